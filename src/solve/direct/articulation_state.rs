//! What a step of an articulation changes besides its bodies, and how it went.

use glam::Vec3;

use super::contacts::ArticulationContact;
use super::servo_loops::ServoTrial;
use crate::joint_rebounds::Rebounds;
use crate::joint_record::JointImpulses;
use crate::solve::joint::LocalPose;
use crate::solve::joint::body_response::BodyResponse;
use crate::solve::joint::rows::Rate;

/// How a substep treats the path of its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Mode {
    /// Rows hold at the end of the substep, whose start is extrapolated from the one before.
    SecondOrder,
    /// Rows hold at the end of the substep.
    #[default]
    Smooth,
    /// Rows hold to first order at the start: kinetic energy cannot grow.
    Safe,
}

/// Whether rows last for a substep, and what for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum ReusedFactor {
    /// They must be built.
    #[default]
    No,
    /// They must be in every substep of the step: it has been taken once and given up, as the articulation would have met something.
    Never,
    /// They have been built in this step.
    Built,
    /// They are still good for the next substep.
    Good,
}

/// What a servo moves.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there are as few of them as servos, and most have parts")]
pub(super) enum ServoLoad {
    /// The bodies of its joint, as far as is known.
    Own,
    /// The two parts that its joint connects, as they answer.
    Parts([BodyResponse; 2]),
    /// All bodies of the loops that its joint closes.
    Loop,
}

/// What each servo moves, and room to find it.
#[derive(Debug, Default)]
pub(super) struct ServoParts {
    /// By joint; empty where no joint has a servo.
    pub loads: Vec<ServoLoad>,
    pub reached: Vec<bool>,
    pub trial: ServoTrial,
}

/// How a step of an articulation went.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StepOutcome {
    /// Substeps taken: to second order, smooth ones of first order, safe ones, and those undone and taken as two halves.
    pub second_order: u32,
    pub first_order: u32,
    pub safe: u32,
    pub halvings: u32,
    /// Whether the active set of a substep with contacts did not come to an end by itself.
    pub unsettled: bool,
    /// Worst gap (m) and angle (rad) left.
    pub gap: f64,
    pub angle: f64,
    /// Change of energy that forces do not explain (J).
    pub energy_change: f64,
    /// Worst overlap with what it does not move (m).
    pub penetration: f64,
}

/// State at the start of a substep, which can be undone until the next one begins.
#[derive(Debug, Clone, Default)]
pub(super) struct Began {
    pub rates: Vec<Rate>,
    pub local_poses: Vec<LocalPose>,
    pub(super) left: f64,
    pub(super) joints: Vec<SavedJoint>,
    pub(super) touches: Vec<ArticulationContact>,
}

/// What a substep changes of a joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct SavedJoint {
    pub(super) impulses: JointImpulses,
    pub(super) angles: [f64; 3],
    pub(super) sums: [Vec3; 2],
    pub(super) acted: [Vec3; 2],
    pub(super) rebounds: Rebounds,
    pub(super) pressed: u32,
    pub(super) motors: [f32; 6],
    /// Rows that pressed then, as bits: what is guessed of impulses says nothing of that.
    pub(super) pressing: u32,
}
