//! Direct solve of articulations: all joints of connected bodies at once, by one sparse factorisation in `f64` on `f32` state.
//!
//! A sweep passes a force on by one joint at a time and forgets most of it where a light body meets a heavy one; the factor knows
//! the whole articulation. A chain of n joints costs n, a bridge little more, at any ratio of masses.
//!
//! [`Direct`] sorts a batch's joints into articulations and decides which of them are solved here; `order` and `factor` are linear
//! algebra and know no physics; `stiffness` and `body` are the inertia that answers; `momentum` keeps what joints cannot change;
//! `system` holds the rows and their active set; `articulation` is the substep, `coupled` that of an articulation with contacts.

use super::StepSettings;
use glam::DVec3;

use super::joint::JointEntry;
use super::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use crate::id::{JointId, Pool};
use crate::joint::Joint;

mod articulation;
mod body;
mod coupled;
mod factor;
pub(crate) mod history;
mod momentum;
mod order;
mod stiffness;
mod system;

use articulation::Articulation;
use history::History;

/// Halvings that an articulation may spend in a step.
const HALVING_BUDGET: u32 = 60;

/// The articulations of a batch that are solved directly.
#[derive(Debug, Default)]
pub(crate) struct Direct {
    articulations: Vec<Articulation>,
    count: usize,
    /// Articulation that has each slot of the batch, and its local number there.
    local: Vec<(u32, u32)>,
    /// Articulation of each slot, as a union–find forest, then as a number.
    group: Vec<u32>,
    touched: Vec<bool>,
    left: Vec<JointEntry>,
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

    /// Takes the joints that are solved directly out of `entries`; `contacts` are pairs of slots that touch,
    /// `record` says where a slot's body stands (m), and its last substep.
    pub(crate) fn take(
        &mut self,
        entries: &mut Vec<JointEntry>,
        joints: &Pool<Joint, JointId>,
        velocities: &[BodyVelocity],
        motions: &mut [BodyMotion],
        contacts: impl Iterator<Item = [u32; 2]>,
        record: impl Fn(u32) -> (DVec3, History),
    ) {
        if entries.is_empty() {
            return;
        }
        self.group_slots(entries, motions);
        self.touched.clear();
        self.touched.resize(motions.len(), false);
        for slot in contacts.flatten().filter(|&slot| motions[slot as usize].is_dynamic()) {
            self.touched[self.group[slot as usize] as usize] = true;
        }
        self.local.clear();
        self.local.resize(motions.len(), (u32::MAX, 0));
        self.left.clear();
        // Groups are numbered by their lowest slot; joints keep their order within each.
        let group_of = |group: &[u32], entry: &JointEntry| {
            [entry.a, entry.b]
                .into_iter()
                .filter(|&slot| motions[slot as usize].is_dynamic())
                .map(|slot| group[slot as usize])
                .min()
        };
        entries.sort_unstable_by_key(|entry| (group_of(&self.group, entry), entry.joint));
        let mut start = 0;
        while start < entries.len() {
            let group = group_of(&self.group, &entries[start]);
            let end = start + entries[start..].iter().take_while(|entry| group_of(&self.group, entry) == group).count();
            let coupled = group.is_some_and(|group| self.touched[group as usize]);
            if group.is_none() || !self.admit(&entries[start..end], coupled, joints, velocities, motions, &record) {
                self.left.extend_from_slice(&entries[start..end]);
            }
            start = end;
        }
        std::mem::swap(entries, &mut self.left);
        for articulation in self.articulations[..self.count].iter().filter(|articulation| !articulation.coupled) {
            for slot in articulation.moved_slots() {
                motions[slot as usize].direct = true;
            }
        }
    }

    /// Joins the slots that joints connect; each then has the lowest slot of its articulation as its group.
    fn group_slots(&mut self, entries: &[JointEntry], motions: &[BodyMotion]) {
        fn root(group: &mut [u32], mut slot: u32) -> u32 {
            while group[slot as usize] != slot {
                group[slot as usize] = group[group[slot as usize] as usize];
                slot = group[slot as usize];
            }
            slot
        }
        self.group.clear();
        self.group.extend(0..motions.len() as u32);
        for entry in entries {
            if motions[entry.a as usize].is_dynamic() && motions[entry.b as usize].is_dynamic() {
                let (a, b) = (root(&mut self.group, entry.a), root(&mut self.group, entry.b));
                self.group[a.max(b) as usize] = a.min(b);
            }
        }
        for slot in 0..motions.len() as u32 {
            self.group[slot as usize] = root(&mut self.group, slot);
        }
    }

    /// Lays out an articulation of these joints; false where sweeps are the better choice.
    fn admit(
        &mut self,
        entries: &[JointEntry],
        coupled: bool,
        joints: &Pool<Joint, JointId>,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        record: impl Fn(u32) -> (DVec3, History),
    ) -> bool {
        if self.articulations.len() == self.count {
            self.articulations.push(Articulation::default());
        }
        let articulation = &mut self.articulations[self.count];
        articulation.clear();
        articulation.coupled = coupled;
        articulation.enlist(
            WORLD_SLOT,
            DVec3::ZERO,
            History::NONE,
            &velocities[WORLD_SLOT as usize],
            &motions[WORLD_SLOT as usize],
        );
        for slot in entries.iter().flat_map(|entry| [entry.a, entry.b]).filter(|&slot| slot != WORLD_SLOT) {
            let local = &mut self.local[slot as usize];
            if local.0 != self.count as u32 {
                let (origin, history) = record(slot);
                let number = articulation.enlist(slot, origin, history, &velocities[slot as usize], &motions[slot as usize]);
                *local = (self.count as u32, number);
            }
        }
        articulation.entries.extend_from_slice(entries);
        let admitted = articulation.lay_out(joints, &self.local);
        self.count += usize::from(admitted);
        admitted
    }

    fn coupled(&mut self) -> impl Iterator<Item = &mut Articulation> {
        self.articulations[..self.count].iter_mut().filter(|articulation| articulation.coupled)
    }

    /// Begins a substep of the articulations that touch what moves.
    pub(crate) fn couple(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        h: f32,
    ) {
        self.coupled().for_each(|articulation| articulation.couple(joints, velocities, motions, f64::from(h)));
    }

    /// Solves the joints of the articulations that touch what moves.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity]) {
        self.coupled().for_each(|articulation| articulation.sweep(velocities));
    }

    /// Hands the multipliers of a substep back to the joints.
    pub(crate) fn keep_impulses(&mut self) {
        self.coupled().for_each(|articulation| articulation.keep_impulses(1.0));
    }

    /// Mends the positions of the articulations that touch what moves.
    pub(crate) fn settle(&mut self, joints: &Pool<Joint, JointId>, velocities: &[BodyVelocity], motions: &mut [BodyMotion]) {
        self.coupled().for_each(|articulation| articulation.settle(joints, velocities, motions));
    }

    /// Moves the other articulations through the step.
    pub(crate) fn step(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        settings: &StepSettings,
    ) {
        let h = f64::from(settings.dt) / f64::from(settings.substeps);
        for articulation in self.articulations[..self.count].iter_mut().filter(|articulation| !articulation.coupled) {
            articulation.step(joints, velocities, motions, settings.substeps, h, HALVING_BUDGET);
        }
    }
}
