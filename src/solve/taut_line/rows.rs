//! Rows across the line of a taut bound.

use glam::Vec3;

use super::{LANES, Lane, MAX_LENS, NEARLY_STRAIGHT, TautBlock, TautLine, response_at};
use crate::lanes::wide::{Wide, Wide3};
use crate::solve::body_gather::{WideMotion, WideVelocities};
use crate::solve::integrate::PredictedPose;
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::solve::wide_matrix::Wide6;

/// Where the joints are, seen from the line.
pub(super) struct LineLevers<W: Wide> {
    pub levers: Wide3<W>,
    /// Along the line, over its length.
    pub share: W,
    /// Off the line (m).
    pub off: Wide3<W>,
    /// How far off it may be (m), and where that is known: where the line is all but straight.
    pub lens: W,
    pub known: W::Mask,
}

impl<W: Wide> LineLevers<W> {
    #[inline(always)]
    pub fn of(block: &TautBlock, place: &WideMotion<W>, line: &TautLine) -> Self {
        let levers = place.rotation.rotate(Wide3::load(&block.local));
        let near = Wide3::splat(line.near + line.levers[0]);
        let point = Wide3::load(&block.offset) + place.displacement + levers - near;
        let along = Wide3::splat(line.along);
        let (before, after, length) = (W::load(&block.before), W::load(&block.after), W::splat(line.length));
        let foot = (length * length + before * before - after * after) / (length + length);
        let lens = (before * before - foot * foot).max(W::zero()).sqrt();
        let reached = along.dot(point);
        // Unused lanes are nowhere along the line.
        let most = W::select(before.above(W::zero()), W::splat(MAX_LENS) * length, W::splat(-1.0));
        let known = most.above(lens);
        Self { levers, share: reached / length, off: point - along * reached, lens, known }
    }
}

/// J M⁻¹ Jᵀ of `count` rows that share their ends, inverted across the line.
#[inline(always)]
pub(super) fn masses<W: Wide>(
    sight: &LineLevers<W>,
    own: &WideVelocities<W>,
    ends: [&BodyVelocity; 2],
    line: &TautLine,
    count: usize,
) -> Wide6<W> {
    let (near, far) = (response_at(ends[0], line.levers[0]), response_at(ends[1], line.levers[1]));
    let near_share = W::splat(1.0) - sight.share;
    let sharers = W::splat(count as f32);
    let k = own.response_at(sight.levers)
        + Wide6::splat(&near).scaled(near_share * near_share * sharers)
        + Wide6::splat(&far).scaled(sight.share * sight.share * sharers);
    k.inverse_across(Wide3::splat(line.along))
}

/// Lanes in which `x` is positive.
pub(super) fn positive(x: &Lane) -> usize {
    x.iter().filter(|&&x| x > 0.0).count()
}

pub(super) fn velocity_at(body: &BodyVelocity, lever: Vec3) -> Vec3 {
    body.linear + body.angular.cross(lever)
}

#[inline(always)]
pub(super) fn prepare<W: Wide>(
    block: &mut TautBlock,
    start: &TautLine,
    end: &TautLine,
    velocities: &[BodyVelocity],
    motions: &[BodyMotion],
    predicted_poses: &[PredictedPose],
    h: f32,
) {
    let sight = LineLevers::of(block, &WideMotion::<W>::then(&block.slots, predicted_poses), end);
    let before = LineLevers::of(block, &WideMotion::<W>::now(&block.slots, motions), start);
    // An error that was there before is left to the position rows.
    let most = sight.lens.max(before.off.length());
    let excess = sight.off - sight.off.shortened(most);
    let size = excess.length();
    let zero = W::zero();
    let allowed = W::select(sight.known, W::splat(NEARLY_STRAIGHT) * W::load(&block.before), W::splat(-1.0));
    let present = W::select(size.above(allowed), zero, size);
    let mut lanes = [0.0; LANES];
    present.store(&mut lanes);
    let count = positive(&lanes);
    block.acts = count > 0;
    if !block.acts {
        return;
    }
    let present = present.above(zero);
    let own = WideVelocities::<W>::gather(&block.slots, velocities);
    let ends = block.ends.slots.map(|slot| &velocities[slot as usize]);
    let mass = masses(&sight, &own, ends, end, count).scaled(W::select(present, W::splat(1.0), zero));
    let (near, far) = (Wide3::splat(velocity_at(ends[0], end.levers[0])), Wide3::splat(velocity_at(ends[1], end.levers[1])));
    let along = Wide3::splat(end.along);
    let rate = own.linear + own.angular.cross(sight.levers) - near * (W::splat(1.0) - sight.share) - far * sight.share;
    let bias = excess * W::splat(1.0 / h) - (rate - along * along.dot(rate));
    (block.along, block.arm) = (end.along, end.levers);
    sight.levers.store(&mut block.own_arm);
    (-sight.share).store(&mut block.far_share);
    mass.store(&mut block.mass);
    bias.only(present).store(&mut block.bias);
    block.impulse = [[0.0; LANES]; 3];
}
