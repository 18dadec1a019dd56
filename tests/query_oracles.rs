//! Every kind of query against an oracle that shares no code with it, for each pair of shapes, from a millimetre to ten kilometres.
//!
//! What proves an answer is a certificate. A distance d is right if two points of the two shapes are d apart and a plane keeps
//! the shapes d apart. A ray is right by bisection: how far a point is outside a convex shape is a convex function along it. A
//! cast is right if the shapes touch at its end and never overlap before.
//!
//! LONGSPAN_QUERY_CASES sets the number of random cases of each pair at each scale (10 by default; by hand, 10000).
//! LONGSPAN_QUERY_SCALES=first..last takes some of the scales, to split a long run; LONGSPAN_QUERY_SEED takes other cases.

#![allow(clippy::needless_range_loop, reason = "kinds are named by their numbers")]

use longspan::glam::{DQuat, DVec3, Quat, Vec3};
use longspan::{BodyDef, Cast, Geometry, Pose, QueryFilter, Shape, ShapeDef, ShapeId, World, WorldDef};

const SCALES: [f64; 5] = [1.0e-3, 0.03, 1.0, 50.0, 1.0e4];

/// Error that is allowed, over the smaller shape: what single-precision normals and witness points on needles leave.
const RELATIVE: f64 = 1.0e-6;

/// Error that is allowed, over the larger shape and the distance from the world's origin: rounding of doubles.
const ROUNDING: f64 = 1.0e-12;

fn number(name: &str, ordinary: usize) -> usize {
    std::env::var(name).map_or(ordinary, |text| text.parse().expect("a number"))
}

fn cases() -> usize {
    number("LONGSPAN_QUERY_CASES", 10)
}

/// The scales to look at, each with its number.
fn scales() -> impl Iterator<Item = (usize, f64)> {
    let chosen = std::env::var("LONGSPAN_QUERY_SCALES").unwrap_or_else(|_| format!("0..{}", SCALES.len()));
    let (first, last) = chosen.split_once("..").expect("first..last");
    let chosen = first.parse::<usize>().expect("a number")..last.parse().expect("a number");
    chosen.map(|number| (number, SCALES[number]))
}

/// Random numbers for the cases of this number.
fn dice(number: usize) -> Dice {
    Dice((1 + number + 100_000 * self::number("LONGSPAN_QUERY_SEED", 0)) as u64)
}

/// A convex form somewhere, known by what is inside it and by its farthest points.
struct Solid {
    geometry: Geometry,
    pose: Pose,
    /// Planes of a hull, by brute force over its points.
    planes: Vec<(DVec3, f64)>,
}

impl Solid {
    fn new(geometry: Geometry, pose: Pose) -> Self {
        let planes = match &geometry {
            Geometry::ConvexHull { .. } => {
                let (points, triangles) = geometry.triangles().expect("a hull has triangles");
                let at = |index: u32| points[index as usize].as_dvec3();
                let plane = |[a, b, c]: [u32; 3]| {
                    let normal = (at(b) - at(a)).cross(at(c) - at(a)).normalize();
                    (normal, normal.dot(at(a)))
                };
                triangles.into_iter().map(plane).collect()
            }
            _ => Vec::new(),
        };
        Self { geometry, pose, planes }
    }

    fn rotation(&self) -> DQuat {
        self.pose.rotation.as_dquat().normalize()
    }

    /// How far a point is outside (m), negative inside; convex, and in the direction of a face or a round side exact.
    fn outside(&self, point: DVec3) -> f64 {
        let p = self.rotation().conjugate() * (point - self.pose.position);
        let across = p.x.hypot(p.z);
        match self.geometry {
            Geometry::Ball { radius } => p.length() - f64::from(radius),
            Geometry::Box { half_extents } => (p.abs() - half_extents.as_dvec3()).max_element(),
            Geometry::Capsule { half_height, radius } => {
                let h = f64::from(half_height);
                (p - DVec3::Y * p.y.clamp(-h, h)).length() - f64::from(radius)
            }
            Geometry::Cylinder { half_height, radius } => (p.y.abs() - f64::from(half_height)).max(across - f64::from(radius)),
            Geometry::Cone { half_height, radius } => {
                let (h, k) = (f64::from(half_height), f64::from(radius) / f64::from(2.0 * half_height));
                (-h - p.y).max((across - k * (h - p.y)) / (1.0 + k * k).sqrt())
            }
            Geometry::ConvexHull { .. } => self.planes.iter().map(|(n, d)| n.dot(p) - d).fold(f64::MIN, f64::max),
            Geometry::HalfSpace { normal } => normal.as_dvec3().normalize().dot(p),
            _ => unreachable!("not convex"),
        }
    }

    /// The greatest coordinate along a unit direction (m).
    fn top(&self, direction: DVec3) -> f64 {
        let d = self.rotation().conjugate() * direction;
        let across = d.x.hypot(d.z);
        let local = match &self.geometry {
            Geometry::Ball { radius } => f64::from(*radius),
            Geometry::Box { half_extents } => half_extents.as_dvec3().dot(d.abs()),
            Geometry::Capsule { half_height, radius } => f64::from(*half_height) * d.y.abs() + f64::from(*radius),
            Geometry::Cylinder { half_height, radius } => f64::from(*half_height) * d.y.abs() + f64::from(*radius) * across,
            Geometry::Cone { half_height, radius } => {
                let h = f64::from(*half_height);
                (h * d.y).max(f64::from(*radius) * across - h * d.y)
            }
            Geometry::ConvexHull { points } => points.iter().map(|p| p.as_dvec3().dot(d)).fold(f64::MIN, f64::max),
            // It has no end in any direction but its normal; the plane passes through its origin.
            Geometry::HalfSpace { .. } => 0.0,
            _ => unreachable!("not convex"),
        };
        direction.dot(self.pose.position) + local
    }

    /// How far this and another are apart along a direction from this to the other (m).
    fn apart(&self, other: &Self, direction: DVec3) -> f64 {
        -other.top(-direction) - self.top(direction)
    }
}

/// Random numbers (Steele, Lea and Flood 2014).
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.between(-size, size), self.between(-size, size), self.between(-size, size))
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector(1.0);
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    fn pose(&mut self, position: DVec3) -> Pose {
        let turn = self.direction() * self.between(0.0, 3.1);
        let rotation = if self.unit() < 0.25 { Quat::IDENTITY } else { DQuat::from_scaled_axis(turn).as_quat() };
        Pose::at(position).rotated(rotation)
    }

    fn form(&mut self, kind: usize, scale: f64) -> Geometry {
        let mut size = || (self.between(0.2, 1.0) * scale) as f32;
        match kind {
            0 => Geometry::Ball { radius: size() },
            1 => Geometry::Box { half_extents: Vec3::new(size(), size(), size()) },
            2 => Geometry::Capsule { half_height: size(), radius: size() },
            3 => Geometry::Cylinder { half_height: size(), radius: size() },
            4 => Geometry::Cone { half_height: size(), radius: size() },
            5 => {
                let half = Vec3::new(size(), size(), size());
                let count = 8 + (self.between(0.0, 40.0) as usize);
                Geometry::ConvexHull { points: (0..count).map(|_| self.direction().as_vec3() * half).collect() }
            }
            _ => Geometry::HalfSpace { normal: self.direction().as_vec3().normalize() },
        }
    }
}

/// A world with one static shape, and the same shape as the oracle knows it.
struct Scene {
    world: World,
    target: Solid,
}

impl Scene {
    fn new(geometry: Geometry, pose: Pose) -> Self {
        let mut world = World::new(&WorldDef::default()).unwrap();
        add(&mut world, geometry.clone(), pose);
        Self { world, target: Solid::new(geometry, pose) }
    }
}

fn add(world: &mut World, geometry: Geometry, pose: Pose) -> ShapeId {
    let def = BodyDef::fixed(pose).with_shape(ShapeDef::new(Shape::new(geometry).expect("a form")));
    let body = world.create_body(&def).unwrap();
    world.body_shapes(body).unwrap()[0]
}

fn all() -> QueryFilter<'static> {
    QueryFilter::default()
}

const KINDS: [&str; 7] = ["ball", "box", "capsule", "cylinder", "cone", "hull", "half-space"];

/// Runs cases of each kind of target, with each kind of probe if there is one, at each scale; `case` says what is wrong.
fn each(probes: usize, mut case: impl FnMut(&mut Dice, (usize, usize), f64) -> Result<(), String>) {
    let (mut wrong, mut first) = (0, Vec::new());
    let mut count = 0;
    for (number, scale) in scales() {
        for target in 0..KINDS.len() {
            for probe in 0..probes {
                let mut dice = dice(number * 100 + target * 10 + probe);
                for round in 0..cases() {
                    count += 1;
                    if let Err(problem) = case(&mut dice, (target, probe), scale) {
                        wrong += 1;
                        first.push(format!("{} and {}, {scale} m, case {round}: {problem}", KINDS[target], KINDS[probe]));
                    }
                }
            }
        }
    }
    println!("{count} cases, {wrong} wrong");
    first.truncate(100);
    assert!(wrong == 0, "{wrong} of {count} wrong:\n{}", first.join("\n"));
}

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

/// A bumpy ground as a height field and as a mesh of the same triangles, and those triangles.
fn grounds(dice: &mut Dice, scale: f64) -> ([Geometry; 2], Vec<[DVec3; 3]>) {
    let (rows, columns) = (4, 5);
    let heights: Vec<f32> = (0..rows * columns).map(|_| (dice.between(-0.3, 0.3) * scale) as f32).collect();
    let field = Geometry::HeightField { rows, columns, heights, size_x: 4.0 * scale as f32, size_z: 3.0 * scale as f32 };
    let (vertices, triangles) = field.triangles().expect("a height field has triangles");
    let corners = triangles.iter().map(|triangle| triangle.map(|index| vertices[index as usize].as_dvec3())).collect();
    ([field, Geometry::TriangleMesh { vertices, triangles }], corners)
}

/// Where a ray meets a triangle (Möller and Trumbore 1997), and how far inside its edges, as a share.
fn meets([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let scale = 1.0 / ab.dot(p);
    let from = origin - a;
    let (u, q) = (from.dot(p) * scale, from.cross(ab));
    let (v, t) = (direction.dot(q) * scale, ac.dot(q) * scale);
    (t >= 0.0).then_some((t, u.min(v).min(1.0 - u - v)))
}

#[test]
fn grounds_answer_as_their_triangles_do_one_by_one() {
    let mut wrong = Vec::new();
    for (number, scale) in scales() {
        let mut dice = dice(1000 + number);
        for round in 0..4 * cases() {
            let (forms, triangles) = grounds(&mut dice, scale);
            let pose = dice.pose(DVec3::ZERO);
            let turn = pose.rotation.as_dquat().normalize();
            let triangles: Vec<[DVec3; 3]> = triangles.iter().map(|corners| corners.map(|corner| turn * corner)).collect();
            let mut single = World::new(&WorldDef::default()).unwrap();
            for corners in &triangles {
                let vertices = corners.map(|corner| corner.as_vec3()).to_vec();
                add(&mut single, Geometry::TriangleMesh { vertices, triangles: vec![[0, 1, 2]] }, Pose::IDENTITY);
            }
            let origin = turn * (DVec3::new(dice.between(-2.0, 2.0), dice.between(-1.0, 1.0), dice.between(-1.5, 1.5)) * scale);
            let direction = dice.direction();
            let probe = dice.form(round % 6, 0.3 * scale);
            let (shape, place) = (Shape::new(probe).unwrap(), dice.pose(origin));
            let path = direction * scale * dice.between(0.1, 6.0);
            for (form, name) in forms.into_iter().zip(["field", "mesh"]) {
                let scene = {
                    let mut world = World::new(&WorldDef::default()).unwrap();
                    add(&mut world, form, pose);
                    world
                };
                let mut note =
                    |what: &str, found: String| wrong.push(format!("{name} of {scale} m, case {round}, {what}: {found}"));
                // The two differ by how single precision rounds turned corners.
                let allowed = 2.0e-6 * scale;
                let hit = scene.cast(&Cast::ray(origin, path), &all()).unwrap();
                let met = triangles.iter().zip(0_u32..).filter_map(|(&corners, i)| Some((meets(corners, origin, direction)?, i)));
                let met: Vec<_> = met.filter(|((t, _), _)| *t <= path.length()).collect();
                let sure =
                    met.iter().filter(|((_, inside), _)| *inside > 1.0e-6).map(|((t, _), _)| *t).fold(f64::INFINITY, f64::min);
                let any =
                    met.iter().filter(|((_, inside), _)| *inside > -1.0e-6).map(|((t, _), _)| *t).fold(f64::INFINITY, f64::min);
                let at = hit.map_or(f64::INFINITY, |hit| hit.distance);
                if at > sure + allowed || at < any - allowed {
                    note("ray", format!("{at} m, by triangles {sure} m"));
                }
                if let Some(hit) = hit
                    && !met
                        .iter()
                        .any(|((t, inside), i)| Some(*i) == hit.triangle && *inside > -1.0e-6 && (t - at).abs() < allowed)
                {
                    note("triangle", format!("{hit:?}"));
                }
                let distance =
                    |world: &World| world.nearest_shape(&shape, place, 1.0e7, &all()).unwrap().map(|near| near.distance.distance);
                let (here, there) = (distance(&scene), distance(&single));
                if (here.unwrap_or(1.0e30) - there.unwrap_or(1.0e30)).abs() > allowed {
                    note("distance", format!("{here:?} m, by triangles {there:?} m"));
                }
                let mut overlaps = Vec::new();
                scene.overlap_shape(&shape, place, &all(), &mut overlaps).unwrap();
                if there.is_some_and(|there| there.abs() > allowed && (there < 0.0) == overlaps.is_empty()) {
                    note("overlap", format!("{} with {there:?} m", overlaps.len()));
                }
                let cast = |world: &World| world.cast(&Cast::new(&shape, place, path), &all()).unwrap();
                let (here, there) = (cast(&scene), cast(&single));
                let [a, b] = [here, there].map(|hit| hit.map_or(f64::INFINITY, |hit| hit.distance));
                // One that grazes an edge may be decided by rounding: then the other is nearly touched there.
                if (a - b).abs() > 1.0e-4 * scale
                    && a.min(b).is_finite()
                    && !grazes(&scene, &shape, place, path, a.min(b), allowed)
                {
                    note("cast", format!("{a} m, by triangles {b} m"));
                }
            }
        }
    }
    wrong.truncate(60);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whether a solid barely touches anything at this distance along a path (m), and so may as well pass.
fn grazes(world: &World, shape: &Shape, place: Pose, path: DVec3, distance: f64, allowed: f64) -> bool {
    let pose = Pose { position: place.position + path.normalize() * (distance + 1.0e-3 * path.length()), ..place };
    world.nearest_shape(shape, pose, 1.0e7, &all()).unwrap().is_none_or(|near| near.distance.distance > -10.0 * allowed)
}

#[test]
fn rays_along_grid_lines_and_through_posts_hit() {
    for n in [8_usize, 41] {
        let half = (n - 1) as f64 / 2.0;
        let heights = vec![0.0; n * n];
        let field = Geometry::HeightField { rows: n, columns: n, heights, size_x: (n - 1) as f32, size_z: (n - 1) as f32 };
        let (vertices, triangles) = field.triangles().unwrap();
        for form in [field, Geometry::TriangleMesh { vertices, triangles }] {
            let mut world = World::new(&WorldDef::default()).unwrap();
            add(&mut world, form, Pose::IDENTITY);
            let (mut missed, mut count) = (0, 0);
            for i in 0..n {
                for j in 0..n {
                    for (dx, dz) in [(0.0, 0.0), (0.375, 0.0), (0.0, 0.375), (0.5, 0.5)] {
                        let at = DVec3::new(i as f64 + dx - half, 0.0, j as f64 + dz - half);
                        if at.x.abs() > half || at.z.abs() > half {
                            continue;
                        }
                        for lean in
                            [DVec3::ZERO, DVec3::new(0.0, 0.0, 2.5), DVec3::new(-2.5, 0.0, 0.0), DVec3::new(2.0, 0.0, 2.0)]
                        {
                            let up = DVec3::Y * 5.0 + lean;
                            let hit = world.cast(&Cast::ray(at + up, up * -2.0), &all()).unwrap();
                            count += 1;
                            missed += u32::from(hit.is_none_or(|hit| (hit.point - at).length() > 1.0e-9));
                        }
                    }
                }
            }
            assert_eq!(missed, 0, "{missed} of {count} rays missed a field of {n} × {n}");
        }
    }
}
