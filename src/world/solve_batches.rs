//! Stage that fills the batches from the world's records and solves them side by side.

use std::cmp::Reverse;

use glam::{DVec3, Vec3};

use super::World;
use super::body_shape_table::BodyShapeTable;
use super::driven_ways::DrivenWays;
use super::islands::IslandGroups;
use super::long_range::BoundRecord;
use super::unions::Unions;
use crate::body::{Body, BodyKind};
use crate::collide::cache::PairCache;
use crate::collide::collider::Collider;
use crate::collide::pairs::WorldManifold;
use crate::collide::persistent_manifold::TOUCHING_SHARE;
use crate::id::{BodyId, JointId, Pool, ShapeId};
use crate::joint_graph::Derived;
use crate::joint_graph::plane::Chain;
use crate::joint_record::Joint;
use crate::long_range::LongRangeDef;
use crate::material::PairMaterial;
use crate::prefetch::{AHEAD, prefetch};
use crate::settings::Solver;
use crate::solve::StepSettings;
use crate::solve::batch::{Batch, BatchManifolds, ContactEnds, REPLICA};
use crate::solve::contact::ContactInput;
use crate::solve::disjoint::{DisjointSlices, Slots};
use crate::solve::distance_bound::BoundEntry;
use crate::solve::joint::JointEnd;
use crate::solve::state::WORLD_SLOT;
use crate::solve::step::BatchStages;
use crate::solve::taut_line::TautEntry;
use crate::tight_vec::make_room;
use crate::tuning::plan::BATTED;
use crate::workers::Workers;
use crate::world::support::told_by;

mod direct;
mod joints;
mod planes;
mod round;
mod states;
mod tally;
mod wrap;

/// How much faster than the fastest body of its batch a body may become in one step by what others do to it: an elastic blow from
/// one that is far heavier doubles its speed.
const OUTPACED: f32 = 2.0;

/// Manifolds, and joints of a net, of a batch from which on all threads work on it together, and how much it must have of what each
/// thread has to do: a part of its work is not shared, so other batches had better be solved beside it where they are as much.
const MIN_SHARED: usize = 512;
const SHARED_FROM: f32 = 0.8;

/// Manifolds that are worth another thread's while: some 5 µs.
const MIN_MANIFOLDS: usize = 128;

/// Everything that a batch reads.
struct BatchInput<'a> {
    bodies: &'a Pool<Body, BodyId>,
    colliders: &'a Pool<Collider, ShapeId>,
    index: &'a BodyShapeTable,
    pairs: &'a PairCache,
    joints: &'a Pool<Joint, JointId>,
    bounds: &'a [BoundRecord],
    long_range: &'a LongRangeDef,
    chains: &'a [Chain],
    /// Bodies whose joints are left to sweeps.
    swept: &'a [bool],
    span: &'a Derived,
    groups: &'a IslandGroups,
    unions: &'a Unions,
    /// Whether contacts are added up over the substeps.
    tallied: bool,
    gravity: Vec3,
    solver: Solver,
    /// Bodies that motors drive further than by their velocities.
    driven: &'a DrivenWays,
    /// Whether any body is flagged fast, with which stops what joints connect to it.
    some_are_fast: bool,
    /// Gap that gravity closes within a substep (m).
    reach: f32,
    /// Length of the step (s).
    dt: f32,
    /// Ratio of this step's substep to the last one's, by which carried multipliers grow.
    impulse_scale: f32,
}

impl World {
    /// Fills every batch, prepares its rows and moves its bodies through the step.
    pub(super) fn solve_batches(&mut self, dt: f32) {
        self.scratch.runs.find(&[], &self.threads);
        if self.batches.count == 0 {
            return;
        }
        let settings = StepSettings {
            dt,
            gravity: self.def.gravity,
            substeps: self.def.substeps,
            iterations: self.def.iterations,
            articulations: self.def.articulations,
            restitution_threshold: self.def.restitution_threshold,
            limits: self.support.as_ref().filter(|support| support.is_awake()).and_then(|_| told_by(self.def.gravity)),
        };
        let substep = dt / self.def.substeps as f32;
        let impulse_scale = self.impulse_scale(substep);
        let records = BatchInput {
            bodies: &self.bodies,
            colliders: &self.colliders,
            index: &self.collision.index,
            pairs: &self.collision.pairs,
            joints: &self.joints,
            bounds: &self.long_range.records,
            long_range: &self.def.long_range,
            chains: &self.long_range.chains,
            swept: &self.long_range.swept,
            span: &self.long_range.derived,
            groups: &self.islands.groups,
            unions: &self.unions,
            tallied: self.def.hit_threshold < f32::INFINITY,
            gravity: self.def.gravity,
            solver: self.def.solver,
            driven: &self.scratch.driven,
            some_are_fast: self.islands.summaries.some_are_fast(),
            reach: self.def.gravity.length() * substep * substep,
            dt,
            impulse_scale,
        };
        let work = |batch: &mut Batch, stages: &mut BatchStages, threads: &Workers| {
            records.fill(batch, &settings.striding(batch.stride), threads);
            stages.contact_energy.find_islands(batch, |index| records.center(index));
            stages.solve(batch, records.joints, threads, &settings.striding(batch.stride));
        };
        let (batches, stages) = (&mut self.batches.list[..self.batches.count], &mut self.batches.stages[..self.batches.count]);
        let all: usize = batches.iter().map(Batch::load).sum();
        let each = SHARED_FROM * all as f32 / self.threads.count() as f32;
        let is_large = |batch: &Batch| batch.load() >= MIN_SHARED && batch.load() as f32 > each;
        let large = batches.iter_mut().zip(&mut *stages).filter(|(batch, _)| is_large(batch));
        large.for_each(|(batch, stages)| work(batch, stages, &self.threads));
        let order = &mut self.scratch.batch_order;
        order.clear();
        order.extend(batches.iter().zip(0..).filter(|(batch, _)| !is_large(batch)).map(|(batch, number)| (batch.size(), number)));
        // The longest first: whoever comes late to the last finds a short one.
        order.sort_unstable_by_key(|&(size, number)| (Reverse(size), number));
        let alone = Workers::default();
        let (batches, stages) = (DisjointSlices::new(batches), DisjointSlices::new(stages));
        self.threads.share_among_all(order.iter(), |&(_, number)| {
            // SAFETY: each batch is once in the order, with its stages.
            let (mut batches, mut stages) = unsafe { (batches.part(), stages.part()) };
            work(batches.get_mut(number), stages.get_mut(number), &alone);
        });
        self.scratch.runs.find(&self.batches.list[..self.batches.count], &self.threads);
    }
}

impl World {
    /// Ratio of a substep of this length (s) to the last one's.
    pub(super) fn impulse_scale(&self, substep: f32) -> f32 {
        if self.last.substep > 0.0 { substep / self.last.substep } else { 1.0 }
    }
}

impl BatchInput<'_> {
    fn fill(&self, batch: &mut Batch, settings: &StepSettings, threads: &Workers) {
        self.list_tallied(batch);
        batch.load_bodies(threads, |index| self.slot_state(index));
        if self.solver == Solver::GaussSeidel {
            self.take_leads_back(batch);
        }
        self.replicate(batch);
        self.note_swung(batch);
        if !batch.joints.slots.is_empty()
            || self.solver != Solver::GaussSeidel && (batch.is_turned_by(BATTED / self.dt) || batch.may_hold_rows())
        {
            self.form_inputs(batch, threads);
        }
        self.list_joints(batch, threads);
        let is_swept = |index: u32| self.swept.get(index as usize).is_some_and(|&swept| swept);
        batch.kick_what_is_pushed(settings, self.solver, |index| self.center(index), is_swept);
        self.lay_out(batch, settings, threads);
        self.list_round_contacts(batch);
        self.fill_bounds(batch);
        self.fill_planes(batch);
        self.find_free_islands(batch);
    }

    /// By how much multipliers that are carried grow to be those of a substep of this batch.
    fn scale_for(&self, batch: &Batch) -> f32 {
        self.impulse_scale * batch.stride
    }

    /// Takes back what bodies were told to be faster than they have moved.
    fn take_leads_back(&self, batch: &mut Batch) {
        let Batch { half_steps, bodies, velocities, .. } = batch;
        let body = |slot: usize| (slot != WORLD_SLOT as usize).then(|| bodies[slot]);
        let united = |slot| body(slot).is_some_and(|body| self.unions.moving(body).is_some());
        half_steps.take_back(velocities, united, |slot| self.bodies[body(slot)?].history.lead());
    }

    /// Slot of a body in a batch: its own, a replica where it is kinematic and moves, or that of the world.
    fn slot(&self, batch: &mut Batch, index: u32) -> u32 {
        self.known_slot(index).unwrap_or_else(|| batch.replica(index, || self.body_state(index)))
    }

    /// The same where it needs no replica.
    fn known_slot(&self, index: u32) -> Option<u32> {
        if self.index.free.has(index) {
            return Some(self.groups.place[index as usize].1);
        }
        let body = &self.bodies[index];
        match body.acts_as() {
            BodyKind::Kinematic if body.is_mover() => None,
            _ => Some(WORLD_SLOT),
        }
    }

    /// From the centre of mass of what is moved as one to that of this body (m).
    fn arm(&self, index: u32) -> Vec3 {
        self.unions.moving(index).map_or(Vec3::ZERO, |union| union.motion.rotation * self.unions.place(index).offset)
    }

    /// Gives replicas to the ends of manifolds that want one.
    fn replicate(&self, batch: &mut Batch) {
        for number in 0..batch.manifolds.ends.len() {
            let ends = batch.manifolds.ends[number];
            if ends.a == REPLICA || ends.b == REPLICA {
                let (a, b) = self.pairs.get(batch.manifolds.list[number].0).key.shapes();
                let [a, b] = [a, b].map(|shape| self.slot(batch, self.index.body_of(shape)));
                let turns = [a, b].iter().any(|&slot| batch.velocities[slot as usize].turns_as_told());
                batch.manifolds.ends[number] = ContactEnds { a, b, is_plain: ends.is_plain && !turns, ..ends };
            }
        }
    }

    /// Brings the manifolds of a batch in which an articulation may hold some into world axes.
    fn form_inputs(&self, batch: &mut Batch, threads: &Workers) {
        let scale = self.scale_for(batch);
        let BatchManifolds { list: manifolds, ends, inputs, .. } = &mut batch.manifolds;
        let form = |number: usize| self.contact_input(&manifolds[number..], ends[number], scale);
        make_room(inputs, manifolds.len());
        if !threads.has_team() {
            return inputs.extend((0..manifolds.len()).map(form));
        }
        inputs.resize(manifolds.len(), ContactInput::default());
        let piece = threads.piece(manifolds.len(), MIN_MANIFOLDS);
        threads.share(inputs.chunks_mut(piece).zip((0..).step_by(piece)), |(inputs, first)| {
            inputs.iter_mut().zip(first..).for_each(|(input, number)| *input = form(number));
        });
    }

    /// The first of these manifolds in world axes: a pair's slot, and which of its manifolds; its multipliers grow by `scale`. The others
    /// come next.
    fn contact_input(&self, coming: &[(u32, u32)], ends: ContactEnds, scale: f32) -> ContactInput {
        self.ask_for_next(coming);
        let (slot, manifold) = coming[0];
        let pair = self.pairs.get(slot);
        let carried = pair.manifolds.get(manifold as usize);
        let (a, b) = pair.key.shapes();
        let (a, b) = (self.index.collider_state(a), self.index.collider_state(b));
        let world = WorldManifold::of(&carried, a.frame(), b.frame());
        let [shift_a, shift_b] = [a.body, b.body].map(|index| self.arm(index));
        ContactInput {
            a: ends.a,
            b: ends.b,
            normal: world.normal,
            lever_a: world.lever_a.map(|lever| lever + shift_a),
            lever_b: world.lever_b.map(|lever| lever + shift_b),
            separation: std::array::from_fn(|i| carried.points.get(i).map_or(0.0, |point| point.separation)),
            touching: TOUCHING_SHARE * a.least_extent.min(b.least_extent),
            count: ends.points as usize,
            material: PairMaterial::combine(&a.material, &b.material),
            impulses: carried.impulses.scaled(scale),
        }
    }

    fn ask_for_next(&self, coming: &[(u32, u32)]) {
        if let Some(&(slot, _)) = coming.get(2 * AHEAD) {
            prefetch(self.pairs.get(slot));
        }
        if let Some(&(slot, _)) = coming.get(AHEAD) {
            let pair = self.pairs.get(slot);
            pair.manifolds.prefetch();
            <[u32; 2]>::from(pair.key.shapes()).into_iter().for_each(|shape| prefetch(self.index.collider_state(shape)));
        }
    }

    fn fill_bounds(&self, batch: &mut Batch) {
        // Bounds are for what is swept: a direct solve needs none.
        if batch.long_range.slots.is_empty() || batch.joints.entries.is_empty() {
            return;
        }
        self.list_joint_ends(batch);
        batch.mark_swept();
        let (pace, scale) = (Pace::of(batch), self.scale_for(batch));
        self.find_touches(batch);
        for number in 0..batch.long_range.slots.len() {
            let slot = batch.long_range.slots[number];
            let record = &self.bounds[slot as usize];
            let [near, far] = record.ends.map(|(joint, side)| self.joint_end(batch, joint, side as usize));
            if !batch.long_range.swept[far.slot as usize] || near.slot == far.slot {
                continue;
            }
            if self.wrap(batch, slot, [&near, &far]) {
                continue;
            }
            if self.is_too_slack(batch, &pace, record, [&near, &far]) {
                batch.long_range.bounds.skipped += 1;
                continue;
            }
            let [upper_give, lower_give] = World::bound_give(self.long_range, record);
            let number = batch.long_range.bounds.entries.len() as u32;
            for inner in record.bound.inner.0..record.bound.inner.1 {
                let at = &self.span.inner[inner as usize];
                let own = self.joint_end(batch, at.end.link, at.end.side as usize);
                batch.long_range.taut.entries.push(TautEntry {
                    inner,
                    bound: number,
                    slot: own.slot,
                    offset: (own.origin - near.origin).as_vec3(),
                    local_lever: own.lever,
                    before: at.before,
                    after: at.after,
                    own_sum: Vec3::ZERO,
                    far_sum: Vec3::ZERO,
                });
            }
            batch.long_range.bounds.entries.push(BoundEntry {
                bound: slot,
                near: near.slot,
                far: far.slot,
                offset: (far.origin - near.origin).as_vec3(),
                local_lever: [near.lever, far.lever],
                upper: record.bound.upper,
                lower: record.bound.lower,
                upper_give,
                lower_give,
                impulses: record.impulses.map(|impulse| impulse * scale),
                far_sum: Vec3::ZERO,
                acted: false,
            });
        }
    }

    /// Whether a bound cannot close within the step: no body of the batch becomes faster than the fastest is, or than gravity and
    /// forces make it, by more than [`OUTPACED`].
    fn is_too_slack(&self, batch: &Batch, pace: &Pace, record: &BoundRecord, ends: [&JointEnd; 2]) -> bool {
        let BoundRecord { bound, impulses, .. } = record;
        if *impulses != [0.0; 2] {
            return false;
        }
        let [near, far] = ends.map(|end| end.origin + (batch.motions[end.slot as usize].rotation * end.lever).as_dvec3());
        let distance = (far - near).length() as f32;
        let levers = ends[0].lever.length() + ends[1].lever.length();
        let dt = self.dt;
        let way = OUTPACED * dt * (2.0 * (pace.speed + pace.acceleration * dt) + pace.spin * levers);
        let lower_is_far = bound.lower <= 0.0 || distance - way > bound.lower;
        lower_is_far && distance + way < bound.upper
    }

    fn find_free_islands(&self, batch: &mut Batch) {
        let Batch { islands, body_flags, motions, manifolds, joints, free, bodies, .. } = batch;
        let BatchManifolds { list: manifolds, ends, .. } = &*manifolds;
        let contacts = ends.iter().enumerate().map(|(number, ends)| ([ends.a, ends.b], Some(number)));
        let links = contacts.chain(joints.links.iter().map(|link| ([link.a, link.b], None)));
        let rubs = |number: usize| {
            let (a, b) = self.pairs.get(manifolds[number].0).key.shapes();
            PairMaterial::combine(&self.index.collider_state(a).material, &self.index.collider_state(b).material).may_turn()
        };
        free.find(islands, body_flags, motions, links, rubs, |slot| self.center(bodies[slot as usize]));
    }

    /// Centre of mass of what is moved as one with this body (m).
    fn center(&self, index: u32) -> DVec3 {
        self.unions.moving(index).map_or(self.bodies[index].center, |union| union.motion.center)
    }

    /// One side of a joint in the slot `joint`.
    fn joint_end(&self, batch: &mut Batch, joint: u32, side: usize) -> JointEnd {
        let place = self.groups.joint_places[joint as usize] as usize;
        if batch.joints.slots.get(place) == Some(&joint)
            && let Some(ends) = batch.joints.ends.get(place)
        {
            return ends[side];
        }
        self.find_joint_end(batch, &self.joints[joint], side)
    }
}

/// Greatest speed (m/s), spin (rad/s) and acceleration (m/s²) in a batch.
struct Pace {
    speed: f32,
    spin: f32,
    acceleration: f32,
}

impl Pace {
    fn of(batch: &Batch) -> Self {
        let speeds = batch.velocities.iter();
        let [speed, spin] =
            speeds.fold([0.0_f32; 2], |[v, w], body| [v.max(body.linear.length_squared()), w.max(body.angular.length_squared())]);
        let acceleration = batch.motions.iter().map(|motion| motion.acceleration.length_squared()).fold(0.0, f32::max);
        Self { speed: speed.sqrt(), spin: spin.sqrt(), acceleration: acceleration.sqrt() }
    }
}
