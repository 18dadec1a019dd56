//! One batch of islands: slots for its bodies, blocks for its contacts, entries for its joints.

use glam::{DVec3, Quat, Vec3};

use super::birth::Birth;
use super::bound::BatchBounds;
use super::color::{Coloring, MAX_COLORS};
use super::contact::{ContactImpulses, ContactInput, LANES};
use super::contact_block::ContactBlocks;
use super::contact_kernels;
use super::direct::Direct;
use super::dissipative::DissipativeIslands;
use super::exact::ExactIslands;
use super::joint::{BatchJoints, JointEntry, may_be_cut};
use super::lead::Leads;
use super::load_pass::LoadPass;
use super::momentum::FreeIslands;
use super::passive::PassiveIslands;
use super::plane::Planes;
use super::poses::Poses;
use super::sheet::Sheet;
use super::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use super::taut::TautRows;
use super::told::Told;
use super::wrap::BatchWraps;
use crate::room::make_room;
use crate::workers::Workers;

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
    /// Whether it neither rebounds nor resists rolling.
    pub is_plain: bool,
}

/// Groups of manifolds: two for each colour, two for what found none; the first of those; and all groups once more for manifolds of
/// bodies that joints hold, with each other and with what is fixed.
const GROUPS: usize = 2 * MAX_COLORS + 2;
const ALONE: usize = 2 * MAX_COLORS;
const ALL_GROUPS: usize = 2 * GROUPS;

/// Whether manifolds of this group share no moving body.
fn is_colored(group: usize) -> bool {
    group % GROUPS < ALONE
}

/// Whether manifolds of this group have more than one point.
fn has_faces(group: usize) -> bool {
    group.is_multiple_of(2)
}

/// Group, and block, of a manifold that an articulation holds.
const HELD: u32 = u32::MAX;

/// Of a lane that has no manifold.
const NO_MANIFOLD: u32 = u32::MAX;

/// Blocks that are worth another thread's while: some 10 µs.
const LEAST_BLOCKS: usize = 8;

/// Bodies of the same.
const LEAST_BODIES: usize = 64;

/// Bodies, contacts and joints solved together.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// Substeps of the world that its islands take at once.
    pub stride: u32,
    /// Body of each slot; the first is the world slot and has none.
    pub bodies: Vec<u32>,
    /// First slot of each island.
    pub islands: Vec<u32>,
    /// Manifolds as (pair, manifold of the pair), in the order they were added.
    pub manifolds: Vec<(u32, u32)>,
    /// Joints, by slot in the world's pool.
    pub joint_slots: Vec<u32>,
    /// Both sides of each of those, where bounds or planes ask for them.
    pub joint_ends: Vec<[JointEnd; 2]>,
    pub velocities: Vec<BodyVelocity>,
    pub motions: Vec<BodyMotion>,
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
    pub poses: Poses,
    pub free: FreeIslands,
    pub passive: PassiveIslands,
    pub dissipative: DissipativeIslands,
    pub sheet: Sheet,
    pub leads: Leads,
    /// Whether a joint of the slot's body is solved by sweeps.
    pub swept: Vec<bool>,
    pub direct: Direct,
    /// Joints that a direct solve may not take.
    pub withheld: Vec<JointEntry>,
    /// Slots of the bodies of each manifold, and how many points it has.
    pub ends: Vec<ContactEnds>,
    /// All manifolds, where an articulation may hold some.
    pub inputs: Vec<ContactInput>,
    /// Whether contacts are added up over the substeps, and their sums by manifold.
    pub tallied: bool,
    tally: Vec<ContactImpulses>,
    /// What is told of the manifolds of each block, if anybody wants to know.
    pub told: Vec<[Told; LANES]>,
    /// Block and lane of each manifold, and the manifold of each lane.
    lanes: Vec<(u32, u32)>,
    numbers: Vec<[u32; LANES]>,
    /// Kinematic bodies that have a slot here, sorted by body.
    replicas: Vec<Replica>,
    pub birth: Birth,
    pub load_pass: LoadPass,
    pub exact: ExactIslands,
    pub coloring: Coloring,
    /// Colour of each manifold, twice, plus one if it has a single point; and [`GROUPS`] more where joints hold what
    /// moves of its bodies.
    groups: Vec<u32>,
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
        self.stride = 1;
        self.bodies.clear();
        self.bodies.push(u32::MAX);
        self.islands.clear();
        self.manifolds.clear();
        self.joint_slots.clear();
        self.joint_ends.clear();
        self.velocities.clear();
        self.motions.clear();
        self.ends.clear();
        self.inputs.clear();
        self.contacts.clear();
        self.joints.clear();
        self.bound_slots.clear();
        self.bounds.clear();
        self.taut.clear();
        self.wraps.clear();
        self.chains.clear();
        self.planes.clear();
        self.free.clear();
        self.passive.clear();
        self.dissipative.clear();
        self.leads.clear();
        self.direct.clear();
        self.lanes.clear();
        self.tally.clear();
        self.told.clear();
        self.tallied = false;
        self.replicas.clear();
        self.color_count = 0;
        self.joint_gap = 0.0;
        self.penetration = 0.0;
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
        let Self { bodies, velocities, motions, .. } = self;
        make_room(velocities, bodies.len());
        make_room(motions, bodies.len());
        velocities.push(BodyVelocity::FIXED);
        motions.push(BodyMotion::FIXED);
        if !threads.has_team() {
            for &body in &bodies[1..] {
                let (velocity, motion) = state(body);
                velocities.push(velocity);
                motions.push(motion);
            }
            return;
        }
        velocities.resize(bodies.len(), BodyVelocity::FIXED);
        motions.resize(bodies.len(), BodyMotion::FIXED);
        let piece = threads.piece(bodies.len(), LEAST_BODIES);
        let places = velocities[1..].chunks_mut(piece).zip(motions[1..].chunks_mut(piece));
        threads.share(places.zip(bodies[1..].chunks(piece)), |((velocities, motions), bodies)| {
            for ((velocity, motion), &body) in velocities.iter_mut().zip(motions).zip(bodies) {
                (*velocity, *motion) = state(body);
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
                self.motions.push(motion);
                self.leads.add_slot(&velocity);
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

    /// Lays out a block and a lane for every manifold that no articulation holds.
    ///
    /// Within a colour, manifolds of one point have blocks of their own, which cost a fraction of those of four.
    pub(crate) fn color_contacts(&mut self) {
        if self.ends.is_empty() {
            self.first_jointed = 0;
            return;
        }
        self.coloring.reset(self.velocities.len());
        self.groups.clear();
        let mut counts = [0_u32; ALL_GROUPS];
        let mut color_count = 0;
        for (number, &ContactEnds { a, b, points, .. }) in self.ends.iter().enumerate() {
            if self.direct.holds(number) {
                self.groups.push(HELD);
                continue;
            }
            self.motions[a as usize].constrained = true;
            self.motions[b as usize].constrained = true;
            let end = |slot: u32| (slot, slot != WORLD_SLOT && self.motions[slot as usize].is_dynamic());
            let color = self.coloring.assign(end(a), end(b)).unwrap_or(MAX_COLORS as u32);
            let ends = [a, b].map(|slot| &self.motions[slot as usize]);
            let held_by_joints =
                ends.iter().any(|end| end.is_dynamic()) && ends.iter().all(|end| end.jointed || !end.is_dynamic());
            let group = 2 * color as usize + usize::from(points == 1) + if held_by_joints { GROUPS } else { 0 };
            counts[group] += 1;
            color_count = color_count.max(color + 1);
            self.groups.push(group as u32);
        }
        // Most of the groups are of colours that no manifold has.
        let used = 2 * color_count as usize;
        let groups = || (0..used).chain(GROUPS..GROUPS + used).map(|group| (group, counts[group]));
        // What found no colour is solved one manifold a block, after the rest.
        let blocks_of = |group: usize, count: u32| if is_colored(group) { count.div_ceil(LANES as u32) } else { count } as usize;
        let (mut blocks, mut faces) = (0, 0);
        for (group, count) in groups() {
            blocks += blocks_of(group, count);
            faces += if has_faces(group) { blocks_of(group, count) } else { 0 };
        }
        self.contacts.make_room(blocks, faces);
        let mut next = [0_u32; ALL_GROUPS];
        self.first_jointed = 0;
        for (group, count) in groups() {
            if group == GROUPS {
                self.first_jointed = self.contacts.len();
            }
            let first = self.contacts.len();
            next[group] = (first * LANES) as u32;
            self.contacts.add(blocks_of(group, count), has_faces(group));
            self.contacts.add_color(first, is_colored(group), has_faces(group));
        }
        // Colours are taken from the lowest on.
        self.color_count = color_count;
        for &group in &self.groups {
            if group == HELD {
                self.lanes.push((HELD, 0));
                continue;
            }
            let place = &mut next[group as usize];
            self.lanes.push((*place / LANES as u32, *place % LANES as u32));
            *place += if is_colored(group as usize) { 1 } else { LANES as u32 };
        }
        let Self { lanes, ends, contacts, .. } = self;
        let needs = |number: &usize| lanes[*number].0 != HELD && !ends[*number].is_plain;
        if (0..lanes.len()).any(|number| needs(&number)) {
            contacts.add_extras((0..lanes.len()).filter(needs).map(|number| lanes[number].0 as usize));
        }
    }

    /// Prepares the rows of all manifolds that have a lane, which `form` brings into world axes; points closer than `reach` (m) count
    /// as touching.
    pub(crate) fn set_contacts(
        &mut self,
        threads: &Workers,
        reach: f32,
        form: impl Fn((u32, u32), ContactEnds) -> ContactInput + Sync,
    ) {
        let Self { lanes, numbers, inputs, manifolds, ends, contacts, velocities, .. } = self;
        let input = |number: usize| {
            let formed = inputs.get(number).copied();
            formed.unwrap_or_else(|| form(manifolds[number], ends[number]))
        };
        let placed = || lanes.iter().enumerate().filter(|(_, (block, _))| *block != HELD);
        if threads.is_alone() {
            // In the order in which pairs lie in memory, which blocks do not follow.
            for (number, &(block, lane)) in placed() {
                contacts.whole(block as usize).set_lane(lane as usize, &input(number), reach);
            }
            for number in 0..contacts.len() {
                contact_kernels::set_masses(&mut contacts.whole(number), velocities);
            }
            return;
        }
        numbers.clear();
        make_room(numbers, contacts.len());
        numbers.resize(contacts.len(), [NO_MANIFOLD; LANES]);
        for (number, &(block, lane)) in placed() {
            numbers[block as usize][lane as usize] = number as u32;
        }
        let piece = threads.piece(contacts.len(), LEAST_BLOCKS);
        threads.share(contacts.parts(piece).zip(numbers.chunks(piece)), |(part, numbers)| {
            for (mut block, numbers) in part.iter().zip(numbers) {
                for (lane, &number) in numbers.iter().enumerate().filter(|(_, number)| **number != NO_MANIFOLD) {
                    block.set_lane(lane, &input(number as usize), reach);
                }
                contact_kernels::set_masses(&mut block, velocities);
            }
        });
    }

    /// Multipliers of the manifold with this number.
    pub(crate) fn contact_impulses(&self, number: usize) -> ContactImpulses {
        let (block, lane) = self.lanes[number];
        if block == HELD {
            return self.direct.impulses_of(number);
        }
        self.contacts.impulses(block as usize, lane as usize)
    }

    /// Sum of the multipliers with which a manifold has rebounded in this step, where none presses any more (N·s).
    pub(crate) fn contact_rebound(&self, number: usize) -> f32 {
        let (block, lane) = self.lanes[number];
        if block == HELD { 0.0 } else { self.contacts.blow(block as usize, lane as usize) }
    }

    /// What is told of a manifold; nothing where an articulation holds it, or where nobody wants to know.
    pub(crate) fn contact_told(&self, number: usize) -> Told {
        let (block, lane) = self.lanes[number];
        self.told.get(block as usize).map_or(Told::NOTHING, |block| block[lane as usize])
    }

    /// Impulse along the normal of a manifold over the step (N·s), where multipliers are added up.
    pub(crate) fn contact_blow(&self, number: usize) -> f32 {
        if self.lanes[number].0 == HELD {
            return self.direct.blow_of(number);
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
