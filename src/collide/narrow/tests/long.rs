//! What is small touches what is long where it is, as deep as it is.

use std::f32::consts::TAU;

use super::*;

/// Half the length of what is long (m).
const LONG: f32 = 40.0;

/// A long shape along z, placed in the frame of the test, with what may be touched there: an outward normal and the edge or side (x, y) it is of.
struct Long {
    shape: Shape,
    place: Pose3,
    touch: fn(f32) -> (Vec3, Vec3),
}

fn prism(radius: f32, half: f32) -> Shape {
    let corner = |i: i32| Quat::from_rotation_z(i as f32 * TAU / 6.0) * Vec3::new(radius, 0.0, half);
    let points = (0..6).flat_map(|i| [corner(i), corner(i) * Vec3::new(1.0, 1.0, -1.0)]).collect();
    Shape::new(Geometry::ConvexHull { points }).unwrap()
}

/// Normals within some 50° of one direction: share runs from 0 to 1.
fn around(share: f32, middle: f32, width: f32) -> Vec3 {
    Quat::from_rotation_z(middle + width * (share - 0.5)) * Vec3::X
}

fn long_shapes() -> [Long; 4] {
    let lying = Pose3::from_rotation(Quat::from_rotation_x(0.25 * TAU));
    let round = |geometry| Shape::new(geometry).unwrap();
    [
        Long {
            shape: Shape::cuboid(Vec3::new(1.0, 0.5, LONG)).unwrap(),
            place: Pose3::IDENTITY,
            touch: |share| (around(share, 0.125 * TAU, 0.24 * TAU), Vec3::new(1.0, 0.5, 0.0)),
        },
        Long {
            shape: prism(0.5, LONG),
            place: Pose3::IDENTITY,
            touch: |share| (around(share, 0.0, 0.16 * TAU), Vec3::new(0.5, 0.0, 0.0)),
        },
        Long {
            shape: round(Geometry::Cylinder { half_height: LONG, radius: 0.3 }),
            place: lying,
            touch: |share| (around(share, 0.0, TAU), 0.3 * around(share, 0.0, TAU)),
        },
        Long {
            shape: Shape::capsule(LONG, 0.02).unwrap(),
            place: lying,
            touch: |share| (around(share, 0.0, TAU), 0.02 * around(share, 0.0, TAU)),
        },
    ]
}

fn small(scale: f32) -> Vec<Shape> {
    let of = |geometry| Shape::new(geometry).unwrap();
    vec![
        of(Geometry::Cylinder { half_height: 0.1 * scale, radius: 0.35 * scale }),
        of(Geometry::Cylinder { half_height: 0.4 * scale, radius: 0.05 * scale }),
        of(Geometry::Cone { half_height: 0.3 * scale, radius: 0.35 * scale }),
        prism(0.3 * scale, 0.2 * scale),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: RngSeed::Fixed(11), ..ProptestConfig::default() })]

    /// With −n among the outward normals at a point of the one and n at a point of the other, they are as far apart as the points are along n.
    ///
    /// A search in `f32` took the far end of the box for what a wheel touches: 50 m away, along the normal of a face and centimetres deep.
    #[test]
    fn what_touches_the_edge_of_a_long_shape_touches_it_there(
        (across, along) in (0.0_f32..1.0, -0.7_f32..0.7),
        rotation in rotation(),
        depth in -1.0e-3_f32..1.0e-3,
        scale in prop_oneof![Just(1.0_f32), Just(0.1)],
    ) {
        for Long { shape, place, touch } in long_shapes() {
            for other in small(scale) {
                let (normal, on_long) = touch(across);
                let facing = other.parry().as_support_map().unwrap().local_support_point(rotation.inverse() * -normal);
                let at = on_long + Vec3::Z * along * LONG;
                let pose = Pose3::from_parts(at - normal * depth * scale - rotation * facing, rotation);
                for manifold in manifolds(&shape, &other, place.inverse() * pose, 1.0e-3 * scale) {
                    let separation = deepest(&[manifold]).unwrap();
                    let what = format!("{shape:?} {other:?} {pose:?}: {manifold:?}");
                    // Out of an overlap another way may be shorter.
                    let (expected, tolerance) = (-depth * scale, 1.2e-3 * scale + 1.0e-5);
                    let is_true = separation > expected - tolerance && separation < expected.max(0.0) + tolerance;
                    prop_assert!(is_true, "expected {expected} m, {what}");
                    for point in manifold.contacts() {
                        let (on_a, on_b) = (place * point.on_a, pose * point.on_b);
                        let reach = 1.1 * scale;
                        prop_assert!((on_a - at).length() < reach && (on_b - at).length() < reach, "not at {at}: {what}");
                    }
                }
            }
        }
    }
}

/// Past the edge by a rounding, a cylinder clipped to the face had one point, in the middle or at an end, and a barrel that rolled off a shelf was
/// turned askew.
#[test]
fn what_lies_along_an_edge_touches_it_with_both_ends() {
    let shelf = Vec3::new(5.0, 0.2, 2.0);
    let corner = |i: u32| 2.0 * shelf * (Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5);
    let hull = Shape::new(Geometry::ConvexHull { points: (0..8).map(corner).collect() }).unwrap();
    let shelves = [Shape::cuboid(shelf).unwrap(), hull];
    for radius in [0.35, 0.05] {
        let barrel = Shape::new(Geometry::Cylinder { half_height: 0.3, radius }).unwrap();
        for (step, shelf_shape) in (0..1000).flat_map(|step| shelves.iter().map(move |shape| (step, shape))) {
            let share = |k: u32| 1.0e-3 * ((step * 7 + k * 331) % 1000) as f32;
            let (angle, height) = (1.3 * share(0), radius + 2.0e-3 * share(1) - 1.0e-3);
            let position = Vec3::new(shelf.x + height * angle.sin(), shelf.y + height * angle.cos(), 0.1);
            let rotation = Quat::from_rotation_x(0.25 * TAU) * Quat::from_rotation_y(TAU * share(2));
            let found = manifolds(shelf_shape, &barrel, Pose3::from_parts(position, rotation), 0.01);
            let ends = found.iter().flat_map(Manifold::contacts).map(|point| point.on_a.z);
            let (low, high) = ends.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
            assert!((low + 0.2).abs() < 1.0e-3 && (high - 0.4).abs() < 1.0e-3, "at {angle} rad: {found:?}");
        }
    }
}
