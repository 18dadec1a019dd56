//! Bodies: create, destroy, and what belongs to one.

use crate::access::{edit, read};
use crate::body_def::LsBodyDef;
use crate::boundary::call;
use crate::enums;
use crate::handle::{LsBody, LsJoint, LsShape, LsWorld};
use crate::pointer::{Buffer, Out, host};
use crate::result::LsResult;
use crate::sized;

/// Creates a body.
///
/// @param world  the world; any value is safe
/// @param def    filled by ls_body_def_init and changed as wanted; read during the call
/// @param out    the body, on LS_OK; the world owns it
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_INDEX_OUT_OF_RANGE,
///         LS_ERROR_NOT_APPLICABLE, LS_ERROR_CAPACITY_EXCEEDED
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_create(world: LsWorld, def: *const LsBodyDef, out: *mut LsBody) -> LsResult {
    call("ls_body_create", || {
        let (def, out) = (host!(sized::read, def), host!(Out::new, out));
        // SAFETY: the header asks the host for valid arrays in the definition.
        let def = unsafe { def.to_core() }?;
        out.write(edit(world, |world| world.create_body(&def))?.into())
    })
}

/// Destroys a body with its shapes and joints, and wakes what touched it.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @return LS_OK, a world error, a handle error, LS_ERROR_ALREADY_DESTROYED
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_destroy(world: LsWorld, body: LsBody) -> LsResult {
    call("ls_body_destroy", || edit(world, |world| world.destroy_body(body.into())))
}

/// LS_BODY_ constant of a body.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_kind_get(world: LsWorld, body: LsBody, out: *mut i32) -> LsResult {
    call("ls_body_kind_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(enums::from_body_kind(world.body_kind(body.into())?)))
    })
}

/// Makes a body static, kinematic or dynamic, and wakes it and what it touches.
///
/// A body that becomes static stops; one that becomes dynamic has the mass that it was made with or given. A joint none of whose bodies is
/// dynamic, as of a ragdoll that an animation moves, is idle: it holds nothing, bears nothing and tells its coordinates, until one is again.
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param kind   LS_BODY_ constant
/// @return LS_OK, a world error, a handle error, LS_ERROR_INVALID_ENUM, LS_ERROR_OUT_OF_RANGE (it would have no mass),
///         LS_ERROR_NOT_APPLICABLE (a shape cannot be on a dynamic body)
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_kind_set(world: LsWorld, body: LsBody, kind: i32) -> LsResult {
    call("ls_body_kind_set", || {
        let kind = enums::body_kind(kind)?;
        edit(world, |world| world.set_body_kind(body.into(), kind))
    })
}

/// The host's own word of a body.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_user_word_get(world: LsWorld, body: LsBody, out: *mut u64) -> LsResult {
    call("ls_body_user_word_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.user_word(body.into())?))
    })
}

/// Sets the host's own word of a body.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param word   any value
/// @return LS_OK, a world error, a handle error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_user_word_set(world: LsWorld, body: LsBody, word: u64) -> LsResult {
    call("ls_body_user_word_set", || edit(world, |world| world.set_user_word(body.into(), word)))
}

/// All shapes of a body.
///
/// @param world     the world; any value is safe
/// @param body      a body of that world; any value is safe
/// @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of handles that fit
/// @param count     number of shapes, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_shapes_get(
    world: LsWorld,
    body: LsBody,
    out: *mut LsShape,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_body_shapes_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| {
            let shapes = world.body_shapes(body.into())?;
            buffer.fill(|| shapes.iter().copied().map(LsShape::from))
        })
    })
}

/// All joints of a body.
///
/// @param world     the world; any value is safe
/// @param body      a body of that world; any value is safe
/// @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of handles that fit
/// @param count     number of joints, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_joints_get(
    world: LsWorld,
    body: LsBody,
    out: *mut LsJoint,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_body_joints_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| {
            let joints = world.body_joints(body.into())?;
            buffer.fill(|| joints.iter().copied().map(LsJoint::from))
        })
    })
}
