//! Prismatic joint: frames stay parallel (three rows), the gap stays on A's joint axis (two rows), and its length along the axis
//! may be limited and driven: C = a·(p_b − p_a), ∇C = [−a, −(r_a + gap)×a, a, r_b×a].

use super::geometry::Placement;
use super::row_sink::RowSink;
use super::rows::HeldDirections;
use crate::joint::{Limits, Motor};

pub(crate) fn rows(sink: &mut RowSink, limits: Limits, motor: Motor) {
    let axis = sink.geometry.gradient.axes_a().x_axis;
    sink.hold_directions(HeldDirections::All, sink.geometry.gradient.a.frame, Placement::rotation_vector);
    sink.hold_points(HeldDirections::Across(axis));
    let jacobian = sink.along(axis);
    if sink.has_rows(limits, motor) {
        let slide = sink.length(jacobian, |p: &Placement| p.local_gap().x);
        sink.limit_and_drive(&slide, limits, motor, 0);
    }
    sink.rub(jacobian, sink.def.friction, limits, 0);
}
