//! Masonry without mortar: an arch of wedges, a house of cards, a wedge between two blocks. All stand by friction and thrust alone.

use std::f32::consts::PI;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, Geometry, Pose, ShapeDef};

use crate::assemble::{INTANGIBLE, filtered, rod, solid};
use crate::metrics::{JointGap, Moved, Reading, Stood, Verdicts};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, ball, cuboid, floor, shape, start, start_at_rate, with_friction};

const ARCH_INNER: f32 = 2.0;
const ARCH_OUTER: f32 = 2.6;
const ARCH_HALF_DEPTH: f32 = 0.5;

pub(crate) fn arch(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 11, 3..=101)?;
    let friction = params.number("friction", 0.6, 0.0..=10.0)? as f32;
    let mut scene = start(params, 20.0)?;
    scene.body(floor(20.0, 0.0, friction)?);
    for index in 0..n {
        let from = PI * index as f32 / n as f32;
        let to = PI * (index + 1) as f32 / n as f32;
        scene.body(voussoir(from, to, friction)?);
    }
    judge_standing(&mut scene, 0.3);
    Ok(scene)
}

/// The wedge between two angles from the x axis; its frame lies at mid-thickness.
fn voussoir(from: f32, to: f32, friction: f32) -> Result<BodyDef, SceneError> {
    let radial = |angle: f32, radius: f32| radius * Vec3::new(libm::cosf(angle), libm::sinf(angle), 0.0);
    let middle = radial(0.5 * (from + to), 0.5 * (ARCH_INNER + ARCH_OUTER));
    let mut points = Vec::new();
    for angle in [from, to] {
        for radius in [ARCH_INNER, ARCH_OUTER] {
            for depth in [-ARCH_HALF_DEPTH, ARCH_HALF_DEPTH] {
                points.push(radial(angle, radius) - middle + Vec3::Z * depth);
            }
        }
    }
    let wedge = ShapeDef { density: 2000.0, ..with_friction(shape(Geometry::ConvexHull { points })?, friction) };
    Ok(BodyDef::dynamic(Pose::at(middle.as_dvec3())).with_shape(wedge))
}

const LAMP_LINKS: usize = 12;
const LAMP_PITCH: f64 = 0.12;
const LAMP_RADIUS: f64 = 0.25;

/// An arch as above, on pillars, with a lamp of `lamp` kg that swings at 1 m/s on a chain of twelve links of 0.3 kg at its keystone.
/// `sunk_m` is how far the keystone has come from where it was made.
pub(crate) fn lamp_arch(params: &mut Params) -> Result<Scene, SceneError> {
    let n = params.count("n", 13, 3..=101)?;
    let lamp = params.number("lamp", 30.0, 1.0e-3..=1.0e6)?;
    let friction = params.number("friction", 0.7, 0.0..=10.0)? as f32;
    let (mut scene, _) = start_at_rate(params, 4.0)?;
    scene.body(floor(20.0, 0.0, friction)?);
    let mut key = 0;
    for index in 0..n {
        let [from, to] = [index, index + 1].map(|edge| PI * edge as f32 / n as f32);
        let stone = scene.body(voussoir(from, to, friction)?);
        if index == n / 2 {
            key = stone;
        }
    }
    // Chain and lamp touch nothing; the chain hangs from under the keystone's middle.
    let start = scene.bodies[key].pose.position;
    let top = start - DVec3::Y * f64::from(0.5 * (ARCH_OUTER - ARCH_INNER) + 0.05);
    let mut last = key;
    for link in 0..LAMP_LINKS {
        let [from, to] = [link, link + 1].map(|end| top - DVec3::Y * (LAMP_PITCH * end as f64));
        let body = scene.body(filtered(rod(from, to, 0.02, 0.3)?, INTANGIBLE));
        scene.tie(last, body, from);
        last = body;
    }
    let end = top - DVec3::Y * (LAMP_PITCH * LAMP_LINKS as f64);
    let at = Pose::at(end - DVec3::Y * LAMP_RADIUS);
    let mut def = filtered(solid(at, ball(LAMP_RADIUS as f32)?, lamp as f32), INTANGIBLE);
    def.linear_velocity = Vec3::X;
    let body = scene.body(def);
    scene.tie(last, body, end);
    let steps = scene.steps;
    scene.judge(Reading::worst_of_last(steps, "sunk_m", move |view| (view.engine.pose(key).position - start).length()));
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

/// Half thickness, half height and half width of a leaning card (m), and how far it leans from the vertical (rad).
const CARD: Vec3 = Vec3::new(0.01, 0.5, 0.3);
const LEAN: f32 = 20.0 * PI / 180.0;
/// Space between the feet of neighbouring pairs (m).
const FOOT_GAP: f32 = 0.005;

/// Pairs of leaning cards, `levels` of them at the bottom and one less on each level, with lying cards between the levels.
///
/// The feet of a level stand just inside the top edges of the pair below, so each leaning card is a strut: the pair's thrust is
/// taken by friction at the foot and by the lying card above, and it stands if friction exceeds tan 20° = 0.36.
pub(crate) fn card_house(params: &mut Params) -> Result<Scene, SceneError> {
    let levels = params.count("levels", 3, 1..=20)?;
    let friction = params.number("friction", 0.6, 0.0..=10.0)? as f32;
    let mut scene = start(params, 20.0)?;
    scene.body(floor(20.0, 0.0, friction)?);

    let (sin, cos) = libm::sincosf(LEAN);
    let half_width = CARD.x * cos + CARD.y * sin;
    let half_height = CARD.x * sin + CARD.y * cos;
    let pitch = 4.0 * half_width + FOOT_GAP;
    let overhang = 3.0 * CARD.x * cos;
    let card = with_friction(cuboid(CARD.x, CARD.y, CARD.z)?, friction);
    let mut bottom = 0.0;
    for level in 0..levels {
        let pairs = levels - level;
        let apex = |pair: usize| pitch * (pair as f32 - 0.5 * (pairs as f32 - 1.0));
        for pair in 0..pairs {
            for side in [-1.0, 1.0] {
                let center = Vec3::new(apex(pair) + side * half_width, bottom + half_height, 0.0);
                let pose = Pose::at(center.as_dvec3()).rotated(Quat::from_rotation_z(side * LEAN));
                scene.body(BodyDef::dynamic(pose).with_shape(card.clone()));
            }
        }
        bottom += 2.0 * half_height;
        for gap in 1..pairs {
            // Lying cards meet over inner pairs; the outermost reach past the outer ones.
            let left = apex(gap - 1) + if gap == 1 { -overhang } else { 0.5 * FOOT_GAP };
            let right = apex(gap) + if gap == pairs - 1 { overhang } else { -0.5 * FOOT_GAP };
            let lying = with_friction(cuboid(0.5 * (right - left), CARD.x, CARD.z)?, friction);
            let center = Vec3::new(0.5 * (left + right), bottom + CARD.x, 0.0);
            scene.body(BodyDef::dynamic(Pose::at(center.as_dvec3())).with_shape(lying));
        }
        bottom += 2.0 * CARD.x;
    }
    judge_standing(&mut scene, 0.2);
    Ok(scene)
}

fn judge_standing(scene: &mut Scene, reach: f64) {
    let end = scene.steps;
    scene.judge(Moved::after(end, None));
    scene.judge(Stood::within(reach));
    scene.judge(Verdicts::within(reach));
}

/// A wedge hung between the leaning faces of two blocks, which stand fast or, if `free` is on, by friction with the floor.
///
/// Its thrust on each block is half its weight times cot(α + φ), with α what the faces lean from the vertical and φ = atan μ.
pub(crate) fn wedge(params: &mut Params) -> Result<Scene, SceneError> {
    let lean = params.number("angle_deg", 10.0, 1.0..=45.0)?.to_radians() as f32;
    let friction = params.number("friction", 0.6, 0.0..=10.0)? as f32;
    let free = params.switch("free", false)?;
    let mut scene = start(params, 20.0)?;
    scene.body(floor(20.0, 0.0, friction)?);
    let prism = |corners: [(f32, f32); 4]| -> Result<ShapeDef, SceneError> {
        let points = corners.into_iter().flat_map(|(x, y)| [Vec3::new(x, y, -0.3), Vec3::new(x, y, 0.3)]).collect();
        Ok(ShapeDef { density: 2000.0, ..with_friction(shape(Geometry::ConvexHull { points })?, friction) })
    };
    let face = |y: f32| 0.35 + (y - 0.3) * libm::tanf(lean);
    for side in [-1.0, 1.0] {
        let flank = prism([(side * face(0.0), 0.0), (side * face(1.0), 1.0), (side * 1.8, 1.0), (side * 1.8, 0.0)])?;
        let block = if free { BodyDef::dynamic(Pose::default()) } else { BodyDef::fixed(Pose::default()) };
        scene.body(block.with_shape(flank));
    }
    let wedge = prism([(-face(0.3), 0.3), (face(0.3), 0.3), (face(0.9), 0.9), (-face(0.9), 0.9)])?;
    scene.body(BodyDef::dynamic(Pose::default()).with_shape(wedge));
    judge_standing(&mut scene, 0.1);
    Ok(scene)
}
