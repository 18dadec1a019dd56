//! One pass of momentum down a stack: what sweeps would carry through one contact at a time.
//!
//! A block that falls by a gap, or a stack whose multipliers are not those of its loads, needs as many sweeps as it has storeys
//! before the ground answers. Before the sweeps of a substep this pass works out, for every body that stands on contacts,
//!
//! 1. *bottom up* the vertical speed that it can keep: t = mean over its closing points of t(below) − c, with c the closing speed
//!    that the gap allows (m/s); a body that nothing stops keeps its own;
//! 2. *top down* what must change: the momentum m (t − v·up) and the two horizontal angular momenta, with what came from above,
//!    split over the points below as changes δ of multipliers of least norm with λ + δ ≥ 0, and handed on;
//! 3. *how much of it is right*: the sweeps minimise ½ |v|² in the metric of mass, plus λ·c; along δ that is a parabola, whose least
//!    point in 0…1 is taken. So the pass never makes the state of the rows worse, and where it has nothing to offer it does nothing.
//!
//! Friction is left to the sweeps: only contacts whose friction cone holds the vertical take part. The pass knows nothing of what
//! friction holds up, and a damaged tower in which it went on slowly came down. So it is for islands that are being put together:
//! with a body younger than [`YOUNG_STEPS`], and in which nothing has moved fast across gravity of late (thrown things are not
//! stopped by handing their momentum straight down). How fast things fall does not matter.

use glam::{DVec3, Vec3};

use super::batch::Batch;
use super::contact::{ContactBlock, LANES, POINTS, tangents};
use super::state::WORLD_SLOT;
use crate::balance::{BoundedPoint, adjust};

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

/// A point through which `upper` stands on `lower`.
#[derive(Debug, Clone, Copy)]
struct Point {
    upper: u32,
    lower: u32,
    block: u32,
    lane: u8,
    index: u8,
    /// From lower to upper.
    normal: Vec3,
    lever_upper: Vec3,
    lever_lower: Vec3,
    /// Vertical force and two horizontal moments on the upper body per unit of λ.
    column: DVec3,
}

/// The points of a batch in order, and buffers.
#[derive(Debug, Default)]
pub(crate) struct LoadPass {
    /// Sorted by upper body.
    points: Vec<Point>,
    /// First point of each slot.
    first: Vec<u32>,
    /// Slots that stand on something, upper before lower.
    order: Vec<u32>,
    waiting: Vec<u32>,
    storey: Vec<u32>,
    targets: Vec<f32>,
    /// Momentum handed down to each slot: along up and about the two horizontal axes.
    carried: Vec<DVec3>,
    deltas: Vec<f32>,
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

/// Island of slots that belong to none: the world's, and those of kinematic bodies.
const NO_ISLAND: u32 = u32::MAX;

impl LoadPass {
    /// Lists the points and the order of the step.
    pub(crate) fn prepare(&mut self, batch: &Batch, gravity: Vec3, h: f32) {
        self.points.clear();
        self.order.clear();
        let Some(up) = (-gravity).try_normalize() else { return };
        let (u, v) = tangents(up);
        self.axes = [up, u, v];
        self.find_slow_islands(batch, SIDEWAYS_TIME * gravity.length(), h);
        if !self.islands.iter().any(|island| island.is_steady && island.is_young) {
            return;
        }
        for (number, block) in batch.contacts.iter().enumerate() {
            for lane in 0..LANES {
                self.list_points(block, number as u32, lane);
            }
        }
        self.points.sort_by_key(|point| point.upper);
        let slots = batch.velocities.len();
        self.first.clear();
        self.first.resize(slots + 1, 0);
        self.waiting.clear();
        self.waiting.resize(slots, 0);
        for point in &self.points {
            self.first[point.upper as usize + 1] += 1;
            self.waiting[point.lower as usize] += 1;
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
        self.islands.clear();
        self.islands.resize(batch.islands.len(), Island { is_slow: true, is_steady: true, ..Island::default() });
        self.island.clear();
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

    fn list_points(&mut self, block: &ContactBlock, number: u32, lane: usize) {
        let normal = block.normal_of(lane);
        let rise = normal.dot(self.axes[0]);
        let friction = block.friction[lane];
        // The vertical lies in the friction cone.
        if block.inverse_diagonal[0][lane] == 0.0 || rise * rise * (1.0 + friction * friction) < 1.0 {
            return;
        }
        let (a, b) = (block.a[lane], block.b[lane]);
        let (lower, upper, normal) = if rise > 0.0 { (a, b, normal) } else { (b, a, -normal) };
        let island = self.island[upper as usize];
        if island == NO_ISLAND || !(self.islands[island as usize].is_steady && self.islands[island as usize].is_young) {
            return;
        }
        for index in (0..POINTS).filter(|&index| block.inverse_diagonal[index][lane] > 0.0) {
            let (lever_a, lever_b) = block.levers_of(index, lane);
            let (lever_lower, lever_upper) = if rise > 0.0 { (lever_a, lever_b) } else { (lever_b, lever_a) };
            let moment = lever_upper.cross(normal);
            let [up, u, v] = self.axes;
            let column = Vec3::new(normal.dot(up), moment.dot(u), moment.dot(v)).as_dvec3();
            let (lane, index) = (lane as u8, index as u8);
            self.points.push(Point { upper, lower, block: number, lane, index, normal, lever_upper, lever_lower, column });
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
                let lower = self.points[number].lower;
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

    /// Passes the momentum of the substep down.
    pub(crate) fn apply(&mut self, batch: &mut Batch) {
        if self.order.is_empty() {
            return;
        }
        self.find_targets(batch);
        self.hand_down(batch);
        self.take_the_best_share(batch);
    }

    fn closing_speed(&self, batch: &Batch, point: &Point) -> f32 {
        batch.contacts[point.block as usize].closing_speed[point.index as usize][point.lane as usize]
    }

    fn lambda(batch: &Batch, point: &Point) -> f32 {
        batch.contacts[point.block as usize].lambda[point.index as usize][point.lane as usize]
    }

    /// Vertical speed that every body can keep.
    fn find_targets(&mut self, batch: &Batch) {
        let up = self.axes[0];
        self.targets.clear();
        self.targets.extend(batch.velocities.iter().map(|velocity| velocity.linear.dot(up)));
        for place in (0..self.order.len()).rev() {
            let slot = self.order[place];
            let velocity = &batch.velocities[slot as usize];
            let (mut sum, mut count) = (0.0, 0.0);
            for point in &self.points[self.range(slot)] {
                let allowed = self.targets[point.lower as usize] - self.closing_speed(batch, point);
                let speed = (velocity.linear + velocity.angular.cross(point.lever_upper)).dot(up);
                if speed < allowed || Self::lambda(batch, point) > 0.0 {
                    sum += allowed;
                    count += 1.0;
                }
            }
            if count > 0.0 {
                self.targets[slot as usize] = sum / count;
            }
        }
    }

    /// Changes of multipliers that give every body its speed, from the top.
    fn hand_down(&mut self, batch: &Batch) {
        self.deltas.clear();
        self.deltas.resize(self.points.len(), 0.0);
        self.carried.clear();
        self.carried.resize(batch.velocities.len(), DVec3::ZERO);
        let [up, u, v] = self.axes;
        for place in 0..self.order.len() {
            let slot = self.order[place] as usize;
            let (velocity, motion) = (&batch.velocities[slot], &batch.motions[slot]);
            self.bounded.clear();
            self.places.clear();
            for number in self.range(slot as u32) {
                let point = &self.points[number];
                let lambda = Self::lambda(batch, point);
                let allowed = self.targets[point.lower as usize] - self.closing_speed(batch, point);
                let speed = (velocity.linear + velocity.angular.cross(point.lever_upper)).dot(up);
                if speed < allowed || lambda > 0.0 {
                    self.bounded.push(BoundedPoint::new(point.column, -f64::from(lambda)));
                    self.places.push(number as u32);
                }
            }
            if self.places.is_empty() {
                continue;
            }
            let mass = 1.0 / velocity.inverse_mass.max_element();
            let spin = motion.angular_momentum(velocity.angular);
            let unbalanced = Vec3::new(mass * (self.targets[slot] - velocity.linear.dot(up)), -spin.dot(u), -spin.dot(v));
            adjust(&mut self.bounded, unbalanced.as_dvec3() + self.carried[slot]);
            for (&number, bounded) in self.places.iter().zip(&self.bounded) {
                let point = &self.points[number as usize];
                self.deltas[number as usize] = bounded.change as f32;
                let push = point.normal * bounded.change as f32;
                let moment = point.lever_lower.cross(push);
                self.carried[point.lower as usize] += Vec3::new(push.dot(up), moment.dot(u), moment.dot(v)).as_dvec3();
            }
        }
    }

    /// Applies the share of the changes at which the rows' energy is least.
    fn take_the_best_share(&mut self, batch: &mut Batch) {
        self.changes.clear();
        self.changes.resize(batch.velocities.len(), (Vec3::ZERO, Vec3::ZERO));
        for (point, &delta) in self.points.iter().zip(&self.deltas) {
            let push = point.normal * delta;
            for (slot, lever, push) in [(point.upper, point.lever_upper, push), (point.lower, point.lever_lower, -push)] {
                let velocity = &batch.velocities[slot as usize];
                let change = &mut self.changes[slot as usize];
                change.0 += velocity.inverse_mass * push;
                change.1 += velocity.inverse_inertia.mul(lever.cross(push));
            }
        }
        for island in &mut self.islands {
            (island.slope, island.curvature) = (0.0, 0.0);
        }
        for (point, &delta) in self.points.iter().zip(&self.deltas) {
            let rate = |linear: [Vec3; 2], angular: [Vec3; 2]| {
                let upper = linear[0] + angular[0].cross(point.lever_upper);
                let lower = linear[1] + angular[1].cross(point.lever_lower);
                point.normal.dot(upper - lower)
            };
            let ends = [point.upper as usize, point.lower as usize];
            let now = rate(ends.map(|slot| batch.velocities[slot].linear), ends.map(|slot| batch.velocities[slot].angular));
            let then = rate(ends.map(|slot| self.changes[slot].0), ends.map(|slot| self.changes[slot].1));
            let closing_speed = self.closing_speed(batch, point);
            let island = &mut self.islands[self.island[point.upper as usize] as usize];
            island.slope += f64::from(delta) * f64::from(now + closing_speed);
            island.curvature += f64::from(delta) * f64::from(then);
        }
        for (slot, change) in self.changes.iter().enumerate().filter(|&(slot, _)| self.island[slot] != NO_ISLAND) {
            let share = self.islands[self.island[slot] as usize].share();
            let velocity = &mut batch.velocities[slot];
            velocity.linear += change.0 * share;
            velocity.angular += change.1 * share;
        }
        for (point, &delta) in self.points.iter().zip(&self.deltas) {
            let share = self.islands[self.island[point.upper as usize] as usize].share();
            let lambda = &mut batch.contacts[point.block as usize].lambda[point.index as usize][point.lane as usize];
            *lambda = (*lambda + delta * share).max(0.0);
        }
    }
}
