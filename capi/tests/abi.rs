//! Hosts that were compiled against another version's header run on this library.

mod common;
#[allow(dead_code, reason = "each test program uses a part of this")]
#[path = "header/interface.rs"]
mod interface;

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use common::{LIBRARY, output_folder, repository, run};
use interface::Interface;

fn header() -> String {
    fs::read_to_string(repository().join("include/longspan/longspan.h")).expect("the header is there")
}

fn abi(name: &str) -> PathBuf {
    repository().join("capi/abi").join(name)
}

/// Compiles a host against a header of its own and runs it on the shared library of now.
fn run_with_header(name: &str, header: &str, source: &std::path::Path) -> String {
    let folder = output_folder().join(name);
    fs::create_dir_all(folder.join("longspan")).expect("a folder can be made");
    fs::write(folder.join("longspan/longspan.h"), header).expect("a header can be written");
    let program = folder.join("host");
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-I"]).arg(&folder).arg(source).arg(LIBRARY.shared());
    run(compiler.arg(format!("-Wl,-rpath,{}", LIBRARY.folder().display())).arg("-lm").arg("-o").arg(&program));
    run(&mut Command::new(program))
}

fn sample(name: &str) -> PathBuf {
    repository().join("examples_c").join(name)
}

#[test]
fn a_host_compiled_for_the_previous_version_runs_on_this_one() {
    let previous = fs::read_to_string(abi("longspan-0.1.0.h")).expect("the previous header is kept");
    assert!(Interface::of_header(&previous).broken_by(&Interface::of_header(&header())).is_empty());
    for name in ["hello.c", "bulk.c"] {
        let (old, new) =
            (run_with_header("previous", &previous, &sample(name)), run_with_header("present", &header(), &sample(name)));
        assert!(old == new && !old.is_empty(), "{name}: {old}\n{new}");
    }
}

#[test]
fn a_host_compiled_for_a_later_version_runs_on_this_one() {
    let (mut later, now) = (header(), Interface::of_header(&header()));
    let growing: Vec<&String> = now.structs.iter().filter(|(_, fields)| fields.grows).map(|(name, _)| name).collect();
    for name in &growing {
        later = later.replacen(&format!("}} {name};"), &format!("    double added[5];\n}} {name};"), 1);
    }
    assert!(growing.len() >= 7 && later.matches("added[5]").count() == growing.len(), "{growing:?}");
    for name in ["hello.c", "bulk.c", "edit.c", "queries.c"] {
        let (old, new) =
            (run_with_header("present-2", &header(), &sample(name)), run_with_header("later", &later, &sample(name)));
        assert!(old == new && !old.is_empty(), "{name}: {old}\n{new}");
    }
}
