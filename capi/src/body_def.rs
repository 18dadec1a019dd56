//! What a body starts with, as C describes it.

use std::ptr;

use ls_core::glam::{Quat, Vec3};
use ls_core::{BodyDef, Mass, MassProperties, Pose};

use crate::boundary::call;
use crate::enums;
use crate::math::LsPose;
use crate::pointer::host;
use crate::result::{LsResult, Outcome};
use crate::shape_def::{LsShapeDef, read_array};
use crate::sized::{Definition, SizedOut, Versioned};

/// Body kind: never moves.
pub const LS_BODY_STATIC: i32 = 0;
/// Body kind: moves as the host says, by velocity or target pose, and pushes dynamic bodies without being pushed.
pub const LS_BODY_KINEMATIC: i32 = 1;
/// Body kind: moves by forces, contacts and joints.
pub const LS_BODY_DYNAMIC: i32 = 2;

/// Mass kind: volume times density of the shapes.
pub const LS_MASS_FROM_SHAPES: i32 = 0;
/// Mass kind: properties.mass, distributed as the shapes say.
pub const LS_MASS_TOTAL: i32 = 1;
/// Mass kind: properties, whatever the shapes are.
pub const LS_MASS_PROPERTIES: i32 = 2;

/// Locked axis: no translation along the world's x axis.
pub const LS_LOCK_TRANSLATION_X: u32 = 1;
/// Locked axis: no translation along the world's y axis.
pub const LS_LOCK_TRANSLATION_Y: u32 = 2;
/// Locked axis: no translation along the world's z axis.
pub const LS_LOCK_TRANSLATION_Z: u32 = 4;
/// Locked axis: no rotation about the world's x axis.
pub const LS_LOCK_ROTATION_X: u32 = 8;
/// Locked axis: no rotation about the world's y axis.
pub const LS_LOCK_ROTATION_Y: u32 = 16;
/// Locked axis: no rotation about the world's z axis.
pub const LS_LOCK_ROTATION_Z: u32 = 32;

/// Mass properties of a rigid body, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsMassProperties {
    /// Mass (kg), 1e-9 to 1e12.
    pub mass: f32,
    /// Centre of mass (m).
    pub center_of_mass: [f32; 3],
    /// Principal moments of inertia about the centre of mass (kg m^2), each > 0.
    pub principal_inertia: [f32; 3],
    /// Rotation of the principal axes, unit quaternion x, y, z, w.
    pub inertia_frame: [f32; 4],
}

/// Where a dynamic body's mass comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsMass {
    /// LS_MASS_ constant; default LS_MASS_FROM_SHAPES.
    pub kind: i32,
    /// Read as far as the kind names it; default 1 kg, 1 kg m^2, centred, not rotated.
    pub properties: LsMassProperties,
}

/// Everything a body starts with. Fill it with ls_body_def_init first. Arrays are read during the call and not kept.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsBodyDef {
    /// Size of this struct in the host, set by ls_body_def_init.
    pub struct_size: u32,
    /// LS_BODY_ constant; default LS_BODY_DYNAMIC.
    pub kind: i32,
    /// Its frame in the world; default the world's own.
    pub pose: LsPose,
    /// Velocity of its centre of mass (m/s), at most 1e4; default zero.
    pub linear_velocity: [f32; 3],
    /// Angular velocity, world axes (rad/s), at most 1e4; default zero.
    pub angular_velocity: [f32; 3],
    /// Where its mass comes from. A dynamic body needs a shape with density, or LS_MASS_PROPERTIES.
    pub mass: LsMass,
    /// Rate k at which linear velocity decays (1/s), >= 0; default 0. Implicit: v / (1 + k h) in a substep of length h (s).
    pub linear_damping: f32,
    /// Rate k at which angular velocity decays (1/s), >= 0; default 0. Implicit: v / (1 + k h) in a substep of length h (s).
    pub angular_damping: f32,
    /// Factor on the world's gravity; default 1.
    pub gravity_scale: f32,
    /// Bit set of LS_LOCK_ constants: degrees of freedom taken away; default 0.
    pub locked_axes: u32,
    /// Not 0: it may fall asleep; default 1.
    pub can_sleep: u32,
    /// Not 0: it is swept through the step, so that it cannot tunnel through anything thin; default 0.
    pub fast: u32,
    /// The host's own word; the library only hands it back.
    pub user_word: u64,
    /// Shapes it is made with, all with the same struct_size; more can be attached later. Default none.
    pub shapes: *const LsShapeDef,
    /// Number of shapes.
    pub shape_count: usize,
}

// SAFETY: numbers and a raw pointer without padding.
unsafe impl Versioned for LsBodyDef {
    const SIZES: &'static [usize] = &[168];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsBodyDef {}

impl Default for LsBodyDef {
    fn default() -> Self {
        let def = BodyDef::default();
        Self {
            struct_size: size_of::<Self>() as u32,
            kind: enums::from_body_kind(def.kind),
            pose: Pose::IDENTITY.into(),
            linear_velocity: def.linear_velocity.to_array(),
            angular_velocity: def.angular_velocity.to_array(),
            mass: LsMass { kind: LS_MASS_FROM_SHAPES, properties: MassProperties::new(1.0, Vec3::ONE).into() },
            linear_damping: def.linear_damping,
            angular_damping: def.angular_damping,
            gravity_scale: def.gravity_scale,
            locked_axes: 0,
            can_sleep: def.can_sleep.into(),
            fast: def.fast.into(),
            user_word: def.user_word,
            shapes: ptr::null(),
            shape_count: 0,
        }
    }
}

/// Fills a body definition with defaults: dynamic, at the origin, at rest, mass from shapes, no shapes.
///
/// @param def   filled on LS_OK
/// @param size  sizeof *def as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_def_init(def: *mut LsBodyDef, size: usize) -> LsResult {
    call("ls_body_def_init", || host!(SizedOut::new, def, size).write_definition(&LsBodyDef::default()))
}

impl LsBodyDef {
    /// # Safety
    /// `shapes` is null, or valid for reading `shape_count` definitions whose own pointers are valid.
    pub(crate) unsafe fn to_core(self) -> Outcome<BodyDef> {
        // SAFETY: as promised to this function.
        let shapes = unsafe { read_array(self.shapes, self.shape_count, "shapes") }?;
        Ok(BodyDef {
            kind: enums::body_kind(self.kind)?,
            pose: self.pose.into(),
            linear_velocity: Vec3::from_array(self.linear_velocity),
            angular_velocity: Vec3::from_array(self.angular_velocity),
            mass: self.mass.try_into()?,
            locked_axes: enums::locked_axes(self.locked_axes)?,
            linear_damping: self.linear_damping,
            angular_damping: self.angular_damping,
            gravity_scale: self.gravity_scale,
            can_sleep: self.can_sleep != 0,
            fast: self.fast != 0,
            user_word: self.user_word,
            // SAFETY: as promised to this function.
            shapes: shapes.into_iter().map(|shape| unsafe { shape.to_core() }).collect::<Outcome<_>>()?,
        })
    }
}

impl TryFrom<LsMass> for Mass {
    type Error = crate::result::Failure;
    fn try_from(mass: LsMass) -> Outcome<Self> {
        match mass.kind {
            LS_MASS_FROM_SHAPES => Ok(Self::FromShapes),
            LS_MASS_TOTAL => Ok(Self::Total(mass.properties.mass)),
            LS_MASS_PROPERTIES => Ok(Self::Properties(mass.properties.into())),
            _ => Err(enums::unknown("mass.kind")),
        }
    }
}

impl From<LsMassProperties> for MassProperties {
    fn from(properties: LsMassProperties) -> Self {
        Self {
            mass: properties.mass,
            center_of_mass: Vec3::from_array(properties.center_of_mass),
            principal_inertia: Vec3::from_array(properties.principal_inertia),
            inertia_frame: Quat::from_array(properties.inertia_frame),
        }
    }
}

impl From<MassProperties> for LsMassProperties {
    fn from(properties: MassProperties) -> Self {
        Self {
            mass: properties.mass,
            center_of_mass: properties.center_of_mass.to_array(),
            principal_inertia: properties.principal_inertia.to_array(),
            inertia_frame: properties.inertia_frame.to_array(),
        }
    }
}
