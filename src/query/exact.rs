//! The shapes themselves, asked through parry3d in coordinates relative to each one.

use glam::{DVec3, Vec3};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose3;
use parry3d::query::{ShapeCastOptions, cast_shapes, intersection_test};

use super::{Probe, Ray, Segment};
use crate::collide::collider::Collider;

/// Where something was met: distance along the way (m), point (m), outward normal.
pub(crate) type Met = (f32, DVec3, Vec3);

/// Where a ray first meets a shape. The part of the ray before the shape's box is skipped in `f64`.
pub(crate) fn ray(collider: &Collider, ray: &Ray) -> Option<Met> {
    let segment = Segment { origin: ray.origin, direction: ray.direction, length: ray.length, half: DVec3::ZERO };
    let entry = segment.enters_box(&collider.world_box(0.0))?;
    let (position, rotation) = collider.place;
    let start = segment.at(entry);
    let inverse = rotation.conjugate();
    let local = parry3d::query::Ray::new(inverse * (start - position).as_vec3(), inverse * ray.direction);
    let remaining = (f64::from(ray.length) - entry) as f32;
    let hit = collider.shape.parry().cast_local_ray_and_get_normal(&local, remaining, true)?;
    let distance = (entry + f64::from(hit.time_of_impact)) as f32;
    let normal = (rotation * hit.normal).try_normalize().unwrap_or(-ray.direction);
    // Seen from behind, a triangle or a plane shows its back.
    let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
    Some((distance, start + (ray.direction * hit.time_of_impact).as_dvec3(), normal))
}

/// Where a shape, moved along a straight path without turning, first meets another.
pub(crate) fn swept(collider: &Collider, probe: &Probe, direction: Vec3, length: f32) -> Option<Met> {
    let own_box = probe_box(probe);
    let half = (own_box.half_extents()).as_dvec3();
    let center = probe.pose.position + own_box.center().as_dvec3();
    let segment = Segment { origin: center, direction, length, half };
    let entry = segment.enters_box(&collider.world_box(0.0))?;
    let (position, rotation) = collider.place;
    let start = probe.pose.position + direction.as_dvec3() * entry;
    let moving = Pose3::from_parts((start - position).as_vec3(), probe.pose.rotation);
    let fixed = Pose3::from_parts(Vec3::ZERO, rotation);
    let options = ShapeCastOptions {
        max_time_of_impact: (f64::from(length) - entry) as f32,
        target_distance: 0.0,
        stop_at_penetration: true,
        compute_impact_geometry_on_penetration: false,
    };
    let (own, other) = (&**probe.shape.parry(), &**collider.shape.parry());
    let hit = cast_shapes(&fixed, Vec3::ZERO, other, &moving, direction, own, options).ok()??;
    let distance = (entry + f64::from(hit.time_of_impact)) as f32;
    if hit.time_of_impact <= 0.0 && entry <= 0.0 {
        return Some((0.0, probe.pose.position, -direction));
    }
    let on_fixed = position + (rotation * hit.witness1).as_dvec3();
    let normal = (rotation * hit.normal1).try_normalize().unwrap_or(-direction);
    Some((distance, on_fixed, normal))
}

/// Whether two shapes overlap or touch.
pub(crate) fn overlap(collider: &Collider, probe: &Probe) -> bool {
    let (position, rotation) = collider.place;
    let own = Pose3::from_parts((probe.pose.position - position).as_vec3(), probe.pose.rotation);
    let fixed = Pose3::from_parts(Vec3::ZERO, rotation);
    intersection_test(&fixed, &**collider.shape.parry(), &own, &**probe.shape.parry()).is_ok_and(|met| met.intersecting)
}

/// The nearest point of a shape not farther than `limit` (m), and how far it is.
pub(crate) fn nearest_point(collider: &Collider, point: DVec3, limit: f32) -> Option<(f32, DVec3)> {
    let (position, rotation) = collider.place;
    let local = rotation.conjugate() * (point - position).as_vec3();
    let found = collider.shape.parry().project_local_point(local, true);
    let distance = if found.is_inside { 0.0 } else { (found.point - local).length() };
    let nearest = if found.is_inside { point } else { position + (rotation * found.point).as_dvec3() };
    (distance <= limit).then_some((distance, nearest))
}

/// Box of a probe around its own origin, in world axes (m).
pub(crate) fn probe_box(probe: &Probe) -> Aabb {
    probe.shape.parry().compute_aabb(&Pose3::from_parts(Vec3::ZERO, probe.pose.rotation))
}
