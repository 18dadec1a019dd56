//! Runs scenes on engines, one after another.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use longspan::WorldDef;
use longspan_bench::peers;
use longspan_scenes::{
    CATALOGUE, Effort, Engine, LongspanEngine, Measurement, RunError, Scene, Timing, build, run as run_scene, time,
};

use crate::args::{OURS, Run};
use crate::cold::OtherWork;
use crate::line::{Outcome, to_json, to_text};

/// How a peer says that a scene asks for what it does not have: by a panic that begins so.
const NOT_SUPPORTED: &str = "not supported by";

type Problem = Box<dyn std::error::Error>;

/// Prints the scenes, one a line.
pub fn list() -> Result<(), Problem> {
    for entry in CATALOGUE {
        let keys: Vec<String> = build(entry.name, &[])?.params.iter().map(|(key, value)| format!("{key}={value}")).collect();
        println!("{:<16} {} [{}]", entry.name, entry.summary, keys.join(" "));
    }
    Ok(())
}

/// Runs and prints; goes on to the next engine after one that cannot run the scene.
pub fn run(options: &Run) -> Result<(), Problem> {
    let mut failures = 0;
    build(&options.chosen.scene, &options.chosen.keys())?;
    for engine in options.engines() {
        for &effort in &options.effort {
            let outcome = match options.seeds {
                Some(seeds) => worst(options, &engine, effort, seeds),
                None => fastest(options, &engine, effort),
            };
            match outcome {
                Ok(outcome) if options.json => println!("{}", to_json(&outcome, options.cold)),
                Ok(outcome) => println!("{}", to_text(&outcome)),
                Err(problem) => {
                    eprintln!("longspan-bench: {problem}");
                    failures += u32::from(engine == OURS);
                }
            }
        }
    }
    if failures > 0 { Err(format!("{failures} of our own runs failed").into()) } else { Ok(()) }
}

fn fastest(options: &Run, engine: &str, effort: Effort) -> Result<Outcome, Problem> {
    let build = || build(&options.chosen.scene, &options.chosen.keys());
    let mut best: Option<Timing> = None;
    for _ in 0..options.repeat {
        let timing = timed(options, &build()?, engine, effort)?;
        if best.as_ref().is_none_or(|best| timing.whole.median < best.whole.median) {
            best = Some(timing);
        }
    }
    Ok(Outcome { run: judged(build()?, engine, effort, options.threads)?, timing: best.ok_or("nothing was run")? })
}

/// Every seed from 1 to `seeds` as one outcome: the worst of each error, how many did not hold, times of the slowest.
fn worst(options: &Run, engine: &str, effort: Effort, seeds: usize) -> Result<Outcome, Problem> {
    let mut runs = Vec::with_capacity(seeds);
    let mut timings = Vec::with_capacity(seeds);
    for seed in 1..=seeds {
        let keys = [options.chosen.keys(), vec![("seed".to_owned(), seed.to_string())]].concat();
        timings.push(timed(options, &build(&options.chosen.scene, &keys)?, engine, effort)?);
        runs.push(judged(build(&options.chosen.scene, &keys)?, engine, effort, options.threads)?);
    }
    let slowest = timings.into_iter().max_by(|a, b| a.whole.median.total_cmp(&b.whole.median));
    let mut all = runs.first().ok_or("nothing was run")?.clone();
    all.params.retain(|(key, _)| key != "seed");
    all.params.push(("seeds".to_owned(), seeds.to_string()));
    for (name, value) in &mut all.errors {
        let found = runs.iter().flat_map(|run| &run.errors).filter(|(found, _)| found == name).map(|(_, found)| *found);
        *value = if *name == "held" { found.fold(1.0, f64::min) } else { found.fold(*value, f64::max) };
    }
    let fell = |run: &&Measurement| run.errors.iter().any(|(name, value)| *name == "held" && *value == 0.0);
    all.errors.push(("failures", runs.iter().filter(fell).count() as f64));
    Ok(Outcome { run: all, timing: slowest.ok_or("nothing was run")? })
}

/// Times of a run of which nothing is measured.
fn timed(options: &Run, scene: &Scene, engine: &str, effort: Effort) -> Result<Timing, Problem> {
    let mut other = options.cold.map(|length| (OtherWork::new(), length));
    let mut between = || {
        if let Some((work, length)) = &mut other {
            work.run(*length);
        }
    };
    on_engine(engine, &scene.world, effort, options.threads, |engine| time(scene, engine, options.threads, &mut between))
}

/// Errors of a run of which no time is taken.
fn judged(scene: Scene, engine: &str, effort: Effort, threads: usize) -> Result<Measurement, Problem> {
    let world = scene.world;
    on_engine(engine, &world, effort, threads, |engine| run_scene(scene, engine, effort, threads))
}

fn on_engine<T>(
    engine: &str,
    world: &WorldDef,
    effort: Effort,
    threads: usize,
    work: impl FnOnce(&mut dyn Engine) -> Result<T, RunError>,
) -> Result<T, Problem> {
    let outcome = if engine == OURS {
        catch_unwind(AssertUnwindSafe(|| Ok(work(&mut LongspanEngine::new(world, effort, threads)?)?)))
    } else {
        in_silence(|| {
            let peer = peers::create(engine, world, effort, threads);
            Ok(work(&mut *peer.ok_or_else(|| format!("'{engine}' was left out of this build"))?)?)
        })
    };
    outcome.unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().cloned().or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        match said {
            Some(said) if said.starts_with(NOT_SUPPORTED) => Err(said.into()),
            Some(said) => Err(format!("{engine} broke down: {said}").into()),
            None => resume_unwind(panic),
        }
    })
}

/// Catches a panic without the usual report: a peer panics to say what it has no equal of.
fn in_silence<T>(work: impl FnOnce() -> T) -> std::thread::Result<T> {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let outcome = catch_unwind(AssertUnwindSafe(work));
    std::panic::set_hook(hook);
    outcome
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Command, Options};

    #[test]
    fn many_seeds_become_one_measurement_of_the_worst() {
        let line = "longspan-bench run violent --set n=10 --set ratio=1 --seconds 0.1 --engines longspan --seeds 3";
        let Command::Run(options) = Options::try_parse_from(line.split(' ')).unwrap().command else { panic!("not a run") };
        let all = worst(&options, OURS, Effort::Default, 3).unwrap().run;
        let of = |all: &Measurement, name: &str| all.errors.iter().find(|(found, _)| *found == name).unwrap().1;
        let gap_of_seed = |seed: usize| {
            let keys = [options.chosen.keys(), vec![("seed".to_owned(), seed.to_string())]].concat();
            let run = judged(build("violent", &keys).unwrap(), OURS, Effort::Default, 1).unwrap();
            of(&run, "joint_gap_m")
        };
        let gaps = [1, 2, 3].map(gap_of_seed);
        assert_eq!(of(&all, "joint_gap_m"), gaps.into_iter().fold(0.0, f64::max), "seeds with gaps of {gaps:?} m");
        assert_eq!(of(&all, "failures") > 0.0, of(&all, "held") == 0.0);
        assert!(all.params.contains(&("seeds".to_owned(), "3".to_owned())), "{:?}", all.params);
    }
}
