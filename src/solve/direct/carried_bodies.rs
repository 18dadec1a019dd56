//! Free bodies that lie on an articulation and are solved with it.
//!
//! A load is felt by all that carries it. To a sweep over contacts a plank of a taut bridge gives way as its own twenty kilograms do,
//! and it takes as many sweeps as the bridge has joints until it has become the whole of it; eight hundred kilograms are through by
//! then. Rows between an articulation and what it carries are therefore rows of its system, and what it carries are bodies of it.
//!
//! *Riders* are unjointed bodies in contact with an articulation, and what is in contact with them in turn, unless that leads to
//! another articulation, or to so many bodies or manifolds that an active set is no longer the way to solve them. Whether they press
//! or are about to is not asked: how a light plank between taut ones will move is known only once its joints are solved, and a load
//! that it meets unforeseen would be left to sweeps for that step. What turns fast is carried only where it presses: it turns exactly by itself.

use super::{NO_GROUP, root};
use crate::solve::contact::ContactInput;
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::tuning::carried::FAST_TURN;

/// Most bodies that an articulation carries, and most manifolds of theirs.
pub(crate) const MAX_RIDERS: u32 = 12;
pub(crate) const MAX_MANIFOLDS: u32 = 24;

/// Carrier of bodies between which and another carrier no choice can be made.
const SEVERAL: u32 = u32::MAX - 1;

/// Which unjointed bodies of a batch ride on which group of joints.
#[derive(Debug, Default)]
pub(super) struct CarriedBodies {
    /// Unjointed bodies that touch one another, as a union–find forest over slots.
    set: Vec<u32>,
    /// Group that carries each set, by its root.
    carrier: Vec<u32>,
    /// Bodies and manifolds of what each group carries, by group.
    load: Vec<(u32, u32)>,
}

impl CarriedBodies {
    pub(super) fn clear(&mut self) {
        self.set.clear();
    }

    /// Group that the unjointed body of this slot rides on.
    pub(super) fn carrier_of(&self, slot: u32) -> Option<u32> {
        let set = *self.set.get(slot as usize)?;
        Some(self.carrier[set as usize]).filter(|&carrier| carrier != NO_GROUP)
    }

    /// Finds all riders of a step with substeps of length `h` (s); `group` says which slots joints connect.
    pub(super) fn find(
        &mut self,
        contacts: &[ContactInput],
        group: &[u32],
        (velocities, motions): (&[BodyVelocity], &[BodyMotion]),
        h: f32,
    ) {
        self.clear();
        let jointed = |slot: u32| motions[slot as usize].is_dynamic() && motions[slot as usize].jointed;
        let loose = |slot: u32| motions[slot as usize].is_dynamic() && !motions[slot as usize].jointed;
        let carries =
            |contact: &ContactInput| (jointed(contact.a) && loose(contact.b)) || (loose(contact.a) && jointed(contact.b));
        if !contacts.iter().any(carries) {
            return;
        }
        self.set.extend(0..motions.len() as u32);
        self.carrier.clear();
        self.carrier.resize(motions.len(), NO_GROUP);
        self.load.clear();
        self.load.resize(motions.len(), (0, 0));
        let both_move = |contact: &&ContactInput| [contact.a, contact.b].iter().all(|&slot| motions[slot as usize].is_dynamic());
        for contact in contacts.iter().filter(both_move) {
            if loose(contact.a) && loose(contact.b) {
                let (a, b) = (root(&mut self.set, contact.a), root(&mut self.set, contact.b));
                self.set[a.max(b) as usize] = a.min(b);
            }
        }
        for slot in 0..self.set.len() as u32 {
            self.set[slot as usize] = root(&mut self.set, slot);
        }
        for contact in contacts.iter().filter(both_move) {
            for (own, other) in [(contact.a, contact.b), (contact.b, contact.a)] {
                if loose(own) {
                    let carrier = &mut self.carrier[self.set[own as usize] as usize];
                    let may_ride =
                        contact.is_plain() && (contact.presses() || velocities[own as usize].angular.length() * h <= FAST_TURN);
                    let wanted = match (may_ride, jointed(other)) {
                        (false, _) => SEVERAL,
                        (true, true) => group[other as usize],
                        (true, false) => *carrier,
                    };
                    *carrier = if *carrier == NO_GROUP || *carrier == wanted { wanted } else { SEVERAL };
                }
            }
        }
        self.weigh(contacts, motions, loose);
    }

    /// Lets go of what is not carried by one group, and of all that a group carries where it is too much.
    fn weigh(&mut self, contacts: &[ContactInput], motions: &[BodyMotion], loose: impl Fn(u32) -> bool) {
        let Self { set, carrier, load, .. } = self;
        let carrier_of = |slot: u32| if loose(slot) { carrier[set[slot as usize] as usize] } else { NO_GROUP };
        for slot in 0..motions.len() as u32 {
            if let Some((bodies, _)) = load.get_mut(carrier_of(slot) as usize) {
                *bodies += 1;
            }
        }
        for contact in contacts {
            let [a, b] = [contact.a, contact.b].map(carrier_of);
            for group in [Some(a), (a != b).then_some(b)].into_iter().flatten() {
                if let Some((_, manifolds)) = load.get_mut(group as usize) {
                    *manifolds += 1;
                }
            }
        }
        for carrier in carrier.iter_mut() {
            let is_light = |&(bodies, manifolds): &(u32, u32)| bodies <= MAX_RIDERS && manifolds <= MAX_MANIFOLDS;
            if !load.get(*carrier as usize).is_some_and(is_light) {
                *carrier = NO_GROUP;
            }
        }
    }
}
