//! How the velocity of a body that the host moves goes on within a step.
//!
//! A host moves a kinematic body along a smooth track and says once a step where it is, or how fast. What it gives is the mean velocity
//! V of each step. A velocity that stays V for the whole step jumps as the step begins, by all that the track has gained since the last
//! one, and friction that would carry a load along the track slips in the substep of the jump. So the velocity goes on straight within
//! the step, with the mean V and a slope: the body arrives where it was told to, and its velocity hardly jumps.
//!
//! With dt between the middles of steps, fₙ = (Vₙ − Vₙ₋₁)/dt is the acceleration at the start of step n. In its middle a smooth track has
//!
//! ```text
//! s = fₙ + ½ (fₙ − fₙ₋₁),
//! ```
//!
//! and velocities jump between steps by a second difference of f, not by f. Not all tracks are smooth: a body starts at once, is put
//! elsewhere in one step, or stops. There the slope is bounded, as that of a limited reconstruction of cell averages is. With
//! q = fₙ₋₁/fₙ, what was there over what is,
//!
//! ```text
//! s = fₙ · max(0, min(2 q, (3 − q)/2, 4 − 2 q)).
//! ```
//!
//! From 2 q follows that a motion that begins at once has no slope in its first step, nor where it ends or turns back in one: it moves at V,
//! neither lags nor runs ahead. An acceleration that begins with a step has q = ½ in its second and is exact from there; one that ends with
//! a step has q = 2 and leaves no slope behind.
//!
//! **Jumps.** What is left of a change between steps once both have their slopes is a jump. That of a smooth track is of second order in dt,
//! that of a body which starts, stops or turns back at once is all of the change: a blow to what hangs on it, which must not be
//! taken for an acceleration that goes on.

use glam::Vec3;

use crate::pose::Pose;

/// Share of the change of velocity between two steps that a jump is at least.
/// Why: it is ½ in the second step of an acceleration that begins with a step, and all where a velocity jumps.
const UNEXPLAINED: f32 = 0.75;

/// Share of the greater of the two velocities that a jump is at least.
/// Why: a second-order substep throws a taut chain by ⅔ of a jump. Of a smaller jump that is no more than the error of a first-order
/// substep. A host that rounds its poses makes far smaller jumps. Test: tests/moved_anchors.rs
const NOTICEABLE_SHARE: f32 = 0.1;

/// Jump that is rounding of poses (m/s, rad/s).
const ROUNDING: f32 = 1.0e-4;

/// What is known of a body that the host moves.
#[derive(Debug, Clone, Default)]
pub(crate) struct KinematicPath {
    /// Pose that it shall have at the end of the next step.
    pub(crate) target: Option<Pose>,
    /// Number of the last step in which it was moved, and the length of that (s).
    pub(crate) step: u64,
    pub(crate) dt: f32,
    /// Mean linear and angular velocity in that step (m/s, rad/s).
    pub(crate) velocity: [Vec3; 2],
    /// Linear and angular acceleration at its start (m/s², rad/s²).
    pub(crate) change: [Vec3; 2],
    /// The same within it.
    pub(crate) slope: [Vec3; 2],
}

impl KinematicPath {
    /// Begins step number `step` of length `dt` (s), in which the body moves at this mean velocity (linear and angular); finds the slope
    /// within it. Returns whether the velocity jumps as the step begins.
    pub(crate) fn begin_step(&mut self, step: u64, dt: f32, velocity: [Vec3; 2]) -> bool {
        if self.step == step {
            // A body may be listed twice.
            return false;
        }
        if self.step + 1 != step {
            // It has stood in the steps between.
            *self = Self { target: self.target, dt, ..Self::default() };
        }
        let between = 0.5 * (self.dt + dt);
        let change = [0, 1].map(|part| (velocity[part] - self.velocity[part]) / between);
        let slope = [0, 1].map(|part| limited(change[part], self.change[part]));
        let before = std::mem::replace(self, Self { target: self.target, step, dt, velocity, change, slope });
        (0..2).any(|part| {
            let [from, to] = [before.velocity[part], velocity[part]];
            let jump = (to - from - 0.5 * (slope[part] * dt + before.slope[part] * before.dt)).length();
            let is_large = jump > (NOTICEABLE_SHARE * from.length().max(to.length())).max(ROUNDING);
            is_large && jump > UNEXPLAINED * (to - from).length()
        })
    }

    /// Whether its velocity changes within the step.
    pub(crate) fn bends(&self) -> bool {
        self.slope != [Vec3::ZERO; 2]
    }

    /// Whether a snapshot can have it.
    pub(crate) fn is_finite(&self) -> bool {
        let parts = [self.velocity, self.change, self.slope];
        self.target.is_none_or(|target| target.checked("target", "target").is_ok())
            && self.dt.is_finite()
            && self.dt >= 0.0
            && parts.iter().flatten().all(|part| part.is_finite())
    }
}

/// The acceleration within a step at whose start it is `now`, and was `before` a step ago.
fn limited(now: Vec3, before: Vec3) -> Vec3 {
    let square = now.length_squared();
    if square == 0.0 {
        return Vec3::ZERO;
    }
    let q = now.dot(before) / square;
    let smooth = 0.5 * (3.0 - q);
    let bound = (2.0 * q).min(4.0 - 2.0 * q);
    // Squares that overflow give none.
    if bound.is_nan() || bound <= 0.0 {
        return Vec3::ZERO;
    }
    (now * 1.5 - before * 0.5) * (bound / smooth).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f32 = 1.0 / 64.0;

    /// Velocities at the starts and ends of steps of a track that is sampled at their ends.
    fn ends(track: impl Fn(f32) -> f32) -> Vec<[f32; 2]> {
        let mut path = KinematicPath::default();
        (1..40)
            .map(|step| {
                let mean = (track(step as f32 * DT) - track((step - 1) as f32 * DT)) / DT;
                path.begin_step(step as u64, DT, [Vec3::X * mean, Vec3::ZERO]);
                [-0.5, 0.5].map(|half| mean + path.slope[0].x * half * DT)
            })
            .collect()
    }

    #[test]
    fn a_motion_that_begins_or_ends_at_once_is_not_bent() {
        let tracks: [fn(f32) -> f32; 3] =
            [|t| if t > 10.5 * DT { 1.0 } else { 0.0 }, |t| (t - 10.0 * DT).clamp(0.0, 12.0 * DT), |t| (t - 20.0 * DT).abs()];
        for (number, track) in tracks.into_iter().enumerate() {
            for (step, [start, end]) in ends(track).into_iter().enumerate() {
                assert_eq!(start, end, "track {number}, step {step}");
            }
        }
    }

    #[test]
    fn an_acceleration_that_begins_and_ends_with_a_step_is_exact_from_its_second_one() {
        let track = |t: f32| {
            let (up, on) = ((t - 8.0 * DT).clamp(0.0, 16.0 * DT), (t - 24.0 * DT).max(0.0));
            0.5 * up * up + 16.0 * DT * on
        };
        let velocity = |t: f32| (t - 8.0 * DT).clamp(0.0, 16.0 * DT);
        for (step, found) in ends(track).into_iter().enumerate().filter(|&(step, _)| step != 8) {
            let [start, end] = [0, 1].map(|after| velocity((step + after) as f32 * DT));
            assert!((found[0] - start).abs() < 1.0e-5 && (found[1] - end).abs() < 1.0e-5, "step {step}: {found:?}");
        }
    }

    #[test]
    fn what_starts_stops_or_turns_back_at_once_jumps_and_a_smooth_track_does_not() {
        let jumps = |track: &dyn Fn(f32) -> f32| {
            let mut path = KinematicPath::default();
            let jumps = (1..60).filter(|&step| {
                let mean = (track(step as f32 * DT) - track((step - 1) as f32 * DT)) / DT;
                path.begin_step(step as u64, DT, [Vec3::X * mean, Vec3::ZERO])
            });
            jumps.collect::<Vec<i32>>()
        };
        assert_eq!(jumps(&|t| (t - 10.0 * DT).clamp(0.0, 12.0 * DT)), [11, 23], "starts and stops");
        assert_eq!(jumps(&|t| (t - 20.0 * DT).abs()), [1, 21], "moves and turns back");
        assert_eq!(jumps(&|t| t + 0.4 * (t - 20.0 * DT).max(0.0)), [1, 21], "moves and goes faster");
        assert_eq!(jumps(&|t| 0.5 * t * t), [1], "is accelerated from rest");
        assert_eq!(jumps(&|t| (8.0 * t).sin()), [1], "swings");
        assert_eq!(jumps(&|t| 1.0 - (8.0 * t).cos()), [1], "swings from rest");
    }

    #[test]
    fn the_velocity_of_a_smooth_track_jumps_by_second_order() {
        let rate = 8.0_f32;
        let jump = |ends: Vec<[f32; 2]>| ends[3..].windows(2).map(|pair| (pair[1][0] - pair[0][1]).abs()).fold(0.0, f32::max);
        // Of v = sin(8 t): 8 dt = 0.125 a step without a slope; (8 dt)² and less with one.
        let found = jump(ends(|t| -(rate * t).cos() / rate));
        assert!(found < 0.016, "the velocity jumps by {found} of its greatest");
    }
}
