//! Promises that hold for every pair of shapes, on random ones.

use glam::{Quat, Vec3};
use parry3d::math::Pose3;
use parry3d::query;
use proptest::prelude::*;

use super::*;
use crate::shape::{Geometry, LocalPose};

fn manifolds(a: &Shape, b: &Shape, relative: Pose3, margin: f32) -> Vec<Manifold> {
    let mut out = Vec::new();
    collide(a, b, relative, margin, &mut Scratch::default(), &mut out);
    out
}

fn deepest(manifolds: &[Manifold]) -> Option<f32> {
    manifolds.iter().flat_map(Manifold::contacts).map(|p| p.separation).reduce(f32::min)
}

/// Half of the greatest extent along a coordinate axis (m).
fn size(shape: &Shape) -> f32 {
    shape.parry().compute_local_aabb().half_extents().max_element().min(1e7)
}

fn direction() -> impl Strategy<Value = Vec3> {
    let c = -1.0_f32..1.0;
    (c.clone(), c.clone(), c).prop_filter_map("too short", |(x, y, z)| Vec3::new(x, y, z).try_normalize())
}

/// Any rotation, and often a multiple of 45° about an axis, where features line up.
fn rotation() -> impl Strategy<Value = Quat> {
    let any = (direction(), 0.0_f32..6.3).prop_map(|(axis, angle)| Quat::from_axis_angle(axis, angle));
    let aligned = (0..3_usize, 0..8_i32).prop_map(|(axis, turns)| {
        Quat::from_axis_angle([Vec3::X, Vec3::Y, Vec3::Z][axis], turns as f32 * std::f32::consts::FRAC_PI_4)
    });
    let almost = (aligned.clone(), direction(), -1e-3_f32..1e-3)
        .prop_map(|(q, axis, angle)| (q * Quat::from_axis_angle(axis, angle)).normalize());
    prop_oneof![2 => any, 1 => aligned, 1 => almost]
}

/// Two shapes of sizes within the ratio, the second placed somewhere between far inside and a size away.
fn pairs(shape: impl Fn(f32) -> BoxedStrategy<Shape>) -> impl Strategy<Value = (Shape, Shape, Pose3)> {
    (shape(1.0), shape(1.0), direction(), 0.0_f32..2.5, rotation()).prop_map(|(a, b, direction, reach, rotation)| {
        let pose = Pose3::from_parts(direction * reach * (size(&a) + size(&b)), rotation);
        (a, b, pose)
    })
}

fn extents(scale: f32) -> impl Strategy<Value = Vec3> {
    let edge = 0.1_f32..1.0;
    (edge.clone(), edge.clone(), edge).prop_map(move |(x, y, z)| Vec3::new(x, y, z) * scale)
}

fn boxes(scale: f32) -> BoxedStrategy<Shape> {
    extents(scale).prop_map(|half| Shape::cuboid(half).unwrap()).boxed()
}

fn own_pairs(scale: f32) -> BoxedStrategy<Shape> {
    let edge = 0.1_f32..1.0;
    prop_oneof![
        boxes(scale),
        edge.clone().prop_map(move |radius| Shape::ball(radius * scale).unwrap()),
        (edge.clone(), edge).prop_map(move |(height, radius)| Shape::capsule(height * scale, radius * scale).unwrap()),
    ]
    .boxed()
}

fn hull(scale: f32) -> BoxedStrategy<Shape> {
    let points = prop::collection::vec(direction(), 8..24);
    (points, extents(scale))
        .prop_filter_map("flat", |(points, half)| {
            Shape::new(Geometry::ConvexHull { points: points.into_iter().map(|p| p * half).collect() }).ok()
        })
        .boxed()
}

fn convex(scale: f32) -> BoxedStrategy<Shape> {
    let edge = 0.1_f32..1.0;
    let round = (edge.clone(), edge, any::<bool>()).prop_map(move |(half_height, radius, cone)| {
        let (half_height, radius) = (half_height * scale, radius * scale);
        let geometry = if cone { Geometry::Cone { half_height, radius } } else { Geometry::Cylinder { half_height, radius } };
        Shape::new(geometry).unwrap()
    });
    prop_oneof![own_pairs(scale), round, hull(scale)].boxed()
}

fn mesh_floor(cells: i32, cell: f32) -> Shape {
    let at = |i: i32| (i as f32 - 0.5 * cells as f32) * cell;
    let vertices = (0..=cells).flat_map(|z| (0..=cells).map(move |x| Vec3::new(at(x), 0.0, at(z)))).collect();
    let triangles = (0..cells * cells)
        .flat_map(|i| {
            let corner = (i / cells * (cells + 1) + i % cells) as u32;
            let (right, up) = (corner + 1, corner + cells as u32 + 1);
            [[corner, up, right], [right, up, up + 1]]
        })
        .collect();
    Shape::new(Geometry::TriangleMesh { vertices, triangles }).unwrap()
}

fn field_floor(cells: usize, cell: f32) -> Shape {
    let (count, extent) = (cells + 1, cells as f32 * cell);
    let heights = vec![0.0; count * count];
    Shape::new(Geometry::HeightField { rows: count, columns: count, heights, size_x: extent, size_z: extent }).unwrap()
}

fn compound() -> Shape {
    let bar = Geometry::Box { half_extents: Vec3::new(1.0, 0.25, 0.25) };
    let knob = Geometry::Ball { radius: 0.5 };
    let turned = LocalPose { position: Vec3::new(-1.0, 0.5, 0.0), rotation: Quat::from_rotation_z(1.0) };
    Shape::new(Geometry::Compound { parts: vec![(turned, bar), (LocalPose::at(Vec3::X), knob)] }).unwrap()
}

/// Greatest overlap or separation over all 15 axes in f64: the exact depth of overlapping boxes.
fn box_depth(a: Vec3, b: Vec3, relative: &Pose3) -> f64 {
    let (a, b, t) = (a.as_dvec3(), b.as_dvec3(), relative.translation.as_dvec3());
    let q = relative.rotation.as_dquat().normalize();
    let of_a = [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z];
    let of_b = of_a.map(|axis| q * axis);
    let crosses = of_a.iter().flat_map(|u| of_b.iter().map(move |v| u.cross(*v))).filter(|c| c.length() > 1e-6);
    let axes = of_a.into_iter().chain(of_b).chain(crosses.map(|c| c.normalize()));
    let reach =
        |axes: &[glam::DVec3; 3], half: glam::DVec3, n: glam::DVec3| (0..3).map(|i| half[i] * axes[i].dot(n).abs()).sum::<f64>();
    axes.map(|n| t.dot(n).abs() - reach(&of_a, a, n) - reach(&of_b, b, n)).fold(f64::MIN, f64::max)
}

fn half_extents(shape: &Shape) -> Vec3 {
    let Geometry::Box { half_extents } = *shape.geometry() else { panic!("not a box") };
    half_extents
}

/// Checks what every manifold promises.
fn check(a: &Shape, b: &Shape, relative: Pose3, margin: f32, found: &[Manifold]) {
    let scale = size(a).min(size(b));
    let rounding = 1e-3 * scale + 1e-6 * size(a).max(size(b)).max(relative.translation.length());
    for manifold in found {
        assert!(manifold.is_finite() && (1..=4).contains(&manifold.count), "{manifold:?}");
        assert!((manifold.normal.length() - 1.0).abs() < 1e-4, "normal {}", manifold.normal);
        for point in manifold.contacts() {
            assert!(point.separation <= margin, "{} m beyond the margin of {margin} m", point.separation);
            let along = manifold.normal.dot(relative * point.on_b - point.on_a);
            assert!((along - point.separation).abs() <= rounding, "separation {} m, points give {along} m", point.separation);
            for (shape, at) in [(a, point.on_a), (b, point.on_b)] {
                if !matches!(shape.geometry(), Geometry::HeightField { .. }) {
                    let off = shape.parry().distance_to_local_point(at, false).abs();
                    assert!(off <= rounding, "{at} is {off} m off the surface of {shape:?}, allowed {rounding} m\n{found:?}");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn overlapping_boxes_report_the_least_way_out((a, b, pose) in pairs(boxes)) {
        let depth = box_depth(half_extents(&a), half_extents(&b), &pose) as f32;
        let found = manifolds(&a, &b, pose, 0.0);
        check(&a, &b, pose, 0.0, &found);
        let bound = 1e-4 * size(&a).max(size(&b));
        match deepest(&found) {
            Some(separation) => prop_assert!((separation - depth).abs() <= bound, "{separation} m, SAT in f64 gives {depth} m"),
            None => prop_assert!(depth > -bound, "no contact at a depth of {depth} m"),
        }
    }

    #[test]
    fn separated_boxes_report_their_distance((a, b, pose) in pairs(boxes)) {
        let distance = query::distance(&Pose3::IDENTITY, &**a.parry(), &pose, &**b.parry()).unwrap().distance;
        prop_assume!(distance > 1e-3);
        let found = manifolds(&a, &b, pose, 10.0);
        check(&a, &b, pose, 10.0, &found);
        let separation = deepest(&found).expect("within the margin");
        prop_assert!((separation - distance).abs() <= 2e-3 * distance + 1e-4, "{separation} m, GJK gives {distance} m");
    }

    #[test]
    fn convex_pairs_agree_with_an_independent_query((a, b, pose) in pairs(convex)) {
        let found = manifolds(&a, &b, pose, 10.0);
        check(&a, &b, pose, 10.0, &found);
        let separation = deepest(&found).expect("within the margin");
        let reference = query::contact(&Pose3::IDENTITY, &**a.parry(), &pose, &**b.parry(), 10.0).unwrap();
        if let Some(reference) = reference {
            let bound = 3e-3 * reference.dist.abs() + 2e-3 * size(&a).max(size(&b));
            prop_assert!(
                separation <= reference.dist + bound && (reference.dist < 0.0 || separation >= reference.dist - bound),
                "{separation} m, parry3d gives {} m for {a:?} and {b:?} at {pose:?}", reference.dist
            );
        }
    }

    #[test]
    fn swapping_the_shapes_mirrors_the_manifold((a, b, pose) in pairs(convex)) {
        let forth = manifolds(&a, &b, pose, 0.5);
        let back = manifolds(&b, &a, pose.inverse(), 0.5);
        let bound = 3e-3 * size(&a).max(size(&b));
        match (deepest(&forth), deepest(&back)) {
            (Some(forth), Some(back)) => prop_assert!((forth - back).abs() <= bound, "{forth} m and {back} m"),
            (one, other) => prop_assert!(one.or(other).is_none_or(|s| s > 0.5 - bound), "{one:?} m and {other:?} m"),
        }
    }

    #[test]
    fn wild_input_gives_finite_contacts(
        (scale_a, scale_b) in (-3_i32..=3, -3_i32..=3),
        kinds in (0..12_usize, 0..12_usize),
        far in -6_i32..=12,
        direction in direction(),
        rotation in rotation(),
        margin in prop_oneof![Just(0.0_f32), Just(1e-3), Just(1.0), Just(1e3)],
    ) {
        let (a, b) = (specimen(kinds.0, 10.0_f32.powi(scale_a)), specimen(kinds.1, 10.0_f32.powi(scale_b)));
        for pose in [Pose3::from_parts(direction * 10.0_f32.powi(far), rotation), Pose3::from_rotation(rotation)] {
            for manifold in manifolds(&a, &b, pose, margin) {
                prop_assert!(manifold.is_finite() && (1..=4).contains(&manifold.count), "{manifold:?}");
                prop_assert!((manifold.normal.length() - 1.0).abs() < 1e-3, "normal {}", manifold.normal);
            }
        }
    }

    #[test]
    fn a_used_scratch_changes_nothing((a, b, pose) in pairs(convex), (c, d, other) in pairs(convex)) {
        let fresh = manifolds(&a, &b, pose, 1.0);
        let mut scratch = Scratch::default();
        let mut out = Vec::new();
        collide(&c, &d, other, 1.0, &mut scratch, &mut out);
        collide(&mesh_floor(2, 1.0), &c, other, 1.0, &mut scratch, &mut out);
        collide(&a, &b, pose, 1.0, &mut scratch, &mut out);
        prop_assert_eq!(out, fresh);
    }
}

fn specimen(kind: usize, scale: f32) -> Shape {
    let parts = |shape: Shape| shape.geometry().clone();
    match kind {
        0 => Shape::ball(scale).unwrap(),
        1 => Shape::cuboid(Vec3::new(1.0, 0.5, 0.25) * scale).unwrap(),
        2 => Shape::capsule(scale, 0.25 * scale).unwrap(),
        3 => Shape::new(Geometry::Cylinder { half_height: scale, radius: 0.5 * scale }).unwrap(),
        4 => Shape::new(Geometry::Cone { half_height: scale, radius: 0.5 * scale }).unwrap(),
        5 => {
            let points = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32 + 0.1) * scale);
            Shape::new(Geometry::ConvexHull { points: points.collect() }).unwrap()
        }
        6 => Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap(),
        7 => mesh_floor(3, scale),
        8 => field_floor(3, scale),
        9 => Shape::new(Geometry::Compound {
            parts: (0..6).map(|i| (LocalPose::at(Vec3::X * scale * i as f32), parts(specimen(i, scale)))).collect(),
        })
        .unwrap(),
        10 => Shape::cuboid(Vec3::new(1.0, 1.0, 1.0) * scale).unwrap(),
        _ => Shape::capsule(0.25 * scale, scale).unwrap(),
    }
}

#[test]
fn a_flat_floor_of_triangles_carries_a_box_evenly_and_straight_up() {
    let cube = Shape::cuboid(Vec3::new(0.5, 0.25, 0.5)).unwrap();
    for floor in [mesh_floor(8, 0.4), field_floor(8, 0.4)] {
        for (x, yaw) in [(0.0, 0.0), (0.013, 0.0), (0.2, 0.3), (-0.37, 0.7853982)] {
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

#[test]
fn parts_of_compounds_are_told_apart() {
    let floor = Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap();
    let found = manifolds(&floor, &compound(), Pose3::from_translation(Vec3::new(0.0, 0.4, 0.0)), 0.2);
    let parts: Vec<_> = found.iter().map(|m| m.part).collect();
    assert_eq!(parts, [0, 1]);
    let pair = manifolds(&compound(), &compound(), Pose3::from_translation(Vec3::new(0.0, 0.1, 0.2)), 0.2);
    let parts: Vec<_> = pair.iter().map(|m| m.part).collect();
    assert!(parts.is_sorted() && parts.contains(&0) && parts.contains(&3), "parts {parts:?}");
}
