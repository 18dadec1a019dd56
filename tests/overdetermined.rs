//! Mechanisms some of whose joints repeat others move as if these were not there.
//!
//! All are turned so that nothing lies along an axis of the world: what repeats does so but for rounding and gaps.

use common::Run;
use longspan::glam::{DQuat, DVec3, EulerRot, Vec3};
use longspan::{BodyDef, BodyId, JointDef, JointId, JointKind, Mass, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef};

mod common;

const DT: f32 = 1.0 / 60.0;
const SECONDS: f32 = 6.0;
const MASS: f32 = 4.0;
const GRAVITY: f64 = 9.81;

fn turned() -> DQuat {
    DQuat::from_euler(EulerRot::XYZ, 0.4, 0.9, 0.3)
}

fn world() -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let gravity = (turned() * DVec3::NEG_Y * GRAVITY).as_vec3();
    World::new(&WorldDef { gravity, sleep, ..WorldDef::default() }).expect("a valid world")
}

fn part(world: &mut World, at: DVec3, turn: DQuat, half: Vec3) -> BodyId {
    let mut shape = ShapeDef::new(Shape::cuboid(half).expect("a valid shape"));
    shape.filter.collides_with = 0;
    let pose = Pose::at(turned() * at).rotated((turned() * turn).as_quat());
    world.create_body(&BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(MASS))).expect("a valid body")
}

fn join(world: &mut World, kind: JointKind, a: BodyId, b: BodyId, at: DVec3, axis: DVec3) -> JointId {
    let turn = DQuat::from_rotation_arc(DVec3::X, (turned() * axis).normalize());
    let seen_by = |body: BodyId| {
        let pose = if body == BodyId::NULL { Pose::IDENTITY } else { world.pose(body).expect("bodies stay") };
        let back = pose.rotation.as_dquat().normalize().inverse();
        Pose::at(back * (turned() * at - pose.position)).rotated((back * turn).as_quat())
    };
    let mut def = JointDef::new(kind, a, b);
    (def.frame_a, def.frame_b) = (seen_by(a), seen_by(b));
    world.create_joint(&def).expect("a valid joint")
}

/// Where a body is after each step, in the axes of the mechanism.
fn path(world: &mut World, body: BodyId) -> Vec<DVec3> {
    let steps = (SECONDS / DT) as usize;
    let after_step = |_| {
        world.step(DT).expect("a valid step");
        turned().inverse() * world.pose(body).expect("bodies stay").position
    };
    (0..steps).map(after_step).collect()
}

/// A door of 4 kg, 1 m wide, on a post that leans, held at these heights; its path, and the greatest force that holds it.
fn door(kind: JointKind, heights: &[f64]) -> (Vec<DVec3>, f32) {
    let mut world = world();
    let door = part(&mut world, DVec3::X * 0.5, DQuat::IDENTITY, Vec3::new(0.5, 1.0, 0.02));
    let post = DVec3::new(0.2, 1.0, 0.3).normalize();
    let joints: Vec<JointId> =
        heights.iter().map(|&height| join(&mut world, kind, BodyId::NULL, door, post * height, post)).collect();
    let path = path(&mut world, door);
    let force = |&joint: &JointId| world.joint_state(joint).expect("joints stay").force.length();
    let force = joints.iter().map(force).fold(0.0, f32::max);
    (path, force)
}

#[test]
fn a_door_swings_on_many_hinges_or_points_as_on_one_hinge() {
    let (one, _) = door(JointKind::HINGE, &[0.0]);
    for (kind, name) in [(JointKind::HINGE, "hinges"), (JointKind::SPHERICAL, "points")] {
        for heights in [&[-0.9, 0.8][..], &[-0.9, 0.1, 0.8], &[-0.9, -0.37, 0.0, 0.41, 0.8]] {
            let (path, force) = door(kind, heights);
            let apart = one.iter().zip(&path).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            let count = heights.len();
            println!("{count} {name}: {apart} m apart, {force} N");
            assert!(apart < 5e-3, "on {count} {name} it is {apart} m from its path on one hinge, bound 5e-3 m");
            // Of what they push against each other alone; the door weighs 39 N.
            assert!(force < 5e3, "{count} {name} bear up to {force} N, bound 5e3 N");
        }
    }
}

#[test]
fn a_platform_swings_back_on_six_bars_as_on_two() {
    for spots in [&[-0.9, 0.9][..], &[-0.9, -0.53, -0.2, 0.11, 0.47, 0.9]] {
        let mut world = world();
        let platform = part(&mut world, DVec3::new(0.6, -0.8, 0.0), DQuat::IDENTITY, Vec3::new(1.0, 0.05, 0.3));
        for &x in spots {
            let slant = DQuat::from_rotation_z(0.6_f64.atan2(0.8));
            let bar = part(&mut world, DVec3::new(x + 0.3, -0.4, 0.0), slant, Vec3::new(0.02, 0.5, 0.02));
            join(&mut world, JointKind::HINGE, BodyId::NULL, bar, DVec3::X * x, DVec3::Z);
            join(&mut world, JointKind::HINGE, bar, platform, DVec3::new(x + 0.6, -0.8, 0.0), DVec3::Z);
        }
        // Past its first swing: how high it comes again.
        let back = path(&mut world, platform)[200..].iter().map(|at| at.y).fold(f64::NEG_INFINITY, f64::max);
        assert!((back + 0.8).abs() < 2e-3, "on {} bars it swings back to {back} m, from −0.8 m, bound 2e-3 m", spots.len());
    }
}

#[test]
fn a_loop_of_six_hinges_keeps_its_momentum() {
    let run = Run::of("hinge_loop", &[("n", "6")]);
    run.keeps("lin_momentum_err_pct", 2e-4, "%");
    run.keeps("ang_momentum_err_pct", 5e-3, "%");
    Run::of("hinge_loop", &[("n", "40")]).keeps("ang_momentum_err_pct", 1e-3, "%");
}
