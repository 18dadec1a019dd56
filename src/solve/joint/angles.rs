//! Angles of joints as coordinates: which angles a joint has, and how they count turns.
//!
//! A rotation tells an angle up to whole turns. The angle that a joint had last, and what its bodies have turned by since, tell which
//! turn it is in: of all values that the rotation allows, the nearest to their sum is taken, so that nothing is missed at any speed.
//!
//! **Six-axis joints** turn by R = R_x(φ) R_y(θ) R_z(ψ) from A's frame to B's. What is locked decides how that is read:
//!
//! - *One axis free.* With the other two at constants, R is a rotation about one axis between two frames that are fixed in the bodies:
//!   a hinge, whichever axis it is.
//! - *x or z locked.* R_y(θ) R_z(ψ) and R_x(φ) R_y(θ) are universal joints: one axis fixed in A, one in B, at right angles. Both
//!   angles follow from two components of a unit vector, and no pose is singular.
//! - *Otherwise* all three angles follow from R but at θ = ±π/2, where x and z are one axis. The same R has two sets of angles,
//!   (φ, θ, ψ) and (φ + π, π − θ, ψ + π); the one nearest to the angles before is taken, so that θ goes on past a right angle. Rows
//!   on φ and ψ are multiplied by a factor that falls to zero there: what cannot be told apart is not pushed.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};

use super::AxisReading;
use super::geometry::{Placement, WorldFrame};
use super::rows::Jacobian;
use crate::joint::{Axis, JointKind, Limits};

/// Cosine of θ below which rows on φ and ψ fade (2.9° from the right angle): their gradients have length one over it.
const MIN_COSINE: f64 = 0.05;

/// Cosine of θ below which φ is not told by the rotation.
const NO_COSINE: f64 = 1.0e-9;

/// One more than the cosine between the axes of a spherical joint, below which its twist has little meaning.
pub(super) const MIN_COMMON: f64 = 1.0e-2;

/// Rotations that take the x axis to the y axis, and to the z axis.
const X_TO_Y: DQuat = DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5);
const X_TO_Z: DQuat = DQuat::from_xyzw(-0.5, -0.5, -0.5, 0.5);

/// The angle in the turn nearest to `near` (rad).
pub(crate) fn nearest(angle: f64, near: f64) -> f64 {
    angle + TAU * ((near - angle) / TAU).round()
}

/// What a six-axis joint leaves free to turn.
#[derive(Debug, Clone, Copy)]
pub(super) enum Turning {
    /// Nothing; rotation from A's frame to B's.
    None(DQuat),
    /// One axis, which is the x axis of both frames turned by these.
    About(usize, [DQuat; 2]),
    /// All but x, in frames turned by these.
    AcrossX([DQuat; 2]),
    /// All but z.
    AcrossZ([DQuat; 2]),
    /// Three angles, of which the middle one may be locked.
    Euler,
}

impl Turning {
    pub(super) fn of(angular: &[Axis; 3]) -> Self {
        let locked = |i: usize| angular[i].limits.min == angular[i].limits.max;
        let about = |axis: DVec3, i: usize| match f64::from(angular[i].limits.min) {
            0.0 => DQuat::IDENTITY,
            angle => {
                let part = axis * libm::sin(0.5 * angle);
                DQuat::from_xyzw(part.x, part.y, part.z, libm::cos(0.5 * angle))
            }
        };
        let [x, y, z] = [about(DVec3::X, 0), about(DVec3::Y, 1), about(DVec3::Z, 2)];
        match [locked(0), locked(1), locked(2)] {
            [true, true, true] => Self::None(x * y * z),
            [false, true, true] => Self::About(0, [DQuat::IDENTITY, (y * z).conjugate()]),
            [true, false, true] => Self::About(1, [x * X_TO_Y, z.conjugate() * X_TO_Y]),
            [true, true, false] => Self::About(2, [x * y * X_TO_Z, X_TO_Z]),
            [true, false, false] => Self::AcrossX([x, DQuat::IDENTITY]),
            [false, false, true] => Self::AcrossZ([DQuat::IDENTITY, z.conjugate()]),
            [false, _, false] => Self::Euler,
        }
    }

    /// The placement with frames turned as this says.
    pub(super) fn turned(&self, placement: &Placement) -> Placement {
        let mut placement = *placement;
        match self {
            Self::About(_, frames) | Self::AcrossX(frames) | Self::AcrossZ(frames) => {
                placement.a.frame *= frames[0];
                placement.b.frame *= frames[1];
            }
            Self::None(turn) => placement.a.frame *= *turn,
            Self::Euler => {}
        }
        placement
    }

    /// All three angles nearest to `near` (rad); of locked ones, what they are off.
    pub(super) fn read(&self, placement: &Placement, near: [f64; 3], angular: &[Axis; 3]) -> [f64; 3] {
        let held = |i: usize, off: f64| f64::from(angular[i].limits.min) + off;
        let placement = self.turned(placement);
        match *self {
            Self::None(_) => {
                let off = placement.rotation_vector();
                [held(0, off.x), held(1, off.y), held(2, off.z)]
            }
            Self::About(axis, _) => {
                let off = placement.axis_error();
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut angles = [0.0; 3];
                angles[axis] = nearest(placement.twist(), near[axis]);
                angles[next] = held(next, off.y);
                angles[last] = held(last, off.z);
                angles
            }
            Self::AcrossX(_) => {
                let r = DMat3::from_quat(placement.relative_rotation());
                let across = (r.z_axis.x * r.z_axis.x + r.z_axis.z * r.z_axis.z).sqrt();
                [
                    held(0, libm::atan2(-r.z_axis.y, across)),
                    nearest(libm::atan2(r.z_axis.x, r.z_axis.z), near[1]),
                    nearest(libm::atan2(r.x_axis.y, r.y_axis.y), near[2]),
                ]
            }
            Self::AcrossZ(_) => {
                let r = DMat3::from_quat(placement.relative_rotation());
                let across = (r.y_axis.y * r.y_axis.y + r.y_axis.z * r.y_axis.z).sqrt();
                [
                    nearest(libm::atan2(r.y_axis.z, r.y_axis.y), near[0]),
                    nearest(libm::atan2(r.z_axis.x, r.x_axis.x), near[1]),
                    held(2, libm::atan2(-r.y_axis.x, across)),
                ]
            }
            Self::Euler => euler_angles(&DMat3::from_quat(placement.relative_rotation()), near),
        }
    }

    /// The axes that the angles turn about, world coordinates.
    fn axes(&self, placement: &Placement, angles: [f64; 3]) -> [DVec3; 3] {
        match self {
            Self::Euler => {
                let a = placement.axes_a();
                let y = a.y_axis * libm::cos(angles[0]) + a.z_axis * libm::sin(angles[0]);
                [a.x_axis, y, placement.b.frame * DVec3::Z]
            }
            _ => self.gradients(placement, angles).map(|(gradient, _)| gradient.angular_b),
        }
    }

    /// Gradients of the angles at a placement where they are `angles`, and factors that those of these rows have.
    pub(super) fn gradients(&self, placement: &Placement, angles: [f64; 3]) -> [(Jacobian, f64); 3] {
        let of = |axes: [DVec3; 3], factors: [f64; 3]| std::array::from_fn(|i| (Jacobian::angular(axes[i]), factors[i]));
        let placement = self.turned(placement);
        let (a, b) = (placement.axes_a(), DMat3::from_quat(placement.b.frame));
        match *self {
            Self::None(_) => of([a.x_axis, a.y_axis, a.z_axis], [1.0; 3]),
            Self::About(axis, _) => {
                let mut axes = [a.x_axis; 3];
                (axes[(axis + 1) % 3], axes[(axis + 2) % 3]) = (a.y_axis, a.z_axis);
                of(axes, [1.0; 3])
            }
            Self::AcrossX(_) => of([a.y_axis.cross(b.z_axis).normalize_or(a.x_axis), a.y_axis, b.z_axis], [1.0; 3]),
            Self::AcrossZ(_) => of([a.x_axis, b.y_axis, a.x_axis.cross(b.y_axis).normalize_or(b.z_axis)], [1.0; 3]),
            Self::Euler => {
                let (x, z) = (a.x_axis, b.z_axis);
                let y = a.y_axis * libm::cos(angles[0]) + a.z_axis * libm::sin(angles[0]);
                let cosine = x.dot(y.cross(z));
                let divisor = if cosine.abs() > MIN_COSINE { cosine } else { MIN_COSINE.copysign(cosine) };
                let fades = cosine / divisor;
                of([y.cross(z) / divisor, y, x.cross(y) / divisor], [fades, 1.0, fades])
            }
        }
    }
}

/// φ, θ, ψ of R = R_x(φ) R_y(θ) R_z(ψ), of all that it has those nearest to `near` (rad).
fn euler_angles(r: &DMat3, near: [f64; 3]) -> [f64; 3] {
    // R e_z = (sin θ, −cos θ sin φ, cos θ cos φ).
    let (sine, cosine) = (-r.z_axis.y, r.z_axis.z);
    let size = (sine * sine + cosine * cosine).sqrt();
    let with = |first: f64, size: f64| {
        // R_x(−φ) R = R_y(θ) R_z(ψ), whose second row is (sin ψ, cos ψ, 0).
        let (s, c) = (libm::sin(first), libm::cos(first));
        let last = libm::atan2(c * r.x_axis.y + s * r.x_axis.z, c * r.y_axis.y + s * r.y_axis.z);
        let middle = libm::atan2(r.z_axis.x, size);
        [nearest(first, near[0]), nearest(middle, near[1]), nearest(last, near[2])]
    };
    if size < NO_COSINE {
        return with(near[0], 0.0);
    }
    let first = libm::atan2(sine, cosine);
    let (one, other) = (with(first, size), with(first + PI, -size));
    let way = |angles: &[f64; 3]| angles.iter().zip(near).map(|(angle, near)| (angle - near) * (angle - near)).sum::<f64>();
    if way(&one) <= way(&other) { one } else { other }
}

/// Whether a joint of this kind has angles that count turns. A ball joint that may swing right round has no twist to count.
pub(crate) fn counts_turns(kind: &JointKind) -> bool {
    match kind {
        JointKind::Hinge { .. } => true,
        JointKind::Spherical { swing_limit, twist_limits, .. } => {
            *swing_limit < std::f32::consts::PI || *twist_limits != Limits::NONE
        }
        JointKind::Generic { angular, .. } => angular.iter().any(|axis| axis.limits.min < axis.limits.max),
        JointKind::Fixed | JointKind::Distance { .. } | JointKind::Prismatic { .. } => false,
    }
}

/// Angles of a joint, of all that its rotation allows those nearest to `near` (rad): that of a hinge, the twist of a spherical joint,
/// all three of a six-axis joint.
pub(crate) fn read(kind: &JointKind, placement: &Placement, near: [f64; 3]) -> [f64; 3] {
    match kind {
        JointKind::Hinge { .. } | JointKind::Spherical { .. } => [nearest(placement.twist(), near[0]), 0.0, 0.0],
        JointKind::Generic { angular, .. } => Turning::of(angular).read(placement, near, angular),
        JointKind::Fixed | JointKind::Distance { .. } | JointKind::Prismatic { .. } => [0.0; 3],
    }
}

/// One angle of a six-axis joint that had these last (rad).
pub(super) fn axis(angular: &[Axis; 3], placement: &Placement, last: [f64; 3], axis: usize) -> AxisReading {
    let turning = Turning::of(angular);
    let found = turning.read(placement, last, angular);
    let (gradient, _) = turning.gradients(placement, found)[axis];
    let gradient = gradient.angular_b;
    AxisReading { position: found[axis], gradient, direction: turning.axes(placement, found)[axis], turns: true }
}

/// Rates of the angles of a joint placed so, at `angles`, where B turns against A at `spin` (rad/s, world axes).
pub(crate) fn rates(kind: &JointKind, placement: &Placement, angles: [f64; 3], spin: DVec3) -> [f64; 3] {
    let axis = |side: &WorldFrame| side.frame * DVec3::X;
    match kind {
        JointKind::Hinge { .. } => [axis(&placement.a).dot(spin), 0.0, 0.0],
        JointKind::Spherical { .. } => {
            let (a, b) = (axis(&placement.a), axis(&placement.b));
            [(a + b).dot(spin) / (1.0 + a.dot(b)).max(MIN_COMMON), 0.0, 0.0]
        }
        JointKind::Generic { angular, .. } => {
            let gradients = Turning::of(angular).gradients(placement, angles);
            gradients.map(|(gradient, _)| gradient.angular_b.dot(spin))
        }
        JointKind::Fixed | JointKind::Distance { .. } | JointKind::Prismatic { .. } => [0.0; 3],
    }
}

/// Angles of a joint that is made: within half a turn of zero, or, where limits rule that turn out, in one that they allow.
pub(crate) fn first(kind: &JointKind, placement: &Placement) -> [f64; 3] {
    let mut angles = read(kind, placement, [0.0; 3]);
    let limits = match kind {
        JointKind::Hinge { limits, .. } => [Some(*limits), None, None],
        JointKind::Spherical { twist_limits, .. } => [Some(*twist_limits), None, None],
        JointKind::Generic { angular, .. } => angular.map(|axis| Some(axis.limits).filter(|limits| limits.min < limits.max)),
        JointKind::Fixed | JointKind::Distance { .. } | JointKind::Prismatic { .. } => [None; 3],
    };
    for (angle, limits) in angles.iter_mut().zip(limits) {
        let Some(limits) = limits else { continue };
        let (min, max) = (f64::from(limits.min), f64::from(limits.max));
        let bound = angle.clamp(min, max);
        let lifted =
            *angle + TAU * if bound > *angle { ((bound - *angle) / TAU).ceil() } else { ((bound - *angle) / TAU).floor() };
        if bound != *angle && (min..=max).contains(&lifted) {
            *angle = lifted;
        }
    }
    angles
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    fn placed(turn: DQuat) -> Placement {
        super::super::placement_of(DVec3::ZERO, [DVec3::ZERO; 2], [DQuat::IDENTITY, turn])
    }

    fn turn(angles: [f64; 3]) -> DQuat {
        DQuat::from_rotation_x(angles[0]) * DQuat::from_rotation_y(angles[1]) * DQuat::from_rotation_z(angles[2])
    }

    const FREE: Axis = Axis::FREE;

    fn held(at: f32) -> Axis {
        Axis::limited(at, at)
    }

    #[test]
    fn free_axes_are_read_over_many_turns_in_whatever_way_the_others_are_locked() {
        let locks = [
            [FREE, held(0.0), held(0.0)],
            [held(0.0), FREE, held(0.0)],
            [held(0.0), held(0.0), FREE],
            [FREE, held(0.3), held(-0.7)],
            [held(0.4), FREE, held(1.1)],
            [held(-0.2), held(0.5), FREE],
            [held(0.0), FREE, FREE],
            [FREE, held(0.0), FREE],
            [FREE, FREE, held(0.0)],
            [held(0.3), FREE, FREE],
            [FREE, held(0.4), FREE],
            [FREE, FREE, held(-0.6)],
            [FREE, held(2.0), FREE],
            [held(0.3), held(1.4), held(-2.0)],
        ];
        for angular in locks {
            let turning = Turning::of(&angular);
            let at = |t: f64| -> [f64; 3] {
                std::array::from_fn(|i| {
                    if angular[i] == FREE { [7.0, 5.0, -6.0][i] * t + 0.1 } else { f64::from(angular[i].limits.min) }
                })
            };
            let mut angles = at(0.0);
            for step in 0..2000 {
                let expected = at(f64::from(step) * 0.01);
                angles = turning.read(&placed(turn(expected)), angles, &angular);
                let worst = (0..3).map(|i| (angles[i] - expected[i]).abs()).fold(0.0, f64::max);
                assert!(worst < 1.0e-7, "{angular:?} at {expected:?}: read {angles:?}");
            }
        }
    }

    #[test]
    fn gradients_are_those_of_the_angles() {
        let locks = [
            [FREE, held(0.3), held(-0.7)],
            [held(0.4), FREE, held(1.1)],
            [held(-0.2), held(0.5), FREE],
            [held(0.3), FREE, FREE],
            [FREE, held(0.4), FREE],
            [FREE, FREE, held(-0.6)],
            [FREE, held(2.0), FREE],
            [FREE, FREE, FREE],
        ];
        const SMALL: f64 = 1.0e-6;
        for angular in locks {
            let turning = Turning::of(&angular);
            let angles: [f64; 3] =
                std::array::from_fn(|i| if angular[i] == FREE { [2.0, 1.2, -2.5][i] } else { f64::from(angular[i].limits.min) });
            let rotation = turn(angles);
            for (i, (gradient, factor)) in turning.gradients(&placed(rotation), angles).into_iter().enumerate() {
                assert!((factor - 1.0).abs() < 1.0e-12, "away from the right angle rows are whole");
                for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                    let moved =
                        |way: f64| turning.read(&placed(DQuat::from_scaled_axis(axis * way) * rotation), angles, &angular)[i];
                    let found = (moved(SMALL) - moved(-SMALL)) / (2.0 * SMALL);
                    let expected = gradient.angular_b.dot(axis);
                    assert!(
                        (found - expected).abs() < 1.0e-6,
                        "{angular:?}, angle {i} about {axis}: {found}, gradient {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn three_angles_go_on_past_the_right_angle() {
        let mut angles = [0.0; 3];
        for step in 0..700 {
            let expected = f64::from(step) * 0.01;
            // A little off, so that the right angle itself is passed beside.
            angles = Turning::Euler.read(&placed(turn([1.0e-3, expected, -2.0e-3])), angles, &[FREE; 3]);
            assert!((angles[1] - expected).abs() < 1.0e-9, "turned by {expected}, read {angles:?}");
            assert!((angles[0] - 1.0e-3).abs() < 1.0e-6 && (angles[2] + 2.0e-3).abs() < 1.0e-6, "at {expected}: {angles:?}");
        }
    }

    #[test]
    fn a_joint_begins_in_a_turn_that_its_limits_allow() {
        let first_of = |min: f32, max: f32, angle: f64| {
            let kind = JointKind::Hinge { limits: Limits::new(min, max), motor: crate::Motor::Off };
            first(&kind, &placed(DQuat::from_rotation_x(angle)))[0]
        };
        let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1.0e-9, "{found}, expected {expected}");
        is(first_of(-1.0, 1.0, 0.5), 0.5);
        is(first_of(3.5, 4.7, 4.0), 4.0);
        is(first_of(-4.7, -3.5, -4.0), -4.0);
        is(first_of(3.5, 4.7, 0.0), 0.0);
        is(first_of(-0.5, 0.5, 1.0), 1.0);
        is(first_of(12.0, 20.0, 0.0), 4.0 * PI);
    }
}
