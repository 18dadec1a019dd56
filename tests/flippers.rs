//! Paddles throw what lies on them as they do where steps are fine: a flipper on a motor, and one that the host turns.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef,
};

/// From where to where a flipper turns (rad).
const TURN: [f32; 2] = [-0.45, 0.55];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Flipper {
    Box,
    Capsule,
}

/// Speed at which a flipper of `size` (m), turned at `speed` (rad/s), throws a ball that lies on it at a quarter of its length. The host tells a
/// kinematic one how fast it turns `rate` times a second; each of these steps is taken in `pieces`.
fn thrown(form: Flipper, is_driven: bool, (rate, pieces): (f32, u32), speed: f32, size: f32) -> f32 {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let gravity = Vec3::NEG_Y * size;
    let mut world = World::new(&WorldDef { gravity, sleep, ..WorldDef::default() }).expect("a valid world");
    let (radius, half) = (0.17 * size, 0.075 * size);
    let surface = |shape: Shape| {
        let mut shape = ShapeDef::new(shape);
        (shape.material.friction, shape.material.restitution) = (0.1, 0.0);
        shape
    };
    let mut blade = match form {
        Flipper::Box => surface(Shape::cuboid(Vec3::new(0.5 * size, half, 0.25 * size)).expect("a shape")),
        Flipper::Capsule => surface(Shape::capsule(0.5 * size - half, half).expect("a shape")),
    };
    blade.local_pose.position = Vec3::X * (0.5 * size);
    if form == Flipper::Capsule {
        blade.local_pose.rotation = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    }
    let turned = Quat::from_rotation_z(TURN[0]);
    let at = Pose::at(DVec3::ZERO).rotated(turned);
    let kind = if is_driven { BodyKind::Dynamic } else { BodyKind::Kinematic };
    let def = BodyDef { kind, ..BodyDef::dynamic(at) }.with_shape(blade).with_mass(Mass::Total(8.0 * size.powi(3)));
    let flipper = world.create_body(&def).expect("a valid body");
    if is_driven {
        let limits = Limits::new(TURN[0], TURN[1]);
        let motor = Motor::Velocity { target: speed, max_force: 1.0e5 * size.powi(5) * speed * speed };
        let mut joint = JointDef::new(JointKind::Hinge { limits, motor }, BodyId::NULL, flipper);
        let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        (joint.frame_a, joint.frame_b) = (joint.frame_a.rotated(about_z), joint.frame_b.rotated(about_z));
        world.create_joint(&joint).expect("a valid joint");
    }
    let place = turned * Vec3::new(0.3 * size, half + radius, 0.0);
    let ball = BodyDef::dynamic(Pose::at(place.as_dvec3())).with_shape(surface(Shape::ball(radius).expect("a shape")));
    let ball = world.create_body(&ball.with_mass(Mass::Total(size.powi(3)))).expect("a valid body");
    let mut angle = TURN[0];
    for _ in 0..(1.2 * (TURN[1] - TURN[0]) / speed * rate).ceil() as u32 + 1 {
        if !is_driven {
            let rate = ((TURN[1] - angle) * rate).min(speed);
            world.set_angular_velocity(flipper, Vec3::Z * rate).expect("a body of the world");
        }
        for _ in 0..pieces {
            world.step(1.0 / (rate * pieces as f32)).expect("a valid step");
        }
        if !is_driven {
            angle += ((TURN[1] - angle) * rate).min(speed) / rate;
        }
    }
    world.linear_velocity(ball).expect("a body of the world").length() / size
}

#[test]
fn a_flipper_throws_as_where_steps_are_fine() {
    for (form, is_driven) in
        [Flipper::Box, Flipper::Capsule].into_iter().flat_map(|form| [true, false].map(|driven| (form, driven)))
    {
        // The stop of one on a motor takes the last part of a substep.
        for (rate, speed, size, [by_host, by_motor]) in [
            (30.0, 8.0, 0.05, [0.1, 0.12]),
            (60.0, 8.0, 5.0, [0.05, 0.06]),
            (60.0, 25.0, 0.05, [0.12, 0.22]),
            (120.0, 25.0, 0.5, [0.06, 0.09]),
            (240.0, 25.0, 5.0, [0.04, 0.06]),
        ] {
            let most = if is_driven { by_motor } else { by_host };
            let [found, fine] = [1, 32].map(|pieces| thrown(form, is_driven, (rate, pieces), speed, size));
            let what =
                format!("{form:?}, {}, {speed} rad/s, {size} m, {rate}/s", if is_driven { "by a motor" } else { "by the host" });
            let share = found / fine;
            println!("{what}: {share:.3} of {fine:.3} sizes a second");
            assert!((share - 1.0).abs() < most, "{what}: thrown at {share} of {fine} sizes a second, off by {most} at most");
        }
    }
}
