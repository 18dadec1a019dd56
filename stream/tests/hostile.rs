//! A publisher that means harm, and memory that is damaged: a reader says so, and goes on.
//!
//! `LONGSPAN_FUZZ_SECONDS` says for how long; two seconds each unless it is set.

mod common;

use std::fs::OpenOptions;
use std::os::unix::fs::FileExt;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use common::{Room, falling_boxes};
use longspan_stream::schema::{ContentHash, LsStreamHeader};
use longspan_stream::{Message, Poll, Problem, Publisher, Reader, Scene};

const DT: f32 = 1.0 / 60.0;
const HEADER: usize = size_of::<LsStreamHeader>();

fn duration() -> Duration {
    let seconds = std::env::var("LONGSPAN_FUZZ_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(2.0);
    Duration::from_secs_f64(seconds)
}

/// xorshift64*.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// All messages of a recording, as a publisher wrote them.
fn messages(test: &str) -> Vec<Vec<u8>> {
    let room = Room::new(test);
    let mut world = falling_boxes(20);
    let def = longspan_stream::PublisherDef { layers: 31, ..room.def("hostile") };
    let mut publisher = Publisher::open(&world, &def).unwrap();
    let mut reader = common::attach(&room, "hostile", std::slice::from_mut(&mut publisher));
    let file = std::env::temp_dir().join(format!("longspan-{test}-{}", std::process::id()));
    reader.record(Some(&file)).unwrap();
    for _ in 0..20 {
        world.step(DT).unwrap();
        publisher.publish(&world);
        reader.wait(Duration::from_secs(5)).unwrap();
    }
    reader.record(None).unwrap();
    let bytes = std::fs::read(&file).unwrap();
    std::fs::remove_file(&file).unwrap();
    // A chunk: 64 bytes of the file's header, 64 of the chunk's, then messages, packed.
    let stored = u64::from_le_bytes(bytes[72..80].try_into().unwrap()) as usize;
    let length = u64::from_le_bytes(bytes[80..88].try_into().unwrap()) as usize;
    let mut rest = lz4_flex::block::decompress(&bytes[128..128 + stored], length).unwrap();
    let mut all = Vec::new();
    while rest.len() >= HEADER {
        let size = u64::from_le_bytes(rest[24..32].try_into().unwrap()) as usize;
        let after = rest.split_off(size);
        all.push(std::mem::replace(&mut rest, after));
    }
    all
}

/// Makes a message say of itself that it is whole.
fn seal(message: &mut [u8]) {
    let mut hash = ContentHash::default();
    hash.add(&message[HEADER..]);
    let length = message.len() as u64;
    message[24..32].copy_from_slice(&length.to_le_bytes());
    message[72..80].copy_from_slice(&hash.finish().to_le_bytes());
}

#[test]
fn whatever_a_publisher_says_is_taken_in_or_refused() {
    let good = messages("hostile_messages");
    assert!(good.iter().all(|message| Message::check(message).is_ok()), "the messages that harm is done to are whole");
    let (mut random, mut scene) = (Random(4711), Scene::default());
    let (mut taken, mut refused) = (0_u64, 0_u64);
    let end = Instant::now() + duration();
    while Instant::now() < end {
        let mut message = good[random.below(good.len())].clone();
        for _ in 0..=random.below(6) {
            let place = random.below(message.len());
            match random.below(5) {
                0 => message[place] ^= 1 << random.below(8),
                1 => message[place] = [0, 1, 0x7F, 0x80, 0xFF][random.below(5)],
                // Counts, lengths and strides stand in whole words.
                2 if place + 8 <= message.len() => {
                    let wild = [0, 1, u64::MAX, u64::from(u32::MAX), 1 << 31, random.next()][random.below(6)];
                    message[place & !7..][..8].copy_from_slice(&wild.to_le_bytes());
                }
                3 if message.len() > HEADER => message.truncate(HEADER + (random.below(message.len() - HEADER) & !7)),
                _ => {
                    let other = &good[random.below(good.len())];
                    let (from, count) = (random.below(other.len()) & !7, 8 * random.below(32));
                    let piece = &other[from..other.len().min(from + count)];
                    let at = ((HEADER + random.below(message.len().saturating_sub(HEADER))) & !7).min(message.len());
                    message.splice(at..at, piece.iter().copied());
                }
            }
        }
        if message.len().is_multiple_of(8) && message.len() >= HEADER && random.below(8) > 0 {
            seal(&mut message);
        }
        match Message::check(&message).and_then(|message| scene.apply(&message)) {
            Ok(()) => taken += 1,
            Err(_) => refused += 1,
        }
        let finite = scene.bodies().all(|body| body.position.iter().all(|x| x.is_finite()));
        assert!(finite, "a body is nowhere");
        if taken % 512 == 0 {
            scene.forget_events();
        }
    }
    println!("{taken} messages taken in, {refused} refused");
    assert!(taken > 100 && refused > 100, "{taken} taken in, {refused} refused: the harm is of one kind only");
}

/// The segments that hold messages, as files.
fn segments(room: &Room) -> Vec<std::fs::File> {
    let of_messages = |name: &str| name.starts_with(&room.domain.prefix()) && name.ends_with(".data") && !name.contains("mgmt");
    let files = std::fs::read_dir("/dev/shm").unwrap().flatten();
    let files = files.filter(|entry| of_messages(&entry.file_name().to_string_lossy()));
    files.filter_map(|entry| OpenOptions::new().read(true).write(true).open(entry.path()).ok()).collect()
}

/// Has a process stand still (`STOP`), or go on (`CONT`).
fn signal(process: &Child, name: &str) {
    let sent = Command::new("kill").args(["-s", name, &process.id().to_string()]).status().unwrap();
    assert!(sent.success(), "kill -s {name}: {sent}");
}

#[test]
fn damaged_shared_memory_is_noticed_and_outlived() {
    let room = Room::new("hostile_memory");
    let words = ["publish", &common::domain_name(&room), "pile,n=30", "10000", "1000"];
    let mut publisher = common::peer(&words);
    let mut reader = Reader::attach(&room.domain, "").unwrap();
    let mut random = Random(99);
    let (mut frames, mut noticed, mut deaths) = (0_u64, 0_u64, 0_u64);
    let end = Instant::now() + duration();
    while Instant::now() < end {
        std::thread::sleep(Duration::from_millis(3));
        // What waits for the reader stays damaged only while nobody writes over it.
        signal(&publisher, "STOP");
        for segment in segments(&room) {
            let length = segment.metadata().map_or(0, |data| data.len());
            // The front of a segment is the publisher's own list of what is free: it does not outlive damage there, readers do.
            let front = if random.below(200) == 0 { 0 } else { 4096 };
            for _ in 0..random.below(400) {
                let place = front + random.next() % length.saturating_sub(front + 8).clamp(1, 256 * 1024);
                let _ = segment.write_all_at(&random.next().to_le_bytes()[..1 + random.below(8)], place);
            }
        }
        for _ in 0..4 {
            match reader.poll() {
                Ok(Poll::Frame { .. }) => frames += 1,
                Ok(_) => {}
                Err(Problem::Corrupt(_) | Problem::Incompatible(_)) => noticed += 1,
                // What the reader opened was gone or nonsense a moment later.
                Err(Problem::System(_)) => noticed += 1,
                Err(problem) => panic!("{problem}"),
            }
            let finite = reader.scene().bodies().all(|body| body.position.iter().all(|x| x.is_finite()));
            assert!(finite, "a body is nowhere");
        }
        signal(&publisher, "CONT");
        if publisher.try_wait().unwrap().is_some() {
            deaths += 1;
            publisher = common::peer(&words);
        }
    }
    common::kill(publisher);
    println!("{frames} frames taken in, {noticed} messages refused, {deaths} publishers did not live through it");
    assert!(frames > 10 && noticed > 10, "{frames} frames, {noticed} refused");
}

#[test]
fn a_stream_of_another_schema_is_told_from_none() {
    let mut bytes = messages("hostile_schema").swap_remove(0);
    bytes[8] = 2;
    let Err(Problem::Incompatible(what)) = Message::check(&bytes) else { panic!("it is taken for one of this schema") };
    assert!(what.contains("schema 2") && what.contains("reads 1"), "{what}");
}

#[test]
fn a_reader_that_finds_only_a_stream_of_another_schema_says_so() {
    let room = Room::new("future");
    let other = common::peer(&["future", &common::domain_name(&room), "60"]);
    let mut reader = Reader::attach(&room.domain, "future").unwrap();
    let Err(Problem::Incompatible(what)) = reader.poll() else { panic!("it is read, or not found") };
    assert_eq!(what, "a stream of this name has schema 2, this library reads 1");
    assert_eq!(room.domain.sources().unwrap().iter().map(|source| source.schema).collect::<Vec<_>>(), [2]);
    // One of this schema beside it is read all the same.
    let world = falling_boxes(3);
    let publisher = Publisher::open(&world, &room.def("future")).unwrap();
    assert_eq!(common::until(&mut reader, Poll::Nothing), Poll::Nothing);
    assert_eq!(reader.source(), Some(publisher.source()));
    drop(reader);
    common::kill(other);
}
