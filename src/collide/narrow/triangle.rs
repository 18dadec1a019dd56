//! A ball or a box against a triangle of a mesh or height field, through parry3d: it knows in which directions a triangle's
//! neighbours let it push, so that nothing stumbles over the seams of a smooth surface.

use parry3d::math::Pose3;
use parry3d::query::details::NormalConstraints;
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d::shape::{Ball, Cuboid, Shape, Triangle, TrianglePseudoNormals};

use super::part::Part;
use super::reduce::{PointCandidate, reduce_into};
use super::{Manifold, ManifoldPoint};

/// Depths within this fraction of the part's reach count as equal.
const TIE: f32 = 1.0e-4;

/// Reused from call to call, for its memory only.
pub(super) type TriangleBuffer = (ContactManifold<(), ()>, Vec<PointCandidate>);

/// Ball or box B against triangle A.
pub(super) fn collide(
    triangle: &Triangle,
    constraints: Option<&TrianglePseudoNormals>,
    part: &Part,
    relative: &Pose3,
    margin: f32,
    (found, candidates): &mut TriangleBuffer,
) -> Option<Manifold> {
    let (ball, cuboid);
    let shape: &dyn Shape = match *part {
        Part::Ball { radius } => {
            ball = Ball::new(radius);
            &ball
        }
        Part::Box { half_extents } => {
            cuboid = Cuboid::new(half_extents);
            &cuboid
        }
        _ => return None,
    };
    // parry reuses a manifold that holds points; an empty one is a fresh start.
    found.points.clear();
    found.local_n1 = Default::default();
    found.local_n2 = Default::default();
    let constraints = constraints.map(|c| c as &dyn NormalConstraints);
    DefaultQueryDispatcher.contact_manifold_convex_convex(relative, triangle, shape, constraints, None, margin, found).ok()?;

    let normal = found.local_n1;
    candidates.clear();
    candidates.extend(found.points.iter().map(|point| {
        let on_b = *relative * point.local_p2;
        let feature = point.fid1.0.rotate_left(16) ^ point.fid2.0;
        PointCandidate { on_a: point.local_p1, on_b, separation: normal.dot(on_b - point.local_p1), feature }
    }));
    candidates.retain(|c| c.separation <= margin);

    let mut manifold = Manifold { normal, ..Manifold::default() };
    reduce_into(&mut manifold, candidates, TIE * part.reach(), |c| ManifoldPoint {
        on_a: c.on_a,
        on_b: relative.inverse_transform_point(c.on_b),
        separation: c.separation,
        feature: c.feature,
    });
    (manifold.count > 0 && manifold.is_finite()).then_some(manifold)
}
