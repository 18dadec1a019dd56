//! A tensegrity tower: struts that touch no other strut of their storey, held apart by cables alone, and a plate with a load on top.
//!
//! Each storey is a prism of three struts (capsules of 1 kg, radius 0.02 m) 1 m high on a circle of 0.5 m, turned by 150° from bottom to
//! top, the angle at which struts and cables of any prestress are in equilibrium; storeys turn in turn. Nine cables a storey (distance
//! joints with a greatest length alone): along both triangles, and the short way up. Struts of two storeys meet in ball joints; those of the
//! lowest stand on the floor by friction. A plate of `load` kg lies on the uppermost three.
//!
//! It stands as it was made: `sunk_m` is how far the top has come from there, `joint_gap_m` counts cables that are too long too.

use std::f64::consts::{PI, TAU};

use longspan::glam::DVec3;
use longspan::{BodyId, CollisionFilter, JointDef, JointKind, Limits, Motor, Pose};

use crate::assemble::{filtered, rod, solid};
use crate::metrics::{JointGap, Reading};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, floor, start_at_rate, with_friction};

const RADIUS: f64 = 0.5;
const STRUT: f64 = 0.02;
const TWIST: f64 = 150.0 * PI / 180.0;

/// Struts touch the floor and the plate, not each other.
const STRUTS: CollisionFilter = CollisionFilter { member_of: 2, collides_with: 1 };

/// A cable between two points of the world on two bodies, as long as it is.
fn cable(scene: &mut Scene, a: usize, b: usize, from: DVec3, to: DVec3) {
    let limits = Limits::new(0.0, from.distance(to) as f32);
    let kind = JointKind::Distance { limits, spring_length: None, motor: Motor::Off };
    let mut def = JointDef::new(kind, BodyId::NULL, BodyId::NULL);
    for (body, point, frame) in [(a, from, &mut def.frame_a), (b, to, &mut def.frame_b)] {
        let pose = scene.bodies[body].pose;
        *frame = Pose::at(pose.rotation.as_dquat().normalize().conjugate() * (point - pose.position));
    }
    scene.joint(Some(a), Some(b), def);
}

pub(crate) fn tensegrity(params: &mut Params) -> Result<Scene, SceneError> {
    let storeys = params.count("storeys", 4, 1..=30)?;
    let load = params.number("load", 100.0, 0.0..=1.0e6)?;
    let (mut scene, _) = start_at_rate(params, 5.0)?;
    scene.body(floor(5.0, 0.0, 0.8)?);
    let corner = |turn: f64, height: f64| {
        [0.0, 1.0, 2.0].map(|third| {
            let angle = turn + TAU * third / 3.0;
            DVec3::new(RADIUS * libm::cos(angle), height, RADIUS * libm::sin(angle))
        })
    };
    let mut turn = 0.0;
    let mut below: Option<[usize; 3]> = None;
    let mut tops = corner(turn, STRUT);
    for storey in 0..storeys {
        let feet = tops;
        turn += if storey % 2 == 0 { TWIST } else { -TWIST };
        tops = corner(turn, STRUT + (storey + 1) as f64);
        let mut struts = [0; 3];
        for side in 0..3 {
            // Its round ends are about its corners.
            let along = (tops[side] - feet[side]).normalize() * STRUT;
            let strut = rod(feet[side] - along, tops[side] + along, STRUT as f32, 1.0)?;
            struts[side] = scene.body(filtered(strut, STRUTS));
            if let Some(below) = below {
                scene.tie(below[side], struts[side], feet[side]);
            }
        }
        for side in 0..3 {
            let next = (side + 1) % 3;
            if storey == 0 {
                cable(&mut scene, struts[side], struts[next], feet[side], feet[next]);
            }
            cable(&mut scene, struts[side], struts[next], tops[side], tops[next]);
            let others = (0..3).filter(|&other| other != side);
            let short = |a: &usize, b: &usize| feet[side].distance(tops[*a]).total_cmp(&feet[side].distance(tops[*b]));
            let up = others.min_by(short).unwrap_or(next);
            cable(&mut scene, struts[side], struts[up], feet[side], tops[up]);
        }
        below = Some(struts);
    }
    let below = below.unwrap_or_default();
    let top = tops[0].y;
    if load > 0.0 {
        let plate = with_friction(cuboid(0.6, 0.05, 0.6)?, 0.8);
        let at = DVec3::Y * (top + STRUT + 0.05);
        let plate = scene.body(solid(Pose::at(at), plate, load as f32));
        let steps = scene.steps;
        scene.judge(Reading::worst_of_last(steps, "sunk_m", move |view| (view.engine.pose(plate).position - at).length()));
    } else {
        let (steps, ends) = (scene.steps, below.map(|strut| (strut, scene.bodies[strut].pose.position)));
        let sunk = move |view: &crate::metrics::View| {
            ends.iter().map(|&(strut, at)| (view.engine.pose(strut).position - at).length()).fold(0.0, f64::max)
        };
        scene.judge(Reading::worst_of_last(steps, "sunk_m", sunk));
    }
    let steps = scene.steps;
    scene.judge(JointGap::over_last(steps));
    scene.judge(Reading::after(steps, "speed_m_s", |view| {
        let speeds = view.dynamic().map(|body| f64::from(view.engine.linear_velocity(body).length()));
        speeds.fold(0.0, f64::max)
    }));
    Ok(scene)
}
