//! A convex solid as polygons, and the clipping of it by planes, in `f64`.

use glam::DVec3;

use crate::error::{Error, ErrorKind, Result};
use crate::shape::{Geometry, Shape};

/// Distance below which two points are one, and below which a point lies on a plane, over the extent of the solid.
const SAME_POINT: f64 = 1.0e-9;

/// Distance below which two corners of a shape are one, over the extent of the solid: what single precision can tell apart.
const SAME_CORNER: f64 = 1.0e-7;

/// A convex polygon, counter-clockwise seen from outside, and the seed whose plane cut it.
#[derive(Debug, Clone)]
pub(super) struct CellFace {
    points: Vec<DVec3>,
    pub other: Option<usize>,
}

/// A convex solid.
#[derive(Debug, Clone)]
pub(super) struct Polyhedron {
    pub faces: Vec<CellFace>,
    /// Greatest extent along an axis of the solid that it was cut from (m).
    pub size: f64,
}

impl Polyhedron {
    pub(super) fn of(geometry: &Geometry) -> Result<Self> {
        let shape = Shape::new(geometry.clone())?;
        let faces = match geometry {
            Geometry::Box { half_extents } => box_faces(half_extents.as_dvec3()),
            Geometry::ConvexHull { .. } => hull_faces(&shape),
            _ => return Err(Error::new(ErrorKind::NotApplicable, "geometry", "is neither a box nor a convex hull")),
        };
        let points = || faces.iter().flatten().copied();
        let extent = points().reduce(DVec3::max).unwrap_or_default() - points().reduce(DVec3::min).unwrap_or_default();
        let faces = faces.into_iter().map(|points| CellFace { points, other: None }).collect();
        Ok(Self { faces, size: extent.max_element() })
    }

    /// What of the solid is closer to this seed than to any other; `None` if nothing is.
    pub(super) fn cell(&self, number: usize, seeds: &[DVec3]) -> Result<Option<Self>> {
        let seed = seeds[number];
        let mut others: Vec<(f64, usize)> =
            (0..seeds.len()).filter(|&other| other != number).map(|other| (seeds[other].distance_squared(seed), other)).collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut cell = self.clone();
        for (distance_squared, other) in others {
            if distance_squared <= (SAME_POINT * self.size).powi(2) {
                return Err(Error::new(ErrorKind::Degenerate, "seeds", "has the same point twice"));
            }
            let points = cell.faces.iter().flat_map(|face| &face.points);
            let reach = points.map(|point| point.distance_squared(seed)).fold(0.0, f64::max);
            if distance_squared > 4.0 * reach {
                break;
            }
            cell.clip(0.5 * (seed + seeds[other]), (seeds[other] - seed).normalize(), other);
            if cell.faces.len() < 4 {
                return Ok(None);
            }
        }
        Ok(Some(cell))
    }

    /// Keeps what lies behind a plane, and closes it with a face of its own.
    fn clip(&mut self, on_plane: DVec3, normal: DVec3, other: usize) {
        let tolerance = SAME_POINT * self.size;
        let height = |point: DVec3| (point - on_plane).dot(normal);
        let mut rim: Vec<DVec3> = Vec::new();
        let mut was_cut = false;
        self.faces.retain_mut(|face| {
            let heights: Vec<f64> = face.points.iter().map(|&point| height(point)).collect();
            was_cut |= heights.iter().any(|&height| height > tolerance);
            let mut kept = Vec::with_capacity(face.points.len() + 1);
            for (i, (&point, &at)) in face.points.iter().zip(&heights).enumerate() {
                let next = (i + 1) % face.points.len();
                if at <= tolerance {
                    kept.push(point);
                }
                if at.abs() <= tolerance {
                    rim.push(point);
                } else if (at < -tolerance && heights[next] > tolerance) || (at > tolerance && heights[next] < -tolerance) {
                    // From the point behind the plane, so that both faces at an edge find the same point.
                    let (from, to, a, b) = if at < 0.0 {
                        (point, face.points[next], at, heights[next])
                    } else {
                        (face.points[next], point, heights[next], at)
                    };
                    let crossing = from + (to - from) * (a / (a - b));
                    kept.push(crossing);
                    rim.push(crossing);
                }
            }
            face.points = kept;
            // A face that only touches the plane is an edge, or a corner, of what is left.
            face.points.len() >= 3 && heights.iter().any(|&height| height < -tolerance)
        });
        if !was_cut {
            return;
        }
        let points = ring(rim, normal, tolerance);
        if points.len() >= 3 {
            self.faces.push(CellFace { points, other: Some(other) });
        }
    }

    /// Every corner once.
    pub(super) fn corners(&self) -> Vec<DVec3> {
        let mut corners: Vec<DVec3> = Vec::new();
        for &point in self.faces.iter().flat_map(|face| &face.points) {
            if corners.iter().all(|corner| corner.distance_squared(point) > (SAME_CORNER * self.size).powi(2)) {
                corners.push(point);
            }
        }
        corners
    }

    pub(super) fn volume_and_center(&self) -> (f64, DVec3) {
        let apex = self.faces[0].points[0];
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for [a, b, c] in self.faces.iter().flat_map(CellFace::triangles) {
            let own = (a - apex).dot((b - apex).cross(c - apex)) / 6.0;
            volume += own;
            moment += own * 0.25 * (a + b + c - 3.0 * apex);
        }
        (volume, apex + moment / volume)
    }

    pub(super) fn contains(&self, point: DVec3) -> bool {
        self.faces.iter().all(|face| (point - face.points[0]).dot(face.normal()) <= 0.0)
    }
}

impl CellFace {
    fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.points[1..].windows(2).map(|edge| [self.points[0], edge[0], edge[1]])
    }

    fn normal(&self) -> DVec3 {
        self.triangles().map(|[a, b, c]| (b - a).cross(c - a)).sum::<DVec3>().normalize()
    }

    pub(super) fn area_and_center(&self) -> (f64, DVec3) {
        let (mut area, mut moment) = (0.0, DVec3::ZERO);
        for [a, b, c] in self.triangles() {
            let own = 0.5 * (b - a).cross(c - a).length();
            area += own;
            moment += own * (a + b + c) / 3.0;
        }
        (area, if area > 0.0 { moment / area } else { self.points[0] })
    }
}

/// The corners of a convex polygon among these points of a plane, counter-clockwise about `normal`, each once.
fn ring(points: Vec<DVec3>, normal: DVec3, tolerance: f64) -> Vec<DVec3> {
    let mut unique: Vec<DVec3> = Vec::new();
    for point in points {
        if unique.iter().all(|other| other.distance_squared(point) > 4.0 * tolerance * tolerance) {
            unique.push(point);
        }
    }
    if unique.len() < 3 {
        return unique;
    }
    let middle = unique.iter().sum::<DVec3>() / unique.len() as f64;
    let (u, v) = normal.any_orthonormal_pair();
    // (u, v, normal) is right-handed or not, as glam has it.
    let v = if u.cross(v).dot(normal) > 0.0 { v } else { -v };
    let angle = |point: &DVec3| libm::atan2((*point - middle).dot(v), (*point - middle).dot(u));
    unique.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    unique
}

fn box_faces(half: DVec3) -> Vec<Vec<DVec3>> {
    let mut faces = Vec::new();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            // Around the outward axis: (y, z) about x, (z, x) about y, (x, y) about z.
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[p, q]: [f64; 2]| {
                let mut corner = DVec3::ZERO;
                corner[axis] = sign;
                corner[(axis + 1) % 3] = p;
                corner[(axis + 2) % 3] = q;
                corner * half
            });
            faces.push(if sign > 0.0 { corners.to_vec() } else { corners.iter().rev().copied().collect() });
        }
    }
    faces
}

/// The triangles of a hull: exactly its surface, so that nothing is lost.
fn hull_faces(shape: &Shape) -> Vec<Vec<DVec3>> {
    let Some(hull) = shape.hull() else { return Vec::new() };
    let corner = |index: u32| hull.points()[index as usize].as_dvec3();
    hull.triangles().iter().map(|triangle| triangle.map(corner).to_vec()).collect()
}
