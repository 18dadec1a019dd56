//! Touching pairs in one compact list, filled once a step by all threads; the pair records are far apart in memory.

use super::body_shape_table::BodyShapeTable;
use super::{Collision, World};
use crate::collide::pairs::{Pair, PairKey};
use crate::material::PairMaterial;
use crate::tight_vec::extend_tightly;

/// A pair that touches, or did in the step before.
#[derive(Debug, Clone, Copy)]
pub(super) struct TouchingPair {
    pub slot: u32,
    pub bodies: [u32; 2],
    /// None where it touched in the step before alone.
    pub manifolds: u16,
    /// Points of all its manifolds.
    pub points: u16,
    /// Whether it neither rebounds nor resists rolling or spinning by itself.
    pub is_plain: bool,
    /// Whether it presses with a round shape that has moved: its features may be swung.
    pub may_swing: bool,
}

impl TouchingPair {
    /// What there is to list of a pair, if anything.
    pub(super) fn of(key: PairKey, slot: u32, pair: &Pair, index: &BodyShapeTable) -> Option<Self> {
        if !pair.has_points() && !pair.in_contact {
            return None;
        }
        let (a, b) = key.shapes();
        let points = pair.manifolds.iter().map(|manifold| manifold.points.len() as u16).sum();
        let (of_a, of_b) = (index.collider_state(a), index.collider_state(b));
        let is_plain = PairMaterial::combine(&of_a.material, &of_b.material).is_plain();
        let may_swing = pair.updated && pair.pressed && (of_a.is_round || of_b.is_round);
        Some(Self {
            slot,
            bodies: [a, b].map(|shape| index.body_of(shape)),
            manifolds: pair.manifolds.len() as u16,
            points,
            is_plain,
            may_swing,
        })
    }
}

/// Those of a step, in the order of the pairs: parts of the list, one after another.
#[derive(Debug, Default)]
pub(super) struct TouchingPairs {
    parts: Vec<Vec<TouchingPair>>,
    count: usize,
    /// Whether they are those of the active pairs as contacts were just brought up to date.
    are_new: bool,
}

impl TouchingPairs {
    /// Parts to be filled anew.
    pub(super) fn begin(&mut self, parts: usize) -> &mut [Vec<TouchingPair>] {
        self.parts.resize_with(self.parts.len().max(parts), Vec::new);
        self.parts.iter_mut().for_each(Vec::clear);
        (self.count, self.are_new) = (parts, true);
        &mut self.parts[..parts]
    }

    /// Takes note that other pairs are active.
    pub(super) fn outdate(&mut self) {
        self.are_new = false;
    }

    /// Those that touch.
    pub(super) fn touching(&self) -> impl Iterator<Item = &TouchingPair> {
        self.all().filter(|touch| touch.manifolds > 0)
    }

    /// Those that touched in the step before alone.
    pub(super) fn parted(&self) -> impl Iterator<Item = &TouchingPair> {
        self.all().filter(|touch| touch.manifolds == 0)
    }

    /// Those that touch, or did in the step before: parts, one after another.
    pub(super) fn parts(&self) -> impl Iterator<Item = &[TouchingPair]> {
        self.parts[..self.count].iter().map(Vec::as_slice)
    }

    /// Leaves out those that are not to be kept.
    pub(super) fn retain(&mut self, mut keeps: impl FnMut(&TouchingPair) -> bool) {
        self.parts[..self.count].iter_mut().for_each(|part| part.retain(&mut keeps));
    }

    pub(super) fn len(&self) -> usize {
        self.parts().map(<[TouchingPair]>::len).sum()
    }

    fn all(&self) -> impl Iterator<Item = &TouchingPair> {
        self.parts().flatten()
    }
}

impl World {
    /// Lists what touches, if that was not done as contacts were brought up to date.
    pub(super) fn list_touches(&mut self) {
        let Self { collision: Collision { touches, pairs, index, .. }, .. } = self;
        if std::mem::take(&mut touches.are_new) {
            return;
        }
        let found = pairs.active().iter().filter_map(|&(key, slot)| TouchingPair::of(key, slot, pairs.get(slot), index));
        extend_tightly(&mut touches.begin(1)[0], found);
    }
}
