//! Long-range constraints: what a world derives from its joints, and what became of it.

use ls_core::{BoundKind, BoundKindDef, BoundState, LongRangeDef, PlaneState, SoftBound, Softness};

use crate::access::{edit, read};
use crate::boundary::call;
use crate::handle::{LsJoint, LsWorld};
use crate::motor_def::LsSoftness;
use crate::pointer::{self, Buffer, host};
use crate::result::LsResult;
use crate::sized::{self, Definition, SizedOut, Versioned};

/// Bound: from a static or kinematic attachment to what hangs on it.
pub const LS_BOUND_ATTACHMENT: i32 = 0;
/// Bound: between two bodies that are free.
pub const LS_BOUND_HIERARCHY: i32 = 1;
/// Bound: asked for by the host between two joints.
pub const LS_BOUND_SOFT: i32 = 2;

/// Whether a kind of bound is derived, and its give. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsBoundKindDef {
    /// Not 0: such bounds are derived; default 1.
    pub enabled: u32,
    /// Give where the distance would exceed the upper bound; default none.
    pub upper: LsSoftness,
    /// Give where the distance would fall below the lower bound; default none.
    pub lower: LsSoftness,
}

/// What a world derives from its joints. Fill it with ls_long_range_def_init first.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsLongRangeDef {
    /// Size of this struct in the host, set by ls_long_range_def_init.
    pub struct_size: u32,
    /// Not 0: bounds are derived; default 1.
    pub enabled: u32,
    /// Bounds from static and kinematic attachments to what hangs on them.
    pub attachment: LsBoundKindDef,
    /// Bounds between bodies that are free.
    pub hierarchy: LsBoundKindDef,
    /// Levels of the hierarchy, 1 to 16; 0 (the default) for as many as the joints ask for.
    pub levels: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// Not 0: bounds asked for with ls_world_soft_bound_set act; default 1.
    pub soft: u32,
    /// Not 0: bodies that rigid fixed joints connect move as one, see ls_body_union_get; default 1.
    pub unions: u32,
    /// Not 0: chains of hinges with parallel axes are kept in one plane; default 1.
    pub plane_position: u32,
    /// Not 0: the axes of such chains are kept parallel; default 1.
    pub plane_axis: u32,
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsLongRangeDef {
    const SIZES: &'static [usize] = &[56, 60, 64, 72];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsLongRangeDef {}

impl Default for LsLongRangeDef {
    fn default() -> Self {
        (&LongRangeDef::default()).into()
    }
}

/// The greatest distance that a chain of joints leaves its two ends, taken as a soft lower bound: a spring that stretches it. The
/// layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsSoftBound {
    /// Factor on the greatest distance at which the spring is at rest, above 0 and up to 1.
    pub share: f32,
    /// Spring and damper; its compliance must not be 0.
    pub softness: LsSoftness,
}

/// A bound on the distance of two joints, as the last step left it. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsBound {
    /// Joint at its near end: that of the attachment, where it has one.
    pub near_joint: LsJoint,
    /// Joint at its far end.
    pub far_joint: LsJoint,
    /// Its near and its far point, world coordinates (m).
    pub points: [[f64; 3]; 2],
    /// LS_BOUND_ constant.
    pub kind: i32,
    /// Level in the hierarchy; 0 for other kinds.
    pub level: u32,
    /// Distance of the two points (m).
    pub distance: f32,
    /// Greatest distance (m).
    pub upper: f32,
    /// Least distance (m), 0 for none.
    pub lower: f32,
    /// Tension, mean over the last step (N); negative where the lower bound pushes.
    pub tension: f32,
    /// 1 if it had anything to do in the last step, else 0.
    pub active: u32,
    /// Not used; 0.
    pub reserved: u32,
}

/// Fills a definition of long-range constraints with defaults.
///
/// @param def   filled on LS_OK
/// @param size  sizeof *def as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_long_range_def_init(def: *mut LsLongRangeDef, size: usize) -> LsResult {
    call("ls_long_range_def_init", || host!(SizedOut::new, def, size).write_definition(&LsLongRangeDef::default()))
}

/// Changes what a world derives from its joints, and wakes everything.
///
/// @param world  the world; any value is safe
/// @param def    filled by ls_long_range_def_init and changed as wanted; read during the call
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_long_range_set(world: LsWorld, def: *const LsLongRangeDef) -> LsResult {
    call("ls_world_long_range_set", || {
        let def = LongRangeDef::from(&host!(sized::read, def));
        edit(world, |world| world.set_long_range(&def))
    })
}

/// What a world derives from its joints.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_long_range_get(world: LsWorld, out: *mut LsLongRangeDef, size: usize) -> LsResult {
    call("ls_world_long_range_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write_definition(&(&world.def().long_range).into()))
    })
}

/// Asks for a soft bound between two joints, or changes it, and wakes their bodies. It ends with either joint.
///
/// @param world    the world; any value is safe
/// @param joint_a  a joint of that world; any value is safe
/// @param joint_b  another one, connected to it by bodies and joints; any value is safe
/// @param bound    read during the call
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_soft_bound_set(
    world: LsWorld,
    joint_a: LsJoint,
    joint_b: LsJoint,
    bound: *const LsSoftBound,
) -> LsResult {
    call("ls_world_soft_bound_set", || {
        let bound = SoftBound::from(&host!(pointer::read, bound));
        edit(world, |world| world.set_soft_bound(joint_a.into(), joint_b.into(), Some(bound)))
    })
}

/// Takes a soft bound back and wakes the bodies of its joints; where there is none, nothing changes.
///
/// @param world    the world; any value is safe
/// @param joint_a  a joint of that world; any value is safe
/// @param joint_b  another one; any value is safe
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_world_soft_bound_remove(world: LsWorld, joint_a: LsJoint, joint_b: LsJoint) -> LsResult {
    call("ls_world_soft_bound_remove", || edit(world, |world| world.set_soft_bound(joint_a.into(), joint_b.into(), None)))
}

/// Every bound that was derived for the last step, with what it did.
///
/// @param world     the world; any value is safe
/// @param out       room for `capacity` bounds, may be NULL if that is 0
/// @param capacity  how many fit
/// @param count     set to how many there are on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL (nothing is written to `out` then)
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_bounds_get(world: LsWorld, out: *mut LsBound, capacity: usize, count: *mut usize) -> LsResult {
    call("ls_world_bounds_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| buffer.fill(|| world.bounds().map(|bound| LsBound::from(&bound))))
    })
}

/// The common plane of a chain of hinges, as the last step left it. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsPlane {
    /// The chain's joint of the lowest slot: it names the chain while both last.
    pub joint: LsJoint,
    /// The plane's point nearest to the middle of the chain (m).
    pub point: [f64; 3],
    /// Unit normal, along the axes of the hinges.
    pub normal: [f32; 3],
    /// Distance from the point of the member that is farthest from it (m).
    pub radius: f32,
    /// Root of the mean square of the distances by which members are off the plane (m).
    pub deviation: f32,
    /// Number of members: bodies, and rigid unions that count as one.
    pub members: u32,
    /// 1 if a hinge to something fixed gives the plane, else 0.
    pub anchored: u32,
    /// Not used; 0.
    pub reserved: u32,
}

/// The plane of every chain of hinges that was found for the last step.
///
/// @param world     the world; any value is safe
/// @param out       room for `capacity` planes, may be NULL if that is 0
/// @param capacity  how many fit
/// @param count     set to how many there are on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL (nothing is written to `out` then)
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_planes_get(world: LsWorld, out: *mut LsPlane, capacity: usize, count: *mut usize) -> LsResult {
    call("ls_world_planes_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| buffer.fill(|| world.planes().map(|plane| LsPlane::from(&plane))))
    })
}

impl From<&PlaneState> for LsPlane {
    fn from(plane: &PlaneState) -> Self {
        Self {
            joint: plane.joint.into(),
            point: plane.point.to_array(),
            normal: plane.normal.to_array(),
            radius: plane.radius,
            deviation: plane.deviation,
            members: plane.members,
            anchored: plane.anchored.into(),
            reserved: 0,
        }
    }
}

impl From<&LsSoftBound> for SoftBound {
    fn from(bound: &LsSoftBound) -> Self {
        let LsSoftness { compliance, damping } = bound.softness;
        Self { share: bound.share, softness: Softness { compliance, damping } }
    }
}

impl From<&LsBoundKindDef> for BoundKindDef {
    fn from(def: &LsBoundKindDef) -> Self {
        let give = |softness: LsSoftness| Softness { compliance: softness.compliance, damping: softness.damping };
        Self { enabled: def.enabled != 0, upper: give(def.upper), lower: give(def.lower) }
    }
}

impl From<&BoundKindDef> for LsBoundKindDef {
    fn from(def: &BoundKindDef) -> Self {
        let give = |softness: Softness| LsSoftness { compliance: softness.compliance, damping: softness.damping };
        Self { enabled: def.enabled.into(), upper: give(def.upper), lower: give(def.lower) }
    }
}

impl From<&LsLongRangeDef> for LongRangeDef {
    fn from(def: &LsLongRangeDef) -> Self {
        Self {
            enabled: def.enabled != 0,
            attachment: (&def.attachment).into(),
            hierarchy: (&def.hierarchy).into(),
            soft: def.soft != 0,
            union: def.unions != 0,
            plane_position: def.plane_position != 0,
            plane_axis: def.plane_axis != 0,
            levels: (def.levels != 0).then_some(def.levels),
        }
    }
}

impl From<&LongRangeDef> for LsLongRangeDef {
    fn from(def: &LongRangeDef) -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            enabled: def.enabled.into(),
            attachment: (&def.attachment).into(),
            hierarchy: (&def.hierarchy).into(),
            levels: def.levels.unwrap_or(0),
            reserved: 0,
            soft: def.soft.into(),
            unions: def.union.into(),
            plane_position: def.plane_position.into(),
            plane_axis: def.plane_axis.into(),
        }
    }
}

impl From<&BoundState> for LsBound {
    fn from(bound: &BoundState) -> Self {
        Self {
            near_joint: bound.near.into(),
            far_joint: bound.far.into(),
            points: bound.points.map(|point| point.to_array()),
            kind: match bound.kind {
                BoundKind::Attachment => LS_BOUND_ATTACHMENT,
                BoundKind::Hierarchy => LS_BOUND_HIERARCHY,
                _ => LS_BOUND_SOFT,
            },
            level: bound.level,
            distance: bound.distance,
            upper: bound.upper,
            lower: bound.lower,
            tension: bound.tension,
            active: bound.active.into(),
            reserved: 0,
        }
    }
}
