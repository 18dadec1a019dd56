//! Sweeps over blocks: directions, then points; backwards, points, then directions.

use super::{DirectionBlock, JointLanes, PointBlock};
use crate::lanes::wide::{Wide, Wide3};
use crate::solve::body_gather::WideVelocities;
use crate::solve::contact::Lane3;
use crate::solve::state::BodyVelocity;
use crate::solve::wide_matrix::Wide6;

#[inline(always)]
pub(super) fn warm_start<W: Wide>(lanes: &JointLanes, velocities: &mut [BodyVelocity]) {
    for block in &lanes.points {
        let torque = block.directions.map(|number| &lanes.directions[number as usize].impulse);
        apply::<W>(block, &block.impulse, torque, velocities);
    }
}

/// Applies multipliers of a block: those on its points, and those on its directions where it has any.
#[inline(always)]
pub(super) fn apply<W: Wide>(block: &PointBlock, impulse: &Lane3, torque: Option<&Lane3>, velocities: &mut [BodyVelocity]) {
    let (mut a, mut b) = (WideVelocities::<W>::gather(&block.a, velocities), WideVelocities::<W>::gather(&block.b, velocities));
    let impulse = Wide3::load(impulse);
    let (mut torque_a, mut torque_b) = (Wide3::load(&block.arm[0]).cross(impulse), Wide3::load(&block.arm[1]).cross(impulse));
    if let Some(torque) = torque {
        let torque = Wide3::load(torque);
        (torque_a, torque_b) = (torque_a + torque, torque_b + torque);
    }
    a.apply(-impulse, -torque_a);
    b.apply(impulse, torque_b);
    a.scatter(&block.a, velocities);
    b.scatter(&block.b, velocities);
}

#[inline(always)]
pub(super) fn sweep<W: Wide>(lanes: &mut JointLanes, start: usize, end: usize, velocities: &mut [BodyVelocity], backwards: bool) {
    let JointLanes { points, directions, .. } = lanes;
    for block in &mut points[start..end] {
        let (mut a, mut b) =
            (WideVelocities::<W>::gather(&block.a, velocities), WideVelocities::<W>::gather(&block.b, velocities));
        match block.directions {
            None => hold_points(block, &mut a, &mut b),
            Some(number) if backwards => {
                hold_points(block, &mut a, &mut b);
                hold_directions(&mut directions[number as usize], &mut a, &mut b);
            }
            Some(number) => {
                hold_directions(&mut directions[number as usize], &mut a, &mut b);
                hold_points(block, &mut a, &mut b);
            }
        }
        a.scatter(&block.a, velocities);
        b.scatter(&block.b, velocities);
    }
}

#[inline(always)]
fn hold_points<W: Wide>(block: &mut PointBlock, a: &mut WideVelocities<W>, b: &mut WideVelocities<W>) {
    let (arm_a, arm_b) = (Wide3::load(&block.arm[0]), Wide3::load(&block.arm[1]));
    let impulse = Wide3::load(&block.impulse);
    let rate = b.linear + b.angular.cross(arm_b) - a.linear - a.angular.cross(arm_a);
    let residual = rate + Wide3::load(&block.bias) + impulse * W::load(&block.give.gamma);
    let change = -Wide6::load(&block.mass).mul(residual);
    (impulse + change).store(&mut block.impulse);
    a.apply(-change, -arm_a.cross(change));
    b.apply(change, arm_b.cross(change));
}

#[inline(always)]
fn hold_directions<W: Wide>(block: &mut DirectionBlock, a: &mut WideVelocities<W>, b: &mut WideVelocities<W>) {
    let impulse = Wide3::load(&block.impulse);
    let residual = b.angular - a.angular + Wide3::load(&block.bias) + impulse * W::load(&block.give.gamma);
    let change = -Wide6::load(&block.mass).mul(residual);
    (impulse + change).store(&mut block.impulse);
    a.turn(-change);
    b.turn(change);
}

/// One sweep of displacements `pushes` (m, rad) that take the errors found at the substep's start out, each component at most `most`.
#[inline(always)]
pub(super) fn push<W: Wide>(
    lanes: &JointLanes,
    start: usize,
    end: usize,
    pushes: &mut [BodyVelocity],
    most: f32,
    backwards: bool,
) {
    for block in &lanes.points[start..end] {
        let (mut a, mut b) = (WideVelocities::<W>::gather(&block.a, pushes), WideVelocities::<W>::gather(&block.b, pushes));
        let directions = block.directions.map(|number| &lanes.directions[number as usize]);
        if let Some(directions) = directions.filter(|_| !backwards) {
            push_directions(directions, &mut a, &mut b, most);
        }
        let (arm_a, arm_b) = (Wide3::load(&block.arm[0]), Wide3::load(&block.arm[1]));
        let way = b.linear + b.angular.cross(arm_b) - a.linear - a.angular.cross(arm_a);
        let impulse = -Wide6::load(&block.mass).mul(way + Wide3::load(&block.gap).clamped(most));
        a.apply(-impulse, -arm_a.cross(impulse));
        b.apply(impulse, arm_b.cross(impulse));
        if let Some(directions) = directions.filter(|_| backwards) {
            push_directions(directions, &mut a, &mut b, most);
        }
        a.scatter(&block.a, pushes);
        b.scatter(&block.b, pushes);
    }
}

#[inline(always)]
fn push_directions<W: Wide>(block: &DirectionBlock, a: &mut WideVelocities<W>, b: &mut WideVelocities<W>, most: f32) {
    let error = Wide3::load(&block.error).clamped(most);
    let torque = -Wide6::load(&block.mass).mul(b.angular - a.angular + error);
    a.turn(-torque);
    b.turn(torque);
}
