//! Position recovery: removes overlaps after the substeps, by displacements that leave no velocity behind.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::Quat;

use super::batch::Batch;
use super::contact_newton::ContactNewton;
use super::direct::SolveContext;
use super::state::{BodyMotion, BodyVelocity, MotionKind};
use super::wide_bodies::TURNING_LET_BE;
use super::{contact_kernels, parallel_contacts};
use crate::tight_vec::make_room;
use crate::workers::Workers;

/// Overlap below which position recovery has nothing to do (m).
pub(super) const NEGLIGIBLE_OVERLAP: f32 = 1.0e-6;

/// Blocks of contacts from which on position recovery begins as the greatest overlap is looked for, since going through them twice takes
/// longer than a sweep that may be in vain.
const LONG_LIST: usize = 64;

/// Bodies that are worth another thread's while where pushes move them.
const SHARED_BODIES: usize = 512;

/// Further sweeps of position recovery over contacts of jointed bodies.
const JOINTED_RECOVERY_SWEEPS: usize = 1;

/// What position recovery moves bodies by, by slot.
#[derive(Debug, Default)]
pub(super) struct Recovery {
    pushes: Vec<BodyVelocity>,
}

impl Recovery {
    /// Takes overlaps out of the positions of a batch.
    pub(super) fn recover_positions(&mut self, batch: &mut Batch, newton: &mut ContactNewton, threads: &Workers, dt: f32) {
        let begins_at_once = batch.contacts.len() >= LONG_LIST;
        let deepest = if begins_at_once {
            self.begin_pushes(batch);
            self.begin_recovery(batch, threads, dt)
        } else {
            contact_kernels::end_step(&mut batch.contacts.all(), &batch.motions)
        };
        batch.residuals.penetration =
            batch.residuals.penetration.max(deepest).max(batch.direct.penetration().max(batch.newton.penetration()) as f32);
        if deepest <= NEGLIGIBLE_OVERLAP {
            return;
        }
        if !begins_at_once {
            self.begin_pushes(batch);
        }
        let (all, jointed) = (0..batch.contacts.len(), batch.contacts.first_jointed..batch.contacts.len());
        for sweep in usize::from(begins_at_once)..contact_kernels::RECOVERY_SWEEPS {
            if sweep > 0 {
                self.yield_to_pushes(batch, threads);
            }
            self.recover(batch, threads, &all, dt);
        }
        for _ in 0..JOINTED_RECOVERY_SWEEPS {
            self.yield_to_pushes(batch, threads);
            self.recover(batch, threads, &jointed, dt);
        }
        newton.recover(batch, &mut self.pushes, dt);
        let (Self { pushes }, Batch { velocities, motions, .. }) = (self, batch);
        let piece = if threads.has_team() { threads.piece(motions.len(), SHARED_BODIES) } else { motions.len() };
        let bodies = velocities.chunks_mut(piece).zip(motions.chunks_mut(piece));
        threads.share(pushes.chunks(piece).zip(bodies), |(pushes, (velocities, motions))| {
            pushes
                .iter()
                .zip(velocities.iter_mut().zip(motions))
                .for_each(|(push, (velocity, motion))| push_out(push, velocity, motion));
        });
    }

    fn begin_pushes(&mut self, batch: &Batch) {
        self.pushes.clear();
        make_room(&mut self.pushes, batch.velocities.len());
        self.pushes.extend(batch.velocities.iter().map(BodyVelocity::at_rest));
    }

    /// Brings contacts to the end of the step and does the first sweep of position recovery over them; greatest overlap (m).
    fn begin_recovery(&mut self, batch: &mut Batch, threads: &Workers, dt: f32) -> f32 {
        // Numbers that are not negative are in the order of their bits.
        let deepest = AtomicU32::new(0);
        let (range, moving, motions) = (0..batch.contacts.len(), batch.moving(), &batch.motions);
        parallel_contacts::in_colors(&mut batch.contacts, range, threads, (&mut self.pushes, moving), false, |part, pushes| {
            deepest.fetch_max(contact_kernels::begin_recovery(part, motions, pushes, dt).to_bits(), Ordering::Relaxed);
        });
        f32::from_bits(deepest.into_inner())
    }

    /// One sweep of position recovery over a range of blocks.
    fn recover(&mut self, batch: &mut Batch, threads: &Workers, range: &Range<usize>, dt: f32) {
        let moving = batch.moving();
        parallel_contacts::in_colors(
            &mut batch.contacts,
            range.clone(),
            threads,
            (&mut self.pushes, moving),
            false,
            |part, pushes| {
                contact_kernels::recover(part, pushes, dt);
            },
        );
    }

    /// Has the pushes of position recovery leave the joints of swept articulations as they are. A hand that is lifted off a trunk is drawn
    /// back by its arm otherwise, as joints are mended next, and sinks in for seconds.
    fn yield_to_pushes(&mut self, batch: &mut Batch, threads: &Workers) {
        let (Self { pushes }, Batch { direct, motions, .. }) = (self, batch);
        direct.yield_to_pushes(SolveContext { threads, velocities: pushes, motions });
    }
}

/// Moves a body out of what it is in. Where its angular velocity has more energy once it has been turned, that goes with it: of a rod that spins about
/// its length a part would be across it, with a thousand times the inertia. Where that is smeared by its turn it always does: such a part may as well take
/// all that it has across. What joints hold keeps it, which they would be pulled apart by.
fn push_out(push: &BodyVelocity, velocity: &mut BodyVelocity, motion: &mut BodyMotion) {
    let before = motion.rotation;
    motion.displace(push.linear, push.angular);
    if motion.kind != MotionKind::Tumbling || motion.jointed || motion.rotation == before {
        return;
    }
    let energy = |rotation: Quat| {
        let spin = (rotation * motion.inertia_frame).conjugate() * velocity.angular;
        (motion.inertia * spin).dot(spin)
    };
    if motion.world_inertia.smeared || energy(motion.rotation) > energy(before) * TURNING_LET_BE {
        velocity.angular = motion.free_rotation() * ((motion.rotation * before.conjugate()).normalize() * velocity.angular);
    }
}
