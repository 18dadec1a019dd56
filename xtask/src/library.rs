//! The library as cargo builds it, and where cargo puts things.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tinyjson::{InnerAsRef, JsonValue};

use crate::install::Wish;
use crate::platforms::Toolchain;
use crate::{Outcome, pgo, platform, printed, repository, succeed};

/// A build of `longspan-capi`.
pub struct Library {
    /// The folder of `liblongspan.a` and `liblongspan.so`.
    pub folder: PathBuf,
}

/// Cargo, as it was called, in the repository.
pub fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(repository());
    command
}

impl Library {
    /// Builds the library, and asks cargo where it went: the folder depends on settings that are the user's.
    pub fn build() -> Outcome<Self> {
        Self::build_by(&["--release", "--package", "longspan-capi"])
    }

    /// The library as somebody wants it installed.
    pub fn build_for(wish: &Wish) -> Outcome<Self> {
        let mut words = vec!["--release", "--package", "longspan-capi"];
        words.extend(wish.features.iter().flat_map(|features| ["--features", features]));
        match &wish.target {
            None if wish.by_profile => Self::build_with(pgo::cargo_with_profile()?, &words),
            None => Self::build_by(&words),
            Some(target) => {
                let toolchain = Toolchain::get(target)?;
                println!("building the library for {target}");
                succeed(toolchain.build()?.args(words))?;
                Ok(Self { folder: toolchain.folder("release")? })
            }
        }
    }

    /// The same with streams.
    pub fn build_with_streams() -> Outcome<Self> {
        Self::build_by(&["--release", "--package", "longspan-capi", "--features", "stream"])
    }

    /// Builds the library with streams as `cargo test` would, and an example beside it. Cargo is told the same packages and profile,
    /// so it gives iceoryx2, and all else, the same features: what the tests have is not compiled again.
    pub fn build_beside_tests(example: &str) -> Outcome<Self> {
        Self::build_by(&["--lib", "--features", "longspan-capi/stream", "--example", example])
    }

    fn build_by(arguments: &[&str]) -> Outcome<Self> {
        Self::build_with(cargo(), arguments)
    }

    fn build_with(mut command: Command, arguments: &[&str]) -> Outcome<Self> {
        println!("building the library: cargo build {}", arguments.join(" "));
        command.args(["build", "--message-format", "json-render-diagnostics"]).args(arguments);
        let messages = printed(command.stderr(Stdio::inherit()))?;
        let folder = folder_of_static_library(&messages).ok_or("cargo says nothing of liblongspan.a")?;
        let library = Self { folder };
        library.link_soname()?;
        Ok(library)
    }

    /// The static library.
    pub fn archive(&self) -> PathBuf {
        self.folder.join("liblongspan.a")
    }

    /// Programs look for the shared library by its SONAME; cargo does not write a file of that name.
    fn link_soname(&self) -> Outcome<()> {
        let soname = self.folder.join("liblongspan.so.0");
        if soname.exists() || !self.folder.join("liblongspan.so").exists() {
            Ok(())
        } else {
            platform::link("liblongspan.so", &soname)
        }
    }
}

/// A folder of cargo's target folder for what a command writes, made if need be.
pub fn output_folder(name: &str) -> Outcome<PathBuf> {
    let folder = target_folder()?.join(name);
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// Where cargo puts what it builds with `--release`.
pub fn release_folder() -> Outcome<PathBuf> {
    Ok(target_folder()?.join("release"))
}

fn target_folder() -> Outcome<PathBuf> {
    let metadata = printed(cargo().args(["metadata", "--format-version", "1", "--no-deps"]))?;
    let metadata: JsonValue = metadata.parse()?;
    let target = field::<String>(&metadata, "target_directory").ok_or("cargo does not say where its target folder is")?;
    Ok(Path::new(target).to_owned())
}

/// Cargo's messages are JSON, one a line; the one of an artifact names its files.
fn folder_of_static_library(messages: &str) -> Option<PathBuf> {
    let messages = messages.lines().filter_map(|line| line.parse::<JsonValue>().ok());
    let files = messages.filter_map(|message| field::<Vec<JsonValue>>(&message, "filenames").cloned()).flatten();
    let archive =
        files.filter_map(|file| file.get::<String>().map(PathBuf::from)).find(|file| file.ends_with("liblongspan.a"))?;
    archive.parent().map(Path::to_owned)
}

/// A field of a JSON object, if it is there and of this type.
pub fn field<'a, T: InnerAsRef>(object: &'a JsonValue, name: &str) -> Option<&'a T> {
    object.get::<HashMap<String, JsonValue>>()?.get(name)?.get()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_is_found_wherever_cargo_put_it() {
        let messages = r#"{"reason":"compiler-artifact","filenames":["/t/release/libglam.rlib"]}
not a message
{"reason":"build-script-executed"}
{"reason":"compiler-artifact","filenames":["/t/x86_64/release/liblongspan.so","/t/x86_64/release/liblongspan.a"]}"#;
        assert_eq!(folder_of_static_library(messages), Some(PathBuf::from("/t/x86_64/release")));
    }
}
