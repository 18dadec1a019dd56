//! A net of ropes that hangs by its corners, and boxes dropped into it.
//!
//! `cells` × `cells` meshes of 0.3 m: each side of a mesh is a capsule of 0.2 kg and radius 0.02 m, tied to the others by ball joints at the
//! knots. The net is made hanging, 0.25 of its width deep, from four fixed corners; `boxes` of `mass` kg and 0.4 m, too wide for a mesh, fall
//! into it from half a metre in layers of four.
//!
//! Nothing gains energy, nothing opens and nothing falls through: `energy_growth_pct`, `joint_gap_m`, `fallen`.

use longspan::glam::DVec3;
use longspan::{BodyDef, CollisionFilter, Pose};

use crate::assemble::{filtered, rod, solid};
use crate::metrics::{EnergyGrowth, JointGap, Reading};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, start_at_rate, with_friction};

/// Ropes touch boxes, not each other.
const ROPE: CollisionFilter = CollisionFilter { member_of: 2, collides_with: 1 };

const MESH: f64 = 0.3;
const BOX_HALF: f64 = 0.2;
const DEPTH: f64 = 0.25;

pub(crate) fn net(params: &mut Params) -> Result<Scene, SceneError> {
    let cells = params.count("cells", 6, 2..=40)?;
    let boxes = params.count("boxes", 8, 0..=1000)?;
    let mass = params.number("mass", 30.0, 1.0e-3..=1.0e6)?;
    let (mut scene, rate) = start_at_rate(params, 6.0)?;
    let width = MESH * cells as f64;
    let depth = DEPTH * width;
    let knot = |row: usize, column: usize| {
        let [u, v] = [row, column].map(|index| 2.0 * index as f64 / cells as f64 - 1.0);
        // Corners are drawn in, so that there is rope enough to hang.
        DVec3::new(0.45 * width * u, -depth * (1.0 - u * u * v * v), 0.45 * width * v)
    };
    let base = scene.body(BodyDef::fixed(Pose::IDENTITY));
    // The first link at each knot holds the others.
    let mut held: Vec<Option<usize>> = vec![None; (cells + 1) * (cells + 1)];
    for row in [0, cells] {
        for column in [0, cells] {
            held[row * (cells + 1) + column] = Some(base);
        }
    }
    let link =
        |scene: &mut Scene, held: &mut Vec<Option<usize>>, from: (usize, usize), to: (usize, usize)| -> Result<(), SceneError> {
            let points = [from, to].map(|(row, column)| knot(row, column));
            let link = scene.body(filtered(rod(points[0], points[1], 0.02, 0.2)?, ROPE));
            for ((row, column), point) in [from, to].into_iter().zip(points) {
                let place = &mut held[row * (cells + 1) + column];
                match *place {
                    Some(other) => {
                        scene.tie(other, link, point);
                    }
                    None => *place = Some(link),
                }
            }
            Ok(())
        };
    for row in 0..=cells {
        for column in 0..=cells {
            if column < cells {
                link(&mut scene, &mut held, (row, column), (row, column + 1))?;
            }
            if row < cells {
                link(&mut scene, &mut held, (row, column), (row + 1, column))?;
            }
        }
    }
    let half = BOX_HALF as f32;
    let mut fallen = Vec::new();
    for index in 0..boxes {
        let (layer, place) = (index / 4, index % 4);
        let [x, z] = [place % 2, place / 2].map(|side| 0.25 * (2.0 * side as f64 - 1.0));
        let at = Pose::at_xyz(x, 0.5 + 0.5 * layer as f64, z);
        fallen.push(scene.body(solid(at, with_friction(cuboid(half, half, half)?, 0.5), mass as f32)));
    }
    let steps = scene.steps;
    let floor = -width;
    scene.judge(JointGap::over_last(steps));
    scene.judge(Reading::after(steps, "fallen", move |view| {
        let heights = fallen.iter().map(|&body| view.engine.pose(body).position.y);
        heights.filter(|&height| height <= floor || height.is_nan()).count() as f64
    }));
    scene.judge(EnergyGrowth::default());
    scene.judge(Reading::worst_of_last(rate as u32, "speed_m_s", |view| {
        let speeds = view.dynamic().map(|body| f64::from(view.engine.linear_velocity(body).length()));
        speeds.fold(0.0, f64::max)
    }));
    Ok(scene)
}
