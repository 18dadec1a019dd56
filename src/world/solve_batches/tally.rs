//! Says of which manifolds multipliers are added up over the substeps of a step.

use super::BatchInput;
use crate::solve::batch::{Batch, BatchManifolds};

impl BatchInput<'_> {
    /// Lists what is added up: everything where hits are told, else what presses on members of unions, whose joints bear what contacts do in the
    /// whole step, not in the last substep alone. Whose loads somebody will ask for is known only when the step is over.
    pub(super) fn list_tallied(&self, batch: &mut Batch) {
        let BatchManifolds { list, tally, .. } = &mut batch.manifolds;
        tally.is_on = self.tallied;
        if self.tallied || self.unions.order.is_empty() {
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
