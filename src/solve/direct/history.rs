//! Second-order stepping: the backward differentiation formula of order two (Curtiss and Hirschfelder 1952), BDF2, in substeps of
//! any length.
//!
//! With Δ = x_n − x_{n−1} the last substep's displacement and ω = h_{n+1}/h_n the ratio of their lengths,
//!
//! ```text
//! x̂ = x_n + s Δ,   v̂ = v_n + s (v_n − v_{n−1}),   s = ω²/(1 + 2ω),   h' = h (1 + ω)/(1 + 2ω),
//! x_{n+1} = x̂ + h' v_{n+1},   v_{n+1} = v̂ + h' a_{n+1}:
//! ```
//!
//! an implicit Euler substep of length h' from an extrapolated start, and as stable for ω < 2.4. Rotations follow with rotation
//! vectors; what is extrapolated of them is the angular momentum L = I ω, as I turns with the body: extrapolating ω would leave an
//! error of first order. The first substep after an impact, an edit or a halving is of first order.
//!
//! **How many substeps.** The local error is (2/9) h³ x‴ ≈ (2/9) h |δ|, with δ = v_{n+1} − v_n − ω (v_n − v_{n−1}). An articulation
//! takes as many substeps as keep (2/9) |δ|, as the mean over its mass, below a bound: one where it hangs still, more
//! where it whips.

use glam::{DQuat, DVec3, Vec3};

use crate::solve::joint::rows::Rate;
use crate::solve::lead::Twist;

/// Ratios of the lengths of two substeps at which the second may be of second order.
const RATIOS: std::ops::RangeInclusive<f64> = 0.2..=2.2;

/// Coefficients of a second-order substep.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SecondOrder {
    /// Ratio ω of its length to that of the one before.
    pub ratio: f64,
    /// Share s of the last change by which its start is extrapolated.
    pub extrapolation: f64,
    /// Length of its Euler part over its own.
    pub euler_share: f64,
}

impl SecondOrder {
    /// For a substep of length `h` (s) after one of length `before`; `None` where the ratio is too far from one.
    pub(crate) fn new(h: f64, before: f64) -> Option<Self> {
        let ratio = h / before;
        let whole = 1.0 + 2.0 * ratio;
        RATIOS.contains(&ratio).then_some(Self {
            ratio,
            extrapolation: ratio * ratio / whole,
            euler_share: (1.0 + ratio) / whole,
        })
    }
}

/// Length of the substep where nothing is known but a lead: see [`crate::solve::lead`].
const TOLD: f32 = -1.0;

/// A body's last substep, as its record keeps it from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct History {
    /// Length of the substep (s); zero where nothing is known.
    pub h: f32,
    /// Substeps that the articulation should take in the next step.
    pub substeps: u32,
    /// Displacement (m) and rotation vector (rad).
    pub(super) displacement: Vec3,
    pub(super) turn: Vec3,
    /// Velocity and angular momentum at its start (m/s, N·m·s); or a lead of the velocities (m/s, rad/s).
    pub(super) linear_before: Vec3,
    pub(super) momentum_before: Vec3,
    /// Velocities at its end: others mean that the body has been struck or edited since.
    pub(super) linear: Vec3,
    pub(super) angular: Vec3,
}

crate::snapshot::stored::stored!(History { h, substeps, displacement, turn, linear_before, momentum_before, linear, angular });

impl History {
    pub(crate) const NONE: Self = Self {
        h: 0.0,
        substeps: 0,
        displacement: Vec3::ZERO,
        turn: Vec3::ZERO,
        linear_before: Vec3::ZERO,
        momentum_before: Vec3::ZERO,
        linear: Vec3::ZERO,
        angular: Vec3::ZERO,
    };

    /// Of a body that sweeps have moved, and whose velocity was told with this lead.
    pub(crate) fn leading([linear, angular]: Twist) -> Self {
        Self { h: TOLD, linear_before: linear, momentum_before: angular, ..Self::NONE }
    }

    /// What its velocity was told with, if with anything.
    pub(crate) fn lead(&self) -> Option<Twist> {
        (self.h == TOLD).then_some([self.linear_before, self.momentum_before])
    }

    /// Forgets a lead: the body is at rest.
    pub(crate) fn forget_lead(&mut self) {
        if self.h == TOLD {
            *self = Self::NONE;
        }
    }

    /// Whether the body has moved at this rate ever since, and no other.
    pub(crate) fn leads_to(&self, rate: &Rate) -> bool {
        self.h > 0.0 && self.linear == rate.linear.as_vec3() && self.angular == rate.angular.as_vec3()
    }

    /// Change of velocity beyond a steady one, δ (m/s).
    pub(crate) fn surprise(&self, now: DVec3, next: DVec3, order: &SecondOrder) -> DVec3 {
        next - now - (now - self.linear_before.as_dvec3()) * order.ratio
    }
}

/// Rotation vector of a rotation by less than half a turn (rad).
pub(super) fn rotation_vector(rotation: DQuat) -> DVec3 {
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
