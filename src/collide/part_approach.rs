//! Parts of a shape that a round one, which others of them bear, is about to meet.
//!
//! A pair that presses is collided a little ahead, where it presses: not where it meets a part that does not bear anything yet. A marble in a groove
//! of triangles passes above the corner of the next two; of where it is now that is a point ahead of it, along a normal that leans back. So
//! such parts are followed as pairs without load are, to the first overlap or to the end of the step.

use glam::{Quat, Vec3};

use super::found_contacts::{FoundContacts, nearest_of};
use super::narrow::Manifold;
use super::predict::{PairApproach, Reach, STRIDE};
use crate::shape::Shape;

/// Most looks at the way of a step. What goes further, more than two extents, keeps what there is where it presses: it might pass a part unseen.
const MAX_STRIDES: f32 = 8.0;

/// How near two must come for their contacts to be kept where they are only looked for, over the lesser least extent: joints may pull one of them
/// aside within the step.
const PASSING: f32 = 0.05;

/// Most looks at two of which one turns far.
const MAX_PASSING_STRIDES: f32 = 64.0;

impl PairApproach<'_> {
    /// Takes what parts without load would act with in this step from where they are met; what is not met acts nowhere. `short` is the share of the
    /// step in which the pair moves by the lesser least extent, `apart` says which manifolds do not touch where the pair presses; they may from
    /// the share `from` of the step on.
    pub(super) fn follow_parts(
        &self,
        shapes: [&Shape; 2],
        (short, apart): (f32, u128),
        from: f32,
        reach: &Reach,
        found: &mut FoundContacts,
    ) {
        if found.manifolds.len() < 2 || apart == 0 {
            return;
        }
        let dt = self.step.dt;
        let is_surface = shapes.iter().any(|shape| !shape.geometry().is_solid());
        let bears = |manifold: &Manifold| reach.before.iter().any(|known| known.part == manifold.part && known.presses());
        let would_act = |manifold: &Manifold| {
            let mut then = *manifold;
            self.put_back(&mut then, -dt, [Quat::IDENTITY; 2]);
            nearest_of(&then) < 0.0
        };
        let (mut ahead, mut missed) = (0_u128, 0_u128);
        for (number, manifold) in found.manifolds.iter().enumerate().take(u128::BITS as usize) {
            ahead |= u128::from(apart >> number & 1 == 1 && !bears(manifold) && would_act(manifold)) << number;
        }
        let strides = ((1.0 - from) / (STRIDE * short)).ceil().max(1.0);
        if ahead == 0 || strides > MAX_STRIDES {
            return;
        }
        std::mem::swap(found.manifolds, found.spare);
        let mut stride = 1.0;
        while ahead != 0 {
            let share = from + (1.0 - from) * stride / strides;
            let turns = self.look(shapes, share, reach.margin, found);
            let is_end = stride >= strides;
            let sought = ahead;
            for (number, kept) in found.spare.iter_mut().enumerate().filter(|(number, _)| sought >> number & 1 == 1) {
                let met = found.manifolds.iter().filter(|manifold| manifold.part == kept.part);
                let met = met.min_by(|a, b| nearest_of(a).total_cmp(&nearest_of(b)));
                match met.filter(|manifold| is_end || nearest_of(manifold) < 0.0) {
                    Some(manifold) => {
                        *kept = *manifold;
                        self.put_back(kept, share * dt, turns);
                        ahead &= !(1 << number);
                    }
                    None if is_end => missed |= 1 << number,
                    None => {}
                }
            }
            // A triangle pushes only what is over it: what is met there may be the next one.
            for manifold in found.manifolds.iter().filter(|manifold| is_surface && nearest_of(manifold) < 0.0) {
                if !found.spare.iter().any(|kept| kept.part == manifold.part) {
                    let mut next = *manifold;
                    self.put_back(&mut next, share * dt, turns);
                    found.spare.push(next);
                }
            }
            if is_end {
                break;
            }
            stride += 1.0;
        }
        std::mem::swap(found.manifolds, found.spare);
        let mut number = 0_u32;
        found.manifolds.retain(|_| {
            number += 1;
            number > u128::BITS || missed >> (number - 1) & 1 == 0
        });
    }

    /// The same for the other parts, after a share of the step in which one has been met with this normal (world axes): the body goes on along that
    /// one then.
    pub(super) fn follow_other_parts(
        &self,
        shapes: [&Shape; 2],
        (short, apart): (f32, u128),
        (share, normal): (f32, Vec3),
        reach: &Reach,
        found: &mut FoundContacts,
    ) {
        let closing = normal.dot(self.b.velocity - self.a.velocity);
        if apart == 0 || closing >= 0.0 {
            return;
        }
        let mut along = *self.b;
        along.velocity -= normal * closing;
        // From where it would have come, had it gone so from the start.
        let aside = normal * (closing * share * self.step.dt);
        along.position += aside.as_dvec3();
        let turn = self.a.rotation;
        let shift = |found: &mut FoundContacts, sign: f32| {
            for manifold in found.manifolds.iter_mut() {
                let moved = sign * (turn * manifold.normal).dot(aside);
                manifold.points[..usize::from(manifold.count)].iter_mut().for_each(|point| point.separation += moved);
            }
        };
        shift(found, 1.0);
        let mut on = *self;
        on.b = &along;
        on.follow_parts(shapes, (short, apart), share, reach, found);
        shift(found, -1.0);
    }

    /// Leaves out all contacts of two that are `nearest` apart (m) and stay so through the step: levers of what turns far say nothing of where they go.
    pub(super) fn leave_what_passes_by(&self, shapes: [&Shape; 2], nearest: f32, margin: f32, found: &mut FoundContacts) {
        let extent = self.a.least_extent.min(self.b.least_extent);
        let strides = (self.path() / (STRIDE * extent)).ceil();
        // Written so that what has no extent or no end is left as it is.
        let is_far = nearest > PASSING * extent && strides <= MAX_PASSING_STRIDES;
        if !is_far || found.manifolds.is_empty() {
            return;
        }
        std::mem::swap(found.manifolds, found.spare);
        let mut stride = 1.0;
        let passes = loop {
            self.look(shapes, stride / strides, margin, found);
            if found.nearest() <= PASSING * extent {
                break false;
            }
            if stride >= strides {
                break true;
            }
            stride += 1.0;
        };
        std::mem::swap(found.manifolds, found.spare);
        if passes {
            found.manifolds.clear();
        }
    }
}
