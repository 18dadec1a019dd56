//! Every kind of query against an oracle that shares no code with it, for each pair of shapes, from a millimetre to ten kilometres.
//!
//! What proves an answer is a certificate. A distance d is right if two points of the two shapes are d apart and a plane keeps
//! the shapes d apart. A ray is right by bisection: how far a point is outside a convex shape is a convex function along it. A
//! cast is right if the shapes touch at its end and never overlap before.
//!
//! `tests/common/oracle.rs` has the variables by which ten thousand cases of each pair are run by hand.

use crate::common::oracle::{Dice, RELATIVE, ROUNDING, Scene, Solid, add, all, dice, each};
use longspan::glam::{DQuat, DVec3, Quat, Vec3};
use longspan::{BodyDef, Cast, Distance, Geometry, LocalPose, Pose, Shape, ShapeDef, World, WorldDef};

/// Where a ray enters a convex shape, by bisection (m).
fn entry(solid: &Solid, origin: DVec3, direction: DVec3, length: f64) -> Option<f64> {
    let outside = |t: f64| solid.outside(origin + direction * t);
    let (mut low, mut high) = (0.0, length);
    for _ in 0..200 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if outside(a) < outside(b) { high = b } else { low = a }
    }
    let deepest = 0.5 * (low + high);
    if outside(deepest) > 0.0 {
        return None;
    }
    let (mut before, mut inside) = (0.0, deepest);
    if outside(before) <= 0.0 {
        return Some(0.0);
    }
    for _ in 0..100 {
        let middle = 0.5 * (before + inside);
        if outside(middle) > 0.0 { before = middle } else { inside = middle }
    }
    Some(inside)
}

#[test]
fn rays_meet_what_bisection_meets() {
    each(1, |dice, (kind, _), scale| {
        let target_pose = dice.pose(DVec3::ZERO);
        let scene = Scene::new(dice.form(kind, scale), target_pose);
        let far = if dice.between(0.0, 1.0) < 0.2 { 300.0 } else { 4.0 };
        let origin = dice.direction() * dice.between(0.0, far) * scale;
        let path = dice.direction() * dice.between(0.0, 1.3) * scale - origin;
        let (direction, length) = (path.normalize(), path.length() * dice.between(0.5, 3.0));
        let found = scene.world.cast(&Cast::ray(origin, direction * length), &all()).unwrap();
        let expected = entry(&scene.target, origin, direction, length);
        // A ray that grazes is decided by rounding; how far it is off the surface there is known.
        let slack = 1.0e-9 * (scale + length);
        match (found, expected) {
            (Some(found), Some(expected)) => {
                let depth = scene.target.outside(origin + direction * (0.5 * (found.distance + expected)));
                let is_near = (found.distance - expected).abs() <= slack * 1.0e3 || depth.abs() <= slack;
                let on_ray = (found.point - origin - direction * found.distance).length() <= slack;
                let faces =
                    f64::from(found.normal.length() - 1.0).abs() < 1.0e-5 && found.normal.as_dvec3().dot(direction) < 1.0e-6;
                // Just under the surface along the normal is inside, just above it is outside.
                let above = |height: f64| scene.target.outside(found.point + found.normal.as_dvec3() * height * scale);
                let is_normal = expected == 0.0 || (above(1.0e-4) > 0.0 && above(1.0e-4) > above(-1.0e-4));
                (is_near && on_ray && faces && is_normal).then_some(()).ok_or(format!("{found:?}, expected {expected} m"))
            }
            (None, None) => Ok(()),
            (Some(found), None) if scene.target.outside(found.point).abs() <= slack => Ok(()),
            (None, Some(expected)) => {
                let deepest = (0..=200).map(|i| expected + (length - expected) * f64::from(i) / 200.0);
                let deepest = deepest.map(|t| scene.target.outside(origin + direction * t)).fold(f64::MAX, f64::min);
                (deepest >= -slack).then_some(()).ok_or(format!("missed at {expected} m, {deepest} m deep"))
            }
            (Some(found), None) => Err(format!("invented {found:?}")),
        }
    });
}

fn at_random(dice: &mut Dice) -> Pose {
    let position = dice.vector(1000.0);
    dice.pose(position)
}

/// A target and a probe near it or overlapping it, by a chosen gap; and what errors are allowed (m).
fn pair(dice: &mut Dice, (target, probe): (usize, usize), scale: f64) -> (Scene, Solid, f64) {
    let ratio = [1.0, 1.0, 0.01, 100.0][dice.between(0.0, 4.0) as usize % 4];
    let other = (scale * ratio).clamp(1.0e-3, 1.0e4);
    let target_pose = at_random(dice);
    let scene = Scene::new(dice.form(target, scale), target_pose);
    let (least, greatest) = (scale.min(other), scale.max(other));
    let mut solid = Solid::new(dice.form(probe, other), dice.pose(DVec3::ZERO));
    let toward = match scene.target.geometry {
        Geometry::HalfSpace { normal } => scene.target.rotation() * normal.as_dvec3().normalize(),
        _ => dice.direction(),
    };
    // Along this direction they are apart by the gap: in all, by no more.
    let gap = match dice.between(0.0, 4.0) as usize {
        0 => -0.3 * dice.between(0.0, 1.0) * least,
        1 => 1.0e-4 * dice.between(0.0, 1.0) * least,
        2 => dice.between(0.0, 1.0) * least,
        _ => dice.between(0.0, 3.0) * greatest,
    };
    let aside = dice.direction() * least * dice.between(0.0, 0.5);
    solid.pose.position = target_pose.position + aside - toward * aside.dot(toward);
    let off = gap - scene.target.apart(&solid, toward);
    solid.pose.position += toward * off;
    (scene, solid, RELATIVE * least + ROUNDING * (greatest + 1000.0))
}

#[test]
fn distances_are_certified_by_points_and_planes() {
    each(6, |dice, kinds, scale| {
        let (scene, probe, allowed) = pair(dice, kinds, scale);
        let shape = Shape::new(probe.geometry.clone()).unwrap();
        let found = scene.world.nearest_shape(&shape, probe.pose, 1.0e7, &all()).unwrap().ok_or("nothing found")?;
        let distance = found.distance;
        let normal = distance.normal.as_dvec3().normalize();
        // A normal of single precision tilts the plane over the whole extent of what lies flat on it.
        let extent = [&scene.target, &probe].map(|solid| match solid.geometry {
            Geometry::HalfSpace { .. } => 0.0,
            _ => {
                solid.top(normal) + solid.top(-normal) + solid.top(normal.any_orthonormal_vector())
                    - normal.any_orthonormal_vector().dot(solid.pose.position)
            }
        });
        let tilt = 2.0e-7 * extent[0].max(extent[1]);
        let plane = scene.target.apart(&probe, normal);
        let offset = distance.point_b - distance.point_a;
        let outside = [scene.target.outside(distance.point_a), probe.outside(distance.point_b)];
        let mut problems = Vec::new();
        if (plane - distance.distance).abs() > allowed + tilt {
            problems.push(format!("the plane shows {plane} m"));
        }
        if (offset.dot(normal) - distance.distance).abs() > allowed + tilt {
            problems.push(format!("points {} m apart along the normal", offset.dot(normal)));
        }
        if distance.distance > 0.0 && (offset.length() - distance.distance).abs() > allowed + tilt {
            problems.push(format!("points {} m apart", offset.length()));
        }
        if outside.iter().any(|&outside| outside > allowed + tilt) {
            problems.push(format!("points {outside:?} m outside"));
        }
        if distance.distance < 0.0 && kinds.0 != 6 {
            // No other way out is shorter.
            let shorter = (0..60).map(|i| match i % 3 {
                0 => dice.direction(),
                1 => (normal + dice.direction() * 0.05).normalize(),
                _ => (normal + dice.direction() * 1.0e-3).normalize(),
            });
            let best = shorter.map(|direction| scene.target.apart(&probe, direction)).fold(f64::MIN, f64::max);
            if best > distance.distance + allowed + tilt {
                problems.push(format!("another way out is {best} m"));
            }
        }
        let mut overlapping = Vec::new();
        scene.world.overlap_shape(&shape, probe.pose, &all(), &mut overlapping).unwrap();
        if distance.distance.abs() > allowed && overlapping.is_empty() == (distance.distance < 0.0) {
            problems.push(format!("overlap found: {}", !overlapping.is_empty()));
        }
        problems.is_empty().then_some(()).ok_or(format!("{} m, but {}", distance.distance, problems.join(", ")))
    });
}

#[test]
fn casts_end_where_shapes_touch_and_pass_through_nothing() {
    each(6, |dice, kinds, scale| {
        let (scene, probe, allowed) = pair(dice, kinds, scale);
        let shape = Shape::new(probe.geometry.clone()).unwrap();
        let gap_at = |pose: Pose| {
            let found = scene.world.nearest_shape(&shape, pose, 1.0e7, &all()).unwrap();
            found.map_or(f64::INFINITY, |found| found.distance.distance)
        };
        let start = gap_at(probe.pose);
        let toward = (scene.target.pose.position - probe.pose.position).normalize_or(DVec3::NEG_Y);
        let length = start.max(0.0) * 1.5 + scale * dice.between(0.2, 3.0);
        let path = (toward + dice.direction() * dice.between(0.0, 2.0)).normalize_or(DVec3::X) * length;
        let turn =
            if dice.between(0.0, 1.0) < 0.5 { Vec3::ZERO } else { dice.direction().as_vec3() * dice.between(0.0, 3.0) as f32 };
        let cast = Cast { turn, ..Cast::new(&shape, probe.pose, path) };
        let at = |share: f64| Pose {
            position: probe.pose.position + path * share,
            rotation: (DQuat::from_scaled_axis(turn.as_dvec3() * share) * probe.rotation()).as_quat(),
        };
        let hit = scene.world.cast(&cast, &all()).unwrap();
        // Poses have rotations of single precision; a turning solid that grazes may be stopped early.
        let allowed = 1.0e2 * allowed + if turn == Vec3::ZERO { 0.0 } else { 1.0e-6 * reach(&probe) };
        let before = hit.map_or(1.0, |hit| hit.fraction);
        let deepest = least_gap(|share| gap_at(at(share * before)), turn == Vec3::ZERO);
        let from_start = hit.is_some_and(|hit| hit.fraction == 0.0);
        if deepest < -allowed && !from_start {
            return Err(format!("passes through {deepest} m before {hit:?}"));
        }
        let Some(hit) = hit else { return Ok(()) };
        let off = scene.target.outside(hit.point);
        let mut problems = Vec::new();
        if from_start {
            if start > allowed || (hit.depth + start.min(0.0)).abs() > allowed {
                problems.push(format!("{start} m apart at the start"));
            }
        } else {
            let left = gap_at(at(hit.fraction));
            if left.abs() > allowed {
                problems.push(format!("{left} m are left"));
            }
            if (hit.distance - hit.fraction * length).abs() > ROUNDING * length {
                problems.push("distance and fraction differ".to_owned());
            }
            if turn == Vec3::ZERO && hit.normal.as_dvec3().dot(path) > 1.0e-6 * length {
                problems.push("the normal points along the path".to_owned());
            }
        }
        if off.abs() > allowed && !(from_start && off < 0.0) {
            problems.push(format!("the point is {off} m off the surface"));
        }
        problems.is_empty().then_some(()).ok_or(format!("{}: {hit:?} turning by {turn}", problems.join(", ")))
    });
}

/// The least gap over a motion, from 0 to 1. On a straight path the gap of two convex forms is a convex function.
fn least_gap(gap: impl Fn(f64) -> f64, is_convex: bool) -> f64 {
    let count = if is_convex { 1 } else { 24 };
    let gaps: Vec<f64> = (0..=count).map(|i| gap(f64::from(i) / f64::from(count))).collect();
    let lowest = (0..gaps.len()).fold(0, |best, i| if gaps[i] < gaps[best] { i } else { best });
    let at = |i: usize| i.min(gaps.len() - 1) as f64 / f64::from(count);
    let (mut low, mut high) = (at(lowest.saturating_sub(1)), at(lowest + 1));
    let mut least = gaps[lowest];
    // By golden sections, to a millionth of the way.
    for _ in 0..if is_convex { 30 } else { 12 } {
        let cut = 0.381_966 * (high - low);
        let (left, right) = (gap(low + cut), gap(high - cut));
        least = least.min(left).min(right);
        if left < right { high -= cut } else { low += cut }
    }
    least
}

/// At least the distance from its origin to its farthest point (m).
fn reach(solid: &Solid) -> f64 {
    let farthest = |direction: DVec3| solid.top(direction) - solid.pose.position.dot(direction);
    DVec3::AXES.iter().map(|&axis| farthest(axis).max(farthest(-axis))).fold(0.0, f64::max) * 3.0_f64.sqrt()
}

#[test]
fn nearest_points_are_on_the_surface_and_nothing_is_nearer() {
    each(1, |dice, (kind, _), scale| {
        let pose = at_random(dice);
        let scene = Scene::new(dice.form(kind, scale), pose);
        let point = pose.position + dice.direction() * dice.between(0.0, 4.0) * scale;
        let found = scene.world.nearest_point(point, 1.0e7, &all()).unwrap().ok_or("nothing found")?;
        let allowed = RELATIVE * scale + ROUNDING * 1000.0;
        if scene.target.outside(point) <= 0.0 {
            return (found.distance <= allowed).then_some(()).ok_or(format!("{found:?} of a point inside"));
        }
        // The plane through the nearest point across the way there keeps the shape apart.
        let way = (point - found.point).normalize_or(DVec3::X);
        let plane = if kind == 6 { scene.target.outside(point) } else { way.dot(point) - scene.target.top(way) };
        let is_right = (plane - found.distance).abs() <= allowed
            && scene.target.outside(found.point) <= allowed
            && ((point - found.point).length() - found.distance).abs() <= allowed;
        is_right.then_some(()).ok_or(format!("{found:?}, {plane} m by a plane"))
    });
}

#[test]
fn a_ray_from_inside_a_cone_meets_it_where_it_begins() {
    let mut dice = dice(11);
    for size in [0.01, 1.0, 100.0] {
        for round in 0..200 {
            let (height, radius) = (dice.between(0.2, 1.0) * size, dice.between(0.2, 1.0) * size);
            let geometry = Geometry::Cone { half_height: height as f32, radius: radius as f32 };
            let scene = Scene::new(geometry, dice.pose(DVec3::ZERO));
            let y = dice.between(-0.99, 0.9) * height;
            let aside = if round % 2 == 0 { 0.0 } else { radius * (height - y) / (2.0 * height) * dice.between(0.0, 0.9) };
            let turn = scene.target.rotation();
            for along in [-1.0, 1.0] {
                let ray = Cast::ray(
                    turn * DVec3::new(aside, y, 0.0),
                    turn * DVec3::new(0.0, along * dice.between(0.1, 5.0) * size, 0.0),
                );
                let found = scene.world.cast(&ray, &all()).unwrap();
                let what = format!("{:?}, {aside} m beside the axis, {y} m up, towards {along}", scene.target.geometry);
                assert_eq!(found.map(|found| found.distance), Some(0.0), "{what}");
            }
        }
    }
}

/// What is between two shapes, each on a body of its own.
fn between(a: (&Geometry, Pose), b: (&Geometry, Pose)) -> Distance {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let [a, b] = [a, b].map(|(geometry, pose)| add(&mut world, geometry.clone(), pose));
    world.shape_distance(a, b).unwrap()
}

#[test]
fn a_ball_inside_a_solid_is_as_deep_as_its_nearest_face_says() {
    let mut dice = dice(12);
    for kind in [1, 3, 4, 5] {
        for round in 0..200 {
            let geometry = dice.form(kind, 1.0);
            let (pose, radius) = (dice.pose(DVec3::ZERO), dice.between(0.05, 1.0) as f32);
            let solid = Solid::new(geometry.clone(), pose);
            // Every other one on the axis.
            let beside = if round % 2 == 0 { DVec3::ZERO } else { dice.vector(0.3) };
            let center = solid.rotation() * (DVec3::Y * dice.between(-0.5, 0.5) + beside);
            let outside = solid.outside(center);
            if outside < 0.0 {
                let found = between((&geometry, pose), (&Geometry::Ball { radius }, Pose::at(center)));
                let expected = outside - f64::from(radius);
                let off = (found.distance - expected).abs();
                assert!(off < 1.0e-8, "{geometry:?}, a ball of {radius} m at {center}: {found:?}, expected {expected} m");
            }
        }
    }
}

#[test]
fn the_deepest_points_of_round_solids_are_opposite_each_other() {
    let mut dice = dice(13);
    for round in 0..3000 {
        let kinds = [2 + round % 3, 2 + round / 3 % 3];
        let [a, b] = kinds.map(|kind| dice.form(kind, 1.0));
        let poses = [dice.pose(DVec3::ZERO), {
            let at = dice.vector(0.7);
            dice.pose(at)
        }];
        let found = between((&a, poses[0]), (&b, poses[1]));
        if found.distance < 0.0 {
            let aside = (found.point_b - found.point_a - found.normal.as_dvec3() * found.distance).length();
            // The normal is of single precision.
            assert!(aside < 3.0e-7, "{a:?} and {b:?}, {poses:?}: points {aside} m beside each other, {found:?}");
        }
    }
}

#[test]
fn round_solids_about_one_line_are_as_deep_as_their_radii_say() {
    let (outer, inner) =
        (Geometry::Cylinder { half_height: 3.0, radius: 1.0 }, Geometry::Cylinder { half_height: 2.0, radius: 0.75 });
    let mut dice = dice(14);
    for _ in 0..50 {
        let pose = dice.pose(DVec3::ZERO);
        let beside = Pose { position: pose.rotation.as_dquat().normalize() * DVec3::Y * dice.between(-1.0, 1.0), ..pose };
        let found = between((&outer, pose), (&inner, beside));
        assert!((found.distance + 1.75).abs() < 1.0e-6, "{pose:?}: {found:?}, expected -1.75 m");
    }
}

#[test]
fn equal_cubes_turned_by_a_quarter_are_one_edge_deep() {
    let points = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0).collect();
    let cube = Geometry::ConvexHull { points };
    for axis in Vec3::AXES {
        for quarters in -1_i8..=1 {
            let turn = Quat::from_axis_angle(axis, f32::from(quarters) * std::f32::consts::FRAC_PI_2);
            let found = between((&cube, Pose::IDENTITY), (&cube, Pose::IDENTITY.rotated(turn)));
            assert!((found.distance + 2.0).abs() < 1.0e-6, "turned about {axis} by {quarters}: {found:?}, expected -2 m");
        }
    }
}

#[test]
fn a_shape_beside_its_body_is_where_both_poses_put_it() {
    let mut dice = dice(15);
    for size in [1.0, 100.0, 10_000.0] {
        for round in 0..100 {
            let half = Vec3::new(1.0, 0.3, 0.7) * size as f32;
            let mut local = dice.pose(DVec3::ZERO);
            local.position = dice.vector(size).as_vec3().as_dvec3();
            let local_pose = LocalPose { position: local.position.as_vec3(), rotation: local.rotation };
            let shape = ShapeDef { local_pose, density: 1.0e-3, ..ShapeDef::new(Shape::cuboid(half).unwrap()) };
            let pose = dice.pose(DVec3::ZERO);
            let def = if round % 2 == 0 { BodyDef::fixed(pose) } else { BodyDef::dynamic(pose) };
            let mut world = World::new(&WorldDef::default()).unwrap();
            let body = world.create_body(&def.with_shape(shape)).unwrap();
            let pose = world.pose(body).unwrap();
            let [outer, inner] = [pose.rotation, local.rotation].map(|turn| turn.as_dquat().normalize());
            // 2 mm above its upper face.
            let on_box = DVec3::new(dice.between(-0.9, 0.9), 1.0, dice.between(-0.9, 0.9)) * half.as_dvec3() + DVec3::Y * 2.0e-3;
            let point = pose.position + outer * (local.position + inner * on_box);
            let found = world.nearest_point(point, 1.0, &all()).unwrap().expect("the box is near");
            let off = (found.distance - 2.0e-3).abs();
            assert!(off < 1.0e-9 * size + 1.0e-10, "a box of {size} m, {local:?} on {pose:?}: off by {off} m");
        }
    }
}
