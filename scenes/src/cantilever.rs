//! A chain of links with limited swing, held level and let go, so that it curls as far as its stops allow.
//!
//! n capsule links (0.2 m, radius 0.02 m, 1 kg) along x from a static box, then a box of half-extent 0.5 m and `ratio` kg, with ball
//! joints whose swing is limited to `swing` degrees about the straight. Nothing touches. 8 s; gap and limits over the whole run.
//! With `reference=on` the box is compared with its exact motion, over 4 s unless set otherwise.

use longspan::glam::DVec3;
use longspan::{BodyDef, JointKind, Limits, Pose, SphericalMotor};

use crate::against::planar_link;
use crate::assemble::{INTANGIBLE, filtered, rod, solid};
use crate::metrics::{EnergyError, JointGap, MotionError, Stretch, SwingOvershoot};
use crate::params::{Params, SceneError};
use crate::reference::{Link, StoppedChain};
use crate::scene::{DT, GRAVITY, Scene, cuboid, start};

const PITCH: f64 = 0.2;
const RADIUS: f32 = 0.02;
const WEIGHT_HALF: f32 = 0.5;
/// Steps that the reference makes of one of the scene, and the coarser one that it is compared with.
const STEPS: u32 = 6400;
const COARSER_STEPS: u32 = 3200;

pub(crate) fn cantilever(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("n", 30, 1..=2000)?;
    let ratio = params.number("ratio", 1.0e4, 1.0e-3..=1.0e9)?;
    let swing = params.number("swing", 30.0, 0.0..=180.0)?;
    let with_reference = params.switch("reference", false)?;
    let mut scene = start(params, if with_reference { 4.0 } else { 8.0 })?;

    let swing_limit = swing.to_radians() as f32;
    let kind = JointKind::Spherical { swing_limit, twist_limits: Limits::NONE, motor: SphericalMotor::Off };
    let anchor = BodyDef::fixed(Pose::at_xyz(-0.1, 0.0, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1)?);
    let mut held = scene.body(filtered(anchor, INTANGIBLE));
    let at = |index: usize| DVec3::X * (PITCH * index as f64);
    let (mut joints, mut links) = (Vec::new(), Vec::new());
    for index in 0..count {
        let link = scene.body(filtered(rod(at(index), at(index + 1), RADIUS, 1.0)?, INTANGIBLE));
        joints.push(scene.join(held, link, kind, &Pose::at(at(index))));
        links.push(link);
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
    if with_reference {
        let chain = links.iter().map(|&link| planar_link(&scene, link, 0.5 * PITCH as f32));
        let chain: Vec<Link> = chain.chain([planar_link(&scene, weight, WEIGHT_HALF)]).collect();
        let reference = StoppedChain::horizontal(chain, f64::from(GRAVITY), swing.to_radians());
        let motion = |mut reference: StoppedChain, substeps: u32| {
            let mut done = 0;
            move |step: u32| {
                while done < step {
                    reference.advance(f64::from(DT), substeps);
                    done += 1;
                }
                reference.centers().last().map(|center| center.extend(0.0)).into_iter().collect()
            }
        };
        let (exact, coarser) = (motion(reference.clone(), STEPS), motion(reference, COARSER_STEPS));
        scene.judge(MotionError::new(vec![weight], exact, coarser));
    }
    Ok(scene)
}
