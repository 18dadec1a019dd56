//! Random numbers that are the same on every machine and in every version: xorshift64* (Vigna 2016) seeded by SplitMix64.

use longspan::glam::{Quat, Vec3};

/// A seeded generator.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// The generator of this seed.
    pub fn new(seed: u64) -> Self {
        let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self((z ^ (z >> 31)).max(1))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [`min`, `max`).
    pub fn between(&mut self, min: f32, max: f32) -> f32 {
        min + (max - min) * self.unit() as f32
    }

    /// Uniform in the logarithm.
    pub fn log_between(&mut self, min: f32, max: f32) -> f32 {
        (f64::from(min) * libm::pow(f64::from(max) / f64::from(min), self.unit())) as f32
    }

    /// Below `count`.
    pub fn index(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// Each component uniform in [−`extent`, `extent`).
    pub fn vector(&mut self, extent: f32) -> Vec3 {
        Vec3::new(self.between(-extent, extent), self.between(-extent, extent), self.between(-extent, extent))
    }

    /// Uniform over all rotations (Shoemake 1992).
    pub fn rotation(&mut self) -> Quat {
        let (u, v, w) = (self.unit(), self.unit() * std::f64::consts::TAU, self.unit() * std::f64::consts::TAU);
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        let ((sin_v, cos_v), (sin_w, cos_w)) = (libm::sincos(v), libm::sincos(w));
        Quat::from_xyzw((a * sin_v) as f32, (a * cos_v) as f32, (b * sin_w) as f32, (b * cos_w) as f32).normalize()
    }
}
