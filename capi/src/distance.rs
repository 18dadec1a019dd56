//! Nearest points of two shapes, or how deep they overlap.

use ls_core::Distance;

use crate::access::read;
use crate::boundary::call;
use crate::cast::LS_NO_INDEX;
use crate::handle::{LsShape, LsWorld};
use crate::math::LsPose;
use crate::pointer::{Out, host};
use crate::query::solid;
use crate::query_def::{LsQueryFilter, ask};
use crate::result::LsResult;
use crate::shape_def::LsShapeDef;

/// How far two shapes are apart, or how deep they overlap. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsShapeDistance {
    /// The first shape; null if there is none.
    pub shape_a: LsShape,
    /// The second shape; null from ls_world_nearest_shape_get, whose second shape is not one of the world's.
    pub shape_b: LsShape,
    /// World position of the nearest point of the first, or of its deepest where they overlap (m).
    pub point_a: [f64; 3],
    /// World position of the nearest point of the second, or of its deepest (m).
    pub point_b: [f64; 3],
    /// Distance (m); negative is the least depth by which they overlap.
    pub distance: f64,
    /// Unit vector from the first to the second: moving the second along it by the depth parts them.
    pub normal: [f32; 3],
    /// Part of a compound that the first point is on; LS_NO_INDEX of any other shape.
    pub part_a: u32,
    /// The same of the second point.
    pub part_b: u32,
    /// Triangle of a mesh or height field that the first point is on, numbered as in LsCastHit; LS_NO_INDEX of any other shape.
    pub triangle_a: u32,
    /// The same of the second point.
    pub triangle_b: u32,
    /// Not used; 0.
    pub reserved: u32,
}

impl LsShapeDistance {
    const NONE: Self = Self {
        shape_a: LsShape { id: 0 },
        shape_b: LsShape { id: 0 },
        point_a: [0.0; 3],
        point_b: [0.0; 3],
        distance: 0.0,
        normal: [0.0; 3],
        part_a: LS_NO_INDEX,
        part_b: LS_NO_INDEX,
        triangle_a: LS_NO_INDEX,
        triangle_b: LS_NO_INDEX,
        reserved: 0,
    };

    fn between(shape_a: LsShape, shape_b: LsShape, distance: &Distance) -> Self {
        let index = |number: Option<u32>| number.unwrap_or(LS_NO_INDEX);
        Self {
            shape_a,
            shape_b,
            point_a: distance.point_a.to_array(),
            point_b: distance.point_b.to_array(),
            distance: distance.distance,
            normal: distance.normal.to_array(),
            part_a: index(distance.parts[0]),
            part_b: index(distance.parts[1]),
            triangle_a: index(distance.triangles[0]),
            triangle_b: index(distance.triangles[1]),
            reserved: 0,
        }
    }
}

/// How far two shapes of a world are apart, or how deep they overlap. Sensors and shapes of one body count too. Where a mesh
/// or a height field is overlapped, the depth is that of the triangle that is overlapped deepest.
///
/// @param world  the world; any value is safe
/// @param a      the first; any value is safe
/// @param b      the second; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_APPLICABLE (both are half-spaces)
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_shape_distance_get(
    world: LsWorld,
    a: LsShape,
    b: LsShape,
    out: *mut LsShapeDistance,
) -> LsResult {
    call("ls_world_shape_distance_get", || {
        let out = host!(Out::new, out);
        read(world, |world| {
            let distance = world.shape_distance(a.into(), b.into())?;
            out.write(LsShapeDistance::between(a, b, &distance))
        })
    })
}

/// The shape nearest to a solid, or the one that it overlaps deepest: shape_a; shape_b is null.
///
/// @param world         the world; any value is safe
/// @param shape         filled by ls_shape_def_init and changed as wanted; as in ls_world_shape_cast
/// @param pose          where it is; positions (m)
/// @param max_distance  how far to look (m), 0 to 1e7
/// @param filter        which shapes count; NULL for all
/// @param out           filled on LS_OK; its shape_a is null if there is none
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_nearest_shape_get(
    world: LsWorld,
    shape: *const LsShapeDef,
    pose: *const LsPose,
    max_distance: f32,
    filter: *const LsQueryFilter,
    out: *mut LsShapeDistance,
) -> LsResult {
    call("ls_world_nearest_shape_get", || {
        let out = host!(Out::new, out);
        // SAFETY: the header asks the host for valid pointers.
        let (shape, pose) = unsafe { solid(shape, pose) }?;
        // SAFETY: the header asks the host for a valid filter or NULL.
        let found = unsafe { ask(world, filter, |world, filter| world.nearest_shape(&shape, pose, max_distance, filter)) }?;
        let none = LsShape { id: 0 };
        out.write(
            found.map_or(LsShapeDistance::NONE, |found| LsShapeDistance::between(found.shape.into(), none, &found.distance)),
        )
    })
}
