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
use super::factor::{Factor, MAX_ROWS, Plan};
use crate::solve::joint::rows::{self, Held, Rate};

/// Added to the diagonal, relative to it: rows that repeat others (a closed planar loop has three) share their multiplier instead
/// of dividing by nothing.
const REGULARIZATION: f64 = 1.0e-9;

/// Most passes of the active set; nearly all solves take one, and the last frees nothing any more.
const MAX_PASSES: usize = 8;

/// Error below which a fixed row stays fixed (m/s, rad/s, or m and rad in a projection).
const FREE_BELOW: f64 = 1.0e-10;

/// Whether a row with bounds is part of the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Free,
    Low,
    High,
    /// Takes no part in this phase.
    Absent,
}

/// Where the multiplier of a row comes from and goes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Origin {
    /// Along a direction of the block of points.
    Point(DVec3),
    /// Along a direction of the block of directions.
    Direction(DVec3),
    /// A scalar row, by number.
    Scalar(u8),
}

/// One row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub origin: Origin,
    pub jacobian: rows::Jacobian,
    /// I⁻¹ times the angular parts of the Jacobian.
    response: [DVec3; 2],
    pub bias: f64,
    gamma: f64,
    min: f64,
    max: f64,
    pub impulse: f64,
    state: State,
}

/// A joint's rows and bodies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    pub bodies: [u32; 2],
    pub first: u32,
    pub last: u32,
}

/// Two joints on one moving body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coupling {
    pub nodes: [u32; 2],
    /// Side of each joint that is the body.
    pub sides: [u8; 2],
    pub body: u32,
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
    factor: Factor,
    /// Rows in the system now, by node.
    active: Vec<u32>,
    unknowns: Vec<f64>,
    base: Vec<Rate>,
    has_pushed: bool,
    /// Passes of the last solve.
    pub passes: u32,
}

impl System {
    /// Removes all rows.
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.rows.clear();
    }

    /// Adds a joint's rows as the next node; blocks and scalars are its rows in any phase.
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
            self.rows.push(Row {
                origin: Origin::Scalar(row.id),
                jacobian: row.jacobian,
                response: [DVec3::ZERO; 2],
                bias: row.bias,
                gamma: row.gamma,
                min: row.min,
                max: row.max,
                impulse,
                state,
            });
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
                origin,
                jacobian,
                response: [DVec3::ZERO; 2],
                bias: block.bias.dot(axis),
                gamma: block.gamma,
                min: f64::NEG_INFINITY,
                max: f64::INFINITY,
                impulse: block.impulse.as_dvec3().dot(axis),
                state: if block.acts { State::Free } else { State::Absent },
            });
        }
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
            for row in &mut self.rows[node.first as usize..node.last as usize] {
                row.response = [a * row.jacobian.angular_a, b * row.jacobian.angular_b];
            }
        }
    }

    /// Solves for the multipliers of all rows and adds their push to the rates.
    pub(crate) fn solve(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate]) {
        self.base.clear();
        self.base.extend_from_slice(rates);
        for pass in 1..=MAX_PASSES {
            self.passes = pass as u32;
            rates.copy_from_slice(&self.base);
            self.push_fixed(bodies, rates);
            self.solve_active(topology, bodies, rates);
            if self.revise(rates, pass < MAX_PASSES / 2) == 0 {
                break;
            }
        }
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
        let Self { nodes, rows, factor, active, unknowns, .. } = self;
        active.clear();
        let counts = nodes.iter().map(|node| {
            let before = active.len();
            active.extend((node.first..node.last).filter(|&row| rows[row as usize].state == State::Free));
            (active.len() - before) as u32
        });
        factor.start(&topology.plan, counts);
        assemble(nodes, rows, active, factor, topology, bodies);
        unknowns.clear();
        for (number, node) in nodes.iter().enumerate() {
            let pair = node.bodies.map(|body| rates[body as usize]);
            for &row in &active[factor.start_of(number)..factor.start_of(number + 1)] {
                let row = &rows[row as usize];
                unknowns.push(-(row.jacobian.rate(&pair) + row.bias));
            }
        }
        factor.factorize(&topology.plan);
        factor.solve(&topology.plan, unknowns);
        for (number, node) in nodes.iter().enumerate() {
            let range = factor.start_of(number)..factor.start_of(number + 1);
            for (&index, &impulse) in active[range.clone()].iter().zip(&unknowns[range]) {
                let row = &mut rows[index as usize];
                row.impulse = impulse;
                push(row, node, impulse, bodies, rates);
            }
        }
    }

    /// Frees and fixes rows with bounds; returns how many changed.
    fn revise(&mut self, rates: &[Rate], may_free: bool) -> usize {
        let mut changes = 0;
        for node in &self.nodes {
            for row in &mut self.rows[node.first as usize..node.last as usize] {
                let state = match row.state {
                    State::Absent => continue,
                    State::Free if row.impulse < row.min => State::Low,
                    State::Free if row.impulse > row.max => State::High,
                    State::Free => continue,
                    State::Low | State::High => {
                        if !may_free || row.min == row.max {
                            continue;
                        }
                        let pair = node.bodies.map(|body| rates[body as usize]);
                        let error = row.jacobian.rate(&pair) + row.bias + row.gamma * row.impulse;
                        let wants_more = row.state == State::Low && error < -FREE_BELOW;
                        let wants_less = row.state == State::High && error > FREE_BELOW;
                        if !(wants_more || wants_less) {
                            continue;
                        }
                        State::Free
                    }
                };
                row.state = state;
                row.impulse = match state {
                    State::Low => row.min,
                    State::High => row.max,
                    State::Free | State::Absent => row.impulse,
                };
                changes += 1;
            }
        }
        changes
    }

    /// Greatest error of the rows that must hold, where the rows were made for a projection; `size` (m) turns angles into lengths.
    pub(crate) fn worst_error(&self, size: f64) -> f64 {
        let error = |row: &Row| match (row.state, row.origin) {
            (State::Absent, _) => 0.0,
            (_, Origin::Point(_)) => row.bias.abs(),
            (_, Origin::Direction(_)) => row.bias.abs() * size,
            (_, Origin::Scalar(_)) => {
                let length = if row.jacobian.linear == DVec3::ZERO { size } else { 1.0 };
                let error = if row.min == 0.0 { (-row.bias).max(0.0) } else { row.bias.abs() };
                error * length
            }
        };
        self.rows.iter().map(error).fold(0.0, f64::max)
    }
}

fn push(row: &Row, node: &Node, impulse: f64, bodies: &[DirectBody], rates: &mut [Rate]) {
    let [a, b] = node.bodies.map(|body| body as usize);
    let linear = row.jacobian.linear * impulse;
    rates[a].linear -= bodies[a].inverse_mass * linear;
    rates[a].angular -= row.response[0] * impulse;
    rates[b].linear += bodies[b].inverse_mass * linear;
    rates[b].angular += row.response[1] * impulse;
}

/// Two unit vectors orthogonal to `axis` and to each other.
fn across(axis: DVec3) -> (DVec3, DVec3) {
    let u = axis.any_orthonormal_vector();
    (u, axis.cross(u))
}

fn assemble(nodes: &[Node], rows: &[Row], active: &[u32], factor: &mut Factor, topology: &Topology, bodies: &[DirectBody]) {
    for (number, node) in nodes.iter().enumerate() {
        let own = &active[factor.start_of(number)..factor.start_of(number + 1)];
        let masses = bodies[node.bodies[0] as usize].inverse_mass + bodies[node.bodies[1] as usize].inverse_mass;
        let (start, _) = topology.plan.block(number as u32, number as u32).unwrap_or_default();
        let block = factor.block_mut(start);
        for (i, &row) in own.iter().enumerate() {
            let row = &rows[row as usize];
            let linear = masses * row.jacobian.linear;
            for (j, &other) in own[..=i].iter().enumerate() {
                let other = &rows[other as usize].jacobian;
                let value =
                    linear.dot(other.linear) + row.response[0].dot(other.angular_a) + row.response[1].dot(other.angular_b);
                block[i * own.len() + j] = value;
                block[j * own.len() + i] = value;
            }
            let diagonal = &mut block[i * own.len() + i];
            *diagonal += row.gamma + REGULARIZATION * *diagonal;
        }
    }
    for coupling in &topology.couplings {
        let [a, b] = coupling.nodes;
        let Some((start, rows_of_b)) = topology.plan.block(a, b) else { continue };
        // Rows of a block belong to the node eliminated later.
        let ((late, late_side), (early, early_side)) = if rows_of_b {
            ((b, coupling.sides[1]), (a, coupling.sides[0]))
        } else {
            ((a, coupling.sides[0]), (b, coupling.sides[1]))
        };
        let range = |node: u32| factor.start_of(node as usize)..factor.start_of(node as usize + 1);
        let (late_rows, early_rows) = (&active[range(late)], &active[range(early)]);
        let sign = if late_side == early_side { 1.0 } else { -1.0 };
        let mass = bodies[coupling.body as usize].inverse_mass * sign;
        let mut columns = [(DVec3::ZERO, DVec3::ZERO); MAX_ROWS];
        for (column, &row) in columns.iter_mut().zip(early_rows) {
            let row = &rows[row as usize];
            *column = (mass * row.jacobian.linear, row.response[early_side as usize] * sign);
        }
        let block = factor.block_mut(start);
        for (i, &row) in late_rows.iter().enumerate() {
            let jacobian = &rows[row as usize].jacobian;
            let angular = if late_side == 0 { jacobian.angular_a } else { jacobian.angular_b };
            for (value, (linear, response)) in block[i * early_rows.len()..].iter_mut().zip(&columns[..early_rows.len()]) {
                *value += jacobian.linear.dot(*linear) + angular.dot(*response);
            }
        }
    }
}
