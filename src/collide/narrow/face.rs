//! The face, edge or point of a part that meets another in a given direction.

use glam::Vec3;

use super::part::Part;
use super::segment::Segment;

/// Corners that stand for the rim of a cylinder or cone. They keep their places on the part, so that a resting contact does
/// not turn with the noise of the normal; where the rim is tilted, its deepest point is added by the caller.
const RIM_CORNERS: u16 = 16;

/// A triangle seen at a smaller cosine than this shows its edge.
const EDGE_ON: f32 = 0.2;

/// A corner with an id that is unique on its part.
pub(super) type Corner = (Vec3, u16);

/// What meets the other shape; the corners are in the buffer given to [`find`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Feature {
    /// No corner worth clipping: a ball.
    Point,
    /// Two corners.
    Edge,
    /// Three or more corners in order around the outward normal, either way.
    Face { normal: Vec3 },
}

/// The feature of `part` that faces `direction` (unit, in the part's frame); fills `corners`.
pub(super) fn find(part: &Part, direction: Vec3, corners: &mut Vec<Corner>) -> Feature {
    corners.clear();
    match part {
        Part::Ball { .. } | Part::HalfSpace { .. } => Feature::Point,
        Part::Capsule { half_height, .. } => {
            corners.extend([(Vec3::new(0.0, -half_height, 0.0), 0), (Vec3::new(0.0, *half_height, 0.0), 1)]);
            Feature::Edge
        }
        Part::Box { half_extents } => box_face(*half_extents, direction, corners),
        Part::Cylinder { half_height, radius } => {
            if direction.y.abs() > std::f32::consts::FRAC_1_SQRT_2 {
                return rim(*radius, half_height.copysign(direction.y), corners);
            }
            let foot = across(direction) * *radius;
            corners.extend([(foot - Vec3::Y * *half_height, 0), (foot + Vec3::Y * *half_height, 1)]);
            Feature::Edge
        }
        Part::Cone { half_height, radius } => {
            let radial = (direction.x * direction.x + direction.z * direction.z).sqrt();
            let side =
                (2.0 * half_height * radial + radius * direction.y) / (4.0 * half_height * half_height + radius * radius).sqrt();
            if -direction.y > side {
                return rim(*radius, -half_height, corners);
            }
            corners.extend([(across(direction) * *radius - Vec3::Y * *half_height, 0), (Vec3::Y * *half_height, 1)]);
            Feature::Edge
        }
        Part::Hull(hull) => {
            let face = hull.facing(direction);
            corners.extend(hull.corners(face).iter().map(|&id| (hull.points()[id as usize], id as u16)));
            Feature::Face { normal: face.normal }
        }
        Part::Triangle { triangle, .. } => {
            corners.extend((0..).zip(triangle.vertices()).map(|(id, &corner)| (corner, id)));
            let Some(normal) = triangle.normal() else { return Feature::Point };
            let facing = normal.dot(direction);
            if facing.abs() > EDGE_ON {
                return Feature::Face { normal: normal * 1.0_f32.copysign(facing) };
            }
            let along = |i: usize| corners[i].0.dot(direction);
            let lowest = (1..3).fold(0, |low, i| if along(i) < along(low) { i } else { low });
            corners.remove(lowest);
            Feature::Edge
        }
    }
}

/// Fills `corners` with the points of the surface of `part` that lie on what is nearly flat in the direction `down` (unit, in the part's frame):
/// the corners of a face, the ends of an edge.
pub(super) fn lying(part: &Part, down: Vec3, corners: &mut Vec<Corner>) {
    match find(part, down, corners) {
        Feature::Point => corners.clear(),
        Feature::Face { .. } => {}
        Feature::Edge => {
            let segment = Segment::between(corners[0].0, corners[1].0);
            let rise = down.dot(segment.half);
            let rounding = part.rounding();
            if rounding > 0.0 {
                for (s, (end, _)) in [-1.0, 1.0].into_iter().zip(corners.iter_mut()) {
                    *end += down * segment.depth_of(s, down, rounding);
                }
            }
            // On a steep edge the upper end is far from the plane and adds nothing.
            if 2.0 * rise * rise > segment.half.length_squared() {
                corners.remove(usize::from(rise < 0.0));
            }
        }
    }
}

/// The ends of the edges of the face of a box or hull that faces `direction` (unit, in the part's frame); fills `corners`. What triangles of a
/// surface meet with an edge, their neighbours say.
pub(super) fn edges(part: &Part, direction: Vec3, corners: &mut Vec<Corner>) -> Option<impl Iterator<Item = [Vec3; 2]>> {
    let has_edges = matches!(part, Part::Box { .. } | Part::Hull(_));
    has_edges.then(|| {
        find(part, direction, corners);
        corners.iter().zip(corners.iter().cycle().skip(1)).map(|(from, to)| [from.0, to.0])
    })
}

fn box_face(half: Vec3, direction: Vec3, corners: &mut Vec<Corner>) -> Feature {
    let facing = direction.abs();
    let axis = (1..3).fold(0, |best, i| if facing[i] > facing[best] { i } else { best });
    let sign = 1.0_f32.copysign(direction[axis]);
    let id = (axis as u16 * 2 + u16::from(sign > 0.0)) * 4;
    for (i, (u, v)) in (0..).zip([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) {
        let mut corner = Vec3::ZERO;
        corner[axis] = sign * half[axis];
        corner[(axis + 1) % 3] = u * half[(axis + 1) % 3];
        corner[(axis + 2) % 3] = v * half[(axis + 2) % 3];
        corners.push((corner, id + i));
    }
    let mut normal = Vec3::ZERO;
    normal[axis] = sign;
    Feature::Face { normal }
}

fn rim(radius: f32, y: f32, corners: &mut Vec<Corner>) -> Feature {
    let first = if y > 0.0 { 2 } else { 2 + RIM_CORNERS };
    corners.extend((0..RIM_CORNERS).map(|i| {
        let angle = f32::from(i) * (std::f32::consts::TAU / f32::from(RIM_CORNERS));
        (Vec3::new(radius * libm::cosf(angle), y, radius * libm::sinf(angle)), first + i)
    }));
    Feature::Face { normal: Vec3::new(0.0, 1.0_f32.copysign(y), 0.0) }
}

fn across(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, 0.0, direction.z).try_normalize().unwrap_or(Vec3::X)
}

/// The normal of the face of `part` most aligned with `direction`; none for what has no flat face.
pub(super) fn nearest(part: &Part, direction: Vec3) -> Option<Vec3> {
    match part {
        Part::Box { half_extents: _ } => {
            let facing = direction.abs();
            let axis = (1..3).fold(0, |best, i| if facing[i] > facing[best] { i } else { best });
            let mut normal = Vec3::ZERO;
            normal[axis] = 1.0_f32.copysign(direction[axis]);
            Some(normal)
        }
        Part::Cylinder { .. } => Some(Vec3::new(0.0, 1.0_f32.copysign(direction.y), 0.0)),
        Part::Cone { .. } => Some(Vec3::NEG_Y),
        Part::Hull(hull) => Some(hull.facing(direction).normal),
        Part::Triangle { triangle, .. } => triangle.normal().map(|n| n * 1.0_f32.copysign(n.dot(direction))),
        Part::Ball { .. } | Part::Capsule { .. } | Part::HalfSpace { .. } => None,
    }
}

/// Outward directions in which `part` might touch something centred at `other`, in the part's frame.
pub(super) fn own_directions(part: &Part, other: Vec3, consider: &mut impl FnMut(Vec3)) {
    let aside = Vec3::new(other.x, 0.0, other.z).try_normalize().unwrap_or(Vec3::X);
    match part {
        Part::Ball { .. } | Part::HalfSpace { .. } => {}
        Part::Box { .. } => [Vec3::X, Vec3::Y, Vec3::Z].into_iter().for_each(|n| {
            consider(n);
            consider(-n);
        }),
        Part::Capsule { .. } => consider(aside),
        Part::Cylinder { .. } => [Vec3::Y, Vec3::NEG_Y, aside].into_iter().for_each(consider),
        Part::Cone { half_height, radius } => {
            consider(Vec3::NEG_Y);
            consider((aside * 2.0 * *half_height + Vec3::Y * *radius).normalize());
        }
        Part::Hull(hull) => hull.faces().iter().for_each(|face| consider(face.normal)),
        Part::Triangle { triangle, .. } => {
            let Some(normal) = triangle.normal() else { return };
            consider(normal);
            consider(-normal);
            for edge in triangle.edges_scaled_directions() {
                if let Some(outward) = edge.cross(normal).try_normalize() {
                    consider(outward);
                }
            }
        }
    }
}
