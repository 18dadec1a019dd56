//! What hangs on a body or a stop that the host moves follows it as it starts, stops and turns back at once, and rebounds from it at the speed
//! at which the two meet: by either solver, at any rate.

use longspan::glam::{Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Drive, JointDef, JointKind, Limits, Mass, MassProperties, Motor, Pose, SleepSettings, Solver,
    SphericalMotor, World, WorldDef,
};

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];
const SOLVERS: [Solver; 2] = [Solver::Auto, Solver::GaussSeidel];

fn world(solver: Solver, gravity: f32) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, solver, sleep, ..WorldDef::default() }).expect("a valid world")
}

/// A body of 2 kg whose radius of gyration is 0.3 `size`.
fn load(world: &mut World, at: Vec3, size: f32) -> BodyId {
    let mass = Mass::Properties(MassProperties::new(2.0, Vec3::splat(2.0 * 0.09 * size * size)));
    world.create_body(&BodyDef::dynamic(Pose::at(at.as_dvec3())).with_mass(mass)).expect("a valid body")
}

fn hook(world: &mut World) -> BodyId {
    world.create_body(&BodyDef::kinematic(Pose::IDENTITY)).expect("a valid body")
}

/// How a load hangs straight below a hook.
#[derive(Debug, Clone, Copy)]
enum Hanging {
    Hinge,
    Ball,
    Rope,
    Rod,
    Slider,
    Welded,
}

impl Hanging {
    const ALL: [Self; 6] = [Self::Hinge, Self::Ball, Self::Rope, Self::Rod, Self::Slider, Self::Welded];

    /// Whether it pulls and does not push.
    fn pulls(self) -> bool {
        matches!(self, Self::Rope | Self::Welded | Self::Slider)
    }

    /// Joins a load `size` (m) below the hook; returns it.
    fn hang(self, world: &mut World, hook: BodyId, size: f32) -> BodyId {
        let low = load(world, Vec3::NEG_Y * size, size);
        let down = Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2);
        let limits = |min: f32, max: f32| Limits::new(min * size, max * size);
        let (kind, at_hook, at_load, frame) = match self {
            Self::Hinge => (JointKind::Hinge { limits: Limits::NONE, motor: Motor::Off }, 0.0, 1.0, Quat::IDENTITY),
            Self::Ball => {
                let (swing_limit, twist_limits) = (std::f32::consts::PI, Limits::NONE);
                (JointKind::Spherical { swing_limit, twist_limits, motor: SphericalMotor::Off }, 0.0, 1.0, Quat::IDENTITY)
            }
            Self::Rope | Self::Welded => {
                let kind = JointKind::Distance { limits: limits(0.0, 1.0), spring_length: None, motor: Motor::Off };
                (kind, 0.0, 0.0, Quat::IDENTITY)
            }
            Self::Rod => {
                let kind = JointKind::Distance { limits: limits(1.0, 1.0), spring_length: None, motor: Motor::Off };
                (kind, 0.0, 0.0, Quat::IDENTITY)
            }
            Self::Slider => (JointKind::Prismatic { limits: limits(-1.0, 0.0), motor: Motor::Off }, -1.0, 0.0, down),
        };
        let mut holds = hook;
        if matches!(self, Self::Welded) {
            holds = load(world, Vec3::ZERO, size);
            world.create_joint(&JointDef::new(JointKind::Fixed, hook, holds)).expect("a valid joint");
        }
        let mut def = JointDef::new(kind, holds, low);
        let pose = |up: f32| Pose::at_xyz(0.0, f64::from(up * size), 0.0).rotated(frame);
        (def.frame_a, def.frame_b) = (pose(at_hook), pose(at_load));
        world.create_joint(&def).expect("a valid joint");
        low
    }
}

#[test]
fn what_is_taut_follows_a_hook_that_starts_stops_and_turns_back_at_once() {
    for (hanging, solver) in Hanging::ALL.into_iter().flat_map(|hanging| SOLVERS.map(|solver| (hanging, solver))) {
        for (rate, size) in RATES.into_iter().flat_map(|rate| [0.1, 1.0, 10.0].map(|size| (rate, size))) {
            for (before, after) in [(0.0_f32, 0.7_f32), (0.7, 0.0), (0.7, -0.5), (-0.5, 0.7), (0.7, 1.2)] {
                if hanging.pulls() && after < before {
                    // The load goes on upwards, and its rope hangs loose.
                    continue;
                }
                let mut world = world(solver, 9.81);
                let hook = hook(&mut world);
                let low = hanging.hang(&mut world, hook, size);
                let mut go = |speed: f32, steps: f32| {
                    world.set_linear_velocity(hook, Vec3::Y * speed).expect("a valid velocity");
                    let mut worst = 0.0_f32;
                    for _ in 0..steps as u32 {
                        world.step(1.0 / rate).expect("a valid step");
                        worst = worst.max((world.linear_velocity(low).expect("it is there").y - speed).abs());
                    }
                    worst
                };
                go(before, 0.3 * rate);
                let off = go(after, 0.2 * rate);
                let what = format!("{hanging:?} of {size} m by {solver:?} at {rate}/s, from {before} to {after} m/s");
                // Nothing that is taut stretches, so that it has the hook's speed; 1 % is left to sweeps.
                assert!(off < 0.01 * (after - before).abs(), "{what}: off by {off} m/s");
            }
        }
    }
}

#[test]
fn what_rests_on_a_stop_that_is_raised_rises_with_it() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for size in [0.1, 1.0, 10.0, 30.0] {
            let mut world = world(solver, 9.81);
            let arm = load(&mut world, Vec3::X * (0.5 * size), size);
            let kind = |min: f32| JointKind::Hinge { limits: Limits::new(min, f32::INFINITY), motor: Motor::Off };
            let mut def = JointDef::new(kind(0.0), BodyId::NULL, arm);
            let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
            def.frame_a = Pose::IDENTITY.rotated(about_z);
            def.frame_b = Pose::at_xyz(f64::from(-0.5 * size), 0.0, 0.0).rotated(about_z);
            let joint = world.create_joint(&def).expect("a valid joint");
            (0..rate as u32 / 4).for_each(|_| _ = world.step(1.0 / rate).expect("a valid step"));
            let mut fastest = 0.0_f32;
            for step in 1..=(0.5 * rate) as i32 {
                world.set_joint_kind(joint, kind(0.8 / rate * step as f32)).expect("a valid limit");
                world.step(1.0 / rate).expect("a valid step");
                fastest = fastest.max(world.angular_velocity(arm).expect("it is there").z);
            }
            // 0.8 rad/s; the lever's rounding over 30 m is a tenth of a per cent.
            let what = format!("{size} m by {solver:?} at {rate}/s");
            assert!((fastest - 0.8).abs() < 0.016, "{what}: raised at 0.8 rad/s, {fastest} rad/s");
        }
    }
}

/// The ways in which a load and what it is held by approach each other at 3 m/s.
#[derive(Debug, Clone, Copy)]
enum Approach {
    Load,
    Hook,
    Both,
    Stop,
}

#[test]
fn a_rebound_has_the_speed_at_which_a_load_and_a_moving_hook_or_stop_meet() {
    for (approach, solver) in [Approach::Load, Approach::Hook, Approach::Both, Approach::Stop]
        .into_iter()
        .flat_map(|way| SOLVERS.map(|solver| (way, solver)))
    {
        for (rate, slides) in RATES.into_iter().flat_map(|rate| [(rate, true), (rate, false)]) {
            let moves_stop = matches!(approach, Approach::Stop);
            let [of_hook, of_load] = match approach {
                Approach::Load => [0.0, -3.0],
                Approach::Hook => [3.0, 0.0],
                Approach::Both => [1.0, -2.0],
                Approach::Stop => [0.0, 0.0],
            };
            let mut world = world(solver, 0.0);
            let holds = if moves_stop { BodyId::NULL } else { hook(&mut world) };
            let moved = load(&mut world, Vec3::ZERO, 1.0);
            let kind = |way: f32| match slides {
                true => JointKind::Prismatic { limits: Limits::new(-way, 9.0), motor: Motor::Off },
                false => JointKind::Distance { limits: Limits::new(0.0, 1.0 + way), spring_length: None, motor: Motor::Off },
            };
            let at_hook = if slides { Vec3::ZERO } else { Vec3::X };
            let def = JointDef { restitution: 0.5, ..JointDef::new(kind(0.313), holds, moved).at(at_hook, Vec3::ZERO) };
            let joint = world.create_joint(&def).expect("a valid joint");
            if !moves_stop {
                world.set_linear_velocity(holds, Vec3::X * of_hook).expect("a valid velocity");
            }
            world.set_linear_velocity(moved, Vec3::X * of_load).expect("a valid velocity");
            for step in 1..=(0.25 * rate) as i32 {
                if moves_stop {
                    world.set_joint_kind(joint, kind(0.313 - 3.0 / rate * step as f32)).expect("a valid limit");
                }
                world.step(1.0 / rate).expect("a valid step");
            }
            let speed = world.linear_velocity(moved).expect("it is there").x - if moves_stop { 3.0 } else { of_hook };
            let what = format!("{approach:?} moves, slides: {slides}, by {solver:?} at {rate}/s");
            // Half of 3 m/s; a per cent is left to rounding of when in a substep they meet.
            assert!((speed - 1.5).abs() < 0.015, "{what}: parts at {speed} of 1.5 m/s");
        }
    }
}

/// What moves a load up at once: a servo whose target moves, or a motor that holds a speed.
#[derive(Debug, Clone, Copy)]
enum Start {
    Servo,
    Speed,
}

#[test]
fn what_hangs_on_a_motor_that_starts_at_once_rises_with_it() {
    for (start, rate) in [Start::Servo, Start::Speed].into_iter().flat_map(|start| RATES.map(|rate| (start, rate))) {
        for (size, share) in [0.1_f32, 1.0, 10.0].into_iter().flat_map(|size| [0.3_f32, 3.0, 0.0].map(|share| (size, share))) {
            if matches!(start, Start::Servo) && share > 1.0 {
                // What lags behind its target goes faster to catch up.
                continue;
            }
            let mut world = world(Solver::Auto, 9.81);
            let hook = load(&mut world, Vec3::ZERO, size);
            let low = load(&mut world, Vec3::NEG_Y * size, size);
            let speed = 0.7_f32;
            // What bears both and takes them to the speed within this share of a substep.
            let max_force = 4.0 * (9.81 + speed * 4.0 * rate / share);
            let kind = |target: Option<f32>, velocity: f32| {
                let drive = Drive { target, velocity, ..Drive::at(velocity, max_force) };
                JointKind::Prismatic { limits: Limits::NONE, motor: Motor::Drive(drive) }
            };
            let begin = matches!(start, Start::Servo).then_some(0.0);
            let up = Pose::IDENTITY.rotated(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2));
            let mut def = JointDef::new(kind(begin, 0.0), BodyId::NULL, hook);
            (def.frame_a, def.frame_b) = (up, up);
            let joint = world.create_joint(&def).expect("a valid joint");
            let rope = JointKind::Distance { limits: Limits::new(0.0, size), spring_length: None, motor: Motor::Off };
            world.create_joint(&JointDef::new(rope, hook, low)).expect("a valid joint");
            (0..(0.5 * rate) as u32).for_each(|_| _ = world.step(1.0 / rate).expect("a valid step"));
            for step in 1..=(0.3 * rate) as i32 {
                world.set_joint_kind(joint, kind(begin.map(|_| speed / rate * step as f32), speed)).expect("a valid motor");
                world.step(1.0 / rate).expect("a valid step");
                for body in [hook, low] {
                    let found = world.linear_velocity(body).expect("it is there").y;
                    let what = format!("{start:?} of {size} m with {max_force} N at {rate}/s");
                    assert!((found - speed).abs() < 0.01 * speed, "{what}: after {step} steps {found} m/s of {speed}");
                }
            }
        }
    }
}
