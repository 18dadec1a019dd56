//! Where something is: position in `f64`, rotation as a unit quaternion in `f32`.

use glam::{DVec3, Quat, Vec3};

use crate::check;
use crate::error::Result;

/// Position (m) and rotation of a frame, in world coordinates or in those of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Origin of the frame (m).
    pub position: DVec3,
    /// Rotation of the frame, unit quaternion.
    pub rotation: Quat,
}

impl Pose {
    /// The frame of the world itself.
    pub const IDENTITY: Self = Self { position: DVec3::ZERO, rotation: Quat::IDENTITY };

    /// A frame at `position`, not rotated.
    pub const fn at(position: DVec3) -> Self {
        Self { position, rotation: Quat::IDENTITY }
    }

    /// A frame at (`x`, `y`, `z`), not rotated.
    pub const fn at_xyz(x: f64, y: f64, z: f64) -> Self {
        Self::at(DVec3::new(x, y, z))
    }

    /// The same position with another rotation.
    pub const fn rotated(self, rotation: Quat) -> Self {
        Self { rotation, ..self }
    }

    /// World position of a point given in this frame (m).
    pub fn transform_point(&self, local: Vec3) -> DVec3 {
        self.position + (self.rotation * local).as_dvec3()
    }

    /// Coordinates in this frame of a world point (m); the difference is formed in `f64`.
    pub fn inverse_transform_point(&self, world: DVec3) -> Vec3 {
        self.rotation.conjugate() * (world - self.position).as_vec3()
    }

    /// The frame `local`, given in this frame, in world coordinates.
    pub fn transform(&self, local: &Pose) -> Pose {
        let offset = self.rotation.as_dquat() * local.position;
        Pose { position: self.position + offset, rotation: (self.rotation * local.rotation).normalize() }
    }

    pub(crate) fn checked(self, position: &'static str, rotation: &'static str) -> Result<Self> {
        Ok(Self { position: check::position(position, self.position)?, rotation: check::rotation(rotation, self.rotation)? })
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}
