//! The shapes themselves, each asked in double precision in a frame whose origin is that of the question.

use glam::{DVec3, Vec3};

use super::cast::{self, CastMotion, Meeting};
use super::gap::{self, Gap};
use super::part::{ConvexPart, PartForm, PartPose};
use super::parts::{self, PlacedPart};
use super::region::PathSegment;
use super::{Distance, Probe, ray};
use crate::body::Body;
use crate::collide::collider::Collider;
use crate::pose::Pose;
use crate::shape::{Geometry, Shape};

/// Room around the box of a probe, over its extent: the box is of single precision.
const BOX_SLACK: f64 = 1.0e-6;

/// By how much the region is widened in which the nearest part of a shape is searched, each time that it holds none.
const WIDENING: f64 = 3.0;

/// Where something was met.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Met {
    /// How far along the way (m).
    pub distance: f64,
    /// What share of the way, 0 to 1.
    pub share: f64,
    /// On the surface of what is met (m).
    pub point: DVec3,
    /// Its outward unit normal there.
    pub normal: Vec3,
    /// How deep the two overlap from the start (m).
    pub depth: f64,
    pub part: Option<u32>,
    pub triangle: Option<u32>,
}

/// A probe on its way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sweep<'a> {
    pub probe: Probe<'a>,
    /// Whole path (m).
    pub path: DVec3,
    /// Whole turn about the probe's origin: unit axis times angle (rad).
    pub turn: DVec3,
    /// Whether what overlaps or touches the probe from the start does not count.
    pub ignore_overlapped: bool,
}

impl Sweep<'_> {
    /// The way of a box around the probe, in the world (m).
    pub(crate) fn path_box(&self) -> PathSegment {
        let length = self.path.length();
        let direction = if length > 0.0 { self.path / length } else { DVec3::X };
        if self.turn == DVec3::ZERO {
            return PathSegment { direction, length, ..probe_box(&self.probe) };
        }
        let mut reach: f64 = 0.0;
        self.probe.parts(self.probe.pose.position, &mut |part| reach = reach.max(part.place.origin.length() + part.reach()));
        PathSegment { origin: self.probe.pose.position, direction, length, half: DVec3::splat(reach * (1.0 + BOX_SLACK)) }
    }
}

impl<'a> Probe<'a> {
    fn placed(&self, frame: DVec3) -> PlacedPart<'a> {
        placed(self.shape, self.pose, frame)
    }

    /// Every part of the probe; a solid is convex or made of convex parts.
    fn parts(&self, frame: DVec3, visit: &mut dyn FnMut(&ConvexPart<'a>)) {
        let (low, high) = self.placed(frame).bounds();
        parts::near(self.placed(frame), low, high, visit);
    }
}

fn placed(shape: &Shape, pose: Pose, frame: DVec3) -> PlacedPart<'_> {
    PlacedPart { shape, place: PartPose::new(pose.position - frame, pose.rotation) }
}

/// A shape of a world, and the body that it is on.
#[derive(Clone, Copy)]
pub(crate) struct BodyShape<'a> {
    pub collider: &'a Collider,
    pub body: &'a Body,
}

impl<'a> BodyShape<'a> {
    /// The shape in the frame of a query: its own pose after that of its body. As collision keeps them together, in single precision, it is off
    /// by the rounding of its distance from the body's centre.
    fn at(&self, frame: DVec3) -> PlacedPart<'a> {
        let (pose, own) = (self.body.pose(), &self.collider.local_pose);
        let place = PartPose::new(pose.position - frame, pose.rotation).then(own.position, own.rotation);
        PlacedPart { shape: &self.collider.shape, place }
    }

    /// The origin of a query between this shape and another: that of a solid is near it.
    fn frame_with(&self, other: &BodyShape) -> DVec3 {
        let solid = if self.collider.shape.geometry().is_solid() { self } else { other };
        solid.collider.place.0
    }
}

/// Where a ray first meets a shape; from outside, if what it begins in is left out.
pub(crate) fn first_on_ray(shape: BodyShape, of: &PathSegment, ignore_overlapped: bool) -> Option<Met> {
    let (direction, length) = (of.direction, of.length);
    let path = PathSegment { origin: DVec3::ZERO, ..*of };
    let mut best: Option<Met> = None;
    parts::along(shape.at(of.origin), &path, &mut |part, _| {
        let limit = best.map_or(length, |best| best.distance);
        if let Some((distance, normal)) = ray::enter(part, DVec3::ZERO, direction, limit)
            && !(distance == 0.0 && ignore_overlapped)
            && best.is_none_or(|best| (distance, part.triangle) < (best.distance, best.triangle))
        {
            best = Some(Met {
                distance,
                share: if length > 0.0 { distance / length } else { 0.0 },
                point: of.origin + direction * distance,
                normal: normal.as_vec3().normalize(),
                depth: 0.0,
                part: part.part,
                triangle: part.triangle,
            });
        }
        best.map_or(length, |best| best.distance)
    });
    best
}

/// Where a moving solid first meets a shape.
pub(crate) fn first_on_sweep(shape: BodyShape, sweep: &Sweep) -> Option<Met> {
    let frame = sweep.probe.pose.position;
    let (way, length) = (sweep.path_box(), sweep.path.length());
    let way = PathSegment { origin: way.origin - frame, ..way };
    let motion = CastMotion { path: sweep.path, turn: sweep.turn, center: DVec3::ZERO };
    let mut probe = Vec::new();
    sweep.probe.parts(frame, &mut |moving| probe.push(*moving));
    let key = |met: &Meeting, triangle: Option<u32>| (met.share, met.gap.distance, triangle);
    let mut best: Option<(Meeting, Option<u32>, Option<u32>)> = None;
    parts::along(shape.at(frame), &way, &mut |fixed, _| {
        let mut first: Option<Meeting> = None;
        let mut is_overlapped = false;
        for moving in &probe {
            let limit = first.or(best.map(|(best, ..)| best)).map_or(1.0, |known| known.share);
            let Some(met) = cast::first_meeting(fixed, moving, &motion, limit) else { continue };
            is_overlapped |= met.from_start;
            if first.is_none_or(|first| key(&met, None) < key(&first, None)) {
                first = Some(met);
            }
        }
        // What one part of the probe begins in is left out for all of them.
        let counting = first.filter(|_| !(is_overlapped && sweep.ignore_overlapped));
        if let Some(met) = counting
            && best.is_none_or(|(best, _, triangle)| key(&met, fixed.triangle) < key(&best, triangle))
        {
            best = Some((met, fixed.part, fixed.triangle));
        }
        // Along the path at least this much is still to be looked at; a turn may reach as far from its start.
        best.map_or(f64::INFINITY, |(best, ..)| best.share * length)
    });
    best.map(|(met, part, triangle)| Met {
        distance: met.share * length,
        share: met.share,
        point: frame + met.gap.on_a,
        normal: met.gap.normal.as_vec3().normalize(),
        depth: if met.from_start { (-met.gap.distance).max(0.0) } else { 0.0 },
        part,
        triangle,
    })
}

/// Whether a solid and a shape overlap or touch.
pub(crate) fn overlaps(shape: BodyShape, probe: &Probe) -> bool {
    let frame = probe.pose.position;
    meet(shape.at(frame), probe.placed(frame))
}

/// Whether two shapes of a world overlap or touch.
pub(crate) fn shapes_overlap(a: BodyShape, b: BodyShape) -> bool {
    let frame = a.frame_with(&b);
    meet(a.at(frame), b.at(frame))
}

fn meet(a: PlacedPart, b: PlacedPart) -> bool {
    let mut met = false;
    pairs(a, &|low, high, visit| parts::near(b, low, high, visit), b.bounds(), 0.0, &mut |part_a, part_b| {
        met = met || gap::distance(part_a, part_b).is_some_and(|distance| distance <= gap::touch(part_a, part_b));
    });
    met
}

/// Nearest points of a solid and a shape not farther apart than `limit` (m), or those of least overlap.
pub(crate) fn distance_to(shape: BodyShape, probe: &Probe, limit: f64) -> Option<Distance> {
    let frame = probe.pose.position;
    separation(shape.at(frame), probe.placed(frame), limit).map(|found| found.in_world(frame))
}

/// Nearest points of two shapes of a world, or those of least overlap; none of two half-spaces.
pub(crate) fn distance_between(a: BodyShape, b: BodyShape) -> Option<Distance> {
    let frame = a.frame_with(&b);
    separation(a.at(frame), b.at(frame), f64::INFINITY).map(|found| found.in_world(frame))
}

/// The nearest point of a shape not farther than `limit` (m); the point itself inside.
pub(crate) fn nearest_point(shape: BodyShape, point: DVec3, limit: f64) -> Option<Distance> {
    let place = PartPose { origin: DVec3::ZERO, axes: glam::DMat3::IDENTITY };
    let part = ConvexPart { form: PartForm::Point, place, rounding: 0.0, part: None, triangle: None };
    let here = (DVec3::ZERO, DVec3::ZERO);
    let found = search(shape.at(point), &|_, _, visit| visit(&part), here, limit)?.in_world(point);
    let is_inside = found.distance <= 0.0;
    Some(if is_inside { Distance { distance: 0.0, point_a: point, ..found } } else { found })
}

/// Visits the parts of a shape that may meet the box between two corners.
type Near<'n, 'b> = &'n dyn Fn(DVec3, DVec3, &mut dyn FnMut(&ConvexPart<'b>));

/// Visits every pair of parts whose boxes, widened by `margin`, meet; by one below zero they are not shrunk: what overlaps is as
/// deep as it is, however little its box reaches into the other. B is known by its box and by its parts.
fn pairs<'a, 'b>(
    a: PlacedPart<'a>,
    near_b: Near<'_, 'b>,
    (low, high): (DVec3, DVec3),
    margin: f64,
    visit: &mut dyn FnMut(&ConvexPart<'a>, &ConvexPart<'b>),
) {
    let room = DVec3::splat(margin.max(0.0));
    parts::near(a, low - room, high + room, &mut |part_a| {
        let (low, high) = part_a.bounds();
        near_b(low - room, high + room, &mut |part_b| visit(part_a, part_b));
    });
}

fn separation(a: PlacedPart, b: PlacedPart, limit: f64) -> Option<Distance> {
    search(a, &|low, high, visit| parts::near(b, low, high, visit), b.bounds(), limit)
}

/// The least gap between two shapes that is not above `limit`, which may be a depth, in regions around B that grow until one holds it.
fn search(a: PlacedPart, near_b: Near, (low, high): (DVec3, DVec3), limit: f64) -> Option<Distance> {
    let (least, greatest) = a.bounds();
    let apart = (least - high).max(low - greatest).max(DVec3::ZERO).length();
    let mut reach = if a.is_single() { limit } else { apart + a.grain() };
    loop {
        let reach_now = reach.min(limit);
        let mut best: Option<Distance> = None;
        pairs(a, near_b, (low, high), reach_now.min(1.0e10), &mut |part_a, part_b| {
            if let Some(gap) = gap::gap(part_a, part_b)
                && gap.distance <= limit
                && best.as_ref().is_none_or(|best| gap.distance < best.distance)
            {
                best = Some(Distance::of(&gap, part_a, part_b));
            }
        });
        let is_certain = best.as_ref().is_some_and(|best| best.distance <= reach_now);
        // Nothing of either is farther from the other than this.
        let all = apart + (greatest - least).length() + (high - low).length();
        if is_certain || reach_now >= limit || reach_now >= all {
            return best;
        }
        reach *= WIDENING;
    }
}

impl Distance {
    fn of(gap: &Gap, a: &ConvexPart, b: &ConvexPart) -> Self {
        Self {
            distance: gap.distance,
            normal: gap.normal.as_vec3().normalize(),
            point_a: gap.on_a,
            point_b: gap.on_b,
            parts: [a.part, b.part],
            triangles: [a.triangle, b.triangle],
        }
    }

    fn in_world(self, frame: DVec3) -> Self {
        Self { point_a: self.point_a + frame, point_b: self.point_b + frame, ..self }
    }
}

impl PlacedPart<'_> {
    fn is_single(&self) -> bool {
        !matches!(self.shape.geometry(), Geometry::TriangleMesh { .. } | Geometry::HeightField { .. } | Geometry::Compound { .. })
    }

    /// The box around a shape in the frame of the query (m).
    fn bounds(&self) -> (DVec3, DVec3) {
        if let Some(part) = ConvexPart::whole(self.shape.geometry(), self.shape.hull(), self.place) {
            return part.bounds();
        }
        let own = self.shape.parry().compute_local_aabb();
        let (center, half) = (own.center().as_dvec3(), own.half_extents().as_dvec3());
        let axes = self.place.axes;
        let half = axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
        let half = half + DVec3::splat(BOX_SLACK * half.max_element());
        let center = self.place.to_frame(center);
        (center - half, center + half)
    }

    /// About how large one part of a shape of many is (m).
    fn grain(&self) -> f64 {
        let count = match self.shape.geometry() {
            Geometry::TriangleMesh { triangles, .. } => triangles.len(),
            Geometry::HeightField { heights, .. } => heights.len(),
            _ => 1,
        };
        let (low, high) = self.bounds();
        (high - low).length() / (count as f64).sqrt()
    }
}

/// The box around a probe, in the world (m).
pub(crate) fn probe_box(probe: &Probe) -> PathSegment {
    let (low, high) = probe.placed(probe.pose.position).bounds();
    let half = (high - low) * 0.5;
    let slack = BOX_SLACK * half.max_element();
    PathSegment::still(probe.pose.position + (low + high) * 0.5, half + DVec3::splat(slack))
}
