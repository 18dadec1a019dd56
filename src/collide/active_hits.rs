//! Pairs that are in a hit, with its approach speed. Few pairs are, so this is a table of its own and not a field of every pair.

use std::collections::BTreeMap;

/// A hit under way.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct ActiveHit {
    /// Greatest speed at which points have approached each other (m/s).
    pub approach: f32,
    /// Impulse along the normal (N·s).
    pub impulse: f32,
}

/// Those of all pairs, by slot.
#[derive(Debug, Default)]
pub(crate) struct ActiveHits(BTreeMap<u32, ActiveHit>);

impl ActiveHits {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn get(&self, slot: u32) -> Option<&ActiveHit> {
        self.0.get(&slot)
    }

    pub(crate) fn get_mut(&mut self, slot: u32) -> Option<&mut ActiveHit> {
        self.0.get_mut(&slot)
    }

    pub(crate) fn slots(&self) -> impl Iterator<Item = u32> {
        self.0.keys().copied()
    }

    /// Takes note of a hit that has come to this; of none where nothing approaches.
    pub(crate) fn set(&mut self, slot: u32, blow: ActiveHit) {
        if blow.approach > 0.0 {
            self.0.insert(slot, blow);
        }
    }

    /// Takes note that points approach each other at this speed (m/s).
    pub(crate) fn note(&mut self, slot: u32, approach: f32) {
        if approach > 0.0 {
            let blow = self.0.entry(slot).or_default();
            blow.approach = blow.approach.max(approach);
        }
    }

    pub(crate) fn forget(&mut self, slot: u32) {
        if !self.0.is_empty() {
            self.0.remove(&slot);
        }
    }

    /// Follows pairs that have gone to other slots.
    pub(crate) fn move_pairs(&mut self, places: &[u32]) {
        self.0 = std::mem::take(&mut self.0).into_iter().map(|(slot, blow)| (places[slot as usize], blow)).collect();
    }
}
