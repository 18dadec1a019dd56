//! Every C sample, compiled both ways and run.

use std::path::PathBuf;
use std::process::Command;

use crate::compiler::{Language, check_standards, compile};
use crate::library::{Library, output_folder};
use crate::{Outcome, printed, repository};

pub fn run() -> Outcome<()> {
    let looks = check_standards(&sources()?)?;
    println!("header from C99 to C23 and C++11 to C++20, wrapper and samples: {looks} times no warning");
    let library = Library::build()?;
    let folder = output_folder("samples")?;
    for source in sources()? {
        for (language, name) in [(Language::C99, "C99"), (Language::Cpp11, "C++11")] {
            let program = folder.join(name_of(&source));
            compile(&source, &program, language, &library)?;
            let lines = printed(&mut Command::new(&program))?.lines().count();
            println!("{} as {name}: no warning, ran, printed {lines} lines", name_of(&source));
        }
    }
    Ok(())
}

/// The samples, in alphabetical order.
pub fn sources() -> Outcome<Vec<PathBuf>> {
    let files: Vec<PathBuf> = std::fs::read_dir(repository().join("examples_c"))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    let mut sources: Vec<PathBuf> = files.into_iter().filter(|file| file.extension().is_some_and(|end| end == "c")).collect();
    sources.sort();
    Ok(sources)
}

/// File name without its ending.
pub fn name_of(source: &std::path::Path) -> String {
    source.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
