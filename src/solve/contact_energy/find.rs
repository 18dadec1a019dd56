//! Decides which islands of a batch are checked for energy, and what carries them.

use glam::{DVec3, Vec3};

use super::super::batch::Batch;
use super::super::joint::JointEntry;
use super::{Carrier, ContactEnergy, NOBODY, SweptIsland};

impl ContactEnergy {
    /// Finds the islands that may be watched: those with joints, where anything touches or carries any. `center` says where a
    /// body's centre of mass is (m).
    pub(crate) fn find_islands(&mut self, batch: &Batch, center: impl Fn(u32) -> DVec3) {
        let replicas = batch.replica_count();
        let Batch { bodies, motions, velocities, manifolds, direct, joints, long_range, .. } = batch;
        let ends = &manifolds.ends;
        let Self { islands, carriers, places, owner, watched, .. } = self;
        islands.clear();
        let has_swept = !joints.entries.is_empty() && (replicas > 0 || !ends.is_empty());
        if !has_swept && direct.coupled_entries().next().is_none() {
            return;
        }
        let origin = |slot: u32| center(bodies[slot as usize]);
        carriers.clear();
        owner.clear();
        owner.resize(motions.len(), NOBODY);
        for (number, &first) in batch.islands.iter().enumerate() {
            let end = batch.islands.get(number + 1).map_or((motions.len() - replicas) as u32, |&next| next);
            let mut island = SweptIsland::new(first, end);
            for slot in island.slots().filter(|&slot| motions[slot].is_dynamic()) {
                owner[slot] = number as u32;
                // Who is locked along an axis hangs on the world.
                let is_free = velocities[slot].inverse_mass.min_element() > 0.0 && motions[slot].is_free_to_turn();
                island.touches_still |= !is_free;
            }
            islands.push(island);
        }
        watched.clear();
        watched.resize(islands.len(), false);
        let owner_of = |ends: [u32; 2]| ends.map(|slot| owner[slot as usize]).into_iter().find(|&number| number != NOBODY);
        let in_island = |entry: &JointEntry| owner_of([entry.a, entry.b]).map(|number| number as usize);
        let entries =
            || direct.coupled_entries().map(|entry| (entry, false)).chain(joints.entries.iter().map(|entry| (entry, true)));
        for (entry, is_swept) in entries() {
            if let Some(number) = in_island(entry) {
                watched[number] = true;
                islands[number].has_swept_joints |= is_swept;
                islands[number].has_drives |= entry.traits.has_motor || !entry.traits.gives_by_motors_alone;
            }
        }
        // What springs do is known where rows are those of an articulation.
        let springs = joints.entries.iter().filter(|entry| !entry.traits.gives_by_motors_alone).filter_map(in_island);
        let soft = long_range.bounds.entries.iter().filter(|entry| entry.has_give());
        let soft = soft.filter_map(|entry| owner_of([entry.near, entry.far])).map(|number| number as usize);
        springs.chain(soft).for_each(|number| watched[number] = false);
        let contacts = ends.iter().map(|ends| [ends.a, ends.b]);
        for ends in contacts.chain(entries().map(|(entry, _)| [entry.a, entry.b])) {
            let Some(number) = owner_of(ends).filter(|&number| watched[number as usize]) else { continue };
            for slot in ends.into_iter().filter(|&slot| owner[slot as usize] == NOBODY) {
                let velocity = &velocities[slot as usize];
                if (velocity.linear, velocity.angular) == (Vec3::ZERO, Vec3::ZERO) {
                    islands[number as usize].touches_still = true;
                } else if !carriers.iter().any(|carrier| (carrier.island, carrier.slot) == (number, slot)) {
                    let place = origin(slot) - origin(islands[number as usize].first);
                    carriers.push(Carrier { island: number, slot, place });
                }
            }
        }
        carriers.sort_by_key(|carrier| carrier.island);
        if !carriers.is_empty() {
            places.resize(motions.len(), DVec3::ZERO);
        }
        let mut number = 0;
        islands.retain_mut(|island| {
            let own = [number, number + 1].map(|number| carriers.partition_point(|carrier| carrier.island < number) as u32);
            island.carriers = own.into();
            if own[0] < own[1] {
                let first = origin(island.first);
                let moved = island.slots().filter(|&slot| motions[slot].is_dynamic());
                moved.for_each(|slot| places[slot] = origin(slot as u32) - first);
            }
            number += 1;
            watched[number as usize - 1]
        });
    }
}
