//! A jack lifts the side of what only stands on it, however slowly its force grows: it doesn't fall asleep on the way.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, Geometry, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, Solver, World,
    WorldDef,
};

const RATES: [f32; 3] = [30.0, 60.0, 240.0];

/// How a jack drives its head up from its foot.
#[derive(Debug, Clone, Copy)]
enum Jack {
    Slider,
    Servo,
    SixAxis,
}

/// A car of so many times 3.2 m on four wheels, with a jack under its left side whose force is four times what that side weighs.
fn jacked_car(jack: Jack, solver: Solver, scale: f32) -> (World, BodyId, JointId) {
    let gravity = Vec3::NEG_Y * 9.81;
    let mut world = World::new(&WorldDef { solver, gravity, ..WorldDef::default() }).expect("a valid world");
    let ground = ShapeDef::new(Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).expect("a valid shape"));
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(ground)).expect("a valid body");
    let heavy = scale * scale * scale;
    let mut put = |geometry: Geometry, at: Vec3, turn: Quat, mass: f32| {
        let shape = ShapeDef::new(Shape::new(geometry).expect("a valid shape"));
        let pose = Pose::at((at * scale).as_dvec3()).rotated(turn);
        world.create_body(&BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(mass * heavy))).expect("a valid body")
    };
    let cuboid = |half: Vec3| Geometry::Box { half_extents: half * scale };
    let car = put(cuboid(Vec3::new(1.6, 0.3, 0.7)), Vec3::Y * 0.65, Quat::IDENTITY, 1200.0);
    let across = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let wheel = Geometry::Cylinder { half_height: 0.1 * scale, radius: 0.35 * scale };
    let places = [(-1.1, -0.85), (-1.1, 0.85), (1.1, -0.85), (1.1, 0.85)].map(|(x, z)| Vec3::new(x, 0.35, z));
    let wheels = places.map(|at| (at, put(wheel.clone(), at, across, 20.0)));
    let foot = put(cuboid(Vec3::new(0.15, 0.03, 0.15)), Vec3::new(0.0, 0.03, 0.5), Quat::IDENTITY, 5.0);
    let head = put(cuboid(Vec3::new(0.06, 0.1, 0.06)), Vec3::new(0.0, 0.2, 0.5), Quat::IDENTITY, 2.0);
    let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    for (at, wheel) in wheels {
        let mut def = JointDef::new(JointKind::HINGE, car, wheel);
        def.frame_a = Pose::at(((at - Vec3::Y * 0.65) * scale).as_dvec3()).rotated(about_z);
        def.frame_b = Pose::IDENTITY.rotated(across.conjugate() * about_z);
        def.friction = 500.0 * heavy * scale;
        world.create_joint(&def).expect("a valid joint");
    }
    let (speed, max_force) = (0.05 * scale.sqrt(), 3.0e4 * heavy);
    let motor = match jack {
        Jack::Servo => Motor::Position { target: 0.2 * scale, softness: longspan::Softness::RIGID, max_force },
        Jack::Slider | Jack::SixAxis => Motor::Velocity { target: speed, max_force },
    };
    let limits = Limits::new(-0.02 * scale, 0.2 * scale);
    let (up, along) = (Quat::from_rotation_z(std::f32::consts::FRAC_PI_2), [Axis { limits, motor }, Axis::LOCKED, Axis::LOCKED]);
    let kind = match jack {
        Jack::SixAxis => JointKind::Generic { linear: along, angular: [Axis::LOCKED; 3] },
        Jack::Slider | Jack::Servo => JointKind::Prismatic { limits, motor },
    };
    let mut def = JointDef::new(kind, foot, head);
    let at = |up: f32| DVec3::Y * f64::from(up * scale);
    (def.frame_a, def.frame_b) = (Pose::at(at(0.03)).rotated(up), Pose::at(at(-0.14)).rotated(up));
    let joint = world.create_joint(&def).expect("a valid joint");
    (world, head, joint)
}

#[test]
fn a_jack_lifts_the_side_of_a_free_car() {
    for (jack, rate) in [Jack::Slider, Jack::Servo, Jack::SixAxis].into_iter().flat_map(|jack| RATES.map(|rate| (jack, rate))) {
        for scale in [0.1_f32, 1.0, 10.0] {
            let (mut world, _, joint) = jacked_car(jack, Solver::Auto, scale);
            for _ in 0..(5.0 * rate * scale.sqrt()) as u32 {
                world.step(1.0 / rate).expect("a valid step");
            }
            let reached = world.joint_axis_state(joint, 0).expect("the joint has this axis").position / scale;
            // 0.05 √(m s²) for five times √s.
            assert!((reached - 0.2).abs() < 5.0e-3, "{jack:?} under a car of {scale} at {rate}/s: at {reached} of 0.2");
        }
    }
}

#[test]
fn a_swept_jack_whose_force_has_yet_to_grow_does_not_sleep() {
    for (jack, rate) in [Jack::Slider, Jack::SixAxis].into_iter().flat_map(|jack| RATES.map(|rate| (jack, rate))) {
        for scale in [0.1_f32, 1.0, 10.0] {
            let (mut world, head, joint) = jacked_car(jack, Solver::GaussSeidel, scale);
            for _ in 0..(3.0 * rate * scale.sqrt().max(1.0)) as u32 {
                world.step(1.0 / rate).expect("a valid step");
            }
            let at = world.joint_axis_state(joint, 0).expect("the joint has this axis").position / scale;
            let is_awake = world.is_awake(head).expect("it is there");
            assert!(is_awake || at > 0.195, "{jack:?} under a car of {scale} at {rate}/s: asleep at {at} of 0.2");
        }
    }
}
