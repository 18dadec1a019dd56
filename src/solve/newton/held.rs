//! The joints of an island, with the records of each in the substep.

use std::cell::RefCell;

use glam::DVec3;

use super::joints::{Asking, JointAssembly, MultiplierSlot, Sink, Source};
use super::problem::{Inverses, JointBlock, Problem};
use super::servos::ServoTrial;
use super::term::{Law, Term};
use crate::id::{JointId, Pool};
use crate::joint_rebounds::Rebounds;
use crate::joint_record::Joint;
use crate::linalg::narrowing;
use crate::solve::direct::body::DirectBody;
use crate::solve::joint::body_response::{BodyResponse, CoordinateAnswer};
use crate::solve::joint::kinds::{self, MotorRows};
use crate::solve::joint::locks::Freedom;
use crate::solve::joint::rows::{Jacobian, Rate, ScalarRow};
use crate::solve::joint::{JointEntry, LocalPose, driven, rigid_gap};

/// Lever below which a joint is in the centre of mass of its body, over the body's radius of gyration: frames are rounded.
const CENTRAL: f64 = 1.0e-3;

/// Joints: see the [module](self).
#[derive(Debug, Default)]
pub(super) struct JointSet {
    pub entries: Vec<JointEntry>,
    /// Local numbers of each joint's bodies: 0 is the world, then the island's own slots, then kinematic ones.
    pub ends: Vec<[usize; 2]>,
    pub rows: Vec<JointAssembly>,
    pub sources: Vec<Source>,
    /// Multipliers' places and arguments of the joints' terms in the last substep of this step, and those of each joint.
    arguments: Vec<(MultiplierSlot, f64)>,
    argument_ranges: Vec<(u32, u32)>,
    asked: Vec<ScalarRow>,
    /// Rows where bodies have moved to.
    at_end: (Vec<JointBlock>, Vec<Term>, Vec<Source>),
}

/// Impulses of a joint on B (N·s, N·m·s): of the rows of its point and its direction, and of those that are no part of these.
struct Done {
    point: DVec3,
    angular: DVec3,
    linear_load: DVec3,
    angular_load: DVec3,
}

impl JointAssembly {
    /// What the joint does by these multipliers of its link and those of its terms, about its point; `scalar` is told those of scalar rows.
    fn done(&self, link: &[f64], sources: &[Source], terms: &[Term], mut scalar: impl FnMut(u8, f64)) -> Done {
        let mut done = Done { point: DVec3::ZERO, angular: DVec3::ZERO, linear_load: DVec3::ZERO, angular_load: DVec3::ZERO };
        let held = self.sources.iter().zip(link.iter().copied());
        let own = self.terms.0 as usize..self.terms.1 as usize;
        let bounded = sources[own.clone()].iter().zip(terms[own].iter().map(|term| term.impulse[0]));
        for (source, impulse) in held.chain(bounded) {
            match source.place {
                MultiplierSlot::Point => done.point += source.linear * impulse,
                MultiplierSlot::Direction => done.angular += source.angular * impulse,
                MultiplierSlot::Scalar(id) => {
                    scalar(id, impulse);
                    done.linear_load += source.linear * impulse;
                    done.angular_load += (source.angular - self.levers[1].cross(source.linear)) * impulse;
                }
            }
        }
        done
    }
}

/// How far joint points are from each other beyond what their joints allow: the greatest distance (m), and the sum of squares of all (m²).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Gaps {
    pub greatest: f64,
    pub squares: f64,
}

/// Bodies as joints ask for them, by local number.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a> {
    pub bodies: &'a [DirectBody],
    /// Number of each in the problem.
    pub moved: &'a [u32],
    pub rates: &'a [Rate],
    pub local_poses: &'a [LocalPose],
}

impl<'a> Ends<'a> {
    /// A joint between these that asks for rows of a substep of length `h` (s), whose start and end are so far from the end of the step (s).
    fn asking(
        self,
        joints: &'a Pool<Joint, JointId>,
        entry: &JointEntry,
        ends: &[usize; 2],
        h: f64,
        left: [f64; 2],
    ) -> Asking<'a> {
        let Self { bodies, moved, rates, local_poses } = self;
        let is_asked = entry.traits.has_motor || !entry.traits.gives_by_motors_alone;
        Asking {
            joint: &joints[entry.joint],
            local_poses: ends.map(|body| local_poses[body]),
            rates: ends.map(|body| rates[body]),
            answers: ends.map(|body| if is_asked { bodies[body].answer_at(&local_poses[body]) } else { BodyResponse::NONE }),
            locks: Freedom::of_both(bodies[ends[0]].freedom(), bodies[ends[1]].freedom()),
            in_loop: None,
            moved: ends.map(|body| moved[body]),
            h,
            left,
        }
    }
}

impl JointSet {
    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.ends.clear();
        self.arguments.clear();
        self.argument_ranges.clear();
    }

    pub(super) fn push(&mut self, entry: JointEntry, ends: [usize; 2]) {
        self.entries.push(entry);
        self.ends.push(ends);
    }

    /// Numbers of the terms of servos.
    fn servo_terms(&self) -> impl Iterator<Item = usize> {
        self.entries.iter().zip(&self.rows).flat_map(move |(entry, rows)| {
            let is_one = |id| entry.motors.rows.is_of_one_axis(id);
            let is_servo = move |number: &usize| matches!(self.sources[*number].place, MultiplierSlot::Scalar(id) if is_one(id));
            (rows.terms.0 as usize..rows.terms.1 as usize).filter(is_servo)
        })
    }

    /// Adds the rows of all to the problem of a substep of length `h` (s), whose start and end are so far from the end of the step (s). Where a
    /// servo is on its way, first on trial.
    pub(super) fn add_rows(
        &mut self,
        joints: &Pool<Joint, JointId>,
        problem: &mut Problem,
        of: Ends<'_>,
        h: f64,
        left: [f64; 2],
    ) {
        self.put_rows(joints, problem, of, (h, left), false);
        let mut entries = self.entries.iter().zip(&self.rows);
        if entries.any(|(entry, rows)| rows.is_under_way && kinds::has_servo(&joints[entry.joint].def.kind)) {
            self.mask(problem, of.bodies, of.rates);
            problem.try_servos(self.servo_terms(), h);
            self.put_rows(joints, problem, of, (h, left), true);
        }
        let Self { rows, sources, arguments, argument_ranges, .. } = self;
        for (rows, &(first, last)) in rows.iter().zip(&*argument_ranges) {
            let known = &arguments[first as usize..last as usize];
            for number in rows.terms.0 as usize..rows.terms.1 as usize {
                // Directions of friction about a point are others in every substep.
                let place = sources[number].place;
                if let Some((_, argument)) = known.iter().find(|known| known.0 == place && place != MultiplierSlot::Direction) {
                    let term = &mut problem.terms[number];
                    (term.is_known, term.argument[0]) = (true, *argument);
                }
            }
        }
    }

    /// Makes the rows of all, whose servos may ask the factor of those that have been made before.
    fn put_rows(
        &mut self,
        joints: &Pool<Joint, JointId>,
        problem: &mut Problem,
        of: Ends<'_>,
        (h, left): (f64, [f64; 2]),
        is_tried: bool,
    ) {
        let Self { entries, ends, rows, sources, asked, .. } = self;
        problem.is_base_stale = true;
        let Problem { links, terms, factor, structure, masses, inverses, forces, unknowns, .. } = problem;
        let inverses = Inverses { masses, angular: inverses };
        let trial = ServoTrial { factor, structure, inverses, forces, joints: entries.len(), room: RefCell::new(unknowns) };
        links.clear();
        terms.clear();
        rows.clear();
        sources.clear();
        let mut sink = Sink { links, terms, sources, asked };
        for (entry, ends) in entries.iter_mut().zip(&*ends) {
            let holds = entry.motors.rows != MotorRows::Three;
            let in_loop = |way: &Jacobian| {
                let (linear, a, b) = (way.linear, way.angular_a, way.angular_b);
                let mut rows = [[-linear, -a], [linear, b]].map(|[v, w]| [v.x, v.y, v.z, w.x, w.y, w.z]);
                for (row, &end) in rows.iter_mut().zip(ends) {
                    settle_row(row, &of.bodies[end], &Rate::ZERO);
                }
                trial.answer(ends.map(|end| of.moved[end]), &rows, holds)
            };
            let asking = Asking {
                in_loop: Some(&in_loop as CoordinateAnswer<'_>).filter(|_| is_tried),
                ..of.asking(joints, entry, ends, h, left)
            };
            rows.push(sink.add(entry, &asking));
        }
    }

    /// Puts speeds of what is not moved by rows into the biases of all, and takes locked axes out of them.
    pub(super) fn mask(&self, problem: &mut Problem, bodies: &[DirectBody], rates: &[Rate]) {
        problem.is_base_stale = true;
        for (link, ends) in problem.links.iter_mut().zip(&self.ends) {
            for side in 0..2 {
                let (body, rate) = (&bodies[ends[side]], &rates[ends[side]]);
                for row in 0..link.rows {
                    link.bias[row] += settle_row(&mut link.jacobian[side][row], body, rate);
                }
            }
        }
        for (rows, ends) in self.rows.iter().zip(&self.ends) {
            let terms = &mut problem.terms[rows.terms.0 as usize..rows.terms.1 as usize];
            terms.iter_mut().for_each(|term| settle_term(term, *ends, bodies, rates));
        }
    }

    /// Takes the rows that always hold where the bodies are, after the multipliers of the substep have been kept. Overlaps stay as they are.
    pub(super) fn follow_rows(&mut self, joints: &Pool<Joint, JointId>, problem: &mut Problem, of: Ends<'_>, h: f64, left: f64) {
        let Self { entries, ends, rows, asked, at_end: (links, terms, sources), .. } = self;
        links.clear();
        terms.clear();
        sources.clear();
        let mut sink = Sink { links, terms, sources, asked };
        for (((entry, ends), rows), link) in entries.iter_mut().zip(&*ends).zip(&mut *rows).zip(&mut problem.links) {
            let pressed = entry.pressed;
            let found = sink.add(entry, &of.asking(joints, entry, ends, h, [left; 2]));
            entry.pressed = pressed;
            let Some(new) = sink.links.last().filter(|new| new.rows == link.rows) else { continue };
            (rows.sources, link.jacobian) = (found.sources, new.jacobian);
            for side in 0..2 {
                let (body, rate) = (&of.bodies[ends[side]], &of.rates[ends[side]]);
                link.jacobian[side][..link.rows].iter_mut().for_each(|row| _ = settle_row(row, body, rate));
            }
        }
        problem.is_base_stale = true;
        problem.forget_overlaps();
    }

    /// Finds how far rows are off where the bodies have moved to in a substep of length `h` (s), `left` (s) from the end of the step; returns
    /// the greatest error of those that always hold, and of stops (m, rad).
    pub(super) fn find_errors(
        &mut self,
        joints: &Pool<Joint, JointId>,
        problem: &mut Problem,
        of: Ends<'_>,
        h: f64,
        left: f64,
    ) -> f64 {
        let Self { entries, ends, rows, sources, asked, .. } = self;
        let (mut worst, mut any_overrun) = (0.0_f64, false);
        for (((entry, ends), rows), link) in entries.iter_mut().zip(&*ends).zip(&*rows).zip(&mut problem.links) {
            let asking = of.asking(joints, entry, ends, h, [left; 2]);
            let own = rows.terms.0 as usize..rows.terms.1 as usize;
            let terms = &mut problem.terms[own.clone()];
            any_overrun |= asking.find_errors(entry, rows, (link, &mut *terms), (&sources[own], asked));
            worst = link.error.iter().fold(worst, |worst, error| worst.max(error.abs()));
            worst = terms.iter().fold(worst, |worst, term| worst.max(term.push));
        }
        if any_overrun {
            // What lies on something is to slide there.
            let rubs = |term: &&mut Term| matches!(term.law, Law::Leaning { .. });
            problem.terms.iter_mut().filter(rubs).for_each(|term| term.gain = [0.0; 2]);
            (problem.is_stale, problem.is_base_stale) = (true, true);
        }
        worst
    }

    /// Brings the angles of joints up to the present poses, `left` (s) from the end of the step.
    pub(super) fn follow_angles(&mut self, joints: &Pool<Joint, JointId>, local_poses: &[LocalPose], left: f64) {
        let Self { entries, ends, .. } = self;
        for (entry, ends) in entries.iter_mut().zip(&*ends).filter(|(entry, _)| entry.counts_turns) {
            let (joint, [a, b]) = (&joints[entry.joint], ends.map(|body| local_poses[body]));
            let placement = driven::before(entry.placement(a, b), joint.drive(), [&a, &b], left);
            entry.follow(&joint.def.kind, &placement);
        }
    }

    /// Hands the multipliers of a substep back, and adds them to the loads.
    pub(super) fn keep_impulses(&mut self, problem: &Problem) {
        let Self { entries, rows, sources, arguments, argument_ranges, .. } = self;
        for ((entry, rows), link) in entries.iter_mut().zip(&*rows).zip(&problem.links) {
            entry.impulses.scalar.fill(0.0);
            let Done { point, angular, linear_load, angular_load } =
                rows.done(&link.impulse[..link.rows], sources, &problem.terms, |id, impulse| {
                    entry.impulses.scalar[id as usize] = impulse as f32;
                    if let Some(axis) = entry.motors.rows.axis(id) {
                        entry.motors.sums[axis] += impulse as f32;
                    }
                });
            entry.impulses.point = narrowing::impulse(point);
            entry.impulses.angular = narrowing::impulse(angular);
            entry.pressed |= entry.impulses.pressing();
            entry.rebounds = Rebounds::NONE;
            entry.acted = [narrowing::impulse(point + linear_load), narrowing::impulse(angular + angular_load)];
            entry.linear_sum += entry.acted[0];
            entry.angular_sum += entry.acted[1];
        }
        arguments.clear();
        arguments.extend(sources.iter().zip(&problem.terms).map(|(source, term)| (source.place, term.argument[0])));
        argument_ranges.clear();
        argument_ranges.extend(rows.iter().map(|rows| rows.terms));
    }

    /// Adds what joints have done in an impact to the loads: a blow is borne as any other impulse is. Stops that have been met in it have pressed.
    pub(super) fn add_blow(&mut self, problem: &Problem) {
        let Self { entries, rows, sources, .. } = self;
        let blows = problem.links.iter().zip(&problem.room.blows).map(|(link, blow)| &blow[..link.rows]);
        for ((entry, rows), blow) in entries.iter_mut().zip(&*rows).zip(blows) {
            let Done { point, angular, linear_load, angular_load } = rows.done(blow, sources, &problem.terms, |id, impulse| {
                entry.pressed |= u32::from(impulse > 0.0) << id;
                if let Some(axis) = entry.motors.rows.axis(id) {
                    entry.motors.sums[axis] += impulse as f32;
                }
            });
            entry.linear_sum += narrowing::impulse(point + linear_load);
            entry.angular_sum += narrowing::impulse(angular + angular_load);
        }
    }

    /// Mean distance of joint points from the centres of mass of what moves, and of the ends of lines from each other (m). Where all joints
    /// are in centres of mass, as those of a slider often are, the mean radius of gyration of the bodies; infinite where these do not turn.
    pub(super) fn mean_lever(&self, bodies: &[DirectBody]) -> f64 {
        let levers = self.entries.iter().zip(&self.ends).flat_map(|(entry, ends)| {
            let of = |side: usize| {
                let (lever, gyration) = (entry.local_lever[side].length(), bodies[ends[side]].gyration());
                if lever > CENTRAL * gyration { lever } else { 0.0 }
            };
            [of(0), of(1)]
        });
        let lines = self.entries.iter().zip(&self.rows).filter(|(entry, _)| entry.is_distance).map(|(_, rows)| rows.gap.length());
        let lever = mean(levers.chain(lines));
        let length = if lever > 0.0 { lever } else { mean(bodies.iter().map(DirectBody::gyration)) };
        if length > 0.0 { length } else { f64::INFINITY }
    }

    /// How far joint points are from each other beyond what their joints allow, where these hold them rigidly.
    pub(super) fn gaps(&self, joints: &Pool<Joint, JointId>, local_poses: &[LocalPose]) -> Gaps {
        let gaps = self.entries.iter().zip(&self.ends).map(|(entry, ends)| {
            let [a, b] = ends.map(|body| local_poses[body]);
            rigid_gap(&joints[entry.joint].def, &entry.placement(a, b))
        });
        gaps.fold(Gaps::default(), |gaps, gap| Gaps { greatest: gaps.greatest.max(gap), squares: gaps.squares + gap * gap })
    }
}

/// Mean of those above zero; zero where there are none.
fn mean(lengths: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) =
        lengths.filter(|&length| length > 0.0).fold((0.0, 0.0), |(count, sum), length| (count + 1.0, sum + length));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Takes locked axes of its body out of a row; the rate that it has by a body which rows do not move is returned.
pub(super) fn settle_row(row: &mut [f64; 6], body: &DirectBody, rate: &Rate) -> f64 {
    if !body.is_dynamic() {
        return super::factor::dot(row, &vector(rate));
    }
    if !body.is_free() {
        row.iter_mut().zip(body.free_axes()).for_each(|(entry, free)| *entry *= free);
    }
    0.0
}

/// The same for all rows of a term between these bodies, whose rates go into its biases.
pub(super) fn settle_term(term: &mut Term, ends: [usize; 2], bodies: &[DirectBody], rates: &[Rate]) {
    for side in 0..2 {
        for row in 0..term.rows {
            term.bias[row] += settle_row(&mut term.jacobian[side][row], &bodies[ends[side]], &rates[ends[side]]);
        }
    }
}

pub(super) fn vector(rate: &Rate) -> [f64; 6] {
    let (v, w) = (rate.linear, rate.angular);
    [v.x, v.y, v.z, w.x, w.y, w.z]
}

pub(super) fn rate_of(v: &[f64; 6]) -> Rate {
    Rate { linear: DVec3::new(v[0], v[1], v[2]), angular: DVec3::new(v[3], v[4], v[5]) }
}
