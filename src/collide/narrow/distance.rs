//! Closest points and penetration of two convex shapes, by parry3d's GJK and EPA.
//!
//! Their tolerances are absolute, so callers hand in shapes scaled to about 1.

use glam::Vec3;
use parry3d::math::Pose3;
use parry3d::query::epa::EPA;
use parry3d::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d::shape::SupportMap;

/// A point of each shape, in A's frame, and the direction from A to B between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct ConvexGap {
    pub on_a: Vec3,
    pub on_b: Vec3,
    pub normal: Vec3,
}

impl ConvexGap {
    /// How far the points are apart along the direction (m).
    pub(super) fn distance(&self) -> f32 {
        self.normal.dot(self.on_b - self.on_a)
    }
}

/// Nearest points of shapes that do not touch; none if they do, or if GJK gives up.
pub(super) fn apart(a: &impl SupportMap, b: &impl SupportMap, relative: &Pose3) -> Option<ConvexGap> {
    let mut simplex = VoronoiSimplex::new();
    let direction = relative.translation.try_normalize().unwrap_or(Vec3::X);
    simplex.reset(CsoPoint::from_shapes(relative, a, b, direction));
    match gjk::closest_points(relative, a, b, f32::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(on_a, on_b, normal) => Some(ConvexGap { on_a, on_b, normal }),
        _ => None,
    }
}

/// What is known of two shapes.
pub(super) enum Nearest {
    /// Nearest points, or the way out of least depth.
    Found(ConvexGap),
    /// Probably further apart than the limit, as a look along this direction will show.
    Beyond(Vec3),
}

/// Nearest points or least overlap of shapes not further apart than `limit`; nothing that `epa` has kept is used but its memory.
pub(super) fn nearest(a: &impl SupportMap, b: &impl SupportMap, relative: &Pose3, limit: f32, epa: &mut EPA) -> Nearest {
    let mut simplex = VoronoiSimplex::new();
    let direction = relative.translation.try_normalize().unwrap_or(Vec3::X);
    simplex.reset(CsoPoint::from_shapes(relative, a, b, direction));
    let found = |(on_a, on_b, normal): (Vec3, Vec3, Vec3)| Nearest::Found(ConvexGap { on_a, on_b, normal });
    match gjk::closest_points(relative, a, b, limit, true, &mut simplex) {
        GJKResult::ClosestPoints(on_a, on_b, normal) => found((on_a, on_b, normal)),
        GJKResult::NoIntersection(direction) | GJKResult::Proximity(direction) => Nearest::Beyond(direction),
        GJKResult::Intersection if can_expand(&simplex) => {
            epa.closest_points(relative, a, b, &simplex).map_or(Nearest::Beyond(Vec3::X), found)
        }
        GJKResult::Intersection => Nearest::Beyond(Vec3::X),
    }
}

/// Whether EPA can begin with a simplex. It makes no face of two points that are the same one, or of what is not finite, and panics.
fn can_expand(simplex: &VoronoiSimplex) -> bool {
    let point = |i: usize| simplex.point(i).point;
    let is_finite = (0..=simplex.dimension()).all(|i| point(i).length_squared().is_finite());
    is_finite && (simplex.dimension() != 1 || (point(1) - point(0)).normalize_or_zero() != Vec3::ZERO)
}
