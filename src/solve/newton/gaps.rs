//! Gaps of an island's joints, and overlaps of its contacts, taken out of its positions.

use super::island::{Island, rate_of};
use crate::id::{JointId, Pool};
use crate::joint::Joint;

/// Shares of what takes errors out of the positions of a loop that are tried, one after the other.
const SHARES: [f64; 3] = [1.0, 0.3, 0.09];

impl Island {
    /// Takes errors of joints and overlaps out of positions: of joints that close a loop no more than makes their gaps less, as a loop that
    /// stands all but straight folds its light links where it should straighten.
    pub(super) fn close_gaps(&mut self, joints: &Pool<Joint, JointId>) {
        let before = if self.is_looped { self.held.square_of_gaps(joints, &self.stances) } else { f64::INFINITY };
        self.problem.find_displacements();
        let Self { problem, bodies, stances, held, moved_to, is_looped, .. } = self;
        let displacements = problem.displacements();
        if displacements.iter().flatten().any(|value| !value.is_finite()) || displacements.is_empty() {
            return;
        }
        for share in SHARES {
            moved_to.clone_from(stances);
            let mut next = 0;
            for (body, stance) in bodies.iter().zip(&mut *moved_to) {
                if body.is_dynamic() {
                    body.displace(stance, &rate_of(&displacements[next]), share);
                    next += 1;
                }
            }
            if !*is_looped || held.square_of_gaps(joints, moved_to) <= before {
                std::mem::swap(stances, moved_to);
                return;
            }
        }
    }
}
