//! When two moving shapes first overlap, by conservative advancement (Mirtich 1996).
//!
//! With n the direction along which two convex parts are a distance s apart, s cannot shrink faster than their centres approach along
//! n plus what both turn along n: |n × ω| times how far from a body's centre the two can meet. So they cannot touch before s divided by
//! that speed, and the search goes on from there. Over a straight path between convex parts s is a convex function of time: the steps are
//! those of Newton's method, and never pass the touch.
//!
//! A touch counts only if it leads to an overlap of `depth`: surfaces that slide or roll on each other touch all along, and must not be
//! stopped.

use glam::{DVec3, Quat, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose3;

use super::part::Part;
use super::{composite, convex};
use crate::shape::Shape;

/// Most distance queries for one pair of parts; a pair that has not converged by then stops where it first came near,
/// or else where the last query found it.
const MAX_SEARCHES: u32 = 48;

/// Share of the depth asked for that counts as that depth: steps of conservative advancement end just before it.
const DEEP_ENOUGH: f32 = 0.9;

/// How far the axis of a round part may be from the centre of mass of its body and count as through it, over the reach of the part: rounding.
const ABOUT_CENTER: f32 = 1.0e-5;

/// A body at a time: its centre of mass (m), and how it is turned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyPose {
    pub center: DVec3,
    pub rotation: Quat,
}

impl BodyPose {
    pub(crate) const ORIGIN: Self = Self { center: DVec3::ZERO, rotation: Quat::IDENTITY };

    /// The pose between the two after this share of the way, 0 to 1.
    pub(crate) fn lerp(&self, to: &Self, share: f64) -> Self {
        Self { center: self.center.lerp(to.center, share), rotation: self.rotation.lerp(to.rotation, share as f32) }
    }
}

/// A body's path through a step, or through the rest of one: its centre goes straight, its quaternion is interpolated (nlerp).
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyPath {
    pub start: BodyPose,
    pub end: BodyPose,
}

impl BodyPath {
    /// Where the body is after a share of the way, 0 to 1.
    pub(crate) fn at(&self, share: f64) -> BodyPose {
        self.start.lerp(&self.end, share)
    }

    /// How fast the body turns at most (rad over the way).
    fn turning(&self) -> f32 {
        turn_between(&self.start, &self.end).length()
    }

    /// How far a point at a distance of `reach` (m) from the centre of mass can swing out of the line between its two ends.
    pub(crate) fn bulge(&self, reach: f32) -> f32 {
        let turn = self.turning();
        reach * (0.125 * turn * turn).min(2.0)
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

/// Distances that decide what counts as a touch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Distance at which two shapes are near each other (m), and overlap in which they are deep in one another.
    pub short: f32,
    pub depth: f32,
    /// Overlap that counts instead where the two are near each other at the start, so that contacts have seen them (m); those that overlap
    /// by that are let through.
    pub depth_if_near: Option<f32>,
    /// Whether shapes that overlap by `depth` at the start are let through otherwise; if not, they may go deeper by another `depth`.
    pub passes_deep: bool,
}

/// Ids of parts near a path, reused from call to call.
#[derive(Debug, Default)]
pub(crate) struct ImpactBuffer {
    parts: Vec<u32>,
}

/// If the path of `a` leads deep into `b`: the share of the path after which it first comes near, and the direction from `a` to `b` then
/// (unit vector, world axes).
pub(crate) fn first_touch(a: &MovingShape, b: &MovingShape, limits: &Limits, buffer: &mut ImpactBuffer) -> Option<(f64, Vec3)> {
    let mut first: Option<(f64, Vec3)> = None;
    for id_a in 0..composite::part_count(a.shape) {
        let Some((part_a, place_a)) = composite::part_at(a.shape, id_a) else { continue };
        let bounds = path_bounds(&part_a, &place_a, a, b, limits.short);
        composite::near_parts(b.shape, bounds.as_ref(), &mut buffer.parts);
        for &id_b in &buffer.parts {
            let Some((part_b, place_b)) = composite::part_at(b.shape, id_b) else { continue };
            let pair = PartPair {
                a: MovingPart { part: &part_a, place: place_a, on: a },
                b: MovingPart { part: &part_b, place: place_b, on: b },
            };
            if let Some(touch) = pair.first_touch(*limits)
                && first.is_none_or(|least| touch.0 < least.0)
            {
                first = Some(touch);
            }
        }
    }
    first
}

/// Box in the frame of `b` that holds a part of `a` all along its path, enlarged by `margin` (m); `None` where it is not finite.
fn path_bounds(part: &Part, place: &Pose3, a: &MovingShape, b: &MovingShape, margin: f32) -> Option<Aabb> {
    let [start, end] = [0.0, 1.0].map(|time| part.bounds(&(relative(b.pose_at(time), a.pose_at(time)) * *place)));
    let whole = start.merged(&end);
    // Between the two, a turn bulges the way by no more than the sagitta of its arc.
    let seen_from_b = whole.extents().length() + whole.center().length();
    let margin = margin + a.path.bulge(a.reach) + b.path.bulge(seen_from_b);
    // Written so that a NaN gives none.
    (0.0..f32::INFINITY).contains(&margin).then(|| whole.loosened(margin))
}

/// Greatest angular velocity between two poses where nlerp interpolates them (rad over the path, world axes). For a turn by θ it is
/// 4 tan(θ/4) about one axis, at most 4/π times that of an even turn.
fn turn_between(from: &BodyPose, to: &BodyPose) -> Vec3 {
    let between = to.rotation * from.rotation.conjugate();
    Vec3::new(between.x, between.y, between.z) * (4.0 / (1.0 + between.w.abs()))
}

/// The second pose in the frame of the first.
fn relative((position, rotation): (DVec3, Quat), (other_position, other_rotation): (DVec3, Quat)) -> Pose3 {
    let inverse = rotation.conjugate();
    Pose3::from_parts(inverse * (other_position - position).as_vec3(), inverse * other_rotation)
}

impl MovingShape<'_> {
    /// Greatest angular velocity of the body on its path (rad over the path).
    pub(crate) fn turning(&self) -> f32 {
        self.path.turning()
    }

    fn pose_at(&self, time: f64) -> (DVec3, Quat) {
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
    /// Distance from the body's centre of mass to the farthest point of the part's core (m) that may meet the other part. Points further
    /// out than the other shape ever comes do not count.
    fn core_reach(&self, other: &Self) -> f32 {
        let center = self.on.place.0 + self.on.place.1 * self.place.translation;
        let whole = match self.part {
            Part::HalfSpace { .. } => self.on.reach,
            part => center.length() + part.reach() - part.rounding(),
        };
        let [own, others] = [self, other].map(|side| &side.on.path);
        let apart = [(own.start, others.start), (own.end, others.end)].map(|(a, b)| (a.center - b.center).length() as f32);
        whole.min(apart[0].max(apart[1]) + other.on.reach + self.part.rounding())
    }

    /// What of a turn of the body (rad over the path) takes the part anywhere: not that about an axis of its own, if that goes through the centre of mass.
    fn swing(&self, spin: Vec3) -> f32 {
        if !matches!(self.part, Part::Cylinder { .. } | Part::Cone { .. } | Part::Capsule { .. }) {
            return spin.length();
        }
        let (offset, turn) = self.on.place;
        let (center, axis) = (offset + turn * self.place.translation, turn * (self.place.rotation * Vec3::Y));
        let is_about_center =
            center.reject_from(axis).length_squared() <= ABOUT_CENTER * ABOUT_CENTER * self.part.reach().powi(2);
        let axis = self.on.path.start.rotation * axis;
        if is_about_center { spin.reject_from(axis).length() } else { spin.length() }
    }
}

struct PartPair<'a> {
    a: MovingPart<'a>,
    b: MovingPart<'a>,
}

impl PartPair<'_> {
    /// As the [`first_touch`] of two shapes.
    fn first_touch(&self, Limits { short, mut depth, depth_if_near, passes_deep }: Limits) -> Option<(f64, Vec3)> {
        let [a, b] = [&self.a.on.path, &self.b.on.path];
        let closing = ((a.end.center - a.start.center) - (b.end.center - b.start.center)).as_vec3();
        let spins = [a, b].map(|path| turn_between(&path.start, &path.end));
        let reaches = [self.a.core_reach(&self.b), self.b.core_reach(&self.a)];
        // Speeds are over the path, on which `gone` runs from 0 to 1.
        let swings = [self.a.swing(spins[0]), self.b.swing(spins[1])];
        let fastest = closing.length() + swings[0] * reaches[0] + swings[1] * reaches[1];
        let (mut gone, mut near_since, mut last) = (0.0, None, None);
        // How far apart they are at the start, if contacts have seen them there.
        let mut seen = None;
        for _ in 0..MAX_SEARCHES {
            let to_go = (1.0 - gone) as f32;
            let (normal, separation) = self.gap(gone, (fastest * to_go).max(2.0 * short))?;
            if gone == 0.0 {
                match depth_if_near {
                    Some(deep) if separation <= -DEEP_ENOUGH * deep => return None,
                    Some(deep) if separation <= short => (seen, depth) = (Some(separation), deep),
                    None if separation <= -DEEP_ENOUGH * depth && passes_deep => return None,
                    None if separation <= -DEEP_ENOUGH * depth => depth -= separation,
                    _ => {}
                }
            }
            if separation <= -DEEP_ENOUGH * depth {
                let touch = seen.map_or(near_since, |before| self.deeper_by(short, before, gone));
                return Some(touch.unwrap_or((gone, normal)));
            }
            match near_since {
                None if separation <= short && seen.is_none() => near_since = Some((gone, normal)),
                Some(_) if separation > 2.0 * short => near_since = None,
                _ => {}
            }
            let aim = if near_since.is_some() || seen.is_some() { -depth } else { 0.5 * short };
            // What turns about the normal does not come closer along it.
            let turns = |i: usize| normal.cross(spins[i]).length().min(swings[i]) * reaches[i];
            let turning = turns(0) + turns(1);
            let speed = normal.dot(closing) + turning;
            if speed * to_go <= separation - aim {
                // They cannot come as near as `aim` on the rest of the path.
                return None;
            }
            gone += f64::from((separation - aim) / speed);
            last = Some((gone, normal));
        }
        // Not converged: a body that turns fast close to another goes no further in this step.
        near_since.or(last)
    }

    /// When two that are as far apart as `before` at the start (m), and deep in each other after a share of the path, overlap by more than at
    /// the start by about `short`: what touches first is no longer what touched then, and contacts will see it there.
    fn deeper_by(&self, short: f32, before: f32, deep_at: f64) -> Option<(f64, Vec3)> {
        let (mut range, mut touch) = ([0.0, deep_at], None);
        for _ in 0..MAX_SEARCHES {
            let middle = 0.5 * (range[0] + range[1]);
            let (normal, separation) = self.gap(middle, f32::INFINITY)?;
            let is_deeper = separation < before - short;
            range[usize::from(is_deeper)] = middle;
            if is_deeper {
                touch = Some((middle, normal));
                if separation > before - 2.0 * short {
                    break;
                }
            }
        }
        touch
    }

    /// Direction from A to B in world axes, and how far they are apart along it (m); none if further than `limit`.
    fn gap(&self, time: f64, limit: f32) -> Option<(Vec3, f32)> {
        let (place_a, place_b) = (self.a.on.pose_at(time), self.b.on.pose_at(time));
        let between = self.a.place.inverse() * relative(place_a, place_b) * self.b.place;
        let (normal, separation) = convex::separation(self.a.part, self.b.part, &between, limit)?;
        Some((place_a.1 * (self.a.place.rotation * normal), separation))
    }
}
