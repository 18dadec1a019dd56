//! Where the instructions of steps go, by stage: `cargo xtask profile SCENE FIRST COUNT [KEY=VALUE ...]`.
//!
//! callgrind names the file that each instruction was compiled from, whatever it was inlined into. Instructions of libraries are
//! those of the file of ours that they were inlined into; calls into them are theirs. Misses are those of a first-level data cache
//! as this machine has it.

use std::collections::BTreeMap;
use std::process::Command;

use crate::library::output_folder;
use crate::{Outcome, instructions, succeed};

/// Stages, and what the paths of their files contain; the first that fits counts.
const STAGES: &[(&str, &[&str])] = &[
    (
        "broad phase",
        &["src/collide/broad", "src/collide/aabb_set", "src/collide/collider.rs", "partitioning/bvh", "bounding_volume"],
    ),
    ("narrow phase", &["src/collide/", "parry3d"]),
    ("lists of pairs", &["src/world/pairs"]),
    ("islands and batches", &["src/world/islands", "src/island", "src/solve/color"]),
    ("filling of batches", &["src/world/solve_batches.rs", "src/solve/batch", "src/solve/contact.rs", "src/solve/contact_block"]),
    ("masses of contacts", &["contact_kernels/masses"]),
    ("sweeps of contacts", &["contact_kernels"]),
    (
        "loads in stacks",
        &["src/solve/momentum_pass", "src/solve/contact_newton", "src/solve/initial_impulses", "src/load_distribution"],
    ),
    (
        "motion of bodies",
        &["src/solve/integrate", "src/solve/rotation", "src/solve/wide_bodies", "src/solve/state", "src/solve/mod", "src/body"],
    ),
    ("joints in sweeps", &["src/solve/joint", "src/joint.rs", "src/joint_drive", "src/joint_rebounds", "src/world/joints"]),
    ("direct solve", &["src/solve/direct", "src/linalg/"]),
    ("coupled solve", &["src/solve/newton", "src/solve/plan"]),
    ("bounds and taut lines", &["src/solve/distance_bound", "src/solve/taut_line", "src/solve/wrapped_bound"]),
    ("planes and momentum", &["src/solve/plane", "src/solve/momentum", "src/world/planes"]),
    ("derivation of bounds", &["src/joint_graph/", "src/world/long_range", "src/world/chain"]),
    ("unions", &["src/world/union"]),
    ("support and hold", &["src/world/support", "src/world/hold"]),
    ("fracture", &["src/fracture", "src/world/fracture", "src/world/cells"]),
    ("sleep", &["src/world/sleep"]),
    ("sensors", &["src/world/sensors"]),
    ("results and events", &["src/world"]),
];

/// What no stage has: copying, filling and taking of memory, sorting.
const REST: &str = "memory and the rest";

/// Instructions, and misses of the first-level data cache.
type Cost = [u64; 2];

pub fn run(words: &[&str]) -> Outcome<()> {
    let [_, _, steps, ..] = words else { return Err("SCENE FIRST COUNT [KEY=VALUE ...]".into()) };
    let steps: u64 = steps.parse()?;
    let out = output_folder("profile")?.join("callgrind.out");
    let mut valgrind = Command::new("valgrind");
    valgrind.args(instructions::CALLGRIND).args(["--quiet", "--cache-sim=yes"]);
    valgrind.arg(format!("--callgrind-out-file={}", out.display())).env("GLIBC_TUNABLES", instructions::NO_REPEATS);
    succeed(valgrind.arg(instructions::build()?).args(words))?;

    let mut stages: BTreeMap<&str, Cost> = BTreeMap::new();
    for (file, cost) in by_file(&std::fs::read_to_string(out)?)? {
        let stage = STAGES.iter().find(|(_, parts)| parts.iter().any(|part| file.contains(part))).map_or(REST, |(name, _)| name);
        add(stages.entry(stage).or_default(), &cost);
    }
    let mut total = Cost::default();
    stages.values().for_each(|cost| add(&mut total, cost));
    let mut rows: Vec<(&str, Cost)> = stages.into_iter().collect();
    rows.sort_by_key(|(_, cost)| std::cmp::Reverse(cost[0]));
    rows.insert(0, ("all", total));
    println!("instructions and cache misses of a step: {}", words.join(" "));
    for (stage, [instructions, misses]) in rows {
        let share = 100.0 * instructions as f64 / total[0] as f64;
        println!("{stage:<22} {:>12} {share:>6.2} % {:>10} misses", instructions / steps, misses / steps);
    }
    Ok(())
}

fn add(sum: &mut Cost, more: &Cost) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}

/// Costs by file in callgrind's format: `fl`, `fi` and `fe` say which file the lines after them are of, by a number and at its first use
/// by name; `cfl` and `cfi` that of a function called, whose costs, one line after `calls`, are its own.
fn by_file(text: &str) -> Outcome<BTreeMap<String, Cost>> {
    let mut names: BTreeMap<&str, &str> = BTreeMap::new();
    let mut costs: BTreeMap<String, Cost> = BTreeMap::new();
    let (mut events, mut file, mut is_call) = (Vec::new(), "", false);
    for line in text.lines() {
        if let Some(list) = line.strip_prefix("events: ") {
            events = list.split(' ').collect();
        } else if line.starts_with("calls=") {
            is_call = true;
        } else if let Some((kind, rest)) = line.split_once("=(") {
            let (number, name) = rest.split_once(')').ok_or("a name without a number")?;
            if !matches!(kind, "fl" | "fi" | "fe" | "cfl" | "cfi") {
                continue;
            }
            if !name.is_empty() {
                names.insert(number, name.trim_start());
            }
            let name = names.get(number).copied().ok_or("a number without a name")?;
            if kind == "fl" || (matches!(kind, "fi" | "fe") && is_ours(name)) {
                file = name;
            }
        } else if line.starts_with(|first: char| first.is_ascii_digit() || matches!(first, '+' | '-' | '*')) {
            if std::mem::take(&mut is_call) {
                continue;
            }
            let mut cost = Cost::default();
            for (event, count) in events.iter().zip(line.split(' ').skip(1)) {
                match *event {
                    "Ir" => cost[0] += count.parse::<u64>()?,
                    "D1mr" | "D1mw" => cost[1] += count.parse::<u64>()?,
                    _ => {}
                }
            }
            add(costs.entry(file.to_owned()).or_default(), &cost);
        }
    }
    Ok(costs)
}

/// Whether what was compiled from a file is a stage's own: lanes, slots and vectors are everybody's.
fn is_ours(file: &str) -> bool {
    let others = [
        "/registry/",
        "/rustc/",
        "sysdeps",
        "src/solve/wide",
        "src/solve/dispatch",
        "src/solve/side",
        "src/id.rs",
        "src/tight_vec.rs",
    ];
    file.contains("src/") && !others.iter().any(|other| file.contains(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_inlined_is_of_the_file_it_is_inlined_into_and_what_is_called_is_not() {
        let text = "events: Ir D1mr D1mw\nfl=(1) src/world.rs\nfn=(1) step\n10 5 1 0\nfi=(2) /rustc/1/library/core/src/cmp.rs\n+1 3\n\
                    fi=(3) src/collide/broad.rs\n7 2 0 1\ncfi=(4) ./sysdeps/memset.S\ncfn=(2) memset\ncalls=1 0\n* 100\n\
                    fl=(4)\nfn=(2)\n9 100\n";
        let costs = by_file(text).unwrap();
        let found: Vec<(&str, Cost)> = costs.iter().map(|(file, cost)| (file.as_str(), *cost)).collect();
        assert_eq!(found, [("./sysdeps/memset.S", [100, 0]), ("src/collide/broad.rs", [2, 1]), ("src/world.rs", [8, 1])]);
    }
}
