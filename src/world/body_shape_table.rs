//! What loops over pairs read of shapes and bodies, in a few bytes each.
//!
//! A pile has ten pairs for each body, and each of its records is hundreds of bytes: a walk that reads one number of each record waits for
//! memory at most pairs, and the more so the more bodies there are. The arrays here stay in the cache.

use glam::Vec3;
use parry3d::bounding_volume::Aabb;

use crate::body::Body;
use crate::collide::collider::Collider;
use crate::collide::collider_state::ColliderState;
use crate::collide::pairs::PairKey;
use crate::id::{BodyId, Pool, ShapeId};
use crate::tight_vec::make_room_behind;

/// A set of slots that is emptied at once.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// When each slot was marked last.
    at: Vec<u32>,
    now: u32,
}

impl Marks {
    /// Forgets all marks, and makes room for those of so many slots.
    pub(super) fn begin(&mut self, slots: usize) {
        if self.now == u32::MAX {
            self.at.clear();
            self.now = 0;
        }
        self.now += 1;
        if self.at.len() < slots {
            self.at.resize(slots, 0);
        }
    }

    pub(super) fn set(&mut self, slot: u32) {
        if self.at.len() <= slot as usize {
            self.at.resize(slot as usize + 1, 0);
        }
        self.at[slot as usize] = self.now;
    }

    pub(super) fn unset(&mut self, slot: u32) {
        if let Some(at) = self.at.get_mut(slot as usize) {
            *at = 0;
        }
    }

    pub(super) fn has(&self, slot: u32) -> bool {
        self.at.get(slot as usize) == Some(&self.now)
    }
}

/// How the shapes of a range of slots stand.
pub(super) struct StancePiece<'a> {
    collider_states: &'a mut [ColliderState],
    known_at: &'a mut [u32],
    now: u32,
}

impl StancePiece<'_> {
    /// Takes note of how the shape at a place in the range stands.
    pub(super) fn set(&mut self, place: usize, collider_state: ColliderState) {
        (self.collider_states[place], self.known_at[place]) = (collider_state, self.now);
    }
}

/// The arrays of a world.
#[derive(Debug, Default)]
pub(super) struct BodyShapeTable {
    /// Body of each shape, by slot.
    bodies: Vec<u32>,
    /// Net force of the contacts of each body in the last substep, by slot (N): of those that do not move by themselves, nothing.
    forces: Vec<Vec3>,
    /// Bodies that a step moves, as it begins.
    pub moving: Marks,
    /// Bodies that islands consist of, but for those that are held with a unit.
    pub free: Marks,
    /// Shapes with another kept box than when pairs were last looked through.
    pub reboxed: Marks,
    /// Every shape that is in an active pair, by slot, and of which shapes that is known in this step.
    collider_states: Vec<ColliderState>,
    known: Marks,
    /// Whether pairs have been looked through since the world was made or restored.
    pub is_known: bool,
}

impl BodyShapeTable {
    /// An index of a world that was restored, with so many places for shapes, and shapes of these bodies.
    pub(super) fn of(places: usize, shapes: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut index = Self { bodies: vec![u32::MAX; places], ..Self::default() };
        shapes.for_each(|(slot, body)| index.add_shape(slot, body));
        index
    }

    /// Takes note of a shape in this slot on a body.
    pub(super) fn add_shape(&mut self, slot: u32, body: u32) {
        if self.bodies.len() <= slot as usize {
            self.bodies.resize(slot as usize + 1, u32::MAX);
        }
        self.bodies[slot as usize] = body;
    }

    /// Forgets how shapes stood in the last step, and makes room for so many.
    pub(super) fn begin_stances(&mut self, shapes: usize) {
        self.known.begin(shapes);
        if self.collider_states.len() < shapes {
            let more = shapes - self.collider_states.len();
            make_room_behind(&mut self.collider_states, more);
            self.collider_states.resize(shapes, ColliderState::UNKNOWN);
        }
    }

    /// Takes note of how a shape stands.
    pub(super) fn set_stance(&mut self, shape: u32, collider_state: ColliderState) {
        self.known.set(shape);
        self.collider_states[shape as usize] = collider_state;
    }

    /// What moves, and how shapes stand and whether that is known, for threads to take note of: in pieces of so many slots.
    pub(super) fn stances_in_pieces(&mut self, piece: usize) -> (&Marks, impl Iterator<Item = StancePiece<'_>>) {
        let Self { moving, collider_states, known: Marks { at, now }, .. } = self;
        let pieces = collider_states.chunks_mut(piece).zip(at.chunks_mut(piece));
        (moving, pieces.map(|(collider_states, known_at)| StancePiece { collider_states, known_at, now: *now }))
    }

    /// Takes note of how the shapes of active pairs stand of which that is not known yet.
    pub(super) fn add_stances(
        &mut self,
        active: &[(PairKey, u32)],
        colliders: &Pool<Collider, ShapeId>,
        bodies: &Pool<Body, BodyId>,
    ) {
        for (key, _) in active {
            for shape in <[u32; 2]>::from(key.shapes()) {
                if !self.known.has(shape) {
                    let collider = &colliders[shape];
                    self.set_stance(shape, ColliderState::of(collider, &bodies[collider.body]));
                }
            }
        }
    }

    /// Has a shape of an active pair stay in this box, and move by so much faster than by its velocity (m/s).
    pub(super) fn drive_further(&mut self, shape: u32, tight_box: Aabb, speed: f32) {
        if self.known.has(shape) {
            let state = &mut self.collider_states[shape as usize];
            state.tight_box = tight_box;
            state.turning += speed;
        }
    }

    /// How a shape in an active pair stands.
    pub(super) fn collider_state(&self, shape: u32) -> &ColliderState {
        &self.collider_states[shape as usize]
    }

    /// Lesser least extent of the shapes of an active pair (m).
    pub(super) fn least_extent(&self, key: PairKey) -> f32 {
        let (a, b) = key.shapes();
        self.collider_state(a).least_extent.min(self.collider_state(b).least_extent)
    }

    /// Net forces of contacts of so many bodies, by slot (N).
    pub(super) fn forces_for(&mut self, bodies: usize) -> &mut [Vec3] {
        if self.forces.len() < bodies {
            let more = bodies - self.forces.len();
            make_room_behind(&mut self.forces, more);
            self.forces.resize(bodies, Vec3::ZERO);
        }
        &mut self.forces
    }

    /// Takes note of the force of a contact of two bodies, as it acts on the second (N).
    pub(super) fn add_contact(&mut self, [a, b]: [u32; 2], force: Vec3) {
        self.forces[a as usize] -= force;
        self.forces[b as usize] += force;
    }

    pub(super) fn forget_force(&mut self, body: u32) {
        if let Some(force) = self.forces.get_mut(body as usize) {
            *force = Vec3::ZERO;
        }
    }

    pub(super) fn set_contact_force(&mut self, body: u32, force: Vec3) {
        if let Some(own) = self.forces.get_mut(body as usize) {
            *own = force;
        }
    }

    /// Net force of the contacts of a body (N).
    pub(super) fn contact_force(&self, body: u32) -> Vec3 {
        self.forces.get(body as usize).copied().unwrap_or(Vec3::ZERO)
    }

    /// Body of a shape.
    pub(super) fn body_of(&self, shape: u32) -> u32 {
        self.bodies[shape as usize]
    }
}
