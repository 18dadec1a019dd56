//! A joint that is made beyond its stops comes to the nearest of them, whatever moves it and whatever it lies on.

use std::f32::consts::PI;

use longspan::glam::{Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, Solver,
    SphericalMotor, World, WorldDef,
};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Hinge,
    Twist,
    Slider,
    Slide,
    Turn,
}

/// The position of the joint of a door of 20 kg at 0 (rad or m), of these limits, by time (s); on a floor, or free of gravity.
fn positions(kind: Kind, limits: Limits, motor: Motor, solver: Solver, rate: f32, on_floor: bool) -> Vec<f32> {
    let gravity = if on_floor { Vec3::NEG_Y * 9.81 } else { Vec3::ZERO };
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let mut world = World::new(&WorldDef { gravity, solver, sleep, ..WorldDef::default() }).expect("a valid world");
    let door = ShapeDef::new(Shape::cuboid(Vec3::new(0.5, 1.0, 0.05)).expect("a valid shape"));
    let floor = ShapeDef::new(Shape::cuboid(Vec3::new(50.0, 0.5, 50.0)).expect("a valid shape"));
    let lever = if matches!(kind, Kind::Slider | Kind::Slide) { 0.0 } else { 0.5 };
    let def = BodyDef::dynamic(Pose::at_xyz(lever, 0.0, 0.0)).with_shape(door).with_mass(Mass::Total(20.0));
    let door = world.create_body(&def).expect("a valid body");
    if on_floor {
        world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.5, 0.0)).with_shape(floor)).expect("a valid body");
    }
    let (free, held) = (Axis { limits, motor }, Axis::LOCKED);
    let up = Quat::from_rotation_arc(Vec3::X, Vec3::Y);
    let (kind_of, frame, axis) = match kind {
        Kind::Hinge => (JointKind::Hinge { limits, motor }, up, 0),
        Kind::Twist => {
            let motor = SphericalMotor::Off;
            (JointKind::Spherical { swing_limit: 3.1, twist_limits: limits, motor }, up, 0)
        }
        Kind::Slider => (JointKind::Prismatic { limits, motor }, Quat::IDENTITY, 0),
        Kind::Slide => (JointKind::Generic { linear: [free, held, held], angular: [held; 3] }, Quat::IDENTITY, 0),
        Kind::Turn => (JointKind::Generic { linear: [held; 3], angular: [held, free, held] }, Quat::IDENTITY, 4),
    };
    let mut def = JointDef::new(kind_of, BodyId::NULL, door);
    (def.frame_a, def.frame_b) = (Pose::IDENTITY.rotated(frame), Pose::at_xyz(-lever, 0.0, 0.0).rotated(frame));
    let joint = world.create_joint(&def).expect("a valid joint");
    let told = |world: &World| world.joint_axis_state(joint, axis).expect("it has this axis").position;
    let steps = (4.0 * rate) as usize;
    (0..steps)
        .map(|_| {
            world.step(1.0 / rate).expect("a valid step");
            told(&world)
        })
        .collect()
}

#[test]
fn what_is_made_beyond_its_stops_comes_to_the_nearest() {
    for (kind, rate) in [Kind::Hinge, Kind::Twist, Kind::Slider, Kind::Slide, Kind::Turn]
        .into_iter()
        .flat_map(|kind| [30.0, 60.0, 240.0].map(|rate| (kind, rate)))
    {
        for (limits, speed) in
            [(Limits::new(200.0, 270.0), 2.0), (Limits::new(-270.0, -200.0), 2.0), (Limits::new(20.0, 90.0), -2.0)]
        {
            for force in [0.0, 500.0, f32::INFINITY] {
                for (solver, on_floor) in [(Solver::Auto, false), (Solver::Auto, true), (Solver::GaussSeidel, false)] {
                    if kind == Kind::Twist && force > 0.0 {
                        continue;
                    }
                    let motor = if force > 0.0 { Motor::Velocity { target: speed, max_force: force } } else { Motor::Off };
                    let limits = Limits::new(limits.min * PI / 180.0, limits.max * PI / 180.0);
                    let positions = positions(kind, limits, motor, solver, rate, on_floor);
                    let what = format!("{kind:?} in {limits:?} by {solver:?} at {rate}/s, {force} N, floor: {on_floor}");
                    let within = |at: &f32| (limits.min - 0.01..=limits.max + 0.01).contains(at);
                    // Positions are mended at 3 rad/s or m/s at least: 3.5 of either are beyond the stops at most.
                    let reached = positions.iter().position(within).map_or(f32::INFINITY, |step| (step + 1) as f32 / rate);
                    assert!(reached < 2.5, "{what}: within its stops after {reached} s, bound 2.5 s");
                    let last = positions[positions.len() - 1];
                    assert!(within(&last), "{what}: ends at {last}");
                }
            }
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Line {
    Slider,
    Slide,
    Rope,
    Reach,
}

/// Distance (m) from its range of a crate of this half width (m) that friction holds on a floor, with as heavy a crate on it, by time (s) after it
/// has been put half a width and 0.3 m beyond the end of a joint in its middle.
fn ways_beyond(line: Line, half: f32, solver: Solver, rate: f32) -> Vec<f32> {
    let gravity = Vec3::NEG_Y * 9.81;
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let mut world = World::new(&WorldDef { gravity, solver, sleep, ..WorldDef::default() }).expect("a valid world");
    let floor = ShapeDef::new(Shape::cuboid(Vec3::new(100.0, 1.0, 100.0)).expect("a valid shape"));
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(floor)).expect("a valid body");
    let height = f64::from(half);
    let crates = [height, 3.0 * height].map(|height| {
        let shape = ShapeDef::new(Shape::cuboid(Vec3::splat(half)).expect("a valid shape"));
        world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, height, 0.0)).with_shape(shape)).expect("a valid body")
    });
    let limits = if line == Line::Reach { Limits::new(4.0 * half, 6.0 * half) } else { Limits::new(0.0, half) };
    let (free, held) = (Axis { limits, motor: Motor::Off }, Axis::LOCKED);
    let kind = match line {
        Line::Slider => JointKind::Prismatic { limits, motor: Motor::Off },
        Line::Slide => JointKind::Generic { linear: [free, held, held], angular: [held; 3] },
        Line::Rope | Line::Reach => JointKind::Distance { limits, spring_length: None, motor: Motor::Off },
    };
    let from = if line == Line::Reach { 5.0 * half } else { 0.5 * half };
    let mut def = JointDef::new(kind, BodyId::NULL, crates[0]);
    def.frame_a = Pose::at_xyz(-f64::from(from), height, 0.0);
    let joint = world.create_joint(&def).expect("a valid joint");
    let step = |world: &mut World| _ = world.step(1.0 / rate).expect("a valid step");
    (0..(0.2 * rate) as usize).for_each(|_| step(&mut world));
    let way = half + 0.3;
    for (level, body) in crates.into_iter().enumerate() {
        let way = if line == Line::Reach { -way } else { way };
        let at = Pose::at_xyz(f64::from(way), height * (1 + 2 * level) as f64, 0.0);
        world.set_pose(body, at).expect("a valid pose");
    }
    let position = |world: &World| world.joint_axis_state(joint, 0).expect("it has this axis").position;
    (0..(2.0 * rate) as usize)
        .map(|_| {
            step(&mut world);
            let at = position(&world);
            (limits.min - at).max(at - limits.max)
        })
        .collect()
}

#[test]
fn what_lies_on_a_floor_under_a_load_and_is_put_beyond_its_range_comes_back() {
    for (line, half) in [Line::Slider, Line::Slide, Line::Rope, Line::Reach]
        .into_iter()
        .flat_map(|line| [0.03, 0.3, 3.0].map(|half| (line, half)))
    {
        for (solver, rate) in [Solver::Auto, Solver::GaussSeidel].into_iter().flat_map(|s| [30.0, 60.0, 240.0].map(|r| (s, r))) {
            let ways = ways_beyond(line, half, solver, rate);
            let what = format!("{line:?} of a crate of {half} m by {solver:?} at {rate}/s");
            let back = ways.iter().position(|way| *way < 0.01 * half).map_or(f32::INFINITY, |step| (step + 1) as f32 / rate);
            // At 3 m/s at least, and a step and two.
            let bound = (half + 0.3) / 3.0 + 2.0 / rate;
            assert!(back < bound, "{what}: within its range after {back} s, bound {bound} s");
            let last = ways[ways.len() - 1];
            assert!(last < 0.01 * half, "{what}: ends {last} m beyond its range");
        }
    }
}
