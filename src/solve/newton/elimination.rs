//! Elimination order of the bodies and joints of an island, and the blocks of the factor that fill in.
//!
//! A body is a node of six unknowns, a joint a node of one unknown for each of its rows. The diagonal block of a joint is −ε, next to
//! nothing, until one of its bodies has been eliminated.
//!
//! An eliminated part answers as if all other bodies were fixed. A body that is eliminated before both its neighbours would be held twice
//! along the line between its two joints, and the second joint would have a pivot of −ε, though neither is redundant. So what has been
//! eliminated together leans on one other body at most, as a rigid body does on one that is fixed, which adds nothing to what holds it
//! together. The world counts as a body that is never eliminated. No pivot is smaller then than the rows are independent.
//!
//! Of the nodes that this allows the one goes first whose elimination takes the least work, the lowest number among equals. A joint is no
//! edge between its bodies: an eliminated part leaves rows of the joints around it, which are fewer than the unknowns of their bodies.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Unknowns of a body, and the most of a joint.
pub(crate) const WIDTH: usize = 6;

/// How long the rows of a panel are that belongs to a node of so many unknowns: what lanes take at once.
pub(crate) const fn stride(size: usize) -> usize {
    if size > 4 { 8 } else { 4 }
}

/// Neighbours that a node has room for from the first: those of nodes change as near pairs do, and that takes no memory then.
const ROOM: usize = 32;

/// Rows of an eliminated node's panel that lie side by side in the panel of a node below it as well: from where, to where, how many.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run {
    pub from: u32,
    pub to: u32,
    pub count: u32,
}

/// How the numbers of the factor are laid out: node by node a panel, with rows of its own and of the blocks below, one after the other, and in
/// each row an entry for each unknown of the node, with zeros at its end.
#[derive(Debug, Default)]
pub(crate) struct Panels {
    /// Where the panel of each node begins, and how many rows it has.
    pub starts: Vec<u32>,
    pub heights: Vec<u32>,
    /// First row of each block in the panel of the node that it is below.
    pub rows: Vec<u32>,
    /// First run of each block, and one more: rows of the panel, from the block's own on, that the elimination subtracts from the panel of the
    /// block's node.
    pub first_run: Vec<u32>,
    pub runs: Vec<Run>,
    /// Numbers in all.
    pub length: usize,
}

/// The structure of the factor of a system.
#[derive(Debug, Default)]
pub(crate) struct Elimination {
    /// Unknowns of each node, and how many of the nodes are bodies, the first ones.
    pub sizes: Vec<u8>,
    bodies: usize,
    /// Pairs of nodes that rows connect, sorted.
    edges: Vec<[u32; 2]>,
    /// Nodes in the order of elimination, and the place of each in it.
    pub order: Vec<u32>,
    place: Vec<u32>,
    /// First block below each node, and one more; the node of each block, those eliminated earlier first.
    pub first_below: Vec<u32>,
    pub below: Vec<u32>,
    pub panels: Panels,
    /// Multiplications of a factorisation.
    pub work: u64,
    neighbours: Vec<Vec<u32>>,
    eliminated: Vec<Vec<u32>>,
    /// Bodies of each joint: the second may be the world.
    ends: Vec<[u32; 2]>,
    /// Groups of bodies that eliminated joints connect, as a forest, and what body each root's group leans on.
    grouped: Vec<u32>,
    leans_on: Vec<u32>,
    /// Nodes that may be next by the work that they take, some of them with a work that is no longer true; the work of each node now, and
    /// whether it is in the queue with that.
    queue: BinaryHeap<Reverse<(u64, u32)>>,
    costs: Vec<u64>,
    is_queued: Vec<bool>,
    /// Joints that are not eligible before each body has been eliminated, or another one.
    waiting: Vec<Vec<u32>>,
    merged: Vec<u32>,
}

/// No body, and the one that is never eliminated.
const NONE: u32 = u32::MAX;
const WORLD: u32 = u32::MAX - 1;

impl Elimination {
    /// Finds the structure for nodes of these sizes, the first of which are bodies, and these edges, which must be sorted, without
    /// repeats, lower node first. Does nothing where they are those of the last time. Whether a factorisation takes `most` multiplications or
    /// fewer: there is no structure where it does not.
    pub(crate) fn prepare(&mut self, bodies: usize, sizes: &[u8], edges: &[[u32; 2]], most: u64) -> bool {
        let is_known = self.bodies == bodies && self.sizes == sizes && self.edges == edges;
        if is_known && (self.work > most || self.order.len() == sizes.len()) {
            return self.work <= most;
        }
        self.bodies = bodies;
        self.sizes.clear();
        self.sizes.extend_from_slice(sizes);
        self.edges.clear();
        self.edges.extend_from_slice(edges);
        self.find_order(most);
        if self.work > most {
            return false;
        }
        self.list_blocks();
        self.list_runs();
        true
    }

    pub(crate) fn node_count(&self) -> usize {
        self.sizes.len()
    }

    /// Where the block of two nodes begins that rows connect, how long its rows are, and whether these are those of `a`.
    pub(crate) fn block(&self, a: u32, b: u32) -> (usize, usize, bool) {
        let a_is_later = self.place[a as usize] > self.place[b as usize];
        let (later, earlier) = if a_is_later { (a, b) } else { (b, a) };
        let panels = &self.panels;
        let stride = stride(usize::from(self.sizes[earlier as usize]));
        let row = panels.rows[self.find(later, earlier)] as usize;
        (panels.starts[earlier as usize] as usize + row * stride, stride, a_is_later)
    }

    fn find(&self, later: u32, earlier: u32) -> usize {
        let range = self.below_of(earlier);
        let place = |node: u32| self.place[node as usize];
        let number = range.start + self.below[range].partition_point(|&node| place(node) < place(later));
        debug_assert!(self.below.get(number) == Some(&later), "no rows connect nodes {later} and {earlier}");
        number
    }

    /// Blocks below a node.
    pub(crate) fn below_of(&self, node: u32) -> std::ops::Range<usize> {
        self.first_below[node as usize] as usize..self.first_below[node as usize + 1] as usize
    }

    /// Finds the order, until it takes more than `most` multiplications.
    fn find_order(&mut self, most: u64) {
        self.begin_order();
        self.work = 0;
        while let Some(Reverse((cost, node))) = self.queue.pop() {
            let number = node as usize;
            if self.place[number] != u32::MAX || !self.is_queued[number] || cost != self.costs[number] {
                continue;
            }
            self.is_queued[number] = false;
            if let Some(leaning) = self.held_up_by(number) {
                leaning.into_iter().filter(|&body| body != WORLD).for_each(|body| self.waiting[body as usize].push(node));
                continue;
            }
            self.place[number] = self.order.len() as u32;
            self.order.push(node);
            if number < self.bodies {
                while let Some(joint) = self.waiting[number].pop() {
                    self.enqueue(joint);
                }
            } else {
                self.connect(number - self.bodies);
            }
            self.work += self.work_of(node);
            if self.work > most {
                return;
            }
            self.remove(node);
        }
        debug_assert!(self.order.len() == self.sizes.len(), "joints that nothing makes eligible");
    }

    /// Multiplications of the elimination of a node.
    fn work_of(&self, node: u32) -> u64 {
        let size = |node: u32| u64::from(self.sizes[node as usize]);
        let sums = |(sum, squares): (u64, u64), &other: &u32| (sum + size(other), squares + size(other).pow(2));
        let (around, squares) = self.neighbours[node as usize].iter().fold((0, 0), sums);
        let own = size(node);
        own.pow(3) + own.pow(2) * around + own * (around * around + squares) / 2
    }

    /// Lists the neighbours of all nodes, and puts those in the queue that may be first.
    fn begin_order(&mut self) {
        let (count, bodies) = (self.sizes.len(), self.bodies);
        for lists in [&mut self.neighbours, &mut self.eliminated] {
            lists.resize_with(count.max(lists.len()), || Vec::with_capacity(ROOM));
            lists.iter_mut().for_each(Vec::clear);
        }
        self.waiting.resize_with(bodies.max(self.waiting.len()), || Vec::with_capacity(ROOM));
        self.waiting.iter_mut().for_each(Vec::clear);
        for &[a, b] in &self.edges {
            self.neighbours[a as usize].push(b);
            self.neighbours[b as usize].push(a);
        }
        self.neighbours.iter_mut().for_each(|list| list.sort_unstable());
        self.ends.clear();
        self.ends.extend(self.neighbours[bodies..count].iter().map(|bodies| match bodies[..] {
            [a, b] => [a, b],
            [a] => [a, WORLD],
            _ => [WORLD, WORLD],
        }));
        self.grouped.clear();
        self.grouped.extend(0..bodies as u32);
        self.leans_on.clear();
        self.leans_on.resize(bodies, NONE);
        self.order.clear();
        self.queue.clear();
        self.queue.reserve(ROOM / 4 * count);
        self.place.clear();
        self.place.resize(count, u32::MAX);
        self.costs.clear();
        self.costs.resize(count, 0);
        self.is_queued.clear();
        self.is_queued.resize(count, false);
        for node in 0..count as u32 {
            self.costs[node as usize] = self.cost(node);
            self.enqueue(node);
        }
    }

    /// Puts a node in the queue that is not in it.
    fn enqueue(&mut self, node: u32) {
        let number = node as usize;
        if !self.is_queued[number] && self.place[number] == u32::MAX {
            self.is_queued[number] = true;
            self.queue.push(Reverse((self.costs[number], node)));
        }
    }

    /// Multiplications of what the elimination of a node subtracts, next to all of its work.
    fn cost(&self, node: u32) -> u64 {
        let size = |node: u32| u64::from(self.sizes[node as usize]);
        let around: u64 = self.neighbours[node as usize].iter().map(|&other| size(other)).sum();
        size(node) * around * around
    }

    /// Takes a node out of the graph: what is around it are neighbours then.
    fn remove(&mut self, node: u32) {
        let own = std::mem::take(&mut self.neighbours[node as usize]);
        for &other in &own {
            self.join(other, &own, node);
        }
        for &other in &own {
            let (number, cost) = (other as usize, self.cost(other));
            if cost != self.costs[number] {
                self.costs[number] = cost;
                if std::mem::take(&mut self.is_queued[number]) {
                    self.enqueue(other);
                }
            }
        }
        self.eliminated[node as usize].extend_from_slice(&own);
        self.neighbours[node as usize] = own;
        self.neighbours[node as usize].clear();
    }

    fn is_eliminated(&self, body: u32) -> bool {
        body != WORLD && self.place[body as usize] != u32::MAX
    }

    /// Root of the group of an eliminated body.
    fn group(&mut self, body: u32) -> u32 {
        let mut body = body as usize;
        while self.grouped[body] as usize != body {
            self.grouped[body] = self.grouped[self.grouped[body] as usize];
            body = self.grouped[body] as usize;
        }
        body as u32
    }

    /// What one end of a joint leans on, were the joint eliminated now: the body itself where it is not. A group that leans on a body which has
    /// been eliminated since has gone with it.
    fn leaning(&mut self, mut body: u32) -> u32 {
        while self.is_eliminated(body) {
            let group = self.group(body);
            let on = self.leans_on[group as usize];
            if on == NONE || !self.is_eliminated(on) {
                return on;
            }
            self.leans_on[group as usize] = NONE;
            self.grouped[group as usize] = self.group(on);
            body = on;
        }
        body
    }

    /// The two bodies on which what has been eliminated would lean with a joint, if that may not be eliminated now.
    fn held_up_by(&mut self, node: usize) -> Option<[u32; 2]> {
        let [a, b] = self.ends[node.checked_sub(self.bodies)?];
        if a == WORLD && b == WORLD {
            return None;
        }
        let leaning = [self.leaning(a), self.leaning(b)];
        let is_sound = leaning[0] == leaning[1] || leaning.contains(&NONE);
        (!is_sound).then_some(leaning)
    }

    /// Notes what an eliminated joint connects.
    fn connect(&mut self, joint: usize) {
        let ends = self.ends[joint];
        let leaning = ends.map(|body| self.leaning(body));
        let on = if leaning[0] == NONE { leaning[1] } else { leaning[0] };
        let [first, other] = ends.map(|body| if self.is_eliminated(body) { self.group(body) } else { NONE });
        let (kept, other) = if first == NONE { (other, first) } else { (first, other) };
        if other != NONE && other != kept {
            self.leans_on[other as usize] = NONE;
            self.grouped[other as usize] = kept;
        }
        if kept != NONE {
            self.leans_on[kept as usize] = on;
        }
    }

    /// Makes all of `own` neighbours of `other`, and takes `node` from them.
    fn join(&mut self, other: u32, own: &[u32], node: u32) {
        let list = &mut self.neighbours[other as usize];
        self.merged.clear();
        let (mut i, mut j) = (0, 0);
        while i < list.len() || j < own.len() {
            let next = match (list.get(i), own.get(j)) {
                (Some(&a), Some(&b)) => a.min(b),
                (Some(&a), None) => a,
                (None, Some(&b)) => b,
                (None, None) => break,
            };
            i += usize::from(list.get(i) == Some(&next));
            j += usize::from(own.get(j) == Some(&next));
            if next != other && next != node {
                self.merged.push(next);
            }
        }
        list.clear();
        list.extend_from_slice(&self.merged);
    }

    /// Lists the blocks below each node, and lays out its panel.
    fn list_blocks(&mut self) {
        let Self { eliminated, place, below, first_below, sizes, panels, .. } = self;
        let Panels { starts, heights, rows, length, .. } = panels;
        for list in [&mut *below, &mut *first_below, &mut *starts, &mut *heights, &mut *rows] {
            list.clear();
        }
        first_below.push(0);
        *length = 0;
        for (list, &size) in eliminated.iter_mut().zip(&*sizes) {
            list.sort_unstable_by_key(|&node| place[node as usize]);
            let mut height = u32::from(size);
            for &node in &*list {
                rows.push(height);
                height += u32::from(sizes[node as usize]);
            }
            below.extend_from_slice(list);
            first_below.push(below.len() as u32);
            starts.push(*length as u32);
            heights.push(height);
            *length += stride(usize::from(size)) * height as usize;
        }
    }

    fn list_runs(&mut self) {
        let mut runs = std::mem::take(&mut self.panels.runs);
        let mut firsts = std::mem::take(&mut self.panels.first_run);
        let first_row = |block: usize| self.panels.rows[block];
        runs.clear();
        firsts.clear();
        for node in 0..self.sizes.len() as u32 {
            let range = self.below_of(node);
            for column in range.clone() {
                let target = self.below[column];
                firsts.push(runs.len() as u32);
                let mut run = Run { from: first_row(column), to: 0, count: u32::from(self.sizes[target as usize]) };
                for block in column + 1..range.end {
                    let later = self.below[block];
                    let (to, count) = (first_row(self.find(later, target)), u32::from(self.sizes[later as usize]));
                    if run.to + run.count == to {
                        run.count += count;
                    } else {
                        runs.push(run);
                        run = Run { from: first_row(block), to, count };
                    }
                }
                runs.push(run);
            }
        }
        firsts.push(runs.len() as u32);
        (self.panels.runs, self.panels.first_run) = (runs, firsts);
    }
}
