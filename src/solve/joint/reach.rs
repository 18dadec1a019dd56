//! Finds joints whose stops are out of reach within the step: they are swept like joints without stops.
//!
//! A stop C ≥ 0 that is far off has no multiplier and does nothing, but its row costs as much as one that presses. So a step looks
//! once at the angle of each limited joint. With ω the spin of B against A now, the stop is out of reach where
//!
//! ```text
//! C > 2 |ω| dt + 0.1 rad:
//! ```
//!
//! the joint may turn twice as fast as it does, and be struck by 6 rad/s at 60 steps a second besides. What a harder blow turns it
//! by beyond its stop is taken back from the next step on, as any overrun stop is.
//!
//! Articulations that are swept leave such rows out too, until rows are built anew. They take no angle for it: a cosine changes by
//! no more than its angle, so a swing θ is farther than r from its limit L, and a twist φ farther than r from both ends of c ± w, where
//!
//! ```text
//! cos θ > cos L + r,      cos(φ − c) > cos w + r,
//! ```
//!
//! and of the quaternion of `R_aᵀ R_b`, cos θ = 1 − 2 (y² + z²), (w² + x²) cos φ = w² − x², (w² + x²) sin φ = 2 w x.

use glam::DQuat;

use super::JointEntry;
use super::angles::nearest;
use super::geometry::Placement;
use super::rows::Rate;
use super::spherical::swing;
use crate::joint::{JointKind, Limits, Motor, SphericalMotor};
use crate::joint_record::JointImpulses;
use crate::solve::state::{BodyMotion, BodyVelocity};

/// How much faster a joint may come to turn within a step, and by how much a blow may turn it besides (rad).
const OUTPACED: f64 = 2.0;
const BLOW: f64 = 0.1;

/// What cosines of f64 are not off by.
const ROUNDING: f64 = 1.0e-9;

/// Whether the joint has stops, no motor, and none of the stops acts or may come to act in a step of length `dt` (s).
pub(super) fn stops_are_out_of_reach(
    entry: &JointEntry,
    kind: &JointKind,
    velocities: &[BodyVelocity],
    motions: &[BodyMotion],
    dt: f32,
) -> bool {
    let can_be =
        matches!(kind, JointKind::Hinge { motor: Motor::Off, .. } | JointKind::Spherical { motor: SphericalMotor::Off, .. });
    if !can_be || entry.impulses.scalar.iter().any(|&multiplier| multiplier != 0.0) {
        return false;
    }
    let [a, b] = [entry.a as usize, entry.b as usize];
    let spin = f64::from((velocities[b].angular - velocities[a].angular).length());
    let reach = OUTPACED * spin * f64::from(dt) + BLOW;
    let placement = entry.placement(motions[a].stance(), motions[b].stance());
    match *kind {
        JointKind::Hinge { limits, .. } => is_within(nearest(placement.twist(), entry.angles[0]), limits, reach),
        JointKind::Spherical { swing_limit, twist_limits, .. } => {
            let swings = swing_limit < std::f32::consts::PI;
            (!swings || swing(&placement) + reach < f64::from(swing_limit))
                && (twist_limits == Limits::NONE || twists_within(&placement, entry.angles[0], twist_limits, reach))
        }
        _ => false,
    }
}

/// Whether an angle is farther than `reach` from both its limits.
fn is_within(angle: f64, limits: Limits, reach: f64) -> bool {
    angle - f64::from(limits.min) > reach && f64::from(limits.max) - angle > reach
}

/// The same of the twist of a joint that is not swung so far that twist has no meaning.
fn twists_within(placement: &Placement, angle: f64, limits: Limits, reach: f64) -> bool {
    swing(placement) < std::f64::consts::FRAC_PI_2 && is_within(nearest(placement.twist(), angle), limits, 2.0 * reach)
}

/// Stops of one joint, by cosines, and whether they are out of reach of the rows that it has now.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FarStops {
    /// Limits of which these are the cosines: swing, least and greatest twist (rad); a hinge has no swing.
    limits: [f32; 3],
    /// cos L, −∞ where swing has no limit, ∞ where nothing is ever out of reach.
    swing: f64,
    /// cos c, sin c and cos w; the last −∞ where twist has no limits.
    twist: [f64; 3],
    is_hinge: bool,
    are_far: bool,
}

impl Default for FarStops {
    fn default() -> Self {
        Self { limits: [f32::NAN; 3], swing: f64::INFINITY, twist: [0.0; 3], is_hinge: false, are_far: false }
    }
}

impl FarStops {
    /// Takes in the limits of a joint of this kind, where they are others than before.
    pub(crate) fn know(&mut self, kind: &JointKind) {
        let (swing, twist, is_hinge) = match *kind {
            JointKind::Hinge { limits, motor: Motor::Off } => (f32::INFINITY, limits, true),
            JointKind::Spherical { swing_limit, twist_limits, motor: SphericalMotor::Off } => (swing_limit, twist_limits, false),
            _ => (f32::INFINITY, Limits::NONE, true),
        };
        let limits = [swing, twist.min, twist.max];
        if self.limits == limits && self.is_hinge == is_hinge {
            return;
        }
        let has_swing = swing < std::f32::consts::PI;
        let (min, max) = (f64::from(twist.min), f64::from(twist.max));
        let turn = -std::f64::consts::PI..=std::f64::consts::PI;
        let (swing, twist) = match twist == Limits::NONE {
            true if !has_swing => (f64::INFINITY, [0.0; 3]),
            true => (libm::cos(f64::from(swing)), [0.0, 0.0, f64::NEG_INFINITY]),
            // Cosines tell no turns apart.
            false if !turn.contains(&min) || !turn.contains(&max) => (f64::INFINITY, [0.0; 3]),
            false => {
                let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
                let swing = if has_swing { libm::cos(f64::from(swing)) } else { f64::NEG_INFINITY };
                (swing, [libm::cos(middle), libm::sin(middle), libm::cos(half)])
            }
        };
        *self = Self { limits, swing, twist, is_hinge, are_far: false };
    }

    /// Notes whether no stop acts or may come to act within a time of `rest` (s), for bodies with these velocities and a joint at this
    /// angle (rad).
    pub(crate) fn are_out_of_reach(
        &mut self,
        (impulses, angle): (&JointImpulses, f64),
        placement: &Placement,
        [a, b]: [&Rate; 2],
        rest: f64,
    ) -> bool {
        // A turn further on it would look the same.
        let is_between = || self.twist[2] == f64::NEG_INFINITY || (self.limits[1]..=self.limits[2]).contains(&(angle as f32));
        self.are_far = self.swing < f64::INFINITY && impulses.scalar[..3] == [0.0; 3] && is_between() && {
            let reach = OUTPACED * (b.angular - a.angular).length() * rest + BLOW;
            self.are_beyond(reach, placement.relative_rotation())
        };
        self.are_far
    }

    /// Whether stops that were out of reach are not overrun there either.
    pub(crate) fn still_hold(&self, placement: &Placement) -> bool {
        self.are_far && self.are_beyond(ROUNDING, placement.relative_rotation())
    }

    /// Whether all stops are farther than `reach` (rad) from where B's frame is turned to in A's.
    fn are_beyond(&self, reach: f64, turned: DQuat) -> bool {
        let DQuat { x, y, z, w } = turned;
        let cosine = 1.0 - 2.0 * (y * y + z * z);
        let [middle_cosine, middle_sine, edge] = self.twist;
        // As above: twist turns with swing.
        let (means_much, twist_reach) = if self.is_hinge { (true, reach) } else { (cosine > 0.0, 2.0 * reach) };
        let is_between = || (w * w - x * x) * middle_cosine + 2.0 * w * x * middle_sine > (edge + twist_reach) * (w * w + x * x);
        cosine > self.swing + reach && (edge == f64::NEG_INFINITY || (means_much && is_between()))
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3, Vec3};

    use super::*;
    use crate::joint_record::JointImpulses;

    const DT: f32 = 1.0 / 60.0;

    /// Whether the stops are out of reach of a joint on the world, turned by `turned` (rad) and turning at `spin` (rad/s).
    fn is_free(kind: JointKind, turned: Vec3, spin: Vec3, pressed: f32) -> bool {
        let velocities = [BodyVelocity::FIXED, BodyVelocity { angular: spin, ..BodyVelocity::FIXED }];
        let mut impulses = JointImpulses::ZERO;
        impulses.scalar[0] = pressed;
        let entry = JointEntry {
            b: 1,
            local_frame: [DQuat::IDENTITY, DQuat::from_scaled_axis(turned.as_dvec3())],
            impulses,
            counts_turns: true,
            ..JointEntry::NONE
        };
        stops_are_out_of_reach(&entry, &kind, &velocities, &[BodyMotion::FIXED; 2], DT)
    }

    #[test]
    fn a_hinge_is_free_far_from_its_stops_and_while_it_turns_slowly() {
        let hinge = JointKind::Hinge { limits: Limits::new(-1.0, 1.0), motor: Motor::Off };
        let driven = JointKind::Hinge { limits: Limits::new(-1.0, 1.0), motor: Motor::Velocity { target: 1.0, max_force: 1.0 } };
        let (x, still) = (Vec3::X, Vec3::ZERO);
        assert!(is_free(hinge, still, still, 0.0), "in the middle");
        assert!(is_free(hinge, x * -0.85, still, 0.0), "0.15 rad from a stop");
        assert!(!is_free(hinge, x * -0.95, still, 0.0), "0.05 rad from a stop");
        assert!(is_free(hinge, still, x * 20.0, 0.0), "a third of a radian in the step");
        assert!(!is_free(hinge, still, x * 30.0, 0.0), "half a radian in the step");
        assert!(!is_free(hinge, still, still, 0.1), "a stop that presses");
        assert!(!is_free(driven, still, still, 0.0), "a motor");
    }

    #[test]
    fn a_ball_joint_is_free_far_from_its_swing_and_twist() {
        let kind = |swing_limit: f32, twist: f32| JointKind::Spherical {
            swing_limit,
            twist_limits: Limits::new(-twist, twist),
            motor: SphericalMotor::Off,
        };
        let still = Vec3::ZERO;
        assert!(is_free(kind(0.7, 1.0), Vec3::Y * 0.5, still, 0.0), "0.2 rad from its swing");
        assert!(!is_free(kind(0.7, 1.0), Vec3::Y * 0.65, still, 0.0), "0.05 rad from its swing");
        assert!(!is_free(kind(0.7, 1.0), Vec3::X * 0.95, still, 0.0), "0.05 rad from its twist");
        assert!(!is_free(kind(0.7, 1.0), Vec3::Y * 0.5, Vec3::Y * 10.0, 0.0), "a sixth of a radian in the step");
    }

    #[test]
    fn cosines_find_stops_far_only_where_angles_do() {
        let hinge = |min: f32, max: f32| JointKind::Hinge { limits: Limits::new(min, max), motor: Motor::Off };
        let ball = |swing_limit: f32, twist_limits: Limits| JointKind::Spherical {
            swing_limit,
            twist_limits,
            motor: SphericalMotor::Off,
        };
        let kinds = [
            hinge(-1.0, 1.0),
            hinge(0.0, 2.4),
            hinge(-3.1, 0.5),
            hinge(2.0, 4.0),
            hinge(0.3, f32::INFINITY),
            ball(0.7, Limits::NONE),
            ball(2.0, Limits::new(-1.0, 1.5)),
            ball(4.0, Limits::new(-0.5, 2.5)),
        ];
        let (still, mut found) = (Rate { linear: DVec3::ZERO, angular: DVec3::ZERO }, [0; 8]);
        for (kind, found) in kinds.iter().zip(&mut found) {
            let mut stops = FarStops::default();
            stops.know(kind);
            for number in 0..4000 {
                let turn = (f64::from(number) + 0.5) * std::f64::consts::TAU / 4000.0;
                // A hinge keeps its axis; a ball joint turns about any.
                let axis = match kind {
                    JointKind::Hinge { .. } => DVec3::X,
                    _ => DVec3::new(libm::cos(7.0 * turn), libm::sin(7.0 * turn), libm::sin(31.0 * turn)).normalize(),
                };
                let turned = DQuat::from_axis_angle(axis, turn);
                let placement = super::super::placement_of(DVec3::ZERO, [DVec3::ZERO; 2], [DQuat::IDENTITY, turned]);
                let by_angle = is_free(*kind, turned.to_scaled_axis().as_vec3(), Vec3::ZERO, 0.0);
                let near = super::super::angles::first(kind, &placement)[0];
                let by_cosine = stops.are_out_of_reach((&JointImpulses::ZERO, near), &placement, [&still; 2], f64::from(DT));
                assert!(by_angle || !by_cosine, "{kind:?} turned by {turn} about {axis}");
                assert!(!by_cosine || stops.still_hold(&placement), "what is far holds");
                *found += i32::from(by_cosine);
            }
        }
        assert!(
            found.iter().zip(&kinds).all(|(&found, kind)| {
                let is_never_far = *kind == hinge(2.0, 4.0) || *kind == hinge(0.3, f32::INFINITY);
                if is_never_far { found == 0 } else { found > 200 }
            }),
            "{found:?}"
        );
    }

    #[test]
    fn a_stop_that_was_far_is_seen_once_it_is_overrun() {
        let mut stops = FarStops::default();
        stops.know(&JointKind::Hinge { limits: Limits::new(-0.5, 0.5), motor: Motor::Off });
        let at = |turned: f64| {
            super::super::placement_of(DVec3::ZERO, [DVec3::ZERO; 2], [DQuat::IDENTITY, DQuat::from_rotation_x(turned)])
        };
        let still = Rate { linear: DVec3::ZERO, angular: DVec3::ZERO };
        let none = (&JointImpulses::ZERO, 0.0);
        assert!(stops.are_out_of_reach(none, &at(0.0), [&still; 2], 0.01));
        assert!(!stops.are_out_of_reach((none.0, 6.3), &at(0.0), [&still; 2], 0.01), "a turn past its stop");
        assert!(stops.are_out_of_reach(none, &at(0.0), [&still; 2], 0.01));
        assert!(stops.still_hold(&at(0.499)) && !stops.still_hold(&at(0.501)) && !stops.still_hold(&at(-0.501)));
        let turning = Rate { angular: DVec3::X * 30.0, ..still };
        assert!(!stops.are_out_of_reach(none, &at(0.0), [&still, &turning], 0.01), "it may turn by 0.6 rad");
        assert!(!stops.still_hold(&at(0.0)), "rows have it");
    }
}
