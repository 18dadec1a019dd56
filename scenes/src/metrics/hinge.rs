//! How far hinges turn and ball joints swing past their stops.

use std::f64::consts::{PI, TAU};

use longspan::glam::{DQuat, DVec3};
use longspan::{JointKind, Pose};

use super::{Errors, Metric, View, Worst, or_infinite};

/// Angle of a hinge in (−π, π], from poses: rotation of B's joint frame against A's about the joint axis (rad).
pub fn hinge_angle(view: &View, joint: usize) -> f64 {
    let joint = &view.joints[joint];
    let turn = |side: Option<usize>| side.map_or(DQuat::IDENTITY, |body| view.engine.pose(body).rotation.as_dquat());
    let a = turn(joint.a) * joint.def.frame_a.rotation.as_dquat();
    let b = turn(joint.b) * joint.def.frame_b.rotation.as_dquat();
    let relative = a.normalize().conjugate() * b.normalize();
    let angle = 2.0 * relative.x.atan2(relative.w);
    if angle > PI {
        angle - TAU
    } else if angle <= -PI {
        angle + TAU
    } else {
        angle
    }
}

/// `overshoot_deg`: how far any limited hinge is past its stops, the worst since a step; `limit_err_deg` at the end.
pub struct HingeOvershoot {
    since: u32,
    peak: Worst,
    end: Worst,
}

impl HingeOvershoot {
    /// Watches from this step on.
    pub fn since(since: u32) -> Self {
        Self { since, peak: Worst::ZERO, end: Worst::ZERO }
    }
}

impl Metric for HingeOvershoot {
    fn observe(&mut self, view: &View) {
        for (index, joint) in view.joints.iter().enumerate() {
            let JointKind::Hinge { limits, .. } = joint.def.kind else { continue };
            let angle = hinge_angle(view, index);
            let past = (f64::from(limits.min) - angle).max(angle - f64::from(limits.max)).to_degrees();
            let past = if angle.is_nan() { f64::NAN } else { past };
            if view.step >= self.since {
                self.peak.note(past);
            }
            if view.at_end() {
                self.end.note(past);
            }
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.extend([("overshoot_deg", self.peak.value()), ("limit_err_deg", self.end.value())]);
    }
}

/// `limit_err_deg`: how far any ball joint with a swing limit swings past it, the worst of the run.
#[derive(Default)]
pub struct SwingOvershoot {
    worst: f64,
}

impl Metric for SwingOvershoot {
    fn observe(&mut self, view: &View) {
        for joint in view.joints {
            let JointKind::Spherical { swing_limit, .. } = joint.def.kind else { continue };
            let axis = |side: Option<usize>, frame: &Pose| {
                let turn = side.map_or(DQuat::IDENTITY, |body| view.engine.pose(body).rotation.as_dquat().normalize());
                turn * (frame.rotation.as_dquat().normalize() * DVec3::X)
            };
            let (a, b) = (axis(joint.a, &joint.def.frame_a), axis(joint.b, &joint.def.frame_b));
            let swing = a.cross(b).length().atan2(a.dot(b));
            self.worst = self.worst.max(or_infinite((swing - f64::from(swing_limit)).to_degrees()));
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("limit_err_deg", self.worst));
    }
}

/// `angle_err_deg`: how far a hinge is from an angle at the end.
pub struct HingeError {
    joint: usize,
    expected: f64,
    end: Worst,
}

impl HingeError {
    /// `expected` in radians.
    pub fn new(joint: usize, expected: f64) -> Self {
        Self { joint, expected, end: Worst::ZERO }
    }
}

impl Metric for HingeError {
    fn observe(&mut self, view: &View) {
        if view.at_end() {
            self.end.note((hinge_angle(view, self.joint) - self.expected).abs().to_degrees());
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("angle_err_deg", self.end.value()));
    }
}
