//! Fracture: what broke, what fell into pieces, what is close to it.

use std::ffi::c_void;

use ls_core::{JointBreak, JointId, JointStress, Piece, Split};

use crate::access::{Hosted, edit, edit_hosted, read};
use crate::boundary::call;
use crate::float_environment::as_host;
use crate::handle::{LsBody, LsJoint, LsWorld};
use crate::pointer::{self, Buffer, Out, OutArray, host, slice};
use crate::result::LsResult;
use crate::sized::{SizedOut, Versioned};
use crate::strength::{LsFractureSettings, LsStrength, from_cause, from_limit};
use crate::world_events::publish;

/// A joint that broke in a step. It is gone: its handle is stale. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsJointBreak {
    /// The joint that was.
    pub joint: LsJoint,
    /// The word its host gave it.
    pub user_word: u64,
    /// Its first body; null is the world.
    pub body_a: LsBody,
    /// Its second body; null is the world.
    pub body_b: LsBody,
    /// Where it was (m).
    pub point: [f64; 3],
    /// Number of the step.
    pub step: u64,
    /// Mean force on B over its window, world axes (N).
    pub force: [f32; 3],
    /// Mean torque on B about its point, world axes (N m).
    pub torque: [f32; 3],
    /// Its load as a fraction of the limit that it broke at; above 1 if by load.
    pub share: f32,
    /// LS_STRENGTH_ constant: that limit.
    pub limit: i32,
    /// LS_BREAK_ constant: why it broke.
    pub cause: i32,
    /// Not used; 0.
    pub reserved: u32,
}

/// A rigid union, which is the dynamic bodies that fixed joints connect, that fell into pieces in a step, or lost its anchor. The
/// layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsSplit {
    /// Its member of the lowest slot, which is in the first piece too.
    pub first_body: LsBody,
    /// Its centre of mass at the end of the step (m).
    pub center: [f64; 3],
    /// Number of the step.
    pub step: u64,
    /// Number of its members.
    pub body_count: u32,
    /// Its mass (kg).
    pub mass: f32,
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: [f32; 3],
    /// 1 if a fixed joint tied it to the world or to a body that is not dynamic, else 0.
    pub anchored: u32,
    /// Its first piece in the array of ls_world_pieces_get.
    pub first_piece: u32,
    /// Number of its pieces.
    pub piece_count: u32,
}

/// What is left of a union: a smaller one, or a single body. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsPiece {
    /// Its member of the lowest slot.
    pub first_body: LsBody,
    /// Its centre of mass at the end of the step (m).
    pub center: [f64; 3],
    /// Its first member in the array of ls_world_piece_bodies_get.
    pub first_member: u32,
    /// Number of its members.
    pub body_count: u32,
    /// Its mass (kg).
    pub mass: f32,
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: [f32; 3],
    /// Angular velocity: that of a rigid body with its angular momentum (rad/s).
    pub angular_velocity: [f32; 3],
    /// 1 if a fixed joint still ties it to the world or to a body that is not dynamic, else 0.
    pub anchored: u32,
    /// 1 if the union had an anchor and this piece has none, else 0.
    pub cut_loose: u32,
    /// Not used; 0.
    pub reserved: u32,
}

/// What a joint bears at present. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsJointStress {
    /// Mean force on B over the window, axes of the joint's frame on A (N); of a distance joint, x along the line from its point on A to that on B.
    pub force: [f32; 3],
    /// Mean torque on B about the joint's point, axes of the joint's frame on A (N m).
    pub torque: [f32; 3],
    /// Its load as a fraction of the nearest limit: 1 breaks; 0 without limits.
    pub share: f32,
    /// LS_STRENGTH_ constant: that limit.
    pub limit: i32,
    /// Its wear, a fraction: 1 breaks.
    pub damage: f32,
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsJointStress {
    const SIZES: &'static [usize] = &[36];
}

/// Receives the joints that broke in a step, one call each, in the order of ls_world_joint_breaks_get.
///
/// Called after the solve on the thread that steps, under its own floating-point settings. It must return normally (no
/// exception, no longjmp). Inside it, reads of the world work, on other threads too; edits return LS_ERROR_WORLD_LOCKED.
/// @param world   the world that steps
/// @param broken  the joint and its load, valid during the call
/// @param user    as given to ls_world_break_callback_set
pub type LsBreakCallback = Option<unsafe extern "C" fn(world: LsWorld, broken: *const LsJointBreak, user: *mut c_void)>;

/// Receives the unions that fell into pieces in a step, one call each, in the order of ls_world_splits_get, after all broken joints.
///
/// Called like LsBreakCallback; ls_world_pieces_get and ls_world_piece_bodies_get work inside it.
/// @param world  the world that steps
/// @param split  the union, valid during the call
/// @param user   as given to ls_world_split_callback_set
pub type LsSplitCallback = Option<unsafe extern "C" fn(world: LsWorld, split: *const LsSplit, user: *mut c_void)>;

/// The functions that are told of fractures.
#[derive(Default)]
pub(crate) struct FractureHandlers {
    on_break: Option<(unsafe extern "C" fn(LsWorld, *const LsJointBreak, *mut c_void), *mut c_void)>,
    on_split: Option<(unsafe extern "C" fn(LsWorld, *const LsSplit, *mut c_void), *mut c_void)>,
}

// SAFETY: the pointers are only handed back, and the header says that this happens on the thread that steps.
unsafe impl Send for FractureHandlers {}
// SAFETY: as above.
unsafe impl Sync for FractureHandlers {}

pub(crate) fn call_back(world: LsWorld, hosted: &Hosted) {
    if let Some((callback, user)) = hosted.fracture_handlers.on_break {
        for broken in hosted.world.broken().iter().map(LsJointBreak::from) {
            // SAFETY: the host promised a function of this type that accepts its own pointer.
            as_host(|| unsafe { callback(world, &raw const broken, user) });
        }
    }
    if let Some((callback, user)) = hosted.fracture_handlers.on_split {
        for split in hosted.world.splits().iter().map(LsSplit::from) {
            // SAFETY: the host promised a function of this type that accepts its own pointer.
            as_host(|| unsafe { callback(world, &raw const split, user) });
        }
    }
}

/// Sets the function that receives broken joints; at the start there is none.
///
/// @param world     the world; any value is safe
/// @param callback  called by ls_world_step; NULL for none
/// @param user      handed back to the callback; must stay valid until another callback is set or the world is destroyed
/// @return LS_OK, a world error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_break_callback_set(world: LsWorld, callback: LsBreakCallback, user: *mut c_void) -> LsResult {
    call("ls_world_break_callback_set", || {
        edit_hosted(world, |hosted| {
            hosted.fracture_handlers.on_break = callback.map(|callback| (callback, user));
            Ok(())
        })
    })
}

/// Sets the function that receives unions that fell into pieces; at the start there is none.
///
/// @param world     the world; any value is safe
/// @param callback  called by ls_world_step; NULL for none
/// @param user      handed back to the callback; must stay valid until another callback is set or the world is destroyed
/// @return LS_OK, a world error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_split_callback_set(world: LsWorld, callback: LsSplitCallback, user: *mut c_void) -> LsResult {
    call("ls_world_split_callback_set", || {
        edit_hosted(world, |hosted| {
            hosted.fracture_handlers.on_split = callback.map(|callback| (callback, user));
            Ok(())
        })
    })
}

/// Joints that broke in the last step, in the order in which they did.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_joint_breaks_get(world: LsWorld, out: *mut *const LsJointBreak, count: *mut usize) -> LsResult {
    call("ls_world_joint_breaks_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, |hosted| hosted.published.broken.get(hosted.world.broken().iter().map(LsJointBreak::from)))
    })
}

/// Unions that fell into pieces in the last step, by their lowest member.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_splits_get(world: LsWorld, out: *mut *const LsSplit, count: *mut usize) -> LsResult {
    call("ls_world_splits_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, |hosted| hosted.published.splits.get(hosted.world.splits().iter().map(LsSplit::from)))
    })
}

/// The pieces of all splits of the last step, split by split.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_pieces_get(world: LsWorld, out: *mut *const LsPiece, count: *mut usize) -> LsResult {
    call("ls_world_pieces_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, |hosted| hosted.published.pieces.get(hosted.world.pieces().iter().map(LsPiece::from)))
    })
}

/// The members of all pieces of the last step, piece by piece.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_piece_bodies_get(world: LsWorld, out: *mut *const LsBody, count: *mut usize) -> LsResult {
    call("ls_world_piece_bodies_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, |hosted| {
            hosted.published.piece_bodies.get(hosted.world.piece_bodies().iter().copied().map(LsBody::from))
        })
    })
}

/// Has joints break in the next step, where a step breaks joints: what ls_world_joint_breaks_get lists on a server makes a client that was
/// in the same state before the step the same after it, bit for bit.
///
/// The part of a handle that says which world it is of is not looked at. Joints that have been destroyed are passed over; lists
/// given before the same step add up.
/// @param world   the world; any value is safe
/// @param joints  count handles
/// @param count   number of handles; 0 is allowed
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_fractures_apply(world: LsWorld, joints: *const LsJoint, count: usize) -> LsResult {
    call("ls_world_fractures_apply", || {
        let joints: Vec<JointId> = host!(slice, joints, count).iter().map(|&joint| joint.into()).collect();
        edit(world, |world| world.apply_fractures(&joints))
    })
}

/// Sets whether and how fast joints break.
///
/// @param world     the world; any value is safe
/// @param settings  read during the call
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_fracture_settings_set(world: LsWorld, settings: *const LsFractureSettings) -> LsResult {
    call("ls_world_fracture_settings_set", || {
        let settings = host!(pointer::read, settings);
        edit(world, |world| world.set_fracture_settings(settings.into()))
    })
}

/// Sets what a joint bears before it breaks.
///
/// @param world     the world; any value is safe
/// @param joint     a joint of that world; any value is safe
/// @param strength  read during the call
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_strength_set(world: LsWorld, joint: LsJoint, strength: *const LsStrength) -> LsResult {
    call("ls_joint_strength_set", || {
        let strength = host!(pointer::read, strength);
        edit(world, |world| world.set_joint_strength(joint.into(), strength.into()))
    })
}

/// What a joint bears at present, against what it can.
///
/// @param world  the world; any value is safe
/// @param joint  a joint of that world; any value is safe
/// @param out    filled on LS_OK
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_stress_get(world: LsWorld, joint: LsJoint, out: *mut LsJointStress, size: usize) -> LsResult {
    call("ls_joint_stress_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write(&world.joint_stress(joint.into())?.into()))
    })
}

/// How close many joints are to breaking.
///
/// @param world   the world; any value is safe
/// @param joints  count handles
/// @param count   number of handles; 0 is allowed
/// @param out     room for count fractions of a limit, 1 breaks, filled on LS_OK in the order of the handles; one bad handle,
///                and none is written
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_shares_get(world: LsWorld, joints: *const LsJoint, count: usize, out: *mut f32) -> LsResult {
    call("ls_joint_shares_get", || {
        let (joints, out) = (host!(slice, joints, count), host!(OutArray::new, out, count));
        read(world, |world| {
            let joints: Vec<JointId> = joints.iter().map(|&joint| joint.into()).collect();
            let mut shares = vec![0.0; joints.len()];
            world.joint_shares_into(&joints, &mut shares)?;
            out.write(shares.into_iter());
            Ok(())
        })
    })
}

/// Joints that bear at least a share of a limit, those closest to breaking first.
///
/// @param world     the world; any value is safe
/// @param least     fraction of a limit from which on they are listed, >= 0; 1 breaks
/// @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of handles that fit
/// @param count     number of joints, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_joints_near_breaking_get(
    world: LsWorld,
    least: f32,
    out: *mut LsJoint,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_world_joints_near_breaking_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| {
            let near = world.joints_near_breaking(least)?;
            buffer.fill(|| near.iter().map(|&(joint, _)| joint.into()))
        })
    })
}

impl From<&JointBreak> for LsJointBreak {
    fn from(broken: &JointBreak) -> Self {
        Self {
            joint: broken.joint.into(),
            user_word: broken.user_word,
            body_a: broken.bodies[0].into(),
            body_b: broken.bodies[1].into(),
            point: broken.point.to_array(),
            step: broken.step,
            force: broken.force.to_array(),
            torque: broken.torque.to_array(),
            share: broken.share,
            limit: from_limit(broken.limit),
            cause: from_cause(broken.cause),
            reserved: 0,
        }
    }
}

impl From<&Split> for LsSplit {
    fn from(split: &Split) -> Self {
        Self {
            first_body: split.first_body.into(),
            center: split.center.to_array(),
            step: split.step,
            body_count: split.body_count,
            mass: split.mass,
            linear_velocity: split.linear_velocity.to_array(),
            anchored: split.anchored.into(),
            first_piece: split.pieces.0,
            piece_count: split.pieces.1 - split.pieces.0,
        }
    }
}

impl From<&Piece> for LsPiece {
    fn from(piece: &Piece) -> Self {
        Self {
            first_body: piece.first_body.into(),
            center: piece.center.to_array(),
            first_member: piece.bodies.0,
            body_count: piece.bodies.1 - piece.bodies.0,
            mass: piece.mass,
            linear_velocity: piece.linear_velocity.to_array(),
            angular_velocity: piece.angular_velocity.to_array(),
            anchored: piece.anchored.into(),
            cut_loose: piece.cut_loose.into(),
            reserved: 0,
        }
    }
}

impl From<JointStress> for LsJointStress {
    fn from(stress: JointStress) -> Self {
        Self {
            force: stress.load.force.to_array(),
            torque: stress.load.torque.to_array(),
            share: stress.share,
            limit: from_limit(stress.limit),
            damage: stress.damage,
        }
    }
}
