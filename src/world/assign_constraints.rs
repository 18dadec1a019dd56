//! Stages that assign contacts and joints to the batches of their bodies.

use smallvec::SmallVec;

use super::body_shape_table::BodyShapeTable;
use super::islands::{IslandGroups, NO_BODY};
use super::touching_pairs::TouchingPair;
use super::{Batches, Collision, Islands, World};
use crate::body::{Body, BodyKind};
use crate::collide::cache::PairCache;
use crate::id::{BodyId, JointId, Pool};
use crate::report::StepCounts;
use crate::solve::batch::{Batch, ContactEnds, REPLICA};
use crate::solve::state::WORLD_SLOT;
use crate::workers::MAX_PIECES;

/// Pairs that touch from which on all threads hand out the manifolds of the largest batch.
const SHARED_TOUCHES: usize = 2048;

/// What is asked of pairs that touch.
struct Contacts<'a> {
    groups: &'a IslandGroups,
    index: &'a BodyShapeTable,
    bodies: &'a Pool<Body, BodyId>,
    pairs: &'a PairCache,
    is_held: &'a [bool],
}

impl Contacts<'_> {
    /// The batch in which the manifolds of a pair are solved, if there are any and they are.
    fn batch_of(&self, touch: &TouchingPair) -> Option<u32> {
        let moved = touch.bodies.into_iter().find(|&body| touch.manifolds > 0 && self.index.free.has(body));
        let solved = moved.filter(|&body| !self.is_held[self.groups.island[body as usize] as usize]);
        solved.map(|body| self.groups.place[body as usize].0)
    }

    fn hand_out(&self, touch: &TouchingPair, batch: &mut Batch, counts: &mut StepCounts) {
        self.manifolds(touch).for_each(|(manifold, ends)| batch.add_manifold(manifold, ends));
        counts.manifolds += u32::from(touch.manifolds);
        counts.contact_points += u32::from(touch.points);
    }

    fn slot_of(&self, body: u32) -> u32 {
        let is_driven = || self.bodies[body].acts_as() == BodyKind::Kinematic && self.bodies[body].is_mover();
        match self.index.free.has(body) {
            true => self.groups.place[body as usize].1,
            false if is_driven() => REPLICA,
            false => WORLD_SLOT,
        }
    }

    /// Manifolds of a pair, and what they are between.
    fn manifolds(&self, touch: &TouchingPair) -> impl Iterator<Item = ((u32, u32), ContactEnds)> {
        let &TouchingPair { slot, manifolds, points, is_plain, may_swing, .. } = touch;
        let [a, b] = touch.bodies.map(|body| self.slot_of(body));
        (0..u32::from(manifolds)).map(move |number| {
            let own = || self.pairs.get(slot).manifolds.get(number as usize).points.len() as u8;
            let points = if manifolds == 1 { points as u8 } else { own() };
            ((slot, number), ContactEnds { a, b, points, is_plain, is_swung: [may_swing; 2] })
        })
    }
}

impl World {
    pub(super) fn hand_out_contacts(&mut self) {
        let largest = self
            .islands
            .groups
            .largest_batch()
            .filter(|_| self.threads.has_team() && self.collision.touches.len() >= SHARED_TOUCHES);
        if let Some(largest) = largest {
            return self.hand_out_contacts_to(largest);
        }
        let Self {
            islands: Islands { groups, hold, .. },
            collision: Collision { touches, pairs, index, .. },
            batches: Batches { list: batches, .. },
            bodies,
            report,
            ..
        } = self;
        let contacts = Contacts { groups, index, bodies, pairs, is_held: &hold.islands };
        for touch in touches.touching() {
            if let Some(batch) = contacts.batch_of(touch) {
                contacts.hand_out(touch, &mut batches[batch as usize], &mut report.counts);
            }
        }
    }

    /// Hands out all contacts, those of the largest batch on all threads.
    fn hand_out_contacts_to(&mut self, largest: u32) {
        let Self {
            islands: Islands { groups, hold, .. },
            collision: Collision { touches, pairs, index, .. },
            batches: Batches { list: batches, .. },
            bodies,
            report,
            threads,
            scratch,
            ..
        } = self;
        let contacts = Contacts { groups, index, bodies, pairs, is_held: &hold.islands };
        let others = &mut scratch.others;
        others.resize_with(others.len().max(touches.parts().count()), Vec::new);
        // Of each part the manifolds and points that are the largest batch's, and what is of other batches.
        let mut parts: SmallVec<[_; MAX_PIECES]> =
            touches.parts().zip(others.iter_mut()).map(|(part, others)| (part, others, 0, 0)).collect();
        threads.share(parts.iter_mut(), |(part, others, manifolds, points)| {
            others.clear();
            for (number, touch) in part.iter().enumerate() {
                match contacts.batch_of(touch) {
                    Some(batch) if batch == largest => {
                        *manifolds += usize::from(touch.manifolds);
                        *points += u32::from(touch.points);
                    }
                    Some(_) => others.push(number as u32),
                    None => {}
                }
            }
        });
        let counts = &mut report.counts;
        for (part, others, ..) in &parts {
            for &number in others.iter() {
                let touch = &part[number as usize];
                if let Some(batch) = contacts.batch_of(touch) {
                    contacts.hand_out(touch, &mut batches[batch as usize], counts);
                }
            }
        }
        counts.contact_points += parts.iter().map(|&(.., points)| points).sum::<u32>();
        let all = parts.iter().map(|&(_, _, manifolds, _)| manifolds).sum();
        counts.manifolds += all as u32;
        let (mut manifolds, mut ends) = batches[largest as usize].room_for_manifolds(all);
        let pieces = parts.into_iter().map(|(part, _, own, _)| {
            let own = (manifolds.split_off_mut(..own), ends.split_off_mut(..own));
            (part, own.0.unwrap_or_default(), own.1.unwrap_or_default())
        });
        threads.share(pieces, |(part, manifolds, ends)| {
            let own = part.iter().filter(|touch| contacts.batch_of(touch) == Some(largest));
            let found = own.flat_map(|touch| contacts.manifolds(touch));
            manifolds.iter_mut().zip(ends).zip(found).for_each(|((manifold, ends), found)| (*manifold, *ends) = found);
        });
    }

    /// Lists the joints of what moves and is not held.
    fn list_joints(&mut self) {
        let Self { islands: Islands { groups, .. }, joints, bodies, unions, collision: Collision { index, .. }, .. } = self;
        let IslandGroups { sorted_joints, listed, joint_heads, dynamic, bound, joint_version, .. } = groups;
        sorted_joints.clear();
        let moves = |body: u32| body != NO_BODY && index.free.has(body);
        let moved = |slot: u32| joint_heads[slot as usize].bodies.into_iter().find(|&body| moves(body));
        for &body in bound.iter().filter(|&&body| !bodies[body].held) {
            let own = |id: &JointId| Some(joints.slot_of(*id)).filter(|&slot| moved(slot) == Some(body));
            match unions.moving(body) {
                None => sorted_joints.extend(bodies[body].joints.iter().filter_map(own)),
                Some(union) if union.lead == body => sorted_joints.extend_from_slice(&union.outer),
                Some(_) => {}
            }
        }
        sorted_joints.sort_unstable();
        sorted_joints.dedup();
        listed.dynamic.clone_from(dynamic);
        listed.bound.clone_from(bound);
        let is_whole = unions.iter().next().is_none() && !bound.iter().any(|&body| bodies[body].held);
        listed.joint_version = joint_version.filter(|_| is_whole);
    }

    pub(super) fn hand_out_joints(&mut self) {
        if !self.islands.groups.joints_stay {
            self.list_joints();
        }
        let Self {
            islands: Islands { groups, .. },
            batches: Batches { list: batches, .. },
            joints,
            collision: Collision { index, .. },
            report,
            ..
        } = self;
        let joint_heads = &groups.joint_heads;
        let moves = |body: u32| body != NO_BODY && index.free.has(body);
        let moved = |slot: u32| joint_heads[slot as usize].bodies.into_iter().find(|&body| moves(body));
        groups.joint_places.resize(joints.slot_count(), 0);
        for &slot in &groups.sorted_joints {
            if let Some(body) = moved(slot) {
                let joint_slots = &mut batches[groups.place[body as usize].0 as usize].joints.slots;
                groups.joint_places[slot as usize] = joint_slots.len() as u32;
                joint_slots.push(slot);
                report.counts.joints += 1;
            }
        }
    }
}
