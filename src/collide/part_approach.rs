//! Parts of a shape that a round one, which others of them bear, is about to meet.
//!
//! A pair that presses is collided a little ahead, where it presses: not where it meets a part that does not bear anything yet. A marble in a groove
//! of triangles passes above the corner of the next two; of where it is now that is a point ahead of it, along a normal that leans back. So
//! such parts are followed as pairs without load are, to the first overlap or to the end of the step; so are those that have borne with a face which
//! the body has left behind, and would push it on with their corners.

use glam::Quat;

use super::narrow::Manifold;
use super::predict::{FoundContacts, PairApproach, Reach, STRIDE, nearest_of};
use crate::shape::Shape;

/// Most looks at the way of a step: what goes further than two extents may pass by a part unseen.
const MAX_STRIDES: f32 = 8.0;

/// Cosine between two normals of a part above which it bears as it did.
const SAME: f32 = 0.9999;

impl PairApproach<'_> {
    /// Takes what parts without load would act with in this step from where they are met; what is not met acts nowhere. `short` is the share of the
    /// step in which the pair moves by the lesser least extent, `apart` says which manifolds do not touch where the pair presses.
    pub(super) fn follow_parts(&self, shapes: [&Shape; 2], (short, apart): (f32, u32), reach: &Reach, found: &mut FoundContacts) {
        if found.manifolds.len() < 2 || apart == 0 {
            return;
        }
        let dt = self.step.dt;
        let bore = |manifold: &Manifold| reach.before.iter().find(|known| known.part == manifold.part && known.presses());
        let bears = |manifold: &Manifold| bore(manifold).is_some_and(|known| known.normal.dot(manifold.normal) > SAME);
        let would_act = |manifold: &Manifold| {
            let mut then = *manifold;
            self.put_back(&mut then, -dt, [Quat::IDENTITY; 2]);
            nearest_of(&then) < 0.0
        };
        let (mut ahead, mut missed) = (0_u32, 0_u32);
        for (number, manifold) in found.manifolds.iter().enumerate().take(u32::BITS as usize) {
            if apart >> number & 1 == 0 || bears(manifold) {
                continue;
            }
            if would_act(manifold) {
                ahead |= 1 << number;
            } else if bore(manifold).is_some() {
                missed |= 1 << number;
            }
        }
        if ahead | missed == 0 {
            return;
        }
        std::mem::swap(found.manifolds, found.spare);
        let strides = (1.0 / (STRIDE * short)).ceil().clamp(1.0, MAX_STRIDES);
        let mut stride = 1.0;
        while ahead != 0 {
            let share = stride / strides;
            let turns = self.look(shapes, share, reach.margin, found);
            let is_end = stride >= strides;
            let sought = ahead;
            for (number, kept) in found.spare.iter_mut().enumerate().filter(|(number, _)| sought >> number & 1 == 1) {
                let met = found.manifolds.iter().filter(|manifold| manifold.part == kept.part);
                let met = met.min_by(|a, b| nearest_of(a).total_cmp(&nearest_of(b)));
                // What has borne along another normal has its load, and would act across the gap.
                let may_wait = is_end && bore(kept).is_none();
                match met.filter(|manifold| may_wait || nearest_of(manifold) < 0.0) {
                    Some(manifold) => {
                        *kept = *manifold;
                        self.put_back(kept, share * dt, turns);
                        ahead &= !(1 << number);
                    }
                    None if is_end => missed |= 1 << number,
                    None => {}
                }
            }
            if is_end {
                break;
            }
            stride += 1.0;
        }
        std::mem::swap(found.manifolds, found.spare);
        let mut number = 0;
        found.manifolds.retain(|_| {
            number += 1;
            number > u32::BITS || missed >> (number - 1) & 1 == 0
        });
    }
}
