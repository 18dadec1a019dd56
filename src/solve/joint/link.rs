//! A joint as it is asked for where joints are sorted: in a few bytes, where an entry has hundreds.

use crate::settings::Solver;

/// What a joint connects.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointLink {
    /// Slot in the world's pool.
    pub joint: u32,
    pub a: u32,
    pub b: u32,
    /// Most rows that it can have.
    pub most_rows: u8,
    /// As in its [`JointEntry`](super::JointEntry).
    pub is_plain: bool,
    pub has_friction: bool,
    pub gives_by_motors_alone: bool,
    pub has_motor: bool,
    /// What its definition asks of its articulation.
    pub solver: Solver,
    /// Whether a direct solve may not take it.
    pub is_withheld: bool,
}
