//! Newton's method on the contacts of small islands in which heavier bodies stand on lighter ones, or bodies strike one another.
//!
//! A sweep passes a load on by one contact at a time, and a light body under a heavy one takes as many sweeps as the ratio of their
//! masses: at 1:10,000 a stack of ten still leans 7 % too fast after 64 substeps of 16 sweeps. A blow on what lies on something else is
//! passed on as slowly, and its multipliers are no forces to carry on: a ball that fell on a lying plate of its own mass went up again at a
//! quarter of its speed. Here all rows of the island are solved at once for the velocities v that are least in
//!
//! ½ |v − v₀|² in the metric of mass, plus λ₀ᵀJ v, plus what [`rows`] answer,
//!
//! a convex function: Newton's method on it, each step one Cholesky factor of M + Jᵀ D J within its [`envelope`], and an exact search
//! along the step. A few times over, each time stiffer, from the multipliers that the last one found and under friction limits of
//! their loads, until the rows' rates say that compliance no longer shows.
//!
//! It comes before the sweeps of a substep, which then find nothing to do; it changes nothing if it did not converge or would leave
//! more kinetic energy than the bodies had before any contact acted. What carries nothing heavier is solved in substeps with a blow alone. From
//! such a substep contacts carry on what would hold the bodies in the next, which is found in the same way. [`overlaps`] takes overlaps out so.

#![expect(clippy::needless_range_loop, reason = "an index runs over rows of several arrays alike")]

pub(super) mod choose;
mod envelope;
mod overlaps;
mod rows;

use glam::DVec3;

use super::batch::Batch;
use super::contact_block::ContactBlocks;
use super::state::BodyVelocity;
use crate::tuning::blows::ALIKE;
use envelope::Envelope;
use rows::{ExactBody, FIXED, NewtonContact, ROWS, Six, add_product, dot};

/// Compliance of a row over J M⁻¹ Jᵀ in the first round, and by what it falls from round to round. Rows that are stiff from the start
/// are in each other's way: each step then ends at the first contact that opens or closes.
const FIRST_COMPLIANCE: f64 = 1.0e-2;
const STIFFENING: f64 = 0.03;

/// Least compliance of a row over J M⁻¹ Jᵀ, times the ratio of the heaviest body's mass to the lightest's.
const COMPLIANCE: f64 = 1.0e-3;

/// Rate that a row may be wrong by, over what gravity adds to a speed in a substep, and from which the sweeps are helped, over that.
const TOLERANCE: f64 = 1.0e-3;
const NOTICEABLE: f64 = 10.0;

/// Rate that a row may be wrong by after a blow, over the speed from which on bodies strike: a tenth of what gravity makes of a speed in a substep.
/// What loads of friction may be off by, over the speed of the blow.
const BLOW_SHARE: f64 = 0.05;

/// Last step of Newton's method, over the tolerance.
const STEP_TOLERANCE: f64 = 0.1;

/// Slope along a step, over that at its beginning, at which the search along it ends, and halvings that it may take.
const SLOPE_SHARE: f64 = 1.0e-2;
const MAX_HALVINGS: usize = 30;

/// Newton steps of a substep, in all rounds; an island that needs more is left to the sweeps for the rest of the step.
const MAX_STEPS: u32 = 64;

/// The islands of a batch that are solved here, and buffers.
#[derive(Debug, Default)]
pub(crate) struct ContactNewton {
    islands: Vec<ContactIsland>,
    bodies: Vec<ExactBody>,
    contacts: Vec<NewtonContact>,
    /// Body of each slot, or none.
    local: Vec<u32>,
    first: Vec<u32>,
    above: Vec<f64>,
    matrix: Envelope,
    start: Vec<Six>,
    free: Vec<Six>,
    now: Vec<Six>,
    step: Vec<Six>,
    gradient: Vec<f64>,
    /// Rates of each contact's rows, and what a step adds to them.
    rates: Vec<[f64; ROWS]>,
    along: Vec<[f64; ROWS]>,
    /// Rate that a row may be wrong by (m/s, rad/s), and that at which bodies strike (m/s).
    tolerance: f64,
    blow: f64,
}

/// Its bodies and contacts, as places in the lists.
#[derive(Debug, Clone, Copy)]
struct ContactIsland {
    bodies: (u32, u32),
    contacts: (u32, u32),
    /// Least compliance of its rows over J M⁻¹ Jᵀ.
    compliance: f64,
    gave_up: bool,
    /// Mass of its heaviest body over that of its lightest.
    ratio: f64,
    /// Whether any of its bodies moves fast enough to strike.
    is_fast: bool,
    /// Whether something so much heavier stands on a light body in it that sweeps are too slow: it is solved in every substep.
    is_uneven: bool,
    /// Whether this substep has solved a blow.
    is_struck: bool,
}

impl ContactNewton {
    /// Whether no island of the batch is solved here.
    pub(crate) fn is_idle(&self) -> bool {
        self.islands.is_empty()
    }

    /// Solves what the warm start has left of a substep; velocities and multipliers are exact then.
    pub(crate) fn apply(&mut self, batch: &mut Batch) {
        for number in 0..self.islands.len() {
            let island = self.islands[number];
            if island.gave_up {
                continue;
            }
            self.load(batch, &island);
            let contacts = &self.contacts[island.contacts()];
            let is_off = |contact: &NewtonContact| contact.error(&contact.rates(&self.now)) > NOTICEABLE * self.tolerance;
            // Whatever is carried, it is no blow if nothing would close in without it.
            let closing = closing_speed(contacts, &self.free, self.blow);
            let is_struck = closing > self.blow;
            if !(is_struck || island.is_uneven && contacts.iter().any(is_off)) {
                continue;
            }
            let tolerances = if is_struck { [BLOW_SHARE * self.blow, BLOW_SHARE * closing] } else { [self.tolerance; 2] };
            if self.solve(&island, tolerances) && self.finish(&island) {
                self.store(batch, &island);
                self.islands[number].is_struck = is_struck;
            } else {
                self.islands[number].gave_up = true;
            }
            if self.islands[number].is_struck {
                let Self { contacts, now, .. } = self;
                contacts[island.contacts()].iter_mut().for_each(|contact| contact.look_ahead(&batch.contacts, now));
            }
        }
    }

    /// Ends blows of a substep of length `h` (s), after whatever rebounds: stops what has closed its gap by now and still closes in, and finds
    /// what is to be carried on.
    pub(crate) fn end_blows(&mut self, batch: &mut Batch, h: f32) {
        for number in 0..self.islands.len() {
            let island = self.islands[number];
            if !island.is_struck {
                continue;
            }
            let rebounds = |contact: &NewtonContact| contact.rebounds(&batch.contacts);
            if island.ratio > ALIKE || self.contacts[island.contacts()].iter().any(rebounds) {
                self.stop_rest(batch, &island);
                self.find_loads(batch, &island, h);
            }
        }
    }

    /// Stops what touches and still closes in. It is part of the blow.
    fn stop_rest(&mut self, batch: &mut Batch, island: &ContactIsland) {
        let Self { bodies, contacts, start, free, now, .. } = self;
        start.clear();
        start.extend(bodies[island.bodies()].iter().map(|body| six(&batch.velocities[body.slot as usize])));
        free.clone_from(start);
        now.clone_from(start);
        let tolerance = BLOW_SHARE * self.blow;
        let contacts = contacts[island.contacts()].iter();
        let closing = contacts.fold(0.0_f64, |most, contact| most.max(contact.closing_speed(&contact.rates(now))));
        if closing > tolerance && self.solve(island, [tolerance; 2]) && self.finish(island) {
            self.store_velocities(batch, island);
            self.contacts[island.contacts()].iter().for_each(|contact| contact.add_to(&mut batch.contacts));
        }
    }

    /// Finds the multipliers that hold the bodies in the substep to come, if nothing strikes in it: a blow says nothing of them. They are against
    /// what forces make of velocities alone, since what is left of the blow to within tolerance may be more than that.
    fn find_loads(&mut self, batch: &Batch, island: &ContactIsland, h: f32) {
        let Self { bodies, contacts, start, now, .. } = self;
        let bodies = &bodies[island.bodies()];
        let contacts = &mut contacts[island.contacts()];
        now.clear();
        now.extend(bodies.iter().map(|body| six(&batch.velocities[body.slot as usize])));
        contacts.iter_mut().for_each(NewtonContact::begin_next);
        // What strikes then is solved then, and would be carried on as a load.
        if closing_speed(contacts, now, self.blow) > 0.0 {
            return;
        }
        contacts.iter_mut().for_each(|contact| contact.rest(now));
        start.clear();
        start.extend(bodies.iter().map(|body| {
            let [x, y, z] = (batch.motions[body.slot as usize].acceleration.as_dvec3() * f64::from(h)).to_array();
            [x, y, z, 0.0, 0.0, 0.0]
        }));
        now.clone_from(start);
        if self.solve(island, [BLOW_SHARE * self.blow; 2]) {
            for contact in &mut self.contacts[island.contacts()] {
                let mut lambda = contact.lambda;
                contact.project(&mut lambda, contact.load);
                contact.carried = lambda;
            }
        }
    }

    /// Ends a substep: multipliers of blows are nothing to carry on.
    pub(crate) fn forget_blows(&mut self, contacts: &mut ContactBlocks) {
        for island in &mut self.islands {
            if std::mem::take(&mut island.is_struck) {
                self.contacts[island.contacts()].iter().for_each(|contact| contact.store(&contact.carried, contacts));
            }
        }
    }

    fn load(&mut self, batch: &Batch, island: &ContactIsland) {
        let Self { bodies, contacts, start, free, now, .. } = self;
        start.clear();
        start.extend(bodies[island.bodies()].iter().map(|body| six(&batch.velocities[body.slot as usize])));
        for contact in &mut contacts[island.contacts()] {
            let fixed = [0, 1].map(|side| {
                let is_fixed = contact.bodies[side] == FIXED;
                is_fixed.then(|| six(&batch.velocities[contact.slots[side] as usize]))
            });
            contact.load(&batch.contacts, fixed);
        }
        now.clone_from(start);
        free.clone_from(start);
        let own = &bodies[island.bodies()];
        contacts[island.contacts()].iter().for_each(|contact| contact.push(&contact.warm, -1.0, own, free));
    }

    /// Finds velocities at which all rows are right to within `tolerance` (m/s, rad/s), friction for the loads that it has
    /// to within `of_friction`, and multipliers that give them.
    fn solve(&mut self, island: &ContactIsland, [tolerance, of_friction]: [f64; 2]) -> bool {
        self.shape(island);
        let (mut compliance, mut steps) = (FIRST_COMPLIANCE, MAX_STEPS);
        loop {
            self.contacts[island.contacts()].iter_mut().for_each(|contact| contact.set_compliance(compliance));
            if !self.minimise(island, &mut steps, STEP_TOLERANCE * tolerance) {
                return false;
            }
            let (mut error, mut off) = (0.0_f64, 0.0_f64);
            for (contact, rates) in self.contacts[island.contacts()].iter_mut().zip(&self.rates) {
                let answer = contact.answer(rates);
                for row in 0..contact.rows() {
                    // What compliance lets the row give way by.
                    error = error.max((answer[row] - contact.lambda[row]).abs() * contact.compliance[row]);
                }
                contact.lambda = answer;
                off = off.max(contact.take_new_load() / compliance);
            }
            if error <= tolerance && off <= of_friction {
                return true;
            }
            compliance = (compliance * STIFFENING).max(island.compliance);
        }
    }

    /// Shapes the matrix: each body's rows begin with those of the first body that it touches.
    fn shape(&mut self, island: &ContactIsland) {
        let contacts = &self.contacts[island.contacts()];
        let first = &mut self.first;
        first.clear();
        first.extend(0..island.bodies.1 - island.bodies.0);
        for contact in contacts.iter().filter(|contact| !contact.bodies.contains(&FIXED)) {
            let [a, b] = contact.bodies;
            let late = &mut first[a.max(b) as usize];
            *late = (*late).min(a.min(b));
        }
        self.matrix.shape(first.iter().flat_map(|&first| [6 * first; 6]));
    }

    /// Newton's method from the velocities of now, in no more than so many steps, the last of which moves no row by more than so much (m/s, rad/s);
    /// leaves the rates at its end.
    fn minimise(&mut self, island: &ContactIsland, steps: &mut u32, last_step: f64) -> bool {
        self.find_rates(island);
        while *steps > 0 {
            *steps -= 1;
            self.find_gradient(island);
            self.fill_matrix(island);
            if !self.matrix.factor() {
                return false;
            }
            self.matrix.solve(&mut self.gradient);
            self.step.clear();
            self.step.extend(self.gradient.chunks_exact(6).map(|six| std::array::from_fn(|i| -six[i])));
            let contacts = &self.contacts[island.contacts()];
            self.along.clear();
            self.along.extend(contacts.iter().map(|contact| contact.raw_rates(&self.step)));
            let share = self.best_share(island);
            for (now, step) in self.now.iter_mut().zip(&self.step) {
                now.iter_mut().zip(step).for_each(|(speed, step)| *speed += share * step);
            }
            self.find_rates(island);
            let moved = self.along.iter().flatten().fold(0.0_f64, |most, rate| most.max(rate.abs()));
            if moved <= last_step {
                return true;
            }
        }
        false
    }

    fn find_rates(&mut self, island: &ContactIsland) {
        self.rates.clear();
        self.rates.extend(self.contacts[island.contacts()].iter().map(|contact| contact.rates(&self.now)));
    }

    /// M (v − v₀) − Jᵀ (λ(v) − λ₀).
    fn find_gradient(&mut self, island: &ContactIsland) {
        let Self { bodies, contacts, start, now, gradient, rates, .. } = self;
        gradient.clear();
        for ((body, now), start) in bodies[island.bodies()].iter().zip(&*now).zip(&*start) {
            gradient.extend(body.momentum(&std::array::from_fn(|i| now[i] - start[i])));
        }
        for (contact, rates) in contacts[island.contacts()].iter().zip(rates) {
            let answer = contact.answer(rates);
            for (side, &body) in contact.bodies.iter().enumerate().filter(|(_, body)| **body != FIXED) {
                let place = &mut gradient[6 * body as usize..][..6];
                for row in 0..contact.rows() {
                    let change = answer[row] - contact.warm[row];
                    place.iter_mut().zip(contact.jacobian[row][side]).for_each(|(sum, entry)| *sum -= entry * change);
                }
            }
        }
    }

    /// M + Jᵀ D J.
    fn fill_matrix(&mut self, island: &ContactIsland) {
        let Self { bodies, contacts, matrix, rates, .. } = self;
        matrix.clear();
        for (number, body) in bodies[island.bodies()].iter().enumerate() {
            let mut block = [[0.0; 6]; 6];
            for i in 0..3 {
                block[i][i] = body.mass;
                for j in 0..3 {
                    block[3 + i][3 + j] = body.inertia.col(j)[i];
                }
            }
            matrix.add_block(number, number, &block);
        }
        for (contact, rates) in contacts[island.contacts()].iter().zip(rates) {
            let [a, b] = contact.bodies;
            let mut blocks = [[[0.0; 6]; 6]; 3];
            contact.stiffness(rates, |[row_a, row_b], weight| {
                let [at_a, at_b, between] = &mut blocks;
                add_product(at_a, row_a, row_a, weight);
                add_product(at_b, row_b, row_b, weight);
                let (late, early) = if a > b { (row_a, row_b) } else { (row_b, row_a) };
                add_product(between, late, early, weight);
            });
            for (body, block) in [a, b].into_iter().zip(&blocks).filter(|(body, _)| *body != FIXED) {
                matrix.add_block(body as usize, body as usize, block);
            }
            if a != FIXED && b != FIXED {
                matrix.add_block(a.max(b) as usize, a.min(b) as usize, &blocks[2]);
            }
        }
    }

    /// Share of the step at which the function is least: its slope along it only rises.
    fn best_share(&self, island: &ContactIsland) -> f64 {
        let Self { bodies, contacts, start, now, step, rates, along, .. } = self;
        let (mut slope_of_mass, mut curvature) = (0.0, 0.0);
        for ((body, step), (now, start)) in bodies[island.bodies()].iter().zip(step).zip(now.iter().zip(start)) {
            let momentum = body.momentum(step);
            slope_of_mass += dot(&momentum, &std::array::from_fn(|i| now[i] - start[i]));
            curvature += dot(&momentum, step);
        }
        let slope = |share: f64| {
            let mut sum = slope_of_mass + share * curvature;
            for (contact, (rates, along)) in contacts[island.contacts()].iter().zip(rates.iter().zip(along)) {
                let answer = contact.answer(&std::array::from_fn(|row| rates[row] + share * along[row]));
                sum -= (0..contact.rows()).map(|row| along[row] * (answer[row] - contact.warm[row])).sum::<f64>();
            }
            sum
        };
        let flat = SLOPE_SHARE * slope(0.0).abs();
        if slope(1.0) <= flat {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..MAX_HALVINGS {
            let middle = 0.5 * (low + high);
            let at_middle = slope(middle);
            if at_middle.abs() <= flat {
                return middle;
            }
            if at_middle > 0.0 { high = middle } else { low = middle }
        }
        low
    }

    /// Cuts friction to the loads that were found, and forms the velocities that the multipliers give; false if that would leave
    /// more kinetic energy than there was before any contact acted.
    fn finish(&mut self, island: &ContactIsland) -> bool {
        let Self { bodies, contacts, free, now, .. } = self;
        let bodies = &bodies[island.bodies()];
        now.clone_from(free);
        for contact in &mut contacts[island.contacts()] {
            let mut lambda = contact.lambda;
            contact.project(&mut lambda, contact.load);
            contact.lambda = lambda;
            contact.push(&contact.lambda, 1.0, bodies, now);
        }
        let energy = |velocities: &[Six]| {
            let own = |(body, velocity): (&ExactBody, &Six)| 0.5 * dot(velocity, &body.momentum(velocity));
            bodies.iter().zip(velocities).map(own).sum::<f64>()
        };
        // What moves by itself does work.
        let is_driven = contacts[island.contacts()].iter().any(|contact| contact.is_driven);
        now.iter().flatten().all(|number| number.is_finite()) && (is_driven || energy(now) <= energy(free))
    }

    fn store(&self, batch: &mut Batch, island: &ContactIsland) {
        self.store_velocities(batch, island);
        self.contacts[island.contacts()].iter().for_each(|contact| contact.store(&contact.lambda, &mut batch.contacts));
    }

    fn store_velocities(&self, batch: &mut Batch, island: &ContactIsland) {
        for (body, now) in self.bodies[island.bodies()].iter().zip(&self.now) {
            set(&mut batch.velocities[body.slot as usize], now);
        }
    }
}

impl ContactIsland {
    fn bodies(&self) -> std::ops::Range<usize> {
        self.bodies.0 as usize..self.bodies.1 as usize
    }

    fn contacts(&self) -> std::ops::Range<usize> {
        self.contacts.0 as usize..self.contacts.1 as usize
    }
}

fn six(velocity: &BodyVelocity) -> Six {
    let (v, w) = (velocity.linear.as_dvec3(), velocity.angular.as_dvec3());
    [v.x, v.y, v.z, w.x, w.y, w.z]
}

fn set(velocity: &mut BodyVelocity, &[x, y, z, u, v, w]: &Six) {
    velocity.linear = DVec3::new(x, y, z).as_vec3();
    velocity.angular = DVec3::new(u, v, w).as_vec3();
}

/// Greatest speed at which a contact closes in that passes the blow on, if any does so at more than `blow` (m/s): a sweep stops what strikes
/// one other body alone. What nothing holds gives way.
fn closing_speed(contacts: &[NewtonContact], velocities: &[Six], blow: f64) -> f64 {
    if !contacts.iter().any(|contact| contact.bodies.contains(&FIXED)) {
        return 0.0;
    }
    let passes_on = |contact: &NewtonContact| {
        let shares = |other: &NewtonContact| other.bodies.iter().any(|body| *body != FIXED && contact.bodies.contains(body));
        contacts.iter().filter(|other| shares(other)).count() > 1
    };
    let closing = contacts.iter().map(|contact| (contact, contact.closing_speed(&contact.rates(velocities))));
    closing.filter(|&(contact, closing)| closing > blow && passes_on(contact)).fold(0.0, |most, (_, closing)| closing.max(most))
}
