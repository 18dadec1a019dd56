//! What all contact kernels use: access to the manifolds of a block, one manifold to a lane, and the normal rows.

#![expect(clippy::needless_range_loop, reason = "an index runs over points and lanes of several arrays alike")]

use super::super::body_gather::{WideVelocities, moved};
use super::super::contact::{Lane, POINTS};
use super::super::contact_block::{ContactBlock, MaterialRows, MultiPointRows, PointRows, TwistRow};
use super::super::state::BodyMotion;
use crate::lanes::wide::{Wide, Wide3};

/// Gauss–Seidel sweeps over the 4×4 matrix of a manifold each time that an outer sweep comes to it.
const INNER_SWEEPS: usize = 4;

/// One number for each point of each manifold.
pub(super) type PerPoint<W> = [W; POINTS];

#[inline(always)]
pub(super) fn load_all<W: Wide, const N: usize>(lanes: &[Lane; N]) -> [W; N] {
    let mut all = [W::zero(); N];
    for i in 0..N {
        all[i] = W::load(&lanes[i]);
    }
    all
}

#[inline(always)]
fn product<W: Wide>(row: &PerPoint<W>, column: &PerPoint<W>) -> W {
    row[0] * column[0] + row[1] * column[1] + row[2] * column[2] + row[3] * column[3]
}

/// The manifolds of a block: of one point each, or of up to four.
pub(super) trait BlockManifolds {
    /// Most points of a manifold.
    const COUNT: usize;

    fn block(&self) -> &ContactBlock;
    fn block_mut(&mut self) -> &mut ContactBlock;
    fn rows(&self, point: usize) -> &PointRows;
    fn rows_mut(&mut self, point: usize) -> &mut PointRows;
    /// The rows that only manifolds of more than one point have.
    fn face_mut(&mut self) -> Option<&mut MultiPointRows>;

    /// Row of torsional friction, about the normal. A manifold of one point has it only where the material asks for it.
    fn twist<'a>(&'a mut self, extra: Option<&'a mut MaterialRows>) -> Option<&'a mut TwistRow>;

    /// Levers of the manifold's centre, where friction acts.
    fn centers<W: Wide>(&self) -> (Wide3<W>, Wide3<W>);

    /// New multipliers λ ≥ 0, given `residual` = J v + b at the multipliers `old`.
    fn solve<W: Wide>(&self, residual: PerPoint<W>, old: &PerPoint<W>) -> PerPoint<W>;
}

/// Manifolds of one point.
pub(super) struct Single<'a>(pub &'a mut ContactBlock);

/// Manifolds of up to four points.
pub(super) struct Faced<'a>(pub &'a mut ContactBlock, pub &'a mut MultiPointRows);

impl BlockManifolds for Single<'_> {
    const COUNT: usize = 1;

    #[inline(always)]
    fn block(&self) -> &ContactBlock {
        self.0
    }

    #[inline(always)]
    fn block_mut(&mut self) -> &mut ContactBlock {
        self.0
    }

    #[inline(always)]
    fn rows(&self, _point: usize) -> &PointRows {
        &self.0.first
    }

    #[inline(always)]
    fn rows_mut(&mut self, _point: usize) -> &mut PointRows {
        &mut self.0.first
    }

    #[inline(always)]
    fn face_mut(&mut self) -> Option<&mut MultiPointRows> {
        None
    }

    #[inline(always)]
    fn twist<'a>(&'a mut self, extra: Option<&'a mut MaterialRows>) -> Option<&'a mut TwistRow> {
        match extra {
            Some(extra) if extra.has_spinning => Some(&mut extra.twist),
            _ => None,
        }
    }

    #[inline(always)]
    fn centers<W: Wide>(&self) -> (Wide3<W>, Wide3<W>) {
        (Wide3::load(&self.0.first.lever_a), Wide3::load(&self.0.first.lever_b))
    }

    #[inline(always)]
    fn solve<W: Wide>(&self, residual: PerPoint<W>, old: &PerPoint<W>) -> PerPoint<W> {
        let mut lambda = *old;
        lambda[0] = (lambda[0] - residual[0] * W::load(&self.0.first.inverse_diagonal)).max(W::zero());
        lambda
    }
}

impl BlockManifolds for Faced<'_> {
    const COUNT: usize = POINTS;

    #[inline(always)]
    fn block(&self) -> &ContactBlock {
        self.0
    }

    #[inline(always)]
    fn block_mut(&mut self) -> &mut ContactBlock {
        self.0
    }

    #[inline(always)]
    fn rows(&self, point: usize) -> &PointRows {
        if point == 0 { &self.0.first } else { &self.1.more[point - 1] }
    }

    #[inline(always)]
    fn rows_mut(&mut self, point: usize) -> &mut PointRows {
        if point == 0 { &mut self.0.first } else { &mut self.1.more[point - 1] }
    }

    #[inline(always)]
    fn face_mut(&mut self) -> Option<&mut MultiPointRows> {
        Some(self.1)
    }

    #[inline(always)]
    fn twist<'a>(&'a mut self, _extra: Option<&'a mut MaterialRows>) -> Option<&'a mut TwistRow> {
        Some(&mut self.1.twist)
    }

    #[inline(always)]
    fn centers<W: Wide>(&self) -> (Wide3<W>, Wide3<W>) {
        (Wide3::load(&self.1.center_a), Wide3::load(&self.1.center_b))
    }

    /// Where all points press, one product with the regularised inverse gives all multipliers, to a thousandth that the next sweep
    /// corrects. Where a point would pull, projected Gauss–Seidel on the manifold's own matrix takes over. Inner sweeps alone are too
    /// few: they leave the load of a face uneven, and tall columns buckle.
    #[inline(always)]
    fn solve<W: Wide>(&self, mut residual: PerPoint<W>, old: &PerPoint<W>) -> PerPoint<W> {
        let zero = W::zero();
        let (pressing, some_would_pull) = regular_solution::<W>(self.1, &residual, old);
        if !W::any(some_would_pull) {
            return pressing;
        }
        let mut lambda = *old;
        let [d0, d1, d2, d3] = load_all::<W, POINTS>(&self.1.diagonal);
        let [c01, c02, c03, c12, c13, c23] = load_all::<W, 6>(&self.1.coupling);
        let matrix = [[d0, c01, c02, c03], [c01, d1, c12, c13], [c02, c12, d2, c23], [c03, c13, c23, d3]];
        let mut inverse_diagonal = [zero; POINTS];
        for i in 0..POINTS {
            inverse_diagonal[i] = W::load(&self.rows(i).inverse_diagonal);
        }
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
        for i in 0..POINTS {
            lambda[i] = W::select(some_would_pull, lambda[i], pressing[i]);
        }
        lambda
    }
}

/// Calls a kernel with a block as [`Faced`] or [`Single`]. `$faces` holds the extra rows of faces from number `$before` on; a block
/// whose face is not among them has manifolds of one point.
macro_rules! of_block {
    ($kernel:ident::<$wide:ty>($block:expr, ($faces:expr, $before:expr) $(, $rest:expr)*)) => {
        match $faces.get_mut($block.face.wrapping_sub($before) as usize) {
            Some(face) => $kernel::<$wide, _>(&mut Faced($block, face) $(, $rest)*),
            None => $kernel::<$wide, _>(&mut Single($block) $(, $rest)*),
        }
    };
}

pub(super) use of_block;

/// Multipliers of every point.
#[inline(always)]
pub(super) fn lambdas<W: Wide, M: BlockManifolds>(of: &M) -> PerPoint<W> {
    let mut lambdas = [W::zero(); POINTS];
    for i in 0..M::COUNT {
        lambdas[i] = W::load(&of.rows(i).lambda);
    }
    lambdas
}

#[inline(always)]
pub(super) fn store_lambdas<W: Wide, M: BlockManifolds>(lambdas: &PerPoint<W>, of: &mut M) {
    for i in 0..M::COUNT {
        lambdas[i].store(&mut of.rows_mut(i).lambda);
    }
}

/// Separation of every point with the bodies displaced as `motions` say (m).
#[inline(always)]
pub(super) fn separations<W: Wide, M: BlockManifolds>(of: &M, motions: &[BodyMotion]) -> PerPoint<W> {
    let (moved_a, turned_a) = moved::<W>(&of.block().a, motions);
    let (moved_b, turned_b) = moved::<W>(&of.block().b, motions);
    let n = Wide3::load(&of.block().normal);
    let shift = n.dot(moved_b - moved_a);
    let (axis_a, axis_b) = (n.cross(turned_a), n.cross(turned_b));
    let mut separation = [W::zero(); POINTS];
    for i in 0..M::COUNT {
        let rows = of.rows(i);
        // n·(θ×r) = r·(n×θ)
        let turning = Wide3::load(&rows.lever_b).dot(axis_b) - Wide3::load(&rows.lever_a).dot(axis_a);
        separation[i] = W::load(&rows.separation) + (shift + turning);
    }
    separation
}

/// J v of every normal row.
#[inline(always)]
pub(super) fn normal_rates<W: Wide, M: BlockManifolds>(
    of: &M,
    side_a: &WideVelocities<W>,
    side_b: &WideVelocities<W>,
) -> PerPoint<W> {
    let n = Wide3::load(&of.block().normal);
    let approach = n.dot(side_b.linear - side_a.linear);
    // n·(ω×r) = r·(n×ω)
    let (axis_a, axis_b) = (n.cross(side_a.angular), n.cross(side_b.angular));
    let mut rates = [W::zero(); POINTS];
    for i in 0..M::COUNT {
        let rows = of.rows(i);
        let turning = Wide3::load(&rows.lever_b).dot(axis_b) - Wide3::load(&rows.lever_a).dot(axis_a);
        rates[i] = approach + turning;
    }
    rates
}

/// λ − (A + ε)⁻¹ residual, cut off at zero, and the lanes where it was negative: there some point would have to pull.
#[inline(always)]
fn regular_solution<W: Wide>(face: &MultiPointRows, residual: &PerPoint<W>, lambda: &PerPoint<W>) -> (PerPoint<W>, W::Mask) {
    let [b00, b11, b22, b33, b01, b02, b03, b12, b13, b23] = load_all::<W, 10>(&face.inverse);
    let inverse = [[b00, b01, b02, b03], [b01, b11, b12, b13], [b02, b12, b22, b23], [b03, b13, b23, b33]];
    let zero = W::zero();
    let (mut pressing, mut least) = ([zero; POINTS], zero);
    for i in 0..POINTS {
        let new = lambda[i] - product(&inverse[i], residual);
        least = least.min(new);
        // A NaN becomes zero.
        pressing[i] = new.max(zero);
    }
    (pressing, zero.above(least))
}

/// Applies the change from `old` to `new` normal multipliers to the velocities.
#[inline(always)]
pub(super) fn push_apart<W: Wide, M: BlockManifolds>(
    of: &M,
    new: &PerPoint<W>,
    old: &PerPoint<W>,
    side_a: &mut WideVelocities<W>,
    side_b: &mut WideVelocities<W>,
) {
    let n = Wide3::load(&of.block().normal);
    let mut sum = W::zero();
    let (mut arm_a, mut arm_b) = (Wide3::zero(), Wide3::zero());
    for i in 0..M::COUNT {
        let change = new[i] - old[i];
        sum = sum + change;
        arm_a = arm_a + Wide3::load(&of.rows(i).lever_a) * change;
        arm_b = arm_b + Wide3::load(&of.rows(i).lever_b) * change;
    }
    side_a.apply(n * -sum, -arm_a.cross(n));
    side_b.apply(n * sum, arm_b.cross(n));
}
