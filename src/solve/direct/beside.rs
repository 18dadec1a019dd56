//! Contacts beside the factor of the joints.
//!
//! An active set of contacts takes a dozen passes where a load walks or tumbles, and each changes few rows of thousands. So the joints alone
//! are factorised, and the rows of contacts are its [`Border`]: what is left of them once the joints have answered is a dense matrix
//!
//! ```text
//! S = J_c M̃⁻¹ J_cᵀ + γ − Xᵀ X,      X = L⁻¹ J M̃⁻¹ J_cᵀ,
//! ```
//!
//! the inverse mass of the whole articulation at its contacts. The active set is found with it alone, as exactly as with the
//! whole matrix. Neither the structure of the factor nor its numbers depend on what touches what.

use super::body::DirectBody;
use super::free_rows::FreeRows;
use super::friction_cone::{FREE_BELOW, revise_cone};
use super::refine::Equations;
use super::row::{ContactRows, Row, RowState};
use super::topology::{SystemNode, Topology};
use crate::linalg::block::{Lanes, ZERO, width};
use crate::linalg::border::{self, Border};
use crate::linalg::factor::{self, BlockFactor, BlockLayout};

/// Share of a row's own coefficient up to which its pivot is rounding: what it asks for others do already.
const NOISE: f64 = 1.0e-14;

/// Most passes, of which the last ones free nothing any more, and those that may go by without fewer rows in the wrong state before they
/// are changed one by one: as where rows of contacts are in the factor.
const PASSES: usize = 40;
const CLOSING: usize = 6;
const PATIENCE: usize = 3;

/// Rows of contacts beside a factor, and room for their active set.
#[derive(Debug, Clone, Default)]
pub(super) struct BesideRows {
    /// Whether contacts of the system are beside its factor.
    pub is_on: bool,
    border: Border,
    /// Rows that take part, and their nodes.
    rows: Vec<u32>,
    nodes: Vec<u32>,
    /// Their errors, J v + b + γ p: now, without any of their multipliers, and as the active set goes on.
    errors: Vec<f64>,
    offsets: Vec<f64>,
    /// What is to be added to their multipliers.
    increments: Vec<Lanes>,
    /// Rows that are free, and the factor of their part of the matrix.
    free: Vec<u32>,
    root: Vec<f64>,
    wanted: Vec<f64>,
    flips: Vec<(usize, RowState)>,
    /// Whether the active set has been found for the solve that goes on.
    pub has_settled: bool,
    /// Whether it came to an end by itself.
    pub is_done: bool,
    /// Whether each body is one that they act on.
    touched: Vec<bool>,
}

impl BesideRows {
    /// Forms what is left of the contacts' rows once the joints have answered, whose factor is there.
    pub(super) fn form(
        &mut self,
        system: (&[SystemNode], &[Row], &[u32]),
        bodies: &[DirectBody],
        (factor, topology): (&BlockFactor, &Topology),
    ) {
        let (nodes, rows, index) = system;
        let plan = &topology.plan;
        let joints = plan.order().len();
        self.rows.clear();
        self.nodes.clear();
        for (number, node) in nodes.iter().enumerate().skip(joints) {
            let own = (node.first..node.last).filter(|&row| rows[row as usize].state != RowState::Absent);
            self.rows.extend(own);
            self.nodes.resize(self.rows.len(), number as u32);
        }
        if self.rows.is_empty() {
            return;
        }
        self.touched.clear();
        self.touched.resize(bodies.len(), false);
        for &node in &self.nodes {
            for body in nodes[node as usize].bodies.into_iter().filter(|&body| bodies[body as usize].is_dynamic()) {
                self.touched[body as usize] = true;
            }
        }
        let touches = |node: &SystemNode| node.bodies.iter().any(|&body| self.touched[body as usize]);
        let coupled = nodes[..joints].iter().zip(0..).filter(|(node, _)| touches(node)).map(|(_, number)| number);
        self.border.begin(factor, plan, coupled, self.rows.len());
        for (number, node) in nodes[..joints].iter().enumerate().filter(|(_, node)| touches(node)) {
            let lanes = factor.lanes(number);
            let own = &index[4 * lanes.start..];
            for (place, &row) in own.iter().enumerate().take(factor.rows(number)) {
                let row = &rows[row as usize];
                for (dense, (&other, &contact)) in self.rows.iter().zip(&self.nodes).enumerate() {
                    let ends = [node.bodies, nodes[contact as usize].bodies];
                    if let Some(share) = coupling([row, &rows[other as usize]], ends, bodies) {
                        *self.border.coupling_mut(number as u32, place, dense) += share;
                    }
                }
            }
        }
        for (i, (&row, &node)) in self.rows.iter().zip(&self.nodes).enumerate() {
            for (j, (&other, &contact)) in self.rows.iter().zip(&self.nodes).enumerate().skip(i) {
                let ends = [node, contact].map(|node| nodes[node as usize].bodies);
                let [row, other] = [row, other].map(|row| &rows[row as usize]);
                if let Some(share) = coupling([row, other], ends, bodies) {
                    *self.border.own_mut(i, j) += share;
                }
            }
            *self.border.own_mut(i, i) += rows[row as usize].gamma;
        }
        border::eliminate(&mut self.border, factor, plan);
    }

    /// Finds the multipliers, and which rows press and which slide, by what rows lack without any of them.
    fn settle(&mut self, rows: &mut [Row], contacts: &[ContactRows]) {
        let (mut fewest, mut patience, mut wrong) = (usize::MAX, PATIENCE, 0);
        let mut is_factored = false;
        for pass in 1..=PASSES {
            if !std::mem::replace(&mut is_factored, true) {
                self.factorize(rows);
            }
            self.solve_free(rows);
            let may_free = pass + CLOSING < PASSES;
            wrong = self.find_flips(rows, may_free);
            if wrong < fewest {
                (fewest, patience) = (wrong, PATIENCE);
            } else {
                patience = patience.saturating_sub(1);
            }
            let first = if patience == 0 && may_free { wrong.saturating_sub(1) } else { 0 };
            for &(place, state) in &self.flips[first..] {
                let row = &mut rows[self.rows[place] as usize];
                row.state = state;
                row.impulse = if state == RowState::Low { row.min } else { row.impulse };
                is_factored = false;
            }
            // Friction is revised once the rest has settled with it: both at once chase each other.
            let sliding = if wrong > 0 { 0 } else { self.revise_friction(rows, contacts, may_free, &mut is_factored) };
            if sliding > 0 {
                (fewest, patience) = (usize::MAX, PATIENCE);
            }
            if wrong + sliding == 0 {
                break;
            }
        }
        // The last passes free nothing: what they keep apart may still be gone through.
        self.is_done = wrong == 0 && self.find_flips(rows, true) == 0;
        self.has_settled = true;
        if !is_factored {
            self.factorize(rows);
        }
    }

    /// Lists the normals in the wrong state; returns how many.
    fn find_flips(&mut self, rows: &[Row], may_free: bool) -> usize {
        let Self { flips, errors, .. } = self;
        flips.clear();
        for (place, (&number, &error)) in self.rows.iter().zip(&*errors).enumerate() {
            let row = &rows[number as usize];
            match row.state {
                RowState::Free if row.impulse < row.min => flips.push((place, RowState::Low)),
                RowState::Low if may_free && error < -FREE_BELOW => flips.push((place, RowState::Free)),
                _ => {}
            }
        }
        flips.len()
    }

    /// Lets friction slide or stick; returns how many changes there were.
    fn revise_friction(&self, rows: &mut [Row], contacts: &[ContactRows], may_free: bool, is_factored: &mut bool) -> usize {
        let mut changes = 0;
        for contact in contacts.iter().filter(|contact| contact.has_friction) {
            let first = (contact.first + contact.normals) as usize;
            let pressed: f64 = rows[contact.first as usize..first].iter().map(|row| row.impulse.max(0.0)).sum();
            let place = self.rows.partition_point(|&row| (row as usize) < first);
            let [u, v, w] = &mut rows[first..first + 3] else { continue };
            let slip = |place: usize, row: &Row| self.errors[place] - row.gamma * row.impulse;
            let (along, about) = ([slip(place, u), slip(place + 1, v)], [slip(place + 2, w), 0.0]);
            let before = [u.state, w.state];
            changes += usize::from(revise_cone([u, v], along, contact.friction * pressed, may_free));
            // About the normal alone, the cone is an interval.
            let mut none = Row { state: w.state, ..Row::EMPTY };
            changes += usize::from(revise_cone([w, &mut none], about, contact.twist_arm * pressed, may_free));
            *is_factored &= before == [u.state, w.state];
        }
        changes
    }

    /// Lists the rows that are free, and factorises their part of the matrix.
    fn factorize(&mut self, rows: &[Row]) {
        let Self { free, root, border, .. } = self;
        free.clear();
        free.extend(
            (0..).zip(&self.rows).filter(|&(_, &row)| rows[row as usize].state == RowState::Free).map(|(place, _)| place),
        );
        let n = free.len();
        root.clear();
        root.resize(n * n, 0.0);
        for i in 0..n {
            let own = border.row(free[i] as usize);
            let (before, after) = root.split_at_mut(i * n);
            for j in 0..=i {
                let other = if j < i { &before[j * n..j * n + j + 1] } else { &[][..] };
                let mut value = own[free[j] as usize];
                let known = &after[..j];
                value -= known.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
                if j < i {
                    // The diagonal holds inverses, zero where a row has no pivot.
                    after[j] = value * other[j];
                } else {
                    value = own[free[i] as usize] - known.iter().map(|a| a * a).sum::<f64>();
                    let is_sound = value > NOISE * own[free[i] as usize].abs();
                    after[i] = if is_sound { value.sqrt().recip() } else { 0.0 };
                }
            }
        }
    }

    /// Solves the free rows' part of the matrix in place.
    fn substitute(&self, x: &mut [f64]) {
        let (n, root) = (self.free.len(), &self.root);
        for i in 0..n {
            let known: f64 = root[i * n..i * n + i].iter().zip(&*x).map(|(a, b)| a * b).sum();
            x[i] = (x[i] - known) * root[i * n + i];
        }
        for i in (0..n).rev() {
            x[i] *= root[i * n + i];
            let own = x[i];
            x[..i].iter_mut().zip(&root[i * n..i * n + i]).for_each(|(x, share)| *x -= share * own);
        }
    }

    /// Finds the multipliers of the free rows beside those of the others, and the errors that all are left with.
    fn solve_free(&mut self, rows: &mut [Row]) {
        let mut wanted = std::mem::take(&mut self.wanted);
        self.find_errors(rows);
        wanted.clear();
        wanted.extend(self.free.iter().map(|&place| -self.errors[place as usize]));
        self.substitute(&mut wanted);
        for (&place, change) in self.free.iter().zip(&wanted) {
            rows[self.rows[place as usize] as usize].impulse += change;
        }
        self.wanted = wanted;
        self.find_errors(rows);
    }

    /// Errors with the multipliers of now.
    fn find_errors(&mut self, rows: &[Row]) {
        self.errors.clone_from(&self.offsets);
        for (place, &number) in self.rows.iter().enumerate() {
            let impulse = rows[number as usize].impulse;
            if impulse != 0.0 {
                let own = self.border.row(place);
                self.errors.iter_mut().zip(own).for_each(|(error, share)| *error += share * impulse);
            }
        }
    }
}

/// The equations of joints that a factor holds, and of the contacts beside it.
pub(super) struct BesideEquations<'a> {
    pub joints: FreeRows<'a>,
    pub beside: &'a mut BesideRows,
    pub nodes: &'a [SystemNode],
    pub rows: &'a mut [Row],
    pub contacts: &'a [ContactRows],
}

impl Equations for BesideEquations<'_> {
    fn find_residuals(&mut self, factor: &BlockFactor, residuals: &mut [Lanes]) -> f64 {
        let mut worst = self.joints.find_residuals(factor, residuals);
        let Self { beside: BesideRows { rows: numbers, nodes, errors, has_settled, .. }, joints, rows, .. } = self;
        errors.clear();
        for (&number, &node) in numbers.iter().zip(&*nodes) {
            let row = &rows[number as usize];
            let pair = self.nodes[node as usize].bodies.map(|body| joints.rates[body as usize]);
            // Carried multipliers say which rows press; until that is known none of them acts.
            let impulse = if *has_settled { row.impulse } else { 0.0 };
            let error = row.rate(&pair) + row.bias + row.gamma * impulse;
            if row.state == RowState::Free || !*has_settled && error < 0.0 {
                worst = worst.max(error.abs());
            }
            errors.push(error);
        }
        worst
    }

    fn find_added(&mut self, factor: &BlockFactor, added: &mut [Lanes]) {
        self.joints.find_added(factor, added);
        self.beside.errors.fill(0.0);
    }

    fn solve(&mut self, factor: &BlockFactor, plan: &BlockLayout, unknowns: &mut [Lanes]) {
        let Self { beside, rows, contacts, .. } = self;
        if beside.rows.is_empty() {
            return factor::substitute(factor, plan, unknowns);
        }
        factor::substitute_forward(factor, plan, unknowns);
        beside.increments.clear();
        beside.increments.resize(width(beside.rows.len()), ZERO);
        border::gather(&beside.border, factor, unknowns, &mut beside.increments);
        let gathered = beside.increments.as_flattened();
        beside.offsets.clear();
        beside.offsets.extend(beside.errors.iter().zip(gathered).map(|(error, sum)| error + sum));
        beside.increments.fill(ZERO);
        if beside.has_settled {
            beside.wanted.clear();
            beside.wanted.extend(beside.free.iter().map(|&place| -beside.offsets[place as usize]));
            let mut wanted = std::mem::take(&mut beside.wanted);
            beside.substitute(&mut wanted);
            for (&place, change) in beside.free.iter().zip(&wanted) {
                beside.increments.as_flattened_mut()[place as usize] = *change;
            }
            beside.wanted = wanted;
        } else {
            beside.settle(rows, contacts);
            for (&number, increment) in beside.rows.iter().zip(beside.increments.as_flattened_mut()) {
                // Nothing of it acts yet.
                *increment = std::mem::take(&mut rows[number as usize].impulse);
            }
        }
        border::spread(&beside.border, factor, &beside.increments, unknowns);
        factor::substitute_back(factor, plan, unknowns);
    }

    fn add_impulses(&mut self, factor: &BlockFactor, increments: &[Lanes], share: f64) {
        self.joints.add_impulses(factor, increments, share);
        let Self { beside, rows, joints, nodes, .. } = self;
        let own = beside.increments.as_flattened();
        for ((&number, &node), increment) in beside.rows.iter().zip(&beside.nodes).zip(own) {
            let (row, impulse) = (&mut rows[number as usize], increment * share);
            row.impulse += impulse;
            for (side, body) in nodes[node as usize].bodies.into_iter().enumerate() {
                let (body, rate) = (&joints.bodies[body as usize], &mut joints.rates[body as usize]);
                rate.linear += body.inverse_mass * row.linear[side] * impulse;
                rate.angular += body.inverse_inertia * (row.angular[side] * impulse);
            }
        }
    }
}

/// What a multiplier of one row changes the rate of another by, J M̃⁻¹ Jᵀ; none where their nodes share no body.
fn coupling(rows: [&Row; 2], ends: [[u32; 2]; 2], bodies: &[DirectBody]) -> Option<f64> {
    let mut found = None;
    for (side, &body) in ends[0].iter().enumerate() {
        for other in (0..2).filter(|&other| ends[1][other] == body && bodies[body as usize].is_dynamic()) {
            let body = &bodies[body as usize];
            let linear = (body.inverse_mass * rows[1].linear[other]).dot(rows[0].linear[side]);
            let angular = (body.inverse_inertia * rows[1].angular[other]).dot(rows[0].angular[side]);
            found = Some(found.unwrap_or(0.0) + (linear + angular));
        }
    }
    found
}

#[cfg(test)]
mod tests;
