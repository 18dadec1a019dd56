//! Sums the pushes on a unit of bodies, and weighs them against its load.

use std::ops::Range;

use glam::{DVec3, Mat3, Vec3};

use crate::collide::pairs::{PairKey, WorldManifold};
use crate::contact::ContactImpulses;
use crate::joint_graph::support::cone::Carriers;
use crate::tuning::thrust::{SPREAD_SHARE, UNBALANCED_SHARE};

/// Bodies that joints tie together, or a single one, about the centre of mass of the lowest; impulses are those of a substep.
#[derive(Debug)]
pub(super) struct Unit {
    pub root: u32,
    pub center: DVec3,
    pub reach: f32,
    /// Of its weight (N·s, N·m·s).
    pub weight: Vec3,
    pub moment: Vec3,
    pub stands: bool,
    pub lost_a_push: bool,
    /// Its pushes.
    pub pushes: Range<u32>,
    /// Pushes that can carry it by themselves, once they had to be looked for.
    pub carriers: Option<Carriers>,
}

/// A manifold that pushes a unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Push {
    pub unit: u32,
    pub key: PairKey,
    pub manifold: u32,
    pub face: u32,
    pub from: Pusher,
    /// Whether projection knows nothing of it.
    pub leans: bool,
    pub is_on_b: bool,
    pub is_lost: bool,
}

/// What pushes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pusher {
    /// Ground, or supported.
    Firm,
    Unit(u32),
    /// Not held up, as far as is known.
    Loose,
}

/// A manifold that pushes two bodies.
#[derive(Debug)]
pub(super) struct PushFace {
    pub world: WorldManifold,
    pub count: usize,
    pub impulses: ContactImpulses,
    pub friction: f32,
    pub bodies: [u32; 2],
}

/// What pushes a unit, summed up.
#[derive(Debug, Default)]
pub(super) struct Sum {
    pub force: Vec3,
    pub moment: Vec3,
    /// Over points: normal impulse, times place, times place twice.
    pub pressed: f32,
    pub middle: Vec3,
    pub spread: Mat3,
    /// Whether anything pushes it that projection knows nothing of.
    pub leans: bool,
}

impl Unit {
    pub fn new(root: u32, center: DVec3) -> Self {
        Self {
            root,
            center,
            reach: 0.0,
            weight: Vec3::ZERO,
            moment: Vec3::ZERO,
            stands: true,
            lost_a_push: false,
            pushes: 0..0,
            carriers: None,
        }
    }
}

impl Sum {
    pub fn add(&mut self, force: Vec3, moment: Vec3, points: impl Iterator<Item = (Vec3, f32)>) {
        self.force += force;
        self.moment += moment;
        for (place, impulse) in points {
            self.pressed += impulse;
            self.middle += place * impulse;
            self.spread += Mat3::from_cols(place * place.x, place * place.y, place * place.z) * impulse;
        }
    }

    /// Whether it and the weight of a unit are an equilibrium.
    pub fn balances(&self, unit: &Unit) -> bool {
        let limit = UNBALANCED_SHARE * unit.weight.length();
        let (force, moment) = (self.force + unit.weight, self.moment + unit.moment);
        limit > 0.0 && force.length() <= limit && moment.length() <= limit * unit.reach
    }

    /// Whether the points reach out in two directions. Of the spread's eigenvalues a ≥ b ≥ c this takes
    /// (ab + ac + bc) / (a + b + c), which is b where c is zero, and at least b/2.
    pub fn is_spread(&self, reach: f32) -> bool {
        let middle = self.middle / self.pressed;
        let about = |i: usize, j: usize| self.spread.col(j)[i] / self.pressed - middle[i] * middle[j];
        let trace = about(0, 0) + about(1, 1) + about(2, 2);
        let minor = |i: usize, j: usize| about(i, i) * about(j, j) - about(i, j) * about(i, j);
        let least = SPREAD_SHARE * reach;
        minor(0, 1) + minor(0, 2) + minor(1, 2) > least * least * trace
    }
}

impl PushFace {
    pub fn levers(&self, on_b: bool) -> &[Vec3] {
        &(if on_b { &self.world.lever_b } else { &self.world.lever_a })[..self.count]
    }
}
