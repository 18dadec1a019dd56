//! Sleep: whole islands, with the pairs between their bodies.

use super::drift::{WATCHED_AGAIN, quiet_after};
use super::pairs::contact_pair;
use super::wake::Edited;
use super::{Collision, Movers, World};
use crate::body::{Anchored, BodyKind, SleepState};
use crate::collide::cache::Fate;
use crate::collide::pairs::PairKey;
use crate::collide::persistent_manifold::TOUCHING_SHARE;
use crate::error::{Error, ErrorKind, Result};
use crate::id::BodyId;
use crate::island::SleepingIsland;
use crate::joint_record::Joint;

impl World {
    /// Whether a body is awake; static and kinematic ones always are, what is welded to static ones and may sleep never is.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn is_awake(&self, body: BodyId) -> Result<bool> {
        let index = self.bodies.find(body)?;
        Ok(self.bodies[index].is_awake() && !self.stands_welded(index))
    }

    /// Whether a body that may sleep stands because welds hold it to what is static, and no joint of it wears or bears too much.
    pub(super) fn stands_welded(&self, index: u32) -> bool {
        let body = &self.bodies[index];
        if body.anchored != Anchored::Still || !self.def.sleep.enabled || !body.settings.can_sleep {
            return false;
        }
        let mut joints = body.joints.iter().filter_map(|&id| self.joints.find(id).ok()).map(|slot| &self.joints[slot]);
        let wears = |joint: &Joint| joint.strain.as_ref().is_some_and(|strain| strain.is_at_work(&joint.def.strength));
        !joints.any(|joint| joint.is_overloaded() || wears(joint))
    }

    /// Wakes a body and its island.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn wake(&mut self, body: BodyId) -> Result<()> {
        let index = self.bodies.find(body)?;
        self.wake_for(Edited::Body(index));
        Ok(())
    }

    /// Puts a dynamic body to sleep with everything it touched or was jointed to in the last step.
    ///
    /// # Errors
    /// The handle is not a body of this world; [`ErrorKind::NotApplicable`] if the body is not dynamic.
    pub fn put_to_sleep(&mut self, body: BodyId) -> Result<()> {
        let index = self.bodies.find(body)?;
        if !self.bodies[index].is_dynamic() {
            return Err(Error::new(ErrorKind::NotApplicable, "body", "only dynamic bodies sleep"));
        }
        self.flood_unions();
        if self.bodies[index].is_mover() && self.bodies[index].is_free() {
            self.settle_movers();
            self.collision.index.begin_stances(self.colliders.slot_count());
            self.collision.pairs.settle();
            self.collision.index.add_stances(self.collision.pairs.active(), &self.colliders, &self.bodies);
            self.collision.touches.outdate();
            self.find_islands();
            let island = self.islands.groups.island[index as usize];
            let members = self.islands.groups.islands().nth(island as usize).map(<[u32]>::to_vec).unwrap_or_default();
            self.end_what_has_parted(&members);
            self.put_islands_to_sleep(vec![members.clone()]);
            members.into_iter().for_each(|member| self.rest_boxes(member));
            self.settle_movers();
        }
        Ok(())
    }

    /// Ends the contacts of these bodies that pressed in the last step and are apart by now: no step looks at them while the bodies sleep.
    fn end_what_has_parted(&mut self, members: &[u32]) {
        let is_member = |shape: u32| members.binary_search(&self.colliders[shape].body).is_ok();
        let has_parted = |key: PairKey| {
            let [a, b] = <[u32; 2]>::from(key.shapes()).map(|shape| self.colliders.handle_of(shape));
            let extent = self.collision.index.least_extent(key);
            self.shape_distance(a, b).is_ok_and(|found| found.distance > f64::from(TOUCHING_SHARE * extent))
        };
        let active = self.collision.pairs.active().iter();
        let parted: Vec<(PairKey, u32)> = active
            .filter(|&&(key, slot)| {
                let (a, b) = key.shapes();
                self.collision.pairs.get(slot).in_contact && (is_member(a) || is_member(b)) && has_parted(key)
            })
            .copied()
            .collect();
        for (key, slot) in parted {
            let pair = self.collision.pairs.get_mut(slot);
            pair.forget_impulses();
            pair.in_contact = false;
            self.events.ended_by_edits.push(contact_pair(&self.colliders, &self.bodies, key));
        }
    }

    /// Drops from the list of movers what no longer moves, and sorts it.
    pub(super) fn settle_movers(&mut self) {
        if self.movers.are_sorted {
            return;
        }
        let Self { movers: Movers { slots: movers, .. }, bodies, .. } = self;
        movers.sort_unstable();
        movers.dedup();
        let mut some_are_driven = false;
        movers.retain(|&index| {
            let body = bodies.get(index).filter(|body| body.is_mover());
            some_are_driven |= body.is_some_and(|body| body.kind == BodyKind::Kinematic || body.acts_as() == BodyKind::Kinematic);
            body.is_some()
        });
        (self.movers.are_sorted, self.movers.some_are_driven) = (true, some_are_driven);
    }

    /// Counts the quiet time of every island and puts those to sleep that have been quiet for long enough.
    pub(super) fn put_quiet_islands_to_sleep(&mut self, dt: f32) {
        if !self.def.sleep.enabled {
            return;
        }
        let limits = self.def.sleep;
        let mut sleepy = std::mem::take(&mut self.scratch.slots);
        sleepy.clear();
        for (island, members) in self.islands.groups.islands().enumerate() {
            let mut quiet = f32::INFINITY;
            for &index in members {
                let (quiet_for, drift) =
                    quiet_after(&self.bodies[index], self.collision.index.contact_force(index) != glam::Vec3::ZERO, &limits, dt);
                quiet = quiet.min(quiet_for);
                let now = SleepState::Awake { quiet_for, drift };
                if self.bodies[index].sleep != now {
                    self.bodies[index].sleep = now;
                }
            }
            if quiet >= WATCHED_AGAIN * limits.time && !members.is_empty() {
                sleepy.push(island as u32);
            }
        }
        sleepy.retain(|&island| self.is_at_rest(island));
        let islands = sleepy.iter().filter_map(|&island| self.islands.groups.members_of(island)).map(<[u32]>::to_vec).collect();
        self.scratch.slots = sleepy;
        self.put_islands_to_sleep(islands);
    }

    /// Whether an island that is watched has been at rest for long enough. Where it goes somewhere, the watch begins anew: what swings
    /// stands still where it turns back, so that no single step tells.
    fn is_at_rest(&mut self, island: u32) -> bool {
        let Some(members) = self.islands.groups.members_of(island) else { return false };
        let quiet = |&index: &u32| match self.bodies[index].sleep {
            SleepState::Awake { quiet_for, .. } => quiet_for,
            SleepState::Asleep { .. } => f32::INFINITY,
        };
        let quiet_for = members.iter().map(quiet).fold(f32::INFINITY, f32::min);
        let (since, is_due) = (WATCHED_AGAIN * self.def.sleep.time, quiet_for >= self.def.sleep.time);
        // As if it had been watched for ever, and as it was: springs may want it to be watched for longer.
        if !(self.goes_somewhere(members, f32::INFINITY) || is_due && self.rests_on_a_mover(members)) {
            let gathers_speed = || members.iter().any(|&index| self.gathers_speed(index));
            return is_due && !self.goes_somewhere(members, quiet_for - since) && !gathers_speed();
        }
        if let SleepState::Awake { quiet_for, .. } = &mut self.bodies[members[0]].sleep {
            *quiet_for = since;
        }
        false
    }

    /// Whether a kinematic body that moves touches or holds one of these bodies.
    fn rests_on_a_mover(&self, members: &[u32]) -> bool {
        let moves = |index: u32| self.bodies[index].acts_as() == BodyKind::Kinematic && self.bodies[index].is_mover();
        let jointed = members.iter().flat_map(|&index| &self.bodies[index].joints).filter_map(|&id| self.joints.find(id).ok());
        if jointed.flat_map(|slot| self.joints[slot].bodies).flatten().any(moves) {
            return true;
        }
        self.movers.slots.iter().any(|&index| self.bodies[index].acts_as() == BodyKind::Kinematic)
            && self.collision.pairs.active().iter().any(|&(key, slot)| {
                let (a, b) = key.shapes();
                let (a, b) = (self.colliders[a].body, self.colliders[b].body);
                self.collision.pairs.get(slot).may_touch
                    && ((moves(a) && members.binary_search(&b).is_ok()) || (moves(b) && members.binary_search(&a).is_ok()))
            })
    }

    /// Takes islands and what touches in them out of the steps. All at once: a pass over the pairs for each of many small islands
    /// would take as long as the square of their number.
    fn put_islands_to_sleep(&mut self, islands: Vec<Vec<u32>>) {
        if islands.is_empty() {
            return;
        }
        let mut kept = std::collections::BTreeMap::new();
        for members in islands {
            for &index in &members {
                let body = &mut self.bodies[index];
                body.linear_velocity = glam::Vec3::ZERO;
                body.angular_velocity = glam::Vec3::ZERO;
                body.history.forget_lead();
            }
            let gap = self.gap_of_island(&members);
            let number = self.islands.sleeping.insert(SleepingIsland { bodies: members.clone(), pairs: Vec::new(), gap });
            for &index in &members {
                self.bodies[index].sleep = SleepState::Asleep { island: number };
            }
            kept.insert(number, Vec::new());
        }
        let Self { collision: Collision { pairs, .. }, colliders, bodies, .. } = self;
        pairs.retain_active(|key, slot| {
            let (a, b) = key.shapes();
            let (a, b) = (colliders[a].body, colliders[b].body);
            if bodies[a].is_mover() || bodies[b].is_mover() {
                return Fate::Stay;
            }
            let island = |index: u32| match bodies[index].sleep {
                SleepState::Asleep { island } => Some(island),
                SleepState::Awake { .. } => None,
            };
            let still = |index: u32| !bodies[index].is_free();
            let together = match (island(a), island(b)) {
                (Some(of_a), Some(of_b)) => (of_a == of_b).then_some(of_a),
                (Some(of_a), None) => still(b).then_some(of_a),
                (None, Some(of_b)) => still(a).then_some(of_b),
                (None, None) => None,
            };
            match together.and_then(|island| kept.get_mut(&island)) {
                Some(kept) => {
                    kept.push(slot);
                    Fate::Store
                }
                // Between two sleeping islands: found again when either wakes.
                None => Fate::Drop,
            }
        });
        for (number, kept) in kept {
            if let Some(support) = &mut self.support {
                support.came_to_rest.extend_from_slice(&kept);
            }
            self.islands.sleeping.set_pairs(number, kept);
        }
        self.movers.are_sorted = false;
    }
}
