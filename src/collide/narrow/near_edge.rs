//! The edge of a part that is nearest to a cylinder, in closed form.
//!
//! A search around a side ends within a share of the distance. That turns the normal by the root of the share: hardly by what a contact would
//! feel, but what faces the side then lies beside the edge by as much of the radius, 2 cm of 1 m, and not on it.

use glam::Vec3;
use parry3d::math::Pose3;

use super::convex_pair::ConvexPair;
use super::distance::ConvexGap;
use super::face::Corner;
use super::part::Part;
use super::segment::Segment;
use super::{composite, cylinder, face, parts_of};
use crate::shape::Shape;

/// Cosine between two normals from which on they may be those of one edge.
const SAME_EDGE: f32 = 0.9;

/// Memory for the corners of a face.
pub(crate) type Corners = Vec<Corner>;

/// Where an edge and a cylinder are nearest to each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearestEdge {
    /// Unit vector in the frame of shape A, from A to B.
    pub normal: Vec3,
    /// In the frame of shape A (m).
    pub on_a: Vec3,
    /// In the frame of shape B (m).
    pub on_b: Vec3,
}

/// Where the edge that a manifold with this normal is of is exactly, if it is one of a box or a hull and the other part a cylinder; `relative` is
/// the pose of B in A's frame.
pub(crate) fn nearest_edge(
    a: &Shape,
    b: &Shape,
    part: u32,
    relative: &Pose3,
    normal: Vec3,
    corners: &mut Corners,
) -> Option<NearestEdge> {
    let [of_a, of_b] = parts_of(b, part);
    let (part_a, place_a) = composite::part_at(a, of_a)?;
    let (part_b, place_b) = composite::part_at(b, of_b)?;
    let between = place_a.inverse() * *relative * place_b;
    let pair = ConvexPair::near(&part_a, &part_b, &between, f32::INFINITY)?;
    let gap = pair.at_edge(place_a.rotation.inverse() * normal, corners)?;
    let found = NearestEdge {
        normal: place_a.rotation * gap.normal,
        on_a: place_a * gap.on_a,
        on_b: relative.inverse_transform_point(place_a * gap.on_b),
    };
    (found.normal.dot(normal) >= SAME_EDGE).then_some(found)
}

impl ConvexPair<'_> {
    /// The widest gap between a cylinder and an edge of the face of the other part that looks along `toward`, from A to B.
    fn at_edge(&self, toward: Vec3, corners: &mut Corners) -> Option<ConvexGap> {
        let (relative, inverse) = (self.relative, self.relative.inverse());
        let widest = |gaps: &mut dyn Iterator<Item = ConvexGap>| {
            gaps.filter(|gap| self.is_sound(gap)).reduce(|best, gap| if gap.distance() > best.distance() { gap } else { best })
        };
        match (self.a, self.b) {
            (&Part::Cylinder { half_height, radius }, other) => {
                let edges = face::edges(other, inverse.rotation * -toward, corners)?;
                widest(&mut edges.filter_map(|[from, to]| {
                    let edge = Segment::between(*relative * from, *relative * to);
                    let near = cylinder::nearest_on_edge((half_height, radius), &edge)?;
                    Some(ConvexGap { on_a: near.on_cylinder, on_b: near.on_edge, normal: near.normal })
                }))
            }
            (other, &Part::Cylinder { half_height, radius }) => {
                let edges = face::edges(other, toward, corners)?;
                widest(&mut edges.filter_map(|[from, to]| {
                    let edge = Segment::between(inverse * from, inverse * to);
                    let near = cylinder::nearest_on_edge((half_height, radius), &edge)?;
                    let normal = relative.rotation * -near.normal;
                    Some(ConvexGap { on_a: *relative * near.on_edge, on_b: *relative * near.on_cylinder, normal })
                }))
            }
            _ => None,
        }
    }
}
