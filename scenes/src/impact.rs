//! Blows and bad births: a bullet at a wall, a box born in the floor, a box that may only move along its axes.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, LockedAxes, Pose};

use crate::metrics::{Escaped, LockedDrift, Overlap, PoseSpeed};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, ball, cuboid, floor, start, start_in, weightless};

/// `escaped` counts the ball if it comes to be behind the wall.
pub(crate) fn bullet(params: &mut Params) -> Result<Scene, SceneError> {
    let speed = params.number("speed", 500.0, 1.0..=1.0e4)? as f32;
    let wall = params.number("wall_mm", 10.0, 0.1..=1000.0)? * 1e-3;
    let mut scene = start_in(weightless(), params, 2.0)?;
    let (def, before_wall) = add_wall_and_ball(&mut scene, 0.5 * wall as f32, -10.0, speed)?;
    scene.body(def);
    scene.judge(before_wall);
    Ok(scene)
}

/// Adds a wall at x = 0 and returns a ball flying at it from `start`, flagged fast, and a metric that counts it behind the wall.
pub(crate) fn add_wall_and_ball(
    scene: &mut Scene,
    half_thickness: f32,
    start: f64,
    speed: f32,
) -> Result<(BodyDef, Escaped), SceneError> {
    scene.body(BodyDef::fixed(Pose::IDENTITY).with_shape(cuboid(half_thickness, 50.0, 50.0)?));
    let mut def = BodyDef::dynamic(Pose::at_xyz(start, 0.0, 0.0)).with_shape(ball(0.05)?);
    def.linear_velocity = Vec3::X * speed;
    def.fast = true;
    let far = 1.0e5;
    Ok((def, Escaped::from(DVec3::splat(-far), DVec3::new(0.0, far, far))))
}

pub(crate) fn half_sunk(params: &mut Params) -> Result<Scene, SceneError> {
    let depth = params.number("depth", 0.5, 0.0..=0.9)?;
    let mut scene = start(params, 5.0)?;
    scene.body(floor(20.0, 0.0, 0.5)?);
    scene.body(BodyDef::dynamic(Pose::at_xyz(0.0, 0.5 - depth, 0.0)).with_shape(cuboid(0.5, 0.5, 0.5)?));
    let steps = scene.steps;
    scene.judge(PoseSpeed::over_last(steps));
    scene.judge(Overlap::at_end());
    Ok(scene)
}

/// A box that may slide along x and y and turn about z only, struck off centre by a heavy ball.
pub(crate) fn locked_axes(params: &mut Params) -> Result<Scene, SceneError> {
    let mut scene = start(params, 4.0)?;
    scene.body(floor(50.0, 0.0, 0.5)?);
    let mut held = BodyDef::dynamic(Pose::at_xyz(0.0, 0.5, 0.0)).with_shape(cuboid(0.3, 0.5, 0.2)?);
    held.locked_axes = LockedAxes { translation: [false, false, true], rotation: [true, true, false] };
    scene.body(held);
    let mut thrown = BodyDef::dynamic(Pose::at_xyz(-2.0, 0.8, -1.9)).with_shape(ball(0.2)?);
    thrown.linear_velocity = Vec3::new(6.0, 1.0, 6.0);
    scene.body(thrown);
    scene.judge(LockedDrift::default());
    Ok(scene)
}
