//! What joints do that nothing solves: those between members of one union, and those between bodies none of which is free.
//!
//! Such bodies stand to each other as fixed joints, or the host, have it. A spring between them does what its length or its angle says, a motor
//! with a bounded force that cannot get where it is to go pushes with all of that force, and the fixed joints bear both. With the rows
//! J v + b + γ p = 0 that all solvers read,
//!
//! ```text
//! p = −(J v + b)/γ    within its bounds,      γ = 0:  the bound against J v + b.
//! ```
//!
//! Rows that hold whatever that takes do nothing here: how much of a load they would take off fixed joints beside them is not determined.

use glam::{DVec3, Vec3};

use super::World;
use crate::joint_record::{Joint, told_load};
use crate::solve::joint::angles;
use crate::solve::joint::body_response::{BodyResponse, MotorAnswers};
use crate::solve::joint::geometry::{JointGeometry, Placement};
use crate::solve::joint::kinds::{self, MotorRows};
use crate::solve::joint::row_sink::RowSink;
use crate::solve::joint::rows::{BlockRow, Jacobian, Phase, Rate, RowRates, ScalarRow};

/// Share of a lever, and of a radian, that is rounding where two bodies stand to each other: rotations of both and of the joint's frames are single
/// precision, a half unit in the last place each. A stiff spring would make newtons of it.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// What a joint does to B: force (N) and torque about B's joint point (N·m), and what of it the motor of each axis does.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct IdleLoad {
    pub force: Vec3,
    pub torque: Vec3,
    pub motors: [f32; 6],
}

impl World {
    /// Whether nothing solves a joint, as its bodies cannot move by it.
    fn is_idle(&self, joint: &Joint) -> bool {
        let is_moved = || joint.bodies.iter().flatten().any(|&index| self.bodies[index].is_free());
        self.is_within_union(joint) || (!is_moved() && !self.is_out_of_work(joint))
    }

    /// Whether none of its bodies is dynamic, as of a ragdoll that an animation moves: it has no rows, no load and no part in any graph.
    fn is_out_of_work(&self, joint: &Joint) -> bool {
        !joint.bodies.iter().flatten().any(|&index| self.bodies[index].is_dynamic())
    }

    /// Counts the turns of joints out of work whose bodies the host has moved in the step.
    pub(super) fn follow_idle_angles(&mut self) {
        for number in 0..self.movers.slots.len() {
            let index = self.movers.slots[number];
            let Some(count) = self.bodies.get(index).filter(|body| !body.is_dynamic()).map(|body| body.joints.len()) else {
                continue;
            };
            for place in 0..count {
                let Ok(slot) = self.joints.find(self.bodies[index].joints[place]) else { continue };
                let joint = &self.joints[slot];
                if angles::counts_turns(&joint.def.kind) && self.is_out_of_work(joint) {
                    let now = angles::read(&joint.def.kind, &self.placement(joint), joint.angles);
                    self.joints[slot].angles = now;
                }
            }
        }
    }

    fn is_within_union(&self, joint: &Joint) -> bool {
        matches!(joint.bodies, [Some(a), Some(b)] if self.unions.same(a, b))
    }

    /// What a joint does in a step of length `dt` (s) that nothing solves; `None` for any other.
    pub(super) fn idle_load(&self, slot: u32, dt: f32) -> Option<IdleLoad> {
        let joint = &self.joints[slot];
        (dt > 0.0 && self.is_idle(joint)).then(|| {
            let rate = |side: usize| {
                let (linear, angular) =
                    if self.is_within_union(joint) { (Vec3::ZERO, Vec3::ZERO) } else { self.velocity(joint, side) };
                Rate { linear: linear.as_dvec3(), angular: angular.as_dvec3() }
            };
            load_at(joint, &self.placement(joint), [rate(0), rate(1)], f64::from(dt))
        })
    }
}

/// What the rows of a joint that give, or have bounds, do where its frames stand so and its bodies move so, in a step of length `h` (s).
fn load_at(joint: &Joint, placement: &Placement, rates: [Rate; 2], h: f64) -> IdleLoad {
    let mut scalars = Vec::new();
    // That it moves something is all that a motor has to know.
    let answers = MotorAnswers { bodies: &|_| BodyResponse::NONE, in_loop: Some(&|_: &Jacobian| Some([1.0, 0.0])) };
    let phase = (Phase::Velocity { h }, RowRates { bodies: rates, frames: None });
    let new = RowSink::new(JointGeometry::at(placement), &joint.def, phase, joint.angles, &mut scalars);
    let mut sink = RowSink { answers, ..new };
    kinds::add_rows(&mut sink);
    let (point, direction) = (sink.point, sink.direction);
    let [a, b] = rates;
    let length = placement.a.lever.length() + placement.b.lever.length() + placement.gap.length();
    let passing = |levers: [DVec3; 2]| b.linear + b.angular.cross(levers[1]) - a.linear - a.angular.cross(levers[0]);
    let mut force = point.map_or(DVec3::ZERO, |block| give_of(&block, passing(block.levers), length * ROUNDING / h));
    let mut torque = direction.map_or(DVec3::ZERO, |block| give_of(&block, b.angular - a.angular, ROUNDING / h));
    let (mut motors, rows) = ([0.0; 6], MotorRows::of(&joint.def.kind));
    for row in scalars.iter().filter(|row| row.acts) {
        let size = if row.jacobian.linear == DVec3::ZERO { 1.0 } else { length };
        let impulse = push_of(row, row.jacobian.rate(&rates), size * ROUNDING / h);
        let linear = row.jacobian.linear * impulse;
        force += linear;
        torque += row.jacobian.angular_b * impulse - placement.b.lever.cross(linear);
        if let Some(axis) = rows.axis(row.id) {
            motors[axis] += (impulse / h) as f32;
        }
    }
    let (force, torque) = told_load((force / h).as_vec3(), (torque / h).as_vec3());
    IdleLoad { force, torque, motors }
}

/// Impulse of a block that gives, at this rate; what is left of its speed is rounding up to `slack`.
fn give_of(block: &BlockRow, rate: DVec3, slack: f64) -> DVec3 {
    let held = block.held.project(rate + block.bias);
    if block.acts && block.gamma > 0.0 {
        held.clamp_length_max((held.length() - slack).max(0.0)) / -block.gamma
    } else {
        DVec3::ZERO
    }
}

/// The same of a scalar row, and of one with bounds that is not where it is to be.
fn push_of(row: &ScalarRow, rate: f64, slack: f64) -> f64 {
    let speed = rate + row.bias;
    let speed = speed.signum() * (speed.abs() - slack).max(0.0);
    if row.gamma > 0.0 {
        (-speed / row.gamma).clamp(row.min, row.max)
    } else if speed == 0.0 || !row.is_bounded() {
        0.0
    } else if speed > 0.0 {
        row.min
    } else {
        row.max
    }
}
