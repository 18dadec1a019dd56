//! One substep of an articulation: tried smoothly, undone and taken safely where that leaves too much, in halves where it must be.

use super::articulation::{Articulation, SOLVES_PER_HALVING, TOLERANCE};
use super::articulation_state::{Mode, SavedJoint};
use super::buckle;
use super::contacts::ArticulationContact;
use super::multistep::SecondOrder;
use super::rotors;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;

/// How often a substep may be halved.
const MAX_HALVINGS: u32 = 4;

/// Parts that a substep may be taken in whose rotors find no end: from the one before to a part, second order goes on.
const MOST_PARTS: f64 = 4.0;

/// A halved substep must end with this share of the error that it began with, where that is beyond the tolerance.
const MUST_FALL: f64 = 0.5;

impl Articulation {
    /// One substep, in halves where it must be; takes the worst error where it is known, and returns it (m).
    pub(super) fn advance(&mut self, joints: &Pool<Joint, JointId>, h: f64, depth: u32, before: Option<f64>) -> f64 {
        self.begin();
        if self.mode == Mode::Smooth
            && let Some(error) = self.advance_smoothly(joints, h, depth, before)
        {
            return error;
        }
        self.advance_safely(joints, h, depth, before)
    }

    /// A substep whose rows hold at its end; none where it has been undone and has to be taken safely.
    fn advance_smoothly(&mut self, joints: &Pool<Joint, JointId>, h: f64, depth: u32, before: Option<f64>) -> Option<f64> {
        let order = match self.continues {
            Some(last) => SecondOrder::new(h, last),
            None => self.second_order(h),
        };
        let mut second_order = order.is_some();
        self.order = order.unwrap_or(SecondOrder::EULER);
        if !second_order && self.entries.iter().all(|entry| entry.impulses.is_zero()) {
            self.guess_impulses(joints, h);
        }
        let energy = self.energy_to_keep();
        self.rotors_diverge = false;
        let mut momentum = self.substep(joints, h, if second_order { Mode::SecondOrder } else { Mode::Smooth });
        if self.rotors_diverge && self.pay(SOLVES_PER_HALVING) {
            self.restore();
            return Some(self.advance_in_parts(joints, h, self.parts_for_rotors(), depth, before));
        }
        if self.has_soft_stops
            && !self.is_meeting
            && let Some(meeting) = self.meets_soft_stop(joints, h, second_order)
        {
            self.restore();
            return Some(self.meet_softly(joints, h, &meeting, depth, before));
        }
        if second_order & self.lets_go_of_motor() || second_order && self.has_soft_stops && self.leaves_soft_stop(joints) {
            self.restore();
            (self.order, second_order) = (SecondOrder::EULER, false);
            momentum = self.substep(joints, h, Mode::Smooth);
        }
        let mut meets_stop = self.meets_stop(joints);
        let knows_past = second_order;
        if meets_stop && second_order {
            // The rates before a blow say nothing of those after it: extrapolated across it, they would throw the bodies back.
            self.restore();
            // What moved smoothly took few substeps, too long for one of first order.
            let parts = (h / self.world_substep).round() as u32;
            if parts > 1 {
                self.forget_histories();
                self.continues = None;
                return Some(self.advance_in_parts(joints, h, parts, depth, before));
            }
            (self.order, second_order) = (SecondOrder::EULER, false);
            momentum = self.substep(joints, h, Mode::Smooth);
            meets_stop = self.meets_stop(joints);
        }
        self.follow_angles(joints, h);
        let errors = self.find_errors(joints);
        if errors.worst <= (TOLERANCE * self.size).max(before.unwrap_or_default())
            && !self.touches.iter().any(ArticulationContact::presses)
            && !energy.is_some_and(|energy| self.has_gained(energy))
        {
            let approaches = if meets_stop && self.rebounds { self.approaches_at_start(joints, knows_past) } else { Vec::new() };
            let error = self.project(joints, errors);
            self.keep_momentum(momentum);
            self.note_smooth(h, second_order);
            if meets_stop {
                self.resolve_impact(joints, &approaches);
            }
            let is_jolted = std::mem::take(&mut self.is_jolted);
            if is_jolted || self.is_under_way || meets_stop || (self.has_soft_stops && self.note_spring_phase(joints, h)) {
                // Neither a blow is what the bodies go on with, be it of a stop or of what holds them, nor a motor that may brake in the next substep, nor a spring that no substep
                // resolves.
                self.forget_histories();
                self.continues = None;
            }
            return Some(error);
        }
        self.mode = Mode::Safe;
        self.order = SecondOrder::EULER;
        self.forget_histories();
        self.continues = None;
        self.restore();
        // What moved smoothly took few substeps, and what it has met has had no say in how many.
        let parts = (h / self.world_substep).round() as u32;
        if parts > 1 {
            return Some(self.advance_in_parts(joints, h, parts, depth, before));
        }
        None
    }

    /// A substep of first order, in which kinetic energy cannot grow, in halves where it leaves too much.
    fn advance_safely(&mut self, joints: &Pool<Joint, JointId>, h: f64, depth: u32, before: Option<f64>) -> f64 {
        let before = before.unwrap_or_else(|| self.find_errors(joints).worst);
        let mut momentum = self.substep(joints, h, Mode::Safe);
        if self.is_jammed(h) && self.pay(buckle::SOLVES) {
            self.restore();
            self.bend_ahead(joints, h);
            momentum = self.substep(joints, h, Mode::Safe);
        }
        self.follow_angles(joints, h);
        self.note_rebounds();
        // What a contact presses on is not free to follow a blow by joints alone.
        let meets_stop = self.meets_stop(joints) && !self.touches.iter().any(ArticulationContact::presses);
        let settled = self.system.settled || self.touches.is_empty();
        let errors = self.find_errors(joints);
        let error = self.project(joints, errors);
        self.keep_momentum(momentum);
        let good = error <= (TOLERANCE * self.size).max(MUST_FALL * before);
        let gives_up = !settled && self.passes_left == 0;
        if good || gives_up || depth >= MAX_HALVINGS || !self.pay(SOLVES_PER_HALVING) {
            if !error.is_finite() {
                self.restore();
                return before;
            }
            self.outcome.safe += 1;
            self.outcome.unsettled |= !settled;
            // What is left of the approach, a turn by a radian in this substep, the next one would be thrown back by.
            if meets_stop {
                self.end_approach(joints);
            }
            return error;
        }
        self.outcome.halvings += 1;
        self.restore();
        self.advance_in_parts(joints, h, 2, depth + 1, Some(before))
    }

    /// Finds multipliers for a first substep that carries none: those of one taken on trial.
    ///
    /// Without them bodies have no geometric stiffness, and the substep leaves what is pulled hard trembling.
    fn guess_impulses(&mut self, joints: &Pool<Joint, JointId>, h: f64) {
        self.substep(joints, h, Mode::Smooth);
        for (entry, saved) in self.entries.iter().zip(&mut self.began.joints) {
            saved.impulses = entry.impulses;
        }
        self.restore();
    }

    /// Parts in which the passes for rotors come to an end: what a pass leaves of their error goes with the length of the substep.
    fn parts_for_rotors(&self) -> u32 {
        (self.rotor_share / rotors::MUST_FALL).ceil().clamp(2.0, MOST_PARTS) as u32
    }

    /// As [`advance`](Self::advance), in parts of equal length.
    fn advance_in_parts(&mut self, joints: &Pool<Joint, JointId>, h: f64, parts: u32, depth: u32, before: Option<f64>) -> f64 {
        self.scale_impulses(1.0 / parts as f32);
        let mut error = before;
        for _ in 0..parts {
            error = Some(self.advance(joints, h / f64::from(parts), depth, error));
        }
        self.scale_impulses(parts as f32);
        error.expect("there are parts")
    }

    /// Notes the state at the start of a substep.
    fn begin(&mut self) {
        let saved = &mut self.began;
        saved.rates.clone_from(&self.rates);
        saved.local_poses.clone_from(&self.local_poses);
        saved.left = self.left;
        saved.joints.clear();
        saved.joints.extend(self.entries.iter().map(|entry| SavedJoint {
            impulses: entry.impulses,
            angles: entry.angles,
            sums: [entry.linear_sum, entry.angular_sum],
            acted: entry.acted,
            rebounds: entry.rebounds,
            pressed: entry.pressed,
            motors: entry.motors.sums,
            pressing: entry.impulses.pressing(),
        }));
        saved.touches.clone_from(&self.touches);
    }

    /// Undoes a substep.
    fn restore(&mut self) {
        let saved = &self.began;
        self.rates.clone_from(&saved.rates);
        self.local_poses.clone_from(&saved.local_poses);
        self.left = saved.left;
        self.points.is_known = false;
        for (entry, saved) in self.entries.iter_mut().zip(&saved.joints) {
            entry.impulses = saved.impulses;
            entry.angles = saved.angles;
            [entry.linear_sum, entry.angular_sum] = saved.sums;
            entry.acted = saved.acted;
            entry.rebounds = saved.rebounds;
            entry.pressed = saved.pressed;
            entry.motors.sums = saved.motors;
        }
        self.touches.clone_from(&saved.touches);
    }
}
