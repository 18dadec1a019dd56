//! Entry checks: every number that enters a world passes one of these, in every build.

use glam::{DVec3, Quat, Vec3};

use crate::error::{Error, ErrorKind, Result};

/// Largest distance from the origin that a position may have (m): at this range an `f64` still resolves 0.1 µm.
pub const MAX_COORDINATE: f64 = 1.0e9;

/// Largest distance of a point of a body from the body's origin (m), as for shapes, centres of mass and frames of joints: the size of
/// the largest shape. An `f32` lever of that length still resolves 0.06 m.
pub const MAX_LEVER: f32 = 1.0e6;

/// Shortest and longest step (s).
pub const STEP_RANGE: (f32, f32) = (1.0e-6, 1.0);

/// How far a rotation or direction may be from unit length before it is refused (1 %).
const UNIT_TOLERANCE: f32 = 0.01;

pub(crate) fn finite(argument: &'static str, value: f32) -> Result<f32> {
    if value.is_finite() { Ok(value) } else { Err(not_finite(argument)) }
}

pub(crate) fn not_nan(argument: &'static str, value: f32) -> Result<f32> {
    if value.is_nan() { Err(not_finite(argument)) } else { Ok(value) }
}

pub(crate) fn not_negative(argument: &'static str, value: f32) -> Result<f32> {
    if finite(argument, value)? < 0.0 {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "must not be negative"));
    }
    Ok(value)
}

/// A bound that may be infinite ("never") but neither NaN nor negative.
pub(crate) fn bound(argument: &'static str, value: f32) -> Result<f32> {
    if not_nan(argument, value)? < 0.0 {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "must not be negative"));
    }
    Ok(value)
}

pub(crate) fn positive(argument: &'static str, value: f32) -> Result<f32> {
    if finite(argument, value)? <= 0.0 {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "must be greater than zero"));
    }
    Ok(value)
}

pub(crate) fn step_length(dt: f32) -> Result<f32> {
    if finite("dt", dt)? < STEP_RANGE.0 || dt > STEP_RANGE.1 {
        return Err(Error::new(ErrorKind::OutOfRange, "dt", "must be between 1e-6 and 1 s"));
    }
    Ok(dt)
}

pub(crate) fn range(argument: &'static str, min: f32, max: f32) -> Result<()> {
    not_nan(argument, min)?;
    if not_nan(argument, max)? < min {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "minimum is greater than maximum"));
    }
    Ok(())
}

pub(crate) fn finite_vec(argument: &'static str, value: Vec3) -> Result<Vec3> {
    if value.is_finite() { Ok(value) } else { Err(not_finite(argument)) }
}

/// A point in the frame of a body.
pub(crate) fn lever(argument: &'static str, value: Vec3) -> Result<Vec3> {
    if finite_vec(argument, value)?.abs().max_element() > MAX_LEVER {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "is more than 1e6 m from the body's origin"));
    }
    Ok(value)
}

pub(crate) fn position(argument: &'static str, value: DVec3) -> Result<DVec3> {
    if !value.is_finite() {
        return Err(not_finite(argument));
    }
    if value.abs().max_element() > MAX_COORDINATE {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "is more than 1e9 m from the origin"));
    }
    Ok(value)
}

/// What rounding leaves of a quaternion's length squared when it is normalised.
const NORMALIZED: f32 = 4.0 * f32::EPSILON;

/// Accepts a rotation within 1 % of unit length and returns it normalised. One that is normalised stays as it is to the bit: a definition
/// goes through here with every edit of any of its fields.
pub(crate) fn rotation(argument: &'static str, value: Quat) -> Result<Quat> {
    if !value.is_finite() {
        return Err(not_finite(argument));
    }
    if (value.length() - 1.0).abs() > UNIT_TOLERANCE {
        return Err(Error::new(ErrorKind::NotUnit, argument, "rotation is not of unit length"));
    }
    if (value.length_squared() - 1.0).abs() <= NORMALIZED {
        return Ok(value);
    }
    Ok(value.normalize())
}

/// Accepts a direction within 1 % of unit length and returns it normalised.
pub(crate) fn direction(argument: &'static str, value: Vec3) -> Result<Vec3> {
    finite_vec(argument, value)?;
    if (value.length() - 1.0).abs() > UNIT_TOLERANCE {
        return Err(Error::new(ErrorKind::NotUnit, argument, "direction is not of unit length"));
    }
    Ok(value.normalize())
}

const fn not_finite(argument: &'static str) -> Error {
    Error::new(ErrorKind::NotFinite, argument, "is NaN or infinite")
}
