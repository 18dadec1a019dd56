//! Distance joint: C = |p_b − p_a| against a least and a greatest distance, a spring length and a motor.
//! ∇C = [−u, −r_a×u, u, r_b×u] with u the direction of the gap.

use glam::DVec3;

use super::geometry::Placement;
use super::row_sink::RowSink;
use super::rows::{Demand, Error1, HeldDirections, Jacobian};
use crate::joint::{JointDef, JointKind, Limits, Motor, Softness};

/// Gap below which the direction has no meaning and A's joint axis stands in for it (m).
const MIN_GAP: f64 = 1.0e-6;

/// Length up to which a rope ties two points together, as a ball joint does (m).
/// Why: what hangs on it turns round it faster than substeps of 1/240 s can tell, g h²/r > 1, and no rope is seen to be so short.
/// Scenes: ropes of 0 to 10 mm with 10 g to 10 t at 30 to 240 Hz. Test: tests/scales.rs
const SHORTEST: f32 = 1.0e-4;

/// Whether a joint is a rigid rope that is as good as reeled in.
pub(crate) fn ties_points(def: &JointDef) -> bool {
    let JointKind::Distance { limits, spring_length: None, motor: Motor::Off } = def.kind else { return false };
    limits.max <= SHORTEST && def.limit == Softness::RIGID && def.linear == Softness::RIGID
}

pub(crate) fn rows(sink: &mut RowSink, limits: Limits, spring_length: Option<f32>, motor: Motor) {
    if ties_points(sink.def) {
        return sink.hold_points(HeldDirections::All);
    }
    let g = sink.geometry.gradient;
    let length = g.gap.length();
    let direction = if length > MIN_GAP { g.gap / length } else { g.a.frame * DVec3::X };
    let jacobian = Jacobian { linear: direction, angular_a: g.a.lever.cross(direction), angular_b: g.b.lever.cross(direction) };
    // No distance is negative: a least distance of zero needs no row.
    let limits = if limits.min <= 0.0 && limits.max > 0.0 { Limits::new(f32::NEG_INFINITY, limits.max) } else { limits };
    if sink.has_rows(limits, motor) {
        let distance = sink.length(jacobian, |p: &Placement| p.gap.length());
        sink.limit_and_drive(&distance, limits, motor, 0);
    }
    if let Some(rest) = spring_length.map(f64::from) {
        let error =
            Error1 { start: sink.geometry.start.gap.length() - rest, predicted: sink.geometry.predicted.gap.length() - rest };
        let give = sink.spring(sink.def.linear, &[jacobian]);
        sink.scalar(jacobian, Demand::Equal(error), give, 3);
    }
}
