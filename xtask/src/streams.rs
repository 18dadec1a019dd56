//! A host in C that publishes, and a process in C that watches, records and plays it.

use std::process::{Command, Stdio};

use crate::compiler::{Language, compile};
use crate::library::{Library, output_folder};
use crate::{Outcome, printed, repository};

pub fn run() -> Outcome<()> {
    let library = Library::build_with(&["--features", "stream"])?;
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
    Ok(())
}

fn last_line(text: &str) -> &str {
    text.lines().last().unwrap_or_default()
}
