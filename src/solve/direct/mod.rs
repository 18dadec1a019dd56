//! Direct solve of articulations: all joints of connected bodies at once, by one sparse factorisation in `f64` on `f32` state.
//!
//! A sweep passes a force on by one joint at a time and forgets most of it where a light body meets a heavy one; the factor knows
//! the whole articulation. A chain of n joints costs n, a bridge little more, at any ratio of masses.
//!
//! [`Direct`] sorts a batch's joints into articulations and decides which of them are solved here; `order` and `factor` are linear
//! algebra and know no physics; `stiffness` and `body` are the inertia that answers; `momentum` keeps what joints cannot change;
//! `system` holds the rows, `active_set` says which of them count, `points` is the same without rows where all joints hold points; `layout` says where in its matrix they
//! are, `guard` what is done about those that repeat others, `refused` remembers that it would be too much work; `quads` moves bodies four at a time, in the arithmetic of `fours` and `registers`; `articulation` takes a step, in as many substeps as `effort` says, `substep` and `project` one part of it each; `ropes` is what distance joints that pull ask for across their lines; `lift` keeps mended positions from making energy; `contacts` are those with what it cannot move, along
//! surfaces that may be `curved`, and with what it carries, its `riders`; `coupled` is the substep of an articulation that touches
//! anything else that moves, whose rows may be `lasting` ones; `single` is how any of them writes its `f64` into the state; `swept` is all of those of a batch, of which like ones go in `lockstep`, their rows
//! `abreast`.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DMat3, DVec3};

use super::StepSettings;
use super::buckets::Buckets;
use super::contact::{ContactImpulses, ContactInput};
use super::joint::{JointEntry, worst_gap};
use super::role::Role;
use super::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use crate::id::{JointId, Pool};
use crate::joint::Joint;
use crate::settings::Solver;
use crate::workers::Workers;

mod abreast;
mod active_set;
mod articulation;
mod block;
mod body;
mod contacts;
mod coupled;
mod curved;
mod effort;
pub(crate) mod factor;
mod fours;
mod grip;
mod guard;
pub(crate) mod history;
mod lasting;
mod layout;
mod lift;
mod lockstep;
#[cfg(test)]
mod noise;
mod order;
mod packed;
mod points;
mod project;
mod quads;
mod refine;
mod refused;
mod registers;
mod riders;
mod ropes;
mod row;
mod single;
mod stiffness;
mod substep;
mod swept;
mod system;
mod watch;

use articulation::Articulation;
use contacts::Touch;
use history::History;
use lockstep::Locksteps;
use refused::Refused;
use riders::Riders;
pub(crate) use swept::Floor;

/// Group of a joint that moves nothing.
const NO_GROUP: u32 = u32::MAX;

/// Articulations at whose gaps to look is worth another thread's while.
const LEAST_LOOKS: usize = 16;

/// The articulations of a batch that are solved directly.
#[derive(Debug, Default)]
pub(crate) struct Direct {
    articulations: Vec<Articulation>,
    count: usize,
    /// What the world says of joints that ask for nothing else.
    pub solver: Solver,
    /// Articulation that has each slot of the batch, and its local number there.
    local: Vec<(u32, u32)>,
    /// Articulation of each slot, as a union–find forest, then as a number.
    group: Vec<u32>,
    /// What the body of each slot is, where there are joints.
    roles: Vec<Role>,
    /// Whether joints connect each slot to another that moves.
    jointed: Vec<bool>,
    /// Unjointed bodies that are solved with what carries them.
    riders: Riders,
    /// Group and number of each contact of a jointed body or a rider, and the numbers by group.
    touches: Vec<(u32, u32)>,
    touching: Buckets,
    left: Vec<JointEntry>,
    refused: Refused,
    locksteps: Locksteps,
    /// Group of each joint, and room to sort joints by it.
    order: Vec<u32>,
    keys: Vec<(u32, u32)>,
    by_group: Buckets,
    sorted: Vec<JointEntry>,
    /// Contacts that need no other rows, by number, and the multipliers of those that press.
    held: Vec<bool>,
    impulses: Vec<(u32, ContactImpulses)>,
}

/// What the world knows of a batch beyond the batch's own arrays.
pub(crate) trait BatchRecords {
    /// Where a slot's body stands (m), and its last substep.
    fn body(&self, slot: u32) -> (DVec3, History);
    /// Shape operators of both surfaces of the contact of this number in world axes (1/m), where both are smooth, and how far its
    /// body B, or else A, reaches from its centre of mass (m).
    fn curvature(&self, contact: u32, of_b: bool) -> Option<([DMat3; 2], f64)>;
}

impl Direct {
    /// Forgets the articulations of the last step but for what they may use again.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Articulations solved directly in this step.
    pub(crate) fn articulations(&self) -> &[Articulation] {
        &self.articulations[..self.count]
    }

    /// Joints solved directly, as their batch holds them.
    pub(crate) fn entries(&self) -> impl Iterator<Item = &JointEntry> {
        self.articulations().iter().flat_map(|articulation| &articulation.entries)
    }

    /// The last substep of each body that an articulation moves by itself, by slot.
    pub(crate) fn histories(&self) -> impl Iterator<Item = (u32, &History)> {
        self.articulations().iter().filter(|articulation| !articulation.coupled).flat_map(Articulation::histories)
    }

    /// Bodies whose contacts are swept in the next steps too although they might be rows, by slot, and for how many steps.
    pub(crate) fn swept_steps(&self) -> impl Iterator<Item = (u32, u32)> {
        let swept = self.articulations().iter().filter(|articulation| articulation.coupled && articulation.swept_steps > 0);
        swept.flat_map(|articulation| articulation.moved_slots().map(|slot| (slot, articulation.swept_steps)))
    }

    /// Lists the contacts of each group, and finds what each carries.
    pub(crate) fn find_touching(&mut self, contacts: &[ContactInput], motions: &[BodyMotion]) {
        self.touching.clear();
        self.touches.clear();
        if self.group.is_empty() {
            return;
        }
        self.riders.find(contacts, &self.group, motions);
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

    /// Takes the joints that are solved directly out of `entries`; `contacts` are all of the batch.
    pub(crate) fn take(
        &mut self,
        entries: &mut Vec<JointEntry>,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        contacts: &[ContactInput],
        records: &impl BatchRecords,
    ) {
        self.held.clear();
        self.held.resize(contacts.len(), false);
        self.impulses.clear();
        if entries.is_empty() {
            return;
        }
        self.local.clear();
        self.local.resize(motions.len(), (u32::MAX, 0));
        self.left.clear();
        self.sort_by_group(entries);
        let order = std::mem::take(&mut self.order);
        let (mut start, mut any) = (0, false);
        while start < entries.len() {
            let group = order[start];
            let end = start + order[start..].iter().take_while(|&&other| other == group).count();
            let solver = solver_of(&entries[start..end], self.solver);
            let admitted = group != NO_GROUP
                && solver != Solver::GaussSeidel
                && self.admit(&entries[start..end], group, solver, velocities, motions, contacts, records);
            if admitted && !std::mem::replace(&mut any, true) {
                self.left.extend_from_slice(&entries[..start]);
            } else if any && !admitted {
                self.left.extend_from_slice(&entries[start..end]);
            }
            start = end;
        }
        self.order = order;
        if any {
            std::mem::swap(entries, &mut self.left);
        }
    }

    /// Puts joints in the order of their groups, which are numbered by their lowest slots, and notes those; joints keep their order within
    /// each.
    fn sort_by_group(&mut self, entries: &mut Vec<JointEntry>) {
        let Self { group, roles, order, keys, by_group, sorted, .. } = self;
        let group_of = |entry: &JointEntry| {
            let end = |slot: u32| if roles[slot as usize].moves() { group[slot as usize] } else { NO_GROUP };
            end(entry.a).min(end(entry.b))
        };
        order.clear();
        order.extend(entries.iter().map(group_of));
        if order.is_sorted() {
            return;
        }
        let none = roles.len() as u32;
        keys.clear();
        keys.extend(order.iter().zip(0..).map(|(&group, number)| (group.min(none), number)));
        by_group.sort(roles.len() + 1, keys.iter().copied());
        sorted.clear();
        sorted.extend((0..=none).flat_map(|group| by_group.of(group)).map(|&number| entries[number as usize]));
        std::mem::swap(entries, sorted);
        order.clear();
        order.extend(entries.iter().map(group_of));
    }

    /// Whether joints connect the body of this slot to another.
    pub(crate) fn is_jointed(&self, slot: u32) -> bool {
        self.jointed.get(slot as usize).copied().unwrap_or(false)
    }

    /// Lowest slot that joints connect to this one.
    pub(crate) fn group_of(&self, slot: u32) -> u32 {
        self.group.get(slot as usize).copied().unwrap_or(slot)
    }

    /// Joins the slots that joints connect; each then has the lowest slot of its articulation as its group.
    pub(crate) fn group_slots(&mut self, entries: &[JointEntry], roles: &[Role]) {
        self.group.clear();
        self.jointed.clear();
        if entries.is_empty() {
            return;
        }
        self.roles.clear();
        self.roles.extend_from_slice(roles);
        self.group.extend(0..roles.len() as u32);
        self.jointed.resize(roles.len(), false);
        for entry in entries {
            if roles[entry.a as usize].moves() && roles[entry.b as usize].moves() {
                let (a, b) = (root(&mut self.group, entry.a), root(&mut self.group, entry.b));
                self.group[a.max(b) as usize] = a.min(b);
                self.jointed[entry.a as usize] = true;
                self.jointed[entry.b as usize] = true;
            }
        }
        for slot in 0..self.group.len() as u32 {
            self.group[slot as usize] = root(&mut self.group, slot);
        }
    }

    /// Lays out an articulation of these joints; false where sweeps are the better choice.
    #[expect(clippy::too_many_arguments, reason = "a batch's arrays, each on its own")]
    fn admit(
        &mut self,
        entries: &[JointEntry],
        group: u32,
        solver: Solver,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        contacts: &[ContactInput],
        records: &impl BatchRecords,
    ) -> bool {
        if self.articulations.len() == self.count {
            self.articulations.push(Articulation::default());
        }
        let asked = solver == Solver::Direct;
        let touches = !self.touching.of(group).is_empty();
        if !touches && self.refused.is_of(entries, &self.roles, asked) {
            return false;
        }
        let Self { articulations, local, count, riders, group: groups, .. } = self;
        let articulation = &mut articulations[*count];
        articulation.clear();
        articulation.enlist(WORLD_SLOT, DVec3::ZERO, History::NONE, &velocities[WORLD_SLOT as usize], &BodyMotion::FIXED);
        let mut enlist = |slot: u32, articulation: &mut Articulation| {
            let local = &mut local[slot as usize];
            if slot != WORLD_SLOT && local.0 != *count as u32 {
                let (origin, history) = records.body(slot);
                let number = articulation.enlist(slot, origin, history, &velocities[slot as usize], &motions[slot as usize]);
                *local = (*count as u32, number);
            }
            if slot == WORLD_SLOT { 0 } else { local.1 }
        };
        for slot in entries.iter().flat_map(|entry| [entry.a, entry.b]) {
            enlist(slot, articulation);
        }
        articulation.entries.extend_from_slice(entries);
        let numbers = self.touching.of(group);
        let place_of = |contact: &ContactInput| Place::of(contact, group, groups, riders, motions);
        let (mut fixed, mut carries, mut presses) = (0, false, false);
        for contact in numbers.iter().map(|&number| &contacts[number as usize]) {
            match place_of(contact) {
                Place::Fixed => fixed += 1,
                Place::Carried => carries = true,
                Place::Apart => presses |= contact.presses(),
            }
        }
        let has_rows = fixed > 0 || carries;
        // Asked in every step, as it counts them.
        let may_sweep = articulation.sweeps_contacts(fixed);
        articulation.coupled = presses || (may_sweep && !carries) || (has_rows && articulation.is_rigid());
        let numbers = if articulation.coupled { &[] } else { numbers };
        for &number in numbers {
            let contact = &contacts[number as usize];
            let place = place_of(contact);
            if place == Place::Apart {
                articulation.watched.push(number);
                continue;
            }
            let is_carried = place == Place::Carried;
            let body_is_b = motions[contact.b as usize].is_dynamic() && !(is_carried && motions[contact.a as usize].jointed);
            let (own, other) = if body_is_b { (contact.b, contact.a) } else { (contact.a, contact.b) };
            let (own, other) = (enlist(own, articulation), enlist(other, articulation));
            let mut touch = Touch::new(number, contact, body_is_b, own, other, is_carried);
            if !is_carried && let Some(([of_a, of_b], reach)) = records.curvature(number, body_is_b) {
                touch.curve(if body_is_b { [of_b, of_a] } else { [of_a, of_b] }, reach);
            }
            articulation.touches.push(touch);
        }
        let mut admitted = articulation.lay_out(local, asked);
        if !admitted && !articulation.touches.is_empty() {
            // Too many contacts for its matrix: they are swept.
            articulation.touches.clear();
            articulation.coupled = true;
            admitted = articulation.lay_out(local, asked);
        }
        if !admitted {
            articulation.slots().for_each(|slot| local[slot as usize].0 = u32::MAX);
            if !touches {
                self.refused.note(entries, &self.roles, asked);
            }
        }
        self.count += usize::from(admitted);
        admitted
    }

    /// Whether the contact of this number needs no rows of its own.
    pub(crate) fn holds(&self, number: usize) -> bool {
        self.held.get(number).copied().unwrap_or(false)
    }

    /// Multipliers of a contact that it holds.
    pub(crate) fn impulses_of(&self, number: usize) -> ContactImpulses {
        let found = self.impulses.binary_search_by_key(&(number as u32), |&(number, _)| number);
        found.map_or(ContactImpulses::default(), |found| self.impulses[found].1)
    }

    /// Impulse along the normal of a contact that it holds, over the step (N·s).
    pub(crate) fn blow_of(&self, number: usize) -> f32 {
        let touches = self.articulations().iter().flat_map(|articulation| &articulation.touches);
        touches.filter(|touch| touch.number as usize == number).map(Touch::blow).sum()
    }

    /// Worst overlap of the contacts that it holds (m).
    pub(crate) fn penetration(&self) -> f64 {
        self.articulations().iter().map(|articulation| articulation.outcome.penetration).fold(0.0, f64::max)
    }

    /// Greatest distance between joint points beyond what their joints allow (m).
    pub(crate) fn joint_gap(&self, joints: &Pool<Joint, JointId>, motions: &[BodyMotion], threads: &Workers) -> f32 {
        let articulations = self.articulations();
        // None is negative, and those of floats that are not are in the order of their bits.
        let worst = AtomicU32::new(0);
        threads.share(articulations.chunks(threads.piece(articulations.len(), LEAST_LOOKS)), |articulations| {
            let entries = articulations.iter().flat_map(|articulation| &articulation.entries);
            worst.fetch_max(worst_gap(entries, joints, motions).to_bits(), Ordering::Relaxed);
        });
        f32::from_bits(worst.into_inner())
    }

    /// Whether any articulation is swept as a block.
    pub(crate) fn sweeps_blocks(&self) -> bool {
        self.articulations().iter().any(|articulation| articulation.coupled)
    }

    /// Slots of the bodies that articulations move by themselves.
    pub(crate) fn slots_moved_alone(&self) -> impl Iterator<Item = u32> {
        self.articulations().iter().filter(|articulation| !articulation.coupled).flat_map(Articulation::moved_slots)
    }

    /// Joints of the articulations that touch what moves.
    pub(crate) fn coupled_entries(&self) -> impl Iterator<Item = &JointEntry> {
        self.articulations().iter().filter(|articulation| articulation.coupled).flat_map(|articulation| &articulation.entries)
    }

    /// Moves the articulations through the step that touch nothing which moves; one that comes to touch is left for the sweeps.
    pub(crate) fn step(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        contacts: &[ContactInput],
        settings: &StepSettings,
        threads: &Workers,
    ) {
        let (starts, bodies) = (&*velocities, &*motions);
        let articulations = &mut self.articulations[..self.count];
        let piece = threads.piece(articulations.len(), 1);
        threads.share(articulations.chunks_mut(piece), |articulations| {
            for articulation in articulations.iter_mut().filter(|articulation| !articulation.coupled) {
                articulation.step(joints, starts, bodies, settings);
            }
        });
        while let Some(number) = self.first_to_meet(velocities, motions, contacts, settings.dt) {
            self.articulations[number].give_up();
        }
        for articulation in self.articulations[..self.count].iter_mut().filter(|articulation| !articulation.coupled) {
            articulation.store(velocities, motions);
            for slot in articulation.moved_slots() {
                motions[slot as usize].direct = true;
            }
            for &number in &articulation.watched {
                self.held[number as usize] = true;
            }
            for touch in &articulation.touches {
                self.held[touch.number as usize] = true;
                self.impulses.push((touch.number, touch.impulses()));
            }
        }
        self.impulses.sort_unstable_by_key(|&(number, _)| number);
    }

    /// An articulation that has taken its step by itself although it comes to touch what moves, or found no end to it.
    ///
    /// Where one gives up, it no longer stands where it has gone, so the others are judged anew.
    fn first_to_meet(
        &self,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        contacts: &[ContactInput],
        dt: f32,
    ) -> Option<usize> {
        let paths = |slot: u32| {
            let (number, local) = self.local[slot as usize];
            let own = self.articulations.get(number as usize).filter(|own| (number as usize) < self.count && !own.coupled);
            match own.and_then(|own| own.path_of(slot, local)) {
                Some(path) => [path; 2],
                None => watch::free_paths(&velocities[slot as usize], &motions[slot as usize], dt),
            }
        };
        self.articulations().iter().position(|articulation| {
            let mut watched = articulation.watched.iter().map(|&number| &contacts[number as usize]);
            !articulation.coupled
                && (articulation.outcome.unsettled
                    || watched.any(|contact| watch::meets(contact, paths(contact.a), paths(contact.b))))
        })
    }
}

/// Where a contact of an articulation is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// As rows, with what does not move.
    Fixed,
    /// As rows, with or among what the articulation carries.
    Carried,
    /// By the sweeps.
    Apart,
}

impl Place {
    fn of(contact: &ContactInput, group: u32, groups: &[u32], riders: &Riders, motions: &[BodyMotion]) -> Self {
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
fn solved_with(slot: u32, motions: &[BodyMotion], groups: &[u32], riders: &Riders) -> Option<u32> {
    let motion = &motions[slot as usize];
    match motion.is_dynamic() {
        true if motion.jointed => Some(groups[slot as usize]),
        true => riders.carrier_of(slot),
        false => None,
    }
}

/// Lowest member of a group that is joined to this one; ways there are shortened.
fn root(group: &mut [u32], mut member: u32) -> u32 {
    while group[member as usize] != member {
        group[member as usize] = group[group[member as usize] as usize];
        member = group[member as usize];
    }
    member
}

/// How joints that belong together are solved: swept if one asks for it, else directly if one asks for that, else as the world says.
fn solver_of(entries: &[JointEntry], of_world: Solver) -> Solver {
    let asks = |solver: Solver| entries.iter().any(|entry| entry.solver == solver);
    [Solver::GaussSeidel, Solver::Direct].into_iter().find(|&solver| asks(solver)).unwrap_or(of_world)
}
