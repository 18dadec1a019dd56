//! The door every engine comes through: a scene knows this trait and nothing else of who runs it.

use longspan::glam::Vec3;
use longspan::{BodyDef, BoundState, JointDef, MassProperties, Pose, SoftBound};

/// A physics engine that can run a scene: ours or a peer's.
pub trait Engine {
    /// Name that the command line and the results call it by.
    fn name(&self) -> &'static str;
    /// Creates a body; returns the scene's body index, counting from 0 in order of creation.
    fn add_body(&mut self, def: &BodyDef) -> usize;
    /// Takes a body out; indices of the others stay as they are.
    fn remove_body(&mut self, body: usize);
    /// Creates a joint; returns the scene's joint index, counting from 0 in order of creation.
    fn add_joint(&mut self, joint: &SceneJoint) -> usize;
    /// Stretches the chain between two joints towards its greatest length; nothing in an engine that cannot.
    fn add_soft_bound(&mut self, bound: &SceneSoftBound) {
        let _ = bound;
    }
    /// Advances by `dt` (s).
    fn step(&mut self, dt: f32);
    /// The body's own frame (not its centre of mass).
    fn pose(&self, body: usize) -> Pose;
    /// Velocity of the centre of mass (m/s).
    fn linear_velocity(&self, body: usize) -> Vec3;
    /// Angular velocity in world axes (rad/s).
    fn angular_velocity(&self, body: usize) -> Vec3;
    /// Sets the velocity of the centre of mass (m/s).
    fn set_linear_velocity(&mut self, body: usize, v: Vec3);
    /// Applies an impulse at the centre of mass (N·s).
    fn apply_impulse(&mut self, body: usize, impulse: Vec3);
    /// Force that the joint exerts on body B, mean over the last step (N), of an engine that reports it.
    fn joint_force(&self, joint: usize) -> Option<Vec3> {
        let _ = joint;
        None
    }
    /// Torque that the joint exerts on body B about its point, mean over the last step (N·m), of an engine that reports it.
    fn joint_torque(&self, joint: usize) -> Option<Vec3> {
        let _ = joint;
        None
    }
    /// Whether the joint is still there: `false` once it has broken, in an engine whose joints do.
    fn has_joint(&self, joint: usize) -> bool {
        let _ = joint;
        true
    }
    /// Net contact force on the body, mean over the last step (N), of an engine that reports it.
    fn contact_force(&self, body: usize) -> Option<Vec3> {
        let _ = body;
        None
    }
    /// Mass properties of a dynamic body as the engine holds them, of an engine that can be asked; checked against the scene's.
    fn mass_properties(&self, body: usize) -> Option<MassProperties> {
        let _ = body;
        None
    }
    /// Turns gravity (m/s²); `false` from an engine that cannot.
    fn set_gravity(&mut self, gravity: Vec3) -> bool {
        let _ = gravity;
        false
    }
    /// The first thing that the engine refused, with the name of the argument at fault.
    fn refusal(&self) -> Option<String> {
        None
    }
    /// Whether something holds the body up, of an engine that says so.
    fn is_supported(&self, body: usize) -> Option<bool> {
        let _ = body;
        None
    }
    /// Long-range bounds as the last step left them, of an engine that has them.
    fn bounds(&self) -> Vec<BoundState> {
        Vec::new()
    }
    /// Whether the body is simulated at present.
    fn is_awake(&self, body: usize) -> bool {
        let _ = body;
        true
    }
}

/// A joint between bodies of a scene. Body handles in `def` are null; `a` and `b` are scene indices, `None` is the world.
#[derive(Debug, Clone)]
pub struct SceneJoint {
    /// First body.
    pub a: Option<usize>,
    /// Second body.
    pub b: Option<usize>,
    /// Everything but the bodies.
    pub def: JointDef,
}

/// A soft bound between two joints of a scene.
#[derive(Debug, Clone, Copy)]
pub struct SceneSoftBound {
    /// The two joints.
    pub joints: [usize; 2],
    /// What is asked for.
    pub bound: SoftBound,
}

/// How much work an engine does a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// What a user gets who sets nothing.
    Default,
    /// This many substeps (collision steps for an engine without substeps).
    N(u32),
}
