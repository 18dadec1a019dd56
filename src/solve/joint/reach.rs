//! Joints whose stops are out of reach within a step: they are swept like joints that have none.
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

use super::JointEntry;
use super::geometry::Placement;
use super::spherical::swing;
use crate::joint::{JointKind, Limits, Motor, SphericalMotor};
use crate::solve::state::{BodyMotion, BodyVelocity};

/// How much faster a joint may come to turn within a step, and by how much a blow may turn it besides (rad).
const OUTPACED: f64 = 2.0;
const BLOW: f64 = 0.1;

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
        JointKind::Hinge { limits, .. } => is_within(placement.twist(), limits, reach),
        JointKind::Spherical { swing_limit, twist_limits, .. } => {
            let swings = swing_limit < std::f32::consts::PI;
            (!swings || swing(&placement) + reach < f64::from(swing_limit))
                && (twist_limits == Limits::NONE || twists_within(&placement, twist_limits, reach))
        }
        _ => false,
    }
}

/// Whether an angle is farther than `reach` from both its limits.
fn is_within(angle: f64, limits: Limits, reach: f64) -> bool {
    angle - f64::from(limits.min) > reach && f64::from(limits.max) - angle > reach
}

/// The same of the twist of a joint that is not swung so far that twist has no meaning.
fn twists_within(placement: &Placement, limits: Limits, reach: f64) -> bool {
    swing(placement) < std::f64::consts::FRAC_PI_2 && is_within(placement.twist(), limits, 2.0 * reach)
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3, Vec3};

    use super::*;
    use crate::joint::JointImpulses;
    use crate::settings::Solver;

    const DT: f32 = 1.0 / 60.0;

    /// Whether the stops are out of reach of a joint on the world, turned by `turned` (rad) and turning at `spin` (rad/s).
    fn is_free(kind: JointKind, turned: Vec3, spin: Vec3, pressed: f32) -> bool {
        let velocities = [BodyVelocity::FIXED, BodyVelocity { angular: spin, ..BodyVelocity::FIXED }];
        let mut impulses = JointImpulses::ZERO;
        impulses.scalar[0] = pressed;
        let entry = JointEntry {
            joint: 0,
            a: 0,
            b: 1,
            offset: DVec3::ZERO,
            local_lever: [DVec3::ZERO; 2],
            local_frame: [DQuat::IDENTITY, DQuat::from_scaled_axis(turned.as_dvec3())],
            impulses,
            linear_sum: Vec3::ZERO,
            angular_sum: Vec3::ZERO,
            acted: [Vec3::ZERO; 2],
            pressed: 0,
            solver: Solver::Auto,
            most_rows: 0,
            is_plain: false,
            is_hinge: false,
            is_distance: false,
            gives_by_motors_alone: true,
            has_motor: false,
            has_friction: false,
            can_be_overloaded: false,
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
}
