//! Rebounds: energy is passed on, lost to what is not elastic, and never made.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyId, JointDef, JointKind, Mass, Material, Pose, Shape, ShapeDef, World, WorldDef};

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
    for (gap, passes_on) in [(0.0, false), (2.0e-4, false), (2.0e-3, false), (1.0e-2, true), (3.0e-2, true)] {
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
            assert!(!passes_on || (last - SPEED).abs() < 1.0e-3 * SPEED, "gap {gap} m, {moving} moving: {last} m/s");
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
            assert!(worst < 1.0e-3, "{lifted} lifted, {rate} steps a second of {substeps}: gains {worst:.4}");
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
