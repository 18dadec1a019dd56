//! Sleep means rest: an island falls asleep once nothing in it is going anywhere, and as soon as that.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, BodyKind, Damage, JointDef, JointId, JointKind, Limits, Mass, MassProperties, Motor, Pose, Shape,
    ShapeDef, SleepSettings, Softness, Solver, SphericalMotor, Strength, World, WorldDef,
};

const RATES: [f32; 3] = [30.0, 60.0, 240.0];

fn cuboid(half: Vec3) -> ShapeDef {
    ShapeDef::new(Shape::cuboid(half).unwrap())
}

fn cube(half: f32) -> ShapeDef {
    cuboid(Vec3::splat(half))
}

fn run(world: &mut World, seconds: f32, dt: f32) {
    for _ in 0..(seconds / dt).round() as u32 {
        world.step(dt).unwrap();
    }
}

fn floor(world: &mut World) -> BodyId {
    let floor = cuboid(Vec3::new(20.0, 2.0, 20.0));
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -2.0, 0.0)).with_shape(floor)).unwrap()
}

/// A bar of 5 kg on a joint to the world, its axis upright, with this motor on its free coordinate.
fn driven(solver: Solver, kind: &str, motor: Motor) -> (World, BodyId, JointId) {
    let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).unwrap();
    let bar = BodyDef::dynamic(Pose::IDENTITY).with_shape(cuboid(Vec3::new(0.5, 0.2, 0.2))).with_mass(Mass::Total(5.0));
    let bar = world.create_body(&bar).unwrap();
    let (limits, locked) = (Limits::NONE, Axis::LOCKED);
    let drive = Axis { limits, motor };
    // The joint axis is x, in axes of the world: along gravity for what turns, across it for what slides.
    let (kind, slides) = match kind {
        "hinge" => (JointKind::Hinge { limits, motor }, false),
        "slider" => (JointKind::Prismatic { limits, motor }, true),
        "spherical" => {
            let motor = match motor {
                Motor::Off => SphericalMotor::Off,
                Motor::Velocity { target, max_force } => {
                    SphericalMotor::Velocity { target: Vec3::X * target, max_torque: max_force }
                }
                Motor::Position { target, softness, max_force } => {
                    SphericalMotor::Position { target: Quat::from_rotation_x(target), softness, max_torque: max_force }
                }
                Motor::Drive(_) => panic!("a spherical joint has no such motor"),
            };
            (JointKind::Spherical { swing_limit: std::f32::consts::PI, twist_limits: limits, motor }, false)
        }
        "six axes, turning" => (JointKind::Generic { linear: [locked; 3], angular: [drive, locked, locked] }, false),
        "six axes, sliding" => (JointKind::Generic { linear: [drive, locked, locked], angular: [locked; 3] }, true),
        other => panic!("no joint is {other}"),
    };
    let rotation = if slides { Quat::IDENTITY } else { Quat::from_rotation_z(std::f32::consts::FRAC_PI_2) };
    let frame = Pose { position: DVec3::ZERO, rotation };
    let joint =
        world.create_joint(&JointDef { frame_a: frame, frame_b: frame, ..JointDef::new(kind, BodyId::NULL, bar) }).unwrap();
    (world, bar, joint)
}

const DRIVEN: [&str; 5] = ["hinge", "slider", "spherical", "six axes, turning", "six axes, sliding"];

/// How far the bar has turned about the upright (rad) or slid along x (m).
fn coordinate(world: &World, bar: BodyId) -> f32 {
    let pose = world.pose(bar).unwrap();
    let turned = pose.rotation.to_scaled_axis();
    pose.position.x as f32 + turned.y
}

#[test]
fn a_velocity_motor_goes_on_however_slow_it_is() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for kind in DRIVEN {
            for (rate, target) in [(60.0, 1.0e-3), (60.0, -0.03), (30.0, 0.05), (240.0, 1.0e-3)] {
                let dt = 1.0 / rate;
                let (mut world, bar, _) = driven(solver, kind, Motor::Velocity { target, max_force: 1.0e5 });
                run(&mut world, 3.0, dt);
                let (reached, expected) = (coordinate(&world, bar), 3.0 * target);
                assert!(
                    (reached - expected).abs() < 0.01 * expected.abs(),
                    "{kind}, {target} per s, {rate} Hz, {solver:?}: at {reached} after 3 s, of {expected}"
                );
            }
        }
    }
}

#[test]
fn a_closer_arrives_whatever_its_time_constant() {
    for (rate, constant) in [(60.0, 0.3), (60.0, 1.0), (60.0, 3.0), (30.0, 1.0), (240.0, 1.0)] {
        for kind in DRIVEN {
            let dt = 1.0 / rate;
            let softness = Softness { compliance: 1.0 / 50.0, damping: 50.0 * constant };
            let (mut world, bar, _) = driven(Solver::Auto, kind, Motor::Position { target: 1.0, softness, max_force: 1.0e5 });
            run(&mut world, 12.0 * constant.max(1.0), dt);
            let left = 1.0 - coordinate(&world, bar);
            assert!(left.abs() < 2.0e-3, "{kind}, time constant {constant} s, {rate} Hz: {left} of 1 left after 12 of them");
            assert!(!world.is_awake(bar).unwrap(), "{kind}, time constant {constant} s, {rate} Hz: awake after 12 of them");
        }
    }
}

#[test]
fn a_rigid_position_motor_arrives_and_sleeps() {
    for rate in RATES {
        for kind in DRIVEN {
            let dt = 1.0 / rate;
            let motor = Motor::Position { target: 1.0, softness: Softness::RIGID, max_force: 1.0e5 };
            let (mut world, bar, _) = driven(Solver::Auto, kind, motor);
            run(&mut world, 5.0, dt);
            let left = 1.0 - coordinate(&world, bar);
            assert!(left.abs() < 1.0e-3, "{kind}, {rate} Hz: {left} of 1 left");
            assert!(!world.is_awake(bar).unwrap(), "{kind}, {rate} Hz: awake after 5 s");
        }
    }
}

/// A mass on a spring so soft that its speed is below that of what is quiet for most of its period of 12.6 s.
#[test]
fn a_soft_spring_does_not_fall_asleep_where_it_turns_back() {
    for rate in RATES {
        for name in ["slider", "hinge"] {
            let dt = 1.0 / rate;
            // ω = 0.5 rad/s: k = m ω² or I ω², slightly damped.
            let inertia = if name == "slider" { 5.0 } else { 5.0 / 3.0 * (0.25 + 0.04) };
            let softness = Softness { compliance: 1.0 / (inertia * 0.25), damping: 0.4 * inertia };
            let (mut world, bar, _) = driven(Solver::Auto, name, Motor::Position { target: 0.05, softness, max_force: 1.0e5 });
            run(&mut world, 60.0, dt.max(1.0 / 60.0));
            let left = 0.05 - coordinate(&world, bar);
            assert!(left.abs() < 2.5e-3, "{name}, {rate} Hz: asleep {left} away from its balance");
            assert!(!world.is_awake(bar).unwrap(), "{name}, {rate} Hz: awake after 60 s");
        }
    }
}

#[test]
fn a_motor_that_is_stalled_sleeps() {
    for (name, motor) in [
        ("at its stop", Motor::Velocity { target: 1.0, max_force: 50.0 }),
        ("pulling a load too heavy for it", Motor::Velocity { target: -1.0, max_force: 20.0 }),
        ("a servo too weak", Motor::Position { target: -1.0, softness: Softness::RIGID, max_force: 20.0 }),
    ] {
        for rate in RATES {
            let mut world = World::new(&WorldDef::default()).unwrap();
            // Along gravity, down to a stop at 0.1 m.
            let body =
                world.create_body(&BodyDef::dynamic(Pose::IDENTITY).with_shape(cube(0.2)).with_mass(Mass::Total(5.0))).unwrap();
            let down = Pose { position: DVec3::ZERO, rotation: Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2) };
            let kind = JointKind::Prismatic { limits: Limits::new(-2.0, 0.1), motor };
            world.create_joint(&JointDef { frame_a: down, frame_b: down, ..JointDef::new(kind, BodyId::NULL, body) }).unwrap();
            run(&mut world, 3.0, 1.0 / rate);
            assert!(!world.is_awake(body).unwrap(), "{name}, {rate} Hz: awake after 3 s");
        }
    }
}

/// To a millimetre, or a thousandth of its extent, where a body is held.
#[test]
fn what_is_embedded_comes_out_before_it_sleeps() {
    for rate in RATES {
        for hold in [false, true] {
            for (half, depth) in [(0.5, 0.3), (0.5, 0.45), (0.05, 0.03), (2.0, 1.5)] {
                let dt = 1.0 / rate;
                let mut world = World::new(&WorldDef { hold, ..WorldDef::default() }).unwrap();
                floor(&mut world);
                let body = BodyDef::dynamic(Pose::at_xyz(0.0, f64::from(half) - depth, 0.0)).with_shape(cube(half));
                let body = world.create_body(&body).unwrap();
                run(&mut world, 6.0, dt);
                let left = f64::from(half) - world.pose(body).unwrap().position.y;
                assert!(
                    left < 1.0e-3 * f64::from(2.0 * half).max(1.0),
                    "{half} m, {depth} m deep, {rate} Hz, hold {hold}: still {left} m deep after 6 s"
                );
                assert!(!world.is_awake(body).unwrap(), "{half} m, {depth} m deep, {rate} Hz, hold {hold}: awake after 6 s");
            }
        }
    }
}

/// A press drives a box into the floor, stops, and is lifted.
#[test]
fn what_is_pressed_into_the_floor_comes_out_once_the_press_is_lifted() {
    for rate in RATES {
        for hold in [false, true] {
            let dt = 1.0 / rate;
            let mut world = World::new(&WorldDef { hold, ..WorldDef::default() }).unwrap();
            floor(&mut world);
            let body = world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, 0.5, 0.0)).with_shape(cube(0.5))).unwrap();
            let press = BodyDef::kinematic(Pose::at_xyz(0.0, 1.5, 0.0)).with_shape(cuboid(Vec3::new(2.0, 0.25, 2.0)));
            let press = world.create_body(&press).unwrap();
            world.set_linear_velocity(press, Vec3::NEG_Y * 0.2).unwrap();
            run(&mut world, 3.3, dt);
            assert!(world.pose(body).unwrap().position.y < 0.3, "the press presses");
            world.set_linear_velocity(press, Vec3::Y * 3.0).unwrap();
            run(&mut world, 0.5, dt);
            world.set_linear_velocity(press, Vec3::ZERO).unwrap();
            run(&mut world, 5.0, dt);
            let left = 0.5 - world.pose(body).unwrap().position.y;
            assert!(left < 1.0e-3, "{rate} Hz, hold {hold}: still {left} m deep 5.5 s after the press was lifted");
            assert!(!world.is_awake(body).unwrap(), "{rate} Hz, hold {hold}");
        }
    }
}

#[test]
fn a_joint_that_wears_out_does_not_sleep() {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let body = world.create_body(&BodyDef::dynamic(Pose::IDENTITY).with_shape(cube(0.2)).with_mass(Mass::Total(3.0))).unwrap();
    let damage = Some(Damage { from: 0.2, time: 5.0, half_life: f32::INFINITY });
    let strength = Strength { tension: 60.0, compression: 60.0, shear: 60.0, damage, ..Strength::UNBREAKABLE };
    let joint = JointDef { strength, ..JointDef::new(JointKind::SPHERICAL, BodyId::NULL, body) }.at(Vec3::Y, Vec3::Y);
    world.create_joint(&joint).unwrap();
    run(&mut world, 60.0, 1.0 / 60.0);
    assert_eq!(world.joint_count(), 0, "it bears half of what it can, and wears");
}

/// A load on a rope that hangs askew a little is drawn to where it hangs straight.
#[test]
fn a_pendulum_does_not_sleep_askew() {
    for rate in RATES {
        for length in [0.1_f32, 1.0, 10.0] {
            let mut world = World::new(&WorldDef::default()).unwrap();
            let bob = BodyDef { linear_damping: 0.2, ..BodyDef::dynamic(Pose::at_xyz(0.04 * f64::from(length), 0.0, 0.0)) };
            let bob = world.create_body(&bob.with_shape(cube(0.05 * length))).unwrap();
            let up = Vec3::new(-0.04, 1.0, 0.0) * length;
            world.create_joint(&JointDef::new(JointKind::SPHERICAL, BodyId::NULL, bob).at(Vec3::Y * length, up)).unwrap();
            let dt = 1.0 / rate;
            for step in 0.. {
                world.step(dt).unwrap();
                let askew = world.pose(bob).unwrap().position.x as f32 / length;
                if !world.is_awake(bob).unwrap() {
                    assert!(askew.abs() < 6.0e-3, "{length} m, {rate} Hz: asleep at {askew} rad");
                    break;
                }
                assert!((step as f32) < 120.0 * rate, "{length} m, {rate} Hz: awake after 120 s at {askew} rad");
            }
        }
    }
}

/// When everything is asleep, and when every body has been slower than the limits for the time that sleep takes (s).
fn times_to_sleep(world: &mut World, bodies: &[BodyId], dt: f32) -> [f32; 2] {
    let SleepSettings { linear_speed, angular_speed, time, .. } = SleepSettings::default();
    let mut quiet_for = vec![0.0; bodies.len()];
    let mut slow = None;
    for step in 1..(60.0 / dt) as u32 {
        world.step(dt).unwrap();
        let now = step as f32 * dt;
        for (&body, quiet) in bodies.iter().zip(&mut quiet_for) {
            let is_slow = world.linear_velocity(body).unwrap().length() <= linear_speed
                && world.angular_velocity(body).unwrap().length() <= angular_speed;
            *quiet = if is_slow { *quiet + dt } else { 0.0 };
        }
        if quiet_for.iter().all(|&quiet| quiet >= time) {
            slow = slow.or(Some(now));
        }
        if world.awake_body_count() == 0 {
            return [now, slow.unwrap_or(now)];
        }
    }
    [f32::INFINITY, slow.unwrap_or(f32::INFINITY)]
}

/// Bodies that fall on a floor, side by side and on each other, from so much (m) higher.
fn heap(def: &WorldDef, shape: impl Fn(usize) -> Shape, layers: usize, lift: f64) -> (World, Vec<BodyId>) {
    let mut world = World::new(def).unwrap();
    floor(&mut world);
    let at = |number: usize| {
        let (layer, place) = (number / 9, number % 9);
        let (x, z) = ((place % 3) as f64 - 1.0, (place / 3) as f64 - 1.0);
        let lean = 0.1 * (layer % 3) as f64;
        Pose {
            position: DVec3::new(0.9 * x + lean, 0.6 + lift + 0.8 * layer as f64, 0.9 * z - lean),
            rotation: Quat::from_rotation_y(0.3 * number as f32) * Quat::from_rotation_x(0.2 * (number % 5) as f32),
        }
    };
    let bodies = (0..9 * layers)
        .map(|number| world.create_body(&BodyDef::dynamic(at(number)).with_shape(ShapeDef::new(shape(number)))).unwrap());
    let bodies = bodies.collect();
    (world, bodies)
}

/// That every body has been slow for half a second was the whole rule once.
#[test]
fn a_heap_sleeps_as_soon_as_its_bodies_have_been_slow_for_long_enough() {
    let boxes = |_: usize| Shape::cuboid(Vec3::new(0.4, 0.3, 0.35)).unwrap();
    let mixed = |number: usize| match number % 3 {
        0 => Shape::cuboid(Vec3::splat(0.3)).unwrap(),
        1 => Shape::cuboid(Vec3::new(0.5, 0.12, 0.3)).unwrap(),
        _ => Shape::cuboid(Vec3::new(0.2, 0.45, 0.25)).unwrap(),
    };
    for rate in RATES {
        for hold in [true, false] {
            let def = WorldDef { hold, ..WorldDef::default() };
            for (name, (mut world, bodies)) in [("boxes", heap(&def, boxes, 4, 0.0)), ("mixed", heap(&def, mixed, 3, 0.0))] {
                let [asleep, slow] = times_to_sleep(&mut world, &bodies, 1.0 / rate);
                assert!(asleep <= 1.2 * slow, "{name}, {rate} Hz, hold {hold}: asleep after {asleep} s, slow after {slow} s");
            }
        }
    }
}

/// A heap sways as its load goes to and fro, at a speed that grows for a quarter of each period. A box of it that stands on an edge may tip over
/// as it should, once it has been slow for long: of 64 heaps two slept after 1.3 and 1.7 times.
#[test]
fn a_heap_that_sways_sleeps_too() {
    let boxes = |_: usize| Shape::cuboid(Vec3::new(0.4, 0.3, 0.35)).unwrap();
    for rate in [30.0, 120.0] {
        let mut times: Vec<f32> = (0..6)
            .map(|lift| {
                let (mut world, bodies) = heap(&WorldDef::default(), boxes, 4, 0.001 * f64::from(lift));
                let [asleep, slow] = times_to_sleep(&mut world, &bodies, 1.0 / rate);
                asleep / slow
            })
            .collect();
        times.sort_by(f32::total_cmp);
        let [.., most, last] = times[..] else { unreachable!() };
        assert!(most <= 1.2 && last <= 2.0, "{rate} Hz: asleep after {times:?} of the time after which all have been slow");
    }
}

#[test]
fn a_stack_sleeps_within_a_second_of_standing() {
    for rate in RATES {
        let mut world = World::new(&WorldDef::default()).unwrap();
        floor(&mut world);
        let bodies: Vec<BodyId> = (0..10)
            .map(|row| {
                world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, 0.5 + f64::from(row), 0.0)).with_shape(cube(0.5))).unwrap()
            })
            .collect();
        let [asleep, slow] = times_to_sleep(&mut world, &bodies, 1.0 / rate);
        assert!(asleep < 1.0 && asleep <= 1.2 * slow, "{rate} Hz: asleep after {asleep} s, slow after {slow} s");
    }
}

#[test]
fn the_report_tells_the_gap_of_joints_that_sleep() {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let [a, b] = [0.0, 1.0].map(|x| {
        let def = BodyDef { kind: BodyKind::Dynamic, gravity_scale: 0.0, ..BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)) };
        world.create_body(&def.with_mass(Mass::Properties(MassProperties::new(1.0, Vec3::ONE)))).unwrap()
    });
    // Half a metre short, and put to sleep before it is closed.
    let joint = world.create_joint(&JointDef::new(JointKind::SPHERICAL, a, b).at(Vec3::X * 0.25, Vec3::X * -0.25)).unwrap();
    world.put_to_sleep(a).unwrap();
    let gap = world.joint_state(joint).unwrap().gap;
    assert_eq!(world.step(1.0 / 60.0).unwrap().residuals.joint_gap, gap);
    assert!((gap - 0.5).abs() < 1.0e-6, "{gap}");
    let mut saved = Vec::new();
    world.save(&mut saved);
    let mut restored = World::new(&WorldDef::default()).unwrap();
    restored.restore(&saved).unwrap();
    assert_eq!(restored.step(1.0 / 60.0).unwrap().residuals.joint_gap, gap, "of a world that was restored");
    world.wake(a).unwrap();
    run(&mut world, 2.0, 1.0 / 60.0);
    assert!(world.report().residuals.joint_gap < 1.0e-4);
}

/// Steps until a body has fallen asleep, for 10 s at most; returns the time that took (s).
fn falls_asleep(world: &mut World, body: BodyId, dt: f32) -> f32 {
    let awake = (0..(10.0 / dt) as u32).take_while(|_| {
        let is_awake = world.is_awake(body).unwrap();
        if is_awake {
            world.step(dt).unwrap();
        }
        is_awake
    });
    let seconds = awake.count() as f32 * dt;
    assert!(!world.is_awake(body).unwrap(), "it does not fall asleep in 10 s");
    seconds
}

#[test]
fn what_lies_on_a_platform_stays_awake_while_it_moves_however_slowly() {
    for (rate, speed) in [(30.0, 1.0e-3), (60.0, 1.0e-4), (240.0, 1.0e-3)] {
        let dt = 1.0 / rate;
        let mut world = World::new(&WorldDef::default()).unwrap();
        let plate = BodyDef::kinematic(Pose::IDENTITY).with_shape(cuboid(Vec3::new(1.0, 0.1, 1.0)));
        let plate = world.create_body(&plate).unwrap();
        let load = world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, 0.35, 0.0)).with_shape(cube(0.25))).unwrap();
        falls_asleep(&mut world, load, dt);
        world.set_linear_velocity(plate, Vec3::X * speed).unwrap();
        for _ in 0..(3.0 * rate) as u32 {
            world.step(dt).unwrap();
            assert!(world.is_awake(load).unwrap(), "{rate} Hz, {speed} m/s");
        }
        let carried = world.pose(load).unwrap().position.x as f32;
        assert!((carried - 3.0 * speed).abs() < 0.1 * speed, "{rate} Hz, {speed} m/s: carried by {carried} m in 3 s");
        world.set_linear_velocity(plate, Vec3::ZERO).unwrap();
        let asleep = falls_asleep(&mut world, load, dt);
        assert!(asleep < 1.0, "{rate} Hz: asleep {asleep} s after the platform stopped");
    }
}

#[test]
fn what_is_made_inside_a_sleeper_drives_it_out() {
    for rate in [30.0, 60.0, 240.0] {
        for kind in [BodyKind::Static, BodyKind::Kinematic] {
            for shape in [Shape::cuboid(Vec3::splat(0.2)).unwrap(), Shape::ball(0.2).unwrap()] {
                let dt = 1.0 / rate;
                let mut world = World::new(&WorldDef::default()).unwrap();
                floor(&mut world);
                let sleeper = world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, 0.3, 0.0)).with_shape(cube(0.3))).unwrap();
                falls_asleep(&mut world, sleeper, dt);
                let inside = BodyDef { kind, pose: Pose::at_xyz(0.05, 0.1, 0.02), ..BodyDef::default() };
                world.create_body(&inside.with_shape(ShapeDef::new(shape.clone()))).unwrap();
                assert!(world.is_awake(sleeper).unwrap());
                run(&mut world, 4.0, dt);
                let points = world.contacts_of(sleeper).unwrap();
                let deepest =
                    points.flat_map(|contact| contact.points().to_vec()).map(|point| -point.separation).fold(0.0, f32::max);
                assert!(deepest < 5.0e-3, "{kind:?} {shape:?}, {rate} Hz: still {deepest} m deep after 4 s");
            }
        }
    }
}

/// A chain of bodies along x, each on the one before it by a fixed joint, the first on `base`.
fn welded(world: &mut World, base: BodyId, count: u32) -> Vec<BodyId> {
    let mut bodies = vec![base];
    for i in 1..=count {
        let def = BodyDef::dynamic(Pose::at_xyz(f64::from(i), 0.0, 0.0)).with_shape(cube(0.2));
        let body = world.create_body(&def).unwrap();
        let before = *bodies.last().unwrap();
        let reach = if i == 1 { Vec3::X } else { Vec3::X * 0.5 };
        let def = JointDef::new(JointKind::Fixed, before, body).at(reach, reach - Vec3::X);
        world.create_joint(&def).unwrap();
        bodies.push(body);
    }
    bodies.split_off(1)
}

#[test]
fn what_is_welded_to_the_world_is_asleep() {
    for (rate, count, gravity) in RATES.into_iter().flat_map(|rate| [(rate, 1, 9.81_f32), (rate, 5, 9.81), (rate, 5, 0.0)]) {
        for (solver, on_static) in
            [Solver::Auto, Solver::GaussSeidel].into_iter().flat_map(|solver| [(solver, false), (solver, true)])
        {
            let what = format!("{count} bodies, {gravity} m/s², {rate} Hz, {solver:?}, on a static body: {on_static}");
            let mut world = World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, solver, ..WorldDef::default() }).unwrap();
            let base = if on_static { world.create_body(&BodyDef::fixed(Pose::IDENTITY)).unwrap() } else { BodyId::NULL };
            let bodies = welded(&mut world, base, count);
            run(&mut world, 1.0, 1.0 / rate);
            let is_awake = |world: &World, body: BodyId| world.is_awake(body).unwrap();
            assert!(bodies.iter().all(|&body| !is_awake(&world, body)), "{what}: awake after a second");
            // It is where it was made, and wakes as it is let go.
            let last = bodies[bodies.len() - 1];
            assert_eq!(world.pose(last).unwrap().position, DVec3::X * f64::from(count), "{what}");
            let first = world.body_joints(bodies[0]).unwrap()[0];
            world.destroy_joint(first).unwrap();
            world.step(1.0 / rate).unwrap();
            assert!(bodies.iter().all(|&body| is_awake(&world, body)), "{what}: asleep, and nothing holds it");
        }
    }
}

#[test]
fn what_is_welded_to_the_world_is_awake_where_it_may_not_sleep_or_wears() {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let body = welded(&mut world, BodyId::NULL, 1)[0];
    run(&mut world, 0.1, 1.0 / 60.0);
    assert!(!world.is_awake(body).unwrap());
    world.set_can_sleep(body, false).unwrap();
    run(&mut world, 1.0, 1.0 / 60.0);
    assert!(world.is_awake(body).unwrap(), "it may not sleep");
    world.set_can_sleep(body, true).unwrap();
    let joint = world.body_joints(body).unwrap()[0];
    let weight = 9.81 * world.mass_properties(body).unwrap().unwrap().mass;
    for (limit, wears) in [(10.0 * weight, false), (1.5 * weight, true)] {
        let damage = Some(Damage { from: 0.5, time: 60.0, half_life: f32::INFINITY });
        world.set_joint_strength(joint, Strength { shear: limit, damage, ..Strength::UNBREAKABLE }).unwrap();
        run(&mut world, 1.0, 1.0 / 60.0);
        assert_eq!(world.is_awake(body).unwrap(), wears, "a limit of {limit} N under {weight} N");
    }
}
