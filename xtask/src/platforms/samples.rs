//! C samples, built with a compiler for another platform and run there: each prints what it prints on this machine.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::library::output_folder;
use crate::{Outcome, printed, repository};

/// Samples that ask nothing of the system but the time.
const SAMPLES: [&str; 9] = ["hello", "chain", "edit", "events", "queries", "keystone", "misuse", "rollback", "track"];

/// Builds and runs every sample here and there.
pub fn compare(compiler: &str, library: &Path, host: &Path, emulated: &dyn Fn(&Path) -> Command) -> Outcome<String> {
    for name in SAMPLES {
        let here = untimed(&printed(&mut Command::new(build("cc", name, &host.join("liblongspan.a"))?))?);
        let there = untimed(&printed(&mut emulated(&build(compiler, name, library)?))?);
        if here != there {
            return Err(format!("{name} prints otherwise there:\n{there}\nhere:\n{here}").into());
        }
        println!("{name}.c prints {} lines, as here", here.lines().count());
    }
    Ok(format!("{} C samples", SAMPLES.len()))
}

/// What a sample prints, but for the time that it took.
fn untimed(output: &str) -> String {
    output.lines().filter(|line| !line.starts_with("CPU time")).flat_map(|line| [line.trim_end(), "\n"]).collect()
}

fn build(compiler: &str, name: &str, library: &Path) -> Outcome<PathBuf> {
    let is_windows = compiler.contains("mingw");
    let program = output_folder("platforms/samples")?.join(format!("{name}-{compiler}{}", if is_windows { ".exe" } else { "" }));
    let mut command = Command::new(compiler);
    command.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", "-I"]).arg(repository().join("include"));
    command.arg(repository().join(format!("examples_c/{name}.c"))).arg(library);
    // Clocks of POSIX are in a library of threads there.
    let windows = ["-D__USE_MINGW_ANSI_STDIO=1", "-Wl,-Bstatic", "-lpthread", "-Wl,-Bdynamic"];
    command.args(if is_windows { &windows[..] } else { &["-lm", "-lpthread", "-ldl"] });
    printed(command.arg("-o").arg(&program))?;
    Ok(program)
}
