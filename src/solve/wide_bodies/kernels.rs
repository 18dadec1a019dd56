//! Kernels over a block of bodies: forces, limits, prediction, motion.

use super::PoseBlock;
use super::turn::turn;
use crate::lanes::wide::{Wide, Wide3};
use crate::linalg::rotation32::{NEGLIGIBLE_SPEED, NEGLIGIBLE_WAY};
use crate::solve::body_gather::{WidePoses, WideVelocities, gather_rotations, scatter_outlooks};
use crate::solve::contact::{LANES, Lane};
use crate::solve::disjoint::{DisjointMut, Slots};
use crate::solve::integrate::{PredictedPose, SAFE_TUMBLE, SPLIT_TUMBLE};
use crate::solve::rotation::{self, MAX_TURN};
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::solve::wide_matrix::{Wide6, WideQuat};
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};

/// Turn of a substep beyond which the rules for lanes say nothing (rad).
const FAR_TURN: f32 = 2.0 * MAX_TURN;

/// Growth of what a body has by turning that is let be: rounding of `f32`.
pub(in crate::solve) const TURNING_LET_BE: f32 = 1.0 + 1.0e-5;

/// Sine of half the angle by which position rows may turn a body without a look at its energy: next to rounding.
const NEGLIGIBLE_TURN: f32 = 1.0e-6;

#[inline(always)]
pub(super) fn apply_forces<W: Wide>(
    blocks: &[PoseBlock],
    velocities: &mut (impl Slots<BodyVelocity> + ?Sized),
    motions: &[BodyMotion],
    energies: &mut (impl Slots<f32> + ?Sized),
    h: f32,
) {
    for block in blocks {
        let mut side = WideVelocities::<W>::gather(&block.slots, velocities);
        let axes = gather_rotations(&block.slots, motions).after(&WideQuat::load(&block.frame)).axes();
        refresh_inertia(block, &mut side, &axes, h);
        side.linear = (side.linear + Wide3::load(&block.gain)) * W::load(&block.left[0]);
        side.turn(Wide3::load(&block.torque));
        side.angular = side.angular * W::load(&block.left[1]);
        store_energies(block, &side, &axes, energies);
        side.scatter_whole(&block.slots, velocities);
    }
}

/// Forms the world inertia, no axis lighter than what the whole turn of the body smears it to; bodies one by one go by the turn of each axis.
#[inline(always)]
fn refresh_inertia<W: Wide>(block: &PoseBlock, side: &mut WideVelocities<W>, axes: &[Wide3<W>; 3], h: f32) {
    let one = W::splat(1.0);
    let way = side.angular * W::splat(h);
    let inertia = Wide3::<W>::load(&block.inertia);
    let least = inertia.x.max(inertia.y).max(inertia.z) * way.dot(way).min(one);
    let ease = Wide3::new(one / inertia.x.max(least), one / inertia.y.max(least), one / inertia.z.max(least));
    let fresh = Wide6::with_axes(axes, ease);
    let tumbles = W::load(&block.tumbles).above(W::zero());
    side.inverse_inertia = Wide6::select(tumbles, fresh, side.inverse_inertia);
}

#[inline(always)]
pub(super) fn find_inertia<W: Wide>(blocks: &[PoseBlock], motions: &[BodyMotion], inertia: &mut [Lane]) {
    for block in blocks {
        let frame = gather_rotations::<W>(&block.slots, motions).after(&WideQuat::load(&block.frame));
        let [xx, yy, zz, xy, xz, yz] = Wide6::with_axes(&frame.axes(), Wide3::load(&block.inertia)).0;
        let rows = W::transpose([xx, yy, zz, xy, xz, yz, W::zero(), W::zero()]);
        for l in 0..LANES {
            rows[l].store(&mut inertia[block.slots[l] as usize]);
        }
    }
}

#[inline(always)]
pub(super) fn find_energies<W: Wide>(
    blocks: &[PoseBlock],
    velocities: &[BodyVelocity],
    motions: &[BodyMotion],
    energies: &mut (impl Slots<f32> + ?Sized),
) {
    for block in blocks {
        let side = WideVelocities::<W>::gather(&block.slots, velocities);
        let axes = gather_rotations(&block.slots, motions).after(&WideQuat::load(&block.frame)).axes();
        store_energies(block, &side, &axes, energies);
    }
}

/// Kinetic energies of a block, its principal axes being these.
#[inline(always)]
fn store_energies<W: Wide>(
    block: &PoseBlock,
    side: &WideVelocities<W>,
    axes: &[Wide3<W>; 3],
    energies: &mut (impl Slots<f32> + ?Sized),
) {
    let spin = Wide3::new(axes[0].dot(side.angular), axes[1].dot(side.angular), axes[2].dot(side.angular));
    let turning = spin.scale(spin).dot(Wide3::load(&block.inertia));
    let energy = (side.linear.dot(side.linear) / side.inverse_mass().x + turning) * W::splat(0.5);
    let mut lanes = [0.0; LANES];
    energy.store(&mut lanes);
    for (&slot, energy) in block.slots.iter().zip(lanes).take(block.count as usize) {
        *energies.get_mut(slot) = energy;
    }
}

/// Twice what bodies have by turning at these velocities when they stand so (J).
#[inline(always)]
fn turning_energy<W: Wide>(block: &PoseBlock, angular: Wide3<W>, rotation: &WideQuat<W>) -> W {
    let axes = rotation.after(&WideQuat::load(&block.frame)).axes();
    let spin = Wide3::new(axes[0].dot(angular), axes[1].dot(angular), axes[2].dot(angular));
    spin.scale(spin).dot(Wide3::load(&block.inertia))
}

/// Turns the angular velocity with the body where that has been turned from how it was noted to stand and has more energy for it.
#[inline(always)]
pub(super) fn keep_turning<W: Wide>(
    blocks: &[PoseBlock],
    velocities: &mut (impl Slots<BodyVelocity> + ?Sized),
    motions: &[BodyMotion],
    noted: &[[f32; LANES]],
) {
    for block in blocks {
        let now = gather_rotations::<W>(&block.slots, motions);
        let [x, y, z, w, ..] = W::transpose(block.slots.map(|slot| W::load(&noted[slot as usize])));
        let then = WideQuat { v: Wide3::new(x, y, z), w };
        let turn = now.after(&then.conjugate());
        let has_turned = turn.v.length().above(W::splat(NEGLIGIBLE_TURN));
        if !W::any(has_turned) {
            continue;
        }
        let mut side = WideVelocities::<W>::gather(&block.slots, velocities);
        let before = turning_energy(block, side.angular, &then) * W::splat(TURNING_LET_BE);
        // What was not noted has not been turned.
        let grown = W::select(has_turned, turning_energy(block, side.angular, &now), W::zero()).above(before);
        if W::any(grown) {
            let turned = turn.rotate(side.angular);
            let choose = |turned: W, left: W| W::select(grown, turned, left);
            let left = side.angular;
            side.angular = Wide3::new(choose(turned.x, left.x), choose(turned.y, left.y), choose(turned.z, left.z));
            side.scatter(&block.slots, velocities);
        }
    }
}

#[inline(always)]
pub(super) fn limit<W: Wide>(blocks: &[PoseBlock], velocities: &mut (impl Slots<BodyVelocity> + ?Sized)) {
    for block in blocks {
        let mut side = WideVelocities::<W>::gather(&block.slots, velocities);
        limit_speeds(&mut side);
        side.scatter(&block.slots, velocities);
    }
}

#[inline(always)]
fn limit_speeds<W: Wide>(side: &mut WideVelocities<W>) {
    side.linear = side.linear.shortened(W::splat(MAX_LINEAR_SPEED)).settled(NEGLIGIBLE_SPEED);
    side.angular = side.angular.shortened(W::splat(MAX_ANGULAR_SPEED)).settled(NEGLIGIBLE_SPEED);
}

#[inline(always)]
pub(super) fn predict<W: Wide>(
    blocks: &[PoseBlock],
    velocities: &[BodyVelocity],
    motions: &[BodyMotion],
    predicted_poses: &mut (impl Slots<PredictedPose> + ?Sized),
    refused: &mut Vec<u32>,
    h: f32,
) {
    for block in blocks {
        let side = WideVelocities::<W>::gather(&block.slots, velocities);
        let stand = WidePoses::<W>::gather(&block.slots, motions);
        let turned = turn(block, &stand.rotation, side.angular, h, SPLIT_TUMBLE);
        let displacement = stand.displacement + side.linear * W::splat(h);
        let rotation = turned.turn.after(&stand.rotation).normalized();
        scatter_outlooks(&block.slots, &turned.turn, displacement, &rotation, predicted_poses);
        let far = is_far(block, side.angular * W::splat(h));
        note_refused(block, turned.gains.max(far), refused);
    }
}

#[inline(always)]
pub(super) fn advance<W: Wide>(
    blocks: &[PoseBlock],
    velocities: &mut DisjointMut<'_, BodyVelocity>,
    motions: &mut DisjointMut<'_, BodyMotion>,
    refused: &mut Vec<u32>,
    h: f32,
) {
    for block in blocks {
        let mut side = WideVelocities::<W>::gather(&block.slots, velocities);
        let mut stand = WidePoses::<W>::gather(&block.slots, motions);
        limit_speeds(&mut side);
        let turned = turn(block, &stand.rotation, side.angular, h, rotation::SPLIT_TUMBLE as f32);
        let mean = side.angular + turned.mean_change;
        // A needle may go around several times and have a mean that looks small.
        let overflows = (side.angular.length() * W::splat(h)).above(W::splat(FAR_TURN));
        let far = W::select(overflows, W::splat(1.0), is_far(block, mean * W::splat(h)));
        let refuses = turned.gains.max(far);
        let moves = W::zero().above(refuses - W::splat(0.5));
        let rotation = turned.turn.after(&stand.rotation).settled(NEGLIGIBLE_WAY).normalized();
        stand.displacement = stand.displacement + (side.linear * W::splat(h)).only(moves);
        stand.turn = stand.turn + (mean * W::splat(h)).only(moves);
        let is_turned = W::select(moves, side.angular.dot(side.angular), W::zero()).above(W::zero());
        stand.rotation = WideQuat::select(is_turned, rotation, stand.rotation);
        side.angular = side.angular + turned.change.only(moves);
        stand.scatter(&block.slots, motions);
        side.scatter(&block.slots, velocities);
        note_refused(block, refuses, refused);
    }
}

/// 1 where a body turns by more than the rules for lanes are good for. Powers of a turn far beyond that overflow: what is no number is far too.
#[inline(always)]
fn is_far<W: Wide>(block: &PoseBlock, way: Wide3<W>) -> W {
    let most = W::select(W::load(&block.tumbles).above(W::zero()), W::splat(SAFE_TUMBLE), W::splat(MAX_TURN));
    W::select(most.above(way.length()), W::zero(), W::splat(1.0))
}

/// Lists the bodies of lanes above zero.
#[inline(always)]
fn note_refused<W: Wide>(block: &PoseBlock, refuses: W, refused: &mut Vec<u32>) {
    if W::any(refuses.above(W::zero())) {
        let mut lanes = [0.0; LANES];
        refuses.store(&mut lanes);
        refused.extend((0..block.count as usize).filter(|&l| lanes[l] > 0.0).map(|l| block.slots[l]));
    }
}
