//! Finds out whether the chain of supports under a body ends on something that cannot move.

use super::super::batch::Batch;
use super::super::buckets::Buckets;
use super::Supports;

/// What stands, hangs or lies on what cannot move, as far as anybody has asked.
#[derive(Debug, Default)]
pub(super) struct Ground {
    known: Vec<GroundState>,
    /// The way down that is being tried: slots, and which of the supports of each comes next.
    way: Vec<(u32, u32)>,
    /// Slots from which this way and others before it have found nothing yet.
    tried: Vec<u32>,
    /// What joints hold together, and what is still to be told that it is held.
    pairs: Vec<(u32, u32)>,
    joined: Buckets,
    open: Vec<u32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GroundState {
    Nothing,
    /// Is on a way that is being tried, or was in vain.
    Tried,
    Grounded,
    InTheAir,
}

impl Ground {
    /// Notes what joints hold to what cannot move.
    ///
    /// What hangs on something that only stands is not noted: a cable over a drum, above which a load lies, may be in free fall.
    pub(super) fn begin(&mut self, batch: &Batch) {
        let Self { known, pairs, joined, open, .. } = self;
        known.clear();
        known.resize(batch.motions.len(), GroundState::Nothing);
        let is_fixed = |slot: u32| !batch.motions[slot as usize].is_dynamic();
        let ends = || batch.joints.links.iter().map(|link| (link.a, link.b));
        if !ends().any(|(a, b)| is_fixed(a) != is_fixed(b)) {
            return;
        }
        pairs.clear();
        pairs.extend(ends().flat_map(|(a, b)| [(a, b), (b, a)]));
        joined.sort(known.len(), pairs.iter().copied());
        open.clear();
        open.extend((0..known.len() as u32).filter(|&slot| is_fixed(slot)));
        while let Some(held) = open.pop() {
            for &other in joined.of(held) {
                if std::mem::replace(&mut known[other as usize], GroundState::Grounded) != GroundState::Grounded {
                    open.push(other);
                }
            }
        }
    }

    /// Whether a slot, over however many others, stands on what cannot move or is held by joints to it: looks down one way after another
    /// until one gets there.
    pub(super) fn carries(&mut self, slot: u32, is_fixed: impl Fn(u32) -> bool, supports: &Supports) -> bool {
        let Self { known, way, tried, .. } = self;
        let ask = |slot: u32, known: &[GroundState]| match known[slot as usize] {
            GroundState::Nothing if is_fixed(slot) => GroundState::Grounded,
            answer => answer,
        };
        way.clear();
        tried.clear();
        let mut answer = ask(slot, known);
        if answer == GroundState::Nothing {
            way.push((slot, 0));
            known[slot as usize] = GroundState::Tried;
        }
        while answer == GroundState::Nothing
            && let Some((own, next)) = way.last_mut()
        {
            let Some(support) = supports.of(*own).get(*next as usize) else {
                tried.push(*own);
                way.pop();
                continue;
            };
            *next += 1;
            match ask(support.lower, known) {
                GroundState::Grounded => answer = GroundState::Grounded,
                GroundState::Nothing => {
                    known[support.lower as usize] = GroundState::Tried;
                    way.push((support.lower, 0));
                }
                GroundState::Tried | GroundState::InTheAir => {}
            }
        }
        // Who was tried in vain may lead back to the way that has found the ground.
        let of_tried = if answer == GroundState::Grounded { GroundState::Nothing } else { GroundState::InTheAir };
        tried.iter().for_each(|&slot| known[slot as usize] = of_tried);
        way.iter().for_each(|&(slot, _)| known[slot as usize] = GroundState::Grounded);
        answer == GroundState::Grounded
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::initial_impulses::Support;

    /// Supports by upper slot of these pairs of an upper slot and a lower one.
    fn sorted(slots: usize, mut pairs: Vec<(u32, u32)>) -> Supports {
        pairs.sort_unstable();
        let first = (0..=slots as u32).map(|slot| pairs.partition_point(|pair| pair.0 < slot) as u32).collect();
        Supports { sorted: pairs.iter().map(|&(upper, lower)| Support { upper, lower, ..Support::default() }).collect(), first }
    }

    #[test]
    fn what_stands_on_the_ground_over_any_way_is_carried_and_nothing_else() {
        const SLOTS: usize = 24;
        let (mut numbers, mut answers) = (0x2545_f491_u32, [0; 2]);
        let mut random = |below: u32| {
            numbers = numbers.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (numbers >> 8) % below
        };
        for _ in 0..200 {
            // With loops, as of stones that lean on each other; some of them in the air.
            let pairs: Vec<(u32, u32)> =
                (0..SLOTS as u32 + random(8)).map(|_| (1 + random(SLOTS as u32 - 1), random(SLOTS as u32))).collect();
            let mut carried = [false; SLOTS];
            carried[0] = true;
            for _ in 0..SLOTS {
                pairs.iter().for_each(|&(upper, lower)| carried[upper as usize] |= carried[lower as usize]);
            }
            let supports = sorted(SLOTS, pairs);
            let mut ground = Ground { known: vec![GroundState::Nothing; SLOTS], ..Ground::default() };
            for slot in (0..40).map(|_| random(SLOTS as u32)) {
                assert_eq!(ground.carries(slot, |slot| slot == 0, &supports), carried[slot as usize], "slot {slot}");
                answers[usize::from(carried[slot as usize])] += 1;
            }
        }
        assert!(answers.iter().all(|&count| count > 1000), "{answers:?}");
    }
}
