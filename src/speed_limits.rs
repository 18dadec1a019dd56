//! Greatest speeds of a body.

/// Greatest linear speed of a body (m/s); faster input is refused, faster motion is clamped.
pub const MAX_LINEAR_SPEED: f32 = 1.0e4;

/// Greatest angular speed of a body (rad/s); faster input is refused, faster motion is clamped.
pub const MAX_ANGULAR_SPEED: f32 = 1.0e4;

/// Whether a velocity (m/s) is at the limit, and whether it is beyond it, but for rounding.
pub(crate) fn is_at_limit(velocity: glam::Vec3) -> bool {
    velocity.length_squared() >= MAX_LINEAR_SPEED * MAX_LINEAR_SPEED * (1.0 - ROUNDING)
}

pub(crate) fn is_beyond_limit(velocity: glam::Vec3) -> bool {
    velocity.length_squared() > MAX_LINEAR_SPEED * MAX_LINEAR_SPEED * (1.0 + ROUNDING)
}

/// Share by which the square of a velocity that has been cut may be off: a few units in the last place of `f32`.
const ROUNDING: f32 = 8.0 * f32::EPSILON;
