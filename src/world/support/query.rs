//! Results of the support analysis for the host: of bodies, of what carries them, and of what would fall.

use glam::DVec3;

use super::{PairFrame, SupportState};
use crate::body::BodyKind;
use crate::error::{Error, ErrorKind, Result};
use crate::id::BodyId;
use crate::joint_graph::support::verdict::{BodySupport, SupportChange, Verdict};
use crate::joint_graph::support::{NodeKind, SupportLink, SupportNode};
use crate::world::World;

/// What no joints hold up, and what they do not tie to the body that is asked of: beyond any number of joints.
const LOOSE: u32 = u32::MAX - 1;
const OUTSIDE: u32 = u32::MAX;

/// Whether, of two bodies that a joint ties together, `upper` hangs on `lower`, the joints that each is away from the ground being these.
fn hangs_on(state: &SupportState, hops: &[u32], upper: u32, lower: u32) -> bool {
    let is_ground = |body: u32| state.graph.node(body).is_some_and(|node| node.kind == NodeKind::Ground);
    let [above, below] = [upper, lower].map(|body| hops[body as usize]);
    !is_ground(upper) && above < LOOSE && (below < above || is_ground(lower))
}

/// Answers are those of the end of the last step. Every call fails if the analysis is off ([`set_support`](Self::set_support)),
/// or if a handle is not a body of this world.
impl World {
    /// Whether a body is held up, or why not, and by what margin.
    ///
    /// # Errors
    /// As said above.
    pub fn support(&self, body: BodyId) -> Result<BodySupport> {
        let index = self.bodies.find(body)?;
        Ok(self.verdict(self.analysis()?, index))
    }

    /// The same of many bodies at once.
    ///
    /// # Errors
    /// As said above, or `out` is not as long as `bodies`; nothing is written then.
    pub fn support_into(&self, bodies: &[BodyId], out: &mut [BodySupport]) -> Result<()> {
        if bodies.len() != out.len() {
            return Err(Error::new(ErrorKind::OutOfRange, "out", "is not as long as the list of bodies"));
        }
        let state = self.analysis()?;
        for &body in bodies {
            self.bodies.find(body)?;
        }
        for (&body, out) in bodies.iter().zip(out) {
            *out = self.verdict(state, self.bodies.find(body)?);
        }
        Ok(())
    }

    /// Number of dynamic bodies that have support, by the events so far.
    ///
    /// # Errors
    /// As said above.
    pub fn supported_count(&self) -> Result<usize> {
        Ok(self.kept_analysis()?.supported_count as usize)
    }

    /// Dynamic bodies that gained or lost support in the last step, by slot. A loss is told at once, a gain when it has lasted
    /// for six steps.
    ///
    /// # Errors
    /// As said above.
    pub fn support_changes(&self) -> Result<&[SupportChange]> {
        Ok(&self.kept_analysis()?.events)
    }

    /// Corners of the hull of a body's supporting contacts, seen along gravity: in the plane through its centre of mass across
    /// gravity (m), anticlockwise from above; none, a point or an edge where there is no more.
    ///
    /// # Errors
    /// As said above.
    pub fn support_hull(&self, body: BodyId) -> Result<Vec<DVec3>> {
        let index = self.bodies.find(body)?;
        let state = self.analysis()?;
        let (Some(PairFrame { across: (u, v), .. }), Some(node)) = (state.frame, state.graph.node(index)) else {
            return Ok(Vec::new());
        };
        let center = self.bodies[index].center;
        Ok(node.hull().iter().map(|point| center + (u * point.x + v * point.y).as_dvec3()).collect())
    }

    /// Contact points through which a body is supported (m).
    pub(in crate::world) fn supporting_points(&self, index: u32) -> Vec<DVec3> {
        let Ok(state) = self.analysis() else { return Vec::new() };
        let Some(node) = state.graph.node(index) else { return Vec::new() };
        let links = node.below.iter().filter(|&&link| state.graph.is_supporting(link));
        let mut pairs: Vec<u32> =
            links.map(|&link| state.graph.link(link).pair).filter(|&slot| self.has_pair(state, slot)).collect();
        pairs.sort_unstable_by_key(|&slot| self.collision.pairs.get(slot).key);
        pairs.dedup();
        let contacts = pairs.iter().flat_map(|&slot| self.contacts_of_pair(self.collision.pairs.get(slot).key, slot));
        contacts.flat_map(|contact| contact.points().iter().map(|point| point.position).collect::<Vec<_>>()).collect()
    }

    /// Bodies that carry a body through supporting contacts or joints, by slot.
    ///
    /// # Errors
    /// As said above.
    pub fn supporters(&self, body: BodyId) -> Result<Vec<BodyId>> {
        let index = self.bodies.find(body)?;
        let state = self.analysis()?;
        let (Some(_), Some(node)) = (state.frame, state.graph.node(index)) else { return Ok(Vec::new()) };
        let below = node.below.iter().filter(|&&link| state.graph.is_supporting(link)).map(|&link| state.graph.link(link).lower);
        let is_supported = |other: u32| self.verdict(state, other).verdict.is_supported();
        let hops = self.hops_to_ground(state, index);
        let tied = self.ties_of(state, index).into_iter().filter(|&other| hangs_on(state, &hops, index, other));
        let braces = self.lifts(state, index).into_iter().map(|(other, _)| other).filter(|&other| is_supported(other));
        Ok(self.handles(below.chain(tied).chain(braces)))
    }

    /// Bodies that a body carries through supporting contacts, or that hang on it by joints, by slot.
    ///
    /// # Errors
    /// As said above.
    pub fn supported_by(&self, body: BodyId) -> Result<Vec<BodyId>> {
        let index = self.bodies.find(body)?;
        let state = self.analysis()?;
        let (Some(_), Some(node)) = (state.frame, state.graph.node(index)) else { return Ok(Vec::new()) };
        let above = node.above.iter().filter(|&&link| state.graph.is_supporting(link)).map(|&link| state.graph.link(link).upper);
        let hops = self.hops_to_ground(state, index);
        let hangs = self.ties_of(state, index).into_iter().filter(|&other| hangs_on(state, &hops, other, index));
        let leaning = if state.thrust.braces_any() { self.lifted_by(state, index) } else { Vec::new() };
        Ok(self.handles(above.chain(hangs).chain(leaning)))
    }

    /// Force with which everything that stands on a body presses it down, along gravity, in the last substep (N).
    ///
    /// # Errors
    /// As said above.
    pub fn load_on(&self, body: BodyId) -> Result<f32> {
        let index = self.bodies.find(body)?;
        let state = self.analysis()?;
        let (Some(frame), Some(node)) = (&state.frame, state.graph.node(index)) else { return Ok(0.0) };
        Ok(self.load_of(state, frame, node.above.iter().copied()))
    }

    /// Force with which `upper` presses `lower` down through their contacts, along gravity, in the last substep (N).
    ///
    /// # Errors
    /// As said above.
    pub fn load_between(&self, upper: BodyId, lower: BodyId) -> Result<f32> {
        let (upper, lower) = (self.bodies.find(upper)?, self.bodies.find(lower)?);
        let state = self.analysis()?;
        let (Some(frame), Some(node)) = (&state.frame, state.graph.node(upper)) else { return Ok(0.0) };
        let between = node.below.iter().copied().filter(|&link| state.graph.link(link).lower == lower);
        Ok(self.load_of(state, frame, between))
    }

    /// The way that a body's weight takes to the ground: from the body itself to one that needs no support, each carrying the one
    /// before it, by the most loaded contact of each, or by as few joints as there can be. Empty for a body without support; a joint to
    /// the world itself ends the way.
    ///
    /// # Errors
    /// As said above.
    pub fn path_to_ground(&self, body: BodyId) -> Result<Vec<BodyId>> {
        let start = self.bodies.find(body)?;
        let state = self.analysis()?;
        let Some(frame) = &state.frame else { return Ok(Vec::new()) };
        let mut path = Vec::new();
        if !self.verdict(state, start).verdict.is_supported() {
            return Ok(path);
        }
        let mut seen = vec![false; self.bodies.slot_count()];
        let mut next = Some(start);
        while let Some(index) = next {
            if std::mem::replace(&mut seen[index as usize], true) {
                break;
            }
            path.push(self.bodies.handle_of(index));
            let Some(node) = state.graph.node(index) else { break };
            if node.kind == NodeKind::Ground {
                break;
            }
            if node.stands() {
                let load = |link: u32| self.load_of(state, frame, std::iter::once(link));
                let supporting = node.below.iter().copied().filter(|&link| state.graph.is_supporting(link));
                let heaviest = supporting.max_by(|&a, &b| load(a).total_cmp(&load(b)));
                next = heaviest.map(|link| state.graph.link(link).lower);
                continue;
            }
            let unseen = self.lifts(state, index).into_iter().filter(|&(other, _)| !seen[other as usize]);
            next = unseen.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(other, _)| other);
            if next.is_none() {
                let mut way = self.way_along_joints(state, index);
                next = way.pop();
                let new = way.into_iter().take_while(|&body| !std::mem::replace(&mut seen[body as usize], true));
                path.extend(new.map(|body| self.bodies.handle_of(body)));
            }
        }
        Ok(path)
    }

    /// Bodies that are supported now and would not be without `removed`, by slot; the world stays as it is.
    ///
    /// This is a question to the graph of contacts, joints and hulls, not a simulation: it knows what no longer reaches the
    /// ground or has its centre of mass over nothing, and which stones of an arch have lost what they lean on, but neither what a
    /// fall would knock over, nor that what is left might slide.
    ///
    /// # Errors
    /// As said above.
    pub fn would_lose_support(&self, removed: &[BodyId]) -> Result<Vec<BodyId>> {
        let state = self.analysis()?;
        let mut gone = removed.iter().map(|&body| self.bodies.find(body)).collect::<Result<Vec<u32>>>()?;
        gone.sort_unstable();
        let is_gone = |index: u32| gone.binary_search(&index).is_ok();
        let mut graph = state.graph.clone();
        for &index in &gone {
            let Some(node) = graph.node(index) else { continue };
            for link in node.below.iter().chain(&node.above).copied().collect::<Vec<_>>() {
                graph.remove(link);
            }
        }
        gone.iter().for_each(|&index| graph.set_kind(index, NodeKind::Absent));
        // The graph is that of the last step: bodies made since then have no node in it, and cannot lose what they do not have.
        let is_known = |index: u32| state.graph.node(index).is_some();
        let (ties, anchors) = self.ties(|index| !is_gone(index) && is_known(index));
        graph.set_joints(&ties, &anchors);
        graph.update();
        let is_supported = |node: Option<&SupportNode>| node.is_some_and(SupportNode::is_supported);
        let was = |index: u32| is_supported(state.graph.node(index)) || state.thrust.braces(index);
        let braced = if state.thrust.braces_any() { self.braced_in(&graph, state) } else { Vec::new() };
        let is = |index: u32| is_supported(graph.node(index)) || braced.get(index as usize).is_some_and(|&braced| braced);
        let lost = (0..self.bodies.slot_count() as u32).filter(|&index| was(index) && !is(index) && !is_gone(index));
        Ok(self.handles(lost))
    }

    /// What to ask of single bodies and contacts.
    fn analysis(&self) -> Result<&SupportState> {
        let state = self.kept_analysis()?;
        let view = || Box::new(self.analysis_anew(state.gravity));
        Ok(if state.rest.rests { state.view.get_or_init(view) } else { state })
    }

    fn kept_analysis(&self) -> Result<&SupportState> {
        let off = || Error::new(ErrorKind::NotApplicable, "world", "the support analysis is off");
        self.support.as_deref().ok_or_else(off)
    }

    fn verdict(&self, state: &SupportState, index: u32) -> BodySupport {
        let nothing = |verdict| BodySupport { verdict, margin: f32::NEG_INFINITY };
        match self.bodies[index].kind {
            BodyKind::Static => return nothing(Verdict::Ground),
            BodyKind::Kinematic if self.bodies[index].is_mover() => return nothing(Verdict::Moving),
            BodyKind::Kinematic => return nothing(Verdict::Ground),
            BodyKind::Dynamic => {}
        }
        if state.frame.is_none() {
            return nothing(Verdict::NoGravity);
        }
        let Some(node) = state.graph.node(index) else { return nothing(Verdict::NoContact) };
        let links = || node.below.iter().map(|&link| state.graph.link(link));
        let verdict = if node.stands() {
            Verdict::Supported
        } else if node.held_by_joints {
            Verdict::HeldByJoints
        } else if state.thrust.braces(index) {
            Verdict::Braced
        } else if !node.hull().is_empty() {
            Verdict::OutsideHull
        } else if links().any(|link: &SupportLink| link.holds) {
            Verdict::OnUnsupported
        } else if links().next().is_some() {
            Verdict::Sliding
        } else if self.tied_to(index).next().is_some() {
            Verdict::HangingLoose
        } else {
            Verdict::NoContact
        };
        BodySupport { verdict, margin: node.margin }
    }

    /// Bodies that push a braced one up, and how hard (N).
    fn lifts(&self, state: &SupportState, index: u32) -> Vec<(u32, f32)> {
        let (true, Some(frame)) = (state.thrust.braces(index), &state.frame) else { return Vec::new() };
        let body = self.bodies.handle_of(index);
        let mut lifts: Vec<(u32, f32)> = Vec::new();
        for contact in self.contacts_of(body).into_iter().flatten() {
            let up = contact.force().dot(frame.up);
            let (other, up) = if contact.pair.body_b == body { (contact.pair.body_a, up) } else { (contact.pair.body_b, -up) };
            let Ok(other) = self.bodies.find(other) else { continue };
            match lifts.iter_mut().find(|(known, _)| *known == other) {
                Some((_, sum)) => *sum += up,
                None => lifts.push((other, up)),
            }
        }
        lifts.retain(|&(_, up)| up > 0.0);
        lifts
    }

    /// Braced bodies that a body pushes up.
    fn lifted_by(&self, state: &SupportState, index: u32) -> Vec<u32> {
        let contacts = self.contacts_of(self.bodies.handle_of(index)).into_iter().flatten();
        let touched = contacts.flat_map(|contact| [contact.pair.body_a, contact.pair.body_b]);
        let touched = touched.filter_map(|other| self.bodies.find(other).ok()).filter(|&other| other != index);
        touched.filter(|&other| self.lifts(state, other).iter().any(|&(lifts, _)| lifts == index)).collect()
    }

    /// Bodies at the other ends of a body's joints.
    fn tied_to(&self, index: u32) -> impl Iterator<Item = u32> + '_ {
        let joints = self.bodies[index].joints.iter().filter_map(|&joint| self.joints.find(joint).ok());
        joints.flat_map(|slot| self.joints[slot].bodies).flatten().filter(move |&other| other != index)
    }

    /// The same by joints that can carry weight, of bodies that are part of the analysis and not both ground.
    fn ties_of(&self, state: &SupportState, index: u32) -> Vec<u32> {
        use NodeKind::{Body, Ground};
        let kind = |body: u32| state.graph.node(body).map(|node| node.kind);
        let may_carry = |&other: &u32| {
            let kinds = (kind(index), kind(other));
            other != index && matches!(kinds, (Some(Body), Some(Body | Ground)) | (Some(Ground), Some(Body)))
        };
        let joints = self.bodies[index].joints.iter().filter_map(|&joint| self.joints.find(joint).ok());
        let holding = joints.filter(|&slot| self.holds_up(&self.joints[slot]));
        holding.flat_map(|slot| self.joints[slot].bodies).flatten().filter(may_carry).collect()
    }

    /// Of each body that joints tie to `start`, how many of them it takes to come to what stands without: 0 for the ground and what contacts
    /// hold up, 1 for what a joint holds to these or to the world, [`LOOSE`] where none do.
    ///
    /// Of two bodies that a joint connects, the one with more of them hangs on the other. Where both have as many, as the middle of a
    /// bridge that is held on both sides, neither does.
    fn hops_to_ground(&self, state: &SupportState, start: u32) -> Vec<u32> {
        let stands = |body: u32| {
            state.graph.node(body).is_some_and(|node| node.kind == NodeKind::Ground || node.stands())
                || !self.lifts(state, body).is_empty()
        };
        let mut hops = vec![OUTSIDE; self.bodies.slot_count()];
        hops[start as usize] = LOOSE;
        let (mut tied, mut next) = (vec![start], 0);
        while let Some(&body) = tied.get(next) {
            next += 1;
            if body == start || !stands(body) {
                let others = self.ties_of(state, body).into_iter();
                tied.extend(others.filter(|&other| std::mem::replace(&mut hops[other as usize], LOOSE) == OUTSIDE));
            }
        }
        let mut reached: Vec<u32> = tied.iter().copied().filter(|&body| stands(body)).collect();
        reached.iter().for_each(|&body| hops[body as usize] = 0);
        let mut further: Vec<u32> = tied.into_iter().filter(|&body| self.hangs_on_world(body)).collect();
        for hop in 1.. {
            further.extend(reached.drain(..).flat_map(|body| self.ties_of(state, body)));
            further.retain(|&body| {
                let is_new = hops[body as usize] == LOOSE;
                if is_new {
                    hops[body as usize] = hop;
                }
                is_new
            });
            if further.is_empty() {
                break;
            }
            std::mem::swap(&mut reached, &mut further);
        }
        hops
    }

    /// Whether a joint that can carry weight holds a body to the world itself.
    fn hangs_on_world(&self, index: u32) -> bool {
        let mut joints = self.bodies[index].joints.iter().filter_map(|&joint| self.joints.find(joint).ok());
        joints.any(|slot| self.joints[slot].bodies.contains(&None) && self.holds_up(&self.joints[slot]))
    }

    /// A shortest way along joints from a body to what stands without them, or to what a joint holds to the world; the body itself is left out.
    fn way_along_joints(&self, state: &SupportState, start: u32) -> Vec<u32> {
        let hops = self.hops_to_ground(state, start);
        let below = |body: u32| self.ties_of(state, body).into_iter().find(|&other| hops[other as usize] < hops[body as usize]);
        std::iter::successors(below(start), |&body| below(body)).collect()
    }

    /// Whether the pair of a link is still there: the graph is of the last step, and edits since may have given the pair up.
    fn has_pair(&self, state: &SupportState, slot: u32) -> bool {
        let key = state.records.get(slot as usize).and_then(|record| record.key);
        key.is_some_and(|key| self.collision.pairs.holds(slot, key))
    }

    /// Weight that links pass on from above to below (N).
    fn load_of(&self, state: &SupportState, frame: &PairFrame, links: impl Iterator<Item = u32>) -> f32 {
        let per_substep = if self.last.substep > 0.0 { 1.0 / self.last.substep } else { 0.0 };
        let links = links.map(|link| (state.graph.link(link).pair, state.graph.link(link).lower));
        let mut pairs: Vec<(u32, u32)> = links.filter(|&(slot, _)| self.has_pair(state, slot)).collect();
        pairs.sort_unstable_by_key(|&(slot, lower)| (self.collision.pairs.get(slot).key, lower));
        pairs.dedup();
        let load = |&(slot, lower): &(u32, u32)| {
            let pair = self.collision.pairs.get(slot);
            let site = super::PairView::new(pair, slot, &self.colliders, &self.bodies);
            let on_b = site.force(frame);
            if site.shapes.1.body == lower { -on_b } else { on_b }
        };
        pairs.iter().map(load).sum::<f32>() * per_substep
    }

    fn handles(&self, bodies: impl Iterator<Item = u32>) -> Vec<BodyId> {
        let mut slots: Vec<u32> = bodies.collect();
        slots.sort_unstable();
        slots.dedup();
        slots.into_iter().map(|slot| self.bodies.handle_of(slot)).collect()
    }
}
