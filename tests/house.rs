//! The layout of the source: imports point down, nothing goes in circles, files, functions and structs are of a size to be read.
//!
//! The rule on fields of structs has a list of the exceptions of today, in `tests/house/`. It only gets shorter: what is not on it fails,
//! and so does what is on it without need. All other rules have no exceptions.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Modules of `src/` by floor, the lowest first. A module may use those of its own floor and of lower ones.
const FLOORS: &[&[&str]] = &[
    // Ground: no physics.
    &[
        "load_distribution",
        "check",
        "dwell_time",
        "error",
        "id",
        "island",
        "lanes",
        "linalg",
        "platform",
        "pose",
        "prefetch",
        "speed_limits",
        "tight_vec",
        "tuning",
        "workers",
    ],
    // What a user defines, and what a step reports.
    &[
        "body",
        "contact",
        "debug",
        "fracture",
        "hull",
        "joint",
        "joint_drive",
        "joint_rebounds",
        "joint_record",
        "kinematic_path",
        "long_range",
        "mass",
        "material",
        "motor",
        "report",
        "settings",
        "shape",
        "step_history",
        "surface",
    ],
    // Contacts, questions, and what follows from the graph of joints.
    &["collide", "query", "joint_graph"],
    &["solve"],
    &["snapshot"],
    &["world"],
    &["record"],
];

/// Most lines of a file, of a function, and most fields of a struct of the solver or the world.
const MAX_LINES: usize = 500;
const MAX_LINES_OF_A_FUNCTION: usize = 80;
const MAX_FIELDS: usize = 20;

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All files of Rust in a folder of the repository, by their path in it.
fn sources(folder: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![repository().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.expect("the folder can be listed").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let name = path.strip_prefix(repository()).expect("it lies in the repository");
                found.insert(name.to_string_lossy().replace('\\', "/"), read(&path));
            }
        }
    }
    found
}

/// The exceptions to a rule, one a line; what follows a `#` is a remark.
fn exceptions(list: &str) -> BTreeSet<String> {
    let text = read(&repository().join("tests/house").join(list));
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    lines.filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

/// The source without its tests, comments and texts.
fn code(source: &str) -> String {
    let source = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let mut skips = false;
    let mut code = String::new();
    for line in source.lines() {
        if line.trim() == "#[cfg(test)]" {
            skips = true;
            continue;
        }
        if !skips {
            let line = line.split("//").next().unwrap_or_default();
            let texts = line.split('"').enumerate().filter(|(index, _)| index % 2 == 0);
            code.extend(texts.map(|(_, part)| part));
            code.push('\n');
        }
        skips = skips && line.trim_start().starts_with("#[");
    }
    code
}

/// Paths that a tree of imports stands for, `a::{b, c::d}` being `a::b` and `a::c::d`.
fn expand(tree: &str) -> Vec<String> {
    let Some((start, rest)) = tree.split_once('{') else { return vec![tree.trim().to_owned()] };
    let inner = rest.rsplit_once('}').map_or(rest, |(inner, _)| inner);
    let (mut depth, mut from, mut branches) = (0, 0, Vec::new());
    for (at, letter) in inner.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                branches.push(&inner[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    branches.push(&inner[from..]);
    let named = branches.into_iter().map(str::trim).filter(|branch| !branch.is_empty());
    named.flat_map(|branch| expand(&format!("{}{branch}", start.trim()))).collect()
}

/// Module of a file: `src/solve/joint/mod.rs` is `solve::joint`.
fn module(file: &str) -> Vec<String> {
    let path = file.trim_start_matches("src/").trim_end_matches(".rs").trim_end_matches("/mod");
    if path == "lib" { Vec::new() } else { path.split('/').map(str::to_owned).collect() }
}

/// Which modules each one names in its code, tests left out. A folder's `mod.rs` is its front: that it uses what it consists of is left out too.
fn imports() -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let files = sources("src");
    let modules: BTreeSet<Vec<String>> = files.keys().map(|file| module(file)).collect();
    let mut imports = BTreeMap::new();
    for (file, source) in files.iter().filter(|(file, _)| !file.contains("tests")) {
        let own = module(file);
        let code = code(source);
        let statements = code.split("use ").skip(1).filter_map(|rest| rest.split(';').next());
        let trees = statements.filter(|tree| ["crate::", "super::", "self::"].iter().any(|start| tree.starts_with(start)));
        let is_path = |letter: char| letter.is_alphanumeric() || "_:".contains(letter);
        let words = code.split(|letter: char| !is_path(letter)).map(str::to_owned);
        let words = words.filter(|word| word.starts_with("crate::") || word.starts_with("super::"));
        let mut named = BTreeSet::new();
        for path in trees.flat_map(expand).chain(words) {
            let mut at = own.clone();
            for (index, part) in path.split("::").map(|part| part.split_whitespace().next().unwrap_or_default()).enumerate() {
                match part {
                    "crate" if index == 0 => at.clear(),
                    "super" => drop(at.pop()),
                    "self" => {}
                    part => {
                        at.push(part.to_owned());
                        if !modules.contains(&at) {
                            at.pop();
                            break;
                        }
                    }
                }
            }
            if !at.is_empty() && at != own {
                named.insert(at);
            }
        }
        imports.insert(own, named);
    }
    imports
}

#[test]
fn modules_use_their_own_floor_and_lower_ones() {
    let floor = |module: &[String]| FLOORS.iter().position(|floor| floor.contains(&module[0].as_str()));
    let mut up = BTreeSet::new();
    let imports = imports();
    for (module, named) in imports.iter().filter(|(module, _)| !module.is_empty()) {
        let own = floor(module).unwrap_or_else(|| panic!("{module:?} stands on no floor: add it to FLOORS"));
        for other in named.iter().filter(|other| floor(other).is_some_and(|other| other > own)) {
            up.insert(format!("{} -> {}", module.join("::"), other.join("::")));
        }
    }
    assert!(imports.len() > 200, "only {} modules were found", imports.len());
    assert!(up.is_empty(), "these use what stands on a higher floor: {up:#?}");
}

/// Groups of modules each of which reaches all others of its group (Tarjan 1972).
fn circles(imports: &BTreeMap<Vec<String>, BTreeSet<Vec<String>>>) -> Vec<BTreeSet<Vec<String>>> {
    let reach = |from: &Vec<String>| {
        let mut reached = BTreeSet::new();
        let mut next: Vec<&Vec<String>> = imports.get(from).into_iter().flatten().collect();
        while let Some(module) = next.pop() {
            if reached.insert(module.clone()) {
                next.extend(imports.get(module).into_iter().flatten());
            }
        }
        reached
    };
    let reached: BTreeMap<&Vec<String>, BTreeSet<Vec<String>>> = imports.keys().map(|module| (module, reach(module))).collect();
    let mut circles: Vec<BTreeSet<Vec<String>>> = Vec::new();
    for (module, out) in &reached {
        if out.contains(*module) && !circles.iter().any(|circle| circle.contains(*module)) {
            let back = |other: &&Vec<String>| reached.get(*other).is_some_and(|out| out.contains(*module));
            circles.push(out.iter().filter(back).cloned().collect());
        }
    }
    circles
}

#[test]
fn modules_do_not_use_each_other_in_circles() {
    let found: Vec<Vec<String>> =
        circles(&imports()).iter().map(|circle| circle.iter().map(|module| module.join("::")).collect()).collect();
    assert!(found.is_empty(), "these use each other in circles: {found:#?}");
}

#[test]
fn circles_are_found_and_trees_are_none() {
    let graph = |edges: &[(&str, &str)]| {
        let mut graph: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = BTreeMap::new();
        for (a, b) in edges {
            graph.entry(vec![(*a).to_owned()]).or_default().insert(vec![(*b).to_owned()]);
        }
        graph
    };
    assert!(circles(&graph(&[("a", "b"), ("b", "c"), ("a", "c")])).is_empty());
    let found = circles(&graph(&[("a", "b"), ("b", "c"), ("c", "b"), ("c", "d")]));
    assert!(found.len() == 1 && found[0].len() == 2, "{found:?}");
}

/// Folders of the project's own Rust.
const FOLDERS: &[&str] = &["src", "capi", "tests", "scenes/src", "bench", "benches", "stream", "viewer/src", "xtask/src"];

#[test]
fn files_have_500_lines_at_most() {
    let files: BTreeMap<String, String> = FOLDERS.iter().flat_map(|folder| sources(folder)).collect();
    let long: Vec<&String> =
        files.iter().filter(|(_, source)| source.lines().count() > MAX_LINES).map(|(file, _)| file).collect();
    assert!(files.len() > 400, "only {} files were found", files.len());
    assert!(long.is_empty(), "these have more than {MAX_LINES} lines: {long:#?}");
}

/// Items that begin with one of these words, as their name and their lines; rustfmt has the last line stand where the first does.
fn items<'a>(source: &'a str, word: &str) -> Vec<(&'a str, Vec<&'a str>)> {
    let lines: Vec<&str> = source.lines().collect();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let text = line.trim_start();
        let Some((before, after)) = text.split_once(&format!("{word} ")) else { continue };
        let is_item = before
            .split_whitespace()
            .all(|part| part.starts_with("pub") || ["const", "unsafe", "extern", "\"C\"", "in", "super)"].contains(&part));
        let name = after.split(|letter: char| !(letter.is_alphanumeric() || letter == '_')).next().unwrap_or_default();
        if !is_item || name.is_empty() || text.ends_with([';', '}']) {
            continue;
        }
        let end = format!("{}}}", &line[..line.len() - text.len()]);
        let length = lines[at..].iter().position(|line| *line == end || line.starts_with(&format!("{end};")));
        if let Some(length) = length {
            found.push((name, lines[at..=at + length].to_vec()));
        }
    }
    found
}

#[test]
fn functions_have_80_lines_at_most() {
    let (mut seen, mut long) = (0, BTreeSet::new());
    for (file, source) in FOLDERS.iter().flat_map(|folder| sources(folder)) {
        for (name, lines) in items(&source, "fn") {
            seen += 1;
            if lines.len() > MAX_LINES_OF_A_FUNCTION {
                long.insert(format!("{file} {name}"));
            }
        }
    }
    assert!(seen > 2000, "only {seen} functions were found");
    assert!(long.is_empty(), "these have more than {MAX_LINES_OF_A_FUNCTION} lines: {long:#?}");
}

#[test]
fn structs_have_20_fields_at_most() {
    let (mut seen, mut large) = (0, BTreeSet::new());
    for (file, source) in sources("src") {
        for (name, lines) in items(&source, "struct") {
            let depth = lines[0].len() - lines[0].trim_start().len() + 4;
            let fields: Vec<&str> =
                (lines.iter().filter(|line| line.len() > depth && line.as_bytes()[..depth].trim_ascii().is_empty()))
                    .map(|line| &line[depth..])
                    .filter(|line| line.starts_with(|letter: char| letter.is_ascii_lowercase()) && line.contains(": "))
                    .collect();
            seen += 1;
            // What has public fields alone is what a user fills in or reads.
            let is_interface =
                lines[0].trim_start().starts_with("pub struct") && fields.iter().all(|field| field.starts_with("pub "));
            if fields.len() > MAX_FIELDS && !is_interface {
                large.insert(format!("{file} {name}"));
            }
        }
    }
    assert!(seen > 200, "only {seen} structs were found");
    let listed = exceptions("structs.txt");
    let new: Vec<&String> = large.difference(&listed).collect();
    let mended: Vec<&String> = listed.difference(&large).collect();
    assert!(new.is_empty(), "these have more than {MAX_FIELDS} fields: {new:#?}");
    assert!(mended.is_empty(), "well done, these are mended: take them off tests/house/structs.txt: {mended:#?}");
}

#[test]
fn thresholds_say_what_they_are_why_and_what_holds_them() {
    let whole =
        [read(&repository().join("src/tuning.rs"))].into_iter().chain(sources("src/tuning").into_values()).collect::<String>();
    let (mut about, mut seen) = (Vec::new(), 0);
    for line in whole.lines().map(str::trim) {
        if let Some(text) = line.strip_prefix("///") {
            about.push(text.trim());
        } else if line.starts_with("pub(crate) const ") {
            let says = |start: &str| about.iter().find_map(|line| line.strip_prefix(start)).map(str::trim);
            let test = says("Test:").unwrap_or_else(|| panic!("{line} names no test"));
            assert!(repository().join(test).is_file(), "{line}: there is no {test}");
            for start in ["Why:", "Scenes:"] {
                assert!(says(start).is_some_and(|text| text.len() > 8), "{line} has nothing after {start}");
            }
            seen += 1;
        }
        if !line.starts_with("///") {
            about.clear();
        }
    }
    assert!(seen > 50, "only {seen} thresholds were found");
}

/// Names of the constants of a source that are real numbers, or arrays of such.
fn real_constants(source: &str) -> Vec<&str> {
    let lines = source.lines().filter(|line| !line.starts_with(' '));
    let items =
        lines.filter_map(|line| line.rsplit_once("const ").filter(|(before, _)| before.is_empty() || before.starts_with("pub")));
    let typed = items.filter_map(|(_, item)| item.split_once(": "));
    typed.filter(|(_, kind)| kind.trim_start_matches('[').starts_with('f')).map(|(name, _)| name).collect()
}

#[test]
fn thresholds_of_the_solver_stand_in_tuning() {
    let mut found = BTreeSet::new();
    for (file, source) in sources("src/solve").iter().filter(|(file, _)| !file.contains("tests")) {
        let source = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        found.extend(real_constants(source).into_iter().map(|name| format!("{} {name}", file.trim_start_matches("src/solve/"))));
    }
    let listed = exceptions("tolerances.txt");
    let new: Vec<&String> = found.difference(&listed).collect();
    assert!(found.len() > 100, "only {} constants were found", found.len());
    assert!(
        new.is_empty(),
        "what decides how a scene behaves belongs into src/tuning.rs, with its reason, its scenes and its test; what an algorithm computes \
         with is listed in tests/house/tolerances.txt: {new:#?}"
    );
}

#[test]
fn real_constants_are_found_however_they_are_written() {
    let source = "const A: f32 = 1.0;\npub(super) const B: f64 = 2.0;\nconst C: [f64; 2] = [1.0, 2.0];\nconst D: usize = 3;\n    const E: f32 = 1.0;";
    assert_eq!(real_constants(source), ["A", "B", "C"]);
}
