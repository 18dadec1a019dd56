//! Recordings: what was seen live is seen again; what is damaged is left out, and that is said.

mod common;

use std::path::PathBuf;
use std::time::Duration;

use common::{Room, falling_boxes};
use longspan_stream::{End, Poll, Problem, Publisher, Reader};

const DT: f32 = 1.0 / 60.0;

struct File(PathBuf);

impl File {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("longspan-{name}-{}", std::process::id())))
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Records a world while it runs; returns the step and hash of each frame as the live reader saw it.
fn record(name: &str, steps: u32) -> (File, Vec<(u64, u64)>) {
    let (room, file) = (Room::new(name), File::new(name));
    let mut world = falling_boxes(40);
    let mut publisher = Publisher::open(&world, &room.def(name)).unwrap();
    let mut reader = common::attach(&room, name, std::slice::from_mut(&mut publisher));
    reader.record(Some(&file.0)).unwrap();
    let mut seen = Vec::new();
    for step in 0..steps {
        // A body goes and one comes now and then.
        if step % 50 == 20 {
            let last = world.bodies().last().unwrap();
            world.destroy_body(last).unwrap();
        }
        world.step(DT).unwrap();
        publisher.publish(&world);
        assert!(matches!(reader.wait(Duration::from_secs(5)).unwrap(), Poll::Frame { .. }));
        seen.push((reader.scene().frame().step, reader.scene().hash()));
    }
    reader.record(None).unwrap();
    (file, seen)
}

/// Steps and hashes that a recording gives, and the problems on the way.
fn play(file: &File) -> (Vec<(u64, u64)>, Vec<Problem>, End) {
    let mut reader = Reader::open(&file.0).unwrap();
    let (mut seen, mut problems) = (Vec::new(), Vec::new());
    loop {
        match reader.poll_next() {
            Ok(Poll::Frame { .. }) => seen.push((reader.scene().frame().step, reader.scene().hash())),
            Ok(_) => return (seen, problems, reader.recording().unwrap().end),
            Err(problem) => problems.push(problem),
        }
    }
}

#[test]
fn a_recording_shows_the_frames_that_were_seen_live() {
    let (file, seen) = record("same_frames", 500);
    let (again, problems, end) = play(&file);
    assert_eq!((again, problems, end), (seen, vec![], End::Finished));
}

#[test]
fn any_frame_is_found_by_its_step() {
    let (file, seen) = record("any_frame", 400);
    let mut reader = Reader::open(&file.0).unwrap();
    assert_eq!(reader.recording().unwrap().steps, Some((1, 400)));
    for index in [399, 0, 250, 119, 120, 121, 7] {
        let (step, hash) = seen[index];
        assert!(matches!(reader.seek(step).unwrap(), Poll::Frame { .. }));
        assert_eq!((reader.scene().frame().step, reader.scene().hash()), (step, hash), "frame {index}");
    }
    assert!(matches!(reader.seek(1_000_000).unwrap(), Poll::Frame { .. }));
    assert_eq!(reader.scene().frame().step, 400, "the last one before it");
}

#[test]
fn a_file_that_was_cut_short_gives_all_that_is_whole_and_says_where_it_ends() {
    let (file, seen) = record("cut_short", 400);
    let bytes = std::fs::read(&file.0).unwrap();
    for share in [0.99, 0.7, 0.5, 0.3] {
        let cut = (bytes.len() as f64 * share) as usize;
        std::fs::write(&file.0, &bytes[..cut]).unwrap();
        let (again, problems, end) = play(&file);
        let End::CutAfter(at) = end else { panic!("{share}: {end:?}") };
        assert!(at <= cut as u64 && problems.is_empty(), "{share}: {problems:?}");
        assert_eq!(again, seen[..again.len()], "{share}");
        assert!(again.len() + 240 > (400.0 * share) as usize, "{share}: only {} frames", again.len());
    }
}

#[test]
fn damage_is_left_out_and_what_is_behind_it_is_read() {
    let (file, seen) = record("damaged", 400);
    let bytes = std::fs::read(&file.0).unwrap();
    for place in [70, bytes.len() / 3, bytes.len() / 2, bytes.len() - 100] {
        let mut changed = bytes.clone();
        changed[place] ^= 0x10;
        std::fs::write(&file.0, &changed).unwrap();
        let (again, _, end) = play(&file);
        assert!(matches!(end, End::DamagedAt(_) | End::CutAfter(_)), "byte {place}: {end:?}");
        assert!(again.iter().all(|frame| seen.contains(frame)), "byte {place}: a frame that was never seen");
        assert!(again.len() >= 240, "byte {place}: only {} of 400 frames", again.len());
    }
}

#[test]
fn other_files_are_refused() {
    let (file, _) = record("refused", 3);
    let bytes = std::fs::read(&file.0).unwrap();
    let open = |bytes: &[u8]| {
        std::fs::write(&file.0, bytes).unwrap();
        Reader::open(&file.0).map(drop)
    };
    assert!(matches!(
        open(b"PNG and what follows, and then some more of that, until there is enough of it"),
        Err(Problem::Incompatible(_))
    ));
    assert!(matches!(open(b"short"), Err(Problem::Corrupt(_))));
    let mut head = bytes.clone();
    head[20] ^= 1;
    assert!(matches!(open(&head), Err(Problem::Corrupt(_))));
    assert!(matches!(Reader::open("/nowhere/at/all".as_ref()), Err(Problem::System(_))));
}
