//! One batch of islands: slots for its bodies, blocks for its contacts, entries for its joints.

use super::birth::Birth;
use super::color::{Coloring, MAX_COLORS};
use super::contact::{ContactBlock, ContactImpulses, ContactInput, LANES, Lane, POINTS};
use super::joint::BatchJoints;
use super::state::{BodyMotion, BodyVelocity, WORLD_SLOT};

/// Slot that stands for a body of the world in this batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Replica {
    body: u32,
    slot: u32,
}

/// Bodies, contacts and joints solved together.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// Body of each slot; the first is the world slot and has none.
    pub bodies: Vec<u32>,
    /// Manifolds as (pair, manifold of the pair), in the order they were added.
    pub manifolds: Vec<(u32, u32)>,
    /// Joints, by slot in the world's pool.
    pub joint_slots: Vec<u32>,
    pub velocities: Vec<BodyVelocity>,
    pub motions: Vec<BodyMotion>,
    pub contacts: Vec<ContactBlock>,
    pub joints: BatchJoints,
    /// Slots of each manifold's bodies.
    pub ends: Vec<(u32, u32)>,
    /// Block and lane of each manifold.
    lanes: Vec<(u32, u32)>,
    /// Kinematic bodies that have a slot here, sorted by body.
    replicas: Vec<Replica>,
    pub birth: Birth,
    pub coloring: Coloring,
    colors: Vec<u32>,
    pub pushes: Vec<BodyVelocity>,
    pub recovery_lambdas: Vec<[Lane; POINTS]>,
    /// Number of colours that the contacts took.
    pub color_count: u32,
    /// Worst joint gap and penetration at the end of the step (m).
    pub joint_gap: f32,
    pub penetration: f32,
}

impl Batch {
    /// Empties the batch but keeps its memory.
    pub(crate) fn clear(&mut self) {
        self.bodies.clear();
        self.bodies.push(u32::MAX);
        self.manifolds.clear();
        self.joint_slots.clear();
        self.velocities.clear();
        self.velocities.push(BodyVelocity::FIXED);
        self.motions.clear();
        self.motions.push(BodyMotion::FIXED);
        self.contacts.clear();
        self.joints.clear();
        self.lanes.clear();
        self.replicas.clear();
        self.color_count = 0;
        self.joint_gap = 0.0;
        self.penetration = 0.0;
    }

    /// Gives a body the next slot; its state is loaded later, by [`load_bodies`](Self::load_bodies).
    pub(crate) fn enlist(&mut self, body: u32) -> u32 {
        self.bodies.push(body);
        self.bodies.len() as u32 - 1
    }

    /// Loads the state of all enlisted bodies.
    pub(crate) fn load_bodies(&mut self, state: impl Fn(u32) -> (BodyVelocity, BodyMotion)) {
        for &body in &self.bodies[1..] {
            let (velocity, motion) = state(body);
            self.velocities.push(velocity);
            self.motions.push(motion);
        }
    }

    /// Slot of a kinematic body, which `state` makes on first use.
    pub(crate) fn replica(&mut self, body: u32, state: impl FnOnce() -> (BodyVelocity, BodyMotion)) -> u32 {
        match self.replicas.binary_search_by_key(&body, |replica| replica.body) {
            Ok(found) => self.replicas[found].slot,
            Err(place) => {
                let (velocity, motion) = state();
                let slot = self.enlist(body);
                self.velocities.push(velocity);
                self.motions.push(motion);
                self.replicas.insert(place, Replica { body, slot });
                slot
            }
        }
    }

    /// Lays out a block and a lane for every manifold; `ends` gives the slots of each.
    pub(crate) fn color_contacts(&mut self, ends: &[(u32, u32)]) {
        self.coloring.reset(self.velocities.len());
        self.colors.clear();
        let mut counts = [0_u32; MAX_COLORS + 1];
        for &(a, b) in ends {
            self.motions[a as usize].constrained = true;
            self.motions[b as usize].constrained = true;
            let end = |slot: u32| (slot, slot != WORLD_SLOT && self.motions[slot as usize].is_dynamic());
            let color = self.coloring.assign(end(a), end(b)).unwrap_or(MAX_COLORS as u32);
            counts[color as usize] += 1;
            self.colors.push(color);
        }
        let mut next = [0_u32; MAX_COLORS + 1];
        let mut blocks = 0;
        for color in 0..MAX_COLORS {
            next[color] = blocks * LANES as u32;
            blocks += counts[color].div_ceil(LANES as u32);
        }
        // What found no colour is solved one manifold a block, after the rest.
        let alone = blocks;
        blocks += counts[MAX_COLORS];
        self.color_count = counts.iter().filter(|&&count| count > 0).count() as u32;
        self.contacts.resize(blocks as usize, ContactBlock::EMPTY);
        for &color in &self.colors {
            let place = next[color as usize];
            next[color as usize] += 1;
            let lane = if color as usize == MAX_COLORS {
                (alone + place, 0)
            } else {
                (place / LANES as u32, place % LANES as u32)
            };
            self.lanes.push(lane);
        }
    }

    /// Prepares the rows of the manifold with this number; points closer than `reach` (m) count as touching.
    pub(crate) fn set_contact(&mut self, number: usize, input: &ContactInput, reach: f32) {
        let (block, lane) = self.lanes[number];
        self.contacts[block as usize].set_lane(lane as usize, input, &self.velocities, reach);
    }

    /// Multipliers of the manifold with this number.
    pub(crate) fn contact_impulses(&self, number: usize) -> ContactImpulses {
        let (block, lane) = self.lanes[number];
        self.contacts[block as usize].impulses(lane as usize)
    }

    /// Normal of the manifold with this number.
    pub(crate) fn contact_normal(&self, number: usize) -> glam::Vec3 {
        let (block, lane) = self.lanes[number];
        self.contacts[block as usize].normal_of(lane as usize)
    }
}
