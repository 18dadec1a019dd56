//! Queries about unions: which bodies rigid fixed joints make one, and how they move.

use glam::{DVec3, Vec3};

use super::World;
use super::unions::{Anchor, Union};
use crate::error::Result;
use crate::id::BodyId;

/// Bodies that rigid fixed joints make one, as the last step left them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnionInfo {
    /// Its dynamic body that was made first: it names the union while both last.
    pub lead: BodyId,
    /// Number of its dynamic bodies.
    pub members: u32,
    /// Number of fixed joints that it is made of.
    pub joints: u32,
    /// Mass of its dynamic bodies (kg).
    pub mass: f32,
    /// World position of their centre of mass (m).
    pub center: DVec3,
    /// Velocity of the centre of mass (m/s).
    pub linear_velocity: Vec3,
    /// Angular velocity (rad/s).
    pub angular_velocity: Vec3,
    /// Whether static or kinematic bodies, or the world, hold it.
    pub anchored: bool,
    /// Worst distance by which its joints contradict one another (m).
    pub distance_residual: f32,
    /// Worst angle by which its joints contradict one another (rad).
    pub angle_residual: f32,
}

impl World {
    /// The union that a dynamic body belongs to; `None` for a body of no union. Joints made or changed since the last step count
    /// from the next one on, and until then their bodies belong to no union.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn union_of(&self, body: BodyId) -> Result<Option<UnionInfo>> {
        let index = self.bodies.find(body)?;
        Ok(self.unions.of(index).map(|union| self.union_info(union)))
    }

    /// Dynamic bodies of the union that a body belongs to, by slot; none where it belongs to none.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn union_members(&self, body: BodyId) -> Result<impl ExactSizeIterator<Item = BodyId> + '_> {
        let index = self.bodies.find(body)?;
        let members = self.unions.of(index).map_or(&[][..], |union| &union.members);
        Ok(members.iter().map(|&member| self.bodies.handle_of(member)))
    }

    /// Every union, by lead.
    pub fn unions(&self) -> impl Iterator<Item = UnionInfo> + '_ {
        self.unions.iter().map(|union| self.union_info(union))
    }

    fn union_info(&self, union: &Union) -> UnionInfo {
        let lead = &self.bodies[union.lead];
        UnionInfo {
            lead: self.bodies.handle_of(union.lead),
            members: union.members.len() as u32,
            joints: union.fixed_links.len() as u32,
            mass: union.mass.mass,
            center: union.motion.center,
            // A sleeping body is at rest, whatever velocity it had when it fell asleep.
            linear_velocity: if lead.is_awake() { union.motion.linear } else { Vec3::ZERO },
            angular_velocity: if lead.is_awake() { union.motion.angular } else { Vec3::ZERO },
            anchored: union.anchor != Anchor::Free,
            distance_residual: union.residual.0,
            angle_residual: union.residual.1,
        }
    }
}
