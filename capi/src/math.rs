//! Poses as C sees them. Vectors are three floats, points three doubles, rotations four floats (x, y, z, w).

use ls_core::Pose;
use ls_core::glam::{DVec3, Quat};

/// Where something is: position in double, rotation in float precision.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsPose {
    /// Origin of the frame (m); at most 1e9 m from that of the world.
    pub position: [f64; 3],
    /// Rotation of the frame, unit quaternion x, y, z, w; up to 1 % off unit length is normalised, more is refused.
    pub rotation: [f32; 4],
}

impl From<LsPose> for Pose {
    fn from(pose: LsPose) -> Self {
        Self { position: DVec3::from_array(pose.position), rotation: Quat::from_array(pose.rotation) }
    }
}

impl From<Pose> for LsPose {
    fn from(pose: Pose) -> Self {
        Self { position: pose.position.to_array(), rotation: pose.rotation.to_array() }
    }
}
