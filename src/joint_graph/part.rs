//! Connected parts of the joint graph. Each is derived by itself, and again only when its inputs change.
//!
//! Bodies that no joint can move end a part. What is derived of a part is a function of its joints, masses and requests alone, with
//! joints and bodies in the order of their slots; so a part of which all these are as they were keeps what it has, and a world that
//! was edited has the same bounds, bit for bit and in the same order, as one that is derived anew.

use super::graph::{JointGraph, PointLink};
use super::joint_part::JointPart;
use super::load::LoadPaths;
use super::{Bound, Choice, InnerJoint, JointSide, attachment, hierarchy, load_class, mesh, soft};
use crate::island::UnionFind;

/// What bounds follow from.
#[derive(Debug, Default)]
pub(crate) struct BoundInput {
    /// Joints that hold two points together, by slot.
    pub links: Vec<Option<PointLink>>,
    /// Mass of each body (kg), infinite for what no joint can move.
    pub masses: Vec<f32>,
    pub choice: Choice,
    /// What the host asked for, by slots of joints.
    pub requests: Vec<soft::Request>,
}

impl BoundInput {
    fn link(&self, slot: usize) -> Option<&PointLink> {
        self.links.get(slot)?.as_ref()
    }

    /// Bodies of a joint that joints can move.
    fn moved_by(&self, link: &PointLink) -> impl Iterator<Item = u32> + use<> {
        let is_moved = |body: Option<u32>| body.filter(|&body| self.masses[body as usize].is_finite());
        link.bodies.map(is_moved).into_iter().flatten()
    }

    /// Bodies of which something is not as it was in `old`.
    fn changed_since(&self, old: &Self) -> Vec<bool> {
        let mut changed: Vec<bool> = (0..self.masses.len())
            .map(|body| old.masses.get(body).map(|mass| mass.to_bits()) != Some(self.masses[body].to_bits()))
            .collect();
        if self.choice != old.choice {
            changed.fill(true);
            return changed;
        }
        let mut note = |input: &Self, slot: usize| {
            for body in input.link(slot).into_iter().flat_map(|link| link.bodies).flatten() {
                // A body that is gone holds nothing.
                if let Some(changed) = changed.get_mut(body as usize) {
                    *changed = true;
                }
            }
        };
        for slot in (0..self.links.len().max(old.links.len()))
            .filter(|&slot| self.link(slot).map(PointLink::words) != old.link(slot).map(PointLink::words))
        {
            note(self, slot);
            note(old, slot);
        }
        if self.requests != old.requests {
            for input in [self, old] {
                input.requests.iter().flat_map(|request| request.links).for_each(|slot| note(input, slot as usize));
            }
        }
        changed
    }

    /// Slots of the joints of each part, in order; parts are in the order of their lowest joint.
    fn parts(&self) -> Vec<Vec<u32>> {
        let mut sets = UnionFind::default();
        sets.reset(self.masses.len(), &(0..self.masses.len() as u32).collect::<Vec<_>>());
        let present = || self.links.iter().enumerate().filter_map(|(slot, link)| Some((slot as u32, link.as_ref()?)));
        for (_, link) in present() {
            let mut bodies = self.moved_by(link);
            if let (Some(a), Some(b)) = (bodies.next(), bodies.next()) {
                sets.union(a, b);
            }
        }
        let mut part_of = vec![u32::MAX; self.masses.len()];
        let mut parts: Vec<Vec<u32>> = Vec::new();
        for (slot, link) in present() {
            let Some(body) = self.moved_by(link).next() else { continue };
            let part = &mut part_of[sets.find(body) as usize];
            if *part == u32::MAX {
                *part = parts.len() as u32;
                parts.push(Vec::new());
            }
            parts[*part as usize].push(slot);
        }
        parts
    }
}

impl JointPart {
    fn derive(joints: Vec<u32>, input: &BoundInput) -> Self {
        let links = || joints.iter().filter_map(|&slot| input.link(slot as usize));
        let mut bodies: Vec<u32> = links().flat_map(|link| input.moved_by(link)).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let place = |body: Option<u32>| bodies.binary_search(&body?).ok().map(|place| place as u32);
        let graph = JointGraph::new(
            links().map(|link| PointLink { bodies: link.bodies.map(place), ..*link }).collect(),
            bodies.iter().map(|&body| input.masses[body as usize]).collect(),
        );
        let mut part = Self { joints, bodies, graph, ..Self::default() };
        let link = |slot: u32| part.joints.binary_search(&slot).ok().map(|link| link as u32);
        let here = input.requests.iter().enumerate().filter_map(|(number, request)| {
            let [a, b] = request.links.map(link);
            Some((number as u32, soft::Request { links: [a?, b?], ..*request }))
        });
        let requests: Vec<_> = here.collect();
        // A sheet has only what the host asks for.
        if requests.is_empty() && mesh::is_sheet(part.joints.len(), part.bodies.len()) {
            return part;
        }
        soft::derive(&mut part, &requests);
        let weights = load_class::weigh(&part.graph);
        if input.choice.hierarchy {
            hierarchy::derive(&mut part, &weights, input.choice.levels);
        }
        if input.choice.attachment {
            attachment::derive(&mut part, &weights);
        }
        part
    }
}

/// Place of bounds whose records are those of another state.
const NOWHERE: u32 = u32::MAX;

/// Where the bounds of a part are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PartBounds {
    pub first: u32,
    pub count: u32,
    /// Where they were before, if they are the same.
    pub kept: Option<u32>,
}

/// Everything derived from the joints of a world. Links are slots of joints.
#[derive(Debug, Default)]
pub(crate) struct Derived {
    pub input: BoundInput,
    parts: Vec<JointPart>,
    pub bounds: Vec<Bound>,
    pub of_parts: Vec<PartBounds>,
    /// Joints on the paths of bounds.
    pub inner: Vec<InnerJoint>,
    pub paths: LoadPaths,
}

impl Derived {
    /// Says that the records of bounds are to be those of another state; what is derived stays where that has the same joints.
    pub(crate) fn forget_places(&mut self) {
        self.of_parts.iter_mut().for_each(|part| part.first = NOWHERE);
    }

    /// Derives anew what follows from what is not as it was.
    pub(crate) fn update(&mut self, input: BoundInput) {
        let changed = input.changed_since(&self.input);
        let mut known: Vec<(JointPart, PartBounds)> = self.parts.drain(..).zip(self.of_parts.drain(..)).collect();
        self.bounds.clear();
        self.inner.clear();
        self.paths.clear();
        for joints in input.parts() {
            // A body that joints can no longer move has cut its part in two.
            let was_moved = |body: u32| self.input.masses.get(body as usize).is_some_and(|mass| mass.is_finite());
            let is_moved = |body: u32| input.masses[body as usize].is_finite() || was_moved(body);
            let is_changed = |&slot: &u32| {
                let bodies = input.link(slot as usize).into_iter().flat_map(|link| link.bodies).flatten();
                bodies.into_iter().any(|body| changed[body as usize] && is_moved(body))
            };
            let same = if joints.iter().any(is_changed) {
                None
            } else {
                known.binary_search_by_key(&joints.first(), |(part, _)| part.joints.first()).ok()
            };
            let (part, kept) = match same {
                Some(place) => {
                    let (part, at) = &mut known[place];
                    // Its joints stay, so that others are found.
                    let joints = vec![joints[0]];
                    (
                        std::mem::replace(part, JointPart { joints, ..JointPart::default() }),
                        (at.first != NOWHERE).then_some(at.first),
                    )
                }
                None => (JointPart::derive(joints, &input), None),
            };
            self.of_parts.push(PartBounds { first: self.bounds.len() as u32, count: part.bounds.len() as u32, kept });
            self.append(&part);
            self.parts.push(part);
        }
        self.input = input;
    }

    fn append(&mut self, part: &JointPart) {
        let side = |side: JointSide| JointSide { link: part.joints[side.link as usize], ..side };
        let first = self.inner.len() as u32;
        let offset = self.paths.append(&part.paths, side);
        self.inner.extend(part.inner.iter().map(|inner| InnerJoint {
            end: side(inner.end),
            path: inner.path.moved_by(offset),
            ..*inner
        }));
        self.bounds.extend(part.bounds.iter().map(|bound| Bound {
            near: side(bound.near),
            far: side(bound.far),
            path: bound.path.moved_by(offset),
            inner: (bound.inner.0 + first, bound.inner.1 + first),
            ..*bound
        }));
    }

    /// Body on this side of a joint, if joints can move it.
    pub(crate) fn dynamic_body(&self, end: JointSide) -> Option<u32> {
        let body = self.input.link(end.link as usize)?.bodies[end.side as usize]?;
        self.input.masses[body as usize].is_finite().then_some(body)
    }

    /// Bodies of parts that the host asked for a bound in.
    pub(crate) fn bodies_with_requests(&self) -> impl Iterator<Item = u32> + '_ {
        let asked = |part: &&JointPart| part.bounds.iter().any(|bound| bound.request.is_some());
        self.parts.iter().filter(asked).flat_map(|part| part.bodies.iter().copied())
    }
}
