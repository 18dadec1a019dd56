//! Order of elimination: minimum degree, weighted by rows, and the structure of the factor that follows from it.
//!
//! Eliminating a node joins its neighbours to one another; the node whose neighbours have the fewest rows goes first (Tinney and
//! Walker 1967, scheme 2). On a chain or a tree no two nodes are ever joined anew; on a bridge the factor has about twice the
//! blocks of the matrix. Ties go to the lowest number, so the order depends on the graph alone.

/// Nodes in the order of elimination, and the nodes that each is coupled to when its turn comes.
#[derive(Debug, Clone, Default)]
pub(crate) struct EliminationOrder {
    /// Node at each place.
    pub order: Vec<u32>,
    /// Later nodes coupled to the node at each place.
    pub coupled: Vec<Vec<u32>>,
    /// Multiplications of a numeric factorisation.
    pub work: u64,
}

/// Orders the nodes of a graph given by neighbour lists; `None` when the factor would cost more than `most_work`.
pub(crate) fn minimum_degree(neighbors: Vec<Vec<u32>>, rows: &[u32], most_work: u64) -> Option<EliminationOrder> {
    let mut graph = Quotient::new(neighbors, rows);
    let mut queue = Queue::new(graph.neighbors.iter().map(|list| graph.weigh(list).rows));
    let mut result = EliminationOrder::default();
    while let Some((degree, node)) = queue.first() {
        let own = u64::from(rows[node as usize]);
        result.work += own * (own + degree) * (own + degree);
        if result.work > most_work {
            return None;
        }
        queue.remove(node);
        graph.eliminate(node, |other, degree| queue.set(other, degree));
        result.order.push(node);
    }
    result.coupled = result.order.iter().map(|&node| std::mem::take(&mut graph.coupled[node as usize])).collect();
    Some(result)
}

impl EliminationOrder {
    /// The same factor in another order: each node right after those that change its column, its subtree in the tree in which the parent of
    /// a node is the first that it is coupled to (Liu 1990). What has just been computed is what comes next.
    pub(crate) fn postordered(mut self) -> Self {
        let mut place = vec![0; self.order.len()];
        for (at, &node) in self.order.iter().enumerate() {
            place[node as usize] = at;
        }
        let mut children = vec![Vec::new(); self.order.len()];
        let mut open = Vec::new();
        for (at, coupled) in self.coupled.iter().enumerate() {
            match coupled.iter().map(|&other| place[other as usize]).min() {
                Some(parent) => children[parent].push(at),
                None => open.push(at),
            }
        }
        // From the last node back: each before its subtree.
        let mut places = Vec::with_capacity(self.order.len());
        while let Some(at) = open.pop() {
            places.push(at);
            open.append(&mut children[at]);
        }
        places.reverse();
        self.order = places.iter().map(|&at| self.order[at]).collect();
        self.coupled = places.iter().map(|&at| std::mem::take(&mut self.coupled[at])).collect();
        self
    }
}

/// Nodes by degree, then by number: a binary tree of which each node is the lesser of its two below, with the nodes of the graph as
/// leaves. Degrees change far more often than the least of all is asked for.
struct Queue {
    tree: Vec<(u64, u32)>,
    leaves: usize,
}

impl Queue {
    const NOTHING: (u64, u32) = (u64::MAX, NONE);

    fn new(degrees: impl ExactSizeIterator<Item = u64>) -> Self {
        let leaves = degrees.len().next_power_of_two();
        let mut tree = vec![Self::NOTHING; leaves];
        tree.extend(degrees.zip(0..));
        tree.resize(2 * leaves, Self::NOTHING);
        for at in (1..leaves).rev() {
            tree[at] = tree[2 * at].min(tree[2 * at + 1]);
        }
        Self { tree, leaves }
    }

    /// The node of least degree.
    fn first(&self) -> Option<(u64, u32)> {
        Some(self.tree[1]).filter(|first| *first != Self::NOTHING)
    }

    fn set(&mut self, node: u32, degree: u64) {
        self.put(node, (degree, node));
    }

    fn remove(&mut self, node: u32) {
        self.put(node, Self::NOTHING);
    }

    fn put(&mut self, node: u32, leaf: (u64, u32)) {
        let mut at = self.leaves + node as usize;
        let mut least = leaf;
        while std::mem::replace(&mut self.tree[at], least) != least && at > 1 {
            least = least.min(self.tree[at ^ 1]);
            at /= 2;
        }
    }
}

/// How many nodes, and how many rows they have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct CliqueSize {
    nodes: u32,
    rows: u64,
}

/// What is left of a graph while its nodes are eliminated, as a *quotient graph* (George and Liu 1980): an eliminated node, an
/// *element* by then, stands for all couplings among its neighbours, and these are never written out one by one. Degrees are exact.
struct Quotient<'a> {
    rows: &'a [u32],
    /// Neighbours of each node by couplings of the matrix that no element of the node stands for.
    neighbors: Vec<Vec<u32>>,
    /// Elements that each node is a neighbour of, but those that add nothing to another.
    elements: Vec<Vec<u32>>,
    /// Neighbours of each element, and what they weigh. As long as the element is one of theirs, none of them has been eliminated.
    coupled: Vec<Vec<u32>>,
    weight: Vec<CliqueSize>,
    /// Of each element: the last one that it was set against, and what its neighbours weigh that are not that one's too.
    against: Vec<u32>,
    outside: Vec<CliqueSize>,
    /// The last element that each node was found to be a neighbour of.
    within: Vec<u32>,
    /// The round in which each node was counted last.
    counted: Vec<u32>,
    round: u32,
}

/// Number of no node.
const NONE: u32 = u32::MAX;

impl<'a> Quotient<'a> {
    fn new(neighbors: Vec<Vec<u32>>, rows: &'a [u32]) -> Self {
        let count = rows.len();
        Self {
            rows,
            neighbors,
            elements: vec![Vec::new(); count],
            coupled: vec![Vec::new(); count],
            weight: vec![CliqueSize::default(); count],
            against: vec![NONE; count],
            outside: vec![CliqueSize::default(); count],
            within: vec![NONE; count],
            counted: vec![0; count],
            round: 0,
        }
    }

    fn weigh(&self, nodes: &[u32]) -> CliqueSize {
        let rows = nodes.iter().map(|&node| u64::from(self.rows[node as usize])).sum();
        CliqueSize { nodes: nodes.len() as u32, rows }
    }

    /// Takes a node out, and tells of each of its neighbours how many rows the neighbours of that one have from now on.
    fn eliminate(&mut self, node: u32, mut tell: impl FnMut(u32, u64)) {
        let absorbed = std::mem::take(&mut self.elements[node as usize]);
        let own = self.find_neighbors(node, &absorbed);
        let weight = self.weigh(&own);
        for &other in &own {
            self.elements[other as usize].retain(|element| !absorbed.contains(element));
            let Self { elements, neighbors, within, against, outside, weight, rows, .. } = self;
            neighbors[other as usize].retain(|&neighbor| neighbor != node && within[neighbor as usize] != node);
            for element in elements[other as usize].iter().map(|&element| element as usize) {
                if std::mem::replace(&mut against[element], node) != node {
                    outside[element] = weight[element];
                }
                outside[element].nodes -= 1;
                outside[element].rows -= u64::from(rows[other as usize]);
            }
        }
        for &other in &own {
            let Self { elements, outside, .. } = self;
            elements[other as usize].retain(|&element| outside[element as usize].nodes > 0);
            let beyond = self.rows_beyond(other, node);
            self.elements[other as usize].push(node);
            tell(other, weight.rows - u64::from(self.rows[other as usize]) + beyond);
        }
        (self.coupled[node as usize], self.weight[node as usize]) = (own, weight);
    }

    /// Neighbours of a node that is in these elements.
    fn find_neighbors(&mut self, node: u32, elements: &[u32]) -> Vec<u32> {
        let mut found = std::mem::take(&mut self.neighbors[node as usize]);
        found.iter().for_each(|&other| self.within[other as usize] = node);
        self.within[node as usize] = node;
        for &element in elements {
            for &other in &self.coupled[element as usize] {
                if std::mem::replace(&mut self.within[other as usize], node) != node {
                    found.push(other);
                }
            }
        }
        found
    }

    /// Rows of the neighbours of `node` that are not neighbours of `element`, the newest one. What is coupled through one of its elements
    /// is not listed as coupled by the matrix, but may be coupled through another.
    fn rows_beyond(&mut self, node: u32, element: u32) -> u64 {
        let by_matrix = self.weigh(&self.neighbors[node as usize]).rows;
        let Self { elements, coupled, outside, within, counted, round, rows, .. } = self;
        by_matrix
            + match elements[node as usize][..] {
                [] => 0,
                [only] => outside[only as usize].rows,
                ref several => {
                    *round += 1;
                    let around = several.iter().flat_map(|&other| &coupled[other as usize]).map(|&node| node as usize);
                    let beyond = around.filter(|&node| within[node] != element);
                    beyond
                        .filter(|&node| std::mem::replace(&mut counted[node], *round) != *round)
                        .map(|node| u64::from(rows[node]))
                        .sum()
                }
            }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_tree_is_eliminated_without_fill() {
        // A chain of 0..10 with a branch of 10..14 at node 4.
        let mut neighbors = vec![Vec::new(); 15];
        let mut join = |a: u32, b: u32| {
            neighbors[a as usize].push(b);
            neighbors[b as usize].push(a);
        };
        (0..9).for_each(|node| join(node, node + 1));
        join(4, 10);
        (10..14).for_each(|node| join(node, node + 1));
        neighbors.iter_mut().for_each(|list| list.sort_unstable());
        let elimination = minimum_degree(neighbors, &[3; 15], u64::MAX).expect("no limit is set");
        let blocks: usize = elimination.coupled.iter().map(Vec::len).sum();
        assert_eq!(blocks, 14, "a tree of 15 nodes has 14 edges and its factor as many blocks");
    }

    /// The same with all couplings written out.
    fn written_out(mut neighbors: Vec<BTreeSet<u32>>, rows: &[u32]) -> (Vec<u32>, Vec<BTreeSet<u32>>) {
        let mut left: BTreeSet<u32> = (0..rows.len() as u32).collect();
        let (mut order, mut coupled) = (Vec::new(), Vec::new());
        while let Some(&node) = left.iter().min_by_key(|&&node| {
            let degree: u32 = neighbors[node as usize].iter().map(|&other| rows[other as usize]).sum();
            (degree, node)
        }) {
            left.remove(&node);
            let own = std::mem::take(&mut neighbors[node as usize]);
            for &other in &own {
                neighbors[other as usize].extend(own.iter().filter(|&&third| third != other));
                neighbors[other as usize].remove(&node);
            }
            order.push(node);
            coupled.push(own);
        }
        (order, coupled)
    }

    proptest! {
        #[test]
        fn a_quotient_graph_is_eliminated_as_one_that_is_written_out(
            pairs in prop::collection::vec((0..40_u32, 0..40_u32), 0..120),
            rows in prop::collection::vec(0..7_u32, 40),
        ) {
            let mut sets = vec![BTreeSet::new(); 40];
            for (a, b) in pairs.into_iter().filter(|(a, b)| a != b) {
                sets[a as usize].insert(b);
                sets[b as usize].insert(a);
            }
            let lists = sets.iter().map(|set| set.iter().copied().collect()).collect();
            let found = minimum_degree(lists, &rows, u64::MAX).expect("no limit is set");
            let (order, coupled) = written_out(sets, &rows);
            prop_assert_eq!(found.order, order);
            let found: Vec<BTreeSet<u32>> = found.coupled.into_iter().map(|list| list.into_iter().collect()).collect();
            prop_assert_eq!(found, coupled);
        }
    }

    #[test]
    fn work_beyond_the_limit_is_refused() {
        let complete: Vec<Vec<u32>> = (0..30).map(|i| (0..30).filter(|&j| j != i).collect()).collect();
        assert!(minimum_degree(complete.clone(), &[3; 30], 10_000).is_none());
        assert!(minimum_degree(complete, &[3; 30], 1_000_000).is_some());
    }
}
