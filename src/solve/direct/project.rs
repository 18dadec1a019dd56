//! Position correction of an articulation: errors at the present poses, and the displacements that close them.

use glam::DVec3;

use super::articulation::{Articulation, TOLERANCE};
use super::body::DirectBody;
use super::contacts::ArticulationContact;
use super::distance_stiffness;
use super::system::PROJECTION_PASSES;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::solve::joint::angles;
use crate::solve::joint::driven::{self, DrivenParts};
use crate::solve::joint::geometry::JointGeometry;
use crate::solve::joint::kinds;
use crate::solve::joint::locks::{self, Freedom};
use crate::solve::joint::row_sink::RowSink;
use crate::solve::joint::rows::{Phase, Rate, RowRates, ScalarRow};

/// Share of the tolerance below which positions are left as they are.
const GOOD_ENOUGH: f64 = 0.25;

/// Energy that gaps may stand for: this share of what is kinetic, or as much as bodies have at this speed (m/s); and the gap, over the
/// articulation's size, that is never too wide.
const HARMLESS: f64 = 0.01;
const HARMLESS_SPEED: f64 = 0.3;
const MIN_GAP: f64 = 1.0e-7;

/// Overlap with what the articulation does not move below which positions are left as they are (m).
const NEGLIGIBLE_OVERLAP: f64 = 1.0e-5;

/// Greatest angle that a projection takes out at once (rad), and greatest length over the articulation's size.
const MAX_ANGLE: f64 = 0.1;
const MAX_LENGTH: f64 = 0.4;

/// Most projections of a substep, and how many of them the step's budget does not count: nearly all take no more.
const PROJECTIONS: usize = 16;
const FREE_PROJECTIONS: usize = 3;

/// How often bodies are stiffened against turning before a projection is shortened.
const STIFFENINGS: usize = 4;

/// Shares of a projection's step that are tried then, one after the other.
const BACKTRACKING: [f64; 2] = [0.3, 0.09];

/// Turns that bodies are to keep to once stiffened: at most this (rad), and this times the root of the worst error over the size, as a
/// turn by θ opens a gap of θ²/2 of its lever.
const MAX_TURN: f64 = 0.1;
const TURN_PER_ROOT: f64 = 0.3;

/// By how much more than in proportion to its turn a body is stiffened: what it does not give, its neighbours must.
const STIFFENING: f64 = 4.0;

/// Errors of the positions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Errors {
    /// Worst of the joints (m), with angles as lengths at the articulation's size.
    pub worst: f64,
    /// Worst length (m) and angle (rad).
    pub gap: f64,
    pub angle: f64,
    /// Worst overlap (m).
    pub overlap: f64,
}

impl Errors {
    pub(super) const NONE: Self = Self { worst: 0.0, gap: 0.0, angle: 0.0, overlap: 0.0 };

    /// Counts in those of a joint: points and directions that it holds, and its scalar rows.
    pub(super) fn add_joint(&mut self, point: DVec3, direction: DVec3, scalars: &[ScalarRow]) {
        self.gap = greater(self.gap, greatest(point));
        self.angle = greater(self.angle, greatest(direction));
        for row in scalars.iter().filter(|row| row.acts) {
            let error = if row.min == 0.0 { (-row.bias).max(0.0) } else { row.bias.abs() };
            let worst = if row.jacobian.linear == DVec3::ZERO { &mut self.angle } else { &mut self.gap };
            *worst = greater(*worst, error);
        }
    }

    /// Finds the worst, with angles as lengths at this size (m).
    pub(super) fn judge(&mut self, size: f64) {
        self.worst = greater(self.gap, self.angle * size);
    }
}

impl Articulation {
    /// Brings the angles of joints up to the present poses, after `h` (s) at the present rates.
    pub(super) fn follow_angles(&mut self, joints: &Pool<Joint, JointId>, h: f64) {
        let Self { entries, links, local_poses, rates, left, .. } = self;
        for (entry, link) in entries.iter_mut().zip(&*links).filter(|(entry, _)| entry.counts_turns) {
            let [a, b] = link.bodies.map(|body| body as usize);
            let joint = &joints[entry.joint];
            let ends = [&local_poses[a], &local_poses[b]];
            let placement = driven::before(entry.placement(*ends[0], *ends[1]), joint.drive(), ends, *left);
            let kind = &joint.def.kind;
            if h > 0.0 {
                let moved = angles::rates(kind, &placement, entry.angles, (rates[b].angular - rates[a].angular) * h);
                entry.angles.iter_mut().zip(moved).for_each(|(angle, moved)| *angle += moved);
            }
            entry.follow(kind, &placement);
        }
    }

    /// Errors at the present poses.
    pub(super) fn find_errors(&mut self, joints: &Pool<Joint, JointId>) -> Errors {
        if self.is_points {
            self.points.is_known = false;
            let gap = self.worst_gap();
            return Errors { worst: gap, gap, angle: 0.0, overlap: 0.0 };
        }
        let mut errors = Errors::NONE;
        for number in 0..self.entries.len() {
            let [point, direction] = self.biases_of(number, joints);
            errors.add_joint(point, direction, &self.asked);
        }
        errors.judge(self.size);
        let overlap = |touch: &ArticulationContact| touch.overlap(&self.local_poses, &self.step_start);
        errors.overlap = self.touches.iter().map(overlap).fold(0.0, f64::max);
        errors
    }

    /// Errors of the points and directions that a joint holds rigidly, and `asked` filled with its scalar rows, at the present poses.
    pub(super) fn biases_of(&mut self, number: usize, joints: &Pool<Joint, JointId>) -> [DVec3; 2] {
        self.asked.clear();
        let (link, entry) = (&self.links[number], &self.entries[number]);
        let [a, b] = link.bodies.map(|body| self.local_poses[body as usize]);
        let joint = &joints[entry.joint];
        if link.is_plain {
            return [entry.points(&a, &b).gap, DVec3::ZERO];
        }
        let placement = driven::before(entry.placement(a, b), joint.drive(), [&a, &b], self.left);
        let stops = self.stops.get(number).filter(|_| self.coupled);
        let are_stops_far = stops.is_some_and(|stops| stops.still_hold(&placement));
        let [own, other] = link.bodies.map(|body| self.bodies[body as usize].freedom());
        let locks = Freedom::of_both(own, other);
        let held = || kinds::held_errors(&joint.def, &placement, !are_stops_far);
        if let Some(errors) = locks.is_none().then(held).flatten() {
            return errors;
        }
        let driven = joint.drive().map(|drive| DrivenParts::new(drive, [&a, &b], &placement, [self.left; 2]));
        let rates = RowRates { bodies: link.bodies.map(|body| self.rates[body as usize]), frames: None };
        let all = (Phase::Position { most: f64::INFINITY }, rates);
        let mut sink = RowSink {
            driven,
            has_stops: !are_stops_far,
            ..RowSink::new(JointGeometry::at(&placement), &joint.def, all, entry.angles, &mut self.asked)
        };
        kinds::add_rows(&mut sink);
        locks::take_out(&mut sink, locks);
        [sink.point, sink.direction].map(|row| row.filter(|row| row.acts).map_or(DVec3::ZERO, |row| row.bias))
    }

    /// Displacements that would take out the errors at the present poses, to first order.
    fn find_changes(&mut self, joints: &Pool<Joint, JointId>) {
        self.changes.clear();
        self.changes.resize(self.bodies.len(), Rate { linear: DVec3::ZERO, angular: DVec3::ZERO });
        let most = MAX_LENGTH * self.size;
        if self.is_points {
            self.ask_points(Phase::Position { most });
            self.points.solve(&self.topology, &self.bodies, &mut self.changes);
            return;
        }
        self.built.clear();
        self.build_rows(joints, Phase::Position { most: f64::INFINITY });
        self.system.begin_projection(most, MAX_ANGLE);
        self.system.begin(&self.bodies);
        self.system.solve(&self.topology, &self.bodies, &mut self.changes, PROJECTION_PASSES);
    }

    /// Displaces the bodies by a Newton step; returns the errors that it leaves, if they are accepted, and else moves nothing.
    ///
    /// Its linear rows do not know that levers turn. Where light bodies can follow by turning, they are turned by radians to spare a
    /// heavy one a centimetre, and the gaps grow. Those bodies are stiffened, and the step is sought again: in the limit none turns,
    /// for which the rows of points are exact.
    fn displace(&mut self, joints: &Pool<Joint, JointId>, worst: f64, accept: impl Fn(&Errors) -> bool) -> Option<Errors> {
        self.tried.clone_from(&self.local_poses);
        self.find_changes(joints);
        for attempt in 0..=STIFFENINGS {
            let left = self.try_share(joints, 1.0);
            if accept(&left) {
                return Some(left);
            }
            self.take_back();
            if attempt == STIFFENINGS || !self.pay(1) || !self.stiffen(worst) {
                break;
            }
            self.find_changes(joints);
        }
        for share in BACKTRACKING {
            let left = self.try_share(joints, share);
            if accept(&left) {
                return Some(left);
            }
            self.take_back();
        }
        None
    }

    fn try_share(&mut self, joints: &Pool<Joint, JointId>, share: f64) -> Errors {
        for ((body, stance), change) in self.bodies.iter().zip(&mut self.local_poses).zip(&self.changes) {
            body.displace(stance, change, share);
        }
        self.find_errors(joints)
    }

    fn take_back(&mut self) {
        self.local_poses.clone_from(&self.tried);
        self.points.is_known = false;
    }

    /// Makes bodies answer less by turning that have turned too far for an error of `worst` (m); returns whether there are any.
    fn stiffen(&mut self, worst: f64) -> bool {
        let most = MAX_TURN.min(TURN_PER_ROOT * (worst / self.size).sqrt());
        let mut any = false;
        for (body, change) in self.bodies.iter_mut().zip(&self.changes) {
            let turn = change.angular.length();
            if turn > most {
                body.inverse_inertia *= most / (STIFFENING * turn);
                any = true;
            }
        }
        any
    }

    /// Whether gaps up to this (m) stand for so little energy that positions may stay as they are.
    ///
    /// A gap under a force is energy: a taut rope that is longer by 0.1 mm at each of its joints sags by a multiple of their sum, and its
    /// light pieces spin with what it falls by. What touches is not asked: contacts take more than that.
    fn is_harmless(&self, gap: f64) -> bool {
        if self.coupled || gap <= MIN_GAP * self.size {
            return true;
        }
        let impulse = self
            .entries
            .iter()
            .map(|entry| f64::from(entry.impulses.point.length()) + distance_stiffness::pull(entry).abs())
            .sum::<f64>();
        let most = |(body, rate): (&DirectBody, &Rate)| {
            let mass = body.mass()?;
            Some(0.5 * mass * (HARMLESS * rate.linear.length_squared()).max(HARMLESS_SPEED * HARMLESS_SPEED))
        };
        impulse * gap <= self.h * self.bodies.iter().zip(&self.rates).filter_map(most).sum::<f64>()
    }

    /// Error below which positions are left as they are (m).
    pub(super) fn good_enough(&self) -> f64 {
        GOOD_ENOUGH * TOLERANCE * self.size
    }

    /// Takes errors out of the positions; returns the worst of the joints that is left.
    pub(super) fn project(&mut self, joints: &Pool<Joint, JointId>, errors: Errors) -> f64 {
        self.outcome.penetration = self.outcome.penetration.max(errors.overlap);
        self.reached.clear();
        let left = self.close(joints, errors);
        (self.outcome.gap, self.outcome.angle) = (left.gap, left.angle);
        left.worst
    }

    /// Takes errors out of the positions by Newton's steps, as far as each lessens the worst; returns those that are left.
    pub(super) fn step_towards(&mut self, joints: &Pool<Joint, JointId>, mut errors: Errors) -> Errors {
        let good = self.good_enough();
        let mut overlaps = errors.overlap > NEGLIGIBLE_OVERLAP;
        for round in 0..PROJECTIONS {
            if (errors.worst <= good && !overlaps && self.is_harmless(errors.gap))
                || !errors.worst.is_finite()
                || (round >= FREE_PROJECTIONS && !self.pay(1))
            {
                break;
            }
            if self.reached.is_empty() {
                self.reached.extend_from_slice(&self.local_poses);
            }
            let accept = |left: &Errors| left.worst < errors.worst || (overlaps && left.worst <= good);
            let Some(left) = self.displace(joints, errors.worst, accept) else { break };
            errors = left;
            // Overlaps are taken out bit by bit, once a substep.
            overlaps = false;
        }
        errors
    }
}

/// The greater of two; unlike `max`, which passes over what is no number.
pub(super) fn greater(worst: f64, error: f64) -> f64 {
    if error <= worst { worst } else { error }
}

/// Greatest component, where one that is no number counts as the greatest.
pub(super) fn greatest(v: DVec3) -> f64 {
    let v = v.abs();
    if v.is_nan() { f64::NAN } else { v.max_element() }
}
