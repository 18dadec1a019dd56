//! Reading bodies and shapes.

use glam::{DVec3, Vec3};

use super::World;
use crate::body::{BodyKind, LockedAxes};
use crate::error::{Error, ErrorKind, Result};
use crate::id::{BodyId, JointId, ShapeId};
use crate::mass::MassProperties;
use crate::material::Material;
use crate::pose::Pose;
use crate::shape::CollisionFilter;

/// Every getter here fails only if its handle is not an object of this world.
impl World {
    /// Number of bodies.
    pub fn body_count(&self) -> usize {
        self.bodies.len()
    }

    /// Number of shapes.
    pub fn shape_count(&self) -> usize {
        self.colliders.len()
    }

    /// Number of joints.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Number of dynamic bodies awake.
    pub fn awake_body_count(&self) -> usize {
        self.bodies.iter().filter(|(_, body)| body.is_dynamic() && body.is_mover()).count()
    }

    /// Every body, by slot.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> + '_ {
        self.bodies.iter().map(|(slot, _)| self.bodies.handle_of(slot))
    }

    /// How the body moves.
    pub fn body_kind(&self, body: BodyId) -> Result<BodyKind> {
        Ok(self.bodies[self.bodies.find(body)?].kind)
    }

    /// The body's frame.
    pub fn pose(&self, body: BodyId) -> Result<Pose> {
        Ok(self.bodies[self.bodies.find(body)?].pose())
    }

    /// The frames of many bodies at once.
    ///
    /// # Errors
    /// `out` is not as long as `ids`, or a handle is not a body of this world; nothing is written then.
    pub fn poses_into(&self, ids: &[BodyId], out: &mut [Pose]) -> Result<()> {
        if ids.len() != out.len() {
            return Err(Error::new(ErrorKind::OutOfRange, "out", "is not as long as the list of bodies"));
        }
        for &id in ids {
            self.bodies.find(id)?;
        }
        for (&id, pose) in ids.iter().zip(out) {
            *pose = self.pose(id)?;
        }
        Ok(())
    }

    /// World position of the centre of mass (m).
    pub fn center_of_mass(&self, body: BodyId) -> Result<DVec3> {
        Ok(self.bodies[self.bodies.find(body)?].center)
    }

    /// Mass properties; `None` for bodies that are not dynamic.
    pub fn mass_properties(&self, body: BodyId) -> Result<Option<MassProperties>> {
        Ok(self.bodies[self.bodies.find(body)?].mass)
    }

    /// Velocity of the centre of mass (m/s).
    pub fn linear_velocity(&self, body: BodyId) -> Result<Vec3> {
        Ok(self.bodies[self.bodies.find(body)?].linear_velocity)
    }

    /// Angular velocity (rad/s).
    pub fn angular_velocity(&self, body: BodyId) -> Result<Vec3> {
        Ok(self.bodies[self.bodies.find(body)?].angular_velocity)
    }

    /// The host's word on the body.
    pub fn user_word(&self, body: BodyId) -> Result<u64> {
        Ok(self.bodies[self.bodies.find(body)?].settings.user_word)
    }

    /// Rates at which linear and angular velocity decay (1/s).
    pub fn damping(&self, body: BodyId) -> Result<(f32, f32)> {
        let body = &self.bodies[self.bodies.find(body)?];
        Ok((body.settings.linear_damping, body.settings.angular_damping))
    }

    /// Factor on the world's gravity.
    pub fn gravity_scale(&self, body: BodyId) -> Result<f32> {
        Ok(self.bodies[self.bodies.find(body)?].settings.gravity_scale)
    }

    /// Degrees of freedom taken away.
    pub fn locked_axes(&self, body: BodyId) -> Result<LockedAxes> {
        Ok(self.bodies[self.bodies.find(body)?].settings.locked_axes)
    }

    /// Whether the body is swept through each step.
    pub fn is_fast(&self, body: BodyId) -> Result<bool> {
        Ok(self.bodies[self.bodies.find(body)?].settings.fast)
    }

    /// Whether the body may fall asleep.
    pub fn can_sleep(&self, body: BodyId) -> Result<bool> {
        Ok(self.bodies[self.bodies.find(body)?].settings.can_sleep)
    }

    /// The body's shapes, in the order they were attached.
    pub fn body_shapes(&self, body: BodyId) -> Result<&[ShapeId]> {
        Ok(&self.bodies[self.bodies.find(body)?].shapes)
    }

    /// The body's joints, in the order they were made.
    pub fn body_joints(&self, body: BodyId) -> Result<&[JointId]> {
        Ok(&self.bodies[self.bodies.find(body)?].joints)
    }

    /// The body that a shape is on.
    pub fn shape_body(&self, shape: ShapeId) -> Result<BodyId> {
        Ok(self.bodies.handle_of(self.colliders[self.colliders.find(shape)?].body))
    }

    /// The shape's surface.
    pub fn material(&self, shape: ShapeId) -> Result<Material> {
        Ok(self.colliders[self.colliders.find(shape)?].material)
    }

    /// Whether the shape only tells what it overlaps.
    pub fn is_sensor(&self, shape: ShapeId) -> Result<bool> {
        Ok(self.colliders[self.colliders.find(shape)?].sensor)
    }

    /// What the shape collides with.
    pub fn filter(&self, shape: ShapeId) -> Result<CollisionFilter> {
        Ok(self.colliders[self.colliders.find(shape)?].filter)
    }

    /// The host's word on the shape.
    pub fn shape_user_word(&self, shape: ShapeId) -> Result<u64> {
        Ok(self.colliders[self.colliders.find(shape)?].user_word)
    }

    /// Numbers that differ whenever bodies, shapes, joints or unions have come or gone; nothing else can be told from them.
    pub fn structure_version(&self) -> [u64; 4] {
        [self.bodies.version(), self.colliders.version(), self.joints.version(), self.unions.version]
    }

    /// Numbers that differ whenever the [`state_hash`](Self::state_hash) may have changed; nothing else can be told from them.
    pub fn state_version(&self) -> [u64; 2] {
        self.bodies.changes()
    }

    /// Hash of the poses and velocities of all bodies, bit for bit, by their slots in order.
    ///
    /// Words of 64 bits go into four lanes that are joined at the end, not bytes into one: a body costs a few nanoseconds,
    /// so that a host can afford it after every step.
    pub fn state_hash(&self) -> u64 {
        const PRIME: u64 = 0x0000_0100_0000_01b3;
        let mix = |hash: u64, word: u64| (hash ^ word ^ (word >> 32)).wrapping_mul(PRIME).rotate_left(23);
        let pair = |a: f32, b: f32| u64::from(a.to_bits()) << 32 | u64::from(b.to_bits());
        let mut lanes = [0xcbf2_9ce4_8422_2325_u64; 4];
        for (slot, body) in self.bodies.iter() {
            let (center, rotation) = (body.center.to_array().map(f64::to_bits), body.rotation.to_array());
            let (linear, angular) = (body.linear_velocity.to_array(), body.angular_velocity.to_array());
            let words = [
                [u64::from(slot), center[0], center[1], center[2]],
                [pair(rotation[0], rotation[1]), pair(rotation[2], rotation[3]), pair(linear[0], linear[1]), 0],
                [pair(linear[2], angular[0]), pair(angular[1], angular[2]), 0, 0],
            ];
            for four in words {
                for (lane, word) in lanes.iter_mut().zip(four) {
                    *lane = mix(*lane, word);
                }
            }
        }
        lanes.into_iter().fold(0, mix)
    }
}
