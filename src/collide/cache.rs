//! Pairs of shapes that may touch: found by key, walked in key order.
//!
//! A pair is *active* while one of its bodies can move by itself; the pairs of a sleeping island are kept by the island.

mod defragment;

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::active_hits::{ActiveHit, ActiveHits};
use super::pairs::{Pair, PairKey};
use super::persistent_manifold::Manifolds;
use crate::prefetch::{AHEAD, prefetch};
use crate::tight_vec::{make_room, make_room_behind};
use crate::workers::Workers;

use defragment::MIN_TIDIED;
pub(crate) use defragment::put_in_places;

/// Pairs of which it is worth another thread's while to ask whether they have gone: some 5 µs.
const MIN_ASKED: usize = 2048;

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
    /// Hits under way.
    pub(crate) blows: ActiveHits,
}

impl PairCache {
    /// A cache of active pairs, sorted by key, and of pairs that sleep, which take the slots after them, each with the hit under way;
    /// `None` if not sorted. `extent` is told the lesser least extent of two shapes (m).
    pub(crate) fn from_parts(
        (active, hits): (Vec<Pair>, Vec<ActiveHit>),
        (asleep, later): (Vec<Pair>, Vec<ActiveHit>),
        extent: impl Fn(PairKey) -> f32,
    ) -> Option<Self> {
        if !active.windows(2).all(|two| two[0].key < two[1].key) {
            return None;
        }
        let keys = active.iter().enumerate().map(|(slot, pair)| (pair.key, slot as u32)).collect();
        let mut pairs = active;
        pairs.iter_mut().for_each(|pair| pair.active = true);
        pairs.extend(asleep);
        pairs.iter_mut().for_each(|pair| pair.note_pressed(extent(pair.key)));
        let mut blows = ActiveHits::default();
        (0..).zip(hits.into_iter().chain(later)).for_each(|(slot, blow)| blows.set(slot, blow));
        Some(Self { pairs, active: keys, blows, ..Self::default() })
    }

    /// The hit under way of a pair; nothing if there is none.
    pub(crate) fn blow_of(&self, slot: u32) -> ActiveHit {
        self.blows.get(slot).copied().unwrap_or_default()
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

    /// Active pairs as of [`active`](Self::active), and the records of all slots.
    pub(crate) fn active_and_slots(&mut self) -> (&[(PairKey, u32)], &mut [Pair]) {
        self.settle();
        (&self.active, &mut self.pairs)
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

    /// Whether there are so many active pairs that where their records lie in memory matters.
    pub(crate) fn is_large(&self) -> bool {
        self.active.len() >= MIN_TIDIED
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

    /// Takes note of how fast the points of pairs that may touch approach each other (m/s).
    pub(crate) fn note_approaches(&mut self, approach: impl Fn(&Pair) -> f32) {
        self.settle();
        let Self { active, pairs, blows, .. } = self;
        for &(_, slot) in &*active {
            let pair = &pairs[slot as usize];
            if pair.may_touch {
                blows.note(slot, approach(pair));
            }
        }
    }

    /// Active pairs with a hit under way, in key order.
    pub(crate) fn active_hits(&self) -> Vec<(PairKey, u32)> {
        let listed = self.blows.slots().map(|slot| (self.get(slot).key, slot));
        let mut hits: Vec<_> = listed.filter(|&(_, slot)| self.get(slot).active).collect();
        hits.sort_unstable();
        hits
    }

    /// Every slot of the cache, also those not in use or asleep; see [`is_active`](Self::is_active).
    pub(crate) fn slots_mut(&mut self) -> &mut [Pair] {
        &mut self.pairs
    }

    /// Adds pairs of a settled list, none of which is active (`keys` are sorted, without repeats).
    pub(crate) fn activate_new(&mut self, keys: &[PairKey]) {
        debug_assert!(self.is_settled() && keys.iter().all(|&key| self.find(key).is_none()), "a pair is active already");
        let mut fresh = Vec::with_capacity(keys.len());
        for &key in keys {
            if let Some(&next) = self.free.len().checked_sub(1 + AHEAD).and_then(|place| self.free.get(place)) {
                prefetch(&self.pairs[next as usize]);
            }
            fresh.push((key, self.allocate(key)));
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
        let piece = if threads.has_team() { threads.piece(active.len(), MIN_ASKED) } else { active.len().max(1) };
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

    /// Calls `fate` with the key and slot of every active pair, in key order, and keeps, stores or releases the pair as it says.
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
        self.blows.forget(slot);
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
    use crate::collide::narrow::Manifold;
    use crate::collide::persistent_manifold::{CarriedManifold, Kind};

    const COUNT: u32 = 2 * MIN_TIDIED as u32;

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
        PairCache::from_parts((pairs, Vec::new()), Default::default(), |_| 0.3).expect("sorted")
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
