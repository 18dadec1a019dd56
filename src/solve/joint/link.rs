//! What sorting reads of a joint, in a few bytes.

use glam::{DVec3, Quat, Vec3};

use super::{friction, kinds};
use crate::joint_record::Joint;
use crate::settings::Solver;

/// What follows from the definition of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct JointTraits {
    /// Most rows that it can have.
    pub most_rows: u8,
    /// Most of its rows that hold whatever force that takes, and whether it may have others, which act within bounds or along a line.
    pub held_rows: u8,
    pub acts_between: bool,
    /// Whether it holds points rigidly together and does nothing else.
    pub is_plain: bool,
    /// Whether it has stops on angles.
    pub limits_angles: bool,
    /// Whether it has friction.
    pub has_friction: bool,
    /// Whether it gives energy by its motors alone, if by anything, and whether it has one.
    pub gives_by_motors_alone: bool,
    /// Whether the host moves its stops or frames: any of its rows may do work then.
    pub is_driven: bool,
    /// Motors are also stops that give back of the speed at which they are met.
    pub has_motor: bool,
    /// Whether it has a motor that holds a place.
    pub holds_by_motor: bool,
    /// Whether it has one that does not give as a spring does.
    pub has_rigid_motor: bool,
    /// Whether it has stops that give.
    pub has_soft_stops: bool,
    /// Whether anything of it gives as a spring does.
    pub has_springs: bool,
    /// Whether all of it does.
    pub gives: bool,
    /// What it asks of its articulation.
    pub solver: Solver,
}

impl JointTraits {
    /// Of no joint.
    pub(crate) const NONE: Self = Self {
        most_rows: 0,
        held_rows: 0,
        acts_between: false,
        is_plain: false,
        limits_angles: false,
        has_friction: false,
        gives_by_motors_alone: false,
        is_driven: false,
        has_motor: false,
        holds_by_motor: false,
        has_rigid_motor: false,
        has_soft_stops: false,
        has_springs: false,
        gives: false,
        solver: Solver::Auto,
    };

    pub(crate) fn of(joint: &Joint) -> Self {
        let (def, is_driven) = (&joint.def, joint.drive.is_some());
        let most_rows = kinds::most_rows(def);
        let (held_rows, acts_between) = kinds::held_rows(def);
        Self {
            most_rows: most_rows as u8,
            held_rows: held_rows as u8,
            acts_between,
            is_plain: kinds::is_plain(&def.kind, most_rows) && def.linear.compliance == 0.0 && !is_driven,
            limits_angles: kinds::limits_angles(&def.kind),
            has_friction: friction::rows_of(def) > 0,
            // What the host moves does work.
            gives_by_motors_alone: kinds::gives_by_motors_alone(def) && !is_driven,
            is_driven,
            // What a stop gives back is more than it had in the substep before.
            has_motor: kinds::has_motor(&def.kind) || def.restitution > 0.0,
            holds_by_motor: kinds::holds_by_motor(&def.kind),
            has_rigid_motor: kinds::has_rigid_motor(&def.kind),
            has_soft_stops: kinds::has_soft_stops(def),
            has_springs: kinds::has_springs(def),
            gives: kinds::gives(def),
            solver: def.solver,
        }
    }
}

/// What a joint connects.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointLink {
    /// Slot in the world's pool.
    pub joint: u32,
    pub a: u32,
    pub b: u32,
    pub traits: JointTraits,
    /// Whether a direct solve may not take it.
    pub is_withheld: bool,
}

/// One side of a joint: what it hangs on, and where its point is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointEnd {
    pub slot: u32,
    /// World position that displacements count from (m).
    pub origin: DVec3,
    /// Joint point from there, in the body's frame (m).
    pub lever: Vec3,
    pub frame: Quat,
}
