//! Eigenvalues and eigenvectors of a symmetric 3×3 matrix, by cyclic Jacobi rotations, `f64`.

use glam::{DMat3, DVec3};

/// Sweeps after which the off-diagonal entries are far below rounding: convergence is quadratic.
const MAX_SWEEPS: usize = 12;

/// Eigenvalues, and eigenvectors as the columns of a rotation in the same order.
pub(crate) fn symmetric_eigen(matrix: DMat3) -> (DVec3, DMat3) {
    let mut a = matrix.to_cols_array_2d();
    let mut v = DMat3::IDENTITY.to_cols_array_2d();
    let scale: f64 = a.iter().flatten().map(|x| x * x).sum();
    for _ in 0..MAX_SWEEPS {
        let off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
        if off <= 1.0e-34 * scale {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = 1.0_f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                let (x, y) = (row[p], row[q]);
                (row[p], row[q]) = (c * x - s * y, s * x + c * y);
            }
            rotate_rows(&mut a, p, q, c, s);
            // Columns of `v` are its first index.
            rotate_rows(&mut v, p, q, c, s);
        }
    }
    let mut vectors = DMat3::from_cols_array_2d(&v);
    if vectors.determinant() < 0.0 {
        vectors.z_axis = -vectors.z_axis;
    }
    (DVec3::new(a[0][0], a[1][1], a[2][2]), vectors)
}

/// Turns two rows into each other, by the angle of this cosine and sine.
fn rotate_rows(m: &mut [[f64; 3]; 3], p: usize, q: usize, c: f64, s: f64) {
    let (row_p, row_q) = (m[p], m[q]);
    m[p] = std::array::from_fn(|k| c * row_p[k] - s * row_q[k]);
    m[q] = std::array::from_fn(|k| s * row_p[k] + c * row_q[k]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_rotated_diagonal_is_found_again() {
        let turn = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.3));
        for diagonal in [DVec3::new(3.0, 1.0, 2.0), DVec3::new(1.0e6, 1.0, 1.0e-6), DVec3::splat(2.0), DVec3::new(0.0, 5.0, 5.0)]
        {
            let matrix = turn * DMat3::from_diagonal(diagonal) * turn.transpose();
            let (values, vectors) = symmetric_eigen(matrix);
            let back = vectors * DMat3::from_diagonal(values) * vectors.transpose();
            let error = (back - matrix).to_cols_array().iter().fold(0.0_f64, |worst, x| worst.max(x.abs()));
            assert!(error < 1.0e-14 * diagonal.max_element(), "error {error:e} for {diagonal}");
            assert!((vectors.determinant() - 1.0).abs() < 1.0e-12);
        }
    }
}
