//! What a servo moves whose joint closes a loop: a cylinder under a boom, the crank of four bars, a door on two hinges.
//!
//! Nothing in a loop hangs on the servo alone, and as one rigid body with what does not move it would not move at all. What it moves is
//! found by the factor of all rows instead. With J the coordinate and J_o the rows that hold rigidly, a unit of impulse along J and what the
//! others answer with change velocities by
//!
//! ```text
//! u = M̃⁻¹ (Jᵀ + J_oᵀ x),     J_o u = 0,
//! ```
//!
//! so that J u is its inverse effective mass, and u·f, with f gravity and other forces, what these accelerate it by. Stops, what gives and
//! friction do not hold. Other servos do, as they do where there are parts, unless they leave the coordinate no freedom: two that drive one
//! freedom each bear it alone.

use super::body::DirectBody;
use super::redundancy::Redundancy;
use super::row::RowState;
use super::system::System;
use super::topology::Topology;
use crate::solve::joint::rows::{Jacobian, Rate};
use glam::DVec3;

/// Share of what its own bodies would yield up to which a coordinate has no freedom.
/// Why: what the solve leaves of a row that repeats others is 1e-7 of it; a ton on a rod of a gram is 1e-6.
/// Scenes: doors on two servos. Test: tests/motors.rs
const NO_FREEDOM: f64 = 1.0e-6;

/// All rows of an articulation, to be solved on trial.
#[derive(Debug, Default)]
pub(super) struct ServoTrial {
    system: System,
    rates: Vec<Rate>,
    /// Whether the rows are those of the present substep.
    pub is_ready: bool,
    /// Node of the joint for which they are in their states, and whether other servos hold.
    held: Option<(usize, bool)>,
}

impl ServoTrial {
    /// Takes rows as they have been built.
    pub(super) fn take(&mut self, system: &System) {
        self.system.clear();
        self.system.nodes.extend_from_slice(&system.nodes);
        self.system.rows.extend_from_slice(&system.rows);
        self.system.rows.iter_mut().for_each(|row| row.bias = 0.0);
        (self.system.is_factored, self.is_ready, self.held) = (false, true, None);
    }

    /// What a unit of impulse along a coordinate of the joint of this node changes of its rate (1/kg, 1/(kg·m²)), and what external forces
    /// accelerate it by (m/s², rad/s²).
    pub(super) fn ease_of(&mut self, node: usize, way: &Jacobian, topology: &Topology, bodies: &[DirectBody]) -> [f64; 2] {
        let own = self.push(node, way, bodies);
        self.hold(node, true);
        let found = self.answer(node, way, topology, bodies);
        if found[0] > NO_FREEDOM * own || !self.hold(node, false) {
            return found;
        }
        self.push(node, way, bodies);
        self.answer(node, way, topology, bodies)
    }

    /// Pushes the bodies of a joint by a unit of impulse along its coordinate, and returns what that changes of its rate.
    fn push(&mut self, node: usize, way: &Jacobian, bodies: &[DirectBody]) -> f64 {
        self.rates.clear();
        self.rates.resize(bodies.len(), Rate { linear: DVec3::ZERO, angular: DVec3::ZERO });
        let ends = self.system.nodes[node].bodies.map(|body| body as usize);
        for (end, linear, angular) in [(ends[0], -way.linear, -way.angular_a), (ends[1], way.linear, way.angular_b)] {
            self.rates[end].linear += bodies[end].inverse_mass * linear;
            self.rates[end].angular += bodies[end].inverse_inertia * angular;
        }
        way.rate(&ends.map(|end| self.rates[end]))
    }

    /// Has the rows hold that are rigid; returns whether that makes a difference to those that held.
    fn hold(&mut self, own: usize, others_hold: bool) -> bool {
        if self.held == Some((own, others_hold)) {
            return true;
        }
        let mut differs = false;
        for (number, node) in self.system.nodes.iter().enumerate() {
            for row in &mut self.system.rows[node.first as usize..node.last as usize] {
                let is_servo = row.drives && row.repeats != Redundancy::Idly && number != own && others_hold;
                let holds = row.gamma == 0.0 && (is_servo || !row.has_bounds());
                let state = if holds { RowState::Free } else { RowState::Absent };
                differs |= state != row.state;
                row.state = state;
            }
        }
        self.system.is_factored &= !differs;
        self.held = Some((own, others_hold));
        differs
    }

    /// What has been pushed moves on with what the rows answer.
    fn answer(&mut self, node: usize, way: &Jacobian, topology: &Topology, bodies: &[DirectBody]) -> [f64; 2] {
        self.system.solve_active(topology, bodies, &mut self.rates);
        let ends = self.system.nodes[node].bodies.map(|body| self.rates[body as usize]);
        let acceleration = bodies.iter().zip(&self.rates).map(|(body, rate)| body.power(rate)).sum();
        [way.rate(&ends).max(0.0), acceleration]
    }
}
