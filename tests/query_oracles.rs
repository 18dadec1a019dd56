//! Every kind of query against an oracle that shares no code with it, for each pair of shapes, from a millimetre to ten kilometres.
//!
//! What proves an answer is a certificate. A distance d is right if two points of the two shapes are d apart and a plane keeps
//! the shapes d apart. A ray is right by bisection: how far a point is outside a convex shape is a convex function along it. A
//! cast is right if the shapes touch at its end and never overlap before.
//!
//! `tests/common/oracle.rs` has the variables by which ten thousand cases of each pair are run by hand.

use crate::common::oracle::{Dice, RELATIVE, ROUNDING, Scene, Solid, all, each};
use longspan::glam::{DQuat, DVec3, Vec3};
use longspan::{Cast, Geometry, Pose, Shape};

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
