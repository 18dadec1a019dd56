//! Nearest points of two convex parts (Gilbert, Johnson and Keerthi 1988), in double precision.
//!
//! The points b − a of two parts form a convex body. Its point nearest to the origin, v, leads from A to B. A simplex of its
//! points closes in on v: each step adds the point farthest towards the origin, and drops the corners that v does not need.
//! Where v lies inside a triangle it is taken along the triangle's normal, so that its direction does not suffer from the
//! size of the parts.

use glam::DVec3;

use super::part::ConvexPart;

/// Relative error of the distance at which the search ends.
const RELATIVE: f64 = 1.0e-10;

/// Error of the distance, over the size of what it is a difference of, at which the search ends: rounding.
const ROUNDING: f64 = 4.0e-15;

/// Error of the volume between a triangle and a point, over the product of the three edges: within it the side is unknown.
const SIDE_ERROR: f64 = 4.0 * f64::EPSILON;

/// Steps of the search. Flat forms take a handful, round rims some twenty.
const MAX_STEPS: usize = 128;

/// A point b − a, and the two that it comes from.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SimplexVertex {
    pub offset: DVec3,
    pub on_a: DVec3,
    pub on_b: DVec3,
}

impl SimplexVertex {
    /// The point b − a farthest along a direction.
    pub(super) fn support(a: &ConvexPart, b: &ConvexPart, direction: DVec3) -> Self {
        let (on_a, on_b) = (a.support(-direction), b.support(direction));
        Self { offset: on_b - on_a, on_a, on_b }
    }
}

/// Up to four points, and the shares of them that make the nearest point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Simplex {
    pub corners: [SimplexVertex; 4],
    pub shares: [f64; 4],
    pub count: usize,
}

/// What is known of two parts, without their rounding.
#[allow(clippy::large_enum_variant, reason = "one lives on the stack at a time")]
pub(super) enum Closest {
    /// They are apart by this vector from A to B.
    Apart { offset: DVec3, on_a: DVec3, on_b: DVec3 },
    /// They overlap or touch: the simplex holds the origin.
    Overlap(Simplex),
}

/// Nearest points of two parts; neither is a half-space.
pub(super) fn closest(a: &ConvexPart, b: &ConvexPart) -> Closest {
    let seed = (a.place.origin - b.place.origin).try_normalize().unwrap_or(DVec3::X);
    let mut simplex = Simplex::of(SimplexVertex::support(a, b, seed));
    let mut offset = simplex.corners[0].offset;
    let mut size = extent(&simplex.corners[0]);
    for _ in 0..MAX_STEPS {
        let distance = offset.length();
        if distance <= ROUNDING * size {
            return Closest::Overlap(simplex);
        }
        let next = SimplexVertex::support(a, b, -offset);
        size = size.max(extent(&next));
        let slack = offset.dot(offset - next.offset);
        let is_found = slack <= RELATIVE * distance * distance + ROUNDING * size * distance
            || simplex.corners[..simplex.count].iter().any(|corner| corner.offset == next.offset);
        let mut grown = simplex;
        let mut nearer = offset;
        if !is_found {
            grown.corners[grown.count] = next;
            grown.count += 1;
            let Some(point) = grown.reduce() else { return Closest::Overlap(grown) };
            nearer = point;
        }
        if nearer.length_squared() >= distance * distance {
            break;
        }
        (simplex, offset) = (grown, nearer);
    }
    // If no plane parts them they are as near as rounding can tell, and the offset may lead the wrong way.
    if offset.dot(SimplexVertex::support(a, b, -offset).offset) <= 0.0 {
        return Closest::Overlap(simplex);
    }
    let (on_a, on_b) = simplex.points();
    Closest::Apart { offset, on_a, on_b }
}

fn extent(vertex: &SimplexVertex) -> f64 {
    vertex.on_a.abs().max(vertex.on_b.abs()).max_element()
}

impl Simplex {
    pub(super) fn of(corner: SimplexVertex) -> Self {
        Self {
            corners: [corner, SimplexVertex::default(), SimplexVertex::default(), SimplexVertex::default()],
            shares: [1.0, 0.0, 0.0, 0.0],
            count: 1,
        }
    }

    /// The points on A and B that the nearest point comes from.
    pub(super) fn points(&self) -> (DVec3, DVec3) {
        let of =
            |part: fn(&SimplexVertex) -> DVec3| (0..self.count).map(|i| part(&self.corners[i]) * self.shares[i]).sum::<DVec3>();
        (of(|corner| corner.on_a), of(|corner| corner.on_b))
    }

    fn at(&self, i: usize) -> DVec3 {
        self.corners[i].offset
    }

    /// The point of the simplex nearest to the origin; keeps the corners that it needs. None if the origin is inside.
    fn reduce(&mut self) -> Option<DVec3> {
        let found = match self.count {
            2 => self.on_segment([0, 1]),
            3 => self.on_triangle([0, 1, 2]),
            4 => self.on_tetrahedron()?,
            _ => NearestOnSimplex::corner(self, 0),
        };
        let mut kept = Self::default();
        for (&corner, &share) in found.corners.iter().zip(&found.shares).take(found.count) {
            kept.corners[kept.count] = self.corners[corner];
            kept.shares[kept.count] = share;
            kept.count += 1;
        }
        *self = kept;
        Some(found.point)
    }

    fn on_segment(&self, [a, b]: [usize; 2]) -> NearestOnSimplex {
        let along = self.at(b) - self.at(a);
        let length_squared = along.length_squared();
        let s = if length_squared > 0.0 { -self.at(a).dot(along) / length_squared } else { 0.0 };
        if s <= 0.0 {
            return NearestOnSimplex::corner(self, a);
        }
        if s >= 1.0 {
            return NearestOnSimplex::corner(self, b);
        }
        let point = self.at(a) + along * s;
        NearestOnSimplex { point, corners: [a, b, 0], shares: [1.0 - s, s, 0.0], count: 2 }
    }

    /// The foot of the origin on the plane, if it lies within the triangle; else the nearest point of an edge. The shares are
    /// areas seen from the foot: measured from the origin, those of a needle far away would be noise.
    fn on_triangle(&self, [a, b, c]: [usize; 3]) -> NearestOnSimplex {
        let (p, q, r) = (self.at(a), self.at(b), self.at(c));
        let normal = (q - p).cross(r - p);
        let square = normal.length_squared();
        if square > 0.0 {
            let foot = normal * (normal.dot(p) / square);
            let (p, q, r) = (p - foot, q - foot, r - foot);
            let areas = [q.cross(r), r.cross(p), p.cross(q)].map(|area| area.dot(normal) / square);
            if areas.iter().all(|&area| area > 0.0) {
                return NearestOnSimplex { point: foot, corners: [a, b, c], shares: areas, count: 3 };
            }
        }
        NearestOnSimplex::best([self.on_segment([a, b]), self.on_segment([b, c]), self.on_segment([c, a])])
    }

    /// None if the origin is inside.
    fn on_tetrahedron(&self) -> Option<NearestOnSimplex> {
        let mut best: Option<NearestOnSimplex> = None;
        for (face, opposite) in [([0, 1, 2], 3), ([0, 1, 3], 2), ([0, 2, 3], 1), ([1, 2, 3], 0)] {
            let corner = self.at(face[0]);
            let (u, v, w) = (self.at(face[1]) - corner, self.at(face[2]) - corner, self.at(opposite) - corner);
            let normal = u.cross(v);
            let (of_origin, of_opposite) = (-normal.dot(corner), normal.dot(w));
            let area = SIDE_ERROR * u.length() * v.length();
            let is_sure = of_origin.abs() > area * corner.length() && of_opposite.abs() > area * w.length();
            if !is_sure || of_origin * of_opposite < 0.0 {
                let nearest = self.on_triangle(face);
                let is_nearer = best.as_ref().is_none_or(|best| nearest.point.length_squared() < best.point.length_squared());
                if is_nearer {
                    best = Some(nearest);
                }
            }
        }
        best
    }
}

/// The nearest point of a simplex, and the corners that it is made of.
struct NearestOnSimplex {
    point: DVec3,
    corners: [usize; 3],
    shares: [f64; 3],
    count: usize,
}

impl NearestOnSimplex {
    fn corner(simplex: &Simplex, corner: usize) -> Self {
        Self { point: simplex.at(corner), corners: [corner, 0, 0], shares: [1.0, 0.0, 0.0], count: 1 }
    }

    fn best(of: [Self; 3]) -> Self {
        let [first, second, third] = of;
        let nearer = |a: Self, b: Self| if b.point.length_squared() < a.point.length_squared() { b } else { a };
        nearer(nearer(first, second), third)
    }
}
