//! Sorts pairs and their manifolds in memory by the order in which a step visits them. It changes time and no result.

use super::PairCache;
use crate::collide::persistent_manifold::{Kind, Manifolds};

/// Active pairs from which on their order in memory matters, and share of them that may come before the one before them.
pub(super) const MIN_TIDIED: usize = 2048;
const MAX_OUT_OF_ORDER: f32 = 0.2;

/// Steps after which manifolds are looked at: nothing but time depends on where they are.
const STEPS_UNTIDIED: u32 = 16;

impl PairCache {
    /// Puts slots in the order in which pairs are gone through, if they are much out of it, and says where each has gone.
    ///
    /// Pairs come and go, and slots are used again: after a while each pair is a read from another place of memory, a dozen times a
    /// step.
    pub(crate) fn tidy(&mut self) -> Option<Vec<u32>> {
        self.settle();
        let places = self.tidy_slots();
        self.until_tidied = self.until_tidied.saturating_sub(1);
        if self.until_tidied == 0 && self.is_large() {
            self.tidy_manifolds();
        }
        places
    }

    fn tidy_slots(&mut self) -> Option<Vec<u32>> {
        let out_of_order = self.active.windows(2).filter(|two| two[0].1 > two[1].1).count();
        if !self.is_large() || out_of_order as f32 <= MAX_OUT_OF_ORDER * self.active.len() as f32 {
            return None;
        }
        const NONE: u32 = u32::MAX;
        let mut places = vec![NONE; self.pairs.len()];
        for ((_, slot), place) in self.active.iter_mut().zip(0..) {
            places[*slot as usize] = place;
            *slot = place;
        }
        let others = places.iter_mut().filter(|place| **place == NONE);
        others.zip(self.active.len() as u32..).for_each(|(place, next)| *place = next);
        put_in_places(&mut self.pairs, &places);
        self.blows.move_pairs(&places);
        for slot in self.free.iter_mut().chain(self.released.iter_mut().flatten()) {
            *slot = places[*slot as usize];
        }
        Some(places)
    }

    /// Lets manifolds lie in memory in the order in which pairs are gone through, as far as they are of one size.
    ///
    /// They are asked for one by one as bodies meet, and come from wherever there was room: of a large pile each is a read from far
    /// memory, half a dozen times a step.
    fn tidy_manifolds(&mut self) {
        self.until_tidied = STEPS_UNTIDIED;
        let mut holders = Vec::new();
        for kind in [Kind::Point, Kind::One] {
            if !self.are_out_of_order(kind) {
                continue;
            }
            holders.clear();
            holders.extend(self.active.iter().map(|&(_, slot)| slot).filter(|&slot| self.get(slot).manifolds.kind() == kind));
            let address = |slot: u32| self.pairs[slot as usize].manifolds.address();
            // Of the manifolds in the order of their addresses, which holder has each.
            let mut by_address: Vec<u32> = (0..holders.len() as u32).collect();
            by_address.sort_unstable_by_key(|&number| address(holders[number as usize]));
            let mut rank = vec![0; holders.len()];
            by_address.iter().zip(0..).for_each(|(&number, place)| rank[number as usize] = place);
            // Memory goes to the holder of its rank, with what is in it; then that goes back to whose it is.
            self.permute(&holders, &mut rank, std::mem::swap);
            self.permute(&holders, &mut by_address, Manifolds::swap_contents);
        }
    }

    /// Whether manifolds of a kind are many, and much out of the order in which pairs are gone through.
    pub(super) fn are_out_of_order(&self, kind: Kind) -> bool {
        let (mut count, mut out_of_order, mut last) = (0, 0, 0);
        for manifolds in
            self.active.iter().map(|&(_, slot)| &self.get(slot).manifolds).filter(|manifolds| manifolds.kind() == kind)
        {
            let address = manifolds.address();
            count += 1;
            out_of_order += usize::from(address < last);
            last = address;
        }
        count >= MIN_TIDIED && out_of_order as f32 > MAX_OUT_OF_ORDER * count as f32
    }

    /// Moves something of the pairs in the slots `holders` to the holders that `places` says, which is used up.
    fn permute(&mut self, holders: &[u32], places: &mut [u32], mut swap: impl FnMut(&mut Manifolds, &mut Manifolds)) {
        for i in 0..holders.len() {
            while places[i] as usize != i {
                let place = places[i] as usize;
                if let Ok([a, b]) = self.pairs.get_disjoint_mut([holders[i] as usize, holders[place] as usize]) {
                    swap(&mut a.manifolds, &mut b.manifolds);
                }
                places.swap(i, place);
            }
        }
    }
}

/// Moves every item to its place.
pub(crate) fn put_in_places<T>(items: &mut [T], places: &[u32]) {
    let mut places = places.to_vec();
    for i in 0..items.len() {
        while places[i] as usize != i {
            let place = places[i] as usize;
            items.swap(i, place);
            places.swap(i, place);
        }
    }
}
