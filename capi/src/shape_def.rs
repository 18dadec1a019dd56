//! What a shape is made from, as C describes it.

use std::ptr;

use ls_core::glam::{Quat, Vec3};
use ls_core::{CollisionFilter, Geometry, LocalPose, Material, Shape, ShapeDef};

use crate::boundary::call;
use crate::enums;
use crate::pointer::{host, slice};
use crate::result::{Failure, LS_ERROR_NOT_APPLICABLE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_STRUCT_SIZE, LsResult, Outcome};
use crate::sized::{self, Definition, SizedOut, Versioned};

/// Shape kind: a ball; radius.
pub const LS_SHAPE_BALL: i32 = 0;
/// Shape kind: a box; half_extents.
pub const LS_SHAPE_BOX: i32 = 1;
/// Shape kind: a cylinder along y with hemispheres at its ends; half_height of the cylinder, radius.
pub const LS_SHAPE_CAPSULE: i32 = 2;
/// Shape kind: a cylinder along y; half_height, radius.
pub const LS_SHAPE_CYLINDER: i32 = 3;
/// Shape kind: a cone along y, tip up, with its origin halfway up; half_height, radius of the base.
pub const LS_SHAPE_CONE: i32 = 4;
/// Shape kind: the convex hull of 4 to 4096 points that are not all in one plane; points.
pub const LS_SHAPE_CONVEX_HULL: i32 = 5;
/// Shape kind: triangles, for static and kinematic bodies only; points, triangles.
pub const LS_SHAPE_TRIANGLE_MESH: i32 = 6;
/// Shape kind: heights on a grid, centred on the origin, for static and kinematic bodies only; heights, rows, columns,
/// size_x, size_z.
pub const LS_SHAPE_HEIGHT_FIELD: i32 = 7;
/// Shape kind: all points below a plane through the origin, for static and kinematic bodies only; normal.
pub const LS_SHAPE_HALF_SPACE: i32 = 8;
/// Shape kind: several convex shapes as one, with one material; parts.
pub const LS_SHAPE_COMPOUND: i32 = 9;

/// Combine rule: square root of the product. Where two touching shapes have different rules, the greater number wins.
pub const LS_COMBINE_GEOMETRIC_MEAN: i32 = 0;
/// Combine rule: arithmetic mean.
pub const LS_COMBINE_AVERAGE: i32 = 1;
/// Combine rule: the smaller value.
pub const LS_COMBINE_MINIMUM: i32 = 2;
/// Combine rule: the product.
pub const LS_COMBINE_MULTIPLY: i32 = 3;
/// Combine rule: the greater value.
pub const LS_COMBINE_MAXIMUM: i32 = 4;

/// Surface of a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsMaterial {
    /// Coulomb friction coefficient, >= 0; default 0.5.
    pub friction: f32,
    /// Rebound speed over approach speed, 0 to 1; default 0. Used above the world's restitution_threshold.
    pub restitution: f32,
    /// Rolling friction: torque limit about tangent axes per normal force (m), >= 0; default 0. Of two shapes the greater counts.
    pub rolling_friction: f32,
    /// Spinning friction: torque limit about the normal per normal force (m), >= 0, beside that of the contact's own extent;
    /// default 0. Of two shapes the greater counts.
    pub spinning_friction: f32,
    /// LS_COMBINE_ constant: how friction combines; default LS_COMBINE_GEOMETRIC_MEAN.
    pub friction_rule: i32,
    /// LS_COMBINE_ constant: how restitution combines; default LS_COMBINE_MAXIMUM.
    pub restitution_rule: i32,
}

/// Which shapes a shape collides with: two collide if each one's member_of meets the other's collides_with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LsCollisionFilter {
    /// Bit set of groups this shape belongs to; default 1.
    pub member_of: u32,
    /// Bit set of groups this shape collides with; default all.
    pub collides_with: u32,
}

/// A shape: form, place on its body, surface, density. Of the geometry fields only those are read that its kind names.
///
/// Fill it with ls_shape_def_init first. Arrays are read during the call that takes the definition and not kept.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsShapeDef {
    /// Size of this struct in the host, set by ls_shape_def_init.
    pub struct_size: u32,
    /// LS_SHAPE_ constant; default LS_SHAPE_BALL.
    pub kind: i32,
    /// Half of each edge of a box (m), 1e-5 to 1e6; default 0.5.
    pub half_extents: [f32; 3],
    /// Half the height of a capsule's cylinder, a cylinder or a cone (m), 1e-5 to 1e6; default 0.5.
    pub half_height: f32,
    /// Radius of a ball, capsule, cylinder or cone (m), 1e-5 to 1e6; default 0.5.
    pub radius: f32,
    /// Outward unit normal of a half-space; default +y.
    pub normal: [f32; 3],
    /// Points of a hull or vertices of a mesh (m): three floats each.
    pub points: *const f32,
    /// Number of points.
    pub point_count: usize,
    /// Triangles of a mesh: three indices of points each, counter-clockwise seen from outside.
    pub triangles: *const u32,
    /// Number of triangles.
    pub triangle_count: usize,
    /// Heights of a height field along y (m), row by row.
    pub heights: *const f32,
    /// Number of heights; must be rows x columns.
    pub height_count: usize,
    /// Rows of a height field, along z; at least 2.
    pub rows: u32,
    /// Columns of a height field, along x; at least 2.
    pub columns: u32,
    /// Extent of a whole height field along x (m); default 1.
    pub size_x: f32,
    /// Extent of a whole height field along z (m); default 1.
    pub size_z: f32,
    /// Parts of a compound, all with the same struct_size; of each, its geometry, local_position and local_rotation are read.
    pub parts: *const LsShapeDef,
    /// Number of parts.
    pub part_count: usize,
    /// Origin of the shape in the body's frame (m); default zero.
    pub local_position: [f32; 3],
    /// Rotation of the shape in the body's frame, unit quaternion x, y, z, w; default none.
    pub local_rotation: [f32; 4],
    /// Density (kg/m^3), >= 0; gives the body its mass unless that is set outright; default 1000.
    pub density: f32,
    /// Surface.
    pub material: LsMaterial,
    /// Which other shapes it collides with.
    pub filter: LsCollisionFilter,
    /// The host's own word; the library only hands it back.
    pub user_word: u64,
    /// Not 0: a sensor, which only tells what it overlaps (ls_world_sensor_overlaps_begun_get): it touches nothing, no query finds it, and it
    /// has no mass; default 0.
    pub sensor: u32,
    /// Not used; 0.
    pub reserved: u32,
}

// SAFETY: numbers and raw pointers without padding.
unsafe impl Versioned for LsShapeDef {
    const SIZES: &'static [usize] = &[192, 200];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsShapeDef {}

impl Default for LsShapeDef {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            kind: LS_SHAPE_BALL,
            half_extents: [0.5; 3],
            half_height: 0.5,
            radius: 0.5,
            normal: [0.0, 1.0, 0.0],
            points: ptr::null(),
            point_count: 0,
            triangles: ptr::null(),
            triangle_count: 0,
            heights: ptr::null(),
            height_count: 0,
            rows: 0,
            columns: 0,
            size_x: 1.0,
            size_z: 1.0,
            parts: ptr::null(),
            part_count: 0,
            local_position: [0.0; 3],
            local_rotation: Quat::IDENTITY.to_array(),
            density: ShapeDef::DEFAULT_DENSITY,
            material: Material::default().into(),
            filter: CollisionFilter::default().into(),
            user_word: 0,
            sensor: 0,
            reserved: 0,
        }
    }
}

/// Fills a shape definition with defaults: a ball of radius 0.5 m, friction 0.5, density 1000 kg/m^3.
///
/// @param def   filled on LS_OK
/// @param size  sizeof *def as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_shape_def_init(def: *mut LsShapeDef, size: usize) -> LsResult {
    call("ls_shape_def_init", || host!(SizedOut::new, def, size).write_definition(&LsShapeDef::default()))
}

impl From<Material> for LsMaterial {
    fn from(material: Material) -> Self {
        Self {
            friction: material.friction,
            restitution: material.restitution,
            rolling_friction: material.rolling_friction,
            spinning_friction: material.spinning_friction,
            friction_rule: enums::from_combine_rule(material.friction_rule),
            restitution_rule: enums::from_combine_rule(material.restitution_rule),
        }
    }
}

impl TryFrom<LsMaterial> for Material {
    type Error = Failure;
    fn try_from(material: LsMaterial) -> Outcome<Self> {
        Ok(Self {
            friction: material.friction,
            restitution: material.restitution,
            rolling_friction: material.rolling_friction,
            spinning_friction: material.spinning_friction,
            friction_rule: enums::combine_rule(material.friction_rule, "friction_rule")?,
            restitution_rule: enums::combine_rule(material.restitution_rule, "restitution_rule")?,
        })
    }
}

impl From<CollisionFilter> for LsCollisionFilter {
    fn from(filter: CollisionFilter) -> Self {
        Self { member_of: filter.member_of, collides_with: filter.collides_with }
    }
}

impl From<LsCollisionFilter> for CollisionFilter {
    fn from(filter: LsCollisionFilter) -> Self {
        Self { member_of: filter.member_of, collides_with: filter.collides_with }
    }
}

impl From<&ShapeDef> for LsShapeDef {
    fn from(def: &ShapeDef) -> Self {
        Self {
            density: def.density,
            material: def.material.into(),
            filter: def.filter.into(),
            user_word: def.user_word,
            sensor: def.sensor.into(),
            ..Self::of_geometry(def.shape.geometry(), def.local_pose)
        }
    }
}

impl LsShapeDef {
    /// A form and its place; its arrays are those of `geometry`.
    pub(crate) fn of_geometry(geometry: &Geometry, pose: LocalPose) -> Self {
        let mut def =
            Self { local_position: pose.position.to_array(), local_rotation: pose.rotation.to_array(), ..Self::default() };
        match geometry {
            &Geometry::Ball { radius } => (def.kind, def.radius) = (LS_SHAPE_BALL, radius),
            Geometry::Box { half_extents } => (def.kind, def.half_extents) = (LS_SHAPE_BOX, half_extents.to_array()),
            &Geometry::Capsule { half_height, radius } => {
                (def.kind, def.half_height, def.radius) = (LS_SHAPE_CAPSULE, half_height, radius);
            }
            &Geometry::Cylinder { half_height, radius } => {
                (def.kind, def.half_height, def.radius) = (LS_SHAPE_CYLINDER, half_height, radius);
            }
            &Geometry::Cone { half_height, radius } => {
                (def.kind, def.half_height, def.radius) = (LS_SHAPE_CONE, half_height, radius);
            }
            Geometry::ConvexHull { points } => {
                (def.kind, def.points, def.point_count) = (LS_SHAPE_CONVEX_HULL, points.as_ptr().cast(), points.len());
            }
            Geometry::TriangleMesh { vertices, triangles } => {
                (def.kind, def.points, def.point_count) = (LS_SHAPE_TRIANGLE_MESH, vertices.as_ptr().cast(), vertices.len());
                (def.triangles, def.triangle_count) = (triangles.as_ptr().cast(), triangles.len());
            }
            Geometry::HeightField { rows, columns, heights, size_x, size_z } => {
                (def.kind, def.heights, def.height_count) = (LS_SHAPE_HEIGHT_FIELD, heights.as_ptr(), heights.len());
                // A field has as many heights as rows times columns, each at least 2, and was made from 32-bit numbers of them.
                (def.rows, def.columns) = (*rows as u32, *columns as u32);
                (def.size_x, def.size_z) = (*size_x, *size_z);
            }
            Geometry::HalfSpace { normal } => (def.kind, def.normal) = (LS_SHAPE_HALF_SPACE, normal.to_array()),
            Geometry::Compound { parts } => (def.kind, def.part_count) = (LS_SHAPE_COMPOUND, parts.len()),
            _ => {}
        }
        def
    }
}

impl LsShapeDef {
    /// # Safety
    /// The pointers that the kind names are null or valid for reading as many elements as their counts say.
    pub(crate) unsafe fn to_core(self) -> Outcome<ShapeDef> {
        // SAFETY: as promised to this function.
        let geometry = unsafe { self.geometry() }?;
        Ok(ShapeDef {
            shape: Shape::new(geometry)?,
            local_pose: self.local_pose(),
            material: self.material.try_into()?,
            density: self.density,
            filter: self.filter.into(),
            user_word: self.user_word,
            sensor: self.sensor != 0,
        })
    }

    fn local_pose(&self) -> LocalPose {
        LocalPose { position: Vec3::from_array(self.local_position), rotation: Quat::from_array(self.local_rotation) }
    }

    /// # Safety
    /// As for [`to_core`](Self::to_core).
    unsafe fn geometry(&self) -> Outcome<Geometry> {
        let Self { half_height, radius, size_x, size_z, .. } = *self;
        Ok(match self.kind {
            LS_SHAPE_BALL => Geometry::Ball { radius },
            LS_SHAPE_BOX => Geometry::Box { half_extents: Vec3::from_array(self.half_extents) },
            LS_SHAPE_CAPSULE => Geometry::Capsule { half_height, radius },
            LS_SHAPE_CYLINDER => Geometry::Cylinder { half_height, radius },
            LS_SHAPE_CONE => Geometry::Cone { half_height, radius },
            // SAFETY: as promised to this function.
            LS_SHAPE_CONVEX_HULL => Geometry::ConvexHull { points: unsafe { self.points() }? },
            LS_SHAPE_TRIANGLE_MESH => Geometry::TriangleMesh {
                // SAFETY: as promised to this function.
                vertices: unsafe { self.points() }?,
                // SAFETY: as promised to this function.
                triangles: unsafe { slice(self.triangles.cast::<[u32; 3]>(), self.triangle_count, "triangles") }?.to_vec(),
            },
            LS_SHAPE_HEIGHT_FIELD => Geometry::HeightField {
                rows: self.rows as usize,
                columns: self.columns as usize,
                // SAFETY: as promised to this function.
                heights: unsafe { slice(self.heights, self.height_count, "heights") }?.to_vec(),
                size_x,
                size_z,
            },
            LS_SHAPE_HALF_SPACE => Geometry::HalfSpace { normal: Vec3::from_array(self.normal) },
            // SAFETY: as promised to this function.
            LS_SHAPE_COMPOUND => Geometry::Compound { parts: unsafe { self.parts() }? },
            _ => return Err(enums::unknown("kind")),
        })
    }

    /// # Safety
    /// As for [`to_core`](Self::to_core).
    unsafe fn points(&self) -> Outcome<Vec<Vec3>> {
        // SAFETY: as promised to this function.
        let points = unsafe { slice(self.points.cast::<[f32; 3]>(), self.point_count, "points") }?;
        Ok(points.iter().copied().map(Vec3::from_array).collect())
    }

    /// # Safety
    /// As for [`to_core`](Self::to_core).
    unsafe fn parts(&self) -> Outcome<Vec<(LocalPose, Geometry)>> {
        // SAFETY: as promised to this function.
        let parts = unsafe { read_array(self.parts, self.part_count, "parts") }?;
        let part = |(number, part): (usize, LsShapeDef)| {
            // Stops a compound that contains itself.
            if part.kind == LS_SHAPE_COMPOUND {
                return Err(Failure::Refused(LS_ERROR_NOT_APPLICABLE, "parts", "every part of a compound must be convex"));
            }
            // SAFETY: as promised to this function, for its parts too.
            let geometry = unsafe { part.geometry() }.map_err(|failure| failure.in_part(number))?;
            Ok((part.local_pose(), geometry))
        };
        parts.into_iter().enumerate().map(part).collect()
    }
}

/// Reads an array of shape definitions whose distance is the size that the first declares.
///
/// # Safety
/// `first` is null, or valid for reading `count` definitions of that size.
pub(crate) unsafe fn read_array(first: *const LsShapeDef, count: usize, name: &'static str) -> Outcome<Vec<LsShapeDef>> {
    if count == 0 {
        return Ok(Vec::new());
    }
    // SAFETY: as promised to this function.
    let stride = unsafe { sized::declared_size(first, name) }?;
    if count.checked_mul(stride).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Failure::Refused(LS_ERROR_OUT_OF_RANGE, name, "the count is larger than memory"));
    }
    let mut defs = Vec::new();
    for i in 0..count {
        // SAFETY: inside the array, which is no longer than memory.
        let def = unsafe { sized::read(first.byte_add(i * stride), name) }?;
        if def.struct_size as usize != stride {
            return Err(Failure::Refused(LS_ERROR_STRUCT_SIZE, name, "elements differ in struct_size"));
        }
        defs.push(def);
    }
    Ok(defs)
}
