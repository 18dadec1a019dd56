//! Broad phase: which shapes may touch, from enlarged [`aabb_set`](super::aabb_set).
//!
//! A shape's kept box changes only when the shape leaves it; only then are new neighbours looked for. The form of a tree of boxes
//! depends on history, but what it reports does not: it only ever adds candidates, and those too far apart are dropped exactly.

use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::aabb_set::AabbSet;
use super::pairs::PairKey;
use crate::tight_vec::give_back_room;
use crate::workers::Workers;

/// Shapes of one group from which on what is near all of them is asked for at once, and up to how many others are then looked at one
/// by one: members of a union lie close, and would find one another mostly.
pub(crate) const LARGE_GROUP: usize = 8;
pub(crate) const FEW_SHAPES: usize = 16;

/// Changed shapes that are worth another thread's while: some 20 µs.
const MIN_SHAPES: usize = 32;

/// Boxes of all shapes, by slot.
#[derive(Default)]
pub(crate) struct BroadPhase {
    boxes: AabbSet,
    /// Shapes whose neighbours are to be looked for at the next [`refresh`](Self::refresh), as their kept box changed or may meet others.
    changed: Vec<u32>,
    /// Whether each shape is one of them.
    is_changed: Vec<bool>,
    /// What was found of each piece of them.
    found: Vec<FoundPairs>,
}

/// What was found of a piece of the changed shapes.
#[derive(Default)]
struct FoundPairs {
    pairs: Vec<PairKey>,
    /// What is near a group.
    near: Vec<(u32, Aabb)>,
}

impl BroadPhase {
    /// Keeps a box for a shape, whose neighbours are looked for at the next refresh. What a step changes is said by
    /// [`revisit`](Self::revisit) alone, as a refresh asks for the boxes.
    pub(crate) fn place(&mut self, shape: u32, kept: Aabb) {
        self.boxes.set(shape, kept);
        self.revisit(shape);
    }

    /// Shapes whose neighbours are to be looked for at the next refresh.
    pub(crate) fn changed(&self) -> &[u32] {
        &self.changed
    }

    /// Holds these boxes and no others.
    pub(crate) fn rebuild(&mut self, slots: usize, box_of: impl Fn(u32) -> Option<Aabb>, changed: Vec<u32>) {
        let held: Vec<u32> = self.boxes.shapes().collect();
        for shape in held {
            if box_of(shape).is_none() {
                self.boxes.remove(shape);
            }
        }
        self.boxes.set_all(slots, (0..slots as u32).filter_map(|shape| Some((shape, box_of(shape)?))));
        self.forget_changes();
        self.is_changed.resize(slots, false);
        changed.into_iter().filter(|&shape| (shape as usize) < slots).for_each(|shape| self.revisit(shape));
    }

    fn forget_changes(&mut self) {
        self.changed.drain(..).for_each(|shape| self.is_changed[shape as usize] = false);
    }

    pub(crate) fn remove(&mut self, shape: u32) {
        // Where it is still listed as changed, it is passed over as one without a box.
        self.boxes.remove(shape);
    }

    /// Looks for a shape's neighbours at the next refresh, whether its box changes or not.
    pub(crate) fn revisit(&mut self, shape: u32) {
        let slot = shape as usize;
        if self.is_changed.len() <= slot {
            self.is_changed.resize(slot + 1, false);
        }
        if !std::mem::replace(&mut self.is_changed[slot], true) {
            self.changed.push(shape);
        }
    }

    /// Brings the boxes up to date and puts every (changed shape, neighbour) that `is_new` into an empty list, in no particular
    /// order and each once, but for two of the same group. Nothing is looked for near shapes that do not `seek`, which are in no new pair.
    pub(crate) fn refresh(
        &mut self,
        threads: &Workers,
        (box_of, seeks): (impl Fn(u32) -> Option<Aabb> + Sync, impl Fn(u32) -> bool + Sync),
        group_of: impl Fn(u32) -> Option<u32> + Sync,
        is_new: impl Fn(&PairKey) -> bool + Sync,
        candidates: &mut Vec<PairKey>,
    ) {
        let Self { boxes, changed, is_changed, found } = self;
        if changed.is_empty() {
            return;
        }
        changed.sort_unstable_by_key(|&shape| (group_of(shape), shape));
        boxes.set_all(changed.len(), changed.iter().filter_map(|&shape| Some((shape, box_of(shape)?))));
        let (boxes, all_changed) = (&*boxes, &*is_changed);
        let sought = |shape: u32| box_of(shape).filter(|_| seeks(shape));
        let piece = threads.piece(changed.len(), MIN_SHAPES);
        let pieces = changed.len().div_ceil(piece);
        found.resize_with(found.len().max(pieces), FoundPairs::default);
        std::mem::swap(candidates, &mut found[0].pairs);
        threads.share(changed.chunks(piece).zip(&mut *found), |(shapes, found)| {
            found.look((boxes, shapes, all_changed), &sought, &group_of, &is_new);
        });
        std::mem::swap(candidates, &mut found[0].pairs);
        for found in &mut found[1..pieces] {
            candidates.append(&mut found.pairs);
            give_back_room(&mut found.pairs);
        }
        self.forget_changes();
    }

    /// Appends the shapes whose kept box a path enters (`enters` says where, of the box's corners), in no particular order.
    pub(crate) fn along(&self, enters: impl Fn(Vec3, Vec3) -> Option<f64>, found: &mut Vec<(f64, u32)>) {
        self.boxes.along(enters, found);
    }

    /// Shapes whose kept box meets `region`, in no particular order.
    pub(crate) fn overlapping<'a>(&'a self, region: &'a Aabb) -> impl Iterator<Item = u32> + 'a {
        self.boxes.overlapping(region)
    }
}

impl FoundPairs {
    /// Lists the new pairs of these shapes with their neighbours. A group that is cut into two pieces is looked for as two.
    fn look(
        &mut self,
        (boxes, shapes, is_changed): (&AabbSet, &[u32], &[bool]),
        box_of: &impl Fn(u32) -> Option<Aabb>,
        group_of: &impl Fn(u32) -> Option<u32>,
        is_new: &impl Fn(&PairKey) -> bool,
    ) {
        for shapes in shapes.chunk_by(|&a, &b| group_of(a).is_some() && group_of(a) == group_of(b)) {
            let group = group_of(shapes[0]);
            let is_other = |&other: &u32| group.is_none() || group_of(other) != group;
            // Where both have changed, the lower one finds the pair.
            let is_ours = |shape: u32, other: u32| shape < other || shape > other && !is_changed[other as usize];
            if shapes.len() >= LARGE_GROUP {
                let own = shapes.iter().filter_map(|&shape| box_of(shape));
                let Some(whole) = own.reduce(|whole, kept| whole.merged(&kept)) else { continue };
                let others = boxes.overlapping(&whole).filter(is_other).take(FEW_SHAPES + 1);
                self.near.clear();
                self.near.extend(others.filter_map(|other| Some((other, box_of(other)?))));
                if self.near.len() <= FEW_SHAPES {
                    for &shape in shapes {
                        let Some(kept) = box_of(shape) else { continue };
                        let meeting = self.near.iter().filter(|&&(other, near)| is_ours(shape, other) && kept.intersects(&near));
                        self.pairs.extend(meeting.map(|&(other, _)| PairKey::new(shape, other)).filter(is_new));
                    }
                    continue;
                }
            }
            for &shape in shapes {
                if let Some(kept) = box_of(shape) {
                    let found = boxes.overlapping(&kept).filter(|&other| is_ours(shape, other)).filter(is_other);
                    found.map(|other| PairKey::new(shape, other)).filter(is_new).for_each(|key| self.pairs.push(key));
                }
            }
        }
    }
}

/// Whether two kept boxes still meet.
pub(crate) fn still_near(a: &Option<Aabb>, b: &Option<Aabb>) -> bool {
    matches!((a, b), (Some(a), Some(b)) if a.intersects(b))
}

impl std::fmt::Debug for BroadPhase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BroadPhase").field("changed", &self.changed.len()).finish_non_exhaustive()
    }
}
