//! Warm start and sweeps over blocks of bounds.

use super::rows::Gradient;
use super::{BoundBlock, Rows};
use crate::lanes::wide::{Wide, Wide3};
use crate::solve::body_gather::WideVelocities;
use crate::solve::state::BodyVelocity;

#[inline(always)]
fn gradient_of<W: Wide>(block: &BoundBlock) -> Gradient<W> {
    let arms = (Wide3::load(&block.arm[0]), Wide3::load(&block.arm[1]));
    Gradient { along: Wide3::load(&block.along), arms }
}

#[inline(always)]
pub(super) fn warm_start<W: Wide>(blocks: &[BoundBlock], velocities: &mut [BodyVelocity]) {
    for block in blocks.iter().filter(|block| block.is_taut()) {
        let (mut near, mut far) =
            (WideVelocities::<W>::gather(&block.near, velocities), WideVelocities::<W>::gather(&block.far, velocities));
        let impulse = W::load(&block.lower_rows.impulse) - W::load(&block.upper_rows.impulse);
        gradient_of(block).push(impulse, &mut near, &mut far);
        near.scatter(&block.near, velocities);
        far.scatter(&block.far, velocities);
    }
}

#[inline(always)]
pub(super) fn sweep<W: Wide>(blocks: &mut [BoundBlock], velocities: &mut [BodyVelocity], backwards: bool) {
    if backwards {
        for block in blocks.iter_mut().rev().filter(|block| block.is_taut()) {
            visit::<W>(block, velocities, true);
        }
    } else {
        for block in blocks.iter_mut().filter(|block| block.is_taut()) {
            visit::<W>(block, velocities, false);
        }
    }
}

#[inline(always)]
fn visit<W: Wide>(block: &mut BoundBlock, velocities: &mut [BodyVelocity], backwards: bool) {
    let (mut near, mut far) =
        (WideVelocities::<W>::gather(&block.near, velocities), WideVelocities::<W>::gather(&block.far, velocities));
    let gradient = gradient_of::<W>(block);
    if block.lower_rows.any && backwards {
        solve(&mut block.lower_rows, &gradient, W::splat(1.0), &mut near, &mut far);
    }
    if block.upper_rows.any {
        solve(&mut block.upper_rows, &gradient, W::splat(-1.0), &mut near, &mut far);
    }
    if block.lower_rows.any && !backwards {
        solve(&mut block.lower_rows, &gradient, W::splat(1.0), &mut near, &mut far);
    }
    near.scatter(&block.near, velocities);
    far.scatter(&block.far, velocities);
}

/// Rows whose coordinate is the distance times `sign` and a constant.
#[inline(always)]
fn solve<W: Wide>(rows: &mut Rows, gradient: &Gradient<W>, sign: W, near: &mut WideVelocities<W>, far: &mut WideVelocities<W>) {
    let impulse = W::load(&rows.impulse);
    let rate = gradient.rate(near, far) * sign;
    let residual = rate + W::load(&rows.bias) + W::load(&rows.gamma) * impulse;
    let new = (impulse - W::load(&rows.mass) * residual).max(W::zero());
    new.store(&mut rows.impulse);
    gradient.push((new - impulse) * sign, near, far);
}
