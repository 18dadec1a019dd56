//! A pile of ragdolls.
//!
//! Each of the n ragdolls has 11 bodies of 70 kg together, in metres about the middle of the pelvis, arms spread along x: pelvis
//! (half-extents 0.14 × 0.08 × 0.09, 11 kg), torso (0.16 × 0.20 × 0.10, 25 kg, 0.30 up), head (ball of 0.11, 5 kg, 0.65 up), upper
//! arms (0.14 × 0.045 × 0.045, 2.2 kg), forearms (0.13 × 0.04 × 0.04, 1.8 kg), thighs (0.065 × 0.20 × 0.065, 7 kg) and shins
//! (0.05 × 0.21 × 0.05, 3.5 kg). Ball joints with limited swing: waist 40°, neck 45°, shoulders 80°, hips 70°; elbows and knees are
//! hinges from straight to 140°. Dropped in a column, turned at random, into a walled pit 3 m wide; friction 0.5; 8 s.

use longspan::glam::{DVec3, Quat};
use longspan::{JointKind, Limits, Motor, Pose, ShapeDef, SphericalMotor};

use crate::assemble::solid;
use crate::metrics::{EndSpeeds, Escaped, HingeOvershoot, JointGap, Overlap};
use crate::params::{Params, SceneError};
use crate::pile::add_pit;
use crate::random::Random;
use crate::scene::{Scene, ball, cuboid, start};

const HALF_PIT: f64 = 1.5;
/// Height that each ragdoll gets at the start (m): it fits in whichever way it is turned.
const LAYER: f64 = 2.0;

/// One body of a ragdoll: where its middle stands, its shape and mass.
type Part = (DVec3, ShapeDef, f32);

pub(crate) fn ragdoll_pile(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("n", 20, 1..=2000)?;
    let mut random = Random::new(params.seed()?);
    let mut scene = start(params, 8.0)?;
    let height = LAYER * (count + 1) as f64 + 2.0;
    add_pit(&mut scene, HALF_PIT, height)?;
    for index in 0..count {
        let off = DVec3::new(f64::from(random.between(-0.3, 0.3)), 0.0, f64::from(random.between(-0.3, 0.3)));
        let middle = DVec3::Y * (1.5 + LAYER * index as f64) + off;
        add_ragdoll(&mut scene, &Pose::at(middle).rotated(random.rotation()))?;
    }
    let last = scene.steps.min(120);
    scene.judge(JointGap::over_last(last));
    scene.judge(Overlap::spread(last, 20));
    scene.judge(HingeOvershoot::since(scene.steps - last));
    let reach = HALF_PIT + 0.5;
    scene.judge(Escaped::from(DVec3::new(-reach, -0.5, -reach), DVec3::new(reach, 2.0 * height, reach)));
    scene.judge(EndSpeeds::default());
    Ok(scene)
}

fn at(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

fn swinging(degrees: f32) -> JointKind {
    JointKind::Spherical { swing_limit: degrees.to_radians(), twist_limits: Limits::NONE, motor: SphericalMotor::Off }
}

/// Adds the 11 bodies and 10 joints of a ragdoll whose pelvis stands at `place`.
pub(crate) fn add_ragdoll(scene: &mut Scene, place: &Pose) -> Result<(), SceneError> {
    let limb = |x: f32, y: f32, z: f32| cuboid(x, y, z);
    let mut parts: Vec<Part> = vec![
        (at(0.0, 0.0), limb(0.14, 0.08, 0.09)?, 11.0),
        (at(0.0, 0.30), limb(0.16, 0.20, 0.10)?, 25.0),
        (at(0.0, 0.65), ball(0.11)?, 5.0),
    ];
    for side in [-1.0, 1.0] {
        parts.push((at(side * 0.33, 0.45), limb(0.14, 0.045, 0.045)?, 2.2));
        parts.push((at(side * 0.61, 0.45), limb(0.13, 0.04, 0.04)?, 1.8));
        parts.push((at(side * 0.09, -0.29), limb(0.065, 0.20, 0.065)?, 7.0));
        parts.push((at(side * 0.09, -0.71), limb(0.05, 0.21, 0.05)?, 3.5));
    }
    let turn = place.rotation.as_dquat();
    let bodies: Vec<usize> = parts
        .into_iter()
        .map(|(middle, shape, mass)| {
            scene.body(solid(Pose::at(place.position + turn * middle).rotated(place.rotation), shape, mass))
        })
        .collect();
    let bent = Limits::new(0.0, 140.0_f32.to_radians());
    let hinge = JointKind::Hinge { limits: bent, motor: Motor::Off };
    // Bodies, kind, point and joint axis of each joint, the latter two about the pelvis.
    let mut joints = vec![(0, 1, swinging(40.0), at(0.0, 0.09), DVec3::Y), (1, 2, swinging(45.0), at(0.0, 0.52), DVec3::Y)];
    for (side, first) in [(-1.0, 3), (1.0, 7)] {
        joints.push((1, first, swinging(80.0), at(side * 0.18, 0.45), DVec3::X * side));
        // A bent forearm comes forward, a bent shin goes back.
        joints.push((first, first + 1, hinge, at(side * 0.475, 0.45), DVec3::NEG_Y * side));
        joints.push((0, first + 2, swinging(70.0), at(side * 0.09, -0.085), DVec3::NEG_Y));
        joints.push((first + 2, first + 3, hinge, at(side * 0.09, -0.495), DVec3::X));
    }
    for (a, b, kind, point, axis) in joints {
        let axes = place.rotation * Quat::from_rotation_arc(longspan::glam::Vec3::X, axis.as_vec3());
        scene.join(bodies[a], bodies[b], kind, &Pose::at(place.position + turn * point).rotated(axes.normalize()));
    }
    Ok(())
}
