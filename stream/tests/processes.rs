//! Processes that die, hang and come back.

mod common;

use std::process::{Child, Command};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use common::{Room, domain_name, falling_boxes, kill, peer};
use longspan_stream::{Poll, Publisher, Reader};

const DT: f32 = 1.0 / 60.0;

/// How often somebody dies: `LONGSPAN_LIVES`, or a few times, since a test must not take long.
fn lives() -> u32 {
    std::env::var("LONGSPAN_LIVES").ok().and_then(|text| text.parse().ok()).unwrap_or(12)
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// One test at a time: whoever is started by another holds, until its own program runs, all that this process has open, so that a
/// domain seems to have members when all have left.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[test]
fn readers_that_are_stopped_and_killed_leave_the_publisher_and_the_others_alone() {
    let _alone = alone();
    let room = Room::new("readers_killed");
    let mut world = falling_boxes(50);
    let mut publisher = Publisher::open(&world, &room.def("host")).unwrap();
    let mut witness = common::attach(&room, "host", std::slice::from_mut(&mut publisher));
    for life in 0..lives() {
        let child = peer(&["read", &domain_name(&room), "60"]);
        let mut publish = || {
            for _ in 0..20 {
                world.step(DT).unwrap();
                publisher.publish(&world);
                std::thread::sleep(Duration::from_millis(1));
                let poll = witness.wait(Duration::from_secs(5)).unwrap();
                assert!(matches!(poll, Poll::Frame { lost_frames: 0, lost_records: 0, .. }), "life {life}: {poll:?}");
            }
        };
        publish();
        signal(&child, "-STOP");
        publish();
        // Every other one dies as it hangs.
        if life.is_multiple_of(2) {
            signal(&child, "-CONT");
            publish();
        }
        kill(child);
    }
    assert_eq!(publisher.stats().dropped, 0);
    drop(publisher);
    common::until(&mut witness, Poll::Gone);
    drop(witness);
    assert_eq!(room.leftovers(), Vec::<String>::new());
}

#[test]
fn a_reader_that_hangs_costs_only_itself_and_catches_up() {
    let _alone = alone();
    let room = Room::new("reader_hangs");
    let mut world = falling_boxes(20);
    let mut publisher = Publisher::open(&world, &room.def("host")).unwrap();
    let mut child = peer(&["read", &domain_name(&room), "0"]);
    world.step(DT).unwrap();
    publisher.publish(&world);
    let is_there = std::thread::spawn(move || (common::line(&mut child), child));
    let deadline = Instant::now() + Duration::from_secs(30);
    while !is_there.is_finished() {
        assert!(Instant::now() < deadline, "the reader sees no frame");
        publisher.serve();
        std::thread::sleep(Duration::from_millis(1));
    }
    let (said, child) = is_there.join().unwrap();
    assert_eq!(said, "life 1");
    let mut publish = |count: u32| {
        for _ in 0..count {
            world.step(DT).unwrap();
            publisher.publish(&world);
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    publish(50);
    signal(&child, "-STOP");
    publish(400);
    signal(&child, "-CONT");
    publish(200);
    assert_eq!(publisher.stats().dropped, 0);
    drop(publisher);
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let lost: u64 = text.split(" frames, ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!(lost >= 390 && text.contains("21 bodies, complete: true"), "{text}");
}

#[test]
fn a_publisher_that_is_killed_is_found_again_and_nothing_of_it_stays() {
    let _alone = alone();
    let room = Room::new("publisher_killed");
    let mut reader = Reader::attach(&room.domain, "").unwrap();
    for life in 0..lives() {
        let child = peer(&["publish", &domain_name(&room), "pile,n=30", "60", "500"]);
        let (mut firsts, mut frames) = (0, 0);
        let deadline = Instant::now() + Duration::from_secs(10);
        while frames < 70 && Instant::now() < deadline {
            if let Poll::Frame { is_first, lost_records, .. } = reader.wait(Duration::from_millis(100)).unwrap() {
                frames += 1;
                firsts += u32::from(is_first);
                assert_eq!(lost_records, 0, "life {life}: no record is lost once the reader is there again");
            }
        }
        assert_eq!((firsts, reader.scene().is_complete(), reader.scene().bodies().len()), (1, true, 35), "life {life}");
        kill(child);
        assert_eq!(common::until(&mut reader, Poll::Gone), Poll::Gone, "life {life}");
    }
    drop(reader);
    assert_eq!(room.leftovers(), Vec::<String>::new());
}

#[test]
fn what_everybody_left_behind_is_cleared_by_whoever_comes_next() {
    let _alone = alone();
    let room = Room::new("all_killed");
    let publisher = peer(&["publish", &domain_name(&room), "pile,n=30", "60", "500"]);
    let mut reader = peer(&["read", &domain_name(&room), "60"]);
    assert_eq!(common::line(&mut reader), "life 1");
    // One that lives would clear up after the other.
    signal(&reader, "-STOP");
    kill(publisher);
    kill(reader);
    assert!(!room.leftovers().is_empty(), "somebody died with everything open");
    let mut next = Reader::attach(&room.domain, "").unwrap();
    common::until(&mut next, Poll::Gone);
    drop(next);
    assert_eq!(room.leftovers(), Vec::<String>::new());
}
