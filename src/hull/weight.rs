//! Volume, centre of mass and inertia of what a closed surface of triangles encloses, in `f64` (Mirtich 1996, by tetrahedra).

use glam::{DMat3, DVec3};

use super::Triangulation;

/// Integrals over a solid of density 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SolidIntegrals {
    /// Volume (m³).
    pub volume: f64,
    /// Centre of mass (m).
    pub center: DVec3,
    /// ∫ (|r|² 1 − r rᵀ) dV about the centre of mass (m⁵).
    pub inertia: DMat3,
}

/// Sums tetrahedra from a corner of the surface to each triangle.
///
/// With one corner at the origin and the others at a, b, c: V = a·(b×c)/6, ∫ r dV = V (a+b+c)/4,
/// ∫ r rᵀ dV = V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ) with s = a+b+c.
pub(crate) fn weigh(surface: &Triangulation) -> SolidIntegrals {
    let origin = surface.points[0].as_dvec3();
    let (mut volume, mut moment, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|index| surface.points[index as usize].as_dvec3() - origin);
        let own = a.dot(b.cross(c)) / 6.0;
        let sum = a + b + c;
        volume += own;
        moment += own * 0.25 * sum;
        second += [a, b, c, sum].into_iter().map(|v| outer(v, v)).fold(DMat3::ZERO, |a, b| a + b) * (own / 20.0);
    }
    let from_origin = moment / volume;
    second += outer(from_origin, from_origin) * -volume;
    let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
    SolidIntegrals { volume, center: origin + from_origin, inertia: DMat3::from_diagonal(DVec3::splat(trace)) - second }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Eigenvalues of a symmetric matrix and the rotation to its eigenvectors (Jacobi's method), for inertia tensors whose
/// moments may differ by many powers of ten.
pub(crate) fn principal_axes(tensor: DMat3) -> (DVec3, DMat3) {
    /// Sweeps; each squares what is left beside the diagonal.
    const SWEEPS: usize = 16;
    let mut m = tensor.to_cols_array_2d();
    let mut axes = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q] == 0.0 || m[p][q].abs() <= f64::EPSILON * 1.0e-3 * (m[p][p] * m[q][q]).abs().sqrt() {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = 1.0_f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let off = m[p][q];
            m[p][p] -= t * off;
            m[q][q] += t * off;
            (m[p][q], m[q][p]) = (0.0, 0.0);
            let r = 3 - p - q;
            let (rp, rq) = (m[r][p], m[r][q]);
            (m[r][p], m[r][q]) = (c * rp - s * rq, s * rp + c * rq);
            (m[p][r], m[q][r]) = (m[r][p], m[r][q]);
            #[allow(clippy::needless_range_loop, reason = "k names an axis of several arrays")]
            for k in 0..3 {
                let (kp, kq) = (axes[p][k], axes[q][k]);
                (axes[p][k], axes[q][k]) = (c * kp - s * kq, s * kp + c * kq);
            }
        }
    }
    let mut axes = DMat3::from_cols_array_2d(&axes);
    if axes.determinant() < 0.0 {
        axes.z_axis = -axes.z_axis;
    }
    (DVec3::new(m[0][0], m[1][1], m[2][2]), axes)
}
