//! What a batch takes of a body, or of a union as one body, at the start of a step.

use glam::{Quat, Vec3};

use super::BatchInput;
use crate::body::BodyKind;
use crate::joint_graph::union::UnionMotion;
use crate::solve::state::{BodyMotion, BodyVelocity, Constraints, MotionKind, Symmetric};
use crate::world::unions::Union;

/// Relative difference of principal moments below which a body is taken as round.
const ROUND: f32 = 1.0e-5;

impl BatchInput<'_> {
    /// State of what has the slot of this body: the body, or the union that it leads. Whether the host pushes it in this step.
    pub(super) fn slot_state(&self, index: u32) -> (BodyVelocity, BodyMotion, bool) {
        match self.unions.moving(index) {
            Some(union) => {
                let (velocity, motion) = self.union_state(union);
                (velocity, motion, union.members.iter().any(|&member| self.bodies[member].is_pushed()))
            }
            None => {
                let (velocity, motion) = self.body_state(index);
                (velocity, motion, self.bodies[index].is_pushed())
            }
        }
    }

    /// A union as one body: forces on its members add up about its centre.
    fn union_state(&self, union: &Union) -> (BodyVelocity, BodyMotion) {
        let UnionMotion { center, rotation, linear, angular } = union.motion;
        let mass = union.mass;
        let (mut force, mut torque, mut decay, mut turning_decay, mut turning) = (Vec3::ZERO, Vec3::ZERO, 0.0, 0.0, 0.0);
        let lead = &self.bodies[union.lead];
        for &index in &union.members {
            let body = &self.bodies[index];
            let Some(own) = &body.mass else { continue };
            let arm = (body.center - center).as_vec3();
            // Gravity is the same pull on all but for what members' factors differ by.
            let excess = self.gravity * ((body.settings.gravity_scale - lead.settings.gravity_scale) * own.mass);
            force += body.force + excess;
            torque += body.torque + arm.cross(body.force + excess);
            let weight = own.mass * arm.length_squared() + own.principal_inertia.element_sum() / 3.0;
            decay += body.settings.linear_damping * own.mass;
            turning_decay += body.settings.angular_damping * weight;
            turning += weight;
        }
        let inertia = mass.principal_inertia;
        let inverse = crate::shape::inertia_tensor(1.0 / inertia, rotation * mass.inertia_frame);
        let at_rest = BodyVelocity::new(Vec3::splat(1.0 / mass.mass), Symmetric::from_mat3(inverse));
        let velocity = BodyVelocity { linear, angular, ..at_rest };
        let jointed = !union.outer.is_empty();
        let motion = BodyMotion {
            rotation,
            acceleration: self.gravity * lead.settings.gravity_scale + force / mass.mass,
            torque,
            linear_damping: decay / mass.mass,
            angular_damping: turning_decay / turning,
            inertia,
            inertia_frame: mass.inertia_frame,
            kind: if is_round(inertia) { MotionKind::Round } else { MotionKind::Tumbling },
            steady: lead.times.settling.is_steady(),
            young: lead.times.settling.is_young(),
            jointed,
            constraints: if jointed { Constraints::Holding } else { Constraints::None },
            driven: union.members.iter().any(|&member| self.driven.drives(member)),
            ..BodyMotion::FIXED
        };
        (velocity, motion)
    }

    pub(super) fn body_state(&self, index: u32) -> (BodyVelocity, BodyMotion) {
        let body = &self.bodies[index];
        let inverse_mass = body.inverse_mass() * crate::body::free_axes(body.settings.locked_axes.translation);
        let velocity = BodyVelocity {
            linear: body.linear_velocity,
            angular: body.angular_velocity,
            ..BodyVelocity::new(inverse_mass, Symmetric::from_mat3(body.world_inverse_inertia()))
        };
        let mass = body.mass.as_ref();
        let inertia = mass.map_or(Vec3::ONE, |mass| mass.principal_inertia);
        let [acceleration, torque] = match body.acts_as() {
            BodyKind::Dynamic => [self.gravity * body.settings.gravity_scale + body.force * body.inverse_mass(), body.torque],
            BodyKind::Kinematic => body.kinematic.path.as_ref().map_or([Vec3::ZERO; 2], |path| path.slope),
            BodyKind::Static => [Vec3::ZERO; 2],
        };
        let motion = BodyMotion {
            rotation: body.rotation,
            acceleration,
            torque,
            linear_damping: body.settings.linear_damping,
            angular_damping: body.settings.angular_damping,
            inertia,
            inertia_frame: mass.map_or(Quat::IDENTITY, |mass| mass.inertia_frame),
            locked_rotation: body.settings.locked_axes.rotation,
            kind: match body.acts_as() {
                BodyKind::Static => MotionKind::Fixed,
                BodyKind::Kinematic => MotionKind::Kinematic,
                BodyKind::Dynamic if is_round(inertia) => MotionKind::Round,
                BodyKind::Dynamic => MotionKind::Tumbling,
            },
            steady: body.times.settling.is_steady(),
            young: body.times.settling.is_young(),
            jointed: !body.joints.is_empty(),
            constraints: if body.joints.is_empty() { Constraints::None } else { Constraints::Holding },
            driven: self.driven.drives(index),
            ..BodyMotion::FIXED
        };
        (velocity, motion)
    }
}

/// Whether principal moments are so nearly equal that the body does not tumble.
fn is_round(inertia: Vec3) -> bool {
    inertia.max_element() - inertia.min_element() <= ROUND * inertia.max_element()
}
