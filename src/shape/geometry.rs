//! Geometry of a shape: plain data, in the shape's own frame.

use glam::{Quat, Vec3};
use parry3d::math::Pose3;

use crate::check;
use crate::error::Result;

/// Smallest and largest extent of a shape (m).
pub const EXTENT_RANGE: (f32, f32) = (1.0e-5, 1.0e6);

/// Most points that a convex hull may be built from.
pub const MAX_HULL_POINTS: usize = 4096;

/// Smallest ratio between the least and the greatest extent of a hull's points; thinner is not a solid.
pub(super) const MIN_HULL_ASPECT: f32 = 1.0e-4;

/// Position (m) and rotation of a shape on its body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalPose {
    /// Origin of the shape in the body's frame (m).
    pub position: Vec3,
    /// Rotation of the shape in the body's frame, unit quaternion.
    pub rotation: Quat,
}

impl LocalPose {
    /// The body's own frame.
    pub const IDENTITY: Self = Self { position: Vec3::ZERO, rotation: Quat::IDENTITY };

    /// A frame at `position`, not rotated.
    pub const fn at(position: Vec3) -> Self {
        Self { position, rotation: Quat::IDENTITY }
    }

    pub(crate) fn to_parry(self) -> Pose3 {
        Pose3::from_parts(self.position, self.rotation)
    }

    pub(crate) fn checked(self) -> Result<Self> {
        check::lever("local_pose.position", self.position)?;
        Ok(Self { rotation: check::rotation("local_pose.rotation", self.rotation)?, ..self })
    }
}

impl Default for LocalPose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// The form of a shape, as plain data (m).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// A ball.
    Ball {
        /// Radius (m).
        radius: f32,
    },
    /// A box.
    Box {
        /// Half of each edge (m).
        half_extents: Vec3,
    },
    /// A cylinder with hemispheres at its ends, along y.
    Capsule {
        /// Half the length of the cylindrical part (m).
        half_height: f32,
        /// Radius (m).
        radius: f32,
    },
    /// A cylinder along y.
    Cylinder {
        /// Half the height (m).
        half_height: f32,
        /// Radius (m).
        radius: f32,
    },
    /// A cone along y, tip up, with its origin halfway up.
    Cone {
        /// Half the height (m).
        half_height: f32,
        /// Radius of the base (m).
        radius: f32,
    },
    /// The convex hull of some points.
    ConvexHull {
        /// At least four points, not in one plane (m).
        points: Vec<Vec3>,
    },
    /// Triangles, for static and kinematic bodies only.
    TriangleMesh {
        /// Vertices (m).
        vertices: Vec<Vec3>,
        /// Three vertex indices a triangle, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
    /// Heights on a grid in the x–z plane, centred on the origin, for static and kinematic bodies only.
    HeightField {
        /// Number of rows, along z; at least 2.
        rows: usize,
        /// Number of columns, along x; at least 2.
        columns: usize,
        /// `rows × columns` heights along y, row by row (m).
        heights: Vec<f32>,
        /// Extent of the whole field along x (m).
        size_x: f32,
        /// Extent of the whole field along z (m).
        size_z: f32,
    },
    /// All points below a plane through the origin, for static and kinematic bodies only.
    HalfSpace {
        /// Outward unit normal.
        normal: Vec3,
    },
    /// Several convex forms as one shape with one material.
    Compound {
        /// Each part with its place; parts are convex.
        parts: Vec<(LocalPose, Geometry)>,
    },
}

impl Geometry {
    /// Whether the form encloses a volume, so that a dynamic body may carry it.
    pub fn is_solid(&self) -> bool {
        !matches!(self, Self::TriangleMesh { .. } | Self::HeightField { .. } | Self::HalfSpace { .. })
    }
}
