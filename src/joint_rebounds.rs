//! Stops of a joint with restitution: see [`crate::solve::joint::rebound`].

/// Stops that were met in the last substep and give back part of that, where sweeps solve them: the fastest two.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rebounds {
    /// Numbers of their rows.
    pub(crate) rows: [u8; 2],
    /// Speeds at which they are to be left (m/s, rad/s); zero for none.
    pub(crate) speeds: [f32; 2],
}

impl Rebounds {
    pub(crate) const NONE: Self = Self { rows: [0; 2], speeds: [0.0; 2] };

    /// Speed at which the stop of this row is to be left.
    pub(crate) fn of(&self, row: u8) -> f32 {
        self.rows.iter().zip(self.speeds).filter(|&(&own, _)| own == row).map(|(_, speed)| speed).fold(0.0, f32::max)
    }

    pub(crate) fn add(&mut self, row: u8, speed: f32) {
        let slowest = usize::from(self.speeds[1] < self.speeds[0]);
        if speed > self.speeds[slowest] {
            (self.rows[slowest], self.speeds[slowest]) = (row, speed);
        }
    }
}
