//! Continuous detection for fast bodies: sweeps the path of a body through the step and stops the body where it first touches.

use glam::Vec3;
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

/// The same where contacts have seen the two, or the body is stopped only for what contacts may have missed: they could not take it out on the
/// side that it came from, since its middle would be inside. What lies, rolls or tips over on another dips in by less.
const DEEP: f32 = 0.4;

/// How a body is swept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// As rows have sent it: it may be in the other already.
    Own,
    /// As rows have sent what is swept only as contacts may have missed something.
    OwnUnseen,
    /// As something else has sent it, which is no reason to go deeper.
    Sent,
}

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

/// Share of the way after which a swept shape of this least extent (m) first touches another, if it goes on into it, and the direction from it
/// to the other then (unit vector, world axes).
pub(crate) fn first_touch(
    swept: &MovingShape,
    other: &MovingShape,
    (extent, way): (f32, Way),
    buffer: &mut ImpactBuffer,
) -> Option<(f64, Vec3)> {
    let (a, b) = (&swept.path, &other.path);
    let shift = ((a.end.center - a.start.center) - (b.end.center - b.start.center)).length() as f32;
    // What turns in place does not leave the ball that it holds.
    let turning = swept.turning() * (swept.reach - 0.5 * extent).max(0.0) + other.turning() * other.reach;
    if shift + turning <= if way == Way::Sent { DEPTH * extent } else { SWEEP_THRESHOLD * extent } {
        return None;
    }
    // What turns may have swept on past the body by the time that its contacts push.
    let is_left = way != Way::Sent && other.turning() == 0.0;
    let limits = Limits {
        short: STOP_SHORT * extent,
        depth: extent * if way == Way::OwnUnseen { DEEP } else { DEPTH },
        depth_if_near: is_left.then_some(DEEP * extent),
        passes_deep: way != Way::Sent,
    };
    impact::first_touch(swept, other, &limits, buffer)
}
