//! Forms as triangles.

use longspan::glam::{DVec3, Vec3};
use longspan::{Geometry, LocalPose, Pose};
use parry3d::math::Vector;
use parry3d::shape::{Ball, Capsule, Cone, Cuboid, Cylinder};

use super::Drawn;

/// Segments around what is round.
const SEGMENTS: u32 = 40;

/// A triangle, relative to the middle of the picture (m).
pub(super) struct Triangle {
    pub points: [Vec3; 3],
    pub normals: [Vec3; 3],
    pub color: Vec3,
}

/// Distance of a form's farthest point from its origin (m).
pub(super) fn reach(geometry: &Geometry) -> f64 {
    match geometry {
        Geometry::Ball { radius } => f64::from(*radius),
        Geometry::Capsule { half_height, radius } => f64::from(half_height + radius),
        Geometry::HalfSpace { .. } => f64::INFINITY,
        other => points_and_triangles(other, SEGMENTS).0.iter().map(|point| f64::from(point.length())).fold(0.0, f64::max),
    }
}

/// Adds the triangles of a body, relative to `center`.
pub(super) fn add_triangles(body: &Drawn, center: DVec3, triangles: &mut Vec<Triangle>) {
    if let Geometry::Compound { parts } = &body.geometry {
        for (LocalPose { position, rotation }, geometry) in parts {
            let pose = body.pose.transform(&Pose { position: position.as_dvec3(), rotation: *rotation });
            add_triangles(&Drawn { geometry: geometry.clone(), pose, color: body.color }, center, triangles);
        }
        return;
    }
    let turn = body.pose.rotation;
    let offset = (body.pose.position - center).as_vec3();
    let (points, indices) = points_and_triangles(&body.geometry, SEGMENTS);
    for corners in indices {
        let local = corners.map(|index| points[index as usize]);
        let flat = (local[1] - local[0]).cross(local[2] - local[0]).normalize_or_zero();
        let normals = local.map(|point| turn * smooth_normal(&body.geometry, point).unwrap_or(flat));
        triangles.push(Triangle { points: local.map(|point| offset + turn * point), normals, color: body.color });
    }
}

/// Normal of a form that is round all over.
fn smooth_normal(geometry: &Geometry, point: Vec3) -> Option<Vec3> {
    match geometry {
        Geometry::Ball { .. } => Some(point.normalize_or_zero()),
        Geometry::Capsule { half_height, .. } => {
            Some((point - Vec3::Y * point.y.clamp(-half_height, *half_height)).normalize_or_zero())
        }
        _ => None,
    }
}

/// Points (m) and triangles of a form, round ones with so many segments around.
pub fn points_and_triangles(geometry: &Geometry, segments: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    match geometry {
        Geometry::Ball { radius } => Ball::new(*radius).to_trimesh(segments, segments / 2),
        Geometry::Box { half_extents } => Cuboid::new(*half_extents).to_trimesh(),
        Geometry::Capsule { half_height, radius } => {
            let ends = [-half_height, *half_height].map(|y| Vector::new(0.0, y, 0.0));
            Capsule::new(ends[0], ends[1], *radius).to_trimesh(segments, segments / 2)
        }
        Geometry::Cylinder { half_height, radius } => Cylinder::new(*half_height, *radius).to_trimesh(segments),
        Geometry::Cone { half_height, radius } => Cone::new(*half_height, *radius).to_trimesh(segments),
        Geometry::Compound { parts } => {
            let place = |(pose, part): &(LocalPose, Geometry)| {
                let points = points_and_triangles(part, segments).0.into_iter();
                points.map(|point| pose.position + pose.rotation * point).collect::<Vec<_>>()
            };
            (parts.iter().flat_map(place).collect(), Vec::new())
        }
        other => other.triangles().unwrap_or_default(),
    }
}
