//! An articulation that touches what moves: its joints are one block of the sweeps over contacts.
//!
//! A substep begins with the multipliers of the last one, as rows of contacts do, and has one solve of the joints between two sweeps,
//! the last: contacts to, contacts back, joints. Carried multipliers know what the contacts weigh on the joints. A solve in their
//! place, before the contacts have been swept, holds the joints alone: it takes back what contacts carried over have just given, and
//! a heap trembles. Only where nothing is carried, as in the first substep of all, the joints are solved first too. Each solve is exact, so
//! a substep ends with joints that hold; contacts see the bodies with their geometric stiffness, I + G, in place of I. Rows
//! are those of a safe substep.

use super::articulation::{Articulation, Mode};
use super::lasting::Lasting;
use super::quads;
use crate::id::{JointId, Pool};
use crate::joint::Joint;
use crate::solve::joint::rows::{Phase, Rate};
use crate::solve::state::{BodyMotion, BodyVelocity};

impl Articulation {
    /// Begins a substep, `rest` (s) from the end of the step: forces are in the velocities already. Bodies answer with I + G from here
    /// on.
    pub(crate) fn couple(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        h: f64,
        rest: f64,
    ) {
        self.h = h;
        if self.lasting == Lasting::Good {
            return self.go_on(velocities, motions);
        }
        self.load(velocities, motions);
        if self.is_points {
            self.find_spots();
            self.find_ends(false);
        }
        self.find_stiffness(h, Mode::Safe, 1.0);
        quads::respond(&self.quads, &self.stances, &self.stiffness, &mut self.bodies);
        self.answer_contacts(velocities, motions, true);
        self.look_ahead(joints, motions, rest);
        self.ask(joints, Phase::Tangent { h });
    }

    /// Applies the carried multipliers in place of the first of several solves, if there are any.
    pub(crate) fn warm_start(&mut self, velocities: &mut [BodyVelocity], iterations: u32) {
        self.is_warm = iterations > 1 && self.entries.iter().any(|entry| !entry.impulses.is_zero());
        if !self.is_warm {
            return;
        }
        self.take_rates(velocities);
        if self.is_points {
            self.points.warm_start(&self.bodies, &mut self.rates);
        } else {
            self.system.warm_start(&self.bodies, &mut self.rates);
        }
        self.give_rates(velocities);
    }

    fn take_rates(&mut self, velocities: &[BodyVelocity]) {
        for (rate, body) in self.rates.iter_mut().zip(&self.bodies) {
            *rate = Rate::of(&velocities[body.slot as usize]);
        }
    }

    fn give_rates(&self, velocities: &mut [BodyVelocity]) {
        for (rate, body) in self.rates.iter().zip(&self.bodies) {
            if body.is_dynamic() {
                let velocity = &mut velocities[body.slot as usize];
                velocity.linear = rate.linear.as_vec3();
                velocity.angular = rate.angular.as_vec3();
            }
        }
    }

    /// Solves all joints for the velocities of now, unless carried multipliers stand for it.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity]) {
        if std::mem::replace(&mut self.is_warm, false) {
            return;
        }
        self.take_rates(velocities);
        if self.is_points {
            self.points.withdraw(&self.bodies, &mut self.rates);
            self.points.solve(&self.topology, &self.bodies, &mut self.rates);
        } else {
            self.system.sweep(&self.topology, &self.bodies, &mut self.rates);
        }
        self.give_rates(velocities);
    }

    /// Ends a substep, after the bodies have moved, or the step: positions are mended, velocities stay.
    pub(crate) fn settle(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &[BodyVelocity],
        motions: &mut [BodyMotion],
        is_end: bool,
    ) {
        if !is_end && self.find_lasting(motions) {
            return;
        }
        self.load(velocities, motions);
        let lasts = self.lasting == Lasting::Good && self.system.is_factored;
        if self.lasting != Lasting::Never {
            self.lasting = Lasting::No;
        }
        let errors = if lasts { self.mend_with_lasting_rows(joints) } else { self.find_errors(joints) };
        self.project(joints, errors);
        for (body, stance) in self.bodies.iter().zip(&self.stances) {
            if body.is_dynamic() {
                let motion = &mut motions[body.slot as usize];
                let turn = stance.1 * motion.rotation.as_dquat().normalize().conjugate();
                motion.displacement = stance.0.as_vec3();
                motion.turn += (2.0 * glam::DVec3::new(turn.x, turn.y, turn.z) * turn.w.signum()).as_vec3();
                motion.rotation = stance.1.as_quat();
            }
        }
    }
}
