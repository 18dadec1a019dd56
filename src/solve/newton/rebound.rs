//! What hits in a substep with restitution leaves again before the substep: see [`impact`](super::impact).

use super::held::rate_of;
use super::island::CoupledIsland;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::solve::StepSettings;

/// Impacts of a substep at most: what one throws may be about to hit the next, as balls do that hang in a row.
const MAX_BLOWS: usize = 24;

impl CoupledIsland {
    /// Lets what hits rebound, and forms the problem of the substep anew with what that leaves of the velocities.
    pub(super) fn rebound(&mut self, joints: &Pool<Joint, JointId>, settings: &StepSettings, h: f64, left: [f64; 2]) {
        for _ in 0..MAX_BLOWS {
            let before = self.energy();
            if !self.is_hit(f64::from(settings.restitution_threshold)) {
                break;
            }
            if self.problem.is_driven() {
                self.outcome.driven += (self.energy() - before).max(0.0);
            }
            self.build(joints, h, left);
        }
    }

    /// Lets what hits within the substep rebound; whether anything did. The problem is that of the impact then.
    fn is_hit(&mut self, threshold: f64) -> bool {
        let Self { problem, held, patches, bodies, rates, .. } = self;
        let first = held.sources.len();
        if !problem.strikes(first, threshold) {
            return false;
        }
        problem.strike(first, threshold);
        if !problem.velocity.iter().flatten().all(|value| value.is_finite()) {
            return true;
        }
        let moved = bodies.iter().zip(rates).filter(|(body, _)| body.is_dynamic());
        moved.zip(&problem.velocity).for_each(|((_, rate), velocity)| *rate = rate_of(velocity));
        patches.iter_mut().for_each(|patch| patch.add_up(&problem.terms));
        held.add_blow(problem);
        true
    }
}
