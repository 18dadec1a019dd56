//! Records the regions of steps, as they would be cut for some number of threads, on one: for `longspan-bench trace`.
//!
//! Only there with the feature `trace`. A world made while [`simulate`] asks for threads has none; each of its pieces is done by the calling
//! thread, in order, and its time is noted.

use std::cell::{Cell, RefCell};
use std::panic::Location;
use std::time::Duration;

use super::region::Needs;

/// A part of a step that is divided among threads.
#[derive(Debug, Clone)]
pub struct Region {
    /// Where it is shared out.
    pub at: &'static Location<'static>,
    /// When it began to be cut into pieces, when it was cut, and when the last of them was done and noted, by the clock.
    pub time: [Duration; 3],
    /// Its pieces, in their order.
    pub pieces: Vec<Piece>,
    /// Whether pieces wait for some others, not for all of an earlier phase.
    pub is_flow: bool,
}

/// What one thread does at a time.
#[derive(Debug, Clone)]
pub struct Piece {
    /// Phase that it is of.
    pub phase: usize,
    /// Thread that it is meant for.
    pub owner: usize,
    /// How long it took.
    pub time: Duration,
    /// Earlier pieces that it waits for, beside those of its own thread.
    pub needs: Vec<usize>,
}

thread_local! {
    static THREADS: Cell<Option<usize>> = const { Cell::new(None) };
    static CLOCK: Cell<fn() -> Duration> = const { Cell::new(|| Duration::ZERO) };
    static BEGUN: Cell<Duration> = const { Cell::new(Duration::ZERO) };
    static REGIONS: RefCell<Vec<Region>> = const { RefCell::new(Vec::new()) };
}

/// Has worlds that this thread makes from now on be cut for so many threads without having any, or no longer. `clock` says how much time
/// the calling thread has had of a processor: where others want it too, wall time would be theirs.
pub fn simulate(threads: Option<usize>, clock: fn() -> Duration) {
    THREADS.set(threads);
    CLOCK.set(clock);
}

fn now() -> Duration {
    CLOCK.get()()
}

/// The regions that this thread has gone through since the last call.
pub fn take() -> Vec<Region> {
    REGIONS.take()
}

pub(super) fn simulated() -> Option<usize> {
    THREADS.get()
}

/// A region begins to be cut into pieces.
pub(super) fn begin() {
    BEGUN.set(now());
}

/// Works on the pieces of a region, each by its phase and owner, and notes it.
pub(super) fn record(at: &'static Location<'static>, (places, needs): (&[(u8, u8)], Option<Needs<'_>>), task: &dyn Fn(usize)) {
    let begun = BEGUN.get();
    let cut = now();
    let mut pieces = Vec::with_capacity(places.len());
    let mut last = now();
    for (number, &(phase, owner)) in places.iter().enumerate() {
        task(number);
        let done = now();
        let mut own = Vec::new();
        if let Some(needs) = needs {
            needs(number, &mut |earlier| own.push(earlier));
        }
        pieces.push(Piece { phase: usize::from(phase), owner: usize::from(owner), time: done.saturating_sub(last), needs: own });
        last = now();
    }
    let region = Region { at, time: [begun, cut, now()], pieces, is_flow: needs.is_some() };
    REGIONS.with_borrow_mut(|regions| regions.push(region));
    begin();
}
