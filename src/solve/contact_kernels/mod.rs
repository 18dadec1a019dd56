//! The loops over contact blocks: effective masses, warm start, sweep, restitution, position recovery.
//!
//! Every kernel gathers the bodies of eight manifolds into lanes, computes one manifold a lane, and scatters the result. Kernels
//! are generic over [`Wide`] and compiled twice on x86-64, for registers of AVX2 and of SSE2; both give the same bits.

mod masses;
mod recover;
mod rows;
mod sweep;
mod tell;
#[cfg(test)]
mod tests;
mod warm_start;

use super::contact::LANES;
use super::contact_block::{BlockView, ContactBlocks};
use super::contact_partition::BlockPart;
use super::disjoint::DisjointMut;
use super::state::{BodyMotion, BodyVelocity};
use super::status::{ContactStatus, StatusThresholds};
use crate::platform::in_lanes;

pub(crate) use recover::{RECOVERY_SWEEPS, asked_by_recovery};

in_lanes!(
    /// Forms the effective masses of a block from the bodies' inertia of now.
    pub(crate) set_masses, masses::set, (whole: &mut BlockView<'_>, velocities: &[BodyVelocity])
);
in_lanes!(
    /// Applies the carried multipliers and forms the closing speeds of this substep.
    ///
    /// The velocities have the substep's forces in them already; the middle of the substep is so much (s) after the time that levers are
    /// of.
    pub(crate) warm_start, warm_start::all,
    (part: &mut BlockPart<'_>, velocities: &mut DisjointMut<'_, BodyVelocity>, motions: &[BodyMotion], h: f32, middle: f32)
);
in_lanes!(
    /// One sweep: the normal rows of each manifold as a block, and its friction before or after them.
    pub(crate) sweep, sweep::all,
    (part: &mut BlockPart<'_>, velocities: &mut DisjointMut<'_, BodyVelocity>, backwards: bool, presses_last: bool)
);
in_lanes!(
    /// One sweep from velocities that have the carried multipliers in them, of blocks without extras: forms the closing speeds of this
    /// substep first.
    pub(crate) sweep_anew, sweep::anew,
    (part: &mut BlockPart<'_>, velocities: &mut DisjointMut<'_, BodyVelocity>, motions: &[BodyMotion], h: f32, presses_last: bool)
);
in_lanes!(
    /// After a substep: points that hit something at more than `threshold` (m/s) leave at the rebound speed.
    pub(crate) restitute, recover::restitute,
    (contacts: &mut ContactBlocks, velocities: &mut [BodyVelocity], threshold: f32)
);
in_lanes!(
    /// Brings the separations to the end of the step and makes room for multipliers of [`recover`]; says the greatest overlap of any
    /// point (m).
    pub(crate) end_step, recover::end_step, (part: &mut BlockPart<'_>, motions: &[BodyMotion]) -> f32
);
in_lanes!(
    /// [`end_step`] and a first sweep of [`recover`] in one.
    pub(crate) begin_recovery, recover::begin,
    (part: &mut BlockPart<'_>, motions: &[BodyMotion], pushes: &mut DisjointMut<'_, BodyVelocity>, dt: f32) -> f32
);
in_lanes!(
    /// Adds to `told` what the step has made of the manifolds of each block.
    pub(crate) tell, tell::all,
    (contacts: &mut ContactBlocks, velocities: &[BodyVelocity], limits: &StatusThresholds, told: &mut Vec<[ContactStatus; LANES]>)
);
in_lanes!(
    /// One sweep of position recovery: overlapping points are pushed apart by displacements that leave no velocity behind.
    ///
    /// `pushes` holds a displacement and rotation for each slot in the form of a velocity times the step. Rows are
    /// J δ ≥ −β s where s < 0 (never faster than [`MAX_RECOVERY_SPEED`](recover::MAX_RECOVERY_SPEED)) and J δ ≥ −s elsewhere, so
    /// that one overlap is not cured by making another; s is that of [`end_step`].
    pub(crate) recover, recover::all,
    (part: &mut BlockPart<'_>, pushes: &mut DisjointMut<'_, BodyVelocity>, dt: f32)
);
