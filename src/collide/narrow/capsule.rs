//! A capsule against a capsule.
//!
//! The closest points of the two inner segments give normal and depth. Side by side, capsules touch along a line, and the
//! ends of the stretch where they lie next to each other carry the contact.

use glam::Vec3;
use parry3d::math::Pose3;

use super::beside::{self, Side};
use super::segment::{PARALLEL, Segment};
use super::{Manifold, ManifoldPoint};

/// Segments closer than this fraction of their lengths have no direction from one to the other.
const CROSSING: f32 = 4.0 * f32::EPSILON;

/// Capsule B against capsule A; half heights and radii (m).
pub(super) fn capsule_capsule(a: (f32, f32), b: (f32, f32), relative: &Pose3, margin: f32) -> Option<Manifold> {
    let segment_a = Segment { center: Vec3::ZERO, half: Vec3::new(0.0, a.0, 0.0) };
    let segment_b = Segment::of_capsule(b.0, relative);
    let radii = a.1 + b.1;
    let (s, t) = segment_a.closest(&segment_b);
    let offset = segment_b.at(t) - segment_a.at(s);
    let distance = offset.length();
    if distance.is_nan() || distance - radii > margin {
        return None;
    }
    let normal = if distance > CROSSING * (a.0 + b.0) { offset / distance } else { across(&segment_a, &segment_b) };

    let place = |(core_a, core_b): (Vec3, Vec3), feature| {
        let (on_a, on_b) = (core_a + normal * a.1, core_b - normal * b.1);
        ManifoldPoint {
            on_a,
            on_b: relative.inverse_transform_point(on_b),
            separation: normal.dot(core_b - core_a) - radii,
            feature,
        }
    };
    let mut manifold = Manifold { normal, ..Manifold::default() };
    match segment_a.side_by_side(&segment_b, normal, radii) {
        Some(ends) => {
            for (feature, end) in (0..).zip(ends) {
                let point = place(end, feature);
                if point.separation <= margin {
                    manifold.push(point);
                }
            }
        }
        None => {
            manifold.push(place((segment_a.at(s), segment_b.at(t)), 2));
            let sides = [Side::around(&segment_a, a.1, normal), Side::around(&segment_b, b.1, -normal)];
            beside::widen(&sides, relative, margin, &mut manifold);
        }
    }
    (manifold.count > 0).then_some(manifold)
}

/// Direction in which crossing segments part soonest: across both, or any across the first where they are parallel.
fn across(a: &Segment, b: &Segment) -> Vec3 {
    let cross = a.half.cross(b.half);
    let squared = cross.length_squared();
    if squared > PARALLEL * a.half.length_squared() * b.half.length_squared() {
        let normal = cross / squared.sqrt();
        return if normal.dot(b.center - a.center) < 0.0 { -normal } else { normal };
    }
    a.half.any_orthogonal_vector().normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn pose(x: f32, y: f32, z: f32, rotation: Quat) -> Pose3 {
        Pose3::from_parts(Vec3::new(x, y, z), rotation)
    }

    #[test]
    fn parallel_capsules_touch_at_both_ends_of_their_common_stretch() {
        let relative = pose(0.0, 1.0, 0.7, Quat::from_rotation_y(1.0));
        let manifold = capsule_capsule((1.0, 0.25), (1.5, 0.5), &relative, 0.0).expect("a contact");
        assert_eq!(manifold.count, 2);
        assert!((manifold.normal - Vec3::Z).length() < 1e-6, "normal {}", manifold.normal);
        for (point, y) in manifold.contacts().iter().zip([-0.5, 1.0]) {
            assert!((point.on_a - Vec3::new(0.0, y, 0.25)).length() < 1e-6, "point {}", point.on_a);
            assert!((point.separation + 0.05).abs() < 1e-6, "{} m", point.separation);
        }
        let upside_down = pose(0.0, 1.0, 0.7, Quat::from_rotation_x(std::f32::consts::PI));
        assert_eq!(capsule_capsule((1.0, 0.25), (1.5, 0.5), &upside_down, 0.0).expect("a contact").count, 2);
    }

    #[test]
    fn crossing_capsules_touch_at_one_point() {
        let relative = pose(0.0, 0.2, 0.7, Quat::from_rotation_z(1.0));
        let manifold = capsule_capsule((1.0, 0.25), (1.0, 0.5), &relative, 0.0).expect("a contact");
        assert_eq!(manifold.count, 1);
        assert!((manifold.normal - Vec3::Z).length() < 1e-6, "normal {}", manifold.normal);
        assert!((manifold.points[0].separation + 0.05).abs() < 1e-6, "{} m", manifold.points[0].separation);
    }

    #[test]
    fn the_surface_of_a_leaning_capsule_is_found_along_the_normal() {
        let (half, radius) = (1.0, 0.5);
        let capsule = parry3d::shape::Capsule::new_y(half, radius);
        let segment = Segment { center: Vec3::ZERO, half: Vec3::Y * half };
        for lean in [-1.5_f32, -0.9, -0.3, 0.0, 0.01, 0.5, 1.2] {
            let toward = Vec3::new(lean.cos(), lean.sin(), 0.0);
            for s in [-1.0, -0.6, 0.0, 0.9, 1.0] {
                let surface = segment.at(s) + toward * segment.depth_of(s, toward, radius);
                let off = parry3d::query::PointQuery::distance_to_local_point(&capsule, surface, false);
                assert!(off.abs() < 1e-5, "{off} m off the surface at lean {lean}, s {s}");
            }
        }
    }

    #[test]
    fn capsules_end_to_end_touch_at_one_point() {
        let relative = pose(0.0, 3.0, 0.0, Quat::IDENTITY);
        let manifold = capsule_capsule((1.0, 0.25), (1.0, 0.5), &relative, 1.0).expect("a contact");
        assert_eq!((manifold.count, manifold.normal, manifold.points[0].separation), (1, Vec3::Y, 0.25));
    }

    #[test]
    fn capsules_whose_axes_meet_part_across_both() {
        let relative = pose(0.0, 0.2, 0.0, Quat::from_rotation_z(1.0));
        let manifold = capsule_capsule((1.0, 0.25), (1.0, 0.5), &relative, 0.0).expect("a contact");
        assert!((manifold.normal.z.abs() - 1.0).abs() < 1e-6, "normal {}", manifold.normal);
        assert!((manifold.points[0].separation + 0.75).abs() < 1e-6, "{} m", manifold.points[0].separation);
        let same = capsule_capsule((1.0, 0.25), (1.0, 0.5), &Pose3::IDENTITY, 0.0).expect("a contact");
        assert!(same.normal.y == 0.0 && same.normal.is_normalized(), "normal {}", same.normal);
        assert_eq!((same.count, same.points[0].separation), (2, -0.75));
    }
}
