//! Bounds along a chain of segments: the distance of its two ends in any pose that its joints allow.
//!
//! Joints p₀ … pₙ, segment i of length lᵢ from pᵢ to pᵢ₊₁. At pᵢ the angle between pᵢ→pᵢ₋₁ and pᵢ→pᵢ₊₁ lies in θminᵢ … θmaxᵢ; π is
//! straight. D and L are the bounds of |pᵢ − p₀|.
//!
//! **Upper.** By the triangle inequality, over one segment or over two whose chord is limited,
//!
//! ```text
//! Dᵢ₊₁ = min(Dᵢ + lᵢ, Dᵢ₋₁ + cᵢ),    cᵢ² = lᵢ₋₁² + lᵢ² − 2 lᵢ₋₁ lᵢ cos θmaxᵢ.
//! ```
//!
//! The greedy rule of the paper (its Fig. 3: bend each segment as far away as it goes) is no bound: with three segments of 1 m and
//! θmax of 180° and 90° it gives 2.236 m, where 2.414 m can be reached by bending the *first* joint.
//!
//! **Lower.** Curl the chain up as far as it goes: with αᵢ the angle at pᵢ between pᵢ→pᵢ₋₁ and pᵢ→p₀,
//!
//! ```text
//! φ = θminᵢ − αᵢ,    Lᵢ₊₁² = Lᵢ² + lᵢ² − 2 Lᵢ lᵢ cos φ,    αᵢ₊₁ from the same triangle,    ψ ← ψ + (its angle at p₀).
//! ```
//!
//! While φ > 0 and ψ ≤ π, the curled chain and its chord are a convex polygon, and by Cauchy's arm lemma (Schur's theorem for
//! polygons in space) no chain with greater angles brings its ends closer: the bound is exact. Once either fails the end can reach
//! around, and what holds is the triangle inequality alone,
//!
//! ```text
//! Lᵢ₊₁ = max(0, lᵢ − Dᵢ, Lᵢ − lᵢ, Lᵢ₋₁ − cᵢ, cminᵢ − Dᵢ₋₁).
//! ```
//!
//! Clamping φ at zero instead, as in the paper, gives 0.85 m for four segments of 1 m with θmin = 45°, whose ends can meet.

use std::f64::consts::PI;

/// Range of the angle between two segments at their joint (rad), π for straight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AngleRange {
    pub min: f64,
    pub max: f64,
}

impl AngleRange {
    pub(crate) const FREE: Self = Self { min: 0.0, max: PI };

    fn chord(a: f64, b: f64, angle: f64) -> f64 {
        (a * a + b * b - 2.0 * a * b * libm::cos(angle)).max(0.0).sqrt()
    }
}

/// Bounds of the distance from the start of a chain to its end so far, and what the next segment needs to know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ChainReach {
    /// Greatest and least distance (m).
    pub upper: f64,
    pub lower: f64,
    /// Both one joint before.
    before: (f64, f64),
    /// Length of the last segment.
    last: f64,
    /// αᵢ and ψ, while the lower bound is exact.
    curl: Option<(f64, f64)>,
}

impl ChainReach {
    /// A chain without segments.
    pub(crate) const START: Self = Self { upper: 0.0, lower: 0.0, before: (0.0, 0.0), last: 0.0, curl: Some((0.0, 0.0)) };

    /// The chain with one more segment of this length, at this angle to the last one.
    pub(crate) fn extended(&self, length: f64, angle: AngleRange) -> Self {
        if self.upper == 0.0 {
            return Self { upper: length, lower: length, before: (0.0, 0.0), last: length, curl: Some((0.0, 0.0)) };
        }
        let (widest, tightest) =
            (AngleRange::chord(self.last, length, angle.max), AngleRange::chord(self.last, length, angle.min));
        let upper = (self.upper + length).min(self.before.0 + widest);
        let (lower, curl) = match self.curled(length, angle.min) {
            Some((lower, curl)) => (lower, Some(curl)),
            None => {
                let over_one = (length - self.upper).max(self.lower - length);
                let over_two = (self.before.1 - widest).max(tightest - self.before.0);
                (over_one.max(over_two).max(0.0), None)
            }
        };
        Self { upper, lower, before: (self.upper, self.lower), last: length, curl }
    }

    /// Exact lower bound with one more segment, and its αᵢ₊₁ and ψ, while the curled chain is convex.
    fn curled(&self, length: f64, least_angle: f64) -> Option<(f64, (f64, f64))> {
        let (tip, turned) = self.curl?;
        let open = least_angle - tip;
        if open <= 0.0 || length == 0.0 || self.lower == 0.0 {
            return None;
        }
        let distance = AngleRange::chord(self.lower, length, open);
        if distance <= 1.0e-9 * (self.lower + length) {
            return None;
        }
        let cosine = (length * length + distance * distance - self.lower * self.lower) / (2.0 * length * distance);
        let next_tip = libm::acos(cosine.clamp(-1.0, 1.0));
        let next_turned = turned + (PI - open - next_tip);
        (next_turned <= PI).then_some((distance, (next_tip, next_turned)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along(lengths: &[f64], angles: &[(f64, f64)]) -> ChainReach {
        let mut reach = ChainReach::START.extended(lengths[0], AngleRange::FREE);
        for (&length, &(min, max)) in lengths[1..].iter().zip(angles) {
            reach = reach.extended(length, AngleRange { min: min.to_radians(), max: max.to_radians() });
        }
        reach
    }

    #[test]
    fn bending_the_first_joint_reaches_farther_than_bending_the_last() {
        let upper = along(&[1.0; 3], &[(0.0, 180.0), (0.0, 90.0)]).upper;
        assert!((upper - (1.0 + 2.0_f64.sqrt())).abs() < 1e-12, "{upper} m, reachable is 2.4142 m");
    }

    #[test]
    fn ends_that_can_meet_have_no_lower_bound() {
        let angles = [(45.0, 180.0); 3];
        let bends = |n: usize| along(&vec![1.0; n], &angles[..n - 1]).lower;
        assert!((bends(2) - 0.765_366_864_730_179_5).abs() < 1e-12, "two segments: {} m", bends(2));
        assert!((bends(3), bends(4)) == (0.0, 0.0), "three and four segments: {} m and {} m, reachable is 0", bends(3), bends(4));
    }

    #[test]
    fn a_chain_without_limits_reaches_the_sum_of_its_segments() {
        let reach = along(&[0.5, 1.5, 0.25], &[(0.0, 180.0); 2]);
        assert!((reach.upper - 2.25).abs() < 1e-12 && (reach.lower - 0.75).abs() < 1e-12, "{reach:?}");
    }

    #[test]
    fn a_stiff_chain_keeps_the_chord_of_its_arc() {
        // Five segments on a circle, each turned by at most 20°: the chord of the arc, by hand.
        let reach = along(&[1.0; 5], &[(160.0, 180.0); 4]);
        let radius = 0.5 / 10.0_f64.to_radians().sin();
        let chord = 2.0 * radius * 50.0_f64.to_radians().sin();
        assert!((reach.lower - chord).abs() < 1e-9, "{} m, the arc's chord is {chord} m", reach.lower);
        assert!((reach.upper - 5.0).abs() < 1e-12);
    }
}
