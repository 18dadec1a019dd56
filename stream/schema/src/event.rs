//! Records of what happened.

use bytemuck::{Pod, Zeroable};

use crate::Wire;
use crate::frame::finite;
use crate::scene::LS_STREAM_SECTION_EVENT;

/// Event: the joint `a` carried more than its limit; values: force (N), torque (N m).
pub const LS_STREAM_EVENT_OVERLOAD: u32 = 1;
/// Event: the joint `a` broke; values: force (N), torque (N m), as at the moment of breaking.
pub const LS_STREAM_EVENT_BROKEN: u32 = 2;
/// Event: a piece `b` has split off the union `a`; 0 for a single body.
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

impl Wire for LsStreamEvent {
    const SECTION: u32 = LS_STREAM_SECTION_EVENT;
    fn is_finite(&self) -> bool {
        finite(&self.values)
    }
}
