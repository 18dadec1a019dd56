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

use super::wide::{Wide, Wide3};
use crate::material::PairMaterial;

/// Manifolds in a block.
pub(crate) const LANES: usize = 8;
/// Points of a manifold.
pub(crate) const POINTS: usize = 4;

/// Share of its limit below which a friction multiplier is dropped before it becomes denormal.
pub(crate) const NEGLIGIBLE_FRICTION: f32 = 1.0e-9;

/// One number for each manifold of a block.
pub(crate) type Lane = [f32; LANES];
/// One vector for each manifold of a block: x, y, z.
pub(crate) type Lane3 = [Lane; 3];

/// Multiplier that says that a point has been hit in the step and has rebounded, and that pushes nothing (N·s).
pub(crate) const TOUCHED: f32 = 1.0e-30;

/// Multipliers of a manifold, to start the next substep or step from.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct ContactImpulses {
    /// Along the normal at each point (N·s), ≥ 0.
    pub normal: [f32; POINTS],
    /// Friction on B in world axes (N·s).
    pub friction: Vec3,
    /// About the normal (N·m·s).
    pub twist: f32,
    /// Rolling friction on B in world axes (N·m·s).
    pub rolling: Vec3,
}

impl ContactImpulses {
    pub(crate) fn scaled(&self, factor: f32) -> Self {
        Self {
            normal: self.normal.map(|lambda| lambda * factor),
            friction: self.friction * factor,
            twist: self.twist * factor,
            rolling: self.rolling * factor,
        }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.normal.iter_mut().zip(other.normal).for_each(|(lambda, more)| *lambda += more);
        self.friction += other.friction;
        self.twist += other.twist;
        self.rolling += other.rolling;
    }

    /// Impulse on B (N·s), and its moment about where the levers begin (N·m·s).
    pub(crate) fn wrench(&self, normal: Vec3, levers: &[Vec3]) -> (Vec3, Vec3) {
        let pressed: Vec3 = levers.iter().zip(self.normal).map(|(lever, lambda)| lever.cross(normal) * lambda).sum();
        let center = levers.iter().sum::<Vec3>() / levers.len().max(1) as f32;
        let force = normal * self.normal[..levers.len()].iter().sum::<f32>() + self.friction;
        (force, pressed + center.cross(self.friction) + normal * self.twist + self.rolling)
    }
}

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
}

/// Two unit vectors that complete `n` to a right-handed frame (Duff et al. 2017).
pub(crate) fn tangents(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let t1 = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    (t1, n.cross(t1))
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
