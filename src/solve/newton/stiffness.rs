//! Geometric stiffness: how the forces of joints, cables and rolling contacts turn with what they act on.
//!
//! A force f at a lever r has the stiffness (f·r) 1 − ½ (f rᵀ + r fᵀ) against rotation. A link under heavy tension is stiff beyond what any
//! substep resolves, so the stiffness must be implicit; where it is negative, as under compression, it must not be: what buckles then
//! buckles at its own rate, as J(q)ᵀ λ says. So the positive part of each body's sum is taken, in its own axes.
//!
//! A contact between surfaces that curve is stiff as well, as its point wanders. With the shape operators A of the other surface and B of
//! the body's own, a direction t across the normal, curvatures a and b along it, and the body's centre of mass at the height h above the
//! contact, a rotation by θ that leans the normal to t, and a way x along t change the gap to second order by −½ S with
//!
//! ```text
//! S = y (θ − a (x − h θ))² − a (x − h θ)² − h θ²,      y = 1/(a + b).
//! ```
//!
//! For a flat link on a drum S = (R + h) θ² − 2 θ x. Of this matrix too only the positive part is taken, as one row, with lengths measured
//! by that by which θ is stiff. Without it a frictionless rope under 10 t leaves its drum within a tenth of a second.

use glam::{DMat3, DVec3};

/// Steps towards the outermost eigenvalue, at most: Laguerre's method takes two to four from where it begins.
const EIGENVALUE_STEPS: usize = 8;

/// Change of the eigenvalue, over itself, below which a step is the last, as the next one would be of the order of its cube; and over the size
/// of the matrix.
const EIGENVALUE_CHANGE: [f64; 2] = [1.0e-5, 1.0e-12];

/// The part of a symmetric matrix that has no negative eigenvalue.
///
/// Of three eigenvalues at most two have the sign of each other, so that one at an end of the spectrum stands alone: of a matrix A with one
/// negative eigenvalue λ and its axis u the part is A − λ u uᵀ, of one with one positive λ it is λ u uᵀ. λ is further from the others than
/// from zero, so that what rounding does to u is next to nothing in λ u uᵀ.
pub(crate) fn positive_part(matrix: DMat3) -> DMat3 {
    let scale = matrix.to_cols_array().iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
    if scale == 0.0 || !scale.is_finite() {
        return DMat3::ZERO;
    }
    let a = matrix * (1.0 / scale);
    let [x, y, z] = [a.x_axis, a.y_axis, a.z_axis];
    let minors = (x.x * y.y - x.y * x.y) + (x.x * z.z - x.z * x.z) + (y.y * z.z - y.z * y.z);
    let (trace, determinant) = (x.x + y.y + z.z, x.dot(y.cross(z)));
    // By Descartes' rule of signs.
    if determinant >= 0.0 && minors >= 0.0 && trace >= 0.0 {
        return matrix;
    }
    if determinant <= 0.0 && minors >= 0.0 && trace <= 0.0 {
        return DMat3::ZERO;
    }
    let is_only_positive = determinant > 0.0;
    let end = if is_only_positive { 1.0 } else { -1.0 };
    let found = outermost(end, [trace, minors, determinant]);
    let Some(axis) = axis_of(a, found) else { return if is_only_positive { DMat3::ZERO } else { matrix } };
    // The quotient of Rayleigh is off by the square of what the axis is.
    let value = axis.dot(a * axis) * end;
    let share = axis * (value.max(0.0) * scale);
    let own = DMat3::from_cols(axis * share.x, axis * share.y, axis * share.z);
    if is_only_positive { own } else { matrix + own }
}

/// The part of a stiffness K against rotation, of an inertia I, that a substep does not resolve: K X² (1 + X²)⁻¹ with X = I⁻¹ K.
///
/// What is resolved, X well below one, is in the rows, which turn with the bodies from one substep to the next, and keeps its energy so.
/// The rest of an oscillation, K/(1 + X²), is taken as in the leapfrog, which bears X up to four, and is at most half of the inertia that stands
/// against it. With X in place of X² a bob on a hinge loses 13 % in 10 s at 30 steps a second instead of 4.
pub(crate) fn unresolved(stiffness: DMat3, inertia: DMat3) -> DMat3 {
    let ratio = inertia.inverse() * stiffness;
    let square = ratio * ratio;
    let part = stiffness * square * (DMat3::IDENTITY + square).inverse();
    0.5 * (part + part.transpose())
}

/// The greatest eigenvalue (`end` is 1) or the least one (−1) of a matrix with these coefficients of its characteristic polynomial, by the
/// method of Laguerre: where all roots are real it goes to the outermost from outside without passing it.
fn outermost(end: f64, [trace, minors, determinant]: [f64; 3]) -> f64 {
    let mean = trace / 3.0;
    // Mean of the squares of how far eigenvalues are from their mean: no root is farther than √2 times the root of it.
    let spread = (2.0 / 9.0 * (trace * trace - 3.0 * minors)).max(0.0);
    let mut value = mean + end * (2.0 * spread).sqrt();
    for _ in 0..EIGENVALUE_STEPS {
        let at = ((value - trace) * value + minors) * value - determinant;
        let slope = (3.0 * value - 2.0 * trace) * value + minors;
        let bend = 6.0 * value - 2.0 * trace;
        let root = (4.0 * slope * slope - 6.0 * at * bend).max(0.0).sqrt();
        let below = slope + root.copysign(slope);
        if below == 0.0 {
            break;
        }
        let change = 3.0 * at / below;
        value -= change;
        if change.abs() <= EIGENVALUE_CHANGE[0] * value.abs() + EIGENVALUE_CHANGE[1] {
            break;
        }
    }
    value
}

/// Axis of an eigenvalue that stands alone: across two columns of the matrix without it, those that are the most across each other.
fn axis_of(matrix: DMat3, value: f64) -> Option<DVec3> {
    let left = matrix - DMat3::from_diagonal(DVec3::splat(value));
    let [x, y, z] = [left.x_axis, left.y_axis, left.z_axis];
    let mut longest = x.cross(y);
    for other in [y.cross(z), z.cross(x)] {
        if other.length_squared() > longest.length_squared() {
            longest = other;
        }
    }
    longest.try_normalize()
}

/// Two surfaces that roll on each other: directions across the normal, and curvatures of the body's own and of the other along them (1/m).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rolling {
    pub directions: [DVec3; 2],
    pub own: [f64; 2],
    pub other: [f64; 2],
}

/// Curvature of both surfaces, times the reach of the body, below which they are flat on each other.
const FLAT: f64 = 1.0e-3;

impl Rolling {
    /// From the shape operators of the body and of the other in world axes (1/m); `reach` is the body's (m).
    pub(crate) fn new([own, other]: [DMat3; 2], normal: DVec3, reach: f64) -> Option<Self> {
        let (u, v) = normal.any_orthonormal_pair();
        let sum = own + other;
        let (uu, uv, vv) = (u.dot(sum * u), u.dot(sum * v), v.dot(sum * v));
        if uu.max(vv) * reach <= FLAT {
            return None;
        }
        let half = 0.5 * (uu - vv);
        let spread = (half * half + uv * uv).sqrt();
        let along = if half > 0.0 { [half + spread, uv] } else { [uv, spread - half] };
        let first = (u * along[0] + v * along[1]).try_normalize().unwrap_or(u);
        let directions = [first, normal.cross(first)];
        let curvature = |operator: DMat3| directions.map(|t| t.dot(operator * t));
        let rolling = Self { directions, own: curvature(own), other: curvature(other) };
        Some(rolling)
    }

    /// Rate at which a body turns about `normal` × each direction as it goes round the other surface at this speed, its centre of mass at
    /// this height (rad/s).
    pub(crate) fn turning(&self, speed: DVec3, height: f64) -> [f64; 2] {
        [0, 1].map(|k| self.other[k] / (1.0 + self.other[k] * height) * self.directions[k].dot(speed))
    }

    /// Rows against rolling, of the body's rotation about an axis and of its way along a direction past the other, and the stiffness of each
    /// for a unit force at this height below the centre of mass (m).
    pub(crate) fn rows(&self, normal: DVec3, height: f64, reach: f64) -> [Option<([DVec3; 2], f64)>; 2] {
        [0, 1].map(|k| {
            let (a, b, t) = (self.other[k], self.own[k], self.directions[k]);
            if (a + b) * reach <= FLAT {
                return None;
            }
            let y = 1.0 / (a + b);
            let lean = 1.0 + a * height;
            let turning = y * lean * lean - a * height * height - height;
            if turning <= 0.0 {
                return None;
            }
            let mixed = -y * a * lean + a * height;
            let along = y * a * a - a;
            // In lengths of `turning`, so that both are measured alike.
            let (p, q, r) = (1.0 / turning, mixed / turning, along);
            let half = 0.5 * (p - r);
            let spread = (half * half + q * q).sqrt();
            let value = 0.5 * (p + r) + spread;
            let [c, s] = if q == 0.0 { [1.0, 0.0] } else { [half + spread, q] };
            let scale = (c * c + s * s).sqrt();
            (value > 0.0).then(|| ([normal.cross(t) * (c / scale * turning), t * (s / scale)], value))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eigenvalues of all signs, apart, in pairs and next to zero; A − A⁺ has no positive eigenvalue then, and A⁺ none below zero.
    #[test]
    fn the_positive_part_keeps_what_is_positive() {
        let axes = DMat3::from_quat(glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.1));
        let sizes = [3.0, 1.0, 0.9999999, 1.0e-3, 1.0e-9, 0.0, -1.0e-9, -1.0e-3, -0.5, -0.5000001, -2.0];
        for axes in [DMat3::IDENTITY, axes] {
            let with = |values: DVec3| axes * DMat3::from_diagonal(values) * axes.transpose();
            for (a, b, c) in sizes.iter().flat_map(|&a| sizes.map(|b| (a, b))).flat_map(|(a, b)| sizes.map(|c| (a, b, c))) {
                for scale in [1.0, 1.0e-12, 1.0e9] {
                    let values = DVec3::new(a, b, c) * scale;
                    let (found, expected) = (positive_part(with(values)), with(values.max(DVec3::ZERO)));
                    assert!(found.abs_diff_eq(expected, 1.0e-8 * scale), "{values}: {found} instead of {expected}");
                }
            }
        }
        assert_eq!(positive_part(DMat3::ZERO), DMat3::ZERO);
    }

    /// A flat link of half thickness r on a drum of radius R: [[D, −1], [−1, 0]] with D = R + r has the one positive eigenvalue 1.618 in
    /// lengths of D.
    #[test]
    fn a_link_on_a_drum_is_stiff_by_the_golden_ratio() {
        let drum = DMat3::from_diagonal(DVec3::X / 0.3);
        let rolling = Rolling::new([DMat3::ZERO, drum], DVec3::Y, 0.05).expect("a drum is not flat");
        let rows = rolling.rows(DVec3::Y, 0.02, 0.05);
        let ([about, along], value) = rows.into_iter().flatten().next().expect("it rolls along x");
        assert!((value * 0.32 - 1.618_034).abs() < 1.0e-6, "{value}");
        assert!((about.length() - 0.850_651 * 0.32).abs() < 1.0e-6, "{about}");
        assert!((along.length() - 0.525_731).abs() < 1.0e-6, "{along}");
    }
}
