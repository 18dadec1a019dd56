//! Nearest points of two convex parts in `f64`: what is small lies at the edge of what is long.
//!
//! GJK in `f32` loses its way where the corners that it goes between are a hundred times as far off as the parts are large or as they are apart:
//! the planes through three such corners are noise. In `f64` there is room for parts of 1 mm and 1 km.

use glam::DVec3;
use parry3d::math::Pose3;

use super::part::Part;

/// Most steps of a search; some ten find corners and edges, and round parts take one for each few bits.
const MAX_STEPS: u32 = 64;

/// Share of the distance, and of the coordinates it comes from, to which it is found: well below what `f32` tells apart.
const EXACT: f64 = 1.0e-9;

/// A point of each part, in A's frame.
#[derive(Clone, Copy)]
pub(super) struct Points {
    pub on_a: DVec3,
    pub on_b: DVec3,
}

impl Points {
    pub(super) fn offset(&self) -> DVec3 {
        self.on_b - self.on_a
    }
}

/// Nearest points of the cores of two parts, the second of which is placed at `relative` and moved by `shift` in A's frame; none where they
/// touch. The search starts along `seed`.
pub(super) fn nearest(a: &Part, b: &Part, relative: &Pose3, shift: DVec3, seed: DVec3) -> Option<Points> {
    let (rotation, place) = (relative.rotation.as_dquat().normalize(), relative.translation.as_dvec3() + shift);
    let back = rotation.inverse();
    let extreme = |direction: DVec3| Points {
        on_a: a.core_support(direction.as_vec3()).as_dvec3(),
        on_b: place + rotation * b.core_support((back * -direction).as_vec3()).as_dvec3(),
    };
    let mut simplex = Simplex::of(extreme(seed));
    let mut found = simplex.points[0];
    for _ in 0..MAX_STEPS {
        let distance = found.offset().length();
        let normal = found.offset() / distance;
        let next = extreme(normal);
        // Written so that a NaN ends the search.
        let goes_on = distance - normal.dot(next.offset()) > EXACT * (distance + next.on_a.length());
        if !goes_on || simplex.holds(&next) {
            break;
        }
        simplex.push(next);
        let nearer = simplex.reduce()?;
        if nearer.offset().length() >= distance {
            break;
        }
        found = nearer;
    }
    (found.offset() != DVec3::ZERO && found.offset().is_finite()).then_some(found)
}

/// Up to four pairs of points, whose offsets span what is known of the differences of the two parts.
struct Simplex {
    points: [Points; 4],
    count: usize,
}

impl Simplex {
    fn of(first: Points) -> Self {
        Self { points: [first; 4], count: 1 }
    }

    fn holds(&self, other: &Points) -> bool {
        self.points[..self.count].iter().any(|known| known.offset() == other.offset())
    }

    fn push(&mut self, next: Points) {
        self.points[self.count] = next;
        self.count += 1;
    }

    /// Leaves the corners of the face, edge or corner on which the offset nearest to the origin lies, and returns the points there; none if the
    /// origin is inside.
    fn reduce(&mut self) -> Option<Points> {
        let (mut best, mut least) = (None, f64::INFINITY);
        // What was nearest among the others is no longer so: the last corner is one of those sought.
        let last = 1_u32 << (self.count - 1);
        for chosen in last..2 * last {
            let mut part = Self { points: self.points, count: 0 };
            for i in (0..self.count).filter(|i| chosen >> i & 1 == 1) {
                part.push(self.points[i]);
            }
            let Some(weights) = part.weights() else { continue };
            let found = part.weighted(weights);
            let squared = found.offset().length_squared();
            if weights[..part.count].iter().all(|&weight| weight > 0.0) && squared < least {
                (best, least) = (Some((part, found)), squared);
            }
        }
        let (part, found) = best?;
        *self = part;
        (self.count < 4).then_some(found)
    }

    fn weighted(&self, weights: [f64; 4]) -> Points {
        let sum = |of: fn(&Points) -> DVec3| (0..self.count).map(|i| of(&self.points[i]) * weights[i]).sum();
        Points { on_a: sum(|points| points.on_a), on_b: sum(|points| points.on_b) }
    }

    /// Weights of the corners, of sum 1, in the point nearest to the origin of the line, plane or space through them; none if they do not span it.
    fn weights(&self) -> Option<[f64; 4]> {
        let [p, q, r, s] = self.points.map(|points| points.offset());
        let weights = match self.count {
            1 => [1.0, 0.0, 0.0, 0.0],
            2 => {
                let along = q - p;
                let share = -p.dot(along) / along.length_squared();
                [1.0 - share, share, 0.0, 0.0]
            }
            3 => {
                let across = (q - p).cross(r - p);
                let squared = across.length_squared();
                let foot = across * (across.dot(p) / squared);
                let of = |from: DVec3, to: DVec3| (from - foot).cross(to - foot).dot(across) / squared;
                [of(q, r), of(r, p), of(p, q), 0.0]
            }
            _ => {
                let volume = (q - p).dot((r - p).cross(s - p));
                let of = |from: DVec3, to: DVec3, last: DVec3| from.dot(to.cross(last)) / volume;
                [of(q, r, s), -of(p, r, s), of(p, q, s), -of(p, q, r)]
            }
        };
        weights.iter().all(|weight| weight.is_finite()).then_some(weights)
    }
}
