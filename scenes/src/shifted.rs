//! An engine seen from another origin: the same scene far away, with nothing in the scene or its metrics aware of it.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BoundState, MassProperties, Pose};

use crate::engine::{Engine, SceneJoint, SceneSoftBound};

/// Wraps an engine so that everything in it lies `origin` (m) away from where the scene says.
pub struct Shifted<'a> {
    /// The engine.
    pub engine: &'a mut dyn Engine,
    /// Where the scene's origin lies in the engine's world (m).
    pub origin: DVec3,
}

impl Shifted<'_> {
    fn outwards(&self, pose: Pose) -> Pose {
        Pose { position: pose.position + self.origin, ..pose }
    }
}

impl Engine for Shifted<'_> {
    fn name(&self) -> &'static str {
        self.engine.name()
    }

    fn add_body(&mut self, def: &BodyDef) -> usize {
        let shifted = BodyDef { pose: self.outwards(def.pose), ..def.clone() };
        self.engine.add_body(&shifted)
    }

    fn remove_body(&mut self, body: usize) {
        self.engine.remove_body(body);
    }

    fn add_joint(&mut self, joint: &SceneJoint) -> usize {
        let mut shifted = joint.clone();
        if joint.a.is_none() {
            shifted.def.frame_a = self.outwards(joint.def.frame_a);
        }
        if joint.b.is_none() {
            shifted.def.frame_b = self.outwards(joint.def.frame_b);
        }
        self.engine.add_joint(&shifted)
    }

    fn add_soft_bound(&mut self, bound: &SceneSoftBound) {
        self.engine.add_soft_bound(bound);
    }

    fn step(&mut self, dt: f32) {
        self.engine.step(dt);
    }

    fn pose(&self, body: usize) -> Pose {
        let pose = self.engine.pose(body);
        Pose { position: pose.position - self.origin, ..pose }
    }

    fn linear_velocity(&self, body: usize) -> Vec3 {
        self.engine.linear_velocity(body)
    }

    fn angular_velocity(&self, body: usize) -> Vec3 {
        self.engine.angular_velocity(body)
    }

    fn set_linear_velocity(&mut self, body: usize, v: Vec3) {
        self.engine.set_linear_velocity(body, v);
    }

    fn apply_impulse(&mut self, body: usize, impulse: Vec3) {
        self.engine.apply_impulse(body, impulse);
    }

    fn joint_force(&self, joint: usize) -> Option<Vec3> {
        self.engine.joint_force(joint)
    }

    fn joint_torque(&self, joint: usize) -> Option<Vec3> {
        self.engine.joint_torque(joint)
    }

    fn has_joint(&self, joint: usize) -> bool {
        self.engine.has_joint(joint)
    }

    fn contact_force(&self, body: usize) -> Option<Vec3> {
        self.engine.contact_force(body)
    }

    fn mass_properties(&self, body: usize) -> Option<MassProperties> {
        self.engine.mass_properties(body)
    }

    fn set_gravity(&mut self, gravity: Vec3) -> bool {
        self.engine.set_gravity(gravity)
    }

    fn refusal(&self) -> Option<String> {
        self.engine.refusal()
    }

    fn is_supported(&self, body: usize) -> Option<bool> {
        self.engine.is_supported(body)
    }

    fn bounds(&self) -> Vec<BoundState> {
        self.engine.bounds()
    }

    fn is_awake(&self, body: usize) -> bool {
        self.engine.is_awake(body)
    }
}
