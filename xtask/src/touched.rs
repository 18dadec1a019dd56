//! What one step touches for the first time when nothing of it is in a cache: lines and pages of code, pages of stack.
//!
//! A game steps once a frame, after much other work, and then waits for code to come from memory: a cold step of one body takes twenty
//! times as long as one in a loop. Counts say more than times here, too.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use crate::instructions::{CALLGRIND, NO_REPEATS};
use crate::library::output_folder;
use crate::{Outcome, printed};

/// Scenes of which one step is looked at, after so many: one body, chains, a small heap.
pub const ROWS: &[&str] = &["free_gyro 20 1", "hanging_chain 20 1 n=10", "hanging_chain 20 1 n=30", "pile 30 1 n=30"];

/// Bytes of a line of a cache, and of a page.
const LINE: u64 = 64;
const PAGE: u64 = 4096;

/// What the step of a row touches, each with its name.
pub fn count(program: &Path, row: &str) -> Outcome<Vec<(String, u64)>> {
    let out = output_folder("touched")?.join(row.replace(' ', "_"));
    let mut valgrind = Command::new("valgrind");
    valgrind.args(CALLGRIND).args(["--dump-instr=yes", "--dump-line=no", "--compress-pos=no"]);
    valgrind.arg(format!("--callgrind-out-file={}", out.display())).env("GLIBC_TUNABLES", NO_REPEATS);
    printed(valgrind.arg(program).args(row.split(' ')))?;
    let addresses = addresses(&std::fs::read_to_string(out)?);
    let distinct = |size: u64| addresses.iter().map(|address| address / size).collect::<BTreeSet<_>>().len() as u64;
    let stack = printed(Command::new(program).arg("stack").args(row.split(' ')))?.trim().parse()?;
    let counts = [("lines of code", distinct(LINE)), ("pages of code", distinct(PAGE)), ("pages of stack", stack)];
    Ok(counts.map(|(what, count)| (format!("{what}: {row}"), count)).into())
}

/// Addresses of the instructions that were counted, in callgrind's format with `--dump-instr=yes --compress-pos=no`.
fn addresses(text: &str) -> Vec<u64> {
    let address = |line: &str| u64::from_str_radix(line.split(' ').next()?.strip_prefix("0x")?, 16).ok();
    text.lines().filter_map(address).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_those_of_cost_lines() {
        let text = "events: Ir\nfl=(1) a.rs\nfn=(1) step\n0x401000 5\n0x401003 5\ncalls=1 0x500000\n0x401003 70\n";
        assert_eq!(addresses(text), [0x40_1000, 0x40_1003, 0x40_1003]);
    }
}
