//! Paths of swept bodies through a step, changed in the order of time as they hit something.
//!
//! Bodies that joints or a union connect form a *group*, which moves as one. Groups that hit each other form a *bundle* for the rest of the
//! step. A bundle that has hit nothing else keeps its own path. One that has hit a body which is not swept moves with that body, as if it lay
//! on it; but what is lighter than the bundle and free goes along with the bundle, so that a crate is not held up by what is in it. All others
//! move by the mean of their groups' displacements, weighted by mass, like bodies that collide without restitution. Bodies in a moving lift
//! therefore hit what they would hit on the ground.
//!
//! What lies still on another for the rest of a step loses that part of its way across it, and no velocity. If the other turns, the direction in
//! which it pushes turns too, and what it gives in each step would add up while the body stays: so a body *slides* there, as far as its own way
//! leads across the surface, until it touches once more. In a room, or on anything else of several pieces, it would slide into the next: there
//! it stays.

use glam::{DVec3, Vec3};

use crate::collide::sweep::{BodyPath, BodyPose};
use crate::world::body_shape_table::Marks;

/// What a body is swept against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::world) enum Swept {
    /// Nothing: it stops with what it is jointed to.
    Along,
    /// What stands still, whatever touches it: a hit has sent it another way than contacts were looked for on.
    FixedOnly,
    /// All that there is: it is flagged fast.
    All,
}

/// A body that may have to be stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::world) struct Path {
    /// Batch, and articulation in it; a body without joints is one by itself.
    pub group: (u32, u32),
    pub body: u32,
    pub swept: Swept,
}

/// In place of the number of a group, path or bundle.
pub(super) const NONE: u32 = u32::MAX;

/// A body that the step moves.
#[derive(Debug, Clone, Copy)]
struct Mover {
    /// Where it was when the step began.
    start: BodyPose,
    /// Number of its leg, if it may have to be stopped.
    leg: u32,
}

/// Way of a body that may have to be stopped, from the last time at which it has met something to the end of the step.
#[derive(Debug, Clone, Copy)]
struct Leg {
    body: u32,
    group: u32,
    swept: Swept,
    mass: f64,
    from: BodyPose,
    to: BodyPose,
}

/// Bodies that joints or a union connect.
#[derive(Debug, Clone, Copy)]
struct Group {
    /// Range of legs.
    first: u32,
    end: u32,
    /// Bundle that it is in, by the number of the first group of it, and the next group of that.
    bundle: u32,
    next: u32,
    /// Share of the step after which it goes on as its legs say, and how often that has changed.
    since: f64,
    changes: u32,
}

/// What decides how a bundle goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Hold {
    /// Nothing that is not swept.
    Free,
    /// A body that moves by itself and is not swept.
    ByMover(u32),
    /// One that nothing stops.
    ByFixed(u32),
}

impl Hold {
    fn body(self) -> Option<u32> {
        match self {
            Self::Free => None,
            Self::ByMover(body) | Self::ByFixed(body) => Some(body),
        }
    }

    fn rank(self) -> u8 {
        match self {
            Self::Free => 0,
            Self::ByMover(_) => 1,
            Self::ByFixed(_) => 2,
        }
    }
}

/// Groups that have met, at the place of the first of them.
#[derive(Debug, Clone, Copy)]
struct Bundle {
    hold: Hold,
    /// Whether it goes on across the surface of what holds it.
    slides: bool,
    /// Last group.
    last: u32,
}

/// Ways of all bodies through a step.
#[derive(Debug, Default)]
pub(super) struct Paths {
    movers: Vec<Mover>,
    moved: Marks,
    legs: Vec<Leg>,
    groups: Vec<Group>,
    bundles: Vec<Bundle>,
    /// Groups that the last meeting has sent another way.
    pub changed: Vec<u32>,
}

/// How something rigid moves that is at one place now and at the other at the end of the step.
fn carried([now, end]: [BodyPose; 2], at: BodyPose) -> BodyPose {
    let turn = end.rotation * now.rotation.conjugate();
    let center = end.center + turn.as_dquat() * (at.center - now.center);
    BodyPose { center, rotation: (turn * at.rotation).normalize() }
}

/// Two ways as the body of the second sees them, in the axes that it has at their start.
pub(super) fn as_seen_from([own, other]: [BodyPath; 2]) -> [BodyPath; 2] {
    let end = carried([other.end, other.start], own.end);
    [BodyPath { start: own.start, end }, BodyPath { start: other.start, end: other.start }]
}

impl Paths {
    /// Begins a step in which bodies of so many slots may move.
    pub fn begin(&mut self, slots: usize) {
        self.moved.begin(slots);
        self.movers.resize(slots, Mover { start: BodyPose::ORIGIN, leg: NONE });
    }

    /// Takes note of where a body is that the step will move.
    pub fn note_start(&mut self, body: u32, start: BodyPose) {
        self.movers[body as usize] = Mover { start, leg: NONE };
        self.moved.set(body);
    }

    /// Takes the bodies that may have to be stopped, sorted by group; `of_body` gives mass (kg) and pose at the end of the step.
    pub fn lay_out(&mut self, paths: &[Path], of_body: impl Fn(u32) -> (f64, BodyPose)) {
        self.legs.clear();
        self.groups.clear();
        self.bundles.clear();
        for (place, path) in (0..).zip(paths) {
            let number = self.groups.len() as u32;
            if place == 0 || paths[place as usize - 1].group != path.group {
                self.groups.push(Group { first: place, end: place, bundle: number, next: NONE, since: 0.0, changes: 0 });
                self.bundles.push(Bundle { hold: Hold::Free, slides: false, last: number });
            }
            let group = self.groups.len() as u32 - 1;
            self.groups[group as usize].end = place + 1;
            let ((mass, to), mover) = (of_body(path.body), &mut self.movers[path.body as usize]);
            mover.leg = place;
            self.legs.push(Leg { body: path.body, group, swept: path.swept, mass, from: mover.start, to });
        }
    }

    pub fn group_count(&self) -> u32 {
        self.groups.len() as u32
    }

    /// Bodies of a group.
    pub fn members(&self, group: u32) -> impl Iterator<Item = u32> + '_ {
        self.legs_of(group).iter().map(|leg| leg.body)
    }

    fn legs_of(&self, group: u32) -> &[Leg] {
        let Group { first, end, .. } = self.groups[group as usize];
        &self.legs[first as usize..end as usize]
    }

    fn leg_of(&self, body: u32) -> Option<&Leg> {
        let is_moved = self.moved.has(body);
        self.legs.get(if is_moved { self.movers[body as usize].leg } else { NONE } as usize)
    }

    /// Group of a body; [`NONE`] if it goes where the step has put it.
    pub fn group_of(&self, body: u32) -> u32 {
        self.leg_of(body).map_or(NONE, |leg| leg.group)
    }

    /// What a body is swept against.
    pub fn swept(&self, body: u32) -> Swept {
        self.leg_of(body).map_or(Swept::Along, |leg| leg.swept)
    }

    /// How often the way of a body has changed.
    pub fn changes_of(&self, body: u32) -> u32 {
        self.leg_of(body).map_or(0, |leg| self.groups[leg.group as usize].changes)
    }

    /// Whether two bodies go on together already.
    pub fn are_together(&self, bodies: [u32; 2]) -> bool {
        let [a, b] = bodies.map(|body| self.leg_of(body).map(|leg| self.groups[leg.group as usize].bundle));
        a.is_some() && a == b
    }

    /// What a body goes on across the surface of.
    pub fn slides_on(&self, body: u32) -> Option<u32> {
        let Bundle { hold, slides, .. } = self.bundles[self.groups[self.leg_of(body)?.group as usize].bundle as usize];
        hold.body().filter(|_| slides)
    }

    /// What holds a body that is not swept.
    pub fn held_by(&self, body: u32) -> Option<u32> {
        self.bundles[self.groups[self.leg_of(body)?.group as usize].bundle as usize].hold.body()
    }

    /// Where a body goes after a share of the step; `end` is where the step has put it.
    pub fn path_after(&self, body: u32, time: f64, end: BodyPose) -> BodyPath {
        if let Some(leg) = self.leg_of(body) {
            return BodyPath { start: self.pose_at(leg, time), end: leg.to };
        }
        let start = if self.moved.has(body) { self.movers[body as usize].start.lerp(&end, time) } else { end };
        BodyPath { start, end }
    }

    /// Where a body ends that has met something; none for one that goes its own way.
    pub fn new_end(&self, body: u32) -> Option<BodyPose> {
        let leg = self.leg_of(body)?;
        (self.groups[leg.group as usize].changes > 0).then_some(leg.to)
    }

    fn pose_at(&self, leg: &Leg, time: f64) -> BodyPose {
        let since = self.groups[leg.group as usize].since;
        if time <= since { leg.from } else { leg.from.lerp(&leg.to, (time - since) / (1.0 - since)) }
    }

    /// Has a body go on with one that is not swept, from a share of the step on; `path` is where that goes from then on, and `across` the
    /// direction in which it is touched, if the body may slide on it.
    pub fn meet_other(&mut self, time: f64, body: u32, hold: Hold, path: BodyPath, across: Option<Vec3>) {
        self.changed.clear();
        let Some(&leg) = self.leg_of(body) else { return };
        let bundle = self.groups[leg.group as usize].bundle;
        let before = self.bundles[bundle as usize];
        let is_new = before.hold.rank() < hold.rank();
        let goes_on = before.slides && before.hold.rank() == hold.rank();
        if !(is_new || goes_on) {
            return;
        }
        let across = across.filter(|_| is_new && path.start.rotation != path.end.rotation);
        let way = across.map_or(DVec3::ZERO, |normal| self.way_across(&leg, time, path, normal));
        let carrier = [path.start, path.end];
        self.redirect(time, bundle, |from| carried(carrier, BodyPose { center: from.center + way, ..from }));
        self.bundles[bundle as usize] = Bundle { hold, slides: across.is_some(), ..before };
    }

    /// What a body's way from a share of the step on leads it across the surface of another, in the axes that that has then (m).
    fn way_across(&self, leg: &Leg, time: f64, path: BodyPath, normal: Vec3) -> DVec3 {
        let [own, _] = as_seen_from([BodyPath { start: self.pose_at(leg, time), end: leg.to }, path]);
        let (way, normal) = (own.end.center - own.start.center, normal.as_dvec3());
        way - normal * way.dot(normal).max(0.0)
    }

    /// Has a free body that is lighter than what it meets, and goes where the step has put it so far, be carried by that from a share of
    /// the step on. False if it is not lighter; `mass` and `end` are its own.
    pub fn take_along(&mut self, time: f64, by: u32, body: u32, (mass, end): (f64, BodyPose)) -> bool {
        let Some(&carrier) = self.leg_of(by) else { return false };
        let bundle = self.groups[carrier.group as usize].bundle;
        if !self.moved.has(body) || mass >= self.way_ahead(bundle, time).0 {
            return false;
        }
        self.changed.clear();
        let (leg, group) = (self.legs.len() as u32, self.groups.len() as u32);
        let mover = &mut self.movers[body as usize];
        mover.leg = leg;
        self.legs.push(Leg { body, group, swept: Swept::All, mass, from: mover.start, to: end });
        self.groups.push(Group { first: leg, end: leg + 1, bundle: group, next: NONE, since: 0.0, changes: 0 });
        self.bundles.push(Bundle { hold: Hold::Free, slides: false, last: group });
        self.carry(time, group, [self.pose_at(&carrier, time), carrier.to]);
        self.join(bundle, group);
        true
    }

    /// Has two bodies that may both have to be stopped go on together.
    pub fn meet(&mut self, time: f64, bodies: [u32; 2]) {
        self.changed.clear();
        let legs = bodies.map(|body| self.leg_of(body).copied());
        let [Some(a), Some(b)] = legs else { return };
        let [bundle_a, bundle_b] = [a, b].map(|leg| self.groups[leg.group as usize].bundle);
        let ranks = [bundle_a, bundle_b].map(|bundle| self.bundles[bundle as usize].hold.rank());
        match ranks[0].cmp(&ranks[1]) {
            // Between two that go where they must there is nothing to decide.
            std::cmp::Ordering::Equal if ranks[0] > 0 => return,
            std::cmp::Ordering::Equal => {
                let ways = [bundle_a, bundle_b].map(|bundle| self.way_ahead(bundle, time));
                let mass = ways[0].0 + ways[1].0;
                let mean = (ways[0].1 + ways[1].1) / mass;
                self.drift(time, bundle_a, mean);
                self.drift(time, bundle_b, mean);
            }
            std::cmp::Ordering::Less => self.carry(time, bundle_a, [self.pose_at(&b, time), b.to]),
            std::cmp::Ordering::Greater => self.carry(time, bundle_b, [self.pose_at(&a, time), a.to]),
        }
        let (into, from) = if ranks[0] >= ranks[1] { (bundle_a, bundle_b) } else { (bundle_b, bundle_a) };
        self.join(into, from);
    }

    /// Groups of a bundle.
    fn groups_in(&self, bundle: u32) -> impl Iterator<Item = u32> + '_ {
        let next = |&group: &u32| Some(self.groups[group as usize].next).filter(|&next| next != NONE);
        std::iter::successors(Some(bundle), next)
    }

    /// Mass of a bundle (kg), and that times what it would move by from a share of the step on (kg·m).
    fn way_ahead(&self, bundle: u32, time: f64) -> (f64, DVec3) {
        let legs = self.groups_in(bundle).flat_map(|group| self.legs_of(group));
        legs.fold((0.0, DVec3::ZERO), |(mass, way), leg| {
            (mass + leg.mass, way + leg.mass * (leg.to.center - self.pose_at(leg, time).center))
        })
    }

    /// Sends a bundle another way.
    fn redirect(&mut self, time: f64, bundle: u32, end_of: impl Fn(BodyPose) -> BodyPose) {
        let mut group = bundle;
        while group != NONE {
            let Group { first, end, next, .. } = self.groups[group as usize];
            for leg in first as usize..end as usize {
                let from = self.pose_at(&self.legs[leg], time);
                (self.legs[leg].from, self.legs[leg].to) = (from, end_of(from));
            }
            let group_record = &mut self.groups[group as usize];
            group_record.since = time;
            group_record.changes += 1;
            self.changed.push(group);
            group = next;
        }
    }

    fn drift(&mut self, time: f64, bundle: u32, way: DVec3) {
        self.redirect(time, bundle, |from| BodyPose { center: from.center + way, ..from });
    }

    fn carry(&mut self, time: f64, bundle: u32, carrier: [BodyPose; 2]) {
        self.redirect(time, bundle, |from| carried(carrier, from));
    }

    /// Merges the bundle `from` into the bundle `into`. The path of `from` is that of `into` already.
    fn join(&mut self, into: u32, from: u32) {
        let (last, end) = (self.bundles[into as usize].last, self.bundles[from as usize].last);
        let mut group = from;
        while group != NONE {
            self.groups[group as usize].bundle = into;
            group = self.groups[group as usize].next;
        }
        self.groups[last as usize].next = from;
        self.bundles[into as usize].last = end;
    }
}
