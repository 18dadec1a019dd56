//! Bounds from attachments (§3.1): everything that hangs on a static or kinematic body stays within reach of it.
//!
//! From each joint on such a body the shortest paths through segments run out into the graph (Dijkstra, all attachments at once,
//! each joint keeping the nearest few). The bound at a joint ties the attachment to the joint point on the body *beyond* the joint:
//! that is the body whose weight pulls. Correcting the body before it stretches light chains (266–912 % at ten links).
//!
//! A taut bound also pulls the joints on its path straight ([`InnerJoint`]). A joint is on the paths to everything beyond it; the
//! one that counts is the path to the body of the greatest moment, mass times length of path. So each joint has one row across its
//! line, whatever the number of paths over it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::bounds::{AngleRange, ChainReach};
use super::graph::JointGraph;
use super::joint_part::JointPart;
use super::load::NodeId;
use super::load_class::LoadClass;
use super::{Bound, BoundKind, InnerJoint, JointSide};
use crate::tuning::bounds::HEAVY_SHARE;

/// Attachments that a joint keeps bounds to, the nearest.
const MAX_ATTACHMENTS: usize = 4;

/// A joint as reached from an attachment.
#[derive(Debug, Clone, Copy)]
struct Label {
    /// The joint, on the side of the body beyond it.
    beyond: JointSide,
    /// Fixed side of the attachment's joint.
    source: JointSide,
    parent: Option<u32>,
    /// Length of the path (m).
    length: f64,
    reach: ChainReach,
    path: NodeId,
}

/// A step of the search that is still to be taken, ordered by length, then by joint.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Path length (m) as bits: lengths are not negative, so bits are in the order of values.
    length: u64,
    beyond: JointSide,
    parent: Option<u32>,
    source: JointSide,
}

/// Adds the bounds of all attachments.
pub(super) fn derive(part: &mut JointPart, weights: &[LoadClass]) {
    let labels = reach_out(part, weights);
    let targets = targets(&part.graph, weights, &labels);
    let mut inner: Vec<(u32, u32)> = targets.iter().enumerate().map(|(label, &target)| (target, label as u32)).collect();
    inner.retain(|&(target, label)| {
        let has_bound = is_worth(&part.graph, weights, &labels[target as usize]);
        target != label && has_bound && labels[label as usize].parent.is_some()
    });
    inner.sort_unstable();
    let mut inner = inner.into_iter().peekable();
    for (number, label) in labels.iter().enumerate().filter(|(_, label)| label.parent.is_some()) {
        if !is_worth(&part.graph, weights, label) {
            continue;
        }
        let first = part.inner.len() as u32;
        while let Some((_, at)) = inner.next_if(|&(target, _)| target == number as u32) {
            let at = &labels[at as usize];
            let (before, after) = (at.reach.upper as f32, (label.length - at.length) as f32);
            part.inner.push(InnerJoint { end: at.beyond, before, after, path: at.path });
        }
        part.bounds.push(Bound {
            kind: BoundKind::Attachment,
            level: 0,
            near: label.source,
            far: label.beyond,
            upper: label.reach.upper as f32,
            lower: label.reach.lower as f32,
            path: label.path,
            inner: (first, part.inner.len() as u32),
            request: None,
        });
    }
}

/// Every joint as reached from its nearest attachments, in the order of path length.
fn reach_out(part: &mut JointPart, weights: &[LoadClass]) -> Vec<Label> {
    let JointPart { graph, paths, .. } = part;
    let mut labels: Vec<Label> = Vec::new();
    let mut kept = vec![[u32::MAX; MAX_ATTACHMENTS]; graph.links.len()];
    let mut queue = BinaryHeap::new();
    for link in 0..graph.links.len() as u32 {
        for side in 0..2 {
            let source = JointSide { link, side };
            if graph.dynamic_body(source).is_none() && graph.dynamic_body(source.other()).is_some() {
                queue.push(Reverse(Candidate { length: 0, beyond: source.other(), parent: None, source }));
            }
        }
    }
    while let Some(Reverse(candidate)) = queue.pop() {
        let Candidate { beyond, parent, source, .. } = candidate;
        let Some(body) = graph.dynamic_body(beyond) else { continue };
        let places = &mut kept[beyond.link as usize];
        match places.iter_mut().find(|place| **place == u32::MAX || **place == source.link) {
            Some(place) if *place == u32::MAX => *place = source.link,
            _ => continue,
        }
        let length = f64::from_bits(candidate.length);
        let (reach, before) = reached(graph, &labels, &candidate);
        let path = paths.crossing(before, beyond);
        let number = labels.len() as u32;
        labels.push(Label { beyond, source, parent, length, reach, path });
        let holds = matches!(weights[body as usize], LoadClass::SingleAttachment | LoadClass::SaggingChain);
        let ends = graph.ends_on(body).iter().filter(|end| end.link != beyond.link);
        for &end in ends {
            if holds && graph.holds_like_fixed(end) {
                queue.push(Reverse(Candidate { length: 0, beyond: end.other(), parent: None, source: end }));
            }
            let length = length + graph.segment(beyond, end);
            if !is_end_of(graph, source, end) {
                queue.push(Reverse(Candidate { length: length.to_bits(), beyond: end.other(), parent: Some(number), source }));
            }
        }
    }
    labels
}

/// Whether what hangs at a body that moves is not followed beyond this end of a joint: it is on that body, or on one as heavy, which holds
/// what is beyond itself.
fn is_end_of(graph: &JointGraph, source: JointSide, end: JointSide) -> bool {
    let Some(holder) = graph.dynamic_body(source) else { return false };
    graph.dynamic_body(end).is_some_and(|body| graph.masses[body as usize] >= HEAVY_SHARE * graph.masses[holder as usize])
}

/// Bounds at a joint, and the path up to the joint before.
fn reached(graph: &JointGraph, labels: &[Label], candidate: &Candidate) -> (ChainReach, NodeId) {
    let Some(from) = candidate.parent.map(|parent| &labels[parent as usize]) else { return (ChainReach::START, NodeId::NONE) };
    let (at, to) = (from.beyond, candidate.beyond.other());
    let angle = match from.parent {
        None => AngleRange::FREE,
        Some(earlier) => graph.angle(labels[earlier as usize].beyond, at.other(), to),
    };
    (from.reach.extended(graph.segment(at, to), angle), from.path)
}

/// Whether a bound at this joint does anything that others do not do better.
fn is_worth(graph: &JointGraph, weights: &[LoadClass], label: &Label) -> bool {
    graph.dynamic_body(label.beyond).is_some_and(|body| weights[body as usize] != LoadClass::Light)
}

/// For each label, which of itself and those beyond it has the greatest moment, of those that have a bound.
fn targets(graph: &JointGraph, weights: &[LoadClass], labels: &[Label]) -> Vec<u32> {
    let moment = |number: u32| {
        let label = &labels[number as usize];
        if !is_worth(graph, weights, label) {
            return -1.0;
        }
        graph.dynamic_body(label.beyond).map_or(0.0, |body| f64::from(graph.masses[body as usize])) * label.length
    };
    let mut targets: Vec<u32> = (0..labels.len() as u32).collect();
    for number in (0..labels.len()).rev() {
        if let Some(parent) = labels[number].parent {
            let (own, kept) = (targets[number], targets[parent as usize]);
            if moment(own) > moment(kept) {
                targets[parent as usize] = own;
            }
        }
    }
    targets
}
