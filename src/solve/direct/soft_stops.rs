//! Soft stops: springs and dampers from where they are met on.
//!
//! A stop C ≥ 0 with compliance α and damping c pushes with
//!
//! ```text
//! F = max(0, −C/α − c Ċ)    where C < 0,     F = 0 where C ≥ 0:
//! ```
//!
//! a row with give as that of any spring, whose multiplier p = h F, N·s or N·m·s, is not below zero. It takes out of the speed what it stores, and
//! gives that back: there is no impact as on a rigid stop.
//!
//! F begins within a substep, with a damper at once at c Ċ. So the substep that meets a stop is undone and taken in parts, the first of which ends
//! where the stop is met: with the distance C, its rate Ċ and C̈ at the substep's start
//!
//! ```text
//! t = 2 C / (−Ċ + √(Ċ² − 2 C̈ C)).
//! ```
//!
//! From there on parts are so short that a body on the spring goes through [`PART_PHASE`] in each, as far as the step may be divided: ω² = w/α, w
//! being what the stop's impulse moves with the rest of its joint held. The first is of first order and a fraction of that, the ones after it
//! grow. The one that leaves the stop is of first order, and where they cannot resolve the spring, every one is: energy can only fall.

use glam::DVec3;

use super::articulation::Articulation;
use super::impact::StopState;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::tuning::soft_stops::{AT_REST, HARD_PHASE, PART_PHASE};

/// Part of [`PART_PHASE`] that is the first whole one; those before it are half of the next each. What a damper does all at once is left to a
/// substep of first order, which is off by its length squared.
const FIRST_PARTS: u32 = 4;

/// Share of a substep that is not worth a part of its own: it moves nothing.
const MIN_SHARE: f64 = 0.02;

/// A soft stop that is met in a substep.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    /// Time from the substep's start (s).
    after: f64,
    /// ω of the bodies on the stop (rad/s).
    frequency: f64,
}

impl StopState {
    /// How long until it is met (s), if it is not yet.
    fn met_after(&self, acceleration: f64) -> f64 {
        if self.distance <= 0.0 {
            return 0.0;
        }
        let root = (self.rate * self.rate - 2.0 * acceleration * self.distance).max(0.0).sqrt();
        let after = 2.0 * self.distance / (root - self.rate);
        if after > 0.0 { after } else { f64::INFINITY }
    }
}

impl Articulation {
    /// The first of the soft stops that this substep of length `h` (s) meets.
    pub(super) fn meets_soft_stop(&mut self, joints: &Pool<Joint, JointId>, h: f64, second_order: bool) -> Option<Meeting> {
        let mut first: Option<Meeting> = None;
        for number in 0..self.entries.len() {
            let is_soft = self.entries[number].traits.has_soft_stops;
            let met = if is_soft { self.newly_pressing(number, joints) } else { 0 };
            if met == 0 {
                continue;
            }
            let bodies = self.links[number].bodies.map(|body| body as usize);
            let (poses, rates) = (bodies.map(|body| self.began.local_poses[body]), bodies.map(|body| self.began.rates[body]));
            let last = f64::from(self.histories[bodies[0]].h.max(self.histories[bodies[1]].h));
            let left = self.began.left;
            let starts = self.stops_at(number, joints, poses, rates, left);
            let before = if second_order {
                let past = bodies.map(|body| self.stance_before(body));
                self.stops_at(number, joints, past, rates, left + last)
            } else {
                Vec::new()
            };
            let joint = &joints[self.entries[number].joint];
            for stop in starts.iter().filter(|stop| met >> stop.id & 1 == 1) {
                // What the host moves is somewhere else by then.
                let after = if joint.drive().is_some() { 0.0 } else { stop.met_after(stop.acceleration(&before, last)) };
                let after = if after < MIN_SHARE * h { 0.0 } else { after.min(h) };
                let frequency = (stop.ease / f64::from(joint.def.limit.compliance)).sqrt();
                let earliest = first.map_or(after, |first| first.after.min(after));
                let highest = first.map_or(frequency, |first| first.frequency.max(frequency));
                first = Some(Meeting { after: earliest, frequency: highest });
            }
        }
        first
    }

    /// Takes a substep of length `h` (s), which has been undone, in parts: up to where a soft stop is met, and on from there.
    pub(super) fn meet_softly(
        &mut self,
        joints: &Pool<Joint, JointId>,
        h: f64,
        meeting: &Meeting,
        depth: u32,
        before: Option<f64>,
    ) -> f64 {
        self.is_meeting = true;
        let whole = (PART_PHASE / meeting.frequency).max(self.finest);
        let (mut error, mut last) = (before, h);
        let mut take = |articulation: &mut Self, part: f64| {
            articulation.scale_impulses((part / last) as f32);
            error = Some(articulation.advance(joints, part, depth, error));
            last = part;
        };
        let rest = h - meeting.after;
        let rest = if rest < MIN_SHARE * h { 0.0 } else { rest };
        if rest < h {
            take(self, h - rest);
            self.part_from_soft_stops();
        }
        if rest > 0.0 {
            // Forces of before say nothing of those from here on.
            self.forget_histories();
            self.continues = None;
            for part in parts(rest, whole.min(rest)) {
                take(self, part);
            }
        }
        self.scale_impulses((h / last) as f32);
        self.is_meeting = false;
        self.met_in_parts = Some([last, whole]);
        error.expect("there are parts")
    }

    /// Has soft stops that were not pressed as the substep began go on as if they were not yet: what rounding makes them push is no meeting.
    fn part_from_soft_stops(&mut self) {
        for (entry, before) in self.entries.iter_mut().zip(&self.began.joints).filter(|(entry, _)| entry.traits.has_soft_stops) {
            let met = entry.impulses.pressing() & !before.pressing;
            let scalars = entry.impulses.scalar.iter_mut().enumerate();
            scalars.filter(|(row, _)| met >> row & 1 == 1).for_each(|(_, impulse)| *impulse = 0.0);
        }
    }

    /// Twice the length of the last substep (s), if that is less than those `most` times as long by which the step would go on: where a stop was
    /// met late in the last step, its parts were short, and what the spring does is to be followed without a break.
    pub(super) fn grows_from(&self, most: f64) -> Option<f64> {
        let next = 2.0 * f64::from(self.histories.iter().map(|history| history.h).fold(0.0, f32::max));
        (self.has_soft_stops && next < most && self.second_order(next).is_some()).then_some(next)
    }

    /// Length up to which the next substep may be as long, after one of length `h` (s) that was too long by a factor of `over`: substeps go on
    /// towards `whole`, none more than twice as long as the one before.
    pub(super) fn next_length(&self, h: f64, over: f64, whole: f64) -> f64 {
        let wanted = if over > 1.0 { h / over } else { 2.0 * h };
        wanted.min(whole).max(self.finest).min(2.0 * h)
    }

    /// Finds the phases ω h (rad) through which the bodies on soft stops have gone in a substep of length `h` (s); returns whether one is more
    /// than a substep resolves.
    pub(super) fn note_spring_phase(&mut self, joints: &Pool<Joint, JointId>, h: f64) -> bool {
        let mut is_hard = false;
        for number in 0..self.entries.len() {
            let entry = &self.entries[number];
            let pressing = if entry.traits.has_soft_stops { entry.impulses.pressing() } else { 0 };
            let pressing = pressing & self.began.joints[number].pressing;
            let joint = &joints[entry.joint];
            if pressing == 0 || joint.stops_of(pressing) == 0 {
                continue;
            }
            let compliance = f64::from(joint.def.limit.compliance);
            let bodies = self.links[number].bodies.map(|body| body as usize);
            let (poses, rates) = (bodies.map(|body| self.local_poses[body]), bodies.map(|body| self.rates[body]));
            let stops = self.stops_at(number, joints, poses, rates, self.left);
            for stop in stops.iter().filter(|stop| pressing >> stop.id & 1 == 1) {
                let frequency = (stop.ease / compliance).sqrt();
                is_hard |= frequency * h > HARD_PHASE;
                if stop.rate.abs() > AT_REST * frequency * stop.distance.abs() {
                    self.spring_phase = self.spring_phase.max(frequency * h);
                }
            }
        }
        is_hard
    }

    /// Whether the bodies leave a soft stop in this substep. One of second order counts the force at its start for a quarter of its length, wherever
    /// in it the force ends, and goes on with a share of the last one: up to ⅛ (ω h)² of the speed more would come back than went in.
    pub(super) fn leaves_soft_stop(&self, joints: &Pool<Joint, JointId>) -> bool {
        self.entries.iter().zip(&self.began.joints).any(|(entry, before)| {
            let left = if entry.traits.has_soft_stops { before.pressing & !entry.impulses.pressing() } else { 0 };
            left != 0 && joints[entry.joint].stops_of(left) != 0
        })
    }

    /// Change of the angular velocity of a body beyond a steady one in this substep of second order, over the square of its length, as a speed at
    /// its radius of gyration (m/s³): what swings on a spring of angles about its own middle shows in no other.
    pub(super) fn angular_jerk(&self, body: usize) -> f64 {
        let (own, history) = (&self.bodies[body], &self.histories[body]);
        let arm = own.gyration();
        if arm == 0.0 || history.spin_turn != 0.0 {
            return 0.0;
        }
        let spin = |poses: &[_], rates: &[_]| -> DVec3 { own.spin(&poses[body], &rates[body]) };
        let now = spin(&self.began.local_poses, &self.began.rates);
        let next = spin(&self.local_poses, &self.rates);
        let ratio = self.order.ratio;
        let surprise = next - now - (now - history.momentum_before.as_dvec3()) * ratio;
        let mass = own.mass().unwrap_or(f64::INFINITY);
        surprise.length() * 2.0 * ratio / ((1.0 + ratio) * self.h * self.h * mass * arm)
    }
}

/// Lengths of the parts of a time, `whole` each but for the first, which come up to that by doubling (s).
fn parts(time: f64, whole: f64) -> Vec<f64> {
    let (mut parts, mut sum) = (Vec::new(), 0.0);
    while sum < time {
        let before_whole = FIRST_PARTS.saturating_sub(1 + parts.len() as u32);
        let part = whole / f64::from(1_u32 << before_whole);
        parts.push(part);
        sum += part;
    }
    parts.iter_mut().for_each(|part| *part *= time / sum);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_grow_by_doubling_and_add_up() {
        for (time, whole) in [(1.0, 0.1), (1.0, 1.0), (0.01, 0.02), (3.0, 0.7)] {
            let parts = parts(time, whole);
            assert!((parts.iter().sum::<f64>() - time).abs() < 1.0e-12 * time, "{parts:?} of {time} s");
            assert!(parts.windows(2).all(|pair| pair[1] <= 2.0 * pair[0] * (1.0 + 1.0e-12)), "{parts:?}");
            assert!(parts.iter().all(|&part| part <= whole), "{parts:?} of at most {whole} s");
        }
    }

    #[test]
    fn a_stop_is_met_when_a_thrown_body_is_there() {
        let stop = StopState { id: 0, distance: 0.5, rate: -1.0, ease: 1.0 };
        assert!((stop.met_after(0.0) - 0.5).abs() < 1.0e-12);
        let after = stop.met_after(-2.0);
        assert!((0.5 - after - after * after).abs() < 1.0e-12, "falls: {after} s");
        assert_eq!(StopState { rate: 1.0, ..stop }.met_after(0.0), f64::INFINITY, "goes away");
        assert_eq!(StopState { distance: -0.1, ..stop }.met_after(0.0), 0.0, "is in it");
    }
}
