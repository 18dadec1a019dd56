//! Momentum pass: carries momentum down a stack in one pass, where sweeps would carry it through one contact at a time.
//!
//! A block that falls by a gap, or a stack whose multipliers are not those of its loads, needs as many sweeps as it has storeys
//! before the ground answers. Before the sweeps of a substep this pass works out, for every body that stands on contacts,
//!
//! 1. *bottom up* the velocity that it can keep: across gravity that of what it rests on; along it t = mean over its closing points
//!    of t(below) − c, with c the closing speed that the gap allows (m/s); a body that nothing stops keeps its own;
//! 2. *top down* what must change: the momentum m (t − v) and the angular momentum, with what came from above. What lies across gravity
//!    goes to friction at the middle of each manifold, shared as these are loaded, within the cones. The rest, less the moments of
//!    that friction, is split over the points below as changes δ of multipliers of least norm with λ + δ ≥ 0. Both are handed on;
//! 3. *how much of it is right*: the sweeps minimise ½ |v|² in the metric of mass, plus λ·c; along the changes that is a parabola,
//!    whose least point in 0…1 is taken. So the pass never makes the state of the rows worse, and where it has nothing to offer it
//!    does nothing. By the impulse P and the angular impulse L that changes add up to on each body, its slope is
//!    Σ P·v + L·ω + Σ δ c and its curvature Σ P·M⁻¹P + L·I⁻¹L, so both are known as momentum is handed down.
//!
//! Only contacts whose friction cone holds the vertical take part. Momentum across gravity counts as much as along it: friction has a
//! moment at every storey, and left to the sweeps it makes the multipliers that are carried over a spring on which a tower sways.
//!
//! The pass is for islands without joints in which nothing moves fast across gravity past what it touches: thrown things are not stopped
//! by handing their momentum straight down. How fast things fall, or a tower sways as a whole, does not matter. What sways needs the pass
//! most. Its loads go to and fro between the points of every storey, and those that few sweeps carry lag behind: sinking and rising again
//! each storey takes less from the tower than it gives, and the sway grows.
//!
//! What leans is on its way down unless something else holds it, and the pass is not to stop it: only bodies take part whose centre of mass
//! is over the points that they stand on. In what is being put together, with a body that was made or put where it is less than
//! `SETTLING_TIME` ago and nothing fast across gravity of late, all do: there nothing is to move.
//!
//! Bodies of one storey neither stand on each other nor hand anything to each other: several threads go through a wide one side by
//! side, and each body adds up what it is handed in the order of the bodies above. A thread goes on to its part of the next storey when
//! those parts are done whose bodies stand on it, or under it, without waiting for the rest.

mod changes;
mod order;
mod patch;
mod stack;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use super::StepSettings;
use super::batch::Batch;
use super::contact::{LANES, tangents};
use super::contact_newton::choose::left_by_sweeps;
use super::contact_partition::BlockRange;
use super::parallel_contacts;
use super::state::{BodyMotion, BodyVelocity};
use crate::tight_vec::resize;
use crate::tuning::stacks::{MIN_LEVELS, MIN_UNEVEN_LEVELS, SIDEWAYS_TIME, WORTHWHILE_SHARE};
use crate::tuning::uneven::LEFT;
use crate::workers::Workers;
use changes::LaneChanges;
use order::Order;
use patch::Balance;
use stack::{NO_PLACE, Stacks};

/// The stacks of a batch, and buffers.
#[derive(Debug, Default)]
pub(crate) struct MomentumPass {
    is_on: bool,
    stacks: Stacks,
    order: Order,
    /// Changes of multipliers, by block.
    changes: Vec<LaneChanges>,
    axes: [Vec3; 3],
    /// Island of each slot; of those after the last island, none.
    island: Vec<u32>,
    islands: Vec<StackIsland>,
    /// Whether each is no tower, as several threads find it.
    others: Vec<AtomicBool>,
    /// By slot.
    activities: Vec<BodyActivity>,
    balance: Vec<Balance>,
}

/// Per-body inputs to [`StackIsland`].
#[derive(Debug, Clone, Copy, Default)]
struct BodyActivity {
    is_dynamic: bool,
    is_slow: bool,
    is_steady: bool,
    is_young: bool,
    is_jointed: bool,
    mass: f64,
    worthwhile: f64,
}

impl BodyActivity {
    fn of(velocity: &BodyVelocity, motion: &BodyMotion, up: Vec3, limit: f32, h: f32) -> Self {
        if !motion.is_dynamic() {
            return Self::default();
        }
        let sideways = velocity.linear.reject_from_normalized(up);
        let gained = f64::from(motion.acceleration.length() * h);
        let mass = 1.0 / f64::from(velocity.inverse_mass.max_element());
        Self {
            is_dynamic: true,
            is_slow: sideways.length_squared() < limit * limit,
            is_steady: motion.steady,
            is_young: motion.young,
            is_jointed: motion.jointed,
            mass,
            worthwhile: WORTHWHILE_SHARE * 0.5 * mass * gained * gained,
        }
    }
}

/// Of an island: whether the pass is for it, its number of storeys, and the slope and curvature along the changes.
#[derive(Debug, Clone, Copy, Default)]
struct StackIsland {
    /// Whether nothing in it moves fast across gravity now.
    is_slow: bool,
    /// Whether that has been so for long enough.
    is_steady: bool,
    /// Whether any body in it is young.
    is_young: bool,
    /// The pass knows contacts alone: a load that a joint takes would be handed down a second time.
    is_jointed: bool,
    /// Whether nothing in it moves fast across gravity past what it touches.
    is_tower: bool,
    /// Whether masses in it differ so much that sweeps carry little of a load through two storeys.
    is_uneven: bool,
    levels: u32,
    slope: f64,
    curvature: f64,
    /// Energy that the pass must take out to be worthwhile (J).
    worthwhile: f64,
    /// Share of the changes that is taken.
    share: f32,
}

impl StackIsland {
    fn may_be_useful(&self) -> bool {
        !self.is_jointed && (self.is_tower || self.is_being_built())
    }

    /// Whether it is being put together: all of it is to stay as it was put, what leans on others too.
    fn is_being_built(&self) -> bool {
        !self.is_jointed && self.is_steady && self.is_young
    }

    fn is_useful(&self) -> bool {
        self.may_be_useful() && self.levels >= if self.is_uneven { MIN_UNEVEN_LEVELS } else { MIN_LEVELS }
    }

    /// Share of the changes at which the energy is least; written so that what is not a number changes nothing.
    fn best_share(&self) -> f32 {
        let descends = self.curvature > 0.0 && self.slope < 0.0;
        let share = (-self.slope / self.curvature).min(1.0);
        let gain = -share * (self.slope + 0.5 * share * self.curvature);
        if self.is_useful() && descends && gain > self.worthwhile { share as f32 } else { 0.0 }
    }
}

/// Island of slots that belong to none: the world's, and those of kinematic bodies.
const NO_ISLAND: u32 = u32::MAX;

/// Bodies of which the velocity is worth another thread's while.
const MIN_BODIES: usize = 256;

/// Blocks of contacts that are.
const MIN_BLOCKS: usize = 64;

impl MomentumPass {
    /// Forgets the islands of the last step.
    pub(crate) fn clear(&mut self) {
        self.is_on = false;
        self.islands.clear();
        self.island.clear();
    }

    /// Lists the stacks of a step with substeps of this length (s).
    pub(crate) fn prepare(&mut self, batch: &Batch, threads: &Workers, settings: &StepSettings, h: f32) {
        self.clear();
        let StepSettings { gravity, iterations, .. } = *settings;
        let Some(up) = (-gravity).try_normalize() else { return };
        let (u, v) = tangents(up);
        self.axes = [up, u, v];
        let limit = SIDEWAYS_TIME * gravity.length();
        self.find_slow_islands(batch, threads, limit, h, iterations);
        self.find_towers(batch, threads, limit);
        if self.islands.iter().any(StackIsland::may_be_useful) {
            self.list_stands(batch, threads);
            self.put_in_order(threads);
            self.is_on = !self.stacks.bodies.is_empty();
            if self.is_on {
                self.describe(batch, threads);
            }
        }
    }

    /// Whether nothing in the island of a slot moves fast across gravity.
    pub(crate) fn is_slow(&self, slot: usize) -> bool {
        self.island.get(slot).and_then(|&island| self.islands.get(island as usize)).is_none_or(|island| island.is_slow)
    }

    fn find_slow_islands(&mut self, batch: &Batch, threads: &Workers, limit: f32, h: f32, sweeps: u32) {
        let Self { islands, island, activities, axes: [up, ..], .. } = self;
        islands.resize(batch.islands.len(), StackIsland { is_slow: true, is_steady: true, ..StackIsland::default() });
        island.resize(batch.velocities.len(), NO_ISLAND);
        resize(activities, batch.velocities.len(), BodyActivity::default());
        let piece = threads.piece(activities.len(), MIN_BODIES);
        let bodies = batch.velocities.chunks(piece).zip(batch.motions.chunks(piece));
        threads.share(activities.chunks_mut(piece).zip(bodies), |(activities, (velocities, motions))| {
            for (activity, (velocity, motion)) in activities.iter_mut().zip(velocities.iter().zip(motions)) {
                *activity = BodyActivity::of(velocity, motion, *up, limit, h);
            }
        });
        for (number, &first) in batch.islands.iter().enumerate() {
            let next = batch.islands.get(number + 1).map_or(activities.len(), |&next| next as usize);
            let own = &mut islands[number];
            let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
            for (activity, island) in activities[first as usize..next].iter().zip(&mut island[first as usize..next]) {
                if activity.is_dynamic {
                    *island = number as u32;
                    own.is_slow &= activity.is_slow;
                    own.is_steady &= activity.is_steady;
                    own.is_young |= activity.is_young;
                    own.is_jointed |= activity.is_jointed;
                    own.worthwhile += activity.worthwhile;
                    (least, most) = (least.min(activity.mass), most.max(activity.mass));
                }
            }
            own.is_steady &= own.is_slow;
            own.is_uneven = left_by_sweeps(most / least, sweeps) > LEFT;
        }
    }

    /// Finds the islands in which nothing moves faster than `limit` (m/s) across gravity past what it touches.
    fn find_towers(&mut self, batch: &Batch, threads: &Workers, limit: f32) {
        let Self { islands, island, others, axes: [up, ..], .. } = self;
        others.clear();
        others.resize_with(islands.len(), AtomicBool::default);
        let piece = threads.piece(batch.contacts.len(), MIN_BLOCKS);
        threads.share(batch.contacts.blocks.chunks(piece), |blocks| {
            for block in blocks {
                for lane in (0..LANES).filter(|&lane| block.count[lane] > 0) {
                    let slots = [block.a[lane], block.b[lane]].map(|slot| slot as usize);
                    let own = || slots.into_iter().filter_map(|slot| others.get(island[slot] as usize));
                    if own().all(|other| other.load(Ordering::Relaxed)) {
                        continue;
                    }
                    let [a, b] = slots.map(|slot| batch.velocities[slot].linear);
                    if (b - a).reject_from_normalized(*up).length_squared() >= limit * limit {
                        own().for_each(|other| other.store(true, Ordering::Relaxed));
                    }
                }
            }
        });
        for (island, other) in islands.iter_mut().zip(others) {
            island.is_tower = !*other.get_mut();
        }
    }

    /// Whether nothing in the batch stands so that momentum is passed down.
    pub(crate) fn is_idle(&self) -> bool {
        !self.is_on
    }

    /// Passes the momentum of the substep down.
    pub(crate) fn apply(&mut self, batch: &mut Batch, threads: &Workers) {
        if self.is_idle() {
            return;
        }
        self.find_targets(batch, threads);
        self.hand_down(batch, threads);
        self.find_shares();
        self.apply_shares(batch, threads);
    }

    /// Finds the velocity that every body can keep, from the ground.
    fn find_targets(&mut self, batch: &Batch, threads: &Workers) {
        let stacks = self.stacks.divide();
        let up = self.axes[0];
        let pieces = self.order.pieces().rev();
        threads.share_in_flow(
            pieces,
            |number, need| self.order.each_below(number, need),
            |places: Range<u32>| {
                // SAFETY: each body is of one piece, and a piece waits for those whose bodies stand on its own, or under them.
                let mut stacks = unsafe { stacks.part() };
                places.rev().for_each(|place| stacks.find_target(place, batch, up));
            },
        );
    }

    /// Finds changes of multipliers that give every body its velocity, from the top.
    fn hand_down(&mut self, batch: &Batch, threads: &Workers) {
        let stacks = self.stacks.divide();
        let Self { order, changes, axes: [up, ..], .. } = self;
        threads.share_in_flow(
            order.pieces(),
            |number, need| order.each_above(number, need),
            |places: Range<u32>| {
                // SAFETY: as above.
                let mut stacks = unsafe { stacks.part() };
                places.for_each(|place| stacks.hand_down(place, order.above(place), batch, *up, changes));
            },
        );
    }

    /// Finds the share of the changes at which the energy of the rows of each island is least.
    fn find_shares(&mut self) {
        for island in &mut self.islands {
            (island.slope, island.curvature) = (0.0, 0.0);
        }
        let placed = self.order.places().iter().zip(&self.island).zip(&self.stacks.along);
        for ((_, &island), along) in placed.filter(|&((&place, _), _)| place != NO_PLACE) {
            let island = &mut self.islands[island as usize];
            island.slope += along.slope;
            island.curvature += along.curvature;
        }
        for island in &mut self.islands {
            island.share = island.best_share();
        }
    }

    /// Takes those shares.
    fn apply_shares(&self, batch: &mut Batch, threads: &Workers) {
        let share_of = |island: u32| self.islands[island as usize].share;
        let piece = threads.piece(batch.velocities.len(), MIN_BODIES);
        threads.share(batch.velocities.chunks_mut(piece).zip(self.order.places().chunks(piece)), |(velocities, places)| {
            for (velocity, &place) in velocities.iter_mut().zip(places).filter(|&(_, &place)| place != NO_PLACE) {
                let body = &self.stacks.bodies[place as usize];
                let share = share_of(body.island);
                if share > 0.0 {
                    velocity.linear += body.change.0 * share;
                    velocity.angular += body.change.1 * share;
                }
            }
        });
        parallel_contacts::side_by_side(&mut batch.contacts, threads, |BlockRange { first, part }| {
            for (whole, changes) in part.iter().zip(&self.changes[first..]) {
                changes.apply(whole, share_of);
            }
        });
    }
}
