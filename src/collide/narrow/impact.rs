//! When two moving shapes first overlap, by conservative advancement (Mirtich 1996).
//!
//! With n the direction along which two convex parts are a distance s apart, s cannot shrink faster than their centres approach along
//! n plus what both turn at their reach. So nothing happens for s over that speed, and the search goes on from there. Over a straight
//! path between convex parts s is a convex function of time: the steps are those of Newton's method from the safe side.
//!
//! What counts is an overlap of `depth`: surfaces that slide or roll on each other touch all along, and must not be stopped.

use glam::{DVec3, Quat, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose3;

use super::part::Part;
use super::{composite, convex};
use crate::shape::Shape;

/// Searches for nearest points after which a pair of parts is taken to be where the last one found it.
const MAX_SEARCHES: u32 = 48;

/// Share of the depth asked for that counts as that depth: the steps end just before it.
const DEEP_ENOUGH: f32 = 0.9;

/// Greatest speed of turning over a stretch of the path that is taken into account (rad): that of a turn by 2.65 rad. Beyond, a turn
/// cannot be told from one in the other direction.
const MAX_TURN: f32 = 8.0;

/// A body at a time: its centre of mass (m), and how it is turned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyPose {
    pub center: DVec3,
    pub rotation: Quat,
}

impl BodyPose {
    pub(crate) const ORIGIN: Self = Self { center: DVec3::ZERO, rotation: Quat::IDENTITY };

    /// In between, at a share of the way.
    pub(crate) fn lerp(&self, to: &Self, share: f32) -> Self {
        Self { center: self.center.lerp(to.center, f64::from(share)), rotation: self.rotation.lerp(to.rotation, share) }
    }
}

/// A body's way through a step: straight to `turn`, which it reaches after a share `until` of the step, and straight from there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyPath {
    pub start: BodyPose,
    pub until: f32,
    pub turn: BodyPose,
    pub end: BodyPose,
}

impl BodyPath {
    /// Straight all the way.
    pub(crate) fn straight(start: BodyPose, end: BodyPose) -> Self {
        Self { start, until: 1.0, turn: end, end }
    }

    /// Where the body is after a share of the step, 0 to 1.
    pub(crate) fn at(&self, time: f32) -> BodyPose {
        if time < self.until {
            self.start.lerp(&self.turn, time / self.until)
        } else if self.until < 1.0 {
            self.turn.lerp(&self.end, ((time - self.until) / (1.0 - self.until)).min(1.0))
        } else {
            self.turn
        }
    }
}

/// A shape on a body that moves along a path.
pub(crate) struct MovingShape<'a> {
    pub shape: &'a Shape,
    pub path: BodyPath,
    /// Origin of the shape in the frame of the body, from its centre of mass (m), and how the shape is turned there.
    pub place: (Vec3, Quat),
    /// Distance from the centre of mass to the farthest point of the shape (m).
    pub reach: f32,
}

/// Ids of parts near a path, reused from call to call.
#[derive(Debug, Default)]
pub(crate) struct ImpactBuffer {
    parts: Vec<u32>,
}

/// Share of the step after which `a` is within `short` of `b` on a way that leads into an overlap of `depth` (m), if it does. What
/// overlaps as deep at the start is passed over.
pub(crate) fn first_touch(
    a: &MovingShape,
    b: &MovingShape,
    (short, depth): (f32, f32),
    buffer: &mut ImpactBuffer,
) -> Option<f32> {
    let mut first: Option<f32> = None;
    for id_a in 0..composite::part_count(a.shape) {
        let Some((part_a, place_a)) = composite::part_at(a.shape, id_a) else { continue };
        let bounds = path_bounds(&part_a, &place_a, a, b).loosened(short);
        composite::near_parts(b.shape, Some(&bounds), &mut buffer.parts);
        for &id_b in &buffer.parts {
            let Some((part_b, place_b)) = composite::part_at(b.shape, id_b) else { continue };
            let pair = PartPair {
                a: MovingPart { part: &part_a, place: place_a, on: a },
                b: MovingPart { part: &part_b, place: place_b, on: b },
            };
            if let Some(time) = pair.first_touch(short, depth)
                && first.is_none_or(|least| time < least)
            {
                first = Some(time);
            }
        }
    }
    first
}

/// Box, in the frame of `b`, that holds a part of `a` all along its way.
fn path_bounds(part: &Part, place: &Pose3, a: &MovingShape, b: &MovingShape) -> Aabb {
    let times = [0.0, a.path.until, b.path.until, 1.0];
    let boxes = times.map(|time| part.bounds(&(relative(b.pose_at(time), a.pose_at(time)) * *place)));
    let whole = boxes[1..].iter().fold(boxes[0], |whole, more| whole.merged(more));
    // Between these, a turn bulges the way by no more than the sagitta of its arc.
    let bulge = |of: &MovingShape, radius: f32| {
        let turn = of.turning();
        if turn > 0.0 { radius * (0.125 * turn * turn).min(2.0) } else { 0.0 }
    };
    let seen_from_b = whole.extents().length() + whole.center().length();
    whole.loosened(bulge(a, a.reach) + bulge(b, seen_from_b))
}

/// Greatest speed at which the rotation between two poses turns, if it goes evenly on the chord (rad over the stretch).
fn turn_between(from: &BodyPose, to: &BodyPose) -> f32 {
    let between = from.rotation.conjugate() * to.rotation;
    let sine = Vec3::new(between.x, between.y, between.z).length();
    (2.0 * sine / between.w.abs().max(f32::MIN_POSITIVE)).min(MAX_TURN)
}

/// Pose of one place in the frame of another.
fn relative((position, rotation): (DVec3, Quat), (other_position, other_rotation): (DVec3, Quat)) -> Pose3 {
    let inverse = rotation.conjugate();
    Pose3::from_parts(inverse * (other_position - position).as_vec3(), inverse * other_rotation)
}

impl MovingShape<'_> {
    /// How far the body turns on its way, if it goes evenly on chords (rad).
    pub(crate) fn turning(&self) -> f32 {
        turn_between(&self.path.start, &self.path.turn) + turn_between(&self.path.turn, &self.path.end)
    }

    fn pose_at(&self, time: f32) -> (DVec3, Quat) {
        let body = self.path.at(time);
        (body.center + (body.rotation * self.place.0).as_dvec3(), body.rotation * self.place.1)
    }
}

/// A part of a moving shape.
struct MovingPart<'a> {
    part: &'a Part<'a>,
    /// In the frame of the shape.
    place: Pose3,
    on: &'a MovingShape<'a>,
}

impl MovingPart<'_> {
    /// Distance from the body's centre of mass to the farthest point of the part's core (m).
    fn core_reach(&self) -> f32 {
        let center = self.on.place.0 + self.on.place.1 * self.place.translation;
        match self.part {
            Part::HalfSpace { .. } => self.on.reach,
            part => center.length() + part.reach() - part.rounding(),
        }
    }
}

struct PartPair<'a> {
    a: MovingPart<'a>,
    b: MovingPart<'a>,
}

/// What happens in a stretch of the way.
enum PathStretch {
    /// The two come as deep into one another as was asked, and were near each other first at this time.
    Deep(f32),
    /// They do not, but are near each other at the end, since this time.
    Near(f32),
    Apart,
}

impl PartPair<'_> {
    fn first_touch(&self, short: f32, depth: f32) -> Option<f32> {
        let (until_a, until_b) = (self.a.on.path.until, self.b.on.path.until);
        let mut near_since = None;
        let mut from = 0.0;
        for to in [until_a.min(until_b), until_a.max(until_b), 1.0] {
            if to <= from {
                continue;
            }
            match self.advance((from, to), near_since, short, depth) {
                PathStretch::Deep(since) => return (since >= 0.0).then_some(since),
                PathStretch::Near(since) => near_since = Some(since),
                PathStretch::Apart => near_since = None,
            }
            from = to;
        }
        None
    }

    /// Follows the two through a stretch in which both go straight. Parts that begin deep in one another are [`PathStretch::Deep`] since a
    /// time before zero.
    fn advance(&self, (from, to): (f32, f32), mut near_since: Option<f32>, short: f32, depth: f32) -> PathStretch {
        let ends = [from, to].map(|time| (self.a.on.path.at(time), self.b.on.path.at(time)));
        let closing = ((ends[1].0.center - ends[0].0.center) - (ends[1].1.center - ends[0].1.center)).as_vec3();
        let turning = turn_between(&ends[0].0, &ends[1].0) * self.a.core_reach()
            + turn_between(&ends[0].1, &ends[1].1) * self.b.core_reach();
        // Rates over the stretch, in which `gone` runs from 0 to 1.
        let fastest = closing.length() + turning;
        let mut gone = 0.0;
        for _ in 0..MAX_SEARCHES {
            let time = from + (to - from) * gone;
            let still = fastest * (1.0 - gone);
            let Some((normal, separation)) = self.gap(time, still.max(2.0 * short)) else { return PathStretch::Apart };
            if separation <= -DEEP_ENOUGH * depth {
                return PathStretch::Deep(if time > 0.0 { near_since.unwrap_or(time) } else { -1.0 });
            }
            match near_since {
                None if separation <= short => near_since = Some(time),
                Some(_) if separation > 2.0 * short => near_since = None,
                _ => {}
            }
            let aim = if near_since.is_some() { -depth } else { 0.5 * short };
            let speed = normal.dot(closing) + turning;
            if speed * (1.0 - gone) <= separation - aim {
                // From here on nothing brings them to what is aimed at.
                return near_since.map_or(PathStretch::Apart, PathStretch::Near);
            }
            gone += (separation - aim) / speed;
        }
        // Steps have become too small to matter: they lie at what is aimed at.
        near_since.map_or(PathStretch::Apart, PathStretch::Deep)
    }

    /// Direction from A to B in world axes, and how far they are apart along it (m); none if further than `limit`.
    fn gap(&self, time: f32, limit: f32) -> Option<(Vec3, f32)> {
        let (place_a, place_b) = (self.a.on.pose_at(time), self.b.on.pose_at(time));
        let between = self.a.place.inverse() * relative(place_a, place_b) * self.b.place;
        let (normal, separation) = convex::separation(self.a.part, self.b.part, &between, limit)?;
        Some((place_a.1 * (self.a.place.rotation * normal), separation))
    }
}
