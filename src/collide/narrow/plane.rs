//! Where two features face each other: a plane across the normal, with features as outlines and heights over it.

use glam::{Vec2, Vec3};

use super::clip::{ClipLine, ClipVertex, clip_segment};
use super::face::Corner;
use super::segment::Segment;

/// A face seen at a smaller cosine than this is not clipped: heights on it would be extrapolated.
const MIN_FACING: f32 = 0.2;

/// Bit of an edge id: a side of the clipping polygon.
const CLIPPING: u16 = 1 << 15;

/// The plane of contact and its axes.
pub(super) struct ContactPlane {
    u: Vec3,
    v: Vec3,
    normal: Vec3,
}

/// Height of a face over the plane of contact.
pub(super) struct Slope {
    gradient: Vec2,
    height: f32,
}

impl Slope {
    pub fn height(&self, at: Vec2) -> f32 {
        self.height + self.gradient.dot(at)
    }
}

impl ContactPlane {
    pub fn across(normal: Vec3) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        Self { u, v, normal }
    }

    pub fn flat(&self, point: Vec3) -> Vec2 {
        Vec2::new(self.u.dot(point), self.v.dot(point))
    }

    pub fn point(&self, at: Vec2, height: f32) -> Vec3 {
        self.u * at.x + self.v * at.y + self.normal * height
    }

    pub fn vertex(&self, &(corner, id): &Corner) -> ClipVertex {
        ClipVertex { at: self.flat(corner), height: self.normal.dot(corner), edge: id, spare: false }
    }

    /// The face through `point`; none if it is seen too much from the side.
    pub fn slope(&self, face: Vec3, point: Vec3) -> Option<Slope> {
        let facing = face.dot(self.normal);
        (facing.abs() >= MIN_FACING).then(|| Slope { gradient: self.flat(face) / -facing, height: face.dot(point) / facing })
    }

    /// The sides of a convex polygon.
    pub fn sides<'a>(&'a self, corners: &'a [Corner], slop: f32) -> impl Iterator<Item = ClipLine> + 'a {
        let at = move |i: usize| self.flat(corners[i % corners.len()].0);
        let area: f32 = (1..corners.len() - 1).map(|i| (at(i) - at(0)).perp_dot(at(i + 1) - at(0))).sum();
        let sense = 1.0_f32.copysign(area);
        (0..corners.len()).filter_map(move |i| {
            let along = (at(i + 1) - at(i)).try_normalize()?;
            let normal = -along.perp() * sense;
            Some(ClipLine { normal, offset: normal.dot(at(i)), slop, edge: CLIPPING | corners[i].1 })
        })
    }

    /// Whether a point is over a face, or no further than `overhang` outside; over an edge, it always is.
    pub fn is_over(&self, corners: &[Corner], point: Vec3, overhang: f32) -> bool {
        corners.len() < 3 || self.sides(corners, overhang).all(|side| side.normal.dot(self.flat(point)) <= side.offset + overhang)
    }

    /// The ends of the part of an edge that lies over a face; none if it rather stands there.
    pub fn lie(&self, segment: &Segment, edge: &[Corner], face: &[Corner], slop: f32) -> Option<[Vec3; 2]> {
        let rise = self.normal.dot(segment.half);
        if 2.0 * rise * rise > segment.half.length_squared() {
            return None;
        }
        let ends = [self.vertex(&edge[0]), self.vertex(&edge[1])];
        let cut = self.sides(face, slop).try_fold(ends, |ends, side| clip_segment(ends, &side))?;
        Some(cut.map(|end| self.point(end.at, end.height)))
    }
}
