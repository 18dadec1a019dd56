//! Status of a manifold at the end of a step: whether it slips or parts, whether friction has reserve, and how its normal rises.
//! The solver writes it while the values are in cache; reading them later would touch eight cache lines.

use glam::Vec3;

/// What manifolds are measured by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StatusThresholds {
    /// Against gravity, and least cosine with it of a normal that rises.
    pub up: Vec3,
    pub rise: f32,
    /// Speeds of the surfaces across each other, the lesser first (m/s).
    pub slips: [f32; 2],
    /// Speeds of either sort, the lesser first (m/s).
    pub speeds: [f32; 2],
    /// Share of its limit below which friction has reserve.
    pub reserve: f32,
}

/// One manifold against [`StatusThresholds`], as bits; none where nothing is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct ContactStatus(u8);

impl ContactStatus {
    /// Values of the bits, which [`of`](Self::of) adds up: known at all; below each limit; with reserve; A under B, or B under A.
    pub(crate) const KNOWN: f32 = 1.0;
    pub(crate) const SLIPS: [f32; 2] = [2.0, 4.0];
    pub(crate) const SPEEDS: [f32; 2] = [8.0, 16.0];
    pub(crate) const RESERVE: f32 = 32.0;
    pub(crate) const RISES: [f32; 2] = [64.0, 128.0];

    pub(crate) const NOTHING: Self = Self(0);

    pub(crate) fn of(sum: f32) -> Self {
        Self(sum as u8)
    }

    #[cfg(test)]
    pub(crate) fn bits(self) -> u8 {
        self.0
    }

    fn has(self, bit: f32) -> bool {
        self.0 & bit as u8 != 0
    }

    pub(crate) fn is_known(self) -> bool {
        self.has(Self::KNOWN)
    }

    /// Whether it slips less than the lesser or the greater limit.
    pub(crate) fn slips_less(self, limit: usize) -> bool {
        self.has(Self::SLIPS[limit])
    }

    /// Whether it slips less and parts or closes more slowly than the lesser or the greater limit.
    pub(crate) fn is_slower(self, limit: usize) -> bool {
        self.has(Self::SPEEDS[limit])
    }

    pub(crate) fn has_reserve(self) -> bool {
        self.has(Self::RESERVE)
    }

    /// Which of the two bodies is under the other, as something to compare.
    pub(crate) fn rise(self) -> u8 {
        self.0 & (Self::RISES[0] as u8 | Self::RISES[1] as u8)
    }
}
