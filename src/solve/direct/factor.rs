//! Sparse symmetric factorisation A = L D Lᵀ in blocks, `f64`.
//!
//! A node is a group of rows that belong together, up to a number fixed by the [`Plan`]; how many take part may change from one
//! factorisation to the next, the structure does not. D⁻¹ is formed block by block, so that a solve is products only.
//!
//! ```text
//! for each column k:   D_k = A_kk,   L_ik = A_ik D_k⁻¹,   A_ij −= L_ik A_jkᵀ   for all i ≥ j coupled to k
//! ```

use super::order::{Elimination, minimum_degree};

/// Where the blocks of a matrix of one structure are stored, in the order of elimination.
#[derive(Debug, Clone, Default)]
pub(crate) struct Plan {
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
    /// Numbers stored.
    size: usize,
    /// Multiplications of a factorisation at full capacity.
    pub work: u64,
}

impl Plan {
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
        let Elimination { order, coupled, work } = minimum_degree(neighbors, weights, most_work)?;
        let mut plan = Self { place: vec![0; order.len()], work, ..Self::default() };
        for (place, &node) in order.iter().enumerate() {
            plan.place[node as usize] = place as u32;
        }
        let rows = |node: u32| capacity[node as usize] as usize;
        plan.diagonal = capacity.iter().map(|&rows| claim(&mut plan.size, (rows * rows) as usize)).collect();
        plan.first.push(0);
        for (&node, mut list) in order.iter().zip(coupled) {
            list.sort_unstable_by_key(|&other| plan.place[other as usize]);
            for other in list {
                let start = claim(&mut plan.size, rows(node) * rows(other));
                plan.couplings.push((other, start));
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

    fn column(&self, place: usize) -> &[(u32, u32)] {
        &self.couplings[self.first[place] as usize..self.first[place + 1] as usize]
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

/// Numbers of a matrix and then of its factor, laid out by a [`Plan`]: blocks row by row, each with as many columns as the node
/// eliminated first has rows now.
#[derive(Debug, Clone, Default)]
pub(crate) struct Factor {
    values: Vec<f64>,
    /// Rows of each node now.
    rows: Vec<u32>,
    /// First row of each node in vectors.
    starts: Vec<u32>,
    scratch: Vec<f64>,
}

/// A pivot this much smaller than the diagonal was before elimination is noise.
const SINGULAR: f64 = 1.0e-14;

impl Factor {
    /// Empties the matrix; `rows` of each node take part.
    pub(crate) fn start(&mut self, plan: &Plan, rows: impl Iterator<Item = u32>) {
        self.values.clear();
        self.values.resize(plan.size, 0.0);
        self.rows.clear();
        self.rows.extend(rows);
        self.starts.clear();
        let mut next = 0;
        for &rows in &self.rows {
            self.starts.push(next);
            next += rows;
        }
        self.starts.push(next);
    }

    /// First row of a node in vectors.
    pub(crate) fn start_of(&self, node: usize) -> usize {
        self.starts[node] as usize
    }

    /// The numbers from the start of a block on.
    pub(crate) fn block_mut(&mut self, start: u32) -> &mut [f64] {
        &mut self.values[start as usize..]
    }

    /// Factorises in place.
    pub(crate) fn factorize(&mut self, plan: &Plan) {
        let mut target = 0;
        for place in 0..plan.order.len() {
            let node = plan.order[place] as usize;
            let column = plan.column(place);
            let k = self.rows[node] as usize;
            if k == 0 {
                target += column.len() * (column.len() + 1) / 2;
                continue;
            }
            let diagonal = plan.diagonal[node] as usize;
            invert(&mut self.values[diagonal..diagonal + k * k], k);
            // A_ik is kept aside, as the updates need it beside L_ik.
            self.scratch.clear();
            for &(other, start) in column {
                let (m, start) = (self.rows[other as usize] as usize, start as usize);
                let from = self.scratch.len();
                self.scratch.extend_from_slice(&self.values[start..start + m * k]);
                let (before, after) = self.values.split_at_mut(start);
                after[..m * k].fill(0.0);
                // The inverse is symmetric: its rows are its columns.
                add_product(&mut after[..m * k], &self.scratch[from..], &before[diagonal..diagonal + k * k], m, k, k, 1.0);
            }
            let mut from = 0;
            for (i, &(upper, _)) in column.iter().enumerate() {
                let n = self.rows[upper as usize] as usize;
                for &(lower, start) in &column[i..] {
                    let m = self.rows[lower as usize] as usize;
                    let into = plan.targets[target] as usize;
                    target += 1;
                    let start = start as usize;
                    // Columns are stored one after another and a target belongs to a later one, or is diagonal.
                    let [from_block, into_block] = disjoint(&mut self.values, start, m * k, into, m * n);
                    add_product(into_block, from_block, &self.scratch[from..from + n * k], m, n, k, -1.0);
                }
                from += n * k;
            }
        }
    }

    /// Solves A x = b in place.
    pub(crate) fn solve(&self, plan: &Plan, x: &mut [f64]) {
        let range = |node: u32| self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize;
        let mut own = [0.0; MAX_ROWS];
        for (place, &node) in plan.order.iter().enumerate() {
            let k = range(node).len();
            own[..k].copy_from_slice(&x[range(node)]);
            for &(other, start) in plan.column(place) {
                let block = &self.values[start as usize..];
                for (row, value) in x[range(other)].iter_mut().enumerate() {
                    *value -= dot(&block[row * k..row * k + k], &own[..k]);
                }
            }
        }
        for (place, &node) in plan.order.iter().enumerate().rev() {
            let k = range(node).len();
            own[..k].copy_from_slice(&x[range(node)]);
            let inverse = &self.values[plan.diagonal[node as usize] as usize..];
            let mut sum = [0.0; MAX_ROWS];
            for (row, value) in sum[..k].iter_mut().enumerate() {
                *value = dot(&inverse[row * k..row * k + k], &own[..k]);
            }
            for &(other, start) in plan.column(place) {
                let block = &self.values[start as usize..];
                for (row, &value) in x[range(other)].iter().enumerate() {
                    for (sum, entry) in sum[..k].iter_mut().zip(&block[row * k..row * k + k]) {
                        *sum -= entry * value;
                    }
                }
            }
            x[range(node)].copy_from_slice(&sum[..k]);
        }
    }
}

/// Most rows of a node.
pub(crate) const MAX_ROWS: usize = 24;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

fn disjoint(values: &mut [f64], a: usize, a_len: usize, b: usize, b_len: usize) -> [&mut [f64]; 2] {
    if a < b {
        let (low, high) = values.split_at_mut(b);
        [&mut low[a..a + a_len], &mut high[..b_len]]
    } else {
        let (low, high) = values.split_at_mut(a);
        [&mut high[..a_len], &mut low[b..b + b_len]]
    }
}

/// C += sign · A Bᵀ with A of m × k, B of n × k and C of m × n.
fn add_product(c: &mut [f64], a: &[f64], b: &[f64], m: usize, n: usize, k: usize, sign: f64) {
    match (m, n, k) {
        (3, 3, 3) => add_product_of::<3, 3, 3>(c, a, b, sign),
        (5, 5, 5) => add_product_of::<5, 5, 5>(c, a, b, sign),
        (6, 6, 6) => add_product_of::<6, 6, 6>(c, a, b, sign),
        _ => {
            for (row_c, row_a) in c.chunks_exact_mut(n.max(1)).zip(a.chunks_exact(k)).take(m) {
                for (value, row_b) in row_c.iter_mut().zip(b.chunks_exact(k)) {
                    *value += sign * dot(row_a, row_b);
                }
            }
        }
    }
}

fn add_product_of<const M: usize, const N: usize, const K: usize>(c: &mut [f64], a: &[f64], b: &[f64], sign: f64) {
    let (Some(c), Some(a), Some(b)) = (c.get_mut(..M * N), a.get(..M * K), b.get(..N * K)) else { return };
    for i in 0..M {
        for j in 0..N {
            let mut sum = 0.0;
            for l in 0..K {
                sum += a[i * K + l] * b[j * K + l];
            }
            c[i * N + j] += sign * sum;
        }
    }
}

/// Inverts a symmetric positive definite matrix of n × n in place; a row that depends on those before it gets no multiplier.
fn invert(a: &mut [f64], n: usize) {
    match n {
        3 => invert_of::<3>(a),
        5 => invert_of::<5>(a),
        6 => invert_of::<6>(a),
        _ => invert_any(a, n),
    }
}

fn invert_of<const N: usize>(a: &mut [f64]) {
    invert_any(a, N);
}

/// Gauss–Jordan steps on the diagonal.
#[inline(always)]
fn invert_any(a: &mut [f64], n: usize) {
    let a = &mut a[..n * n];
    let mut own = [0.0; MAX_ROWS];
    for (i, value) in own[..n].iter_mut().enumerate() {
        *value = a[i * n + i];
    }
    for k in 0..n {
        let pivot = a[k * n + k];
        if pivot <= SINGULAR * own[k] || !pivot.is_finite() {
            for i in 0..n {
                a[k * n + i] = 0.0;
                a[i * n + k] = 0.0;
            }
            continue;
        }
        let inverse = 1.0 / pivot;
        // The pivot's row and column are left out by making them those of a step that is already done.
        a[k * n + k] = 1.0;
        for j in 0..n {
            a[k * n + j] *= inverse;
        }
        for i in 0..n {
            if i != k {
                let factor = a[i * n + k];
                a[i * n + k] = 0.0;
                for j in 0..n {
                    a[i * n + j] -= factor * a[k * n + j];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Noise(u64);

    impl Noise {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        }
    }

    #[test]
    fn a_random_block_system_is_solved_to_rounding() {
        let mut noise = Noise(7);
        let rows = [3_u32, 5, 6, 2, 0, 7, 3, 3, 3, 6];
        let capacity = rows.map(|rows| rows + 2);
        let pairs: Vec<(u32, u32)> = vec![(0, 1), (0, 4), (1, 2), (1, 7), (2, 3), (3, 9), (4, 5), (5, 6), (6, 7), (7, 8), (8, 9)];
        let plan = Plan::new(&capacity, &capacity, &pairs, u64::MAX).expect("no limit is set");
        let mut factor = Factor::default();
        factor.start(&plan, rows.iter().copied());
        let total = rows.iter().sum::<u32>() as usize;
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
                    let (r, c) = (factor.start_of(row_node as usize) + i, factor.start_of(column_node as usize) + j);
                    (dense[r][c], dense[c][r]) = (value, value);
                    let columns = rows[column_node as usize] as usize;
                    factor.block_mut(start)[i * columns + j] = value;
                    if a == b {
                        factor.block_mut(start)[j * columns + i] = value;
                    }
                }
            }
        }
        let expected: Vec<f64> = (0..total).map(|_| noise.next()).collect();
        let mut x: Vec<f64> = dense.iter().map(|row| dot(row, &expected)).collect();
        factor.factorize(&plan);
        factor.solve(&plan, &mut x);
        let worst = x.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1.0e-13, "the worst error is {worst:e}");
    }

    #[test]
    fn a_dependent_row_gets_no_multiplier() {
        let mut a = [2.0, 2.0, 0.5, 2.0, 2.0, 0.5, 0.5, 0.5, 1.0];
        invert(&mut a, 3);
        assert!(a.iter().all(|value| value.is_finite()), "the inverse is {a:?}");
        assert_eq!(a[4], 0.0, "the second row repeats the first");
    }
}
