//! Fixed joint: C = [p_b − p_a, log(R_aᵀ R_b)] = 0, six rows as two blocks.

use super::geometry::Placement;
use super::row_sink::RowSink;
use super::rows::HeldDirections;

pub(crate) fn rows(sink: &mut RowSink) {
    sink.hold_directions(HeldDirections::All, sink.geometry.gradient.a.frame, Placement::rotation_vector);
    sink.hold_points(HeldDirections::All);
}
