//! Attaching, changing and destroying shapes.

use parry3d::bounding_volume::BoundingVolume;

use super::pairs::{contact_pair, may_collide};
use super::wake::Edited;
use super::{Collision, World};
use crate::body::BodyKind;
use crate::collide::broad::still_near;
use crate::collide::collider::{Collider, own_margin};
use crate::collide::pairs::PairKey;
use crate::error::Result;
use crate::id::{BodyId, ShapeId};
use crate::material::Material;
use crate::shape::{self, CollisionFilter, ShapeDef};

impl World {
    /// Adds a shape to a body; the body's mass follows unless it was set outright.
    ///
    /// # Errors
    /// The handle is not a body of this world; a field of `def` is out of range; the shape cannot be on a dynamic body.
    pub fn attach_shape(&mut self, body: BodyId, def: &ShapeDef) -> Result<ShapeId> {
        let index = self.bodies.find(body)?;
        let dynamic = self.bodies[index].kind == BodyKind::Dynamic;
        let def = def.clone().checked(dynamic)?;
        let mass = if dynamic {
            let mut defs = self.shape_defs(index);
            defs.push(def.clone());
            Some(shape::resolve_mass(self.bodies[index].settings.mass_source, &defs)?)
        } else {
            None
        };
        let id = self.add_collider(index, &def)?;
        self.apply_mass(index, mass);
        self.wake_for(Edited::Shape(id));
        self.note_mover(index);
        Ok(id)
    }

    /// Takes a shape off its body; the body's mass follows unless it was set outright.
    ///
    /// # Errors
    /// The handle is not a shape of this world; without the shape a dynamic body would have no mass.
    pub fn destroy_shape(&mut self, shape: ShapeId) -> Result<()> {
        let slot = self.colliders.find_to_destroy(shape)?;
        let index = self.colliders[slot].body;
        let mass = if self.bodies[index].is_dynamic() {
            let mut defs = self.shape_defs(index);
            defs.remove(self.bodies[index].shapes.iter().position(|&id| id == shape).unwrap_or(0));
            Some(shape::resolve_mass(self.bodies[index].settings.mass_source, &defs)?)
        } else {
            None
        };
        self.wake_for(Edited::Shape(shape));
        self.remove_collider(slot);
        self.apply_mass(index, mass);
        Ok(())
    }

    /// Gives a shape another surface.
    ///
    /// # Errors
    /// The handle is not a shape of this world; a coefficient is out of range.
    pub fn set_material(&mut self, shape: ShapeId, material: Material) -> Result<()> {
        material.check()?;
        let slot = self.colliders.find(shape)?;
        self.wake_for(Edited::Shape(shape));
        self.colliders[slot].material = material;
        Ok(())
    }

    /// Gives a shape another filter.
    ///
    /// # Errors
    /// The handle is not a shape of this world.
    pub fn set_filter(&mut self, shape: ShapeId, filter: CollisionFilter) -> Result<()> {
        let slot = self.colliders.find(shape)?;
        self.wake_for(Edited::Shape(shape));
        self.colliders[slot].filter = filter;
        self.drop_pairs_of_shape(slot);
        self.collision.broad.revisit(slot);
        Ok(())
    }

    pub(super) fn add_collider(&mut self, index: u32, def: &ShapeDef) -> Result<ShapeId> {
        let body = &self.bodies[index];
        let collider = Collider::new(index, def, body.local_center);
        let (slot, id) = self.colliders.insert(collider)?;
        self.collision.sensing.note(slot, def.sensor);
        self.collision.index.add_shape(slot, index);
        let shapes = &mut self.bodies[index].shapes;
        // Most bodies have one.
        if shapes.is_empty() {
            shapes.reserve_exact(1);
        }
        shapes.push(id);
        self.refresh_box(slot);
        Ok(id)
    }

    pub(super) fn remove_collider(&mut self, slot: u32) {
        self.drop_pairs_of_shape(slot);
        self.collision.broad.remove(slot);
        self.collision.sensing.note(slot, false);
        let id = self.colliders.handle_of(slot);
        if let Some(collider) = self.colliders.remove(slot) {
            self.bodies[collider.body].shapes.retain(|&other| other != id);
        }
    }

    /// Gives up the pairs of a shape, whose bodies are awake or not dynamic; contacts that end so are the next step's events.
    fn drop_pairs_of_shape(&mut self, slot: u32) {
        for (key, pair) in self.pairs_of_shape(slot) {
            self.give_up_pair(key, pair);
        }
    }

    /// Gives up the pairs between two bodies.
    pub(super) fn drop_pairs_between(&mut self, a: u32, b: u32) {
        let (few, other) = if self.bodies[a].shapes.len() <= self.bodies[b].shapes.len() { (a, b) } else { (b, a) };
        for id in self.bodies[few].shapes.clone() {
            let Ok(slot) = self.colliders.find(id) else { continue };
            self.drop_pairs_where(slot, |world, shape| world.colliders[shape].body == other);
        }
    }

    /// Gives up the active pairs of a shape with those others.
    pub(super) fn drop_pairs_where(&mut self, slot: u32, is_one: impl Fn(&Self, u32) -> bool) {
        for (key, pair) in self.pairs_of_shape(slot) {
            let (first, second) = key.shapes();
            if is_one(self, if first == slot { second } else { first }) {
                self.give_up_pair(key, pair);
            }
        }
    }

    /// Brings pairs up to date with what a joint holds together from now on, or no longer does.
    pub(super) fn review_pairs_of_joint(&mut self, joint: u32) {
        let bodies = self.joints[joint].bodies;
        for (body, other) in [(bodies[0], bodies[1]), (bodies[1], bodies[0])] {
            let Some(body) = body else { continue };
            if self.bodies[body].is_free() {
                self.review_pairs_of(body);
            } else if let Some(other) = other {
                // A floor has too many pairs: of them, those with what the other holds.
                let held = self.bodies[other].joints.iter().flat_map(|&id| self.joints[self.joints.slot_of(id)].bodies);
                let held: Vec<u32> = held.flatten().filter(|&held| held != other && self.bodies[held].is_free()).collect();
                held.into_iter().for_each(|held| self.review_pairs_of(held));
            }
        }
    }

    fn review_pairs_of(&mut self, body: u32) {
        for id in self.bodies[body].shapes.clone() {
            let Ok(shape) = self.colliders.find(id) else { continue };
            self.collision.broad.revisit(shape);
            self.drop_pairs_where(shape, |world, other| {
                let [own, other] = [shape, other].map(|shape| &world.colliders[shape]);
                !may_collide(own, other, &world.bodies, &world.joints, &world.unions)
            });
        }
    }

    fn give_up_pair(&mut self, key: PairKey, slot: u32) {
        if self.collision.pairs.get(slot).in_contact {
            self.events.ended_by_edits.push(contact_pair(&self.colliders, &self.bodies, key));
        }
        self.collision.pairs.give_up(slot);
    }

    /// Active pairs of a shape with their slots, in key order: kept boxes of a pair meet, so that the tree of boxes names them.
    pub(super) fn pairs_of_shape(&self, slot: u32) -> Vec<(PairKey, u32)> {
        let Some(region) = self.colliders[slot].fat_box else { return Vec::new() };
        let found = self.collision.broad.overlapping(&region).filter(|&other| other != slot);
        let mut found: Vec<(PairKey, u32)> = found
            .filter_map(|other| {
                let key = PairKey::new(slot, other);
                Some((key, self.collision.pairs.find(key)?))
            })
            .collect();
        found.sort_unstable();
        debug_assert!(
            found.iter().eq(self
                .collision
                .pairs
                .listed()
                .iter()
                .filter(|(key, _)| [key.shapes().0, key.shapes().1].contains(&slot))),
            "kept boxes of active pairs meet"
        );
        found
    }

    /// Gives up all pairs of a body; those that still hold are found again in the next step.
    pub(super) fn forget_contacts_of(&mut self, index: u32) {
        for id in self.bodies[index].shapes.clone() {
            if let Ok(slot) = self.colliders.find(id) {
                self.drop_pairs_of_shape(slot);
                self.collision.broad.revisit(slot);
            }
        }
    }

    /// Brings the kept boxes of a body to where it is now.
    pub(super) fn refresh_boxes(&mut self, index: u32) {
        for id in self.bodies[index].shapes.clone() {
            if let Ok(slot) = self.colliders.find(id) {
                self.refresh_box(slot);
            }
        }
    }

    /// The same between two looks for pairs: those that do not meet any more are given up.
    pub(super) fn take_boxes_along(&mut self, index: u32) {
        for id in self.bodies[index].shapes.clone() {
            let Ok(slot) = self.colliders.find(id) else { continue };
            let pairs = self.pairs_of_shape(slot);
            self.refresh_box(slot);
            for (key, pair) in pairs {
                let (a, b) = key.shapes();
                if !still_near(&self.colliders[a].fat_box, &self.colliders[b].fat_box) {
                    self.give_up_pair(key, pair);
                }
            }
        }
    }

    /// Gives the shapes of a body that an edit has stopped the boxes of what is at rest: no step gives it boxes for its motion any more,
    /// and those of the last one are not stored.
    pub(super) fn rest_boxes(&mut self, index: u32) {
        let Self { bodies, colliders, collision: Collision { index: known, .. }, .. } = self;
        if bodies[index].is_mover() {
            return;
        }
        for slot in bodies[index].shapes.iter().filter_map(|&id| colliders.find(id).ok()).collect::<Vec<_>>() {
            let collider = &mut colliders[slot];
            collider.tight_box = collider.world_box(own_margin(collider));
            known.reboxed.set(slot);
        }
    }

    fn refresh_box(&mut self, slot: u32) {
        let collider = &mut self.colliders[slot];
        collider.follow(&self.bodies[collider.body]);
        collider.tight_box = collider.world_box(own_margin(collider));
        let kept = collider.tight_box.loosened(collider.fat_margin());
        collider.fat_box = Some(kept);
        self.collision.index.reboxed.set(slot);
        self.collision.broad.place(slot, kept);
    }
}
