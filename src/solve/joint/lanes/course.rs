//! The multipliers of all joints in lanes as one point, moved along two lines at once: what sheets are solved with (*sheet.rs*).

use glam::Vec3;

use super::{Holds, JointEntry, JointLanes, ZERO3, get, put, sweep};
use crate::lanes::wide::{Wide, Wide3};
use crate::platform::in_lanes;
use crate::solve::contact::{LANES, Lane3};
use crate::solve::shared::Slots;
use crate::solve::state::BodyVelocity;

/// Multipliers of a block before the last sweeps, and what the last move changed them by.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Station {
    before: Lane3,
    way: Lane3,
}

/// Stations of the blocks of [`JointLanes`], one for points and one for directions.
#[derive(Debug, Default)]
pub(super) struct Course {
    points: Vec<Station>,
    directions: Vec<Station>,
}

/// Greatest move that is remembered (N·s, N·m·s): beyond, its products with the lightest bodies are no numbers in `f32`.
const MOST_WAY: f32 = 1.0e10;

/// A move, or none where it is beyond all measure.
fn sane(way: Vec3) -> Vec3 {
    // Written so that one which is no number counts.
    if way.abs().cmple(Vec3::splat(MOST_WAY)).all() { way } else { Vec3::ZERO }
}

impl JointLanes {
    /// Begins a step: multipliers have last moved as the joints remember.
    pub(crate) fn begin_course(&mut self, entries: &[JointEntry]) {
        let Self { points, directions, course, .. } = self;
        for (stations, count) in [(&mut course.points, points.len()), (&mut course.directions, directions.len())] {
            stations.clear();
            stations.resize(count, Station { before: ZERO3, way: ZERO3 });
        }
        for (block, station) in points.iter().zip(&mut course.points) {
            for (l, &number) in block.numbers().iter().enumerate() {
                let entry = &entries[number as usize];
                put(&mut station.way, l, sane(entry.acted[0]));
                if let Some(number) = block.directions {
                    put(&mut course.directions[number as usize].way, l, sane(entry.acted[1]));
                }
            }
        }
    }

    /// Has the joints remember how multipliers moved last.
    pub(crate) fn end_course(&self, entries: &mut (impl Slots<JointEntry> + ?Sized)) {
        for (block, station) in self.points.iter().zip(&self.course.points) {
            for (l, &number) in block.numbers().iter().enumerate() {
                let entry = entries.get_mut(number);
                let turn = block.directions.map(|number| get(&self.course.directions[number as usize].way, l));
                entry.acted = [get(&station.way, l), turn.unwrap_or_default()].map(sane);
            }
        }
    }

    /// Notes the multipliers that sweeps begin with.
    pub(crate) fn note_course(&mut self) {
        let Self { points, directions, course, .. } = self;
        let note = |(station, impulse): (&mut Station, &Lane3)| station.before = *impulse;
        course.points.iter_mut().zip(points.iter().map(|block| &block.impulse)).for_each(note);
        course.directions.iter_mut().zip(directions.iter().map(|block| &block.impulse)).for_each(note);
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
        let Self { directions, course, .. } = self;
        for (block, station) in directions.iter().zip(&mut course.directions).filter(|(block, _)| block.holds == Holds::Axis) {
            for l in 0..LANES {
                let (way, axis) = (get(&station.way, l), get(&block.free_axis, l));
                put(&mut station.way, l, way - axis * axis.dot(way));
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
    let JointLanes { points, course, .. } = lanes;
    for (block, station) in points.iter().zip(&course.points) {
        let torque = block.directions.map(|number| &course.directions[number as usize].way);
        sweep::apply::<W>(block, &station.way, torque, velocities);
    }
}

#[inline(always)]
fn weigh<W: Wide>(lanes: &JointLanes, products: &mut [f64; 2]) {
    let JointLanes { points, directions, course, .. } = lanes;
    let mut sums = [W::zero(); 2];
    for (block, station) in points.iter().zip(&course.points) {
        weigh_block(station, &block.impulse, &block.bias, &mut sums);
    }
    for (block, station) in directions.iter().zip(&course.directions) {
        weigh_block(station, &block.impulse, &block.bias, &mut sums);
    }
    for (sum, product) in sums.into_iter().zip(products) {
        let mut lane = [0.0; 8];
        sum.store(&mut lane);
        *product = lane.iter().map(|&lane| f64::from(lane)).sum();
    }
}

#[inline(always)]
fn weigh_block<W: Wide>(station: &Station, impulse: &Lane3, bias: &Lane3, sums: &mut [W; 2]) {
    let bias = Wide3::<W>::load(bias);
    sums[0] = sums[0] + bias.dot(Wide3::load(impulse) - Wide3::load(&station.before));
    sums[1] = sums[1] + bias.dot(Wide3::load(&station.way));
}

#[inline(always)]
fn steer<W: Wide>(lanes: &mut JointLanes, shares: [f32; 2]) {
    let JointLanes { points, directions, course, .. } = lanes;
    for (block, station) in points.iter_mut().zip(&mut course.points) {
        steer_block::<W>(station, &mut block.impulse, shares);
    }
    for (block, station) in directions.iter_mut().zip(&mut course.directions) {
        steer_block::<W>(station, &mut block.impulse, shares);
    }
}

#[inline(always)]
fn steer_block<W: Wide>(station: &mut Station, impulse: &mut Lane3, shares: [f32; 2]) {
    let before = Wide3::<W>::load(&station.before);
    let change = Wide3::load(impulse) - before;
    let way = change * W::splat(shares[0]) + Wide3::load(&station.way) * W::splat(shares[1]);
    way.store(&mut station.way);
    (before + way).store(impulse);
}
