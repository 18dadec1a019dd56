//! Builds a union: the bodies that fixed joints connect, the poses that satisfy them, and its mass.

use std::sync::OnceLock;

use glam::DQuat;

use super::{Anchor, Union, can_join, frame_of};
use crate::body::{Anchored, BodyKind};
use crate::joint_graph::union::matching::Covariances;
use crate::joint_graph::union::{Compound, FixedLink, Pose64, RestState, UnionMotion};
use crate::mass::MassProperties;
use crate::snapshot::carried::CarriedUnion;
use crate::world::World;
use crate::world::union_loads::wants_load;

/// Dynamic members, anchors and fixed joints reached from one body.
#[derive(Debug, Default)]
pub(super) struct Component {
    pub members: Vec<u32>,
    anchors: Vec<u32>,
    fixed_links: Vec<u32>,
    /// Whether a joint holds it to the world itself.
    to_world: bool,
}

impl World {
    /// What fixed joints connect to a body, not through anchors.
    pub(super) fn component(&self, start: u32) -> Component {
        let mut component = Component::default();
        let mut seen = std::collections::BTreeSet::from([start]);
        let mut next = vec![start];
        while let Some(index) = next.pop() {
            component.members.push(index);
            for slot in self.bodies[index].joints.iter().filter_map(|&id| self.joints.find(id).ok()) {
                let joint = &self.joints[slot];
                if !self.is_weld(slot) {
                    continue;
                }
                let other = if joint.bodies[0] == Some(index) { joint.bodies[1] } else { joint.bodies[0] };
                match other {
                    None => component.to_world = true,
                    Some(other) if can_join(&self.bodies[other]) => {
                        if seen.insert(other) {
                            next.push(other);
                        }
                    }
                    Some(other) if !self.bodies[other].is_dynamic() => component.anchors.push(other),
                    Some(_) => continue,
                }
                component.fixed_links.push(slot);
            }
        }
        for list in [&mut component.members, &mut component.anchors, &mut component.fixed_links] {
            list.sort_unstable();
            list.dedup();
        }
        component
    }

    /// Makes a union of a component, where it is one; `carried` is the motion that it is known to have.
    pub(super) fn form(&mut self, component: Component, carried: Option<&CarriedUnion>) {
        let Component { members, anchors, fixed_links, to_world } = component;
        let driven = anchors.iter().any(|&index| self.bodies[index].kind == BodyKind::Kinematic);
        let anchor = match (&anchors[..], to_world) {
            ([], false) => Anchor::Free,
            ([only], false) if driven => Anchor::Driven(*only),
            _ if !driven => Anchor::Still,
            // Two things hold it that may move against each other: joints between bodies say what comes of it.
            _ => return,
        };
        if members.len() < 2 && anchor == Anchor::Free {
            return;
        }
        let rest = self.rest_state(&members, &anchors, &fixed_links, anchor);
        let frames = if anchor == Anchor::Free { &rest.frames[..] } else { &rest.frames[1..] };
        let masses: Vec<MassProperties> = members.iter().filter_map(|&index| self.bodies[index].mass).collect();
        let compound = Compound::new(frames, &masses);
        let wanted = fixed_links.iter().any(|&slot| wants_load(&self.joints[slot].def));
        let (inner, outer) = self.other_joints(&members, &fixed_links);
        let union = Union {
            lead: members[0],
            anchor,
            covariances: Covariances::new(&masses, &compound.places),
            held: Pose64 { position: compound.center, rotation: DQuat::IDENTITY },
            outer,
            inner,
            mass: compound.mass,
            residual: (rest.residual.0 as f32, rest.residual.1 as f32),
            motion: carried.map_or(UnionMotion::ORIGIN, |carried| carried.motion),
            before: carried.and_then(|carried| carried.before),
            members,
            anchors,
            fixed_links,
            wanted,
            pushes: Vec::new(),
            jolts: Vec::new(),
            stiffness: OnceLock::new(),
            loads: OnceLock::new(),
        };
        let members = union.members.clone();
        self.unions.insert(union, &compound.places);
        if carried.is_some() {
            return;
        }
        if anchor == Anchor::Free {
            self.begin_free(members[0]);
            return;
        }
        self.set_anchored(&members, if anchor == Anchor::Still { Anchored::Still } else { Anchored::Driven });
        self.put_anchored(members[0]);
    }

    /// Poses that satisfy all welds: of the anchor first, where there is one, then of the members, from centres of mass; further
    /// anchors follow.
    fn rest_state(&self, members: &[u32], anchors: &[u32], fixed_links: &[u32], anchor: Anchor) -> RestState {
        let base = self.frame_of_anchor(anchors);
        let shift = u32::from(anchor != Anchor::Free);
        let number = |index: u32| members.binary_search(&index).ok().map(|place| place as u32 + shift);
        let mut list = Vec::with_capacity(fixed_links.len());
        for &slot in fixed_links {
            let joint = &self.joints[slot];
            let end = |side: usize| {
                let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
                let own = Pose64 { position: frame.position, rotation: frame.rotation.as_dquat().normalize() };
                match joint.bodies[side] {
                    Some(index) if self.bodies[index].is_dynamic() => {
                        let center = self.bodies[index].local_center.as_dvec3();
                        (number(index), Pose64 { position: own.position - center, ..own })
                    }
                    // In the frame of the first anchor, without a detour through the world: a moving one would leave other bits of it
                    // wherever the union is formed, and a restored world would part from the one that was saved.
                    Some(index) if anchors.first() == Some(&index) => (Some(0), own),
                    // All that is static has that frame.
                    Some(index) => (Some(0), base.inverse().then(&frame_of(&self.bodies[index]).then(&own))),
                    None => (Some(0), base.inverse().then(&own)),
                }
            };
            let ((a, frame_a), (b, frame_b)) = (end(0), end(1));
            if let (Some(a), Some(b)) = (a, b) {
                list.push(FixedLink { members: [a, b], frames: [frame_a, frame_b] });
            }
        }
        RestState::conform(members.len() + shift as usize, &list)
    }

    pub(super) fn frame_of_anchor(&self, anchors: &[u32]) -> Pose64 {
        anchors.first().map_or(Pose64::IDENTITY, |&index| frame_of(&self.bodies[index]))
    }

    /// Joints of members but for those that make the union and hold it to its anchor: those between members, and those whose other end is elsewhere.
    fn other_joints(&self, members: &[u32], fixed_links: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let of_members = members.iter().flat_map(|&index| &self.bodies[index].joints).filter_map(|&id| self.joints.find(id).ok());
        let mut others: Vec<u32> = of_members.filter(|slot| fixed_links.binary_search(slot).is_err()).collect();
        others.sort_unstable();
        others.dedup();
        let inside = |body: &Option<u32>| body.is_some_and(|index| members.binary_search(&index).is_ok());
        others.into_iter().partition(|&slot| self.joints[slot].bodies.iter().all(inside))
    }
}
