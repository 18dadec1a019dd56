//! Order of elimination: minimum degree, weighted by rows, and the structure of the factor that follows from it.
//!
//! Eliminating a node joins its neighbours to one another; the node whose neighbours have the fewest rows goes first (Tinney and
//! Walker 1967, scheme 2). On a chain or a tree no two nodes are ever joined anew; on a bridge the factor has about twice the
//! blocks of the matrix. Ties go to the lowest number, so the order depends on the graph alone.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Nodes in the order of elimination, and the nodes that each is coupled to when its turn comes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Elimination {
    /// Node at each place.
    pub order: Vec<u32>,
    /// Later nodes coupled to the node at each place.
    pub coupled: Vec<Vec<u32>>,
    /// Multiplications of a numeric factorisation.
    pub work: u64,
}

/// Orders the nodes of a graph given by sorted neighbour lists; `None` when the factor would cost more than `most_work`.
pub(crate) fn minimum_degree(mut neighbors: Vec<Vec<u32>>, rows: &[u32], most_work: u64) -> Option<Elimination> {
    let degree = |list: &[u32]| list.iter().map(|&node| u64::from(rows[node as usize])).sum::<u64>();
    let mut queue: BinaryHeap<Reverse<(u64, u32)>> =
        neighbors.iter().zip(0..).map(|(list, node)| Reverse((degree(list), node))).collect();
    let mut current: Vec<u64> = neighbors.iter().map(|list| degree(list)).collect();
    let mut done = vec![false; rows.len()];
    let mut result = Elimination::default();
    while let Some(Reverse((queued, node))) = queue.pop() {
        if done[node as usize] || queued != current[node as usize] {
            continue;
        }
        done[node as usize] = true;
        let own = u64::from(rows[node as usize]);
        result.work += own * (own + queued) * (own + queued);
        if result.work > most_work {
            return None;
        }
        let list = std::mem::take(&mut neighbors[node as usize]);
        for &other in &list {
            let joined = union_without(&neighbors[other as usize], &list, [node, other]);
            neighbors[other as usize] = joined;
            current[other as usize] = degree(&neighbors[other as usize]);
            queue.push(Reverse((current[other as usize], other)));
        }
        result.order.push(node);
        result.coupled.push(list);
    }
    Some(result)
}

/// Union of two sorted lists, less two members.
fn union_without(a: &[u32], b: &[u32], without: [u32; 2]) -> Vec<u32> {
    let mut union = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let next = match (a.get(i), b.get(j)) {
            (Some(&x), Some(&y)) => x.min(y),
            (Some(&x), None) => x,
            (None, Some(&y)) => y,
            (None, None) => break,
        };
        i += usize::from(a.get(i) == Some(&next));
        j += usize::from(b.get(j) == Some(&next));
        if !without.contains(&next) {
            union.push(next);
        }
    }
    union
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn work_beyond_the_limit_is_refused() {
        let complete: Vec<Vec<u32>> = (0..30).map(|i| (0..30).filter(|&j| j != i).collect()).collect();
        assert!(minimum_degree(complete.clone(), &[3; 30], 10_000).is_none());
        assert!(minimum_degree(complete, &[3; 30], 1_000_000).is_some());
    }
}
