//! Wraps the bounds of a batch whose chain lies on something fixed, such as a drum.

use super::BatchInput;
use crate::solve::batch::Batch;
use crate::solve::joint::JointEnd;
use crate::solve::wrapped_bound::{Waypoint, WrapEntry};
use crate::tuning::bounds::{MIN_WRAPPED, STRAIGHT_SHARE};

impl BatchInput<'_> {
    /// Lists the bodies of the batch that touch something fixed, or are no farther from it than gravity closes within the step. Does
    /// nothing if no bound is long enough to be wrapped.
    pub(super) fn find_touches(&self, batch: &mut Batch) {
        let inner = |&slot: &u32| self.bounds[slot as usize].bound.inner;
        if batch.long_range.slots.iter().map(inner).any(|(first, end)| end - first >= MIN_WRAPPED) {
            let reach = self.gravity.length() * self.dt * self.dt;
            batch.long_range.wraps.find_touches(&batch.contacts, &batch.motions, reach);
        }
    }

    /// Wraps a bound around what its chain is pressed against, unless the bound is nearly straight or gives way; returns whether it has
    /// been wrapped.
    pub(super) fn wrap(&self, batch: &mut Batch, slot: u32, [near, far]: [&JointEnd; 2]) -> bool {
        let record = &self.bounds[slot as usize];
        let (first, end) = record.bound.inner;
        let gives = || super::World::bound_give(self.long_range, record)[0].compliance > 0.0;
        if !batch.long_range.wraps.has_touches() || end - first < MIN_WRAPPED || gives() {
            return false;
        }
        let [a, b] = [near, far].map(|end| end.origin + (batch.motions[end.slot as usize].rotation * end.lever).as_dvec3());
        if a.distance(b) as f32 > STRAIGHT_SHARE * record.bound.upper {
            return false;
        }
        batch.long_range.wraps.waypoints.clear();
        let mut before = near.slot;
        // Inner joints are listed from the far end, waypoints from the near one.
        for inner in (first..end).rev() {
            let at = &self.span.inner[inner as usize];
            let own = self.joint_end(batch, at.end.link, at.end.side as usize);
            if let Some(out) = batch.long_range.wraps.touched([before, own.slot]) {
                let lever = batch.motions[own.slot as usize].rotation * own.lever;
                let point = (own.origin - near.origin).as_vec3() + lever;
                batch.long_range.wraps.waypoints.push(Waypoint { inner, point, out });
            }
            before = own.slot;
        }
        let (offset, levers) = ((far.origin - near.origin).as_vec3(), [near.lever, far.lever]);
        let impulse = record.impulses[0] * self.scale_for(batch);
        let entry = WrapEntry::new(slot, [near.slot, far.slot], offset, levers, record.bound.upper, impulse);
        batch.long_range.wraps.add(entry, &batch.motions)
    }
}
