//! What deriving long-range constraints costs, as a table for the guide.

use cpu_time::ThreadTime;
use longspan::{JointId, LongRangeDef, Solver};
use longspan_scenes::{Effort, Engine, LongspanEngine, Scene, build};

type Problem = Box<dyn std::error::Error>;

/// Each time is the least of so many, less the least of a step in which nothing is derived.
const REPEATS: u32 = 7;

/// Name, scene, keys, and whether it is cut loose from what holds it.
type Structure = (&'static str, &'static str, &'static [(&'static str, &'static str)], bool);

/// Structures whose bounds are derived.
const STRUCTURES: &[Structure] = &[
    ("hanging chain, 100 links", "hanging_chain", &[("n", "100")], false),
    ("hanging chain, 1000 links", "hanging_chain", &[("n", "1000")], false),
    ("hanging chain, 10,000 links", "hanging_chain", &[("n", "10000")], false),
    ("free chain, 100 links", "hanging_chain", &[("n", "100"), ("ratio", "1")], true),
    ("free chain, 1000 links", "hanging_chain", &[("n", "1000"), ("ratio", "1")], true),
    ("free chain, 10,000 links", "hanging_chain", &[("n", "10000"), ("ratio", "1")], true),
    ("rope bridge", "rope_bridge", &[], false),
    ("200 ragdolls", "ragdoll_pile", &[("n", "200")], false),
];

/// Prints one line a structure as soon as it is measured.
pub fn print() -> Result<(), Problem> {
    println!("| structure | joints | bounds | all derived (ms) | one joint gone (ms) | bounds derived then |");
    println!("|---|---|---|---|---|---|");
    for &(name, scene, keys, is_free) in STRUCTURES {
        let keys: Vec<(String, String)> = keys.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
        println!("{}", line(name, build(scene, &keys)?, is_free)?);
    }
    Ok(())
}

fn line(name: &str, scene: Scene, is_free: bool) -> Result<String, Problem> {
    let mut def = scene.world;
    // Rows are not what is measured.
    (def.solver, def.substeps, def.iterations) = (Solver::GaussSeidel, 1, 1);
    let mut engine = LongspanEngine::new(&def, Effort::Default, 1)?;
    for body in &scene.bodies {
        engine.add_body(body);
    }
    for joint in &scene.joints {
        engine.add_joint(joint);
    }
    if let Some(problem) = engine.refusal() {
        return Err(problem.into());
    }
    let joints: Vec<JointId> = engine.world().joints().collect();
    if is_free {
        engine.world_mut().destroy_joint(joints[0])?;
    }
    // CPU time (ms) of a step after an edit, so short that nothing moves.
    let mut step = |edit: &mut dyn FnMut(&mut LongspanEngine) -> longspan::Result<()>| -> Result<(f64, u32), Problem> {
        edit(&mut engine)?;
        let clock = ThreadTime::now();
        let report = *engine.world_mut().step(1.0e-6)?;
        Ok((1.0e3 * clock.elapsed().as_secs_f64(), report.counts.bounds_derived))
    };
    step(&mut |_| Ok(()))?;
    let mut plain = f64::INFINITY;
    for _ in 0..REPEATS {
        plain = plain.min(step(&mut |_| Ok(()))?.0);
    }
    let (mut all, mut bounds) = (f64::INFINITY, 0);
    for repeat in 1..=2 * REPEATS {
        // Any other choice has all derived anew; the last one is the default's six levels.
        let levels = Some(if repeat % 2 == 0 { 6 } else { 5 });
        let (ms, count) =
            step(&mut |engine| engine.world_mut().set_long_range(&LongRangeDef { levels, ..LongRangeDef::default() }))?;
        if repeat % 2 == 0 {
            (all, bounds) = (all.min(ms), count);
        }
    }
    // Without that joint there are other rows to solve.
    let (mut one, mut derived, mut plain_without) = (f64::INFINITY, 0, f64::INFINITY);
    let middle = joints[joints.len() / 2];
    for _ in 0..REPEATS {
        let (ms, count) = step(&mut |engine| engine.world_mut().set_joint_long_range(middle, false))?;
        (one, derived) = (one.min(ms), count);
        plain_without = plain_without.min(step(&mut |_| Ok(()))?.0);
        step(&mut |engine| engine.world_mut().set_joint_long_range(middle, true))?;
    }
    let count = joints.len() - usize::from(is_free);
    let (all, one) = (all - plain, one - plain_without);
    Ok(format!("| {name} | {count} | {bounds} | {all:.3} | {one:.3} | {derived} |"))
}
