//! Writes `f64` results into the `f32` state.
//!
//! Of what is nothing rounding leaves 1e-17, or less. In `f32` products of such numbers are subnormal, and each takes some processors
//! as long as a hundred others: of an excavator that turns about one axis alone, whose rotation, turns and velocities had such
//! components, a step took half as long again.

use glam::{DQuat, DVec3, Quat, Vec3};

use super::rotation32::{NEGLIGIBLE_SPEED, NEGLIGIBLE_WAY};

/// Other numbers are taken as zero where nothing could be multiplied with them.
const NEGLIGIBLE: f64 = 1.0e-30;

/// A velocity (m/s, rad/s).
pub(crate) fn speed(v: DVec3) -> Vec3 {
    settled(v, f64::from(NEGLIGIBLE_SPEED))
}

/// A displacement (m) or a rotation vector (rad).
pub(crate) fn way(v: DVec3) -> Vec3 {
    settled(v, f64::from(NEGLIGIBLE_WAY))
}

pub(crate) fn rotation(q: DQuat) -> Quat {
    let v = way(DVec3::new(q.x, q.y, q.z));
    Quat::from_xyzw(v.x, v.y, v.z, if q.w.abs() <= f64::from(NEGLIGIBLE_WAY) { 0.0 } else { q.w as f32 })
}

/// An impulse, or anything else that is not of the state of a body.
pub(crate) fn impulse(v: DVec3) -> Vec3 {
    settled(v, NEGLIGIBLE)
}

fn settled(v: DVec3, least: f64) -> Vec3 {
    // What is not a number stays that, and is found by who stores the body.
    DVec3::select(v.abs().cmple(DVec3::splat(least)), DVec3::ZERO, v).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_written_has_subnormal_squares() {
        let tiny = DVec3::new(1.0e-17, -1.0e-44, 0.5);
        let rotation = rotation(DQuat::from_xyzw(tiny.x, tiny.y, tiny.z, 0.8));
        assert_eq!(rotation, Quat::from_xyzw(0.0, 0.0, 0.5, 0.8));
        for written in [speed(tiny), way(tiny)] {
            assert_eq!(written, Vec3::new(0.0, 0.0, 0.5));
        }
        assert_eq!(impulse(tiny), Vec3::new(1.0e-17, 0.0, 0.5));
    }

    #[test]
    fn what_is_not_a_number_is_written_as_it_is() {
        assert!(speed(DVec3::NAN).is_nan() && rotation(DQuat::from_xyzw(0.0, 0.0, 0.0, f64::NAN)).is_nan());
    }

    #[test]
    fn the_slowest_turn_of_a_substep_is_kept() {
        let turn = f64::from(NEGLIGIBLE_SPEED) * 0.5 / 240.0;
        assert!(way(DVec3::splat(1.01 * turn)) != Vec3::ZERO);
    }
}
