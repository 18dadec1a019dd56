//! A robot arm: seven hinges with speed servos carry a payload.
//!
//! From a static box at the origin six links of 10 kg (boxes of half-extents 0.05 × 0.2 × 0.05 m) stand upright on one another; the
//! seventh body is the payload, a cube of half-extent 0.2 m and `payload` kg. The hinges turn about y, z, x, z, y, z, x in this order,
//! each at 20°/s, the second and the sixth backwards, with a torque of at most `torque` N·m. All bodies start with the velocities
//! that these rates give them, so the angle of each hinge should be its rate times time. Nothing touches. 4 s.

use longspan::glam::DVec3;
use longspan::{BodyDef, JointKind, Limits, Motor, Pose};

use crate::assemble::{INTANGIBLE, filtered, solid};
use crate::machines::servo_error;
use crate::metrics::{DrivenEnergy, JointGap};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, start};

const AXES: [DVec3; 7] = [DVec3::Y, DVec3::Z, DVec3::X, DVec3::Z, DVec3::Y, DVec3::Z, DVec3::X];
const RATE_DEG: f64 = 20.0;
const LINK: f64 = 0.4;
const PAYLOAD_HALF: f32 = 0.2;

/// Rate of a hinge (rad/s).
fn rate(hinge: usize) -> f64 {
    let sign = if hinge == 1 || hinge == 5 { -1.0 } else { 1.0 };
    sign * RATE_DEG.to_radians()
}

pub(crate) fn arm(params: &mut Params) -> Result<Scene, SceneError> {
    let payload = params.number("payload", 200.0, 1.0e-3..=1.0e9)?;
    let torque = params.number("torque", f64::INFINITY, 0.0..=f64::INFINITY)?;
    let mut scene = start(params, 4.0)?;

    let base = BodyDef::fixed(Pose::at_xyz(0.0, -0.1, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1)?);
    let mut held = scene.body(filtered(base, INTANGIBLE));
    let mut joints = Vec::new();
    let (mut spin, mut speed) = (DVec3::ZERO, DVec3::ZERO);
    for (index, axis) in AXES.into_iter().enumerate() {
        let foot = DVec3::Y * (LINK * index as f64);
        let is_payload = index + 1 == AXES.len();
        let rise = if is_payload { f64::from(PAYLOAD_HALF) } else { 0.5 * LINK };
        let shape = if is_payload { cuboid(PAYLOAD_HALF, PAYLOAD_HALF, PAYLOAD_HALF)? } else { cuboid(0.05, 0.2, 0.05)? };
        let mut def = solid(Pose::at(foot + DVec3::Y * rise), shape, if is_payload { payload as f32 } else { 10.0 });
        // `speed` is that of the foot; the link turns about it.
        spin += axis * rate(index);
        def.angular_velocity = spin.as_vec3();
        def.linear_velocity = (speed + spin.cross(DVec3::Y * rise)).as_vec3();
        speed += spin.cross(DVec3::Y * LINK);

        let body = scene.body(filtered(def, INTANGIBLE));
        let motor = Motor::Velocity { target: rate(index) as f32, max_force: torque as f32 };
        let kind = JointKind::Hinge { limits: Limits::NONE, motor };
        joints.push((scene.hinge(held, body, kind, foot, axis), rate(index)));
        held = body;
    }

    let steps = scene.steps;
    scene.judge(servo_error(steps, joints));
    scene.judge(JointGap::over_last(steps));
    scene.judge(DrivenEnergy::default());
    Ok(scene)
}
