//! Writes poses and velocities of bodies back, on all threads where there are many: each body has one slot.

use std::ops::Range;

use glam::Vec3;

use crate::body::{Body, SleepState, within_limit};
use crate::collide::collider::Collider;
use crate::collide::round_features::carried_by;
use crate::collide::sweep::BodyPose;
use crate::dwell_time::DwellTime;
use crate::id::{BodyId, Pool, ShapeId, Slot};
use crate::joint_graph::union::UnionMotion;
use crate::prefetch::{AHEAD, prefetch};
use crate::settings::SleepSettings;
use crate::solve::batch::Batch;
use crate::solve::disjoint::{DisjointPart, DisjointSlices, Slots};
use crate::solve::state::{Constraints, WORLD_SLOT};
use crate::solve::step::BatchStages;
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};
use crate::step_history::History;
use crate::world::body_shape_table::BodyShapeTable;
use crate::world::drift::is_slow;
use crate::world::fast::{Path, Start, Swept};
use crate::world::substep_multiplier::Smoothness;
use crate::world::unions::{Anchor, Unions};
use crate::world::{Batches, Collision, LastStep, World};

/// How far the square of a rotation's length may be from one before its body counts as broken; NaN is farther.
const ROTATION_TOLERANCE: f32 = 1.0e-3;

/// Slots of a batch from which on all threads write its bodies back, and those that are worth another thread's while: some 5 µs.
pub(super) const SHARED_SLOTS: usize = 512;
pub(super) const MIN_SLOTS: usize = 128;

/// What is noted of bodies as they are written back, for each piece of a batch.
#[derive(Debug, Default)]
pub(in crate::world) struct BodyNotes {
    /// Bodies whose motion is no number.
    broken: Vec<u32>,
    /// Bodies that may have to be stopped on their paths, and where those were that are not flagged fast.
    paths: Vec<Path>,
    starts: Vec<(u32, BodyPose)>,
    /// Motions of unions, by a member.
    unions: Vec<(u32, UnionMotion)>,
    has_smooth_bodies: bool,
}

/// What the bodies of any batch are written back by.
#[derive(Clone, Copy)]
struct Limits {
    /// Of bodies without joints and with joints.
    calm_speeds: [f32; 2],
    smoothness: Smoothness,
    /// When bodies are quiet, where they may sleep or be held, and the length of the step (s).
    sleep: Option<SleepSettings>,
    dt: f32,
    has_joints: bool,
    some_are_fast: bool,
}

/// What the bodies of a batch are written back from.
struct Moves<'a> {
    limits: Limits,
    number: usize,
    batch: &'a Batch,
    stages: &'a BatchStages,
    unions: &'a Unions,
    may_stride: bool,
}

/// Records of which each thread writes those of other bodies.
struct SharedRecords<'a> {
    bodies: DisjointSlices<'a, Slot<Body>>,
    colliders: DisjointSlices<'a, Slot<Collider>>,
    forces: DisjointSlices<'a, Vec3>,
}

impl<'a> SharedRecords<'a> {
    fn new(
        bodies: &'a mut Pool<Body, BodyId>,
        colliders: &'a mut Pool<Collider, ShapeId>,
        index: &'a mut BodyShapeTable,
    ) -> Self {
        let forces = DisjointSlices::new(index.forces_for(bodies.slot_count()));
        Self { bodies: DisjointSlices::new(bodies.slots_mut()), colliders: DisjointSlices::new(colliders.slots_mut()), forces }
    }

    /// Those of some bodies, for one thread.
    ///
    /// # Safety
    /// While they live no other part is used for a body that these are used for, or for a shape of one.
    unsafe fn part(&self) -> BodyRecords<'_> {
        // SAFETY: each body has its own record and force, and each shape is on one body.
        let (bodies, colliders, forces) = unsafe { (self.bodies.part(), self.colliders.part(), self.forces.part()) };
        BodyRecords { bodies, colliders, forces }
    }
}

/// Records that a thread writes, each body's by one of them.
struct BodyRecords<'a> {
    bodies: DisjointPart<'a, Slot<Body>>,
    colliders: DisjointPart<'a, Slot<Collider>>,
    /// Net force of contacts, by body.
    forces: DisjointPart<'a, Vec3>,
}

impl BodyRecords<'_> {
    fn body(&mut self, index: u32) -> Option<&mut Body> {
        self.bodies.get_mut(index).value.as_mut()
    }

    /// Asks for the memory of the bodies that come next, and of their first shapes.
    #[inline(always)]
    fn ask_for_next(&self, coming: &[u32]) {
        if let Some(&index) = coming.get(2 * AHEAD) {
            prefetch(self.bodies.get(index));
        }
        if let Some(&id) = coming.get(AHEAD).and_then(|&index| self.bodies.get(index).value.as_ref()?.shapes.first()) {
            prefetch(self.colliders.get(Pool::<Collider, ShapeId>::place_of(id)));
        }
    }

    /// Has the shapes of a body follow it; how far they reach from its centre, and their least extent (m).
    fn shapes_follow(&mut self, index: u32) -> (f32, f32) {
        let Self { bodies, colliders, .. } = self;
        let (mut reach, mut least_extent) = (0.0_f32, f32::INFINITY);
        let Some(body) = &bodies.get(index).value else { return (reach, least_extent) };
        for &id in &body.shapes {
            if let Some(collider) = &mut colliders.get_mut(Pool::<Collider, ShapeId>::place_of(id)).value {
                collider.follow(body);
                reach = reach.max(collider.reach);
                least_extent = least_extent.min(collider.least_extent);
            }
        }
        (reach, least_extent)
    }

    /// How far a turn (rad) takes what the shapes of a body are made of, at most (m).
    fn carried_by(&self, index: u32, turn: Vec3) -> f32 {
        let Some(body) = &self.bodies.get(index).value else { return 0.0 };
        let shapes =
            body.shapes.iter().filter_map(|&id| self.colliders.get(Pool::<Collider, ShapeId>::place_of(id)).value.as_ref());
        let ways = shapes.map(|collider| {
            let place = (collider.offset_on(body), collider.place.1);
            carried_by(&collider.shape, place, turn).unwrap_or(turn.length() * collider.reach)
        });
        ways.fold(0.0, f32::max)
    }
}

impl World {
    fn write_limits(&self, dt: f32) -> Limits {
        Limits {
            calm_speeds: self.calm_speeds(dt),
            smoothness: self.smoothness(dt),
            sleep: Some(self.def.sleep).filter(|sleep| sleep.enabled || self.def.hold),
            dt,
            has_joints: self.joints.len() > 0,
            some_are_fast: self.islands.summaries.some_are_fast(),
        }
    }

    /// Writes back the bodies of runs of small batches.
    pub(super) fn store_bodies_of_runs(&mut self, dt: f32) {
        let limits = self.write_limits(dt);
        let Self {
            batches: Batches { list: batches, stages, .. },
            bodies,
            colliders,
            unions,
            collision: Collision { index, .. },
            scratch,
            threads,
            ..
        } = self;
        let (records, unions) = (SharedRecords::new(bodies, colliders, index), &*unions);
        scratch.runs.each(threads, |run, notes| {
            for number in run {
                let moves = Moves::new(limits, number, (&batches[number], &stages[number]), unions);
                // SAFETY: each body is in one batch.
                let mut records = unsafe { records.part() };
                moves.write_some(1..moves.batch.bodies.len(), &mut records, &mut notes.bodies);
            }
        });
    }

    pub(super) fn store_bodies(&mut self, number: usize, dt: f32) {
        let limits = self.write_limits(dt);
        let Self {
            batches: Batches { list: batches, stages, .. },
            bodies,
            colliders,
            unions,
            collision: Collision { index, .. },
            scratch,
            last: LastStep { has_smooth_bodies, broken, .. },
            threads,
            ..
        } = self;
        let batch = &batches[number];
        let mut tell = |noted: &mut BodyNotes, unions: &mut Unions| {
            broken.append(&mut noted.broken);
            scratch.sweeps.paths.append(&mut noted.paths);
            scratch.sweeps.starts.append(&mut noted.starts);
            *has_smooth_bodies |= std::mem::take(&mut noted.has_smooth_bodies);
            for (member, motion) in noted.unions.drain(..) {
                if let Some(union) = unions.of_mut(member).filter(|union| union.anchor == Anchor::Free) {
                    union.motion = motion;
                }
            }
        };
        if scratch.runs.has(number) {
            if let Some(notes) = scratch.runs.notes_from(number) {
                tell(&mut notes.bodies, unions);
            }
            return store_histories(batch, bodies, dt);
        }
        let slots = batch.bodies.len();
        let is_shared = slots >= SHARED_SLOTS && threads.has_team();
        let piece = if is_shared { threads.piece(slots, MIN_SLOTS) } else { slots };
        let pieces = slots.div_ceil(piece);
        let noted = &mut scratch.noted;
        noted.resize_with(pieces.max(noted.len()), BodyNotes::default);
        let records = SharedRecords::new(bodies, colliders, index);
        let moves = Moves::new(limits, number, (batch, &stages[number]), unions);
        let write = |slots: Range<usize>, noted: &mut BodyNotes| {
            // SAFETY: each body has one slot, which is in one piece.
            let mut records = unsafe { records.part() };
            moves.write_some(slots, &mut records, noted);
        };
        if is_shared {
            let ranges = (0..slots).step_by(piece).map(|first| first.max(1)..slots.min(first + piece));
            threads.share(ranges.zip(&mut *noted), |(slots, noted)| write(slots, noted));
        } else {
            write(1..slots, &mut noted[0]);
        }
        noted[..pieces].iter_mut().for_each(|noted| tell(noted, unions));
        store_histories(batch, bodies, dt);
    }
}

impl<'a> Moves<'a> {
    fn new(limits: Limits, number: usize, (batch, stages): (&'a Batch, &'a BatchStages), unions: &'a Unions) -> Self {
        let may_stride = batch.direct.sweeps_blocks() || stages.joint_mesh.is_one() || !batch.newton.is_idle();
        Self { limits, number, batch, stages, unions, may_stride }
    }

    /// Writes back what has some slots.
    fn write_some(&self, slots: Range<usize>, records: &mut BodyRecords<'_>, noted: &mut BodyNotes) {
        for slot in slots.clone() {
            // Not of bodies that another thread has.
            records.ask_for_next(&self.batch.bodies[slot..slots.end]);
            self.write(slot, records, noted);
        }
    }
}

impl Moves<'_> {
    /// Writes back what has this slot: a body, or the members of a union.
    fn write(&self, slot: usize, records: &mut BodyRecords<'_>, noted: &mut BodyNotes) {
        let &Self { limits, number, batch, stages, unions, may_stride } = self;
        let Limits { calm_speeds, has_joints, some_are_fast, .. } = limits;
        let index = batch.bodies[slot];
        let Some(lead) = records.body(index).filter(|body| body.is_free()) else { return };
        let (velocity, motion) = (&batch.velocities[slot], &batch.motions[slot]);
        let union = unions.moving(index);
        let members = union.map_or(std::slice::from_ref(&index), |union| &union.members);
        let (from, before) =
            union.map_or((lead.center, lead.linear_velocity), |union| (union.motion.center, union.motion.linear));
        let slid = stages.slides.way(slot, velocity.linear - before);
        let to = UnionMotion {
            center: from + (motion.displacement + slid).as_dvec3(),
            rotation: motion.rotation,
            linear: velocity.linear,
            angular: velocity.angular,
        };
        let mut is_fast = false;
        for &member in members {
            if let Some(body) = records.body(member) {
                (body.force, body.torque) = (Vec3::ZERO, Vec3::ZERO);
                is_fast |= body.settings.fast;
            }
            *records.forces.get_mut(member) = Vec3::ZERO;
        }
        let finite = motion.displacement.is_finite()
            && (motion.rotation.length_squared() - 1.0).abs() < ROTATION_TOLERANCE
            && velocity.linear.is_finite()
            && velocity.angular.is_finite()
            && to.center.abs().max_element() <= crate::check::MAX_COORDINATE;
        if !finite {
            noted.broken.extend_from_slice(members);
            return;
        }
        // What is jointed to a fast body stops with it.
        let is_swept = is_fast || (some_are_fast && batch.direct.is_jointed(slot as u32));
        let steady = stages.momentum_pass.is_slow(slot);
        for &member in members {
            let Some(body) = records.body(member) else { continue };
            let group = (number as u32, batch.direct.group_of(slot as u32));
            if is_swept {
                let swept = if body.settings.fast { Swept::All } else { Swept::Along };
                noted.paths.push(Path { group, body: member, swept });
            }
            let may_stray = motion.constraints != Constraints::None && !is_swept && union.is_none() && body.joints.is_empty();
            let start = may_stray.then(|| Start::of(body));
            let own = match union {
                Some(_) => unions.motion_of(member, &to),
                None => to,
            };
            // Of what has no joints always: what is solved beside it makes no difference.
            let may_be_smooth = if body.joints.is_empty() { has_joints } else { may_stride };
            let before = may_be_smooth.then_some([body.linear_velocity, body.angular_velocity]);
            self.note_drift(body, &own);
            (body.center, body.rotation) = (own.center, own.rotation);
            body.linear_velocity = within_limit(own.linear, MAX_LINEAR_SPEED);
            body.angular_velocity = within_limit(own.angular, MAX_ANGULAR_SPEED);
            body.history.forget();
            // What is solved as one with what it leans on stays where it was put.
            if !steady || !motion.direct || motion.jointed {
                body.times.settling.count(steady, limits.dt);
            }
            let (reach, least_extent) = records.shapes_follow(member);
            let carried_by = |turn: Vec3| records.carried_by(member, turn);
            if let Some(start) = start.filter(|start| start.goes_astray(motion, limits.dt, (reach, least_extent), carried_by)) {
                noted.paths.push(Path { group, body: member, swept: Swept::FixedOnly });
                noted.starts.push((member, start.pose));
            }
            let Some(body) = records.body(member) else { continue };
            let is_calm = own.linear.length() + own.angular.length() * reach < calm_speeds[usize::from(!body.joints.is_empty())];
            body.times.calm_for.count(is_calm, limits.dt);
            match before {
                Some(before) => noted.has_smooth_bodies |= limits.smoothness.count(body, before, reach, limits.dt) && may_stride,
                None => body.times.smooth_for = DwellTime::NONE,
            }
        }
        if union.is_some() {
            noted.unions.push((index, to));
        }
    }
}

impl Moves<'_> {
    /// Has the drift of a quiet body follow its pose.
    fn note_drift(&self, body: &mut Body, own: &UnionMotion) {
        if !self.limits.sleep.is_some_and(|limits| is_slow(&limits, own.linear, own.angular)) {
            return;
        }
        if let SleepState::Awake { quiet_for, drift } = &mut body.sleep {
            let poses = ((body.center, body.rotation), (own.center, own.rotation));
            drift.follow(poses, self.limits.dt, *quiet_for == 0.0);
        }
    }
}

/// Has bodies remember what a solver needs of them in the next step.
fn store_histories(batch: &Batch, bodies: &mut Pool<Body, BodyId>, dt: f32) {
    for (slot, lead) in batch.half_steps.told.iter().enumerate().filter_map(|(slot, lead)| Some((slot, (*lead)?))) {
        bodies[batch.bodies[slot]].history.set(History::leading(lead));
    }
    for (slot, history) in batch.direct.histories() {
        bodies[batch.bodies[slot as usize]].history.set(*history);
    }
    if batch.direct.sweeps_blocks() || !batch.newton.is_idle() {
        let swept_alone = batch.joints.entries.iter().flat_map(|entry| [entry.a, entry.b]);
        let moved_alone = batch.direct.slots_moved_alone();
        for slot in moved_alone.chain(swept_alone).filter(|&slot| slot != WORLD_SLOT) {
            bodies[batch.bodies[slot as usize]].times.smooth_for = DwellTime::NONE;
        }
    }
    for (slot, time) in batch.direct.swept_for(dt) {
        bodies[batch.bodies[slot as usize]].history.set_swept_for(time);
    }
}
