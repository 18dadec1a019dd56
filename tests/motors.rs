//! Motors do what they are documented to do: servos go as fast as their force allows and stop on their target, speed limits hold, targets
//! that move are followed, one-sided motors never push the other way, and all of them tell their true force.

use crate::common::motor_kinds::{KINDS, Kind};
use longspan::glam::{Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Drive, ForceSide, JointAxisState, JointDef, JointId, JointKind, Limits, Mass, MassProperties, Motor, Pose,
    SleepSettings, Softness, Solver, World, WorldDef,
};

const SOLVERS: [Solver; 2] = [Solver::Auto, Solver::GaussSeidel];
const RATES: [f32; 3] = [30.0, 60.0, 240.0];
const MASS: f32 = 2.0;
const INERTIA: f32 = 0.1;
/// From a hinge to the centre of mass of what it carries (m).
const LEVER: f32 = 0.5;

struct Rig {
    world: World,
    body: BodyId,
    joint: JointId,
    axis: u32,
    /// What the coordinate begins at, and what a unit of force accelerates it by.
    begin: f32,
    ease: f32,
}

/// A body whose coordinate points up along y, or a door whose lever lies level at zero; `gravity` along −y (m/s²).
fn rig(kind: Kind, motor: Motor, limits: Limits, gravity: f32, solver: Solver, substeps: u32) -> Rig {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let def = WorldDef { gravity: Vec3::NEG_Y * gravity, solver, sleep, substeps, ..WorldDef::default() };
    let mut world = World::new(&def).expect("a valid world");
    let properties = MassProperties {
        mass: MASS,
        center_of_mass: Vec3::ZERO,
        principal_inertia: Vec3::splat(INERTIA),
        inertia_frame: Quat::IDENTITY,
    };
    let turns = kind.turns();
    let start = if turns { Pose::at_xyz(f64::from(LEVER), 0.0, 0.0) } else { Pose::IDENTITY };
    let body = world.create_body(&BodyDef::dynamic(start).with_mass(Mass::Properties(properties))).expect("a valid body");
    let (kind_of, frame) = kind.joint(motor, limits);
    let mut def = JointDef::new(kind_of, BodyId::NULL, body);
    let lever = if turns { f64::from(LEVER) } else { 0.0 };
    let below = if kind == Kind::Distance { -0.5 } else { 0.0 };
    (def.frame_a, def.frame_b) = (Pose::at_xyz(0.0, below, 0.0).rotated(frame), Pose::at_xyz(-lever, 0.0, 0.0).rotated(frame));
    let joint = world.create_joint(&def).expect("a valid joint");
    let axis = kind.axis();
    let begin = if kind == Kind::Distance { 0.5 } else { 0.0 };
    let ease = if turns { 1.0 / (INERTIA + MASS * LEVER * LEVER) } else { 1.0 / MASS };
    Rig { world, body, joint, axis, begin, ease }
}

impl Rig {
    fn step(&mut self, dt: f32) -> JointAxisState {
        self.world.step(dt).expect("a valid step");
        let mut state = self.world.joint_axis_state(self.joint, self.axis).expect("the joint has this axis");
        state.position -= self.begin;
        state
    }
}

fn servo(kind: Kind, target: f32, max_force: f32) -> Motor {
    let begin = if kind == Kind::Distance { 0.5 } else { 0.0 };
    Motor::Position { target: target + begin, softness: Softness::RIGID, max_force }
}

/// Steps until a servo stays within 0.1 % of its target, and what it overshot by.
fn arrival(rig: &mut Rig, target: f32, dt: f32, most: u32) -> (u32, f32, JointAxisState) {
    let (mut last_away, mut over, mut state) = (0, 0.0_f32, JointAxisState::default());
    for step in 1..=most {
        state = rig.step(dt);
        if (state.position - target).abs() > 1.0e-3 * target {
            last_away = step;
        }
        over = over.max(state.position - target);
    }
    (last_away + 1, over, state)
}

#[test]
fn a_servo_is_as_fast_as_its_force_allows_and_stops_on_its_target() {
    for kind in KINDS {
        for (rate, substeps) in [(30.0_f32, 4), (60.0, 4), (60.0, 1), (60.0, 16), (240.0, 4)] {
            for (force, target) in [(10.0_f32, 0.7_f32), (300.0, 1.0), (1.0e4, 1.0), (1.0e6, 0.8)] {
                let mut rig = rig(kind, servo(kind, target, force), Limits::NONE, 0.0, Solver::Auto, substeps);
                let least = 2.0 * (target / (force * rig.ease)).sqrt();
                let (steps, over, state) = arrival(&mut rig, target, 1.0 / rate, ((2.0 * least + 0.2) * rate) as u32 + 8);
                let time = steps as f32 / rate;
                // What is left for braking costs 2.7 %; rests are told at the ends of steps, and force is even for a substep.
                let bound = 1.05 * least + 2.0 / rate;
                let what = format!("{kind:?}, {force} N over {target} at {rate} Hz in {substeps} substeps");
                assert!(time <= bound, "{what}: {time} s, mechanics allow {least} s, bound {bound} s");
                assert!(over <= 1.0e-4, "{what}: overshoots by {over}");
                assert!((state.position - target).abs() < 1.0e-5 && state.velocity.abs() < 1.0e-4, "{what}: rests at {state:?}");
            }
        }
    }
}

#[test]
fn a_servo_lifts_and_lowers_its_load_without_overshoot() {
    for (kind, solver) in KINDS.into_iter().flat_map(|kind| SOLVERS.map(|solver| (kind, solver))) {
        for (rate, way) in RATES.into_iter().flat_map(|rate| [(rate, 1.0), (rate, -1.0)]) {
            let (gravity, force) = (9.81, 40.0);
            let target = if kind == Kind::Distance && way < 0.0 { -0.4 } else { 0.8 * way };
            let mut rig = rig(kind, servo(kind, target, force), Limits::NONE, gravity, solver, 4);
            let (mut over, mut state, mut greatest) = (0.0_f32, JointAxisState::default(), 0.0_f32);
            for _ in 0..(3.0 * rate) as u32 {
                state = rig.step(1.0 / rate);
                over = over.max((state.position - target) * way);
                greatest = greatest.max(state.motor.abs());
            }
            let what = format!("{kind:?} to {target} at {rate} Hz by {solver:?}");
            // A lever's weight changes as it turns, and sweeps keep a carried multiplier.
            let bound = if solver == Solver::Auto { 2.0e-3 } else { 1.0e-2 };
            assert!(over < bound, "{what}: overshoots by {over}");
            assert!((state.position - target).abs() < 1.0e-3, "{what}: rests at {state:?}");
            assert!(greatest <= force * 1.001, "{what}: pushes with {greatest} N of {force} N");
            let load = match kind {
                Kind::Hinge | Kind::Turn => MASS * gravity * LEVER * target.cos(),
                _ => MASS * gravity,
            };
            assert!((state.motor - load).abs() < 0.02 * MASS * gravity, "{what}: tells {} N for a load of {load} N", state.motor);
        }
    }
}

fn drive(kind: Kind, target: f32, drive: Drive) -> Motor {
    let begin = if kind == Kind::Distance { 0.5 } else { 0.0 };
    Motor::Drive(Drive { target: Some(target + begin), ..drive })
}

#[test]
fn a_position_motor_keeps_its_speed_limit() {
    let soft = Softness { compliance: 1.0 / 400.0, damping: 20.0 };
    for (kind, solver) in KINDS.into_iter().flat_map(|kind| SOLVERS.map(|solver| (kind, solver))) {
        for (rate, softness) in [30.0, 60.0, 120.0, 240.0].into_iter().flat_map(|rate| [(rate, Softness::RIGID), (rate, soft)]) {
            let told = Drive { softness, max_speed: 0.5, ..Drive::to(0.0, 500.0) };
            let mut rig = rig(kind, drive(kind, 1.0, told), Limits::NONE, 0.0, solver, 4);
            let (mut fastest, mut state) = (0.0_f32, JointAxisState::default());
            for _ in 0..(5.0 * rate) as u32 {
                state = rig.step(1.0 / rate);
                fastest = fastest.max(state.velocity);
            }
            let what = format!("{kind:?} at {rate} Hz by {solver:?}, {softness:?}");
            // Two sweeps leave a share of the force with which a lever's points answer a stiff spring.
            let bound = if solver == Solver::Auto { 0.51 } else { 0.6 };
            assert!((0.48..=bound).contains(&fastest), "{what}: {fastest} of 0.5 m/s, bound {bound} m/s");
            assert!((state.position - 1.0).abs() < 5.0e-3, "{what}: rests at {state:?}");
        }
    }
}

#[test]
fn a_motor_follows_a_target_that_moves() {
    let soft = Softness { compliance: 1.0 / 400.0, damping: 60.0 };
    for (kind, rate) in KINDS.into_iter().flat_map(|kind| RATES.map(|rate| (kind, rate))) {
        for softness in [Softness::RIGID, soft] {
            let speed = 0.6;
            let told = Drive { softness, velocity: speed, ..Drive::to(0.0, 1000.0) };
            let mut rig = rig(kind, drive(kind, 0.0, told), Limits::NONE, 0.0, Solver::Auto, 4);
            for step in 1..=(2.0 * rate) as u32 {
                let target = speed * step as f32 / rate;
                let def = rig.world.joint_def(rig.joint).expect("the joint stays");
                let motor = drive(kind, target, told);
                let kind_now = match def.kind {
                    JointKind::Hinge { limits, .. } => JointKind::Hinge { limits, motor },
                    JointKind::Prismatic { limits, .. } => JointKind::Prismatic { limits, motor },
                    JointKind::Distance { limits, spring_length, .. } => JointKind::Distance { limits, spring_length, motor },
                    JointKind::Generic { mut linear, mut angular } => {
                        let axes = if kind == Kind::Slide { &mut linear } else { &mut angular };
                        axes[if kind == Kind::Slide { 1 } else { 2 }].motor = motor;
                        JointKind::Generic { linear, angular }
                    }
                    other => other,
                };
                rig.world.set_joint_kind(rig.joint, kind_now).expect("the same kind");
                let state = rig.step(1.0 / rate);
                let (off, time) = ((state.position - target).abs(), step as f32 / rate);
                let what = format!("{kind:?} at {rate} Hz, {softness:?}, after {time} s");
                if time > 1.0 {
                    assert!(off < 2.0e-3, "{what}: {off} behind its target");
                    assert!((state.velocity - speed).abs() < 0.02, "{what}: at {} of {speed} m/s", state.velocity);
                }
            }
        }
    }
}

#[test]
fn a_motor_that_only_pulls_lifts_and_never_pushes() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        // Hangs 0.5 m below; the distance is shortened.
        let told = Drive { target: Some(0.2), side: ForceSide::Pull, ..Drive::to(0.2, 60.0) };
        let mut rig = rig(Kind::Distance, Motor::Drive(told), Limits::NONE, -9.81, solver, 4);
        let mut state = JointAxisState::default();
        for _ in 0..(3.0 * rate) as u32 {
            state = rig.step(1.0 / rate);
            assert!(state.motor <= 1.0e-3, "{solver:?} at {rate} Hz: pushes with {} N", state.motor);
        }
        assert!((state.position + 0.3).abs() < 2.0e-3, "{solver:?} at {rate} Hz: holds at {state:?}");
        assert!((state.motor + MASS * 9.81).abs() < 0.4, "{solver:?} at {rate} Hz: tells {} N", state.motor);
        // Thrown up, it is not held back.
        rig.world.set_linear_velocity(rig.body, Vec3::NEG_Y * 1.0).expect("the body stays");
        let thrown = rig.step(1.0 / rate);
        assert!(thrown.velocity < -0.3 && thrown.motor.abs() < 1.0e-3, "{solver:?} at {rate} Hz: thrown towards, {thrown:?}");
    }
}

#[test]
fn a_motor_tells_its_own_force_where_a_stop_takes_it_up() {
    for (kind, solver) in KINDS.into_iter().flat_map(|kind| SOLVERS.map(|solver| (kind, solver))) {
        let begin = if kind == Kind::Distance { 0.5 } else { 0.0 };
        // A spring to beyond its stop: 400 N/m over 0.2 m.
        let motor = Motor::Drive(Drive {
            target: Some(begin),
            softness: Softness { compliance: 1.0 / 400.0, damping: 10.0 },
            ..Drive::to(0.0, f32::INFINITY)
        });
        let limits = Limits::new(begin + 0.2, begin + 1.0);
        let mut rig = rig(kind, motor, limits, 0.0, solver, 4);
        let mut state = JointAxisState::default();
        for _ in 0..120 {
            state = rig.step(1.0 / 60.0);
        }
        // A spring presses on the stop, which takes it up.
        assert!((state.position - 0.2).abs() < 1.0e-3, "{kind:?} by {solver:?}: {state:?}");
        assert!((state.motor + 80.0).abs() < 1.0 && state.effort.abs() < 1.0, "{kind:?} by {solver:?}: {state:?}");
        let mut pressed = state;
        for _ in 0..10 {
            rig.world.add_force(rig.body, Vec3::Y * -50.0).expect("the body stays");
            pressed = rig.step(1.0 / 60.0);
        }
        let load = if matches!(kind, Kind::Hinge | Kind::Turn) { 50.0 * LEVER * 0.2_f32.cos() } else { 50.0 };
        assert!((pressed.effort - load).abs() < 0.05 * load, "{kind:?} by {solver:?}: {pressed:?} under {load} N");
        assert!((pressed.motor + 80.0).abs() < 0.1 * load, "{kind:?} by {solver:?}: the stop takes it, told {} N", pressed.motor);
    }
}

#[test]
fn servos_of_an_arm_brake_what_hangs_on_them() {
    let targets = [0.8_f32, -0.5, 0.6];
    for rate in RATES {
        for force in [200.0_f32, 2.0e3, 2.0e4] {
            let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
            let def = WorldDef { gravity: Vec3::NEG_Y * 9.81, sleep, ..WorldDef::default() };
            let mut world = World::new(&def).expect("a valid world");
            let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
            let (mut before, mut joints) = (BodyId::NULL, Vec::new());
            for (link, &target) in targets.iter().enumerate() {
                let mass = if link == 2 { 5.0 } else { 2.0 };
                let inertia = mass / 12.0 * Vec3::new(0.02, 0.26, 0.26);
                let properties = MassProperties {
                    mass,
                    center_of_mass: Vec3::ZERO,
                    principal_inertia: inertia,
                    inertia_frame: Quat::IDENTITY,
                };
                let pose = Pose::at_xyz(0.25 + 0.5 * link as f64, 0.0, 0.0);
                let body =
                    world.create_body(&BodyDef::dynamic(pose).with_mass(Mass::Properties(properties))).expect("a valid body");
                let motor = Motor::Position { target, softness: Softness::RIGID, max_force: force };
                let mut def = JointDef::new(JointKind::Hinge { limits: Limits::NONE, motor }, before, body);
                let end = if link == 0 { 0.0 } else { 0.25 };
                (def.frame_a, def.frame_b) =
                    (Pose::at_xyz(end, 0.0, 0.0).rotated(about_z), Pose::at_xyz(-0.25, 0.0, 0.0).rotated(about_z));
                joints.push(world.create_joint(&def).expect("a valid joint"));
                before = body;
            }
            let mut over = 0.0_f32;
            for _ in 0..(5.0 * rate) as u32 {
                world.step(1.0 / rate).expect("a valid step");
                for (&joint, target) in joints.iter().zip(targets) {
                    let state = world.joint_axis_state(joint, 0).expect("a hinge has one");
                    over = over.max((state.position - target) * target.signum());
                }
            }
            let what = format!("an arm with {force} N·m at {rate} Hz");
            let off = joints.iter().zip(targets).map(|(&joint, target)| {
                let state = world.joint_axis_state(joint, 0).expect("a hinge has one");
                (state.position - target).abs() + state.velocity.abs()
            });
            let worst = off.fold(0.0, f32::max);
            // Two hundred N·m carry the arm, but hardly brake it; beyond, servos know what they have set going.
            assert!(over < 0.15, "{what}: overshoots by {over} rad, bound 0.15");
            assert!(worst < 1.0e-3, "{what}: off by {worst} rad and rad/s after 5 s");
        }
    }
}

/// A rope that is taut and a motor that pulls at it contradict each other, as a drum that jams does.
#[test]
fn a_motor_that_a_rope_stops_tells_its_force_and_no_speed() {
    for (kind, solver) in
        [Kind::Hinge, Kind::Slider, Kind::Slide, Kind::Turn].into_iter().flat_map(|kind| SOLVERS.map(|s| (kind, s)))
    {
        // Sweeps bring a motor to its bound in seconds where it would reach its speed in less than a substep, and that of a six-axis joint
        // trembles there by 5 cm/s.
        let forces: &[f32] = match (solver, kind) {
            (Solver::Auto, _) => &[50.0, 200.0, 1.0e5],
            (_, Kind::Turn) => &[],
            _ => &[50.0],
        };
        for (rate, &force) in RATES.into_iter().flat_map(|rate| forces.iter().map(move |force| (rate, force))) {
            let mut rig = rig(kind, Motor::Velocity { target: 2.0, max_force: force }, Limits::NONE, 0.0, solver, 4);
            // To its outer end, straight below that at first, and slack by a tenth.
            let end = if matches!(kind, Kind::Hinge | Kind::Turn) { Vec3::X * 2.0 * LEVER } else { Vec3::ZERO };
            let reach = JointKind::Distance { limits: Limits::new(0.0, 1.1), spring_length: None, motor: Motor::Off };
            let mut rope = JointDef::new(reach, BodyId::NULL, rig.body).at(end - Vec3::Y, Vec3::ZERO);
            rope.frame_b = Pose::at((end - rig.world.pose(rig.body).expect("it stays").position.as_vec3()).as_dvec3());
            let rope = rig.world.create_joint(&rope).expect("a valid joint");
            let mut state = JointAxisState::default();
            for _ in 0..(2.0 * rate) as u32 {
                state = rig.step(1.0 / rate);
            }
            let what = format!("{kind:?} with {force} N at {rate} Hz by {solver:?}");
            assert!(state.velocity.abs() < 5.0e-3, "{what}: tells {} m/s and stands", state.velocity);
            assert!((state.motor / force - 1.0).abs() < 1.0e-2, "{what}: tells {} N", state.motor);
            let pull = rig.world.joint_state(rope).expect("it stays").force.length();
            let lever = if matches!(kind, Kind::Hinge | Kind::Turn) { 2.0 * LEVER } else { 1.0 };
            // The rope is a hundredth askew; what two sweeps leave a six-axis joint to bear is up to a sixth of it.
            let bound = if solver == Solver::Auto { 0.02 } else { 0.2 };
            assert!((pull * lever / force - 1.0).abs() < bound, "{what}: the rope bears {pull} N, bound {bound} of it");
        }
    }
}

#[test]
fn a_motor_that_pushes_one_way_comes_to_its_speed_and_no_further() {
    for (kind, solver) in KINDS.into_iter().flat_map(|kind| SOLVERS.map(|solver| (kind, solver))) {
        for (rate, way) in RATES.into_iter().flat_map(|rate| [(rate, 1.0), (rate, -1.0)]) {
            for max_force in [20.0, 2000.0, f32::INFINITY] {
                let side = if way > 0.0 { ForceSide::Push } else { ForceSide::Pull };
                let velocity = if kind == Kind::Distance { 0.2 } else { 1.0 } * way;
                let motor = Motor::Drive(Drive { side, ..Drive::at(velocity, max_force) });
                let mut rig = rig(kind, motor, Limits::NONE, 0.0, solver, 4);
                let (mut fastest, mut state) = (0.0_f32, JointAxisState::default());
                for _ in 0..(1.0 * rate) as u32 {
                    state = rig.step(1.0 / rate);
                    fastest = fastest.max(state.velocity * way);
                }
                let what = format!("{kind:?} to {velocity} with {max_force} N at {rate} Hz by {solver:?}");
                let share = fastest / velocity.abs();
                // Second order went on with half of what the motor had given: 1.49 and 1.51 of it.
                assert!(
                    share < 1.001 && state.velocity * way > 0.999 * velocity.abs(),
                    "{what}: {share} of it, {state:?} in the end"
                );
            }
        }
    }
}

/// What else holds the lid of [`a_servo_moves_what_other_joints_hold_as_well`].
#[derive(Debug, Clone, Copy)]
enum SecondHold {
    Hinge,
    Ball,
    SlackRope,
    Servo,
}

#[test]
fn a_servo_moves_what_other_joints_hold_as_well() {
    let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let target = 0.3;
    for second in [SecondHold::Hinge, SecondHold::Ball, SecondHold::SlackRope, SecondHold::Servo] {
        for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
            for size in [0.1_f32, 1.0, 10.0] {
                let (mass, gravity) = (20.0 * size.powi(3), 9.81);
                let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
                let def = WorldDef { gravity: Vec3::NEG_Y * gravity, solver, sleep, ..WorldDef::default() };
                let mut world = World::new(&def).expect("a valid world");
                let properties = MassProperties::new(mass, Vec3::splat(0.1 * mass * size * size));
                let lid = BodyDef::dynamic(Pose::at_xyz(f64::from(size), 0.0, 0.0)).with_mass(Mass::Properties(properties));
                let lid = world.create_body(&lid).expect("a valid body");
                let mut hold = |kind: JointKind, along: f32| {
                    let mut def = JointDef::new(kind, BodyId::NULL, lid);
                    def.frame_a = Pose::at_xyz(0.0, 0.0, f64::from(along)).rotated(about_z);
                    def.frame_b = Pose::at_xyz(f64::from(-size), 0.0, f64::from(along)).rotated(about_z);
                    world.create_joint(&def).expect("a valid joint")
                };
                let (limits, load) = (Limits::NONE, mass * gravity * size);
                let motor = Motor::Position { target, softness: Softness::RIGID, max_force: 3.0 * load };
                let servo = hold(JointKind::Hinge { limits, motor }, -0.5 * size);
                let kind = match second {
                    SecondHold::Hinge => JointKind::Hinge { limits, motor: Motor::Off },
                    SecondHold::Ball => {
                        let (swing_limit, motor) = (std::f32::consts::PI, longspan::SphericalMotor::Off);
                        JointKind::Spherical { swing_limit, twist_limits: limits, motor }
                    }
                    SecondHold::SlackRope => {
                        JointKind::Distance { limits: Limits::new(0.0, size), spring_length: None, motor: Motor::Off }
                    }
                    SecondHold::Servo => JointKind::Hinge { limits, motor },
                };
                hold(kind, 0.5 * size);
                let mut over = 0.0_f32;
                // Mechanics allow 0.3 s √(size/m), and sweeps close a tenth of what is left in a substep.
                let steps = ((0.8 * size.sqrt() + 0.5) * rate) as u32;
                for _ in 0..steps {
                    world.step(1.0 / rate).expect("a valid step");
                    over = over.max(world.joint_axis_state(servo, 0).expect("the joint has this axis").position - target);
                }
                let state = world.joint_axis_state(servo, 0).expect("the joint has this axis");
                let what = format!("{second:?}, {size} m by {solver:?} at {rate}/s");
                assert!((state.position - target).abs() < 2.0e-3, "{what}: after {steps} steps at {} rad", state.position);
                // As of a servo without a second joint, above.
                assert!(over < 1.0e-2, "{what}: overshoots by {over} rad");
            }
        }
    }
}

#[test]
fn a_spring_stretched_beyond_its_stop_presses_on_it_and_yields_to_more() {
    for (kind, solver) in KINDS.into_iter().flat_map(|kind| SOLVERS.map(|solver| (kind, solver))) {
        for rate in RATES {
            let begin = if kind == Kind::Distance { 0.5 } else { 0.0 };
            let softness = Softness { compliance: 0.01, damping: 5.0 };
            let motor = Motor::Position { target: begin + 1.0, softness, max_force: f32::INFINITY };
            let mut rig = rig(kind, motor, Limits::new(begin - 1.0, begin + 0.2), 0.0, solver, 4);
            let mut under = |push: f32| {
                let mut state = JointAxisState::default();
                for _ in 0..(3.0 * rate) as u32 {
                    if kind.turns() {
                        rig.world.add_torque(rig.body, Vec3::NEG_Z * push).expect("a valid torque");
                    } else {
                        rig.world.add_force(rig.body, Vec3::NEG_Y * push).expect("a valid force");
                    }
                    state = rig.step(1.0 / rate);
                }
                state
            };
            let what = format!("{kind:?} by {solver:?} at {rate}/s");
            // 100 N/m, or N·m/rad, over 0.8.
            let (alone, pushed, overcome) = (under(0.0), under(40.0), under(100.0));
            // Sweeps do not say which of the two takes how much of what they press on each other with.
            assert!(solver != Solver::Auto || (alone.motor - 80.0).abs() < 0.8, "{what}: presses with {} of 80", alone.motor);
            assert!((pushed.position - 0.2).abs() < 1.0e-3, "{what}: pushed with 40 it stands at {} of 0.2", pushed.position);
            assert!(overcome.position.abs() < 0.01, "{what}: pushed with 100 it stands at {} of 0", overcome.position);
        }
    }
}
