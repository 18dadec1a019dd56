//! How far hinges turn past their stops.

use std::f64::consts::{PI, TAU};

use longspan::JointKind;
use longspan::glam::DQuat;

use super::{Errors, Metric, View, Worst};

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
