//! Contacts of an articulation with what it cannot move and with bodies that it carries, as rows of its system.
//!
//! A normal row J v ≥ −max(s, 0)/h for each point with separation s (m), friction at the manifold's centre inside |λ_t| ≤ μ Σλ_n and
//! about its normal, |λ_w| ≤ μ r̄ Σλ_n, as for contacts elsewhere. They stand beside the factor of the joints, each in a node of its own
//! ([`beside`](super::beside)), unless they are too many for that. Then a contact with one moving body shares that body with its joints, so
//! its rows join the node of one of them: the structure of the matrix stays as it is. One with a body that it carries has two moving
//! bodies, and a node of its own.
//!
//! A row that presses makes a substep a safe one: an active set at the level of positions, with geometric stiffness, does not settle.

use glam::{DMat3, DVec3};

use super::contact_rows::RowAnchor;
use super::curved_contacts::CurvedPoint;
use super::row::FRICTION_ROWS;
use super::system::System;
use super::tracked_points::{TrackedPoints, carry, middles, overlap, slip_of_turn, way};
use crate::solve::contact::{ContactImpulses, ContactInput, POINTS, tangents};
use crate::solve::joint::LocalPose;
use crate::solve::joint::rows::Rate;

/// Share of an overlap that is taken out of the positions in a second (1/s), and the greatest share of a substep.
const RECOVERY: f64 = 12.0;
const MAX_RECOVERY_SHARE: f64 = 0.2;

/// Greatest speed at which an overlap is taken out (m/s).
const MAX_RECOVERY: f64 = 4.8;

/// A manifold between a body of the articulation and one that it does not move, or that it carries.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ArticulationContact {
    /// Number of the manifold in its batch.
    pub number: u32,
    /// Joint whose node has its rows, and the side of it that is the body.
    pub node: u32,
    pub side: u8,
    /// Local numbers of the body and of what it touches.
    pub body: u32,
    pub other: u32,
    /// Whether the other is moved too.
    pub other_moves: bool,
    /// Sign of an impulse on the body in the manifold's own terms: 1 where the body is its B.
    sign: f64,
    /// Its points, as the body sees them.
    spots: TrackedPoints,
    friction: f64,
    twist_arm: f64,
    /// Multipliers: along the normal, and on the body in world axes.
    lambda: [f64; POINTS],
    tangential: DVec3,
    twist: f64,
    /// Sums of the multipliers over the substeps, in the manifold's own terms.
    pub sum: ContactImpulses,
}

impl ArticulationContact {
    /// The manifold `input` with B (or else A) the articulation's body; the node is chosen later.
    pub(crate) fn new(number: u32, input: &ContactInput, body_is_b: bool, body: u32, other: u32, other_moves: bool) -> Self {
        let sign = if body_is_b { 1.0 } else { -1.0 };
        let spots = TrackedPoints::of(input, body_is_b);
        let spread = spots.spread();
        let material = &input.material;
        Self {
            number,
            node: 0,
            side: 0,
            body,
            other,
            other_moves,
            sign,
            spots,
            friction: f64::from(material.friction),
            twist_arm: f64::from(material.friction) * spread + f64::from(material.spinning),
            lambda: input.impulses.normal.map(f64::from),
            tangential: input.impulses.friction.as_dvec3() * sign,
            // The normal turns with the sign, so that the push about it does not.
            twist: f64::from(input.impulses.twist),
            sum: ContactImpulses::default(),
        }
    }

    /// Rows that it needs.
    pub(crate) fn rows(&self) -> u32 {
        self.spots.count as u32 + FRICTION_ROWS
    }

    /// Whether any of its points presses.
    pub(crate) fn presses(&self) -> bool {
        self.lambda.iter().any(|&lambda| lambda > 0.0)
    }

    /// Takes note of how far B's points lie from A's at the start of the step (m).
    pub(crate) fn lie(&mut self, offset: DVec3) {
        self.spots.lie(offset * self.sign);
    }

    /// Lets it follow surfaces with these shape operators in world axes, of the body and of the other (1/m); `reach` is that of the
    /// body from its centre of mass (m).
    pub(crate) fn curve(&mut self, operators: [DMat3; 2], reach: f64) {
        self.spots.curve(operators, reach);
    }

    /// Its points at these stances; `began` are those at the start of the step.
    pub(crate) fn spots(&self, local_poses: &[LocalPose], began: &[LocalPose]) -> [CurvedPoint; POINTS] {
        let [own, other] = [self.body, self.other].map(|body| [&local_poses[body as usize], &began[body as usize]]);
        self.spots.at(own, other)
    }

    /// Greatest overlap at these stances, zero where there is none (m).
    pub(crate) fn overlap(&self, local_poses: &[LocalPose], began: &[LocalPose]) -> f64 {
        overlap(&self.spots(local_poses, began))
    }

    /// Stiffness of its forces against rocking (N·m·s), and the rate at which the body turns as it slides along the other (rad/s).
    pub(crate) fn stiffness(&self, local_poses: &[LocalPose], began: &[LocalPose], rates: &[Rate]) -> Option<(DMat3, DVec3)> {
        let curved = self.spots.curved().filter(|_| self.presses())?;
        let (own, other) = (&rates[self.body as usize], &rates[self.other as usize]);
        let (mut total, mut turning) = (DMat3::ZERO, DVec3::ZERO);
        for (spot, &lambda) in self.spots(local_poses, began)[..self.spots.count].iter().zip(&self.lambda) {
            let height = -spot.normal.dot(spot.lever);
            let beside = other.linear + other.angular.cross(spot.other_lever - spot.lever);
            let (stiffness, turn) = curved.rocking(spot.normal, height, own.linear - beside);
            total += stiffness * lambda;
            turning = turn + other.angular;
        }
        Some((total, turning))
    }

    /// Where a row acts with these levers of the body and of the other (m).
    fn grip(&self, lever: DVec3, other_lever: DVec3) -> RowAnchor {
        RowAnchor { side: self.side as usize, lever, opposite: self.other_moves.then_some(other_lever) }
    }

    /// Adds its rows for a substep of length `h` (s) to the last node, between bodies that have moved from where they began.
    pub(crate) fn add_rows(
        &self,
        system: &mut System,
        (local_poses, began, rates): (&[LocalPose], &[LocalPose], &[Rate]),
        h: f64,
    ) {
        let mut spots = self.spots(local_poses, began);
        let spots = &mut spots[..self.spots.count];
        let sides = [self.body, self.other].map(|body| body as usize);
        // What follows surfaces has been followed up to now.
        if self.spots.curved().is_none() {
            carry(spots, self.spots.aside(), sides.map(|body| way(&local_poses[body], &began[body])));
        }
        let other = &rates[self.other as usize];
        // What is moved too has its speed in the rows.
        let other = if self.other_moves { Rate { linear: DVec3::ZERO, angular: DVec3::ZERO } } else { *other };
        system.begin_contact(self.friction, self.twist_arm);
        for (spot, &lambda) in spots.iter().zip(&self.lambda) {
            let passing = spot.normal.dot(other.linear + other.angular.cross(spot.other_lever));
            let bias = spot.separation.max(0.0) / h - passing;
            system.add_normal(&self.grip(spot.lever, spot.other_lever), spot.normal, bias, lambda);
        }
        let normal = spots[0].normal;
        let [center, other_center] = middles(spots);
        let slip = slip_of_turn(spots, sides.map(|body| &rates[body]), h);
        let passing = other.linear + other.angular.cross(other_center);
        let (t1, t2) = tangents(normal.as_vec3());
        let rows = [t1, t2].map(|t| t.as_dvec3()).map(|t| (t, t.dot(slip - passing), t.dot(self.tangential)));
        let twist = (normal, -normal.dot(other.angular), self.twist);
        system.add_friction(&self.grip(center, other_center), rows, twist);
    }

    /// Adds its rows for a projection after a substep of length `h` (s) to the last node.
    pub(crate) fn add_position_rows(&self, system: &mut System, spots: &[CurvedPoint; POINTS], h: f64) {
        let share = (RECOVERY * h).min(MAX_RECOVERY_SHARE);
        system.begin_contact(0.0, 0.0);
        for spot in &spots[..self.spots.count] {
            let overlaps = spot.separation < 0.0;
            let bias = if overlaps { (spot.separation * share).max(-MAX_RECOVERY * h) } else { spot.separation };
            // An overlap starts as a row that pushes.
            let pushes = if overlaps { f64::MIN_POSITIVE } else { 0.0 };
            system.add_normal(&self.grip(spot.lever, spot.other_lever), spot.normal, bias, pushes);
        }
    }

    /// Takes the multipliers from the rows that [`add_rows`](Self::add_rows) added as contact `index`.
    pub(crate) fn keep_impulses(&mut self, system: &System, index: usize) {
        let contact = &system.contacts[index];
        let first = contact.first as usize;
        for (lambda, row) in self.lambda.iter_mut().zip(&system.rows[first..first + self.spots.count]) {
            *lambda = row.impulse.max(0.0);
        }
        let side = self.side as usize;
        if let [u, v, w] = &system.rows[first + self.spots.count..first + self.spots.count + 3] {
            self.tangential = u.linear[side] * u.impulse + v.linear[side] * v.impulse;
            self.twist = w.impulse;
        }
        self.sum.add(&self.impulses());
    }

    pub(crate) fn scale_impulses(&mut self, factor: f64) {
        self.lambda.iter_mut().for_each(|lambda| *lambda *= factor);
        self.tangential *= factor;
        self.twist *= factor;
    }

    /// Multipliers in the manifold's own terms.
    pub(crate) fn impulses(&self) -> ContactImpulses {
        ContactImpulses {
            normal: self.lambda.map(|lambda| lambda as f32),
            friction: (self.tangential * self.sign).as_vec3(),
            twist: self.twist as f32,
            rolling: glam::Vec3::ZERO,
        }
    }
}
