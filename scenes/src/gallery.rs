//! The stacks of the paper's figures 11 and 12, each body with the verdict that it should get.

use longspan::glam::Vec3;
use longspan::{BodyDef, Pose};

use crate::metrics::{Errors, Metric, View};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, floor, start, with_friction};

/// Distance between stacks (m).
const PITCH: f64 = 8.0;

/// Step after which the verdicts are read: contacts bear load, and what is not supported has hardly begun to move.
const JUDGED_AFTER: u32 = 2;

/// A stone of a stack: place of its centre (m), half extents across and up (m), speed sideways (m/s), and whether it is supported.
type Stone = ((f64, f64), (f32, f32), f32, bool);

const STACKS: &[&[Stone]] = &[
    // Figure 11, top: over the hull below.
    &[((0.0, 0.5), (0.5, 0.5), 0.0, true), ((0.3, 1.5), (0.5, 0.5), 0.0, true)],
    // Middle: the upper contact lies outside of what carries the plank. (It is light enough not to tip it.)
    &[((0.0, 0.5), (0.3, 0.5), 0.0, true), ((0.0, 1.1), (1.2, 0.1), 0.0, true), ((1.1, 1.25), (0.05, 0.05), 0.0, false)],
    // Bottom: what lies below slides.
    &[((0.0, 0.25), (1.0, 0.25), 3.0, false), ((0.0, 0.75), (0.5, 0.25), 3.0, false)],
    // Figure 12, left: three boxes beyond the edge of one another; each stands on the last, the third over nothing.
    &[((0.0, 0.5), (0.5, 0.5), 0.0, true), ((0.4, 1.5), (0.5, 0.5), 0.0, true), ((1.05, 2.5), (0.5, 0.5), 0.0, false)],
    // A wall with a beam over a gap, and a box in the middle of the beam.
    &[
        ((-1.0, 0.5), (0.3, 0.5), 0.0, true),
        ((1.0, 0.5), (0.3, 0.5), 0.0, true),
        ((0.0, 1.1), (1.4, 0.1), 0.0, true),
        ((0.0, 1.5), (0.3, 0.3), 0.0, true),
    ],
    // A plank on a post, and a plank as wide on it.
    &[((0.0, 0.5), (0.3, 0.5), 0.0, true), ((0.0, 1.1), (1.2, 0.1), 0.0, true), ((0.0, 1.3), (1.2, 0.1), 0.0, true)],
    // A pyramid, and a box that has just been let go.
    &[
        ((-1.05, 0.25), (0.5, 0.25), 0.0, true),
        ((0.0, 0.25), (0.5, 0.25), 0.0, true),
        ((1.05, 0.25), (0.5, 0.25), 0.0, true),
        ((-0.5, 0.75), (0.5, 0.25), 0.0, true),
        ((0.5, 0.75), (0.49, 0.25), 0.0, true),
        ((0.0, 1.25), (0.45, 0.25), 0.0, true),
        ((0.0, 3.0), (0.3, 0.3), 0.0, false),
    ],
];

pub(crate) fn support_gallery(params: &mut Params) -> Result<Scene, SceneError> {
    let mut scene = start(params, f64::from(JUDGED_AFTER) / 60.0)?;
    scene.world.support = true;
    scene.body(floor(60.0, 0.0, 0.5)?);
    let mut expected = vec![(0, true)];
    for (number, stack) in STACKS.iter().enumerate() {
        let origin = (number as f64 - 0.5 * (STACKS.len() - 1) as f64) * PITCH;
        for &((x, y), (across, up), speed, is_supported) in *stack {
            let shape = with_friction(cuboid(across, up, 0.5)?, 0.5);
            let mut stone = BodyDef::dynamic(Pose::at_xyz(origin + x, y, 0.0)).with_shape(shape);
            stone.linear_velocity = Vec3::X * speed;
            expected.push((scene.body(stone), is_supported));
        }
    }
    scene.judge(WrongVerdicts { expected, wrong: None });
    Ok(scene)
}

/// `wrong_verdicts`: of how many bodies an engine that judges support says the wrong thing at the end.
struct WrongVerdicts {
    expected: Vec<(usize, bool)>,
    wrong: Option<usize>,
}

impl Metric for WrongVerdicts {
    fn observe(&mut self, view: &View) {
        if view.at_end() {
            let says = |&(body, expected): &(usize, bool)| Some(view.engine.is_supported(body)? != expected);
            let wrong: Option<Vec<bool>> = self.expected.iter().map(says).collect();
            self.wrong = wrong.map(|wrong| wrong.into_iter().filter(|&is| is).count());
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("wrong_verdicts", self.wrong.map_or(f64::INFINITY, |wrong| wrong as f64)));
    }
}
