//! One batch of islands: slots for its bodies, blocks for its contacts, entries for its joints.

use super::body_flags::BodyFlags;
use super::contact::{ContactImpulses, ContactInput, LANES};
use super::contact_block::{BlockSums, ContactBlocks};
use super::direct::Direct;
use super::distance_bound::BatchBounds;
use super::joint::{BatchJoints, may_be_cut};
use super::momentum::FreeIslands;
use super::newton::Newton;
use super::plane::Planes;
use super::round_contacts::RoundContacts;
use super::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use super::status::ContactStatus;
use super::taut_line::TautRows;
use super::velocity_half_step::HalfStepVelocities;
use super::wide_bodies::WideBodies;
use super::wrapped_bound::BatchWraps;
use crate::joint_graph::mesh;
use crate::tight_vec::{extend_tightly, make_room, resize};
use crate::workers::Workers;

mod falling;
mod kicks;
mod lanes;

use kicks::IslandNote;
pub(crate) use lanes::LaneLayout;

/// Slot that stands for a body of the world in this batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Replica {
    body: u32,
    slot: u32,
}

/// What the order of a batch's manifolds follows from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactEnds {
    pub a: u32,
    pub b: u32,
    pub points: u8,
    /// Whether it neither rebounds nor resists rolling or spinning by itself, nor lies on what the host turns, nor is swung.
    pub is_plain: bool,
    /// Of each side, whether its round features are followed in each substep; before it has slots whether they may be.
    pub is_swung: [bool; 2],
}

/// Slot of an end that is still to be given a replica.
pub(crate) const REPLICA: u32 = u32::MAX;

/// Group, and block, of a manifold that an articulation holds.
const HELD: u32 = u32::MAX;

/// Bodies that are worth another thread's while: some 10 µs.
const MIN_BODIES: usize = 64;

/// The manifolds of a batch.
#[derive(Debug, Default)]
pub(crate) struct BatchManifolds {
    /// Each as (pair, manifold of the pair), in the order they were added.
    pub list: Vec<(u32, u32)>,
    /// Slots of the bodies of each, and how many points it has.
    pub ends: Vec<ContactEnds>,
    /// All of them, where an articulation may hold some.
    pub inputs: Vec<ContactInput>,
    pub tally: ContactTally,
    /// Those of round features that are swung.
    pub round: RoundContacts,
}

/// What is said of manifolds after a step, if anybody wants to know.
#[derive(Debug, Default)]
pub(crate) struct ContactTally {
    /// Whether multipliers of all manifolds are added up over the substeps; those that are else, and the blocks that have any of these.
    pub is_on: bool,
    pub numbers: Vec<u32>,
    blocks: Vec<u32>,
    /// Sums by block.
    sums: Vec<BlockSums>,
    /// What is told of the manifolds of each block.
    pub told: Vec<[ContactStatus; LANES]>,
}

impl ContactTally {
    /// Whether nothing is added up.
    fn is_empty(&self) -> bool {
        !self.is_on && self.numbers.is_empty()
    }

    /// How many manifolds of so many are.
    fn count(&self, all: usize) -> usize {
        if self.is_on { all } else { self.numbers.len() }
    }

    /// Number of one of those.
    fn number(&self, place: usize) -> usize {
        if self.is_on { place } else { self.numbers[place] as usize }
    }
}

/// Long-range bounds of a batch.
#[derive(Debug, Default)]
pub(crate) struct LongRangeRows {
    /// By slot in the world's list.
    pub slots: Vec<u32>,
    pub bounds: BatchBounds,
    pub taut: TautRows,
    pub wraps: BatchWraps,
    /// Whether a joint of each slot's body is solved by sweeps.
    pub swept: Vec<bool>,
}

impl LongRangeRows {
    fn clear(&mut self) {
        self.slots.clear();
        self.bounds.clear();
        self.taut.clear();
        self.wraps.clear();
    }
}

/// Worst joint gap and penetration at the end of a step (m).
#[derive(Debug, Default)]
pub(crate) struct BatchResiduals {
    pub joint_gap: f32,
    pub penetration: f32,
}

/// Bodies, contacts and joints solved together: what the stages of a step share.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// Substeps of the world that its islands take at once: less than one where they take several for each.
    pub stride: f32,
    /// Body of each slot; the first is the world slot and has none.
    pub bodies: Vec<u32>,
    /// First slot of each island.
    pub islands: Vec<u32>,
    /// What is known of each island.
    notes: Vec<IslandNote>,
    pub velocities: Vec<BodyVelocity>,
    pub motions: Vec<BodyMotion>,
    pub body_flags: Vec<BodyFlags>,
    /// Kinematic bodies that have a slot here, sorted by body.
    replicas: Vec<Replica>,
    pub poses: WideBodies,
    pub free: FreeIslands,
    pub half_steps: HalfStepVelocities,
    pub manifolds: BatchManifolds,
    /// Blocks of manifolds, those of which joints hold all that moves last.
    pub contacts: ContactBlocks,
    pub layout: LaneLayout,
    pub joints: BatchJoints,
    pub long_range: LongRangeRows,
    pub planes: Planes,
    pub direct: Direct,
    pub newton: Newton,
    pub residuals: BatchResiduals,
}

impl Batch {
    /// Empties the batch but keeps its memory.
    pub(crate) fn clear(&mut self) {
        self.stride = 1.0;
        self.bodies.clear();
        self.bodies.push(u32::MAX);
        self.islands.clear();
        let BatchManifolds { list, ends, inputs, tally, round } = &mut self.manifolds;
        list.clear();
        ends.clear();
        inputs.clear();
        round.clear();
        tally.is_on = false;
        tally.numbers.clear();
        tally.blocks.clear();
        tally.sums.clear();
        tally.told.clear();
        self.joints.slots.clear();
        self.joints.ends.clear();
        self.body_flags.clear();
        self.long_range.clear();
        self.planes.clear();
        self.free.clear();
        self.half_steps.clear();
        self.direct.clear();
        self.newton.clear();
        self.layout.lanes.clear();
        self.layout.color_count = 0;
        self.replicas.clear();
        self.residuals = BatchResiduals::default();
    }

    /// Takes a manifold: a pair's slot and which of its manifolds.
    pub(crate) fn add_manifold(&mut self, manifold: (u32, u32), ends: ContactEnds) {
        extend_tightly(&mut self.manifolds.list, std::iter::once(manifold));
        extend_tightly(&mut self.manifolds.ends, std::iter::once(ends));
    }

    /// Room for all manifolds that it takes, as [`add_manifold`](Self::add_manifold) would fill it.
    pub(crate) fn room_for_manifolds(&mut self, count: usize) -> (&mut [(u32, u32)], &mut [ContactEnds]) {
        let BatchManifolds { list, ends, .. } = &mut self.manifolds;
        resize(list, count, (0, 0));
        resize(ends, count, ContactEnds { a: WORLD_SLOT, b: WORLD_SLOT, points: 0, is_plain: true, is_swung: [false; 2] });
        (list, ends)
    }

    /// Bodies enlisted so far.
    pub(crate) fn body_count(&self) -> u32 {
        self.bodies.len() as u32 - 1
    }

    /// Work that it makes for several threads.
    pub(crate) fn load(&self) -> usize {
        let joints = self.joints.slots.len();
        self.manifolds.list.len() + if may_be_cut(joints, self.body_count() as usize) { joints } else { 0 }
    }

    /// What goes with the time that one thread takes for it: bodies, joints and manifolds.
    pub(crate) fn size(&self) -> usize {
        self.manifolds.list.len() + self.joints.slots.len() + self.body_count() as usize
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

    /// Loads the state of all enlisted bodies, each with whether the host pushes it.
    pub(crate) fn load_bodies(&mut self, threads: &Workers, state: impl Fn(u32) -> (BodyVelocity, BodyMotion, bool) + Sync) {
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
                let (velocity, motion, is_pushed) = state(body);
                velocities.push(velocity);
                body_flags.push(BodyFlags::of(&velocity, &motion).pushed(is_pushed));
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
                let is_pushed;
                (*velocity, *motion, is_pushed) = state(body);
                *role = BodyFlags::of(velocity, motion).pushed(is_pushed);
            }
        });
    }

    /// Notes whose joints are left to sweeps: bounds are for those.
    pub(crate) fn mark_swept(&mut self) {
        let swept = &mut self.long_range.swept;
        swept.clear();
        swept.resize(self.velocities.len(), false);
        for entry in &self.joints.entries {
            swept[entry.a as usize] = true;
            swept[entry.b as usize] = true;
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

    /// Whether bodies may carry what contacts do from substep to substep: it is one large island, as what is done must not depend on what else is
    /// in a batch.
    pub(crate) fn may_carry_changes(&self) -> bool {
        self.islands.len() == 1 && self.moving() >= mesh::MIN_BODIES
    }

    /// Whether the host turns anything faster than this in it (rad/s).
    pub(crate) fn is_turned_by(&self, speed: f32) -> bool {
        self.velocities[self.moving() + 1..].iter().any(|velocity| velocity.angular.length_squared() > speed * speed)
    }

    /// Whether bodies without joints may be solved as one: contacts are formed then.
    pub(crate) fn may_hold_rows(&mut self) -> bool {
        let end = self.moving() + 1;
        let bodies = (&self.velocities[..end], &self.motions[..end]);
        self.newton.may_hold_rows(&self.islands, bodies, self.manifolds.ends.iter().map(|ends| [ends.a, ends.b]))
    }

    /// Block and lane of the manifold with this number; none where an articulation holds it.
    pub(crate) fn place_of(&self, number: usize) -> Option<(u32, u32)> {
        self.layout.lanes.get(number).copied().filter(|&(block, _)| block != HELD)
    }

    /// Multipliers of the manifold with this number.
    pub(crate) fn contact_impulses(&self, number: usize) -> ContactImpulses {
        let (block, lane) = self.layout.lanes[number];
        if block == HELD {
            return self.newton.impulses_of(number).unwrap_or_else(|| self.direct.impulses_of(number));
        }
        self.contacts.impulses(block as usize, lane as usize)
    }

    /// Asks for the memory of the multipliers of a manifold, if it is the first of its block.
    #[inline(always)]
    pub(crate) fn ask_for_contact(&self, number: usize) {
        if let Some(&(block, 0)) = self.layout.lanes.get(number)
            && block != HELD
        {
            self.contacts.ask_for(block as usize);
        }
    }

    /// Sum of the multipliers with which a manifold has rebounded in this step, where none presses any more (N·s).
    pub(crate) fn contact_rebound(&self, number: usize) -> f32 {
        let (block, lane) = self.layout.lanes[number];
        if block == HELD { 0.0 } else { self.contacts.blow(block as usize, lane as usize) }
    }

    /// What is told of a manifold; nothing where an articulation holds it, or where nobody wants to know.
    pub(crate) fn contact_told(&self, number: usize) -> ContactStatus {
        let (block, lane) = self.layout.lanes[number];
        self.manifolds.tally.told.get(block as usize).map_or(ContactStatus::NOTHING, |block| block[lane as usize])
    }

    /// Impulse along the normal of a manifold over the step (N·s), where multipliers are added up.
    pub(crate) fn contact_blow(&self, number: usize) -> f32 {
        self.sum_of(number).normal.iter().sum()
    }

    /// Adds the multipliers of a substep to the sums. What is solved through the whole step at once has its own.
    pub(crate) fn add_to_tally(&mut self) {
        let Self { layout, contacts, manifolds: BatchManifolds { tally, .. }, .. } = self;
        if tally.is_empty() || contacts.is_empty() {
            return;
        }
        if tally.sums.is_empty() {
            tally.sums.resize(contacts.len(), BlockSums::NONE);
            let ContactTally { is_on, numbers, blocks, .. } = tally;
            if *is_on {
                blocks.extend(0..contacts.len() as u32);
            } else {
                blocks.extend(numbers.iter().map(|&number| layout.lanes[number as usize].0).filter(|&block| block != HELD));
            }
            blocks.sort_unstable();
            blocks.dedup();
        }
        tally.blocks.iter().for_each(|&block| contacts.add_up(block as usize, &mut tally.sums[block as usize]));
    }

    /// Sums of multipliers over the step's substeps, by manifold.
    pub(crate) fn tallies(&self) -> impl Iterator<Item = (usize, ContactImpulses)> {
        let tally = &self.manifolds.tally;
        (0..tally.count(self.manifolds.list.len())).map(|place| tally.number(place)).map(|number| (number, self.sum_of(number)))
    }

    fn sum_of(&self, number: usize) -> ContactImpulses {
        let (block, lane) = self.layout.lanes[number];
        if block == HELD {
            return self.newton.sum_of(number).unwrap_or_else(|| self.direct.sum_of(number));
        }
        let sums = self.manifolds.tally.sums.get(block as usize);
        sums.map_or(ContactImpulses::default(), |sums| self.contacts.sum_of(block as usize, lane as usize, sums))
    }

    /// Normal of the manifold with this number.
    pub(crate) fn contact_normal(&self, number: usize) -> glam::Vec3 {
        let (block, lane) = self.layout.lanes[number];
        if block == HELD {
            self.manifolds.inputs[number].normal
        } else {
            self.contacts.blocks[block as usize].normal_of(lane as usize)
        }
    }
}
