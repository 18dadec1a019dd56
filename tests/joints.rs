//! What a joint says of itself, and who solves it.

use longspan::glam::{Quat, Vec3};
use longspan::{
    ArticulationSettings, Axis, BodyDef, BodyId, JointDef, JointId, JointKind, Limits, LockedAxes, Mass, Motor, Pose, Shape,
    ShapeDef, SleepSettings, Softness, Solver, World, WorldDef,
};

const DT: f32 = 1.0 / 60.0;
const MASS: f32 = 8.0;
const GRAVITY: f32 = 9.81;

fn world(solver: Solver) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let def = WorldDef { gravity: Vec3::NEG_Y * GRAVITY, solver, sleep, ..WorldDef::default() };
    World::new(&def).expect("a valid world")
}

fn cube(world: &mut World, x: f64, y: f64) -> BodyId {
    let shape = Shape::cuboid(Vec3::splat(0.1)).expect("a valid shape");
    let def = BodyDef::dynamic(Pose::at_xyz(x, y, 0.0)).with_shape(ShapeDef::new(shape)).with_mass(Mass::Total(MASS));
    world.create_body(&def).expect("a valid body")
}

fn cube_that_resists_rolling(world: &mut World, x: f64, y: f64) -> BodyId {
    let mut shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.1)).expect("a valid shape"));
    shape.material.rolling_friction = 1.0e-3;
    let def = BodyDef::dynamic(Pose::at_xyz(x, y, 0.0)).with_shape(shape).with_mass(Mass::Total(MASS));
    world.create_body(&def).expect("a valid body")
}

/// A joint between the world and a cube 0.75 m along x from its point; the axis of both frames is turned by `turn` from x.
fn joint(world: &mut World, kind: JointKind, turn: Quat) -> JointId {
    let body = cube(world, 0.75, 0.0);
    let mut def = JointDef::new(kind, BodyId::NULL, body);
    (def.frame_a, def.frame_b) = (Pose::IDENTITY.rotated(turn), Pose::at_xyz(-0.75, 0.0, 0.0).rotated(turn));
    world.create_joint(&def).expect("a valid joint")
}

/// Mean over the second half of so many seconds: by sweeps a body on a long lever trembles by half a milliradian.
fn effort_over(world: &mut World, joint: JointId, seconds: f32) -> f32 {
    let steps = (seconds / DT) as usize;
    let mut sum = 0.0;
    for step in 0..steps {
        world.step(DT).expect("a valid step");
        if step >= steps / 2 {
            sum += world.joint_state(joint).expect("the joint stays").effort;
        }
    }
    sum / (steps - steps / 2) as f32
}

#[track_caller]
fn is_near(found: f32, expected: f32, what: &str) {
    assert!((found - expected).abs() <= 0.01 * expected.abs(), "{what}: {found}, by statics {expected}, bound 1 %");
}

#[test]
fn motors_and_stops_say_what_they_bear() {
    let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let upwards = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        let holds = Motor::Position { target: 0.0, softness: Softness::RIGID, max_force: f32::INFINITY };
        let mut arm = world(solver);
        let held = joint(&mut arm, JointKind::Hinge { limits: Limits::NONE, motor: holds }, about_z);
        is_near(effort_over(&mut arm, held, 4.0), MASS * GRAVITY * 0.75, "torque of a motor that holds an arm level");

        let mut flap = world(solver);
        let stopped = joint(&mut flap, JointKind::Hinge { limits: Limits::new(0.0, 1.0), motor: Motor::Off }, about_z);
        is_near(effort_over(&mut flap, stopped, 4.0), MASS * GRAVITY * 0.75, "torque of a stop under a flap");

        let mut lift = world(solver);
        let raised = Motor::Velocity { target: 0.5, max_force: 1.0e4 };
        let cabin = joint(&mut lift, JointKind::Prismatic { limits: Limits::NONE, motor: raised }, upwards);
        is_near(effort_over(&mut lift, cabin, 4.0), MASS * GRAVITY, "force of a motor that lifts steadily");

        let mut weak = world(solver);
        let motor = Motor::Velocity { target: 0.0, max_force: 20.0 };
        let slips = joint(&mut weak, JointKind::Hinge { limits: Limits::NONE, motor }, about_z);
        is_near(effort_over(&mut weak, slips, 0.1), 20.0, "torque of a hinge whose friction slips");
    }
}

/// A chain of three cubes that hangs from the world; returns its joints.
fn chain(world: &mut World, x: f64) -> Vec<JointId> {
    let mut above = BodyId::NULL;
    let mut joints = Vec::new();
    for link in 0..3 {
        let body = cube(world, x, -0.5 * f64::from(link));
        let mut def = JointDef::new(JointKind::SPHERICAL, above, body);
        let on_a = if above == BodyId::NULL { Pose::at_xyz(x, 0.25, 0.0) } else { Pose::at_xyz(0.0, -0.25, 0.0) };
        (def.frame_a, def.frame_b) = (on_a, Pose::at_xyz(0.0, 0.25, 0.0));
        joints.push(world.create_joint(&def).expect("a valid joint"));
        above = body;
    }
    joints
}

#[test]
fn joints_of_damped_bodies_bear_their_weight() {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    for damping in [0.5, 5.0] {
        let def = WorldDef { gravity: Vec3::NEG_Y * GRAVITY, sleep, ..WorldDef::default() };
        let mut world = World::new(&def).expect("a valid world");
        let joints = chain(&mut world, 0.0);
        // An arm that a motor holds level: torques know of damping too.
        let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        let motor = Motor::Position { target: 0.0, softness: Softness::RIGID, max_force: f32::INFINITY };
        let arm = joint(&mut world, JointKind::Hinge { limits: Limits::NONE, motor }, about_z);
        let bodies: Vec<BodyId> =
            joints.iter().chain([&arm]).map(|&joint| world.joint_def(joint).expect("joints stay").body_b).collect();
        for body in bodies {
            world.set_damping(body, damping, damping).expect("a body of the world");
        }
        for _ in 0..60 {
            world.step(DT).expect("a valid step");
        }
        for (number, &joint) in joints.iter().enumerate() {
            let force = world.joint_state(joint).expect("joints stay").force.length();
            is_near(force, MASS * GRAVITY * (3 - number) as f32, &format!("force of joint {number} at a damping of {damping}/s"));
        }
        let effort = world.joint_state(arm).expect("joints stay").effort;
        is_near(effort, MASS * GRAVITY * 0.75, &format!("torque of a motor that holds an arm at a damping of {damping}/s"));
    }
}

#[test]
fn one_joint_chooses_how_its_articulation_is_solved() {
    let solved_directly = |world: &mut World| {
        world.step(DT).expect("a valid step");
        world.articulations().iter().map(|articulation| articulation.bodies).sum::<u32>()
    };
    let mut mixed = world(Solver::Auto);
    let [first, second] = [0.0, 2.0].map(|x| chain(&mut mixed, x));
    assert_eq!(solved_directly(&mut mixed), 6, "both chains, as the world says");
    mixed.set_joint_solver(second[1], Solver::GaussSeidel).expect("a joint of the world");
    assert_eq!(solved_directly(&mut mixed), 3, "the first chain alone");
    mixed.set_joint_solver(second[2], Solver::Direct).expect("a joint of the world");
    assert_eq!(solved_directly(&mut mixed), 3, "one that asks for sweeps is enough");
    mixed.set_joint_solver(second[1], Solver::Auto).expect("a joint of the world");
    assert_eq!(solved_directly(&mut mixed), 6, "both again");
    assert_eq!(mixed.joint_def(second[2]).expect("a joint of the world").solver, Solver::Direct);

    let mut swept = world(Solver::GaussSeidel);
    let [asking, _] = [0.0, 2.0].map(|x| chain(&mut swept, x));
    assert_eq!(solved_directly(&mut swept), 0, "none, as the world says");
    swept.set_joint_solver(asking[0], Solver::Direct).expect("a joint of the world");
    assert_eq!(solved_directly(&mut swept), 3, "the chain that asks");
    for world in [&mut mixed, &mut swept] {
        for _ in 0..120 {
            world.step(DT).expect("a valid step");
        }
        assert!(world.report().residuals.joint_gap < 1.0e-4, "a gap of {} m, bound 1e-4", world.report().residuals.joint_gap);
    }
    let other = world(Solver::Auto);
    assert!({ other }.set_joint_solver(first[0], Solver::Direct).is_err(), "a joint of another world");
}

/// A limb that is struck at a given speed (m/s): whether it has been swept, how far it has been turned (rad), and for how many steps on end it
/// has been at its stop and turned on.
fn struck_limb(speed: f32) -> (bool, f32, u32) {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    // Without a budget no island is one problem, and what resists rolling does not ride on the limb as rows of its joint: they are swept.
    let articulations = ArticulationSettings { halving_budget: 0.0, ..ArticulationSettings::default() };
    let def = WorldDef { gravity: Vec3::ZERO, sleep, articulations, ..WorldDef::default() };
    let mut world = World::new(&def).expect("a valid world");
    let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let arm = joint(&mut world, JointKind::Hinge { limits: Limits::new(-0.5, 0.5), motor: Motor::Off }, about_z);
    cube_that_resists_rolling(&mut world, 0.95, 0.0);
    let striker = cube_that_resists_rolling(&mut world, 0.7, -0.45);
    world.set_linear_velocity(striker, Vec3::Y * speed).expect("a body of the world");
    let (mut was_swept, mut worst, mut running, mut longest) = (false, 0.0_f32, 0, 0);
    for _ in 0..60 {
        world.step(DT).expect("a valid step");
        was_swept |= world.articulations().iter().any(|articulation| articulation.swept);
        let state = world.joint_state(arm).expect("the joint stays");
        worst = worst.max(state.position);
        running = if state.position >= 0.499 && state.velocity >= 0.1 { running + 1 } else { 0 };
        longest = longest.max(running);
    }
    (was_swept, worst, longest)
}

#[test]
fn a_blow_drives_no_swept_joint_past_a_stop_that_was_out_of_reach() {
    let mut swept = 0;
    for speed in [20.0, 25.0, 28.0, 30.0, 32.0, 35.0, 40.0, 45.0, 50.0, 60.0] {
        let (was_swept, worst, longest) = struck_limb(speed);
        swept += u32::from(was_swept);
        assert!(worst > 0.4, "{speed} m/s: the blow turns the limb by {worst} rad only");
        assert!(worst < 0.5005, "{speed} m/s: it has been at {worst} rad, its stop is at 0.5");
        // Positions alone would be taken back to the stop without a row of it, and the limb go on to press. A blow that turns it by more than
        // a tenth of a radian within a substep takes it there before there is a row, and the next step stops it.
        assert!(longest <= 1, "{speed} m/s: it turns on at its stop for {longest} steps");
    }
    // At others what it has struck turns away from it, and it takes its steps by itself.
    assert!(swept >= 5, "{swept} of 10 were swept, and rows are left out of what is swept alone");
}

/// Greatest gap (m) within a second of a joint that holds a cube of `size` on a lever of 7.5 times that, its axes locked so.
fn gap_of_a_locked_cube(solver: Solver, rate: u32, size: f64, kind: JointKind, locks: u32) -> f32 {
    let mut world = world(solver);
    let bit = |number: u32| locks >> number & 1 == 1;
    let locked_axes = LockedAxes { translation: [0, 1, 2].map(bit), rotation: [3, 4, 5].map(bit) };
    let shape = Shape::cuboid(Vec3::splat(size as f32)).expect("a valid shape");
    let def = BodyDef { locked_axes, ..BodyDef::dynamic(Pose::at_xyz(7.5 * size, 0.0, 0.0)) };
    let body = world.create_body(&def.with_shape(ShapeDef::new(shape))).expect("a valid body");
    let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let turn = if matches!(kind, JointKind::Prismatic { .. }) { Quat::IDENTITY } else { about_z };
    let mut def = JointDef::new(kind, BodyId::NULL, body);
    (def.frame_a, def.frame_b) = (Pose::IDENTITY.rotated(turn), Pose::at_xyz(-7.5 * size, 0.0, 0.0).rotated(turn));
    let joint = world.create_joint(&def).expect("a valid joint");
    let mut widest = 0.0_f32;
    for _ in 0..rate {
        world.step(1.0 / rate as f32).expect("a valid step");
        widest = widest.max(world.joint_state(joint).expect("the joint stays").gap);
    }
    widest
}

#[test]
fn a_body_with_locked_axes_hangs_on_its_joint_by_either_solver() {
    let kinds = [
        JointKind::Fixed,
        JointKind::Hinge { limits: Limits::NONE, motor: Motor::Off },
        JointKind::Spherical { swing_limit: std::f32::consts::PI, twist_limits: Limits::NONE, motor: Default::default() },
        JointKind::Prismatic { limits: Limits::NONE, motor: Motor::Off },
        JointKind::Generic { linear: [Axis::LOCKED; 3], angular: [Axis::LOCKED, Axis::LOCKED, Axis::FREE] },
    ];
    // All sets of locks that leave it free to fall.
    for locks in (0..64).filter(|locks| locks & 2 == 0) {
        for kind in kinds {
            for (solver, rate, size) in [
                (Solver::GaussSeidel, 60, 0.1),
                (Solver::GaussSeidel, 30, 1.0),
                (Solver::GaussSeidel, 240, 0.01),
                (Solver::Auto, 60, 0.1),
            ] {
                let gap = f64::from(gap_of_a_locked_cube(solver, rate, size, kind, locks));
                // A hundredth of the lever; it falls by 4.9 m where the joint has let go.
                let bound = 0.075 * size;
                let what = format!("{kind:?}, {solver:?}, {rate} Hz, {size} m, locks {locks:06b}");
                assert!(gap <= bound, "{what}: the joint opens by {gap} m, bound {bound} m");
            }
        }
    }
}
