//! What a body is made of: geometry, checked once, shared by every body that uses it.
//!
//! Geometry is plain data; [`Shape::new`] refuses what cannot be a solid and builds what collision needs from it. Capsules,
//! cylinders and cones stand along the local y axis. parry3d holds the collision form; nothing outside `collide/` uses it.

use std::sync::Arc;

use glam::{Mat3, Quat, Vec3};
use parry3d::math::Pose3;
use parry3d::shape::SharedShape;
use parry3d::utils::Array2;

use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::hull::Hull;
use crate::hull::weight::weigh;
use crate::mass::{self, MassProperties};
use crate::material::Material;

/// Smallest and largest extent of a shape (m).
pub const EXTENT_RANGE: (f32, f32) = (1.0e-5, 1.0e6);

/// Most points that a convex hull may be built from.
pub const MAX_HULL_POINTS: usize = 4096;

/// Smallest ratio between the least and the greatest extent of a hull's points; thinner is not a solid.
const MIN_HULL_ASPECT: f32 = 1.0e-4;

/// Position (m) and rotation of a shape on its body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalPose {
    /// Origin of the shape in the body's frame (m).
    pub position: Vec3,
    /// Rotation of the shape in the body's frame, unit quaternion.
    pub rotation: Quat,
}

impl LocalPose {
    /// The body's own frame.
    pub const IDENTITY: Self = Self { position: Vec3::ZERO, rotation: Quat::IDENTITY };

    /// A frame at `position`, not rotated.
    pub const fn at(position: Vec3) -> Self {
        Self { position, rotation: Quat::IDENTITY }
    }

    pub(crate) fn to_parry(self) -> Pose3 {
        Pose3::from_parts(self.position, self.rotation)
    }

    pub(crate) fn checked(self) -> Result<Self> {
        check::lever("local_pose.position", self.position)?;
        Ok(Self { rotation: check::rotation("local_pose.rotation", self.rotation)?, ..self })
    }
}

impl Default for LocalPose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// The form of a shape, as plain data (m).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// A ball.
    Ball {
        /// Radius (m).
        radius: f32,
    },
    /// A box.
    Box {
        /// Half of each edge (m).
        half_extents: Vec3,
    },
    /// A cylinder with hemispheres at its ends, along y.
    Capsule {
        /// Half the length of the cylindrical part (m).
        half_height: f32,
        /// Radius (m).
        radius: f32,
    },
    /// A cylinder along y.
    Cylinder {
        /// Half the height (m).
        half_height: f32,
        /// Radius (m).
        radius: f32,
    },
    /// A cone along y, tip up, with its origin halfway up.
    Cone {
        /// Half the height (m).
        half_height: f32,
        /// Radius of the base (m).
        radius: f32,
    },
    /// The convex hull of some points.
    ConvexHull {
        /// At least four points, not in one plane (m).
        points: Vec<Vec3>,
    },
    /// Triangles, for static and kinematic bodies only.
    TriangleMesh {
        /// Vertices (m).
        vertices: Vec<Vec3>,
        /// Three vertex indices a triangle, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
    /// Heights on a grid in the x–z plane, centred on the origin, for static and kinematic bodies only.
    HeightField {
        /// Number of rows, along z; at least 2.
        rows: usize,
        /// Number of columns, along x; at least 2.
        columns: usize,
        /// `rows × columns` heights along y, row by row (m).
        heights: Vec<f32>,
        /// Extent of the whole field along x (m).
        size_x: f32,
        /// Extent of the whole field along z (m).
        size_z: f32,
    },
    /// All points below a plane through the origin, for static and kinematic bodies only.
    HalfSpace {
        /// Outward unit normal.
        normal: Vec3,
    },
    /// Several convex forms as one shape with one material.
    Compound {
        /// Each part with its place; parts are convex.
        parts: Vec<(LocalPose, Geometry)>,
    },
}

/// A checked, immutable shape; cheap to clone, one copy serves any number of bodies.
#[derive(Clone)]
pub struct Shape(Arc<ShapeData>);

struct ShapeData {
    geometry: Geometry,
    parry: SharedShape,
    /// Mass properties at a density of 1 kg/m³; none for what has no volume.
    unit_mass: Option<MassProperties>,
    /// The host's number of each triangle of a mesh of which parry3d has left some out; empty if it has not.
    host_triangles: Vec<u32>,
}

impl Shape {
    /// Checks `geometry` and builds the shape.
    ///
    /// # Errors
    /// Names the field at fault: not finite, zero or negative extents, collinear or coplanar hull points, an index past
    /// the vertices, an empty mesh, a compound part that is not convex.
    pub fn new(geometry: Geometry) -> Result<Self> {
        let parry = build(&geometry)?;
        let unit_mass = unit_mass(&geometry, &*parry);
        if let Some(mass) = &unit_mass
            && !(mass.mass.is_finite() && mass.mass > 0.0 && mass.principal_inertia.is_finite())
        {
            return Err(Error::new(ErrorKind::Degenerate, "geometry", "encloses no volume"));
        }
        let host_triangles = host_triangles(&geometry, &*parry);
        Ok(Self(Arc::new(ShapeData { geometry, parry, unit_mass, host_triangles })))
    }

    /// A ball of `radius` (m).
    pub fn ball(radius: f32) -> Result<Self> {
        Self::new(Geometry::Ball { radius })
    }

    /// A box of half the given edges (m).
    pub fn cuboid(half_extents: Vec3) -> Result<Self> {
        Self::new(Geometry::Box { half_extents })
    }

    /// A capsule along y: half the length of its cylinder, and its radius (m).
    pub fn capsule(half_height: f32, radius: f32) -> Result<Self> {
        Self::new(Geometry::Capsule { half_height, radius })
    }

    /// The form this shape was built from.
    pub fn geometry(&self) -> &Geometry {
        &self.0.geometry
    }

    /// Mass properties at `density` (kg/m³); `None` for meshes, height fields and half-spaces, which have no volume.
    pub fn mass_properties(&self, density: f32) -> Option<MassProperties> {
        self.0.unit_mass.map(|unit| unit.scaled(density))
    }

    /// The same for clones of one shape, and for no two others that are alive.
    pub(crate) fn address(&self) -> usize {
        Arc::as_ptr(&self.0) as usize
    }

    /// Whether it is round somewhere.
    pub(crate) fn is_round(&self) -> bool {
        use Geometry::{Ball, Capsule, Cone, Cylinder};
        matches!(self.geometry(), Ball { .. } | Capsule { .. } | Cylinder { .. } | Cone { .. })
    }

    /// Whether it consists of several convex forms.
    pub(crate) fn is_compound(&self) -> bool {
        matches!(self.geometry(), Geometry::Compound { .. })
    }

    pub(crate) fn parry(&self) -> &SharedShape {
        &self.0.parry
    }

    /// The host's number of a triangle of parry3d's mesh.
    pub(crate) fn host_triangle(&self, number: u32) -> u32 {
        self.0.host_triangles.get(number as usize).copied().unwrap_or(number)
    }

    /// The hull that the shape is, if it is one.
    pub(crate) fn hull(&self) -> Option<&Hull> {
        self.0.parry.as_shape::<Hull>()
    }
}

impl std::fmt::Debug for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Shape").field(&self.0.geometry).finish()
    }
}

/// Which shapes a shape collides with: two collide if each one's `member_of` meets the other's `collides_with`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CollisionFilter {
    /// Bit set of groups this shape belongs to.
    pub member_of: u32,
    /// Bit set of groups this shape collides with.
    pub collides_with: u32,
}

impl CollisionFilter {
    pub(crate) fn accepts(&self, other: &Self) -> bool {
        self.member_of & other.collides_with != 0 && other.member_of & self.collides_with != 0
    }
}

impl Default for CollisionFilter {
    fn default() -> Self {
        Self { member_of: 1, collides_with: u32::MAX }
    }
}

/// A shape on a body: form, place, surface, density.
#[derive(Debug, Clone)]
pub struct ShapeDef {
    /// Form.
    pub shape: Shape,
    /// Place on the body.
    pub local_pose: LocalPose,
    /// Surface.
    pub material: Material,
    /// Density (kg/m³), ≥ 0; gives the body its mass unless that is set outright.
    pub density: f32,
    /// Which other shapes it collides with.
    pub filter: CollisionFilter,
    /// The host's own word; the world only hands it back.
    pub user_word: u64,
    /// Whether it only tells what it overlaps: it touches nothing, no query finds it, and it has no mass.
    pub sensor: bool,
}

impl ShapeDef {
    /// Default density (kg/m³), that of water.
    pub const DEFAULT_DENSITY: f32 = 1000.0;

    /// `shape` in the body's own frame, with default surface, density and filter.
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            local_pose: LocalPose::IDENTITY,
            material: Material::default(),
            density: Self::DEFAULT_DENSITY,
            filter: CollisionFilter::default(),
            user_word: 0,
            sensor: false,
        }
    }

    /// The same as a sensor.
    #[must_use]
    pub fn sensing(mut self) -> Self {
        self.sensor = true;
        self
    }

    pub(crate) fn checked(mut self, body_is_dynamic: bool) -> Result<Self> {
        self.local_pose = self.local_pose.checked()?;
        self.material.check()?;
        check::not_negative("density", self.density)?;
        if body_is_dynamic && !self.shape.geometry().is_solid() {
            return Err(Error::new(
                ErrorKind::NotApplicable,
                "shape",
                "meshes, height fields and half-spaces belong on static or kinematic bodies",
            ));
        }
        Ok(self)
    }
}

impl Geometry {
    /// Whether the form encloses a volume, so that a dynamic body may carry it.
    pub fn is_solid(&self) -> bool {
        !matches!(self, Self::TriangleMesh { .. } | Self::HeightField { .. } | Self::HalfSpace { .. })
    }
}

fn build(geometry: &Geometry) -> Result<SharedShape> {
    Ok(match geometry {
        Geometry::Ball { radius } => SharedShape::ball(extent("radius", *radius)?),
        Geometry::Box { half_extents } => SharedShape::cuboid(
            extent("half_extents.x", half_extents.x)?,
            extent("half_extents.y", half_extents.y)?,
            extent("half_extents.z", half_extents.z)?,
        ),
        Geometry::Capsule { half_height, radius } => {
            SharedShape::capsule_y(extent("half_height", *half_height)?, extent("radius", *radius)?)
        }
        Geometry::Cylinder { half_height, radius } => {
            SharedShape::cylinder(extent("half_height", *half_height)?, extent("radius", *radius)?)
        }
        Geometry::Cone { half_height, radius } => {
            SharedShape::cone(extent("half_height", *half_height)?, extent("radius", *radius)?)
        }
        Geometry::ConvexHull { points } => convex_hull(points)?,
        Geometry::TriangleMesh { vertices, triangles } => triangle_mesh(vertices, triangles)?,
        Geometry::HeightField { rows, columns, heights, size_x, size_z } => {
            height_field(*rows, *columns, heights, *size_x, *size_z)?
        }
        Geometry::HalfSpace { normal } => SharedShape::halfspace(check::direction("normal", *normal)?),
        Geometry::Compound { parts } => compound(parts)?,
    })
}

/// Which triangles of the host a mesh still has: parry3d leaves out those with two corners in one place.
fn host_triangles(geometry: &Geometry, parry: &dyn parry3d::shape::Shape) -> Vec<u32> {
    let (Geometry::TriangleMesh { vertices, triangles }, Some(mesh)) = (geometry, parry.as_trimesh()) else {
        return Vec::new();
    };
    if mesh.indices().len() == triangles.len() {
        return Vec::new();
    }
    let mut kept = (0..).zip(triangles).filter(|(_, triangle)| {
        let [a, b, c] = triangle.map(|index| vertices[index as usize]);
        a != b && b != c && c != a
    });
    mesh.indices().iter().filter_map(|_| Some(kept.next()?.0)).collect()
}

/// Mass properties at a density of 1 kg/m³: of a hull, those of exactly the surface that was given; none without volume.
fn unit_mass(geometry: &Geometry, parry: &dyn parry3d::shape::Shape) -> Option<MassProperties> {
    match geometry {
        Geometry::ConvexHull { .. } => Some(MassProperties::from_weight(&weigh(parry.as_shape::<Hull>()?.surface()))),
        Geometry::Compound { parts } => {
            let built = parry.as_compound()?.shapes();
            let weighed = parts.iter().zip(built);
            let weighed = weighed.filter_map(|((pose, part), (_, built))| Some(unit_mass(part, &**built)?.placed(*pose)));
            mass::combined(&weighed.collect::<Vec<_>>())
        }
        _ if geometry.is_solid() => Some(MassProperties::from_parry(&parry.mass_properties(1.0))),
        _ => None,
    }
}

fn extent(argument: &'static str, value: f32) -> Result<f32> {
    if check::positive(argument, value)? < EXTENT_RANGE.0 {
        return Err(Error::new(ErrorKind::Degenerate, argument, "is smaller than 1e-5 m"));
    }
    if value > EXTENT_RANGE.1 {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "is greater than 1e6 m"));
    }
    Ok(value)
}

fn points_in_range(argument: &'static str, points: &[Vec3]) -> Result<()> {
    for &point in points {
        if check::finite_vec(argument, point)?.abs().max_element() > EXTENT_RANGE.1 {
            return Err(Error::new(ErrorKind::OutOfRange, argument, "holds a coordinate beyond 1e6 m"));
        }
    }
    Ok(())
}

fn convex_hull(points: &[Vec3]) -> Result<SharedShape> {
    points_in_range("points", points)?;
    if points.len() < 4 {
        return Err(Error::new(ErrorKind::Degenerate, "points", "a hull needs at least four points"));
    }
    if points.len() > MAX_HULL_POINTS {
        return Err(Error::new(ErrorKind::OutOfRange, "points", "a hull takes at most 4096 points"));
    }
    spans_a_volume(points)?;
    let degenerate = Error::new(ErrorKind::Degenerate, "points", "do not span a convex solid");
    Ok(SharedShape::new(Hull::new(points).ok_or(degenerate)?))
}

/// Refuses points on one point, line or plane: the spread along the third direction is compared with the first.
fn spans_a_volume(points: &[Vec3]) -> Result<()> {
    let refuse = |problem| Err(Error::new(ErrorKind::Degenerate, "points", problem));
    let origin = points[0];
    let farthest = |measure: &dyn Fn(Vec3) -> f32| {
        points.iter().map(|&p| p - origin).max_by(|a, b| measure(*a).total_cmp(&measure(*b))).unwrap_or(Vec3::ZERO)
    };
    let along = farthest(&|d| d.length_squared());
    let length = along.length();
    if length < EXTENT_RANGE.0 {
        return refuse("all points coincide");
    }
    let axis = along / length;
    let across = farthest(&|d| d.reject_from_normalized(axis).length_squared()).reject_from_normalized(axis);
    if across.length() < MIN_HULL_ASPECT * length {
        return refuse("all points lie on one line");
    }
    let normal = axis.cross(across.normalize());
    if farthest(&|d| d.dot(normal).abs()).dot(normal).abs() < MIN_HULL_ASPECT * length {
        return refuse("all points lie in one plane");
    }
    Ok(())
}

fn triangle_mesh(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<SharedShape> {
    points_in_range("vertices", vertices)?;
    if triangles.is_empty() {
        return Err(Error::new(ErrorKind::Degenerate, "triangles", "a mesh needs at least one triangle"));
    }
    if triangles.iter().flatten().any(|&index| index as usize >= vertices.len()) {
        return Err(Error::new(ErrorKind::IndexOutOfRange, "triangles", "an index points past the last vertex"));
    }
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|index| vertices[index as usize]);
        (b - a).cross(c - a).length()
    };
    if triangles.iter().all(|t| area(t) <= EXTENT_RANGE.0 * EXTENT_RANGE.0) {
        return Err(Error::new(ErrorKind::Degenerate, "triangles", "no triangle has an area"));
    }
    let flags = parry3d::shape::TriMeshFlags::FIX_INTERNAL_EDGES | parry3d::shape::TriMeshFlags::DELETE_DEGENERATE_TRIANGLES;
    SharedShape::trimesh_with_flags(vertices.to_vec(), triangles.to_vec(), flags)
        .map_err(|_| Error::new(ErrorKind::Degenerate, "triangles", "do not form a mesh"))
}

fn height_field(rows: usize, columns: usize, heights: &[f32], size_x: f32, size_z: f32) -> Result<SharedShape> {
    extent("size_x", size_x)?;
    extent("size_z", size_z)?;
    if rows < 2 || columns < 2 {
        return Err(Error::new(ErrorKind::Degenerate, "rows", "a height field needs at least two rows and two columns"));
    }
    if rows.checked_mul(columns) != Some(heights.len()) {
        return Err(Error::new(ErrorKind::IndexOutOfRange, "heights", "must hold rows × columns values"));
    }
    for &height in heights {
        if check::finite("heights", height)?.abs() > EXTENT_RANGE.1 {
            return Err(Error::new(ErrorKind::OutOfRange, "heights", "holds a height beyond 1e6 m"));
        }
    }
    // parry stores the grid column by column.
    let column_major = (0..rows * columns).map(|i| heights[(i % rows) * columns + i / rows]).collect();
    let flags = parry3d::shape::HeightFieldFlags::FIX_INTERNAL_EDGES;
    Ok(SharedShape::heightfield_with_flags(Array2::new(rows, columns, column_major), Vec3::new(size_x, 1.0, size_z), flags))
}

fn compound(parts: &[(LocalPose, Geometry)]) -> Result<SharedShape> {
    if parts.is_empty() {
        return Err(Error::new(ErrorKind::Degenerate, "parts", "a compound needs at least one part"));
    }
    let mut built = Vec::with_capacity(parts.len());
    for (pose, geometry) in parts {
        if !geometry.is_solid() || matches!(geometry, Geometry::Compound { .. }) {
            return Err(Error::new(ErrorKind::NotApplicable, "parts", "every part of a compound must be convex"));
        }
        built.push((pose.checked()?.to_parry(), build(geometry)?));
    }
    Ok(SharedShape::compound(built))
}

/// Inertia tensor of `principal` moments (kg·m²) in the frame `rotation`.
pub(crate) fn inertia_tensor(principal: Vec3, rotation: Quat) -> Mat3 {
    if principal.x == principal.y && principal.y == principal.z {
        return Mat3::from_diagonal(principal);
    }
    let Mat3 { x_axis: x, y_axis: y, z_axis: z } = Mat3::from_quat(rotation).transpose();
    let [px, py, pz] = [x, y, z].map(|row| row * principal);
    let (xy, xz, yz) = (px.dot(y), px.dot(z), py.dot(z));
    Mat3::from_cols(Vec3::new(px.dot(x), xy, xz), Vec3::new(xy, py.dot(y), yz), Vec3::new(xz, yz, pz.dot(z)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(geometry: Geometry) -> (ErrorKind, &'static str) {
        let error = Shape::new(geometry).expect_err("must be refused");
        (error.kind, error.argument)
    }

    #[test]
    fn what_is_no_solid_is_refused_by_name() {
        let line = (0..6).map(|i| Vec3::new(i as f32, 2.0 * i as f32, 0.0)).collect();
        assert_eq!(refused(Geometry::ConvexHull { points: line }), (ErrorKind::Degenerate, "points"));
        let plane = (0..9).map(|i| Vec3::new((i % 3) as f32, (i / 3) as f32, 1.0)).collect();
        assert_eq!(refused(Geometry::ConvexHull { points: plane }), (ErrorKind::Degenerate, "points"));
        assert_eq!(refused(Geometry::Ball { radius: 0.0 }), (ErrorKind::OutOfRange, "radius"));
        assert_eq!(refused(Geometry::Ball { radius: f32::NAN }), (ErrorKind::NotFinite, "radius"));
        assert_eq!(refused(Geometry::Box { half_extents: Vec3::new(1.0, 0.0, 1.0) }), (ErrorKind::OutOfRange, "half_extents.y"));
        let vertices = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        assert_eq!(
            refused(Geometry::TriangleMesh { vertices, triangles: vec![[0, 1, 3]] }),
            (ErrorKind::IndexOutOfRange, "triangles")
        );
        let heights = vec![0.0; 5];
        assert_eq!(
            refused(Geometry::HeightField { rows: 2, columns: 3, heights, size_x: 1.0, size_z: 1.0 }),
            (ErrorKind::IndexOutOfRange, "heights")
        );
        let normal = Vec3::new(0.0, 0.5, 0.0);
        assert_eq!(refused(Geometry::HalfSpace { normal }), (ErrorKind::NotUnit, "normal"));
        assert_eq!(refused(Geometry::Compound { parts: vec![] }), (ErrorKind::Degenerate, "parts"));
    }

    #[test]
    fn a_box_of_water_weighs_its_volume() {
        let half = Vec3::new(0.1, 0.2, 0.3);
        let mass = Shape::cuboid(half).unwrap().mass_properties(1000.0).unwrap();
        assert!((mass.mass - 48.0).abs() < 1e-3, "{} kg", mass.mass);
        let expected = 48.0 / 3.0 * (half.y * half.y + half.z * half.z);
        let measured = inertia_tensor(mass.principal_inertia, mass.inertia_frame).x_axis.x;
        assert!((measured - expected).abs() < 1e-4 * expected, "{measured} kg·m², expected {expected}");
    }
}
