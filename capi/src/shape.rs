//! Shapes on bodies.

use crate::access::{edit, read};
use crate::boundary::call;
use crate::handle::{LsBody, LsShape, LsWorld};
use crate::pointer::{self, Out, host};
use crate::result::LsResult;
use crate::shape_def::{LsCollisionFilter, LsMaterial, LsShapeDef};
use crate::sized;

/// Attaches a new shape to a body; a body whose mass comes from its shapes is weighed again.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param def    filled by ls_shape_def_init and changed as wanted; read during the call
/// @param out    the shape, on LS_OK; the body owns it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
///         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE,
///         LS_ERROR_INDEX_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE, LS_ERROR_CAPACITY_EXCEEDED
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_attach(world: LsWorld, body: LsBody, def: *const LsShapeDef, out: *mut LsShape) -> LsResult {
    call("ls_shape_attach", || {
        let (def, out) = (host!(sized::read, def), host!(Out::new, out));
        // SAFETY: the header asks the host for valid arrays in the definition.
        let def = unsafe { def.to_core() }?;
        out.write(edit(world, |world| world.attach_shape(body.into(), &def))?.into())
    })
}

/// Takes a shape off its body; a body whose mass comes from its shapes is weighed again.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @return LS_OK, a world error, a handle error, LS_ERROR_ALREADY_DESTROYED, LS_ERROR_OUT_OF_RANGE (a dynamic
///         body would be left without mass)
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_shape_destroy(world: LsWorld, shape: LsShape) -> LsResult {
    call("ls_shape_destroy", || edit(world, |world| world.destroy_shape(shape.into())))
}

/// Body that a shape is on.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_body_get(world: LsWorld, shape: LsShape, out: *mut LsBody) -> LsResult {
    call("ls_shape_body_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.shape_body(shape.into())?.into()))
    })
}

/// The host's own word of a shape.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_user_word_get(world: LsWorld, shape: LsShape, out: *mut u64) -> LsResult {
    call("ls_shape_user_word_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.shape_user_word(shape.into())?))
    })
}

/// Sets the surface of a shape.
///
/// @param world     the world; any value is safe
/// @param shape     a shape of that world; any value is safe
/// @param material  read during the call
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_INVALID_ENUM,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_material_set(world: LsWorld, shape: LsShape, material: *const LsMaterial) -> LsResult {
    call("ls_shape_material_set", || {
        let material = host!(pointer::read, material).try_into()?;
        edit(world, |world| world.set_material(shape.into(), material))
    })
}

/// Sets which other shapes a shape collides with.
///
/// @param world   the world; any value is safe
/// @param shape   a shape of that world; any value is safe
/// @param filter  read during the call
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_filter_set(world: LsWorld, shape: LsShape, filter: *const LsCollisionFilter) -> LsResult {
    call("ls_shape_filter_set", || {
        let filter = host!(pointer::read, filter);
        edit(world, |world| world.set_filter(shape.into(), filter.into()))
    })
}
