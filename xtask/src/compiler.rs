//! The system's C and C++ compilers, called as strictly as the samples promise to stand.

use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;

use crate::library::Library;
use crate::{Outcome, repository, succeed};

const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-pedantic", "-Werror"];

/// What a program needs besides `liblongspan.a`.
const SYSTEM_LIBRARIES: [&str; 3] = ["-lm", "-lpthread", "-ldl"];

/// What a source is compiled as; every sample is both.
#[derive(Debug, Clone, Copy)]
pub enum Language {
    C99,
    Cpp11,
}

impl Language {
    /// The compiler's command line so far: `CC` or `CXX` if set, which may hold arguments too.
    pub fn compiler(self) -> Outcome<Command> {
        let (variable, usual, name) = match self {
            Self::C99 => ("CC", "cc", "C"),
            Self::Cpp11 => ("CXX", "c++", "C++"),
        };
        let chosen = std::env::var(variable).unwrap_or_default();
        let mut words = chosen.split_whitespace();
        let program = words.next().unwrap_or(usual);
        let mut command = Command::new(program);
        command.args(words);
        match Command::new(program).arg("--version").output() {
            Err(error) if error.kind() == ErrorKind::NotFound => Err(format!(
                "no {name} compiler: `{program}` is not there.\n\
                 On Debian and Ubuntu setup/install.sh installs one; elsewhere install one, or set {variable} to its name."
            )
            .into()),
            _ => Ok(command),
        }
    }

    fn arguments(self) -> [&'static str; 3] {
        match self {
            Self::C99 => ["-std=c99", "-x", "c"],
            Self::Cpp11 => ["-std=c++11", "-x", "c++"],
        }
    }
}

/// Compiles one source, linked statically.
pub fn compile(source: &Path, program: &Path, language: Language, library: &Library) -> Outcome<()> {
    let mut command = language.compiler()?;
    command.args(WARNINGS).arg("-O2").args(language.arguments()).arg(source).args(["-x", "none", "-I"]);
    command.arg(repository().join("include")).arg(library.archive()).args(SYSTEM_LIBRARIES).arg("-o").arg(program);
    succeed(&mut command)
}
