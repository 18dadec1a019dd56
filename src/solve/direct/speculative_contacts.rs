//! Contacts outside the system because they do not press: checks whether one would have closed in the step.

use glam::{DQuat, Vec3};

use crate::solve::contact::ContactInput;
use crate::solve::joint::LocalPose;
use crate::solve::rotation;
use crate::solve::state::{BodyMotion, BodyVelocity};

/// Where a body whose step is still to come may go: on at its velocity, held up by others, or in free fall.
pub(crate) fn free_paths(velocity: &BodyVelocity, motion: &BodyMotion, dt: f32) -> [LocalPose; 2] {
    let turn = rotation::rotated(DQuat::IDENTITY, (velocity.angular * dt).as_dvec3());
    let steady = velocity.linear * dt;
    [steady, steady + motion.acceleration * (dt * dt)].map(|flight| (flight.as_dvec3(), turn))
}

/// Whether any point of the contact is closed at the end of any pair of paths.
pub(crate) fn meets(contact: &ContactInput, a: [LocalPose; 2], b: [LocalPose; 2]) -> bool {
    let normal = contact.normal.as_dvec3();
    let along = |path: &LocalPose, lever: Vec3| normal.dot(path.0 + path.1 * lever.as_dvec3() - lever.as_dvec3());
    (0..contact.count).any(|i| {
        let least_b = b.iter().map(|path| along(path, contact.lever_b[i])).fold(f64::INFINITY, f64::min);
        let most_a = a.iter().map(|path| along(path, contact.lever_a[i])).fold(f64::NEG_INFINITY, f64::max);
        f64::from(contact.separation[i]) + least_b - most_a < 0.0
    })
}
