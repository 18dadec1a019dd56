//! Shapes: geometry that is checked once and shared by every body that uses it.
//!
//! Geometry is plain data; [`Shape::new`] refuses what cannot be a solid and builds what collision needs from it. Capsules,
//! cylinders and cones stand along the local y axis. parry3d holds the collision form; nothing outside `collide/` uses it.

use std::sync::Arc;

use glam::{Mat3, Quat, Vec3};
use parry3d::shape::SharedShape;

use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::hull::Hull;
use crate::mass::{self, Mass, MassProperties};
use crate::material::Material;

mod build;
pub(crate) mod geometry;

use build::{build, host_triangles, unit_mass};
pub use geometry::{EXTENT_RANGE, Geometry, LocalPose, MAX_HULL_POINTS};

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

    /// Whether there is a filter that it accepts.
    pub(crate) fn accepts_any(&self) -> bool {
        self.member_of != 0 && self.collides_with != 0
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

/// Mass properties of a dynamic body with these shapes.
pub(crate) fn resolve_mass(source: Mass, shapes: &[ShapeDef]) -> Result<MassProperties> {
    match source {
        Mass::Properties(properties) => properties.checked(),
        Mass::FromShapes => {
            let combined = of_shapes(shapes)?;
            mass::checked_mass("density", combined.mass)?;
            combined.checked().map_err(too_thin)
        }
        Mass::Total(total) => {
            mass::checked_mass("mass", total)?;
            let combined = of_shapes(shapes)?;
            combined.scaled(total / combined.mass).checked().map_err(too_thin)
        }
    }
}

/// The host gave shapes, not moments of inertia: what is wrong with those is wrong with the shapes.
fn too_thin(error: Error) -> Error {
    Error::new(error.kind, "shapes", "are too small or too thin: a moment of inertia cannot be inverted")
}

fn of_shapes(shapes: &[ShapeDef]) -> Result<MassProperties> {
    let parts: Vec<MassProperties> = shapes
        .iter()
        .filter(|shape| shape.density > 0.0 && !shape.sensor)
        .filter_map(|shape| Some(shape.shape.mass_properties(shape.density)?.placed(shape.local_pose)))
        .collect();
    mass::combined(&parts).ok_or(Error::new(
        ErrorKind::OutOfRange,
        "mass",
        "a dynamic body needs a shape with density, or mass and inertia of its own",
    ))
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
    fn what_is_wrong_with_a_part_is_told_with_its_number() {
        let good = (LocalPose::IDENTITY, Geometry::Ball { radius: 1.0 });
        let flat = (LocalPose::IDENTITY, Geometry::Box { half_extents: Vec3::new(1.0, -2.0, 1.0) });
        let askew = (LocalPose { rotation: glam::Quat::from_xyzw(0.0, 0.0, 0.0, 2.0), ..LocalPose::IDENTITY }, good.1.clone());
        let told =
            |part| Shape::new(Geometry::Compound { parts: vec![good.clone(), good.clone(), part] }).unwrap_err().to_string();
        assert_eq!(told(flat), "parts[2].half_extents.y: must be greater than zero");
        assert!(told(askew).starts_with("parts[2].local_pose.rotation: "), "a rotation of a part");
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
