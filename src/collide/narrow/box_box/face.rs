//! Contact points of two boxes that touch with a face: the most opposed face of the other box is clipped against its sides.

use glam::{Vec2, Vec3};

use super::super::clip::{ClipLine, ClipVertex, clip};
use super::super::reduce::{PointCandidate, reduce_into};
use super::super::{MAX_POINTS, Manifold, ManifoldPoint};
use super::axes::FaceAxis;
use super::{AXIS_LEAD, BoxPair, FACE_OF_B, LONE, unit};

/// Most vertices of a quadrilateral clipped to a rectangle.
const MAX_CLIPPED: usize = 8;

/// Cosine between the normal of two edges and that of a face from which on what turns about the edges comes down on the face: beyond half a
/// radian the points of the face are far off.
/// Why: at 0.9 their distance along the one normal is that along the other to a tenth.
/// Scenes: sticks and planks across each other. Test: tests/sticks.rs
const SAME_FACE: f32 = 0.9;

impl BoxPair {
    /// Fills `manifold` with the points over the face not further off than `margin`; returns the separation of the deepest,
    /// infinity if there is nothing over the face.
    #[inline]
    pub(super) fn on_face(&self, face: &FaceAxis, margin: f32, manifold: &mut Manifold) -> f32 {
        if !face.of_b {
            return self.over_face(face.axis, margin, manifold);
        }
        let deepest = self.swapped().over_face(face.axis, margin, manifold);
        manifold.normal = -(self.axes * manifold.normal);
        for point in &mut manifold.points[..usize::from(manifold.count)] {
            *point = ManifoldPoint { on_a: point.on_b, on_b: point.on_a, feature: point.feature | FACE_OF_B, ..*point };
        }
        deepest
    }

    /// Adds to the one point of two edges those over a face whose normal is nearly theirs, as far apart as they are along it: what lies on an edge
    /// and turns about it comes down on the face. Seen only once it overlaps there, a stick on another would roll from edge to edge for ever.
    pub(super) fn add_points_of_face(&self, face: &FaceAxis, margin: f32, manifold: &mut Manifold) {
        let mut over = Manifold::default();
        self.on_face(face, margin, &mut over);
        let cosine = over.normal.dot(manifold.normal);
        if manifold.count != 1 || cosine < SAME_FACE {
            return;
        }
        let first = manifold.points[0];
        // One of four is that of the edges, or near it.
        let beside = |point: &ManifoldPoint| point.on_a.distance_squared(first.on_a);
        let nearest = (0..usize::from(over.count)).min_by(|&i, &j| beside(&over.points[i]).total_cmp(&beside(&over.points[j])));
        for (number, point) in over.contacts().iter().enumerate() {
            if usize::from(over.count) < MAX_POINTS || Some(number) != nearest {
                manifold.push(ManifoldPoint { separation: point.separation * cosine, ..*point });
            }
        }
    }

    /// Like [`on_face`](Self::on_face), for A's face across `axis`. Works in axes of which the third is the face's.
    fn over_face(&self, axis: usize, margin: f32, manifold: &mut Manifold) -> f32 {
        let turn = AxisCycle(axis);
        let half = turn.to_face(self.a);
        let center = turn.to_face(self.center);
        let axes = [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis].map(|axis| turn.to_face(axis));
        let sign = 1.0_f32.copysign(center.z);
        let facing = axes.map(|axis| axis.z * sign);
        let k = (1..3).fold(0, |best, k| if facing[k].abs() > facing[best].abs() + AXIS_LEAD { k } else { best });
        let (p, q) = ((k + 1) % 3, (k + 2) % 3);
        let b = self.b.to_array();
        let middle = center - axes[k] * b[k].copysign(facing[k]);
        let (along_p, along_q) = (axes[p] * b[p], axes[q] * b[q]);
        let vertex = |corner: Vec3, edge: u16| ClipVertex {
            at: Vec2::new(corner.x, corner.y),
            height: sign * corner.z - half.z,
            edge,
            spare: false,
        };
        let (low, high) = (middle - along_q, middle + along_q);
        let mut polygon = Polygon { vertices: [ClipVertex::default(); MAX_CLIPPED], count: 4 };
        polygon.vertices[0] = vertex(low - along_p, 0);
        polygon.vertices[1] = vertex(low + along_p, 1);
        polygon.vertices[2] = vertex(high + along_p, 2);
        polygon.vertices[3] = vertex(high - along_p, 3);
        polygon.clip_to_rectangle(Vec2::new(half.x, half.y), self.slop);

        let names = (axis as u32) << 10 | u32::from(sign > 0.0) << 9 | (k as u32) << 7 | u32::from(facing[k] > 0.0) << 6;
        let place = |vertex: &ClipVertex, feature: u32| {
            let ClipVertex { at, height, .. } = *vertex;
            let from_center = Vec3::new(at.x, at.y, sign * (half.z + height)) - center;
            ManifoldPoint {
                on_a: turn.back(Vec3::new(at.x, at.y, sign * half.z)),
                on_b: Vec3::from_array(axes.map(|axis| axis.dot(from_center))),
                separation: height,
                feature,
            }
        };
        manifold.normal = unit(axis) * sign;
        let mut deepest = f32::INFINITY;
        let mut kept = [(0_u8, 0_u32); MAX_CLIPPED];
        let mut count = 0;
        let vertices = &polygon.vertices[..polygon.count];
        let mut arriving = vertices.last().map_or(0, |vertex| vertex.edge);
        for (i, vertex) in vertices.iter().enumerate() {
            deepest = deepest.min(vertex.height);
            if vertex.height <= margin && !vertex.spare {
                kept[count] = (i as u8, names | u32::from(arriving) << 3 | u32::from(vertex.edge));
                count += 1;
            }
            arriving = vertex.edge;
        }
        let kept = &kept[..count];
        if count <= MAX_POINTS {
            for &(i, feature) in kept {
                manifold.push(place(&vertices[usize::from(i)], feature));
            }
        } else {
            let mut candidates = [PointCandidate::default(); MAX_CLIPPED];
            for (candidate, &(i, feature)) in candidates.iter_mut().zip(kept) {
                let ClipVertex { at, height, .. } = vertices[usize::from(i)];
                let (on_a, on_b) = (Vec3::new(at.x, at.y, 0.0), Vec3::ZERO);
                *candidate = PointCandidate { on_a, on_b, separation: height, feature: u32::from(i) << 16 | feature };
            }
            reduce_into(manifold, &candidates[..count], self.slop, |chosen| {
                place(&vertices[(chosen.feature >> 16) as usize], chosen.feature & 0xffff)
            });
        }
        deepest
    }

    /// The corner of the other box furthest down on a face, and the point of that face nearest to it.
    pub(super) fn corner_over_face(&self, face: &FaceAxis) -> Manifold {
        if face.of_b {
            let pair = self.swapped();
            let mut found = pair.corner_over_face(&FaceAxis { of_b: false, ..*face });
            found.normal = -(self.axes * found.normal);
            std::mem::swap(&mut found.points[0].on_a, &mut found.points[0].on_b);
            found.points[0].feature |= FACE_OF_B;
            return found;
        }
        let sign = 1.0_f32.copysign(self.center[face.axis]);
        let normal = unit(face.axis) * sign;
        let corner = self.center + self.axes * self.b.copysign(self.axes_in_b * -normal);
        let mut foot = corner.clamp(-self.a, self.a);
        foot[face.axis] = sign * self.a[face.axis];
        Manifold::single(normal, self.point(foot, corner, normal, LONE))
    }
}

/// Cyclic change of axes that makes this one the third.
#[derive(Clone, Copy)]
struct AxisCycle(usize);

impl AxisCycle {
    #[inline]
    fn to_face(self, v: Vec3) -> Vec3 {
        match self.0 {
            0 => Vec3::new(v.y, v.z, v.x),
            1 => Vec3::new(v.z, v.x, v.y),
            _ => v,
        }
    }

    #[inline]
    fn back(self, v: Vec3) -> Vec3 {
        match self.0 {
            0 => Vec3::new(v.z, v.x, v.y),
            1 => Vec3::new(v.y, v.z, v.x),
            _ => v,
        }
    }
}

/// A quadrilateral, cut to a rectangle.
struct Polygon {
    vertices: [ClipVertex; MAX_CLIPPED],
    count: usize,
}

impl Polygon {
    #[inline]
    fn clip_to_rectangle(&mut self, half: Vec2, slop: f32) {
        let reach = self.vertices[..4].iter().fold(Vec2::ZERO, |reach, vertex| reach.max(vertex.at.abs()));
        if reach.x - half.x <= slop && reach.y - half.y <= slop {
            return;
        }
        let sides = [(Vec2::X, half.x), (Vec2::NEG_X, half.x), (Vec2::Y, half.y), (Vec2::NEG_Y, half.y)];
        for (edge, (normal, offset)) in (4..).zip(sides) {
            if self.vertices[..self.count].iter().all(|vertex| normal.dot(vertex.at) - offset <= slop) {
                continue;
            }
            let from = Polygon { ..*self };
            self.count = 0;
            clip(&from.vertices[..from.count], &ClipLine { normal, offset, slop, edge }, |vertex| {
                // A convex polygon gains one vertex a side; only rounding could offer a ninth.
                if self.count < MAX_CLIPPED {
                    self.vertices[self.count] = vertex;
                    self.count += 1;
                }
            });
        }
    }
}
