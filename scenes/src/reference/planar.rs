//! A planar chain of rigid links in minimal coordinates: the reference for the swinging weight.
//!
//! The state is the angle θ and its rate ω of every link, so joints cannot come apart. Link k hangs by its top from the bottom of
//! link k−1; u = (cos θ, sin θ) points along it, n = (−sin θ, cos θ) across; its centre of mass lies c below its top and d above its
//! bottom. With the force f_k at its top and −f_{k+1} at its bottom,
//!
//!   a = g + (f_k − f_{k+1})/m,    α = −n·(c f_k + d f_{k+1})/I,
//!   a_top = a − c α n + c ω² u,   a_bottom = a + d α n − d ω² u.
//!
//! Setting a_top of each link equal to a_bottom of the link above gives a symmetric block-tridiagonal system for the forces,
//! solved in one sweep down and one up; α follows. Classic Runge–Kutta of fourth order steps it.

use longspan::glam::{DMat2, DVec2};

/// Inner steps of a frame of 1/60 s: the fastest wave in a light chain under a heavy weight must be resolved.
pub const SUBSTEPS: u32 = 160;

/// One link.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// Mass (kg).
    pub mass: f64,
    /// Moment of inertia about the centre of mass, across the plane (kg·m²).
    pub inertia: f64,
    /// From its top to its centre of mass (m).
    pub to_center: f64,
    /// From its centre of mass to its bottom (m).
    pub to_bottom: f64,
}

/// The chain, hung from the origin.
#[derive(Debug, Clone)]
pub struct PlanarChain {
    links: Vec<Link>,
    gravity: DVec2,
    /// Angle of each link from the x axis (rad), then its rate (rad/s).
    state: Vec<[f64; 2]>,
}

impl PlanarChain {
    /// All links along x, at rest; gravity (m/s²) acts along −y.
    pub fn horizontal(links: Vec<Link>, gravity: f64) -> Self {
        let state = vec![[0.0; 2]; links.len()];
        Self { links, gravity: DVec2::new(0.0, -gravity), state }
    }

    /// Advances by `dt` (s) in `substeps` steps.
    pub fn advance(&mut self, dt: f64, substeps: u32) {
        let h = dt / f64::from(substeps);
        let offset = |state: &[[f64; 2]], rate: &[[f64; 2]], by: f64| -> Vec<[f64; 2]> {
            state.iter().zip(rate).map(|(s, r)| [s[0] + by * r[0], s[1] + by * r[1]]).collect()
        };
        for _ in 0..substeps {
            let k1 = self.rates(&self.state);
            let k2 = self.rates(&offset(&self.state, &k1, 0.5 * h));
            let k3 = self.rates(&offset(&self.state, &k2, 0.5 * h));
            let k4 = self.rates(&offset(&self.state, &k3, h));
            for (index, state) in self.state.iter_mut().enumerate() {
                for part in 0..2 {
                    state[part] += h / 6.0 * (k1[index][part] + 2.0 * (k2[index][part] + k3[index][part]) + k4[index][part]);
                }
            }
        }
    }

    /// Centre of mass of the last link (m).
    pub fn last_center(&self) -> DVec2 {
        self.centers().last().map_or(DVec2::ZERO, |(center, _)| *center)
    }

    /// Kinetic and potential energy (J), heights taken from the origin.
    pub fn energy(&self) -> f64 {
        let of_link = |((link, state), (center, velocity)): ((&Link, &[f64; 2]), (DVec2, DVec2))| {
            0.5 * (link.mass * velocity.length_squared() + link.inertia * state[1] * state[1])
                - link.mass * self.gravity.dot(center)
        };
        self.links.iter().zip(&self.state).zip(self.centers()).map(of_link).sum()
    }

    /// Position and velocity of every link's centre of mass.
    fn centers(&self) -> Vec<(DVec2, DVec2)> {
        let (mut top, mut top_velocity) = (DVec2::ZERO, DVec2::ZERO);
        let mut centers = Vec::with_capacity(self.links.len());
        for (link, &[angle, rate]) in self.links.iter().zip(&self.state) {
            let along = DVec2::from_angle(angle);
            let turning = rate * along.perp();
            centers.push((top + link.to_center * along, top_velocity + link.to_center * turning));
            top += (link.to_center + link.to_bottom) * along;
            top_velocity += (link.to_center + link.to_bottom) * turning;
        }
        centers
    }

    /// Rate of change of every link's angle and rate.
    fn rates(&self, state: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let forces = self.joint_forces(state);
        let rate_of = |(index, link): (usize, &Link)| {
            let across = DVec2::from_angle(state[index][0]).perp();
            let below = forces.get(index + 1).copied().unwrap_or(DVec2::ZERO);
            let moment = across.dot(link.to_center * forces[index] + link.to_bottom * below);
            [state[index][1], -moment / link.inertia]
        };
        self.links.iter().enumerate().map(rate_of).collect()
    }

    /// Force on every link at its top (N).
    fn joint_forces(&self, state: &[[f64; 2]]) -> Vec<DVec2> {
        let count = self.links.len();
        let mut diagonal = Vec::with_capacity(count);
        let mut right = Vec::with_capacity(count);
        // Coupling of each row to the one below; the matrix is symmetric.
        let mut coupling = Vec::with_capacity(count);
        let (mut above_block, mut above_pull) = (DMat2::ZERO, self.gravity);
        for (link, &[angle, rate]) in self.links.iter().zip(state) {
            let along = DVec2::from_angle(angle);
            let across = along.perp();
            let (c, d) = (link.to_center, link.to_bottom);
            let outer = DMat2::from_cols(across * across.x, across * across.y) * (1.0 / link.inertia);
            let inverse_mass = DMat2::from_diagonal(DVec2::splat(1.0 / link.mass));
            diagonal.push(inverse_mass + outer * (c * c) + above_block);
            right.push(-c * rate * rate * along - above_pull);
            coupling.push(outer * (c * d) - inverse_mass);
            above_block = inverse_mass + outer * (d * d);
            above_pull = d * rate * rate * along;
        }
        for row in 1..count {
            let factor = coupling[row - 1] * diagonal[row - 1].inverse();
            diagonal[row] -= factor * coupling[row - 1];
            right[row] = right[row] - factor * right[row - 1];
        }
        for row in (0..count).rev() {
            let below = if row + 1 < count { coupling[row] * right[row + 1] } else { DVec2::ZERO };
            right[row] = diagonal[row].inverse() * (right[row] - below);
        }
        right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Links and weight of the swinging weight with n = 30 and a ratio of 10,000.
    fn heavy_chain() -> PlanarChain {
        let link = Link { mass: 1.0, inertia: 0.0033, to_center: 0.1, to_bottom: 0.1 };
        let weight = Link { mass: 1.0e4, inertia: 1.0e4 / 6.0, to_center: 0.5, to_bottom: 0.5 };
        PlanarChain::horizontal([vec![link; 30], vec![weight]].concat(), 9.81)
    }

    #[test]
    fn the_reference_keeps_its_energy() {
        let mut chain = heavy_chain();
        let (start, scale) = (chain.energy(), 1.0e4 * 9.81 * 6.5);
        let mut drift = 0.0_f64;
        for _ in 0..240 {
            chain.advance(1.0 / 60.0, SUBSTEPS);
            drift = drift.max((chain.energy() - start).abs() / scale);
        }
        assert!(drift < 1e-9, "energy drifts by {drift:e} of the greatest fall, bound 1e-9");
    }

    #[test]
    fn the_reference_converges() {
        let (mut chain, mut finer) = (heavy_chain(), heavy_chain());
        chain.advance(4.0, 240 * SUBSTEPS);
        finer.advance(4.0, 240 * 2 * SUBSTEPS);
        let apart = chain.last_center().distance(finer.last_center());
        assert!(apart < 1e-6, "halving the step moves the weight by {apart:e} m, bound 1e-6 m");
    }

    #[test]
    fn one_link_swings_as_a_compound_pendulum() {
        let link = Link { mass: 3.0, inertia: 0.7, to_center: 0.8, to_bottom: 0.8 };
        let mut pendulum = PlanarChain::horizontal(vec![link], 9.81);
        let moment = link.inertia + link.mass * link.to_center * link.to_center;
        let rate = (link.mass * 9.81 * link.to_center / moment).sqrt();
        // From the horizontal, the quarter period is π/2 / (rate · agm(1, cos 45°)).
        let (mut a, mut b) = (1.0_f64, std::f64::consts::FRAC_PI_4.cos());
        for _ in 0..8 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        pendulum.advance(std::f64::consts::FRAC_PI_2 / (rate * a), 2000);
        let x = pendulum.last_center().x;
        assert!(x.abs() < 1e-9, "after a quarter period the weight is {x:e} m from the vertical, bound 1e-9 m");
    }
}
