//! Restitution of stops: a stop that is met at v is left at −e v.
//!
//! v is the speed at the moment of impact, somewhere inside a substep. With C the distance to the stop and Ċ its rate at the substep's
//! start, and C̈ all but constant within it,
//!
//! ```text
//! v² = Ċ² − 2 C̈ C,
//! ```
//!
//! so that what falls on a stop at e = 1 comes up as high as it fell from, wherever in the substep it is met. A direct solve gives that back
//! at the end of the substep; where joints are swept, with contacts or by themselves, the row of the stop asks for it in the next
//! one, J v ≥ e v, with all other rows: only so do sweeps see what hangs on a body.
//!
//! A stop rebounds if it presses and did not before. One that is left more slowly than the forces bring back within a substep goes on pressing,
//! and comes to rest.

use super::rows::ScalarRow;

/// Speed at which a stop is met, of a coordinate at this distance from it with this rate and its rate of change (m, m/s, m/s²; or rad).
pub(crate) fn speed_of_impact(distance: f64, rate: f64, acceleration: f64) -> f64 {
    let square = rate * rate - 2.0 * acceleration * distance.max(0.0);
    if rate >= 0.0 && acceleration >= 0.0 { 0.0 } else { square.max(0.0).sqrt() }
}

/// Speed that is asked of a stop in the substep of length `h` (s) after the one that met it, of which the rate with all forces was `rate`:
/// `acceleration` (m/s²) acts in both.
pub(crate) fn speed_after(restitution: f32, distance: f64, rate: f64, acceleration: f64, h: f64) -> f64 {
    let met_at = speed_of_impact(distance, rate - acceleration * h, acceleration);
    (f64::from(restitution) * met_at + acceleration * h).max(0.0)
}

impl ScalarRow {
    /// Whether the row is a stop's.
    pub(crate) fn is_stop(&self) -> bool {
        self.min == 0.0 && self.max == f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_falls_on_a_stop_meets_it_at_the_speed_of_its_fall() {
        for distance in [0.0, 0.01, 0.04] {
            let (fallen, g) = (1.0 - distance, 9.81_f64);
            let speed = speed_of_impact(distance, -(2.0 * g * fallen).sqrt(), -g);
            assert!((speed - (2.0 * g).sqrt()).abs() < 1.0e-12, "{distance} m above the stop: {speed} m/s");
        }
        assert_eq!(speed_of_impact(0.1, 1.0, 2.0), 0.0, "of what goes away");
    }
}
