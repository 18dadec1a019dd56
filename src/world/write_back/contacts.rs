//! Writes multipliers of contacts back, on all threads where there are many: each pair's manifolds are in one piece.

use std::ops::Range;

use glam::Vec3;

use crate::collide::pairs::Pair;
use crate::prefetch::{AHEAD, prefetch};
use crate::solve::batch::Batch;
use crate::solve::contact::TOUCHED;
use crate::solve::disjoint::{DisjointSlices, Slots};
use crate::world::body_shape_table::BodyShapeTable;
use crate::world::{Batches, Collision, World};

/// Manifolds of a batch from which on their multipliers are written back by all threads, and those that are worth another thread's while.
pub(super) const SHARED_MANIFOLDS: usize = 1024;
const MIN_MANIFOLDS: usize = 128;

/// Force of a manifold on the second of two bodies (N), and whether its pair presses that did not, or no longer does.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::world) struct Pull {
    bodies: [u32; 2],
    force: Vec3,
    has_changed: bool,
}

/// What the contacts of a batch are written back from.
struct Results<'a> {
    batch: &'a Batch,
    index: &'a BodyShapeTable,
    /// Share of a substep's multipliers that one of the world's substeps has.
    share: f32,
    /// Length of one of those (s).
    substep: f32,
    is_judged: bool,
}

impl Results<'_> {
    /// Keeps the multipliers of a manifold, and returns its force on the second shape.
    fn store(&self, i: usize, pair: &mut Pair) -> Vec3 {
        let batch = self.batch;
        let mut impulses = batch.contact_impulses(i).scaled(self.share);
        let manifold = batch.manifolds.list[i].1 as usize;
        let pressed = impulses.normal.iter().sum::<f32>();
        let rebound = if pressed > 0.0 { 0.0 } else { batch.contact_rebound(i) };
        if rebound > 0.0 {
            impulses.normal[0] = TOUCHED;
        }
        if !impulses.normal.iter().sum::<f32>().is_finite() || !impulses.friction.is_finite() {
            pair.forget_impulses();
            return Vec3::ZERO;
        }
        if self.is_judged {
            let key = pair.key;
            pair.store_told(manifold, impulses, batch.contact_told(i), || self.index.least_extent(key));
        } else {
            pair.store(manifold, impulses);
        }
        (batch.contact_normal(i) * (pressed + rebound) + impulses.friction) / self.substep
    }

    fn pull(&self, i: usize, pair: &mut Pair) -> Pull {
        Pull {
            bodies: <[u32; 2]>::from(pair.key.shapes()).map(|shape| self.index.body_of(shape)),
            force: self.store(i, pair),
            has_changed: pair.pressed != pair.in_contact,
        }
    }

    /// Keeps the multipliers of some manifolds, and tells of each.
    #[inline(always)]
    fn each(&self, range: Range<usize>, pairs: &mut (impl Slots<Pair> + ?Sized), mut tell: impl FnMut(usize, Pull)) {
        for i in range.clone() {
            ask_for_next(&self.batch.manifolds.list[i..range.end], &*pairs);
            self.batch.ask_for_contact(i + AHEAD);
            tell(i, self.pull(i, pairs.get_mut(self.batch.manifolds.list[i].0)));
        }
    }
}

impl World {
    /// Writes back the contacts of runs of small batches.
    pub(super) fn store_contacts_of_runs(&mut self, dt: f32) {
        let substep = dt / self.def.substeps as f32;
        let Self {
            batches: Batches { list: batches, .. },
            collision: Collision { pairs, index, .. },
            support,
            scratch,
            threads,
            ..
        } = self;
        let is_judged = support.as_ref().is_some_and(|support| support.is_awake());
        let slots = DisjointSlices::new(pairs.slots_mut());
        scratch.runs.each(threads, |run, notes| {
            // SAFETY: all manifolds of a pair are in one batch.
            let mut pairs = unsafe { slots.part() };
            notes.pulls.clear();
            for batch in &batches[run] {
                let results = Results { batch, index, share: 1.0 / batch.stride, substep, is_judged };
                results.each(0..batch.manifolds.list.len(), &mut pairs, |_, pull| notes.pulls.push(pull));
            }
        });
    }

    pub(super) fn store_contacts(&mut self, number: usize, dt: f32) {
        self.store_blows(number);
        let substep = dt / self.def.substeps as f32;
        let Self {
            batches: Batches { list: batches, .. },
            collision: Collision { pairs, index, .. },
            support,
            scratch,
            threads,
            ..
        } = self;
        let batch = &batches[number];
        let changed = &mut scratch.changed;
        let mut note = |index: &mut BodyShapeTable, slot: u32, pull: &Pull| {
            index.add_contact(pull.bodies, pull.force);
            if pull.has_changed {
                changed.push(slot);
            }
        };
        if scratch.runs.has(number) {
            if let Some(notes) = scratch.runs.notes_from(number) {
                let manifolds = batches[number..].iter().flat_map(|batch| &batch.manifolds.list);
                notes.pulls.iter().zip(manifolds).for_each(|(pull, &(slot, _))| note(index, slot, pull));
            }
            return;
        }
        let is_judged = support.as_ref().is_some_and(|support| support.is_awake());
        let share = 1.0 / batch.stride;
        if batch.manifolds.list.len() < SHARED_MANIFOLDS || !threads.has_team() {
            for (i, &(slot, _)) in batch.manifolds.list.iter().enumerate() {
                ask_for_next(&batch.manifolds.list[i..], &*pairs.slots_mut());
                batch.ask_for_contact(i + AHEAD);
                let pull = Results { batch, index, share, substep, is_judged }.pull(i, pairs.get_mut(slot));
                note(index, slot, &pull);
            }
            return;
        }
        scratch.pulls.clear();
        scratch.pulls.resize(batch.manifolds.list.len(), Pull::default());
        let slots = DisjointSlices::new(pairs.slots_mut());
        let pieces = pieces_by_pair(&batch.manifolds.list, threads.piece(batch.manifolds.list.len(), MIN_MANIFOLDS));
        let mut rest = &mut scratch.pulls[..];
        let pieces = pieces.map(|range| (rest.split_off_mut(..range.len()).unwrap_or_default(), range));
        let results = Results { batch, index, share, substep, is_judged };
        threads.share(pieces, |(pulls, range)| {
            // SAFETY: all manifolds of a pair are in one piece.
            let mut pairs = unsafe { slots.part() };
            results.each(range.clone(), &mut pairs, |i, pull| pulls[i - range.start] = pull);
        });
        scratch.pulls.iter().zip(&batch.manifolds.list).for_each(|(pull, &(slot, _))| note(index, slot, pull));
    }

    /// Adds what contacts have given to the hits under way.
    fn store_blows(&mut self, number: usize) {
        let Self { batches: Batches { list: batches, .. }, collision: Collision { pairs, .. }, .. } = self;
        if pairs.blows.is_empty() {
            return;
        }
        let batch = &batches[number];
        for (i, &(slot, _)) in batch.manifolds.list.iter().enumerate() {
            if let Some(blow) = pairs.blows.get_mut(slot) {
                let impulse = batch.contact_blow(i);
                blow.impulse += if impulse.is_finite() { impulse } else { 0.0 };
            }
        }
    }
}

/// Asks for the memory of the pairs of manifolds that come next, and of their multipliers.
#[inline(always)]
fn ask_for_next(coming: &[(u32, u32)], pairs: &(impl Slots<Pair> + ?Sized)) {
    if let Some(&(slot, _)) = coming.get(2 * AHEAD) {
        prefetch(pairs.get(slot));
    }
    if let Some(&(slot, _)) = coming.get(AHEAD) {
        pairs.get(slot).manifolds.prefetch_impulses();
    }
}

/// Ranges of so many manifolds, and a few more where others of the same pair follow.
fn pieces_by_pair(manifolds: &[(u32, u32)], length: usize) -> impl Iterator<Item = Range<usize>> + '_ {
    let mut next = 0;
    std::iter::from_fn(move || {
        let first = next;
        next = manifolds.len().min(first + length);
        while next < manifolds.len() && manifolds[next].0 == manifolds[next - 1].0 {
            next += 1;
        }
        (first < next).then_some(first..next)
    })
}
