//! A joint none of whose bodies is dynamic is idle, and comes alive with the first that is.

use std::f32::consts::TAU;

use longspan::glam::{Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, Solver, Strength, World,
    WorldDef,
};

/// Kinds of joints between the links of a chain, in turn.
const KINDS: [JointKind; 5] = [
    JointKind::Fixed,
    JointKind::HINGE,
    JointKind::SPHERICAL,
    JointKind::Distance { limits: Limits { min: 0.0, max: 0.01 }, spring_length: None, motor: Motor::Off },
    JointKind::Prismatic { limits: Limits { min: -0.05, max: 0.05 }, motor: Motor::Off },
];

/// A chain of ten links that hangs from the world, each joint of a kind of its own, one that breaks in the middle.
fn chain(solver: Solver) -> (World, Vec<BodyId>, Vec<JointId>) {
    let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).unwrap();
    let (mut bodies, mut joints) = (vec![], vec![]);
    for link in 0..10 {
        let def = BodyDef::dynamic(Pose::at_xyz(0.0, -0.2 * f64::from(link), 0.0)).with_mass(Mass::Total(1.0));
        let shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.03, 0.08, 0.03)).unwrap());
        bodies.push(world.create_body(&def.with_shape(shape)).unwrap());
    }
    for (number, &body) in bodies.iter().enumerate() {
        let before = if number == 0 { BodyId::NULL } else { bodies[number - 1] };
        let mut def = JointDef::new(KINDS[number % KINDS.len()], before, body);
        let down = if number == 0 { 0.1 } else { -0.1 };
        (def.frame_a, def.frame_b) = (Pose::at_xyz(0.0, down, 0.0), Pose::at_xyz(0.0, 0.1, 0.0));
        if number == 5 {
            def.strength = Strength { tension: 1.0e3, shear: 1.0e3, ..Strength::UNBREAKABLE };
            def.break_force = 1.0e3;
        }
        joints.push(world.create_joint(&def).unwrap());
    }
    (world, bodies, joints)
}

/// How far down the chain pulls at the world (N).
fn load(world: &World, joints: &[JointId]) -> f32 {
    world.joint_state(joints[0]).unwrap().force.length()
}

#[test]
fn a_chain_that_an_animation_moves_bears_nothing_and_hangs_again_as_it_is_let_go() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for rate in [30, 60, 240] {
            let dt = 1.0 / rate as f32;
            let what = format!("{solver:?}, {rate} Hz");
            let (mut world, bodies, joints) = chain(solver);
            for _ in 0..rate / 2 {
                world.step(dt).unwrap();
            }
            for (&body, number) in bodies.iter().zip(0..) {
                let kind = if number % 3 == 0 { BodyKind::Static } else { BodyKind::Kinematic };
                world.set_body_kind(body, kind).unwrap_or_else(|error| panic!("{what}: {error}"));
            }
            let places: Vec<Pose> = bodies.iter().map(|&body| world.pose(body).unwrap()).collect();
            for step in 0..rate {
                // Apart, and back to where they were.
                let way = (TAU * (step + 1) as f32 / rate as f32).sin();
                for (number, (&body, place)) in bodies.iter().zip(&places).enumerate() {
                    if world.body_kind(body).unwrap() == BodyKind::Kinematic {
                        let apart = (Vec3::X * way * number as f32).as_dvec3();
                        world.move_to(body, Pose { position: place.position + apart, ..*place }).unwrap();
                    }
                }
                world.step(dt).unwrap();
                assert_eq!((world.report().counts.joints, world.broken().len()), (0, 0), "{what}: rows or breaks of idle joints");
                assert_eq!(world.overloaded().len(), 0, "{what}: an idle joint is overloaded");
                for &joint in &joints {
                    let state = world.joint_state(joint).unwrap();
                    assert_eq!((state.force, state.torque), (Vec3::ZERO, Vec3::ZERO), "{what}: an idle joint bears a load");
                    assert_eq!(world.joint_stress(joint).unwrap().share, 0.0, "{what}: an idle joint has a share");
                }
            }
            let mut saved = Vec::new();
            world.save(&mut saved);
            world.restore(&saved).unwrap();
            for &body in bodies.iter().rev() {
                world.set_body_kind(body, BodyKind::Dynamic).unwrap();
                world.step(dt).unwrap();
            }
            for _ in 0..3 * rate {
                world.step(dt).unwrap();
            }
            let counts = world.report().counts;
            assert!(counts.joints > 0 || counts.bodies_awake == 0, "{what}: no rows");
            let (borne, gap) = (load(&world, &joints), world.report().residuals.joint_gap);
            assert!((borne / 98.1 - 1.0).abs() < 0.15, "{what}: the chain hangs with {borne} N, and weighs 98.1 N");
            assert!(gap < 2.0e-3, "{what}: it has opened by {gap} m");
        }
    }
}

#[test]
fn a_joint_may_be_made_idle_and_counts_the_turns_that_an_animation_makes() {
    for rate in [30, 60, 240] {
        let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
        let shape = || ShapeDef::new(Shape::cuboid(Vec3::new(0.5, 0.1, 0.1)).unwrap());
        let mut body = |x: f64| {
            let def = BodyDef { kind: BodyKind::Kinematic, ..BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)) };
            world.create_body(&def.with_shape(shape())).unwrap()
        };
        let (hub, wheel) = (body(0.0), body(0.0));
        let joint = world.create_joint(&JointDef::new(JointKind::HINGE, hub, wheel)).unwrap();
        for step in 1..=rate {
            let rotation = Quat::from_rotation_x(3.25 * TAU * step as f32 / rate as f32);
            world.move_to(wheel, Pose { rotation, ..Pose::IDENTITY }).unwrap();
            world.step(1.0 / rate as f32).unwrap();
        }
        let angle = world.joint_state(joint).unwrap().position;
        assert!((angle - 3.25 * TAU).abs() < 1.0e-3, "{rate} Hz: after 3¼ turns the hinge tells {angle} rad");
        for body in [wheel, hub] {
            world.set_body_kind(body, BodyKind::Dynamic).unwrap();
        }
        for _ in 0..rate {
            world.step(1.0 / rate as f32).unwrap();
        }
        let spins = [hub, wheel].map(|body| world.angular_velocity(body).unwrap().x);
        let angle = world.joint_state(joint).unwrap().position;
        assert!((spins[1] - 3.25 * TAU).abs() < 0.5 && spins[0].abs() < 0.5, "{rate} Hz: they go on at {spins:?} rad/s");
        assert!((angle - 6.5 * TAU).abs() < 0.5, "{rate} Hz: a second later it tells {angle} rad");
    }
}
