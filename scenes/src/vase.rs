//! A vase of welded pieces dropped on its edge (Müller et al. 2017, Fig. 17), unbreakable unless `break` is set.
//!
//! Six rings of ten boxes with radii 0.28, 0.36, 0.42, 0.40, 0.32 and 0.24 m, each ring 0.16 m high, the wall twice 0.025 m thick;
//! fixed joints to both neighbours in the ring and to the piece above. Another number of `pieces` keeps the outline: a rings of
//! b boxes with b/a close to 10/6, radii between those given. Boxes are a hundredth smaller than their share, so that none touches
//! at the start. Tilted by 35°, the lowest corner 2 m above the floor; friction 0.5; pieces are fast, so that engines with
//! continuous detection use it, unless `fast=off`. 4 s.
//!
//! `break` is the stress (Pa) that a weld bears in tension and shear, and a tenth of what it bears in compression, over the section
//! that its two pieces share; the axis of a weld points from piece to piece.

use std::f64::consts::TAU;

use longspan::glam::{DQuat, DVec3};
use longspan::{BodyDef, BodyKind, BondMaterial, JointKind, Pose};

use crate::assemble::x_to;
use crate::metrics::{Breakage, EnergyRise, NotFinite, RigidDeviation};
use crate::params::{Params, SceneError};
use crate::scene::{GRAVITY, Scene, cuboid, floor, start};

const RADII: [f64; 6] = [0.28, 0.36, 0.42, 0.40, 0.32, 0.24];
const HEIGHT: f64 = 6.0 * 0.16;
const HALF_WALL: f64 = 0.025;
const FILL: f64 = 0.99;
const TILT_DEG: f64 = 35.0;
const DROP: f64 = 2.0;

/// Radius of the outline at this share of the height.
fn radius(share: f64) -> f64 {
    let place = (share * 6.0 - 0.5).clamp(0.0, 5.0);
    let below = (place.floor() as usize).min(4);
    let part = place - below as f64;
    RADII[below] * (1.0 - part) + RADII[below + 1] * part
}

pub(crate) fn vase(params: &mut Params) -> Result<Scene, SceneError> {
    let wanted = params.count("pieces", 60, 12..=100_000)?;
    let fast = params.switch("fast", true)?;
    let stress = params.number("break", 0.0, 0.0..=1.0e12)?;
    let material = (stress > 0.0).then(|| BondMaterial::brittle(stress as f32));
    let mut scene = start(params, 4.0)?;
    let around = ((wanted as f64 * 10.0 / 6.0).sqrt().round() as usize).max(4);
    let rings = (wanted as f64 / around as f64).round().max(2.0) as usize;
    if rings * around != wanted {
        scene.params.push(("pieces_built".into(), (rings * around).to_string()));
    }

    scene.body(floor(50.0, 0.0, 0.5)?);
    let ring_height = HEIGHT / rings as f64;
    let half_angle = 0.5 * TAU / around as f64;
    let tilt = DQuat::from_rotation_z(TILT_DEG.to_radians());
    let mut pieces: Vec<(Pose, DVec3)> = Vec::new();
    for ring in 0..rings {
        let share = (ring as f64 + 0.5) / rings as f64;
        let half = FILL * DVec3::new(HALF_WALL / FILL, 0.5 * ring_height, radius(share) * libm::tan(half_angle));
        for place in 0..around {
            let turn = tilt * DQuat::from_rotation_y(2.0 * half_angle * place as f64);
            let position = turn * (radius(share) * DVec3::X) + tilt * (share * HEIGHT * DVec3::Y);
            pieces.push((Pose { position, rotation: turn.normalize().as_quat() }, half));
        }
    }
    let corner = |(pose, half): &(Pose, DVec3)| {
        let axes = longspan::glam::DMat3::from_quat(pose.rotation.as_dquat());
        pose.position.y - (axes.x_axis.y.abs() * half.x + axes.y_axis.y.abs() * half.y + axes.z_axis.y.abs() * half.z)
    };
    let lowest = pieces.iter().map(corner).fold(f64::INFINITY, f64::min);
    let first = scene.bodies.len();
    for (pose, half) in &pieces {
        let shape = cuboid(half.x as f32, half.y as f32, half.z as f32)?;
        let mut def = BodyDef::dynamic(Pose { position: pose.position + DVec3::Y * (DROP - lowest), ..*pose }).with_shape(shape);
        def.fast = fast;
        scene.body(def);
    }
    let piece = |ring: usize, place: usize| first + ring * around + place % around;
    for ring in 0..rings {
        for place in 0..around {
            weld(&mut scene, piece(ring, place), piece(ring, place + 1));
            if ring + 1 < rings {
                weld(&mut scene, piece(ring, place), piece(ring + 1, place));
            }
        }
    }
    if let Some(material) = material {
        let width = |body: usize| pieces[body - first].1.z;
        for joint in &mut scene.joints {
            let (Some(a), Some(b)) = (joint.a, joint.b) else { continue };
            let is_beside = (a - first) / around == (b - first) / around;
            let length = if is_beside { ring_height } else { 2.0 * width(a).min(width(b)) };
            joint.def.strength = material.strength((2.0 * HALF_WALL * length) as f32);
            let along = x_to(scene.bodies[b].pose.position - scene.bodies[a].pose.position);
            let turned = |body: usize| (scene.bodies[body].pose.rotation.conjugate() * along).normalize();
            (joint.def.frame_a.rotation, joint.def.frame_b.rotation) = (turned(a), turned(b));
        }
        scene.judge(Breakage::default());
        scene.judge(NotFinite::default());
        return Ok(scene);
    }

    let mass_height: f64 = scene.bodies.iter().filter(|body| body.kind == BodyKind::Dynamic).map(weight_height).sum();
    scene.judge(RigidDeviation::new((first..scene.bodies.len()).collect()));
    scene.judge(EnergyRise::new("energy_gain_pct", mass_height * f64::from(GRAVITY)));
    Ok(scene)
}

/// Mass times height above the floor (kg·m).
fn weight_height(body: &BodyDef) -> f64 {
    match body.mass {
        longspan::Mass::Properties(mass) => f64::from(mass.mass) * body.pose.position.y,
        _ => 0.0,
    }
}

/// A fixed joint halfway between two pieces.
fn weld(scene: &mut Scene, a: usize, b: usize) {
    let (pose_a, pose_b) = (scene.bodies[a].pose, scene.bodies[b].pose);
    let between = Pose::at(0.5 * (pose_a.position + pose_b.position)).rotated(pose_a.rotation);
    scene.join(a, b, JointKind::Fixed, &between);
}
