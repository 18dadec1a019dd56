//! Chains with a weight, hanging and swinging, and chains picked up by a hand.
//!
//! `links=mixed` gives the links of a hanging or lifted chain other lengths than the pitch of 0.2 m: 0.063 to 0.63 m, evenly spread
//! in the logarithm and in no order.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, Geometry, Mass, Pose, ShapeDef};

use crate::against::{judge_ball_tree, planar_link};
use crate::assemble::{INTANGIBLE, filtered};
use crate::metrics::{DrivenEnergy, EnergyError, JointGap, LoadError, MotionError, Stretch};
use crate::params::{Params, SceneError};
use crate::reference::{PlanarChain, SUBSTEPS};
use crate::scene::{Action, DT, GRAVITY, Scene, cuboid, shape, spherical, start};

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

/// Lengths of `n` links as `links` says (m).
fn lengths(params: &mut Params, n: usize) -> Result<Vec<f32>, SceneError> {
    let is_mixed = params.word("links", &["even", "mixed"])? == "mixed";
    // Multiples of the golden ratio fill the unit interval evenly.
    let share = |index: usize| (index as f64 * 0.618_034).fract();
    let length = |index: usize| if is_mixed { PITCH * libm::pow(10.0, share(index) - 0.5) as f32 } else { PITCH };
    Ok((0..n).map(length).collect())
}

fn capsule(length: f32) -> Result<ShapeDef, SceneError> {
    shape(Geometry::Capsule { half_height: length / 2.0 - RADIUS, radius: RADIUS })
}

fn total(lengths: &[f32]) -> f64 {
    lengths.iter().map(|&length| f64::from(length)).sum()
}

/// Adds a static anchor above the origin, `n` links of 1 kg and a weight of `weight` kg.
pub(crate) fn add_chain(scene: &mut Scene, n: usize, weight: f32, turn: Quat) -> Result<Chain, SceneError> {
    add_links(scene, &vec![PITCH; n], weight, turn)
}

/// The same with links of these lengths (m).
fn add_links(scene: &mut Scene, lengths: &[f32], weight: f32, turn: Quat) -> Result<Chain, SceneError> {
    let anchor = scene.body(BodyDef::fixed(Pose::at_xyz(0.0, 0.1, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1)?));
    let along = turn.as_dquat() * DVec3::NEG_Y;
    let place = |distance: f64| Pose::at(along * distance).rotated(turn);

    let mut above = (anchor, Vec3::new(0.0, -0.1, 0.0));
    let mut chain = Chain { links: Vec::new(), weight: 0, joints: Vec::new() };
    for (index, &length) in lengths.iter().enumerate() {
        let pose = place(total(&lengths[..index]) + 0.5 * f64::from(length));
        let link = scene.body(BodyDef::dynamic(pose).with_shape(capsule(length)?).with_mass(Mass::Total(1.0)));
        chain.joints.push(scene.joint(Some(above.0), Some(link), spherical(above.1, Vec3::Y * (length / 2.0))));
        chain.links.push(link);
        above = (link, Vec3::Y * (-length / 2.0));
    }
    let pose = place(total(lengths) + f64::from(WEIGHT_HALF));
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
    let lengths = lengths(params, n)?;
    let with_reference = params.switch("reference", false)?;
    let mut scene = start(params, 10.0)?;
    let chain = add_links(&mut scene, &lengths, ratio, Quat::IDENTITY)?;
    for &body in chain.links.iter().chain([&chain.weight]) {
        scene.bodies[body].linear_velocity = Vec3::new(0.2, 0.0, 0.0);
    }
    let weight = (n as f64 + f64::from(ratio)) * f64::from(GRAVITY);
    scene.judge(Stretch::new(chain.joints.clone(), total(&lengths), LAST));
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

/// Steps that the hand takes, height (m) that it lifts by, and damping of the links (1/s).
const LIFTING: u32 = 240;
const LIFT: f64 = 1.0;
const DAMPING: f32 = 3.0;

/// A chain of `n` links of 1 kg that lies along x, and is lifted by a metre at joint `at` of 0 to n by a kinematic hand: both its
/// sides fall and come to rest below the hand.
pub(crate) fn lifted_chain(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 100, 2..=10_000)?;
    let at = params.count("at", n / 2, 0..=n)?;
    let lengths = lengths(params, n)?;
    let mut scene = start(params, 8.0)?;
    let along_x = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let mut joints = Vec::new();
    for (index, &length) in lengths.iter().enumerate() {
        let pose = Pose::at(DVec3::X * (total(&lengths[..index]) + 0.5 * f64::from(length))).rotated(along_x);
        let link = BodyDef { linear_damping: DAMPING, angular_damping: DAMPING, ..BodyDef::dynamic(pose) };
        let link = link.with_shape(capsule(length)?).with_mass(Mass::Total(1.0));
        let link = scene.body(filtered(link, INTANGIBLE));
        if index > 0 {
            let before = Vec3::Y * (-lengths[index - 1] / 2.0);
            joints.push(scene.joint(Some(link - 1), Some(link), spherical(before, Vec3::Y * (length / 2.0))));
        }
    }
    let hand = scene.body(BodyDef::kinematic(Pose::at(DVec3::X * total(&lengths[..at]))));
    let (held, point) = if at < n { (at, 0.5 * lengths[at]) } else { (n - 1, -0.5 * lengths[n - 1]) };
    joints.push(scene.joint(Some(hand), Some(held), spherical(Vec3::ZERO, Vec3::Y * point)));
    let height = |step: u32| {
        let share = f64::from(step) / f64::from(LIFTING);
        LIFT * share * share * (3.0 - 2.0 * share)
    };
    for step in 0..LIFTING {
        let speed = (height(step + 1) - height(step)) / f64::from(DT);
        scene.at(step, Action::SetLinearVelocity(hand, Vec3::Y * speed as f32));
    }
    scene.at(LIFTING, Action::SetLinearVelocity(hand, Vec3::ZERO));
    scene.judge(Stretch::new(joints, total(&lengths), LAST / 2));
    scene.judge(JointGap::over_last(LAST / 2));
    scene.judge(DrivenEnergy::default());
    Ok(scene)
}

/// The same chain in minimal coordinates, with the masses that the engines get.
fn reference_chain(scene: &Scene, chain: &Chain) -> PlanarChain {
    let links = chain.links.iter().map(|&body| planar_link(scene, body, PITCH / 2.0));
    PlanarChain::horizontal(links.chain([planar_link(scene, chain.weight, WEIGHT_HALF)]).collect(), f64::from(GRAVITY))
}
