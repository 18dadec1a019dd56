//! Stage that finds what overlaps each sensor, and reports what began and ended.
//!
//! A sensor sees every shape of another body that its filter accepts and that is no sensor itself, unless both bodies are static.
//! It looks at poses at the end of the step: what passes through it within one is not seen.

use super::World;
use crate::body::BodyKind;
use crate::collide::collider::Collider;
use crate::id::{Pool, ShapeId};
use crate::query;
use crate::report::ContactPair;

/// The sensors of a world, and what overlaps them.
#[derive(Debug, Default)]
pub(super) struct Sensors {
    /// Slots of shapes, sorted.
    sensors: Vec<u32>,
    /// The sensor first, sorted.
    pub overlaps: Vec<ContactPair>,
    now: Vec<ContactPair>,
    near: Vec<u32>,
}

impl Sensors {
    /// Those of a world that has been restored.
    pub(super) fn of(colliders: &Pool<Collider, ShapeId>, overlaps: Vec<ContactPair>) -> Self {
        let sensors = colliders.iter().filter(|(_, shape)| shape.sensor).map(|(slot, _)| slot).collect();
        Self { sensors, overlaps, ..Self::default() }
    }

    /// Takes note of whether the shape in this slot is a sensor.
    pub(super) fn note(&mut self, slot: u32, is_sensor: bool) {
        match (self.sensors.binary_search(&slot), is_sensor) {
            (Ok(place), false) => drop(self.sensors.remove(place)),
            (Err(place), true) => self.sensors.insert(place, slot),
            _ => {}
        }
    }
}

impl World {
    pub(super) fn sense(&mut self) {
        if self.collision.sensing.sensors.is_empty() && self.collision.sensing.overlaps.is_empty() {
            return;
        }
        let mut sensing = std::mem::take(&mut self.collision.sensing);
        sensing.now.clear();
        for &sensor in &sensing.sensors {
            self.list_near(sensor, &mut sensing.near);
            for &visitor in sensing.near.iter().filter(|&&visitor| self.is_inside(sensor, visitor)) {
                let body_of = |slot: u32| self.bodies.handle_of(self.colliders[slot].body);
                sensing.now.push(ContactPair {
                    shape_a: self.colliders.handle_of(sensor),
                    shape_b: self.colliders.handle_of(visitor),
                    body_a: body_of(sensor),
                    body_b: body_of(visitor),
                });
            }
        }
        sensing.now.sort_unstable_by_key(key);
        let missing = |from: &[ContactPair], pair: &ContactPair| from.binary_search_by_key(&key(pair), key).is_err();
        self.events.sensor_began.extend(sensing.now.iter().filter(|pair| missing(&sensing.overlaps, pair)));
        self.events.sensor_ended.extend(sensing.overlaps.iter().filter(|pair| missing(&sensing.now, pair)));
        std::mem::swap(&mut sensing.now, &mut sensing.overlaps);
        self.collision.sensing = sensing;
    }

    /// Shapes that may be inside a sensor, each once.
    fn list_near(&self, sensor: u32, near: &mut Vec<u32>) {
        let region = self.colliders[sensor].world_box(0.0);
        near.clear();
        near.extend(self.collision.broad.overlapping(&region));
        near.extend(self.escaped_shapes());
        near.sort_unstable();
        near.dedup();
    }

    fn is_inside(&self, sensor: u32, visitor: u32) -> bool {
        let (Some(a), Some(b)) = (self.colliders.get(sensor), self.colliders.get(visitor)) else { return false };
        let (body_a, body_b) = (&self.bodies[a.body], &self.bodies[b.body]);
        let both_static = body_a.kind == BodyKind::Static && body_b.kind == BodyKind::Static;
        if b.sensor || a.body == b.body || both_static || body_b.quarantined || !a.filter.accepts(&b.filter) {
            return false;
        }
        query::shapes_overlap(self.on_body(sensor), self.on_body(visitor))
    }
}

fn key(pair: &ContactPair) -> (ShapeId, ShapeId) {
    (pair.shape_a, pair.shape_b)
}
