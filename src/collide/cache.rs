//! Pairs of shapes that may touch: found by key, walked in key order.
//!
//! A pair is *active* while one of its bodies can move by itself; the pairs of a sleeping island are kept by the island.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::carried::{Kind, Manifolds};
use super::pairs::{Pair, PairKey};
use crate::room::{make_room, make_room_behind};
use crate::workers::Workers;

/// Pairs of which it is worth another thread's while to ask whether they have gone: some 5 µs.
const LEAST_ASKED: usize = 2048;

/// All pairs of a world.
#[derive(Debug, Default)]
pub(crate) struct PairCache {
    pairs: Vec<Pair>,
    free: Vec<u32>,
    /// Active pairs in key order, and what edits have given up since it was last [settled](Self::settle).
    active: Vec<(PairKey, u32)>,
    /// How many of those were given up, and what edits have made active instead.
    gone: usize,
    woken: BTreeMap<PairKey, u32>,
    /// Slots given up and not yet [forgotten](Self::forget_released), where somebody wants to know.
    released: Option<Vec<u32>>,
    /// Buffer of [`drop_active`](Self::drop_active).
    gone_at: Vec<Vec<u32>>,
    /// Buffer of [`Lookup`].
    firsts: Vec<u32>,
    /// Steps until manifolds are looked at.
    until_tidied: u32,
}

impl PairCache {
    /// A cache of active pairs, sorted by key, and of pairs that sleep, which take the slots after them; `None` if not sorted.
    pub(crate) fn from_parts(active: Vec<Pair>, asleep: Vec<Pair>) -> Option<Self> {
        if !active.windows(2).all(|two| two[0].key < two[1].key) {
            return None;
        }
        let keys = active.iter().enumerate().map(|(slot, pair)| (pair.key, slot as u32)).collect();
        let mut pairs = active;
        pairs.iter_mut().for_each(|pair| pair.active = true);
        pairs.extend(asleep);
        pairs.iter_mut().for_each(Pair::note_pressed);
        Some(Self { pairs, active: keys, ..Self::default() })
    }

    /// Every slot of the cache, also those not in use.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Pair> {
        self.pairs.iter()
    }

    /// Active pairs, in key order; as they were before edits since [`settle`](Self::settle).
    pub(crate) fn active(&self) -> &[(PairKey, u32)] {
        debug_assert!(self.is_settled(), "stages of a step begin with settled pairs");
        &self.active
    }

    /// Active pairs, in key order, also between steps.
    pub(crate) fn listed(&self) -> Cow<'_, [(PairKey, u32)]> {
        if self.is_settled() {
            return Cow::Borrowed(&self.active);
        }
        let mut listed: Vec<(PairKey, u32)> = self.active.iter().copied().filter(|&(_, slot)| self.get(slot).active).collect();
        listed.extend(self.woken.iter().map(|(&key, &slot)| (key, slot)));
        listed.sort_unstable();
        Cow::Owned(listed)
    }

    /// Brings the list of active pairs up to date with edits.
    ///
    /// Each edit touches few pairs of very many: it leaves a mark, and the list is gone through once for all of them.
    #[inline]
    pub(crate) fn settle(&mut self) {
        if !self.is_settled() {
            self.apply_edits();
        }
    }

    fn apply_edits(&mut self) {
        if std::mem::take(&mut self.gone) > 0 {
            let pairs = &self.pairs;
            self.active.retain(|&(_, slot)| pairs[slot as usize].active);
        }
        if !self.woken.is_empty() {
            let woken: Vec<(PairKey, u32)> = std::mem::take(&mut self.woken).into_iter().collect();
            self.merge(&woken);
        }
    }

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
        if !self.is_large() || out_of_order as f32 <= MOST_OUT_OF_ORDER * self.active.len() as f32 {
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
    fn are_out_of_order(&self, kind: Kind) -> bool {
        let (mut count, mut out_of_order, mut last) = (0, 0, 0);
        for manifolds in
            self.active.iter().map(|&(_, slot)| &self.get(slot).manifolds).filter(|manifolds| manifolds.kind() == kind)
        {
            let address = manifolds.address();
            count += 1;
            out_of_order += usize::from(address < last);
            last = address;
        }
        count >= LEAST_TIDIED && out_of_order as f32 > MOST_OUT_OF_ORDER * count as f32
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

    /// Whether there are so many active pairs that where their records lie in memory matters.
    pub(crate) fn is_large(&self) -> bool {
        self.active.len() >= LEAST_TIDIED
    }

    fn is_settled(&self) -> bool {
        self.gone == 0 && self.woken.is_empty()
    }

    /// Slot of an active pair, also between steps.
    pub(crate) fn find(&self, key: PairKey) -> Option<u32> {
        let listed = self.active.binary_search_by_key(&key, |&(key, _)| key).ok().map(|place| self.active[place].1);
        listed.filter(|&slot| self.get(slot).active).or_else(|| self.woken.get(&key).copied())
    }

    /// What tells whether a settled list has a pair, for as many shapes as a world has and for questions about the neighbours of
    /// some of them.
    pub(crate) fn lookup(&mut self, shapes: usize, asking: usize) -> Lookup<'_> {
        let is_large = self.is_large();
        let Self { active, firsts, .. } = self;
        firsts.clear();
        if is_large && asking * QUESTIONS_OF_EACH >= active.len() {
            firsts.resize(shapes + 1, 0);
            active.iter().for_each(|(key, _)| firsts[key.shapes().0 as usize + 1] += 1);
            (1..firsts.len()).for_each(|shape| firsts[shape] += firsts[shape - 1]);
        }
        Lookup { active, firsts }
    }

    /// Gives up an active pair, also between steps.
    pub(crate) fn give_up(&mut self, slot: u32) {
        let key = self.get(slot).key;
        if self.woken.remove(&key).is_none() {
            self.gone += 1;
        }
        self.release(slot);
    }

    pub(crate) fn get(&self, slot: u32) -> &Pair {
        &self.pairs[slot as usize]
    }

    pub(crate) fn get_mut(&mut self, slot: u32) -> &mut Pair {
        &mut self.pairs[slot as usize]
    }

    /// Calls `f` for every active pair, in key order.
    pub(crate) fn for_each_active(&mut self, mut f: impl FnMut(&mut Pair)) {
        self.settle();
        for &(_, slot) in &self.active {
            f(&mut self.pairs[slot as usize]);
        }
    }

    /// Every slot of the cache, also those not in use or asleep; see [`is_active`](Self::is_active).
    pub(crate) fn slots_mut(&mut self) -> &mut [Pair] {
        &mut self.pairs
    }

    /// Adds those of `keys` (sorted, without repeats) that are not active yet.
    pub(crate) fn activate_new(&mut self, keys: &[PairKey]) {
        if keys.is_empty() {
            return;
        }
        self.settle();
        let mut fresh = Vec::new();
        for &key in keys {
            if self.active.binary_search_by_key(&key, |&(key, _)| key).is_err() {
                fresh.push((key, self.allocate(key)));
            }
        }
        self.merge(&fresh);
    }

    /// Makes pairs active again that a sleeping island kept. Dropped are those that were found anew meanwhile, and those of which
    /// one side has gone: `is_whole` says whether a pair still is one.
    pub(crate) fn activate_kept(&mut self, slots: &[u32], is_whole: impl Fn(PairKey) -> bool) {
        for &slot in slots {
            let key = self.pairs[slot as usize].key;
            if is_whole(key) && self.find(key).is_none() {
                let pair = &mut self.pairs[slot as usize];
                (pair.active, pair.still) = (true, false);
                self.woken.insert(key, slot);
            } else {
                self.release(slot);
            }
        }
    }

    /// Gives up the active pairs of which `has_gone` says so, which is asked on all threads; `give_up` is told of each, in their order.
    pub(crate) fn drop_active(
        &mut self,
        threads: &Workers,
        has_gone: impl Fn(PairKey) -> bool + Sync,
        mut give_up: impl FnMut(PairKey, &Pair),
    ) {
        self.settle();
        if self.active.is_empty() {
            return;
        }
        let (mut active, mut gone) = (std::mem::take(&mut self.active), std::mem::take(&mut self.gone_at));
        let piece = if threads.has_team() { threads.piece(active.len(), LEAST_ASKED) } else { active.len().max(1) };
        let pieces = active.len().div_ceil(piece);
        gone.resize_with(pieces.max(gone.len()), Vec::new);
        threads.share(active.chunks(piece).zip(&mut gone).zip((0..).step_by(piece)), |((pairs, gone), first)| {
            gone.extend((first..).zip(pairs).filter(|&(_, &(key, _))| has_gone(key)).map(|(at, _)| at as u32));
        });
        // What stays between two that have gone moves forward by as many as have gone before it.
        let (mut to, mut from) = (0, 0);
        for at in gone.iter_mut().flat_map(|gone| gone.drain(..)) {
            let (key, slot) = active[at as usize];
            give_up(key, &self.pairs[slot as usize]);
            self.release(slot);
            active.copy_within(from..at as usize, to);
            to += at as usize - from;
            from = at as usize + 1;
        }
        if from > 0 {
            active.copy_within(from.., to);
            active.truncate(active.len() - (from - to));
        }
        (self.active, self.gone_at) = (active, gone);
    }

    /// Keeps the active pairs of which `fate` says so, which is told their keys and slots.
    pub(crate) fn retain_active(&mut self, mut fate: impl FnMut(PairKey, u32) -> Fate) {
        self.settle();
        let mut active = std::mem::take(&mut self.active);
        active.retain(|&(key, slot)| match fate(key, slot) {
            Fate::Stay => true,
            Fate::Store => {
                self.pairs[slot as usize].active = false;
                false
            }
            Fate::Drop => {
                self.release(slot);
                false
            }
        });
        self.active = active;
    }

    /// Gives a slot back, and the room of its manifolds: three of four pairs never touch.
    pub(crate) fn release(&mut self, slot: u32) {
        let pair = &mut self.pairs[slot as usize];
        pair.manifolds = Manifolds::default();
        pair.active = false;
        self.free.push(slot);
        if let Some(released) = &mut self.released {
            released.push(slot);
        }
    }

    /// Notes which slots are given up from now on, or no longer.
    pub(crate) fn follow_releases(&mut self, on: bool) {
        self.released = on.then(Vec::new);
    }

    /// Slots that were given up; some may be those of other pairs by now.
    pub(crate) fn released(&self) -> &[u32] {
        self.released.as_deref().unwrap_or(&[])
    }

    /// Forgets which slots were given up.
    pub(crate) fn forget_released(&mut self) {
        if let Some(released) = &mut self.released {
            released.clear();
        }
    }

    /// Whether a slot still is that of a pair, active or asleep, that has contacts.
    pub(crate) fn holds(&self, slot: u32, key: PairKey) -> bool {
        let pair = &self.pairs[slot as usize];
        pair.key == key && !pair.manifolds.is_empty()
    }

    fn allocate(&mut self, key: PairKey) -> u32 {
        match self.free.pop() {
            Some(slot) => {
                let version = self.pairs[slot as usize].version.wrapping_add(1);
                self.pairs[slot as usize] = Pair { version, ..Pair::new(key) };
                slot
            }
            None => {
                make_room_behind(&mut self.pairs, 1);
                // Bodies that part must not ask for memory.
                make_room(&mut self.free, self.pairs.capacity());
                self.pairs.push(Pair::new(key));
                self.pairs.len() as u32 - 1
            }
        }
    }

    fn merge(&mut self, fresh: &[(PairKey, u32)]) {
        if fresh.is_empty() {
            return;
        }
        for &(_, slot) in fresh {
            self.pairs[slot as usize].active = true;
        }
        let mut old = self.active.len();
        make_room_behind(&mut self.active, fresh.len());
        self.active.extend_from_slice(fresh);
        // From the last to the first, so that nothing is written over before it is read.
        for (number, &next) in fresh.iter().enumerate().rev() {
            while old > 0 && self.active[old - 1].0 > next.0 {
                self.active[old + number] = self.active[old - 1];
                old -= 1;
            }
            self.active[old + number] = next;
        }
    }
}

/// Active pairs from which on their order in memory matters, and share of them that may come before the one before them.
const LEAST_TIDIED: usize = 2048;
const MOST_OUT_OF_ORDER: f32 = 0.2;

/// Steps after which manifolds are looked at: nothing but time depends on where they are.
const STEPS_UNTIDIED: u32 = 16;

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

/// Active pairs that may be gone through once for each shape that asks for its neighbours.
const QUESTIONS_OF_EACH: usize = 32;

/// What tells whether there is a pair.
pub(crate) struct Lookup<'a> {
    active: &'a [(PairKey, u32)],
    /// Where the pairs of each shape with higher ones begin, if that is known: few are left to search then, and those lie together.
    firsts: &'a [u32],
}

impl Lookup<'_> {
    pub(crate) fn has(&self, key: &PairKey) -> bool {
        let lower = key.shapes().0 as usize;
        let places = match self.firsts.get(lower..lower + 2) {
            Some(range) => range[0] as usize..range[1] as usize,
            None => 0..self.active.len(),
        };
        self.active[places].binary_search_by_key(key, |&(key, _)| key).is_ok()
    }
}

/// What becomes of an active pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fate {
    /// Stays active.
    Stay,
    /// Leaves the active list; somebody else keeps its slot.
    Store,
    /// Is given up.
    Drop,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collide::carried::CarriedManifold;
    use crate::collide::narrow::Manifold;

    const COUNT: u32 = 2 * LEAST_TIDIED as u32;

    /// Pairs of neighbours, every other one with a manifold of one point, the others of two: each manifold says whose it is.
    fn large() -> PairCache {
        let mut pairs: Vec<Pair> = (0..2 * COUNT).map(|shape| Pair::new(PairKey::new(shape, shape + 1))).collect();
        // Asked for far from the order of the pairs.
        for number in 0..2 * COUNT {
            let shape = number * 3 % (2 * COUNT);
            let mut geometry = Manifold { count: 1 + (shape % 2) as u8, ..Manifold::default() };
            geometry.points[0].feature = shape;
            pairs[shape as usize].manifolds = Manifolds::of(&[CarriedManifold { geometry, impulses: Default::default() }]);
        }
        PairCache::from_parts(pairs, Vec::new()).expect("sorted")
    }

    #[test]
    fn manifolds_are_tidied_and_stay_with_their_pairs() {
        let mut cache = large();
        assert!([Kind::Point, Kind::One].iter().all(|&kind| cache.are_out_of_order(kind)), "the test begins in disorder");
        assert_eq!(cache.tidy(), None, "slots are in order already");
        assert!([Kind::Point, Kind::One].iter().all(|&kind| !cache.are_out_of_order(kind)));
        for &(key, slot) in cache.active() {
            let (shape, _) = key.shapes();
            let points = cache.get(slot).manifolds.get(0).points;
            assert_eq!((points[0].feature, points.len()), (shape, 1 + shape as usize % 2));
        }
    }

    #[test]
    fn what_has_gone_is_dropped_and_told_of_in_order_whoever_asks() {
        for threads in [Workers::default(), Workers::new(3).unwrap()] {
            let _watch = threads.watch();
            let mut cache = large();
            for gone in
                [|shape: u32| shape.is_multiple_of(7), |shape| shape < 40, |shape| shape >= 2 * COUNT - 3, |_| false, |_| true]
            {
                let has_gone = |key: PairKey| gone(key.shapes().0);
                let before = cache.active().to_vec();
                let mut told = Vec::new();
                cache.drop_active(&threads, has_gone, |key, pair| told.push((key, pair.key)));
                let (left, dropped): (Vec<_>, Vec<_>) = before.into_iter().partition(|&(key, _)| !has_gone(key));
                assert_eq!(cache.active(), left);
                assert!(told.into_iter().eq(dropped.iter().map(|&(key, _)| (key, key))));
                assert!(dropped.iter().all(|&(_, slot)| !cache.get(slot).is_active()));
            }
        }
    }

    #[test]
    fn a_lookup_knows_what_is_listed_whoever_asks() {
        let mut cache = large();
        for asking in [0, COUNT as usize] {
            let lookup = cache.lookup(2 * COUNT as usize + 1, asking);
            for shape in 0..2 * COUNT {
                assert!(lookup.has(&PairKey::new(shape, shape + 1)));
                assert!(!lookup.has(&PairKey::new(shape, shape + 2)));
            }
        }
    }
}
