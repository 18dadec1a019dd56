//! What every message begins with.

use bytemuck::{Pod, Zeroable};

/// The first eight bytes of every message: "LSSTREAM".
pub const LS_STREAM_MAGIC: u64 = 0x4D41_4552_5453_534C;

/// Number of the library's binary interface, which is part of the names of streams; LS_ABI_VERSION.
pub const LS_STREAM_ABI: u32 = 0;

/// Number of the schema: another one means bytes that a reader of this one cannot read.
pub const LS_STREAM_SCHEMA: u32 = 1;

/// Channel of frames: one message a published step, the latest wins.
pub const LS_STREAM_CHANNEL_HOT: u32 = 1;
/// Channel of records: ordered, none is left out, as long as a reader does not fall behind by more than the history.
pub const LS_STREAM_CHANNEL_COLD: u32 = 2;

/// Message flag: the whole scene begins to be told anew with this message.
pub const LS_STREAM_CYCLE_BEGINS: u32 = 1;
/// Message flag: with this message the whole scene has been told.
pub const LS_STREAM_CYCLE_ENDS: u32 = 2;
/// Message flag: state_hash is that of the world after the step.
pub const LS_STREAM_HAS_STATE_HASH: u32 = 4;

/// What every message begins with.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamHeader {
    /// LS_STREAM_MAGIC.
    pub magic: u64,
    /// LS_STREAM_SCHEMA.
    pub schema: u32,
    /// Bytes of this header; sections begin after them.
    pub header_size: u32,
    /// Hash of the names, offsets and sizes of all fields as the publisher was compiled.
    pub layout_hash: u64,
    /// Bytes of the message, this header included.
    pub length: u64,
    /// A number that differs between any two lives of a publisher.
    pub session: u64,
    /// Number of the message on its channel, from 1, without gaps.
    pub sequence: u64,
    /// Number of the step that it is about.
    pub step: u64,
    /// Simulated time at the end of that step (s).
    pub time: f64,
    /// Hash of the poses and velocities of all bodies of the world, as ls_world_state_hash_get gives it; see flags.
    pub state_hash: u64,
    /// Hash of all bytes after this header.
    pub content_hash: u64,
    /// Messages that the publisher could not place so far.
    pub dropped: u64,
    /// LS_STREAM_CHANNEL_ constant.
    pub channel: u32,
    /// Number of sections.
    pub section_count: u32,
    /// Bodies in the world.
    pub body_count: u32,
    /// Shapes in the world.
    pub shape_count: u32,
    /// Joints in the world.
    pub joint_count: u32,
    /// LS_STREAM_ message flags.
    pub flags: u32,
    /// How often the whole scene has begun to be told.
    pub cycle: u64,
    /// When it was published, by the system's clock: nanoseconds since 1970 began.
    pub clock: u64,
}

/// What every section of a message begins with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LsStreamSection {
    /// LS_STREAM_SECTION_ constant; one that a reader does not know is skipped.
    pub kind: u32,
    /// Bytes from one record to the next.
    pub stride: u32,
    /// Number of records.
    pub count: u32,
    /// Not used; 0.
    pub flags: u32,
    /// Bytes of the records, padding to a multiple of 8 included.
    pub length: u64,
    /// Not used; 0.
    pub reserved: u64,
}

/// Hash of the bytes after a message's header, in words of 8 bytes: four lanes, so that a processor does four words at once.
///
/// Word number `i` goes to lane `i mod 4`: `lane = rotate_left((lane xor word) * P, 29)`; at the end the lanes and the number of
/// words go through one more lane. It finds what was damaged; it does not stop who means harm.
#[derive(Debug, Clone)]
pub struct ContentHash {
    lanes: [u64; 4],
    words: u64,
}

impl Default for ContentHash {
    fn default() -> Self {
        Self { lanes: [0x243F_6A88_85A3_08D3, 0x1319_8A2E_0370_7344, 0xA409_3822_299F_31D0, 0x082E_FA98_EC4E_6C89], words: 0 }
    }
}

impl ContentHash {
    const FACTOR: u64 = 0x9E37_79B9_7F4A_7C15;

    fn mix(lane: u64, word: u64) -> u64 {
        (lane ^ word).wrapping_mul(Self::FACTOR).rotate_left(29)
    }

    /// Takes in bytes, a multiple of 8 of them.
    pub fn add(&mut self, bytes: &[u8]) {
        let word = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().expect("chunks of eight bytes"));
        let (head, body) = bytes.split_at(bytes.len().min(8 * ((4 - self.words % 4) % 4) as usize));
        for bytes in head.chunks_exact(8) {
            self.add_word(word(bytes));
        }
        let mut lanes = self.lanes;
        let fours = body.chunks_exact(32);
        let tail = fours.remainder();
        self.words += 4 * fours.len() as u64;
        for four in fours {
            for (lane, bytes) in lanes.iter_mut().zip(four.chunks_exact(8)) {
                *lane = Self::mix(*lane, word(bytes));
            }
        }
        self.lanes = lanes;
        for bytes in tail.chunks_exact(8) {
            self.add_word(word(bytes));
        }
    }

    fn add_word(&mut self, word: u64) {
        let lane = &mut self.lanes[(self.words % 4) as usize];
        *lane = Self::mix(*lane, word);
        self.words += 1;
    }

    /// The hash of all that was taken in.
    pub fn finish(&self) -> u64 {
        let last = self.lanes.iter().fold(self.words, |sum, &lane| Self::mix(sum, lane));
        last ^ (last >> 32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_does_not_depend_on_how_the_bytes_come() {
        let bytes: Vec<u8> = (0..=255).cycle().take(8 * 61).collect();
        let mut whole = ContentHash::default();
        whole.add(&bytes);
        for split in (0..=bytes.len()).step_by(8) {
            let mut parts = ContentHash::default();
            parts.add(&bytes[..split]);
            parts.add(&bytes[split..]);
            assert_eq!(parts.finish(), whole.finish(), "split after {split} bytes");
        }
    }

    #[test]
    fn every_bit_counts() {
        let mut bytes = vec![0_u8; 8 * 23];
        let hash = |bytes: &[u8]| {
            let mut hash = ContentHash::default();
            hash.add(bytes);
            hash.finish()
        };
        let clean = hash(&bytes);
        for bit in 0..8 * bytes.len() {
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(hash(&bytes), clean, "bit {bit}");
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        assert_ne!(hash(&bytes[8..]), clean, "a word of zeroes less");
    }
}
