//! Limits, springs and motors of the coordinates of joints.

use glam::{Quat, Vec3};

use crate::check;
use crate::error::Result;

/// How a constraint row gives way: compliance (m/N or rad/(N·m)) and damping (N·s/m or N·m·s/rad).
///
/// Zero compliance is rigid; damping then has nothing to act on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Softness {
    /// Inverse stiffness, ≥ 0.
    pub compliance: f32,
    /// Force per relative speed, ≥ 0.
    pub damping: f32,
}

impl Softness {
    /// Does not give way at all.
    pub const RIGID: Self = Self { compliance: 0.0, damping: 0.0 };

    pub(crate) fn check(&self, compliance: &'static str, damping: &'static str) -> Result<()> {
        check::not_negative(compliance, self.compliance)?;
        check::not_negative(damping, self.damping)?;
        Ok(())
    }
}

/// Least and greatest value of a coordinate (m or rad); either may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Least value.
    pub min: f32,
    /// Greatest value.
    pub max: f32,
}

impl Limits {
    /// No limits.
    pub const NONE: Self = Self { min: f32::NEG_INFINITY, max: f32::INFINITY };

    /// Limits from `min` to `max`.
    pub const fn new(min: f32, max: f32) -> Self {
        Self { min, max }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::NONE
    }
}

/// What drives a coordinate of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Motor {
    /// Nothing.
    #[default]
    Off,
    /// Holds a speed (m/s or rad/s) with at most `max_force` (N or N·m).
    Velocity {
        /// Speed to hold.
        target: f32,
        /// Greatest force or torque, may be infinite.
        max_force: f32,
    },
    /// Drives towards a value (m or rad) as a spring and damper with at most `max_force` (N or N·m).
    Position {
        /// Value to reach.
        target: f32,
        /// Spring and damper; rigid goes to its target as fast as `max_force` allows, and stops there.
        softness: Softness,
        /// Greatest force or torque, may be infinite.
        max_force: f32,
    },
    /// Either of the two, with all settings that a motor has.
    Drive(Drive),
}

/// All settings of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Value to reach (m or rad); `None` for a motor that holds `velocity` alone.
    pub target: Option<f32>,
    /// Speed to hold (m/s or rad/s). With a `target`, the speed at which the target moves: damping acts on the difference to it, and
    /// `target` is where the target is at the end of the step. A host that moves a target sets both before each step.
    pub velocity: f32,
    /// Spring and damper towards `target`; rigid goes there as fast as force and speed allow.
    pub softness: Softness,
    /// Greatest force or torque, may be infinite.
    pub max_force: f32,
    /// Greatest speed on the way to `target` (m/s or rad/s), may be infinite. A spring drives no faster than this, but does not brake a
    /// coordinate that something else drives faster.
    pub max_speed: f32,
    /// Which way it may push.
    pub side: ForceSide,
}

/// Which way a motor may push its coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ForceSide {
    /// Both ways.
    #[default]
    Both,
    /// Towards lesser values alone: a winch, a muscle.
    Pull,
    /// Towards greater values alone: a jack.
    Push,
}

impl Drive {
    /// A rigid motor to `target` (m or rad) with at most `max_force` (N or N·m).
    pub const fn to(target: f32, max_force: f32) -> Self {
        Self { target: Some(target), ..Self::at(0.0, max_force) }
    }

    /// A motor that holds a speed (m/s or rad/s) with at most `max_force` (N or N·m).
    pub const fn at(velocity: f32, max_force: f32) -> Self {
        Self { target: None, velocity, softness: Softness::RIGID, max_force, max_speed: f32::INFINITY, side: ForceSide::Both }
    }

    /// Whether its force has no bound, either way.
    pub(crate) fn is_unbounded(&self) -> bool {
        self.max_force == f32::INFINITY && self.side == ForceSide::Both
    }

    /// Whether it is a spring with a greatest speed. Its row may then have bounds, even where `max_force` has none.
    pub(crate) fn may_be_slowed(&self) -> bool {
        self.softness.compliance > 0.0 && self.max_speed < f32::INFINITY
    }
}

impl Motor {
    /// Its settings; `None` where it is off.
    pub fn drive(&self) -> Option<Drive> {
        match *self {
            Self::Off => None,
            Self::Velocity { target, max_force } => Some(Drive::at(target, max_force)),
            Self::Position { target, softness, max_force } => Some(Drive { softness, ..Drive::to(target, max_force) }),
            Self::Drive(drive) => Some(drive),
        }
    }

    /// Checks its settings; errors call them by these names.
    pub(crate) fn check(&self, names: &MotorNames) -> Result<()> {
        let Some(drive) = self.drive() else { return Ok(()) };
        let is_velocity = matches!(self, Self::Velocity { .. });
        check::finite(if is_velocity { names.target } else { names.velocity }, drive.velocity)?;
        check::finite(names.target, drive.target.unwrap_or_default())?;
        drive.softness.check(names.compliance, names.damping)?;
        check::bound(names.max_force, drive.max_force)?;
        check::bound(names.max_speed, drive.max_speed)?;
        Ok(())
    }
}

/// What errors call the fields of a motor, and the limits beside it.
pub(crate) struct MotorNames {
    pub limits: &'static str,
    target: &'static str,
    velocity: &'static str,
    compliance: &'static str,
    damping: &'static str,
    max_force: &'static str,
    max_speed: &'static str,
}

macro_rules! motor_names {
    ($of:literal) => {
        MotorNames {
            limits: concat!($of, "limits"),
            target: concat!($of, "motor.target"),
            velocity: concat!($of, "motor.velocity"),
            compliance: concat!($of, "motor.compliance"),
            damping: concat!($of, "motor.damping"),
            max_force: concat!($of, "motor.max_force"),
            max_speed: concat!($of, "motor.max_speed"),
        }
    };
}

impl MotorNames {
    /// Those of a joint with one coordinate.
    pub(crate) const ONLY: Self = motor_names!("");
    /// Those of the six axes of a generic joint.
    pub(crate) const OF_AXES: [Self; 6] = [
        motor_names!("linear[0]."),
        motor_names!("linear[1]."),
        motor_names!("linear[2]."),
        motor_names!("angular[0]."),
        motor_names!("angular[1]."),
        motor_names!("angular[2]."),
    ];
}

/// What drives the rotation of a spherical joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum SphericalMotor {
    /// Nothing.
    #[default]
    Off,
    /// Holds an angular velocity of B against A, in A's joint frame (rad/s), with at most `max_torque` (N·m) about
    /// each of the frame's axes.
    Velocity {
        /// Angular velocity to hold.
        target: Vec3,
        /// Greatest torque about each axis, may be infinite.
        max_torque: f32,
    },
    /// Pulls towards a rotation of B's joint frame in A's, with at most `max_torque` (N·m) about each axis of A's.
    Position {
        /// Rotation to reach, unit quaternion.
        target: Quat,
        /// Spring and damper.
        softness: Softness,
        /// Greatest torque about each axis, may be infinite.
        max_torque: f32,
    },
}
