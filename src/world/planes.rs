//! Reads the planes of hinge chains.

use glam::{DVec3, Quat, Vec3};

use super::World;
use crate::joint_graph::plane::{Chain, Member, PlaneAnchor};
use crate::long_range::PlaneState;

/// A member in the world: mass (kg), centre of mass (m), and the plane's normal as this member has it.
struct PlacedMember {
    mass: f64,
    center: DVec3,
    normal: Vec3,
    /// Centre of mass moved back by its height: in the plane, were it exact.
    foot: DVec3,
}

impl World {
    /// The plane of every hinge chain that was derived for the last step, by its lowest joint.
    pub fn planes(&self) -> impl Iterator<Item = PlaneState> + '_ {
        self.long_range.chains.iter().filter_map(|chain| self.plane_state(chain))
    }

    fn plane_state(&self, chain: &Chain) -> Option<PlaneState> {
        // A joint or body that went since the step takes its chain with it.
        let members: Vec<PlacedMember> = chain.members.iter().map(|member| self.placed(member)).collect::<Option<_>>()?;
        let joint = *chain.joints.first()?;
        self.joints.get(joint)?;
        let held = match chain.anchor {
            Some(anchor) => Some(self.plane_of_anchor(anchor)?),
            None => None,
        };
        let mass: f64 = members.iter().map(|member| member.mass).sum();
        let mean = members.iter().map(|member| member.normal * (member.mass / mass) as f32).sum::<Vec3>();
        let middle = members.iter().map(|member| member.foot * (member.mass / mass)).sum::<DVec3>();
        let normal = held.map_or(mean, |(_, normal)| normal).try_normalize()?;
        let across = normal.as_dvec3();
        let point = held.map_or(middle, |(on_it, _)| middle - across * across.dot(middle - on_it));
        let off = members.iter().map(|member| across.dot(member.foot - point).powi(2)).sum::<f64>();
        Some(PlaneState {
            joint: self.joints.handle_of(joint),
            members: members.len() as u32,
            point,
            normal,
            radius: members.iter().map(|member| member.center.distance(point)).fold(0.0, f64::max) as f32,
            deviation: (off / members.len() as f64).sqrt() as f32,
            anchored: held.is_some(),
        })
    }

    fn placed(&self, member: &Member) -> Option<PlacedMember> {
        let body = self.bodies.get(member.body)?;
        let (center, rotation, mass) = match self.unions.moving(member.body) {
            Some(union) => (union.motion.center, union.motion.rotation, union.mass.mass),
            None => (body.center, body.rotation, body.mass.as_ref()?.mass),
        };
        let normal = rotation * member.axis;
        Some(PlacedMember { mass: mass.into(), center, normal, foot: center - (normal * member.height).as_dvec3() })
    }

    /// A point of the plane that a fixed end gives, and the plane's normal.
    fn plane_of_anchor(&self, anchor: PlaneAnchor) -> Option<(DVec3, Vec3)> {
        let (joint, side) = (self.joints.get(anchor.end.0)?, usize::from(anchor.end.1));
        let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
        let turned = match joint.bodies[side] {
            Some(body) => self.bodies.get(body)?.rotation,
            None => Quat::IDENTITY,
        };
        let normal = turned * frame.rotation * Vec3::X * anchor.sign;
        Some((self.joint_point(joint, side) - (normal * anchor.height).as_dvec3(), normal))
    }
}
