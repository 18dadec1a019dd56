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

use super::joint::rows::{Demand, Error1, Give, Jacobian, Phase, ScalarRow};
use super::joint::{IMPLICIT_RANGE, turning_ease};
use super::state::{BodyMotion, BodyVelocity};
use crate::joint::Softness;

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

#[derive(Debug, Clone, Copy)]
struct BoundRow {
    entry: u32,
    near: u32,
    far: u32,
    row: ScalarRow,
}

const UPPER: usize = 0;
const LOWER: usize = 1;

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
}

impl BatchBounds {
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }

    /// Builds this substep's rows; `predicted` holds the poses that the velocities of now lead to, and `applied` says whether
    /// carried multipliers are in those velocities already.
    pub(crate) fn prepare(
        &mut self,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        predicted: &[(Vec3, Quat)],
        h: f32,
        applied: bool,
    ) {
        self.rows.clear();
        for (number, entry) in self.entries.iter_mut().enumerate() {
            let end = entry.span(predicted[entry.near as usize], predicted[entry.far as usize]);
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
            let (from, to) = (start.gap.length(), end.gap.length());
            if !upper_slack {
                let error = Error1 { start: entry.upper - from, predicted: entry.upper - to };
                let give = Give::new(entry.upper_give, Phase::Velocity { h });
                let row =
                    ScalarRow::new(bodies, along.reversed(), Demand::AtLeast(error), give, UPPER as u8, entry.impulses[UPPER]);
                self.rows.push(BoundRow { entry: number as u32, near: entry.near, far: entry.far, row });
            }
            if !lower_slack {
                let error = Error1 { start: from - entry.lower, predicted: to - entry.lower };
                let give = Give::new(entry.lower_give, Phase::Velocity { h });
                let row = ScalarRow::new(bodies, along, Demand::AtLeast(error), give, LOWER as u8, entry.impulses[LOWER]);
                self.rows.push(BoundRow { entry: number as u32, near: entry.near, far: entry.far, row });
            }
        }
    }

    /// Applies the carried multipliers.
    pub(crate) fn warm_start(&self, velocities: &mut [BodyVelocity]) {
        for bound in &self.rows {
            on_pair(velocities, bound, |near, far| bound.row.push(bound.row.impulse, near, far));
        }
    }

    /// One sweep over all rows, from the longest bounds to the shortest or back.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity], backwards: bool) {
        let mut visit = |bound: &mut BoundRow| {
            let mut row = bound.row;
            on_pair(velocities, bound, |near, far| row.solve(near, far));
            bound.row = row;
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
            self.entries[bound.entry as usize].impulses[bound.row.id as usize] = bound.row.impulse;
        }
    }

    /// Adds the substep's multipliers to the bounds' loads.
    pub(crate) fn add_loads(&mut self) {
        for bound in &self.rows {
            self.entries[bound.entry as usize].far_sum += bound.row.jacobian.linear * bound.row.impulse;
        }
    }

    /// One sweep of position rows over the bounds that acted in this substep, at the poses of now.
    pub(crate) fn project(&mut self, velocities: &[BodyVelocity], motions: &mut [BodyMotion], h: f32) {
        for bound in &self.rows {
            let entry = &self.entries[bound.entry as usize];
            let span = entry.span(now(motions, entry.near), now(motions, entry.far));
            let length = span.gap.length();
            let is_upper = bound.row.id as usize == UPPER;
            let error = if is_upper { entry.upper - length } else { length - entry.lower };
            if error >= 0.0 {
                continue;
            }
            let along = span.along();
            let (jacobian, softness) = if is_upper { (along.reversed(), entry.upper_give) } else { (along, entry.lower_give) };
            let [mut near, mut far] = [entry.near, entry.far].map(|slot| velocities[slot as usize].at_rest());
            let error = Error1 { start: error, predicted: error };
            let give = Give::new(softness, Phase::Position { h });
            let mut row = ScalarRow::new([&near, &far], jacobian, Demand::AtLeast(error), give, bound.row.id, 0.0);
            row.solve(&mut near, &mut far);
            motions[entry.near as usize].displace(near.linear, near.angular);
            motions[entry.far as usize].displace(far.linear, far.angular);
        }
    }
}

fn on_pair(velocities: &mut [BodyVelocity], bound: &BoundRow, act: impl FnOnce(&mut BodyVelocity, &mut BodyVelocity)) {
    let (mut near, mut far) = (velocities[bound.near as usize], velocities[bound.far as usize]);
    act(&mut near, &mut far);
    velocities[bound.near as usize] = near;
    velocities[bound.far as usize] = far;
}

fn now(motions: &[BodyMotion], slot: u32) -> (Vec3, Quat) {
    (motions[slot as usize].displacement, motions[slot as usize].rotation)
}

impl BoundEntry {
    fn span(&self, near: (Vec3, Quat), far: (Vec3, Quat)) -> Span {
        let levers = [near.1 * self.local_lever[0], far.1 * self.local_lever[1]];
        Span { levers, gap: self.offset + (far.0 - near.0) + (levers[1] - levers[0]) }
    }

    /// Gradient of the distance, taken between start and predicted end by how stiff the tension makes the turning of the bodies,
    /// as joints do.
    fn gradient(&self, start: &Span, end: &Span, velocities: &[BodyVelocity], h: f32) -> Jacobian {
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
    fn along(&self) -> Jacobian {
        let n = self.gap.normalize_or(Vec3::X);
        Jacobian { linear: n, angular_a: self.levers[0].cross(n), angular_b: self.levers[1].cross(n) }
    }
}
