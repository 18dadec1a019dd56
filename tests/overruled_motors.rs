//! Where something rigid overrules a motor, however strong it is, the velocities that are told are those that poses follow.

use crate::common::motor_kinds::{KINDS, Kind};
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Drive, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, Solver,
    World, WorldDef,
};

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];
const SPEED: f32 = 2.0;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Obstacle {
    Limit,
    Rope,
    Weld,
    Wall,
}

fn world(gravity: f32, solver: Solver) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, solver, sleep, ..WorldDef::default() }).expect("a valid world")
}

/// A box of this mass (kg) and these half extents (m), which collides with nothing where it is a ghost.
fn cuboid(world: &mut World, at: DVec3, half: Vec3, mass: f32, is_ghost: bool) -> BodyId {
    let mut shape = ShapeDef::new(Shape::cuboid(half).expect("a valid shape"));
    if is_ghost {
        shape.filter.collides_with = 0;
    }
    let def = BodyDef::dynamic(Pose::at(at)).with_shape(shape).with_mass(Mass::Total(mass));
    world.create_body(&def).expect("a valid body")
}

/// The joint that drives `body` up along y, by `motor`, at this scale (m).
fn driven(world: &mut World, kind: Kind, body: BodyId, motor: Motor, limits: Limits, size: f32) -> JointId {
    let begin = if kind == Kind::Distance { 0.5 * size } else { 0.0 };
    let limits = Limits::new(limits.min + begin, limits.max + begin);
    let (kind_of, frame) = kind.joint(motor, limits);
    let lever = if kind.turns() { f64::from(-0.5 * size) } else { 0.0 };
    let mut def = JointDef::new(kind_of, BodyId::NULL, body);
    (def.frame_a, def.frame_b) =
        (Pose::at_xyz(lever, f64::from(-begin), 0.0).rotated(frame), Pose::at_xyz(lever, 0.0, 0.0).rotated(frame));
    world.create_joint(&def).expect("a valid joint")
}

/// Puts something in the way of a body that a motor drives up from the origin, at this scale (m).
fn obstruct(world: &mut World, obstacle: Obstacle, kind: Kind, body: BodyId, size: f32) {
    match obstacle {
        Obstacle::Limit => {}
        Obstacle::Rope => {
            let end = if kind.turns() { Vec3::X * 0.5 * size } else { Vec3::ZERO };
            let reach = JointKind::Distance { limits: Limits::new(0.0, 1.1 * size), spring_length: None, motor: Motor::Off };
            let mut rope = JointDef::new(reach, BodyId::NULL, body);
            (rope.frame_a, rope.frame_b) = (Pose::at((end - Vec3::Y * size).as_dvec3()), Pose::at(end.as_dvec3()));
            world.create_joint(&rope).expect("a valid joint");
        }
        Obstacle::Weld => {
            world.create_joint(&JointDef::new(JointKind::Fixed, BodyId::NULL, body)).expect("a valid joint");
        }
        Obstacle::Wall => {
            let wall = ShapeDef::new(Shape::cuboid(Vec3::new(3.0, 0.5, 3.0) * size).expect("a valid shape"));
            let at = Pose::at_xyz(0.0, f64::from(0.8 * size), 0.0);
            world.create_body(&BodyDef::fixed(at).with_shape(wall)).expect("a valid body");
        }
    }
}

/// By how much velocities that are told of a body and its joint exceed those that poses follow, at most, in a second after one in which they came
/// to rest; and the greatest speed that the joint was told to have.
fn untrue(world: &mut World, body: BodyId, joint: JointId, axis: u32, rate: f32) -> (f32, f32) {
    let (mut worst, mut fastest) = (0.0_f32, 0.0_f32);
    let look = |world: &World| {
        let pose = world.pose(body).expect("it stays");
        (pose, world.joint_axis_state(joint, axis).expect("it has this axis"))
    };
    let excess = |told: Vec3, moved: Vec3| told.length() - moved.dot(told.normalize_or_zero());
    let mut before = look(world);
    for step in 0..(2.0 * rate) as u32 {
        world.step(1.0 / rate).expect("a valid step");
        let (pose, state) = look(world);
        if step as f32 >= rate {
            let linear = (pose.position - before.0.position).as_vec3() * rate;
            let angular = (pose.rotation * before.0.rotation.conjugate()).to_scaled_axis() * rate;
            worst = worst.max(excess(world.linear_velocity(body).expect("it stays"), linear));
            worst = worst.max(excess(world.angular_velocity(body).expect("it stays"), angular));
            let moved = (state.position - before.1.position) * rate;
            worst = worst.max(excess(Vec3::X * state.velocity, Vec3::X * moved));
            fastest = fastest.max(state.velocity.abs());
        }
        before = (pose, state);
    }
    (worst, fastest)
}

/// A motor, or a servo to where it never comes, of this force (N or N·m) as the only thing that moves a body of 2 kg.
fn check(solver: Solver, kind: Kind, obstacle: Obstacle, rate: f32, force: f32, size: f32, is_servo: bool) {
    let speed = if kind.turns() { SPEED / size } else { SPEED };
    let target = if kind == Kind::Distance { 2.5 } else { 2.0 };
    let motor = match is_servo {
        true => Motor::Drive(Drive { max_speed: speed, ..Drive::to(target * size, force) }),
        false => Motor::Velocity { target: speed, max_force: force },
    };
    let mut world = world(0.0, solver);
    let body = cuboid(&mut world, DVec3::ZERO, Vec3::splat(0.2) * size, 2.0, false);
    let most = match obstacle {
        Obstacle::Limit if kind.turns() => 0.1,
        Obstacle::Limit => 0.1 * size,
        _ => f32::INFINITY,
    };
    let joint = driven(&mut world, kind, body, motor, Limits::new(f32::NEG_INFINITY, most), size);
    obstruct(&mut world, obstacle, kind, body, size);
    let (worst, fastest) = untrue(&mut world, body, joint, kind.axis(), rate);
    let what = format!("{solver:?}, {kind:?} of {force} N against {obstacle:?} at {rate}/s, {size} m, servo: {is_servo}");
    // Of what is asked for: what a factor leaves between rows that contradict each other, and what sweeps leave of a rope that swings.
    let bound = speed * if solver == Solver::Auto { 2.5e-3 } else { 0.025 };
    assert!(worst < bound, "{what}: tells {worst} m/s that no pose follows, bound {bound}");
    assert!(fastest < bound, "{what}: tells {fastest} m/s and stands, bound {bound}");
}

#[test]
fn a_motor_that_something_rigid_stops_tells_no_speed() {
    for (kind, rate) in KINDS.into_iter().flat_map(|kind| RATES.map(|rate| (kind, rate))) {
        for obstacle in [Obstacle::Limit, Obstacle::Rope, Obstacle::Weld, Obstacle::Wall] {
            for force in [200.0, 1.0e4, f32::INFINITY] {
                check(Solver::Auto, kind, obstacle, rate, force, 1.0, false);
            }
            check(Solver::Auto, kind, obstacle, rate, f32::INFINITY, 1.0, true);
            check(Solver::Auto, kind, obstacle, rate, f32::INFINITY, 10.0, false);
            check(Solver::Auto, kind, obstacle, rate, f32::INFINITY, 0.1, false);
        }
        for obstacle in [Obstacle::Limit, Obstacle::Rope, Obstacle::Weld] {
            check(Solver::GaussSeidel, kind, obstacle, rate, 1.0e7, 1.0, true);
            check(Solver::GaussSeidel, kind, obstacle, rate, f32::INFINITY, 1.0, false);
            check(Solver::GaussSeidel, kind, obstacle, rate, f32::INFINITY, 10.0, false);
        }
    }
}

/// What it stands on goes along with the ceiling that it is pressed against, not with its motor.
#[test]
fn a_lift_that_presses_its_load_against_a_ceiling_tells_no_speed() {
    for (rate, mass) in RATES.into_iter().flat_map(|rate| [0.5_f32, 50.0, 5.0e3].map(|mass| (rate, mass))) {
        let mut world = world(9.81, Solver::Auto);
        let lift = cuboid(&mut world, DVec3::ZERO, Vec3::new(1.0, 0.1, 1.0), 50.0, false);
        let load = cuboid(&mut world, DVec3::Y * 0.4, Vec3::splat(0.3), mass, false);
        let motor = Motor::Velocity { target: SPEED, max_force: f32::INFINITY };
        let joint = driven(&mut world, Kind::Slider, lift, motor, Limits::NONE, 1.0);
        let ceiling = ShapeDef::new(Shape::cuboid(Vec3::new(2.0, 0.5, 2.0)).expect("a valid shape"));
        world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, 1.4, 0.0)).with_shape(ceiling)).expect("a valid body");
        let (worst, fastest) = untrue(&mut world, lift, joint, 0, rate);
        let speed = world.linear_velocity(load).expect("it stays").length();
        let what = format!("{mass} kg at {rate}/s");
        assert!(worst < 1.0e-3 && fastest < 1.0e-3, "{what}: the lift tells {fastest} m/s, {worst} of it untrue, bound 1 mm/s");
        assert!(speed < 1.0e-3, "{what}: the load tells {speed} m/s, bound 1 mm/s");
    }
}

/// Three bars that hinges join are rigid: a motor in one of the hinges has nothing to turn.
#[test]
fn a_motor_in_a_corner_of_a_triangle_tells_no_speed() {
    for (rate, force) in RATES.into_iter().flat_map(|rate| [1.0e3, 1.0e6, f32::INFINITY].map(|force| (rate, force))) {
        let mut world = world(0.0, Solver::Auto);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.75_f64.sqrt(), 0.0)];
        let bars: Vec<BodyId> =
            (0..3).map(|i| cuboid(&mut world, 0.5 * (corners[i] + corners[(i + 1) % 3]), Vec3::splat(0.1), 2.0, true)).collect();
        let mut hinge = |[a, b]: [BodyId; 2], at: DVec3, motor: Motor| {
            let turned = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
            let seen = |body: BodyId| match body == BodyId::NULL {
                true => Pose::at(at).rotated(turned),
                false => Pose::at(at - world.pose(body).expect("it stays").position).rotated(turned),
            };
            let kind = JointKind::Hinge { limits: Limits::NONE, motor };
            let def = JointDef { frame_a: seen(a), frame_b: seen(b), ..JointDef::new(kind, a, b) };
            world.create_joint(&def).expect("a valid joint")
        };
        let motor = Motor::Velocity { target: SPEED, max_force: force };
        hinge([BodyId::NULL, bars[0]], corners[0], Motor::Off);
        let joint = hinge([bars[2], bars[0]], corners[0], motor);
        hinge([bars[0], bars[1]], corners[1], Motor::Off);
        hinge([bars[1], bars[2]], corners[2], Motor::Off);
        let (worst, fastest) = untrue(&mut world, bars[1], joint, 0, rate);
        let what = format!("{force} N·m at {rate}/s");
        assert!(worst < 1.0e-3 && fastest < 1.0e-3, "{what}: tells {fastest} rad/s, {worst} of it untrue, bound 1e-3");
    }
}

/// Sweeps let a heavy load sink into its light lift, at the cost of the lift: what is told of that is how it rises.
#[test]
fn a_swept_lift_tells_the_speed_at_which_it_rises() {
    for (rate, kind) in RATES.into_iter().flat_map(|rate| [Kind::Slider, Kind::Slide].map(|kind| (rate, kind))) {
        for (mass, is_servo) in [(500.0, false), (5.0e3, true)] {
            let mut world = world(9.81, Solver::GaussSeidel);
            let lift = cuboid(&mut world, DVec3::ZERO, Vec3::new(1.0, 0.1, 1.0), 50.0, false);
            cuboid(&mut world, DVec3::Y * 0.4, Vec3::splat(0.3), mass, false);
            let motor = match is_servo {
                true => Motor::Drive(Drive { max_speed: 1.0, ..Drive::to(20.0, f32::INFINITY) }),
                false => Motor::Velocity { target: 1.0, max_force: f32::INFINITY },
            };
            let joint = driven(&mut world, kind, lift, motor, Limits::NONE, 1.0);
            let mut told = [0.0; 2];
            for _ in 0..(6.0 * rate) as u32 {
                world.step(1.0 / rate).expect("a valid step");
                told[0] += world.linear_velocity(lift).expect("it stays").y / rate;
                told[1] += world.joint_axis_state(joint, kind.axis()).expect("it has this axis").velocity / rate;
            }
            let rise = world.pose(lift).expect("it stays").position.y as f32;
            let what = format!("{kind:?} under {mass} kg at {rate}/s");
            for told in told {
                assert!((told / rise - 1.0).abs() < 2.0e-3, "{what}: rises by {rise} m and tells {told} m, bound 0.2 %");
            }
        }
    }
}
