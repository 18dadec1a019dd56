//! The table of state hashes on other platforms, and the C samples on those that run C programs.
//!
//! A target is built with a compiler that is fetched if need be, and run by an emulator. What cannot be had is said, and the
//! command fails: a target that was not looked at has not passed.

mod samples;
mod toolchain;

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::library::{cargo, output_folder};
use crate::{Outcome, printed, repository, succeed};
pub use toolchain::Toolchain;
use toolchain::need;

/// A platform, and who can run its programs.
struct Target {
    name: &'static str,
    triple: &'static str,
    /// Programs that are called, and Debian's packages of them.
    programs: &'static [&'static str],
    packages: &'static [&'static str],
    /// Looks at everything that is promised there; returns what it has looked at.
    check: fn(&Toolchain, &Host) -> Outcome<Vec<String>>,
}

const TARGETS: [Target; 4] = [
    Target {
        name: "aarch64",
        triple: "aarch64-unknown-linux-gnu",
        programs: &["aarch64-linux-gnu-gcc", "qemu-aarch64"],
        packages: &["gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross", "qemu-user"],
        check: aarch64,
    },
    Target {
        name: "windows",
        triple: "x86_64-pc-windows-gnu",
        programs: &["x86_64-w64-mingw32-gcc", "wine"],
        packages: &["gcc-mingw-w64-x86-64", "wine64", "wine"],
        check: windows,
    },
    Target {
        name: "wasi",
        triple: "wasm32-wasip1",
        programs: &["wasm-ld", "node"],
        packages: &["lld", "wasi-libc", "nodejs"],
        check: wasi,
    },
    Target {
        name: "web",
        triple: "wasm32-unknown-unknown",
        programs: &["wasm-ld", "node"],
        packages: &["lld", "nodejs"],
        check: web,
    },
];

/// Checks the targets of these names, or all.
pub fn run(names: &[&str]) -> Outcome<()> {
    if let Some(name) = names.iter().find(|name| TARGETS.iter().all(|target| target.name != **name)) {
        return Err(format!("no target {name}; there are {}", TARGETS.map(|target| target.name).join(", ")).into());
    }
    let host = Host::prepare()?;
    let mut outcomes = vec![("host", Ok(vec![format!("{} rows on 1 and 3 threads", host.rows)]))];
    for target in TARGETS.iter().filter(|target| names.is_empty() || names.contains(&target.name)) {
        println!("\n{} ({})", target.name, target.triple);
        let toolchain = need(target.programs, target.packages).and_then(|()| Toolchain::get(target.triple));
        let outcome = match toolchain {
            Ok(toolchain) => (target.check)(&toolchain, &host).map_err(|problem| format!("FAILED: {problem}")),
            Err(problem) => Err(format!("LEFT OUT, not looked at: {problem}")),
        };
        outcomes.push((target.name, outcome));
    }
    println!();
    for (name, outcome) in &outcomes {
        println!(
            "{name:8} {}",
            outcome.as_ref().map_or_else(Clone::clone, |looked| format!("the same bits: {}", looked.join(", ")))
        );
    }
    let failed = outcomes.iter().filter(|(_, outcome)| outcome.is_err()).count();
    if failed > 0 { Err(format!("{failed} targets have not passed").into()) } else { Ok(()) }
}

/// This machine: what others are compared with.
struct Host {
    bits: PathBuf,
    /// Snapshots and recordings written here.
    folder: PathBuf,
    /// The folder of the library.
    library: PathBuf,
    rows: usize,
}

impl Host {
    fn prepare() -> Outcome<Self> {
        succeed(cargo().args(["build", "--package", "longspan-bits", "--package", "longspan-capi"]))?;
        let library = output_folder("debug")?;
        let mut host = Self { bits: library.join("bits"), folder: emptied("platforms/host")?, library, rows: 0 };
        println!("\nhost");
        say(host.run().args(["run", TABLE, "1"]).arg(&host.folder))?;
        say(host.run().args(["run", TABLE, "3"]))?;
        host.rows = fs::read_dir(&host.folder)?.count() / 2;
        Ok(host)
    }

    fn run(&self) -> Command {
        in_repository(&self.bits)
    }

    fn recordings(&self) -> impl Iterator<Item = PathBuf> {
        (0..self.rows).map(|number| self.folder.join(format!("{number}.recording")))
    }
}

/// The table; a program for WASI knows no folder that it is in.
const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/reference/platforms.md");

fn in_repository(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(repository());
    command
}

/// Runs a program that must succeed and prints what it says.
fn say(command: &mut Command) -> Outcome<()> {
    print!("{}", printed(command)?);
    Ok(())
}

/// The table, on each number of threads; snapshots and recordings from here there, and from there here.
fn compare(name: &str, run: &dyn Fn() -> Command, threads: &[&str], host: &Host) -> Outcome<Vec<String>> {
    let folder = emptied(&format!("platforms/{name}"))?;
    say(run().args(["run", TABLE, threads[0]]).arg(&folder))?;
    for count in &threads[1..] {
        say(run().args(["run", TABLE, count]))?;
    }
    say(run().args(["resume", TABLE]).arg(&host.folder))?;
    say(host.run().args(["resume", TABLE]).arg(&folder))?;
    let rows = format!("{} rows on {} threads", host.rows, threads.join(" and "));
    Ok(vec![rows, "snapshots and recordings both ways".to_owned()])
}

fn aarch64(toolchain: &Toolchain, host: &Host) -> Outcome<Vec<String>> {
    const EMULATOR: &str = "qemu-aarch64 -L /usr/aarch64-linux-gnu";
    succeed(toolchain.build()?.args(["--package", "longspan-bits", "--package", "longspan-capi"]))?;
    let folder = toolchain.folder("debug")?;
    let emulated = |program: &Path| {
        let mut words = EMULATOR.split(' ');
        let mut command = in_repository(words.next().unwrap_or_default());
        command.args(words).arg(program);
        command
    };
    let mut looked = compare("aarch64", &|| emulated(&folder.join("bits")), &["1", "3"], host)?;
    looked.push(samples::compare("aarch64-linux-gnu-gcc", &folder.join("liblongspan.a"), &host.library, &emulated)?);
    looked.push(lanes(toolchain, EMULATOR)?);
    Ok(looked)
}

fn windows(toolchain: &Toolchain, host: &Host) -> Outcome<Vec<String>> {
    succeed(toolchain.build()?.args(["--package", "longspan-bits", "--package", "longspan-capi"]))?;
    let folder = toolchain.folder("debug")?;
    let source = repository().join("xtask/src/platforms/random.c");
    let mut compiler = Command::new("x86_64-w64-mingw32-gcc");
    succeed(compiler.arg("-shared").arg(source).args(["-ladvapi32", "-o"]).arg(folder.join("bcryptprimitives.dll")))?;
    // A program finds the DLLs that lie beside it.
    for dll in ["longspan.dll", "bcryptprimitives.dll"] {
        fs::copy(folder.join(dll), output_folder("platforms/samples")?.join(dll))?;
    }
    let prefix = output_folder("platforms/wine")?;
    let emulated = |program: &Path| {
        let mut command = in_repository("wine");
        command.env("WINEPREFIX", &prefix).env("WINEDEBUG", "-all").arg(program);
        command
    };
    let mut looked = compare("windows", &|| emulated(&folder.join("bits.exe")), &["1", "3"], host)?;
    looked.push(samples::compare("x86_64-w64-mingw32-gcc", &folder.join("liblongspan.dll.a"), &host.library, &emulated)?);
    Ok(looked)
}

/// Node 20 crashes now and then where memory grows while other threads still compile, or while what is in use has been marked in part.
const NODE: [&str; 3] = ["--no-warnings", "--single-threaded", "--no-incremental-marking"];

fn wasi(toolchain: &Toolchain, host: &Host) -> Outcome<Vec<String>> {
    succeed(toolchain.build()?.args(["--package", "longspan-bits"]))?;
    let (program, script) = (toolchain.folder("debug")?.join("bits.wasm"), repository().join("xtask/src/platforms/wasi.mjs"));
    let run = || {
        let mut command = in_repository("node");
        command.args(NODE).arg(&script).arg(&program);
        command
    };
    let mut looked = compare("wasi", &run, &["1"], host)?;
    looked.push(lanes(toolchain, &format!("node {} {}", NODE.join(" "), script.display()))?);
    Ok(looked)
}

/// A module without a system has no files: it plays recordings, which hold a hash for every step.
fn web(toolchain: &Toolchain, host: &Host) -> Outcome<Vec<String>> {
    succeed(toolchain.build()?.args(["--package", "longspan-capi"]))?;
    let script = repository().join("xtask/src/platforms/replay.mjs");
    say(in_repository("node").arg(script).arg(toolchain.folder("debug")?.join("longspan.wasm")).args(host.recordings()))?;
    Ok(vec![format!("recordings of {} rows, played by the C interface", host.rows)])
}

/// The tests that compare a processor's registers with plain arrays.
fn lanes(toolchain: &Toolchain, runner: &str) -> Outcome<String> {
    const TEST: &str = "all_registers_give_the_same_bits";
    let output = printed(toolchain.test(runner)?.args(["--package", "longspan", "--lib", TEST]))?;
    match output.lines().find(|line| line.starts_with("test result: ok.") && !line.contains(" 0 passed")) {
        Some(_) => Ok("registers as arrays".to_owned()),
        None => Err(format!("no test {TEST} has run\n{output}").into()),
    }
}

fn emptied(name: &str) -> Outcome<PathBuf> {
    let folder = output_folder(name)?;
    fs::remove_dir_all(&folder)?;
    output_folder(name)
}
