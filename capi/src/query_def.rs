//! What a question to a world is about, and what the answer is, as C describes them.

use std::ffi::c_void;
use std::ptr;

use ls_core::glam::{DVec3, Vec3};
use ls_core::{BodyId, CollisionFilter, NearestPoint, QueryFilter, Ray, RayHit, ShapeId, World};

use crate::access::read;
use crate::boundary::call;
use crate::enums;
use crate::float_environment::as_host;
use crate::handle::{LsBody, LsShape, LsWorld};
use crate::pointer::{host, slice};
use crate::result::{LsResult, Outcome};
use crate::sized::{Definition, SizedOut, Versioned};

/// Query kinds: shapes of static bodies count.
pub const LS_QUERY_STATIC: u32 = 1;
/// Query kinds: shapes of kinematic bodies count.
pub const LS_QUERY_KINEMATIC: u32 = 2;
/// Query kinds: shapes of dynamic bodies count.
pub const LS_QUERY_DYNAMIC: u32 = 4;

/// Has the last word on a shape whose box a query meets.
///
/// Called during the query under the host's floating-point settings, in any order, in ls_world_rays_cast on any thread of the
/// world. It must return normally (no exception, no longjmp). Inside it, reads of the world work; edits return
/// LS_ERROR_WORLD_BUSY.
/// @param shape  the shape
/// @param user   as given in the filter
/// @return not 0 if the shape counts
pub type LsQueryCallback = Option<unsafe extern "C" fn(shape: LsShape, user: *mut c_void) -> u32>;

/// Which shapes a query is about. Fill it with ls_query_filter_init first; where a filter is asked for, NULL means everything.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsQueryFilter {
    /// Size of this struct in the host, set by ls_query_filter_init.
    pub struct_size: u32,
    /// Bit set of groups the query belongs to, as if it were a shape; default all.
    pub member_of: u32,
    /// Bit set of groups the query meets; default all.
    pub collides_with: u32,
    /// Bit set of LS_QUERY_ constants: which kinds of body count; default all.
    pub kinds: u32,
    /// Bodies that do not count; any handles are allowed. Default none.
    pub ignored: *const LsBody,
    /// Number of bodies that do not count.
    pub ignored_count: usize,
    /// Has the last word on each shape; default NULL.
    pub accept: LsQueryCallback,
    /// Handed back to the callback.
    pub user: *mut c_void,
}

// SAFETY: numbers, raw pointers and a function pointer (null is none) without padding.
unsafe impl Versioned for LsQueryFilter {
    const SIZES: &'static [usize] = &[48];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsQueryFilter {}

impl Default for LsQueryFilter {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            member_of: u32::MAX,
            collides_with: u32::MAX,
            kinds: LS_QUERY_STATIC | LS_QUERY_KINEMATIC | LS_QUERY_DYNAMIC,
            ignored: ptr::null(),
            ignored_count: 0,
            accept: None,
            user: ptr::null_mut(),
        }
    }
}

/// Fills a query filter with defaults: every shape counts.
///
/// @param filter  filled on LS_OK
/// @param size    sizeof *filter as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_query_filter_init(filter: *mut LsQueryFilter, size: usize) -> LsResult {
    call("ls_query_filter_init", || host!(SizedOut::new, filter, size).write_definition(&LsQueryFilter::default()))
}

/// A half-line of some length. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsRay {
    /// Where it begins (m).
    pub origin: [f64; 3],
    /// Unit direction; up to 1 % off unit length is normalised, more is refused.
    pub direction: [f32; 3],
    /// How far it goes (m), 0 to 1e7.
    pub length: f32,
}

/// Where a ray or a swept shape first meets a shape. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsRayHit {
    /// The shape that is met; null if nothing is.
    pub shape: LsShape,
    /// Its body.
    pub body: LsBody,
    /// Where (m), on the surface of the shape that is met.
    pub point: [f64; 3],
    /// Outward unit normal of that surface; where a solid overlaps it from the start, the shortest way out. Of a ray that begins
    /// inside a solid, against the ray.
    pub normal: [f32; 3],
    /// How far along the ray or sweep (m); 0 where the two overlap or touch from the start.
    pub distance: f32,
}

/// The nearest point of a shape to a point. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsNearestPoint {
    /// The shape; null if there is none.
    pub shape: LsShape,
    /// Its body.
    pub body: LsBody,
    /// Its nearest point (m): the point asked about, if that lies inside.
    pub point: [f64; 3],
    /// How far that is (m); 0 inside.
    pub distance: f32,
    /// Not used; 0.
    pub reserved: u32,
}

impl LsRayHit {
    pub(crate) const NONE: Self =
        Self { shape: LsShape { id: 0 }, body: LsBody::NULL, point: [0.0; 3], normal: [0.0; 3], distance: 0.0 };
}

impl LsNearestPoint {
    pub(crate) const NONE: Self =
        Self { shape: LsShape { id: 0 }, body: LsBody::NULL, point: [0.0; 3], distance: 0.0, reserved: 0 };
}

impl From<LsRay> for Ray {
    fn from(ray: LsRay) -> Self {
        Self { origin: DVec3::from_array(ray.origin), direction: Vec3::from_array(ray.direction), length: ray.length }
    }
}

impl From<RayHit> for LsRayHit {
    fn from(hit: RayHit) -> Self {
        Self {
            shape: hit.shape.into(),
            body: hit.body.into(),
            point: hit.point.to_array(),
            normal: hit.normal.to_array(),
            distance: hit.distance as f32,
        }
    }
}

impl From<NearestPoint> for LsNearestPoint {
    fn from(nearest: NearestPoint) -> Self {
        Self {
            shape: nearest.shape.into(),
            body: nearest.body.into(),
            point: nearest.point.to_array(),
            distance: nearest.distance as f32,
            reserved: 0,
        }
    }
}

/// A callback of the host and its own pointer.
#[derive(Clone, Copy)]
struct Accept {
    callback: unsafe extern "C" fn(LsShape, *mut c_void) -> u32,
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back, and the header says on which threads.
unsafe impl Sync for Accept {}

impl Accept {
    fn ask(&self, shape: ShapeId) -> bool {
        let mut answer = 0;
        // SAFETY: the host promised a function of this type that accepts its own pointer.
        as_host(|| answer = unsafe { (self.callback)(shape.into(), self.user) });
        answer != 0
    }
}

/// Asks a world a question under a filter of the host.
///
/// # Safety
/// `filter` is null, or valid for reading as many bytes as its `struct_size` says, with a valid array of ignored bodies.
pub(crate) unsafe fn ask<R>(
    world: LsWorld,
    filter: *const LsQueryFilter,
    question: impl FnOnce(&World, &QueryFilter) -> ls_core::Result<R>,
) -> Outcome<R> {
    // SAFETY: as promised to this function.
    read(world, |world| unsafe { filtered(filter, |filter| Ok(question(world, filter)?)) })
}

/// Runs a query under a filter of the host.
///
/// # Safety
/// `filter` is null, or valid for reading as many bytes as its `struct_size` says, with a valid array of ignored bodies.
unsafe fn filtered<R>(filter: *const LsQueryFilter, work: impl FnOnce(&QueryFilter) -> Outcome<R>) -> Outcome<R> {
    if filter.is_null() {
        return work(&QueryFilter::default());
    }
    // SAFETY: as promised to this function.
    let filter = unsafe { crate::sized::read(filter, "filter") }?;
    if filter.kinds & !(LS_QUERY_STATIC | LS_QUERY_KINEMATIC | LS_QUERY_DYNAMIC) != 0 {
        return Err(enums::unknown("filter.kinds"));
    }
    // SAFETY: as promised to this function.
    let ignored = unsafe { slice(filter.ignored, filter.ignored_count, "filter.ignored") }?;
    let ignored: Vec<BodyId> = ignored.iter().map(|&body| body.into()).collect();
    let accept = filter.accept.map(|callback| Accept { callback, user: filter.user });
    let ask = accept.map(|accept| move |shape| accept.ask(shape));
    work(&QueryFilter {
        groups: CollisionFilter { member_of: filter.member_of, collides_with: filter.collides_with },
        fixed: filter.kinds & LS_QUERY_STATIC != 0,
        kinematic: filter.kinds & LS_QUERY_KINEMATIC != 0,
        dynamic: filter.kinds & LS_QUERY_DYNAMIC != 0,
        ignored: &ignored,
        accept: ask.as_ref().map(|ask| ask as &(dyn Fn(ShapeId) -> bool + Sync)),
    })
}
