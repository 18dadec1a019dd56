//! The table of state hashes, computed on the platform that this is built for; `cargo xtask platforms` runs it on each.
//!
//! ```text
//! bits run TABLE THREADS [FOLDER]   takes the steps of every row; writes a snapshot and a recording of each into the folder
//! bits resume TABLE FOLDER          restores these snapshots and plays these recordings, wherever they were written
//! ```
//!
//! What a row comes to is printed; where it is not what the table says, the program fails.

use std::path::Path;
use std::process::ExitCode;

use longspan::{World, WorldDef};
use longspan_scenes::bits::{Problem, Row, record, replay, rows};

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let failed = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["run", table, threads] => each_row(table, &|row, _| run(row, threads, None)),
        ["run", table, threads, folder] => each_row(table, &|row, number| run(row, threads, Some((Path::new(folder), number)))),
        ["resume", table, folder] => each_row(table, &|row, number| resume(row, Path::new(folder), number)),
        _ => Err("bits run TABLE THREADS [FOLDER], or bits resume TABLE FOLDER".into()),
    };
    match failed {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(problem) => {
            eprintln!("bits: {problem}");
            ExitCode::FAILURE
        }
    }
}

/// Does something with every row, and counts those that fail.
fn each_row(table: &str, work: &dyn Fn(&Row, usize) -> Result<(), Problem>) -> Result<usize, Problem> {
    let text = std::fs::read_to_string(table).map_err(|error| format!("{table}: {error}"))?;
    let (rows, mut failed) = (rows(&text), 0);
    for (number, row) in rows.iter().enumerate() {
        if let Err(problem) = work(row, number) {
            println!("{}: {problem}", row.name());
            failed += 1;
        }
    }
    println!("{} rows, {failed} of them not as the table says", rows.len());
    if rows.is_empty() { Err(format!("{table} has no rows").into()) } else { Ok(failed) }
}

fn run(row: &Row, threads: &str, kept: Option<(&Path, usize)>) -> Result<(), Problem> {
    let engine = row.world(threads.parse()?)?;
    compare(row, engine.world())?;
    let Some((folder, number)) = kept else { return Ok(()) };
    let mut snapshot = Vec::new();
    engine.world().save(&mut snapshot);
    std::fs::write(folder.join(format!("{number}.snapshot")), &snapshot)?;
    Ok(std::fs::write(folder.join(format!("{number}.recording")), record(&snapshot)?)?)
}

fn resume(row: &Row, folder: &Path, number: usize) -> Result<(), Problem> {
    let mut world = World::new(&WorldDef::default())?;
    world.restore(&std::fs::read(folder.join(format!("{number}.snapshot")))?)?;
    compare(row, &world)?;
    replay(&std::fs::read(folder.join(format!("{number}.recording")))?)
}

fn compare(row: &Row, world: &World) -> Result<(), Problem> {
    let found = world.state_hash();
    if found == row.hash { Ok(()) } else { Err(format!("the hash is {found:016x}, not {:016x}", row.hash).into()) }
}
