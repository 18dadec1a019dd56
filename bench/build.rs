//! Compiles the peer engines that are written in C and C++, from the sources that crates of the lock file carry.
//!
//! Both are built as their own release builds would be, whatever profile cargo runs in: a peer with its assertions on or its
//! optimiser off would make every comparison worthless.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    #[cfg(feature = "peer-box3d")]
    box3d::build();
    #[cfg(feature = "peer-jolt")]
    jolt::build();
}

#[cfg(any(feature = "peer-box3d", feature = "peer-jolt"))]
mod sources {
    use std::path::{Path, PathBuf};
    use std::process::Command;

    /// Directory of the crate `name` as the lock file pins it, downloaded if need be.
    pub fn of_crate(name: &str) -> PathBuf {
        let cargo = std::env::var_os("CARGO").expect("cargo sets it for build scripts");
        let output = Command::new(cargo)
            .args(["metadata", "--format-version=1", "--all-features", "--locked"])
            .output()
            .expect("cargo can be started");
        assert!(output.status.success(), "cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
        let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON");
        let packages = metadata["packages"].as_array().expect("the format's version 1 has packages");
        let package = packages.iter().find(|package| package["name"] == name).unwrap_or_else(|| panic!("{name} is not locked"));
        let manifest = package["manifest_path"].as_str().expect("every package has a manifest");
        Path::new(manifest).parent().expect("a manifest lies in a directory").to_path_buf()
    }

    /// All files under `directory` whose name ends in `.extension`, in a fixed order.
    pub fn files(directory: &Path, extension: &str) -> Vec<PathBuf> {
        let mut found = Vec::new();
        for entry in std::fs::read_dir(directory).expect("the crate's sources are there") {
            let path = entry.expect("the directory can be listed").path();
            if path.is_dir() {
                found.extend(files(&path, extension));
            } else if path.extension().is_some_and(|end| end == extension) {
                found.push(path);
            }
        }
        found.sort();
        found
    }
}

#[cfg(feature = "peer-box3d")]
mod box3d {
    use crate::sources;

    /// The bindings crate would leave assertions on. It links a library `box3d` by name, so this one only has to be found.
    pub fn build() {
        let root = sources::of_crate("boxddd-sys").join("third-party/box3d");
        let mut build = cc::Build::new();
        build.include(root.join("include")).include(root.join("src")).files(sources::files(&root.join("src"), "c"));
        build.std("c17").opt_level(3).debug(false).define("NDEBUG", None).define("_POSIX_C_SOURCE", "199309L");
        build.flag_if_supported("-ffp-contract=off").flag_if_supported("-pthread").warnings(false);
        build.compile("box3d");
    }
}

#[cfg(feature = "peer-jolt")]
mod jolt {
    use crate::sources;

    /// Jolt and the shim in one library, with the definitions of Jolt's `Distribution` configuration.
    pub fn build() {
        println!("cargo::rerun-if-changed=src/peers/jolt_shim.h");
        println!("cargo::rerun-if-changed=src/peers/jolt_shim.cpp");
        let root = sources::of_crate("joltc-sys").join("JoltC/JoltPhysics");
        let mut build = cc::Build::new();
        build.cpp(true).include(&root).files(sources::files(&root.join("Jolt"), "cpp")).file("src/peers/jolt_shim.cpp");
        build.std("c++17").opt_level(3).debug(false).define("NDEBUG", None);
        build.flag_if_supported("-ffp-contract=off").flag_if_supported("-fno-rtti").flag_if_supported("-fno-exceptions");
        build.flag_if_supported("-pthread").warnings(false);
        instruction_set(&mut build);
        build.compile("longspan_jolt");
    }

    /// What Jolt's own build asks for by default, where the machine that builds has it; the benchmark runs where it is built.
    fn instruction_set(build: &mut cc::Build) {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
            for flag in ["-mavx2", "-mbmi", "-mpopcnt", "-mlzcnt", "-mf16c", "-mfma", "-mfpmath=sse"] {
                build.flag_if_supported(flag);
            }
            for name in ["AVX2", "AVX", "SSE4_1", "SSE4_2", "LZCNT", "TZCNT", "F16C", "FMADD"] {
                build.define(&format!("JPH_USE_{name}"), None);
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = build;
    }
}
