//! A few dense rows beside a sparse factor: the Schur complement that they are left with once the factor's rows are eliminated.
//!
//! ```text
//! | A   B | | p |   | r |        X = L⁻¹ B,   y = L⁻¹ r,
//! | Bᵀ  D | | z | = | s |        (D − Xᵀ X) z = s − Xᵀ y,   Lᵀ p = y − X z
//! ```
//!
//! Which of these rows take part, and what they ask for, may change as often as it likes: A keeps its factor L. X has rows only for nodes
//! that elimination leads to from those which B couples, and is worked out along these alone.

use super::block::{Lanes, ZERO, add_product, add_scaled, sum, width};
use super::factor::{BlockFactor, BlockLayout};
use crate::platform::dispatched;

/// Marks a node that no dense row is coupled to.
const NONE: u32 = u32::MAX;

/// Dense rows beside a factor.
#[derive(Debug, Clone, Default)]
pub(crate) struct Border {
    /// Dense rows, and the lanes that hold as many numbers.
    count: usize,
    lanes: usize,
    /// Nodes on the ways of elimination, in its order, and of each node where its rows of X begin, in lanes.
    path: Vec<u32>,
    starts: Vec<u32>,
    /// First B, then X: of each row of the factor `lanes` lanes.
    columns: Vec<Lanes>,
    /// First D, then D − Xᵀ X.
    complement: Vec<Lanes>,
    scratch: Vec<Lanes>,
}

impl Border {
    /// Begins `count` rows that are coupled to these nodes of a factor: all coefficients are zero.
    pub(crate) fn begin(&mut self, factor: &BlockFactor, plan: &BlockLayout, nodes: impl Iterator<Item = u32>, count: usize) {
        (self.count, self.lanes) = (count, width(count));
        self.path.clear();
        self.starts.clear();
        self.starts.resize(plan.order().len(), NONE);
        for mut node in nodes {
            while self.starts[node as usize] == NONE {
                self.starts[node as usize] = 0;
                self.path.push(node);
                let Some(&(next, _)) = plan.column(plan.place(node)).first() else { break };
                node = next;
            }
        }
        self.path.sort_unstable_by_key(|&node| plan.place(node));
        let mut size = 0;
        for &node in &self.path {
            self.starts[node as usize] = size as u32;
            size += factor.rows(node as usize) * self.lanes;
        }
        self.columns.clear();
        self.columns.resize(size, ZERO);
        self.complement.clear();
        self.complement.resize(count * self.lanes, ZERO);
    }

    /// Coefficient of a dense row in a row of a node, of which the latter is one that [`begin`](Self::begin) was told of.
    pub(crate) fn coupling_mut(&mut self, node: u32, row: usize, dense: usize) -> &mut f64 {
        &mut self.columns[self.starts[node as usize] as usize + row * self.lanes + dense / 4][dense % 4]
    }

    /// Coefficient of two dense rows, of which the former is not the later.
    pub(crate) fn own_mut(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.complement[row * self.lanes + column / 4][column % 4]
    }

    /// Coefficients of a dense row with all others, once the factor's rows are eliminated.
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.complement[row * self.lanes..(row + 1) * self.lanes].as_flattened()[..self.count]
    }
}

dispatched!(
    /// Eliminates the factor's rows.
    eliminate, eliminate_body, (border: &mut Border, factor: &BlockFactor, plan: &BlockLayout)
);

dispatched!(
    /// Adds Xᵀ y to `sums`.
    gather, gather_body, (border: &Border, factor: &BlockFactor, y: &[Lanes], sums: &mut [Lanes])
);

dispatched!(
    /// Subtracts X z from y.
    spread, spread_body, (border: &Border, factor: &BlockFactor, z: &[Lanes], y: &mut [Lanes])
);

#[inline(always)]
fn eliminate_body(border: &mut Border, factor: &BlockFactor, plan: &BlockLayout) {
    let Border { count, lanes, path, starts, columns, complement, scratch } = border;
    let lanes = *lanes;
    for &node in &*path {
        let (k, start) = (factor.rows(node as usize), starts[node as usize] as usize);
        let wk = width(k);
        let root = factor.block(plan.diagonal(node as usize));
        scratch.clear();
        scratch.resize(k * lanes, ZERO);
        let own = &columns[start..start + k * lanes];
        for i in 0..k {
            let from = &own[i * lanes..(i + 1) * lanes];
            for (j, into) in scratch.chunks_exact_mut(lanes).enumerate().skip(i) {
                let share = root[i * wk + j / 4][j % 4];
                into.iter_mut().zip(from).for_each(|(into, from)| add_scaled(into, share, from));
            }
        }
        columns[start..start + k * lanes].copy_from_slice(scratch);
        for &(other, block) in plan.column(plan.place(node)) {
            let (m, into) = (factor.rows(other as usize), starts[other as usize] as usize);
            let block = factor.block(block);
            for (i, into) in columns[into..into + m * lanes].chunks_exact_mut(lanes).enumerate() {
                for (j, from) in scratch.chunks_exact(lanes).enumerate() {
                    let share = -block[i * wk + j / 4][j % 4];
                    into.iter_mut().zip(from).for_each(|(into, from)| add_scaled(into, share, from));
                }
            }
        }
        for from in scratch.chunks_exact(lanes) {
            for (row, into) in complement.chunks_exact_mut(lanes).enumerate() {
                let share = -from[row / 4][row % 4];
                let first = row / 4;
                into[first..].iter_mut().zip(&from[first..]).for_each(|(into, from)| add_scaled(into, share, from));
            }
        }
    }
    for row in 1..*count {
        for column in 0..row {
            let value = complement[column * lanes + row / 4][row % 4];
            complement[row * lanes + column / 4][column % 4] = value;
        }
    }
}

#[inline(always)]
fn gather_body(border: &Border, factor: &BlockFactor, y: &[Lanes], sums: &mut [Lanes]) {
    for &node in &border.path {
        let (lanes, start) = (factor.lanes(node as usize), border.starts[node as usize] as usize);
        let rows = border.columns[start..].chunks_exact(border.lanes).take(factor.rows(node as usize));
        for (row, from) in rows.enumerate() {
            let share = y[lanes.start + row / 4][row % 4];
            sums.iter_mut().zip(from).for_each(|(sum, from)| add_scaled(sum, share, from));
        }
    }
}

#[inline(always)]
fn spread_body(border: &Border, factor: &BlockFactor, z: &[Lanes], y: &mut [Lanes]) {
    for &node in &border.path {
        let (lanes, start) = (factor.lanes(node as usize), border.starts[node as usize] as usize);
        let rows = border.columns[start..].chunks_exact(border.lanes).take(factor.rows(node as usize));
        for (row, from) in rows.enumerate() {
            let mut product = ZERO;
            from.iter().zip(z).for_each(|(from, z)| add_product(&mut product, from, z));
            y[lanes.start + row / 4][row % 4] -= sum(&product);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::factor::{factorize, substitute_back, substitute_forward};
    use crate::linalg::noise::Noise;

    /// Nodes of the factor, rows of each, and dense rows.
    const NODES: u32 = 7;
    const ROWS: usize = 3;
    const DENSE: usize = 6;

    #[test]
    fn dense_rows_beside_a_factor_are_solved_as_one_system_with_it() {
        let mut noise = Noise(3);
        let sizes = [ROWS as u32; NODES as usize];
        let pairs: Vec<(u32, u32)> = (0..NODES - 1).map(|node| (node, node + 1)).collect();
        let plan = BlockLayout::new(&sizes, &sizes, &pairs, u64::MAX).expect("no limit is set");
        let mut factor = BlockFactor::default();
        factor.start(&plan, &sizes);
        let size = NODES as usize * ROWS + DENSE;
        let mut dense = vec![vec![0.0; size]; size];
        for (a, b) in pairs.iter().copied().chain((0..NODES).map(|node| (node, node))) {
            let (start, b_is_row) = plan.block(a, b).expect("the two are coupled");
            let (of_row, of_column) = if b_is_row { (b, a) } else { (a, b) };
            for i in 0..ROWS {
                for j in 0..if a == b { i + 1 } else { ROWS } {
                    let value = if a == b && i == j { 4.0 } else { noise.next() };
                    let [row, column] = [(of_row, i), (of_column, j)].map(|(node, i)| node as usize * ROWS + i);
                    (dense[row][column], dense[column][row]) = (value, value);
                    factor.block_mut(start)[i][j] = value;
                    if a == b {
                        factor.block_mut(start)[j][i] = value;
                    }
                }
            }
        }
        factorize(&mut factor, &plan);
        let coupled = [1, 2, 5];
        let mut border = Border::default();
        border.begin(&factor, &plan, coupled.into_iter(), DENSE);
        for i in 0..DENSE {
            let own = NODES as usize * ROWS + i;
            for (node, row) in coupled.into_iter().flat_map(|node| (0..ROWS).map(move |row| (node, row))) {
                let value = noise.next();
                *border.coupling_mut(node, row, i) = value;
                let other = node as usize * ROWS + row;
                (dense[own][other], dense[other][own]) = (value, value);
            }
            for j in i..DENSE {
                let value = if i == j { 5.0 } else { noise.next() };
                *border.own_mut(i, j) = value;
                let other = NODES as usize * ROWS + j;
                (dense[own][other], dense[other][own]) = (value, value);
            }
        }
        eliminate(&mut border, &factor, &plan);
        let expected: Vec<f64> = (0..size).map(|_| noise.next()).collect();
        let sides: Vec<f64> = dense.iter().map(|row| row.iter().zip(&expected).map(|(a, b)| a * b).sum()).collect();
        let mut y: Vec<Lanes> = sides[..size - DENSE].chunks(ROWS).map(|rows| [rows[0], rows[1], rows[2], 0.0]).collect();
        substitute_forward(&factor, &plan, &mut y);
        let mut sums = [ZERO; width(DENSE)];
        gather(&border, &factor, &y, &mut sums);
        let z = &expected[size - DENSE..];
        for i in 0..DENSE {
            let left = sides[size - DENSE + i] - sums.as_flattened()[i];
            let found: f64 = border.row(i).iter().zip(z).map(|(share, z)| share * z).sum();
            assert!((left - found).abs() < 1e-13, "row {i} of the complement times the solution is {found} for {left}");
        }
        let mut lanes = [ZERO; width(DENSE)];
        lanes.as_flattened_mut()[..DENSE].copy_from_slice(z);
        spread(&border, &factor, &lanes, &mut y);
        substitute_back(&factor, &plan, &mut y);
        for (row, expected) in expected[..size - DENSE].iter().enumerate() {
            let found = y[row / ROWS][row % ROWS];
            assert!((found - expected).abs() < 1e-13, "unknown {row} is {found} for {expected}");
        }
    }
}
