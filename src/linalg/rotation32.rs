//! Rotations in `f32`, by power series: the same bits on every platform. Components too small to matter become zero.

use glam::{Quat, Vec3, Vec4};

/// Speeds below this are taken as zero (m/s, rad/s), so that neither they nor their squares
/// become denormal numbers, which cost ten times as much.
pub(crate) const NEGLIGIBLE_SPEED: f32 = 1.0e-9;

/// Components of quaternions and displacements below this are taken as zero (m, rad), for the same reason.
pub(crate) const NEGLIGIBLE_WAY: f32 = 1.0e-12;

/// The same for the displacement by which one position correction moves a body (m, rad): power series take its fourth power.
pub(crate) const NEGLIGIBLE_PUSH: f32 = 1.0e-8;

/// Ratios of the terms of the power series of sin φ/φ and of cos φ to the terms before, over −φ².
pub(crate) const SINE_TERMS: [f32; 4] = [1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0];
pub(crate) const COSINE_TERMS: [f32; 5] = [1.0 / 2.0, 1.0 / 12.0, 1.0 / 30.0, 1.0 / 56.0, 1.0 / 90.0];

/// `rotation` turned by a rotation vector in world axes (rad).
///
/// Sine and cosine of the half angle are power series: exact to rounding up to a half angle of half a radian.
pub(crate) fn rotated(rotation: Quat, vector: Vec3) -> Quat {
    let rotation = Vec4::from(quaternion_of(vector) * rotation);
    Quat::from_vec4(Vec4::select(rotation.abs().cmpgt(Vec4::splat(NEGLIGIBLE_WAY)), rotation, Vec4::ZERO)).normalize()
}

/// The same for a rotation vector of any length, in pieces of at most a radian.
pub(crate) fn rotated_far(rotation: Quat, turn: Vec3) -> Quat {
    let pieces = turn.length().ceil().max(1.0);
    (0..pieces as u32).fold(rotation, |rotation, _| rotated(rotation, turn / pieces))
}

/// Quaternion of a rotation vector of at most a radian.
pub(crate) fn quaternion_of(vector: Vec3) -> Quat {
    let half = vector * 0.5;
    let x = half.length_squared();
    let series = |terms: &[f32]| terms.iter().rev().fold(1.0, |sum, term| 1.0 - x * term * sum);
    let (sine_over_angle, cosine) = (series(&SINE_TERMS), series(&COSINE_TERMS));
    let axis = half * sine_over_angle;
    Quat::from_xyzw(axis.x, axis.y, axis.z, cosine)
}

/// `v` with components no greater than `least` set to zero.
pub(crate) fn settled(v: Vec3, least: f32) -> Vec3 {
    Vec3::select(v.abs().cmpgt(Vec3::splat(least)), v, Vec3::ZERO)
}
