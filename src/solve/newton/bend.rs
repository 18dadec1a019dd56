//! The bend of the ways on which joints lead bodies, kept in their velocities.
//!
//! A substep holds rows along their start, J(x₀) v = 0, and bodies that go so leave the way on which joints lead them by its bend
//!
//! ```text
//! c = (C(x₀ + h v) − C(x₀))/h − J v
//! ```
//!
//! Where that is taken out of positions alone, the next substep projects v on a tangent that has turned by ω h, and (ω h)² of the energy of
//! what swings is lost in each: 55 % in 10 s at 60 steps a second. So velocities are those of the chord, J v = −c, as in SHAKE: the next projection
//! takes what the chord has given. It is solved for with the substep's last factor, in which contacts stick or slide as has been found.

use glam::DVec3;

use super::factor::dot;
use super::held::rate_of;
use super::island::CoupledIsland;
use super::joints::MultiplierSlot;
use super::problem::{Problem, push_term, speed};
use super::term::{FIXED, Term};

/// Speed that a bend may give to the two bodies of a joint, over the speed that they have, both in the metric of their masses: half the angle by
/// which a body turns about a joint in a substep. Beyond it a chord is no picture of the way: what comes to a dead centre, or a line of links
/// that snaps straight, would be given more than it has. No bend is kept then, and energy is lost as it was. Tried from 0.05 to 0.3 on ropes over
/// square posts and bridges of straight planks: at 0.15 both hold, without a bound a rope sinks 0.29 m into its post.
const MOST_BENT: f64 = 0.15;

/// Bend of a joint's way in a substep.
struct Bend {
    /// How far its points part beyond h J v, over the substep's length (m/s).
    points: DVec3,
    /// How much longer the line between them gets, as much; and the line.
    line: Option<(f64, DVec3)>,
}

impl Bend {
    /// Along the direction of a row.
    fn along(&self, place: MultiplierSlot, linear: DVec3) -> f64 {
        match (place, self.line) {
            (MultiplierSlot::Point, _) => linear.dot(self.points),
            (MultiplierSlot::Scalar(_), Some((longer, line))) => linear.dot(line) * longer,
            _ => 0.0,
        }
    }
}

impl CoupledIsland {
    /// Gives velocities of a substep of length `h` (s) what leads bodies round the bend, and multipliers what that takes.
    pub(super) fn follow_bends(&mut self, h: f64) {
        let mut asked = std::mem::take(&mut self.problem.room.asked);
        asked.clear();
        self.problem.room.bent.clear();
        let mut is_bent = false;
        for number in 0..self.held.rows.len() {
            let rows = &self.held.rows[number];
            let bend = self.bend_of(number, h);
            let Problem { links, terms, room, .. } = &mut self.problem;
            let link = &links[number];
            let mut along = [0.0; 6];
            for row in (0..link.rows).filter(|&row| link.give[row] == 0.0) {
                along[row] = -bend.along(rows.sources[row].place, rows.sources[row].linear);
            }
            for number in (rows.terms.0..rows.terms.1).filter(|&number| terms[number as usize].is_one_sided()) {
                let source = &self.held.sources[number as usize];
                let bent = -bend.along(source.place, source.linear);
                if bent != 0.0 {
                    room.bent.push((number, bent));
                }
            }
            is_bent |= along != [0.0; 6];
            asked.push(along);
        }
        if is_bent || !self.problem.room.bent.is_empty() {
            self.problem.bend(&asked);
        }
        self.problem.room.asked = asked;
    }

    /// The bend of a joint that holds points, or keeps them at a distance.
    fn bend_of(&self, number: usize, h: f64) -> Bend {
        let Self { problem, bodies, local_poses, held, .. } = self;
        let (rows, ends, link) = (&held.rows[number], held.ends[number], &problem.links[number]);
        let length = rows.gap.length();
        let is_line = held.entries[number].is_distance && length > super::island::MIN_LENGTH;
        if !rows.holds_points && !is_line {
            return Bend { points: DVec3::ZERO, line: None };
        }
        let [a, b] = [0, 1].map(|side| {
            if link.bodies[side] == FIXED {
                return [DVec3::ZERO; 2];
            }
            let (stance, lever) = (&local_poses[ends[side]], rows.levers[side]);
            let rate = rate_of(&problem.velocity[link.bodies[side] as usize]);
            let turned = bodies[ends[side]].turn(stance, &rate, h).rotation * (stance.1.conjugate() * lever);
            let straight = rate.angular.cross(lever);
            [(turned - lever) / h - straight, rate.linear + straight]
        });
        let points = b[0] - a[0];
        let line = is_line.then(|| {
            let (line, part) = (rows.gap / length, b[1] - a[1]);
            (((rows.gap + (part + points) * h).length() - length) / h - line.dot(part), line)
        });
        Bend { points, line }
    }
}

impl Problem {
    /// Gives velocities what rows are asked for beyond their own, and what terms that press are, unless it is more than a chord can be.
    fn bend(&mut self, asked: &[[f64; 6]]) {
        if self.is_stale {
            self.factorize();
        }
        let bodies = self.masses.len();
        let Self { unknowns, terms, factor, structure, room, .. } = self;
        unknowns.clear();
        unknowns.resize(bodies, [0.0; 6]);
        for &(number, bent) in &room.bent {
            let term = &terms[number as usize];
            push_term(term, term.gained([bent / term.compliance, 0.0]), unknowns);
        }
        unknowns.extend_from_slice(asked);
        factor.solve(structure, unknowns);
        if !self.is_chord() {
            return;
        }
        let Self { unknowns, terms, links, velocity, room, .. } = self;
        for (velocity, more) in velocity.iter_mut().zip(&*unknowns) {
            velocity.iter_mut().zip(more).for_each(|(value, more)| *value += more);
        }
        for (link, found) in links.iter_mut().zip(&unknowns[bodies..]) {
            link.impulse.iter_mut().zip(found).for_each(|(impulse, found)| *impulse -= found);
        }
        let mut bent = room.bent.iter().peekable();
        for (number, term) in (0..).zip(terms.iter_mut()) {
            let own = bent.next_if(|(of, _)| *of == number).map_or(0.0, |(_, bent)| *bent);
            if term.give == 0.0 && term.gain != [0.0; 2] {
                term.lead(unknowns, own);
            }
        }
    }

    /// Whether the velocities found are small beside those that bodies have at each joint, and lead no way but across: together they have no more
    /// energy than that.
    fn is_chord(&self) -> bool {
        let share = MOST_BENT * MOST_BENT;
        let energy = |body: usize, v: &[f64; 6]| dot(&self.masses[body].times(v, 0.0), v);
        let (mut before, mut after) = (0.0, 0.0);
        for (body, (v, more)) in self.velocity.iter().zip(&self.unknowns).enumerate() {
            before += energy(body, v);
            after += energy(body, &std::array::from_fn(|i| v[i] + more[i]));
        }
        let of = |bodies: [u32; 2], v: &[[f64; 6]]| -> f64 {
            let moved = bodies.into_iter().filter(|&body| body != FIXED).map(|body| body as usize);
            moved.map(|body| energy(body, &v[body])).sum()
        };
        // Written so that what is no number is none.
        after <= (1.0 + share) * before
            && self.links.iter().all(|link| of(link.bodies, &self.unknowns) <= share * of(link.bodies, &self.velocity))
    }
}

impl Term {
    /// Takes what a bend's velocities make it do, of which it asks this (m/s) itself.
    fn lead(&mut self, velocity: &[[f64; 6]], asked: f64) {
        let u = speed(self, velocity);
        let yields = [u[0] - asked, u[1]].map(|u| u / self.compliance);
        let done = self.gained(yields);
        self.impulse = self.project([0, 1].map(|i| self.impulse[i] - done[i]));
        self.argument = [0, 1].map(|i| self.argument[i] - yields[i]);
    }
}
