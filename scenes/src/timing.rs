//! How long each step of a run takes, and what is told of it.

use std::ops::Range;
use std::time::Duration;

use crate::engine::Engine;
use crate::platform;
use crate::run::{RunError, Stage};
use crate::scene::Scene;
use crate::shifted::Shifted;
use crate::units::Converted;

/// Length of the busiest stretch (simulated s).
const BUSIEST: f64 = 1.0;

/// Times of the steps of one run (ms): CPU time of the stepping thread where one thread steps, else wall time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Timing {
    /// Over every step of the run.
    pub whole: Spread,
    /// Over the second of simulated time that takes longest; over the whole run if that is shorter.
    pub busiest: Spread,
    /// Simulated time at which that second begins (s).
    pub busiest_from: f64,
    /// Over the scene's own window, the last quarter of the run unless the scene says otherwise.
    pub last: Spread,
    /// The first step, which lays out what later ones keep (ms).
    pub first: f64,
    /// The longest step (ms).
    pub worst: f64,
    /// Which step that is, counting from 0.
    pub worst_step: u32,
    /// Median over a second window of the scene, under the scene's name for it.
    pub second_window: Option<(&'static str, f64)>,
}

/// Median and 99th percentile of some steps (ms).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The 99th percentile.
    pub p99: f64,
}

/// Runs `scene` on a fresh engine whose world was made from `scene.world`, and takes the time of every step.
///
/// Nothing is measured of the motion, so nothing but `between`, called before each step, and the scene's own script runs
/// between two steps. A run that the engine refuses ends there.
///
/// # Errors
/// If the engine cannot do what the scene's script asks.
pub fn time(scene: &Scene, engine: &mut dyn Engine, threads: usize, between: &mut dyn FnMut()) -> Result<Timing, RunError> {
    let mut engine = Shifted { engine, origin: scene.origin };
    let mut engine = Converted::new(&mut engine, scene.units, scene.world.gravity)?;
    let mut stage = Stage::set(scene, &mut engine);
    let mut times = Vec::with_capacity(scene.steps as usize);
    let mut bounds = vec![0.0];
    let mut script = scene.script.iter().peekable();
    for step in 0..scene.steps {
        if engine.refusal().is_some() {
            break;
        }
        while let Some(scheduled) = script.next_if(|scheduled| scheduled.step <= step) {
            stage.act(&scheduled.action, &mut engine)?;
        }
        between();
        times.push(timed(threads, || stage.step(&mut engine)));
        bounds.push(stage.time);
    }
    Ok(summary(scene, &bounds, &times))
}

fn timed(threads: usize, step: impl FnOnce()) -> Duration {
    if threads == 1 { platform::thread_time_of(step) } else { platform::time_of(step) }
}

fn summary(scene: &Scene, bounds: &[f64], times: &[Duration]) -> Timing {
    let second_window = scene.second_window.as_ref().and_then(|(name, window)| Some((*name, spread(times, window)?.median)));
    let busiest = busiest(bounds, times);
    let worst = (0..times.len()).max_by_key(|&step| times[step]).unwrap_or_default();
    let ms = |step: usize| times.get(step).map_or(0.0, |time| milliseconds(*time));
    Timing {
        whole: spread(times, &(0..times.len() as u32)).unwrap_or_default(),
        busiest: spread(times, &busiest).unwrap_or_default(),
        busiest_from: bounds.get(busiest.start as usize).copied().unwrap_or_default(),
        last: spread(times, &scene.window).unwrap_or_default(),
        first: ms(0),
        worst: ms(worst),
        worst_step: worst as u32,
        second_window,
    }
}

/// The steps of the second of simulated time with the greatest sum of times; step `i` lies between `bounds[i]` and `bounds[i + 1]`.
fn busiest(bounds: &[f64], times: &[Duration]) -> Range<u32> {
    // Simulated time is a sum of rounded steps.
    let longest = BUSIEST * (1.0 + 1.0e-4);
    let (mut best, mut most) = (0..0, Duration::ZERO);
    let (mut from, mut sum) = (0, Duration::ZERO);
    for (step, &time) in times.iter().enumerate() {
        sum += time;
        while from < step && bounds[step + 1] - bounds[from] > longest {
            sum -= times[from];
            from += 1;
        }
        if sum > most {
            (best, most) = (from..step + 1, sum);
        }
    }
    best.start as u32..best.end as u32
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Median and 99th percentile of the window; `None` if the run ended before it.
fn spread(times: &[Duration], window: &Range<u32>) -> Option<Spread> {
    let end = (window.end as usize).min(times.len());
    let mut sorted = times.get(window.start as usize..end)?.to_vec();
    sorted.sort_unstable();
    let at = |share: f64| sorted.get((share * (sorted.len().checked_sub(1)?) as f64).round() as usize).copied().map(milliseconds);
    Some(Spread { median: at(0.5)?, p99: at(0.99)? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::build;
    use crate::engine::Effort;
    use crate::longspan_engine::LongspanEngine;
    use crate::scene::DT;

    #[test]
    fn percentiles_are_taken_over_the_window_alone() {
        let times: Vec<Duration> = (1..=101).map(Duration::from_millis).collect();
        assert_eq!(spread(&times, &(0..101)), Some(Spread { median: 51.0, p99: 100.0 }));
        assert_eq!(spread(&times, &(99..101)).map(|spread| spread.median), Some(101.0));
        assert_eq!(spread(&times, &(200..300)), None);
    }

    #[test]
    fn the_busiest_second_is_found_wherever_it_lies_and_however_long_steps_are() {
        for rate in [30_u32, 60, 240] {
            let steps = 5 * rate;
            let bounds: Vec<f64> = (0..=steps).map(|step| f64::from(step) * f64::from(1.0 / rate as f32)).collect();
            let busy = 2 * rate + 7..3 * rate + 7;
            let times: Vec<Duration> =
                (0..steps).map(|step| Duration::from_micros(if busy.contains(&step) { 90 } else { 10 })).collect();
            assert_eq!(busiest(&bounds, &times), busy, "at {rate} Hz");
        }
        let short = [Duration::from_micros(1), Duration::from_micros(2)];
        assert_eq!(
            busiest(&[0.0, f64::from(DT), 2.0 * f64::from(DT)], &short),
            0..2,
            "a run shorter than a second is its own busiest"
        );
    }

    #[test]
    fn every_step_of_a_run_is_timed_after_other_work() {
        let scene = build("pile", &[("n".into(), "8".into()), ("seconds".into(), "1.5".into())]).unwrap();
        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1).unwrap();
        let mut calls = 0;
        let timing = time(&scene, &mut engine, 1, &mut || calls += 1).unwrap();
        assert_eq!(calls, scene.steps, "other work comes before each step");
        assert!(timing.first > 0.0 && timing.worst >= timing.first && timing.worst >= timing.busiest.p99, "{timing:?}");
        assert!(timing.busiest.median > 0.0 && timing.whole.median > 0.0 && timing.last.median > 0.0, "{timing:?}");
    }
}
