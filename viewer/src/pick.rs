//! Which body is under a point of the window.

use longspan::glam::{DVec3, Vec3};
use longspan_scenes::picture::{Drawn, points_and_triangles};

/// Segments around what is round.
const SEGMENTS: u32 = 12;

/// What passes the ray by no more than this share of its distance from the eye counts as hit where nothing else is: chains are thin.
const NEAR: f32 = 0.02;

/// A ray from the eye, in a frame whose origin is `center`.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Origin of the frame in the world (m).
    pub center: DVec3,
    /// Where the eye is in that frame.
    pub eye: Vec3,
    /// Which way it looks; of length one.
    pub along: Vec3,
}

impl Ray {
    /// The body whose surface it meets first, or else the one whose middle it passes nearest, if it passes one nearly.
    pub fn body<'a>(&self, parts: impl Iterator<Item = &'a (u64, Drawn)>) -> Option<u64> {
        let mut first: Option<(f32, u64)> = None;
        let mut nearest: Option<(f32, u64)> = None;
        for (body, part) in parts {
            let middle = (part.pose.position - self.center).as_vec3() - self.eye;
            let far = middle.dot(self.along);
            let beside = (middle - far * self.along).length() / far.max(f32::MIN_POSITIVE);
            if far > 0.0 && beside < NEAR && nearest.is_none_or(|(other, _)| beside < other) {
                nearest = Some((beside, *body));
            }
            let (points, triangles) = points_and_triangles(&part.geometry, SEGMENTS);
            let back = part.pose.rotation.inverse();
            let (eye, along) = (back * -middle, back * self.along);
            for corners in triangles {
                if let Some(far) = meets(eye, along, corners.map(|corner| points[corner as usize]))
                    && first.is_none_or(|(other, _)| far < other)
                {
                    first = Some((far, *body));
                }
            }
        }
        first.or(nearest).map(|(_, body)| body)
    }
}

/// Distance at which a ray meets a triangle, from either side (Möller and Trumbore 1997).
fn meets(eye: Vec3, along: Vec3, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let across = along.cross(ac);
    let determinant = ab.dot(across);
    let from_a = eye - a;
    let u = from_a.dot(across) / determinant;
    let turned = from_a.cross(ab);
    let v = along.dot(turned) / determinant;
    let far = ac.dot(turned) / determinant;
    // A triangle seen from its edge gives no numbers, and is not met.
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && far > 0.0).then_some(far)
}

#[cfg(test)]
mod tests {
    use longspan::{Geometry, Pose};

    use super::*;

    fn at(x: f64, z: f64, geometry: Geometry) -> Drawn {
        Drawn { geometry, pose: Pose::at_xyz(x, 0.0, z), color: Vec3::ONE }
    }

    #[test]
    fn the_first_surface_counts_and_thin_things_are_found_beside_it() {
        let slab = Geometry::Box { half_extents: Vec3::new(2.0, 2.0, 0.1) };
        let ball = Geometry::Ball { radius: 0.001 };
        let parts = [(1, at(0.0, 0.0, slab.clone())), (2, at(0.0, 1.0, slab)), (3, at(5.0, 0.0, ball))];
        let look = |x: f32| Ray { center: DVec3::ZERO, eye: Vec3::new(x, 0.3, 10.0), along: Vec3::NEG_Z }.body(parts.iter());
        assert_eq!(look(1.9), Some(2), "the nearer of two, far from the middle of either");
        assert_eq!(look(2.5), None);
        let beside = Ray { center: DVec3::ZERO, eye: Vec3::new(5.1, 0.0, 10.0), along: Vec3::NEG_Z };
        assert_eq!(beside.body(parts.iter()), Some(3), "0.1 m beside a grain that is 10 m away");
    }
}
