//! Joints that close a loop and bear much: scissor lifts, four-bars, bridges.

use std::f32::consts::PI;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Geometry, JointDef, JointId, JointKind, Limits, Mass, Material, Motor, Pose, Shape, ShapeDef, SleepSettings,
    World, WorldDef,
};

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];

const HELD: Motor = Motor::Velocity { target: 0.0, max_force: f32::INFINITY };

fn world() -> World {
    World::new(&WorldDef { sleep: SleepSettings { enabled: false, ..SleepSettings::default() }, ..WorldDef::default() }).unwrap()
}

fn block(world: &mut World, mass: f32, pose: Pose, half_extents: Vec3, collides: bool) -> BodyId {
    let mut shape = ShapeDef::new(Shape::new(Geometry::Box { half_extents }).unwrap());
    shape.material = Material { friction: 0.6, ..Material::default() };
    if !collides {
        shape.filter.collides_with = 0;
    }
    let def = BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(pose) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

/// A hinge about z at a point of the world.
fn hinge(world: &mut World, ends: [BodyId; 2], at: DVec3, motor: Motor) -> JointId {
    let about_z = Quat::from_rotation_y(-0.5 * PI);
    let mut def = JointDef::new(JointKind::Hinge { limits: Limits::NONE, motor }, ends[0], ends[1]);
    for (body, frame) in ends.into_iter().zip([&mut def.frame_a, &mut def.frame_b]) {
        let pose = if body == BodyId::NULL { Pose::at(DVec3::ZERO) } else { world.pose(body).unwrap() };
        let back = pose.rotation.conjugate();
        *frame = Pose { position: back.as_dquat() * (at - pose.position), rotation: back * about_z };
    }
    world.create_joint(&def).unwrap()
}

fn run(world: &mut World, seconds: f32, rate: f32) {
    for _ in 0..(seconds * rate).round() as usize {
        world.step(1.0 / rate).unwrap();
    }
}

/// A scissor lift of arms of 1 kg and 2 m that cross at 0.3 rad from the ground, held at its foot.
struct Lift {
    world: World,
    foot: JointId,
    platform: BodyId,
    /// Crate that lies on it, if its load is not its own mass.
    crate_: Option<BodyId>,
    /// Force at the foot that the weights ask for (N).
    expected: f64,
}

const SLANT: f64 = 0.3;

impl Lift {
    fn new(stages: usize, load: f32, lies_on_it: bool, (limits, motor): (Limits, Motor)) -> Self {
        let mut world = world();
        let (rise, width) = (2.0 * SLANT.sin(), 2.0 * SLANT.cos());
        let middle = 0.5 * width;
        let arm = Vec3::new(1.0, 0.03, 0.03);
        let mut last = None;
        let top = rise * stages as f64;
        let small = Vec3::splat(0.05);
        let slider = block(&mut world, 5.0, Pose::at_xyz(width, 0.0, 0.0), small, false);
        for stage in 0..stages {
            let below = rise * stage as f64;
            let at = DVec3::new(middle, below + 0.5 * rise, 0.0);
            let arms = [SLANT, -SLANT].map(|slant| {
                let pose = Pose { position: at, rotation: Quat::from_rotation_z(slant as f32) };
                block(&mut world, 1.0, pose, arm, false)
            });
            hinge(&mut world, arms, at, Motor::Off);
            let [left, right] = [DVec3::Y * below, DVec3::new(width, below, 0.0)];
            let [up, down] = last.unwrap_or([slider, BodyId::NULL]);
            hinge(&mut world, [down, arms[0]], left, Motor::Off);
            hinge(&mut world, [up, arms[1]], right, Motor::Off);
            last = Some(arms);
        }
        let mut def = JointDef::new(JointKind::Prismatic { limits, motor }, BodyId::NULL, slider);
        def.frame_a.position = DVec3::X * width;
        let foot = world.create_joint(&def).unwrap();
        let weight = if lies_on_it { 20.0 } else { load };
        let at = DVec3::new(middle, top + 0.1, 0.0);
        let platform = block(&mut world, weight, Pose::at(at), Vec3::new(1.0, 0.05, 0.5), lies_on_it);
        let [up, down] = last.expect("it has stages");
        hinge(&mut world, [platform, down], DVec3::Y * top, Motor::Off);
        let runner = block(&mut world, 1.0, Pose::at_xyz(width, top, 0.0), small, false);
        hinge(&mut world, [runner, up], DVec3::new(width, top, 0.0), Motor::Off);
        let rail = JointDef::new(JointKind::PRISMATIC, platform, runner).at(Vec3::new(middle as f32, -0.1, 0.0), Vec3::ZERO);
        world.create_joint(&rail).unwrap();
        let crate_ = lies_on_it.then(|| block(&mut world, load, Pose::at(at + DVec3::Y * 0.35), Vec3::splat(0.3), true));
        // Virtual work: the foot closes by 2 sin θ of what each stage rises by 2 cos θ; arms of a stage by that of its middle.
        let n = stages as f64;
        let weights = f64::from(if lies_on_it { weight + load } else { load }) * n + n + n * n;
        Self { world, foot, platform, crate_, expected: weights * 9.81 / SLANT.tan() }
    }
}

#[test]
fn a_scissor_lift_of_light_arms_holds_two_tonnes_where_it_was_made() {
    let actuators = [("a motor at rest", (Limits::NONE, HELD)), ("limits", (Limits::new(0.0, 0.0), Motor::Off))];
    for (stages, lies_on_it) in [(5, false), (8, false), (3, true), (8, true)] {
        for (what, actuator) in actuators {
            for rate in RATES {
                let mut lift = Lift::new(stages, 2000.0, lies_on_it, actuator);
                let heights = |lift: &Lift| {
                    let bodies = [Some(lift.platform), lift.crate_].into_iter().flatten();
                    bodies.map(|body| lift.world.pose(body).unwrap().position.y).collect::<Vec<_>>()
                };
                let before = heights(&lift);
                run(&mut lift.world, 0.5, rate);
                let (mut effort, steps) = (0.0, (0.5 * rate) as usize);
                for _ in 0..steps {
                    lift.world.step(1.0 / rate).unwrap();
                    let state = lift.world.joint_state(lift.foot).unwrap();
                    effort += f64::from(state.force.length()) / steps as f64;
                }
                let what = format!("{stages} stages held by {what} at {rate} Hz, load loose: {lies_on_it}");
                for (now, before) in heights(&lift).into_iter().zip(before) {
                    assert!((now - before).abs() < 2.0e-4, "{what}: it has moved by {} m", now - before);
                }
                // The slider also bears half the weight across its way: 0.14 % of what three stages push along it.
                let off = effort / lift.expected - 1.0;
                assert!(off.abs() < 5.0e-3, "{what}: {effort} N, expected {} N", lift.expected);
            }
        }
    }
}

#[test]
fn a_scissor_lift_rises_as_its_foot_is_drawn_in() {
    for (stages, lies_on_it) in [(5, false), (8, true)] {
        for rate in [30.0, 60.0, 240.0] {
            let motor = Motor::Velocity { target: -0.1, max_force: f32::INFINITY };
            let mut lift = Lift::new(stages, 2000.0, lies_on_it, (Limits::NONE, motor));
            run(&mut lift.world, 1.0, rate);
            let way = f64::from(lift.world.joint_state(lift.foot).unwrap().position);
            let height = lift.world.pose(lift.platform).unwrap().position.y;
            let expected = stages as f64 * 2.0 * (SLANT.cos() + 0.5 * way).acos().sin() + 0.1;
            let what = format!("{stages} stages at {rate} Hz, load loose: {lies_on_it}");
            assert!((way + 0.1).abs() < 1.0e-3, "{what}: the foot has been drawn in by {} m", -way);
            assert!((height - expected).abs() < 1.0e-3, "{what}: the platform is at {height} m, expected {expected} m");
        }
    }
}

/// Two cranks of 1 m carry a plate on which a crate lies. As the motor starts at 0.5 m/s, the crate slides by v²/(2 μ g) = 21 mm.
#[test]
fn a_crate_goes_along_on_a_four_bar_of_light_links() {
    for (load, link) in [(2000.0, 2.0), (200.0, 20.0)] {
        for rate in RATES {
            let mut world = world();
            let crank = Vec3::new(0.05, 0.5, 0.05);
            let cranks = [-1.0, 1.0].map(|x| block(&mut world, link, Pose::at_xyz(x, 0.5, 0.0), crank, false));
            let plate = block(&mut world, link, Pose::at_xyz(0.0, 1.05, 0.0), Vec3::new(1.2, 0.05, 0.5), true);
            let motor = Motor::Velocity { target: -0.5, max_force: f32::INFINITY };
            for (side, motor) in [(0, motor), (1, Motor::Off)] {
                let x = [-1.0, 1.0][side];
                hinge(&mut world, [BodyId::NULL, cranks[side]], DVec3::X * x, motor);
                hinge(&mut world, [cranks[side], plate], DVec3::new(x, 1.0, 0.0), Motor::Off);
            }
            let start = DVec3::new(0.3, 0.35, 0.0);
            let crate_ = block(&mut world, load, Pose::at(DVec3::Y * 1.05 + start), Vec3::splat(0.3), true);
            run(&mut world, 1.0, rate);
            let at = world.pose(plate).unwrap().position;
            let off = (at - DVec3::new(0.5_f64.sin(), 0.05 + 0.5_f64.cos(), 0.0)).length();
            let slid = world.pose(crate_).unwrap().position - at - start;
            let what = format!("{load} kg on links of {link} kg at {rate} Hz");
            assert!(off < 2.0e-4, "{what}: the plate is {off} m from where it is driven to");
            assert!((slid.x + 0.0212).abs() < 4.0e-3, "{what}: the crate has slid by {slid} m, expected −0.021 m");
            assert!(slid.y.abs() < 1.0e-4, "{what}: the crate is off its plate by {} m", slid.y);
        }
    }
}

/// It sags by √(span × what its joints have opened by / 2). What closing its joints lifts is no energy from nothing: no step is given up but that of the blow.
#[test]
fn a_straight_bridge_of_planks_bears_tonnes_at_any_rate() {
    for (load, rate) in [(800.0, 30.0), (8000.0, 30.0), (8000.0, 60.0), (8000.0, 120.0), (800.0, 240.0), (8000.0, 240.0)] {
        let mut world = world();
        let planks = 12;
        let mut last = BodyId::NULL;
        for plank in 0..planks {
            let edge = 0.5 * f64::from(plank) - 3.0;
            let pose = Pose::at_xyz(edge + 0.25, 0.0, 0.0);
            let next = block(&mut world, 20.0, pose, Vec3::new(0.25, 0.08, 1.2), true);
            hinge(&mut world, [last, next], DVec3::X * edge, Motor::Off);
            last = next;
        }
        hinge(&mut world, [last, BodyId::NULL], DVec3::X * 3.0, Motor::Off);
        let crate_ = block(&mut world, load, Pose::at_xyz(0.0, 0.49, 0.0), Vec3::splat(0.4), true);
        let mut given_up = 0;
        for _ in 0..(3.0 * rate) as usize {
            world.step(1.0 / rate).unwrap();
            given_up += world.islands().iter().filter(|island| island.given_up).count();
        }
        let sag = 0.48 - world.pose(crate_).unwrap().position.y;
        let gap = world.report().residuals.joint_gap;
        let what = format!("{load} kg at {rate} Hz");
        // The blow with which tonnes land on what has no way to give may be left to the other solvers.
        assert!(given_up <= 1, "{what}: {given_up} steps of which the coupled solve was given up");
        assert!((0.0..3.0e-3).contains(&sag), "{what}: it sags by {sag} m");
        assert!(gap < 1.0e-6, "{what}: joints are {gap} m open");
    }
}
