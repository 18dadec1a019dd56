//! The planes of hinge chains of a batch.

use glam::Vec3;

use super::BatchInput;
use crate::joint_graph::plane::Member;
use crate::solve::batch::Batch;
use crate::solve::plane::{PlaneEntry, PlaneHold, PlaneMember};

impl BatchInput<'_> {
    /// Gives a batch the hinge chains that are to stay in their planes.
    pub(super) fn fill_planes(&self, batch: &mut Batch) {
        batch.planes.parts = (self.long_range.plane_position, self.long_range.plane_axis);
        for number in 0..batch.planes.chains.len() {
            let chain = &self.chains[batch.planes.chains[number] as usize];
            // What a direct solve has moved is flat already.
            let is_solved = |member: &Member| batch.motions[self.groups.place[member.body as usize].1 as usize].direct;
            if chain.members.iter().all(is_solved) {
                continue;
            }
            let first = batch.planes.members.len() as u32;
            let mut reference = None;
            for member in &chain.members {
                let end = self.joint_end(batch, member.end.0, member.end.1 as usize);
                let origin = end.origin - *reference.get_or_insert(end.origin);
                let (velocity, motion) = (&batch.velocities[end.slot as usize], &batch.motions[end.slot as usize]);
                let (mass, across) = PlaneMember::weigh(velocity, motion, member.axis);
                let &Member { axis, height, .. } = member;
                batch.planes.members.push(PlaneMember { slot: end.slot, axis, height, origin, mass, across });
            }
            let hold = chain.anchor.map(|anchor| {
                let end = self.joint_end(batch, anchor.end.0, anchor.end.1 as usize);
                PlaneHold {
                    slot: end.slot,
                    origin: end.origin - reference.unwrap_or(end.origin),
                    lever: end.lever,
                    axis: end.frame * Vec3::X * anchor.sign,
                    height: anchor.height,
                }
            });
            let members = (first, batch.planes.members.len() as u32);
            batch.planes.entries.push(PlaneEntry { members, hold, size: chain.size });
        }
    }
}
