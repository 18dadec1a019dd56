//! Load paths: which joints a long-range bound carries load past.
//!
//! What a taut bound pulls with would, without it, go through every joint on its path. A path is a node that names the joint at its
//! end and the path before it, or two paths that it joins, so paths share what they have in common and a load is handed down once
//! for all. Where bounds leave the straight line their pulls differ in direction; they are added as vectors, which is what the
//! equilibrium of everything beyond a joint asks for.

use glam::Vec3;

use super::JointSide;

/// A path in [`LoadPaths`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NodeId(u32);

impl NodeId {
    pub(crate) const NONE: Self = Self(u32::MAX);

    /// The same path among others that come after so many.
    pub(crate) fn moved_by(self, offset: u32) -> Self {
        if self == Self::NONE { self } else { Self(self.0 + offset) }
    }
}

#[derive(Debug, Clone, Copy)]
struct LoadNode {
    /// Paths that it goes on from, each walked forwards (1) or backwards (−1).
    parents: [(NodeId, f32); 2],
    /// Joint crossed at its end, on the side that lies beyond.
    crossed: Option<JointSide>,
}

/// Paths, each after those it is made of.
#[derive(Debug, Default)]
pub(crate) struct LoadPaths {
    nodes: Vec<LoadNode>,
    loads: Vec<Vec3>,
}

impl LoadPaths {
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
    }

    /// Adds the paths of a part, with the joints that they cross named anew; returns what their numbers grow by.
    pub(crate) fn append(&mut self, other: &Self, side: impl Fn(JointSide) -> JointSide) -> u32 {
        let offset = self.nodes.len() as u32;
        self.nodes.extend(other.nodes.iter().map(|node| LoadNode {
            parents: node.parents.map(|(path, sign)| (path.moved_by(offset), sign)),
            crossed: node.crossed.map(&side),
        }));
        offset
    }

    /// The path `before` and the joint at its end; `beyond` is that joint's far side.
    pub(crate) fn crossing(&mut self, before: NodeId, beyond: JointSide) -> NodeId {
        self.push(LoadNode { parents: [(before, 1.0), (NodeId::NONE, 1.0)], crossed: Some(beyond) })
    }

    /// Two paths, one after the other, each walked forwards (1) or backwards (−1).
    pub(crate) fn joining(&mut self, first: (NodeId, f32), second: (NodeId, f32)) -> NodeId {
        self.push(LoadNode { parents: [first, second], crossed: None })
    }

    /// What [`crossing`](Self::crossing) went on from.
    pub(crate) fn before(&self, path: NodeId) -> NodeId {
        self.nodes[path.0 as usize].parents[0].0
    }

    fn push(&mut self, node: LoadNode) -> NodeId {
        self.nodes.push(node);
        NodeId(self.nodes.len() as u32 - 1)
    }

    /// Sets all loads to nothing.
    pub(crate) fn unload(&mut self) {
        self.loads.clear();
        self.loads.resize(self.nodes.len(), Vec3::ZERO);
    }

    /// Adds the force that a bound exerts at the far end of its path (N).
    pub(crate) fn load(&mut self, path: NodeId, force: Vec3) {
        if path != NodeId::NONE {
            self.loads[path.0 as usize] += force;
        }
    }

    /// Hands all loads down and reports what each joint crossed would carry on its far side (N).
    pub(crate) fn hand_down(&mut self, mut carried: impl FnMut(JointSide, Vec3)) {
        for index in (0..self.nodes.len()).rev() {
            let (node, force) = (self.nodes[index], self.loads[index]);
            if force == Vec3::ZERO {
                continue;
            }
            for (parent, sign) in node.parents {
                self.load(parent, force * sign);
            }
            if let Some(beyond) = node.crossed {
                carried(beyond, force);
            }
        }
    }
}
