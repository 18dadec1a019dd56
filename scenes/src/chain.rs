//! Chains with a weight: hanging and swinging.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, Geometry, Mass, Pose};

use crate::against::{judge_ball_tree, planar_link};
use crate::metrics::{EnergyError, JointGap, LoadError, MotionError, Stretch};
use crate::params::{Params, SceneError};
use crate::reference::{PlanarChain, SUBSTEPS};
use crate::scene::{DT, GRAVITY, Scene, cuboid, shape, spherical, start};

/// Distance between the joints of a chain (m).
pub const PITCH: f32 = 0.2;
const RADIUS: f32 = 0.02;
const WEIGHT_HALF: f32 = 0.5;
/// Errors count over the last two seconds.
const LAST: u32 = 120;

/// A chain and a weight that hang from the origin along `along` at rest.
pub(crate) struct Chain {
    pub links: Vec<usize>,
    pub weight: usize,
    pub joints: Vec<usize>,
}

/// Adds a static anchor above the origin, `n` links of 1 kg and a weight of `weight` kg.
pub(crate) fn add_chain(scene: &mut Scene, n: usize, weight: f32, turn: Quat) -> Result<Chain, SceneError> {
    let anchor = scene.body(BodyDef::fixed(Pose::at_xyz(0.0, 0.1, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1)?));
    let along = turn.as_dquat() * DVec3::NEG_Y;
    let capsule = shape(Geometry::Capsule { half_height: PITCH / 2.0 - RADIUS, radius: RADIUS })?;
    let pitch = f64::from(PITCH);
    let place = |distance: f64| Pose::at(along * distance).rotated(turn);

    let mut above = (anchor, Vec3::new(0.0, -0.1, 0.0));
    let mut chain = Chain { links: Vec::new(), weight: 0, joints: Vec::new() };
    for index in 0..n {
        let pose = place(pitch * (index as f64 + 0.5));
        let link = scene.body(BodyDef::dynamic(pose).with_shape(capsule.clone()).with_mass(Mass::Total(1.0)));
        chain.joints.push(scene.joint(Some(above.0), Some(link), spherical(above.1, Vec3::Y * (PITCH / 2.0))));
        chain.links.push(link);
        above = (link, Vec3::Y * (-PITCH / 2.0));
    }
    let pose = place(pitch * n as f64 + f64::from(WEIGHT_HALF));
    let solid = cuboid(WEIGHT_HALF, WEIGHT_HALF, WEIGHT_HALF)?;
    chain.weight = scene.body(BodyDef::dynamic(pose).with_shape(solid).with_mass(Mass::Total(weight)));
    chain.joints.push(scene.joint(Some(above.0), Some(chain.weight), spherical(above.1, Vec3::Y * WEIGHT_HALF)));
    Ok(chain)
}

fn n_and_ratio(params: &mut Params) -> Result<(usize, f32), SceneError> {
    Ok((params.count("n", 30, 1..=10_000)?, params.number("ratio", 1.0e4, 1.0e-3..=1.0e9)? as f32))
}

pub(crate) fn hanging_chain(params: &mut Params) -> Result<Scene, SceneError> {
    let (n, ratio) = n_and_ratio(params)?;
    let with_reference = params.switch("reference", false)?;
    let mut scene = start(params, 10.0)?;
    let chain = add_chain(&mut scene, n, ratio, Quat::IDENTITY)?;
    for &body in chain.links.iter().chain([&chain.weight]) {
        scene.bodies[body].linear_velocity = Vec3::new(0.2, 0.0, 0.0);
    }
    let weight = (n as f64 + f64::from(ratio)) * f64::from(GRAVITY);
    scene.judge(Stretch::new(chain.joints.clone(), n as f64 * f64::from(PITCH), LAST));
    scene.judge(JointGap::over_last(LAST));
    scene.judge(LoadError::new(chain.joints[0], weight, LAST));
    if with_reference {
        judge_ball_tree(&mut scene);
    }
    Ok(scene)
}

pub(crate) fn swinging_weight(params: &mut Params) -> Result<Scene, SceneError> {
    let (n, ratio) = n_and_ratio(params)?;
    let mut scene = start(params, 4.0)?;
    scene.window = 0..scene.steps;
    let to_horizontal = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let chain = add_chain(&mut scene, n, ratio, to_horizontal)?;
    let steps = scene.steps;
    let length = n as f64 * f64::from(PITCH);
    let weight_length = f64::from(WEIGHT_HALF);
    let greatest_fall = f64::from(GRAVITY) * (f64::from(ratio) * (length + weight_length) + 0.5 * n as f64 * length);

    let reference = reference_chain(&scene, &chain);
    let motion = |mut reference: PlanarChain, substeps: u32| {
        let mut done = 0;
        move |step: u32| {
            while done < step {
                reference.advance(f64::from(DT), substeps);
                done += 1;
            }
            vec![reference.last_center().extend(0.0)]
        }
    };
    let (exact, coarser) = (motion(reference.clone(), SUBSTEPS), motion(reference, SUBSTEPS / 2));
    scene.judge(MotionError::new(vec![chain.weight], exact, coarser));
    scene.judge(Stretch::new(chain.joints.clone(), length, steps));
    scene.judge(JointGap::over_last(steps));
    scene.judge(EnergyError::new("energy_drift_pct", Some("energy_rise_pct"), Some(greatest_fall)));
    Ok(scene)
}

/// The same chain in minimal coordinates, with the masses that the engines get.
fn reference_chain(scene: &Scene, chain: &Chain) -> PlanarChain {
    let links = chain.links.iter().map(|&body| planar_link(scene, body, PITCH / 2.0));
    PlanarChain::horizontal(links.chain([planar_link(scene, chain.weight, WEIGHT_HALF)]).collect(), f64::from(GRAVITY))
}
