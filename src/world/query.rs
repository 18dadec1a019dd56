//! Queries that a host makes between steps, from any number of threads.

use std::sync::OnceLock;

use glam::{DVec3, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::World;
use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::id::ShapeId;
use crate::pose::Pose;
use crate::query::{
    self, BodyShape, Cast, Distance, Met, NearestPoint, NearestShape, PathSegment, Probe, QueryFilter, Ray, RayHit, Way,
};
use crate::shape::Shape;

/// Rays of a batch below which it stays on one thread.
const MIN_PARALLEL_RAYS: usize = 64;

/// Rays that are worth another thread's while: some 10 µs.
const MIN_RAYS: usize = 16;

/// Shapes that an impact carried out of their kept box in the last step.
///
/// A kept box holds its shape for as long as the shape moves by the velocity it began the step with; the next step makes it a
/// new one. Until then questions look at these shapes besides those that the broad phase names. Found when first asked for.
#[derive(Debug, Default)]
pub(super) struct OutOfBoxBodies(OnceLock<Vec<u32>>);

impl World {
    /// The first shape that a ray meets.
    ///
    /// # Errors
    /// A number of the ray that is not finite, a direction that is not of unit length, a length outside 0 … 1e7 m.
    pub fn cast_ray(&self, ray: &Ray, filter: &QueryFilter) -> Result<Option<RayHit>> {
        let path = ray.checked()?;
        Ok(self.first_hit(&path, filter, |slot| query::first_on_ray(self.on_body(slot), &path, false)))
    }

    /// Every shape that a ray meets, nearest first, where the ray first meets it; `out` is cleared.
    ///
    /// # Errors
    /// As [`cast_ray`](Self::cast_ray).
    pub fn cast_ray_all(&self, ray: &Ray, filter: &QueryFilter, out: &mut Vec<RayHit>) -> Result<()> {
        let path = ray.checked()?;
        self.all_hits(&path, filter, out, |slot| query::first_on_ray(self.on_body(slot), &path, false));
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
        let checked = rays.iter().map(|ray| ray.checked()).collect::<Result<Vec<PathSegment>>>()?;
        let cast = |(path, hit): (&PathSegment, &mut Option<RayHit>)| {
            *hit = self.first_hit(path, filter, |slot| query::first_on_ray(self.on_body(slot), path, false));
        };
        if rays.len() < MIN_PARALLEL_RAYS || self.threads.has_host() {
            checked.iter().zip(out).for_each(cast);
        } else {
            let piece = self.threads.piece(rays.len(), MIN_RAYS);
            self.threads
                .share(checked.chunks(piece).zip(out.chunks_mut(piece)), |(rays, out)| rays.iter().zip(out).for_each(cast));
        }
        Ok(())
    }

    /// The first shape that a solid meets on a straight path (m) without turning.
    ///
    /// # Errors
    /// A shape that is not solid; a pose or path that is not finite or out of range.
    pub fn cast_shape(&self, shape: &Shape, pose: Pose, path: Vec3, filter: &QueryFilter) -> Result<Option<RayHit>> {
        self.cast(&Cast::new(shape, pose, path.as_dvec3()), filter)
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
        self.cast_all(&Cast::new(shape, pose, path.as_dvec3()), filter, out)
    }

    /// The first shape that a solid meets on its way, which may turn, or a ray.
    ///
    /// # Errors
    /// A shape that is not solid; a pose, path or turn that is not finite or out of range.
    pub fn cast(&self, cast: &Cast, filter: &QueryFilter) -> Result<Option<RayHit>> {
        let ignore = cast.ignore_overlapped;
        Ok(match cast.checked()? {
            Way::Ray(path) => self.first_hit(&path, filter, |slot| query::first_on_ray(self.on_body(slot), &path, ignore)),
            Way::Sweep(sweep) => {
                self.first_hit(&sweep.path_box(), filter, |slot| query::first_on_sweep(self.on_body(slot), &sweep))
            }
        })
    }

    /// Every shape that a solid or a ray meets on its way, nearest first; `out` is cleared.
    ///
    /// # Errors
    /// As [`cast`](Self::cast).
    pub fn cast_all(&self, cast: &Cast, filter: &QueryFilter, out: &mut Vec<RayHit>) -> Result<()> {
        let ignore = cast.ignore_overlapped;
        match cast.checked()? {
            Way::Ray(path) => {
                self.all_hits(&path, filter, out, |slot| query::first_on_ray(self.on_body(slot), &path, ignore));
            }
            Way::Sweep(sweep) => {
                self.all_hits(&sweep.path_box(), filter, out, |slot| query::first_on_sweep(self.on_body(slot), &sweep));
            }
        }
        Ok(())
    }

    /// Every shape that a solid overlaps or touches, in the order of their handles; `out` is cleared.
    ///
    /// # Errors
    /// As [`cast_shape`](Self::cast_shape).
    pub fn overlap_shape(&self, shape: &Shape, pose: Pose, filter: &QueryFilter, out: &mut Vec<ShapeId>) -> Result<()> {
        let probe = Probe::checked(shape, pose)?;
        out.clear();
        for (_, slot) in self.candidates(&query::probe_box(&probe)) {
            if self.counts(slot, filter) && query::overlaps(self.on_body(slot), &probe) {
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
        let path = PathSegment::still((min + max) * 0.5, (max - min) * 0.5);
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
        let around = PathSegment::still(point, DVec3::splat(reach));
        let found = self.nearest(&around, reach, filter, |slot, limit| query::nearest_point(self.on_body(slot), point, limit));
        Ok(found.map(|(slot, found)| NearestPoint {
            shape: self.colliders.handle_of(slot),
            body: self.bodies.handle_of(self.colliders[slot].body),
            point: found.point_a,
            distance: found.distance,
            part: found.parts[0],
            triangle: found.triangles[0],
        }))
    }

    /// The shape nearest to a solid, not farther than `max_distance` (m), or the one that it overlaps deepest.
    ///
    /// # Errors
    /// A shape that is not solid, a pose that is not finite or out of range, a distance outside 0 … 1e7 m.
    pub fn nearest_shape(
        &self,
        shape: &Shape,
        pose: Pose,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Option<NearestShape>> {
        let probe = Probe::checked(shape, pose)?;
        let reach = f64::from(query::query_length("max_distance", max_distance)?);
        let own = query::probe_box(&probe);
        let around = PathSegment { half: own.half + DVec3::splat(reach), ..own };
        let found = self.nearest(&around, reach, filter, |slot, limit| query::distance_to(self.on_body(slot), &probe, limit));
        Ok(found.map(|(slot, distance)| {
            let body = self.bodies.handle_of(self.colliders[slot].body);
            NearestShape { shape: self.colliders.handle_of(slot), body, distance }
        }))
    }

    /// How far two shapes are apart, or how deep they overlap; sensors and shapes of one body too. Of a mesh or height field
    /// that is overlapped, the depth is that of the triangle that is overlapped deepest.
    ///
    /// # Errors
    /// A handle of no shape of this world; two half-spaces.
    pub fn shape_distance(&self, a: ShapeId, b: ShapeId) -> Result<Distance> {
        let find = |shape: ShapeId, argument| self.colliders.find(shape).map_err(|error| Error { argument, ..error });
        let (slot_a, slot_b) = (find(a, "a")?, find(b, "b")?);
        query::distance_between(self.on_body(slot_a), self.on_body(slot_b)).ok_or(Error::new(
            ErrorKind::NotApplicable,
            "b",
            "two half-spaces have no nearest points",
        ))
    }

    /// The least distance that `measure` finds within a limit, and its shape; of equal ones, that of the lowest handle.
    fn nearest(
        &self,
        around: &PathSegment,
        reach: f64,
        filter: &QueryFilter,
        measure: impl Fn(u32, f64) -> Option<Distance>,
    ) -> Option<(u32, Distance)> {
        let mut best: Option<(u32, Distance)> = None;
        for (_, slot) in self.candidates(around) {
            let limit = best.as_ref().map_or(reach, |(_, best)| best.distance);
            if self.counts(slot, filter)
                && let Some(found) = measure(slot, limit)
            {
                let order = |slot: u32, found: &Distance| (found.distance, self.colliders.handle_of(slot));
                if best.as_ref().is_none_or(|(known, best)| order(slot, &found) < order(*known, best)) {
                    best = Some((slot, found));
                }
            }
        }
        best
    }

    fn first_hit(&self, path: &PathSegment, filter: &QueryFilter, meet: impl Fn(u32) -> Option<Met>) -> Option<RayHit> {
        let mut best: Option<RayHit> = None;
        for (entry, slot) in self.candidates(path) {
            // Boxes come in the order in which the path enters them; a hit lies no nearer than its box.
            if best.is_some_and(|best| entry > best.distance) {
                break;
            }
            if self.counts(slot, filter)
                && let Some(met) = meet(slot)
            {
                let hit = self.hit(slot, &met);
                if best.is_none_or(|best| (hit.fraction, hit.shape) < (best.fraction, best.shape)) {
                    best = Some(hit);
                }
            }
        }
        best
    }

    fn all_hits(&self, path: &PathSegment, filter: &QueryFilter, out: &mut Vec<RayHit>, meet: impl Fn(u32) -> Option<Met>) {
        out.clear();
        let counting = self.candidates(path).into_iter().filter(|&(_, slot)| self.counts(slot, filter));
        out.extend(counting.filter_map(|(_, slot)| Some(self.hit(slot, &meet(slot)?))));
        out.sort_by(|a, b| a.fraction.total_cmp(&b.fraction).then(a.shape.cmp(&b.shape)));
    }

    fn hit(&self, slot: u32, met: &Met) -> RayHit {
        RayHit {
            shape: self.colliders.handle_of(slot),
            body: self.bodies.handle_of(self.colliders[slot].body),
            point: met.point,
            normal: met.normal,
            distance: met.distance,
            fraction: met.share,
            depth: met.depth,
            part: met.part,
            triangle: met.triangle,
        }
    }

    /// A shape with its body, as questions take it.
    pub(super) fn on_body(&self, slot: u32) -> BodyShape<'_> {
        let collider = &self.colliders[slot];
        BodyShape { collider, body: &self.bodies[collider.body] }
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
    fn candidates(&self, path: &PathSegment) -> Vec<(f64, u32)> {
        let mut found: Vec<(f64, u32)> = Vec::new();
        self.collision.broad.along(|mins, maxs| path.enters(mins, maxs), &mut found);
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
        self.collision.escaped.0.get_or_init(|| self.find_escaped()).iter().copied()
    }

    fn find_escaped(&self) -> Vec<u32> {
        let inside = |kept: &Option<Aabb>, now: &Aabb| kept.is_some_and(|kept| kept.contains(now));
        let movable = self.colliders.iter().filter(|(_, shape)| self.bodies[shape.body].kind != crate::body::BodyKind::Static);
        movable.filter(|(_, shape)| !inside(&shape.fat_box, &shape.world_box(0.0))).map(|(slot, _)| slot).collect()
    }

    /// To be called when shapes have moved by a step.
    pub(super) fn forget_escaped(&mut self) {
        self.collision.escaped = OutOfBoxBodies::default();
    }
}
