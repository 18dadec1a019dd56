//! What joints hold and contacts load: an elevator, a gripper and a scissor lift.
//!
//! * *Elevator*: a motor raises a platform of 50 kg at 1 m/s, on which a crate of `load` kg stands loose; `stop` sets a stop that the
//!   platform reaches after 2 m. `behind_m` is how far it is from where it is told to be, `hop_m` how far the crate from its place on it,
//!   and `load_err_pct` compares what the slider bears with both weights.
//! * *Gripper*: two fingers of `finger` kg on a moved palm push with `force` N each, friction 0.6, and hold a cube of `load` kg as the palm
//!   is raised at 0.1 m/s and shaken at 4 Hz by 1 cm. `slid_m` is how far the cube has slid.
//! * *Scissor lift*: `stages` of arms of 1 kg and 2 m that cross at 0.3 rad, held at the foot by a motor at rest, with a crate of `load` kg
//!   on the platform of 20 kg. `sunk_m` is how far the crate has come from where it was made; `load_err_pct` compares the foot's force with
//!   virtual work: the weights times what they would rise by as the foot closes, n W / tan θ.

use std::f64::consts::PI;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, JointKind, Limits, Motor, Pose};

use crate::assemble::{INTANGIBLE, filtered, solid, x_to};
use crate::metrics::{JointGap, LoadError, Reading};
use crate::params::{Params, SceneError};
use crate::scene::{Action, GRAVITY, Scene, cuboid, floor, start_at_rate, with_friction};

fn slider(target: f64, max_force: f64, limits: Limits) -> JointKind {
    JointKind::Prismatic { limits, motor: Motor::Velocity { target: target as f32, max_force: max_force as f32 } }
}

const LIFT_SPEED: f64 = 1.0;
const PLATFORM_MASS: f64 = 50.0;

pub(crate) fn elevator(params: &mut Params) -> Result<Scene, SceneError> {
    let load = params.number("load", 5000.0, 1.0e-3..=1.0e7)?;
    let has_stop = params.switch("stop", false)?;
    let (mut scene, rate) = start_at_rate(params, 4.0)?;
    let base = scene.body(BodyDef::fixed(Pose::IDENTITY));
    let start = DVec3::Y * 2.0;
    let platform = scene.body(solid(Pose::at(start), cuboid(1.0, 0.1, 1.0)?, PLATFORM_MASS as f32));
    let crate_ = scene.body(solid(Pose::at(start + DVec3::new(0.2, 0.4, 0.1)), cuboid(0.3, 0.3, 0.3)?, load as f32));
    let stop = if has_stop { 2.0 } else { f64::INFINITY };
    let limits = if has_stop { Limits::new(-1.0, stop as f32) } else { Limits::NONE };
    let kind = slider(LIFT_SPEED, f64::INFINITY, limits);
    let rail = scene.join(base, platform, kind, &Pose::at(start).rotated(x_to(DVec3::Y)));
    let steps = scene.steps;
    scene.judge(Reading::worst_of_last(steps, "behind_m", move |view| {
        let told = (LIFT_SPEED * view.time).min(stop);
        (view.engine.pose(platform).position.y - start.y - told).abs()
    }));
    scene.judge(Reading::worst_of_last(steps, "hop_m", move |view| {
        (view.engine.pose(crate_).position.y - view.engine.pose(platform).position.y - 0.4).abs()
    }));
    scene.judge(LoadError::new(rail, (load + PLATFORM_MASS) * f64::from(GRAVITY), (0.5 * rate) as u32));
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

pub(crate) fn gripper(params: &mut Params) -> Result<Scene, SceneError> {
    let load = params.number("load", 20.0, 1.0e-3..=1.0e6)?;
    let finger = params.number("finger", 0.3, 1.0e-3..=1.0e6)?;
    let force = params.number("force", 700.0, 0.0..=1.0e7)?;
    let (mut scene, rate) = start_at_rate(params, 3.0)?;
    scene.body(floor(3.0, 0.0, 0.5)?);
    let start = DVec3::Y * 0.6;
    let palm = scene.body(BodyDef::kinematic(Pose::at(start)).with_shape(cuboid(0.3, 0.05, 0.1)?));
    let held = scene.body(solid(Pose::at_xyz(0.0, 0.1, 0.0), with_friction(cuboid(0.1, 0.1, 0.1)?, 0.6), load as f32));
    for side in [-1.0, 1.0] {
        let at = DVec3::new(0.1205 * side, 0.15, 0.0);
        let shape = with_friction(cuboid(0.02, 0.1, 0.08)?, 0.6);
        let finger = scene.body(solid(Pose::at(at), shape, finger as f32));
        scene.join(palm, finger, slider(-0.3 * side, force, Limits::NONE), &Pose::at(at));
    }
    // It closes in the first half second; then the palm rises, and is shaken.
    let grasped = (0.5 * rate).round() as u32;
    let way = |time: f64| 0.01 * (1.0 - libm::cos(8.0 * PI * time));
    for step in grasped..scene.steps {
        let time = f64::from(step - grasped) / rate;
        let aside = (way(time + 1.0 / rate) - way(time)) * rate;
        scene.at(step, Action::SetLinearVelocity(palm, Vec3::new(aside as f32, 0.1, 0.0)));
    }
    let from = std::cell::Cell::new(0.0);
    let steps = scene.steps;
    scene.judge(Reading::worst_of_last(steps, "slid_m", move |view| {
        let above = view.engine.pose(held).position.y - view.engine.pose(palm).position.y;
        if view.step <= grasped {
            from.set(above);
        }
        (above - from.get()).abs()
    }));
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

const ARM_MASS: f64 = 1.0;
const SLANT: f64 = 0.3;
const DECK_MASS: f64 = 20.0;

pub(crate) fn scissor_lift(params: &mut Params) -> Result<Scene, SceneError> {
    let stages = params.count("stages", 8, 1..=50)?;
    let load = params.number("load", 2000.0, 1.0e-3..=1.0e7)?;
    let (mut scene, rate) = start_at_rate(params, 3.0)?;
    let base = scene.body(BodyDef::fixed(Pose::IDENTITY));
    let (rise, width) = (2.0 * libm::sin(SLANT), 2.0 * libm::cos(SLANT));
    let (middle, top) = (0.5 * width, rise * stages as f64);
    let pin = |scene: &mut Scene, a: usize, b: usize, at: DVec3| scene.hinge(a, b, JointKind::HINGE, at, DVec3::Z);
    let part = |scene: &mut Scene, at: DVec3, turn: f64, half: Vec3, mass: f64| -> Result<usize, SceneError> {
        let pose = Pose::at(at).rotated(Quat::from_rotation_z(turn as f32));
        Ok(scene.body(filtered(solid(pose, cuboid(half.x, half.y, half.z)?, mass as f32), INTANGIBLE)))
    };
    let foot = part(&mut scene, DVec3::X * width, 0.0, Vec3::splat(0.05), 5.0)?;
    let mut below = [base, foot];
    for stage in 0..stages {
        let height = rise * stage as f64;
        let at = DVec3::new(middle, height + 0.5 * rise, 0.0);
        let arm = Vec3::new(1.0, 0.03, 0.03);
        let arms = [part(&mut scene, at, SLANT, arm, ARM_MASS)?, part(&mut scene, at, -SLANT, arm, ARM_MASS)?];
        pin(&mut scene, arms[0], arms[1], at);
        pin(&mut scene, below[0], arms[0], DVec3::Y * height);
        pin(&mut scene, below[1], arms[1], DVec3::new(width, height, 0.0));
        below = [arms[1], arms[0]];
    }
    let rail = scene.join(base, foot, slider(0.0, f64::INFINITY, Limits::NONE), &Pose::at(DVec3::X * width));
    let at = DVec3::new(middle, top + 0.1, 0.0);
    let deck = scene.body(solid(Pose::at(at), with_friction(cuboid(1.0, 0.05, 0.5)?, 0.6), DECK_MASS as f32));
    pin(&mut scene, deck, below[0], DVec3::Y * top);
    let runner = part(&mut scene, DVec3::new(width, top, 0.0), 0.0, Vec3::splat(0.05), 1.0)?;
    pin(&mut scene, runner, below[1], DVec3::new(width, top, 0.0));
    scene.join(deck, runner, JointKind::PRISMATIC, &Pose::at(DVec3::new(width, top, 0.0)));
    let high = DVec3::Y * 0.35;
    let crate_ = scene.body(solid(Pose::at(at + high), with_friction(cuboid(0.3, 0.3, 0.3)?, 0.6), load as f32));
    let steps = scene.steps;
    scene.judge(Reading::worst_of_last(steps, "sunk_m", move |view| (view.engine.pose(crate_).position - at - high).length()));
    // The foot closes by 2 sin θ of what each stage rises by 2 cos θ; arms of a stage rise with its middle.
    let n = stages as f64;
    let weights = (DECK_MASS + load + 1.0) * n + ARM_MASS * n * n;
    let along = weights * f64::from(GRAVITY) / libm::tan(SLANT);
    // Across its way the foot bears half the weight and its own.
    let across = (0.5 * (DECK_MASS + load + 1.0 + 2.0 * ARM_MASS * n) + 5.0) * f64::from(GRAVITY);
    scene.judge(LoadError::new(rail, libm::hypot(along, across), rate as u32));
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use crate::catalogue::build;

    #[test]
    fn a_lift_has_two_arms_a_stage() {
        let scene = build("scissor_lift", &[("stages".into(), "3".into())]).unwrap();
        assert_eq!((scene.bodies.len(), scene.joints.len()), (1 + 6 + 4, 3 * 3 + 4));
    }
}
