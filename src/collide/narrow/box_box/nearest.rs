//! An edge against an edge, and the nearest points of boxes that no axis describes.

use glam::Vec3;
use parry3d::math::Pose3;
use parry3d::shape::Cuboid;

use super::super::Manifold;
use super::super::distance::{self, ConvexGap};
use super::super::segment::Segment;
use super::axes::EdgeAxis;
use super::{BoxPair, EDGES, LINE, LONE, edge, within};

impl BoxPair {
    /// The contact of two crossing edges, or what is nearest where they do not face each other.
    pub(super) fn on_edges(&self, axis: &EdgeAxis, relative: &Pose3, margin: f32) -> Option<Manifold> {
        let normal = axis.normal;
        let on_a = edge(self.a, axis.a, normal);
        let local = edge(self.b, axis.b, self.axes_in_b * -normal);
        let on_b = Segment { center: self.center + self.axes * local.center, half: self.axes * local.half };
        let (s, t) = on_a.closest(&on_b);
        let (point_a, point_b) = (on_a.at(s), on_b.at(t));
        let offset = point_b - point_a;
        let separation = normal.dot(offset);
        let facing = offset.length() <= separation + self.slack(separation);
        if !facing
            && axis.separation > 0.0
            && let Some(found) = self.nearest(relative)
        {
            return within(found, margin);
        }
        let side = |n: Vec3| u32::from(n.x > 0.0) | u32::from(n.y > 0.0) << 1 | u32::from(n.z > 0.0) << 2;
        let feature = EDGES | (3 * axis.a + axis.b) as u32 | side(on_a.center) << 4 | side(local.center) << 7;
        within(Manifold::single(normal, self.point(point_a, point_b, normal, feature)), margin)
    }

    /// The contact of boxes apart along `normal` whose edges run side by side there: both ends of the stretch where they do. A single
    /// point would lie anywhere on it, by rounding, and turn what it pushes.
    fn along_edges(&self, normal: Vec3) -> Option<Manifold> {
        let (on_a, on_b) = self.edges_across(normal);
        let ends = on_a.side_by_side(&on_b, normal, self.a.min_element().min(self.b.min_element()))?;
        let mut manifold = Manifold { normal, ..Manifold::default() };
        for (feature, (end_a, end_b)) in (LINE..).zip(ends) {
            manifold.push(self.point(end_a, end_b, normal, feature));
        }
        manifold.is_finite().then_some(manifold)
    }

    /// The edges of A and of B that lie most across `normal`, on the sides that face each other along it.
    fn edges_across(&self, normal: Vec3) -> (Segment, Segment) {
        let in_b = self.axes_in_b * normal;
        let (on_a, local) = (edge(self.a, least_axis(normal), normal), edge(self.b, least_axis(in_b), -in_b));
        (on_a, Segment { center: self.center + self.axes * local.center, half: self.axes * local.half })
    }

    /// Boxes apart whose nearest features face each other along none of the axes.
    pub(super) fn nearest(&self, relative: &Pose3) -> Option<Manifold> {
        let scale = 1.0 / self.a.max_element().min(self.b.max_element());
        let scaled = Pose3::from_parts(self.center * scale, relative.rotation);
        let gap = distance::apart(&Cuboid::new(self.a * scale), &Cuboid::new(self.b * scale), &scaled);
        let gap = gap.map(|gap| ConvexGap { on_a: gap.on_a / scale, on_b: gap.on_b / scale, ..gap });
        let gap = gap.filter(|gap| self.proves(gap)).or_else(|| self.nearest_features())?;
        if let Some(line) = self.along_edges(gap.normal) {
            return Some(line);
        }
        let point = self.point(gap.on_a, gap.on_b, gap.normal, LONE);
        let manifold = Manifold::single(gap.normal, point);
        manifold.is_finite().then_some(manifold)
    }

    /// Whether the boxes are as far apart along the normal as the points are from each other. GJK sometimes stops short.
    fn proves(&self, gap: &ConvexGap) -> bool {
        let offset = gap.on_b - gap.on_a;
        let reach_a = self.a.dot(gap.normal.abs());
        let reach_b = self.b.dot((self.axes_in_b * gap.normal).abs());
        let proven = self.center.dot(gap.normal) - reach_a - reach_b;
        offset.length() - proven <= self.lead_over(proven)
    }

    /// The nearest points, by trying every corner against every face and every edge against every edge.
    fn nearest_features(&self) -> Option<ConvexGap> {
        let mut best = (f32::INFINITY, Vec3::ZERO, Vec3::ZERO);
        let mut offer = |on_a: Vec3, on_b: Vec3| {
            let squared = on_a.distance_squared(on_b);
            if squared < best.0 {
                best = (squared, on_a, on_b);
            }
        };
        for corner in 0..8 {
            let signs = Vec3::new(sign(corner & 1), sign(corner & 2), sign(corner & 4));
            let of_a = self.a * signs;
            offer(of_a, self.center + self.axes * self.in_b(of_a).clamp(-self.b, self.b));
            let of_b = self.center + self.axes * (self.b * signs);
            offer(of_b.clamp(-self.a, self.a), of_b);
        }
        for i in 0..12 {
            let of_a = nth_edge(self.a, i);
            for j in 0..12 {
                let local = nth_edge(self.b, j);
                let of_b = Segment { center: self.center + self.axes * local.center, half: self.axes * local.half };
                let (s, t) = of_a.closest(&of_b);
                offer(of_a.at(s), of_b.at(t));
            }
        }
        let (_, on_a, on_b) = best;
        Some(ConvexGap { on_a, on_b, normal: (on_b - on_a).try_normalize()? })
    }
}

/// One of the four edges along each of the three axes.
fn nth_edge(half: Vec3, n: usize) -> Segment {
    let axis = n / 4;
    let mut direction = Vec3::ZERO;
    direction[(axis + 1) % 3] = sign(n & 1);
    direction[(axis + 2) % 3] = sign(n & 2);
    edge(half, axis, direction)
}

/// The axis along which a vector has least.
fn least_axis(v: Vec3) -> usize {
    v.abs().min_position()
}

fn sign(bit: usize) -> f32 {
    if bit == 0 { -1.0 } else { 1.0 }
}
