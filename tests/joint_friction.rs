//! Joints rub: what moves is braked as a dry bearing brakes it, what stands stays, by either solver.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, JointDef, JointId, JointKind, Limits, Mass, MassProperties, Motor, Pose, SleepSettings, Softness,
    Solver, SphericalMotor, World, WorldDef,
};

const DT: f32 = 1.0 / 60.0;
const GRAVITY: f32 = 9.81;
const SOLVERS: [Solver; 2] = [Solver::Auto, Solver::GaussSeidel];

/// Greatest turn (rad) or way (m) of what sticks.
const NO_CREEP: f64 = 1.0e-6;

fn world_with(solver: Solver, gravity: f32, substeps: u32) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let def = WorldDef { gravity: Vec3::NEG_Y * gravity, solver, sleep, substeps, ..WorldDef::default() };
    World::new(&def).expect("a valid world")
}

fn world(solver: Solver, gravity: f32) -> World {
    world_with(solver, gravity, WorldDef::default().substeps)
}

fn steps(world: &mut World, seconds: f32) {
    for _ in 0..(seconds / DT).round() as u32 {
        world.step(DT).expect("a valid step");
    }
}

/// A body of this mass (kg) and moment of inertia about any axis (kg·m²).
fn body(world: &mut World, at: DVec3, mass: f32, inertia: f32) -> BodyId {
    let properties = Mass::Properties(MassProperties::new(mass, Vec3::splat(inertia)));
    world.create_body(&BodyDef::dynamic(Pose::at(at)).with_mass(properties)).expect("a valid body")
}

/// From the x axis to the z axis, about which hinges turn here.
fn about_z() -> Quat {
    Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2)
}

/// A joint between the world's origin and a body, whose joint point is `arm` from its middle; joint axes along z.
fn hang(world: &mut World, kind: JointKind, body: BodyId, arm: Vec3, friction: f32) -> JointId {
    let mut def = JointDef::new(kind, BodyId::NULL, body).with_friction(friction);
    def.frame_a = Pose::IDENTITY.rotated(about_z());
    def.frame_b = Pose::at(arm.as_dvec3()).rotated(about_z());
    world.create_joint(&def).expect("a valid joint")
}

/// A wheel of 1 kg·m² on a hinge that rubs, which turns at `spin` (rad/s).
fn wheel(world: &mut World, kind: JointKind, spin: f32, friction: f32) -> (BodyId, JointId) {
    let wheel = body(world, DVec3::ZERO, 2.0, 1.0);
    world.set_angular_velocity(wheel, Vec3::Z * spin).expect("a body of the world");
    let joint = hang(world, kind, wheel, Vec3::ZERO, friction);
    (wheel, joint)
}

/// An arm of 8 kg whose middle is 0.75 m from its hinge, out at `angle` (rad) above the level.
fn arm(world: &mut World, kind: JointKind, angle: f32, friction: f32) -> (BodyId, JointId) {
    let out = Quat::from_rotation_z(angle) * Vec3::X * 0.75;
    let arm = body(world, out.as_dvec3(), 8.0, 0.2);
    let joint = hang(world, kind, arm, -out, friction);
    (arm, joint)
}

fn angle_of(world: &World, joint: JointId) -> f64 {
    f64::from(world.joint_state(joint).expect("the joint stays").position)
}

/// How far the joint's coordinate leaves its value of now within so many seconds.
fn greatest_change(world: &mut World, joint: JointId, seconds: f32) -> f64 {
    let start = angle_of(world, joint);
    let mut most: f64 = 0.0;
    for _ in 0..(seconds / DT) as u32 {
        world.step(DT).expect("a valid step");
        most = most.max((angle_of(world, joint) - start).abs());
    }
    most
}

#[track_caller]
fn is_near(found: f64, expected: f64, share: f64, what: &str) {
    assert!((found - expected).abs() <= share * expected.abs(), "{what}: {found}, expected {expected}, bound {share} of it");
}

#[test]
fn a_flywheel_stops_after_its_spin_over_what_its_bearing_takes() {
    let (spin, friction) = (10.0, 2.0);
    for solver in SOLVERS {
        let mut world = world(solver, 0.0);
        let (wheel, joint) = wheel(&mut world, JointKind::HINGE, spin, friction);
        let (mut time, mut last) = (0.0, spin);
        for _ in 0..360 {
            world.step(DT).expect("a valid step");
            let now = world.angular_velocity(wheel).expect("a body of the world").z;
            // The step in which it stops counts by what was left.
            let turns = now > 1.0e-4;
            time += f64::from(if turns { DT } else { last / friction });
            last = if turns { now } else { 0.0 };
            let effort = world.joint_state(joint).expect("the joint stays").effort;
            if turns {
                is_near(f64::from(effort), f64::from(-friction), 1.0e-3, "the friction that the joint tells (N·m)");
            }
        }
        is_near(time, f64::from(spin / friction), 1.0e-3, "time to stop (s)");
        let creeps = greatest_change(&mut world, joint, 5.0);
        assert!(creeps <= NO_CREEP, "{solver:?}: a wheel that has stopped turns by {creeps} rad, bound {NO_CREEP}");
    }
}

#[test]
fn an_arm_stays_where_its_bearing_holds_it_and_falls_where_it_does_not() {
    let angle = 0.5_f32;
    let weight = 8.0 * GRAVITY * 0.75 * angle.cos();
    for solver in SOLVERS {
        for substeps in [1, 4] {
            let mut held = world_with(solver, GRAVITY, substeps);
            let (_, joint) = arm(&mut held, JointKind::HINGE, angle, 1.02 * weight);
            let begins = greatest_change(&mut held, joint, 0.2);
            assert!(begins <= 1.0e-4, "{solver:?}, {substeps} substeps: begins with {begins} rad, bound 1e-4");
            let creeps = greatest_change(&mut held, joint, 10.0);
            assert!(creeps <= NO_CREEP, "{solver:?}, {substeps} substeps: creeps by {creeps} rad in 10 s, bound {NO_CREEP}");
            let effort = held.joint_state(joint).expect("the joint stays").effort;
            is_near(f64::from(effort), f64::from(weight), 0.01, "the torque that the joint tells (N·m)");

            // As without friction, but for the share of its weight that is left: one substep of sweeps has not all of it at first.
            let [free, rubbing] = [0.0, 0.9 * weight].map(|friction| {
                let mut falls = world_with(solver, GRAVITY, substeps);
                let (falling, _) = arm(&mut falls, JointKind::HINGE, angle, friction);
                steps(&mut falls, 0.1);
                f64::from(falls.angular_velocity(falling).expect("a body of the world").z)
            });
            let expected = if substeps > 1 { -0.1 * f64::from(weight) / (0.2 + 8.0 * 0.75 * 0.75) * 0.1 } else { 0.1 * free };
            is_near(rubbing, expected, 0.02, "spin after a tenth of a second (rad/s)");
        }
    }
}

#[test]
fn a_slider_on_a_slope_sticks_or_runs_by_what_is_left_of_its_weight() {
    let slope = 0.5_f32;
    let pull = 8.0 * GRAVITY * slope.sin();
    for solver in SOLVERS {
        let slide = |friction: f32| {
            let mut world = world(solver, GRAVITY);
            let slider = body(&mut world, DVec3::ZERO, 8.0, 0.2);
            let mut def = JointDef::new(JointKind::PRISMATIC, BodyId::NULL, slider).with_friction(friction);
            let along = Quat::from_rotation_z(-slope);
            (def.frame_a, def.frame_b) = (Pose::IDENTITY.rotated(along), Pose::IDENTITY.rotated(along));
            let joint = world.create_joint(&def).expect("a valid joint");
            (world, joint)
        };
        let (mut sticks, joint) = slide(1.02 * pull);
        let creeps = greatest_change(&mut sticks, joint, 10.0);
        assert!(creeps <= NO_CREEP, "{solver:?}: creeps by {creeps} m in 10 s, bound {NO_CREEP}");
        let (mut runs, joint) = slide(0.4 * pull);
        steps(&mut runs, 1.0);
        let state = runs.joint_state(joint).expect("the joint stays");
        is_near(f64::from(state.velocity), f64::from(0.6 * pull / 8.0), 1.0e-3, "speed after a second (m/s)");
        is_near(f64::from(state.effort), f64::from(-0.4 * pull), 1.0e-3, "the friction that the joint tells (N)");
    }
}

/// Greatest angle after half a swing from rest at `angle`, friction being `share` of m g l: what is lost of height is the way times it.
fn next_swing(angle: f64, share: f64) -> f64 {
    let (mut low, mut high) = (-angle, angle);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if middle.cos() - angle.cos() > share * (angle + middle) { low = middle } else { high = middle }
    }
    low
}

#[test]
fn a_pendulum_loses_twice_its_friction_over_its_weight_with_every_half_swing() {
    let share = 0.008;
    for solver in SOLVERS {
        let mut world = world(solver, GRAVITY);
        let friction = share * 8.0 * f64::from(GRAVITY) * 0.75;
        let start = 0.1 - std::f32::consts::FRAC_PI_2;
        let (bob, joint) = arm(&mut world, JointKind::HINGE, start, friction as f32);
        let (mut expected, mut swings, mut before) = (0.1, 0, 0.0);
        for _ in 0..600 {
            world.step(DT).expect("a valid step");
            let spin = world.angular_velocity(bob).expect("a body of the world").z;
            let spin = if spin.abs() < 1.0e-3 { 0.0 } else { spin };
            if before * spin < 0.0 {
                swings += 1;
                expected = next_swing(expected, share);
                let side = if swings % 2 == 0 { 1.0 } else { -1.0 };
                let found = side * (angle_of(&world, joint) + 0.1);
                assert!(
                    (found - expected).abs() < 4.0e-4,
                    "{solver:?}: after {swings} half swings at {found} rad, expected {expected}, bound 4e-4"
                );
            }
            before = if spin == 0.0 { before } else { spin };
        }
        assert_eq!(swings, 5, "{solver:?}: half swings of six from which it swings back");
        let left = (angle_of(&world, joint) + 0.1).abs();
        let expected = next_swing(expected, share);
        assert!((left - expected).abs() < 4.0e-4, "{solver:?}: {left} rad left, expected {expected}, bound 4e-4");
        let creeps = greatest_change(&mut world, joint, 10.0);
        assert!(creeps <= NO_CREEP, "{solver:?}: stands off the plumb line and creeps by {creeps} rad, bound {NO_CREEP}");
    }
}

#[test]
fn a_motor_has_what_friction_leaves_of_its_torque() {
    let driven = |target, max_force| JointKind::Hinge { limits: Limits::NONE, motor: Motor::Velocity { target, max_force } };
    for solver in SOLVERS {
        let mut strong = world(solver, 0.0);
        let (turns, joint) = wheel(&mut strong, driven(4.0, 3.0), 0.0, 1.0);
        steps(&mut strong, 1.0);
        let spin = strong.angular_velocity(turns).expect("a body of the world").z;
        is_near(f64::from(spin), 2.0, 1.0e-3, "spin after a second of 3 N·m against 1 (rad/s)");
        steps(&mut strong, 3.0);
        let spin = strong.angular_velocity(turns).expect("a body of the world").z;
        is_near(f64::from(spin), 4.0, 1.0e-4, "spin that the motor holds (rad/s)");
        let effort = strong.joint_state(joint).expect("the joint stays").effort;
        assert!(effort.abs() < 1.0e-2, "{solver:?}: motor and friction cancel but for {effort} N·m, bound 0.01");

        let mut unbounded = world(solver, 0.0);
        let (turns, _) = wheel(&mut unbounded, driven(0.1, f32::INFINITY), 0.0, 1000.0);
        steps(&mut unbounded, DT);
        let spin = unbounded.angular_velocity(turns).expect("a body of the world").z;
        is_near(f64::from(spin), 0.1, 1.0e-3, "spin after a step of a motor without bound against 1000 N·m (rad/s)");

        let mut weak = world(solver, 0.0);
        let (_, joint) = wheel(&mut weak, driven(4.0, 1.0), 0.0, 3.0);
        let creeps = greatest_change(&mut weak, joint, 10.0);
        assert!(creeps <= NO_CREEP, "{solver:?}: a motor of 1 N·m turns 3 N·m of friction by {creeps} rad, bound {NO_CREEP}");
    }
}

#[test]
fn a_servo_in_a_bearing_that_rubs_holds_its_target() {
    for solver in SOLVERS {
        let mut world = world(solver, GRAVITY);
        let motor = Motor::Position { target: 0.3, softness: Softness::RIGID, max_force: 1000.0 };
        let (_, joint) = arm(&mut world, JointKind::Hinge { limits: Limits::NONE, motor }, 0.0, 20.0);
        steps(&mut world, 6.0);
        let off = (angle_of(&world, joint) - 0.3).abs();
        assert!(off < 1.0e-3, "{solver:?}: off its target by {off} rad, bound 1e-3");
        let effort = world.joint_state(joint).expect("the joint stays").effort;
        is_near(f64::from(effort), 8.0 * 9.81 * 0.75 * 0.3_f64.cos(), 0.01, "the torque that holds the arm (N·m)");
    }
}

#[test]
fn friction_acts_between_stops_and_leaves_them_as_they_are() {
    for solver in SOLVERS {
        let mut world = world(solver, GRAVITY);
        let kind = JointKind::Hinge { limits: Limits::new(-0.4, 1.0), motor: Motor::Off };
        let (_, joint) = arm(&mut world, kind, 0.0, 15.0);
        steps(&mut world, 3.0);
        let angle = angle_of(&world, joint);
        assert!((angle + 0.4).abs() < 2.0e-3, "{solver:?}: rests at {angle} rad on its stop at -0.4, bound 2e-3");
        let effort = world.joint_state(joint).expect("the joint stays").effort;
        is_near(f64::from(effort), 8.0 * 9.81 * 0.75 * 0.4_f64.cos(), 0.01, "what stop and friction bear (N·m)");
        let creeps = greatest_change(&mut world, joint, 5.0);
        assert!(creeps <= 1.0e-5, "{solver:?}: on its stop it creeps by {creeps} rad, bound 1e-5");
    }
}

#[test]
fn a_turntable_drags_what_rubs_on_it() {
    for solver in SOLVERS {
        let mut world = world(solver, 0.0);
        let table = world.create_body(&BodyDef::kinematic(Pose::IDENTITY)).expect("a valid body");
        world.set_angular_velocity(table, Vec3::Z * 2.0).expect("a body of the world");
        let wheel = body(&mut world, DVec3::ZERO, 2.0, 1.0);
        let mut def = JointDef::new(JointKind::HINGE, table, wheel).with_friction(1.0);
        (def.frame_a, def.frame_b) = (Pose::IDENTITY.rotated(about_z()), Pose::IDENTITY.rotated(about_z()));
        let joint = world.create_joint(&def).expect("a valid joint");
        steps(&mut world, 1.0);
        let spin = world.angular_velocity(wheel).expect("a body of the world").z;
        is_near(f64::from(spin), 1.0, 1.0e-3, "spin after a second of 1 N·m (rad/s)");
        steps(&mut world, 1.5);
        let creeps = greatest_change(&mut world, joint, 5.0);
        assert!(creeps <= 1.0e-5, "{solver:?}: goes along but for {creeps} rad in 5 s, bound 1e-5");
    }
}

#[test]
fn a_brake_that_is_let_go_wakes_what_it_held() {
    for solver in SOLVERS {
        let def = WorldDef { gravity: Vec3::NEG_Y * GRAVITY, solver, ..WorldDef::default() };
        let mut world = World::new(&def).expect("a valid world");
        let (held, joint) = arm(&mut world, JointKind::HINGE, 0.0, 100.0);
        steps(&mut world, 2.0);
        assert_eq!(world.awake_body_count(), 0, "{solver:?}: what sticks falls asleep");
        world.set_joint_friction(joint, 100.0).expect("a joint of the world");
        assert_eq!(world.awake_body_count(), 0, "{solver:?}: the same friction changes nothing");
        world.set_joint_friction(joint, 0.0).expect("a joint of the world");
        steps(&mut world, 0.2);
        let spin = world.angular_velocity(held).expect("a body of the world").z;
        assert!(spin < -1.0, "{solver:?}: falls at {spin} rad/s, at least 1 downwards");
        world.set_joint_friction(joint, 1.0e6).expect("a joint of the world");
        steps(&mut world, 2.0 * DT);
        let spin = world.angular_velocity(held).expect("a body of the world").z;
        assert!(spin.abs() < 1.0e-3, "{solver:?}: the brake stops it, {spin} rad/s left, bound 1e-3");
    }
}

#[test]
fn a_ball_joint_rubs_alike_about_every_axis() {
    let axis = Vec3::new(0.48, -0.6, 0.64);
    for solver in SOLVERS {
        let mut spins = world(solver, 0.0);
        let ball = body(&mut spins, DVec3::ZERO, 2.0, 1.0);
        spins.set_angular_velocity(ball, axis * 5.0).expect("a body of the world");
        let joint = hang(&mut spins, JointKind::SPHERICAL, ball, Vec3::ZERO, 2.0);
        steps(&mut spins, 1.0);
        let spin = spins.angular_velocity(ball).expect("a body of the world");
        let expected = axis * 3.0;
        assert!(
            (spin - expected).length() < 0.01,
            "{solver:?}: spin after a second {spin}, expected {expected}, bound 0.01 rad/s"
        );
        let torque = spins.joint_state(joint).expect("the joint stays").torque;
        is_near(f64::from(torque.length()), 2.0, 1.0e-3, "the torque that the joint tells (N·m)");
        steps(&mut spins, 2.0);
        let start = spins.pose(ball).expect("a body of the world").rotation;
        steps(&mut spins, 5.0);
        let turned = f64::from(start.angle_between(spins.pose(ball).expect("a body of the world").rotation));
        // Angles of f32 quaternions resolve no better.
        assert!(turned < 1.0e-3, "{solver:?}: turns by {turned} rad once it has stopped, bound 1e-3");

        let torque = 8.0 * GRAVITY * 0.75;
        let mut held = world(solver, GRAVITY);
        let (stays, _) = arm(&mut held, JointKind::SPHERICAL, 0.0, 1.02 * torque);
        steps(&mut held, 0.5);
        let start = held.center_of_mass(stays).expect("a body of the world");
        steps(&mut held, 10.0);
        let crept = (held.center_of_mass(stays).expect("a body of the world") - start).length();
        assert!(crept < NO_CREEP, "{solver:?}: creeps by {crept} m in 10 s, bound {NO_CREEP}");

        let mut falls = world(solver, GRAVITY);
        let (goes, _) = arm(&mut falls, JointKind::SPHERICAL, 0.0, 0.9 * torque);
        steps(&mut falls, 0.1);
        let spin = falls.angular_velocity(goes).expect("a body of the world").z;
        is_near(f64::from(spin), f64::from(-0.1 * torque / (0.2 + 8.0 * 0.75 * 0.75) * 0.1), 0.02, "spin as it falls (rad/s)");
    }
}

#[test]
fn each_axis_of_a_six_axis_joint_has_its_own() {
    let free = JointKind::Generic { linear: [Axis::FREE; 3], angular: [Axis::FREE; 3] };
    for solver in SOLVERS {
        let mut world = world(solver, 0.0);
        let thrown = body(&mut world, DVec3::ZERO, 2.0, 1.0);
        world.set_linear_velocity(thrown, Vec3::new(3.0, 3.0, 3.0)).expect("a body of the world");
        let mut def = JointDef::new(free, BodyId::NULL, thrown);
        def.axis_friction = [2.0, 0.0, 40.0, 0.0, 0.0, 1.0];
        let joint = world.create_joint(&def).expect("a valid joint");
        steps(&mut world, 1.0);
        let velocity = world.linear_velocity(thrown).expect("a body of the world");
        let expected = Vec3::new(2.0, 3.0, 0.0);
        assert!((velocity - expected).length() < 0.01, "{solver:?}: {velocity}, expected {expected}, bound 0.01 m/s");
        world.set_joint_axis_friction(joint, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]).expect("a joint of the world");
        world.set_linear_velocity(thrown, Vec3::ZERO).expect("a body of the world");
        world.set_angular_velocity(thrown, Vec3::Z * 2.0).expect("a body of the world");
        steps(&mut world, 1.0);
        let spin = world.angular_velocity(thrown).expect("a body of the world").z;
        is_near(f64::from(spin), 1.0, 5.0e-3, "spin about z after a second of 1 N·m (rad/s)");
    }
}

/// A chain that hangs from the world, let go at an angle: links of 1 kg and 0.2 m, and what its end weighs.
fn chain(world: &mut World, kind: JointKind, links: u32, end: f32, tilt: f32, friction: f32) -> Vec<(BodyId, JointId)> {
    let turn = Quat::from_rotation_z(tilt);
    let mut above = BodyId::NULL;
    let mut all = Vec::new();
    for link in 0..links {
        let at = turn * Vec3::NEG_Y * (0.1 + 0.2 * link as f32);
        let mass = if link + 1 == links { end } else { 1.0 };
        let properties = Mass::Properties(MassProperties::new(mass, Vec3::splat(0.005 * mass)));
        let def = BodyDef::dynamic(Pose::at(at.as_dvec3()).rotated(turn)).with_mass(properties);
        let body = world.create_body(&def).expect("a valid body");
        let mut def = JointDef::new(kind, above, body).with_friction(friction);
        let on_a = if above == BodyId::NULL { Pose::IDENTITY.rotated(turn) } else { Pose::at_xyz(0.0, -0.1, 0.0) };
        def.frame_a = on_a.rotated(on_a.rotation * about_z());
        def.frame_b = Pose::at_xyz(0.0, 0.1, 0.0).rotated(about_z());
        all.push((body, world.create_joint(&def).expect("a valid joint")));
        above = body;
    }
    all
}

fn energy(world: &World, bodies: &[(BodyId, JointId)]) -> f64 {
    let one = |&(body, _): &(BodyId, JointId)| {
        let mass = world.mass_properties(body).expect("a body").expect("a dynamic one");
        let (v, w) = (world.linear_velocity(body).expect("a body"), world.angular_velocity(body).expect("a body"));
        let kinetic = 0.5 * (mass.mass * v.length_squared() + mass.principal_inertia.x * w.length_squared());
        f64::from(kinetic) + f64::from(mass.mass * GRAVITY) * world.center_of_mass(body).expect("a body").y
    };
    bodies.iter().map(one).sum()
}

#[test]
fn friction_makes_no_energy_at_any_effort() {
    for solver in SOLVERS {
        for substeps in [1, 4] {
            for kind in [JointKind::HINGE, JointKind::SPHERICAL] {
                for friction in [0.3, 3.0] {
                    let mut world = world_with(solver, GRAVITY, substeps);
                    let links = chain(&mut world, kind, 5, 1.0, 1.4, friction);
                    let start = energy(&world, &links);
                    // Of what it may lose in all: five links that fall by their distance from the point.
                    let scale = f64::from(GRAVITY) * (0.1 + 0.3 + 0.5 + 0.7 + 0.9);
                    let mut highest = f64::NEG_INFINITY;
                    for _ in 0..300 {
                        world.step(DT).expect("a valid step");
                        highest = highest.max(energy(&world, &links));
                    }
                    let rise = (highest - start) / scale;
                    let what = format!("{solver:?}, {substeps} substeps, {kind:?}, {friction} N·m");
                    assert!(rise < 2.0e-3, "{what}: energy rises by {rise} of what there is, bound 0.002");
                    let left = (energy(&world, &links) + scale) / scale;
                    assert!(left < 0.8, "{what}: {left} of its energy left after 5 s of 0.83, bound 0.8");
                }
            }
        }
    }
}

#[test]
fn ten_tonnes_on_a_chain_whose_joints_rub_hang_still() {
    for kind in [JointKind::HINGE, JointKind::SPHERICAL] {
        let mut world = world(Solver::Auto, GRAVITY);
        let links = chain(&mut world, kind, 20, 10_000.0, 0.3, 50.0);
        let mut gap: f32 = 0.0;
        for _ in 0..600 {
            world.step(DT).expect("a valid step");
            gap = gap.max(world.report().residuals.joint_gap);
        }
        assert!(gap < 2.0e-3, "{kind:?}: a gap of {gap} m while it swings, bound 2e-3");
        let lowest = -f64::from(0.1 + 0.2 * 19.0_f32);
        let end = world.center_of_mass(links[19].0).expect("a body of the world");
        let reach = end.length();
        assert!((reach + lowest).abs() < 4.0e-3, "{kind:?}: {reach} m from its point, expected {}, bound 4 mm", -lowest);
    }
}

#[test]
fn a_restored_world_rubs_on_with_the_same_bits() {
    for solver in SOLVERS {
        let mut first = world(solver, GRAVITY);
        chain(&mut first, JointKind::SPHERICAL, 6, 3.0, 1.0, 1.0);
        let driven = JointKind::Hinge { limits: Limits::new(-1.0, 1.0), motor: Motor::Velocity { target: 1.0, max_force: 40.0 } };
        arm(&mut first, driven, 0.2, 5.0);
        steps(&mut first, 0.5);
        let mut bytes = Vec::new();
        first.save(&mut bytes);
        let mut second = world(solver, GRAVITY);
        second.restore(&bytes).expect("a snapshot of this version");
        for step in 0..120 {
            first.step(DT).expect("a valid step");
            second.step(DT).expect("a valid step");
            assert_eq!(first.state_hash(), second.state_hash(), "{solver:?}: step {step} after the restore");
        }
        let joint = second.joints().next().expect("there are joints");
        let def = second.joint_def(joint).expect("a joint of the world");
        assert_eq!(def.friction.to_bits(), 1.0_f32.to_bits(), "{solver:?}: friction is in the snapshot");
    }
}

#[test]
fn friction_that_is_no_friction_is_refused() {
    let mut world = world(Solver::Auto, 0.0);
    let (wheel, joint) = wheel(&mut world, JointKind::HINGE, 0.0, 0.0);
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        let error =
            world.create_joint(&JointDef::new(JointKind::HINGE, BodyId::NULL, wheel).with_friction(bad)).expect_err("bad");
        assert_eq!(error.argument, "friction");
        assert_eq!(world.set_joint_friction(joint, bad).expect_err("bad").argument, "friction");
        let axes = [0.0, 0.0, 0.0, 0.0, bad, 0.0];
        assert_eq!(world.set_joint_axis_friction(joint, axes).expect_err("bad").argument, "axis_friction");
    }
    assert_eq!(world.joint_def(joint).expect("a joint of the world").friction.to_bits(), 0, "a refused call changes nothing");
    let motor = SphericalMotor::Off;
    let kind = JointKind::Spherical { swing_limit: 1.0, twist_limits: Limits::NONE, motor };
    assert!(world.create_joint(&JointDef::new(kind, BodyId::NULL, wheel).with_friction(1.0)).is_ok());
}
