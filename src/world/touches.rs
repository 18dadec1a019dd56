//! Pairs that touch, as islands and batches ask for them: pairs are far from one another in memory, and are read once, by all threads.

use super::World;
use super::index::Index;
use crate::collide::pairs::{Pair, PairKey};
use crate::material::PairMaterial;
use crate::room::extend_tightly;

/// A pair that touches, or did in the step before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    pub slot: u32,
    pub bodies: [u32; 2],
    /// None where it touched in the step before alone.
    pub manifolds: u16,
    /// Points of all its manifolds.
    pub points: u16,
    /// Whether it neither rebounds nor resists rolling or spinning by itself.
    pub is_plain: bool,
}

impl Touch {
    /// What there is to list of a pair, if anything.
    pub(super) fn of(key: PairKey, slot: u32, pair: &Pair, index: &Index) -> Option<Self> {
        if !pair.has_points() && !pair.in_contact {
            return None;
        }
        let (a, b) = key.shapes();
        let points = pair.manifolds.iter().map(|manifold| manifold.points.len() as u16).sum();
        let is_plain = PairMaterial::combine(&index.stance(a).material, &index.stance(b).material).is_plain();
        Some(Self {
            slot,
            bodies: [a, b].map(|shape| index.body_of(shape)),
            manifolds: pair.manifolds.len() as u16,
            points,
            is_plain,
        })
    }
}

/// Those of a step, in the order of the pairs: parts of the list, one after another.
#[derive(Debug, Default)]
pub(super) struct Touches {
    parts: Vec<Vec<Touch>>,
    count: usize,
    /// Whether they are those of the active pairs as contacts were just brought up to date.
    are_new: bool,
}

impl Touches {
    /// Parts to be filled anew.
    pub(super) fn begin(&mut self, parts: usize) -> &mut [Vec<Touch>] {
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
    pub(super) fn touching(&self) -> impl Iterator<Item = &Touch> {
        self.all().filter(|touch| touch.manifolds > 0)
    }

    /// Those that touched in the step before alone.
    pub(super) fn parted(&self) -> impl Iterator<Item = &Touch> {
        self.all().filter(|touch| touch.manifolds == 0)
    }

    /// Those that touch, or did in the step before: parts, one after another.
    pub(super) fn parts(&self) -> impl Iterator<Item = &[Touch]> {
        self.parts[..self.count].iter().map(Vec::as_slice)
    }

    pub(super) fn len(&self) -> usize {
        self.parts().map(<[Touch]>::len).sum()
    }

    fn all(&self) -> impl Iterator<Item = &Touch> {
        self.parts().flatten()
    }
}

impl World {
    /// Lists what touches, if that was not done as contacts were brought up to date.
    pub(super) fn list_touches(&mut self) {
        let Self { touches, pairs, index, .. } = self;
        if std::mem::take(&mut touches.are_new) {
            return;
        }
        let found = pairs.active().iter().filter_map(|&(key, slot)| Touch::of(key, slot, pairs.get(slot), index));
        extend_tightly(&mut touches.begin(1)[0], found);
    }
}
