//! Whatever can change a world is recorded; what is damaged does no harm.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};

use glam::Vec3;

use super::{RecordedWorld, Replay, calls};
use crate::{BodyDef, Geometry, JointDef, JointKind, Pose, Shape, ShapeDef, World, WorldDef};

/// Methods that change nothing of what a replay sees: who does the work, and who watches.
const NOT_STATE: [&str; 4] = ["set_parallel_for", "set_thread_pool", "set_profiler", "set_thread_pool"];

/// Made of calls each of which is recorded.
const COMPOSED: [&str; 1] = ["create_cells"];

/// Names of all public methods of `World` that take it to change it, from the source.
fn changing_methods() -> BTreeSet<String> {
    let mut methods = BTreeSet::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the source is there") {
            let path = entry.expect("the source can be listed").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = fs::read_to_string(&path).expect("the source is text");
            for block in text.split("\nimpl World {").skip(1).filter_map(|rest| rest.split("\n}\n").next()) {
                for rest in block.split("\n    pub fn ").skip(1) {
                    let head = rest.split('{').next().unwrap_or_default();
                    if head.contains("&mut self") {
                        methods.extend(head.split(['(', '<']).next().map(str::to_owned));
                    }
                }
            }
        }
    }
    methods
}

#[test]
fn every_method_that_changes_a_world_is_recorded() {
    let listed: BTreeSet<String> =
        (0..1000).filter_map(calls::name_of).chain(NOT_STATE).chain(COMPOSED).map(str::to_owned).collect();
    let methods = changing_methods();
    assert!(methods.len() > 40, "only {} methods were found", methods.len());
    let missing: Vec<&String> = methods.difference(&listed).collect();
    assert!(missing.is_empty(), "not in the table of src/record/calls.rs: {missing:?}");
    let gone: Vec<&String> = listed.difference(&methods).collect();
    assert!(gone.is_empty(), "listed, but no method of a world: {gone:?}");
}

#[derive(Clone, Default)]
struct Tape(Arc<Mutex<Vec<u8>>>);

impl super::RecordingSink for Tape {
    fn write(&mut self, bytes: &[u8]) -> bool {
        self.0.lock().map(|mut tape| tape.extend_from_slice(bytes)).is_ok()
    }
}

/// A short life of a world with calls of many kinds, some of them refused.
fn recorded(hash_every_call: bool) -> (Vec<u8>, u64) {
    let mut world = RecordedWorld::new(World::new(&WorldDef::default()).unwrap());
    let floor = ShapeDef::new(Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap());
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
    let tape = Tape::default();
    world.record(Box::new(tape.clone()), hash_every_call).unwrap();
    let ball = || ShapeDef::new(Shape::ball(0.3).unwrap());
    let bodies: Vec<_> = (0..6)
        .map(|i| {
            world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, 0.3 + 0.61 * f64::from(i), 0.0)).with_shape(ball())).unwrap()
        })
        .collect();
    let joint = world.create_joint(&JointDef::new(JointKind::SPHERICAL, bodies[4], bodies[5]).at(Vec3::Y * 0.3, Vec3::Y * -0.31));
    let mut saved = Vec::new();
    for step in 0..60 {
        match step {
            5 => world.add_impulse(bodies[0], Vec3::new(3.0, 0.0, 1.0)).unwrap(),
            10 => world.destroy_body(bodies[1]).unwrap(),
            11 => assert!(world.destroy_body(bodies[1]).is_err(), "it is gone"),
            12 => assert!(world.set_gravity(Vec3::NAN).is_err(), "not a number"),
            20 => world.save(&mut saved),
            25 => drop(world.attach_shape(bodies[2], &ball()).unwrap()),
            30 => world.set_joint_break(joint.unwrap(), 5.0, 5.0).unwrap(),
            40 => world.restore(&saved).unwrap(),
            _ => {}
        }
        world.step(1.0 / 60.0).unwrap();
    }
    let hash = world.state_hash();
    world.stop_recording().unwrap();
    let bytes = tape.0.lock().unwrap().clone();
    (bytes, hash)
}

#[test]
fn a_recording_plays_to_the_same_bits() {
    for hash_every_call in [false, true] {
        let (bytes, hash) = recorded(hash_every_call);
        let mut replay = Replay::new(&bytes).unwrap();
        let done = replay.run(u64::MAX).unwrap();
        assert_eq!((done.steps, done.refused, done.divergence, done.cut_short), (60, 2, None, false));
        assert_eq!(replay.world().state_hash(), hash);
        println!("{} bytes, {} calls", bytes.len(), done.calls);
    }
}

#[test]
fn the_first_call_that_differs_is_named() {
    let (mut bytes, _) = recorded(true);
    // Another impulse than the one that was given: the state after it is not what was recorded.
    let three = 3.0_f32.to_le_bytes();
    let four = 3.5_f32.to_le_bytes();
    let places: Vec<usize> =
        (0..bytes.len() - 8).filter(|&at| bytes[at + 2..at + 4] == three[2..] && bytes[at + 1] == 0).collect();
    let mut named = 0;
    for at in places {
        let before = [bytes[at + 2], bytes[at + 3]];
        bytes[at + 2..at + 4].copy_from_slice(&four[2..]);
        if let Ok(done) = Replay::new(&bytes).and_then(|mut replay| replay.run(u64::MAX))
            && let Some(divergence) = done.divergence
            && divergence.method == "add_impulse"
        {
            assert!(divergence.in_state && divergence.step == 5 && divergence.recorded != divergence.found, "{divergence:?}");
            named += 1;
        }
        bytes[at + 2..at + 4].copy_from_slice(&before);
    }
    assert_eq!(named, 1, "the impulse that was changed is found");
}

#[test]
fn a_damaged_recording_is_refused_or_found_to_differ() {
    let (good, _) = recorded(false);
    assert!(Replay::new(&good[..20]).is_err());
    let mut foreign = good.clone();
    foreign[17] ^= 1;
    assert!(Replay::new(&foreign).is_err());
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    let seed = u64::from_le_bytes(std::array::from_fn(|i| good[24 + i])) as usize + super::HEADER;
    let (mut refused, mut differs, mut cut) = (0, 0, 0);
    for _ in 0..300 {
        let mut damaged = good.clone();
        damaged[seed + random(good.len() - seed)] ^= 1 << random(8);
        match Replay::new(&damaged).and_then(|mut replay| replay.run(100)) {
            Err(_) => refused += 1,
            Ok(done) => {
                differs += usize::from(done.divergence.is_some());
                cut += usize::from(done.cut_short);
            }
        }
    }
    println!("of 300 damaged recordings {refused} were refused, {differs} differed, {cut} ended early");
    assert!(refused + differs + cut > 250);
    let done = Replay::new(&good[..good.len() - 3]).and_then(|mut replay| replay.run(u64::MAX)).unwrap();
    assert!(done.cut_short && done.divergence.is_none() && done.steps == 60, "{done:?}");
}
