//! Outlines and surfaces of forms, in their own frames.

use glam::Vec3;
use parry3d::shape::{SharedShape, TypedShape};

use crate::hull::Hull;

/// Lines of a whole circle.
const CIRCLE: u32 = 24;

/// Extent of the part that is drawn of a half-space, and lines across it.
const PLANE_EXTENT: f32 = 20.0;
const PLANE_LINES: i32 = 10;

/// Calls `line` for each line of a form's outline (m).
pub(crate) fn outline(form: &SharedShape, line: &mut dyn FnMut(Vec3, Vec3)) {
    match form.as_typed_shape() {
        TypedShape::Ball(ball) => {
            for normal in Vec3::AXES {
                arc(Vec3::ZERO, normal, ball.radius, (0.0, std::f32::consts::TAU), line);
            }
        }
        TypedShape::Cuboid(cuboid) => box_edges(-cuboid.half_extents, cuboid.half_extents, line),
        TypedShape::Capsule(capsule) => {
            let (a, b, radius) = (capsule.segment.a, capsule.segment.b, capsule.radius);
            let axis = (b - a).normalize_or(Vec3::Y);
            let (u, v) = axis.any_orthonormal_pair();
            for end in [a, b] {
                arc(end, axis, radius, (0.0, std::f32::consts::TAU), line);
            }
            for side in [u, -u, v, -v] {
                line(a + side * radius, b + side * radius);
            }
            for side in [u, v] {
                arc_from(a, (side, -axis), radius, (0.0, std::f32::consts::PI), line);
                arc_from(b, (side, axis), radius, (0.0, std::f32::consts::PI), line);
            }
        }
        TypedShape::Cylinder(cylinder) => {
            let (top, radius) = (Vec3::Y * cylinder.half_height, cylinder.radius);
            for end in [top, -top] {
                arc(end, Vec3::Y, radius, (0.0, std::f32::consts::TAU), line);
            }
            for side in [Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z] {
                line(-top + side * radius, top + side * radius);
            }
        }
        TypedShape::Cone(cone) => {
            let (top, radius) = (Vec3::Y * cone.half_height, cone.radius);
            arc(-top, Vec3::Y, radius, (0.0, std::f32::consts::TAU), line);
            for side in [Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z] {
                line(-top + side * radius, top);
            }
        }
        TypedShape::TriMesh(mesh) => mesh_edges(mesh.vertices(), mesh.indices(), line),
        TypedShape::HeightField(field) => {
            let (points, triangles) = field.to_trimesh();
            mesh_edges(&points, &triangles, line);
        }
        TypedShape::HalfSpace(plane) => {
            let (u, v) = plane.normal.any_orthonormal_pair();
            for i in -PLANE_LINES..=PLANE_LINES {
                let offset = i as f32 / PLANE_LINES as f32 * PLANE_EXTENT;
                line(u * offset - v * PLANE_EXTENT, u * offset + v * PLANE_EXTENT);
                line(v * offset - u * PLANE_EXTENT, v * offset + u * PLANE_EXTENT);
            }
        }
        TypedShape::Compound(compound) => {
            for (pose, part) in compound.shapes() {
                outline(part, &mut |from, to| {
                    line(pose.rotation * from + pose.translation, pose.rotation * to + pose.translation);
                });
            }
        }
        TypedShape::Custom(custom) => {
            if let Some(hull) = custom.as_shape::<Hull>() {
                hull_edges(hull, line);
            }
        }
        _ => {}
    }
}

/// Calls `triangle` for each triangle of a form's surface (m).
pub(crate) fn surface(form: &SharedShape, triangle: &mut dyn FnMut([Vec3; 3])) {
    let mut all = |(points, indices): (Vec<Vec3>, Vec<[u32; 3]>)| {
        indices.iter().for_each(|corners| triangle(corners.map(|i| points[i as usize])));
    };
    match form.as_typed_shape() {
        TypedShape::Ball(ball) => all(ball.to_trimesh(CIRCLE / 2, CIRCLE / 2)),
        TypedShape::Cuboid(cuboid) => all(cuboid.to_trimesh()),
        TypedShape::Capsule(capsule) => all(capsule.to_trimesh(CIRCLE / 2, CIRCLE / 4)),
        TypedShape::Cylinder(cylinder) => all(cylinder.to_trimesh(CIRCLE)),
        TypedShape::Cone(cone) => all(cone.to_trimesh(CIRCLE)),
        TypedShape::Custom(custom) => {
            if let Some(hull) = custom.as_shape::<Hull>() {
                hull.triangles().iter().for_each(|corners| triangle(corners.map(|i| hull.points()[i as usize])));
            }
        }
        TypedShape::TriMesh(mesh) => {
            mesh.indices().iter().for_each(|corners| triangle(corners.map(|i| mesh.vertices()[i as usize])));
        }
        TypedShape::HeightField(field) => all(field.to_trimesh()),
        TypedShape::HalfSpace(plane) => {
            let (u, v) = plane.normal.any_orthonormal_pair();
            let corner = |x: f32, y: f32| (u * x + v * y) * PLANE_EXTENT;
            triangle([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)]);
            triangle([corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        }
        TypedShape::Compound(compound) => {
            for (pose, part) in compound.shapes() {
                surface(part, &mut |corners| triangle(corners.map(|point| pose.rotation * point + pose.translation)));
            }
        }
        _ => {}
    }
}

/// Lines of an arc about `normal` (rad), beginning at the first of the two directions that are across it.
pub(crate) fn arc(center: Vec3, normal: Vec3, radius: f32, (from, to): (f32, f32), line: &mut dyn FnMut(Vec3, Vec3)) {
    let (u, v) = normal.any_orthonormal_pair();
    arc_from(center, (u, v), radius, (from, to), line);
}

/// Lines of an arc in the plane of `u` and `v`, by the angle from `u` towards `v` (rad).
pub(crate) fn arc_from(
    center: Vec3,
    (u, v): (Vec3, Vec3),
    radius: f32,
    (from, to): (f32, f32),
    line: &mut dyn FnMut(Vec3, Vec3),
) {
    let count = ((to - from).abs() / std::f32::consts::TAU * CIRCLE as f32).ceil().max(1.0);
    let point = |i: f32| {
        let (sin, cos) = libm::sincosf(from + (to - from) * i / count);
        center + (u * cos + v * sin) * radius
    };
    (0..count as u32).for_each(|i| line(point(i as f32), point(i as f32 + 1.0)));
}

/// The twelve edges of a box.
pub(crate) fn box_edges(min: Vec3, max: Vec3, line: &mut dyn FnMut(Vec3, Vec3)) {
    let corner = |bits: usize| Vec3::from_array(std::array::from_fn(|k| if bits >> k & 1 == 1 { max[k] } else { min[k] }));
    for axis in 0..3 {
        for from in (0..8).filter(|bits| bits >> axis & 1 == 0) {
            line(corner(from), corner(from | 1 << axis));
        }
    }
}

/// Every edge of the flat faces once: two of them share it.
fn hull_edges(hull: &Hull, line: &mut dyn FnMut(Vec3, Vec3)) {
    let sides = hull.faces().iter().flat_map(|face| {
        let corners = hull.corners(face);
        corners.iter().zip(corners.iter().cycle().skip(1)).map(|(&a, &b)| (a.min(b), a.max(b)))
    });
    let mut edges: Vec<(u32, u32)> = sides.collect();
    edges.sort_unstable();
    edges.dedup();
    edges.iter().for_each(|&(a, b)| line(hull.points()[a as usize], hull.points()[b as usize]));
}

/// Every edge of a mesh once: inner ones belong to two triangles.
fn mesh_edges(points: &[Vec3], triangles: &[[u32; 3]], line: &mut dyn FnMut(Vec3, Vec3)) {
    let sides = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let mut edges: Vec<(u32, u32)> = sides.map(|(a, b)| (a.min(b), a.max(b))).collect();
    edges.sort_unstable();
    edges.dedup();
    edges.iter().for_each(|&(a, b)| line(points[a as usize], points[b as usize]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Geometry, LocalPose, Shape};

    /// What is drawn of a form: number of lines, and greatest distance of any of their ends, or of a corner, from its box.
    fn drawn(geometry: Geometry) -> (usize, usize, f32) {
        let shape = Shape::new(geometry).expect("a form");
        let own_box = shape.parry().compute_local_aabb();
        let (mut lines, mut triangles, mut reach) = (0, 0, 0.0_f32);
        let beyond = |p: Vec3| (own_box.mins - p).max(p - own_box.maxs).max_element();
        outline(shape.parry(), &mut |from, to| {
            lines += 1;
            reach = reach.max(beyond(from)).max(beyond(to));
        });
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        surface(shape.parry(), &mut |corners| {
            triangles += 1;
            corners.iter().for_each(|&point| (min, max) = (min.min(point), max.max(point)));
        });
        let misfit = (own_box.mins - min).abs().max((own_box.maxs - max).abs()).max_element();
        (lines, triangles, reach.max(misfit))
    }

    #[test]
    fn outlines_and_surfaces_fill_the_box_of_their_form() {
        let forms = [
            (Geometry::Box { half_extents: Vec3::new(0.1, 0.2, 0.3) }, 12, 12),
            (Geometry::Ball { radius: 0.5 }, 72, 100),
            (Geometry::Capsule { half_height: 0.5, radius: 0.2 }, 100, 100),
            (Geometry::Cylinder { half_height: 0.5, radius: 0.2 }, 52, 80),
            (Geometry::Cone { half_height: 0.5, radius: 0.2 }, 28, 40),
            (Geometry::ConvexHull { points: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z] }, 6, 4),
            (
                Geometry::TriangleMesh {
                    vertices: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0), Vec3::Z],
                    triangles: vec![[0, 2, 1], [0, 3, 2]],
                },
                5,
                2,
            ),
            (
                Geometry::HeightField {
                    rows: 3,
                    columns: 3,
                    heights: vec![0.0, 0.1, 0.2, 0.0, 0.3, 0.0, 0.1, 0.0, 0.0],
                    size_x: 2.0,
                    size_z: 3.0,
                },
                16,
                8,
            ),
            (
                Geometry::Compound {
                    parts: vec![
                        (LocalPose::at(Vec3::X), Geometry::Box { half_extents: Vec3::ONE }),
                        (LocalPose::at(-Vec3::X), Geometry::Box { half_extents: Vec3::ONE }),
                    ],
                },
                24,
                24,
            ),
        ];
        for (geometry, least_lines, least_triangles) in forms {
            let name = format!("{geometry:?}");
            let (lines, triangles, reach) = drawn(geometry);
            assert!(lines >= least_lines && triangles >= least_triangles, "{name}: {lines} lines, {triangles} triangles");
            assert!(reach < 0.02, "{name}: drawn {reach} m off its box");
        }
    }
}
