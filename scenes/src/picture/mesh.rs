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
        other => points_and_triangles(other).0.iter().map(|point| f64::from(point.length())).fold(0.0, f64::max),
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
    let (points, indices) = points_and_triangles(&body.geometry);
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

fn points_and_triangles(geometry: &Geometry) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    match geometry {
        Geometry::Ball { radius } => Ball::new(*radius).to_trimesh(SEGMENTS, SEGMENTS / 2),
        Geometry::Box { half_extents } => Cuboid::new(*half_extents).to_trimesh(),
        Geometry::Capsule { half_height, radius } => {
            let ends = [-half_height, *half_height].map(|y| Vector::new(0.0, y, 0.0));
            Capsule::new(ends[0], ends[1], *radius).to_trimesh(SEGMENTS, SEGMENTS / 2)
        }
        Geometry::Cylinder { half_height, radius } => Cylinder::new(*half_height, *radius).to_trimesh(SEGMENTS),
        Geometry::Cone { half_height, radius } => Cone::new(*half_height, *radius).to_trimesh(SEGMENTS),
        Geometry::ConvexHull { points } => parry3d::transformation::try_convex_hull(points).unwrap_or_default(),
        Geometry::TriangleMesh { vertices, triangles } => (vertices.clone(), triangles.clone()),
        Geometry::HeightField { rows, columns, heights, size_x, size_z } => grid(*rows, *columns, heights, *size_x, *size_z),
        Geometry::Compound { parts } => {
            let place = |(pose, part): &(LocalPose, Geometry)| {
                let points = points_and_triangles(part).0.into_iter();
                points.map(|point| pose.position + pose.rotation * point).collect::<Vec<_>>()
            };
            (parts.iter().flat_map(place).collect(), Vec::new())
        }
        _ => (Vec::new(), Vec::new()),
    }
}

fn grid(rows: usize, columns: usize, heights: &[f32], size_x: f32, size_z: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let along = |index: usize, count: usize, size: f32| (index as f32 / (count - 1) as f32 - 0.5) * size;
    let point = |index: usize| {
        let (row, column) = (index / columns, index % columns);
        Vec3::new(along(column, columns, size_x), heights[index], along(row, rows, size_z))
    };
    let cell = |index: usize| {
        let corner = (index / (columns - 1) * columns + index % (columns - 1)) as u32;
        let below = corner + columns as u32;
        [[corner, below, corner + 1], [corner + 1, below, below + 1]]
    };
    ((0..rows * columns).map(point).collect(), (0..(rows - 1) * (columns - 1)).flat_map(cell).collect())
}
