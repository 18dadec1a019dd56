//! Whether contacts can hold a body in balance: forces inside their friction cones that take its weight.
//!
//! Static equilibrium under weight w, with points p about the centre of mass, normals n into the body and forces f (N):
//!
//! ```text
//!   w + Σ f_k = 0,   Σ p_k × f_k = 0,   f_k ∈ K_k = { f : |f − (f·n_k) n_k| ≤ μ_k f·n_k }
//!   r = (w + Σ f_k, Σ p_k × f_k / reach),   can: min |r| ≤ share · |w|
//! ```
//!
//! With moments over the body's reach r is in newtons, and the least |r| the distance of −w from a convex cone: least squares in
//! multipliers x ≥ 0 of a few of its generators (Lawson and Hanson 1974, chapter 23), which are found on demand. With
//! g = r_f + r_m × p / reach, a force f at a contact changes |r|²/2 by f·g, so of its cone the generator n − μ t, t = g/|g| across n,
//! lowers it most: by g·n − μ |g across n|. Where that is nowhere below zero no force in any cone lowers it, and none comes nearer.

use glam::{DVec3, Vec3};

/// A point at which something may push a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PushPoint {
    /// From the body's centre of mass (m).
    pub lever: Vec3,
    /// Into the body.
    pub normal: Vec3,
    pub friction: f32,
    /// The caller's name for what pushes there.
    pub push: u32,
}

/// The pushes through which contacts carry a body; there may be fewer than six.
pub(crate) type Carriers = [Option<u32>; MOST];

/// A force, and a moment over the body's reach (N).
#[derive(Debug, Clone, Copy, Default)]
struct ScaledWrench {
    force: DVec3,
    moment: DVec3,
}

/// Generators that take part at once: no more are independent.
const MOST: usize = 6;

/// Generators that are tried: round cones are met by finitely many up to the share that may be left.
const TRIES: u32 = 60;

/// Share of what is left by which a generator must lower it, per unit of its multiplier.
const MIN_GAIN: f32 = 5.0e-3;

/// The pushes that can balance `weight` (N) at the centre of mass, up to a share of it; `reach` is that of the body (m).
pub(crate) fn carriers(touches: &[PushPoint], weight: Vec3, reach: f32, share: f32) -> Option<Carriers> {
    let weight = ScaledWrench { force: weight.as_dvec3(), moment: DVec3::ZERO };
    let limit = f64::from(share).powi(2) * weight.dot(&weight);
    let mut basis = Basis::default();
    let mut left = weight;
    for _ in 0..TRIES {
        if left.dot(&left) <= limit {
            return Some(basis.pushes());
        }
        let (force, moment) = (left.force.as_vec3(), left.moment.as_vec3() / reach);
        let rates = touches.iter().map(|touch| touch.rate(force, moment));
        let (best, rate) = touches.iter().zip(rates).min_by(|a, b| a.1.total_cmp(&b.1))?;
        if rate > -MIN_GAIN * left.dot(&left).sqrt() as f32 || basis.count == MOST {
            return None;
        }
        basis.take_in(best.steepest(&left, f64::from(reach)), best.push);
        left = basis.fit(&weight);
    }
    None
}

impl PushPoint {
    /// The least rate at which a force in its cone changes what is left of force and moment (the latter over the square of the reach).
    fn rate(&self, force: Vec3, moment: Vec3) -> f32 {
        let gradient = force + moment.cross(self.lever);
        let along = gradient.dot(self.normal);
        along - self.friction * (gradient.length_squared() - along * along).max(0.0).sqrt()
    }

    /// The generator of its cone with that rate, of length one.
    fn steepest(&self, left: &ScaledWrench, reach: f64) -> ScaledWrench {
        let (lever, normal) = (self.lever.as_dvec3() / reach, self.normal.as_dvec3());
        let gradient = left.force + left.moment.cross(lever);
        let across = (gradient - normal * gradient.dot(normal)).normalize_or_zero();
        let force = normal - across * f64::from(self.friction);
        let generator = ScaledWrench { force, moment: lever.cross(force) };
        ScaledWrench::default().plus(&generator, 1.0 / generator.dot(&generator).sqrt())
    }
}

impl ScaledWrench {
    fn dot(&self, other: &Self) -> f64 {
        self.force.dot(other.force) + self.moment.dot(other.moment)
    }

    fn plus(&self, other: &Self, factor: f64) -> Self {
        Self { force: self.force + other.force * factor, moment: self.moment + other.moment * factor }
    }
}

/// Generators with multipliers above zero (N).
#[derive(Debug, Default)]
struct Basis {
    generators: [ScaledWrench; MOST],
    multipliers: [f64; MOST],
    named: [u32; MOST],
    count: usize,
}

impl Basis {
    fn take_in(&mut self, generator: ScaledWrench, push: u32) {
        (self.generators[self.count], self.multipliers[self.count], self.named[self.count]) = (generator, 0.0, push);
        self.count += 1;
    }

    fn pushes(&self) -> Carriers {
        std::array::from_fn(|i| Some(self.named[i]).filter(|_| i < self.count))
    }

    /// Finds the multipliers ≥ 0 that leave least of `weight`, drops generators that have none, and says what is left.
    fn fit(&mut self, weight: &ScaledWrench) -> ScaledWrench {
        loop {
            let wanted = self.unbounded(weight);
            let now = self.multipliers;
            let step = |i: usize| if wanted[i] > 0.0 { 1.0 } else { now[i] / (now[i] - wanted[i]) };
            let Some(first) = (0..self.count).min_by(|&i, &j| step(i).total_cmp(&step(j))) else { break };
            let whole = step(first) >= 1.0;
            for i in 0..self.count {
                self.multipliers[i] = if whole { wanted[i] } else { now[i] + step(first) * (wanted[i] - now[i]) };
            }
            if whole {
                break;
            }
            self.multipliers[first] = 0.0;
            self.drop_unused();
        }
        let terms = self.generators[..self.count].iter().zip(self.multipliers);
        terms.fold(*weight, |left, (generator, multiplier)| left.plus(generator, multiplier))
    }

    fn drop_unused(&mut self) {
        let mut kept = 0;
        for i in 0..self.count {
            if self.multipliers[i] > 0.0 {
                (self.generators[kept], self.multipliers[kept]) = (self.generators[i], self.multipliers[i]);
                self.named[kept] = self.named[i];
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// The multipliers of either sign that leave least, by Cholesky factors L Lᵀ of the products of the generators.
    fn unbounded(&self, weight: &ScaledWrench) -> [f64; MOST] {
        let mut factor = [[0.0; MOST]; MOST];
        let mut x = [0.0; MOST];
        for i in 0..self.count {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let product = self.generators[i].dot(&self.generators[j]) - known;
                factor[i][j] = if i == j { product.max(f64::EPSILON).sqrt() } else { product / factor[j][j] };
            }
            let known: f64 = (0..i).map(|k| factor[i][k] * x[k]).sum();
            x[i] = (-self.generators[i].dot(weight) - known) / factor[i][i];
        }
        for i in (0..self.count).rev() {
            let known: f64 = (i + 1..self.count).map(|k| factor[k][i] * x[k]).sum();
            x[i] = (x[i] - known) / factor[i][i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn carries(touches: &[(Vec3, Vec3)], friction: f32) -> bool {
        let touches: Vec<PushPoint> =
            touches.iter().map(|&(lever, normal)| PushPoint { lever, normal, friction, push: 0 }).collect();
        carriers(&touches, Vec3::NEG_Y * 10.0, 1.0, 0.02).is_some()
    }

    /// Points in front of and behind one in the plane, which take moments about the axes across depth.
    fn both(lever: Vec3, normal: Vec3) -> [(Vec3, Vec3); 2] {
        [(lever + Vec3::Z, normal), (lever - Vec3::Z, normal)]
    }

    #[test]
    fn a_wedge_hangs_where_its_faces_lean_less_than_friction_holds() {
        for (lean, friction, expected) in [(0.17_f32, 0.0, true), (-0.17, 0.1, false), (-0.17, 0.3, true), (0.0, 0.0, false)] {
            let normal = |side: f32| Vec3::new(-side * lean.cos(), lean.sin(), 0.0);
            let touches = [both(Vec3::X, normal(1.0)), both(Vec3::NEG_X, normal(-1.0))].concat();
            assert_eq!(carries(&touches, friction), expected, "{lean} rad, {friction}");
        }
    }

    #[test]
    fn a_ladder_stands_by_friction_at_its_foot() {
        // Leaning by 45° against a wall without friction: half the weight pushes against the wall.
        let stands = |friction: f32| {
            let on = |(lever, normal): (Vec3, Vec3), friction: f32| PushPoint { lever, normal, friction, push: 0 };
            let mut touches: Vec<PushPoint> = both(Vec3::new(-1.0, -1.0, 0.0), Vec3::Y).map(|touch| on(touch, friction)).to_vec();
            touches.extend(both(Vec3::new(1.0, 1.0, 0.0), Vec3::NEG_X).map(|touch| on(touch, 0.0)));
            carriers(&touches, Vec3::NEG_Y * 10.0, 1.5, 0.02).is_some()
        };
        assert!(stands(0.51) && !stands(0.46));
    }

    #[test]
    fn cones_are_round() {
        // A slope of atan 0.5 in any direction needs a friction of 0.5.
        for turn in 0..16 {
            let (sin, cos) = (turn as f32 * 0.4).sin_cos();
            let normal = Vec3::new(0.5 * cos, 1.0, 0.5 * sin).normalize();
            let (u, v) = normal.any_orthonormal_pair();
            let touches: Vec<(Vec3, Vec3)> = [u, -u, v, -v].map(|across| (across - 0.1 * normal, normal)).to_vec();
            assert!(carries(&touches, 0.51) && !carries(&touches, 0.46), "direction {turn}");
        }
    }

    #[test]
    fn what_stands_beside_its_contacts_is_not_carried() {
        let feet =
            |from: f32, to: f32| [both(Vec3::new(from, -1.0, 0.0), Vec3::Y), both(Vec3::new(to, -1.0, 0.0), Vec3::Y)].concat();
        assert!(carries(&feet(-1.0, 1.0), 0.5));
        assert!(!carries(&feet(0.2, 1.0), 0.5));
        assert!(!carries(&[], 0.5));
    }
}
