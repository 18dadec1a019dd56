//! Says of which manifolds multipliers are added up over the substeps of a step.

use super::BatchInput;
use crate::solve::batch::{Batch, BatchManifolds};
use crate::world::World;

/// Manifolds whose multipliers are added up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tallied {
    None,
    /// Those of members of unions: their joints bear what contacts do in the whole step, not in the last substep alone.
    OfUnions,
    /// All, as hits are told.
    All,
}

impl World {
    /// What is added up in this step: nothing that nobody wants to know.
    pub(super) fn tallied(&self) -> Tallied {
        if self.def.hit_threshold < f32::INFINITY {
            Tallied::All
        } else if self.unions.asks_for_loads() {
            Tallied::OfUnions
        } else {
            Tallied::None
        }
    }
}

impl BatchInput<'_> {
    /// Lists the manifolds of a batch that are added up.
    pub(super) fn list_tallied(&self, batch: &mut Batch) {
        let BatchManifolds { list, tally, .. } = &mut batch.manifolds;
        tally.is_on = self.tallied == Tallied::All;
        if self.tallied != Tallied::OfUnions {
            return;
        }
        for (number, &(slot, _)) in list.iter().enumerate() {
            let (a, b) = self.pairs.get(slot).key.shapes();
            if [a, b].into_iter().any(|shape| self.unions.number_of(self.index.body_of(shape)).is_some()) {
                tally.numbers.push(number as u32);
            }
        }
    }
}
