//! Finds the pairs whose links may have changed in the step.
//!
//! Any pair that touches may be one. Whether it is, is told from the pair itself while contacts are reported: by the word that was
//! found for it last, what the solver has told of it, and a byte for each shape. In a pile that moves nearly all contacts slide, and
//! go on sliding; what slides carries nothing, wherever it is.

use glam::Quat;

use super::pair_view::{PairFrame, PairView, TURN, has_reserve};
use super::{SupportState, World};
use crate::body::Body;
use crate::collide::cache::PairCache;
use crate::collide::collider::Collider;
use crate::collide::pairs::{Pair, PairKey, TOO_MANY, Word};
use crate::id::{BodyId, Pool, ShapeId};
use crate::joint_graph::support::slip::Slip;

/// Links of its body are to be made anew.
pub(super) const TURNED: u8 = 1;
/// So fast that its links may slide where friction is spent, and so fast that they may leave.
const FAST: u8 = 2;
const LEAVING: u8 = 4;

/// What may have changed the links of a body that is not held; `made_for` is the rotation that they were made for.
fn signs_of(body: &Body, made_for: &mut Quat, colliders: &Pool<Collider, ShapeId>) -> u8 {
    // Not-a-number counts as turned.
    let is_near = ((body.rotation - *made_for).length() * 2.0) <= TURN;
    if !is_near {
        *made_for = body.rotation;
    }
    let reaches = body.shapes.iter().filter_map(|&id| colliders.find(id).ok()).map(|shape| colliders[shape].reach);
    let speed = body.linear_velocity.length() + body.angular_velocity.length() * reaches.fold(0.0, f32::max);
    // Of two bodies each may have half of it; not-a-number counts as fast.
    let stays_below = |limit: f32| speed <= 0.5 * limit;
    let sign = |holds: bool, sign: u8| if holds { sign } else { 0 };
    sign(!is_near, TURNED) | sign(!stays_below(Slip::STILL_HOLDS), FAST) | sign(!stays_below(Slip::LEAVES), LEAVING)
}

/// Whether friction of any manifold is at its limit.
fn is_spent(pair: &Pair, colliders: &Pool<Collider, ShapeId>) -> bool {
    let (a, b) = pair.key.shapes();
    let friction = colliders[a].surface_with(&colliders[b]).friction;
    pair.manifolds.iter().any(|manifold| !has_reserve(&manifold, friction))
}

impl SupportState {
    /// Whether it is kept up at all in this step.
    pub fn is_awake(&self) -> bool {
        !self.rest.rests && self.frame.is_some()
    }

    /// Takes note of the points of a pair that touch after the step, and whether it is to be looked at. Its key is that of the pair, which
    /// begins in another line of memory than what else is asked here.
    pub fn note_touching(&mut self, (key, slot): (PairKey, u32), pair: &mut Pair, colliders: &Pool<Collider, ShapeId>) {
        let bits = pair.touches;
        let is_same = bits == std::mem::replace(&mut pair.touching, bits) && bits != TOO_MANY && !pair.updated;
        if bits != 0 && self.by_thrust {
            self.pressed.push(slot);
        }
        // What touches nowhere, and did not when it was looked at, has no links.
        if self.changed.is_new || (bits == 0 && pair.word == Word::Nothing) {
            return;
        }
        let (a, b) = key.shapes();
        let signs = self.signs[a as usize] | self.signs[b as usize];
        let stays = match pair.word {
            Word::Nothing | Word::Unsettled => false,
            Word::Holds if !is_same || signs & TURNED != 0 => false,
            Word::Holds if pair.is_told() => Slip::told_to_hold(pair.told, true),
            Word::Holds => signs & LEAVING == 0 && (signs & FAST == 0 || !is_spent(pair, colliders)),
            Word::Slides(rise) => {
                bits != 0 && pair.is_told() && !Slip::told_to_hold(pair.told, false) && pair.told.rise() == rise
            }
        };
        if !stays {
            self.near.push(slot);
        }
    }

    /// Looks at those of the pairs just reported that are to be looked at.
    pub fn look_at_near(&mut self, pairs: &mut PairCache, colliders: &Pool<Collider, ShapeId>, bodies: &Pool<Body, BodyId>) {
        let Some(frame) = self.frame else { return };
        let mut near = std::mem::take(&mut self.near);
        for slot in near.drain(..) {
            let site = PairView::new(pairs.get(slot), slot, colliders, bodies);
            // What is held was judged when it came to rest, but for what moves beside it.
            let (a, b) = site.bodies;
            let rests = (a.held || b.held) && !a.is_solved() && !b.is_solved();
            let word = if rests { Word::Unsettled } else { self.sync_pair(&site, &frame) };
            pairs.get_mut(slot).word = word;
        }
        self.near = near;
    }
}

impl World {
    /// Readies the analysis for contacts that are about to be reported: what bodies there are, and which of them have stirred.
    pub(in crate::world) fn prepare_support(&mut self) {
        let Some(mut state) = self.support.take() else { return };
        if state.gravity != self.def.gravity {
            state.turn_to(self.def.gravity);
        }
        self.forget_released(&mut state);
        if !state.rest.rests {
            self.sync_bodies(&mut state);
            self.note_signs(&mut state);
        }
        self.support = Some(state);
    }

    /// Takes the links of pairs that were given up out of the graph.
    pub(super) fn forget_released(&mut self, state: &mut SupportState) {
        for &slot in self.collision.pairs.released() {
            let key = state.records.get(slot as usize).and_then(|record| record.key);
            if key.is_some_and(|key| !self.collision.pairs.holds(slot, key)) {
                state.forget_pair(slot);
            }
        }
        self.collision.pairs.forget_released();
    }

    fn note_signs(&self, state: &mut SupportState) {
        state.signs.clear();
        state.signs.resize(self.colliders.slot_count(), 0);
        for &index in &self.movers.slots {
            let Some(body) = self.bodies.get(index).filter(|body| !body.held) else { continue };
            let signs = signs_of(body, &mut state.made_for[index as usize], &self.colliders);
            for shape in body.shapes.iter().filter_map(|&id| self.colliders.find(id).ok()) {
                state.signs[shape as usize] = signs;
            }
        }
    }

    /// Looks at the pairs that were not looked at when contacts were reported: all of them where everything is new, and those that
    /// have come to rest.
    pub(super) fn sync_contacts(&mut self, state: &mut SupportState) {
        let Some(frame) = state.frame else { return };
        if state.changed.is_new {
            self.note_signs(state);
            for (slot, word) in self.sync_all(state, &frame) {
                self.collision.pairs.get_mut(slot).word = word;
            }
        }
        for number in 0..state.came_to_rest.len() {
            let slot = state.came_to_rest[number];
            // What was dropped meanwhile has no contacts any more.
            if self.collision.pairs.get(slot).has_points() {
                let site = PairView::new(self.collision.pairs.get(slot), slot, &self.colliders, &self.bodies);
                let word = state.sync_pair(&site, &frame);
                self.collision.pairs.get_mut(slot).word = word;
            }
        }
        state.changed.is_new = false;
    }

    /// Looks at all pairs, also those that sleep, and says what it found.
    pub(super) fn sync_all(&self, state: &mut SupportState, frame: &PairFrame) -> Vec<(u32, Word)> {
        let listed = self.collision.pairs.listed();
        let slots = listed.iter().map(|&(_, slot)| slot).chain(self.islands.sleeping.pairs());
        let look = |slot: u32| {
            let site = PairView::new(self.collision.pairs.get(slot), slot, &self.colliders, &self.bodies);
            (slot, state.sync_pair(&site, frame))
        };
        slots.map(look).collect()
    }
}
