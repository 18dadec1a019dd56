//! Joints do at every scale, rate and mass what they do at that of a crate: from what is a centimetre long to what is a hundred metres.

use longspan::glam::{Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, BodyKind, JointDef, JointId, JointKind, Limits, Mass, MassProperties, Motor, Pose, Softness, Solver,
    SphericalMotor, World, WorldDef,
};

const SOLVERS: [Solver; 2] = [Solver::Auto, Solver::GaussSeidel];
const RATES: [f32; 3] = [30.0, 60.0, 240.0];
const SCALES: [f32; 3] = [0.01, 1.0, 100.0];

fn world(solver: Solver, gravity: f32) -> World {
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, solver, ..WorldDef::default() }).expect("a valid world")
}

/// A cube with an edge of 0.4 `scale` (m).
fn cube(world: &mut World, at: Vec3, mass: f32, scale: f32) -> BodyId {
    let properties = MassProperties::new(mass, Vec3::splat(0.027 * mass * scale * scale));
    let def = BodyDef::dynamic(Pose::at(at.as_dvec3())).with_mass(Mass::Properties(properties));
    world.create_body(&def).expect("a valid body")
}

fn hub(world: &mut World) -> BodyId {
    world.create_body(&BodyDef { kind: BodyKind::Kinematic, ..BodyDef::dynamic(Pose::IDENTITY) }).expect("a valid body")
}

fn steps(world: &mut World, rate: f32, seconds: f32) {
    for _ in 0..(seconds * rate).round() as u32 {
        world.step(1.0 / rate).expect("a valid step");
    }
}

fn rope(max: f32, motor: Motor) -> JointKind {
    JointKind::Distance { limits: Limits::new(0.0, max), spring_length: None, motor }
}

/// Joints on which a load may hang.
fn hangers(scale: f32) -> [(&'static str, JointKind); 7] {
    let locked = [Axis::LOCKED; 3];
    [
        ("ball joint", JointKind::SPHERICAL),
        ("hinge", JointKind::HINGE),
        ("rope", rope(0.5 * scale, Motor::Off)),
        ("rope without length", rope(0.0, Motor::Off)),
        ("weld", JointKind::Fixed),
        ("six locked axes", JointKind::Generic { linear: locked, angular: locked }),
        ("six-axis ball", JointKind::Generic { linear: locked, angular: [Axis::FREE; 3] }),
    ]
}

#[test]
fn what_hangs_on_a_hub_follows_it_at_every_scale() {
    for (scale, solver) in SCALES.into_iter().flat_map(|scale| SOLVERS.map(|solver| (scale, solver))) {
        for ((name, kind), mass) in hangers(scale).into_iter().flat_map(|hanger| [(hanger, 0.01), (hanger, 1.0e4)]) {
            let (mut world, rate) = (world(solver, 9.81), 60.0);
            let hub = hub(&mut world);
            let load = cube(&mut world, Vec3::NEG_Y * scale, mass, scale);
            let def = JointDef::new(kind, hub, load).at(Vec3::ZERO, Vec3::Y * scale);
            let joint = world.create_joint(&def).expect("a valid joint");
            steps(&mut world, rate, 2.0);
            world.set_linear_velocity(hub, Vec3::X * 0.3 * scale).expect("a valid velocity");
            let (mut worst, mut is_awake) = (0.0_f32, true);
            for _ in 0..60 {
                world.step(1.0 / rate).expect("a valid step");
                worst = worst.max(world.joint_state(joint).expect("it stays").gap / scale);
                is_awake &= world.is_awake(load).expect("it stays");
            }
            let what = format!("{mass} kg on a {name} of {scale} m by {solver:?}");
            assert!(is_awake, "{what}: sleeps while its hub moves");
            // What sweeps are off by where a load of 100 m is yanked to 30 m/s between two steps.
            let bound = if solver == Solver::Auto { 1.0e-3 } else { 1.0e-2 };
            assert!(worst < bound, "{what}: open by {worst} of its size, bound {bound}");
        }
    }
}

#[test]
fn a_rope_that_is_reeled_in_to_nothing_holds_as_a_ball_joint_does() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for (length, mass) in [0.0, 1.0e-5, 1.0e-4].into_iter().flat_map(|length| [(length, 0.01), (length, 1.0e4)]) {
            let mut world = world(solver, 9.81);
            let load = cube(&mut world, Vec3::NEG_Y, mass, 1.0);
            let def = JointDef::new(rope(length, Motor::Off), BodyId::NULL, load).at(Vec3::ZERO, Vec3::Y);
            let joint = world.create_joint(&def).expect("a valid joint");
            steps(&mut world, rate, 1.5);
            let (state, weights) = (world.joint_state(joint).expect("it stays"), 1.0 / (9.81 * mass));
            let what = format!("{mass} kg on {length} m of rope at {rate} Hz by {solver:?}");
            assert!(state.gap < 1.0e-5, "{what}: {} m too long", state.gap);
            assert!((state.force.length() * weights - 1.0).abs() < 1.0e-2, "{what}: bears {:?}", state.force * weights);
            assert!(!world.is_awake(load).expect("it stays"), "{what}: does not come to rest");
        }
    }
}

#[test]
fn a_winch_draws_in_what_swings_round_it_at_its_speed() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for (scale, mass) in [(0.01, 1.0), (1.0, 1.0e-2), (10.0, 1.0e4)] {
            let mut world = world(solver, 0.0);
            let ball = cube(&mut world, Vec3::X * 5.0 * scale, mass, scale);
            world.set_linear_velocity(ball, Vec3::Y * 2.0 * scale).expect("a valid velocity");
            let motor = Motor::Velocity { target: -scale, max_force: 1.0e3 * mass * scale };
            world.create_joint(&JointDef::new(rope(f32::INFINITY, motor), BodyId::NULL, ball)).expect("a valid joint");
            steps(&mut world, rate, 3.0);
            let place = world.pose(ball).expect("it stays").position.as_vec3() / scale;
            let velocity = world.linear_velocity(ball).expect("it stays") / scale;
            let (length, spin) = (place.length(), place.cross(velocity).z);
            let what = format!("{mass} kg, {scale} m at {rate} Hz by {solver:?}");
            assert!((length - 2.0).abs() < 5.0e-3, "{what}: {length} of 2 lengths are left");
            assert!((spin - 10.0).abs() < 0.1, "{what}: angular momentum {spin} of 10");
            let radial = place.dot(velocity) / length;
            assert!((radial + 1.0).abs() < 0.06, "{what}: tells {radial} of -1");
        }
    }
}

#[test]
fn a_weld_whose_frame_moves_gives_its_body_the_speed_and_takes_it_along() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for (scale, mass) in [(0.01, 0.01), (1.0, 1.0), (10.0, 1.0e4)] {
            let mut world = world(solver, 9.81 * scale);
            let body = cube(&mut world, Vec3::ZERO, mass, scale);
            let joint = world.create_joint(&JointDef::new(JointKind::Fixed, BodyId::NULL, body)).expect("a valid joint");
            let what = format!("{mass} kg, {scale} m at {rate} Hz by {solver:?}");
            let mut place = 0.0;
            for _ in 0..rate as u32 {
                place += f64::from(2.0 * scale / rate);
                world.set_joint_frames(joint, Pose::at_xyz(place, 0.0, 0.0), Pose::IDENTITY).expect("valid frames");
                world.step(1.0 / rate).expect("a valid step");
            }
            let speed = world.linear_velocity(body).expect("it stays").x / scale;
            assert!((speed - 2.0).abs() < 0.02, "{what}: tells {speed} of 2");
            let behind = (place - world.pose(body).expect("it stays").position.x) as f32 / scale;
            assert!(behind.abs() < 1.0e-2, "{what}: {behind} behind its frame");
            steps(&mut world, rate, 1.0);
            let (at, speed) = (world.pose(body).expect("it stays").position.x, world.linear_velocity(body).expect("it stays"));
            let off = (at - place) as f32 / scale;
            assert!(off.abs() < 1.0e-4 && speed.length() < 1.0e-3 * scale, "{what}: stops {off} off, at {speed} m/s");
        }
    }
}

#[test]
fn a_twist_counts_turns_where_swing_is_limited() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        let mut world = world(solver, 0.0);
        let wheel = cube(&mut world, Vec3::ZERO, 1.0, 1.0);
        world.set_angular_velocity(wheel, Vec3::X * 20.0).expect("a valid velocity");
        let kind = JointKind::Spherical { swing_limit: 0.5, twist_limits: Limits::NONE, motor: SphericalMotor::Off };
        let joint = world.create_joint(&JointDef::new(kind, BodyId::NULL, wheel)).expect("a valid joint");
        steps(&mut world, rate, 3.0);
        let twist = world.joint_axis_state(joint, 0).expect("a twist").position;
        assert!((twist - 60.0).abs() < 0.1, "at {rate} Hz by {solver:?}: {twist} of 60 rad");
    }
}

/// A spring whose overshoot is a few millimetres stands still for a moment where it turns back, and is slow all the way.
#[test]
fn a_spring_of_a_centimetre_sleeps_where_it_balances() {
    let spring = Softness { compliance: 0.1, damping: 3.0 };
    let motor = Motor::Position { target: 0.01, softness: spring, max_force: f32::INFINITY };
    let driven = Axis { limits: Limits::NONE, motor };
    let kinds = [
        ("slider", JointKind::Prismatic { limits: Limits::NONE, motor }),
        ("six-axis slide", JointKind::Generic { linear: [driven, Axis::LOCKED, Axis::LOCKED], angular: [Axis::LOCKED; 3] }),
    ];
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for (name, kind) in kinds {
            let mut world = world(solver, 9.81);
            let body = cube(&mut world, Vec3::ZERO, 1.0, 0.01);
            let mut def = JointDef::new(kind, BodyId::NULL, body);
            (def.frame_a.rotation, def.frame_b.rotation) = (Quat::IDENTITY, Quat::IDENTITY);
            let joint: JointId = world.create_joint(&def).expect("a valid joint");
            steps(&mut world, rate, 12.0);
            let left = world.joint_axis_state(joint, 0).expect("it has one").position - 0.01;
            let what = format!("a {name} at {rate} Hz by {solver:?}");
            assert!(left.abs() < 1.5e-4, "{what}: {left} m are left, bound 0.15 mm");
            assert!(!world.is_awake(body).expect("it stays"), "{what}: does not sleep");
        }
    }
}

/// A rod of a centimetre that is let go turns by more than a radian in its first step at 30 steps a second.
#[test]
fn a_small_pendulum_that_is_let_go_begins_with_its_energy() {
    for (rate, from) in
        [30.0, 60.0, 240.0_f32].into_iter().flat_map(|rate| [0.3, 1.0, 1.5, 2.0, 2.8_f32].map(|from| (rate, from)))
    {
        for length in [0.01, 0.02, 0.05_f32] {
            let mut world = world(Solver::Auto, 9.81);
            let turn = Quat::from_rotation_z(from - std::f32::consts::FRAC_PI_2);
            let middle = (turn * (Vec3::X * (0.5 * length))).as_dvec3();
            let inertia = length * length / 12.0;
            let mass = Mass::Properties(MassProperties::new(1.0, Vec3::splat(inertia)));
            let rod = world.create_body(&BodyDef::dynamic(Pose::at(middle).rotated(turn)).with_mass(mass)).expect("a valid body");
            let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
            let mut def = JointDef::new(JointKind::HINGE, BodyId::NULL, rod);
            def.frame_a = Pose::IDENTITY.rotated(about_z);
            def.frame_b = Pose::at_xyz(f64::from(-0.5 * length), 0.0, 0.0).rotated(about_z);
            world.create_joint(&def).expect("a valid joint");
            let energy = |world: &World| {
                let (speed, turn) = (
                    world.linear_velocity(rod).expect("it is there").length(),
                    world.angular_velocity(rod).expect("it is there").length(),
                );
                let height = world.pose(rod).expect("it is there").position.y;
                f64::from(0.5 * speed * speed + 0.5 * inertia * turn * turn) + 9.81 * height
            };
            let begun = energy(&world);
            (0..(0.25 * rate) as u32).for_each(|_| _ = world.step(1.0 / rate).expect("a valid step"));
            let lost = (begun - energy(&world)) / (9.81 * 0.5 * f64::from(length));
            let what = format!("{length} m from {from} rad at {rate}/s");
            assert!(lost.abs() < 0.08, "{what}: loses {lost} m g l within a quarter of a second");
        }
    }
}
