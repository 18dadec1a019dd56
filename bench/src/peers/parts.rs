//! Shapes as the peers take them: one convex part at a time, in the frame of the body.

use longspan::{Geometry, LocalPose, ShapeDef};

/// The parts of `shape` with their places on the body; a shape that is not a compound is its own only part.
pub fn parts(shape: &ShapeDef) -> Vec<(LocalPose, &Geometry)> {
    match shape.shape.geometry() {
        Geometry::Compound { parts } => parts.iter().map(|(pose, part)| (placed(&shape.local_pose, pose), part)).collect(),
        geometry => vec![(shape.local_pose, geometry)],
    }
}

/// The box, and its place, that stands in for the half-space below the plane with this outward `normal`.
#[cfg(any(feature = "peer-box3d", feature = "peer-jolt"))]
pub fn ground_box(place: &LocalPose, normal: glam::Vec3) -> (LocalPose, glam::Vec3) {
    use glam::{Quat, Vec3};

    // Beyond every scene, and small enough for single precision (m).
    const GROUND_HALF_EXTENT: f32 = 500.0;
    const GROUND_HALF_DEPTH: f32 = 25.0;
    let upright = Quat::from_rotation_arc(Vec3::Y, normal);
    let local = LocalPose { position: -GROUND_HALF_DEPTH * normal, rotation: upright };
    (placed(place, &local), Vec3::new(GROUND_HALF_EXTENT, GROUND_HALF_DEPTH, GROUND_HALF_EXTENT))
}

fn placed(outer: &LocalPose, inner: &LocalPose) -> LocalPose {
    LocalPose {
        position: outer.position + outer.rotation * inner.position,
        rotation: (outer.rotation * inner.rotation).normalize(),
    }
}

/// What to call a form in a message.
pub fn name(geometry: &Geometry) -> &'static str {
    match geometry {
        Geometry::Ball { .. } => "ball",
        Geometry::Box { .. } => "box",
        Geometry::Capsule { .. } => "capsule",
        Geometry::Cylinder { .. } => "cylinder",
        Geometry::Cone { .. } => "cone",
        Geometry::ConvexHull { .. } => "convex hull",
        Geometry::TriangleMesh { .. } => "triangle mesh",
        Geometry::HeightField { .. } => "height field",
        Geometry::HalfSpace { .. } => "half-space",
        Geometry::Compound { .. } => "compound",
        _ => "shape of an unknown kind",
    }
}
