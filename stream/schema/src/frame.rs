//! Records of frames: what is true of one step.

use bytemuck::{Pod, Zeroable};

use crate::Wire;

/// Section of LsStreamMotion.
pub const LS_STREAM_SECTION_MOTION: u32 = 1;
/// Section of LsStreamContact.
pub const LS_STREAM_SECTION_CONTACT: u32 = 2;
/// Section of LsStreamJointLoad.
pub const LS_STREAM_SECTION_JOINT_LOAD: u32 = 3;
/// Section of LsStreamBound.
pub const LS_STREAM_SECTION_BOUND: u32 = 4;
/// Section of LsStreamPlane.
pub const LS_STREAM_SECTION_PLANE: u32 = 5;

/// Layer of a stream: contacts of awake bodies, in every frame.
pub const LS_STREAM_LAYER_CONTACTS: u32 = 1;
/// Layer of a stream: what each joint carries, in every frame.
pub const LS_STREAM_LAYER_JOINT_LOADS: u32 = 2;
/// Layer of a stream: long-range bounds, in every frame.
pub const LS_STREAM_LAYER_BOUNDS: u32 = 4;
/// Layer of a stream: planes of hinge chains, in every frame.
pub const LS_STREAM_LAYER_PLANES: u32 = 8;
/// Layer of a stream: an event for each contact that begins or ends.
pub const LS_STREAM_LAYER_CONTACT_EVENTS: u32 = 16;
/// All layers that this version knows.
pub const LS_STREAM_LAYER_ALL: u32 = 31;

/// Body flag: it sleeps.
pub const LS_STREAM_BODY_ASLEEP: u32 = 1;
/// Body flag: whether it is supported is known.
pub const LS_STREAM_BODY_SUPPORT_KNOWN: u32 = 2;
/// Body flag: it is supported.
pub const LS_STREAM_BODY_SUPPORTED: u32 = 4;
/// Body flag: it is of a piece of something that fell apart since the stream was opened.
pub const LS_STREAM_BODY_BROKEN: u32 = 8;

/// A body that moved in a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamMotion {
    /// The body.
    pub body: u64,
    /// The word its host gave it.
    pub user_word: u64,
    /// Rigid union that it is a member of; 0 for none.
    pub union_id: u64,
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
    /// Not used; 0.
    pub reserved: u32,
}

/// A point of a contact in a stream.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamContactPoint {
    /// Halfway between the two surfaces (m).
    pub position: [f64; 3],
    /// Distance of the surfaces along the normal (m), negative if they overlap.
    pub separation: f32,
    /// Force along the normal in the last substep (N), >= 0.
    pub normal_force: f32,
}

/// A contact between two bodies after a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamContact {
    /// One body.
    pub body_a: u64,
    /// The other.
    pub body_b: u64,
    /// Unit normal, from A to B.
    pub normal: [f32; 3],
    /// Number of points, 1 to 4.
    pub point_count: u32,
    /// Friction on B, mean over the last substep (N).
    pub friction_force: [f32; 3],
    /// Not used; 0.
    pub reserved: u32,
    /// The points; those beyond point_count are zero.
    pub points: [LsStreamContactPoint; 4],
}

/// What a joint carries after a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamJointLoad {
    /// The joint.
    pub joint: u64,
    /// Force that it carries, mean over the step (N).
    pub force: f32,
    /// Torque that it carries, mean over the step (N m).
    pub torque: f32,
    /// Fraction of its limit: the greatest of force / break_force, torque / break_torque and, if it can break, its mean load over
    /// the limit that it is nearest to; 0 for a joint without limits.
    pub share: f32,
    /// Distance between the joint points beyond what the joint allows (m).
    pub gap: f32,
}

/// A long-range bound after a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamBound {
    /// Joint at its near end.
    pub near_joint: u64,
    /// Joint at its far end.
    pub far_joint: u64,
    /// The point at its near end (m).
    pub near_point: [f64; 3],
    /// The point at its far end (m).
    pub far_point: [f64; 3],
    /// Distance of the two points (m).
    pub distance: f32,
    /// Greatest distance (m).
    pub upper: f32,
    /// Least distance (m), 0 for none.
    pub lower: f32,
    /// Tension, mean over the step (N); negative where the lower bound pushes.
    pub tension: f32,
    /// LS_BOUND_ constant.
    pub kind: u32,
    /// Level in the hierarchy; 0 for other kinds.
    pub level: u32,
    /// 1 if it had anything to do in the step, else 0.
    pub active: u32,
    /// Not used; 0.
    pub reserved: u32,
}

/// The common plane of a chain of hinges after a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamPlane {
    /// The chain's joint of the lowest slot: it names the chain while both last.
    pub chain: u64,
    /// The plane's point nearest to the middle of the chain (m).
    pub point: [f64; 3],
    /// Unit normal, along the axes of the hinges.
    pub normal: [f32; 3],
    /// Distance from the point of the member that is farthest from it (m).
    pub radius: f32,
}

pub(crate) fn finite<const N: usize>(values: &[f32; N]) -> bool {
    values.iter().all(|value| value.is_finite())
}

pub(crate) fn finite_position(values: &[f64; 3]) -> bool {
    values.iter().all(|value| value.is_finite())
}

impl Wire for LsStreamMotion {
    const SECTION: u32 = LS_STREAM_SECTION_MOTION;
    fn is_finite(&self) -> bool {
        let velocities = finite(&self.linear_velocity) && finite(&self.angular_velocity);
        finite_position(&self.position) && finite(&self.rotation) && velocities
    }
}

impl Wire for LsStreamContact {
    const SECTION: u32 = LS_STREAM_SECTION_CONTACT;
    fn is_finite(&self) -> bool {
        let point = |p: &LsStreamContactPoint| finite_position(&p.position) && finite(&[p.separation, p.normal_force]);
        self.point_count <= 4 && finite(&self.normal) && finite(&self.friction_force) && self.points.iter().all(point)
    }
}

impl Wire for LsStreamJointLoad {
    const SECTION: u32 = LS_STREAM_SECTION_JOINT_LOAD;
    fn is_finite(&self) -> bool {
        finite(&[self.force, self.torque, self.share, self.gap])
    }
}

impl Wire for LsStreamBound {
    const SECTION: u32 = LS_STREAM_SECTION_BOUND;
    fn is_finite(&self) -> bool {
        let points = finite_position(&self.near_point) && finite_position(&self.far_point);
        points && finite(&[self.distance, self.upper, self.lower, self.tension])
    }
}

impl Wire for LsStreamPlane {
    const SECTION: u32 = LS_STREAM_SECTION_PLANE;
    fn is_finite(&self) -> bool {
        finite_position(&self.point) && finite(&self.normal) && self.radius.is_finite()
    }
}
