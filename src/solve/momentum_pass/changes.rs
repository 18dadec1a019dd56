//! Changes of multipliers in the layout of the rows: eight manifolds side by side.
//!
//! Bodies whose manifolds lie in one block may be two threads', so changes are stored through shared references, without order: they
//! are read when all are there.

use std::sync::atomic::{AtomicU32, Ordering};

use super::super::contact::{LANES, Lane, POINTS};
use super::super::contact_block::BlockView;
use super::NO_ISLAND;

/// Changes of the multipliers of a block's points, and of its friction along both tangents, as bits.
#[derive(Debug, Default)]
pub(super) struct LaneChanges {
    rows: [[AtomicU32; LANES]; POINTS + 2],
    /// Island of each lane that has any.
    islands: [u32; LANES],
}

impl LaneChanges {
    /// Begins with the island of each lane, or none: what is noted of such is left, and nothing is taken of it.
    pub(super) fn begin(&mut self, islands: impl Iterator<Item = u32>) {
        self.islands.iter_mut().zip(islands).for_each(|(own, island)| *own = island);
    }

    /// Notes the changes of all points of a lane, and those of friction along both tangents.
    pub(super) fn set(&self, lane: usize, points: [f32; POINTS], friction: [f32; 2]) {
        for (row, change) in self.rows.iter().zip(points.into_iter().chain(friction)) {
            row[lane].store(change.to_bits(), Ordering::Relaxed);
        }
    }

    fn row(&self, row: usize) -> Lane {
        self.rows[row].each_ref().map(|bits| f32::from_bits(bits.load(Ordering::Relaxed)))
    }

    /// Takes of the changes the shares of their islands.
    pub(super) fn apply(&self, whole: BlockView<'_>, share_of: impl Fn(u32) -> f32) {
        let shares = self.islands.map(|island| if island == NO_ISLAND { 0.0 } else { share_of(island) });
        if shares == [0.0; LANES] {
            return;
        }
        let BlockView { block, face, .. } = whole;
        let more = face.into_iter().flat_map(|face| &mut face.more);
        let lambdas = [&mut block.first.lambda].into_iter().chain(more.map(|rows| &mut rows.lambda));
        for (row, lambda) in lambdas.enumerate() {
            change(lambda, &self.row(row), &shares, |lambda| lambda.max(0.0));
        }
        for (row, lambda) in block.tangent_lambda.iter_mut().enumerate() {
            change(lambda, &self.row(POINTS + row), &shares, |lambda| lambda);
        }
    }
}

/// What is not a number, where nothing is taken of it, changes nothing.
fn change(lambda: &mut Lane, by: &Lane, shares: &Lane, bound: impl Fn(f32) -> f32) {
    for l in 0..LANES {
        let changed = bound(lambda[l] + by[l] * shares[l]);
        lambda[l] = if shares[l] > 0.0 { changed } else { lambda[l] };
    }
}
