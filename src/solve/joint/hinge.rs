//! Hinge: points coincide, B's joint axis stays on A's (two rows, C = angle·(a_a × a_b)), and the angle about it may be limited
//! and driven, and rub. The angle is read as the twist of R_aᵀ R_b; its gradient is the joint axis.

use super::geometry::Placement;
use super::row_sink::RowSink;
use super::rows::{HeldDirections, Jacobian};
use crate::joint::{Limits, Motor};

pub(crate) fn rows(sink: &mut RowSink, limits: Limits, motor: Motor) {
    let axis = sink.geometry.gradient.axes_a().x_axis;
    sink.hold_directions(HeldDirections::Across(axis), sink.geometry.gradient.a.frame, Placement::axis_error);
    sink.hold_points(HeldDirections::All);
    let jacobian = Jacobian::angular(axis);
    if sink.has_rows(limits, motor) {
        let angle = sink.angle(jacobian, Placement::twist);
        sink.limit_and_drive(&angle, limits, motor, 0);
    }
    sink.rub(jacobian, sink.def.friction, limits, 0);
}
