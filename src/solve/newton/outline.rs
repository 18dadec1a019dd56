//! What the matrix of an island is made of: bodies, rows of joints that hold, near pairs. It is known before any row is formed.

use super::elimination::Elimination;
use super::term::FIXED;

/// A joint: which bodies it connects, how many rows of it hold at most, and whether it has others, which act on its bodies outright.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct JointOutline {
    pub bodies: [u32; 2],
    pub rows: u8,
    pub acts_between: bool,
}

/// What a structure follows from.
#[derive(Debug, Default, PartialEq, Eq)]
struct Parts {
    bodies: usize,
    joints: Vec<JointOutline>,
    pairs: Vec<[u32; 2]>,
    /// Most multiplications that a factorisation may take.
    most: u64,
}

/// The outline of an island.
#[derive(Debug, Default)]
pub(super) struct Outline {
    parts: Parts,
    /// Those of which the structure was found last, and whether it takes more work than it may.
    known: Parts,
    is_large: bool,
    sizes: Vec<u8>,
    edges: Vec<[u32; 2]>,
}

impl Outline {
    /// Begins anew with so many bodies; a factorisation may take `most` multiplications.
    pub(super) fn begin(&mut self, bodies: usize, most: u64) {
        let Self { parts, .. } = self;
        (parts.bodies, parts.most) = (bodies, most);
        parts.joints.clear();
        parts.pairs.clear();
    }

    pub(super) fn add_joint(&mut self, joint: JointOutline) {
        self.parts.joints.push(joint);
    }

    pub(super) fn add_pair(&mut self, bodies: [u32; 2]) {
        self.parts.pairs.push(bodies);
    }

    /// Whether the structure was found of just these parts.
    pub(super) fn is_known(&self) -> bool {
        self.parts == self.known
    }

    /// Whether a factorisation takes more work than it may.
    pub(super) fn is_large(&self) -> bool {
        self.is_large
    }

    /// Finds the structure of these parts; there is none where a factorisation takes more work than it may.
    pub(super) fn find(&mut self, structure: &mut Elimination) {
        let Self { parts, known, is_large, sizes, edges } = self;
        let bodies = parts.bodies;
        sizes.clear();
        sizes.resize(bodies, 6);
        sizes.extend(parts.joints.iter().map(|joint| joint.rows));
        edges.clear();
        for (number, joint) in parts.joints.iter().enumerate() {
            // A joint that only bounds has no rows to eliminate.
            let moved = joint.bodies.into_iter().filter(|&body| body != FIXED && joint.rows > 0);
            edges.extend(moved.map(|body| [body, (bodies + number) as u32]));
            if joint.acts_between {
                edges.push(joint.bodies);
            }
        }
        edges.extend_from_slice(&parts.pairs);
        edges.retain_mut(|edge| {
            edge.sort_unstable();
            edge[1] != FIXED && edge[0] != edge[1]
        });
        edges.sort_unstable();
        edges.dedup();
        *is_large = !structure.prepare(bodies, sizes, edges, parts.most);
        (known.bodies, known.most) = (bodies, parts.most);
        known.joints.clone_from(&parts.joints);
        known.pairs.clone_from(&parts.pairs);
    }
}
