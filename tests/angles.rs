//! Angles of joints are coordinates: they count turns, stops and targets hold at any size, and six-axis joints have no dead region.

use longspan::glam::{EulerRot, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, JointDef, JointId, JointKind, Limits, Mass, MassProperties, Motor, Pose, Shape, ShapeDef,
    SleepSettings, Softness, Solver, SphericalMotor, World, WorldDef,
};

const SOLVERS: [Solver; 2] = [Solver::Auto, Solver::GaussSeidel];
const RATES: [f32; 3] = [30.0, 60.0, 240.0];

fn world(solver: Solver) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::ZERO, solver, sleep, ..WorldDef::default() }).expect("a valid world")
}

/// A box of 2 kg about the origin that turns at `spin` (rad/s).
fn turning_box(world: &mut World, spin: Vec3) -> BodyId {
    let shape = Shape::cuboid(Vec3::new(0.3, 0.2, 0.1)).expect("a valid shape");
    let def = BodyDef::dynamic(Pose::IDENTITY).with_shape(ShapeDef::new(shape)).with_mass(Mass::Total(2.0));
    world.create_body(&BodyDef { angular_velocity: spin, ..def }).expect("a valid body")
}

fn join(world: &mut World, kind: JointKind, body: BodyId) -> JointId {
    world.create_joint(&JointDef::new(kind, BodyId::NULL, body)).expect("a valid joint")
}

fn hinge(min: f32, max: f32) -> JointKind {
    JointKind::Hinge { limits: Limits::new(min.to_radians(), max.to_radians()), motor: Motor::Off }
}

/// The same about one axis of a six-axis joint.
fn about(axis: usize, min: f32, max: f32, motor: Motor) -> JointKind {
    let mut angular = [Axis::LOCKED; 3];
    angular[axis] = Axis { limits: Limits::new(min.to_radians(), max.to_radians()), motor };
    JointKind::Generic { linear: [Axis::LOCKED; 3], angular }
}

fn twist(min: f32, max: f32) -> JointKind {
    JointKind::Spherical {
        swing_limit: 0.1,
        twist_limits: Limits::new(min.to_radians(), max.to_radians()),
        motor: SphericalMotor::Off,
    }
}

fn step(world: &mut World, dt: f32) {
    world.step(dt).expect("a valid step");
}

/// Turns of a body about `axis` as its poses tell them, one after another.
struct Turns {
    axis: Vec3,
    before: Quat,
    angle: f64,
}

impl Turns {
    fn new(axis: Vec3) -> Self {
        Self { axis, before: Quat::IDENTITY, angle: 0.0 }
    }

    /// Less than half a turn since the last call.
    fn follow(&mut self, world: &World, body: BodyId) -> f64 {
        let now = world.pose(body).expect("the body stays").rotation;
        let turned = now * std::mem::replace(&mut self.before, now).conjugate();
        let turned = if turned.w < 0.0 { -turned } else { turned };
        let sine = turned.xyz().dot(self.axis);
        self.angle += 2.0 * f64::from(sine.atan2(turned.w));
        self.angle
    }
}

/// A stop may be overrun by what one substep of the default effort is off at most (rad); by sweeps, which take the first substep of a step
/// at the velocity of its middle, by half of what it turned by in one besides.
const OVERRUN: f64 = 0.02;
const SWEPT_SHARE: f64 = 0.5;

#[test]
fn stops_hold_at_any_angle_and_speed_from_both_sides() {
    let ranges = [(0.0, 180.0), (0.0, 200.0), (-30.0, 270.0), (-180.0, 180.0), (-720.0, 720.0), (-200.0, 0.0)];
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for (min, max) in ranges {
            // At the last one it turns by 1.5 rad in a step: poses tell turns up to half a one.
            for spin in [0.7, 5.0, 1.5 * rate] {
                let joints: [(JointKind, Vec3); 3] =
                    [(hinge(min, max), Vec3::X), (twist(min, max), Vec3::X), (about(1, min, max, Motor::Off), Vec3::Y)];
                for (kind, axis) in joints {
                    for way in [1.0, -1.0] {
                        let mut world = world(solver);
                        let body = turning_box(&mut world, axis * spin * way);
                        let joint = join(&mut world, kind, body);
                        let mut turns = Turns::new(axis);
                        let swept =
                            if solver == Solver::GaussSeidel { SWEPT_SHARE * f64::from(spin / (4.0 * rate)) } else { 0.0 };
                        let overrun = OVERRUN + swept;
                        let (low, high) = (f64::from(min.to_radians()) - overrun, f64::from(max.to_radians()) + overrun);
                        let mut farthest = 0.0_f64;
                        // 2 N·m push it into its stop, and hold it there.
                        let seconds = (f64::from((max - min).to_radians()) / f64::from(spin)).min(3.0) + 0.2;
                        for _ in 0..(seconds * f64::from(rate)) as u32 {
                            world.add_torque(body, axis * 2.0 * way).expect("the body stays");
                            step(&mut world, 1.0 / rate);
                            let angle = turns.follow(&world, body);
                            farthest = farthest.max(angle * f64::from(way));
                            assert!(
                                (low..=high).contains(&angle),
                                "{kind:?} at {rate} Hz by {solver:?}, {spin} rad/s: {angle} rad, bound {overrun} beyond its stops"
                            );
                            if !matches!(kind, JointKind::Hinge { .. }) {
                                continue;
                            }
                            let told = f64::from(world.joint_state(joint).expect("the joint stays").position);
                            assert!((told - angle).abs() < 1.0e-3, "told {told} rad where it has turned {angle}");
                        }
                        let stop = if way > 0.0 { high } else { -low } - overrun;
                        assert!(farthest > stop - 0.1, "{kind:?} by {solver:?}, {spin} rad/s: went to {farthest} of {stop} rad");
                    }
                }
            }
        }
    }
}

#[test]
fn a_hinge_made_in_a_later_turn_of_its_range_stays_there() {
    for solver in SOLVERS {
        let mut world = world(solver);
        let body = turning_box(&mut world, Vec3::X * 2.0);
        world.set_pose(body, Pose::IDENTITY.rotated(Quat::from_rotation_x(220.0_f32.to_radians()))).expect("a valid pose");
        let joint = join(&mut world, hinge(200.0, 270.0), body);
        let mut greatest = f32::NEG_INFINITY;
        for _ in 0..240 {
            step(&mut world, 1.0 / 60.0);
            let angle = world.joint_state(joint).expect("the joint stays").position.to_degrees();
            assert!((199.0..=271.0).contains(&angle), "{solver:?}: {angle}°");
            greatest = greatest.max(angle);
        }
        assert!(greatest > 265.0, "{solver:?}: it never came to its upper stop: {greatest}°");
    }
}

#[test]
fn wheels_count_their_turns() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for spin in [3.0_f32, 1.2 * rate] {
            for (kind, axis) in [(JointKind::HINGE, Vec3::X), (about(2, f32::NEG_INFINITY, f32::INFINITY, Motor::Off), Vec3::Z)] {
                let mut world = world(solver);
                let mut joints = Vec::new();
                for _ in 0..10 {
                    let properties = MassProperties {
                        mass: 2.0,
                        center_of_mass: Vec3::ZERO,
                        principal_inertia: Vec3::ONE,
                        inertia_frame: Quat::IDENTITY,
                    };
                    let mut def = BodyDef::dynamic(Pose::IDENTITY).with_mass(Mass::Properties(properties));
                    def.angular_velocity = axis * spin;
                    let body = world.create_body(&def).expect("a valid body");
                    joints.push(join(&mut world, kind, body));
                }
                (0..(2.0 * rate) as u32).for_each(|_| step(&mut world, 1.0 / rate));
                if matches!(kind, JointKind::Hinge { .. }) {
                    for &joint in &joints {
                        let found = world.joint_state(joint).expect("the joint stays").position;
                        // Rounding of rotations over 300 rad.
                        assert!(
                            (found - 2.0 * spin).abs() < 1.0e-2,
                            "{solver:?} at {rate} Hz: {found}, turned {} rad",
                            2.0 * spin
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_spring_that_overshoots_half_a_turn_comes_back() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for (target, ratio) in [(100.0_f32, 0.2_f32), (150.0, 0.2), (170.0, 0.5), (-170.0, 0.5), (400.0, 0.3)] {
            for axis in 0..3 {
                let inertia = [0.2_f32, 0.1, 0.3][axis];
                let target = target.to_radians();
                let stiffness = 20.0;
                let damping = 2.0 * ratio * (stiffness * inertia).sqrt();
                let softness = Softness { compliance: 1.0 / stiffness, damping };
                let motor = Motor::Position { target, softness, max_force: f32::INFINITY };
                let mut world = world(solver);
                let properties = MassProperties {
                    mass: 2.0,
                    center_of_mass: Vec3::ZERO,
                    principal_inertia: Vec3::new(0.2, 0.1, 0.3),
                    inertia_frame: Quat::IDENTITY,
                };
                let def = BodyDef::dynamic(Pose::IDENTITY).with_mass(Mass::Properties(properties));
                let body = world.create_body(&def).expect("a valid body");
                join(&mut world, about(axis, f32::NEG_INFINITY, f32::INFINITY, motor), body);
                let mut turns = Turns::new(Vec3::AXES[axis]);
                let most = 0.5 * stiffness * target * target;
                for _ in 0..(6.0 * rate) as u32 {
                    step(&mut world, 1.0 / rate);
                    turns.follow(&world, body);
                    let spin = world.angular_velocity(body).expect("the body stays").length();
                    let energy = 0.5 * inertia * spin * spin;
                    assert!(
                        energy <= 1.01 * most,
                        "{solver:?} at {rate} Hz to {target} rad: {energy} J of {most} J in the spring"
                    );
                }
                let (found, expected) = (turns.angle as f32, target);
                assert!(
                    (found - expected).abs() < 0.02,
                    "{solver:?} at {rate} Hz about axis {axis}: rests at {found}, target {expected}"
                );
            }
        }
    }
}

#[test]
fn any_one_free_axis_of_a_six_axis_joint_turns_for_ever() {
    let driven = Motor::Velocity { target: 3.0, max_force: 100.0 };
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for axis in 0..3 {
            for motor in [Motor::Off, driven] {
                let mut world = world(solver);
                let start = if motor == Motor::Off { 3.0 } else { 0.0 };
                let body = turning_box(&mut world, Vec3::AXES[axis] * start);
                join(&mut world, about(axis, f32::NEG_INFINITY, f32::INFINITY, motor), body);
                let mut turns = Turns::new(Vec3::AXES[axis]);
                for _ in 0..(5.0 * rate) as u32 {
                    step(&mut world, 1.0 / rate);
                    turns.follow(&world, body);
                }
                // The motor gets it to its speed in the first substep.
                assert!(
                    (turns.angle - 15.0).abs() < 0.05,
                    "{solver:?} at {rate} Hz, axis {axis}, {motor:?}: {} rad",
                    turns.angle
                );
            }
        }
    }
}

#[test]
fn two_free_axes_are_a_universal_joint_in_all_poses() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        for locked in 0..3 {
            let mut angular = [Axis::FREE; 3];
            angular[locked] = Axis::LOCKED;
            let mut world = world(solver);
            let spin = Vec3::new(1.3, 2.1, -1.7) - Vec3::AXES[locked] * [1.3, 2.1, -1.7][locked];
            let body = turning_box(&mut world, spin);
            join(&mut world, JointKind::Generic { linear: [Axis::LOCKED; 3], angular }, body);
            let energy = |world: &World| {
                let (spin, turn) = (world.angular_velocity(body).expect("stays"), world.pose(body).expect("stays").rotation);
                let local = turn.conjugate() * spin;
                let inertia = world.mass_properties(body).expect("stays").expect("dynamic").principal_inertia;
                0.5 * local.dot(inertia * local)
            };
            let before = energy(&world);
            let mut widest = 0.0_f32;
            let mut worst = 0.0_f32;
            for _ in 0..(8.0 * rate) as u32 {
                step(&mut world, 1.0 / rate);
                let turn = world.pose(body).expect("stays").rotation;
                // One axis of A and one of B, at right angles.
                let (of_a, of_b) = [(Vec3::Y, Vec3::Z), (Vec3::X, Vec3::Z), (Vec3::X, Vec3::Y)][locked];
                worst = worst.max(of_a.dot(turn * of_b).abs());
                widest = widest.max(2.0 * turn.w.abs().min(1.0).acos());
            }
            assert!(worst < 5.0e-3, "{solver:?} at {rate} Hz, axis {locked} locked: its axes are off by {worst} rad");
            assert!(widest > 2.0, "{solver:?} at {rate} Hz, axis {locked} locked: it turned by no more than {widest} rad");
            let kept = energy(&world) / before;
            // A universal joint keeps it; substeps of first order damp what they turn by.
            assert!((0.4..=1.02).contains(&kept), "{solver:?} at {rate} Hz, axis {locked} locked: {kept} of its energy");
        }
    }
}

#[test]
fn three_free_axes_behave_as_a_spherical_joint() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        let free = JointKind::Generic { linear: [Axis::LOCKED; 3], angular: [Axis::FREE; 3] };
        let turn_of = |kind: JointKind| {
            let mut world = world(solver);
            let body = turning_box(&mut world, Vec3::new(2.0, 3.0, 1.0));
            let def = JointDef::new(kind, BodyId::NULL, body).at(Vec3::ZERO, Vec3::new(0.2, 0.1, 0.0));
            let def = JointDef { frame_a: Pose::at_xyz(0.2, 0.1, 0.0), ..def };
            world.create_joint(&def).expect("a valid joint");
            (0..(3.0 * rate) as u32).for_each(|_| step(&mut world, 1.0 / rate));
            world.pose(body).expect("stays").rotation
        };
        let off = turn_of(free).angle_between(turn_of(JointKind::SPHERICAL));
        // The same rows in another arithmetic.
        assert!(off < 0.05, "{solver:?} at {rate} Hz: {off} rad apart after 3 s");
    }
}

#[test]
fn limited_axes_of_a_six_axis_joint_hold_where_the_middle_one_passes_a_right_angle() {
    for (solver, rate) in SOLVERS.into_iter().flat_map(|solver| RATES.map(|rate| (solver, rate))) {
        let mut world = world(solver);
        let body = turning_box(&mut world, Vec3::new(0.1, 2.0, -0.05));
        let narrow = Axis::limited(-0.2, 0.2);
        join(&mut world, JointKind::Generic { linear: [Axis::LOCKED; 3], angular: [narrow, Axis::FREE, narrow] }, body);
        let mut turns = Turns::new(Vec3::Y);
        for _ in 0..(6.0 * rate) as u32 {
            step(&mut world, 1.0 / rate);
            turns.follow(&world, body);
            let turn = world.pose(body).expect("stays").rotation;
            let (x, y, z) = turn.to_euler(EulerRot::XYZ);
            let far = |angle: f32| angle.abs().min((std::f32::consts::PI - angle.abs()).abs());
            if y.abs() < 1.4 {
                assert!(far(x) < 0.3 && far(z) < 0.3, "{solver:?} at {rate} Hz: x {x}, y {y}, z {z} rad");
            }
            let spin = world.angular_velocity(body).expect("stays").length();
            assert!(spin < 6.0, "{solver:?} at {rate} Hz: {spin} rad/s, begun with 2");
        }
        assert!(turns.angle.abs() > 2.0, "{solver:?} at {rate} Hz: stuck at {} rad", turns.angle);
    }
}

#[test]
fn turns_are_in_snapshots_and_survive_teleports() {
    for solver in SOLVERS {
        let mut world = world(solver);
        let (a, b) = (turning_box(&mut world, Vec3::ZERO), turning_box(&mut world, Vec3::X * 40.0));
        let joint = world.create_joint(&JointDef::new(JointKind::HINGE, a, b)).expect("a valid joint");
        (0..60).for_each(|_| step(&mut world, 1.0 / 60.0));
        let angle = |world: &World| world.joint_state(joint).expect("the joint stays").position;
        let before = angle(&world);
        assert!((before - 40.0).abs() < 0.1, "{solver:?}: {before} rad after 40");
        let mut saved = Vec::new();
        world.save(&mut saved);
        step(&mut world, 1.0 / 60.0);
        let after = angle(&world);
        world.restore(&saved).expect("its own snapshot");
        assert_eq!(angle(&world), before, "{solver:?}: restored");
        step(&mut world, 1.0 / 60.0);
        assert_eq!(angle(&world), after, "{solver:?}: restored and stepped");
        // Both bodies are put elsewhere, turned by half a turn, one after the other.
        for body in [a, b] {
            let pose = world.pose(body).expect("stays");
            let turn = Quat::from_rotation_x(std::f32::consts::PI) * pose.rotation;
            world.set_pose(body, Pose { position: pose.position + 5.0, rotation: turn }).expect("a valid pose");
        }
        assert!((angle(&world) - after).abs() < 1.0e-4, "{solver:?}: {} rad after a teleport, {after} before", angle(&world));
    }
}
