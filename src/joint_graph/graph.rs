//! The joint graph: joints without positional freedom are nodes, and two of them on one body are joined by a segment.
//!
//! **Angles between segments.** Where a joint's rotation is limited, so is the angle at it between a segment u on A and a segment w
//! on B (unit vectors from the joint point, in the joint's frames).
//!
//! - *Hinge* about x by ϑ in [a, b]: u·R(ϑ)w = u_x w_x + c cos(ϑ − ϑ₀), with c the product of the parts of u and w across the axis and
//!   ϑ₀ the angle that turns w's part onto u's. The extremes over [a, b] are at its ends, or ±c where ϑ₀ or ϑ₀ + π lies inside. This is
//!   exact for axes at any angle to the segments and for any angle at rest.
//! - *Spherical* with swing up to s, twist free: B's axis is within s of A's, so u is β_u ± s from B's axis (β_u, β_w angles of the
//!   segments from their joint axes), and since w may point anywhere on its cone about that axis, the angle to it lies between
//!   |φ − β_w| and min(φ + β_w, 2π − φ − β_w) with φ over that range. Limits on twist would tighten it; leaving them out keeps it a
//!   bound.
//! - *Fixed*: one value.

use std::f64::consts::{PI, TAU};

use glam::{Quat, Vec3};

use super::JointSide;
use super::bounds::AngleRange;
use crate::tuning::bounds::HEAVY_SHARE;

/// Added to both ends of an angle range (rad): joint frames are `f32`, and a bound must hold all the same.
const ANGLE_MARGIN: f64 = 1.0e-6;

/// What a joint allows to turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Turn {
    Free,
    Fixed { frames: [Quat; 2] },
    Hinge { frames: [Quat; 2], min: f32, max: f32 },
    Swing { frames: [Quat; 2], limit: f32 },
}

impl Turn {
    /// Whether it says anything about angles between segments.
    pub(crate) fn limits(&self) -> bool {
        match *self {
            Self::Free => false,
            Self::Fixed { .. } | Self::Hinge { .. } => true,
            Self::Swing { limit, .. } => f64::from(limit) < PI - ANGLE_MARGIN,
        }
    }
}

/// A joint that holds two points together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PointLink {
    /// Bodies; `None` for the world.
    pub bodies: [Option<u32>; 2],
    /// Joint points in their bodies' frames (m).
    pub points: [Vec3; 2],
    pub turn: Turn,
}

impl PointLink {
    /// All of it, to the bit.
    pub(super) fn words(&self) -> [u32; 19] {
        let Self { bodies, points, turn } = self;
        let (kind, frames, limits) = match *turn {
            Turn::Free => (0, [Quat::IDENTITY; 2], [0.0; 2]),
            Turn::Fixed { frames } => (1, frames, [0.0; 2]),
            Turn::Hinge { frames, min, max } => (2, frames, [min, max]),
            Turn::Swing { frames, limit } => (3, frames, [limit, 0.0]),
        };
        let mut words = [0; 19];
        let whole = [bodies[0].unwrap_or(u32::MAX), bodies[1].unwrap_or(u32::MAX), kind];
        let floats = points.iter().flat_map(Vec3::to_array).chain(frames.iter().flat_map(Quat::to_array)).chain(limits);
        let all = whole.into_iter().chain(floats.map(f32::to_bits));
        words.iter_mut().zip(all).for_each(|(word, value)| *word = value);
        words
    }
}

/// Links and the bodies they meet in.
#[derive(Debug, Default)]
pub(crate) struct JointGraph {
    pub links: Vec<PointLink>,
    /// Mass of each body (kg), infinite for what no joint can move.
    pub masses: Vec<f32>,
    /// Links of each dynamic body.
    starts: Vec<u32>,
    ends: Vec<JointSide>,
}

impl JointGraph {
    /// Links between bodies of these masses.
    pub(crate) fn new(links: Vec<PointLink>, masses: Vec<f32>) -> Self {
        let mut graph = Self { links, masses, ..Self::default() };
        graph.connect();
        graph
    }

    /// Lists the links of each body.
    fn connect(&mut self) {
        let Self { links, masses, starts, ends } = self;
        let sides = || {
            links.iter().enumerate().flat_map(|(link, joint)| {
                [0, 1].into_iter().filter_map(move |side| {
                    joint.bodies[side].map(|body| (body, JointSide { link: link as u32, side: side as u8 }))
                })
            })
        };
        starts.clear();
        starts.resize(masses.len() + 1, 0);
        for (body, _) in sides().filter(|&(body, _)| masses[body as usize].is_finite()) {
            starts[body as usize + 1] += 1;
        }
        for body in 0..masses.len() {
            starts[body + 1] += starts[body];
        }
        ends.clear();
        ends.resize(starts[masses.len()] as usize, JointSide { link: 0, side: 0 });
        let mut next = starts.clone();
        for (body, end) in sides().filter(|&(body, _)| masses[body as usize].is_finite()) {
            ends[next[body as usize] as usize] = end;
            next[body as usize] += 1;
        }
    }

    /// Dynamic body on this side of a joint.
    pub(crate) fn dynamic_body(&self, end: JointSide) -> Option<u32> {
        self.links[end.link as usize].bodies[end.side as usize].filter(|&body| self.masses[body as usize].is_finite())
    }

    /// Ends of joints on a dynamic body.
    pub(crate) fn ends_on(&self, body: u32) -> &[JointSide] {
        &self.ends[self.starts[body as usize] as usize..self.starts[body as usize + 1] as usize]
    }

    /// Whether what is jointed to this end of a joint is so light beside its body that this holds it as something fixed would.
    pub(crate) fn holds_like_fixed(&self, end: JointSide) -> bool {
        let mass = |end: JointSide| self.dynamic_body(end).map_or(f32::INFINITY, |body| self.masses[body as usize]);
        mass(end.other()) < HEAVY_SHARE * mass(end)
    }

    pub(crate) fn point(&self, end: JointSide) -> Vec3 {
        self.links[end.link as usize].points[end.side as usize]
    }

    /// Length of the segment between two joints on one body (m).
    pub(crate) fn segment(&self, from: JointSide, to: JointSide) -> f64 {
        (self.point(to).as_dvec3() - self.point(from).as_dvec3()).length()
    }

    /// Range of the angle at a joint between the segment to `before`, on the body of side `at`, and the segment to `after`, on the
    /// body of the other side.
    pub(crate) fn angle(&self, before: JointSide, at: JointSide, after: JointSide) -> AngleRange {
        let link = &self.links[at.link as usize];
        let direction = |from: JointSide, to: JointSide| (self.point(to) - self.point(from)).try_normalize();
        let (Some(u), Some(w)) = (direction(at, before), direction(at.other(), after)) else { return AngleRange::FREE };
        let (near, far) = (at.side as usize, 1 - at.side as usize);
        let local = |frames: &[Quat; 2]| ((frames[near].conjugate() * u).as_dvec3(), (frames[far].conjugate() * w).as_dvec3());
        let range = match link.turn {
            Turn::Free => return AngleRange::FREE,
            Turn::Fixed { frames } => {
                let (u, w) = local(&frames);
                let angle = u.angle_between(w);
                AngleRange { min: angle, max: angle }
            }
            Turn::Hinge { frames, min, max } => {
                let (u, w) = local(&frames);
                // The hinge turns B against A; seen from B it turns A by the opposite angle.
                let (low, high) = if near == 0 { (min, max) } else { (-max, -min) };
                hinge_range(u, w, f64::from(low), f64::from(high))
            }
            Turn::Swing { frames, limit } => {
                let (u, w) = local(&frames);
                let from_axis = |v: glam::DVec3| libm::atan2(libm::hypot(v.y, v.z), v.x);
                swing_range(from_axis(u), from_axis(w), f64::from(limit))
            }
        };
        AngleRange { min: (range.min - ANGLE_MARGIN).max(0.0), max: (range.max + ANGLE_MARGIN).min(PI) }
    }
}

fn hinge_range(u: glam::DVec3, w: glam::DVec3, low: f64, high: f64) -> AngleRange {
    let across = libm::hypot(u.y, u.z) * libm::hypot(w.y, w.z);
    let aligned = libm::atan2(u.z, u.y) - libm::atan2(w.z, w.y);
    let cosine = |turned: f64| (u.x * w.x + across * libm::cos(turned - aligned)).clamp(-1.0, 1.0);
    // Angles count turns: limits a turn apart, or only one of them, leave every direction.
    let is_whole = (high - low).partial_cmp(&TAU) != Some(std::cmp::Ordering::Less);
    let contains = |angle: f64| is_whole || (angle - low).rem_euclid(TAU) <= high - low;
    let (at_low, at_high) = if is_whole { (0.0, 0.0) } else { (cosine(low), cosine(high)) };
    let greatest = if contains(aligned) { u.x * w.x + across } else { at_low.max(at_high) };
    let least = if contains(aligned + PI) { u.x * w.x - across } else { at_low.min(at_high) };
    AngleRange { min: libm::acos(greatest.clamp(-1.0, 1.0)), max: libm::acos(least.clamp(-1.0, 1.0)) }
}

fn swing_range(from_a: f64, from_b: f64, limit: f64) -> AngleRange {
    let (low, high) = ((from_a - limit).max(0.0), (from_a + limit).min(PI));
    let min = if (low..=high).contains(&from_b) { 0.0 } else { (low - from_b).abs().min((high - from_b).abs()) };
    let widest = |phi: f64| (phi + from_b).min(TAU - phi - from_b);
    let max = if (low..=high).contains(&(PI - from_b)) { PI } else { widest(low).max(widest(high)) };
    AngleRange { min, max }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn limits_of_a_hinge_mean_what_they_say_beyond_half_a_turn() {
        let between = |low: f64, high: f64| {
            let range = hinge_range(DVec3::Y, DVec3::Y, low.to_radians(), high.to_radians());
            [range.min.to_degrees(), range.max.to_degrees()]
        };
        let is = |found: [f64; 2], expected: [f64; 2]| {
            let off = (0..2).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
            assert!(off < 1.0e-4, "{found:?}, expected {expected:?} degrees");
        };
        is(between(190.0, 200.0), [160.0, 170.0]);
        is(between(0.0, 200.0), [0.0, 180.0]);
        is(between(170.0, 200.0), [160.0, 180.0]);
        is(between(-400.0, -380.0), [20.0, 40.0]);
        for (low, high) in [(-180.0, 180.0), (-720.0, 720.0), (0.0, f64::INFINITY), (f64::NEG_INFINITY, f64::INFINITY)] {
            is(between(low, high), [0.0, 180.0]);
        }
    }
}
