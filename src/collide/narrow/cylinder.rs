//! A ball or a capsule against the side of a cylinder, in closed form: what lies on a drum, a wheel or a pipe.
//!
//! Where the point of a segment that is nearest to the cylinder's axis lies between the ends of the cylinder and outside it, it is
//! the nearest to the cylinder too, for the cylinder is a part of the infinite one. The normal is radial there, exact to rounding. An
//! iterative search that stops at 1e-5 of the distance leaves the normal several hundredths of a radian off over a thin core: a cable would
//! slide into its drum.

use glam::{Vec2, Vec3};
use parry3d::math::Pose3;

use super::capsule::Segment;
use super::convex::LONE;
use super::{Manifold, ManifoldPoint};

/// Squared sine of a segment's angle to the axis below which all of its points are as near to it as its middle.
const PARALLEL: f32 = 1.0e-10;

/// A core of `radius` around the segment `core` (one point where `half` is zero) against the side of cylinder A (half height and
/// radius, m); none where it is not the side that the core is nearest to.
pub(super) fn side_core(a: (f32, f32), core: &Segment, radius: f32, relative: &Pose3, margin: f32) -> Option<Option<Manifold>> {
    let (half_height, radius_a) = a;
    let nearest = core.at(nearest_to_axis(core));
    let across = Vec2::new(nearest.x, nearest.z);
    let distance = across.length();
    // Written so that a NaN is left to others.
    let beside = nearest.y.abs() <= half_height && distance > radius_a;
    if !beside {
        return None;
    }
    if distance - radius_a - radius > margin {
        return Some(None);
    }
    let normal = Vec3::new(across.x, 0.0, across.y) / distance;
    let foot = normal * radius_a;
    let place = |(on_side, on_core): (Vec3, Vec3), feature| ManifoldPoint {
        on_a: on_side,
        on_b: relative.inverse_transform_point(on_core - normal * radius),
        separation: normal.dot(on_core - on_side) - radius,
        feature,
    };
    let mut manifold = Manifold { normal, ..Manifold::default() };
    let line = Segment { center: foot, half: Vec3::Y * half_height };
    let girth = radius.min(radius_a).min(half_height);
    match line.side_by_side(core, normal, girth) {
        Some(ends) => {
            let points = (0..).zip(ends).map(|(feature, end)| place(end, feature));
            points.filter(|point| point.separation <= margin).for_each(|point| manifold.push(point));
        }
        None => manifold.push(place((foot + Vec3::Y * nearest.y, nearest), LONE)),
    }
    Some((manifold.count > 0).then_some(manifold))
}

/// Where on the segment the distance to the y axis is least.
fn nearest_to_axis(core: &Segment) -> f32 {
    let (center, half) = (Vec2::new(core.center.x, core.center.z), Vec2::new(core.half.x, core.half.z));
    let squared = half.length_squared();
    if squared <= PARALLEL * core.half.length_squared() { 0.0 } else { (-center.dot(half) / squared).clamp(-1.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    const DRUM: (f32, f32) = (0.5, 1.0);

    fn rod(at: Vec3, rotation: Quat) -> (Segment, Pose3) {
        let pose = Pose3::from_parts(at, rotation);
        (Segment::of_capsule(0.1, &pose), pose)
    }

    #[test]
    fn a_rod_across_a_drum_touches_where_it_is_tangent_and_nowhere_else() {
        for degrees in 0..360 {
            let angle = (degrees as f32).to_radians();
            let radial = Vec3::new(angle.cos(), 0.0, angle.sin());
            let tangent = Vec3::Y.cross(radial);
            // Its middle lies 3 cm past the point of contact.
            let (core, pose) = rod(radial * 1.019 + tangent * 0.03, Quat::from_rotation_arc(Vec3::Y, tangent));
            let manifold = side_core(DRUM, &core, 0.02, &pose, 0.1).flatten().expect("a contact");
            assert_eq!(manifold.count, 1);
            let point = &manifold.points[0];
            assert!((manifold.normal - radial).length() < 1e-6, "normal {} for {radial}", manifold.normal);
            assert!((point.separation + 0.001).abs() < 1e-6, "{} m", point.separation);
            assert!((point.on_b - Vec3::new(0.0, -0.03, 0.0)).reject_from(pose.rotation.inverse() * radial).length() < 1e-5);
        }
    }

    #[test]
    fn a_rod_along_a_drum_lies_on_both_ends_of_the_common_stretch() {
        let (core, pose) = rod(Vec3::new(0.0, 0.45, 1.02), Quat::IDENTITY);
        let manifold = side_core(DRUM, &core, 0.02, &pose, 0.1).flatten().expect("a contact");
        assert_eq!((manifold.count, manifold.normal), (2, Vec3::Z));
        for (point, y) in manifold.contacts().iter().zip([0.35, 0.5]) {
            assert!((point.on_a - Vec3::new(0.0, y, 1.0)).length() < 1e-6, "point {}", point.on_a);
            assert!(point.separation.abs() < 1e-6, "{} m", point.separation);
        }
    }

    #[test]
    fn what_is_past_an_end_or_inside_is_left_to_others() {
        for at in [Vec3::new(1.01, 0.6, 0.0), Vec3::new(0.9, 0.0, 0.0)] {
            let (core, pose) = rod(at, Quat::from_rotation_x(1.5));
            assert!(side_core(DRUM, &core, 0.02, &pose, 0.1).is_none(), "{at}");
        }
    }
}
