//! Promises that hold for every pair of shapes, on random ones.

use glam::{Quat, Vec3};
use parry3d::math::Pose3;
use parry3d::query;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::box_box::{EDGE_LEAD, EDGE_LEAD_OF_SIZE};
use super::*;
use crate::shape::{Geometry, LocalPose};

mod long;
mod rest;

fn manifolds(a: &Shape, b: &Shape, relative: Pose3, margin: f32) -> Vec<Manifold> {
    let mut out = Vec::new();
    collide(a, b, relative, margin, &mut NarrowScratch::default(), &mut out);
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
        .prop_filter_map("no solid", |(points, half)| {
            let points = points.into_iter().map(|p| p * half).collect();
            Shape::new(Geometry::ConvexHull { points }).ok()
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

/// Distance between the planes across `normal` that hold A below and B above: no more than their distance (m).
fn support_gap(a: &Shape, b: &Shape, pose: &Pose3, normal: Vec3) -> f32 {
    let furthest = |shape: &Shape, direction: Vec3| shape.parry().as_support_map().unwrap().local_support_point(direction);
    let on_b = *pose * furthest(b, pose.rotation.inverse() * -normal);
    normal.dot(on_b - furthest(a, normal))
}

/// Normals across an edge of each, both ways: along one of them a face may be preferred to, the shapes are furthest apart.
fn common_normals(a: &Shape, b: &Shape, pose: &Pose3) -> impl Iterator<Item = Vec3> {
    let edges = |shape: &Shape| match shape.geometry() {
        Geometry::Box { .. } => vec![Vec3::X, Vec3::Y, Vec3::Z],
        Geometry::Capsule { .. } => vec![Vec3::Y],
        _ => vec![],
    };
    let (of_a, of_b): (Vec<_>, Vec<_>) = (edges(a), edges(b).into_iter().map(|edge| pose.rotation * edge).collect());
    let crosses: Vec<_> = of_a.iter().flat_map(|u| of_b.iter().filter_map(|v| u.cross(*v).try_normalize())).collect();
    crosses.into_iter().flat_map(|normal| [normal, -normal])
}

/// Directions spread evenly over the sphere.
fn directions(count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| {
        let y = 1.0 - (2 * i + 1) as f32 / count as f32;
        let (sin, cos) = (2.399_963_2 * i as f32).sin_cos();
        Vec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + Vec3::Y * y
    })
}

fn half_extents(shape: &Shape) -> Vec3 {
    let Geometry::Box { half_extents } = *shape.geometry() else { panic!("not a box") };
    half_extents
}

fn off_surface(shape: &Shape, point: Vec3) -> f32 {
    let Some(hull) = shape.hull() else {
        return shape.parry().distance_to_local_point(point, false).abs();
    };
    let above = hull.planes().iter().map(|(normal, offset)| normal.dot(point.as_dvec3()) - offset);
    above.fold(f64::MIN, f64::max).abs() as f32
}

/// Checks what every manifold promises, to a fraction of the larger shape's size.
fn check(a: &Shape, b: &Shape, relative: Pose3, margin: f32, found: &[Manifold], tolerance: f32) {
    let rounding = tolerance * size(a).max(size(b));
    for manifold in found {
        assert!(manifold.is_finite() && (1..=4).contains(&manifold.count), "{manifold:?}");
        assert!((manifold.normal.length() - 1.0).abs() < 1e-4, "normal {}", manifold.normal);
        for point in manifold.contacts() {
            assert!(point.separation <= margin, "{} m beyond the margin of {margin} m", point.separation);
            let along = manifold.normal.dot(relative * point.on_b - point.on_a);
            assert!((along - point.separation).abs() <= rounding, "separation {} m, points give {along} m", point.separation);
            for (shape, at) in [(a, point.on_a), (b, point.on_b)] {
                if !matches!(shape.geometry(), Geometry::HeightField { .. }) {
                    let off = off_surface(shape, at);
                    assert!(off <= rounding, "{at} is {off} m off the surface of {shape:?}, allowed {rounding} m\n{found:?}");
                }
            }
        }
    }
}

/// How much less than the greatest separation a manifold may report (m), when it is made along an axis on which the shapes are
/// `along` apart. Edges that beat a face of two boxes by no more than this leave the contact to the face (see box_box.rs): if
/// they are e apart and the face f, then e ≤ f + EDGE_LEAD |f| + EDGE_LEAD_OF_SIZE h, h the least half extent. Other pairs take
/// the best direction there is.
fn edge_lead(a: &Shape, b: &Shape, along: f32) -> f32 {
    match (a.geometry(), b.geometry()) {
        (&Geometry::Box { half_extents: a }, &Geometry::Box { half_extents: b }) => {
            EDGE_LEAD * along.abs() + EDGE_LEAD_OF_SIZE * a.min(b).min_element()
        }
        _ => 0.0,
    }
}

/// Proves the deepest point right, to a fraction `tolerance` of the size. Never more than what the shapes are apart in some
/// direction: their distance, or the shortest way out. Never less than along the normal, nor than in any direction less
/// the lead of edges. And apart, its points are no further from each other.
fn certify(a: &Shape, b: &Shape, pose: &Pose3, found: &[Manifold], tolerance: f32) -> Result<(), TestCaseError> {
    let separation = deepest(found).expect("within the margin");
    let bound = tolerance * (separation.abs() + size(a).max(size(b)));
    let along = support_gap(a, b, pose, found[0].normal);
    let lead = edge_lead(a, b, along);
    let proven = common_normals(a, b, pose).map(|normal| support_gap(a, b, pose, normal)).fold(along, f32::max);
    prop_assert!(separation <= proven + bound, "{separation} m, but no axis shows more than {proven} m");
    prop_assert!(separation >= along - bound, "{separation} m, but {along} m apart along the normal");
    prop_assert!(separation >= proven - lead - bound, "{separation} m, {proven} m along another axis; allowed lead {lead} m");
    if separation > bound {
        let deepest = found[0].contacts().iter().find(|p| p.separation == separation).unwrap();
        let offset = *pose * deepest.on_b - deepest.on_a;
        let (distance, aside) = (offset.length(), offset.reject_from(found[0].normal).length());
        // Points along a line of contact may be seen up to a twentieth of the radii from the side.
        prop_assert!(
            distance - separation <= bound || aside <= 0.05 * (size(a) + size(b)),
            "points {distance} m apart for a distance of {separation} m"
        );
    } else {
        for direction in directions(500) {
            let way_out = support_gap(a, b, pose, direction);
            prop_assert!(
                way_out <= separation + lead + bound,
                "{separation} m, but {way_out} m along {direction}; allowed lead {lead} m"
            );
        }
    }
    Ok(())
}

/// Two boxes, one on the other at most 3° from flat, from 20 mm apart to 10 mm deep: their size is up to 1 m.
fn stacked_boxes() -> impl Strategy<Value = (Shape, Shape, Pose3)> {
    let around = -1.0_f32..1.0;
    (boxes(1.0), boxes(1.0), (around.clone(), around), (direction(), 0.0_f32..0.05), -0.01_f32..0.02, 0.0_f32..6.3).prop_map(
        |(a, b, (x, z), (axis, tilt), gap, turn)| {
            let rotation = Quat::from_axis_angle(axis, tilt) * Quat::from_rotation_y(turn);
            let (half_a, half_b) = (half_extents(&a), half_extents(&b));
            let reach = half_b.dot((rotation.inverse() * Vec3::Y).abs());
            let reach_aside = 0.5 * (half_a + half_b);
            let position = Vec3::new(x * reach_aside.x, half_a.y + reach + gap, z * reach_aside.z);
            (a, b, Pose3::from_parts(position, rotation))
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn overlapping_boxes_report_the_least_way_out_up_to_the_lead_of_edges((a, b, pose) in pairs(boxes)) {
        let depth = box_depth(half_extents(&a), half_extents(&b), &pose) as f32;
        let found = manifolds(&a, &b, pose, 0.0);
        check(&a, &b, pose, 0.0, &found, 2e-4);
        let bound = 1e-4 * (size(&a).max(size(&b)) + depth.abs());
        match deepest(&found) {
            Some(separation) => {
                let lead = edge_lead(&a, &b, support_gap(&a, &b, &pose, found[0].normal));
                prop_assert!(
                    separation <= depth + bound && separation >= depth - lead - bound,
                    "{separation} m, SAT in f64 gives {depth} m, allowed lead {lead} m"
                );
            }
            None => prop_assert!(depth > -bound, "no contact at a depth of {depth} m"),
        }
    }

    #[test]
    fn boxes_near_rest_report_no_more_than_their_distance_and_no_less_than_it_by_the_lead_of_edges(
        (a, b, pose) in stacked_boxes(),
    ) {
        let found = manifolds(&a, &b, pose, 10.0);
        check(&a, &b, pose, 10.0, &found, 5e-4);
        certify(&a, &b, &pose, &found, 3e-4)?;
    }

    #[test]
    fn balls_boxes_and_capsules_report_their_distance_or_least_overlap((a, b, pose) in pairs(own_pairs)) {
        let found = manifolds(&a, &b, pose, 10.0);
        check(&a, &b, pose, 10.0, &found, 5e-4);
        certify(&a, &b, &pose, &found, 2e-3)?;
    }

    #[test]
    fn convex_pairs_report_their_distance_or_least_overlap((a, b, pose) in pairs(convex)) {
        let found = manifolds(&a, &b, pose, 10.0);
        // EPA's points of an overlap lie on the chords of round shapes.
        let overlap = deepest(&found).is_some_and(|s| s < 0.0);
        check(&a, &b, pose, 10.0, &found, if overlap { 5e-2 } else { 5e-3 });
        // What GJK, EPA and the snap to faces may miss together on round shapes.
        certify(&a, &b, &pose, &found, 5e-3)?;
    }

    #[test]
    fn convex_pairs_agree_with_an_independent_query((a, b, pose) in pairs(convex)) {
        let reference = query::contact(&Pose3::IDENTITY, &**a.parry(), &pose, &**b.parry(), 10.0).unwrap();
        let Some(reference) = reference else { return Err(TestCaseError::reject("no answer")) };
        // The query sometimes stops short of the nearest points; then its normal does not bear its distance out.
        let bound = 3e-3 * reference.dist.abs() + 1e-3 * size(&a).max(size(&b));
        let proven = support_gap(&a, &b, &pose, reference.normal1);
        prop_assume!((proven - reference.dist).abs() <= bound);
        let separation = deepest(&manifolds(&a, &b, pose, 10.0)).expect("within the margin");
        // Between boxes, a face is preferred to edges that part them a little sooner.
        let lead = edge_lead(&a, &b, reference.dist);
        prop_assert!(
            separation - reference.dist <= 2.0 * bound && reference.dist - separation <= 2.0 * bound + lead,
            "{separation} m, parry3d gives {} m for {a:?} and {b:?} at {pose:?}", reference.dist
        );
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

    /// Of what is apart any direction may be told; what overlaps may go back along one that is longer by a hundredth of its reach.
    #[test]
    fn the_last_normal_changes_no_distance((a, b, pose) in pairs(convex), wild in direction()) {
        let fresh = manifolds(&a, &b, pose, 1.0);
        let Some(distance) = deepest(&fresh) else { return Ok(()) };
        let (mut scratch, mut out) = (NarrowScratch::default(), Vec::new());
        for last in [fresh[0].normal, wild, Vec3::X, Vec3::NEG_Y, Vec3::Z] {
            scratch.last = Some(last);
            collide(&a, &b, pose, 1.0, &mut scratch, &mut out);
            let reach = size(&a).min(size(&b)) * 3.0_f32.sqrt();
            let found = deepest(&out).unwrap_or(f32::INFINITY);
            let least = if distance > 0.0 { 0.005 } else { 0.012 };
            prop_assert!(found >= distance - least * reach, "{found} m after {last}, {distance} without: {a:?} {b:?} {pose:?}");
            prop_assert!(found <= distance + 0.005 * reach || distance > 0.99, "{found} m after {last}, {distance} without: {a:?} {b:?}");
        }
    }

    #[test]
    fn a_used_scratch_changes_nothing((a, b, pose) in pairs(convex), (c, d, other) in pairs(convex)) {
        let fresh = manifolds(&a, &b, pose, 1.0);
        let mut scratch = NarrowScratch::default();
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
fn parts_of_compounds_are_told_apart() {
    let floor = Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap();
    let found = manifolds(&floor, &compound(), Pose3::from_translation(Vec3::new(0.0, 0.4, 0.0)), 0.2);
    let parts: Vec<_> = found.iter().map(|m| m.part).collect();
    assert_eq!(parts, [0, 1]);
    let pair = manifolds(&compound(), &compound(), Pose3::from_translation(Vec3::new(0.0, 0.1, 0.2)), 0.2);
    let parts: Vec<_> = pair.iter().map(|m| m.part).collect();
    assert!(parts.is_sorted() && parts.contains(&0) && parts.contains(&3), "parts {parts:?}");
}
