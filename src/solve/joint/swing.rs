//! How much the springs of a joint may set going within a step.
//!
//! A spring that is off its rest by x pushes with no more than x/α, or what bounds its force; and from rest it goes past its rest by no more than x.
//! So within a step of length T its coordinate goes by
//!
//! ```text
//! min(T² w x/α, 2 x),    w = J M⁻¹ Jᵀ,
//! ```
//!
//! at most, with w that of the joint's own two bodies, as what other joints hold answers less. In the norm |v|² = vᵀ M v that is a mean velocity
//! of so much over T √w (√J). Those of several springs add up at most, and by one of |v| no row n of a body closes faster than √(n M⁻¹ nᵀ) |v|.
//! What gives so little that it is as good as rigid is next to where it rests, and goes nowhere.

use glam::DVec3;

use super::JointEntry;
use super::body_response::MotorAnswers;
use super::geometry::JointGeometry;
use super::kinds;
use super::row_sink::RowSink;
use super::rows::{BlockRow, Jacobian, Phase, Rate, RowRates, ScalarRow};
use super::singles::answer_of;
use crate::joint_record::Joint;
use crate::solve::state::{BodyMotion, BodyVelocity};

/// Greatest mean |v| that the springs of a joint make in a step of length `dt` (s) from where its bodies are; `asked` is room for rows.
pub(crate) fn most_swing(
    entry: &JointEntry,
    joint: &Joint,
    (velocities, motions): (&[BodyVelocity], &[BodyMotion]),
    dt: f64,
    asked: &mut Vec<ScalarRow>,
) -> f64 {
    let answers = [entry.a, entry.b].map(|slot| answer_of(&velocities[slot as usize], &motions[slot as usize]));
    let placement = entry.placement(motions[entry.a as usize].stance(), motions[entry.b as usize].stance());
    let rates = RowRates { bodies: [Rate::ZERO; 2], frames: None };
    let mut sink = RowSink {
        answers: MotorAnswers { bodies: &|side| answers[side], in_loop: None },
        ..RowSink::new(JointGeometry::at(&placement), &joint.def, (Phase::Tangent { h: dt }, rates), entry.angles, asked)
    };
    kinds::add_rows(&mut sink);
    let (point, direction) = (sink.point, sink.direction);
    let ease = |way: &Jacobian| {
        let pushes = [(way.linear, way.angular_a), (way.linear, way.angular_b)];
        let each = pushes.iter().zip(&answers).map(|(&(linear, angular), answer)| {
            linear.dot(answer.inverse_mass * linear) + angular.dot(answer.inverse_inertia * angular)
        });
        each.sum::<f64>()
    };
    let swing = |way: &Jacobian, bias: f64, gamma: f64, [least, most]: [f64; 2]| {
        let (impulse, ease) = ((-bias / gamma).clamp(least, most).abs(), ease(way));
        if ease > 0.0 { (ease * impulse).min(2.0 * bias.abs()) / ease.sqrt() } else { 0.0 }
    };
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let of_block = |block: BlockRow, way: &dyn Fn(&BlockRow, DVec3) -> Jacobian| {
        let (axes, count) = block.held.axes();
        axes[..count].iter().map(|&axis| swing(&way(&block, axis), block.bias.dot(axis), block.gamma, free)).sum::<f64>()
    };
    let along = |block: &BlockRow, axis: DVec3| {
        let [angular_a, angular_b] = block.levers.map(|lever| lever.cross(axis));
        Jacobian { linear: axis, angular_a, angular_b }
    };
    let gives = |block: &BlockRow| block.gamma > 0.0;
    let of_point = point.filter(gives).map_or(0.0, |block| of_block(block, &along));
    let of_direction = direction.filter(gives).map_or(0.0, |block| of_block(block, &|_, axis| Jacobian::angular(axis)));
    let scalars = asked.iter().filter(|row| row.acts && row.gamma > 0.0);
    of_point + of_direction + scalars.map(|row| swing(&row.jacobian, row.bias, row.gamma, [row.min, row.max])).sum::<f64>()
}
