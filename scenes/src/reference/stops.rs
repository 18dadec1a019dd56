//! A planar chain whose links stop at a greatest angle to one another, without rebound.
//!
//! Links lie along u(θ) = (cos θ, sin θ) one after another from the origin. With L_k the length of link k, r_k the way from its top
//! to its centre of mass and m_k its mass, the centre of link i is Σ_{k<i} L_k u_k + r_i u_i, so with w_ik = L_k for k < i and
//! w_ii = r_i the kinetic energy is ½ Σ_jk M_jk ω_j ω_k, M_jk = cos(θ_j − θ_k) Σ_i m_i w_ij w_ik + I_k [j = k], and
//!
//!   Σ_k M_jk ω̇_k = −Σ_k sin(θ_j − θ_k) ω_k² Σ_i m_i w_ij w_ik − g cos θ_j Σ_i m_i w_ij.
//!
//! A stop keeps s (θ_k − θ_{k−1}) ≤ limit, s = ±1, θ_{−1} = 0. Stepping (Moreau 1988): angles move by half a step, velocities by
//! the smooth forces there; at stops that would be passed in the other half, impulses p ≥ 0 take away just what would pass them,
//! G(ω + M⁻¹ Gᵀ p) ≤ gap/(h/2), complementary: a linear complementarity problem with a positive definite matrix, which least-index
//! principal pivoting (Murty 1974) solves in finitely many steps; then angles move by the other half. Second order in h where no
//! stop is struck; smooth and struck motions need no other treatment.

use super::planar::Link;
use longspan::glam::DVec2;

/// The chain and its motion.
#[derive(Debug, Clone)]
pub struct StoppedChain {
    links: Vec<Link>,
    gravity: f64,
    limit: f64,
    angles: Vec<f64>,
    rates: Vec<f64>,
    /// Σ_i m_i w_ij w_ik and Σ_i m_i w_ij.
    coupling: Vec<Vec<f64>>,
    lever: Vec<f64>,
    /// Stops with an impulse in the last step: where the search starts.
    held: Vec<bool>,
}

impl StoppedChain {
    /// All links along x, at rest, each free by ± `limit` (rad) against the one before, the first against x; gravity along −y.
    pub fn horizontal(links: Vec<Link>, gravity: f64, limit: f64) -> Self {
        let count = links.len();
        let way = |i: usize, k: usize| match k.cmp(&i) {
            std::cmp::Ordering::Less => links[k].to_center + links[k].to_bottom,
            std::cmp::Ordering::Equal => links[i].to_center,
            std::cmp::Ordering::Greater => 0.0,
        };
        let sum = |of: &dyn Fn(usize) -> f64| (0..count).map(|i| links[i].mass * of(i)).sum::<f64>();
        let coupling = (0..count).map(|j| (0..count).map(|k| sum(&|i| way(i, j) * way(i, k))).collect()).collect();
        let lever = (0..count).map(|j| sum(&|i| way(i, j))).collect();
        let (angles, rates) = (vec![0.0; count], vec![0.0; count]);
        Self { links, gravity, limit, angles, rates, coupling, lever, held: vec![false; 2 * count] }
    }

    /// Advances by `dt` (s) in `substeps` steps.
    pub fn advance(&mut self, dt: f64, substeps: u32) {
        for _ in 0..substeps {
            self.step(dt / f64::from(substeps));
        }
    }

    /// Centre of mass of every link (m).
    pub fn centers(&self) -> Vec<DVec2> {
        let mut top = DVec2::ZERO;
        let mut centers = Vec::with_capacity(self.links.len());
        for (link, &angle) in self.links.iter().zip(&self.angles) {
            let along = DVec2::from_angle(angle);
            centers.push(top + link.to_center * along);
            top += (link.to_center + link.to_bottom) * along;
        }
        centers
    }

    fn step(&mut self, h: f64) {
        let count = self.links.len();
        for (angle, rate) in self.angles.iter_mut().zip(&self.rates) {
            *angle += 0.5 * h * rate;
        }
        let (angles, rates) = (&self.angles, &self.rates);
        let along: Vec<DVec2> = angles.iter().map(|&angle| DVec2::from_angle(angle)).collect();
        let factor = Cholesky::of(count, |j, k| {
            let own = if j == k { self.links[k].inertia } else { 0.0 };
            along[j].dot(along[k]) * self.coupling[j][k] + own
        });
        let moved_by_forces = |rates: &[f64]| {
            let mut change: Vec<f64> = (0..count)
                .map(|j| {
                    let swing = |k: usize| along[k].perp_dot(along[j]) * self.coupling[j][k] * rates[k] * rates[k];
                    -h * ((0..count).map(swing).sum::<f64>() + self.gravity * along[j].x * self.lever[j])
                })
                .collect();
            factor.solve(&mut change);
            change
        };
        // The second pass has the rates of the middle of the step, where the angles are already.
        let middle: Vec<f64> = rates.iter().zip(moved_by_forces(rates)).map(|(rate, change)| rate + 0.5 * change).collect();
        let free: Vec<f64> = rates.iter().zip(moved_by_forces(&middle)).map(|(rate, change)| rate + change).collect();

        // Stop 2k keeps link k from turning further up against the one before, stop 2k + 1 from turning further down.
        let before = |of: &[f64], k: usize| if k == 0 { 0.0 } else { of[k - 1] };
        let sign = |stop: usize| if stop.is_multiple_of(2) { 1.0 } else { -1.0 };
        let gaps: Vec<f64> =
            (0..2 * count).map(|stop| self.limit - sign(stop) * (angles[stop / 2] - before(angles, stop / 2))).collect();
        let excess = |rates: &[f64], stop: usize| {
            let k = stop / 2;
            sign(stop) * (rates[k] - before(rates, k)) - gaps[stop].max(0.0) / (0.5 * h)
        };
        let mut rates = free.clone();
        let mut near: Vec<usize> = (0..2 * count).filter(|&stop| excess(&free, stop) > 0.0 || self.held[stop]).collect();
        while !near.is_empty() {
            // Columns of M⁻¹ Gᵀ.
            let columns: Vec<Vec<f64>> = near
                .iter()
                .map(|&stop| {
                    let mut column = vec![0.0; count];
                    column[stop / 2] = -sign(stop);
                    if stop / 2 > 0 {
                        column[stop / 2 - 1] = sign(stop);
                    }
                    factor.solve(&mut column);
                    column
                })
                .collect();
            let effect = |row: usize, column: usize| {
                let k = near[row] / 2;
                -sign(near[row]) * (columns[column][k] - before(&columns[column], k))
            };
            let excesses: Vec<f64> = near.iter().map(|&stop| excess(&free, stop)).collect();
            let impulses = complementary(&effect, &excesses, near.iter().map(|&stop| self.held[stop]).collect());
            rates.clone_from(&free);
            self.held.fill(false);
            for (column, (&stop, impulse)) in columns.iter().zip(near.iter().zip(impulses)) {
                self.held[stop] = impulse > 0.0;
                for (rate, by) in rates.iter_mut().zip(column) {
                    *rate += impulse * by;
                }
            }
            // What these impulses drive into other stops strikes in the same step.
            let known = near.len();
            let more: Vec<usize> = (0..2 * count).filter(|stop| !near.contains(stop) && excess(&rates, *stop) > 1e-9).collect();
            near.extend(more);
            if near.len() == known {
                break;
            }
        }
        for (angle, rate) in self.angles.iter_mut().zip(&rates) {
            *angle += 0.5 * h * rate;
        }
        self.rates = rates;
    }
}

/// p ≥ 0 with excess − W p ≤ 0 and their product zero, for a positive definite W, beginning with these p above zero.
fn complementary(matrix: &dyn Fn(usize, usize) -> f64, excess: &[f64], mut basic: Vec<bool>) -> Vec<f64> {
    let count = excess.len();
    loop {
        let active: Vec<usize> = (0..count).filter(|&row| basic[row]).collect();
        let mut solution: Vec<f64> = active.iter().map(|&row| excess[row]).collect();
        if !active.is_empty() {
            Cholesky::of(active.len(), |a, b| matrix(active[a], active[b])).solve(&mut solution);
        }
        let left = |row: usize| {
            let taken: f64 = active.iter().zip(&solution).map(|(&column, p)| matrix(row, column) * p).sum();
            excess[row] - taken
        };
        let wrong = |row: usize| match active.iter().position(|&active| active == row) {
            Some(place) => solution[place] < 0.0,
            None => left(row) > 1e-12 * (1.0 + excess[row].abs()),
        };
        match (0..count).find(|&row| wrong(row)) {
            Some(row) => basic[row] = !basic[row],
            None => {
                let mut impulses = vec![0.0; count];
                for (&row, &impulse) in active.iter().zip(&solution) {
                    impulses[row] = impulse;
                }
                return impulses;
            }
        }
    }
}

/// The factor L of a symmetric positive definite matrix L Lᵀ, by rows.
struct Cholesky {
    rows: Vec<Vec<f64>>,
}

impl Cholesky {
    fn of(count: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(count);
        for j in 0..count {
            let mut row: Vec<f64> = Vec::with_capacity(j + 1);
            for (k, above) in rows.iter().enumerate() {
                let known: f64 = row.iter().zip(above).map(|(a, b)| a * b).sum();
                row.push((entry(j, k) - known) / above[k]);
            }
            let known: f64 = row.iter().map(|a| a * a).sum();
            row.push((entry(j, j) - known).max(f64::MIN_POSITIVE).sqrt());
            rows.push(row);
        }
        Self { rows }
    }

    fn solve(&self, right: &mut [f64]) {
        for (j, row) in self.rows.iter().enumerate() {
            let known: f64 = row[..j].iter().zip(right.iter()).map(|(a, b)| a * b).sum();
            right[j] = (right[j] - known) / row[j];
        }
        for j in (0..right.len()).rev() {
            right[j] /= self.rows[j][j];
            let value = right[j];
            for (k, entry) in self.rows[j][..j].iter().enumerate() {
                right[k] -= entry * value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::PlanarChain;
    use super::*;

    fn links(count: usize, weight: f64) -> Vec<Link> {
        let link = Link { mass: 1.0, inertia: 0.0033, to_center: 0.1, to_bottom: 0.1 };
        let end = Link { mass: weight, inertia: weight / 6.0, to_center: 0.5, to_bottom: 0.5 };
        [vec![link; count], vec![end]].concat()
    }

    #[test]
    fn without_stops_it_moves_as_the_free_chain() {
        let mut stopped = StoppedChain::horizontal(links(4, 100.0), 9.81, std::f64::consts::TAU);
        let mut free = PlanarChain::horizontal(links(4, 100.0), 9.81);
        stopped.advance(0.5, 20_000);
        free.advance(0.5, 2000);
        let apart = stopped.centers()[4].distance(free.last_center());
        assert!(apart < 1e-3, "after half a second the two references lie {apart:e} m apart, bound 1 mm");
    }

    #[test]
    fn stops_are_never_passed_and_the_motion_converges() {
        let run = |substeps: u32| {
            let mut chain = StoppedChain::horizontal(links(5, 100.0), 9.81, 0.2);
            let mut past = 0.0_f64;
            for _ in 0..60 {
                chain.advance(1.0 / 60.0, substeps);
                let mut before = 0.0;
                for &angle in &chain.angles {
                    past = past.max((angle - before).abs() - 0.2);
                    before = angle;
                }
            }
            (chain.centers()[5], past)
        };
        let [(coarse, _), (fine, past), (finer, _)] = [50, 200, 800].map(run);
        assert!(past < 5e-4, "a stop of 0.2 rad is passed by {past:e} rad, bound 5e-4 rad");
        let (first, second) = (coarse.distance(finer), fine.distance(finer));
        assert!(second < 0.5 * first.max(1e-9), "errors of {first:e} m and {second:e} m at steps four times finer");
    }
}
