//! What rolls on driven wheels goes as fast as they turn, and hangs in its springs as statics says.

use std::f32::consts::TAU;

use longspan::glam::{DVec3, Mat3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, Geometry, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, Softness, Solver, World,
    WorldDef,
};

const RADIUS: f32 = 0.4;
const GRAVITY: f32 = 9.8;

fn round(geometry: Geometry) -> ShapeDef {
    let mut shape = ShapeDef::new(Shape::new(geometry).expect("a valid shape"));
    shape.material.friction = 0.9;
    shape
}

fn add(world: &mut World, at: DVec3, turned: Quat, shape: ShapeDef, mass: f32) -> BodyId {
    let def = BodyDef::dynamic(Pose::at(at).rotated(turned)).with_shape(shape).with_mass(Mass::Total(mass));
    world.create_body(&def).expect("a valid body")
}

fn join(world: &mut World, kind: JointKind, [a, b]: [BodyId; 2], at: DVec3, axis: Vec3) {
    let frame = Quat::from_rotation_arc(Vec3::X, axis);
    let mut def = JointDef::new(kind, a, b);
    let place = |world: &World, body: BodyId| {
        let pose = world.pose(body).expect("it exists");
        Pose::at(pose.inverse_transform_point(at).as_dvec3()).rotated(pose.rotation.inverse() * frame)
    };
    (def.frame_a, def.frame_b) = (place(world, a), place(world, b));
    world.create_joint(&def).expect("a valid joint");
}

/// A world with a floor at y = 0: a half-space, or a box of ten tonnes on it.
fn floor(solver: Solver, is_deck: bool) -> World {
    let mut world =
        World::new(&WorldDef { gravity: Vec3::NEG_Y * GRAVITY, solver, ..WorldDef::default() }).expect("a valid world");
    let at = Pose::at(DVec3::Y * if is_deck { -0.5 } else { 0.0 });
    let ground = BodyDef::fixed(at).with_shape(round(Geometry::HalfSpace { normal: Vec3::Y }));
    world.create_body(&ground).expect("a floor");
    if is_deck {
        let half_extents = Vec3::new(40.0, 0.25, 2.0);
        add(&mut world, DVec3::Y * -0.25, Quat::IDENTITY, round(Geometry::Box { half_extents }), 1.0e4);
    }
    world
}

/// A tonne on four wheels of 30 kg, on a floor at y = 0; between chassis and hubs are springs, where there are any.
fn car(solver: Solver, wheel: Geometry, turn: f32, spring: Option<Softness>) -> (World, BodyId, Vec<BodyId>) {
    let mut world = floor(solver, false);
    let motor = Motor::Velocity { target: -turn, max_force: f32::INFINITY };
    let (chassis, all) = add_car(&mut world, wheel, turn, spring, motor);
    (world, chassis, all)
}

fn add_car(world: &mut World, wheel: Geometry, turn: f32, spring: Option<Softness>, motor: Motor) -> (BodyId, Vec<BodyId>) {
    let chassis = ShapeDef::new(Shape::cuboid(Vec3::new(1.5, 0.2, 0.6)).expect("a valid shape"));
    let chassis = add(world, DVec3::Y * 0.7, Quat::IDENTITY, chassis, 1000.0);
    let upright = if matches!(wheel, Geometry::Ball { .. }) { Quat::IDENTITY } else { Quat::from_rotation_arc(Vec3::Y, Vec3::Z) };
    let mut all = vec![chassis];
    for (x, z) in [(-1.0, -0.8), (-1.0, 0.8), (1.0, -0.8), (1.0, 0.8)] {
        let at = DVec3::new(x, f64::from(RADIUS), z);
        let mut bearer = chassis;
        if let Some(softness) = spring {
            let mut shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.1)).expect("a valid shape"));
            shape.filter.collides_with = 0;
            let hub = add(world, at, Quat::IDENTITY, shape, 15.0);
            let spring = Motor::Position { target: 0.0, softness, max_force: f32::INFINITY };
            join(world, JointKind::Prismatic { limits: Limits::new(-0.3, 0.3), motor: spring }, [bearer, hub], at, Vec3::Y);
            (bearer, all) = (hub, [all, vec![hub]].concat());
        }
        let wheel = add(world, at, upright, round(wheel.clone()), 30.0);
        world.set_angular_velocity(wheel, Vec3::Z * -turn).expect("a valid velocity");
        join(world, JointKind::Hinge { limits: Limits::NONE, motor }, [bearer, wheel], at, Vec3::Z);
        all.push(wheel);
    }
    for &body in &all {
        world.set_linear_velocity(body, Vec3::X * turn * RADIUS).expect("a valid velocity");
    }
    (chassis, all)
}

/// Within a step the point at which a wheel touches goes around it: by a third of a radian at 10 rad/s and 30 steps a second.
#[test]
fn a_car_drives_as_fast_as_its_wheels_turn() {
    let wheels = [
        Geometry::Cylinder { half_height: 0.15, radius: RADIUS },
        Geometry::Ball { radius: RADIUS },
        Geometry::Capsule { half_height: 0.1, radius: RADIUS },
    ];
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for wheel in &wheels {
            for turn in [3.0_f32, 10.0, 30.0, 100.0] {
                for rate in [30.0, 60.0, 240.0] {
                    let (mut world, chassis, _) = car(solver, wheel.clone(), turn, None);
                    for _ in 0..(2.0 * rate) as usize {
                        world.step(1.0 / rate).expect("a valid step");
                    }
                    let what = format!("{solver:?}, {wheel:?}, {turn} rad/s, {rate}/s");
                    let speed = world.linear_velocity(chassis).expect("it stays").x;
                    let at = world.pose(chassis).expect("it stays").position;
                    let (gone, told) = (f64::from(turn * RADIUS) * 2.0, turn * RADIUS);
                    assert!((speed / told - 1.0).abs() < 2e-3, "{what}: {speed} m/s of {told}, bound 0.2 %");
                    assert!((at.x / gone - 1.0).abs() < 2e-3, "{what}: gone {} m of {gone}, bound 0.2 %", at.x);
                    assert!((at.y - 0.7).abs() < 5e-3, "{what}: the chassis is at {} m in place of 0.7, bound 5 mm", at.y);
                    assert!(at.z.abs() < 5e-3, "{what}: {} m aside, bound 5 mm", at.z);
                }
            }
        }
    }
}

#[test]
fn a_car_hangs_in_its_springs_as_its_weight_says() {
    for frequency in [1.0_f32, 1.5, 3.0] {
        for rate in [30.0, 60.0, 240.0] {
            let stiffness = 250.0 * (TAU * frequency).powi(2);
            let softness = Softness { compliance: stiffness.recip(), damping: (stiffness * 250.0).sqrt() };
            let wheel = Geometry::Cylinder { half_height: 0.15, radius: RADIUS };
            let (mut world, chassis, all) = car(Solver::Auto, wheel, 10.0, Some(softness));
            let mut gap = 0.0_f32;
            for _ in 0..(6.0 * rate) as usize {
                world.step(1.0 / rate).expect("a valid step");
                gap = gap.max(world.report().residuals.joint_gap);
            }
            let (sag, what) = (f64::from(250.0 * GRAVITY / stiffness), format!("{frequency} Hz, {rate}/s"));
            let [at, wheel] = [chassis, all[2]].map(|body| world.pose(body).expect("it stays").position);
            let speed = world.linear_velocity(chassis).expect("it stays").x;
            assert!((wheel.y - f64::from(RADIUS)).abs() < 2e-3, "{what}: a wheel's axle is at {} m, bound 2 mm off 0.4", wheel.y);
            assert!((0.7 - sag - at.y).abs() < 2e-3, "{what}: the chassis sags to {} m, expected {} ± 0.002", at.y, 0.7 - sag);
            assert!((speed - 4.0).abs() < 0.02, "{what}: {speed} m/s, expected 4 ± 0.02");
            assert!(gap < 1e-3, "{what}: joints {gap} m open, bound 1 mm");
        }
    }
}

/// Nothing slows down what rolls on free wheels, on the ground and on what lies there, however heavy that is: a body under a wheel was taken to
/// go round it as a link of a rope goes round a drum, and held the wheel back by 0.36 g h/r of its speed, h being the substep.
#[test]
fn what_coasts_on_free_wheels_keeps_its_speed() {
    let wheels = [
        Geometry::Cylinder { half_height: 0.15, radius: RADIUS },
        Geometry::Ball { radius: RADIUS },
        Geometry::Capsule { half_height: 0.1, radius: RADIUS },
    ];
    for (solver, wheel) in
        [Solver::Auto, Solver::GaussSeidel].into_iter().flat_map(|solver| wheels.iter().map(move |w| (solver, w)))
    {
        for (is_deck, rate) in [false, true].into_iter().flat_map(|deck| [30.0_f32, 60.0, 240.0].map(|rate| (deck, rate))) {
            let mut world = floor(solver, is_deck);
            let (chassis, _) = add_car(&mut world, wheel.clone(), 10.0, None, Motor::Off);
            for _ in 0..(3.0 * rate) as usize {
                world.step(1.0 / rate).expect("a valid step");
            }
            let kept = world.linear_velocity(chassis).expect("it stays").x / (10.0 * RADIUS);
            let what = format!("{solver:?}, {wheel:?}, {rate}/s, on {}", if is_deck { "a deck" } else { "the ground" });
            assert!((kept - 1.0).abs() < 2e-3, "{what}: {kept} of its speed is left, bound 0.2 % off");
        }
    }
}

/// The same of a ball with a hundredth of its mass hanging from its centre, of 2 cm to 3.5 m: 0.2 to 0.9 of its speed was left after 5 s.
#[test]
fn what_hangs_from_the_centre_of_a_ball_does_not_slow_it_down() {
    for radius in [0.02_f32, 0.5, 3.5] {
        for (rate, is_hinge) in [30.0_f32, 60.0, 240.0].into_iter().flat_map(|rate| [false, true].map(|hinge| (rate, hinge))) {
            let mut world = floor(Solver::Auto, false);
            let speed = 6.0 * radius;
            let at = DVec3::Y * f64::from(radius);
            let ball = add(&mut world, at, Quat::IDENTITY, round(Geometry::Ball { radius }), 100.0);
            let mut shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.1 * radius)).expect("a valid shape"));
            shape.filter.collides_with = 0;
            let tag = add(&mut world, at * 0.5, Quat::IDENTITY, shape, 1.0);
            let kind = if is_hinge { JointKind::HINGE } else { JointKind::SPHERICAL };
            join(&mut world, kind, [ball, tag], at, Vec3::Z);
            world.set_angular_velocity(ball, Vec3::NEG_Z * (speed / radius)).expect("a valid velocity");
            for body in [ball, tag] {
                world.set_linear_velocity(body, Vec3::X * speed).expect("a valid velocity");
            }
            for _ in 0..(5.0 * rate) as usize {
                world.step(1.0 / rate).expect("a valid step");
            }
            let kept = world.linear_velocity(ball).expect("it stays").x / speed;
            assert!((kept - 1.0).abs() < 2e-3, "of {radius} m, {rate}/s: {kept} of its speed is left, bound 0.2 % off");
        }
    }
}

/// The car of *docs/guide/recipes.md*: its wheels are on six-axis joints whose x axis points up. With y up and x the axle, the axis of steering goes
/// round with the wheel, and it drives straight on.
#[test]
fn a_car_on_six_axis_joints_drives_in_the_circle_that_it_steers() {
    let (circle, speed) = (8.0_f32, 3.0_f32);
    let spring = Softness { compliance: 2.5e-5, damping: 2000.0 };
    for (rate, has_servo) in [30.0_f32, 60.0, 120.0, 240.0].into_iter().flat_map(|rate| [true, false].map(|servo| (rate, servo)))
    {
        let mut world = floor(Solver::Auto, false);
        let chassis = ShapeDef::new(Shape::cuboid(Vec3::new(1.5, 0.2, 0.6)).expect("a valid shape"));
        let chassis = add(&mut world, DVec3::Y * 0.7, Quat::IDENTITY, chassis, 1000.0);
        for (x, z) in [(-1.0_f32, -0.8_f32), (-1.0, 0.8), (1.0, -0.8), (1.0, 0.8)] {
            let at = DVec3::new(f64::from(x), f64::from(RADIUS), f64::from(z));
            let wheel = Geometry::Cylinder { half_height: 0.1, radius: RADIUS };
            let wheel = add(&mut world, at, Quat::from_rotation_arc(Vec3::Y, Vec3::Z), round(wheel), 30.0);
            // Each wheel rolls as fast as its circle about the middle of them all is long.
            let (ahead, across) = (x + 1.0, circle - z);
            let drive = Motor::Velocity { target: -speed / RADIUS * ahead.hypot(across) / circle, max_force: 500.0 };
            let turn = -(ahead / across).atan();
            let is_steered = x > 0.0;
            let servo = Motor::Position { target: turn, softness: Softness::RIGID, max_force: f32::INFINITY };
            let steered = Axis { limits: Limits::new(-1.0, 1.0), motor: servo };
            let hung = Motor::Position { target: 0.0, softness: spring, max_force: f32::INFINITY };
            let kind = JointKind::Generic {
                linear: [Axis { limits: Limits::new(-0.2, 0.2), motor: hung }, Axis::LOCKED, Axis::LOCKED],
                angular: [
                    if is_steered && has_servo { steered } else { Axis::LOCKED },
                    Axis { limits: Limits::NONE, motor: drive },
                    Axis::LOCKED,
                ],
            };
            // What is locked is locked as it is made: already steered.
            let made = Quat::from_rotation_y(if is_steered && !has_servo { turn } else { 0.0 });
            let upright = Quat::from_mat3(&Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X));
            let mut def = JointDef::new(kind, chassis, wheel);
            let place = |body: BodyId, turned: Quat| {
                let pose = world.pose(body).expect("it exists");
                let local = pose.inverse_transform_point(at).as_dvec3();
                Pose::at(local).rotated(pose.rotation.inverse() * turned * upright)
            };
            (def.frame_a, def.frame_b) = (place(chassis, made), place(wheel, Quat::IDENTITY));
            world.create_joint(&def).expect("a valid joint");
        }
        let steps = |world: &mut World, seconds: f32| {
            for _ in 0..(seconds * rate) as usize {
                world.step(1.0 / rate).expect("a valid step");
            }
        };
        steps(&mut world, 4.0);
        let (way, turning) = (world.linear_velocity(chassis), world.angular_velocity(chassis));
        let (way, turning) = (way.expect("it stays").length(), turning.expect("it stays").y);
        let what = format!("{rate}/s, with a servo: {has_servo}");
        let (radius, expected) = (-way / turning, circle.hypot(1.0));
        assert!((radius / expected - 1.0).abs() < 0.02, "{what}: a circle of {radius} m, bound 2 % from {expected} m");
        assert!((way / speed - 1.0).abs() < 0.02, "{what}: {way} m/s, bound 2 % from {speed} m/s");
        let height = world.pose(chassis).expect("it stays").position.y;
        steps(&mut world, 1.0);
        let bob = world.pose(chassis).expect("it stays").position.y - height;
        // A rigid servo trembles, more in longer steps.
        let most = if has_servo { 5.0e-3 } else { 1.0e-3 };
        assert!(bob.abs() < most, "{what}: the chassis moves by {bob} m in a second, bound {most} m");
    }
}
