//! Block LDLᵀ of a symmetric quasi-definite matrix, with the inverse of each pivot formed outright.
//!
//! The matrix is [[M̂, Jᵀ], [J, −ε]]: positive on bodies, negative on joints. Such a matrix has an LDLᵀ in any order of its nodes whose
//! pivots keep their sign (Vanderbei 1995); [`Elimination`](super::elimination::Elimination) chooses one in which none is tiny.

use super::elimination::{Elimination, WIDTH};

/// A block of rows of one node and columns of another.
pub(crate) type Block = [[f64; WIDTH]; WIDTH];
pub(crate) type Vector = [f64; WIDTH];

const NOTHING: Block = [[0.0; WIDTH]; WIDTH];

/// The matrix of a system, then its factor.
#[derive(Debug, Default)]
pub(crate) struct Factor {
    blocks: Vec<Block>,
    /// Blocks times the inverse of the pivot above.
    scaled: Vec<Block>,
    diagonal: Vec<Block>,
    inverse: Vec<Block>,
}

impl Factor {
    /// Begins a new matrix of this structure.
    pub(crate) fn start(&mut self, structure: &Elimination) {
        let (nodes, blocks) = (structure.node_count(), structure.block_count());
        for (list, count) in
            [(&mut self.blocks, blocks), (&mut self.scaled, blocks), (&mut self.diagonal, nodes), (&mut self.inverse, nodes)]
        {
            list.clear();
            list.resize(count, NOTHING);
        }
    }

    pub(crate) fn diagonal_mut(&mut self, node: u32) -> &mut Block {
        &mut self.diagonal[node as usize]
    }

    /// The block of two nodes, rows of `a` and columns of `b` given by `value`, grows by that.
    pub(crate) fn add(&mut self, structure: &Elimination, a: u32, b: u32, value: impl Fn(usize, usize) -> f64) {
        let (number, in_order) = structure.block(a, b);
        let block = &mut self.blocks[number];
        let [rows, columns] = [a, b].map(|node| usize::from(structure.sizes[node as usize]));
        for row in 0..rows {
            for column in 0..columns {
                let entry = if in_order { &mut block[row][column] } else { &mut block[column][row] };
                *entry += value(row, column);
            }
        }
    }

    /// Factorises the matrix in place.
    pub(crate) fn factorize(&mut self, structure: &Elimination) {
        for (place, &node) in structure.order.iter().enumerate() {
            let size = usize::from(structure.sizes[node as usize]);
            let inverse = inverse_of(&self.diagonal[node as usize], size);
            self.inverse[node as usize] = inverse;
            for number in structure.below_of(node) {
                let rows = usize::from(structure.sizes[structure.below[number] as usize]);
                let (block, scaled) = (&self.blocks[number], &mut self.scaled[number]);
                for row in 0..rows {
                    let mut sums = [0.0; WIDTH];
                    for (value, line) in block[row][..size].iter().zip(&inverse) {
                        for (sum, entry) in sums.iter_mut().zip(line) {
                            *sum += value * entry;
                        }
                    }
                    scaled[row] = sums;
                }
            }
            let range = structure.first_update[place] as usize..structure.first_update[place + 1] as usize;
            for update in &structure.updates[range] {
                let (x, b) = (self.scaled[update.rows as usize], &self.blocks[update.columns as usize]);
                // Columns of the product as rows, for sums side by side.
                let mut columns = NOTHING;
                for (i, line) in b.iter().enumerate() {
                    for (column, entry) in columns.iter_mut().zip(line) {
                        column[i] = *entry;
                    }
                }
                let target = match (update.target as usize).checked_sub(self.blocks.len()) {
                    Some(node) => &mut self.diagonal[node],
                    None => &mut self.blocks[update.target as usize],
                };
                // Rows beyond a joint's own are empty.
                let rows = usize::from(structure.sizes[structure.below[update.rows as usize] as usize]);
                for (line, x) in target.iter_mut().zip(&x).take(rows) {
                    for (value, column) in x[..size].iter().zip(&columns) {
                        for (entry, other) in line.iter_mut().zip(column) {
                            *entry -= value * other;
                        }
                    }
                }
            }
        }
    }

    /// Solves for one right-hand side, in place.
    pub(crate) fn solve(&self, structure: &Elimination, values: &mut [Vector]) {
        for &node in &structure.order {
            let own = values[node as usize];
            for number in structure.below_of(node) {
                let other = &mut values[structure.below[number] as usize];
                for (entry, line) in other.iter_mut().zip(&self.scaled[number]) {
                    *entry -= dot(line, &own);
                }
            }
        }
        for &node in structure.order.iter().rev() {
            let mut found = self.inverse[node as usize].map(|line| dot(&line, &values[node as usize]));
            for number in structure.below_of(node) {
                let other = &values[structure.below[number] as usize];
                for (line, value) in self.scaled[number].iter().zip(other) {
                    for (entry, factor) in found.iter_mut().zip(line) {
                        *entry -= factor * value;
                    }
                }
            }
            values[node as usize] = found;
        }
    }
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Inverse of a definite symmetric block of either sign, by its own LDLᵀ; zero beyond `size`.
fn inverse_of(block: &Block, size: usize) -> Block {
    let mut lower = NOTHING;
    let (mut pivots, mut reciprocal) = ([0.0; WIDTH], [0.0; WIDTH]);
    for column in 0..size {
        let mut pivot = block[column][column];
        for k in 0..column {
            pivot -= lower[column][k] * lower[column][k] * pivots[k];
        }
        // What has no inverse answers to nothing.
        (pivots[column], reciprocal[column]) = (pivot, if pivot == 0.0 { 0.0 } else { 1.0 / pivot });
        for row in column + 1..size {
            let mut value = block[row][column];
            for k in 0..column {
                value -= lower[row][k] * lower[column][k] * pivots[k];
            }
            lower[row][column] = value * reciprocal[column];
        }
    }
    // The inverse of the lower triangle, whose diagonal is one.
    let mut inverse = NOTHING;
    for column in 0..size {
        inverse[column][column] = 1.0;
        for row in column + 1..size {
            inverse[row][column] = -(column..row).map(|k| lower[row][k] * inverse[k][column]).sum::<f64>();
        }
    }
    let mut result = NOTHING;
    for i in 0..size {
        for j in 0..=i {
            let sum = (i..size).map(|k| inverse[k][i] * inverse[k][j] * reciprocal[k]).sum::<f64>();
            result[i][j] = sum;
            result[j][i] = sum;
        }
    }
    result
}
