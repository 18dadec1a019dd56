//! What bounds, unions and held units carry from step to step: the rest of them is derived.

use glam::Vec3;

use crate::id::JointId;
use crate::joint_graph::union::UnionMotion;
use crate::long_range::{BoundKind, SoftBound};

/// What the host asked for between two joints, the lower handle first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AskedBound {
    pub joints: [JointId; 2],
    pub bound: SoftBound,
}

/// What a bound carries from step to step, as a snapshot keeps it: the rest is derived.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CarriedBound {
    pub kind: BoundKind,
    pub level: u8,
    pub upper: f32,
    pub lower: f32,
    pub ends: [(u32, u8); 2],
    pub impulses: [f32; 2],
    pub far_force: Vec3,
    pub active: bool,
}

/// What a union carries from step to step, as a snapshot keeps it: the rest is derived.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CarriedUnion {
    pub lead: u32,
    pub motion: UnionMotion,
    pub before: Option<UnionMotion>,
}

/// A body of a unit that is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HeldBody {
    pub body: u32,
    /// Force (N) and moment about the centre of mass (N·m) of what is beside the unit, as it was engaged.
    pub load: [Vec3; 2],
}

/// Those of a unit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeldUnit {
    pub bodies: Vec<HeldBody>,
}
