//! Position correction of the rigid bounds of a block that acted in this substep.

use super::rows::BoundLevers;
use super::{BoundBlock, Rows};
use crate::lanes::wide::Wide;
use crate::solve::body_gather::{WidePoses, WideVelocities};
use crate::solve::state::{BodyMotion, BodyVelocity, MAX_PUSH_TURN};

/// Greatest displacement of a point by one position row in one substep, as a speed (m/s).
pub(super) const MAX_RECOVERY_SPEED: f32 = 10.0;

#[inline(always)]
pub(super) fn project<W: Wide>(blocks: &[BoundBlock], velocities: &[BodyVelocity], motions: &mut [BodyMotion], most: f32) {
    for block in blocks {
        if block.upper_rows.any {
            shift::<W>(block, &block.upper_rows, true, velocities, motions, most);
        }
        if block.lower_rows.any {
            shift::<W>(block, &block.lower_rows, false, velocities, motions, most);
        }
    }
}

#[inline(always)]
fn shift<W: Wide>(
    block: &BoundBlock,
    rows: &Rows,
    upper: bool,
    velocities: &[BodyVelocity],
    motions: &mut [BodyMotion],
    most: f32,
) {
    let zero = W::zero();
    let (mut near, mut far) = (WidePoses::<W>::gather(&block.near, motions), WidePoses::<W>::gather(&block.far, motions));
    let span = BoundLevers::of(block, &near.place(), &far.place());
    let length = span.gap.length();
    let (sign, error) =
        if upper { (W::splat(-1.0), W::load(&block.upper) - length) } else { (W::splat(1.0), length - W::load(&block.lower)) };
    let acts = W::load(&rows.present).min(W::load(&rows.rigid)).min(-error).above(zero);
    if !W::any(acts) {
        return;
    }
    let (near_side, far_side) =
        (WideVelocities::<W>::gather(&block.near, velocities), WideVelocities::<W>::gather(&block.far, velocities));
    let (mut near_push, mut far_push) = (near_side.at_rest(), far_side.at_rest());
    let gradient = span.gradient();
    let w = gradient.inverse_effective_mass(&near_side, &far_side);
    let impulse = -error.max(W::splat(-most)) / w;
    let impulse = W::select(acts, W::select(w.above(zero), impulse, zero), zero);
    gradient.push(impulse * sign, &mut near_push, &mut far_push);
    near.displace(near_push.linear, near_push.angular, MAX_PUSH_TURN);
    far.displace(far_push.linear, far_push.angular, MAX_PUSH_TURN);
    near.scatter(&block.near, motions);
    far.scatter(&block.far, motions);
}
