//! Steps of a scene for an instruction counter: `counted SCENE FIRST COUNT [KEY=VALUE ...]` makes `FIRST` steps, then `COUNT` steps
//! inside a function named [`counted_steps`], which valgrind's callgrind is told to count alone. Scripts of scenes are not run.

use std::process::ExitCode;

use longspan_scenes::{Engine, LongspanEngine, build};

fn main() -> ExitCode {
    match run(&std::env::args().skip(1).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("counted: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn run(words: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let [scene, first, count, keys @ ..] = words else { return Err("SCENE FIRST COUNT [KEY=VALUE ...]".into()) };
    let pair = |word: &String| word.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned()));
    let keys: Vec<(String, String)> = keys.iter().map(pair).collect::<Option<_>>().ok_or("a key has no value")?;
    let scene = build(scene, &keys)?;
    let mut engine = LongspanEngine::start(&scene)?;
    for _ in 0..first.parse::<u32>()? {
        engine.step(scene.dt);
    }
    counted_steps(&mut engine, scene.dt, count.parse()?);
    engine.refusal().map_or(Ok(()), |refusal| Err(refusal.into()))
}

#[inline(never)]
fn counted_steps(engine: &mut LongspanEngine, dt: f32, count: u32) {
    for _ in 0..count {
        engine.step(dt);
    }
}
