//! Runs scenes on engines, one after another.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use longspan_bench::peers;
use longspan_scenes::{CATALOGUE, Effort, LongspanEngine, Measurement, Scene, build, run as run_scene};

use crate::args::{OURS, Run};
use crate::line::{to_json, to_text};

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
            match fastest(options, &engine, effort) {
                Ok(measurement) if options.json => println!("{}", to_json(&measurement)),
                Ok(measurement) => println!("{}", to_text(&measurement)),
                Err(problem) => {
                    eprintln!("longspan-bench: {problem}");
                    failures += u32::from(engine == OURS);
                }
            }
        }
    }
    if failures > 0 { Err(format!("{failures} of our own runs failed").into()) } else { Ok(()) }
}

fn fastest(options: &Run, engine: &str, effort: Effort) -> Result<Measurement, Problem> {
    let mut best: Option<Measurement> = None;
    for _ in 0..options.repeat {
        let scene = build(&options.chosen.scene, &options.chosen.keys())?;
        let measurement = run_on(scene, engine, effort, options.threads)?;
        if best.as_ref().is_none_or(|best| measurement.ms_median < best.ms_median) {
            best = Some(measurement);
        }
    }
    best.ok_or_else(|| "nothing was run".into())
}

fn run_on(scene: Scene, engine: &str, effort: Effort, threads: usize) -> Result<Measurement, Problem> {
    let outcome = if engine == OURS {
        catch_unwind(AssertUnwindSafe(|| {
            let mut ours = LongspanEngine::new(&scene.world, effort, threads)?;
            Ok(run_scene(scene, &mut ours, effort, threads)?)
        }))
    } else {
        in_silence(|| {
            let mut peer = peers::create(engine, &scene.world, effort, threads)
                .ok_or_else(|| format!("'{engine}' was left out of this build"))?;
            Ok(run_scene(scene, &mut *peer, effort, threads)?)
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
