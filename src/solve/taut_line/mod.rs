//! Joints on the path of a taut bound: they lie on the straight line between its ends.
//!
//! A joint at d from the bound's near end a and at e from its far end p, both along segments, is inside two balls. Seen from the
//! line, with D = |p − a|, they meet in a lens of radius ρ about the line:
//!
//! ```text
//! x = (D² + d² − e²) / 2D,    ρ² = d² − x²    (about 2 s d e / (d + e) where the slack s = d + e − D is small).
//! ```
//!
//! A bound that is taut to a micrometre leaves a joint a millimetre. The two balls are all but tangent there, so rows on the two
//! distances push along the line and hardly across; this row pushes across. With n = (p − a)/D, P the projection across n, and σ =
//! n·(q − a)/D where the joint is along the line,
//!
//! ```text
//! C = P(q − a),  |C| ≤ ρ,    Ċ = P(v_q − (1 − σ) v_a − σ v_p),
//! K = M⁻¹ seen at q + (1 − σ)² M⁻¹ seen at a + σ² M⁻¹ seen at p    (1/kg).
//! ```
//!
//! Forces f on q, −(1 − σ) f on a and −σ f on p sum to nothing, and turn nothing but by C × f.
//!
//! Nothing is carried from substep to substep: what acts across a taut line is small beside what acts along it.
//!
//! **Lanes.** Up to eight joints of one bound are solved at once. Each has a body of its own, but they share the two ends, which
//! answer to the sum. So that the sum cannot overshoot, each of n rows of a block sees the ends as n times lighter than they are
//! (mass splitting; Tonge, Benevolenski, Voroshilov 2012): K = M⁻¹ at q + n (1 − σ)² M⁻¹ at a + n σ² M⁻¹ at p.

use glam::{Mat3, Vec3};

use super::contact::{LANES, Lane, Lane3};
use super::distance_bound::{BatchBounds, BoundEntry, Pose32, now, then};
use super::integrate::{PredictedPose, skew};
use super::state::{BodyMotion, BodyVelocity};
use crate::platform::in_lanes;

mod rows;
mod sweep;

/// Lens beyond which a joint is left alone, as a share of the bound: rows are for what is all but straight.
const MAX_LENS: f32 = 0.05;

/// Way across the line in one substep, as a share of the distance from the near end, beyond which a joint is left to position rows:
/// velocity rows on joints that are thrown across the line put energy in (1:10,000, links at 10 m/s and 20 rad/s: speeds of
/// kilometres a second in 16 runs of 16; with this limit in none of 72).
const NEARLY_STRAIGHT: f32 = 1.0e-3;

/// Greatest displacement across the line in one substep, as a speed (m/s).
const MAX_RECOVERY_SPEED: f32 = 10.0;

/// A joint on the path of a bound, as its batch holds it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TautEntry {
    /// The joint's place in the world's list.
    pub inner: u32,
    /// The bound, by its place among the batch's entries.
    pub bound: u32,
    pub slot: u32,
    /// From the near body's origin to this body's at the start of the step (m).
    pub offset: Vec3,
    pub local_lever: Vec3,
    /// Length along segments to the near and to the far end (m).
    pub before: f32,
    pub after: f32,
    /// Sum over the substeps of the impulses on this body, and of those on the bound's far body (N·s).
    pub own_sum: Vec3,
    pub far_sum: Vec3,
}

/// Ends of a bound, the near one first.
#[derive(Debug, Clone, Copy)]
struct BoundEnds {
    slots: [u32; 2],
    /// From the near body's origin to the far one's, and the bound's points from there in the frames of the bodies (m).
    offset: Vec3,
    levers: [Vec3; 2],
}

/// Up to eight joints on the path of one bound.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct TautBlock {
    /// First of its entries, and how many.
    first: u32,
    count: u32,
    bound: u32,
    slots: [u32; LANES],
    ends: BoundEnds,
    offset: Lane3,
    local: Lane3,
    before: Lane,
    after: Lane,
    /// Whether there are rows in this substep.
    acts: bool,
    /// Along the line from near to far; levers of the bound's points and of the joints (m).
    along: Vec3,
    arm: [Vec3; 2],
    own_arm: Lane3,
    /// Share of the impulse that the far body gets, with its sign.
    far_share: Lane,
    mass: [Lane; 6],
    bias: Lane3,
    impulse: Lane3,
    /// Sums over the substeps of the impulses on the joints' bodies, and on the bound's far body.
    own_sum: Lane3,
    far_sum: Lane3,
}

impl TautBlock {
    fn new(first: u32, bound: u32, ends: &BoundEntry) -> Self {
        Self {
            first,
            count: 0,
            bound,
            slots: [0; LANES],
            ends: BoundEnds { slots: [ends.near, ends.far], offset: ends.offset, levers: ends.local_lever },
            offset: [[0.0; LANES]; 3],
            local: [[0.0; LANES]; 3],
            before: [0.0; LANES],
            after: [0.0; LANES],
            acts: false,
            along: Vec3::X,
            arm: [Vec3::ZERO; 2],
            own_arm: [[0.0; LANES]; 3],
            far_share: [0.0; LANES],
            mass: [[0.0; LANES]; 6],
            bias: [[0.0; LANES]; 3],
            impulse: [[0.0; LANES]; 3],
            own_sum: [[0.0; LANES]; 3],
            far_sum: [[0.0; LANES]; 3],
        }
    }

    fn add(&mut self, entry: &TautEntry) {
        let l = self.count as usize;
        self.slots[l] = entry.slot;
        for i in 0..3 {
            self.offset[i][l] = entry.offset[i];
            self.local[i][l] = entry.local_lever[i];
        }
        (self.before[l], self.after[l]) = (entry.before, entry.after);
        self.count += 1;
    }

    fn has_room_for(&self, slot: u32) -> bool {
        let taken = &self.slots[..self.count as usize];
        taken.len() < LANES && !taken.contains(&slot) && !self.ends.slots.contains(&slot)
    }

    /// The bound's line where its bodies are in these places.
    fn line(&self, pose_of: impl Fn(u32) -> Pose32) -> TautLine {
        let [near, far] = self.ends.slots.map(pose_of);
        let levers = [near.1 * self.ends.levers[0], far.1 * self.ends.levers[1]];
        let gap = self.ends.offset + (far.0 - near.0) + (levers[1] - levers[0]);
        let length = gap.length();
        TautLine { levers, near: near.0, along: gap / length, length }
    }
}

/// The line of a bound: levers of its ends, where the near body is, direction, and length (m).
#[derive(Debug, Clone, Copy)]
struct TautLine {
    levers: [Vec3; 2],
    near: Vec3,
    along: Vec3,
    length: f32,
}

/// M⁻¹ as a point at `lever` sees it (1/kg).
fn response_at(body: &BodyVelocity, lever: Vec3) -> Mat3 {
    let arm = skew(lever);
    Mat3::from_diagonal(body.inverse_mass) - arm * body.inverse_inertia.to_mat3() * arm
}

/// Rows of all taut bounds of a batch.
#[derive(Debug, Default)]
pub(crate) struct TautRows {
    pub entries: Vec<TautEntry>,
    blocks: Vec<TautBlock>,
}

impl TautRows {
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }

    /// Lays out lanes: joints of one bound, none of which is on the body of another, in blocks.
    pub(crate) fn lay_out(&mut self, bounds: &BatchBounds) {
        let Self { entries, blocks } = self;
        blocks.clear();
        for (number, entry) in entries.iter().enumerate() {
            let fits = |block: &TautBlock| block.bound == entry.bound && (block.has_room_for(entry.slot) || block.count == 0);
            if !blocks.last().is_some_and(fits) {
                blocks.push(TautBlock::new(number as u32, entry.bound, &bounds.entries[entry.bound as usize]));
            }
            if let Some(block) = blocks.last_mut() {
                block.add(entry);
            }
        }
    }

    /// Builds this substep's rows for the bounds that have rows themselves.
    pub(crate) fn prepare(
        &mut self,
        bounds: &BatchBounds,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        predicted_poses: &[PredictedPose],
        h: f32,
    ) {
        for block in &mut self.blocks {
            if bounds.is_taut(block.bound) {
                let end = block.line(|slot| then(predicted_poses, slot));
                let start = block.line(|slot| now(motions, slot));
                prepare_block(block, &start, &end, velocities, motions, predicted_poses, h);
            } else {
                block.acts = false;
            }
        }
    }

    /// One sweep over all rows.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity], backwards: bool) {
        if backwards {
            self.blocks.iter_mut().rev().filter(|block| block.acts).for_each(|block| sweep_block(block, velocities));
        } else {
            self.blocks.iter_mut().filter(|block| block.acts).for_each(|block| sweep_block(block, velocities));
        }
    }

    /// Sets the multipliers of rows on bounds between these slots to nothing.
    pub(crate) fn give_up(&mut self, slots: &[bool]) {
        for block in self.blocks.iter_mut().filter(|block| block.ends.slots.iter().any(|&slot| slots[slot as usize])) {
            block.impulse = [[0.0; LANES]; 3];
        }
    }

    /// Adds the substep's multipliers to the loads.
    pub(crate) fn add_loads(&mut self) {
        for block in self.blocks.iter_mut().filter(|block| block.acts) {
            for i in 0..3 {
                for l in 0..LANES {
                    block.own_sum[i][l] += block.impulse[i][l];
                    block.far_sum[i][l] += block.impulse[i][l] * block.far_share[l];
                }
            }
        }
    }

    /// One sweep of position rows over the bounds that had rows in this substep, at the poses of now.
    pub(crate) fn project(&self, bounds: &BatchBounds, velocities: &[BodyVelocity], motions: &mut [BodyMotion], h: f32) {
        for block in self.blocks.iter().filter(|block| bounds.is_taut(block.bound)) {
            let line = block.line(|slot| now(motions, slot));
            project_block(block, &line, velocities, motions, MAX_RECOVERY_SPEED * h);
        }
    }

    /// Hands loads back to the entries.
    pub(crate) fn store(&mut self) {
        for block in &self.blocks {
            let first = block.first as usize;
            for (l, entry) in self.entries[first..first + block.count as usize].iter_mut().enumerate() {
                entry.own_sum = Vec3::from_array(std::array::from_fn(|i| block.own_sum[i][l]));
                entry.far_sum = Vec3::from_array(std::array::from_fn(|i| block.far_sum[i][l]));
            }
        }
    }
}

in_lanes!(
    prepare_block, rows::prepare,
    (
        block: &mut TautBlock, start: &TautLine, end: &TautLine, velocities: &[BodyVelocity], motions: &[BodyMotion],
        predicted_poses: &[PredictedPose], h: f32
    )
);
in_lanes!(sweep_block, sweep::sweep, (block: &mut TautBlock, velocities: &mut [BodyVelocity]));
in_lanes!(
    project_block, sweep::project,
    (block: &TautBlock, line: &TautLine, velocities: &[BodyVelocity], motions: &mut [BodyMotion], most: f32)
);
