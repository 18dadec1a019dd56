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
//!
//! A round shape does not tip over an end of J ahead of it within a step, as a flat one might: what is no higher than J's plane need not lie on J.
//! Where the face of K behind e rises from that plane, by less than a step, the contact is put on that face: the shape comes to it before the step ends.
//!
//! Where pieces move, e must be so at the step's end, too, as J and K move there. Round shapes roll over what is flat and held by joints.

use std::cell::Cell;
use std::f32::consts::FRAC_1_SQRT_2;

use glam::{DVec3, Vec3};

use super::body_shape_table::BodyShapeTable;
use super::{Collision, World};
use crate::body::Body;
use crate::collide::collider::Collider;
use crate::collide::collider_state::ColliderState;
use crate::collide::narrow;
use crate::collide::pairs::{Pair, PairKey};
use crate::collide::predict::FLUSH;
use crate::id::{BodyId, Pool, ShapeId};
use crate::shape::Geometry;

/// How far behind a point, in distances of which surfaces are flush, K is looked for above J's plane.
const BEHIND: f32 = 10.0;

/// Shares of that at which a surface is looked for as well, at twice that distance above the plane: seen from one of them or from `BEHIND`, every slope
/// from 6 degrees to upright passes within the distance of which surfaces are flush.
const NEARER: [f32; 4] = [0.0, 0.1, 0.25, 0.5];

/// Cosine between two normals from which on they press alike: points of a face of K support what lies on it.
const ALIKE: f32 = 0.9;

/// Sine of the angle from J's normal below which a point does not hold up what slides.
const UPRIGHT: f32 = 1.0e-4;

/// How far to the side of where it is a point may be found, over its separation: faces stand for directions whose distance they give to a
/// share of 0.002, and may be turned from them by √(2·0.002).
const UNSURE: f32 = 0.07;

/// Most faces that are asked, for all points of a body together, whether they carry it over them: some 5 ms, and twice what a pin of seven parts
/// asks of the floor as it flies past ten others. Points beyond those stay.
const MAX_TRIALS: u32 = 131_072;

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
    pub(super) fn of(
        key: PairKey,
        slot: u32,
        pair: &Pair,
        (a, b): (&ColliderState, &ColliderState),
        dt: f32,
        bodies: &Pool<Body, BodyId>,
    ) -> Option<Self> {
        if !pair.may_touch || a.body == b.body {
            return None;
        }
        let is_second = a.is_ground_of(b);
        let (still, mover) = if is_second { (a, b) } else { (b, a) };
        // Blocks of a heap lie on each other's faces, and one by one they are no floor.
        if !(mover.is_round || still.is_unmoved()) {
            return None;
        }
        let is_held = |body: u32| !bodies[body].joints.is_empty();
        mover.glides_over(still, dt, is_held).then_some(Self { body: mover.body, key, slot, is_second })
    }

    /// Shape that is moved over.
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
    /// Shape that moves over another.
    mover: u32,
    /// That other, and its part.
    shape: u32,
    part: u32,
    /// On that shape (m), and from there to the body.
    at: DVec3,
    normal: Vec3,
    separation: f32,
    flush: f32,
    /// Whether it lies on a face of that shape.
    is_face: bool,
    /// Place in the list of the first point of its manifold.
    first: usize,
}

/// Buffers of the stage.
#[derive(Debug, Default)]
pub(super) struct Seams {
    glides: Vec<Glide>,
    points: Vec<GlidePoint>,
    /// Those of them that lie on faces, and shapes that any are on.
    faces: Vec<u32>,
    shapes: Vec<u32>,
    corners: narrow::Corners,
}

impl World {
    /// Leaves out contacts with the edges of flush neighbours of what a body moves over.
    pub(super) fn leave_out_seams(&mut self, dt: f32) {
        let Self { collision: Collision { pairs, index, .. }, colliders, bodies, scratch, .. } = self;
        let Seams { glides, points, faces, shapes, corners } = &mut scratch.seams;
        glides.clear();
        scratch.glides.iter_mut().for_each(|found| glides.append(found));
        glides.sort_unstable();
        for glides in glides.chunk_by(|a, b| a.body == b.body) {
            let is_at_seam = glides.len() > 1 || colliders[glides[0].still()].shape.is_compound();
            if !is_at_seam {
                continue;
            }
            let ground = Ground { colliders, bodies, index, dt };
            points.clear();
            for glide in glides {
                ground.list_points(glide, pairs.get(glide.slot), corners, points);
            }
            shapes.clear();
            shapes.extend(points.iter().map(|point| point.shape));
            shapes.sort_unstable();
            shapes.dedup();
            faces.clear();
            faces.extend((0_u32..).zip(&*points).filter(|(_, point)| point.is_face).map(|(place, _)| place));
            let ways = Ways { points, faces, shapes, trials_left: Cell::new(MAX_TRIALS) };
            for manifold in points.chunk_by(|a, b| (a.slot, a.number) == (b.slot, b.number)) {
                let carrier_of = |e: &GlidePoint| ways.faces().find(|f| ground.carries(f, e, &ways));
                let first = &manifold[0];
                // Of what may move most lies on faces, in heaps, and its sides stand in nobody's way: only edges do.
                if first.is_face && !index.collider_state(first.shape).is_unmoved() {
                    continue;
                }
                let extent = index.least_extent(pairs.get(first.slot).key);
                let carrier = if first.is_face { None } else { manifold.iter().find_map(carrier_of) };
                let rising = carrier.and_then(|f| ground.rising_face(f, first));
                if rising.is_some_and(|normal| ground.put_on_face(normal, first, pairs.get_mut(first.slot), extent)) {
                    continue;
                }
                for e in manifold.iter().filter(|e| carrier.is_some() || carrier_of(e).is_some()) {
                    pairs.get_mut(e.slot).leave_out(e.number, e.point, extent);
                }
            }
        }
    }
}

/// All that one body moves over.
struct Ways<'a> {
    points: &'a [GlidePoint],
    /// Those of them that lie on faces.
    faces: &'a [u32],
    /// Shapes that any are on.
    shapes: &'a [u32],
    /// Faces that are yet asked whether they carry the body over a point.
    trials_left: Cell<u32>,
}

impl<'a> Ways<'a> {
    /// Points on faces, as long as any are asked.
    fn faces(&self) -> impl Iterator<Item = &'a GlidePoint> {
        let asks = |_: &&u32| {
            let left = self.trials_left.get();
            self.trials_left.set(left.saturating_sub(1));
            left > 0
        };
        self.faces.iter().take_while(asks).map(|&place| &self.points[place as usize])
    }

    /// Whether something holds of a shape that is none of those of two points.
    fn any_other(&self, [f, e]: [&GlidePoint; 2], holds: impl Fn(u32) -> bool) -> bool {
        self.shapes.iter().any(|&shape| shape != f.shape && shape != e.shape && holds(shape))
    }
}

/// What others move over.
struct Ground<'a> {
    colliders: &'a Pool<Collider, ShapeId>,
    bodies: &'a Pool<Body, BodyId>,
    index: &'a BodyShapeTable,
    /// Of the step (s).
    dt: f32,
}

impl Ground<'_> {
    /// Appends the points of a pair.
    fn list_points(&self, glide: &Glide, pair: &Pair, corners: &mut narrow::Corners, points: &mut Vec<GlidePoint>) {
        let Self { colliders, index, .. } = self;
        let (a, b) = glide.key.shapes();
        let shape = glide.still();
        let mover = if glide.is_second { b } else { a };
        let (collider_state, sign) = (index.collider_state(shape), if glide.is_second { 1.0 } else { -1.0 });
        let turn_a = index.collider_state(a).rotation;
        // A surface has no thickness, and a flat one no extent either.
        let extent_of = |shape: u32| match colliders[shape].shape.geometry().is_solid() {
            true => index.collider_state(shape).least_extent,
            false => f32::INFINITY,
        };
        let extent = extent_of(a).min(extent_of(b));
        let flush = FLUSH * if extent.is_finite() { extent } else { index.least_extent(glide.key) };
        for (number, manifold) in pair.manifolds.iter().enumerate() {
            let part = narrow::parts_of(&colliders[b].shape, manifold.part)[usize::from(!glide.is_second)];
            let normal_of = |normal: Vec3| turn_a * normal * sign;
            let is_face = self.is_face((mover, shape), part, normal_of(manifold.normal));
            let first = points.len();
            let of = |normal: Vec3, point: usize, at: Vec3, separation: f32| GlidePoint {
                slot: glide.slot,
                number,
                point,
                mover,
                shape,
                part,
                at: collider_state.position + (collider_state.rotation * at).as_dvec3(),
                normal: normal_of(normal),
                separation,
                flush,
                is_face,
                first,
            };
            let on_still = |on_a: Vec3, on_b: Vec3| if glide.is_second { on_a } else { on_b };
            let places = manifold.points.iter().enumerate();
            points.extend(places.map(|(i, place)| of(manifold.normal, i, on_still(place.on_a, place.on_b), place.separation)));
            if is_face {
                continue;
            }
            let [shape_a, shape_b] = [a, b].map(|shape| &colliders[shape]);
            let relative = shape_a.relative(shape_b);
            let edge = narrow::nearest_edge(&shape_a.shape, &shape_b.shape, manifold.part, &relative, manifold.normal, corners);
            if let Some(edge) = edge {
                let found = of(edge.normal, 0, on_still(edge.on_a, edge.on_b), points[first].separation);
                points[first] = GlidePoint { is_face: self.is_face((mover, shape), part, found.normal), ..found };
            }
        }
    }

    /// Whether the surface at `f` carries what moves so that it does not meet `e`; `ways` are all of what moves.
    fn carries(&self, f: &GlidePoint, e: &GlidePoint, ways: &Ways) -> bool {
        let is_same = f.shape == e.shape && (f.part == e.part || !self.colliders[e.shape].shape.is_compound());
        let alignment = e.normal.dot(f.normal);
        if is_same {
            return false;
        }
        let into = f.normal * alignment - e.normal;
        if into.length_squared() < UPRIGHT * UPRIGHT || (alignment >= ALIKE && e.is_face) {
            return false;
        }
        let further = into.normalize() * (BEHIND * e.flush);
        let height = f.normal.dot((e.at - f.at).as_vec3());
        let at = e.at - (f.normal * height).as_dvec3();
        // What lies a little deep in one surface meets the side of the next by as much, and what is far off is not seen exactly.
        let unsure = UNSURE * e.separation.max(0.0);
        let depth = (-f.separation).max(0.0) + unsure;
        // Where both move, K may rise out of the plane, or sink below it, by the end of the step.
        let rise = f.normal.dot(self.velocity(e.shape, e.at) - self.velocity(f.shape, e.at)) * self.dt;
        let (lowest, highest) = (height + rise.min(0.0), height + rise.max(0.0));
        // Where e is above the plane, so is K.
        if lowest > e.flush + unsure {
            return false;
        }
        let is_held_above = highest <= e.flush && self.is_rolled_over(f, e, into, ways);
        // What fell has points of the pose that it would have had below the plane: of a side that ends at the plane, they are no more.
        let is_at_plane = highest <= e.flush && lowest >= -(e.flush + depth);
        if !is_at_plane && !is_held_above {
            let is_met = highest > 0.0 && self.distance(e.shape, e.at + further.as_dvec3(), e.flush) < e.flush;
            if is_met || self.distance(e.shape, at, e.flush) > e.flush {
                return false;
            }
        }
        let behind = at + (f.normal * (2.0 * e.flush) + further).as_dvec3();
        let above = (f.normal * (2.0 * e.flush)).as_dvec3();
        // Also where a third one lies there, flush with J: what comes over a corner meets the tile across it before those beside it press.
        let distance = |shape: u32, place: DVec3| self.distance(shape, place, e.flush);
        let lies_there = |shape: u32| distance(shape, at) <= e.flush && distance(shape, at + above) >= e.flush;
        let is_covered = is_held_above || distance(f.shape, at) <= e.flush || ways.any_other([f, e], lies_there);
        if !is_covered {
            return false;
        }
        // What lies against a side of J does so to both hands of e; what rises beside the way does to one.
        let rises = |shape: u32, place: DVec3| distance(shape, place) < e.flush;
        let aside = (f.normal.cross(further).normalize() * (2.0 * e.flush)).as_dvec3();
        let is_filled = |place: DVec3| ways.any_other([f, e], |shape| rises(shape, place));
        // A point that goes with another one's normal may lie at a corner, from where that leads beside K. What is convex and flush rises nowhere.
        let beside = f.normal.cross(further).as_dvec3();
        let is_convex = self.colliders[e.shape].shape.geometry().is_solid() && !self.colliders[e.shape].shape.is_compound();
        let rises_beside = || is_convex && (rises(e.shape, behind + beside) || rises(e.shape, behind - beside));
        let is_walled = || is_filled(behind + aside) && is_filled(behind - aside);
        // A surface has nothing behind it: a wall of triangles rises at e, a steep slope of them before what lies behind.
        let is_solid = self.colliders[e.shape].shape.geometry().is_solid();
        let nearer = if is_solid { &NEARER[..0] } else { &NEARER };
        let rises_before = || nearer.iter().any(|&share| rises(e.shape, behind - (further * (1.0 - share)).as_dvec3()));
        !(rises(e.shape, behind) || rises_beside() || rises_before() || is_walled())
    }

    /// Whether e lies ahead of or behind a round shape that J keeps above its plane, between points that it touches J at or those that it would
    /// roll to from there: it does not tip over to a side then, and comes to no point of that plane or below it in this step.
    fn is_rolled_over(&self, f: &GlidePoint, e: &GlidePoint, into: Vec3, ways: &Ways) -> bool {
        if f.mover != e.mover || !self.index.collider_state(e.mover).is_round {
            return false;
        }
        let across = f.normal.cross(into).normalize();
        let unsure = e.flush + UNSURE * e.separation.max(0.0);
        let on_j = ways.points[f.first..].iter().take_while(|other| other.first == f.first);
        let aside = on_j.map(|other| across.dot((other.at - e.at).as_vec3()));
        let (least, most) =
            aside.fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), aside| (least.min(aside), most.max(aside)));
        least <= unsure && most >= -unsure
    }

    /// The face of K behind the edge `e` where it rises out of the plane of J at `f`, as planks of a bridge that sags do: what rolls on comes to that
    /// face in this step, and not to the edge.
    fn rising_face(&self, f: &GlidePoint, e: &GlidePoint) -> Option<Vec3> {
        let still = self.index.collider_state(e.shape);
        let normal = narrow::face_normal(&self.colliders[e.shape].shape, e.part, still.rotation.conjugate() * f.normal);
        let normal = still.rotation * normal?;
        let ahead = (f.normal * e.normal.dot(f.normal) - e.normal).normalize();
        let above = normal * (2.0 * e.flush);
        let is_beside = self.distance(e.shape, e.at + above.as_dvec3(), e.flush) > e.flush;
        (is_beside && normal.dot(f.normal) >= ALIKE && normal.dot(ahead) < -UPRIGHT).then_some(normal)
    }

    /// Puts the contacts of a round shape with the edge `e` on the face behind it, whose normal is n: with a radius r and the axis at c, that is at
    /// c − r n. Not if the shape does not lie on its side.
    fn put_on_face(&self, normal: Vec3, e: &GlidePoint, pair: &mut Pair, extent: f32) -> bool {
        let [mover, still] = [e.mover, e.shape].map(|shape| self.index.collider_state(shape));
        let down = mover.rotation.conjugate() * -normal;
        let (radius, half_height, down) = match *self.colliders[e.mover].shape.geometry() {
            Geometry::Ball { radius } => (radius, 0.0, down),
            Geometry::Capsule { half_height, radius } => (radius, half_height, down),
            Geometry::Cylinder { half_height, radius } if down.y.abs() < FRAC_1_SQRT_2 => {
                (radius, half_height, down.with_y(0.0).normalize())
            }
            _ => return false,
        };
        let is_second = pair.key.shapes().0 == e.shape;
        let seen_from_a = if is_second { still.rotation.conjugate() * normal } else { mover.rotation.conjugate() * -normal };
        pair.turn(e.number, seen_from_a, extent, |point| {
            let (on_mover, on_still) =
                if is_second { (&mut point.on_b, &mut point.on_a) } else { (&mut point.on_a, &mut point.on_b) };
            *on_mover = Vec3::Y * on_mover.y.clamp(-half_height, half_height) + down * radius;
            let at = mover.rotation * *on_mover;
            point.separation = normal.dot(at - (e.at - mover.position).as_vec3());
            let foot = (mover.position - still.position).as_vec3() + at - normal * point.separation;
            *on_still = still.rotation.conjugate() * foot;
        });
        true
    }

    /// Of a shape's body at a place (m/s).
    fn velocity(&self, shape: u32, at: DVec3) -> Vec3 {
        let body = &self.bodies[self.colliders[shape].body];
        body.linear_velocity + body.angular_velocity.cross((at - body.center).as_vec3())
    }

    /// Whether a direction (in world axes) in which a mover touches a shape is that of a face of a part.
    fn is_face(&self, (mover, shape): (u32, u32), part: u32, normal: Vec3) -> bool {
        let normal = self.index.collider_state(shape).rotation.conjugate() * normal;
        let is_exact = matches!(self.colliders[mover].shape.geometry(), Geometry::Ball { .. } | Geometry::Capsule { .. });
        narrow::is_face_normal(&self.colliders[shape].shape, part, normal, is_exact)
    }

    /// From a shape to a place (m), or infinite where that is more than `most`; zero inside.
    fn distance(&self, shape: u32, at: DVec3, most: f32) -> f32 {
        let collider_state = self.index.collider_state(shape);
        let at = collider_state.rotation.conjugate() * (at - collider_state.position).as_vec3();
        narrow::distance_up_to(&self.colliders[shape].shape, at, most)
    }
}
