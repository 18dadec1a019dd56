//! Any two convex parts: a direction from GJK and EPA, then clipping of the features that face each other along it.
//!
//! parry3d's GJK gives the direction between parts apart, its EPA the way out of an overlap. Near touching, both are noise
//! in `f32`; what keeps a resting contact still is that a face as good as the direction found takes its place. A direction
//! that does not keep what it promises, or none at all, is replaced by the best of the parts' own directions, so that
//! no overlap is ever lost.
//!
//! Both work on the parts scaled to 1, for their tolerances are absolute.

use glam::{Vec2, Vec3};
use parry3d::math::Pose3;
use parry3d::query::details::NormalConstraints;
use parry3d::shape::SupportMap;

use super::capsule::Segment;
use super::clip::{Side, Vertex, clip, clip_segment, plane_axes};
use super::distance::{self, Gap, Nearest};
use super::face::{self, Corner, Feature};
use super::part::Part;
use super::reduce::{Candidate, reduce_into};
use super::{Manifold, ManifoldPoint};

/// How much less than the distance found a face may give and still be the normal; a direction that gives less than the
/// distance by this much is noise. Fractions of the distance and of the smaller part.
const SLACK: (f32, f32) = (2.0e-3, 1.0e-4);

/// How far outside a face a vertex counts as over it, as a fraction of the smaller part.
const CLIP_SLOP: f32 = 1.0e-4;

/// A face seen at a smaller cosine than this is not clipped: heights on it would be extrapolated.
const MIN_FACING: f32 = 0.2;

/// Where a triangle's neighbours have turned the normal, points deeper than this many times the original depth are thought
/// to belong to another triangle.
const MAX_DEEPENING: f32 = 5.0;

/// Feature of the nearest points, where they are no vertex of a clipped polygon.
pub(super) const LONE: u32 = u32::MAX;

/// Bit of an edge id: a side of the clipping polygon.
const CLIPPING: u16 = 1 << 15;

/// Reused from call to call.
#[derive(Default)]
pub(super) struct Buffers {
    pub corners_a: Vec<Corner>,
    pub corners_b: Vec<Corner>,
    pub candidates: Vec<Candidate>,
    polygon: Vec<Vertex>,
    clipped: Vec<Vertex>,
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

/// Part B against part A.
pub(super) fn collide(a: &Part, b: &Part, relative: &Pose3, margin: f32, buffers: &mut Buffers) -> Option<Manifold> {
    let (reach_a, reach_b) = (a.reach(), b.reach());
    // Written so that a NaN is no contact.
    let near = relative.translation.length() <= reach_a + reach_b + margin;
    if !near || !relative.rotation.is_finite() {
        return None;
    }
    let size = reach_a.min(reach_b);
    let pair = Pair {
        a,
        b,
        relative,
        radii: a.rounding() + b.rounding(),
        size,
        slop: CLIP_SLOP * size + 4.0 * f32::EPSILON * reach_a.max(reach_b),
    };
    let mut gap = pair.gap(margin)?;
    let found = gap.normal;
    let distance = gap.distance();
    if let Part::Triangle { constraints: Some(constraints), .. } = a
        && !constraints.project_local_normal_mut(&mut gap.normal)
    {
        return None;
    }
    if let Part::Triangle { constraints: Some(constraints), .. } = b {
        let mut toward_a = relative.rotation.inverse() * -gap.normal;
        let before = toward_a;
        if !constraints.project_local_normal_mut(&mut toward_a) {
            return None;
        }
        if toward_a != before {
            gap.normal = relative.rotation * -toward_a;
        }
    }
    let turned = gap.normal.dot(found) < 1.0 - SLACK.1;
    if !turned {
        gap.normal = pair.face_as_good(&gap).unwrap_or(gap.normal);
    }

    pair.facing_features(gap.normal, buffers);
    let candidates = &mut buffers.candidates;
    if turned {
        candidates.retain(|c| distance >= pair.radii || c.separation >= MAX_DEEPENING * (distance - pair.radii));
    } else {
        let separation = gap.distance() - pair.radii;
        let found = candidates.iter().any(|c| c.separation <= separation + SLACK.0 * separation.abs() + pair.slop);
        if !found {
            candidates.push(pair.candidate(gap.on_a, gap.on_b, gap.normal, LONE));
        }
    }
    candidates.retain(|c| c.separation <= margin);

    let mut manifold = Manifold { normal: gap.normal, ..Manifold::default() };
    reduce_into(&mut manifold, candidates, pair.slop, |c| ManifoldPoint {
        on_a: c.on_a,
        on_b: relative.inverse_transform_point(c.on_b),
        separation: c.separation,
        feature: c.feature,
    });
    (manifold.count > 0 && manifold.is_finite()).then_some(manifold)
}

impl Gap {
    fn distance(&self) -> f32 {
        self.normal.dot(self.on_b - self.on_a)
    }
}

struct Pair<'a> {
    a: &'a Part<'a>,
    b: &'a Part<'a>,
    relative: &'a Pose3,
    /// Rounding of both (m).
    radii: f32,
    /// Reach of the smaller (m).
    size: f32,
    slop: f32,
}

impl Pair<'_> {
    /// Nearest points of the cores, or those of deepest overlap; none if the parts are further apart than `margin`.
    fn gap(&self, margin: f32) -> Option<Gap> {
        let scale = 1.0 / self.size;
        let pose = Pose3::from_parts(self.relative.translation * scale, self.relative.rotation);
        let limit = (margin + self.radii) * scale;
        let (a, b) = (Core { part: self.a, scale }, Core { part: self.b, scale });
        let gap = match distance::nearest(&a, &b, &pose, limit + SLACK.1) {
            Nearest::Found(gap) => Gap { on_a: gap.on_a * self.size, on_b: gap.on_b * self.size, ..gap },
            Nearest::Beyond(direction) if self.along(direction).distance() - self.radii > margin => return None,
            Nearest::Beyond(_) => self.best_own_direction(),
        };
        let promised = gap.distance();
        let kept = self.along(gap.normal).distance();
        let is_unit = (gap.normal.length_squared() - 1.0).abs() < SLACK.0;
        let sound = is_unit && (kept - promised).abs() <= self.slack(promised);
        let gap = if sound { gap } else { self.best_own_direction() };
        (gap.distance() - self.radii <= margin).then_some(gap)
    }

    fn slack(&self, distance: f32) -> f32 {
        SLACK.0 * distance.abs() + SLACK.1 * self.size
    }

    /// The gap that a unit `normal` proves: between the parts' extreme points along it.
    fn along(&self, normal: Vec3) -> Gap {
        let on_b = *self.relative * self.b.core_support(self.relative.rotation.inverse() * -normal);
        Gap { on_a: self.a.core_support(normal), on_b, normal }
    }

    /// The best direction that the parts themselves suggest: their faces, their axes, and from centre to centre.
    fn best_own_direction(&self) -> Gap {
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
        own_directions(self.a, center, &mut consider);
        own_directions(self.b, -in_b, &mut |direction| consider(self.relative.rotation * -direction));
        best
    }

    /// The normal of a face of A or B that separates the parts as well as `gap` does.
    fn face_as_good(&self, gap: &Gap) -> Option<Vec3> {
        let enough = gap.distance() - self.slack(gap.distance());
        let rotation = self.relative.rotation;
        let of_a = nearest_face(self.a, gap.normal);
        let of_b = nearest_face(self.b, rotation.inverse() * -gap.normal).map(|normal| rotation * -normal);
        of_a.into_iter().chain(of_b).find(|&normal| self.along(normal).distance() >= enough)
    }

    /// Fills the candidates with the corners of the common part of the two features that face each other along `normal`.
    fn facing_features(&self, normal: Vec3, buffers: &mut Buffers) {
        let Buffers { corners_a, corners_b, candidates, polygon, clipped } = buffers;
        candidates.clear();
        let feature_a = face::find(self.a, normal, corners_a);
        let feature_b = face::find(self.b, self.relative.rotation.inverse() * -normal, corners_b);
        for (corner, _) in corners_b.iter_mut() {
            *corner = *self.relative * *corner;
        }
        let face_b = |n: Vec3| self.relative.rotation * n;
        let plane = Plane::across(normal);
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
                    clip(polygon, &side, |vertex| clipped.push(vertex));
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
                let Some(ends) = plane.cut(corners_b, corners_a, self.slop) else { return };
                candidates.extend((0..).zip(ends).map(|(feature, end)| {
                    let (low, high) = (ground.height(end.at), end.height);
                    self.candidate(plane.point(end.at, low), plane.point(end.at, high), normal, feature)
                }));
            }
            (Feature::Edge, Feature::Face { normal: normal_b }) => {
                let Some(ceiling) = plane.slope(face_b(normal_b), corners_b[0].0) else { return };
                let Some(ends) = plane.cut(corners_a, corners_b, self.slop) else { return };
                candidates.extend((0..).zip(ends).map(|(feature, end)| {
                    let (low, high) = (end.height, ceiling.height(end.at));
                    self.candidate(plane.point(end.at, low), plane.point(end.at, high), normal, feature)
                }));
            }
            (Feature::Edge, Feature::Edge) => {
                let segment = |corners: &[Corner]| Segment {
                    center: 0.5 * (corners[0].0 + corners[1].0),
                    half: 0.5 * (corners[1].0 - corners[0].0),
                };
                let girth = self.a.girth().min(self.b.girth());
                let ends = segment(corners_a).side_by_side(&segment(corners_b), normal, girth);
                let ends = ends.into_iter().flatten();
                candidates.extend((0..).zip(ends).map(|(feature, (a, b))| self.candidate(a, b, normal, feature)));
            }
            (Feature::Point, _) | (_, Feature::Point) => {}
        }
    }

    /// From points of the cores to points of the surfaces.
    fn candidate(&self, core_a: Vec3, core_b: Vec3, normal: Vec3, feature: u32) -> Candidate {
        Candidate {
            on_a: core_a + normal * self.a.rounding(),
            on_b: core_b - normal * self.b.rounding(),
            separation: normal.dot(core_b - core_a) - self.radii,
            feature,
        }
    }
}

fn nearest_face(part: &Part, direction: Vec3) -> Option<Vec3> {
    match part {
        Part::Box { half_extents: _ } => {
            let facing = direction.abs();
            let axis = (1..3).fold(0, |best, i| if facing[i] > facing[best] { i } else { best });
            let mut normal = Vec3::ZERO;
            normal[axis] = 1.0_f32.copysign(direction[axis]);
            Some(normal)
        }
        Part::Cylinder { .. } => Some(Vec3::new(0.0, 1.0_f32.copysign(direction.y), 0.0)),
        Part::Cone { .. } => Some(Vec3::NEG_Y),
        Part::Hull(hull) => {
            let facing = |n: &Vec3| n.dot(direction);
            hull.faces().iter().map(|face| face.normal).reduce(|best, n| if facing(&n) > facing(&best) { n } else { best })
        }
        Part::Triangle { triangle, .. } => triangle.normal().map(|n| n * 1.0_f32.copysign(n.dot(direction))),
        Part::Ball { .. } | Part::Capsule { .. } | Part::HalfSpace { .. } => None,
    }
}

/// Outward directions in which `part` might touch something centred at `other`, in the part's frame.
fn own_directions(part: &Part, other: Vec3, consider: &mut impl FnMut(Vec3)) {
    let aside = Vec3::new(other.x, 0.0, other.z).try_normalize().unwrap_or(Vec3::X);
    match part {
        Part::Ball { .. } | Part::HalfSpace { .. } => {}
        Part::Box { .. } => [Vec3::X, Vec3::Y, Vec3::Z].into_iter().for_each(|n| {
            consider(n);
            consider(-n);
        }),
        Part::Capsule { .. } => consider(aside),
        Part::Cylinder { .. } => [Vec3::Y, Vec3::NEG_Y, aside].into_iter().for_each(consider),
        Part::Cone { half_height, radius } => {
            consider(Vec3::NEG_Y);
            consider((aside * 2.0 * *half_height + Vec3::Y * *radius).normalize());
        }
        Part::Hull(hull) => hull.faces().iter().for_each(|face| consider(face.normal)),
        Part::Triangle { triangle, .. } => {
            let Some(normal) = triangle.normal() else { return };
            consider(normal);
            consider(-normal);
            for edge in triangle.edges_scaled_directions() {
                if let Some(outward) = edge.cross(normal).try_normalize() {
                    consider(outward);
                }
            }
        }
    }
}

/// The plane of contact and its axes.
struct Plane {
    u: Vec3,
    v: Vec3,
    normal: Vec3,
}

/// Height of a face over the plane of contact.
struct Slope {
    gradient: Vec2,
    height: f32,
}

impl Slope {
    fn height(&self, at: Vec2) -> f32 {
        self.height + self.gradient.dot(at)
    }
}

impl Plane {
    fn across(normal: Vec3) -> Self {
        let (u, v) = plane_axes(normal);
        Self { u, v, normal }
    }

    fn flat(&self, point: Vec3) -> Vec2 {
        Vec2::new(self.u.dot(point), self.v.dot(point))
    }

    fn point(&self, at: Vec2, height: f32) -> Vec3 {
        self.u * at.x + self.v * at.y + self.normal * height
    }

    fn vertex(&self, &(corner, id): &Corner) -> Vertex {
        Vertex { at: self.flat(corner), height: self.normal.dot(corner), edge: id, spare: false }
    }

    /// The face through `point`; none if it is seen too much from the side.
    fn slope(&self, face: Vec3, point: Vec3) -> Option<Slope> {
        let facing = face.dot(self.normal);
        (facing.abs() >= MIN_FACING).then(|| Slope { gradient: self.flat(face) / -facing, height: face.dot(point) / facing })
    }

    /// The sides of a convex polygon.
    fn sides<'a>(&'a self, corners: &'a [Corner], slop: f32) -> impl Iterator<Item = Side> + 'a {
        let at = move |i: usize| self.flat(corners[i % corners.len()].0);
        let area: f32 = (1..corners.len() - 1).map(|i| (at(i) - at(0)).perp_dot(at(i + 1) - at(0))).sum();
        let sense = 1.0_f32.copysign(area);
        (0..corners.len()).filter_map(move |i| {
            let along = (at(i + 1) - at(i)).try_normalize()?;
            let normal = -along.perp() * sense;
            Some(Side { normal, offset: normal.dot(at(i)), slop, edge: CLIPPING | corners[i].1 })
        })
    }

    /// The part of an edge over a face.
    fn cut(&self, edge: &[Corner], face: &[Corner], slop: f32) -> Option<[Vertex; 2]> {
        let ends = [self.vertex(&edge[0]), self.vertex(&edge[1])];
        self.sides(face, slop).try_fold(ends, |ends, side| clip_segment(ends, &side))
    }
}
