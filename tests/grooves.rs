//! Marbles go on along grooves and over bends of several pieces as if these were one.

use std::f64::consts::TAU;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, LocalPose, Mass, Material, Pose, Shape, ShapeDef, World, WorldDef};

fn ball(world: &mut World, radius: f32, position: DVec3, speed: f32, friction: f32, spin: f32) -> BodyId {
    let shape = Shape::ball(radius).unwrap();
    let mut part = ShapeDef::new(shape);
    part.material = Material { friction, ..Material::default() };
    let mut def = BodyDef::dynamic(Pose { position, rotation: Quat::IDENTITY }).with_shape(part);
    (def.mass, def.can_sleep) = (Mass::Total(1.0), false);
    (def.linear_velocity, def.angular_velocity) = (Vec3::X * speed, Vec3::Z * -spin);
    world.create_body(&def).unwrap()
}

fn ground(world: &mut World, geometry: Geometry, friction: f32) {
    let mut part = ShapeDef::new(Shape::new(geometry).unwrap());
    part.material = Material { friction, ..Material::default() };
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(part)).unwrap();
}

/// A level groove along x, of pairs of triangles `length` long on both sides, whose walls rise by `slope`.
fn groove(count: u32, length: f32, width: f32, slope: f32) -> Geometry {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..=count {
        let x = length * (i as f32 - 0.5 * count as f32);
        vertices.extend([-1.0_f32, 0.0, 1.0].map(|side| Vec3::new(x, width * slope * side.abs(), width * side)));
    }
    for i in 0..count {
        for j in 0..2 {
            let a = 3 * i + j;
            triangles.extend([[a, a + 1, a + 3], [a + 1, a + 4, a + 3]]);
        }
    }
    Geometry::TriangleMesh { vertices, triangles }
}

/// The corner of the next facets lies ahead, along a normal that leans back, and is passed above: looked at where the marble presses, it stopped
/// marbles at up to 0.4 of their speed and threw them up by a radius.
#[test]
fn a_marble_keeps_its_speed_along_a_groove_of_triangles() {
    for (radius, rate, stride, degrees) in [
        (0.01_f32, 60.0_f32, 0.5_f32, 15.0_f32),
        (0.01, 60.0, 1.0, 15.0),
        (0.01, 60.0, 1.5, 45.0),
        (0.01, 240.0, 0.3, 15.0),
        (0.01, 120.0, 2.0, 30.0),
        (0.5, 60.0, 0.5, 15.0),
        (0.5, 30.0, 1.0, 30.0),
        // Slow: what tilts it from side to side is no smooth surface, and took or gave what it was raised and lowered by.
        (0.01, 60.0, 0.05, 15.0),
        (0.01, 60.0, 0.2, 15.0),
    ] {
        for phase in 0..12 {
            let slope = degrees.to_radians().tan();
            let mut world = World::new(&WorldDef::default()).unwrap();
            ground(&mut world, groove(16, 2.5 * radius, 3.0 * radius, slope), 0.0);
            let (height, speed) = (radius / degrees.to_radians().cos(), stride * radius * rate);
            let start = radius * (-18.0 + stride * phase as f32 / 12.0);
            let position = DVec3::new(f64::from(start), f64::from(height + 1.0e-3 * radius), 0.0);
            let body = ball(&mut world, radius, position, speed, 0.0, 0.0);
            for step in 0..(30.0 / stride).min(300.0) as usize {
                world.step(1.0 / rate).unwrap();
                let share = world.linear_velocity(body).unwrap().x / speed;
                let hop = (world.pose(body).unwrap().position.y as f32 - height) / radius;
                let what = format!("{radius} m, {rate} Hz, {stride} radii a step, {degrees} degrees, phase {phase}, step {step}");
                assert!((0.97..1.02).contains(&share), "{what}: {share} of the speed");
                assert!(hop < 0.03, "{what}: {hop} radii up");
            }
        }
    }
}

/// Across a concave edge a triangle pushed as if it bent outwards there, along the edge as well: marbles stopped, or were driven on.
#[test]
fn a_marble_rolls_on_in_valleys_of_a_height_field_and_in_a_half_pipe() {
    for (radius, rate, stride) in
        [(0.01_f32, 60.0_f32, 0.05_f32), (0.01, 60.0, 0.25), (0.01, 30.0, 0.1), (0.1, 60.0, 0.05), (0.01, 120.0, 0.5)]
    {
        // In a flat pipe slow marbles that fall by a quarter of their radius in a step stop: docs/guide/limits.md.
        let is_slow = stride < 0.5;
        for is_pipe in [false, true].into_iter().take(if is_slow { 1 } else { 2 }) {
            for phase in 0..6 {
                let mut world = World::new(&WorldDef::default()).unwrap();
                let (rows, columns, cell) = (9, 61, 2.0 * radius);
                let slope = 15.0_f32.to_radians();
                let width = |row: usize| (row as f32 - 4.0) * cell;
                let rise = |across: f32| match is_pipe {
                    // Of a pipe of 16 radii, whose lowest strips meet in the middle.
                    true => 16.0 * radius - (256.0 * radius * radius - across * across).sqrt(),
                    false => across.abs() * slope.tan(),
                };
                let heights = (0..rows).flat_map(|row| std::iter::repeat_n(rise(width(row)), columns)).collect();
                let (size_x, size_z) = (cell * 60.0, cell * 8.0);
                ground(&mut world, Geometry::HeightField { rows, columns, heights, size_x, size_z }, 0.5);
                let lean = if is_pipe { (rise(cell) / cell).atan() } else { slope };
                let (speed, height) = (stride * radius * rate, radius / lean.cos());
                let start = radius * (-50.0 + 2.0 * phase as f32 / 6.0);
                let position = DVec3::new(f64::from(start), f64::from(height + 1.0e-3 * radius), 0.0);
                let body = ball(&mut world, radius, position, speed, 0.5, speed / (radius * lean.cos()));
                for step in 0..(60.0 / stride).min(600.0) as usize {
                    world.step(1.0 / rate).unwrap();
                    let share = world.linear_velocity(body).unwrap().x / speed;
                    let what =
                        format!("pipe: {is_pipe}, {radius} m, {rate} Hz, {stride} radii a step, phase {phase}, step {step}");
                    assert!((0.96..1.03).contains(&share), "{what}: {share} of the speed");
                }
            }
        }
    }
}

/// It falls by twice its radius in a step, and rests on the edge alone as it goes over it.
#[test]
fn a_slow_marble_does_not_fall_through_the_edge_that_it_rolls_over() {
    for (radius, rate) in [(0.005_f32, 30.0_f32), (0.005, 60.0), (0.05, 30.0)] {
        for case in 0..16 {
            let (slope, length) = (0.15 + 0.07 * case as f32, radius * (0.3 + 0.08 * case as f32));
            let mut world = World::new(&WorldDef::default()).unwrap();
            let columns = 2 * (15.0 * radius / length).ceil() as usize + 1;
            let x = |column: usize| length * (column as f32 - 0.5 * (columns - 1) as f32);
            let row = (0..columns).map(|column| -x(column).max(0.0) * slope.tan());
            let heights = (0..5).flat_map(|_| row.clone()).collect();
            let (size_x, size_z) = (length * (columns - 1) as f32, 40.0 * radius);
            ground(&mut world, Geometry::HeightField { rows: 5, columns, heights, size_x, size_z }, 0.5);
            let speed = 0.03 * radius * rate;
            let position = DVec3::new(f64::from(-0.4 * radius), f64::from(1.001 * radius), 0.0);
            let body = ball(&mut world, radius, position, speed, 0.5, speed / radius);
            for step in 0..200 {
                world.step(1.0 / rate).unwrap();
                let position = world.pose(body).unwrap().position;
                if position.x as f32 > 0.5 * size_x - 2.0 * radius {
                    break;
                }
                let ground = -position.x.max(0.0) * f64::from(slope.tan());
                let what = format!("{radius} m, {rate} Hz, slope {slope}, step {step}");
                assert!(position.y > ground + 0.5 * f64::from(radius), "{what}: {} m under the ground", ground - position.y);
            }
        }
    }
}

/// Of the part that is met ahead the normal where the ball presses is that of its edge: it left 0.67 to 0.98 of the speed, by where steps began.
#[test]
fn a_ball_keeps_its_speed_over_a_bend_of_a_compound() {
    for (radius, rate, stride, angle) in [
        (0.15_f32, 60.0_f32, 0.25_f32, 7.5_f64),
        (0.15, 60.0, 0.86, 7.5),
        (0.15, 60.0, 1.5, 7.5),
        (0.15, 60.0, 1.5, 20.0),
        (0.02, 120.0, 0.5, 7.5),
    ] {
        for phase in 0..16 {
            let mut world =
                World::new(&WorldDef { gravity: Vec3::Y * -0.1 * radius * rate * rate * 0.01, ..WorldDef::default() }).unwrap();
            let (length, half, turn) = (20.0 * f64::from(radius), 0.7 * f64::from(radius), angle / 360.0 * TAU);
            let plank = Geometry::Box { half_extents: Vec3::new(0.5 * length as f32, half as f32, 5.0 * radius) };
            let level = LocalPose { position: DVec3::new(-0.5 * length, -half, 0.0).as_vec3(), rotation: Quat::IDENTITY };
            let (sin, cos) = turn.sin_cos();
            let middle = DVec3::new(0.5 * length * cos + half * sin, 0.5 * length * sin - half * cos, 0.0);
            let risen = LocalPose { position: middle.as_vec3(), rotation: Quat::from_rotation_z(turn as f32) };
            ground(&mut world, Geometry::Compound { parts: vec![(level, plank.clone()), (risen, plank)] }, 0.0);
            let speed = stride * radius * rate;
            let start = f64::from(radius) * (-8.0 - f64::from(stride) * f64::from(phase) / 16.0);
            let body = ball(&mut world, radius, DVec3::new(start, f64::from(radius), 0.0), speed, 0.0, 0.0);
            for _ in 0..(14.0 / stride) as usize {
                world.step(1.0 / rate).unwrap();
            }
            // What it has risen by is as good as nothing; the bend takes what goes into it.
            let share = f64::from(world.linear_velocity(body).unwrap().length() / speed) / cos;
            let what = format!("{radius} m, {rate} Hz, {stride} radii a step, {angle} degrees, phase {phase}");
            assert!((share - 1.0).abs() < 0.015, "{what}: {share} of what the bend leaves");
        }
    }
}

/// An elastic ball of 0.1 m in a closed room of triangles, of this half width and so many squares along each side, without gravity.
fn in_a_room(half: f32, count: usize, position: DVec3, velocity: Vec3) -> (World, BodyId) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let first = vertices.len() as u32;
            let along = |number: usize| half * (2.0 * number as f32 / count as f32 - 1.0);
            for i in 0..=count {
                for j in 0..=count {
                    let mut corner = Vec3::ZERO;
                    (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (side * half, along(i), along(j));
                    vertices.push(corner);
                }
            }
            for i in 0..count as u32 {
                for j in 0..count as u32 {
                    let a = first + i * (count as u32 + 1) + j;
                    let (b, c, d) = (a + 1, a + count as u32 + 1, a + count as u32 + 2);
                    // Seen from inside.
                    let pair = if side < 0.0 { [[a, c, b], [b, c, d]] } else { [[a, b, c], [b, d, c]] };
                    triangles.extend(pair);
                }
            }
        }
    }
    let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, restitution_threshold: 0.0, ..WorldDef::default() }).unwrap();
    let elastic = |shape: Shape| {
        let mut part = ShapeDef::new(shape);
        part.material = Material { friction: 0.0, restitution: 1.0, ..Material::default() };
        part
    };
    let room = elastic(Shape::new(Geometry::TriangleMesh { vertices, triangles }).unwrap());
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(room)).unwrap();
    let ball = elastic(Shape::ball(0.1).unwrap());
    let mut def = BodyDef::dynamic(Pose { position, rotation: Quat::IDENTITY }).with_shape(ball);
    (def.mass, def.can_sleep, def.linear_velocity) = (Mass::Total(1.0), false, velocity);
    let body = world.create_body(&def).unwrap();
    (world, body)
}

/// A wall of small triangles is met where the ball comes to it, not where it was when it pressed another: an elastic ball got out of its room at 0.95 radii
/// a step.
#[test]
fn an_elastic_ball_stays_in_a_room_of_small_triangles() {
    for seed in 0..30 {
        let mut dice = crate::common::oracle::dice(seed);
        let (place, way) = (dice.vector(0.15), (dice.direction() * 5.7).as_vec3());
        let (mut world, body) = in_a_room(0.3, 5, place, way);
        for step in 0..200 {
            world.step(1.0 / 60.0).unwrap();
            let farthest = world.pose(body).unwrap().position.abs().max_element();
            assert!(farthest < 0.21, "seed {seed}, step {step}: {} radii from a wall", (0.3 - farthest) / 0.1);
            let speed = world.linear_velocity(body).unwrap().length();
            assert!((speed / 5.7 - 1.0).abs() < 0.01, "seed {seed}, step {step}: {speed} m/s");
        }
    }
}

/// At more than a radius a step, what has just rebounded from one wall meets two others within one step: it carries no load then. It was taken to go straight
/// through the first of them, and passed the second: the ball went in by 0.16 and 0.38 radii.
#[test]
fn what_has_rebounded_meets_the_next_two_walls_in_one_step() {
    for (radii, place, way) in [
        (1.3_f32, [-0.3877, -0.2077, -0.1751], [-0.067, -0.534, -0.843]),
        (2.5, [-0.2341, 0.3441, 0.1331], [-0.634, 0.476, 0.609]),
    ] {
        let velocity = Vec3::from_array(way) * (radii * 0.1 * 60.0);
        let (mut world, body) = in_a_room(0.5, 1, DVec3::from_array(place), velocity);
        for step in 0..6 {
            world.step(1.0 / 60.0).unwrap();
            let nearest = (0.5 - world.pose(body).unwrap().position.abs().max_element()) / 0.1;
            assert!(nearest > 0.95, "{radii} radii a step, step {step}: {nearest} radii from a wall");
        }
    }
}
