//! Builds the library once and compiles hosts against it.
#![allow(dead_code, reason = "each test program uses a part of this")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

pub const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-pedantic", "-Werror"];

/// The library, built by the first test that needs it.
pub static LIBRARY: LazyLock<Library> = LazyLock::new(Library::build);

#[derive(Clone, Copy)]
pub enum Language {
    C99,
    Cpp11,
    Cpp17,
}

#[derive(Clone, Copy)]
pub enum Linkage {
    Static,
    Dynamic,
}

pub struct Library {
    folder: PathBuf,
    /// What a program linked with the static library needs besides it.
    system_libraries: Vec<String>,
}

pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Where the programs go, and what they write.
pub fn output_folder() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

/// Runs a command that must succeed, and returns what it printed.
pub fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let (printed, complaint) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}\n{printed}\n{complaint}", output.status);
    printed.into_owned()
}

impl Library {
    /// Cargo does not build a cdylib or staticlib for the tests of its package.
    fn build() -> Self {
        let target = output_folder().parent().expect("cargo puts its folder for tests into the target folder");
        let mut cargo = Command::new(env!("CARGO"));
        // With what `cargo test` selects, which is the libraries of all packages and what tests and examples need, dependencies have the
        // same features as there: nothing but this library is compiled again.
        cargo
            .args(["build", "--quiet", "--lib", "--example", "stream_peer", "--target-dir"])
            .arg(target)
            .current_dir(repository());
        let folder = if cfg!(debug_assertions) {
            target.join("debug")
        } else {
            cargo.arg("--release");
            target.join("release")
        };
        run(&mut cargo);
        let soname = folder.join("liblongspan.so.0");
        if !soname.exists() {
            std::os::unix::fs::symlink("liblongspan.so", soname).expect("a link can be made beside the library");
        }
        Self { folder, system_libraries: system_libraries() }
    }

    /// Where both forms of the library are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    pub fn shared(&self) -> PathBuf {
        self.folder.join("liblongspan.so")
    }

    /// Compiles a host and returns the command that runs it.
    pub fn compile(&self, source: &Path, language: Language, linkage: Linkage) -> Command {
        let (compiler, standard, kind) = match language {
            Language::C99 => ("cc", "-std=c99", "c"),
            Language::Cpp11 => ("g++", "-std=c++11", "c++"),
            Language::Cpp17 => ("g++", "-std=c++17", "c++"),
        };
        // Tests run at the same time, and each needs its own program.
        static COUNT: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
        let number = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let name = source.file_stem().expect("a source has a name").to_string_lossy().into_owned();
        let program = output_folder().join(format!("{name}-{number}"));
        let mut command = Command::new(compiler);
        command.args(WARNINGS).args([standard, "-O1", "-Wl,--strip-debug", "-x", kind]).arg(source).args(["-x", "none", "-I"]);
        command.arg(repository().join("include"));
        match linkage {
            Linkage::Static => command.arg(self.folder.join("liblongspan.a")).args(&self.system_libraries),
            Linkage::Dynamic => command.arg(self.shared()).arg(format!("-Wl,-rpath,{}", self.folder.display())).arg("-lm"),
        };
        run(command.arg("-o").arg(&program));
        Command::new(program)
    }
}

/// As the compiler of Rust names them.
fn system_libraries() -> Vec<String> {
    let empty = output_folder().join("empty.rs");
    std::fs::write(&empty, "").expect("a temporary file can be written");
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let mut command = Command::new(rustc);
    command.args(["--crate-type", "staticlib", "--print", "native-static-libs", "--out-dir"]).arg(output_folder()).arg(empty);
    let output = command.output().expect("the compiler of Rust can be run");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let list = text.split_once("native-static-libs:").map(|(_, rest)| rest.lines().next().unwrap_or_default());
    list.unwrap_or_else(|| panic!("rustc names the libraries: {text}")).split_whitespace().map(str::to_owned).collect()
}
