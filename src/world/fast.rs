//! Stage that stops bodies flagged fast at what they would have passed through.
//!
//! A step moves bodies from where they were to where the solver has put them. Those flagged fast are swept along that way, against all
//! that is near it and moves along its own way at the same time. Touches are taken in the order in which they happen: what one has
//! stopped does not come as far as the next, and nothing meets it there. All are found before anything is put back.
//!
//! Two fast bodies that touch both stop there. What touches another body is carried on by that to the end of the step, as if it lay on it.
//! Velocities stay what they are; the contact of the next step answers to them.
//!
//! What joints connect stops as one: where a member of an articulation is stopped, all of it goes back along its path by the same
//! share, so that no part is torn from the rest. Members do not stop one another.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::World;
use super::body_shape_table::Marks;
use crate::collide::broad::{FEW_SHAPES, LARGE_GROUP};
use crate::collide::sweep::{self, BodyPath, BodyPose, ImpactBuffer};
use crate::joint_graph::union::UnionMotion;

/// A body that may have to be stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Path {
    /// Batch, and articulation in it; a body without joints is one by itself.
    pub group: (u32, u32),
    pub body: u32,
}

/// Group of a body that is not swept.
const NO_GROUP: u32 = u32::MAX;

/// A body that the step moves.
#[derive(Debug, Clone, Copy)]
struct Mover {
    /// Where it was when the step began.
    start: BodyPose,
    /// Number of its group.
    group: u32,
}

/// Bodies that stop as one.
#[derive(Debug, Clone, Copy)]
struct Group {
    /// Range of paths.
    first: usize,
    end: usize,
    stop: Option<Stop>,
}

/// Where a group stops.
#[derive(Debug, Clone, Copy)]
struct Stop {
    /// Share of the way.
    time: f32,
    /// Where what it has met was then, and is at the end of the step, if that goes on.
    carried: Option<[BodyPose; 2]>,
}

impl Stop {
    /// Where a body ends that stops here.
    fn carry(&self, at: BodyPose) -> BodyPose {
        let Some([from, to]) = self.carried else { return at };
        let turn = to.rotation * from.rotation.conjugate();
        let center = to.center + turn.as_dquat() * (at.center - from.center);
        BodyPose { center, rotation: (turn * at.rotation).normalize() }
    }
}

/// A touch to come, in the order in which touches are taken: share of the step as the bits of a number that is not negative, swept shape,
/// the other, and which of the two were stopped when it was found.
type TimeOfImpact = (u32, u32, u32, [bool; 2]);

/// Buffers of the stage.
#[derive(Debug, Default)]
pub(super) struct Sweeps {
    pub paths: Vec<Path>,
    /// By slot, those that are marked.
    movers: Vec<Mover>,
    moved: Marks,
    groups: Vec<Group>,
    /// Swept shapes, each with another that may be in its way.
    near: Vec<(u32, u32)>,
    /// Places in that list by the groups of both.
    near_group: Vec<(u32, u32)>,
    /// Swept shapes that have left the box in which others look for them, with the box of their way.
    strays: Vec<(u32, Aabb)>,
    around: Vec<u32>,
    /// Swept shapes of a group, with the boxes of their ways.
    boxes: Vec<(u32, Aabb)>,
    touches: BinaryHeap<Reverse<TimeOfImpact>>,
    parts: ImpactBuffer,
}

impl Sweeps {
    fn group_of(&self, body: u32) -> u32 {
        if self.moved.has(body) { self.movers[body as usize].group } else { NO_GROUP }
    }

    fn stop_of(&self, body: u32) -> Option<Stop> {
        self.groups.get(self.group_of(body) as usize)?.stop
    }

    /// Cuts the list of paths into groups.
    fn form_groups(&mut self) {
        self.paths.sort_unstable();
        self.groups.clear();
        for (place, path) in self.paths.iter().enumerate() {
            if place == 0 || self.paths[place - 1].group != path.group {
                self.groups.push(Group { first: place, end: place, stop: None });
            }
            let number = self.groups.len() - 1;
            self.groups[number].end = place + 1;
            self.movers[path.body as usize].group = number as u32;
        }
    }
}

impl World {
    /// Takes note of where bodies are that the step has not moved yet, if any may have to be stopped.
    pub(super) fn note_starts(&mut self) {
        let Self { summaries, movers, bodies, scratch, .. } = self;
        let sweeps = &mut scratch.sweeps;
        sweeps.paths.clear();
        if !summaries.some_are_fast() {
            return;
        }
        sweeps.moved.begin(bodies.slot_count());
        let nowhere = Mover { start: BodyPose::ORIGIN, group: NO_GROUP };
        sweeps.movers.resize(bodies.slot_count(), nowhere);
        for &index in &*movers {
            let body = &bodies[index];
            let start = BodyPose { center: body.center, rotation: body.rotation };
            sweeps.movers[index as usize] = Mover { start, group: NO_GROUP };
            sweeps.moved.set(index);
        }
    }

    /// Sweeps bodies flagged fast along their ways through the step.
    pub(super) fn stop_fast_bodies(&mut self) {
        if self.scratch.sweeps.paths.is_empty() {
            return;
        }
        let mut sweeps = std::mem::take(&mut self.scratch.sweeps);
        sweeps.form_groups();
        self.find_near_paths(&mut sweeps);
        sweeps.touches.clear();
        for place in 0..sweeps.near.len() {
            self.find_touch(&mut sweeps, place);
        }
        while let Some(Reverse((time, swept, other, stopped))) = sweeps.touches.pop() {
            let bodies = [swept, other].map(|shape| self.colliders[shape].body);
            if bodies.map(|body| sweeps.stop_of(body).is_some()) == stopped {
                self.stop_at(&mut sweeps, f32::from_bits(time), bodies);
            }
        }
        for group in &sweeps.groups {
            if let Some(stop) = &group.stop {
                self.put_back(&sweeps.paths[group.first..group.end], stop, &sweeps);
            }
        }
        self.scratch.sweeps = sweeps;
    }

    /// Way of a body through the step, as far as it goes by what is known so far.
    fn path_of(&self, sweeps: &Sweeps, index: u32) -> BodyPath {
        let body = &self.bodies[index];
        let end = BodyPose { center: body.center, rotation: body.rotation };
        if !sweeps.moved.has(index) {
            return BodyPath::straight(end, end);
        }
        let start = sweeps.movers[index as usize].start;
        match sweeps.stop_of(index) {
            None => BodyPath::straight(start, end),
            Some(stop) => {
                let turn = start.lerp(&end, stop.time);
                BodyPath { start, until: stop.time, turn, end: stop.carry(turn) }
            }
        }
    }

    /// Lists swept shapes with what may be in their way.
    fn find_near_paths(&self, sweeps: &mut Sweeps) {
        let mut near = std::mem::take(&mut sweeps.near);
        let mut strays = std::mem::take(&mut sweeps.strays);
        let (mut around, mut boxes) = (std::mem::take(&mut sweeps.around), std::mem::take(&mut sweeps.boxes));
        near.clear();
        strays.clear();
        let is_swept = |body: u32| sweeps.group_of(body) != NO_GROUP && self.bodies[body].fast;
        let pair_of = |shape: u32, other: u32| {
            let (a, b) = (&self.colliders[shape], &self.colliders[other]);
            let may_meet = sweeps.group_of(a.body) != sweeps.group_of(b.body) && self.may_meet(a, b);
            may_meet.then(|| if other < shape && is_swept(b.body) { (other, shape) } else { (shape, other) })
        };
        for group in &sweeps.groups {
            let members = &sweeps.paths[group.first..group.end];
            boxes.clear();
            self.list_swept_shapes(sweeps, members, &mut boxes);
            let few = self.find_around(sweeps, members, &boxes, &mut around).then_some(&around[..]);
            for &(shape, bounds) in &boxes {
                match few {
                    Some(few) => {
                        let meets = |other: u32| self.colliders[other].fat_box.is_some_and(|kept| kept.intersects(&bounds));
                        near.extend(few.iter().filter(|&&other| meets(other)).filter_map(|&other| pair_of(shape, other)));
                    }
                    None => near.extend(self.broad.overlapping(&bounds).filter_map(|other| pair_of(shape, other))),
                }
                if self.colliders[shape].fat_box.is_none_or(|kept| !kept.contains(&bounds)) {
                    strays.push((shape, bounds));
                }
            }
        }
        strays.sort_unstable_by(|(a, bounds_a), (b, bounds_b)| bounds_a.mins.x.total_cmp(&bounds_b.mins.x).then(a.cmp(b)));
        for (place, (shape, bounds)) in strays.iter().enumerate() {
            let behind = strays[place + 1..].iter().take_while(|(_, other)| other.mins.x <= bounds.maxs.x);
            near.extend(behind.filter(|(_, other)| other.intersects(bounds)).filter_map(|&(other, _)| pair_of(*shape, other)));
        }
        near.sort_unstable();
        near.dedup();
        sweeps.near_group.clear();
        for (place, &(swept, other)) in near.iter().enumerate() {
            let groups = [swept, other].map(|shape| sweeps.group_of(self.colliders[shape].body));
            let swept_groups = groups.into_iter().filter(|&group| group != NO_GROUP);
            sweeps.near_group.extend(swept_groups.map(|group| (group, place as u32)));
        }
        sweeps.near_group.sort_unstable();
        (sweeps.near, sweeps.strays, sweeps.around, sweeps.boxes) = (near, strays, around, boxes);
    }

    /// Lists the shapes of a group that are swept, with the boxes of their ways.
    fn list_swept_shapes(&self, sweeps: &Sweeps, members: &[Path], boxes: &mut Vec<(u32, Aabb)>) {
        for index in members.iter().map(|path| path.body) {
            let (body, start) = (&self.bodies[index], &sweeps.movers[index as usize].start);
            if body.fast {
                let shapes = body.shapes.iter().filter_map(|&id| self.colliders.find(id).ok());
                boxes.extend(shapes.map(|shape| (shape, sweep::path_box(&self.colliders[shape], body, start))));
            }
        }
    }

    /// Finds the shapes that may be in the way of a large group; false if it is small, or there are many.
    fn find_around(&self, sweeps: &Sweeps, members: &[Path], boxes: &[(u32, Aabb)], around: &mut Vec<u32>) -> bool {
        around.clear();
        if members.len() < LARGE_GROUP {
            return false;
        }
        let own = sweeps.group_of(members[0].body);
        if let Some(whole) = boxes.iter().map(|&(_, bounds)| bounds).reduce(|whole, more| whole.merged(&more)) {
            let is_other = |&shape: &u32| sweeps.group_of(self.colliders[shape].body) != own;
            around.extend(self.broad.overlapping(&whole).filter(is_other).take(FEW_SHAPES + 1));
        }
        around.len() <= FEW_SHAPES
    }

    /// Finds the touch of two shapes that may be in each other's way, as far as both go by what is known so far.
    fn find_touch(&self, sweeps: &mut Sweeps, place: usize) {
        let (swept, other) = sweeps.near[place];
        let colliders = [swept, other].map(|shape| &self.colliders[shape]);
        let bodies = colliders.map(|collider| collider.body);
        let stopped = bodies.map(|body| sweeps.stop_of(body).is_some());
        let moving = |i: usize| sweep::moving(colliders[i], &self.bodies[bodies[i]], self.path_of(sweeps, bodies[i]));
        let (a, b) = (moving(0), moving(1));
        let is_swept = sweeps.group_of(bodies[1]) != NO_GROUP && self.bodies[bodies[1]].fast;
        let extent = if is_swept { colliders[0].least_extent.min(colliders[1].least_extent) } else { colliders[0].least_extent };
        if let Some(time) = sweep::first_touch(&a, &b, extent, &mut sweeps.parts) {
            sweeps.touches.push(Reverse((time.to_bits(), swept, other, stopped)));
        }
    }

    /// Stops those of two bodies that touch which are swept and have not been stopped, and looks what that changes for others.
    fn stop_at(&self, sweeps: &mut Sweeps, time: f32, bodies: [u32; 2]) {
        let goes_on = |body: u32| sweeps.group_of(body) == NO_GROUP || sweeps.stop_of(body).is_some();
        let on = bodies.map(goes_on);
        let paths = bodies.map(|body| self.path_of(sweeps, body));
        for (i, met) in [(0, 1), (1, 0)] {
            if on[i] {
                continue;
            }
            let carried = on[met].then(|| [paths[met].at(time), paths[met].end]);
            let group = sweeps.group_of(bodies[i]);
            sweeps.groups[group as usize].stop = Some(Stop { time, carried });
        }
        for i in (0..2).filter(|&i| !on[i]) {
            let group = sweeps.group_of(bodies[i]);
            let first = sweeps.near_group.partition_point(|&(other, _)| other < group);
            let end = sweeps.near_group.partition_point(|&(other, _)| other <= group);
            for entry in first..end {
                let place = sweeps.near_group[entry].1 as usize;
                let (swept, other) = sweeps.near[place];
                let may_stop = |shape: u32| {
                    let body = self.colliders[shape].body;
                    sweeps.group_of(body) != NO_GROUP && sweeps.stop_of(body).is_none()
                };
                if may_stop(swept) || may_stop(other) {
                    self.find_touch(sweeps, place);
                }
            }
        }
    }

    /// Puts the members of a group where they stop.
    fn put_back(&mut self, members: &[Path], stop: &Stop, sweeps: &Sweeps) {
        for path in members {
            if let Some(union) = self.unions.moving(path.body) {
                if let Some(before) = union.before.filter(|_| union.lead == path.body) {
                    let pose = |motion: &UnionMotion| BodyPose { center: motion.center, rotation: motion.rotation };
                    let BodyPose { center, rotation } = stop.carry(pose(&before).lerp(&pose(&union.motion), stop.time));
                    self.place_members(path.body, UnionMotion { center, rotation, ..before });
                }
                continue;
            }
            let end = self.path_of(sweeps, path.body).end;
            let body = &mut self.bodies[path.body];
            (body.center, body.rotation) = (end.center, end.rotation);
            self.shapes_follow(path.body);
        }
    }

    fn shapes_follow(&mut self, index: u32) {
        let body = &self.bodies[index];
        for &id in &body.shapes {
            if let Ok(shape) = self.colliders.find(id) {
                self.colliders[shape].follow(body);
            }
        }
    }
}
