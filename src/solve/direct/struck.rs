//! Velocities that the host has set, or changed by an impulse, and joints do not allow.
//!
//! A blow acts over no time, and joints answer to it over none: J v⁺ = 0 of what joints hold, v⁺ = v + M⁻¹ Jᵀ p with the bodies' own masses. A
//! substep that starts from v instead looks for the end of a way on which joints turn bodies far: a rod on a hinge that is struck
//! turns four times as fast without it, and was told two thirds of its speed from 0.05 rad in a substep on.

use glam::DMat3;

use super::articulation::{Articulation, TOLERANCE};
use super::articulation_state::Mode;
use super::impact::LONG;
use super::wide_integrator;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::linalg::narrowing;
use crate::solve::joint::rows::Phase;
use crate::step_history::History;

impl Articulation {
    /// Lets the next substep go on from the last one as if that had been taken at the velocities which an impulse to all bodies as one has made of
    /// those at its end: with each faster by what it is faster now nothing else is different, and the two-step method stays of second order. A first
    /// substep in each step would lose energy.
    pub(super) fn kick_histories(&mut self) {
        if !std::mem::take(&mut self.forces.is_kicked) {
            return;
        }
        for ((body, history), (rate, stance)) in
            self.bodies.iter().zip(&mut self.histories).zip(self.rates.iter().zip(&self.local_poses))
        {
            if !body.is_dynamic() || history.h <= 0.0 {
                continue;
            }
            let gained = [rate.linear - history.linear.as_dvec3(), rate.angular - history.angular.as_dvec3()];
            history.linear_before += gained[0].as_vec3();
            history.momentum_before += (body.inertia_at(stance) * gained[1]).as_vec3();
            history.displacement += (gained[0] * f64::from(history.h)).as_vec3();
            if history.spin_turn == 0.0 {
                history.turn += (gained[1] * f64::from(history.h)).as_vec3();
            }
            (history.linear, history.angular) = (narrowing::speed(rate.linear), narrowing::speed(rate.angular));
        }
    }

    /// Takes out of velocities that the host has changed what joints do not allow, where it would open them within a substep.
    pub(super) fn stop_at_joints(&mut self, joints: &Pool<Joint, JointId>) {
        if self.mode == Mode::Smooth && self.histories.iter().any(History::is_struck) && self.would_open() {
            // How many substeps were enough says nothing of what is thrown round now.
            self.histories.iter_mut().for_each(|history| history.substeps = 0);
            self.stiffness.clear();
            self.stiffness.resize(self.bodies.len(), DMat3::ZERO);
            for shares in [&mut self.implicit, &mut self.tensions] {
                shares.clear();
                shares.resize(self.links.len(), 0.0);
            }
            self.weigh(0.0);
            if self.is_points { self.stop_at_points() } else { self.end_approach(joints) }
        }
    }

    /// Whether joints would open in a substep by more than a smooth one may leave, at the velocities of now.
    fn would_open(&self) -> bool {
        let most = TOLERANCE * self.size / self.world_substep;
        self.links.iter().zip(&self.entries).any(|(link, entry)| {
            let rates = link.bodies.map(|body| &self.rates[body as usize]);
            let levers = [0, 1].map(|side| self.local_poses[link.bodies[side] as usize].1 * entry.local_lever[side]);
            let [a, b] = [0, 1].map(|side| rates[side].linear + rates[side].angular.cross(levers[side]));
            let turning = if link.is_plain { 0.0 } else { (rates[1].angular - rates[0].angular).length() * self.size };
            (b - a).length().max(turning) > most
        })
    }

    /// The same where all joints hold points and nothing else.
    fn stop_at_points(&mut self) {
        self.find_spots();
        wide_integrator::respond(&self.bodies4, 0.0, &self.local_poses, &self.stiffness, &mut self.bodies);
        self.ask_points(Phase::Tangent { h: LONG });
        self.points.drop_impulses();
        self.points.solve(&self.topology, &self.bodies, &mut self.rates);
        for (entry, joint) in self.entries.iter_mut().zip(&self.points.joints) {
            entry.linear_sum += narrowing::impulse(joint.impulse);
        }
    }
}
