//! Long-range bounds of a batch: rows on the distance of two joint points far apart (Müller et al. 2017, §3.1–3.3).
//!
//! With near point a, far point p, gap g = p − a and n = g/|g|,
//!
//! ```text
//! upper:  C = D − |g| ≥ 0,  J = [n, r_a×n, −n, −r_p×n],        lower:  C = |g| − L ≥ 0,  J negated;
//! w = J M⁻¹ Jᵀ = 1/m_a + (r_a×n)·I_a⁻¹(r_a×n) + 1/m_p + (r_p×n)·I_p⁻¹(r_p×n)   (1/kg; an attachment adds nothing).
//! ```
//!
//! The rows are those of a joint's stop: a velocity row for what this substep does to C, with a multiplier λ ≥ 0 (N·s) carried from
//! substep to substep, and a position row for the error that is left. Rigid rows never pull a bound that is slack, so no energy
//! comes from them; soft ones are springs of their compliance. A bound that is slack at the predicted poses has no row.
//!
//! **Order and lanes.** Rows go from the longest bounds to the shortest, since what is coarse must be right before what is fine.
//! Eight that share no moving body stand in one block; a bound stands in the first block with room after all blocks of earlier
//! bounds on its bodies. So any two rows of one body are solved in their order, and the result is that of one row after another.

use glam::{Quat, Vec3};

use super::contact::{LANES, Lane, Lane3};
use super::integrate::PredictedPose;
use super::state::{BodyMotion, BodyVelocity};
use crate::joint::Softness;
use crate::platform::in_lanes;

mod project;
mod rows;
mod sweep;

/// A bound as its batch holds it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundEntry {
    /// The world's number for it.
    pub bound: u32,
    pub near: u32,
    pub far: u32,
    /// From the near body's origin to the far one's at the start of the step (m).
    pub offset: Vec3,
    /// Joint points from the origins, in the bodies' frames (m).
    pub local_lever: [Vec3; 2],
    /// Greatest and least distance (m).
    pub upper: f32,
    pub lower: f32,
    pub upper_give: Softness,
    pub lower_give: Softness,
    /// Multipliers of the upper and the lower row (N·s), ≥ 0.
    pub impulses: [f32; 2],
    /// Sum over the substeps of the impulses on the far body (N·s).
    pub far_sum: Vec3,
    /// Whether any row of it was there in any substep.
    pub acted: bool,
}

impl BoundEntry {
    /// Whether any of its rows is a spring.
    pub(crate) fn has_give(&self) -> bool {
        self.upper_give.compliance > 0.0 || (self.lower > 0.0 && self.lower_give.compliance > 0.0)
    }
}

/// Gap at a share of the bound's length below it that already makes a row: others may close it within the sweeps.
const READY_SHARE: f32 = 1.0e-4;

/// The upper or the lower rows of eight bounds.
#[derive(Debug, Clone, Copy)]
struct Rows {
    /// Compliance over h², and the share of the bias that acts: see [`super::joint::rows`].
    gamma: Lane,
    damped: Lane,
    /// 1 where there is no compliance, and where a row is there in this substep.
    rigid: Lane,
    present: Lane,
    /// Whether any row is there, and whether any may ever be.
    any: bool,
    used: bool,
    mass: Lane,
    bias: Lane,
    impulse: Lane,
}

impl Rows {
    const EMPTY: Self = Self {
        gamma: [0.0; LANES],
        damped: [1.0; LANES],
        rigid: [1.0; LANES],
        present: [0.0; LANES],
        any: false,
        used: false,
        mass: [0.0; LANES],
        bias: [0.0; LANES],
        impulse: [0.0; LANES],
    };

    fn set(&mut self, l: usize, give: Softness, impulse: f32, h: f32) {
        self.damped[l] = 1.0 / (1.0 + give.damping * give.compliance / h);
        self.gamma[l] = give.compliance / (h * h) * self.damped[l];
        self.rigid[l] = f32::from(u8::from(give.compliance == 0.0));
        self.impulse[l] = impulse;
        self.used = true;
    }
}

/// Eight bounds that share no moving body; unused lanes act on the world slot and are always slack.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct BoundBlock {
    near: [u32; LANES],
    far: [u32; LANES],
    count: u32,
    offset: Lane3,
    local: [Lane3; 2],
    upper: Lane,
    lower: Lane,
    /// Squared distance (m²) above which there is an upper row, and below which there is a lower one.
    ready: Lane,
    near_lower: Lane,
    /// Unit vector from near to far where the gradient is taken, and its moments about the centres of mass (m).
    along: Lane3,
    arm: [Lane3; 2],
    upper_rows: Rows,
    lower_rows: Rows,
    far_sum: Lane3,
    /// 1 where any row was there in any substep.
    acted: Lane,
}

impl BoundBlock {
    const EMPTY: Self = Self {
        near: [0; LANES],
        far: [0; LANES],
        count: 0,
        offset: [[0.0; LANES]; 3],
        local: [[[0.0; LANES]; 3]; 2],
        upper: [f32::INFINITY; LANES],
        lower: [0.0; LANES],
        ready: [f32::INFINITY; LANES],
        near_lower: [-1.0; LANES],
        along: [[0.0; LANES]; 3],
        arm: [[[0.0; LANES]; 3]; 2],
        upper_rows: Rows::EMPTY,
        lower_rows: Rows::EMPTY,
        far_sum: [[0.0; LANES]; 3],
        acted: [0.0; LANES],
    };

    fn set(&mut self, l: usize, entry: &BoundEntry, h: f32) {
        (self.near[l], self.far[l]) = (entry.near, entry.far);
        put(&mut self.offset, l, entry.offset);
        for (lanes, lever) in self.local.iter_mut().zip(entry.local_lever) {
            put(lanes, l, lever);
        }
        let ready = entry.upper * (1.0 - READY_SHARE);
        (self.upper[l], self.ready[l]) = (entry.upper, ready * ready);
        self.upper_rows.set(l, entry.upper_give, entry.impulses[0], h);
        if entry.lower > 0.0 {
            (self.lower[l], self.near_lower[l]) = (entry.lower, entry.lower * entry.lower);
            self.lower_rows.set(l, entry.lower_give, entry.impulses[1], h);
        }
    }

    /// Whether any row is there in this substep.
    fn is_taut(&self) -> bool {
        self.upper_rows.any || self.lower_rows.any
    }
}

fn put(lanes: &mut Lane3, l: usize, v: Vec3) {
    [lanes[0][l], lanes[1][l], lanes[2][l]] = v.to_array();
}

/// All bounds of a batch.
#[derive(Debug, Default)]
pub(crate) struct BatchBounds {
    pub entries: Vec<BoundEntry>,
    blocks: Vec<BoundBlock>,
    /// Block and lane of each entry.
    places: Vec<(u32, u32)>,
    /// First block that may take another bound of each slot.
    next: Vec<u32>,
    /// A block no earlier than each that may have room: itself if it has.
    after: Vec<u32>,
    /// Bounds that are no entries, because they are too slack to close within the step.
    pub skipped: u32,
}

/// First block with room from this one on; paths that led there are shortened.
fn with_room(after: &mut [u32], mut block: u32) -> u32 {
    while (block as usize) < after.len() && after[block as usize] != block {
        let next = after[block as usize];
        if let Some(&further) = after.get(next as usize) {
            after[block as usize] = further;
        }
        block = next;
    }
    block
}

impl BatchBounds {
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
        self.skipped = 0;
    }

    /// Lays out lanes for substeps of length `h`.
    pub(crate) fn lay_out(&mut self, motions: &[BodyMotion], h: f32) {
        let Self { entries, blocks, places, next, after, .. } = self;
        blocks.clear();
        places.clear();
        if entries.is_empty() {
            return;
        }
        next.clear();
        next.resize(motions.len(), 0);
        after.clear();
        for entry in entries.iter() {
            let ends = [entry.near, entry.far].map(|slot| slot as usize).into_iter().filter(|&slot| motions[slot].is_dynamic());
            let earliest = ends.clone().map(|slot| next[slot]).fold(0, u32::max);
            let block = with_room(after, earliest);
            if block as usize == blocks.len() {
                blocks.push(BoundBlock::EMPTY);
                after.push(block);
            }
            let lanes = &mut blocks[block as usize];
            lanes.set(lanes.count as usize, entry, h);
            places.push((block, lanes.count));
            lanes.count += 1;
            if lanes.count as usize == LANES {
                after[block as usize] = block + 1;
            }
            ends.for_each(|slot| next[slot] = block + 1);
        }
    }

    /// Whether the upper row of an entry is there in this substep.
    pub(crate) fn is_taut(&self, entry: u32) -> bool {
        let (block, lane) = self.places[entry as usize];
        self.blocks[block as usize].upper_rows.present[lane as usize] > 0.0
    }

    /// Builds this substep's rows; `predicted_poses` hold the poses that the velocities of now lead to, and `applied` says whether
    /// carried multipliers are in those velocities already.
    pub(crate) fn prepare(
        &mut self,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        predicted_poses: &[PredictedPose],
        h: f32,
        applied: bool,
    ) {
        if !self.blocks.is_empty() {
            prepare_all(&mut self.blocks, velocities, motions, predicted_poses, h, applied);
        }
    }

    /// Applies the carried multipliers.
    pub(crate) fn warm_start(&self, velocities: &mut [BodyVelocity]) {
        warm_start_all(&self.blocks, velocities);
    }

    /// One sweep over all rows, from the longest bounds to the shortest or back.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity], backwards: bool) {
        sweep_all(&mut self.blocks, velocities, backwards);
    }

    /// Sets the multipliers of bounds on these slots to nothing.
    pub(crate) fn give_up(&mut self, slots: &[bool]) {
        for block in &mut self.blocks {
            for l in (0..LANES).filter(|&l| slots[block.near[l] as usize] || slots[block.far[l] as usize]) {
                (block.upper_rows.impulse[l], block.lower_rows.impulse[l]) = (0.0, 0.0);
            }
        }
    }

    /// Adds the substep's multipliers to the bounds' loads.
    pub(crate) fn add_loads(&mut self) {
        for block in self.blocks.iter_mut().filter(|block| block.is_taut()) {
            for (sum, along) in block.far_sum.iter_mut().zip(&block.along) {
                for l in 0..LANES {
                    sum[l] += along[l] * (block.lower_rows.impulse[l] - block.upper_rows.impulse[l]);
                }
            }
        }
    }

    /// One sweep of position rows over the rigid bounds that acted in this substep, at the poses of now.
    pub(crate) fn project(&self, velocities: &[BodyVelocity], motions: &mut [BodyMotion], h: f32) {
        project_all(&self.blocks, velocities, motions, project::MAX_RECOVERY_SPEED * h);
    }

    /// Hands multipliers and loads back to the entries.
    pub(crate) fn store(&mut self) {
        for (entry, &(block, lane)) in self.entries.iter_mut().zip(&self.places) {
            let (block, l) = (&self.blocks[block as usize], lane as usize);
            entry.impulses = [block.upper_rows.impulse[l], block.lower_rows.impulse[l]];
            entry.far_sum = Vec3::new(block.far_sum[0][l], block.far_sum[1][l], block.far_sum[2][l]);
            entry.acted = block.acted[l] > 0.0;
        }
    }
}

in_lanes!(
    prepare_all, rows::prepare,
    (blocks: &mut [BoundBlock], velocities: &[BodyVelocity], motions: &[BodyMotion], predicted_poses: &[PredictedPose], h: f32, applied: bool)
);
in_lanes!(warm_start_all, sweep::warm_start, (blocks: &[BoundBlock], velocities: &mut [BodyVelocity]));
in_lanes!(sweep_all, sweep::sweep, (blocks: &mut [BoundBlock], velocities: &mut [BodyVelocity], backwards: bool));
in_lanes!(
    project_all, project::project,
    (blocks: &[BoundBlock], velocities: &[BodyVelocity], motions: &mut [BodyMotion], most: f32)
);

/// Where a body is: its displacement since the start of the step (m) and its rotation.
pub(crate) type Pose32 = (Vec3, Quat);

pub(crate) fn now(motions: &[BodyMotion], slot: u32) -> Pose32 {
    (motions[slot as usize].displacement, motions[slot as usize].rotation)
}

pub(crate) fn then(predicted_poses: &[PredictedPose], slot: u32) -> Pose32 {
    (predicted_poses[slot as usize].displacement, predicted_poses[slot as usize].rotation)
}
