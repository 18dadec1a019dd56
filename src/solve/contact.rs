//! Contacts as the solver takes them.
//!
//! Each manifold of up to four points carries
//!
//! * normal rows C_i = n·(p_b − p_a) ≥ 0 with J = [−n, −r_a×n, n, r_b×n], taken at velocity level as J v + max(s_i, 0)/h ≥ 0 and
//!   solved together through their own 4×4 matrix A_ij = J_i M⁻¹ J_jᵀ; λ_i ≥ 0 (N·s) is carried from substep to substep;
//! * two tangential rows at the manifold's centre inside the Coulomb cone |λ_t| ≤ μ Σλ_i;
//! * one row about the normal, |λ_w| ≤ (μ r̄ + spin) Σλ_i, with r̄ the mean distance of the points from the centre (m);
//! * two rolling rows about the tangents, |λ_r| ≤ rolling Σλ_i, where the material asks for them.
//!
//! Points and normal are those of the start of the step; separations follow the bodies' displacements linearly.

use glam::Vec3;

use super::state::BodyVelocity;
pub(crate) use crate::contact::{ContactImpulses, POINTS, TOUCHED, tangents};
pub(crate) use crate::lanes::wide::{LANES, Lane, Lane3};
use crate::lanes::wide::{Wide, Wide3};
use crate::material::PairMaterial;

/// Share of its limit below which a friction multiplier is dropped before it becomes denormal.
pub(crate) const NEGLIGIBLE_FRICTION: f32 = 1.0e-9;

/// A manifold as the solver takes it: world axes, levers from the centres of mass.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactInput {
    pub a: u32,
    pub b: u32,
    /// From A to B.
    pub normal: Vec3,
    pub lever_a: [Vec3; POINTS],
    pub lever_b: [Vec3; POINTS],
    pub separation: [f32; POINTS],
    /// Separation up to which a point touches (m).
    pub touching: f32,
    pub count: usize,
    pub material: PairMaterial,
    pub impulses: ContactImpulses,
}

impl ContactInput {
    /// Whether it neither rebounds nor resists rolling or spinning by itself.
    pub(crate) fn is_plain(&self) -> bool {
        self.material.is_plain()
    }

    /// Whether any of its points has pressed in the last substep.
    pub(crate) fn presses(&self) -> bool {
        self.impulses.normal.iter().any(|&lambda| lambda > 0.0)
    }

    /// Speed at which one of its points opens (m/s).
    pub(crate) fn opening(&self, point: usize, velocities: &[BodyVelocity]) -> f32 {
        let [a, b] = [self.a, self.b].map(|slot| &velocities[slot as usize]);
        let of_a = a.linear + a.angular.cross(self.lever_a[point]);
        let of_b = b.linear + b.angular.cross(self.lever_b[point]);
        self.normal.dot(of_b - of_a)
    }

    /// How both bodies by themselves answer along its normal at a point (1/kg).
    pub(crate) fn own_ease(&self, point: usize, velocities: &[BodyVelocity]) -> f32 {
        let ends = [(self.a, self.lever_a[point]), (self.b, self.lever_b[point])];
        let each = ends.map(|(slot, lever)| {
            let (body, turn) = (&velocities[slot as usize], lever.cross(self.normal));
            (body.inverse_mass * self.normal).dot(self.normal) + body.inverse_inertia.mul(turn).dot(turn)
        });
        each[0] + each[1]
    }

    /// Whether a point of it closes faster than this (m/s).
    pub(crate) fn closes(&self, velocities: &[BodyVelocity], speed: f32) -> bool {
        (0..self.count).any(|point| -self.opening(point, velocities) > speed)
    }
}

/// As [`tangents`], to the same bits.
#[inline(always)]
pub(crate) fn tangents_in_lanes<W: Wide>(n: Wide3<W>) -> [Wide3<W>; 2] {
    let one = W::splat(1.0);
    let sign = one.with_sign_of(n.z);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    let t1 = Wide3::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x);
    [t1, n.cross(t1)]
}
