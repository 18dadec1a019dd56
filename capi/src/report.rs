//! What a step did: counts, residuals, times.

use ls_core::StepReport;

use crate::sized::Versioned;

/// Report of a step. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsStepReport {
    /// Number of the step; 0 before the first.
    pub step: u64,
    /// Simulated time (s).
    pub time: f64,
    /// Dynamic bodies awake during the step.
    pub bodies_awake: u32,
    /// Dynamic bodies asleep.
    pub bodies_asleep: u32,
    /// Groups of touching or jointed bodies that were solved.
    pub islands: u32,
    /// Pairs of shapes near each other with a body that can move.
    pub pairs: u32,
    /// Pairs for which contact points were computed.
    pub pairs_updated: u32,
    /// Pairs that kept their contact points because they had not moved.
    pub pairs_reused: u32,
    /// Contacts solved.
    pub manifolds: u32,
    /// Contact points solved.
    pub contact_points: u32,
    /// Joints solved.
    pub joints: u32,
    /// Batches of islands solved independently.
    pub batches: u32,
    /// Greatest number of contact colours in a batch.
    pub colors: u32,
    /// Bodies that moved.
    pub moved: u32,
    /// Worst distance between joint points beyond what the joint allows (m).
    pub joint_gap: f32,
    /// Worst overlap of two shapes before it was recovered (m).
    pub penetration: f32,
    /// Wall time of finding candidate pairs (s).
    pub broad_phase_time: f32,
    /// Wall time of computing contact points (s).
    pub narrow_phase_time: f32,
    /// Wall time of waking and grouping islands (s).
    pub island_time: f32,
    /// Wall time of preparing and solving the constraints (s).
    pub solve_time: f32,
    /// Wall time of writing back, sweeping fast bodies, sleep and events (s).
    pub finish_time: f32,
    /// Wall time of the whole step without callbacks (s).
    pub total_time: f32,
    /// Unions awake and free, each solved as one body.
    pub unions: u32,
    /// Bodies that moved as members of those.
    pub union_members: u32,
    /// Worst angle by which a joint or a stop of an articulation is off (rad).
    pub joint_angle: f32,
    /// Of the long-range bounds of bodies awake, how many were wrapped around what their chain lies on.
    pub bounds_wrapped: u32,
    /// Long-range bounds derived in this step; 0 where nothing has changed that they follow from.
    pub bounds_derived: u32,
    /// Long-range bounds of bodies awake.
    pub bounds: u32,
    /// Of those, how many were taut or nearly so.
    pub bounds_active: u32,
    /// Of those, how many were so slack that the step did not look at them again.
    pub bounds_skipped: u32,
    /// Hinge chains kept in a plane.
    pub planes: u32,
    /// Wall time of deriving long-range constraints and handing them out (s).
    pub long_range_time: f32,
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsStepReport {
    const SIZES: &'static [usize] = &[96, 104, 112, 136];
}

impl From<&StepReport> for LsStepReport {
    fn from(report: &StepReport) -> Self {
        let (counts, timings) = (&report.counts, &report.timings);
        Self {
            step: report.step,
            time: report.time,
            bodies_awake: counts.bodies_awake,
            bodies_asleep: counts.bodies_asleep,
            islands: counts.islands,
            pairs: counts.pairs,
            pairs_updated: counts.pairs_updated,
            pairs_reused: counts.pairs_reused,
            manifolds: counts.manifolds,
            contact_points: counts.contact_points,
            joints: counts.joints,
            batches: counts.batches,
            colors: counts.colors,
            moved: counts.moved,
            joint_gap: report.residuals.joint_gap,
            penetration: report.residuals.penetration,
            broad_phase_time: timings.broad_phase,
            narrow_phase_time: timings.narrow_phase,
            island_time: timings.islands,
            solve_time: timings.solve,
            finish_time: timings.finish,
            total_time: timings.total,
            unions: counts.unions,
            union_members: counts.union_members,
            joint_angle: report.residuals.joint_angle,
            bounds_wrapped: counts.bounds_wrapped,
            bounds_derived: counts.bounds_derived,
            bounds: counts.bounds,
            bounds_active: counts.bounds_active,
            bounds_skipped: counts.bounds_skipped,
            planes: counts.planes,
            long_range_time: timings.long_range,
        }
    }
}
