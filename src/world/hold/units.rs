//! Holds articulations at rest among others that still move.
//!
//! A heap of ragdolls comes to rest but for a head that spins about its neck, or an arm that settles: it is one island, and none of it could
//! sleep or be held. Of a *unit*, the free bodies that joints connect, those that lie still are held by themselves, with what they touch and
//! what hangs on them solved as if they were static.
//!
//! That is what the solver would find as long as nothing acts on them but what did as they lay still: contacts and joints take up what is
//! asked of them, within their limits, and nothing moves. So a unit keeps what *loads* each of its bodies from outside, the sum of the forces
//! of contacts and joints with other bodies that are free, and of their moments:
//!
//! * **Engaged** once all of its bodies have been calm for [`CALM_TIME`], at [`UNIT_CALM_SHARE`] of what gravity adds in a step, but for
//!   ends that hang on one joint each, fewer than half of them; it touches something, nothing overlaps by more than [`OVERLAP_SHARE`], and its
//!   joints are passive: rigid, without motors and friction, none of which can break or bears more than its limit.
//! * **Released** whole, before the step is solved, by whatever releases an island, by an end that touches more than one thing, by a body
//!   beside it that brings more momentum than [`BLOW_SHARE`] of what gravity gives the unit in a step, and once the load of a body is
//!   another one by [`LOAD_SHARE`] of what it bears and weighs. It is held again where it is still calm [`AGAIN_TIME`] later, under what
//!   loads it then.

use glam::Vec3;

use super::Hold;
use crate::body::Body;
use crate::collide::pairs::WorldManifold;
use crate::dwell_time::DwellTime;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::settings::Solver;
use crate::snapshot::carried::{HeldBody, HeldUnit};
pub(super) use crate::tuning::units::UNIT_CALM_SHARE;
use crate::tuning::units::{AGAIN_TIME, BLOW_SHARE, CALM_TIME, LOAD_SHARE, LOOK_TIME, OVERLAP_SHARE};
use crate::world::body_shape_table::Marks;
use crate::world::islands::{JointHead, NO_BODY};
use crate::world::touching_pairs::TouchingPair;
use crate::world::{Collision, Islands, LastStep, World};

/// Bodies that a unit may have.
const MAX_BODIES: usize = 64;

/// The units of a world that are held, and buffers.
#[derive(Debug, Default)]
pub(in crate::world) struct Units {
    pub held: Vec<HeldUnit>,
    /// Bodies that are held with a unit in this step.
    pub members: Marks,
    /// Of each body of a unit that is looked at: which unit, and its number there.
    places: Vec<(u32, u32)>,
    looks: Vec<UnitCheck>,
    /// Manifolds of each body.
    manifolds: Vec<u16>,
    seen: Marks,
    component: Vec<u32>,
    ends: Vec<u32>,
    /// Net forces of contacts of what is held, as the step began (N).
    forces: Vec<Vec3>,
}

/// What a look at a unit finds.
#[derive(Debug, Default)]
struct UnitCheck {
    bodies: Vec<Borne>,
    /// Momentum of a body beside it that strikes it (N·s).
    blow: f32,
    is_new: bool,
    touches: bool,
    is_disturbed: bool,
}

/// What a body of a unit bears.
#[derive(Debug)]
struct Borne {
    /// Force (N) and moment about the centre of mass (N·m) of what is beside the unit.
    load: [Vec3; 2],
    /// What it weighs (N), and how far its shapes reach (m).
    weight: f32,
    reach: f32,
}

impl World {
    /// Says which units are held in this step.
    pub(super) fn hold_units(&mut self, Hold { units, let_go, .. }: &mut Hold) {
        units.members.begin(self.bodies.slot_count());
        *let_go |= self.drop_changed_units(units);
        let kept = units.held.len();
        // What sweeps and soft bounds leave of errors goes on being mended where nothing moves fast; thrust is passed on by all that moves or
        // has just come to rest.
        let is_exact = self.def.solver != Solver::GaussSeidel && self.long_range.soft.is_empty();
        let may_hold = self.def.hold && is_exact && !self.def.support_by_thrust;
        if may_hold {
            self.find_units(units);
        }
        if units.held.is_empty() {
            return;
        }
        self.look_at_units(units, kept);
        let Units { held, looks, members, forces, .. } = units;
        let mut looks = looks.iter();
        let mut are_new = false;
        held.retain(|unit| {
            let Some(look) = looks.next() else { return false };
            let stays = may_hold && look.lets_hold(unit);
            for &HeldBody { body, .. } in &unit.bodies {
                if stays {
                    members.set(body);
                }
                let was_held = self.bodies[body].held;
                // Of what goes on being held nothing changes.
                if stays && was_held {
                    continue;
                }
                *let_go |= was_held;
                self.islands.summaries.note_held(body, stays);
                let record = &mut self.bodies[body];
                record.held = stays;
                if stays {
                    are_new = true;
                    (record.linear_velocity, record.angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
                    record.history.forget_lead();
                } else if look.is_disturbed {
                    record.times.calm_for = DwellTime::NONE;
                    if was_held {
                        record.times.smooth_for = DwellTime::NONE;
                    }
                } else {
                    record.times.calm_for = DwellTime::short_of(CALM_TIME, AGAIN_TIME);
                }
            }
            stays
        });
        // To what is not held they are as if they did not move.
        forces.clear();
        for &HeldBody { body, .. } in held.iter().flat_map(|unit| &unit.bodies) {
            self.collision.index.free.unset(body);
            self.islands.groups.leave_out(body);
            forces.push(self.collision.index.contact_force(body));
        }
        if are_new {
            self.judge_what_came_to_rest(members);
        }
        self.report.counts.bodies_held += held.iter().map(|unit| unit.bodies.len() as u32).sum::<u32>();
    }

    /// Releases each unit whole of which a body has been released, is in no island any more or has joined a union; returns whether it
    /// has released any body.
    fn drop_changed_units(&mut self, units: &mut Units) -> bool {
        let Self { bodies, islands: Islands { summaries, .. }, collision: Collision { index, .. }, unions, .. } = self;
        let mut some_are = false;
        units.held.retain(|unit| {
            let goes_on = |body: u32| index.free.has(body) && bodies[body].held && unions.moving(body).is_none();
            let is_whole = unit.bodies.iter().all(|held| goes_on(held.body));
            for held in unit.bodies.iter().filter(|_| !is_whole) {
                if let Some(body) = bodies.get_mut(held.body).filter(|body| body.held) {
                    (body.held, body.times.calm_for, body.times.smooth_for) = (false, DwellTime::NONE, DwellTime::NONE);
                    summaries.note_held(held.body, false);
                    some_are = true;
                }
            }
            is_whole
        });
        some_are
    }

    /// Adds the units that have become calm to those that are held.
    fn find_units(&mut self, units: &mut Units) {
        let Self {
            islands: Islands { groups, summaries, .. },
            bodies,
            joints,
            unions,
            collision: Collision { index, .. },
            last: LastStep { dt: last_dt, .. },
            ..
        } = self;
        let Units { held, seen, component, ends, .. } = units;
        seen.begin(bodies.slot_count());
        held.iter().flat_map(|unit| &unit.bodies).for_each(|held| seen.set(held.body));
        let is_calm = |body: u32| summaries.of(body).is_calm_in_unit() && !summaries.of(body).is_held();
        // A walk starts from each of its bodies, at a time of its own, and not in every step.
        let is_due = |body: u32| bodies[body].times.calm_for.completes(LOOK_TIME, *last_dt);
        for &first in &groups.bound {
            if seen.has(first) || !is_calm(first) || !is_due(first) {
                continue;
            }
            component.clear();
            ends.clear();
            component.push(first);
            seen.set(first);
            let mut may_be_held = true;
            let mut next = 0;
            while let Some(&body) = component.get(next) {
                next += 1;
                let own = &bodies[body].joints;
                if !is_calm(body) {
                    may_be_held &= own.len() == 1;
                    ends.push(body);
                }
                may_be_held = may_be_held && component.len() <= MAX_BODIES && unions.moving(body).is_none();
                for &id in own {
                    let slot = joints.slot_of(id);
                    let head = &groups.joint_heads[slot as usize];
                    may_be_held = may_be_held && is_passive(head, joints, slot);
                    for other in head.bodies {
                        if other == NO_BODY || !index.free.has(other) {
                            may_be_held = false;
                        } else if !seen.has(other) {
                            seen.set(other);
                            component.push(other);
                        } else if summaries.of(other).is_held() {
                            // Held with what is left of the unit: this is one of its ends.
                            may_be_held = false;
                        }
                    }
                }
            }
            if may_be_held && 2 * ends.len() < component.len() {
                component.retain(|body| !ends.contains(body));
                component.sort_unstable();
                let bodies = component.iter().map(|&body| HeldBody { body, load: [Vec3::ZERO; 2] });
                held.push(HeldUnit { bodies: bodies.collect() });
            }
        }
    }

    /// Looks at what loads units; those from number `kept` on are new.
    fn look_at_units(&self, units: &mut Units, kept: usize) {
        let Self { bodies, colliders, collision: Collision { index, .. }, def, last: LastStep { dt: last_dt, .. }, .. } = self;
        let Units { held, places, looks, manifolds, seen, .. } = units;
        seen.begin(bodies.slot_count());
        places.resize(bodies.slot_count(), (0, 0));
        manifolds.clear();
        manifolds.resize(bodies.slot_count(), 0);
        looks.resize_with(looks.len().max(held.len()), UnitCheck::default);
        let gravity = def.gravity.length();
        for ((number, unit), look) in held.iter().enumerate().zip(&mut *looks) {
            let mut mass = 0.0;
            look.bodies.clear();
            for (local, held) in unit.bodies.iter().enumerate() {
                seen.set(held.body);
                places[held.body as usize] = (number as u32, local as u32);
                let body = &bodies[held.body];
                let own = body.mass.as_ref().map_or(0.0, |mass| mass.mass);
                mass += own;
                let shapes = body.shapes.iter().filter_map(|&id| colliders.find(id).ok());
                let reach = shapes.map(|shape| colliders[shape].reach).fold(0.0, f32::max);
                look.bodies.push(Borne { load: [Vec3::ZERO; 2], weight: own * gravity, reach });
            }
            look.blow = BLOW_SHARE * mass * gravity * last_dt;
            (look.is_new, look.touches, look.is_disturbed) = (number >= kept, false, false);
        }
        let place_of = |body: u32| seen.has(body).then(|| places[body as usize]);
        self.add_contacts(looks, manifolds, place_of);
        for (number, (unit, look)) in held.iter().zip(&mut *looks).enumerate() {
            for (local, held) in unit.bodies.iter().enumerate() {
                let is_beside =
                    |other: u32| index.free.has(other) && place_of(other).is_none_or(|(unit, _)| unit != number as u32);
                self.add_joints(look, manifolds, (held.body, local), is_beside);
            }
            look.is_disturbed |= !look.touches;
        }
        for (unit, look) in held.iter_mut().zip(&*looks).skip(kept) {
            unit.bodies.iter_mut().zip(&look.bodies).for_each(|(held, borne)| held.load = borne.load);
        }
    }

    /// Adds the contacts of units to what is found of them, and counts those of all bodies; a body is told its unit, and its number there.
    fn add_contacts(&self, looks: &mut [UnitCheck], manifolds: &mut [u16], place_of: impl Fn(u32) -> Option<(u32, u32)>) {
        let Self {
            colliders,
            collision: Collision { touches, pairs, index, .. },
            last: LastStep { substep: last_substep, .. },
            ..
        } = self;
        let per_substep = if *last_substep > 0.0 { 1.0 / last_substep } else { 0.0 };
        for touch in touches.touching() {
            for body in touch.bodies {
                let own = &mut manifolds[body as usize];
                *own = own.saturating_add(touch.manifolds);
            }
            let places = touch.bodies.map(&place_of);
            if places == [None; 2] {
                continue;
            }
            let pair = pairs.get(touch.slot);
            let shapes = <[u32; 2]>::from(pair.key.shapes());
            let frames = shapes.map(|shape| index.collider_state(shape).frame());
            let deepest = -OVERLAP_SHARE * index.least_extent(pair.key);
            for side in 0..2 {
                let (Some((unit, local)), other) = (places[side], touch.bodies[1 - side]) else { continue };
                let look = &mut looks[unit as usize];
                look.touches = true;
                let mut points = pair.manifolds.iter().flat_map(|manifold| manifold.points);
                look.is_disturbed |= look.is_new && points.any(|point| point.separation < deepest);
                if !index.free.has(other) || places[1 - side].is_some_and(|(of_other, _)| of_other == unit) {
                    continue;
                }
                look.is_disturbed |= self.momentum(other, colliders[shapes[1 - side]].reach) > look.blow;
                for manifold in pair.manifolds.iter() {
                    let world = WorldManifold::of(&manifold, frames[0], frames[1]);
                    let levers = &[world.lever_a, world.lever_b][side][..manifold.points.len()];
                    let (impulse, moment) = manifold.impulses.wrench(world.normal, levers);
                    let sign = if side == 0 { -per_substep } else { per_substep };
                    look.add(local as usize, impulse * sign, moment * sign);
                }
            }
        }
    }

    /// Adds the joints of a body of a unit to bodies that are beside it.
    fn add_joints(&self, look: &mut UnitCheck, manifolds: &[u16], (index, local): (u32, usize), is_beside: impl Fn(u32) -> bool) {
        let Self { bodies, joints, islands: Islands { groups, .. }, .. } = self;
        let body = &bodies[index];
        for &id in &body.joints {
            let slot = joints.slot_of(id);
            let ends = groups.joint_heads[slot as usize].bodies;
            let side = usize::from(ends[1] == index);
            let other = ends[1 - side];
            if other == NO_BODY || !is_beside(other) {
                continue;
            }
            let joint = &joints[slot];
            let lever = (bodies[other].center - body.center).as_vec3();
            // What is wedged between its joint and two things needs all three of them to yield.
            let is_wedged = manifolds[other as usize] > 1;
            look.is_disturbed |= is_wedged || self.momentum(other, lever.length()) > look.blow;
            let sign = if side == 1 { 1.0 } else { -1.0 };
            let (force, torque) = (joint.force * sign, joint.torque * sign);
            look.add(local, force, torque + lever_of(joint, side, body).cross(force));
        }
    }

    /// Momentum with which a body of this reach (m), and what the host pushes it with, may strike another (N·s).
    fn momentum(&self, index: u32, reach: f32) -> f32 {
        let body = &self.bodies[index];
        if body.held {
            return 0.0;
        }
        let mass = match self.unions.moving(index) {
            Some(union) => union.mass.mass,
            None => body.mass.as_ref().map_or(0.0, |mass| mass.mass),
        };
        let pushed = body.force.length() * self.last.dt;
        mass * (body.linear_velocity.length() + body.angular_velocity.length() * reach) + pushed
    }

    /// Has the support analysis look once more at the contacts of units through which nothing moves.
    fn judge_what_came_to_rest(&mut self, members: &Marks) {
        let Self { support: Some(support), collision: Collision { touches, .. }, bodies, .. } = self else { return };
        let rests = |touch: &&TouchingPair| {
            touch.bodies.iter().any(|&body| members.has(body)) && !touch.bodies.iter().any(|&body| bodies[body].is_solved())
        };
        support.came_to_rest.extend(touches.touching().filter(rests).map(|touch| touch.slot));
    }

    /// Contacts of what is held have the force that they had as the step began: those beside it would be added to it again.
    pub(in crate::world) fn keep_contact_forces(&mut self) {
        let Self { islands: Islands { hold: Hold { units, .. }, .. }, collision: Collision { index, .. }, .. } = self;
        for (held, &force) in units.held.iter().flat_map(|unit| &unit.bodies).zip(&units.forces) {
            index.set_contact_force(held.body, force);
        }
    }
}

/// From a body's centre of mass to where a joint holds it (m).
fn lever_of(joint: &Joint, side: usize, body: &Body) -> Vec3 {
    let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
    body.rotation * (frame.position.as_vec3() - body.local_center)
}

impl UnitCheck {
    fn add(&mut self, local: usize, force: Vec3, moment: Vec3) {
        let [sum, moments] = &mut self.bodies[local].load;
        *sum += force;
        *moments += moment;
    }

    /// Whether the unit may be held: nothing has struck it, and it is loaded as it was.
    fn lets_hold(&self, unit: &HeldUnit) -> bool {
        // Not-a-number is another load.
        let is_same = |(held, borne): (&HeldBody, &Borne)| {
            let size = |[force, moment]: [Vec3; 2]| force.length() * borne.reach + moment.length();
            let change = size([borne.load[0] - held.load[0], borne.load[1] - held.load[1]]);
            change <= LOAD_SHARE * (size(held.load) + borne.weight * borne.reach)
        };
        !self.is_disturbed && unit.bodies.iter().zip(&self.bodies).all(is_same)
    }
}

/// Whether a joint does nothing by itself, and stays.
fn is_passive(head: &JointHead, joints: &Pool<Joint, JointId>, slot: u32) -> bool {
    let traits = &head.traits;
    !traits.has_motor
        && !traits.has_friction
        && traits.gives_by_motors_alone
        && traits.solver != Solver::GaussSeidel
        && joints[slot].strain.is_none()
        && !joints[slot].is_overloaded()
}
