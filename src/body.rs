//! Rigid bodies: what a user defines, and the record the world keeps.

use glam::{DVec3, Mat3, Quat, Vec3};

use crate::check;
use crate::dwell_time::{DwellTime, Settling};
use crate::error::{Error, ErrorKind, Result};
use crate::id::{JointId, ShapeId};
use crate::kinematic_path::KinematicPath;
use crate::linalg::held_axes::held32;
use crate::mass::{Mass, MassProperties};
use crate::pose::Pose;
use crate::shape::ShapeDef;
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};
use crate::step_history::StepHistory;

/// How a body moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BodyKind {
    /// Never moves.
    Static,
    /// Moves as the host says, by velocity or target pose, and pushes dynamic bodies without being pushed.
    Kinematic,
    /// Moves by forces, contacts and joints.
    #[default]
    Dynamic,
}

/// Degrees of freedom taken from a dynamic body, along and about world axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LockedAxes {
    /// No translation along x, y, z.
    pub translation: [bool; 3],
    /// No rotation about x, y, z.
    pub rotation: [bool; 3],
}

/// Everything a body starts with.
#[derive(Debug, Clone)]
pub struct BodyDef {
    /// How it moves.
    pub kind: BodyKind,
    /// Its frame in the world.
    pub pose: Pose,
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: Vec3,
    /// Angular velocity, world axes (rad/s).
    pub angular_velocity: Vec3,
    /// Where its mass comes from.
    pub mass: Mass,
    /// Degrees of freedom taken away.
    pub locked_axes: LockedAxes,
    /// Rate at which linear velocity decays (1/s), ≥ 0.
    pub linear_damping: f32,
    /// Rate at which angular velocity decays (1/s), ≥ 0.
    pub angular_damping: f32,
    /// Factor on the world's gravity.
    pub gravity_scale: f32,
    /// Whether it may fall asleep.
    pub can_sleep: bool,
    /// Sweep it through the step, so that it cannot tunnel through anything thin.
    pub fast: bool,
    /// The host's own word; the world only hands it back.
    pub user_word: u64,
    /// Shapes it is made with; more can be attached later.
    pub shapes: Vec<ShapeDef>,
}

impl Default for BodyDef {
    fn default() -> Self {
        Self {
            kind: BodyKind::Dynamic,
            pose: Pose::IDENTITY,
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            mass: Mass::FromShapes,
            locked_axes: LockedAxes::default(),
            linear_damping: 0.0,
            angular_damping: 0.0,
            gravity_scale: 1.0,
            can_sleep: true,
            fast: false,
            user_word: 0,
            shapes: Vec::new(),
        }
    }
}

impl BodyDef {
    /// A dynamic body at `pose`.
    pub fn dynamic(pose: Pose) -> Self {
        Self { pose, ..Self::default() }
    }

    /// A static body at `pose`.
    pub fn fixed(pose: Pose) -> Self {
        Self { kind: BodyKind::Static, pose, ..Self::default() }
    }

    /// A kinematic body at `pose`.
    pub fn kinematic(pose: Pose) -> Self {
        Self { kind: BodyKind::Kinematic, pose, ..Self::default() }
    }

    /// The same body with one more shape.
    #[must_use]
    pub fn with_shape(mut self, shape: ShapeDef) -> Self {
        // Most bodies have one.
        if self.shapes.is_empty() {
            self.shapes.reserve_exact(1);
        }
        self.shapes.push(shape);
        self
    }

    /// The same body with its mass set outright.
    #[must_use]
    pub fn with_mass(mut self, mass: Mass) -> Self {
        self.mass = mass;
        self
    }

    pub(crate) fn checked(mut self) -> Result<Self> {
        self.pose = self.pose.checked("pose.position", "pose.rotation")?;
        checked_velocity("linear_velocity", self.linear_velocity, MAX_LINEAR_SPEED)?;
        checked_velocity("angular_velocity", self.angular_velocity, MAX_ANGULAR_SPEED)?;
        check::not_negative("linear_damping", self.linear_damping)?;
        check::not_negative("angular_damping", self.angular_damping)?;
        check::finite("gravity_scale", self.gravity_scale)?;
        let dynamic = self.kind == BodyKind::Dynamic;
        self.shapes = self.shapes.into_iter().map(|shape| shape.checked(dynamic)).collect::<Result<_>>()?;
        Ok(self)
    }
}

pub(crate) fn checked_velocity(argument: &'static str, velocity: Vec3, limit: f32) -> Result<Vec3> {
    if check::finite_vec(argument, velocity)?.length() > limit {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "is faster than 1e4 (m/s or rad/s)"));
    }
    Ok(velocity)
}

/// A velocity no greater than `limit`, as the solver leaves it: rows and position rows of the last substep may ask for more.
pub(crate) fn within_limit(velocity: Vec3, limit: f32) -> Vec3 {
    let length = velocity.length();
    // Rounding must not leave it above.
    if length > limit { velocity * (limit / length * (1.0 - 2.0 * f32::EPSILON)) } else { velocity }
}

/// What the host sets of a body and steps only read.
#[derive(Debug, Clone)]
pub(crate) struct BodySettings {
    pub mass_source: Mass,
    pub locked_axes: LockedAxes,
    pub linear_damping: f32,
    pub angular_damping: f32,
    pub gravity_scale: f32,
    pub can_sleep: bool,
    pub fast: bool,
    pub user_word: u64,
}

/// Where the host moves a kinematic body.
#[derive(Debug, Clone, Default)]
pub(crate) struct KinematicState {
    /// Whether the velocity comes from a target, so that it ends with it.
    pub driven: bool,
    pub path: Option<Box<KinematicPath>>,
}

/// For how long a body has been in the state in which steps may save work.
#[derive(Debug, Clone)]
pub(crate) struct BodyTimes {
    /// How far it is from lying where it was put.
    pub settling: Settling,
    /// For how long it has been calm.
    pub calm_for: DwellTime,
    /// For how long it has moved smoothly: by itself, or in an articulation that is swept with contacts.
    pub smooth_for: DwellTime,
}

/// The world's record of a body. The centre of mass is what the solver moves; the user's frame follows from it.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub kind: BodyKind,
    /// World position of the centre of mass (m).
    pub center: DVec3,
    pub rotation: Quat,
    pub linear_velocity: Vec3,
    pub angular_velocity: Vec3,
    /// Force and torque gathered since the last step (N, N·m), about the centre of mass.
    pub force: Vec3,
    pub torque: Vec3,
    pub mass: Option<MassProperties>,
    pub local_center: Vec3,
    pub settings: BodySettings,
    pub kinematic: KinematicState,
    pub shapes: Vec<ShapeId>,
    pub joints: Vec<JointId>,
    pub sleep: SleepState,
    pub times: BodyTimes,
    /// Whether it keeps its pose in this step because nothing could move it.
    pub held: bool,
    /// Whether it has woken since what moved was last listed.
    pub woke: bool,
    /// Whether fixed joints make it part of something that does not move, or that the host moves.
    pub anchored: Anchored,
    /// Last substep, for stepping to second order.
    pub history: StepHistory,
    /// Taken out of the simulation because a step gave it a non-finite state.
    pub quarantined: bool,
}

/// What holds a dynamic body so that it is not free to move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchored {
    /// Nothing.
    No,
    /// Fixed joints to something static.
    Still,
    /// Fixed joints to something kinematic.
    Driven,
}

/// Where a body is in the life of its island.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SleepState {
    /// Moving, or quiet for this long (s), and how it drifts meanwhile.
    Awake { quiet_for: f32, drift: Drift },
    /// Asleep as a member of this sleeping island.
    Asleep { island: u32 },
}

impl SleepState {
    /// Awake, and not quiet yet.
    pub(crate) const AWAKE: Self = Self::Awake { quiet_for: 0.0, drift: Drift::NONE };
}

/// Mean rate at which the pose of a quiet body changes (m/s, rad/s), which is not its velocity where overlaps are taken out of positions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Drift {
    pub linear: Vec3,
    pub angular: Vec3,
    /// What both were a while ago: means over a longer time.
    pub linear_before: Vec3,
    pub angular_before: Vec3,
}

impl Drift {
    pub(crate) const NONE: Self =
        Self { linear: Vec3::ZERO, angular: Vec3::ZERO, linear_before: Vec3::ZERO, angular_before: Vec3::ZERO };
}

impl Body {
    pub(crate) fn new(def: &BodyDef, mass: Option<MassProperties>) -> Self {
        let local_center = mass.map_or(Vec3::ZERO, |mass| mass.center_of_mass);
        let moves = def.kind != BodyKind::Static;
        let mut body = Self {
            kind: def.kind,
            center: def.pose.transform_point(local_center),
            rotation: def.pose.rotation,
            linear_velocity: if moves { def.linear_velocity } else { Vec3::ZERO },
            angular_velocity: if moves { def.angular_velocity } else { Vec3::ZERO },
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            mass,
            local_center,
            settings: BodySettings {
                mass_source: def.mass,
                locked_axes: def.locked_axes,
                linear_damping: def.linear_damping,
                angular_damping: def.angular_damping,
                gravity_scale: def.gravity_scale,
                can_sleep: def.can_sleep,
                fast: def.fast,
                user_word: def.user_word,
            },
            kinematic: KinematicState::default(),
            shapes: Vec::new(),
            joints: Vec::new(),
            sleep: SleepState::AWAKE,
            times: BodyTimes { settling: Settling::NEW, calm_for: DwellTime::NONE, smooth_for: DwellTime::NONE },
            woke: false,
            held: false,
            anchored: Anchored::No,
            history: StepHistory::default(),
            quarantined: false,
        };
        body.stop_along_locked_axes();
        body
    }

    /// Takes away the velocity along and about axes that are locked. A kinematic body moves as the host says.
    pub(crate) fn stop_along_locked_axes(&mut self) {
        if self.is_dynamic() {
            self.linear_velocity *= free_axes(self.settings.locked_axes.translation);
            self.angular_velocity *= free_axes(self.settings.locked_axes.rotation);
        }
    }

    pub(crate) fn is_dynamic(&self) -> bool {
        self.kind == BodyKind::Dynamic
    }

    /// How it acts on others: what is anchored acts as what it is anchored to.
    pub(crate) fn acts_as(&self) -> BodyKind {
        match self.anchored {
            Anchored::No => self.kind,
            Anchored::Still => BodyKind::Static,
            Anchored::Driven => BodyKind::Kinematic,
        }
    }

    /// Whether forces, contacts and joints can move it.
    pub(crate) fn is_free(&self) -> bool {
        self.acts_as() == BodyKind::Dynamic
    }

    pub(crate) fn is_awake(&self) -> bool {
        matches!(self.sleep, SleepState::Awake { .. })
    }

    /// Whether a step may move the body: awake and dynamic, or kinematic with a velocity or a target.
    pub(crate) fn is_mover(&self) -> bool {
        match self.acts_as() {
            BodyKind::Static => false,
            BodyKind::Dynamic => self.is_awake() && !self.quarantined,
            BodyKind::Kinematic => {
                self.linear_velocity != Vec3::ZERO
                    || self.angular_velocity != Vec3::ZERO
                    || self.kinematic.path.as_ref().is_some_and(|path| path.target.is_some() || path.bends())
            }
        }
    }

    /// Pose a kinematic body shall have at the end of the next step.
    pub(crate) fn target(&self) -> Option<Pose> {
        self.kinematic.path.as_ref().and_then(|path| path.target)
    }

    /// The same, no longer kept.
    pub(crate) fn take_target(&mut self) -> Option<Pose> {
        self.kinematic.path.as_mut().and_then(|path| path.target.take())
    }

    /// Whether it has arrived where it was told to move to, and stands from the next step on.
    pub(crate) fn stops(&self) -> bool {
        self.kind == BodyKind::Kinematic && self.kinematic.driven && self.target().is_none()
    }

    /// Whether the host pushes it in the next step.
    pub(crate) fn is_pushed(&self) -> bool {
        self.force != Vec3::ZERO || self.torque != Vec3::ZERO
    }

    /// Whether this step solves for its motion: free, awake and not held.
    pub(crate) fn is_solved(&self) -> bool {
        self.is_free() && self.is_mover() && !self.held
    }

    /// Whether it is awake and moves, or is held for the moment.
    pub(crate) fn is_under_way(&self) -> bool {
        self.is_awake() && (self.held || self.linear_velocity != Vec3::ZERO || self.angular_velocity != Vec3::ZERO)
    }

    pub(crate) fn pose(&self) -> Pose {
        Pose { position: self.center - (self.rotation * self.local_center).as_dvec3(), rotation: self.rotation }
    }

    pub(crate) fn set_pose(&mut self, pose: Pose) {
        self.rotation = pose.rotation;
        self.center = pose.transform_point(self.local_center);
    }

    /// Gives the body new mass properties; its frame stays where it is, and its points go on as fast as they did: a centre that
    /// moves by d has the velocity v + ω × d, and what was gathered as F and τ there is F and τ − d × F here.
    pub(crate) fn set_mass(&mut self, mass: Option<MassProperties>) {
        let (pose, before) = (self.pose(), self.local_center);
        self.mass = mass;
        self.local_center = mass.map_or(Vec3::ZERO, |mass| mass.center_of_mass);
        self.set_pose(pose);
        let shift = self.rotation * (self.local_center - before);
        if shift != Vec3::ZERO {
            let change = self.angular_velocity.cross(shift) * free_axes(self.settings.locked_axes.translation);
            self.linear_velocity = within_limit(self.linear_velocity + change, MAX_LINEAR_SPEED);
            self.torque -= shift.cross(self.force);
            self.history.center_moved(shift);
        }
    }

    /// Inverse mass (1/kg); zero for what is not free.
    pub(crate) fn inverse_mass(&self) -> f32 {
        if self.is_free() { self.own_inverse_mass() } else { 0.0 }
    }

    /// Inverse mass that it has once nothing holds it (1/kg).
    pub(crate) fn own_inverse_mass(&self) -> f32 {
        self.mass.map_or(0.0, |mass| 1.0 / mass.mass)
    }

    /// Inverse inertia tensor in world axes (1/(kg·m²)), locked axes held.
    pub(crate) fn world_inverse_inertia(&self) -> Mat3 {
        if self.is_free() { self.own_inverse_inertia() } else { Mat3::ZERO }
    }

    /// Inverse inertia tensor that it has once nothing holds it: world axes (1/(kg·m²)), locked axes held.
    pub(crate) fn own_inverse_inertia(&self) -> Mat3 {
        match &self.mass {
            Some(mass) => {
                let inverse = crate::shape::inertia_tensor(1.0 / mass.principal_inertia, self.rotation * mass.inertia_frame);
                held32(inverse, free_axes(self.settings.locked_axes.rotation))
            }
            _ => Mat3::ZERO,
        }
    }
}

/// 1 along free axes, 0 along locked ones.
pub(crate) fn free_axes(locked: [bool; 3]) -> Vec3 {
    Vec3::from_array(locked.map(|locked| if locked { 0.0 } else { 1.0 }))
}
