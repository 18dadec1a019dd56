//! Machines of servo hinges that handle loads: a crane and an excavator.
//!
//! *Crane*: a static mast with a jib of 2 t (a box, half-extents 4 × 0.2 × 0.2 m, its root at the mast, 6 m up) that a speed servo
//! slews about the vertical at 10°/s; from its tip a rope of `links` capsules (0.2 m, radius 0.02 m, 1 kg) with a box of `load` kg
//! (half-extent 0.5 m). The jib starts at its rate, rope and load with the velocities of the tip. 8 s.
//!
//! *Excavator*: from a static base at (0, 1) m a boom (3 m, 500 kg, 30° up), a stick (2 m, 300 kg, 40° down) and a fork (200 kg: a
//! back and a floor, each 0.1 m thick) with four boxes of 250 kg (half-extent 0.25 m) stacked on it. Speed servos turn the boom up at
//! 6°/s, the stick against it at 2°/s and the fork back at 8°/s, so that it stays level; all start at these rates. 5 s. Arm, fork and
//! base do not touch each other; friction 0.5 between fork and boxes.

use longspan::glam::{DQuat, DVec3, Vec3};
use longspan::{BodyDef, CollisionFilter, Geometry, JointKind, Limits, LocalPose, Motor, Pose};

use crate::assemble::{INTANGIBLE, filtered, rod, solid};
use crate::metrics::{DrivenEnergy, JointGap, Overlap, Reading, Stretch, View, hinge_angle, or_infinite};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, shape, start, start_at_rate};

const PITCH: f64 = 0.2;
const JIB_HALF: f64 = 4.0;
const JIB_HEIGHT: f64 = 6.0;
const SLEW_DEG: f64 = 10.0;
const LOAD_HALF: f64 = 0.5;

/// A hinge that holds a rate (rad/s) with whatever torque that takes.
pub(crate) fn servo(rate: f64) -> JointKind {
    JointKind::Hinge { limits: Limits::NONE, motor: Motor::Velocity { target: rate as f32, max_force: f32::INFINITY } }
}

/// `servo_err_deg`: the greatest difference of any of these hinges from its rate (rad/s) times time, over the run.
pub(crate) fn servo_error(steps: u32, hinges: Vec<(usize, f64)>) -> Reading {
    Reading::worst_of_last(steps, "servo_err_deg", move |view: &View| {
        let error = |&(joint, rate): &(usize, f64)| (hinge_angle(view, joint) - rate * view.time).abs();
        hinges.iter().map(error).map(or_infinite).fold(0.0, f64::max).to_degrees()
    })
}

pub(crate) fn crane(params: &mut Params) -> Result<Scene, SceneError> {
    let load = params.number("load", 5000.0, 1.0e-3..=1.0e9)?;
    let links = params.count("links", 20, 1..=1000)?;
    let (mut scene, _) = start_at_rate(params, 8.0)?;
    let mast = BodyDef::fixed(Pose::at_xyz(0.0, 0.5 * JIB_HEIGHT, 0.0)).with_shape(cuboid(0.3, 3.0, 0.3)?);
    let mast = scene.body(filtered(mast, INTANGIBLE));
    let spin = DVec3::Y * SLEW_DEG.to_radians();
    let add = |scene: &mut Scene, mut def: BodyDef, turns: bool| {
        let at = if turns { def.pose.position } else { DVec3::X * (2.0 * JIB_HALF) };
        def.linear_velocity = spin.cross(at).as_vec3();
        def.angular_velocity = if turns { spin.as_vec3() } else { Vec3::ZERO };
        scene.body(filtered(def, INTANGIBLE))
    };
    let jib = solid(Pose::at_xyz(JIB_HALF, JIB_HEIGHT, 0.0), cuboid(JIB_HALF as f32, 0.2, 0.2)?, 2000.0);
    let jib = add(&mut scene, jib, true);
    let slew = scene.hinge(mast, jib, servo(SLEW_DEG.to_radians()), DVec3::Y * JIB_HEIGHT, DVec3::Y);

    let at = |index: usize| DVec3::new(2.0 * JIB_HALF, JIB_HEIGHT - PITCH * index as f64, 0.0);
    let mut held = jib;
    let mut joints = Vec::new();
    for index in 0..links {
        let link = add(&mut scene, rod(at(index), at(index + 1), 0.02, 1.0)?, false);
        joints.push(scene.tie(held, link, at(index)));
        held = link;
    }
    let half = LOAD_HALF as f32;
    let load = solid(Pose::at(at(links) - DVec3::Y * LOAD_HALF), cuboid(half, half, half)?, load as f32);
    let load = add(&mut scene, load, false);
    joints.push(scene.tie(held, load, at(links)));

    let steps = scene.steps;
    scene.judge(Stretch::new(joints, PITCH * links as f64, steps));
    scene.judge(JointGap::over_last(steps));
    scene.judge(servo_error(steps, vec![(slew, SLEW_DEG.to_radians())]));
    scene.judge(DrivenEnergy::default());
    Ok(scene)
}

/// The machine itself touches boxes alone.
const MACHINE: CollisionFilter = CollisionFilter { member_of: 2, collides_with: 1 };
const BOOM_DEG: f64 = 30.0;
const STICK_DEG: f64 = -40.0;
const BOXES: usize = 4;
const BOX_HALF: f64 = 0.25;

pub(crate) fn excavator(params: &mut Params) -> Result<Scene, SceneError> {
    let mass = params.number("mass", 250.0, 1.0e-3..=1.0e9)?;
    let mut scene = start(params, 5.0)?;
    let root = DVec3::Y;
    let base = BodyDef::fixed(Pose::at(0.5 * root)).with_shape(cuboid(0.5, 0.5, 0.5)?);
    let base = scene.body(filtered(base, MACHINE));
    let rates = [6.0, 2.0, -8.0].map(f64::to_radians);
    let along = |degrees: f64| DVec3::new(libm::cos(degrees.to_radians()), libm::sin(degrees.to_radians()), 0.0);

    let (elbow, wrist) = (root + 3.0 * along(BOOM_DEG), root + 3.0 * along(BOOM_DEG) + 2.0 * along(STICK_DEG));
    let beam = |from: DVec3, to: DVec3, mass: f32| -> Result<BodyDef, SceneError> {
        let turn = DQuat::from_rotation_arc(DVec3::X, (to - from).normalize()).as_quat();
        let shape = cuboid((0.5 * from.distance(to)) as f32, 0.1, 0.1)?;
        Ok(solid(Pose::at(0.5 * (from + to)).rotated(turn), shape, mass))
    };
    let plate = |x: f32, y: f32| Geometry::Box { half_extents: Vec3::new(x, y, 0.5) };
    let parts = vec![
        (LocalPose::at(Vec3::new(0.05, 0.0, 0.0)), plate(0.05, 0.55)),
        (LocalPose::at(Vec3::new(0.7, -0.5, 0.0)), plate(0.6, 0.05)),
    ];
    let fork_shape = shape(Geometry::Compound { parts })?;
    // Each part: its body, where it hangs, and the centre whose velocity it starts with.
    let steps = [
        (beam(root, elbow, 500.0)?, root),
        (beam(elbow, wrist, 300.0)?, elbow),
        (solid(Pose::at(wrist), fork_shape, 200.0), wrist),
    ];
    let (mut held, mut spin, mut speed, mut last) = (base, 0.0, DVec3::ZERO, root);
    let mut hinges = Vec::new();
    for ((mut def, foot), rate) in steps.into_iter().zip(rates) {
        speed += DVec3::Z.cross(foot - last) * spin;
        spin += rate;
        last = foot;
        // The fork's centre of mass lies beside its pivot; it does not turn, so that makes no difference.
        def.linear_velocity = (speed + DVec3::Z.cross(def.pose.position - foot) * spin).as_vec3();
        def.angular_velocity = Vec3::Z * spin as f32;
        let body = scene.body(filtered(def, MACHINE));
        hinges.push((scene.hinge(held, body, servo(rate), foot, DVec3::Z), rate));
        held = body;
    }
    let fork = held;
    let half = BOX_HALF as f32;
    let stack: Vec<usize> = (0..BOXES)
        .map(|level| {
            let height = -0.45 + BOX_HALF * (2 * level + 1) as f64;
            let mut def = solid(Pose::at(wrist + DVec3::new(0.7, height, 0.0)), cuboid(half, half, half)?, mass as f32);
            def.linear_velocity = speed.as_vec3();
            Ok(scene.body(def))
        })
        .collect::<Result<_, SceneError>>()?;

    let steps = scene.steps;
    scene.judge(servo_error(steps, hinges));
    scene.judge(JointGap::over_last(steps));
    let starts: Vec<Vec3> =
        stack.iter().map(|&body| scene.bodies[fork].pose.inverse_transform_point(scene.bodies[body].pose.position)).collect();
    scene.judge(Reading::worst_of_last(steps, "slip_m", move |view| {
        let pose = view.engine.pose(fork);
        let moved = |(&body, start): (&usize, &Vec3)| {
            (pose.inverse_transform_point(view.engine.pose(body).position) - *start).as_dvec3().length()
        };
        stack.iter().zip(&starts).map(moved).map(or_infinite).fold(0.0, f64::max)
    }));
    scene.judge(Overlap::at_end());
    scene.judge(DrivenEnergy::default());
    Ok(scene)
}
