//! Newton's method on the joint manifold, in an augmented Lagrangian of what acts within bounds.
//!
//! A step solves joints and all terms, each linearised where its y is,
//!
//! ```text
//! [ M̂ + Σ J_cᵀ (G/R) J_c    J_jᵀ ] [  d ]   [ −(M̂ v − drive − Σ J_cᵀ γ) ]
//! [ J_j                      −ε  ] [ −λ ] = [ −b − J_j v + ε λ̄           ]
//! ```
//!
//! * The first step of a pass takes each y where the last pass left it, or the last substep, not at v: what stands or slides as it did needs no
//!   second one. At v, what has lost more than half of its load since the last λ̄ would count as open.
//! * Later steps go as far along d as the objective falls, found on its derivative.
//! * A step is the last where the true P and its linear model agree; then λ̄ ← λ, ρ ← μ λ_n (by secants where that swings), R by its rule, and once more until λ̄ and ρ
//!   stay what they are.
//!
//! What does not come to an end within the budget is settled by a few iterations of ADMM from the carried impulses
//! ([`admm`](super::admm)), which degrade gracefully.

use super::factor::Vector;
use super::problem::{Problem, push_term, rate, speed};
use super::term::{Law, Term, length};

/// R over J M⁻¹ Jᵀ, at most; and R over 1/λ̄ (m/s): a term that bears much is stiffer, so that what a bristle yields stays small. Tried from
/// 1e-2 to 1e-6; at 1e-2 an arch sinks by 4 mm as its lamp swings, at 1e-8 a winch and an arch blow up.
const COMPLIANCE: f64 = 1.0e-4;
const YIELD: f64 = 1.0e-3;
const MIN_COMPLIANCE: f64 = 1.0e-9;

/// Outer passes of one substep.
const OUTER_PASSES: usize = 6;

/// Factorisations after which a substep ends where it is. Of a blow of tonnes through links of a fifth of a kilogram as a rope goes taut on
/// its post nothing was found with 12 and 20, and the substeps after it, begun from nothing, found nothing either; with 40 and 80 it
/// comes to rest.
pub(super) const MAX_FACTORS: u32 = 40;

/// Error of the linear model, and length of a step, below which a step is the last (m/s).
const MODEL_ERROR: f64 = 1.0e-5;
const MIN_STEP: f64 = 1.0e-6;

/// Change of λ̄ over R below which no further outer pass is needed (m/s); and change of a bound that presses, in the first pass and later.
const SETTLED: f64 = 1.0e-3;
const BOUND_CHANGE: [f64; 2] = [0.1, 0.33];

/// Slope at the end of a step, over that at its beginning, from which on the step is shortened, and to which.
const STEEP: f64 = 1.0e-2;

/// Iterations of ADMM before a cold start and out of budget.
const COLD_ITERATIONS: usize = 10;
const FALLBACK_ITERATIONS: usize = 20;

/// How a solve went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Effort {
    pub factors: u32,
    /// Whether it ran out of its budget.
    pub is_capped: bool,
}

impl Effort {
    pub(crate) fn add(&mut self, other: Self) {
        self.factors += other.factors;
        self.is_capped |= other.is_capped;
    }
}

impl Term {
    /// R by its rule.
    fn choose_compliance(&mut self) {
        if self.give > 0.0 {
            (self.compliance, self.expected) = (self.give, [0.0; 2]);
            return;
        }
        let size = self.size();
        let by_load = if size > 0.0 { YIELD / size } else { f64::INFINITY };
        self.compliance = (COMPLIANCE * self.ease).min(by_load).max(MIN_COMPLIANCE * self.ease);
    }

    /// Takes another compliance. What is at a bound is as far beyond it as its compliance says.
    fn change_compliance(&mut self, compliance: f64) {
        let (y, p, scale) = (self.argument, self.impulse, self.compliance / compliance);
        self.argument = [0, 1].map(|i| p[i] + (y[i] - p[i]) * scale);
        self.compliance = compliance;
    }

    /// Whether nothing tells that it has pressed, although it is going to; `free` is its speed without any push.
    fn is_cold(&self, free: [f64; 2]) -> bool {
        !self.is_known && matches!(self.law, Law::Between(0.0, _)) && self.give == 0.0 && self.expected[0] <= 0.0 && free[0] < 0.0
    }
}

impl Problem {
    /// Finds the velocity, λ of all links and terms, and leaves a factor for the positions. `budget` bounds the factorisations.
    pub(crate) fn solve(&mut self, budget: u32) -> Effort {
        self.find_radii();
        self.terms.iter_mut().for_each(Term::choose_compliance);
        let mut effort = Effort::default();
        if self.terms.iter().any(|term| term.is_cold(with_bias(term, speed(term, &self.free)))) && budget > 1 {
            self.find_start();
            effort.factors += 1;
        } else {
            self.guess_arguments();
        }
        effort.add(self.iterate(budget.saturating_sub(effort.factors).min(MAX_FACTORS)));
        effort
    }

    /// Solves once more from where the last solve has ended, after the stiffness has changed.
    pub(crate) fn solve_again(&mut self, budget: u32) -> Effort {
        self.find_drive();
        self.iterate(budget.min(MAX_FACTORS))
    }

    /// Bounds of friction from the impulses expected of what it leans on.
    pub(super) fn find_radii(&mut self) {
        for number in 0..self.terms.len() {
            if let Law::Leaning { first, count, share } = self.terms[number].law {
                let pressing: f64 = self.normals(first, count).map(|term| term.hit + term.expected[0].max(0.0)).sum();
                self.terms[number].radius = share * pressing;
            }
        }
    }

    pub(super) fn normals(&self, first: u32, count: u32) -> impl Iterator<Item = &Term> {
        self.terms[first as usize..(first + count) as usize].iter()
    }

    /// Says where terms are linearised first of which that is not known: from what they are expected to do, and how fast bodies are.
    fn guess_arguments(&mut self) {
        let Self { terms, before, free, .. } = self;
        for term in terms.iter_mut().filter(|term| !term.is_known) {
            let (was, is) = (with_bias(term, speed(term, before)), with_bias(term, speed(term, free)));
            term.argument = if term.give > 0.0 {
                term.argument_at(is)
            } else if matches!(term.law, Law::Between(0.0, _)) {
                if term.expected[0] > 0.0 { term.expected } else { [-is[0] / term.ease, 0.0] }
            } else if term.is_at_bound() {
                term.argument_at(was)
            } else {
                term.expected
            };
        }
    }

    /// Finds where to begin by ADMM.
    fn find_start(&mut self) {
        copy(&self.terms, &mut self.room.warm_terms);
        copy(&self.before, &mut self.velocity);
        self.admm(COLD_ITERATIONS);
        let Self { terms, room, before, velocity, .. } = self;
        copy(before, velocity);
        for (term, warm) in terms.iter_mut().zip(&room.warm_terms) {
            if warm.is_known {
                (term.argument, term.compliance, term.expected) = (warm.argument, warm.compliance, warm.expected);
                continue;
            }
            term.change_compliance(warm.compliance);
            term.expected = warm.expected;
        }
    }

    fn iterate(&mut self, budget: u32) -> Effort {
        let mut effort = Effort::default();
        copy(&self.terms, &mut self.room.warm_terms);
        Self::save_impulses(&self.links, &mut self.room.warm_impulses);
        copy(&self.before, &mut self.velocity);
        let mut has_saved = false;
        for pass in 0..OUTER_PASSES {
            let mut is_found = false;
            let mut is_first = true;
            while effort.factors < budget {
                self.linearize(is_first);
                self.find_step();
                effort.factors += 1;
                // What is no number compares as no error: it would end the solve.
                if !self.unknowns.iter().flatten().all(|value| value.is_finite()) {
                    break;
                }
                let ends = self.take_step(is_first);
                is_first = false;
                if ends {
                    is_found = true;
                    break;
                }
            }
            if !is_found {
                effort.is_capped = true;
                if has_saved {
                    self.restore();
                } else {
                    self.fall_back();
                }
                return effort;
            }
            if self.settle(pass) {
                break;
            }
            self.save();
            has_saved = true;
        }
        effort
    }

    /// Takes P and G of all terms: at the arguments they have, brought to the velocity by the linear model, or at the velocity.
    fn linearize(&mut self, at_argument: bool) {
        self.find_speeds();
        for term in &mut self.terms {
            let now = term.argument_at(term.speed);
            if at_argument {
                let stored = term.argument;
                term.linearize(stored);
                let more = term.gained([now[0] - stored[0], now[1] - stored[1]]);
                term.impulse = [term.impulse[0] + more[0], term.impulse[1] + more[1]];
            } else {
                term.linearize(now);
            }
            term.argument = now;
        }
    }

    /// Solves for the step, into the unknowns, and for the links' multipliers.
    fn find_step(&mut self) {
        let mut gradient = std::mem::take(&mut self.room.gradient);
        self.times(&self.velocity, &mut gradient);
        for (gradient, drive) in gradient.iter_mut().zip(&self.drive) {
            gradient.iter_mut().zip(drive).for_each(|(entry, drive)| *entry = drive - *entry);
        }
        for term in &self.terms {
            push_term(term, term.impulse, &mut gradient);
        }
        self.factorize();
        let Self { unknowns, links, velocity, .. } = self;
        unknowns.clear();
        unknowns.extend_from_slice(&gradient);
        Self::ask_links(links, Some(velocity), unknowns);
        self.room.gradient = gradient;
        self.solve_unknowns();
        self.keep_links();
    }

    /// Goes along the step; whether it was the last.
    fn take_step(&mut self, is_full: bool) -> bool {
        let bodies = self.masses.len();
        let Self { terms, unknowns, room, .. } = self;
        room.step_speeds.clear();
        room.step_speeds.extend(terms.iter().map(|term| speed(term, unknowns)));
        let share = if is_full { 1.0 } else { self.search() };
        let Self { terms, unknowns, velocity, room, .. } = self;
        for (velocity, step) in velocity.iter_mut().zip(&unknowns[..bodies]) {
            velocity.iter_mut().zip(step).for_each(|(entry, step)| *entry += share * step);
        }
        let (mut error, mut longest) = (0.0_f64, 0.0_f64);
        for (term, step) in terms.iter().zip(&room.step_speeds) {
            let change = step.map(|step| -share * step / term.compliance);
            let found = term.project([term.argument[0] + change[0], term.argument[1] + change[1]]);
            let more = term.gained(change);
            for row in 0..term.rows {
                error = error.max((found[row] - term.impulse[row] - more[row]).abs() * term.ease);
                longest = longest.max(step[row].abs());
            }
        }
        // Written so that what is no number never ends it.
        (share == 1.0 && error < MODEL_ERROR) || (!is_full && longest < MIN_STEP)
    }

    /// How far to go along the step: where the slope of the objective along it is next to nothing, all of it if that is not before.
    fn search(&mut self) -> f64 {
        let bodies = self.masses.len();
        let mut product = std::mem::take(&mut self.room.product);
        let steps = &self.unknowns[..bodies];
        self.times(steps, &mut product);
        let along = |values: &[Vector]| -> f64 { values.iter().zip(steps).map(|(a, b)| super::factor::dot(a, b)).sum() };
        let curvature = along(&product);
        self.times(&self.velocity, &mut product);
        for (product, drive) in product.iter_mut().zip(&self.drive) {
            product.iter_mut().zip(drive).for_each(|(entry, drive)| *entry -= drive);
        }
        let start = along(&product);
        self.room.product = product;
        let [start, curvature] = self.with_springs([start, curvature]);
        let Self { terms, room, .. } = self;
        let slope = |share: f64| {
            let terms = terms.iter().zip(&room.step_speeds);
            terms.fold(start + share * curvature, |slope, (term, step)| {
                let y = [0, 1].map(|i| term.argument[i] - share * step[i] / term.compliance);
                let found = term.project(y);
                slope - found[0] * step[0] - found[1] * step[1]
            })
        };
        let (first, last) = (slope(0.0), slope(1.0));
        if first < 0.0 && last > STEEP * first.abs() { zero_of(slope, first, last) } else { 1.0 }
    }

    /// Slope and curvature of the objective along the step, with those of rows of joints that give, whose part of it is ½ (J v + b)²/γ: rows that
    /// do not are as far from what they ask for anywhere along it.
    fn with_springs(&self, of_bodies: [f64; 2]) -> [f64; 2] {
        let mut sums = of_bodies;
        for link in &self.links {
            for row in (0..link.rows).filter(|&row| link.give[row] > 0.0) {
                let jacobian = [&link.jacobian[0][row], &link.jacobian[1][row]];
                let step = rate(link.bodies, jacobian, &self.unknowns);
                let error = rate(link.bodies, jacobian, &self.velocity) + link.bias[row];
                sums = [sums[0] + error * step / link.give[row], sums[1] + step * step / link.give[row]];
            }
        }
        sums
    }

    /// Takes the impulses that have been found as those expected; whether nothing has changed by much.
    fn settle(&mut self, pass: usize) -> bool {
        self.find_speeds();
        for term in &mut self.terms {
            term.argument = term.argument_at(term.speed);
            term.impulse = term.project(term.argument);
        }
        if pass == 0 {
            self.room.bounds.clear();
            self.room.bounds.reserve(self.terms.capacity());
            self.room.bounds.resize(self.terms.len(), [0.0; 2]);
        }
        let most = BOUND_CHANGE[pass.min(1)];
        let mut is_settled = true;
        for number in 0..self.terms.len() {
            if let Law::Leaning { first, count, share } = self.terms[number].law {
                let pressing: f64 = self.normals(first, count).map(|term| term.hit + term.impulse[0]).sum();
                let (term, radius) = (&mut self.terms[number], share * pressing);
                let matters = length(term.argument) > 0.999 * term.radius || length(term.impulse) > radius;
                let greater = radius.max(term.radius);
                let changed = (radius - term.radius).abs() > most * greater && greater * term.ease > SETTLED;
                is_settled &= !(matters && changed);
                let last = std::mem::replace(&mut self.room.bounds[number], [term.radius, radius]);
                term.radius = if pass == 0 { radius } else { next_bound(last, [term.radius, radius]) };
            }
        }
        for term in &mut self.terms {
            let change = length([term.impulse[0] - term.expected[0], term.impulse[1] - term.expected[1]]);
            is_settled &= term.give > 0.0 || change * term.compliance < SETTLED;
            term.expected = if term.give > 0.0 { [0.0; 2] } else { term.impulse };
        }
        if !is_settled {
            // Positions are corrected with the factor of the last pass, whose compliances these are.
            for term in &mut self.terms {
                let before = term.compliance;
                term.choose_compliance();
                let chosen = std::mem::replace(&mut term.compliance, before);
                term.change_compliance(chosen);
            }
        }
        is_settled
    }

    fn save(&mut self) {
        let Self { room, velocity, terms, links, .. } = self;
        copy(velocity, &mut room.saved_velocity);
        copy(terms, &mut room.saved_terms);
        Self::save_impulses(links, &mut room.saved_impulses);
        self.is_stale = true;
    }

    /// Goes back to the last pass that has come to an end.
    fn restore(&mut self) {
        let Self { room, velocity, terms, links, .. } = self;
        copy(&room.saved_velocity, velocity);
        copy(&room.saved_terms, terms);
        Self::restore_impulses(links, &room.saved_impulses);
        self.is_stale = true;
    }

    /// Ends a solve that is out of budget by ADMM from the carried impulses.
    fn fall_back(&mut self) {
        let Self { room, velocity, before, terms, links, .. } = self;
        copy(before, velocity);
        copy(&room.warm_terms, terms);
        Self::restore_impulses(links, &room.warm_impulses);
        self.find_radii();
        self.admm(FALLBACK_ITERATIONS);
        for term in &mut self.terms {
            term.expected = term.impulse;
            term.choose_compliance();
            let y = term.argument;
            term.linearize(y);
            term.impulse = term.expected;
        }
        self.is_stale = true;
    }
}

/// Bound of friction for the next pass, of those of the last two, each with what has been found to press with it. Where a greater bound lets less
/// press, as between bodies that are wedged, passes would go to and fro between two bounds for ever: the next is where both would meet if
/// that went on in proportion (the secant method). Else it is what has been found.
fn next_bound([before, found_before]: [f64; 2], [bound, found]: [f64; 2]) -> f64 {
    let slope = (found - found_before) / (bound - before);
    if slope < 0.0 { bound + (found - bound) / (1.0 - slope) } else { found }
}

/// The zero of a function that rises, between 0 and 1, where it is `low` < 0 and `high` > 0: regula falsi as Illinois has it, with a halving
/// every fourth time.
fn zero_of(slope: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let first = low;
    let (mut from, mut to, mut side) = (0.0, 1.0, 0);
    for number in 0..30 {
        let share = if number % 4 == 3 { 0.5 * (from + to) } else { (from * high - to * low) / (high - low) };
        let found = slope(share);
        if found.abs() < STEEP * first.abs() {
            return share;
        }
        if found < 0.0 {
            (from, low) = (share, found);
            if side == -1 {
                high *= 0.5;
            }
            side = -1;
        } else {
            (to, high) = (share, found);
            if side == 1 {
                low *= 0.5;
            }
            side = 1;
        }
    }
    0.5 * (from + to)
}

/// Copies a list into another, which gets room for all that the first has room for: what grows by one now and then takes no memory.
pub(super) fn copy<T: Copy>(from: &Vec<T>, to: &mut Vec<T>) {
    to.clear();
    to.reserve(from.capacity());
    to.extend_from_slice(from);
}

pub(super) fn with_bias(term: &Term, speed: [f64; 2]) -> [f64; 2] {
    [speed[0] + term.bias[0], speed[1] + term.bias[1]]
}
