//! Joints and contacts in one solve: islands in which joints meet contacts, moved through the step by themselves.
//!
//! Sweeps solve joints and contacts in turn, and each undoes part of what the other did: where a light body is held between heavy ones by
//! a joint on one side and a contact on the other, as is every link of a rope on a drum, that takes hundreds of sweeps. Here all of an
//! island is one problem, solved by Newton's method from where the last substep left it: at rest, and wherever nothing changes, by one
//! factorisation a substep. The derivation is in *docs/reference/coupled.md*.
//!
//! `elimination`, `factor`, `refine`, `term`, `problem`, `passes`, `admm` and `impact` are numbers on plain arrays and know nothing of the
//! engine; `positions` is what they do for errors of positions, `overruled` where rows contradict one another, and `self_stress` for forces that
//! hold one another. `servos` says what servos move. `joints` (of `held`), `patch` and `masses` make joints, manifolds and bodies theirs,
//! `stiffness` says how forces turn, `stiff_lines` and `pivots` what of that a substep resolves, `island` takes the step, `budget` bounds its work, `soundness` judges it, `rebound` what hits in it,
//! and `gaps` closes what it leaves open. Which islands are solved here is said by [`plan`](crate::solve::plan).

#![expect(clippy::needless_range_loop, reason = "an index names a row or a column of several arrays alike")]

use glam::{DMat3, DVec3};

use super::StepSettings;
use super::contact::{ContactImpulses, ContactInput};
use super::direct::body::DirectBody;
use super::direct::round_on_block::RoundOnBlock;
use super::joint::rows::ScalarRow;
use super::joint::swing::most_swing;
use super::joint::{JointEntry, JointLink};
use super::plan::Planner;
use super::state::{BodyMotion, BodyVelocity};
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::report::IslandPlan;
use crate::tuning::plan::MAX_HALVINGS;
use crate::workers::Workers;

mod admm;
mod assembly;
mod bend;
mod budget;
mod elimination;
mod factor;
mod fall;
mod gaps;
mod held;
mod impact;
mod island;
mod joints;
mod masses;
mod outline;
mod overruled;
mod passes;
mod patch;
mod phase;
mod pivots;
mod positions;
mod problem;
mod rebound;
mod refine;
mod self_stress;
mod servos;
mod soundness;
mod stiff_lines;
mod stiffness;
mod term;
#[cfg(test)]
mod tests;

use island::CoupledIsland;
use patch::Patch;

/// The islands of a batch that are solved here.
#[derive(Debug, Default)]
pub(crate) struct Newton {
    islands: Vec<CoupledIsland>,
    count: usize,
    /// Which of those has each manifold, and its number there; none where it is no one's.
    held: Vec<Option<(u32, u32)>>,
    planner: Planner,
    /// Room for the rows of a joint.
    asked: Vec<ScalarRow>,
}

/// What the world knows of a batch beyond the batch's own arrays.
pub(crate) trait IslandRecords {
    /// A joint as it is solved.
    fn joint(&self, link: &JointLink) -> JointEntry;
    /// Whether an end of a joint is the world or a body that is not dynamic: what is held where it is for now is neither.
    fn is_anchor(&self, link: &JointLink) -> bool;
    /// Both surfaces of the contact of this number, where it is known how both bend.
    fn surfaces(&self, contact: u32) -> Option<Surfaces>;
    /// Where both surfaces are at the points of the contact of this number.
    fn tangency(&self, contact: u32) -> Tangency;

    /// Both sides of the contact of this number, if one is round and the other a block.
    fn on_block(&self, contact: u32) -> Option<RoundOnBlock>;

    /// How far the first point of a manifold on B is from that on A (m, world axes).
    fn offset(&self, contact: u32) -> DVec3;
}

/// Outward normals of A's and of B's surface at each point of a manifold, and how far the point on B is from that on A (m), in world axes.
pub(crate) type Tangency = [(DVec3, DVec3, DVec3); super::contact::POINTS];

/// Shape operators of A's and of B's surface where they touch, in world axes (1/m), and how far both bodies reach from their centres of
/// mass (m).
pub(crate) type Surfaces = ([DMat3; 2], [f64; 2]);

/// What a batch has before it is solved.
pub(crate) struct Contents<'a> {
    /// First slot of each island, and one past the last slot of them all.
    pub islands: &'a [u32],
    pub end: u32,
    pub velocities: &'a mut [BodyVelocity],
    pub motions: &'a mut [BodyMotion],
    pub contacts: &'a [ContactInput],
}

impl Newton {
    /// Forgets the islands of the last step but for their memory.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
        self.held.clear();
        self.planner.clear();
    }

    /// Islands that have taken the step.
    pub(crate) fn islands(&self) -> impl Iterator<Item = &CoupledIsland> {
        self.islands[..self.count].iter().filter(|island| island.is_accepted())
    }

    /// Whether contacts are to be formed though there are no joints, as a row of bodies may be solved as one; `contacts` are the slots of each
    /// contact's bodies.
    pub(crate) fn may_hold_rows(
        &mut self,
        islands: &[u32],
        bodies: (&[BodyVelocity], &[BodyMotion]),
        contacts: impl Iterator<Item = [u32; 2]>,
    ) -> bool {
        self.planner.may_hold_rows(islands, bodies, contacts)
    }

    /// Whether no island has taken the step.
    pub(crate) fn is_idle(&self) -> bool {
        self.islands().next().is_none()
    }

    /// First slot, bodies, joints and plan of each island with joints, and whether it was begun here and given up.
    pub(crate) fn plans(&self) -> impl Iterator<Item = (u32, u32, u32, IslandPlan, bool)> {
        self.planner.told().map(|(first, bodies, joints, plan)| {
            let is_taken = self.islands().any(|island| island.slots.start == first);
            (first, bodies, joints, plan, plan == IslandPlan::Coupled && !is_taken)
        })
    }

    /// Joints solved here, as their batch holds them.
    pub(crate) fn entries(&self) -> impl Iterator<Item = &JointEntry> {
        self.islands().flat_map(|island| &island.held.entries)
    }

    fn patch(&self, number: usize) -> Option<&Patch> {
        let (island, patch) = (*self.held.get(number)?)?;
        Some(&self.islands[island as usize].patches[patch as usize])
    }

    /// Whether the manifold of this number needs no other rows.
    pub(crate) fn holds(&self, number: usize) -> bool {
        self.held.get(number).is_some_and(Option::is_some)
    }

    /// Multipliers of a manifold that it holds.
    pub(crate) fn impulses_of(&self, number: usize) -> Option<ContactImpulses> {
        self.patch(number).map(Patch::impulses)
    }

    /// Sum of the multipliers of a manifold that it holds, over the step.
    pub(crate) fn sum_of(&self, number: usize) -> Option<ContactImpulses> {
        self.patch(number).map(|patch| patch.sum)
    }

    /// Worst overlap of the contacts that it holds (m).
    pub(crate) fn penetration(&self) -> f64 {
        self.islands().map(CoupledIsland::penetration).fold(0.0, f64::max)
    }

    /// Greatest distance between joint points beyond what their joints allow (m).
    pub(crate) fn joint_gap(&self, joints: &Pool<Joint, JointId>) -> f32 {
        self.islands().map(|island| island.joint_gap(joints)).fold(0.0, f64::max) as f32
    }

    /// Moves the islands through the step that are to be solved here, and takes their joints from `links`. Contacts are empty where nothing is.
    pub(crate) fn step(
        &mut self,
        links: &mut Vec<JointLink>,
        contents: Contents<'_>,
        records: &impl IslandRecords,
        (joints, settings, threads): (&Pool<Joint, JointId>, &StepSettings, &Workers),
    ) {
        self.clear();
        let Contents { islands: firsts, end, velocities, motions, contacts } = contents;
        if links.is_empty() && contacts.is_empty() {
            return;
        }
        let Self { islands, count, held, planner, asked } = self;
        let (rates, moving): (&[BodyVelocity], &[BodyMotion]) = (velocities, motions);
        let h = f64::from(settings.dt) / f64::from(settings.substeps);
        let stiffness = |link: &JointLink| {
            let (entry, slots) = (records.joint(link), [link.a, link.b].map(|slot| slot as usize));
            let ease = |side: usize| {
                let slot = slots[side];
                DirectBody::new(slot as u32, &rates[slot], &moving[slot]).turning_ease(entry.local_lever[side])
            };
            [h * h * (ease(0) + ease(1)), f64::from(entry.impulses.point.length()) / h]
        };
        let swing = |link: &JointLink| {
            let entry = records.joint(link);
            most_swing(&entry, &joints[entry.joint], (rates, moving), f64::from(settings.dt), asked)
        };
        let is_on_block = |contact| records.on_block(contact).is_some();
        planner.plan(
            firsts,
            end,
            links,
            (rates, moving, contacts),
            (|link| records.is_anchor(link), stiffness, swing, is_on_block),
            settings,
        );
        for (number, traits) in planner.coupled() {
            let last = firsts.get(number + 1).copied().unwrap_or(end);
            if *count == islands.len() {
                islands.push(CoupledIsland::default());
            }
            islands[*count].begin(firsts[number]..last, traits, motions);
            *count += 1;
        }
        if *count == 0 {
            return;
        }
        let taken = &mut islands[..*count];
        find_structures(taken, (links, contacts), threads);
        taken.iter().filter(|island| island.is_large()).for_each(|island| planner.enlarge(island.slots.start));
        if taken.iter().all(CoupledIsland::is_large) {
            return;
        }
        taken.iter_mut().filter(|island| !island.is_large()).for_each(CoupledIsland::ask);
        for halvings in 0..=MAX_HALVINGS {
            take_in(taken, (links, contacts), (velocities, motions), records, halvings);
            let finer = StepSettings { substeps: settings.substeps << halvings, ..*settings };
            threads.share(taken.iter_mut().filter(|island| island.is_pending()), |island| island.step(joints, &finer, halvings));
            if !taken.iter().any(CoupledIsland::is_pending) {
                break;
            }
        }
        if !taken.iter().any(CoupledIsland::is_accepted) {
            return;
        }
        links.retain(|link| owner([link.a, link.b], taken, CoupledIsland::is_accepted).is_none());
        held.resize(contacts.len(), None);
        for (held, contact) in held.iter_mut().zip(contacts) {
            let place = owner([contact.a, contact.b], taken, CoupledIsland::is_accepted);
            *held = place.map(|place| (place as u32, taken[place].next_patch()));
        }
        for island in taken.iter().filter(|island| island.is_accepted()) {
            island.store(velocities, motions);
        }
    }
}

/// Takes bodies, joints and manifolds into the islands that are to take the step, in substeps halved so often.
fn take_in(
    islands: &mut [CoupledIsland],
    (links, contacts): (&[JointLink], &[ContactInput]),
    (velocities, motions): (&[BodyVelocity], &[BodyMotion]),
    records: &impl IslandRecords,
    halvings: u32,
) {
    let share = 1.0 / (1 << halvings) as f32;
    islands.iter_mut().filter(|island| island.is_pending()).for_each(|island| island.enlist_bodies(velocities, motions));
    for link in links {
        let Some(place) = owner([link.a, link.b], islands, CoupledIsland::is_pending) else { continue };
        let ends = [link.a, link.b].map(|slot| islands[place].local(slot, velocities, motions));
        islands[place].held.push(records.joint(link).scaled(share), ends);
    }
    for (number, contact) in contacts.iter().enumerate() {
        let Some(place) = owner([contact.a, contact.b], islands, CoupledIsland::is_pending) else { continue };
        let ends = [contact.a, contact.b].map(|slot| islands[place].local(slot, velocities, motions));
        let mut patch = Patch::new(contact, ends);
        patch.scale_impulses(f64::from(share));
        if !contact.presses() {
            patch.lie(records.offset(number as u32));
        }
        if let Some(on_block) = records.on_block(number as u32) {
            patch.go_over_block(on_block);
        }
        // What no joint holds has been collided as it will stand when it presses.
        let is_jointed = [contact.a, contact.b].iter().any(|&slot| motions[slot as usize].jointed);
        if let Some(surfaces) = records.surfaces(number as u32).filter(|_| is_jointed) {
            patch.curve(surfaces, [contact.a, contact.b].map(|slot| motions[slot as usize].is_dynamic()));
            patch.settle(&records.tangency(number as u32));
        }
        islands[place].patches.push(patch);
    }
}

/// Finds the structure of each island's factor, from its joints and near pairs; that of most is the one of the last step.
fn find_structures(islands: &mut [CoupledIsland], (links, contacts): (&[JointLink], &[ContactInput]), threads: &Workers) {
    for link in links {
        if let Some(place) = owner([link.a, link.b], islands, |_| true) {
            islands[place].outline_joint(link);
        }
    }
    for contact in contacts {
        if let Some(place) = owner([contact.a, contact.b], islands, |_| true) {
            islands[place].outline_pair([contact.a, contact.b]);
        }
    }
    let mut unknown = islands.iter_mut().filter(|island| !island.has_structure()).peekable();
    if unknown.peek().is_some() {
        threads.share(unknown, CoupledIsland::find_structure);
    }
}

/// Which of these islands, in the order of their slots, moves any of the two, if it is one to be asked.
fn owner(slots: [u32; 2], islands: &[CoupledIsland], asks: impl Fn(&CoupledIsland) -> bool) -> Option<usize> {
    let place_of = |slot| {
        let place = islands.partition_point(|island| island.slots.end <= slot);
        islands.get(place).filter(|island| island.slots.contains(&slot)).map(|_| place)
    };
    slots.into_iter().find_map(place_of).filter(|&place| asks(&islands[place]))
}
