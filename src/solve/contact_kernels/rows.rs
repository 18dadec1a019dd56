//! What the kernels share: the bodies of a block in lanes, and its normal rows.

#![expect(clippy::needless_range_loop, reason = "an index runs over points and lanes of several arrays alike")]

use super::super::contact::{ContactBlock, Lane, POINTS};
use super::super::side::{Side, moved};
use super::super::state::BodyMotion;
use super::super::wide::{Wide, Wide3};

/// Sweeps over the 4×4 matrix of a manifold within one visit.
const INNER_SWEEPS: usize = 4;

/// One number for each point of each manifold.
pub(super) type Points<W> = [W; POINTS];

#[inline(always)]
pub(super) fn load_all<W: Wide, const N: usize>(lanes: &[Lane; N]) -> [W; N] {
    let mut all = [W::zero(); N];
    for i in 0..N {
        all[i] = W::load(&lanes[i]);
    }
    all
}

#[inline(always)]
pub(super) fn load_points<W: Wide>(lanes: &[Lane; POINTS]) -> Points<W> {
    load_all(lanes)
}

#[inline(always)]
fn product<W: Wide>(row: &Points<W>, column: &Points<W>) -> W {
    row[0] * column[0] + row[1] * column[1] + row[2] * column[2] + row[3] * column[3]
}

#[inline(always)]
pub(super) fn store_points<W: Wide, const N: usize>(points: &Points<W>, lanes: &mut [Lane; POINTS]) {
    for i in 0..N {
        points[i].store(&mut lanes[i]);
    }
}

/// Separation of the first `N` points with the bodies displaced as `motions` say (m).
#[inline(always)]
pub(super) fn separations<W: Wide, const N: usize>(block: &ContactBlock, motions: &[BodyMotion]) -> Points<W> {
    let (moved_a, turned_a) = moved::<W>(&block.a, motions);
    let (moved_b, turned_b) = moved::<W>(&block.b, motions);
    let n = Wide3::load(&block.normal);
    let shift = n.dot(moved_b - moved_a);
    let (axis_a, axis_b) = (n.cross(turned_a), n.cross(turned_b));
    let mut separation = load_points::<W>(&block.separation);
    for i in 0..N {
        // n·(θ×r) = r·(n×θ)
        let turning = Wide3::load(&block.lever_b[i]).dot(axis_b) - Wide3::load(&block.lever_a[i]).dot(axis_a);
        separation[i] = separation[i] + (shift + turning);
    }
    separation
}

/// J v of every normal row.
#[inline(always)]
pub(super) fn normal_rates<W: Wide, const N: usize>(block: &ContactBlock, side_a: &Side<W>, side_b: &Side<W>) -> Points<W> {
    let n = Wide3::load(&block.normal);
    let approach = n.dot(side_b.linear - side_a.linear);
    // n·(ω×r) = r·(n×ω)
    let (axis_a, axis_b) = (n.cross(side_a.angular), n.cross(side_b.angular));
    let mut rates = [W::zero(); POINTS];
    for i in 0..N {
        let turning = Wide3::load(&block.lever_b[i]).dot(axis_b) - Wide3::load(&block.lever_a[i]).dot(axis_a);
        rates[i] = approach + turning;
    }
    rates
}

/// Multipliers λ ≥ 0 of every manifold, from `residual` = J v + b at the multipliers `old`.
///
/// Where all points press, the regularised inverse gives them at once. Elsewhere, and for what it leaves, projected
/// Gauss–Seidel on the manifold's own matrix. Without the inverse, the few inner sweeps leave a face's load uneven and tall
/// columns buckle.
#[inline(always)]
pub(super) fn solve_manifolds<W: Wide, const N: usize>(
    block: &ContactBlock,
    mut residual: Points<W>,
    old: &Points<W>,
) -> Points<W> {
    let zero = W::zero();
    let mut lambda = *old;
    if N == 1 {
        lambda[0] = (lambda[0] - residual[0] * W::load(&block.inverse_diagonal[0])).max(zero);
        return lambda;
    }
    let step = regular_step::<W>(block, &residual, &lambda);
    for i in 0..POINTS {
        lambda[i] = lambda[i] + step[i];
    }
    let [d0, d1, d2, d3] = load_points::<W>(&block.diagonal);
    let [c01, c02, c03, c12, c13, c23] = load_all::<W, 6>(&block.coupling);
    let matrix = [[d0, c01, c02, c03], [c01, d1, c12, c13], [c02, c12, d2, c23], [c03, c13, c23, d3]];
    for i in 0..POINTS {
        residual[i] = residual[i] + product(&matrix[i], &step);
    }
    let inverse_diagonal = load_points::<W>(&block.inverse_diagonal);
    for _ in 0..INNER_SWEEPS {
        for i in 0..POINTS {
            let new = (lambda[i] - residual[i] * inverse_diagonal[i]).max(zero);
            let change = new - lambda[i];
            lambda[i] = new;
            for j in 0..POINTS {
                residual[j] = residual[j] + matrix[j][i] * change;
            }
        }
    }
    lambda
}

/// −(A + ε)⁻¹ residual where that leaves all multipliers ≥ 0, else nothing.
#[inline(always)]
fn regular_step<W: Wide>(block: &ContactBlock, residual: &Points<W>, lambda: &Points<W>) -> Points<W> {
    let [b00, b11, b22, b33, b01, b02, b03, b12, b13, b23] = load_all::<W, 10>(&block.inverse);
    let inverse = [[b00, b01, b02, b03], [b01, b11, b12, b13], [b02, b12, b22, b23], [b03, b13, b23, b33]];
    let zero = W::zero();
    let (mut step, mut least) = ([zero; POINTS], zero);
    for i in 0..POINTS {
        let sum = product(&inverse[i], residual);
        step[i] = -sum;
        least = least.min(lambda[i] - sum);
    }
    let some_would_pull = zero.above(least);
    for i in 0..POINTS {
        step[i] = W::select(some_would_pull, zero, step[i]);
    }
    step
}

/// Applies the difference of two sets of normal multipliers.
#[inline(always)]
pub(super) fn push_apart<W: Wide, const N: usize>(
    block: &ContactBlock,
    new: &Points<W>,
    old: &Points<W>,
    side_a: &mut Side<W>,
    side_b: &mut Side<W>,
) {
    let n = Wide3::load(&block.normal);
    let mut sum = W::zero();
    let (mut arm_a, mut arm_b) = (Wide3::zero(), Wide3::zero());
    for i in 0..N {
        let change = new[i] - old[i];
        sum = sum + change;
        arm_a = arm_a + Wide3::load(&block.lever_a[i]) * change;
        arm_b = arm_b + Wide3::load(&block.lever_b[i]) * change;
    }
    side_a.apply(n * -sum, -arm_a.cross(n));
    side_b.apply(n * sum, arm_b.cross(n));
}
