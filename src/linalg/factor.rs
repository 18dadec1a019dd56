//! Sparse symmetric factorisation A = W Wᵀ in blocks (Cholesky), `f64`.
//!
//! A node is a group of rows that belong together, up to a number fixed by the [`BlockLayout`]; how many take part may change from one
//! factorisation to the next, the structure does not. Each diagonal block is kept as the inverse of its root, so that a solve is
//! products only.
//!
//! ```text
//! for each column k:   A_kk = L Lᵀ,   U_k = L⁻ᵀ,   W_ik = A_ik U_k,   A_ij −= W_ik W_jkᵀ   for all i ≥ j coupled to k
//! ```

use std::ops::Range;

use super::block::{self, Lanes, MAX_ROWS, ZERO, width};
use super::order::{EliminationOrder, minimum_degree};
use crate::platform::dispatched;

/// Where the blocks of a matrix of one structure are stored, in the order of elimination.
#[derive(Debug, Clone, Default)]
pub(crate) struct BlockLayout {
    /// Node at each place, and place of each node.
    order: Vec<u32>,
    place: Vec<u32>,
    /// Where the diagonal block of each node begins.
    diagonal: Vec<u32>,
    /// First coupling of the node at each place, and one past the last.
    first: Vec<u32>,
    /// Coupled node and start of its block, column by column, sorted by place.
    couplings: Vec<(u32, u32)>,
    /// Blocks that a column's elimination changes, in the order in which it does.
    targets: Vec<u32>,
    /// Lanes stored, and set aside while a column is eliminated.
    size: usize,
    scratch: usize,
    /// Multiplications of a factorisation at full capacity.
    pub work: u64,
}

impl BlockLayout {
    /// Lays out the factor of a matrix whose nodes usually have `expected` and at most `capacity` rows, and are coupled in these pairs
    /// (smaller number first, sorted, none twice); `None` when a factorisation would take more than `most_work` multiplications. Order and work
    /// follow from `weights`, rows that each node always may have: `capacity` may depend on what was there before.
    pub(crate) fn new(weights: &[u32], capacity: &[u32], pairs: &[(u32, u32)], most_work: u64) -> Option<Self> {
        let mut neighbors = vec![Vec::new(); capacity.len()];
        for &(a, b) in pairs {
            neighbors[a as usize].push(b);
            neighbors[b as usize].push(a);
        }
        neighbors.iter_mut().for_each(|list| list.sort_unstable());
        let EliminationOrder { order, coupled, work } = minimum_degree(neighbors, weights, most_work)?.postordered();
        let mut plan = Self { place: vec![0; order.len()], work, ..Self::default() };
        for (place, &node) in order.iter().enumerate() {
            plan.place[node as usize] = place as u32;
        }
        let rows = |node: u32| capacity[node as usize] as usize;
        let lanes_of = |from: u32, to: u32| rows(from) * width(rows(to));
        plan.diagonal = vec![0; capacity.len()];
        plan.first.push(0);
        for (&node, mut list) in order.iter().zip(coupled) {
            plan.diagonal[node as usize] = claim(&mut plan.size, lanes_of(node, node));
            list.sort_unstable_by_key(|&other| plan.place[other as usize]);
            let mut scratch = 0;
            for other in list {
                let start = claim(&mut plan.size, lanes_of(other, node));
                plan.couplings.push((other, start));
                plan.scratch = plan.scratch.max(scratch + lanes_of(node, other) + lanes_of(other, node));
                scratch += lanes_of(node, other);
            }
            plan.first.push(plan.couplings.len() as u32);
        }
        plan.order = order;
        plan.find_targets();
        Some(plan)
    }

    fn find_targets(&mut self) {
        let mut targets = Vec::new();
        for place in 0..self.order.len() {
            let column = self.column(place);
            for (i, &(upper, _)) in column.iter().enumerate() {
                for &(lower, _) in &column[i..] {
                    targets.push(self.block(lower, upper).expect("elimination couples all neighbours of a node").0);
                }
            }
        }
        self.targets = targets;
    }

    /// Nodes in the order of elimination.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Starts of the blocks that each column's elimination changes: one for each two couplings of it, in their order.
    pub(crate) fn targets(&self) -> &[u32] {
        &self.targets
    }

    /// Place of a node in the order of elimination.
    pub(crate) fn place(&self, node: u32) -> usize {
        self.place[node as usize] as usize
    }

    /// Nodes coupled to that at a place and eliminated later, and the starts of their blocks.
    pub(crate) fn column(&self, place: usize) -> &[(u32, u32)] {
        &self.couplings[self.first[place] as usize..self.first[place + 1] as usize]
    }

    /// Numbers of the factor.
    pub(crate) fn numbers(&self) -> usize {
        4 * self.size
    }

    /// Start of a node's diagonal block.
    pub(crate) fn diagonal(&self, node: usize) -> u32 {
        self.diagonal[node]
    }

    /// Start of the block that couples two nodes, and whether its rows are those of `b` instead of `a`.
    pub(crate) fn block(&self, a: u32, b: u32) -> Option<(u32, bool)> {
        if a == b {
            return Some((self.diagonal[a as usize], false));
        }
        let (early, late) = if self.place[a as usize] < self.place[b as usize] { (a, b) } else { (b, a) };
        let column = self.column(self.place[early as usize] as usize);
        let place = |node: u32| self.place[node as usize];
        let found = column.binary_search_by_key(&place(late), |&(node, _)| place(node)).ok()?;
        Some((column[found].1, late == b))
    }
}

fn claim(size: &mut usize, count: usize) -> u32 {
    let start = *size;
    *size += count;
    start as u32
}

/// Numbers of a matrix and then of its factor, laid out by a [`BlockLayout`]: blocks as in [`block`], each with as many columns as the
/// node eliminated first has rows now.
#[derive(Debug, Clone, Default)]
pub(crate) struct BlockFactor {
    values: Vec<Lanes>,
    /// Rows of each node now.
    rows: Vec<u32>,
    /// First lane of each node in vectors.
    starts: Vec<u32>,
    scratch: Vec<Lanes>,
    /// Pivots up to which a row has no multiplier, laid out as vectors.
    pub least: Vec<Lanes>,
    /// Whether all nodes have three rows.
    pub is_uniform: bool,
}

impl BlockFactor {
    /// Empties the matrix; `rows` of each node take part.
    pub(crate) fn start(&mut self, plan: &BlockLayout, rows: &[u32]) {
        self.values.resize(plan.size, ZERO);
        self.values.fill(ZERO);
        self.scratch.resize(plan.scratch, ZERO);
        self.rows.clear();
        self.rows.extend_from_slice(rows);
        self.starts.clear();
        let mut next = 0;
        for &rows in &self.rows {
            self.starts.push(next);
            next += width(rows as usize) as u32;
        }
        self.starts.push(next);
        self.least.clear();
        self.least.resize(next as usize, ZERO);
        self.is_uniform = self.rows.iter().all(|&rows| rows as usize == POINT);
    }

    /// Rows of a node now.
    #[inline(always)]
    pub(crate) fn rows(&self, node: usize) -> usize {
        self.rows[node] as usize
    }

    /// Lanes of a node in vectors.
    #[inline(always)]
    pub(crate) fn lanes(&self, node: usize) -> Range<usize> {
        self.starts[node] as usize..self.starts[node + 1] as usize
    }

    /// Lanes of a vector.
    pub(crate) fn len(&self) -> usize {
        self.starts.last().map_or(0, |&end| end as usize)
    }

    /// The numbers from the start of a block on.
    #[inline(always)]
    pub(crate) fn block(&self, start: u32) -> &[Lanes] {
        &self.values[start as usize..]
    }

    /// The same, to be written.
    #[inline(always)]
    pub(crate) fn block_mut(&mut self, start: u32) -> &mut [Lanes] {
        &mut self.values[start as usize..]
    }
}

dispatched!(
    /// Factorises in place.
    factorize, factorize_body, (factor: &mut BlockFactor, plan: &BlockLayout)
);

dispatched!(
    /// Solves A x = b in place.
    substitute, substitute_body, (factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes])
);

dispatched!(
    /// Solves L y = b in place, the first half of [`substitute`].
    substitute_forward, forward_body, (factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes])
);

dispatched!(
    /// Solves Lᵀ x = y in place, the second half of [`substitute`].
    substitute_back, back_body, (factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes])
);

/// Rows of every node where all have as many: joints that hold points, as in chains, trees and bridges.
pub(crate) const POINT: usize = 3;

#[inline(always)]
fn factorize_body(factor: &mut BlockFactor, plan: &BlockLayout) {
    if factor.is_uniform { factorize_points(factor, plan) } else { factorize_any(factor, plan) }
}

#[inline(always)]
fn substitute_body(factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes]) {
    forward_body(factor, plan, x);
    back_body(factor, plan, x);
}

#[inline(always)]
fn forward_body(factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes]) {
    if factor.is_uniform { forward_points(factor, plan, x) } else { forward_any(factor, plan, x) }
}

#[inline(always)]
fn back_body(factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes]) {
    if factor.is_uniform { back_points(factor, plan, x) } else { back_any(factor, plan, x) }
}

#[inline(always)]
fn factorize_points(factor: &mut BlockFactor, plan: &BlockLayout) {
    let BlockFactor { values, scratch, least, .. } = factor;
    let mut targets = plan.targets.iter();
    for (place, &node) in plan.order.iter().enumerate() {
        let diagonal = plan.diagonal[node as usize] as usize;
        block::invert_root(&mut values[diagonal..], POINT, &least[node as usize..]);
        let root = *block::block3(&values[diagonal..]);
        let column = plan.column(place);
        // The updates need the transposed beside W_ik.
        let kept = &mut scratch.as_chunks_mut::<POINT>().0[..column.len()];
        for (kept, &(_, start)) in kept.iter_mut().zip(column) {
            let a = block::block3_mut(&mut values[start as usize..]);
            *a = block::product3(a, &root);
            *kept = block::transposed3(a);
        }
        for (i, kept) in kept.iter().enumerate() {
            for (&(_, start), &target) in column[i..].iter().zip(&mut targets) {
                let l = *block::block3(&values[start as usize..]);
                let into = block::block3_mut(&mut values[target as usize..]);
                *into = block::minus_product3(into, &l, kept);
            }
        }
    }
}

#[inline(always)]
fn forward_points(factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes]) {
    for (place, &node) in plan.order.iter().enumerate() {
        let root = block::block3(&factor.values[plan.diagonal[node as usize] as usize..]);
        let own = block::columns3(root, &x[node as usize]);
        x[node as usize] = own;
        for &(other, start) in plan.column(place) {
            let into = &mut x[other as usize];
            *into = block::minus_rows3(into, block::block3(&factor.values[start as usize..]), &own);
        }
    }
}

#[inline(always)]
fn back_points(factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes]) {
    for (place, &node) in plan.order.iter().enumerate().rev() {
        let mut own = x[node as usize];
        for &(other, start) in plan.column(place) {
            let block = block::block3(&factor.values[start as usize..]);
            own = block::minus(&own, &block::columns3(block, &x[other as usize]));
        }
        x[node as usize] = block::rows3(block::block3(&factor.values[plan.diagonal[node as usize] as usize..]), &own);
    }
}

#[inline(always)]
fn factorize_any(factor: &mut BlockFactor, plan: &BlockLayout) {
    let BlockFactor { values, rows, scratch, starts, least, .. } = factor;
    let mut target = 0;
    for place in 0..plan.order.len() {
        let node = plan.order[place] as usize;
        let column = plan.column(place);
        let k = rows[node] as usize;
        if k == 0 {
            target += column.len() * (column.len() + 1) / 2;
            continue;
        }
        let (diagonal, wk) = (plan.diagonal[node] as usize, width(k));
        block::invert_root(&mut values[diagonal..], k, &least[starts[node] as usize..]);
        let mut from = 0;
        for &(other, start) in column {
            let (m, start) = (rows[other as usize] as usize, start as usize);
            let (early, late) = values.split_at_mut(start);
            let kept = &mut scratch[from + k * width(m)..];
            kept[..m * wk].copy_from_slice(&late[..m * wk]);
            block::set_product(&mut late[..m * wk], kept, &early[diagonal..diagonal + k * wk], m, k);
            block::transpose(&mut scratch[from..], &values[start..start + m * wk], m, k);
            from += k * width(m);
        }
        let mut from = 0;
        for (i, &(upper, _)) in column.iter().enumerate() {
            let n = rows[upper as usize] as usize;
            for &(lower, start) in &column[i..] {
                let (m, start) = (rows[lower as usize] as usize, start as usize);
                let into = plan.targets[target] as usize;
                target += 1;
                if m == 0 || n == 0 {
                    continue;
                }
                // Columns are stored one after another and a target belongs to a later one, or is diagonal.
                let [from_block, into_block] = disjoint(values, start, m * wk, into, m * width(n));
                block::subtract_product(into_block, from_block, &scratch[from..from + k * width(n)], m, k, n);
            }
            from += k * width(n);
        }
    }
}

#[inline(always)]
fn forward_any(factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes]) {
    let mut own = [ZERO; width(MAX_ROWS)];
    for (place, &node) in plan.order.iter().enumerate() {
        let lanes = factor.lanes(node as usize);
        if lanes.is_empty() {
            continue;
        }
        let own = &mut own[..lanes.len()];
        own.fill(ZERO);
        let root = &factor.values[plan.diagonal[node as usize] as usize..];
        block::add_columns(own, root, &x[lanes.clone()], factor.rows(node as usize), 1.0);
        block::copy(&mut x[lanes], own);
        for &(other, start) in plan.column(place) {
            let into = &mut x[factor.lanes(other as usize)];
            block::subtract_rows(into, &factor.values[start as usize..], own, factor.rows(other as usize));
        }
    }
}

#[inline(always)]
fn back_any(factor: &BlockFactor, plan: &BlockLayout, x: &mut [Lanes]) {
    let mut own = [ZERO; width(MAX_ROWS)];
    for (place, &node) in plan.order.iter().enumerate().rev() {
        let lanes = factor.lanes(node as usize);
        if lanes.is_empty() {
            continue;
        }
        let own = &mut own[..lanes.len()];
        block::copy(own, &x[lanes.clone()]);
        for &(other, start) in plan.column(place) {
            let from = &x[factor.lanes(other as usize)];
            block::add_columns(own, &factor.values[start as usize..], from, factor.rows(other as usize), -1.0);
        }
        let root = &factor.values[plan.diagonal[node as usize] as usize..];
        block::set_rows(&mut x[lanes], root, own, factor.rows(node as usize));
    }
}

#[inline(always)]
fn disjoint(values: &mut [Lanes], a: usize, a_len: usize, b: usize, b_len: usize) -> [&mut [Lanes]; 2] {
    if a < b {
        let (low, high) = values.split_at_mut(b);
        [&mut low[a..a + a_len], &mut high[..b_len]]
    } else {
        let (low, high) = values.split_at_mut(a);
        [&mut high[..a_len], &mut low[b..b + b_len]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::noise::Noise;
    use crate::platform::with_baseline;

    #[test]
    fn a_random_block_system_is_solved_to_rounding() {
        let mut noise = Noise(7);
        let rows = [3_u32, 5, 6, 2, 0, 7, 3, 3, 3, 6];
        let capacity = rows.map(|rows| rows + 2);
        let pairs: Vec<(u32, u32)> = vec![(0, 1), (0, 4), (1, 2), (1, 7), (2, 3), (3, 9), (4, 5), (5, 6), (6, 7), (7, 8), (8, 9)];
        let plan = BlockLayout::new(&capacity, &capacity, &pairs, u64::MAX).expect("no limit is set");
        let mut factor = BlockFactor::default();
        factor.start(&plan, &rows);
        let total = 4 * factor.len();
        let mut dense = vec![vec![0.0; total]; total];
        for &(a, b) in pairs.iter().chain(&(0..10).map(|node| (node, node)).collect::<Vec<_>>()) {
            let (start, swapped) = plan.block(a, b).expect("the pair is in the structure");
            let (row_node, column_node) = if a == b || !swapped { (a, b) } else { (b, a) };
            for i in 0..rows[row_node as usize] as usize {
                for j in 0..rows[column_node as usize] as usize {
                    if a == b && j > i {
                        continue;
                    }
                    let value = noise.next() + if a == b && i == j { 12.0 } else { 0.0 };
                    let [r, c] = [(row_node, i), (column_node, j)].map(|(node, i)| 4 * factor.lanes(node as usize).start + i);
                    (dense[r][c], dense[c][r]) = (value, value);
                    let columns = width(rows[column_node as usize] as usize);
                    factor.block_mut(start)[i * columns + j / 4][j % 4] = value;
                    if a == b {
                        factor.block_mut(start)[j * columns + i / 4][i % 4] = value;
                    }
                }
            }
        }
        let is_row = |at: usize| dense[at][at] != 0.0;
        let expected: Vec<f64> = (0..total).map(|at| if is_row(at) { noise.next() } else { 0.0 }).collect();
        let image = |row: &Vec<f64>| row.iter().zip(&expected).map(|(a, b)| a * b).sum::<f64>();
        let flat: Vec<f64> = dense.iter().map(image).collect();
        let mut x = flat.as_chunks::<4>().0.to_vec();
        let (mut plain, mut plain_x) = (factor.clone(), x.clone());
        factorize(&mut factor, &plan);
        substitute(&factor, &plan, &mut x);
        with_baseline(|| {
            factorize(&mut plain, &plan);
            substitute(&plain, &plan, &mut plain_x);
        });
        assert_eq!(x, plain_x, "wide registers give other bits");
        let worst = x.iter().flatten().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1.0e-13, "the worst error is {worst:e}");
    }
}
