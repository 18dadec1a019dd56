//! Says how a scene's steps would scale: what of them is serial, what is divided, and how long so many threads would take.
//!
//! Steps are made on one thread, cut into pieces as for several; a model then has threads do the pieces as the library's would. What it
//! leaves out is that a body which changes hands is read from another core's cache.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::ffi::CStr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use cpu_time::ThreadTime;
use longspan::Profiler;
use longspan::trace::{Region, simulate, take};
use longspan_scenes::{Effort, LongspanEngine, build, time};

use crate::args::Trace;

/// What each thread adds to the time of a region, and to that of a phase (µs): measured on 16 cores of one socket.
const REGION_COST: f64 = 0.38;
const PHASE_COST: f64 = 0.11;

/// Time that this thread has had of a processor.
fn clock() -> Duration {
    ThreadTime::now().as_duration()
}

/// Zone of a whole step.
const STEP: &CStr = c"longspan step";

/// Zones as they begin, by the calling thread.
#[derive(Default)]
struct Zones(Mutex<Vec<(Duration, &'static CStr)>>);

impl Zones {
    fn note(&self, zone: &'static CStr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((clock(), zone));
    }

    fn take(&self) -> Vec<(Duration, &'static CStr)> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Profiler for Zones {
    fn begin(&self, zone: &'static CStr) {
        self.note(zone);
    }

    fn end(&self, zone: &'static CStr) {
        if zone == STEP {
            self.note(zone);
        }
    }
}

/// Time that a step spends somewhere (µs): serially, in pieces, and by how much the model has so many threads exceed an equal division.
#[derive(Debug, Default, Clone, Copy)]
struct Share {
    serial: f64,
    parallel: f64,
    modelled: f64,
    regions: usize,
    phases: usize,
    pieces: usize,
}

/// A step as it was recorded.
struct Step {
    /// From one thing to the next: where, and how long (µs), outside of regions.
    serial: Vec<(String, f64)>,
    regions: Vec<(String, Region)>,
}

pub fn run(options: &Trace) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "{:>7} {:>10} {:>10} {:>10} {:>8} {:>8} {:>9} {:>9}",
        "threads", "all ms", "serial ms", "model ms", "times", "best", "regions", "phases"
    );
    let mut last = None;
    for &threads in &options.threads {
        let steps = record(options, threads)?;
        let all = summary(&steps, threads, false);
        let best = summary(&steps, threads, true);
        let sum = total(&all);
        let whole = sum.serial + sum.parallel;
        let count = steps.len().max(1) as f64;
        println!(
            "{threads:>7} {:>10.3} {:>10.3} {:>10.3} {:>8.2} {:>8.2} {:>9.1} {:>9.1}",
            whole / count / 1e3,
            sum.serial / count / 1e3,
            (sum.serial + sum.modelled) / count / 1e3,
            whole / (sum.serial + sum.modelled),
            whole / (sum.serial + total(&best).modelled),
            sum.regions as f64 / count,
            sum.phases as f64 / count,
        );
        last = Some((threads, all, count));
    }
    if let Some((threads, all, count)) = last {
        print_stages(threads, all, count);
    }
    Ok(())
}

/// Stages by what they cost so many threads.
fn print_stages(threads: usize, all: BTreeMap<String, Share>, count: f64) {
    println!("\nfor {threads} threads, a step: µs serial, µs in pieces, µs of those by the model, regions, phases, pieces");
    let mut rows: Vec<(String, Share)> = all.into_iter().collect();
    rows.sort_by(|a, b| (b.1.serial + b.1.modelled).total_cmp(&(a.1.serial + a.1.modelled)));
    for (stage, share) in rows.iter().take(40) {
        println!(
            "{:>9.1} {:>9.1} {:>9.1} {:>7.1} {:>7.1} {:>8.1}  {stage}",
            share.serial / count,
            share.parallel / count,
            share.modelled / count,
            share.regions as f64 / count,
            share.phases as f64 / count,
            share.pieces as f64 / count,
        );
    }
}

/// How long it takes to look at the clock, which is once a piece.
fn clock_cost() -> Duration {
    const LOOKS: u32 = 1000;
    let begun = clock();
    (1..LOOKS).for_each(|_| _ = std::hint::black_box(clock()));
    (clock() - begun) / LOOKS
}

/// The steps of a scene, cut for so many threads.
fn record(options: &Trace, threads: usize) -> Result<Vec<Step>, Box<dyn std::error::Error>> {
    let look = clock_cost();
    let scene = build(&options.chosen.scene, &options.chosen.keys())?;
    simulate(Some(threads), clock);
    let engine = LongspanEngine::new(&scene.world, Effort::Default, threads);
    simulate(None, clock);
    let mut engine = engine?;
    let zones = Arc::new(Zones::default());
    engine.world_mut().set_profiler(Some(zones.clone()));
    let mut steps = Vec::new();
    let skipped = options.skip;
    let mut number = 0;
    time(&scene, &mut engine, 1, &mut || {
        let (zones, mut regions) = (zones.take(), take());
        let pieces = regions.iter_mut().flat_map(|region| &mut region.pieces);
        pieces.for_each(|piece| piece.time = piece.time.saturating_sub(look));
        if number > skipped {
            steps.push(step(&zones, regions));
        }
        number += 1;
    })?;
    steps.push(step(&zones.take(), take()));
    Ok(steps)
}

/// What of a step lies between regions, by the stage and the region before.
fn step(zones: &[(Duration, &'static CStr)], regions: Vec<Region>) -> Step {
    let (mut serial, mut named) = (Vec::new(), Vec::new());
    let mut regions = regions.into_iter().peekable();
    for window in zones.windows(2) {
        let [(mut from, zone), (to, _)] = [window[0], window[1]];
        let zone = zone.to_string_lossy();
        let mut after = "begin".to_owned();
        while let Some(region) = regions.next_if(|region| region.time[0] < to) {
            let [begun, cut, ended] = region.time;
            serial.push((format!("{zone}: after {after}"), micros(begun.saturating_sub(from))));
            let at = format!("{}:{}", region.at.file().trim_start_matches("src/"), region.at.line());
            serial.push((format!("{zone}: cutting for {at}"), micros(cut.saturating_sub(begun))));
            named.push((format!("{zone}: {at}"), region));
            (from, after) = (ended, at);
        }
        serial.push((format!("{zone}: after {after}"), micros(to.saturating_sub(from))));
    }
    Step { serial, regions: named }
}

fn micros(time: Duration) -> f64 {
    time.as_secs_f64() * 1e6
}

/// Sums over all steps, by stage; for free, threads cost nothing.
fn summary(steps: &[Step], threads: usize, for_free: bool) -> BTreeMap<String, Share> {
    let mut all: BTreeMap<String, Share> = BTreeMap::new();
    for step in steps {
        for (stage, time) in &step.serial {
            all.entry(stage.clone()).or_default().serial += time;
        }
        for (stage, region) in &step.regions {
            let share = all.entry(stage.clone()).or_default();
            share.parallel += region.pieces.iter().map(|piece| micros(piece.time)).sum::<f64>();
            share.modelled += modelled(region, threads, for_free);
            share.regions += 1;
            share.phases += phases(region);
            share.pieces += region.pieces.len();
        }
    }
    all
}

fn total(all: &BTreeMap<String, Share>) -> Share {
    all.values().fold(Share::default(), |sum, share| Share {
        serial: sum.serial + share.serial,
        parallel: sum.parallel + share.parallel,
        modelled: sum.modelled + share.modelled,
        regions: sum.regions + share.regions,
        phases: sum.phases + share.phases,
        pieces: sum.pieces + share.pieces,
    })
}

fn phases(region: &Region) -> usize {
    region.pieces.last().map_or(0, |last| last.phase + 1)
}

/// How long threads take for a region (µs).
fn modelled(region: &Region, threads: usize, for_free: bool) -> f64 {
    let width = region.pieces.iter().map(|piece| piece.owner + 1).max().unwrap_or(1).min(threads);
    if width < 2 || region.pieces.len() < 2 {
        return region.pieces.iter().map(|piece| micros(piece.time)).sum();
    }
    let costs = if for_free { 0.0 } else { width as f64 * (REGION_COST + PHASE_COST * phases(region) as f64) };
    costs + if region.is_flow { flow(region, width, if for_free { 0.0 } else { PHASE_COST }) } else { phased(region, width) }
}

/// Phase after phase: whoever is free does the next piece of his own, or of the one who has most left.
fn phased(region: &Region, width: usize) -> f64 {
    let mut sum = 0.0;
    for pieces in region.pieces.chunk_by(|a, b| a.phase == b.phase) {
        let mut own: Vec<std::collections::VecDeque<f64>> = vec![Default::default(); width];
        pieces.iter().for_each(|piece| own[piece.owner % width].push_back(micros(piece.time)));
        let mut free: BinaryHeap<Reverse<(u64, usize)>> = (0..width).map(|thread| Reverse((0, thread))).collect();
        let mut end = 0_u64;
        while let Some(Reverse((at, thread))) = free.pop() {
            let next = own[thread].pop_front().or_else(|| {
                let most = (0..width).max_by_key(|&other| own[other].len())?;
                own[most].pop_back()
            });
            let Some(time) = next else { continue };
            // In ns: a heap wants what can be ordered.
            let done = at + (time * 1e3) as u64;
            end = end.max(done);
            free.push(Reverse((done, thread)));
        }
        sum += end as f64 * 1e-3;
    }
    sum
}

/// Each thread goes through its own pieces, and waits for what each needs: a little longer for what another has done.
fn flow(region: &Region, width: usize, wait: f64) -> f64 {
    let (mut free, mut done) = (vec![0.0_f64; width], Vec::with_capacity(region.pieces.len()));
    for piece in &region.pieces {
        let needed = piece.needs.iter().map(|&earlier: &usize| done[earlier] + wait);
        let start = needed.fold(free[piece.owner % width], f64::max);
        free[piece.owner % width] = start + micros(piece.time);
        done.push(free[piece.owner % width]);
    }
    free.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::panic::Location;

    use longspan::trace::Piece;

    use super::*;

    fn region(pieces: &[(usize, usize, u64, &[usize])], is_flow: bool) -> Region {
        let piece = |&(phase, owner, time, needs): &(usize, usize, u64, &[usize])| Piece {
            phase,
            owner,
            time: Duration::from_micros(time),
            needs: needs.to_vec(),
        };
        Region { at: Location::caller(), time: [Duration::ZERO; 3], pieces: pieces.iter().map(piece).collect(), is_flow }
    }

    #[test]
    fn phases_wait_for_their_longest_thread_and_idle_threads_help() {
        let pieces: &[(usize, usize, u64, &[usize])] =
            &[(0, 0, 10, &[]), (0, 1, 2, &[]), (0, 1, 2, &[]), (1, 0, 3, &[]), (1, 0, 3, &[]), (1, 1, 1, &[])];
        assert!((phased(&region(pieces, false), 2) - (10.0 + 4.0)).abs() < 0.01);
        assert!((modelled(&region(pieces, false), 1, true) - 21.0).abs() < 0.01);
    }

    #[test]
    fn in_a_flow_a_piece_waits_for_what_it_needs_alone() {
        let pieces: &[(usize, usize, u64, &[usize])] =
            &[(0, 0, 10, &[]), (0, 1, 2, &[]), (0, 1, 2, &[]), (0, 1, 2, &[0]), (0, 0, 1, &[2])];
        assert!((flow(&region(pieces, true), 2, 0.0) - 12.0).abs() < 0.01);
    }
}
