//! After the substeps: rebounds, and overlaps out of positions.

#![expect(clippy::needless_range_loop, reason = "an index runs over points and lanes of several arrays alike")]

use super::super::contact::{ContactBlock, LANES, Lane, POINTS};
use super::super::side::Side;
use super::super::state::{BodyMotion, BodyVelocity};
use super::super::wide::Wide;
use super::rows::{load_points, normal_rates, push_apart, separations, solve_manifolds, store_points};

/// Share of an overlap that is taken out in one step.
const RECOVERY_SHARE: f32 = 0.2;

/// Greatest speed at which an overlap is taken out (m/s).
pub(super) const MAX_RECOVERY_SPEED: f32 = 0.9;

/// Sweeps of position recovery in a step.
pub(crate) const RECOVERY_SWEEPS: usize = 2;

#[inline(always)]
pub(super) fn restitute<W: Wide>(blocks: &mut [ContactBlock], velocities: &mut [BodyVelocity], threshold: f32) {
    for block in blocks.iter_mut().filter(|block| block.has_restitution) {
        let (mut side_a, mut side_b) = (Side::<W>::gather(&block.a, velocities), Side::gather(&block.b, velocities));
        let mut rebound = [[0.0; LANES]; POINTS];
        let mut any = [0.0; LANES];
        for l in 0..LANES {
            for i in 0..POINTS {
                if block.impact_speed[i][l] < -threshold && block.peak_lambda[i][l] > 0.0 {
                    rebound[i][l] = block.restitution[l] * block.impact_speed[i][l];
                    any[l] = 1.0;
                }
            }
        }
        let mut residual = normal_rates::<W, POINTS>(block, &side_a, &side_b);
        for i in 0..POINTS {
            residual[i] = residual[i] + W::load(&rebound[i]);
        }
        let old = load_points::<W>(&block.lambda);
        let mut new = solve_manifolds::<W, POINTS>(block, residual, &old);
        let any = W::load(&any).above(W::zero());
        for i in 0..POINTS {
            new[i] = W::select(any, new[i], old[i]);
        }
        push_apart::<W, POINTS>(block, &new, &old, &mut side_a, &mut side_b);
        side_a.scatter(&block.a, velocities);
        side_b.scatter(&block.b, velocities);
        store_points::<W, POINTS>(&new, &mut block.lambda);
    }
}

#[inline(always)]
pub(super) fn end_step<W: Wide>(blocks: &mut [ContactBlock], motions: &[BodyMotion], worst: &mut f32) {
    let zero = W::zero();
    let mut deepest = zero;
    for block in blocks {
        let separation = separations::<W, POINTS>(block, motions);
        for i in 0..POINTS {
            let exists = W::load(&block.inverse_diagonal[i]).above(zero);
            deepest = deepest.max(W::select(exists, -separation[i], zero));
        }
        store_points::<W, POINTS>(&separation, &mut block.separation);
    }
    let mut lanes = [0.0; LANES];
    deepest.store(&mut lanes);
    *worst = lanes.iter().fold(*worst, |worst, &overlap| worst.max(overlap));
}

#[inline(always)]
pub(super) fn all<W: Wide>(blocks: &[ContactBlock], lambdas: &mut [[Lane; POINTS]], pushes: &mut [BodyVelocity], dt: f32) {
    for (block, lambda) in blocks.iter().zip(lambdas) {
        if block.has_faces {
            part_overlaps::<W, POINTS>(block, lambda, pushes, dt);
        } else {
            part_overlaps::<W, 1>(block, lambda, pushes, dt);
        }
    }
}

#[inline(always)]
fn part_overlaps<W: Wide, const N: usize>(
    block: &ContactBlock,
    lambda: &mut [Lane; POINTS],
    pushes: &mut [BodyVelocity],
    dt: f32,
) {
    let (mut side_a, mut side_b) = (Side::<W>::gather(&block.a, pushes), Side::gather(&block.b, pushes));
    let mut residual = normal_rates::<W, N>(block, &side_a, &side_b);
    for i in 0..N {
        let s = W::load(&block.separation[i]);
        let apart = (W::splat(RECOVERY_SHARE) * s).max(W::splat(-MAX_RECOVERY_SPEED * dt));
        residual[i] = residual[i] + W::select(W::zero().above(s), apart, s);
    }
    let old = load_points::<W>(lambda);
    let new = solve_manifolds::<W, N>(block, residual, &old);
    push_apart::<W, N>(block, &new, &old, &mut side_a, &mut side_b);
    side_a.scatter(&block.a, pushes);
    side_b.scatter(&block.b, pushes);
    store_points::<W, N>(&new, lambda);
}
