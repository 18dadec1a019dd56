//! Continuous detection for bodies flagged fast: the path of a step is swept, and the body stops where it would first touch.

use glam::{DVec3, Quat};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose3;
use parry3d::query::{ShapeCastOptions, cast_shapes};

use super::collider::Collider;
use crate::body::Body;

/// Share of a shape's least extent that a body must move in one step before it is swept.
const SWEEP_THRESHOLD: f32 = 0.25;

/// Distance left between the swept body and what it meets, as a share of its least extent.
const STOP_SHORT: f32 = 0.01;

/// Where a body was at the start of the step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PathStart {
    pub center: DVec3,
    pub rotation: Quat,
}

/// Whether the path from `start` is long enough for a body with this shape to miss something.
pub(crate) fn is_long(collider: &Collider, body: &Body, start: &PathStart) -> bool {
    (body.center - start.center).length() as f32 > collider.least_extent * SWEEP_THRESHOLD
}

/// Box around the whole path of a shape.
pub(crate) fn path_box(collider: &Collider, body: &Body, start: &PathStart) -> Aabb {
    collider.box_at(collider.pose_with(body, start.center, start.rotation), 0.0).merged(&collider.world_box(0.0))
}

/// Fraction of the path, 0 to 1, at which the shape first touches `other` where that is now; `None` if it does not.
///
/// The sweep is a translation at the rotation of the path's end; what already overlaps at the start is left to the contacts.
pub(crate) fn first_touch(collider: &Collider, body: &Body, start: &PathStart, other: &Collider) -> Option<f32> {
    let (from, rotation) = collider.pose_with(body, start.center, body.rotation);
    let (other_position, other_rotation) = other.place;
    // Everything relative to the other shape's origin, so that f32 keeps its precision far from the world's.
    let moving = Pose3::from_parts((from - other_position).as_vec3(), rotation);
    let fixed = Pose3::from_parts(glam::Vec3::ZERO, other_rotation);
    let path = (body.center - start.center).as_vec3();
    let options = ShapeCastOptions {
        max_time_of_impact: 1.0,
        target_distance: collider.least_extent * STOP_SHORT,
        stop_at_penetration: false,
        compute_impact_geometry_on_penetration: false,
    };
    let hit = cast_shapes(&moving, path, &**collider.shape.parry(), &fixed, glam::Vec3::ZERO, &**other.shape.parry(), options);
    hit.ok().flatten().map(|hit| hit.time_of_impact)
}
