//! Moves unions: takes in members that were placed by the host, and lets all members follow.

use glam::Vec3;

use super::{Anchor, Union, UnionPlace, Unions, shapes_follow};
use crate::body::{Anchored, Body, within_limit};
use crate::joint_graph::union::loads::Wrench;
use crate::joint_graph::union::matching::{Loose, fit_velocity};
use crate::joint_graph::union::{UnionMotion, inertia_of};
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};
use crate::world::World;
use crate::world::union_loads::wants_load;

impl World {
    /// Takes the members of a new free union as they are.
    pub(super) fn begin_free(&mut self, lead: u32) {
        let Some(union) = self.unions.of(lead) else { return };
        let place = self.unions.place(lead);
        // Where the lead alone would have it: only a place to start from.
        let rotation = (self.bodies[lead].rotation * place.rotation.conjugate()).normalize();
        let center = self.bodies[lead].center - (rotation * place.offset).as_dvec3();
        let motion = UnionMotion { center, rotation, ..UnionMotion::ORIGIN };
        for index in union.members.clone() {
            self.bodies[index].history.forget();
        }
        if let Some(union) = self.unions.of_mut(lead) {
            union.motion = motion;
        }
    }

    /// Gives unions whose members were moved or pushed by the host the motion of all of them together.
    pub(super) fn gather_members(&mut self, again: bool) {
        for number in 0..self.unions.order.len() {
            let slot = self.unions.order[number];
            let Some(union) = &mut self.unions.records[slot as usize] else { continue };
            if again && union.before.is_some() {
                continue;
            }
            // Loads of a step are gone with the next one.
            union.loads.take();
            union.jolts.clear();
            union.pushes.clear();
            if union.anchor != Anchor::Free && union.wanted {
                self.gather_pushes(slot);
            } else if union.anchor == Anchor::Free && self.bodies[union.lead].is_mover() {
                self.gather(slot);
            }
            if let Some(union) = &mut self.unions.records[slot as usize]
                && !matches!(union.anchor, Anchor::Driven(_))
            {
                union.before = Some(union.motion);
            }
        }
        self.unions.take_blows();
        for number in 0..self.unions.pushed.len() {
            let index = self.unions.pushed[number];
            let Some(body) = self.bodies.get(index) else { continue };
            let push = (index, body.force, body.torque);
            if let Some(union) = self.unions.of_mut(index).filter(|union| union.pushes.iter().all(|push| push.0 != index)) {
                union.pushes.push(push);
            }
        }
    }

    /// Notes what the host did to the members of an anchored union: forces act on its joints, and so do impulses, which end there.
    pub(super) fn gather_pushes(&mut self, slot: u32) {
        let Self { unions, bodies, .. } = self;
        let Unions { records, places, pushed, .. } = unions;
        let Some(union) = &mut records[slot as usize] else { return };
        // What is new on something that moves has no velocity of its union yet.
        let is_known = union.anchor == Anchor::Still || union.before.is_some();
        for (number, &index) in union.members.iter().enumerate() {
            let body = &mut bodies[index];
            if body.force != Vec3::ZERO || body.torque != Vec3::ZERO {
                union.pushes.push((index, body.force, body.torque));
                pushed.push(index);
            }
            let (linear, angular) = union.velocities_at(&places[index as usize]);
            if let Some(jolt) = jolt_to(body, linear, angular).filter(|_| is_known) {
                union.jolts.resize(union.members.len(), Wrench::default());
                union.jolts[number] = jolt;
                (body.linear_velocity, body.angular_velocity) = (linear, angular);
            }
        }
        pushed.sort_unstable();
        pushed.dedup();
    }

    /// Says that a joint has other limits.
    pub(in crate::world) fn limits_changed(&mut self, slot: u32) {
        for index in self.joints[slot].bodies.into_iter().flatten() {
            // What was found when asked for is what the records hold from now on.
            let lead = self.unions.of(index).filter(|union| !union.wanted).map(|union| union.lead);
            for slot in lead.and_then(|lead| self.unions.of(lead)).map(|union| union.fixed_links.clone()).unwrap_or_default() {
                if let Some(load) = self.load_inside(slot) {
                    (self.joints[slot].force, self.joints[slot].torque) = load;
                }
            }
            let joints = &self.joints;
            if let Some(union) = self.unions.of_mut(index) {
                union.stiffness.take();
                union.wanted = union.fixed_links.iter().any(|&slot| wants_load(&joints[slot].def));
            }
        }
    }

    pub(super) fn gather(&mut self, slot: u32) {
        let Self { unions, bodies, colliders, .. } = self;
        let Unions { records, places, scratch, .. } = unions;
        let Some(union) = &mut records[slot as usize] else { return };
        let (mut moved, mut pushed) = (false, false);
        for &index in &union.members {
            let (body, place) = (&bodies[index], &places[index as usize]);
            let expected = union.motion.at(place.offset, place.rotation);
            moved |= body.center != expected.center || body.rotation != expected.rotation;
            pushed |= body.linear_velocity != expected.linear || body.angular_velocity != expected.angular;
            if body.force != Vec3::ZERO || body.torque != Vec3::ZERO {
                union.pushes.push((index, body.force, body.torque));
            }
        }
        if !moved && !pushed {
            return;
        }
        scratch.loose.clear();
        scratch.places.clear();
        for &index in &union.members {
            let (body, place) = (&bodies[index], &places[index as usize]);
            let Some(mass) = body.mass else { return };
            let motion = UnionMotion {
                center: body.center,
                rotation: body.rotation,
                linear: body.linear_velocity,
                angular: body.angular_velocity,
            };
            scratch.loose.push(Loose { mass, motion });
            scratch.places.push((place.offset, place.rotation));
        }
        if moved {
            (union.motion.center, union.motion.rotation) =
                union.covariances.fit_pose(&scratch.loose, &scratch.places, union.motion.rotation);
        }
        (union.motion.linear, union.motion.angular) = fit_velocity(&scratch.loose, &union.mass, union.motion.rotation);
        if union.before.is_some() && !moved {
            union.jolts.extend(scratch.loose.iter().zip(&scratch.places).map(|(loose, &(offset, rotation))| {
                let Loose { mass, motion } = loose;
                let fitted = union.motion.at(offset, rotation);
                let inertia = inertia_of(mass, motion.rotation.as_dquat().normalize());
                Wrench {
                    force: (fitted.linear - motion.linear).as_dvec3() * f64::from(mass.mass),
                    torque: inertia * (fitted.angular - motion.angular).as_dvec3(),
                }
            }));
        }
        for &index in &union.members {
            follow(&mut bodies[index], &union.motion, &places[index as usize]);
            if moved {
                shapes_follow(&bodies[index], colliders);
            }
        }
    }

    /// Gives what kinematic bodies hold their velocity in a step of length `dt` (s), or again in the same step.
    pub(super) fn drive_anchored(&mut self, dt: Option<f32>) {
        let step = self.report.step;
        for number in 0..self.unions.order.len() {
            let Some(union) = &self.unions.records[self.unions.order[number] as usize] else { continue };
            let Anchor::Driven(anchor) = union.anchor else { continue };
            let driver = &self.bodies[anchor];
            let (center, linear, angular) = (driver.center, driver.linear_velocity, driver.angular_velocity);
            let lead = union.lead;
            if let Some(union) = self.unions.of_mut(lead) {
                let old = union.motion;
                union.motion.linear = linear + angular.cross((union.motion.center - center).as_vec3());
                union.motion.angular = angular;
                union.before = match union.before {
                    // One that is new has moved like this before.
                    None => Some(union.motion),
                    Some(before) if dt.is_none() => Some(before),
                    Some(_) => Some(old),
                };
            }
            let count = self.unions.of(lead).map_or(0, |union| union.members.len());
            for number in 0..count {
                let Some(&index) = self.unions.of(lead).and_then(|union| union.members.get(number)) else { continue };
                let body = &mut self.bodies[index];
                let was_mover = body.is_mover();
                let linear = linear + angular.cross((body.center - center).as_vec3());
                body.linear_velocity = within_limit(linear, MAX_LINEAR_SPEED);
                body.angular_velocity = angular;
                if let Some(dt) = dt
                    && (was_mover || body.is_mover())
                {
                    let velocity = [body.linear_velocity, body.angular_velocity];
                    body.kinematic.path.get_or_insert_default().begin_step(step, dt, velocity);
                }
                match (was_mover, body.is_mover()) {
                    (false, true) => self.movers.slots.push(index),
                    (true, false) => self.rest_boxes(index),
                    _ => {}
                }
            }
            self.movers.are_sorted = false;
        }
    }

    /// Ends the step of what is anchored: what kinematic bodies hold is put where those are now, and pushes are spent.
    pub(in crate::world) fn carry_anchored(&mut self) {
        for number in 0..self.unions.order.len() {
            let Some(union) = &self.unions.records[self.unions.order[number] as usize] else { continue };
            if matches!(union.anchor, Anchor::Driven(_)) && self.bodies[union.lead].is_mover() {
                let lead = union.lead;
                let motion = self.anchored_motion(lead);
                self.place_members(lead, motion);
                self.keep_members_along(lead);
            }
        }
        for index in std::mem::take(&mut self.unions.pushed) {
            if self.bodies.get(index).is_some_and(|body| body.anchored != Anchored::No) {
                (self.bodies[index].force, self.bodies[index].torque) = (Vec3::ZERO, Vec3::ZERO);
            }
        }
    }

    /// Gives the members of an anchored union the velocities that they have with it.
    fn keep_members_along(&mut self, lead: u32) {
        let Self { unions, bodies, .. } = self;
        let Some(union) = unions.of(lead) else { return };
        for &index in &union.members {
            (bodies[index].linear_velocity, bodies[index].angular_velocity) = union.velocities_at(&unions.places[index as usize]);
        }
    }

    /// Where an anchored union stands, by its anchor.
    pub(super) fn anchored_motion(&self, lead: u32) -> UnionMotion {
        let Some(union) = self.unions.of(lead) else { return UnionMotion::ORIGIN };
        let at = self.frame_of_anchor(&union.anchors).then(&union.held);
        UnionMotion { center: at.position, rotation: at.rotation.as_quat(), ..UnionMotion::ORIGIN }
    }

    /// Puts the members of a new anchored union where they belong.
    pub(super) fn put_anchored(&mut self, lead: u32) {
        let motion = self.anchored_motion(lead);
        self.place_members(lead, motion);
        let members = self.unions.of(lead).map(|union| union.members.clone()).unwrap_or_default();
        for &index in &members {
            self.take_boxes_along(index);
        }
        self.wake_for_places(&members);
    }

    /// Gives a union this pose, and its members with it; velocities stay.
    pub(in crate::world) fn place_members(&mut self, lead: u32, motion: UnionMotion) {
        let Self { unions, bodies, colliders, .. } = self;
        let slot = unions.place(lead).union;
        let Some(union) = unions.records.get_mut(slot as usize).and_then(Option::as_mut) else { return };
        union.motion = UnionMotion { linear: union.motion.linear, angular: union.motion.angular, ..motion };
        for &index in &union.members {
            let place = &unions.places[index as usize];
            let at = union.motion.at(place.offset, place.rotation);
            let body = &mut bodies[index];
            (body.center, body.rotation) = (at.center, at.rotation);
            shapes_follow(body, colliders);
        }
    }
}

impl Unions {
    /// Has an anchored body move as its union does, and notes what that takes of the joints.
    pub(in crate::world) fn stop(&mut self, index: u32, body: &mut Body) {
        let (linear, angular) = self.velocities_of(index);
        // What is new on something that moves has no velocity of its union yet.
        let is_known = self.of(index).is_some_and(|union| union.anchor == Anchor::Still || union.before.is_some());
        self.struck.extend(jolt_to(body, linear, angular).filter(|_| is_known).map(|jolt| (index, jolt)));
        (body.linear_velocity, body.angular_velocity) = (linear, angular);
    }

    /// Gives unions the blows that have been noted since the last step.
    fn take_blows(&mut self) {
        let mut struck = std::mem::take(&mut self.struck);
        for (index, blow) in struck.drain(..) {
            let Some(union) = self.of_mut(index).filter(|union| union.anchor != Anchor::Free) else { continue };
            let Ok(number) = union.members.binary_search(&index) else { continue };
            union.jolts.resize(union.members.len(), Wrench::default());
            union.jolts[number].force += blow.force;
            union.jolts[number].torque += blow.torque;
        }
        self.struck = struck;
    }
}

impl Union {
    /// Linear and angular velocity of a member.
    pub(super) fn velocities_at(&self, place: &UnionPlace) -> (Vec3, Vec3) {
        let motion = self.motion.at(place.offset, place.rotation);
        (within_limit(motion.linear, MAX_LINEAR_SPEED), within_limit(motion.angular, MAX_ANGULAR_SPEED))
    }
}

/// Gives a member the motion that it has in its union.
fn follow(body: &mut Body, union: &UnionMotion, place: &UnionPlace) {
    let motion = union.at(place.offset, place.rotation);
    (body.center, body.rotation) = (motion.center, motion.rotation);
    body.linear_velocity = within_limit(motion.linear, MAX_LINEAR_SPEED);
    body.angular_velocity = within_limit(motion.angular, MAX_ANGULAR_SPEED);
}

/// What gives a body these velocities, if it has others (N·s, N·m·s about its centre).
fn jolt_to(body: &Body, linear: Vec3, angular: Vec3) -> Option<Wrench> {
    let mass = body.mass.filter(|_| body.linear_velocity != linear || body.angular_velocity != angular)?;
    Some(Wrench {
        force: (linear - body.linear_velocity).as_dvec3() * f64::from(mass.mass),
        torque: inertia_of(&mass, body.rotation.as_dquat().normalize()) * (angular - body.angular_velocity).as_dvec3(),
    })
}
