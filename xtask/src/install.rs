//! The library with header, pkg-config file and CMake package, where a system or a host wants it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::library::Library;
use crate::platform::link;
use crate::{Outcome, repository};

/// Major, minor and patch version.
const VERSION: [&str; 3] = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")];

/// Number in the SONAME, that of `capi/build.rs`.
const ABI: &str = "0";

/// Installs into `prefix`; with `DESTDIR` set, files go below that, as packagers expect.
pub fn run(prefix: &str) -> Outcome<()> {
    let library = Library::build()?;
    let prefix = std::path::absolute(prefix)?;
    let root = match std::env::var_os("DESTDIR") {
        Some(folder) => Path::new(&folder).join(prefix.strip_prefix("/").unwrap_or(&prefix)),
        None => prefix.clone(),
    };
    install(&library, &prefix, &root)
}

/// Installs a library that was built into `root`, for use in `prefix`.
pub fn install(library: &Library, prefix: &Path, root: &Path) -> Outcome<()> {
    let folder = |name: &str| -> Outcome<PathBuf> {
        let folder = root.join(name);
        fs::create_dir_all(&folder)?;
        Ok(folder)
    };
    let (lib, include) = (folder("lib")?, folder("include/longspan")?);
    let (cmake, pkgconfig) = (folder("lib/cmake/longspan")?, folder("lib/pkgconfig")?);

    for header in fs::read_dir(repository().join("include/longspan"))? {
        let header = header?;
        fs::copy(header.path(), include.join(header.file_name()))?;
    }
    copy_stripped(&library.archive(), &lib.join("liblongspan.a"))?;
    let [major, minor, patch] = VERSION;
    let file = format!("liblongspan.so.{ABI}.{minor}.{patch}");
    copy_stripped(&library.folder.join("liblongspan.so"), &lib.join(&file))?;
    link(&file, &lib.join(format!("liblongspan.so.{ABI}")))?;
    link(&format!("liblongspan.so.{ABI}"), &lib.join("liblongspan.so"))?;

    let package = repository().join("capi/package");
    let version = VERSION.join(".");
    let filled = |name: &str| -> Outcome<String> {
        let text = fs::read_to_string(package.join(name))?;
        Ok(text.replace("@PREFIX@", &prefix.to_string_lossy()).replace("@VERSION@", &version).replace("@MAJOR@", major))
    };
    fs::write(pkgconfig.join("longspan.pc"), filled("longspan.pc.in")?)?;
    fs::write(cmake.join("longspanConfig.cmake"), filled("longspanConfig.cmake")?)?;
    fs::write(cmake.join("longspanConfigVersion.cmake"), filled("longspanConfigVersion.cmake.in")?)?;
    println!("installed longspan {version} into {}", root.display());
    Ok(())
}

/// Copies a library without its debugging information, if there is a tool that can do that.
fn copy_stripped(from: &Path, to: &Path) -> Outcome<()> {
    let stripped = Command::new("strip").arg("--strip-debug").arg("-o").arg(to).arg(from).status();
    if !stripped.is_ok_and(|status| status.success()) {
        fs::copy(from, to)?;
    }
    Ok(())
}
