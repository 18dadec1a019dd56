//! Holds islands at rest: one that is supported and quiet keeps its poses and multipliers, and is not solved.
//!
//! This is the long-range constraint of the paper's §3.6, from every supported body to the ground, for whole islands. The solver
//! has found multipliers under which nothing moves, so solving again would find them again. What makes it safe is when it ends:
//!
//! * **Engaged** only if for [`CALM_TIME`] no body has kept more speed than [`CALM_SHARE`] of what gravity adds in a step, the
//!   support analysis finds every body standing on contacts that hold, by a margin, and nothing overlaps noticeably. Joints and
//!   their springs, motors and friction are never held.
//! * **Released** whole, before the step is solved, by anything that could change the answer: an edit of a body or of what it
//!   touches, a force, gravity, or a contact point with anything that is not held.
//!
//! Neither poses nor velocities are changed but for setting speeds below the limit to zero, so that energy can only fall, and a
//! released island goes on from the very multipliers that held it.

use glam::Vec3;

mod units;

use super::body_summary::BodySummary;
use super::support::{PairFrame, PairView, kind_of};
use super::{Collision, Islands, LastStep, World};
use crate::body::BodyKind;
use crate::dwell_time::DwellTime;
use crate::joint_graph::support::{SupportGraph, hull};
use crate::tuning::hold::{CALM_SHARE, CALM_TIME, MARGIN_SHARE, OVERLAP_SHARE, STILL_TIME};
use units::{UNIT_CALM_SHARE, Units};

/// Buffers of the stage.
#[derive(Debug, Default)]
pub(super) struct Hold {
    /// Whether each island is held.
    pub islands: Vec<bool>,
    /// Whether anything was let go of in this step.
    pub let_go: bool,
    pub units: Units,
    candidates: Vec<bool>,
    /// The support analysis of the candidates.
    graph: SupportGraph,
}

impl World {
    /// Speeds below which bodies without joints and with joints are calm (m/s).
    pub(super) fn calm_speeds(&self, dt: f32) -> [f32; 2] {
        [CALM_SHARE, UNIT_CALM_SHARE].map(|share| if self.def.hold { share * self.def.gravity.length() * dt } else { 0.0 })
    }

    /// Lets go of a body that is held; its island follows in the next step.
    pub(super) fn release(&mut self, index: u32) {
        let body = &mut self.bodies[index];
        (body.held, body.times.calm_for, body.times.smooth_for) = (false, DwellTime::NONE, DwellTime::NONE);
    }

    pub(super) fn release_all(&mut self) {
        for number in 0..self.movers.slots.len() {
            if self.bodies.get(self.movers.slots[number]).is_some() {
                self.release(self.movers.slots[number]);
            }
        }
    }

    /// Lets go of what a moving kinematic body touches.
    pub(super) fn release_what_is_driven(&mut self) {
        let drives = |body: &crate::body::Body| body.acts_as() == BodyKind::Kinematic && body.is_mover();
        let Self { collision: Collision { pairs, .. }, colliders, bodies, .. } = self;
        for &(key, slot) in pairs.active() {
            let (a, b) = key.shapes();
            let ends = [colliders[a].body, colliders[b].body];
            if pairs.get(slot).has_points() && ends.iter().any(|&index| drives(&bodies[index])) {
                for index in ends {
                    (bodies[index].held, bodies[index].times.calm_for) = (false, DwellTime::NONE);
                }
            }
        }
    }

    /// Says which islands are held in this step: those that were and that nothing has touched, and those that have become calm.
    pub(super) fn hold_islands(&mut self) {
        let mut hold = std::mem::take(&mut self.islands.hold);
        hold.islands.clear();
        hold.candidates.clear();
        hold.let_go = false;
        self.hold_units(&mut hold);
        let mut any = false;
        let Self { islands: Islands { summaries, .. }, bodies, last: LastStep { dt: last_dt, .. }, .. } = &*self;
        for members in self.islands.groups.islands() {
            let known = || members.iter().map(|&index| summaries.of(index));
            let is_held = known().all(BodySummary::is_held);
            hold.let_go |=
                !is_held && members.iter().any(|&index| summaries.of(index).is_held() && !hold.units.members.has(index));
            let is_due = || {
                let calm_for = members.iter().map(|&index| bodies[index].times.calm_for).fold(DwellTime::LONGEST, DwellTime::min);
                calm_for.completes(CALM_TIME, *last_dt)
            };
            let is_calm = |known: BodySummary| known.is_calm() && !known.is_jointed();
            let may_be_candidate = !is_held && known().all(is_calm) && is_due();
            // What is embedded comes out without a velocity.
            let is_candidate = may_be_candidate && !members.iter().any(|&index| self.creeps(index) || self.gathers_speed(index));
            hold.islands.push(is_held);
            hold.candidates.push(is_candidate);
            any |= is_candidate;
        }
        if any {
            self.judge_candidates(&mut hold);
        }
        let Self { islands: Islands { groups, summaries, .. }, bodies, report, .. } = self;
        for (members, &is_held) in groups.islands().zip(&hold.islands) {
            // Of what goes on being held nothing changes.
            let mut count = 0;
            for &index in members.iter().filter(|&&index| !hold.units.members.has(index)) {
                count += 1;
                if summaries.of(index).is_held() == is_held {
                    continue;
                }
                let body = &mut bodies[index];
                body.held = is_held;
                if is_held {
                    (body.linear_velocity, body.angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
                }
            }
            report.counts.bodies_held += if is_held { count } else { 0 };
        }
        self.islands.hold = hold;
    }

    /// Holds the candidates of which every body stands.
    fn judge_candidates(&self, hold: &mut Hold) {
        let Some(frame) = PairFrame::new(self.def.gravity) else { return };
        self.graph_candidates(hold, &frame);
        let Self { islands: Islands { groups, .. }, bodies, .. } = self;
        for (number, members) in groups.islands().enumerate().filter(|&(number, _)| hold.candidates[number]) {
            let stands = |&index: &u32| {
                hold.graph.node(index).is_some_and(|node| {
                    let is_still = bodies[index].times.calm_for.reaches(STILL_TIME) && !node.below.is_empty();
                    let is_supported = node.margin > MARGIN_SHARE * hull::reach(node.hull());
                    (is_still || is_supported) && node.below.iter().all(|&link| hold.graph.link(link).holds)
                })
            };
            // Checked again each half second while it stays calm.
            hold.islands[number] = hold.candidates[number] && members.iter().all(stands);
        }
    }

    /// The support graph of all candidates; those with a noticeable overlap are candidates no longer.
    fn graph_candidates(&self, hold: &mut Hold, frame: &PairFrame) {
        let Self { collision: Collision { pairs, .. }, colliders, bodies, islands: Islands { groups, .. }, .. } = self;
        let Hold { candidates, graph, .. } = hold;
        graph.clear();
        let island = |index: u32| groups.island[index as usize] as usize;
        let moves = |index: u32| bodies[index].is_free() && bodies[index].is_mover();
        for &(_, slot) in pairs.active() {
            let pair = pairs.get(slot);
            let site = PairView::new(pair, slot, colliders, bodies);
            let ends = [site.shapes.0.body, site.shapes.1.body];
            let Some(number) = ends.into_iter().find(|&index| moves(index)).map(island) else { continue };
            if !candidates[number] {
                continue;
            }
            let extent = site.shapes.0.least_extent.min(site.shapes.1.least_extent);
            for manifold in pair.manifolds.iter() {
                candidates[number] &= manifold.points.iter().all(|point| point.separation >= -OVERLAP_SHARE * extent);
                let (points, holds) = site.state(&manifold, true);
                if points != 0
                    && let Some(link) = site.link(&manifold, points, holds, frame)
                {
                    ends.into_iter().for_each(|index| graph.set_kind(index, kind_of(&bodies[index])));
                    graph.insert(link);
                }
            }
        }
        graph.update();
    }

    /// Multipliers that are not solved for follow the length of the substep.
    pub(super) fn scale_held(&mut self, scale: f32) {
        if scale == 1.0 || self.report.counts.bodies_held == 0 {
            return;
        }
        let Self { collision: Collision { pairs, .. }, colliders, bodies, joints, islands: Islands { hold, .. }, .. } = self;
        pairs.for_each_active(|pair| {
            let (a, b) = pair.key.shapes();
            let ends = [a, b].map(|shape| &bodies[colliders[shape].body]);
            if ends.iter().any(|body| body.held) && !ends.iter().any(|body| body.is_solved()) {
                pair.scale_impulses(scale);
            }
        });
        for held in hold.units.held.iter().flat_map(|unit| &unit.bodies) {
            for &id in &bodies[held.body].joints {
                let slot = joints.slot_of(id);
                let ends = joints[slot].bodies;
                // Once, from its first body.
                if ends[0] == Some(held.body) && ends[1].is_some_and(|other| bodies[other].held) {
                    joints[slot].impulses = joints[slot].impulses.scaled(scale);
                }
            }
        }
    }
}
