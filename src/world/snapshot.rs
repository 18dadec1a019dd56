//! A whole world into bytes, and back.

use glam::{DVec3, Quat};
use parry3d::bounding_volume::Aabb;

use super::body_shape_table::BodyShapeTable;
use super::fracture::Fracture;
use super::sensors::Sensors;
use super::unions::Anchor;
use super::wake::is_whole;
use super::{Batches, Collision, Islands, LastStep, Movers, World};
use crate::body::{Anchored, Body, SleepState};
use crate::collide::cache::PairCache;
use crate::collide::collider::{Collider, own_margin};
use crate::error::Result;
use crate::id::{BodyId, JointId, Pool, ShapeId};
use crate::island::{SleepingIsland, SleepingIslands};
use crate::joint_record::Joint;
use crate::report::{Events, StepReport};
use crate::settings::WorldDef;
use crate::snapshot::carried::{CarriedBound, CarriedUnion};
use crate::snapshot::contacts;
use crate::snapshot::forms::{KnownForms, NumberedForms};
use crate::snapshot::table::{Input, Output};
use crate::snapshot::{Displaced, FreeSlots, IslandRow, LISTED, LastBox, Runs, WorldRow, refused, seal};

/// What a snapshot makes of a world, complete and checked.
struct Image {
    row: WorldRow,
    bodies: Pool<Body, BodyId>,
    colliders: Pool<Collider, ShapeId>,
    joints: Pool<Joint, JointId>,
    pairs: PairCache,
    sleeping: SleepingIslands,
    bounds: Vec<CarriedBound>,
    unions: Vec<CarriedUnion>,
}

impl World {
    /// Writes the whole world into `out`, which is cleared.
    ///
    /// The bytes can be given to [`restore`](Self::restore) of this world or of another one, by the same version of the library
    /// on any machine of the same byte order. Events of the last step and the report's counts are not among them.
    pub fn save(&self, out: &mut Vec<u8>) {
        // Whoever adds a field says here where it is stored, or why it is not.
        let Self {
            // In the row of the world.
            def: _,
            report: _,
            support: _,
            fracture: _,
            movers: Movers { slots: _, are_sorted: _, some_are_driven: _, stopped: _, driven_joints: _ },
            // In tables of their own.
            bodies: _,
            colliders: _,
            joints: _,
            // Of collisions boxes are in the row and pairs in a table. What overlaps is stored; what is a sensor follows from the shapes. What
            // has escaped, what touches and the index are made anew from the rest by whoever needs them next.
            collision: Collision { broad: _, pairs: _, sensing: _, escaped: _, touches: _, index: _ },
            // Those that sleep are a table, and units that are held are stored; what else is there is made anew.
            islands: Islands { sleeping: _, hold: _, groups: _, summaries: _ },
            // What edits have ended will be told by the next step; the last step's events are gone after a restore.
            events: _,
            // Carried bounds and what was asked for are stored, and derived bounds made anew.
            long_range: _,
            unions: _,
            // The lengths are in the row; the rest is made anew.
            last: LastStep { substep: _, dt: _, has_smooth_bodies: _, broken: _ },
            // Made anew from the rest by whoever needs them next.
            rest: _,
            batches: Batches { list: _, stages: _, count: _ },
            scratch: _,
            // Belong to the world that is restored, whatever it holds.
            threads: _,
            profiler: _,
            _tag: _,
        } = self;
        let (bounds_stale, carried_bounds) = self.carried_bounds();
        let (stale_unions, carried_unions) = self.carried_unions();
        let forms = NumberedForms::of(self.colliders.iter().map(|(_, collider)| &collider.shape));
        seal::open(out);
        forms.write(out);
        let mut tables = Output::new(out, &forms);
        tables.table(std::iter::once(&self.row(bounds_stale, stale_unions)));
        tables.table(self.bodies.slots().iter());
        tables.table(self.colliders.slots().iter());
        tables.table(self.joints.slots().iter());
        self.write_places(&mut tables);
        self.write_sleepers(&mut tables);
        tables.table(carried_bounds.iter());
        tables.table(carried_unions.iter());
        seal::close(out, seal::form(LISTED));
    }

    /// What there is once in a world.
    fn row(&self, bounds_stale: bool, stale_unions: Vec<u32>) -> WorldRow {
        // The last step's events are gone after a restore; what edits have ended since will be told by the next step.
        let Events {
            moved: _,
            contact_began: _,
            contact_ended: _,
            overloaded: _,
            hits: _,
            joint_stops: _,
            sensor_began: _,
            sensor_ended: _,
            quarantined: _,
            articulations: _,
            islands: _,
            broken: _,
            splits: _,
            pieces: _,
            piece_bodies: _,
            ended_by_edits,
        } = &self.events;
        let (said_supported, watched) = self.support.as_ref().map_or_else(Default::default, |support| support.said());
        WorldRow {
            def: self.def,
            step: self.report.step,
            time: self.report.time,
            last_substep: self.last.substep,
            last_dt: self.last.dt,
            movers: Runs(self.movers.slots.clone()),
            movers_sorted: self.movers.are_sorted,
            changed: Runs(self.collision.broad.changed().to_vec()),
            ended_by_edits: ended_by_edits.clone(),
            sensed: self.collision.sensing.overlaps.clone(),
            said_supported: Runs(said_supported),
            watched,
            bounds_stale,
            stale_unions: Runs(stale_unions),
            pushed: Runs(self.unions.pushed.clone()),
            asked_bounds: self.long_range.soft.clone(),
            asked_fractures: self.fracture.asked().to_vec(),
            held_units: self.islands.hold.units.held.clone(),
            free: FreeSlots {
                bodies: Runs(self.bodies.free().to_vec()),
                shapes: Runs(self.colliders.free().to_vec()),
                joints: Runs(self.joints.free().to_vec()),
                islands: Runs(self.islands.sleeping.free().to_vec()),
            },
        }
    }

    /// Writes where shapes and boxes are that do not follow from their bodies, and the contacts of what is awake.
    fn write_places(&self, tables: &mut Output) {
        let Self { bodies, colliders, unions, collision: Collision { pairs, .. }, .. } = self;
        // What has arrived where a host told it to move to stands in the next step, and so does what it holds.
        let stands = |index: u32| match unions.of(index).map(|union| union.anchor) {
            Some(Anchor::Driven(driver)) => bodies[driver].stops(),
            _ => bodies[index].stops(),
        };
        let is_followed = |index: u32| is_followed(&bodies[index]) && !stands(index);
        let displaced: Vec<Displaced> = colliders
            .iter()
            .filter(|(_, collider)| !same_place(collider.place, collider.world_pose(&bodies[collider.body])))
            .map(|(shape, collider)| Displaced { shape, place: collider.place })
            .collect();
        tables.table(displaced.iter());
        let last_boxes: Vec<LastBox> = colliders
            .iter()
            .filter(|(_, shape)| !is_followed(shape.body) && !same_box(&shape.tight_box, &box_at_rest(shape)))
            .map(|(slot, shape)| LastBox { shape: slot, tight_box: shape.tight_box })
            .collect();
        tables.table(last_boxes.iter());
        contacts::write(tables, (pairs, pairs.listed().iter().map(|&(_, slot)| slot)), colliders);
    }

    /// Writes islands that sleep, and their contacts.
    fn write_sleepers(&self, tables: &mut Output) {
        let Self { colliders, islands: Islands { sleeping, .. }, collision: Collision { pairs, .. }, .. } = self;
        // What a sleeping island kept of a shape that has gone since is not there any more.
        let is_whole = |slot: &u32| is_whole(colliders, pairs.get(*slot).key);
        let asleep: Vec<u32> = sleeping.pairs().filter(is_whole).collect();
        contacts::write(tables, (pairs, asleep.into_iter()), colliders);
        let island = |island: &Option<SleepingIsland>| {
            island.as_ref().map(|SleepingIsland { bodies, pairs, .. }| IslandRow {
                bodies: Runs(bodies.clone()),
                pairs: pairs.iter().filter(|slot| is_whole(slot)).count() as u32,
            })
        };
        let islands: Vec<Option<IslandRow>> = sleeping.islands().iter().map(island).collect();
        tables.table(islands.iter());
    }

    /// Makes the world what it was when `snapshot` was saved: every later step gives the same bits. Handles of what existed then
    /// are valid again, with this world's number in them; the last step's events are gone.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidSnapshot`](crate::ErrorKind::InvalidSnapshot) if the bytes are not a snapshot, of another version of
    /// the library, cut short or corrupted; the world is as it was then.
    pub fn restore(&mut self, snapshot: &[u8]) -> Result<()> {
        let content = seal::content(snapshot, seal::form(LISTED))?;
        let present = self.colliders.iter().map(|(_, collider)| &collider.shape);
        let (forms, content) = KnownForms::read(content, present)?;
        let mut input = Input::new(content, &forms, self._tag.number());
        let image = Image::read(&mut input, self._tag.number()).ok_or(refused("holds what makes no sense"))?;
        let Image { row, bodies, colliders, joints, pairs, sleeping, bounds, unions } = image;
        self.collision.broad.rebuild(colliders.slot_count(), |slot| colliders.get(slot)?.fat_box, row.changed.0);
        self.def = WorldDef { threads: self.def.threads, ..row.def };
        let report = StepReport { step: row.step, time: row.time, ..StepReport::default() };
        self.events = Events { ended_by_edits: row.ended_by_edits, ..Events::default() };
        self.movers.slots = row.movers.0;
        (self.movers.are_sorted, self.movers.some_are_driven) = (row.movers_sorted, true);
        self.movers.driven_joints = joints.iter().filter(|(_, joint)| joint.drive.is_some()).map(|(slot, _)| slot).collect();
        self.last.has_smooth_bodies = true;
        self.last.substep = row.last_substep;
        self.last.dt = row.last_dt;
        self.bodies = bodies;
        self.colliders = colliders;
        self.joints = joints;
        self.collision.pairs = pairs;
        self.islands.sleeping = sleeping;
        // Which joints make unions depends on what was asked for.
        self.long_range.soft.clone_from(&row.asked_bounds);
        self.restart_unions(row.stale_unions.0, row.pushed.0, &unions);
        self.restart_long_range(row.bounds_stale, &bounds, row.asked_bounds);
        self.fracture = Fracture::restored(row.asked_fractures);
        self.report = report;
        self.collision.index =
            BodyShapeTable::of(self.colliders.slot_count(), self.colliders.iter().map(|(slot, collider)| (slot, collider.body)));
        self.add_up_contact_forces();
        let mut sleeping = std::mem::take(&mut self.islands.sleeping);
        sleeping.set_gaps(|members| self.gap_of_island(members));
        self.islands.sleeping = sleeping;
        self.islands.hold.units.held = row.held_units;
        self.last.broken.clear();
        self.batches.count = 0;
        self.islands.groups.forget();
        self.forget_escaped();
        self.collision.sensing = Sensors::of(&self.colliders, row.sensed);
        self.restart_support(&row.said_supported.0, row.watched);
        Ok(())
    }
}

/// Whether the next step looks at where a body is: it makes the boxes of its shapes anew, and follows their contacts.
fn is_followed(body: &Body) -> bool {
    body.is_mover() && !body.held
}

fn box_at_rest(shape: &Collider) -> Aabb {
    shape.world_box(own_margin(shape))
}

fn same_box(a: &Aabb, b: &Aabb) -> bool {
    a.mins.to_array().map(f32::to_bits) == b.mins.to_array().map(f32::to_bits)
        && a.maxs.to_array().map(f32::to_bits) == b.maxs.to_array().map(f32::to_bits)
}

fn same_place(a: (DVec3, Quat), b: (DVec3, Quat)) -> bool {
    a.0.to_array().map(f64::to_bits) == b.0.to_array().map(f64::to_bits)
        && a.1.to_array().map(f32::to_bits) == b.1.to_array().map(f32::to_bits)
}

impl Image {
    /// Reads all tables; `None` if anything in them makes no sense.
    fn read(input: &mut Input, tag: u16) -> Option<Self> {
        let [row] = <[WorldRow; 1]>::try_from(input.table::<WorldRow>()?).ok()?;
        let bodies: Pool<Body, BodyId> = Pool::from_parts(tag, input.table()?, row.free.bodies.0.clone())?;
        let mut colliders: Pool<Collider, ShapeId> = Pool::from_parts(tag, input.table()?, row.free.shapes.0.clone())?;
        let joints: Pool<Joint, JointId> = Pool::from_parts(tag, input.table()?, row.free.joints.0.clone())?;
        for slot in 0..colliders.slot_count() as u32 {
            let body = match colliders.get(slot) {
                Some(collider) => bodies.get(collider.body)?,
                None => continue,
            };
            colliders[slot].follow(body);
        }
        for Displaced { shape, place } in input.table::<Displaced>()? {
            colliders.get(shape)?;
            colliders[shape].place = place;
        }
        for slot in 0..colliders.slot_count() as u32 {
            if let Some(shape) = colliders.get_mut(slot) {
                shape.tight_box = box_at_rest(shape);
            }
        }
        for LastBox { shape, tight_box } in input.table::<LastBox>()? {
            colliders.get_mut(shape)?.tight_box = tight_box;
        }
        let (active, asleep) = (contacts::read(input, &colliders)?, contacts::read(input, &colliders)?);
        let mut next = active.0.len() as u32;
        let mut islands = Vec::new();
        for island in input.table::<Option<IslandRow>>()? {
            islands.push(match island {
                None => None,
                Some(IslandRow { bodies, pairs }) => {
                    let slots = next..next.checked_add(pairs)?;
                    next = slots.end;
                    Some(SleepingIsland { bodies: bodies.0, pairs: slots.collect(), gap: 0.0 })
                }
            });
        }
        let (bounds, unions) = (input.table()?, input.table()?);
        if next as usize != active.0.len() + asleep.0.len() || !input.is_done() {
            return None;
        }
        let sleeping = SleepingIslands::from_parts(islands, row.free.islands.0.clone())?;
        let least_extent = |shape: u32| colliders.get(shape).map_or(0.0, |collider: &Collider| collider.least_extent);
        let pairs = PairCache::from_parts(active, asleep, |key| least_extent(key.shapes().0).min(least_extent(key.shapes().1)))?;
        let image = Self { row, bodies, colliders, joints, pairs, sleeping, bounds, unions };
        image.makes_sense().then_some(image)
    }

    /// Whether everything that names something else names what is there, and numbers are such as a world can have.
    fn makes_sense(&self) -> bool {
        let Self { row, bodies, colliders, joints, pairs, .. } = self;
        let pairs_ok = pairs.all().all(|pair| {
            let (a, b) = pair.key.shapes();
            colliders.get(a).is_some() && colliders.get(b).is_some()
        });
        let lengths_ok = row.last_substep >= 0.0 && row.last_dt >= 0.0 && row.last_dt.is_finite() && row.time.is_finite();
        let bodies_ok = bodies.iter().all(|(slot, body)| self.body_makes_sense(slot, body));
        let joints_ok = joints.iter().all(|(_, joint)| self.joint_makes_sense(joint));
        let shapes_ok = colliders.iter().all(|(_, shape)| shape_makes_sense(shape));
        // With as many places as there are things, and each place right, everything is where it is named.
        let shapes_named: usize = bodies.iter().map(|(_, body)| body.shapes.len()).sum();
        let joints_named: usize = bodies.iter().map(|(_, body)| body.joints.len()).sum();
        let joint_sides = joints.iter().map(|(_, joint)| joint.bodies.iter().flatten().count()).sum();
        let all_named = shapes_named == colliders.len() && joints_named == joint_sides;
        bodies_ok
            && joints_ok
            && shapes_ok
            && pairs_ok
            && all_named
            && self.movers_make_sense()
            && self.sleepers_make_sense()
            && lengths_ok
            && row.def.check().is_ok()
            && self.units_make_sense()
            && row.asked_bounds.iter().all(|asked| asked.bound.check().is_ok())
    }

    fn body_makes_sense(&self, slot: u32, body: &Body) -> bool {
        let own_shape = |&id| self.colliders.find(id).is_ok_and(|shape| self.colliders[shape].body == slot);
        let own_joint = |&id| self.joints.find(id).is_ok_and(|joint| self.joints[joint].bodies.contains(&Some(slot)));
        body.center.abs().max_element() <= crate::check::MAX_COORDINATE
            && (body.rotation.length_squared() - 1.0).abs() < 0.1
            && body.linear_velocity.is_finite()
            && body.angular_velocity.is_finite()
            && body.force.is_finite()
            && body.torque.is_finite()
            && body.settings.gravity_scale.is_finite()
            && body.settings.linear_damping >= 0.0
            && body.settings.angular_damping >= 0.0
            && crate::check::lever("local_center", body.local_center).is_ok()
            && body.is_dynamic() == body.mass.is_some()
            && body.mass.is_none_or(|mass| mass.checked().is_ok())
            && body.kinematic.path.as_ref().is_none_or(|path| path.is_finite() && !body.is_free())
            && (body.anchored == Anchored::No || body.is_dynamic())
            && body.shapes.iter().all(own_shape)
            && body.joints.iter().all(own_joint)
    }

    fn joint_makes_sense(&self, joint: &Joint) -> bool {
        let named = |(body, named): (Option<u32>, BodyId)| match body {
            None => named == BodyId::NULL,
            Some(body) => self.bodies.find(named) == Ok(body),
        };
        let ends = [(joint.bodies[0], joint.def.body_a), (joint.bodies[1], joint.def.body_b)];
        ends.into_iter().all(named)
            && joint.def.checked().is_ok()
            && joint.angles.iter().all(|angle| angle.is_finite())
            && joint.motors.iter().all(|force| force.is_finite())
            && joint.strain.is_some() == joint.def.strength.can_break()
            && joint.rebounds.speeds.iter().all(|&speed| speed.is_finite() && speed >= 0.0)
            && joint.drive.as_ref().is_none_or(|drive| drive.is_finite())
    }

    /// Whether every dynamic body that moves is listed, and the list is in order where it says so.
    fn movers_make_sense(&self) -> bool {
        let listed = &self.row.movers.0;
        let mut sorted = listed.clone();
        sorted.sort_unstable();
        let moves = |body: &Body| body.is_free() && body.is_mover();
        let all_listed = self.bodies.iter().all(|(slot, body)| !moves(body) || sorted.binary_search(&slot).is_ok());
        let is_settled = || {
            let known = |&slot: &u32| self.bodies.get(slot).is_some_and(Body::is_mover);
            listed.is_sorted_by(|a, b| a < b) && listed.iter().all(known)
        };
        all_listed && (!self.row.movers_sorted || is_settled())
    }

    /// Whether every body of a unit is there, and in one.
    fn units_make_sense(&self) -> bool {
        let mut listed: Vec<u32> = self.row.held_units.iter().flat_map(|unit| &unit.bodies).map(|held| held.body).collect();
        listed.sort_unstable();
        listed.is_sorted_by(|a, b| a < b) && listed.iter().all(|&body| self.bodies.get(body).is_some())
    }

    /// Whether islands and the bodies that sleep in them agree.
    fn sleepers_make_sense(&self) -> bool {
        let asleep = self.bodies.iter().filter(|(_, body)| !body.is_awake()).count();
        let islands = self.sleeping.islands().iter().enumerate();
        let members = islands
            .flat_map(|(number, island)| island.iter().flat_map(|island| &island.bodies).map(move |&body| (number as u32, body)));
        let (mut count, mut right) = (0, true);
        for (island, body) in members {
            count += 1;
            right &= self.bodies.get(body).is_some_and(|body| body.sleep == SleepState::Asleep { island });
        }
        right && count == asleep
    }
}

fn shape_makes_sense(shape: &Collider) -> bool {
    shape.place.0.is_finite()
        && crate::check::rotation("place", shape.place.1).is_ok()
        && shape.local_pose.checked().is_ok()
        && shape.material.check().is_ok()
        && shape.density >= 0.0
        && !(shape.reach.is_nan() || shape.least_extent.is_nan())
        && shape.fat_box.is_some_and(|kept| kept.mins.cmple(kept.maxs).all())
}
