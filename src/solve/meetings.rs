//! Which contacts of an island may press within a step, and how.

use super::StepSettings;
use super::contact::ContactInput;
use super::state::{BodyMotion, BodyVelocity};
use crate::tuning::plan::{BATTED, HEAVY};

/// Whether one side of a contact, which the host moves, turns by more than [`BATTED`] across it in a step of `dt` (s).
pub(super) fn is_batted(contact: &ContactInput, velocities: &[BodyVelocity], dt: f32) -> bool {
    [contact.a, contact.b].into_iter().map(|slot| &velocities[slot as usize]).any(|velocity| {
        velocity.turns_as_told() && velocity.angular.reject_from_normalized(contact.normal).length() * dt > BATTED
    })
}

/// Whether a contact may close within a step of `dt` (s), at the speeds of now, what gravity and the host's forces add, and what springs do that
/// make motions of this size (√J, see [`swing`](super::joint::swing)).
pub(super) fn may_meet(
    contact: &ContactInput,
    (velocities, motions): (&[BodyVelocity], &[BodyMotion]),
    dt: f32,
    swing: f32,
) -> bool {
    let most = |slot: u32| motions[slot as usize].acceleration.length();
    let fall = most(contact.a).max(most(contact.b)) * dt * dt;
    let closes = |point: usize| {
        let thrown = if swing > 0.0 { swing * contact.own_ease(point, velocities).sqrt() } else { 0.0 };
        contact.separation[point] <= fall + (thrown - contact.opening(point, velocities).min(0.0)) * dt
    };
    (0..contact.count).any(closes)
}

/// Whether one body of a contact is held by joints and [`HEAVY`] times lighter than the other, which moves too.
pub(super) fn weighs_down(contact: &ContactInput, velocities: &[BodyVelocity], motions: &[BodyMotion]) -> bool {
    let [a, b] = [contact.a, contact.b].map(|slot| velocities[slot as usize].inverse_mass.max_element());
    let is_light = |slot: u32, own: f32, other: f32| motions[slot as usize].jointed && other > 0.0 && own > HEAVY * other;
    is_light(contact.a, a, b) || is_light(contact.b, b, a)
}

/// Whether a contact is to rebound in the step.
pub(super) fn rebounds(contact: &ContactInput, velocities: &[BodyVelocity], settings: &StepSettings) -> bool {
    contact.material.restitution > 0.0 && contact.closes(velocities, settings.restitution_threshold)
}
