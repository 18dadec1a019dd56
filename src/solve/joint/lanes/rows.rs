//! Rows of a block: gradients, effective masses and biases.

use super::begin::{arc_between, full_arc};
use super::{DirectionBlock, Holds, JointLanes, PointBlock};
use crate::lanes::wide::{Wide, Wide3};
use crate::solve::body_gather::{WideVelocities, gather_turns};
use crate::solve::integrate::PredictedPose;
use crate::solve::joint::IMPLICIT_RANGE;
use crate::solve::state::BodyVelocity;
use crate::solve::wide_matrix::WideQuat;

#[inline(always)]
pub(super) fn prepare<W: Wide>(lanes: &mut JointLanes, velocities: &[BodyVelocity], predicted_poses: &[PredictedPose], h: f32) {
    let JointLanes { points, directions, .. } = lanes;
    for block in points {
        let (a, b) = (WideVelocities::<W>::gather(&block.a, velocities), WideVelocities::<W>::gather(&block.b, velocities));
        let turns = (gather_turns::<W>(&block.a, predicted_poses), gather_turns::<W>(&block.b, predicted_poses));
        let implicit = hold_points(block, (&a, &b), (&turns.0, &turns.1), h);
        if let Some(number) = block.directions {
            let block = &mut directions[number as usize];
            // Of B against A, seen as if A had not turned.
            let turn = turns.0.conjugate().after(&turns.1);
            match block.holds {
                Holds::Frame => hold_frames(block, (&a, &b), &turns.0, &turn, implicit, h),
                Holds::Axis | Holds::Points => hold_axes(block, (&a, &b), &turns.0, &turn, implicit, h),
            }
        }
    }
}

/// |r| tr(I⁻¹ across r), as `turning_ease` of one body.
#[inline(always)]
pub(crate) fn turning_ease<W: Wide>(side: &WideVelocities<W>, lever: Wide3<W>) -> W {
    let squared = lever.dot(lever);
    let ease = squared * side.inverse_inertia.trace() - lever.dot(side.response(lever));
    W::select(squared.above(W::zero()), ease / squared.sqrt(), W::zero())
}

/// Where between start and end of the substep gradients are taken at this transverse stiffness κ.
#[inline(always)]
pub(crate) fn implicit_share<W: Wide>(stiffness: W) -> W {
    let span = W::splat(1.0 / (IMPLICIT_RANGE.1 - IMPLICIT_RANGE.0));
    ((stiffness - W::splat(IMPLICIT_RANGE.0)) * span).max(W::zero()).min(W::splat(1.0))
}

/// Rows that bring the joint points together; returns where between start and end of the substep the gradients are taken.
#[inline(always)]
fn hold_points<W: Wide>(
    block: &mut PointBlock,
    (a, b): (&WideVelocities<W>, &WideVelocities<W>),
    turns: (&WideQuat<W>, &WideQuat<W>),
    h: f32,
) -> W {
    let (lever_a, lever_b) = (Wide3::load(&block.lever[0]), Wide3::load(&block.lever[1]));
    let gap = Wide3::load(&block.gap);
    let (way_a, way_b) = (turns.0.way_of(lever_a), turns.1.way_of(lever_b));

    let tension = Wide3::<W>::load(&block.impulse);
    let stiffness = W::splat(h) * tension.dot(tension).sqrt() * (turning_ease(a, lever_a) + turning_ease(b, lever_b));
    let implicit = implicit_share(stiffness);

    let drift = (b.linear - a.linear) * W::splat(h) + (way_b - way_a);
    let half_gap = (gap + drift * implicit) * W::splat(0.5);
    let arm_a = lever_a + way_a * implicit + half_gap;
    let arm_b = lever_b + way_b * implicit - half_gap;

    let gamma = W::load(&block.give.gamma);
    let k = a.response_at(arm_a) + b.response_at(arm_b);
    let mass = k.plus_diagonal(Wide3::new(gamma, gamma, gamma)).inverse_where_it_moves();
    // (C* − C₀)/h − J v*: the velocities of the centres of mass cancel.
    let curvature = (way_b - way_a) * W::splat(1.0 / h) - (b.angular.cross(arm_b) - a.angular.cross(arm_a));
    let bias = curvature * W::load(&block.give.share) + gap * W::load(&block.give.start);

    arm_a.store(&mut block.arm[0]);
    arm_b.store(&mut block.arm[1]);
    mass.store(&mut block.mass);
    bias.store(&mut block.bias);
    implicit
}

/// Rows that turn B's frame onto A's: with g the rotation from A's to B's and ε + 1 that of B against A, δg = ε g.
#[inline(always)]
fn hold_frames<W: Wide>(
    block: &mut DirectionBlock,
    (a, b): (&WideVelocities<W>, &WideVelocities<W>),
    turn_a: &WideQuat<W>,
    turn: &WideQuat<W>,
    implicit: W,
    h: f32,
) {
    let relative = WideQuat::<W>::load(&block.relative);
    let less = -turn.v.dot(turn.v) / (W::splat(1.0) + turn.w);
    let way = relative.v * less + turn.v * relative.w + turn.v.cross(relative.v);
    let start = Wide3::load(&block.error);
    let arc = full_arc(relative.v + way);
    let change = way * arc + relative.v * (arc - W::load(&block.arc));

    let gamma = W::load(&block.give.gamma);
    let k = a.inverse_inertia + b.inverse_inertia;
    k.plus_diagonal(Wide3::new(gamma, gamma, gamma)).inverse_where_it_moves().store(&mut block.mass);
    let (change, start) = (eased(turn_a, change, implicit), eased(turn_a, start, implicit));
    let curvature = change * W::splat(1.0 / h) - (b.angular - a.angular);
    (curvature * W::load(&block.give.share) + start * W::load(&block.give.start)).store(&mut block.bias);
}

/// Rows that turn B's axis onto A's.
#[inline(always)]
fn hold_axes<W: Wide>(
    block: &mut DirectionBlock,
    (a, b): (&WideVelocities<W>, &WideVelocities<W>),
    turn_a: &WideQuat<W>,
    turn: &WideQuat<W>,
    implicit: W,
    h: f32,
) {
    let (axis_a, axis_b) = (Wide3::<W>::load(&block.axis[0]), Wide3::load(&block.axis[1]));
    let way = turn.way_of(axis_b);
    let across = axis_a.cross(axis_b);
    let way_across = axis_a.cross(way);
    let arc = arc_between(across + way_across, axis_a.dot(axis_b + way));
    let change = way_across * arc + across * (arc - W::load(&block.arc));

    let axis = eased(turn_a, axis_a, implicit);
    let axis = axis * (W::splat(1.0) / axis.dot(axis).sqrt());
    let gamma = W::load(&block.give.gamma);
    let k = a.inverse_inertia + b.inverse_inertia;
    k.plus_diagonal(Wide3::new(gamma, gamma, gamma)).inverse_across(axis).store(&mut block.mass);
    let (change, start) = (eased(turn_a, change, implicit), eased(turn_a, Wide3::load(&block.error), implicit));
    let curvature = change * W::splat(1.0 / h) - (b.angular - a.angular);
    let bias = curvature * W::load(&block.give.share) + start * W::load(&block.give.start);
    across_axis(axis, bias).store(&mut block.bias);
    across_axis(axis, Wide3::load(&block.impulse)).store(&mut block.impulse);
    axis.store(&mut block.free_axis);
}

/// `v`, fixed in A, where the gradients are taken.
#[inline(always)]
fn eased<W: Wide>(turn_a: &WideQuat<W>, v: Wide3<W>, implicit: W) -> Wide3<W> {
    v + turn_a.way_of(v) * implicit
}

#[inline(always)]
fn across_axis<W: Wide>(axis: Wide3<W>, v: Wide3<W>) -> Wide3<W> {
    v - axis * axis.dot(v)
}
