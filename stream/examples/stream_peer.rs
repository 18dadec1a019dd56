//! One side of a stream as a process of its own: for tests that kill it, and to measure.
//!
//! ```text
//! stream_peer publish DOMAIN BODIES SECONDS RATE    steps a pile of boxes, RATE times a second (0: as fast as it can), with a stream
//! stream_peer step    DOMAIN BODIES SECONDS RATE    the same without one, for comparison
//! stream_peer read    DOMAIN SECONDS                reads each newest frame, and says what was lost and how old frames were
//! ```

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use longspan::glam::Vec3;
use longspan::{BodyDef, Pose, Shape, ShapeDef, World, WorldDef};
use longspan_stream::{Domain, Poll, Publisher, PublisherDef, Reader};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |index: usize| words.get(index).and_then(|word| word.parse::<f64>().ok()).unwrap_or(1.0);
    let domain = Domain::named(words.get(1).map_or("", String::as_str)).expect("a name for a domain");
    match words.first().map(String::as_str) {
        Some("publish") => step(number(2) as usize, number(3), number(4), Some(&domain)),
        Some("step") => step(number(2) as usize, number(3), number(4), None),
        Some("read") => read(&domain, number(2)),
        _ => eprintln!("publish DOMAIN BODIES SECONDS RATE, step DOMAIN BODIES SECONDS RATE, or read DOMAIN SECONDS"),
    }
}

/// Boxes in loose layers that go on moving for a while, on a floor.
fn pile(count: usize) -> World {
    let mut world = World::new(&WorldDef { body_capacity: count as u32 + 1, ..WorldDef::default() }).expect("a world");
    let floor = Shape::cuboid(Vec3::new(200.0, 0.5, 200.0)).expect("a box");
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(ShapeDef::new(floor))).expect("a floor");
    let shape = Shape::cuboid(Vec3::new(0.25, 0.2, 0.22)).expect("a box");
    let side = (count as f64 / 4.0).sqrt().ceil() as usize;
    for index in 0..count {
        let (x, z, y) = (index % side, index / side % side, index / (side * side));
        let shift = 0.07 * ((index * 7919 % 13) as f64 - 6.0) / 6.0;
        let pose = Pose::at_xyz(0.66 * x as f64 + shift, 0.5 + 0.66 * y as f64, 0.66 * z as f64 - shift);
        world.create_body(&BodyDef::dynamic(pose).with_shape(ShapeDef::new(shape.clone()))).expect("a body");
    }
    world
}

fn step(count: usize, seconds: f64, rate: f64, domain: Option<&Domain>) {
    let mut world = pile(count);
    let def = domain.map(|domain| PublisherDef { domain: domain.clone(), name: "peer".into(), ..PublisherDef::default() });
    let mut publisher = def.map(|def| Publisher::open(&world, &def).expect("a stream"));
    println!("ready");
    let (mut whole, mut publishing) = (Vec::new(), Vec::new());
    let start = Instant::now();
    while start.elapsed().as_secs_f64() < seconds {
        let begin = Instant::now();
        world.step(1.0 / 60.0).expect("a step");
        if let Some(publisher) = &mut publisher {
            publisher.publish(&world);
            publishing.push(1e6 * publisher.stats().seconds);
        }
        whole.push(1e6 * begin.elapsed().as_secs_f64());
        if rate > 0.0 {
            let due = start + Duration::from_secs_f64(whole.len() as f64 / rate);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        // A pile that has come to rest is thrown up again.
        if world.awake_body_count() == 0 {
            let bodies: Vec<_> = world.bodies().skip(1).collect();
            bodies.into_iter().for_each(|body| world.set_linear_velocity(body, Vec3::Y).expect("a body"));
        }
    }
    let dropped = publisher.map_or(0, |publisher| publisher.stats().dropped);
    println!("{} steps, {dropped} dropped", whole.len());
    print_times("step with publication", &mut whole);
    print_times("publication", &mut publishing);
}

fn read(domain: &Domain, seconds: f64) {
    let mut reader = Reader::attach(domain, "").expect("a reader");
    println!("ready");
    let (mut ages, mut frames, mut lost, mut records, mut lives, mut problems) = (Vec::new(), 0, 0, 0, 0, 0);
    let start = Instant::now();
    while start.elapsed().as_secs_f64() < seconds {
        match reader.wait(Duration::from_millis(50)) {
            Ok(Poll::Frame { lost_frames, lost_records, is_first }) => {
                let clock = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64);
                // What waited for a reader that was not there yet is old for another reason.
                if is_first {
                    lives += 1;
                } else {
                    ages.push(clock.saturating_sub(reader.scene().frame().clock) as f64 / 1e3);
                }
                (frames, lost, records) = (frames + 1, lost + lost_frames, records + lost_records);
            }
            Ok(_) => {}
            Err(problem) => {
                problems += 1;
                eprintln!("{problem}");
            }
        }
    }
    let bodies = reader.scene().bodies().len();
    let complete = reader.scene().is_complete();
    println!("{frames} frames, {lost} lost, {records} records lost, {lives} lives, {problems} problems");
    println!("{bodies} bodies, complete: {complete}");
    print_times("age of a frame when it has been taken in", &mut ages);
}

fn print_times(what: &str, microseconds: &mut [f64]) {
    microseconds.sort_by(f64::total_cmp);
    if let Some(last) = microseconds.len().checked_sub(1) {
        let at = |share: f64| microseconds[(share * last as f64).round() as usize];
        let mean = microseconds.iter().sum::<f64>() / microseconds.len() as f64;
        let [p50, p90, p99, max] = [0.5, 0.9, 0.99, 1.0].map(at);
        println!("{what}: mean {mean:.1} us, p50 {p50:.1}, p90 {p90:.1}, p99 {p99:.1}, max {max:.1}");
    }
}
