//! Contact rows in blocks of eight manifolds of one colour, laid out for SIMD lanes.
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

use glam::{Vec2, Vec3, Vec4};

use super::state::BodyMotion;
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
#[derive(Debug, Clone, Copy)]
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
    /// Whether it neither rebounds nor resists rolling.
    pub(crate) fn is_plain(&self) -> bool {
        self.material.restitution == 0.0 && self.material.rolling == 0.0
    }

    /// Whether any of its points has pressed in the last substep.
    pub(crate) fn presses(&self) -> bool {
        self.impulses.normal.iter().any(|&lambda| lambda > 0.0)
    }
}

/// Eight manifolds; unused lanes act on the world slot and do nothing.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(crate) struct ContactBlock {
    pub a: [u32; LANES],
    pub b: [u32; LANES],
    pub normal: Lane3,
    pub tangent: Lane3,
    pub center_a: Lane3,
    pub center_b: Lane3,
    pub lever_a: [Lane3; POINTS],
    pub lever_b: [Lane3; POINTS],
    /// A_ij for i < j: 01, 02, 03, 12, 13, 23.
    pub coupling: [Lane; 6],
    /// (A + ε)⁻¹ on the points that exist: 00, 11, 22, 33, 01, 02, 03, 12, 13, 23.
    pub inverse: [Lane; 10],
    /// A_ii, and its inverse; the inverse is zero for points that do not exist.
    pub diagonal: [Lane; POINTS],
    pub inverse_diagonal: [Lane; POINTS],
    /// Separation at the start of the step (m).
    pub separation: [Lane; POINTS],
    /// max(s, 0)/h of this substep (m/s).
    pub closing_speed: [Lane; POINTS],
    pub lambda: [Lane; POINTS],
    /// Inverse of the tangential 2×2 matrix: 11, 12, 22.
    pub tangent_mass: [Lane; 3],
    pub tangent_lambda: [Lane; 2],
    pub friction: Lane,
    pub twist_mass: Lane,
    pub twist_lambda: Lane,
    /// Torque limit about the normal per normal force (m).
    pub twist_arm: Lane,
    /// Inverse of the angular 2×2 matrix about the tangents: 11, 12, 22.
    pub rolling_mass: [Lane; 3],
    pub rolling_lambda: [Lane; 2],
    /// Torque limit about the tangents per normal force (m).
    pub rolling_arm: Lane,
    pub restitution: Lane,
    /// Normal velocity at the moment of impact, negative when approaching (m/s); zero where there was none.
    pub impact_speed: [Lane; POINTS],
    /// Greatest multiplier of each point in this step (N·s).
    pub peak_lambda: [Lane; POINTS],
    /// Points of each manifold.
    pub count: [u8; LANES],
    pub has_rolling: bool,
    pub has_restitution: bool,
    /// Whether any manifold has more than one point.
    pub has_faces: bool,
}

impl ContactBlock {
    pub(crate) const EMPTY: Self = Self {
        a: [0; LANES],
        b: [0; LANES],
        normal: [[0.0; LANES]; 3],
        tangent: [[0.0; LANES]; 3],
        center_a: [[0.0; LANES]; 3],
        center_b: [[0.0; LANES]; 3],
        lever_a: [[[0.0; LANES]; 3]; POINTS],
        lever_b: [[[0.0; LANES]; 3]; POINTS],
        coupling: [[0.0; LANES]; 6],
        inverse: [[0.0; LANES]; 10],
        diagonal: [[0.0; LANES]; POINTS],
        inverse_diagonal: [[0.0; LANES]; POINTS],
        separation: [[0.0; LANES]; POINTS],
        closing_speed: [[0.0; LANES]; POINTS],
        lambda: [[0.0; LANES]; POINTS],
        tangent_mass: [[0.0; LANES]; 3],
        tangent_lambda: [[0.0; LANES]; 2],
        friction: [0.0; LANES],
        twist_mass: [0.0; LANES],
        twist_lambda: [0.0; LANES],
        twist_arm: [0.0; LANES],
        rolling_mass: [[0.0; LANES]; 3],
        rolling_lambda: [[0.0; LANES]; 2],
        rolling_arm: [0.0; LANES],
        restitution: [0.0; LANES],
        impact_speed: [[0.0; LANES]; POINTS],
        peak_lambda: [[0.0; LANES]; POINTS],
        count: [0; LANES],
        has_rolling: false,
        has_restitution: false,
        has_faces: false,
    };

    /// Prepares one manifold in lane `l`, all but its effective masses; points closer than `reach` (m) count as touching.
    pub(crate) fn set_lane(&mut self, l: usize, input: &ContactInput, reach: f32) {
        let n = input.normal;
        let (t1, t2) = tangents(n);

        self.a[l] = input.a;
        self.b[l] = input.b;
        put(&mut self.normal, l, n);
        put(&mut self.tangent, l, t1);

        let count = input.count;
        for i in 0..count {
            put(&mut self.lever_a[i], l, input.lever_a[i]);
            put(&mut self.lever_b[i], l, input.lever_b[i]);
            self.separation[i][l] = input.separation[i];
            self.lambda[i][l] = input.impulses.normal[i];
        }
        let inverse_count = 1.0 / count as f32;
        let center_a = input.lever_a[..count].iter().sum::<Vec3>() * inverse_count;
        let center_b = input.lever_b[..count].iter().sum::<Vec3>() * inverse_count;
        put(&mut self.center_a, l, center_a);
        put(&mut self.center_b, l, center_b);
        self.count[l] = count as u8;
        self.has_faces |= count > 1;
        self.has_rolling |= input.material.rolling > 0.0;
        if count == POINTS {
            self.level(l, reach);
        }

        let pressed: f32 = input.impulses.normal.iter().sum();
        let carried = |lambda: f32| if lambda.abs() > NEGLIGIBLE_FRICTION * pressed { lambda } else { 0.0 };
        self.friction[l] = input.material.friction;
        self.tangent_lambda[0][l] = carried(input.impulses.friction.dot(t1));
        self.tangent_lambda[1][l] = carried(input.impulses.friction.dot(t2));
        let spread = input.lever_a[..count].iter().map(|lever| (*lever - center_a).length()).sum::<f32>() * inverse_count;
        self.twist_lambda[l] = carried(input.impulses.twist);
        self.twist_arm[l] = input.material.friction * spread + input.material.spinning;
        if input.material.rolling > 0.0 {
            self.rolling_arm[l] = input.material.rolling;
            self.rolling_lambda[0][l] = input.impulses.rolling.dot(t1);
            self.rolling_lambda[1][l] = input.impulses.rolling.dot(t2);
        }
        if input.material.restitution > 0.0 {
            self.has_restitution = true;
            self.restitution[l] = input.material.restitution;
        }
    }

    /// Whether the inertia of any of its bodies has been formed anew.
    pub(crate) fn is_refreshed(&self, motions: &[BodyMotion]) -> bool {
        self.a.iter().chain(&self.b).any(|&slot| motions[slot as usize].refreshed)
    }

    /// Evens out the load of four touching points in lane `l` without changing its force or moments.
    ///
    /// Four points of a face have one combination ν of multipliers that does nothing: Σν = 0, Σν r = 0. Where some of them
    /// overlap by a micrometre and others gape by one, their rows contradict each other along ν, and the sweeps would shift the
    /// load along it until two points carry all and the face rocks on a diagonal.
    fn level(&mut self, l: usize, reach: f32) {
        if (0..POINTS).any(|i| self.separation[i][l] > reach) {
            return;
        }
        let (n, t1) = (get(&self.normal, l), get(&self.tangent, l));
        let t2 = n.cross(t1);
        let p: [Vec2; POINTS] = std::array::from_fn(|i| {
            let lever = get(&self.lever_a[i], l);
            Vec2::new(lever.dot(t1), lever.dot(t2))
        });
        let area = |a: Vec2, b: Vec2, c: Vec2| (b - a).perp_dot(c - a);
        let idle = Vec4::new(area(p[1], p[2], p[3]), -area(p[0], p[2], p[3]), area(p[0], p[1], p[3]), -area(p[0], p[1], p[2]));
        let Some(idle) = idle.try_normalize() else { return };
        let lambda = Vec4::from_array(std::array::from_fn(|i| self.lambda[i][l]));
        let shift = idle * idle.dot(lambda);
        let least = (lambda - shift).min_element();
        if least >= 0.0 {
            for i in 0..POINTS {
                self.lambda[i][l] = lambda[i] - shift[i];
            }
        }
    }

    /// Multipliers of lane `l` at the end of the last substep.
    pub(crate) fn impulses(&self, l: usize) -> ContactImpulses {
        let n = get(&self.normal, l);
        let t1 = get(&self.tangent, l);
        let t2 = n.cross(t1);
        ContactImpulses {
            normal: std::array::from_fn(|i| self.lambda[i][l]),
            friction: t1 * self.tangent_lambda[0][l] + t2 * self.tangent_lambda[1][l],
            twist: self.twist_lambda[l],
            rolling: t1 * self.rolling_lambda[0][l] + t2 * self.rolling_lambda[1][l],
        }
    }

    /// Levers of a point of lane `l`.
    pub(crate) fn levers_of(&self, point: usize, l: usize) -> (Vec3, Vec3) {
        (get(&self.lever_a[point], l), get(&self.lever_b[point], l))
    }

    /// Levers of the middle of lane `l`, where friction acts.
    pub(crate) fn centers_of(&self, l: usize) -> (Vec3, Vec3) {
        (get(&self.center_a, l), get(&self.center_b, l))
    }

    /// Normal of lane `l`.
    pub(crate) fn normal_of(&self, l: usize) -> Vec3 {
        get(&self.normal, l)
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

fn put(lanes: &mut Lane3, l: usize, v: Vec3) {
    lanes[0][l] = v.x;
    lanes[1][l] = v.y;
    lanes[2][l] = v.z;
}

fn get(lanes: &Lane3, l: usize) -> Vec3 {
    Vec3::new(lanes[0][l], lanes[1][l], lanes[2][l])
}
