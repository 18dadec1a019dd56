//! Solves a substep of some islands of a batch again, without warm start.

use std::ops::Range;

use super::super::batch::Batch;
use super::super::color::ColorRange;
use super::super::contact::LANES;
use super::super::contact_block::{ContactBlock, ContactBlocks};
use super::super::joint_energy::put_back_unmoved;
use super::super::parallel_contacts;
use super::super::smeared_spins::SmearedSpins;
use super::super::state::WORLD_SLOT;
use super::{ContactEnergy, SweptIsland};
use crate::workers::Workers;

/// What a second solve works on.
#[derive(Debug, Default)]
pub(super) struct ColdSolve {
    /// Whether each slot is of an island that is solved once more.
    slots: Vec<bool>,
    /// Their blocks of contacts, in which lanes of other islands are empty, and the batch's number of each.
    pub(super) blocks: ContactBlocks,
    numbers: Vec<u32>,
}

impl ColdSolve {
    /// Chooses the islands with these slots, of a batch that has so many.
    pub(super) fn choose(&mut self, islands: impl Iterator<Item = Range<usize>>, count: usize) {
        self.slots.clear();
        self.slots.resize(count, false);
        islands.for_each(|slots| self.slots[slots].fill(true));
    }

    /// Whether each slot belongs to a chosen island.
    pub(super) fn slots(&self) -> &[bool] {
        &self.slots
    }

    /// Lanes of a block that belong to a chosen island.
    pub(super) fn lanes(&self, block: &ContactBlock) -> [bool; LANES] {
        std::array::from_fn(|l| self.slots[block.a[l] as usize] || self.slots[block.b[l] as usize])
    }

    /// Takes the blocks of the chosen islands without their multipliers, in the colours that they have.
    pub(super) fn take(&mut self, contacts: &ContactBlocks) {
        self.blocks.clear();
        self.numbers.clear();
        self.blocks.first_jointed = 0;
        for color in &contacts.colors {
            let first = self.blocks.len();
            self.take_blocks(contacts, color.blocks.start..color.points);
            let points = self.blocks.len();
            self.take_blocks(contacts, color.points..color.blocks.end);
            let blocks = first..self.blocks.len();
            self.blocks.colors.push(ColorRange { blocks, points, ..*color });
        }
    }

    /// Takes what is chosen of blocks that follow one another.
    fn take_blocks(&mut self, contacts: &ContactBlocks, numbers: Range<usize>) {
        for number in numbers {
            let chosen = self.lanes(&contacts.blocks[number]);
            if chosen == [false; LANES] {
                continue;
            }
            let mut copy = self.blocks.add_copy(contacts, number);
            copy.multipliers().for_each(|lambda| *lambda = [0.0; LANES]);
            for l in (0..LANES).filter(|&l| !chosen[l]) {
                (copy.block.a[l], copy.block.b[l]) = (WORLD_SLOT, WORLD_SLOT);
            }
            self.numbers.push(number as u32);
            self.blocks.first_jointed += usize::from(number < contacts.first_jointed);
        }
    }

    /// Hands the multipliers of the chosen islands back.
    pub(super) fn give_back(&mut self, contacts: &mut ContactBlocks) {
        for (place, &number) in self.numbers.iter().enumerate() {
            let chosen = self.lanes(&self.blocks.blocks[place]);
            let (mut found, mut whole) = (self.blocks.whole(place), contacts.whole(number as usize));
            for (lambda, found) in whole.multipliers().zip(found.multipliers()) {
                (0..LANES).filter(|&l| chosen[l]).for_each(|l| lambda[l] = found[l]);
            }
        }
    }
}

impl ContactEnergy {
    /// Solves the substep once more for the islands that have gained too much.
    pub(super) fn solve_afresh(&mut self, batch: &mut Batch, iterations: u32, smeared: &SmearedSpins) {
        let (alone, moving) = (Workers::default(), batch.moving());
        let Self { islands, before, cold_solve, .. } = self;
        let Batch { velocities, motions, contacts, direct, .. } = batch;
        let chosen = || islands.iter().filter(|island| island.is_to_be_solved_afresh()).map(SweptIsland::slots);
        cold_solve.choose(chosen(), velocities.len());
        chosen().for_each(|slots| velocities[slots.clone()].copy_from_slice(&before[slots]));
        put_back_unmoved(velocities, motions, before);
        smeared.show(velocities, |slot| cold_solve.slots[slot]);
        cold_solve.take(contacts);
        direct.drop_impulses(&cold_solve.slots);
        for iteration in 0..iterations {
            if iteration % 2 == 0 {
                direct.sweep_on(&cold_solve.slots, velocities);
                parallel_contacts::sweep(&mut cold_solve.blocks, &alone, (velocities, moving), false, true);
            } else {
                parallel_contacts::sweep(&mut cold_solve.blocks, &alone, (velocities, moving), true, true);
                direct.sweep_on(&cold_solve.slots, velocities);
            }
        }
        smeared.give_back(velocities, |slot| cold_solve.slots[slot]);
        cold_solve.give_back(contacts);
    }
}
