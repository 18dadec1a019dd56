//! Mobiles, branched trees and trees closed to loops: light rods on ball joints with heavy boxes at every end.
//!
//! *Mobile*: `levels` levels of bars, each hung at its middle, 5 cm above its axis, by a rod of 0.2 m, with the next level at both
//! tips; at the tips of the last, rods with boxes of `ratio` kg (half-extent 0.25 m). Bars lie along x and z by turns; the last is
//! 1.2 m long, and every second level above it twice as long. Rods and bars: capsules of radius 0.02 m, 1 kg. 5 levels make
//! 31·2 + 32·2 = 126 bodies and 126 joints. Every body starts with 0.2 m/s along z.
//!
//! *Tree*: n rods (0.2 m, 1 kg) from the origin on, each at the tip of a random earlier one that has fewer than three, in a random
//! direction that leans downwards; a box (half-extent 0.1 m, `ratio` kg) at every tip that nothing else hangs from. It falls from
//! rest. *Loop graph*: the same with `loops` rods more, between random tips 0.1 m to 1 m apart.
//!
//! With `reference=on` the mobile is compared with its exact motion, over 2 s unless set otherwise.
//!
//! No two bodies touch: rods that grow at random start inside one another.

use longspan::Pose;
use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyKind};

use crate::against::judge_ball_tree;
use crate::assemble::{INTANGIBLE, filtered, rod, solid};
use crate::metrics::{EnergyError, JointGap, Stretch};
use crate::params::{Params, SceneError};
use crate::random::Random;
use crate::scene::{GRAVITY, Scene, cuboid, start};

const ROD: f64 = 0.2;
const RADIUS: f32 = 0.02;
const LIGHT: f32 = 1.0;
/// From the point a bar hangs by down to its axis (m).
const PIVOT: f64 = 0.05;
const SMALLEST_HALF_BAR: f64 = 0.6;
/// Most rods at the tip of one.
const BRANCHES: usize = 3;
/// Errors count over the last two seconds.
const LAST: u32 = 120;

/// A series of joints and its length at rest (m).
type Path = (Vec<usize>, f64);

/// What hangs at the end of a path of joints.
struct Held {
    body: usize,
    tip: DVec3,
    path: Path,
}

impl Held {
    /// The path with one more joint at its tip and `length` (m) of another body.
    fn longer(&self, joint: usize, length: f64) -> Path {
        let mut path = self.path.clone();
        path.0.push(joint);
        path.1 += length;
        path
    }
}

/// A static box above the origin, with nothing between it and there.
fn anchor(scene: &mut Scene) -> Result<Held, SceneError> {
    let shape = cuboid(0.1, 0.1, 0.1)?;
    let body = scene.body(filtered(BodyDef::fixed(Pose::at_xyz(0.0, 0.1, 0.0)).with_shape(shape), INTANGIBLE));
    Ok(Held { body, tip: DVec3::ZERO, path: (Vec::new(), 0.0) })
}

/// A rod from the tip of `held` to `tip`.
fn hang_rod(scene: &mut Scene, held: &Held, tip: DVec3) -> Result<Held, SceneError> {
    let body = scene.body(filtered(rod(held.tip, tip, RADIUS, LIGHT)?, INTANGIBLE));
    let joint = scene.tie(held.body, body, held.tip);
    Ok(Held { body, tip, path: held.longer(joint, held.tip.distance(tip)) })
}

/// A box at the tip of `held`, by the middle of its top.
fn hang_box(scene: &mut Scene, held: &Held, half: f32, mass: f32) -> Result<Held, SceneError> {
    let pose = Pose::at(held.tip - DVec3::Y * f64::from(half));
    let body = scene.body(filtered(solid(pose, cuboid(half, half, half)?, mass), INTANGIBLE));
    let joint = scene.tie(held.body, body, held.tip);
    Ok(Held { body, tip: held.tip, path: held.longer(joint, 0.0) })
}

/// Adds a mobile and returns the path from its anchor to every box.
pub(crate) fn add_mobile(scene: &mut Scene, levels: usize, weight: f32) -> Result<Vec<Path>, SceneError> {
    let mut ends = vec![anchor(scene)?];
    for level in 0..levels {
        let below = levels - 1 - level;
        let reach = SMALLEST_HALF_BAR * f64::from(1 << (below / 2));
        let along = if below.is_multiple_of(2) { DVec3::X } else { DVec3::Z };
        let mut next = Vec::new();
        for end in &ends {
            let rod_below = hang_rod(scene, end, end.tip - DVec3::Y * ROD)?;
            let middle = rod_below.tip - DVec3::Y * PIVOT;
            let tips = [middle + along * reach, middle - along * reach];
            let bar = scene.body(filtered(rod(tips[0], tips[1], RADIUS, LIGHT)?, INTANGIBLE));
            let joint = scene.tie(rod_below.body, bar, rod_below.tip);
            let length = libm::hypot(PIVOT, reach);
            next.extend(tips.map(|tip| Held { body: bar, tip, path: rod_below.longer(joint, length) }));
        }
        ends = next;
    }
    ends.iter()
        .map(|end| {
            let rod_below = hang_rod(scene, end, end.tip - DVec3::Y * ROD)?;
            Ok(hang_box(scene, &rod_below, 0.25, weight)?.path)
        })
        .collect()
}

/// Adds a tree of `count` rods, with `loops` rods more between its tips, and returns the path from the anchor to every box.
pub(crate) fn add_tree(
    scene: &mut Scene,
    count: usize,
    loops: usize,
    weight: f32,
    random: &mut Random,
) -> Result<Vec<Path>, SceneError> {
    let mut rods: Vec<Held> = Vec::new();
    let mut children: Vec<usize> = Vec::new();
    let root = anchor(scene)?;
    for _ in 0..count {
        let lean = random.vector(1.0).as_dvec3() + 0.7 * DVec3::NEG_Y;
        let along = lean.try_normalize().unwrap_or(DVec3::NEG_Y);
        let free: Vec<usize> = (0..rods.len()).filter(|&rod| children[rod] < BRANCHES).collect();
        let parent = (!free.is_empty()).then(|| free[random.index(free.len())]);
        let held = parent.map_or(&root, |parent| &rods[parent]);
        let grown = hang_rod(scene, held, held.tip + along * ROD)?;
        if let Some(parent) = parent {
            children[parent] += 1;
        }
        rods.push(grown);
        children.push(0);
    }
    let mut closed = 0;
    while closed < loops {
        let (a, b) = (&rods[random.index(count)], &rods[random.index(count)]);
        if (0.1..1.0).contains(&a.tip.distance(b.tip)) {
            let closer = hang_rod(scene, a, b.tip)?;
            scene.tie(closer.body, b.body, b.tip);
            closed += 1;
        }
    }
    let leaves = rods.iter().zip(&children).filter(|(_, children)| **children == 0);
    leaves.map(|(rod, _)| Ok(hang_box(scene, rod, 0.1, weight)?.path)).collect()
}

/// Stretch of every path, gaps and energy of a scene that moves smoothly from its start.
fn judge(scene: &mut Scene, paths: Vec<Path>) {
    let fall = |body: &BodyDef| match body.mass {
        longspan::Mass::Properties(mass) if body.kind == BodyKind::Dynamic => f64::from(mass.mass),
        _ => 0.0,
    };
    let mass: f64 = scene.bodies.iter().map(fall).sum();
    let reach = paths.iter().map(|(_, length)| *length).fold(0.0, f64::max);
    scene.judge(Stretch::worst_of(paths, LAST));
    scene.judge(JointGap::over_last(LAST));
    let scale = mass * f64::from(GRAVITY) * reach;
    scene.judge(EnergyError::new("energy_drift_pct", Some("energy_rise_pct"), Some(scale)));
}

fn ratio(params: &mut Params) -> Result<f32, SceneError> {
    Ok(params.number("ratio", 1.0e4, 1.0e-3..=1.0e9)? as f32)
}

pub(crate) fn mobile(params: &mut Params) -> Result<Scene, SceneError> {
    let levels = params.count("levels", 5, 1..=12)?;
    let ratio = ratio(params)?;
    let with_reference = params.switch("reference", false)?;
    let mut scene = start(params, if with_reference { 2.0 } else { 10.0 })?;
    let paths = add_mobile(&mut scene, levels, ratio)?;
    for body in scene.bodies.iter_mut().filter(|body| body.kind == BodyKind::Dynamic) {
        body.linear_velocity = Vec3::Z * 0.2;
    }
    judge(&mut scene, paths);
    if with_reference {
        judge_ball_tree(&mut scene);
    }
    Ok(scene)
}

pub(crate) fn branched_tree(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("n", 100, 1..=10_000)?;
    let ratio = ratio(params)?;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, 5.0)?;
    let paths = add_tree(&mut scene, count, 0, ratio, &mut random)?;
    judge(&mut scene, paths);
    Ok(scene)
}

pub(crate) fn loop_graph(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("n", 100, 10..=10_000)?;
    let loops = params.count("loops", 25, 0..=10_000)?;
    let ratio = ratio(params)?;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, 5.0)?;
    let paths = add_tree(&mut scene, count, loops, ratio, &mut random)?;
    judge(&mut scene, paths);
    Ok(scene)
}
