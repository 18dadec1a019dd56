//! Second-order stepping: a two-step method of order two between the backward differentiation formula and the trapezoidal rule, in
//! substeps of any length.
//!
//! Of the two-step methods that weigh the rates at the end of a substep by β and those at its start by 1 − β, one for each β is of
//! order two. On ẏ = f, with ω = h_{n+1}/h_n the ratio of the lengths of two substeps and c = (2β − 1) ω²/(1 + ω):
//!
//! ```text
//! (1 + c/ω) (y_{n+1} − y_n) = c (y_n − y_{n−1}) + h ((1 − β) f_n + β f_{n+1})
//! ```
//!
//! With ρ and σ the polynomials of both sides, Re ρ σ̄ = β (2β − 1) (1 − cos θ)² on the unit circle: A-stable for β ≥ ½ (Dahlquist,
//! Liniger and Nevanlinna 1983). The error constant is ½β − ⅙, and what no substep resolves is multiplied by (1 − β)/β in each.
//! β = 1 is BDF2 (Curtiss and Hirschfelder 1952) with ⅓ and 0, β = ½ the trapezoidal rule with 1/12 and 1: multipliers of
//! constraints would ring for ever. β = ¾, taken here, has 5/24 and ⅓. With Δ = x_n − x_{n−1}:
//!
//! ```text
//! s = ω²/(2 + 3ω),   k = h (1 + ω)/(4 + 6ω),   h' = 3k,
//! x̂ = x_n + s Δ + k v_n,   v̂ = v_n + s (v_n − v_{n−1}) + k a_n,
//! x_{n+1} = x̂ + h' v_{n+1},   v_{n+1} = v̂ + h' a_{n+1}:
//! ```
//!
//! an implicit Euler substep of length h' from an extrapolated start, stable for ω < 3.5, where s is 1. Rotations follow with rotation
//! vectors; what is extrapolated of them is the angular momentum L = I ω, as I turns with the body: extrapolating ω would leave an
//! error of first order. The first substep after an impact, an edit or a halving is of first order.
//!
//! **How many substeps.** The local error is ⅙ h³ v̈ = ⅙ h |δ|, with δ = h² v̈ and v̈ from the velocities of three substeps. What counts
//! is what the substeps of a step add up to: light links that tremble under a heavy weight change the sign of v̈ many times a step, and
//! move nothing. So v̈ is averaged, for each body by itself, over as much time as a step takes. An articulation takes as many substeps
//! as keep |δ| below a bound: one where it hangs still, more where it whips. Without an error target |δ| is the mean over the mass,
//! with one that of the body whose is greatest.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3, Vec3};

use crate::linalg::narrowing;
use crate::solve::joint::rows::Rate;
use crate::step_history::History;

/// Ratios of the lengths of two substeps at which the second may be of second order.
pub(super) const RATIOS: std::ops::RangeInclusive<f64> = 0.2..=2.2;

/// Coefficients of a second-order substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SecondOrder {
    /// Ratio ω of its length to that of the one before.
    pub ratio: f64,
    /// Share s of the last change by which its start is extrapolated.
    pub extrapolation: f64,
    /// Length k over which the last rates go on, over its own.
    pub steady_share: f64,
    /// Length h' of its Euler part over its own.
    pub euler_share: f64,
}

impl Default for SecondOrder {
    fn default() -> Self {
        Self::EULER
    }
}

impl SecondOrder {
    /// An implicit Euler substep, of first order.
    pub(crate) const EULER: Self = Self { ratio: 0.0, extrapolation: 0.0, steady_share: 0.0, euler_share: 1.0 };

    /// For a substep of length `h` (s) after one of length `before`; `None` where the ratio is too far from one.
    pub(crate) fn new(h: f64, before: f64) -> Option<Self> {
        let ratio = h / before;
        let steady_share = (1.0 + ratio) / (4.0 + 6.0 * ratio);
        RATIOS.contains(&ratio).then_some(Self {
            ratio,
            extrapolation: ratio * ratio / (2.0 + 3.0 * ratio),
            steady_share,
            euler_share: 3.0 * steady_share,
        })
    }
}

/// Change of velocity beyond a steady one in a substep, δ (m/s).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LocalError {
    /// Mean over the mass. Not its root mean square, which light links that tremble under a heavy weight would rule, though they hardly
    /// move it.
    pub mean: f64,
    /// Of the body whose is greatest.
    pub worst: f64,
}

impl History {
    /// Whether the body has moved at this rate ever since, and no other.
    pub(crate) fn leads_to(&self, rate: &Rate) -> bool {
        self.h > 0.0 && self.linear == narrowing::speed(rate.linear) && self.angular == narrowing::speed(rate.angular)
    }

    /// Takes a substep of length `h` (s), from the velocity `now` to `next` (m/s), into the average of the jerk over `dt` (s), and
    /// returns that (m/s³).
    pub(crate) fn note_jerk(&mut self, now: DVec3, next: DVec3, order: &SecondOrder, h: f64, dt: f64) -> DVec3 {
        let surprise = next - now - (now - self.linear_before.as_dvec3()) * order.ratio;
        let found = surprise * (2.0 * order.ratio / ((1.0 + order.ratio) * h * h));
        let known = self.jerk.as_dvec3();
        let jerk = if self.jerk == Vec3::ZERO { found } else { known + (found - known) * (h / dt).min(1.0) };
        self.jerk = jerk.as_vec3();
        jerk
    }
}

/// Rotation vector of a rotation by about `way` (rad): of all that mean the same, the nearest.
pub(super) fn rotation_vector_near(rotation: DQuat, way: DVec3) -> DVec3 {
    let vector = rotation_vector(rotation);
    let length = vector.length();
    if length == 0.0 {
        return vector;
    }
    let turns = ((way.dot(vector) / length - length) / TAU).round();
    vector + vector * (turns * TAU / length)
}

/// Rotation vector of a rotation by less than half a turn (rad).
pub(crate) fn rotation_vector(rotation: DQuat) -> DVec3 {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    let axis = DVec3::new(rotation.x, rotation.y, rotation.z);
    let sine = axis.length();
    let square = sine * sine;
    if square < 1.0e-3 {
        // 2 asin(s)/s, to rounding of the numbers kept.
        return axis * (2.0 + square * (1.0 / 3.0 + square * (3.0 / 20.0 + square * (5.0 / 56.0))));
    }
    axis * (2.0 * libm::atan2(sine, rotation.w) / sine)
}
