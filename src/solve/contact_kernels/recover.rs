//! Restitution after each substep, and position recovery after the last.

#![expect(clippy::needless_range_loop, reason = "an index runs over points and lanes of several arrays alike")]

use super::super::body_gather::WideVelocities;
use super::super::contact::{LANES, POINTS};
use super::super::contact_block::{ContactBlocks, MaterialRows};
use super::super::contact_partition::BlockPart;
use super::super::disjoint::DisjointMut;
use super::super::recovery::NEGLIGIBLE_OVERLAP;
use super::super::state::{BodyMotion, BodyVelocity};
use super::rows::{BlockManifolds, Faced, Single, lambdas, normal_rates, of_block, push_apart, separations, store_lambdas};
use crate::lanes::wide::Wide;

/// Share of an overlap that is taken out in one step.
const RECOVERY_SHARE: f32 = 0.2;

/// Greatest speed at which an overlap is taken out (m/s).
pub(super) const MAX_RECOVERY_SPEED: f32 = 0.9;

/// Sweeps of position recovery in a step.
pub(crate) const RECOVERY_SWEEPS: usize = 2;

/// How far the surfaces at a point with this separation (m) may come together, if not negative, or are to come apart in a step (m).
pub(crate) fn asked_by_recovery(separation: f32, dt: f32) -> f32 {
    match separation {
        s if s < -NEGLIGIBLE_OVERLAP => (RECOVERY_SHARE * s).max(-MAX_RECOVERY_SPEED * dt),
        s => s.max(0.0),
    }
}

#[inline(always)]
pub(super) fn restitute<W: Wide>(contacts: &mut ContactBlocks, velocities: &mut [BodyVelocity], threshold: f32) {
    let ContactBlocks { blocks, faces, extras, .. } = contacts;
    if extras.is_empty() {
        return;
    }
    for block in blocks {
        let Some(extra) = extras.get_mut(block.extra as usize).filter(|extra| extra.has_restitution) else { continue };
        of_block!(rebound::<W>(block, (faces, 0), extra, velocities, threshold));
    }
}

#[inline(always)]
fn rebound<W: Wide, M: BlockManifolds>(of: &mut M, extra: &mut MaterialRows, velocities: &mut [BodyVelocity], threshold: f32) {
    let (a, b) = (&of.block().a, &of.block().b);
    let (mut side_a, mut side_b) = (WideVelocities::<W>::gather(a, velocities), WideVelocities::gather(b, velocities));
    let mut rebound = [[0.0; LANES]; POINTS];
    let mut any = [0.0; LANES];
    for l in 0..LANES {
        for i in 0..M::COUNT {
            if extra.impact_speed[i][l] < -threshold && of.rows(i).lambda[l] > 0.0 {
                rebound[i][l] = extra.restitution[l] * extra.impact_speed[i][l];
                any[l] = 1.0;
                extra.rebounds[l] = true;
            }
        }
    }
    if any == [0.0; LANES] {
        return;
    }
    let mut residual = normal_rates::<W, M>(of, &side_a, &side_b);
    for i in 0..M::COUNT {
        residual[i] = residual[i] + W::load(&rebound[i]);
    }
    let old = lambdas::<W, M>(of);
    let mut new = of.solve(residual, &old);
    let any = W::load(&any).above(W::zero());
    let mut sum = W::zero();
    for i in 0..M::COUNT {
        new[i] = W::select(any, new[i], old[i]);
        sum = sum + new[i];
    }
    W::select(any, sum, W::load(&extra.blow)).store(&mut extra.blow);
    push_apart::<W, M>(of, &new, &old, &mut side_a, &mut side_b);
    side_a.scatter(&of.block().a, velocities);
    side_b.scatter(&of.block().b, velocities);
    store_lambdas::<W, M>(&new, of);
}

#[inline(always)]
pub(super) fn end_step<W: Wide>(part: &mut BlockPart<'_>, motions: &[BodyMotion]) -> f32 {
    let BlockPart { blocks, faces, before, .. } = part;
    let mut deepest = W::zero();
    for block in blocks.iter_mut() {
        // In this order what is not a number is passed over, and so the parts into which blocks are cut do not matter.
        deepest = of_block!(follow::<W>(block, (faces, before[0]), motions)).max(deepest);
    }
    greatest(deepest)
}

#[inline(always)]
pub(super) fn begin<W: Wide>(
    part: &mut BlockPart<'_>,
    motions: &[BodyMotion],
    pushes: &mut DisjointMut<'_, BodyVelocity>,
    dt: f32,
) -> f32 {
    let mut deepest = W::zero();
    for number in 0..part.blocks.len() {
        part.ask_for_next(number, false);
        let BlockPart { blocks, faces, before, .. } = part;
        let block = &mut blocks[number];
        deepest = of_block!(follow_and_part::<W>(block, (faces, before[0]), motions, pushes, dt)).max(deepest);
    }
    greatest(deepest)
}

#[inline(always)]
fn greatest<W: Wide>(of: W) -> f32 {
    let mut lanes = [0.0; LANES];
    of.store(&mut lanes);
    lanes.into_iter().fold(0.0, f32::max)
}

#[inline(always)]
fn follow_and_part<W: Wide, M: BlockManifolds>(
    of: &mut M,
    motions: &[BodyMotion],
    pushes: &mut DisjointMut<'_, BodyVelocity>,
    dt: f32,
) -> W {
    let deepest = follow::<W, M>(of, motions);
    part_overlaps::<W, M>(of, pushes, dt);
    deepest
}

/// Brings the separations of a block up to date, and begins its recovery with nothing; greatest overlap of each lane (m).
#[inline(always)]
fn follow<W: Wide, M: BlockManifolds>(of: &mut M, motions: &[BodyMotion]) -> W {
    let separation = separations::<W, M>(of, motions);
    let mut deepest = W::zero();
    for i in 0..M::COUNT {
        let rows = of.rows_mut(i);
        let exists = W::load(&rows.inverse_diagonal).above(W::zero());
        deepest = W::select(exists, -separation[i], W::zero()).max(deepest);
        separation[i].store(&mut rows.separation);
        W::zero().store(&mut rows.closing_speed);
    }
    deepest
}

#[inline(always)]
pub(super) fn all<W: Wide>(part: &mut BlockPart<'_>, pushes: &mut DisjointMut<'_, BodyVelocity>, dt: f32) {
    for number in 0..part.blocks.len() {
        part.ask_for_next(number, false);
        let BlockPart { blocks, faces, before, .. } = part;
        let block = &mut blocks[number];
        of_block!(part_overlaps::<W>(block, (faces, before[0]), pushes, dt));
    }
}

#[inline(always)]
fn part_overlaps<W: Wide, M: BlockManifolds>(of: &mut M, pushes: &mut DisjointMut<'_, BodyVelocity>, dt: f32) {
    let (a, b) = (&of.block().a, &of.block().b);
    let (mut side_a, mut side_b) = (WideVelocities::<W>::gather(a, pushes), WideVelocities::gather(b, pushes));
    let mut residual = normal_rates::<W, M>(of, &side_a, &side_b);
    let mut old = [W::zero(); POINTS];
    for i in 0..M::COUNT {
        old[i] = W::load(&of.rows(i).closing_speed);
        // Below what is worth a push there is none, so that no island is pushed because another in its batch is.
        let s = W::load(&of.rows(i).separation);
        let s = W::select((-s).above(W::splat(NEGLIGIBLE_OVERLAP)), s, s.max(W::zero()));
        let apart = (W::splat(RECOVERY_SHARE) * s).max(W::splat(-MAX_RECOVERY_SPEED * dt));
        residual[i] = residual[i] + W::select(W::zero().above(s), apart, s);
    }
    let new = of.solve(residual, &old);
    push_apart::<W, M>(of, &new, &old, &mut side_a, &mut side_b);
    side_a.scatter(&of.block().a, pushes);
    side_b.scatter(&of.block().b, pushes);
    for i in 0..M::COUNT {
        new[i].store(&mut of.rows_mut(i).closing_speed);
    }
}
