//! Tells which bodies a step may have taken past what contacts have seen.
//!
//! Contacts are looked for once a step, on the way on which each body would go on as it moves. A hit may send a small body another way: a box
//! of 1 cm that lands on a corner turns half round within the step, and another corner comes down where no contact is. So a body on which
//! rows act, and which ends far from that way or has turned far, is swept along the way that it took.

use glam::Vec3;

use crate::body::Body;
use crate::collide::sweep::{BodyPose, SWEEP_THRESHOLD};
use crate::solve::state::BodyMotion;
use crate::tuning::fast::{FAR_TURN, SLENDER};

/// A body before a step is written back to it.
#[derive(Debug, Clone, Copy)]
pub(in crate::world) struct Start {
    pub pose: BodyPose,
    linear: Vec3,
    angular: Vec3,
}

impl Start {
    pub(in crate::world) fn of(body: &Body) -> Self {
        let pose = BodyPose { center: body.center, rotation: body.rotation };
        Self { pose, linear: body.linear_velocity, angular: body.angular_velocity }
    }

    /// Whether a step of length `dt` (s) has taken it off its way; `reach` is how far it reaches from its centre, and `carried_by` how far a
    /// turn takes what it is made of (m).
    pub(in crate::world) fn goes_astray(
        &self,
        motion: &BodyMotion,
        dt: f32,
        (reach, least_extent): (f32, f32),
        carried_by: impl Fn(Vec3) -> f32,
    ) -> bool {
        if reach > SLENDER * least_extent {
            return false;
        }
        let aside = (motion.displacement - self.linear * dt).length();
        let turned_aside = motion.turn - self.angular * dt;
        let is_far = |by: &dyn Fn(Vec3) -> f32| {
            aside + by(turned_aside) > SWEEP_THRESHOLD * least_extent || by(motion.turn) > FAR_TURN * reach
        };
        // What is round and stays about where it is comes nowhere else by spinning.
        let moves = motion.displacement.length() > SWEEP_THRESHOLD * least_extent;
        is_far(&|turn| turn.length() * reach) && (moves || is_far(&carried_by))
    }
}
