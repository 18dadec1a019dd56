//! Joint rows as a sweep solves them, one after another: in `f32`, each with its own effective mass.

use glam::{Mat3, Vec3};

use super::rows::{self, Held};
use crate::solve::state::BodyVelocity;

/// Three rows solved together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockRow {
    pub lever_a: Vec3,
    pub lever_b: Vec3,
    /// (J M⁻¹ Jᵀ + γ)⁻¹ on the held directions, zero on the others.
    mass: Mat3,
    bias: Vec3,
    gamma: f32,
    pub impulse: Vec3,
}

/// Inverse of `k` on the held directions.
fn inverse_on(held: Held, k: Mat3) -> Mat3 {
    match held {
        Held::All => inverse_or_zero(k),
        Held::Across(axis) => {
            let (u, v) = crate::solve::contact::tangents(axis.as_vec3());
            let (a, b, c) = (u.dot(k * u), u.dot(k * v), v.dot(k * v));
            let determinant = a * c - b * b;
            if determinant <= f32::EPSILON * a * c {
                return Mat3::ZERO;
            }
            let outer = |x: Vec3, y: Vec3| Mat3::from_cols(x * y.x, x * y.y, x * y.z);
            (outer(u, u) * c - (outer(u, v) + outer(v, u)) * b + outer(v, v) * a) * (1.0 / determinant)
        }
    }
}

fn inverse_or_zero(k: Mat3) -> Mat3 {
    let determinant = k.determinant();
    let scale = k.x_axis.x * k.y_axis.y * k.z_axis.z;
    if determinant > 1.0e-7 * scale { k.inverse() } else { Mat3::ZERO }
}

impl BlockRow {
    /// A row on points.
    pub(crate) fn point(row: &rows::BlockRow, [a, b]: [&BodyVelocity; 2]) -> Self {
        let response = |body: &BodyVelocity, lever: Vec3| {
            let arm = crate::solve::integrate::skew(lever);
            Mat3::from_diagonal(body.inverse_mass) - arm * body.inverse_inertia.to_mat3() * arm
        };
        let [lever_a, lever_b] = row.levers.map(|lever| lever.as_vec3());
        Self::new(row, response(a, lever_a) + response(b, lever_b))
    }

    /// A row on directions.
    pub(crate) fn direction(row: &rows::BlockRow, [a, b]: [&BodyVelocity; 2]) -> Self {
        Self::new(row, a.inverse_inertia.to_mat3() + b.inverse_inertia.to_mat3())
    }

    fn new(row: &rows::BlockRow, k: Mat3) -> Self {
        let [lever_a, lever_b] = row.levers.map(|lever| lever.as_vec3());
        let gamma = row.gamma as f32;
        let mass = inverse_on(row.held, k + Mat3::from_diagonal(Vec3::splat(gamma)));
        let mass = if row.acts { mass } else { Mat3::ZERO };
        Self { lever_a, lever_b, mass, bias: row.bias.as_vec3(), gamma, impulse: row.impulse }
    }

    /// Impulse that makes the row hold, for a row on points.
    pub(crate) fn solve_point(&mut self, a: &mut BodyVelocity, b: &mut BodyVelocity) {
        let rate = b.linear + b.angular.cross(self.lever_b) - a.linear - a.angular.cross(self.lever_a);
        let change = self.change(rate);
        a.apply(-change, -self.lever_a.cross(change));
        b.apply(change, self.lever_b.cross(change));
    }

    /// Impulse that makes the row hold, for a row on directions.
    pub(crate) fn solve_direction(&mut self, a: &mut BodyVelocity, b: &mut BodyVelocity) {
        let change = self.change(b.angular - a.angular);
        a.apply(Vec3::ZERO, -change);
        b.apply(Vec3::ZERO, change);
    }

    fn change(&mut self, rate: Vec3) -> Vec3 {
        let change = self.mass * -(rate + self.bias + self.impulse * self.gamma);
        self.impulse += change;
        change
    }
}

/// One row along a coordinate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScalarRow {
    pub linear: Vec3,
    angular_a: Vec3,
    pub angular_b: Vec3,
    response_a: Vec3,
    response_b: Vec3,
    mass: f32,
    bias: f32,
    gamma: f32,
    pub impulse: f32,
    min: f32,
    max: f32,
    /// Place of its multiplier in the joint's record.
    pub id: u8,
}

impl ScalarRow {
    pub(crate) fn new(row: &rows::ScalarRow, [a, b]: [&BodyVelocity; 2]) -> Self {
        let jacobian = &row.jacobian;
        let (linear, angular_a, angular_b) =
            (jacobian.linear.as_vec3(), jacobian.angular_a.as_vec3(), jacobian.angular_b.as_vec3());
        let (response_a, response_b) = (a.inverse_inertia.mul(angular_a), b.inverse_inertia.mul(angular_b));
        let gamma = row.gamma as f32;
        let w = linear.dot((a.inverse_mass + b.inverse_mass) * linear)
            + angular_a.dot(response_a)
            + angular_b.dot(response_b)
            + gamma;
        Self {
            linear,
            angular_a,
            angular_b,
            response_a,
            response_b,
            mass: if w > 0.0 && row.acts { 1.0 / w } else { 0.0 },
            bias: row.bias as f32,
            gamma,
            impulse: row.impulse,
            min: row.min as f32,
            max: row.max as f32,
            id: row.id,
        }
    }

    /// J v.
    pub(crate) fn rate(&self, a: &BodyVelocity, b: &BodyVelocity) -> f32 {
        self.linear.dot(b.linear - a.linear) + self.angular_b.dot(b.angular) - self.angular_a.dot(a.angular)
    }

    pub(crate) fn solve(&mut self, a: &mut BodyVelocity, b: &mut BodyVelocity) {
        let rate = self.rate(a, b);
        let free = self.impulse - self.mass * (rate + self.bias + self.gamma * self.impulse);
        let new = free.clamp(self.min, self.max);
        let change = new - self.impulse;
        self.impulse = new;
        self.push(change, a, b);
    }

    /// Applies an impulse along the row.
    pub(crate) fn push(&self, impulse: f32, a: &mut BodyVelocity, b: &mut BodyVelocity) {
        let linear = self.linear * impulse;
        a.linear -= a.inverse_mass * linear;
        a.angular -= self.response_a * impulse;
        b.linear += b.inverse_mass * linear;
        b.angular += self.response_b * impulse;
    }
}
