//! Bounds between bodies that are free (§3.2): over ever longer stretches of a graph, each level made of pairs of the level below.
//!
//! The paper pairs constraints at joints. Where light bodies alternate with heavy ones (planks and the ropes between them) such a
//! pair hardly ever ends on heavy bodies, and it is those whose motion stretches a structure. So the hierarchy is built on the
//! graph of *heavy* bodies: light ones are contracted into the paths between them.
//!
//! - An *edge* of level 0 leads from a joint on one heavy body to a joint on another, past light bodies only. Its bound is the length
//!   of the path; where the two are jointed directly it is zero and the joint itself keeps it.
//! - At each heavy body B, an edge to A and an edge to C make an edge of the next level from A to C, as long as the two and the
//!   segment inside B together. Of several edges between the same two bodies the two shortest are kept.
//!
//! So a level joins bodies 2, 4, 8 … steps apart, and both ends of each bound are on the *outer* bodies: correcting the spanned
//! bodies themselves leaves four to eight times the stretch. The number of edges at a body is capped, so that a dense graph has no
//! more bounds than a chain, times a constant.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::bounds::{AngleRange, ChainReach};
use super::graph::JointGraph;
use super::joint_part::JointPart;
use super::load::{LoadPaths, NodeId};
use super::load_class::LoadClass;
use super::{Bound, BoundKind, InnerJoint, JointSide};
use crate::tuning::bounds::{LONG_EDGE, LONG_LINE, MIN_SPAN, MIN_SPAN_OF_BENT};

/// Heavy bodies to which an end of a joint has edges of level 0, the nearest.
const MAX_NEIGHBOURS: usize = 3;

/// Edges kept between the same two bodies at one level.
const MAX_PARALLEL: usize = 2;

/// Pairs of edges joined at one body at one level, the shortest.
const MAX_PAIRS: usize = 8;

/// Levels where the user asks for no number: the last spans 64 bodies.
const DEFAULT_LEVELS: u32 = 6;

/// A path between two heavy bodies.
#[derive(Debug, Clone, Copy)]
struct Edge {
    bodies: [u32; 2],
    /// Joint at each end, on the side of the heavy body there.
    ends: [JointSide; 2],
    length: f64,
    path: NodeId,
    /// Joints on it, from the first end to the second, each on the side that lies beyond; as a range.
    crossed: (u32, u32),
}

/// Adds the bounds of all levels, the coarsest first.
pub(super) fn derive(part: &mut JointPart, weights: &[LoadClass], levels: Option<u32>) {
    let is_bent = weights.contains(&LoadClass::SaggingChain);
    let heavy: Vec<bool> = weights.iter().map(|&weight| matches!(weight, LoadClass::Heavy | LoadClass::SaggingChain)).collect();
    let mut crossed = Vec::new();
    let edges = neighbours(&part.graph, &heavy, &mut part.paths, &mut crossed);
    let mut strung = vec![false; heavy.len()];
    let is_long = |edge: &&Edge| edge.crossed.1 - edge.crossed.0 > LONG_EDGE;
    for edge in edges.iter().filter(is_long) {
        let sides = &crossed[edge.crossed.0 as usize..edge.crossed.1 as usize];
        for body in sides.iter().flat_map(|&side| [side, side.other()]).filter_map(|side| part.graph.dynamic_body(side)) {
            strung[body as usize] = true;
        }
    }
    let is_line = (0..heavy.len() as u32).all(|body| heavy[body as usize] && part.graph.ends_on(body).len() <= 2);
    let is_long_line = is_line && heavy.len() >= LONG_LINE;
    let least = if is_bent {
        MIN_SPAN_OF_BENT
    } else if is_long_line {
        MIN_SPAN
    } else {
        0
    };
    add_levels(part, edges, &mut crossed, levels, least);
    if strung.contains(&true) {
        let edges = neighbours(&part.graph, &strung, &mut part.paths, &mut crossed);
        add_levels(part, edges, &mut crossed, levels, 0);
    }
}

/// Adds the bounds of these edges and of all levels above them that span at least so many joints.
fn add_levels(part: &mut JointPart, edges: Vec<Edge>, crossed: &mut Vec<JointSide>, levels: Option<u32>, least: u32) {
    let has_limits = part.graph.links.iter().any(|link| link.turn.limits());
    let mut all = vec![edges];
    for _ in 0..levels.unwrap_or(DEFAULT_LEVELS) {
        let level = joined(&part.graph, &all[all.len() - 1], &mut part.paths, crossed);
        if level.is_empty() {
            break;
        }
        all.push(level);
    }
    for (number, edges) in all.iter().enumerate().rev() {
        for edge in edges.iter().filter(|edge| edge.length > 0.0 && edge.crossed.1 - edge.crossed.0 >= least) {
            let sides = &crossed[edge.crossed.0 as usize..edge.crossed.1 as usize];
            let reach = has_limits.then(|| reach_along(&part.graph, sides));
            let first = part.inner.len() as u32;
            if number == 0 {
                add_inner(part, edge, sides);
            }
            part.bounds.push(Bound {
                kind: BoundKind::Hierarchy,
                level: number as u8,
                near: edge.ends[0],
                far: edge.ends[1],
                upper: reach.map_or(edge.length, |reach| reach.upper) as f32,
                lower: reach.map_or(0.0, |reach| reach.lower) as f32,
                path: edge.path,
                inner: (first, part.inner.len() as u32),
                request: None,
            });
        }
    }
}

/// A step of the search from one heavy body past light ones, ordered by length.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Path length (m) as bits: lengths are not negative, so bits are in the order of values.
    length: u64,
    beyond: JointSide,
    parent: Option<u32>,
}

/// Edges of level 0.
fn neighbours(graph: &JointGraph, heavy: &[bool], paths: &mut LoadPaths, crossed: &mut Vec<JointSide>) -> Vec<Edge> {
    let mut edges = Vec::new();
    let mut seen = vec![0_u32; graph.links.len()];
    let mut mark = 0;
    let mut queue: BinaryHeap<Reverse<Candidate>> = BinaryHeap::new();
    let mut steps: Vec<(JointSide, Option<u32>)> = Vec::new();
    for body in (0..heavy.len() as u32).filter(|&body| heavy[body as usize]) {
        for &start in graph.ends_on(body) {
            mark += 1;
            queue.clear();
            steps.clear();
            queue.push(Reverse(Candidate { length: 0, beyond: start.other(), parent: None }));
            let mut found = 0;
            while let Some(Reverse(Candidate { length, beyond, parent })) = queue.pop() {
                let Some(reached) = graph.dynamic_body(beyond) else { continue };
                if seen[beyond.link as usize] == mark {
                    continue;
                }
                seen[beyond.link as usize] = mark;
                let number = steps.len() as u32;
                steps.push((beyond, parent));
                if heavy[reached as usize] {
                    // Each edge is found from both its ends, and kept from the lower one.
                    if reached > body {
                        let first = crossed.len();
                        let back = std::iter::successors(Some(number), |&at| steps[at as usize].1);
                        crossed.extend(back.map(|at| steps[at as usize].0));
                        crossed[first..].reverse();
                        let path = crossed[first..].iter().fold(NodeId::NONE, |before, &side| paths.crossing(before, side));
                        let (length, crossed) = (f64::from_bits(length), (first as u32, crossed.len() as u32));
                        edges.push(Edge { bodies: [body, reached], ends: [start, beyond], length, path, crossed });
                    }
                    if reached != body {
                        found += 1;
                    }
                    if found == MAX_NEIGHBOURS {
                        break;
                    }
                    continue;
                }
                for &end in graph.ends_on(reached).iter().filter(|end| end.link != beyond.link) {
                    let length = f64::from_bits(length) + graph.segment(beyond, end);
                    queue.push(Reverse(Candidate { length: length.to_bits(), beyond: end.other(), parent: Some(number) }));
                }
            }
        }
    }
    shortest(graph, edges)
}

/// Edges of the next level: pairs of edges that meet in a body.
fn joined(graph: &JointGraph, level: &[Edge], paths: &mut LoadPaths, crossed: &mut Vec<JointSide>) -> Vec<Edge> {
    let mut at_body: Vec<(u32, u32, usize)> =
        level.iter().enumerate().flat_map(|(number, edge)| [0, 1].map(|side| (edge.bodies[side], number as u32, side))).collect();
    at_body.sort_unstable();
    let mut edges = Vec::new();
    let mut pairs: Vec<(f64, [(u32, usize); 2])> = Vec::new();
    for group in at_body.chunk_by(|a, b| a.0 == b.0) {
        pairs.clear();
        for (i, &(_, left, left_side)) in group.iter().enumerate() {
            for &(_, right, right_side) in &group[i + 1..] {
                let (a, b) = (&level[left as usize], &level[right as usize]);
                let (inner_a, inner_b) = (a.ends[left_side], b.ends[right_side]);
                if a.bodies[1 - left_side] != b.bodies[1 - right_side] && inner_a.link != inner_b.link {
                    let length = a.length + graph.segment(inner_a, inner_b) + b.length;
                    pairs.push((length, [(left, left_side), (right, right_side)]));
                }
            }
        }
        pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for &(length, [(left, left_side), (right, right_side)]) in pairs.iter().take(MAX_PAIRS) {
            // Edges lead from the lower body to the higher.
            let outer = |(edge, side): (u32, usize)| level[edge as usize].bodies[1 - side];
            let turned = outer((left, left_side)) > outer((right, right_side));
            let [(left, left_side), (right, right_side)] =
                if turned { [(right, right_side), (left, left_side)] } else { [(left, left_side), (right, right_side)] };
            let (a, b) = (level[left as usize], level[right as usize]);
            let first = crossed.len() as u32;
            // The first edge is walked towards the body in the middle, the second away from it.
            append(crossed, a.crossed, left_side == 0);
            append(crossed, b.crossed, right_side == 1);
            let sign = |backwards: bool| if backwards { -1.0 } else { 1.0 };
            edges.push(Edge {
                bodies: [a.bodies[1 - left_side], b.bodies[1 - right_side]],
                ends: [a.ends[1 - left_side], b.ends[1 - right_side]],
                length,
                path: paths.joining((a.path, sign(left_side == 0)), (b.path, sign(right_side == 1))),
                crossed: (first, crossed.len() as u32),
            });
        }
    }
    shortest(graph, edges)
}

/// Appends the joints of a range, or the same walked backwards.
fn append(crossed: &mut Vec<JointSide>, (start, end): (u32, u32), backwards: bool) {
    let range = start as usize..end as usize;
    if backwards {
        for at in range.rev() {
            crossed.push(crossed[at].other());
        }
    } else {
        crossed.extend_from_within(range);
    }
}

/// Of the edges between the same two bodies the shortest few, without those that others imply.
fn shortest(graph: &JointGraph, mut edges: Vec<Edge>) -> Vec<Edge> {
    edges.sort_unstable_by(|a, b| (a.bodies.cmp(&b.bodies)).then(a.length.total_cmp(&b.length)).then(a.ends.cmp(&b.ends)));
    let mut kept: Vec<Edge> = Vec::new();
    for group in edges.chunk_by(|a, b| a.bodies == b.bodies) {
        let first = kept.len();
        for edge in group {
            let implied = |other: &Edge| {
                let within = |end: usize| graph.segment(edge.ends[end], other.ends[end]);
                edge.length >= within(0) + other.length + within(1)
            };
            if kept.len() - first < MAX_PARALLEL && !kept[first..].iter().any(implied) {
                kept.push(*edge);
            }
        }
    }
    kept
}

/// Bounds along a path, with the limits of its joints.
fn reach_along(graph: &JointGraph, sides: &[JointSide]) -> ChainReach {
    let mut reach = ChainReach::START;
    for (number, pair) in sides.windows(2).enumerate() {
        let angle = match number.checked_sub(1) {
            None => AngleRange::FREE,
            Some(earlier) => graph.angle(sides[earlier], pair[0].other(), pair[1].other()),
        };
        reach = reach.extended(graph.segment(pair[0], pair[1].other()), angle);
    }
    reach
}

/// Adds the joints between the ends of an edge, which it pulls straight when it is taut.
fn add_inner(part: &mut JointPart, edge: &Edge, sides: &[JointSide]) {
    let mut before = edge.length;
    let mut path = edge.path;
    for pair in sides.windows(2).skip(1).rev() {
        before -= part.graph.segment(pair[0], pair[1].other());
        path = part.paths.before(path);
        let after = edge.length - before;
        part.inner.push(InnerJoint { end: pair[0], before: before as f32, after: after as f32, path });
    }
}
