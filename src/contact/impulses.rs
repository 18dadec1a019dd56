//! Multipliers of a manifold.

use glam::Vec3;

/// Points of a manifold.
pub(crate) const POINTS: usize = 4;

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

/// Two unit vectors that complete `n` to a right-handed frame (Duff et al. 2017).
pub(crate) fn tangents(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let t1 = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    (t1, n.cross(t1))
}
