//! The two forms of joint row: a 3×3 block and a scalar, both with give.
//!
//! A row holds C(x) = 0 (or ≥ 0) at the *end* of the substep. With the pose predicted from the present velocity v*, C* there,
//! and Jacobian J,  C(end)/h ≈ J v + b,  b = C*/h − J v*, so the position row becomes a velocity row, corrections go into the
//! velocity, and positions follow from it: nothing is ever differenced.
//!
//! Compliance α and damping c (Macklin et al. 2016) make the impulse p satisfy  p = −h (C + c α … ) as an implicit spring and
//! damper would: with k = c α / h and γ = α / h²,
//!
//!     Δp = −(J v + b/(1+k) + γ/(1+k) p) / (w + γ/(1+k)),    w = J M⁻¹ Jᵀ.
//!
//! α = 0 is a rigid row. Units: p in N·s or N·m·s, b in m/s or rad/s, w in 1/kg or 1/(kg·m²).

use glam::{Mat3, Vec3};

use crate::joint::Softness;
use crate::solve::state::BodyVelocity;

/// Greatest speed at which a rigid row takes out an error that it did not cause itself (m/s, rad/s).
const MAX_RECOVERY_SPEED: f32 = 10.0;

/// Softness of a row for one substep: γ/(1+k) and 1/(1+k).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Give {
    gamma: f32,
    share: f32,
    rigid: bool,
}

impl Give {
    pub(crate) const RIGID: Self = Self { gamma: 0.0, share: 1.0, rigid: true };

    pub(crate) fn new(softness: Softness, h: f32) -> Self {
        let k = softness.damping * softness.compliance / h;
        let share = 1.0 / (1.0 + k);
        Self { gamma: softness.compliance / (h * h) * share, share, rigid: softness.compliance == 0.0 }
    }

    /// Bias of a row with error `predicted` (C*), rate `rate` (J v*) and error `start` at the start of the substep.
    ///
    /// A rigid row keeps what this substep's motion makes of C, and takes out what was there before at a bounded speed.
    fn bias(&self, predicted: f32, start: f32, rate: f32, h: f32) -> f32 {
        if self.rigid {
            let recovery = (start / h).clamp(-MAX_RECOVERY_SPEED, MAX_RECOVERY_SPEED);
            return (predicted - start) / h - rate + recovery;
        }
        (predicted / h - rate) * self.share
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
    fn project(self, v: Vec3) -> Vec3 {
        match self {
            Self::All => v,
            Self::Across(axis) => v - axis * axis.dot(v),
        }
    }

    /// Inverse of `k` on the held directions.
    fn inverse(self, k: Mat3) -> Mat3 {
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
        h: f32,
    ) -> Self {
        let [a, b] = bodies;
        let response = |body: &BodyVelocity, lever: Vec3| {
            let arm = crate::solve::integrate::skew(lever);
            Mat3::from_diagonal(body.inverse_mass) - arm * body.inverse_inertia.to_mat3() * arm
        };
        let k = response(a, levers[0]) + response(b, levers[1]);
        let rate = b.linear + b.angular.cross(levers[1]) - a.linear - a.angular.cross(levers[0]);
        Self::new(levers, k, rate, error, held, give, impulse, h)
    }

    /// Holds two directions together about the axes `held`.
    pub(crate) fn direction(bodies: [&BodyVelocity; 2], error: Error3, held: Held, give: Give, impulse: Vec3, h: f32) -> Self {
        let [a, b] = bodies;
        let k = a.inverse_inertia.to_mat3() + b.inverse_inertia.to_mat3();
        Self::new([Vec3::ZERO; 2], k, b.angular - a.angular, error, held, give, impulse, h)
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one row, passed on once")]
    fn new(levers: [Vec3; 2], k: Mat3, rate: Vec3, error: Error3, held: Held, give: Give, impulse: Vec3, h: f32) -> Self {
        let bias = Vec3::from_array(std::array::from_fn(|i| give.bias(error.predicted[i], error.start[i], rate[i], h)));
        Self {
            lever_a: levers[0],
            lever_b: levers[1],
            mass: held.inverse(k + Mat3::from_diagonal(Vec3::splat(give.gamma))),
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
    /// How far a rigid stop was overrun at the start of the substep (m or rad).
    pub overlap: f32,
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
    pub(crate) fn new(
        bodies: [&BodyVelocity; 2],
        jacobian: Jacobian,
        demand: Demand,
        give: Give,
        id: u8,
        impulse: f32,
        h: f32,
    ) -> Self {
        let [a, b] = bodies;
        let rate = jacobian.rate(a, b);
        let mut gamma = give.gamma;
        let mut overlap = 0.0;
        let (bias, min, max) = match demand {
            Demand::Equal(error) => (give.bias(error.predicted, error.start, rate, h), f32::NEG_INFINITY, f32::INFINITY),
            Demand::AtLeast(error) if give.rigid => {
                let open = error.start.max(0.0);
                overlap = open - error.start;
                ((error.predicted - error.start + open) / h - rate, 0.0, f32::INFINITY)
            }
            Demand::AtLeast(error) => (give.bias(error.predicted, error.start, rate, h), 0.0, f32::INFINITY),
            Demand::Speed { target, max_impulse } => {
                gamma = 0.0;
                (-target, -max_impulse, max_impulse)
            }
            Demand::Drive { error, max_impulse } => {
                (give.bias(error.predicted, error.start, rate, h), -max_impulse, max_impulse)
            }
        };
        let w = jacobian.inverse_effective_mass(a, b) + gamma;
        Self {
            jacobian,
            response_a: a.inverse_inertia.mul(jacobian.angular_a),
            response_b: b.inverse_inertia.mul(jacobian.angular_b),
            mass: if w > 0.0 { 1.0 / w } else { 0.0 },
            bias,
            gamma,
            impulse: impulse.clamp(min, max),
            min,
            max,
            overlap,
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

    /// Displaces the bodies until the coordinate has grown by `amount`, or leaves them where it has.
    pub(crate) fn push_towards(&self, amount: f32, a: &mut BodyVelocity, b: &mut BodyVelocity) {
        let missing = amount - self.jacobian.rate(a, b);
        if missing > 0.0 {
            self.push(self.mass * missing, a, b);
        }
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
