//! Lists the contacts of round features that their bodies swing.

use super::BatchInput;
use crate::collide::collider_state::Follow;
use crate::collide::round_features::{RoundFeature, swung};
use crate::solve::batch::{Batch, ContactEnds};
use crate::solve::round_contacts::{ROUND_POINTS, RoundPoints};

impl BatchInput<'_> {
    /// Asks for the rows that manifolds with swung features take. Not in an island so large that its bodies carry what contacts do from
    /// substep to substep, as levers stay there.
    pub(super) fn note_swung(&self, batch: &mut Batch) {
        let is_large = batch.may_carry_changes();
        for number in 0..batch.manifolds.ends.len() {
            let ends = batch.manifolds.ends[number];
            if ends.is_swung == [false; 2] {
                continue;
            }
            let is_followed = !is_large && usize::from(ends.points) <= ROUND_POINTS;
            let is_swung = if is_followed { self.swung(batch.manifolds.list[number].0) } else { [false; 2] };
            let is_plain = ends.is_plain && is_swung == [false; 2];
            batch.manifolds.ends[number] = ContactEnds { is_swung, is_plain, ..ends };
        }
    }

    /// Whose features of a pair that presses are swung.
    fn swung(&self, slot: u32) -> [bool; 2] {
        let (a, b) = self.pairs.get(slot).key.shapes();
        let follows = [a, b].map(|shape| Follow::of(&self.colliders[shape], &self.bodies[self.index.body_of(shape)]));
        swung((self.index.collider_state(a), self.index.collider_state(b)), &follows, self.gravity, self.dt)
    }

    /// Lists the manifolds of a batch with swung features, where rows hold them.
    pub(super) fn list_round_contacts(&self, batch: &mut Batch) {
        let scale = self.scale_for(batch);
        for number in 0..batch.manifolds.ends.len() {
            let ends = batch.manifolds.ends[number];
            if ends.is_swung == [false; 2] {
                continue;
            }
            let Some(place) = batch.place_of(number) else { continue };
            let features = [0, 1].map(|side| if ends.is_swung[side] { self.round_points(batch, number, side) } else { None });
            if features.iter().any(Option::is_some) {
                let input = self.contact_input(&batch.manifolds.list[number..], ends, scale);
                batch.manifolds.round.add(place, &input, features, &batch.motions);
            }
        }
    }

    /// Features of one side at the points of a manifold.
    fn round_points(&self, batch: &Batch, number: usize, side: usize) -> RoundPoints {
        let (slot, manifold) = batch.manifolds.list[number];
        let pair = self.pairs.get(slot);
        let manifold = pair.manifolds.get(manifold as usize);
        let (a, b) = pair.key.shapes();
        let colliders = [a, b].map(|shape| &self.colliders[shape]);
        let [to_a, to_b] = colliders.map(|collider| collider.place.1);
        let along = to_a * manifold.normal;
        let feature = |point: usize| {
            let at = manifold.points.get(point).unwrap_or(&manifold.points[0]);
            let feature = match side {
                0 => RoundFeature::at(&colliders[0].shape, at.on_a, manifold.normal)?.turned(to_a),
                _ => RoundFeature::at(&colliders[1].shape, at.on_b, to_b.conjugate() * -along)?.turned(to_b),
            };
            Some(feature)
        };
        Some([feature(0)?, feature(1)?])
    }
}
