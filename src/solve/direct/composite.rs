//! Composite inertia of a motor: the bodies on either side of its joint, as if all other joints were locked.
//!
//! A servo brakes in time only if it knows what it has set going: an arm's shoulder moves the whole arm and what the hand holds. With
//! the joint taken out an articulation falls into two parts; each is taken as one rigid body, of mass M = Σ m and inertia about its
//! centre I = Σ (I + m (|r|² 1 − r rᵀ)), since other servos hold. A part with something that does not move does not move either.
//! Where the joint closes a loop, what does not move being one body, there are no two parts: see *servo_loops.rs*.

use glam::{DMat3, DVec3};

use super::articulation::Articulation;
use super::articulation_state::ServoLoad;
use super::topology::NodeBodies;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::solve::joint::body_response::BodyResponse;
use crate::solve::joint::kinds;
use crate::solve::joint::rows::Rate;

/// Joints of an articulation beyond which a servo looks at its own bodies alone: its parts are found anew for each motor, which takes
/// joints times the depth of the tree.
const MAX_JOINTS: usize = 64;

impl Articulation {
    /// Finds what the servos move, at the present poses.
    pub(super) fn find_parts(&mut self, joints: &Pool<Joint, JointId>) {
        let mut parts = std::mem::take(&mut self.parts);
        parts.loads.clear();
        parts.trial.is_ready = false;
        let is_small = (2..=MAX_JOINTS).contains(&self.entries.len());
        if is_small && self.entries.iter().any(|entry| entry.traits.has_motor) {
            for number in 0..self.entries.len() {
                let entry = &self.entries[number];
                let is_servo = entry.traits.has_motor && kinds::has_servo(&joints[entry.joint].def.kind);
                parts.loads.push(if is_servo { self.load_of(number, &mut parts.reached) } else { ServoLoad::Own });
            }
        }
        self.parts = parts;
    }

    fn load_of(&self, number: usize, reached: &mut Vec<bool>) -> ServoLoad {
        let ends = self.links[number].bodies;
        let mut answers = [BodyResponse::NONE; 2];
        let mut stands = [true; 2];
        for side in 0..2 {
            if !self.bodies[ends[side] as usize].is_dynamic() {
                continue;
            }
            reached.clear();
            reached.resize(self.bodies.len(), false);
            reached[ends[side] as usize] = true;
            // What does not move connects nothing.
            let others = || {
                self.links
                    .iter()
                    .enumerate()
                    .filter(|&(other, link)| other != number && other < self.entries.len() && moves(self, link))
            };
            loop {
                let mut grows = false;
                for (_, link) in others() {
                    let [a, b] = link.bodies.map(|body| body as usize);
                    grows |= reached[a] != reached[b];
                    (reached[a], reached[b]) = (reached[a] | reached[b], reached[a] | reached[b]);
                }
                if !grows {
                    break;
                }
            }
            if reached[ends[1 - side] as usize] {
                return ServoLoad::Loop;
            }
            stands[side] = self.links.iter().take(self.entries.len()).enumerate().any(|(other, link)| {
                other != number && !moves(self, link) && link.bodies.iter().any(|&body| reached[body as usize])
            });
            if !stands[side] {
                let Some(part) = self.composite(ends[side] as usize, reached) else { return ServoLoad::Own };
                answers[side] = part;
            }
        }
        if stands == [true; 2] { ServoLoad::Loop } else { ServoLoad::Parts(answers) }
    }

    /// The bodies that have been reached, as one, seen from the centre of mass of `body`.
    fn composite(&self, body: usize, reached: &[bool]) -> Option<BodyResponse> {
        let place = |i: usize| self.origins[i] - self.origins[body] + self.local_poses[i].0 - self.local_poses[body].0;
        let members = || (0..self.bodies.len()).filter(|&i| reached[i]);
        let (mut mass, mut center, mut force) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for i in members() {
            let own = self.bodies[i].free_mass()?;
            mass += own;
            center += place(i) * own;
            force += self.bodies[i].acceleration * own;
        }
        let center = center / mass;
        let (mut inertia, mut torque) = (DMat3::ZERO, DVec3::ZERO);
        for i in members() {
            let (own, arm) = (self.bodies[i].free_mass()?, place(i) - center);
            let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
            inertia += self.bodies[i].inertia_at(&self.local_poses[i])
                + (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer) * own;
            torque += self.bodies[i].torque + arm.cross(self.bodies[i].acceleration * own);
        }
        let inverse_inertia = inertia.inverse();
        let acceleration = Rate { linear: force / mass, angular: inverse_inertia * torque };
        Some(BodyResponse { inverse_mass: DVec3::splat(1.0 / mass), inverse_inertia, acceleration, center })
    }
}

/// Whether both bodies of a joint move.
fn moves(own: &Articulation, link: &NodeBodies) -> bool {
    link.bodies.iter().all(|&body| own.bodies[body as usize].is_dynamic())
}
