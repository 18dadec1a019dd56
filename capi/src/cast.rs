//! Casts with all that is known of a hit: rays, swept solids, solids that turn on their way.

use std::ptr;

use ls_core::glam::{DVec3, Vec3};
use ls_core::{Cast, RayHit, Shape};

use crate::boundary::call;
use crate::handle::{LsBody, LsShape, LsWorld};
use crate::math::LsPose;
use crate::pointer::{Buffer, Out, host};
use crate::query::solid_of;
use crate::query_def::{LsQueryFilter, ask};
use crate::result::{LsResult, Outcome};
use crate::shape_def::LsShapeDef;
use crate::sized::{self, Definition, SizedOut, Versioned};

/// Part or triangle of a shape that has none.
pub const LS_NO_INDEX: u32 = u32::MAX;

/// What is cast: a solid or a point on a straight path, with or without a turn. Fill it with ls_cast_def_init first.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsCastDef {
    /// Size of this struct in the host, set by ls_cast_def_init.
    pub struct_size: u32,
    /// Not 0: leaves out what is overlapped or touched at the start; of a mesh, a height field or a compound those triangles or
    /// parts alone. Default 0.
    pub ignore_overlapped: u32,
    /// A solid, so no half-space, mesh or height field; of it, only its geometry is read. Default NULL: a point, whose way is a
    /// ray.
    pub shape: *const LsShapeDef,
    /// Where it begins; default the origin.
    pub pose: LsPose,
    /// How far its origin goes (m), together at most 1e7; default zero.
    pub path: [f64; 3],
    /// How far a solid turns about its origin on the way, evenly: axis times angle (rad), at most 100.6 together; default zero.
    pub turn: [f32; 3],
    /// Not used; 0.
    pub reserved: u32,
}

// SAFETY: numbers and a raw pointer without padding.
unsafe impl Versioned for LsCastDef {
    const SIZES: &'static [usize] = &[96];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsCastDef {}

impl Default for LsCastDef {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            ignore_overlapped: 0,
            shape: ptr::null(),
            pose: LsPose { position: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0] },
            path: [0.0; 3],
            turn: [0.0; 3],
            reserved: 0,
        }
    }
}

impl LsCastDef {
    /// The solid that is cast, if it is one.
    ///
    /// # Safety
    /// Its pointer is null, or valid as that of a shape definition.
    unsafe fn shape(&self) -> Outcome<Option<Shape>> {
        // SAFETY: as promised to this function.
        if self.shape.is_null() { Ok(None) } else { unsafe { solid_of(self.shape) }.map(Some) }
    }

    fn cast<'a>(&self, shape: Option<&'a Shape>) -> Cast<'a> {
        Cast {
            shape,
            pose: self.pose.into(),
            path: DVec3::from_array(self.path),
            turn: Vec3::from_array(self.turn),
            ignore_overlapped: self.ignore_overlapped != 0,
        }
    }
}

/// Where a cast first meets a shape. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsCastHit {
    /// The shape that is met; null if nothing is.
    pub shape: LsShape,
    /// Its body.
    pub body: LsBody,
    /// Where (m), on the surface of the shape that is met; where a ray begins, if that is inside a solid.
    pub point: [f64; 3],
    /// Outward unit normal of that surface; where a solid overlaps it from the start, the shortest way out. Of a ray that begins
    /// inside a solid, against the ray.
    pub normal: [f32; 3],
    /// Part of a compound that is met; LS_NO_INDEX of any other shape.
    pub part: u32,
    /// How far along the path (m); 0 where the two overlap or touch from the start.
    pub distance: f64,
    /// The same as a fraction of the whole way, 0 to 1: it tells how far a turn has got.
    pub fraction: f64,
    /// How deep a solid overlaps the shape from the start, along the normal (m); else 0.
    pub depth: f64,
    /// Triangle of a mesh that is met, as the host numbered them, or of a height field: 2 * (row * (columns - 1) + column) for
    /// the triangle at the cell's own height, and 1 more for the one across. LS_NO_INDEX of any other shape.
    pub triangle: u32,
    /// Not used; 0.
    pub reserved: u32,
}

impl LsCastHit {
    const NONE: Self = Self {
        shape: LsShape { id: 0 },
        body: LsBody::NULL,
        point: [0.0; 3],
        normal: [0.0; 3],
        part: LS_NO_INDEX,
        distance: 0.0,
        fraction: 0.0,
        depth: 0.0,
        triangle: LS_NO_INDEX,
        reserved: 0,
    };
}

impl From<RayHit> for LsCastHit {
    fn from(hit: RayHit) -> Self {
        Self {
            shape: hit.shape.into(),
            body: hit.body.into(),
            point: hit.point.to_array(),
            normal: hit.normal.to_array(),
            part: hit.part.unwrap_or(LS_NO_INDEX),
            distance: hit.distance,
            fraction: hit.fraction,
            depth: hit.depth,
            triangle: hit.triangle.unwrap_or(LS_NO_INDEX),
            reserved: 0,
        }
    }
}

/// Fills the definition of a cast with defaults: a ray of no length from the origin.
///
/// @param def   filled on LS_OK
/// @param size  sizeof *def as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_cast_def_init(def: *mut LsCastDef, size: usize) -> LsResult {
    call("ls_cast_def_init", || host!(SizedOut::new, def, size).write_definition(&LsCastDef::default()))
}

/// The first shape that a solid or a point meets on its way, with the part and the triangle that it meets.
///
/// @param world   the world; any value is safe
/// @param def     filled by ls_cast_def_init and changed as wanted; read during the call
/// @param filter  which shapes count; NULL for all
/// @param out     filled on LS_OK; its shape is null if nothing is met
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_cast(
    world: LsWorld,
    def: *const LsCastDef,
    filter: *const LsQueryFilter,
    out: *mut LsCastHit,
) -> LsResult {
    call("ls_world_cast", || {
        let (def, out) = (host!(sized::read, def), host!(Out::new, out));
        // SAFETY: the header asks the host for a valid shape or NULL.
        let shape = unsafe { def.shape() }?;
        // SAFETY: the header asks the host for a valid filter or NULL.
        let hit = unsafe { ask(world, filter, |world, filter| world.cast(&def.cast(shape.as_ref()), filter)) }?;
        out.write(hit.map_or(LsCastHit::NONE, LsCastHit::from))
    })
}

/// Every shape that a solid or a point meets on its way, nearest first, where it first meets it.
///
/// @param world     the world; any value is safe
/// @param def       filled by ls_cast_def_init and changed as wanted; read during the call
/// @param filter    which shapes count; NULL for all
/// @param out       room for capacity hits, filled on LS_OK, nearest first; may be NULL if capacity is 0
/// @param capacity  number that fit
/// @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_cast_all(
    world: LsWorld,
    def: *const LsCastDef,
    filter: *const LsQueryFilter,
    out: *mut LsCastHit,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_world_cast_all", || {
        let (def, buffer) = (host!(sized::read, def), host!(Buffer::new, out, capacity, count));
        // SAFETY: the header asks the host for a valid shape or NULL.
        let shape = unsafe { def.shape() }?;
        let mut hits = Vec::new();
        // SAFETY: the header asks the host for a valid filter or NULL.
        unsafe { ask(world, filter, |world, filter| world.cast_all(&def.cast(shape.as_ref()), filter, &mut hits)) }?;
        buffer.fill(|| hits.iter().map(|&hit| hit.into()))
    })
}
