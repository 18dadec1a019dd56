//! Builds the articulations of a batch: sorts the joints that are solved directly, and collects the bodies, joints and contacts
//! of each, side by side.

use std::ops::Range;

use glam::DVec3;

use super::articulation::Articulation;
use super::carried_bodies::CarriedBodies;
use super::contacts::ArticulationContact;
use super::{BatchRecords, Direct, NO_GROUP, root};
use crate::settings::Solver;
use crate::solve::body_flags::BodyFlags;
use crate::solve::buckets::Buckets;
use crate::solve::contact::ContactInput;
use crate::solve::disjoint::{DisjointPart, DisjointSlices, Slots};
use crate::solve::joint::JointLink;
use crate::solve::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use crate::step_history::History;
use crate::workers::Workers;

/// Speed of a contact with what does not move from which on limbs land (m/s): that of a fall of 13 mm, five times what gravity adds in a step
/// of 1/100 s. Scene: ragdoll_rain. Test: tests/direct.rs.
const MIN_HIT: f32 = 0.5;

/// Articulations that are worth another thread's while to take in: some 10 µs.
const MIN_TAKEN: usize = 4;

/// Joints that belong together, and may become an articulation.
#[derive(Debug)]
pub(super) struct ArticulationCandidate {
    /// Among the batch's joints in the order of their groups.
    joints: Range<usize>,
    group: u32,
    /// Whether the host has asked for the direct solve.
    is_asked_for: bool,
    is_admitted: bool,
}

/// What a batch has for articulations to take in.
struct BuildInput<'a, R> {
    links: &'a [JointLink],
    velocities: &'a [BodyVelocity],
    motions: &'a [BodyMotion],
    contacts: &'a [ContactInput],
    groups: &'a [u32],
    riders: &'a CarriedBodies,
    touching: &'a Buckets,
    records: &'a R,
}

/// An articulation that takes in what is its own, and its number.
struct Builder<'a, 'l> {
    articulation: &'a mut Articulation,
    number: u32,
    local: &'a mut DisjointPart<'l, (u32, u32)>,
}

impl Direct {
    /// Joins the slots that joints connect; each then has the lowest slot of its articulation as its group.
    pub(crate) fn group_slots(&mut self, links: &[JointLink], body_flags: &[BodyFlags]) {
        self.group.clear();
        self.jointed.clear();
        if links.is_empty() {
            return;
        }
        self.body_flags.clear();
        self.body_flags.extend_from_slice(body_flags);
        self.group.extend(0..body_flags.len() as u32);
        self.jointed.resize(body_flags.len(), false);
        for link in links {
            if body_flags[link.a as usize].moves() && body_flags[link.b as usize].moves() {
                let (a, b) = (root(&mut self.group, link.a), root(&mut self.group, link.b));
                self.group[a.max(b) as usize] = a.min(b);
                self.jointed[link.a as usize] = true;
                self.jointed[link.b as usize] = true;
            }
        }
        for slot in 0..self.group.len() as u32 {
            self.group[slot as usize] = root(&mut self.group, slot);
        }
    }

    /// Whether joints connect the body of this slot to another.
    pub(crate) fn is_jointed(&self, slot: u32) -> bool {
        self.jointed.get(slot as usize).copied().unwrap_or(false)
    }

    /// Lowest slot that joints connect to this one.
    pub(crate) fn group_of(&self, slot: u32) -> u32 {
        self.group.get(slot as usize).copied().unwrap_or(slot)
    }

    /// Lists the contacts of each group, and finds what each carries in a step with substeps of length `h` (s).
    pub(crate) fn find_touching(
        &mut self,
        contacts: &[ContactInput],
        (velocities, motions): (&[BodyVelocity], &[BodyMotion]),
        h: f32,
    ) {
        self.touching.clear();
        self.touches.clear();
        if self.group.is_empty() {
            return;
        }
        self.riders.find(contacts, &self.group, (velocities, motions), h);
        if contacts.is_empty() {
            return;
        }
        for (number, contact) in contacts.iter().enumerate() {
            let groups = [contact.a, contact.b].map(|slot| solved_with(slot, motions, &self.group, &self.riders));
            let other = groups[1].filter(|_| groups[0] != groups[1]);
            self.touches.extend([groups[0], other].into_iter().flatten().map(|group| (group, number as u32)));
        }
        self.touching.sort(motions.len(), self.touches.iter().copied());
    }

    /// Takes the joints that are solved directly, and puts `links`, those of the batch, in the order of their groups; `contacts` are all of
    /// the batch.
    pub(crate) fn take(
        &mut self,
        links: &mut Vec<JointLink>,
        (velocities, motions): (&[BodyVelocity], &[BodyMotion]),
        contacts: &[ContactInput],
        records: &(impl BatchRecords + Sync),
        threads: &Workers,
    ) {
        self.held.clear();
        self.held.resize(contacts.len(), false);
        self.impulses.clear();
        if links.is_empty() {
            return;
        }
        self.sort_by_group(links);
        self.list_candidates(links);
        self.local.clear();
        self.local.resize(motions.len(), (u32::MAX, 0));
        let Self { articulations, candidates, local, group: groups, riders, touching, .. } = self;
        articulations.resize_with(articulations.len().max(candidates.len()), Articulation::default);
        let intake = BuildInput { links, velocities, motions, contacts, groups, riders, touching, records };
        let local = DisjointSlices::new(local);
        let piece = threads.piece(candidates.len(), MIN_TAKEN);
        let pieces = candidates.chunks_mut(piece).zip(articulations.chunks_mut(piece)).zip((0..).step_by(piece));
        threads.share(pieces, |((candidates, articulations), first)| {
            // SAFETY: of local numbers only those of bodies that move are used, each of which is of one group, or rides on one.
            let mut local = unsafe { local.part() };
            for ((candidate, articulation), number) in candidates.iter_mut().zip(articulations).zip(first..) {
                candidate.is_admitted = intake.fill(Builder { articulation, number, local: &mut local }, candidate);
            }
        });
        self.keep_admitted(links);
    }

    /// The joints that are not solved directly, unless they are all.
    pub(crate) fn left_over(&self) -> Option<&[JointLink]> {
        (self.count > 0).then_some(&self.left)
    }

    /// Of all joints of the batch, those that are not solved directly.
    pub(crate) fn left<'a>(&'a self, links: &'a [JointLink]) -> &'a [JointLink] {
        self.left_over().unwrap_or(links)
    }

    /// Puts joints in the order of their groups, which are numbered by their lowest slots, and notes those; joints keep their order within
    /// each.
    fn sort_by_group(&mut self, links: &mut Vec<JointLink>) {
        let Self { group, body_flags, order, keys, by_group, sorted, .. } = self;
        let group_of = |link: &JointLink| {
            let end = |slot: u32| if body_flags[slot as usize].moves() { group[slot as usize] } else { NO_GROUP };
            if link.is_withheld { NO_GROUP } else { end(link.a).min(end(link.b)) }
        };
        order.clear();
        order.extend(links.iter().map(group_of));
        if order.is_sorted() {
            return;
        }
        let none = body_flags.len() as u32;
        keys.clear();
        keys.extend(order.iter().zip(0..).map(|(&group, number)| (group.min(none), number)));
        by_group.sort(body_flags.len() + 1, keys.iter().copied());
        sorted.clear();
        sorted.extend((0..=none).flat_map(|group| by_group.of(group)).map(|&number| links[number as usize]));
        std::mem::swap(links, sorted);
        order.clear();
        order.extend(links.iter().map(group_of));
    }

    /// Lists groups of joints that are to be solved directly, unless they turn out to be too much work.
    fn list_candidates(&mut self, links: &[JointLink]) {
        let Self { candidates, order, touching, refused, body_flags, solver, .. } = self;
        candidates.clear();
        let mut start = 0;
        while start < links.len() {
            let group = order[start];
            let joints = start..start + order[start..].iter().take_while(|&&other| other == group).count();
            start = joints.end;
            let own = &links[joints.clone()];
            let solver = solver_of(own, *solver);
            let is_asked_for = solver == Solver::Direct;
            let is_refused = || touching.of(group).is_empty() && refused.is_of(own, body_flags, is_asked_for);
            if group != NO_GROUP && solver != Solver::GaussSeidel && !is_refused() {
                candidates.push(ArticulationCandidate { joints, group, is_asked_for, is_admitted: false });
            }
        }
    }

    /// Numbers the articulations that have been admitted, and lists the joints that are no one's.
    fn keep_admitted(&mut self, links: &[JointLink]) {
        let Self { articulations, candidates, local, touching, refused, body_flags, left, count, .. } = self;
        left.clear();
        let mut first_left = 0;
        for (number, ArticulationCandidate { joints, group, is_asked_for, is_admitted }) in candidates.iter().enumerate() {
            if !is_admitted {
                if touching.of(*group).is_empty() {
                    refused.note(&links[joints.clone()], body_flags, *is_asked_for);
                }
                continue;
            }
            left.extend_from_slice(&links[first_left..joints.start]);
            first_left = joints.end;
            if *count < number {
                articulations.swap(*count, number);
                articulations[*count].moved_slots().for_each(|slot| local[slot as usize].0 = *count as u32);
            }
            for &(slot, own) in articulations[*count].anchors() {
                local[slot as usize] = (*count as u32, own);
            }
            *count += 1;
        }
        left.extend_from_slice(&links[first_left..]);
    }
}

impl<R: BatchRecords> BuildInput<'_, R> {
    /// Lays out an articulation of these joints; false where sweeps are the better choice.
    fn fill(&self, mut taker: Builder<'_, '_>, candidate: &ArticulationCandidate) -> bool {
        let &ArticulationCandidate { ref joints, group, is_asked_for, .. } = candidate;
        let Self { motions, contacts, .. } = *self;
        taker.articulation.clear();
        taker.articulation.enlist(
            WORLD_SLOT,
            DVec3::ZERO,
            (History::NONE, false),
            &self.velocities[WORLD_SLOT as usize],
            &BodyMotion::FIXED,
        );
        for link in &self.links[joints.clone()] {
            let ends = [link.a, link.b].map(|slot| self.number_of(slot, &mut taker));
            taker.articulation.add_joint(self.records.joint(link), ends);
        }
        let numbers = self.touching.of(group);
        let place_of = |contact: &ContactInput| ContactRoute::of(contact, group, self.groups, self.riders, motions);
        let (mut fixed, mut hits, mut carries, mut presses) = (0, false, false, false);
        for contact in numbers.iter().map(|&number| &contacts[number as usize]) {
            match place_of(contact) {
                ContactRoute::Fixed => {
                    fixed += 1;
                    hits |= contact.closes(self.velocities, MIN_HIT);
                }
                ContactRoute::Carried => carries = true,
                ContactRoute::Apart => presses |= contact.presses(),
            }
        }
        let has_rows = fixed > 0 || carries;
        let lands = hits && self.links[joints.clone()].iter().any(|link| link.traits.limits_angles);
        let may_sweep = taker.articulation.sweeps_contacts(fixed, lands);
        taker.articulation.coupled = presses || (may_sweep && !carries) || (has_rows && taker.articulation.is_rigid());
        let numbers = if taker.articulation.coupled { &[] } else { numbers };
        for &number in numbers {
            let contact = &contacts[number as usize];
            let place = place_of(contact);
            if place == ContactRoute::Apart {
                taker.articulation.watched.push(number);
                continue;
            }
            let is_carried = place == ContactRoute::Carried;
            let body_is_b = motions[contact.b as usize].is_dynamic() && !(is_carried && motions[contact.a as usize].jointed);
            let (own, other) = if body_is_b { (contact.b, contact.a) } else { (contact.a, contact.b) };
            let [own, other] = [own, other].map(|slot| self.number_of(slot, &mut taker));
            let mut touch = ArticulationContact::new(number, contact, body_is_b, own, other, is_carried);
            if !contact.presses() {
                touch.lie(self.records.offset(number));
            }
            if !is_carried && let Some(([of_a, of_b], reach)) = self.records.curvature(number, body_is_b) {
                touch.curve(if body_is_b { [of_b, of_a] } else { [of_a, of_b] }, reach);
            }
            taker.articulation.touches.push(touch);
        }
        let Builder { articulation, local, .. } = taker;
        let mut is_admitted = articulation.lay_out(is_asked_for);
        if !is_admitted && !articulation.touches.is_empty() {
            // Too many contacts for its matrix: they are swept.
            articulation.touches.clear();
            articulation.coupled = true;
            is_admitted = articulation.lay_out(is_asked_for);
        }
        if !is_admitted {
            articulation.moved_slots().for_each(|slot| local.get_mut(slot).0 = u32::MAX);
        }
        is_admitted
    }

    /// Number that the body of a slot has in an articulation, which takes it in if it has not yet.
    fn number_of(&self, slot: u32, taker: &mut Builder<'_, '_>) -> u32 {
        if slot == WORLD_SLOT {
            return 0;
        }
        let motion = &self.motions[slot as usize];
        if !motion.is_dynamic() {
            return taker.articulation.anchor(slot).unwrap_or_else(|| self.enlist(slot, taker.articulation));
        }
        let place = taker.local.get_mut(slot);
        if place.0 != taker.number {
            *place = (taker.number, self.enlist(slot, taker.articulation));
        }
        place.1
    }

    fn enlist(&self, slot: u32, articulation: &mut Articulation) -> u32 {
        let (origin, history) = self.records.body(slot);
        articulation.enlist(slot, origin, history, &self.velocities[slot as usize], &self.motions[slot as usize])
    }
}

/// Where a contact of an articulation is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ContactRoute {
    /// As rows, with what does not move.
    Fixed,
    /// As rows, with or among what the articulation carries.
    Carried,
    /// By the sweeps.
    Apart,
}

impl ContactRoute {
    fn of(contact: &ContactInput, group: u32, groups: &[u32], riders: &CarriedBodies, motions: &[BodyMotion]) -> Self {
        let ends = [contact.a, contact.b];
        if !contact.is_plain() {
            return Self::Apart;
        }
        if !ends.iter().all(|&slot| motions[slot as usize].is_dynamic()) {
            return Self::Fixed;
        }
        let solved_here = ends.map(|slot| solved_with(slot, motions, groups, riders) == Some(group));
        let is_carried = solved_here == [true; 2] && ends.iter().any(|&slot| riders.carrier_of(slot) == Some(group));
        if is_carried { Self::Carried } else { Self::Apart }
    }
}

/// Group of joints that the body of this slot is solved with: its own, or that which carries it.
fn solved_with(slot: u32, motions: &[BodyMotion], groups: &[u32], riders: &CarriedBodies) -> Option<u32> {
    let motion = &motions[slot as usize];
    match motion.is_dynamic() {
        true if motion.jointed => Some(groups[slot as usize]),
        true => riders.carrier_of(slot),
        false => None,
    }
}

/// How joints that belong together are solved: swept if one asks for it, else directly if one asks for that, else as the world says.
fn solver_of(links: &[JointLink], of_world: Solver) -> Solver {
    let asks = |solver: Solver| links.iter().any(|link| link.traits.solver == solver);
    [Solver::GaussSeidel, Solver::Direct].into_iter().find(|&solver| asks(solver)).unwrap_or(of_world)
}
