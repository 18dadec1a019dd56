//! Stage that removes contacts at the seams between flush surfaces.
//!
//! What slides or rolls from one surface onto another that lies flush beside it meets the edge of the second, which is no obstacle: were
//! both one surface, there would be none. Narrow phases see two shapes at a time and cannot know. Where a body moves over at least two pairs
//! with what does not move, or over a compound, a point e on K is left out if a face of another shape or part J carries the body there as well:
//!
//! * J presses with a face, or keeps the body above the plane of one, and e lies in that plane, or as much under it as the body is sunk in there,
//!   or K ends there at that plane: nothing above a plane comes to a point of it before it comes to the plane;
//! * e lies on J, on its rim, or on a third shape that is flush with J there;
//! * e does not press as that face does: it is an edge, or a side;
//! * K does not rise above that plane behind e, as a wall or a step would, and nothing else is there: what lies against a side of J makes it none.
//!
//! Points along the normal of one edge are left out together: some of them may lie over the face behind it.

use glam::{DVec3, Vec3};

use super::body_shape_table::BodyShapeTable;
use super::{Collision, World};
use crate::collide::collider::Collider;
use crate::collide::collider_state::ColliderState;
use crate::collide::narrow;
use crate::collide::pairs::{Pair, PairKey};
use crate::collide::predict::FLUSH;
use crate::id::{Pool, ShapeId};

/// How far behind a point, in distances of which surfaces are flush, K is looked for above J's plane.
const BEHIND: f32 = 10.0;

/// Cosine between two normals from which on they press alike: points of a face of K support what lies on it.
const ALIKE: f32 = 0.9;

/// Sine of the angle from J's normal below which a point does not hold up what slides.
const UPRIGHT: f32 = 1.0e-4;

/// How far to the side of where it is a point may be found, over its separation: faces stand for directions whose distance they give to a
/// share of 0.002, and may be turned from them by √(2·0.002).
const UNSURE: f32 = 0.07;

/// A pair of which one body moves over the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Glide {
    /// The body that moves.
    body: u32,
    key: PairKey,
    slot: u32,
    /// Whether that is the second.
    is_second: bool,
}

impl Glide {
    /// What there is to note of a pair that has been brought up to date: whether a round shape of it moves over the other.
    pub(super) fn of(key: PairKey, slot: u32, pair: &Pair, (a, b): (&ColliderState, &ColliderState), dt: f32) -> Option<Self> {
        if !pair.may_touch || a.body == b.body {
            return None;
        }
        let is_second = a.is_ground_of(b);
        let (still, mover) = if is_second { (a, b) } else { (b, a) };
        // Blocks of a heap lie on each other's faces, and one by one they are no floor.
        if !(mover.is_round || still.is_unmoved()) {
            return None;
        }
        mover.glides_over(still, dt).then_some(Self { body: mover.body, key, slot, is_second })
    }

    /// Shape that does not move.
    fn still(&self) -> u32 {
        let (a, b) = self.key.shapes();
        if self.is_second { a } else { b }
    }
}

/// A point at which a body moves over a shape.
#[derive(Debug, Clone, Copy)]
struct GlidePoint {
    slot: u32,
    number: usize,
    point: usize,
    /// Shape that does not move, and its part.
    shape: u32,
    part: u32,
    /// On that shape (m), and from there to the body.
    at: DVec3,
    normal: Vec3,
    separation: f32,
    flush: f32,
}

/// Buffers of the stage.
#[derive(Debug, Default)]
pub(super) struct Seams {
    glides: Vec<Glide>,
    points: Vec<GlidePoint>,
    corners: narrow::Corners,
}

impl World {
    /// Leaves out contacts with the edges of flush neighbours of what a body moves over.
    pub(super) fn leave_out_seams(&mut self) {
        let Self { collision: Collision { pairs, index, .. }, colliders, scratch, .. } = self;
        let Seams { glides, points, corners } = &mut scratch.seams;
        glides.clear();
        scratch.glides.iter_mut().for_each(|found| glides.append(found));
        glides.sort_unstable();
        for glides in glides.chunk_by(|a, b| a.body == b.body) {
            let is_at_seam = glides.len() > 1 || colliders[glides[0].still()].shape.is_compound();
            if !is_at_seam {
                continue;
            }
            let ground = StaticSurface { colliders, index };
            points.clear();
            for glide in glides {
                ground.list_points(glide, pairs.get(glide.slot), corners, points);
            }
            for manifold in points.chunk_by(|a, b| (a.slot, a.number) == (b.slot, b.number)) {
                let is_carried = |e: &GlidePoint| points.iter().any(|f| ground.carries(f, e, points));
                let is_edge = !ground.is_face(&manifold[0]);
                let goes = is_edge && manifold.iter().any(is_carried);
                for e in manifold.iter().filter(|e| goes || is_carried(e)) {
                    let extent = index.least_extent(pairs.get(e.slot).key);
                    pairs.get_mut(e.slot).leave_out(e.number, e.point, extent);
                }
            }
        }
    }
}

/// What does not move.
struct StaticSurface<'a> {
    colliders: &'a Pool<Collider, ShapeId>,
    index: &'a BodyShapeTable,
}

impl StaticSurface<'_> {
    /// Appends the points of a pair.
    fn list_points(&self, glide: &Glide, pair: &Pair, corners: &mut narrow::Corners, points: &mut Vec<GlidePoint>) {
        let Self { colliders, index } = self;
        let (a, b) = glide.key.shapes();
        let shape = glide.still();
        let (collider_state, sign) = (index.collider_state(shape), if glide.is_second { 1.0 } else { -1.0 });
        let turn_a = index.collider_state(a).rotation;
        let flush = FLUSH * index.least_extent(glide.key);
        for (number, manifold) in pair.manifolds.iter().enumerate() {
            let part = narrow::parts_of(&colliders[b].shape, manifold.part)[usize::from(!glide.is_second)];
            let of = |normal: Vec3, point: usize, at: Vec3, separation: f32| GlidePoint {
                slot: glide.slot,
                number,
                point,
                shape,
                part,
                at: collider_state.position + (collider_state.rotation * at).as_dvec3(),
                normal: turn_a * normal * sign,
                separation,
                flush,
            };
            let on_still = |on_a: Vec3, on_b: Vec3| if glide.is_second { on_a } else { on_b };
            let places = manifold.points.iter().enumerate();
            points.extend(places.map(|(i, place)| of(manifold.normal, i, on_still(place.on_a, place.on_b), place.separation)));
            let first = points.len() - manifold.points.len();
            if self.is_face(&points[first]) {
                continue;
            }
            let [shape_a, shape_b] = [a, b].map(|shape| &colliders[shape]);
            let relative = shape_a.relative(shape_b);
            let edge = narrow::nearest_edge(&shape_a.shape, &shape_b.shape, manifold.part, &relative, manifold.normal, corners);
            if let Some(edge) = edge {
                points[first] = of(edge.normal, 0, on_still(edge.on_a, edge.on_b), points[first].separation);
            }
        }
    }

    /// Whether the surface at `f` carries what moves so that it does not meet `e`; `points` are all of what moves.
    fn carries(&self, f: &GlidePoint, e: &GlidePoint, points: &[GlidePoint]) -> bool {
        let is_same = f.shape == e.shape && (f.part == e.part || !self.colliders[e.shape].shape.is_compound());
        let alignment = e.normal.dot(f.normal);
        if is_same {
            return false;
        }
        let into = f.normal * alignment - e.normal;
        if into.length_squared() < UPRIGHT * UPRIGHT || !self.is_face(f) || (alignment >= ALIKE && self.is_face(e)) {
            return false;
        }
        let further = into.normalize() * (BEHIND * e.flush);
        let height = f.normal.dot((e.at - f.at).as_vec3());
        let at = e.at - (f.normal * height).as_dvec3();
        // What lies a little deep in one surface meets the side of the next by as much, and what is far off is not seen exactly.
        let depth = (-f.separation).max(0.0) + UNSURE * e.separation.max(0.0);
        // What fell has points of the pose that it would have had below the plane: of a side that ends at the plane, they are no more.
        let is_at_plane = height <= e.flush && height >= -(e.flush + depth);
        if !is_at_plane {
            let is_met = height > 0.0 && self.distance(e.shape, e.at + further.as_dvec3()) < e.flush;
            if is_met || self.distance(e.shape, at) > e.flush {
                return false;
            }
        }
        let behind = at + (f.normal * (2.0 * e.flush) + further).as_dvec3();
        let above = (f.normal * (2.0 * e.flush)).as_dvec3();
        // Also where a third one lies there, flush with J: what comes over a corner meets the tile across it before those beside it press.
        let lies_there = |shape: u32| self.distance(shape, at) <= e.flush && self.distance(shape, at + above) >= e.flush;
        let is_covered = self.distance(f.shape, at) <= e.flush
            || points.iter().any(|other| other.shape != f.shape && other.shape != e.shape && lies_there(other.shape));
        // What lies against a side of J does so to both hands of e; what rises beside the way does to one.
        let rises = |shape: u32, place: DVec3| self.distance(shape, place) < e.flush;
        let aside = (f.normal.cross(further).normalize() * (2.0 * e.flush)).as_dvec3();
        let is_filled = |place: DVec3| {
            points.iter().any(|other| other.shape != f.shape && other.shape != e.shape && rises(other.shape, place))
        };
        is_covered && !rises(e.shape, behind) && !(is_filled(behind + aside) && is_filled(behind - aside))
    }

    fn is_face(&self, point: &GlidePoint) -> bool {
        let normal = self.index.collider_state(point.shape).rotation.conjugate() * point.normal;
        narrow::is_face_normal(&self.colliders[point.shape].shape, point.part, normal)
    }

    /// From a shape to a place (m); zero inside.
    fn distance(&self, shape: u32, at: DVec3) -> f32 {
        let collider_state = self.index.collider_state(shape);
        narrow::distance_to(
            &self.colliders[shape].shape,
            collider_state.rotation.conjugate() * (at - collider_state.position).as_vec3(),
        )
    }
}
