//! What a taut bound does to the joints on its path: they lie on the straight line between its ends.
//!
//! A joint at d from the bound's near end a and at e from its far end p, both along segments, is inside two balls. Seen from the
//! line, with D = |p − a|, they meet in a lens of radius ρ about the line:
//!
//! ```text
//! x = (D² + d² − e²) / 2D,    ρ² = d² − x²    (about 2 s d e / (d + e) where the slack s = d + e − D is small).
//! ```
//!
//! A bound that is taut to a micrometre leaves a joint a millimetre. The two balls are all but tangent there, so rows on the two
//! distances push along the line and hardly across; this row pushes across. With n = (p − a)/D, P the projection across n, and σ =
//! n·(q − a)/D where the joint is along the line,
//!
//! ```text
//! C = P(q − a),  |C| ≤ ρ,    Ċ = P(v_q − (1 − σ) v_a − σ v_p),
//! K = M⁻¹ seen at q + (1 − σ)² M⁻¹ seen at a + σ² M⁻¹ seen at p    (1/kg).
//! ```
//!
//! Forces f on q, −(1 − σ) f on a and −σ f on p sum to nothing, and turn nothing but by C × f.
//!
//! Nothing is carried from substep to substep: what acts across a taut line is small beside what acts along it.

use glam::{Mat3, Vec3};

use super::bound::{BatchBounds, BoundEntry, Place, now, rounded};
use super::integrate::skew;
use super::joint::Stance;
use super::state::{BodyMotion, BodyVelocity};

/// Lens beyond which a joint is left alone, as a share of the bound: rows are for what is all but straight.
const MAX_LENS: f32 = 0.05;

/// Way across the line in one substep, as a share of the distance from the near end, beyond which a joint is left to position rows:
/// velocity rows on joints that are thrown across the line put energy in (1:10,000, links at 10 m/s and 20 rad/s: speeds of
/// kilometres a second in 16 runs of 16; with this limit in none of 72).
const NEARLY_STRAIGHT: f32 = 1.0e-3;

/// Greatest displacement across the line in one substep, as a speed (m/s).
const MAX_RECOVERY_SPEED: f32 = 10.0;

/// A joint on the path of a bound, as its batch holds it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TautEntry {
    /// The joint's place in the world's list.
    pub inner: u32,
    /// The bound, by its place among the batch's entries.
    pub bound: u32,
    pub slot: u32,
    /// From the near body's origin to this body's at the start of the step (m).
    pub offset: Vec3,
    pub local_lever: Vec3,
    /// Length along segments to the near and to the far end (m).
    pub before: f32,
    pub after: f32,
    /// Sum over the substeps of the impulses on this body, and of those on the bound's far body (N·s).
    pub own_sum: Vec3,
    pub far_sum: Vec3,
}

/// A row across the line.
#[derive(Debug, Clone, Copy)]
struct TautRow {
    entry: u32,
    /// The joint's body, the near and the far one.
    slots: [u32; 3],
    levers: [Vec3; 3],
    /// Share of the impulse that each body gets.
    shares: [f32; 3],
    mass: Mat3,
    bias: Vec3,
    impulse: Vec3,
}

/// Rows of all taut bounds of a batch.
#[derive(Debug, Default)]
pub(crate) struct TautRows {
    pub entries: Vec<TautEntry>,
    rows: Vec<TautRow>,
}

/// Where a joint is, seen from the line between a bound's ends.
struct Sight {
    levers: [Vec3; 3],
    shares: [f32; 3],
    along: Vec3,
    /// Off the line (m), and how far that may be.
    off: Vec3,
    lens: f32,
}

impl TautRows {
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
        self.rows.clear();
    }

    /// Builds this substep's rows for the bounds that have rows themselves.
    pub(crate) fn prepare(
        &mut self,
        bounds: &BatchBounds,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        predicted: &[Stance],
        h: f32,
    ) {
        let Self { entries, rows } = self;
        rows.clear();
        for (number, entry) in entries.iter().enumerate() {
            let bound = &bounds.entries[entry.bound as usize];
            if !bound.taut {
                continue;
            }
            let Some(end) = entry.sight(bound, |slot| rounded(predicted[slot as usize])) else { continue };
            let start = entry.off_line(bound, |slot| now(motions, slot));
            // An error that was there before is left to the position rows.
            let excess = end.off - end.off.clamp_length_max(end.lens.max(start));
            if excess == Vec3::ZERO || excess.length() > NEARLY_STRAIGHT * entry.before {
                continue;
            }
            let slots = [entry.slot, bound.near, bound.far];
            let mass = inverse_across(end.along, end.inverse_effective_mass(slots, velocities));
            let bias = excess / h - across(end.along, end.rate(slots, velocities));
            let Sight { levers, shares, .. } = end;
            rows.push(TautRow { entry: number as u32, slots, levers, shares, mass, bias, impulse: Vec3::ZERO });
        }
    }

    /// One sweep over all rows.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity], backwards: bool) {
        if backwards {
            self.rows.iter_mut().rev().for_each(|row| row.solve(velocities));
        } else {
            self.rows.iter_mut().for_each(|row| row.solve(velocities));
        }
    }

    /// Adds the substep's multipliers to the loads.
    pub(crate) fn add_loads(&mut self) {
        for row in &self.rows {
            let entry = &mut self.entries[row.entry as usize];
            entry.own_sum += row.impulse;
            entry.far_sum += row.impulse * row.shares[2];
        }
    }

    /// One sweep of position rows over the bounds that had rows in this substep, at the poses of now.
    pub(crate) fn project(&self, bounds: &BatchBounds, velocities: &[BodyVelocity], motions: &mut [BodyMotion], h: f32) {
        for entry in &self.entries {
            let bound = &bounds.entries[entry.bound as usize];
            if !bound.taut {
                continue;
            }
            let Some(sight) = entry.sight(bound, |slot| now(motions, slot)) else { continue };
            let excess = sight.off - sight.off.clamp_length_max(sight.lens);
            if excess == Vec3::ZERO {
                continue;
            }
            let slots = [entry.slot, bound.near, bound.far];
            let inverse = sight.inverse_effective_mass(slots, velocities);
            let change = inverse_across(sight.along, inverse) * -excess.clamp_length_max(MAX_RECOVERY_SPEED * h);
            for i in 0..3 {
                let mut push = velocities[slots[i] as usize].at_rest();
                let own = change * sight.shares[i];
                push.apply(own, sight.levers[i].cross(own));
                motions[slots[i] as usize].displace(push.linear, push.angular);
            }
        }
    }
}

/// The part of `v` across a unit vector.
fn across(axis: Vec3, v: Vec3) -> Vec3 {
    v - axis * axis.dot(v)
}

/// Inverse of `k` on the directions across a unit vector, zero along it.
fn inverse_across(axis: Vec3, k: Mat3) -> Mat3 {
    let (u, v) = super::contact::tangents(axis);
    let (a, b, c) = (u.dot(k * u), u.dot(k * v), v.dot(k * v));
    let determinant = a * c - b * b;
    if determinant <= f32::EPSILON * a * c {
        return Mat3::ZERO;
    }
    let outer = |x: Vec3, y: Vec3| Mat3::from_cols(x * y.x, x * y.y, x * y.z);
    (outer(u, u) * c - (outer(u, v) + outer(v, u)) * b + outer(v, v) * a) * (1.0 / determinant)
}

impl TautRow {
    fn solve(&mut self, velocities: &mut [BodyVelocity]) {
        let mut rate = self.bias;
        for i in 0..3 {
            let body = &velocities[self.slots[i] as usize];
            rate += (body.linear + body.angular.cross(self.levers[i])) * self.shares[i];
        }
        let change = self.mass * -rate;
        self.impulse += change;
        for i in 0..3 {
            let own = change * self.shares[i];
            velocities[self.slots[i] as usize].apply(own, self.levers[i].cross(own));
        }
    }
}

impl TautEntry {
    /// Levers of the three points, line from near to far end, and this point from the near end.
    fn lines(&self, bound: &BoundEntry, place: impl Fn(u32) -> Place) -> ([Vec3; 3], Vec3, Vec3) {
        let (own, near, far) = (place(self.slot), place(bound.near), place(bound.far));
        let levers = [own.1 * self.local_lever, near.1 * bound.local_lever[0], far.1 * bound.local_lever[1]];
        let line = bound.offset + (far.0 - near.0) + (levers[2] - levers[1]);
        let point = self.offset + (own.0 - near.0) + (levers[0] - levers[1]);
        (levers, line, point)
    }

    /// The joint seen from the line, unless that is too far from taut to say where the joint is.
    fn sight(&self, bound: &BoundEntry, place: impl Fn(u32) -> Place) -> Option<Sight> {
        let (levers, line, point) = self.lines(bound, place);
        let squared = line.length_squared();
        let length = squared.sqrt();
        let foot = (squared + self.before * self.before - self.after * self.after) / (2.0 * length);
        let lens = (self.before * self.before - foot * foot).max(0.0).sqrt();
        if lens.is_nan() || lens > MAX_LENS * length {
            return None;
        }
        let along = line / length;
        let reached = along.dot(point);
        let share = reached / length;
        Some(Sight { levers, shares: [1.0, share - 1.0, -share], along, off: point - along * reached, lens })
    }

    /// Distance of the joint from the line (m).
    fn off_line(&self, bound: &BoundEntry, place: impl Fn(u32) -> Place) -> f32 {
        let (_, line, point) = self.lines(bound, place);
        let along = line.normalize_or_zero();
        (point - along * along.dot(point)).length()
    }
}

impl Sight {
    fn inverse_effective_mass(&self, slots: [u32; 3], velocities: &[BodyVelocity]) -> Mat3 {
        let mut k = Mat3::ZERO;
        for i in 0..3 {
            let body = &velocities[slots[i] as usize];
            let arm = skew(self.levers[i]);
            let own = Mat3::from_diagonal(body.inverse_mass) - arm * body.inverse_inertia.to_mat3() * arm;
            k += own * (self.shares[i] * self.shares[i]);
        }
        k
    }

    fn rate(&self, slots: [u32; 3], velocities: &[BodyVelocity]) -> Vec3 {
        (0..3).fold(Vec3::ZERO, |rate, i| {
            let body = &velocities[slots[i] as usize];
            rate + (body.linear + body.angular.cross(self.levers[i])) * self.shares[i]
        })
    }
}
