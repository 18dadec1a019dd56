//! Impact law: the velocities after everything that hits at once.
//!
//! Of points that press at the end of a substep, those that closed in faster than a threshold have hit. The velocities v⁻ from before any
//! contact acted are what they hit with. From there on:
//!
//! 1. *Rounds.* Points that close in faster than the threshold are to leave at −e J v, all at once: λ ≥ 0, J v + e J v⁻ ≥ 0, one of them
//!    zero. Sweeps to and fro find λ; after each, λ and what it has done to velocities, Δ = M⁻¹ Jᵀ λ, are scaled by the
//!
//!    ```text
//!    s = −Σ λ (J v⁻ + e J v⁻) / Σ λ J Δ        at which   ½ Δᵀ M Δ + Σ λ (1 + e) J v⁻   is least.
//!    ```
//!
//!    A further round is for points that close in now: momentum goes on from body to body as in a row of balls, where a single solve of all
//!    would shatter it.
//! 2. *A last solve* of all points that press, with friction: J v ≥ 0, friction within μ (Λ + λ), Λ being what the rounds have
//!    pressed a manifold with.
//!
//! *Energy.* Impulses λ from v change what contacts see of the kinetic energy by Σ λ J v + ½ Σ λ J Δ, for Δᵀ M Δ = Σ λ J Δ. At the s above
//! that is −½ Σ λ (1 − e) |J v⁻| for one e, done or not: nothing is lost at e = 1, and never anything gained. For several e, and for
//! friction, s is bounded by −2 Σ λ J v / Σ λ J Δ, at which the change is zero. Where the host moves a side, J v is against it, and what it
//! gives by its motion is its work.
//!
//! The law knows bodies, points and rows, and nothing of what solves the rest of a step.

pub(crate) mod gather;
mod rows;

use glam::{DMat3, DVec3};

pub(crate) use rows::{ImpactManifold, ImpactPoint};

/// Rounds in an impact at most: a blow passes one contact in each. What still closes in after those is stopped.
const MAX_ROUNDS: usize = 24;

/// Sweeps of a round at most, and of the last solve. Scaled, a hundred manifolds under one box take some ten to a thousandth.
const MAX_SWEEPS: usize = 60;

/// Change of a normal speed in a sweep below which it is done, as a share of the greatest speed of approach.
const TOLERANCE: f64 = 1.0e-4;

/// A body in an impact, in world axes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ImpactBody {
    pub linear: DVec3,
    pub angular: DVec3,
    /// Zero along axes that are locked, and of what the host moves (1/kg).
    pub inverse_mass: DVec3,
    pub inverse_inertia: DMat3,
}

/// Bodies and contacts that are struck together.
#[derive(Debug, Default)]
pub(crate) struct Impact {
    pub bodies: Vec<ImpactBody>,
    pub manifolds: Vec<ImpactManifold>,
    pub points: Vec<ImpactPoint>,
    /// Velocities at the start of a round.
    from: Vec<ImpactBody>,
    /// Manifolds with points that hit in a round.
    active: Vec<u32>,
}

impl Impact {
    pub(crate) fn clear(&mut self) {
        self.bodies.clear();
        self.manifolds.clear();
        self.points.clear();
    }

    /// Solves the impact: velocities and multipliers of all that takes part. Points that close in faster than `threshold` (m/s) rebound.
    pub(crate) fn solve(&mut self, threshold: f64) {
        self.manifolds.iter_mut().for_each(|manifold| manifold.prepare(&self.bodies, &mut self.points));
        let mut fastest = threshold;
        for round in 0..MAX_ROUNDS {
            let Some(approach) = self.aim(threshold, round == 0) else { break };
            fastest = fastest.max(approach);
            self.pass_on(TOLERANCE * approach);
        }
        self.stop(TOLERANCE * fastest);
    }

    /// Finds what closes in faster than the threshold, and what it is to leave at; the greatest speed of approach, if there is any.
    fn aim(&mut self, threshold: f64, is_first: bool) -> Option<f64> {
        let Self { bodies, manifolds, points, active, .. } = self;
        active.clear();
        let mut fastest = 0.0;
        for (number, manifold) in manifolds.iter_mut().enumerate() {
            let mut any = false;
            for point in &mut points[manifold.points.clone()] {
                point.rate = manifold.rate(point, bodies);
                point.is_active = point.takes_part && point.rate < -threshold;
                if point.is_active {
                    point.lambda = 0.0;
                    // At the moment of the hit, gravity had not acted for the whole substep yet.
                    let speed = if is_first && point.impact_speed < -threshold { point.impact_speed } else { point.rate };
                    point.target = manifold.restitution * speed;
                    fastest = f64::max(fastest, -point.rate);
                    any = true;
                }
            }
            manifold.was_hit |= any;
            if any {
                active.push(number as u32);
            }
        }
        (fastest > 0.0).then_some(fastest)
    }

    /// One round.
    fn pass_on(&mut self, tolerance: f64) {
        self.from.clone_from(&self.bodies);
        for sweep in 0..MAX_SWEEPS {
            let Self { bodies, manifolds, points, active, .. } = self;
            let mut change = 0.0_f64;
            let mut press = |&number: &u32| change = change.max(manifolds[number as usize].press(bodies, points));
            if sweep % 2 == 0 {
                active.iter().for_each(&mut press)
            } else {
                active.iter().rev().for_each(&mut press)
            }
            self.scale();
            if change < tolerance {
                break;
            }
        }
        let Self { manifolds, points, active, .. } = self;
        for &number in active.iter() {
            let manifold = &mut manifolds[number as usize];
            for point in points[manifold.points.clone()].iter_mut().filter(|point| point.is_active) {
                point.blow += std::mem::take(&mut point.lambda);
                point.is_active = false;
            }
        }
    }

    /// Scales the multipliers of a round to where its energy is least, and not greater than it was.
    fn scale(&mut self) {
        let Self { bodies, manifolds, points, from, active } = self;
        let (mut slope, mut bend, mut work) = (0.0, 0.0, 0.0);
        for &number in active.iter() {
            let manifold = &manifolds[number as usize];
            for point in points[manifold.points.clone()].iter().filter(|point| point.is_active) {
                slope += point.lambda * (point.rate + point.target);
                bend += point.lambda * (manifold.rate(point, bodies) - point.rate);
                work += point.lambda * point.rate;
            }
        }
        if bend > 0.0 {
            let scale = (-slope / bend).min(-2.0 * work / bend).max(0.0);
            blend(bodies, from, scale);
            for &number in active.iter() {
                for point in points[manifolds[number as usize].points.clone()].iter_mut().filter(|point| point.is_active) {
                    point.lambda *= scale;
                }
            }
        }
    }

    /// The last solve: nothing that presses closes in, and friction acts.
    fn stop(&mut self, tolerance: f64) {
        let Self { bodies, manifolds, points, from, .. } = self;
        from.clone_from(bodies);
        for manifold in manifolds.iter_mut() {
            manifold.begin_last(from, bodies, points);
        }
        for sweep in 0..MAX_SWEEPS {
            let mut change = 0.0_f64;
            let count = manifolds.len();
            for place in 0..count {
                if sweep % 2 == 0 {
                    let manifold = &mut manifolds[place];
                    change = change.max(manifold.press(bodies, points));
                    manifold.rub(bodies, points);
                } else {
                    let manifold = &mut manifolds[count - 1 - place];
                    manifold.rub(bodies, points);
                    change = change.max(manifold.press(bodies, points));
                }
            }
            // It ends on the way back, with what presses.
            if change < tolerance && sweep % 2 == 1 {
                break;
            }
        }
        let (mut work, mut bend) = (0.0, 0.0);
        for manifold in manifolds.iter() {
            let [before, after] = [&*from, &*bodies].map(|bodies| manifold.power(bodies, points));
            (work, bend) = (work + before, bend + after - before);
        }
        // Energy that sweeps which are not done, or a disc that has shrunk, have made.
        if work + 0.5 * bend > 0.0 && bend > 0.0 {
            let scale = (-2.0 * work / bend).max(0.0);
            blend(bodies, from, scale);
            manifolds.iter_mut().for_each(|manifold| manifold.scale(points, scale));
        }
    }
}

/// Takes a share of how velocities have changed since.
fn blend(bodies: &mut [ImpactBody], from: &[ImpactBody], share: f64) {
    for (now, before) in bodies.iter_mut().zip(from) {
        now.linear = before.linear + (now.linear - before.linear) * share;
        now.angular = before.angular + (now.angular - before.angular) * share;
    }
}
