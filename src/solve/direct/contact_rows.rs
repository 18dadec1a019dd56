//! Rows of a contact in the linear system of an articulation.

use glam::DVec3;

use super::row::{ContactRows, Row, RowState};
use super::system::System;

/// Share of its limit below which a carried friction multiplier starts as one that holds.
const STICKS: f64 = 0.999;

/// Where a row of a contact acts: on the body at one side of its node at this lever (m), and on the other, if that moves, at that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowAnchor {
    pub side: usize,
    pub lever: DVec3,
    pub opposite: Option<DVec3>,
}

impl RowAnchor {
    /// The row along this direction.
    fn along(&self, direction: DVec3, row: Row) -> Row {
        let mut row = self.about(self.lever.cross(direction), self.opposite.map(|lever| lever.cross(direction)), row);
        row.linear[self.side] = direction;
        if self.opposite.is_some() {
            row.linear[1 - self.side] = -direction;
        }
        row
    }

    /// The row that turns the body so, and the other back so.
    fn about(&self, turn: DVec3, opposite: Option<DVec3>, mut row: Row) -> Row {
        row.angular[self.side] = turn;
        if let Some(opposite) = opposite {
            row.angular[1 - self.side] = -opposite;
        }
        row
    }
}

impl System {
    /// Begins a manifold in the last node; its rows follow.
    pub(crate) fn begin_contact(&mut self, friction: f64, twist_arm: f64) {
        let (node, first) = (self.nodes.len() as u32 - 1, self.rows.len() as u32);
        self.contacts.push(ContactRows { node, first, normals: 0, has_friction: false, friction, twist_arm });
    }

    /// Adds a normal row of the last manifold, J v + bias ≥ 0.
    pub(crate) fn add_normal(&mut self, grip: &RowAnchor, normal: DVec3, bias: f64, impulse: f64) {
        let state = if impulse > 0.0 { RowState::Free } else { RowState::Low };
        self.add_row(grip.along(normal, Row { bias, min: 0.0, impulse, state, ..Row::EMPTY }));
        if let Some(contact) = self.contacts.last_mut() {
            contact.normals += 1;
        }
    }

    /// Adds the friction of the last manifold: two rows along tangents at its centre and one about its normal, each with the speed
    /// of the other body and the carried multiplier.
    pub(crate) fn add_friction(&mut self, grip: &RowAnchor, tangents: [(DVec3, f64, f64); 2], twist: (DVec3, f64, f64)) {
        let Some(&contact) = self.contacts.last() else { return };
        let pressed = self.pressed(&contact);
        let [u, v] = tangents.map(|(_, _, impulse)| impulse);
        let state = |impulse: f64, limit: f64| if impulse < limit * STICKS { RowState::Free } else { RowState::High };
        let sticks = state((u * u + v * v).sqrt(), contact.friction * pressed);
        for (tangent, bias, impulse) in tangents {
            self.add_row(grip.along(tangent, Row { bias, impulse, state: sticks, ..Row::EMPTY }));
        }
        let (axis, bias, impulse) = twist;
        let state = state(impulse.abs(), contact.twist_arm * pressed);
        self.add_row(grip.about(axis, grip.opposite.map(|_| axis), Row { bias, impulse, state, ..Row::EMPTY }));
        if let Some(contact) = self.contacts.last_mut() {
            contact.has_friction = true;
        }
    }

    /// Sum of the normal multipliers of a manifold (N·s).
    pub(crate) fn pressed(&self, contact: &ContactRows) -> f64 {
        let normals = contact.first as usize..(contact.first + contact.normals) as usize;
        self.rows[normals].iter().map(|row| row.impulse.max(0.0)).sum()
    }
}
