//! Compilers for other platforms: rustup's where it has or gets them, else Debian's, unpacked into the target folder.
//!
//! Debian's `rustc-web` comes with its own source, from which cargo builds the standard library of any target. It would take the
//! place of other compilers if it were installed, so it is unpacked, and nothing but this command sees it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::library::{cargo, output_folder};
use crate::{Outcome, printed, succeed};

/// Packages of Debian's compiler; those that they depend on are found by [`with_libraries`].
const PACKAGES: [&str; 4] = ["rustc-web", "libstd-rust-web-dev", "libstd-rust-web-dev:arm64", "rust-web-src"];

/// What can build for a target.
pub struct Toolchain {
    triple: String,
    /// Debian's compiler, if it is that.
    debian: Option<PathBuf>,
}

impl Toolchain {
    /// Finds or gets a compiler.
    pub fn get(triple: &str) -> Outcome<Self> {
        let has_it = || {
            let listed = printed(Command::new("rustup").args(["target", "list", "--installed"]));
            listed.is_ok_and(|listed| listed.lines().any(|line| line == triple))
        };
        if has_it() || (printed(Command::new("rustup").args(["target", "add", triple])).is_ok() && has_it()) {
            return Ok(Self { triple: triple.to_owned(), debian: None });
        }
        let folder = output_folder("platforms/debian")?;
        if !folder.join("usr/bin/rustc").exists() {
            unpack(&folder).map_err(|problem| format!("neither rustup nor Debian has a compiler for {triple}: {problem}"))?;
        }
        Ok(Self { triple: triple.to_owned(), debian: Some(folder) })
    }

    /// `cargo build` for the target, without debugging information.
    pub fn build(&self) -> Outcome<Command> {
        let mut command = cargo();
        command.arg("build");
        self.prepare(&mut command)?;
        Ok(command)
    }

    /// `cargo test` for the target, whose programs are run by `runner`.
    pub fn test(&self, runner: &str) -> Outcome<Command> {
        let mut command = cargo();
        command.arg("test").env(self.variable("RUNNER"), runner);
        self.prepare(&mut command)?;
        Ok(command)
    }

    fn prepare(&self, command: &mut Command) -> Outcome<()> {
        command.args(["--target", &self.triple]).env("CARGO_PROFILE_DEV_DEBUG", "none");
        let linker = match self.triple.as_str() {
            "aarch64-unknown-linux-gnu" => Some("aarch64-linux-gnu-gcc"),
            "x86_64-pc-windows-gnu" => Some("x86_64-w64-mingw32-gcc"),
            _ => None,
        };
        if let Some(linker) = linker {
            command.env(self.variable("LINKER"), linker);
        }
        if self.triple == "wasm32-wasip1" {
            command.env(self.variable("RUSTFLAGS"), "-C target-feature=+simd128");
        }
        let Some(folder) = &self.debian else { return Ok(()) };
        // A folder of its own: cargo would build the host's programs again with this compiler.
        command
            .env("RUSTC", wrapper(folder)?)
            .env("RUSTC_BOOTSTRAP", "1")
            .env("CARGO_TARGET_DIR", output_folder("platforms/cargo")?);
        if !folder.join("usr/lib/rustlib").join(&self.triple).exists() {
            let crates = if self.triple.starts_with("wasm32") { "std,panic_abort" } else { "std,panic_unwind" };
            command.arg(format!("-Zbuild-std={crates}"));
        }
        if self.triple == "wasm32-wasip1" {
            command.env(self.variable("RUSTFLAGS"), WASI_FLAGS);
        }
        Ok(())
    }

    fn variable(&self, name: &str) -> String {
        format!("CARGO_TARGET_{}_{name}", self.triple.replace('-', "_").to_uppercase())
    }

    /// Where cargo puts what it builds so, in this profile's folder.
    pub fn folder(&self, profile: &str) -> Outcome<PathBuf> {
        let target = match &self.debian {
            Some(_) => output_folder("platforms/cargo")?,
            None => output_folder(".")?,
        };
        Ok(target.join(&self.triple).join(profile))
    }
}

/// Debian's compiler finds its libraries where they would have been installed, unless it is told.
fn wrapper(folder: &Path) -> Outcome<PathBuf> {
    let path = folder.join("rustc");
    let libraries = folder.join("usr/lib/x86_64-linux-gnu");
    let text =
        format!("#!/bin/sh\nLD_LIBRARY_PATH={} exec {} \"$@\"\n", libraries.display(), folder.join("usr/bin/rustc").display());
    if fs::read_to_string(&path).ok().as_ref() != Some(&text) {
        fs::write(&path, text)?;
        succeed(Command::new("chmod").arg("+x").arg(&path))?;
    }
    Ok(path)
}

/// How a program for WASI is linked with Debian's C library. That is of 2022 and has none of the functions of threads that the
/// standard library names but never calls there: `wasi.mjs` stands in for them.
const WASI_FLAGS: &str = "-C target-feature=+simd128 -C linker=wasm-ld -C link-self-contained=no -L native=/usr/lib/wasm32-wasi \
    -C link-arg=/usr/lib/wasm32-wasi/crt1-command.o -C link-arg=--allow-undefined";

fn unpack(folder: &Path) -> Outcome<()> {
    println!("getting Debian's compiler, 190 MB");
    if !printed(Command::new("dpkg").arg("--print-foreign-architectures"))?.contains("arm64") {
        succeed(Command::new("dpkg").args(["--add-architecture", "arm64"]))?;
        succeed(Command::new("apt-get").args(["--quiet=2", "update"]))?;
    }
    let archives = folder.join("archives");
    fs::create_dir_all(&archives)?;
    succeed(Command::new("apt-get").args(["--quiet=2", "download"]).args(with_libraries()?).current_dir(&archives))?;
    for archive in fs::read_dir(&archives)? {
        succeed(Command::new("dpkg-deb").arg("--extract").arg(archive?.path()).arg(folder))?;
    }
    Ok(fs::remove_dir_all(&archives)?)
}

/// The packages, and the libraries of the compiler's that they depend on.
fn with_libraries() -> Outcome<Vec<String>> {
    let mut packages: Vec<String> = PACKAGES.iter().map(|&name| name.to_owned()).collect();
    let mut looked = 0;
    while let Some(package) = packages.get(looked).cloned() {
        looked += 1;
        for line in printed(Command::new("apt-cache").arg("depends").arg(package))?.lines() {
            let name = line.trim().strip_prefix("Depends: ").unwrap_or_default().to_owned();
            let is_wanted = name.starts_with("libstd-rust-web") || name.starts_with("libllvm");
            if is_wanted && !packages.contains(&name) {
                packages.push(name);
            }
        }
    }
    Ok(packages)
}

/// Installs Debian's packages of programs that are not there.
pub fn need(programs: &[&str], packages: &[&str]) -> Outcome<()> {
    let missing = |program: &&&str| Command::new(program).arg("--version").output().is_err();
    let Some(first) = programs.iter().find(missing) else { return Ok(()) };
    println!("`{first}` is not there; installing {}", packages.join(" "));
    let mut install = Command::new("apt-get");
    install
        .args(["install", "--quiet=2", "--yes", "--no-install-recommends"])
        .args(packages)
        .env("DEBIAN_FRONTEND", "noninteractive");
    printed(&mut install).map_err(|problem| format!("`{first}` is not there and cannot be installed: {problem}"))?;
    match programs.iter().find(missing) {
        Some(program) => Err(format!("`{program}` is not there even now").into()),
        None => Ok(()),
    }
}
