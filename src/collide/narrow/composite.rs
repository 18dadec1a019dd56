//! Shapes of several parts: each pair of parts that are near each other is collided as a pair of convex parts.
//!
//! Parts are visited in the order of their ids, so that the result does not depend on how a tree was built.

use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose3;
use parry3d::shape::{HeightField, Triangle, TrianglePseudoNormals};

use super::part::Part;
use super::{Manifold, NarrowScratch, part_pairs};
use crate::shape::{Geometry, Shape};

/// Appends the manifolds of every near pair of parts to `out`.
pub(super) fn collide(a: &Shape, b: &Shape, relative: &Pose3, margin: f32, scratch: &mut NarrowScratch, out: &mut Vec<Manifold>) {
    if !relative.is_finite() {
        return;
    }
    let mut near_a = std::mem::take(&mut scratch.parts_a);
    let mut near_b = std::mem::take(&mut scratch.parts_b);
    let inverse = relative.inverse();
    let parts_of_b = part_count(b);
    near_parts(a, bounds(b, relative, margin).as_ref(), &mut near_a);
    for &id_a in &near_a {
        let Some((part_a, pose_a)) = part_at(a, id_a) else { continue };
        let bounds_in_b = matches!(part_a, Part::HalfSpace { .. }).then_some(None);
        let bounds_in_b = bounds_in_b.unwrap_or_else(|| Some(part_a.bounds(&(inverse * pose_a)).loosened(margin)));
        near_parts(b, bounds_in_b.as_ref(), &mut near_b);
        for &id_b in &near_b {
            let Some((part_b, pose_b)) = part_at(b, id_b) else { continue };
            let between = pose_a.inverse() * *relative * pose_b;
            let before = out.len();
            part_pairs::collide(&part_a, &part_b, &between, margin, scratch, out);
            for manifold in &mut out[before..] {
                manifold.normal = pose_a.rotation * manifold.normal;
                for point in &mut manifold.points[..usize::from(manifold.count)] {
                    point.on_a = pose_a * point.on_a;
                    point.on_b = pose_b * point.on_b;
                }
                manifold.part = id_a.wrapping_mul(parts_of_b).wrapping_add(id_b);
            }
        }
    }
    scratch.parts_a = near_a;
    scratch.parts_b = near_b;
}

/// Box around `shape` placed at `pose`, widened; none for a half-space, which has no bounds.
fn bounds(shape: &Shape, pose: &Pose3, margin: f32) -> Option<Aabb> {
    let bounded = !matches!(shape.geometry(), Geometry::HalfSpace { .. });
    bounded.then(|| shape.parry().compute_aabb(pose).loosened(margin))
}

pub(super) fn part_count(shape: &Shape) -> u32 {
    match shape.geometry() {
        Geometry::Compound { parts } => parts.len() as u32,
        Geometry::TriangleMesh { .. } => shape.parry().as_trimesh().map_or(0, |mesh| mesh.num_triangles() as u32),
        // parry numbers the right-hand triangles of all cells after the left-hand ones.
        Geometry::HeightField { rows, columns, .. } => 2 * ((rows - 1) * (columns - 1)) as u32,
        _ => 1,
    }
}

/// Ids of the parts of `shape` that may meet `bounds`, in order; all of them without bounds.
pub(super) fn near_parts(shape: &Shape, bounds: Option<&Aabb>, ids: &mut Vec<u32>) {
    ids.clear();
    let parry = shape.parry();
    let Some(bounds) = bounds else {
        ids.extend(0..part_count(shape));
        return;
    };
    if let Some(compound) = parry.as_compound() {
        ids.extend(compound.bvh().intersect_aabb(bounds));
    } else if let Some(mesh) = parry.as_trimesh() {
        ids.extend(mesh.bvh().intersect_aabb(bounds));
    } else if let Some(field) = parry.as_heightfield() {
        field.map_elements_in_local_aabb(bounds, &mut |id, _| ids.push(id));
    } else {
        ids.push(0);
    }
    ids.sort_unstable();
}

/// A part of `shape` and its pose in the shape's frame; a triangle is moved so that its centroid is the origin.
pub(super) fn part_at(shape: &Shape, id: u32) -> Option<(Part<'_>, Pose3)> {
    let parry = shape.parry();
    if let Geometry::Compound { parts } = shape.geometry() {
        let (pose, part) = parry.as_compound()?.shapes().get(id as usize)?;
        return Some((Part::of(&parts.get(id as usize)?.1, &**part)?, *pose));
    }
    if let Some(mesh) = parry.as_trimesh() {
        let constraints = mesh.triangle_normal_constraints(id).map(|allowed| without_concave(&mesh.triangle(id), allowed));
        return Some(about_centroid(mesh.triangle(id), |triangle| Part::Triangle { triangle, constraints }));
    }
    if let Some(field) = parry.as_heightfield() {
        let triangle = field.triangle_at_id(id)?;
        let constraints = allowed_normals(field, id).map(|allowed| without_concave(&triangle, allowed));
        return Some(about_centroid(triangle, |triangle| Part::Triangle { triangle, constraints }));
    }
    Some((Part::whole(shape)?, Pose3::IDENTITY))
}

/// Directions in which a triangle of a height field may push.
///
/// parry3d lets the outermost triangles push sideways, as if the field were a slab, and a body that goes from one field onto the next
/// would hit that side. Here edges on the rim push along the normal of their triangle only, as those of an open mesh do.
fn allowed_normals(field: &HeightField, id: u32) -> Option<TrianglePseudoNormals> {
    let mut allowed = field.triangle_normal_constraints(id)?;
    let (rows, columns) = (field.nrows() as u32, field.ncols() as u32);
    let (cell, is_left) = (id % (rows * columns), id < rows * columns);
    let (row, column) = (cell % rows, cell / rows);
    let (is_at_row_rim, is_at_column_rim) =
        if is_left { (row == 0, column == 0) } else { (row + 1 == rows, column + 1 == columns) };
    if is_at_row_rim {
        allowed.edges[usize::from(!is_left)] = allowed.face;
    }
    if is_at_column_rim {
        allowed.edges[2] = allowed.face;
    }
    Some(allowed)
}

fn about_centroid<'a>(triangle: Triangle, part: impl FnOnce(Triangle) -> Part<'a>) -> (Part<'a>, Pose3) {
    let center = triangle.center();
    let [a, b, c] = triangle.vertices().map(|corner| corner - center);
    (part(Triangle::new(a, b, c)), Pose3::from_translation(center))
}

/// The same directions without those across edges at which the surface bends inwards: what comes there rests on the other side.
///
/// parry3d allows all directions around the triangle's normal that are as far off it as the nearest neighbour's, along the edge too: marbles that
/// roll along a groove hit the corners of the facets ahead.
fn without_concave(triangle: &Triangle, mut allowed: TrianglePseudoNormals) -> TrianglePseudoNormals {
    let face = allowed.face;
    let [a, b, c] = triangle.vertices();
    let outward = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).cross(face).normalize_or_zero());
    for edge in &mut allowed.edges {
        let lean = *edge - face * face.dot(*edge);
        // The edge that a normal leans across is the one that it is square to.
        let across = outward
            .map(|out| out.dot(lean))
            .into_iter()
            .fold(0.0_f32, |most, next| if next.abs() > most.abs() { next } else { most });
        if across <= 0.0 {
            *edge = face;
        }
    }
    allowed
}
