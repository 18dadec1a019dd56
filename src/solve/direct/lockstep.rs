//! Swept articulations of one structure, four at a time.
//!
//! Ragdolls of a heap have the same joints, so that their systems differ in numbers alone. Their carried multipliers, their solves between
//! sweeps over contacts and the mending of their positions go through the same loops side by side ([`abreast`](super::abreast)). Whatever
//! is not alike, a row that changes its state or a first solve that carries nothing, is done by the articulation's own [`System`], and
//! stays with it for the step.

use super::abreast::{self, Abreast};
use super::articulation::Articulation;
use super::body::DirectBody;
use super::lasting::{MENDINGS, Settling};
use super::row::{Row, State};
use super::system::{PASSES, System, Topology};
use crate::id::{JointId, Pool};
use crate::joint::Joint;
use crate::solve::joint::rows::Rate;
use crate::solve::shared::Slots;
use crate::solve::state::{BodyMotion, BodyVelocity};

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
pub(super) struct Lockstep {
    members: Vec<u32>,
    abreast: Abreast,
    /// Row of each member in each place.
    index: Vec<[u32; ABREAST]>,
    is_factored: bool,
    /// Whether a solution by the factor of each member has been found to need no refinement.
    is_exact: [bool; ABREAST],
}

/// Groups of the swept articulations of a batch.
#[derive(Debug, Default)]
pub(super) struct Locksteps {
    groups: Vec<Lockstep>,
    count: usize,
    /// Articulations that are swept by themselves.
    lone: Vec<u32>,
}

impl Locksteps {
    /// Groups the articulations that are swept and have a twin.
    pub(super) fn gather(&mut self, articulations: &mut [Articulation]) {
        self.count = 0;
        let mut first_open = 0;
        for number in 0..articulations.len() {
            let own = &articulations[number];
            if !own.coupled || own.is_points || own.topology.loops > 0 {
                continue;
            }
            let is_twin =
                |group: &Lockstep| group.members.len() < ABREAST && articulations[group.members[0] as usize].is_twin(own);
            let found = self.groups[first_open..self.count].iter().position(is_twin);
            let group = match found {
                Some(place) => &mut self.groups[first_open + place],
                None => {
                    if self.groups.len() == self.count {
                        self.groups.push(Lockstep::default());
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
    pub(super) fn parts(&mut self) -> (&[u32], &mut [Lockstep]) {
        (&self.lone, &mut self.groups[..self.count])
    }
}

impl Lockstep {
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
        abreast::push(&mut self.abreast, &articulations.get(self.members[0]).system.nodes, &lanes);
        self.give_rates(articulations, lanes);
        for member in self.chosen(lanes) {
            let own = articulations.get_mut(member);
            own.system.note_pushed(&own.bodies, &mut own.rates);
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
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            let own = articulations.get_mut(self.members[lane]);
            self.give_impulses(lane, &mut own.system);
            if own.system.find_flips(&own.rates, true) > 0 {
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
            self.abreast.rates.fill([[0.0; ABREAST]; 6]);
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
        own.changes.extend(self.abreast.rates.iter().map(|rate| rate_of(rate, lane)));
    }

    /// Forgets the multipliers of these lanes; the others may go on with theirs.
    fn clear_impulses(&mut self, lanes: [bool; ABREAST]) {
        for impulse in &mut self.abreast.impulse {
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
            abreast::factorize(&mut self.abreast, nodes, topology);
        }
        let Topology { plan, .. } = topology;
        let first = abreast::solve(&mut self.abreast, nodes, plan, &lanes);
        let asks = |lane: usize, is_exact: &[bool; ABREAST]| lanes[lane] && !is_exact[lane];
        if !(0..ABREAST).any(|lane| asks(lane, &self.is_exact)) {
            return;
        }
        let left = abreast::find_errors(&mut self.abreast, nodes, &lanes);
        let unsure: [bool; ABREAST] =
            std::array::from_fn(|lane| asks(lane, &self.is_exact) && left[lane] > REFINE_ABOVE * first[lane]);
        for lane in (0..ABREAST).filter(|&lane| lanes[lane]) {
            self.is_exact[lane] = !unsure[lane];
        }
        if unsure != [false; ABREAST] {
            abreast::solve(&mut self.abreast, nodes, plan, &unsure);
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
        self.choose(articulations);
        self.abreast.start(articulations.get(self.members[0]).bodies.len());
        for lane in 0..ABREAST {
            let own = self.members.get(lane).map(|&member| articulations.get_mut(member));
            let (rows, bodies) = match own {
                Some(own) => {
                    // What one has been found to need does not depend on who joins it.
                    self.is_exact[lane] &= own.system.is_abreast;
                    (own.system.is_abreast, own.system.has_new_biases) = (true, false);
                    (&own.system.rows[..], &own.bodies[..])
                }
                None => Default::default(),
            };
            write_rows(&mut self.abreast, &self.index, lane, rows);
            write_masses(&mut self.abreast, lane, bodies);
        }
        abreast::respond(&mut self.abreast, &articulations.get(self.members[0]).system.nodes);
    }

    /// Gives each free row of each member a place in its node.
    fn choose(&mut self, articulations: &(impl Slots<Articulation> + ?Sized)) {
        let Self { members, abreast, index, .. } = self;
        let systems = || members.iter().map(|&member| &articulations.get(member).system);
        abreast.counts.clear();
        index.clear();
        for number in 0..articulations.get(members[0]).system.nodes.len() {
            let first = index.len();
            for (lane, system) in systems().enumerate() {
                let node = &system.nodes[number];
                let is_free = |&row: &u32| system.rows[row as usize].state == State::Free;
                for (place, row) in (node.first..node.last).filter(is_free).enumerate() {
                    if index.len() == first + place {
                        index.push([NONE; ABREAST]);
                    }
                    index[first + place][lane] = row;
                }
            }
            abreast.counts.push((index.len() - first) as u32);
        }
    }

    fn take_biases(&mut self, lane: usize, system: &System) {
        for (bias, row) in self.abreast.bias.iter_mut().zip(&self.index) {
            if row[lane] != NONE {
                bias[lane] = system.rows[row[lane] as usize].bias;
            }
        }
    }

    /// Hands the multipliers of a member back to its rows.
    fn give_impulses(&self, lane: usize, system: &mut System) {
        for (impulse, row) in self.abreast.impulse.iter().zip(&self.index) {
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
        self.abreast.rates.fill([[0.0; ABREAST]; 6]);
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            let bodies = &articulations.get(self.members[lane]).bodies;
            for (into, body) in self.abreast.rates.iter_mut().zip(bodies) {
                let velocity = velocities.get(body.slot);
                let numbers = velocity.linear.to_array().into_iter().chain(velocity.angular.to_array());
                into.iter_mut().zip(numbers).for_each(|(into, number)| into[lane] = f64::from(number));
            }
        }
    }

    fn give_rates(&self, articulations: &mut (impl Slots<Articulation> + ?Sized), lanes: [bool; ABREAST]) {
        for lane in (0..self.members.len()).filter(|&lane| lanes[lane]) {
            let rates = &mut articulations.get_mut(self.members[lane]).rates;
            rates.clear();
            rates.extend(self.abreast.rates.iter().map(|rate| rate_of(rate, lane)));
        }
    }
}

/// Writes the rows of a member into its lane, with zeros where it has none.
fn write_rows(abreast: &mut Abreast, index: &[[u32; ABREAST]], lane: usize, rows: &[Row]) {
    for (place, number) in index.iter().enumerate() {
        let row = rows.get(number[lane] as usize).unwrap_or(&Row::EMPTY);
        let jacobian = &mut abreast.jacobian[place];
        for side in 0..2 {
            let numbers = row.linear[side].to_array().into_iter().chain(row.angular[side].to_array());
            jacobian[6 * side..].iter_mut().zip(numbers).for_each(|(into, number)| into[lane] = number);
        }
        abreast.bias[place][lane] = row.bias;
        abreast.gamma[place][lane] = row.gamma;
        abreast.impulse[place][lane] = row.impulse;
    }
}

/// Writes the bodies of a member into its lane, with zeros where there is none.
fn write_masses(abreast: &mut Abreast, lane: usize, bodies: &[DirectBody]) {
    for (number, into) in abreast.masses.iter_mut().enumerate() {
        let (mass, inertia) = bodies
            .get(number)
            .map_or_else(Default::default, |body| (body.inverse_mass.to_array(), body.inverse_inertia.to_cols_array()));
        into.iter_mut().zip(mass.into_iter().chain(inertia)).for_each(|(into, number)| into[lane] = number);
    }
}

fn rate_of(rate: &[[f64; ABREAST]; 6], lane: usize) -> Rate {
    let [x, y, z, about_x, about_y, about_z] = rate.map(|number| number[lane]);
    Rate { linear: glam::DVec3::new(x, y, z), angular: glam::DVec3::new(about_x, about_y, about_z) }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;
    use crate::id::WorldTag;
    use crate::solve::direct::factor::Plan;
    use crate::solve::direct::guard::Guard;
    use crate::solve::direct::noise::Noise;
    use crate::solve::direct::project::Errors;
    use crate::solve::direct::system::{Coupling, Node};
    use crate::solve::state::{BodyMotion, MotionKind};

    fn vector(noise: &mut Noise) -> DVec3 {
        DVec3::new(noise.next(), noise.next(), noise.next())
    }

    /// A chain of six bodies with random rows, of which some take no part.
    fn articulation(noise: &mut Noise) -> Articulation {
        const COUNTS: [u32; 5] = [3, 7, 5, 1, 6];
        let mut own = Articulation::default();
        for slot in 0..6 {
            let motion = BodyMotion { kind: MotionKind::Tumbling, ..BodyMotion::FIXED };
            let mut body = DirectBody::new(slot, &BodyVelocity::FIXED, &motion);
            body.inverse_mass = DVec3::splat(0.6 + noise.next());
            body.inverse_inertia = DMat3::from_diagonal(DVec3::splat(0.7) + 0.5 * vector(noise));
            own.bodies.push(body);
            own.rates.push(Rate { linear: vector(noise), angular: vector(noise) });
        }
        for (number, count) in (0..).zip(COUNTS) {
            let first = own.system.rows.len() as u32;
            for _ in 0..count {
                let state = if noise.next() < -0.3 { State::Absent } else { State::Free };
                let (linear, angular) = ([vector(noise), vector(noise)], [vector(noise), vector(noise)]);
                own.system.rows.push(Row { linear, angular, bias: noise.next(), gamma: 0.01, state, ..Row::EMPTY });
            }
            own.system.nodes.push(Node { bodies: [number, number + 1], first, last: own.system.rows.len() as u32 });
        }
        let plan = Plan::new(&COUNTS, &COUNTS, &[(0, 1), (1, 2), (2, 3), (3, 4)], u64::MAX).expect("no limit is set");
        let coupling = |a: u32| {
            let (start, b_is_late) = plan.block(a, a + 1).expect("neighbours are coupled");
            let (late, early) = if b_is_late { (a + 1, a) } else { (a, a + 1) };
            let side = |node: u32| u8::from(node == a);
            Coupling { late, early, late_side: side(late), early_side: side(early), body: a + 1, start }
        };
        let couplings = (0..4).map(coupling).collect();
        own.topology = Topology { plan, couplings, guards: Guard::all(0), loops: 0, doubled: false };
        own.system.begin(&own.bodies);
        own
    }

    #[test]
    fn each_lane_is_solved_as_its_member_is_alone() {
        let mut noise = Noise(5);
        let mut members: Vec<Articulation> = (0..3).map(|_| articulation(&mut noise)).collect();
        let mut group = Lockstep { members: vec![0, 1, 2], ..Lockstep::default() };
        let lanes = [true, true, false, false];
        group.take_in(&mut members[..], lanes);
        for (lane, own) in members.iter().enumerate() {
            for (into, rate) in group.abreast.rates.iter_mut().zip(&own.rates) {
                let numbers = rate.linear.to_array().into_iter().chain(rate.angular.to_array());
                into.iter_mut().zip(numbers).for_each(|(into, number)| into[lane] = number);
            }
        }
        let before: Vec<Rate> = group.abreast.rates.iter().map(|rate| rate_of(rate, 2)).collect();
        group.solve(&members[..], lanes);
        assert!(!group.is_exact[2], "who has not been solved is not known to need no refinement");
        for (lane, own) in members.iter_mut().enumerate().take(2) {
            own.system.solve(&own.topology, &own.bodies, &mut own.rates, PASSES);
            let impulses: Vec<f64> = own.system.rows.iter().map(|row| row.impulse).collect();
            group.give_impulses(lane, &mut own.system);
            for (row, impulse) in own.system.rows.iter().zip(impulses) {
                assert!((row.impulse - impulse).abs() < 1e-10, "a multiplier of lane {lane} is {} alone {impulse}", row.impulse);
            }
            for (body, rate) in own.rates.iter().enumerate() {
                let beside = rate_of(&group.abreast.rates[body], lane);
                let apart = (beside.linear - rate.linear).length().max((beside.angular - rate.angular).length());
                assert!(apart < 1e-10, "body {body} of lane {lane} is {apart:e} from what it does alone");
            }
        }
        let after = group.abreast.rates.iter().map(|rate| rate_of(rate, 2));
        assert!(after.zip(&before).all(|(after, before)| (after.linear, after.angular) == (before.linear, before.angular)));
    }

    #[test]
    fn joints_yield_to_pushes_beside_others_as_they_do_alone() {
        let mut noise = Noise(7);
        let mut members: Vec<Articulation> = (0..3).map(|_| articulation(&mut noise)).collect();
        let mut pushes = Vec::new();
        for (number, own) in (0..).zip(&mut members) {
            own.built.resize(own.bodies.len(), glam::Vec3::ZERO);
            own.system.rows.iter_mut().for_each(|row| row.gamma = 0.0);
            for body in &mut own.bodies {
                body.slot += 6 * number;
                let (linear, angular) = match number {
                    2 => Default::default(),
                    _ => (vector(&mut noise).as_vec3(), vector(&mut noise).as_vec3()),
                };
                pushes.push(BodyVelocity { linear, angular, ..BodyVelocity::FIXED });
            }
        }
        let asked = pushes.clone();
        let mut group = Lockstep { members: vec![0, 1, 2], ..Lockstep::default() };
        group.take_in(&mut members[..], [true; ABREAST]);
        group.yield_to(&mut members[..], &mut pushes[..]);
        for own in &mut members {
            let rates = |pushes: &[BodyVelocity]| -> Vec<Rate> {
                own.bodies.iter().map(|body| Rate::of(&pushes[body.slot as usize])).collect()
            };
            let (before, after) = (rates(&asked), rates(&pushes));
            let weighed = |a: &[Rate], b: &[Rate]| -> f64 {
                let of = |body: &DirectBody, a: &Rate, b: &Rate| {
                    a.linear.dot(b.linear / body.inverse_mass) + a.angular.dot(body.inverse_inertia.inverse() * b.angular)
                };
                own.bodies.iter().zip(a).zip(b).map(|((body, a), b)| of(body, a, b)).sum()
            };
            let change = |(a, b): (&Rate, &Rate)| Rate { linear: a.linear - b.linear, angular: a.angular - b.angular };
            let change: Vec<Rate> = before.iter().zip(&after).map(change).collect();
            let apart = weighed(&before, &before) - weighed(&after, &after) - weighed(&change, &change);
            assert!(apart.abs() < 1e-4, "the change is not the least in the metric of the masses: {apart:e}");
            for node in &own.system.nodes {
                let pair = node.bodies.map(|body| after[body as usize]);
                for row in own.system.rows[node.first as usize..node.last as usize].iter().filter(|row| row.state == State::Free)
                {
                    assert!(row.rate(&pair).abs() < 1e-5, "a joint opens by {}", row.rate(&pair));
                }
            }
            let mut alone = asked.clone();
            own.system.is_abreast = false;
            own.system.is_factored = false;
            own.system.solve(&own.topology, &own.bodies, &mut own.rates, PASSES);
            own.yield_to(&mut alone[..]);
            for body in &own.bodies {
                let (beside, alone) = (pushes[body.slot as usize], alone[body.slot as usize]);
                let apart = (beside.linear - alone.linear).length().max((beside.angular - alone.angular).length());
                assert!(apart < 1e-6, "body {} is pushed {apart:e} from what it is alone", body.slot);
            }
        }
    }

    #[test]
    fn who_mends_positions_between_substeps_leaves_others_their_multipliers() {
        let mut noise = Noise(6);
        let mut members: Vec<Articulation> = (0..2).map(|_| articulation(&mut noise)).collect();
        let mut group = Lockstep { members: vec![0, 1], ..Lockstep::default() };
        let lanes = [true, true, false, false];
        group.take_in(&mut members[..], lanes);
        group.solve(&members[..], lanes);
        let carried = |group: &Lockstep| -> Vec<f64> { group.abreast.impulse.iter().map(|impulse| impulse[1]).collect() };
        let before = carried(&group);
        let tag = WorldTag::acquire().expect("a test has few worlds");
        let mut settling = [Some(Settling { errors: Errors { worst: 1.0, ..Errors::NONE }, mends: true }), None, None, None];
        group.mend(&mut members[..], &Pool::new(&tag), &mut settling, false);
        assert!(settling[0].is_some_and(|settling| !settling.mends && settling.errors.worst < 1.0), "{settling:?}");
        assert!(before.iter().any(|&impulse| impulse != 0.0));
        assert_eq!(carried(&group), before, "multipliers of the one beside it");
    }
}
