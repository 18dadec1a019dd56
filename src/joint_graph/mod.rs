//! Long-range constraints from the graph of joints (Müller et al. 2017, §3.1–3.3): which distances can no pose exceed?
//!
//! A joint that holds two points together makes one node. Two joints on one body are a fixed distance apart: a *segment*. Any
//! path of segments is at least as long as the straight line between its ends, so its length is an upper bound of a distance; with
//! limits on the angles between segments it is a tighter one, and there is a lower bound too.
//!
//! Everything here is pure: arrays of joints and masses in, a list of bounds out. It runs when topology, limits, masses or joint
//! frames have changed, and not otherwise.
//!
//! | file | what |
//! |---|---|
//! | `graph.rs` | joints as nodes, segments inside bodies, the range of the angle between two segments |
//! | `bounds.rs` | bounds along a chain of segments that hold in every pose |
//! | `attachment.rs` | from attachments to what hangs on them (§3.1) |
//! | `hierarchy.rs` | between bodies that are free (§3.2) |
//! | `soft.rs` | between two joints, soft, as the host asks (§3.3) |
//! | `load_class.rs` | which bodies bounds are for |
//! | `load.rs` | which joints a bound carries load past |
//! | `part.rs` | connected parts, and which of them are derived again |
//! | `plane.rs` | chains of parallel hinges, and their planes (§3.4) |
//! | `mesh.rs` | graphs that get no derived bounds |
//! | `union/` | what fixed joints make one body (§3.5) |
//! | `support.rs` | which bodies stand on the ground (§3.6) |

pub(crate) mod attachment;
pub(crate) mod bounds;
pub(crate) mod graph;
pub(crate) mod hierarchy;
mod joint_part;
pub(crate) mod load;
pub(crate) mod load_class;
pub(crate) mod mesh;
pub(crate) mod part;
pub(crate) mod plane;
pub(crate) mod soft;
pub(crate) mod support;
pub(crate) mod union;

use load::NodeId;

use crate::long_range::BoundKind;
pub(crate) use part::{BoundInput, Derived, PartBounds};

/// One side of a joint, by the joint's place in the graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct JointSide {
    pub link: u32,
    pub side: u8,
}

impl JointSide {
    pub(crate) fn other(self) -> Self {
        Self { side: 1 - self.side, ..self }
    }
}

/// A distance that no pose exceeds, or falls below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bound {
    pub kind: BoundKind,
    /// 0 for attachments and for neighbours; each level spans twice as much.
    pub level: u8,
    pub near: JointSide,
    pub far: JointSide,
    /// Greatest and least distance (m).
    pub upper: f32,
    pub lower: f32,
    /// Where its load goes.
    pub path: NodeId,
    /// Its joints in between, as a range of the list of inner joints.
    pub inner: (u32, u32),
    /// What the host asked for, by its place among the requests.
    pub request: Option<u32>,
}

/// A joint on the path of a bound, and how far along segments it is from both ends (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct InnerJoint {
    pub end: JointSide,
    pub before: f32,
    pub after: f32,
    /// Where its load goes.
    pub path: NodeId,
}

/// What is derived, and how far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Choice {
    pub attachment: bool,
    pub hierarchy: bool,
    pub levels: Option<u32>,
}
