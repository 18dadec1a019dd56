//! Large scenes of the kind that engines publish their own times of: a sheet of joints, one large pyramid, many small ones, and a
//! rain of ragdolls.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, Pose};

use crate::assemble::{INTANGIBLE, filtered};
use crate::metrics::{EndSpeeds, Escaped, JointGap, Moved, Overlap, Stood};
use crate::params::{Params, SceneError};
use crate::ragdoll::add_ragdoll;
use crate::random::Random;
use crate::scene::{Scene, ball, cuboid, floor, spherical, start};

/// Radius of the balls of the sheet and distance between neighbours (m).
const GRID_RADIUS: f32 = 0.4;
const GRID_PITCH: f32 = 1.0;
/// Half the number of balls of the first row that are held, less a half.
const GRID_HELD: usize = 3;

/// n × n balls in an upright sheet, each in a spherical joint with the next of its row and of its column, seven in the middle of
/// the first row static, let fall. n = 100 makes 10,000 bodies and 19,794 joints in one articulation. Nothing collides.
pub(crate) fn joint_grid(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 100, 8..=400)?;
    let mut scene = start(params, 4.0)?;
    let solid = ball(GRID_RADIUS)?;
    let held = n / 2 - GRID_HELD..=n / 2 + GRID_HELD;
    for column in 0..n {
        for row in 0..n {
            let pose = Pose::at_xyz(column as f64, -(row as f64), 0.0);
            let def = if row == 0 && held.contains(&column) { BodyDef::fixed(pose) } else { BodyDef::dynamic(pose) };
            let body = scene.body(filtered(def.with_shape(solid.clone()), INTANGIBLE));
            let half = 0.5 * GRID_PITCH;
            if row > 0 {
                scene.joint(Some(body - 1), Some(body), spherical(Vec3::NEG_Y * half, Vec3::Y * half));
            }
            let between_held = row == 0 && held.contains(&column) && *held.start() < column;
            if column > 0 && !between_held {
                scene.joint(Some(body - n), Some(body), spherical(Vec3::X * half, Vec3::NEG_X * half));
            }
        }
    }
    scene.judge(JointGap::over_last(scene.steps.min(120)));
    scene.judge(EndSpeeds::default());
    Ok(scene)
}

/// Half the edge of the pyramids' boxes (m), and how far apart neighbours in a row are.
const HALF_BOX: f32 = 0.5;
const BOX_GAP: f64 = 0.02;

/// A flat pyramid of unit boxes, `base` in its lowest row, created touching, that stands at `place` in the plane z = `place.z`.
fn add_pyramid(scene: &mut Scene, base: usize, place: DVec3) -> Result<(), SceneError> {
    let solid = cuboid(HALF_BOX, HALF_BOX, HALF_BOX)?;
    let edge = 2.0 * f64::from(HALF_BOX);
    for row in 0..base {
        let count = base - row;
        for index in 0..count {
            let x = (index as f64 - 0.5 * (count as f64 - 1.0)) * (edge + BOX_GAP);
            let at = place + DVec3::new(x, (row as f64 + 0.5) * edge, 0.0);
            scene.body(BodyDef::dynamic(Pose::at(at)).with_shape(solid.clone()));
        }
    }
    Ok(())
}

fn judge_pyramids(scene: &mut Scene) {
    let end = scene.steps;
    scene.judge(Moved::after(end, None));
    scene.judge(Stood::within(f64::from(HALF_BOX)));
    scene.judge(Overlap::at_end());
}

/// One pyramid; base = 100 makes 5,050 boxes.
pub(crate) fn large_pyramid(params: &mut Params) -> Result<Scene, SceneError> {
    let base = params.count("base", 100, 2..=200)?;
    let mut scene = start(params, 4.0)?;
    scene.body(floor(2.0 * base as f32, 0.0, 0.5)?);
    add_pyramid(&mut scene, base, DVec3::ZERO)?;
    judge_pyramids(&mut scene);
    Ok(scene)
}

/// Boxes in the lowest row of each of many pyramids, and how far apart they stand (m).
const SMALL_BASE: usize = 10;
const SMALL_PITCH: f64 = 12.0;

/// n × n pyramids of 55 boxes each, side by side; n = 14 makes 10,780 boxes in 196 islands.
pub(crate) fn many_pyramids(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 14, 1..=60)?;
    let mut scene = start(params, 4.0)?;
    let reach = 0.5 * SMALL_PITCH * n as f64;
    scene.body(floor((reach + SMALL_PITCH) as f32, 0.0, 0.5)?);
    for index in 0..n * n {
        let along = |place: usize| SMALL_PITCH * (place as f64 - 0.5 * (n as f64 - 1.0));
        add_pyramid(&mut scene, SMALL_BASE, DVec3::new(along(index % n), 0.0, along(index / n)))?;
    }
    judge_pyramids(&mut scene);
    Ok(scene)
}

/// Distance between the ragdolls of a layer, and between layers (m).
const RAIN_PITCH: f64 = 2.2;
const RAIN_LAYER: f64 = 2.5;
/// Ragdolls of a layer, along each side.
const RAIN_SIDE: usize = 5;

/// n ragdolls, turned at random, that fall layer by layer onto open ground.
pub(crate) fn ragdoll_rain(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 100, 1..=2000)?;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, 6.0)?;
    let reach = 100.0;
    scene.body(floor(reach, 0.0, 0.5)?);
    let layer = RAIN_SIDE * RAIN_SIDE;
    for index in 0..n {
        let along = |place: usize| RAIN_PITCH * (place as f64 - 0.5 * (RAIN_SIDE as f64 - 1.0));
        let height = 2.0 + RAIN_LAYER * (index / layer) as f64;
        let middle = DVec3::new(along(index % RAIN_SIDE), height, along(index % layer / RAIN_SIDE));
        add_ragdoll(&mut scene, &Pose::at(middle).rotated(random.rotation()))?;
    }
    let last = scene.steps.min(120);
    scene.judge(JointGap::over_last(last));
    scene.judge(Overlap::spread(last, 20));
    let reach = f64::from(reach);
    let height = 10.0 + RAIN_LAYER * n.div_ceil(layer) as f64;
    scene.judge(Escaped::from(DVec3::new(-reach, -0.5, -reach), DVec3::new(reach, height, reach)));
    scene.judge(EndSpeeds::default());
    Ok(scene)
}
