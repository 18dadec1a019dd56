//! A joint whose stops or frames the host moves, within a substep: see [`crate::joint_drive`].
//!
//! Stops and frames are where the host has put them at the end of the step, or somewhat later; `left` (s) before, where they came from at
//! their rates. With
//! u what that motion alone does to a coordinate, Ċ = J v + u, and rows ask of J v + u what they would ask of J v.

use super::LocalPose;
use super::geometry::Placement;
use super::rows::Rate;
use crate::joint_drive::{DriveRates, STOP_ROWS};
use crate::solve::rotation;

/// What moves of a joint by itself while its rows are built.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DrivenParts<'a> {
    /// Velocities of the two bodies that would move the frames as they move.
    pub rates: [Rate; 2],
    stops: &'a [f32; STOP_ROWS],
    /// How long before they arrive the start and the end of the substep are (s).
    left: [f64; 2],
}

impl<'a> DrivenParts<'a> {
    /// Of a joint between bodies that stand so, whose frames are placed like this, in a substep so far from the step's end.
    pub(crate) fn new(drive: &'a DriveRates, local_poses: [&LocalPose; 2], placement: &Placement, left: [f64; 2]) -> Self {
        let levers = [placement.a.lever, placement.b.lever];
        let rates = [0, 1].map(|side| {
            let [linear, angular] = drive.frames[side].map(|rate| local_poses[side].1 * rate.as_dvec3());
            Rate { linear: linear - angular.cross(levers[side]), angular }
        });
        Self { rates, stops: &drive.stops, left: left.map(|left| left + f64::from(drive.behind)) }
    }

    /// Where the stop of this row is at the start and at the end of the substep, which the host has put at `value`, and its rate.
    pub(crate) fn stop(&self, value: f64, row: u8) -> ([f64; 2], f64) {
        let rate = f64::from(self.stops[row as usize]);
        (self.left.map(|left| value - rate * left), rate)
    }
}

/// A placement as it is `left` (s) before the end of the step, of bodies that stand so; of a joint that nothing drives as it is.
pub(crate) fn before(mut placement: Placement, drive: Option<&DriveRates>, local_poses: [&LocalPose; 2], left: f64) -> Placement {
    let Some(drive) = drive else { return placement };
    let left = left + f64::from(drive.behind);
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let [linear, angular] = drive.frames[side].map(|rate| local_poses[side].1 * rate.as_dvec3());
        let own = if side == 0 { &mut placement.a } else { &mut placement.b };
        own.lever -= linear * left;
        own.frame = rotation::rotated(own.frame, angular * -left);
        placement.gap += linear * (left * sign);
    }
    placement
}
