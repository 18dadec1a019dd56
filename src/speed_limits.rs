//! Greatest speeds of a body.

/// Greatest linear speed of a body (m/s); faster input is refused, faster motion is clamped.
pub const MAX_LINEAR_SPEED: f32 = 1.0e4;

/// Greatest angular speed of a body (rad/s); faster input is refused, faster motion is clamped.
pub const MAX_ANGULAR_SPEED: f32 = 1.0e4;
