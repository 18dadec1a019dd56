//! The 15 axes that can separate two boxes.

use glam::Vec3;

use super::{BoxPair, unit};

/// Squared sine between two edges below which they have no common normal of their own.
const PARALLEL: f32 = 1.0e-8;

/// A face of A, or of B, and how far apart the boxes are along its normal.
pub(super) struct FaceAxis {
    pub axis: usize,
    pub of_b: bool,
    pub separation: f32,
}

/// An edge of A and one of B, parallel to these axes.
pub(super) struct EdgeAxis {
    pub a: usize,
    pub b: usize,
    pub separation: f32,
    /// In A's frame, from A to B.
    pub normal: Vec3,
}

/// For the cross products of each axis of A with B's three, which are no unit vectors: separation times length, and length
/// squared.
pub(super) struct EdgeAxes {
    over: [Vec3; 3],
    squared: [Vec3; 3],
}

impl EdgeAxes {
    /// No separation is greater than this if it is an overlap; otherwise, some pair of edges separates the boxes.
    #[inline]
    pub fn greatest(&self) -> f32 {
        self.over[0].max(self.over[1]).max(self.over[2]).max_element()
    }
}

impl BoxPair {
    /// None if a face separates the boxes by more than `margin`.
    #[inline]
    pub(super) fn best_face(&self, margin: f32) -> Option<FaceAxis> {
        let Self { a, b, axes, axes_in_b, center, center_in_b, .. } = self;
        let over_a = center.abs() - *a - (axes.x_axis.abs() * b.x + axes.y_axis.abs() * b.y + axes.z_axis.abs() * b.z);
        // Written so that a NaN is no contact.
        let near = over_a.max_element() <= margin;
        if !near {
            return None;
        }
        let reach_a = axes_in_b.x_axis.abs() * a.x + axes_in_b.y_axis.abs() * a.y + axes_in_b.z_axis.abs() * a.z;
        let over_b = center_in_b.abs() - *b - reach_a;
        if over_b.max_element() > margin {
            return None;
        }
        let mut best = FaceAxis { axis: 0, of_b: false, separation: over_a.x };
        let mut to_beat = over_a.x + self.lead_over(over_a.x);
        for (separation, axis, of_b) in
            [(over_a.y, 1, false), (over_a.z, 2, false), (over_b.x, 0, true), (over_b.y, 1, true), (over_b.z, 2, true)]
        {
            if separation > to_beat {
                best = FaceAxis { axis, of_b, separation };
                to_beat = separation + self.lead_over(separation);
            }
        }
        Some(best)
    }

    /// Row i of the rotation holds what is needed of the cross products with A's axis i: with rows r, s of the other two,
    /// they are (−s, r) across that axis. B's reach is measured with these vectors themselves, not with the entries of the
    /// rotation that it equals in theory: near parallel, the difference would be divided by a small length.
    #[inline]
    pub(super) fn edge_axes(&self) -> EdgeAxes {
        let Self { a, b, axes_in_b, center, .. } = self;
        let rows = [axes_in_b.x_axis, axes_in_b.y_axis, axes_in_b.z_axis];
        let along_axis = |r: Vec3, s: Vec3, (a_r, a_s): (f32, f32), (c_r, c_s): (f32, f32)| {
            let reach_a = s.abs() * a_r + r.abs() * a_s;
            let w = r.cross(s).abs();
            let reach_b = Vec3::new(b.y * w.z + b.z * w.y, b.z * w.x + b.x * w.z, b.x * w.y + b.y * w.x);
            ((r * c_s - s * c_r).abs() - reach_a - reach_b, r * r + s * s)
        };
        let x = along_axis(rows[1], rows[2], (a.y, a.z), (center.y, center.z));
        let y = along_axis(rows[2], rows[0], (a.z, a.x), (center.z, center.x));
        let z = along_axis(rows[0], rows[1], (a.x, a.y), (center.x, center.y));
        EdgeAxes { over: [x.0, y.0, z.0], squared: [x.1, y.1, z.1] }
    }

    /// The edges furthest apart, if further than `to_beat`; `None` if any are further apart than `margin`.
    pub(super) fn best_edges(&self, axes: &EdgeAxes, mut to_beat: f32, margin: f32) -> Option<Option<EdgeAxis>> {
        let mut best = None;
        for i in 0..3 {
            let (over, squared) = (axes.over[i].to_array(), axes.squared[i].to_array());
            for j in 0..3 {
                if squared[j] < PARALLEL || (over[j] <= to_beat && over[j] <= 0.0) {
                    continue;
                }
                let separation = over[j] / squared[j].sqrt();
                if separation > margin {
                    return None;
                }
                if separation > to_beat {
                    best = Some((i, j, separation));
                    to_beat = separation + self.lead_over(separation);
                }
            }
        }
        Some(best.map(|(a, b, separation)| {
            let cross = unit(a).cross(self.axes.col(b));
            let normal = cross * (1.0_f32.copysign(self.center.dot(cross)) / cross.length());
            EdgeAxis { a, b, separation, normal }
        }))
    }
}
