//! What is told of bodies that fixed joints make one: the forces on each, and what each joint bears.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, Geometry, JointDef, JointId, JointKind, Limits, Mass, Material, Motor, Pose, Shape, ShapeDef,
    Softness, Solver, Strength, World, WorldDef,
};

const RATES: [f32; 3] = [30.0, 60.0, 240.0];

fn body(world: &mut World, mass: f32, at: DVec3, geometry: Geometry, restitution: f32) -> BodyId {
    let mut shape = ShapeDef::new(Shape::new(geometry).unwrap());
    shape.material = Material { restitution, ..Material::default() };
    world.create_body(&BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(Pose::at(at)) }.with_shape(shape)).unwrap()
}

fn slab() -> Geometry {
    Geometry::Box { half_extents: Vec3::new(1.0, 0.1, 1.0) }
}

/// A slab of 50 kg at the origin that a fixed joint holds to the world or to a body of this kind.
fn held_slab(world: &mut World, kind: Option<BodyKind>) -> (BodyId, JointId) {
    let plate = body(world, 50.0, DVec3::ZERO, slab(), 0.0);
    let mut def = JointDef::new(JointKind::Fixed, BodyId::NULL, plate);
    if let Some(kind) = kind {
        let beside = BodyDef { kind, ..BodyDef::fixed(Pose::at(DVec3::X * 3.0)) };
        def.body_a = world.create_body(&beside.with_shape(ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).unwrap()))).unwrap();
        def.frame_a = Pose::at(DVec3::X * -3.0);
    }
    (plate, world.create_joint(&def).unwrap())
}

/// Nothing took the force of the step before from what is held to something static: it grew by the load in every step, and stayed as it was
/// when what lay there fell asleep.
#[test]
fn the_force_on_what_is_welded_to_something_static_is_that_of_its_contacts_now() {
    for rate in RATES {
        for kind in [None, Some(BodyKind::Static), Some(BodyKind::Kinematic)] {
            let mut world = World::new(&WorldDef::default()).unwrap();
            let (plate, joint) = held_slab(&mut world, kind);
            let cube = Geometry::Box { half_extents: Vec3::splat(0.2) };
            let boxes = [-0.5, 0.5].map(|x| body(&mut world, 20.0, DVec3::new(x, 0.3, 0.0), cube.clone(), 0.0));
            let weight = 20.0 * 9.81;
            let what = format!("{kind:?} at {rate} Hz");
            for step in 0..(2.0 * rate) as usize {
                world.step(1.0 / rate).unwrap();
                let force = world.contact_force(plate).unwrap();
                assert!((force.y + 2.0 * weight).abs() < 0.01 * weight, "{what}: {force} N in step {step}, of {}", 2.0 * weight);
            }
            assert!(!world.is_awake(boxes[0]).unwrap(), "{what}: it does not sleep");
            // One is woken, the other sleeps on.
            world.set_linear_velocity(boxes[0], Vec3::X * 0.1).unwrap();
            world.step(1.0 / rate).unwrap();
            assert!(!world.is_awake(boxes[1]).unwrap());
            let force = world.contact_force(plate).unwrap();
            assert!((force.y + 2.0 * weight).abs() < 0.05 * weight, "{what}: {force} N as one has been woken");
            // Until the next step it is what it was, though nothing holds the plate any more.
            world.destroy_joint(joint).unwrap();
            let after = world.contact_force(plate).unwrap();
            assert!((after - force).length() < 0.01 * weight, "{what}: {after} N as the joint has gone, {force} N before");
        }
    }
}

#[test]
fn a_bounce_on_what_is_welded_leaves_no_force_behind() {
    for rate in RATES {
        for kind in [None, Some(BodyKind::Static), Some(BodyKind::Kinematic)] {
            let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
            let (plate, _) = held_slab(&mut world, kind);
            let ball = body(&mut world, 20.0, DVec3::Y * 0.4, Geometry::Ball { radius: 0.1 }, 1.0);
            world.set_linear_velocity(ball, Vec3::NEG_Y * 2.0).unwrap();
            for _ in 0..(0.5 * rate) as usize {
                world.step(1.0 / rate).unwrap();
            }
            assert!(world.linear_velocity(ball).unwrap().y > 1.99);
            assert_eq!(world.contact_force(plate).unwrap(), Vec3::ZERO, "{kind:?} at {rate} Hz");
        }
    }
}

/// Ways to load a weld that nothing else holds: a ball that hits what it holds to the world, and a pair that lands on its lower body.
const STRUCK: [&str; 3] = ["held to the world", "a free pair", "on a hinge"];

/// Impulse up that a weld gives in half a second in which what it holds is hit (N·s), and what it has to give: by its strength, and asked for in every
/// step.
fn weld_impulse(how: &str, strength: f32, restitution: f32, rate: f32) -> [f32; 2] {
    let gravity = if how == "on a hinge" { 0.0 } else { 9.81 };
    let mut world = World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, ..WorldDef::default() }).unwrap();
    let floor = body(&mut world, 1.0, DVec3::Y * -9.5, slab(), 0.0);
    world.set_body_kind(floor, BodyKind::Static).unwrap();
    let mut def = JointDef::new(JointKind::Fixed, BodyId::NULL, BodyId::NULL);
    let ball = Geometry::Ball { radius: 0.1 };
    // Bodies whose momentum the weld changes.
    let beyond = match how {
        "held to the world" => {
            def.body_b = body(&mut world, 100.0, DVec3::ZERO, slab(), restitution);
            vec![(def.body_b, 100.0), (body(&mut world, 20.0, DVec3::Y * 0.7, ball, restitution), 20.0)]
        }
        "a free pair" => {
            let cube = Geometry::Box { half_extents: Vec3::splat(0.4) };
            def.body_a = body(&mut world, 3.0, DVec3::Y * -8.4, cube.clone(), restitution);
            def.body_b = body(&mut world, 2.0, DVec3::Y * -7.4, cube, restitution);
            (def.frame_a, def.frame_b) = (Pose::at(DVec3::Y * 0.5), Pose::at(DVec3::Y * -0.5));
            vec![(def.body_b, 2.0)]
        }
        _ => {
            def.body_a = body(&mut world, 10.0, DVec3::X * 1.0, slab(), restitution);
            def.body_b = body(&mut world, 10.0, DVec3::X * 3.0, slab(), restitution);
            (def.frame_a, def.frame_b) = (Pose::at(DVec3::X), Pose::at(DVec3::X * -1.0));
            let hinge = JointDef::new(JointKind::HINGE, BodyId::NULL, def.body_a);
            let turned = |x: f64| Pose::at(DVec3::X * x).rotated(Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2));
            world.create_joint(&JointDef { frame_a: turned(0.0), frame_b: turned(-1.0), ..hinge }).unwrap();
            vec![(def.body_b, 10.0), (body(&mut world, 4.0, DVec3::new(2.2, 0.7, 0.0), ball, restitution), 4.0)]
        }
    };
    (def.strength.tension, def.strength.compression, def.strength.shear) = (strength, strength, strength);
    let weld = world.create_joint(&def).unwrap();
    let thrown = beyond.last().unwrap().0;
    if how != "a free pair" {
        world.set_linear_velocity(thrown, Vec3::NEG_Y * 4.0).unwrap();
    }
    let momentum = |world: &World| beyond.iter().map(|&(body, mass)| mass * world.linear_velocity(body).unwrap().y).sum::<f32>();
    let (before, count) = (momentum(&world), (0.5 * rate) as usize);
    let mut given = 0.0;
    for _ in 0..count {
        world.step(1.0 / rate).unwrap();
        given += world.joint_state(weld).unwrap().force.y / rate;
    }
    let mass: f32 = beyond.iter().map(|&(_, mass)| mass).sum();
    [given, momentum(&world) - before + mass * gravity * count as f32 / rate]
}

/// A joint without a strength was told what contacts did in the last substep: of most hits nothing. And where the island was solved as one, joints with
/// one were told no blow that came back.
#[test]
fn a_weld_tells_what_it_bears_of_hits_whether_it_can_break_or_not() {
    for how in STRUCK {
        for (rate, restitution) in RATES.into_iter().flat_map(|rate| [0.0, 0.3, 1.0].map(|restitution| (rate, restitution))) {
            for strength in [f32::INFINITY, 1.0e9] {
                let [told, expected] = weld_impulse(how, strength, restitution, rate);
                let what = format!("{how}, e {restitution}, {rate} Hz, strength {strength}");
                assert!(expected > 2.0, "{what}: {expected} N·s are no hit");
                // Where it swings, its force turns by as much as it does in a step.
                assert!((told / expected - 1.0).abs() < 0.02, "{what}: {told} N·s, of {expected}");
            }
        }
    }
}

/// What the host does to a body is told as well. Impulses and velocities were taken and lost where no joint had a limit.
#[test]
fn a_weld_tells_what_the_host_does_to_what_it_holds() {
    for kind in [None, Some(BodyKind::Static), Some(BodyKind::Kinematic)] {
        for strength in [f32::INFINITY, 1.0e9] {
            for way in ["an impulse", "a velocity", "a force", "two impulses"] {
                let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
                let (plate, weld) = held_slab(&mut world, kind);
                let limits = Strength { tension: strength, ..world.joint_def(weld).unwrap().strength };
                world.set_joint_strength(weld, limits).unwrap();
                world.step(1.0 / 60.0).unwrap();
                match way {
                    "an impulse" => world.add_impulse(plate, Vec3::Y * 30.0).unwrap(),
                    "a velocity" => world.set_linear_velocity(plate, Vec3::Y * 0.6).unwrap(),
                    "a force" => world.add_force(plate, Vec3::Y * 1800.0).unwrap(),
                    _ => [10.0, 20.0].into_iter().for_each(|impulse| world.add_impulse(plate, Vec3::Y * impulse).unwrap()),
                }
                let mut told = 0.0;
                for _ in 0..3 {
                    world.step(1.0 / 60.0).unwrap();
                    told += world.joint_state(weld).unwrap().force.y / 60.0;
                }
                let what = format!("{way} on what {kind:?} holds, strength {strength}");
                assert!((told + 30.0).abs() < 0.01, "{what}: {told} N·s told of -30");
                assert_eq!(world.linear_velocity(plate).unwrap(), Vec3::ZERO, "{what}");
            }
        }
    }
}

/// Nobody has asked before: the load of the step of the hit is as good as that of any other.
#[test]
fn a_weld_tells_the_whole_of_a_hit_when_it_is_asked_for_the_first_time() {
    for (rate, restitution) in RATES.into_iter().flat_map(|rate| [0.0, 0.3, 1.0].map(|restitution| (rate, restitution))) {
        let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
        let (_, weld) = held_slab(&mut world, None);
        let ball = body(&mut world, 20.0, DVec3::Y * 0.4, Geometry::Ball { radius: 0.1 }, restitution);
        world.set_linear_velocity(ball, Vec3::NEG_Y * 4.0).unwrap();
        let speed = |world: &World| world.linear_velocity(ball).unwrap().y;
        let mut given = 0.0;
        while given < 1.0 {
            let before = speed(&world);
            world.step(1.0 / rate).unwrap();
            given = 20.0 * (speed(&world) - before);
        }
        let told = world.joint_state(weld).unwrap().force.y / rate;
        assert!((told / given - 1.0).abs() < 1.0e-3, "e {restitution}, {rate} Hz: {told} N·s told of {given}");
    }
}

/// Springs and motors between what cannot move did nothing, and latches that held them bore nothing.
#[test]
fn a_latch_bears_what_a_spring_or_a_motor_beside_it_pushes_with() {
    let softness = Softness { compliance: 1.0e-3, ..Softness::RIGID };
    let spring = Motor::Position { target: 1.0, softness, max_force: f32::INFINITY };
    let bounded = Motor::Velocity { target: 0.5, max_force: 1000.0 };
    let kinds = [
        ("a hinge spring", JointKind::Hinge { limits: Limits::NONE, motor: spring }),
        ("a slider spring", JointKind::Prismatic { limits: Limits::NONE, motor: spring }),
        ("a line spring", JointKind::Distance { limits: Limits::NONE, spring_length: Some(1.0), motor: Motor::Off }),
        ("a hinge motor", JointKind::Hinge { limits: Limits::NONE, motor: bounded }),
        ("a slider motor", JointKind::Prismatic { limits: Limits::NONE, motor: bounded }),
    ];
    for (solver, (name, kind)) in
        [Solver::Auto, Solver::GaussSeidel].into_iter().flat_map(|solver| kinds.map(|kind| (solver, kind)))
    {
        for (to_world, strength) in
            [(true, f32::INFINITY), (false, f32::INFINITY), (true, 2000.0), (false, 2000.0), (true, 500.0), (false, 500.0)]
        {
            let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, solver, ..WorldDef::default() }).unwrap();
            let cube = Geometry::Box { half_extents: Vec3::splat(0.1) };
            let arm = body(&mut world, 2.0, DVec3::ZERO, cube.clone(), 0.0);
            let other = if to_world { BodyId::NULL } else { body(&mut world, 3.0, DVec3::X, cube, 0.0) };
            let mut pusher = JointDef::new(kind, other, arm);
            let across = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
            let from = DVec3::X * if to_world { 0.0 } else { -1.0 };
            (pusher.frame_a, pusher.frame_b) = (Pose::at(from).rotated(across), Pose::at(DVec3::ZERO).rotated(across));
            if matches!(kind, JointKind::Distance { .. }) {
                (pusher.frame_a.position, pusher.linear) = (from + DVec3::Y * 2.0, softness);
            }
            let pusher = world.create_joint(&pusher).unwrap();
            let mut latch = JointDef::new(JointKind::Fixed, other, arm).at(from.as_vec3(), Vec3::ZERO);
            let limits = &mut latch.strength;
            for limit in
                [&mut limits.tension, &mut limits.compression, &mut limits.shear, &mut limits.bending, &mut limits.torsion]
            {
                *limit = strength;
            }
            let latch = world.create_joint(&latch).unwrap();
            let mut broken = 0;
            for _ in 0..5 {
                world.step(1.0 / 60.0).unwrap();
                broken += world.broken().len();
            }
            let what = format!("{solver:?}, {name}, to the world {to_world}, strength {strength}");
            assert_eq!(broken > 0, strength < 1000.0, "{what}: {broken} latches break");
            if broken == 0 {
                let turns = matches!(kind, JointKind::Hinge { .. });
                let load = |joint| {
                    let state = world.joint_state(joint).unwrap();
                    if turns { state.torque } else { state.force }
                };
                let (effort, borne) = (world.joint_state(pusher).unwrap().effort.abs(), load(latch));
                assert!((effort - 1000.0).abs() < 0.1, "{what}: pushes with {effort}");
                assert!((borne + load(pusher)).length() < 0.1, "{what}: bears {borne} of {}", load(pusher));
            }
        }
    }
}

/// What a latch bears is no rounding of where the bodies stand.
#[test]
fn a_stiff_spring_at_rest_loads_no_latch() {
    for (size, compliance) in [(0.01, 1.0e-7), (1.0, 1.0e-9), (100.0, 1.0e-9)] {
        let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
        let cube = Geometry::Box { half_extents: Vec3::splat(0.1 * size as f32) };
        let at = |x: f64| DVec3::new(0.37, 0.11, -0.73) * size + DVec3::new(0.6, 0.48, 0.64).normalize() * (x * size);
        let [a, b] = [0.0, 1.0].map(|x| body(&mut world, 1.0, at(x), cube.clone(), 0.0));
        let way = (at(1.0) - at(0.0)).as_vec3();
        let mut spring = JointDef::new(
            JointKind::Distance { limits: Limits::NONE, spring_length: Some(size as f32), motor: Motor::Off },
            a,
            b,
        );
        spring.linear = Softness { compliance, ..Softness::RIGID };
        let spring = world.create_joint(&spring).unwrap();
        let latch = world.create_joint(&JointDef::new(JointKind::Fixed, a, b).at(way * 0.5, way * -0.5)).unwrap();
        world.set_angular_velocity(a, Vec3::new(1.0, 2.0, 3.0)).unwrap();
        for step in 0..60 {
            world.step(1.0 / 60.0).unwrap();
            let pushes = world.joint_state(spring).unwrap().force.length();
            assert!(pushes == 0.0, "{size} m: {pushes} N in step {step}, latch {:?}", world.joint_state(latch).unwrap().force);
        }
    }
}
