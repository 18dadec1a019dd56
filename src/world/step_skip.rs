//! Skips the work of a step in which nothing can move.
//!
//! A step depends on the records of bodies, shapes, joints and pairs, and on what edits have left for it. Where all that could move is held
//! (*hold.rs*) and the last step has changed no record, this one would find what that one found: the same boxes, pairs, contacts and
//! islands. So none of it is looked for. Whatever opens a record to a change ends that, as pools count it ([`Pool::changes`]).
//!
//! [`Pool::changes`]: crate::id::Pool::changes

use super::World;
use crate::report::StepCounts;

/// State of the records of bodies, shapes and joints.
type Changes = [[u64; 2]; 3];

/// What the last step has left.
#[derive(Debug, Default)]
pub(super) struct StepSkip {
    /// As this step began.
    before: Changes,
    /// As the last step ended, if it has changed nothing.
    still: Option<Changes>,
    /// What the last step has counted.
    counts: StepCounts,
}

impl World {
    fn changes(&self) -> Changes {
        [self.bodies.changes(), self.colliders.changes(), self.joints.changes()]
    }

    /// Whether anything may be found in this step that was not in the last one; where not, what that one has counted is counted again.
    pub(super) fn stirs(&mut self) -> bool {
        let now = self.changes();
        self.rest.before = now;
        if self.rest.still != Some(now) || !self.collision.broad.changed().is_empty() {
            return true;
        }
        self.report.counts = self.rest.counts;
        false
    }

    /// Takes note of whether the step has changed anything.
    pub(super) fn note_rest(&mut self) {
        let (now, counts) = (self.changes(), self.report.counts);
        let is_still = self.rest.before == now
            && self.rest.counts == counts
            && counts.bodies_held as usize == self.movers.slots.len()
            && counts.pairs_updated == 0
            && counts.joints_condemned == 0
            && self.movers.are_sorted
            && !self.islands.hold.let_go;
        self.rest.still = is_still.then_some(now);
        self.rest.counts = counts;
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::{BodyDef, BodyId, Material, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef};

    const DT: f32 = 1.0 / 60.0;

    /// Two stacks on a floor, of which nothing sleeps.
    fn stacks(threads: u32) -> (World, Vec<BodyId>) {
        let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
        let mut world = World::new(&WorldDef { sleep, threads, ..WorldDef::default() }).unwrap();
        let floor = Shape::cuboid(Vec3::new(20.0, 0.5, 20.0)).unwrap();
        let mut bodies =
            vec![world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(ShapeDef::new(floor))).unwrap()];
        for (x, row) in [(0.0, 0), (0.0, 1), (0.0, 2), (3.0, 0), (3.0, 1)] {
            let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).unwrap());
            let def = BodyDef::dynamic(Pose::at_xyz(x, 0.5 + f64::from(row), 0.0)).with_shape(cube);
            bodies.push(world.create_body(&def).unwrap());
        }
        (world, bodies)
    }

    /// Steps a world that rests where it may beside one that is never let rest, and says how often nothing stirred.
    fn beside(edit: impl Fn(&mut World, &[BodyId], u32), threads: u32) -> u32 {
        let [(mut world, bodies), (mut restless, twins)] = [stacks(threads), stacks(threads)];
        let mut rested = 0;
        for step in 0..400 {
            edit(&mut world, &bodies, step);
            edit(&mut restless, &twins, step);
            // A record is open to a change and has none.
            restless.set_user_word(twins[5], 0).unwrap();
            let rests = |world: &World| world.rest.still == Some(world.changes());
            assert!(!rests(&restless));
            rested += u32::from(rests(&world));
            let dt = if step % 50 < 40 { DT } else { 0.5 * DT };
            let counts = world.step(dt).unwrap().counts;
            assert_eq!(counts, restless.step(dt).unwrap().counts, "step {step}");
            let events = |world: &World| [world.moved().len(), world.contact_began().len(), world.contact_ended().len()];
            assert_eq!(events(&world), events(&restless), "step {step}");
            for (&body, &twin) in bodies.iter().zip(&twins) {
                if let (Ok(pose), Ok(other)) = (world.pose(body), restless.pose(twin)) {
                    assert_eq!(pose, other, "step {step}");
                    assert_eq!(world.linear_velocity(body).unwrap(), restless.linear_velocity(twin).unwrap(), "step {step}");
                    let forces =
                        |world: &World, body| world.contacts_of(body).unwrap().map(|contact| contact.force()).collect::<Vec<_>>();
                    assert_eq!(forces(&world, body), forces(&restless, twin), "step {step}");
                }
            }
        }
        rested
    }

    fn slippery() -> Material {
        Material { friction: 0.0, ..Material::default() }
    }

    #[test]
    fn a_world_that_rests_is_as_one_that_looks_for_everything_in_every_step() {
        for threads in [1, 2] {
            assert!(beside(|_, _, _| (), threads) > 300);
        }
    }

    #[test]
    fn whatever_is_done_to_a_world_at_rest_is_noticed() {
        let edits: [fn(&mut World, &[BodyId]); 8] = [
            |world, bodies| world.add_impulse(bodies[3], Vec3::X * 2000.0).unwrap(),
            |world, bodies| world.destroy_body(bodies[1]).unwrap(),
            |world, bodies| world.destroy_body(bodies[0]).unwrap(),
            |world, bodies| world.set_pose(bodies[0], Pose::at_xyz(0.0, -2.0, 0.0)).unwrap(),
            |world, _| world.set_gravity(Vec3::new(9.0, -9.0, 0.0)).unwrap(),
            |world, bodies| world.set_material(world.body_shapes(bodies[2]).unwrap()[0], slippery()).unwrap(),
            |world, bodies| world.put_to_sleep(bodies[4]).unwrap(),
            |world, _| {
                let ball = ShapeDef::new(Shape::ball(0.4).unwrap());
                let def = BodyDef::dynamic(Pose::at_xyz(0.1, 6.0, 0.0)).with_shape(ball);
                world.create_body(&def).map(drop).unwrap();
            },
        ];
        for (number, edit) in edits.into_iter().enumerate() {
            let rested = beside(
                |world, bodies, step| {
                    if step == 120 {
                        edit(world, bodies)
                    }
                },
                1,
            );
            assert!((60..400).contains(&rested), "edit {number}: rested for {rested} steps");
        }
    }
}
