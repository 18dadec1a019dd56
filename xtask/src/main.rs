//! The project's own commands: `cargo demo`, and `cargo xtask` with one of the words below.
//!
//! What lives here is what somebody does with this repository that takes more than one call of cargo or of a C compiler. What
//! must not: anything that a user of the library needs, and any check that a plain test can make.

mod compiler;
mod consumers;
mod demo;
mod display;
mod hosts;
mod install;
mod instructions;
mod library;
mod notices;
mod pgo;
mod platform;
mod platforms;
mod profile;
mod readme;
mod samples;
mod streams;
mod touched;
mod tunnel;
mod viewer;
mod window;

use std::path::Path;
use std::process::{Command, ExitCode};

const USAGE: &str = "cargo xtask COMMAND

    demo      builds the library and the C samples, hangs ten tonnes on a chain, and draws it (also: cargo demo)
    header    writes include/longspan/longspan.h and capi/abi/baseline.txt anew
    samples   looks for warnings in the header at every standard, compiles every C sample as C99 and as C++11, and runs it
    streams   builds the library with streams; runs a host in C, and one that watches, records and plays it
    streams LIVES   kills, stops and restarts readers and publishers so many times, and looks at step times and what is left
    tunnel    carries a stream between two network namespaces by iceoryx2's tunnel, which must be installed; as root
    viewer [FOLDER [FIGURE]]   publishes each scene of the paper from a host in C; watches, records and plays it; looks at the pictures
    window [FOLDER] presses every key and button that the viewer's window answers to, and looks at what they do
    install PREFIX [--target TRIPLE] [--features stream] [--pgo]
              installs shared and static library, header, pkg-config files, CMake package and licences (DESTDIR is honoured);
              with --pgo, the library is built by a profile of scenes, for this platform
    consumers builds and runs a program for each way to take the installed library
    hosts     builds the hosts with a window, runs them under a virtual display, and looks at their pictures
    platforms [TARGET ...]   the table of state hashes and the C samples on aarch64, Windows and WebAssembly; gets what it needs
    instructions [bless]   counts the instructions of steps of some scenes, and the code and stack that one step touches; compares with benches/instructions.toml, or writes it
    profile SCENE FIRST COUNT [KEY=VALUE ...]   where the instructions of these steps go
    readme    compiles and runs the C example of README.md by the compiler lines given there";

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let outcome = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["demo"] => demo::run(),
        ["header"] => write_header(),
        ["samples"] => samples::run(),
        ["hosts"] => hosts::run(),
        ["streams"] => streams::run(),
        ["tunnel"] => tunnel::run(),
        ["viewer"] => viewer::run(None, None),
        ["viewer", folder] => viewer::run(Some(folder), None),
        ["viewer", folder, figure] => viewer::run(Some(folder), Some(figure)),
        ["window"] => window::run(None),
        ["window", folder] => window::run(Some(folder)),
        ["streams", lives] => streams::endure(lives),
        ["readme"] => readme::run(),
        ["install", ref words @ ..] => install::run(words),
        ["instructions"] => instructions::run(false),
        ["instructions", "bless"] => instructions::run(true),
        ["profile", ref words @ ..] => profile::run(words),
        ["platforms", ref names @ ..] => platforms::run(names),
        ["consumers"] => consumers::run(),
        _ => Err(USAGE.into()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::FAILURE
        }
    }
}

/// The test that compares the header with the library's source can also write it.
fn write_header() -> Outcome<()> {
    let mut cargo = library::cargo();
    cargo.args(["test", "--package", "longspan-capi", "--test", "header"]).env("LONGSPAN_BLESS", "1");
    succeed(&mut cargo)
}

/// The folder that holds everything.
fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("this crate lies in a folder of the repository")
}

/// Runs a command that must succeed; what it prints is seen.
fn succeed(command: &mut Command) -> Outcome<()> {
    let status = command.status().map_err(|error| format!("{command:?}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?}: {status}").into()) }
}

/// Runs a command that must succeed and returns what it prints.
fn printed(command: &mut Command) -> Outcome<String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() {
        return Ok(text(&output.stdout));
    }
    Err(format!("{command:?}: {}\n{}{}", output.status, text(&output.stdout), text(&output.stderr)).into())
}
