//! Bounds from attachments (§3.1): everything that hangs on a static or kinematic body stays within reach of it.
//!
//! From each joint on such a body the shortest paths through segments run out into the graph (Dijkstra, all attachments at once,
//! each joint keeping the nearest few). The bound at a joint ties the attachment to the joint point on the body *beyond* the joint:
//! that is the body whose weight pulls. Correcting the body before it stretches light chains (266–912 % at ten links).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::bounds::{AngleRange, Reach};
use super::graph::Graph;
use super::load::{LoadPaths, NodeId};
use super::{Bound, BoundKind, JointSide};

/// Attachments that a joint keeps bounds to, the nearest.
const MAX_ATTACHMENTS: usize = 4;

/// A joint as reached from an attachment.
#[derive(Debug, Clone, Copy)]
struct Label {
    /// The joint, on the side of the body beyond it.
    beyond: JointSide,
    /// Fixed side of the attachment's joint.
    source: JointSide,
    parent: u32,
    reach: Reach,
    path: NodeId,
}

const NO_PARENT: u32 = u32::MAX;

/// A step of the search that is still to be taken, ordered by length, then by joint.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Path length (m) as bits: lengths are not negative, so bits are in the order of values.
    length: u64,
    beyond: JointSide,
    parent: u32,
    source: JointSide,
}

/// Adds the bounds of all attachments.
pub(crate) fn derive(graph: &Graph, paths: &mut LoadPaths, bounds: &mut Vec<Bound>) {
    let mut labels: Vec<Label> = Vec::new();
    let mut kept = vec![[u32::MAX; MAX_ATTACHMENTS]; graph.links.len()];
    let mut queue = BinaryHeap::new();
    for link in 0..graph.links.len() as u32 {
        for side in 0..2 {
            let source = JointSide { link, side };
            if graph.dynamic_body(source).is_none() && graph.dynamic_body(source.other()).is_some() {
                queue.push(Reverse(Candidate { length: 0, beyond: source.other(), parent: NO_PARENT, source }));
            }
        }
    }
    while let Some(Reverse(candidate)) = queue.pop() {
        let Candidate { length, beyond, source, .. } = candidate;
        let places = &mut kept[beyond.link as usize];
        let Some(place) = places.iter_mut().find(|place| **place == u32::MAX || **place == source.link) else { continue };
        if *place == source.link {
            continue;
        }
        *place = source.link;
        let Some(body) = graph.dynamic_body(beyond) else { continue };
        let label = reached(graph, &labels, &candidate, paths);
        let number = labels.len() as u32;
        labels.push(label);
        for &end in graph.ends_on(body) {
            if end.link != beyond.link {
                let length = f64::from_bits(length) + graph.segment(beyond, end);
                queue.push(Reverse(Candidate { length: length.to_bits(), beyond: end.other(), parent: number, source }));
            }
        }
    }
    for label in labels.iter().filter(|label| label.parent != NO_PARENT) {
        bounds.push(Bound {
            kind: BoundKind::Attachment,
            level: 0,
            near: label.source,
            far: label.beyond,
            upper: label.reach.upper as f32,
            lower: label.reach.lower as f32,
            path: label.path,
        });
    }
}

fn reached(graph: &Graph, labels: &[Label], candidate: &Candidate, paths: &mut LoadPaths) -> Label {
    let &Candidate { beyond, parent, source, .. } = candidate;
    let (reach, before) = match labels.get(parent as usize) {
        None => (Reach::START, NodeId::NONE),
        Some(from) => {
            let length = graph.segment(from.beyond, beyond.other());
            let angle = match labels.get(from.parent as usize) {
                None => AngleRange::FREE,
                Some(earlier) => graph.angle(earlier.beyond, from.beyond.other(), beyond.other()),
            };
            (from.reach.extended(length, angle), from.path)
        }
    };
    Label { beyond, source, parent, reach, path: paths.crossing(before, beyond) }
}
