//! Contact manifolds between two shapes, as a pure function of the shapes and their relative pose.
//!
//! ```text
//! collide ─┬─ a part against a part (part_pairs.rs) ─┬─ ball, capsule, box, the side of a cylinder: closed forms and clipping
//!          │                                         ├─ half-space: the points nearest to its plane
//!          │                                         ├─ triangle against ball, box: parry3d (triangle.rs)
//!          │                                         ├─ the rest: GJK, EPA, clipping (convex.rs), in f64 where they fail (fine.rs)
//!          │                                         └─ with corners on what is round (lying.rs)
//!          └─ composite.rs: parts of compounds, triangles of meshes and height fields near the other shape
//! ```
//!
//! Nothing is remembered between calls: the same arguments give the same bits, whatever was asked before; one of them may be the normal of
//! the last step. Tolerances are fractions of the smaller shape plus the rounding of the larger, so that 1 mm and 1 km behave alike.

use glam::Vec3;
use parry3d::math::Pose3;
use parry3d::query::PointQuery;
use parry3d::shape::CompositeShapeRef;

use crate::shape::{Geometry, Shape};

pub(crate) use near_edge::{Corners, nearest_edge};
pub(crate) use same_side::PressedNormal;

mod ball;
mod beside;
mod box_box;
mod capsule;
mod capsule_box;
mod clip;
mod composite;
mod convex;
mod convex_pair;
mod cylinder;
mod distance;
mod face;
mod fine;
mod half_space;
pub(crate) mod impact;
mod known_face;
mod lying;
mod near_edge;
mod part;
mod part_pairs;
mod plane;
mod reduce;
mod same_side;
mod segment;
mod triangle;

#[cfg(test)]
mod tests;

/// Most points of a manifold.
pub(crate) const MAX_POINTS: usize = 4;

/// One point of a manifold. Points lie on the two surfaces; separation = n·(p_b − p_a), negative when overlapping (m).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct ManifoldPoint {
    /// In the frame of shape A (m).
    pub on_a: Vec3,
    /// In the frame of shape B (m).
    pub on_b: Vec3,
    /// Along the manifold's normal (m).
    pub separation: f32,
    /// Stable id of the pair of features, to match multipliers from step to step.
    pub feature: u32,
}

/// Up to four points that share a normal.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Manifold {
    /// Unit vector in the frame of shape A, from A to B.
    pub normal: Vec3,
    /// Only the first `count` mean something.
    pub points: [ManifoldPoint; MAX_POINTS],
    /// Number of points, 1 to 4.
    pub count: u8,
    /// Which pair of sub-shapes or triangles; 0 for convex pairs.
    pub part: u32,
}

impl Manifold {
    fn single(normal: Vec3, point: ManifoldPoint) -> Self {
        let mut manifold = Self { normal, ..Self::default() };
        manifold.push(point);
        manifold
    }

    /// An empty manifold at the end of `out`, to be filled where it lies: copies of one as large as this are felt.
    #[inline]
    fn append(out: &mut Vec<Self>) -> &mut Self {
        let last = out.len();
        out.push(Self::default());
        &mut out[last]
    }

    #[inline]
    fn push(&mut self, point: ManifoldPoint) {
        self.points[usize::from(self.count)] = point;
        self.count += 1;
    }

    pub(crate) fn contacts(&self) -> &[ManifoldPoint] {
        &self.points[..usize::from(self.count)]
    }

    /// Makes the manifold of (A, B) that of (B, A), with B at `relative` in A's frame.
    fn swap(&mut self, relative: &Pose3) {
        self.normal = relative.rotation.inverse() * -self.normal;
        for point in &mut self.points[..usize::from(self.count)] {
            std::mem::swap(&mut point.on_a, &mut point.on_b);
        }
    }

    fn is_finite(&self) -> bool {
        let finite = |p: &ManifoldPoint| p.on_a.is_finite() && p.on_b.is_finite() && p.separation.is_finite();
        self.normal.is_finite() && self.contacts().iter().all(finite)
    }
}

/// Buffers kept between calls so that nothing is allocated; they carry nothing from one call to the next.
#[derive(Default)]
pub(crate) struct NarrowScratch {
    /// Normal of the pair's one contact in the last step, in A's frame: an argument of the call to come.
    pub last: Option<Vec3>,
    /// Of one that pressed on what cannot be pushed: an argument of the call to come.
    pub pressed: Option<PressedNormal>,
    /// How far each body may turn in the step (rad), infinite where the other cannot be pushed: an argument of the call to come.
    pub turns: [f32; 2],
    polygons: convex::Buffers,
    triangle: triangle::TriangleBuffer,
    parts_a: Vec<u32>,
    parts_b: Vec<u32>,
}

/// Manifolds of `b` (placed at `relative` in A's frame) against `a`; points further apart than `margin` are left out.
/// Clears `out` first.
///
/// Speculative points are honest: their separation is the distance along the normal, never more than the true distance.
#[inline]
pub(crate) fn collide(a: &Shape, b: &Shape, relative: Pose3, margin: f32, scratch: &mut NarrowScratch, out: &mut Vec<Manifold>) {
    out.clear();
    // The commonest pairs need nothing but their sizes, and balls are done before a call would be.
    match (a.geometry(), b.geometry()) {
        (&Geometry::Ball { radius: radius_a }, &Geometry::Ball { radius: radius_b }) => {
            ball::append(ball::ball_ball(radius_a, radius_b, &relative, margin), out);
        }
        (&Geometry::Box { half_extents }, &Geometry::Ball { radius }) if !lying::may_lie_on_ball(half_extents, radius) => {
            ball::append(ball::box_ball(half_extents, radius, &relative, margin), out);
        }
        (&Geometry::Ball { radius }, &Geometry::Box { half_extents }) if !lying::may_lie_on_ball(half_extents, radius) => {
            ball::append(ball::ball_box(radius, half_extents, &relative, margin), out);
        }
        (&Geometry::Box { half_extents: half_a }, &Geometry::Box { half_extents: half_b }) => {
            box_box::box_box(half_a, half_b, &relative, margin, out);
        }
        _ => collide_parts(a, b, &relative, margin, scratch, out),
    }
    if let Some(last) = scratch.pressed {
        same_side::keep(a, b, &relative, last, &mut scratch.polygons, out);
    }
}

/// The parts of two shapes, the second of which is `b`, that a manifold between them is of.
pub(crate) fn parts_of(b: &Shape, part: u32) -> [u32; 2] {
    let parts_of_b = composite::part_count(b).max(1);
    [part / parts_of_b, part % parts_of_b]
}

/// Angle between directions that count as one (rad): more than manifolds are turned by rounding and by resting overlaps.
const SAME_DIRECTION: f32 = 5.0e-3;

/// The same of balls and capsules, whose normals are exact: at an edge that they have just left they are pushed on by the sine of this.
const SAME_EXACT_DIRECTION: f32 = 5.0e-4;

/// The outward normal of the face of a part of a shape that is most along a direction (unit), both in the frame of the shape; none if it has none.
pub(crate) fn face_normal(shape: &Shape, part: u32, direction: Vec3) -> Option<Vec3> {
    let (part, place) = composite::part_at(shape, part)?;
    let face = match part {
        part::Part::HalfSpace { normal } => Some(normal),
        part => face::nearest(&part, place.rotation.inverse() * direction),
    };
    face.map(|normal| place.rotation * normal)
}

/// Whether a direction in the frame of a shape (unit), which is `is_exact` or not, is the outward normal of a face of one of its parts.
pub(crate) fn is_face_normal(shape: &Shape, part: u32, direction: Vec3, is_exact: bool) -> bool {
    let face = face_normal(shape, part, direction);
    let same = if is_exact { SAME_EXACT_DIRECTION } else { SAME_DIRECTION };
    face.is_some_and(|normal| (normal - direction).length_squared() < same * same)
}

/// Distance from a shape to a point in its frame (m), zero inside; infinite where it is more than twice `most`. Most of what is asked lies far
/// off: boxes around the shape and its parts tell that, and no search for the nearest point begins.
pub(crate) fn distance_up_to(shape: &Shape, point: Vec3, most: f32) -> f32 {
    let (parry, reach) = (shape.parry(), 2.0 * most);
    if parry.compute_local_aabb().distance_to_local_point(point, true) > reach {
        return f32::INFINITY;
    }
    let nearest = match parry.as_compound() {
        Some(compound) => CompositeShapeRef(compound).project_local_point(point, reach, true).map(|(_, nearest)| nearest),
        None if shape.geometry().is_solid() => return parry.distance_to_local_point(point, true),
        None => parry.project_local_point_with_max_dist(point, true, reach),
    };
    nearest.map_or(f32::INFINITY, |nearest| (point - nearest.point).length())
}

fn collide_parts(a: &Shape, b: &Shape, relative: &Pose3, margin: f32, scratch: &mut NarrowScratch, out: &mut Vec<Manifold>) {
    match (part::Part::whole(a), part::Part::whole(b)) {
        (Some(part_a), Some(part_b)) => {
            let last = scratch.last;
            part_pairs::collide(&part_a, &part_b, relative, margin, scratch, out);
            scratch.last = last;
        }
        _ => {
            scratch.last = None;
            composite::collide(a, b, relative, margin, scratch, out);
        }
    }
}
