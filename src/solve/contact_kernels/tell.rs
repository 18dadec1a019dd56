//! Contact status at the end of a step.

use super::super::body_gather::gather_velocities;
use super::super::contact::LANES;
use super::super::contact_block::ContactBlocks;
use super::super::state::BodyVelocity;
use super::super::status::{ContactStatus, StatusThresholds};
use super::rows::{BlockManifolds, Faced, Single, of_block};
use crate::lanes::wide::{Wide, Wide3};

#[inline(always)]
pub(super) fn all<W: Wide>(
    contacts: &mut ContactBlocks,
    velocities: &[BodyVelocity],
    limits: &StatusThresholds,
    told: &mut Vec<[ContactStatus; LANES]>,
) {
    let ContactBlocks { blocks, faces, .. } = contacts;
    for block in blocks {
        told.push(of_block!(words_of::<W>(block, (faces, 0), velocities, limits)));
    }
}

#[inline(always)]
fn words_of<W: Wide, M: BlockManifolds>(
    of: &mut M,
    velocities: &[BodyVelocity],
    limits: &StatusThresholds,
) -> [ContactStatus; LANES] {
    let block = of.block();
    let ((linear_a, angular_a), (linear_b, angular_b)) =
        (gather_velocities::<W>(&block.a, velocities), gather_velocities::<W>(&block.b, velocities));
    let (center_a, center_b) = of.centers::<W>();
    let n = Wide3::load(&block.normal);
    let turning = angular_b.cross(center_b) - angular_a.cross(center_a);
    let rate = linear_b - linear_a + turning;
    let approach = rate.dot(n);
    let slip = (rate - n * approach).length();
    let speed = slip.max(approach.abs());
    let zero = W::zero();
    let mut pressed = zero;
    for i in 0..M::COUNT {
        pressed = pressed + W::load(&of.rows(i).lambda);
    }
    let most = pressed * W::load(&block.friction) * W::splat(limits.reserve);
    let (t, u) = (W::load(&block.tangent_lambda[0]), W::load(&block.tangent_lambda[1]));
    let rise = n.dot(Wide3::splat(limits.up));
    let mut sum = W::splat(ContactStatus::KNOWN);
    for i in 0..2 {
        sum = sum + W::select(W::splat(limits.slips[i]).above(slip), W::splat(ContactStatus::SLIPS[i]), zero);
        sum = sum + W::select(W::splat(limits.speeds[i]).above(speed), W::splat(ContactStatus::SPEEDS[i]), zero);
    }
    sum = sum + W::select((most * most).above(t * t + u * u), W::splat(ContactStatus::RESERVE), zero);
    sum = sum + W::select(rise.above(W::splat(limits.rise)), W::splat(ContactStatus::RISES[0]), zero);
    sum = sum + W::select((-rise).above(W::splat(limits.rise)), W::splat(ContactStatus::RISES[1]), zero);
    let mut lanes = [0.0; LANES];
    sum.store(&mut lanes);
    let mut words = [ContactStatus::NOTHING; LANES];
    for l in 0..LANES {
        words[l] = ContactStatus::of(lanes[l]);
    }
    words
}
