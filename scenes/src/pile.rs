//! Boxes and balls dropped into a pit.

use longspan::glam::{DVec3, Quat};
use longspan::{BodyDef, Pose};

use crate::metrics::{EndSpeeds, Escaped, Overlap};
use crate::params::{Params, SceneError};
use crate::random::Random;
use crate::scene::{Scene, ball, cuboid, start};

/// Distance between bodies at the start (m).
const PITCH: f64 = 0.66;
/// Bodies start this much off their grid point at most (m) and turned by at most `TURN` (rad), so that none overlap.
const JITTER: f32 = 0.03;
const TURN: f32 = 0.2;
const WALL: f64 = 0.5;

pub(crate) fn pile(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 1000, 1..=200_000)?;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, 8.0)?;
    scene.window = scene.steps.saturating_sub(120)..scene.steps;

    let half_width = 3.2 * libm::cbrt(n as f64 / 1000.0);
    let row = ((2.0 * half_width / PITCH) as usize).max(1);
    let layers = n.div_ceil(row * row);
    let height = PITCH * layers as f64 + 4.0;
    add_pit(&mut scene, half_width, height)?;

    let (box_shape, ball_shape) = (cuboid(0.25, 0.2, 0.22)?, ball(0.25)?);
    for index in 0..n {
        let (layer, in_layer) = (index / (row * row), index % (row * row));
        let centred = |place: usize| (place as f64 - 0.5 * (row as f64 - 1.0)) * PITCH;
        let grid = DVec3::new(centred(in_layer % row), 1.0 + PITCH * layer as f64, centred(in_layer / row));
        let pose = Pose::at(grid + random.vector(JITTER).as_dvec3());
        let turn = Quat::from_rotation_y(random.between(-TURN, TURN));
        let shape = if random.unit() < 0.5 { &box_shape } else { &ball_shape };
        scene.body(BodyDef::dynamic(pose.rotated(turn)).with_shape(shape.clone()));
    }

    let reach = half_width + WALL;
    let last = scene.steps.min(120);
    scene.judge(Overlap::spread(last, 20));
    scene.judge(Escaped::from(DVec3::new(-reach, -WALL, -reach), DVec3::new(reach, 2.0 * height, reach)));
    scene.judge(EndSpeeds::default());
    Ok(scene)
}

/// A floor at height 0 and four walls around it, all static boxes.
pub(crate) fn add_pit(scene: &mut Scene, half_width: f64, height: f64) -> Result<(), SceneError> {
    let outer = (half_width + 2.0 * WALL) as f32;
    let (wall, tall) = (WALL as f32, (0.5 * height) as f32);
    scene.body(BodyDef::fixed(Pose::at_xyz(0.0, -WALL, 0.0)).with_shape(cuboid(outer, wall, outer)?));
    for sign in [-1.0, 1.0] {
        let away = sign * (half_width + WALL);
        let x_wall = BodyDef::fixed(Pose::at_xyz(away, 0.5 * height, 0.0)).with_shape(cuboid(wall, tall, outer)?);
        let z_wall = BodyDef::fixed(Pose::at_xyz(0.0, 0.5 * height, away)).with_shape(cuboid(outer, tall, wall)?);
        for def in [x_wall, z_wall] {
            let body = scene.body(def);
            scene.unseen.push(body);
        }
    }
    Ok(())
}
