//! Warm start by body: the velocity change of its contacts, kept from substep to substep.
//!
//! A substep begins with the multipliers λ of the last one: v ← v + M⁻¹ Jᵀ λ. Normals and levers are those of the step, and so is J; so from
//! the second substep on that sum is what contacts have changed of the velocities in the last one,
//!
//! ```text
//! M⁻¹ Jᵀ λ = δ,    δ = v(after the sweeps) − v(before the carried multipliers),
//! ```
//!
//! to rounding, where nothing but contacts acts between the two. Kept by body it is 24 bytes of each, instead of all that blocks of contacts
//! have, and spares a walk over them in three of four substeps. Where the inertia I of a body is formed anew, what its contacts give it is
//! still Jᵀ λ, and so
//!
//! ```text
//! δω ← I'⁻¹ I δω.
//! ```

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use super::batch::Batch;
use super::integrate;
use super::state::{BodyMotion, BodyVelocity, Symmetric};
use crate::step_history::Twist;
use crate::tight_vec::resize;
use crate::workers::Workers;

/// Bodies that are worth another thread's while.
const MIN_SHARED: usize = 128;

/// What contacts have changed of the velocity of each slot in the last substep; while one is solved, the velocities before it.
#[derive(Debug, Default)]
pub(crate) struct BodyWarmStart {
    is_on: bool,
    changes: Vec<Twist>,
}

impl BodyWarmStart {
    /// Whether bodies carry what their contacts do.
    pub(crate) fn is_on(&self) -> bool {
        self.is_on
    }

    /// Finds whether contacts alone act on the bodies of this batch, and all multipliers are carried on as they are: `sweeps_alone` says that no
    /// other stage changes those of contacts in substeps of length `h` (s). What is smeared is seen otherwise in each substep.
    pub(super) fn prepare(&mut self, batch: &Batch, sweeps_alone: bool, h: f32) {
        self.is_on = batch.may_carry_changes()
            && !batch.contacts.is_empty()
            && batch.contacts.extras.is_empty()
            && batch.joints.slots.is_empty()
            && batch.long_range.slots.is_empty()
            && batch.free.is_empty()
            && sweeps_alone
            && batch.body_flags.iter().all(|role| !role.moves() || role.is_unlocked())
            && !batch.velocities.iter().zip(&batch.motions).any(|(velocity, motion)| integrate::is_smeared(velocity, motion, h));
        if self.is_on {
            resize(&mut self.changes, batch.velocities.len(), Twist::default());
        }
    }

    /// Adds a substep's forces and, but in the first substep, what contacts have changed in the last one; says whether the inertia of any body
    /// has been formed anew.
    pub(super) fn apply_forces(&mut self, batch: &mut Batch, threads: &Workers, h: f32, is_first: bool) -> bool {
        let Batch { velocities, motions, .. } = batch;
        let refreshes = AtomicBool::new(false);
        let begin = |velocity: &mut BodyVelocity, motion: &mut BodyMotion, change: &mut Twist| {
            let before = velocity.inverse_inertia;
            integrate::apply_forces(velocity, motion, h);
            integrate::limit_speeds(velocity, motion);
            let [linear, angular] = std::mem::replace(change, [velocity.linear, velocity.angular]);
            if motion.world_inertia.refreshed {
                refreshes.store(true, Ordering::Relaxed);
            }
            if !is_first {
                let now = &velocity.inverse_inertia;
                let angular = if motion.world_inertia.refreshed { after_refresh(&before, now, angular) } else { angular };
                velocity.linear += linear;
                velocity.angular += angular;
            }
        };
        let piece = threads.piece(motions.len(), MIN_SHARED);
        let pieces = velocities.chunks_mut(piece).zip(motions.chunks_mut(piece)).zip(self.changes.chunks_mut(piece));
        threads.share(pieces, |((velocities, motions), changes)| {
            for ((velocity, motion), change) in velocities.iter_mut().zip(motions).zip(changes) {
                begin(velocity, motion, change);
            }
        });
        refreshes.into_inner()
    }

    /// Keeps what contacts have changed of velocities in this substep.
    pub(super) fn keep_changes(&mut self, velocities: &[BodyVelocity], threads: &Workers) {
        let piece = threads.piece(velocities.len(), MIN_SHARED);
        threads.share(velocities.chunks(piece).zip(self.changes.chunks_mut(piece)), |(velocities, changes)| {
            for (velocity, change) in velocities.iter().zip(changes) {
                *change = [velocity.linear - change[0], velocity.angular - change[1]];
            }
        });
    }
}

/// Change of angular velocity by the same angular momentum.
fn after_refresh(before: &Symmetric, now: &Symmetric, change: Vec3) -> Vec3 {
    let momentum = before.to_mat3().as_dmat3().inverse() * change.as_dvec3();
    now.mul(momentum.as_vec3())
}
