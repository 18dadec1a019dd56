//! Joints: what a user defines, and the record the world keeps.
//!
//! A joint ties a frame on body A to a frame on body B. The *joint axis* is the x axis of both frames: a hinge turns about it,
//! a prismatic joint slides along it, a spherical joint twists about it. Either body may be [`BodyId::NULL`]: that side is then
//! the world itself and its frame is given in world coordinates.
//!
//! Compliance is the inverse of stiffness (m/N, rad/(N·m)), damping is a force per speed (N·s/m, N·m·s/rad); both act as a
//! physical spring and damper would, whatever the number of substeps and iterations (Macklin et al. 2016, XPBD).
//!
//! Friction is that of a dry bearing: a force or torque of a given greatest size against the motion of what the joint leaves free,
//! whatever its speed and whatever the joint bears. Below it the joint sticks.

use glam::Vec3;

use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::fracture::Strength;
use crate::id::BodyId;
use crate::motor::MotorNames;
pub use crate::motor::{Drive, ForceSide, Limits, Motor, Softness, SphericalMotor};
use crate::pose::Pose;
use crate::settings::Solver;

/// One coordinate of a generic joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Range of the coordinate (m or rad); equal bounds lock it there.
    pub limits: Limits,
    /// Drive.
    pub motor: Motor,
}

impl Axis {
    /// Free to move.
    pub const FREE: Self = Self { limits: Limits::NONE, motor: Motor::Off };
    /// Held at zero.
    pub const LOCKED: Self = Self { limits: Limits::new(0.0, 0.0), motor: Motor::Off };

    /// Free between two values (m or rad).
    pub const fn limited(min: f32, max: f32) -> Self {
        Self { limits: Limits::new(min, max), motor: Motor::Off }
    }
}

/// What a joint allows.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum JointKind {
    /// Nothing moves.
    Fixed,
    /// Rotation about the joint axis; the angle counts turns.
    Hinge {
        /// Range of the angle (rad), of any size.
        limits: Limits,
        /// Drive of the angle.
        motor: Motor,
    },
    /// Rotation about a point.
    Spherical {
        /// Greatest angle between the two joint axes (rad), π for none.
        swing_limit: f32,
        /// Range of the rotation about the joint axis (rad), which counts turns.
        twist_limits: Limits,
        /// Drive of the rotation.
        motor: SphericalMotor,
    },
    /// The distance between two points.
    Distance {
        /// Range of the distance (m), ≥ 0.
        limits: Limits,
        /// Length of the spring (m) whose give is the joint's `linear` softness; `None` for no spring.
        spring_length: Option<f32>,
        /// Drive of the distance.
        motor: Motor,
    },
    /// Translation along the joint axis.
    Prismatic {
        /// Range of the translation (m).
        limits: Limits,
        /// Drive of the translation.
        motor: Motor,
    },
    /// Six axes of A's frame, each free, locked or limited. Rotations are the angles φ, θ, ψ of R_x(φ) R_y(θ) R_z(ψ), which takes A's
    /// frame to B's, and count turns. With one axis free it is a hinge, with x and y or y and z a universal joint, with three a
    /// spherical joint. Where none of x and z is locked, these two are one axis at θ = ±π/2: what is asked of them fades there.
    Generic {
        /// Translation along x, y, z.
        linear: [Axis; 3],
        /// Rotation about x, y, z.
        angular: [Axis; 3],
    },
}

impl JointKind {
    /// A hinge without limits or motor.
    pub const HINGE: Self = Self::Hinge { limits: Limits::NONE, motor: Motor::Off };
    /// A spherical joint without limits or motor.
    pub const SPHERICAL: Self =
        Self::Spherical { swing_limit: std::f32::consts::PI, twist_limits: Limits::NONE, motor: SphericalMotor::Off };
    /// A prismatic joint without limits or motor.
    pub const PRISMATIC: Self = Self::Prismatic { limits: Limits::NONE, motor: Motor::Off };

    /// What drives each of its axes, and between which limits, as far as that has a motor of its own; of a spherical joint what holds a speed
    /// about each axis of A's frame.
    pub(crate) fn drives(&self) -> [Option<(Drive, Limits)>; 6] {
        let driven = |limits: &Limits, motor: &Motor| motor.drive().map(|drive| (drive, *limits));
        match self {
            Self::Fixed => [None; 6],
            Self::Hinge { limits, motor } | Self::Prismatic { limits, motor } | Self::Distance { limits, motor, .. } => {
                [driven(limits, motor), None, None, None, None, None]
            }
            Self::Spherical { motor, .. } => {
                let SphericalMotor::Velocity { target, max_torque } = *motor else { return [None; 6] };
                let [x, y, z] = target.to_array().map(|speed| Some((Drive::at(speed, max_torque), Limits::NONE)));
                [x, y, z, None, None, None]
            }
            Self::Generic { linear: [x, y, z], angular: [u, v, w] } => {
                [x, y, z, u, v, w].map(|axis| driven(&axis.limits, &axis.motor))
            }
        }
    }
}

/// Everything a joint starts with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDef {
    /// What it allows.
    pub kind: JointKind,
    /// First body, or null for the world.
    pub body_a: BodyId,
    /// Second body, or null for the world.
    pub body_b: BodyId,
    /// Joint frame on body A, in its frame (in world coordinates if A is the world).
    pub frame_a: Pose,
    /// Joint frame on body B, in its frame (in world coordinates if B is the world).
    pub frame_b: Pose,
    /// Give of the rows that hold points together, and of a distance joint's spring.
    pub linear: Softness,
    /// Give of the rows that hold directions together.
    pub angular: Softness,
    /// Give of the stops at limits: springs and dampers from where they are met on, which only push.
    pub limit: Softness,
    /// Dry friction, ≥ 0: of a hinge about its axis (N·m), of a prismatic joint along it (N), of a spherical joint against any
    /// rotation (N·m, the greatest length of its torque). Other kinds have none.
    pub friction: f32,
    /// Dry friction of a six-axis joint's axes, ≥ 0: along x, y and z (N), then about them (N·m). Other kinds have none.
    pub axis_friction: [f32; 6],
    /// Restitution of its rigid stops, 0 to 1: the share of the speed at which one is met that it is left with.
    pub restitution: f32,
    /// Force at which the joint is reported as overloaded (N), infinity for never.
    pub break_force: f32,
    /// Torque at which the joint is reported as overloaded (N·m), infinity for never.
    pub break_torque: f32,
    /// What it bears before it breaks.
    pub strength: Strength,
    /// Whether the two bodies collide with each other. Two bodies that joints hold at one point of a third, or of the world, so that they overlap
    /// by a tenth of the thinner one however they turn, never do.
    pub collide_connected: bool,
    /// Whether long-range constraints are derived from it: bounds past it, planes of hinges, unions of fixed joints.
    pub long_range: bool,
    /// How the articulation that it belongs to is solved; [`Solver::Auto`] for as the world says. Of all joints of an articulation one that
    /// asks for sweeps is enough for these, and else one that asks for the direct solve.
    pub solver: Solver,
    /// The host's own word; the world only hands it back.
    pub user_word: u64,
}

impl JointDef {
    /// A rigid, unbreakable joint with both frames at their body's origin.
    pub fn new(kind: JointKind, body_a: BodyId, body_b: BodyId) -> Self {
        Self {
            kind,
            body_a,
            body_b,
            frame_a: Pose::IDENTITY,
            frame_b: Pose::IDENTITY,
            linear: Softness::RIGID,
            angular: Softness::RIGID,
            limit: Softness::RIGID,
            friction: 0.0,
            axis_friction: [0.0; 6],
            restitution: 0.0,
            break_force: f32::INFINITY,
            break_torque: f32::INFINITY,
            strength: Strength::UNBREAKABLE,
            collide_connected: false,
            long_range: true,
            solver: Solver::Auto,
            user_word: 0,
        }
    }

    /// The same joint with its frames at these points of the two bodies (m), not rotated.
    #[must_use]
    pub fn at(mut self, on_a: Vec3, on_b: Vec3) -> Self {
        self.frame_a = Pose::at(on_a.as_dvec3());
        self.frame_b = Pose::at(on_b.as_dvec3());
        self
    }

    /// The same joint with this friction (N·m or N).
    #[must_use]
    pub fn with_friction(mut self, friction: f32) -> Self {
        self.friction = friction;
        self
    }

    pub(crate) fn checked(mut self) -> Result<Self> {
        self.frame_a = self.frame_a.checked("frame_a.position", "frame_a.rotation")?;
        self.frame_b = self.frame_b.checked("frame_b.position", "frame_b.rotation")?;
        let sides = [("frame_a.position", self.body_a, self.frame_a), ("frame_b.position", self.body_b, self.frame_b)];
        for (argument, _, frame) in sides.into_iter().filter(|(_, body, _)| *body != BodyId::NULL) {
            check::lever(argument, frame.position.as_vec3())?;
        }
        self.linear.check("linear.compliance", "linear.damping")?;
        self.angular.check("angular.compliance", "angular.damping")?;
        self.limit.check("limit.compliance", "limit.damping")?;
        check::not_negative("friction", self.friction)?;
        for friction in self.axis_friction {
            check::not_negative("axis_friction", friction)?;
        }
        if check::not_negative("restitution", self.restitution)? > 1.0 {
            return Err(Error::new(ErrorKind::OutOfRange, "restitution", "is greater than 1"));
        }
        check::bound("break_force", self.break_force)?;
        check::bound("break_torque", self.break_torque)?;
        self.strength.check()?;
        self.kind = self.kind.checked()?;
        Ok(self)
    }
}

impl JointKind {
    pub(crate) fn checked(mut self) -> Result<Self> {
        match &mut self {
            Self::Fixed => {}
            Self::Hinge { limits, motor } | Self::Prismatic { limits, motor } => {
                check::range(MotorNames::ONLY.limits, limits.min, limits.max)?;
                motor.check(&MotorNames::ONLY)?;
            }
            Self::Spherical { swing_limit, twist_limits, motor } => {
                if check::not_negative("swing_limit", *swing_limit)? > std::f32::consts::PI {
                    return Err(Error::new(ErrorKind::OutOfRange, "swing_limit", "is greater than π"));
                }
                check::range("twist_limits", twist_limits.min, twist_limits.max)?;
                match motor {
                    SphericalMotor::Off => {}
                    SphericalMotor::Velocity { target, max_torque } => {
                        check::finite_vec("motor.target", *target)?;
                        check::bound("motor.max_torque", *max_torque)?;
                    }
                    SphericalMotor::Position { target, softness, max_torque } => {
                        *target = check::rotation("motor.target", *target)?;
                        softness.check("motor.compliance", "motor.damping")?;
                        check::bound("motor.max_torque", *max_torque)?;
                    }
                }
            }
            Self::Distance { limits, spring_length, motor } => {
                check::range("limits", limits.min, limits.max)?;
                if limits.max < 0.0 {
                    return Err(Error::new(ErrorKind::OutOfRange, "limits", "a distance cannot be negative"));
                }
                if let Some(length) = *spring_length {
                    check::not_negative("spring_length", length)?;
                }
                motor.check(&MotorNames::ONLY)?;
            }
            Self::Generic { linear, angular } => {
                for (axis, names) in linear.iter().chain(angular.iter()).zip(&MotorNames::OF_AXES) {
                    check::range(names.limits, axis.limits.min, axis.limits.max)?;
                    axis.motor.check(names)?;
                }
            }
        }
        Ok(self)
    }
}

/// What a joint does at the end of the last step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// Coordinate of the free axis: angle, turns counted (rad), translation or distance (m); zero for other kinds.
    pub position: f32,
    /// Its rate (rad/s or m/s).
    pub velocity: f32,
    /// Force that the joint exerts on body B at its point, world axes, mean over the step (N).
    pub force: Vec3,
    /// Torque that the joint exerts on body B about its point, world axes, mean over the step (N·m).
    pub torque: Vec3,
    /// Distance between the two joint points beyond what the joint allows (m).
    pub gap: f32,
    /// Force (N) or torque (N·m) on body B along the free axis, mean over the step: what motor, friction, spring, stops at limits and a
    /// distance that is held come to. Zero for kinds without a coordinate; of these `torque` has all.
    pub effort: f32,
}

/// One axis of a joint at the end of the last step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointAxisState {
    /// Its coordinate: angle, turns counted (rad), translation or distance (m).
    pub position: f32,
    /// Rate of the coordinate (rad/s or m/s).
    pub velocity: f32,
    /// Force (N) or torque (N·m) on body B along the axis, mean over the step: all that acts there.
    pub effort: f32,
    /// That of the motor alone (N or N·m).
    pub motor: f32,
}
