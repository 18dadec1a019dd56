//! Where a segment, thick or not, meets a box: in `f64`, so that nothing is missed far from the origin.

use glam::{DVec3, Vec3};
use parry3d::bounding_volume::Aabb;

/// Relative and absolute tolerance of the slab test (m): what is decided by rounding is looked at.
const TOLERANCE: f64 = 1.0e-9;

/// A straight path of a box: from `origin` along `direction` for `length`, with half extents `half`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PathSegment {
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    pub length: f64,
    /// Half extents of what moves (m); zero for a ray.
    pub half: DVec3,
}

impl PathSegment {
    /// A box that does not move.
    pub(crate) fn still(origin: DVec3, half: DVec3) -> Self {
        Self { origin, direction: DVec3::X, length: 0.0, half }
    }

    /// Distance along the path at which it enters a box (m), or none if it does not.
    pub(crate) fn enters(&self, mins: Vec3, maxs: Vec3) -> Option<f64> {
        self.inside(mins, maxs).map(|(first, _)| first)
    }

    /// The stretch of the path on which it meets a box (m), or none if it does not.
    ///
    /// Per axis, the path is between the two faces while t₁ ≤ t ≤ t₂, with t = (face − origin)/direction; it is in the box
    /// where all three intervals meet (Kay and Kajiya 1986). An axis along which it does not move allows all t or none.
    pub(crate) fn inside(&self, mins: Vec3, maxs: Vec3) -> Option<(f64, f64)> {
        let (mut first, mut last) = (0.0_f64, self.length);
        for axis in 0..3 {
            let origin = self.origin[axis];
            let slack = self.half[axis] + TOLERANCE * (1.0 + origin.abs());
            let (low, high) = (f64::from(mins[axis]) - slack - origin, f64::from(maxs[axis]) + slack - origin);
            let direction = self.direction[axis];
            if direction.abs() < f64::MIN_POSITIVE {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / direction, high / direction);
            first = first.max(a.min(b));
            last = last.min(a.max(b));
        }
        (first <= last).then_some((first, last))
    }

    pub(crate) fn enters_box(&self, region: &Aabb) -> Option<f64> {
        self.enters(region.mins, region.maxs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_enters_a_box_where_its_face_is() {
        let path =
            PathSegment { origin: DVec3::new(1.0e6, 5.0, 0.0), direction: DVec3::NEG_Y, length: 10.0, half: DVec3::splat(0.5) };
        let (mins, maxs) = (Vec3::new(1.0e6 - 1.0, 0.0, -1.0), Vec3::new(1.0e6 + 1.0, 1.0, 1.0));
        let distance = path.enters(mins, maxs).expect("the box is below");
        assert!((distance - 3.5).abs() < 1.0e-2, "{distance} m");
        assert!(PathSegment { length: 3.0, ..path }.enters(mins, maxs).is_none());
        assert!(PathSegment { origin: DVec3::new(1.0e6 + 1.6, 5.0, 0.0), ..path }.enters(mins, maxs).is_none());
        assert_eq!(PathSegment { origin: DVec3::new(1.0e6, 0.5, 0.0), ..path }.enters(mins, maxs), Some(0.0));
    }
}
