//! One manifold between two bodies of an island, as terms: a normal for each point, friction at the middle of those that press, one about
//! the normal, and two rows of rolling friction where the material asks for them.

use glam::DVec3;

use super::Surfaces;
use super::stiffness::Rolling;
use super::term::{Law, Term};
use crate::solve::contact::{ContactImpulses, ContactInput, POINTS, tangents};
use crate::solve::direct::curved_contacts::CurvedPoint;
use crate::solve::direct::round_on_block::RoundOnBlock;
use crate::solve::direct::tracked_points::{TrackedPoints, carry, middles, overlap, slip_of_turn, way};
use crate::solve::joint::LocalPose;
use crate::solve::joint::rows::Rate;
use crate::solve::rotation::rotated;

/// Overlap that is left (m): what presses goes on to touch.
const SLOP: f64 = 1.0e-5;

/// Greatest speed at which an overlap is taken out (m/s).
const MAX_RECOVERY: f64 = 4.8;

/// Looks for the moment at which what is round comes to touch a block, at most: regula falsi leaves a thousandth of the way after three.
const MEETINGS: usize = 6;

/// A manifold as its island has it. Its normal points from A to B.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    /// Local numbers of A and B.
    pub bodies: [usize; 2],
    /// Its points, as B sees them, and which of the manifold's each is.
    spots: TrackedPoints,
    places: [u8; POINTS],
    /// As B and as A rolls.
    rolling: [Option<(Rolling, f64)>; 2],
    friction: f64,
    restitution: f64,
    twist_arm: f64,
    rolling_arm: f64,
    /// Multipliers (N·s), friction and rolling in world axes, on B.
    normal: [f64; POINTS],
    tangential: DVec3,
    twist: f64,
    rolls: DVec3,
    /// Sums of the multipliers over the step, impacts with them.
    pub sum: ContactImpulses,
    /// Arguments of its terms in the last substep, as multipliers are, if there was one in this step.
    normal_arguments: [f64; POINTS],
    tangential_argument: DVec3,
    twist_argument: f64,
    rolls_argument: DVec3,
    is_known: bool,
    /// Its first term in this substep, and directions of its friction.
    first: u32,
    across: [DVec3; 2],
}

impl Patch {
    pub(crate) fn new(input: &ContactInput, bodies: [usize; 2]) -> Self {
        let spots = TrackedPoints::of(input, true);
        let spread = spots.spread();
        let material = &input.material;
        Self {
            bodies,
            spots,
            places: std::array::from_fn(|i| i as u8),
            rolling: [None; 2],
            friction: f64::from(material.friction),
            restitution: f64::from(material.restitution),
            twist_arm: f64::from(material.friction) * spread + f64::from(material.spinning),
            rolling_arm: f64::from(material.rolling),
            normal: input.impulses.normal.map(f64::from),
            tangential: input.impulses.friction.as_dvec3(),
            twist: f64::from(input.impulses.twist),
            rolls: input.impulses.rolling.as_dvec3(),
            sum: ContactImpulses::default(),
            normal_arguments: [0.0; POINTS],
            tangential_argument: DVec3::ZERO,
            twist_argument: 0.0,
            rolls_argument: DVec3::ZERO,
            is_known: false,
            first: 0,
            across: [DVec3::ZERO; 2],
        }
    }

    /// Multiplies its multipliers.
    pub(crate) fn scale_impulses(&mut self, factor: f64) {
        self.normal.iter_mut().for_each(|lambda| *lambda *= factor);
        (self.tangential, self.rolls) = (self.tangential * factor, self.rolls * factor);
        self.twist *= factor;
    }

    /// Takes note of how far B's points lie from A's at the start of the step (m).
    pub(crate) fn lie(&mut self, offset: DVec3) {
        self.spots.lie(offset);
    }

    /// Lets it follow what is round on a block.
    pub(crate) fn go_over_block(&mut self, on_block: RoundOnBlock) {
        self.spots.go_over_block(on_block);
    }

    /// Its points with the bodies where they come to touch first within a substep of length `h` (s), or are at its end if they do not. Separations are
    /// those from which its rows lead there.
    fn meet(&self, spots: &mut [CurvedPoint], (local_poses, began, rates): (&[LocalPose], &[LocalPose], &[Rate]), h: f64) {
        let [a, b] = self.bodies;
        let after = |t: f64| {
            let moved = |body: usize| {
                let ((place, rotation), rate) = (local_poses[body], &rates[body]);
                [(place + rate.linear * t, rotated(rotation, rate.angular * t)), began[body]]
            };
            let [of_a, of_b] = [moved(a), moved(b)];
            self.spots.at([&of_b[0], &of_b[1]], [&of_a[0], &of_a[1]])
        };
        let nearest = |spots: &[CurvedPoint]| spots.iter().fold(f64::INFINITY, |nearest, spot| nearest.min(spot.separation));
        let count = self.spots.count;
        let (mut apart, mut met) = ((0.0, nearest(spots)), (h, after(h)));
        if apart.1 <= 0.0 {
            return;
        }
        for _ in 0..MEETINGS {
            let overlap = nearest(&met.1[..count]);
            if overlap >= 0.0 {
                break;
            }
            let t = apart.0 + (met.0 - apart.0) * apart.1 / (apart.1 - overlap);
            let found = after(t);
            match nearest(&found[..count]) {
                next if next > SLOP => apart = (t, next),
                _ => met = (t, found),
            }
        }
        let speed_at = |body: usize, lever: DVec3| rates[body].linear + rates[body].angular.cross(lever);
        for (spot, then) in spots.iter_mut().zip(&met.1[..count]) {
            let opening = then.normal.dot(speed_at(b, then.lever) - speed_at(a, then.other_lever));
            *spot = CurvedPoint { separation: then.separation - met.0 * opening, ..*then };
        }
    }

    /// Lets it follow surfaces that bend. Only a side that forces may turn rolls on the other.
    pub(crate) fn curve(&mut self, ([of_a, of_b], [reach_a, reach_b]): Surfaces, turns: [bool; 2]) {
        let normal = self.spots.normal();
        self.spots.curve([of_b, of_a], reach_b.min(reach_a));
        let as_b = Rolling::new([of_b, of_a], normal, reach_b).filter(|_| turns[1]).map(|rolling| (rolling, reach_b));
        let as_a = Rolling::new([of_a, of_b], -normal, reach_a).filter(|_| turns[0]).map(|rolling| (rolling, reach_a));
        self.rolling = [as_b, as_a];
    }

    /// Brings points that are older than the poses to where the surfaces are tangent now. What becomes one there presses as one.
    pub(crate) fn settle(&mut self, at: &super::Tangency) {
        let Self { spots, places, normal, .. } = self;
        let (points, before) = (spots.count, spots.spread());
        let pressed = *normal;
        let mut kept = 0;
        spots.settle(at, |point, known| {
            if let Some(known) = known {
                normal[known] += pressed[point];
            } else {
                (places[kept], normal[kept]) = (point as u8, pressed[point]);
                kept += 1;
            }
        });
        if spots.count < points {
            normal[spots.count..].fill(0.0);
            self.twist_arm -= self.friction * (before - spots.spread());
        }
    }

    /// Its points at these stances; `began` are those at the start of the step.
    fn spots(&self, local_poses: &[LocalPose], began: &[LocalPose]) -> [CurvedPoint; POINTS] {
        let [a, b] = self.bodies.map(|body| [&local_poses[body], &began[body]]);
        self.spots.at(b, a)
    }

    /// Greatest overlap at these stances, zero where there is none (m).
    pub(crate) fn overlap(&self, local_poses: &[LocalPose], began: &[LocalPose]) -> f64 {
        overlap(&self.spots(local_poses, began))
    }

    /// Adds its terms for a substep of length `h` (s), between bodies that rows know by these numbers. Jacobians of terms are [−, +].
    pub(crate) fn add_terms(
        &mut self,
        moved: [u32; 2],
        (local_poses, began, rates): (&[LocalPose], &[LocalPose], &[Rate]),
        h: f64,
        terms: &mut Vec<Term>,
    ) {
        let mut spots = self.spots(local_poses, began);
        let spots = &mut spots[..self.spots.count];
        let [a, b] = self.bodies.map(|body| [&local_poses[body], &began[body]]);
        // What follows surfaces has been followed up to now.
        if self.spots.are_on_block() {
            if !self.presses() {
                self.meet(spots, (local_poses, began, rates), h);
            }
        } else if self.spots.curved().is_none() {
            carry(spots, self.spots.aside(), [b, a].map(|[now, began]| way(now, began)));
        }
        let first = terms.len() as u32;
        self.first = first;
        for (number, (spot, &pressed)) in spots.iter().zip(&self.normal).enumerate() {
            let mut term = Term::new(moved, 1, Law::Between(0.0, f64::INFINITY));
            (term.is_known, term.argument[0]) = (self.is_known, self.normal_arguments[number]);
            term.jacobian = [0, 1].map(|side| [row(side, spot.normal, [spot.other_lever, spot.lever][side]), [0.0; 6]]);
            term.bias[0] = spot.separation.max(0.0) / h;
            (term.ahead, term.restitution) = (term.bias[0], self.restitution);
            term.expected[0] = pressed;
            term.push = (-spot.separation - SLOP).clamp(0.0, MAX_RECOVERY * h);
            terms.push(term);
        }
        let count = self.spots.count as u32;
        let normal = spots[0].normal;
        let centers = middles(spots);
        let [a, b] = self.bodies.map(|body| &rates[body]);
        let slip = slip_of_turn(spots, [b, a], h);
        let (t1, t2) = tangents(normal.as_vec3());
        let across = [t1.as_dvec3(), t2.as_dvec3()];
        self.across = across;
        if self.friction > 0.0 {
            let mut term = Term::new(moved, 2, Law::Leaning { first, count, share: self.friction });
            term.jacobian = [0, 1].map(|side| across.map(|t| row(side, t, centers[1 - side])));
            term.bias = across.map(|t| t.dot(slip));
            term.expected = across.map(|t| t.dot(self.tangential));
            (term.is_known, term.argument) = (self.is_known, across.map(|t| t.dot(self.tangential_argument)));
            terms.push(term);
        }
        if self.twist_arm > 0.0 {
            let mut term = Term::new(moved, 1, Law::Leaning { first, count, share: self.twist_arm });
            term.jacobian = [0, 1].map(|side| [turning_row(side, normal), [0.0; 6]]);
            term.expected[0] = self.twist;
            (term.is_known, term.argument[0]) = (self.is_known, self.twist_argument);
            terms.push(term);
        }
        if self.rolling_arm > 0.0 {
            let mut term = Term::new(moved, 2, Law::Leaning { first, count, share: self.rolling_arm });
            term.jacobian = [0, 1].map(|side| across.map(|t| turning_row(side, t)));
            term.expected = across.map(|t| t.dot(self.rolls));
            (term.is_known, term.argument) = (self.is_known, across.map(|t| t.dot(self.rolls_argument)));
            terms.push(term);
        }
    }

    /// Its terms in this substep.
    pub(crate) fn terms<'a>(&self, terms: &'a [Term]) -> &'a [Term] {
        &terms[self.first as usize..self.first as usize + self.term_count()]
    }

    /// Terms that it has.
    pub(crate) fn term_count(&self) -> usize {
        let asks = |arm: f64| usize::from(arm > 0.0);
        self.spots.count + asks(self.friction) + asks(self.twist_arm) + asks(self.rolling_arm)
    }

    /// Rows against rolling at these stances, with the sides' Jacobians, the stiffness of each times `h` (s), and the rate that it has where
    /// a body goes steadily round the other. `steady` is told at what rate a side turns then, and the impulse that presses it (N·s).
    pub(crate) fn rolling(
        &self,
        (local_poses, began, rates): (&[LocalPose], &[LocalPose], &[Rate]),
        h: f64,
        pressing: impl Fn(u32) -> f64,
        mut take: impl FnMut([[f64; 6]; 2], f64, f64),
        mut steady: impl FnMut(usize, DVec3, f64),
    ) {
        if self.rolling.iter().all(Option::is_none) {
            return;
        }
        let spots = self.spots(local_poses, began);
        for (number, spot) in spots[..self.spots.count].iter().enumerate() {
            let impulse = pressing(self.first + number as u32);
            if impulse <= 0.0 {
                continue;
            }
            for (as_a, rolling) in self.rolling.iter().enumerate() {
                let Some((rolling, reach)) = rolling else { continue };
                let (side, normal, lever) =
                    if as_a == 0 { (1, spot.normal, spot.lever) } else { (0, -spot.normal, spot.other_lever) };
                let (height, [own, other]) = (-normal.dot(lever), [side, 1 - side].map(|side| rates[self.bodies[side]].linear));
                let (turning, angular) = (rolling.turning(own - other, height), rates[self.bodies[side]].angular);
                let axes = rolling.directions.map(|t| normal.cross(t));
                // A link on a drum goes round it, the deck under a wheel does not: no body is made to turn that does not turn by itself.
                let turns = [0, 1].map(|k| axes[k] * axes[k].dot(angular).clamp(turning[k].min(0.0), turning[k].max(0.0)));
                let turns = turns[0] + turns[1];
                steady(side, turns, impulse);
                for ([about, along], stiffness) in rolling.rows(normal, height, *reach).into_iter().flatten() {
                    let rate = about.dot(turns) + along.dot(own - other);
                    let (own, other) = ([along, about], [-along, DVec3::ZERO]);
                    let sides = if as_a == 0 { [other, own] } else { [own, other] };
                    take(sides.map(|[v, w]| [v.x, v.y, v.z, w.x, w.y, w.z]), h * impulse * stiffness, rate);
                }
            }
        }
    }

    /// Adds what it has done by these terms to what it does in the step.
    pub(crate) fn add_up(&mut self, terms: &[Term]) {
        let terms = self.terms(terms);
        let mut sum = ContactImpulses::default();
        for (&place, term) in self.places.iter().zip(&terms[..self.spots.count]) {
            sum.normal[usize::from(place)] = term.impulse[0].max(0.0) as f32;
        }
        let [u, v] = self.across;
        let in_world = |[along, aside]: [f64; 2]| (u * along + v * aside).as_vec3();
        let mut beside = terms[self.spots.count..].iter().map(|term| term.impulse);
        let mut next = |is_asked: bool| if is_asked { beside.next().unwrap_or_default() } else { [0.0; 2] };
        sum.friction = in_world(next(self.friction > 0.0));
        sum.twist = next(self.twist_arm > 0.0)[0] as f32;
        sum.rolling = in_world(next(self.rolling_arm > 0.0));
        self.sum.add(&sum);
    }

    /// Takes its multipliers, and arguments, from the terms.
    pub(crate) fn keep_impulses(&mut self, terms: &[Term]) {
        self.add_up(terms);
        let mut next = self.first as usize;
        for number in 0..self.spots.count {
            let term = &terms[next + number];
            self.normal[number] = term.impulse[0].max(0.0);
            self.normal_arguments[number] = term.argument[0];
        }
        next += self.spots.count;
        let [u, v] = self.across;
        let in_world = |[along, aside]: [f64; 2]| u * along + v * aside;
        if self.friction > 0.0 {
            self.tangential = in_world(terms[next].impulse);
            self.tangential_argument = in_world(terms[next].argument);
            next += 1;
        }
        if self.twist_arm > 0.0 {
            self.twist = terms[next].impulse[0];
            self.twist_argument = terms[next].argument[0];
            next += 1;
        }
        if self.rolling_arm > 0.0 {
            self.rolls = in_world(terms[next].impulse);
            self.rolls_argument = in_world(terms[next].argument);
        }
        self.is_known = true;
    }

    /// Whether any of its points presses.
    pub(crate) fn presses(&self) -> bool {
        self.normal.iter().any(|&lambda| lambda > 0.0)
    }

    /// Whether any of its points presses as far as the next step is told: what is below the least number of single precision is carried as none.
    pub(crate) fn goes_on_pressing(&self) -> bool {
        self.impulses().normal.iter().any(|&lambda| lambda > 0.0)
    }

    /// Multipliers in the manifold's own terms.
    pub(crate) fn impulses(&self) -> ContactImpulses {
        let mut normal = [0.0; POINTS];
        for (&place, &lambda) in self.places.iter().zip(&self.normal[..self.spots.count]) {
            normal[usize::from(place)] = lambda as f32;
        }
        ContactImpulses { normal, friction: self.tangential.as_vec3(), twist: self.twist as f32, rolling: self.rolls.as_vec3() }
    }
}

/// A row along `axis` at `lever` on one side: A has it with the other sign.
pub(super) fn row(side: usize, axis: DVec3, lever: DVec3) -> [f64; 6] {
    let (v, w) = (axis, lever.cross(axis));
    let sign = if side == 1 { 1.0 } else { -1.0 };
    [v.x * sign, v.y * sign, v.z * sign, w.x * sign, w.y * sign, w.z * sign]
}

/// A row about `axis` on one side.
pub(super) fn turning_row(side: usize, axis: DVec3) -> [f64; 6] {
    let sign = if side == 1 { 1.0 } else { -1.0 };
    [0.0, 0.0, 0.0, axis.x * sign, axis.y * sign, axis.z * sign]
}
