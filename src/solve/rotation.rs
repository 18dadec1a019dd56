//! Rotation of a body without torque, in `f64`: in `f32` the rounding of the angular momentum is biased and costs 0.07 % of it in
//! ten seconds.
//!
//! Rotation is torque-free between the constraint impulses, so the angular momentum L = R I Rᵀ ω stays constant while the body
//! turns. Every rule here turns R alone and reads ω off L, which is therefore exact; they differ in what they do to the energy.
//!
//! **Slow.** The midpoint rule (Müller et al. 2020 use the explicit gyroscopic term, which loses 1–2 % of L)
//!
//! ```text
//! ω½ = R½ I⁻¹ R½ᵀ L,   R½ = exp(h ω / 2) R,      R' = exp(h ω½) R,      ω' = R' I⁻¹ R'ᵀ L
//! ```
//!
//! **Fast.** With e₃ the principal axis whose moment is apart from the other two, M = Rᵀ L the momentum in principal axes and
//!
//! ```text
//! ½ M·I⁻¹M = [½ |M|²/I₂ + ½ (1/I₃ − 1/I₂) M₃²] + ½ (1/I₁ − 1/I₂) M₁²
//! ```
//!
//! the bracket is a symmetric top, R' = exp(h L/I₂) R exp(h (1/I₃ − 1/I₂) M₃ e₃), and the rest a rotation about e₁, R' = R exp(h (1/I₁
//! − 1/I₂) M₁ e₁): both exact at any h. Where I₁ = I₂ the first is all there is. Else they take turns, symplectically: the energy
//! swings by a bounded share and does not drift. By the triangle inequality of moments a thin rod is nearly symmetric, however thin.
//!
//! Where an axis is locked, L is not kept: the midpoint rule is taken if it gains no energy (see [`MAX_ENERGY_GAIN`]), else one
//! implicit step of Euler's equations in the body frame (Catto 2015), which only loses energy.

use crate::linalg::held_axes::held;
use glam::{DMat3, DQuat, DVec3};

/// Relative gain of rotational energy in one substep beyond which the midpoint rule is refused.
pub(crate) const MAX_ENERGY_GAIN: f64 = 1.0e-3;

/// Rotation of one substep above which the midpoint rule takes two halves (rad).
pub(crate) const SPLIT_TUMBLE: f64 = 1.0e-2;

/// Largest rotation of one substep that power series in `f32` are right for (rad); beyond it sine and cosine are asked for.
pub(crate) const MAX_TURN: f32 = 1.5;

/// Rotation of one substep (rad), and the same times the ratio of the greatest moment of inertia to the least, up to which the midpoint
/// rule is good enough: it loses or gains 2e-9 of the energy in a substep then, 0.01 % in a minute of 1000 substeps a second.
const SLOW_TUMBLE: f64 = 3.0e-2;
const SLOW_SHEAR: f64 = 1.0e-1;

/// Share of the energy by which two parts of a rotation that take turns once may be off.
const ONCE_ERROR: f64 = 1.0e-6;

/// Rotation of the symmetric part up to which one pass of fourth order is right (rad): the energy is off by 1e-5 of itself at most.
const PASS_TURN: f64 = 1.0;

/// Passes of fourth order that a substep may take: a body of the greatest speed in a substep of 1/120 s takes 84.
const MAX_PASSES: f64 = 128.0;

/// Lengths of the symmetric part and of the rest in a pass of fourth order, from one end to the middle (Blanes and Moan 2002, S6).
const PASS: ([f64; 4], [f64; 3]) = {
    let (a, b) = ([0.0792036964311957, 0.353172906049774, -0.0420650803577195], [0.209515106613362, -0.143851773179818]);
    ([a[0], a[1], a[2], 1.0 - 2.0 * (a[0] + a[1] + a[2])], [b[0], b[1], 0.5 - (b[0] + b[1])])
};

/// What decides how a body tumbles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Top {
    /// Principal moments of inertia (kg·m²).
    pub inertia: DVec3,
    /// Rotation of the principal axes in the body.
    pub frame: DQuat,
    /// 1 about free world axes, 0 about locked ones.
    pub free: DVec3,
    /// Whether all principal moments are equal.
    pub round: bool,
}

impl Top {
    /// Angular velocity of an angular momentum with the principal axes so.
    fn velocity_of(&self, axes: DQuat, momentum: DVec3) -> DVec3 {
        if self.free == DVec3::ONE {
            return axes * ((axes.conjugate() * momentum) / self.inertia);
        }
        let axes = DMat3::from_quat(axes);
        held(axes * DMat3::from_diagonal(self.inertia.recip()) * axes.transpose(), self.free) * (momentum * self.free)
    }
}

/// Rotation of a body through a substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SubstepRotation {
    pub rotation: DQuat,
    /// Mean angular velocity of the substep (rad/s).
    pub mean: DVec3,
    /// Angular velocity at its end (rad/s).
    pub angular: DVec3,
}

/// Rotation of any body through a substep of length `h` (s).
pub(crate) fn turn(rotation: DQuat, angular: DVec3, top: &Top, h: f64) -> SubstepRotation {
    if top.round {
        return plain(rotation, angular, h);
    }
    tumble(rotation, angular, top, h)
}

fn plain(rotation: DQuat, angular: DVec3, h: f64) -> SubstepRotation {
    SubstepRotation { rotation: rotated(rotation, angular * h), mean: angular, angular }
}

/// Rotation of a body whose principal moments differ.
pub(crate) fn tumble(rotation: DQuat, angular: DVec3, top: &Top, h: f64) -> SubstepRotation {
    if top.free != DVec3::ONE {
        return tumble_locked(rotation, angular, top, h);
    }
    let (way, shear) = (angular.length() * h, top.inertia.max_element() / top.inertia.min_element());
    if way <= SLOW_TUMBLE && way * shear <= SLOW_SHEAR {
        return midpoint(rotation, angular, top, h);
    }
    let frame = rotation * top.frame;
    let momentum = frame * (top.inertia * (frame.conjugate() * angular));
    let parts = InertiaSplit::of(top.inertia, momentum.length());
    let turned = parts.turned(frame, momentum, h);
    let end = turned * ((turned.conjugate() * momentum) / top.inertia);
    SubstepRotation { rotation: (turned * top.frame.conjugate()).normalize(), mean: (angular + end) * 0.5, angular: end }
}

/// How the energy of a body splits into that of a symmetric top and the rest.
struct InertiaSplit {
    /// Which principal axis is that of the symmetric top, and about which the rest turns.
    axis: usize,
    other: usize,
    /// Rates of rotation over the momentum: of all about it, about `axis` and about `other` (1/(kg·m²)).
    whole: f64,
    spin: f64,
    rest: f64,
    /// Length of the momentum (N·m·s).
    momentum: f64,
}

impl InertiaSplit {
    fn of(inertia: DVec3, momentum: f64) -> Self {
        let ease = inertia.recip();
        let apart = |axis: usize| (ease[(axis + 1) % 3] - ease[(axis + 2) % 3]).abs();
        let axis = if apart(0) <= apart(1) && apart(0) <= apart(2) {
            0
        } else if apart(1) <= apart(2) {
            1
        } else {
            2
        };
        let (other, whole) = ((axis + 1) % 3, ease[(axis + 2) % 3]);
        let (spin, rest) = (ease[axis] - whole, ease[other] - whole);
        Self { axis, other, whole, spin, rest, momentum }
    }

    /// Rotation of the symmetric part in a time of `h` (s), at most (rad).
    fn turn(&self, h: f64) -> f64 {
        (self.whole + self.spin.abs()) * self.momentum * h
    }

    /// Share of the energy by which parts that take turns once are off, at most: β α²/24 with α and β the rotations of the two.
    fn error(&self, h: f64) -> f64 {
        let turn = self.turn(h);
        self.rest.abs() * self.momentum * h * turn * turn / 24.0
    }

    /// Principal axes after a time of `h` (s).
    fn turned(&self, frame: DQuat, momentum: DVec3, h: f64) -> DQuat {
        if self.rest == 0.0 {
            return self.as_symmetric(frame, momentum, h);
        }
        if self.error(h) <= ONCE_ERROR {
            let half = self.as_symmetric(frame, momentum, 0.5 * h);
            return self.as_symmetric(self.about_other(half, momentum, h), momentum, 0.5 * h);
        }
        let passes = (self.turn(h) / PASS_TURN).ceil().clamp(1.0, MAX_PASSES);
        let (h, mut turned) = (h / passes, frame);
        for _ in 0..passes as usize {
            for k in 0..6 {
                turned = self.as_symmetric(turned, momentum, h * PASS.0[k.min(6 - k)]);
                turned = self.about_other(turned, momentum, h * PASS.1[k.min(5 - k)]);
            }
            turned = self.as_symmetric(turned, momentum, h * PASS.0[0]);
        }
        turned
    }

    fn as_symmetric(&self, frame: DQuat, momentum: DVec3, h: f64) -> DQuat {
        let about = (frame.conjugate() * momentum)[self.axis];
        let spin = about_axis(self.axis, about * self.spin * h);
        rotated(frame * spin, momentum * (self.whole * h))
    }

    fn about_other(&self, frame: DQuat, momentum: DVec3, h: f64) -> DQuat {
        frame * about_axis(self.other, (frame.conjugate() * momentum)[self.other] * self.rest * h)
    }
}

/// The rotation about one of the axes by an angle (rad).
fn about_axis(axis: usize, angle: f64) -> DQuat {
    let mut vector = DVec3::ZERO;
    vector[axis] = angle;
    quaternion_of(vector)
}

/// The midpoint rule, in two halves where the body turns by more than [`SPLIT_TUMBLE`].
fn midpoint(rotation: DQuat, angular: DVec3, top: &Top, h: f64) -> SubstepRotation {
    let frame = rotation * top.frame;
    let momentum = frame * (top.inertia * (frame.conjugate() * angular));
    let velocity_in = |frame: DQuat| top.velocity_of(frame, momentum);

    let pieces = if angular.length() * h > SPLIT_TUMBLE { 2 } else { 1 };
    let piece = h / f64::from(pieces);
    let (mut turned, mut end, mut mean) = (rotation, angular, DVec3::ZERO);
    for _ in 0..pieces {
        let middle = velocity_in(rotated(turned * top.frame, end * (0.5 * piece)));
        turned = rotated(turned, middle * piece);
        end = velocity_in(turned * top.frame);
        mean += middle / f64::from(pieces);
    }
    SubstepRotation { rotation: turned, mean, angular: end }
}

/// Rotation of a body with locked axes.
fn tumble_locked(rotation: DQuat, angular: DVec3, top: &Top, h: f64) -> SubstepRotation {
    let frame = rotation * top.frame;
    let local = frame.conjugate() * angular;
    let momentum = frame * (top.inertia * local);
    let turn = midpoint(rotation, angular, top, h);
    let energy = local.dot(top.inertia * local);
    let gains = momentum.dot(turn.angular) > energy * (1.0 + MAX_ENERGY_GAIN);
    if !gains && (turn.mean * h).length_squared() < f64::from(MAX_TURN * MAX_TURN) {
        return turn;
    }
    let implicit = frame * implicit_gyroscopic(local, top.inertia, h) * top.free;
    let scale = (local.length() / implicit.length().max(f64::MIN_POSITIVE)).min(1.0);
    plain(rotation, implicit * scale, h)
}

/// One Newton step of I (ω' − ω) + h ω' × I ω' = 0 in principal axes.
fn implicit_gyroscopic(local: DVec3, inertia: DVec3, h: f64) -> DVec3 {
    let momentum = inertia * local;
    let residual = h * local.cross(momentum);
    let jacobian = DMat3::from_diagonal(inertia) + h * (skew(local) * DMat3::from_diagonal(inertia) - skew(momentum));
    local - jacobian.inverse() * residual
}

fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

/// 1/(n (n + 1)) and 1/(n (n − 1)) for n = 2, 4 … 16: the power series of sin x / x and cos x.
pub(crate) const SERIES: [(f64, f64); 8] = {
    let mut terms = [(0.0, 0.0); 8];
    let mut k = 0;
    while k < 8 {
        let n = 2.0 * (k + 1) as f64;
        terms[k] = (1.0 / (n * (n + 1.0)), 1.0 / (n * (n - 1.0)));
        k += 1;
    }
    terms
};

/// Square of half an angle below which this many terms leave nothing but rounding, x⁵/11! < 3e-18.
pub(crate) const FEW_TERMS_BELOW: f64 = 1.0e-2;
pub(crate) const FEW_TERMS: usize = 4;

/// Square of half an angle beyond which [`SERIES`] are not right to rounding.
pub(crate) const SERIES_BELOW: f64 = 0.5625;

/// `rotation` turned by a rotation vector in world axes (rad), by power series: the same bits on every platform.
pub(crate) fn rotated(rotation: DQuat, vector: DVec3) -> DQuat {
    (quaternion_of(vector) * rotation).normalize()
}

/// The rotation by a rotation vector of any length (rad).
pub(crate) fn quaternion_of(vector: DVec3) -> DQuat {
    let half = vector * 0.5;
    let x = half.length_squared();
    if x > SERIES_BELOW {
        let angle = x.sqrt();
        let axis = half * (libm::sin(angle) / angle);
        return DQuat::from_xyzw(axis.x, axis.y, axis.z, libm::cos(angle));
    }
    let (mut sine_over_angle, mut cosine) = (1.0, 1.0);
    let terms = if x < FEW_TERMS_BELOW { FEW_TERMS } else { SERIES.len() };
    for (sine_term, cosine_term) in SERIES[..terms].iter().rev() {
        sine_over_angle = 1.0 - x * sine_term * sine_over_angle;
        cosine = 1.0 - x * cosine_term * cosine;
    }
    let axis = half * sine_over_angle;
    DQuat::from_xyzw(axis.x, axis.y, axis.z, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOMENTS: [[f64; 3]; 6] =
        [[1.0, 2.0, 2.9], [1.0, 1.5, 2.0], [1.0, 10.0, 10.5], [2.0, 2.0, 1.0], [1.0, 1.001, 0.01], [2.9, 1.0, 2.0]];

    fn top(moments: [f64; 3]) -> Top {
        let frame = quaternion_of(DVec3::new(0.4, -0.3, 0.2));
        Top { inertia: DVec3::from_array(moments), frame, free: DVec3::ONE, round: false }
    }

    #[test]
    fn a_long_substep_turns_a_body_as_many_short_ones_do() {
        let pieces = 20_000;
        for moments in MOMENTS {
            for turn in [0.05, 0.5, 5.0] {
                let (top, start) = (top(moments), quaternion_of(DVec3::new(0.1, 0.2, 0.3)));
                let angular = DVec3::new(0.3, 1.0, 0.2).normalize() * turn;
                let long = tumble(start, angular, &top, 1.0);
                let short = (0..pieces).fold((start, angular), |(rotation, angular), _| {
                    let turn = midpoint(rotation, angular, &top, 1.0 / f64::from(pieces));
                    (turn.rotation, turn.angular)
                });
                let off = 2.0 * (1.0 - long.rotation.dot(short.0).powi(2)).max(0.0).sqrt();
                assert!(off < 1e-4 * turn, "moments {moments:?}: off by {off} rad after {turn} rad, bound 1e-4 of it");
                let off = (long.angular - short.1).length() / turn;
                let shear = top.inertia.max_element() / top.inertia.min_element();
                assert!(off < 1e-4 * shear, "moments {moments:?}: ω off by {off} of itself after {turn} rad");
            }
        }
    }

    #[test]
    fn rotations_of_any_length_are_right() {
        for angle in [1.0e-3, 1.4, 1.6, 3.0, 7.0, 100.0_f64] {
            let found = quaternion_of(DVec3::new(0.0, angle, 0.0));
            let expected = DQuat::from_rotation_y(angle);
            assert!(found.abs_diff_eq(expected, 1e-14), "{found} instead of {expected} by {angle} rad");
        }
    }
}
