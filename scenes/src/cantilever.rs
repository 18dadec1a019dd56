//! A chain of links with limited swing, held level and let go, so that it curls as far as its stops allow.
//!
//! n capsule links (0.2 m, radius 0.02 m, 1 kg) along x from a static box, then a box of half-extent 0.5 m and `ratio` kg, with ball
//! joints whose swing is limited to `swing` degrees about the straight. Nothing touches. 8 s; gap and limits over the whole run.

use longspan::glam::DVec3;
use longspan::{BodyDef, JointKind, Limits, Pose, SphericalMotor};

use crate::assemble::{INTANGIBLE, filtered, rod, solid};
use crate::metrics::{EnergyError, JointGap, Stretch, SwingOvershoot};
use crate::params::{Params, SceneError};
use crate::scene::{GRAVITY, Scene, cuboid, start};

const PITCH: f64 = 0.2;
const RADIUS: f32 = 0.02;
const WEIGHT_HALF: f32 = 0.5;

pub(crate) fn cantilever(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("n", 30, 1..=2000)?;
    let ratio = params.number("ratio", 1.0e4, 1.0e-3..=1.0e9)?;
    let swing = params.number("swing", 30.0, 0.0..=180.0)?;
    let mut scene = start(params, 8.0)?;

    let swing_limit = swing.to_radians() as f32;
    let kind = JointKind::Spherical { swing_limit, twist_limits: Limits::NONE, motor: SphericalMotor::Off };
    let anchor = BodyDef::fixed(Pose::at_xyz(-0.1, 0.0, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1)?);
    let mut held = scene.body(filtered(anchor, INTANGIBLE));
    let at = |index: usize| DVec3::X * (PITCH * index as f64);
    let mut joints = Vec::new();
    for index in 0..count {
        let link = scene.body(filtered(rod(at(index), at(index + 1), RADIUS, 1.0)?, INTANGIBLE));
        joints.push(scene.join(held, link, kind, &Pose::at(at(index))));
        held = link;
    }
    let pose = Pose::at(at(count) + DVec3::X * f64::from(WEIGHT_HALF));
    let shape = cuboid(WEIGHT_HALF, WEIGHT_HALF, WEIGHT_HALF)?;
    let weight = scene.body(filtered(solid(pose, shape, ratio as f32), INTANGIBLE));
    joints.push(scene.join(held, weight, kind, &Pose::at(at(count))));

    let length = PITCH * count as f64;
    let fall = f64::from(GRAVITY) * (ratio * (length + f64::from(WEIGHT_HALF)) + 0.5 * count as f64 * length);
    let steps = scene.steps;
    scene.judge(SwingOvershoot::default());
    scene.judge(JointGap::over_last(steps));
    scene.judge(Stretch::new(joints, length, steps));
    scene.judge(EnergyError::new("energy_drift_pct", Some("energy_rise_pct"), Some(fall)));
    Ok(scene)
}
