//! What the tests of streams share.
#![allow(dead_code)]

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use longspan::glam::Vec3;
use longspan::{BodyDef, BodyId, Pose, Shape, ShapeDef, World, WorldDef};
use longspan_scenes::{LongspanEngine, build};
use longspan_stream::schema::LsStreamBody;
use longspan_stream::{Domain, Poll, Publisher, PublisherDef, Reader};

/// A domain of a test's own, empty before and removed after.
pub struct Room {
    pub domain: Domain,
}

impl Room {
    pub fn new(test: &str) -> Self {
        let room = Self { domain: Domain::named(&format!("{test}{}", std::process::id())).unwrap() };
        room.remove();
        room
    }

    pub fn def(&self, name: &str) -> PublisherDef {
        PublisherDef { name: name.into(), domain: self.domain.clone(), ..PublisherDef::default() }
    }

    /// All shared memory, folders and files of the domain.
    pub fn files(&self) -> Vec<PathBuf> {
        let memory = Path::new("/dev/shm");
        let mut found: Vec<PathBuf> = names(memory, &self.domain.prefix()).iter().map(|name| memory.join(name)).collect();
        let mut open = vec![self.domain.folder()];
        while let Some(folder) = open.pop() {
            let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
            let (folders, files): (Vec<PathBuf>, Vec<PathBuf>) =
                entries.map(|entry| entry.path()).partition(|path| path.is_dir());
            open.extend(folders);
            found.extend(files);
            found.push(folder);
        }
        found.sort();
        found
    }

    /// The same without folders, the one file that iceoryx2 keeps for good, and our own lock.
    pub fn leftovers(&self) -> Vec<String> {
        let files = self.files().into_iter().filter(|path| !path.is_dir()).map(|path| path.display().to_string());
        files.filter(|name| !name.contains("global_mgmt") && !name.ends_with("/lock")).collect()
    }

    fn remove(&self) {
        let _ = std::fs::remove_dir_all(self.domain.folder());
        for name in names("/dev/shm".as_ref(), &self.domain.prefix()) {
            let _ = std::fs::remove_file(format!("/dev/shm/{name}"));
        }
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        self.remove();
    }
}

fn names(folder: &std::path::Path, prefix: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).filter(|name| name.starts_with(prefix)).collect()
}

/// Boxes in the air above a ground.
pub fn falling_boxes(count: usize) -> World {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let ground = Shape::cuboid(Vec3::new(50.0, 0.5, 50.0)).unwrap();
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(ShapeDef::new(ground))).unwrap();
    let shape = Shape::cuboid(Vec3::splat(0.3)).unwrap();
    for index in 0..count {
        let (x, z) = ((index % 10) as f64, (index / 10 % 10) as f64);
        let pose = Pose::at_xyz(x - 4.5, 1.0 + (index / 100) as f64, z - 4.5);
        let mut def = BodyDef::dynamic(pose).with_shape(ShapeDef::new(shape.clone()));
        def.user_word = index as u64;
        world.create_body(&def).unwrap();
    }
    world
}

/// What a scene of the library of scenes begins with.
pub fn scene(name: &str, keys: &[(&str, &str)]) -> LongspanEngine {
    let keys: Vec<_> = keys.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    LongspanEngine::start(&build(name, &keys).unwrap()).unwrap()
}

/// Whether a reader has a body where the world has it.
pub fn body_matches(world: &World, body: BodyId, found: &LsStreamBody) {
    let pose = world.pose(body).unwrap();
    assert_eq!(found.position, pose.position.to_array(), "position of {body:?} after step {}", world.step_count());
    assert_eq!(found.rotation, pose.rotation.to_array(), "rotation of {body:?}");
    assert_eq!(found.linear_velocity, world.linear_velocity(body).unwrap().to_array(), "velocity of {body:?}");
    assert_eq!(found.user_word, world.user_word(body).unwrap(), "word of {body:?}");
}

/// Polls until it says this, or for five seconds.
pub fn until(reader: &mut Reader, wanted: Poll) -> Poll {
    let deadline = Instant::now() + Duration::from_secs(5);
    loop {
        let poll = reader.poll();
        if poll.as_ref().is_ok_and(|&poll| poll == wanted) || Instant::now() > deadline {
            return poll.unwrap();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A reader that has seen its publisher's first frame.
pub fn attach(room: &Room, name: &str, publishers: &mut [Publisher]) -> Reader {
    let mut reader = Reader::attach(&room.domain, name).unwrap();
    assert_eq!(until(&mut reader, Poll::Nothing), Poll::Nothing, "{name} is there");
    publishers.iter_mut().for_each(Publisher::serve);
    let poll = reader.wait(Duration::from_secs(5)).unwrap();
    assert!(matches!(poll, Poll::Frame { is_first: true, .. }), "{name}: {poll:?}");
    reader
}

/// `examples/stream_peer.rs`, started and ready.
pub fn peer(words: &[&str]) -> Child {
    let here = std::env::current_exe().unwrap();
    let program = here.parent().and_then(|deps| deps.parent()).unwrap().join("examples/stream_peer");
    let mut child = Command::new(program).args(words).stdout(Stdio::piped()).spawn().expect("cargo builds examples for tests");
    assert_eq!(line(&mut child), "ready");
    child
}

/// The next line that a process says, without what follows it.
pub fn line(child: &mut Child) -> String {
    let (mut said, mut byte) = (Vec::new(), [0]);
    // Byte by byte: what a buffer took beyond the line would be lost.
    while child.stdout.as_mut().unwrap().read_exact(&mut byte).is_ok() && byte != *b"\n" {
        said.extend(byte);
    }
    String::from_utf8(said).unwrap()
}

/// What was given to [`Room::new`], and the number of this process.
pub fn domain_name(room: &Room) -> String {
    let folder = room.domain.folder();
    folder.file_name().unwrap().to_str().unwrap().trim_start_matches("d-").to_owned()
}

/// Ends a process at once, as if it had crashed.
pub fn kill(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}
