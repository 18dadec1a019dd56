//! Fast rotors: bodies that spin about an axis of symmetry by a good part of a turn in a step, or by many turns.
//!
//! Of such a body everything but its angle is slow. With a the axis, σ the spin and Ω = ω − σ a the rest of its angular velocity, A and
//! C the moments across the axis and along it,
//!
//! ```text
//! L = A Ω + C σ a,        a' = exp(h Ω) a,        φ' = φ + h σ:
//! ```
//!
//! a substep turns the axis by Ω alone and adds the spin as an angle about it, so that σ h may be as long as it likes. What is
//! extrapolated from the last substep are two ways, of the axis and of the angle, not one rotation vector, which would be ambiguous from
//! half a turn on.
//!
//! **Gyroscopic torque.** L is what forces change; the axis carries C σ a along as it turns. With a₀ the axis for which the system is
//! written down, the velocity before joints act is therefore not A⁻¹ L̂ but
//!
//! ```text
//! A Ω̂ = L̂ − C σ a' = (L̂ − C σ a₀) − C σ (a' − a₀),        a' = exp(h Ω) a
//! ```
//!
//! with Ω that which joints leave it: an antisymmetric term, which a symmetric factor cannot hold. So it is found by passes of the same
//! factor, each with the a' of the one before. An error of a' falls by C σ h/A* in each, with A* the moment that joints give the axis.
//!
//! **Shafts.** Of a slender body in joints with a rotor, however slowly it spins, A/C is large, and L taken about an axis that is off by ε
//! would be a spin of A/C ε Ω. So the momentum about its length is extrapolated by itself: (C σ)' = τ·a + (I₂ − I₃) ω₂ ω₃, the last of
//! which is found by the passes.
//!
//! What is as fast and not symmetric turns by one rotation vector, as all other bodies do, but finds I at the end of the substep by the
//! same passes: with I where it would be without joints, and ω carried over only where that gains no energy, as for bodies that turn
//! slowly, gyroscopic torques are off by 2 σ h of themselves, always to the side that loses energy.

use glam::{DQuat, DVec3};

use super::body::{is_slender, thinnest};
use crate::solve::joint::LocalPose;
use crate::solve::joint::rows::Rate;
use crate::solve::rotation;
use crate::step_history::History;

/// Spin from which a body is taken as a rotor, and below which it no longer is (rad/s). A gyroscope that the spin holds up against gravity
/// falls by 1.4 cm in a second at 30 rad/s if it is not, even at 960 steps a second. Test: tests/rotors.rs.
const MIN_SPIN: f64 = 3.0;
const MIN_SPIN_OF_ROTOR: f64 = 1.8;

/// Momentum along a slender body over that across it from which it is taken as a rotor; it stays one as long as the first is the greater. A
/// link that swings is none.
const MIN_SHARE: f64 = 2.0;

/// Difference of the two moments across the axis, over their sum, up to which a body counts as symmetric: what that leaves out of the
/// momentum goes round with the spin, and comes to nothing over a turn.
const ALIKE: f64 = 1.0e-3;

/// Most that the axis of a rotor turns by in a substep of the world (rad): what is extrapolated of it is slow.
const MAX_AXIS_TURN: f64 = 0.5;

/// Spin in a substep of the world (rad) from which the joints of a body feel the mean of its moments across the axis, however unlike.
const BLURRED_SPIN: f64 = 1.0;

/// Difference of the moments across a principal axis, over their sum.
fn unlike(moments: &DVec3, axis: usize) -> f64 {
    let (i, j) = (moments[(axis + 1) % 3], moments[(axis + 2) % 3]);
    (i - j).abs() / (i + j)
}

/// Number of the principal axis about which a body with these moments spins: that of its symmetry, or else that about which it turns fastest.
fn axis_of(moments: &DVec3, turning: DVec3) -> usize {
    let fastest = (1..3).fold(0, |fastest, axis| if turning[axis].abs() > turning[fastest].abs() { axis } else { fastest });
    (0..3).find(|&axis| unlike(moments, axis) <= ALIKE).unwrap_or(fastest)
}

/// A body that spins fast about an axis of symmetry.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rotor {
    pub body: usize,
    /// Whether its axis and its angle about it move apart: it counts as symmetric, be it only because of its spin, or is slender.
    pub by_axis: bool,
    pub is_blurred: bool,
    /// Its axis in the body's frame, and the moments along it and across it (kg·m²).
    pub axis: DVec3,
    pub along: f64,
    pub across: f64,
    /// Number of the axis among the principal ones, and difference of the moments across it, in their order (kg·m²): zero where it
    /// counts as symmetric.
    number: usize,
    uneven: f64,
    /// Principal moments (kg·m²) and rotation of the principal axes in the body.
    pub moments: DVec3,
    pub frame: DQuat,
    /// Rotation where the Euler part of the substep starts, and the axis there.
    pub start: DQuat,
    pub first: DVec3,
    /// Axis for which the system is written down, and rotation with it.
    pub held: DVec3,
    pub pose: DQuat,
    /// Change of angular velocity by what the axis carries along (rad/s).
    pub kick: DVec3,
    /// Whether it moves as any other body in this substep, since its kick would give energy.
    pub is_left: bool,
    /// Angular velocity that joints leave it (rad/s).
    pub found: DVec3,
    /// What an extrapolation of its momentum about the axis adds to it (N·m·s).
    pub carried: f64,
    /// Angle by which it has spun before the Euler part, and in the whole substep (rad).
    pub spun_before: f64,
    pub spun: f64,
}

impl Rotor {
    /// Of the body with this number, if it is one in substeps of `h` (s).
    pub fn of(
        body: usize,
        own: &super::body::DirectBody,
        (stance, rate): (&LocalPose, &Rate),
        known: bool,
        h: f64,
    ) -> Option<Self> {
        let least = if known { MIN_SPIN_OF_ROTOR } else { MIN_SPIN };
        if rate.angular.length_squared() <= least * least || own.free_mass().is_none() || own.top.round {
            return None;
        }
        let top = &own.top;
        let local = (stance.1 * top.frame).conjugate() * rate.angular;
        let axis = axis_of(&top.inertia, local);
        let spin = local[axis].abs();
        let rest = (local.length_squared() - spin * spin).max(0.0);
        if spin <= least || rest * h * h > MAX_AXIS_TURN * MAX_AXIS_TURN {
            return None;
        }
        let is_blurred = unlike(&top.inertia, axis) > ALIKE && spin * h > BLURRED_SPIN;
        if is_slender(&top.inertia) && !is_blurred {
            // What turns end over end only swings.
            let share = if known { 1.0 } else { MIN_SHARE };
            let (along, across) = (top.inertia[axis] * spin, top.inertia.max_element() * rest.sqrt());
            let is_spun = spin * h > BLURRED_SPIN || along >= share * across;
            let is_spun = is_spun && axis == thinnest(&top.inertia);
            return if is_spun { Self::of_shaft(body, own, (stance, rate), h) } else { None };
        }
        Some(Self::about(axis, body, own, stance, is_blurred))
    }

    /// Of a slender body about its length, at whatever rate it spins.
    pub fn of_shaft(body: usize, own: &super::body::DirectBody, (stance, rate): (&LocalPose, &Rate), h: f64) -> Option<Self> {
        let moments = &own.top.inertia;
        if own.free_mass().is_none() || own.top.round || !is_slender(moments) {
            return None;
        }
        let thin = thinnest(moments);
        let mut across = (stance.1 * own.top.frame).conjugate() * rate.angular;
        across[thin] = 0.0;
        if across.length_squared() * h * h > MAX_AXIS_TURN * MAX_AXIS_TURN {
            return None;
        }
        Some(Self { by_axis: true, ..Self::about(thin, body, own, stance, false) })
    }

    /// About this principal axis.
    fn about(number: usize, body: usize, own: &super::body::DirectBody, stance: &LocalPose, is_blurred: bool) -> Self {
        let top = &own.top;
        let mut axis = DVec3::ZERO;
        axis[number] = 1.0;
        let (i, j) = (top.inertia[(number + 1) % 3], top.inertia[(number + 2) % 3]);
        let is_symmetric = is_blurred || unlike(&top.inertia, number) <= ALIKE;
        Self {
            body,
            by_axis: is_symmetric,
            is_blurred,
            moments: top.inertia,
            frame: top.frame,
            axis: top.frame * axis,
            along: top.inertia[number],
            across: 0.5 * (i + j),
            number,
            uneven: if is_symmetric { 0.0 } else { i - j },
            start: stance.1,
            first: DVec3::ZERO,
            held: DVec3::ZERO,
            pose: stance.1,
            found: DVec3::ZERO,
            kick: DVec3::ZERO,
            is_left: false,
            carried: 0.0,
            spun_before: 0.0,
            spun: 0.0,
        }
    }

    /// Whether it matters how its moments across the axis are turned.
    pub fn is_uneven(&self) -> bool {
        !self.by_axis || self.uneven != 0.0
    }

    /// Spin (rad/s), and the rest of an angular velocity.
    pub fn split(&self, angular: DVec3) -> (f64, DVec3) {
        let spin = angular.dot(self.held);
        (spin, angular - self.held * spin)
    }

    /// Rotation a time of `h` (s) after the start, at an angular velocity.
    pub fn turned(&self, angular: DVec3, h: f64) -> DQuat {
        if !self.by_axis {
            return rotation::rotated(self.start, angular * h);
        }
        let (spin, rest) = self.split(angular);
        (rotation::rotated(self.start, rest * h) * rotation::quaternion_of(self.axis * (spin * h))).normalize()
    }

    /// Angular velocity of an angular momentum (N·m·s) of which so much is about the axis that is held, the rest across it.
    pub fn angular_of(&self, momentum: DVec3, about: f64) -> DVec3 {
        let across = momentum - self.held * momentum.dot(self.held);
        let turning = if self.uneven == 0.0 { across / self.across } else { self.angular_at(self.pose, across) };
        turning + self.held * (about / self.along)
    }

    /// What the rest of an angular velocity, across the axis, changes of the spin in a time of `h` (s) where the moments across differ
    /// (rad/s): (I₂ − I₃) ω₂ ω₃ h / C.
    fn coupling(&self, rotation: DQuat, rest: DVec3, h: f64) -> f64 {
        let local = (rotation * self.frame).conjugate() * rest;
        self.uneven * local[(self.number + 1) % 3] * local[(self.number + 2) % 3] * (h / self.along)
    }

    /// Angular velocity of an angular momentum where the body is turned so.
    pub fn angular_at(&self, rotation: DQuat, momentum: DVec3) -> DVec3 {
        let axes = rotation * self.frame;
        axes * ((axes.conjugate() * momentum) / self.moments)
    }

    /// What the axis that this angular velocity leads to carries along, as a change of angular velocity (rad/s).
    pub fn kick_of(&self, angular: DVec3, h: f64) -> DVec3 {
        if !self.by_axis {
            let (own, axes) = (angular - self.kick, self.pose * self.frame);
            let momentum = axes * ((axes.conjugate() * own) * self.moments);
            return self.angular_at(self.turned(angular, h), momentum) - own;
        }
        let (spin, rest) = self.split(angular);
        let change = rotation::quaternion_of(rest * h) * self.first - self.held;
        let across = (change - self.held * change.dot(self.held)) * (-self.along * spin / self.across);
        if self.uneven == 0.0 {
            return across;
        }
        across + self.held * self.coupling(self.turned(angular, h), rest, h)
    }

    /// Way of the axis (rad) and angle spun (rad) in the last substep.
    pub fn ways(&self, history: &History) -> (DVec3, f64) {
        let turn = history.turn.as_dvec3();
        if history.spin_turn != 0.0 {
            return (turn, f64::from(history.spin_turn));
        }
        let spun = turn.dot(self.held);
        (turn - self.held * spun, spun)
    }
}
