//! The gap under a face that the contact of the last step had.
//!
//! No direction has to be sought where the face of a part whose normal was that of the contact still is what the other part meets: where
//! what goes farthest below its plane is over the face itself. Of parts that do not touch, the plane proves that the point and its foot are
//! nearest points. Of parts that overlap, of which the point is d below the plane and its foot no nearer to the border of the face than
//! that, no way out is shorter that leads to the face's side of the plane: along a direction at an angle θ to the normal it is
//! d (cos θ + sin θ) or more, as the face holds a disc of radius d about the foot. So bodies that overlap little go back the way they came.

use glam::Vec3;

use super::convex_pair::ConvexPair;
use super::distance::ConvexGap;
use super::face::{self, Corner, Feature};
use super::plane::ContactPlane;

/// Cosine between the last normal and that of a face from which on they may be one: some turn of a step.
const SAME_FACE: f32 = 0.98;

/// Depth up to which parts go back the way they came, over the reach of the smaller: forty times what rests overlaps by, and little beside
/// any way out on the other side.
const SHALLOW: f32 = 0.01;

/// What the last normal tells of two parts.
pub(super) enum Known {
    /// They are further apart than asked for.
    Apart,
    /// The gap under a face of A (true) or B (false).
    Under(ConvexGap, bool),
}

impl ConvexPair<'_> {
    /// What the normal `last`, in A's frame, tells of parts no further apart than `margin`, if anything.
    pub(super) fn known(&self, last: Vec3, margin: f32, corners: &mut Vec<Corner>) -> Option<Known> {
        [true, false].into_iter().find_map(|of_a| {
            let (part, toward) = if of_a { (self.a, last) } else { (self.b, self.relative.rotation.inverse() * -last) };
            let outward = face::nearest(part, toward).filter(|outward| outward.dot(toward) >= SAME_FACE)?;
            let normal = if of_a { outward } else { self.relative.rotation * -outward };
            let extreme = self.along(normal);
            let distance = extreme.distance();
            if distance - self.radii > margin {
                return Some(Known::Apart);
            }
            // Written so that a NaN is nothing known.
            let is_shallow = distance >= -SHALLOW * self.size;
            if !is_shallow {
                return None;
            }
            let point = if of_a { extreme.on_b } else { self.relative.inverse_transform_point(extreme.on_a) };
            let is_face = matches!(face::find(part, outward, corners), Feature::Face { normal } if normal == outward);
            let is_over = ContactPlane::across(outward).is_over(corners, point, distance.min(0.0));
            let gap = if of_a {
                ConvexGap { on_a: extreme.on_b - normal * distance, ..extreme }
            } else {
                ConvexGap { on_b: extreme.on_a + normal * distance, ..extreme }
            };
            (is_face && is_over).then_some(Known::Under(gap, of_a))
        })
    }
}
