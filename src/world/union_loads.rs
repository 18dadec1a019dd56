//! Stage that computes the loads of joints inside unions from the motion of their bodies.
//!
//! For unions with a joint that has a limit the loads are found in every step; for others when somebody asks. A member's joints
//! together exert what it needs beyond everything else that acts on it,
//!
//! ```text
//! n_i = m_i (v_i' − v_i)/dt − m_i g − F_i − contacts − other joints,        likewise for the angular momentum,
//! ```
//!
//! and [`BondStiffness`] distributes it. Contacts count with their mean over the step's substeps; those of what sleeps with
//! the last one that it took.

use glam::{DMat3, DVec3, Quat, Vec3};

use super::World;
use super::unions::{Anchor, Union};
use crate::collide::pairs::WorldManifold;
use crate::fracture::Strength;
use crate::joint::JointDef;
use crate::joint_graph::union::loads::{BondStiffness, UnionBond, UnionMember, Wrench};
use crate::joint_graph::union::{UnionMotion, inertia_of};
use crate::joint_record::told_load;
use crate::report::JointOverload;
use crate::solve::contact::ContactImpulses;
use crate::solve::joint::kinds::is_distance;

/// Whether somebody wants to know the load of a joint in every step.
pub(super) fn wants_load(def: &JointDef) -> bool {
    def.strength.can_break() || def.break_force < f32::INFINITY || def.break_torque < f32::INFINITY
}

/// Impulses of a contact manifold in a step, over its substeps: pair, manifold of the pair, mean.
type Mean = (u32, u32, ContactImpulses);

impl World {
    /// Writes the loads of joints inside unions into their records, where they are wanted, before the solve is stored.
    pub(super) fn find_union_loads(&mut self, dt: f32) {
        let half_steps: Vec<u32> = self.unions.iter().filter(|union| union.wanted).map(|union| union.lead).collect();
        if half_steps.is_empty() {
            return;
        }
        let contacts = self.contact_wrenches(&self.mean_impulses(), dt);
        for lead in half_steps {
            let Some(union) = self.unions.of(lead) else { continue };
            if union.anchor == Anchor::Free && !self.bodies[lead].is_mover() {
                continue;
            }
            let loads = self.loads_of(union, &self.motion_after(union), &contacts, dt);
            let fixed_links = union.fixed_links.clone();
            for (&slot, load) in fixed_links.iter().zip(&loads) {
                let joint = &mut self.joints[slot];
                (joint.force, joint.torque) = told_load(load.force.as_vec3(), load.torque.as_vec3());
            }
        }
    }

    /// Lists joints inside unions that are above the load at which they are reported.
    pub(super) fn report_union_overloads(&mut self) {
        let Self { unions, joints, events, bodies, .. } = self;
        let moves = |union: &&Union| union.anchor != Anchor::Free || bodies[union.lead].is_mover();
        for &slot in unions.iter().filter(|union| union.wanted).filter(moves).flat_map(|union| &union.fixed_links) {
            let joint = &joints[slot];
            if joint.is_overloaded() {
                let (force, torque) = (joint.force.length(), joint.torque.length());
                let user_word = joint.def.user_word;
                events.overloaded.push(JointOverload { joint: joints.handle_of(slot), user_word, force, torque });
            }
        }
        events.overloaded.sort_unstable_by_key(|overload| joints.find(overload.joint).unwrap_or(u32::MAX));
    }

    /// How a union moves at the end of the solve.
    pub(super) fn motion_after(&self, union: &Union) -> UnionMotion {
        match self.solved_at(union.lead) {
            Some((batch, slot)) if union.anchor == Anchor::Free => {
                let (velocity, motion) = (&batch.velocities[slot], &batch.motions[slot]);
                UnionMotion {
                    center: union.motion.center + motion.displacement.as_dvec3(),
                    rotation: motion.rotation,
                    linear: velocity.linear,
                    angular: velocity.angular,
                }
            }
            _ => union.motion,
        }
    }

    /// Load of a joint that nothing solves in the last step: force (N) and torque (N·m) about the joint point on body B, world axes.
    pub(super) fn load_inside(&self, slot: u32) -> Option<(Vec3, Vec3)> {
        self.load_of_link(slot).or_else(|| self.idle_load(slot, self.last.dt).map(|idle| (idle.force, idle.torque)))
    }

    /// The same of a joint that a union is made of.
    fn load_of_link(&self, slot: u32) -> Option<(Vec3, Vec3)> {
        let joint = &self.joints[slot];
        let member = joint.bodies.into_iter().flatten().find(|&index| self.bodies[index].is_dynamic())?;
        let union = self.unions.of(member)?;
        let number = union.fixed_links.binary_search(&slot).ok()?;
        if union.wanted {
            return Some((joint.force, joint.torque));
        }
        let loads = union.loads.get_or_init(|| {
            let contacts = self.contact_wrenches(&self.mean_impulses(), self.last.dt);
            self.loads_of(union, &union.motion, &contacts, self.last.dt)
        });
        let load = loads.get(number)?;
        Some(told_load(load.force.as_vec3(), load.torque.as_vec3()))
    }

    /// What batches tallied, sorted.
    fn mean_impulses(&self) -> Vec<Mean> {
        let mut means = Vec::new();
        for batch in &self.batches.list[..self.batches.count] {
            means.extend(batch.tallies().map(|(number, impulses)| {
                let (pair, manifold) = batch.manifolds.list[number];
                (pair, manifold, impulses.scaled(1.0 / self.def.substeps as f32))
            }));
        }
        means.sort_unstable_by_key(|&(pair, manifold, _)| (pair, manifold));
        means
    }

    /// Loads of all joints of a union, world axes, about their points.
    fn loads_of(&self, union: &Union, after: &UnionMotion, contacts: &[Wrench], dt: f32) -> Vec<Wrench> {
        if dt <= 0.0 {
            return vec![Wrench::default(); union.fixed_links.len()];
        }
        let stiffness = union.stiffness.get_or_init(|| self.bond_stiffness(union));
        let mut needed: Vec<Wrench> = union.members.iter().map(|&index| self.inertial_need(union, after, index, dt)).collect();
        for (wrench, jolt) in needed.iter_mut().zip(&union.jolts) {
            wrench.force += jolt.force / f64::from(dt);
            wrench.torque += jolt.torque / f64::from(dt);
        }
        for (need, &index) in needed.iter_mut().zip(&union.members) {
            if let Some(contact) = contacts.get(index as usize) {
                need.force -= contact.force;
                need.torque -= contact.torque;
            }
        }
        self.take_other_joints(union, &mut needed, dt);
        // Loads are means over the step, and so are the axes that they are found in.
        let began = union.before.filter(|_| union.anchor != Anchor::Still).map_or(after.rotation, |before| before.rotation);
        let turn = halfway(began, after.rotation).as_dquat().normalize();
        let own = turn.conjugate();
        for wrench in &mut needed {
            (wrench.force, wrench.torque) = (own * wrench.force, own * wrench.torque);
        }
        let mut loads = stiffness.solve(&needed);
        for load in &mut loads {
            (load.force, load.torque) = (turn * load.force, turn * load.torque);
        }
        loads
    }

    /// Change of a member's momentum over the step, less weight and the host's forces.
    fn inertial_need(&self, union: &Union, after: &UnionMotion, index: u32, dt: f32) -> Wrench {
        let body = &self.bodies[index];
        let Some(mass) = &body.mass else { return Wrench::default() };
        let kilograms = f64::from(mass.mass);
        let gravity = (self.def.gravity * body.settings.gravity_scale).as_dvec3() * kilograms;
        let (push, twist) = union
            .pushes
            .iter()
            .find(|push| push.0 == index)
            .map_or((DVec3::ZERO, DVec3::ZERO), |&(_, force, torque)| (force.as_dvec3(), torque.as_dvec3()));
        let mut need = Wrench { force: -gravity - push, torque: -twist };
        if let Some(before) = union.before.filter(|_| union.anchor != Anchor::Still) {
            let [old, new] = [&before, after].map(|motion| self.unions.motion_of(index, motion));
            let spin =
                |rotation: glam::Quat, angular: Vec3| inertia_of(mass, rotation.as_dquat().normalize()) * angular.as_dvec3();
            need.force += (new.linear - old.linear).as_dvec3() * (kilograms / f64::from(dt));
            need.torque += (spin(new.rotation, new.angular) - spin(old.rotation, old.angular)) / f64::from(dt);
        }
        need
    }

    /// What contacts do to each member of a union, by slot: about its centre.
    fn contact_wrenches(&self, means: &[Mean], dt: f32) -> Vec<Wrench> {
        let mut wrenches = vec![Wrench::default(); self.bodies.slot_count()];
        let per_substep = f64::from(self.def.substeps as f32 / dt);
        let asleep = self.islands.sleeping.pairs().map(|slot| (self.collision.pairs.get(slot).key, slot));
        for (key, slot) in self.collision.pairs.listed().iter().copied().chain(asleep) {
            let (a, b) = key.shapes();
            let (shape_a, shape_b) = (&self.colliders[a], &self.colliders[b]);
            let member = |index: u32| self.unions.number_of(index).map(|_| index as usize);
            let ends = [member(shape_a.body), member(shape_b.body)];
            if ends == [None; 2] {
                continue;
            }
            let pair = self.collision.pairs.get(slot);
            for (number, carried) in pair.manifolds.iter().enumerate() {
                let world =
                    WorldManifold::new(&carried, (shape_a, &self.bodies[shape_a.body]), (shape_b, &self.bodies[shape_b.body]));
                let mean = means.binary_search_by_key(&(slot, number as u32), |&(pair, manifold, _)| (pair, manifold));
                let impulses = mean.map_or(*carried.impulses, |found| means[found].2);
                for (end, sign, levers) in [(ends[0], -1.0, &world.lever_a), (ends[1], 1.0, &world.lever_b)] {
                    let Some(end) = end else { continue };
                    let (force, torque) = impulses.wrench(world.normal, &levers[..carried.points.len()]);
                    wrenches[end].force += force.as_dvec3() * (sign * per_substep);
                    wrenches[end].torque += torque.as_dvec3() * (sign * per_substep);
                }
            }
        }
        wrenches
    }

    /// Takes from what members need what joints that the union is not made of give them.
    fn take_other_joints(&self, union: &Union, needed: &mut [Wrench], dt: f32) {
        for &slot in union.outer.iter().chain(&union.inner) {
            let joint = &self.joints[slot];
            let [on_b, about_b] = self.idle_load(slot, dt).map_or([joint.force, joint.torque], |idle| [idle.force, idle.torque]);
            for side in 0..2 {
                // The force acts at B's point, on both; that of a distance joint on each body at its own.
                let point = self.joint_point(joint, if is_distance(&joint.def) { side } else { 1 });
                let Some(index) = joint.bodies[side] else { continue };
                let Ok(end) = union.members.binary_search(&index) else { continue };
                let sign = if side == 1 { 1.0 } else { -1.0 };
                let force = on_b.as_dvec3() * sign;
                let torque = about_b.as_dvec3() * sign + (point - self.bodies[index].center).cross(force);
                needed[end].force -= force;
                needed[end].torque -= torque;
            }
        }
    }

    fn bond_stiffness(&self, union: &Union) -> BondStiffness {
        let bodies = union.members.iter().map(|&index| {
            let place = self.unions.place(index);
            let mass = self.bodies[index].mass.as_ref();
            UnionMember {
                center: place.offset.as_dvec3(),
                mass: mass.map_or(0.0, |mass| f64::from(mass.mass)),
                inertia: mass.map_or(DMat3::ZERO, |mass| inertia_of(mass, place.rotation.as_dquat().normalize())),
            }
        });
        let member = |index: Option<u32>| union.members.binary_search(&index?).ok().map(|place| place as u32);
        let bonds = union.fixed_links.iter().map(|&slot| {
            let joint = &self.joints[slot];
            let members = joint.bodies.map(member);
            // On B where it is a member: that is the point that a joint's load is about.
            let side = usize::from(members[1].is_some());
            let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
            let point = joint.bodies[side].map_or(DVec3::ZERO, |index| {
                let place = self.unions.place(index);
                let lever = frame.position - self.bodies[index].local_center.as_dvec3();
                place.offset.as_dvec3() + place.rotation.as_dquat().normalize() * lever
            });
            UnionBond { members, point, stiffness: stiffness_of(&joint.def.strength) }
        });
        BondStiffness::new(bodies.collect(), bonds.collect())
    }
}

/// What a joint's strength says of its stiffness: that of a bond of the same area (N per unit stress) and radius r, ℓ² = r²/4.
fn stiffness_of(strength: &Strength) -> Option<[f64; 2]> {
    let (pull, bend) = (f64::from(strength.tension), f64::from(strength.bending));
    let is_bond = pull > 0.0 && bend > 0.0 && pull.is_finite() && bend.is_finite();
    is_bond.then(|| [pull, (2.0 * bend / pull).powi(2)])
}

/// The rotation halfway between two that are close.
pub(super) fn halfway(a: Quat, b: Quat) -> Quat {
    let b = if a.dot(b) < 0.0 { -b } else { b };
    (a + b).normalize()
}
