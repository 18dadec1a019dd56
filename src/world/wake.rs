//! Waking: an edit that changes the motion or the load of a body wakes everything that joints, contacts and unions connect to it.
//!
//! Every edit of a body, shape or joint goes through [`World::wake_for`]. Bodies that are free to move wake with their whole island, which
//! holds all that touches them or is jointed to them. What is static, kinematic or welded to such a body is in no island, since many of
//! them rest on it: an edit of it wakes all that is jointed to it or near it, with their islands, and goes no further.

use super::{Collision, World};
use crate::body::{Anchored, BodyKind, SleepState};
use crate::collide::broad::still_near;
use crate::collide::collider::Collider;
use crate::collide::pairs::PairKey;
use crate::dwell_time::DwellTime;
use crate::id::{Pool, ShapeId};

/// What an edit changes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Edited {
    /// How a body moves, or what loads it.
    Body(u32),
    /// Where a body is, or what it may touch. Said before the edit for what it leaves, and after it for what it meets.
    Place(u32),
    /// The form of a shape, or whether there is one. Said before or after the edit, as of a place.
    Shape(ShapeId),
    /// What a joint does to its bodies, or what it bears.
    Joint(u32),
}

impl World {
    /// Wakes whatever an edit may set in motion, and starts its time of quiet anew.
    pub(super) fn wake_for(&mut self, edited: Edited) {
        match edited {
            Edited::Body(index) => {
                self.wake_body(index);
                if !self.is_in_island(index) {
                    self.wake_around_hubs(&[index]);
                }
            }
            Edited::Place(index) => self.wake_for_places(&[index]),
            Edited::Shape(shape) => {
                if let Ok(slot) = self.colliders.find(shape) {
                    self.wake_body(self.colliders[slot].body);
                    self.wake_near(&[shape]);
                }
            }
            Edited::Joint(slot) => {
                for index in self.joints[slot].bodies.into_iter().flatten() {
                    self.wake_body(index);
                    // What hangs on a union bears on the joints inside it.
                    if self.bodies[index].anchored != Anchored::No {
                        self.wake_around_hubs(&[index]);
                    }
                }
            }
        }
    }

    /// Whether all that touches a body or is jointed to it sleeps and wakes with it.
    fn is_in_island(&self, index: u32) -> bool {
        self.bodies[index].is_free() && !self.bodies[index].quarantined
    }

    /// As [`wake_for`](Self::wake_for) says of [`Edited::Place`], of several bodies.
    pub(super) fn wake_for_places(&mut self, edited: &[u32]) {
        let mut hubs = Vec::new();
        for &index in edited {
            self.wake_body(index);
            if self.is_in_island(index) {
                self.wake_near(&self.bodies[index].shapes.clone());
            } else {
                hubs.push(index);
            }
        }
        self.wake_around_hubs(&hubs);
    }

    /// Wakes what is jointed to bodies that are in no island, or to what is welded to them, and what is near these.
    fn wake_around_hubs(&mut self, edited: &[u32]) {
        let mut unions = Vec::new();
        for &index in edited {
            let is_anchored = |other: &u32| self.bodies[*other].anchored != Anchored::No;
            let welded = self.jointed_to(index).filter(is_anchored).chain([index]);
            unions.extend(welded.filter_map(|other| self.unions.of(other)).map(|union| union.lead));
        }
        unions.sort_unstable();
        unions.dedup();
        let mut hubs = edited.to_vec();
        hubs.extend(unions.iter().filter_map(|&lead| self.unions.of(lead)).flat_map(|union| union.members.iter().copied()));
        hubs.sort_unstable();
        hubs.dedup();
        for hub in hubs {
            for other in self.jointed_to(hub).collect::<Vec<_>>() {
                self.wake_body(other);
            }
            self.wake_near(&self.bodies[hub].shapes.clone());
        }
    }

    /// Bodies that joints connect to a body.
    pub(super) fn jointed_to(&self, index: u32) -> impl Iterator<Item = u32> + '_ {
        let joints = self.bodies[index].joints.iter().filter_map(|&id| self.joints.find(id).ok());
        joints.flat_map(|slot| self.joints[slot].bodies).flatten().filter(move |&other| other != index)
    }

    /// Wakes the island of a body, or starts its time of quiet anew.
    pub(super) fn wake_body(&mut self, index: u32) {
        match self.bodies[index].sleep {
            SleepState::Awake { .. } => {
                self.bodies[index].sleep = SleepState::AWAKE;
                self.release(index);
            }
            SleepState::Asleep { island } => {
                let island = self.islands.sleeping.take(island);
                for &member in &island.bodies {
                    let body = &mut self.bodies[member];
                    body.sleep = SleepState::AWAKE;
                    (body.held, body.times.calm_for, body.times.smooth_for, body.woke) =
                        (false, DwellTime::NONE, DwellTime::NONE, true);
                    for &id in &body.shapes {
                        if let Ok(shape) = self.colliders.find(id) {
                            self.collision.broad.revisit(shape);
                        }
                    }
                }
                self.movers.slots.extend_from_slice(&island.bodies);
                self.movers.are_sorted = false;
                let Self { collision: Collision { pairs, .. }, colliders, .. } = self;
                pairs.activate_kept(&island.pairs, |key| is_whole(colliders, key));
            }
        }
        if self.bodies[index].is_mover() {
            self.movers.slots.push(index);
            self.movers.are_sorted = false;
        }
    }

    pub(super) fn wake_all(&mut self) {
        let asleep: Vec<u32> = self.bodies.iter().filter(|(_, body)| !body.is_awake()).map(|(index, _)| index).collect();
        for index in asleep {
            self.wake_body(index);
        }
    }

    /// Wakes everything dynamic whose box meets that of one of these shapes, unless that only senses.
    fn wake_near(&mut self, shapes: &[ShapeId]) {
        let mut near = Vec::new();
        for &id in shapes {
            if let Ok(shape) = self.colliders.find(id)
                && !self.colliders[shape].sensor
                && let Some(region) = self.colliders[shape].fat_box
            {
                near.extend(self.collision.broad.overlapping(&region).map(|other| self.colliders[other].body));
            }
        }
        near.sort_unstable();
        near.dedup();
        near.retain(|&other| self.bodies[other].is_dynamic());
        for other in near {
            self.wake_body(other);
        }
    }

    /// Wakes sleeping islands that something awake may touch in this step, and those that hang on a kinematic body that moves.
    pub(super) fn wake_what_is_touched(&mut self) {
        self.collision.pairs.settle();
        if self.islands.sleeping.body_count() == 0 {
            return self.settle_movers();
        }
        let mut slots = std::mem::take(&mut self.scratch.slots);
        slots.clear();
        let sleeps = |body: u32| self.bodies[body].is_free() && !self.bodies[body].is_awake();
        for &(key, slot) in self.collision.pairs.active() {
            if !self.collision.pairs.get(slot).may_touch {
                continue;
            }
            let (a, b) = key.shapes();
            slots.extend([self.colliders[a].body, self.colliders[b].body].into_iter().filter(|&body| sleeps(body)));
        }
        let drives = |&&body: &&u32| self.bodies.get(body).is_some_and(|body| body.acts_as() == BodyKind::Kinematic);
        if self.movers.some_are_driven {
            slots.extend(
                self.movers.slots.iter().filter(drives).flat_map(|&body| self.jointed_to(body)).filter(|&body| sleeps(body)),
            );
        }
        for &body in &slots {
            self.wake_body(body);
        }
        let has_woken = !slots.is_empty();
        self.scratch.slots = slots;
        self.settle_movers();
        if has_woken {
            // Pairs that have woken are solved in this step.
            self.collision.pairs.settle();
            self.collision.index.add_stances(self.collision.pairs.active(), &self.colliders, &self.bodies);
            self.collision.touches.outdate();
        }
    }
}

/// Whether a pair that a sleeping island kept still is one: what is kinematic may have moved away from what sleeps beside it, or be
/// gone.
pub(super) fn is_whole(colliders: &Pool<Collider, ShapeId>, key: PairKey) -> bool {
    let (a, b) = key.shapes();
    let Some((a, b)) = colliders.get(a).zip(colliders.get(b)) else { return false };
    still_near(&a.fat_box, &b.fat_box)
}
