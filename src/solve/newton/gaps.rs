//! Position correction of an island: closes the gaps of its joints and removes the overlaps of its contacts.

use super::held::{Ends, Gaps, rate_of};
use super::island::CoupledIsland;
use super::patch::Patch;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::tuning::gaping_loops::{MENDED, STUCK};

/// Shares of what takes errors out of positions that are tried, one after the other.
const SHARES: [f64; 3] = [1.0, 0.3, 0.09];

/// Gap of a joint above which a substep corrects positions again, over the mean distance of joint points from centres of mass. The arms of
/// what swings are off by 1e-5 of it; the light links of a rope that snaps taut under tonnes turn by 0.2 rad in a substep, and one correction
/// leaves 3e-3, which grows from step to step.
const MIN_GAP: f64 = 1.0e-4;

/// Corrections with rows and a factor of where bodies have moved to, at most. Each leaves about the square of what it finds: two are enough for
/// ropes of 0.2 kg a link under 37 kg to 60 t, at 30 to 240 Hz.
const MAX_CLOSINGS: usize = 4;

impl CoupledIsland {
    /// Takes errors of joints and overlaps out of the positions that bodies have moved to in a substep of length `h` (s), `left` (s) from the end
    /// of the step: with the factor of the substep, and while a gap is left that matters, with rows and a factor of where the bodies are now.
    /// Greatest gap that is left (m).
    pub(super) fn close_gaps(&mut self, joints: &Pool<Joint, JointId>, h: f64, left: f64) -> f64 {
        let mut before = if self.is_looped { self.held.gaps(joints, &self.local_poses).squares } else { f64::INFINITY };
        let mut corrected = self.correct(joints, h, left, before);
        for _ in 0..MAX_CLOSINGS {
            let gaps = corrected.unwrap_or_else(|| self.held.gaps(joints, &self.local_poses));
            if gaps.greatest <= MIN_GAP * self.held.mean_lever(&self.bodies) {
                return gaps.greatest;
            }
            let last = before;
            before = gaps.squares;
            if self.is_looped && before > STUCK * last {
                return gaps.greatest;
            }
            self.follow_rows(joints, h, left);
            corrected = self.correct(joints, h, left, before);
            if corrected.is_none() {
                return gaps.greatest;
            }
        }
        corrected.map_or(0.0, |gaps| gaps.greatest)
    }

    /// Takes errors of joints and overlaps out of positions: all of them, or as much as leaves no more than half of what it takes by turning
    /// bodies too far. A line of links that is all but straight gives way to its sides only, and that by more the straighter it is. No more
    /// is taken than leaves the sum of the squares of gaps at `before` or less: a loop that stands all but straight folds its light links
    /// where it should straighten. In a loop in which nothing presses, bodies may turn further if that leaves next to nothing. The
    /// gaps that are left; none if nothing could be taken.
    fn correct(&mut self, joints: &Pool<Joint, JointId>, h: f64, left: f64, before: f64) -> Option<Gaps> {
        let lever = self.held.mean_lever(&self.bodies);
        let Self { problem, bodies, moved, rates, local_poses, held, moved_to, patches, is_looped, .. } = self;
        let worst = held.find_errors(joints, problem, Ends { bodies, moved, rates, local_poses }, h, left);
        problem.find_displacements();
        let displacements = problem.displacements();
        if displacements.iter().flatten().any(|value| !value.is_finite()) || displacements.is_empty() {
            return None;
        }
        // In a loop only joints decide: what pushes it further out of an overlap opens it.
        let worst = if *is_looped { worst } else { worst.max(problem.deepest_push()) };
        let turn = displacements.iter().map(|way| rate_of(way).angular.length_squared()).fold(0.0, f64::max);
        let most = if worst < lever * turn { worst / (lever * turn) } else { 1.0 };
        let may_turn = *is_looped && !patches.iter().any(Patch::presses);
        let further =
            [1.0, most.sqrt()].into_iter().filter(|&share| may_turn && share > most).map(|share| (share, MENDED * before));
        for (share, bound) in further.chain(SHARES.map(|share| (share * most, before))) {
            moved_to.clone_from(local_poses);
            let moving = bodies.iter().zip(&mut *moved_to).filter(|(body, _)| body.is_dynamic());
            for ((body, stance), way) in moving.zip(displacements) {
                body.displace(stance, &rate_of(way), share);
            }
            let gaps = held.gaps(joints, moved_to);
            if before == f64::INFINITY || gaps.squares < bound {
                std::mem::swap(local_poses, moved_to);
                return Some(gaps);
            }
        }
        None
    }

    /// Brings rows that always hold to where bodies are.
    fn follow_rows(&mut self, joints: &Pool<Joint, JointId>, h: f64, left: f64) {
        let Self { problem, bodies, moved, rates, local_poses, held, .. } = self;
        held.follow_rows(joints, problem, Ends { bodies, moved, rates, local_poses }, h, left);
    }
}
