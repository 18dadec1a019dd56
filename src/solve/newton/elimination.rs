//! The order in which bodies and joints are eliminated, and which blocks of the factor that fills.
//!
//! Nodes are bodies, of six unknowns each, and joints, of one for each row. A joint's own block is −ε, next to nothing, until one of its
//! bodies has been eliminated. What is eliminated answers then as if all other bodies were fixed: two joints of one body that has gone
//! before both its neighbours hold it twice along the line between them, and the second has a pivot of −ε, though neither is redundant. So what
//! has been eliminated together leans on one other body at most, as a rigid body does on one that is fixed, which adds nothing to what
//! it holds within itself; the world counts as a body that is never eliminated. No pivot is smaller then than the rows are independent.
//! Among what is eligible joints go before bodies, then the node with the fewest neighbours (minimum degree), the lowest number among equals.

/// Unknowns of a body, and the most of a joint.
pub(crate) const WIDTH: usize = 6;

/// Neighbours that a node has room for from the first: those of nodes change as near pairs do, and that takes no memory then.
const ROOM: usize = 32;

/// One product that the elimination of a node subtracts: `rows` and `columns` are blocks below it, `target` is a block or, from the
/// number of blocks on, a diagonal one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Update {
    pub rows: u32,
    pub columns: u32,
    pub target: u32,
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
    /// First product of each place, and one more.
    pub first_update: Vec<u32>,
    pub updates: Vec<Update>,
    /// Multiplications of a factorisation.
    pub work: u64,
    neighbours: Vec<Vec<u32>>,
    eliminated: Vec<Vec<u32>>,
    /// Bodies of each joint: the second may be the world.
    ends: Vec<[u32; 2]>,
    /// Groups of bodies that eliminated joints connect, by one of each, and what body each group leans on.
    grouped: Vec<u32>,
    leans_on: Vec<u32>,
    merged: Vec<u32>,
}

/// No body, and the one that is never eliminated.
const NONE: u32 = u32::MAX;
const WORLD: u32 = u32::MAX - 1;

impl Elimination {
    /// Finds the structure for nodes of these sizes, the first of which are bodies, and these edges, which must be sorted, without
    /// repeats, lower node first. Does nothing where they are those of the last time.
    pub(crate) fn prepare(&mut self, bodies: usize, sizes: &[u8], edges: &[[u32; 2]]) {
        if self.bodies == bodies && self.sizes == sizes && self.edges == edges {
            return;
        }
        self.bodies = bodies;
        self.sizes.clear();
        self.sizes.extend_from_slice(sizes);
        self.edges.clear();
        self.edges.extend_from_slice(edges);
        self.find_order();
        self.list_blocks();
        self.list_updates();
    }

    pub(crate) fn node_count(&self) -> usize {
        self.sizes.len()
    }

    pub(crate) fn block_count(&self) -> usize {
        self.below.len()
    }

    /// Block of two nodes that rows connect, and whether its rows are those of `a`.
    pub(crate) fn block(&self, a: u32, b: u32) -> (usize, bool) {
        let a_is_later = self.place[a as usize] > self.place[b as usize];
        let (later, earlier) = if a_is_later { (a, b) } else { (b, a) };
        (self.find(later, earlier), a_is_later)
    }

    fn find(&self, later: u32, earlier: u32) -> usize {
        let range = self.below_of(earlier);
        let place = |node: u32| self.place[node as usize];
        range.start + self.below[range].partition_point(|&node| place(node) < place(later))
    }

    /// Blocks below a node.
    pub(crate) fn below_of(&self, node: u32) -> std::ops::Range<usize> {
        self.first_below[node as usize] as usize..self.first_below[node as usize + 1] as usize
    }

    fn find_order(&mut self) {
        let count = self.sizes.len();
        for lists in [&mut self.neighbours, &mut self.eliminated] {
            lists.resize_with(count.max(lists.len()), || Vec::with_capacity(ROOM));
            lists.iter_mut().for_each(Vec::clear);
        }
        for &[a, b] in &self.edges {
            self.neighbours[a as usize].push(b);
            self.neighbours[b as usize].push(a);
        }
        self.neighbours.iter_mut().for_each(|list| list.sort_unstable());
        self.ends.clear();
        self.ends.extend(self.neighbours[self.bodies..count].iter().map(|bodies| match bodies[..] {
            [a, b] => [a, b],
            [a] => [a, WORLD],
            _ => [WORLD, WORLD],
        }));
        self.grouped.clear();
        self.grouped.extend(0..self.bodies as u32);
        self.leans_on.clear();
        self.leans_on.resize(self.bodies, NONE);
        self.order.clear();
        self.place.clear();
        self.place.resize(count, u32::MAX);
        while self.order.len() < count {
            let node = self.next_node();
            self.place[node as usize] = self.order.len() as u32;
            self.order.push(node);
            self.connect(node);
            let own = std::mem::take(&mut self.neighbours[node as usize]);
            for &other in &own {
                self.join(other, &own, node);
            }
            let kept = &mut self.eliminated[node as usize];
            kept.extend_from_slice(&own);
            self.neighbours[node as usize] = own;
            self.neighbours[node as usize].clear();
        }
    }

    fn is_eliminated(&self, body: u32) -> bool {
        body != WORLD && self.place[body as usize] != u32::MAX
    }

    /// What one end of a joint leans on, were the joint eliminated now: the body itself where it is not.
    fn leaning(&self, body: u32) -> u32 {
        if self.is_eliminated(body) { self.leans_on[self.grouped[body as usize] as usize] } else { body }
    }

    /// Puts the bodies of one group into another.
    fn regroup(&mut self, from: u32, to: u32) {
        self.leans_on[from as usize] = NONE;
        self.grouped.iter_mut().filter(|group| **group == from).for_each(|group| *group = to);
    }

    /// Whether a node may be eliminated: of joints, one that leaves what has been eliminated leaning on no more than one body.
    fn is_eligible(&self, node: usize) -> bool {
        let Some(joint) = node.checked_sub(self.bodies) else { return true };
        let ends = self.ends[joint];
        let [a, b] = ends.map(|body| self.leaning(body));
        ends.iter().any(|&body| self.is_eliminated(body)) && (a == b || a == NONE || b == NONE)
    }

    /// Notes what an eliminated node connects.
    fn connect(&mut self, node: u32) {
        let Some(joint) = (node as usize).checked_sub(self.bodies) else {
            // What leans on a body that is eliminated goes with it.
            for group in 0..self.bodies as u32 {
                if self.leans_on[group as usize] == node {
                    self.regroup(group, node);
                }
            }
            return;
        };
        let ends = self.ends[joint];
        let leaning = ends.map(|body| self.leaning(body));
        let on = if leaning[0] == NONE { leaning[1] } else { leaning[0] };
        let [first, other] = ends.map(|body| if self.is_eliminated(body) { self.grouped[body as usize] } else { NONE });
        let (kept, other) = if first == NONE { (other, first) } else { (first, other) };
        if other != NONE && other != kept {
            self.regroup(other, kept);
        }
        if kept != NONE {
            self.leans_on[kept as usize] = on;
        }
    }

    /// The node to eliminate next: a joint that is eligible before any body, the one with the fewest neighbours of either.
    fn next_node(&self) -> u32 {
        let weight = |node: usize| {
            let size: usize = self.neighbours[node].iter().map(|&other| usize::from(self.sizes[other as usize])).sum();
            (node < self.bodies, size)
        };
        let left = || (0..self.sizes.len()).filter(|&node| self.place[node] == u32::MAX);
        let best = left().filter(|&node| self.is_eligible(node)).min_by_key(|&node| weight(node));
        // A joint between what does not move has no neighbour that could make it eligible.
        best.or_else(|| left().next()).expect("nodes are left") as u32
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

    fn list_blocks(&mut self) {
        let Self { eliminated, place, below, first_below, sizes, .. } = self;
        below.clear();
        first_below.clear();
        first_below.push(0);
        for list in &mut eliminated[..sizes.len()] {
            list.sort_unstable_by_key(|&node| place[node as usize]);
            below.extend_from_slice(list);
            first_below.push(below.len() as u32);
        }
    }

    fn list_updates(&mut self) {
        let mut updates = std::mem::take(&mut self.updates);
        let mut firsts = std::mem::take(&mut self.first_update);
        updates.clear();
        firsts.clear();
        firsts.push(0);
        self.work = 0;
        let size = |node: u32| u64::from(self.sizes[node as usize]);
        let mut work = 0;
        for &node in &self.order {
            let range = self.below_of(node);
            work += size(node).pow(3);
            for rows in range.clone() {
                work += size(node).pow(2) * size(self.below[rows]);
                for columns in range.start..=rows {
                    let (i, j) = (self.below[rows], self.below[columns]);
                    work += size(i) * size(j) * size(node);
                    let target = if i == j { self.below.len() as u32 + i } else { self.find(i, j) as u32 };
                    updates.push(Update { rows: rows as u32, columns: columns as u32, target });
                }
            }
            firsts.push(updates.len() as u32);
        }
        self.work = work;
        (self.updates, self.first_update) = (updates, firsts);
    }
}
