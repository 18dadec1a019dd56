//! Contacts between curved surfaces: where the contact point moves within a step, and the stiffness that this gives.
//!
//! A link on a drum turns with the drum's surface under it, and touches it elsewhere as it rocks. With the normal and the points of
//! the step's start, a cable that runs over the drum leaves it along a tangent in every step and falls back on it, and neighbouring
//! links rock against each other from step to step, ever further.
//!
//! With the shape operators A of the other surface and B of the body's own (by how much a normal turns per length, 1/m), a relative
//! displacement d of the two points of contact, tangential part d_t, and a relative rotation θ, both surfaces are tangent again
//! where x on the body and y on the other satisfy (Montana 1988)
//!
//! ```text
//! (A + B) x = θ×n − A d_t,    y = d_t + x,    n' = n + A y
//! s' = n·d + n·(θ×x) + ½ xᵀB x + ½ yᵀA y
//! ```
//!
//! to second order. In directions in which both are flat, A + B has no inverse and the points stay. A way x along a surface turns the
//! normal by φ = |B x| and ends at x sin φ/φ, fallen away from the tangent plane by ½ xᵀB x · 2 (1 − cos φ)/φ²: exact where that is an arc of
//! a circle, as on balls and cylinders. With the straight x the lever of a wheel that rolls by θ would be √(1 + θ²) of its radius, and what
//! it drives as much too fast. The separation is then that of the two points along n'.
//!
//! A force N along n, at a height h below the body's centre of mass, resists rocking as the point of contact wanders: the second
//! derivative of −N s' by θ, in terms of θ×n, is N ((1 − hB)(A+B)⁻¹(1 − hB) + h (1 − hB)); for a flat link on a drum N (R + h). The
//! orientation that it wants turns as the body goes around: θ̂×n = (1 + hA)⁻¹ A v_t for a centre of mass at v_t.

use glam::{DMat2, DMat3, DQuat, DVec2, DVec3};

use super::multistep::rotation_vector;
use crate::solve::joint::LocalPose;

/// Curvature of both surfaces together, times the reach of the body, below which they are flat on each other.
const FLAT: f64 = 1.0e-3;

/// Greatest turn of a normal in a step, or of the body (rad), for which second order is enough: beyond it the contact stays as it was.
const MAX_TURN: f64 = 0.5;

/// Two surfaces at the point where they touch, at the start of the step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curved {
    /// Two directions across the normal; operators are given in them.
    tangents: [DVec3; 2],
    own: DMat2,
    other: DMat2,
    /// Inverse of their sum in the directions in which it has one (m).
    yielding: DMat2,
    /// How far the point of contact may wander on the body (m).
    reach: f64,
}

/// Where a contact is: unit normal towards the body, levers from the centres of mass of the body and of the other, separation (m).
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvedPoint {
    pub normal: DVec3,
    pub lever: DVec3,
    pub other_lever: DVec3,
    pub separation: f64,
}

impl Curved {
    /// From the shape operators of the body and of the other in world axes (1/m); none where both are flat.
    pub(crate) fn new([own, other]: [DMat3; 2], normal: DVec3, reach: f64) -> Option<Self> {
        let (u, v) = normal.any_orthonormal_pair();
        let across = |m: DMat3| {
            let (mu, mv) = (m * u, m * v);
            DMat2::from_cols(DVec2::new(u.dot(mu), v.dot(mu)), DVec2::new(u.dot(mv), v.dot(mv)))
        };
        let (own, other) = (across(own), across(other));
        let yielding = inverse_above(own + other, FLAT / reach);
        (yielding != DMat2::ZERO).then_some(Self { tangents: [u, v], own, other, yielding, reach })
    }

    /// How far the point of contact may wander on the body (m).
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    fn flatten(&self, vector: DVec3) -> DVec2 {
        DVec2::new(self.tangents[0].dot(vector), self.tangents[1].dot(vector))
    }

    fn raise(&self, flat: DVec2) -> DVec3 {
        self.tangents[0] * flat.x + self.tangents[1] * flat.y
    }

    /// Where the contact is after the body and the other have moved and turned by `own` and `other` since the start of the step.
    pub(crate) fn follow(&self, spot: &CurvedPoint, own: &LocalPose, other: &LocalPose) -> Option<CurvedPoint> {
        let back = other.1.conjugate();
        let point = own.0 + own.1 * spot.lever - spot.lever;
        let under = other.0 + other.1 * spot.other_lever - spot.other_lever;
        let normal = spot.normal;
        let offset = back * (normal * spot.separation + point - under);
        let (swing, twist) = split(back * own.1, normal);
        let (of_own, yielding) = self.twisted(twist);
        let (turn, aside) = (rotation_vector(swing), self.flatten(offset));
        let on_own = (yielding * (self.flatten(turn.cross(normal)) - self.other * aside)).clamp_length_max(self.reach);
        let on_other = aside + on_own;
        let lean = self.other * on_other;
        // Written so that what is no number stays behind too.
        let is_small = turn.length_squared() < MAX_TURN * MAX_TURN && lean.length_squared() < MAX_TURN * MAX_TURN;
        is_small.then(|| {
            let (x, drop) = along(on_own, of_own * on_own);
            let (y, other_drop) = along(on_other, lean);
            let (x, y) = (twist.conjugate() * self.raise(x) + normal * drop, self.raise(y) - normal * other_drop);
            let leaning = (normal + self.raise(lean * (1.0 + lean.length_squared() / 3.0))).normalize();
            CurvedPoint {
                normal: other.1 * leaning,
                lever: own.1 * (spot.lever + x),
                other_lever: other.1 * (spot.other_lever + y),
                separation: leaning.dot(offset + back * (own.1 * x) - y),
            }
        })
    }

    /// The body's operator after it has turned about the normal against the other, and the inverse of the sum.
    fn twisted(&self, twist: DQuat) -> (DMat2, DMat2) {
        let axes = self.tangents.map(|tangent| self.flatten(twist * tangent));
        let turn = DMat2::from_cols(axes[0], axes[1]);
        let own = turn * self.own * turn.transpose();
        // What is as round in all directions, or does not turn, keeps it.
        if own == self.own { (own, self.yielding) } else { (own, inverse_above(own + self.other, FLAT / self.reach)) }
    }

    /// Where the surfaces are tangent, from a point at which they are not: their outward normals there, and the way to the body's point from
    /// the other's (m).
    pub(super) fn settle(&self, spot: &CurvedPoint, [of_own, of_other]: [DVec3; 2], offset: DVec3) -> Option<CurvedPoint> {
        let (lean, aside) = (self.flatten(-of_own - of_other), self.flatten(offset));
        let on_own = (self.yielding * (lean - self.other * aside)).clamp_length_max(self.reach);
        let on_other = aside + on_own;
        let turn = self.other * on_other;
        let is_small = lean.length_squared() < MAX_TURN * MAX_TURN && turn.length_squared() < MAX_TURN * MAX_TURN;
        is_small.then(|| {
            let (x, drop) = along(on_own, self.own * on_own);
            let (y, other_drop) = along(on_other, turn);
            CurvedPoint {
                normal: (of_other + self.raise(turn)).normalize(),
                lever: spot.lever + self.raise(x) - of_own * drop,
                other_lever: spot.other_lever + self.raise(y) - of_other * other_drop,
                separation: of_other.dot(offset) - on_own.dot(lean)
                    + 0.5 * (on_own.dot(self.own * on_own) + on_other.dot(self.other * on_other)),
            }
        })
    }

    /// Stiffness against rocking of a unit force at a height below the centre of mass (m), as a matrix on rotation vectors, and the
    /// rate at which the orientation that it wants turns while the centre of mass moves at `speed` past the other surface (rad/s).
    pub(super) fn rocking(&self, normal: DVec3, height: f64, speed: DVec3) -> (DMat3, DVec3) {
        let round = DMat2::IDENTITY - self.own * height;
        let bent = self.yielding * (self.own + self.other);
        let stiffness = round * self.yielding * round + bent.transpose() * round * bent * height;
        let rocks = |axis: DVec3| normal.cross(self.raise(stiffness * self.flatten(axis.cross(normal))));
        let stiffness = DMat3::from_cols(rocks(DVec3::X), rocks(DVec3::Y), rocks(DVec3::Z));
        let around = (DMat2::IDENTITY + self.other * height).inverse() * (self.other * self.flatten(speed));
        (stiffness, normal.cross(self.raise(around)))
    }
}

/// A rotation as one about the normal and then one across it. Its vector as a whole is off by half the product of the two: by so much of its radius
/// the point under a ball that rolls on a turntable would lie aside.
fn split(rotation: DQuat, normal: DVec3) -> (DQuat, DQuat) {
    let about = normal * normal.dot(DVec3::new(rotation.x, rotation.y, rotation.z));
    let length = (about.length_squared() + rotation.w * rotation.w).sqrt();
    // Of half a turn across the normal it is not known.
    if length == 0.0 {
        return (rotation, DQuat::IDENTITY);
    }
    let twist = DQuat::from_xyzw(about.x / length, about.y / length, about.z / length, rotation.w / length);
    (rotation * twist.conjugate(), twist)
}

/// Where a way along a surface that turns its normal by `turn` ends: across the normal, and how far below the tangent plane (m). Series of
/// sin φ/φ and 2 (1 − cos φ)/φ², good to 3e-6 and 4e-7 at half a radian.
fn along(way: DVec2, turn: DVec2) -> (DVec2, f64) {
    let squared = turn.length_squared();
    let sine = 1.0 - squared * (1.0 / 6.0) * (1.0 - squared * (1.0 / 20.0));
    let fall = 1.0 - squared * (1.0 / 12.0) * (1.0 - squared * (1.0 / 30.0));
    (way * sine, 0.5 * way.dot(turn) * fall)
}

/// The inverse of a symmetric matrix on its eigenvectors whose eigenvalues are above `least`, zero on the others.
fn inverse_above(m: DMat2, least: f64) -> DMat2 {
    let (a, b, c) = (m.x_axis.x, m.x_axis.y, m.y_axis.y);
    let half = 0.5 * (a - c);
    let spread = (half * half + b * b).sqrt();
    let along = if half > 0.0 { DVec2::new(half + spread, b) } else { DVec2::new(b, spread - half) };
    let axis = along.try_normalize().unwrap_or(DVec2::X);
    let axes = [axis, axis.perp()];
    let mut inverse = DMat2::ZERO;
    for axis in axes {
        let curvature = axis.dot(m * axis);
        if curvature > least {
            inverse += DMat2::from_cols(axis * axis.x, axis * axis.y) * curvature.recip();
        }
    }
    inverse
}

/// How far a body has moved and turned from one stance to another (m).
pub(crate) fn change(now: &LocalPose, start: &LocalPose) -> (DVec3, DQuat) {
    (now.0 - start.0, now.1 * start.1.conjugate())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drum of 1 m about z, and over its top a flat link of half thickness 0.02 m along x, 1 mm off.
    fn link_on_drum() -> (Curved, CurvedPoint) {
        let drum = DMat3::from_diagonal(DVec3::X);
        let curved = Curved::new([DMat3::ZERO, drum], DVec3::Y, 1.0).expect("a drum is not flat");
        (curved, CurvedPoint { normal: DVec3::Y, lever: DVec3::Y * -0.02, other_lever: DVec3::Y, separation: 1e-3 })
    }

    /// In closed form: a line touches a circle where it is tangent, and is as far from it as from its centre, less the radius.
    #[test]
    fn a_link_touches_a_drum_where_it_is_tangent() {
        let (curved, spot) = link_on_drum();
        for (aside, up, angle) in [(0.03, 0.0, 0.0), (0.0, 0.002, 0.02), (0.01, -0.001, -0.01), (-0.02, 0.001, 0.03)] {
            let turn = DQuat::from_rotation_z(angle);
            let found = curved.follow(&spot, &(DVec3::new(aside, up, 0.0), turn), &(DVec3::ZERO, DQuat::IDENTITY)).unwrap();
            let (normal, center) = (turn * DVec3::Y, DVec3::new(aside, 1.021 + up, 0.0));
            let separation = normal.dot(center) - 0.02 - 1.0;
            let lever = normal * (1.0 + separation) - center;
            assert!((found.separation - separation).abs() < 2e-6, "{} m, expected {separation} m", found.separation);
            assert!((found.normal - normal).length() < 1e-4, "normal {}, expected {normal}", found.normal);
            assert!((found.lever - lever).length() < 2e-4, "lever {}, expected {lever}", found.lever);
        }
    }

    #[test]
    fn a_drum_that_turns_under_a_link_changes_nothing() {
        let (curved, spot) = link_on_drum();
        let own = (DVec3::new(0.01, 0.0, 0.0), DQuat::from_rotation_z(0.01));
        let still = curved.follow(&spot, &own, &(DVec3::ZERO, DQuat::IDENTITY)).unwrap();
        let turned = curved.follow(&spot, &own, &(DVec3::ZERO, DQuat::from_rotation_z(0.1))).unwrap();
        assert!((still.separation - turned.separation).abs() < 1e-5, "{} m and {} m", still.separation, turned.separation);
        assert!((still.normal - turned.normal).length() < 1e-3, "{} and {}", still.normal, turned.normal);
    }

    #[test]
    fn rocking_on_a_drum_is_as_stiff_as_its_radius_is_long() {
        let (curved, spot) = link_on_drum();
        let (stiffness, turning) = curved.rocking(spot.normal, 0.02, DVec3::X);
        let expected = DMat3::from_diagonal(DVec3::Z * 1.02);
        assert!(stiffness.abs_diff_eq(expected, 1e-12), "{stiffness}");
        assert!((turning - DVec3::Z * (-1.0 / 1.02)).length() < 1e-12, "{turning} rad/s");
    }

    #[test]
    fn a_rod_that_spins_on_a_floor_stays_where_it_is() {
        let rod = Curved::new([DMat3::from_diagonal(DVec3::Z / 0.02), DMat3::ZERO], DVec3::Y, 0.1).expect("a rod is round");
        let spot = CurvedPoint { normal: DVec3::Y, lever: DVec3::Y * -0.02, other_lever: DVec3::ZERO, separation: 0.0 };
        let found = rod.follow(&spot, &(DVec3::ZERO, DQuat::from_rotation_x(0.4)), &(DVec3::ZERO, DQuat::IDENTITY)).unwrap();
        assert!(found.separation.abs() < 1e-4, "{} m", found.separation);
        assert!((found.lever - spot.lever).length() < 2e-3, "{}", found.lever);
        let (stiffness, _) = rod.rocking(DVec3::Y, 0.02, DVec3::ZERO);
        assert!(stiffness.abs_diff_eq(DMat3::ZERO, 1e-12), "{stiffness}");
    }

    /// A ball that rolls over what turns under it touches it right below its centre.
    #[test]
    fn a_ball_that_rolls_on_a_turntable_touches_it_below_its_centre() {
        let ball = Curved::new([DMat3::IDENTITY / 0.1, DMat3::ZERO], DVec3::Y, 0.1).expect("a ball is round");
        let spot = CurvedPoint { normal: DVec3::Y, lever: DVec3::Y * -0.1, other_lever: DVec3::X, separation: 0.0 };
        let own = (DVec3::new(0.02, 0.0, 0.01), DQuat::from_rotation_y(0.1) * DQuat::from_rotation_z(-0.3));
        let found = ball.follow(&spot, &own, &(DVec3::ZERO, DQuat::from_rotation_y(0.2))).unwrap();
        assert!((found.lever - spot.lever).length() < 1e-6, "{}", found.lever);
        // Where it is on the table is good to third order.
        assert!((found.other_lever - DVec3::new(1.02, 0.0, 0.01)).length() < 5e-4, "{}", found.other_lever);
    }

    #[test]
    fn flat_on_flat_has_no_wandering_point() {
        assert!(Curved::new([DMat3::ZERO; 2], DVec3::Y, 1.0).is_none());
    }
}
