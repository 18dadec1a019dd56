//! A box against a box: separating axes, then clipping of the two faces that meet.
//!
//! 15 axes can separate two boxes: three face normals of each and the nine cross products of their edges (Gottschalk et
//! al. 1996). The axis of least overlap, or of greatest separation, is the normal. A face must be beaten by an edge, and a
//! face of A by one of B, by a margin well above rounding: aligned boxes are then always A's face against B's.
//!
//! Between boxes apart, that axis gives the true distance where the nearest features face each other along it. Where they do
//! not (corner to corner, corner to edge), the nearest points are found by GJK and make a manifold of one point.

use glam::{Mat3, Vec2, Vec3};
use parry3d::math::Pose3;
use parry3d::shape::Cuboid;

use super::capsule::Segment;
use super::clip::{Side, Vertex, clip};
use super::distance;
use super::reduce::{Candidate, reduce_into};
use super::{Manifold, ManifoldPoint};

/// By how much a later axis must beat an earlier one: relative to the overlap, and to the size of the smaller box.
const AXIS_LEAD: f32 = 1.0e-4;
const AXIS_LEAD_OF_SIZE: f32 = 1.0e-5;

/// How far outside a face a vertex counts as over it, as a fraction of the least half extent.
const CLIP_SLOP: f32 = 1.0e-4;

/// Rounding of a coordinate, as a fraction of the greatest half extent.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Squared sine between two edges below which they have no common normal of their own.
const PARALLEL: f32 = 1.0e-8;

/// Most vertices of a quadrilateral clipped to a rectangle.
const MAX_CLIPPED: usize = 8;

/// Box B against box A, by their half extents (m).
pub(super) fn box_box(a: Vec3, b: Vec3, relative: &Pose3, margin: f32) -> Option<Manifold> {
    let pair = Pair::new(a, b, relative);
    let axis = pair.best_axis(margin)?;
    let found = match axis.kind {
        Kind::FaceOfA(i) => pair.faces(i, axis.separation, margin),
        Kind::FaceOfB(i) => {
            let from_b = |found: Manifold| Manifold {
                normal: -(pair.axes * found.normal),
                points: found.points.map(|p| ManifoldPoint { on_a: p.on_b, on_b: p.on_a, feature: p.feature | FACE_OF_B, ..p }),
                ..found
            };
            pair.swapped().faces(i, axis.separation, margin).map(from_b).map_err(from_b)
        }
        Kind::Edges(i, j) => pair.edges(i, j, axis.normal),
    };
    let manifold = match found {
        Ok(manifold) => manifold,
        Err(poor) if axis.separation > 0.0 => pair.nearest(relative, &axis).unwrap_or(poor),
        Err(poor) => poor,
    };
    let near = manifold.count > 0 && manifold.contacts().iter().any(|p| p.separation <= margin);
    near.then_some(manifold)
}

/// Bit of a feature id: the clipping face belongs to B.
const FACE_OF_B: u32 = 1 << 16;

/// Bit of a feature id: edge against edge.
const EDGES: u32 = 1 << 17;

/// Feature of a lone point found by other means.
const LONE: u32 = 1 << 18;

enum Kind {
    FaceOfA(usize),
    FaceOfB(usize),
    Edges(usize, usize),
}

struct Axis {
    kind: Kind,
    separation: f32,
    /// In A's frame, from A to B.
    normal: Vec3,
}

/// The contact along an axis; as an error where the nearest features do not face each other along it.
type Found = Result<Manifold, Manifold>;

/// Two boxes in the frame of the first.
struct Pair {
    a: Vec3,
    b: Vec3,
    /// B's axes as columns, and A's in B's frame.
    axes: Mat3,
    axes_in_b: Mat3,
    /// Centre of B in A's frame, and of A in B's.
    center: Vec3,
    center_in_b: Vec3,
    lead: f32,
    slop: f32,
}

impl Pair {
    fn new(a: Vec3, b: Vec3, relative: &Pose3) -> Self {
        let axes = Mat3::from_quat(relative.rotation);
        let axes_in_b = axes.transpose();
        let center = relative.translation;
        let rounding = ROUNDING * a.max_element().max(b.max_element());
        Self {
            a,
            b,
            axes,
            axes_in_b,
            center,
            center_in_b: -(axes_in_b * center),
            lead: AXIS_LEAD_OF_SIZE * a.max_element().min(b.max_element()) + rounding,
            slop: CLIP_SLOP * a.min_element().min(b.min_element()) + rounding,
        }
    }

    /// The same pair in B's frame.
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

    /// None if some axis separates the boxes by more than `margin`.
    #[inline]
    fn best_axis(&self, margin: f32) -> Option<Axis> {
        let Self { a, b, axes, axes_in_b, center, .. } = self;
        let over_a = center.abs() - *a - abs(axes) * *b;
        // Written so that a NaN is no contact.
        let near = over_a.max_element() <= margin;
        if !near {
            return None;
        }
        let over_b = self.center_in_b.abs() - *b - abs(axes_in_b) * *a;
        if over_b.max_element() > margin {
            return None;
        }

        let mut best = Best { separation: over_a.x, to_beat: over_a.x + self.lead_over(over_a.x), at: 0 };
        best.offer(over_a.y, 1, self);
        best.offer(over_a.z, 2, self);
        best.offer(over_b.x, 3, self);
        best.offer(over_b.y, 4, self);
        best.offer(over_b.z, 5, self);

        let mut edge_normal = Vec3::ZERO;
        for i in 0..3 {
            for j in 0..3 {
                let cross = unit(i).cross(axes.col(j));
                let squared = cross.length_squared();
                if squared < PARALLEL {
                    continue;
                }
                let along = center.dot(cross);
                // B's reach is measured with the same vector, not with the entries of the rotation that it equals in theory:
                // near parallel, the difference would be divided by a small length.
                let (k, l) = ((j + 1) % 3, (j + 2) % 3);
                let reach_a = a.dot(cross.abs());
                let reach_b = b[k] * cross.dot(axes.col(k)).abs() + b[l] * cross.dot(axes.col(l)).abs();
                let over = along.abs() - reach_a - reach_b;
                // |cross| ≤ 1: division only lowers an overlap.
                if over <= best.to_beat && over <= 0.0 {
                    continue;
                }
                let length = squared.sqrt();
                let separation = over / length;
                if separation > margin {
                    return None;
                }
                if separation > best.to_beat {
                    best.offer(separation, 6 + 3 * i + j, self);
                    edge_normal = cross * (1.0_f32.copysign(along) / length);
                }
            }
        }

        let separation = best.separation;
        Some(match best.at {
            i @ 0..3 => Axis { kind: Kind::FaceOfA(i), separation, normal: unit(i) * 1.0_f32.copysign(center[i]) },
            i @ 3..6 => {
                let i = i - 3;
                let normal = axes.col(i) * -1.0_f32.copysign(self.center_in_b[i]);
                Axis { kind: Kind::FaceOfB(i), separation, normal }
            }
            i => Axis { kind: Kind::Edges((i - 6) / 3, (i - 6) % 3), separation, normal: edge_normal },
        })
    }

    fn lead_over(&self, separation: f32) -> f32 {
        self.lead + AXIS_LEAD * separation.abs()
    }

    /// A's face across axis `i` against the face of B most opposed to it.
    fn faces(&self, i: usize, expected: f32, margin: f32) -> Found {
        let sign = 1.0_f32.copysign(self.center[i]);
        let (u, v) = ((i + 1) % 3, (i + 2) % 3);
        let facing = self.axes_in_b.col(i) * sign;
        let alignment = facing.abs();
        let k = (1..3).fold(0, |best, k| if alignment[k] > alignment[best] + AXIS_LEAD { k } else { best });
        let incident_normal = self.axes.col(k) * -1.0_f32.copysign(facing[k]);
        let middle = self.center + incident_normal * self.b[k];
        let (p, q) = ((k + 1) % 3, (k + 2) % 3);
        let (along_p, along_q) = (self.axes.col(p) * self.b[p], self.axes.col(q) * self.b[q]);

        let vertex = |offset: Vec3, edge: u16| {
            let corner = middle + offset;
            Vertex { at: Vec2::new(corner[u], corner[v]), height: sign * corner[i] - self.a[i], edge, spare: false }
        };
        let incident = [
            vertex(-along_p - along_q, 0),
            vertex(along_p - along_q, 1),
            vertex(along_p + along_q, 2),
            vertex(along_q - along_p, 3),
        ];
        let rectangle = Vec2::new(self.a[u], self.a[v]);
        let mut clipped = Clipped::default();
        clipped.fill(&incident, rectangle, self.slop);

        let face_id = (i as u32) << 1 | u32::from(sign > 0.0);
        let incident_id = (k as u32) << 1 | u32::from(facing[k] > 0.0);
        let mut candidates = [Candidate::default(); MAX_CLIPPED];
        let mut count = 0;
        let mut deepest = f32::INFINITY;
        let mut arriving = clipped.vertices[..clipped.count].last().map_or(0, |vertex| vertex.edge);
        for vertex in &clipped.vertices[..clipped.count] {
            let Vertex { at, height, .. } = *vertex;
            deepest = deepest.min(height);
            if height <= margin && !vertex.spare {
                let mut on_a = Vec3::ZERO;
                on_a[u] = at.x;
                on_a[v] = at.y;
                on_a[i] = sign * self.a[i];
                let mut on_b = on_a;
                on_b[i] = sign * (self.a[i] + height);
                let feature = face_id << 9 | incident_id << 6 | u32::from(arriving) << 3 | u32::from(vertex.edge);
                candidates[count] = Candidate { on_a, on_b, separation: height, feature };
                count += 1;
            }
            arriving = vertex.edge;
        }
        let slack = self.lead_over(expected) + self.slop;
        if clipped.count == 0 || (expected > 0.0 && deepest > expected + slack) {
            return Err(self.corner_over_face(i, sign));
        }
        let mut manifold = Manifold { normal: unit(i) * sign, ..Manifold::default() };
        reduce_into(&mut manifold, &candidates[..count], self.slop, |c| ManifoldPoint {
            on_a: c.on_a,
            on_b: self.in_b(c.on_b),
            separation: c.separation,
            feature: c.feature,
        });
        Ok(manifold)
    }

    /// Edge `i` of A across edge `j` of B.
    fn edges(&self, i: usize, j: usize, normal: Vec3) -> Found {
        let on_a = edge(self.a, i, normal);
        let local = edge(self.b, j, self.axes_in_b * -normal);
        let on_b = Segment { center: self.center + self.axes * local.center, half: self.axes * local.half };
        let (s, t) = on_a.closest(&on_b);
        let (point_a, point_b) = (on_a.at(s), on_b.at(t));
        let offset = point_b - point_a;
        let separation = normal.dot(offset);
        let facing = offset.length() <= separation + self.lead_over(separation) + self.slop;
        let side = |n: Vec3| u32::from(n.x > 0.0) | u32::from(n.y > 0.0) << 1 | u32::from(n.z > 0.0) << 2;
        let feature = EDGES | (3 * i + j) as u32 | side(on_a.center) << 4 | side(local.center) << 7;
        let manifold = Manifold::single(normal, self.point(point_a, point_b, normal, feature));
        if facing || separation <= 0.0 { Ok(manifold) } else { Err(manifold) }
    }

    /// Boxes apart whose nearest features face each other along none of the axes.
    fn nearest(&self, relative: &Pose3, axis: &Axis) -> Option<Manifold> {
        let scale = 1.0 / self.a.max_element().min(self.b.max_element());
        let scaled = Pose3::from_parts(self.center * scale, relative.rotation);
        let gap = distance::apart(&Cuboid::new(self.a * scale), &Cuboid::new(self.b * scale), &scaled)?;
        let point = self.point(gap.on_a / scale, gap.on_b / scale, gap.normal, LONE);
        let manifold = Manifold::single(gap.normal, point);
        // The axis is a proof that the boxes are no nearer.
        let sound = point.separation >= axis.separation - self.lead_over(axis.separation);
        (sound && manifold.is_finite()).then_some(manifold)
    }

    /// The corner of B furthest down on A's face across axis `i`, and the point of that face nearest to it.
    fn corner_over_face(&self, i: usize, sign: f32) -> Manifold {
        let normal = unit(i) * sign;
        let corner = self.center + self.axes * self.b.copysign(self.axes_in_b * -normal);
        let mut foot = corner.clamp(-self.a, self.a);
        foot[i] = sign * self.a[i];
        Manifold::single(normal, self.point(foot, corner, normal, LONE))
    }

    fn point(&self, on_a: Vec3, on_b: Vec3, normal: Vec3, feature: u32) -> ManifoldPoint {
        ManifoldPoint { on_a, on_b: self.in_b(on_b), separation: normal.dot(on_b - on_a), feature }
    }

    fn in_b(&self, point: Vec3) -> Vec3 {
        self.axes_in_b * (point - self.center)
    }
}

struct Best {
    separation: f32,
    to_beat: f32,
    at: usize,
}

impl Best {
    #[inline]
    fn offer(&mut self, separation: f32, at: usize, pair: &Pair) {
        if separation > self.to_beat {
            *self = Self { separation, to_beat: separation + pair.lead_over(separation), at };
        }
    }
}

/// A quadrilateral cut to a rectangle.
#[derive(Default)]
struct Clipped {
    vertices: [Vertex; MAX_CLIPPED],
    count: usize,
}

impl Clipped {
    #[inline]
    fn fill(&mut self, polygon: &[Vertex; 4], rectangle: Vec2, slop: f32) {
        let Vec2 { x, y } = rectangle;
        let sides = [(Vec2::X, x), (Vec2::NEG_X, x), (Vec2::Y, y), (Vec2::NEG_Y, y)];
        self.vertices[..4].copy_from_slice(polygon);
        self.count = 4;
        for (edge, (normal, offset)) in (4..).zip(sides) {
            let side = Side { normal, offset, slop, edge };
            if self.vertices[..self.count].iter().all(|vertex| normal.dot(vertex.at) - offset <= slop) {
                continue;
            }
            let (from, count) = (self.vertices, self.count);
            self.count = 0;
            clip(&from[..count], &side, |vertex| {
                // A convex polygon gains one vertex a side; only rounding could offer a ninth.
                if self.count < MAX_CLIPPED {
                    self.vertices[self.count] = vertex;
                    self.count += 1;
                }
            });
        }
    }
}

fn abs(m: &Mat3) -> Mat3 {
    Mat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
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

    fn contact(a: Vec3, b: Vec3, position: Vec3, rotation: Quat, margin: f32) -> Manifold {
        box_box(a, b, &Pose3::from_parts(position, rotation), margin).expect("a contact")
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
                let Some(manifold) = box_box(UNIT, UNIT, &Pose3::from_parts(position, turn), 0.01) else { continue };
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
        assert!(box_box(UNIT, UNIT, &Pose3::from_translation(Vec3::new(0.2, -2.1, 0.1)), 1.0).is_none());
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
