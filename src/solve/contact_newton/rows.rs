//! Rows of one manifold, and their response at given velocities.
//!
//! Each row has a multiplier λ₀ that it starts from and a compliance ε (small against J M⁻¹ Jᵀ). At the rate ρ = J v + c it answers
//! with the projection of λ₀ − ρ/ε onto what a contact can give: λ ≥ 0 along the normal, the disc |λ_t| ≤ μ L and the interval
//! |λ_w| ≤ r L, with L the manifold's load. That is minus the gradient of a convex function of v, and where λ = λ₀ it is exact.

#![expect(clippy::needless_range_loop, reason = "an index runs over rows of several arrays alike")]

use glam::{DMat3, DVec3};

use super::super::contact::{POINTS, tangents};
use super::super::contact_block::ContactBlocks;

/// Most rows of a manifold: normals, two tangents, twist.
pub(super) const ROWS: usize = POINTS + 3;

/// A body that no row can move.
pub(super) const FIXED: u32 = u32::MAX;

/// What is added to the rate of a row that has a gap left, so that it answers nothing (m/s): above any closing speed of two bodies, which have 1e4 at most
/// each and as much by their turns, and a power of two, which is taken off again without a rounding of what matters.
const OPEN: f64 = 131_072.0;

/// Velocity or momentum of a body: linear, then angular.
pub(super) type Six = [f64; 6];

pub(super) fn dot(a: &Six, b: &Six) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// Adds w a bᵀ.
pub(super) fn add_product(sum: &mut [Six; 6], a: &Six, b: &Six, weight: f64) {
    for (sum, a) in sum.iter_mut().zip(a) {
        let factor = weight * a;
        sum.iter_mut().zip(b).for_each(|(sum, b)| *sum += factor * b);
    }
}

/// A body as the rows see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExactBody {
    pub slot: u32,
    pub island: u32,
    pub mass: f64,
    pub inertia: DMat3,
    pub inverse_inertia: DMat3,
}

impl ExactBody {
    /// What a push and a turn do to its velocity.
    pub(super) fn respond(&self, momentum: &Six) -> Six {
        let [x, y, z, u, v, w] = *momentum;
        let turn = self.inverse_inertia * DVec3::new(u, v, w);
        [x / self.mass, y / self.mass, z / self.mass, turn.x, turn.y, turn.z]
    }

    /// Momentum of a velocity.
    pub(super) fn momentum(&self, velocity: &Six) -> Six {
        let [x, y, z, u, v, w] = *velocity;
        let turn = self.inertia * DVec3::new(u, v, w);
        [x * self.mass, y * self.mass, z * self.mass, turn.x, turn.y, turn.z]
    }
}

/// The rows of a manifold between two bodies: normals first, then two tangents and the twist.
#[derive(Debug, Clone, Copy)]
pub(super) struct NewtonContact {
    pub island: u32,
    pub block: u32,
    pub lane: u8,
    /// Whether it touches what moves by itself.
    pub is_driven: bool,
    pub normals: u8,
    /// Bodies of the island, or [`FIXED`], and their slots.
    pub bodies: [u32; 2],
    pub slots: [u32; 2],
    /// Of each row, for both bodies.
    pub jacobian: [[Six; 2]; ROWS],
    /// Rate at which the row is at rest, negative: closing speeds of gaps, and what moves by itself (m/s, rad/s).
    pub bias: [f64; ROWS],
    /// Gaps after a blow, over the substep (m/s).
    gap: [f64; POINTS],
    inverse_mass: [f64; ROWS],
    pub compliance: [f64; ROWS],
    /// Multipliers of the warm start, which the velocities have in them, and those that the answers start from.
    pub warm: [f64; ROWS],
    pub lambda: [f64; ROWS],
    /// Multipliers that are carried on from a blow.
    pub carried: [f64; ROWS],
    pub friction: f64,
    pub twist_arm: f64,
    /// L, the load of which friction is a share.
    pub load: f64,
}

impl NewtonContact {
    pub(super) fn new(contacts: &ContactBlocks, block: u32, lane: usize, bodies: [u32; 2]) -> Self {
        let of = &contacts.blocks[block as usize];
        let normals = usize::from(of.count[lane]);
        let normal = of.normal_of(lane);
        let (t1, t2) = tangents(normal);
        let (center_a, center_b) = contacts.centers_of(block as usize, lane);
        let mut jacobian = [[[0.0; 6]; 2]; ROWS];
        let put = |direction: glam::Vec3, (lever_a, lever_b): (glam::Vec3, glam::Vec3)| {
            let [push, lever_a, lever_b] = [direction, lever_a, lever_b].map(|v| v.as_dvec3());
            let (turn_a, turn_b) = (lever_a.cross(push), lever_b.cross(push));
            [[-push.x, -push.y, -push.z, -turn_a.x, -turn_a.y, -turn_a.z], [push.x, push.y, push.z, turn_b.x, turn_b.y, turn_b.z]]
        };
        for (i, row) in jacobian.iter_mut().enumerate().take(normals) {
            *row = put(normal, contacts.rows(block as usize, i).levers_of(lane));
        }
        jacobian[normals] = put(t1, (center_a, center_b));
        jacobian[normals + 1] = put(t2, (center_a, center_b));
        let about = normal.as_dvec3();
        jacobian[normals + 2] = [[0.0, 0.0, 0.0, -about.x, -about.y, -about.z], [0.0, 0.0, 0.0, about.x, about.y, about.z]];
        Self {
            island: 0,
            block,
            lane: lane as u8,
            is_driven: false,
            normals: normals as u8,
            bodies,
            slots: [of.a[lane], of.b[lane]],
            jacobian,
            bias: [0.0; ROWS],
            gap: [0.0; POINTS],
            inverse_mass: [1.0; ROWS],
            compliance: [1.0; ROWS],
            warm: [0.0; ROWS],
            lambda: [0.0; ROWS],
            carried: [0.0; ROWS],
            friction: f64::from(of.friction[lane]),
            twist_arm: contacts.twist_of(block as usize).map_or(0.0, |twist| f64::from(twist.arm[lane])),
            load: 0.0,
        }
    }

    pub(super) fn normals(&self) -> usize {
        usize::from(self.normals)
    }

    /// Rows of normals and friction.
    pub(super) fn rows(&self) -> usize {
        self.normals() + 3
    }

    /// Takes multipliers and closing speeds of now from its block; `fixed` are the velocities of bodies that it cannot move.
    pub(super) fn load(&mut self, contacts: &ContactBlocks, fixed: [Option<Six>; 2]) {
        let (number, lane, normals) = (self.block as usize, usize::from(self.lane), self.normals());
        let block = &contacts.blocks[number];
        for i in 0..normals {
            let rows = contacts.rows(number, i);
            self.bias[i] = f64::from(rows.closing_speed[lane]);
            self.warm[i] = f64::from(rows.lambda[lane]);
        }
        self.bias[normals..].fill(0.0);
        self.warm[normals] = f64::from(block.tangent_lambda[0][lane]);
        self.warm[normals + 1] = f64::from(block.tangent_lambda[1][lane]);
        self.warm[normals + 2] = contacts.twist_of(number).map_or(0.0, |twist| f64::from(twist.lambda[lane]));
        self.is_driven = fixed.iter().flatten().any(|velocity| velocity.iter().any(|&speed| speed != 0.0));
        for (side, velocity) in fixed.iter().enumerate() {
            if let Some(velocity) = velocity {
                for row in 0..self.rows() {
                    self.bias[row] += dot(&self.jacobian[row][side], velocity);
                }
            }
        }
        (self.lambda, self.carried) = (self.warm, self.warm);
        self.take_load();
    }

    /// Takes the gaps that bodies leave which move with these velocities through the substep, and begins a solve of what touches then, from no
    /// multipliers.
    pub(super) fn look_ahead(&mut self, contacts: &ContactBlocks, velocities: &[Six]) {
        let rates = self.rates(velocities);
        for i in 0..self.normals() {
            self.bias[i] -= f64::from(contacts.rows(self.block as usize, i).closing_speed[usize::from(self.lane)]);
            self.gap[i] = rates[i].max(0.0);
            self.bias[i] += if self.gap[i] > 0.0 { OPEN } else { 0.0 };
        }
        self.begin_anew();
    }

    fn begin_anew(&mut self) {
        (self.warm, self.lambda, self.load) = ([0.0; ROWS], [0.0; ROWS], 0.0);
    }

    /// Begins a solve of the substep to come.
    pub(super) fn begin_next(&mut self) {
        for i in (0..self.normals()).filter(|&i| self.gap[i] > 0.0) {
            self.bias[i] += self.gap[i] - OPEN;
        }
        self.begin_anew();
    }

    /// The same for what is added to these velocities: normals that close in by a rounding are at rest.
    pub(super) fn rest(&mut self, velocities: &[Six]) {
        let normals = self.normals();
        self.bias = self.rates(velocities);
        self.bias[..normals].iter_mut().for_each(|rate| *rate = rate.max(0.0));
    }

    /// Sets the load that friction is a share of from the multipliers of now.
    pub(super) fn take_load(&mut self) {
        self.load = self.lambda[..self.normals()].iter().sum();
    }

    /// Takes the load anew; says by how much friction that is at its limit is off, as a rate over the share of compliance.
    pub(super) fn take_new_load(&mut self) -> f64 {
        let (normals, before) = (self.normals(), self.load);
        self.take_load();
        let slides = |size: f64, arm: f64| size >= arm * before.min(self.load) && arm > 0.0;
        let off = |row: usize, size: f64, arm: f64| {
            if slides(size, arm) { (self.load - before).abs() * arm * self.compliance[row] } else { 0.0 }
        };
        let [u, v, twist] = [0, 1, 2].map(|row| self.lambda[normals + row]);
        off(normals, length(u, v), self.friction).max(off(normals + 2, twist.abs(), self.twist_arm))
    }

    /// Gives these multipliers to its block.
    pub(super) fn store(&self, lambda: &[f64; ROWS], contacts: &mut ContactBlocks) {
        let (number, lane, normals) = (self.block as usize, usize::from(self.lane), self.normals());
        for i in 0..normals {
            contacts.rows_mut(number, i).lambda[lane] = lambda[i] as f32;
        }
        let block = &mut contacts.blocks[number];
        block.tangent_lambda[0][lane] = lambda[normals] as f32;
        block.tangent_lambda[1][lane] = lambda[normals + 1] as f32;
        if let Some(twist) = contacts.twist_mut(number) {
            twist.lambda[lane] = lambda[normals + 2] as f32;
        }
    }

    /// Adds its multipliers to those of its block.
    pub(super) fn add_to(&self, contacts: &mut ContactBlocks) {
        let mut sum = Self { ..*self };
        sum.load(contacts, [None; 2]);
        let total = std::array::from_fn(|row| sum.warm[row] + self.lambda[row]);
        self.store(&total, contacts);
    }

    /// J v + c of every row.
    pub(super) fn rates(&self, velocities: &[Six]) -> [f64; ROWS] {
        self.add_rates(self.bias, velocities)
    }

    /// J v of every row.
    pub(super) fn raw_rates(&self, velocities: &[Six]) -> [f64; ROWS] {
        self.add_rates([0.0; ROWS], velocities)
    }

    fn add_rates(&self, mut rates: [f64; ROWS], velocities: &[Six]) -> [f64; ROWS] {
        for (side, &body) in self.bodies.iter().enumerate().filter(|(_, body)| **body != FIXED) {
            for row in 0..self.rows() {
                rates[row] += dot(&self.jacobian[row][side], &velocities[body as usize]);
            }
        }
        rates
    }

    /// How far the rows are from what they ask for (m/s, rad/s): what an answer of their own to these rates would change.
    pub(super) fn error(&self, rates: &[f64; ROWS]) -> f64 {
        let mut answer: [f64; ROWS] = std::array::from_fn(|row| self.lambda[row] - rates[row] / self.inverse_mass[row]);
        self.project(&mut answer, self.load);
        (0..self.rows()).map(|row| (answer[row] - self.lambda[row]).abs() * self.inverse_mass[row]).fold(0.0, f64::max)
    }

    /// How fast its points close in at these rates (m/s).
    pub(super) fn closing_speed(&self, rates: &[f64; ROWS]) -> f64 {
        rates[..self.normals()].iter().fold(0.0, |most, rate| most.max(-rate))
    }

    /// Whether its material rebounds.
    pub(super) fn rebounds(&self, contacts: &ContactBlocks) -> bool {
        let extra = contacts.extras.get(contacts.blocks[self.block as usize].extra as usize);
        extra.is_some_and(|extra| extra.restitution[usize::from(self.lane)] > 0.0)
    }

    /// Changes velocities by a share of these multipliers.
    pub(super) fn push(&self, lambda: &[f64; ROWS], share: f64, bodies: &[ExactBody], velocities: &mut [Six]) {
        for (side, &body) in self.bodies.iter().enumerate().filter(|(_, body)| **body != FIXED) {
            let mut momentum = [0.0; 6];
            for row in 0..self.rows() {
                momentum.iter_mut().zip(self.jacobian[row][side]).for_each(|(sum, entry)| *sum += share * lambda[row] * entry);
            }
            let change = bodies[body as usize].respond(&momentum);
            velocities[body as usize].iter_mut().zip(change).for_each(|(speed, change)| *speed += change);
        }
    }

    /// Finds J M⁻¹ Jᵀ of its rows for these bodies of its island.
    pub(super) fn find_masses(&mut self, bodies: &[ExactBody]) {
        for row in 0..self.rows() {
            let sides = self.bodies.iter().zip(&self.jacobian[row]).filter(|(body, _)| **body != FIXED);
            self.inverse_mass[row] = sides.map(|(&body, row)| dot(row, &bodies[body as usize].respond(row))).sum();
        }
    }

    /// Makes its rows as compliant as this share of J M⁻¹ Jᵀ.
    pub(super) fn set_compliance(&mut self, share: f64) {
        for row in 0..self.rows() {
            self.compliance[row] = share * self.inverse_mass[row];
        }
    }

    /// Cosine of its normal, from A to B, to the vertical.
    pub(super) fn rise(&self, up: glam::Vec3) -> f64 {
        let [x, y, z, ..] = self.jacobian[0][1];
        DVec3::new(x, y, z).dot(up.as_dvec3())
    }

    /// What the rows answer at these rates, bias included.
    pub(super) fn answer(&self, rates: &[f64; ROWS]) -> [f64; ROWS] {
        let mut answer = [0.0; ROWS];
        for row in 0..self.rows() {
            answer[row] = self.lambda[row] - rates[row] / self.compliance[row];
        }
        self.project(&mut answer, self.load);
        answer
    }

    /// Cuts multipliers to what a contact under this load can give.
    pub(super) fn project(&self, lambda: &mut [f64; ROWS], load: f64) {
        let normals = self.normals();
        lambda[..normals].iter_mut().for_each(|lambda| *lambda = lambda.max(0.0));
        let (limit, size) = (self.friction * load, length(lambda[normals], lambda[normals + 1]));
        if size > limit {
            let share = limit / size;
            lambda[normals] *= share;
            lambda[normals + 1] *= share;
        }
        let limit = self.twist_arm * load;
        lambda[normals + 2] = lambda[normals + 2].clamp(-limit, limit);
    }

    /// How the answer stiffens each row at these rates, −∂λ/∂ρ, as rows of rank one: factors over the rows, and a weight each.
    pub(super) fn stiffness(&self, rates: &[f64; ROWS], mut add: impl FnMut(&[Six; 2], f64)) {
        let normals = self.normals();
        let free = |row: usize| self.lambda[row] - rates[row] / self.compliance[row];
        for row in (0..normals).filter(|&row| free(row) > 0.0) {
            add(&self.jacobian[row], 1.0 / self.compliance[row]);
        }
        let (u, v) = (free(normals), free(normals + 1));
        let (limit, size, weight) = (self.friction * self.load, length(u, v), 1.0 / self.compliance[normals]);
        let [first, second] = [self.jacobian[normals], self.jacobian[normals + 1]];
        if size <= limit {
            add(&first, weight);
            add(&second, weight);
        } else if limit > 0.0 {
            // It slides: along the slip nothing answers, across it the direction of friction turns.
            let (along_first, along_second) = (-v / size, u / size);
            let mut across = [[0.0; 6]; 2];
            for side in 0..2 {
                for i in 0..6 {
                    across[side][i] = along_first * first[side][i] + along_second * second[side][i];
                }
            }
            add(&across, weight * limit / size);
        }
        if free(normals + 2).abs() <= self.twist_arm * self.load {
            add(&self.jacobian[normals + 2], 1.0 / self.compliance[normals + 2]);
        }
    }
}
