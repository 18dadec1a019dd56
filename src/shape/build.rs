//! Checks a geometry, and builds what collision needs from it.

use glam::Vec3;
use parry3d::shape::SharedShape;
use parry3d::utils::Array2;

use super::geometry::{EXTENT_RANGE, Geometry, LocalPose, MAX_HULL_POINTS, MIN_HULL_ASPECT};
use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::hull::Hull;
use crate::hull::weight::weigh;
use crate::mass::{self, MassProperties};

/// What collision needs of a geometry, or what is wrong with it.
pub(super) fn build(geometry: &Geometry) -> Result<SharedShape> {
    Ok(match geometry {
        Geometry::Ball { radius } => SharedShape::ball(extent("radius", *radius)?),
        Geometry::Box { half_extents } => SharedShape::cuboid(
            extent("half_extents.x", half_extents.x)?,
            extent("half_extents.y", half_extents.y)?,
            extent("half_extents.z", half_extents.z)?,
        ),
        Geometry::Capsule { half_height, radius } => {
            SharedShape::capsule_y(extent("half_height", *half_height)?, extent("radius", *radius)?)
        }
        Geometry::Cylinder { half_height, radius } => {
            SharedShape::cylinder(extent("half_height", *half_height)?, extent("radius", *radius)?)
        }
        Geometry::Cone { half_height, radius } => {
            SharedShape::cone(extent("half_height", *half_height)?, extent("radius", *radius)?)
        }
        Geometry::ConvexHull { points } => convex_hull(points)?,
        Geometry::TriangleMesh { vertices, triangles } => triangle_mesh(vertices, triangles)?,
        Geometry::HeightField { rows, columns, heights, size_x, size_z } => {
            height_field(*rows, *columns, heights, *size_x, *size_z)?
        }
        Geometry::HalfSpace { normal } => SharedShape::halfspace(check::direction("normal", *normal)?),
        Geometry::Compound { parts } => compound(parts)?,
    })
}

/// Which triangles of the host a mesh still has: parry3d leaves out those with two corners in one place.
pub(super) fn host_triangles(geometry: &Geometry, parry: &dyn parry3d::shape::Shape) -> Vec<u32> {
    let (Geometry::TriangleMesh { vertices, triangles }, Some(mesh)) = (geometry, parry.as_trimesh()) else {
        return Vec::new();
    };
    if mesh.indices().len() == triangles.len() {
        return Vec::new();
    }
    let mut kept = (0..).zip(triangles).filter(|(_, triangle)| {
        let [a, b, c] = triangle.map(|index| vertices[index as usize]);
        a != b && b != c && c != a
    });
    mesh.indices().iter().filter_map(|_| Some(kept.next()?.0)).collect()
}

/// Mass properties at a density of 1 kg/m³: of a hull, those of exactly the surface that was given; none without volume.
pub(super) fn unit_mass(geometry: &Geometry, parry: &dyn parry3d::shape::Shape) -> Option<MassProperties> {
    match geometry {
        Geometry::ConvexHull { .. } => Some(MassProperties::from_weight(&weigh(parry.as_shape::<Hull>()?.surface()))),
        Geometry::Compound { parts } => {
            let built = parry.as_compound()?.shapes();
            let weighed = parts.iter().zip(built);
            let weighed = weighed.filter_map(|((pose, part), (_, built))| Some(unit_mass(part, &**built)?.placed(*pose)));
            mass::combined(&weighed.collect::<Vec<_>>())
        }
        _ if geometry.is_solid() => Some(MassProperties::from_parry(&parry.mass_properties(1.0))),
        _ => None,
    }
}

fn extent(argument: &'static str, value: f32) -> Result<f32> {
    if check::positive(argument, value)? < EXTENT_RANGE.0 {
        return Err(Error::new(ErrorKind::Degenerate, argument, "is smaller than 1e-5 m"));
    }
    if value > EXTENT_RANGE.1 {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "is greater than 1e6 m"));
    }
    Ok(value)
}

fn points_in_range(argument: &'static str, points: &[Vec3]) -> Result<()> {
    for &point in points {
        if check::finite_vec(argument, point)?.abs().max_element() > EXTENT_RANGE.1 {
            return Err(Error::new(ErrorKind::OutOfRange, argument, "holds a coordinate beyond 1e6 m"));
        }
    }
    Ok(())
}

fn convex_hull(points: &[Vec3]) -> Result<SharedShape> {
    points_in_range("points", points)?;
    if points.len() < 4 {
        return Err(Error::new(ErrorKind::Degenerate, "points", "a hull needs at least four points"));
    }
    if points.len() > MAX_HULL_POINTS {
        return Err(Error::new(ErrorKind::OutOfRange, "points", "a hull takes at most 4096 points"));
    }
    spans_a_volume(points)?;
    let degenerate = Error::new(ErrorKind::Degenerate, "points", "do not span a convex solid");
    Ok(SharedShape::new(Hull::new(points).ok_or(degenerate)?))
}

/// Refuses points on one point, line or plane: the spread along the third direction is compared with the first.
fn spans_a_volume(points: &[Vec3]) -> Result<()> {
    let refuse = |problem| Err(Error::new(ErrorKind::Degenerate, "points", problem));
    let origin = points[0];
    let farthest = |measure: &dyn Fn(Vec3) -> f32| {
        points.iter().map(|&p| p - origin).max_by(|a, b| measure(*a).total_cmp(&measure(*b))).unwrap_or(Vec3::ZERO)
    };
    let along = farthest(&|d| d.length_squared());
    let length = along.length();
    if length < EXTENT_RANGE.0 {
        return refuse("all points coincide");
    }
    let axis = along / length;
    let across = farthest(&|d| d.reject_from_normalized(axis).length_squared()).reject_from_normalized(axis);
    if across.length() < MIN_HULL_ASPECT * length {
        return refuse("all points lie on one line");
    }
    let normal = axis.cross(across.normalize());
    if farthest(&|d| d.dot(normal).abs()).dot(normal).abs() < MIN_HULL_ASPECT * length {
        return refuse("all points lie in one plane");
    }
    Ok(())
}

fn triangle_mesh(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<SharedShape> {
    points_in_range("vertices", vertices)?;
    if triangles.is_empty() {
        return Err(Error::new(ErrorKind::Degenerate, "triangles", "a mesh needs at least one triangle"));
    }
    if triangles.iter().flatten().any(|&index| index as usize >= vertices.len()) {
        return Err(Error::new(ErrorKind::IndexOutOfRange, "triangles", "an index points past the last vertex"));
    }
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|index| vertices[index as usize]);
        (b - a).cross(c - a).length()
    };
    if triangles.iter().all(|t| area(t) <= EXTENT_RANGE.0 * EXTENT_RANGE.0) {
        return Err(Error::new(ErrorKind::Degenerate, "triangles", "no triangle has an area"));
    }
    let flags = parry3d::shape::TriMeshFlags::FIX_INTERNAL_EDGES | parry3d::shape::TriMeshFlags::DELETE_DEGENERATE_TRIANGLES;
    SharedShape::trimesh_with_flags(vertices.to_vec(), triangles.to_vec(), flags)
        .map_err(|_| Error::new(ErrorKind::Degenerate, "triangles", "do not form a mesh"))
}

fn height_field(rows: usize, columns: usize, heights: &[f32], size_x: f32, size_z: f32) -> Result<SharedShape> {
    extent("size_x", size_x)?;
    extent("size_z", size_z)?;
    if rows < 2 || columns < 2 {
        return Err(Error::new(ErrorKind::Degenerate, "rows", "a height field needs at least two rows and two columns"));
    }
    if rows.checked_mul(columns) != Some(heights.len()) {
        return Err(Error::new(ErrorKind::IndexOutOfRange, "heights", "must hold rows × columns values"));
    }
    for &height in heights {
        if check::finite("heights", height)?.abs() > EXTENT_RANGE.1 {
            return Err(Error::new(ErrorKind::OutOfRange, "heights", "holds a height beyond 1e6 m"));
        }
    }
    // parry stores the grid column by column.
    let column_major = (0..rows * columns).map(|i| heights[(i % rows) * columns + i / rows]).collect();
    let flags = parry3d::shape::HeightFieldFlags::FIX_INTERNAL_EDGES;
    Ok(SharedShape::heightfield_with_flags(Array2::new(rows, columns, column_major), Vec3::new(size_x, 1.0, size_z), flags))
}

fn compound(parts: &[(LocalPose, Geometry)]) -> Result<SharedShape> {
    if parts.is_empty() {
        return Err(Error::new(ErrorKind::Degenerate, "parts", "a compound needs at least one part"));
    }
    let mut built = Vec::with_capacity(parts.len());
    for (number, (pose, geometry)) in parts.iter().enumerate() {
        if !geometry.is_solid() || matches!(geometry, Geometry::Compound { .. }) {
            return Err(Error::new(ErrorKind::NotApplicable, "parts", "every part of a compound must be convex"));
        }
        let pose = pose.checked().map_err(|error| error.in_part(number))?;
        built.push((pose.to_parry(), build(geometry).map_err(|error| error.in_part(number))?));
    }
    Ok(SharedShape::compound(built))
}
