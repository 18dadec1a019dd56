//! Questions that a host asks between steps: rays, swept shapes, overlaps, nearest points.

use ls_core::{Pose, RayHit, Shape, ShapeId};

use crate::boundary::call;
use crate::handle::{LsShape, LsWorld};
use crate::math::LsPose;
use crate::pointer::{self, Buffer, Out, OutArray, host, slice, vector};
use crate::query_def::{LsNearestPoint, LsQueryFilter, LsRay, LsRayHit, ask};
use crate::result::{LsResult, Outcome};
use crate::shape_def::LsShapeDef;
use crate::sized;

/// The first shape that a ray meets. A ray that begins inside a solid meets it at once.
///
/// @param world   the world; any value is safe
/// @param ray     read during the call; lengths (m)
/// @param filter  which shapes count; NULL for all
/// @param out     filled on LS_OK; its shape is null if nothing is met
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_ray_cast(
    world: LsWorld,
    ray: *const LsRay,
    filter: *const LsQueryFilter,
    out: *mut LsRayHit,
) -> LsResult {
    call("ls_world_ray_cast", || {
        let (ray, out) = (host!(pointer::read, ray), host!(Out::new, out));
        // SAFETY: the header asks the host for a valid filter or NULL.
        let hit = unsafe { ask(world, filter, |world, filter| world.cast_ray(&ray.into(), filter)) }?;
        out.write(hit.map_or(LsRayHit::NONE, LsRayHit::from))
    })
}

/// Every shape that a ray meets, nearest first, where the ray first meets it.
///
/// @param world     the world; any value is safe
/// @param ray       read during the call; lengths (m)
/// @param filter    which shapes count; NULL for all
/// @param out       room for capacity hits, filled on LS_OK, nearest first; may be NULL if capacity is 0
/// @param capacity  number that fit
/// @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_ray_cast_all(
    world: LsWorld,
    ray: *const LsRay,
    filter: *const LsQueryFilter,
    out: *mut LsRayHit,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_world_ray_cast_all", || {
        let (ray, buffer) = (host!(pointer::read, ray), host!(Buffer::new, out, capacity, count));
        let mut hits = Vec::new();
        // SAFETY: the header asks the host for a valid filter or NULL.
        unsafe { ask(world, filter, |world, filter| world.cast_ray_all(&ray.into(), filter, &mut hits)) }?;
        fill_hits(&buffer, &hits)
    })
}

/// The first shape that each of many rays meets; on the threads of the world, if it has more than one and the rays are many.
///
/// @param world   the world; any value is safe
/// @param rays    count rays, read during the call; lengths (m)
/// @param count   number of rays; 0 is allowed
/// @param filter  which shapes count; NULL for all
/// @param out     room for count hits, filled on LS_OK; the shape of a hit is null if nothing is met
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_rays_cast(
    world: LsWorld,
    rays: *const LsRay,
    count: usize,
    filter: *const LsQueryFilter,
    out: *mut LsRayHit,
) -> LsResult {
    call("ls_world_rays_cast", || {
        let (rays, out) = (host!(slice, rays, count), host!(OutArray::new, out, count));
        let rays: Vec<_> = rays.iter().map(|&ray| ray.into()).collect();
        let mut hits = vec![None; rays.len()];
        // SAFETY: the header asks the host for a valid filter or NULL.
        unsafe { ask(world, filter, |world, filter| world.cast_rays(&rays, filter, &mut hits)) }?;
        out.write(hits.into_iter().map(|hit| hit.map_or(LsRayHit::NONE, LsRayHit::from)));
        Ok(())
    })
}

/// The first shape that a solid meets on a straight path, without turning.
///
/// @param world   the world; any value is safe
/// @param shape   filled by ls_shape_def_init and changed as wanted; its geometry is read during the call; a solid, so no
///                half-space, mesh or height field
/// @param pose    where it starts; local_position and local_rotation of the shape do not count
/// @param path    three floats: how far it goes (m), together at most 1e7
/// @param filter  which shapes count; NULL for all
/// @param out     filled on LS_OK; its shape is null if nothing is met
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[path;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_shape_cast(
    world: LsWorld,
    shape: *const LsShapeDef,
    pose: *const LsPose,
    path: *const f32,
    filter: *const LsQueryFilter,
    out: *mut LsRayHit,
) -> LsResult {
    call("ls_world_shape_cast", || {
        let (path, out) = (host!(vector, path), host!(Out::new, out));
        // SAFETY: the header asks the host for valid pointers.
        let (shape, pose) = unsafe { solid(shape, pose) }?;
        // SAFETY: the header asks the host for a valid filter or NULL.
        let hit = unsafe { ask(world, filter, |world, filter| world.cast_shape(&shape, pose, path, filter)) }?;
        out.write(hit.map_or(LsRayHit::NONE, LsRayHit::from))
    })
}

/// Every shape that a solid meets on a straight path, without turning, nearest first.
///
/// @param world     the world; any value is safe
/// @param shape     filled by ls_shape_def_init and changed as wanted; as in ls_world_shape_cast
/// @param pose      where it starts
/// @param path      three floats: how far it goes (m), together at most 1e7
/// @param filter    which shapes count; NULL for all
/// @param out       room for capacity hits, filled on LS_OK, nearest first; may be NULL if capacity is 0
/// @param capacity  number that fit
/// @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[path;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_shape_cast_all(
    world: LsWorld,
    shape: *const LsShapeDef,
    pose: *const LsPose,
    path: *const f32,
    filter: *const LsQueryFilter,
    out: *mut LsRayHit,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_world_shape_cast_all", || {
        let (path, buffer) = (host!(vector, path), host!(Buffer::new, out, capacity, count));
        // SAFETY: the header asks the host for valid pointers.
        let (shape, pose) = unsafe { solid(shape, pose) }?;
        let mut hits = Vec::new();
        // SAFETY: the header asks the host for a valid filter or NULL.
        unsafe { ask(world, filter, |world, filter| world.cast_shape_all(&shape, pose, path, filter, &mut hits)) }?;
        fill_hits(&buffer, &hits)
    })
}

/// Every shape that a solid overlaps or touches, in a fixed order.
///
/// @param world     the world; any value is safe
/// @param shape     filled by ls_shape_def_init and changed as wanted; as in ls_world_shape_cast
/// @param pose      where it is; positions (m)
/// @param filter    which shapes count; NULL for all
/// @param out       room for capacity shapes, filled on LS_OK, in a fixed order; may be NULL if capacity is 0
/// @param capacity  number that fit
/// @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_shape_overlaps_get(
    world: LsWorld,
    shape: *const LsShapeDef,
    pose: *const LsPose,
    filter: *const LsQueryFilter,
    out: *mut LsShape,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_world_shape_overlaps_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        // SAFETY: the header asks the host for valid pointers.
        let (shape, pose) = unsafe { solid(shape, pose) }?;
        let mut shapes = Vec::new();
        // SAFETY: the header asks the host for a valid filter or NULL.
        unsafe { ask(world, filter, |world, filter| world.overlap_shape(&shape, pose, filter, &mut shapes)) }?;
        fill_shapes(&buffer, &shapes)
    })
}

/// Every shape whose world box meets a box, in a fixed order; cheaper than ls_world_shape_overlaps_get and less exact.
///
/// @param world     the world; any value is safe
/// @param min       three doubles: the least corner (m)
/// @param max       three doubles: the greatest corner (m)
/// @param filter    which shapes count; NULL for all
/// @param out       room for capacity shapes, filled on LS_OK, in a fixed order; may be NULL if capacity is 0
/// @param capacity  number that fit
/// @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[min;3]; [max;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_box_overlaps_get(
    world: LsWorld,
    min: *const f64,
    max: *const f64,
    filter: *const LsQueryFilter,
    out: *mut LsShape,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_world_box_overlaps_get", || {
        let (min, max) = (host!(pointer::point, min), host!(pointer::point, max));
        let buffer = host!(Buffer::new, out, capacity, count);
        let mut shapes = Vec::new();
        // SAFETY: the header asks the host for a valid filter or NULL.
        unsafe { ask(world, filter, |world, filter| world.overlap_box(min, max, filter, &mut shapes)) }?;
        fill_shapes(&buffer, &shapes)
    })
}

/// The shape nearest to a point.
///
/// @param world         the world; any value is safe
/// @param point         three doubles (m)
/// @param max_distance  how far to look (m), 0 to 1e7
/// @param filter        which shapes count; NULL for all
/// @param out           filled on LS_OK; its shape is null if there is none
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[point;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_nearest_point_get(
    world: LsWorld,
    point: *const f64,
    max_distance: f32,
    filter: *const LsQueryFilter,
    out: *mut LsNearestPoint,
) -> LsResult {
    call("ls_world_nearest_point_get", || {
        let (point, out) = (host!(pointer::point, point), host!(Out::new, out));
        // SAFETY: the header asks the host for a valid filter or NULL.
        let nearest = unsafe { ask(world, filter, |world, filter| world.nearest_point(point, max_distance, filter)) }?;
        out.write(nearest.map_or(LsNearestPoint::NONE, LsNearestPoint::from))
    })
}

/// # Safety
/// The pointers are null or valid, as those of a shape definition.
pub(crate) unsafe fn solid(shape: *const LsShapeDef, pose: *const LsPose) -> Outcome<(Shape, Pose)> {
    // SAFETY: as promised to this function.
    let (shape, pose) = unsafe { (solid_of(shape)?, pointer::read(pose, "pose")?) };
    Ok((shape, pose.into()))
}

/// # Safety
/// The pointer is null or valid, as that of a shape definition.
pub(crate) unsafe fn solid_of(shape: *const LsShapeDef) -> Outcome<Shape> {
    // SAFETY: as promised to this function.
    Ok(unsafe { sized::read(shape, "shape")?.to_core() }?.shape)
}

fn fill_hits(buffer: &Buffer<LsRayHit>, hits: &[RayHit]) -> Outcome<()> {
    buffer.fill(|| hits.iter().map(|&hit| hit.into()))
}

fn fill_shapes(buffer: &Buffer<LsShape>, shapes: &[ShapeId]) -> Outcome<()> {
    buffer.fill(|| shapes.iter().map(|&shape| shape.into()))
}
