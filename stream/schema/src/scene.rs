//! Records of what a world consists of.

use bytemuck::{Pod, Zeroable};

use crate::Wire;
use crate::frame::{finite, finite_position};

/// Section of LsStreamBody.
pub const LS_STREAM_SECTION_BODY: u32 = 32;
/// Section of LsStreamShape.
pub const LS_STREAM_SECTION_SHAPE: u32 = 33;
/// Section of LsStreamJoint.
pub const LS_STREAM_SECTION_JOINT: u32 = 34;
/// Section of LsStreamGone, for bodies.
pub const LS_STREAM_SECTION_BODY_GONE: u32 = 35;
/// Section of LsStreamGone, for shapes.
pub const LS_STREAM_SECTION_SHAPE_GONE: u32 = 36;
/// Section of LsStreamGone, for joints.
pub const LS_STREAM_SECTION_JOINT_GONE: u32 = 37;
/// Section of one LsStreamGeometry, its vertices (3 floats each) and its triangles (3 uint32_t each).
pub const LS_STREAM_SECTION_GEOMETRY: u32 = 38;
/// Section of LsStreamEvent.
pub const LS_STREAM_SECTION_EVENT: u32 = 39;
/// Section of LsStreamWorld.
pub const LS_STREAM_SECTION_WORLD: u32 = 40;
/// Section of LsStreamBreak.
pub const LS_STREAM_SECTION_BREAK: u32 = 41;
/// Section of LsStreamPiece.
pub const LS_STREAM_SECTION_PIECE: u32 = 42;

/// Joint flag: it can break.
pub const LS_STREAM_JOINT_BREAKABLE: u32 = 1;

/// A body as it was when the record was written. It replaces what was known of the body.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamBody {
    /// The body.
    pub body: u64,
    /// The word its host gave it.
    pub user_word: u64,
    /// Rigid union that it is a member of; 0 for none.
    pub union_id: u64,
    /// Step after which it stood here.
    pub step: u64,
    /// Position of its frame (m).
    pub position: [f64; 3],
    /// Rotation of its frame, unit quaternion: x, y, z, w.
    pub rotation: [f32; 4],
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: [f32; 3],
    /// Angular velocity, world axes (rad/s).
    pub angular_velocity: [f32; 3],
    /// LS_STREAM_BODY_ flags.
    pub flags: u32,
    /// LS_BODY_ constant.
    pub kind: i32,
    /// Mass (kg); 0 unless it is dynamic.
    pub mass: f32,
    /// LS_SUPPORT_ constant, if the flags say that support is known.
    pub support: i32,
    /// How far its centre of mass lies inside the hull of its supporting contacts (m); 0 where that is not known or infinite.
    pub support_margin: f32,
    /// Load that rests on it (N), if known.
    pub support_load: f32,
}

/// A shape of a body, or one part of a compound shape.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamShape {
    /// The shape.
    pub shape: u64,
    /// Its body.
    pub body: u64,
    /// The word its host gave it.
    pub user_word: u64,
    /// LS_SHAPE_ constant, never LS_SHAPE_COMPOUND: hulls, meshes and height fields come with triangles (LsStreamGeometry).
    pub kind: i32,
    /// Number of the part, from 0.
    pub part: u32,
    /// Number of parts, 1 unless the shape is a compound.
    pub part_count: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// Position in the body's frame (m).
    pub position: [f32; 3],
    /// Rotation in the body's frame, unit quaternion: x, y, z, w.
    pub rotation: [f32; 4],
    /// Ball: radius. Box: half extents. Capsule, cylinder and cone, along y: half height, radius. Half-space: normal. (m)
    pub size: [f32; 3],
    /// Coefficient of friction.
    pub friction: f32,
    /// Coefficient of restitution.
    pub restitution: f32,
}

/// A joint as it was when the record was written.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamJoint {
    /// The joint.
    pub joint: u64,
    /// The word its host gave it.
    pub user_word: u64,
    /// First body; 0 for the world.
    pub body_a: u64,
    /// Second body; 0 for the world.
    pub body_b: u64,
    /// Joint frame on body A, in its frame, or in the world's (m).
    pub position_a: [f64; 3],
    /// Joint frame on body B, in its frame, or in the world's (m).
    pub position_b: [f64; 3],
    /// Rotation of the joint frame on body A, unit quaternion: x, y, z, w.
    pub rotation_a: [f32; 4],
    /// Rotation of the joint frame on body B, unit quaternion: x, y, z, w.
    pub rotation_b: [f32; 4],
    /// LS_JOINT_ constant.
    pub kind: i32,
    /// LS_STREAM_JOINT_ flags.
    pub flags: u32,
    /// Force above which it is overloaded (N); 0 for no limit.
    pub break_force: f32,
    /// Torque above which it is overloaded (N m); 0 for no limit.
    pub break_torque: f32,
}

/// A body, shape or joint that is no more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamGone {
    /// Its handle.
    pub id: u64,
    /// Step before which it went.
    pub step: u64,
}

/// Some triangles of a shape that has no simple form: the whole may come in several of these.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamGeometry {
    /// The shape.
    pub shape: u64,
    /// Number of the shape's part.
    pub part: u32,
    /// Vertices of the whole.
    pub vertex_total: u32,
    /// Triangles of the whole.
    pub triangle_total: u32,
    /// First vertex of these.
    pub first_vertex: u32,
    /// Number of vertices that follow.
    pub vertex_count: u32,
    /// First triangle of these.
    pub first_triangle: u32,
    /// Number of triangles that follow the vertices, as three numbers of vertices of the whole each.
    pub triangle_count: u32,
    /// Not used; 0.
    pub reserved: u32,
}

/// The world that a stream is of.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamWorld {
    /// Bytes of the stream's name in UTF-8, then zeroes.
    pub name: [u8; 64],
    /// Number of the process that steps it.
    pub process: u64,
    /// Gravity (m/s^2).
    pub gravity: [f32; 3],
    /// Substeps a step.
    pub substeps: u32,
    /// Sweeps a substep.
    pub iterations: u32,
    /// 1 if the support analysis is on, else 0.
    pub support: u32,
    /// LS_STREAM_LAYER_ bits of what its frames hold besides motion.
    pub layers: u32,
    /// Every how many steps a frame is published.
    pub every: u32,
}

impl Default for LsStreamWorld {
    fn default() -> Self {
        Zeroable::zeroed()
    }
}

impl Wire for LsStreamBody {
    const SECTION: u32 = LS_STREAM_SECTION_BODY;
    fn is_finite(&self) -> bool {
        let velocities = finite(&self.linear_velocity) && finite(&self.angular_velocity);
        let numbers = finite(&[self.mass, self.support_margin, self.support_load]);
        finite_position(&self.position) && finite(&self.rotation) && velocities && numbers
    }
}

impl Wire for LsStreamShape {
    const SECTION: u32 = LS_STREAM_SECTION_SHAPE;
    fn is_finite(&self) -> bool {
        finite(&self.position) && finite(&self.rotation) && finite(&self.size) && finite(&[self.friction, self.restitution])
    }
}

impl Wire for LsStreamJoint {
    const SECTION: u32 = LS_STREAM_SECTION_JOINT;
    fn is_finite(&self) -> bool {
        let positions = finite_position(&self.position_a) && finite_position(&self.position_b);
        let rotations = finite(&self.rotation_a) && finite(&self.rotation_b);
        positions && rotations && finite(&[self.break_force, self.break_torque])
    }
}

impl Wire for LsStreamWorld {
    const SECTION: u32 = LS_STREAM_SECTION_WORLD;
    fn is_finite(&self) -> bool {
        finite(&self.gravity)
    }
}
