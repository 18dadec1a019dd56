//! What hangs at a rope from something that moves stays at its rope's length, by sweeps with long-range bounds as by the direct solver.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, Softness, Solver,
    World, WorldDef,
};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Crane {
    /// A jib of 8 m and 2 t that a hinge's motor slews.
    Jib,
    /// The same with a stay of 9 m and 20 kg from its tip to the mast.
    Stayed,
    /// A trolley of 200 kg that a slider's motor drives.
    Trolley,
    /// A kinematic body.
    Hand,
    /// Nothing: a body of 2 t falls with its rope and its load.
    Nothing,
    /// The jib with a stay so small that its ends are 45 of its sizes away, which sweeps tear.
    Torn,
}

const CRANES: [Crane; 5] = [Crane::Jib, Crane::Stayed, Crane::Trolley, Crane::Hand, Crane::Nothing];
const PITCH: f64 = 0.2;

fn solid(world: &mut World, at: DVec3, half: Vec3, mass: f32) -> BodyId {
    let mut shape = ShapeDef::new(Shape::cuboid(half).expect("a valid shape"));
    shape.filter.collides_with = 0;
    let def = BodyDef::dynamic(Pose::at(at)).with_shape(shape).with_mass(Mass::Total(mass));
    world.create_body(&def).expect("a valid body")
}

fn join(world: &mut World, kind: JointKind, [a, b]: [BodyId; 2], at: DVec3, frame: Quat) -> JointId {
    let mut def = JointDef::new(kind, a, b);
    let place = |world: &World, body: BodyId| {
        let from = if body == BodyId::NULL { DVec3::ZERO } else { world.pose(body).expect("it exists").position };
        Pose::at(at - from).rotated(frame)
    };
    (def.frame_a, def.frame_b) = (place(world, a), place(world, b));
    world.create_joint(&def).expect("a valid joint")
}

/// What a rope hangs at, at the origin.
fn holder(world: &mut World, crane: Crane) -> BodyId {
    let up = Quat::from_rotation_arc(Vec3::X, Vec3::Y);
    let motor = |target: f32| Motor::Velocity { target, max_force: f32::INFINITY };
    match crane {
        Crane::Jib | Crane::Stayed | Crane::Torn => {
            let jib = solid(world, DVec3::NEG_X * 4.0, Vec3::new(4.0, 0.2, 0.2), 2000.0);
            let slew = JointKind::Hinge { limits: Limits::NONE, motor: motor(0.2) };
            join(world, slew, [BodyId::NULL, jib], DVec3::NEG_X * 8.0, up);
            if crane != Crane::Jib {
                let half = if crane == Crane::Stayed { Vec3::new(4.0, 2.0, 0.05) } else { Vec3::splat(0.1) };
                let stay = solid(world, DVec3::new(-4.0, 2.0, 0.0), half, 20.0);
                join(world, JointKind::SPHERICAL, [BodyId::NULL, stay], DVec3::new(-8.0, 4.0, 0.0), up);
                join(world, JointKind::SPHERICAL, [stay, jib], DVec3::ZERO, up);
            }
            jib
        }
        Crane::Trolley => {
            let trolley = solid(world, DVec3::ZERO, Vec3::splat(0.3), 200.0);
            let rail = JointKind::Prismatic { limits: Limits::NONE, motor: motor(1.0) };
            join(world, rail, [BodyId::NULL, trolley], DVec3::ZERO, Quat::IDENTITY);
            trolley
        }
        Crane::Hand => {
            let mut def = BodyDef::kinematic(Pose::IDENTITY);
            def.linear_velocity = Vec3::X;
            world.create_body(&def).expect("a valid body")
        }
        Crane::Nothing => solid(world, DVec3::ZERO, Vec3::splat(0.3), 2000.0),
    }
}

/// By how much a rope of `links` links of 1 kg is longer than when it was made, at most, over 4 s: a share of its length.
fn stretch(crane: Crane, solver: Solver, rate: f32, links: usize, load: f32) -> f64 {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let mut world = World::new(&WorldDef { solver, sleep, ..WorldDef::default() }).expect("a valid world");
    let top = holder(&mut world, crane);
    let mut held = top;
    for link in 0..links {
        let at = DVec3::NEG_Y * PITCH * link as f64;
        let next = solid(&mut world, at - DVec3::Y * (0.5 * PITCH), Vec3::new(0.02, 0.1, 0.02), 1.0);
        join(&mut world, JointKind::SPHERICAL, [held, next], at, Quat::IDENTITY);
        held = next;
    }
    let length = PITCH * links as f64;
    let load = solid(&mut world, DVec3::NEG_Y * (length + 0.5), Vec3::splat(0.5), load);
    join(&mut world, JointKind::SPHERICAL, [held, load], DVec3::NEG_Y * length, Quat::IDENTITY);
    let from = if matches!(crane, Crane::Jib | Crane::Stayed | Crane::Torn) { DVec3::X * 4.0 } else { DVec3::ZERO };
    let point = |world: &World, body: BodyId, local: DVec3| {
        let pose = world.pose(body).expect("it stays");
        pose.position + pose.rotation.as_dquat() * local
    };
    let mut worst = 0.0_f64;
    for _ in 0..(4.0 * rate) as u32 {
        world.step(1.0 / rate).expect("a valid step");
        assert!(world.quarantined().is_empty(), "{crane:?} at {rate}/s: {} bodies quarantined", world.quarantined().len());
        let distance = point(&world, load, DVec3::Y * 0.5).distance(point(&world, top, from));
        worst = worst.max(distance / length - 1.0);
    }
    worst
}

#[test]
fn a_load_stays_at_its_ropes_length() {
    // Rate (1/s), links, load (kg), and the share of the length that sweeps may leave, most where a load is 100 times what carries it; the
    // direct solver keeps it to a millimetre.
    let cases = [
        (30.0, 20, 5e3, 0.01),
        (60.0, 20, 5e3, 0.003),
        (120.0, 20, 5e3, 0.001),
        (240.0, 20, 5e3, 5e-4),
        (60.0, 5, 20e3, 0.05),
        (60.0, 3, 5e3, 0.03),
        (60.0, 1, 5e3, 0.2),
        (60.0, 60, 1e3, 5e-4),
        (60.0, 20, 100.0, 5e-4),
        (30.0, 5, 1e3, 0.006),
    ];
    for (crane, (rate, links, load, swept)) in CRANES.into_iter().flat_map(|crane| cases.map(|case| (crane, case))) {
        for (solver, bound) in [(Solver::Auto, 1e-3 / (PITCH * links as f64)), (Solver::GaussSeidel, swept)] {
            let stretch = stretch(crane, solver, rate, links, load);
            let what = format!("{crane:?} by {solver:?} at {rate}/s, {links} links, {load} kg");
            assert!(stretch < bound, "{what}: the rope is {stretch} of its length longer, bound {bound}");
        }
    }
}

#[test]
fn nothing_is_lost_where_sweeps_do_not_hold_a_crane() {
    for (rate, load) in [30.0, 60.0, 120.0].into_iter().flat_map(|rate| [100.0, 5e3, 20e3].map(|load| (rate, load))) {
        let stretch = stretch(Crane::Torn, Solver::GaussSeidel, rate, 20, load);
        assert!(stretch.is_finite(), "a load of {load} kg at {rate}/s is no number of metres away");
    }
}

/// A boom of 2 m and 20 kg on a base of 2 t that stands on the floor, raised by a servo: a cylinder of two parts between both, or the boom's
/// own hinge, with a fore-arm locked to it. All times `size`; the servo has so many times the force that the boom asks for.
fn derrick(by_cylinder: bool, times: f32, size: f32) -> (World, JointId) {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let mut world = World::new(&WorldDef { sleep, gravity: Vec3::NEG_Y * 9.81, ..WorldDef::default() }).expect("a valid world");
    let heavy = size * size * size;
    let cuboid = |half: Vec3| ShapeDef::new(Shape::cuboid(half * size).expect("a valid shape"));
    let at = |place: Vec3| Pose::at((place * size).as_dvec3());
    let floor = BodyDef::fixed(at(Vec3::NEG_Y * 2.6)).with_shape(cuboid(Vec3::new(50.0, 1.0, 50.0)));
    world.create_body(&floor).expect("a valid body");
    let base = BodyDef::dynamic(at(Vec3::new(-0.2, -1.1, 0.0))).with_shape(cuboid(Vec3::new(0.6, 0.5, 0.6)));
    let base = world.create_body(&base.with_mass(Mass::Total(2000.0 * heavy))).expect("a valid body");
    let mut part = |place: Vec3, turn: f32, half: Vec3, mass: f32| {
        let mut shape = cuboid(half);
        shape.filter.collides_with = 0;
        let pose = at(place).rotated(Quat::from_rotation_z(turn));
        world.create_body(&BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(mass * heavy))).expect("a valid body")
    };
    let boom = part(Vec3::X, 0.0, Vec3::new(1.0, 0.08, 0.08), 20.0);
    let (foot, eye) = (Vec3::NEG_Y, Vec3::X * 0.8);
    let (along, slope) = (eye - foot, (1.0_f32).atan2(0.8));
    let half = Vec3::new(0.25 * along.length(), 0.04, 0.04);
    let others = match by_cylinder {
        true => [(0.25, 2.0), (0.75, 1.0)].map(|(share, mass)| part(foot + along * share, slope, half, mass)),
        false => [part(Vec3::X * 2.5, 0.0, Vec3::new(0.5, 0.05, 0.05), 5.0); 2],
    };
    let mut hold = |kind: JointKind, a: BodyId, b: BodyId, place: Vec3, turn: Quat| {
        let seen_by = |body: BodyId| {
            let pose = world.pose(body).expect("it is there");
            let local = pose.inverse_transform_point((place * size).as_dvec3());
            Pose::at(local.as_dvec3()).rotated(pose.rotation.conjugate() * turn)
        };
        let def = JointDef { frame_a: seen_by(a), frame_b: seen_by(b), ..JointDef::new(kind, a, b) };
        world.create_joint(&def).expect("a valid joint")
    };
    let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let servo = |target: f32, force: f32| Motor::Position { target, softness: Softness::RIGID, max_force: force * heavy * times };
    if by_cylinder {
        hold(JointKind::HINGE, base, boom, Vec3::ZERO, about_z);
        hold(JointKind::HINGE, base, others[0], foot, about_z);
        hold(JointKind::HINGE, boom, others[1], eye, about_z);
        // The boom's weight over the lever at which the cylinder raises it.
        let motor = servo(0.25 * size, 20.0 * 9.81 / (0.8 * slope.sin()));
        let kind = JointKind::Prismatic { limits: Limits::NONE, motor };
        let servo = hold(kind, others[0], others[1], 0.5 * (foot + eye), Quat::from_rotation_z(slope));
        return (world, servo);
    }
    let motor = servo(0.25, (20.0 + 5.0 * 2.5) * 9.81 * size);
    let servo = hold(JointKind::Hinge { limits: Limits::NONE, motor }, base, boom, Vec3::ZERO, about_z);
    let locked = JointKind::Hinge { limits: Limits::new(0.0, 0.0), motor: Motor::Off };
    hold(locked, boom, others[0], Vec3::X * 2.0, about_z);
    (world, servo)
}

#[test]
fn a_servo_of_a_machine_that_stands_brakes_by_all_that_it_moves() {
    for (by_cylinder, rate) in [true, false].into_iter().flat_map(|kind| [30.0, 60.0, 240.0_f32].map(|rate| (kind, rate))) {
        for (times, size) in [1.5, 3.0, 10.0_f32].into_iter().flat_map(|times| [0.1, 1.0, 10.0_f32].map(|size| (times, size))) {
            let (mut world, servo) = derrick(by_cylinder, times, size);
            let target = if by_cylinder { 0.25 * size } else { 0.25 };
            let mut position = 0.0;
            let mut highest = 0.0_f32;
            for _ in 0..(2.0 * size.sqrt() * rate) as u32 + 3 {
                world.step(1.0 / rate).expect("a valid step");
                position = world.joint_axis_state(servo, 0).expect("the joint has this axis").position;
                highest = highest.max(position);
            }
            let what = format!("by cylinder: {by_cylinder}, {times} times the force, {size} m at {rate}/s");
            assert!(highest < 1.02 * target, "{what}: overshoots its {target} to {highest}");
            assert!((position / target - 1.0).abs() < 0.01, "{what}: ends at {position} of {target}");
        }
    }
}
