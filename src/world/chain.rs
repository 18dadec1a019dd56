//! Reads a chain of joints: its stretch, and the load of its links.
//!
//! The length at rest is that of the shortest path of segments between two joints; what the joints on it, both ends among them, are
//! apart is what it is stretched by. A link bears what its two joints pull it apart with along its segment, in the mean of the two:
//! they differ by what its own weight and inertia ask for.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec3, Vec3};

use super::World;
use super::long_range::{ends_of, holds_points};
use crate::error::{Error, ErrorKind, Result};
use crate::id::JointId;
use crate::joint_record::Joint;
use crate::long_range::{ChainLink, ChainState};

/// A joint on a path, by slot, and the side on which the path leaves it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Crossed {
    joint: u32,
    beyond: usize,
}

/// A step of the search, ordered by length.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Path length (m) as bits: lengths are not negative, so bits are in the order of values.
    length: u64,
    crossed: Crossed,
    parent: Option<usize>,
}

impl World {
    /// The chain between two joints, along the shortest path past bodies that joints can move, as the last step left it.
    ///
    /// Joints on it hold two points together without give; whether long-range constraints are derived from them does not matter.
    ///
    /// # Errors
    /// A handle is not a joint of this world; the two are the same; no such path connects them.
    pub fn chain(&self, joint_a: JointId, joint_b: JointId) -> Result<ChainState> {
        let named = |argument| move |error| Error { argument, ..error };
        let ends = [self.joints.find(joint_a).map_err(named("joint_a"))?, self.joints.find(joint_b).map_err(named("joint_b"))?];
        if ends[0] == ends[1] {
            return Err(Error::new(ErrorKind::NotApplicable, "joint_b", "is the same as joint_a"));
        }
        let path = self.path_between(ends);
        let path = path.ok_or(Error::new(ErrorKind::NotApplicable, "joint_b", "is not connected to joint_a by a chain"))?;
        let side = |crossed: &Crossed, side: usize| self.joint_point(&self.joints[crossed.joint], side);
        let gaps: f64 = path.iter().map(|crossed| side(crossed, 0).distance(side(crossed, 1))).sum();
        let mut rest_length = 0.0;
        let links = path.windows(2).map(|pair| {
            let points = [side(&pair[0], pair[0].beyond), side(&pair[1], 1 - pair[1].beyond)];
            let length = points[0].distance(points[1]);
            rest_length += length;
            self.chain_link([pair[0], pair[1]], points, length as f32)
        });
        let links: Vec<ChainLink> = links.collect();
        Ok(ChainState {
            links,
            rest_length: rest_length as f32,
            length: (rest_length + gaps) as f32,
            stretch: if rest_length > 0.0 { (gaps / rest_length) as f32 } else { 0.0 },
        })
    }

    fn chain_link(&self, crossed: [Crossed; 2], points: [DVec3; 2], length: f32) -> ChainLink {
        let along = (points[1] - points[0]).as_vec3().normalize_or_zero();
        // On the link: at its first joint it is the body beyond, at its second the one before.
        let [first, second] = crossed.map(|Crossed { joint, beyond }| {
            let on_b = self.load_inside(joint).map_or(self.joints[joint].force, |(force, _)| force);
            if beyond == 1 { on_b } else { -on_b }
        });
        let tension = 0.5 * (-first.dot(along) + (-second).dot(along));
        let body = self.joints[crossed[0].joint].bodies[crossed[0].beyond];
        ChainLink {
            body: body.map_or(crate::id::BodyId::NULL, |body| self.bodies.handle_of(body)),
            joints: crossed.map(|crossed| self.joints.handle_of(crossed.joint)),
            length,
            tension,
        }
    }

    /// Shortest path from one joint to the other.
    fn path_between(&self, [from, to]: [u32; 2]) -> Option<Vec<Crossed>> {
        let mut seen = vec![false; self.joints.slot_count()];
        let mut steps: Vec<(Crossed, Option<usize>)> = Vec::new();
        let mut queue = BinaryHeap::new();
        if !holds_points(&self.joints[from].def) {
            return None;
        }
        for beyond in 0..2 {
            queue.push(Reverse(Candidate { length: 0, crossed: Crossed { joint: from, beyond }, parent: None }));
        }
        while let Some(Reverse(Candidate { length, crossed, parent })) = queue.pop() {
            // The first joint is left over both its sides.
            if parent.is_some() && std::mem::replace(&mut seen[crossed.joint as usize], true) {
                continue;
            }
            let number = steps.len();
            steps.push((crossed, parent));
            if crossed.joint == to {
                let back = std::iter::successors(Some(number), |&at| steps[at].1);
                let mut path: Vec<Crossed> = back.map(|at| steps[at].0).collect();
                path.reverse();
                return Some(path);
            }
            let (body, point) = self.passed(&self.joints[crossed.joint], crossed.beyond);
            let Some(body) = body else { continue };
            for next in self.joints_on(body) {
                if next == crossed.joint || next == from || !holds_points(&self.joints[next].def) {
                    continue;
                }
                for side in (0..2).filter(|&side| self.passed(&self.joints[next], side).0 == Some(body)) {
                    let step = self.passed(&self.joints[next], side).1.as_dvec3().distance(point.as_dvec3());
                    let length = (f64::from_bits(length) + step).to_bits();
                    let crossed = Crossed { joint: next, beyond: 1 - side };
                    queue.push(Reverse(Candidate { length, crossed, parent: Some(number) }));
                }
            }
        }
        None
    }

    /// What moves as one on this side of a joint, if joints can move it, and the joint's point there.
    fn passed(&self, joint: &Joint, side: usize) -> (Option<u32>, Vec3) {
        let (body, point, _) = ends_of(joint, &self.unions, &self.bodies)[side];
        (body.filter(|&body| self.bodies[body].is_free()), point)
    }

    /// Joints of what moves as one under this body.
    fn joints_on(&self, body: u32) -> Vec<u32> {
        match self.unions.moving(body) {
            Some(union) => union.outer.clone(),
            None => self.bodies[body].joints.iter().filter_map(|&id| self.joints.find(id).ok()).collect(),
        }
    }
}
