//! What spins fast goes on spinning: wheels, gyroscopes and free bodies of every shape, at any rate of steps.

use longspan::glam::{DQuat, DVec3, Quat, Vec3};
use longspan::{
    ArticulationSettings, Axis, BodyDef, BodyId, JointDef, JointKind, Limits, Mass, MassProperties, Motor, Pose, Shape, ShapeDef,
    SleepSettings, Solver, World, WorldDef,
};

const GRAVITY: f32 = 9.81;

fn world(gravity: f32, solver: Solver) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, solver, sleep, ..WorldDef::default() }).expect("a valid world")
}

/// A body without shapes, whose principal axes are its own.
fn body(world: &mut World, x: f64, mass: f32, moments: Vec3, velocity: [Vec3; 2]) -> BodyId {
    let def = BodyDef {
        linear_velocity: velocity[0],
        angular_velocity: velocity[1],
        ..BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)).with_mass(Mass::Properties(MassProperties::new(mass, moments)))
    };
    world.create_body(&def).expect("a valid body")
}

fn hinge(motor: Motor, a: BodyId, b: BodyId) -> JointDef {
    JointDef::new(JointKind::Hinge { limits: Limits::NONE, motor }, a, b)
}

fn steps(world: &mut World, rate: f32, seconds: f32) {
    for _ in 0..(rate * seconds).round() as usize {
        world.step(1.0 / rate).expect("a valid step");
    }
}

/// Angular momentum about the centre of mass (N·m·s) and energy of rotation (J).
fn spin(world: &World, body: BodyId) -> (DVec3, f64) {
    let mass = world.mass_properties(body).expect("the body stays").expect("it is dynamic");
    let angular = world.angular_velocity(body).expect("the body stays").as_dvec3();
    let rotation = world.pose(body).expect("the body stays").rotation.as_dquat() * mass.inertia_frame.as_dquat();
    let axes: DQuat = rotation.normalize();
    let momentum = axes * (mass.principal_inertia.as_dvec3() * (axes.conjugate() * angular));
    (momentum, 0.5 * momentum.dot(angular))
}

#[test]
fn a_motor_speeds_a_rotor_up_and_angular_momentum_is_kept() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for rate in [30.0, 60.0, 240.0] {
            for target in [140.0, 300.0, 1000.0] {
                let mut world = world(0.0, solver);
                let (own, frame) = (1.0e-3_f32, 0.133_f32);
                let rotor = body(&mut world, 0.0, 0.2, Vec3::new(own, 0.5e-3, 0.5e-3), [Vec3::ZERO; 2]);
                let base = body(&mut world, 0.0, 5.0, Vec3::splat(frame), [Vec3::ZERO; 2]);
                let motor = Motor::Velocity { target, max_force: 4.0 };
                let joint = world.create_joint(&hinge(motor, base, rotor)).expect("a valid joint");
                steps(&mut world, rate, 1.0);
                let angle = |world: &World| world.joint_state(joint).expect("it stays").position;
                let before = angle(&world);
                world.step(1.0 / rate).expect("a valid step");
                let counted = (angle(&world) - before) * rate / target;
                assert!((counted - 1.0).abs() < 1e-3, "{solver:?}, {rate}/s, {target} rad/s: angles count {counted} of it");
                let [fast, slow] = [rotor, base].map(|body| world.angular_velocity(body).expect("it stays").x);
                let what = format!("{solver:?}, {rate}/s, {target} rad/s");
                let reached = (fast - slow) / target;
                assert!((reached - 1.0).abs() < 1e-3, "{what}: reaches {reached} of its target, bound 0.1 %");
                let left = (own * fast + frame * slow) / (own * target);
                assert!(left.abs() < 1e-3, "{what}: angular momentum is {left} of the rotor's, bound 0.1 %");
            }
        }
    }
}

#[test]
fn a_rotor_coasts_on_a_hinge_at_any_speed() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for rate in [30.0, 60.0, 120.0] {
            for speed in [50.0_f32, 155.0, 300.0, 1000.0] {
                for across in [0.5e-3, 0.9e-3] {
                    let mut world = world(GRAVITY, solver);
                    let moments = Vec3::new(1.0e-3, 0.5e-3, across);
                    let rotor = body(&mut world, 0.0, 0.2, moments, [Vec3::ZERO, Vec3::X * speed]);
                    world.create_joint(&hinge(Motor::Off, BodyId::NULL, rotor)).expect("a valid joint");
                    steps(&mut world, rate, 2.0);
                    let kept = world.angular_velocity(rotor).expect("it stays").x / speed;
                    assert!((kept - 1.0).abs() < 1e-3, "{solver:?}, {rate}/s, {speed} rad/s: keeps {kept}, bound 0.1 %");
                }
            }
        }
    }
}

/// Out of balance a wheel turns its joint's load with it, and a substep no longer takes what the axis does to it for nothing.
#[test]
fn a_flywheel_out_of_balance_coasts_where_a_substep_turns_it_by_half_a_radian() {
    // Distance of the centre of mass from the axis (m), spin (rad/s), steps a second, and what is left of the spin after 4 s.
    let solved = [
        (0.45, 50.0, 60.0, 0.985),
        (0.45, 100.0, 60.0, 0.94),
        (0.45, 100.0, 120.0, 0.985),
        (0.1, 100.0, 60.0, 0.98),
        (0.05, 200.0, 60.0, 0.94),
        (0.02, 200.0, 60.0, 0.98),
        (0.45, 50.0, 30.0, 0.965),
        (0.45, 100.0, 30.0, 0.75),
    ];
    let swept = [(0.45, 50.0, 60.0, 0.985), (0.45, 100.0, 60.0, 0.70), (0.45, 100.0, 30.0, 0.35)];
    let all = solved.map(|case| (Solver::Auto, case)).into_iter().chain(swept.map(|case| (Solver::GaussSeidel, case)));
    for (solver, (lever, speed, rate, least)) in all {
        let mut world = world(0.0, solver);
        let spin = [Vec3::Y * lever * speed, Vec3::Z * speed];
        let wheel = body(&mut world, f64::from(lever), 1.0, Vec3::splat(0.07), spin);
        let mut def = hinge(Motor::Off, BodyId::NULL, wheel).at(Vec3::ZERO, Vec3::NEG_X * lever);
        let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        (def.frame_a.rotation, def.frame_b.rotation) = (about_z, about_z);
        world.create_joint(&def).expect("a valid joint");
        steps(&mut world, rate, 4.0);
        let kept = world.angular_velocity(wheel).expect("it stays").z / speed;
        let what = format!("{lever} m from its axis at {speed} rad/s and {rate} steps a second by {solver:?}");
        assert!((least..=1.001).contains(&kept), "{what}: keeps {kept}, bound {least}");
    }
}

/// A disc of 2 kg on a hinge at the end of an arm of 0.5 m on a ball joint, in level precession; the rotor is returned.
fn gyroscope(world: &mut World, spin: f32, arm: f32) -> BodyId {
    Gyroscope::scaled(spin, arm, 1.0).make(world)
}

/// The same with these moments of the arm and of the rotor (kg·m²), the first about their length.
fn gyroscope_of(world: &mut World, spin: f32, arm: f32, held: Vec3, moments: Vec3) -> BodyId {
    Gyroscope { spin, arm, held, moments, ..Gyroscope::default() }.make(world)
}

/// A disc of 2 kg on a hinge at the end of an arm, in level precession.
#[derive(Debug, Clone, Copy)]
struct Gyroscope {
    spin: f32,
    /// Mass (kg) and length of the arm (m).
    arm: f32,
    reach: f32,
    /// Moments of the arm and of the rotor (kg·m²), the first about their length.
    held: Vec3,
    moments: Vec3,
    bearing: Bearing,
}

/// What holds the near end of the arm.
#[derive(Debug, Clone, Copy)]
enum Bearing {
    Ball,
    SixAxis,
    /// A ring on an upright hinge, and in it a level one.
    Gimbals,
}

impl Default for Gyroscope {
    fn default() -> Self {
        Self::scaled(100.0, 0.05, 1.0)
    }
}

impl Gyroscope {
    /// With all lengths so many times as long.
    fn scaled(spin: f32, arm: f32, scale: f32) -> Self {
        let across = arm * 0.25 / 12.0;
        let (held, moments) = (Vec3::new(1.0e-4, across, across), Vec3::new(0.09, 0.0456, 0.0456));
        let square = scale * scale;
        Self { spin, arm, reach: 0.5 * scale, held: held * square, moments: moments * square, bearing: Bearing::Ball }
    }

    fn make(self, world: &mut World) -> BodyId {
        let Self { spin, arm, reach, held, moments, bearing } = self;
        let (along, mass) = (moments.x, 2.0);
        let turning = GRAVITY * reach * (mass + 0.5 * arm) / (along * spin);
        let way = |x: f32| Vec3::NEG_Z * (turning * x);
        let half = Pose::at_xyz(f64::from(-0.5 * reach), 0.0, 0.0);
        let held = body(world, f64::from(0.5 * reach), arm, held, [way(0.5 * reach), Vec3::Y * turning]);
        let rotor = body(world, f64::from(reach), mass, moments, [way(reach), Vec3::new(spin, turning, 0.0)]);
        let mut joint = JointDef::new(JointKind::SPHERICAL, BodyId::NULL, held);
        match bearing {
            Bearing::Ball => {}
            Bearing::SixAxis => joint.kind = JointKind::Generic { linear: [Axis::LOCKED; 3], angular: [Axis::FREE; 3] },
            Bearing::Gimbals => {
                let ring = body(world, 0.0, 0.2, Vec3::splat(0.008 * reach * reach), [Vec3::ZERO, Vec3::Y * turning]);
                let mut upright = hinge(Motor::Off, BodyId::NULL, ring);
                let along_y = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
                (upright.frame_a.rotation, upright.frame_b.rotation) = (along_y, along_y);
                world.create_joint(&upright).expect("a valid joint");
                joint = hinge(Motor::Off, ring, held);
                let along_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
                (joint.frame_a.rotation, joint.frame_b.rotation) = (along_z, along_z);
            }
        }
        joint.frame_b.position = half.position;
        world.create_joint(&joint).expect("a valid joint");
        let mut joint = hinge(Motor::Off, held, rotor);
        joint.frame_a.position = -half.position;
        world.create_joint(&joint).expect("a valid joint");
        rotor
    }
}

/// Greatest height that a gyroscope has gained or lost at the end of each second (m).
fn way_off_level(rate: f32, spin: f32, arm: f32, error_target: f32, seconds: usize) -> f64 {
    way_off_level_of(rate, error_target, seconds, |world| gyroscope(world, spin, arm))
}

fn way_off_level_of(rate: f32, error_target: f32, seconds: usize, gyroscope: impl FnOnce(&mut World) -> BodyId) -> f64 {
    let mut world = world(GRAVITY, Solver::Auto);
    let settings = ArticulationSettings { error_target, ..ArticulationSettings::default() };
    world.set_articulation_settings(settings).expect("valid settings");
    let rotor = gyroscope(&mut world);
    let height = |world: &World| world.pose(rotor).expect("it stays").position.y.abs();
    (0..seconds).map(|_| (steps(&mut world, rate, 1.0), height(&world)).1).fold(0.0, f64::max)
}

#[test]
fn a_gyroscope_keeps_its_height() {
    for (rate, seconds) in [(30.0, 10), (60.0, 10), (240.0, 2), (960.0, 1)] {
        for spin in [30.0, 50.0, 100.0, 200.0, 1000.0] {
            for arm in [0.05, 1.0] {
                let off = way_off_level(rate, spin, arm, 0.0, seconds);
                assert!(off < 5e-3, "{spin} rad/s, {rate}/s, arm of {arm} kg: off by {off} m, bound 5 mm");
            }
        }
    }
}

#[test]
fn gyroscopes_of_all_sizes_and_bearings_keep_their_height() {
    for bearing in [Bearing::Ball, Bearing::SixAxis, Bearing::Gimbals] {
        for (scale, spins) in [(0.1, [50.0, 80.0, 500.0]), (1.0, [10.0, 30.0, 200.0]), (10.0, [10.0, 80.0, 500.0])] {
            for spin in spins {
                for (rate, error_target) in [(60.0, 0.0), (60.0, 1e-3), (240.0, 0.0)] {
                    let of = Gyroscope { bearing, ..Gyroscope::scaled(spin, 1.0, scale) };
                    let off = way_off_level_of(rate, error_target, 10, |world| of.make(world));
                    let what = format!("{bearing:?}, times {scale}, {spin} rad/s, {rate}/s, target {error_target} m");
                    assert!(off < 2e-3, "{what}: off by {off} m, bound 2 mm");
                }
            }
        }
    }
}

/// So fast that an axis which is off sets itself right, or swings out, several times within a step.
#[test]
fn a_gyroscope_at_a_thousand_radians_a_second_keeps_its_height_in_long_steps() {
    for (bearing, scale, arm, error_target) in
        [(Bearing::Ball, 1.0, 1.0, 1e-3), (Bearing::Ball, 10.0, 0.05, 1e-3), (Bearing::Gimbals, 10.0, 0.05, 0.0)]
    {
        let of = Gyroscope { bearing, ..Gyroscope::scaled(1000.0, arm, scale) };
        let off = way_off_level_of(30.0, error_target, 10, |world| of.make(world));
        assert!(off < 1e-3, "{bearing:?}, times {scale}, arm of {arm} kg: off by {off} m, bound 1 mm");
    }
}

/// It precesses as fast as it spins, or faster: no less a rotor for that.
#[test]
fn a_disc_that_turns_as_fast_as_it_spins_keeps_its_spin() {
    for rate in [60.0, 240.0] {
        for spin in [10.0, 13.0, 16.0] {
            for arm in [0.05, 1.0] {
                let mut world = world(GRAVITY, Solver::Auto);
                let rotor = gyroscope(&mut world, spin, arm);
                steps(&mut world, rate, 10.0);
                let axis = world.pose(rotor).expect("it stays").rotation * Vec3::X;
                let kept = world.angular_velocity(rotor).expect("it stays").dot(axis) / spin;
                let what = format!("{spin} rad/s, {rate}/s, arm of {arm} kg");
                assert!((kept - 1.0).abs() < 2e-3, "{what}: keeps {kept} of its spin after 10 s, bound 0.2 %");
            }
        }
    }
}

#[test]
fn a_box_that_tumbles_on_a_ball_joint_keeps_its_energy() {
    let moments = Vec3::new(0.09, 0.055, 0.036);
    let (mass, reach) = (2.0, 0.5);
    for rate in [60.0, 240.0] {
        for spin in [Vec3::new(10.0, 8.0, 6.0), Vec3::new(20.0, 5.0, 20.0)] {
            let mut world = world(GRAVITY, Solver::Auto);
            let tumbling = body(&mut world, f64::from(reach), mass, moments, [spin.cross(Vec3::X * reach), spin]);
            let mut joint = JointDef::new(JointKind::SPHERICAL, BodyId::NULL, tumbling);
            joint.frame_b = Pose::at_xyz(f64::from(-reach), 0.0, 0.0);
            world.create_joint(&joint).expect("a valid joint");
            let energy = |world: &World| {
                let linear = world.linear_velocity(tumbling).expect("it stays").as_dvec3();
                let height = world.pose(tumbling).expect("it stays").position.y;
                self::spin(world, tumbling).1 + f64::from(mass) * (0.5 * linear.length_squared() + f64::from(GRAVITY) * height)
            };
            let before = energy(&world);
            steps(&mut world, rate, 10.0);
            let kept = energy(&world) / before;
            assert!((kept - 1.0).abs() < 2e-3, "{spin} rad/s, {rate}/s: keeps {kept} of its energy after 10 s, bound 0.2 %");
        }
    }
}

/// Sweeps turn a rotor with all else: finer substeps hold it, the default effort at 60 steps a second lets it sink (see the limits).
#[test]
fn a_swept_gyroscope_sinks_by_centimetres_in_fine_substeps() {
    for (rate, substeps, bound) in [(240.0, 4, 0.025), (60.0, 16, 0.025)] {
        for spin in [30.0, 50.0, 100.0] {
            let mut world = world(GRAVITY, Solver::GaussSeidel);
            world.set_effort(substeps, 2).expect("a valid effort");
            let rotor = gyroscope(&mut world, spin, 0.05);
            steps(&mut world, rate, 5.0);
            let sunk = -world.pose(rotor).expect("it stays").position.y;
            let what = format!("{spin} rad/s, {rate}/s, {substeps} substeps");
            assert!(sunk.abs() <= bound, "{what}: sinks by {sunk} m in 5 s, bound {bound} m");
        }
    }
}

#[test]
fn an_error_target_holds_of_gyroscopes() {
    for rate in [30.0, 60.0] {
        for spin in [30.0, 100.0, 200.0] {
            let off = way_off_level(rate, spin, 0.05, 1e-3, 2);
            assert!(off < 1e-3, "{spin} rad/s, {rate}/s: off by {off} m, target 1 mm");
        }
    }
}

/// Moments of shafts: 4.5, 76 and 3000 to one, and of unequal sides.
const SHAFTS: [Vec3; 5] = [
    Vec3::new(2.2e-4, 1.0e-3, 1.0e-3),
    Vec3::new(1.3e-5, 1.0e-3, 1.0e-3),
    Vec3::new(3.3e-7, 1.0e-3, 1.0e-3),
    Vec3::new(1.3e-5, 1.0e-3, 1.004e-3),
    Vec3::new(2.0e-5, 1.0e-3, 1.02e-3),
];

#[test]
fn a_gyroscope_keeps_its_height_on_a_shaft_of_any_slenderness() {
    let disc = Vec3::new(0.09, 0.0456, 0.0456);
    for (rate, error_target) in [(30.0, 0.0), (60.0, 0.0), (60.0, 1e-3)] {
        for shaft in SHAFTS {
            for spin in [30.0, 100.0] {
                let off = way_off_level_of(rate, error_target, 10, |world| gyroscope_of(world, spin, 0.05, shaft, disc));
                // The error target, and at the default effort a thousandth of the arm twice over.
                assert!(off < 1e-3, "{spin} rad/s, {rate}/s, target {error_target} m, shaft {shaft}: off by {off} m, bound 1 mm");
            }
        }
    }
}

#[test]
fn a_gyroscope_whose_rotor_is_a_long_shaft_keeps_its_height() {
    // So fast that most of their momentum is about their length.
    for (moments, spin) in
        [([0.1, 0.1], 100.0), ([0.1, 0.1], 200.0), ([0.4, 0.4], 200.0), ([0.1, 0.101], 100.0), ([0.1, 0.101], 200.0)]
    {
        let rotor = Vec3::new(0.02, moments[0], moments[1]);
        for rate in [30.0, 60.0] {
            let off = way_off_level_of(rate, 0.0, 10, |world| gyroscope_of(world, spin, 0.05, SHAFTS[1], rotor));
            assert!(off < 1e-3, "{spin} rad/s, {rate}/s, rotor {rotor}: off by {off} m, bound 1 mm");
        }
    }
}

#[test]
fn a_gyroscope_goes_on_from_a_snapshot_to_the_same_bits() {
    let mut world = world(GRAVITY, Solver::Auto);
    gyroscope(&mut world, 100.0, 0.05);
    steps(&mut world, 60.0, 0.5);
    let mut saved = Vec::new();
    world.save(&mut saved);
    let mut twin = World::new(&WorldDef::default()).expect("a valid world");
    twin.restore(&saved).expect("it can be restored");
    for which in [&mut world, &mut twin] {
        steps(which, 60.0, 0.5);
    }
    let [mut bytes, mut twins] = [Vec::new(), Vec::new()];
    world.save(&mut bytes);
    twin.save(&mut twins);
    assert!(bytes == twins, "the restored world has moved otherwise");
}

/// Boxes with these half extents; an edge of none makes a needle.
const FREE: [[f32; 3]; 12] = [
    [0.5, 0.5, 0.5],
    [0.1, 0.5, 0.1],
    [0.02, 0.5, 0.02],
    [0.005, 0.5, 0.005],
    [0.001, 0.5, 0.001],
    [0.0035, 0.09, 0.0035],
    [0.5, 0.02, 0.5],
    [0.5, 0.001, 0.5],
    [0.1, 0.2, 0.3],
    [0.02, 0.1, 0.5],
    [0.1, 0.1001, 0.3],
    [0.3, 0.3, 0.31],
];

#[test]
fn a_free_body_keeps_its_energy_and_angular_momentum() {
    for rate in [30.0, 60.0, 240.0] {
        for turn in [Vec3::new(10.0, 100.0, 0.0), Vec3::new(60.0, 60.0, 50.0), Vec3::new(0.1, 0.1, 100.0)] {
            let mut world = world(0.0, Solver::Auto);
            let bodies: Vec<BodyId> = (FREE.iter().enumerate())
                .map(|(i, half)| {
                    let [x, y, z] = half.map(|half| half * half / 3.0);
                    body(&mut world, 5.0 * i as f64, 1.0, Vec3::new(y + z, x + z, x + y), [Vec3::ZERO, turn])
                })
                .collect();
            let before: Vec<_> = bodies.iter().map(|&body| spin(&world, body)).collect();
            let mut worst = [0.0_f64; 2];
            for second in 0..60 {
                steps(&mut world, rate, 1.0);
                for (i, &body) in bodies.iter().enumerate() {
                    let ((momentum, energy), (first, first_energy)) = (spin(&world, body), before[i]);
                    let lost = (momentum - first).length() / first.length();
                    let gained = (energy / first_energy - 1.0).abs();
                    worst = [worst[0].max(lost), worst[1].max(gained)];
                    let what = format!("half extents {:?} at {turn} rad/s, {rate}/s, after {second} s", FREE[i]);
                    assert!(lost < 1e-3, "{what}: angular momentum off by {lost} of itself, bound 0.1 %");
                    assert!(gained < 1e-3, "{what}: energy off by {gained} of itself, bound 0.1 %");
                }
            }
            println!("{rate}/s, {turn} rad/s: momentum {:.1e}, energy {:.1e}", worst[0], worst[1]);
        }
    }
}

#[test]
fn a_body_turns_by_what_it_spins() {
    // A whole number of turns brings a body back; 100 turns in ten seconds.
    for rate in [30.0, 60.0] {
        for moments in [Vec3::splat(1.0), Vec3::new(1.0, 2.0, 2.0), Vec3::new(1.0, 2.0, 2.5)] {
            let mut world = world(0.0, Solver::Auto);
            let speed = std::f32::consts::TAU * 100.0;
            let free = body(&mut world, 0.0, 1.0, moments, [Vec3::ZERO, Vec3::X * speed]);
            steps(&mut world, rate, 1.0);
            let angle = world.pose(free).expect("it stays").rotation.angle_between(Quat::IDENTITY);
            assert!(angle < 1e-3, "{rate}/s, {moments}: off by {angle} rad after 100 turns, bound 1 mrad");
        }
    }
}

#[test]
fn no_speed_is_above_its_limit_at_the_end_of_a_step() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        let mut world = world(0.0, solver);
        // A thin body on the end of a heavy one: turned by the other it would be far faster than is allowed.
        let heavy = body(&mut world, 0.0, 1e4, Vec3::splat(1e4), [Vec3::ZERO, Vec3::Z * 9e3]);
        let light = body(&mut world, 20.0, 1.0, Vec3::splat(1e-3), [Vec3::Y * 9e3, Vec3::ZERO]);
        let mut joint = JointDef::new(JointKind::SPHERICAL, heavy, light);
        (joint.frame_a, joint.frame_b) = (Pose::at_xyz(10.0, 0.0, 0.0), Pose::at_xyz(-10.0, 0.0, 0.0));
        world.create_joint(&joint).expect("a valid joint");
        let free = body(&mut world, 0.0, 1.0, Vec3::ONE, [Vec3::Y * 9.9e3, Vec3::Y * 9.9e3]);
        for _ in 0..10 {
            world.add_force(free, Vec3::Y * 1e5).expect("a valid force");
            world.add_torque(free, Vec3::Y * 1e5).expect("a valid torque");
            world.step(1.0 / 60.0).expect("a valid step");
            for body in [heavy, light, free] {
                let linear = world.linear_velocity(body).expect("it stays").length();
                let angular = world.angular_velocity(body).expect("it stays").length();
                assert!(linear <= 1e4 && angular <= 1e4, "{solver:?}: {linear} m/s, {angular} rad/s, bounds 1e4");
            }
        }
    }
}

/// What turns about its own middle without gravity turns by its speed, whichever way the middle is off by a rounding: it was taken for a row of links
/// that is pressed together along its line, and bent by half a radian in every step.
#[test]
fn what_turns_about_its_own_middle_turns_by_its_speed() {
    for kind in [JointKind::HINGE, JointKind::SPHERICAL] {
        for (rate, off) in [30.0_f32, 60.0, 240.0]
            .into_iter()
            .flat_map(|rate| [0.0, 4.0e-16, 1.0e-12, 1.0e-10, 1.0e-8, 1.0e-5].map(|off| (rate, off)))
        {
            let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
            let shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.1, 0.5, 0.05)).unwrap());
            let body = world
                .create_body(&BodyDef { angular_velocity: Vec3::X * 5.0, ..BodyDef::dynamic(Pose::IDENTITY) }.with_shape(shape))
                .unwrap();
            let mut joint = JointDef::new(kind, BodyId::NULL, body);
            joint.frame_b.position.y = off;
            world.create_joint(&joint).unwrap();
            let mut last = world.pose(body).unwrap().rotation;
            for _ in 0..rate as u32 {
                world.step(1.0 / rate).unwrap();
                let now = world.pose(body).unwrap().rotation;
                let turned = (now * last.conjugate()).xyz().length().asin() * 2.0 * rate;
                assert!((turned - 5.0).abs() < 0.02, "{kind:?} off by {off} m at {rate} Hz: turns at {turned} of 5 rad/s");
                last = now;
            }
        }
    }
}
