//! What answers where some axes are held.
//!
//! W says how all axes answer to what acts along them. Where one is held, what holds it acts along it too, and takes from the others what it turns:
//! W − W_k W_kᵀ/W_kk is left, the inverse of what W⁻¹ says of the others alone. To leave out the row and the column would let a body that leans answer
//! as if it were lighter than it is about the axis that is free.

use glam::{DMat3, DVec3, Mat3, Vec3};

/// Of a symmetric positive definite matrix; `free` is 1 along free axes and 0 along held ones.
pub(crate) fn held(mut answer: DMat3, free: DVec3) -> DMat3 {
    for axis in (0..3).filter(|&axis| free[axis] == 0.0) {
        let row = answer.col(axis);
        if row[axis] > 0.0 {
            let share = row / row[axis];
            answer -= DMat3::from_cols(row * share.x, row * share.y, row * share.z);
        }
        answer = without(answer, axis);
    }
    answer
}

/// The same in single precision, bit for bit where no axis is held.
pub(crate) fn held32(answer: Mat3, free: Vec3) -> Mat3 {
    if free == Vec3::ONE { answer } else { held(answer.as_dmat3(), free.as_dvec3()).as_mat3() }
}

fn without(matrix: DMat3, axis: usize) -> DMat3 {
    let mut kept = DVec3::ONE;
    kept[axis] = 0.0;
    DMat3::from_cols(matrix.x_axis * kept * kept.x, matrix.y_axis * kept * kept.y, matrix.z_axis * kept * kept.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a body of the moments 1, 2 and 30 that leans: what is left is the inverse of the part of its inertia that is free.
    #[test]
    fn what_is_left_is_the_inverse_of_the_part_that_is_free() {
        let axes = DMat3::from_quat(glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 1.3));
        let inertia = axes * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 30.0)) * axes.transpose();
        for bits in 0..8 {
            let free = DVec3::from_array([0, 1, 2].map(|axis| f64::from(bits >> axis & 1)));
            let found = held(inertia.inverse(), free);
            let only = DMat3::from_diagonal(free);
            let unit = only * inertia * only * found;
            assert!(unit.abs_diff_eq(only, 1.0e-12), "{free}: {unit}");
            assert!((found - only * found * only).abs_diff_eq(DMat3::ZERO, 0.0), "{free}: {found}");
        }
    }
}
