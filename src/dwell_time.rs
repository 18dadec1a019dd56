//! Timers of conditions: for how many seconds one has held without a break, so that waits are as long at every step rate.

use crate::tuning::stacks::SETTLING_TIME;

/// Time at which a timer stops counting (s).
const LONGEST: f32 = 60.0;

/// Share of a time that rounding of its sum may take: adding 1/240 s for four seconds is off by less than a tenth of it.
const ROUNDING: f32 = 1.0e-4;

/// Time for which a condition has held without a break (s), at most a minute.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct DwellTime(f32);

impl DwellTime {
    pub(crate) const NONE: Self = Self(0.0);
    /// Longer than anything waits for.
    pub(crate) const LONGEST: Self = Self(LONGEST);

    /// A timer that reaches `time` if its condition holds for `rest` more (s).
    pub(crate) const fn short_of(time: f32, rest: f32) -> Self {
        Self(time - rest)
    }

    /// A timer from its [`seconds`](Self::seconds), as a snapshot has them; `None` if out of range.
    pub(crate) fn from_seconds(time: f32) -> Option<Self> {
        (0.0..=LONGEST).contains(&time).then_some(Self(time))
    }

    pub(crate) fn seconds(self) -> f32 {
        self.0
    }

    /// Counts a step of `dt` (s) if the condition holds at its end; else starts anew.
    pub(crate) fn count(&mut self, holds: bool, dt: f32) {
        self.0 = if holds { (self.0 + dt).min(LONGEST) } else { 0.0 };
    }

    /// Whether it has held for this time (s).
    pub(crate) fn reaches(self, time: f32) -> bool {
        self.0 >= time * (1.0 - ROUNDING)
    }

    /// Whether the last step, of `dt` (s), has taken it to or past a multiple of `period` (s).
    pub(crate) fn completes(self, period: f32, dt: f32) -> bool {
        let periods = |time: f32| (time / (period * (1.0 - ROUNDING))).floor();
        periods(self.0) > periods((self.0 - dt).max(0.0))
    }

    pub(crate) fn total_cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }

    pub(crate) fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }
}

/// Timer of a body that a user places, as blocks of a tower are (s). Above zero it is what is left of the time for which the body counts as
/// just placed (young); below zero, the time for which nothing in its island may go fast across gravity before it counts as steady again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settling(f32);

impl Settling {
    /// Of a body that has just been made.
    pub(crate) const NEW: Self = Self(SETTLING_TIME);

    /// A timer from its [`seconds`](Self::seconds), as a snapshot has them; `None` if out of range.
    pub(crate) fn from_seconds(time: f32) -> Option<Self> {
        (-SETTLING_TIME..=SETTLING_TIME).contains(&time).then_some(Self(time))
    }

    pub(crate) fn seconds(self) -> f32 {
        self.0
    }

    /// Notes that the host has put the body somewhere else: a steady body is young again.
    pub(crate) fn put(&mut self) {
        if self.is_steady() {
            *self = Self::NEW;
        }
    }

    /// Counts a step of `dt` (s) towards zero if all in the body's island is slow across gravity; else the full wait begins anew.
    pub(crate) fn count(&mut self, is_slow: bool, dt: f32) {
        self.0 = match is_slow {
            false => -SETTLING_TIME,
            true if self.0.abs() < 1.5 * dt => 0.0,
            true => self.0 - dt.copysign(self.0),
        };
    }

    pub(crate) fn is_steady(self) -> bool {
        self.0 >= 0.0
    }

    /// Whether it was made or placed of late, and nothing in its island has gone fast since.
    pub(crate) fn is_young(self) -> bool {
        self.0 > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_reached_in_the_step_that_completes_it_at_every_rate() {
        for rate in [24.0_f32, 30.0, 50.0, 60.0, 90.0, 120.0, 144.0, 240.0, 1000.0] {
            for time in [0.05_f32, 0.1, 0.5, 2.5, 4.0] {
                let steps = (time * rate - 1.0e-3).ceil() as u32;
                let mut dwell = DwellTime::NONE;
                for step in 1..=steps {
                    assert!(!dwell.reaches(time), "{time} s are over before step {step} of {steps} at {rate} steps a second");
                    dwell.count(true, 1.0 / rate);
                }
                assert!(dwell.reaches(time), "{time} s are not over after {steps} steps at {rate} a second");
                dwell.count(false, 1.0 / rate);
                assert_eq!(dwell, DwellTime::NONE);
            }
        }
    }

    #[test]
    fn what_was_put_somewhere_is_young_for_a_while_and_what_was_thrown_is_not_steady_for_as_long() {
        for rate in [24.0_f32, 30.0, 60.0, 144.0, 240.0] {
            let steps = (SETTLING_TIME * rate).round() as u32;
            let mut settling = Settling::NEW;
            for _ in 1..steps {
                settling.count(true, 1.0 / rate);
            }
            assert!(settling.is_young() && settling.is_steady(), "a step early at {rate} steps a second");
            settling.count(true, 1.0 / rate);
            assert!(!settling.is_young() && settling.is_steady());
            settling.count(false, 1.0 / rate);
            settling.put();
            for _ in 1..steps {
                settling.count(true, 1.0 / rate);
            }
            assert!(!settling.is_young() && !settling.is_steady(), "a step early at {rate} steps a second");
            settling.count(true, 1.0 / rate);
            assert!(!settling.is_young() && settling.is_steady());
        }
    }

    #[test]
    fn each_period_is_completed_once() {
        for rate in [30.0_f32, 60.0, 144.0, 240.0] {
            let mut dwell = DwellTime::NONE;
            let mut completed = 0;
            for _ in 0..(10.0 * rate) as u32 + 1 {
                dwell.count(true, 1.0 / rate);
                completed += u32::from(dwell.completes(0.5, 1.0 / rate));
            }
            assert_eq!(completed, 20, "of half a second in ten, at {rate} steps a second");
        }
    }
}
