//! How far joints come apart, how far a path of joints stretches, and whether a joint reports what it carries.

use longspan::glam::DVec3;
use longspan::{Axis, JointKind, Pose};

use super::{Errors, Metric, View, Worst, or_infinite};
use crate::engine::{Engine, SceneJoint};

/// Distance between the two points of a joint beyond what it allows (m).
pub fn gap_of(joint: &SceneJoint, engine: &dyn Engine) -> f64 {
    let frame = |side: Option<usize>, local: &Pose| match side {
        None => *local,
        Some(body) => {
            let pose = engine.pose(body);
            let turn = pose.rotation.as_dquat().normalize();
            Pose {
                position: pose.position + turn * local.position,
                rotation: (turn * local.rotation.as_dquat()).normalize().as_quat(),
            }
        }
    };
    let a = frame(joint.a, &joint.def.frame_a);
    let b = frame(joint.b, &joint.def.frame_b);
    let apart = b.position - a.position;
    let in_a = a.rotation.as_dquat().normalize().conjugate() * apart;
    match &joint.def.kind {
        JointKind::Prismatic { .. } => in_a.y.hypot(in_a.z),
        JointKind::Distance { limits, .. } => beyond(apart.length(), limits.min, limits.max),
        JointKind::Generic { linear, .. } => {
            let excess = |axis: &Axis, value: f64| beyond(value, axis.limits.min, axis.limits.max);
            DVec3::new(excess(&linear[0], in_a.x), excess(&linear[1], in_a.y), excess(&linear[2], in_a.z)).length()
        }
        _ => apart.length(),
    }
}

/// How far `value` lies outside `min … max`; not a number stays so.
fn beyond(value: f64, min: f32, max: f32) -> f64 {
    if value < f64::from(min) {
        f64::from(min) - value
    } else if value > f64::from(max) {
        value - f64::from(max)
    } else {
        value * 0.0
    }
}

/// `joint_gap_m`: the worst gap of any joint over the last steps (m).
pub struct JointGap {
    last: u32,
    worst: Worst,
}

impl JointGap {
    /// Watches the last `last` steps.
    pub fn over_last(last: u32) -> Self {
        Self { last, worst: Worst::ZERO }
    }
}

impl Metric for JointGap {
    fn observe(&mut self, view: &View) {
        if view.step > 0 && view.in_last(self.last) {
            for joint in view.joints {
                self.worst.note(gap_of(joint, view.engine));
            }
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("joint_gap_m", self.worst.value()));
    }
}

/// `stretch_pct`: length of the path through a series of joints, gaps included, over its rest length, the worst of the last steps
/// and of all paths.
///
/// Inside a rigid body the path keeps its length, so what it gains is the sum of the gaps.
pub struct Stretch {
    /// Joints of each path and its length at rest (m).
    paths: Vec<(Vec<usize>, f64)>,
    last: u32,
    worst: Worst,
}

impl Stretch {
    /// The path through `joints`, of `rest_length` (m), over the last `last` steps.
    pub fn new(joints: Vec<usize>, rest_length: f64, last: u32) -> Self {
        Self::worst_of(vec![(joints, rest_length)], last)
    }

    /// Several paths, each its joints and its length at rest (m), over the last `last` steps.
    pub fn worst_of(paths: Vec<(Vec<usize>, f64)>, last: u32) -> Self {
        Self { paths, last, worst: Worst::ZERO }
    }
}

impl Metric for Stretch {
    fn observe(&mut self, view: &View) {
        if view.step > 0 && view.in_last(self.last) {
            for (joints, rest_length) in &self.paths {
                let gained: f64 = joints.iter().map(|&joint| gap_of(&view.joints[joint], view.engine)).sum();
                self.worst.note(100.0 * gained / rest_length);
            }
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("stretch_pct", self.worst.value()));
    }
}

/// `load_err_pct`: mean reported force of a joint over the last steps against the weight that hangs below it.
pub struct LoadError {
    joint: usize,
    weight: f64,
    last: u32,
    sum: DVec3,
    samples: u32,
}

impl LoadError {
    /// `weight` (N) hangs below `joint`.
    pub fn new(joint: usize, weight: f64, last: u32) -> Self {
        Self { joint, weight, last, sum: DVec3::ZERO, samples: 0 }
    }
}

impl Metric for LoadError {
    fn observe(&mut self, view: &View) {
        if view.step > 0
            && view.in_last(self.last)
            && let Some(force) = view.engine.joint_force(self.joint)
        {
            self.sum += force.as_dvec3();
            self.samples += 1;
        }
    }

    fn report(&self, errors: &mut Errors) {
        if self.samples > 0 {
            let mean = self.sum.length() / f64::from(self.samples);
            errors.push(("load_err_pct", or_infinite(100.0 * (mean - self.weight).abs() / self.weight)));
        }
    }
}

#[cfg(test)]
mod tests {
    use longspan::glam::{Quat, Vec3};
    use longspan::{BodyDef, BodyId, JointDef, Limits, WorldDef};

    use super::*;
    use crate::engine::Effort;
    use crate::longspan_engine::LongspanEngine;

    fn joint(kind: JointKind) -> SceneJoint {
        let def = JointDef::new(kind, BodyId::NULL, BodyId::NULL).at(Vec3::new(0.0, -0.5, 0.0), Vec3::new(0.0, 0.5, 0.0));
        SceneJoint { a: Some(0), b: Some(1), def }
    }

    /// Two static bodies, the second at `b`.
    fn still(b: Pose) -> LongspanEngine {
        let mut engine = LongspanEngine::new(&WorldDef::default(), Effort::Default, 1).unwrap();
        engine.add_body(&BodyDef::fixed(Pose::IDENTITY));
        engine.add_body(&BodyDef::fixed(b));
        engine
    }

    #[test]
    fn a_gap_is_the_distance_that_the_joint_does_not_allow() {
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} m, expected {expected} m");
        let apart = Pose::at_xyz(0.3, -1.0, 0.4);
        close(gap_of(&joint(JointKind::SPHERICAL), &still(apart)), 0.5);
        close(gap_of(&joint(JointKind::PRISMATIC), &still(apart)), 0.4);
        let rope = |max| JointKind::Distance { limits: Limits::new(0.0, max), spring_length: None, motor: Default::default() };
        close(gap_of(&joint(rope(0.25)), &still(apart)), 0.25);
        close(gap_of(&joint(rope(0.75)), &still(apart)), 0.0);
        let turned = Pose::at_xyz(0.5, -0.5, 0.0).rotated(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2));
        assert!(gap_of(&joint(JointKind::Fixed), &still(turned)) < 1e-7);
    }

    #[test]
    fn stretch_is_the_sum_of_gaps_over_the_rest_length() {
        let engine = still(Pose::at_xyz(0.0, -1.02, 0.0));
        let (bodies, joints) = (vec![BodyDef::default(), BodyDef::default()], vec![joint(JointKind::SPHERICAL)]);
        let view = View {
            step: 10,
            steps: 10,
            time: 1.0,
            gravity: Vec3::ZERO,
            engine: &engine,
            bodies: &bodies,
            alive: &[true, true],
            joints: &joints,
        };
        let mut metric = Stretch::new(vec![0], 2.0, 5);
        metric.observe(&view);
        let mut errors = Errors::new();
        metric.report(&mut errors);
        assert!((errors[0].1 - 1.0).abs() < 1e-9, "{} %, expected 1 %", errors[0].1);
    }
}
