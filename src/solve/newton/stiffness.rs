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

/// Rotations of the Jacobi method that find the axes of a matrix.
const SWEEPS: usize = 8;

/// The part of a symmetric matrix that has no negative eigenvalue.
pub(crate) fn positive_part(matrix: DMat3) -> DMat3 {
    let mut a: [[f64; 3]; 3] = matrix.to_cols_array_2d();
    let mut axes = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..SWEEPS {
        let off = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
        if off <= 1.0e-14 * (a[0][0].abs() + a[1][1].abs() + a[2][2].abs()) {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut a, &mut axes, p, q);
        }
    }
    let mut result = DMat3::ZERO;
    for (k, axis) in axes.into_iter().enumerate() {
        let axis = DVec3::from_array(axis);
        let value = a[k][k].max(0.0);
        result += DMat3::from_cols(axis * (axis.x * value), axis * (axis.y * value), axis * (axis.z * value));
    }
    result
}

/// Turns two axes so that the matrix has nothing off its diagonal between them. `axes` are rows.
fn rotate(a: &mut [[f64; 3]; 3], axes: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = 1.0_f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for k in 0..3 {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
        (axes[p][k], axes[q][k]) = (c * axes[p][k] - s * axes[q][k], s * axes[p][k] + c * axes[q][k]);
    }
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

    #[test]
    fn the_positive_part_keeps_what_is_positive() {
        let axes = DMat3::from_quat(glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.1));
        let with = |values: DVec3| axes * DMat3::from_diagonal(values) * axes.transpose();
        let found = positive_part(with(DVec3::new(3.0, -2.0, 0.5)));
        let expected = with(DVec3::new(3.0, 0.0, 0.5));
        assert!(found.abs_diff_eq(expected, 1.0e-12), "{found} instead of {expected}");
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
