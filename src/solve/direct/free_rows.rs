//! The equations of the rows that a factor holds.

use super::block::Lanes;
use super::body::DirectBody;
use super::factor::BlockFactor;
use super::packed_rows::{self, PackedRows};
use super::refine::Equations;
use super::topology::SystemNode;
use crate::solve::joint::rows::Rate;

/// The rows that are free, at rates that change as they are solved.
pub(super) struct FreeRows<'a> {
    pub packed_rows: &'a mut PackedRows,
    pub nodes: &'a [SystemNode],
    pub bodies: &'a [DirectBody],
    pub rates: &'a mut [Rate],
}

impl Equations for FreeRows<'_> {
    fn find_residuals(&mut self, factor: &BlockFactor, residuals: &mut [Lanes]) -> f64 {
        packed_rows::find_residuals(residuals, self.packed_rows, self.nodes, factor, self.rates)
    }

    fn find_added(&mut self, factor: &BlockFactor, added: &mut [Lanes]) {
        self.packed_rows.find_added(factor, added);
    }

    fn add_impulses(&mut self, factor: &BlockFactor, increments: &[Lanes], share: f64) {
        packed_rows::add_impulses(self.packed_rows, increments, share, self.nodes, factor, self.bodies, self.rates);
    }
}
