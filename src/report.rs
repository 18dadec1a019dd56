//! Report of a step: counts, residuals, timings, events.

use glam::{DVec3, Vec3};

use crate::fracture::{JointBreak, Piece, Split};
use crate::id::{BodyId, JointId, ShapeId};
use crate::pose::Pose;

/// Summary of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// Number of the step, from 1.
    pub step: u64,
    /// Simulated time at its end (s).
    pub time: f64,
    /// How much there was to do.
    pub counts: StepCounts,
    /// How well it was done.
    pub residuals: Residuals,
    /// How long it took.
    pub timings: StepTimings,
}

/// Sizes of a step's work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StepCounts {
    /// Dynamic bodies awake during the step.
    pub bodies_awake: u32,
    /// Dynamic bodies asleep.
    pub bodies_asleep: u32,
    /// Islands solved.
    pub islands: u32,
    /// Pairs of shapes near each other with a body that can move.
    pub pairs: u32,
    /// Pairs whose contacts were made anew.
    pub pairs_updated: u32,
    /// Pairs that kept their contacts.
    pub pairs_reused: u32,
    /// Contact manifolds solved.
    pub manifolds: u32,
    /// Contact points solved.
    pub contact_points: u32,
    /// Joints solved.
    pub joints: u32,
    /// Joints that broke.
    pub joints_broken: u32,
    /// Joints past a limit that break in the steps to come.
    pub joints_condemned: u32,
    /// Times that the step was solved, more than once where joints broke or a motor drove a body into something that was out of its reach.
    pub solves: u32,
    /// Long-range bounds derived in this step; 0 where no graph of joints has changed.
    pub bounds_derived: u32,
    /// Long-range bounds of bodies awake.
    pub bounds: u32,
    /// Of those, how many were taut or nearly so.
    pub bounds_active: u32,
    /// Of those, how many were so slack that the step did not look at them again.
    pub bounds_skipped: u32,
    /// Of those, how many were wrapped around what their chain lies on.
    pub bounds_wrapped: u32,
    /// Batches of islands solved independently.
    pub batches: u32,
    /// Greatest number of contact colours in a batch.
    pub colors: u32,
    /// Bodies whose pose changed.
    pub moved: u32,
    /// Dynamic bodies awake that were held where they are, not solved.
    pub bodies_held: u32,
    /// Hinge chains awake.
    pub planes: u32,
    /// Of those, how often one was put back into its plane, over all substeps.
    pub planes_corrected: u32,
    /// Unions awake and free, each solved as one body.
    pub unions: u32,
    /// Bodies that moved as members of those.
    pub union_members: u32,
}

/// Errors left at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residuals {
    /// Worst distance between joint points beyond what the joint allows (m), of bodies asleep too.
    pub joint_gap: f32,
    /// Worst overlap of two shapes before it was recovered (m).
    pub penetration: f32,
    /// Worst angle by which a joint or a stop of an articulation is off (rad).
    pub joint_angle: f32,
}

/// How an articulation was solved in the last step: bodies that joints connect, solved at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArticulationReport {
    /// One of its bodies.
    pub body: BodyId,
    /// Bodies that it moves.
    pub bodies: u32,
    /// Joints.
    pub joints: u32,
    /// Whether it touched what moves, or its contacts did not settle in one system with its joints, so that these were swept with the
    /// contacts.
    pub swept: bool,
    /// Substeps of second order, smooth ones of first order, and safe ones, in which kinetic energy cannot grow.
    pub second_order: u32,
    /// Smooth substeps of first order.
    pub first_order: u32,
    /// Substeps in which kinetic energy cannot grow: safe ones, and all of those in which it was swept.
    pub safe: u32,
    /// Substeps that were undone and taken as two halves.
    pub halvings: u32,
    /// Worst distance between joint points beyond what the joint allows (m).
    pub gap: f32,
    /// Worst angle by which a joint or a stop is off (rad).
    pub angle: f32,
    /// Worst overlap with what it does not move (m).
    pub penetration: f32,
    /// Change of kinetic energy that the work of gravity and applied forces does not explain (J): what stepping adds or takes, and
    /// what motors, damping, friction, impacts and moved anchors do. Zero where it was swept.
    pub energy_change: f32,
    /// Numbers in its factor.
    pub factor_size: u32,
}

/// How an island is solved in a step, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(i32)]
pub enum IslandPlan {
    /// Joints meet contacts, or close a loop and bear more than a substep resolves, or bodies without joints lean on one another in a row, as
    /// stones of an arch, or at rest with few contacts, as cards of a house, or stand on each other on what moves or bear their load aside: all of
    /// it is one problem.
    Coupled,
    /// No joint is in it: contacts are swept.
    #[default]
    Loose,
    /// Nothing that joints hold touches anything but a few free bodies on points of which there are many: articulations take the step by
    /// themselves, with what they carry.
    Apart,
    /// The host asks for sweeps.
    Swept,
    /// Joints have stops on angles, as limbs do, no motor holds a place, and they form a tree that nothing fixed holds: sweeps and direct solves
    /// carry its loads for less.
    Jointed,
    /// Joints do more than hold points together, no motor holds a place, and masses are alike, in a tree that nothing fixed holds or a loop that
    /// does not stand: sweeps and direct solves carry loads between such bodies as well, for less.
    Alike,
    /// Articulations touch one another that nothing fixed holds, or with more contacts than joints: a heap. Not while what stands with loops, as a
    /// vehicle on tracks, is still.
    Heaped = 7,
    /// A factor of it takes more work than the world's budget allows: see `ArticulationSettings::halving_budget`.
    Large,
}

/// How an island was solved in the last step: bodies that joints and contacts connect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IslandReport {
    /// One of its bodies.
    pub body: BodyId,
    /// Bodies that it moves.
    pub bodies: u32,
    /// Joints.
    pub joints: u32,
    /// How it was to be solved, and why.
    pub plan: IslandPlan,
    /// Whether the coupled solve did not reach a result that it could vouch for, so that sweeps and direct solves took the step.
    pub given_up: bool,
}

/// Wall time of each stage (s).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepTimings {
    /// Finding pairs.
    pub broad_phase: f32,
    /// Making contacts.
    pub narrow_phase: f32,
    /// Waking and grouping islands.
    pub islands: f32,
    /// Deriving long-range constraints where joints have changed, and handing them out.
    pub long_range: f32,
    /// Preparing rows and solving them.
    pub solve: f32,
    /// Writing back, sweeping fast bodies, sleep, events.
    pub finish: f32,
    /// The whole step.
    pub total: f32,
}

/// A body whose pose changed in the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// The body.
    pub body: BodyId,
    /// The host's word on it.
    pub user_word: u64,
    /// Its frame now.
    pub pose: Pose,
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: Vec3,
    /// Angular velocity (rad/s).
    pub angular_velocity: Vec3,
    /// Whether it fell asleep at the end of the step.
    pub fell_asleep: bool,
    /// Whether it woke in the step, or since the one before it.
    pub woke: bool,
}

/// Two shapes in contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ContactPair {
    /// One shape.
    pub shape_a: ShapeId,
    /// The other.
    pub shape_b: ShapeId,
    /// Body of `shape_a`.
    pub body_a: BodyId,
    /// Body of `shape_b`.
    pub body_b: BodyId,
}

/// A contact whose shapes met fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The shapes and bodies.
    pub pair: ContactPair,
    /// Where they touch now, the middle of the pressed points (m).
    pub point: DVec3,
    /// Unit vector from A to B.
    pub normal: Vec3,
    /// Greatest speed at which points approached each other at the start of a step (m/s).
    pub approach_speed: f32,
    /// Impulse along the normal over the steps of the hit, one or two, rebound included (N·s).
    pub impulse: f32,
}

/// A joint that has come to one of its stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JointStop {
    /// The joint.
    pub joint: JointId,
    /// The host's word on it.
    pub user_word: u64,
    /// Which coordinate: 0 for the only one of a hinge, prismatic or distance joint and for the twist of a spherical one, 1 for
    /// its swing; 0 to 2 for the translations and 3 to 5 for the rotations of a generic joint.
    pub axis: u8,
    /// Whether it is the upper stop.
    pub upper: bool,
}

/// A joint whose load passed its limit in the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointOverload {
    /// The joint.
    pub joint: JointId,
    /// The host's word on it.
    pub user_word: u64,
    /// Its force (N).
    pub force: f32,
    /// Its torque (N·m).
    pub torque: f32,
}

/// One manifold between two shapes, as the last step left it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The shapes and bodies.
    pub pair: ContactPair,
    /// Unit vector from A to B.
    pub normal: Vec3,
    /// Friction on B, mean over the last substep (N).
    pub friction_force: Vec3,
    points: [ContactPoint; 4],
    count: u8,
}

impl Contact {
    pub(crate) fn new(pair: ContactPair, normal: Vec3, friction_force: Vec3) -> Self {
        Self { pair, normal, friction_force, points: [ContactPoint::default(); 4], count: 0 }
    }

    pub(crate) fn push(&mut self, point: ContactPoint) {
        self.points[self.count as usize] = point;
        self.count += 1;
    }

    /// Force along the normal of all its points (N), ≥ 0.
    pub fn normal_force(&self) -> f32 {
        self.points().iter().map(|point| point.normal_force).sum()
    }

    /// Its whole force on B, along the normal and of friction (N).
    pub fn force(&self) -> Vec3 {
        self.normal * self.normal_force() + self.friction_force
    }

    /// Its points, one to four.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points[..self.count as usize]
    }
}

/// A point of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactPoint {
    /// Halfway between the two surfaces (m).
    pub position: DVec3,
    /// Distance of the surfaces along the normal, negative when they overlap (m).
    pub separation: f32,
    /// Force along the normal in the last substep (N), ≥ 0.
    pub normal_force: f32,
}

/// Everything that happened in the last step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Events {
    pub moved: Vec<Moved>,
    pub contact_began: Vec<ContactPair>,
    pub contact_ended: Vec<ContactPair>,
    pub overloaded: Vec<JointOverload>,
    pub hits: Vec<Hit>,
    pub joint_stops: Vec<JointStop>,
    /// Of each pair, the sensor first.
    pub sensor_began: Vec<ContactPair>,
    pub sensor_ended: Vec<ContactPair>,
    pub quarantined: Vec<BodyId>,
    pub articulations: Vec<ArticulationReport>,
    pub islands: Vec<IslandReport>,
    pub broken: Vec<JointBreak>,
    pub splits: Vec<Split>,
    pub pieces: Vec<Piece>,
    pub piece_bodies: Vec<BodyId>,
    /// Contacts that edits ended since the last step: the next step lists them, for a host that reads after each step.
    pub ended_by_edits: Vec<ContactPair>,
}

impl Events {
    /// Starts the lists of a step: empty but for what edits ended before it, and for what moved, which is written over.
    pub(crate) fn begin_step(&mut self) {
        self.contact_began.clear();
        self.contact_ended.clear();
        self.overloaded.clear();
        self.hits.clear();
        self.joint_stops.clear();
        self.sensor_began.clear();
        self.sensor_ended.clear();
        self.quarantined.clear();
        self.articulations.clear();
        self.islands.clear();
        self.broken.clear();
        self.splits.clear();
        self.pieces.clear();
        self.piece_bodies.clear();
        self.take_edits();
    }

    /// Hands endings by edits over to the step that is under way.
    pub(crate) fn take_edits(&mut self) {
        self.contact_ended.append(&mut self.ended_by_edits);
    }
}
