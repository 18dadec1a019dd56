//! Continuous detection for fast bodies: sweeps the path of a body through the step and stops the body where it first touches.

use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::collider::Collider;
use super::narrow::impact::{self, MovingShape};
pub(crate) use super::narrow::impact::{BodyPath, BodyPose, ImpactBuffer};
use crate::body::Body;

/// Share of a shape's least extent that it and another must move against each other in a step before it is swept: less cannot miss
/// what contacts see.
const SWEEP_THRESHOLD: f32 = 0.25;

/// Distance left between a body that is stopped and what it meets, as a share of its least extent.
const STOP_SHORT: f32 = 0.01;

/// Overlap into which a way must lead for the body to be stopped, as a share of its least extent: surfaces that slide or roll on each
/// other overlap by less, and contacts take it out. It must be well above the overlap of resting bodies (some 0.001) and below half of the
/// extent, which what passes through a thin wall overlaps by.
const DEPTH: f32 = 0.05;

/// Box around the whole way of a shape.
pub(crate) fn path_box(collider: &Collider, body: &Body, start: &BodyPose) -> Aabb {
    let margin = collider.least_extent * STOP_SHORT;
    collider.box_at(collider.pose_with(body, start.center, start.rotation), margin).merged(&collider.world_box(margin))
}

/// A shape on its way.
pub(crate) fn moving<'a>(collider: &'a Collider, body: &Body, path: BodyPath) -> MovingShape<'a> {
    let place = (collider.local_pose.position - body.local_center, collider.local_pose.rotation);
    MovingShape { shape: &collider.shape, path, place, reach: collider.reach }
}

/// Share of the step after which a swept shape of this least extent (m) first touches another, if it goes on into it.
pub(crate) fn first_touch(swept: &MovingShape, other: &MovingShape, extent: f32, buffer: &mut ImpactBuffer) -> Option<f32> {
    let (a, b) = (&swept.path, &other.path);
    let shift = ((a.turn.center - a.start.center) - (b.turn.center - b.start.center)).length() as f32
        + ((a.end.center - a.turn.center) - (b.end.center - b.turn.center)).length() as f32;
    // What turns in place does not leave the ball that it holds.
    let turning = swept.turning() * (swept.reach - 0.5 * extent).max(0.0) + other.turning() * other.reach;
    if shift + turning <= SWEEP_THRESHOLD * extent {
        return None;
    }
    impact::first_touch(swept, other, (STOP_SHORT * extent, DEPTH * extent), buffer)
}
