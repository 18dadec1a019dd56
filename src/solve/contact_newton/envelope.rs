//! Cholesky factor of a symmetric positive matrix, row by row within its envelope: A = L Lᵀ in `f64`.
//!
//! Each row is kept from its first entry to its diagonal; nothing before the first entry ever fills in. A stack whose bodies are in
//! order has rows of twelve entries, however high it is.

/// The lower half of a matrix, and after [`factor`](Self::factor) its root.
#[derive(Debug, Default)]
pub(super) struct Envelope {
    /// First column of each row, and where its entries begin.
    first: Vec<u32>,
    start: Vec<u32>,
    entries: Vec<f64>,
}

impl Envelope {
    /// Takes the shape of a matrix whose rows begin in these columns.
    pub(super) fn shape(&mut self, first_columns: impl Iterator<Item = u32>) {
        self.first.clear();
        self.start.clear();
        self.start.push(0);
        for (row, first) in first_columns.enumerate() {
            self.first.push(first);
            self.start.push(self.start[row] + row as u32 + 1 - first);
        }
    }

    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.entries.resize(self.start.last().map_or(0, |&end| end as usize), 0.0);
    }

    /// Adds a block of six rows and columns on or below the diagonal, of which what lies above it is left out.
    pub(super) fn add_block(&mut self, row_block: usize, column_block: usize, block: &[[f64; 6]; 6]) {
        for (i, values) in block.iter().enumerate() {
            let row = 6 * row_block + i;
            let count = if row_block == column_block { i + 1 } else { 6 };
            let place = self.start[row] as usize + 6 * column_block - self.first[row] as usize;
            self.entries[place..place + count].iter_mut().zip(values).for_each(|(entry, value)| *entry += value);
        }
    }

    /// Takes the root; false where the matrix is not positive.
    pub(super) fn factor(&mut self) -> bool {
        for row in 0..self.first.len() {
            let (first, start) = (self.first[row] as usize, self.start[row] as usize);
            let (above, own) = self.entries.split_at_mut(start);
            let mut pivot = own[row - first];
            for column in first..row {
                let (other_first, other_start) = (self.first[column] as usize, self.start[column] as usize);
                let from = first.max(other_first);
                let other = &above[other_start + from - other_first..=other_start + column - other_first];
                let (diagonal, other) = other.split_last().expect("every row has its diagonal");
                let sum: f64 = own[from - first..column - first].iter().zip(other).map(|(a, b)| a * b).sum();
                let entry = (own[column - first] - sum) / diagonal;
                own[column - first] = entry;
                pivot -= entry * entry;
            }
            if pivot.is_nan() || pivot <= 0.0 {
                return false;
            }
            own[row - first] = pivot.sqrt();
        }
        true
    }

    /// Solves A x = b in place.
    pub(super) fn solve(&self, x: &mut [f64]) {
        for row in 0..self.first.len() {
            let (before, diagonal) = self.row(row);
            let known = &x[self.first[row] as usize..row];
            let sum: f64 = before.iter().zip(known).map(|(a, b)| a * b).sum();
            x[row] = (x[row] - sum) / diagonal;
        }
        for row in (0..self.first.len()).rev() {
            let (before, diagonal) = self.row(row);
            let value = x[row] / diagonal;
            x[row] = value;
            for (other, entry) in x[self.first[row] as usize..row].iter_mut().zip(before) {
                *other -= entry * value;
            }
        }
    }

    /// Entries of a row before the diagonal, and that on it.
    fn row(&self, row: usize) -> (&[f64], f64) {
        let entries = &self.entries[self.start[row] as usize..self.start[row + 1] as usize];
        let (diagonal, before) = entries.split_last().expect("every row has its diagonal");
        (before, *diagonal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_with_gaps_is_solved_within_its_envelope() {
        // Blocks 0 to 3 begin in blocks 0, 0, 2, 1; every diagonal outweighs the rest of its row.
        let first = [0_usize, 0, 2, 1];
        let mut dense = [[0.0; 24]; 24];
        let mut matrix = Envelope::default();
        matrix.shape(first.iter().flat_map(|&first| [6 * first as u32; 6]));
        matrix.clear();
        for row in 0..4 {
            for column in first[row]..=row {
                let entry = |i: usize, j: usize| if row == column && i == j { 30.0 } else { ((i + j) % 5 + row) as f64 / 7.0 };
                let block = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
                matrix.add_block(row, column, &block);
                for i in 0..6 {
                    for j in 0..6 {
                        dense[6 * row + i][6 * column + j] = block[i][j];
                        dense[6 * column + j][6 * row + i] = block[i][j];
                    }
                }
            }
        }
        let expected: [f64; 24] = std::array::from_fn(|i| (i as f64 - 11.0) / 3.0);
        let mut x: Vec<f64> = dense.iter().map(|row| row.iter().zip(expected).map(|(a, b)| a * b).sum()).collect();
        assert!(matrix.factor());
        matrix.solve(&mut x);
        for (x, expected) in x.iter().zip(expected) {
            assert!((x - expected).abs() < 1e-12, "{x} against {expected}");
        }
    }
}
