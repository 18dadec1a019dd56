//! A convex piece of a shape: what the pair functions work on.

use glam::Vec3;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose3;
use parry3d::shape::{SupportMap, Triangle, TrianglePseudoNormals};

use crate::hull::Hull;
use crate::shape::{Geometry, Shape};

/// A convex piece, in its own frame. Lengths in metres, as in [`Geometry`].
#[derive(Clone)]
pub(super) enum Part<'a> {
    Ball {
        radius: f32,
    },
    Box {
        half_extents: Vec3,
    },
    Capsule {
        half_height: f32,
        radius: f32,
    },
    Cylinder {
        half_height: f32,
        radius: f32,
    },
    Cone {
        half_height: f32,
        radius: f32,
    },
    Hull(&'a Hull),
    HalfSpace {
        normal: Vec3,
    },
    /// A triangle about its centroid, with the directions in which its neighbours let it push.
    Triangle {
        triangle: Triangle,
        constraints: Option<TrianglePseudoNormals>,
    },
}

impl<'a> Part<'a> {
    /// The part that a shape is; none for a shape of several.
    pub fn whole(shape: &'a Shape) -> Option<Self> {
        Self::of(shape.geometry(), &**shape.parry())
    }

    pub fn of(geometry: &'a Geometry, parry: &'a dyn parry3d::shape::Shape) -> Option<Self> {
        Some(match *geometry {
            Geometry::Ball { radius } => Self::Ball { radius },
            Geometry::Box { half_extents } => Self::Box { half_extents },
            Geometry::Capsule { half_height, radius } => Self::Capsule { half_height, radius },
            Geometry::Cylinder { half_height, radius } => Self::Cylinder { half_height, radius },
            Geometry::Cone { half_height, radius } => Self::Cone { half_height, radius },
            Geometry::ConvexHull { .. } => Self::Hull(parry.as_shape::<Hull>()?),
            Geometry::HalfSpace { .. } => Self::HalfSpace { normal: parry.as_halfspace()?.normal },
            Geometry::TriangleMesh { .. } | Geometry::HeightField { .. } | Geometry::Compound { .. } => return None,
        })
    }

    /// Radius of a ball about the origin that holds the part (m).
    pub fn reach(&self) -> f32 {
        match self {
            Self::Ball { radius } => *radius,
            Self::Box { half_extents } => half_extents.length(),
            Self::Capsule { half_height, radius } => half_height + radius,
            Self::Cylinder { half_height, radius } | Self::Cone { half_height, radius } => {
                (half_height * half_height + radius * radius).sqrt()
            }
            Self::Hull(hull) => hull.reach() as f32,
            Self::Triangle { triangle, .. } => triangle.vertices().iter().map(|p| p.length()).fold(0.0, f32::max),
            Self::HalfSpace { .. } => f32::INFINITY,
        }
    }

    /// Half the thickness where the part is round, else a tenth of its reach: the scale of a line of contact (m).
    pub fn girth(&self) -> f32 {
        match self {
            Self::Ball { radius } | Self::Capsule { radius, .. } => *radius,
            Self::Cylinder { half_height, radius } | Self::Cone { half_height, radius } => radius.min(*half_height),
            _ => 0.1 * self.reach(),
        }
    }

    /// Radius around the core that [`Self::core_support`] describes (m).
    pub fn rounding(&self) -> f32 {
        match self {
            Self::Ball { radius } | Self::Capsule { radius, .. } => *radius,
            _ => 0.0,
        }
    }

    /// The point of the part, less its rounding, that is furthest along `direction`. A half-space has no such point.
    pub fn core_support(&self, direction: Vec3) -> Vec3 {
        let rim = |radius: f32, y: f32| {
            let across = Vec3::new(direction.x, 0.0, direction.z).normalize_or_zero();
            Vec3::new(across.x * radius, y, across.z * radius)
        };
        match self {
            Self::Ball { .. } | Self::HalfSpace { .. } => Vec3::ZERO,
            Self::Box { half_extents } => half_extents.copysign(direction),
            Self::Capsule { half_height, .. } => Vec3::new(0.0, half_height.copysign(direction.y), 0.0),
            Self::Cylinder { half_height, radius } => rim(*radius, half_height.copysign(direction.y)),
            Self::Cone { half_height, radius } => {
                let (base, tip) = (rim(*radius, -half_height), Vec3::new(0.0, *half_height, 0.0));
                if base.dot(direction) > tip.dot(direction) { base } else { tip }
            }
            Self::Hull(hull) => hull.local_support_point(direction),
            Self::Triangle { triangle, .. } => triangle.local_support_point(direction),
        }
    }

    /// A box in the frame of `pose` that holds the part placed there.
    pub fn bounds(&self, pose: &Pose3) -> Aabb {
        match self {
            Self::Triangle { triangle, .. } => {
                let corners = triangle.vertices().map(|p| *pose * p);
                Aabb::new(corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]))
            }
            _ => Aabb::new(pose.translation - Vec3::splat(self.reach()), pose.translation + Vec3::splat(self.reach())),
        }
    }
}
