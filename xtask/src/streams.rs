//! A host in C that publishes, and a process in C that watches, records and plays it; what they say of a stream of another version;
//! and what killing and stopping them does.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::compiler::{Language, compile};
use crate::library::{Library, cargo, output_folder};
use crate::{Outcome, printed, repository, succeed};

pub fn run() -> Outcome<()> {
    let library = Library::build_beside_tests("stream_peer")?;
    let folder = output_folder("streams")?;
    for language in [Language::Cpp11, Language::C99] {
        for name in ["publish", "renderer"] {
            let source = repository().join("examples_c").join(name).with_extension("c");
            compile(&source, &folder.join(name), language, &library)?;
        }
    }
    let recording = folder.join("run.lsr");
    let host = Command::new(folder.join("publish")).arg("4").stdout(Stdio::piped()).spawn()?;
    let seen = printed(Command::new(folder.join("renderer")).arg("2").arg(&recording))?;
    let published = host.wait_with_output()?;
    if !published.status.success() {
        return Err(format!("publish: {}", published.status).into());
    }
    let played = printed(Command::new(folder.join("renderer")).arg("play").arg(&recording))?;
    println!("{}seen live: {}\nplayed: {}", String::from_utf8(published.stdout)?, last_line(&seen), last_line(&played));
    let frames = |text: &str| last_line(text).split(' ').next().and_then(|count| count.parse::<u32>().ok()).unwrap_or(0);
    // What is published between two looks of a watcher is one more frame in the recording.
    if frames(&seen) < 10 || frames(&played) < frames(&seen) {
        return Err("the watcher saw less than it should have".into());
    }
    from_python(&library, &recording, frames(&played))?;
    other_version(&library.folder.join("examples/stream_peer"), &folder.join("renderer"))
}

/// The sample in Python finds as many frames, the blocks of the tower and the ball in the last; where there is no Python, nobody asks.
fn from_python(library: &Library, recording: &Path, frames: u32) -> Outcome<()> {
    if Command::new("python3").arg("--version").output().is_err() {
        return Ok(());
    }
    let mut script = Command::new("python3");
    script.arg(repository().join("examples/analyse.py")).arg(library.folder.join("liblongspan.so")).arg(recording);
    let rows = printed(&mut script)?;
    println!("from Python, the last of {} frames: {}", rows.lines().count() - 1, last_line(&rows));
    let bodies = last_line(&rows).split(',').nth(2);
    let holds = rows.lines().count() == frames as usize + 1 && bodies == Some("22");
    if holds { Ok(()) } else { Err(format!("{frames} frames were played, and the sample in Python finds others").into()) }
}

/// Kills, stops and restarts readers and publishers so many times.
pub fn endure(lives: &str) -> Outcome<()> {
    let peer = build_peer()?;
    succeed(Command::new(peer).args(["endure", "endure", "pile,n=1000", lives]))?;
    let mut tests = cargo();
    tests.args(["test", "--release", "--package", "longspan-stream", "--test", "processes"]).env("LONGSPAN_LIVES", lives);
    succeed(&mut tests)
}

/// `stream/examples/stream_peer.rs`, built to be measured.
pub fn build_peer() -> Outcome<std::path::PathBuf> {
    succeed(cargo().args(["build", "--release", "--package", "longspan-stream", "--example", "stream_peer"]))?;
    Ok(output_folder("release/examples")?.join("stream_peer"))
}

/// Ends when it is dropped.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A watcher in C says that the only stream there is of another version, and does not read it.
fn other_version(peer: &Path, renderer: &Path) -> Outcome<()> {
    let future = Ended(Command::new(peer).args(["future", "", "60"]).stdout(Stdio::null()).spawn()?);
    std::thread::sleep(std::time::Duration::from_secs(1));
    let output = Command::new(renderer).arg("1").output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    let said = said.lines().next().unwrap_or_default();
    println!("of a stream of the next schema: {said}");
    let frames = String::from_utf8_lossy(&output.stdout).contains("0 frames seen");
    // It dies with everything open, and whoever comes next clears up.
    drop(future);
    printed(Command::new(renderer).arg("0"))?;
    let holds = said.contains("schema 2") && said.contains("reads 1") && frames && output.status.success();
    if holds { Ok(()) } else { Err("the watcher does not say that the stream is of another version".into()) }
}

fn last_line(text: &str) -> &str {
    text.lines().last().unwrap_or_default()
}
