//! What a host asks about a scene is what looking at every shape of it gives.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, CollisionFilter, Geometry, LocalPose, NearestPoint, Pose, QueryFilter, Ray, RayHit, Shape,
    ShapeDef, ShapeId, World, WorldDef,
};
use longspan_scenes::Random;
use parry3d::math::Pose3;
use parry3d::query::ShapeCastOptions;
use parry3d::shape::SharedShape;

/// Shapes of every kind, thrown together and stepped while they collide, so that some have left their kept boxes.
struct Throng {
    world: World,
    shapes: Vec<(ShapeId, SharedShape)>,
}

fn geometry(random: &mut Random, number: usize) -> Geometry {
    let mut size = || random.between(0.1, 0.5);
    match number % 7 {
        0 => Geometry::Ball { radius: size() },
        1 => Geometry::Box { half_extents: Vec3::new(size(), size(), size()) },
        2 => Geometry::Capsule { half_height: size(), radius: size() },
        3 => Geometry::Cylinder { half_height: size(), radius: size() },
        4 => Geometry::Cone { half_height: size(), radius: size() },
        5 => Geometry::ConvexHull {
            points: vec![Vec3::ZERO, Vec3::X * size(), Vec3::Y * size(), Vec3::Z * size(), Vec3::new(size(), size(), size())],
        },
        _ => Geometry::Compound {
            parts: vec![
                (LocalPose::IDENTITY, Geometry::Ball { radius: size() }),
                (LocalPose::at(Vec3::Y * 0.5), Geometry::Box { half_extents: Vec3::splat(size()) }),
            ],
        },
    }
}

/// The same form as parry3d makes it, without a detour through our code.
fn parry(geometry: &Geometry) -> SharedShape {
    match geometry {
        Geometry::Ball { radius } => SharedShape::ball(*radius),
        Geometry::Box { half_extents } => SharedShape::cuboid(half_extents.x, half_extents.y, half_extents.z),
        Geometry::Capsule { half_height, radius } => SharedShape::capsule_y(*half_height, *radius),
        Geometry::Cylinder { half_height, radius } => SharedShape::cylinder(*half_height, *radius),
        Geometry::Cone { half_height, radius } => SharedShape::cone(*half_height, *radius),
        Geometry::ConvexHull { points } => SharedShape::convex_hull(points).expect("the points span a volume"),
        Geometry::TriangleMesh { vertices, triangles } => {
            SharedShape::trimesh(vertices.clone(), triangles.clone()).expect("the triangles are a mesh")
        }
        Geometry::HalfSpace { normal } => SharedShape::halfspace(*normal),
        Geometry::Compound { parts } => SharedShape::compound(
            parts.iter().map(|(pose, part)| (Pose3::from_parts(pose.position, pose.rotation), parry(part))).collect(),
        ),
        other => panic!("the throng has no {other:?}"),
    }
}

impl Throng {
    fn new(origin: DVec3, threads: u32) -> Self {
        let mut random = Random::new(7);
        let mut world = World::new(&WorldDef { threads, ..WorldDef::default() }).unwrap();
        let mut shapes = Vec::new();
        let mut add = |world: &mut World, kind: BodyKind, pose: Pose, velocity: Vec3, geometry: Geometry| {
            let mut shape = ShapeDef::new(Shape::new(geometry.clone()).unwrap());
            shape.local_pose = LocalPose::at(Vec3::new(0.1, 0.0, -0.1));
            let def = BodyDef { kind, linear_velocity: velocity, ..BodyDef::dynamic(pose).with_shape(shape) };
            let body = world.create_body(&def).unwrap();
            shapes.push((world.body_shapes(body).unwrap()[0], parry(&geometry)));
        };
        let plane = Geometry::HalfSpace { normal: Vec3::Y };
        add(&mut world, BodyKind::Static, Pose::at(origin + DVec3::Y * -8.0), Vec3::ZERO, plane);
        let roof = Geometry::TriangleMesh {
            vertices: vec![
                Vec3::new(-3.0, 0.0, -3.0),
                Vec3::new(3.0, 0.5, -3.0),
                Vec3::new(0.0, 0.0, 4.0),
                Vec3::new(5.0, 1.0, 4.0),
            ],
            triangles: vec![[0, 2, 1], [1, 2, 3]],
        };
        add(&mut world, BodyKind::Static, Pose::at(origin + DVec3::Y * 4.0), Vec3::ZERO, roof);
        for number in 0..400 {
            let kind = [BodyKind::Dynamic, BodyKind::Dynamic, BodyKind::Kinematic, BodyKind::Static][number % 4];
            let pose = Pose::at(origin + random.vector(3.0).as_dvec3()).rotated(random.rotation());
            let speed = if number % 11 == 0 { 60.0 } else { 3.0 };
            let velocity = if kind == BodyKind::Dynamic { random.vector(speed) } else { Vec3::ZERO };
            add(&mut world, kind, pose, velocity, geometry(&mut random, number));
        }
        for _ in 0..6 {
            world.step(1.0 / 60.0).unwrap();
        }
        Self { world, shapes }
    }

    /// Every shape, as parry3d has it, relative to `origin`.
    fn each(&self, origin: DVec3) -> impl Iterator<Item = (ShapeId, &SharedShape, Pose3)> {
        self.shapes.iter().map(move |(id, shape)| {
            let body = self.world.shape_body(*id).unwrap();
            let (pose, local) = (self.world.pose(body).unwrap(), self.world.shape_def(*id).unwrap().local_pose);
            let position = (pose.position - origin).as_vec3() + pose.rotation * local.position;
            (*id, shape, Pose3::from_parts(position, pose.rotation * local.rotation))
        })
    }
}

fn random_ray(random: &mut Random, origin: DVec3) -> Ray {
    let (from, to) = (random.vector(5.0), random.vector(5.0));
    Ray::between(origin + from.as_dvec3(), origin + to.as_dvec3())
}

/// Greatest difference of distances that counts as equal (m): on grazing hits of round forms GJK stops within 4 mm.
const TOLERANCE: f64 = 1.0e-2;

#[test]
fn a_ray_meets_first_and_meets_all_that_brute_force_finds() {
    for origin in [DVec3::ZERO, DVec3::new(40_000.0, -300.0, 9_000.0)] {
        let throng = Throng::new(origin, 1);
        let (mut random, mut hits, mut all) = (Random::new(1), 0, Vec::new());
        for _ in 0..3000 {
            let ray = random_ray(&mut random, origin);
            let local = parry3d::query::Ray::new((ray.origin - origin).as_vec3(), ray.direction);
            let mut expected: Vec<(f32, ShapeId)> = throng
                .each(origin)
                .filter_map(|(id, shape, pose)| Some((shape.cast_ray(&pose, &local, ray.length, true)?, id)))
                .collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            let first = throng.world.cast_ray(&ray, &QueryFilter::default()).unwrap();
            throng.world.cast_ray_all(&ray, &QueryFilter::default(), &mut all).unwrap();
            let grazing = expected.len().abs_diff(all.len());
            assert!(grazing <= 1, "{} of {} shapes are met", all.len(), expected.len());
            assert_eq!(first, all.first().copied(), "the first of all is the first");
            if grazing == 0 {
                for (found, (distance, _)) in all.iter().zip(&expected) {
                    // Where parry3d's search ends early on a round form, ours is the one that is on the surface.
                    let near = (found.distance - f64::from(*distance)).abs() < TOLERANCE;
                    let at = (found.point - origin).as_vec3();
                    let off = |shape: &SharedShape, pose: &Pose3| shape.project_point(pose, at, false).point.distance(at);
                    let is_on =
                        |(id, shape, pose): (ShapeId, &SharedShape, Pose3)| id == found.shape && off(shape, &pose) < 1.0e-3;
                    let on_surface = near || throng.each(origin).any(is_on);
                    assert!(on_surface, "{} m, by brute force {distance} m", found.distance);
                    let along = ray.origin + ray.direction.as_dvec3() * found.distance;
                    assert!((found.point - along).length() < 1.0e-3, "the point lies on the ray");
                    assert!(found.normal.is_normalized() && found.normal.dot(ray.direction) <= 1.0e-6, "{:?}", found.normal);
                }
                hits += all.len();
            }
        }
        println!("3000 rays met {hits} shapes at {origin}");
        assert!(hits > 4000, "only {hits} hits");
    }
}

#[test]
fn a_batch_of_rays_gives_what_single_rays_give_on_any_number_of_threads() {
    let (single, threaded) = (Throng::new(DVec3::ZERO, 1), Throng::new(DVec3::ZERO, 4));
    let mut random = Random::new(2);
    let rays: Vec<Ray> = (0..500).map(|_| random_ray(&mut random, DVec3::ZERO)).collect();
    let expected: Vec<Option<f64>> =
        rays.iter().map(|ray| single.world.cast_ray(ray, &QueryFilter::default()).unwrap().map(|hit| hit.distance)).collect();
    for throng in [&single, &threaded] {
        let mut out: Vec<Option<RayHit>> = vec![None; rays.len()];
        throng.world.cast_rays(&rays, &QueryFilter::default(), &mut out).unwrap();
        let found: Vec<Option<f64>> = out.iter().map(|hit| hit.map(|hit| hit.distance)).collect();
        assert_eq!(found, expected);
    }
    assert!(expected.iter().flatten().count() > 200);
}

#[test]
fn threads_may_ask_at_the_same_time() {
    let throng = Throng::new(DVec3::ZERO, 1);
    let ask = || {
        let mut random = Random::new(3);
        let hits = (0..300).filter_map(|_| {
            let ray = random_ray(&mut random, DVec3::ZERO);
            throng.world.cast_ray(&ray, &QueryFilter::default()).unwrap().map(|hit| hit.distance.to_bits())
        });
        hits.collect::<Vec<_>>()
    };
    let expected = ask();
    let found: Vec<Vec<u64>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(ask)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(expected.len() > 100 && found.iter().all(|hits| *hits == expected));
}

#[test]
fn a_swept_solid_meets_first_what_brute_force_finds() {
    let throng = Throng::new(DVec3::ZERO, 1);
    let (mut random, mut hits, mut from_inside) = (Random::new(4), 0, 0);
    for number in 0..1500 {
        let form = geometry(&mut random, number % 6);
        let (shape, twin) = (Shape::new(form.clone()).unwrap(), parry(&form));
        let pose = Pose::at(random.vector(9.0).as_dvec3()).rotated(random.rotation());
        let path = random.vector(9.0);
        let moving = Pose3::from_parts(pose.position.as_vec3(), pose.rotation);
        let options = ShapeCastOptions { max_time_of_impact: path.length(), stop_at_penetration: true, ..Default::default() };
        let direction = path.normalize();
        let cast = |(id, other, place): (ShapeId, &SharedShape, Pose3)| {
            let hit = parry3d::query::cast_shapes(&place, Vec3::ZERO, &**other, &moving, direction, &*twin, options).unwrap()?;
            Some((hit.time_of_impact, id))
        };
        let expected = throng.each(DVec3::ZERO).filter_map(cast).min_by(|a, b| a.0.total_cmp(&b.0));
        let found = throng.world.cast_shape(&shape, pose, path, &QueryFilter::default()).unwrap();
        let distances = (found.map(|hit| hit.distance), expected.map(|hit| f64::from(hit.0)));
        match distances {
            (Some(found), Some(expected)) => {
                // Both search by conservative advancement, from different starts.
                assert!((found - expected).abs() < 1.0e-2, "{found} m, by brute force {expected} m ({form:?})");
                hits += 1;
                from_inside += u32::from(found == 0.0);
            }
            (None, None) => {}
            (None, Some(late)) => {
                assert!(late > f64::from(path.length()) - 1.0e-2, "missed at {late} of {} m ({form:?})", path.length())
            }
            (Some(late), None) => assert!(late > f64::from(path.length()) - 1.0e-2, "invented at {late} of {} m", path.length()),
        }
        if let Some(hit) = found.filter(|hit| hit.distance > 0.0) {
            assert!(hit.normal.is_normalized() && hit.normal.dot(direction) < 1.0e-2, "{:?} along {direction:?}", hit.normal);
        }
    }
    println!("1500 sweeps met {hits}, {from_inside} from the start");
    assert!(hits > 500 && from_inside > 50, "{hits} hits, {from_inside} from inside");
}

#[test]
fn a_solid_overlaps_all_that_brute_force_finds_and_no_more() {
    let throng = Throng::new(DVec3::ZERO, 1);
    let (mut random, mut overlaps, mut doubtful, mut out) = (Random::new(5), 0, 0, Vec::new());
    for number in 0..1500 {
        let form = geometry(&mut random, number % 6);
        let (shape, twin) = (Shape::new(form.clone()).unwrap(), parry(&form));
        let pose = Pose::at(random.vector(4.0).as_dvec3()).rotated(random.rotation());
        let here = Pose3::from_parts(pose.position.as_vec3(), pose.rotation);
        throng.world.overlap_shape(&shape, pose, &QueryFilter::default(), &mut out).unwrap();
        for (id, other, place) in throng.each(DVec3::ZERO) {
            let expected = parry3d::query::intersection_test(&place, &**other, &here, &*twin).unwrap().intersecting;
            // In relative coordinates the last bit differs, and with it a touch.
            doubtful += u32::from(out.contains(&id) != expected);
        }
        overlaps += out.len();
    }
    println!("{overlaps} overlaps, {doubtful} decided by rounding");
    assert!(overlaps > 900 && doubtful < 5, "{overlaps} overlaps, {doubtful} differ");
}

#[test]
fn the_nearest_point_is_the_one_that_brute_force_finds() {
    let throng = Throng::new(DVec3::ZERO, 1);
    let (mut random, mut found) = (Random::new(6), 0);
    for _ in 0..1000 {
        let (point, limit) = (random.vector(7.0).as_dvec3(), random.between(0.0, 3.0));
        let expected = throng.each(DVec3::ZERO).map(|(_, shape, pose)| shape.distance_to_point(&pose, point.as_vec3(), true));
        let expected = f64::from(expected.fold(f32::INFINITY, f32::min));
        let nearest: Option<NearestPoint> = throng.world.nearest_point(point, limit, &QueryFilter::default()).unwrap();
        match nearest {
            Some(nearest) => {
                assert!((nearest.distance - expected).abs() < 1.0e-4, "{} m, by brute force {expected} m", nearest.distance);
                assert!(((nearest.point - point).length() - nearest.distance).abs() < 1.0e-4);
                found += 1;
            }
            None => assert!(expected > f64::from(limit) - 1.0e-4, "missed at {expected} m within {limit} m"),
        }
    }
    assert!(found > 300, "only {found} found");
}

#[test]
fn filters_leave_out_what_they_name() {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let mut stack = |kind: BodyKind, x: f64, member_of: u32| -> BodyId {
        let mut shape = ShapeDef::new(Shape::ball(0.4).unwrap());
        shape.filter = CollisionFilter { member_of, collides_with: u32::MAX };
        world.create_body(&BodyDef { kind, ..BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)) }.with_shape(shape)).unwrap()
    };
    let [fixed, kinematic, dynamic, ghost] =
        [(BodyKind::Static, 1.0, 1), (BodyKind::Kinematic, 2.0, 1), (BodyKind::Dynamic, 3.0, 1), (BodyKind::Dynamic, 4.0, 2)]
            .map(|(kind, x, group)| stack(kind, x, group));
    let ray = Ray { origin: DVec3::ZERO, direction: Vec3::X, length: 10.0 };
    let met = |filter: QueryFilter| {
        let mut out = Vec::new();
        world.cast_ray_all(&ray, &filter, &mut out).unwrap();
        out.iter().map(|hit| hit.body).collect::<Vec<_>>()
    };
    let all = QueryFilter::default();
    assert_eq!(met(all), [fixed, kinematic, dynamic, ghost]);
    assert_eq!(met(QueryFilter { fixed: false, ..all }), [kinematic, dynamic, ghost]);
    assert_eq!(met(QueryFilter { kinematic: false, dynamic: false, ..all }), [fixed]);
    assert_eq!(met(QueryFilter { ignored: &[kinematic, ghost], ..all }), [fixed, dynamic]);
    assert_eq!(met(QueryFilter { groups: CollisionFilter { member_of: 1, collides_with: 2 }, ..all }), [ghost]);
    let of_dynamic = world.body_shapes(dynamic).unwrap()[0];
    let only = |shape: ShapeId| shape == of_dynamic;
    assert_eq!(met(QueryFilter { accept: Some(&only), ..all }), [dynamic]);
}

#[test]
fn an_edit_is_seen_at_once() {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let ball = || BodyDef::dynamic(Pose::IDENTITY).with_shape(ShapeDef::new(Shape::ball(0.5).unwrap()));
    let bodies: Vec<BodyId> = (0..20).map(|_| world.create_body(&ball()).unwrap()).collect();
    for (number, &body) in bodies.iter().enumerate() {
        world.set_pose(body, Pose::at_xyz(100.0 * number as f64, 50.0, 0.0).rotated(Quat::IDENTITY)).unwrap();
    }
    let mut out = Vec::new();
    for (number, &body) in bodies.iter().enumerate() {
        let ray = Ray { origin: DVec3::new(100.0 * number as f64, 0.0, 0.0), direction: Vec3::Y, length: 60.0 };
        let hit = world.cast_ray(&ray, &QueryFilter::default()).unwrap().expect("the body is above");
        assert!(hit.body == body && (hit.distance - 49.5).abs() < 1.0e-3, "{hit:?}");
    }
    world.destroy_body(bodies[3]).unwrap();
    let (min, max) = (DVec3::new(-1.0, 49.0, -1.0), DVec3::new(1001.0, 51.0, 1.0));
    world.overlap_box(min, max, &QueryFilter::default(), &mut out).unwrap();
    assert_eq!(out.len(), 10, "of the first eleven, one is gone");
}

#[test]
fn a_ball_knocked_away_from_rest_is_found_where_it_is_after_that_very_step() {
    let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
    let ball = |x: f64, density: f32, speed: f32| {
        let mut shape = ShapeDef { density, ..ShapeDef::new(Shape::ball(0.1).unwrap()) };
        shape.material.restitution = 1.0;
        BodyDef { linear_velocity: Vec3::X * speed, ..BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)).with_shape(shape) }
    };
    let light = world.create_body(&ball(0.0, 100.0, 0.0)).unwrap();
    world.create_body(&ball(-5.0, 10_000.0, 100.0)).unwrap();
    let mut leap: f64 = 0.0;
    for _ in 0..10 {
        let before = world.pose(light).unwrap().position;
        world.step(1.0 / 60.0).unwrap();
        let now = world.pose(light).unwrap().position;
        leap = leap.max(if before == DVec3::ZERO { (now - before).length() } else { 0.0 });
        let ray = Ray { origin: now + DVec3::Y * 5.0, direction: Vec3::NEG_Y, length: 10.0 };
        let hit = world.cast_ray(&ray, &QueryFilter::default()).unwrap();
        assert!(hit.is_some_and(|hit| hit.body == light), "missed at {now}: {hit:?}");
    }
    println!("from rest it leapt {leap:.2} m in one step");
    assert!(leap > 0.15, "{leap} m");
}

#[test]
fn a_question_that_makes_no_sense_is_refused_by_name() {
    let world = World::new(&WorldDef::default()).unwrap();
    let ray = Ray { origin: DVec3::ZERO, direction: Vec3::X, length: 1.0 };
    let refused = |ray: Ray| world.cast_ray(&ray, &QueryFilter::default()).unwrap_err().argument;
    assert_eq!(refused(Ray { origin: DVec3::NAN, ..ray }), "origin");
    assert_eq!(refused(Ray { direction: Vec3::X * 2.0, ..ray }), "direction");
    assert_eq!(refused(Ray { length: -1.0, ..ray }), "length");
    assert_eq!(refused(Ray { length: f32::INFINITY, ..ray }), "length");
    let plane = Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap();
    let sweep = world.cast_shape(&plane, Pose::IDENTITY, Vec3::X, &QueryFilter::default());
    assert_eq!(sweep.unwrap_err().argument, "shape");
    let ball = Shape::ball(1.0).unwrap();
    let sweep = world.cast_shape(&ball, Pose::IDENTITY, Vec3::splat(f32::NAN), &QueryFilter::default());
    assert_eq!(sweep.unwrap_err().argument, "path");
    assert_eq!(world.nearest_point(DVec3::ZERO, -1.0, &QueryFilter::default()).unwrap_err().argument, "max_distance");
}
