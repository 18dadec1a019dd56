//! Spherical joint: points coincide; the angle between the joint axes (swing) and the rotation about A's axis (twist) may be
//! limited, and the rotation driven.
//!
//! Swing: C = limit − acos(a_a·a_b), gradient the unit vector a_a × a_b. Twist: the x part of the swing–twist split of
//! R_aᵀ R_b; its gradient is (a_a + a_b)/(1 + a_a·a_b), the axis about which twist changes and swing does not. Where swing is locked the axes
//! lie along one another, and a_a × a_b is nothing: both directions across them are held then, as a hinge holds them.

use glam::DVec3;

use super::geometry::Placement;
use super::row_sink::RowSink;
use super::rows::{Demand, Error1, HeldDirections, Jacobian, SoftParams};
use crate::joint::{Limits, Motor, SphericalMotor};

/// Swing below which its axis has no meaning (rad): a limit below it locks, and no other is ever reached from there in one substep.
const MIN_SWING: f64 = 1.0e-4;

/// Multiplier of the first of two rows that hold the axes along one another.
const LOCKED_SWING: u8 = 7;

/// 1 + cos(swing) below which twist has no meaning: the axes are all but opposite.
const MIN_TWIST_DENOMINATOR: f64 = 1.0e-2;

pub(crate) fn rows(sink: &mut RowSink, swing_limit: f32, twist_limits: Limits, motor: SphericalMotor) {
    let g = sink.geometry.gradient;
    let (axis_a, axis_b) = (g.a.frame * DVec3::X, g.b.frame * DVec3::X);
    if locks_swing(swing_limit) {
        hold_axes(sink);
    } else if swing_limit < std::f32::consts::PI && sink.has_stops {
        let across = axis_a.cross(axis_b);
        let sine = across.length();
        if sine > MIN_SWING {
            let ([first, last], rate) = sink.stop_at(f64::from(swing_limit), 0);
            let (start, predicted) = sink.geometry.read(swing);
            let error = Error1 { start: first - start, predicted: last - predicted };
            let give = SoftParams::new(sink.def.limit, sink.phase);
            sink.driven_scalar(Jacobian::angular(-across / sine), rate, Demand::AtLeast(error), give, 0);
        }
    }
    let denominator = 1.0 + axis_a.dot(axis_b);
    if twist_limits != Limits::NONE && denominator > MIN_TWIST_DENOMINATOR {
        let jacobian = Jacobian::angular((axis_a + axis_b) / denominator);
        if sink.has_rows(twist_limits, Motor::Off) {
            let twist = sink.angle(jacobian, Placement::twist);
            sink.limit_and_drive(&twist, twist_limits, Motor::Off, 1);
        }
    }
    sink.hold_points(HeldDirections::All);
    drive(sink, motor);
    sink.rub_about_point(sink.def.friction);
}

/// Whether a joint with this greatest swing has none.
pub(super) fn locks_swing(swing_limit: f32) -> bool {
    f64::from(swing_limit) < MIN_SWING
}

/// Holds the joint axes along one another, about both axes of A's frame across them.
fn hold_axes(sink: &mut RowSink) {
    let give = SoftParams::new(sink.def.limit, sink.phase);
    let axes = sink.geometry.gradient.axes_a();
    let (start, predicted) = sink.geometry.read(Placement::axis_error);
    for i in 1..3 {
        let error = Error1 { start: start[i], predicted: predicted[i] };
        sink.scalar(Jacobian::angular(axes.col(i)), Demand::Equal(error), give, LOCKED_SWING + i as u8 - 1);
    }
}

/// Angle between the joint axes (rad).
pub(super) fn swing(placement: &Placement) -> f64 {
    let b = placement.relative_rotation() * DVec3::X;
    libm::atan2((b.y * b.y + b.z * b.z).sqrt(), b.x)
}

/// Three rows along the axes of A's joint frame, each with the full torque.
fn drive(sink: &mut RowSink, motor: SphericalMotor) {
    let axes = sink.geometry.gradient.axes_a();
    match motor {
        SphericalMotor::Off => {}
        SphericalMotor::Velocity { target, max_torque } => {
            let max_impulse = f64::from(max_torque) * sink.phase.h();
            for i in 0..3 {
                let demand = Demand::Speed { target: f64::from(target[i]), bounds: [-max_impulse, max_impulse] };
                sink.scalar(Jacobian::angular(axes.col(i)), demand, SoftParams::rigid(sink.phase), 4 + i as u8);
            }
        }
        SphericalMotor::Position { target, softness, max_torque } => {
            let target = target.as_dquat().normalize();
            let error = |placement: &Placement| {
                let mut turned = *placement;
                turned.a.frame = placement.a.frame * target;
                target * turned.rotation_vector()
            };
            sink.turn_to(error, softness, max_torque);
        }
    }
}
