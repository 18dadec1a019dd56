//! Steps of a scene for an instruction counter: `counted SCENE FIRST COUNT [KEY=VALUE ...]` makes `FIRST` steps, then `COUNT` steps
//! inside a function named [`counted_steps`], which valgrind's callgrind is told to count alone, and prints the hash of the state that they
//! lead to. `counted stack SCENE …` prints how many pages of stack one more step takes. Scripts of scenes are not run.

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
    if let [first, words @ ..] = words
        && first == "stack"
    {
        println!("{}", stack_pages(&mut stepped(words)?)?);
        return Ok(());
    }
    let Made { engine, .. } = stepped(words)?;
    println!("{:016x}", engine.world().state_hash());
    Ok(())
}

/// An engine after the steps that are asked for, and the length of one (s).
struct Made {
    engine: LongspanEngine,
    dt: f32,
}

fn stepped(words: &[String]) -> Result<Made, Box<dyn std::error::Error>> {
    let [scene, first, count, keys @ ..] = words else { return Err("[stack] SCENE FIRST COUNT [KEY=VALUE ...]".into()) };
    let pair = |word: &String| word.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned()));
    let keys: Vec<(String, String)> = keys.iter().map(pair).collect::<Option<_>>().ok_or("a key has no value")?;
    let scene = build(scene, &keys)?;
    let mut engine = LongspanEngine::start(&scene)?;
    for _ in 0..first.parse::<u32>()? {
        engine.step(scene.dt);
    }
    counted_steps(&mut engine, scene.dt, count.parse()?);
    match engine.refusal() {
        Some(refusal) => Err(refusal.into()),
        None => Ok(Made { engine, dt: scene.dt }),
    }
}

/// Pages that are there of the stack of a thread which makes one step, by what Linux says of its memory.
fn stack_pages(made: &mut Made) -> Result<u64, Box<dyn std::error::Error>> {
    let kilobytes = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(8 << 20).spawn_scoped(scope, || {
            made.engine.step(made.dt);
            let here = 0_u8;
            let maps = std::fs::read_to_string("/proc/self/smaps").map_err(|error| error.to_string())?;
            resident(&maps, std::ptr::from_ref(&here) as u64).ok_or_else(|| "no mapping has this thread's stack".to_owned())
        })?;
        thread.join().map_err(|_| "the step panicked")?.map_err(Box::<dyn std::error::Error>::from)
    })?;
    Ok(kilobytes / 4)
}

/// Kilobytes that are in memory of the mapping which has an address.
fn resident(maps: &str, address: u64) -> Option<u64> {
    let mut is_inside = false;
    for line in maps.lines() {
        let range = line.split(' ').next()?.split_once('-');
        if let Some((Ok(start), Ok(end))) =
            range.map(|(start, end)| (u64::from_str_radix(start, 16), u64::from_str_radix(end, 16)))
        {
            is_inside = (start..end).contains(&address);
        } else if let Some(size) = line.strip_prefix("Rss:").filter(|_| is_inside) {
            return size.trim().strip_suffix(" kB")?.parse().ok();
        }
    }
    None
}

#[inline(never)]
fn counted_steps(engine: &mut LongspanEngine, dt: f32, count: u32) {
    for _ in 0..count {
        engine.step(dt);
    }
}
