//! Random numbers for tests.

/// A linear congruential generator (Knuth's MMIX).
pub(crate) struct Noise(pub u64);

impl Noise {
    /// The next number, between −½ and ½.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}
