//! The rows of an articulation as one linear system, and the active set of those with bounds.
//!
//! With v₀ the velocities before any joint acts, M̃ = M + G the inertia that answers, and rows J v + b + γ p = 0,
//!
//! ```text
//! v = v₀ + M̃⁻¹ Jᵀ p,      (J M̃⁻¹ Jᵀ + γ) p = −(J v₀ + b).
//! ```
//!
//! A stop has p ≥ 0, a motor |p| ≤ its greatest impulse. Each such row is in one of three states: free, so that it is part of the
//! system, or at one of its bounds, where p is a constant push. A pass solves the system, then frees rows whose error wants another
//! multiplier and fixes those whose multiplier left its bounds (a primal–dual active set; Hintermüller et al. 2003). States are
//! read off the multipliers of the last substep, so that most solves take one pass. Where passes go round in a circle, one row at a
//! time changes its state, the last, until fewer are wrong than ever before: as the matrix is positive definite, that comes to an
//! end (block principal pivoting; Júdice and Pires 1994).
//!
//! The displacements of a projection are solved for in the same way, with v₀ = 0 and b the errors.

use glam::DVec3;

use super::beside::{BesideEquations, BesideRows};
use super::block::{Lanes, ZERO};
use super::body::DirectBody;
use super::factor::{self, BlockFactor};
use super::free_rows::FreeRows;
use super::packed_rows::{self, PackedRows};
use super::redundancy::Redundancy;
use super::refine::{MODERATIONS, refine};
use super::row::{ContactRows, MAX_IMPULSE, Origin, Row, RowState};
use super::topology::{SystemNode, Topology};
use crate::solve::joint::friction;
use crate::solve::joint::rows::{self, HeldDirections, Rate};

/// Most passes of the active set: nearly all solves take one, and the last ones (a third, at most [`MAX_CLOSING`]) free nothing
/// any more. Contacts ask for more than stops and motors; a projection is judged by what it reaches.
pub(crate) const PASSES: usize = 24;
pub(crate) const CONTACT_PASSES: usize = 40;
pub(crate) const PROJECTION_PASSES: usize = 4;
const MAX_CLOSING: usize = 6;

/// Passes that may go by without fewer rows in the wrong state before they are changed one by one.
const PATIENCE: usize = 3;

/// Compliance of a contact's row over its own response: of multipliers that hold equally, those of least norm are taken.
const CONTACT_COMPLIANCE: f64 = 1.0e-6;

/// Share of its bound from which on a carried multiplier starts as one that is at it.
const AT_BOUND: f64 = 1.0 - 1.0e-6;

/// Where a solve begins.
#[derive(Debug, Clone, Default)]
pub(super) struct SolveStart {
    pub rates: Vec<Rate>,
    /// By how much a body may turn faster after it before motors yield (rad/s).
    pub most_turn: f64,
}

/// All rows of an articulation, and room to solve them.
#[derive(Debug, Clone, Default)]
pub(crate) struct System {
    pub nodes: Vec<SystemNode>,
    pub rows: Vec<Row>,
    /// Sum of each row's multipliers over the substeps since they were handed back to the joints; empty where there are none.
    pub sums: Vec<f64>,
    pub contacts: Vec<ContactRows>,
    factor: BlockFactor,
    /// Those of contacts where they are no part of it.
    pub(super) beside: BesideRows,
    packed_rows: PackedRows,
    /// Rows in the system now, by node.
    counts: Vec<u32>,
    /// Unknowns and increments.
    room: [Vec<Lanes>; 2],
    pub(super) base: SolveStart,
    /// Whether the push of the multipliers is in the rates.
    pub(super) has_pushed: bool,
    /// Whether any row has bounds or takes no part, and those that have bounds, with their nodes.
    is_bounded: bool,
    pub(super) bounded: Vec<(u32, u32)>,
    /// Whether a solution by the factor has been found to need no refinement.
    is_exact: bool,
    /// Whether the factor is that of the rows that are free now.
    pub(super) is_factored: bool,
    /// Whether a lane of a [`ArticulationBatch`](super::articulation_batch::ArticulationBatch) holds the rows as they are now, but for biases that are new.
    pub(super) is_abreast: bool,
    pub(super) has_new_biases: bool,
    /// Rows in the wrong state, and the state that they want.
    pub(super) flips: Vec<(u32, RowState)>,
    /// Whether multipliers of rows that contradict each other are moderated.
    pub(super) moderates: bool,
    /// Whether every solve since this was set came to an end by itself.
    pub settled: bool,
}

impl System {
    /// Removes all rows.
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.rows.clear();
        self.sums.clear();
        self.contacts.clear();
    }

    /// Adds a joint's rows as the next node, to which rows of contacts may be added; `repeats` is said of rows that hold points, of
    /// a hinge those across its axis.
    pub(super) fn add(
        &mut self,
        bodies: [u32; 2],
        point: Option<&rows::BlockRow>,
        direction: Option<&rows::BlockRow>,
        scalars: &[rows::ScalarRow],
        repeats: Redundancy,
    ) {
        let first = self.rows.len() as u32;
        if let Some(block) = point {
            let mut axes = block.held.axes();
            let mut all = [repeats; 3];
            if repeats == Redundancy::InLine && matches!(block.held, HeldDirections::All) {
                all = [Redundancy::Often; 3];
                if let Some(rows::BlockRow { held: HeldDirections::Across(axis), .. }) = direction {
                    let (u, v) = rows::across(*axis);
                    (axes, all) = (([u, v, *axis], 3), [Redundancy::InLine, Redundancy::InLine, Redundancy::Often]);
                }
            }
            self.add_block(block, axes, all, |axis| {
                let [a, b] = block.levers;
                (rows::Jacobian { linear: axis, angular_a: a.cross(axis), angular_b: b.cross(axis) }, Origin::Point)
            });
        }
        if let Some(block) = direction {
            self.add_block(block, block.held.axes(), [Redundancy::Often; 3], |axis| {
                (rows::Jacobian::angular(axis), Origin::Direction)
            });
        }
        for row in scalars {
            let (bias, driven, gamma, min, max) = (row.bias, row.driven, row.gamma, row.min, row.max);
            let carried = f64::from(row.impulse);
            // A carried multiplier is rounded.
            let (state, impulse) = match (row.acts, min < max) {
                (false, _) => (RowState::Absent, carried),
                (true, true) if carried > min * AT_BOUND && carried < max * AT_BOUND => (RowState::Free, carried),
                (true, _) if carried <= min * AT_BOUND => (RowState::Low, min),
                _ => (RowState::High, max),
            };
            let (origin, repeats) = match row.id {
                friction::ABOUT_POINT => (Origin::Direction, Redundancy::Idly),
                friction::OF_AXES.. => (Origin::Scalar(row.id), Redundancy::Idly),
                _ => (Origin::Scalar(row.id), Redundancy::Often),
            };
            let drives = row.drives;
            self.rows.push(Row {
                bias,
                driven,
                gamma,
                min,
                max,
                impulse,
                state,
                repeats,
                drives,
                ..Row::of(&row.jacobian, origin)
            });
        }
        self.nodes.push(SystemNode { bodies, first, last: self.rows.len() as u32 });
    }

    /// Adds a row for each of the first `count` axes of a block that holds a point or a direction; `row_along` gives the Jacobian and the
    /// origin of the row along an axis.
    fn add_block(
        &mut self,
        block: &rows::BlockRow,
        (axes, count): ([DVec3; 3], usize),
        repeats: [Redundancy; 3],
        row_along: impl Fn(DVec3) -> (rows::Jacobian, Origin),
    ) {
        for (&axis, repeats) in axes[..count].iter().zip(repeats) {
            let (jacobian, origin) = row_along(axis);
            self.rows.push(Row {
                bias: block.bias.dot(axis),
                gamma: block.gamma,
                impulse: block.impulse.as_dvec3().dot(axis),
                state: if block.acts { RowState::Free } else { RowState::Absent },
                repeats,
                ..Row::of(&jacobian, origin)
            });
        }
    }

    /// Adds a row to the last node.
    pub(super) fn add_row(&mut self, row: Row) {
        self.rows.push(row);
        if let Some(node) = self.nodes.last_mut() {
            node.last = self.rows.len() as u32;
        }
    }

    /// Prepares the first solve of these rows, none of which has pushed yet; the bodies' inertias are those of now.
    pub(crate) fn begin(&mut self, bodies: &[DirectBody]) {
        for contact in &self.contacts {
            let node = &self.nodes[contact.node as usize];
            for row in &mut self.rows[contact.first as usize..(contact.first + contact.count()) as usize] {
                row.gamma = CONTACT_COMPLIANCE * row.response(node.bodies.map(|body| &bodies[body as usize]));
            }
        }
        self.is_bounded = self.rows.iter().any(|row| row.state != RowState::Free || row.drives || row.has_bounds());
        self.list_bounded(bodies);
        self.has_pushed = false;
        self.is_factored = false;
        self.is_abreast = false;
    }

    /// Begins another substep with the same rows, after the bodies have changed so much over its length: stops are nearer or further.
    pub(crate) fn follow(&mut self, changes: &[Rate]) {
        let mut any_free = false;
        for &(row, node) in &self.bounded {
            let row = &mut self.rows[row as usize];
            if row.min == 0.0 && row.max == f64::INFINITY {
                let pair = self.nodes[node as usize].bodies.map(|body| changes[body as usize]);
                row.bias = (row.bias + row.rate(&pair)).max(0.0);
                any_free |= row.state == RowState::Free;
            }
        }
        if self.is_factored && any_free {
            self.packed_rows.take_biases(&self.rows);
        }
        self.has_new_biases |= any_free;
        self.has_pushed = false;
    }

    /// Sets the biases of a joint's rows to these position errors, so that the next solve finds the displacements that correct them;
    /// `scalars` are its scalar rows as a projection makes them, with errors for biases.
    pub(super) fn take_errors(&mut self, node: usize, point: DVec3, direction: DVec3, scalars: &[rows::ScalarRow]) {
        let node = &self.nodes[node];
        for row in &mut self.rows[node.first as usize..node.last as usize] {
            row.bias = match row.origin {
                Origin::Point => row.linear[1].dot(point),
                Origin::Direction => row.angular[1].dot(direction),
                Origin::Scalar(id) => {
                    let found = scalars.iter().find(|scalar| scalar.id == id && scalar.acts);
                    // A stop in the system corrects an overrun, and does not pull the joint onto itself from a distance.
                    let is_held = row.state == RowState::Free && row.min == 0.0;
                    found.map_or(0.0, |scalar| if is_held { scalar.bias.min(0.0) } else { scalar.bias })
                }
                Origin::Across | Origin::Contact => 0.0,
            };
        }
    }

    /// Worst overrun of the stops that have no part in the system, after these displacements (rad).
    pub(super) fn overrun(&self, changes: &[Rate]) -> f64 {
        let stops = self.bounded.iter().map(|&(row, node)| (&self.rows[row as usize], &self.nodes[node as usize]));
        let apart = stops.filter(|(row, _)| row.state == RowState::Low && row.max == f64::INFINITY);
        apart.map(|(row, node)| -(row.bias + row.rate(&node.bodies.map(|body| changes[body as usize])))).fold(0.0, f64::max)
    }

    /// Solves the rows that are free, whose factor is there, once more for what they ask for now.
    pub(super) fn solve_lasting(&mut self, topology: &Topology, bodies: &[DirectBody], changes: &mut [Rate]) {
        self.packed_rows.take_biases(&self.rows);
        self.solve_active(topology, bodies, changes);
    }

    /// Solves for all multipliers again, after what else acts on the bodies has changed the rates.
    pub(crate) fn sweep(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate]) {
        // What is free goes on from where it is, as long as all rows stay in their states.
        if self.has_pushed && self.is_factored {
            self.improve(topology, bodies, rates);
            if self.find_flips(rates, true) == 0 {
                return;
            }
            self.withdraw(bodies, rates);
            self.flip(false);
        } else {
            self.withdraw(bodies, rates);
        }
        self.solve(topology, bodies, rates, PASSES);
    }

    /// Adds the push of the carried multipliers to the rates.
    pub(crate) fn warm_start(&mut self, bodies: &[DirectBody], rates: &mut [Rate]) {
        if !self.is_factored {
            self.has_pushed = true;
            return self.push(bodies, rates, |row| row.impulse);
        }
        let Self { nodes, factor, packed_rows, room: [_, increments], .. } = self;
        increments.clone_from(&packed_rows.impulse);
        packed_rows.impulse.fill(ZERO);
        packed_rows::add_impulses(packed_rows, increments, 1.0, nodes, factor, bodies, rates);
        self.note_pushed(bodies, rates);
    }

    /// Notes that the push of the free rows' multipliers is in the rates, and adds that of the others.
    pub(super) fn note_pushed(&mut self, bodies: &[DirectBody], rates: &mut [Rate]) {
        self.has_pushed = true;
        let pushes = |row: &Row| matches!(row.state, RowState::Low | RowState::High) && row.impulse != 0.0;
        if self.bounded.iter().any(|&(row, _)| pushes(&self.rows[row as usize])) {
            self.push_fixed(bodies, rates);
        }
    }

    /// Adds the multipliers of a substep to the sums of all since the rows were built.
    pub(super) fn add_up(&mut self) {
        self.drop_senseless();
        self.sums.resize(self.rows.len(), 0.0);
        for (sum, row) in self.sums.iter_mut().zip(&self.rows) {
            *sum += row.impulse;
        }
    }

    /// Whether any row has a multiplier.
    pub(super) fn is_pressed(&self) -> bool {
        self.rows.iter().any(|row| row.impulse != 0.0)
    }

    /// Length of the multiplier by which a joint holds its points together (N·s).
    pub(super) fn point_impulse(&self, node: usize) -> f64 {
        let node = &self.nodes[node];
        let rows = self.rows[node.first as usize..node.last as usize].iter().filter(|row| row.origin == Origin::Point);
        rows.map(|row| row.impulse * row.impulse).sum::<f64>().sqrt()
    }

    /// Takes the push of the last solve out of the rates.
    pub(super) fn withdraw(&mut self, bodies: &[DirectBody], rates: &mut [Rate]) {
        if std::mem::replace(&mut self.has_pushed, true) {
            self.push(bodies, rates, |row| -row.impulse);
        }
    }

    /// Solves for the multipliers of all rows and adds their push to the rates; returns the passes that it took.
    pub(crate) fn solve(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate], most_passes: usize) -> usize {
        if !self.is_bounded {
            self.solve_active(topology, bodies, rates);
            return 1;
        }
        self.base.rates.clear();
        self.base.rates.extend_from_slice(rates);
        let (mut fewest, mut patience, mut wrong) = (usize::MAX, PATIENCE, 0);
        for pass in 1..=most_passes {
            rates.copy_from_slice(&self.base.rates);
            self.push_fixed(bodies, rates);
            self.solve_active(topology, bodies, rates);
            if self.ease_motors(rates, topology.loops > 0) {
                continue;
            }
            let may_free = pass + (most_passes / 3).min(MAX_CLOSING) < most_passes;
            wrong = self.find_flips(rates, may_free);
            if wrong < fewest {
                (fewest, patience) = (wrong, PATIENCE);
            } else {
                patience = patience.saturating_sub(1);
            }
            let one_by_one = patience == 0 && may_free;
            self.flip(one_by_one);
            // Friction is revised once the rest has settled with it: both at once chase each other.
            let sliding = if wrong > 0 || self.beside.is_on { 0 } else { self.revise_friction(rates, may_free) };
            if sliding > 0 {
                (fewest, patience) = (usize::MAX, PATIENCE);
            }
            if wrong + sliding == 0 {
                self.settled &= (!self.beside.is_on || self.beside.is_done) && (may_free || !self.keeps_open(rates));
                return pass;
            }
        }
        self.settled &= wrong == 0 && !self.keeps_open(rates);
        most_passes
    }

    /// Forgets the multipliers of a solve that came to more than bodies can ask for: they are neither carried on nor anyone's load.
    pub(crate) fn drop_senseless(&mut self) {
        // Written so that one which is no number counts.
        if !self.rows.iter().all(|row| row.impulse.abs() <= MAX_IMPULSE) {
            self.rows.iter_mut().for_each(|row| row.impulse = 0.0);
            // What is packed would go on from the old ones.
            (self.is_factored, self.is_abreast) = (false, false);
        }
    }

    /// Forgets all multipliers, whose push has been taken out of the rates.
    pub(super) fn drop_impulses(&mut self) {
        self.rows.iter_mut().for_each(|row| row.impulse = 0.0);
        (self.is_factored, self.is_abreast) = (false, false);
        self.has_pushed = false;
    }

    fn push_fixed(&self, bodies: &[DirectBody], rates: &mut [Rate]) {
        let is_on = self.beside.is_on;
        let pushes = |row: &Row| matches!(row.state, RowState::Low | RowState::High) && !(is_on && row.origin == Origin::Contact);
        self.push(bodies, rates, |row| if pushes(row) { row.impulse } else { 0.0 });
    }

    /// Adds what rows push with these impulses to the rates: one response for each body of a node.
    fn push(&self, bodies: &[DirectBody], rates: &mut [Rate], impulse_of: impl Fn(&Row) -> f64) {
        for node in &self.nodes {
            let (mut linear, mut angular) = ([DVec3::ZERO; 2], [DVec3::ZERO; 2]);
            for row in &self.rows[node.first as usize..node.last as usize] {
                let impulse = impulse_of(row);
                if impulse == 0.0 {
                    continue;
                }
                for side in 0..2 {
                    linear[side] += row.linear[side] * impulse;
                    angular[side] += row.angular[side] * impulse;
                }
            }
            for (side, body) in node.bodies.map(|body| body as usize).into_iter().enumerate() {
                rates[body].linear += bodies[body].inverse_mass * linear[side];
                rates[body].angular += bodies[body].inverse_inertia * angular[side];
            }
        }
    }

    pub(super) fn solve_active(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate]) {
        let Self { nodes, rows, factor, packed_rows, counts, beside, .. } = self;
        if !std::mem::replace(&mut self.is_factored, true) {
            self.is_exact = false;
            let planned = &nodes[..topology.plan.order().len()];
            packed_rows.choose(planned, rows, counts);
            factor.start(&topology.plan, counts);
            packed_rows::pack(packed_rows, planned, rows, factor, topology, bodies);
            packed_rows::assemble(factor, packed_rows, planned, topology, bodies);
            factor::factorize(factor, &topology.plan);
            if beside.is_on {
                beside.form((nodes, rows, packed_rows.index.as_flattened()), bodies, (factor, topology));
            }
        }
        beside.has_settled = false;
        packed_rows.impulse.clear();
        packed_rows.impulse.resize(factor.len(), ZERO);
        self.improve(topology, bodies, rates);
    }

    /// Whether rows of contacts are part of the system now.
    fn touches(&self) -> bool {
        let rows_of = |contact: &ContactRows| contact.first as usize..(contact.first + contact.count()) as usize;
        self.contacts.iter().any(|contact| self.rows[rows_of(contact)].iter().any(|row| row.state == RowState::Free))
    }

    /// Adds what the free rows still lack.
    fn improve(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate]) {
        // What contacts contradict each other in is for their active set to settle.
        let least = usize::from(topology.doubled);
        let most = if self.moderates && !self.touches() { MODERATIONS } else { least };
        let Self { nodes, rows, contacts, factor, packed_rows, room: [unknowns, increments], is_exact, beside, .. } = self;
        let planned = &nodes[..topology.plan.order().len()];
        let mut joints = FreeRows { packed_rows, nodes: planned, bodies, rates };
        if beside.is_on {
            let mut equations = BesideEquations { joints, beside, nodes, rows, contacts };
            refine(&mut equations, factor, &topology.plan, [least, most], unknowns, increments, is_exact);
        } else {
            refine(&mut joints, factor, &topology.plan, [least, most], unknowns, increments, is_exact);
        }
        // Rows of contacts repeat one another.
        *is_exact &= contacts.is_empty();
        packed_rows.unpack(rows);
        self.is_abreast = false;
    }

    /// Prepares the rows of a projection: bounds the errors that it takes out at once to lengths (m) and angles (rad) for which rows
    /// stay all but linear, and makes stops that are overrun hold as equalities, which no active set has to find.
    pub(crate) fn begin_projection(&mut self, length: f64, angle: f64) {
        for row in &mut self.rows {
            let most = if row.linear == [DVec3::ZERO; 2] { angle } else { length };
            let overrun = row.bias < 0.0 && row.min == 0.0 && row.origin != Origin::Contact && row.state != RowState::Absent;
            if overrun {
                (row.state, row.min) = (RowState::Free, f64::NEG_INFINITY);
            }
            row.bias = row.bias.max(-most);
            if row.min == f64::NEG_INFINITY {
                row.bias = row.bias.min(most);
            }
        }
    }
}
