//! Rigid unions of a world: which bodies fixed joints make one, updated as joints come and go, and how each moves.
//!
//! A body of a free union is no body of the solver: the union has one slot, and contacts, joints and bounds of its members act on
//! that. What is anchored to something static stands like it; what is anchored to a kinematic body is driven by it. Joints inside
//! a union are not solved at all.
//!
//! **Kept up lazily.** An edit that concerns a fixed joint dissolves the unions of its bodies at once and notes the bodies; the next
//! step floods from those alone. Members carry their own poses and velocities, so a union that has fallen apart leaves each piece
//! what it had.
//!
//! **Members first.** A union's motion is kept with it, and members follow to the last bit. One that is found elsewhere, or at
//! another velocity, was put there: the union takes it in by shape matching and a velocity fit that keeps momentum.

use std::sync::OnceLock;

use glam::{Quat, Vec3};

use super::World;
use super::wake::Edited;
use crate::body::{Anchored, Body, within_limit};
use crate::collide::collider::Collider;
use crate::dwell_time::DwellTime;
use crate::id::{Pool, ShapeId};
use crate::joint::JointKind;
use crate::joint_graph::union::loads::{BondStiffness, Wrench};
use crate::joint_graph::union::matching::{Covariances, Loose};
use crate::joint_graph::union::{Pose64, UnionMotion};
use crate::mass::MassProperties;
use crate::snapshot::carried::CarriedUnion;
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};

mod flood;
mod motion;

/// No union.
pub(super) const NONE: u32 = u32::MAX;

/// Where a body is in its union.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnionPlace {
    pub union: u32,
    /// From the union's centre of mass, in its axes (m), and the rotation there.
    pub offset: Vec3,
    pub rotation: Quat,
}

impl UnionPlace {
    const OUTSIDE: Self = Self { union: NONE, offset: Vec3::ZERO, rotation: Quat::IDENTITY };
}

/// What holds a union.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    /// Nothing: it is one body of the solver.
    Free,
    /// The world or static bodies.
    Still,
    /// This kinematic body.
    Driven(u32),
}

/// Bodies that move as one.
#[derive(Debug)]
pub(super) struct Union {
    /// Lowest dynamic member: its slot stands for the union.
    pub lead: u32,
    /// Dynamic members, sorted.
    pub members: Vec<u32>,
    pub anchor: Anchor,
    /// Static and kinematic bodies that hold it, sorted.
    pub anchors: Vec<u32>,
    /// Fixed joints that it is made of, sorted.
    pub fixed_links: Vec<u32>,
    /// Joints to what does not belong to it, sorted, and those between members that it is not made of, which nothing solves.
    pub outer: Vec<u32>,
    pub inner: Vec<u32>,
    /// Of all dynamic members.
    pub mass: MassProperties,
    covariances: Covariances,
    /// Its frame in that of its first anchor.
    held: Pose64,
    /// Worst distance (m) and angle (rad) by which its joints contradict one another.
    pub residual: (f32, f32),
    pub motion: UnionMotion,
    /// Where it was, and how it moved, before the last step; nothing before its first one.
    pub before: Option<UnionMotion>,
    /// Whether a joint in it has a limit, so that loads are found in every step.
    pub wanted: bool,
    /// Members that the host pushed in the last step: force (N) and torque (N·m).
    pub pushes: Vec<(u32, Vec3, Vec3)>,
    /// What the joints did when the host gave members velocities of their own before the last step (N·s, N·m·s, about centres).
    pub jolts: Vec<Wrench>,
    /// Stiffness of its joints, made when loads are first asked for.
    pub stiffness: OnceLock<BondStiffness>,
    /// Loads of the joints in `fixed_links` in the last step, likewise.
    pub loads: OnceLock<Vec<Wrench>>,
}

/// All unions of a world.
#[derive(Debug, Default)]
pub(super) struct Unions {
    /// By body slot.
    pub places: Vec<UnionPlace>,
    records: Vec<Option<Union>>,
    free: Vec<u32>,
    /// Unions sorted by their lead.
    pub order: Vec<u32>,
    /// Bodies to flood from.
    pub stale: Vec<u32>,
    /// Anchored bodies that the host has pushed since the last step.
    pub pushed: Vec<u32>,
    /// What has been taken from anchored bodies of the velocities that the host gave them since the last step (N·s, N·m·s, about centres).
    struck: Vec<(u32, Wrench)>,
    /// Counts up whenever a union is made or dissolved.
    pub version: u64,
    scratch: UnionScratch,
}

#[derive(Debug, Default)]
struct UnionScratch {
    loose: Vec<Loose>,
    places: Vec<(Vec3, Quat)>,
}

impl Unions {
    pub(super) fn place(&self, body: u32) -> UnionPlace {
        self.places.get(body as usize).copied().unwrap_or(UnionPlace::OUTSIDE)
    }

    /// Linear and angular velocity that a member has as its union does; none outside one.
    pub(super) fn velocities_of(&self, body: u32) -> (Vec3, Vec3) {
        let place = self.place(body);
        self.of(body).map_or((Vec3::ZERO, Vec3::ZERO), |union| union.velocities_at(&place))
    }

    /// Union that a body belongs to.
    pub(super) fn of(&self, body: u32) -> Option<&Union> {
        let place = self.places.get(body as usize)?;
        self.records.get(place.union as usize)?.as_ref()
    }

    pub(super) fn of_mut(&mut self, body: u32) -> Option<&mut Union> {
        let slot = self.place(body).union;
        self.records.get_mut(slot as usize)?.as_mut()
    }

    /// The union of a body that the solver moves as part of it.
    pub(super) fn moving(&self, body: u32) -> Option<&Union> {
        self.of(body).filter(|union| union.anchor == Anchor::Free)
    }

    /// Those that this kinematic body drives.
    pub(super) fn driven_by(&self, kinematic: u32) -> impl Iterator<Item = &Union> {
        self.records.iter().flatten().filter(move |union| union.anchor == Anchor::Driven(kinematic))
    }

    /// What a member does where its union does this.
    pub(super) fn motion_of(&self, member: u32, union: &UnionMotion) -> UnionMotion {
        let place = self.place(member);
        union.at(place.offset, place.rotation)
    }

    /// Number of the union that a body belongs to.
    pub(super) fn number_of(&self, body: u32) -> Option<u32> {
        self.places.get(body as usize).map(|place| place.union).filter(|&union| union != NONE)
    }

    pub(super) fn same(&self, a: u32, b: u32) -> bool {
        match (self.places.get(a as usize), self.places.get(b as usize)) {
            (Some(a), Some(b)) => a.union != NONE && a.union == b.union,
            _ => false,
        }
    }

    /// All unions, by lead.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Union> {
        self.order.iter().filter_map(|&slot| self.records[slot as usize].as_ref())
    }

    /// Removes the union in this slot; its members belong to none then.
    fn dissolve(&mut self, slot: u32) -> Option<Union> {
        let union = self.records.get_mut(slot as usize)?.take()?;
        self.version += 1;
        for &body in union.members.iter().chain(&union.anchors) {
            if let Some(place) = self.places.get_mut(body as usize).filter(|place| place.union == slot) {
                *place = UnionPlace::OUTSIDE;
            }
        }
        self.order.retain(|&other| other != slot);
        self.free.push(slot);
        Some(union)
    }

    fn insert(&mut self, union: Union, places: &[(Vec3, Quat)]) {
        self.version += 1;
        let slot = self.free.pop().unwrap_or_else(|| {
            self.records.push(None);
            self.records.len() as u32 - 1
        });
        for (&body, &(offset, rotation)) in union.members.iter().zip(places) {
            self.places[body as usize] = UnionPlace { union: slot, offset, rotation };
        }
        let lead = union.lead;
        let records = &self.records;
        let place = self.order.partition_point(|&other| records[other as usize].as_ref().is_some_and(|union| union.lead < lead));
        self.order.insert(place, slot);
        self.records[slot as usize] = Some(union);
    }
}

/// Whether a dynamic body can be part of a union: axes locked in the world would have to be locked for all of it.
fn can_join(body: &Body) -> bool {
    body.is_dynamic() && !body.quarantined && body.settings.locked_axes == crate::body::LockedAxes::default()
}

impl World {
    /// Whether a joint leaves its bodies no freedom at all, and nothing but unions has to know of it.
    fn is_weld(&self, slot: u32) -> bool {
        let joint = &self.joints[slot];
        let def = &joint.def;
        let rigid = matches!(def.kind, JointKind::Fixed) && def.linear.compliance == 0.0 && def.angular.compliance == 0.0;
        // One by which the host drags its body along gives it a speed.
        let drags =
            joint.drive.is_some() && joint.bodies.iter().any(|body| body.is_none_or(|body| !self.bodies[body].is_dynamic()));
        // A soft bound ends at joints, and needs bodies on both sides.
        rigid && !drags && def.long_range && !self.long_range.is_asked_at(self.joints.handle_of(slot))
    }

    /// Says that a joint is new, about to go, or another than it was.
    pub(super) fn joint_changed(&mut self, slot: u32) {
        let fixed_link = self.is_weld(slot);
        for index in self.joints[slot].bodies.into_iter().flatten() {
            if fixed_link || self.unions.place(index).union != NONE {
                self.welds_changed(index);
            }
        }
    }

    /// Says that fixed joints of a body, its mass, or whether it can be part of a union have changed.
    pub(super) fn welds_changed(&mut self, index: u32) {
        let slot = self.unions.place(index).union;
        let anchored_here: Vec<u32> = match self.bodies.get(index) {
            // An anchor belongs to no union, and may hold several.
            Some(body) if !body.is_dynamic() => self.unions_held_by(index),
            _ => Vec::new(),
        };
        // A body that comes to be free to join belongs to no union yet, but those beside it will be other ones with it.
        let beside = self.unions_welded_to(index);
        for slot in anchored_here.into_iter().chain((slot != NONE).then_some(slot)).chain(beside) {
            self.dissolve_union(slot);
        }
        self.unions.stale.push(index);
    }

    /// Takes a union apart, and has its members looked at in the next flood. Does nothing where there is none.
    fn dissolve_union(&mut self, slot: u32) {
        let Some(union) = self.unions.dissolve(slot) else { return };
        self.set_anchored(&union.members, Anchored::No);
        for &member in &union.members {
            self.revisit_shapes(member);
        }
        self.unions.stale.extend_from_slice(&union.members);
        self.long_range.graph_changed();
    }

    /// Unions with a member that a weld connects to this dynamic body.
    fn unions_welded_to(&self, index: u32) -> Vec<u32> {
        let Some(body) = self.bodies.get(index).filter(|body| body.is_dynamic()) else { return Vec::new() };
        let fixed_links = body.joints.iter().filter_map(|&id| self.joints.find(id).ok()).filter(|&slot| self.is_weld(slot));
        let others = fixed_links.flat_map(|slot| self.joints[slot].bodies).flatten().filter(|&other| other != index);
        others.map(|other| self.unions.place(other).union).filter(|&slot| slot != NONE).collect()
    }

    /// Has what is near a body looked for: members of a union are no pairs, those of two are.
    fn revisit_shapes(&mut self, index: u32) {
        let Some(body) = self.bodies.get(index) else { return };
        for &id in &body.shapes {
            if let Ok(shape) = self.colliders.find(id) {
                self.collision.broad.revisit(shape);
            }
        }
    }

    fn unions_held_by(&self, anchor: u32) -> Vec<u32> {
        let holds = |&&slot: &&u32| {
            self.unions.records[slot as usize].as_ref().is_some_and(|union| union.anchors.binary_search(&anchor).is_ok())
        };
        self.unions.order.iter().filter(holds).copied().collect()
    }

    /// Has all unions made anew.
    pub(super) fn all_welds_changed(&mut self) {
        let welded: Vec<u32> =
            self.bodies.iter().filter(|(_, body)| body.is_dynamic() && !body.joints.is_empty()).map(|(index, _)| index).collect();
        for index in welded {
            self.welds_changed(index);
        }
    }

    /// Says what bodies are anchored to: all members of a union at once, as each wakes what is around all of them.
    fn set_anchored(&mut self, members: &[u32], anchored: Anchored) {
        let is_other = |&index: &u32| self.bodies.get(index).is_some_and(|body| body.anchored != anchored);
        let changed: Vec<u32> = members.iter().copied().filter(is_other).collect();
        if anchored == Anchored::Still {
            self.movers.stopped.extend(changed.iter().filter(|&&index| self.bodies[index].is_under_way()));
        }
        for &index in &changed {
            self.wake_for(Edited::Body(index));
        }
        for &index in &changed {
            let wanted = self.unions.of(index).is_some_and(|union| union.wanted);
            let body = &mut self.bodies[index];
            (body.anchored, body.kinematic.path) = (anchored, None);
            if anchored != Anchored::No {
                // A velocity becomes a blow to the joints. Where those have limits, that is found as the step begins.
                if anchored == Anchored::Driven {
                    (body.linear_velocity, body.angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
                } else if !wanted {
                    self.unions.stop(index, body);
                }
                (body.held, body.times.calm_for) = (false, DwellTime::NONE);
            }
            // That of what is anchored is added up when somebody asks.
            self.collision.index.forget_force(index);
        }
        self.movers.are_sorted = false;
        self.wake_for_places(&changed);
        for &index in &changed {
            self.rest_boxes(index);
            self.note_mover(index);
            self.topology_changed();
        }
    }

    /// Brings unions up to date with the joints, and their motion with what was done to members.
    pub(super) fn form_unions(&mut self, dt: f32) {
        self.flood_unions();
        self.gather_members(false);
        self.drive_anchored(Some(dt));
        self.settle_movers();
    }

    /// The same within a step, where joints have broken: unions that are left have their motion and forces of this step already.
    pub(super) fn form_unions_again(&mut self) {
        self.flood_unions();
        self.gather_members(true);
        self.drive_anchored(None);
        self.settle_movers();
    }

    /// Gives the members of a union that is about to break the velocities that the host gave each, before the union shared them.
    pub(super) fn take_back_jolts(&mut self, index: u32) {
        let Self { unions, bodies, .. } = self;
        let Some(union) = unions.of_mut(index) else { return };
        for (&member, jolt) in union.members.iter().zip(&union.jolts) {
            let body = &mut bodies[member];
            let (linear, angular) =
                (jolt.force.as_vec3() * body.own_inverse_mass(), body.own_inverse_inertia() * jolt.torque.as_vec3());
            body.linear_velocity = within_limit(body.linear_velocity - linear, MAX_LINEAR_SPEED);
            body.angular_velocity = within_limit(body.angular_velocity - angular, MAX_ANGULAR_SPEED);
        }
        union.jolts.clear();
    }

    /// Makes unions of what has changed since the last flood.
    pub(super) fn flood_unions(&mut self) {
        if self.unions.stale.is_empty() {
            return;
        }
        let mut open = std::mem::take(&mut self.unions.stale);
        open.sort_unstable();
        open.dedup();
        self.unions.places.resize(self.bodies.slot_count(), UnionPlace::OUTSIDE);
        for &index in &open {
            let begins = self.bodies.get(index).is_some_and(can_join) && self.unions.place(index).union == NONE;
            if begins && self.def.long_range.enabled && self.def.long_range.union {
                let component = self.component(index);
                let is_apart = |&member: &u32| self.unions.place(member).union == NONE;
                debug_assert!(component.members.iter().all(is_apart), "a union is formed around another");
                self.form(component, None);
            }
        }
        open.clear();
        self.unions.stale = open;
        self.long_range.graph_changed();
    }

    /// What unions carry from step to step, and the bodies to flood from.
    pub(super) fn carried_unions(&self) -> (Vec<u32>, Vec<CarriedUnion>) {
        let carried = |union: &Union| CarriedUnion { lead: union.lead, motion: union.motion, before: union.before };
        let mut stale = self.unions.stale.clone();
        stale.sort_unstable();
        stale.dedup();
        (stale, self.unions.iter().map(carried).collect())
    }

    /// Makes all unions anew after a restore, with what they carried.
    pub(super) fn restart_unions(&mut self, stale: Vec<u32>, pushed: Vec<u32>, carried: &[CarriedUnion]) {
        self.unions = Unions { places: vec![UnionPlace::OUTSIDE; self.bodies.slot_count()], ..Unions::default() };
        for union in carried {
            if self.bodies.get(union.lead).is_some_and(can_join) && self.unions.place(union.lead).union == NONE {
                let component = self.component(union.lead);
                self.form(component, Some(union));
            }
        }
        (self.unions.stale, self.unions.pushed) = (stale, pushed);
    }
}

/// Centre of mass and axes of a body.
fn frame_of(body: &Body) -> Pose64 {
    Pose64 { position: body.pose().position, rotation: body.rotation.as_dquat().normalize() }
}

fn shapes_follow(body: &Body, colliders: &mut Pool<Collider, ShapeId>) {
    for &id in &body.shapes {
        if let Ok(shape) = colliders.find(id) {
            colliders[shape].follow(body);
        }
    }
}
