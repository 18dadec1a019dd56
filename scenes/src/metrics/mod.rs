//! What judges a run: errors computed from poses and velocities alone, by the same code for every engine.

mod breakage;
mod driven;
mod energy;
mod held;
mod hinge;
mod joints;
mod motion;
mod overlap;
mod plane;
mod reading;
mod rigid;
mod settling;
mod solid;
mod trajectory;
mod verdicts;

pub use breakage::{Breakage, FirstBreak};
pub use driven::DrivenEnergy;
pub use energy::{AngularMomentumError, EnergyError, EnergyGrowth, EnergyRise, LinearMomentumError, energy_of};
pub use held::Held;
pub use hinge::{HingeError, HingeOvershoot, SwingOvershoot, hinge_angle};
pub use joints::{JointGap, LoadError, Stretch, gap_of};
pub use motion::{Awake, Displaced, EndSpeeds, Escaped, LockedDrift, Moved, NotFinite, PeakSpeed, PoseSpeed, Stood};
pub use overlap::Overlap;
pub use plane::{HingePlane, PlaneMember, smallest_axis};
pub use reading::Reading;
pub use rigid::RigidDeviation;
pub use settling::Settling;
pub use solid::{Solid, overlap_depth};
pub use trajectory::{MotionError, TrajectoryError};
pub use verdicts::Verdicts;

use longspan::glam::{DMat3, DVec3, Vec3};
use longspan::{BodyDef, BodyKind, Mass, MassProperties, Pose};

use crate::engine::{Engine, SceneJoint};

/// Errors of a run by name, in the order in which the metrics gave them.
pub type Errors = Vec<(&'static str, f64)>;

/// Watches a run and reports at its end.
pub trait Metric {
    /// Called once before the first step and once after each.
    fn observe(&mut self, view: &View);
    /// What was found.
    fn report(&self, errors: &mut Errors);
}

/// A running scene as a metric sees it.
pub struct View<'a> {
    /// Steps done.
    pub step: u32,
    /// Steps of the whole run.
    pub steps: u32,
    /// Simulated time (s).
    pub time: f64,
    /// Gravity at present (m/s²).
    pub gravity: Vec3,
    /// The engine.
    pub engine: &'a dyn Engine,
    /// Every body that was ever created, as it was defined.
    pub bodies: &'a [BodyDef],
    /// Which of them still exist.
    pub alive: &'a [bool],
    /// Every joint.
    pub joints: &'a [SceneJoint],
}

impl View<'_> {
    /// Whether this is the end of the run.
    pub fn at_end(&self) -> bool {
        self.step == self.steps
    }

    /// Whether fewer than `count` steps are left, the end included.
    pub fn in_last(&self, count: u32) -> bool {
        self.step + count > self.steps
    }

    /// Bodies that exist and move by forces.
    pub fn dynamic(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.bodies.len()).filter(|&body| self.alive[body] && self.bodies[body].kind == BodyKind::Dynamic)
    }

    /// Mass properties that every engine was given.
    pub fn mass(&self, body: usize) -> Option<MassProperties> {
        match self.bodies[body].mass {
            Mass::Properties(properties) => Some(properties),
            _ => None,
        }
    }

    /// World position of the centre of mass (m).
    pub fn center(&self, body: usize) -> DVec3 {
        let pose = self.engine.pose(body);
        self.mass(body).map_or(pose.position, |mass| transform_point(&pose, mass.center_of_mass))
    }
}

/// As [`Pose::transform_point`], with the rotation carried out in `f64` so that measuring adds no rounding of its own.
pub fn transform_point(pose: &Pose, local: Vec3) -> DVec3 {
    pose.position + pose.rotation.as_dquat().normalize() * local.as_dvec3()
}

/// Inertia tensor in world axes (kg·m²).
pub(crate) fn world_inertia(mass: &MassProperties, pose: &Pose) -> DMat3 {
    let turn = DMat3::from_quat((pose.rotation.as_dquat() * mass.inertia_frame.as_dquat()).normalize());
    turn * DMat3::from_diagonal(mass.principal_inertia.as_dvec3()) * turn.transpose()
}

/// The greatest value seen; anything that is not a number counts as infinite.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Worst(f64);

impl Worst {
    pub(crate) const ZERO: Self = Self(0.0);

    pub(crate) fn note(&mut self, value: f64) {
        self.0 = self.0.max(if value.is_nan() { f64::INFINITY } else { value });
    }

    pub(crate) fn value(self) -> f64 {
        self.0
    }
}

/// `value`, or infinity where it is not a number.
pub(crate) fn or_infinite(value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { value }
}
