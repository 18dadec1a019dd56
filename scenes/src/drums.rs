//! Ropes on round things: a bollard, a capstan, a winch and a pulley.
//!
//! Links are capsules of 0.2 kg and radius 0.02 m, tied end to end by ball joints; loads are boxes of half-extent 0.25 m that hang from
//! them. A rope of links is a polygon: joints on a drum lie beyond its radius so that the middles of links touch it.
//!
//! * *Bollard*: one end is tied, the other bears `load` over a fixed bollard of 0.3 m. It rests: `moved_m` is how far the load has come
//!   from where it was, of which the slack that the rope begins with is up to 2 mm.
//! * *Capstan*: both ends are free, over a fixed post of 0.3 m with friction 0.3; loads are as 1 : `ratio`. By Euler's e^(μ π) = 2.57 the
//!   rope holds up to there, its own weight counted in: `slid_m` is how far it has slid.
//! * *Winch*: a hinge turns a drum of 0.4 m at 1 rad/s, which winds up the rope and `load`: `wound_err_pct` compares its rise with what the
//!   middle of the rope would rise by on a round drum. Sides of a polygon are up to 2 % more.
//! * *Pulley*: a drum of 1 m and 500 kg on a hinge, `load` on one side and `other` on the other: `fallen_err_pct` compares with an Atwood
//!   machine, x″ = (Δm + 2 λ x) g / (m₁ + m₂ + m_rope + m_drum/2) with λ the rope's mass by length.

use std::f64::consts::PI;

use longspan::glam::{DVec3, Quat};
use longspan::{BodyDef, Geometry, JointKind, Pose, ShapeDef};

use crate::assemble::{rod, solid};
use crate::machines::servo;
use crate::metrics::{JointGap, Reading};
use crate::params::{Params, SceneError};
use crate::scene::{GRAVITY, Scene, cuboid, shape, start_at_rate, with_friction};

const LINK_MASS: f64 = 0.2;
const LINK_RADIUS: f64 = 0.02;
const LOAD_HALF: f64 = 0.25;
const POST_RADIUS: f64 = 0.3;

/// A rope through these points; its links and the joints between them.
fn lay(scene: &mut Scene, points: &[DVec3], friction: f32) -> Result<Vec<usize>, SceneError> {
    let mut links: Vec<usize> = Vec::new();
    for ends in points.windows(2) {
        let mut def = rod(ends[0], ends[1], LINK_RADIUS as f32, LINK_MASS as f32)?;
        def.shapes = def.shapes.into_iter().map(|shape| with_friction(shape, friction)).collect();
        let link = scene.body(def);
        if let Some(&last) = links.last() {
            scene.tie(last, link, ends[0]);
        }
        links.push(link);
    }
    Ok(links)
}

/// Half way round a drum of this radius at the origin, from `-x` over the top to `+x`, with straight ends of this length, in links of about
/// this one.
fn over(radius: f64, straight: f64, link: f64) -> Vec<DVec3> {
    let along = radius + LINK_RADIUS;
    let round = along / libm::cos(0.5 * link / along);
    let whole = 2.0 * straight + PI * round;
    let count = (whole / link).round() as usize;
    let point = |index: usize| {
        let way = whole * index as f64 / count as f64 - straight;
        let angle = PI - way / round;
        match way {
            way if way < 0.0 => DVec3::new(-round, way, 0.0),
            way if way < PI * round => DVec3::new(round * libm::cos(angle), round * libm::sin(angle), 0.0),
            way => DVec3::new(round, PI * round - way, 0.0),
        }
    };
    (0..=count).map(point).collect()
}

/// A box of this mass (kg) that hangs from a link at this point.
fn hang(scene: &mut Scene, link: usize, point: DVec3, mass: f64) -> Result<usize, SceneError> {
    let half = LOAD_HALF as f32;
    let load = scene.body(solid(Pose::at(point - DVec3::Y * LOAD_HALF), cuboid(half, half, half)?, mass as f32));
    scene.tie(link, load, point);
    Ok(load)
}

/// A cylinder whose axis is z at the origin.
fn drum(radius: f64, friction: f32) -> Result<(Pose, ShapeDef), SceneError> {
    let geometry = Geometry::Cylinder { half_height: 0.5, radius: radius as f32 };
    let turn = Quat::from_rotation_x(0.5 * std::f32::consts::PI);
    Ok((Pose::IDENTITY.rotated(turn), with_friction(shape(geometry)?, friction)))
}

/// Height of a body above where it was made (m).
fn risen(scene: &mut Scene, name: &'static str, body: usize, reading: impl Fn(f64) -> f64 + 'static) {
    let (steps, from) = (scene.steps, scene.bodies[body].pose.position.y);
    scene.judge(Reading::after(steps, name, move |view| reading(view.engine.pose(body).position.y - from)));
}

pub(crate) fn bollard(params: &mut Params) -> Result<Scene, SceneError> {
    let load = params.number("load", 1000.0, 1.0e-3..=1.0e7)?;
    let friction = params.number("friction", 0.5, 0.0..=10.0)? as f32;
    let (mut scene, _) = start_at_rate(params, 3.0)?;
    let (pose, shape) = drum(POST_RADIUS, friction)?;
    let post = scene.body(BodyDef::fixed(pose).with_shape(shape));
    let points = over(POST_RADIUS, 1.5, 0.15);
    let links = lay(&mut scene, &points, friction)?;
    scene.tie(post, links[0], points[0]);
    let (last, end) = (links[links.len() - 1], points[links.len()]);
    let load = hang(&mut scene, last, end, load)?;
    risen(&mut scene, "moved_m", load, f64::abs);
    let steps = scene.steps;
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

pub(crate) fn capstan(params: &mut Params) -> Result<Scene, SceneError> {
    let load = params.number("load", 100.0, 1.0e-3..=1.0e7)?;
    let ratio = params.number("ratio", 2.0, 1.0..=1.0e3)?;
    let friction = params.number("friction", 0.3, 0.0..=10.0)? as f32;
    let (mut scene, _) = start_at_rate(params, 3.0)?;
    let (pose, shape) = drum(POST_RADIUS, friction)?;
    scene.body(BodyDef::fixed(pose).with_shape(shape));
    let points = over(POST_RADIUS, 2.0, 0.1);
    let links = lay(&mut scene, &points, friction)?;
    hang(&mut scene, links[0], points[0], load)?;
    let (last, end) = (links[links.len() - 1], points[links.len()]);
    let heavy = hang(&mut scene, last, end, load * ratio)?;
    risen(&mut scene, "slid_m", heavy, f64::abs);
    let steps = scene.steps;
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

const WINCH_RADIUS: f64 = 0.4;
const WINCH_RATE: f64 = 1.0;
/// The winch is watched from here on (s): what is slack has been taken up.
const TAUT_AFTER: f64 = 0.5;

pub(crate) fn winch(params: &mut Params) -> Result<Scene, SceneError> {
    let load = params.number("load", 500.0, 1.0e-3..=1.0e7)?;
    let friction = params.number("friction", 0.3, 0.0..=10.0)? as f32;
    let (mut scene, rate) = start_at_rate(params, 2.5)?;
    let (pose, shape) = drum(WINCH_RADIUS, friction)?;
    let base = scene.body(BodyDef::fixed(Pose::IDENTITY));
    let drum = scene.body(solid(pose, shape, 300.0));
    scene.hinge(base, drum, servo(WINCH_RATE), DVec3::ZERO, DVec3::Z);
    let (along, link) = (WINCH_RADIUS + LINK_RADIUS, 0.15);
    let points: Vec<DVec3> = (0..=40).map(|index| DVec3::new(along, -link * f64::from(index), 0.0)).collect();
    let links = lay(&mut scene, &points, friction)?;
    scene.tie(drum, links[0], points[0]);
    let load = hang(&mut scene, links[links.len() - 1], points[links.len()], load)?;
    let (steps, taut) = (scene.steps, (TAUT_AFTER * rate).round() as u32);
    let expected = WINCH_RATE * along * f64::from(steps.saturating_sub(taut)) / rate;
    let from = std::cell::Cell::new(0.0);
    scene.judge(Reading::worst_of_last(steps, "wound_err_pct", move |view| {
        let height = view.engine.pose(load).position.y;
        if view.step == taut {
            from.set(height);
        }
        if view.at_end() { 100.0 * ((height - from.get()) / expected - 1.0).abs() } else { 0.0 }
    }));
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}

const PULLEY_RADIUS: f64 = 1.0;
const PULLEY_MASS: f64 = 500.0;

pub(crate) fn pulley(params: &mut Params) -> Result<Scene, SceneError> {
    let load = params.number("load", 530.0, 1.0e-3..=1.0e7)?;
    let other = params.number("other", 400.0, 1.0e-3..=1.0e7)?;
    let friction = params.number("friction", 0.5, 0.0..=10.0)? as f32;
    let (mut scene, rate) = start_at_rate(params, 1.5)?;
    let (pose, shape) = drum(PULLEY_RADIUS, friction)?;
    let base = scene.body(BodyDef::fixed(Pose::IDENTITY));
    let drum = scene.body(solid(pose, shape, PULLEY_MASS as f32));
    scene.hinge(base, drum, JointKind::HINGE, DVec3::ZERO, DVec3::Z);
    let points = over(PULLEY_RADIUS, 5.0, 0.2);
    let links = lay(&mut scene, &points, friction)?;
    let heavy = hang(&mut scene, links[0], points[0], load)?;
    hang(&mut scene, links[links.len() - 1], points[links.len()], other)?;
    let line = LINK_MASS / (points[1] - points[0]).length();
    let whole = load + other + LINK_MASS * links.len() as f64 + 0.5 * PULLEY_MASS;
    let growth = libm::sqrt(2.0 * line * f64::from(GRAVITY) / whole);
    let time = f64::from(scene.steps) / rate;
    let expected = (load - other) / (2.0 * line) * (libm::cosh(growth * time) - 1.0);
    risen(&mut scene, "fallen_err_pct", heavy, move |rise| 100.0 * (-rise / expected - 1.0).abs());
    let steps = scene.steps;
    scene.judge(JointGap::over_last(steps));
    Ok(scene)
}
