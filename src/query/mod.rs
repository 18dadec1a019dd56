//! Questions about where things are: rays, swept shapes, overlaps, nearest points.
//!
//! A question is answered in two stages. The broad phase names shapes whose kept box the question's region meets; here the
//! shapes themselves are asked, in coordinates relative to each one, so that `f32` keeps its precision far from the origin.
//! Answers are sorted by distance, then by shape, so they do not depend on the form of the tree.

use glam::{DVec3, Vec3};

use crate::body::BodyKind;
use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::id::{BodyId, ShapeId};
use crate::pose::Pose;
use crate::shape::{CollisionFilter, Shape};

mod exact;
mod region;

pub(crate) use exact::{nearest_point, overlap, probe_box, ray, swept};
pub(crate) use region::Segment;

/// Longest ray or sweep, and greatest distance that is searched (m).
pub const MAX_QUERY_LENGTH: f32 = 1.0e7;

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

    pub(crate) fn checked(self) -> Result<Self> {
        Ok(Self {
            origin: check::position("origin", self.origin)?,
            direction: check::direction("direction", self.direction)?,
            length: query_length("length", self.length)?,
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
    /// Where (m): on the surface of the shape that is met.
    pub point: DVec3,
    /// Outward unit normal of that surface; against the motion where the two overlap from the start.
    pub normal: Vec3,
    /// How far along the ray or sweep (m); 0 where the two overlap from the start.
    pub distance: f32,
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
    pub distance: f32,
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
