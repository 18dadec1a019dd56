//! Records of what happened.

use bytemuck::{Pod, Zeroable};

use crate::Wire;
use crate::frame::{finite, finite_position};
use crate::scene::{LS_STREAM_SECTION_BREAK, LS_STREAM_SECTION_EVENT, LS_STREAM_SECTION_PIECE};

/// Event: the joint `a` carried more than its limit; values: force (N), torque (N m).
pub const LS_STREAM_EVENT_OVERLOAD: u32 = 1;
/// Event: the joint `a` broke; values: mean force (N) and torque (N m) over its window. LsStreamBreak has the rest.
pub const LS_STREAM_EVENT_BROKEN: u32 = 2;
/// Event: the union of the body `a` has fallen apart, or lost its anchor; one for each piece, and `b` is a body of it.
/// LsStreamPiece has the rest.
pub const LS_STREAM_EVENT_SPLIT: u32 = 3;
/// Event: the body `a` is supported from now on.
pub const LS_STREAM_EVENT_SUPPORT_GAINED: u32 = 4;
/// Event: the body `a` is no longer supported.
pub const LS_STREAM_EVENT_SUPPORT_LOST: u32 = 5;
/// Event: the body `a` had a state that is NaN or infinite, and is taken out of the simulation.
pub const LS_STREAM_EVENT_QUARANTINED: u32 = 6;
/// Event: a contact between the bodies `a` and `b` began.
pub const LS_STREAM_EVENT_CONTACT_BEGAN: u32 = 7;
/// Event: a contact between the bodies `a` and `b` ended.
pub const LS_STREAM_EVENT_CONTACT_ENDED: u32 = 8;

/// Something that happened in a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamEvent {
    /// The step.
    pub step: u64,
    /// What it happened to: see the kinds.
    pub a: u64,
    /// And what else.
    pub b: u64,
    /// The word that the host gave `a`.
    pub user_word: u64,
    /// LS_STREAM_EVENT_ constant.
    pub kind: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// Numbers as the kinds say, (N) and (N m).
    pub values: [f32; 4],
}

/// A joint that broke. It is gone: its handle means nothing any more.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamBreak {
    /// The step.
    pub step: u64,
    /// The joint that was.
    pub joint: u64,
    /// The word its host gave it.
    pub user_word: u64,
    /// Its first body; 0 for the world.
    pub body_a: u64,
    /// Its second body; 0 for the world.
    pub body_b: u64,
    /// Where it was (m).
    pub point: [f64; 3],
    /// Mean force on B over its window, world axes (N).
    pub force: [f32; 3],
    /// Mean torque on B about its point, world axes (N m).
    pub torque: [f32; 3],
    /// Its load as a fraction of the limit that it broke at; above 1 if by load.
    pub share: f32,
    /// LS_STRENGTH_ constant: that limit.
    pub limit: i32,
    /// LS_BREAK_ constant: why it broke.
    pub cause: i32,
    /// Not used; 0.
    pub reserved: u32,
}

/// A piece of a rigid union that fell apart, or lost its anchor. Which bodies are of it is told of them: LsStreamBody.union_id.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamPiece {
    /// The step.
    pub step: u64,
    /// The union's member of the lowest slot: the same for all pieces of one union.
    pub of_body: u64,
    /// The piece's member of the lowest slot.
    pub first_body: u64,
    /// Its centre of mass at the end of the step (m).
    pub center: [f64; 3],
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: [f32; 3],
    /// Angular velocity: that of a rigid body with its angular momentum (rad/s).
    pub angular_velocity: [f32; 3],
    /// Its mass (kg).
    pub mass: f32,
    /// Number of its bodies.
    pub body_count: u32,
    /// 1 if a fixed joint ties it to the world, or to a body that is not dynamic, else 0.
    pub anchored: u32,
    /// 1 if it has lost its anchor, else 0.
    pub cut_loose: u32,
}

impl Wire for LsStreamBreak {
    const SECTION: u32 = LS_STREAM_SECTION_BREAK;
    fn is_finite(&self) -> bool {
        finite_position(&self.point) && finite(&self.force) && finite(&self.torque) && self.share.is_finite()
    }
}

impl Wire for LsStreamPiece {
    const SECTION: u32 = LS_STREAM_SECTION_PIECE;
    fn is_finite(&self) -> bool {
        let velocities = finite(&self.linear_velocity) && finite(&self.angular_velocity);
        finite_position(&self.center) && velocities && self.mass.is_finite()
    }
}

impl Wire for LsStreamEvent {
    const SECTION: u32 = LS_STREAM_SECTION_EVENT;
    fn is_finite(&self) -> bool {
        finite(&self.values)
    }
}
