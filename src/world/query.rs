//! Questions that a host asks between steps; any number of threads may ask at a time.

use std::sync::OnceLock;

use glam::{DVec3, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::World;
use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::id::ShapeId;
use crate::pose::Pose;
use crate::query::{self, NearestPoint, Probe, QueryFilter, Ray, RayHit, Segment};
use crate::shape::Shape;

/// Rays of a batch below which it stays on one thread.
const MIN_PARALLEL_RAYS: usize = 64;

/// Rays that are worth another thread's while: some 10 µs.
const LEAST_RAYS: usize = 16;

/// Shapes that an impact carried out of their kept box in the last step.
///
/// A kept box holds its shape for as long as the shape moves by the velocity it began the step with; the next step makes it a
/// new one. Until then questions look at these shapes besides those that the broad phase names. Found when first asked for.
#[derive(Debug, Default)]
pub(super) struct Escaped(OnceLock<Vec<u32>>);

impl World {
    /// The first shape that a ray meets.
    ///
    /// # Errors
    /// A number of the ray that is not finite, a direction that is not of unit length, a length outside 0 … 1e7 m.
    pub fn cast_ray(&self, ray: &Ray, filter: &QueryFilter) -> Result<Option<RayHit>> {
        let ray = ray.checked()?;
        Ok(self.first_hit(&ray_path(&ray), filter, |slot| query::ray(&self.colliders[slot], &ray)))
    }

    /// Every shape that a ray meets, nearest first, where the ray first meets it; `out` is cleared.
    ///
    /// # Errors
    /// As [`cast_ray`](Self::cast_ray).
    pub fn cast_ray_all(&self, ray: &Ray, filter: &QueryFilter, out: &mut Vec<RayHit>) -> Result<()> {
        let ray = ray.checked()?;
        self.all_hits(&ray_path(&ray), filter, out, |slot| query::ray(&self.colliders[slot], &ray));
        Ok(())
    }

    /// The first shape that each of many rays meets, on the world's threads if there are many.
    ///
    /// # Errors
    /// As [`cast_ray`](Self::cast_ray), for any of them, or if `out` is not as long as `rays`; nothing is written then.
    pub fn cast_rays(&self, rays: &[Ray], filter: &QueryFilter, out: &mut [Option<RayHit>]) -> Result<()> {
        if rays.len() != out.len() {
            return Err(Error::new(ErrorKind::OutOfRange, "out", "is not as long as the list of rays"));
        }
        rays.iter().try_for_each(|ray| ray.checked().map(drop))?;
        let cast = |(ray, hit): (&Ray, &mut Option<RayHit>)| *hit = self.cast_ray(ray, filter).unwrap_or(None);
        if rays.len() < MIN_PARALLEL_RAYS || self.threads.has_host() {
            rays.iter().zip(out).for_each(cast);
        } else {
            let piece = self.threads.piece(rays.len(), LEAST_RAYS);
            self.threads.share(rays.chunks(piece).zip(out.chunks_mut(piece)), |(rays, out)| rays.iter().zip(out).for_each(cast));
        }
        Ok(())
    }

    /// The first shape that a solid meets on a straight path (m) without turning.
    ///
    /// # Errors
    /// A shape that is not solid; a pose or path that is not finite or out of range.
    pub fn cast_shape(&self, shape: &Shape, pose: Pose, path: Vec3, filter: &QueryFilter) -> Result<Option<RayHit>> {
        let (probe, direction, length) = sweep(shape, pose, path)?;
        let segment = sweep_path(&probe, direction, length);
        Ok(self.first_hit(&segment, filter, |slot| query::swept(&self.colliders[slot], &probe, direction, length)))
    }

    /// Every shape that a solid meets on a straight path (m) without turning, nearest first; `out` is cleared.
    ///
    /// # Errors
    /// As [`cast_shape`](Self::cast_shape).
    pub fn cast_shape_all(
        &self,
        shape: &Shape,
        pose: Pose,
        path: Vec3,
        filter: &QueryFilter,
        out: &mut Vec<RayHit>,
    ) -> Result<()> {
        let (probe, direction, length) = sweep(shape, pose, path)?;
        let segment = sweep_path(&probe, direction, length);
        self.all_hits(&segment, filter, out, |slot| query::swept(&self.colliders[slot], &probe, direction, length));
        Ok(())
    }

    /// Every shape that a solid overlaps or touches, in the order of their handles; `out` is cleared.
    ///
    /// # Errors
    /// As [`cast_shape`](Self::cast_shape).
    pub fn overlap_shape(&self, shape: &Shape, pose: Pose, filter: &QueryFilter, out: &mut Vec<ShapeId>) -> Result<()> {
        let probe = Probe::checked(shape, pose)?;
        let path = sweep_path(&probe, Vec3::X, 0.0);
        out.clear();
        for (_, slot) in self.candidates(&path) {
            if self.counts(slot, filter) && query::overlap(&self.colliders[slot], &probe) {
                out.push(self.colliders.handle_of(slot));
            }
        }
        out.sort_unstable();
        Ok(())
    }

    /// Every shape whose world box meets the box from `min` to `max` (m), in the order of their handles; `out` is cleared.
    ///
    /// # Errors
    /// A corner that is not finite or out of range; `min` beyond `max`.
    pub fn overlap_box(&self, min: DVec3, max: DVec3, filter: &QueryFilter, out: &mut Vec<ShapeId>) -> Result<()> {
        check::position("min", min)?;
        check::position("max", max)?;
        if min.cmpgt(max).any() {
            return Err(Error::new(ErrorKind::OutOfRange, "min", "is beyond max"));
        }
        let path = Segment { origin: (min + max) * 0.5, direction: Vec3::X, length: 0.0, half: (max - min) * 0.5 };
        out.clear();
        for (_, slot) in self.candidates(&path) {
            if self.counts(slot, filter) && path.enters_box(&self.colliders[slot].world_box(0.0)).is_some() {
                out.push(self.colliders.handle_of(slot));
            }
        }
        out.sort_unstable();
        Ok(())
    }

    /// The shape nearest to a point, not farther than `max_distance` (m); of those that hold the point, the one with the lowest handle.
    ///
    /// # Errors
    /// A point that is not finite or out of range; a distance outside 0 … 1e7 m.
    pub fn nearest_point(&self, point: DVec3, max_distance: f32, filter: &QueryFilter) -> Result<Option<NearestPoint>> {
        check::position("point", point)?;
        let reach = f64::from(query::query_length("max_distance", max_distance)?);
        let around = Segment { origin: point, direction: Vec3::X, length: 0.0, half: DVec3::splat(reach) };
        let mut best: Option<NearestPoint> = None;
        for (_, slot) in self.candidates(&around) {
            let limit = best.map_or(max_distance, |best| best.distance);
            if !self.counts(slot, filter) {
                continue;
            }
            if let Some((distance, nearest)) = query::nearest_point(&self.colliders[slot], point, limit) {
                let shape = self.colliders.handle_of(slot);
                if best.is_none_or(|best| (distance, shape) < (best.distance, best.shape)) {
                    let body = self.bodies.handle_of(self.colliders[slot].body);
                    best = Some(NearestPoint { shape, body, point: nearest, distance });
                }
            }
        }
        Ok(best)
    }

    fn first_hit(
        &self,
        path: &Segment,
        filter: &QueryFilter,
        meet: impl Fn(u32) -> Option<(f32, DVec3, Vec3)>,
    ) -> Option<RayHit> {
        let mut best: Option<RayHit> = None;
        for (entry, slot) in self.candidates(path) {
            // Boxes come in the order in which the path enters them; a hit lies no nearer than its box.
            if best.is_some_and(|best| entry as f32 > best.distance) {
                break;
            }
            if self.counts(slot, filter)
                && let Some(met) = meet(slot)
            {
                let hit = self.hit(slot, met);
                if best.is_none_or(|best| (hit.distance, hit.shape) < (best.distance, best.shape)) {
                    best = Some(hit);
                }
            }
        }
        best
    }

    fn all_hits(
        &self,
        path: &Segment,
        filter: &QueryFilter,
        out: &mut Vec<RayHit>,
        meet: impl Fn(u32) -> Option<(f32, DVec3, Vec3)>,
    ) {
        out.clear();
        let counting = self.candidates(path).into_iter().filter(|&(_, slot)| self.counts(slot, filter));
        out.extend(counting.filter_map(|(_, slot)| Some(self.hit(slot, meet(slot)?))));
        out.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.shape.cmp(&b.shape)));
    }

    fn hit(&self, slot: u32, (distance, point, normal): (f32, DVec3, Vec3)) -> RayHit {
        let body = self.bodies.handle_of(self.colliders[slot].body);
        RayHit { shape: self.colliders.handle_of(slot), body, point, normal, distance }
    }

    fn counts(&self, slot: u32, filter: &QueryFilter) -> bool {
        let collider = &self.colliders[slot];
        if collider.sensor {
            return false;
        }
        let (shape, body) = (self.colliders.handle_of(slot), self.bodies.handle_of(collider.body));
        filter.accepts(shape, &collider.filter, body, self.bodies[collider.body].kind)
    }

    /// Shapes whose box the path may meet, with the distance at which it enters the kept box (m), in that order.
    fn candidates(&self, path: &Segment) -> Vec<(f64, u32)> {
        let mut found: Vec<(f64, u32)> = Vec::new();
        self.broad.along(|mins, maxs| path.enters(mins, maxs), &mut found);
        for slot in self.escaped_shapes() {
            // An edit may have destroyed it since.
            if let Some(collider) = self.colliders.get(slot)
                && let Some(entry) = path.enters_box(&collider.world_box(0.0))
            {
                found.push((entry, slot));
            }
        }
        found.sort_unstable_by(|a, b| a.1.cmp(&b.1).then(a.0.total_cmp(&b.0)));
        found.dedup_by_key(|&mut (_, slot)| slot);
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found
    }

    /// Shapes that an impact carried out of their kept box in the last step; an edit may have destroyed some since.
    pub(super) fn escaped_shapes(&self) -> impl Iterator<Item = u32> + '_ {
        self.escaped.0.get_or_init(|| self.find_escaped()).iter().copied()
    }

    fn find_escaped(&self) -> Vec<u32> {
        let inside = |kept: &Option<Aabb>, now: &Aabb| kept.is_some_and(|kept| kept.contains(now));
        let movable = self.colliders.iter().filter(|(_, shape)| self.bodies[shape.body].kind != crate::body::BodyKind::Static);
        movable.filter(|(_, shape)| !inside(&shape.fat_box, &shape.world_box(0.0))).map(|(slot, _)| slot).collect()
    }

    /// To be called when shapes have moved by a step.
    pub(super) fn forget_escaped(&mut self) {
        self.escaped = Escaped::default();
    }
}

fn ray_path(ray: &Ray) -> Segment {
    Segment { origin: ray.origin, direction: ray.direction, length: ray.length, half: DVec3::ZERO }
}

fn sweep(shape: &Shape, pose: Pose, path: Vec3) -> Result<(Probe<'_>, Vec3, f32)> {
    let probe = Probe::checked(shape, pose)?;
    let length = query::query_length("path", check::finite_vec("path", path)?.length())?;
    Ok((probe, path.try_normalize().unwrap_or(Vec3::X), length))
}

fn sweep_path(probe: &Probe, direction: Vec3, length: f32) -> Segment {
    let own_box = query::probe_box(probe);
    let origin = probe.pose.position + own_box.center().as_dvec3();
    Segment { origin, direction, length, half: own_box.half_extents().as_dvec3() }
}
