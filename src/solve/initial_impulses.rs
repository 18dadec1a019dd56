//! First multipliers of contacts that appear under load: the static load of what rests on them.
//!
//! A sweep carries load through one contact at a time, so a column built at rest would first sink under multipliers of zero,
//! then rebound. Where bodies at rest stand on contacts that have no history, this pass walks down from the top, and splits each
//! body's weight and what it carries over the points under it: of all λ ≥ 0 along the normals that balance force along gravity
//! and moment about the two horizontal axes, those of least norm. The sweeps start from there. What moves, has multipliers
//! already, or has nothing under it that stands on what cannot move, is left alone, so nothing is held up that must fall: a load
//! handed down to a light body in free fall would shoot it off.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::batch::Batch;
use super::contact::LANES;
use super::contact_block::ContactBlock;
use crate::load_distribution::{LoadedPoint, balance};
use crate::tight_vec::{extend_tightly, make_room};
use crate::tuning::stacks::MAX_REST_SPEED;
use crate::tuning::support::MIN_RISE;
use crate::workers::Workers;
use ground::Ground;

mod ground;

/// Blocks that are worth another thread's while: some 5 µs.
const MIN_BLOCKS: usize = 64;

/// Number of a slot that is not born.
const NOT_BORN: u32 = u32::MAX;

/// Buffers of the pass.
#[derive(Debug, Default)]
pub(crate) struct InitialImpulses {
    /// Supports as they are found, in parts, one after another; and sorted by upper body.
    found: Vec<Vec<Support>>,
    supports: Supports,
    /// Slots under which all contacts are new, which are born; and the number among them of each slot, or [`NOT_BORN`].
    born: Vec<u32>,
    number: Vec<u32>,
    /// What is born and stands on each of those, and is still to be visited; and their load.
    waiting: Vec<u32>,
    load: Vec<(DVec3, DVec3)>,
    /// Where the next support of each slot goes.
    next: Vec<u32>,
    ground: Ground,
    queue: Vec<u32>,
    points: Vec<SupportPoint>,
    /// Force along the vertical and moments about the horizontal axes per unit of λ of each point, and its λ/h.
    loaded: Vec<LoadedPoint>,
}

/// A manifold through which `upper` stands on `lower`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
struct Support {
    upper: u32,
    lower: u32,
    block: u32,
    lane: u8,
    /// Whether it is without multipliers and at rest.
    fresh: bool,
}

/// Supports by upper body.
#[derive(Debug, Default)]
struct Supports {
    sorted: Vec<Support>,
    /// The first of each slot, and one past the last.
    first: Vec<u32>,
}

impl Supports {
    fn range(&self, slot: u32) -> Range<usize> {
        self.first[slot as usize] as usize..self.first[slot as usize + 1] as usize
    }

    /// Those under a slot.
    fn of(&self, slot: u32) -> &[Support] {
        &self.sorted[self.range(slot)]
    }
}

/// A supporting point: its place in the blocks, and how a unit force there acts on the upper body.
#[derive(Debug, Clone, Copy)]
struct SupportPoint {
    support: Support,
    index: usize,
    normal: DVec3,
    lever_lower: DVec3,
}

impl InitialImpulses {
    /// Writes first multipliers into the contacts of `batch` that are new and at rest; `h` is the substep (s).
    pub(crate) fn start_contacts(&mut self, batch: &mut Batch, threads: &Workers, gravity: Vec3, h: f32) {
        let Some(up) = (-gravity).try_normalize() else { return };
        self.find_supports(batch, threads, up, gravity.length() * h);
        if self.born.is_empty() {
            return;
        }
        self.sort_by_upper(batch.velocities.len());
        self.ground.begin(batch);
        self.count_waiting();
        let Self { born, waiting, queue, .. } = self;
        queue.clear();
        queue.extend(born.iter().zip(waiting).filter(|(_, waiting)| **waiting == 0).map(|(&slot, _)| slot));
        let mut next = 0;
        while next < self.queue.len() {
            let slot = self.queue[next];
            next += 1;
            if self.ground.carries(slot, |slot| !batch.motions[slot as usize].is_dynamic(), &self.supports) {
                self.split_load(batch, slot, up.as_dvec3(), h);
            }
            let Self { supports, waiting, number, queue, .. } = self;
            for &Support { lower, .. } in supports.of(slot) {
                let Some(waiting) = waiting.get_mut(number[lower as usize] as usize) else { continue };
                *waiting -= 1;
                if *waiting == 0 {
                    queue.push(lower);
                }
            }
        }
    }

    /// Lists the supporting manifolds, and the bodies of which all are fresh.
    fn find_supports(&mut self, batch: &Batch, threads: &Workers, up: Vec3, closable_speed: f32) {
        let Self { found, supports: Supports { first, .. }, born, number, .. } = self;
        let blocks = &batch.contacts.blocks;
        let piece = if threads.has_team() { threads.piece(blocks.len(), MIN_BLOCKS) } else { blocks.len().max(1) };
        found.resize_with(blocks.len().div_ceil(piece).max(found.len()), Vec::new);
        found.iter_mut().for_each(Vec::clear);
        threads.share(blocks.chunks(piece).zip(found.iter_mut()).zip((0..).step_by(piece)), |((blocks, found), first)| {
            for (block, number) in blocks.iter().zip(first..) {
                let supports = (0..LANES).filter_map(|lane| Support::of(batch, block, lane, up, closable_speed));
                extend_tightly(found, supports.map(|support| Support { block: number, ..support }));
            }
        });
        born.clear();
        if !found.iter().flatten().any(|support| support.fresh) {
            return;
        }
        let slots = batch.velocities.len();
        first.clear();
        first.resize(slots + 1, 0);
        number.clear();
        number.resize(slots, 0);
        for support in found.iter().flatten() {
            first[support.upper as usize + 1] += 1;
            if !support.fresh {
                number[support.upper as usize] = NOT_BORN;
            }
        }
        for (slot, number) in number.iter_mut().enumerate() {
            if first[slot + 1] == 0 {
                *number = NOT_BORN;
            }
            if *number != NOT_BORN {
                *number = born.len() as u32;
                born.push(slot as u32);
            }
            first[slot + 1] += first[slot];
        }
    }

    /// Sorts the supports that were found by upper body; those of bodies that are born in one order, whatever the order of blocks.
    fn sort_by_upper(&mut self, slots: usize) {
        let Self { found, supports, next, born, .. } = self;
        next.clear();
        next.extend_from_slice(&supports.first[..slots]);
        supports.sorted.clear();
        make_room(&mut supports.sorted, supports.first[slots] as usize);
        supports.sorted.resize(supports.first[slots] as usize, Support::default());
        for support in found.iter().flatten() {
            let place = &mut next[support.upper as usize];
            supports.sorted[*place as usize] = *support;
            *place += 1;
        }
        for &slot in &*born {
            let own = supports.range(slot);
            supports.sorted[own].sort_unstable();
        }
    }

    /// Counts what is born and stands on what is born, and takes all load from that.
    fn count_waiting(&mut self) {
        let Self { supports, waiting, load, born, number, .. } = self;
        waiting.clear();
        waiting.resize(born.len(), 0);
        load.clear();
        load.resize(born.len(), (DVec3::ZERO, DVec3::ZERO));
        for support in born.iter().flat_map(|&slot| supports.of(slot)) {
            if let Some(waiting) = waiting.get_mut(number[support.lower as usize] as usize) {
                *waiting += 1;
            }
        }
    }

    /// Splits the load of one body over its supporting points and hands it on to what carries them.
    fn split_load(&mut self, batch: &mut Batch, slot: u32, up: DVec3, h: f32) {
        let horizontal = super::contact::tangents(up.as_vec3());
        let axes = [horizontal.0.as_dvec3(), horizontal.1.as_dvec3()];
        let (motion, velocity) = (&batch.motions[slot as usize], &batch.velocities[slot as usize]);
        let mass = 1.0 / f64::from(velocity.inverse_mass.max_element());
        let (carried, moment) = self.load[self.number[slot as usize] as usize];
        let force = motion.acceleration.as_dvec3() * mass + carried;
        let moment = moment + motion.torque.as_dvec3();
        let demand = -DVec3::new(force.dot(up), moment.dot(axes[0]), moment.dot(axes[1]));
        if demand.x <= 0.0 || !mass.is_finite() {
            return;
        }

        self.points.clear();
        self.loaded.clear();
        let reach = motion.acceleration.length() * h * h;
        for support in self.supports.of(slot) {
            let (number, lane) = (support.block as usize, usize::from(support.lane));
            let block = &batch.contacts.blocks[number];
            let upper_is_b = block.b[lane] == slot;
            let normal = block.normal_of(lane).as_dvec3() * if upper_is_b { 1.0 } else { -1.0 };
            for index in 0..batch.contacts.room_of(number) {
                let rows = batch.contacts.rows(number, index);
                // Touching means that gravity closes the gap within the substep.
                if rows.inverse_diagonal[lane] == 0.0 || rows.separation[lane] > reach {
                    continue;
                }
                let (lever_a, lever_b) = rows.levers_of(lane);
                let (upper, lower) = if upper_is_b { (lever_b, lever_a) } else { (lever_a, lever_b) };
                let turning = upper.as_dvec3().cross(normal);
                let column = DVec3::new(normal.dot(up), turning.dot(axes[0]), turning.dot(axes[1]));
                let lever_lower = lower.as_dvec3();
                self.points.push(SupportPoint { support: *support, index, normal, lever_lower });
                self.loaded.push(LoadedPoint::new(column));
            }
        }
        balance(&mut self.loaded, demand);
        for (point, loaded) in self.points.iter().zip(&self.loaded) {
            let Support { block, lane, lower, .. } = point.support;
            batch.contacts.rows_mut(block as usize, point.index).lambda[usize::from(lane)] = (loaded.force * f64::from(h)) as f32;
            let push = -point.normal * loaded.force;
            if let Some((force, moment)) = self.load.get_mut(self.number[lower as usize] as usize) {
                *force += push;
                *moment += point.lever_lower.cross(push);
            }
        }
    }
}

impl Support {
    /// Of a lane, if a body that rows move stands on something there; its block is still to be told.
    fn of(batch: &Batch, block: &ContactBlock, lane: usize, up: Vec3, closable_speed: f32) -> Option<Self> {
        let normal = block.normal_of(lane);
        let rise = normal.dot(up);
        if !block.is_movable(lane) || rise.abs() < MIN_RISE {
            return None;
        }
        let (a, b) = (block.a[lane], block.b[lane]);
        let (lower, upper) = if rise > 0.0 { (a, b) } else { (b, a) };
        if !(1..=batch.moving() as u32).contains(&upper) {
            return None;
        }
        let approach = || normal.dot(batch.velocities[b as usize].linear - batch.velocities[a as usize].linear).abs();
        let fresh = !block.is_pressed[lane] && approach() < MAX_REST_SPEED + closable_speed;
        Some(Self { upper, lower, block: 0, lane: lane as u8, fresh })
    }
}
