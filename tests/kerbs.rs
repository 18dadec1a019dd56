//! What rolls against a kerb keeps as much of its speed as where steps are fine: the wheel goes over the edge within a step.

use longspan::glam::{Quat, Vec3};
use longspan::{
    BodyDef, Geometry, JointDef, JointKind, Limits, Mass, MassProperties, Motor, Pose, Shape, ShapeDef, SleepSettings, Softness,
    World, WorldDef,
};

/// Radius of the wheel, and its mass and those of the hub and of what the hub bears, at size 1 (m, kg).
const RADIUS: f32 = 0.35;
const MASSES: [f32; 3] = [20.0, 5.0, 250.0];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Wheel {
    Disc,
    Ball,
}

/// Share of its speed that a quarter of a car keeps on a kerb: a wheel under a body that does not turn, with a spring between them. `phase` is how
/// far before the kerb it begins (m at size 1); each of `rate` steps a second is taken in `pieces`.
fn kept(wheel: Wheel, kerb: f32, phase: f32, speed: f32, size: f32, (rate, pieces): (f32, u32)) -> f32 {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let gravity = Vec3::NEG_Y * (9.81 * size);
    let mut world = World::new(&WorldDef { gravity, sleep, ..WorldDef::default() }).expect("a valid world");
    let ground = |size: Vec3| {
        let mut shape = ShapeDef::new(Shape::cuboid(size).expect("a shape"));
        shape.material.friction = 0.8;
        shape
    };
    // The wheel touches the edge where its middle is this far before it.
    let reach = (RADIUS * RADIUS - (RADIUS - kerb) * (RADIUS - kerb)).sqrt();
    for (x, top) in [(0.0, 0.0), (reach + phase + 10.0, kerb)] {
        let at = Pose::at((Vec3::new(x, top - 0.5, 0.0) * size).as_dvec3());
        world.create_body(&BodyDef::fixed(at).with_shape(ground(Vec3::new(10.0, 0.5, 2.0) * size))).expect("a valid body");
    }
    let volume = size.powi(3);
    let mut add = |y: f32, shape: Option<ShapeDef>, mass: f32, locked: bool| {
        let mut def = BodyDef::dynamic(Pose::at((Vec3::Y * (y * size)).as_dvec3()));
        (def.linear_velocity, def.locked_axes.rotation) = (Vec3::X * (speed * size), [locked; 3]);
        def = match shape {
            Some(shape) => def.with_shape(shape).with_mass(Mass::Total(mass * volume)),
            None => def.with_mass(Mass::Properties(MassProperties::new(mass * volume, Vec3::splat(mass * volume * size * size)))),
        };
        world.create_body(&def).expect("a valid body")
    };
    let mut shape = ShapeDef::new(match wheel {
        Wheel::Disc => Shape::new(Geometry::Cylinder { half_height: 0.1 * size, radius: RADIUS * size }).expect("a shape"),
        Wheel::Ball => Shape::ball(RADIUS * size).expect("a shape"),
    });
    shape.local_pose.rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    shape.material.friction = 0.8;
    let [body, hub] = [(RADIUS + 0.4, MASSES[2]), (RADIUS, MASSES[1])].map(|(y, mass)| add(y, None, mass, true));
    let wheel = add(RADIUS, Some(shape), MASSES[0], false);
    world.set_angular_velocity(wheel, Vec3::NEG_Z * (speed / RADIUS)).expect("a body of the world");
    let softness = Softness { compliance: 1.0 / (4.0e4 * volume), damping: 3.0e3 * volume };
    let motor = Motor::Position { target: -MASSES[2] * 9.81 / 4.0e4 * size, softness, max_force: f32::INFINITY };
    let slider = JointKind::Prismatic { limits: Limits::NONE, motor };
    let mut joint = JointDef::new(slider, body, hub).at(Vec3::NEG_Y * (0.4 * size), Vec3::ZERO);
    let up = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    (joint.frame_a, joint.frame_b) = (joint.frame_a.rotated(up), joint.frame_b.rotated(up));
    world.create_joint(&joint).expect("a valid joint");
    let hinge = JointKind::Hinge { limits: Limits::NONE, motor: Motor::Off };
    let mut joint = JointDef::new(hinge, hub, wheel);
    let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    (joint.frame_a, joint.frame_b) = (joint.frame_a.rotated(about_z), joint.frame_b.rotated(about_z));
    world.create_joint(&joint).expect("a valid joint");
    let steps = (1.5 * (phase + 2.0 * reach) / speed * rate).ceil() as u32 * pieces;
    let mut least = f32::INFINITY;
    for _ in 0..steps {
        world.step(1.0 / (rate * pieces as f32)).expect("a valid step");
        least = world.linear_velocity(body).expect("a body of the world").x;
    }
    least / (speed * size)
}

#[test]
fn a_wheel_keeps_at_a_kerb_what_it_keeps_in_fine_steps() {
    for wheel in [Wheel::Disc, Wheel::Ball] {
        for (kerb, speed, size) in [(0.04, 6.0, 1.0), (0.08, 12.0, 0.1), (0.08, 12.0, 1.0), (0.12, 12.0, 10.0)] {
            for (rate, most) in [(30.0, 0.06), (60.0, 0.03), (120.0, 0.03), (240.0, 0.02)] {
                for phase in [0.21, 0.32, 0.43] {
                    let [found, fine] = [1, 16].map(|pieces| kept(wheel, kerb, phase, speed, size, (rate, pieces)));
                    let what = format!("{wheel:?} at {speed} sizes a second over {kerb}, {size} m, {phase} before it, {rate}/s");
                    println!("{what}: keeps {found:.3}, in fine steps {fine:.3}");
                    assert!(
                        (found - fine).abs() < most,
                        "{what}: keeps {found} of its speed, in fine steps {fine}; bound {most}"
                    );
                }
            }
        }
    }
}
