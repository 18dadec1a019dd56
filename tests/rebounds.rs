//! Rebounds: energy is passed on, lost to what is not elastic, and never made.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, Geometry, JointDef, JointKind, Limits, Mass, Material, Motor, Pose, Shape, ShapeDef, Solver,
    World, WorldDef,
};

const RADIUS: f32 = 0.1;
const SPEED: f32 = 2.36;

fn world(gravity: f32, substeps: u32) -> World {
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, substeps, ..WorldDef::default() }).unwrap()
}

/// A ball of 1 kg without friction.
fn ball(world: &mut World, at: DVec3, speed: f32, restitution: f32) -> BodyId {
    let mut shape = ShapeDef::new(Shape::ball(RADIUS).unwrap());
    shape.material = Material { restitution, friction: 0.0, ..Material::default() };
    let def = BodyDef { linear_velocity: Vec3::X * speed, mass: Mass::Total(1.0), ..BodyDef::dynamic(Pose::at(at)) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

/// Kinetic energy and that of height of balls of 1 kg, but for their spin (J).
fn energy(world: &World, balls: &[BodyId]) -> f64 {
    let of = |&ball: &BodyId| {
        let (position, velocity) = (world.pose(ball).unwrap().position, world.linear_velocity(ball).unwrap());
        0.5 * f64::from(velocity.length_squared()) - f64::from(world.gravity().y) * position.y
    };
    balls.iter().map(of).sum()
}

#[test]
fn a_row_of_balls_passes_a_blow_on_and_gains_no_energy() {
    for gap in [0.0, 2.0e-4, 2.0e-3, 1.0e-2, 3.0e-2] {
        for moving in 1..=2 {
            let mut world = world(0.0, 4);
            let place = |i: usize| f64::from(2.0 * RADIUS + gap) * i as f64 - if i < moving { 0.5 } else { 0.0 };
            let balls: Vec<_> =
                (0..5).map(|i| ball(&mut world, DVec3::X * place(i), if i < moving { SPEED } else { 0.0 }, 1.0)).collect();
            let before = energy(&world, &balls);
            for _ in 0..60 {
                world.step(1.0 / 60.0).unwrap();
                let now = energy(&world, &balls);
                assert!(now < before * 1.0001, "gap {gap} m, {moving} moving: {before} J have become {now} J");
            }
            let last = world.linear_velocity(balls[4]).unwrap().x;
            println!("gap {gap} m, {moving} moving: last ball {last:.4} m/s, {:.4} J of {before:.4}", energy(&world, &balls));
            assert!((last - SPEED).abs() < 0.01 * SPEED, "gap {gap} m, {moving} moving: {last} m/s");
            let kept = energy(&world, &balls) / before;
            assert!(kept > 0.99, "gap {gap} m, {moving} moving: {kept} of the energy is left");
        }
    }
}

#[test]
fn a_cradle_gains_no_energy() {
    for (rate, substeps) in [(30.0, 4), (60.0, 1), (60.0, 4), (240.0, 2), (240.0, 4)] {
        for lifted in 1..=2 {
            let mut world = world(9.81, substeps);
            let balls: Vec<_> = (0..5)
                .map(|i| {
                    let pivot = DVec3::new(0.2002 * i as f64, 2.0, 0.0);
                    let string = if i < lifted { Vec3::new(-0.7, -0.714, 0.0).normalize() } else { Vec3::NEG_Y };
                    let ball = ball(&mut world, pivot + string.as_dvec3(), 0.0, 1.0);
                    let def = JointDef::new(JointKind::SPHERICAL, BodyId::NULL, ball).at(pivot.as_vec3(), -string);
                    world.create_joint(&JointDef { collide_connected: true, ..def }).unwrap();
                    ball
                })
                .collect();
            let before = energy(&world, &balls);
            let fallen = lifted as f64 * 9.81 * (1.0 - 0.714);
            let mut worst = f64::NEG_INFINITY;
            for _ in 0..(5.0 * rate) as usize {
                world.step(1.0 / rate).unwrap();
                worst = worst.max((energy(&world, &balls) - before) / fallen);
            }
            println!("{lifted} lifted, {rate} steps a second of {substeps}: gains {worst:.5} of what they have fallen by");
            // While balls touch, velocities are told half a substep early: ½ h a of their speed.
            let most = if rate < 60.0 { 2.5e-3 } else { 1.0e-3 };
            assert!(worst < most, "{lifted} lifted, {rate} steps a second of {substeps}: gains {worst:.4}");
        }
    }
}

#[test]
fn a_rebound_that_is_over_within_a_step_is_told_of() {
    // In steps of 1/60 s of eight substeps it comes down in another one each time.
    for start in 0..8 {
        let mut world = world(9.81, 8);
        let mut floor = ShapeDef::new(Shape::cuboid(Vec3::new(5.0, 0.5, 5.0)).unwrap());
        floor.material.friction = 0.0;
        world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(floor)).unwrap();
        let ball = ball(&mut world, DVec3::Y * (1.0 + 0.009 * f64::from(start)), 0.0, 0.9);
        let (mut began, mut ended, mut impulse) = (0, 0, 0.0);
        for _ in 0..45 {
            world.step(1.0 / 60.0).unwrap();
            if !world.contact_began().is_empty() {
                began += 1;
                impulse = world.contact_force(ball).unwrap().y / (60.0 * 8.0);
            }
            ended += world.contact_ended().len();
            let mut snapshot = Vec::new();
            world.save(&mut snapshot);
            world.restore(&snapshot).unwrap();
        }
        assert_eq!((began, ended), (1, 1), "it comes down once in 0.75 s");
        assert!(impulse > 1.9 * 4.0 && impulse < 1.9 * 4.7, "a blow of {impulse} N·s");
    }
}

fn cuboid(half: Vec3, restitution: f32) -> ShapeDef {
    let mut shape = ShapeDef::new(Shape::cuboid(half).unwrap());
    shape.material = Material { restitution, friction: 0.5, ..Material::default() };
    shape
}

/// How high a cube of 1 m comes up again that falls flat from this height onto what is below (m), and how fast it spins then (rad/s).
fn drop_flat(height: f64, restitution: f32, tiles: &[(f64, f64, f32)], legs: &[Vec3], (rate, substeps): (f32, u32)) -> [f64; 2] {
    let mut world = world(9.81, substeps);
    for &(x, z, half) in tiles {
        let tile = cuboid(Vec3::new(half, 0.5, half), restitution);
        world.create_body(&BodyDef::fixed(Pose::at_xyz(x, -0.5, z)).with_shape(tile)).unwrap();
    }
    let mut def = BodyDef::dynamic(Pose::at_xyz(0.0, 0.5 + height, 0.0));
    if legs.is_empty() {
        def = def.with_shape(cuboid(Vec3::splat(0.5), restitution));
    }
    for &leg in legs {
        let mut shape = cuboid(Vec3::new(0.05, 0.5, 0.05), restitution);
        shape.local_pose.position = leg;
        def = def.with_shape(shape);
    }
    let body = world.create_body(&def).unwrap();
    let start = world.center_of_mass(body).unwrap().y;
    let (mut has_hit, mut rise, mut spin) = (false, 0.0_f64, 0.0_f64);
    // Until it comes down again: what has turned by a thousandth by then lands on an edge.
    let flight = (1.0 + 1.9 * f64::from(restitution)) * (2.0 * height / 9.81).sqrt();
    for _ in 0..(flight * f64::from(rate)) as usize {
        world.step(1.0 / rate).unwrap();
        has_hit |= world.linear_velocity(body).unwrap().y > 0.0;
        if has_hit {
            rise = rise.max(world.center_of_mass(body).unwrap().y - start + height);
            spin = spin.max(f64::from(world.angular_velocity(body).unwrap().length()));
        }
    }
    [rise, spin]
}

#[test]
fn a_flat_drop_over_many_manifolds_comes_up_by_restitution_squared_and_does_not_spin() {
    let grid = |count: usize, x: f64, z: f64| -> Vec<(f64, f64, f32)> {
        let at = |i: usize| (i as f64 - 0.5 * (count as f64 - 1.0)) / (count as f64 - 1.0) * 2.0;
        let half = (1.0 / (count as f64 - 1.0)) as f32;
        (0..count * count).map(|i| (at(i % count) + x, at(i / count) + z, half)).collect()
    };
    let legs = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)].map(|(x, z)| Vec3::new(0.4 * x, 0.0, 0.3 * z));
    let floors =
        [("four tiles", grid(2, 0.0, 0.0)), ("four tiles, aside", grid(2, 0.17, 0.23)), ("49 tiles", grid(7, 0.05, 0.1))];
    for (restitution, height) in [(1.0_f32, 2.0), (0.5, 2.0), (0.5, 0.5)] {
        let due = height * f64::from(restitution * restitution);
        for timing in [(60.0, 4), (60.0, 16), (120.0, 4)] {
            for (name, tiles) in &floors {
                let [rise, spin] = drop_flat(height, restitution, tiles, &[], timing);
                println!("{name}, e {restitution}, {height} m, {timing:?}: {rise} m of {due}, {spin} rad/s");
                // Two per cent, as of one manifold.
                assert!(
                    (rise / due - 1.0).abs() < 0.02 && spin < 0.02,
                    "{name}, e {restitution}, {timing:?}: {rise} m of {due}, {spin} rad/s"
                );
            }
            let [rise, spin] = drop_flat(height, restitution, &[(0.0, 0.0, 5.0)], &legs, timing);
            assert!(
                (rise / due - 1.0).abs() < 0.02 && spin < 0.02,
                "on legs, e {restitution}, {timing:?}: {rise} m of {due}, {spin} rad/s"
            );
        }
    }
}

#[test]
fn a_gas_of_elastic_balls_keeps_its_energy_and_does_not_spin() {
    for (rate, substeps, balls) in [(60.0, 4, 60), (60.0, 1, 30), (240.0, 4, 60)] {
        let mut world = world(0.0, substeps);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for side in [-5.5, 5.5] {
                let mut wall = cuboid(Vec3::splat(5.0) - axis * 4.5, 1.0);
                wall.material.friction = 0.0;
                world.create_body(&BodyDef::fixed(Pose::at((axis * side).as_dvec3())).with_shape(wall)).unwrap();
            }
        }
        let place = |i: usize| (DVec3::new((i % 4) as f64, (i / 4 % 4) as f64, (i / 16) as f64) - 1.5) * 2.0;
        let all: Vec<_> = (0..balls)
            .map(|i| {
                let ball = ball(&mut world, place(i), 0.0, 1.0);
                let k = i as f32;
                world.set_linear_velocity(ball, 5.0 * Vec3::new(k.sin(), (2.0 * k).cos(), (3.0 * k).sin())).unwrap();
                ball
            })
            .collect();
        let before = energy(&world, &all);
        for _ in 0..(8.0 * rate) as usize {
            world.step(1.0 / rate).unwrap();
        }
        let kept = energy(&world, &all) / before;
        let spin = all.iter().map(|&ball| world.angular_velocity(ball).unwrap().length()).fold(0.0, f32::max);
        println!("{balls} balls, {rate} Hz of {substeps}: {kept} of the energy, {spin} rad/s");
        assert!(
            (kept - 1.0).abs() < 0.01 && spin < 1.0e-3,
            "{balls} balls, {rate} Hz of {substeps}: {kept} of the energy, {spin} rad/s"
        );
    }
}

#[test]
fn balls_that_hit_each_other_without_friction_do_not_spin() {
    for (restitution, speed, rate) in
        [(0.0_f32, 2.0_f32, 30.0), (0.0, 10.0, 60.0), (0.0, 50.0, 60.0), (0.5, 20.0, 60.0), (1.0, 50.0, 240.0)]
    {
        for phase in 0..24 {
            let mut world = world(0.0, 4);
            let angle = 0.7 * phase as f32;
            // Half of what is between a central hit and a glancing one, and so much before they meet.
            let aside = 0.95 * RADIUS * (phase as f32 + 0.5) / 24.0 * Vec3::new(0.0, angle.cos(), angle.sin());
            let ahead = Vec3::X * (RADIUS + 2.0 * speed / rate * (1.0 + phase as f32 / 24.0));
            let [a, b] = [-1.0_f32, 1.0].map(|side| {
                let ball = ball(&mut world, (side * (ahead + aside)).as_dvec3(), 0.0, restitution);
                world.set_linear_velocity(ball, Vec3::X * -side * speed).unwrap();
                ball
            });
            for _ in 0..12 {
                world.step(1.0 / rate).unwrap();
            }
            let spin = [a, b].map(|ball| world.angular_velocity(ball).unwrap().length());
            let met = (world.linear_velocity(a).unwrap() - Vec3::X * speed).length();
            assert!(met > 0.01 * speed, "they do not meet");
            assert!(spin.iter().all(|&spin| spin < 1.0e-3), "e {restitution}, {speed} m/s, {rate} Hz, {phase}: {spin:?} rad/s");
        }
    }
}

#[test]
fn friction_of_a_rebound_is_that_of_the_whole_blow_and_makes_no_energy() {
    for (friction, restitution) in [(0.05_f32, 1.0_f32), (0.2, 0.5), (2.0, 1.0), (2.0, 0.3)] {
        let mut world = world(0.0, 4);
        let mut floor = cuboid(Vec3::new(5.0, 0.5, 5.0), restitution);
        floor.material.friction = friction;
        world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(floor)).unwrap();
        let mut shape = ShapeDef::new(Shape::ball(RADIUS).unwrap());
        shape.material = Material { restitution, friction, ..Material::default() };
        let velocity = Vec3::new(4.0, -3.0, 0.0);
        let def = BodyDef { linear_velocity: velocity, mass: Mass::Total(1.0), ..BodyDef::dynamic(Pose::at_xyz(-0.4, 0.4, 0.0)) };
        let ball = world.create_body(&def.with_shape(shape)).unwrap();
        for _ in 0..30 {
            world.step(1.0 / 60.0).unwrap();
        }
        let (after, spin) = (world.linear_velocity(ball).unwrap(), world.angular_velocity(ball).unwrap());
        // What the ball is pressed with is m (1 + e) v. Friction takes its share, or 2/7 of the speed, at which the ball rolls.
        let slowed = (friction * (1.0 + restitution) * 3.0).min(4.0 * 2.0 / 7.0);
        let due = Vec3::new(4.0 - slowed, 3.0 * restitution, 0.0);
        assert!((after - due).length() < 0.02, "friction {friction}, e {restitution}: {after} m/s, expected {due}");
        let energy = |v: Vec3, w: Vec3| 0.5 * (v.length_squared() + 0.4 * RADIUS * RADIUS * w.length_squared());
        assert!(
            energy(after, spin) <= energy(velocity, Vec3::ZERO) * 1.0001,
            "friction {friction}, e {restitution}: energy is made"
        );
    }
}

/// A solid of so much restitution that has come to rest on the floor, or falls.
fn solid(world: &mut World, geometry: Geometry, (mass, height, speed): (f32, f64, f32), restitution: f32) -> BodyId {
    let mut shape = ShapeDef::new(Shape::new(geometry).unwrap());
    shape.material = Material { restitution, friction: 0.5, ..Material::default() };
    let at = Pose::at_xyz(-0.012, height, 0.02);
    let def = BodyDef { linear_velocity: Vec3::NEG_Y * speed, mass: Mass::Total(mass), ..BodyDef::dynamic(at) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

/// Without restitution nothing goes up again, whatever it falls on lies on, and with next to none next to nothing. What sweeps pass on of a blow one
/// contact at a time, and carry on as if it were a force, threw a ball up at a quarter of its speed from a plate of its own mass, and at half of it
/// from one of a quarter. With a restitution of 0.001 to 0.1 the last of the blow was carried on, up to the speed below which nothing rebounds: up at
/// 0.78 m/s, and what is 38 times as heavy as the plate sank into it by its whole height.
#[test]
fn what_falls_on_something_that_lies_does_not_rebound() {
    let plate = Geometry::Box { half_extents: Vec3::new(0.45, 0.035, 0.25) };
    for (falling, low) in [(Geometry::Ball { radius: 0.25 }, 0.25), (Geometry::Box { half_extents: Vec3::splat(0.2) }, 0.2)] {
        for (mass, rate) in
            [3.5, 35.0, 157.0, 1400.0].into_iter().flat_map(|mass| [30.0, 60.0, 120.0, 240.0].map(|rate| (mass, rate)))
        {
            for (solver, restitution) in [Solver::Auto, Solver::GaussSeidel]
                .into_iter()
                .flat_map(|solver| [0.0, 0.001, 0.05].map(|restitution| (solver, restitution)))
            {
                let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).unwrap();
                let ground = Shape::cuboid(Vec3::new(20.0, 1.0, 20.0)).unwrap();
                world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(ShapeDef::new(ground))).unwrap();
                solid(&mut world, plate.clone(), (35.0, 0.035, 0.0), restitution);
                for _ in 0..rate as u32 / 2 {
                    world.step(1.0 / rate).unwrap();
                }
                let body = solid(&mut world, falling.clone(), (mass, 0.37 + low, 2.4), restitution);
                let (mut up, mut deep) = (0.0_f32, 0.0_f64);
                for _ in 0..rate as u32 / 2 {
                    world.step(1.0 / rate).unwrap();
                    up = up.max(world.linear_velocity(body).unwrap().y);
                    deep = deep.max(0.07 + low - world.pose(body).unwrap().position.y);
                }
                let what = format!("{falling:?} of {mass} kg at {rate} Hz, e {restitution}, {solver:?}");
                println!("{what}: up at {up} m/s, {deep} m deep");
                assert!(up < 0.1 + 3.8 * restitution, "{what}: up at {up} m/s");
                assert!(deep < if rate < 60.0 { 1.0e-2 } else { 2.0e-3 }, "{what}: {deep} m deep");
            }
        }
    }
}

/// A wall that goes at a steady speed makes nothing go faster that it pushes, with a light body between it and a heavy one.
#[test]
fn what_a_wall_pushes_goes_no_faster_than_the_wall() {
    for (mass, rate) in [10.0, 100.0, 2000.0].into_iter().flat_map(|mass| [30.0_f32, 60.0, 240.0].map(|rate| (mass, rate))) {
        let mut world = world(0.0, 4);
        let wall = BodyDef { kind: BodyKind::Kinematic, ..BodyDef::dynamic(Pose::at_xyz(-1.0, 0.0, 0.0)) };
        let wall = world.create_body(&wall.with_shape(ShapeDef::new(Shape::cuboid(Vec3::new(0.2, 1.0, 2.0)).unwrap()))).unwrap();
        world.set_linear_velocity(wall, Vec3::X).unwrap();
        let crates = [(0.0, 10.0), (0.6, mass)].map(|(x, mass)| {
            let def = BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)) };
            world.create_body(&def.with_shape(ShapeDef::new(Shape::cuboid(Vec3::splat(0.3)).unwrap()))).unwrap()
        });
        for _ in 0..(1.5 * rate) as u32 {
            world.step(1.0 / rate).unwrap();
            for body in crates {
                let speed = world.linear_velocity(body).unwrap().x;
                assert!(speed < 1.001, "10 kg and {mass} kg at {rate} Hz: {speed} m/s before a wall at 1 m/s");
            }
        }
        let speed = world.linear_velocity(crates[1]).unwrap().x;
        assert!(speed > 0.999, "{mass} kg at {rate} Hz: {speed} m/s");
    }
}

/// The same of a slider whose motor sets off just before a body: nobody knows of the speed that it will hit with when the step begins.
#[test]
fn what_a_motor_pushes_goes_no_faster_than_the_motor() {
    for (mass, rate) in [1.0, 5.0, 50.0].into_iter().flat_map(|mass| [30.0_f32, 60.0, 120.0].map(|rate| (mass, rate))) {
        for gap in [0.0, 1.0e-3, 3.0e-3, 1.0e-2, 3.0e-2] {
            let mut world = world(0.0, 4);
            let mut put = |x: f64, mass: f32| {
                let def = BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)) };
                world.create_body(&def.with_shape(ShapeDef::new(Shape::cuboid(Vec3::splat(0.2)).unwrap()))).unwrap()
            };
            let (pusher, body) = (put(0.0, 10.0), put(0.4 + gap, mass));
            let motor = Motor::Velocity { target: 1.0, max_force: 1.0e5 };
            let kind = JointKind::Prismatic { limits: Limits::NONE, motor };
            world.create_joint(&JointDef::new(kind, BodyId::NULL, pusher)).unwrap();
            let mut fastest = 0.0_f32;
            for _ in 0..rate as u32 {
                world.step(1.0 / rate).unwrap();
                fastest = fastest.max(world.linear_velocity(body).unwrap().x);
            }
            assert!((0.999..1.005).contains(&fastest), "{mass} kg, {gap} m off, {rate} Hz: {fastest} m/s by a motor of 1 m/s");
        }
    }
}

/// A ball that is hit right before a wall comes back from it: what has a gap left when a blow is over hits in a substep of its own.
#[test]
fn a_ball_that_is_hit_right_before_a_wall_comes_back_from_it() {
    for rate in [30.0_f32, 60.0, 120.0, 240.0, 480.0] {
        for gap in [1.0e-3, 2.0e-3, 5.0e-3, 1.0e-2, 3.0e-2] {
            let mut world = world(0.0, 4);
            world
                .create_body(&BodyDef::fixed(Pose::at_xyz(0.2 + gap, 0.0, 0.0)).with_shape(cuboid(Vec3::new(0.1, 1.0, 1.0), 1.0)))
                .unwrap();
            let balls = [ball(&mut world, DVec3::X * -0.8, 4.0, 1.0), ball(&mut world, DVec3::ZERO, 0.0, 1.0)];
            for _ in 0..rate as u32 {
                world.step(1.0 / rate).unwrap();
            }
            let [first, second] = balls.map(|ball| world.linear_velocity(ball).unwrap().x);
            assert!((first + 4.0).abs() < 0.01 && second.abs() < 0.01, "{gap} m off at {rate} Hz: {first} and {second} m/s");
        }
    }
}

/// What flies against a ball without friction and restitution gains nothing, whichever point of its rim it hits with, and whichever by the end of the
/// substep would be nearest: cones came off with up to five times their energy.
#[test]
fn what_has_a_rim_gains_nothing_from_a_ball() {
    for form in [Geometry::Cone { half_height: 0.5, radius: 0.5 }, Geometry::Cylinder { half_height: 0.5, radius: 0.5 }] {
        for rate in [30.0_f32, 60.0, 120.0] {
            for throw in 0..100_u32 {
                let mut world = world(0.0, 4);
                let smooth = Material { friction: 0.0, ..Material::default() };
                let mut round = ShapeDef::new(Shape::ball(0.5).unwrap());
                round.material = smooth;
                world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(round)).unwrap();
                let [turn, tilt, aside] = [0.37, 0.73, 0.59].map(|step| (throw as f32 * step).fract());
                let rotation = Quat::from_rotation_y(6.3 * turn) * Quat::from_rotation_x(3.1 * tilt);
                let pose = Pose::at_xyz(2.0, f64::from(1.2 * aside - 0.6), 0.0).rotated(rotation);
                let mut shape = ShapeDef::new(Shape::new(form.clone()).unwrap());
                shape.material = smooth;
                let def = BodyDef { linear_velocity: Vec3::X * -10.0, ..BodyDef::dynamic(pose) };
                let body = world.create_body(&def.with_shape(shape)).unwrap();
                let own = world.mass_properties(body).unwrap().unwrap();
                let energy = |world: &World| {
                    let [speed, spin] = [world.linear_velocity(body).unwrap(), world.angular_velocity(body).unwrap()];
                    let spin = (world.pose(body).unwrap().rotation * own.inertia_frame).conjugate() * spin;
                    own.mass * speed.length_squared() + spin.dot(own.principal_inertia * spin)
                };
                let before = energy(&world);
                for _ in 0..(0.4 * rate) as u32 {
                    world.step(1.0 / rate).unwrap();
                    let now = energy(&world);
                    assert!(now < 1.001 * before, "{form:?}, throw {throw} at {rate} Hz: {before} J have become {now}");
                }
            }
        }
    }
}
