//! Sweeps give no energy.
//!
//! Rigid joints and bounds without motors do no work on bodies that move as they allow. Sweeps that are not done do: a carried
//! multiplier is the force of a substep ago, put on where the bodies stand now, and what the few sweeps of a substep leave of it on
//! bodies thousands of times lighter than what hangs on them is speed. So of each island of such joints alone, without contacts,
//! the kinetic energy T is noted when forces have been added, and looked at again after the sweeps. Where it has grown from T to
//! T', all velocities of the island are slowed,
//!
//! ```text
//! v ← √(T/T') v,
//! ```
//!
//! and where nothing holds the island, its motion as one body is left alone: v and T are those against that. What the rows hold stays
//! held: J v = 0 is so at any scale, and rows of second order are off by the share taken. Multipliers are forces, not speeds, and
//! stay; only where T' is beyond a thousand times T (`TORN`) they have grown from one substep to the next, and are given up with all
//! that they have done.

use super::batch::Batch;
use super::joint::JointEntry;
use super::joint::kinds::gives_no_energy;
use super::momentum::FreeIslands;
use super::poses::Poses;
use super::state::{BodyMotion, BodyVelocity, MotionKind};
use crate::id::{JointId, Pool};
use crate::joint::Joint;

/// Growth of kinetic energy by the sweeps of a substep that is let be, as a share of it: rounding of `f32`.
const LET_BE: f64 = 1.0e-6;

/// Growth of kinetic energy by the sweeps of a substep beyond which their multipliers are worth nothing.
const TORN: f64 = 1.0e3;

/// An island whose joints and bounds can give no energy: a range of slots.
#[derive(Debug, Clone, Copy)]
struct Island {
    first: u32,
    end: u32,
    /// Kinetic energy before and after the sweeps (J).
    before: f64,
    after: f64,
}

impl Island {
    fn slots(&self) -> std::ops::Range<usize> {
        self.first as usize..self.end as usize
    }

    fn sum(&self, energies: &[f32]) -> f64 {
        energies[self.slots()].iter().map(|&energy| f64::from(energy)).sum()
    }

    fn has_grown(&self) -> bool {
        self.after > self.before * (1.0 + LET_BE) || self.after.is_nan()
    }

    fn is_torn(&self) -> bool {
        self.after > self.before * TORN || self.after.is_nan()
    }
}

/// The islands of a batch whose energy is watched.
#[derive(Debug, Default)]
pub(crate) struct PassiveIslands {
    islands: Vec<Island>,
    /// Number of the island of each slot, and whether each island may be given energy.
    owner: Vec<u32>,
    driven: Vec<bool>,
    /// Velocities of all slots before the sweeps.
    before: Vec<BodyVelocity>,
    /// Whether the multipliers on each slot are given up.
    torn: Vec<bool>,
}

/// What is in no island: the world, and bodies that move by themselves.
const NOBODY: u32 = u32::MAX;

impl PassiveIslands {
    pub(crate) fn clear(&mut self) {
        self.islands.clear();
    }

    /// Slots of each island.
    pub(crate) fn slots(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.islands.iter().map(Island::slots)
    }

    /// Notes velocities, and the energy that forces have left.
    pub(crate) fn note(&mut self, velocities: &[BodyVelocity], poses: &Poses) {
        let Self { islands, before, .. } = self;
        if islands.is_empty() {
            return;
        }
        before.clear();
        before.extend_from_slice(velocities);
        islands.iter_mut().for_each(|island| island.before = island.sum(&poses.energies));
    }

    /// Takes out what sweeps have added; says on which slots multipliers are given up, if on any.
    fn restrain(
        &mut self,
        velocities: &mut [BodyVelocity],
        motions: &[BodyMotion],
        poses: &mut Poses,
        free: &FreeIslands,
    ) -> Option<&[bool]> {
        let Self { islands, before, torn, .. } = self;
        if islands.is_empty() {
            return None;
        }
        poses.find_energies(velocities, motions);
        islands.iter_mut().for_each(|island| island.after = island.sum(&poses.energies));
        torn.clear();
        for island in islands.iter().filter(|island| island.has_grown()) {
            if island.is_torn() {
                torn.resize(velocities.len(), false);
                torn[island.slots()].fill(true);
                for slot in island.slots() {
                    (velocities[slot].linear, velocities[slot].angular) = (before[slot].linear, before[slot].angular);
                }
            } else if !free.slow(island.first, (island.before, island.after), velocities, motions, poses) {
                let kept = (island.before / island.after).sqrt() as f32;
                for velocity in &mut velocities[island.slots()] {
                    velocity.linear *= kept;
                    velocity.angular *= kept;
                }
            }
        }
        (!torn.is_empty()).then_some(torn)
    }
}

impl Batch {
    /// Finds the islands whose rows can give no energy: joints without motor or give, and rigid bounds, on bodies moved in lanes.
    pub(crate) fn find_passive_islands(&mut self, joints: &Pool<Joint, JointId>) {
        let Self { passive: PassiveIslands { islands, owner, driven, .. }, motions, inputs, direct, bounds, .. } = self;
        islands.clear();
        if self.joints.entries.is_empty() {
            return;
        }
        driven.clear();
        owner.clear();
        owner.resize(motions.len(), NOBODY);
        for (number, &first) in self.islands.iter().enumerate() {
            let end = self.islands.get(number + 1).map_or(motions.len(), |&next| next as usize);
            islands.push(Island { first, end: end as u32, before: 0.0, after: 0.0 });
            let own = || (first as usize..end).filter(|&slot| motions[slot].is_dynamic());
            own().for_each(|slot| owner[slot] = number as u32);
            driven.push(own().any(|slot| !motions[slot].in_lanes));
        }
        let mut mark = |ends: [u32; 2], gives: bool| {
            let is_moved = ends.iter().any(|&slot| motions[slot as usize].kind == MotionKind::Kinematic);
            for owner in ends.map(|slot| owner[slot as usize]).into_iter().filter(|&owner| owner != NOBODY) {
                driven[owner as usize] |= gives || is_moved;
            }
        };
        let gives = |entry: &JointEntry| !gives_no_energy(&joints[entry.joint].def);
        inputs.iter().for_each(|input| mark([input.a, input.b], true));
        direct.entries().for_each(|entry| mark([entry.a, entry.b], true));
        self.joints.entries.iter().for_each(|entry| mark([entry.a, entry.b], gives(entry)));
        bounds.entries.iter().for_each(|entry| mark([entry.near, entry.far], entry.has_give()));
        let mut number = 0;
        islands.retain(|_| {
            number += 1;
            !driven[number - 1]
        });
    }

    /// Takes the energy out again that the sweeps of this substep have added.
    pub(crate) fn restrain(&mut self) {
        let Self { passive, velocities, motions, poses, free, joints, bounds, taut, .. } = self;
        if let Some(torn) = passive.restrain(velocities, motions, poses, free) {
            joints.give_up(torn);
            bounds.give_up(torn);
            taut.give_up(torn);
        }
    }
}
