//! Which rows with bounds are part of the system: stops and motors one by one, friction by its cone.

use glam::DVec3;

use super::body::DirectBody;
use super::friction_cone::{FREE_BELOW, revise_cone};
use super::row::{Origin, Row, RowState};
use super::system::System;
use crate::solve::joint::rows::{MAX_RECOVERY_SPEED, Rate};
use crate::tuning::overruled::{OVERRULED_COMPLIANCE, STRAINED};

impl Row {
    /// Whether it is at a bound, and asks to push less or to pull, as its bodies part or close at these rates.
    fn wants_free(&self, pair: [Rate; 2]) -> bool {
        let side = match self.state {
            RowState::Low if self.min < self.max => 1.0,
            RowState::High if self.min < self.max => -1.0,
            _ => return false,
        };
        side * (self.rate(&pair) + self.bias + self.gamma * self.impulse) < -FREE_BELOW
    }
}

/// Share of what a motor asks for, and speed beside it (m/s, rad/s), that a solve may leave.
/// Why: what rows contradict each other by is of the size of what they ask for; what a solve leaves else is 1e-7 of it.
/// Scenes: motors of 50 N m to without bound, held by ropes, welds and stops at 30 to 240 Hz. Test: tests/motors.rs
const MET: [f64; 2] = [1.0e-3, 1.0e-4];

impl System {
    /// Lists the rows with bounds and those of motors, and finds what these give where they are overruled.
    pub(super) fn list_bounded(&mut self, bodies: &[DirectBody]) {
        let Self { nodes, rows, bounded, .. } = self;
        bounded.clear();
        for (number, node) in nodes.iter().enumerate() {
            for place in node.first..node.last {
                let row = &mut rows[place as usize];
                if row.drives {
                    row.give = OVERRULED_COMPLIANCE * row.own_response(node.bodies.map(|body| &bodies[body as usize]));
                }
                if row.drives || row.has_bounds() {
                    bounded.push((place, number as u32));
                }
            }
        }
    }

    /// Lists the rows with bounds that are in the wrong state; returns how many.
    pub(super) fn find_flips(&mut self, rates: &[Rate], may_free: bool) -> usize {
        self.flips.clear();
        if self.find_overruled(rates) {
            return self.flips.len();
        }
        let Self { nodes, rows, bounded, flips, beside, .. } = self;
        for &(number, node) in &*bounded {
            let row = &rows[number as usize];
            if beside.is_on && row.origin == Origin::Contact {
                continue;
            }
            match row.state {
                RowState::Absent => {}
                RowState::Free if row.impulse < row.min => flips.push((number, RowState::Low)),
                RowState::Free if row.impulse > row.max => flips.push((number, RowState::High)),
                RowState::Free => {}
                RowState::Low | RowState::High => {
                    if may_free && row.wants_free(nodes[node as usize].bodies.map(|body| rates[body as usize])) {
                        flips.push((number, RowState::Free));
                    }
                }
            }
        }
        flips.len()
    }

    /// Whether passes that free nothing have kept a row in a state which it is not to be in: a contact that bodies go through.
    pub(super) fn keeps_open(&self, rates: &[Rate]) -> bool {
        self.bounded.iter().any(|&(number, node)| {
            let row = &self.rows[number as usize];
            let is_apart = self.beside.is_on && row.origin == Origin::Contact;
            !is_apart && row.wants_free(self.nodes[node as usize].bodies.map(|body| rates[body as usize]))
        })
    }

    /// Lists the motors and bearings that rub which what joints hold does not let have their way: they push with all they have, or without a
    /// bound they yield. Multipliers of rows that contradict each other tell nothing until then, not even which stops press. Returns whether
    /// there are any.
    fn find_overruled(&mut self, rates: &[Rate]) -> bool {
        let Self { nodes, rows, bounded, flips, .. } = self;
        for &(number, node) in &*bounded {
            let row = &rows[number as usize];
            if row.state != RowState::Free || !row.drives || row.gamma != 0.0 {
                continue;
            }
            let rate = row.rate(&nodes[node as usize].bodies.map(|body| rates[body as usize]));
            let error = rate + row.bias;
            if error.abs() > MET[0] * rate.abs().max(row.bias.abs()) + MET[1] {
                let (state, most) = if error < 0.0 { (RowState::High, row.max) } else { (RowState::Low, row.min) };
                flips.push((number, if most.is_finite() { state } else { RowState::Free }));
            }
        }
        !flips.is_empty()
    }

    /// Lets motors without a bound yield that fling a body round by more than a substep resolves, as near a dead centre, where no force would do what they ask
    /// for: those that would miss it if they yielded. What turns a body in a tree has none. Returns whether any yields that did not before.
    pub(super) fn ease_motors(&mut self, rates: &[Rate], has_loops: bool) -> bool {
        let Self { rows, bounded, base, .. } = self;
        let mut pairs = rates.iter().zip(&base.rates);
        if !pairs.any(|(now, before)| now.angular.distance_squared(before.angular) > base.most_turn * base.most_turn) {
            return false;
        }
        let mut is_eased = false;
        for &(number, _) in &*bounded {
            let row = &mut rows[number as usize];
            // What holds something where it is flings nothing.
            let is_strained = row.bias.abs() > MET[1] && row.give * row.impulse.abs() > STRAINED * row.bias.abs();
            let is_bounded = row.min.is_finite() || row.max.is_finite();
            let may_be_dead = has_loops || row.linear != [DVec3::ZERO; 2];
            if may_be_dead && row.drives && !is_bounded && row.state == RowState::Free && row.gamma == 0.0 && is_strained {
                row.gamma = row.give;
                is_eased = true;
            }
        }
        if is_eased {
            (self.is_factored, self.is_abreast) = (false, false);
        }
        is_eased
    }

    /// Changes the state of the rows that have been found in a wrong one, or of the last of them alone.
    pub(super) fn flip(&mut self, only_the_last: bool) {
        let first = if only_the_last { self.flips.len().saturating_sub(1) } else { 0 };
        for &(number, state) in &self.flips[first..] {
            let row = &mut self.rows[number as usize];
            if state == RowState::Free && row.state == state {
                row.gamma = row.give;
                row.bias = row.bias.clamp(-MAX_RECOVERY_SPEED, MAX_RECOVERY_SPEED);
            }
            row.state = state;
            row.impulse = match state {
                RowState::Low => row.min,
                RowState::High => row.max,
                RowState::Free => row.impulse,
                RowState::Absent => 0.0,
            };
            (self.is_factored, self.is_abreast) = (false, false);
        }
    }

    /// Lets friction slide or stick: inside the cone |λ| ≤ μ Σλ_n it holds; outside it is a push of that size against the slip.
    pub(super) fn revise_friction(&mut self, rates: &[Rate], may_free: bool) -> usize {
        let mut changes = 0;
        for number in 0..self.contacts.len() {
            let contact = self.contacts[number];
            if !contact.has_friction {
                continue;
            }
            let (pressed, first) = (self.pressed(&contact), (contact.first + contact.normals) as usize);
            let pair = self.nodes[contact.node as usize].bodies.map(|body| rates[body as usize]);
            let [u, v, w] = &mut self.rows[first..first + 3] else { continue };
            let slip = |row: &Row| row.rate(&pair) + row.bias;
            let (along, about) = ([slip(u), slip(v)], [slip(w), 0.0]);
            let before = [u.state, w.state];
            changes += usize::from(revise_cone([u, v], along, contact.friction * pressed, may_free));
            // About the normal alone, the cone is an interval.
            let mut none = Row { state: w.state, ..Row::EMPTY };
            changes += usize::from(revise_cone([w, &mut none], about, contact.twist_arm * pressed, may_free));
            self.is_factored &= before == [u.state, w.state];
        }
        changes
    }
}
