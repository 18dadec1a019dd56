//! What hangs at a rope from something that moves stays at its rope's length, by sweeps with long-range bounds as by the direct solver.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, Solver, World,
    WorldDef,
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
