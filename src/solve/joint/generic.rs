//! Generic six-axis joint: each translation and rotation along A's axes free, locked, limited or driven.
//!
//! Translations are the gap's components in A's frame. Rotations are Euler angles R_aᵀ R_b = R_x(φ) R_y(θ) R_z(ψ): φ turns about
//! A's x axis, ψ about B's z axis, θ about their common normal. The gradient of each angle is the vector of the dual basis, so
//! that the angles are exact away from θ = ±π/2.

use glam::{DMat3, DVec3};

use super::geometry::Placement;
use super::kinds::{Coordinate, RowSink};
use super::rows::{Held, Jacobian};
use crate::joint::{Axis, Limits};

/// Least volume of the basis (cosine of θ) at which the dual basis is formed.
const MIN_BASIS_VOLUME: f64 = 0.05;

pub(crate) fn rows(sink: &mut RowSink, linear: &[Axis; 3], angular: &[Axis; 3]) {
    let locked = |axes: &[Axis; 3]| axes.iter().all(|axis| axis.limits == Limits::new(0.0, 0.0));
    let axes = sink.geometry.gradient.axes_a();
    if locked(angular) {
        sink.hold_directions(Held::All, Placement::rotation_vector);
    } else {
        let duals = dual_axes(sink.geometry.gradient);
        for (i, axis) in angular.iter().enumerate() {
            let angle = Coordinate {
                jacobian: Jacobian::angular(duals.col(i)),
                value: move |p: &Placement| euler_angles(p)[i],
                is_angle: true,
            };
            sink.limit_and_drive(&angle, axis.limits, axis.motor, 9 + 3 * i as u8);
            sink.rub(angle.jacobian, sink.def.axis_friction[3 + i], axis.limits, 3 + i as u8);
        }
    }
    if locked(linear) {
        sink.hold_points(Held::All);
    } else {
        for (i, axis) in linear.iter().enumerate() {
            let slide =
                Coordinate { jacobian: sink.along(axes.col(i)), value: move |p: &Placement| p.local_gap()[i], is_angle: false };
            sink.limit_and_drive(&slide, axis.limits, axis.motor, 3 * i as u8);
            sink.rub(slide.jacobian, sink.def.axis_friction[i], axis.limits, i as u8);
        }
    }
}

/// φ, θ, ψ of R_aᵀ R_b = R_x(φ) R_y(θ) R_z(ψ) (rad).
pub(crate) fn euler_angles(placement: &Placement) -> DVec3 {
    let r = DMat3::from_quat(placement.relative_rotation());
    DVec3::new(
        libm::atan2(-r.z_axis.y, r.z_axis.z),
        libm::asin(r.z_axis.x.clamp(-1.0, 1.0)),
        libm::atan2(-r.y_axis.x, r.x_axis.x),
    )
}

/// The vectors that pick φ', θ' and ψ' out of the relative angular velocity (world axes).
fn dual_axes(placement: &Placement) -> DMat3 {
    let x = placement.a.frame * DVec3::X;
    let z = placement.b.frame * DVec3::Z;
    let normal = z.cross(x);
    let cosine = normal.length();
    if cosine < MIN_BASIS_VOLUME {
        return placement.axes_a();
    }
    let y = normal / cosine;
    DMat3::from_cols(y.cross(z) / cosine, y, x.cross(y) / cosine)
}
