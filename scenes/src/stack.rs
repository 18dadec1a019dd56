//! Things that stand on one another: the heavy on the light, a column, a ring-shaped tower.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, Mass, Pose, ShapeDef};

use crate::metrics::{Awake, Displaced, Moved, Overlap, PoseSpeed, Settling, Stood};
use crate::params::{Params, SceneError};
use crate::random::Random;
use crate::scene::{Action, Scene, ball, cuboid, floor, start, with_friction};
use crate::toppling::{Foundation, Toppling};

/// What has come to rest is watched over its last second.
const LAST_SECOND: u32 = 60;

pub(crate) fn heavy_on_light(params: &mut Params) -> Result<Scene, SceneError> {
    let ratio = params.number("ratio", 1.0e4, 1.0e-3..=1.0e9)?;
    let gap = params.number("gap_mm", 0.0, 0.0..=1000.0)? * 1e-3;
    let offset = params.number("offset", 0.0, -1.0..=1.0)?;
    let mut scene = start(params, 5.0)?;
    scene.body(floor(20.0, 0.0, 0.5)?);
    let unit = cuboid(0.5, 0.5, 0.5)?;
    for level in 0..10 {
        let is_top = level == 9;
        let x = if is_top { offset } else { 0.0 };
        let pose = Pose::at_xyz(x, 0.5 + gap + (1.0 + gap) * f64::from(level), 0.0);
        let mass = if is_top { 100.0 * ratio as f32 } else { 100.0 };
        scene.body(BodyDef::dynamic(pose).with_shape(unit.clone()).with_mass(Mass::Total(mass)));
    }
    scene.judge(Overlap::at_end());
    scene.judge(Stood::within(0.2 + 10.0 * gap));
    scene.judge(PoseSpeed::over_last(LAST_SECOND));
    if offset.abs() > 0.5 {
        // The stack under the heavy box stays up if the common centre of mass stays over every interface below.
        let topples_alone = ratio * offset.abs() / (ratio + 1.0) < 0.5;
        let foundation = match () {
            () if gap > 0.0 => None,
            () if topples_alone => Some(Foundation::Fixed),
            // Nine boxes weigh no more than a hundredth of what leans them back.
            () => (ratio >= 1.0e3).then_some(Foundation::Strut { height: 9.0 }),
        };
        scene.judge(Toppling::new(10, offset.abs() - 0.5, foundation));
    }
    Ok(scene)
}

pub(crate) fn column(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 20, 1..=1000)?;
    let gap = params.number("gap_mm", 0.0, 0.0..=1000.0)? * 1e-3;
    let scatter = params.number("scatter_mm", 0.0, 0.0..=400.0)? as f32 * 1e-3;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, 60.0)?;
    scene.body(floor(20.0, 0.0, 0.5)?);
    let unit = cuboid(0.5, 0.5, 0.5)?;
    for level in 0..n {
        let aside = scatter * Vec3::new(random.between(-1.0, 1.0), 0.0, random.between(-1.0, 1.0));
        let pose = Pose::at(aside.as_dvec3() + DVec3::Y * (0.5 + gap + (1.0 + gap) * level as f64));
        scene.body(BodyDef::dynamic(pose).with_shape(unit.clone()));
    }
    let end = scene.steps;
    scene.judge(Moved::after(end, Some(vec![n])));
    scene.judge(Overlap::spread(1, 1));
    scene.judge(Stood::within(0.3 + gap * n as f64));
    scene.judge(PoseSpeed::over_last(LAST_SECOND));
    scene.judge(Awake::default());
    Ok(scene)
}

const RING: usize = 40;
const RING_RADIUS: f32 = 3.0;
const BLOCK: Vec3 = Vec3::new(0.15, 0.125, 0.22);
const STONE_FRICTION: f32 = 0.6;
/// The tower stands for so long before anything happens to it (s).
const STANDING: f64 = 10.0;
const COLLAPSE: f64 = 4.0;
/// By when a tower that was built loosely should have settled (steps).
const SETTLED: u32 = 120;

pub(crate) fn tower(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("bodies", 1000, RING..=100_000)?;
    let scatter = params.number("scatter_mm", 0.0, 0.0..=20.0)? as f32 * 1e-3;
    let twist = (params.number("scatter_deg", 0.0, 0.0..=5.0)? as f32).to_radians();
    let loose = params.switch("loose", false)?;
    let removed = params.count("remove", 0, 0..=RING)?;
    let choice = params.count("choice", 0, 0..=100_000)?;
    let push = params.number("push", 0.0, -1.0e6..=1.0e6)? as f32;
    let throws_ball = params.switch("ball", true)?;
    let standing = (params.number("stand", STANDING, 0.0..=1.0e4)? * 60.0).round() as u32;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, f64::from(standing) / 60.0 + COLLAPSE)?;
    scene.window = standing.min(scene.steps) / 2..standing.min(scene.steps);
    scene.second_window = Some(("collapse_median", standing..scene.steps));

    scene.body(floor(50.0, 0.0, STONE_FRICTION)?);
    let stone = ShapeDef { density: 2000.0, ..with_friction(cuboid(BLOCK.x, BLOCK.y, BLOCK.z)?, STONE_FRICTION) };
    let mut blocks = Vec::new();
    for index in 0..count {
        let (course, place) = (index / RING, index % RING);
        let angle = std::f32::consts::TAU * (place as f32 + 0.5 * (course % 2) as f32) / RING as f32;
        let turn = Quat::from_rotation_y(-angle);
        let aside = Vec3::new(random.between(-scatter, scatter), 0.0, random.between(-scatter, scatter));
        let center = turn * Vec3::X * RING_RADIUS + aside;
        let mut height = f64::from(BLOCK.y) * (1.0 + 2.0 * course as f64);
        let mut twisted = Quat::from_rotation_y(random.between(-twist, twist));
        if loose {
            // Up and down and about all axes too, the courses apart by as much as that can take.
            let room = 2.0 * (scatter + twist * (BLOCK.x + BLOCK.z));
            height += f64::from(room * (course + 1) as f32 + random.between(-scatter, scatter));
            twisted *=
                Quat::from_rotation_x(random.between(-twist, twist)) * Quat::from_rotation_z(random.between(-twist, twist));
        }
        let pose = Pose::at(center.as_dvec3() + DVec3::Y * height);
        let turned = pose.rotated(turn * twisted);
        blocks.push(scene.body(BodyDef::dynamic(turned).with_shape(stone.clone())));
    }

    let mut choices = Random::new(choice as u64);
    let mut bottom: Vec<usize> = blocks[..RING.min(count)].to_vec();
    for index in 0..removed {
        // Evenly round the ring, or a random choice.
        let block = if choice == 0 { blocks[index * RING / removed] } else { bottom.swap_remove(choices.index(bottom.len())) };
        scene.at(standing, Action::Remove(block));
    }
    if push != 0.0 {
        // A block in the middle of the height, pushed towards the axis.
        let block = blocks[(count / RING / 2) * RING];
        scene.at(standing, Action::Push(block, Vec3::NEG_X * push));
    }
    if throws_ball {
        let shape = with_friction(ball(0.6)?, STONE_FRICTION);
        let mut thrown = BodyDef::dynamic(Pose::at_xyz(-8.0, 2.5, 0.0)).with_shape(shape).with_mass(Mass::Total(5000.0));
        thrown.linear_velocity = Vec3::new(20.0, 0.0, 0.0);
        scene.at(standing, Action::Add(thrown));
    }
    let standing = standing.min(scene.steps);
    if loose {
        scene.judge(Settling::between(SETTLED.min(standing), standing));
    }
    scene.judge(Moved::after(standing, None));
    scene.judge(Displaced::since(standing, blocks));
    scene.judge(Overlap::spread(scene.steps + 1 - standing, 60));
    Ok(scene)
}
