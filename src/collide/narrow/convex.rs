//! Any two convex parts: a direction from GJK and EPA, then clipping of the features that face each other along it.
//!
//! parry3d's GJK gives the direction between parts apart, its EPA the way out of an overlap. Near touching, both are noise
//! in `f32`, and far from it too where one part is much longer than the other; what keeps a resting contact still is that a face as
//! good as the direction found takes its place. An answer counts where its direction keeps what it promises and its points face
//! each other along it. In place of any other, or of none at all, comes one found in `f64` (fine.rs) between the parts pulled apart along
//! the best direction known, so that no overlap is ever lost.
//!
//! parry3d works on the parts scaled to 1, for its tolerances are absolute.

use glam::{DVec3, Vec3};
use parry3d::math::Pose3;
use parry3d::query::details::NormalConstraints;
use parry3d::query::epa::EPA;
use parry3d::shape::SupportMap;

use super::beside::{self, Across, Side};
use super::clip;
use super::convex_pair::ConvexPair;
use super::distance::{self, ConvexGap, Nearest};
use super::face::{self, Corner, Feature};
use super::fine;
use super::known_face::Known;
use super::part::Part;
use super::plane::ContactPlane;
use super::reduce::{PointCandidate, reduce_into};
use super::segment::Segment;
use super::{Manifold, ManifoldPoint};

/// How much less than the distance found a face may give and still be the normal; a direction that gives less than the
/// distance by this much is noise. Fractions of the distance and of the smaller part.
const SLACK: (f32, f32) = (2.0e-3, 1.0e-4);

/// How far sideways the nearest points of parts that do not touch may be from facing each other across a face, as a fraction
/// of the smaller part.
const SKEW: f32 = 1.0e-3;

/// How far outside a face the point of deepest overlap may be, as a fraction of the smaller part: corners stand for round
/// rims, and directions are not exact.
const OVERHANG: f32 = 0.02;

/// Where a triangle's neighbours have turned the normal, points deeper than this many times the original depth are thought
/// to belong to another triangle.
const MAX_DEEPENING: f32 = 5.0;

/// Most searches for a shorter way out, each from the last: pulled by a twentieth of its reach, a direction is off by some twentieth of
/// what the last was, and a few are enough.
const MAX_PULLS: u32 = 16;

/// A search that shortens the way out by no more than this is the last, as a fraction of the smaller part: a tenth of the slack.
const EXACT: f32 = 1.0e-5;

/// How far apart parts are moved so that nearest points show the direction, as a fraction of the smaller.
const CLEARANCE: f32 = 0.05;

/// Feature of the nearest points, where they are no vertex of a clipped polygon.
pub(super) const LONE: u32 = u32::MAX;

/// Reused from call to call.
#[derive(Default)]
pub(super) struct Buffers {
    pub corners_a: Vec<Corner>,
    pub corners_b: Vec<Corner>,
    pub candidates: Vec<PointCandidate>,
    epa: EPA,
    polygon: Vec<clip::ClipVertex>,
    clipped: Vec<clip::ClipVertex>,
}

/// The core of a part, scaled.
struct Core<'a> {
    part: &'a Part<'a>,
    scale: f32,
}

impl SupportMap for Core<'_> {
    fn local_support_point(&self, direction: Vec3) -> Vec3 {
        self.part.core_support(direction) * self.scale
    }
}

/// Part B against part A, whose contact of the last step had the normal `last`.
pub(super) fn collide(
    a: &Part,
    b: &Part,
    relative: &Pose3,
    margin: f32,
    last: Option<Vec3>,
    buffers: &mut Buffers,
) -> Option<Manifold> {
    let pair = ConvexPair::near(a, b, relative, margin)?;
    let (gap, face) = match last.and_then(|last| pair.known(last, margin, &mut buffers.corners_a)) {
        Some(Known::Apart) => return None,
        Some(Known::Under(gap, of_a)) => (gap, Some((gap, of_a))),
        None => (pair.gap(margin, &mut buffers.epa)?, None),
    };
    let allowed = pair.allowed_normal(gap.normal)?;
    // However little the neighbours have turned it, their normal is the right one: a normal tilted by θ pushes sideways with θ of the
    // weight, and nothing holds what can roll.
    let normal = if allowed != gap.normal {
        pair.facing_features(allowed, buffers);
        let depth = gap.distance() - pair.radii;
        if buffers.candidates.is_empty() {
            pair.stand(allowed, buffers);
        }
        // Where they only just overlap, the depth found is noise.
        let deepest = MAX_DEEPENING * depth - pair.slack(gap.distance());
        buffers.candidates.retain(|c| depth >= 0.0 || c.separation >= deepest);
        allowed
    } else {
        pair.settle(&gap, face, buffers)
    };
    let candidates = &mut buffers.candidates;
    candidates.retain(|c| c.separation <= margin);

    let mut manifold = Manifold { normal, ..Manifold::default() };
    reduce_into(&mut manifold, candidates, pair.slop, |c| ManifoldPoint {
        on_a: c.on_a,
        on_b: relative.inverse_transform_point(c.on_b),
        separation: c.separation,
        feature: c.feature,
    });
    (manifold.count > 0 && manifold.is_finite()).then_some(manifold)
}

/// Direction from part A to part B, in A's frame, along which they are furthest apart or least overlap, and how far they are apart along
/// it (m), which is never more than they are; none if further than `limit`.
pub(super) fn separation(a: &Part, b: &Part, relative: &Pose3, limit: f32) -> Option<(Vec3, f32)> {
    let above = |normal: Vec3, part: &Part, pose: &Pose3| {
        let lowest = *pose * part.core_support(pose.rotation.inverse() * -normal);
        let height = normal.dot(lowest) - part.rounding();
        (height <= limit).then_some(height)
    };
    match (a, b) {
        (&Part::HalfSpace { normal }, _) => Some((normal, above(normal, b, relative)?)),
        (_, &Part::HalfSpace { normal }) => Some((relative.rotation * -normal, above(normal, a, &relative.inverse())?)),
        _ => {
            let pair = ConvexPair::near(a, b, relative, limit)?;
            let gap = pair.gap(limit, &mut EPA::new())?;
            Some((gap.normal, pair.along(gap.normal).distance() - pair.radii))
        }
    }
}

impl ConvexPair<'_> {
    /// Nearest points of the cores, or those of deepest overlap; none if the parts are further apart than `margin`.
    fn gap(&self, margin: f32, epa: &mut EPA) -> Option<ConvexGap> {
        let scale = 1.0 / self.size;
        let pose = Pose3::from_parts(self.relative.translation * scale, self.relative.rotation);
        let limit = (margin + self.radii) * scale;
        let (a, b) = (Core { part: self.a, scale }, Core { part: self.b, scale });
        let mut unsound: Option<ConvexGap> = None;
        match distance::nearest(&a, &b, &pose, limit + SLACK.1, epa) {
            Nearest::Found(gap) => {
                let gap = ConvexGap { on_a: gap.on_a * self.size, on_b: gap.on_b * self.size, ..gap };
                if self.is_sound(&gap) {
                    return self.within(gap, margin);
                }
                let is_unit = (gap.normal.length_squared() - 1.0).abs() < SLACK.0;
                unsound = Some(gap).filter(|_| is_unit);
            }
            Nearest::Beyond(direction) if self.along(direction).distance() - self.radii > margin => return None,
            Nearest::Beyond(_) => {}
        }
        self.within(self.pull_apart(unsound), margin)
    }

    /// Parts that touch, or nearly: from the best direction known, they are moved until they are clearly apart, and what is nearest there is
    /// taken back if it is a shorter way out. Where they are that far apart, it is the answer.
    fn pull_apart(&self, unsound: Option<ConvexGap>) -> ConvexGap {
        let mut best = self.best_own_direction();
        if let Some(gap) = unsound.map(|gap| self.along(gap.normal))
            && gap.distance() > best.distance()
        {
            best = gap;
        }
        let mut depth = f64::from(best.distance());
        for _ in 0..MAX_PULLS {
            let shift = best.normal.as_dvec3() * f64::from((CLEARANCE * self.size - best.distance()).max(0.0));
            let Some(points) = fine::nearest(self.a, self.b, self.relative, shift, best.normal.as_dvec3()) else { break };
            let normal = points.offset().normalize();
            let distance = normal.dot(points.offset() - shift);
            let is_found = distance - depth <= f64::from(EXACT * self.size) || shift == DVec3::ZERO;
            depth = distance;
            best = ConvexGap {
                on_a: points.on_a.as_vec3(),
                on_b: (points.on_a + normal * distance).as_vec3(),
                normal: normal.as_vec3(),
            };
            if is_found {
                break;
            }
        }
        best
    }

    fn within(&self, gap: ConvexGap, margin: f32) -> Option<ConvexGap> {
        (gap.distance() - self.radii <= margin).then_some(gap)
    }

    /// Whether the parts are as far apart along the normal as the points are, and these face each other: of an overlap, only then is no
    /// direction near the normal a shorter way out.
    pub(super) fn is_sound(&self, gap: &ConvexGap) -> bool {
        let promised = gap.distance();
        let kept = self.along(gap.normal).distance();
        let aside = (gap.on_b - gap.on_a - gap.normal * promised).length();
        (gap.normal.length_squared() - 1.0).abs() < SLACK.0
            && (kept - promised).abs() <= self.slack(promised)
            && aside <= OVERHANG * (self.size + promised.abs())
    }

    fn slack(&self, distance: f32) -> f32 {
        SLACK.0 * distance.abs() + SLACK.1 * self.size
    }

    /// The best direction that the parts themselves suggest: their faces, their axes, and from centre to centre.
    fn best_own_direction(&self) -> ConvexGap {
        let center = self.relative.translation;
        let between = center.try_normalize().unwrap_or(Vec3::Y);
        let mut best = self.along(between);
        let mut consider = |direction: Vec3| {
            let gap = self.along(direction);
            if gap.distance() > best.distance() {
                best = gap;
            }
        };
        let in_b = self.relative.rotation.inverse() * center;
        face::own_directions(self.a, center, &mut consider);
        face::own_directions(self.b, -in_b, &mut |direction| consider(self.relative.rotation * -direction));
        best
    }

    /// The normal, turned to where the neighbours of a triangle let it push; none if it does not push there at all.
    fn allowed_normal(&self, normal: Vec3) -> Option<Vec3> {
        let mut allowed = normal;
        if let Part::Triangle { constraints: Some(constraints), .. } = self.a
            && !constraints.project_local_normal_mut(&mut allowed)
        {
            return None;
        }
        if let Part::Triangle { constraints: Some(constraints), .. } = self.b {
            let before = self.relative.rotation.inverse() * -allowed;
            let mut toward_a = before;
            if !constraints.project_local_normal_mut(&mut toward_a) {
                return None;
            }
            if toward_a != before {
                allowed = self.relative.rotation * -toward_a;
            }
        }
        Some(allowed)
    }

    /// Fills the candidates, with the normal of a face if one is as good as that of `gap`, which may be known; returns the normal.
    fn settle(&self, gap: &ConvexGap, face: Option<(ConvexGap, bool)>, buffers: &mut Buffers) -> Vec3 {
        if let Some((under_face, of_a)) = face.or_else(|| self.face_as_good(gap)) {
            self.facing_features(under_face.normal, buffers);
            if self.is_found(&under_face, &buffers.candidates) {
                return under_face.normal;
            }
            // What is deepest under the face's plane must also be under the face.
            let (corners, foot) =
                if of_a { (&buffers.corners_a, under_face.on_a) } else { (&buffers.corners_b, under_face.on_b) };
            let plane = ContactPlane::across(under_face.normal);
            if under_face.distance() > 0.0 || plane.is_over(corners, foot, OVERHANG * self.size) {
                if buffers.candidates.is_empty() {
                    self.beside_border(under_face.normal, buffers);
                }
                if !self.is_found(&under_face, &buffers.candidates) {
                    buffers.candidates.push(self.candidate(under_face.on_a, under_face.on_b, under_face.normal, LONE));
                }
                return under_face.normal;
            }
        }
        self.facing_features(gap.normal, buffers);
        self.beside_border(gap.normal, buffers);
        if !self.is_found(gap, &buffers.candidates) {
            buffers.candidates.push(self.candidate(gap.on_a, gap.on_b, gap.normal, LONE));
            self.widen(gap.normal, buffers);
        }
        gap.normal
    }

    /// Adds the ends of the stretch on which two edges that cross, or lean on each other, lie beside each other to the nearest point, the last of
    /// the candidates. [`Self::facing_features`] has looked for the features.
    fn widen(&self, normal: Vec3, buffers: &mut Buffers) {
        let Buffers { corners_a, corners_b, candidates, .. } = buffers;
        let sides = Side::of(self.a, corners_a, normal).zip(Side::of(self.b, corners_b, -normal));
        let Some(((of_a, of_b), near)) = sides.zip(candidates.last().map(|nearest| nearest.on_a)) else { return };
        let ends = beside::ends(&of_a, &of_b, normal, near);
        candidates.extend((0..).zip(ends).filter_map(|(feature, end)| {
            let Across { on_a, on_b, separation } = end?;
            Some(PointCandidate { on_a, on_b, separation, feature })
        }));
    }

    fn is_found(&self, gap: &ConvexGap, candidates: &[PointCandidate]) -> bool {
        let separation = gap.distance() - self.radii;
        candidates.iter().any(|c| c.separation <= separation + SLACK.0 * separation.abs() + self.slop)
    }

    /// The gap under a face of A (true) or B (false) that separates the parts as well as `gap` does.
    fn face_as_good(&self, gap: &ConvexGap) -> Option<(ConvexGap, bool)> {
        let enough = gap.distance() - self.slack(gap.distance());
        let offset = gap.on_b - gap.on_a;
        let skew = SKEW * self.size;
        let under = |normal: Vec3, of_a: bool| {
            let extreme = self.along(normal);
            let depth = extreme.distance();
            if depth < enough {
                return None;
            }
            if gap.distance() > 0.0 {
                let facing = offset.reject_from_normalized(normal).length_squared() <= skew * skew;
                return facing.then_some((ConvexGap { normal, ..*gap }, of_a));
            }
            let foot = if of_a {
                ConvexGap { on_a: extreme.on_b - normal * depth, ..extreme }
            } else {
                ConvexGap { on_b: extreme.on_a + normal * depth, ..extreme }
            };
            Some((foot, of_a))
        };
        let rotation = self.relative.rotation;
        let of_a = face::nearest(self.a, gap.normal);
        let of_b = || face::nearest(self.b, rotation.inverse() * -gap.normal).map(|normal| rotation * -normal);
        of_a.and_then(|normal| under(normal, true)).or_else(|| under(of_b()?, false))
    }

    /// Fills the candidates with the corners of the common part of the two features that face each other along `normal`.
    fn facing_features(&self, normal: Vec3, buffers: &mut Buffers) {
        let Buffers { corners_a, corners_b, candidates, polygon, clipped, .. } = buffers;
        candidates.clear();
        let feature_a = face::find(self.a, normal, corners_a);
        let feature_b = face::find(self.b, self.relative.rotation.inverse() * -normal, corners_b);
        for (corner, _) in corners_b.iter_mut() {
            *corner = *self.relative * *corner;
        }
        let face_b = |n: Vec3| self.relative.rotation * n;
        let plane = ContactPlane::across(normal);
        match (feature_a, feature_b) {
            (Feature::Face { normal: normal_a }, Feature::Face { normal: normal_b }) => {
                let (Some(ground), Some(_)) =
                    (plane.slope(normal_a, corners_a[0].0), plane.slope(face_b(normal_b), corners_b[0].0))
                else {
                    return;
                };
                polygon.clear();
                polygon.extend(corners_b.iter().map(|corner| plane.vertex(corner)));
                for side in plane.sides(corners_a, self.slop) {
                    clipped.clear();
                    clip::clip(polygon, &side, |vertex| clipped.push(vertex));
                    std::mem::swap(polygon, clipped);
                }
                let mut arriving = polygon.last().map_or(0, |vertex| vertex.edge);
                for vertex in polygon.iter() {
                    if !vertex.spare {
                        let feature = u32::from(arriving) << 16 | u32::from(vertex.edge);
                        let low = plane.point(vertex.at, ground.height(vertex.at));
                        let high = plane.point(vertex.at, vertex.height);
                        candidates.push(self.candidate(low, high, normal, feature));
                    }
                    arriving = vertex.edge;
                }
            }
            (Feature::Face { normal: normal_a }, Feature::Edge) => {
                let Some(ground) = plane.slope(normal_a, corners_a[0].0) else { return };
                let segment = Segment::between(corners_b[0].0, corners_b[1].0);
                for (feature, end) in (0..).zip(plane.lie(&segment, corners_b, corners_a, self.slop).into_iter().flatten()) {
                    let depth = depth_of(&segment, end, -normal, self.b.rounding());
                    let low = plane.point(plane.flat(end), ground.height(plane.flat(end)));
                    candidates.push(self.at_depths((low, self.a.rounding()), (end, depth), normal, feature));
                }
            }
            (Feature::Edge, Feature::Face { normal: normal_b }) => {
                let Some(ceiling) = plane.slope(face_b(normal_b), corners_b[0].0) else { return };
                let segment = Segment::between(corners_a[0].0, corners_a[1].0);
                for (feature, end) in (0..).zip(plane.lie(&segment, corners_a, corners_b, self.slop).into_iter().flatten()) {
                    let depth = depth_of(&segment, end, normal, self.a.rounding());
                    let high = plane.point(plane.flat(end), ceiling.height(plane.flat(end)));
                    candidates.push(self.at_depths((end, depth), (high, self.b.rounding()), normal, feature));
                }
            }
            (Feature::Edge, Feature::Edge) => {
                let girth = self.a.girth().min(self.b.girth());
                let of_a = Segment::between(corners_a[0].0, corners_a[1].0);
                let of_b = Segment::between(corners_b[0].0, corners_b[1].0);
                let ends = of_a.side_by_side(&of_b, normal, girth).into_iter().flatten();
                candidates.extend((0..).zip(ends).map(|(feature, (a, b))| self.candidate(a, b, normal, feature)));
            }
            (Feature::Point, _) | (_, Feature::Point) => {}
        }
    }

    /// Puts the ends of the line along which an edge lies beside one of the border of a face in place of the candidates, if it does: along a normal
    /// that is not that of the face this is what touches, and clipped to the face an edge that has left it by a rounding has no end there, or
    /// one. [`Self::facing_features`] has looked for the features.
    fn beside_border(&self, normal: Vec3, buffers: &mut Buffers) {
        let Buffers { corners_a, corners_b, candidates, .. } = buffers;
        let of_a = corners_a.len() > 2;
        let (face, edge) = if of_a { (corners_a, corners_b) } else { (corners_b, corners_a) };
        let &[(from, _), (to, _)] = &edge[..] else { return };
        let (lying, girth) = (Segment::between(from, to), self.a.girth().min(self.b.girth()));
        let aside = |[low, high]: &[(Vec3, Vec3); 2]| {
            [low, high]
                .map(|(border, end)| (*end - *border).reject_from_normalized(normal).length_squared())
                .into_iter()
                .sum::<f32>()
        };
        let borders = face.iter().zip(face.iter().cycle().skip(1)).map(|(from, to)| Segment::between(from.0, to.0));
        let lines = borders.filter(|_| face.len() > 2).filter_map(|border| border.side_by_side(&lying, normal, girth));
        if let Some(line) = lines.min_by(|one, other| aside(one).total_cmp(&aside(other))) {
            candidates.clear();
            candidates.extend((0..).zip(line).map(|(feature, (border, end))| {
                let (on_a, on_b) = if of_a { (border, end) } else { (end, border) };
                self.candidate(on_a, on_b, normal, feature)
            }));
        }
    }

    /// Adds the end of an edge that stands on a triangle rather than lies on it, where it is over the triangle: of a capsule or a cone.
    /// [`Self::facing_features`] has looked for the features.
    fn stand(&self, normal: Vec3, buffers: &mut Buffers) {
        let Buffers { corners_a, corners_b, candidates, .. } = buffers;
        let stands_on_a = matches!(self.a, Part::Triangle { .. });
        let (face, edge) = if stands_on_a { (corners_a, corners_b) } else { (corners_b, corners_a) };
        let (&[first, second, third], &[_, _]) = (&face[..], &edge[..]) else { return };
        let plane = ContactPlane::across(normal);
        let extreme = self.along(normal);
        let end = if stands_on_a { extreme.on_b } else { extreme.on_a };
        let across = (second.0 - first.0).cross(third.0 - first.0).normalize_or_zero();
        let Some(slope) = plane.slope(across, first.0).filter(|_| plane.is_over(face, end, self.slop)) else { return };
        let foot = plane.point(plane.flat(end), slope.height(plane.flat(end)));
        let (on_a, on_b) = if stands_on_a { (foot, end) } else { (end, foot) };
        candidates.push(self.candidate(on_a, on_b, normal, LONE));
    }

    /// From points of the cores to points of the surfaces.
    fn candidate(&self, core_a: Vec3, core_b: Vec3, normal: Vec3, feature: u32) -> PointCandidate {
        self.at_depths((core_a, self.a.rounding()), (core_b, self.b.rounding()), normal, feature)
    }

    /// From points of the cores to points of the surfaces at the given depths (m) before them.
    fn at_depths(&self, a: (Vec3, f32), b: (Vec3, f32), normal: Vec3, feature: u32) -> PointCandidate {
        let separation = normal.dot(b.0 - a.0) - a.1 - b.1;
        PointCandidate { on_a: a.0 + normal * a.1, on_b: b.0 - normal * b.1, separation, feature }
    }
}

fn depth_of(segment: &Segment, at: Vec3, toward: Vec3, rounding: f32) -> f32 {
    if rounding == 0.0 {
        return 0.0;
    }
    let s = (at - segment.center).dot(segment.half) / segment.half.length_squared();
    segment.depth_of(s.clamp(-1.0, 1.0), toward, rounding)
}
