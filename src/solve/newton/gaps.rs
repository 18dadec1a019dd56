//! Gaps of an island's joints, and overlaps of its contacts, taken out of its positions.

use super::held::Ends;
use super::island::{CoupledIsland, rate_of};
use crate::id::{JointId, Pool};
use crate::joint::Joint;

/// Shares of what takes errors out of the positions of a loop that are tried, one after the other.
const SHARES: [f64; 3] = [1.0, 0.3, 0.09];

impl CoupledIsland {
    /// Takes errors of joints and overlaps out of the positions that bodies have moved to in a substep of length `h` (s), `left` (s) from the end
    /// of the step: all of them, or as much as leaves no more than half of what it takes by turning bodies too far. A line of links that is
    /// all but straight gives way to its sides only, and that by more the straighter it is. Of joints that close a loop no more is taken
    /// than makes their gaps less: a loop that stands all but straight folds its light links where it should straighten.
    pub(super) fn close_gaps(&mut self, joints: &Pool<Joint, JointId>, h: f64, left: f64) {
        let lever = self.held.mean_lever();
        let before = if self.is_looped { self.held.square_of_gaps(joints, &self.local_poses) } else { f64::INFINITY };
        let Self { problem, bodies, moved, rates, local_poses, held, moved_to, is_looped, .. } = self;
        let worst = held.find_errors(joints, problem, Ends { bodies, moved, rates, local_poses }, h, left);
        problem.find_displacements();
        let displacements = problem.displacements();
        if displacements.iter().flatten().any(|value| !value.is_finite()) || displacements.is_empty() {
            return;
        }
        let turn = displacements.iter().map(|way| rate_of(way).angular.length_squared()).fold(0.0, f64::max);
        let most = if worst < lever * turn { worst / (lever * turn) } else { 1.0 };
        for share in SHARES {
            moved_to.clone_from(local_poses);
            let moving = bodies.iter().zip(&mut *moved_to).filter(|(body, _)| body.is_dynamic());
            for ((body, stance), way) in moving.zip(displacements) {
                body.displace(stance, &rate_of(way), share * most);
            }
            if !*is_looped || held.square_of_gaps(joints, moved_to) <= before {
                std::mem::swap(local_poses, moved_to);
                return;
            }
        }
    }
}
