//! What holds a body up: the dual contact graph (Müller et al. 2017, §3.6), kept up as contacts come and go.
//!
//! Nodes are contacts (here *links*), two are neighbours when they act on the same body. A link is *lower → upper* by its normal
//! against gravity. It can carry load if it does not slide, and only where what lies below can: its **region** is its polygon of
//! points, projected across gravity, cut to the hull of the regions under its lower body. On the ground nothing is cut.
//!
//! ```text
//!   hull(b)      = convex hull of region(l) for the links l under b
//!   region(l)    = polygon(l) ∩ hull(lower(l))        if l holds, else nothing;      all of polygon(l) on the ground
//!   margin(b)    = signed distance of b's centre of mass, projected, from the border of hull(b)          supported: > 0
//! ```
//!
//! The paper takes points for contacts and asks of each whether it lies in the hull below. For single points this is the same;
//! a face that is wider than what carries it is cut here, where the paper would drop it whole.
//!
//! Bodies that joints tie together are one *unit*: held by a joint to the ground, or by a member that is supported by itself.
//!
//! Along lower → upper the units have **levels**, so that every hull is a function of hulls on lower levels: the order of work
//! does not matter, and a change is followed upwards only, one unit at a time from the lowest level, until hulls and verdicts
//! stay what they were. Where things stand on each other in a circle, links that do not go up in level carry nothing.

pub(crate) mod hull;
mod level;
pub(crate) mod slip;
pub(crate) mod verdict;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec2;

/// Points of a link.
pub(crate) const POINTS: usize = 4;

/// Share of a hull's reach that the centre of mass must lie inside it: a body balanced on an edge is not supported.
const EDGE_SHARE: f32 = 1.0e-3;

/// What a body is to the graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum NodeKind {
    /// Nothing.
    #[default]
    Absent,
    /// Carries any load, anywhere.
    Ground,
    /// Moves, but only as the host says; carries nothing while it does.
    Moving,
    /// Must be held up.
    Body,
}

/// A body, by its slot in the world.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Node {
    pub kind: NodeKind,
    /// Lowest body of those that joints tie together.
    pub unit: u32,
    /// Of the lowest body: all bodies of its unit, if there are others.
    members: Vec<u32>,
    /// Of the lowest body: whether a joint holds the unit to the ground.
    anchored: bool,
    /// Of the lowest body.
    level: u32,
    /// Links under the body and on it.
    pub below: Vec<u32>,
    pub above: Vec<u32>,
    /// Where it can carry, about its centre of mass (m).
    hull: Vec<Vec2>,
    /// How far its centre of mass lies inside (m).
    pub margin: f32,
    pub held_by_joints: bool,
}

impl Node {
    pub(crate) fn is_supported(&self) -> bool {
        self.stands() || self.held_by_joints
    }

    /// Whether contacts alone support it.
    pub(crate) fn stands(&self) -> bool {
        self.kind == NodeKind::Body && self.margin > EDGE_SHARE * hull::reach(&self.hull)
    }

    /// Corners of the region that supports it, about its centre of mass (m).
    pub(crate) fn hull(&self) -> &[Vec2] {
        &self.hull
    }
}

/// A contact through which `upper` stands on `lower`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Link {
    pub lower: u32,
    pub upper: u32,
    /// Points about the lower body's centre of mass (m).
    pub points: [Vec2; POINTS],
    pub count: u8,
    /// From the upper body's centre of mass to the lower one's (m).
    pub offset: Vec2,
    /// Whether it does not slide.
    pub holds: bool,
    /// Name of the contact in the world.
    pub pair: u32,
}

/// Contacts and bodies, and the verdicts on them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Graph {
    nodes: Vec<Node>,
    links: Vec<Option<Link>>,
    free: Vec<u32>,
    /// Units to evaluate, lowest level first.
    queue: BinaryHeap<Reverse<(u32, u32)>>,
    /// Bodies whose inputs have changed.
    dirty: Vec<u32>,
    levels_are_stale: bool,
    has_circles: bool,
    /// Bodies whose verdict the last update changed.
    changed: Vec<u32>,
    /// Number of units that the last update evaluated.
    evaluated: u32,
    scratch: Scratch,
}

#[derive(Debug, Clone, Default)]
struct Scratch {
    polygon: Vec<Vec2>,
    region: Vec<Vec2>,
    points: Vec<Vec2>,
    hull: Vec<Vec2>,
    bodies: Vec<u32>,
    /// Of the bodies of a unit: whether they were supported, and whether their hulls have changed.
    before: Vec<(bool, bool)>,
    levels: level::Scratch,
}

impl Graph {
    /// Forgets everything but memory.
    pub(crate) fn clear(&mut self) {
        for node in &mut self.nodes {
            node.kind = NodeKind::Absent;
            node.members.clear();
            node.below.clear();
            node.above.clear();
            node.hull.clear();
        }
        self.links.clear();
        self.free.clear();
        self.dirty.clear();
        self.changed.clear();
        self.levels_are_stale = false;
        self.has_circles = false;
    }

    pub(crate) fn node(&self, body: u32) -> Option<&Node> {
        self.nodes.get(body as usize).filter(|node| node.kind != NodeKind::Absent)
    }

    pub(crate) fn link(&self, link: u32) -> &Link {
        self.links[link as usize].as_ref().expect("links are named by the bodies they act on, and leave them first")
    }

    /// Bodies whose verdict the last update changed.
    pub(crate) fn changed(&self) -> &[u32] {
        &self.changed
    }

    /// Units that the last update had to look at.
    #[cfg(test)]
    fn evaluated(&self) -> u32 {
        self.evaluated
    }

    /// Says what a body is; it must have no links if it is to be absent.
    pub(crate) fn set_kind(&mut self, body: u32, kind: NodeKind) {
        if self.nodes.len() <= body as usize {
            self.nodes.resize_with(body as usize + 1, Node::default);
        }
        let node = &mut self.nodes[body as usize];
        if node.kind == kind {
            return;
        }
        let was_absent = node.kind == NodeKind::Absent;
        node.kind = kind;
        if was_absent {
            *node = Node { kind, unit: body, margin: f32::NEG_INFINITY, ..std::mem::take(node) };
            node.level = 1;
            node.anchored = false;
            node.held_by_joints = false;
        }
        node.hull.clear();
        node.margin = f32::NEG_INFINITY;
        self.mark(body);
        for number in 0..self.nodes[body as usize].above.len() {
            let upper = self.link(self.nodes[body as usize].above[number]).upper;
            self.mark(upper);
        }
        self.levels_are_stale |= !was_absent;
    }

    /// Ties bodies together anew: `ties` are pairs of bodies, `anchors` bodies that a joint holds to the ground.
    pub(crate) fn set_joints(&mut self, ties: &[(u32, u32)], anchors: &[u32]) {
        for body in 0..self.nodes.len() as u32 {
            let node = &mut self.nodes[body as usize];
            let was_tied = node.unit != body || !node.members.is_empty() || node.anchored;
            (node.unit, node.anchored) = (body, false);
            node.members.clear();
            if was_tied && node.kind == NodeKind::Body {
                self.mark(body);
            }
        }
        for &(a, b) in ties {
            let (a, b) = (self.root(a), self.root(b));
            self.nodes[a.max(b) as usize].unit = a.min(b);
        }
        for body in 0..self.nodes.len() as u32 {
            let root = self.root(body);
            self.nodes[body as usize].unit = root;
            if root != body {
                if self.nodes[root as usize].members.is_empty() {
                    self.nodes[root as usize].members.push(root);
                }
                self.nodes[root as usize].members.push(body);
                self.mark(body);
            }
        }
        for &body in anchors {
            let root = self.nodes[body as usize].unit;
            self.nodes[root as usize].anchored = true;
            self.mark(root);
        }
        self.levels_are_stale = true;
    }

    fn root(&self, mut body: u32) -> u32 {
        while self.nodes[body as usize].unit != body {
            body = self.nodes[body as usize].unit;
        }
        body
    }

    /// Adds a contact; its points are put in the order of their hull.
    pub(crate) fn insert(&mut self, mut link: Link) -> u32 {
        let polygon = &mut self.scratch.polygon;
        convex(&mut link, polygon);
        let number = self.free.pop().unwrap_or_else(|| {
            self.links.push(None);
            self.links.len() as u32 - 1
        });
        self.links[number as usize] = Some(link);
        self.nodes[link.upper as usize].below.push(number);
        self.nodes[link.lower as usize].above.push(number);
        self.mark(link.upper);
        let (lower, upper) = (self.nodes[link.lower as usize].unit, self.nodes[link.upper as usize].unit);
        let goes_up = self.nodes[lower as usize].level < self.nodes[upper as usize].level;
        let stands_on_a_body = self.nodes[link.lower as usize].kind == NodeKind::Body && lower != upper;
        self.levels_are_stale |= self.has_circles || (stands_on_a_body && !goes_up);
        number
    }

    /// Takes a contact away.
    pub(crate) fn remove(&mut self, number: u32) {
        let Some(link) = self.links[number as usize].take() else { return };
        self.free.push(number);
        self.nodes[link.upper as usize].below.retain(|&other| other != number);
        self.nodes[link.lower as usize].above.retain(|&other| other != number);
        self.mark(link.upper);
        self.levels_are_stale |= self.has_circles;
    }

    fn unit(&self, body: u32) -> &Node {
        &self.nodes[self.nodes[body as usize].unit as usize]
    }

    fn mark(&mut self, body: u32) {
        self.dirty.push(body);
    }

    /// Brings hulls and verdicts up to date with what has changed.
    pub(crate) fn update(&mut self) {
        self.changed.clear();
        self.evaluated = 0;
        if self.dirty.is_empty() {
            return;
        }
        if self.levels_are_stale {
            let had_circles = self.has_circles;
            self.has_circles = level::assign(&mut self.nodes, &self.links, &mut self.scratch.levels);
            self.levels_are_stale = false;
            if had_circles || self.has_circles {
                // Which links carry depends on the levels then.
                self.mark_all();
            }
        }
        while let Some(body) = self.dirty.pop() {
            if self.nodes[body as usize].kind == NodeKind::Body {
                self.queue.push(Reverse((self.unit(body).level, self.nodes[body as usize].unit)));
            }
        }
        let mut last = None;
        while let Some(Reverse(next)) = self.queue.pop() {
            if last != Some(next) {
                self.evaluate(next.1);
                last = Some(next);
            }
        }
        self.changed.sort_unstable();
    }

    /// Works everything out anew.
    #[cfg(test)]
    fn update_all(&mut self) {
        self.levels_are_stale = true;
        self.mark_all();
        self.update();
    }

    fn mark_all(&mut self) {
        for body in 0..self.nodes.len() as u32 {
            if self.nodes[body as usize].kind == NodeKind::Body && self.nodes[body as usize].unit == body {
                self.dirty.push(body);
            }
        }
    }

    /// Hulls and verdicts of the bodies of a unit; if they change, whatever stands on it is next.
    fn evaluate(&mut self, unit: u32) {
        self.evaluated += 1;
        let mut bodies = std::mem::take(&mut self.scratch.bodies);
        bodies.clear();
        match &self.nodes[unit as usize].members[..] {
            [] => bodies.push(unit),
            members => bodies.extend_from_slice(members),
        }
        bodies.retain(|&body| self.nodes[body as usize].kind == NodeKind::Body);
        let is_tied = bodies.len() > 1 || self.nodes[unit as usize].anchored;
        let mut held = self.nodes[unit as usize].anchored;
        self.scratch.before.clear();
        for &body in &bodies {
            let was_supported = self.nodes[body as usize].is_supported();
            let mut hull = std::mem::take(&mut self.scratch.hull);
            self.find_hull(body, &mut hull);
            let node = &mut self.nodes[body as usize];
            let is_other = node.hull != hull;
            if is_other {
                std::mem::swap(&mut node.hull, &mut hull);
                node.margin = hull::margin(&node.hull, Vec2::ZERO);
            }
            held |= node.stands();
            self.scratch.hull = hull;
            self.scratch.before.push((was_supported, is_other));
        }
        for (i, &body) in bodies.iter().enumerate() {
            let (was_supported, hull_is_other) = self.scratch.before[i];
            let node = &mut self.nodes[body as usize];
            let was_held = std::mem::replace(&mut node.held_by_joints, held && is_tied);
            if node.is_supported() != was_supported {
                self.changed.push(body);
            }
            if hull_is_other || was_held != (held && is_tied) {
                self.mark_above(body);
            }
        }
        self.scratch.bodies = bodies;
    }

    fn mark_above(&mut self, body: u32) {
        let level = self.unit(body).level;
        for number in 0..self.nodes[body as usize].above.len() {
            let upper = self.link(self.nodes[body as usize].above[number]).upper;
            let (unit, upper_level) = (self.nodes[upper as usize].unit, self.unit(upper).level);
            if upper_level > level {
                self.queue.push(Reverse((upper_level, unit)));
            }
        }
    }

    /// Hull of all regions under a body, about its centre of mass.
    fn find_hull(&mut self, body: u32, hull: &mut Vec<Vec2>) {
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.points.clear();
        for &number in &self.nodes[body as usize].below {
            let link = self.link(number);
            self.region(link, &mut scratch.polygon, &mut scratch.region);
            scratch.points.extend(scratch.region.iter().map(|&point| point + link.offset));
        }
        hull::convex_hull(&mut scratch.points, hull);
        self.scratch = scratch;
    }

    /// Where a link can carry, about the centre of mass of its lower body.
    fn region(&self, link: &Link, polygon: &mut Vec<Vec2>, out: &mut Vec<Vec2>) {
        out.clear();
        if !link.holds {
            return;
        }
        let lower = &self.nodes[link.lower as usize];
        let points = &link.points[..link.count as usize];
        match lower.kind {
            NodeKind::Absent | NodeKind::Moving => {}
            NodeKind::Ground => out.extend_from_slice(points),
            NodeKind::Body if self.unit(link.lower).level >= self.unit(link.upper).level => {}
            NodeKind::Body if lower.held_by_joints => out.extend_from_slice(points),
            NodeKind::Body => {
                polygon.clear();
                polygon.extend_from_slice(points);
                hull::intersect(polygon, &lower.hull, out);
            }
        }
    }

    /// Whether a link carries load up to the ground.
    pub(crate) fn is_supporting(&self, number: u32) -> bool {
        let (mut polygon, mut region) = (Vec::new(), Vec::new());
        self.region(self.link(number), &mut polygon, &mut region);
        !region.is_empty()
    }
}

/// Puts the points of a link in the order of their hull, which may leave some out.
fn convex(link: &mut Link, polygon: &mut Vec<Vec2>) {
    let mut points = link.points;
    hull::convex_hull(&mut points[..link.count as usize], polygon);
    link.count = polygon.len() as u8;
    link.points[..polygon.len()].copy_from_slice(polygon);
}

#[cfg(test)]
mod tests;
