//! Solves the first substep of a step anew where the load that contacts have carried is gone.
//!
//! Contacts carry their multipliers from step to step as forces. Where what pressed is destroyed, made lighter, put elsewhere or pushed no
//! more between two steps, those stand for a load that is no longer there, and the few sweeps of a substep take back only some of it: the
//! rest throws what is left, 2 m/s at 60 Hz under ten times its weight.
//!
//! From no multipliers on sweeps never add to the kinetic energy T of the bodies they act between: see [the module](super). So of each
//! island without joints T is noted when forces have been added, and looked at after the sweeps. Where it has grown beyond [`AFRESH`],
//! the substep is solved once more from no multipliers.
//!
//! What is pushed by what the host moves, or carried along by its surface, gains by right: such islands are left alone. So are those
//! that are solved as one, which end where nothing is left over.

use std::ops::Range;

use glam::Vec3;

use super::super::batch::Batch;
use super::super::parallel_contacts;
use super::super::state::{BodyMotion, BodyVelocity};
use super::resolve_cold::ColdSolve;
use super::{BodyView, InertiaBounds};
use crate::tuning::energy::AFRESH;
use crate::workers::Workers;

/// Islands without joints in the first substep of a step.
#[derive(Debug, Default)]
pub(crate) struct LoadRelease {
    /// Velocities of all slots before the sweeps.
    before: Vec<BodyVelocity>,
    /// Islands that have gained, as ranges of slots.
    gained: Vec<Range<usize>>,
    cold_solve: ColdSolve,
}

impl LoadRelease {
    /// Notes the velocities that the sweeps begin with.
    pub(crate) fn note(&mut self, batch: &Batch) {
        self.before.clear();
        if !batch.contacts.is_empty() {
            self.before.extend_from_slice(&batch.velocities);
        }
    }

    /// Solves the substep once more for islands to which carried multipliers have given energy.
    pub(crate) fn solve_anew(&mut self, batch: &mut Batch, threads: &Workers, iterations: u32) {
        if self.before.is_empty() {
            return;
        }
        self.find_gained(batch);
        if self.gained.is_empty() {
            return;
        }
        self.leave_what_is_pushed(batch);
        if self.gained.is_empty() {
            return;
        }
        let moving = batch.moving();
        let Self { before, gained, cold_solve } = self;
        let Batch { velocities, contacts, .. } = batch;
        cold_solve.choose(gained.iter().cloned(), velocities.len());
        gained.iter().for_each(|slots| velocities[slots.clone()].copy_from_slice(&before[slots.clone()]));
        cold_solve.take(contacts);
        for iteration in 0..iterations {
            let blocks = &mut cold_solve.blocks;
            parallel_contacts::sweep(blocks, threads, (&mut velocities[..], moving), iteration % 2 == 1, true);
        }
        cold_solve.give_back(contacts);
    }

    /// Finds the islands that have gained energy in the sweeps.
    fn find_gained(&mut self, batch: &Batch) {
        let Self { before, gained, .. } = self;
        gained.clear();
        let end = batch.moving() + 1;
        for (number, &first) in batch.islands.iter().enumerate() {
            let slots = first as usize..batch.islands.get(number + 1).map_or(end, |&next| next as usize);
            if has_gained(&slots, before, &batch.velocities, &batch.motions) {
                gained.push(slots);
            }
        }
    }

    /// Takes out islands that touch what the host moves.
    fn leave_what_is_pushed(&mut self, batch: &Batch) {
        let Self { gained, .. } = self;
        let first = batch.moving() + 1;
        let moves = |slot: u32| {
            let velocity = &batch.velocities[slot as usize];
            slot as usize >= first && (velocity.linear, velocity.angular) != (Vec3::ZERO, Vec3::ZERO)
        };
        if !(first..batch.velocities.len()).any(|slot| moves(slot as u32)) {
            return;
        }
        for ends in &batch.manifolds.ends {
            if moves(ends.a) || moves(ends.b) {
                gained.retain(|slots| ![ends.a, ends.b].iter().any(|&slot| slots.contains(&(slot as usize))));
            }
        }
    }
}

/// Whether an island without joints has gained kinetic energy beyond [`AFRESH`]: by bounds first, which need no inertia tensor.
fn has_gained(slots: &Range<usize>, before: &[BodyVelocity], now: &[BodyVelocity], motions: &[BodyMotion]) -> bool {
    let (mut least, mut most) = (0.0, 0.0);
    for slot in slots.clone() {
        let motion = &motions[slot];
        if motion.jointed || motion.direct {
            return false;
        }
        let weight = InertiaBounds::of(&now[slot], motion);
        least += weight.energy(&before[slot], weight.least);
        most += weight.energy(&now[slot], weight.greatest);
    }
    if most <= AFRESH * least {
        return false;
    }
    let energy = |velocities| {
        let view = BodyView { velocities, motions, places: &[] };
        slots.clone().filter(|&slot| motions[slot].is_dynamic()).map(|slot| view.energy_of(slot)).sum::<f64>()
    };
    energy(now) > AFRESH * energy(before)
}
