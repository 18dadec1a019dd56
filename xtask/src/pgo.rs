//! A build of the library that knows which of its code steps run through: `cargo xtask install PREFIX --pgo`.
//!
//! A step that comes once a frame finds its code in no cache, so what it runs through should lie together. The profile is of scenes that no
//! benchmark measures. The bits of steps may not depend on it: scenes of both kinds are run with and without.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::library::{cargo, output_folder};
use crate::{Outcome, instructions, printed, succeed};

/// Scenes that the profile is of: first steps that count for nothing, and steps.
const TRAINING: &[&str] = &[
    "swinging_weight 0 120",
    "lifted_chain 0 120",
    "cable_car 0 60",
    "cantilever 0 120",
    "arm 0 120",
    "crossbow 0 60",
    "breaking_beam 0 90",
    "heavy_on_light 0 120",
    "column 0 120",
    "support_gallery 0 60",
    "wedge 0 120",
    "card_house 0 120",
    "free_cluster 0 120",
    "slope 0 60",
    "bounce 0 120",
    "hinge_motor 0 60",
    "platform 0 120",
    "resting 0 120",
    "violent 0 120 n=100",
    "violent 0 120 n=40 what=joints",
];

/// Cargo, told to build with a profile that has been taken now.
pub fn cargo_with_profile() -> Outcome<Command> {
    let merge = profdata()?;
    let folder = output_folder("pgo")?;
    let (raw, profile) = (folder.join("raw"), folder.join("steps.profdata"));
    if raw.exists() {
        fs::remove_dir_all(&raw)?;
    }
    println!("taking a profile of {} scenes", TRAINING.len());
    let trainer = counted(&mut told("-Cprofile-generate", &raw, &folder.join("train")), &folder.join("train"))?;
    for row in TRAINING {
        printed(Command::new(&trainer).args(row.split(' ')))?;
    }
    succeed(Command::new(merge).args(["merge", "--output"]).args([&profile, &raw]))?;
    let trained = folder.join("trained");
    let program = counted(&mut told("-Cprofile-use", &profile, &trained), &trained)?;
    compare(&instructions::build()?, &program)?;
    Ok(told("-Cprofile-use", &profile, &trained))
}

/// LLVM's tool that merges raw profiles, which has to be of the compiler's own version.
fn profdata() -> Outcome<PathBuf> {
    let sysroot = printed(Command::new("rustc").args(["--print", "sysroot"]))?;
    let name = if cfg!(windows) { "llvm-profdata.exe" } else { "llvm-profdata" };
    let tool = Path::new(sysroot.trim()).join("lib/rustlib").join(env!("LONGSPAN_HOST")).join("bin").join(name);
    if tool.exists() {
        return Ok(tool);
    }
    let advice = "Install it with `rustup component add llvm-tools`, or install the library without --pgo.";
    Err(format!("a profile takes the compiler's own llvm-profdata, and {} does not exist. {advice}", tool.display()).into())
}

/// Cargo with a flag for the compiler that names a path, and a target folder of its own.
fn told(flag: &str, path: &Path, target: &Path) -> Command {
    let mut cargo = cargo();
    let mut flags = OsString::from(flag);
    flags.push("=");
    flags.push(path);
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags).env("CARGO_TARGET_DIR", target);
    cargo
}

/// The program that makes steps.
fn counted(cargo: &mut Command, target: &Path) -> Outcome<PathBuf> {
    let packages = ["--package", "longspan-capi", "--package", "longspan-scenes"];
    succeed(cargo.args(["build", "--release"]).args(packages).args(["--bin", "counted"]))?;
    Ok(target.join("release/counted"))
}

/// Makes sure that scenes end in the same state by two builds, those of the profile and others.
fn compare(plain: &Path, trained: &Path) -> Outcome<()> {
    for row in TRAINING.iter().chain(instructions::ROWS) {
        let state = |program: &Path| printed(Command::new(program).args(row.split(' ')));
        let (before, now) = (state(plain)?, state(trained)?);
        if before != now {
            return Err(format!("{row}: state {} without a profile and {} with one", before.trim(), now.trim()).into());
        }
    }
    println!("{} scenes end in the same state with the profile as without", TRAINING.len() + instructions::ROWS.len());
    Ok(())
}
