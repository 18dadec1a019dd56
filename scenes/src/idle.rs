//! What must cost nothing: bodies asleep, and features that a scene does not use.

use longspan::glam::Quat;
use longspan::{BodyDef, Geometry, Pose, WorldDef};

use crate::chain::add_chain;
use crate::metrics::{Awake, EndSpeeds, Overlap, PoseSpeed};
use crate::params::{Params, SceneError};
use crate::pile;
use crate::random::Random;
use crate::scene::{Scene, ball, cuboid, floor, shape, start, start_in, weightless};

pub(crate) fn idle(params: &mut Params) -> Result<Scene, SceneError> {
    match params.word("what", &["asleep", "no_joints", "no_static"])? {
        "asleep" => asleep(params),
        "no_joints" => pile::pile(params),
        _ => no_static(params),
    }
}

/// Boxes that lie on the floor, apart from one another, and fall asleep; time counts once they do.
fn asleep(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 10_000, 1..=1_000_000)?;
    let mut scene = start_in(WorldDef::default(), params, 6.0)?;
    scene.window = scene.steps / 2..scene.steps;
    let row = (n as f64).sqrt().ceil() as usize;
    scene.body(floor(row as f32, 0.0, 0.5)?);
    let solid = cuboid(0.25, 0.25, 0.25)?;
    for index in 0..n {
        let along = |place: usize| place as f64 - 0.5 * row as f64;
        let pose = Pose::at_xyz(along(index % row), 0.25, along(index / row));
        scene.body(BodyDef::dynamic(pose).with_shape(solid.clone()));
    }
    scene.judge(Awake::default());
    scene.judge(EndSpeeds::default());
    Ok(scene)
}

/// Boxes that drift and collide without gravity and without anything static.
fn no_static(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 1000, 1..=1_000_000)?;
    let mut random = Random::new(params.seed()?);
    let mut scene = start_in(weightless(), params, 4.0)?;
    let row = libm::cbrt(n as f64).ceil() as usize;
    let solid = cuboid(0.25, 0.25, 0.25)?;
    for index in 0..n {
        let place = |part: usize| (part % row) as f64 * 0.8;
        let pose = Pose::at_xyz(place(index), place(index / row), place(index / row / row));
        let mut def = BodyDef::dynamic(pose).with_shape(solid.clone());
        def.linear_velocity = random.vector(0.5);
        def.angular_velocity = random.vector(1.0);
        scene.body(def);
    }
    scene.judge(EndSpeeds::default());
    Ok(scene)
}

/// Three boxes on one another, balls, lying capsules, and a weight on a short chain: awake, and still.
pub(crate) fn resting(params: &mut Params) -> Result<Scene, SceneError> {
    let mut scene = start(params, 4.0)?;
    add_chain(&mut scene, 3, 10.0, Quat::IDENTITY)?;
    scene.body(floor(20.0, -4.0, 0.5)?);
    let (solid, round) = (cuboid(0.25, 0.25, 0.25)?, ball(0.25)?);
    let long = shape(Geometry::Capsule { half_height: 0.3, radius: 0.2 })?;
    for row in 0..3 {
        let at = |x: f64, height: f64| Pose::at_xyz(x, -4.0 + height, 2.0 + f64::from(row));
        scene.body(BodyDef::dynamic(at(-3.0, 0.25)).with_shape(round.clone()));
        let lying = at(3.0, 0.2).rotated(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2));
        scene.body(BodyDef::dynamic(lying).with_shape(long.clone()));
        let stacked = Pose::at_xyz(0.0, -3.75 + 0.5 * f64::from(row), 3.0);
        scene.body(BodyDef::dynamic(stacked).with_shape(solid.clone()));
    }
    scene.judge(PoseSpeed::over_last(60));
    scene.judge(Overlap::at_end());
    Ok(scene)
}
