//! What steps cost, in instructions and in code and stack that one step touches, beside what the committed table says they cost.
//!
//! Time on a machine that others use says little; valgrind's callgrind counts the same instructions again to a few in a million. The
//! table was written by one compiler for processors with AVX2: counts of another compiler, or without AVX2, are printed and not
//! judged.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::library::{cargo, release_folder};
use crate::{Outcome, platform, printed, repository, succeed, touched};

/// The table, from the repository's folder.
const TABLE: &str = "benches/instructions.toml";

/// How much more than the table says a scene may cost (%).
const MAX_MORE: f64 = 3.0;

/// How much more at any rate: where a linker puts a function moves some lines and pages.
const MAX_MOVED: f64 = 4.0;

/// Counts nothing but what that function of `counted` does.
pub const CALLGRIND: [&str; 3] = ["--tool=callgrind", "--collect-atstart=no", "--toggle-collect=*counted_steps*"];

/// Keeps glibc from filling and copying by one repeated instruction, which valgrind counts for every byte, where the processor likes that.
pub const NO_REPEATS: &str = "glibc.cpu.x86_rep_stosb_threshold=0x7fffffff:glibc.cpu.x86_rep_movsb_threshold=0x7fffffff";

/// Line of a commit's message that says why a scene costs more from there on.
const REASON: &str = "Costs-more: ";

/// What is counted: scene, first step, number of steps, keys. All of them together take some twenty seconds on two cores.
pub const ROWS: &[&str] = &[
    "pile 60 10 n=200",
    "tower 20 10 bodies=100",
    "tower 20 10 bodies=100 support=on",
    "large_pyramid 5 10 base=14",
    "ragdoll_rain 50 10 n=8",
    "ragdoll_rain 50 10 n=8 solver=gs",
    "joint_grid 5 5 n=12",
    "joint_grid 5 5 n=24 solver=gs",
    "hanging_chain 20 20",
    "hanging_chain 20 20 solver=gs",
    "rope_bridge 2 3",
    "rope_bridge 2 3 solver=gs",
    "hinge_loop 5 10",
    "hinge_loop 5 10 solver=gs",
    "vase 5 20",
    "idle 70 1000 n=300",
];

/// Instructions by scene, and the compiler that made them.
#[derive(Debug, Default, PartialEq)]
struct Table {
    compiler: String,
    counts: BTreeMap<String, u64>,
}

/// Counts, and compares with the table; with `bless` writes the table anew.
pub fn run(bless: bool) -> Outcome<()> {
    let found = Table { compiler: compiler()?, counts: count_all(&build()?)? };
    let path = repository().join(TABLE);
    if bless {
        std::fs::write(&path, found.to_text())?;
        println!("{TABLE} written");
        return Ok(());
    }
    let table = Table::read(&std::fs::read_to_string(&path)?)?;
    let worse = compare(&table, &found);
    explained(&table)?;
    if table.compiler != found.compiler || !platform::has_avx2() {
        println!("not judged: the table is of {} with AVX2, this is {}", table.compiler, found.compiler);
        return Ok(());
    }
    if worse.is_empty() {
        return Ok(());
    }
    let advice = format!(
        "If that is worth it, run `cargo xtask instructions bless`, and say why on a line `{REASON}…` of the message of the commit \
         that changes {TABLE}."
    );
    Err(format!("costs more than {MAX_MORE} % more than it did:\n    {}\n{advice}", worse.join("\n    ")).into())
}

/// Prints both counts of every scene; those that cost too much, or stand in only one of the two, are returned.
fn compare(table: &Table, found: &Table) -> Vec<String> {
    let mut worse: Vec<String> =
        table.counts.keys().filter(|row| !found.counts.contains_key(*row)).map(|row| format!("{row}: not counted")).collect();
    for (row, &count) in &found.counts {
        let Some(&before) = table.counts.get(row) else {
            worse.push(format!("{row}: not in {TABLE}"));
            continue;
        };
        let more = 100.0 * (count as f64 / before as f64 - 1.0);
        println!("{row:<42} {count:>12}, {more:+.2} %");
        if costs_more(before, count) {
            worse.push(format!("{row}: {before} to {count}, {more:+.2} %"));
        }
    }
    worse
}

/// Whether the last commit that changed the table says why, where it let a scene cost more. A copy without history is believed.
fn explained(table: &Table) -> Outcome<()> {
    let git = |arguments: &[&str]| printed(Command::new("git").args(arguments).current_dir(repository()));
    let Ok(log) = git(&["log", "-1", "--format=%H%n%B", "--", TABLE]) else { return Ok(()) };
    let Some((commit, message)) = log.split_once('\n') else { return Ok(()) };
    let Ok(before) = git(&["show", &format!("{commit}^:{TABLE}")]) else { return Ok(()) };
    let before = Table::read(&before)?;
    let raised: Vec<&str> = raised(&before, table).collect();
    if raised.is_empty() || before.compiler != table.compiler || has_reason(message) {
        return Ok(());
    }
    Err(format!("commit {commit} lets these cost more, and its message has no line `{REASON}…`: {}", raised.join(", ")).into())
}

fn has_reason(message: &str) -> bool {
    message.lines().any(|line| line.strip_prefix(REASON).is_some_and(|reason| !reason.trim().is_empty()))
}

/// Scenes that may cost more by one table than by an earlier one.
fn raised<'a>(before: &'a Table, now: &'a Table) -> impl Iterator<Item = &'a str> {
    now.counts.iter().filter_map(|(row, &count)| {
        let old = *before.counts.get(row)?;
        costs_more(old, count).then_some(row.as_str())
    })
}

fn costs_more(before: u64, now: u64) -> bool {
    now as f64 > before as f64 * (1.0 + MAX_MORE / 100.0) + MAX_MOVED
}

/// The program that makes the steps. Beside the C library's package, its dependencies have the features that they have there, and
/// what was built for that one is not compiled again.
pub fn build() -> Outcome<PathBuf> {
    let packages = ["--package", "longspan-capi", "--package", "longspan-scenes"];
    succeed(cargo().args(["build", "--release"]).args(packages).args(["--bin", "counted"]))?;
    Ok(release_folder()?.join("counted"))
}

fn compiler() -> Outcome<String> {
    Ok(printed(Command::new("rustc").arg("--version").current_dir(repository()))?.trim().to_owned())
}

/// Counts all rows, as many at a time as there are processors.
fn count_all(program: &Path) -> Outcome<BTreeMap<String, u64>> {
    let next = AtomicUsize::new(0);
    let counts = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(row) = ROWS.get(next.fetch_add(1, Ordering::Relaxed)) {
                    // As text, which may go from thread to thread.
                    let count = count(program, row).map_err(|problem| problem.to_string());
                    counts.lock().unwrap_or_else(PoisonError::into_inner).push((*row, count));
                }
            });
        }
    });
    let counts = counts.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut all = BTreeMap::new();
    for (row, count) in counts {
        all.insert(row.to_owned(), count.map_err(|problem| format!("{row}: {problem}"))?);
    }
    for row in touched::ROWS {
        all.extend(touched::count(program, row)?);
    }
    Ok(all)
}

/// Instructions of one row.
fn count(program: &Path, row: &str) -> Outcome<u64> {
    let mut valgrind = Command::new("valgrind");
    valgrind.args(CALLGRIND).arg("--callgrind-out-file=/dev/null");
    valgrind.arg(program).args(row.split(' ')).env("GLIBC_TUNABLES", NO_REPEATS);
    let output = valgrind.output().map_err(|error| format!("valgrind: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(said.into_owned().into());
    }
    collected(&said).ok_or_else(|| format!("valgrind counted nothing:\n{said}").into())
}

/// What callgrind says it counted.
fn collected(said: &str) -> Option<u64> {
    let count = said.lines().find_map(|line| line.split_once("Collected :"))?.1;
    count.trim().parse().ok().filter(|&count| count > 0)
}

impl Table {
    /// The only TOML it reads is what it writes: comments, a table's head, and lines of a key and a value.
    fn read(text: &str) -> Outcome<Self> {
        let mut table = Self::default();
        for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with(['#', '['])) {
            let (key, value) = line.split_once(" = ").ok_or_else(|| format!("{TABLE}: {line}"))?;
            match key.trim_matches('"') {
                "compiler" => table.compiler = value.trim_matches('"').to_owned(),
                row => _ = table.counts.insert(row.to_owned(), value.parse()?),
            }
        }
        Ok(table)
    }

    fn to_text(&self) -> String {
        let mut text = format!(
            "# Instructions of steps: scene, first step, number of steps, keys; and code and stack that one step touches. Written by `cargo xtask instructions bless`; CI fails where\n\
             # a scene costs {MAX_MORE} % more, or where a commit lets it and has no line `{REASON}…` in its message.\n\
             compiler = \"{}\"\n\n[instructions]\n",
            self.compiler
        );
        for (row, count) in &self.counts {
            _ = writeln!(text, "\"{row}\" = {count}");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(counts: &[(&str, u64)]) -> Table {
        let counts = counts.iter().map(|&(row, count)| (row.to_owned(), count)).collect();
        Table { compiler: "rustc 1.0".to_owned(), counts }
    }

    #[test]
    fn what_is_written_is_read() {
        let written = table(&[("pile 60 10 n=200", 123_456), ("vase 5 20", 7)]);
        assert_eq!(Table::read(&written.to_text()).unwrap(), written);
    }

    #[test]
    fn three_hundredths_and_four_more_are_let_pass_and_no_more() {
        let before = table(&[("a", 1000), ("b", 1000), ("c", 1000)]);
        let now = table(&[("a", 1034), ("b", 1035), ("c", 10)]);
        assert_eq!(compare(&before, &now), ["b: 1000 to 1035, +3.50 %"]);
        assert_eq!(raised(&before, &now).collect::<Vec<_>>(), ["b"]);
        assert_eq!(compare(&before, &table(&[("a", 1000), ("b", 1000), ("d", 1)])).len(), 2, "c is missing, d is new");
    }

    #[test]
    fn a_reason_is_a_line_that_says_something() {
        assert!(has_reason("Shapes\n\nCosts-more: friction cones, 4 %\n"));
        assert!(!has_reason("Shapes\n\nCosts-more: \n") && !has_reason("That it Costs-more: so what\n"));
    }

    #[test]
    fn a_count_is_found_among_what_callgrind_says() {
        assert_eq!(collected("==1== Events    : Ir\n==1== Collected : 1234\n"), Some(1234));
        assert_eq!(collected("==1== Collected : 0\n"), None, "the function was not found");
    }
}
