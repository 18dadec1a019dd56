//! What friction does: it carries, and it brings rolling and spinning to an end.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, Pose};

use crate::closed_form::properties_of;
use crate::metrics::{PoseSpeed, TrajectoryError, View};
use crate::outcome::{Distance, SpeedError};
use crate::params::{Params, SceneError};
use crate::scene::{GRAVITY, Scene, ball, cuboid, floor, start};

/// A box at rest on a platform that moves at a steady speed: it gains μ g until it moves with the platform.
pub(crate) fn platform(params: &mut Params) -> Result<Scene, SceneError> {
    let speed = params.number("speed", 1.0, 1.0e-3..=10.0)?;
    let mut scene = start(params, 4.0)?;
    let mut carrier = BodyDef::kinematic(Pose::at_xyz(0.0, -0.25, 0.0)).with_shape(cuboid(20.0, 0.25, 5.0)?);
    carrier.linear_velocity = Vec3::X * speed as f32;
    scene.body(carrier);
    let body = scene.body(BodyDef::dynamic(Pose::at_xyz(0.0, 0.25, 0.0)).with_shape(cuboid(0.25, 0.25, 0.25)?));
    let gain = 0.5 * f64::from(GRAVITY);
    scene.judge(TrajectoryError::new(body, "pos_err_max_m", Some("pos_err_rms_m"), move |_, t| {
        let slid = t.min(speed / gain);
        DVec3::new(0.5 * gain * slid * slid + speed * (t - slid), 0.25, 0.0)
    }));
    Ok(scene)
}

const RADIUS: f32 = 0.25;

/// A ball that rolls without slipping under rolling friction ρ: a = ρ g/(R (1 + I/(m R²))), and at rest in the end.
pub(crate) fn rolling(params: &mut Params) -> Result<Scene, SceneError> {
    let speed = params.number("speed", 2.0, 1.0e-3..=100.0)?;
    let arm = params.number("arm", 0.02, 1.0e-4..=0.1)?;
    let mut scene = start(params, 6.0)?;
    scene.body(floor(100.0, 0.0, 0.5)?);
    let mut solid = ball(RADIUS)?;
    solid.material.rolling_friction = arm as f32;
    let mut def = BodyDef::dynamic(Pose::at_xyz(0.0, f64::from(RADIUS), 0.0)).with_shape(solid);
    def.linear_velocity = Vec3::X * speed as f32;
    def.angular_velocity = Vec3::NEG_Z * (speed as f32 / RADIUS);
    let body = scene.body(def);
    let radius = f64::from(RADIUS);
    let loss = arm * f64::from(GRAVITY) / (radius * 1.4);
    scene.judge(Distance::new(body, move |t| {
        let rolled = t.min(speed / loss);
        speed * rolled - 0.5 * loss * rolled * rolled
    }));
    scene.judge(PoseSpeed::over_last(30));
    Ok(scene)
}

/// A ball spinning on the spot under spinning friction σ: ω(t) = max(0, ω₀ − σ m g t/I).
pub(crate) fn spinning(params: &mut Params) -> Result<Scene, SceneError> {
    let spin = params.number("spin", 10.0, 1.0e-3..=100.0)?;
    let arm = params.number("arm", 0.01, 1.0e-4..=0.1)?;
    let mut scene = start(params, 4.0)?;
    scene.body(floor(20.0, 0.0, 0.5)?);
    let mut solid = ball(RADIUS)?;
    solid.material.spinning_friction = arm as f32;
    let mut def = BodyDef::dynamic(Pose::at_xyz(0.0, f64::from(RADIUS), 0.0)).with_shape(solid);
    def.angular_velocity = Vec3::Y * spin as f32;
    let body = scene.body(def);
    let mass = properties_of(&scene, body);
    let loss = arm * f64::from(mass.mass * GRAVITY / mass.principal_inertia.y);
    let spin_now = move |view: &View| f64::from(view.engine.angular_velocity(body).y);
    scene.judge(SpeedError::new("spin_err_pct", spin, spin_now, move |_, t| (spin - loss * t).max(0.0)));
    Ok(scene)
}
