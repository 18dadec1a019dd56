//! What makes the bits the same on every platform: the table of state hashes, and where code may ask what it is compiled for.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use longspan_scenes::CATALOGUE;
use longspan_scenes::bits::{blessed, rows};

const TABLE: &str = "docs/reference/platforms.md";

/// Files that may ask: one for each crate, and a build script that asks of the machine it runs on.
const MAY_ASK: [&str; 5] =
    ["src/platform/", "capi/src/platform.rs", "scenes/src/platform.rs", "stream/src/platform.rs", "xtask/src/platform.rs"];

/// What asks.
const QUESTIONS: [&str; 9] = [
    "target_arch",
    "target_os",
    "target_family",
    "target_env",
    "target_pointer_width",
    "is_x86_feature_detected",
    "cfg(unix)",
    "cfg(windows)",
    "target_feature",
];

/// Functions that the system's C library computes, each system's a little otherwise; those of `libm` are the same on all.
const SYSTEMS_OWN: [&str; 18] = [
    ".sin()",
    ".cos()",
    ".tan()",
    ".sin_cos()",
    ".asin()",
    ".acos()",
    ".atan()",
    ".atan2(",
    ".hypot(",
    ".exp()",
    ".exp2()",
    ".ln()",
    ".log2()",
    ".log10()",
    ".powf(",
    ".cbrt()",
    ".sinh()",
    ".mul_add(",
];

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn table() -> String {
    fs::read_to_string(repository().join(TABLE)).expect("the table is there")
}

#[test]
fn every_scene_ends_with_the_hash_of_the_table() {
    let found = blessed(&table()).expect("every scene runs");
    if std::env::var_os("LONGSPAN_BLESS").is_some() {
        return write(&found);
    }
    let known = rows(&table());
    assert_eq!(known.len(), found.len(), "a scene has no row in {TABLE}; write it with LONGSPAN_BLESS=1");
    let differ: Vec<String> =
        known.iter().zip(&found).filter(|(known, found)| known != found).map(|(_, found)| found.to_string()).collect();
    assert!(
        differ.is_empty(),
        "{} of {} rows differ from {TABLE}; if the change is meant, write it anew with LONGSPAN_BLESS=1, and say so in the commit:\n{}",
        differ.len(),
        known.len(),
        differ.join("\n")
    );
}

/// Writes the rows in place of those that are there.
fn write(found: &[longspan_scenes::bits::Row]) {
    let text = table();
    let kept: Vec<&str> = text.lines().filter(|line| !line.starts_with("| `")).collect();
    let rows: Vec<String> = found.iter().map(ToString::to_string).collect();
    let at = kept.iter().position(|line| line.starts_with("|---")).expect("the table has a head") + 1;
    let lines = kept[..at].iter().copied().chain(rows.iter().map(String::as_str)).chain(kept[at..].iter().copied());
    fs::write(repository().join(TABLE), lines.flat_map(|line| [line, "\n"]).collect::<String>())
        .expect("the table can be written");
}

#[test]
fn every_scene_has_a_row_and_rows_differ() {
    let rows = rows(&table());
    for entry in CATALOGUE {
        assert!(rows.iter().any(|row| row.scene == entry.name), "{} has no row in {TABLE}", entry.name);
    }
    let mut names: Vec<String> = rows.iter().map(|row| row.name()).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), rows.len(), "rows of one name");
}

/// Sources below a folder, with their paths in the repository.
fn sources(folder: &str) -> Vec<(String, String)> {
    let mut waiting = vec![repository().join(folder)];
    let mut found = Vec::new();
    while let Some(folder) = waiting.pop() {
        let entries: Vec<PathBuf> =
            fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
        for path in entries {
            if path.is_dir() {
                waiting.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                let name = path.strip_prefix(repository()).expect("inside").to_string_lossy().replace('\\', "/");
                found.push((name, fs::read_to_string(&path).expect("a source")));
            }
        }
    }
    assert!(!found.is_empty(), "{folder} has no sources");
    found
}

#[test]
fn code_asks_for_its_platform_in_one_place_a_crate() {
    for folder in ["src", "capi/src", "scenes/src", "stream/src", "xtask/src", "bits/src", "viewer/src", "bench/src"] {
        for (name, text) in sources(folder).iter().filter(|(name, _)| !MAY_ASK.iter().any(|place| name.starts_with(place))) {
            for (number, line) in text.lines().enumerate() {
                let asks = QUESTIONS.iter().find(|question| line.contains(*question));
                assert!(asks.is_none(), "{name}:{}: {line}\nask in one of {MAY_ASK:?}", number + 1);
            }
        }
    }
}

#[test]
fn the_library_computes_no_function_by_the_systems_own_library() {
    for (name, text) in sources("src").iter().filter(|(name, _)| !name.ends_with("tests.rs") && !name.contains("/tests/")) {
        let own = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        for (number, line) in own.lines().enumerate() {
            let found = SYSTEMS_OWN.iter().find(|function| line.contains(*function));
            assert!(found.is_none(), "{name}:{}: {line}\nuse libm's", number + 1);
        }
    }
}
