//! Block LDLᵀ of a symmetric quasi-definite matrix, with the inverse of each pivot formed outright.
//!
//! The matrix is [[M̂, Jᵀ], [J, −ε]]: positive on bodies, negative on joints. Such a matrix has an LDLᵀ in any order of its nodes whose
//! pivots keep their sign (Vanderbei 1995); [`Elimination`](super::elimination::Elimination) chooses one in which none is tiny.

use super::elimination::{Elimination, LANES, WIDTH};
use crate::platform::dispatched;

/// A block of a node with itself.
pub(crate) type Block = [[f64; WIDTH]; WIDTH];
pub(crate) type Vector = [f64; WIDTH];

const NOTHING: Block = [[0.0; WIDTH]; WIDTH];

/// Rows of a panel that follow one another.
type Rows = [f64; LANES];

/// Bits that are kept of rows of which so many matter.
const KEPT: [[u64; LANES]; LANES] = [[0; 4], [u64::MAX, 0, 0, 0], [u64::MAX, u64::MAX, 0, 0], [u64::MAX, u64::MAX, u64::MAX, 0]];

/// The matrix of a system, then its factor.
#[derive(Debug, Default)]
pub(crate) struct Factor {
    /// Panels of all nodes: see [`Panels`](super::elimination::Panels). Own rows hold what has been subtracted from the node's diagonal block.
    panels: Vec<f64>,
    /// Rows below times the inverse of the pivot above.
    scaled: Vec<f64>,
    diagonal: Vec<Block>,
    inverse: Vec<Block>,
}

impl Factor {
    /// Begins a new matrix of this structure.
    pub(crate) fn start(&mut self, structure: &Elimination) {
        let (nodes, length) = (structure.node_count(), structure.panels.length + LANES + WIDTH);
        self.panels.clear();
        self.panels.resize(length, 0.0);
        self.diagonal.clear();
        self.diagonal.resize(nodes, NOTHING);
        // What is read of them is written before.
        self.scaled.resize(length, 0.0);
        self.inverse.resize(nodes, NOTHING);
    }

    pub(crate) fn diagonal_mut(&mut self, node: u32) -> &mut Block {
        &mut self.diagonal[node as usize]
    }

    /// The block of two nodes, rows of `a` and columns of `b` given by `value`, grows by that.
    pub(crate) fn add(&mut self, structure: &Elimination, a: u32, b: u32, value: impl Fn(usize, usize) -> f64) {
        let (start, height, in_order) = structure.block(a, b);
        let [rows, columns] = [a, b].map(|node| usize::from(structure.sizes[node as usize]));
        let (lines, length) = if in_order { (columns, rows) } else { (rows, columns) };
        for line in 0..lines {
            let entries = &mut self.panels[start + line * height..][..length];
            for (at, entry) in entries.iter_mut().enumerate() {
                *entry += if in_order { value(at, line) } else { value(line, at) };
            }
        }
    }

    /// Factorises the matrix in place.
    pub(crate) fn factorize(&mut self, structure: &Elimination) {
        factorize(self, structure);
    }

    /// Solves for one right-hand side, in place.
    pub(crate) fn solve(&self, structure: &Elimination, values: &mut [Vector]) {
        substitute(self, structure, values);
    }
}

dispatched!(
    /// See [`Factor::factorize`].
    factorize, factorize_body, (factor: &mut Factor, structure: &Elimination)
);

dispatched!(
    /// See [`Factor::solve`].
    substitute, substitute_body, (factor: &Factor, structure: &Elimination, values: &mut [Vector])
);

#[inline(always)]
fn factorize_body(factor: &mut Factor, structure: &Elimination) {
    for &node in &structure.order {
        // Loops of known length are unrolled.
        match structure.sizes[node as usize] {
            6 => eliminate::<6, 8>(factor, structure, node),
            5 => eliminate::<5, 8>(factor, structure, node),
            4 => eliminate::<4, 4>(factor, structure, node),
            3 => eliminate::<3, 4>(factor, structure, node),
            2 => eliminate::<2, 4>(factor, structure, node),
            1 => eliminate::<1, 4>(factor, structure, node),
            _ => {}
        }
    }
}

/// Inverts the pivot of a node of this size, in lines of `LINE`, and subtracts what it makes of the blocks below.
#[inline(always)]
fn eliminate<const SIZE: usize, const LINE: usize>(factor: &mut Factor, structure: &Elimination, node: u32) {
    let Factor { panels, scaled, diagonal, inverse } = factor;
    let layout = &structure.panels;
    let (start, height) = (layout.starts[node as usize] as usize, layout.heights[node as usize] as usize);
    let mut pivot = [[0.0; LINE]; SIZE];
    for (column, line) in pivot.iter_mut().enumerate() {
        let (own, subtracted) = (&diagonal[node as usize][column], &panels[start + column * height..][..SIZE]);
        for row in 0..SIZE {
            line[row] = own[row] + subtracted[row];
        }
    }
    invert(&mut pivot);
    let stored = &mut inverse[node as usize];
    *stored = NOTHING;
    for (stored, line) in stored.iter_mut().zip(&pivot) {
        stored[..SIZE].copy_from_slice(&line[..SIZE]);
    }
    let mut lines = [[0.0; LANES]; SIZE];
    let mut row = SIZE - SIZE % LANES;
    while row < height {
        for (k, line) in lines.iter_mut().enumerate() {
            *line = rows_at(panels, start + k * height + row);
        }
        for column in 0..SIZE {
            let mut sums = [0.0; LANES];
            for k in 0..SIZE {
                add_product(&mut sums, pivot[k][column], &lines[k]);
            }
            scaled[start + column * height + row..][..LANES].copy_from_slice(&sums);
        }
        row += LANES;
    }
    for block in structure.below_of(node) {
        let (target, first) = (structure.below[block], start + layout.rows[block] as usize);
        let columns = usize::from(structure.sizes[target as usize]);
        let (to, length) = (layout.starts[target as usize] as usize, layout.heights[target as usize] as usize);
        // Of each own unknown, and each column of the target.
        let mut factors = [[0.0; WIDTH]; SIZE];
        for (k, factors) in factors.iter_mut().enumerate() {
            factors.copy_from_slice(&panels[first + k * height..][..WIDTH]);
        }
        for run in &layout.runs[layout.first_run[block] as usize..layout.first_run[block + 1] as usize] {
            let (from, to, count) = (start + run.from as usize, to + run.to as usize, run.count as usize);
            let mut row = 0;
            while row < count {
                for (k, line) in lines.iter_mut().enumerate() {
                    *line = rows_at(scaled, from + k * height + row);
                }
                if let Some(kept) = KEPT.get(count - row) {
                    // Rows after the last one stay as they are.
                    for line in &mut lines {
                        for lane in 0..LANES {
                            line[lane] = f64::from_bits(line[lane].to_bits() & kept[lane]);
                        }
                    }
                }
                for column in 0..columns {
                    let changed = &mut panels[to + column * length + row..][..LANES];
                    for k in 0..SIZE {
                        for lane in 0..LANES {
                            changed[lane] -= factors[k][column] * lines[k][lane];
                        }
                    }
                }
                row += LANES;
            }
        }
    }
}

#[inline(always)]
fn rows_at(panels: &[f64], at: usize) -> Rows {
    let mut rows = [0.0; LANES];
    rows.copy_from_slice(&panels[at..][..LANES]);
    rows
}

#[inline(always)]
fn substitute_body(factor: &Factor, structure: &Elimination, values: &mut [Vector]) {
    let layout = &structure.panels;
    for &node in &structure.order {
        let (own, size) = (values[node as usize], usize::from(structure.sizes[node as usize]));
        let (start, height) = (layout.starts[node as usize] as usize, layout.heights[node as usize] as usize);
        for block in structure.below_of(node) {
            let first = start + layout.rows[block] as usize;
            let mut sums = [0.0; WIDTH];
            for (column, value) in own[..size].iter().enumerate() {
                let rows = &factor.scaled[first + column * height..][..WIDTH];
                for row in 0..WIDTH {
                    sums[row] += value * rows[row];
                }
            }
            let below = structure.below[block];
            let (other, rows) = (&mut values[below as usize], usize::from(structure.sizes[below as usize]));
            for row in 0..rows {
                other[row] -= sums[row];
            }
        }
    }
    for &node in structure.order.iter().rev() {
        let size = usize::from(structure.sizes[node as usize]);
        let (start, height) = (layout.starts[node as usize] as usize, layout.heights[node as usize] as usize);
        let (own, mut found) = (values[node as usize], [0.0; WIDTH]);
        for (value, line) in own[..size].iter().zip(&factor.inverse[node as usize]) {
            for row in 0..WIDTH {
                found[row] += value * line[row];
            }
        }
        for block in structure.below_of(node) {
            let (below, first) = (structure.below[block], start + layout.rows[block] as usize);
            let (other, rows) = (&values[below as usize], usize::from(structure.sizes[below as usize]));
            for (column, entry) in found[..size].iter_mut().enumerate() {
                let factors = &factor.scaled[first + column * height..][..rows];
                for row in 0..rows {
                    *entry -= factors[row] * other[row];
                }
            }
        }
        values[node as usize] = found;
    }
}

#[inline(always)]
fn add_product(sums: &mut Rows, factor: f64, line: &Rows) {
    for lane in 0..LANES {
        sums[lane] += factor * line[lane];
    }
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Inverts a definite symmetric block of either sign in place, by its LDLᵀ: with what Gauss and Jordan leave of a block whose terms are stiff, a
/// tower of struts and cables sinks by 35 mm for 6. What has no inverse answers to nothing.
#[inline(always)]
fn invert<const SIZE: usize, const LINE: usize>(block: &mut [[f64; LINE]; SIZE]) {
    let (mut lower, mut pivots, mut reciprocals) = ([[0.0; LINE]; SIZE], [0.0; SIZE], [0.0; SIZE]);
    for column in 0..SIZE {
        let mut pivot = block[column][column];
        for k in 0..column {
            pivot -= lower[column][k] * lower[column][k] * pivots[k];
        }
        (pivots[column], reciprocals[column]) = (pivot, if pivot == 0.0 { 0.0 } else { 1.0 / pivot });
        for row in column + 1..SIZE {
            let mut value = block[row][column];
            for k in 0..column {
                value -= lower[row][k] * lower[column][k] * pivots[k];
            }
            lower[row][column] = value * reciprocals[column];
        }
    }
    // The inverse of the lower triangle, whose diagonal is one, line by line.
    let mut inverse = [[0.0; LINE]; SIZE];
    for row in 0..SIZE {
        inverse[row][row] = 1.0;
        for k in 0..row {
            for column in 0..LINE {
                inverse[row][column] -= lower[row][k] * inverse[k][column];
            }
        }
    }
    *block = [[0.0; LINE]; SIZE];
    for k in 0..SIZE {
        for row in 0..SIZE {
            let factor = inverse[k][row] * reciprocals[k];
            for column in 0..LINE {
                block[row][column] += factor * inverse[k][column];
            }
        }
    }
    for row in 0..SIZE {
        for column in 0..row {
            block[column][row] = block[row][column];
        }
    }
}
