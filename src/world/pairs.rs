//! Stages of a step that find pairs of shapes and bring their contacts up to date.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::always_overlap::always_overlap;
use super::seams::Glide;
use super::surface_energy::BallOnSurface;
use super::touching_pairs::TouchingPair;
use super::unions::Unions;
use super::{Collision, Movers, World};
use crate::body::Body;
use crate::collide::active_hits::ActiveHit;
use crate::collide::broad::still_near;
use crate::collide::collider::{Collider, own_margin};
use crate::collide::collider_state::{ColliderState, Follow};
use crate::collide::pairs::{Pair, PairKey, PairScratch, WorldManifold};
use crate::collide::predict::Step;
use crate::id::{BodyId, JointId, Pool, ShapeId};
use crate::joint_record::Joint;
use crate::prefetch::{AHEAD, prefetch};
use crate::report::{Contact, Hit};
use crate::solve::disjoint::{DisjointSlices, Slots};
use crate::tight_vec::{extend_tightly, give_back_room};
use crate::workers::MAX_PIECES;

/// Margins around a shape's box from which on the box that is kept is made anew although the shape is still in it.
const LOOSE: f32 = 4.0;

/// Moving bodies from which on their shapes' boxes are brought up to date on all threads, and shapes that are worth another thread's while:
/// some 10 µs.
const SHARED_MOVERS: usize = 512;
const MIN_BOXES: usize = 128;

/// Active pairs below which the narrow phase stays on one thread.
const MIN_PARALLEL_PAIRS: usize = 256;

/// Pairs that are worth another thread's while: some 10 µs.
const MIN_PAIRS: usize = 64;

impl World {
    /// Brings the boxes of what moves up to date and the list of active pairs with them.
    pub(super) fn find_pairs(&mut self, dt: f32) {
        let gravity = self.def.gravity.length();
        self.collision.index.moving.begin(self.bodies.slot_count());
        self.collision.index.begin_stances(self.colliders.slot_count());
        let most_are_in_pairs = self.collision.pairs.is_large();
        for &body in &self.movers.slots {
            self.collision.index.moving.set(body);
        }
        let any_moves = self.movers.slots.iter().any(|&body| !self.bodies[body].held);
        let most_move = 2 * self.movers.slots.len() > self.colliders.slot_count();
        if any_moves && self.threads.has_team() && self.movers.slots.len() >= SHARED_MOVERS && most_move {
            self.renew_boxes_on_all_threads(gravity, dt, most_are_in_pairs);
        } else if any_moves {
            self.renew_boxes(gravity, dt, most_are_in_pairs);
        }
        self.drop_distant_pairs();
        self.add_new_pairs();
        self.tidy_pairs();
        if !self.collision.pairs.active().is_empty() {
            self.collision.index.add_stances(self.collision.pairs.active(), &self.colliders, &self.bodies);
        }
    }

    fn renew_boxes(&mut self, gravity: f32, dt: f32, most_are_in_pairs: bool) {
        let Self { movers: Movers { slots: movers, .. }, bodies, colliders, collision: Collision { index, broad, .. }, .. } =
            self;
        for body in movers.iter().map(|&body| &bodies[body]).filter(|body| !body.held) {
            for &id in &body.shapes {
                let Ok(shape) = colliders.find(id) else { continue };
                let collider = &mut colliders[shape];
                if renew_box(collider, body, gravity, dt) {
                    index.reboxed.set(shape);
                    broad.revisit(shape);
                }
                if most_are_in_pairs {
                    index.set_stance(shape, ColliderState::of(collider, body));
                }
            }
        }
    }

    /// The same, by slots of shapes.
    fn renew_boxes_on_all_threads(&mut self, gravity: f32, dt: f32, most_are_in_pairs: bool) {
        let Self { bodies, colliders, collision: Collision { index, broad, .. }, scratch, threads, .. } = self;
        let bodies = &*bodies;
        let piece = threads.piece(colliders.slot_count(), MIN_BOXES);
        scratch.reboxed.resize_with(MAX_PIECES, Vec::new);
        let (moving, collider_states) = index.stances_in_pieces(piece);
        let pieces =
            colliders.slots_mut().chunks_mut(piece).zip(collider_states).zip(&mut scratch.reboxed).zip((0..).step_by(piece));
        threads.share(pieces, |(((slots, mut collider_states), reboxed), first)| {
            for (place, slot) in slots.iter_mut().enumerate() {
                let Some(collider) = slot.value.as_mut().filter(|collider| moving.has(collider.body)) else { continue };
                let body = &bodies[collider.body];
                if body.held {
                    continue;
                }
                if renew_box(collider, body, gravity, dt) {
                    reboxed.push((first + place) as u32);
                }
                if most_are_in_pairs {
                    collider_states.set(place, ColliderState::of(collider, body));
                }
            }
        });
        for shape in scratch.reboxed.iter_mut().flat_map(|found| found.drain(..)) {
            index.reboxed.set(shape);
            broad.revisit(shape);
        }
    }

    /// Keeps pairs in memory in the order in which they are gone through.
    pub(super) fn tidy_pairs(&mut self) {
        let Some(places) = self.collision.pairs.tidy() else { return };
        self.islands.sleeping.move_pairs(&places);
        if let Some(support) = &mut self.support {
            support.move_pairs(&places);
        }
    }

    fn drop_distant_pairs(&mut self) {
        let Self { collision: Collision { pairs, index, .. }, colliders, bodies, unions, events, threads, .. } = self;
        let may_know = index.is_known && unions.iter().next().is_none();
        let (colliders, bodies, unions) = (&*colliders, &*bodies, &*unions);
        let has_gone = |key: PairKey| {
            let (a, b) = key.shapes();
            let is_known = may_know && !index.reboxed.has(a) && !index.reboxed.has(b);
            if is_known && (index.moving.has(index.body_of(a)) || index.moving.has(index.body_of(b))) {
                return false;
            }
            let (shape_a, shape_b) = (&colliders[a], &colliders[b]);
            let moves = |body: u32| index.moving.has(body) || bodies[body].is_mover();
            !((moves(shape_a.body) || moves(shape_b.body))
                && still_near(&shape_a.fat_box, &shape_b.fat_box)
                && !unions.same(shape_a.body, shape_b.body))
        };
        pairs.drop_active(threads, has_gone, |key, pair| {
            if pair.in_contact {
                events.contact_ended.push(contact_pair(colliders, bodies, key));
            }
        });
        index.is_known = true;
        index.reboxed.begin(colliders.slot_count());
    }

    /// Looks up the neighbours of shapes whose boxes have changed, and makes a pair active of any two that may collide and have none.
    pub(super) fn add_new_pairs(&mut self) {
        let Self {
            collision: Collision { broad, pairs, index, .. }, colliders, bodies, joints, unions, scratch, threads, ..
        } = self;
        scratch.candidates.clear();
        pairs.settle();
        let listed = pairs.lookup(colliders.slot_count(), broad.changed().len());
        broad.refresh(
            threads,
            (
                |shape| colliders.get(shape).and_then(|collider| collider.fat_box),
                |shape| colliders.get(shape).is_some_and(|collider| !collider.sensor && collider.filter.accepts_any()),
            ),
            |shape| unions.number_of(index.body_of(shape)),
            |key| {
                let (a, b) = key.shapes();
                !listed.has(key) && may_collide(&colliders[a], &colliders[b], bodies, joints, unions)
            },
            &mut scratch.candidates,
        );
        let candidates = &mut scratch.candidates;
        if !candidates.is_empty() {
            candidates.sort_unstable();
            pairs.activate_new(candidates);
        }
        // The first step of a world finds most of its pairs; later ones do not need the room.
        give_back_room(candidates);
    }

    /// Makes or follows the contacts of every active pair, and lists what touches.
    pub(super) fn update_contacts(&mut self, dt: f32) {
        let Self { collision: Collision { pairs, index, touches, .. }, colliders, bodies, scratch, threads, def, report, .. } =
            self;
        let (active, slots) = pairs.active_and_slots();
        let moving = |slot: u32| {
            let collider = &colliders[slot];
            Follow::of(collider, &bodies[collider.body])
        };
        let step = Step { dt, substeps: def.substeps, gravity: def.gravity };
        let update = |pair: &mut Pair, scratch: &mut PairScratch| {
            let (a, b) = pair.key.shapes();
            let collider_states = (index.collider_state(a), index.collider_state(b));
            if pair.rests(collider_states.0.still && collider_states.1.still) {
                return;
            }
            if !collider_states.0.tight_box.intersects(&collider_states.1.tight_box) {
                return pair.part();
            }
            let motion = collider_states.0.motion_against(collider_states.1, def.gravity, dt);
            pair.update(collider_states, motion, step, || [moving(a), moving(b)], scratch);
        };
        let is_shared = !threads.is_alone() && active.len() >= MIN_PARALLEL_PAIRS;
        let piece = if is_shared { threads.piece(active.len(), MIN_PAIRS) } else { active.len().max(1) };
        let parts = active.len().div_ceil(piece);
        scratch.pairs.resize_with(scratch.pairs.len().max(parts), PairScratch::default);
        scratch.glides.resize_with(scratch.glides.len().max(parts), Vec::new);
        scratch.found_balls.resize_with(scratch.found_balls.len().max(parts), Vec::new);
        let (updated, slots) = (AtomicUsize::new(0), DisjointSlices::new(slots));
        let noted = scratch.glides.iter_mut().zip(&mut scratch.found_balls);
        let pieces = active.chunks(piece).zip(&mut scratch.pairs).zip(touches.begin(parts)).zip(noted);
        threads.share(pieces, |(((active, scratch), touches), (glides, balls))| {
            // SAFETY: each active pair has a slot of its own, and is in one piece.
            let mut pairs = unsafe { slots.part() };
            let mut own = 0;
            for (place, &(key, slot)) in active.iter().enumerate() {
                if let Some(&(key, slot)) = active.get(place + 2 * AHEAD) {
                    prefetch(pairs.get(slot));
                    prefetch(index.collider_state(key.shapes().1));
                }
                if let Some(&(key, slot)) = active.get(place + AHEAD) {
                    let coming = pairs.get(slot);
                    coming.manifolds.prefetch();
                    // What was made anew in the last step may well be again.
                    if coming.updated {
                        <[u32; 2]>::from(key.shapes()).into_iter().for_each(|shape| colliders.ask_for(shape));
                    }
                }
                let pair = pairs.get_mut(slot);
                let was_pressed = pair.pressed;
                update(pair, scratch);
                own += usize::from(pair.updated);
                let (a, b) = key.shapes();
                let states = (index.collider_state(a), index.collider_state(b));
                glides.extend(Glide::of(key, slot, pair, states, dt, bodies));
                let on_surface = was_pressed.then(|| BallOnSurface::of(slot, key, states, colliders, bodies));
                balls.extend(on_surface.flatten());
                extend_tightly(touches, TouchingPair::of(key, slot, pair, index).into_iter());
            }
            updated.fetch_add(own, Ordering::Relaxed);
        });
        let (active, updated) = (active.len(), updated.into_inner());
        report.counts.pairs = active as u32;
        report.counts.pairs_updated = updated as u32;
        report.counts.pairs_reused = (active - updated) as u32;
        self.leave_out_seams(dt);
        self.thin_out_crowds(dt);
    }
}

impl World {
    /// Notes of every pair how fast its points approach each other, where that is fast enough for a hit.
    pub(super) fn note_approaches(&mut self) {
        let Self { collision: Collision { pairs, .. }, colliders, bodies, def, .. } = self;
        if def.hit_threshold == f32::INFINITY {
            return;
        }
        pairs.note_approaches(|pair| approach(pair, colliders, bodies, def.hit_threshold));
    }

    /// Lists pairs of shapes that met fast: once the approach is over, for speculative contacts spread it over two steps.
    pub(super) fn report_hits(&mut self) {
        let threshold = self.def.hit_threshold;
        if threshold == f32::INFINITY {
            return;
        }
        for (key, slot) in self.collision.pairs.active_hits() {
            if approach(self.collision.pairs.get(slot), &self.colliders, &self.bodies, threshold) > 0.0 {
                continue;
            }
            let ActiveHit { approach: approach_speed, impulse } = self.collision.pairs.blow_of(slot);
            let heaviest = |a: &Contact, b: &Contact| a.normal_force().total_cmp(&b.normal_force());
            if let Some(contact) = self.contacts_of_pair(key, slot).max_by(heaviest).filter(|_| impulse > 0.0) {
                let points = contact.points();
                let point = points.iter().map(|point| point.position).sum::<DVec3>() / points.len() as f64;
                let pair = contact.pair;
                self.events.hits.push(Hit { pair, point, normal: contact.normal, approach_speed, impulse });
                // What a hit has stopped need not press any more as its step ends.
                let record = self.collision.pairs.get_mut(slot);
                if !record.in_contact && !self.events.contact_ended.contains(&pair) {
                    record.in_contact = true;
                    self.events.contact_began.push(pair);
                }
            }
            self.collision.pairs.blows.forget(slot);
        }
    }
}

/// Greatest speed at which points of a pair approach each other (m/s), if it is above a threshold; else zero.
fn approach(pair: &Pair, colliders: &Pool<Collider, ShapeId>, bodies: &Pool<Body, BodyId>, threshold: f32) -> f32 {
    let (a, b) = pair.key.shapes();
    let (shape_a, shape_b) = (&colliders[a], &colliders[b]);
    let (body_a, body_b) = (&bodies[shape_a.body], &bodies[shape_b.body]);
    let linear = body_b.linear_velocity - body_a.linear_velocity;
    let turning = body_a.angular_velocity.length() * shape_a.reach + body_b.angular_velocity.length() * shape_b.reach;
    if linear.length() + turning <= threshold {
        return 0.0;
    }
    let mut greatest = 0.0;
    for manifold in pair.manifolds.iter() {
        let world = WorldManifold::new(&manifold, (shape_a, body_a), (shape_b, body_b));
        for i in 0..manifold.points.len() {
            let turning = body_b.angular_velocity.cross(world.lever_b[i]) - body_a.angular_velocity.cross(world.lever_a[i]);
            let speed = -(linear + turning).dot(world.normal);
            if speed > threshold {
                greatest = speed.max(greatest);
            }
        }
    }
    greatest
}

/// Whether a pair of shapes belongs among the active pairs.
pub(super) fn may_collide(
    a: &Collider,
    b: &Collider,
    bodies: &Pool<Body, BodyId>,
    joints: &Pool<Joint, JointId>,
    unions: &Unions,
) -> bool {
    if a.body == b.body || a.sensor || b.sensor || !a.filter.accepts(&b.filter) {
        return false;
    }
    let (body_a, body_b) = (&bodies[a.body], &bodies[b.body]);
    (body_a.is_free() || body_b.is_free())
        && !unions.same(a.body, b.body)
        && (body_a.is_mover() || body_b.is_mover())
        && !(body_a.quarantined || body_b.quarantined)
        && !kept_apart((a.body, body_a), (b.body, body_b), joints)
        && !always_overlap((a, body_a), (b, body_b), joints)
}

/// Whether a joint between two bodies forbids that they collide.
fn kept_apart((a, body_a): (u32, &Body), (b, body_b): (u32, &Body), joints: &Pool<Joint, JointId>) -> bool {
    let fewer = if body_a.joints.len() <= body_b.joints.len() { &body_a.joints } else { &body_b.joints };
    fewer.iter().map(|&id| &joints[joints.slot_of(id)]).any(|joint| {
        let connects = joint.bodies.contains(&Some(a)) && joint.bodies.contains(&Some(b));
        connects && !joint.def.collide_connected
    })
}

/// Whether a kept box is of a time when the shape was faster: bodies that have fallen into a pile would have twice the neighbours that
/// they need.
fn is_loose(kept: &Aabb, tight: &Aabb, margin: f32) -> bool {
    (kept.extents() - tight.extents()).max_element() > 2.0 * margin * LOOSE
}

/// Brings a shape's box up to date; whether the one that is kept has changed with it.
fn renew_box(collider: &mut Collider, body: &Body, gravity: f32, dt: f32) -> bool {
    let tight = collider.world_box(collider.motion_bound(body, gravity, dt) + own_margin(collider));
    collider.tight_box = tight;
    let margin = collider.fat_margin();
    let keeps = collider.fat_box.is_some_and(|kept| kept.contains(&tight) && !is_loose(&kept, &tight, margin));
    if !keeps {
        collider.fat_box = Some(tight.loosened(margin));
    }
    !keeps
}

/// Handles of a pair of shapes.
pub(super) fn contact_pair(
    colliders: &Pool<Collider, ShapeId>,
    bodies: &Pool<Body, BodyId>,
    key: PairKey,
) -> crate::report::ContactPair {
    let (a, b) = key.shapes();
    crate::report::ContactPair {
        shape_a: colliders.handle_of(a),
        shape_b: colliders.handle_of(b),
        body_a: bodies.handle_of(colliders[a].body),
        body_b: bodies.handle_of(colliders[b].body),
    }
}
