//! Signed distance between two convex parts: how far apart they are, or how deep they overlap and the shortest way out.

use glam::DVec3;

use super::epa;
use super::gjk::{self, Closest};
use super::part::Part;

/// How much less than the distance found the planes of a face may be apart and still give the normal: over the distance and
/// over the reach of the smaller part. The face is exact, what the search found is good to its last step. Over the greatest
/// measure: rounding.
const FACE_SLACK: (f64, f64, f64) = (1.0e-9, 1.0e-10, 1.0e-14);

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
pub(super) fn touch(a: &Part, b: &Part) -> f64 {
    TOUCH.0 * a.reach().min(b.reach()) + TOUCH.1 * greatest(a, b)
}

/// Greatest reach or coordinate of two parts (m): what rounding is measured by.
pub(super) fn greatest(a: &Part, b: &Part) -> f64 {
    let far = a.place.origin.abs().max_element().max(b.place.origin.abs().max_element());
    [a.reach(), b.reach()].into_iter().filter(|reach| reach.is_finite()).fold(far, f64::max)
}

/// The gap between two parts; none between two half-spaces.
pub(super) fn gap(a: &Part, b: &Part) -> Option<Gap> {
    if let Some(core) = with_half_space(a, b) {
        return core;
    }
    let core = match gjk::closest(a, b) {
        Closest::Apart { offset, on_a, on_b } => {
            let distance = offset.length();
            Gap { distance, normal: offset / distance, on_a, on_b }
        }
        Closest::Overlap(simplex) => {
            let found = epa::depth(a, b, &simplex);
            Gap { distance: -found.depth, normal: found.normal, on_a: found.on_a, on_b: found.on_b }
        }
    };
    Some(rounded(prefer_faces(a, b, core), a, b))
}

/// Distance of two parts that do not overlap; 0 or less if they do. Cheaper than [`gap`] where they overlap deep.
pub(super) fn distance(a: &Part, b: &Part) -> Option<f64> {
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
pub(super) fn along(a: &Part, b: &Part, normal: DVec3) -> f64 {
    match (a.half_space(), b.half_space()) {
        (None, None) => normal.dot(b.support(-normal) - a.support(normal)) - a.rounding - b.rounding,
        // Apart along the normal of its plane only.
        (Some(_), None) => normal.dot(b.support(-normal) - a.place.origin) - b.rounding,
        (None, Some(_)) => normal.dot(b.place.origin - a.support(normal)) - a.rounding,
        (Some(_), Some(_)) => f64::NEG_INFINITY,
    }
}

fn with_half_space(a: &Part, b: &Part) -> Option<Option<Gap>> {
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

/// A face along which the parts are as far apart gives the normal.
fn prefer_faces(a: &Part, b: &Part, found: Gap) -> Gap {
    let slack = FACE_SLACK.0 * found.distance.abs() + FACE_SLACK.1 * a.reach().min(b.reach()) + FACE_SLACK.2 * greatest(a, b);
    let (of_a, of_b) = (a.face_toward(found.normal), b.face_toward(-found.normal).map(|normal| -normal));
    for normal in [of_a, of_b].into_iter().flatten() {
        let distance = normal.dot(b.support(-normal) - a.support(normal));
        if distance >= found.distance - slack {
            let on_a = found.on_b - normal * distance;
            return Gap { distance, normal, on_a, on_b: found.on_b };
        }
    }
    found
}

fn rounded(core: Gap, a: &Part, b: &Part) -> Gap {
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
