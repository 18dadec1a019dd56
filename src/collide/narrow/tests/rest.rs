//! Solids at rest on floors: every point that carries them is there, whatever the floor is made of.

use super::*;

#[test]
fn a_flat_floor_of_triangles_carries_a_box_evenly_and_straight_up() {
    let cube = Shape::cuboid(Vec3::new(0.5, 0.25, 0.5)).unwrap();
    for floor in [mesh_floor(8, 0.4), field_floor(8, 0.4)] {
        for (x, yaw) in [(0.0, 0.0), (0.013, 0.0), (0.2, 0.3), (-0.37, std::f32::consts::FRAC_PI_4)] {
            let pose = Pose3::from_parts(Vec3::new(x, 0.249, 0.11 * x), Quat::from_rotation_y(yaw));
            let found = manifolds(&floor, &cube, pose, 0.01);
            let area: f32 = found.iter().map(|m| spanned(m.contacts())).sum();
            for manifold in &found {
                assert!(manifold.normal.y > 0.9999, "a seam pushes along {}", manifold.normal);
                for point in manifold.contacts() {
                    assert!((point.separation + 0.001).abs() < 1e-5, "{} m", point.separation);
                    let off = (pose * point.on_b).y + 0.001;
                    assert!(off.abs() < 1e-5 && point.on_a.y.abs() < 1e-5, "{point:?}");
                }
            }
            // Polygons cut down to four points lose some of their area, but none of their contact.
            assert!((0.8..1.001).contains(&area), "contact over {area} m² of 1 m² at x = {x} m, yaw {yaw}");
            let mut parts: Vec<_> = found.iter().map(|m| m.part).collect();
            parts.dedup();
            assert_eq!(parts.len(), found.len(), "one manifold a triangle");
        }
    }
}

/// Area of the convex polygon through at most four points (m²).
fn spanned(points: &[ManifoldPoint]) -> f32 {
    let at = |i: usize| points[i].on_a;
    let triangle = |i: usize, j: usize, k: usize| 0.5 * (at(j) - at(i)).cross(at(k) - at(i)).length();
    match points.len() {
        3 => triangle(0, 1, 2),
        4 => {
            let diagonals = [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2)];
            diagonals.map(|(i, j, k, l)| 0.5 * (at(j) - at(i)).cross(at(l) - at(k)).length()).into_iter().fold(0.0, f32::max)
        }
        _ => 0.0,
    }
}

#[test]
fn a_ball_rolling_over_seams_is_pushed_straight_up() {
    let ball = Shape::ball(0.3).unwrap();
    for floor in [mesh_floor(4, 1.0), field_floor(4, 1.0)] {
        for step in 0..200 {
            let pose = Pose3::from_parts(Vec3::new(-1.0 + 0.01 * step as f32, 0.299, 0.3), Quat::IDENTITY);
            let found = manifolds(&floor, &ball, pose, 0.01);
            assert!(!found.is_empty(), "no contact at step {step}");
            for manifold in &found {
                assert!(manifold.normal.y > 0.999, "a seam pushes along {} at step {step}", manifold.normal);
            }
        }
    }
}

#[test]
fn every_solid_rests_on_every_floor() {
    let floors = [Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap(), mesh_floor(4, 1.0), field_floor(4, 1.0), {
        let slab = Geometry::Box { half_extents: Vec3::new(2.0, 1.0, 2.0) };
        Shape::new(Geometry::Compound { parts: vec![(LocalPose::at(Vec3::NEG_Y), slab)] }).unwrap()
    }];
    for (number, floor) in floors.iter().enumerate() {
        for kind in [0, 1, 2, 3, 4, 5, 10, 11] {
            let solid = specimen(kind, 0.5);
            let bottom = solid.parry().compute_local_aabb().mins.y;
            let pose = Pose3::from_parts(Vec3::new(0.13, -bottom - 0.002, 0.08), Quat::from_rotation_y(0.2));
            let found = manifolds(floor, &solid, pose, 0.005);
            let lowest = deepest(&found).unwrap_or(f32::MAX);
            assert!((lowest + 0.002).abs() < 1e-4, "{solid:?} on floor {number}: {lowest} m, expected -0.002 m");
            for manifold in &found {
                assert!(manifold.normal.y > 0.999, "{solid:?} on floor {number} is pushed along {}", manifold.normal);
            }
            let back = manifolds(&solid, floor, pose.inverse(), 0.005);
            let lowest = deepest(&back).unwrap_or(f32::MAX);
            assert!((lowest + 0.002).abs() < 1e-4, "floor {number} under {solid:?}: {lowest} m, expected -0.002 m");
            for manifold in &back {
                let up = pose.rotation * manifold.normal;
                assert!(up.y < -0.999, "floor {number} under {solid:?} is pushed along {up}");
            }
        }
    }
}

#[test]
fn flat_solids_rest_on_a_box_over_their_whole_base() {
    let table = Shape::cuboid(Vec3::new(2.0, 0.5, 2.0)).unwrap();
    let prism = (0..12).map(|i| {
        let (sin, cos) = ((i / 2) as f32 * std::f32::consts::FRAC_PI_3).sin_cos();
        Vec3::new(cos, (i % 2) as f32 - 0.5, sin)
    });
    let prism = Shape::new(Geometry::ConvexHull { points: prism.collect() }).unwrap();
    let drum = Shape::new(Geometry::Cylinder { half_height: 0.5, radius: 1.0 }).unwrap();
    let cone = Shape::new(Geometry::Cone { half_height: 0.5, radius: 1.0 }).unwrap();
    for solid in [prism, drum, cone] {
        for jitter in [0.0, 1e-6, -1e-6] {
            let pose = Pose3::from_parts(Vec3::new(0.1, 0.999, 0.2), Quat::from_rotation_z(jitter));
            let found = manifolds(&table, &solid, pose, 0.01);
            assert_eq!((found.len(), found[0].count), (1, 4), "{solid:?}");
            assert!(found[0].normal.y > 0.999_999, "normal {}", found[0].normal);
            let area = spanned(found[0].contacts());
            assert!(area > 1.7, "{solid:?} stands on {area} m²");
        }
    }
}

/// What stands on floors: each 0.5 m wide and high, on a flat base at y = −0.25 m; with the corners of the base (m).
fn standing() -> Vec<(&'static str, Shape, Vec<Vec3>)> {
    let half = 0.25;
    let ring = |count: usize| -> Vec<Vec3> {
        let at = |i: usize| (i as f32 * std::f32::consts::TAU / count as f32).sin_cos();
        (0..count).map(|i| Vec3::new(half * at(i).1, -half, half * at(i).0)).collect()
    };
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x, -1.0, z) * half).to_vec();
    let prism = ring(6).into_iter().flat_map(|p| [p, Vec3::new(p.x, half, p.z)]).collect();
    vec![
        ("box", Shape::cuboid(Vec3::splat(half)).unwrap(), square),
        ("cylinder", Shape::new(Geometry::Cylinder { half_height: half, radius: half }).unwrap(), ring(16)),
        ("cone", Shape::new(Geometry::Cone { half_height: half, radius: half }).unwrap(), ring(16)),
        ("hull", Shape::new(Geometry::ConvexHull { points: prism }).unwrap(), ring(6)),
    ]
}

fn flat_floors() -> Vec<(&'static str, Shape)> {
    let slab = |half: Vec3| Geometry::Box { half_extents: half };
    let hull = (0..8).map(|i| Vec3::new(sign(i & 1) * 2.0, (i >> 1 & 1) as f32 - 1.0, sign(i & 4) * 2.0)).collect();
    vec![
        ("half-space", Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap()),
        ("box", {
            let slab = slab(Vec3::new(2.0, 1.0, 2.0));
            Shape::new(Geometry::Compound { parts: vec![(LocalPose::at(Vec3::NEG_Y), slab)] }).unwrap()
        }),
        ("hull", Shape::new(Geometry::ConvexHull { points: hull }).unwrap()),
        ("mesh", mesh_floor(4, 1.0)),
        ("height field", field_floor(4, 1.0)),
    ]
}

fn sign(bit: i32) -> f32 {
    if bit == 0 { -1.0 } else { 1.0 }
}

/// A tilt (rad) about a horizontal axis under a turn about the vertical.
fn tilted(tilt: f32, toward: f32, turn: f32) -> Quat {
    let axis = Vec3::new(toward.cos(), 0.0, toward.sin());
    Quat::from_axis_angle(axis, tilt) * Quat::from_rotation_y(turn)
}

/// The place of a solid over a floor at y = 0 (m): its lowest corner at `height`.
fn over_floor(corners: &[Vec3], rotation: Quat, height: f32, x: f32, z: f32) -> Pose3 {
    let lowest = corners.iter().map(|&p| (rotation * p).y).fold(f32::MAX, f32::min);
    Pose3::from_parts(Vec3::new(x, height - lowest, z), rotation)
}

const TILTS: [f32; 5] = [0.0, 0.1, 0.5, 1.0, 2.0];

/// Turns that line edges up, nearly so, and not at all: direction of the tilt and turn about the vertical (rad).
const POSES: [(f32, f32); 7] = [(0.0, 0.0), (0.3, 0.0), (0.7854, 0.0), (0.2, 0.01), (0.2, 0.5), (1.0, 1.3), (2.5, 0.7854)];

/// A face's normal is no more than the tilt off the vertical, here 2°; rounding adds a little.
const FACE_LEAN: f32 = 2.1;

/// A line tilted by 2° has a common normal with a rim at 37° to it that is atan(tan 2° / sin 37°) = 3.3° off the vertical.
const RIM_LEAN: f32 = 3.4;

/// Checks the number of points, and how far (degrees) the normals lean from `up`.
fn assert_carried(found: &[Manifold], (up, allowed): (Vec3, f32), points: usize, case: &str) {
    let count: usize = found.iter().map(|m| usize::from(m.count)).sum();
    assert!(count >= points, "{case}: {count} points of at least {points}\n{found:?}");
    for manifold in found {
        let lean = manifold.normal.angle_between(up).to_degrees();
        assert!(lean <= allowed, "{case}: pushed {lean}° off the vertical, allowed {allowed}°\n{found:?}");
    }
}

#[test]
fn a_slightly_tilted_solid_keeps_its_base_on_every_floor() {
    let margin = 0.01;
    for (solid_name, solid, corners) in &standing() {
        for (floor_name, floor) in &flat_floors() {
            for (degrees, height) in TILTS.iter().flat_map(|&t| [(t, -1e-3), (t, 1e-3)]) {
                for (toward, turn) in POSES {
                    let rotation = tilted(f32::to_radians(degrees), toward, turn);
                    let pose = over_floor(corners, rotation, height, 0.13, 0.08);
                    // A point at the margin may be left out for rounding.
                    let near = corners.iter().filter(|&&corner| (pose * corner).y < margin - 1e-4).count();
                    let case = format!("{solid_name} on {floor_name}, {degrees}° toward {toward}, turned {turn}, at {height} m");
                    assert_carried(&manifolds(floor, solid, pose, margin), (Vec3::Y, FACE_LEAN), near.min(3), &case);
                    let back = manifolds(solid, floor, pose.inverse(), margin);
                    assert_carried(&back, (rotation.inverse() * Vec3::NEG_Y, FACE_LEAN), near.min(3), &format!("under {case}"));
                }
            }
        }
    }
}

#[test]
fn a_slightly_tilted_solid_keeps_its_base_on_one_of_its_own_size() {
    // At 2° the highest corner of a base 0.71 m across is 25 mm above the lowest.
    let margin = 0.03;
    for (solid_name, solid, corners) in &standing() {
        for (floor_name, floor, _) in standing().iter().filter(|(name, ..)| *name != "cone") {
            for (degrees, height) in TILTS.iter().flat_map(|&t| [(t, -1e-3), (t, 1e-3)]) {
                for (toward, turn) in POSES {
                    for (x, z) in [(0.0, 0.0), (2e-4, -1e-4), (1e-3, -2e-3), (0.01, 0.005), (0.1, 0.07)] {
                        let rotation = tilted(f32::to_radians(degrees), toward, turn);
                        let mut pose = over_floor(corners, rotation, height, x, z);
                        pose.translation.y += 0.25;
                        let case = format!(
                            "{solid_name} on {floor_name}, {degrees}° toward {toward}, turned {turn}, at {x}, {height}, {z} m"
                        );
                        assert_carried(&manifolds(floor, solid, pose, margin), (Vec3::Y, FACE_LEAN), 3, &case);
                        let back = manifolds(solid, floor, pose.inverse(), margin);
                        assert_carried(&back, (rotation.inverse() * Vec3::NEG_Y, FACE_LEAN), 3, &format!("under {case}"));
                    }
                }
            }
        }
    }
}

#[test]
fn a_slightly_tilted_capsule_lies_on_two_points_also_over_a_rim() {
    let (radius, margin) = (0.1, 0.03);
    let capsule = Shape::capsule(0.2, radius).unwrap();
    for (floor_name, floor, _) in standing().iter().filter(|(name, ..)| *name != "cone") {
        for (degrees, height) in TILTS.iter().flat_map(|&t| [(t, -1e-3), (t, 1e-3), (-t, 1e-3)]) {
            for (turn, x) in [(0.0, 0.0), (0.3, 0.0), (0.0, 0.1), (0.01, 0.1), (0.4, 0.15)] {
                let lying = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2 + f32::to_radians(degrees));
                let rotation = Quat::from_rotation_y(turn) * lying;
                let along = rotation * Vec3::new(0.0, 0.2, 0.0);
                // The height is that of the lower end, or of the axis over the rim.
                let reach = ((0.25 - x) / along.x.abs()).min(1.0) * along.y.abs();
                let pose = Pose3::from_parts(Vec3::new(x, 0.25 + radius + height + reach, 0.01), rotation);
                let case = format!("capsule on {floor_name}, {degrees}°, turned {turn}, {x} m off the middle, at {height} m");
                assert_carried(&manifolds(floor, &capsule, pose, margin), (Vec3::Y, RIM_LEAN), 2, &case);
                let back = manifolds(&capsule, floor, pose.inverse(), margin);
                assert_carried(&back, (rotation.inverse() * Vec3::NEG_Y, RIM_LEAN), 2, &format!("under {case}"));
            }
        }
    }
}
