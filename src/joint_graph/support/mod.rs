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

pub(crate) mod cone;
pub(crate) mod hull;
mod level;
mod node;
pub(crate) mod slip;
pub(crate) mod verdict;

use glam::Vec2;

pub(crate) use node::{NodeKind, POINTS, SupportLink, SupportNode};

/// A link, its places in the lists of its two bodies, and whether it went up in level when levels were numbered last.
#[derive(Debug, Clone, Copy)]
struct PlacedLink {
    link: SupportLink,
    in_below: u32,
    in_above: u32,
    went_up: bool,
}

/// Contacts and bodies, and the verdicts on them.
#[derive(Debug, Clone, Default)]
pub(crate) struct SupportGraph {
    nodes: Vec<SupportNode>,
    links: Vec<Option<PlacedLink>>,
    free: Vec<u32>,
    /// Links whose lower body needs no support.
    bases: u32,
    /// Units to evaluate, by level.
    queue: Vec<Vec<u32>>,
    /// Bodies whose inputs have changed.
    dirty: Vec<u32>,
    levels_are_stale: bool,
    has_circles: bool,
    /// Bodies whose verdict the last update changed.
    changed: Vec<u32>,
    /// Number of units that the last update evaluated.
    evaluated: u32,
    scratch: LevelScratch,
}

#[derive(Debug, Clone, Default)]
struct LevelScratch {
    polygon: Vec<Vec2>,
    region: Vec<Vec2>,
    points: Vec<Vec2>,
    hull: Vec<Vec2>,
    bodies: Vec<u32>,
    /// Of the bodies of a unit: whether they were supported, and whether their hulls have changed.
    before: Vec<(bool, bool)>,
    levels: level::LevelScratch,
}

impl SupportGraph {
    /// Forgets everything but memory.
    pub(crate) fn clear(&mut self) {
        for node in &mut self.nodes {
            node.kind = NodeKind::Absent;
            node.members.clear();
            node.below.clear();
            node.above.clear();
            node.hull.clear();
            (node.is_dirty, node.waits) = (false, false);
        }
        self.links.clear();
        self.free.clear();
        self.dirty.clear();
        self.changed.clear();
        self.bases = 0;
        self.levels_are_stale = false;
        self.has_circles = false;
    }

    /// Whether anything stands on what needs no support.
    pub(crate) fn has_bases(&self) -> bool {
        self.bases > 0
    }

    pub(crate) fn node(&self, body: u32) -> Option<&SupportNode> {
        self.nodes.get(body as usize).filter(|node| node.kind != NodeKind::Absent)
    }

    pub(crate) fn link(&self, link: u32) -> &SupportLink {
        &self.links[link as usize].as_ref().expect("links are named by the bodies they act on, and leave them first").link
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
            self.nodes.resize_with(body as usize + 1, SupportNode::default);
        }
        let node = &mut self.nodes[body as usize];
        if node.kind == kind {
            return;
        }
        let was_absent = node.kind == NodeKind::Absent;
        let on_it = node.above.len() as u32;
        self.bases += on_it * u32::from(kind != NodeKind::Body);
        self.bases -= on_it * u32::from(node.kind != NodeKind::Body);
        node.kind = kind;
        if was_absent {
            *node = SupportNode { kind, unit: body, margin: f32::NEG_INFINITY, ..std::mem::take(node) };
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
    pub(crate) fn insert(&mut self, mut link: SupportLink) -> u32 {
        convex(&mut link, &mut self.scratch.polygon);
        self.place(link)
    }

    fn place(&mut self, link: SupportLink) -> u32 {
        let number = self.free.pop().unwrap_or_else(|| {
            self.links.push(None);
            self.links.len() as u32 - 1
        });
        if link.holds {
            self.mark(link.upper);
            self.begin_to_hold(&link);
        }
        let [below, above] = [link.upper, link.lower].map(|body| body as usize);
        let (in_below, in_above) = (self.nodes[below].below.len() as u32, self.nodes[above].above.len() as u32);
        self.links[number as usize] = Some(PlacedLink { link, in_below, in_above, went_up: self.goes_up(&link) });
        self.nodes[below].below.push(number);
        self.nodes[above].above.push(number);
        self.bases += u32::from(self.nodes[above].kind != NodeKind::Body);
        number
    }

    /// Puts another contact in the place of one, and says which number it has.
    pub(crate) fn replace(&mut self, number: u32, mut link: SupportLink) -> u32 {
        convex(&mut link, &mut self.scratch.polygon);
        let Some(PlacedLink { link: old, .. }) = &mut self.links[number as usize] else { return self.place(link) };
        if (old.lower, old.upper) != (link.lower, link.upper) {
            self.remove(number);
            return self.place(link);
        }
        if old.is_near(&link) {
            return number;
        }
        let old = std::mem::replace(old, link);
        if old.holds || link.holds {
            self.mark(link.upper);
        }
        match (old.holds, link.holds) {
            (false, true) => {
                self.begin_to_hold(&link);
                let went_up = self.goes_up(&link);
                if let Some(placed) = &mut self.links[number as usize] {
                    placed.went_up = went_up;
                }
            }
            (true, false) => self.levels_are_stale |= self.has_circles,
            _ => {}
        }
        number
    }

    /// Levels are those of links that hold.
    fn begin_to_hold(&mut self, link: &SupportLink) {
        let [lower, upper] = [link.lower, link.upper].map(|body| self.nodes[body as usize].unit);
        let stands_on_a_body = self.nodes[link.lower as usize].kind == NodeKind::Body && lower != upper;
        self.levels_are_stale |= self.has_circles;
        if stands_on_a_body && !self.goes_up(link) && !self.levels_are_stale {
            self.levels_are_stale = !level::raise(&mut self.nodes, &self.links, (lower, upper), &mut self.scratch.levels);
        }
    }

    fn goes_up(&self, link: &SupportLink) -> bool {
        self.unit(link.lower).level < self.unit(link.upper).level
    }

    /// Gives the contacts of the world other names.
    pub(crate) fn name_pairs(&mut self, name: impl Fn(u32) -> u32) {
        self.links.iter_mut().flatten().for_each(|placed| placed.link.pair = name(placed.link.pair));
    }

    /// Removes a contact, and its entries in the lists of the two bodies.
    pub(crate) fn remove(&mut self, number: u32) {
        let Some(PlacedLink { link, in_below, in_above, .. }) = self.links[number as usize].take() else { return };
        self.free.push(number);
        let Self { nodes, links, .. } = self;
        let (below, above) = (&mut nodes[link.upper as usize].below, in_below as usize);
        below.swap_remove(above);
        if let Some(moved) = below.get(above).and_then(|&other| links[other as usize].as_mut()) {
            moved.in_below = in_below;
        }
        let (above, place) = (&mut nodes[link.lower as usize].above, in_above as usize);
        above.swap_remove(place);
        if let Some(moved) = above.get(place).and_then(|&other| links[other as usize].as_mut()) {
            moved.in_above = in_above;
        }
        self.bases -= u32::from(nodes[link.lower as usize].kind != NodeKind::Body);
        if link.holds {
            self.mark(link.upper);
            self.levels_are_stale |= self.has_circles;
        }
    }

    fn unit(&self, body: u32) -> &SupportNode {
        &self.nodes[self.nodes[body as usize].unit as usize]
    }

    fn mark(&mut self, body: u32) {
        if !std::mem::replace(&mut self.nodes[body as usize].is_dirty, true) {
            self.dirty.push(body);
        }
    }

    /// Brings hulls and verdicts up to date with what has changed.
    pub(crate) fn update(&mut self) {
        self.changed.clear();
        self.evaluated = 0;
        if self.dirty.is_empty() && !self.levels_are_stale {
            return;
        }
        if std::mem::take(&mut self.levels_are_stale) {
            self.has_circles = level::assign(&mut self.nodes, &mut self.links, &mut self.scratch.levels);
            // Which links carry depends on the levels.
            let mut turned = std::mem::take(&mut self.scratch.levels.turned);
            turned.drain(..).for_each(|body| self.mark(body));
            self.scratch.levels.turned = turned;
        }
        while let Some(body) = self.dirty.pop() {
            self.nodes[body as usize].is_dirty = false;
            if self.nodes[body as usize].kind == NodeKind::Body {
                self.enqueue(self.nodes[body as usize].unit);
            }
        }
        let mut level = 0;
        while level < self.queue.len() {
            match self.queue[level].pop() {
                Some(unit) => self.evaluate(unit),
                None => level += 1,
            }
        }
        self.changed.sort_unstable();
    }

    fn enqueue(&mut self, unit: u32) {
        let node = &mut self.nodes[unit as usize];
        if !std::mem::replace(&mut node.waits, true) {
            let level = node.level as usize;
            if self.queue.len() <= level {
                self.queue.resize_with(level + 1, Vec::new);
            }
            self.queue[level].push(unit);
        }
    }

    /// Works everything out anew.
    #[cfg(test)]
    fn update_all(&mut self) {
        self.levels_are_stale = true;
        for body in 0..self.nodes.len() as u32 {
            self.mark(body);
        }
        self.update();
    }

    /// Hulls and verdicts of the bodies of a unit; if they change, whatever stands on it is next.
    fn evaluate(&mut self, unit: u32) {
        self.evaluated += 1;
        self.nodes[unit as usize].waits = false;
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
            let &SupportLink { upper, holds: true, .. } = self.link(self.nodes[body as usize].above[number]) else { continue };
            let (unit, upper_level) = (self.nodes[upper as usize].unit, self.unit(upper).level);
            if upper_level > level {
                self.enqueue(unit);
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
    fn region(&self, link: &SupportLink, polygon: &mut Vec<Vec2>, out: &mut Vec<Vec2>) {
        out.clear();
        if !link.holds {
            return;
        }
        let lower = &self.nodes[link.lower as usize];
        let points = &link.points[..link.count as usize];
        match lower.kind {
            NodeKind::Absent | NodeKind::Moving => {}
            NodeKind::Ground => out.extend_from_slice(points),
            NodeKind::Body if !self.goes_up(link) => {}
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

/// Puts the points of a link that holds in the order of their hull, which may leave some out.
fn convex(link: &mut SupportLink, polygon: &mut Vec<Vec2>) {
    if !link.holds {
        // It carries nothing, wherever it is.
        (link.count, link.points, link.offset) = (0, [Vec2::ZERO; POINTS], Vec2::ZERO);
        return;
    }
    let mut points = link.points;
    hull::convex_hull(&mut points[..link.count as usize], polygon);
    link.count = polygon.len() as u8;
    link.points[..polygon.len()].copy_from_slice(polygon);
}

#[cfg(test)]
mod tests;
