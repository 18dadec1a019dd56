//! Contacts of an articulation with what it cannot move: rows of the same system.
//!
//! A normal row J v ≥ −max(s, 0)/h for each point with separation s (m), friction at the manifold's centre inside |λ_t| ≤ μ Σλ_n and
//! about its normal, |λ_w| ≤ μ r̄ Σλ_n, as for contacts elsewhere. A contact with one moving body shares that body with its joints, so
//! its rows join the node of one of them: the structure of the matrix stays as it is.
//!
//! A row that presses makes a substep a safe one: an active set at the level of positions, with geometric stiffness, does not settle.

use glam::DVec3;

use super::system::System;
use crate::solve::contact::{ContactImpulses, ContactInput, POINTS, tangents};
use crate::solve::joint::Stance;
use crate::solve::joint::rows::Rate;

/// Rows of a manifold beside its normals.
const FRICTION_ROWS: u32 = 3;

/// Share of an overlap that is taken out of the positions in one substep.
const RECOVERY: f64 = 0.05;

/// Greatest overlap taken out in one substep (m).
const MOST_RECOVERY: f64 = 0.02;

/// A manifold between a body of the articulation and one that it does not move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch {
    /// Number of the manifold in its batch.
    pub number: u32,
    /// Joint whose node has its rows, and the side of it that is the body.
    pub node: u32,
    pub side: u8,
    /// Local numbers of the body and of what it touches.
    pub body: u32,
    pub other: u32,
    /// Sign of an impulse on the body in the manifold's own terms: 1 where the body is its B.
    sign: f64,
    /// Towards the body.
    normal: DVec3,
    /// Points from the centres of mass of the body and of the other, at the start of the step (m).
    levers: [DVec3; POINTS],
    other_levers: [DVec3; POINTS],
    separation: [f64; POINTS],
    count: usize,
    friction: f64,
    twist_arm: f64,
    /// Multipliers: along the normal, and on the body in world axes.
    lambda: [f64; POINTS],
    tangential: DVec3,
    twist: f64,
    /// Sum of the normals' multipliers over the substeps (N·s).
    blow: f64,
}

impl Touch {
    /// The manifold `input` with B (or else A) the articulation's body; the node is chosen later.
    pub(crate) fn new(number: u32, input: &ContactInput, body_is_b: bool, body: u32, other: u32) -> Self {
        let sign = if body_is_b { 1.0 } else { -1.0 };
        let (own, others) = if body_is_b { (&input.lever_b, &input.lever_a) } else { (&input.lever_a, &input.lever_b) };
        let levers = own.map(|lever| lever.as_dvec3());
        let center = levers[..input.count].iter().sum::<DVec3>() / input.count as f64;
        let spread = levers[..input.count].iter().map(|lever| (*lever - center).length()).sum::<f64>() / input.count as f64;
        let material = &input.material;
        Self {
            number,
            node: 0,
            side: 0,
            body,
            other,
            sign,
            normal: input.normal.as_dvec3() * sign,
            levers,
            other_levers: others.map(|lever| lever.as_dvec3()),
            separation: input.separation.map(f64::from),
            count: input.count,
            friction: f64::from(material.friction),
            twist_arm: f64::from(material.friction) * spread + f64::from(material.spinning),
            lambda: input.impulses.normal.map(f64::from),
            tangential: input.impulses.friction.as_dvec3() * sign,
            // The normal turns with the sign, so that the push about it does not.
            twist: f64::from(input.impulses.twist),
            blow: 0.0,
        }
    }

    /// Rows that it needs.
    pub(crate) fn rows(&self) -> u32 {
        self.count as u32 + FRICTION_ROWS
    }

    /// Whether any of its points presses.
    pub(crate) fn presses(&self) -> bool {
        self.lambda.iter().any(|&lambda| lambda > 0.0)
    }

    /// Separations at these stances; `began` are those at the start of the step (m).
    pub(crate) fn separations(&self, stances: &[Stance], began: &[Stance]) -> [f64; POINTS] {
        let moved = |body: u32, lever: DVec3| {
            let (now, start) = (&stances[body as usize], &began[body as usize]);
            now.0 - start.0 + now.1 * (start.1.conjugate() * lever) - lever
        };
        std::array::from_fn(|i| {
            if i >= self.count {
                return f64::INFINITY;
            }
            let apart = moved(self.body, self.levers[i]) - moved(self.other, self.other_levers[i]);
            self.separation[i] + self.normal.dot(apart)
        })
    }

    /// Adds its rows for a substep of length `h` (s) to the last node.
    pub(crate) fn add_rows(&self, system: &mut System, separations: &[f64; POINTS], other: &Rate, h: f64) {
        let side = self.side as usize;
        system.begin_contact(self.friction, self.twist_arm);
        for (i, separation) in separations[..self.count].iter().enumerate() {
            let passing = self.normal.dot(other.linear + other.angular.cross(self.other_levers[i]));
            system.add_normal(side, self.normal, self.levers[i], separation.max(0.0) / h - passing, self.lambda[i]);
        }
        let share = 1.0 / self.count as f64;
        let center = self.levers[..self.count].iter().sum::<DVec3>() * share;
        let other_center = self.other_levers[..self.count].iter().sum::<DVec3>() * share;
        let passing = other.linear + other.angular.cross(other_center);
        let (t1, t2) = tangents(self.normal.as_vec3());
        let rows = [t1, t2].map(|t| t.as_dvec3()).map(|t| (t, -t.dot(passing), t.dot(self.tangential)));
        system.add_friction(side, center, rows, (self.normal, -self.normal.dot(other.angular), self.twist));
    }

    /// Adds its rows for a projection to the last node.
    pub(crate) fn add_position_rows(&self, system: &mut System, separations: &[f64; POINTS]) {
        system.begin_contact(0.0, 0.0);
        for (i, &separation) in separations[..self.count].iter().enumerate() {
            let bias = if separation < 0.0 { (separation * RECOVERY).max(-MOST_RECOVERY) } else { separation };
            // An overlap starts as a row that pushes.
            let pushes = if separation < 0.0 { f64::MIN_POSITIVE } else { 0.0 };
            system.add_normal(self.side as usize, self.normal, self.levers[i], bias, pushes);
        }
    }

    /// Takes the multipliers from the rows that [`add_rows`](Self::add_rows) added as contact `index`.
    pub(crate) fn keep_impulses(&mut self, system: &System, index: usize) {
        let contact = &system.contacts[index];
        let first = contact.first as usize;
        for (lambda, row) in self.lambda.iter_mut().zip(&system.rows[first..first + self.count]) {
            *lambda = row.impulse.max(0.0);
        }
        self.blow += self.lambda[..self.count].iter().sum::<f64>();
        let (t1, t2) = tangents(self.normal.as_vec3());
        if let [u, v, w] = &system.rows[first + self.count..first + self.count + 3] {
            self.tangential = t1.as_dvec3() * u.impulse + t2.as_dvec3() * v.impulse;
            self.twist = w.impulse;
        }
    }

    pub(crate) fn scale_impulses(&mut self, factor: f64) {
        self.lambda.iter_mut().for_each(|lambda| *lambda *= factor);
        self.tangential *= factor;
        self.twist *= factor;
    }

    /// Impulse along the normal over the step (N·s).
    pub(crate) fn blow(&self) -> f32 {
        self.blow as f32
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
