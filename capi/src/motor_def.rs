//! What drives a coordinate of a joint, and what gives way in it, as C describes them.

use ls_core::glam::{Quat, Vec3};
use ls_core::{Drive, ForceSide, Motor, Softness, SphericalMotor};

use crate::enums;
use crate::result::{Failure, Outcome};

/// Motor mode: nothing drives the coordinate.
pub const LS_MOTOR_OFF: i32 = 0;
/// Motor mode: holds a speed with at most the greatest force or torque.
pub const LS_MOTOR_VELOCITY: i32 = 1;
/// Motor mode: pulls towards a value as a spring and damper, with at most the greatest force or torque.
pub const LS_MOTOR_POSITION: i32 = 2;

/// Which way a motor may push its coordinate: both ways.
pub const LS_FORCE_BOTH: i32 = 0;
/// Which way a motor may push its coordinate: towards lesser values alone, as a winch or a muscle does.
pub const LS_FORCE_PULL: i32 = 1;
/// Which way a motor may push its coordinate: towards greater values alone, as a jack does.
pub const LS_FORCE_PUSH: i32 = 2;

/// How constraint rows give way. Acts as a physical spring and damper whatever the number of substeps and iterations.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsSoftness {
    /// Inverse stiffness (m/N or rad/(N m)), >= 0; 0 is rigid.
    pub compliance: f32,
    /// Force per relative speed (N s/m or N m s/rad), >= 0; without compliance there is nothing to damp.
    pub damping: f32,
}

/// What drives one coordinate of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsMotor {
    /// LS_MOTOR_ constant.
    pub mode: i32,
    /// Speed (m/s or rad/s) or value (m or rad) to reach.
    pub target: f32,
    /// Spring and damper of LS_MOTOR_POSITION; rigid goes to its target as fast as max_force allows, and stops there.
    pub softness: LsSoftness,
    /// Greatest force (N) or torque (N m), may be INFINITY.
    pub max_force: f32,
}

/// Further settings of a motor, beside those of LsMotor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsDrive {
    /// LS_MOTOR_POSITION: speed at which its target moves (m/s or rad/s); default 0. Damping acts on the difference to it, and the target
    /// is where target says at the end of the step: set both before each step.
    pub target_velocity: f32,
    /// LS_MOTOR_POSITION: greatest speed on the way to the target (m/s or rad/s), >= 0; default INFINITY. A spring drives no
    /// faster than this, but does not brake a coordinate that something else drives faster.
    pub max_speed: f32,
    /// LS_FORCE_ constant: which way the motor may push; default LS_FORCE_BOTH.
    pub side: i32,
    /// Not used; 0.
    pub reserved: u32,
}

/// What drives the rotation of a spherical joint.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsSphericalMotor {
    /// LS_MOTOR_ constant.
    pub mode: i32,
    /// LS_MOTOR_VELOCITY: angular velocity of B against A, in A's joint frame (rad/s).
    pub target_velocity: [f32; 3],
    /// LS_MOTOR_POSITION: rotation of B's joint frame in A's, unit quaternion x, y, z, w.
    pub target_rotation: [f32; 4],
    /// Spring and damper of LS_MOTOR_POSITION.
    pub softness: LsSoftness,
    /// Greatest torque about each axis of A's joint frame (N m), may be INFINITY: about (1, 1, 1) up to 1.73 times as much.
    pub max_torque: f32,
}

impl LsDrive {
    /// No further settings. Not in the header: cbindgen cannot write an infinity for C.
    ///
    /// cbindgen:ignore
    pub const NONE: Self = Self { target_velocity: 0.0, max_speed: f32::INFINITY, side: LS_FORCE_BOTH, reserved: 0 };

    /// The settings of a joint's motor that `LsMotor` does not have.
    pub fn of(motor: &Motor) -> Self {
        let Motor::Drive(drive) = motor else { return Self::NONE };
        Self {
            target_velocity: if drive.target.is_some() { drive.velocity } else { 0.0 },
            max_speed: drive.max_speed,
            side: match drive.side {
                ForceSide::Both => LS_FORCE_BOTH,
                ForceSide::Pull => LS_FORCE_PULL,
                ForceSide::Push => LS_FORCE_PUSH,
            },
            reserved: 0,
        }
    }
}

/// The motor of a joint with one coordinate, with its further settings.
pub fn motor(motor: LsMotor, drive: LsDrive) -> Outcome<Motor> {
    driven(motor.try_into()?, drive).map_err(|failure| match failure {
        Failure::Refused(code, _, problem) => Failure::Refused(code, "motor_drive.side", problem),
        other => other,
    })
}

/// A motor with its further settings.
pub fn driven(plain: Motor, drive: LsDrive) -> Outcome<Motor> {
    let side = match drive.side {
        LS_FORCE_BOTH => ForceSide::Both,
        LS_FORCE_PULL => ForceSide::Pull,
        LS_FORCE_PUSH => ForceSide::Push,
        _ => return Err(enums::unknown("side")),
    };
    let is_plain = drive.target_velocity == 0.0 && drive.max_speed == f32::INFINITY && side == ForceSide::Both;
    Ok(match plain.drive().filter(|_| !is_plain) {
        None => plain,
        Some(told) => {
            let velocity = if told.target.is_some() { drive.target_velocity } else { told.velocity };
            Motor::Drive(Drive { velocity, max_speed: drive.max_speed, side, ..told })
        }
    })
}

impl From<LsSoftness> for Softness {
    fn from(softness: LsSoftness) -> Self {
        Self { compliance: softness.compliance, damping: softness.damping }
    }
}

impl From<Softness> for LsSoftness {
    fn from(softness: Softness) -> Self {
        Self { compliance: softness.compliance, damping: softness.damping }
    }
}

impl TryFrom<LsMotor> for Motor {
    type Error = Failure;
    fn try_from(motor: LsMotor) -> Outcome<Self> {
        let LsMotor { mode, target, softness, max_force } = motor;
        match mode {
            LS_MOTOR_OFF => Ok(Self::Off),
            LS_MOTOR_VELOCITY => Ok(Self::Velocity { target, max_force }),
            LS_MOTOR_POSITION => Ok(Self::Position { target, softness: softness.into(), max_force }),
            _ => Err(enums::unknown("motor.mode")),
        }
    }
}

impl From<Motor> for LsMotor {
    fn from(motor: Motor) -> Self {
        let rigid = Softness::RIGID.into();
        match motor {
            Motor::Off => Self { mode: LS_MOTOR_OFF, target: 0.0, softness: rigid, max_force: f32::INFINITY },
            Motor::Velocity { target, max_force } => Self { mode: LS_MOTOR_VELOCITY, target, softness: rigid, max_force },
            Motor::Position { target, softness, max_force } => {
                Self { mode: LS_MOTOR_POSITION, target, softness: softness.into(), max_force }
            }
            Motor::Drive(Drive { target: None, velocity, max_force, .. }) => {
                Self { mode: LS_MOTOR_VELOCITY, target: velocity, softness: rigid, max_force }
            }
            Motor::Drive(Drive { target: Some(target), softness, max_force, .. }) => {
                Self { mode: LS_MOTOR_POSITION, target, softness: softness.into(), max_force }
            }
        }
    }
}

impl TryFrom<LsSphericalMotor> for SphericalMotor {
    type Error = Failure;
    fn try_from(motor: LsSphericalMotor) -> Outcome<Self> {
        let LsSphericalMotor { mode, target_velocity, target_rotation, softness, max_torque } = motor;
        match mode {
            LS_MOTOR_OFF => Ok(Self::Off),
            LS_MOTOR_VELOCITY => Ok(Self::Velocity { target: Vec3::from_array(target_velocity), max_torque }),
            LS_MOTOR_POSITION => {
                Ok(Self::Position { target: Quat::from_array(target_rotation), softness: softness.into(), max_torque })
            }
            _ => Err(enums::unknown("spherical_motor.mode")),
        }
    }
}

impl From<SphericalMotor> for LsSphericalMotor {
    fn from(motor: SphericalMotor) -> Self {
        let off = Self {
            mode: LS_MOTOR_OFF,
            target_velocity: [0.0; 3],
            target_rotation: Quat::IDENTITY.to_array(),
            softness: Softness::RIGID.into(),
            max_torque: f32::INFINITY,
        };
        match motor {
            SphericalMotor::Off => off,
            SphericalMotor::Velocity { target, max_torque } => {
                Self { mode: LS_MOTOR_VELOCITY, target_velocity: target.to_array(), max_torque, ..off }
            }
            SphericalMotor::Position { target, softness, max_torque } => {
                Self { mode: LS_MOTOR_POSITION, target_rotation: target.to_array(), softness: softness.into(), max_torque, ..off }
            }
        }
    }
}
