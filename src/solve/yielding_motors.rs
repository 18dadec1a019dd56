//! Ends the sweeps with what joints hold and contacts stop, where motors drive against them: a sweep back ends with joints, and a motor that
//! it ends with has its way, through any wall.
//!
//! Only islands in which a swept motor and a contact of jointed bodies meet take part. Others in their batch are swept along, as lanes hold
//! joints and contacts of several, and are put back: what is solved beside an island makes no difference to it.

use super::batch::Batch;
use super::contact::Lane;
use super::contact_block::ContactBlocks;
use super::joint::KeptJoints;
use super::parallel_contacts;
use super::state::BodyVelocity;
use crate::workers::Workers;

/// Sweeps of contacts and joints at the end of a substep in which motors do what they did before.
const YIELDING_SWEEPS: u32 = 2;

/// The islands of a batch that take part, and what the others had.
#[derive(Debug, Default)]
pub(super) struct YieldingMotors {
    /// Whether each island has a motor, and a contact of jointed bodies.
    islands: Vec<[bool; 2]>,
    /// Whether each slot is of an island with both.
    slots: Vec<bool>,
    velocities: Vec<BodyVelocity>,
    contacts: Vec<Lane>,
    joints: KeptJoints,
}

impl YieldingMotors {
    pub(super) fn apply(&mut self, batch: &mut Batch, threads: &Workers) {
        if batch.contacts.first_jointed == batch.contacts.len() || !self.find_islands(batch) {
            return;
        }
        let is_for_all = self.islands.iter().all(|has| *has == [true; 2]);
        if !is_for_all {
            self.keep(batch);
        }
        batch.joints.hold_motors();
        for _ in 0..YIELDING_SWEEPS {
            sweep_contacts(batch, threads);
            batch.joints.sweep(threads, &mut batch.velocities, false);
        }
        sweep_contacts(batch, threads);
        if !is_for_all {
            self.put_back(batch);
        }
    }

    /// Finds the islands that take part; whether there are any.
    fn find_islands(&mut self, batch: &Batch) -> bool {
        let Self { islands, slots, .. } = self;
        let end = batch.moving() as u32 + 1;
        let island_of = |ends: [u32; 2]| {
            let slot = ends.into_iter().find(|slot| (1..end).contains(slot))?;
            batch.islands.partition_point(|&first| first <= slot).checked_sub(1)
        };
        islands.clear();
        islands.resize(batch.islands.len(), [false; 2]);
        let mut any = false;
        for island in batch.joints.motor_slots().filter_map(island_of) {
            (islands[island][0], any) = (true, true);
        }
        if !any {
            return false;
        }
        for block in &batch.contacts.blocks[batch.contacts.first_jointed..] {
            let lanes = block.a.iter().zip(&block.b).zip(&block.count).filter(|(_, count)| **count > 0);
            lanes.filter_map(|((&a, &b), _)| island_of([a, b])).for_each(|island| islands[island][1] = true);
        }
        slots.clear();
        slots.resize(batch.velocities.len(), false);
        for (number, _) in islands.iter().enumerate().filter(|(_, has)| **has == [true; 2]) {
            let last = batch.islands.get(number + 1).map_or(end, |&next| next);
            slots[batch.islands[number] as usize..last as usize].fill(true);
        }
        islands.contains(&[true; 2])
    }

    fn keep(&mut self, batch: &mut Batch) {
        self.velocities.clone_from(&batch.velocities);
        batch.joints.keep(&mut self.joints);
        self.contacts.clear();
        for number in batch.contacts.first_jointed..batch.contacts.len() {
            self.contacts.extend(batch.contacts.whole(number).multipliers().map(|lambda| *lambda));
        }
    }

    /// Puts back what is not of an island that takes part.
    fn put_back(&mut self, batch: &mut Batch) {
        let Self { slots, velocities, contacts, joints, .. } = self;
        for ((velocity, kept), _) in
            batch.velocities.iter_mut().zip(velocities).zip(&*slots).filter(|(_, takes_part)| !**takes_part)
        {
            *velocity = *kept;
        }
        batch.joints.put_back(joints, slots);
        put_contacts_back(&mut batch.contacts, contacts, slots);
    }
}

fn put_contacts_back(contacts: &mut ContactBlocks, kept: &[Lane], slots: &[bool]) {
    let mut kept = kept.iter();
    for number in contacts.first_jointed..contacts.len() {
        let mut whole = contacts.whole(number);
        let (a, b) = (whole.block.a, whole.block.b);
        for (lambda, kept) in whole.multipliers().zip(&mut kept) {
            for (l, lambda) in lambda.iter_mut().enumerate().filter(|&(l, _)| !(slots[a[l] as usize] || slots[b[l] as usize])) {
                *lambda = kept[l];
            }
        }
    }
}

/// One sweep over the contacts of bodies that joints hold.
fn sweep_contacts(batch: &mut Batch, threads: &Workers) {
    let moving = batch.moving();
    parallel_contacts::sweep_jointed(&mut batch.contacts, threads, (&mut batch.velocities[..], moving));
}
