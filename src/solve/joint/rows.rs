//! Joint rows J v + b + γ p = 0 with a multiplier p, in blocks of three and alone: the one language of rows that all solvers
//! read.
//!
//! The two solvers take them as they are: [`super::sweep`] solves them one after another, [`crate::solve::direct`] all at once.
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
//! **Tangent rows** are velocity rows with the prediction left linear, C* = C₀ + h J v*: a rigid row is J v = 0 then, so that no
//! solution has more kinetic energy than v* had.
//!
//! **Leaps.** Where nothing but v₁ moves the bodies, x₁ = x₀ + h v₁, that spring takes (ω h)² of its energy in each substep, all of it within a
//! second where ω h is a quarter. One that gives way by C₀/4 and by what this substep *changes* of the rate,
//!
//! ```text
//! p = −(h/α) (C₀ + ¼ h (J v₁ − J v₀)) − h c J v₁,
//! ```
//!
//! is the trapezoidal rule with velocities told half a substep late: 4 sin²(φ/2) = s/(1 + s/4), s = (ω h)², turns by φ in each, and the
//! determinant of the two is 1, so that it loses nothing at any s. At rest it bears what it bears by C₀. It is a row as above with 4 α for α
//! and 4 C₀ − h J v₀ for C₀. What no substep resolves it would have swing for ever, so beyond ω h = 1 springs stay as they are; and stops,
//! which begin within a substep.
//!
//! **Position rows** take rigid errors out after the substep, J δ = −C, by displacements that leave no velocity behind.

use glam::{DVec3, Vec3};

use crate::joint::Softness;
use crate::solve::state::BodyVelocity;

/// Greatest displacement of a joint point, and rotation, by one position row in one substep of a sweep, as speeds (m/s, rad/s).
pub(crate) const MAX_RECOVERY_SPEED: f64 = 10.0;

/// Share of its error that a rigid drive closes in a substep of a sweep at most.
///
/// The carried multiplier repeats what the closing took, and sweeps take that back by a factor 1 − ρ only. With ρ what a
/// substep's sweeps leave of an error, the drive swings to and fro for ever where the share exceeds about 1 − ρ (a bar on its end:
/// ρ = 0.56).
pub(crate) const DRIVE_SHARE: f64 = 0.1;

/// What rows are built for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Phase {
    /// Velocities at the end of a substep of this length (s).
    Velocity { h: f64 },
    /// The same, to first order at the substep's start.
    Tangent { h: f64 },
    /// The same where nothing but the velocities found moves the bodies, so that springs may keep their energy.
    Leap { h: f64 },
    /// Displacements that take out errors of at most this much (m or rad).
    Position { most: f64 },
}

impl Phase {
    /// Length of the substep (s); displacements have none, and nothing in them depends on it.
    pub(crate) fn h(self) -> f64 {
        match self {
            Self::Velocity { h } | Self::Tangent { h } | Self::Leap { h } => h,
            Self::Position { .. } => 1.0,
        }
    }
}

/// Give of a row in one phase of one substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SoftParams {
    phase: Phase,
    /// γ/(1+k) and 1/(1+k).
    gamma: f64,
    share: f64,
    rigid: bool,
    /// Whether it is a spring that keeps its energy.
    keeps: bool,
}

impl SoftParams {
    pub(crate) fn new(softness: Softness, phase: Phase) -> Self {
        let h = phase.h();
        let compliance = f64::from(softness.compliance);
        let k = f64::from(softness.damping) * compliance / h;
        let share = 1.0 / (1.0 + k);
        Self { phase, gamma: compliance / (h * h) * share, share, rigid: compliance == 0.0, keeps: false }
    }

    /// A spring that keeps its energy where nothing but the velocities found moves the bodies; others lose (ω h)² of it in a substep.
    pub(crate) fn keeping(softness: Softness, phase: Phase) -> Self {
        Self { keeps: true, ..Self::new(Softness { compliance: 4.0 * softness.compliance, ..softness }, phase) }
    }

    pub(crate) fn rigid(phase: Phase) -> Self {
        Self::new(Softness::RIGID, phase)
    }

    /// The same of a stop that is met after a share of the substep: until then its damper has nothing to act on, though its row sees the rate of
    /// all of it. A damper that acted from the start would brake what has yet to come to the stop, the farther away the more it is damped.
    fn once_met(self, error: Error1, rate: [f64; 2]) -> Self {
        if self.rigid || error.start <= 0.0 {
            return self;
        }
        let end = match self.phase {
            Phase::Velocity { .. } => error.predicted,
            Phase::Tangent { h } | Phase::Leap { h } => error.start + h * (rate[0] + rate[1]),
            Phase::Position { .. } => return self,
        };
        let within = if end < 0.0 { end / (end - error.start) } else { 0.0 };
        let share = self.share / (self.share + (1.0 - self.share) * within);
        Self { gamma: self.gamma / self.share * share, share, ..self }
    }

    /// Whether the row takes part in this phase: only what is rigid has an error to take out of positions.
    fn acts(&self) -> bool {
        self.rigid || !matches!(self.phase, Phase::Position { .. })
    }

    /// What the error changes by in a substep at the present velocity, over its length, less the rate: the path's curvature.
    pub(crate) fn curvature(&self, error: Error1, [rate, driven]: [f64; 2]) -> f64 {
        match self.phase {
            Phase::Velocity { h } => (error.predicted - error.start) / h - (rate + driven),
            Phase::Tangent { .. } | Phase::Leap { .. } | Phase::Position { .. } => 0.0,
        }
    }

    /// Bias of a row C = 0 whose error has the rate J v* by the bodies, and one by what the host moves of the joint.
    fn bias(&self, error: Error1, rate: [f64; 2]) -> f64 {
        match self.phase {
            Phase::Position { most } => error.start.clamp(-most, most),
            _ if self.rigid => rate[1] + self.curvature(error, rate),
            Phase::Leap { h } if self.keeps => rate[1] + (4.0 * error.start / h - rate[0] - rate[1]) * self.share,
            Phase::Velocity { h } | Phase::Tangent { h } | Phase::Leap { h } => {
                rate[1] + (error.start / h + self.curvature(error, rate)) * self.share
            }
        }
    }

    /// Bias of a stop C ≥ 0: a rigid one may be closed within the substep but not overrun further.
    fn stop(&self, error: Error1, rate: [f64; 2]) -> f64 {
        match self.phase {
            Phase::Position { most } => error.start.max(-most),
            Phase::Velocity { h } | Phase::Tangent { h } | Phase::Leap { h } if self.rigid => {
                rate[1] + error.start.max(0.0) / h + self.curvature(error, rate)
            }
            _ => self.bias(error, rate),
        }
    }

    /// Bias of a spring and damper towards C = 0, whose reference moves at `speed`, and γ; `speed` is what moves it over the length of the
    /// row's part of the substep, and what its damper sees.
    pub(crate) fn spring(&self, error: Error1, speed: [f64; 2], rate: [f64; 2]) -> (f64, f64) {
        // What keeps its energy sees how much the rate to its reference changes.
        let moved = if self.keeps { 0.0 } else { speed[0] * self.share };
        (self.bias(error, rate) - moved - speed[1] * (1.0 - self.share), self.gamma)
    }
}

/// Velocity of a body (m/s, rad/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rate {
    pub linear: DVec3,
    pub angular: DVec3,
}

impl Rate {
    pub(crate) const ZERO: Self = Self { linear: DVec3::ZERO, angular: DVec3::ZERO };

    pub(crate) fn of(body: &BodyVelocity) -> Self {
        Self { linear: body.linear.as_dvec3(), angular: body.angular.as_dvec3() }
    }
}

/// Velocities that a joint's coordinates change with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowRates {
    /// Of the two bodies.
    pub bodies: [Rate; 2],
    /// Of frames that the host moves, as velocities of the bodies that would move them so.
    pub frames: Option<[Rate; 2]>,
}

impl RowRates {
    /// Rate of a coordinate by the bodies, and by the frames.
    pub(super) fn read<T>(&self, rate: impl Fn(&[Rate; 2]) -> T, none: T) -> [T; 2] {
        [rate(&self.bodies), self.frames.as_ref().map_or(none, rate)]
    }
}

/// Directions that a block holds (unit vectors, world axes).
#[derive(Debug, Clone, Copy)]
pub(crate) enum HeldDirections {
    /// All three.
    All,
    /// Those orthogonal to this one.
    Across(DVec3),
    /// This one.
    Along(DVec3),
    /// None.
    Nothing,
}

impl HeldDirections {
    /// Unit vectors that span them, and how many there are.
    pub(crate) fn axes(self) -> ([DVec3; 3], usize) {
        match self {
            Self::All => (DVec3::AXES, 3),
            Self::Across(axis) => {
                let (u, v) = across(axis);
                ([u, v, DVec3::ZERO], 2)
            }
            Self::Along(axis) => ([axis, DVec3::ZERO, DVec3::ZERO], 1),
            Self::Nothing => ([DVec3::ZERO; 3], 0),
        }
    }
}

/// Two unit vectors orthogonal to `axis` and to each other.
pub(crate) fn across(axis: DVec3) -> (DVec3, DVec3) {
    let u = axis.any_orthonormal_vector();
    (u, axis.cross(u))
}

impl HeldDirections {
    pub(crate) fn project(self, v: DVec3) -> DVec3 {
        match self {
            Self::All => v,
            Self::Across(axis) => v - axis * axis.dot(v),
            Self::Along(axis) => axis * axis.dot(v),
            Self::Nothing => DVec3::ZERO,
        }
    }
}

/// Error of a block: C at the start of the substep and at the predicted end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Error3 {
    pub start: DVec3,
    pub predicted: DVec3,
}

/// Error of a scalar row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Error1 {
    pub start: f64,
    pub predicted: f64,
}

/// Three rows that belong together: J = [−1, r_a×, 1, −r_b×] (points) or [0, −1, 0, 1] (directions), in the directions held.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockRow {
    /// From each body's centre of mass to the point where it is pushed; unused for directions.
    pub levers: [DVec3; 2],
    pub held: HeldDirections,
    pub bias: DVec3,
    pub gamma: f64,
    /// Whether the row takes part in this phase.
    pub acts: bool,
    /// Multiplier of the last substep.
    pub impulse: Vec3,
}

impl BlockRow {
    /// Holds two points together in the directions `held`.
    pub(crate) fn point(
        rates: &RowRates,
        levers: [DVec3; 2],
        error: Error3,
        held: HeldDirections,
        give: SoftParams,
        impulse: Vec3,
    ) -> Self {
        let rate = |[a, b]: &[Rate; 2]| b.linear + b.angular.cross(levers[1]) - a.linear - a.angular.cross(levers[0]);
        Self::new(levers, rates.read(rate, DVec3::ZERO), error, held, give, impulse)
    }

    /// Holds two directions together about the axes `held`.
    pub(crate) fn direction(rates: &RowRates, error: Error3, held: HeldDirections, give: SoftParams, impulse: Vec3) -> Self {
        let rate = |[a, b]: &[Rate; 2]| b.angular - a.angular;
        Self::new([DVec3::ZERO; 2], rates.read(rate, DVec3::ZERO), error, held, give, impulse)
    }

    fn new(levers: [DVec3; 2], rate: [DVec3; 2], error: Error3, held: HeldDirections, give: SoftParams, impulse: Vec3) -> Self {
        // The bias is bounded by components, so what is along a free direction must be gone before.
        let (start, predicted) = (held.project(error.start), held.project(error.predicted));
        let [rate, driven] = rate.map(|rate| held.project(rate));
        let bias = std::array::from_fn(|i| give.bias(Error1 { start: start[i], predicted: predicted[i] }, [rate[i], driven[i]]));
        let impulse = held.project(impulse.as_dvec3()).as_vec3();
        Self { levers, held, bias: DVec3::from_array(bias), gamma: give.gamma, acts: give.acts(), impulse }
    }
}

/// Gradient of a coordinate: how it changes with the bodies' velocities, J = [−linear, −angular_a, linear, angular_b].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jacobian {
    pub linear: DVec3,
    pub angular_a: DVec3,
    pub angular_b: DVec3,
}

impl Jacobian {
    /// Of the rotation of B against A about `axis`.
    pub(crate) fn angular(axis: DVec3) -> Self {
        Self { linear: DVec3::ZERO, angular_a: axis, angular_b: axis }
    }

    /// Rate of the coordinate at the bodies' velocities.
    pub(crate) fn rate(&self, [a, b]: &[Rate; 2]) -> f64 {
        self.linear.dot(b.linear - a.linear) + self.angular_b.dot(b.angular) - self.angular_a.dot(a.angular)
    }
}

/// What a scalar row does.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Demand {
    /// C = 0.
    Equal(Error1),
    /// C ≥ 0; an overlap of a rigid stop is left to position recovery.
    AtLeast(Error1),
    /// Hold a speed with an impulse in these bounds.
    Speed { target: f64, bounds: [f64; 2] },
    /// A spring and damper towards C = 0, where that moves at `speed` (see [`SoftParams::spring`]), with an impulse in these bounds.
    Drive { error: Error1, speed: [f64; 2], bounds: [f64; 2] },
    /// The same rigidly, closing C at the rate `closing`.
    Approach { error: Error1, closing: f64, speed: f64, bounds: [f64; 2] },
}

/// One row along a coordinate, with a bounded multiplier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScalarRow {
    pub jacobian: Jacobian,
    pub bias: f64,
    /// Rate of its error by what the host moves of the joint, which the bias has in it where the row is one of velocities (m/s, rad/s).
    pub driven: f64,
    pub gamma: f64,
    pub min: f64,
    pub max: f64,
    /// Whether the row takes part in this phase.
    pub acts: bool,
    /// Whether it is that of a motor or of friction, which give way to what has no bound.
    pub drives: bool,
    /// Multiplier of the last substep.
    pub impulse: f32,
    /// Place of its multiplier in the joint's record.
    pub id: u8,
}

impl ScalarRow {
    /// `driven` is how fast the error grows by what the host moves of the stop itself.
    pub(crate) fn new(
        rates: &RowRates,
        driven: f64,
        jacobian: Jacobian,
        demand: Demand,
        give: SoftParams,
        id: u8,
        impulse: f32,
    ) -> Self {
        let mut rate = rates.read(|rates| jacobian.rate(rates), 0.0);
        rate[1] += driven;
        let give = if let Demand::AtLeast(error) = demand { give.once_met(error, rate) } else { give };
        let moves = !matches!(give.phase, Phase::Position { .. });
        let (mut gamma, mut acts) = (give.gamma, give.acts());
        let (bias, min, max) = match demand {
            Demand::Equal(error) => (give.bias(error, rate), f64::NEG_INFINITY, f64::INFINITY),
            Demand::AtLeast(error) => (give.stop(error, rate), 0.0, f64::INFINITY),
            Demand::Speed { target, bounds: [least, most] } => {
                (gamma, acts) = (0.0, moves);
                (rate[1] - target, least, most)
            }
            Demand::Drive { error, speed, bounds: [least, most] } => {
                acts = moves;
                (give.spring(error, speed, rate).0, least, most)
            }
            Demand::Approach { error, closing, speed, bounds: [least, most] } => {
                acts = moves;
                (rate[1] + give.curvature(error, rate) + closing - speed, least, most)
            }
        };
        let impulse = if acts { impulse.clamp(min as f32, max as f32) } else { 0.0 };
        let drives = matches!(demand, Demand::Speed { .. } | Demand::Drive { .. } | Demand::Approach { .. });
        Self { jacobian, bias, driven: rate[1], gamma, min, max, acts, drives, impulse, id }
    }

    /// Whether there is a greatest multiplier on both sides.
    pub(crate) fn is_bounded(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// Has a stop be left at this speed at least (m/s, rad/s), if it is above zero.
    pub(super) fn leave_at(&mut self, speed: f64) {
        if speed > 0.0 {
            self.bias = self.bias.min(self.driven - speed);
        }
    }
}
