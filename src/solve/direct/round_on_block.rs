//! Round shapes on boxes and capsules: where the two touch at any pose, in closed form.
//!
//! A wheel that goes up a kerb in a step, and a ball on a paddle, have another normal at each moment. What has that of the step's start, or of the
//! moment at which the two first touch, is thrown along it for the rest of the step. With m the middle of what is round, q the point of the block
//! that is nearest to it, and r the sum of both radii (a capsule is a line with one),
//!
//! ```text
//! n = (m − q)/|m − q|,   s = |m − q| − r,
//! ```
//!
//! however far the two have gone and turned. A wheel that lies along an edge goes over it as a circle in the plane across.

use glam::{DQuat, DVec3};

use super::curved_contacts::CurvedPoint;
use crate::solve::contact::POINTS;
use crate::solve::joint::LocalPose;

/// Something round that is near a block, at the start of the step, in world axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoundOnBlock {
    /// Whether B is round and A the block.
    pub round_is_b: bool,
    /// Radii of what is round and of the block's edges (m).
    pub radii: [f64; 2],
    /// Middle of what is round at each point, from its body's centre of mass (m).
    pub middles: [DVec3; POINTS],
    /// Middle of the block from its body's centre of mass (m), its rotation, and how far it reaches along its own axes: infinitely along an edge that
    /// the other lies along.
    pub place: DVec3,
    pub rotation: DQuat,
    pub half: DVec3,
    /// From the centre of mass of the block's body to that of the other (m).
    pub apart: DVec3,
}

impl RoundOnBlock {
    /// The point of this number, as B sees it, after B and A have moved and turned so since the start of the step. None where the middle of what is
    /// round is within the block.
    pub(super) fn follow(&self, number: usize, of_b: &LocalPose, of_a: &LocalPose) -> Option<CurvedPoint> {
        let (round, block) = if self.round_is_b { (of_b, of_a) } else { (of_a, of_b) };
        let (middle, rotation) = (round.1 * self.middles[number], block.1 * self.rotation);
        let place = block.1 * self.place;
        let from_block = self.apart + round.0 - block.0 + middle - place;
        let own = rotation.conjugate() * from_block;
        let nearest = own.clamp(-self.half, self.half);
        let distance = own.distance(nearest);
        (distance > 0.0).then(|| {
            let outward = rotation * ((own - nearest) / distance);
            let on_round = middle - outward * self.radii[0];
            let on_block = place + rotation * nearest + outward * self.radii[1];
            let separation = distance - self.radii[0] - self.radii[1];
            match self.round_is_b {
                true => CurvedPoint { normal: outward, lever: on_round, other_lever: on_block, separation },
                false => CurvedPoint { normal: -outward, lever: on_block, other_lever: on_round, separation },
            }
        })
    }
}
