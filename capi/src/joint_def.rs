//! What a joint starts with, as C describes it: one flat struct, of which each kind reads its own fields.

use ls_core::{Axis, JointDef, JointKind, Limits, Motor, Pose, Softness, SphericalMotor, Strength};

use crate::boundary::call;
use crate::enums;
use crate::handle::LsBody;
use crate::math::LsPose;
use crate::motor_def::{LsDrive, LsMotor, LsSoftness, LsSphericalMotor, driven, motor};
use crate::pointer::host;
use crate::result::{Failure, LS_ERROR_UNSUPPORTED, LsResult, Outcome};
use crate::sized::{Definition, SizedOut, Versioned};
use crate::strength::LsStrength;
use crate::world_def::LS_SOLVER_AUTO;

/// Joint kind: nothing moves.
pub const LS_JOINT_FIXED: i32 = 0;
/// Joint kind: rotation about the joint axis, the angle counts turns; limits, motor, motor_drive, friction.
pub const LS_JOINT_HINGE: i32 = 1;
/// Joint kind: rotation about a point; swing_limit, limits (of the twist, which counts turns), spherical_motor, friction.
pub const LS_JOINT_SPHERICAL: i32 = 2;
/// Joint kind: the distance between two points; limits, has_spring, spring_length, motor, motor_drive.
pub const LS_JOINT_DISTANCE: i32 = 3;
/// Joint kind: translation along the joint axis; limits, motor, motor_drive, friction.
pub const LS_JOINT_PRISMATIC: i32 = 4;
/// Joint kind: six axes of A's frame, each free, locked or limited; linear_axes, angular_axes, axis_drives, axis_friction.
/// Rotations are the angles x, y, z of R_x R_y R_z, which takes A's frame to B's, and count turns. With one free it is a hinge,
/// whichever it is; with x and y or y and z free a universal joint; with three free a spherical joint. Where neither x nor z is
/// locked, these two are one axis at y = 90 degrees: what is asked of them fades there.
pub const LS_JOINT_GENERIC: i32 = 5;

/// Least and greatest value of a coordinate (m or rad); -INFINITY and INFINITY for none. Equal values lock it there.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsLimits {
    /// Least value (m or rad).
    pub min: f32,
    /// Greatest value (m or rad).
    pub max: f32,
}

/// One coordinate of a generic joint.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsAxis {
    /// Range of the coordinate (m or rad).
    pub limits: LsLimits,
    /// Drive of the coordinate.
    pub motor: LsMotor,
}

/// Everything a joint starts with. Fill it with ls_joint_def_init first.
///
/// A joint ties a frame on body A to a frame on body B. The joint axis is the x axis of both frames. Either body may be the null
/// handle: that side is then the world itself, and its frame is given in world coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsJointDef {
    /// Size of this struct in the host, set by ls_joint_def_init.
    pub struct_size: u32,
    /// LS_JOINT_ constant; default LS_JOINT_FIXED.
    pub kind: i32,
    /// First body, or null for the world; default null.
    pub body_a: LsBody,
    /// Second body, or null for the world; default null.
    pub body_b: LsBody,
    /// Joint frame on body A, in its frame; default its own.
    pub frame_a: LsPose,
    /// Joint frame on body B, in its frame; default its own.
    pub frame_b: LsPose,
    /// Give of the rows that hold points together, and of a distance joint's spring; default rigid.
    pub linear: LsSoftness,
    /// Give of the rows that hold directions together; default rigid.
    pub angular: LsSoftness,
    /// Give of the stops at limits; default rigid.
    pub limit: LsSoftness,
    /// Range of the angle (hinge), translation (prismatic), distance (distance) or twist (spherical); default none.
    pub limits: LsLimits,
    /// Spherical: greatest angle between the two joint axes (rad), 0 to pi; default pi, which is none.
    pub swing_limit: f32,
    /// Distance: length of the spring (m), >= 0; default 0.
    pub spring_length: f32,
    /// Distance: not 0 if there is a spring, whose give is linear; default 0.
    pub has_spring: u32,
    /// Force at which the joint is reported as overloaded (N), >= 0; default INFINITY, which is never.
    pub break_force: f32,
    /// Torque at which the joint is reported as overloaded (N m), >= 0; default INFINITY, which is never.
    pub break_torque: f32,
    /// Not 0: the two bodies collide with each other; default 0. Two bodies that joints hold at one point of a third, or of the world, so that
    /// they overlap by a tenth of the thinner one however they turn, never collide.
    pub collide_connected: u32,
    /// The host's own word; the library only hands it back.
    pub user_word: u64,
    /// Drive of a hinge, prismatic or distance joint; default off.
    pub motor: LsMotor,
    /// Drive of a spherical joint; default off.
    pub spherical_motor: LsSphericalMotor,
    /// Generic: translation along x, y, z; default locked at zero.
    pub linear_axes: [LsAxis; 3],
    /// Generic: rotation about x, y, z; default locked at zero.
    pub angular_axes: [LsAxis; 3],
    /// What the joint bears before it breaks; default unbreakable.
    pub strength: LsStrength,
    /// Not 0: long-range constraints are derived from it: bounds past it, planes of hinges, unions of fixed joints; default 1.
    pub long_range: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// LS_SOLVER_ constant: how the articulation that it belongs to is solved; default LS_SOLVER_AUTO, which is as the world says. One
    /// joint that asks for sweeps is enough for these, and else one that asks for the direct solve.
    pub solver: i32,
    /// Not used; 0.
    pub reserved_too: u32,
    /// Dry friction, >= 0: of a hinge about its axis (N m), of a prismatic joint along it (N), of a spherical joint against any rotation
    /// (N m, the greatest length of its torque); default 0.
    pub friction: f32,
    /// Generic: dry friction along x, y, z (N), then about them (N m), >= 0; default 0.
    pub axis_friction: [f32; 6],
    /// Coefficient of restitution of its rigid stops, 0 to 1: a limit that is met at v is left at this share of v; default 0.
    pub restitution: f32,
    /// What more the motor of a hinge, prismatic or distance joint is told; default nothing.
    pub motor_drive: LsDrive,
    /// Generic: what more the motors of its axes are told, along x, y and z, then about them; default nothing.
    pub axis_drives: [LsDrive; 6],
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsJointDef {
    const SIZES: &'static [usize] = &[400, 440, 448, 456, 488, 600];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsJointDef {}

impl Default for LsJointDef {
    fn default() -> Self {
        let locked = LsAxis { limits: LsLimits { min: 0.0, max: 0.0 }, motor: Motor::Off.into() };
        let rigid = LsSoftness::from(Softness::RIGID);
        Self {
            struct_size: size_of::<Self>() as u32,
            kind: LS_JOINT_FIXED,
            body_a: LsBody::NULL,
            body_b: LsBody::NULL,
            frame_a: Pose::IDENTITY.into(),
            frame_b: Pose::IDENTITY.into(),
            linear: rigid,
            angular: rigid,
            limit: rigid,
            limits: Limits::NONE.into(),
            swing_limit: std::f32::consts::PI,
            spring_length: 0.0,
            has_spring: 0,
            break_force: f32::INFINITY,
            break_torque: f32::INFINITY,
            collide_connected: 0,
            user_word: 0,
            motor: Motor::Off.into(),
            spherical_motor: SphericalMotor::Off.into(),
            linear_axes: [locked; 3],
            angular_axes: [locked; 3],
            strength: Strength::UNBREAKABLE.into(),
            long_range: 1,
            reserved: 0,
            solver: LS_SOLVER_AUTO,
            reserved_too: 0,
            friction: 0.0,
            axis_friction: [0.0; 6],
            restitution: 0.0,
            motor_drive: LsDrive::NONE,
            axis_drives: [LsDrive::NONE; 6],
        }
    }
}

/// Fills a joint definition with defaults: fixed, rigid, unbreakable, both bodies null.
///
/// @param def   filled on LS_OK
/// @param size  sizeof *def as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_def_init(def: *mut LsJointDef, size: usize) -> LsResult {
    call("ls_joint_def_init", || host!(SizedOut::new, def, size).write_definition(&LsJointDef::default()))
}

impl TryFrom<&LsJointDef> for JointDef {
    type Error = Failure;
    fn try_from(def: &LsJointDef) -> Outcome<Self> {
        Ok(Self {
            kind: def.try_into()?,
            body_a: def.body_a.into(),
            body_b: def.body_b.into(),
            frame_a: def.frame_a.into(),
            frame_b: def.frame_b.into(),
            linear: def.linear.into(),
            angular: def.angular.into(),
            limit: def.limit.into(),
            friction: def.friction,
            axis_friction: def.axis_friction,
            restitution: def.restitution,
            break_force: def.break_force,
            break_torque: def.break_torque,
            strength: def.strength.into(),
            collide_connected: def.collide_connected != 0,
            long_range: def.long_range != 0,
            solver: enums::solver(def.solver)?,
            user_word: def.user_word,
        })
    }
}

impl TryFrom<&LsJointDef> for JointKind {
    type Error = Failure;
    fn try_from(def: &LsJointDef) -> Outcome<Self> {
        let limits = Limits::from(def.limits);
        Ok(match def.kind {
            LS_JOINT_FIXED => Self::Fixed,
            LS_JOINT_HINGE => Self::Hinge { limits, motor: motor(def.motor, def.motor_drive)? },
            LS_JOINT_SPHERICAL => {
                Self::Spherical { swing_limit: def.swing_limit, twist_limits: limits, motor: def.spherical_motor.try_into()? }
            }
            LS_JOINT_DISTANCE => Self::Distance {
                limits,
                spring_length: (def.has_spring != 0).then_some(def.spring_length),
                motor: motor(def.motor, def.motor_drive)?,
            },
            LS_JOINT_PRISMATIC => Self::Prismatic { limits, motor: motor(def.motor, def.motor_drive)? },
            LS_JOINT_GENERIC => {
                let [x, y, z, about_x, about_y, about_z] = def.axis_drives;
                Self::Generic {
                    linear: axes("linear_axes", def.linear_axes, ([x, y, z], 0))?,
                    angular: axes("angular_axes", def.angular_axes, ([about_x, about_y, about_z], 3))?,
                }
            }
            _ => return Err(enums::unknown("kind")),
        })
    }
}

/// Three axes of `list`, and what more their motors are told, the first of which has a number among those of all six.
fn axes(list: &str, axes: [LsAxis; 3], (drives, first): ([LsDrive; 3], usize)) -> Outcome<[Axis; 3]> {
    let axis = |number: usize| {
        let motor = Motor::try_from(axes[number].motor).map_err(|failure| failure.in_element(list, number))?;
        let driven = driven(motor, drives[number]).map_err(|failure| failure.in_element("axis_drives", first + number))?;
        Ok::<_, Failure>(Axis { limits: axes[number].limits.into(), motor: driven })
    };
    Ok([axis(0)?, axis(1)?, axis(2)?])
}

impl TryFrom<&JointDef> for LsJointDef {
    type Error = Failure;
    fn try_from(def: &JointDef) -> Outcome<Self> {
        let mut c = Self {
            body_a: def.body_a.into(),
            body_b: def.body_b.into(),
            frame_a: def.frame_a.into(),
            frame_b: def.frame_b.into(),
            linear: def.linear.into(),
            angular: def.angular.into(),
            limit: def.limit.into(),
            break_force: def.break_force,
            break_torque: def.break_torque,
            collide_connected: def.collide_connected.into(),
            user_word: def.user_word,
            strength: def.strength.into(),
            long_range: def.long_range.into(),
            solver: enums::from_solver(def.solver),
            friction: def.friction,
            axis_friction: def.axis_friction,
            restitution: def.restitution,
            ..Self::default()
        };
        c.set_kind(&def.kind)?;
        Ok(c)
    }
}

impl LsJointDef {
    fn set_kind(&mut self, kind: &JointKind) -> Outcome<()> {
        match *kind {
            JointKind::Fixed => self.kind = LS_JOINT_FIXED,
            JointKind::Hinge { limits, motor } => {
                (self.kind, self.limits, self.motor) = (LS_JOINT_HINGE, limits.into(), motor.into());
                self.motor_drive = LsDrive::of(&motor);
            }
            JointKind::Prismatic { limits, motor } => {
                (self.kind, self.limits, self.motor) = (LS_JOINT_PRISMATIC, limits.into(), motor.into());
                self.motor_drive = LsDrive::of(&motor);
            }
            JointKind::Spherical { swing_limit, twist_limits, motor } => {
                (self.kind, self.swing_limit, self.limits) = (LS_JOINT_SPHERICAL, swing_limit, twist_limits.into());
                self.spherical_motor = motor.into();
            }
            JointKind::Distance { limits, spring_length, motor } => {
                (self.kind, self.limits, self.motor) = (LS_JOINT_DISTANCE, limits.into(), motor.into());
                self.motor_drive = LsDrive::of(&motor);
                self.has_spring = spring_length.is_some().into();
                self.spring_length = spring_length.unwrap_or(0.0);
            }
            JointKind::Generic { linear, angular } => {
                self.kind = LS_JOINT_GENERIC;
                self.linear_axes = linear.map(LsAxis::from);
                self.angular_axes = angular.map(LsAxis::from);
                let mut motors = linear.iter().chain(&angular).map(|axis| LsDrive::of(&axis.motor));
                self.axis_drives = std::array::from_fn(|_| motors.next().unwrap_or(LsDrive::NONE));
            }
            _ => return Err(Failure::Refused(LS_ERROR_UNSUPPORTED, "joint", "is of a kind that C cannot describe")),
        }
        Ok(())
    }
}

impl From<LsLimits> for Limits {
    fn from(limits: LsLimits) -> Self {
        Self { min: limits.min, max: limits.max }
    }
}

impl From<Limits> for LsLimits {
    fn from(limits: Limits) -> Self {
        Self { min: limits.min, max: limits.max }
    }
}

impl From<Axis> for LsAxis {
    fn from(axis: Axis) -> Self {
        Self { limits: axis.limits.into(), motor: axis.motor.into() }
    }
}
