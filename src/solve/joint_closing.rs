//! Further position sweeps at the end of a step, over joints whose error is still open.
//!
//! One sweep a substep closes what opens in chains that hang. What bends has no taut bound, and a sweep leaves it gaps. So rows are swept on,
//! in each island by itself: what has closed, or closes no more, stays as it is, whatever others in the batch do.

use super::body_flags::BodyFlags;
use super::joint::BatchJoints;
use super::plane::Planes;
use super::state::{BodyMotion, BodyVelocity};
use super::wide_bodies::WideBodies;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::tight_vec::resize;
use crate::workers::Workers;

/// Gaps of joints, as shares of their levers, for which position rows are swept on at the end of a step, and how often at most.
/// Chains keep their length to the lesser share; where joints are torn open further than the greater, a few sweeps close nothing.
const AJAR: std::ops::Range<f64> = 1.0e-4..1.0e-2;
const CLOSING_SWEEPS: u32 = 3;

/// Share of a gap that a sweep must leave at most for another to be worth while.
const WORTH_WHILE: f64 = 0.5;

/// Buffers.
#[derive(Debug, Default)]
pub(crate) struct JointClosing {
    /// Of each island: the widest gap as a share of its levers, before and after a sweep, and whether it is swept on.
    before: Vec<f64>,
    after: Vec<f64>,
    open: Vec<bool>,
    /// What a sweep starts from.
    velocities: Vec<BodyVelocity>,
    motions: Vec<BodyMotion>,
}

/// What is closed, of a batch.
pub(super) struct OpenJoints<'a> {
    pub joints: &'a mut BatchJoints,
    pub all: &'a Pool<Joint, JointId>,
    pub planes: &'a mut Planes,
    pub poses: &'a mut WideBodies,
    pub velocities: &'a mut Vec<BodyVelocity>,
    pub motions: &'a mut Vec<BodyMotion>,
    pub body_flags: &'a [BodyFlags],
    /// First slots of the islands, and the slot after the last that moves.
    pub islands: &'a [u32],
    pub end: usize,
}

impl JointClosing {
    /// Closes joints at the end of a step, whose substeps have the length `h` (s).
    pub(super) fn close(&mut self, open_joints: &mut OpenJoints, threads: &Workers, h: f32) {
        if open_joints.joints.entries.is_empty() {
            return;
        }
        open_joints.find_openings(&mut self.before);
        self.open.clear();
        self.open.extend(self.before.iter().map(|opening| AJAR.contains(opening)));
        for _ in 0..CLOSING_SWEEPS {
            if !self.open.contains(&true) {
                break;
            }
            self.sweep_open(open_joints, threads, h);
            open_joints.find_openings(&mut self.after);
            for ((open, before), &after) in self.open.iter_mut().zip(&mut self.before).zip(&self.after) {
                *open &= AJAR.contains(&after) && after <= WORTH_WHILE * *before;
                *before = after;
            }
        }
    }

    /// One sweep over position rows of joints, of the islands that are open.
    fn sweep_open(&mut self, open_joints: &mut OpenJoints, threads: &Workers, h: f32) {
        let all = !self.open.contains(&false);
        if !all {
            self.velocities.clone_from(open_joints.velocities);
            self.motions.clone_from(open_joints.motions);
        }
        open_joints.joints.project(open_joints.all, threads, open_joints.velocities, open_joints.motions, h);
        if !open_joints.planes.entries.is_empty() {
            open_joints.planes.project(open_joints.velocities, open_joints.motions, open_joints.poses);
        }
        if all {
            return;
        }
        for island in (0..open_joints.islands.len()).filter(|&island| !self.open[island]) {
            let end = open_joints.islands.get(island + 1).map_or(open_joints.end, |&next| next as usize);
            let slots = open_joints.islands[island] as usize..end;
            open_joints.velocities[slots.clone()].copy_from_slice(&self.velocities[slots.clone()]);
            open_joints.motions[slots.clone()].copy_from_slice(&self.motions[slots]);
        }
    }
}

impl OpenJoints<'_> {
    /// Greatest distance of points that a joint of each island holds together without give, as a share of its levers.
    fn find_openings(&self, openings: &mut Vec<f64>) {
        openings.clear();
        if self.islands.len() == 1 {
            openings.push(self.joints.opening(self.all, self.motions));
            return;
        }
        resize(openings, self.islands.len(), 0.0);
        self.joints.each_opening(self.all, self.motions, |slots, opening| {
            let own = slots.into_iter().find(|&slot| self.body_flags[slot as usize].moves());
            let island = own.and_then(|slot| self.islands.partition_point(|&first| first <= slot).checked_sub(1));
            if let Some(island) = island {
                openings[island] = f64::max(openings[island], opening);
            }
        });
    }
}
