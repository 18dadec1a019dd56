//! A world that was saved and restored goes on as if nothing had been: the same bits, step for step.

use crate::common;
use std::collections::BTreeMap;
use std::time::Instant;

use longspan::glam::Vec3;
use longspan::{
    BodyDef, BodyId, BodyKind, CollisionFilter, ErrorKind, Handle, JointDef, JointId, JointKind, Mass, Material, Pose, Shape,
    ShapeDef, SleepSettings, World, WorldDef,
};
use longspan_scenes::{Action, Random, Scene};

/// A scene on a world of its own, stepped with its script.
struct Play {
    scene: Scene,
    world: World,
    bodies: Vec<BodyId>,
    step: u32,
    dt: f32,
}

/// Latest step of a script's first actions.
const SOON: u32 = 20;

/// Where a play was when it was saved: what a host keeps beside the snapshot.
#[derive(Clone)]
struct Saved {
    bytes: Vec<u8>,
    bodies: Vec<BodyId>,
    step: u32,
    dt: f32,
}

impl Play {
    fn new(mut scene: Scene, threads: u32, sleep: bool) -> Self {
        // What the script does after a long wait, it does soon.
        scene.script.iter_mut().for_each(|scheduled| scheduled.step = scheduled.step.min(SOON));
        let sleep = SleepSettings { enabled: sleep, ..scene.world.sleep };
        let mut world = World::new(&WorldDef { threads, sleep, ..scene.world }).unwrap();
        let bodies: Vec<BodyId> = scene.bodies.iter().map(|def| world.create_body(def).unwrap()).collect();
        for joint in &scene.joints {
            let id_of = |side: Option<usize>| side.map_or(BodyId::NULL, |body| bodies[body]);
            world.create_joint(&JointDef { body_a: id_of(joint.a), body_b: id_of(joint.b), ..joint.def }).unwrap();
        }
        let dt = scene.dt;
        Self { scene, world, bodies, step: 0, dt }
    }

    fn advance(&mut self) {
        for scheduled in self.scene.script.iter().filter(|scheduled| scheduled.step == self.step) {
            match &scheduled.action {
                Action::Add(def) => self.bodies.push(self.world.create_body(def).unwrap()),
                Action::Remove(body) => self.world.destroy_body(self.bodies[*body]).unwrap(),
                Action::SetLinearVelocity(body, velocity) => {
                    self.world.set_linear_velocity(self.bodies[*body], *velocity).unwrap();
                }
                Action::Push(body, impulse) => self.world.add_impulse(self.bodies[*body], *impulse).unwrap(),
                &Action::PushTo { body, along, speed, most } => {
                    let mass = self.world.mass_properties(self.bodies[body]).unwrap().map_or(0.0, |mass| mass.mass);
                    let missing = mass * (speed - self.world.linear_velocity(self.bodies[body]).unwrap().dot(along));
                    self.world.add_impulse(self.bodies[body], along * missing.clamp(-most * self.dt, most * self.dt)).unwrap();
                }
                Action::SetStep(dt) => self.dt = *dt,
                Action::SetGravity(gravity) => self.world.set_gravity(*gravity).unwrap(),
            }
        }
        self.world.step(self.dt).unwrap();
        self.step += 1;
    }

    fn save(&self) -> Saved {
        let mut bytes = Vec::new();
        self.world.save(&mut bytes);
        Saved { bytes, bodies: self.bodies.clone(), step: self.step, dt: self.dt }
    }

    fn restore(&mut self, saved: &Saved) {
        self.world.restore(&saved.bytes).unwrap();
        (self.step, self.dt) = (saved.step, saved.dt);
        // A handle's highest ten bits are the number of its world.
        const OBJECT: u64 = (1 << 54) - 1;
        let number = self.world.bodies().next().map_or(0, |body| body.to_bits() & !OBJECT);
        self.bodies = saved.bodies.iter().map(|body| BodyId::from_bits(number | (body.to_bits() & OBJECT))).collect();
    }

    /// Has a world that knows nothing of the scene: what is not in a snapshot cannot be at hand by chance.
    fn forget_world(&mut self) {
        self.world = World::new(&WorldDef { threads: self.world.def().threads, ..WorldDef::default() }).unwrap();
    }
}

fn bytes_of(world: &World) -> Vec<u8> {
    let mut bytes = Vec::new();
    world.save(&mut bytes);
    bytes
}

/// Restores of a scene: LONGSPAN_RESTORES=n does others as often, for a search of minutes.
fn restores(usual: u32) -> u32 {
    std::env::var("LONGSPAN_RESTORES").ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// Plays a scene through, saving as it goes, then jumps back to random points, up to 25 steps before a random one, and compares
/// every step with that of the first time: the hash of the state, and at the end of each stretch the whole snapshot.
fn rolls_back(name: &str, keys: &[(&str, &str)], steps: u32, jumps: u32, threads: u32) {
    let jumps = restores(jumps);
    let mut play = Play::new(common::scene(name, keys), threads, true);
    let (mut saved, mut hashes) = (BTreeMap::from([(0, play.save())]), vec![play.world.state_hash()]);
    while play.step < steps {
        play.advance();
        hashes.push(play.world.state_hash());
        saved.insert(play.step, play.save());
    }
    let asleep = play.world.report().counts.bodies_asleep;
    let mut random = Random::new(11);
    let mut compared = 0_u32;
    for jump in 0..jumps {
        let from = random.index(steps as usize) as u32;
        if jump % 2 == 0 {
            play.forget_world();
        }
        play.restore(&saved[&from]);
        assert!(bytes_of(&play.world) == saved[&from].bytes, "{name}: what is saved after a restore is what was restored");
        let to = (from + 1 + random.index(25) as u32).min(steps);
        while play.step < to {
            play.advance();
            let hash = play.world.state_hash();
            assert!(hash == hashes[play.step as usize], "{name}: restored at step {from}, another world at step {}", play.step);
            compared += 1;
        }
        assert!(bytes_of(&play.world) == saved[&to].bytes, "{name}: restored at step {from}, another snapshot at step {to}");
    }
    let bodies = play.world.body_count();
    let largest = saved.values().map(|saved| saved.bytes.len()).max().unwrap_or(0);
    println!(
        "{name} {keys:?}: {jumps} jumps, {compared} steps compared, {bodies} bodies, {asleep} asleep, {largest} bytes at most"
    );
    assert!(compared > jumps * 5);
}

#[test]
fn a_falling_tower_rolls_back_to_any_step() {
    rolls_back("tower", &[("bodies", "200")], 120, 400, 1);
}

#[test]
fn a_vase_that_is_hit_rolls_back_to_any_step() {
    rolls_back("vase", &[], 60, 300, 1);
}

#[test]
fn a_sheet_rolls_back_to_any_step() {
    rolls_back("joint_grid", &[("n", "22"), ("solver", "gs")], 60, 60, 1);
    // Too much work for the direct solve, which remembers that.
    rolls_back("joint_grid", &[("n", "50")], 60, 20, 1);
}

#[test]
fn a_rope_bridge_rolls_back_to_any_step() {
    rolls_back("rope_bridge", &[("planks", "24")], 90, 120, 1);
}

#[test]
fn a_bridge_that_loads_fall_on_rolls_back_to_any_step() {
    rolls_back("footbridge", &[("drop", "0.3"), ("boxes", "3")], 90, 50, 1);
}

#[test]
fn long_range_bounds_roll_back_with_what_they_carry() {
    for name in ["hanging_chain", "rope_bridge", "swinging_weight"] {
        rolls_back(name, &[("solver", "gs")], 60, 50, 1);
    }
}

#[test]
fn what_breaks_rolls_back_to_any_step() {
    rolls_back("vase", &[("break", "1000000")], 100, 200, 1);
}

#[test]
fn ragdolls_whose_contacts_are_swept_for_a_while_roll_back_to_any_step() {
    rolls_back("ragdoll_rain", &[("n", "3")], 120, 100, 1);
}

#[test]
fn a_machine_that_has_come_to_move_smoothly_rolls_back_to_any_step() {
    rolls_back("excavator", &[], 60, 100, 1);
}

#[test]
fn a_pile_that_falls_asleep_rolls_back_to_any_step() {
    rolls_back("pile", &[("n", "150")], 300, 300, 1);
    rolls_back("resting", &[], 120, 200, 1);
}

#[test]
fn every_kind_of_joint_rolls_back_to_any_step() {
    rolls_back("free_cluster", &[], 120, 100, 1);
    for name in ["hinge_motor", "hinge_servo", "hinge_limit", "stiff_hinge", "spring", "swinging_weight", "cable_car"] {
        rolls_back(name, &[], 60, 50, 1);
    }
}

#[test]
fn bodies_that_come_and_go_fast_or_driven_roll_back_to_any_step() {
    rolls_back("brick_wall", &[], 60, 50, 1);
    for name in ["platform", "bullet", "card_house", "bounce", "locked_axes", "half_sunk"] {
        rolls_back(name, &[], 90, 50, 1);
    }
}

#[test]
fn the_number_of_threads_does_not_matter_to_a_rollback() {
    let single = Play::new(common::scene("pile", &[("n", "300")]), 1, true);
    let mut threaded = Play::new(common::scene("pile", &[("n", "300")]), 4, true);
    let (mut first, mut saved) = (single, None);
    for step in 0..100 {
        first.advance();
        if step == 60 {
            saved = Some(first.save());
        }
    }
    threaded.restore(&saved.expect("saved on the way"));
    while threaded.step < 100 {
        threaded.advance();
    }
    assert_eq!(threaded.world.state_hash(), first.world.state_hash());
}

#[test]
fn what_is_supported_is_known_after_a_restore_and_moves_nothing() {
    let mut play = Play::new(common::scene("tower", &[("bodies", "100")]), 1, true);
    play.world.set_support(true);
    (0..15).for_each(|_| play.advance());
    let saved = play.save();
    let supported = |world: &World| {
        world.bodies().filter(|&body| world.support(body).is_ok_and(|support| support.verdict.is_supported())).count()
    };
    let (before, mut hashes) = (supported(&play.world), Vec::new());
    for _ in 0..10 {
        play.advance();
        hashes.push(play.world.state_hash());
    }
    play.forget_world();
    play.restore(&saved);
    let after = supported(&play.world);
    println!("{before} bodies were supported, {after} are after a restore");
    assert!(before > 50 && after == before, "{before} bodies were supported, {after} are after a restore");
    for hash in hashes {
        play.advance();
        assert_eq!(play.world.state_hash(), hash);
    }
}

#[test]
fn another_world_goes_on_where_the_first_was_saved() {
    let scenes = [
        ("tower", vec![("bodies", "100")]),
        ("rope_bridge", vec![("planks", "24")]),
        ("free_cluster", vec![]),
        ("hinge_loop", vec![]),
    ];
    for (name, keys) in scenes {
        let mut first = Play::new(common::scene(name, &keys), 1, true);
        first.scene.script.clear();
        (0..40).for_each(|_| first.advance());
        let saved = first.save();
        let mut other = World::new(&WorldDef::default()).unwrap();
        other.restore(&saved.bytes).unwrap();
        assert!(bytes_of(&other) == saved.bytes, "{name}: the bytes do not depend on the world");
        for (ours, theirs) in first.world.bodies().zip(other.bodies()) {
            assert_eq!(first.world.pose(ours).unwrap(), other.pose(theirs).unwrap());
            assert_ne!(ours, theirs, "a handle belongs to one world");
        }
        for step in 0..30 {
            first.advance();
            other.step(first.dt).unwrap();
            assert_eq!(first.world.state_hash(), other.state_hash(), "{name}, {step} steps later");
        }
    }
}

/// Does something to a world that a host may do at any time.
fn edit(world: &mut World, random: &mut Random) {
    let bodies: Vec<BodyId> = world.bodies().filter(|&body| world.body_kind(body) == Ok(BodyKind::Dynamic)).collect();
    let joints: Vec<JointId> = world.joints().collect();
    let body = bodies[random.index(bodies.len())];
    let shape = world.body_shapes(body).unwrap()[0];
    let solid = ShapeDef::new(Shape::cuboid(Vec3::splat(0.2)).unwrap());
    let place = Pose::at((random.vector(3.0) + Vec3::Y * 3.5).as_dvec3());
    match random.index(12) {
        0 => world.set_mass(body, Mass::Total(3.0)).unwrap(),
        1 => world.set_pose(body, place).unwrap(),
        2 => world.wake(body).unwrap(),
        10 => world.put_to_sleep(body).unwrap(),
        3 => world.destroy_body(body).unwrap(),
        4 | 5 => drop(world.create_body(&BodyDef::dynamic(place).with_shape(solid)).unwrap()),
        6 => world.set_material(shape, Material { friction: 0.2, ..Material::default() }).unwrap(),
        7 => world.set_filter(shape, CollisionFilter { member_of: 2, collides_with: u32::MAX }).unwrap(),
        8 => world.set_shape_def(shape, &solid).unwrap(),
        9 => {
            let other = bodies[random.index(bodies.len())];
            let _ = world.create_joint(&JointDef::new(JointKind::SPHERICAL, body, other).at(Vec3::X * 0.4, Vec3::X * -0.4));
        }
        _ => joints.first().into_iter().for_each(|&joint| world.destroy_joint(joint).unwrap()),
    }
}

#[test]
fn a_world_that_is_saved_amid_edits_goes_on_the_same() {
    let mut play = Play::new(common::scene("pile", &[("n", "120")]), 1, true);
    let mut other = World::new(&WorldDef::default()).unwrap();
    let mut random = Random::new(3);
    (0..120).for_each(|_| play.advance());
    for round in 0..150 {
        for _ in 0..1 + random.index(30) {
            edit(&mut play.world, &mut random);
        }
        let contacts = |world: &World| -> (usize, usize) {
            let of_bodies = world.bodies().map(|body| world.contacts_of(body).unwrap().count()).sum();
            (world.contacts().count(), of_bodies)
        };
        let before = bytes_of(&play.world);
        other.restore(&before).unwrap();
        assert_eq!(contacts(&play.world), contacts(&other), "round {round}");
        for step in 0..4 {
            play.world.step(play.dt).unwrap();
            other.step(play.dt).unwrap();
            assert_eq!(play.world.state_hash(), other.state_hash(), "round {round}, step {step}");
        }
        assert!(bytes_of(&play.world) == bytes_of(&other), "round {round}: the same hash, other bytes");
    }
    println!("{} bodies, {} joints at the end", play.world.body_count(), play.world.joints().count());
}

/// An edit that stops what was moving.
type Stop = fn(&mut World, BodyId);

/// A body that an edit stops is looked at no more in the next step: how far it had come in the last one must make no difference, as a
/// restored world does not know it.
#[test]
fn what_an_edit_stops_after_a_restore_goes_on_the_same() {
    let stops: [(&str, BodyKind, Stop); 4] = [
        ("put to sleep", BodyKind::Dynamic, |world, body| world.put_to_sleep(body).unwrap()),
        ("stopped", BodyKind::Kinematic, |world, body| world.set_linear_velocity(body, Vec3::ZERO).unwrap()),
        ("fixed to the world", BodyKind::Dynamic, |world, body| {
            let frame_a = world.pose(body).unwrap();
            world.create_joint(&JointDef { frame_a, ..JointDef::new(JointKind::Fixed, BodyId::NULL, body) }).map(drop).unwrap();
        }),
        ("made static", BodyKind::Dynamic, |world, body| world.set_body_kind(body, BodyKind::Static).unwrap()),
    ];
    for (what, kind, stop) in stops {
        let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
        let mut random = Random::new(7);
        let bodies: Vec<BodyId> = (0..60)
            .map(|i| {
                let pose = Pose::at(random.vector(3.0).as_dvec3());
                let shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.3)).unwrap());
                let linear_velocity = random.vector(60.0);
                let kind = if i % 3 == 0 { kind } else { BodyKind::Dynamic };
                world.create_body(&BodyDef { kind, linear_velocity, ..BodyDef::dynamic(pose).with_shape(shape) }).unwrap()
            })
            .collect();
        for step in 0..10 {
            world.step(1.0 / 60.0).unwrap();
            let saved = bytes_of(&world);
            let [first, twin] = [0, 1].map(|run| {
                if run == 1 {
                    world.restore(&saved).unwrap();
                }
                stop(&mut world, bodies[3 * step]);
                world.step(1.0 / 60.0).unwrap();
                (world.state_hash(), world.contacts().map(|contact| format!("{contact:?}")).collect::<Vec<_>>())
            });
            assert_eq!(first.0, twin.0, "a body {what} in step {step}: the twin moves otherwise");
            assert_eq!(first.1, twin.1, "a body {what} in step {step}: the twin has other contacts");
        }
    }
}

#[test]
fn handles_live_and_die_with_the_state_that_they_belong_to() {
    let mut play = Play::new(common::scene("pile", &[("n", "300")]), 1, true);
    (0..5).for_each(|_| play.advance());
    let doomed = play.bodies[3];
    let saved = play.save();
    play.world.destroy_body(doomed).unwrap();
    let def = longspan::BodyDef::dynamic(longspan::Pose::at_xyz(0.0, 90.0, 0.0));
    let ball = longspan::ShapeDef::new(longspan::Shape::ball(0.3).unwrap());
    let late = play.world.create_body(&def.with_shape(ball)).unwrap();
    assert_eq!(play.world.pose(doomed).unwrap_err().kind, ErrorKind::StaleHandle);
    play.restore(&saved);
    assert!(play.world.pose(doomed).is_ok(), "what lived then lives again");
    assert!(play.world.pose(late).is_err(), "what did not exist then is gone");
}

#[test]
fn what_is_not_a_whole_snapshot_of_this_version_is_refused_and_changes_nothing() {
    let mut play = Play::new(common::scene("pile", &[("n", "300")]), 1, true);
    (0..30).for_each(|_| play.advance());
    let good = play.save().bytes;
    (0..3).for_each(|_| play.advance());
    let before = bytes_of(&play.world);
    let mut refuse = |bytes: &[u8], what: &str| {
        let error = play.world.restore(bytes).expect_err(what);
        assert_eq!((error.kind, error.argument), (ErrorKind::InvalidSnapshot, "snapshot"), "{what}");
        assert!(bytes_of(&play.world) == before, "{what}: the world has changed");
        error.problem
    };
    assert_eq!(refuse(&[], "nothing"), "is not a snapshot");
    assert_eq!(refuse(b"something else altogether, long enough to have a header", "a text"), "is not a snapshot");
    for length in [1, 39, 40, good.len() / 2, good.len() - 1] {
        refuse(&good[..length], "cut short");
    }
    let mut longer = good.clone();
    longer.push(0);
    assert_eq!(refuse(&longer, "too long"), "is cut short or too long");
    let mut foreign = good.clone();
    foreign[8] += 1;
    assert_eq!(refuse(&foreign, "another format"), "was made by another version of the library");
    foreign = good.clone();
    foreign[17] ^= 1;
    assert_eq!(refuse(&foreign, "another form"), "was made by another version of the library");
    let mut random = Random::new(5);
    for _ in 0..500 {
        let mut corrupted = good.clone();
        corrupted[40 + random.index(good.len() - 40)] ^= 1 << random.index(8);
        assert_eq!(refuse(&corrupted, "a bit turned"), "is corrupted");
    }
    assert!(play.world.restore(&good).is_ok());
}

#[test]
fn a_snapshot_is_small() {
    for (name, keys, step) in [("tower", vec![], 15), ("tower", vec![], 60), ("pile", vec![], 200), ("column", vec![], 60)] {
        let mut play = Play::new(common::scene(name, &keys), 1, true);
        (0..step).for_each(|_| play.advance());
        let (bodies, bytes) = (play.world.body_count(), bytes_of(&play.world).len());
        let points: usize = play.world.contacts().map(|contact| contact.points().len()).sum();
        let pairs = play.world.report().counts.pairs as usize;
        let clock = Instant::now();
        let saved = play.save();
        let saving = clock.elapsed();
        play.world.restore(&saved.bytes).unwrap();
        let restoring = clock.elapsed() - saving;
        play.advance();
        let stepping = clock.elapsed() - saving - restoring;
        println!("{name}: {bytes} bytes, {bodies} bodies, {pairs} pairs, {points} points");
        println!("    saved in {saving:?}, restored in {restoring:?}, stepped in {stepping:?}");
        // A pile has two pairs for each point, or fewer, as its blocks happen to fall; what still moves has 28 bytes for the pose that a pair was
        // made for.
        let most = 155 * bodies + 64 * points + 10 * pairs;
        assert!(bytes <= most, "{name}: {bytes} bytes for {bodies} bodies, {points} points and {pairs} pairs");
    }
}
