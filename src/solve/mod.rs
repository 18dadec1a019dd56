//! The solver: substeps of one batch of islands, on arrays of its own.
//!
//! A *batch* is one island, or several small ones, with its own copy of the bodies' state and its own rows, sorted by colour.
//! Batches share nothing and are solved side by side; an island's result does not depend on the batch it is in.
//!
//! A substep: forces → joint rows at predicted poses, warm start → sweeps of joints and contacts → poses → position rows of
//! joints → impacts. After the substeps: position recovery of contacts. What moves positions gives no velocity.

pub(crate) mod batch;
pub(crate) mod body_flags;
mod body_gather;
mod body_warm_start;
mod buckets;
mod color;
pub(crate) mod contact;
mod contact_block;
mod contact_energy;
mod contact_kernels;
mod contact_newton;
mod contact_partition;
pub(crate) mod direct;
pub(crate) mod disjoint;
pub(crate) mod distance_bound;
mod followed_velocity;
mod forest;
mod impact;
mod initial_impulses;
pub(crate) mod integrate;
pub(crate) mod joint;
mod joint_closing;
mod joint_energy;
mod joint_mesh;
mod meetings;
pub(crate) mod momentum;
pub(crate) mod momentum_pass;
pub(crate) mod newton;
mod parallel_contacts;
pub(crate) mod plan;
pub(crate) mod plane;
mod recovery;
mod rotation;
pub(crate) mod round_contacts;
pub(crate) mod slides;
mod smeared_spins;
mod stances;
pub(crate) mod state;
pub(crate) mod step;
pub(crate) mod taut_line;
pub(crate) mod velocity_half_step;
mod wide_bodies;
mod wide_matrix;
pub(crate) mod wrapped_bound;
mod yielding_motors;

pub(crate) use crate::contact::status;

/// What all batches of a step have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepSettings {
    /// Length of the step (s).
    pub dt: f32,
    /// Acceleration of free fall (m/s²).
    pub gravity: glam::Vec3,
    pub substeps: u32,
    pub iterations: u32,
    pub articulations: crate::settings::ArticulationSettings,
    /// Approach speed above which a contact rebounds (m/s).
    pub restitution_threshold: f32,
    /// What contacts are told by, where somebody wants to know.
    pub limits: Option<status::StatusThresholds>,
}

impl StepSettings {
    /// Those of a batch that takes so many substeps at once, or several for each.
    pub(crate) fn striding(&self, stride: f32) -> Self {
        Self { substeps: (self.substeps as f32 / stride).round() as u32, ..*self }
    }
}
