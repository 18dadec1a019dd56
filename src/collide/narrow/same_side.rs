//! What presses on something that cannot be pushed, and has been pressed half way through it, goes back the way it came.
//!
//! The shortest way out of a thin floor leads on through it, once the middle of what is in it is past the middle of the floor. The contact of the last step
//! tells on which side it was, and nothing comes to the other side within a step but through the floor: so a manifold that pushes the other way gives
//! way to one along the last normal, with each corner at its own depth.

use glam::Vec3;
use parry3d::math::Pose3;

use super::convex::Buffers;
use super::part::Part;
use super::reduce::{PointCandidate, reduce_into};
use super::{Manifold, ManifoldPoint, face};
use crate::shape::Shape;

/// Cosine between two normals below which they push to different sides of one body.
const OTHER_SIDE: f32 = -0.5;

/// Depths that differ by less than this fraction of a part's reach count as equal.
const TIE: f32 = 1.0e-4;

/// The normal of the one contact that pressed in the last step, from A to B, in the frame of the shape that cannot be pushed.
#[derive(Debug, Clone, Copy)]
pub(crate) enum PressedNormal {
    OfA(Vec3),
    OfB(Vec3),
}

/// Turns the one manifold of B (placed at `relative` in A's frame) against A back to the side of the last normal, if it pushes to the other one.
pub(super) fn keep(a: &Shape, b: &Shape, relative: &Pose3, last: PressedNormal, buffers: &mut Buffers, out: &mut [Manifold]) {
    let [manifold] = out else { return };
    let normal = match last {
        PressedNormal::OfA(normal) => normal,
        PressedNormal::OfB(normal) => relative.rotation * normal,
    };
    let overlaps = manifold.contacts().iter().any(|point| point.separation < 0.0);
    if !overlaps || manifold.normal.dot(normal) >= OTHER_SIDE {
        return;
    }
    let (Some(part_a), Some(part_b)) = (Part::whole(a), Part::whole(b)) else { return };
    // The corners are those of what can be pushed.
    let moves_b = matches!(last, PressedNormal::OfA(_));
    let (part, fixed, place, toward) = match moves_b {
        true => (&part_b, &part_a, *relative, -normal),
        false => (&part_a, &part_b, Pose3::IDENTITY, normal),
    };
    let to_fixed = if moves_b { Pose3::IDENTITY } else { relative.inverse() };
    let outward = to_fixed.rotation * -toward;
    let height = outward.dot(fixed.core_support(outward)) + fixed.rounding();
    let surface = |at: Vec3| at + toward * (outward.dot(to_fixed * at) - height);
    let (down, Buffers { corners_b: corners, candidates, .. }) = (place.rotation.inverse() * toward, buffers);
    face::lying(part, down, corners);
    if corners.is_empty() {
        corners.push((part.core_support(down) + down * part.rounding(), 0));
    }
    candidates.clear();
    candidates.extend(corners.iter().map(|&(corner, id)| {
        let at = place * corner;
        let (on_a, on_b) = if moves_b { (surface(at), at) } else { (at, surface(at)) };
        PointCandidate { on_a, on_b, separation: normal.dot(on_b - on_a), feature: u32::from(id) }
    }));
    let mut kept = Manifold { normal, part: manifold.part, ..Manifold::default() };
    reduce_into(&mut kept, candidates, TIE * part.reach(), |c| ManifoldPoint {
        on_a: c.on_a,
        on_b: relative.inverse_transform_point(c.on_b),
        separation: c.separation,
        feature: c.feature,
    });
    *manifold = kept;
}
