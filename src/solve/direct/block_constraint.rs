//! An articulation that touches moving bodies: all its joints act as one block constraint in the sweeps over contacts.
//!
//! A substep begins with the multipliers of the last one, as rows of contacts do, and has one solve of the joints between two sweeps,
//! the last: contacts to, contacts back, joints. Carried multipliers know what the contacts weigh on the joints. A solve in their
//! place, before the contacts have been swept, holds the joints alone: it takes back what contacts carried over have just given, and
//! a heap trembles. Only where nothing is carried, as in the first substep of all, or where a motor or a stop has given a blow that is
//! over, the joints are solved first too. Each solve is exact, so
//! a substep ends with joints that hold; contacts see the bodies with their geometric stiffness, I + G, in place of I. Rows
//! are those of a safe substep.

use glam::DVec3;

use super::articulation::Articulation;
use super::articulation_state::Mode;
use super::articulation_state::ReusedFactor;
use super::body::DirectBody;
use super::factor_reuse::{MENDINGS, Settling};
use super::project::{Errors, greatest};
use super::row::Origin;
use super::topology::SystemNode;
use super::wide_integrator;
use crate::id::{JointId, Pool};
use crate::joint_record::{Joint, JointImpulses};
use crate::linalg::narrowing;
use crate::solve::disjoint::Slots;
use crate::solve::joint::JointEntry;
use crate::solve::joint::rows::{Phase, Rate};
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::tuning::mending::MAX_TURNED;

/// Push of a body that joints yield to, as a share of the least error that positions are mended for.
const PUSHED: f64 = 0.1;

/// Share of the rate that carried multipliers give a row by which they may take it beyond what it asks for. A steady load takes it
/// nowhere, a blow that is over all the way, or half of it where contacts have borne the other half. A flipper threw a ball at 15.8 m/s
/// in place of 11.
const MAX_OVERSHOOT: f64 = 0.25;

impl Articulation {
    /// Writes the effective inertia of the first substep, of length `h` (s), to the bodies: geometric stiffness included, as rows of contacts
    /// must see it from the start.
    pub(crate) fn get_ready(
        &mut self,
        velocities: &mut (impl Slots<BodyVelocity> + ?Sized),
        motions: &(impl Slots<BodyMotion> + ?Sized),
        h: f64,
    ) {
        self.h = h;
        self.turned = 0.0;
        self.find_answer(velocities, motions);
        for body in self.bodies.iter().filter(|body| body.is_dynamic()) {
            velocities.get_mut(body.slot).inverse_inertia = body.answer();
        }
        self.has_answer = true;
    }

    fn find_answer(&mut self, velocities: &(impl Slots<BodyVelocity> + ?Sized), motions: &(impl Slots<BodyMotion> + ?Sized)) {
        self.load(velocities, motions);
        if self.is_points {
            self.find_spots();
            self.find_ends(false);
        }
        self.find_stiffness(self.h, Mode::Safe, 1.0);
        // Sweeps over contacts know of no damping.
        wide_integrator::respond(&self.bodies4, 0.0, &self.local_poses, &self.stiffness, &mut self.bodies);
    }

    /// Begins a substep, `rest` (s) from the end of the step: forces are in the velocities already. Bodies answer with I + G from here
    /// on.
    pub(crate) fn couple(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut (impl Slots<BodyVelocity> + ?Sized),
        motions: &mut (impl Slots<BodyMotion> + ?Sized),
        h: f64,
        rest: f64,
    ) {
        (self.h, self.rest, self.left) = (h, rest, rest);
        if self.lasting == ReusedFactor::Good {
            return self.go_on(velocities, motions);
        }
        let has_answer = std::mem::replace(&mut self.has_answer, false);
        if has_answer {
            self.take_rates(velocities);
        } else {
            self.find_answer(velocities, motions);
            // Positions that wait to be mended have not been looked at.
            self.follow_angles(joints, 0.0);
        }
        self.answer_contacts(velocities, motions, !has_answer);
        self.look_ahead(joints, motions, rest);
        self.ask(joints, Phase::Tangent { h });
        self.list_approaches(h);
    }

    /// Applies the carried multipliers in place of the first of several solves, if there are any.
    pub(crate) fn warm_start(&mut self, velocities: &mut (impl Slots<BodyVelocity> + ?Sized), iterations: u32) {
        if !self.may_start_warm(iterations) {
            return;
        }
        self.take_rates(velocities);
        if self.is_points {
            self.points.warm_start(&self.bodies, &mut self.rates);
        } else {
            self.system.warm_start(&self.bodies, &mut self.rates);
            self.is_warm = !self.overshoots(velocities);
        }
        self.give_rates(velocities);
    }

    /// Whether carried multipliers, which are in the rates and not yet in the velocities, take a motor or a stop too far: they were a
    /// blow, not a load. Contacts would hand twice the speed of the blow on, and what they throw is gone before the joints are solved.
    pub(super) fn overshoots(&self, velocities: &(impl Slots<BodyVelocity> + ?Sized)) -> bool {
        let Self { system, rates, bodies, .. } = self;
        system.nodes.iter().any(|node| {
            let rows = &system.rows[node.first as usize..node.last as usize];
            rows.iter().filter(|row| matches!(row.origin, Origin::Scalar(_)) && row.impulse != 0.0).any(|row| {
                let now = row.rate(&node.bodies.map(|body| rates[body as usize]));
                let before = row.rate(&node.bodies.map(|body| Rate::of(velocities.get(bodies[body as usize].slot))));
                let (beyond, carried) = (now + row.bias + row.gamma * row.impulse, now - before);
                beyond * row.impulse > 0.0 && beyond * carried > MAX_OVERSHOOT * carried * carried
            })
        })
    }

    /// Whether carried multipliers are applied in place of the first of several solves.
    pub(super) fn may_start_warm(&mut self, iterations: u32) -> bool {
        self.is_warm = iterations > 1 && self.is_pressed();
        self.is_warm
    }

    /// Whether any joint has a carried multiplier.
    fn is_pressed(&self) -> bool {
        if self.system.sums.is_empty() {
            self.entries.iter().any(|entry| !entry.impulses.is_zero())
        } else {
            self.system.is_pressed()
        }
    }

    pub(super) fn take_rates(&mut self, velocities: &(impl Slots<BodyVelocity> + ?Sized)) {
        for (rate, body) in self.rates.iter_mut().zip(&self.bodies) {
            *rate = Rate::of(velocities.get(body.slot));
        }
    }

    pub(super) fn give_rates(&self, velocities: &mut (impl Slots<BodyVelocity> + ?Sized)) {
        for (rate, body) in self.rates.iter().zip(&self.bodies) {
            if body.is_dynamic() {
                let velocity = velocities.get_mut(body.slot);
                velocity.linear = narrowing::speed(rate.linear);
                velocity.angular = narrowing::speed(rate.angular);
            }
        }
    }

    /// Solves all joints for the velocities of now, unless carried multipliers stand for it.
    pub(crate) fn sweep(&mut self, velocities: &mut (impl Slots<BodyVelocity> + ?Sized)) {
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

    /// Whether its bodies have these slots.
    pub(crate) fn is_on(&self, slots: &[bool]) -> bool {
        self.moved_slots().next().is_some_and(|slot| slots[slot as usize])
    }

    /// Forgets all multipliers, as if the substep had begun without any: what they have pushed is out of the velocities.
    pub(crate) fn drop_impulses(&mut self) {
        self.is_warm = false;
        self.entries.iter_mut().for_each(|entry| entry.impulses = JointImpulses::ZERO);
        if self.is_points {
            self.points.drop_impulses();
        } else {
            self.system.drop_impulses();
        }
    }

    /// What motors, springs and what the host moves of joints have done in the substep (J).
    pub(crate) fn work(&self) -> f64 {
        if self.is_points {
            return 0.0;
        }
        let Self { entries, system, rates, .. } = self;
        let work = |(entry, node): (&JointEntry, &SystemNode)| {
            let is_motor = |origin: Origin| matches!(origin, Origin::Scalar(id) if entry.motors.rows.axis(id).is_some() || entry.rebounds.of(id) > 0.0);
            let pair = node.bodies.map(|body| rates[body as usize]);
            let rows = system.rows[node.first as usize..node.last as usize].iter();
            rows.filter(|row| entry.traits.is_driven || row.gamma > 0.0 || is_motor(row.origin))
                .map(|row| row.impulse * row.rate(&pair))
                .sum::<f64>()
        };
        let gives = |(entry, _): &(&JointEntry, &SystemNode)| entry.traits.has_motor || !entry.traits.gives_by_motors_alone;
        entries.iter().zip(&system.nodes).filter(gives).map(work).sum()
    }

    /// Keeps the multipliers of a substep. Rows that may last keep them themselves, and what they add up to.
    fn keep_swept_impulses(&mut self) {
        self.outcome.safe += 1;
        self.note_rebounds();
        if self.is_points {
            return self.keep_impulses(1.0);
        }
        self.system.add_up();
        if self.lasting != ReusedFactor::Built {
            self.hand_back_impulses();
        }
    }

    /// Hands the multipliers back to the joints, and adds all since that was last done to their loads.
    fn hand_back_impulses(&mut self) {
        let Self { entries, system, links, local_poses, .. } = self;
        if system.sums.is_empty() {
            return;
        }
        for ((entry, node), link) in entries.iter_mut().zip(&system.nodes).zip(&*links) {
            let lever = local_poses[link.bodies[1] as usize].1 * entry.local_lever[1];
            let (mut point, mut angular) = (DVec3::ZERO, DVec3::ZERO);
            let (mut last, mut all) = ([DVec3::ZERO; 2], [DVec3::ZERO; 2]);
            let rows = node.first as usize..node.last as usize;
            for (row, &sum) in system.rows[rows.clone()].iter().zip(&system.sums[rows]) {
                let (force, moment) = match row.origin {
                    Origin::Point => {
                        point += row.linear[1] * row.impulse;
                        (row.linear[1], DVec3::ZERO)
                    }
                    Origin::Direction => {
                        angular += row.angular[1] * row.impulse;
                        (DVec3::ZERO, row.angular[1])
                    }
                    Origin::Scalar(id) => {
                        entry.impulses.scalar[id as usize] = row.impulse as f32;
                        entry.pressed |= u32::from(sum > 0.0) << id;
                        if let Some(axis) = entry.motors.rows.axis(id) {
                            entry.motors.sums[axis] += sum as f32;
                        }
                        (row.linear[1], row.angular[1] - lever.cross(row.linear[1]))
                    }
                    Origin::Across | Origin::Contact => continue,
                };
                last = [last[0] + force * row.impulse, last[1] + moment * row.impulse];
                all = [all[0] + force * sum, all[1] + moment * sum];
            }
            entry.impulses.point = narrowing::impulse(point);
            entry.impulses.angular = narrowing::impulse(angular);
            entry.acted = last.map(narrowing::impulse);
            entry.linear_sum += narrowing::impulse(all[0]);
            entry.angular_sum += narrowing::impulse(all[1]);
        }
        system.sums.clear();
    }

    /// Whether the rows of the last substep are there, to be solved for something else. Built are empty where rows of this kind cannot last,
    /// or where others have taken their place.
    pub(super) fn has_lasting_rows(&self) -> bool {
        !self.built.is_empty() && (self.system.is_factored || self.system.is_abreast)
    }

    /// Has displacements of the bodies leave the joints as they are, in the metric of their masses; the multipliers of the substep are
    /// handed back before.
    pub(crate) fn yield_to(&mut self, pushes: &mut (impl Slots<BodyVelocity> + ?Sized)) {
        if self.begin_yielding(pushes) {
            self.changes.clear();
            self.changes.extend(self.bodies.iter().map(|body| Rate::of(pushes.get(body.slot))));
            self.solve_lasting_rows();
            self.end_yielding(pushes);
        }
    }

    /// Prepares the rows of the last substep to take out of the pushes of position recovery what joints would undo. Returns whether they
    /// are needed: whether those rows still last and a body is pushed far enough.
    pub(super) fn begin_yielding(&mut self, pushes: &(impl Slots<BodyVelocity> + ?Sized)) -> bool {
        let least = PUSHED * self.least_to_mend();
        let is_pushed = |body: &DirectBody| greatest(pushes.get(body.slot).linear.as_dvec3()) > least;
        let yields = self.has_lasting_rows() && self.bodies.iter().any(is_pushed);
        if yields {
            self.hand_back_impulses();
            self.system.rows.iter_mut().for_each(|row| row.bias = 0.0);
        }
        yields
    }

    /// Replaces the pushes by what the joints let through.
    pub(super) fn end_yielding(&self, pushes: &mut (impl Slots<BodyVelocity> + ?Sized)) {
        for (change, body) in self.changes.iter().zip(&self.bodies).filter(|(_, body)| body.is_dynamic()) {
            let push = pushes.get_mut(body.slot);
            (push.linear, push.angular) = (narrowing::way(change.linear), narrowing::way(change.angular));
        }
    }

    /// Ends a substep, after the bodies have moved, whose multipliers are kept, or the step: positions are mended, velocities stay.
    pub(crate) fn settle(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &(impl Slots<BodyVelocity> + ?Sized),
        motions: &mut (impl Slots<BodyMotion> + ?Sized),
        is_end: bool,
    ) {
        let Some(mut settling) = self.begin_settling(joints, velocities, motions, is_end) else { return };
        for round in 1..=MENDINGS {
            if settling.mends {
                self.solve_lasting();
                self.mend_with_lasting_rows(joints, &mut settling, round < MENDINGS);
            }
        }
        self.end_settling(joints, motions, settling.errors);
    }

    /// Begins position correction: keeps the multipliers of the substep and finds the position errors. Returns none where the rows last for the
    /// next substep, so that errors are corrected at the end of the step.
    pub(super) fn begin_settling(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &(impl Slots<BodyVelocity> + ?Sized),
        motions: &(impl Slots<BodyMotion> + ?Sized),
        is_end: bool,
    ) -> Option<Settling> {
        if !is_end {
            self.keep_swept_impulses();
            let waits = self.may_wait();
            if self.find_lasting(motions) {
                return None;
            }
            if waits {
                self.hand_back_impulses();
                self.build_anew();
                return None;
            }
        }
        self.left = if is_end { 0.0 } else { self.rest - self.h };
        self.hand_back_impulses();
        self.load(velocities, motions);
        self.follow_angles(joints, 0.0);
        let has_rows = self.has_lasting_rows();
        self.build_anew();
        Some(match has_rows {
            true => self.ask_lasting_rows(joints, self.least_to_mend()),
            false => Settling { errors: self.find_errors(joints), mends: false },
        })
    }

    /// Has the next substep build its rows.
    fn build_anew(&mut self) {
        if self.lasting != ReusedFactor::Never {
            self.lasting = ReusedFactor::No;
        }
    }

    /// Whether errors of positions may wait for the end of the step: rows leave gaps of half the square of a turn, of its lever. Those of a loop
    /// do not: its rows may contradict one another where it is not closed, which doubled the error of a ring's momentum.
    fn may_wait(&mut self) -> bool {
        if self.topology.loops > 0 {
            return false;
        }
        let most = self.rates.iter().map(|rate| rate.angular.length_squared()).fold(0.0, f64::max);
        self.turned += most * self.h * self.h;
        let waits = self.turned <= MAX_TURNED;
        if !waits {
            self.turned = 0.0;
        }
        waits
    }

    /// Takes out what lasting rows have left, and moves the bodies.
    pub(super) fn end_settling(
        &mut self,
        joints: &Pool<Joint, JointId>,
        motions: &mut (impl Slots<BodyMotion> + ?Sized),
        errors: Errors,
    ) {
        self.project(joints, errors);
        for (body, stance) in self.bodies.iter().zip(&self.local_poses) {
            if body.is_dynamic() {
                let motion = motions.get_mut(body.slot);
                let turn = stance.1 * motion.rotation.as_dquat().normalize().conjugate();
                motion.displacement = narrowing::way(stance.0);
                motion.turn += narrowing::way(2.0 * DVec3::new(turn.x, turn.y, turn.z) * turn.w.signum());
                motion.rotation = narrowing::rotation(stance.1);
            }
        }
    }
}
