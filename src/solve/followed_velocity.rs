//! Velocities that motors ask for and poses do not follow.
//!
//! Where a motor pulls at a rope that is taut, sweeps end with the row that they visited last: bodies have the speed that the motor asks for,
//! and position rows take back in each step what it moves them by. Where a heavy load lies on a light lift, they take back a part. With c/T
//! what a body's position was corrected by in a step of length T, over that length, M its mass and v its velocity, it is told as
//!
//! ```text
//! v + c/T · clamp(−vᵀ M c / cᵀ M c · T, 0, 1):
//! ```
//!
//! less what is taken back of it, and no less than nothing. What was told is a lead, which the next step takes back first
//! (*velocity_half_step.rs*): sweeps go on from what they have left.

use glam::{Quat, Vec3};

use super::joint::JointLink;
use super::state::{BodyMotion, BodyVelocity};
use crate::step_history::Twist;

/// Share of a velocity that positions may take back before less of it is told.
/// Why: position rows bend paths that are curved, by the square of what a body turns in a substep.
/// Scenes: cranks, cars, lifts and swimmers at 30 to 240 Hz, whose velocities stay. Test: tests/motors.rs
const TAKEN_BACK: f32 = 0.02;

/// What position rows make of the bodies of islands with motors, in one step.
#[derive(Debug, Default)]
pub(crate) struct FollowedVelocities {
    /// By island.
    has_motor: Vec<bool>,
    slots: Vec<u32>,
    /// Where each was before position rows moved it.
    marks: Vec<(Vec3, Quat)>,
    /// Displacement and rotation vector by which they have moved it.
    corrections: Vec<Twist>,
}

impl FollowedVelocities {
    /// Takes in the bodies that move freely of those of `islands`, by their first slots, that swept joints with rigid motors are in: springs
    /// give way by themselves.
    pub(super) fn begin_step(&mut self, links: &[JointLink], islands: &[u32], motions: &[BodyMotion]) {
        self.slots.clear();
        self.has_motor.clear();
        self.has_motor.resize(islands.len(), false);
        for link in links.iter().filter(|link| link.traits.has_rigid_motor) {
            for slot in [link.a, link.b].into_iter().filter(|&slot| motions[slot as usize].is_dynamic()) {
                let island = islands.partition_point(|&first| first <= slot);
                self.has_motor[island - 1] = true;
            }
        }
        for number in (0..islands.len()).filter(|&number| self.has_motor[number]) {
            let end = islands.get(number + 1).map_or(motions.len() as u32, |&next| next);
            self.slots.extend((islands[number]..end).filter(|&slot| motions[slot as usize].is_dynamic()));
        }
        self.corrections.clear();
        self.corrections.resize(self.slots.len(), Twist::default());
    }

    /// Notes where bodies are before position rows act.
    pub(super) fn mark(&mut self, motions: &[BodyMotion]) {
        self.marks.clear();
        let places = self.slots.iter().map(|&slot| &motions[slot as usize]);
        self.marks.extend(places.map(|motion| (motion.displacement, motion.rotation)));
    }

    /// Adds up what they have done since.
    pub(super) fn add_up(&mut self, motions: &[BodyMotion]) {
        for ((&slot, (place, rotation)), sum) in self.slots.iter().zip(&self.marks).zip(&mut self.corrections) {
            let motion = &motions[slot as usize];
            sum[0] += motion.displacement - *place;
            let turn = motion.rotation * rotation.conjugate();
            sum[1] += 2.0 * turn.xyz() * turn.w.signum();
        }
    }

    /// Tells less of the velocities of which positions took back a part in a step of length `dt` (s), and adds that to what `leads` knows.
    pub(super) fn tell(
        &self,
        velocities: &mut [BodyVelocity],
        motions: &[BodyMotion],
        dt: f32,
        mut lead: impl FnMut(usize, Twist),
    ) {
        for (slot, correction) in self.slots.iter().map(|&slot| slot as usize).zip(&self.corrections) {
            let (velocity, motion) = (&mut velocities[slot], &motions[slot]);
            let mass = 1.0 / velocity.inverse_mass.x;
            let [linear, angular] = correction.map(|way| way / dt);
            let spin = motion.angular_momentum(angular);
            let against = -(mass * linear.dot(velocity.linear) + spin.dot(velocity.angular));
            let own = motion.angular_momentum(velocity.angular).dot(velocity.angular);
            let moves = mass * velocity.linear.length_squared() + own;
            let size = mass * linear.length_squared() + spin.dot(angular);
            // Written so that what is no number is left as it is.
            if against > TAKEN_BACK * moves && size > 0.0 {
                let share = (against / size).min(1.0);
                let change = [linear * share, angular * share];
                velocity.linear += change[0];
                velocity.angular += change[1];
                lead(slot, change);
            }
        }
    }
}
