//! Contacts of round features that their bodies swing about: tips of tops, rims of coins and of wheels out of true.
//!
//! A row has one lever for a step. Where a body turns by a good part of a radian in a substep, that is the lever of another moment: the tip of
//! a top goes round the middle of the top as it precesses, and a lever that lags by δ turns a part δ of gravity's torque into spin. And with
//! the right lever too a row holds at the start of a substep, while the angular velocity turns with the body until its end. Both go one way
//! in each step: at 60 steps a second a top of 100 rad/s that should precess for ever gained a quarter of its energy in ten seconds.
//!
//! So these rows have their levers r of each substep's start, on the feature's middle, which goes with the body (*collide/round_features.rs*), and hold
//! at its end. With r' and ω' at the end, of the rotation that nothing acts on within the substep, the normal row asks for
//!
//! ```text
//! n·(v + ω×r + d) ≥ 0,    d = (r' − r)/h − ω×r,
//! ```
//!
//! which is what the gap changes by, to all orders; and the rows of friction for no slip of the material at the contact in the mean,
//!
//! ```text
//! v + ω×r + ½ (ω'×r' − ω×r) = 0.
//! ```
//!
//! Both are found anew before each sweep. They are nothing where a feature is not swung: what rolls about its own axis has r' = r, ω' = ω.

use glam::{DQuat, DVec3};

use super::contact::ContactInput;
use super::contact_block::ContactBlocks;
use super::contact_kernels;
use super::rotation;
use super::state::{BodyMotion, BodyVelocity};
use crate::collide::round_features::RoundFeature;

/// Points of a manifold that may be round: the two ends of a line.
pub(crate) const ROUND_POINTS: usize = 2;

/// The features of one side at the points of a manifold; none where one is not round.
pub(crate) type RoundPoints = Option<[RoundFeature; ROUND_POINTS]>;

/// One point of a side that swings.
#[derive(Debug, Clone, Copy)]
struct RoundPoint {
    feature: RoundFeature,
    /// Lever, and that of the feature's middle, at the start of the step (m).
    began: DVec3,
    middle: DVec3,
}

/// A side of a contact whose features swing.
#[derive(Debug, Clone, Copy)]
struct RoundSide {
    slot: u32,
    /// Sign of the side's motion in that of the gap, and the outward normal.
    sign: f64,
    outward: DVec3,
    /// Inverse of the body's rotation at the start of the step.
    back: DQuat,
    points: [RoundPoint; ROUND_POINTS],
}

#[derive(Debug, Clone, Copy)]
struct RoundContact {
    block: usize,
    lane: usize,
    count: usize,
    normal: DVec3,
    sides: [Option<RoundSide>; 2],
    /// Separations at the start of the step (m), and what the points close at by their gaps in this substep (m/s).
    separation: [f32; ROUND_POINTS],
    closing_speed: [f32; ROUND_POINTS],
}

/// Those of a batch.
#[derive(Debug, Default)]
pub(crate) struct RoundContacts {
    list: Vec<RoundContact>,
}

impl RoundSide {
    fn new(slot: u32, sign: f64, input: &ContactInput, features: [RoundFeature; ROUND_POINTS], motion: &BodyMotion) -> Self {
        let levers = if sign > 0.0 { &input.lever_b } else { &input.lever_a };
        let outward = input.normal.as_dvec3() * -sign;
        let points = std::array::from_fn(|i| {
            let (feature, began) = (features[i], levers[i].as_dvec3());
            RoundPoint { feature, began, middle: began - feature.reach(DQuat::IDENTITY, outward) }
        });
        Self { slot, sign, outward, back: rotation_of(motion).conjugate(), points }
    }

    /// Lever of a point with the body at this rotation (m).
    fn lever(&self, point: usize, rotation: DQuat) -> DVec3 {
        let (turn, RoundPoint { feature, middle, .. }) = (rotation * self.back, &self.points[point]);
        turn * *middle + feature.reach(turn, self.outward)
    }
}

impl RoundSide {
    /// From the feature's middle to the point with the body at this rotation (m).
    fn reach(&self, point: usize, rotation: DQuat) -> DVec3 {
        self.points[point].feature.reach(rotation * self.back, self.outward)
    }
}

impl RoundContacts {
    pub(crate) fn clear(&mut self) {
        self.list.clear();
    }

    /// Takes the manifold in lane `lane` of a block, with what is round of its two sides.
    pub(crate) fn add(
        &mut self,
        (block, lane): (u32, u32),
        input: &ContactInput,
        features: [RoundPoints; 2],
        motions: &[BodyMotion],
    ) {
        let slots = [input.a, input.b];
        let sides = [0, 1].map(|side| {
            let motion = &motions[slots[side] as usize];
            let sign = if side == 1 { 1.0 } else { -1.0 };
            features[side].filter(|_| motion.is_dynamic()).map(|own| RoundSide::new(slots[side], sign, input, own, motion))
        });
        self.list.push(RoundContact {
            block: block as usize,
            lane: lane as usize,
            count: input.count,
            normal: input.normal.as_dvec3(),
            sides,
            separation: [input.separation[0], input.separation[1]],
            closing_speed: [0.0; ROUND_POINTS],
        });
    }

    /// Gives rows the levers that they have with the bodies where they are now, and with them their separations and effective masses.
    pub(crate) fn place(&self, contacts: &mut ContactBlocks, velocities: &[BodyVelocity], motions: &[BodyMotion]) {
        for contact in &self.list {
            let &RoundContact { block, lane, normal, .. } = contact;
            for point in 0..contact.count {
                let mut separation = f64::from(contact.separation[point]);
                for (number, side) in contact.sides.iter().enumerate() {
                    let Some(side) = side else { continue };
                    let motion = &motions[side.slot as usize];
                    let lever = side.lever(point, rotation_of(motion));
                    contacts.set_lever(block, lane, (point, number), lever.as_vec3());
                    // Rows add what the lever makes of the turn.
                    let linear = motion.turn.as_dvec3().cross(lever);
                    separation += side.sign * normal.dot(lever - side.points[point].began - linear);
                }
                contacts.rows_mut(block, point).separation[lane] = separation as f32;
            }
            contacts.recenter(block, lane);
            contact_kernels::set_masses(&mut contacts.whole(block), velocities);
        }
    }

    /// Has the rows of a substep of length `h` (s) hold at its end, with velocities as they are now; `is_first` where closing speeds are
    /// those of gaps alone.
    pub(crate) fn aim(
        &mut self,
        contacts: &mut ContactBlocks,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        h: f32,
        is_first: bool,
    ) {
        for contact in &mut self.list {
            let (block, lane, count) = (contact.block, contact.lane, contact.count);
            let (mut rates, mut slip) = ([0.0; ROUND_POINTS], DVec3::ZERO);
            for side in contact.sides.iter().flatten() {
                let (velocity, motion) = (&velocities[side.slot as usize], &motions[side.slot as usize]);
                let (now, angular) = (rotation_of(motion), velocity.angular.as_dvec3());
                let then = rotation::turn(now, angular, &motion.top(), f64::from(h));
                for (point, rate) in rates.iter_mut().enumerate().take(count) {
                    let levers = [side.lever(point, now), side.lever(point, then.rotation)];
                    // Where it is another point by then, as on the rim of what falls flat, it is not this one that swings there. Held to
                    // it, a cone that flew against a ball came off with five times its energy.
                    let [before, after] = [now, then.rotation].map(|rotation| side.reach(point, rotation));
                    let carried = then.rotation * now.conjugate() * before;
                    if carried.dot(after) < 0.5 * before.length_squared() {
                        continue;
                    }
                    let swung = angular.cross(levers[0]);
                    *rate += side.sign * contact.normal.dot((levers[1] - levers[0]) / f64::from(h) - swung);
                    slip += (then.angular.cross(levers[1]) - swung) * (0.5 * side.sign / count as f64);
                }
            }
            for (point, rate) in rates.into_iter().enumerate().take(count) {
                let closing_speed = &mut contacts.rows_mut(block, point).closing_speed[lane];
                if is_first {
                    contact.closing_speed[point] = *closing_speed;
                }
                *closing_speed = contact.closing_speed[point] + rate as f32;
            }
            contacts.lean_by(block, lane, slip.as_vec3());
        }
    }
}

fn rotation_of(motion: &BodyMotion) -> DQuat {
    motion.rotation.as_dquat().normalize()
}
