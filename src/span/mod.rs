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
//! | `soft.rs` | asked for between two joints, with give (§3.3) |
//! | `weight.rs` | which bodies bounds are for |
//! | `load.rs` | which joints a bound carries load past |
//! | `plane.rs` | chains of parallel hinges, and their planes (§3.4) |
//! | `sheet.rs` | graphs that are left without bounds |
//! | `union/` | what fixed joints make one body (§3.5) |
//! | `support.rs` | which bodies stand on the ground (§3.6) |
//! | `eigen.rs` | principal axes |

pub(crate) mod attachment;
pub(crate) mod bounds;
pub(crate) mod eigen;
pub(crate) mod graph;
pub(crate) mod hierarchy;
pub(crate) mod load;
pub(crate) mod plane;
pub(crate) mod sheet;
pub(crate) mod soft;
pub(crate) mod support;
pub(crate) mod union;
pub(crate) mod weight;

use graph::Graph;
use load::{LoadPaths, NodeId};

/// Why a bound is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum BoundKind {
    /// From a static or kinematic attachment to what hangs on it.
    Attachment,
    /// Between two bodies that are free.
    Hierarchy,
    /// Asked for by the host between two joints, with give.
    Soft,
}

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
    /// Its joints in between, as a range of [`Derived::inner`].
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Choice {
    pub attachment: bool,
    pub hierarchy: bool,
    pub levels: Option<u32>,
}

/// Everything derived from a graph.
#[derive(Debug, Default)]
pub(crate) struct Derived {
    pub graph: Graph,
    pub bounds: Vec<Bound>,
    /// Joints on the paths of bounds.
    pub inner: Vec<InnerJoint>,
    pub paths: LoadPaths,
    /// What it was derived with besides the graph.
    made_with: Option<(Choice, Vec<soft::Request>)>,
}

impl Derived {
    /// Derives all bounds of a graph, if they are not those that are here already: as after an edit that came to nothing, or where
    /// a host goes back to a state with the same joints.
    pub(crate) fn follow(&mut self, graph: Graph, choice: Choice, soft: Vec<soft::Request>) {
        let is_same = self.made_with.as_ref().is_some_and(|made_with| *made_with == (choice, soft.clone()));
        if is_same && self.graph.is_same(&graph) {
            return;
        }
        self.graph = graph;
        self.rebuild(choice, &soft);
        self.made_with = Some((choice, soft));
    }

    /// Derives all bounds anew; `graph` holds the joints as they are.
    fn rebuild(&mut self, choice: Choice, soft: &[soft::Request]) {
        self.bounds.clear();
        self.inner.clear();
        self.paths.clear();
        self.graph.connect();
        soft::derive(self, soft);
        let weights = weight::weigh(&self.graph);
        if choice.hierarchy {
            hierarchy::derive(self, &weights, choice.levels);
        }
        if choice.attachment {
            attachment::derive(self, &weights);
        }
    }
}
