//! Starts that no careful user would choose.
//!
//! `chain` (n links of the hanging chain), `mobile` (five levels), `tree` (n rods) and `graph` (n rods and a quarter as many that
//! close loops), all with heavy boxes of `ratio` kg and,
//! but for a chain with `touching=on`, without contacts: every body thrown with up to ±10 m/s along each axis and spun with up to
//! ±20 rad/s about each. `held` says whether energy never doubled and all joints were closed to a millimetre at the end: from five
//! seconds on, or at the last step of a shorter run. `joints`: boxes in joints of every kind, tied at random. `limits`: hinges past their stops. `overlap`: boxes
//! inside one another.

use longspan::glam::{Quat, Vec3};
use longspan::{BodyDef, BodyId, BodyKind, JointDef, JointKind, Limits, Mass, Motor, Pose};

use crate::assemble::INTANGIBLE;
use crate::branching::{add_mobile, add_tree};
use crate::chain;
use crate::metrics::{EnergyGrowth, Held, HingeOvershoot, JointGap, Metric, NotFinite, PeakSpeed};
use crate::params::{Params, SceneError};
use crate::random::Random;
use crate::scene::{Scene, about_z, cuboid, floor, spherical, start};

/// Greatest speed along each axis (m/s).
const SPEED: f32 = 10.0;
/// Greatest spin about each axis (rad/s).
const SPIN: f32 = 20.0;
const MOBILE_LEVELS: usize = 5;

pub(crate) fn violent(params: &mut Params) -> Result<Scene, SceneError> {
    let what = params.word("what", &["chain", "mobile", "tree", "graph", "joints", "limits", "overlap"])?;
    let n = match what {
        "mobile" => 0,
        "tree" => params.count("n", 500, 2..=10_000)?,
        "chain" | "graph" => params.count("n", 100, 10..=10_000)?,
        _ => params.count("n", 10, 2..=1000)?,
    };
    let touching = what == "chain" && params.switch("touching", false)?;
    let ratio = params.number("ratio", 100.0, 1.0..=1.0e6)? as f32;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, 6.0)?;
    scene.window = 0..scene.steps;
    match what {
        "chain" => thrown_chain(&mut scene, n, ratio, touching)?,
        "mobile" => drop(add_mobile(&mut scene, MOBILE_LEVELS, ratio)?),
        "tree" => drop(add_tree(&mut scene, n, 0, ratio, &mut random)?),
        "graph" => drop(add_tree(&mut scene, n, n / 4, ratio, &mut random)?),
        "joints" => tied_boxes(&mut scene, n, ratio, &mut random)?,
        "limits" => violated_limits(&mut scene, n, &mut random)?,
        _ => deep_overlap(&mut scene, n, &mut random)?,
    }
    let is_torn = ["chain", "mobile", "tree", "graph"].contains(&what);
    let metrics = judges(&scene);
    if is_torn {
        throw(&mut scene, &mut random);
        scene.judge(Held::new(metrics, vec![("energy_growth_pct", 100.0), ("non_finite", 0.0), ("joint_gap_m", 1.0e-3)]));
    } else {
        scene.metrics.extend(metrics);
    }
    if what == "limits" {
        let after = scene.steps / 2;
        scene.judge(HingeOvershoot::since(after));
    }
    Ok(scene)
}

/// The hanging chain; without `touching` its links pass through one another, as those of the trees do.
fn thrown_chain(scene: &mut Scene, n: usize, ratio: f32, touching: bool) -> Result<(), SceneError> {
    chain::add_chain(scene, n, ratio, Quat::IDENTITY)?;
    if !touching {
        for shape in scene.bodies.iter_mut().flat_map(|body| &mut body.shapes) {
            shape.filter = INTANGIBLE;
        }
    }
    Ok(())
}

/// Throws and spins every body that can move.
fn throw(scene: &mut Scene, random: &mut Random) {
    for body in scene.bodies.iter_mut().filter(|body| body.kind == BodyKind::Dynamic) {
        body.linear_velocity = random.vector(SPEED);
        body.angular_velocity = random.vector(SPIN);
    }
}

/// Nothing may grow, nothing may stop being a number, and what was torn must close.
fn judges(scene: &Scene) -> Vec<Box<dyn Metric>> {
    let after = scene.steps.saturating_sub(300).max(1);
    vec![
        Box::new(EnergyGrowth::default()),
        Box::new(NotFinite::default()),
        Box::new(PeakSpeed::default()),
        Box::new(JointGap::over_last(after)),
    ]
}

/// Boxes thrown about, tied by a random tree and half as many joints more, of every kind; one body hangs from the world.
fn tied_boxes(scene: &mut Scene, n: usize, ratio: f32, random: &mut Random) -> Result<(), SceneError> {
    for _ in 0..n {
        let half = Vec3::new(random.between(0.05, 0.3), random.between(0.05, 0.3), random.between(0.05, 0.3));
        let pose = Pose::at(random.vector(2.0).as_dvec3()).rotated(random.rotation());
        let mut shape = cuboid(half.x, half.y, half.z)?;
        // Joints, not contacts, are what this scene is about.
        shape.filter.collides_with = 0;
        let mass = Mass::Total(random.log_between(1.0, ratio.max(1.1)));
        let mut def = BodyDef::dynamic(pose).with_shape(shape).with_mass(mass);
        def.linear_velocity = random.vector(SPEED);
        def.angular_velocity = random.vector(SPIN);
        scene.body(def);
    }
    let mut pairs: Vec<(usize, usize)> = (1..n).map(|body| (random.index(body), body)).collect();
    for _ in 0..n / 2 {
        let (a, b) = (random.index(n), random.index(n));
        if a != b {
            pairs.push((a, b));
        }
    }
    for (a, b) in pairs {
        let def = random_joint(scene, a, b, random);
        scene.joint(Some(a), Some(b), def);
    }
    let hung = spherical_to_world(scene.bodies[0].pose);
    scene.joint(None, Some(0), hung);
    Ok(())
}

fn spherical_to_world(pose: Pose) -> JointDef {
    let mut def = spherical(Vec3::ZERO, Vec3::ZERO);
    def.frame_a = pose;
    def
}

/// A joint of a random kind whose frames agree at the start, halfway between two bodies.
pub(crate) fn random_joint(scene: &Scene, a: usize, b: usize, random: &mut Random) -> JointDef {
    let (pose_a, pose_b) = (scene.bodies[a].pose, scene.bodies[b].pose);
    let shared = Pose::at(0.5 * (pose_a.position + pose_b.position)).rotated(random.rotation());
    let distance = pose_a.position.distance(pose_b.position) as f32;
    let kind = match random.index(5) {
        0 => JointKind::Fixed,
        1 => JointKind::HINGE,
        2 => JointKind::PRISMATIC,
        3 => {
            let limits = Limits::new(0.5 * distance, distance);
            let kind = JointKind::Distance { limits, spring_length: None, motor: Motor::Off };
            return JointDef::new(kind, BodyId::NULL, BodyId::NULL);
        }
        _ => JointKind::SPHERICAL,
    };
    let local = |pose: Pose| {
        let back = pose.rotation.conjugate();
        let position = pose.inverse_transform_point(shared.position).as_dvec3();
        Pose { position, rotation: (back * shared.rotation).normalize() }
    };
    let mut def = JointDef::new(kind, BodyId::NULL, BodyId::NULL);
    def.frame_a = local(pose_a);
    def.frame_b = local(pose_b);
    def
}

/// A chain of hinges, each up to a radian past its stops at the start.
pub(crate) fn violated_limits(scene: &mut Scene, n: usize, random: &mut Random) -> Result<(), SceneError> {
    let mut above = scene.body(BodyDef::fixed(Pose::IDENTITY).with_shape(cuboid(0.05, 0.05, 0.05)?));
    let mut arm = Vec3::ZERO;
    for index in 0..n {
        let pose = Pose::at_xyz(0.0, -0.2 - 0.4 * index as f64, 0.0);
        let body = scene.body(BodyDef::dynamic(pose).with_shape(cuboid(0.05, 0.18, 0.05)?));
        let past = random.between(0.0, 1.0);
        let limits = Limits::new(past, past + random.between(0.0, 0.5));
        let kind = JointKind::Hinge { limits, motor: Motor::Off };
        scene.joint(Some(above), Some(body), about_z(kind, arm, Vec3::Y * 0.2));
        (above, arm) = (body, Vec3::Y * -0.2);
    }
    Ok(())
}

/// Boxes created inside one another above a floor.
pub(crate) fn deep_overlap(scene: &mut Scene, n: usize, random: &mut Random) -> Result<(), SceneError> {
    scene.body(floor(50.0, 0.0, 0.5)?);
    let solid = cuboid(0.25, 0.25, 0.25)?;
    for _ in 0..n {
        let spread = random.vector(0.4);
        let pose = Pose::at(spread.as_dvec3() + longspan::glam::DVec3::Y);
        let turn: Quat = random.rotation();
        scene.body(BodyDef::dynamic(pose.rotated(turn)).with_shape(solid.clone()));
    }
    Ok(())
}
