//! Our engine behind the scenes' trait.

use longspan::glam::Vec3;
use longspan::{BodyDef, BodyId, BoundState, JointId, MassProperties, Pose, Result, World, WorldDef};

use crate::engine::{Effort, Engine, SceneJoint, SceneSoftBound};
use crate::run::{RunError, run};
use crate::scene::Scene;

/// A [`World`], its handles in order of creation, and the first call that it refused.
pub struct LongspanEngine {
    world: World,
    bodies: Vec<BodyId>,
    joints: Vec<JointId>,
    refusal: Option<longspan::Error>,
    quarantined: usize,
}

impl LongspanEngine {
    /// A world as `def` says, but with this effort and this many threads.
    ///
    /// # Errors
    /// What [`World::new`] refuses.
    pub fn new(def: &WorldDef, effort: Effort, threads: usize) -> Result<Self> {
        let mut def = *def;
        def.threads = threads as u32;
        if let Effort::N(substeps) = effort {
            def.substeps = substeps;
        }
        Ok(Self { world: World::new(&def)?, bodies: Vec::new(), joints: Vec::new(), refusal: None, quarantined: 0 })
    }

    /// A world with everything that a scene begins with, on one thread; what the scene's script does later is left to the caller.
    ///
    /// # Errors
    /// What [`World::new`] refuses, or the first body, joint or bound that the world refuses.
    pub fn start(scene: &Scene) -> Result<Self> {
        let mut engine = Self::new(&scene.world, Effort::Default, 1)?;
        for body in &scene.bodies {
            engine.add_body(body);
        }
        for joint in &scene.joints {
            engine.add_joint(joint);
        }
        for bound in &scene.soft_bounds {
            engine.add_soft_bound(bound);
        }
        match engine.refusal.take() {
            Some(refusal) => Err(refusal),
            None => Ok(engine),
        }
    }

    /// Runs a scene to its end, on one thread, and returns the world as it is then, for hosts that build no scenes themselves:
    /// [`World::restore`] and `ls_world_restore` read it.
    ///
    /// # Errors
    /// If the scene is refused.
    pub fn snapshot(scene: Scene) -> std::result::Result<Vec<u8>, RunError> {
        let refused = |problem: longspan::Error| RunError::Refused { engine: "longspan", problem: problem.to_string() };
        let mut engine = Self::new(&scene.world, Effort::Default, 1).map_err(refused)?;
        run(scene, &mut engine, Effort::Default, 1)?;
        let mut bytes = Vec::new();
        engine.world.save(&mut bytes);
        Ok(bytes)
    }

    /// The world behind the trait.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world behind the trait, to edit.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// The world's handle of a scene's body.
    pub fn body_id(&self, body: usize) -> BodyId {
        self.bodies[body]
    }

    /// The world's handle of a scene's joint.
    pub fn joint_id(&self, joint: usize) -> JointId {
        self.joints[joint]
    }

    /// How often a body has left the simulation because its state was no number.
    pub fn quarantined(&self) -> usize {
        self.quarantined
    }

    fn note<T>(&mut self, result: Result<T>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.refusal.get_or_insert(error);
                None
            }
        }
    }
}

const HELD: &str = "the scene asks only for bodies that it created and did not remove";

impl Engine for LongspanEngine {
    fn name(&self) -> &'static str {
        "longspan"
    }

    fn add_body(&mut self, def: &BodyDef) -> usize {
        let created = self.world.create_body(def);
        let id = self.note(created).unwrap_or(BodyId::NULL);
        self.bodies.push(id);
        self.bodies.len() - 1
    }

    fn remove_body(&mut self, body: usize) {
        let removed = self.world.destroy_body(self.bodies[body]);
        self.note(removed);
    }

    fn add_joint(&mut self, joint: &SceneJoint) -> usize {
        let id_of = |side: Option<usize>| side.map_or(BodyId::NULL, |body| self.bodies[body]);
        let mut def = joint.def;
        def.body_a = id_of(joint.a);
        def.body_b = id_of(joint.b);
        let created = self.world.create_joint(&def);
        let id = self.note(created).unwrap_or(JointId::NULL);
        self.joints.push(id);
        self.joints.len() - 1
    }

    fn add_soft_bound(&mut self, bound: &SceneSoftBound) {
        let [a, b] = bound.joints.map(|joint| self.joints[joint]);
        let set = self.world.set_soft_bound(a, b, Some(bound.bound));
        self.note(set);
    }

    fn step(&mut self, dt: f32) {
        if let Err(error) = self.world.step(dt) {
            self.refusal.get_or_insert(error);
        }
        self.quarantined += self.world.quarantined().len();
    }

    fn pose(&self, body: usize) -> Pose {
        self.world.pose(self.bodies[body]).expect(HELD)
    }

    fn linear_velocity(&self, body: usize) -> Vec3 {
        self.world.linear_velocity(self.bodies[body]).expect(HELD)
    }

    fn angular_velocity(&self, body: usize) -> Vec3 {
        self.world.angular_velocity(self.bodies[body]).expect(HELD)
    }

    fn set_linear_velocity(&mut self, body: usize, v: Vec3) {
        let set = self.world.set_linear_velocity(self.bodies[body], v);
        self.note(set);
    }

    fn apply_impulse(&mut self, body: usize, impulse: Vec3) {
        let applied = self.world.add_impulse(self.bodies[body], impulse);
        self.note(applied);
    }

    fn joint_force(&self, joint: usize) -> Option<Vec3> {
        self.world.joint_state(self.joints[joint]).ok().map(|state| state.force)
    }

    fn joint_torque(&self, joint: usize) -> Option<Vec3> {
        self.world.joint_state(self.joints[joint]).ok().map(|state| state.torque)
    }

    fn has_joint(&self, joint: usize) -> bool {
        self.world.joint_def(self.joints[joint]).is_ok()
    }

    fn contact_force(&self, body: usize) -> Option<Vec3> {
        self.world.contact_force(self.bodies[body]).ok()
    }

    fn mass_properties(&self, body: usize) -> Option<MassProperties> {
        self.world.mass_properties(self.bodies[body]).ok().flatten()
    }

    fn set_gravity(&mut self, gravity: Vec3) -> bool {
        let set = self.world.set_gravity(gravity);
        self.note(set).is_some()
    }

    fn refusal(&self) -> Option<String> {
        self.refusal.map(|error| error.to_string())
    }

    fn is_supported(&self, body: usize) -> Option<bool> {
        self.world.support(self.bodies[body]).ok().map(|support| support.verdict.is_supported())
    }

    fn bounds(&self) -> Vec<BoundState> {
        self.world.bounds().collect()
    }

    fn is_awake(&self, body: usize) -> bool {
        self.world.is_awake(self.bodies[body]).unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use longspan::{World, WorldDef};

    use super::*;
    use crate::DT;
    use crate::catalogue::build;

    #[test]
    fn a_scene_goes_on_in_another_world_to_the_last_bit() {
        // The script of this one adds a ball after 0.1 s, which hits the tower 0.2 s later.
        let keys = |seconds: &str| {
            let given = [("bodies", "120"), ("stand", "0.1"), ("seconds", seconds)];
            given.map(|(key, value)| (key.to_owned(), value.to_owned()))
        };
        let early = LongspanEngine::snapshot(build("tower", &keys("0.2")).unwrap()).unwrap();
        let late = LongspanEngine::snapshot(build("tower", &keys("0.5")).unwrap()).unwrap();
        let [mut going_on, mut there] = [(); 2].map(|()| World::new(&WorldDef::default()).unwrap());
        going_on.restore(&early).unwrap();
        for _ in 0..18 {
            going_on.step(DT).unwrap();
        }
        there.restore(&late).unwrap();
        assert_eq!(going_on.state_hash(), there.state_hash());
    }
}
