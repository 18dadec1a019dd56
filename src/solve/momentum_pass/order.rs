//! Orders bodies by what stands on what, upper before lower, and divides them among threads.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::super::batch::Batch;
use super::super::buckets::Buckets;
use super::super::contact::LANES;
use super::super::state::WORLD_SLOT;
use super::changes::LaneChanges;
use super::patch::{Balance, BalanceRows, Impulse, PatchPoint, SupportPatch, SupportedBody, describe};
use super::stack::{Along, NO_PLACE, Stacks, Standing};
use super::{MomentumPass, NO_ISLAND, StackIsland};
use crate::load_distribution::BoundedPoint;
use crate::tight_vec::resize;
use crate::workers::Workers;

/// Bodies in stacks from which on several threads go through them, bodies of a storey that are worth another thread's while, some 1 µs, and
/// how long one thread takes for one (µs).
const SHARED_BODIES: usize = 256;
const MIN_BODIES: usize = 4;
const BODY_TIME: f32 = 0.25;

/// Blocks that are worth another thread's while to look through.
const MIN_BLOCKS: usize = 64;

/// What stands on what.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// By block and lane.
    stands: Vec<SupportedBody>,
    /// Those, by the slot of the upper body.
    by_upper: Buckets,
    /// Slots that stand on something, upper before lower: storey after storey.
    slots: Vec<u32>,
    /// Of each slot how many stand on it that are not in order yet, and its storey.
    waiting: Vec<u32>,
    level: Vec<u32>,
    /// By their phases, and by their places.
    pieces: Vec<BodyRange>,
    by_place: Vec<BodyRange>,
    /// By piece, which others bodies stand in that stand on its own, and which those in that its own stand on.
    above_piece: Buckets,
    below_piece: Buckets,
    /// Those, each with the piece below first.
    waits: Vec<(u32, u32)>,
    /// Piece of each place, and for which piece each has been seen last.
    piece_of: Vec<u32>,
    seen_for: Vec<u32>,
    /// Place of each slot.
    places: Vec<u32>,
    /// Lanes by the place of the lower body.
    above: Buckets,
    found_for: FoundFor,
}

/// What all that but stands was found for, besides these: most stacks stand as they did in the step before.
#[derive(Debug, Default)]
struct FoundFor {
    island: Vec<u32>,
    islands: Vec<StackIsland>,
    /// Threads that storeys are cut for, or none where nothing has been found.
    places: usize,
}

impl FoundFor {
    fn is(&self, island: &[u32], islands: &[StackIsland], threads: &Workers) -> bool {
        let asked = |island: &StackIsland| (island.may_be_useful(), island.is_uneven);
        let are_asked = islands.iter().map(asked);
        self.places == places_of(threads) && self.island == island && self.islands.iter().map(asked).eq(are_asked)
    }

    fn set(&mut self, island: &[u32], islands: &[StackIsland], threads: &Workers) {
        self.island.clear();
        self.island.extend_from_slice(island);
        self.islands.clear();
        self.islands.extend_from_slice(islands);
        self.places = places_of(threads);
    }
}

/// Threads that storeys are cut for.
fn places_of(threads: &Workers) -> usize {
    if threads.has_team() { threads.places() } else { 1 }
}

/// Places that one thread goes through at a time; until they are given, bodies in order.
#[derive(Debug, Clone, Copy)]
struct BodyRange {
    phase: u32,
    owner: u32,
    first: u32,
    end: u32,
}

impl Order {
    /// Place of each slot.
    pub(super) fn places(&self) -> &[u32] {
        &self.places
    }

    /// Lanes of the patches that stand on the body at a place.
    pub(super) fn above(&self, place: u32) -> &[u32] {
        self.above.of(place)
    }

    /// The places, upper before lower, in pieces, each with whose it is.
    pub(super) fn pieces(&self) -> impl DoubleEndedIterator<Item = (usize, Range<u32>)> {
        self.pieces.iter().map(|piece| (piece.owner as usize, piece.first..piece.end))
    }

    /// Calls a function for each piece of another owner whose bodies stand on those of a piece.
    pub(super) fn each_above(&self, piece: usize, need: &mut dyn FnMut(usize)) {
        self.above_piece.of(piece as u32).iter().for_each(|&above| need(above as usize));
    }

    /// The same for those that they stand on, where pieces are numbered from the last one.
    pub(super) fn each_below(&self, piece: usize, need: &mut dyn FnMut(usize)) {
        let number = |piece: usize| self.pieces.len() - 1 - piece;
        self.below_piece.of(number(piece) as u32).iter().for_each(|&below| need(number(below as usize)));
    }

    /// Finds which pieces of different owners have bodies that stand on each other.
    fn find_waits(&mut self) {
        let Self { stands, pieces, above_piece, below_piece, waits, piece_of, seen_for, places, above, .. } = self;
        waits.clear();
        if pieces.iter().any(|piece| piece.owner > 0) {
            piece_of.clear();
            piece_of.resize(pieces.iter().map(|piece| piece.end as usize).max().unwrap_or(0), 0);
            for (number, piece) in (0..).zip(&*pieces) {
                piece_of[piece.first as usize..piece.end as usize].fill(number);
            }
            seen_for.clear();
            seen_for.resize(pieces.len(), u32::MAX);
            for (number, piece) in (0..).zip(&*pieces) {
                for &lane in (piece.first..piece.end).flat_map(|place| above.of(place)) {
                    let upper = piece_of[places[stands[lane as usize].upper as usize] as usize];
                    let is_new = std::mem::replace(&mut seen_for[upper as usize], number) != number;
                    if is_new && pieces[upper as usize].owner != piece.owner {
                        waits.push((number, upper));
                    }
                }
            }
        }
        above_piece.sort(pieces.len(), waits.iter().copied());
        below_piece.sort(pieces.len(), waits.iter().map(|&(below, above)| (above, below)));
    }

    /// Cuts storeys that are wide for several threads; what is between them is gone through by one.
    fn cut(&mut self, threads: &Workers) {
        let Self { pieces, slots, level, .. } = self;
        pieces.clear();
        let is_shared = slots.len() >= SHARED_BODIES && threads.has_team();
        let places = if is_shared { threads.places_for(slots.len() as f32 * BODY_TIME, 0) } else { 1 };
        let (mut first, mut phase, mut is_narrow) = (0, 0, false);
        for bodies in slots.chunk_by(|&above, &slot| level[above as usize] == level[slot as usize]) {
            let (count, cuts) = (bodies.len() as u32, places.min(bodies.len() / MIN_BODIES).max(1) as u32);
            match pieces.last_mut().filter(|_| is_narrow && cuts == 1) {
                Some(narrow) => narrow.end += count,
                None => {
                    phase += 1;
                    let cut = |owner: u32| first + count * owner / cuts;
                    pieces.extend((0..cuts).map(|owner| BodyRange { phase, owner, first: cut(owner), end: cut(owner + 1) }));
                }
            }
            is_narrow = cuts == 1;
            first += count;
        }
    }

    fn stands(&self, slot: u32) -> bool {
        !self.by_upper.of(slot).is_empty()
    }
}

impl MomentumPass {
    /// Finds which manifolds bodies stand on in islands that the pass may be for.
    pub(super) fn list_stands(&mut self, batch: &Batch, threads: &Workers) {
        self.find_balance(batch);
        let Self { order, island, islands, balance, axes: [up, ..], .. } = self;
        let contacts = &batch.contacts;
        let is_asked = |stand: &SupportedBody| {
            let own = islands.get(island[stand.upper as usize] as usize);
            own.is_some_and(|island| {
                island.is_being_built() || island.may_be_useful() && balance[stand.upper as usize].is_balanced()
            })
        };
        let is_other = AtomicBool::new(order.stands.len() != contacts.len() * LANES);
        resize(&mut order.stands, contacts.len() * LANES, SupportedBody::NONE);
        let piece = threads.piece(contacts.len(), MIN_BLOCKS);
        threads.share(order.stands.chunks_mut(piece * LANES).zip((0..).step_by(piece)), |(stands, first)| {
            for (stand, number) in stands.iter_mut().zip(0..) {
                let found = SupportedBody::of(contacts, first + number / LANES, number % LANES, *up);
                let found = found.filter(is_asked).unwrap_or(SupportedBody::NONE);
                if std::mem::replace(stand, found) != found {
                    is_other.store(true, Ordering::Relaxed);
                }
            }
        });
        if is_other.into_inner() {
            order.found_for.places = 0;
        }
    }

    /// Finds what would stand on what is under it, in islands of which not all do.
    fn find_balance(&mut self, batch: &Batch) {
        let Self { island, islands, balance, axes: [up, u, v], .. } = self;
        balance.clear();
        if islands.iter().all(|island| island.is_being_built() || !island.may_be_useful()) {
            return;
        }
        balance.resize(island.len(), Balance::NONE);
        for (block, lane) in (0..batch.contacts.len()).flat_map(|block| (0..LANES).map(move |lane| (block, lane))) {
            let Some(stand) = SupportedBody::of(&batch.contacts, block, lane, *up) else { continue };
            for lever in stand.levers(&batch.contacts, block, lane) {
                balance[stand.upper as usize].add(lever.dot(*u), lever.dot(*v));
            }
        }
    }

    /// Finds the order and the places, unless they are those of the last step.
    pub(super) fn put_in_order(&mut self, threads: &Workers) {
        let Self { order, island, islands, .. } = self;
        if !order.found_for.is(island, islands, threads) {
            self.sort();
            self.place_bodies(threads);
            self.order.found_for.set(&self.island, &self.islands, threads);
        } else {
            islands.iter_mut().zip(&order.found_for.islands).for_each(|(island, found)| island.levels = found.levels);
        }
    }

    /// Upper before lower; in circles, those that wait for each other are left out, as are islands that the pass is not for.
    fn sort(&mut self) {
        let Self { order, island, islands, .. } = self;
        let slots = island.len();
        // Lanes without such a manifold are in a bucket that no body has.
        let by_upper = order.stands.iter().enumerate().map(|(number, stand)| (stand.upper.min(slots as u32), number as u32));
        order.by_upper.sort(slots + 1, by_upper);
        order.waiting.clear();
        order.waiting.resize(slots, 0);
        order.stands.iter().filter(|stand| stand.exists()).for_each(|stand| order.waiting[stand.lower as usize] += 1);
        order.level.clear();
        order.level.resize(slots, 1);
        let mut sorted = std::mem::take(&mut order.slots);
        sorted.clear();
        sorted.extend((WORLD_SLOT + 1..slots as u32).filter(|&slot| order.waiting[slot as usize] == 0 && order.stands(slot)));
        let mut next = 0;
        while let Some(&slot) = sorted.get(next) {
            next += 1;
            let level = order.level[slot as usize];
            let island = &mut islands[island[slot as usize] as usize];
            island.levels = island.levels.max(level);
            for &number in order.by_upper.of(slot) {
                let lower = order.stands[number as usize].lower;
                if lower == WORLD_SLOT {
                    continue;
                }
                let (waiting, below) = (&mut order.waiting[lower as usize], &mut order.level[lower as usize]);
                *below = (*below).max(level + 1);
                *waiting -= 1;
                if *waiting == 0 && order.stands(lower) {
                    sorted.push(lower);
                }
            }
        }
        sorted.retain(|&slot| islands[island[slot as usize] as usize].is_useful());
        order.slots = sorted;
    }

    /// Gives every body in order its place, those of one thread in a row, and after them those that stand on nothing but are stood on.
    fn place_bodies(&mut self, threads: &Workers) {
        let Self { order, stacks: Stacks { bodies, .. }, changes, island, islands, .. } = self;
        order.cut(threads);
        let Order { stands, by_upper, slots, level, pieces, by_place, places, above, .. } = order;
        bodies.clear();
        by_place.clear();
        places.clear();
        places.resize(island.len(), NO_PLACE);
        let mut ends = ([0; 2], [0; 2]);
        for owner in 0..pieces.iter().map(|piece| piece.owner + 1).max().unwrap_or(0) {
            for piece in pieces.iter_mut().filter(|piece| piece.owner == owner) {
                let own = piece.first as usize..piece.end as usize;
                piece.first = bodies.len() as u32;
                for &slot in &slots[own] {
                    places[slot as usize] = bodies.len() as u32;
                    let lanes = by_upper.of(slot);
                    let points = lanes.iter().map(|&lane| u32::from(stands[lane as usize].points)).sum::<u32>();
                    let ([_, patch], [_, point]) = ends;
                    ends = ([patch, patch + lanes.len() as u32], [point, point + points]);
                    bodies.push(Standing::new(slot, island[slot as usize], ends));
                }
                piece.end = bodies.len() as u32;
                by_place.push(*piece);
            }
        }
        let first = bodies.len() as u32;
        let ends = ([ends.0[1]; 2], [ends.1[1]; 2]);
        for (slot, place) in places.iter_mut().enumerate() {
            let is_useful = || islands.get(island[slot] as usize).is_some_and(StackIsland::is_useful);
            if *place == NO_PLACE && level[slot] > 1 && is_useful() {
                *place = bodies.len() as u32;
                bodies.push(Standing::new(slot as u32, island[slot], ends));
            }
        }
        if let Some(&BodyRange { phase, .. }) = pieces.last().filter(|_| bodies.len() as u32 > first) {
            let last = BodyRange { phase: phase + 1, owner: 0, first, end: bodies.len() as u32 };
            pieces.push(last);
            by_place.push(last);
        }
        let none = bodies.len() as u32;
        let is_placed = |stand: &SupportedBody| stand.exists() && places[stand.upper as usize] < first;
        let is_above = |stand: &SupportedBody| level[stand.upper as usize] < level[stand.lower as usize];
        let mut between = stands.iter().filter(|stand| is_placed(stand) && places[stand.lower as usize] != NO_PLACE);
        debug_assert!(between.all(is_above), "a body stands on one of its own storey");
        let below = |stand: &SupportedBody| if is_placed(stand) { places[stand.lower as usize].min(none) } else { none };
        above.sort(bodies.len() + 1, stands.iter().enumerate().map(|(lane, stand)| (below(stand), lane as u32)));
        changes.resize_with(stands.len() / LANES, LaneChanges::default);
        for (changes, stands) in changes.iter_mut().zip(stands.chunks(LANES)) {
            changes.begin(stands.iter().map(|stand| if is_placed(stand) { island[stand.upper as usize] } else { NO_ISLAND }));
        }
        order.find_waits();
    }

    /// Describes what bodies stand on, each with the thread that goes through it later.
    pub(super) fn describe(&mut self, batch: &Batch, threads: &Workers) {
        let Self { order, stacks, axes, .. } = self;
        let Order { stands, by_upper, places, by_place, .. } = order;
        let Stacks { bodies, patches, points, bounded, handed, along } = stacks;
        let [patch_count, point_count] = bodies.last().map_or([0; 2], Standing::ends);
        resize(patches, patch_count, SupportPatch::default());
        resize(points, point_count, PatchPoint::default());
        resize(bounded, point_count, BoundedPoint::default());
        resize(handed, stands.len(), Impulse::default());
        resize(along, places.len(), Along::default());
        let mut rest = (&mut bodies[..], &mut patches[..], &mut points[..], &mut bounded[..]);
        let mut before = [0; 2];
        let pieces = by_place.iter().map(|piece| {
            let bodies = take(&mut rest.0, (piece.end - piece.first) as usize);
            let ends = bodies.last().map_or(before, Standing::ends);
            let [patch_count, point_count] = [ends[0] - before[0], ends[1] - before[1]];
            before = ends;
            let own = (take(&mut rest.1, patch_count), take(&mut rest.2, point_count), take(&mut rest.3, point_count));
            (0, piece.owner as usize, (bodies, own))
        });
        threads.share_in_phases(pieces, |(bodies, (mut patches, mut points, mut bounded))| {
            for body in bodies {
                body.rows = BalanceRows::new(&batch.velocities[body.slot as usize], axes);
                let mut first = body.points().start as u32;
                let patches = take(&mut patches, body.patches().len());
                for (&lane, patch) in by_upper.of(body.slot).iter().zip(patches) {
                    let stand = &stands[lane as usize];
                    *patch = SupportPatch::new(&batch.contacts, lane, stand, places[stand.lower as usize], first);
                    first += u32::from(stand.points);
                    let count = usize::from(stand.points);
                    describe(&batch.contacts, patch, &body.rows, take(&mut points, count), take(&mut bounded, count));
                }
            }
        });
    }
}

/// Takes the first elements out of what is left.
fn take<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    rest.split_off_mut(..count).unwrap_or_default()
}
