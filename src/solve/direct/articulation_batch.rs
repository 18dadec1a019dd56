//! Swept articulations of one structure, four at a time.
//!
//! Ragdolls of a heap have the same joints, so that their systems differ in numbers alone. Their carried multipliers, their solves between
//! sweeps over contacts and the mending of their positions go through the same loops side by side ([`interleaved`](super::interleaved_system)).
//! Stops that press or part are solved beside the factor (*changed_stops.rs*). Whatever is not alike, a motor that comes to its bound or a
//! first solve that carries nothing, is done by the articulation's own [`System`], and stays with it while its rows last.

use super::articulation::Articulation;
use super::body::DirectBody;
use super::factor_reuse::{MENDINGS, Settling};
use super::interleaved_system::{self, InterleavedSystem};
use super::row::Row;
use super::system::{PASSES, System};
use super::topology::Topology;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::solve::disjoint::Slots;
use crate::solve::joint::rows::Rate;
use crate::solve::state::{BodyMotion, BodyVelocity};
use changed_stops::ChangedStops;

mod changed_stops;

/// Articulations that go side by side.
const ABREAST: usize = 4;

/// Row that a member lacks.
const NONE: u32 = u32::MAX;

/// Groups that still take members: of more kinds of articulations than these, some stay alone.
const OPEN: usize = 8;

/// Share of what rows lacked that a solve may leave; what leaves more is solved for once more.
const REFINE_ABOVE: f64 = 1.0e-7;

/// Up to four articulations of one structure.
#[derive(Debug, Default)]
pub(super) struct ArticulationBatch {
    members: Vec<u32>,
    interleaved: InterleavedSystem,
    /// Row of each member in each place.
    index: Vec<[u32; ABREAST]>,
    is_factored: bool,
    /// Whether a solution by the factor of each member has been found to need no refinement.
    is_exact: [bool; ABREAST],
    /// Stops of each member that have changed their states since.
    changed: [ChangedStops; ABREAST],
}

/// Groups of the swept articulations of a batch.
#[derive(Debug, Default)]
pub(super) struct ArticulationBatches {
    groups: Vec<ArticulationBatch>,
    count: usize,
    /// Articulations that are swept by themselves.
    lone: Vec<u32>,
}

impl ArticulationBatches {
    /// Forgets the groups of the last step.
    pub(super) fn clear(&mut self) {
        self.count = 0;
        self.lone.clear();
    }

    /// Groups the articulations that are swept and have a twin.
    pub(super) fn gather(&mut self, articulations: &mut [Articulation]) {
        self.count = 0;
        let mut first_open = 0;
        for number in 0..articulations.len() {
            let own = &articulations[number];
            if !own.coupled || own.is_points || own.topology.loops > 0 {
                continue;
            }
            let is_twin = |group: &ArticulationBatch| {
                group.members.len() < ABREAST && articulations[group.members[0] as usize].is_twin(own)
            };
            let found = self.groups[first_open..self.count].iter().position(is_twin);
            let group = match found {
                Some(place) => &mut self.groups[first_open + place],
                None => {
                    if self.groups.len() == self.count {
                        self.groups.push(ArticulationBatch::default());
                    }
                    self.count += 1;
                    first_open = first_open.max(self.count.saturating_sub(OPEN));
                    let group = &mut self.groups[self.count - 1];
                    group.members.clear();
                    group.is_factored = false;
                    group
                }
            };
            group.members.push(number as u32);
        }
        self.lone.clear();
        for group in &self.groups[..self.count] {
            let has_twins = group.members.len() > 1;
            group.members.iter().for_each(|&member| articulations[member as usize].in_lockstep = has_twins);
        }
        let goes_alone = |own: &Articulation| own.coupled && !own.in_lockstep;
        self.lone.extend((0..).zip(&*articulations).filter(|(_, own)| goes_alone(own)).map(|(number, _)| number));
    }

    /// Swept articulations that go alone, by number, and groups of those that do not.
    pub(super) fn parts(&mut self) -> (&[u32], &mut [ArticulationBatch]) {
        (&self.lone, &mut self.groups[..self.count])
    }
}

impl ArticulationBatch {
    /// Its articulations, by number; none where there is only one, which goes alone.
    pub(super) fn members(&self) -> &[u32] {
        if self.members.len() > 1 { &self.members } else { &[] }
    }

    /// As [`Articulation::warm_start`], of each member.
    pub(super) fn warm_start(
        &mut self,
        articulations: &mut (impl Slots<Articulation> + ?Sized),
        velocities: &mut (impl Slots<BodyVelocity> + ?Sized),
        iterations: u32,
    ) {
        let mut lanes = [false; ABREAST];
        for (lane, &member) in lanes.iter_mut().zip(&self.members) {
            let own = articulations.get_mut(member);
            if own.goes_abreast() {
                *lane = own.may_start_warm(iterations);
            } else {
                own.warm_start(velocities, iterations);
            }
        }
        if lanes == [false; ABREAST] {
            return;
        }
        self.take_in(articulations, lanes);
        self.take_rates(articulations, velocities, lanes);
        interleaved_system::push(&mut self.interleaved, &articulations.get(self.members[0]).system.nodes, &lanes);
        self.give_rates(articulations, lanes);
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            let own = articulations.get_mut(self.members[lane]);
            let Articulation { system, bodies, rates, .. } = &mut *own;
            system.note_pushed(bodies, rates);
            self.changed[lane].push_pressing(&system.rows, bodies, rates);
            own.is_warm = !own.overshoots(velocities);
            own.give_rates(velocities);
        }
    }

    /// As [`Articulation::sweep`], of each member.
    pub(super) fn sweep(
        &mut self,
        articulations: &mut (impl Slots<Articulation> + ?Sized),
        velocities: &mut (impl Slots<BodyVelocity> + ?Sized),
    ) {
        let mut lanes = [false; ABREAST];
        for (lane, &member) in lanes.iter_mut().zip(&self.members) {
            let own = articulations.get_mut(member);
            if own.goes_abreast() && (own.is_warm || own.system.has_pushed) {
                *lane = !std::mem::replace(&mut own.is_warm, false);
            } else {
                own.sweep(velocities);
            }
        }
        if lanes == [false; ABREAST] {
            return;
        }
        self.take_in(articulations, lanes);
        self.take_rates(articulations, velocities, lanes);
        self.solve(articulations, lanes);
        self.give_rates(articulations, lanes);
        let unsettled = self.change_stops(articulations, lanes);
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            let own = articulations.get_mut(self.members[lane]);
            if unsettled[lane] {
                own.system.withdraw(&own.bodies, &mut own.rates);
                own.system.flip(false);
                own.system.solve(&own.topology, &own.bodies, &mut own.rates, PASSES);
            }
            own.give_rates(velocities);
        }
    }

    /// As [`Articulation::settle`], of each member.
    pub(super) fn settle(
        &mut self,
        articulations: &mut (impl Slots<Articulation> + ?Sized),
        joints: &Pool<Joint, JointId>,
        velocities: &(impl Slots<BodyVelocity> + ?Sized),
        motions: &mut (impl Slots<BodyMotion> + ?Sized),
        is_end: bool,
    ) {
        let mut settling = [None::<Settling>; ABREAST];
        for (settling, &member) in settling.iter_mut().zip(&self.members) {
            *settling = articulations.get_mut(member).begin_settling(joints, velocities, motions, is_end);
        }
        for round in 1..=MENDINGS {
            self.mend(articulations, joints, &mut settling, round < MENDINGS);
        }
        for (&member, settling) in self.members.iter().zip(settling) {
            if let Some(settling) = settling {
                articulations.get_mut(member).end_settling(joints, motions, settling.errors);
            }
        }
    }

    /// Has lasting rows mend the positions of those members that ask for it; `again` where they may ask once more.
    fn mend(
        &mut self,
        articulations: &mut (impl Slots<Articulation> + ?Sized),
        joints: &Pool<Joint, JointId>,
        settling: &mut [Option<Settling>; ABREAST],
        again: bool,
    ) {
        let mut lanes = [false; ABREAST];
        for lane in (0..self.members.len()).filter(|&lane| settling[lane].is_some_and(|settling| settling.mends)) {
            let own = articulations.get_mut(self.members[lane]);
            lanes[lane] = own.system.is_abreast;
            match lanes[lane] {
                true => self.take_biases(lane, &own.system),
                false => own.solve_lasting(),
            }
        }
        if lanes != [false; ABREAST] {
            self.clear_impulses(lanes);
            self.interleaved.rates.fill([[0.0; ABREAST]; 6]);
            self.solve(articulations, lanes);
        }
        for (lane, settling) in settling.iter_mut().enumerate() {
            let Some(settling) = settling.as_mut().filter(|settling| settling.mends) else { continue };
            let own = articulations.get_mut(self.members[lane]);
            if lanes[lane] {
                self.give_changes(lane, own);
            }
            own.mend_with_lasting_rows(joints, settling, again);
        }
    }

    /// As [`Articulation::yield_to`], of each member.
    pub(super) fn yield_to(
        &mut self,
        articulations: &mut (impl Slots<Articulation> + ?Sized),
        pushes: &mut (impl Slots<BodyVelocity> + ?Sized),
    ) {
        let mut lanes = [false; ABREAST];
        for (lane, &member) in lanes.iter_mut().zip(&self.members) {
            let own = articulations.get_mut(member);
            if own.system.is_abreast {
                *lane = own.begin_yielding(pushes);
            } else {
                own.yield_to(pushes);
            }
        }
        if lanes == [false; ABREAST] {
            return;
        }
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            self.take_biases(lane, &articulations.get(self.members[lane]).system);
        }
        self.clear_impulses(lanes);
        self.take_rates(articulations, pushes, lanes);
        self.solve(articulations, lanes);
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            let own = articulations.get_mut(self.members[lane]);
            self.give_changes(lane, own);
            own.end_yielding(pushes);
        }
    }

    /// What the last solve changed in the rates of this lane, given to its member.
    fn give_changes(&self, lane: usize, own: &mut Articulation) {
        own.changes.clear();
        own.changes.extend(self.interleaved.rates.iter().map(|rate| rate_of(rate, lane)));
        let changed = &self.changed[lane];
        if !changed.is_empty() {
            let place = |row: u32| self.index.iter().position(|index| index[lane] == row);
            let impulse = |row: u32| place(row).map_or(0.0, |place| self.interleaved.impulse[place][lane]);
            changed.make_up_changes(&own.system.rows, &mut own.changes, impulse);
        }
    }

    /// Forgets the multipliers of these lanes; the others may go on with theirs.
    fn clear_impulses(&mut self, lanes: [bool; ABREAST]) {
        for impulse in &mut self.interleaved.impulse {
            for lane in (0..ABREAST).filter(|&lane| lanes[lane]) {
                impulse[lane] = 0.0;
            }
        }
    }

    fn chosen(&self, lanes: [bool; ABREAST]) -> impl Iterator<Item = u32> {
        self.members.iter().zip(lanes).filter(|&(_, chosen)| chosen).map(|(&member, _)| member)
    }

    /// Solves for what the rows of these lanes lack.
    fn solve(&mut self, articulations: &(impl Slots<Articulation> + ?Sized), lanes: [bool; ABREAST]) {
        let Articulation { system: System { nodes, .. }, topology, .. } = articulations.get(self.members[0]);
        if !std::mem::replace(&mut self.is_factored, true) {
            interleaved_system::factorize(&mut self.interleaved, nodes, topology);
        }
        let Topology { plan, .. } = topology;
        let first = interleaved_system::solve(&mut self.interleaved, nodes, plan, &lanes);
        let asks = |lane: usize, is_exact: &[bool; ABREAST]| lanes[lane] && !is_exact[lane];
        if !(0..ABREAST).any(|lane| asks(lane, &self.is_exact)) {
            return;
        }
        let left = interleaved_system::find_errors(&mut self.interleaved, nodes, &lanes);
        let unsure: [bool; ABREAST] =
            std::array::from_fn(|lane| asks(lane, &self.is_exact) && left[lane] > REFINE_ABOVE * first[lane]);
        for lane in (0..ABREAST).filter(|&lane| lanes[lane]) {
            self.is_exact[lane] = !unsure[lane];
        }
        if unsure != [false; ABREAST] {
            interleaved_system::solve(&mut self.interleaved, nodes, plan, &unsure);
        }
    }

    /// Takes in the rows and bodies of all members where those of any of these lanes have changed, and biases where stops have come nearer.
    fn take_in(&mut self, articulations: &mut (impl Slots<Articulation> + ?Sized), lanes: [bool; ABREAST]) {
        if self.chosen(lanes).all(|member| articulations.get(member).system.is_abreast) {
            for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
                let system = &mut articulations.get_mut(self.members[lane]).system;
                if std::mem::replace(&mut system.has_new_biases, false) {
                    self.take_biases(lane, system);
                }
            }
            return;
        }
        self.is_factored = false;
        for (lane, &member) in self.members.iter().enumerate() {
            let is_known = articulations.get(member).system.is_abreast;
            // What one has been found to need does not depend on who joins it.
            self.is_exact[lane] &= is_known;
            if !is_known {
                self.changed[lane].clear();
            }
        }
        self.choose(articulations);
        self.interleaved.start(articulations.get(self.members[0]).bodies.len());
        for &member in &self.members {
            let system = &mut articulations.get_mut(member).system;
            (system.is_abreast, system.has_new_biases) = (true, false);
        }
        let own = |lane: usize| self.members.get(lane).map(|&member| articulations.get(member));
        let own: [Option<&Articulation>; ABREAST] = std::array::from_fn(own);
        write_rows(&mut self.interleaved, &self.index, own.map(|own| own.map_or(&[][..], |own| &own.system.rows)));
        write_masses(&mut self.interleaved, own.map(|own| own.map_or(&[][..], |own| &own.bodies)));
        interleaved_system::respond(&mut self.interleaved, &articulations.get(self.members[0]).system.nodes);
    }

    /// Gives each free row of each member a place in its node.
    fn choose(&mut self, articulations: &(impl Slots<Articulation> + ?Sized)) {
        let Self { members, interleaved, index, changed, .. } = self;
        let systems = || members.iter().map(|&member| &articulations.get(member).system);
        interleaved.counts.clear();
        index.clear();
        for number in 0..articulations.get(members[0]).system.nodes.len() {
            let first = index.len();
            for (lane, system) in systems().enumerate() {
                let node = &system.nodes[number];
                let is_in = |&row: &u32| changed[lane].is_in_factor(row, &system.rows[row as usize]);
                for (place, row) in (node.first..node.last).filter(is_in).enumerate() {
                    if index.len() == first + place {
                        index.push([NONE; ABREAST]);
                    }
                    index[first + place][lane] = row;
                }
            }
            interleaved.counts.push((index.len() - first) as u32);
        }
    }

    fn take_biases(&mut self, lane: usize, system: &System) {
        for (bias, row) in self.interleaved.bias.iter_mut().zip(&self.index) {
            if row[lane] != NONE {
                bias[lane] = system.rows[row[lane] as usize].bias;
            }
        }
    }

    fn take_impulses(&mut self, lane: usize, system: &System) {
        for (impulse, row) in self.interleaved.impulse.iter_mut().zip(&self.index) {
            if row[lane] != NONE {
                impulse[lane] = system.rows[row[lane] as usize].impulse;
            }
        }
    }

    /// Hands the multipliers of a member back to its rows.
    fn give_impulses(&self, lane: usize, system: &mut System) {
        for (impulse, row) in self.interleaved.impulse.iter().zip(&self.index) {
            if row[lane] != NONE {
                system.rows[row[lane] as usize].impulse = impulse[lane];
            }
        }
        // A factor of its own would go on from other multipliers.
        system.is_factored = false;
    }

    fn take_rates(
        &mut self,
        articulations: &(impl Slots<Articulation> + ?Sized),
        velocities: &(impl Slots<BodyVelocity> + ?Sized),
        lanes: [bool; ABREAST],
    ) {
        let bodies = |lane: usize| match self.members.get(lane) {
            Some(&member) if lanes[lane] => &articulations.get(member).bodies[..],
            _ => &[],
        };
        let bodies: [&[DirectBody]; ABREAST] = std::array::from_fn(bodies);
        for (number, into) in self.interleaved.rates.iter_mut().enumerate() {
            let rates = bodies.map(|bodies| match bodies.get(number) {
                Some(body) => numbers_of(velocities.get(body.slot)),
                None => [0.0; 6],
            });
            *into = std::array::from_fn(|i| rates.map(|rate| f64::from(rate[i])));
        }
    }

    fn give_rates(&self, articulations: &mut (impl Slots<Articulation> + ?Sized), lanes: [bool; ABREAST]) {
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            let rates = &mut articulations.get_mut(self.members[lane]).rates;
            rates.clear();
            rates.extend(self.interleaved.rates.iter().map(|rate| rate_of(rate, lane)));
        }
    }
}

/// Linear and angular velocity.
fn numbers_of(velocity: &BodyVelocity) -> [f32; 6] {
    let (linear, angular) = (velocity.linear, velocity.angular);
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// Writes the rows of each member into its lane, with zeros where it has none.
fn write_rows(interleaved: &mut InterleavedSystem, index: &[[u32; ABREAST]], rows: [&[Row]; ABREAST]) {
    for (place, numbers) in index.iter().enumerate() {
        let row = |lane: usize| rows[lane].get(numbers[lane] as usize).unwrap_or(&Row::EMPTY);
        let row: [&Row; ABREAST] = std::array::from_fn(row);
        let jacobian = &mut interleaved.jacobian[place];
        for side in 0..2 {
            for i in 0..3 {
                jacobian[6 * side + i] = row.map(|row| row.linear[side][i]);
                jacobian[6 * side + 3 + i] = row.map(|row| row.angular[side][i]);
            }
        }
        interleaved.bias[place] = row.map(|row| row.bias);
        interleaved.gamma[place] = row.map(|row| row.gamma);
        interleaved.impulse[place] = row.map(|row| row.impulse);
    }
}

/// Writes the bodies of each member into its lane, with zeros where there is none.
fn write_masses(interleaved: &mut InterleavedSystem, bodies: [&[DirectBody]; ABREAST]) {
    let none = ([0.0; 3], [0.0; 9]);
    for (number, into) in interleaved.masses.iter_mut().enumerate() {
        let masses = bodies.map(|bodies| {
            bodies.get(number).map_or(none, |body| (body.inverse_mass.to_array(), body.inverse_inertia.to_cols_array()))
        });
        for i in 0..3 {
            into[i] = masses.map(|(mass, _)| mass[i]);
        }
        for i in 0..9 {
            into[3 + i] = masses.map(|(_, inertia)| inertia[i]);
        }
    }
}

fn rate_of(rate: &[[f64; ABREAST]; 6], lane: usize) -> Rate {
    let [x, y, z, about_x, about_y, about_z] = rate.map(|number| number[lane]);
    Rate { linear: glam::DVec3::new(x, y, z), angular: glam::DVec3::new(about_x, about_y, about_z) }
}

#[cfg(test)]
mod tests;
