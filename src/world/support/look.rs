//! Which pairs the analysis looks at in a step: those of which something may have changed that links are made from.
//!
//! While a body turns or is fast that may be any pair that touches. Those are looked at while contacts are reported: going through
//! all pairs again later takes longer than judging them.

use glam::Quat;

use super::record::{FAST, HELD, LEAVING, TURNED};
use super::site::{Site, TURN};
use super::{SupportState, World};
use crate::body::Body;
use crate::collide::cache::PairCache;
use crate::collide::collider::Collider;
use crate::collide::pairs::{Pair, TOO_MANY};
use crate::id::{BodyId, Pool, ShapeId};
use crate::span::support::slip::Slip;

/// What may have changed the links of a body that is not held; `turn` is the rotation that they were made for, and whether it has
/// turned since.
fn signs_of(body: &Body, turn: &mut (Quat, bool), colliders: &Pool<Collider, ShapeId>) -> u8 {
    let (made_for, turned) = turn;
    // Not-a-number counts as turned.
    let is_near = ((body.rotation - *made_for).length() * 2.0) <= TURN;
    if !is_near {
        (*made_for, *turned) = (body.rotation, true);
    }
    let reaches = body.shapes.iter().filter_map(|&id| colliders.find(id).ok()).map(|shape| colliders[shape].reach);
    let speed = body.linear_velocity.length() + body.angular_velocity.length() * reaches.fold(0.0, f32::max);
    // Of two bodies each may have half of it; not-a-number counts as fast.
    let stays_below = |limit: f32| speed <= 0.5 * limit;
    let sign = |holds: bool, sign: u8| if holds { sign } else { 0 };
    let is_fast = !stays_below(Slip::STILL_HOLDS);
    sign(*turned, TURNED) | sign(is_fast, FAST) | sign(!stays_below(Slip::LEAVES), LEAVING)
}

impl SupportState {
    /// Whether it is kept up at all in this step.
    pub fn is_awake(&self) -> bool {
        !self.rests && self.frame.is_some()
    }

    /// Whether any pair that touches may have changed, and is to be looked at when its contact is reported.
    fn looks_at_all(&self) -> bool {
        self.stirs && !self.is_new
    }

    /// Takes note of the points of a pair that touch after the step.
    pub fn note_touching(&mut self, slot: u32, pair: &mut Pair) {
        let bits = pair.touches;
        // What touches nowhere, and did not a step ago, has no links.
        let is_altered = bits != pair.touching || (pair.updated && bits != 0) || bits == TOO_MANY;
        pair.touching = bits;
        if bits != 0 && self.by_thrust {
            self.pressed.push(slot);
        }
        if bits != 0 && self.looks_at_all() {
            self.near.push(slot);
        } else if is_altered {
            self.altered.push(slot);
        }
    }

    /// Looks at the pairs that touch among those just reported.
    pub fn look_at_near(&mut self, pairs: &PairCache, colliders: &Pool<Collider, ShapeId>, bodies: &Pool<Body, BodyId>) {
        let mut near = std::mem::take(&mut self.near);
        near.drain(..).for_each(|slot| self.look_at(slot, pairs.get(slot), colliders, bodies));
        self.near = near;
    }

    /// Looks at a pair again if anything may have changed that its links were made from.
    fn look_at(&mut self, slot: u32, pair: &Pair, colliders: &Pool<Collider, ShapeId>, bodies: &Pool<Body, BodyId>) {
        let Some(frame) = self.frame else { return };
        let record = self.records.get(slot as usize);
        let is_up_to_date = record.map_or(pair.touching == 0, |record| record.is_up_to_date(pair, &self.signs));
        if self.is_new || !is_up_to_date {
            let site = Site::new(pair, slot, colliders, bodies);
            // What is held was judged when it came to rest.
            if self.is_new || !(site.bodies.0.held || site.bodies.1.held) {
                self.sync_pair(&site, &frame);
            }
        }
        let record = self.records.get(slot as usize);
        if !record.map_or(pair.touching == 0, |record| record.is_settled(pair)) {
            self.left.push(slot);
        }
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
        if !state.rests {
            self.sync_bodies(&mut state);
            self.note_signs(&mut state);
        }
        self.support = Some(state);
    }

    /// Takes the links of pairs that were given up out of the graph.
    pub(super) fn forget_released(&mut self, state: &mut SupportState) {
        for &slot in self.pairs.released() {
            let key = state.records.get(slot as usize).and_then(|record| record.key);
            if key.is_some_and(|key| !self.pairs.holds(slot, key)) {
                state.forget_pair(slot);
            }
        }
        self.pairs.forget_released();
    }

    fn note_signs(&self, state: &mut SupportState) {
        state.stirs = false;
        for &index in &self.movers {
            if let Some(body) = self.bodies.get(index) {
                let turn = &mut state.turns[index as usize];
                let signs = if body.held { HELD } else { signs_of(body, turn, &self.colliders) };
                state.signs[index as usize] = signs;
                state.stirs |= signs & (TURNED | FAST | LEAVING) != 0;
            }
        }
    }

    /// Looks at the pairs that were not looked at when contacts were reported.
    pub(super) fn sync_contacts(&self, state: &mut SupportState) {
        let Self { pairs, colliders, bodies, .. } = self;
        let Some(frame) = state.frame else { return };
        let looked_at_all = state.looks_at_all();
        let (mut altered, mut unsettled) = (std::mem::take(&mut state.altered), std::mem::take(&mut state.unsettled));
        if state.is_new {
            self.note_signs(state);
            pairs.active().iter().for_each(|&(_, slot)| state.look_at(slot, pairs.get(slot), colliders, bodies));
        } else {
            // While nothing moves, only what the solver changed can be other than it was.
            altered.append(&mut unsettled);
            let is_left = |pair: &Pair| pair.is_active() && (!looked_at_all || pair.still || pair.touching == 0);
            altered.retain(|&slot| is_left(pairs.get(slot)));
            altered.sort_unstable();
            altered.dedup();
            altered.iter().for_each(|&slot| state.look_at(slot, pairs.get(slot), colliders, bodies));
        }
        altered.clear();
        unsettled.clear();
        state.altered = altered;
        state.unsettled = std::mem::replace(&mut state.left, unsettled);
        let fell_asleep = std::mem::take(&mut state.fell_asleep);
        // What was dropped meanwhile has no contacts any more.
        let dozing = fell_asleep.iter().copied().filter(|&slot| pairs.get(slot).has_points());
        let asleep = state.is_new.then(|| self.sleeping.pairs());
        dozing.chain(asleep.into_iter().flatten()).for_each(|slot| {
            state.sync_pair(&Site::new(pairs.get(slot), slot, colliders, bodies), &frame);
        });
        state.fell_asleep = fell_asleep;
        state.is_new = false;
        if !state.stirs {
            // That a body is held is said anew in each step that it moves in; else there is nothing to take back.
            return;
        }
        for &index in &self.movers {
            if let Some((_, turned)) = state.turns.get_mut(index as usize) {
                *turned = false;
                state.signs[index as usize] = 0;
            }
        }
    }
}
