//! Signed distance between two convex parts: how far apart they are, or how deep they overlap and the shortest way out.

use glam::DVec3;

use super::epa;
use super::gjk::{self, Closest};
use super::part::{ConvexPart, PartForm};

/// How much less than the distance found the planes of a face may be apart and still give the normal: over the distance and
/// over the reach of the smaller part. The face is exact, what the search found is good to its last step. Over the greatest
/// measure: rounding.
const FACE_SLACK: (f64, f64, f64) = (1.0e-9, 1.0e-10, 1.0e-14);

/// How far off a part the foot on the plane of its face may be, over the reach of the part: rounding.
const ON_FACE: f64 = 1.0e-9;

/// Parts nearer than this to each other touch, over the reach of the smaller part, and over the greatest coordinate (rounding).
const TOUCH: (f64, f64) = (1.0e-9, 1.0e-14);

/// Nearest points of two parts, or those of least overlap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    /// Distance (m); negative is a depth.
    pub distance: f64,
    /// Outward unit normal of A, towards B.
    pub normal: DVec3,
    pub on_a: DVec3,
    pub on_b: DVec3,
}

/// Distance below which two parts touch (m).
pub(super) fn touch(a: &ConvexPart, b: &ConvexPart) -> f64 {
    TOUCH.0 * a.reach().min(b.reach()) + TOUCH.1 * greatest(a, b)
}

/// Greatest reach or coordinate of two parts (m): what rounding is measured by.
pub(super) fn greatest(a: &ConvexPart, b: &ConvexPart) -> f64 {
    let far = a.place.origin.abs().max_element().max(b.place.origin.abs().max_element());
    [a.reach(), b.reach()].into_iter().filter(|reach| reach.is_finite()).fold(far, f64::max)
}

/// The gap between two parts; none between two half-spaces.
pub(super) fn gap(a: &ConvexPart, b: &ConvexPart) -> Option<Gap> {
    if let Some(core) = with_half_space(a, b) {
        return core;
    }
    let core = match gjk::closest(a, b) {
        Closest::Apart { offset, on_a, on_b } => {
            let distance = offset.length();
            Gap { distance, normal: offset / distance, on_a, on_b }
        }
        Closest::Overlap(simplex) => of_point(a, b).or_else(|| of_point(b, a).map(Gap::swapped)).unwrap_or_else(|| {
            let found = epa::depth(a, b, &simplex);
            Gap { distance: -found.depth, normal: found.normal, on_a: found.on_a, on_b: found.on_b }
        }),
    };
    Some(rounded(prefer_faces(a, b, core), a, b))
}

/// The way out of A of a point B inside it.
fn of_point(a: &ConvexPart, b: &ConvexPart) -> Option<Gap> {
    let PartForm::Point = b.form else { return None };
    let on_b = b.place.origin;
    let (depth, normal) = a.way_out(on_b)?;
    Some(Gap { distance: -depth, normal, on_a: on_b + normal * depth, on_b })
}

/// Distance of two parts that do not overlap; 0 or less if they do. Cheaper than [`gap`] where they overlap deep.
pub(super) fn distance(a: &ConvexPart, b: &ConvexPart) -> Option<f64> {
    if let Some(core) = with_half_space(a, b) {
        return core.map(|gap| gap.distance);
    }
    let core = match gjk::closest(a, b) {
        Closest::Apart { offset, .. } => offset.length(),
        Closest::Overlap(_) => 0.0,
    };
    Some(core - a.rounding - b.rounding)
}

/// How far apart the parts are along a direction from A to B (m): never more than their distance.
pub(super) fn along(a: &ConvexPart, b: &ConvexPart, normal: DVec3) -> f64 {
    match (a.half_space(), b.half_space()) {
        (None, None) => normal.dot(b.support(-normal) - a.support(normal)) - a.rounding - b.rounding,
        // Apart along the normal of its plane only.
        (Some(_), None) => normal.dot(b.support(-normal) - a.place.origin) - b.rounding,
        (None, Some(_)) => normal.dot(b.place.origin - a.support(normal)) - a.rounding,
        (Some(_), Some(_)) => f64::NEG_INFINITY,
    }
}

fn with_half_space(a: &ConvexPart, b: &ConvexPart) -> Option<Option<Gap>> {
    match (a.half_space(), b.half_space()) {
        (None, None) => None,
        (Some(_), Some(_)) => Some(None),
        (Some(normal), None) => {
            let on_b = b.support(-normal) - normal * b.rounding;
            let distance = normal.dot(on_b - a.place.origin);
            Some(Some(Gap { distance, normal, on_a: on_b - normal * distance, on_b }))
        }
        (None, Some(_)) => Some(with_half_space(b, a)?.map(Gap::swapped)),
    }
}

/// A face along which the parts are as far apart gives the normal, if the point nearest to the other part lies on it. Far
/// from a face that leans by little, its plane is as far as the edge beside it, and the foot on that plane is off the part.
fn prefer_faces(a: &ConvexPart, b: &ConvexPart, found: Gap) -> Gap {
    let slack = FACE_SLACK.0 * found.distance.abs() + FACE_SLACK.1 * a.reach().min(b.reach()) + FACE_SLACK.2 * greatest(a, b);
    if let Some(normal) = a.face_toward(found.normal) {
        let distance = normal.dot(b.support(-normal) - a.support(normal));
        let on_a = found.on_b - normal * distance;
        if distance >= found.distance - slack && is_on(a, on_a, found.on_a) {
            return Gap { distance, normal, on_a, on_b: found.on_b };
        }
    }
    if let Some(normal) = b.face_toward(-found.normal).map(|normal| -normal) {
        let distance = normal.dot(b.support(-normal) - a.support(normal));
        let on_b = found.on_a + normal * distance;
        if distance >= found.distance - slack && is_on(b, on_b, found.on_b) {
            return Gap { distance, normal, on_a: found.on_a, on_b };
        }
    }
    found
}

/// Whether a point is on a part, near one that is.
fn is_on(part: &ConvexPart, point: DVec3, near: DVec3) -> bool {
    let slack = ON_FACE * part.reach();
    point.distance(near) <= slack || part.outside(point) <= slack
}

fn rounded(core: Gap, a: &ConvexPart, b: &ConvexPart) -> Gap {
    Gap {
        distance: core.distance - a.rounding - b.rounding,
        normal: core.normal,
        on_a: core.on_a + core.normal * a.rounding,
        on_b: core.on_b - core.normal * b.rounding,
    }
}

impl Gap {
    /// The same with A and B exchanged.
    pub(super) fn swapped(self) -> Self {
        Self { distance: self.distance, normal: -self.normal, on_a: self.on_b, on_b: self.on_a }
    }
}
