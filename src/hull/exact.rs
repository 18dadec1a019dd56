//! Convex hull of points, with exact predicates (quickhull: Barber, Dobkin and Huhdanpaa 1996).
//!
//! Points are snapped to a grid of 2³⁸ steps over their extent, finer than single precision. On it the volume that decides
//! whether a point lies above a plane is an integer of at most 122 bits, so its sign is exact: a floating-point value decides
//! where it is larger than its error, `i128` elsewhere. A point in the plane of a face is not above it. So no triangle of the
//! hull is ever degenerate, however thin, round or finely divided the hull is.

use glam::{DVec3, Vec3};

/// Steps of the grid over the extent of the points.
const GRID: f64 = (1_u64 << 38) as f64;

/// Relative error of the sum of six products of three differences, with room to spare.
const DETERMINANT_ERROR: f64 = 16.0 * f64::EPSILON;

/// No face, or no point.
const NONE: u32 = u32::MAX;

/// A triangle of the hull while it is built.
struct HullTriangle {
    /// Corners, counter-clockwise seen from outside.
    corners: [u32; 3],
    /// Face across the edge from each corner to the next.
    across: [u32; 3],
    /// Points above this face that no other face has taken.
    above: Vec<u32>,
    /// The face was seen by a point that the hull has taken in.
    removed: bool,
}

/// An edge between a face that a point sees and one that it does not.
struct Rim {
    from: u32,
    to: u32,
    /// The face that the point does not see.
    beyond: u32,
}

struct Builder {
    points: Vec<DVec3>,
    faces: Vec<HullTriangle>,
    /// Faces that may have points above them.
    open: Vec<u32>,
    /// New face that begins at a point of the rim.
    starts_at: Vec<u32>,
}

/// Triangles of the convex hull as indices of `points`, counter-clockwise seen from outside; none if all lie in one plane.
pub(super) fn triangles(points: &[Vec3]) -> Option<Vec<[u32; 3]>> {
    let points: Vec<DVec3> = points.iter().map(|point| point.as_dvec3()).collect();
    let low = points.iter().copied().reduce(DVec3::min)?;
    let extent = (points.iter().copied().reduce(DVec3::max)? - low).max_element();
    if extent <= 0.0 {
        return None;
    }
    let points = points.iter().map(|&point| ((point - low) * (GRID / extent)).round()).collect();
    let mut builder = Builder { points, faces: Vec::new(), open: Vec::new(), starts_at: Vec::new() };
    builder.starts_at.resize(builder.points.len(), NONE);
    builder.begin()?;
    while let Some(face) = builder.open.pop() {
        builder.extend(face);
    }
    Some(builder.faces.iter().filter(|face| !face.removed).map(|face| face.corners).collect())
}

impl Builder {
    /// Makes a tetrahedron of four points far from each other; none if all points lie in one plane.
    fn begin(&mut self) -> Option<()> {
        let count = self.points.len() as u32;
        let farthest =
            |measure: &dyn Fn(DVec3) -> f64| (0..count).max_by(|&a, &b| measure(self.at(a)).total_cmp(&measure(self.at(b))));
        let first = farthest(&|p| -p.x)?;
        let a = self.at(first);
        let second = farthest(&|p| p.distance_squared(a))?;
        let b = self.at(second);
        let third = farthest(&|p| (p - a).cross(b - a).length_squared())?;
        let fourth = farthest(&|p| (b - a).cross(self.at(third) - a).dot(p - a).abs())?;
        let side = self.height(&[first, second, third], fourth);
        if side == 0.0 {
            return None;
        }
        let [second, third] = if side > 0.0 { [third, second] } else { [second, third] };
        // The fourth point is below the first face.
        let corners = [[first, second, third], [first, fourth, second], [second, fourth, third], [third, fourth, first]];
        let across = [[1, 2, 3], [3, 2, 0], [1, 3, 0], [2, 1, 0]];
        for (corners, across) in corners.into_iter().zip(across) {
            self.faces.push(HullTriangle { corners, across, above: Vec::new(), removed: false });
        }
        self.hand_out((0..count).collect(), 0);
        self.open.extend(0..4);
        Some(())
    }

    fn at(&self, point: u32) -> DVec3 {
        self.points[point as usize]
    }

    /// Six times the signed volume between a triangle and a point, positive above it. The sign is exact.
    fn height(&self, &[a, b, c]: &[u32; 3], point: u32) -> f64 {
        let a = self.at(a);
        let (u, v, w) = (self.at(b) - a, self.at(c) - a, self.at(point) - a);
        let (p, q, r) = ((u.y * v.z, u.z * v.y), (u.z * v.x, u.x * v.z), (u.x * v.y, u.y * v.x));
        let value = (p.0 - p.1) * w.x + (q.0 - q.1) * w.y + (r.0 - r.1) * w.z;
        let size =
            (p.0.abs() + p.1.abs()) * w.x.abs() + (q.0.abs() + q.1.abs()) * w.y.abs() + (r.0.abs() + r.1.abs()) * w.z.abs();
        if value.abs() > DETERMINANT_ERROR * size {
            return value;
        }
        // Differences of grid points have at most 39 bits, so the sum has at most 122.
        let exact = |d: DVec3| [d.x as i128, d.y as i128, d.z as i128];
        let (u, v, w) = (exact(u), exact(v), exact(w));
        let sum = (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] + (u[0] * v[1] - u[1] * v[0]) * w[2];
        sum as f64
    }

    /// Gives each point to the first face, from `first` on, that it is above.
    fn hand_out(&mut self, points: Vec<u32>, first: usize) {
        for point in points {
            let taker = (first..self.faces.len()).find(|&face| self.height(&self.faces[face].corners, point) > 0.0);
            if let Some(face) = taker {
                self.faces[face].above.push(point);
            }
        }
    }

    /// Takes in the highest point above a face.
    fn extend(&mut self, face: u32) {
        if self.faces[face as usize].removed {
            return;
        }
        let corners = self.faces[face as usize].corners;
        let above = &self.faces[face as usize].above;
        let Some(&apex) = above.iter().max_by(|&&a, &&b| self.height(&corners, a).total_cmp(&self.height(&corners, b))) else {
            return;
        };
        let mut points = Vec::new();
        let rim = self.remove_seen(face, apex, &mut points);
        let first = self.faces.len();
        for (number, edge) in (first as u32..).zip(&rim) {
            self.starts_at[edge.from as usize] = number;
            let corners = [edge.from, edge.to, apex];
            self.faces.push(HullTriangle { corners, across: [edge.beyond, NONE, NONE], above: Vec::new(), removed: false });
            let beyond = &mut self.faces[edge.beyond as usize];
            // The face beyond runs along the edge the other way.
            let side = (0..3).find(|&side| beyond.corners[side] == edge.to).unwrap_or(0);
            beyond.across[side] = number;
        }
        for (number, edge) in (first as u32..).zip(&rim) {
            let next = self.starts_at[edge.to as usize];
            self.faces[number as usize].across[1] = next;
            self.faces[next as usize].across[2] = number;
        }
        points.retain(|&point| point != apex);
        self.hand_out(points, first);
        self.open.extend(first as u32..self.faces.len() as u32);
    }

    /// Removes the faces that a point is above, and collects the points above those; returns the edges around them.
    fn remove_seen(&mut self, face: u32, apex: u32, points: &mut Vec<u32>) -> Vec<Rim> {
        let (mut rim, mut stack) = (Vec::new(), vec![face]);
        self.faces[face as usize].removed = true;
        while let Some(face) = stack.pop() {
            let seen = &mut self.faces[face as usize];
            points.append(&mut seen.above);
            let (corners, across) = (seen.corners, seen.across);
            for side in 0..3 {
                let beyond = across[side];
                if self.faces[beyond as usize].removed {
                    continue;
                }
                if self.height(&self.faces[beyond as usize].corners, apex) > 0.0 {
                    self.faces[beyond as usize].removed = true;
                    stack.push(beyond);
                } else {
                    rim.push(Rim { from: corners[side], to: corners[(side + 1) % 3], beyond });
                }
            }
        }
        rim
    }
}
