//! Tables of rows, each written as what differs from the row before.

use super::forms::{KnownForms, NumberedForms};
use super::stored::{Reader, Stored, Writer};

/// Tables are written here, one after the other.
pub(crate) struct Output<'a> {
    bytes: &'a mut Vec<u8>,
    row: Writer<'a>,
    last: Vec<u32>,
}

impl<'a> Output<'a> {
    pub(crate) fn new(bytes: &'a mut Vec<u8>, forms: &'a NumberedForms) -> Self {
        Self { bytes, row: Writer { words: Vec::new(), forms }, last: Vec::new() }
    }

    /// Writes a table: its number of rows, then each row.
    pub(crate) fn table<'b, T: Stored + 'b>(&mut self, rows: impl ExactSizeIterator<Item = &'b T>) {
        self.last.clear();
        self.number(rows.len() as u64);
        for row in rows {
            self.row.words.clear();
            row.put(&mut self.row);
            if !T::FIXED || self.last.is_empty() {
                self.length();
            }
            self.difference();
            std::mem::swap(&mut self.row.words, &mut self.last);
        }
    }

    /// Writes a row by itself, which `put` writes.
    pub(crate) fn row_of(&mut self, put: impl FnOnce(&mut Writer)) {
        self.last.clear();
        self.row.words.clear();
        put(&mut self.row);
        self.length();
        self.difference();
    }

    /// Seven bits a byte, the lowest first; the highest bit says that more follow.
    fn number(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }

    /// Length of the row against that of the last one.
    fn length(&mut self) {
        let change = self.row.words.len() as i64 - self.last.len() as i64;
        self.number(((change << 1) ^ (change >> 63)) as u64);
    }

    /// For each four words a byte of how long their differences from those of the last row are (two bits each, the first lowest),
    /// and those differences.
    fn difference(&mut self) {
        let (words, last) = (&self.row.words, &self.last);
        let is_masked = words.len() > MASKED;
        let mut mask_at = 0;
        for (group, four) in words.chunks(4).enumerate() {
            if is_masked && group % 8 == 0 {
                mask_at = self.bytes.len();
                self.bytes.push(0);
            }
            let is_same = |(i, word): (usize, &u32)| last.get(group * 4 + i).copied().unwrap_or(0) == *word;
            if is_masked {
                if four.iter().enumerate().all(is_same) {
                    continue;
                }
                self.bytes[mask_at] |= 1 << (group % 8);
            }
            let at = self.bytes.len();
            self.bytes.push(0);
            for (i, &word) in four.iter().enumerate() {
                let difference = word ^ last.get(group * 4 + i).copied().unwrap_or(0);
                let code =
                    LENGTHS.iter().rposition(|&length| u64::from(difference) >> (8 * length) != 0).map_or(0, |code| code + 1);
                self.bytes[at] |= (code as u8) << (2 * i);
                self.bytes.extend_from_slice(&difference.to_le_bytes()[..LENGTHS[code]]);
            }
        }
    }
}

/// Rows that room is made for before they are read.
const MAX_AT_ONCE: u64 = 1 << 14;

/// How many numbers a byte of a snapshot may stand for by runs. A number names a row of a table, which takes a byte or more, and there are
/// eleven lists of them: more numbers than this name nothing, and memory stays a multiple of the snapshot's length.
const NUMBERS_FOR_A_BYTE: u64 = 16;

/// Words of a row above which a byte for each eight groups of four tells which of them differ at all.
const MASKED: usize = 16;

/// Bytes of a difference, by its two bits: floats of about the same size agree in their highest byte, numbers in their upper two.
const LENGTHS: [usize; 4] = [0, 2, 3, 4];

/// Tables are read from here, in the order in which they were written.
pub(crate) struct Input<'a> {
    bytes: &'a [u8],
    forms: &'a KnownForms,
    tag: u16,
    row: Vec<u32>,
    numbers_left: u64,
}

impl<'a> Input<'a> {
    pub(crate) fn new(bytes: &'a [u8], forms: &'a KnownForms, tag: u16) -> Self {
        Self { bytes, forms, tag, row: Vec::new(), numbers_left: NUMBERS_FOR_A_BYTE * bytes.len() as u64 }
    }

    /// Reads a table; `None` if it makes no sense.
    pub(crate) fn table<T: Stored>(&mut self) -> Option<Vec<T>> {
        self.row.clear();
        let rows = self.number()?;
        // A row takes a byte or more.
        if rows > self.bytes.len() as u64 {
            return None;
        }
        // Beyond so many, room is made as rows turn out to be there.
        let mut table = Vec::with_capacity(rows.min(MAX_AT_ONCE) as usize);
        for _ in 0..rows {
            table.push(self.row()?);
        }
        Some(table)
    }

    /// Whether all has been read.
    pub(crate) fn is_done(&self) -> bool {
        self.bytes.is_empty()
    }

    /// How many bytes have not been read yet.
    pub(crate) fn remaining(&self) -> usize {
        self.bytes.len()
    }

    fn byte(&mut self) -> Option<u8> {
        let (&first, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(first)
    }

    /// The number of so many bytes, 1 to 4.
    fn short_word(&mut self, length: usize) -> Option<u32> {
        let word = match self.bytes.first_chunk() {
            Some(&whole) => u32::from_le_bytes(whole) & (u32::MAX >> (32 - 8 * length)),
            None => self.bytes.get(..length)?.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte)),
        };
        self.bytes = &self.bytes[length..];
        Some(word)
    }

    fn number(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..63).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// Reads a row that [`Output::row_of`] has written.
    pub(crate) fn row_of<T>(&mut self, take: impl FnOnce(&mut Reader) -> Option<T>) -> Option<T> {
        self.row.clear();
        self.length()?;
        self.row_with(take)
    }

    fn row<T: Stored>(&mut self) -> Option<T> {
        if !T::FIXED || self.row.is_empty() {
            self.length()?;
        }
        self.row_with(T::take)
    }

    fn length(&mut self) -> Option<()> {
        let zigzag = self.number()?;
        let change = (zigzag >> 1) as i64 ^ -((zigzag & 1) as i64);
        let len = usize::try_from(change.checked_add(self.row.len() as i64)?).ok()?;
        // Each 32 words take a byte or more.
        if len / 32 > self.bytes.len() {
            return None;
        }
        self.row.resize(len, 0);
        Some(())
    }

    fn row_with<T>(&mut self, take: impl FnOnce(&mut Reader) -> Option<T>) -> Option<T> {
        let len = self.row.len();
        let mut mask = u8::MAX;
        for group in 0..len.div_ceil(4) {
            if len > MASKED && group % 8 == 0 {
                mask = self.byte()?;
            }
            if mask >> (group % 8) & 1 == 0 {
                continue;
            }
            let codes = self.byte()?;
            for i in 0..4 {
                let length = LENGTHS[usize::from(codes >> (2 * i) & 3)];
                if length > 0 {
                    *self.row.get_mut(group * 4 + i)? ^= self.short_word(length)?;
                }
            }
        }
        let mut reader =
            Reader { words: &self.row, forms: self.forms, tag: self.tag, depth: 0, numbers_left: &mut self.numbers_left };
        let value = take(&mut reader)?;
        reader.words.is_empty().then_some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Runs;
    use super::*;

    #[test]
    fn a_few_bytes_do_not_stand_for_millions_of_numbers() {
        let (numbered, known) = (NumberedForms::default(), KnownForms::default());
        let mut bytes = Vec::new();
        Output::new(&mut bytes, &numbered).table([Runs((0..1 << 20).collect())].iter());
        assert!(bytes.len() < 16, "a run is short: {} bytes", bytes.len());
        assert!(Input::new(&bytes, &known, 1).table::<Runs>().is_none(), "no table has so many rows in so few bytes");
        // Beside as many rows as the numbers name they are taken.
        bytes.resize(bytes.len() + (1 << 20), 0);
        let read = Input::new(&bytes, &known, 1).table::<Runs>().expect("makes sense");
        assert_eq!(read[0].0.len(), 1 << 20);
    }

    #[test]
    fn rows_come_back_and_equal_ones_cost_next_to_nothing() {
        let rows: Vec<Vec<u32>> =
            (0..100).map(|i| (0..i % 7 * 9).map(|j| if j % 5 == 0 { i * j } else { 77 }).collect()).collect();
        let (mut bytes, numbered, known) = (Vec::new(), NumberedForms::default(), KnownForms::default());
        Output::new(&mut bytes, &numbered).table(rows.iter());
        let mut input = Input::new(&bytes, &known, 1);
        assert_eq!(input.table::<Vec<u32>>().as_ref(), Some(&rows));
        assert!(input.is_done());
        for length in 0..bytes.len() {
            assert!(Input::new(&bytes[..length], &known, 1).table::<Vec<u32>>().is_none(), "cut to {length} bytes");
        }
        let equal = vec![vec![5_u32; 80]; 1000];
        let mut bytes = Vec::new();
        Output::new(&mut bytes, &numbered).table(equal.iter());
        assert!(bytes.len() < 23_000, "{} bytes for 1000 equal rows of 81 words", bytes.len());
    }
}
