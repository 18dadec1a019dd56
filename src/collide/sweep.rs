//! Continuous detection for fast bodies: sweeps the path of a body through the step and stops the body where it first touches.

use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::collider::Collider;
use super::narrow::impact::{self, Limits, MovingShape};
pub(crate) use super::narrow::impact::{BodyPath, BodyPose, ImpactBuffer};
use crate::body::Body;

/// Share of a shape's least extent that it and another must move against each other in a step before it is swept: less cannot miss
/// what contacts see.
pub(crate) const SWEEP_THRESHOLD: f32 = 0.25;

/// Distance left between a body that is stopped and what it meets, as a share of its least extent.
const STOP_SHORT: f32 = 0.01;

/// Overlap into which a way must lead for the body to be stopped, as a share of its least extent: surfaces that slide or roll on each
/// other overlap by less, and contacts take it out. It must be well above the overlap of resting bodies (some 0.001) and below half of the
/// extent, which what passes through a thin wall overlaps by.
const DEPTH: f32 = 0.05;

/// Box around the way of a shape.
pub(crate) fn path_box(collider: &Collider, body: &Body, path: &BodyPath) -> Aabb {
    let margin = collider.least_extent * STOP_SHORT + path.bulge(collider.reach);
    let [start, end] = [path.start, path.end].map(|at| collider.box_at(collider.pose_with(body, at.center, at.rotation), margin));
    start.merged(&end)
}

/// A shape on its way.
pub(crate) fn moving<'a>(collider: &'a Collider, body: &Body, path: BodyPath) -> MovingShape<'a> {
    let place = (collider.local_pose.position - body.local_center, collider.local_pose.rotation);
    MovingShape { shape: &collider.shape, path, place, reach: collider.reach }
}

/// Share of the way after which a swept shape of this least extent (m) first touches another, if it goes on into it. Where it goes its own way,
/// as rows have sent it, it may be in the other already; where something else has sent it, that is no reason to go deeper.
pub(crate) fn first_touch(
    swept: &MovingShape,
    other: &MovingShape,
    (extent, goes_its_own_way): (f32, bool),
    buffer: &mut ImpactBuffer,
) -> Option<f64> {
    let (a, b) = (&swept.path, &other.path);
    let shift = ((a.end.center - a.start.center) - (b.end.center - b.start.center)).length() as f32;
    // What turns in place does not leave the ball that it holds.
    let turning = swept.turning() * (swept.reach - 0.5 * extent).max(0.0) + other.turning() * other.reach;
    if shift + turning <= if goes_its_own_way { SWEEP_THRESHOLD * extent } else { DEPTH * extent } {
        return None;
    }
    let limits = Limits { short: STOP_SHORT * extent, depth: DEPTH * extent, passes_deep: goes_its_own_way };
    impact::first_touch(swept, other, &limits, buffer)
}
