//! Changes settings of a live world: geometry of shapes, frames of joints, effort, sleep.

use glam::Vec3;

use super::World;
use super::wake::Edited;
use crate::body::BodyKind;
use crate::check;
use crate::error::Result;
use crate::id::{BodyId, JointId, ShapeId};
use crate::joint::JointDef;
use crate::pose::Pose;
use crate::settings::{ArticulationSettings, SleepSettings, WorldDef};
use crate::shape::{self, ShapeDef};

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
            Some(shape::resolve_mass(self.bodies[index].settings.mass_source, &defs)?)
        } else {
            None
        };
        self.wake_for(Edited::Place(index));
        self.forget_contacts_of(index);
        self.colliders[slot].redefine(&def, self.bodies[index].local_center);
        self.collision.sensing.note(slot, def.sensor);
        self.apply_mass(index, mass);
        self.refresh_boxes(index);
        self.wake_for(Edited::Place(index));
        self.note_mover(index);
        Ok(())
    }

    /// Makes a body static, kinematic or dynamic, and wakes it and what it touches. A body that becomes static stops; one that
    /// becomes dynamic has the mass that it was made with or given. A joint that is left without a dynamic body is idle until it has one again.
    ///
    /// # Errors
    /// The handle is not a body of this world; a shape of the body cannot be on a dynamic one, or it would have no mass.
    pub fn set_body_kind(&mut self, body: BodyId, kind: BodyKind) -> Result<()> {
        let index = self.bodies.find(body)?;
        if self.bodies[index].kind == kind {
            return Ok(());
        }
        let mass = if kind == BodyKind::Dynamic {
            let defs = self.shape_defs(index);
            let defs = defs.into_iter().map(|def| def.checked(true)).collect::<Result<Vec<_>>>()?;
            Some(shape::resolve_mass(self.bodies[index].settings.mass_source, &defs)?)
        } else {
            None
        };
        self.wake_for(Edited::Place(index));
        self.forget_contacts_of(index);
        self.forget_joints_of(index);
        let record = &mut self.bodies[index];
        record.kind = kind;
        (record.kinematic.driven, record.kinematic.path) = (false, None);
        record.times.settling.put();
        record.history.forget();
        if kind == BodyKind::Static {
            (record.linear_velocity, record.angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
        }
        if kind != BodyKind::Dynamic {
            (record.force, record.torque) = (Vec3::ZERO, Vec3::ZERO);
            record.held = false;
        }
        record.stop_along_locked_axes();
        self.collision.index.forget_force(index);
        self.apply_mass(index, mass);
        self.topology_changed();
        self.long_range.graph_changed();
        self.welds_changed(index);
        for joint in self.bodies[index].joints.clone() {
            if let Ok(slot) = self.joints.find(joint) {
                self.joint_changed(slot);
            }
        }
        self.refresh_boxes(index);
        self.wake_for(Edited::Place(index));
        self.note_mover(index);
        self.movers.are_sorted = false;
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

    /// Gives a joint other frames on its bodies (in world coordinates where the body is the world) and wakes them.
    ///
    /// Frames that are moved in step after step carry the speed that they move with, as a kinematic body would. A frame that is put
    /// somewhere else by a single edit has none: the joint starts from nothing, as after a teleport.
    ///
    /// # Errors
    /// The handle is not a joint of this world; a frame is not finite, too far out, or not a rotation.
    pub fn set_joint_frames(&mut self, joint: JointId, frame_a: Pose, frame_b: Pose) -> Result<()> {
        let slot = self.joints.find(joint)?;
        let def = JointDef { frame_a, frame_b, ..self.joints[slot].def }.checked()?;
        self.change_joint(slot, |old| *old = def);
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

    /// Sets how much work articulations may take, from the next step on.
    ///
    /// # Errors
    /// A setting is out of range or not finite.
    pub fn set_articulation_settings(&mut self, settings: ArticulationSettings) -> Result<()> {
        self.change_def(|def| def.articulations = settings)
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
        check::not_negative("speed", speed)?;
        self.change_def(|def| def.restitution_threshold = speed)
    }

    /// Sets the approach speed above which contacts are listed as hits (m/s), ≥ 0; infinity for never.
    ///
    /// # Errors
    /// The speed is negative or NaN.
    pub fn set_hit_threshold(&mut self, speed: f32) -> Result<()> {
        check::bound("speed", speed)?;
        self.change_def(|def| def.hit_threshold = speed)
    }

    fn change_def(&mut self, edit: impl FnOnce(&mut WorldDef)) -> Result<()> {
        let mut def = self.def;
        edit(&mut def);
        def.check()?;
        self.def = def;
        Ok(())
    }
}
