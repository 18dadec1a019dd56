//! Energy of a driven scene, with the work of what drives it accounted for.

use longspan::glam::DVec3;
use longspan::{BodyKind, JointKind, Motor};

use super::energy::total_energy;
use super::{Errors, Metric, View, or_infinite, transform_point};
use crate::engine::SceneJoint;

/// What a joint drives with, as it stood a step ago.
#[derive(Clone, Copy)]
enum Drive {
    /// The motor of a hinge: the rate that it turns at (rad/s), and its axis.
    Motor { joint: usize, rate: f64, axis: DVec3 },
    /// A kinematic body: the joint's point on it (m). `sign` is −1 where that is body B, which the reported force acts on.
    Hand { joint: usize, point: DVec3, sign: f64 },
}

/// `unexplained_rise_pct`: how far kinetic and potential energy rise above their start and the work of all drives, in per cent of
/// m g L, with L the greatest distance of two bodies at the start.
///
/// The work of a hinge's motor is the joint's torque about its axis times the rate that the hinge turns at, before and after the step on
/// average, and its time: what takes errors out of positions turns a hinge too, and is no work of its motor. That of a kinematic body is
/// its joint's force times the way of the joint's point. Not reported by an engine that does not tell both.
#[derive(Default)]
pub struct DrivenEnergy {
    drives: Vec<Drive>,
    start: f64,
    scale: f64,
    time: f64,
    work: f64,
    rise: Option<f64>,
}

impl DrivenEnergy {
    fn begin(&mut self, view: &View) {
        let centers: Vec<DVec3> = view.dynamic().map(|body| view.center(body)).collect();
        let length = centers.iter().flat_map(|a| centers.iter().map(|b| a.distance(*b))).fold(0.0, f64::max);
        let mass: f64 = view.dynamic().filter_map(|body| view.mass(body)).map(|mass| f64::from(mass.mass)).sum();
        (self.start, self.time) = (total_energy(view), view.time);
        self.scale = mass * f64::from(crate::scene::GRAVITY) * length;
        self.drives = (0..view.joints.len()).filter_map(|joint| drive_of(view, joint)).collect();
    }
}

impl Metric for DrivenEnergy {
    fn observe(&mut self, view: &View) {
        if view.step == 0 {
            self.begin(view);
            return;
        }
        for drive in &mut self.drives {
            let Some(work) = done(view, drive, view.time - self.time) else { return };
            self.work += work;
        }
        self.time = view.time;
        let rise = or_infinite(100.0 * (total_energy(view) - self.start - self.work) / self.scale);
        self.rise = Some(self.rise.map_or(rise, |before| before.max(rise)));
    }

    fn report(&self, errors: &mut Errors) {
        errors.extend(self.rise.map(|rise| ("unexplained_rise_pct", rise)));
    }
}

fn axis_of(view: &View, joint: &SceneJoint) -> DVec3 {
    let turn = joint.a.map_or(joint.def.frame_a.rotation, |body| view.engine.pose(body).rotation * joint.def.frame_a.rotation);
    turn.as_dquat().normalize() * DVec3::X
}

/// The point of a joint on its body A or B.
fn point_on(view: &View, joint: &SceneJoint, body: usize) -> DVec3 {
    let frame = if joint.a == Some(body) { &joint.def.frame_a } else { &joint.def.frame_b };
    transform_point(&view.engine.pose(body), frame.position.as_vec3())
}

fn drive_of(view: &View, index: usize) -> Option<Drive> {
    let joint = &view.joints[index];
    let is_hand = |body: &usize| view.bodies[*body].kind == BodyKind::Kinematic;
    if let Some(body) = joint.a.filter(is_hand) {
        return Some(Drive::Hand { joint: index, point: point_on(view, joint, body), sign: 1.0 });
    }
    if let Some(body) = joint.b.filter(is_hand) {
        return Some(Drive::Hand { joint: index, point: point_on(view, joint, body), sign: -1.0 });
    }
    match joint.def.kind {
        JointKind::Hinge { motor, .. } if motor != Motor::Off => {
            let axis = axis_of(view, joint);
            let spin = |body: Option<usize>| body.map_or(DVec3::ZERO, |body| view.engine.angular_velocity(body).as_dvec3());
            Some(Drive::Motor { joint: index, rate: axis.dot(spin(joint.b) - spin(joint.a)), axis })
        }
        _ => None,
    }
}

/// Work of a drive over a step of `dt` (s), in J; it stands where it does now after that.
fn done(view: &View, drive: &mut Drive, dt: f64) -> Option<f64> {
    let before = *drive;
    *drive = match before {
        Drive::Motor { joint, .. } | Drive::Hand { joint, .. } => drive_of(view, joint)?,
    };
    match (before, *drive) {
        (Drive::Motor { joint, rate, axis }, Drive::Motor { rate: now, axis: axis_now, .. }) => {
            let along = (axis + axis_now).normalize_or_zero();
            Some(view.engine.joint_torque(joint)?.as_dvec3().dot(along) * 0.5 * (rate + now) * dt)
        }
        (Drive::Hand { joint, point, sign }, Drive::Hand { point: now, .. }) => {
            Some(sign * view.engine.joint_force(joint)?.as_dvec3().dot(now - point))
        }
        _ => None,
    }
}
