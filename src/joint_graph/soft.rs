//! Soft lower bounds that the host asks for (§3.3): the greatest distance that a chain leaves its ends, or a share of it.
//!
//! A spring towards the whole upper bound stretches a chain that was modelled bent, and shoots an arrow; one on a beam's own length
//! gives it resistance to bending.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::bounds::{AngleRange, ChainReach};
use super::graph::JointGraph;
use super::joint_part::JointPart;
use super::load::NodeId;
use super::{Bound, BoundKind, JointSide};

/// What the host asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Request {
    /// The two joints.
    pub links: [u32; 2],
    /// Share of the upper bound that the lower one is.
    pub share: f32,
}

/// A step of the search between two joints, ordered by length.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Path length (m) as bits: lengths are not negative, so bits are in the order of values.
    length: u64,
    beyond: JointSide,
    parent: Option<u32>,
}

/// Adds a bound for each of these requests, by number, whose joints are connected.
pub(super) fn derive(part: &mut JointPart, requests: &[(u32, Request)]) {
    for &(number, request) in requests {
        let Some(sides) = shortest_path(&part.graph, request.links) else { continue };
        let mut reach = ChainReach::START;
        for (crossed, pair) in sides.windows(2).enumerate() {
            let angle = match crossed.checked_sub(1) {
                None => AngleRange::FREE,
                Some(earlier) => part.graph.angle(sides[earlier], pair[0].other(), pair[1].other()),
            };
            reach = reach.extended(part.graph.segment(pair[0], pair[1].other()), angle);
        }
        let path = sides.iter().fold(NodeId::NONE, |before, &side| part.paths.crossing(before, side));
        let (first, last) = (sides[0], sides[sides.len() - 1]);
        part.bounds.push(Bound {
            kind: BoundKind::Soft,
            level: 0,
            near: heavier(&part.graph, first.other(), first),
            far: heavier(&part.graph, last.other(), last),
            upper: reach.upper as f32,
            lower: reach.upper as f32 * request.share,
            path,
            inner: (0, 0),
            request: Some(number),
        });
    }
}

/// Of the two sides of a joint the one on the heavier body: a spring on a light one would shake it.
fn heavier(graph: &JointGraph, a: JointSide, b: JointSide) -> JointSide {
    let mass = |side: JointSide| graph.dynamic_body(side).map_or(f32::INFINITY, |body| graph.masses[body as usize]);
    if mass(b) > mass(a) { b } else { a }
}

/// Joints from one to the other, each on the side that lies beyond.
fn shortest_path(graph: &JointGraph, [from, to]: [u32; 2]) -> Option<Vec<JointSide>> {
    let mut seen = vec![false; graph.links.len()];
    let mut steps: Vec<(JointSide, Option<u32>)> = Vec::new();
    let mut queue = BinaryHeap::new();
    for side in 0..2 {
        queue.push(Reverse(Candidate { length: 0, beyond: JointSide { link: from, side }, parent: None }));
    }
    while let Some(Reverse(Candidate { length, beyond, parent })) = queue.pop() {
        // The first joint is left over both its sides.
        if parent.is_some() && std::mem::replace(&mut seen[beyond.link as usize], true) {
            continue;
        }
        let number = steps.len() as u32;
        steps.push((beyond, parent));
        if beyond.link == to {
            let back = std::iter::successors(Some(number), |&at| steps[at as usize].1);
            let mut sides: Vec<JointSide> = back.map(|at| steps[at as usize].0).collect();
            sides.reverse();
            return Some(sides);
        }
        let Some(body) = graph.dynamic_body(beyond) else { continue };
        for &end in graph.ends_on(body).iter().filter(|end| end.link != beyond.link && end.link != from) {
            let length = f64::from_bits(length) + graph.segment(beyond, end);
            queue.push(Reverse(Candidate { length: length.to_bits(), beyond: end.other(), parent: Some(number) }));
        }
    }
    None
}
