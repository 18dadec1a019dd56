//! Questions about where things are: rays, swept shapes, overlaps, nearest points.
//!
//! A query is answered in two stages. The broad phase finds the shapes whose kept box the query's region meets; here those
//! shapes are looked at, in double precision and in world axes about the query's own origin, so that a millimetre and ten
//! kilometres are alike. Answers are sorted by distance, then by shape, so they do not depend on the form of the tree.
//!
//! ```text
//! exact.rs ─┬─ parts.rs: the parts of compounds, meshes and height fields that a path may meet
//!           ├─ ray.rs: a ray and a convex part, in closed form
//!           ├─ cast.rs: a moving part and another, by advancing to where their gap can have closed
//!           └─ gap.rs: signed distance of two parts ── gjk.rs (apart), epa.rs (overlapping)
//! ```
//!
//! parry3d serves as a tree of boxes only: its own queries have absolute tolerances and single precision.

use glam::{DVec3, Vec3};

use crate::body::BodyKind;
use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::id::{BodyId, ShapeId};
use crate::pose::Pose;
use crate::shape::{CollisionFilter, Shape};

mod cast;
mod epa;
mod exact;
mod gap;
mod gjk;
mod part;
mod parts;
mod ray;
mod region;

pub(crate) use exact::{
    BodyShape, Met, Sweep, distance_between, distance_to, first_on_ray, first_on_sweep, nearest_point, overlaps, probe_box,
    shapes_overlap,
};
pub(crate) use region::PathSegment;

/// Longest ray or sweep, and greatest distance that is searched (m).
pub const MAX_QUERY_LENGTH: f32 = 1.0e7;

/// Greatest turn of a cast (rad): 16 revolutions.
pub const MAX_CAST_TURN: f32 = 100.6;

/// A half-line of some length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it begins (m).
    pub origin: DVec3,
    /// Unit direction.
    pub direction: Vec3,
    /// How far it goes (m), 0 to 1e7.
    pub length: f32,
}

impl Ray {
    /// The ray from one point to another (m); points that coincide make one of no length.
    pub fn between(from: DVec3, to: DVec3) -> Self {
        let path = to - from;
        let length = path.length();
        let direction = if length > 0.0 { (path / length).as_vec3() } else { Vec3::X };
        Self { origin: from, direction, length: length as f32 }
    }

    pub(crate) fn checked(self) -> Result<PathSegment> {
        Ok(PathSegment {
            origin: check::position("origin", self.origin)?,
            direction: check::direction("direction", self.direction)?.as_dvec3().normalize(),
            length: f64::from(query_length("length", self.length)?),
            half: DVec3::ZERO,
        })
    }
}

/// Where a ray or a swept shape first meets a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// The shape that is met.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Where (m): on the surface of the shape that is met. For a ray that begins inside a solid, where it begins.
    pub point: DVec3,
    /// Outward unit normal of that surface; where a solid overlaps it from the start, the shortest way out. For a ray that
    /// begins inside a solid, against the ray.
    pub normal: Vec3,
    /// How far along the ray or sweep (m); 0 where the two overlap or touch from the start.
    pub distance: f64,
    /// The same as a share of the whole way, 0 to 1: it tells where a turn has got to.
    pub fraction: f64,
    /// How deep a swept solid overlaps the shape from the start, along the normal (m); else 0.
    pub depth: f64,
    /// Which part of a compound is met.
    pub part: Option<u32>,
    /// Which triangle of a mesh is met, as the host numbered them, or of a height field: 2 (row (columns − 1) + column) for the
    /// one at the cell's own post, 1 more for the one across.
    pub triangle: Option<u32>,
}

/// A solid, or a point, on its way: a straight path, with or without a turn.
#[derive(Debug, Clone, Copy)]
pub struct Cast<'a> {
    /// What moves: a solid; none is a point, whose way is a ray.
    pub shape: Option<&'a Shape>,
    /// Where it begins.
    pub pose: Pose,
    /// How far its origin goes (m), together at most 1e7.
    pub path: DVec3,
    /// How far a solid turns about its origin on the way, evenly: axis times angle (rad), at most 100.6.
    pub turn: Vec3,
    /// Whether what it overlaps or touches from the start is left out: of a mesh, a height field or a compound those triangles
    /// or parts alone.
    pub ignore_overlapped: bool,
}

/// A cast whose numbers have been checked.
pub(crate) enum Way<'a> {
    Ray(PathSegment),
    Sweep(Sweep<'a>),
}

impl<'a> Cast<'a> {
    /// A solid on a straight path (m), without turning.
    pub fn new(shape: &'a Shape, pose: Pose, path: DVec3) -> Self {
        Self { shape: Some(shape), pose, path, turn: Vec3::ZERO, ignore_overlapped: false }
    }

    /// A ray (m).
    pub fn ray(origin: DVec3, path: DVec3) -> Self {
        Self { shape: None, pose: Pose::at(origin), path, turn: Vec3::ZERO, ignore_overlapped: false }
    }

    pub(crate) fn checked(&self) -> Result<Way<'a>> {
        if !self.path.is_finite() {
            return Err(Error::new(ErrorKind::NotFinite, "path", "is not finite"));
        }
        let length = self.path.length();
        if length > f64::from(MAX_QUERY_LENGTH) {
            return Err(Error::new(ErrorKind::OutOfRange, "path", "is longer than 1e7 m"));
        }
        if check::finite_vec("turn", self.turn)?.length() > MAX_CAST_TURN {
            return Err(Error::new(ErrorKind::OutOfRange, "turn", "is greater than 100.6 rad"));
        }
        let Some(shape) = self.shape else {
            let origin = self.pose.checked("pose.position", "pose.rotation")?.position;
            let direction = if length > 0.0 { self.path / length } else { DVec3::X };
            return Ok(Way::Ray(PathSegment { origin, direction, length, half: DVec3::ZERO }));
        };
        let probe = Probe::checked(shape, self.pose)?;
        let (turn, ignore_overlapped) = (self.turn.as_dvec3(), self.ignore_overlapped);
        Ok(Way::Sweep(Sweep { probe, path: self.path, turn, ignore_overlapped }))
    }
}

/// How far two shapes are apart, or how deep they overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Distance (m); negative is the least depth by which they overlap.
    pub distance: f64,
    /// Unit vector from the first to the second: to push the second along it by the depth parts them.
    pub normal: Vec3,
    /// Nearest point of the first, or its deepest (m).
    pub point_a: DVec3,
    /// Nearest point of the second, or its deepest (m).
    pub point_b: DVec3,
    /// Part of a compound that the points are on, of the first and of the second.
    pub parts: [Option<u32>; 2],
    /// Triangle of a mesh or height field that they are on; numbers as in [`RayHit`].
    pub triangles: [Option<u32>; 2],
}

/// The shape nearest to a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestShape {
    /// The shape.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Between the shape, the first, and the solid, the second.
    pub distance: Distance,
}

/// The nearest point of a shape to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPoint {
    /// The shape.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Its nearest point (m): the point asked about, if that lies inside.
    pub point: DVec3,
    /// How far that is (m); 0 inside.
    pub distance: f64,
    /// Which part of a compound it is on.
    pub part: Option<u32>,
    /// Which triangle of a mesh or height field it is on; numbers as in [`RayHit`].
    pub triangle: Option<u32>,
}

/// What a question is about; the default is everything.
#[derive(Clone, Copy)]
pub struct QueryFilter<'a> {
    /// Groups, as if the question were a shape with this filter.
    pub groups: CollisionFilter,
    /// Whether static bodies count.
    pub fixed: bool,
    /// Whether kinematic bodies count.
    pub kinematic: bool,
    /// Whether dynamic bodies count.
    pub dynamic: bool,
    /// Bodies that do not count; any handle is allowed.
    pub ignored: &'a [BodyId],
    /// A last word on each shape whose box is met; asked in any order, and on any thread in a batch.
    pub accept: Option<&'a (dyn Fn(ShapeId) -> bool + Sync)>,
}

impl Default for QueryFilter<'_> {
    fn default() -> Self {
        Self {
            groups: CollisionFilter { member_of: u32::MAX, collides_with: u32::MAX },
            fixed: true,
            kinematic: true,
            dynamic: true,
            ignored: &[],
            accept: None,
        }
    }
}

impl std::fmt::Debug for QueryFilter<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("QueryFilter").field("groups", &self.groups).field("ignored", &self.ignored.len()).finish_non_exhaustive()
    }
}

impl QueryFilter<'_> {
    pub(crate) fn accepts(&self, shape: ShapeId, filter: &CollisionFilter, body: BodyId, kind: BodyKind) -> bool {
        let counts = match kind {
            BodyKind::Static => self.fixed,
            BodyKind::Kinematic => self.kinematic,
            BodyKind::Dynamic => self.dynamic,
        };
        counts && self.groups.accepts(filter) && !self.ignored.contains(&body) && self.accept.is_none_or(|accept| accept(shape))
    }
}

/// A solid somewhere, to be swept or compared with what is there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Probe<'a> {
    pub shape: &'a Shape,
    pub pose: Pose,
}

impl<'a> Probe<'a> {
    pub(crate) fn checked(shape: &'a Shape, pose: Pose) -> Result<Self> {
        if !shape.geometry().is_solid() {
            return Err(Error::new(ErrorKind::NotApplicable, "shape", "only solid shapes can ask: no mesh, field or half-space"));
        }
        Ok(Self { shape, pose: pose.checked("pose.position", "pose.rotation")? })
    }
}

pub(crate) fn query_length(argument: &'static str, length: f32) -> Result<f32> {
    if check::not_negative(argument, length)? > MAX_QUERY_LENGTH {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "is greater than 1e7 m"));
    }
    Ok(length)
}
