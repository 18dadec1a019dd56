//! Contacts and events of the last step, for reading.

use glam::Vec3;

use super::pairs::contact_pair;
use super::{Collision, LastStep, World};
use crate::body::SleepState;
use crate::collide::collider::{self, Collider};
use crate::collide::narrow::{self, MAX_POINTS, Manifold, ManifoldPoint, NarrowScratch};
use crate::collide::pairs::{PairKey, WorldManifold};
use crate::collide::persistent_manifold::Carried;
use crate::error::Result;
use crate::id::BodyId;
use crate::report::{ArticulationReport, Contact, ContactPair, ContactPoint, Hit, IslandReport, JointOverload, JointStop, Moved};

/// Cosine between normals of surfaces that face the same way: within 60°, as far as neighbours on a round hull are not.
const SAME_SIDE: f32 = 0.5;

impl World {
    /// Bodies whose pose changed in the last step, those that fell asleep at its end included, in order of creation slot.
    pub fn moved(&self) -> &[Moved] {
        &self.events.moved
    }

    /// How each articulation was solved in the last step: bodies that joints connect and that are solved at once.
    ///
    /// Islands that sleep or are held, and joints that are left to sweeps alone, are not among them.
    pub fn articulations(&self) -> &[ArticulationReport] {
        &self.events.articulations
    }

    /// How each island with joints was solved in the last step, and why.
    ///
    /// Islands that sleep or are held, and those without joints, whose contacts are swept, are not among them.
    pub fn islands(&self) -> &[IslandReport] {
        &self.events.islands
    }

    /// Pairs of shapes whose contact began in the last step.
    pub fn contact_began(&self) -> &[ContactPair] {
        &self.events.contact_began
    }

    /// Pairs of shapes whose contact ended in the last step, or by an edit since the step before it: handles of what the edit
    /// destroyed are stale.
    pub fn contact_ended(&self) -> &[ContactPair] {
        &self.events.contact_ended
    }

    /// Joints whose load passed their limit in the last step.
    pub fn overloaded(&self) -> &[JointOverload] {
        &self.events.overloaded
    }

    /// Contacts whose shapes met faster than [`WorldDef::hit_threshold`](crate::WorldDef::hit_threshold) in the last step.
    pub fn hits(&self) -> &[Hit] {
        &self.events.hits
    }

    /// Joints that came to a stop of theirs in the last step.
    pub fn joint_stops(&self) -> &[JointStop] {
        &self.events.joint_stops
    }

    /// Shapes that began to overlap a sensor in the last step; of each pair, the sensor comes first.
    pub fn sensor_began(&self) -> &[ContactPair] {
        &self.events.sensor_began
    }

    /// Shapes that ceased to overlap a sensor in the last step, or of which either was destroyed since the step before it:
    /// handles of what was are stale.
    pub fn sensor_ended(&self) -> &[ContactPair] {
        &self.events.sensor_ended
    }

    /// Everything that overlaps a sensor at the end of the last step, by sensor; of each pair, the sensor comes first.
    pub fn sensed(&self) -> &[ContactPair] {
        &self.collision.sensing.overlaps
    }

    /// Bodies that the last step would have given a non-finite state: they stay where they were, without contacts, until the
    /// host gives them a pose or velocity.
    pub fn quarantined(&self) -> &[BodyId] {
        &self.events.quarantined
    }

    /// Net force of all contacts on a body in the last substep (N).
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn contact_force(&self, body: BodyId) -> Result<Vec3> {
        let index = self.bodies.find(body)?;
        // What joints hold to something static is like that: nothing solves it, and part of what touches it may sleep. What they have just let
        // go has had no force of its own yet.
        let kept = self.collision.index.contact_force(index);
        let is_kept = self.bodies[index].is_free() && (kept != Vec3::ZERO || !self.unions.stale.contains(&index));
        Ok(if is_kept { kept } else { self.force_on_fixed(index) })
    }

    /// Every manifold between shapes of which at least one body is awake, in a fixed order.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let listed = self.collision.pairs.listed();
        (0..listed.len()).map(move |place| listed[place]).flat_map(|(key, slot)| self.contacts_now(key, slot))
    }

    /// Every manifold of a body, asleep or awake, in a fixed order.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn contacts_of(&self, body: BodyId) -> Result<impl Iterator<Item = Contact> + '_> {
        let index = self.bodies.find(body)?;
        Ok(self.pairs_of_body(index).flat_map(|(key, slot)| self.contacts_now(key, slot)))
    }

    fn pairs_of_body(&self, index: u32) -> impl Iterator<Item = (PairKey, u32)> + '_ {
        let mut pairs: Vec<(PairKey, u32)> = Vec::new();
        for &shape in &self.bodies[index].shapes {
            pairs.extend(self.colliders.find(shape).iter().flat_map(|&slot| self.pairs_of_shape(slot)));
        }
        pairs.sort_unstable();
        pairs.into_iter().chain(self.kept_pairs_of(index))
    }

    /// Pairs of a body that sleeping islands keep: of a body asleep, its own island.
    fn kept_pairs_of(&self, index: u32) -> impl Iterator<Item = (PairKey, u32)> + '_ {
        let body = &self.bodies[index];
        let islands = self.islands.sleeping.islands();
        let islands = match body.sleep {
            SleepState::Asleep { island } => &islands[island as usize..][..1],
            SleepState::Awake { .. } if body.is_free() => &[],
            SleepState::Awake { .. } => islands,
        };
        let kept =
            islands.iter().flatten().flat_map(|island| &island.pairs).map(|&slot| (self.collision.pairs.get(slot).key, slot));
        kept.filter(move |(key, _)| {
            let (a, b) = key.shapes();
            self.colliders[a].body == index || self.colliders[b].body == index
        })
    }

    /// Gives every body the sum of the forces of its contacts, as after a restore.
    pub(super) fn add_up_contact_forces(&mut self) {
        let Self {
            collision: Collision { pairs, index, .. },
            bodies,
            colliders,
            last: LastStep { substep: last_substep, .. },
            ..
        } = self;
        index.forces_for(bodies.slot_count());
        let per_substep = if *last_substep > 0.0 { 1.0 / *last_substep } else { 0.0 };
        for pair in pairs.all().filter(|pair| pair.has_points()) {
            let (a, b) = pair.key.shapes();
            let rotation = colliders[a].place.1;
            let force = |manifold: Carried| {
                let normal: f32 = manifold.impulses.normal.iter().sum();
                ((rotation * manifold.normal) * normal + manifold.impulses.friction) * per_substep
            };
            let force: Vec3 = pair.manifolds.iter().map(force).sum();
            index.add_contact([colliders[a].body, colliders[b].body], force);
        }
    }

    fn force_on_fixed(&self, index: u32) -> Vec3 {
        let mut force = Vec3::ZERO;
        for contact in self.pairs_of_body(index).flat_map(|(key, slot)| self.contacts_of_pair(key, slot)) {
            let on_b = contact.force();
            force += if contact.pair.body_b == self.bodies.handle_of(index) { on_b } else { -on_b };
        }
        force
    }

    /// Contacts of a pair as the solver had them: their points have gone along with the bodies that they lay on.
    pub(super) fn contacts_of_pair(&self, key: PairKey, slot: u32) -> impl Iterator<Item = Contact> + '_ {
        self.contacts_where(key, slot, Vec::new())
    }

    /// The same with points and separations where surfaces are now: what turns or rolls touches with another point by the end of a step.
    pub(super) fn contacts_now(&self, key: PairKey, slot: u32) -> impl Iterator<Item = Contact> + '_ {
        self.contacts_where(key, slot, self.manifolds_now(key, slot))
    }

    /// Manifolds of a pair as it lies now; none if it lies as it did when those that it has were made.
    fn manifolds_now(&self, key: PairKey, slot: u32) -> Vec<Manifold> {
        let pair = self.collision.pairs.get(slot);
        let Some((_, margin)) = pair.made_for().filter(|_| pair.has_points()) else { return Vec::new() };
        let (shape_a, shape_b) = (&self.colliders[key.shapes().0], &self.colliders[key.shapes().1]);
        let [place_a, place_b] = [shape_a, shape_b].map(|shape| shape.world_pose(&self.bodies[shape.body]));
        let relative = collider::relative(place_a, place_b);
        let mut manifolds = Vec::new();
        let is_round = shape_a.shape.is_round() || shape_b.shape.is_round();
        if !pair.is_near(&relative, shape_a.least_extent.min(shape_b.least_extent), is_round) {
            let scratch = &mut NarrowScratch::default();
            narrow::collide(&shape_a.shape, &shape_b.shape, relative, margin, scratch, &mut manifolds);
        }
        manifolds
    }

    fn contacts_where(&self, key: PairKey, slot: u32, now: Vec<Manifold>) -> impl Iterator<Item = Contact> + '_ {
        let (a, b) = key.shapes();
        let (shape_a, shape_b) = (&self.colliders[a], &self.colliders[b]);
        let (body_a, body_b) = (&self.bodies[shape_a.body], &self.bodies[shape_b.body]);
        let pair = contact_pair(&self.colliders, &self.bodies, key);
        let per_substep = if self.last.substep > 0.0 { 1.0 / self.last.substep } else { 0.0 };
        let (origin, turn) = shape_a.world_pose(body_a);
        // A flat mesh has no thickness.
        let solid = |extent: f32| if extent > 0.0 { extent } else { f32::INFINITY };
        let extent = solid(shape_a.least_extent).min(solid(shape_b.least_extent));
        let manifolds = &self.collision.pairs.get(slot).manifolds;
        let only = nearest_pair(&now).filter(|_| manifolds.len() == 1);
        manifolds.iter().map(move |manifold| {
            let world = WorldManifold::new(&manifold, (shape_a, body_a), (shape_b, body_b));
            let only = only.filter(|_| manifold.points.len() == 1);
            let normal = only.map_or(world.normal, |(normal, _)| (turn * normal).normalize());
            let mut contact = Contact::new(pair, normal, manifold.impulses.friction * per_substep);
            let apart = |i: usize| {
                let (on_a, on_b) = (body_a.center + world.lever_a[i].as_dvec3(), body_b.center + world.lever_b[i].as_dvec3());
                (0.5 * (on_a + on_b), world.normal.dot((on_b - on_a).as_vec3()))
            };
            let middle = |i: usize| turn.conjugate() * (apart(i).0 - origin).as_vec3();
            let mut places = successors(&now, &manifold, middle, extent);
            places[0] = only.map_or(places[0], |(_, place)| Some(place));
            for (i, (place, normal)) in places.into_iter().zip(manifold.impulses.normal).enumerate().take(manifold.points.len()) {
                let place = place.map(|(middle, separation)| (origin + (turn * middle).as_dvec3(), separation));
                let (position, separation) = place.unwrap_or_else(|| apart(i));
                contact.push(ContactPoint { position, separation, normal_force: normal * per_substep });
            }
            contact
        })
    }

    /// Whether a swept shape and another may touch at all.
    pub(super) fn may_meet(&self, a: &Collider, b: &Collider) -> bool {
        super::pairs::may_collide(a, b, &self.bodies, &self.joints, &self.unions)
    }
}

/// Normal, middle (m) and separation (m), in A's frame, of the only point of the only manifold, if there is no other: it takes the place of any such
/// point, however far the shapes have turned.
fn nearest_pair(now: &[Manifold]) -> Option<(Vec3, (Vec3, f32))> {
    let [manifold] = now else { return None };
    let [point] = manifold.contacts() else { return None };
    Some((manifold.normal, (point.on_a + manifold.normal * (0.5 * point.separation), point.separation)))
}

/// Distance below which two points are at one place, over the lesser least extent.
const ONE_PLACE: f32 = 1.0e-6;

/// The middle, in A's frame (m), and the separation (m) of the point that has taken the place of each one of a manifold, which has come to
/// `at`: it is of the same feature, or else the nearest that is no other's, on a surface that faces about the same way and not as far as the
/// shapes are thick. Which corners of a face are kept may change with the last bit.
fn successors(now: &[Manifold], before: &Carried, at: impl Fn(usize) -> Vec3, extent: f32) -> [Option<(Vec3, f32)>; MAX_POINTS] {
    let facing = now.iter().filter(|manifold| manifold.normal.dot(before.normal) > SAME_SIDE);
    let placed = facing.flat_map(|manifold| {
        let middle = |point: &ManifoldPoint| point.on_a + manifold.normal * (0.5 * point.separation);
        manifold.contacts().iter().map(move |point| ((manifold.part, point.feature), (middle(point), point.separation)))
    });
    let mut places: [Option<(Vec3, f32)>; MAX_POINTS] = [None; MAX_POINTS];
    for same in [true, false] {
        for (i, old) in before.points.iter().enumerate() {
            if places[i].is_some() {
                continue;
            }
            // At a seam two parts have a point each at one place.
            let is_free = |middle: Vec3| places.iter().flatten().all(|taken| taken.0.distance(middle) > ONE_PLACE * extent);
            let fits = |&(feature, (middle, _)): &(_, (Vec3, f32))| {
                (feature == (before.part, old.feature)) == same && (same || is_free(middle))
            };
            let distance_squared = |place: &(Vec3, f32)| place.0.distance_squared(at(i));
            let nearest = placed.clone().filter(fits).map(|(_, place)| place);
            let nearest = nearest.min_by(|a, b| distance_squared(a).total_cmp(&distance_squared(b)));
            places[i] = nearest.filter(|place| distance_squared(place) <= extent * extent);
        }
    }
    places
}
