//! How a shape's surface curves where it touches another.

use glam::{Mat3, Vec3};

use crate::shape::{Geometry, Shape};

/// How far a normal may lean from that of a flat face, or of a cylinder's side, and still be of it (squared sine).
const LEAN: f32 = 1.0e-6;

/// Squared sine of the angle between an edge and the axis of what lies along it, at most: by half of it the radius across the edge is off.
const ALONG: f32 = 1.0e-2;

/// The shape operator of the surface at the point `at` (m) with the outward unit normal, all in the shape's frame: by how much the
/// normal turns per length along the surface (1/m). Zero on a flat face; none at edges and corners, on rims and on shapes of several
/// parts.
pub(crate) fn shape_operator(shape: &Shape, at: Vec3, outward: Vec3) -> Option<Mat3> {
    match *shape.geometry() {
        Geometry::Ball { radius } => Some(round(outward, radius)),
        Geometry::Capsule { half_height, radius } if at.y.abs() > half_height => Some(round(outward, radius)),
        Geometry::Capsule { radius, .. } => side(outward, radius),
        Geometry::Cylinder { radius, .. } if outward.y * outward.y < LEAN => side(outward, radius),
        Geometry::Cylinder { .. } => flat(outward.x * outward.x + outward.z * outward.z),
        Geometry::Box { .. } => flat(1.0 - outward.abs().max_element().powi(2)),
        Geometry::HalfSpace { .. } => Some(Mat3::ZERO),
        _ => None,
    }
}

/// Radius that the rim of a cylinder is taken to have, over the cylinder's.
const SHARP: f32 = 1.0e-6;

/// The same on rims of cylinders too: there the normal turns by any angle over next to no way.
pub(crate) fn shape_operator_with_rims(shape: &Shape, at: Vec3, outward: Vec3) -> Option<Mat3> {
    shape_operator(shape, at, outward).or_else(|| {
        let Geometry::Cylinder { radius, .. } = *shape.geometry() else { return None };
        let around = Vec3::Y.cross(outward).try_normalize()?;
        let bend = outward.reject_from_normalized(Vec3::Y).length() / radius;
        Some(product(around) * bend + product(outward.cross(around)) * (radius * SHARP).recip())
    })
}

/// The outward unit normal of the surface at the point `at` (m), in the shape's frame; `outward` is near it, and is it at edges, on rims and
/// on shapes of which it is not known.
pub(crate) fn normal_at(shape: &Shape, at: Vec3, outward: Vec3) -> Vec3 {
    let from = match *shape.geometry() {
        Geometry::Ball { .. } => at,
        Geometry::Capsule { half_height, .. } => at - Vec3::Y * at.y.clamp(-half_height, half_height),
        Geometry::Cylinder { .. } if outward.y * outward.y < LEAN => Vec3::new(at.x, 0.0, at.z),
        Geometry::Cylinder { .. } if outward.x * outward.x + outward.z * outward.z < LEAN => Vec3::new(0.0, outward.y, 0.0),
        Geometry::Box { .. } if 1.0 - outward.abs().max_element().powi(2) < LEAN => outward.round(),
        _ => outward,
    };
    from.normalize()
}

/// Whether it is a box or a capsule, all of which lies within a radius of a box or of a line.
pub(crate) fn is_block(shape: &Shape) -> bool {
    matches!(shape.geometry(), Geometry::Box { .. } | Geometry::Capsule { .. })
}

/// Half sizes of that box, or line, and the radius about it (m).
pub(crate) fn block_size(shape: &Shape) -> (Vec3, f32) {
    match *shape.geometry() {
        Geometry::Box { half_extents } => (half_extents, 0.0),
        Geometry::Capsule { half_height, radius } => (Vec3::Y * half_height, radius),
        _ => (Vec3::ZERO, 0.0),
    }
}

/// The direction of the edge of a box that this outward unit normal is of, in the box's frame; none where it is that of a face or a corner.
pub(crate) fn edge_of(shape: &Shape, outward: Vec3) -> Option<Vec3> {
    let size = outward.abs();
    if !matches!(shape.geometry(), Geometry::Box { .. }) || size.max_element().powi(2) >= 1.0 - LEAN {
        return None;
    }
    let along = Vec3::AXES.into_iter().find(|axis| size.dot(*axis) == size.min_element())?;
    (size.min_element().powi(2) < LEAN).then_some(along)
}

/// How round a shape is where it goes over a block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoundPart {
    pub radius: f32,
    /// Whether it is a ball about the middle of the shape, or else round about the inward normal.
    pub is_ball: bool,
}

/// How round a shape is at the point `at` (m) with this outward unit normal, where it goes over a block, or over an edge of it in this direction, all
/// in the shape's frame; none where it is not, or does not lie along the edge.
pub(crate) fn radius_over(shape: &Shape, at: Vec3, outward: Vec3, edge: Option<Vec3>) -> Option<RoundPart> {
    let lies = edge.is_some_and(|edge| edge.y * edge.y > 1.0 - ALONG && outward.y * outward.y < LEAN);
    match *shape.geometry() {
        Geometry::Ball { radius } => Some(RoundPart { radius, is_ball: true }),
        Geometry::Capsule { half_height, radius } if at.y.abs() <= half_height && lies => {
            Some(RoundPart { radius, is_ball: false })
        }
        Geometry::Cylinder { radius, .. } if lies => Some(RoundPart { radius, is_ball: false }),
        _ => None,
    }
}

fn round(outward: Vec3, radius: f32) -> Mat3 {
    (Mat3::IDENTITY - product(outward)) * radius.recip()
}

/// Curved about the y axis alone.
fn side(outward: Vec3, radius: f32) -> Option<Mat3> {
    Vec3::Y.cross(outward).try_normalize().map(|around| product(around) * radius.recip())
}

fn flat(lean: f32) -> Option<Mat3> {
    (lean < LEAN).then_some(Mat3::ZERO)
}

fn product(a: Vec3) -> Mat3 {
    Mat3::from_cols(a * a.x, a * a.y, a * a.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The normal turns by the operator times the way, on every shape whose surface is known as the gradient of a distance.
    #[test]
    fn normals_turn_as_the_operator_says() {
        let cylinder = Shape::new(Geometry::Cylinder { half_height: 1.0, radius: 0.5 }).unwrap();
        let around_y = |p: Vec3| Vec3::new(p.x, 0.0, p.z).normalize();
        type Normal = fn(Vec3) -> Vec3;
        let cases: [(Shape, Vec3, Normal); 4] = [
            (Shape::ball(0.5).unwrap(), Vec3::new(0.3, 0.4, 0.0), |p| p.normalize()),
            (Shape::capsule(1.0, 0.5).unwrap(), Vec3::new(0.3, 0.7, 0.4), |p| Vec3::new(p.x, 0.0, p.z).normalize()),
            (Shape::capsule(1.0, 0.5).unwrap(), Vec3::new(0.3, 1.4, 0.0), |p| (p - Vec3::Y).normalize()),
            (cylinder, Vec3::new(0.3, -0.2, 0.4), around_y),
        ];
        for (shape, at, normal) in cases {
            let operator = shape_operator(&shape, at, normal(at)).expect("a smooth point");
            for tangent in [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis.reject_from_normalized(normal(at))) {
                let step = 1e-3;
                let turned = (normal(at + tangent * step) - normal(at - tangent * step)) / (2.0 * step);
                assert!((turned - operator * tangent).length() < 2e-3, "{turned} along {tangent}, operator {operator}");
            }
        }
    }

    /// Along a rim the normal turns as the rim bends, across it by any angle.
    #[test]
    fn rims_turn_across_themselves() {
        let disc = Shape::new(Geometry::Cylinder { half_height: 1.0, radius: 2.0 }).unwrap();
        let leaning = Vec3::new(1.0, 1.0, 0.0).normalize();
        let operator = shape_operator_with_rims(&disc, Vec3::new(2.0, 1.0, 0.0), leaning).expect("a rim");
        let bend = leaning.x / 2.0;
        assert!((operator * Vec3::Z - Vec3::Z * bend).length() < 1.0e-6, "{operator}, expected {bend} about the rim");
        assert!((operator * Vec3::new(1.0, -1.0, 0.0)).length() > 1.0e5, "{operator}");
        assert_eq!(shape_operator_with_rims(&Shape::cuboid(Vec3::ONE).unwrap(), Vec3::new(1.0, 1.0, 0.3), leaning), None);
    }

    #[test]
    fn edges_and_rims_have_none() {
        let corner = Vec3::new(1.0, 1.0, 0.0).normalize();
        let cuboid = Shape::cuboid(Vec3::ONE).unwrap();
        assert_eq!(shape_operator(&cuboid, Vec3::new(1.0, 1.0, 0.0), corner), None);
        assert_eq!(shape_operator(&cuboid, Vec3::X, Vec3::X), Some(Mat3::ZERO));
        let cylinder = Shape::new(Geometry::Cylinder { half_height: 1.0, radius: 1.0 }).unwrap();
        assert_eq!(shape_operator(&cylinder, Vec3::new(1.0, 1.0, 0.0), corner), None);
        assert_eq!(shape_operator(&cylinder, Vec3::Y, Vec3::Y), Some(Mat3::ZERO));
    }
}
