//! The two forms of joint row: a 3×3 block and a scalar, both with give; each for velocities and for positions.
//!
//! **Velocity rows** hold C(x) = 0 (or ≥ 0) at the *end* of the substep. With the pose predicted from the present velocity v*,
//! C* there, and Jacobian J,  C(end)/h ≈ J v + b,  b = C*/h − J v*: corrections go into the velocity, and positions follow from
//! it; nothing is ever differenced. A rigid row only answers for what this substep makes of C, b = (C* − C₀)/h − J v*; the
//! error C₀ that was there before is left to the position rows. So a carried multiplier is a force and nothing else: with C₀ in
//! the velocity row, a joint that converges slowly repeats its own correction and blows up (a bob of small inertia on a long
//! hinge lever does so within a second).
//!
//! Compliance α and damping c (Macklin et al. 2016) make the impulse p that of an implicit spring and damper: with k = c α / h
//! and γ = α / h²,
//!
//! ```text
//! Δp = −(J v + b/(1+k) + γ/(1+k) p) / (w + γ/(1+k)),    w = J M⁻¹ Jᵀ.
//! ```
//!
//! α = 0 is a rigid row. Units: p in N·s or N·m·s, b in m/s or rad/s, w in 1/kg or 1/(kg·m²).
//!
//! **Position rows** take rigid errors out after the substep, J δ = −C, by displacements that leave no velocity behind.

use glam::{Mat3, Vec3};

use crate::joint::Softness;
use crate::solve::state::BodyVelocity;

/// Greatest displacement of a joint point, and rotation, by one position row in one substep, as speeds (m/s, rad/s).
const MAX_RECOVERY_SPEED: f32 = 10.0;

/// Share of its error that a rigid drive closes in a substep.
///
/// The carried multiplier repeats what the closing took, and sweeps take that back by a factor 1 − ρ only. With ρ what a
/// substep's sweeps leave of an error, the drive swings to and fro for ever where the share exceeds about 1 − ρ (a bar on its end:
/// ρ = 0.56).
const DRIVE_SHARE: f32 = 0.1;

/// What rows are built for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Phase {
    /// Velocities at the end of a substep of this length (s).
    Velocity { h: f32 },
    /// Displacements after a substep of this length (s).
    Position { h: f32 },
}

impl Phase {
    /// Length of the substep (s).
    pub(crate) fn h(self) -> f32 {
        let (Self::Velocity { h } | Self::Position { h }) = self;
        h
    }
}

/// Give of a row in one phase of one substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Give {
    phase: Phase,
    /// γ/(1+k) and 1/(1+k).
    gamma: f32,
    share: f32,
    rigid: bool,
}

impl Give {
    pub(crate) fn new(softness: Softness, phase: Phase) -> Self {
        let h = phase.h();
        let k = softness.damping * softness.compliance / h;
        let share = 1.0 / (1.0 + k);
        Self { phase, gamma: softness.compliance / (h * h) * share, share, rigid: softness.compliance == 0.0 }
    }

    pub(crate) fn rigid(phase: Phase) -> Self {
        Self::new(Softness::RIGID, phase)
    }

    /// Whether the row takes part in the position phase: only what is rigid has an error to take out.
    fn acts(&self) -> bool {
        self.rigid || matches!(self.phase, Phase::Velocity { .. })
    }

    /// Bias of a row with errors `start` (C₀) and `predicted` (C*), and rate `rate` (J v*).
    fn bias(&self, predicted: f32, start: f32, rate: f32) -> f32 {
        match self.phase {
            Phase::Velocity { h } if self.rigid => (predicted - start) / h - rate,
            Phase::Velocity { h } => (predicted / h - rate) * self.share,
            Phase::Position { h } => start.clamp(-MAX_RECOVERY_SPEED * h, MAX_RECOVERY_SPEED * h),
        }
    }

    /// Bias of a stop C ≥ 0: a rigid one may be closed within the substep but not overrun further.
    fn stop(&self, error: Error1, rate: f32) -> f32 {
        match self.phase {
            Phase::Velocity { h } if self.rigid => (error.predicted - error.start + error.start.max(0.0)) / h - rate,
            Phase::Velocity { .. } => self.bias(error.predicted, error.start, rate),
            Phase::Position { h } => error.start.max(-MAX_RECOVERY_SPEED * h),
        }
    }

    /// Bias of a drive towards C = 0; a rigid one closes [`DRIVE_SHARE`] of the error in a substep, at a bounded speed.
    fn drive(&self, error: Error1, rate: f32) -> f32 {
        match self.phase {
            Phase::Velocity { h } if self.rigid => {
                let closing = (error.start * DRIVE_SHARE / h).clamp(-MAX_RECOVERY_SPEED, MAX_RECOVERY_SPEED);
                (error.predicted - error.start) / h - rate + closing
            }
            _ => self.bias(error.predicted, error.start, rate),
        }
    }
}

/// Three rows solved together: J = [−1, r_a×, 1, −r_b×] (points) or [0, −1, 0, 1] (directions), restricted to some directions.
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

/// Directions that a block holds (unit vectors, world axes).
#[derive(Debug, Clone, Copy)]
pub(crate) enum Held {
    /// All three.
    All,
    /// Those orthogonal to this one.
    Across(Vec3),
}

impl Held {
    pub(crate) fn project(self, v: Vec3) -> Vec3 {
        match self {
            Self::All => v,
            Self::Across(axis) => v - axis * axis.dot(v),
        }
    }

    /// Inverse of `k` on the held directions.
    pub(crate) fn inverse(self, k: Mat3) -> Mat3 {
        match self {
            Self::All => inverse_or_zero(k),
            Self::Across(axis) => {
                let (u, v) = crate::solve::contact::tangents(axis);
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
}

fn inverse_or_zero(k: Mat3) -> Mat3 {
    let determinant = k.determinant();
    let scale = k.x_axis.x * k.y_axis.y * k.z_axis.z;
    if determinant > 1.0e-7 * scale { k.inverse() } else { Mat3::ZERO }
}

/// Error of a row: C at the start of the substep and at the predicted end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Error3 {
    pub start: Vec3,
    pub predicted: Vec3,
}

/// Error of a scalar row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Error1 {
    pub start: f32,
    pub predicted: f32,
}

impl BlockRow {
    /// Holds two points together in the directions `held`; `impulse` is the multiplier of the last substep.
    pub(crate) fn point(
        bodies: [&BodyVelocity; 2],
        levers: [Vec3; 2],
        error: Error3,
        held: Held,
        give: Give,
        impulse: Vec3,
    ) -> Self {
        let [a, b] = bodies;
        let response = |body: &BodyVelocity, lever: Vec3| {
            let arm = crate::solve::integrate::skew(lever);
            Mat3::from_diagonal(body.inverse_mass) - arm * body.inverse_inertia.to_mat3() * arm
        };
        let k = response(a, levers[0]) + response(b, levers[1]);
        let rate = b.linear + b.angular.cross(levers[1]) - a.linear - a.angular.cross(levers[0]);
        Self::new(levers, k, rate, error, held, give, impulse)
    }

    /// Holds two directions together about the axes `held`.
    pub(crate) fn direction(bodies: [&BodyVelocity; 2], error: Error3, held: Held, give: Give, impulse: Vec3) -> Self {
        let [a, b] = bodies;
        let k = a.inverse_inertia.to_mat3() + b.inverse_inertia.to_mat3();
        Self::new([Vec3::ZERO; 2], k, b.angular - a.angular, error, held, give, impulse)
    }

    fn new(levers: [Vec3; 2], k: Mat3, rate: Vec3, error: Error3, held: Held, give: Give, impulse: Vec3) -> Self {
        // The bias is bounded by components, so what is along a free direction must be gone before.
        let error = Error3 { start: held.project(error.start), predicted: held.project(error.predicted) };
        let bias = Vec3::from_array(std::array::from_fn(|i| give.bias(error.predicted[i], error.start[i], rate[i])));
        let mass = held.inverse(k + Mat3::from_diagonal(Vec3::splat(give.gamma)));
        Self {
            lever_a: levers[0],
            lever_b: levers[1],
            mass: if give.acts() { mass } else { Mat3::ZERO },
            bias,
            gamma: give.gamma,
            impulse: held.project(impulse),
        }
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
    /// J = [−linear, −angular_a, linear, angular_b].
    pub jacobian: Jacobian,
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

/// Gradient of a coordinate: how it changes with the bodies' velocities.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jacobian {
    pub linear: Vec3,
    pub angular_a: Vec3,
    pub angular_b: Vec3,
}

impl Jacobian {
    /// Of the rotation of B against A about `axis`.
    pub(crate) fn angular(axis: Vec3) -> Self {
        Self { linear: Vec3::ZERO, angular_a: axis, angular_b: axis }
    }

    /// Rate of the coordinate at the bodies' velocities.
    pub(crate) fn rate(&self, a: &BodyVelocity, b: &BodyVelocity) -> f32 {
        self.linear.dot(b.linear - a.linear) + self.angular_b.dot(b.angular) - self.angular_a.dot(a.angular)
    }

    /// w = J M⁻¹ Jᵀ.
    pub(crate) fn inverse_effective_mass(&self, a: &BodyVelocity, b: &BodyVelocity) -> f32 {
        self.linear.dot((a.inverse_mass + b.inverse_mass) * self.linear)
            + self.angular_a.dot(a.inverse_inertia.mul(self.angular_a))
            + self.angular_b.dot(b.inverse_inertia.mul(self.angular_b))
    }
}

/// What a scalar row does.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Demand {
    /// C = 0.
    Equal(Error1),
    /// C ≥ 0; an overlap of a rigid stop is left to position recovery.
    AtLeast(Error1),
    /// Hold a speed with a bounded impulse.
    Speed { target: f32, max_impulse: f32 },
    /// C = 0 with a bounded impulse.
    Drive { error: Error1, max_impulse: f32 },
}

impl ScalarRow {
    pub(crate) fn new(bodies: [&BodyVelocity; 2], jacobian: Jacobian, demand: Demand, give: Give, id: u8, impulse: f32) -> Self {
        let [a, b] = bodies;
        let rate = jacobian.rate(a, b);
        let (mut gamma, mut acts) = (give.gamma, give.acts());
        let moves = matches!(give.phase, Phase::Velocity { .. });
        let (bias, min, max) = match demand {
            Demand::Equal(error) => (give.bias(error.predicted, error.start, rate), f32::NEG_INFINITY, f32::INFINITY),
            Demand::AtLeast(error) => (give.stop(error, rate), 0.0, f32::INFINITY),
            Demand::Speed { target, max_impulse } => {
                gamma = 0.0;
                acts = moves;
                (-target, -max_impulse, max_impulse)
            }
            Demand::Drive { error, max_impulse } => {
                acts = moves;
                (give.drive(error, rate), -max_impulse, max_impulse)
            }
        };
        let w = jacobian.inverse_effective_mass(a, b) + gamma;
        Self {
            jacobian,
            response_a: a.inverse_inertia.mul(jacobian.angular_a),
            response_b: b.inverse_inertia.mul(jacobian.angular_b),
            mass: if w > 0.0 && acts { 1.0 / w } else { 0.0 },
            bias,
            gamma,
            impulse: if acts { impulse.clamp(min, max) } else { 0.0 },
            min,
            max,
            id,
        }
    }

    pub(crate) fn solve(&mut self, a: &mut BodyVelocity, b: &mut BodyVelocity) {
        let rate = self.jacobian.rate(a, b);
        let free = self.impulse - self.mass * (rate + self.bias + self.gamma * self.impulse);
        let new = free.clamp(self.min, self.max);
        let change = new - self.impulse;
        self.impulse = new;
        self.push(change, a, b);
    }

    /// Applies an impulse along the row.
    pub(crate) fn push(&self, impulse: f32, a: &mut BodyVelocity, b: &mut BodyVelocity) {
        let linear = self.jacobian.linear * impulse;
        a.linear -= a.inverse_mass * linear;
        a.angular -= self.response_a * impulse;
        b.linear += b.inverse_mass * linear;
        b.angular += self.response_b * impulse;
    }
}
