//! Block LDLᵀ of a symmetric quasi-definite matrix, with the inverse of each pivot formed outright.
//!
//! The matrix is [[M̂, Jᵀ], [J, −ε]]: positive on bodies, negative on joints. Such a matrix has an LDLᵀ in any order of its nodes whose
//! pivots keep their sign (Vanderbei 1995); [`Elimination`](super::elimination::Elimination) chooses one in which none is tiny.

use super::elimination::{Elimination, WIDTH};
use crate::platform::dispatched;

/// A block of rows of one node and columns of another.
pub(crate) type Block = [[f64; WIDTH]; WIDTH];
pub(crate) type Vector = [f64; WIDTH];

const NOTHING: Block = [[0.0; WIDTH]; WIDTH];

/// The matrix of a system, then its factor.
#[derive(Debug, Default)]
pub(crate) struct Factor {
    /// Column by column, so that products of two blocks go over whole lines.
    blocks: Vec<Block>,
    /// Blocks times the inverse of the pivot above, column by column.
    scaled: Vec<Block>,
    diagonal: Vec<Block>,
    inverse: Vec<Block>,
}

impl Factor {
    /// Begins a new matrix of this structure.
    pub(crate) fn start(&mut self, structure: &Elimination) {
        let (nodes, blocks) = (structure.node_count(), structure.block_count());
        for (list, count) in [(&mut self.blocks, blocks), (&mut self.diagonal, nodes)] {
            list.clear();
            list.resize(count, NOTHING);
        }
        // What is read of them is written before.
        self.scaled.resize(blocks, NOTHING);
        self.inverse.resize(nodes, NOTHING);
    }

    pub(crate) fn diagonal_mut(&mut self, node: u32) -> &mut Block {
        &mut self.diagonal[node as usize]
    }

    /// The block of two nodes, rows of `a` and columns of `b` given by `value`, grows by that.
    pub(crate) fn add(&mut self, structure: &Elimination, a: u32, b: u32, value: impl Fn(usize, usize) -> f64) {
        let (number, in_order) = structure.block(a, b);
        let block = &mut self.blocks[number];
        let [rows, columns] = [a, b].map(|node| usize::from(structure.sizes[node as usize]));
        if in_order {
            for (column, line) in block[..columns].iter_mut().enumerate() {
                line[..rows].iter_mut().enumerate().for_each(|(row, entry)| *entry += value(row, column));
            }
        } else {
            for (row, line) in block[..rows].iter_mut().enumerate() {
                line[..columns].iter_mut().enumerate().for_each(|(column, entry)| *entry += value(row, column));
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
    let Factor { blocks, scaled, diagonal, inverse } = factor;
    let size_of = |node: u32| usize::from(structure.sizes[node as usize]);
    for (place, &node) in structure.order.iter().enumerate() {
        let size = size_of(node);
        let block = &diagonal[node as usize];
        // Loops of known length are unrolled: most nodes are bodies, balls and hinges.
        let own = match size {
            6 => inverse_of::<6>(block),
            5 => inverse_of::<5>(block),
            3 => inverse_of::<3>(block),
            _ => inverse_within(block, size),
        };
        inverse[node as usize] = own;
        for number in structure.below_of(node) {
            let (block, scaled) = (&blocks[number], &mut scaled[number]);
            for (column, sums) in scaled[..size].iter_mut().enumerate() {
                *sums = [0.0; WIDTH];
                for (line, factors) in block[..size].iter().zip(&own) {
                    add_product(sums, factors[column], line);
                }
            }
        }
        let range = structure.first_update[place] as usize..structure.first_update[place + 1] as usize;
        for update in &structure.updates[range] {
            let (rows, columns) = (&scaled[update.rows as usize], blocks[update.columns as usize]);
            match (update.target as usize).checked_sub(blocks.len()) {
                Some(target) => {
                    for (row, line) in diagonal[target][..size_of(target as u32)].iter_mut().enumerate() {
                        for (factors, other) in rows[..size].iter().zip(&columns) {
                            subtract_product(line, factors[row], other);
                        }
                    }
                }
                None => {
                    let count = size_of(structure.below[update.columns as usize]);
                    for (column, line) in blocks[update.target as usize][..count].iter_mut().enumerate() {
                        for (other, factors) in rows[..size].iter().zip(&columns) {
                            subtract_product(line, factors[column], other);
                        }
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn substitute_body(factor: &Factor, structure: &Elimination, values: &mut [Vector]) {
    for &node in &structure.order {
        let (own, size) = (values[node as usize], usize::from(structure.sizes[node as usize]));
        for number in structure.below_of(node) {
            let mut sums = [0.0; WIDTH];
            for (line, value) in factor.scaled[number][..size].iter().zip(&own) {
                add_product(&mut sums, *value, line);
            }
            let other = &mut values[structure.below[number] as usize];
            for (entry, sum) in other.iter_mut().zip(&sums) {
                *entry -= sum;
            }
        }
    }
    for &node in structure.order.iter().rev() {
        let size = usize::from(structure.sizes[node as usize]);
        let mut found = factor.inverse[node as usize].map(|line| dot(&line, &values[node as usize]));
        for number in structure.below_of(node) {
            let other = &values[structure.below[number] as usize];
            for (entry, line) in found[..size].iter_mut().zip(&factor.scaled[number]) {
                for (value, factor) in other.iter().zip(line) {
                    *entry -= factor * value;
                }
            }
        }
        values[node as usize] = found;
    }
}

#[inline(always)]
fn add_product(sums: &mut Vector, factor: f64, line: &Vector) {
    for (sum, entry) in sums.iter_mut().zip(line) {
        *sum += factor * entry;
    }
}

#[inline(always)]
fn subtract_product(sums: &mut Vector, factor: f64, line: &Vector) {
    for (sum, entry) in sums.iter_mut().zip(line) {
        *sum -= factor * entry;
    }
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// As [`inverse_within`], of a block of known size.
#[inline(always)]
fn inverse_of<const SIZE: usize>(block: &Block) -> Block {
    inverse_within(block, SIZE)
}

/// Inverse of a definite symmetric block of either sign, by its own LDLᵀ; zero beyond `size`.
#[inline(always)]
fn inverse_within(block: &Block, size: usize) -> Block {
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
