//! Rows of an articulation at the poses of now, the errors that they show, and how those are taken out.

use glam::DVec3;

use super::articulation::{Articulation, TOLERANCE};
use super::contacts::Touch;
use super::system::{PROJECTION_PASSES, System};
use crate::id::{JointId, Pool};
use crate::joint::{Joint, JointImpulses};
use crate::solve::joint::Stance;
use crate::solve::joint::geometry::JointGeometry;
use crate::solve::joint::kinds::{self, RowSink};
use crate::solve::joint::rows::{BlockRow, Held, Phase, Rate};

/// Share of the tolerance below which positions are left as they are.
const GOOD_ENOUGH: f64 = 0.25;

/// Overlap with what the articulation does not move below which positions are left as they are (m).
const NEGLIGIBLE_OVERLAP: f64 = 1.0e-5;

/// Greatest angle that a projection takes out at once (rad), and over the articulation's size the greatest length.
const MOST_ANGLE: f64 = 0.1;

/// Most projections of a substep.
const PROJECTIONS: usize = 3;

/// Shares of a projection's step that are tried, one after the other.
const BACKTRACKING: [f64; 3] = [1.0, 0.3, 0.09];

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

impl Articulation {
    /// What joints and contacts ask for in this phase, ready for the first solve.
    pub(super) fn ask(&mut self, joints: &Pool<Joint, JointId>, phase: Phase) {
        if self.is_points {
            self.ask_points(phase);
        } else {
            self.build_rows(joints, phase);
            self.system.begin(&self.bodies);
        }
    }

    /// Makes the rows of all joints and contacts; those of a velocity phase need the predicted poses.
    fn build_rows(&mut self, joints: &Pool<Joint, JointId>, phase: Phase) {
        let Self { entries, links, rates, stances, began, predicted, implicit, system, asked, touches, step_start, h, .. } = self;
        let mut next_touch = 0;
        let mut add_touches = |number: usize, system: &mut System| {
            while let Some(touch) = touches.get(next_touch).filter(|touch| touch.node as usize == number) {
                let spots = touch.spots(stances, step_start);
                match phase {
                    Phase::Velocity { h } | Phase::Tangent { h } => {
                        touch.add_rows(system, &spots, &rates[touch.other as usize], h);
                    }
                    Phase::Position { .. } => touch.add_position_rows(system, &spots, *h),
                }
                next_touch += 1;
            }
        };
        let in_place = matches!(phase, Phase::Position { .. });
        system.clear();
        for (number, link) in links.iter().enumerate() {
            let Some(entry) = entries.get(number) else {
                system.add(link.bodies, None, None, &[]);
                add_touches(number, system);
                continue;
            };
            let [a, b] = link.bodies.map(|body| body as usize);
            let placement = |a: &Stance, b: &Stance| if link.is_plain { entry.points(a, b) } else { entry.placement(*a, *b) };
            let geometry = if matches!(phase, Phase::Velocity { .. }) {
                let start = placement(&began.stances[a], &began.stances[b]);
                let end = placement(&predicted[a], &predicted[b]);
                let between = |body: usize| {
                    let (from, to) = (began.stances[body], predicted[body]);
                    (from.0.lerp(to.0, implicit[number]), from.1.lerp(to.1, implicit[number]))
                };
                let gradient = match implicit[number] {
                    0.0 => start,
                    1.0 => end,
                    _ => placement(&between(a), &between(b)),
                };
                JointGeometry { start, predicted: end, gradient }
            } else {
                JointGeometry::at(placement(&stances[a], &stances[b]))
            };
            asked.clear();
            let mut sink = RowSink {
                rates: [rates[a], rates[b]],
                geometry: &geometry,
                def: &joints[entry.joint].def,
                impulses: if in_place { &JointImpulses::ZERO } else { &entry.impulses },
                phase,
                point: None,
                direction: None,
                scalars: asked,
            };
            if link.is_plain {
                sink.hold_points(Held::All);
            } else {
                kinds::add_rows(&mut sink);
            }
            let (point, direction) = (sink.point, sink.direction);
            system.add(link.bodies, point.as_ref(), direction.as_ref(), asked);
            add_touches(number, system);
        }
    }

    /// Errors at the present poses.
    pub(super) fn find_errors(&mut self, joints: &Pool<Joint, JointId>) -> Errors {
        if self.is_points {
            self.points.is_known = false;
            let gap = self.worst_gap();
            return Errors { worst: gap, gap, angle: 0.0, overlap: 0.0 };
        }
        let (mut gap, mut angle) = (0.0_f64, 0.0_f64);
        for number in 0..self.entries.len() {
            let (own_gap, own_angle) = self.error_of(number, joints);
            (gap, angle) = (greater(gap, own_gap), greater(angle, own_angle));
        }
        let worst = greater(gap, angle * self.size);
        let overlap = |touch: &Touch| touch.overlap(&self.stances, &self.step_start);
        Errors { worst, gap, angle, overlap: self.touches.iter().map(overlap).fold(0.0, f64::max) }
    }

    /// Greatest errors of the rigid rows of a joint at the present poses, length (m) and angle (rad).
    fn error_of(&mut self, number: usize, joints: &Pool<Joint, JointId>) -> (f64, f64) {
        let (link, entry) = (&self.links[number], &self.entries[number]);
        let [a, b] = link.bodies.map(|body| self.stances[body as usize]);
        let def = &joints[entry.joint].def;
        if link.is_plain {
            return (greatest(entry.points(&a, &b).gap), 0.0);
        }
        self.asked.clear();
        let mut sink = RowSink {
            rates: link.bodies.map(|body| self.rates[body as usize]),
            geometry: &JointGeometry::at(entry.placement(a, b)),
            def,
            impulses: &JointImpulses::ZERO,
            phase: Phase::Position { most: f64::INFINITY },
            point: None,
            direction: None,
            scalars: &mut self.asked,
        };
        kinds::add_rows(&mut sink);
        let block = |row: Option<BlockRow>| row.filter(|row| row.acts).map_or(0.0, |row| greatest(row.bias));
        let (mut gap, mut angle) = (block(sink.point), block(sink.direction));
        for row in self.asked.iter().filter(|row| row.acts) {
            let error = if row.min == 0.0 { (-row.bias).max(0.0) } else { row.bias.abs() };
            let worst = if row.jacobian.linear == DVec3::ZERO { &mut angle } else { &mut gap };
            *worst = greater(*worst, error);
        }
        (gap, angle)
    }

    /// Displacements that would take out the errors at the present poses, to first order.
    fn find_changes(&mut self, joints: &Pool<Joint, JointId>) {
        self.changes.clear();
        self.changes.resize(self.bodies.len(), Rate { linear: DVec3::ZERO, angular: DVec3::ZERO });
        let most = MOST_ANGLE * self.size;
        if self.is_points {
            self.ask_points(Phase::Position { most });
            self.points.solve(&self.topology, &self.bodies, &mut self.changes);
            return;
        }
        self.build_rows(joints, Phase::Position { most: f64::INFINITY });
        self.system.begin_projection(most, MOST_ANGLE);
        self.system.begin(&self.bodies);
        self.system.solve(&self.topology, &self.bodies, &mut self.changes, PROJECTION_PASSES);
    }

    /// Takes errors out of the positions; returns the worst of the joints that is left.
    pub(super) fn project(&mut self, joints: &Pool<Joint, JointId>, mut errors: Errors) -> f64 {
        self.outcome.penetration = self.outcome.penetration.max(errors.overlap);
        let good = GOOD_ENOUGH * TOLERANCE * self.size;
        let mut overlaps = errors.overlap > NEGLIGIBLE_OVERLAP;
        for _ in 0..PROJECTIONS {
            if (errors.worst <= good && !overlaps) || !errors.worst.is_finite() {
                break;
            }
            self.find_changes(joints);
            self.tried.clone_from(&self.stances);
            let mut accepted = false;
            for factor in BACKTRACKING {
                for ((body, stance), change) in self.bodies.iter().zip(&mut self.stances).zip(&self.changes) {
                    body.displace(stance, change, factor);
                }
                let left = self.find_errors(joints);
                if left.worst < errors.worst || (overlaps && left.worst <= good) {
                    errors = left;
                    accepted = true;
                    break;
                }
                self.stances.clone_from(&self.tried);
                self.points.is_known = false;
            }
            if !accepted {
                break;
            }
            // Overlaps are taken out bit by bit, once a substep.
            overlaps = false;
        }
        (self.outcome.gap, self.outcome.angle) = (errors.gap, errors.angle);
        errors.worst
    }
}

/// The greater of two; unlike `max`, which passes over what is no number.
fn greater(worst: f64, error: f64) -> f64 {
    if error <= worst { worst } else { error }
}

/// Greatest component, where one that is no number counts as the greatest.
fn greatest(v: DVec3) -> f64 {
    let v = v.abs();
    if v.is_nan() { f64::NAN } else { v.max_element() }
}
