//! One pass of momentum down a stack: what sweeps would carry through one contact at a time.
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
//!    does nothing.
//!
//! Only contacts whose friction cone holds the vertical take part. Momentum across gravity counts as much as along it: friction has a
//! moment at every storey, and left to the sweeps it makes the multipliers that are carried over a spring on which a tower sways.
//!
//! The pass is for islands that are being put together: with a body younger than [`YOUNG_STEPS`], and in which nothing has moved fast
//! across gravity of late (thrown things are not stopped by handing their momentum straight down). How fast things fall does not
//! matter.

mod patch;

use glam::{DVec3, Vec3};

use super::batch::Batch;
use super::contact::{LANES, tangents};
use super::contact_block::ContactBlocks;
use super::state::WORLD_SLOT;
use crate::balance::{BoundedPoint, adjust};
use patch::{Patch, Point, rows_of};

/// Least number of storeys for which the pass is worth its time.
const MIN_STOREYS: u32 = 3;

/// Speed across gravity above which an island is left to the sweeps, as the time in which gravity would give it (s).
const SIDEWAYS_TIME: f32 = 0.05;

/// Age up to which a body is being put where it is (steps).
pub(crate) const YOUNG_STEPS: u8 = 240;

/// Steps for which nothing in an island may have moved so fast: no less than what is thrown is young.
pub(crate) const STEADY_STEPS: u8 = 240;

/// Least energy that the pass must take out of an island, as a share of what gravity puts into it in a substep: the sweeps do as well
/// with less, and leave a stack that is loaded already as it is.
const WORTHWHILE_SHARE: f64 = 1.0e-6;

/// The points of a batch in order, and buffers.
#[derive(Debug, Default)]
pub(crate) struct LoadPass {
    /// Sorted by upper body, as are the points.
    patches: Vec<Patch>,
    points: Vec<Point>,
    /// First patch of each slot.
    first: Vec<u32>,
    /// Slots that stand on something, upper before lower.
    order: Vec<u32>,
    waiting: Vec<u32>,
    storey: Vec<u32>,
    targets: Vec<Vec3>,
    /// Momentum and angular momentum handed down to each slot.
    carried: Vec<(DVec3, DVec3)>,
    /// Changes of the points' multipliers, and of friction on the upper bodies.
    deltas: Vec<f32>,
    rubs: Vec<Vec3>,
    /// Points whose multipliers change: many are apart.
    changed: Vec<u32>,
    /// Changes of linear and angular velocity.
    changes: Vec<(Vec3, Vec3)>,
    bounded: Vec<BoundedPoint>,
    places: Vec<u32>,
    axes: [Vec3; 3],
    /// Island of each slot; of those after the last island, none.
    island: Vec<u32>,
    /// Of each island: whether the pass is for it, its number of storeys, and the slope and curvature along the changes.
    islands: Vec<Island>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Island {
    /// Whether nothing in it moves fast across gravity now.
    is_slow: bool,
    /// Whether that has been so for long enough.
    is_steady: bool,
    /// Whether any body in it is young.
    is_young: bool,
    storeys: u32,
    slope: f64,
    curvature: f64,
    /// Energy that the pass must take out to be worthwhile (J).
    worthwhile: f64,
}

impl Island {
    fn is_useful(&self) -> bool {
        self.is_steady && self.is_young && self.storeys >= MIN_STOREYS
    }

    /// Share of the changes at which the energy is least; written so that what is not a number changes nothing.
    fn share(&self) -> f32 {
        let descends = self.curvature > 0.0 && self.slope < 0.0;
        let share = (-self.slope / self.curvature).min(1.0);
        let gain = -share * (self.slope + 0.5 * share * self.curvature);
        if self.is_useful() && descends && gain > self.worthwhile { share as f32 } else { 0.0 }
    }
}

/// Share of what a body asks of its points that they may leave undone for it to be balanced on them.
const UNBALANCED_SHARE: f64 = 0.1;

/// Island of slots that belong to none: the world's, and those of kinematic bodies.
const NO_ISLAND: u32 = u32::MAX;

impl LoadPass {
    /// Forgets the islands of the last step.
    pub(crate) fn clear(&mut self) {
        self.points.clear();
        self.patches.clear();
        self.order.clear();
        self.islands.clear();
        self.island.clear();
    }

    /// Lists the points and the order of the step.
    pub(crate) fn prepare(&mut self, batch: &Batch, gravity: Vec3, h: f32) {
        self.clear();
        let Some(up) = (-gravity).try_normalize() else { return };
        let (u, v) = tangents(up);
        self.axes = [up, u, v];
        self.find_slow_islands(batch, SIDEWAYS_TIME * gravity.length(), h);
        if !self.islands.iter().any(|island| island.is_steady && island.is_young) {
            return;
        }
        for number in 0..batch.contacts.len() {
            for lane in 0..LANES {
                self.list_patch(&batch.contacts, number as u32, lane);
            }
        }
        self.patches.sort_unstable_by_key(|patch| (patch.upper, patch.block, patch.lane));
        self.list_points(batch);
        let slots = batch.velocities.len();
        self.first.clear();
        self.first.resize(slots + 1, 0);
        self.waiting.clear();
        self.waiting.resize(slots, 0);
        for patch in &self.patches {
            self.first[patch.upper as usize + 1] += 1;
            self.waiting[patch.lower as usize] += 1;
        }
        for slot in 0..slots {
            self.first[slot + 1] += self.first[slot];
        }
        self.put_in_order(slots);
    }

    /// Whether nothing in the island of a slot moves fast across gravity.
    pub(crate) fn is_slow(&self, slot: usize) -> bool {
        self.island.get(slot).and_then(|&island| self.islands.get(island as usize)).is_none_or(|island| island.is_slow)
    }

    fn find_slow_islands(&mut self, batch: &Batch, limit: f32, h: f32) {
        self.islands.resize(batch.islands.len(), Island { is_slow: true, is_steady: true, ..Island::default() });
        self.island.resize(batch.velocities.len(), NO_ISLAND);
        for (number, &first) in batch.islands.iter().enumerate() {
            let next = batch.islands.get(number + 1).map_or(batch.velocities.len(), |&next| next as usize);
            for slot in first as usize..next {
                if batch.motions[slot].is_dynamic() {
                    self.island[slot] = number as u32;
                    let sideways = batch.velocities[slot].linear.reject_from_normalized(self.axes[0]);
                    self.islands[number].is_slow &= sideways.length_squared() < limit * limit;
                    // The pass knows contacts alone: a load that a joint takes would be handed down a second time.
                    self.islands[number].is_steady &= batch.motions[slot].steady && !batch.motions[slot].jointed;
                    let gained = f64::from(batch.motions[slot].acceleration.length() * h);
                    let mass = 1.0 / f64::from(batch.velocities[slot].inverse_mass.max_element());
                    self.islands[number].worthwhile += WORTHWHILE_SHARE * 0.5 * mass * gained * gained;
                    self.islands[number].is_young |= batch.motions[slot].young;
                }
            }
            self.islands[number].is_steady &= self.islands[number].is_slow;
        }
    }

    fn list_patch(&mut self, contacts: &ContactBlocks, number: u32, lane: usize) {
        let Some(patch) = Patch::of(contacts, number, lane, self.axes[0]) else { return };
        let island = self.island[patch.upper as usize];
        if island != NO_ISLAND && self.islands[island as usize].is_steady && self.islands[island as usize].is_young {
            self.patches.push(patch);
        }
    }

    fn list_points(&mut self, batch: &Batch) {
        for patch in &mut self.patches {
            patch.list_points(batch, &self.axes, &mut self.points);
        }
    }

    /// Upper before lower; in circles, those that wait for each other are left out.
    fn put_in_order(&mut self, slots: usize) {
        self.order.clear();
        self.storey.clear();
        self.storey.resize(slots, 1);
        for slot in 1..slots as u32 {
            if self.waiting[slot as usize] == 0 && self.stands(slot) {
                self.order.push(slot);
            }
        }
        let mut next = 0;
        while next < self.order.len() {
            let slot = self.order[next];
            next += 1;
            let storey = self.storey[slot as usize];
            let island = &mut self.islands[self.island[slot as usize] as usize];
            island.storeys = island.storeys.max(storey);
            for number in self.range(slot) {
                let lower = self.patches[number].lower;
                if lower == WORLD_SLOT {
                    continue;
                }
                let (waiting, below) = (&mut self.waiting[lower as usize], &mut self.storey[lower as usize]);
                *below = (*below).max(storey + 1);
                *waiting -= 1;
                if *waiting == 0 && self.stands(lower) {
                    self.order.push(lower);
                }
            }
        }
        if !self.islands.iter().any(Island::is_useful) {
            self.order.clear();
        }
    }

    fn stands(&self, slot: u32) -> bool {
        !self.range(slot).is_empty()
    }

    fn range(&self, slot: u32) -> std::ops::Range<usize> {
        self.first[slot as usize] as usize..self.first[slot as usize + 1] as usize
    }

    /// Whether nothing in the batch stands so that momentum is passed down.
    pub(crate) fn is_idle(&self) -> bool {
        self.order.is_empty()
    }

    /// Passes the momentum of the substep down.
    pub(crate) fn apply(&mut self, batch: &mut Batch) {
        self.read_points(batch);
        self.find_targets(batch);
        self.hand_down(batch);
        self.list_changed();
        self.take_the_best_share(batch);
    }

    /// Takes multipliers and closing speeds of now from the blocks: each is asked for several times.
    fn read_points(&mut self, batch: &Batch) {
        for point in &mut self.points {
            let rows = batch.contacts.rows(point.block as usize, point.index as usize);
            (point.lambda, point.closing_speed) = (rows.lambda[point.lane as usize], rows.closing_speed[point.lane as usize]);
        }
    }

    /// Whether a point of an upper body that can keep `target` presses or closes in.
    fn takes_part(&self, batch: &Batch, point: &Point) -> Option<f32> {
        let up = self.axes[0];
        let velocity = &batch.velocities[point.upper as usize];
        let allowed = self.targets[point.lower as usize].dot(up) - point.closing_speed;
        let speed = (velocity.linear + velocity.angular.cross(point.lever_upper)).dot(up);
        (speed < allowed || point.lambda > 0.0).then_some(allowed)
    }

    /// Velocity that every body can keep.
    fn find_targets(&mut self, batch: &Batch) {
        let up = self.axes[0];
        self.targets.clear();
        self.targets.extend(batch.velocities.iter().map(|velocity| velocity.linear));
        for place in (0..self.order.len()).rev() {
            let slot = self.order[place];
            let (mut sum, mut count) = (0.0, 0.0);
            let (mut along, mut load) = (Vec3::ZERO, 0.0);
            for patch in &self.patches[self.range(slot)] {
                for point in &self.points[patch.points()] {
                    if let Some(allowed) = self.takes_part(batch, point) {
                        sum += allowed;
                        count += 1.0;
                    }
                    along += self.targets[patch.lower as usize] * point.lambda;
                    load += point.lambda;
                }
            }
            let target = &mut self.targets[slot as usize];
            let aside = if load > 0.0 { along / load } else { *target };
            let rise = if count > 0.0 { sum / count } else { target.dot(up) };
            *target = aside.reject_from_normalized(up) + up * rise;
        }
    }

    /// Changes of multipliers that give every body its velocity, from the top.
    fn hand_down(&mut self, batch: &Batch) {
        self.deltas.clear();
        self.deltas.resize(self.points.len(), 0.0);
        self.rubs.clear();
        self.rubs.resize(self.patches.len(), Vec3::ZERO);
        self.carried.clear();
        self.carried.resize(batch.velocities.len(), (DVec3::ZERO, DVec3::ZERO));
        let up = self.axes[0].as_dvec3();
        for place in 0..self.order.len() {
            let slot = self.order[place] as usize;
            let (velocity, motion) = (&batch.velocities[slot], &batch.motions[slot]);
            let mass = 1.0 / velocity.inverse_mass.max_element();
            let push = (mass * (self.targets[slot] - velocity.linear)).as_dvec3() + self.carried[slot].0;
            let turn = self.carried[slot].1 - motion.angular_momentum(velocity.angular).as_dvec3();
            self.share_friction(slot as u32, push - up * push.dot(up));
            if !self.adjust_points(batch, slot as u32, push, turn) {
                // It turns over the edge of what is under it: the edge rests then, not the centre of mass.
                let range = self.range(slot as u32);
                self.rubs[range].fill(Vec3::ZERO);
                self.adjust_points(batch, slot as u32, push, turn);
            }
            self.hand_on(batch, slot as u32);
        }
    }

    /// Finds changes of the multipliers under a body that, with its friction, add up to a push and a turn, as nearly as pushing can;
    /// says whether they do.
    fn adjust_points(&mut self, batch: &Batch, slot: u32, mut push: DVec3, mut turn: DVec3) -> bool {
        self.bounded.clear();
        self.places.clear();
        for number in self.range(slot) {
            let patch = &self.patches[number];
            let rub = self.rubs[number].as_dvec3();
            push -= rub;
            turn -= patch.center_upper.as_dvec3().cross(rub);
            for place in patch.points() {
                let point = &self.points[place];
                if self.takes_part(batch, point).is_some() {
                    self.bounded.push(BoundedPoint::new(point.column, -f64::from(point.lambda)));
                    self.places.push(place as u32);
                }
            }
        }
        let demand = rows_of(&batch.velocities[slot as usize], &self.axes, push.as_vec3(), turn.as_vec3());
        adjust(&mut self.bounded, demand);
        let mut left = demand;
        for (&place, bounded) in self.places.iter().zip(&self.bounded) {
            self.deltas[place as usize] = bounded.change as f32;
            left -= self.points[place as usize].column * bounded.change;
        }
        left.length_squared() <= UNBALANCED_SHARE * UNBALANCED_SHARE * demand.length_squared()
    }

    /// Friction that takes momentum across gravity, on every manifold by the load that it bears.
    fn share_friction(&mut self, slot: u32, push: DVec3) {
        let pressed = |patch: &Patch| self.points[patch.points()].iter().map(|point| point.lambda).sum::<f32>();
        let load: f32 = self.patches[self.range(slot)].iter().map(pressed).sum();
        if load > 0.0 {
            for number in self.range(slot) {
                let patch = &self.patches[number];
                let share = push.as_vec3() * (pressed(patch) / load);
                let [t1, t2] = patch.tangents;
                self.rubs[number] = t1 * share.dot(t1) + t2 * share.dot(t2);
            }
        }
    }

    /// Cuts friction to what the new load allows, and hands everything to the bodies below.
    fn hand_on(&mut self, batch: &Batch, slot: u32) {
        for number in self.range(slot) {
            let patch = &self.patches[number];
            let mut load = 0.0;
            let carried = &mut self.carried[patch.lower as usize];
            for place in patch.points() {
                let (point, delta) = (&self.points[place], self.deltas[place]);
                load += point.lambda + delta;
                let push = (point.normal * delta).as_dvec3();
                carried.0 += push;
                carried.1 += point.lever_lower.as_dvec3().cross(push);
            }
            let before = patch.rubbed(batch);
            let rub = (before + self.rubs[number]).clamp_length_max(patch.friction * load.max(0.0)) - before;
            self.rubs[number] = rub;
            carried.0 += rub.as_dvec3();
            carried.1 += patch.center_lower.as_dvec3().cross(rub.as_dvec3());
        }
    }

    /// Lists the points that change, without a branch: which do follows no pattern, and they are gone through four times.
    fn list_changed(&mut self) {
        self.changed.clear();
        self.changed.resize(self.deltas.len(), 0);
        let mut count = 0;
        for (place, &delta) in self.deltas.iter().enumerate() {
            self.changed[count] = place as u32;
            count += usize::from(delta != 0.0);
        }
        self.changed.truncate(count);
    }

    fn changed_points(&self) -> impl Iterator<Item = (&Point, f32)> {
        self.changed.iter().map(|&place| (&self.points[place as usize], self.deltas[place as usize]))
    }

    /// What changes at one place between two bodies: upper and lower slot, levers, and the impulse on the upper one.
    fn pushes(&self) -> impl Iterator<Item = ([usize; 2], [Vec3; 2], Vec3)> {
        self.changed_points()
            .map(|(point, delta)| {
                let ends = [point.upper as usize, point.lower as usize];
                (ends, [point.lever_upper, point.lever_lower], point.normal * delta)
            })
            .chain(self.patches.iter().zip(&self.rubs).map(|(patch, &rub)| {
                ([patch.upper as usize, patch.lower as usize], [patch.center_upper, patch.center_lower], rub)
            }))
    }

    /// Applies the share of the changes at which the rows' energy is least.
    fn take_the_best_share(&mut self, batch: &mut Batch) {
        let mut changes = std::mem::take(&mut self.changes);
        changes.clear();
        changes.resize(batch.velocities.len(), (Vec3::ZERO, Vec3::ZERO));
        for (ends, levers, push) in self.pushes() {
            for ((slot, lever), push) in ends.into_iter().zip(levers).zip([push, -push]) {
                let velocity = &batch.velocities[slot];
                changes[slot].0 += velocity.inverse_mass * push;
                changes[slot].1 += velocity.inverse_inertia.mul(lever.cross(push));
            }
        }
        let mut islands = std::mem::take(&mut self.islands);
        for island in &mut islands {
            (island.slope, island.curvature) = (0.0, 0.0);
        }
        for (ends, levers, push) in self.pushes() {
            let power = |upper: (Vec3, Vec3), lower: (Vec3, Vec3)| {
                f64::from(push.dot((upper.0 + upper.1.cross(levers[0])) - (lower.0 + lower.1.cross(levers[1]))))
            };
            let now = |slot: usize| (batch.velocities[slot].linear, batch.velocities[slot].angular);
            let island = &mut islands[self.island[ends[0]] as usize];
            island.slope += power(now(ends[0]), now(ends[1]));
            island.curvature += power(changes[ends[0]], changes[ends[1]]);
        }
        for (point, delta) in self.changed_points() {
            let island = &mut islands[self.island[point.upper as usize] as usize];
            island.slope += f64::from(delta * point.closing_speed);
        }
        (self.changes, self.islands) = (changes, islands);
        self.apply_shares(batch);
    }

    fn apply_shares(&self, batch: &mut Batch) {
        let share_of = |slot: u32| self.islands[self.island[slot as usize] as usize].share();
        for (slot, change) in self.changes.iter().enumerate().filter(|&(slot, _)| self.island[slot] != NO_ISLAND) {
            let share = share_of(slot as u32);
            let velocity = &mut batch.velocities[slot];
            velocity.linear += change.0 * share;
            velocity.angular += change.1 * share;
        }
        for (point, delta) in self.changed_points() {
            let share = share_of(point.upper);
            let lambda = &mut batch.contacts.rows_mut(point.block as usize, point.index as usize).lambda[point.lane as usize];
            *lambda = (*lambda + delta * share).max(0.0);
        }
        for (patch, &rub) in self.patches.iter().zip(&self.rubs) {
            let on_b = rub * share_of(patch.upper) * if patch.upper_is_b { 1.0 } else { -1.0 };
            let block = &mut batch.contacts.blocks[patch.block as usize];
            for (lambda, tangent) in block.tangent_lambda.iter_mut().zip(patch.tangents) {
                lambda[patch.lane as usize] += on_b.dot(tangent);
            }
        }
    }
}
