//! Block LDLᵀ of a symmetric quasi-definite matrix, with the inverse of each pivot formed outright.
//!
//! The matrix is [[M̂, Jᵀ], [J, −ε]]: positive on bodies, negative on joints. Such a matrix has an LDLᵀ in any order of its nodes whose
//! pivots keep their sign (Vanderbei 1995); [`Elimination`](super::elimination::Elimination) chooses one in which none is tiny.

use super::elimination::{Elimination, WIDTH, stride};
use crate::platform::dispatched;

/// A block of a node with itself.
pub(crate) type Block = [[f64; WIDTH]; WIDTH];
pub(crate) type Vector = [f64; WIDTH];

const NOTHING: Block = [[0.0; WIDTH]; WIDTH];

/// The matrix of a system, then its factor.
#[derive(Debug, Default)]
pub(crate) struct Factor {
    /// Panels of all nodes: see [`Panels`](super::elimination::Panels). Own rows hold what has been subtracted from the node's diagonal block.
    panels: Vec<f64>,
    /// Rows below times the inverse of the pivot above.
    scaled: Vec<f64>,
    diagonal: Vec<Block>,
    inverse: Vec<Block>,
    /// Panels and diagonal of the matrix that has been kept.
    base_panels: Vec<f64>,
    base_diagonal: Vec<Block>,
}

impl Factor {
    /// Begins a new matrix of this structure.
    pub(crate) fn start(&mut self, structure: &Elimination) {
        let (nodes, length) = (structure.node_count(), structure.panels.length);
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

    /// The block at this place (see [`Elimination::block`]), whose rows and columns are so many and given by `value`, grows by that.
    #[inline(always)]
    pub(crate) fn add(
        &mut self,
        (start, stride, in_order): (usize, usize, bool),
        [rows, columns]: [usize; 2],
        value: impl Fn(usize, usize) -> f64,
    ) {
        let (lines, length) = if in_order { (rows, columns) } else { (columns, rows) };
        for line in 0..lines {
            let entries = &mut self.panels[start + line * stride..][..length];
            for (at, entry) in entries.iter_mut().enumerate() {
                *entry += if in_order { value(line, at) } else { value(at, line) };
            }
        }
    }

    /// Keeps the matrix as it is, to begin again with it.
    pub(crate) fn keep(&mut self) {
        self.base_panels.clone_from(&self.panels);
        self.base_diagonal.clone_from(&self.diagonal);
    }

    /// Begins again with the matrix that has been kept.
    pub(crate) fn begin_again(&mut self) {
        self.panels.clone_from(&self.base_panels);
        self.diagonal.clone_from(&self.base_diagonal);
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

/// Calls a function with the size of a node and the length of its rows as constants: loops of known length are unrolled.
macro_rules! by_size {
    ($size:expr, $function:ident, $($arguments:expr),*) => {
        match $size {
            6 => $function::<6, 8>($($arguments),*),
            5 => $function::<5, 8>($($arguments),*),
            4 => $function::<4, 4>($($arguments),*),
            3 => $function::<3, 4>($($arguments),*),
            2 => $function::<2, 4>($($arguments),*),
            1 => $function::<1, 4>($($arguments),*),
            _ => {}
        }
    };
}

#[inline(always)]
fn factorize_body(factor: &mut Factor, structure: &Elimination) {
    for &node in &structure.order {
        by_size!(structure.sizes[node as usize], eliminate, factor, structure, node);
    }
}

/// Inverts the pivot of a node of this size, in rows of `LINE`, and subtracts what it makes of the blocks below.
#[inline(always)]
fn eliminate<const SIZE: usize, const LINE: usize>(factor: &mut Factor, structure: &Elimination, node: u32) {
    let Factor { panels, scaled, diagonal, inverse, .. } = factor;
    let layout = &structure.panels;
    let (start, rows) = (layout.starts[node as usize] as usize, layout.heights[node as usize] as usize);
    let own = &panels[start..start + rows * LINE];
    let mut pivot = [[0.0; LINE]; SIZE];
    for ((line, own), subtracted) in pivot.iter_mut().zip(&diagonal[node as usize]).zip(own.chunks_exact(LINE)) {
        for column in 0..SIZE {
            line[column] = own[column] + subtracted[column];
        }
    }
    invert(&mut pivot);
    let stored = &mut inverse[node as usize];
    *stored = NOTHING;
    for (stored, line) in stored.iter_mut().zip(&pivot) {
        stored[..SIZE].copy_from_slice(&line[..SIZE]);
    }
    let scaled = &mut scaled[start..start + rows * LINE];
    for (scaled, line) in scaled.chunks_exact_mut(LINE).zip(own.chunks_exact(LINE)).skip(SIZE) {
        let mut sums = [0.0; LINE];
        for k in 0..SIZE {
            for lane in 0..LINE {
                sums[lane] += line[k] * pivot[k][lane];
            }
        }
        scaled.copy_from_slice(&sums);
    }
    for block in structure.below_of(node) {
        let target = structure.below[block];
        if stride(usize::from(structure.sizes[target as usize])) == 8 {
            subtract::<SIZE, LINE, 8>(panels, scaled, structure, (start, block));
        } else {
            subtract::<SIZE, LINE, 4>(panels, scaled, structure, (start, block));
        }
    }
}

/// Subtracts from the panel of the node of a block below, whose rows have the length `OTHER`, what the elimination makes of it; `scaled` are the
/// rows of the eliminated node's panel, which begins at `start`, times the inverse of its pivot.
#[inline(always)]
fn subtract<const SIZE: usize, const LINE: usize, const OTHER: usize>(
    panels: &mut [f64],
    scaled: &[f64],
    structure: &Elimination,
    (start, block): (usize, usize),
) {
    let layout = &structure.panels;
    let target = structure.below[block] as usize;
    let columns = usize::from(structure.sizes[target]);
    // Of each own unknown, and each column of the target.
    let mut factors = [[0.0; OTHER]; SIZE];
    let first = start + layout.rows[block] as usize * LINE;
    for (column, line) in panels[first..first + columns * LINE].chunks_exact(LINE).enumerate().take(OTHER) {
        for k in 0..SIZE {
            factors[k][column] = line[k];
        }
    }
    for run in &layout.runs[layout.first_run[block] as usize..layout.first_run[block + 1] as usize] {
        let (from, count) = (run.from as usize * LINE, run.count as usize);
        let to = layout.starts[target] as usize + run.to as usize * OTHER;
        let rows = scaled[from..from + count * LINE].chunks_exact(LINE);
        for (row, changed) in rows.zip(panels[to..to + count * OTHER].chunks_exact_mut(OTHER)) {
            let mut left = [0.0; OTHER];
            left.copy_from_slice(changed);
            for k in 0..SIZE {
                for lane in 0..OTHER {
                    left[lane] -= row[k] * factors[k][lane];
                }
            }
            changed.copy_from_slice(&left);
        }
    }
}

#[inline(always)]
fn substitute_body(factor: &Factor, structure: &Elimination, values: &mut [Vector]) {
    for &node in &structure.order {
        by_size!(structure.sizes[node as usize], hand_on, factor, structure, node, values);
    }
    for &node in structure.order.iter().rev() {
        by_size!(structure.sizes[node as usize], take_back, factor, structure, node, values);
    }
}

/// Takes a node out of the right-hand side of those below.
#[inline(always)]
fn hand_on<const SIZE: usize, const LINE: usize>(factor: &Factor, structure: &Elimination, node: u32, values: &mut [Vector]) {
    let layout = &structure.panels;
    let (own, start) = (values[node as usize], layout.starts[node as usize] as usize);
    for block in structure.below_of(node) {
        let (below, first) = (structure.below[block] as usize, start + layout.rows[block] as usize * LINE);
        let rows = factor.scaled[first..first + usize::from(structure.sizes[below]) * LINE].chunks_exact(LINE);
        for (value, row) in values[below].iter_mut().zip(rows) {
            let mut sum = 0.0;
            for k in 0..SIZE {
                sum += own[k] * row[k];
            }
            *value -= sum;
        }
    }
}

/// Finds the unknowns of a node from those below.
#[inline(always)]
fn take_back<const SIZE: usize, const LINE: usize>(factor: &Factor, structure: &Elimination, node: u32, values: &mut [Vector]) {
    let layout = &structure.panels;
    let (own, start) = (values[node as usize], layout.starts[node as usize] as usize);
    let mut found = [0.0; LINE];
    for (value, line) in own[..SIZE].iter().zip(&factor.inverse[node as usize]) {
        for lane in 0..SIZE {
            found[lane] += value * line[lane];
        }
    }
    for block in structure.below_of(node) {
        let (below, first) = (structure.below[block] as usize, start + layout.rows[block] as usize * LINE);
        let rows = factor.scaled[first..first + usize::from(structure.sizes[below]) * LINE].chunks_exact(LINE);
        for (value, row) in values[below].iter().zip(rows) {
            for lane in 0..LINE {
                found[lane] -= value * row[lane];
            }
        }
    }
    let values = &mut values[node as usize];
    *values = [0.0; WIDTH];
    values[..SIZE].copy_from_slice(&found[..SIZE]);
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
