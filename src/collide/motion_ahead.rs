//! Where shapes will be within a step.

use glam::{Quat, Vec3};

use super::collider_state::ColliderState;
use crate::linalg::rotation32::rotated_far;
use crate::shape::{Geometry, Shape};

/// Square of half a turn (rad²) below which sine and cosine are the first terms of their series, right to rounding.
const SMALL_TURN: f32 = 1.0e-4;

/// Turn of a body that is followed (rad): about as far as four substeps turn anything.
const MAX_TURN: f32 = 6.0;

/// A vector turned by a rotation, which often is none.
pub(super) fn applied(turn: Quat, vector: Vec3) -> Vec3 {
    if turn == Quat::IDENTITY { vector } else { turn * vector }
}

/// How a body is turned after `t` (s).
pub(super) fn turned(angular: Vec3, t: f32) -> Quat {
    if angular == Vec3::ZERO {
        return Quat::IDENTITY;
    }
    let half = angular * (0.5 * t);
    let x = half.length_squared();
    if x < SMALL_TURN {
        let axis = half * (1.0 - x / 6.0);
        return Quat::from_xyzw(axis.x, axis.y, axis.z, 1.0 - 0.5 * x);
    }
    rotated_far(Quat::IDENTITY, (angular * t).clamp_length_max(MAX_TURN))
}

impl ColliderState {
    /// Whether turning changes nothing of what the shape does to another: that of a ball about its centre of mass, where normals go through
    /// the centre. Those of the triangles of a surface may not.
    pub(super) fn turns_in_itself(&self, shape: &Shape, other: &Shape) -> bool {
        self.offset == Vec3::ZERO && matches!(shape.geometry(), Geometry::Ball { .. }) && other.geometry().is_solid()
    }

    /// Speed at which the surface goes where the shape was not, by turning (m/s). A shape that holds a ball of radius ρ about the centre and
    /// reaches as far as R has a support function whose slope is at most √(R² − ρ²): nothing of a ball.
    pub(super) fn sweep_speed(&self, angular: Vec3) -> f32 {
        let held = 0.25 * self.least_extent * self.least_extent * angular.length_squared();
        (self.turning * self.turning - held).max(0.0).sqrt()
    }

    /// How far the shape's origin has moved after `t` (s, m), and how the shape is turned then, if it is turned by `turn` in its own frame.
    pub(super) fn after(&self, turn: Quat, t: f32) -> (Vec3, Quat) {
        let rotation = if turn == Quat::IDENTITY { self.rotation } else { self.rotation * turn };
        if self.offset == Vec3::ZERO {
            return (self.velocity * t, rotation);
        }
        let offset = rotation * (self.rotation.conjugate() * self.offset);
        (self.velocity * t + (offset - self.offset), rotation)
    }
}
