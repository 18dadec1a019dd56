//! A box against a box: separating axes, then clipping of the two faces that meet.
//!
//! 15 axes can separate two boxes: three face normals of each and the nine cross products of their edges (Gottschalk et
//! al. 1996). The axis of least overlap, or of greatest separation, is the normal, with two preferences. A later face must
//! beat an earlier one by a margin well above rounding: aligned boxes are then always A's face against B's. And a pair of
//! edges is one point, while a face keeps all points that carry a tilted box. So by how far the edges beat the face decides:
//!
//! ```text
//! not at all                 the face
//! up to the edge lead        the face, if what touches over it is as near as the edges are; else the edges
//! by more                    the edges
//! ```
//!
//! Between boxes apart, the best axis gives the true distance where the nearest features face each other along it. Where
//! they do not (corner to corner, corner to edge), the nearest points are found by GJK and make a manifold of one point.

use glam::{Mat3, Vec3};
use parry3d::math::Pose3;

use super::segment::Segment;
use super::{Manifold, ManifoldPoint};

mod axes;
mod face;
mod nearest;

use axes::FaceAxis;

/// By how much a later axis must beat an earlier one: relative to the overlap, and to the size of the smaller box.
const AXIS_LEAD: f32 = 1.0e-4;
const AXIS_LEAD_OF_SIZE: f32 = 1.0e-5;

/// By how much an edge axis must beat the best face: relative to the overlap, and to the least half extent.
pub(super) const EDGE_LEAD: f32 = 0.1;
pub(super) const EDGE_LEAD_OF_SIZE: f32 = 0.02;

/// How much further apart (relative) the points over a face may be than the edges it is preferred to: along a face's normal,
/// edges that cross 2.5° off it are 1/cos 2.5° as far apart.
const FACE_TILT: f32 = 1.0e-3;

/// How far outside a face a vertex counts as over it, as a fraction of the least half extent.
const CLIP_SLOP: f32 = 1.0e-4;

/// Rounding of a coordinate, as a fraction of the greatest half extent.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Bit of a feature id: the clipping face belongs to B.
const FACE_OF_B: u32 = 1 << 16;

/// Bit of a feature id: edge against edge.
const EDGES: u32 = 1 << 17;

/// Feature of a lone point found by other means.
const LONE: u32 = 1 << 18;

/// Feature of the first end of two edges side by side, followed by that of the other.
const LINE: u32 = 1 << 19;

/// Box B against box A, by their half extents (m): appends their manifold if they are near.
pub(super) fn box_box(a: Vec3, b: Vec3, relative: &Pose3, margin: f32, out: &mut Vec<Manifold>) {
    let pair = BoxPair::new(a, b, relative);
    let Some(face) = pair.best_face(margin) else { return };
    let manifold = Manifold::append(out);
    if pair.contact(&face, relative, margin, manifold).is_none() {
        out.pop();
    }
}

/// What was found between boxes apart, if any of it is near enough.
fn within(found: Manifold, margin: f32) -> Option<Manifold> {
    found.contacts().iter().any(|point| point.separation <= margin).then_some(found)
}

/// Two boxes in the frame of the first.
struct BoxPair {
    a: Vec3,
    b: Vec3,
    /// B's axes as columns, and A's in B's frame.
    axes: Mat3,
    axes_in_b: Mat3,
    /// Centre of B in A's frame, and of A in B's.
    center: Vec3,
    center_in_b: Vec3,
    lead: f32,
    edge_lead: f32,
    slop: f32,
}

impl BoxPair {
    #[inline]
    fn new(a: Vec3, b: Vec3, relative: &Pose3) -> Self {
        let axes = Mat3::from_quat(relative.rotation);
        let axes_in_b = axes.transpose();
        let center = relative.translation;
        let rounding = ROUNDING * a.max_element().max(b.max_element());
        let least = a.min_element().min(b.min_element());
        Self {
            a,
            b,
            axes,
            axes_in_b,
            center,
            center_in_b: -(axes_in_b * center),
            lead: AXIS_LEAD_OF_SIZE * a.max_element().min(b.max_element()) + rounding,
            edge_lead: EDGE_LEAD_OF_SIZE * least,
            slop: CLIP_SLOP * least + rounding,
        }
    }

    /// The same pair in B's frame.
    #[inline]
    fn swapped(&self) -> Self {
        Self {
            a: self.b,
            b: self.a,
            axes: self.axes_in_b,
            axes_in_b: self.axes,
            center: self.center_in_b,
            center_in_b: self.center,
            ..*self
        }
    }

    /// Fills an empty `manifold`; none if the boxes are further apart than `margin`.
    #[inline]
    fn contact(&self, face: &FaceAxis, relative: &Pose3, margin: f32, manifold: &mut Manifold) -> Option<()> {
        let axes = self.edge_axes();
        let to_beat = face.separation + self.lead_over(face.separation);
        let clear_lead = self.edge_lead_over(face.separation);

        // Nearly always no edges come near to beating the face by as much as they must, and which are best does not matter.
        let edges_count = axes.greatest() > clear_lead.min(0.0);
        let mut edges = None;
        if edges_count {
            edges = self.best_edges(&axes, to_beat, margin)?;
            if let Some(edges) = edges.take_if(|edges| edges.separation > clear_lead) {
                *manifold = self.on_edges(&edges, relative, margin)?;
                self.add_points_of_face(face, margin, manifold);
                return Some(());
            }
        }
        let deepest = self.on_face(face, margin, manifold);
        let facing = deepest <= face.separation + self.slack(face.separation);
        if facing {
            return (manifold.count > 0).then_some(());
        }
        if !edges_count {
            edges = self.best_edges(&axes, to_beat, margin)?;
        }
        match edges {
            Some(edges) if manifold.count < 2 || deepest > edges.separation + self.tilt_slack(edges.separation) => {
                *manifold = self.on_edges(&edges, relative, margin)?;
            }
            None if face.separation > 0.0 => {
                let found = self.nearest(relative).unwrap_or_else(|| self.corner_over_face(face));
                *manifold = within(found, margin)?;
            }
            None if manifold.count == 0 => *manifold = self.corner_over_face(face),
            _ => {}
        }
        Some(())
    }

    fn lead_over(&self, separation: f32) -> f32 {
        self.lead + AXIS_LEAD * separation.abs()
    }

    /// What edges must reach to be preferred to a face (m).
    fn edge_lead_over(&self, face: f32) -> f32 {
        face + self.edge_lead + EDGE_LEAD * face.abs()
    }

    /// How far points may be off the separation along an axis and still be those it promises (m).
    fn slack(&self, separation: f32) -> f32 {
        self.lead_over(separation) + self.slop
    }

    fn tilt_slack(&self, separation: f32) -> f32 {
        self.slack(separation) + FACE_TILT * separation.abs()
    }

    fn point(&self, on_a: Vec3, on_b: Vec3, normal: Vec3, feature: u32) -> ManifoldPoint {
        ManifoldPoint { on_a, on_b: self.in_b(on_b), separation: normal.dot(on_b - on_a), feature }
    }

    fn in_b(&self, point: Vec3) -> Vec3 {
        self.axes_in_b * (point - self.center)
    }
}

fn unit(i: usize) -> Vec3 {
    [Vec3::X, Vec3::Y, Vec3::Z][i]
}

/// The edge parallel to `axis` that reaches furthest along `direction`.
fn edge(half: Vec3, axis: usize, direction: Vec3) -> Segment {
    let mut center = half.copysign(direction);
    let mut along = Vec3::ZERO;
    center[axis] = 0.0;
    along[axis] = half[axis];
    Segment { center, half: along }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

    const UNIT: Vec3 = Vec3::splat(0.5);

    fn found(a: Vec3, b: Vec3, position: Vec3, rotation: Quat, margin: f32) -> Option<Manifold> {
        let mut out = Vec::new();
        box_box(a, b, &Pose3::from_parts(position, rotation), margin, &mut out);
        out.pop()
    }

    fn contact(a: Vec3, b: Vec3, position: Vec3, rotation: Quat, margin: f32) -> Manifold {
        found(a, b, position, rotation, margin).expect("a contact")
    }

    fn features(manifold: &Manifold) -> Vec<u32> {
        manifold.contacts().iter().map(|p| p.feature).collect()
    }

    /// Small deterministic disturbances of position (m) and rotation (rad).
    fn jitters(size: f32) -> impl Iterator<Item = (Vec3, Quat)> {
        (0..200_u32).map(move |i| {
            let noise =
                |k: u32| size * ((i.wrapping_mul(2_654_435_761).wrapping_add(k * 40_503) >> 7) % 2001) as f32 / 1000.0 - size;
            let turn = Quat::from_scaled_axis(Vec3::new(noise(4), noise(5), noise(6)));
            (Vec3::new(noise(1), noise(2), noise(3)), turn)
        })
    }

    #[test]
    fn equal_aligned_boxes_touch_with_four_corners_and_keep_them_under_jitter() {
        for scale in [1e-3, 1.0, 1e3] {
            let above = Vec3::new(0.0, 0.999 * scale, 0.0);
            let still = contact(UNIT * scale, UNIT * scale, above, Quat::IDENTITY, 0.01 * scale);
            assert_eq!((still.count, still.normal), (4, Vec3::Y));
            for point in still.contacts() {
                let corner = point.on_a.abs() - UNIT * scale;
                assert!(corner.abs().max_element() < 1e-6 * scale, "{} is no corner", point.on_a);
                assert!((point.separation + 0.001 * scale).abs() < 1e-6 * scale, "{} m", point.separation);
            }
            for (offset, turn) in jitters(1e-6) {
                let moved = contact(UNIT * scale, UNIT * scale, above + offset * scale, turn, 0.01 * scale);
                assert_eq!(features(&moved), features(&still), "moved by {offset} and {turn} of {scale} m");
            }
        }
    }

    #[test]
    fn a_box_turned_by_45_degrees_keeps_four_of_its_eight_points_under_jitter() {
        let (above, turned) = (Vec3::new(0.0, 1.0, 0.0), Quat::from_rotation_y(FRAC_PI_4));
        let still = contact(UNIT, UNIT, above, turned, 0.01);
        assert_eq!((still.count, still.normal), (4, Vec3::Y));
        for point in still.contacts() {
            let [x, _, z] = point.on_a.abs().to_array();
            let crossing = FRAC_1_SQRT_2 - 0.5;
            assert!((x.max(z) - 0.5).abs() < 1e-6 && (x.min(z) - crossing).abs() < 1e-6, "{} is no crossing", point.on_a);
        }
        for (offset, turn) in jitters(1e-6) {
            let moved = contact(UNIT, UNIT, above + offset, turn * turned, 0.01);
            assert_eq!(features(&moved), features(&still), "moved by {offset} and {turn}");
        }
    }

    #[test]
    fn a_small_box_on_a_huge_one_keeps_its_corners_under_jitter() {
        let ground = Vec3::new(1000.0, 1.0, 1000.0);
        let above = Vec3::new(300.0, 1.499, -200.0);
        let still = contact(ground, UNIT, above, Quat::IDENTITY, 0.01);
        assert_eq!((still.count, still.normal), (4, Vec3::Y));
        for (offset, turn) in jitters(1e-6) {
            let moved = contact(ground, UNIT, above + offset, turn, 0.01);
            assert_eq!(features(&moved), features(&still), "moved by {offset} and {turn}");
            for point in moved.contacts() {
                assert!((point.separation + 0.001).abs() < 1e-5, "{} m", point.separation);
            }
        }
    }

    #[test]
    fn boxes_whose_edges_line_up_are_never_found_deep() {
        for shift in [0.0, 1e-7, -1e-7, 1e-6, -1e-6, 1e-4, -1e-4] {
            for (offset, turn) in jitters(1e-5) {
                let position = Vec3::new(1.0 + shift, 0.25, 0.0) + offset;
                let Some(manifold) = found(UNIT, UNIT, position, turn, 0.01) else { continue };
                for point in manifold.contacts() {
                    assert!(point.separation > -2e-4, "{} m at {position}", point.separation);
                }
            }
        }
    }

    #[test]
    fn crossed_edges_touch_at_one_point() {
        // Both stand on an edge, the edges at right angles.
        let tilt = Quat::from_rotation_z(FRAC_PI_4).inverse() * Quat::from_rotation_x(FRAC_PI_4);
        let up = Quat::from_rotation_z(FRAC_PI_4).inverse() * Vec3::Y;
        for gap in [-0.05, 0.0, 0.05] {
            let manifold = contact(UNIT, UNIT, up * (2.0 * FRAC_1_SQRT_2 + gap), tilt, 0.1);
            assert_eq!(manifold.count, 1);
            assert!((manifold.normal - up).length() < 1e-5, "normal {}", manifold.normal);
            assert!((manifold.points[0].separation - gap).abs() < 1e-6, "{} m, expected {gap} m", manifold.points[0].separation);
        }
    }

    /// Blocks of a ring wall: their upright edges face each other across a wedge.
    #[test]
    fn edges_side_by_side_touch_at_both_ends_of_the_line_and_keep_them_under_jitter() {
        let (turn, normal) = (Quat::from_rotation_y(0.2), Quat::from_rotation_y(0.1) * Vec3::X);
        // B's upright edge that reaches back furthest, opposite A's with the gap between.
        let (own, other) = (Vec3::new(0.5, 0.0, -0.5), turn * Vec3::new(-0.5, 0.0, -0.5));
        for (gap, rise) in [(0.01, 0.0), (0.02, 0.3), (0.03, -0.3)] {
            let position = own + normal * gap - other + Vec3::Y * rise;
            let still = contact(UNIT, UNIT, position, turn, 0.05);
            assert_eq!(still.count, 2, "points at a gap of {gap} m, {rise} m up");
            assert!((still.normal - normal).length() < 1e-3, "normal {}", still.normal);
            for (point, height) in still.contacts().iter().zip([(rise - 0.5).max(-0.5), (rise + 0.5).min(0.5)]) {
                assert!((point.on_a - own - Vec3::Y * height).length() < 1e-4, "{} on the first", point.on_a);
                assert!((point.separation - gap).abs() < 1e-5, "{} m, expected {gap} m", point.separation);
            }
            for (offset, tilt) in jitters(1e-6) {
                let moved = contact(UNIT, UNIT, position + offset, tilt * turn, 0.05);
                assert_eq!(features(&moved), features(&still), "moved by {offset} and {tilt}");
            }
        }
    }

    #[test]
    fn boxes_corner_to_corner_report_the_true_distance() {
        let manifold = contact(UNIT, UNIT, Vec3::new(1.3, 1.4, 2.2), Quat::IDENTITY, 2.0);
        let point = manifold.points[0];
        assert_eq!(manifold.count, 1);
        assert!((point.separation - 1.3).abs() < 1e-5, "{} m, expected 1.3 m", point.separation);
        assert!((manifold.normal - Vec3::new(3.0, 4.0, 12.0) / 13.0).length() < 1e-5, "normal {}", manifold.normal);
    }

    #[test]
    fn boxes_face_to_face_are_seen_a_metre_away() {
        let manifold = contact(UNIT, UNIT, Vec3::new(0.2, -1.9, 0.1), Quat::IDENTITY, 1.0);
        assert_eq!((manifold.count, manifold.normal), (4, Vec3::NEG_Y));
        for point in manifold.contacts() {
            assert!((point.separation - 0.9).abs() < 1e-6, "{} m", point.separation);
        }
        assert!(found(UNIT, UNIT, Vec3::new(0.2, -2.1, 0.1), Quat::IDENTITY, 1.0).is_none());
    }

    #[test]
    fn a_box_inside_another_leaves_by_the_nearest_face() {
        let manifold = contact(Vec3::ONE, UNIT * 0.5, Vec3::new(0.1, -0.2, 0.3), Quat::IDENTITY, 0.0);
        assert_eq!((manifold.count, manifold.normal), (4, Vec3::Z));
        assert!((manifold.points[0].separation + 0.95).abs() < 1e-6, "{} m", manifold.points[0].separation);
        let same = contact(UNIT, UNIT, Vec3::ZERO, Quat::IDENTITY, 0.0);
        assert_eq!((same.normal, same.points[0].separation), (Vec3::X, -1.0));
    }
}
