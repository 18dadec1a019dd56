//! Changing what a live world was made with: forms of shapes, frames of joints, effort, sleep.

use super::World;
use crate::body::BodyKind;
use crate::error::Result;
use crate::id::{JointId, ShapeId};
use crate::joint::JointDef;
use crate::mass;
use crate::pose::Pose;
use crate::settings::{SleepSettings, WorldDef};
use crate::shape::ShapeDef;
use crate::solve::direct::history::History;

impl World {
    /// The shape's definition as it is now.
    ///
    /// # Errors
    /// The handle is not a shape of this world.
    pub fn shape_def(&self, shape: ShapeId) -> Result<ShapeDef> {
        Ok(self.colliders[self.colliders.find(shape)?].def())
    }

    /// Gives a shape another definition: form, place, surface, density, filter and word. Its handle stays, the body's mass
    /// follows unless it was set outright, and what touched it wakes.
    ///
    /// # Errors
    /// The handle is not a shape of this world; a field of `def` is out of range; the form cannot be on a dynamic body; a
    /// dynamic body would have no mass.
    pub fn set_shape_def(&mut self, shape: ShapeId, def: &ShapeDef) -> Result<()> {
        let slot = self.colliders.find(shape)?;
        let index = self.colliders[slot].body;
        let dynamic = self.bodies[index].kind == BodyKind::Dynamic;
        let def = def.clone().checked(dynamic)?;
        let mass = if dynamic {
            let mut defs = self.shape_defs(index);
            if let Some(place) = self.bodies[index].shapes.iter().position(|&id| id == shape) {
                defs[place] = def.clone();
            }
            Some(mass::resolve(self.bodies[index].mass_source, &defs)?)
        } else {
            None
        };
        self.wake_body(index);
        self.wake_around(index);
        self.forget_contacts_of(index);
        self.colliders[slot].redefine(&def, self.bodies[index].local_center);
        self.apply_mass(index, mass);
        self.refresh_boxes(index);
        self.wake_around(index);
        self.note_mover(index);
        Ok(())
    }

    /// The host's own word on the shape.
    ///
    /// # Errors
    /// The handle is not a shape of this world.
    pub fn set_shape_user_word(&mut self, shape: ShapeId, word: u64) -> Result<()> {
        let slot = self.colliders.find(shape)?;
        self.colliders[slot].user_word = word;
        Ok(())
    }

    /// Gives a joint other frames on its bodies (in world coordinates where the body is the world) and wakes them; the joint
    /// starts from nothing, as after a teleport.
    ///
    /// # Errors
    /// The handle is not a joint of this world; a frame is not finite, too far out, or not a rotation.
    pub fn set_joint_frames(&mut self, joint: JointId, frame_a: Pose, frame_b: Pose) -> Result<()> {
        let slot = self.joints.find(joint)?;
        let def = JointDef { frame_a, frame_b, ..self.joints[slot].def }.checked()?;
        self.joints[slot].forget_impulses();
        self.joints[slot].def = def;
        self.joint_changed(slot);
        self.topology_changed();
        self.long_range.graph_changed();
        for index in self.joints[slot].bodies.into_iter().flatten() {
            self.bodies[index].history = History::NONE;
            self.wake_body(index);
        }
        Ok(())
    }

    /// The host's own word on the joint.
    ///
    /// # Errors
    /// The handle is not a joint of this world.
    pub fn set_joint_user_word(&mut self, joint: JointId, word: u64) -> Result<()> {
        let slot = self.joints.find(joint)?;
        self.joints[slot].def.user_word = word;
        Ok(())
    }

    /// Sets the substeps of a step and the sweeps of a substep, each 1 to 256, from the next step on.
    ///
    /// # Errors
    /// Either is out of range.
    pub fn set_effort(&mut self, substeps: u32, iterations: u32) -> Result<()> {
        self.change_def(|def| (def.substeps, def.iterations) = (substeps, iterations))
    }

    /// Sets when bodies fall asleep; if they no longer may, all wake.
    ///
    /// # Errors
    /// A limit is negative or not finite.
    pub fn set_sleep_settings(&mut self, sleep: SleepSettings) -> Result<()> {
        self.change_def(|def| def.sleep = sleep)?;
        if !sleep.enabled {
            self.wake_all();
        }
        Ok(())
    }

    /// Sets the approach speed above which contacts rebound (m/s), ≥ 0.
    ///
    /// # Errors
    /// The speed is negative or not finite.
    pub fn set_restitution_threshold(&mut self, speed: f32) -> Result<()> {
        self.change_def(|def| def.restitution_threshold = speed)
    }

    fn change_def(&mut self, edit: impl FnOnce(&mut WorldDef)) -> Result<()> {
        let mut def = self.def;
        edit(&mut def);
        def.check()?;
        self.def = def;
        Ok(())
    }
}
