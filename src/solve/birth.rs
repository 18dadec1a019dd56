//! First multipliers of contacts that are born under load: the static load of what rests on them.
//!
//! A sweep carries load through one contact at a time, so a column built at rest would first sink under multipliers of zero,
//! then rebound. Where bodies at rest stand on contacts that have no history, this pass walks down from the top, and splits each
//! body's weight and what it carries over the points under it: of all λ ≥ 0 along the normals that balance force along gravity
//! and moment about the two horizontal axes, those of least norm. The sweeps start from there. What moves, has multipliers
//! already, or has nothing under it that stands on what cannot move, is left alone, so nothing is held up that must fall: a load
//! handed down to a light body in free fall would shoot it off.

use glam::{DVec3, Vec3};

use super::batch::Batch;
use super::buckets::Buckets;
use super::contact::LANES;
use super::state::WORLD_SLOT;
use crate::balance::{LoadedPoint, balance};

/// Least cosine between a contact's normal and the vertical for it to support.
const MIN_SUPPORT_COSINE: f32 = 0.3;

/// Relative normal speed above which a contact is an impact (m/s).
const MAX_REST_SPEED: f32 = 0.05;

/// Buffers of the pass.
#[derive(Debug, Default)]
pub(crate) struct Birth {
    /// Supports as they are found, and sorted by upper body: the first of each slot.
    found: Vec<Support>,
    supports: Vec<Support>,
    first: Vec<u32>,
    /// Number of unvisited bodies that stand on each slot, and whether the slot's contacts are all new.
    waiting: Vec<u32>,
    new: Vec<bool>,
    /// Whether a slot is, hangs or stands on, what cannot move; those from which this is still to be handed on, and to which.
    grounded: Vec<bool>,
    open: Vec<u32>,
    pairs: Vec<(u32, u32)>,
    above: Buckets,
    load: Vec<(DVec3, DVec3)>,
    queue: Vec<u32>,
    points: Vec<Point>,
    /// Force along the vertical and moments about the horizontal axes per unit of λ of each point, and its λ/h.
    loaded: Vec<LoadedPoint>,
}

/// A manifold through which `upper` stands on `lower`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
struct Support {
    upper: u32,
    lower: u32,
    block: u32,
    lane: u32,
}

/// A supporting point: its place in the blocks, and how a unit force there acts on the upper body.
#[derive(Debug, Clone, Copy)]
struct Point {
    support: Support,
    index: usize,
    normal: DVec3,
    lever_lower: DVec3,
}

impl Birth {
    /// Writes first multipliers into the contacts of `batch` that are new and at rest; `h` is the substep (s).
    pub(crate) fn start_contacts(&mut self, batch: &mut Batch, gravity: Vec3, h: f32) {
        let Some(up) = (-gravity).try_normalize() else { return };
        self.find_supports(batch, up, gravity.length() * h);
        if self.supports.is_empty() {
            return;
        }
        self.queue.clear();
        for slot in 1..batch.velocities.len() as u32 {
            if self.waiting[slot as usize] == 0 && self.has_supports(slot) {
                self.queue.push(slot);
            }
        }
        self.find_grounded(batch);
        let mut next = 0;
        while next < self.queue.len() {
            let slot = self.queue[next];
            next += 1;
            if self.new[slot as usize] && self.grounded[slot as usize] {
                self.split_load(batch, slot, up.as_dvec3(), h);
            }
            for support in self.first[slot as usize]..self.first[slot as usize + 1] {
                let lower = self.supports[support as usize].lower as usize;
                if lower != WORLD_SLOT as usize {
                    self.waiting[lower] -= 1;
                    if self.waiting[lower] == 0 && self.has_supports(lower as u32) {
                        self.queue.push(lower as u32);
                    }
                }
            }
        }
    }

    fn has_supports(&self, slot: u32) -> bool {
        self.first[slot as usize] < self.first[slot as usize + 1]
    }

    /// Notes what joints hold to what cannot move, and what stands on either, over however many others.
    ///
    /// What hangs on something that only stands is not noted: a cable over a drum, above which a load lies, may be in free fall.
    fn find_grounded(&mut self, batch: &Batch) {
        self.grounded.clear();
        self.grounded.extend(batch.motions.iter().map(|motion| !motion.is_dynamic()));
        let joined = || batch.joints.entries.iter().chain(batch.direct.entries()).map(|entry| (entry.a, entry.b));
        if joined().any(|(a, b)| self.grounded[a as usize] != self.grounded[b as usize]) {
            self.pairs.clear();
            self.pairs.extend(joined().flat_map(|(a, b)| [(a, b), (b, a)]));
            self.spread_grounded();
        }
        self.pairs.clear();
        self.pairs.extend(self.supports.iter().map(|support| (support.lower, support.upper)));
        self.spread_grounded();
    }

    /// Notes what is above what is noted, over however many others.
    fn spread_grounded(&mut self) {
        let Self { grounded, open, pairs, above, .. } = self;
        above.sort(grounded.len(), pairs.iter().copied());
        open.clear();
        open.extend((0..grounded.len() as u32).filter(|&slot| grounded[slot as usize]));
        while let Some(lower) = open.pop() {
            for &upper in above.of(lower) {
                if !std::mem::replace(&mut grounded[upper as usize], true) {
                    open.push(upper);
                }
            }
        }
    }

    /// Lists the supporting manifolds; a body is new if all of its are without multipliers and at rest.
    fn find_supports(&mut self, batch: &Batch, up: Vec3, closable_speed: f32) {
        let slots = batch.velocities.len();
        let moving = batch.moving() as u32;
        self.found.clear();
        self.first.clear();
        self.first.resize(slots + 1, 0);
        self.new.clear();
        self.new.resize(slots, true);
        for (number, block) in batch.contacts.blocks.iter().enumerate() {
            for lane in 0..LANES {
                let normal = block.normal_of(lane);
                let rise = normal.dot(up);
                if !block.is_movable(lane) || rise.abs() < MIN_SUPPORT_COSINE {
                    continue;
                }
                let (a, b) = (block.a[lane], block.b[lane]);
                let (lower, upper) = if rise > 0.0 { (a, b) } else { (b, a) };
                if !(1..=moving).contains(&upper) {
                    continue;
                }
                let approach = || normal.dot(batch.velocities[b as usize].linear - batch.velocities[a as usize].linear).abs();
                let fresh = !block.is_pressed[lane] && approach() < MAX_REST_SPEED + closable_speed;
                self.new[upper as usize] &= fresh;
                self.first[upper as usize + 1] += 1;
                self.found.push(Support { upper, lower, block: number as u32, lane: lane as u32 });
            }
        }
        self.supports.clear();
        if !self.found.iter().any(|support| self.new[support.upper as usize]) {
            return;
        }
        for slot in 0..slots {
            self.first[slot + 1] += self.first[slot];
        }
        self.sort_by_upper(slots);
        self.load.clear();
        self.load.resize(slots, (DVec3::ZERO, DVec3::ZERO));
    }

    /// Sorts the supports that were found by upper body, and counts what stands on each slot.
    fn sort_by_upper(&mut self, slots: usize) {
        let Self { found, supports, first, waiting, .. } = self;
        waiting.clear();
        // For now, where the next support of each slot goes.
        waiting.extend_from_slice(&first[..slots]);
        supports.resize(found.len(), Support::default());
        for support in &*found {
            let place = &mut waiting[support.upper as usize];
            supports[*place as usize] = *support;
            *place += 1;
        }
        waiting.fill(0);
        found.iter().for_each(|support| waiting[support.lower as usize] += 1);
        first.windows(2).for_each(|own| supports[own[0] as usize..own[1] as usize].sort_unstable());
    }

    /// Splits the load of one body over its supporting points and hands it on to what carries them.
    fn split_load(&mut self, batch: &mut Batch, slot: u32, up: DVec3, h: f32) {
        let horizontal = super::contact::tangents(up.as_vec3());
        let axes = [horizontal.0.as_dvec3(), horizontal.1.as_dvec3()];
        let (motion, velocity) = (&batch.motions[slot as usize], &batch.velocities[slot as usize]);
        let mass = 1.0 / f64::from(velocity.inverse_mass.max_element());
        let (carried, moment) = self.load[slot as usize];
        let force = motion.acceleration.as_dvec3() * mass + carried;
        let moment = moment + motion.torque.as_dvec3();
        let demand = -DVec3::new(force.dot(up), moment.dot(axes[0]), moment.dot(axes[1]));
        if demand.x <= 0.0 || !mass.is_finite() {
            return;
        }

        self.points.clear();
        self.loaded.clear();
        let reach = motion.acceleration.length() * h * h;
        for support in &self.supports[self.first[slot as usize] as usize..self.first[slot as usize + 1] as usize] {
            let (number, lane) = (support.block as usize, support.lane as usize);
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
                self.points.push(Point { support: *support, index, normal, lever_lower });
                self.loaded.push(LoadedPoint::new(column));
            }
        }
        balance(&mut self.loaded, demand);
        for (point, loaded) in self.points.iter().zip(&self.loaded) {
            let Support { block, lane, lower, .. } = point.support;
            batch.contacts.rows_mut(block as usize, point.index).lambda[lane as usize] = (loaded.force * f64::from(h)) as f32;
            let push = -point.normal * loaded.force;
            let load = &mut self.load[lower as usize];
            load.0 += push;
            load.1 += point.lever_lower.cross(push);
        }
    }
}
