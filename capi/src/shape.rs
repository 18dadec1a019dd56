//! Shapes on bodies.

use ls_core::Geometry;

use crate::access::{edit, read};
use crate::boundary::call;
use crate::handle::{LsBody, LsShape, LsWorld};
use crate::pointer::{self, Out, host};
use crate::result::{Failure, LS_ERROR_INDEX_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE, LsResult};
use crate::shape_def::{LsCollisionFilter, LsMaterial, LsShapeDef};
use crate::sized::{self, SizedOut};

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

/// Whether a shape only tells what it overlaps; ls_shape_def_set changes it.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param out    1 if it does, else 0; filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_sensor_get(world: LsWorld, shape: LsShape, out: *mut u32) -> LsResult {
    call("ls_shape_sensor_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.is_sensor(shape.into())?.into()))
    })
}

/// Sets the host's own word of a shape.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param word   any value
/// @return LS_OK, a world error, a handle error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_shape_user_word_set(world: LsWorld, shape: LsShape, word: u64) -> LsResult {
    call("ls_shape_user_word_set", || edit(world, |world| world.set_shape_user_word(shape.into(), word)))
}

/// Surface of a shape.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_material_get(world: LsWorld, shape: LsShape, out: *mut LsMaterial) -> LsResult {
    call("ls_shape_material_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.material(shape.into())?.into()))
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

/// Which other shapes a shape collides with.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_filter_get(world: LsWorld, shape: LsShape, out: *mut LsCollisionFilter) -> LsResult {
    call("ls_shape_filter_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.filter(shape.into())?.into()))
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

/// The definition that a shape has now. It may be changed and given to ls_shape_def_set or ls_shape_attach.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param out    filled on LS_OK; fields that the kind does not name have their defaults. Its arrays are owned by the shape and
///               may be read until the shape is destroyed or given another definition. A compound has its part_count, and
///               NULL for parts: see ls_shape_part_get
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_def_get(world: LsWorld, shape: LsShape, out: *mut LsShapeDef, size: usize) -> LsResult {
    call("ls_shape_def_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write_definition(&(&world.shape_def(shape.into())?).into()))
    })
}

/// One part of a compound shape.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param index  number of the part, from 0
/// @param out    filled on LS_OK with the part's geometry, local_position and local_rotation; the rest has its defaults. Its
///               arrays are owned by the shape, as those of ls_shape_def_get
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_NOT_APPLICABLE (not a
///         compound), LS_ERROR_INDEX_OUT_OF_RANGE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_part_get(
    world: LsWorld,
    shape: LsShape,
    index: usize,
    out: *mut LsShapeDef,
    size: usize,
) -> LsResult {
    call("ls_shape_part_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| {
            let def = world.shape_def(shape.into())?;
            let Geometry::Compound { parts } = def.shape.geometry() else {
                return Err(Failure::Refused(LS_ERROR_NOT_APPLICABLE, "shape", "is not a compound"));
            };
            let beyond = Failure::Refused(LS_ERROR_INDEX_OUT_OF_RANGE, "index", "is not less than the number of parts");
            let (pose, geometry) = parts.get(index).ok_or(beyond)?;
            out.write_definition(&LsShapeDef::of_geometry(geometry, *pose))
        })
    })
}

/// Gives a shape another definition: form, place, surface, density, filter and word. Its handle stays; a body whose mass comes
/// from its shapes is weighed again; what touched the shape wakes.
///
/// @param world  the world; any value is safe
/// @param shape  a shape of that world; any value is safe
/// @param def    filled by ls_shape_def_init or ls_shape_def_get and changed as wanted; read during the call
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
///         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE,
///         LS_ERROR_INDEX_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_def_set(world: LsWorld, shape: LsShape, def: *const LsShapeDef) -> LsResult {
    call("ls_shape_def_set", || {
        let def = host!(sized::read, def);
        // SAFETY: the header asks the host for valid arrays in the definition.
        let def = unsafe { def.to_core() }?;
        edit(world, |world| world.set_shape_def(shape.into(), &def))
    })
}
