//! One connected part of the joint graph, and what is derived of it.

use super::graph::JointGraph;
use super::load::LoadPaths;
use super::{Bound, InnerJoint};

/// One part: its joints and bodies, and the bounds between them. Links are numbers in `joints`.
#[derive(Debug, Default)]
pub(crate) struct JointPart {
    /// Slots of its joints and of its bodies, in order.
    pub joints: Vec<u32>,
    pub bodies: Vec<u32>,
    pub graph: JointGraph,
    pub bounds: Vec<Bound>,
    /// Joints on the paths of bounds.
    pub inner: Vec<InnerJoint>,
    pub paths: LoadPaths,
}
