//! A footbridge built straight between fixed piers: planks hinged edge to edge, and a load, or a stack of loads, set down on the middle.
//!
//! n planks of 20 kg (half-extents 0.25 × 0.08 × 1.2 m) span 0.5·n m with no slack at all: a rigid bridge could not give way, and what
//! it carries it would carry with an endless tension. A solver's opens its joints by as little as its rows are soft, and the
//! bridge sags by √(span × what its joints have opened by / 2), with the tension weight × span / (4 × sag).

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, JointKind, Pose};

use crate::assemble::solid;
use crate::metrics::{JointGap, Overlap, Reading};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, start, with_friction};

const PLANK_HALF: Vec3 = Vec3::new(0.25, 0.08, 1.2);
const PIER_HALF: Vec3 = Vec3::new(1.0, 0.5, 1.5);
const LOAD_HALF: f32 = 0.4;
/// Errors count over the last two seconds.
const LAST: u32 = 120;

pub(crate) fn footbridge(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("planks", 24, 2..=2000)?;
    let mass = params.number("plank", 20.0, 0.01..=1.0e6)? as f32;
    let load = params.number("load", 800.0, 0.01..=1.0e7)? as f32;
    let drop = params.number("drop", 0.01, 0.0..=10.0)?;
    let boxes = params.count("boxes", 1, 1..=20)?;
    let mut scene = start(params, 8.0)?;
    let half_span = f64::from(PLANK_HALF.x) * count as f64;

    let pier = cuboid(PIER_HALF.x, PIER_HALF.y, PIER_HALF.z)?;
    let ends = [-1.0, 1.0].map(|side| {
        let at = Pose::at_xyz(side * (half_span + f64::from(PIER_HALF.x)), 0.0, 0.0);
        scene.body(BodyDef::fixed(at).with_shape(pier.clone()))
    });
    let wood = with_friction(cuboid(PLANK_HALF.x, PLANK_HALF.y, PLANK_HALF.z)?, 0.6);
    let mut last = ends[0];
    for index in 0..count {
        let edge = 2.0 * f64::from(PLANK_HALF.x) * index as f64 - half_span;
        let plank = scene.body(solid(Pose::at_xyz(edge + f64::from(PLANK_HALF.x), 0.0, 0.0), wood.clone(), mass));
        scene.hinge(last, plank, JointKind::HINGE, DVec3::X * edge, DVec3::Z);
        last = plank;
    }
    scene.hinge(last, ends[1], JointKind::HINGE, DVec3::X * half_span, DVec3::Z);

    let rests = f64::from(PLANK_HALF.y + LOAD_HALF);
    let crate_shape = with_friction(cuboid(LOAD_HALF, LOAD_HALF, LOAD_HALF)?, 0.6);
    let mut stack = Vec::new();
    for level in 0..boxes {
        let height = rests + 2.0 * f64::from(LOAD_HALF) * level as f64 + drop * (level + 1) as f64;
        stack.push(scene.body(solid(Pose::at_xyz(0.0, height, 0.0), crate_shape.clone(), load)));
    }
    let lowest = stack[0];
    scene.judge(JointGap::over_last(LAST));
    scene.judge(Overlap::spread(LAST, 1));
    scene.judge(Reading::mean_of_last(LAST, "sag_m", move |view| rests - view.center(lowest).y));
    Ok(scene)
}
