//! Sweeps and position rows over the joints of one taut bound: their bodies in lanes, its ends by the sum.

use glam::Vec3;

use super::rows::{LineLevers, masses, positive, velocity_at};
use super::{LANES, Lane3, TautBlock, TautLine};
use crate::lanes::wide::{Wide, Wide3};
use crate::solve::body_gather::{WidePoses, WideVelocities};
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::solve::wide_matrix::Wide6;

/// What the near and the far end get of the impulses on the joints' bodies.
#[inline(always)]
fn reactions<W: Wide>(impulse: Wide3<W>, share: W) -> [Vec3; 2] {
    let mut lanes: [Lane3; 2] = [[[0.0; LANES]; 3]; 2];
    (impulse * (share - W::splat(1.0))).store(&mut lanes[0]);
    (impulse * -share).store(&mut lanes[1]);
    lanes.map(|of| Vec3::from_array(of.map(|lane| lane.iter().sum())))
}

#[inline(always)]
pub(super) fn sweep<W: Wide>(block: &mut TautBlock, velocities: &mut [BodyVelocity]) {
    let mut own = WideVelocities::<W>::gather(&block.slots, velocities);
    let slots = block.ends.slots.map(|slot| slot as usize);
    let (near, far) = (velocity_at(&velocities[slots[0]], block.arm[0]), velocity_at(&velocities[slots[1]], block.arm[1]));
    let (levers, share) = (Wide3::load(&block.own_arm), -W::load(&block.far_share));
    let rate = own.linear + own.angular.cross(levers) - Wide3::splat(near) * (W::splat(1.0) - share) - Wide3::splat(far) * share;
    let change = -Wide6::load(&block.mass).mul(rate + Wide3::load(&block.bias));
    (Wide3::load(&block.impulse) + change).store(&mut block.impulse);
    own.apply(change, levers.cross(change));
    own.scatter(&block.slots, velocities);
    for (i, impulse) in reactions(change, share).into_iter().enumerate() {
        velocities[slots[i]].apply(impulse, block.arm[i].cross(impulse));
    }
}

#[inline(always)]
pub(super) fn project<W: Wide>(
    block: &TautBlock,
    line: &TautLine,
    velocities: &[BodyVelocity],
    motions: &mut [BodyMotion],
    most: f32,
) {
    let mut stand = WidePoses::<W>::gather(&block.slots, motions);
    let sight = LineLevers::of(block, &stand.place(), line);
    let excess = (sight.off - sight.off.shortened(sight.lens)).only(sight.known);
    let mut sizes = [0.0; LANES];
    excess.length().store(&mut sizes);
    let count = positive(&sizes);
    if count == 0 {
        return;
    }
    let own = WideVelocities::<W>::gather(&block.slots, velocities);
    let slots = block.ends.slots.map(|slot| slot as usize);
    let mass = masses(&sight, &own, slots.map(|slot| &velocities[slot]), line, count);
    let impulse = -mass.mul(excess.shortened(W::splat(most)));
    let mut push = own.at_rest();
    push.apply(impulse, sight.levers.cross(impulse));
    stand.displace(push.linear, push.angular, crate::solve::state::MAX_PUSH_TURN);
    stand.scatter(&block.slots, motions);
    for (i, impulse) in reactions(impulse, sight.share).into_iter().enumerate() {
        let mut push = velocities[slots[i]].at_rest();
        push.apply(impulse, line.levers[i].cross(impulse));
        motions[slots[i]].displace(push.linear, push.angular);
    }
}
