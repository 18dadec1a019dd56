//! What the documents say of the code is so: stages have the names that they are described by, and files are where links lead.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = repository().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The functions that the method beginning with `start` calls as statements, in order, and whose they are.
fn calls(source: &str, start: &str) -> Vec<String> {
    let source = read(source);
    let (_, rest) = source.split_once(start).unwrap_or_else(|| panic!("there is no `{start}`"));
    let body = rest.split("\n    }\n").next().unwrap_or_default();
    let statements = body.lines().filter_map(|line| {
        let (path, _) = line.trim().rsplit_once(" = ").map_or(line.trim(), |(_, value)| value).split_once('(')?;
        let is_path = path.chars().all(|letter| letter.is_alphanumeric() || "_.:".contains(letter));
        let is_stage = ["self.", "batch.", "contact_kernels::"].iter().any(|owner| path.starts_with(owner));
        (is_path && is_stage).then(|| path.trim_start_matches("self.").to_owned())
    });
    statements.collect()
}

/// The part of a document under this heading.
fn section<'a>(document: &'a str, heading: &str) -> &'a str {
    let (_, rest) = document.split_once(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("there is no section {heading}"));
    rest.split("\n## ").next().unwrap_or_default()
}

#[test]
fn every_stage_of_a_step_is_described_in_the_order_in_which_it_runs() {
    let document = read("docs/reference/architecture.md");
    let stages = section(&document, "The stages").lines().filter_map(|line| line.strip_prefix("### `")?.strip_suffix('`'));
    let stages: Vec<&str> = stages.collect();
    let called = calls("src/world.rs", "pub fn step(&mut self");
    assert!(called.len() > 5, "only {called:?} were found in `step`");
    assert_eq!(stages, called, "docs/reference/architecture.md describes the left, `step` in src/world.rs calls the right");
}

#[test]
fn every_stage_of_a_batch_that_is_described_exists() {
    let document = read("docs/reference/architecture.md");
    let parts = ["fn begin_step(", "fn take_substep(", "fn end_step(", "fn sweep_all("];
    let called = parts.map(|part| calls("src/solve/step.rs", part)).concat();
    let lines = section(&document, "A batch").lines().filter_map(|line| line.strip_prefix("    "));
    let described: Vec<&str> = lines.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "for").collect();
    assert!(described.len() > 5, "only {described:?} are described");
    let is_called = |name: &str| called.iter().any(|call| call == name || call.ends_with(&format!(".{name}")));
    let missing: Vec<&&str> = described.iter().filter(|name| !is_called(name)).collect();
    assert!(
        missing.is_empty(),
        "docs/reference/architecture.md names {missing:?}; the step of a batch in src/solve/step.rs calls {called:?}"
    );
}

/// Those of the project's root, and all of docs/ and of the folders' own.
fn documents() -> Vec<PathBuf> {
    let folders =
        ["", "docs", "docs/guide", "docs/reference", "docs/lab", "examples_c", "include", "setup", "tests", "benches", "bench"];
    let files = folders.iter().flat_map(|folder| {
        let folder = repository().join(folder);
        let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        entries.map(|entry| entry.expect("the folder can be listed").path())
    });
    files.filter(|file| file.extension().is_some_and(|ending| ending == "md")).collect()
}

#[test]
fn links_and_sources_named_in_the_documents_exist() {
    let (mut seen, mut broken) = (0, BTreeSet::new());
    for document in documents() {
        let text = std::fs::read_to_string(&document).expect("a document can be read");
        let folder = document.parent().expect("a document lies in a folder");
        let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        let links = links.filter(|link| !link.is_empty() && !link.contains("://")).map(|link| folder.join(link));
        let words = text.split(|letter: char| letter.is_whitespace() || "`*,;()".contains(letter));
        let sources =
            words.filter(|word| ["src/", "capi/", "examples_c/", "include/"].iter().any(|start| word.starts_with(start)));
        // Notes of the lab keep the names that files had.
        let sources = sources
            .filter(|_| !document.starts_with(repository().join("docs/lab")))
            .map(|word| repository().join(word.trim_end_matches(['.', ':'])));
        for file in links.chain(sources) {
            seen += 1;
            if !file.exists() {
                broken.insert(format!("{}: {}", document.display(), file.display()));
            }
        }
    }
    assert!(seen > 30, "only {seen} files are named");
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Documents on one shelf of docs/.
fn shelf(name: &str) -> Vec<(PathBuf, String)> {
    let folder = repository().join("docs").join(name);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("the folder can be listed").path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "md"));
    files.sort();
    let read = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).expect("a document can be read");
        (file, text)
    };
    files.into_iter().map(read).collect()
}

/// Most words of the reference: an hour of reading. What was tried and measured goes into docs/lab.
const MAX_WORDS: usize = 12_000;

#[test]
fn the_reference_can_be_read_in_an_hour() {
    let mut words = 0;
    for (_, text) in shelf("reference") {
        // Tables of bytes and of hashes are looked up, not read.
        let parts = text.split("<!-- tables begin -->").enumerate();
        let prose = parts.filter_map(|(index, part)| {
            if index == 0 { Some(part) } else { part.split_once("<!-- tables end -->").map(|(_, after)| after) }
        });
        let is_word = |word: &&str| word.chars().any(char::is_alphanumeric);
        words += prose.flat_map(str::split_whitespace).filter(is_word).count();
    }
    assert!((5_000..=MAX_WORDS).contains(&words), "docs/reference has {words} words, may have {MAX_WORDS}");
}

/// Every file of the library's source, as text.
fn sources(folder: &Path, into: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("the source is there") {
        let path = entry.expect("the source can be listed").path();
        if path.is_dir() {
            sources(&path, into);
        } else {
            into.push(std::fs::read_to_string(&path).expect("the source is text"));
        }
    }
}

/// A number as it stands in the source or in a document.
fn number(text: &str) -> Option<f64> {
    text.replace('_', "").parse().ok()
}

#[test]
fn constants_have_the_values_that_the_reference_gives() {
    let mut source = Vec::new();
    sources(&repository().join("src"), &mut source);
    let (mut seen, mut wrong) = (0, Vec::new());
    for (file, text) in shelf("reference") {
        // As in (`NAME` = 0.2).
        for (before, after) in text.match_indices("` = ").map(|(at, mark)| (&text[..at], &text[at + mark.len()..])) {
            let name = before.rsplit('`').next().unwrap_or_default();
            if name.is_empty() || !name.chars().all(|letter| letter.is_ascii_uppercase() || letter == '_') {
                continue;
            }
            let end =
                after.find(|letter: char| !(letter.is_ascii_alphanumeric() || ".-".contains(letter))).unwrap_or(after.len());
            let value =
                number(after[..end].trim_end_matches('.')).unwrap_or_else(|| panic!("{name} in {} has no value", file.display()));
            seen += 1;
            let definition = format!("const {name}: ");
            let found: Vec<&str> = (source.iter())
                .flat_map(|text| text.split(definition.as_str()).skip(1))
                .filter_map(|rest| rest.split(';').next()?.split(" = ").nth(1))
                .collect();
            if !found.iter().any(|text| number(text) == Some(value)) {
                wrong.push(format!("{}: {name} is said to be {value}, the source has {found:?}", file.display()));
            }
        }
    }
    assert!(seen > 40, "only {seen} constants are named");
    assert!(wrong.is_empty(), "{wrong:#?}");
}
