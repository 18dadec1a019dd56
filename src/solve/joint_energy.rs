//! Energy check of swept joints: sweeps may not add kinetic energy.
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
//!
//! **Motors** do work. An impulse λ of rows J takes v to v' = v + M⁻¹ Jᵀ λ, and T' = T + λᵀ J v' − ½ (v' − v)ᵀ M (v' − v). What
//! holds or stops has λ J v' ≤ 0 where it is solved; so with W the sum of λ J v' over the rows of motors, which have no more than that to
//! give, T' ≤ T + W, and where sweeps have made it more,
//!
//! ```text
//! v ← s v,    s² T' = T + s W.
//! ```
//!
//! **What rows do not hold.** A light body between joints that contradict each other, or between the world and what is thousands of
//! times heavier, is flung about within T where a few sweeps come nowhere near what its rows ask for. So in an island that hangs on
//! something fixed, √(2T/m) of a body that its joints do not hold (`UNHELD`) is kept to the greatest of all before the sweeps, but for
//! what motors do. A whip's end is held, and may be faster.

use super::batch::Batch;
use super::joint::{BatchJoints, JointEntry};
use super::momentum::FreeIslands;
use super::state::{BodyMotion, BodyVelocity};
use super::wide_bodies::WideBodies;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::tight_vec::resize;
use crate::tuning::energy::{TORN, UNHELD};
use crate::workers::Workers;

/// Growth of kinetic energy by the sweeps of a substep that is let be, as a share of it: rounding of `f32`.
const LET_BE: f64 = 1.0e-6;

/// Growth of a body's energy over that of the fastest that is let be: rounding of `f32`.
const FASTER: f32 = 1.0 + 1.0e-4;

/// An island whose joints and bounds give no energy but by motors: a range of slots.
#[derive(Debug, Clone, Copy)]
struct WatchedIsland {
    first: u32,
    end: u32,
    /// Kinetic energy before and after the sweeps (J).
    before: f64,
    after: f64,
    /// Of its bodies before, the greatest energy for a mass (J/kg).
    fastest: f32,
    /// Whether it has motors, and what they have done in the substep (J).
    has_motors: bool,
    work: f64,
}

impl WatchedIsland {
    fn slots(&self) -> std::ops::Range<usize> {
        self.first as usize..self.end as usize
    }

    fn sum(&self, energies: &[f32]) -> f64 {
        energies[self.slots()].iter().map(|&energy| f64::from(energy)).sum()
    }

    fn has_grown(&self) -> bool {
        self.after > (self.before + self.work) * (1.0 + LET_BE) || self.after.is_nan()
    }

    fn is_torn(&self) -> bool {
        self.after > (self.before + self.work.max(0.0)) * TORN || !(self.after + self.work).is_finite()
    }

    /// Share of a motion that is kept where its kinetic energy has grown (J, from and to).
    fn kept(&self, from: f64, to: f64) -> f64 {
        if self.has_motors {
            (self.work + (self.work * self.work + 4.0 * to * from).sqrt()) / (2.0 * to)
        } else {
            (from / to).sqrt()
        }
    }
}

/// The islands of a batch whose energy is watched.
#[derive(Debug, Default)]
pub(crate) struct JointEnergy {
    islands: Vec<WatchedIsland>,
    /// Number of the island of each slot, and whether each island may be given energy by anything but motors, or by them.
    owner: Vec<u32>,
    driven: Vec<bool>,
    motorised: Vec<bool>,
    /// Velocities of all slots before the sweeps.
    before: Vec<BodyVelocity>,
    /// Whether the multipliers on each slot are given up.
    torn: Vec<bool>,
    /// Slots of bodies with a joint that does not hold them.
    unheld: Vec<u32>,
}

/// Velocities that are worth another thread's while: some 5 µs.
const MIN_NOTED: usize = 1024;

/// What is in no island: the world, and bodies that move by themselves.
const NOBODY: u32 = u32::MAX;

impl JointEnergy {
    /// Slots of each island that can be given no energy at all.
    pub(crate) fn slots(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.islands.iter().filter(|island| !island.has_motors).map(WatchedIsland::slots)
    }

    /// Slots of all islands.
    pub(crate) fn all_slots(&self) -> impl Iterator<Item = usize> + '_ {
        self.islands.iter().flat_map(WatchedIsland::slots)
    }

    /// First slot of each island.
    pub(crate) fn firsts(&self) -> impl Iterator<Item = u32> + '_ {
        self.islands.iter().map(|island| island.first)
    }

    /// Notes velocities, and the energy that forces have left.
    pub(crate) fn note(&mut self, threads: &Workers, velocities: &[BodyVelocity], poses: &WideBodies) {
        let Self { islands, before, .. } = self;
        if islands.is_empty() {
            return;
        }
        resize(before, velocities.len(), BodyVelocity::FIXED);
        let piece = threads.piece(velocities.len(), MIN_NOTED);
        threads.share(before.chunks_mut(piece).zip(velocities.chunks(piece)), |(before, now)| before.copy_from_slice(now));
        for island in islands {
            island.before = island.sum(&poses.energies);
            let own = velocities[island.slots()].iter().zip(&poses.energies[island.slots()]);
            island.fastest = own.map(|(velocity, energy)| energy * velocity.inverse_mass.max_element()).fold(0.0, f32::max);
        }
    }

    /// Velocities that forces have left, of all slots.
    pub(crate) fn noted(&self) -> &[BodyVelocity] {
        &self.before
    }

    /// Slows what is faster than anything in its island was and not held by its joints; energies are those of now.
    fn slow_unheld(
        &mut self,
        (joints, entries): (&Pool<Joint, JointId>, &[JointEntry]),
        (velocities, motions): (&mut [BodyVelocity], &[BodyMotion]),
        poses: &mut WideBodies,
        free: &FreeIslands,
    ) {
        let Self { islands, unheld, .. } = self;
        unheld.clear();
        let mut looked = false;
        for island in islands.iter() {
            let most = |ease: f32| island.fastest + island.work.max(0.0) as f32 * ease;
            for slot in island.slots() {
                let ease = velocities[slot].inverse_mass.max_element();
                let (pace, most) = (poses.energies[slot] * ease, most(ease));
                if pace <= most * FASTER || free.begins_at(island.first) {
                    continue;
                }
                if !std::mem::replace(&mut looked, true) {
                    let loose = |entry: &&JointEntry| entry.missed(&joints[entry.joint].def.kind, velocities, motions) > UNHELD;
                    unheld.extend(entries.iter().filter(loose).flat_map(|entry| [entry.a, entry.b]));
                }
                if unheld.contains(&(slot as u32)) {
                    let kept = most / pace;
                    let velocity = &mut velocities[slot];
                    (velocity.linear, velocity.angular) = (velocity.linear * kept.sqrt(), velocity.angular * kept.sqrt());
                    poses.energies[slot] *= kept;
                }
            }
        }
    }

    /// Finds the islands whose rows give no energy but by motors: joints and bounds without give, on bodies moved in lanes.
    pub(crate) fn find_islands(&mut self, batch: &Batch) {
        let first_driver = batch.moving() + 1;
        let Batch { motions, manifolds, direct, long_range, joints, .. } = batch;
        let Self { islands, owner, driven, motorised, .. } = self;
        islands.clear();
        if joints.entries.is_empty() {
            return;
        }
        driven.clear();
        owner.clear();
        owner.resize(motions.len(), NOBODY);
        for (number, &first) in batch.islands.iter().enumerate() {
            let end = batch.islands.get(number + 1).map_or(motions.len(), |&next| next as usize);
            islands.push(WatchedIsland {
                first,
                end: end as u32,
                before: 0.0,
                after: 0.0,
                fastest: 0.0,
                has_motors: false,
                work: 0.0,
            });
            let own = || (first as usize..end).filter(|&slot| motions[slot].is_dynamic());
            own().for_each(|slot| owner[slot] = number as u32);
            driven.push(own().any(|slot| !motions[slot].in_lanes));
        }
        motorised.clear();
        motorised.resize(islands.len(), false);
        let mut mark = |ends: [u32; 2], gives: bool, has_motor: bool| {
            let is_moved = ends.iter().any(|&slot| slot as usize >= first_driver);
            for owner in ends.map(|slot| owner[slot as usize]).into_iter().filter(|&owner| owner != NOBODY) {
                driven[owner as usize] |= gives || is_moved;
                motorised[owner as usize] |= has_motor;
            }
        };
        manifolds.inputs.iter().for_each(|input| mark([input.a, input.b], true, false));
        direct.entries().for_each(|entry| mark([entry.a, entry.b], true, false));
        for link in direct.left(&joints.links) {
            mark([link.a, link.b], !link.traits.gives_by_motors_alone, link.traits.has_motor);
        }
        long_range.bounds.entries.iter().for_each(|entry| mark([entry.near, entry.far], entry.has_give(), false));
        let mut number = 0;
        islands.retain_mut(|island| {
            number += 1;
            island.has_motors = motorised[number - 1];
            !driven[number - 1]
        });
    }

    /// Takes the energy out again that the sweeps of this substep have added; `is_weighed` where energies of now have been found.
    pub(crate) fn restrain(&mut self, batch: &mut Batch, all: &Pool<Joint, JointId>, threads: &Workers, is_weighed: bool) {
        if self.islands.is_empty() {
            return;
        }
        let Batch { velocities, motions, poses, free, joints, long_range, .. } = batch;
        self.find_motor_work(joints, velocities);
        if !is_weighed {
            poses.find_energies(threads, velocities, motions);
        }
        self.slow_unheld((all, &joints.entries), (velocities, motions), poses, free);
        let Self { islands, before, torn, .. } = self;
        islands.iter_mut().for_each(|island| island.after = island.sum(&poses.energies));
        torn.clear();
        for island in islands.iter().filter(|island| island.has_grown()) {
            if island.is_torn() {
                torn.resize(velocities.len(), false);
                torn[island.slots()].fill(true);
                for slot in island.slots() {
                    (velocities[slot].linear, velocities[slot].angular) = (before[slot].linear, before[slot].angular);
                }
                continue;
            }
            let kept = |from, to| island.kept(from, to);
            if !free.slow(island.first, (island.before, island.after), kept, velocities, motions, poses) {
                let kept = kept(island.before, island.after) as f32;
                for velocity in &mut velocities[island.slots()] {
                    velocity.linear *= kept;
                    velocity.angular *= kept;
                }
            }
        }
        if !torn.is_empty() {
            put_back_unmoved(velocities, motions, before);
            joints.give_up(torn);
            long_range.bounds.give_up(torn);
            long_range.taut.give_up(torn);
        }
    }

    fn find_motor_work(&mut self, joints: &BatchJoints, velocities: &[BodyVelocity]) {
        let Self { islands, owner, .. } = self;
        if !islands.iter().any(|island| island.has_motors) {
            return;
        }
        islands.iter_mut().for_each(|island| island.work = 0.0);
        joints.find_work(velocities, |slots, work| {
            let slot = slots.into_iter().find(|&slot| owner[slot as usize] != NOBODY);
            // They are in the order of their slots.
            let place = slot.map(|slot| islands.partition_point(|island| island.end <= slot));
            if let Some(island) = place.and_then(|place| islands.get_mut(place)).filter(|island| Some(island.first) <= slot) {
                island.work += work;
            }
        });
    }
}

/// Gives what rows do not move the velocities that it had: an impulse beyond all numbers, times no ease at all, is no number.
pub(super) fn put_back_unmoved(velocities: &mut [BodyVelocity], motions: &[BodyMotion], before: &[BodyVelocity]) {
    for ((velocity, motion), before) in velocities.iter_mut().zip(motions).zip(before) {
        if !motion.is_dynamic() {
            *velocity = *before;
        }
    }
}
