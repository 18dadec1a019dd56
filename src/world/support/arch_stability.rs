//! Support by thrust: stones of an arch, leaning cards, wedges, which no vertical projection shows to be held up.
//!
//! The solver's multipliers lie inside the friction cones. Where those of contacts that hold balance the weights of bodies at rest,
//! they are an equilibrium, and by the safe theorem of limit analysis (Heyman, *The stone skeleton*, Int. J. Solids Structures 2,
//! 1966) one that is found is enough: that the real one may be another does not matter. So a unit that the hulls do not support is
//! *braced* if it is quiet and, with J the impulses of a substep of length h at contacts that hold,
//!
//! ```text
//!   |Σ J + m g h| ≤ s m g h,    |Σ r × J| ≤ s m g h · reach,    the points of J not all along one line
//! ```
//!
//! and if what pushes it is ground, supported, or braced itself. Where it only stands on what is supported, projection has the say.
//! Stones lean on each other, so this is the greatest set of which that is true: all that balance to begin with, less those that
//! what is left of their pushes does not carry, until none goes. It does if it balances as it is; or if forces inside the cones of
//! the contacts that are left can, since a stone that only lost its load stands on. No circle holds itself up: over a set that
//! nothing outside it pushes, ΣJ is zero, and not its weight.
//!
//! The words are a function of the world as it is and of which contacts hold. They are worked out for what moved in this step or the
//! one before, in rounds and sums whose order is that of bodies and shapes: what fell asleep or came to be held between the two is
//! judged once more, at rest, and keeps its word, since nothing of what it hangs on changes until it wakes.

use glam::{DVec3, Vec3};

use super::SupportState;
use super::pair_view::{MIN_RISE, PairFrame};
use super::record::Record;
use crate::body::Body;
use crate::collide::pairs::WorldManifold;
use crate::dwell_time::DwellTime;
use crate::joint_graph::support::cone::{Carriers, PushPoint, carriers};
use crate::joint_graph::support::{NodeKind, SupportGraph, SupportNode};
use crate::tuning::thrust::{QUIET_TIME, UNBALANCED_SHARE};
use crate::world::World;

mod balance;

use balance::{Push, PushFace, Pusher, Sum, Unit};

/// Bodies that stand by thrust, and what it takes to tell.
#[derive(Debug, Default)]
pub(in crate::world) struct Thrust {
    /// Whether each body is braced.
    braced: Vec<bool>,
    count: u32,
    /// Bodies that moved in the last step, and those judged in this one.
    moved: Vec<u32>,
    judged: Vec<u32>,
    units: Vec<Unit>,
    /// Of each body: the place of its unit in the list plus one, or zero.
    places: Vec<u32>,
    faces: Vec<PushFace>,
    /// By unit and shapes, and as they were found.
    pushes: Vec<Push>,
    found: Vec<Push>,
    touches: Vec<PushPoint>,
}

impl Thrust {
    pub(super) fn braces(&self, body: u32) -> bool {
        self.braced.get(body as usize).is_some_and(|&braced| braced)
    }

    pub(super) fn braces_any(&self) -> bool {
        self.count > 0
    }

    pub(super) fn forget_body(&mut self, body: u32) {
        self.say(body, false);
    }

    /// Forgets everything but memory.
    pub(super) fn clear(&mut self) {
        self.braced.fill(false);
        self.count = 0;
        self.moved.clear();
    }

    /// Says whether a body is braced, and returns whether that is another word.
    fn say(&mut self, body: u32, is_braced: bool) -> bool {
        let Some(word) = self.braced.get_mut(body as usize).filter(|word| **word != is_braced) else { return false };
        *word = is_braced;
        self.count = self.count.wrapping_add_signed(if is_braced { 1 } else { -1 });
        true
    }

    fn make_room(&mut self, slots: usize) {
        self.braced.resize(slots, false);
        self.places.resize(slots, 0);
    }

    fn unit_of(&self, body: u32) -> Option<u32> {
        self.places.get(body as usize)?.checked_sub(1)
    }

    fn pusher(&self, graph: &SupportGraph, body: u32) -> Pusher {
        let Some(node) = graph.node(body) else { return Pusher::Loose };
        match node.kind {
            NodeKind::Ground => Pusher::Firm,
            NodeKind::Body if node.is_supported() => Pusher::Firm,
            NodeKind::Body => match self.unit_of(body) {
                Some(unit) => Pusher::Unit(unit),
                None if self.braces(body) => Pusher::Firm,
                None => Pusher::Loose,
            },
            NodeKind::Absent | NodeKind::Moving => Pusher::Loose,
        }
    }

    fn stands(&self, pusher: Pusher) -> bool {
        match pusher {
            Pusher::Firm => true,
            Pusher::Unit(unit) => self.units[unit as usize].stands,
            Pusher::Loose => false,
        }
    }

    /// The unit of a body, with this lowest one and made about `center` if it is not listed yet.
    fn enlist(&mut self, body: u32, root: u32, center: DVec3) -> &mut Unit {
        if self.places[root as usize] == 0 {
            self.units.push(Unit::new(root, center));
            self.places[root as usize] = self.units.len() as u32;
        }
        let place = self.places[root as usize];
        self.places[body as usize] = place;
        &mut self.units[place as usize - 1]
    }

    /// Sorts what was found by unit, and of each by shapes.
    fn sort_pushes(&mut self) {
        let Self { units, pushes, found, .. } = self;
        found.iter().for_each(|push| units[push.unit as usize].pushes.end += 1);
        let mut end = 0;
        for unit in units.iter_mut() {
            let count = unit.pushes.end;
            unit.pushes = end..end;
            end += count;
        }
        pushes.clear();
        pushes.extend_from_slice(found);
        for push in found.drain(..) {
            let place = &mut units[push.unit as usize].pushes.end;
            pushes[*place as usize] = push;
            *place += 1;
        }
        for unit in units.iter_mut() {
            let own = &mut pushes[unit.pushes.start as usize..unit.pushes.end as usize];
            own.sort_unstable_by_key(|push| (push.key, push.manifold));
        }
    }

    /// Pushes on a unit that are not lost.
    fn pushes_on(&self, unit: &Unit) -> impl Iterator<Item = (u32, &Push)> {
        unit.pushes.clone().map(|name| (name, &self.pushes[name as usize])).filter(|(_, push)| !push.is_lost)
    }
}

impl World {
    /// Works out which bodies are braced, once contacts and joints are in the graph: of all bodies, or of those that have moved.
    pub(super) fn judge_thrust(&self, state: &mut SupportState, frame: &PairFrame, all: bool) {
        let mut thrust = std::mem::take(&mut state.thrust);
        self.list_judged(&mut thrust, all);
        state.came_to_rest.sort_unstable();
        state.came_to_rest.dedup();
        if !thrust.judged.is_empty() {
            let (graph, records) = (&state.graph, &state.records);
            thrust.make_room(self.bodies.slot_count());
            self.list_units(&mut thrust, graph);
            if thrust.units.iter().any(|unit| unit.stands) {
                if all {
                    self.list_all_pushes(&mut thrust, (graph, frame), records);
                } else {
                    let is_active = |slot: &u32| self.collision.pairs.get(*slot).is_active();
                    let (pressed, asleep) = (state.pressed.iter().copied(), state.came_to_rest.iter().copied());
                    let slots = pressed.filter(is_active).chain(asleep.filter(|slot| !is_active(slot)));
                    self.list_pushes(&mut thrust, (graph, frame), records, slots);
                }
                self.keep_the_balanced(&mut thrust);
                self.drop_the_unheld(&mut thrust);
            }
            for number in 0..thrust.judged.len() {
                let index = thrust.judged[number];
                let is_braced = thrust.unit_of(index).is_some_and(|unit| thrust.units[unit as usize].stands);
                if thrust.say(index, is_braced) {
                    state.watched.push((index, DwellTime::NONE));
                }
            }
            let Thrust { judged, units, places, faces, .. } = &mut thrust;
            judged.iter().for_each(|&index| places[index as usize] = 0);
            units.drain(..).for_each(|unit| places[unit.root as usize] = 0);
            faces.clear();
        }
        // Only of interest where nothing stands on a base.
        let leans = || self.collision.pairs.active().iter().any(|&(_, slot)| self.leans_on_a_base(slot));
        state.rest.leans = thrust.braces_any() || (!state.graph.has_bases() && leans());
        state.thrust = thrust;
    }

    /// Whether just one of the bodies of a pair needs no support.
    fn leans_on_a_base(&self, slot: u32) -> bool {
        let pair = self.collision.pairs.get(slot);
        let (a, b) = pair.key.shapes();
        let is_dynamic = |shape: u32| self.bodies[self.colliders[shape].body].is_dynamic();
        pair.has_points() && is_dynamic(a) != is_dynamic(b)
    }

    /// Lists, by number, what is to be judged: all bodies, or what moved in this step or the one before.
    fn list_judged(&self, thrust: &mut Thrust, all: bool) {
        let Thrust { moved, judged, .. } = thrust;
        judged.clear();
        judged.append(moved);
        if self.report.counts.bodies_held as usize != self.movers.slots.len() || all {
            let moves = |&index: &u32| self.bodies.get(index).is_some_and(|body| body.is_mover() && !body.held);
            moved.extend(self.movers.slots.iter().copied().filter(moves));
        }
        if all {
            judged.clear();
            judged.extend(self.bodies.iter().map(|(index, _)| index));
        } else {
            judged.extend_from_slice(moved);
            judged.sort_unstable();
            judged.dedup();
        }
    }

    /// Lists the units of what is judged and has no support by hulls and joints; those that are not quiet do not stand.
    fn list_units(&self, thrust: &mut Thrust, graph: &SupportGraph) {
        let judged = std::mem::take(&mut thrust.judged);
        for &index in &judged {
            let Some(node) = graph.node(index).filter(|node| !node.is_known()) else { continue };
            let body = &self.bodies[index];
            let reach = self.reach_of(body);
            let speed = body.linear_velocity.length() + body.angular_velocity.length() * reach;
            let unit = thrust.enlist(index, node.unit, self.bodies[node.unit].center);
            unit.stands &= speed <= QUIET_TIME * self.def.gravity.length();
            self.add_weight(unit, body, reach);
        }
        thrust.judged = judged;
    }

    fn add_weight(&self, unit: &mut Unit, body: &Body, reach: f32) {
        let mass = body.mass.as_ref().map_or(0.0, |mass| mass.mass);
        let weight = self.def.gravity * (body.settings.gravity_scale * mass * self.last.substep);
        let lever = (body.center - unit.center).as_vec3();
        unit.reach = unit.reach.max(lever.length() + reach);
        unit.weight += weight;
        unit.moment += lever.cross(weight);
    }

    /// How far a body reaches from its centre of mass (m).
    pub(in crate::world) fn reach_of(&self, body: &Body) -> f32 {
        let shapes = body.shapes.iter().filter_map(|&id| self.colliders.find(id).ok());
        shapes.map(|shape| self.colliders[shape].reach).fold(0.0, f32::max)
    }

    /// Which of the braced bodies would be so in another graph, in which bodies have been taken away.
    pub(super) fn braced_in(&self, graph: &SupportGraph, state: &SupportState) -> Vec<bool> {
        let mut thrust = Thrust::default();
        thrust.make_room(self.bodies.slot_count());
        for (index, body) in self.bodies.iter().filter(|&(index, _)| state.thrust.braces(index)) {
            if let Some(node) = graph.node(index).filter(|node| !node.is_known()) {
                self.add_weight(thrust.enlist(index, node.unit, self.bodies[node.unit].center), body, self.reach_of(body));
            }
        }
        if let Some(frame) = &state.frame {
            self.list_all_pushes(&mut thrust, (graph, frame), &state.records);
            self.drop_the_unheld(&mut thrust);
        }
        let is_braced = |index: u32| thrust.unit_of(index).is_some_and(|unit| thrust.units[unit as usize].stands);
        (0..self.bodies.slot_count() as u32).map(is_braced).collect()
    }

    fn list_all_pushes(&self, thrust: &mut Thrust, place: (&SupportGraph, &PairFrame), records: &[Record]) {
        let listed = self.collision.pairs.listed();
        let active = listed.iter().map(|&(_, slot)| slot);
        self.list_pushes(thrust, place, records, active.chain(self.islands.sleeping.pairs()));
    }

    /// Lists what pushes the units that may stand, by unit and shapes.
    fn list_pushes(
        &self,
        thrust: &mut Thrust,
        (graph, frame): (&SupportGraph, &PairFrame),
        records: &[Record],
        slots: impl Iterator<Item = u32>,
    ) {
        let rests = |body: u32| self.bodies[body].held || !self.bodies[body].is_mover();
        for slot in slots {
            let Some(record) = records.get(slot as usize) else { continue };
            let ends = record.bodies.map(|body| thrust.unit_of(body).filter(|&unit| thrust.units[unit as usize].stands));
            let pair = self.collision.pairs.get(slot);
            if ends[0] == ends[1] || record.key != Some(pair.key) {
                continue;
            }
            let rests = record.bodies.into_iter().all(rests);
            let (a, b) = pair.key.shapes();
            let (a, b) = (&self.colliders[a], &self.colliders[b]);
            for (number, (manifold, seen)) in pair.manifolds.iter().zip(&record.manifolds).enumerate() {
                if !(rests || seen.holds) || manifold.impulses.normal.iter().all(|&lambda| lambda <= 0.0) {
                    continue;
                }
                let world = WorldManifold::new(&manifold, (a, &self.bodies[a.body]), (b, &self.bodies[b.body]));
                let is_steep = world.normal.dot(frame.up).abs() < MIN_RISE;
                for (side, unit) in ends.into_iter().enumerate().filter_map(|(side, unit)| Some((side, unit?))) {
                    let from = record.bodies[1 - side];
                    thrust.found.push(Push {
                        unit,
                        key: pair.key,
                        manifold: number as u32,
                        face: thrust.faces.len() as u32,
                        from: thrust.pusher(graph, from),
                        leans: is_steep || !graph.node(from).is_some_and(SupportNode::is_known),
                        is_on_b: side == 1,
                        is_lost: false,
                    });
                }
                thrust.faces.push(PushFace {
                    world,
                    count: manifold.points.len(),
                    impulses: *manifold.impulses,
                    friction: a.surface_with(b).friction,
                    bodies: [a.body, b.body],
                });
            }
        }
        thrust.sort_pushes();
    }

    /// Leaves only units that all their pushes balance.
    fn keep_the_balanced(&self, thrust: &mut Thrust) {
        for number in 0..thrust.units.len() {
            let unit = &thrust.units[number];
            if unit.stands {
                let sum = self.sum_up(thrust, unit);
                let stands = sum.leans && sum.balances(unit) && sum.is_spread(unit.reach);
                thrust.units[number].stands = stands;
            }
        }
    }

    /// Takes out what cannot be carried by the pushes of those that stand, until all that is left can.
    fn drop_the_unheld(&self, thrust: &mut Thrust) {
        loop {
            let mut any = false;
            for number in 0..thrust.units.len() {
                if !thrust.units[number].stands {
                    continue;
                }
                let mut lost = false;
                for name in thrust.units[number].pushes.clone() {
                    let push = &thrust.pushes[name as usize];
                    if !push.is_lost && !thrust.stands(push.from) {
                        thrust.pushes[name as usize].is_lost = true;
                        lost = true;
                    }
                }
                thrust.units[number].lost_a_push = lost;
                any |= lost;
            }
            if !any {
                return;
            }
            for number in 0..thrust.units.len() {
                if std::mem::take(&mut thrust.units[number].lost_a_push) {
                    let unit = &thrust.units[number];
                    let sum = self.sum_up(thrust, unit);
                    let may_stand = sum.leans && sum.is_spread(unit.reach);
                    let stands = may_stand && (sum.balances(unit) || self.cones_carry(thrust, number));
                    thrust.units[number].stands = stands;
                }
            }
        }
    }

    /// The pushes that a unit has left.
    fn sum_up(&self, thrust: &Thrust, unit: &Unit) -> Sum {
        let mut sum = Sum::default();
        for (_, push) in thrust.pushes_on(unit) {
            let face = &thrust.faces[push.face as usize];
            let (levers, shift) = (face.levers(push.is_on_b), self.shift(face, push, unit));
            let sign = if push.is_on_b { 1.0 } else { -1.0 };
            let (force, moment) = face.impulses.wrench(face.world.normal, levers);
            let (force, moment) = (force * sign, moment * sign);
            let points = levers.iter().zip(face.impulses.normal).map(|(&lever, lambda)| (lever + shift, lambda));
            sum.add(force, moment + shift.cross(force), points);
            sum.leans |= push.leans;
        }
        sum
    }

    /// Whether forces inside the cones of the contacts that a unit has left can carry it.
    fn cones_carry(&self, thrust: &mut Thrust, number: usize) -> bool {
        let are_left = |carriers: Carriers| carriers.into_iter().flatten().all(|push| !thrust.pushes[push as usize].is_lost);
        if thrust.units[number].carriers.is_some_and(are_left) {
            return true;
        }
        let mut touches = std::mem::take(&mut thrust.touches);
        touches.clear();
        let unit = &thrust.units[number];
        for (name, push) in thrust.pushes_on(unit) {
            let face = &thrust.faces[push.face as usize];
            let shift = self.shift(face, push, unit);
            let normal = if push.is_on_b { face.world.normal } else { -face.world.normal };
            let touch = |&lever: &Vec3| PushPoint { lever: lever + shift, normal, friction: face.friction, push: name };
            touches.extend(face.levers(push.is_on_b).iter().map(touch));
        }
        let carriers = carriers(&touches, unit.weight, unit.reach, UNBALANCED_SHARE);
        thrust.units[number].carriers = carriers;
        thrust.touches = touches;
        carriers.is_some()
    }

    /// From the centre of a unit to that of its body which a push is on (m).
    fn shift(&self, face: &PushFace, push: &Push, unit: &Unit) -> Vec3 {
        (self.bodies[face.bodies[usize::from(push.is_on_b)]].center - unit.center).as_vec3()
    }
}
