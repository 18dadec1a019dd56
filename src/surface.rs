//! Triangles of shapes, for drawing.

use glam::Vec3;

use crate::hull::Triangulation;
use crate::shape::Geometry;

impl Geometry {
    /// Vertices (m) and triangles of the surface, counter-clockwise seen from outside, of a hull, a mesh or a height field;
    /// `None` for the other forms, which a few numbers describe.
    pub fn triangles(&self) -> Option<(Vec<Vec3>, Vec<[u32; 3]>)> {
        match self {
            Self::ConvexHull { points } => {
                Some(Triangulation::of(points).map(|hull| (hull.points, hull.triangles)).unwrap_or_default())
            }
            Self::TriangleMesh { vertices, triangles } => Some((vertices.clone(), triangles.clone())),
            Self::HeightField { rows, columns, heights, size_x, size_z } => {
                Some(grid(*rows, *columns, heights, *size_x, *size_z))
            }
            _ => None,
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_height_field_has_two_triangles_a_cell_and_they_look_up() {
        let field = Geometry::HeightField { rows: 3, columns: 4, heights: vec![0.0; 12], size_x: 3.0, size_z: 2.0 };
        let (points, triangles) = field.triangles().expect("a height field has triangles");
        assert_eq!((points.len(), triangles.len()), (12, 12));
        let area = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|index| points[index as usize]);
            0.5 * (b - a).cross(c - a)
        };
        let total: Vec3 = triangles.iter().map(|&corners| area(corners)).sum();
        assert!((total - 6.0 * Vec3::Y).length() < 1e-5, "the areas add up to {total}, expected 6 m² upwards");
    }
}
