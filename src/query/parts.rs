//! The parts of a shape that a path may meet: of a compound, a mesh, a height field.

use glam::{DMat3, DVec3};
use parry3d::partitioning::{Bvh, TraversalAction};

use super::part::{ConvexPart, PartPose};
use super::region::PathSegment;
use crate::hull::Hull;
use crate::shape::{Geometry, Shape};

/// How far beside a cell of a height field a path counts as inside it, in cells: what rounding leaves open is looked at.
const CELL_SLACK: f64 = 1.0e-9;

/// A shape somewhere, in the frame of a query.
#[derive(Clone, Copy)]
pub(super) struct PlacedPart<'a> {
    pub shape: &'a Shape,
    pub place: PartPose,
}

/// Calls `visit` for each part of a shape that a path may meet, with the distance at which it enters the part's box (m); it
/// returns how much of the path is still of interest (m).
pub(super) fn along<'a>(of: PlacedPart<'a>, path: &PathSegment, visit: &mut dyn FnMut(&ConvexPart<'a>, f64) -> f64) {
    let PlacedPart { shape, place } = of;
    let parry = shape.parry();
    match shape.geometry() {
        Geometry::Compound { parts } => {
            let Some(compound) = parry.as_compound() else { return };
            let mut path = in_local(path, &place);
            walk(compound.bvh(), &mut path, &mut |number, entry| {
                let (definition, built) = (&parts[number as usize], &compound.shapes()[number as usize].1);
                let part = ConvexPart::of_compound(definition, built.as_shape::<Hull>(), place, number);
                part.map_or(f64::INFINITY, |part| visit(&part, entry))
            });
        }
        Geometry::TriangleMesh { .. } => {
            let Some(mesh) = parry.as_trimesh() else { return };
            let mut path = in_local(path, &place);
            walk(mesh.bvh(), &mut path, &mut |number, entry| {
                let triangle = mesh.triangle(number);
                let corners = [triangle.a, triangle.b, triangle.c].map(|corner| place.to_frame(corner.as_dvec3()));
                visit(&ConvexPart::triangle(corners, shape.host_triangle(number)), entry)
            });
        }
        Geometry::HeightField { rows, columns, heights, size_x, size_z } => {
            let Some(field) = parry.as_heightfield() else { return };
            let bounds = field.root_aabb();
            let grid = Grid { rows: *rows, columns: *columns, heights, size: (f64::from(*size_x), f64::from(*size_z)) };
            let path = in_local(path, &place);
            let Some(inside) = path.inside(bounds.mins, bounds.maxs) else { return };
            grid.walk(&path, inside, &mut |number, corners, entry| {
                visit(&ConvexPart::triangle(corners.map(|corner| place.to_frame(corner)), number), entry)
            });
        }
        geometry => {
            if let Some(part) = ConvexPart::whole(geometry, shape.hull(), place) {
                visit(&part, 0.0);
            }
        }
    }
}

/// Calls `visit` for each part of a shape that may meet the box from `low` to `high`, in the frame of the query (m); an empty box
/// is the point in its middle.
pub(super) fn near<'a>(of: PlacedPart<'a>, low: DVec3, high: DVec3, visit: &mut dyn FnMut(&ConvexPart<'a>)) {
    let path = PathSegment::still((low + high) * 0.5, ((high - low) * 0.5).max(DVec3::ZERO));
    along(of, &path, &mut |part, _| {
        visit(part);
        f64::INFINITY
    });
}

/// A path in the frame of a shape; its box is the one around the turned box.
fn in_local(path: &PathSegment, place: &PartPose) -> PathSegment {
    let back = place.axes.transpose();
    let widths = DMat3::from_cols(back.x_axis.abs(), back.y_axis.abs(), back.z_axis.abs());
    PathSegment { origin: place.to_local(path.origin), direction: back * path.direction, half: widths * path.half, ..*path }
}

fn walk(tree: &Bvh, path: &mut PathSegment, visit: &mut dyn FnMut(u32, f64) -> f64) {
    tree.traverse(|node| match path.enters(node.mins(), node.maxs()) {
        None => TraversalAction::Prune,
        Some(entry) => {
            if let Some(number) = node.leaf_data() {
                path.length = path.length.min(visit(number, entry));
            }
            TraversalAction::Continue
        }
    });
}

/// A height field: two triangles a cell, cells row by row.
struct Grid<'a> {
    rows: usize,
    columns: usize,
    heights: &'a [f32],
    /// Extents along x and z (m).
    size: (f64, f64),
}

impl Grid<'_> {
    /// Visits the triangles of all cells that a path may meet on a stretch of it, by slices along the axis on which it crosses
    /// most cells: within a slice, the cells beside the path.
    fn walk(&self, path: &PathSegment, (first, last): (f64, f64), visit: &mut dyn FnMut(u32, [DVec3; 3], f64) -> f64) {
        let cells = [self.columns - 1, self.rows - 1];
        let sizes = [self.size.0 / cells[0] as f64, self.size.1 / cells[1] as f64];
        let axes = [0, 2];
        let origin = [0, 1].map(|i| path.origin[axes[i]] / sizes[i] + 0.5 * cells[i] as f64);
        let rate = [0, 1].map(|i| path.direction[axes[i]] / sizes[i]);
        let half = [0, 1].map(|i| path.half[axes[i]] / sizes[i] + CELL_SLACK * (1.0 + origin[i].abs()));
        let range = |i: usize, from: f64, to: f64| {
            let (a, b) = (origin[i] + rate[i] * from, origin[i] + rate[i] * to);
            let bound = |at: f64| at.clamp(0.0, (cells[i] - 1) as f64) as usize;
            (bound((a.min(b) - half[i]).floor()), bound((a.max(b) + half[i]).floor()))
        };
        let main = usize::from(rate[1].abs() > rate[0].abs());
        let (low, high) = range(main, first, last);
        let mut limit = last;
        for step in low..=high {
            let slice = if rate[main] < 0.0 { high - (step - low) } else { step };
            let [near, far] =
                [slice as f64 - half[main], (slice + 1) as f64 + half[main]].map(|at| (at - origin[main]) / rate[main]);
            let crosses = near.is_finite() && far.is_finite();
            let (from, to) = if crosses { (near.min(far).max(first), near.max(far).min(last)) } else { (first, last) };
            if from > limit {
                return;
            }
            if from > to {
                continue;
            }
            let (y_from, y_to) = (path.origin.y + path.direction.y * from, path.origin.y + path.direction.y * to);
            let slack = path.half.y + CELL_SLACK * (1.0 + path.origin.y.abs());
            let (bottom, top) = (y_from.min(y_to) - slack, y_from.max(y_to) + slack);
            let (left, right) = range(1 - main, from, to);
            for beside in left..=right {
                let (row, column) = if main == 0 { (beside, slice) } else { (slice, beside) };
                let corners = self.cell(row, column);
                if corners.iter().all(|corner| corner.y > top) || corners.iter().all(|corner| corner.y < bottom) {
                    continue;
                }
                let number = 2 * (row * (self.columns - 1) + column) as u32;
                let [here, right, below, across] = corners;
                limit = limit.min(visit(number, [here, below, right], from));
                limit = limit.min(visit(number + 1, [right, below, across], from));
            }
        }
    }

    /// Corners of a cell: at its row and column, to the right, below, and across.
    fn cell(&self, row: usize, column: usize) -> [DVec3; 4] {
        [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)].map(|(row, column)| {
            let at = |index: usize, count: usize, size: f64| (index as f64 / (count - 1) as f64 - 0.5) * size;
            DVec3::new(
                at(column, self.columns, self.size.0),
                f64::from(self.heights[row * self.columns + column]),
                at(row, self.rows, self.size.1),
            )
        })
    }
}
