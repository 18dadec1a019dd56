//! Conjugate search directions over the multipliers of all joints in lanes, two at once (*solve/joint_mesh.rs*).

use glam::Vec3;

use super::{Holds, JointEntry, JointLanes, ZERO3, get, put, sweep};
use crate::lanes::wide::{Wide, Wide3};
use crate::platform::in_lanes;
use crate::solve::contact::{LANES, Lane3};
use crate::solve::disjoint::Slots;
use crate::solve::state::BodyVelocity;

/// Multipliers of a block before the last sweeps, and what the last move changed them by.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct JointDirectionEntry {
    before: Lane3,
    way: Lane3,
}

/// Stations of the blocks of [`JointLanes`], one for points and one for directions.
#[derive(Debug, Default)]
pub(super) struct JointDirections {
    points: Vec<JointDirectionEntry>,
    directions: Vec<JointDirectionEntry>,
}

/// Greatest move that is remembered (N·s, N·m·s): beyond, its products with the lightest bodies are no numbers in `f32`.
const MAX_WAY: f32 = 1.0e10;

/// A move, or none where it is beyond all measure.
fn sane(way: Vec3) -> Vec3 {
    // Written so that one which is no number counts.
    if way.abs().cmple(Vec3::splat(MAX_WAY)).all() { way } else { Vec3::ZERO }
}

impl JointLanes {
    /// Begins a step: multipliers have last moved as the joints remember.
    pub(crate) fn begin_course(&mut self, entries: &[JointEntry]) {
        let Self { points, directions, search, .. } = self;
        for (direction_entries, count) in [(&mut search.points, points.len()), (&mut search.directions, directions.len())] {
            direction_entries.clear();
            direction_entries.resize(count, JointDirectionEntry { before: ZERO3, way: ZERO3 });
        }
        for (block, direction_entry) in points.iter().zip(&mut search.points) {
            for (l, &number) in block.numbers().iter().enumerate() {
                let entry = &entries[number as usize];
                put(&mut direction_entry.way, l, sane(entry.acted[0]));
                if let Some(number) = block.directions {
                    put(&mut search.directions[number as usize].way, l, sane(entry.acted[1]));
                }
            }
        }
    }

    /// Has the joints remember how multipliers moved last.
    pub(crate) fn end_course(&self, entries: &mut (impl Slots<JointEntry> + ?Sized)) {
        for (block, direction_entry) in self.points.iter().zip(&self.search.points) {
            for (l, &number) in block.numbers().iter().enumerate() {
                let entry = entries.get_mut(number);
                let turn = block.directions.map(|number| get(&self.search.directions[number as usize].way, l));
                entry.acted = [get(&direction_entry.way, l), turn.unwrap_or_default()].map(sane);
            }
        }
    }

    /// Notes the multipliers that sweeps begin with.
    pub(crate) fn note_course(&mut self) {
        let Self { points, directions, search, .. } = self;
        let note = |(direction_entry, impulse): (&mut JointDirectionEntry, &Lane3)| direction_entry.before = *impulse;
        search.points.iter_mut().zip(points.iter().map(|block| &block.impulse)).for_each(note);
        search.directions.iter_mut().zip(directions.iter().map(|block| &block.impulse)).for_each(note);
    }

    /// Scales the multipliers.
    pub(crate) fn scale_impulses(&mut self, share: f32) {
        let Self { points, directions, .. } = self;
        let impulses = points.iter_mut().map(|block| &mut block.impulse);
        for lane in impulses.chain(directions.iter_mut().map(|block| &mut block.impulse)).flatten() {
            lane.iter_mut().for_each(|impulse| *impulse *= share);
        }
    }

    /// Applies the last move of the multipliers, across the axes of now where joints turn about one.
    pub(crate) fn apply_way(&mut self, velocities: &mut [BodyVelocity]) {
        let Self { directions, search, .. } = self;
        for (block, direction_entry) in
            directions.iter().zip(&mut search.directions).filter(|(block, _)| block.holds == Holds::Axis)
        {
            for l in 0..LANES {
                let (way, axis) = (get(&direction_entry.way, l), get(&block.free_axis, l));
                put(&mut direction_entry.way, l, way - axis * axis.dot(way));
            }
        }
        apply_all(self, velocities);
    }

    /// Products of the biases with what sweeps have changed the multipliers by, and with the last move.
    pub(crate) fn weigh_course(&self) -> [f64; 2] {
        let mut products = [0.0; 2];
        weigh_all(self, &mut products);
        products
    }

    /// Moves from the multipliers before by p ← α d + β p.
    pub(crate) fn steer_course(&mut self, shares: [f32; 2]) {
        steer_all(self, shares);
    }
}

in_lanes!(apply_all, apply, (lanes: &JointLanes, velocities: &mut [BodyVelocity]));
in_lanes!(weigh_all, weigh, (lanes: &JointLanes, products: &mut [f64; 2]));
in_lanes!(steer_all, steer, (lanes: &mut JointLanes, shares: [f32; 2]));

#[inline(always)]
fn apply<W: Wide>(lanes: &JointLanes, velocities: &mut [BodyVelocity]) {
    let JointLanes { points, search, .. } = lanes;
    for (block, direction_entry) in points.iter().zip(&search.points) {
        let torque = block.directions.map(|number| &search.directions[number as usize].way);
        sweep::apply::<W>(block, &direction_entry.way, torque, velocities);
    }
}

#[inline(always)]
fn weigh<W: Wide>(lanes: &JointLanes, products: &mut [f64; 2]) {
    let JointLanes { points, directions, search, .. } = lanes;
    let mut sums = [W::zero(); 2];
    for (block, direction_entry) in points.iter().zip(&search.points) {
        weigh_block(direction_entry, &block.impulse, &block.bias, &mut sums);
    }
    for (block, direction_entry) in directions.iter().zip(&search.directions) {
        weigh_block(direction_entry, &block.impulse, &block.bias, &mut sums);
    }
    for (sum, product) in sums.into_iter().zip(products) {
        let mut lane = [0.0; 8];
        sum.store(&mut lane);
        *product = lane.iter().map(|&lane| f64::from(lane)).sum();
    }
}

#[inline(always)]
fn weigh_block<W: Wide>(direction_entry: &JointDirectionEntry, impulse: &Lane3, bias: &Lane3, sums: &mut [W; 2]) {
    let bias = Wide3::<W>::load(bias);
    sums[0] = sums[0] + bias.dot(Wide3::load(impulse) - Wide3::load(&direction_entry.before));
    sums[1] = sums[1] + bias.dot(Wide3::load(&direction_entry.way));
}

#[inline(always)]
fn steer<W: Wide>(lanes: &mut JointLanes, shares: [f32; 2]) {
    let JointLanes { points, directions, search, .. } = lanes;
    for (block, direction_entry) in points.iter_mut().zip(&mut search.points) {
        steer_block::<W>(direction_entry, &mut block.impulse, shares);
    }
    for (block, direction_entry) in directions.iter_mut().zip(&mut search.directions) {
        steer_block::<W>(direction_entry, &mut block.impulse, shares);
    }
}

#[inline(always)]
fn steer_block<W: Wide>(direction_entry: &mut JointDirectionEntry, impulse: &mut Lane3, shares: [f32; 2]) {
    let before = Wide3::<W>::load(&direction_entry.before);
    let change = Wide3::load(impulse) - before;
    let way = change * W::splat(shares[0]) + Wide3::load(&direction_entry.way) * W::splat(shares[1]);
    way.store(&mut direction_entry.way);
    (before + way).store(impulse);
}
