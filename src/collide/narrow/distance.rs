//! Closest points and penetration of two convex shapes, by parry3d's GJK and EPA.
//!
//! Their tolerances are absolute, so callers hand in shapes scaled to about 1.

use glam::Vec3;
use parry3d::math::Pose3;
use parry3d::query::details::contact_support_map_support_map_with_params;
use parry3d::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d::shape::SupportMap;

/// A point of each shape, in A's frame, and the direction from A to B between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    pub on_a: Vec3,
    pub on_b: Vec3,
    pub normal: Vec3,
}

/// Nearest points of shapes that do not touch; none if they do, or if GJK gives up.
pub(super) fn apart(a: &impl SupportMap, b: &impl SupportMap, relative: &Pose3) -> Option<Gap> {
    let mut simplex = VoronoiSimplex::new();
    let direction = relative.translation.try_normalize().unwrap_or(Vec3::X);
    simplex.reset(CsoPoint::from_shapes(relative, a, b, direction));
    match gjk::closest_points(relative, a, b, f32::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(on_a, on_b, normal) => Some(Gap { on_a, on_b, normal }),
        _ => None,
    }
}

/// What is known of two shapes.
pub(super) enum Nearest {
    /// Nearest points, or the way out of least depth.
    Found(Gap),
    /// Probably further apart than the limit, as a look along this direction will show.
    Beyond(Vec3),
}

/// Nearest points or least overlap of shapes not further apart than `limit`.
pub(super) fn nearest(a: &impl SupportMap, b: &impl SupportMap, relative: &Pose3, limit: f32) -> Nearest {
    match contact_support_map_support_map_with_params(relative, a, b, limit, &mut VoronoiSimplex::new(), None) {
        GJKResult::ClosestPoints(on_a, on_b, normal) => Nearest::Found(Gap { on_a, on_b, normal }),
        GJKResult::NoIntersection(direction) | GJKResult::Proximity(direction) => Nearest::Beyond(direction),
        GJKResult::Intersection => Nearest::Beyond(Vec3::X),
    }
}
