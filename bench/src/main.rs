//! The command line: runs scenes on engines, lists them, plots results, draws pictures, writes snapshots.

mod args;
mod cold;
mod derive_table;
mod draw;
mod holdout_table;
mod host_table;
mod line;
mod plot;
mod session;
mod stress_table;
#[cfg(feature = "trace")]
mod trace;

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use longspan_scenes::{LongspanEngine, build};

use args::{Chosen, Command, Options};

fn main() -> ExitCode {
    let outcome = match Options::parse().command {
        Command::Run(run) => session::run(&run),
        Command::List => session::list(),
        Command::Plot { file, out_dir, error, time } => plot::plot(&file, &out_dir, error.as_deref(), time),
        Command::StressTable { seeds } => stress_table::print(seeds as u64),
        Command::HoldoutTable { of } => holdout_table::print(&of),
        Command::DeriveTable => derive_table::print(),
        Command::HostTable { repeats } => host_table::print(repeats),
        #[cfg(feature = "trace")]
        Command::Trace(options) => trace::run(&options),
        Command::Picture(picture) => draw::picture(&picture),
        Command::Save { chosen, out } => save(&chosen, &out),
        Command::Draw { file, out, size } => draw::draw_file(&file, &out, size),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("longspan-bench: {problem}");
            ExitCode::FAILURE
        }
    }
}

/// Writes the end of a scene for another host to take up.
fn save(chosen: &Chosen, out: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let bytes = LongspanEngine::snapshot(build(&chosen.scene, &chosen.keys())?)?;
    std::fs::write(out, &bytes)?;
    println!("{}: {} bytes", out.display(), bytes.len());
    Ok(())
}
