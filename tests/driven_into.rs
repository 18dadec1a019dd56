//! A motor pushes what it drives against what is in the way, however strong it is, and stalls there: nothing is driven through a wall.

use crate::common::motor_kinds::{KINDS, Kind};
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Drive, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, Solver,
    World, WorldDef,
};

const RATES: [f32; 3] = [30.0, 60.0, 240.0];

fn world(solver: Solver) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::ZERO, solver, sleep, ..WorldDef::default() }).expect("a valid world")
}

fn cuboid(half: Vec3, friction: f32) -> ShapeDef {
    let mut shape = ShapeDef::new(Shape::cuboid(half).expect("a valid shape"));
    shape.material.friction = friction;
    shape
}

fn body(world: &mut World, at: DVec3, half: f32, mass: f32) -> BodyId {
    let def = BodyDef::dynamic(Pose::at(at)).with_shape(cuboid(Vec3::splat(half), 0.5)).with_mass(Mass::Total(mass));
    world.create_body(&def).expect("a valid body")
}

fn wall(world: &mut World, y: f32, size: f32, friction: f32) {
    let at = Pose::at_xyz(0.0, f64::from(y * size), 0.0);
    world.create_body(&BodyDef::fixed(at).with_shape(cuboid(Vec3::new(3.0, 0.25, 3.0) * size, friction))).expect("a valid body");
}

/// Drives `b` against `a` up along y, or about z half its size beside it.
fn driven(world: &mut World, kind: Kind, [a, b]: [BodyId; 2], motor: Motor, size: f32) -> JointId {
    let begin = if kind == Kind::Distance { 0.5 * size } else { 0.0 };
    let (kind_of, frame) = kind.joint(motor, Limits::NONE);
    let lever = if kind.turns() { f64::from(-0.5 * size) } else { 0.0 };
    let mut def = JointDef::new(kind_of, a, b);
    (def.frame_a, def.frame_b) =
        (Pose::at_xyz(lever, f64::from(-begin), 0.0).rotated(frame), Pose::at_xyz(lever, 0.0, 0.0).rotated(frame));
    world.create_joint(&def).expect("a valid joint")
}

/// Motors that take what they drive a size and more, or 2 rad, in a step.
fn strong(kind: Kind, size: f32) -> [Motor; 4] {
    let to = if kind == Kind::Distance { 2.5 } else { 2.0 } * if kind.turns() { 1.0 } else { size };
    let speed = if kind.turns() { 20.0 } else { 20.0 * size };
    [
        Motor::Drive(Drive::to(to, f32::INFINITY)),
        Motor::Drive(Drive::to(to, 1.0e4 * size * size)),
        Motor::Velocity { target: speed, max_force: f32::INFINITY },
        Motor::Velocity { target: speed, max_force: 1.0e4 * size * size },
    ]
}

#[test]
fn a_strong_motor_drives_nothing_into_a_wall() {
    for (kind, rate) in KINDS.into_iter().flat_map(|kind| RATES.map(|rate| (kind, rate))) {
        for (size, motor) in [0.1, 1.0, 10.0].into_iter().flat_map(|size| strong(kind, size).map(|motor| (size, motor))) {
            check(Solver::Auto, kind, rate, size, motor);
            // Sweeps bear what has a bound.
            let is_bounded = match motor {
                Motor::Velocity { max_force, .. } => max_force < f32::INFINITY,
                Motor::Drive(drive) => drive.max_force < f32::INFINITY,
                _ => false,
            };
            if is_bounded {
                check(Solver::GaussSeidel, kind, rate, size, motor);
            }
        }
    }
}

/// Drives a body of 2 kg against a wall, and looks how far it goes and what is told as it stands.
fn check(solver: Solver, kind: Kind, rate: f32, size: f32, motor: Motor) {
    let mut world = world(solver);
    let box_ = body(&mut world, DVec3::ZERO, 0.2 * size, 2.0);
    let joint = driven(&mut world, kind, [BodyId::NULL, box_], motor, size);
    wall(&mut world, 0.55, size, 0.5);
    let (mut furthest, mut fastest) = (0.0_f64, 0.0_f32);
    for step in 0..rate as u32 {
        world.step(1.0 / rate).expect("a valid step");
        furthest = furthest.max(world.pose(box_).expect("it stays").position.y);
        if 2 * step > rate as u32 {
            fastest = fastest.max(world.joint_axis_state(joint, kind.axis()).expect("it has this axis").velocity.abs());
        }
    }
    let (way, what) = (furthest / f64::from(size), format!("{solver:?}, {kind:?} by {motor:?} at {rate}/s, {size} m"));
    // A tenth of its size is free; what turns gets there with a corner first.
    assert!(way < 0.11, "{what}: goes {way} of its size, bound 0.11");
    let least = if kind.turns() { 0.06 } else { 0.09 };
    assert!(way > least, "{what}: goes {way} of its size, and not to the wall");
    assert!(fastest < 0.01 * size.max(1.0), "{what}: tells {fastest} m/s and stands, bound 10 mm/s");
}

/// What is in the way may be carried on itself, into what is in its way.
#[test]
fn a_strong_lift_drives_its_load_through_no_ceiling() {
    for (rate, mass) in RATES.into_iter().flat_map(|rate| [0.2_f32, 2.0, 20.0].map(|mass| (rate, mass))) {
        for motor in strong(Kind::Slider, 1.0) {
            let mut world = world(Solver::Auto);
            let lift = body(&mut world, DVec3::ZERO, 0.2, 2.0);
            let load = body(&mut world, DVec3::Y * 0.6, 0.2, mass);
            driven(&mut world, Kind::Slider, [BodyId::NULL, lift], motor, 1.0);
            wall(&mut world, 1.35, 1.0, 0.5);
            let mut furthest = [0.0_f64; 2];
            for _ in 0..rate as u32 {
                world.step(1.0 / rate).expect("a valid step");
                let at = [lift, load].map(|body| world.pose(body).expect("it stays").position.y);
                furthest = std::array::from_fn(|i| furthest[i].max(at[i]));
            }
            let what = format!("{motor:?} under {mass} kg at {rate}/s");
            // A way that leads into something by a twentieth of 0.4 m is a touch, and as much again may be pressed in by the time that it is seen,
            // with what rounding makes of it.
            assert!(furthest[1] < 0.9401, "{what}: its load comes to {} m, bound 0.9401", furthest[1]);
            assert!(furthest[0] < 0.56, "{what}: comes to {} m, bound 0.56", furthest[0]);
        }
    }
}

/// Two motors without a bound, of which one meets a wall without friction: the other goes on as if there were none.
#[test]
fn a_motor_that_stalls_holds_no_other_up() {
    for (rate, is_servo) in RATES.into_iter().flat_map(|rate| [false, true].map(|is_servo| (rate, is_servo))) {
        let mut world = world(Solver::Auto);
        let carriage = body(&mut world, -DVec3::Y, 0.1, 5.0);
        let head = body(&mut world, DVec3::ZERO, 0.2, 2.0);
        let motor = |speed: f32| match is_servo {
            true => Motor::Drive(Drive { max_speed: speed, ..Drive::to(speed, f32::INFINITY) }),
            false => Motor::Velocity { target: speed, max_force: f32::INFINITY },
        };
        let slide = JointKind::Prismatic { limits: Limits::NONE, motor: motor(0.5) };
        let mut def = JointDef::new(slide, BodyId::NULL, carriage);
        def.frame_a = Pose::at_xyz(0.0, -1.0, 0.0);
        let along = world.create_joint(&def).expect("a valid joint");
        let up = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let mut def = JointDef::new(JointKind::Prismatic { limits: Limits::NONE, motor: motor(1.0) }, carriage, head);
        (def.frame_a, def.frame_b) = (Pose::at_xyz(0.0, 1.0, 0.0).rotated(up), Pose::IDENTITY.rotated(up));
        let across = world.create_joint(&def).expect("a valid joint");
        wall(&mut world, 0.75, 1.0, 0.0);
        (0..rate as u32).for_each(|_| _ = world.step(1.0 / rate).expect("a valid step"));
        let at = |joint: JointId| world.joint_axis_state(joint, 0).expect("it has this axis").position;
        let what = format!("at {rate}/s, servos: {is_servo}");
        assert!((at(along) - 0.5).abs() < 0.005, "{what}: the carriage is at {} m, should be at 0.5", at(along));
        assert!((at(across) - 0.3).abs() < 0.003, "{what}: the head is at {} m, should be at the wall at 0.3", at(across));
    }
}
