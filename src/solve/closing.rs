//! Last position sweeps of a step over joints that are left ajar.
//!
//! One sweep a substep closes what opens in chains that hang. What bends has no taut bound, and a sweep leaves it gaps. So rows are swept on,
//! in each island by itself: what has closed, or closes no more, stays as it is, whatever others in the batch do.

use super::joint::BatchJoints;
use super::plane::Planes;
use super::poses::Poses;
use super::role::Role;
use super::state::{BodyMotion, BodyVelocity};
use crate::id::{JointId, Pool};
use crate::joint::Joint;
use crate::room::resize;
use crate::workers::Workers;

/// Gaps of joints, as shares of their levers, for which position rows are swept on at the end of a step, and how often at most.
/// Chains keep their length to the lesser share; where joints are torn open further than the greater, a few sweeps close nothing.
const AJAR: std::ops::Range<f64> = 1.0e-4..1.0e-2;
const CLOSING_SWEEPS: u32 = 3;

/// Share of a gap that a sweep must leave at most for another to be worth while.
const WORTH_WHILE: f64 = 0.5;

/// Buffers.
#[derive(Debug, Default)]
pub(crate) struct Closing {
    /// Of each island: the widest gap as a share of its levers, before and after a sweep, and whether it is swept on.
    before: Vec<f64>,
    after: Vec<f64>,
    open: Vec<bool>,
    /// What a sweep starts from.
    velocities: Vec<BodyVelocity>,
    motions: Vec<BodyMotion>,
}

/// What is closed, of a batch.
pub(super) struct Ajar<'a> {
    pub joints: &'a mut BatchJoints,
    pub all: &'a Pool<Joint, JointId>,
    pub planes: &'a mut Planes,
    pub poses: &'a mut Poses,
    pub velocities: &'a mut Vec<BodyVelocity>,
    pub motions: &'a mut Vec<BodyMotion>,
    pub roles: &'a [Role],
    /// First slots of the islands, and the slot after the last that moves.
    pub islands: &'a [u32],
    pub end: usize,
}

impl Closing {
    /// Closes joints at the end of a step, whose substeps have the length `h` (s).
    pub(super) fn close(&mut self, ajar: &mut Ajar, threads: &Workers, h: f32) {
        if ajar.joints.entries.is_empty() {
            return;
        }
        ajar.find_openings(&mut self.before);
        self.open.clear();
        self.open.extend(self.before.iter().map(|opening| AJAR.contains(opening)));
        for _ in 0..CLOSING_SWEEPS {
            if !self.open.contains(&true) {
                break;
            }
            self.sweep_open(ajar, threads, h);
            ajar.find_openings(&mut self.after);
            for ((open, before), &after) in self.open.iter_mut().zip(&mut self.before).zip(&self.after) {
                *open &= AJAR.contains(&after) && after <= WORTH_WHILE * *before;
                *before = after;
            }
        }
    }

    /// One sweep over position rows of joints, of the islands that are open.
    fn sweep_open(&mut self, ajar: &mut Ajar, threads: &Workers, h: f32) {
        let all = !self.open.contains(&false);
        if !all {
            self.velocities.clone_from(ajar.velocities);
            self.motions.clone_from(ajar.motions);
        }
        ajar.joints.project(ajar.all, threads, ajar.velocities, ajar.motions, h);
        if !ajar.planes.entries.is_empty() {
            ajar.planes.project(ajar.velocities, ajar.motions, ajar.poses);
        }
        if all {
            return;
        }
        for island in (0..ajar.islands.len()).filter(|&island| !self.open[island]) {
            let end = ajar.islands.get(island + 1).map_or(ajar.end, |&next| next as usize);
            let slots = ajar.islands[island] as usize..end;
            ajar.velocities[slots.clone()].copy_from_slice(&self.velocities[slots.clone()]);
            ajar.motions[slots.clone()].copy_from_slice(&self.motions[slots]);
        }
    }
}

impl Ajar<'_> {
    /// Greatest distance of points that a joint of each island holds together without give, as a share of its levers.
    fn find_openings(&self, openings: &mut Vec<f64>) {
        openings.clear();
        if self.islands.len() == 1 {
            openings.push(self.joints.opening(self.all, self.motions));
            return;
        }
        resize(openings, self.islands.len(), 0.0);
        self.joints.each_opening(self.all, self.motions, |slots, opening| {
            let own = slots.into_iter().find(|&slot| self.roles[slot as usize].moves());
            let island = own.and_then(|slot| self.islands.partition_point(|&first| first <= slot).checked_sub(1));
            if let Some(island) = island {
                openings[island] = f64::max(openings[island], opening);
            }
        });
    }
}
