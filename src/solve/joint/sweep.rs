//! Joint rows as a sweep solves them, one after another: in `f32`, each with its own effective mass.

use glam::{Mat3, Vec3};

use super::friction;
use super::rows::{self, HeldDirections};
use crate::solve::state::BodyVelocity;
use crate::solve::wide_matrix::{RANK_TWO, SINGULAR};

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
fn inverse_on(held: HeldDirections, k: Mat3) -> Mat3 {
    match held {
        HeldDirections::All => inverse_where_it_moves(k),
        HeldDirections::Across(axis) => {
            let (u, v) = crate::solve::contact::tangents(axis.as_vec3());
            let (a, b, c) = (u.dot(k * u), u.dot(k * v), v.dot(k * v));
            let determinant = a * c - b * b;
            let outer = |x: Vec3, y: Vec3| Mat3::from_cols(x * y.x, x * y.y, x * y.z);
            let across = outer(u, v) + outer(v, u);
            if determinant <= f32::EPSILON * a * c {
                return of_rank_one(outer(u, u) * a + across * b + outer(v, v) * c);
            }
            (outer(u, u) * c - across * b + outer(v, v) * a) * (1.0 / determinant)
        }
        HeldDirections::Along(axis) => {
            let axis = axis.as_vec3();
            of_rank_one(Mat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z) * axis.dot(k * axis))
        }
        HeldDirections::Nothing => Mat3::ZERO,
    }
}

/// Inverse of a matrix of positive or zero eigenvalues on the directions in which it moves anything, zero on the others (Moore and Penrose).
///
/// Bodies with locked axes do not move in every direction. With N the adjugate over its trace d, which of a matrix of rank two is the
/// square of its null direction, K⁺ = (tr K (1 − N) − K)/d; of rank one, K⁺ = K/tr² K.
fn inverse_where_it_moves(k: Mat3) -> Mat3 {
    let determinant = k.determinant();
    let scale = k.x_axis.x * k.y_axis.y * k.z_axis.z;
    if determinant > SINGULAR * scale {
        return k.inverse();
    }
    let [x, y, z] = [k.x_axis, k.y_axis, k.z_axis];
    let adjugate = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let trace_of = |m: &Mat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
    let (trace, minors) = (trace_of(&k), trace_of(&adjugate));
    if minors > RANK_TWO * trace * trace {
        ((Mat3::IDENTITY - adjugate * (1.0 / minors)) * trace - k) * (1.0 / minors)
    } else {
        of_rank_one(k)
    }
}

/// The same of a matrix of rank one, or zero.
fn of_rank_one(k: Mat3) -> Mat3 {
    let trace = k.x_axis.x + k.y_axis.y + k.z_axis.z;
    if trace * trace > f32::MIN_POSITIVE { k * (1.0 / (trace * trace)) } else { Mat3::ZERO }
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

/// Share of a row's response that is left to it once points hold, below which it does not lean on them.
const MIN_LEFT: f32 = 1.0e-4;

/// One row along a coordinate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScalarRow {
    pub linear: Vec3,
    angular_a: Vec3,
    pub angular_b: Vec3,
    response_a: Vec3,
    response_b: Vec3,
    /// Linear impulse on B for each unit of its own, and what of that the points take back.
    pushed: Vec3,
    lean: Vec3,
    mass: f32,
    bias: f32,
    gamma: f32,
    pub impulse: f32,
    min: f32,
    max: f32,
    /// Place of its multiplier in the joint's record.
    pub id: u8,
    /// Whether it is the friction of the coordinate that the row before it drives.
    is_beside: bool,
}

impl ScalarRow {
    /// Leaves its multiplier as it is.
    pub(crate) fn hold(&mut self) {
        self.mass = 0.0;
    }

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
            pushed: linear,
            lean: Vec3::ZERO,
            mass: if w > 0.0 && row.acts { 1.0 / w } else { 0.0 },
            bias: row.bias as f32,
            gamma,
            impulse: row.impulse,
            min: row.min as f32,
            max: row.max as f32,
            id: row.id,
            is_beside: false,
        }
    }

    /// J v.
    pub(crate) fn rate(&self, a: &BodyVelocity, b: &BodyVelocity) -> f32 {
        self.linear.dot(b.linear - a.linear) + self.angular_b.dot(b.angular) - self.angular_a.dot(a.angular)
    }

    /// Lets the row push together with its joint's points, so that these go on holding: see [`solve_leaning`].
    pub(crate) fn lean_on(&mut self, points: &BlockRow, [a, b]: [&BodyVelocity; 2]) {
        let (linear, w) = (self.linear, a.inverse_mass + b.inverse_mass);
        let moves = w * linear + self.response_a.cross(points.lever_a) + self.response_b.cross(points.lever_b);
        let lean = points.mass * moves;
        let pushed = linear - lean;
        let response_a = a.inverse_inertia.mul(self.angular_a - points.lever_a.cross(lean));
        let response_b = b.inverse_inertia.mul(self.angular_b - points.lever_b.cross(lean));
        let left = linear.dot(w * pushed) + self.angular_a.dot(response_a) + self.angular_b.dot(response_b) + self.gamma;
        // What the points hold as well is left to them.
        if self.mass > 0.0 && left * self.mass > MIN_LEFT {
            *self = Self { pushed, lean, response_a, response_b, mass: 1.0 / left, ..*self };
        }
    }

    /// What the points carry beyond their own multiplier by the one that the row starts with.
    pub(crate) fn leaning(&self) -> Vec3 {
        self.lean * self.impulse
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
        let linear = self.pushed * impulse;
        a.linear -= a.inverse_mass * linear;
        a.angular -= self.response_a * impulse;
        b.linear += b.inverse_mass * linear;
        b.angular += self.response_b * impulse;
    }
}

/// Lets the rows of a joint with friction lean on its points, and marks friction of coordinates that are driven too.
pub(crate) fn lean(rows: &mut [ScalarRow], points: Option<&BlockRow>, bodies: [&BodyVelocity; 2]) {
    let mut before = None;
    for row in rows {
        let motor = friction::motor_beside(row.id);
        row.is_beside = motor.is_some() && motor == before;
        before = Some(row.id);
        if let Some(points) = points {
            row.lean_on(points, bodies);
        }
    }
}

/// One pass over the points and rows of a joint with friction, rows forwards or backwards.
///
/// An arm of mass m on a lever r has m r²/I times the inertia about its joint that it has about itself, and row after row shares of
/// its weight would be passed to and fro as many times; meanwhile it slips. So a row s pushes together with the points p, which it
/// keeps from moving: with K that of the points and c = J_p M⁻¹ J_sᵀ, a unit of s comes with −K⁻¹ c of p, and w becomes w − c·K⁻¹ c.
pub(crate) fn solve_leaning(
    rows: &mut [ScalarRow],
    points: &mut Option<BlockRow>,
    a: &mut BodyVelocity,
    b: &mut BodyVelocity,
    backwards: bool,
) {
    if let Some(points) = points {
        points.solve_point(a, b);
    }
    let mut solve = |rows: &mut [ScalarRow]| {
        let sum = |rows: &[ScalarRow]| rows.iter().map(|row| row.impulse).sum::<f32>();
        let before = sum(rows);
        match &mut *rows {
            [motor, friction] => solve_pair(motor, friction, a, b),
            others => others.iter_mut().for_each(|row| row.solve(a, b)),
        }
        if let (Some(points), [first, ..]) = (&mut *points, &*rows) {
            points.impulse -= first.lean * (sum(rows) - before);
        }
    };
    let groups = rows.chunk_by_mut(|_, row| row.is_beside);
    if backwards { groups.rev().for_each(&mut solve) } else { groups.for_each(&mut solve) }
}

/// Solves a motor, J v + b + γ p = 0 with |p| ≤ T, and friction, J v = 0 with |q| ≤ F, on one coordinate at once.
///
/// One after the other they push against each other by what holds either, until one is at its bound; meanwhile the last one rules.
/// With r the rate without both, p(r) = −(r + b)/(w + γ) within ±T is what the motor answers. If the coordinate still moves forwards
/// after p(r − w F) and q = −F, that is the solution; if backwards after p(r + w F) and q = F, that; if neither, it stands,
/// p + q = −r/w, and the motor has what it asks for at rest: −b/γ, or all of T if it is rigid and wants to move.
fn solve_pair(motor: &mut ScalarRow, friction: &mut ScalarRow, a: &mut BodyVelocity, b: &mut BodyVelocity) {
    if friction.mass == 0.0 {
        return;
    }
    let (w, most, before) = (1.0 / friction.mass, friction.max, motor.impulse + friction.impulse);
    let free = friction.rate(a, b) - w * before;
    let answer = |rate: f32| (-motor.mass * (rate + motor.bias)).clamp(motor.min, motor.max);
    let (ahead, back) = (free - w * most, free + w * most);
    let [forwards, backwards] = [ahead, back].map(answer);
    (motor.impulse, friction.impulse) = if ahead + w * forwards > 0.0 {
        (forwards, -most)
    } else if back + w * backwards < 0.0 {
        (backwards, most)
    } else {
        let total = -free * friction.mass;
        let at_rest = if motor.gamma > 0.0 {
            (-motor.bias / motor.gamma).clamp(motor.min, motor.max)
        } else if motor.bias == 0.0 {
            motor.impulse
        } else {
            (-motor.bias * f32::INFINITY).clamp(motor.min, motor.max)
        };
        let rubs = (total - at_rest).clamp(-most, most);
        ((total - rubs).clamp(motor.min, motor.max), rubs)
    };
    friction.push(motor.impulse + friction.impulse - before, a, b);
}
