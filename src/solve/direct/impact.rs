//! The impact when a stop is met: the end of a slider or of a hinge's range, a rope that goes taut.
//!
//! The substep in which a stop closes ends with the bodies at the stop, C = 0, and still approaching it by what was left of the way,
//! −J v = C₀/h. How much that is says only when in the substep the stop was met. So an impact follows, over no time: no force acts but
//! those of rigid rows,
//!
//! ```text
//! v⁺ = v + M⁻¹ Jᵀ p,     J v⁺ = 0 of what joints hold,     J v⁺ ≥ 0,  p ≥ 0 of the stops that press,
//! ```
//!
//! with the bodies' own masses M: nothing has turned in no time, so that no geometric stiffness takes part. The impulse is the one that the
//! effective mass of the whole articulation gives; momentum is kept, and kinetic energy can only fall (v⁺ is the projection of v on what
//! is allowed, in the metric of M).

use glam::{DMat3, DVec3};

use super::articulation::Articulation;
use super::quads;
use super::row::{Origin, State};
use super::single;
use super::system::PASSES;
use crate::id::{JointId, Pool};
use crate::joint::Joint;
use crate::solve::joint::rows::Phase;

/// Multiplier of a stop that presses although nothing is known of its load: the blow that met it says nothing of that (N·s, N·m·s).
const PRESSES: f32 = f32::MIN_POSITIVE;

impl Articulation {
    /// Stops of a joint that press and did not before this substep, as bits of their rows.
    fn met_by(&self, number: usize, joints: &Pool<Joint, JointId>) -> u32 {
        let (entry, before) = (&self.entries[number], &self.began.joints[number]);
        let met = entry.impulses.pressing() & !before.impulses.pressing();
        if met != 0 && joints[entry.joint].stops_of(met) != 0 { met } else { 0 }
    }

    /// Whether a stop presses that did not before this substep.
    pub(super) fn meets_stop(&self, joints: &Pool<Joint, JointId>) -> bool {
        !self.is_points && (0..self.entries.len()).any(|number| self.met_by(number, joints) != 0)
    }

    /// Ends a substep in which a stop was met by the impact that follows: what presses approaches no more. Joints go on with the
    /// multipliers that they had before.
    pub(super) fn resolve_impact(&mut self, joints: &Pool<Joint, JointId>) {
        self.stiffness.fill(DMat3::ZERO);
        quads::respond(&self.quads, 0.0, &self.stances, &self.stiffness, &mut self.bodies);
        self.predicted.clone_from(&self.stances);
        self.tensions.fill(0.0);
        self.ask(joints, Phase::Tangent { h: self.h });
        for (number, node) in self.system.nodes.iter().enumerate().take(self.entries.len()) {
            let pressing = self.entries[number].impulses.pressing();
            for row in &mut self.system.rows[node.first as usize..node.last as usize] {
                let is_stop = row.min == 0.0 && row.max == f64::INFINITY;
                let acts = match row.origin {
                    Origin::Contact => false,
                    Origin::Scalar(id) if is_stop => pressing >> id & 1 == 1,
                    _ => row.gamma == 0.0 && !row.has_bounds(),
                };
                row.bias = 0.0;
                row.impulse = 0.0;
                row.state = if acts { State::Free } else { State::Absent };
            }
        }
        self.system.begin(&self.bodies);
        self.system.solve(&self.topology, &self.bodies, &mut self.rates, PASSES);
        self.add_blows(joints);
    }

    /// Adds the multipliers of an impact to the loads of the joints; those that joints go on with are those from before it.
    fn add_blows(&mut self, joints: &Pool<Joint, JointId>) {
        for number in 0..self.entries.len() {
            let met = self.met_by(number, joints);
            let Self { entries, system, links, stances, began, .. } = self;
            let (entry, node) = (&mut entries[number], &system.nodes[number]);
            let lever = stances[links[number].bodies[1] as usize].1 * entry.local_lever[1];
            let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
            for row in system.rows[node.first as usize..node.last as usize].iter().filter(|row| row.state != State::Absent) {
                let about = match row.origin {
                    Origin::Point => DVec3::ZERO,
                    Origin::Direction => row.angular[1],
                    _ => row.angular[1] - lever.cross(row.linear[1]),
                };
                force += row.linear[1] * row.impulse;
                moment += about * row.impulse;
            }
            entry.linear_sum += single::impulse(force);
            entry.angular_sum += single::impulse(moment);
            entry.impulses = began.joints[number].impulses;
            for (row, impulse) in entry.impulses.scalar.iter_mut().enumerate().filter(|&(row, _)| met >> row & 1 == 1) {
                debug_assert!(row < u32::BITS as usize);
                *impulse = PRESSES;
            }
        }
    }
}
