//! Convex hulls: their surface, their faces for contacts, their planes for queries, their weight.
//!
//! ```text
//! points ── exact.rs ── triangles ─┬─ weight.rs: volume, centre, inertia of exactly this surface
//!                                  ├─ planes, for rays
//!                                  └─ faces.rs: flat polygons, for contacts
//! ```
//!
//! parry3d holds a hull as one of its shapes for boxes around it and for sweeps, and knows its support points only.

use glam::{DVec3, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingSphere};
use parry3d::math::Pose3;
use parry3d::query::details::local_ray_intersection_with_support_map_with_params;
use parry3d::query::gjk::VoronoiSimplex;
use parry3d::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use parry3d::shape::{FeatureId, Shape, ShapeType, SupportMap, TypedShape};

mod abreast;
mod exact;
mod faces;
pub(crate) mod weight;

use abreast::Abreast;
pub(crate) use faces::Face;
use faces::Faces;

/// Points up to which all are compared for the farthest; beyond it, steps from neighbour to neighbour are fewer.
const FEW_POINTS: usize = 48;

/// A closed convex surface of triangles, counter-clockwise seen from outside; every point is a corner of it.
#[derive(Debug, Clone)]
pub(crate) struct Triangulation {
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Triangulation {
    /// The hull of some points; none if all lie in one plane.
    pub(crate) fn of(points: &[Vec3]) -> Option<Self> {
        let mut triangles = exact::triangles(points)?;
        let mut renumbered = vec![u32::MAX; points.len()];
        triangles.iter().flatten().for_each(|&index| renumbered[index as usize] = 0);
        let mut kept = Vec::new();
        for (number, &point) in renumbered.iter_mut().zip(points) {
            if *number == 0 {
                *number = kept.len() as u32;
                kept.push(point);
            }
        }
        triangles.iter_mut().flatten().for_each(|index| *index = renumbered[*index as usize]);
        Some(Self { points: kept, triangles })
    }

    /// The triangle across the edge from each corner of each triangle to the next.
    fn neighbours(&self) -> Vec<[u32; 3]> {
        let mut edges: Vec<((u32, u32), u32, usize)> = Vec::with_capacity(3 * self.triangles.len());
        for (number, triangle) in (0..).zip(&self.triangles) {
            for side in 0..3 {
                let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
                edges.push(((a.min(b), a.max(b)), number, side));
            }
        }
        edges.sort_unstable();
        let mut across = vec![[0; 3]; self.triangles.len()];
        // Every edge of a closed surface belongs to two triangles.
        for pair in edges.chunks_exact(2) {
            let ((_, a, side_a), (_, b, side_b)) = (pair[0], pair[1]);
            across[a as usize][side_a] = b;
            across[b as usize][side_b] = a;
        }
        across
    }

    fn extent(&self) -> f64 {
        let points = || self.points.iter().copied();
        let (low, high) = (points().reduce(Vec3::min), points().reduce(Vec3::max));
        f64::from((high.unwrap_or_default() - low.unwrap_or_default()).max_element())
    }

    fn greatest_coordinate(&self) -> f64 {
        f64::from(self.points.iter().map(|point| point.abs().max_element()).fold(0.0, f32::max))
    }
}

/// A convex hull.
#[derive(Debug, Clone)]
pub(crate) struct Hull {
    surface: Triangulation,
    faces: Faces,
    /// Corners, and normals of the faces.
    corners: Abreast,
    normals: Abreast,
    /// Outward unit normal of each triangle, and how far its plane is from the origin along it (m).
    planes: Vec<(DVec3, f64)>,
    /// Corners that an edge joins to a corner: `links[starts[i]..starts[i + 1]]`; empty for a few points.
    links: Vec<u32>,
    starts: Vec<u32>,
    /// The farthest corner along ±x, ±y, ±z.
    extremes: [u32; 6],
    /// Distance from the origin to the farthest corner (m).
    reach: f64,
}

impl Hull {
    /// The hull of some points; none if all lie in one plane.
    pub(crate) fn new(points: &[Vec3]) -> Option<Self> {
        let surface = Triangulation::of(points)?;
        let faces = Faces::of(&surface);
        let plane = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|index| surface.points[index as usize].as_dvec3());
            let normal = (b - a).cross(c - a).normalize();
            (normal, normal.dot(a).max(normal.dot(b)).max(normal.dot(c)))
        };
        let planes = surface.triangles.iter().map(plane).collect();
        let reach = surface.points.iter().map(|point| point.as_dvec3().length()).fold(0.0, f64::max);
        let corners = Abreast::of(surface.points.iter().copied());
        let normals = Abreast::of(faces.all.iter().map(|face| face.normal));
        let (links, starts) = (Vec::new(), Vec::new());
        let mut hull = Self { surface, faces, corners, normals, planes, links, starts, extremes: [0; 6], reach };
        if hull.points().len() > FEW_POINTS {
            hull.link();
        }
        Some(hull)
    }

    pub(crate) fn surface(&self) -> &Triangulation {
        &self.surface
    }

    /// Corners (m).
    pub(crate) fn points(&self) -> &[Vec3] {
        &self.surface.points
    }

    /// Triangles of the surface, counter-clockwise seen from outside.
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        &self.surface.triangles
    }

    /// The plane of each triangle: outward unit normal, and distance from the origin along it (m).
    pub(crate) fn planes(&self) -> &[(DVec3, f64)] {
        &self.planes
    }

    /// Distance from the origin to the farthest corner (m).
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// Flat faces.
    pub(crate) fn faces(&self) -> &[Face] {
        &self.faces.all
    }

    /// The face whose normal is nearest to a direction.
    pub(crate) fn facing(&self, direction: Vec3) -> &Face {
        &self.faces.all[self.normals.farthest(direction) as usize]
    }

    /// Corners of a face, counter-clockwise seen from outside.
    pub(crate) fn corners(&self, face: &Face) -> &[u32] {
        self.faces.corners(face)
    }

    /// The corner that is farthest along a direction.
    pub(crate) fn farthest(&self, direction: DVec3) -> u32 {
        if self.starts.is_empty() {
            return highest(&self.surface.points, direction);
        }
        // On a convex surface, whoever has no higher neighbour is the highest.
        let along = |index: u32| (self.surface.points[index as usize].as_dvec3().dot(direction), index);
        let higher = |a: (f64, u32), b: &u32| Some(along(*b)).filter(|b| b.0 > a.0).unwrap_or(a);
        let mut best = self.extremes.iter().fold(along(self.extremes[0]), higher);
        loop {
            let [from, to] = [0, 1].map(|next| self.starts[best.1 as usize + next] as usize);
            let next = self.links[from..to].iter().fold(best, higher);
            if next.1 == best.1 {
                return best.1;
            }
            best = next;
        }
    }

    fn link(&mut self) {
        let Triangulation { points, triangles } = &self.surface;
        // Each edge is met once in either direction.
        let mut edges: Vec<(u32, u32)> = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        edges.sort_unstable();
        self.starts = (0..=points.len() as u32).map(|from| edges.partition_point(|edge| edge.0 < from) as u32).collect();
        self.links = edges.iter().map(|edge| edge.1).collect();
        for (i, extreme) in self.extremes.iter_mut().enumerate() {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            let along = |index: u32| sign * points[index as usize][i / 2];
            *extreme = (0..points.len() as u32).fold(0, |a, b| if along(b) > along(a) { b } else { a });
        }
    }
}

/// The first of the points that are highest along a direction. The height of the best is kept: looked up and reckoned again for each point it
/// takes a third longer.
fn highest(points: &[Vec3], direction: DVec3) -> u32 {
    let (mut best, mut found) = (f64::NEG_INFINITY, 0);
    for (index, point) in points.iter().enumerate() {
        let height = point.as_dvec3().dot(direction);
        if height > best {
            (best, found) = (height, index as u32);
        }
    }
    found
}

impl SupportMap for Hull {
    fn local_support_point(&self, direction: Vec3) -> Vec3 {
        let farthest =
            if self.starts.is_empty() { self.corners.farthest(direction) } else { self.farthest(direction.as_dvec3()) };
        self.surface.points[farthest as usize]
    }
}

impl PointQuery for Hull {
    fn project_local_point(&self, point: Vec3, solid: bool) -> PointProjection {
        parry3d::query::details::local_point_projection_on_support_map(self, &mut VoronoiSimplex::new(), point, solid)
    }

    fn project_local_point_and_get_feature(&self, point: Vec3) -> (PointProjection, FeatureId) {
        (self.project_local_point(point, false), FeatureId::Unknown)
    }
}

impl RayCast for Hull {
    fn cast_local_ray_and_get_normal(&self, ray: &Ray, max: f32, solid: bool) -> Option<RayIntersection> {
        local_ray_intersection_with_support_map_with_params(self, &mut VoronoiSimplex::new(), ray, max, solid)
    }
}

impl Shape for Hull {
    fn compute_local_aabb(&self) -> Aabb {
        if self.starts.is_empty() {
            return Aabb::from_points(self.points().iter().copied());
        }
        // Of many corners the outermost are known.
        let end = |number: usize| self.surface.points[self.extremes[number] as usize][number / 2];
        Aabb::new(Vec3::new(end(1), end(3), end(5)), Vec3::new(end(0), end(2), end(4)))
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        let center = self.compute_local_aabb().center();
        let radius = self.points().iter().map(|point| point.distance_squared(center)).fold(0.0, f32::max).sqrt();
        BoundingSphere::new(center, radius)
    }

    fn compute_aabb(&self, position: &Pose3) -> Aabb {
        Aabb::from_points(self.points().iter().map(|&point| *position * point))
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn scale_dyn(&self, _: Vec3, _: u32) -> Option<Box<dyn Shape>> {
        None
    }

    fn mass_properties(&self, density: f32) -> parry3d::mass_properties::MassProperties {
        parry3d::mass_properties::MassProperties::from_convex_polyhedron(density, self.points(), self.triangles())
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> f32 {
        self.compute_local_aabb().half_extents().min_element()
    }

    fn ccd_angular_thickness(&self) -> f32 {
        std::f32::consts::FRAC_PI_4
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn as_support_map(&self) -> Option<&dyn SupportMap> {
        Some(self)
    }
}

#[cfg(test)]
mod tests;
