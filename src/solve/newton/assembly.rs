//! The matrix of a substep: what all of its solves have alike is formed once, and terms add their G in each.

use super::elimination::Elimination;
use super::factor::{Factor, Vector};
use super::problem::Problem;
use super::term::{FIXED, Term};
use crate::platform::dispatched;

impl Problem {
    /// Fills and factorises the matrix.
    pub(super) fn factorize(&mut self) {
        if std::mem::take(&mut self.is_base_stale) {
            self.assemble_base();
            self.factor.keep();
        } else {
            self.factor.begin_again();
        }
        add_terms(&mut self.factor, &self.structure, &self.terms);
        self.factor.factorize(&self.structure);
        self.is_stale = false;
    }

    /// Fills the matrix with masses, links and what is stiff.
    fn assemble_base(&mut self) {
        let Self { masses, links, stiff, structure, factor, .. } = self;
        factor.start(structure);
        for (number, mass) in masses.iter().enumerate() {
            let block = factor.diagonal_mut(number as u32);
            for i in 0..3 {
                block[i][i] = mass.linear[i];
                for j in 0..3 {
                    block[3 + i][3 + j] = mass.angular[i][j] + mass.stiffness[i][j];
                }
            }
        }
        for (number, link) in links.iter().enumerate() {
            let node = (masses.len() + number) as u32;
            debug_assert!(link.rows <= usize::from(structure.sizes[node as usize]), "more rows than joints of its kind have");
            let block = factor.diagonal_mut(node);
            for row in 0..link.rows {
                block[row][row] -= link.give[row] + link.proximity[row];
            }
            // Rows that the joint has at other times, not in this substep.
            for row in link.rows..usize::from(structure.sizes[node as usize]) {
                block[row][row] = -1.0;
            }
            for side in (0..2).filter(|&side| link.bodies[side] != FIXED && link.rows > 0) {
                let at = structure.block(node, link.bodies[side]);
                factor.add(at, [link.rows, 6], |row, column| link.jacobian[side][row][column]);
            }
        }
        let mut place = Place::default();
        for stiff in stiff.iter() {
            let rows = [&stiff.jacobian[0], &stiff.jacobian[1]];
            add_row(factor, structure, &mut place, stiff.bodies, rows, stiff.gain);
        }
    }
}

dispatched!(
    /// Adds Jᵀ (G/R) J of each term.
    add_terms, add_terms_body, (factor: &mut Factor, structure: &Elimination, terms: &[Term])
);

#[inline(always)]
fn add_terms_body(factor: &mut Factor, structure: &Elimination, terms: &[Term]) {
    let mut place = Place::default();
    for term in terms {
        if term.rows == 1 {
            let gain = term.gain[0] / term.compliance;
            add_row(factor, structure, &mut place, term.bodies, [&term.jacobian[0][0], &term.jacobian[1][0]], gain);
            continue;
        }
        let [c, s] = term.slide;
        for (turned, gain) in [([c, s], term.gain[0]), ([-s, c], term.gain[1])] {
            if gain != 0.0 {
                let [a, b] = term.jacobian.map(|rows| combined(&rows, turned));
                add_row(factor, structure, &mut place, term.bodies, [&a, &b], gain / term.compliance);
            }
        }
    }
}

/// Where the block of two bodies is, looked up once for rows between them that follow one another.
#[derive(Debug, Clone, Copy)]
struct Place {
    bodies: [u32; 2],
    block: (usize, usize, bool),
}

impl Default for Place {
    fn default() -> Self {
        Self { bodies: [FIXED; 2], block: (0, 0, false) }
    }
}

#[inline(always)]
fn combined(rows: &[Vector; 2], [c, s]: [f64; 2]) -> Vector {
    std::array::from_fn(|i| c * rows[0][i] + s * rows[1][i])
}

/// Adds gain × Jᵀ J.
#[inline(always)]
fn add_row(factor: &mut Factor, structure: &Elimination, place: &mut Place, bodies: [u32; 2], jacobian: [&Vector; 2], gain: f64) {
    if gain == 0.0 {
        return;
    }
    for side in (0..2).filter(|&side| bodies[side] != FIXED) {
        let row = jacobian[side];
        for (line, a) in factor.diagonal_mut(bodies[side]).iter_mut().zip(row) {
            let scaled = gain * a;
            for (entry, b) in line.iter_mut().zip(row) {
                *entry += scaled * b;
            }
        }
    }
    if bodies[0] != FIXED && bodies[1] != FIXED {
        if place.bodies != bodies {
            *place = Place { bodies, block: structure.block(bodies[0], bodies[1]) };
        }
        let scaled = jacobian[0].map(|entry| gain * entry);
        factor.add(place.block, [6; 2], |i, j| scaled[i] * jacobian[1][j]);
    }
}
