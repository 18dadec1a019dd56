//! State hashes of every scene: a table that holds on every platform, on any number of threads.
//!
//! The table is `docs/reference/platforms.md`, rows of Markdown. A row names a scene with its keys and a number of steps; [`Row::world`] takes
//! these steps, and the hash of the world's state is then the row's, or the platform computes otherwise.

use std::sync::{Arc, Mutex, PoisonError};

use longspan::glam::Vec3;
use longspan::{RecordedWorld, RecordingSink, Replay, World, WorldDef};

use crate::catalogue::{CATALOGUE, build};
use crate::engine::Effort;
use crate::longspan_engine::LongspanEngine;
use crate::run::run;

/// Any problem, in words.
pub type Problem = Box<dyn std::error::Error>;

/// Steps of a scene that has no row yet.
const STEPS: u32 = 60;

/// Steps of a recording before gravity changes, and after it.
const RECORDED: u32 = 5;

/// A row of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// Keys of the scene with their values.
    pub keys: Vec<(String, String)>,
    /// Steps taken.
    pub steps: u32,
    /// Hash of the world's state after these.
    pub hash: u64,
}

impl Row {
    /// Reads a line of the table; `None` if it is no row.
    fn parse(line: &str) -> Option<Self> {
        let cells: Vec<&str> = line.strip_prefix("| `")?.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
        let [scene, steps, hash, ..] = cells[..] else { return None };
        let (scene, keys) = scene.split_once(' ').unwrap_or((scene, ""));
        let pair = |word: &str| word.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned()));
        let keys = keys.split_whitespace().map(pair).collect::<Option<_>>()?;
        Some(Self { scene: scene.to_owned(), keys, steps: steps.parse().ok()?, hash: u64::from_str_radix(hash, 16).ok()? })
    }

    /// The scene and its keys.
    pub fn name(&self) -> String {
        self.keys.iter().fold(self.scene.clone(), |name, (key, value)| format!("{name} {key}={value}"))
    }

    /// The scene after the row's steps.
    ///
    /// # Errors
    /// The scene is not known, or is refused though it should not be.
    pub fn world(&self, threads: usize) -> Result<LongspanEngine, Problem> {
        let mut scene = build(&self.scene, &self.keys)?;
        scene.metrics.clear();
        scene.steps = self.steps;
        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, threads)?;
        run(scene, &mut engine, Effort::Default, threads)?;
        Ok(engine)
    }
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "| `{}` | {} | `{:016x}` |", self.name(), self.steps, self.hash)
    }
}

/// The rows of a table.
pub fn rows(table: &str) -> Vec<Row> {
    table.lines().filter_map(Row::parse).collect()
}

/// Every row with the hash that is found here, and rows for the scenes that have none yet.
///
/// # Errors
/// As [`Row::world`].
pub fn blessed(table: &str) -> Result<Vec<Row>, Problem> {
    let mut rows = rows(table);
    let known: Vec<String> = rows.iter().map(|row| row.scene.clone()).collect();
    let missing = CATALOGUE.iter().filter(|entry| !known.iter().any(|scene| scene == entry.name));
    rows.extend(missing.map(|entry| Row { scene: entry.name.to_owned(), keys: Vec::new(), steps: STEPS, hash: 0 }));
    for row in &mut rows {
        row.hash = row.world(1)?.world().state_hash();
    }
    Ok(rows)
}

/// A recording of some steps from a snapshot on, under gravity that changes.
///
/// # Errors
/// If the world refuses the snapshot or a call.
pub fn record(snapshot: &[u8]) -> Result<Vec<u8>, Problem> {
    let mut world = World::new(&WorldDef::default())?;
    world.restore(snapshot)?;
    let mut world = RecordedWorld::new(world);
    let bytes = Kept::default();
    world.record(Box::new(bytes.clone()), true)?;
    for gravity in [Vec3::new(0.0, -9.81, 0.0), Vec3::new(1.0, -9.0, -0.5)] {
        world.set_gravity(gravity)?;
        for _ in 0..RECORDED {
            world.step(1.0 / 60.0)?;
        }
    }
    world.stop_recording()?;
    drop(world);
    Ok(bytes.take())
}

/// Plays such a recording.
///
/// # Errors
/// If it comes out otherwise than recorded, or not all of it is there.
pub fn replay(recording: &[u8]) -> Result<(), Problem> {
    let mut replay = Replay::new(recording)?;
    let played = replay.run(u64::MAX)?;
    if let Some(divergence) = played.divergence {
        return Err(format!("the recording comes out otherwise: {divergence:?}").into());
    }
    if played.cut_short || played.steps != u64::from(2 * RECORDED) {
        return Err(format!("only {} steps of the recording are there", played.steps).into());
    }
    Ok(())
}

/// Bytes that a recording writes.
#[derive(Clone, Default)]
struct Kept(Arc<Mutex<Vec<u8>>>);

impl Kept {
    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl RecordingSink for Kept {
    fn write(&mut self, bytes: &[u8]) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(bytes);
        true
    }
}
