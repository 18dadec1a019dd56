//! State hashes of every scene of the catalogue: `hashes STEPS [NAME ...]` makes so many steps of each, directly solved and swept, and
//! prints one line a run. Two builds of the library that print the same compute the same, bit for bit. Scripts of scenes are not run.

use std::process::ExitCode;

use longspan_scenes::{CATALOGUE, Engine, LongspanEngine, build};

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.split_first().map(|(steps, names)| print(steps, names)) {
        Some(Ok(())) => ExitCode::SUCCESS,
        Some(Err(problem)) => {
            eprintln!("hashes: {problem}");
            ExitCode::FAILURE
        }
        None => {
            eprintln!("hashes STEPS [NAME ...]");
            ExitCode::FAILURE
        }
    }
}

fn print(steps: &str, names: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let steps: u32 = steps.parse()?;
    for entry in CATALOGUE.iter().filter(|entry| names.is_empty() || names.iter().any(|name| name == entry.name)) {
        for solver in ["auto", "gs"] {
            let scene = build(entry.name, &[("solver".to_owned(), solver.to_owned())])?;
            let mut engine = LongspanEngine::start(&scene)?;
            for _ in 0..steps {
                engine.step(scene.dt);
            }
            println!("{:016x} {} {solver} {steps}", engine.world().state_hash(), entry.name);
        }
    }
    Ok(())
}
