//! Second-order stepping: the backward differentiation formula of order two (Curtiss and Hirschfelder 1952), BDF2.
//!
//! With Δ = x_n − x_{n−1} the last substep's displacement,
//!
//! ```text
//! x̂ = x_n + Δ/3,   v̂ = v_n + (v_n − v_{n−1})/3,   h' = 2h/3,      x_{n+1} = x̂ + h' v_{n+1},   v_{n+1} = v̂ + h' a_{n+1}:
//! ```
//!
//! an implicit Euler substep of length h' from an extrapolated start, and as stable. Rotations follow with rotation vectors; what is
//! extrapolated of them is the angular momentum L = I ω, as I turns with the body: extrapolating ω would leave an error of first
//! order. It needs a substep of the same length before it; the first after an impact, an edit or a halving is of first order.

use glam::{DQuat, DVec3, Vec3};

use crate::solve::joint::Stance;
use crate::solve::joint::rows::Rate;
use crate::solve::rotation;

/// Share of a BDF2 substep that its Euler part is long.
pub(crate) const EULER_SHARE: f64 = 2.0 / 3.0;

/// A body's last substep, as its record keeps it from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct History {
    /// Length of the substep (s); zero where nothing is known.
    pub h: f32,
    /// Displacement (m) and rotation vector (rad).
    displacement: Vec3,
    turn: Vec3,
    /// Velocity and angular momentum at its start (m/s, N·m·s).
    linear_before: Vec3,
    momentum_before: Vec3,
    /// Velocities at its end: others mean that the body has been struck or edited since.
    linear: Vec3,
    angular: Vec3,
}

crate::snapshot::stored::stored!(History { h, displacement, turn, linear_before, momentum_before, linear, angular });

impl History {
    pub(crate) const NONE: Self = Self {
        h: 0.0,
        displacement: Vec3::ZERO,
        turn: Vec3::ZERO,
        linear_before: Vec3::ZERO,
        momentum_before: Vec3::ZERO,
        linear: Vec3::ZERO,
        angular: Vec3::ZERO,
    };

    /// Of a body that went from one state to another in a substep of length `h` (s).
    ///
    /// `momentum` is the angular momentum about the centre of mass in the first of them (N·m·s).
    pub(crate) fn of(h: f64, from: (&Stance, &Rate), momentum: DVec3, to: (&Stance, &Rate)) -> Self {
        Self {
            h: h as f32,
            displacement: (to.0.0 - from.0.0).as_vec3(),
            turn: rotation_vector(to.0.1 * from.0.1.conjugate()).as_vec3(),
            linear_before: from.1.linear.as_vec3(),
            momentum_before: momentum.as_vec3(),
            linear: to.1.linear.as_vec3(),
            angular: to.1.angular.as_vec3(),
        }
    }

    /// Whether it is that of a substep as long as this one, after which the body has moved at this rate.
    pub(crate) fn leads_to(&self, rate: &Rate, h: f64) -> bool {
        self.h == h as f32 && self.linear == rate.linear.as_vec3() && self.angular == rate.angular.as_vec3()
    }

    /// Extrapolated start of the next substep: stance, velocity (m/s) and angular momentum (N·m·s); `momentum` is that of now.
    pub(crate) fn extrapolate(&self, stance: &Stance, rate: &Rate, momentum: DVec3) -> (Stance, DVec3, DVec3) {
        let third = 1.0 / 3.0;
        let displacement = stance.0 + self.displacement.as_dvec3() * third;
        let rotation = rotation::rotated(stance.1, self.turn.as_dvec3() * third);
        let linear = rate.linear + (rate.linear - self.linear_before.as_dvec3()) * third;
        ((displacement, rotation), linear, momentum + (momentum - self.momentum_before.as_dvec3()) * third)
    }
}

/// Rotation vector of a rotation by less than half a turn (rad).
fn rotation_vector(rotation: DQuat) -> DVec3 {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    let axis = DVec3::new(rotation.x, rotation.y, rotation.z);
    let sine = axis.length();
    if sine < 1.0e-8 {
        return axis * 2.0;
    }
    axis * (2.0 * libm::atan2(sine, rotation.w) / sine)
}
