//! Conjugate search directions over all joints of a mesh, two at once (*../joint_mesh.rs*): domains side by side, then the rest.

use super::{BatchJoints, rows};
use crate::solve::disjoint::DisjointSlices;
use crate::solve::state::BodyVelocity;
use crate::workers::Workers;

impl BatchJoints {
    /// Whether none is swept by itself.
    pub(crate) fn are_all_in_lanes(&self) -> bool {
        self.singles.len() == 0
    }

    /// Begins a step of joints that are solved as a sheet.
    pub(crate) fn begin_course(&mut self, threads: &Workers) {
        let Self { entries, domains, lanes, .. } = self;
        domains.each(threads, |strip| strip.lanes.begin_course(entries));
        lanes.begin_course(entries);
    }

    /// Ends it.
    pub(crate) fn end_course(&mut self, threads: &Workers) {
        let Self { entries, domains, lanes, .. } = self;
        let shared = DisjointSlices::new(entries);
        domains.each(threads, |strip| {
            // SAFETY: each joint has one lane, and each strip is one thread's.
            strip.lanes.end_course(&mut unsafe { shared.part() });
        });
        // SAFETY: no other part is in use.
        lanes.end_course(&mut unsafe { shared.part() });
    }

    /// Displacements of joints in lanes, to and fro, that take errors out of positions in a substep of length `h`.
    pub(crate) fn push(&mut self, threads: &Workers, pushes: &mut [BodyVelocity], h: f32) {
        let Self { domains, lanes, visits, .. } = self;
        let most = rows::MAX_RECOVERY_SPEED as f32 * h;
        domains.each_with(threads, pushes, |strip, own| strip.push(own, most, false));
        visits.iter().for_each(|visit| lanes.push(visit.blocks.clone(), pushes, most, false));
        visits.iter().rev().for_each(|visit| lanes.push(visit.blocks.clone(), pushes, most, true));
        domains.each_with(threads, pushes, |strip, own| strip.push(own, most, true));
    }

    /// Applies the last move of the multipliers.
    pub(crate) fn apply_way(&mut self, threads: &Workers, velocities: &mut [BodyVelocity]) {
        self.domains.each_with(threads, velocities, |strip, own| strip.lanes.apply_way(own));
        self.lanes.apply_way(velocities);
    }

    /// Scales the multipliers.
    pub(crate) fn scale_impulses(&mut self, share: f32) {
        self.domains.all_mut().iter_mut().for_each(|strip| strip.lanes.scale_impulses(share));
        self.lanes.scale_impulses(share);
    }

    /// One sweep to and one fro; the products of the biases with what they have changed multipliers by, and with the last move.
    pub(crate) fn sweep_course(&mut self, threads: &Workers, velocities: &mut [BodyVelocity]) -> [f64; 2] {
        let Self { domains, lanes, visits, .. } = self;
        domains.each_with(threads, velocities, |strip, own| {
            strip.lanes.note_course();
            strip.sweep(own, false);
        });
        lanes.note_course();
        visits.iter().for_each(|visit| lanes.sweep(visit.blocks.clone(), velocities, false));
        visits.iter().rev().for_each(|visit| lanes.sweep(visit.blocks.clone(), velocities, true));
        domains.each_with(threads, velocities, |strip, own| {
            strip.sweep(own, true);
            strip.products = strip.lanes.weigh_course();
        });
        domains.all().iter().fold(lanes.weigh_course(), |[d, p], strip| [d + strip.products[0], p + strip.products[1]])
    }

    /// Moves from the multipliers before by p ← α d + β p.
    pub(crate) fn steer_course(&mut self, threads: &Workers, shares: [f32; 2]) {
        self.domains.each(threads, |strip| strip.lanes.steer_course(shares));
        self.lanes.steer_course(shares);
    }
}
