//! The system's C and C++ compilers, called as strictly as the samples promise to stand.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::library::Library;
use crate::{Outcome, repository, succeed};

const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-pedantic", "-Werror"];

/// What a program needs besides `liblongspan.a`.
const SYSTEM_LIBRARIES: [&str; 3] = ["-lm", "-lpthread", "-ldl"];

/// A language, and what its compilers call one of its standards.
type Standard = (Language, &'static str);

/// Every standard that the header promises to stand, C23 by the name that it has in compilers from before it.
const STANDARDS: [Standard; 8] = [
    (Language::C99, "c99"),
    (Language::C99, "c11"),
    (Language::C99, "c17"),
    (Language::C99, "c2x"),
    (Language::Cpp11, "c++11"),
    (Language::Cpp11, "c++14"),
    (Language::Cpp11, "c++17"),
    (Language::Cpp11, "c++20"),
];

/// The same of the wrapper for C++.
const WRAPPER_STANDARDS: [Standard; 2] = [(Language::Cpp11, "c++17"), (Language::Cpp11, "c++20")];

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

    fn name(self) -> &'static str {
        match self {
            Self::C99 => "c",
            Self::Cpp11 => "c++",
        }
    }

    /// The compiler, and clang where there is one.
    fn compilers(self) -> Outcome<Vec<Command>> {
        let clang = if matches!(self, Self::C99) { "clang" } else { "clang++" };
        let second = Command::new(clang).arg("--version").output().is_ok().then(|| Command::new(clang));
        Ok([Some(self.compiler()?), second].into_iter().flatten().collect())
    }
}

/// Looks for warnings in the header at every standard, in the wrapper at those of its own, and in the samples at the last ones, with
/// every compiler that is there; returns how many times it has looked.
pub fn check_standards(samples: &[PathBuf]) -> Outcome<usize> {
    let header = [repository().join("include/longspan/longspan.h")];
    let wrapper = [repository().join("include/longspan/longspan.hpp")];
    let newest: Vec<_> = [STANDARDS[3], STANDARDS[7]].into_iter().collect();
    let looks: [(&[PathBuf], &[Standard]); 3] = [(&header, &STANDARDS), (&wrapper, &WRAPPER_STANDARDS), (samples, &newest)];
    let mut count = 0;
    for (sources, standards) in looks {
        for &(language, standard) in standards {
            for mut compiler in language.compilers()? {
                compiler.args(WARNINGS).arg(format!("-std={standard}")).args(["-fsyntax-only", "-I"]);
                compiler.arg(repository().join("include")).args(["-x", language.name()]).args(sources);
                succeed(&mut compiler)?;
                count += sources.len();
            }
        }
    }
    Ok(count)
}

/// Compiles one source, linked statically.
pub fn compile(source: &Path, program: &Path, language: Language, library: &Library) -> Outcome<()> {
    let mut command = language.compiler()?;
    command.args(WARNINGS).arg("-O2").args(language.arguments()).arg(source).args(["-x", "none", "-I"]);
    command.arg(repository().join("include")).arg(library.archive()).args(SYSTEM_LIBRARIES).arg("-o").arg(program);
    succeed(&mut command)
}
