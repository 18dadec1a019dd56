//! A free closed loop of parallel hinges (Müller et al. 2017, Fig. 9 and 13), struck sideways.
//!
//! n boxes of 1 kg, 0.2 m long (half-extents 0.1 × 0.04 × 0.05 m along, across, up), lie as a regular polygon in the x–y plane;
//! hinges along z at its corners. With `offset=on` links n/3 + 1 … 2n/3 − 1 lie 0.3 m higher, and the two links between low and
//! high are taller by half of that each way and stand 0.15 m up. Zero gravity; link 0 starts with 50 m/s along z: an impulse of
//! 50 N·s at its centre, or of `impulse`.

use std::f64::consts::TAU;

use longspan::glam::{DQuat, DVec2, DVec3, Vec3};
use longspan::{JointKind, Pose};

use crate::assemble::{solid, x_to};
use crate::metrics::{AngularMomentumError, HingePlane, JointGap, LinearMomentumError, Moved, PlaneMember};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, start_in, weightless};

const LENGTH: f64 = 0.2;
const RAISE: f64 = 0.3;
const IMPULSE: f64 = 50.0;

pub(crate) fn hinge_loop(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("n", 132, 6..=5000)?;
    let impulse = params.number("impulse", IMPULSE, 0.0..=1000.0)?;
    let raise = if params.switch("offset", true)? { RAISE } else { 0.0 };
    let mut scene = start_in(weightless(), params, 2.0)?;

    let corner_radius = 0.5 * LENGTH / libm::sin(0.5 * TAU / count as f64);
    let corner = |index: usize| corner_radius * DVec2::from_angle(TAU * index as f64 / count as f64);
    let is_between = |link: usize| link == count / 3 || link == 2 * count / 3;
    let height = |link: usize| match link {
        _ if is_between(link) => 0.5 * raise,
        _ if link > count / 3 && link < 2 * count / 3 => raise,
        _ => 0.0,
    };
    let links: Vec<usize> = (0..count)
        .map(|index| {
            let (from, to) = (corner(index), corner(index + 1));
            let heading = (to - from).to_angle();
            let up = 0.05 + if is_between(index) { 0.5 * raise } else { 0.0 };
            let pose = Pose::at((0.5 * (from + to)).extend(height(index))).rotated(DQuat::from_rotation_z(heading).as_quat());
            Ok(scene.body(solid(pose, cuboid(0.1, 0.04, up as f32)?, 1.0)))
        })
        .collect::<Result<_, SceneError>>()?;
    for index in 0..count {
        let next = (index + 1) % count;
        // Between a taller link and its neighbour the hinge stands at the height of the neighbour.
        let at = if is_between(index) { height(next) } else { height(index) };
        let place = Pose::at(corner(index + 1).extend(at)).rotated(x_to(DVec3::Z));
        scene.join(links[index], links[next], JointKind::HINGE, &place);
    }
    scene.bodies[links[0]].linear_velocity = Vec3::Z * impulse as f32;

    let member = |(index, &body): (usize, &usize)| PlaneMember { body, axis: Vec3::Z, offset: height(index) };
    scene.judge(HingePlane::new(links.iter().enumerate().map(member).collect()));
    let steps = scene.steps;
    if impulse == 0.0 {
        scene.judge(Moved::after(steps, Some(links)));
    }
    scene.judge(JointGap::over_last(steps));
    scene.judge(LinearMomentumError::default());
    scene.judge(AngularMomentumError::default());
    Ok(scene)
}
