//! Long-range bounds of a batch: rows on the distance of two joint points far apart (Müller et al. 2017, §3.1–3.3).
//!
//! With near point a, far point p, gap g = p − a and n = g/|g|,
//!
//! ```text
//! upper:  C = D − |g| ≥ 0,  J = [n, r_a×n, −n, −r_p×n],        lower:  C = |g| − L ≥ 0,  J negated;
//! w = J M⁻¹ Jᵀ = 1/m_a + (r_a×n)·I_a⁻¹(r_a×n) + 1/m_p + (r_p×n)·I_p⁻¹(r_p×n)   (1/kg; an attachment adds nothing).
//! ```
//!
//! The rows are those of a joint's stop: a velocity row for what this substep does to C, with a multiplier λ ≥ 0 (N·s) carried from
//! substep to substep, and a position row for the error that is left. Rigid rows never pull a bound that is slack, so no energy
//! comes from them; soft ones are springs of their compliance. A bound that is slack at the predicted poses has no row.

use glam::{Quat, Vec3};

use super::joint::{IMPLICIT_RANGE, Stance, turning_ease};
use super::state::{BodyMotion, BodyVelocity};
use crate::joint::Softness;

/// Greatest displacement of a point by one position row in one substep, as a speed (m/s).
const MAX_RECOVERY_SPEED: f32 = 10.0;

/// Gap at a share of the bound's length below it that already makes a row: others may close it within the sweeps.
const READY_SHARE: f32 = 1.0e-4;

/// A bound as its batch holds it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundEntry {
    /// The world's number for it.
    pub bound: u32,
    pub near: u32,
    pub far: u32,
    /// From the near body's origin to the far one's at the start of the step (m).
    pub offset: Vec3,
    /// Joint points from the origins, in the bodies' frames (m).
    pub local_lever: [Vec3; 2],
    /// Greatest and least distance (m).
    pub upper: f32,
    pub lower: f32,
    pub upper_give: Softness,
    pub lower_give: Softness,
    /// Multipliers of the upper and the lower row (N·s), ≥ 0.
    pub impulses: [f32; 2],
    /// Sum over the substeps of the impulses on the far body (N·s).
    pub far_sum: Vec3,
    /// Whether its upper row is there in this substep, and whether any was in any.
    pub taut: bool,
    pub acted: bool,
}

/// One side of a bound in this substep.
#[derive(Debug, Clone, Copy)]
struct BoundRow {
    entry: u32,
    near: u32,
    far: u32,
    side: usize,
    /// C = bound − distance for [`UPPER`], its negative for [`LOWER`]; the gradient below is of C.
    gradient: Gradient,
    response_near: Vec3,
    response_far: Vec3,
    mass: f32,
    bias: f32,
    gamma: f32,
    impulse: f32,
}

const UPPER: usize = 0;
const LOWER: usize = 1;

/// Gradient of a coordinate of two points: [−linear, −angular_near, linear, angular_far].
#[derive(Debug, Clone, Copy)]
struct Gradient {
    linear: Vec3,
    angular_near: Vec3,
    angular_far: Vec3,
}

impl Gradient {
    fn reversed(self) -> Self {
        Self { linear: -self.linear, angular_near: -self.angular_near, angular_far: -self.angular_far }
    }

    fn rate(&self, near: &BodyVelocity, far: &BodyVelocity) -> f32 {
        self.linear.dot(far.linear - near.linear) + self.angular_far.dot(far.angular) - self.angular_near.dot(near.angular)
    }
}

impl BoundRow {
    fn new(entry: u32, side: usize, ends: (u32, u32), gradient: Gradient, [near, far]: [&BodyVelocity; 2]) -> Self {
        let response_near = near.inverse_inertia.mul(gradient.angular_near);
        let response_far = far.inverse_inertia.mul(gradient.angular_far);
        let w = gradient.linear.dot((near.inverse_mass + far.inverse_mass) * gradient.linear)
            + gradient.angular_near.dot(response_near)
            + gradient.angular_far.dot(response_far);
        let mass = if w > 0.0 { 1.0 / w } else { 0.0 };
        let (near, far) = ends;
        Self { entry, near, far, side, gradient, response_near, response_far, mass, bias: 0.0, gamma: 0.0, impulse: 0.0 }
    }

    /// A velocity row over a substep of length `h`, in which C goes from `start` to `predicted` at the rate `rate`.
    fn moving(mut self, start: f32, predicted: f32, rate: f32, give: Softness, h: f32, impulse: f32) -> Self {
        let damped = 1.0 / (1.0 + give.damping * give.compliance / h);
        self.gamma = give.compliance / (h * h) * damped;
        self.mass = if self.mass > 0.0 { 1.0 / (1.0 / self.mass + self.gamma) } else { 0.0 };
        self.bias = if give.compliance == 0.0 {
            (start.max(0.0) + predicted - start) / h - rate
        } else {
            (predicted / h - rate) * damped
        };
        self.impulse = impulse;
        self
    }

    fn solve(&mut self, near: &mut BodyVelocity, far: &mut BodyVelocity) {
        let rate = self.gradient.rate(near, far);
        let new = (self.impulse - self.mass * (rate + self.bias + self.gamma * self.impulse)).max(0.0);
        let change = new - self.impulse;
        self.impulse = new;
        self.push(change, near, far);
    }

    fn push(&self, impulse: f32, near: &mut BodyVelocity, far: &mut BodyVelocity) {
        let linear = self.gradient.linear * impulse;
        near.linear -= near.inverse_mass * linear;
        near.angular -= self.response_near * impulse;
        far.linear += far.inverse_mass * linear;
        far.angular += self.response_far * impulse;
    }
}

/// Where the two points are: levers in world axes and the gap between them (m).
#[derive(Debug, Clone, Copy)]
struct Span {
    levers: [Vec3; 2],
    gap: Vec3,
}

/// All bounds of a batch.
#[derive(Debug, Default)]
pub(crate) struct BatchBounds {
    pub entries: Vec<BoundEntry>,
    rows: Vec<BoundRow>,
    /// Bounds that are no entries, because they are too slack to close within the step.
    pub skipped: u32,
}

impl BatchBounds {
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
        self.skipped = 0;
    }

    /// Builds this substep's rows; `predicted` holds the poses that the velocities of now lead to, and `applied` says whether
    /// carried multipliers are in those velocities already.
    pub(crate) fn prepare(
        &mut self,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        predicted: &[Stance],
        h: f32,
        applied: bool,
    ) {
        self.rows.clear();
        for (number, entry) in self.entries.iter_mut().enumerate() {
            let end = entry.span(rounded(predicted[entry.near as usize]), rounded(predicted[entry.far as usize]));
            let length = end.gap.length_squared();
            let ready = entry.upper * (1.0 - READY_SHARE);
            // A multiplier that has been applied stays in its row, where it can be taken back.
            let holds = |side: usize| applied && entry.impulses[side] > 0.0;
            let upper_slack = length < ready * ready && !holds(UPPER);
            let lower_slack = (entry.lower <= 0.0 || length > entry.lower * entry.lower) && !holds(LOWER);
            entry.taut = !upper_slack;
            if upper_slack && lower_slack {
                entry.impulses = [0.0; 2];
                continue;
            }
            entry.acted = true;
            let start = entry.span(now(motions, entry.near), now(motions, entry.far));
            let along = entry.gradient(&start, &end, velocities, h);
            let bodies = [&velocities[entry.near as usize], &velocities[entry.far as usize]];
            let ends = (entry.near, entry.far);
            let (from, to) = (start.gap.length(), end.gap.length());
            let rate = along.rate(bodies[0], bodies[1]);
            if !upper_slack {
                let row = BoundRow::new(number as u32, UPPER, ends, along.reversed(), bodies);
                let (from, to) = (entry.upper - from, entry.upper - to);
                self.rows.push(row.moving(from, to, -rate, entry.upper_give, h, entry.impulses[UPPER]));
            }
            if !lower_slack {
                let row = BoundRow::new(number as u32, LOWER, ends, along, bodies);
                let (from, to) = (from - entry.lower, to - entry.lower);
                self.rows.push(row.moving(from, to, rate, entry.lower_give, h, entry.impulses[LOWER]));
            }
        }
    }

    /// Applies the carried multipliers.
    pub(crate) fn warm_start(&self, velocities: &mut [BodyVelocity]) {
        for bound in &self.rows {
            on_pair(velocities, bound, |near, far| bound.push(bound.impulse, near, far));
        }
    }

    /// One sweep over all rows, from the longest bounds to the shortest or back.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity], backwards: bool) {
        let mut visit = |bound: &mut BoundRow| {
            let mut row = *bound;
            on_pair(velocities, bound, |near, far| row.solve(near, far));
            *bound = row;
        };
        if backwards {
            self.rows.iter_mut().rev().for_each(&mut visit);
        } else {
            self.rows.iter_mut().for_each(&mut visit);
        }
    }

    /// Keeps the multipliers for rows that are built anew.
    pub(crate) fn keep_impulses(&mut self) {
        for bound in &self.rows {
            self.entries[bound.entry as usize].impulses[bound.side] = bound.impulse;
        }
    }

    /// Adds the substep's multipliers to the bounds' loads.
    pub(crate) fn add_loads(&mut self) {
        for bound in &self.rows {
            self.entries[bound.entry as usize].far_sum += bound.gradient.linear * bound.impulse;
        }
    }

    /// One sweep of position rows over the rigid bounds that acted in this substep, at the poses of now.
    pub(crate) fn project(&self, velocities: &[BodyVelocity], motions: &mut [BodyMotion], h: f32) {
        for row in self.rows.iter().filter(|row| row.gamma == 0.0) {
            let entry = &self.entries[row.entry as usize];
            let span = entry.span(now(motions, row.near), now(motions, row.far));
            let length = span.gap.length();
            let (error, gradient) = match row.side {
                UPPER => (entry.upper - length, span.along().reversed()),
                _ => (length - entry.lower, span.along()),
            };
            if error >= 0.0 {
                continue;
            }
            let [mut near, mut far] = [row.near, row.far].map(|slot| velocities[slot as usize].at_rest());
            let row = BoundRow::new(row.entry, row.side, (row.near, row.far), gradient, [&near, &far]);
            row.push(-row.mass * error.max(-MAX_RECOVERY_SPEED * h), &mut near, &mut far);
            motions[row.near as usize].displace(near.linear, near.angular);
            motions[row.far as usize].displace(far.linear, far.angular);
        }
    }
}

fn on_pair(velocities: &mut [BodyVelocity], bound: &BoundRow, act: impl FnOnce(&mut BodyVelocity, &mut BodyVelocity)) {
    let (mut near, mut far) = (velocities[bound.near as usize], velocities[bound.far as usize]);
    act(&mut near, &mut far);
    velocities[bound.near as usize] = near;
    velocities[bound.far as usize] = far;
}

/// Where a body is: its displacement since the start of the step (m) and its rotation.
pub(crate) type Place = (Vec3, Quat);

pub(crate) fn now(motions: &[BodyMotion], slot: u32) -> Place {
    (motions[slot as usize].displacement, motions[slot as usize].rotation)
}

pub(crate) fn rounded((displacement, rotation): Stance) -> Place {
    (displacement.as_vec3(), rotation.as_quat())
}

impl BoundEntry {
    fn span(&self, near: Place, far: Place) -> Span {
        let levers = [near.1 * self.local_lever[0], far.1 * self.local_lever[1]];
        Span { levers, gap: self.offset + (far.0 - near.0) + (levers[1] - levers[0]) }
    }

    /// Gradient of the distance, taken between start and predicted end by how stiff the tension makes the turning of the bodies,
    /// as joints do. At the start it is at right angles to the mean of the substeps before and after, so the row does no work; halfway
    /// to the end a weight of 1:10,000 let go from the horizontal would lose ten times as much energy.
    fn gradient(&self, start: &Span, end: &Span, velocities: &[BodyVelocity], h: f32) -> Gradient {
        let tension = self.impulses[UPPER].max(self.impulses[LOWER]);
        let ease = |slot: u32, lever: Vec3| turning_ease(&velocities[slot as usize], lever);
        let stiffness = h * tension * (ease(self.near, start.levers[0]) + ease(self.far, start.levers[1]));
        let implicit = ((stiffness - IMPLICIT_RANGE.0) / (IMPLICIT_RANGE.1 - IMPLICIT_RANGE.0)).clamp(0.0, 1.0);
        let between = |from: Vec3, to: Vec3| from.lerp(to, implicit);
        let levers = [0, 1].map(|i| between(start.levers[i], end.levers[i]));
        Span { levers, gap: between(start.gap, end.gap) }.along()
    }
}

impl Span {
    /// Gradient of the distance. Both levers may reach anywhere along the line: the two impulses are on it.
    fn along(&self) -> Gradient {
        let n = self.gap.normalize_or(Vec3::X);
        Gradient { linear: n, angular_near: self.levers[0].cross(n), angular_far: self.levers[1].cross(n) }
    }
}
