//! The solver's own view of a body: what constraint rows touch, apart from what only integration touches.
//!
//! Slot 0 of every batch is the world: it never moves and absorbs what static shapes receive.

use glam::{Mat3, Quat, Vec3};

use super::rotation::Top;
use crate::linalg::rotation32::{NEGLIGIBLE_PUSH, rotated, settled};

/// Slot of everything static.
pub(crate) const WORLD_SLOT: u32 = 0;

/// Largest rotation by which a body is pushed at once (rad).
pub(crate) const MAX_PUSH_TURN: f32 = 0.5;

/// Symmetric 3×3 matrix: xx, yy, zz, xy, xz, yz.
#[derive(Debug, Clone, Copy, Default)]
#[repr(transparent)]
pub(crate) struct Symmetric([f32; 6]);

impl Symmetric {
    pub(crate) const ZERO: Self = Self([0.0; 6]);

    pub(crate) fn from_mat3(m: Mat3) -> Self {
        Self([m.x_axis.x, m.y_axis.y, m.z_axis.z, m.x_axis.y, m.x_axis.z, m.y_axis.z])
    }

    pub(crate) fn to_mat3(self) -> Mat3 {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Mat3::from_cols(Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz))
    }

    pub(crate) fn entries(&self) -> &[f32; 6] {
        &self.0
    }

    #[inline(always)]
    pub(crate) fn mul(&self, v: Vec3) -> Vec3 {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Vec3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
    }
}

/// Velocity and inverse mass of a body: one cache line, all that a sweep reads and writes.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct BodyVelocity {
    /// Velocity of the centre of mass (m/s).
    pub linear: Vec3,
    /// Angular velocity (rad/s).
    pub angular: Vec3,
    /// Inverse mass along the world axes (1/kg); zero where locked.
    pub inverse_mass: Vec3,
    /// Inverse inertia in world axes (1/(kg·m²)).
    pub inverse_inertia: Symmetric,
    /// Fills the line, so that it can be read as numbers.
    pub unused: f32,
}

impl BodyVelocity {
    pub(crate) const FIXED: Self = Self::new(Vec3::ZERO, Symmetric::ZERO);

    /// A body at rest.
    pub(crate) const fn new(inverse_mass: Vec3, inverse_inertia: Symmetric) -> Self {
        Self { linear: Vec3::ZERO, angular: Vec3::ZERO, inverse_mass, inverse_inertia, unused: 0.0 }
    }

    /// Its numbers in order: linear and angular velocity, inverse mass, inverse inertia, and one without meaning.
    #[inline(always)]
    pub(crate) fn halves(&self) -> [&[f32; 8]; 2] {
        // SAFETY: the struct is `repr(C)` and made of 16 `f32` without padding, as its size says.
        let halves = unsafe { &*std::ptr::from_ref(self).cast::<[[f32; 8]; 2]>() };
        [&halves[0], &halves[1]]
    }

    /// Linear and angular velocity, and the first two numbers of the inverse mass.
    #[inline(always)]
    pub(crate) fn first_half_mut(&mut self) -> &mut [f32; 8] {
        // SAFETY: as in `halves`; any numbers may be written.
        unsafe { &mut *std::ptr::from_mut(self).cast::<[f32; 8]>() }
    }

    /// Whether it turns and no row can change that: it is moved by the host.
    pub(crate) fn turns_as_told(&self) -> bool {
        self.angular != Vec3::ZERO && self.inverse_mass == Vec3::ZERO && self.inverse_inertia.0 == [0.0; 6]
    }

    /// The same body at rest, to gather displacements in.
    pub(crate) fn at_rest(&self) -> Self {
        Self { linear: Vec3::ZERO, angular: Vec3::ZERO, ..*self }
    }

    #[inline(always)]
    pub(crate) fn halves_mut(&mut self) -> [&mut [f32; 8]; 2] {
        // SAFETY: as in `halves`; any numbers may be written.
        let [first, second] = unsafe { &mut *std::ptr::from_mut(self).cast::<[[f32; 8]; 2]>() };
        [first, second]
    }

    /// Applies an impulse (N·s) and an angular impulse about the centre of mass (N·m·s).
    #[inline(always)]
    pub(crate) fn apply(&mut self, impulse: Vec3, angular_impulse: Vec3) {
        self.linear += self.inverse_mass * impulse;
        self.angular += self.inverse_inertia.mul(angular_impulse);
    }
}

const _: () = assert!(size_of::<BodyVelocity>() == 16 * size_of::<f32>());

/// Motion of a body since the start of the step, and what integration needs to know of it.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct BodyMotion {
    /// Displacement of the centre of mass since the start of the step (m).
    pub displacement: Vec3,
    /// Sum of the substeps' rotation vectors since the start of the step (rad).
    pub turn: Vec3,
    pub linear_damping: f32,
    pub angular_damping: f32,
    /// Rotation now.
    pub rotation: Quat,
    /// Acceleration by gravity and by the host's forces, or of a path that the host gives (m/s²).
    pub acceleration: Vec3,
    /// The host's torque (N·m), or the angular acceleration of a path (rad/s²).
    pub torque: Vec3,
    /// Principal moments of inertia (kg·m²).
    pub inertia: Vec3,
    /// Rotation vector since the world inertia was last refreshed (rad).
    pub turn_at_refresh: Vec3,
    /// Rotation of the principal axes in the body.
    pub inertia_frame: Quat,
    pub kind: MotionKind,
    /// Whether joint rows need the predicted pose of this body.
    pub jointed: bool,
    /// Whether its articulation moves this body through the whole step.
    pub direct: bool,
    /// Whether its island has not been thrown about of late.
    pub steady: bool,
    /// Whether it was made, or put where it is, a short while ago.
    pub young: bool,
    pub constraints: Constraints,
    pub world_inertia: WorldInertia,
    /// Whether the body is moved with seven others.
    pub in_lanes: bool,
    /// No rotation about these world axes.
    pub locked_rotation: [bool; 3],
    /// Whether a motor takes it further than it may go by its velocity, into what contacts have been looked for with.
    pub driven: bool,
}

const _: () = assert!(std::mem::offset_of!(BodyMotion, rotation) == 32 && std::mem::offset_of!(BodyMotion, inertia) == 72);

/// Two cache lines: all motions of a batch are gone through several times a substep.
const _: () = assert!(size_of::<BodyMotion>() == 128);

/// How the inertia in world axes is that of a substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorldInertia {
    /// Whether it was formed anew.
    pub refreshed: bool,
    /// Whether an axis answers as heavier than it is, as the substep smears it.
    pub smeared: bool,
}

/// What acts on a body beside forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Constraints {
    /// No row.
    None,
    /// Rows between bodies that fall as it does.
    Falling,
    /// Any others.
    Holding,
}

/// How a slot is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MotionKind {
    /// Static, or a replica of a static body that a joint holds on to.
    Fixed,
    /// Moves at a given velocity.
    Kinematic,
    /// All principal moments are equal: angular velocity is constant without torque.
    Round,
    /// The gyroscopic term matters.
    Tumbling,
}

impl BodyMotion {
    /// Force of gravity and of the host on it, of this inverse mass (N).
    pub(crate) fn pull(&self, velocity: &BodyVelocity) -> f64 {
        let inverse_mass = f64::from(velocity.inverse_mass.max_element());
        if self.is_dynamic() && inverse_mass > 0.0 { f64::from(self.acceleration.length()) / inverse_mass } else { 0.0 }
    }

    pub(crate) const FIXED: Self = Self {
        displacement: Vec3::ZERO,
        turn: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        acceleration: Vec3::ZERO,
        torque: Vec3::ZERO,
        linear_damping: 0.0,
        angular_damping: 0.0,
        inertia: Vec3::ONE,
        inertia_frame: Quat::IDENTITY,
        turn_at_refresh: Vec3::ZERO,
        kind: MotionKind::Fixed,
        jointed: false,
        direct: false,
        steady: true,
        young: false,
        constraints: Constraints::None,
        world_inertia: WorldInertia { refreshed: false, smeared: false },
        in_lanes: false,
        locked_rotation: [false; 3],
        driven: false,
    };

    /// Displacement, turn, and two numbers more.
    #[inline(always)]
    pub(crate) fn moved(&self) -> &[f32; 8] {
        // SAFETY: the struct is `repr(C)` and begins with eight `f32`: two vectors and two dampings.
        unsafe { &*std::ptr::from_ref(self).cast::<[f32; 8]>() }
    }

    /// Displacement, turn, two numbers more, rotation, and four more.
    #[inline(always)]
    pub(crate) fn halves(&self) -> [&[f32; 8]; 2] {
        // SAFETY: the struct is `repr(C)` and begins with 16 `f32` without padding, as the offsets of two fields say.
        let halves = unsafe { &*std::ptr::from_ref(self).cast::<[[f32; 8]; 2]>() };
        [&halves[0], &halves[1]]
    }

    #[inline(always)]
    pub(crate) fn halves_mut(&mut self) -> [&mut [f32; 8]; 2] {
        // SAFETY: as in `halves`; any numbers may be written.
        let [first, second] = unsafe { &mut *std::ptr::from_mut(self).cast::<[[f32; 8]; 2]>() };
        [first, second]
    }

    /// Moves a dynamic body by a displacement (m) and a rotation vector (rad, at most [`MAX_PUSH_TURN`]).
    pub(crate) fn displace(&mut self, displacement: Vec3, turn: Vec3) {
        // To push by nothing normalises the rotation, but of what is solved by itself no bit depends on what else is in its batch.
        if !self.is_dynamic() || self.direct {
            return;
        }
        let turn = settled(turn, NEGLIGIBLE_PUSH).clamp_length_max(MAX_PUSH_TURN);
        let displacement = settled(displacement, NEGLIGIBLE_PUSH);
        if displacement == Vec3::ZERO && turn == Vec3::ZERO {
            return;
        }
        self.displacement += displacement;
        self.turn += turn;
        self.rotation = rotated(self.rotation, turn);
    }

    /// 1 about free world axes, 0 about locked ones.
    pub(crate) fn free_rotation(&self) -> Vec3 {
        crate::body::free_axes(self.locked_rotation)
    }

    pub(crate) fn is_free_to_turn(&self) -> bool {
        self.locked_rotation == [false; 3]
    }

    /// What decides how the body tumbles.
    pub(crate) fn top(&self) -> Top {
        Top {
            inertia: self.inertia.as_dvec3(),
            frame: self.inertia_frame.as_dquat().normalize(),
            free: self.free_rotation().as_dvec3(),
            round: self.kind == MotionKind::Round,
        }
    }

    /// Angular momentum at this angular velocity (kg·m²/s).
    pub(crate) fn angular_momentum(&self, angular: Vec3) -> Vec3 {
        if self.kind == MotionKind::Round {
            return self.inertia.x * angular;
        }
        let frame = self.rotation * self.inertia_frame;
        frame * (self.inertia * (frame.conjugate() * angular))
    }

    pub(crate) fn is_dynamic(&self) -> bool {
        matches!(self.kind, MotionKind::Round | MotionKind::Tumbling)
    }
}
