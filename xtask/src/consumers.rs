//! Every way to take the library, tried from a clean folder: pkg-config, an installed CMake package, a part of a CMake build.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::library::{Library, output_folder};
use crate::{Outcome, install, printed, repository};

pub fn run() -> Outcome<()> {
    let library = Library::build()?;
    let folder = output_folder("consumers")?;
    fs::remove_dir_all(&folder)?;
    let prefix = folder.join("prefix");
    install::install(&library, &install::Wish::default(), &prefix, &prefix)?;
    let consumers = repository().join("tests/consumers");

    let build = clean(folder.join("pkg_config"))?;
    let mut script = Command::new(consumers.join("pkg_config/build.sh"));
    script.arg(build).env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
    print!("pkg-config, shared and static:\n{}", printed(&mut script)?);

    let prefix_path = format!("-DCMAKE_PREFIX_PATH={}", prefix.display());
    cmake("find_package", &consumers, &folder, &prefix_path)?;
    // The library is built as part of the host's build; where cargo has built it already is no different but quicker.
    let target = library.folder.parent().ok_or("the library lies in a folder of the target folder")?;
    cmake("add_subdirectory", &consumers, &folder, &format!("-DLONGSPAN_TARGET_DIR={}", target.display()))
}

/// Configures, builds and tests a consumer.
fn cmake(name: &str, consumers: &Path, folder: &Path, option: &str) -> Outcome<()> {
    let build = clean(folder.join(name))?;
    printed(Command::new("cmake").arg("-S").arg(consumers.join(name)).arg("-B").arg(&build).arg(option))?;
    printed(Command::new("cmake").arg("--build").arg(&build))?;
    let output = printed(Command::new("ctest").args(["--verbose", "--test-dir"]).arg(&build))?;
    println!("CMake, {name}:");
    let lines: Vec<&str> = output.lines().filter(|line| line.contains("the ball is at")).collect();
    if lines.len() != 2 {
        return Err(format!("{name}: not both kinds ran\n{output}").into());
    }
    lines.iter().for_each(|line| println!("{line}"));
    Ok(())
}

fn clean(folder: PathBuf) -> Outcome<PathBuf> {
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    Ok(folder)
}
