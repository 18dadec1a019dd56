//! Time of one step: bodies in contact, bodies in a column, a chain of joints, and bodies that sleep or are woken.

use criterion::{Criterion, criterion_group, criterion_main};
use longspan_scenes::{Effort, Engine, LongspanEngine, build};

/// A scene at default effort on one thread, after `steps` steps; the second value is the length of a step (s).
fn after(steps: u32, name: &str, keys: &[(&str, &str)]) -> (LongspanEngine, f32) {
    let keys: Vec<(String, String)> = keys.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    let scene = build(name, &keys).expect("the scene and its keys exist");
    let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1).expect("the scene's world is valid");
    for def in &scene.bodies {
        engine.add_body(def);
    }
    for joint in &scene.joints {
        engine.add_joint(joint);
    }
    for _ in 0..steps {
        engine.step(scene.dt);
    }
    assert!(engine.refusal().is_none(), "{name}: {:?}", engine.refusal());
    (engine, scene.dt)
}

fn step(criterion: &mut Criterion) {
    let mut measure = |name: &str, (mut engine, dt): (LongspanEngine, f32)| {
        criterion.bench_function(name, |bencher| bencher.iter(|| engine.step(dt)));
    };
    measure("settled pile of 200", after(480, "pile", &[("n", "200")]));
    measure("column of 20", after(60, "column", &[("n", "20")]));
    measure("chain of 30 links", after(60, "hanging_chain", &[("n", "30"), ("ratio", "1")]));

    let asleep = after(180, "idle", &[("what", "asleep"), ("n", "10000")]);
    let awake = asleep.0.world().awake_body_count();
    assert_eq!(awake, 0, "bodies that are awake after 3 s at rest");
    measure("10000 sleeping bodies", asleep);
}

/// Waking one box of some that sleep apart from one another, a step, and putting it to sleep again.
fn waking(criterion: &mut Criterion) {
    for count in ["1", "1000"] {
        let (mut engine, dt) = after(180, "idle", &[("what", "asleep"), ("n", count)]);
        // After the floor.
        let body = engine.body_id(1);
        criterion.bench_function(&format!("one of {count} islands woken"), |bencher| {
            bencher.iter(|| {
                let world = engine.world_mut();
                world.wake(body).expect("the box is there");
                engine.step(dt);
                engine.world_mut().put_to_sleep(body).expect("the box is there");
            });
        });
    }
}

/// Saving and restoring against a step of the same world.
fn snapshot(criterion: &mut Criterion) {
    let (mut tower, dt) = after(10, "tower", &[]);
    let mut bytes = Vec::new();
    tower.world().save(&mut bytes);
    criterion.bench_function("save a tower of 1000", |bencher| {
        let mut out = Vec::new();
        bencher.iter(|| tower.world().save(&mut out));
    });
    criterion.bench_function("restore a tower of 1000", |bencher| bencher.iter(|| tower.world_mut().restore(&bytes)));
    criterion.bench_function("step a tower of 1000", |bencher| bencher.iter(|| tower.step(dt)));
}

criterion_group!(benches, step, waking, snapshot);
criterion_main!(benches);
