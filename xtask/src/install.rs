//! The library with header, pkg-config files, CMake package and licences, where a system or a host wants it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::library::Library;
use crate::platform::link;
use crate::{Outcome, notices, repository};

/// Major, minor and patch version.
const VERSION: [&str; 3] = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")];

/// Number in the SONAME, that of `capi/build.rs`.
const ABI: &str = "0";

/// What is installed, as the words of the command say.
#[derive(Default)]
pub struct Wish {
    prefix: Option<PathBuf>,
    /// Another platform than this one.
    pub target: Option<String>,
    pub features: Option<String>,
    /// Whether a profile of scenes says how code is laid out.
    pub by_profile: bool,
}

impl Wish {
    fn parse(words: &[&str]) -> Outcome<Self> {
        let (mut wish, mut words) = (Self::default(), words.iter());
        while let Some(&word) = words.next() {
            let mut value = || words.next().map(|&value| value.to_owned()).ok_or(format!("{word} needs a value"));
            match word {
                "--target" => wish.target = Some(value()?),
                "--features" => wish.features = Some(value()?),
                "--pgo" => wish.by_profile = true,
                prefix if wish.prefix.is_none() && !prefix.starts_with('-') => wish.prefix = Some(std::path::absolute(prefix)?),
                other => {
                    return Err(format!("install PREFIX [--target TRIPLE] [--features stream] [--pgo]; what is {other}?").into());
                }
            }
        }
        if wish.by_profile && wish.target.is_some() {
            return Err("--pgo runs scenes on this platform: leave --target out".into());
        }
        Ok(wish)
    }
}

/// Installs into the prefix; with `DESTDIR` set, files go below that, as packagers expect.
pub fn run(words: &[&str]) -> Outcome<()> {
    let wish = Wish::parse(words)?;
    let prefix = wish.prefix.clone().ok_or("install where? name a prefix")?;
    let library = Library::build_for(&wish)?;
    let root = match std::env::var_os("DESTDIR") {
        Some(folder) => Path::new(&folder).join(prefix.strip_prefix("/").unwrap_or(&prefix)),
        None => prefix.clone(),
    };
    install(&library, &wish, &prefix, &root)
}

/// What the files of the library are called on a platform.
struct Names {
    /// As cargo writes it, and where it goes.
    shared: (&'static str, String),
    /// What a program is linked with that uses a DLL.
    import: Option<&'static str>,
    archive: &'static str,
    /// What an archive needs besides, as linkers are told, and as CMake is.
    system: (&'static str, &'static str),
}

impl Names {
    fn of(target: &str) -> Self {
        let [_, minor, patch] = VERSION;
        const WINDOWS: [&str; 2] = ["-lkernel32 -lntdll -luserenv -lws2_32 -ldbghelp", "kernel32;ntdll;userenv;ws2_32;dbghelp"];
        const UNIX: [&str; 2] = ["-lm -lpthread -ldl", "Threads::Threads;${CMAKE_DL_LIBS};m"];
        if target.contains("windows") {
            let is_msvc = target.contains("msvc");
            return Self {
                shared: ("longspan.dll", "bin/longspan.dll".into()),
                import: Some(if is_msvc { "longspan.dll.lib" } else { "liblongspan.dll.a" }),
                archive: if is_msvc { "longspan.lib" } else { "liblongspan.a" },
                system: (WINDOWS[0], WINDOWS[1]),
            };
        }
        let shared = if target.contains("apple") {
            ("liblongspan.dylib", format!("lib/liblongspan.{ABI}.dylib"))
        } else {
            ("liblongspan.so", format!("lib/liblongspan.so.{ABI}.{minor}.{patch}"))
        };
        Self { shared, import: None, archive: "liblongspan.a", system: (UNIX[0], UNIX[1]) }
    }
}

/// Installs a library that was built into `root`, for use in `prefix`.
pub fn install(library: &Library, wish: &Wish, prefix: &Path, root: &Path) -> Outcome<()> {
    let target = wish.target.as_deref().unwrap_or(env!("LONGSPAN_HOST"));
    let names = Names::of(target);
    let folder = |name: &str| -> Outcome<PathBuf> {
        let folder = root.join(name);
        fs::create_dir_all(&folder)?;
        Ok(folder)
    };
    let (lib, include) = (folder("lib")?, folder("include/longspan")?);
    for header in fs::read_dir(repository().join("include/longspan"))? {
        let header = header?;
        fs::copy(header.path(), include.join(header.file_name()))?;
    }
    copy_stripped(target, &library.folder.join(names.archive), &lib.join(names.archive))?;
    if let Some(import) = names.import {
        fs::copy(library.folder.join(import), lib.join(import))?;
        folder("bin")?;
    }
    let shared = root.join(&names.shared.1);
    copy_stripped(target, &library.folder.join(names.shared.0), &shared)?;
    match names.shared.0 {
        "liblongspan.so" => {
            let file = shared.file_name().unwrap_or_default().to_string_lossy();
            link(&file, &lib.join(format!("liblongspan.so.{ABI}")))?;
            link(&format!("liblongspan.so.{ABI}"), &lib.join("liblongspan.so"))?;
        }
        "liblongspan.dylib" => link(&format!("liblongspan.{ABI}.dylib"), &lib.join("liblongspan.dylib"))?,
        _ => {}
    }
    let texts = folder("share/doc/longspan")?;
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        fs::copy(repository().join(licence), texts.join(licence))?;
    }
    fs::write(texts.join("THIRD-PARTY.txt"), notices::text(wish)?)?;
    write_packages(&names, prefix, &folder("lib/pkgconfig")?, &folder("lib/cmake/longspan")?)?;
    println!("installed longspan {} for {target} into {}", VERSION.join("."), root.display());
    Ok(())
}

/// The files by which pkg-config and CMake find the library.
fn write_packages(names: &Names, prefix: &Path, pkgconfig: &Path, cmake: &Path) -> Outcome<()> {
    let import =
        names.import.map_or(String::new(), |import| format!("\n        IMPORTED_IMPLIB \"${{_longspan_prefix}}/lib/{import}\""));
    let words = [
        ("@PREFIX@", prefix.to_string_lossy().into_owned()),
        ("@VERSION@", VERSION.join(".")),
        ("@MAJOR@", VERSION[0].to_owned()),
        ("@SHARED@", names.shared.1.clone()),
        ("@IMPORT@", import),
        ("@ARCHIVE@", names.archive.to_owned()),
        ("@SYSTEM@", names.system.0.to_owned()),
        ("@CMAKE_SYSTEM@", names.system.1.to_owned()),
    ];
    let package = repository().join("capi/package");
    for (from, to) in [
        ("longspan.pc.in", pkgconfig.join("longspan.pc")),
        ("longspan-static.pc.in", pkgconfig.join("longspan-static.pc")),
        ("longspanConfig.cmake.in", cmake.join("longspanConfig.cmake")),
        ("longspanConfigVersion.cmake.in", cmake.join("longspanConfigVersion.cmake")),
    ] {
        let text = fs::read_to_string(package.join(from))?;
        fs::write(to, words.iter().fold(text, |text, (word, value)| text.replace(word, value)))?;
    }
    Ok(())
}

/// Copies a library without its debugging information, if there is a tool that can do that.
fn copy_stripped(target: &str, from: &Path, to: &Path) -> Outcome<()> {
    let tool = match target {
        "aarch64-unknown-linux-gnu" => "aarch64-linux-gnu-strip",
        "x86_64-pc-windows-gnu" => "x86_64-w64-mingw32-strip",
        _ => "strip",
    };
    let stripped = Command::new(tool).arg("--strip-debug").arg("-o").arg(to).arg(from).status();
    if !stripped.is_ok_and(|status| status.success()) {
        fs::copy(from, to)?;
    }
    Ok(())
}
