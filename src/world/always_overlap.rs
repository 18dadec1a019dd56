//! Bodies that joints hold so close to each other that they overlap however they turn.
//!
//! Slings from one hook, ropes from one ring, bars in one node: two bodies are jointed to the same third one, or both to the world, at points p
//! and q of theirs that are a distance g apart. Let the ball that is as thick as a body and lies in it next to its point have the radius ρ
//! and its centre at the distance d from the point. The centres are no more than g + d_A + d_B apart, and where both bodies are turned by
//! 60° and more out of the line of the points, no more than g + ½ (d_A + d_B). Where that is less than ρ_A + ρ_B they overlap there, and as good
//! as always: capsules held by their tips do but in one line. Contacts can't part them, and joints bring them back whenever contacts have
//! tried: links of three chains from one point were pushed up again and again, and gained a quarter of their energy in ten seconds. So they do
//! not collide, as bodies do not that a joint connects.

use glam::{DVec3, Vec3};

use super::long_range::holds_points;
use crate::body::Body;
use crate::collide::collider::Collider;
use crate::id::{JointId, Pool};
use crate::joint::JointDef;
use crate::joint_record::Joint;
use crate::shape::Geometry;

/// How deep two bodies overlap at least that do not collide for it, over the lesser least extent of their shapes. Less is what models are off
/// by, leaves of a door that share a post: these go on to hold each other up, and what contacts push them by is little.
const OVERLAP: f32 = 0.1;

/// Whether joints hold two shapes of different bodies, with these slots, so that they always overlap.
pub(super) fn always_overlap(
    (a, body_a): (&Collider, &Body),
    (b, body_b): (&Collider, &Body),
    joints: &Pool<Joint, JointId>,
) -> bool {
    if body_a.joints.is_empty() || body_b.joints.is_empty() {
        return false;
    }
    let widest = 0.5 * (a.least_extent + b.least_extent);
    let least = OVERLAP * a.least_extent.min(b.least_extent);
    held_points(body_a, a.body, joints).any(|on_a| {
        held_points(body_b, b.body, joints).any(|on_b| {
            let gap = (on_a.there - on_b.there).length() as f32;
            let may = on_a.other == on_b.other && on_a.other != Some(b.body) && gap < widest;
            may && ball_at(a, on_a.here)
                .zip(ball_at(b, on_b.here))
                .is_some_and(|(in_a, in_b)| in_a.radius + in_b.radius - gap - 0.5 * (in_a.distance + in_b.distance) > least)
        })
    })
}

/// A point at which a joint holds a body.
struct Held {
    /// In the body's frame, and in that of what it is held to (m).
    here: Vec3,
    there: DVec3,
    /// Slot of that; none is the world.
    other: Option<u32>,
}

impl Held {
    fn of(joint: &Joint, body: u32) -> Option<Self> {
        let JointDef { frame_a, frame_b, .. } = &joint.def;
        let (own, other, to) = match joint.bodies {
            [a, b] if a == Some(body) => (frame_a, frame_b, b),
            [a, _] => (frame_b, frame_a, a),
        };
        holds_points(&joint.def).then(|| Self { here: own.position.as_vec3(), there: other.position, other: to })
    }
}

/// Points at which joints hold a body.
fn held_points<'a>(body: &'a Body, slot: u32, joints: &'a Pool<Joint, JointId>) -> impl Iterator<Item = Held> + 'a {
    body.joints.iter().filter_map(move |&id| Held::of(&joints[joints.slot_of(id)], slot))
}

/// A ball in a body.
struct Ball {
    radius: f32,
    /// Of its centre from a point of the body (m).
    distance: f32,
}

/// The ball in one of a body's shapes that lies next to a point of the body: as thick as the shape where that has a plain form, or else about the
/// point and as wide as that is deep. None for a shape without an inside.
fn ball_at(collider: &Collider, point: Vec3) -> Option<Ball> {
    let at = collider.local_pose.to_parry().inverse_transform_point(point);
    let in_box = |half: Vec3| {
        let radius = half.min_element();
        Ball { radius, distance: at.clamp(Vec3::splat(radius) - half, half - radius).distance(at) }
    };
    match *collider.shape.geometry() {
        Geometry::Ball { radius } => Some(Ball { radius, distance: at.length() }),
        Geometry::Box { half_extents } => Some(in_box(half_extents)),
        Geometry::Capsule { half_height, radius } => {
            let center = Vec3::new(0.0, at.y.clamp(-half_height, half_height), 0.0);
            Some(Ball { radius, distance: center.distance(at) })
        }
        Geometry::Cylinder { half_height, radius: wide } => {
            let radius = wide.min(half_height);
            let across = Vec3::new(at.x, 0.0, at.z).clamp_length_max(wide - radius);
            let center = across + Vec3::Y * at.y.clamp(radius - half_height, half_height - radius);
            Some(Ball { radius, distance: center.distance(at) })
        }
        Geometry::Cone { .. } | Geometry::ConvexHull { .. } | Geometry::Compound { .. } => {
            let found = collider.shape.parry().project_local_point(at, false);
            found.is_inside.then(|| Ball { radius: (found.point - at).length(), distance: 0.0 })
        }
        Geometry::HalfSpace { .. } | Geometry::TriangleMesh { .. } | Geometry::HeightField { .. } => None,
    }
}
