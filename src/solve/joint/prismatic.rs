//! Prismatic joint: frames stay parallel (three rows), the gap stays on A's joint axis (two rows), and its length along the axis
//! may be limited and driven: C = a·(p_b − p_a), ∇C = [−a, −(r_a + gap)×a, a, r_b×a].

use super::geometry::Placement;
use super::kinds::{Coordinate, RowSink};
use super::rows::Held;
use crate::joint::{Limits, Motor};

pub(crate) fn rows(sink: &mut RowSink, limits: Limits, motor: Motor) {
    let axis = sink.geometry.gradient.axes_a().x_axis;
    sink.hold_directions(Held::All, Placement::rotation_vector);
    let slide = Coordinate { jacobian: sink.along(axis), value: |p: &Placement| p.local_gap().x, is_angle: false };
    sink.limit_and_drive(&slide, limits, motor, 0);
    sink.rub(slide.jacobian, sink.def.friction, limits, 0);
    sink.hold_points(Held::Across(axis));
}
