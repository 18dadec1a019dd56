//! Impacts of an island: what hits with restitution, before the substep in which it hits.
//!
//! Over no time no force acts but those of contacts, of stops and of what joints hold, with the bodies' own masses. Rounds follow one
//! another as long as a contact closes in faster than the threshold:
//!
//! ```text
//! v₀ = P(v),     v ← v₀ + s M̃⁻¹ Jᵀ (e ∘ λ)
//! ```
//!
//! P stops all that closes in so fast, λ are its impulses, and e of them act once more. M̃ holds what joints hold, and the stops that have
//! been pressed. P is a projection in the metric of the masses, so 2P − 1 keeps energy: nothing is lost at e = 1 and nothing ever gained
//! for one e; for several, s ≤ 1 is the largest with no more energy than before, where nothing that moves by itself gives any. A round is
//! for what touches next: a blow goes through a row of balls from one to the other.
//!
//! Last, all that touches is stopped, with friction that leans on what the rounds have pressed as well.
//!
//! What joints do in all this is a load like any other, as what one bears may break it: the multipliers of links and of stops are summed.

use super::problem::{Problem, push_term, speed};
use super::term::{Law, Term};

/// Rounds in an impact at most: a blow passes one contact in each.
const MAX_ROUNDS: usize = 24;

/// Solves of a projection: the second takes out what the bristles of the first have yielded, a thousandth of a metre a second.
const SOLVES: usize = 2;

/// Factorisations of a solve at most.
const MAX_FACTORS: u32 = 40;

impl Term {
    /// Whether it takes part in impacts: a contact's normal or a rigid stop.
    pub(super) fn is_one_sided(&self) -> bool {
        self.rows == 1 && self.give == 0.0 && matches!(self.law, Law::Between(0.0, most) if most == f64::INFINITY)
    }
}

/// What the terms of a substep are in its impact.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    /// Takes none.
    Absent,
    /// Touches, or may be touched, within the substep, and gives back where it is met faster than this (m/s, rad/s): a contact's normal, or
    /// a stop with restitution.
    Hit(f64),
    /// A stop without.
    Stop,
    /// Friction of a contact.
    Friction(Law),
}

impl Part {
    fn is_hit(self) -> bool {
        matches!(self, Self::Hit(_))
    }
}

impl Problem {
    /// Whether something hits in this substep that is to rebound: contacts' terms begin at `first`.
    pub(super) fn strikes(&self, first: usize, threshold: f64) -> bool {
        let hits = |(number, term): (usize, &Term)| {
            term.restitution > 0.0 && self.touches(term) && self.closing(term) > self.least(term, number < first, threshold)
        };
        self.terms.iter().enumerate().any(hits)
    }

    /// Speed above which a term gives back. A stop goes on pressing that would be left more slowly than the forces bring back within a
    /// substep.
    fn least(&self, term: &Term, is_stop: bool, threshold: f64) -> f64 {
        if !is_stop {
            return threshold;
        }
        let gained = speed(term, &self.before)[0] - speed(term, &self.free)[0];
        gained.max(0.0) / term.restitution
    }

    /// Whether a one-sided term is closed within the substep: it pressed in the last one, or forces close it. Those of the bodies alone do not
    /// say it of what rests, as a door on its stop hangs on its hinge, and the light end of a lever is pressed up.
    fn touches(&self, term: &Term) -> bool {
        term.is_one_sided() && (term.impulse_now() > 0.0 || speed(term, &self.free)[0] + term.bias[0] <= 0.0)
    }

    /// Speed at which a term closes in at the start of the substep.
    fn closing(&self, term: &Term) -> f64 {
        -(speed(term, &self.before)[0] + term.bias[0] - term.ahead)
    }

    /// Solves the impact: the velocity is what it leaves, λ of contacts' normals and of stops what they have been hit with, and that of links is
    /// in `blows` of the room. The problem is no longer that of the substep.
    pub(super) fn strike(&mut self, first: usize, threshold: f64) {
        let parts = self.take_parts(first, threshold);
        self.aim(&parts);
        self.room.blows.clear();
        self.room.blows.resize(self.links.len(), [0.0; 6]);
        self.velocity.clone_from(&self.before);
        for _ in 0..MAX_ROUNDS {
            let mut any = false;
            self.before.clone_from(&self.velocity);
            for (number, part) in parts.iter().enumerate() {
                let hits = match part {
                    Part::Hit(least) => self.closing(&self.terms[number]) > *least,
                    Part::Stop => true,
                    _ => false,
                };
                self.terms[number].law = Law::Between(0.0, if hits { f64::INFINITY } else { 0.0 });
                any |= hits && part.is_hit();
            }
            if !any {
                break;
            }
            self.project();
            self.add_blows();
            self.give_back(&parts);
        }
        for (term, part) in self.terms.iter_mut().zip(&parts) {
            match *part {
                Part::Hit(_) | Part::Stop => term.law = Law::Between(0.0, f64::INFINITY),
                Part::Friction(law) => term.law = law,
                Part::Absent => {}
            }
        }
        self.project();
        self.add_blows();
        for (term, part) in self.terms.iter_mut().zip(&parts) {
            match part {
                Part::Hit(_) | Part::Stop => term.impulse[0] += term.hit,
                // What rubs does so in the last projection alone.
                Part::Friction(_) => {}
                Part::Absent => term.impulse = [0.0; 2],
            }
        }
    }

    /// Adds what links have done in the last projection to what they do in the impact.
    fn add_blows(&mut self) {
        for (blow, link) in self.room.blows.iter_mut().zip(&self.links) {
            blow.iter_mut().zip(link.impulse).for_each(|(blow, impulse)| *blow += impulse);
        }
    }

    /// Takes out of the problem what takes no part in an impact.
    fn take_parts(&mut self, first: usize, threshold: f64) -> Vec<Part> {
        let part = |(number, term): (usize, &Term)| match term.law {
            law @ Law::Leaning { .. } if number >= first => Part::Friction(law),
            _ if !self.touches(term) => Part::Absent,
            _ if number < first && term.restitution == 0.0 => Part::Stop,
            _ => Part::Hit(self.least(term, number < first, threshold)),
        };
        let parts: Vec<_> = self.terms.iter().enumerate().map(part).collect();
        for (term, part) in self.terms.iter_mut().zip(&parts) {
            (term.expected, term.is_known, term.hit) = ([0.0; 2], false, 0.0);
            term.bias[0] = match part {
                Part::Stop => 0.0,
                _ => term.bias[0] - term.ahead,
            };
            term.law = Law::Between(0.0, 0.0);
        }
        for link in &mut self.links {
            for row in 0..link.rows {
                link.impulse[row] = 0.0;
                if link.give[row] > 0.0 {
                    // A spring has no impulse.
                    (link.jacobian[0][row], link.jacobian[1][row], link.bias[row]) = ([0.0; 6], [0.0; 6], 0.0);
                }
            }
        }
        self.masses.iter_mut().for_each(|mass| mass.stiffness = [[0.0; 3]; 3]);
        self.stiff.clear();
        parts
    }

    /// Corrects restitution for contacts that hit early, with a distance s still ahead of them, so that they rebound as high as if they had
    /// closed it first: e'² = e² − (1 − e²) 2 a s/v², with v the present speed and a the acceleration with which joints let them close.
    fn aim(&mut self, parts: &[Part]) {
        if self.terms.iter().any(|term| term.restitution > 0.0 && term.restitution < 1.0) {
            let before = std::mem::take(&mut self.before);
            self.velocity.clone_from(&self.free);
            for (term, part) in self.terms.iter_mut().zip(parts) {
                term.law = Law::Between(0.0, if *part == Part::Stop { f64::INFINITY } else { 0.0 });
            }
            self.project();
            self.before = before;
            let Self { terms, velocity, before, .. } = self;
            for (term, _) in terms.iter_mut().zip(parts).filter(|(_, part)| part.is_hit()) {
                let (was, is) = (speed(term, before)[0], speed(term, velocity)[0]);
                let (square, closing) = (term.restitution * term.restitution, was + term.bias[0]);
                if closing < 0.0 {
                    let gained = 2.0 * term.ahead * (was - is);
                    term.restitution = (square - (1.0 - square) * gained / (closing * closing)).clamp(0.0, 1.0).sqrt();
                }
            }
        }
        self.terms.iter_mut().for_each(|term| term.ahead = 0.0);
    }

    /// v ← P(v).
    fn project(&mut self) {
        self.before.clone_from(&self.velocity);
        self.free.clone_from(&self.velocity);
        self.terms.iter_mut().for_each(|term| (term.expected, term.is_known) = ([0.0; 2], false));
        self.links.iter_mut().for_each(|link| link.impulse = [0.0; 6]);
        self.find_drive();
        for _ in 0..SOLVES {
            self.solve(MAX_FACTORS);
            self.note_impulses();
        }
    }

    /// Lets the contacts that have just been stopped give back their shares, after P has gone from `before` to the velocity.
    fn give_back(&mut self, parts: &[Part]) {
        for (term, part) in self.terms.iter_mut().zip(parts) {
            let holds = *part == Part::Stop && term.impulse[0] > 0.0;
            term.gain = [if holds { 1.0 } else { 0.0 }, 0.0];
        }
        self.factorize();
        let bodies = self.masses.len();
        let Self { unknowns, terms, links, .. } = self;
        unknowns.clear();
        unknowns.resize(bodies, [0.0; 6]);
        for (term, _) in terms.iter().zip(parts).filter(|(_, part)| part.is_hit()) {
            push_term(term, [term.restitution * term.impulse[0], 0.0], unknowns);
        }
        unknowns.resize(bodies + links.len(), [0.0; 6]);
        self.solve_unknowns();
        let share = self.share_within_energy();
        let Self { unknowns, terms, velocity, room, .. } = self;
        for (velocity, more) in velocity.iter_mut().zip(&*unknowns) {
            velocity.iter_mut().zip(more).for_each(|(value, more)| *value += share * more);
        }
        for (blow, found) in room.blows.iter_mut().zip(&unknowns[bodies..]) {
            blow.iter_mut().zip(found).for_each(|(blow, found)| *blow -= share * found);
        }
        for (term, part) in terms.iter_mut().zip(parts) {
            term.hit += match part {
                Part::Hit(_) => term.impulse[0] * (1.0 + share * term.restitution),
                Part::Stop => term.impulse[0] - share * term.gain[0] * speed(term, unknowns)[0] / term.compliance,
                _ => 0.0,
            };
        }
    }

    /// Whether anything that moves by itself, or a motor, takes part in the impact.
    pub(super) fn is_driven(&self) -> bool {
        self.links.iter().any(|link| link.bias != [0.0; 6]) || self.terms.iter().any(|term| term.bias[0] != 0.0)
    }

    /// Largest share up to one of what is given back at which there is no more kinetic energy than before, unless something that moves by
    /// itself takes part.
    fn share_within_energy(&mut self) -> f64 {
        if self.is_driven() {
            return 1.0;
        }
        let bodies = self.masses.len();
        let mut product = std::mem::take(&mut self.room.product);
        let dot = |a: &[[f64; 6]], b: &[[f64; 6]]| -> f64 { a.iter().zip(b).map(|(a, b)| super::factor::dot(a, b)).sum() };
        self.times(&self.before, &mut product);
        let before = dot(&product, &self.before);
        self.times(&self.velocity, &mut product);
        let (stopped, mixed) = (dot(&product, &self.velocity), dot(&product, &self.unknowns[..bodies]));
        self.times(&self.unknowns[..bodies], &mut product);
        let given = dot(&product, &self.unknowns[..bodies]);
        // stopped + 2 s mixed + s² given = before.
        self.room.product = product;
        let more = stopped - before;
        if given <= 0.0 || more + 2.0 * mixed + given <= 0.0 {
            return 1.0;
        }
        let root = (mixed * mixed - given * more).max(0.0).sqrt();
        ((root - mixed) / given).clamp(0.0, 1.0)
    }
}
