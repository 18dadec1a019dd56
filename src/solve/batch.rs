//! One batch of islands: slots for its bodies, blocks for its contacts, entries for its joints.

use glam::{DVec3, Quat, Vec3};

use super::body_flags::BodyFlags;
use super::buckets::Buckets;
use super::color::Coloring;
use super::contact::{ContactImpulses, ContactInput, LANES};
use super::contact_block::ContactBlocks;
use super::direct::Direct;
use super::distance_bound::BatchBounds;
use super::joint::{BatchJoints, may_be_cut};
use super::momentum::FreeIslands;
use super::newton::Newton;
use super::plane::Planes;
use super::slides::Slides;
use super::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use super::status::ContactStatus;
use super::taut_line::TautRows;
use super::velocity_half_step::HalfStepVelocities;
use super::wide_bodies::WideBodies;
use super::wrapped_bound::BatchWraps;
use crate::tight_vec::{extend_tightly, make_room, resize};
use crate::workers::Workers;

mod lanes;

/// Slot that stands for a body of the world in this batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Replica {
    body: u32,
    slot: u32,
}

/// One side of a joint: what it hangs on, and where its point is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointEnd {
    pub slot: u32,
    /// World position that displacements count from (m).
    pub origin: DVec3,
    /// Joint point from there, in the body's frame (m).
    pub lever: Vec3,
    pub frame: Quat,
}

/// What the order of a batch's manifolds follows from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactEnds {
    pub a: u32,
    pub b: u32,
    pub points: u8,
    /// Whether it neither rebounds nor resists rolling or spinning by itself, nor lies on what the host turns.
    pub is_plain: bool,
}

/// Slot of an end that is still to be given a replica.
pub(crate) const REPLICA: u32 = u32::MAX;

/// Group, and block, of a manifold that an articulation holds.
const HELD: u32 = u32::MAX;

/// Bodies that are worth another thread's while: some 10 µs.
const MIN_BODIES: usize = 64;

/// Bodies, contacts and joints solved together.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// Substeps of the world that its islands take at once: less than one where they take several for each.
    pub stride: f32,
    /// Body of each slot; the first is the world slot and has none.
    pub bodies: Vec<u32>,
    /// First slot of each island.
    pub islands: Vec<u32>,
    /// Manifolds as (pair, manifold of the pair), in the order they were added.
    pub manifolds: Vec<(u32, u32)>,
    /// Joints, by slot in the world's pool.
    pub joint_slots: Vec<u32>,
    /// Both sides of each of those, where bounds ask for them.
    pub joint_ends: Vec<[JointEnd; 2]>,
    pub velocities: Vec<BodyVelocity>,
    pub motions: Vec<BodyMotion>,
    pub body_flags: Vec<BodyFlags>,
    /// Blocks of manifolds, those of which joints hold all that moves last.
    pub contacts: ContactBlocks,
    /// The first of those last ones.
    pub first_jointed: usize,
    pub joints: BatchJoints,
    /// Long-range bounds, by slot in the world's list and as rows.
    pub bound_slots: Vec<u32>,
    pub bounds: BatchBounds,
    pub taut: TautRows,
    pub wraps: BatchWraps,
    /// Hinge chains, by number in the world's list and as planes.
    pub chains: Vec<u32>,
    pub planes: Planes,
    pub poses: WideBodies,
    pub free: FreeIslands,
    pub half_steps: HalfStepVelocities,
    /// Whether a joint of the slot's body is solved by sweeps.
    pub swept: Vec<bool>,
    pub direct: Direct,
    pub newton: Newton,
    /// Slots of the bodies of each manifold, and how many points it has.
    pub ends: Vec<ContactEnds>,
    /// All manifolds, where an articulation may hold some.
    pub inputs: Vec<ContactInput>,
    /// Whether contacts are added up over the substeps, and their sums by manifold.
    pub tallied: bool,
    tally: Vec<ContactImpulses>,
    /// What is told of the manifolds of each block, if anybody wants to know.
    pub told: Vec<[ContactStatus; LANES]>,
    /// Block and lane of each manifold.
    lanes: Vec<(u32, u32)>,
    /// Which thread's each block is, where several work on them.
    places: Vec<u8>,
    /// Kinematic bodies that have a slot here, sorted by body.
    replicas: Vec<Replica>,
    pub slides: Slides,
    pub coloring: Coloring,
    /// Colour of each manifold, twice, plus one if it has a single point; and [`lanes::GROUPS`] more for each round before its own.
    groups: Vec<u32>,
    /// Manifolds of each group, then the next lane of each.
    group_lanes: Vec<u32>,
    /// Manifolds by the first of their bodies, where there are many.
    by_body: Buckets,
    pub pushes: Vec<BodyVelocity>,
    /// Number of colours that the contacts took.
    pub color_count: u32,
    /// Worst joint gap and penetration at the end of the step (m).
    pub joint_gap: f32,
    pub penetration: f32,
}

impl Batch {
    /// Empties the batch but keeps its memory.
    pub(crate) fn clear(&mut self) {
        self.stride = 1.0;
        self.bodies.clear();
        self.bodies.push(u32::MAX);
        self.islands.clear();
        self.manifolds.clear();
        self.joint_slots.clear();
        self.joint_ends.clear();
        self.body_flags.clear();
        self.ends.clear();
        self.inputs.clear();
        self.bound_slots.clear();
        self.bounds.clear();
        self.taut.clear();
        self.wraps.clear();
        self.chains.clear();
        self.planes.clear();
        self.free.clear();
        self.half_steps.clear();
        self.direct.clear();
        self.newton.clear();
        self.slides.clear();
        self.lanes.clear();
        self.tally.clear();
        self.told.clear();
        self.tallied = false;
        self.replicas.clear();
        self.color_count = 0;
        self.joint_gap = 0.0;
        self.penetration = 0.0;
    }

    /// Takes a manifold: a pair's slot and which of its manifolds.
    pub(crate) fn add_manifold(&mut self, manifold: (u32, u32), ends: ContactEnds) {
        extend_tightly(&mut self.manifolds, std::iter::once(manifold));
        extend_tightly(&mut self.ends, std::iter::once(ends));
    }

    /// Room for all manifolds that it takes, as [`add_manifold`](Self::add_manifold) would fill it.
    pub(crate) fn room_for_manifolds(&mut self, count: usize) -> (&mut [(u32, u32)], &mut [ContactEnds]) {
        let Self { manifolds, ends, .. } = self;
        resize(manifolds, count, (0, 0));
        resize(ends, count, ContactEnds { a: WORLD_SLOT, b: WORLD_SLOT, points: 0, is_plain: true });
        (manifolds, ends)
    }

    /// Bodies enlisted so far.
    pub(crate) fn body_count(&self) -> u32 {
        self.bodies.len() as u32 - 1
    }

    /// Work that it makes for several threads.
    pub(crate) fn load(&self) -> usize {
        let joints = self.joint_slots.len();
        self.manifolds.len() + if may_be_cut(joints, self.body_count() as usize) { joints } else { 0 }
    }

    /// Bodies that it has had room for.
    pub(crate) fn room(&self) -> usize {
        self.bodies.capacity()
    }

    /// Says that the bodies enlisted from here on are those of another island.
    pub(crate) fn begin_island(&mut self) {
        self.islands.push(self.bodies.len() as u32);
    }

    /// Gives a body the next slot; its state is loaded later, by [`load_bodies`](Self::load_bodies).
    pub(crate) fn enlist(&mut self, body: u32) -> u32 {
        self.bodies.push(body);
        self.bodies.len() as u32 - 1
    }

    /// Loads the state of all enlisted bodies.
    pub(crate) fn load_bodies(&mut self, threads: &Workers, state: impl Fn(u32) -> (BodyVelocity, BodyMotion) + Sync) {
        let Self { bodies, velocities, motions, body_flags, .. } = self;
        if !threads.has_team() {
            velocities.clear();
            motions.clear();
            make_room(velocities, bodies.len());
            make_room(motions, bodies.len());
            velocities.push(BodyVelocity::FIXED);
            motions.push(BodyMotion::FIXED);
            body_flags.push(BodyFlags::default());
            for &body in &bodies[1..] {
                let (velocity, motion) = state(body);
                velocities.push(velocity);
                body_flags.push(BodyFlags::of(&velocity, &motion));
                motions.push(motion);
            }
            return;
        }
        resize(velocities, bodies.len(), BodyVelocity::FIXED);
        resize(motions, bodies.len(), BodyMotion::FIXED);
        (velocities[0], motions[0]) = (BodyVelocity::FIXED, BodyMotion::FIXED);
        body_flags.resize(bodies.len(), BodyFlags::default());
        let piece = threads.piece(bodies.len(), MIN_BODIES);
        let places = velocities[1..].chunks_mut(piece).zip(motions[1..].chunks_mut(piece)).zip(body_flags[1..].chunks_mut(piece));
        threads.share(places.zip(bodies[1..].chunks(piece)), |(((velocities, motions), body_flags), bodies)| {
            for (((velocity, motion), role), &body) in velocities.iter_mut().zip(motions).zip(body_flags).zip(bodies) {
                (*velocity, *motion) = state(body);
                *role = BodyFlags::of(velocity, motion);
            }
        });
    }

    /// Notes whose joints are left to sweeps: bounds are for those.
    pub(crate) fn mark_swept(&mut self) {
        self.swept.clear();
        self.swept.resize(self.velocities.len(), false);
        for entry in &self.joints.entries {
            self.swept[entry.a as usize] = true;
            self.swept[entry.b as usize] = true;
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
                self.body_flags.push(BodyFlags::of(&velocity, &motion));
                self.motions.push(motion);
                self.half_steps.add_slot(&velocity);
                self.replicas.insert(place, Replica { body, slot });
                slot
            }
        }
    }

    /// Kinematic bodies that have slots here, the last ones.
    pub(crate) fn replica_count(&self) -> usize {
        self.replicas.len()
    }

    /// Slots after the world's that are those of bodies which rows may move.
    pub(crate) fn moving(&self) -> usize {
        self.bodies.len() - 1 - self.replicas.len()
    }

    /// Whether bodies without joints may be solved as one: contacts are formed then.
    pub(crate) fn may_hold_rows(&mut self) -> bool {
        let end = self.moving() as u32 + 1;
        self.newton.may_hold_rows(&self.islands, end, self.ends.iter().map(|ends| [ends.a, ends.b]))
    }

    /// Block and lane of the manifold with this number; none where an articulation holds it.
    pub(crate) fn place_of(&self, number: usize) -> Option<(u32, u32)> {
        self.lanes.get(number).copied().filter(|&(block, _)| block != HELD)
    }

    /// Multipliers of the manifold with this number.
    pub(crate) fn contact_impulses(&self, number: usize) -> ContactImpulses {
        let (block, lane) = self.lanes[number];
        if block == HELD {
            return self.newton.impulses_of(number).unwrap_or_else(|| self.direct.impulses_of(number));
        }
        self.contacts.impulses(block as usize, lane as usize)
    }

    /// Asks for the memory of the multipliers of a manifold, if it is the first of its block.
    #[inline(always)]
    pub(crate) fn ask_for_contact(&self, number: usize) {
        if let Some(&(block, 0)) = self.lanes.get(number)
            && block != HELD
        {
            self.contacts.ask_for(block as usize);
        }
    }

    /// Sum of the multipliers with which a manifold has rebounded in this step, where none presses any more (N·s).
    pub(crate) fn contact_rebound(&self, number: usize) -> f32 {
        let (block, lane) = self.lanes[number];
        if block == HELD { 0.0 } else { self.contacts.blow(block as usize, lane as usize) }
    }

    /// What is told of a manifold; nothing where an articulation holds it, or where nobody wants to know.
    pub(crate) fn contact_told(&self, number: usize) -> ContactStatus {
        let (block, lane) = self.lanes[number];
        self.told.get(block as usize).map_or(ContactStatus::NOTHING, |block| block[lane as usize])
    }

    /// Impulse along the normal of a manifold over the step (N·s), where multipliers are added up.
    pub(crate) fn contact_blow(&self, number: usize) -> f32 {
        if self.lanes[number].0 == HELD {
            return self.newton.blow_of(number).unwrap_or_else(|| self.direct.blow_of(number));
        }
        self.tally.get(number).map_or(0.0, |sum| sum.normal.iter().sum())
    }

    /// Adds the multipliers of a substep to the sums.
    pub(crate) fn add_to_tally(&mut self) {
        if !self.tallied {
            return;
        }
        self.tally.resize(self.manifolds.len(), ContactImpulses::default());
        for number in 0..self.tally.len() {
            let impulses = self.contact_impulses(number);
            self.tally[number].add(&impulses);
        }
    }

    /// Sums of multipliers over the step's substeps, by manifold.
    pub(crate) fn tallies(&self) -> impl Iterator<Item = (usize, &ContactImpulses)> {
        self.tally.iter().enumerate()
    }

    /// Normal of the manifold with this number.
    pub(crate) fn contact_normal(&self, number: usize) -> glam::Vec3 {
        let (block, lane) = self.lanes[number];
        if block == HELD { self.inputs[number].normal } else { self.contacts.blocks[block as usize].normal_of(lane as usize) }
    }
}
