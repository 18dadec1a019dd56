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
//! read off the multipliers of the last substep, so that most solves take one pass.
//!
//! The displacements of a projection are solved for in the same way, with v₀ = 0 and b the errors.

use glam::DVec3;

use super::body::DirectBody;
use super::factor::{Factor, Plan};
use super::row::{Origin, Row, State};
use crate::solve::joint::rows::{self, Held, Rate};

/// Added to the diagonal, relative to it: rows that repeat others (a closed planar loop has three) share their multiplier instead
/// of dividing by nothing.
const REGULARIZATION: f64 = 1.0e-9;

/// Most passes of the active set: nearly all solves take one, and the last third frees nothing any more. Contacts ask for more
/// than stops and motors; a projection is judged by what it reaches.
pub(crate) const PASSES: usize = 8;
pub(crate) const CONTACT_PASSES: usize = 30;
pub(crate) const PROJECTION_PASSES: usize = 4;

/// Most times that a solution is refined with the same factor, and the share of the first residual from which it is.
const REFINEMENTS: usize = 2;
const REFINE_ABOVE: f64 = 1.0e-7;

/// Share of the residual that a refinement must reach to be kept.
const IMPROVES: f64 = 0.5;

/// Compliance of a contact's row over its own response: of multipliers that hold equally, those of least norm are taken.
const CONTACT_COMPLIANCE: f64 = 1.0e-6;

/// Share of its limit below which a carried friction multiplier starts as one that holds.
const STICKS: f64 = 0.999;

/// Rows of one manifold, by number: normals, then two of friction and one about the normal where there is friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactRows {
    pub node: u32,
    pub first: u32,
    pub normals: u32,
    pub has_friction: bool,
    /// Coefficient of friction, and torque limit per normal force (m).
    pub friction: f64,
    pub twist_arm: f64,
}

/// A joint's rows and bodies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    pub bodies: [u32; 2],
    pub first: u32,
    pub last: u32,
}

/// Two joints on one moving body, and the block that they share: its rows are those of the joint eliminated later.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coupling {
    pub late: u32,
    pub early: u32,
    /// Side of each joint that is the body.
    pub late_side: u8,
    pub early_side: u8,
    pub body: u32,
    pub start: u32,
}

/// What does not change while the joints and their bodies stay the same.
#[derive(Debug, Clone, Default)]
pub(crate) struct Topology {
    pub plan: Plan,
    pub couplings: Vec<Coupling>,
}

/// All rows of an articulation, and room to solve them.
#[derive(Debug, Clone, Default)]
pub(crate) struct System {
    pub nodes: Vec<Node>,
    pub rows: Vec<Row>,
    pub contacts: Vec<ContactRows>,
    factor: Factor,
    /// Rows in the system now, by node.
    active: Vec<u32>,
    /// What the rows of one node do to a body, for the blocks that couple them to another.
    columns: Vec<(DVec3, DVec3)>,
    unknowns: Vec<f64>,
    increments: Vec<f64>,
    base: Vec<Rate>,
    has_pushed: bool,
    /// Whether every solve since this was set came to an end by itself.
    pub settled: bool,
}

impl System {
    /// Removes all rows.
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.rows.clear();
        self.contacts.clear();
    }

    /// Adds a joint's rows as the next node, to which rows of contacts may be added.
    pub(crate) fn add(
        &mut self,
        bodies: [u32; 2],
        point: Option<&rows::BlockRow>,
        direction: Option<&rows::BlockRow>,
        scalars: &[rows::ScalarRow],
    ) {
        let first = self.rows.len() as u32;
        if let Some(block) = point {
            self.add_block(block, |axis| {
                let [a, b] = block.levers;
                (rows::Jacobian { linear: axis, angular_a: a.cross(axis), angular_b: b.cross(axis) }, Origin::Point(axis))
            });
        }
        if let Some(block) = direction {
            self.add_block(block, |axis| (rows::Jacobian::angular(axis), Origin::Direction(axis)));
        }
        for row in scalars {
            let impulse = f64::from(row.impulse);
            let state = match (row.acts, row.min < row.max) {
                (false, _) => State::Absent,
                (true, true) if impulse > row.min && impulse < row.max => State::Free,
                (true, _) if impulse <= row.min => State::Low,
                _ => State::High,
            };
            let (bias, gamma, min, max) = (row.bias, row.gamma, row.min, row.max);
            self.rows.push(Row { bias, gamma, min, max, impulse, state, ..Row::of(&row.jacobian, Origin::Scalar(row.id)) });
        }
        self.nodes.push(Node { bodies, first, last: self.rows.len() as u32 });
    }

    fn add_block(&mut self, block: &rows::BlockRow, row_along: impl Fn(DVec3) -> (rows::Jacobian, Origin)) {
        let (axes, count) = match block.held {
            Held::All => (DVec3::AXES, 3),
            Held::Across(axis) => {
                let (u, v) = across(axis);
                ([u, v, DVec3::ZERO], 2)
            }
        };
        for &axis in &axes[..count] {
            let (jacobian, origin) = row_along(axis);
            self.rows.push(Row {
                bias: block.bias.dot(axis),
                gamma: block.gamma,
                impulse: block.impulse.as_dvec3().dot(axis),
                state: if block.acts { State::Free } else { State::Absent },
                ..Row::of(&jacobian, origin)
            });
        }
    }

    /// Begins a manifold in the last node; its rows follow.
    pub(crate) fn begin_contact(&mut self, friction: f64, twist_arm: f64) {
        let (node, first) = (self.nodes.len() as u32 - 1, self.rows.len() as u32);
        self.contacts.push(ContactRows { node, first, normals: 0, has_friction: false, friction, twist_arm });
    }

    /// Adds a normal row of the last manifold, J v + bias ≥ 0, on one side of its node.
    pub(crate) fn add_normal(&mut self, side: usize, normal: DVec3, lever: DVec3, bias: f64, impulse: f64) {
        let state = if impulse > 0.0 { State::Free } else { State::Low };
        let row = Row { bias, min: 0.0, impulse, state, ..Row::EMPTY };
        self.add_contact_row(side, normal, lever.cross(normal), row);
        if let Some(contact) = self.contacts.last_mut() {
            contact.normals += 1;
        }
    }

    /// Adds the friction of the last manifold: two rows along tangents at its centre and one about its normal, each with the speed
    /// of the other body and the carried multiplier.
    pub(crate) fn add_friction(
        &mut self,
        side: usize,
        center: DVec3,
        tangents: [(DVec3, f64, f64); 2],
        twist: (DVec3, f64, f64),
    ) {
        let Some(&contact) = self.contacts.last() else { return };
        let pressed = self.pressed(&contact);
        let [u, v] = tangents.map(|(_, _, impulse)| impulse);
        let state = |impulse: f64, limit: f64| if impulse < limit * STICKS { State::Free } else { State::High };
        let sticks = state(u.hypot(v), contact.friction * pressed);
        for (tangent, bias, impulse) in tangents {
            let row = Row { bias, impulse, state: sticks, ..Row::EMPTY };
            self.add_contact_row(side, tangent, center.cross(tangent), row);
        }
        let (axis, bias, impulse) = twist;
        let state = state(impulse.abs(), contact.twist_arm * pressed);
        self.add_contact_row(side, DVec3::ZERO, axis, Row { bias, impulse, state, ..Row::EMPTY });
        if let Some(contact) = self.contacts.last_mut() {
            contact.has_friction = true;
        }
    }

    fn add_contact_row(&mut self, side: usize, linear: DVec3, angular: DVec3, mut row: Row) {
        row.linear[side] = linear;
        row.angular[side] = angular;
        self.rows.push(row);
        if let Some(node) = self.nodes.last_mut() {
            node.last = self.rows.len() as u32;
        }
    }

    /// Sum of the normal multipliers of a manifold (N·s).
    pub(crate) fn pressed(&self, contact: &ContactRows) -> f64 {
        let normals = contact.first as usize..(contact.first + contact.normals) as usize;
        self.rows[normals].iter().map(|row| row.impulse.max(0.0)).sum()
    }

    /// Forms the responses of all rows, none of which has pushed yet.
    pub(crate) fn begin(&mut self, bodies: &[DirectBody]) {
        self.respond(bodies);
        self.has_pushed = false;
    }

    /// Takes the push of the last solve out of the rates.
    pub(crate) fn withdraw(&mut self, bodies: &[DirectBody], rates: &mut [Rate]) {
        if std::mem::replace(&mut self.has_pushed, true) {
            for node in &self.nodes {
                for row in &self.rows[node.first as usize..node.last as usize] {
                    push(row, node, -row.impulse, bodies, rates);
                }
            }
        }
    }

    /// Forms the responses of all rows; the bodies' inertias are those of now.
    fn respond(&mut self, bodies: &[DirectBody]) {
        for node in &self.nodes {
            let [a, b] = node.bodies.map(|body| bodies[body as usize].inverse_inertia);
            let masses = node.bodies.map(|body| bodies[body as usize].inverse_mass);
            for row in &mut self.rows[node.first as usize..node.last as usize] {
                row.response = [a * row.angular[0], b * row.angular[1]];
                if row.origin == Origin::Contact {
                    let own = |side: usize| {
                        (masses[side] * row.linear[side]).dot(row.linear[side]) + row.response[side].dot(row.angular[side])
                    };
                    row.gamma = CONTACT_COMPLIANCE * (own(0) + own(1));
                }
            }
        }
    }

    /// Solves for the multipliers of all rows and adds their push to the rates.
    pub(crate) fn solve(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate], most_passes: usize) {
        self.base.clear();
        self.base.extend_from_slice(rates);
        for pass in 1..=most_passes {
            rates.copy_from_slice(&self.base);
            self.push_fixed(bodies, rates);
            self.solve_active(topology, bodies, rates);
            let may_free = pass < most_passes - most_passes / 3;
            if self.revise(rates, may_free) + self.revise_friction(rates, may_free) == 0 {
                self.settled &= may_free;
                return;
            }
        }
        self.settled = false;
    }

    fn push_fixed(&self, bodies: &[DirectBody], rates: &mut [Rate]) {
        for node in &self.nodes {
            for row in &self.rows[node.first as usize..node.last as usize] {
                if matches!(row.state, State::Low | State::High) && row.impulse != 0.0 {
                    push(row, node, row.impulse, bodies, rates);
                }
            }
        }
    }

    fn solve_active(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate]) {
        let Self { nodes, rows, factor, active, columns, unknowns, increments, .. } = self;
        active.clear();
        let counts = nodes.iter().map(|node| {
            let before = active.len();
            active.extend((node.first..node.last).filter(|&row| rows[row as usize].state == State::Free));
            (active.len() - before) as u32
        });
        factor.start(&topology.plan, counts);
        assemble(nodes, rows, active, columns, factor, topology, bodies);
        factor.factorize(&topology.plan);
        active.iter().for_each(|&row| rows[row as usize].impulse = 0.0);
        let first = find_residuals(nodes, rows, active, factor, rates, unknowns);
        let mut before = first;
        for round in 0..=REFINEMENTS {
            factor.solve(&topology.plan, unknowns);
            std::mem::swap(unknowns, increments);
            add_impulses(nodes, rows, active, factor, increments, 1.0, bodies, rates);
            let left = find_residuals(nodes, rows, active, factor, rates, unknowns);
            let improves = left < IMPROVES * before;
            if round > 0 && !improves {
                // Rows that contradict each other: more of the same would only raise multipliers that cancel.
                add_impulses(nodes, rows, active, factor, increments, -1.0, bodies, rates);
                break;
            }
            if left <= REFINE_ABOVE * first {
                break;
            }
            before = left;
        }
    }

    /// Prepares the rows of a projection: bounds the errors that it takes out at once to lengths (m) and angles (rad) for which rows
    /// stay all but linear, and makes stops that are overrun hold as equalities, which no active set has to find.
    pub(crate) fn begin_projection(&mut self, length: f64, angle: f64) {
        for row in &mut self.rows {
            let most = if row.linear == [DVec3::ZERO; 2] { angle } else { length };
            let overrun = row.bias < 0.0 && row.min == 0.0 && row.origin != Origin::Contact && row.state != State::Absent;
            if overrun {
                (row.state, row.min) = (State::Free, f64::NEG_INFINITY);
            }
            row.bias = row.bias.max(-most);
            if row.min == f64::NEG_INFINITY {
                row.bias = row.bias.min(most);
            }
        }
    }

    /// Greatest error of the rows that must hold, where the rows were made for a projection; `size` (m) turns angles into lengths.
    pub(crate) fn worst_error(&self, size: f64) -> f64 {
        let error = |row: &Row| match (row.state, row.origin) {
            (State::Absent, _) | (_, Origin::Contact) => 0.0,
            (_, Origin::Point(_)) => row.bias.abs(),
            (_, Origin::Direction(_)) => row.bias.abs() * size,
            (_, Origin::Scalar(_)) => {
                let length = if row.linear[1] == DVec3::ZERO { size } else { 1.0 };
                let error = if row.min == 0.0 { (-row.bias).max(0.0) } else { row.bias.abs() };
                error * length
            }
        };
        // Unlike `max`, which passes over what is no number.
        self.rows.iter().map(error).fold(0.0, |worst, error| if error <= worst { worst } else { error })
    }
}

/// Adds a share of the increments to the multipliers of the rows in the system, and their push to the rates.
#[expect(clippy::too_many_arguments, reason = "parts of a system that are borrowed one by one")]
fn add_impulses(
    nodes: &[Node],
    rows: &mut [Row],
    active: &[u32],
    factor: &Factor,
    increments: &[f64],
    share: f64,
    bodies: &[DirectBody],
    rates: &mut [Rate],
) {
    for (number, node) in nodes.iter().enumerate() {
        let range = factor.start_of(number)..factor.start_of(number + 1);
        for (&index, &increment) in active[range.clone()].iter().zip(&increments[range]) {
            let row = &mut rows[index as usize];
            row.impulse += increment * share;
            push(row, node, increment * share, bodies, rates);
        }
    }
}

/// Writes what the rows in the system still lack, −(J v + b + γ p); returns the greatest.
fn find_residuals(
    nodes: &[Node],
    rows: &[Row],
    active: &[u32],
    factor: &Factor,
    rates: &[Rate],
    residuals: &mut Vec<f64>,
) -> f64 {
    residuals.clear();
    let mut worst = 0.0_f64;
    for (number, node) in nodes.iter().enumerate() {
        let pair = node.bodies.map(|body| rates[body as usize]);
        for &row in &active[factor.start_of(number)..factor.start_of(number + 1)] {
            let row = &rows[row as usize];
            let residual = -(row.rate(&pair) + row.bias + row.gamma * row.impulse);
            worst = worst.max(residual.abs());
            residuals.push(residual);
        }
    }
    worst
}

fn push(row: &Row, node: &Node, impulse: f64, bodies: &[DirectBody], rates: &mut [Rate]) {
    for (side, body) in node.bodies.map(|body| body as usize).into_iter().enumerate() {
        rates[body].linear += bodies[body].inverse_mass * row.linear[side] * impulse;
        rates[body].angular += row.response[side] * impulse;
    }
}

/// Two unit vectors orthogonal to `axis` and to each other.
fn across(axis: DVec3) -> (DVec3, DVec3) {
    let u = axis.any_orthonormal_vector();
    (u, axis.cross(u))
}

fn assemble(
    nodes: &[Node],
    rows: &[Row],
    active: &[u32],
    columns: &mut Vec<(DVec3, DVec3)>,
    factor: &mut Factor,
    topology: &Topology,
    bodies: &[DirectBody],
) {
    for (number, node) in nodes.iter().enumerate() {
        let own = &active[factor.start_of(number)..factor.start_of(number + 1)];
        let masses = node.bodies.map(|body| bodies[body as usize].inverse_mass);
        let block = factor.block_mut(topology.plan.diagonal(number));
        for (i, &row) in own.iter().enumerate() {
            let row = &rows[row as usize];
            let linear = [masses[0] * row.linear[0], masses[1] * row.linear[1]];
            for (j, &other) in own[..=i].iter().enumerate() {
                let other = &rows[other as usize];
                let value = linear[0].dot(other.linear[0])
                    + linear[1].dot(other.linear[1])
                    + row.response[0].dot(other.angular[0])
                    + row.response[1].dot(other.angular[1]);
                block[i * own.len() + j] = value;
                block[j * own.len() + i] = value;
            }
            let diagonal = &mut block[i * own.len() + i];
            *diagonal += row.gamma + REGULARIZATION * *diagonal;
        }
    }
    for coupling in &topology.couplings {
        let range = |node: u32| factor.start_of(node as usize)..factor.start_of(node as usize + 1);
        let (late_rows, early_rows) = (&active[range(coupling.late)], &active[range(coupling.early)]);
        let (late_side, early_side) = (coupling.late_side as usize, coupling.early_side as usize);
        let mass = bodies[coupling.body as usize].inverse_mass;
        columns.clear();
        columns.extend(early_rows.iter().map(|&row| {
            let row = &rows[row as usize];
            (mass * row.linear[early_side], row.response[early_side])
        }));
        let block = factor.block_mut(coupling.start);
        for (i, &row) in late_rows.iter().enumerate() {
            let row = &rows[row as usize];
            let (linear, angular) = (row.linear[late_side], row.angular[late_side]);
            for (value, column) in block[i * columns.len()..].iter_mut().zip(&*columns) {
                *value += linear.dot(column.0) + angular.dot(column.1);
            }
        }
    }
}
