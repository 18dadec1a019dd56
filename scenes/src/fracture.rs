//! Things that break: a wall of Voronoi bricks hit by a ball, a cantilever under growing load.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyKind, BondMaterial, Cells, Geometry, JointKind, Pose, Strength};

use crate::metrics::{Breakage, FirstBreak, NotFinite};
use crate::params::{Params, SceneError};
use crate::random::Random;
use crate::scene::{Action, GRAVITY, Scene, ball, cuboid, floor, start, with_friction};

/// Half the width, the height and half the thickness of the wall (m).
const WALL: (f32, f32, f32) = (2.0, 2.0, 0.15);
const STONE_DENSITY: f32 = 2000.0;
const BALL_RADIUS: f32 = 0.3;

/// A wall 4 m wide, 2 m high and 0.3 m thick, of `bricks` Voronoi cells of stone (2000 kg/m³, friction 0.6) whose bonds bear `stress` Pa
/// in tension and shear and ten times as much in compression, built on a foundation; after 0.5 s a ball of 0.3 m radius and `mass` kg
/// meets its middle at `speed` m/s. 3 s.
///
/// The seeds are mirrored in the ground, so that the lowest cells end in it and are bonded to static ones below by faces as true as
/// any other.
pub(crate) fn brick_wall(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("bricks", 150, 2..=5000)?;
    let stress = params.number("stress", 1.0e5, 0.0..=1.0e12)?;
    let mass = params.number("mass", 200.0, 1.0e-3..=1.0e9)?;
    let speed = params.number("speed", 15.0, 0.0..=1000.0)?;
    let seed = params.seed()?;
    let mut scene = start(params, 3.0)?;
    scene.body(floor(20.0, 0.0, 0.6)?);

    let (half_width, height, half_depth) = WALL;
    let mut random = Random::new(seed);
    let mut point = || {
        let between = |random: &mut Random, half: f32| random.between(-half, half);
        Vec3::new(between(&mut random, half_width), random.between(0.0, height), between(&mut random, half_depth))
    };
    let above: Vec<Vec3> = (0..count).map(|_| point()).collect();
    let mirrored = above.iter().map(|seed| Vec3::new(seed.x, -seed.y, seed.z));
    let seeds: Vec<Vec3> = above.iter().copied().chain(mirrored).collect();
    let wall = Geometry::Box { half_extents: Vec3::new(half_width, height, half_depth) };
    let cells = Cells::cut(&wall, &seeds)?;

    let stone = longspan::ShapeDef { density: STONE_DENSITY, ..with_friction(cuboid(1.0, 1.0, 1.0)?, 0.6) };
    let is_above = |cell: usize| cells.cells[cell].seed < count;
    let is_bonded = |[a, b]: [usize; 2]| is_above(a) || is_above(b);
    let mut bodies: Vec<Option<usize>> = vec![None; cells.cells.len()];
    for (cell, def) in cells.bodies(&BodyDef::dynamic(Pose::IDENTITY), &stone)?.into_iter().enumerate() {
        let is_footing = cells.bonds.iter().any(|bond| bond.cells.contains(&cell) && is_bonded(bond.cells));
        if is_above(cell) {
            bodies[cell] = Some(scene.body(def));
        } else if is_footing {
            bodies[cell] = Some(scene.body(BodyDef { kind: BodyKind::Static, ..def }));
        }
    }
    let material = BondMaterial::brittle(stress as f32);
    for ([a, b], def) in cells.joints(&material).filter(|(cells, _)| is_bonded(*cells)) {
        scene.joint(bodies[a], bodies[b], def);
    }

    let shape = ball(BALL_RADIUS)?;
    let hit = BodyDef {
        linear_velocity: Vec3::Z * speed as f32,
        gravity_scale: 0.0,
        ..BodyDef::dynamic(Pose::at_xyz(0.0, 0.5 * f64::from(height), -3.0))
    };
    scene.at(30, Action::Add(hit.with_shape(shape).with_mass(longspan::Mass::Total(mass as f32))));
    scene.judge(Breakage::default());
    scene.judge(NotFinite::default());
    Ok(scene)
}

const CUBE_HALF: f32 = 0.1;
const BEAM_DENSITY: f32 = 1000.0;

/// `n` cubes of 0.2 m and 8 kg in a row from a wall, each joint fixed and bearing `bending` N·m; gravity grows from nothing by
/// standard gravity every 10 s, in `seconds`.
///
/// The first joint bears n·m g · n·(edge)/2 and breaks first, at g = 2 M/(n² m·edge).
pub(crate) fn breaking_beam(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("n", 10, 1..=200)?;
    let bending = params.number("bending", 400.0, 1.0e-3..=1.0e9)?;
    let mut scene = start(params, 10.0)?;
    let edge = 2.0 * f64::from(CUBE_HALF);
    let mut held = scene.body(BodyDef::fixed(Pose::at_xyz(-f64::from(CUBE_HALF), 0.0, 0.0)).with_shape(cuboid(
        CUBE_HALF,
        3.0 * CUBE_HALF,
        3.0 * CUBE_HALF,
    )?));
    for index in 0..count {
        let pose = Pose::at_xyz(edge * (index as f64 + 0.5), 0.0, 0.0);
        let cube = scene.body(BodyDef::dynamic(pose).with_shape(cuboid(CUBE_HALF, CUBE_HALF, CUBE_HALF)?));
        let joint = scene.join(held, cube, JointKind::Fixed, &Pose::at(DVec3::X * (edge * index as f64)));
        scene.joints[joint].def.strength = Strength { bending: bending as f32, ..Strength::UNBREAKABLE };
        held = cube;
    }
    let steps = scene.steps;
    let per_step = GRAVITY / steps as f32;
    scene.world.gravity = Vec3::ZERO;
    for step in 0..steps {
        scene.at(step, Action::SetGravity(Vec3::NEG_Y * (per_step * (step + 1) as f32)));
    }
    let mass = f64::from(BEAM_DENSITY) * edge.powi(3);
    scene.judge(FirstBreak::at_gravity(2.0 * bending / ((count * count) as f64 * mass * edge)));
    scene.judge(Breakage::default());
    Ok(scene)
}
