//! The header of a snapshot: what it is, what form it has, how long it is, and whether a bit of it has changed.

use super::refused;
use crate::error::Result;

const MAGIC: [u8; 8] = *b"longspan";

/// Number of the way in which rows and tables are written.
const FORMAT: u32 = 1;

/// magic (8), format (4), reserved (4), form (8), length (8), checksum (8)
const HEADER: usize = 40;
const CHECKSUM: std::ops::Range<usize> = 32..40;

/// Makes room for the header of a snapshot that is about to be written.
pub(crate) fn open(out: &mut Vec<u8>) {
    out.clear();
    out.resize(HEADER, 0);
}

/// Writes the header of a snapshot whose content is complete.
pub(crate) fn close(out: &mut [u8], form: u64) {
    let length = out.len() as u64;
    out[..8].copy_from_slice(&MAGIC);
    out[8..12].copy_from_slice(&FORMAT.to_le_bytes());
    out[12..16].fill(0);
    out[16..24].copy_from_slice(&form.to_le_bytes());
    out[24..32].copy_from_slice(&length.to_le_bytes());
    let sum = checksum(out);
    out[CHECKSUM].copy_from_slice(&sum.to_le_bytes());
}

/// The content of a snapshot that is whole, of this form.
pub(crate) fn content(bytes: &[u8], form: u64) -> Result<&[u8]> {
    let word = |at: usize| {
        let mut word = [0; 8];
        word.copy_from_slice(&bytes[at..at + 8]);
        u64::from_le_bytes(word)
    };
    if bytes.len() < HEADER || bytes[..8] != MAGIC {
        return Err(refused("is not a snapshot"));
    }
    if word(8) != u64::from(FORMAT) || word(16) != form {
        return Err(refused("was made by another version of the library"));
    }
    if word(24) != bytes.len() as u64 {
        return Err(refused("is cut short or too long"));
    }
    if word(CHECKSUM.start) != checksum(bytes) {
        return Err(refused("is corrupted"));
    }
    Ok(&bytes[HEADER..])
}

/// Hash of everything but the checksum itself, eight bytes at a time in four lanes (multiply and fold, as in wyhash).
fn checksum(bytes: &[u8]) -> u64 {
    let mut lanes = [0x9e37_79b9_7f4a_7c15_u64, 0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb, 0x2545_f491_4f6c_dd1d];
    let mix = |lane: &mut u64, word: u64| {
        let product = u128::from(*lane ^ word) * 0xa076_1d64_78bd_642f_u128;
        *lane = (product as u64) ^ ((product >> 64) as u64) ^ lane.rotate_left(23);
    };
    for part in [&bytes[..CHECKSUM.start], &bytes[CHECKSUM.end..]] {
        let mut blocks = part.chunks_exact(32);
        for block in &mut blocks {
            for (lane, word) in lanes.iter_mut().zip(block.as_chunks::<8>().0) {
                mix(lane, u64::from_le_bytes(*word));
            }
        }
        for (i, &byte) in blocks.remainder().iter().enumerate() {
            mix(&mut lanes[i % 4], u64::from(byte) | 0x100 << (i / 4));
        }
    }
    lanes.iter().fold(bytes.len() as u64, |mut sum, &lane| {
        mix(&mut sum, lane);
        sum
    })
}

/// Hash of the names of what is stored (FNV-1a).
pub(crate) fn form(listed: &[&str]) -> u64 {
    let text = [env!("CARGO_PKG_VERSION")].into_iter().chain(listed.iter().copied()).flat_map(str::bytes);
    text.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bit_that_changes_is_noticed() {
        let mut whole = Vec::new();
        open(&mut whole);
        whole.extend((0..333_u32).map(|i| (i * 7) as u8));
        close(&mut whole, 5);
        assert_eq!(content(&whole, 5).map(<[u8]>::len), Ok(333));
        assert!(content(&whole, 6).is_err(), "another form");
        for bit in 0..whole.len() * 8 {
            let mut changed = whole.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(content(&changed, 5).is_err(), "bit {bit}");
        }
        for length in 0..whole.len() {
            assert!(content(&whole[..length], 5).is_err(), "cut to {length} bytes");
        }
    }
}
