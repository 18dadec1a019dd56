//! A half-space against a part: the points of the part's lowest face, edge or point, each with its own distance to the plane.

use glam::Vec3;
use parry3d::math::Pose3;

use super::convex::{Buffers, LONE};
use super::face;
use super::part::Part;
use super::reduce::{PointCandidate, reduce_into};
use super::{Manifold, ManifoldPoint};

/// Separations that differ by less than this fraction of the part's reach count as equal.
const TIE: f32 = 1.0e-4;

/// Part B against half-space A, whose plane passes through the origin; `None` where they are further apart than `margin`.
pub(super) fn half_space(normal: Vec3, part: &Part, relative: &Pose3, margin: f32, buffers: &mut Buffers) -> Option<Manifold> {
    let rounding = part.rounding();
    let down = relative.rotation.inverse() * -normal;
    let deepest = part.core_support(down);
    let lowest = normal.dot(*relative * deepest) - rounding;
    // Written so that a NaN is no contact.
    let near = lowest <= margin;
    if !near {
        return None;
    }

    let tie = TIE * part.reach();
    let Buffers { corners_b: corners, candidates, .. } = buffers;
    candidates.clear();
    let candidate = |on_b: Vec3, feature: u32| {
        let surface = *relative * on_b;
        let separation = normal.dot(surface);
        PointCandidate { on_a: surface - normal * separation, on_b, separation, feature }
    };
    face::lying(part, down, corners);
    candidates.extend(corners.iter().map(|&(at, id)| candidate(at, u32::from(id))));
    if candidates.iter().all(|c| c.separation > lowest + tie) {
        candidates.push(candidate(deepest + down * rounding, LONE));
    }
    candidates.retain(|c| c.separation <= margin);

    let mut manifold = Manifold { normal, ..Manifold::default() };
    reduce_into(&mut manifold, candidates, tie, |c| ManifoldPoint {
        on_a: c.on_a,
        on_b: c.on_b,
        separation: c.separation,
        feature: c.feature,
    });
    (manifold.count > 0).then_some(manifold)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn against(part: &Part, pose: Pose3, margin: f32) -> Manifold {
        half_space(Vec3::Y, part, &pose, margin, &mut Buffers::default()).expect("a contact")
    }

    #[test]
    fn a_ball_touches_a_half_space_below_its_centre() {
        let pose = Pose3::from_parts(Vec3::new(3.0, 0.4, -2.0), Quat::from_rotation_x(1.0));
        let manifold = against(&Part::Ball { radius: 0.5 }, pose, 0.0);
        let point = manifold.points[0];
        assert_eq!((manifold.count, manifold.normal), (1, Vec3::Y));
        assert!((point.separation + 0.1).abs() < 1e-6, "{} m", point.separation);
        assert!((point.on_a - Vec3::new(3.0, 0.0, -2.0)).length() < 1e-6, "{}", point.on_a);
        assert!((pose * point.on_b - Vec3::new(3.0, -0.1, -2.0)).length() < 1e-6, "{}", point.on_b);
    }

    #[test]
    fn a_capsule_lies_on_two_points_and_stands_on_one() {
        let capsule = Part::Capsule { half_height: 1.0, radius: 0.25 };
        let lying = against(&capsule, Pose3::from_parts(Vec3::new(0.0, 0.3, 0.0), Quat::from_rotation_z(1.57)), 0.1);
        assert_eq!(lying.count, 2);
        let standing = against(&capsule, Pose3::from_parts(Vec3::new(0.0, 1.3, 0.0), Quat::from_rotation_z(0.1)), 10.0);
        assert_eq!(standing.count, 1);
    }

    #[test]
    fn a_box_touches_with_the_corners_of_its_lowest_face_only() {
        let part = Part::Box { half_extents: Vec3::new(1.0, 0.5, 2.0) };
        let manifold = against(&part, Pose3::from_parts(Vec3::new(0.0, 0.49, 0.0), Quat::IDENTITY), 10.0);
        assert_eq!(manifold.count, 4);
        for point in manifold.contacts() {
            assert!((point.separation + 0.01).abs() < 1e-6 && point.on_a.y == 0.0, "{point:?}");
        }
    }

    #[test]
    fn a_tilted_cylinder_touches_with_the_lowest_point_of_its_rim() {
        let part = Part::Cylinder { half_height: 1.0, radius: 0.5 };
        for turn in 0..20 {
            let rotation = Quat::from_rotation_z(0.3) * Quat::from_rotation_y(0.1 * turn as f32);
            let manifold = against(&part, Pose3::from_parts(Vec3::new(0.0, 1.0, 0.0), rotation), 5.0);
            let lowest = manifold.contacts().iter().map(|p| p.separation).fold(f32::MAX, f32::min);
            let expected = 1.0 - 0.3_f32.cos() - 0.5 * 0.3_f32.sin();
            assert!((lowest - expected).abs() < 1e-4, "{lowest} m, expected {expected} m");
        }
    }
}
