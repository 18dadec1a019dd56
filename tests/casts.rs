//! Casts that turn, that leave out what they begin in, and the parts and triangles that answers name, against closed forms.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, Cast, Geometry, LocalPose, Pose, QueryFilter, RayHit, Shape, ShapeDef, ShapeId, World, WorldDef};
use longspan_scenes::Random;

const SCALES: [f32; 4] = [1.0e-3, 0.1, 1.0, 1.0e3];

fn world() -> World {
    World::new(&WorldDef::default()).unwrap()
}

fn add(world: &mut World, geometry: Geometry, pose: Pose) -> ShapeId {
    let def = BodyDef::fixed(pose).with_shape(ShapeDef::new(Shape::new(geometry).expect("a form")));
    let body = world.create_body(&def).unwrap();
    world.body_shapes(body).unwrap()[0]
}

fn cast(world: &World, cast: &Cast) -> Option<RayHit> {
    world.cast(cast, &QueryFilter::default()).unwrap()
}

fn cuboid(x: f32, y: f32, z: f32) -> Geometry {
    Geometry::Box { half_extents: Vec3::new(x, y, z) }
}

/// The corners of a box as a hull.
fn hull(half: Vec3) -> Geometry {
    let sign = |bits: usize, bit: usize| if bits >> bit & 1 == 0 { 1.0 } else { -1.0 };
    Geometry::ConvexHull { points: (0..8).map(|i| half * Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect() }
}

/// A flat rectangle of two triangles, facing up.
fn sheet(x: f32, z: f32) -> Geometry {
    let vertices = vec![Vec3::new(-x, 0.0, -z), Vec3::new(-x, 0.0, z), Vec3::new(x, 0.0, z), Vec3::new(x, 0.0, -z)];
    Geometry::TriangleMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

#[test]
fn a_ball_on_an_arm_swings_down_to_the_angle_at_which_it_touches_the_floor() {
    for scale in SCALES {
        let size = f64::from(scale);
        let floors =
            [Geometry::HalfSpace { normal: Vec3::Y }, cuboid(9.0 * scale, scale, 9.0 * scale), sheet(9.0 * scale, 9.0 * scale)];
        for floor in floors {
            let top = if matches!(floor, Geometry::Box { .. }) { size } else { 0.0 };
            let mut world = world();
            let below = 1.5 * size;
            add(&mut world, floor, Pose::at(DVec3::new(1000.0, -below - top, 0.0)));
            let ball = Geometry::Ball { radius: 0.25 * scale };
            let arm = Shape::new(Geometry::Compound { parts: vec![(LocalPose::at(Vec3::X * 2.0 * scale), ball)] }).unwrap();
            for (turns, side) in [(0.25, 0.0), (0.25, 1.0), (3.0, 0.5), (16.0, -1.0)] {
                let turn = Vec3::NEG_Z * turns * std::f32::consts::TAU;
                let path = DVec3::new(0.5, 0.0, side) * size;
                let found = cast(&world, &Cast { turn, ..Cast::new(&arm, Pose::at(DVec3::X * 1000.0), path) });
                let found = found.unwrap_or_else(|| panic!("{turns} turns at {scale} m pass through the floor"));
                // The centre of the ball is 2 sin θ below the hub, and touches at 1.5 less its radius.
                let angle = (1.25_f64 / 2.0).asin();
                let share = angle / f64::from(turn.length());
                let point = DVec3::new(1000.0 + 2.0 * size * angle.cos(), -below, 0.0) + path * share;
                assert!((found.fraction - share).abs() < 1.0e-6 * share, "{} of the turn, not {share}", found.fraction);
                assert!((found.point - point).length() < 3.0e-6 * size + 1.0e-9, "{} instead of {point}", found.point);
                assert!((found.normal - Vec3::Y).length() < 1.0e-6, "{}", found.normal);
            }
        }
    }
}

#[test]
fn a_wheel_that_turns_close_above_the_ground_neither_touches_it_nor_passes_through_it() {
    for scale in SCALES {
        let size = f64::from(scale);
        let mut world = world();
        add(&mut world, cuboid(20.0 * scale, scale, 20.0 * scale), Pose::at(DVec3::Y * -size));
        let wheel = Shape::new(Geometry::Cylinder { half_height: 0.3 * scale, radius: scale }).unwrap();
        let lying = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        for gap in [1.0e-2, 1.0e-3, 1.0e-4] {
            let pose = Pose { position: DVec3::Y * size * (1.0 + gap), rotation: lying };
            // About its own axis: the way that its rim goes says nothing about its lowest line.
            let turn = Vec3::Z * 20.0;
            let along = Cast { turn, ..Cast::new(&wheel, pose, DVec3::X * 5.0 * size) };
            assert!(cast(&world, &along).is_none(), "{scale} m, {gap}: {:?}", cast(&world, &along));
            // And down by twice the gap: half-way it touches.
            let path = DVec3::new(5.0, -2.0 * gap, 0.0) * size;
            let down = cast(&world, &Cast { path, ..along }).expect("it comes down");
            assert!((down.fraction - 0.5).abs() < 1.0e-6 / gap * 1.0e-2, "{scale} m, {gap}: {down:?}");
        }
    }
}

#[test]
fn what_a_cast_begins_in_is_left_out_and_what_is_behind_it_met() {
    for scale in SCALES {
        let size = f64::from(scale);
        let around = [
            Geometry::Ball { radius: scale },
            cuboid(scale, scale, scale),
            Geometry::Capsule { half_height: scale, radius: scale },
            Geometry::Cylinder { half_height: scale, radius: scale },
            Geometry::Cone { half_height: scale, radius: scale },
            hull(Vec3::splat(scale)),
            Geometry::Compound { parts: vec![(LocalPose::IDENTITY, cuboid(scale, scale, scale))] },
        ];
        for geometry in around {
            let mut world = world();
            let here = add(&mut world, geometry.clone(), Pose::IDENTITY);
            let behind = add(&mut world, cuboid(scale, scale, scale), Pose::at(DVec3::X * 5.0 * size));
            let ball = Shape::ball(0.1 * scale).unwrap();
            let path = DVec3::X * 10.0 * size;
            for (way, reach) in [(Cast::new(&ball, Pose::IDENTITY, path), 0.1), (Cast::ray(DVec3::ZERO, path), 0.0)] {
                let first = cast(&world, &way).expect("it begins in a solid");
                assert!(first.shape == here && first.distance == 0.0, "{geometry:?}: {first:?}");
                let turns = [Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5)];
                for turn in if way.shape.is_some() { &turns[..] } else { &turns[..1] } {
                    let next = cast(&world, &Cast { ignore_overlapped: true, turn: *turn, ..way }).expect("there is one behind");
                    assert!(next.shape == behind, "{geometry:?}: {next:?}");
                    assert!((next.distance - (4.0 - reach) * size).abs() < 1.0e-6 * size, "{geometry:?}: {next:?}");
                }
                let mut all = Vec::new();
                world.cast_all(&Cast { ignore_overlapped: true, ..way }, &QueryFilter::default(), &mut all).unwrap();
                assert_eq!(all.iter().map(|hit| hit.shape).collect::<Vec<_>>(), [behind], "{geometry:?}");
            }
        }
    }
}

#[test]
fn what_one_part_of_a_cast_begins_in_is_left_out_for_all_of_its_parts() {
    for scale in SCALES {
        let size = f64::from(scale);
        let mut world = world();
        add(&mut world, cuboid(scale, scale, scale), Pose::IDENTITY);
        let behind = add(&mut world, cuboid(scale, scale, scale), Pose::at(DVec3::X * 6.0 * size));
        // The ball in front is in the box, and the one behind it would come to it.
        for places in [[0.0, -2.0], [-2.0, 0.0]] {
            let ball = |x: f32| (LocalPose::at(Vec3::X * x * scale), Geometry::Ball { radius: 0.3 * scale });
            let pair = Shape::new(Geometry::Compound { parts: places.map(ball).to_vec() }).unwrap();
            for turn in [Vec3::ZERO, Vec3::new(0.0, 0.1, 0.0)] {
                let way = Cast { ignore_overlapped: true, turn, ..Cast::new(&pair, Pose::IDENTITY, DVec3::X * 10.0 * size) };
                let met = cast(&world, &way).expect("there is one behind");
                assert!(met.shape == behind && (met.distance - 4.7 * size).abs() < 5.0e-3 * size, "{scale} m: {met:?}");
                let first = cast(&world, &Cast { ignore_overlapped: false, ..way }).expect("it begins in a box");
                assert!(first.distance == 0.0 && first.depth > 1.2 * size, "{scale} m: {first:?}");
            }
        }
    }
}

/// A few shapes of every kind about the origin, most of which overlap what is there.
fn heap(dice: &mut Random, scale: f32) -> (World, Vec<ShapeId>) {
    let mut world = world();
    let shapes = (0..4).map(|_| {
        let mut size = || scale * dice.between(0.5, 2.0);
        let extents = [size(), size(), size()];
        let geometry = match (dice.between(0.0, 7.0)) as u32 {
            0 => Geometry::Ball { radius: extents[0] },
            1 => hull(Vec3::from(extents)),
            2 => sheet(extents[0], extents[1]),
            3 => Geometry::HalfSpace { normal: Vec3::Y },
            4 => {
                let heights = (0..30).map(|_| scale * dice.between(-0.2, 0.2)).collect();
                Geometry::HeightField { rows: 5, columns: 6, heights, size_x: 4.0 * extents[0], size_z: 4.0 * extents[1] }
            }
            5 => {
                let part = |x: f32| (LocalPose::at(Vec3::X * x * scale), cuboid(extents[0], extents[1], extents[2]));
                Geometry::Compound { parts: vec![part(0.0), part(20.0), part(1.0)] }
            }
            _ => cuboid(extents[0], extents[1], extents[2]),
        };
        let place = (dice.vector(0.7) * scale).as_dvec3();
        let turn = if dice.between(0.0, 1.0) < 0.3 { Quat::IDENTITY } else { dice.rotation() };
        add(&mut world, geometry, Pose::at(place).rotated(turn))
    });
    let shapes = shapes.collect();
    (world, shapes)
}

#[test]
fn of_several_shapes_that_a_solid_overlaps_the_deepest_is_named() {
    let (mut dice, mut overlapped) = (Random::new(3), 0);
    for number in 0..2000 {
        let scale = SCALES[number % SCALES.len()];
        let (world, shapes) = heap(&mut dice, scale);
        let size = scale * dice.between(0.05, 1.0);
        let probe = match number % 3 {
            0 => Shape::ball(size).unwrap(),
            1 => Shape::new(cuboid(size, 2.0 * size, 0.5 * size)).unwrap(),
            _ => {
                let part = |x: f32| (LocalPose::at(Vec3::X * x * size), Geometry::Ball { radius: size });
                Shape::new(Geometry::Compound { parts: vec![part(0.0), part(3.0)] }).unwrap()
            }
        };
        let at = Pose::at((dice.vector(1.0) * scale).as_dvec3()).rotated(dice.rotation());
        let nearest = |accept: &(dyn Fn(ShapeId) -> bool + Sync)| {
            let filter = QueryFilter { accept: Some(accept), ..QueryFilter::default() };
            let found = world.nearest_shape(&probe, at, 10.0 * scale, &filter).unwrap();
            found.map_or(f64::INFINITY, |found| found.distance.distance)
        };
        let alone = shapes.iter().map(|&shape| nearest(&|other| other == shape)).fold(f64::INFINITY, f64::min);
        let all = nearest(&|_| true);
        assert!(all == alone, "number {number}: {all} m of all, {alone} m of one by one");
        overlapped += u32::from(all < 0.0);
    }
    assert!(overlapped > 1000, "only {overlapped} overlap");
}

#[test]
fn of_what_a_cast_begins_in_only_those_parts_and_triangles_are_left_out() {
    let ball = Shape::ball(0.2).unwrap();
    let mut world = world();
    let parts = [0.0, 3.0].map(|x| (LocalPose::at(Vec3::X * x), cuboid(0.5, 0.5, 0.5))).to_vec();
    add(&mut world, Geometry::Compound { parts }, Pose::IDENTITY);
    let way = Cast { ignore_overlapped: true, ..Cast::new(&ball, Pose::IDENTITY, DVec3::X * 9.0) };
    let met = cast(&world, &way).expect("the other part");
    assert!(met.part == Some(1) && (met.distance - 2.3).abs() < 1.0e-6, "{met:?}");
    // A floor that the ball is sunk in by 0.05 m, and a wall of the same mesh at x = 4.
    let corners = [(-9.0, 0.0, -9.0), (-9.0, 0.0, 9.0), (4.0, 0.0, 9.0), (4.0, 0.0, -9.0), (4.0, 9.0, 9.0), (4.0, 9.0, -9.0)];
    let vertices = corners.map(|(x, y, z)| Vec3::new(x, y, z)).to_vec();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]];
    let mut world = self::world();
    add(&mut world, Geometry::TriangleMesh { vertices, triangles }, Pose::IDENTITY);
    let way = Cast { pose: Pose::at_xyz(0.0, 0.15, -1.0), ..way };
    let first = cast(&world, &Cast { ignore_overlapped: false, ..way }).expect("the floor");
    assert!(first.distance == 0.0 && (first.depth - 0.05).abs() < 1.0e-6, "{first:?}");
    let met = cast(&world, &way).expect("the wall");
    assert!(met.triangle == Some(2) && (met.distance - 3.8).abs() < 1.0e-6, "{met:?}");
}

/// What every kind of question says is at `at`, where a small ball comes down from above.
fn named(world: &World, shape: ShapeId, at: DVec3) -> Vec<(Option<u32>, Option<u32>)> {
    let ball = Shape::ball(0.01).unwrap();
    let (above, down) = (at + DVec3::Y * 0.3, DVec3::NEG_Y * 2.0);
    let turning = Cast { turn: Vec3::Y, ..Cast::new(&ball, Pose::at(above), down) };
    let hits = [Cast::ray(above, down), Cast::new(&ball, Pose::at(above), down), turning];
    let mut found: Vec<_> = hits.iter().map(|way| cast(world, way).map(|hit| (hit.part, hit.triangle)).expect("a hit")).collect();
    let point = world.nearest_point(above, 5.0, &QueryFilter::default()).unwrap().expect("it is near");
    found.push((point.part, point.triangle));
    let near = world.nearest_shape(&ball, Pose::at(above), 5.0, &QueryFilter::default()).unwrap().expect("it is near");
    assert_eq!(near.shape, shape);
    found.push((near.distance.parts[0], near.distance.triangles[0]));
    found
}

#[test]
fn every_answer_names_the_part_or_the_triangle() {
    let mut world = world();
    let xs = [0.0, 2.0, 4.0, 6.0];
    let parts = [cuboid(0.5, 0.5, 0.5), hull(Vec3::splat(0.5)), Geometry::Cylinder { half_height: 0.5, radius: 0.5 }];
    let parts = parts.into_iter().chain([Geometry::Ball { radius: 0.5 }]);
    let parts = xs.into_iter().zip(parts).map(|(x, part)| (LocalPose::at(Vec3::X * x), part)).collect();
    let shape = add(&mut world, Geometry::Compound { parts }, Pose::at_xyz(0.0, -0.5, 0.0));
    for (number, x) in xs.into_iter().enumerate() {
        let found = named(&world, shape, DVec3::X * f64::from(x));
        assert!(found.iter().all(|&found| found == (Some(number as u32), None)), "part {number}: {found:?}");
    }
    // A grid of 4 × 5 posts as a height field; as a mesh whose first triangle has no area and is no surface.
    let (rows, columns) = (4_usize, 5_usize);
    let field = Geometry::HeightField { rows, columns, heights: vec![0.0; rows * columns], size_x: 4.0, size_z: 3.0 };
    let (vertices, mut triangles) = field.triangles().unwrap();
    triangles.insert(0, [0, 0, 1]);
    for (form, offset) in [(field, 0), (Geometry::TriangleMesh { vertices, triangles }, 1)] {
        let mut world = self::world();
        let shape = add(&mut world, form, Pose::IDENTITY);
        for (row, column) in (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| (row, column))) {
            for (across, share) in [(0, 0.3), (1, 0.7)] {
                let at = DVec3::new(column as f64 + share - 2.0, 0.0, row as f64 + share - 1.5);
                let number = 2 * (row * (columns - 1) + column) + across + offset;
                let found = named(&world, shape, at);
                assert!(found.iter().all(|&found| found == (None, Some(number as u32))), "triangle {number}: {found:?}");
            }
        }
    }
}

#[test]
fn distances_of_two_shapes_name_the_parts_and_triangles_of_both() {
    let mut world = world();
    let row = |y: f32| {
        let parts = [0.0, 2.0, 4.0].map(|x| (LocalPose::at(Vec3::new(x, y * x, 0.0)), cuboid(0.5, 0.5, 0.5)));
        Geometry::Compound { parts: parts.to_vec() }
    };
    // Two rows that lean apart are nearest at their first boxes; turned round, at the last of one.
    let a = add(&mut world, row(0.0), Pose::IDENTITY);
    let b = add(&mut world, row(0.5), Pose::at_xyz(0.0, 3.0, 0.0));
    let found = world.shape_distance(a, b).unwrap();
    assert!(found.parts == [Some(0), Some(0)] && (found.distance - 2.0).abs() < 1.0e-6, "{found:?}");
    let c = add(&mut world, row(-0.5), Pose::at_xyz(0.0, 5.0, 0.0));
    let found = world.shape_distance(c, a).unwrap();
    assert!(found.parts == [Some(2), Some(2)] && (found.distance - 2.0).abs() < 1.0e-6, "{found:?}");
    let floor = add(&mut world, sheet(9.0, 9.0), Pose::at_xyz(0.0, -2.0, 0.0));
    let found = world.shape_distance(c, floor).unwrap();
    assert!(found.parts == [Some(2), None] && found.triangles[0].is_none() && found.triangles[1].is_some(), "{found:?}");
}

#[test]
fn far_above_an_edge_and_a_little_beside_it_the_nearest_point_is_on_the_shape() {
    let half = 0.5_f32;
    let forms = [
        cuboid(half, half, half),
        hull(Vec3::splat(half)),
        Geometry::Cylinder { half_height: half, radius: half },
        Geometry::Compound { parts: vec![(LocalPose::IDENTITY, cuboid(half, half, half))] },
    ];
    let upright = forms.into_iter().map(|form| (form, Quat::IDENTITY, 0.5));
    // A cone stands on its tip here, its flat end above.
    let cone = (Geometry::Cone { half_height: half, radius: half }, Quat::from_xyzw(0.0, 0.0, 1.0, 0.0), 0.5);
    for (form, rotation, top) in upright.chain([cone, (sheet(half, half), Quat::IDENTITY, 0.0)]) {
        let mut world = world();
        add(&mut world, form.clone(), Pose { position: DVec3::ZERO, rotation });
        for (above, beside) in [(1.0, 1.0e-5), (100.0, 1.0e-3), (1.0e4, 0.1), (1.0e6, 10.0)] {
            let at = DVec3::new(0.5 + beside, top + above, 0.0);
            let point = world.nearest_point(at, 1.0e7, &QueryFilter::default()).unwrap().expect("it is near");
            let ball = Shape::ball(0.1).unwrap();
            let shape = world.nearest_shape(&ball, Pose::at(at), 1.0e7, &QueryFilter::default()).unwrap().expect("it is near");
            for (found, distance) in [(point.point, point.distance), (shape.distance.point_a, shape.distance.distance + 0.1)] {
                let off = (found.x - 0.5).max((found.y - top).abs());
                assert!(off < 1.0e-8, "{form:?}, {above} m above: {off} m off the shape");
                let error = (distance - above.hypot(beside)).abs();
                assert!(error < 1.0e-9 * above + 1.0e-8, "{form:?}, {above} m above: {error} m wrong");
            }
        }
    }
}
