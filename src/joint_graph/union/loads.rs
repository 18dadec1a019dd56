//! Loads of the joints inside a union, from its motion, without solving them.
//!
//! The union moves as one body, so each member's motion is known, and with it the wrench that its joints together must exert: mass
//! times acceleration less all that acts on it from outside (d'Alembert). In a tree of joints statics alone decides what each
//! carries. In loops the joints' compliance decides. A joint that can break is as stiff as it is strong: a bond of area A and radius
//! r bears σA in tension and σAr/4 in bending, and has stiffnesses in the ratio of A and Ar²/4. Others are all equally stiff, with
//! rotational stiffness ℓ² times the linear one, ℓ² being the mean square of the levers from members' centres to joint points. With u the small displacements and
//! rotations of the members,
//!
//! ```text
//! K u = −n,    K = Σ_joints J_jᵀ D J_j,    D = k diag(1, 1, 1, ℓ², ℓ², ℓ²),    load of joint j on its body B = −D J_j u,
//! ```
//!
//! J_j u being the displacement and rotation of B against A at the joint. K is a graph Laplacian in blocks of six; in the union's
//! axes it never changes, so it is factorised once, and a step costs one solve. A union that nothing anchors has one member held,
//! whose reaction is what the given wrenches lack to balance: that imbalance is first spread over all members as a rigid
//! acceleration would be.

use glam::{DMat3, DVec3};

use crate::linalg::factor::{BlockFactor, BlockLayout, factorize, substitute};

/// Rows of a member: displacement and rotation.
const ROWS: usize = 6;

/// Lanes of four numbers that the factor gives a row of a block, and a member in a vector.
const LANES: usize = ROWS.div_ceil(4);

/// A force (N) and a torque (N·m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Wrench {
    pub force: DVec3,
    pub torque: DVec3,
}

/// A joint between two members, in the union's axes and from its centre; an anchor is no member.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UnionBond {
    pub members: [Option<u32>; 2],
    /// Joint point (m).
    pub point: DVec3,
    /// Linear stiffness k against that of the others, and the square of the length ℓ (m²), where its strength says them.
    pub stiffness: Option<[f64; 2]>,
}

/// A member as its inertia counts in the balance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UnionMember {
    /// Centre of mass (m), mass (kg), inertia in the union's axes (kg·m²).
    pub center: DVec3,
    pub mass: f64,
    pub inertia: DMat3,
}

/// The factorised stiffness of a union's joints.
#[derive(Debug, Clone)]
pub(crate) struct BondStiffness {
    bodies: Vec<UnionMember>,
    bonds: Vec<UnionBond>,
    /// Square of the length that makes rotations comparable with displacements (m²).
    turning: f64,
    /// Linear stiffness where a joint's strength says nothing: the mean of the others.
    usual: f64,
    anchored: bool,
    plan: BlockLayout,
    factor: BlockFactor,
}

impl BondStiffness {
    pub(crate) fn new(bodies: Vec<UnionMember>, bonds: Vec<UnionBond>) -> Self {
        let anchored = bonds.iter().any(|bond| bond.members.contains(&None));
        let levers = || bonds.iter().flat_map(|bond| bond.members.into_iter().flatten().map(|m| (m, bond.point)));
        let squares: f64 = levers().map(|(member, point)| (point - bodies[member as usize].center).length_squared()).sum();
        let mean = squares / levers().count().max(1) as f64;
        // Joints at the centres of their bodies have no levers: any length will do then.
        let turning = if mean > 0.0 { mean } else { 1.0 };
        let mut pairs: Vec<(u32, u32)> = bonds
            .iter()
            .filter_map(|bond| match bond.members {
                [Some(a), Some(b)] => Some((a.min(b), a.max(b))),
                _ => None,
            })
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        let rows = vec![ROWS as u32; bodies.len()];
        let plan = BlockLayout::new(&rows, &rows, &pairs, u64::MAX).expect("no limit is set");
        let said = || bonds.iter().filter_map(|bond| bond.stiffness);
        let usual = if said().count() > 0 { said().map(|[linear, _]| linear).sum::<f64>() / said().count() as f64 } else { 1.0 };
        let mut stiffness = Self { bodies, bonds, turning, usual, anchored, plan, factor: BlockFactor::default() };
        stiffness.assemble();
        factorize(&mut stiffness.factor, &stiffness.plan);
        stiffness
    }

    /// Linear and rotational stiffness of a bond.
    fn stiffness_of(&self, bond: &UnionBond) -> [f64; 2] {
        bond.stiffness.map_or([self.usual, self.usual * self.turning], |[linear, turning]| [linear, linear * turning])
    }

    /// J of a member at a bond: rates of displacement and rotation at the point, [1, −[r]×; 0, 1], negative for side A.
    fn jacobian(&self, member: u32, point: DVec3) -> [[f64; ROWS]; ROWS] {
        let r = point - self.bodies[member as usize].center;
        let mut j = [[0.0; ROWS]; ROWS];
        for (i, row) in j.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        // θ × r = −[r]× θ.
        (j[0][4], j[0][5]) = (r.z, -r.y);
        (j[1][3], j[1][5]) = (-r.z, r.x);
        (j[2][3], j[2][4]) = (r.y, -r.x);
        j
    }

    fn assemble(&mut self) {
        self.factor.start(&self.plan, &vec![ROWS as u32; self.bodies.len()]);
        let mut blocks: Vec<(u32, [f64; ROWS * ROWS])> = Vec::new();
        for bond in &self.bonds {
            let [linear, angular] = self.stiffness_of(bond);
            let weight = |row: usize| if row < 3 { linear } else { angular };
            let ends: Vec<(u32, [[f64; ROWS]; ROWS], f64)> = (0..2)
                .filter_map(|side| {
                    let member = bond.members[side]?;
                    Some((member, self.jacobian(member, bond.point), if side == 0 { -1.0 } else { 1.0 }))
                })
                .collect();
            for (a, ja, sign_a) in &ends {
                for (b, jb, sign_b) in &ends {
                    let Some((start, rows_are_b)) = self.plan.block(*a, *b) else { continue };
                    // Both orders of a pair name the same block: it is added once.
                    if a != b && rows_are_b {
                        continue;
                    }
                    let mut block = [0.0; ROWS * ROWS];
                    for i in 0..ROWS {
                        for k in 0..ROWS {
                            let sum: f64 = (0..ROWS).map(|l| ja[l][i] * weight(l) * jb[l][k]).sum();
                            block[i * ROWS + k] = sign_a * sign_b * sum;
                        }
                    }
                    blocks.push((start, block));
                }
            }
        }
        if !self.anchored && !self.bodies.is_empty() {
            // The first member is held; what it takes is nothing, as the wrenches are balanced.
            let start = self.plan.diagonal(0);
            let mut hold = [0.0; ROWS * ROWS];
            for i in 0..ROWS {
                hold[i * ROWS + i] = if i < 3 { self.usual } else { self.usual * self.turning };
            }
            blocks.push((start, hold));
        }
        for (start, block) in blocks {
            for (row, add) in self.factor.block_mut(start).chunks_mut(LANES).zip(block.chunks(ROWS)) {
                row.as_flattened_mut().iter_mut().zip(add).for_each(|(value, add)| *value += add);
            }
        }
    }

    /// Load of each joint on its body B about the joint point, in the union's axes; `needed` is the wrench about its centre that
    /// each member's joints together exert on it.
    pub(crate) fn solve(&self, needed: &[Wrench]) -> Vec<Wrench> {
        let mut needed = needed.to_vec();
        if !self.anchored {
            self.balance(&mut needed);
        }
        let mut u = vec![[0.0; 4]; self.factor.len()];
        for (lanes, wrench) in u.chunks_mut(LANES).zip(&needed) {
            let numbers = lanes.as_flattened_mut();
            numbers[..3].copy_from_slice(&wrench.force.to_array());
            numbers[3..ROWS].copy_from_slice(&wrench.torque.to_array());
        }
        // K u = −n, and the load on B is −D J u: both signs are left out.
        substitute(&self.factor, &self.plan, &mut u);
        let moved = |member: Option<u32>, point: DVec3| {
            member.map_or((DVec3::ZERO, DVec3::ZERO), |member| {
                let own = u[LANES * member as usize..].as_flattened();
                let (shift, turn) = (DVec3::from_slice(own), DVec3::from_slice(&own[3..]));
                (shift + turn.cross(point - self.bodies[member as usize].center), turn)
            })
        };
        let load = |bond: &UnionBond| {
            let [a, b] = bond.members.map(|member| moved(member, bond.point));
            let [linear, angular] = self.stiffness_of(bond);
            Wrench { force: (b.0 - a.0) * linear, torque: (b.1 - a.1) * angular }
        };
        self.bonds.iter().map(load).collect()
    }

    /// Takes from each member what a rigid acceleration of all would need, so that the sums of forces and torques are zero.
    fn balance(&self, needed: &mut [Wrench]) {
        let total: f64 = self.bodies.iter().map(|body| body.mass).sum();
        let center = self.bodies.iter().map(|body| body.center * body.mass).sum::<DVec3>() / total;
        let (mut force, mut torque, mut inertia) = (DVec3::ZERO, DVec3::ZERO, DMat3::ZERO);
        for (body, wrench) in self.bodies.iter().zip(needed.iter()) {
            let r = body.center - center;
            force += wrench.force;
            torque += wrench.torque + r.cross(wrench.force);
            inertia += body.inertia + (DMat3::from_diagonal(DVec3::splat(r.length_squared())) - super::outer(r, r)) * body.mass;
        }
        let (linear, angular) = (force / total, inertia.inverse() * torque);
        for (body, wrench) in self.bodies.iter().zip(needed) {
            wrench.force -= (linear + angular.cross(body.center - center)) * body.mass;
            wrench.torque -= body.inertia * angular;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f64, y: f64) -> UnionMember {
        UnionMember { center: DVec3::new(x, y, 0.0), mass: 1.0, inertia: DMat3::from_diagonal(DVec3::splat(1.0 / 6.0)) }
    }

    fn bond(a: Option<u32>, b: Option<u32>, x: f64, y: f64) -> UnionBond {
        UnionBond { members: [a, b], point: DVec3::new(x, y, 0.0), stiffness: None }
    }

    #[test]
    fn a_cantilever_carries_what_statics_says() {
        let count = 50_u32;
        let bodies: Vec<UnionMember> = (0..count).map(|i| cube(f64::from(i) + 0.5, 0.0)).collect();
        let bonds = (0..count).map(|i| bond(i.checked_sub(1), Some(i), f64::from(i), 0.0)).collect();
        let up = Wrench { force: DVec3::Y * 9.81, torque: DVec3::ZERO };
        let loads = BondStiffness::new(bodies, bonds).solve(&vec![up; count as usize]);
        for (i, load) in loads.iter().enumerate() {
            // Joint i holds all beyond it, whose centre is half their length away.
            let beyond = f64::from(count) - i as f64;
            let (force, moment) = (9.81 * beyond, 9.81 * beyond * beyond / 2.0);
            assert!((load.force - DVec3::Y * force).length() < 1.0e-6 * force, "joint {i}: {} N, {force} N", load.force);
            assert!((load.torque - DVec3::Z * moment).length() < 1.0e-6 * moment, "joint {i}: {} N·m, {moment} N·m", load.torque);
        }
    }

    #[test]
    fn a_free_ring_pulled_apart_shares_the_pull() {
        // Four cubes in a square; the left two are pulled left, the right two right: the horizontal joints carry it.
        let bodies = vec![cube(0.0, 0.0), cube(1.0, 0.0), cube(1.0, 1.0), cube(0.0, 1.0)];
        let bonds = vec![
            bond(Some(0), Some(1), 0.5, 0.0),
            bond(Some(1), Some(2), 1.0, 0.5),
            bond(Some(3), Some(2), 0.5, 1.0),
            bond(Some(3), Some(0), 0.0, 0.5),
        ];
        let pull = |sign: f64| Wrench { force: DVec3::X * sign, torque: DVec3::ZERO };
        let needed = [pull(1.0), pull(-1.0), pull(-1.0), pull(1.0)];
        let loads = BondStiffness::new(bodies, bonds).solve(&needed);
        for number in [0, 2] {
            assert!((loads[number].force + DVec3::X).length() < 1.0e-9, "{:?}", loads[number]);
        }
        for number in [1, 3] {
            assert!(loads[number].force.length() < 1.0e-9, "{:?}", loads[number]);
        }
        // What the joints give each member is what it needs, whatever the loop.
        let on_zero = -loads[0].force + loads[3].force;
        assert!((on_zero - DVec3::X).length() < 1.0e-9, "{on_zero}");
    }
}
