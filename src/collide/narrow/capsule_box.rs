//! A capsule against a box: the capsule's inner segment against the box, then its radius.
//!
//! The box swept along the segment has six faces of its own and those that the segment draws out of the box's edges. While
//! the segment cuts the box, the nearest of them is the way out, exactly. Outside, the closest points are on one of the
//! segment's ends or on one of the box's edges. On a face, and along an edge, both ends of the common stretch touch; also
//! where a capsule that lies on a face slightly tilted is nearest to the rim.

use glam::{Mat3, Vec3};
use parry3d::math::Pose3;

use super::segment::Segment;
use super::{Manifold, ManifoldPoint};

/// An edge must beat a face by this fraction of the smaller shape, so that a capsule lying on a face keeps it.
const FACE_PREFERENCE: f32 = 1.0e-5;

/// Squared sine between a segment and a box edge below which they have no common normal.
const PARALLEL: f32 = 1.0e-8;

/// A normal that leans less than this (rad) from a face's is that face's.
const SNAP: f32 = 1.0e-3;

/// A normal that leans less than this (sine of 2.5°) from a face's gives way to it if the capsule then lies on two points.
/// Distances along the face's normal are up to 1/cos 2.5° those along the other: the fraction of gap and radius allowed for.
const FACE_LEAN: f32 = 0.0436;
const FACE_TILT: f32 = 1.0e-3;

/// Component of a normal below which it stands across a box edge.
const ACROSS: f32 = 1.0e-3;

/// Feature of a contact that is not one end of a line of contact.
const MIDDLE: u32 = 2;

/// Capsule B (half height and radius, m) against box A.
pub(super) fn box_capsule(half: Vec3, (half_height, radius): (f32, f32), relative: &Pose3, margin: f32) -> Option<Manifold> {
    let segment = Segment::of_capsule(half_height, relative);
    let tolerance =
        FACE_PREFERENCE * half.min_element().min(half_height + radius) + 4.0 * f32::EPSILON * (half.max_element() + half_height);
    let way_out = way_out(half, &segment, tolerance, margin + radius)?;

    let mut contact = CapsuleBoxContact { half, segment, radius, margin, tolerance, relative, manifold: Manifold::default() };
    if way_out.separation > tolerance {
        contact.apart();
    } else if let Some(axis) = way_out.face {
        contact.on_face(axis, way_out.normal);
    } else {
        contact.on_edge(way_out.normal, way_out.separation);
    }
    (contact.manifold.count > 0).then_some(contact.manifold)
}

struct WayOut {
    normal: Vec3,
    separation: f32,
    face: Option<usize>,
}

/// The axis along which segment and box overlap least or are furthest apart; none if further than `limit`.
fn way_out(half: Vec3, segment: &Segment, tolerance: f32, limit: f32) -> Option<WayOut> {
    let (t, u) = (segment.center, segment.half);
    let over_faces = t.abs() - half - u.abs();
    let near = over_faces.max_element() <= limit;
    if !near {
        return None;
    }
    let face = (1..3).fold(0, |best, i| if over_faces[i] > over_faces[best] + tolerance { i } else { best });
    let mut best = WayOut { normal: axis_towards(face, t[face]), separation: over_faces[face], face: Some(face) };
    let mut to_beat = best.separation + tolerance;
    for i in 0..3 {
        let cross = Mat3::IDENTITY.col(i).cross(u);
        let squared = cross.length_squared();
        if squared <= PARALLEL * u.length_squared() {
            continue;
        }
        let axis = cross / squared.sqrt();
        let along = t.dot(axis);
        let separation = along.abs() - half.dot(axis.abs());
        if separation > limit {
            return None;
        }
        if separation > to_beat {
            to_beat = separation;
            best = WayOut { normal: axis * 1.0_f32.copysign(along), separation, face: None };
        }
    }
    Some(best)
}

fn axis_towards(axis: usize, sign: f32) -> Vec3 {
    let mut normal = Vec3::ZERO;
    normal[axis] = 1.0_f32.copysign(sign);
    normal
}

/// The box edge that reaches furthest along `normal`, parallel to `axis`.
fn edge(half: Vec3, axis: usize, normal: Vec3) -> Segment {
    let mut center = Vec3::new(half.x.copysign(normal.x), half.y.copysign(normal.y), half.z.copysign(normal.z));
    let mut along = Vec3::ZERO;
    center[axis] = 0.0;
    along[axis] = half[axis];
    Segment { center, half: along }
}

/// The axis of the face most aligned with a unit normal, and the sine between them.
fn nearest_face(normal: Vec3) -> (usize, f32) {
    let facing = normal.abs();
    let axis = (1..3).fold(0, |best, i| if facing[i] > facing[best] { i } else { best });
    let mut lean = normal;
    lean[axis] = 0.0;
    (axis, lean.length())
}

fn smallest_component(v: Vec3) -> usize {
    let v = v.abs();
    if v.x <= v.y && v.x <= v.z {
        0
    } else if v.y <= v.z {
        1
    } else {
        2
    }
}

struct CapsuleBoxContact<'a> {
    half: Vec3,
    segment: Segment,
    radius: f32,
    margin: f32,
    tolerance: f32,
    relative: &'a Pose3,
    manifold: Manifold,
}

impl CapsuleBoxContact<'_> {
    /// The segment is outside the box: the closest points decide the normal, and the normal where to look for a second point.
    fn apart(&mut self) {
        let (on_box, on_segment) = self.closest();
        let offset = on_segment - on_box;
        let distance = offset.length();
        let near = distance - self.radius <= self.margin;
        if !near {
            return;
        }
        let normal = offset / distance;
        let (axis, lean) = nearest_face(normal);
        if lean <= SNAP {
            self.on_face(axis, axis_towards(axis, normal[axis]));
            return;
        }
        if self.lies_on_face(normal, distance - self.radius) {
            return;
        }
        self.manifold.normal = normal;
        let axis = smallest_component(normal);
        if normal[axis].abs() < ACROSS
            && let Some(ends) = edge(self.half, axis, normal).side_by_side(&self.segment, normal, self.radius)
        {
            let low_first = self.segment.half[axis] >= 0.0;
            for (i, (on_box, on_segment)) in ends.into_iter().enumerate() {
                self.push(on_box, on_segment, u32::from((i == 0) != low_first));
            }
        } else {
            self.push(on_box, on_segment, MIDDLE);
        }
    }

    /// Fills the manifold if the capsule lies on the face next to `normal`, nearly as near as `separation` (m) along it.
    fn lies_on_face(&mut self, normal: Vec3, separation: f32) -> bool {
        let (axis, lean) = nearest_face(normal);
        if lean > FACE_LEAN {
            return false;
        }
        self.on_face(axis, axis_towards(axis, normal[axis]));
        let deepest = self.manifold.contacts().iter().fold(f32::INFINITY, |least, point| least.min(point.separation));
        let lies =
            self.manifold.count == 2 && deepest <= separation + FACE_TILT * (separation.abs() + self.radius) + self.tolerance;
        if !lies {
            self.manifold = Manifold::default();
        }
        lies
    }

    /// The part of the segment over the face: its ends carry the contact.
    fn on_face(&mut self, axis: usize, normal: Vec3) {
        self.manifold.normal = normal;
        let (mut low, mut high) = (-1.0_f32, 1.0_f32);
        for side in [(axis + 1) % 3, (axis + 2) % 3] {
            let (t, u, h) = (self.segment.center[side], self.segment.half[side], self.half[side]);
            let (one, other) = ((-h - t) / u, (h - t) / u);
            if one.is_finite() && other.is_finite() {
                low = low.max(one.min(other));
                high = high.min(one.max(other));
            }
        }
        let foot = |on_segment: Vec3| {
            let mut on_box = on_segment.clamp(-self.half, self.half);
            on_box[axis] = self.half[axis] * normal[axis];
            on_box
        };
        if low >= high {
            // Only rounding leaves the face empty: the end nearest to it stands for all.
            let end = self.segment.at(if self.segment.half.dot(normal) > 0.0 { -1.0 } else { 1.0 });
            self.push(foot(end), end, MIDDLE);
            return;
        }
        let ends = [low, high].map(|s| self.segment.at(s));
        let feet = ends.map(foot);
        // One above the other, the higher of two points adds nothing.
        let rise = normal.dot(ends[1] - ends[0]);
        let steep = rise.abs() > (feet[1] - feet[0]).length();
        for (i, s) in [low, high].into_iter().enumerate() {
            if !(steep && (i == 1) == (rise > 0.0)) {
                let depth = self.segment.depth_of(s, -normal, self.radius);
                self.push_at(feet[i], ends[i], depth, i as u32);
            }
        }
    }

    /// The segment crosses one of the box's edges.
    fn on_edge(&mut self, normal: Vec3, separation: f32) {
        if self.lies_on_face(normal, separation - self.radius) {
            return;
        }
        self.manifold.normal = normal;
        let edge = edge(self.half, smallest_component(normal), normal);
        let (s, t) = edge.closest(&self.segment);
        self.push(edge.at(s), self.segment.at(t), MIDDLE);
    }

    /// Closest points of the box and a segment outside it: at an end of the segment or on an edge of the box.
    fn closest(&self) -> (Vec3, Vec3) {
        let ends = [self.segment.at(-1.0), self.segment.at(1.0)];
        let at_ends = ends.map(|end| (end.clamp(-self.half, self.half), end));
        let on_edges = (0..12).map(|i| {
            let axis = i >> 2;
            let mut toward = Vec3::ZERO;
            toward[(axis + 1) % 3] = sign(i & 1);
            toward[(axis + 2) % 3] = sign(i & 2);
            let edge = edge(self.half, axis, toward);
            let (s, t) = edge.closest(&self.segment);
            (edge.at(s), self.segment.at(t))
        });
        let gap = |pair: &(Vec3, Vec3)| pair.0.distance_squared(pair.1);
        let [first, second] = at_ends;
        std::iter::once(second).chain(on_edges).fold(first, |best, pair| if gap(&pair) < gap(&best) { pair } else { best })
    }

    fn push(&mut self, on_box: Vec3, on_segment: Vec3, feature: u32) {
        self.push_at(on_box, on_segment, self.radius, feature);
    }

    /// A point whose surface is `depth` (m) below the segment.
    fn push_at(&mut self, on_box: Vec3, on_segment: Vec3, depth: f32, feature: u32) {
        let normal = self.manifold.normal;
        let separation = normal.dot(on_segment - on_box) - depth;
        if separation <= self.margin {
            let on_b = self.relative.inverse_transform_point(on_segment - normal * depth);
            self.manifold.push(ManifoldPoint { on_a: on_box, on_b, separation, feature });
        }
    }
}

fn sign(bit: usize) -> f32 {
    if bit == 0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

    const HALF: Vec3 = Vec3::new(1.0, 0.5, 2.0);

    fn contact(x: f32, y: f32, z: f32, rotation: Quat, margin: f32) -> Manifold {
        let relative = Pose3::from_parts(Vec3::new(x, y, z), rotation);
        box_capsule(HALF, (0.75, 0.25), &relative, margin).expect("a contact")
    }

    #[test]
    fn a_capsule_lying_on_a_face_touches_at_both_ends() {
        let manifold = contact(0.1, 0.74, 0.2, Quat::from_rotation_z(FRAC_PI_2), 0.0);
        assert_eq!((manifold.count, manifold.normal), (2, Vec3::Y));
        for point in manifold.contacts() {
            assert!((point.separation + 0.01).abs() < 1e-6, "{} m", point.separation);
            assert!(point.on_a.y == 0.5 && (point.on_a.z - 0.2).abs() < 1e-6, "point {}", point.on_a);
        }
        let span = (manifold.points[0].on_a.x - manifold.points[1].on_a.x).abs();
        assert!((span - 1.5).abs() < 1e-6, "span {span} m");
    }

    #[test]
    fn a_capsule_over_the_rim_touches_at_its_end_and_at_the_rim() {
        let manifold = contact(0.9, 0.74, 0.2, Quat::from_rotation_z(FRAC_PI_2), 0.0);
        let mut x: Vec<_> = manifold.contacts().iter().map(|p| p.on_a.x).collect();
        x.sort_by(f32::total_cmp);
        assert!(x.len() == 2 && (x[0] - 0.15).abs() < 1e-6 && (x[1] - 1.0).abs() < 1e-6, "points at {x:?} m");
    }

    #[test]
    fn a_capsule_standing_on_a_face_touches_once() {
        let manifold = contact(0.1, 1.6, 0.2, Quat::IDENTITY, 10.0);
        assert_eq!((manifold.count, manifold.normal), (1, Vec3::Y));
        assert!((manifold.points[0].separation - 0.1).abs() < 1e-6, "{} m", manifold.points[0].separation);
    }

    #[test]
    fn a_capsule_beside_an_edge_touches_along_it() {
        let manifold = contact(1.3, 0.9, 1.0, Quat::from_rotation_x(FRAC_PI_2), 1.0);
        assert!((manifold.normal - Vec3::new(0.6, 0.8, 0.0)).length() < 1e-6, "normal {}", manifold.normal);
        let mut z: Vec<_> = manifold.contacts().iter().map(|p| p.on_a.z).collect();
        z.sort_by(f32::total_cmp);
        assert!(z.len() == 2 && (z[0] - 0.25).abs() < 1e-5 && (z[1] - 1.75).abs() < 1e-5, "points at {z:?} m");
        for point in manifold.contacts() {
            assert!((point.separation - 0.25).abs() < 1e-6, "{} m", point.separation);
        }
    }

    #[test]
    fn a_capsule_across_an_edge_touches_once() {
        // Tilted by 45° in the x–y plane, its axis 0.3 m off the edge x = 1, y = 0.5.
        let out = 0.3 * std::f32::consts::FRAC_1_SQRT_2;
        let manifold = contact(1.0 + out, 0.5 + out, 0.0, Quat::from_rotation_z(FRAC_PI_4), 1.0);
        let expected = Vec3::new(1.0, 1.0, 0.0).normalize();
        assert_eq!(manifold.count, 1);
        assert!((manifold.normal - expected).length() < 1e-5, "normal {}", manifold.normal);
        assert!((manifold.points[0].separation - 0.05).abs() < 1e-6, "{} m", manifold.points[0].separation);
    }

    #[test]
    fn a_capsule_deep_inside_leaves_by_the_nearest_face_or_edge() {
        let manifold = contact(0.0, 0.1, 0.0, Quat::from_rotation_x(FRAC_PI_2), 0.0);
        assert_eq!((manifold.count, manifold.normal), (2, Vec3::Y));
        assert!((manifold.points[0].separation + 0.65).abs() < 1e-6, "{} m", manifold.points[0].separation);
        let center = box_capsule(HALF, (0.75, 0.25), &Pose3::IDENTITY, 0.0).expect("a contact");
        assert_eq!((center.count, center.normal), (2, Vec3::X));
        assert!((center.points[0].separation + 1.25).abs() < 1e-6, "{} m", center.points[0].separation);
    }
}
