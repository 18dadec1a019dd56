//! The support patch of a body in the pass: the manifolds and points that it stands on.

use std::ops::{Add, Sub};

use std::ops::Range;

use glam::{DVec3, Vec3, Vec4};

use super::super::contact::{LANES, tangents};
use super::super::contact_block::{ContactBlock, ContactBlocks};
use super::super::state::BodyVelocity;
use crate::load_distribution::BoundedPoint;

/// Momentum (N·s) and angular momentum about the centre of mass of the body that it is handed to (N·m·s).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Impulse {
    pub linear: DVec3,
    pub angular: DVec3,
}

impl Add for Impulse {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

impl Sub for Impulse {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { linear: self.linear - other.linear, angular: self.angular - other.angular }
    }
}

impl Impulse {
    /// A force's, by its lever.
    pub(super) fn at(lever: Vec3, push: DVec3) -> Self {
        Self { linear: push, angular: lever.as_dvec3().cross(push) }
    }

    /// Its power at a velocity (J).
    pub(super) fn power(&self, linear: Vec3, angular: Vec3) -> f64 {
        self.linear.dot(linear.as_dvec3()) + self.angular.dot(angular.as_dvec3())
    }
}

/// A manifold through which `upper` stands on `lower`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct SupportedBody {
    pub upper: u32,
    pub lower: u32,
    /// Number of its points.
    pub points: u8,
    /// Whether the upper body is the block's B.
    upper_is_b: bool,
}

impl SupportedBody {
    /// Of a lane in which nothing stands on anything.
    pub(super) const NONE: Self = Self { upper: u32::MAX, lower: u32::MAX, points: 0, upper_is_b: false };

    pub(super) fn exists(&self) -> bool {
        self.upper != Self::NONE.upper
    }

    /// The manifold of a lane, if the vertical lies in its friction cone.
    pub(super) fn of(contacts: &ContactBlocks, block: usize, lane: usize, up: Vec3) -> Option<Self> {
        let own = &contacts.blocks[block];
        let rise = own.normal_of(lane).dot(up);
        let friction = own.friction[lane];
        if !own.is_movable(lane) || rise * rise * (1.0 + friction * friction) < 1.0 {
            return None;
        }
        let upper_is_b = rise > 0.0;
        let (a, b) = (own.a[lane], own.b[lane]);
        let (lower, upper) = if upper_is_b { (a, b) } else { (b, a) };
        let exists = |&point: &usize| contacts.rows(block, point).inverse_diagonal[lane] > 0.0;
        let points = (0..contacts.room_of(block)).filter(exists).count() as u8;
        Some(Self { upper, lower, points, upper_is_b })
    }

    /// Its points, from the centre of mass of the upper body (m).
    pub(super) fn levers(self, contacts: &ContactBlocks, block: usize, lane: usize) -> impl Iterator<Item = Vec3> {
        let exists = move |&point: &usize| contacts.rows(block, point).inverse_diagonal[lane] > 0.0;
        (0..contacts.room_of(block)).filter(exists).map(move |point| self.sorted(contacts.rows(block, point).levers_of(lane)).0)
    }

    /// Of something on A and on B, that on the upper body and that on the lower.
    fn sorted<T>(&self, (a, b): (T, T)) -> (T, T) {
        if self.upper_is_b { (b, a) } else { (a, b) }
    }
}

/// How far the points that a body stands on reach from its centre of mass, seen from above: along two axes and two diagonals (m).
#[derive(Debug, Clone, Copy)]
pub(super) struct Balance {
    least: Vec4,
    most: Vec4,
}

impl Balance {
    pub(super) const NONE: Self = Self { least: Vec4::INFINITY, most: Vec4::NEG_INFINITY };

    pub(super) fn add(&mut self, x: f32, y: f32) {
        let ways = Vec4::new(x, y, x + y, x - y);
        (self.least, self.most) = (self.least.min(ways), self.most.max(ways));
    }

    /// Whether its centre of mass is over them, so that it stands by itself. A card that leans on another does not.
    pub(super) fn is_balanced(&self) -> bool {
        self.least.cmple(Vec4::ZERO).all() && self.most.cmpge(Vec4::ZERO).all()
    }
}

/// Such a manifold, with its friction.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SupportPatch {
    pub stand: SupportedBody,
    /// Its lane among those of all blocks.
    pub all_lanes: u32,
    /// Place of the lower body among those that the pass is for, if it has one.
    pub below: u32,
    first: u32,
    /// From lower to upper.
    pub normal: Vec3,
    /// Its middle, from both centres of mass, and the directions of friction.
    pub center_upper: Vec3,
    pub center_lower: Vec3,
    pub tangents: [Vec3; 2],
    pub friction: f32,
    /// Change of friction on the upper body (N·s).
    pub rub: Vec3,
}

impl SupportPatch {
    /// A manifold whose points begin with the number `first`.
    pub(super) fn new(contacts: &ContactBlocks, all_lanes: u32, stand: &SupportedBody, below: u32, first: u32) -> Self {
        let (number, lane) = (all_lanes as usize / LANES, all_lanes as usize % LANES);
        let block = &contacts.blocks[number];
        let normal = block.normal_of(lane);
        let (center_upper, center_lower) = stand.sorted(contacts.centers_of(number, lane));
        Self {
            stand: *stand,
            all_lanes,
            below,
            first,
            normal: if stand.upper_is_b { normal } else { -normal },
            center_upper,
            center_lower,
            tangents: tangents(normal).into(),
            friction: block.friction[lane],
            ..Self::default()
        }
    }

    pub(super) fn block(&self) -> usize {
        self.all_lanes as usize / LANES
    }

    pub(super) fn lane(&self) -> usize {
        self.all_lanes as usize % LANES
    }

    pub(super) fn points(&self) -> Range<usize> {
        self.first as usize..self.first as usize + usize::from(self.stand.points)
    }

    /// Friction on the upper body now (N·s).
    pub(super) fn rubbed(&self, blocks: &[ContactBlock]) -> Vec3 {
        let (block, lane) = (&blocks[self.block()], self.lane());
        let [t1, t2] = self.tangents;
        let on_b = t1 * block.tangent_lambda[0][lane] + t2 * block.tangent_lambda[1][lane];
        if self.stand.upper_is_b { on_b } else { -on_b }
    }

    /// Change of friction along the tangents, as its rows have it.
    pub(super) fn rub_along_tangents(&self) -> [f32; 2] {
        let on_b = if self.stand.upper_is_b { self.rub } else { -self.rub };
        self.tangents.map(|tangent| on_b.dot(tangent))
    }
}

/// A point of a patch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PatchPoint {
    pub lever_upper: Vec3,
    pub lever_lower: Vec3,
    /// Of this substep; see [`PointRows`](super::super::contact_block::PointRows).
    pub lambda: f32,
    pub closing_speed: f32,
    /// Which of the rows of its block are its own.
    pub index: u8,
    /// Whether it presses, or closes in on what is below.
    pub takes_part: bool,
}

/// Describes the points of a patch of a body that is balanced in these rows.
pub(super) fn describe(
    contacts: &ContactBlocks,
    patch: &SupportPatch,
    rows: &BalanceRows,
    points: &mut [PatchPoint],
    bounded: &mut [BoundedPoint],
) {
    let SupportPatch { stand, normal, .. } = patch;
    let (block, lane) = (patch.block(), patch.lane());
    let all = (0..contacts.room_of(block)).map(|index| (index, contacts.rows(block, index)));
    let existing = all.filter(|(_, rows)| rows.inverse_diagonal[lane] > 0.0);
    for ((index, own), (point, bounded)) in existing.zip(points.iter_mut().zip(bounded)) {
        let (lever_upper, lever_lower) = stand.sorted(own.levers_of(lane));
        *point = PatchPoint { lever_upper, lever_lower, index: index as u8, ..PatchPoint::default() };
        *bounded = BoundedPoint::new(rows.of(*normal, lever_upper.cross(*normal)));
    }
}

/// The rows in which a body is balanced: momentum along up and angular momentum about the two axes across it, each of these over
/// the radius of gyration √(I/m).
///
/// What cannot be balanced is then least in ½ v·M v, as the sweeps have it, and not in a sum of forces and moments.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BalanceRows {
    up: Vec3,
    /// The axes across it over the radii about them (1/m).
    across: [Vec3; 2],
}

impl BalanceRows {
    pub(super) fn new(velocity: &BodyVelocity, &[up, u, v]: &[Vec3; 3]) -> Self {
        let inverse_mass = velocity.inverse_mass.max_element();
        let over_gyration = |axis: Vec3| {
            let squared = axis.dot(velocity.inverse_inertia.mul(axis)) / inverse_mass;
            // What cannot turn has no such radius, and is balanced about any.
            if squared > 0.0 { axis * squared.sqrt() } else { axis }
        };
        Self { up, across: [u, v].map(over_gyration) }
    }

    fn of(&self, push: Vec3, turn: Vec3) -> Vec3 {
        let [u, v] = self.across;
        Vec3::new(push.dot(self.up), turn.dot(u), turn.dot(v))
    }

    /// What an impulse is in them.
    pub(super) fn of_impulse(&self, impulse: &Impulse) -> DVec3 {
        self.of(impulse.linear.as_vec3(), impulse.angular.as_vec3()).as_dvec3()
    }
}
