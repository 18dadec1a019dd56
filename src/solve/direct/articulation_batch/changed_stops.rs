//! Stops that press or part after their articulation's lane has been factorised.
//!
//! With v the solution of the rows that the factor holds, a stop s that begins to press has the multiplier z for which
//! J_s (v + z a_s) + b_s = 0, where a_s is how the articulation answers to a push of one at the stop with all those rows held: one solve by the
//! factor as it is. A stop that ceases to press is let go by the error z of its row for which its multiplier is zero; it answers to an
//! error of one. So several changes are as many equations, and nothing is factorised anew while rows last.

use super::{ABREAST, ArticulationBatch, NONE, rate_of};
use crate::solve::direct::articulation::Articulation;
use crate::solve::direct::body::DirectBody;
use crate::solve::direct::interleaved_system;
use crate::solve::direct::row::{Row, RowState};
use crate::solve::direct::system::System;
use crate::solve::disjoint::Slots;
use crate::solve::joint::rows::Rate;

/// Passes in which stops may change their states beside the factor: nearly all changes take one or two.
const CHANGES: usize = 4;

/// Most stops of a member that are told apart from its factor: as many equations are solved by elimination.
const MOST: usize = 8;

/// A stop that has changed its state.
#[derive(Debug, Default)]
struct ChangedStop {
    row: u32,
    /// Bodies of its joint.
    bodies: [u32; 2],
    /// Whether the factor holds it: it ceased to press.
    is_held: bool,
    /// What the bodies and the multipliers of the rows that the factor holds, by row, answer.
    rates: Vec<Rate>,
    impulses: Vec<f64>,
}

/// Those of one member, of which lists beyond the count are room.
#[derive(Debug, Default)]
pub(super) struct ChangedStops {
    all: Vec<ChangedStop>,
    count: usize,
}

impl ChangedStops {
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    fn find(&self, row: u32) -> Option<&ChangedStop> {
        self.all[..self.count].iter().find(|stop| stop.row == row)
    }

    /// Whether the factor is to hold this row, numbered `row`: as it has done before, or else if it is free.
    pub(super) fn is_in_factor(&self, number: u32, row: &Row) -> bool {
        self.find(number).map_or(row.state == RowState::Free, |stop| stop.is_held)
    }

    /// Lets rows have the states that they want; false where one is no stop or they are too many: nothing has changed then.
    pub(super) fn take_flips(&mut self, system: &mut System) -> bool {
        let is_new = |&&(row, _): &&(u32, RowState)| self.find(row).is_none();
        let count = self.count + system.flips.iter().filter(is_new).count();
        if count > MOST || !system.flips.iter().all(|&(row, _)| system.rows[row as usize].is_stop()) {
            return false;
        }
        let System { flips, rows, bounded, nodes, .. } = system;
        for &(number, state) in &*flips {
            let row = &mut rows[number as usize];
            if self.find(number).is_none() {
                let node = bounded.iter().find(|&&(row, _)| row == number).map_or(0, |&(_, node)| node);
                self.add(number, nodes[node as usize].bodies, row.state == RowState::Free);
            }
            row.state = state;
        }
        true
    }

    fn add(&mut self, row: u32, bodies: [u32; 2], is_held: bool) {
        if self.all.len() == self.count {
            self.all.push(ChangedStop::default());
        }
        let stop = &mut self.all[self.count];
        (stop.row, stop.bodies, stop.is_held) = (row, bodies, is_held);
        stop.rates.clear();
        stop.impulses.clear();
        self.count += 1;
    }

    /// A stop whose answer is not known yet: its row, the bodies of its joint, and whether the factor holds it.
    pub(super) fn asked(&self) -> Option<(u32, [u32; 2], bool)> {
        let asked = self.all[..self.count].iter().find(|stop| stop.rates.is_empty());
        asked.map(|stop| (stop.row, stop.bodies, stop.is_held))
    }

    /// Notes the answer of that stop: of bodies, and of multipliers by row.
    pub(super) fn answer(&mut self, rates: impl Iterator<Item = Rate>, rows: usize, impulses: impl Iterator<Item = (u32, f64)>) {
        let Some(stop) = self.all[..self.count].iter_mut().find(|stop| stop.rates.is_empty()) else { return };
        stop.rates.extend(rates);
        stop.impulses.resize(rows, 0.0);
        impulses.for_each(|(row, impulse)| stop.impulses[row as usize] = impulse);
    }

    /// Makes up for the changed stops in velocities, and multipliers of rows, that solve all rows of the factor. False where they cannot do as
    /// they should; nothing has changed then.
    pub(super) fn make_up(&self, rows: &mut [Row], rates: &mut [Rate]) -> bool {
        let impulses = self.all[..self.count].iter().map(|stop| rows[stop.row as usize].impulse);
        let Some(shares) = self.shares(rows, rates, impulses) else { return false };
        for (stop, share) in self.all[..self.count].iter().zip(shares) {
            add_rates(rates, &stop.rates, share);
            rows.iter_mut().zip(&stop.impulses).for_each(|(row, impulse)| row.impulse += impulse * share);
            if !stop.is_held {
                rows[stop.row as usize].impulse += share;
            }
        }
        for stop in &self.all[..self.count] {
            let row = &mut rows[stop.row as usize];
            if row.state != RowState::Free {
                row.impulse = 0.0;
            }
        }
        true
    }

    /// The same of changes of bodies alone, by multipliers of their own, of which `impulse` is that of a row which the factor holds.
    pub(super) fn make_up_changes(&self, rows: &[Row], changes: &mut [Rate], impulse: impl Fn(u32) -> f64) {
        let impulses = self.all[..self.count].iter().map(|stop| if stop.is_held { impulse(stop.row) } else { 0.0 });
        let shares = self.shares(rows, changes, impulses);
        for (stop, share) in self.all[..self.count].iter().zip(shares.into_iter().flatten()) {
            add_rates(changes, &stop.rates, share);
        }
    }

    /// Adds what stops do that press without being held by the factor to the rates.
    pub(super) fn push_pressing(&self, rows: &[Row], bodies: &[DirectBody], rates: &mut [Rate]) {
        for stop in self.all[..self.count].iter().filter(|stop| !stop.is_held) {
            let row = &rows[stop.row as usize];
            if row.state == RowState::Free && row.impulse != 0.0 {
                let [a, b] = stop.bodies.map(|body| body as usize);
                let pushed = push(row, row.impulse, [&bodies[a], &bodies[b]]);
                add_rates(&mut rates[a..=a], &pushed[..1], 1.0);
                add_rates(&mut rates[b..=b], &pushed[1..], 1.0);
            }
        }
    }

    /// By how much of its answer each changed stop is made up for; `impulses` are their multipliers now.
    fn shares(&self, rows: &[Row], rates: &[Rate], impulses: impl Iterator<Item = f64>) -> Option<[f64; MOST]> {
        let mut equations = [[0.0; MOST + 1]; MOST];
        for ((stop, impulse), equation) in self.all[..self.count].iter().zip(impulses).zip(&mut equations) {
            let row = &rows[stop.row as usize];
            let pair = |rates: &[Rate]| stop.bodies.map(|body| rates[body as usize]);
            let is_free = row.state == RowState::Free;
            for (other, number) in self.all[..self.count].iter().zip(&mut *equation) {
                let own = if other.row == stop.row && !stop.is_held { 1.0 } else { other.impulses[stop.row as usize] };
                *number = if is_free { row.rate(&pair(&other.rates)) + row.gamma * own } else { own };
            }
            equation[MOST] = if is_free { -(row.rate(&pair(rates)) + row.bias + row.gamma * impulse) } else { -impulse };
        }
        eliminate(&mut equations, self.count)
    }
}

fn add_rates(rates: &mut [Rate], more: &[Rate], share: f64) {
    for (rate, more) in rates.iter_mut().zip(more) {
        rate.linear += more.linear * share;
        rate.angular += more.angular * share;
    }
}

/// Solves the first `count` of these equations, right sides last, each by its greatest pivot; none where one has no pivot.
fn eliminate(equations: &mut [[f64; MOST + 1]; MOST], count: usize) -> Option<[f64; MOST]> {
    for column in 0..count {
        let size = |row: &usize| equations[*row][column].abs();
        let pivot = (column..count).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        equations.swap(column, pivot);
        let own = equations[column];
        if !(own[column].abs() > f64::MIN_POSITIVE && own[column].is_finite()) {
            return None;
        }
        for equation in &mut equations[column + 1..count] {
            let share = equation[column] / own[column];
            equation.iter_mut().zip(&own).for_each(|(number, own)| *number -= own * share);
        }
    }
    let mut shares = [0.0; MOST];
    for column in (0..count).rev() {
        let equation = &equations[column];
        let known: f64 = (column + 1..count).map(|other| equation[other] * shares[other]).sum();
        shares[column] = (equation[MOST] - known) / equation[column];
    }
    Some(shares)
}

/// What a multiplier of a row does to its two bodies.
fn push(row: &Row, impulse: f64, bodies: [&DirectBody; 2]) -> [Rate; 2] {
    std::array::from_fn(|side| Rate {
        linear: bodies[side].inverse_mass * row.linear[side] * impulse,
        angular: bodies[side].inverse_inertia * (row.angular[side] * impulse),
    })
}

impl ArticulationBatch {
    /// Hands the multipliers of these lanes back, and has stops press or part that ask for it. Returns the lanes in which some still ask for it,
    /// which their members are left to do by themselves.
    pub(super) fn change_stops(
        &mut self,
        articulations: &mut (impl Slots<Articulation> + ?Sized),
        lanes: [bool; ABREAST],
    ) -> [bool; ABREAST] {
        let (mut open, mut unsettled) = (lanes, [false; ABREAST]);
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            let Articulation { system, rates, .. } = articulations.get_mut(self.members[lane]);
            self.give_impulses(lane, system);
            let changed = &self.changed[lane];
            system.flips.clear();
            unsettled[lane] = !changed.is_empty() && !changed.make_up(&mut system.rows, rates);
        }
        let mut are_new = [false; ABREAST];
        for pass in 0..CHANGES {
            for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
                let Articulation { system, rates, .. } = articulations.get_mut(self.members[lane]);
                if !open[lane] || unsettled[lane] || system.find_flips(rates, true) == 0 {
                    open[lane] = false;
                    continue;
                }
                let may_go_on = pass + 1 < CHANGES && self.is_exact[lane] && self.changed[lane].take_flips(system);
                (unsettled[lane], open[lane], are_new[lane]) = (!may_go_on, may_go_on, are_new[lane] | may_go_on);
            }
            if open == [false; ABREAST] {
                break;
            }
            self.find_answers(articulations, open);
            for lane in (0..self.members.len()).filter(|&lane| open[lane]) {
                let Articulation { system, rates, .. } = articulations.get_mut(self.members[lane]);
                unsettled[lane] = !self.changed[lane].make_up(&mut system.rows, rates);
            }
        }
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane] && !unsettled[lane]) {
            let system = &articulations.get(self.members[lane]).system;
            if are_new[lane] {
                self.take_biases(lane, system);
            }
            if !self.changed[lane].is_empty() {
                self.take_impulses(lane, system);
            }
        }
        unsettled
    }

    /// Finds how the members in these lanes answer to stops that have newly changed, one of each at a time; biases, multipliers and rates of
    /// those lanes are lost.
    fn find_answers(&mut self, articulations: &(impl Slots<Articulation> + ?Sized), lanes: [bool; ABREAST]) {
        loop {
            let asked = |lane: usize| if lanes[lane] { self.changed[lane].asked() } else { None };
            let asked: [Option<(u32, [u32; 2], bool)>; ABREAST] = std::array::from_fn(asked);
            let asking = asked.map(|asked| asked.is_some());
            if asking == [false; ABREAST] {
                return;
            }
            self.clear_impulses(asking);
            self.interleaved.rates.fill([[0.0; ABREAST]; 6]);
            for (lane, asked) in asked.iter().enumerate() {
                let &Some((number, pair, is_held)) = asked else { continue };
                let is_own = |index: &[u32; ABREAST]| is_held && index[lane] == number;
                for (bias, index) in self.interleaved.bias.iter_mut().zip(&self.index) {
                    bias[lane] = if is_own(index) { 1.0 } else { 0.0 };
                }
                let own = articulations.get(self.members[lane]);
                let bodies = pair.map(|body| &own.bodies[body as usize]);
                let impulse = if is_held { 0.0 } else { 1.0 };
                let rates = push(&own.system.rows[number as usize], impulse, bodies);
                for (body, rate) in pair.into_iter().zip(rates) {
                    let numbers = rate.linear.to_array().into_iter().chain(rate.angular.to_array());
                    let into = &mut self.interleaved.rates[body as usize];
                    into.iter_mut().zip(numbers).for_each(|(into, number)| into[lane] = number);
                }
            }
            let Articulation { system: System { nodes, .. }, topology, .. } = articulations.get(self.members[0]);
            interleaved_system::solve(&mut self.interleaved, nodes, &topology.plan, &asking);
            for lane in (0..self.members.len()).filter(|&lane| asking[lane]) {
                let rows = articulations.get(self.members[lane]).system.rows.len();
                let Self { interleaved, index, changed, .. } = self;
                let impulses = index.iter().zip(&interleaved.impulse).map(|(index, impulse)| (index[lane], impulse[lane]));
                let rates = interleaved.rates.iter().map(|rate| rate_of(rate, lane));
                changed[lane].answer(rates, rows, impulses.filter(|&(row, _)| row != NONE));
            }
        }
    }
}
