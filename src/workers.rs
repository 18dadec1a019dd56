//! Runs the independent parts of a step: on the calling thread, on threads of a pool, or on the host's job system.
//!
//! Parts share nothing and are the same whoever does them, so the bits of a step do not depend on it.

mod pieces;
mod region;
mod team;
#[cfg(feature = "trace")]
pub mod trace;
mod wait;

use std::sync::{Arc, Mutex, PoisonError};

use rayon::ThreadPool;

use crate::error::{Error, ErrorKind, Result};
use team::{Team, Watch};

/// A host's job system.
pub trait ParallelFor: Send + Sync {
    /// Calls `part` once for each number below `count`, on any threads and in any order, and returns when all calls have
    /// returned. What it leaves out is done afterwards on the calling thread; what it does twice is done once.
    fn run(&self, count: usize, part: &(dyn Fn(usize) + Sync));
}

/// Pieces into which work is cut at most.
pub(crate) const MAX_PIECES: usize = 64;

/// Pieces for each thread: one may come late.
const PIECES_EACH: usize = 8;

/// What each thread adds to a region's time (µs): it has to learn of it, fetch what it is made of, and tell that it is done. Measured on 16
/// cores of one socket, 6.1 µs for 16 threads.
const REGION_COST: f32 = 0.38;

/// What each thread adds to a phase's time (µs): 1.8 µs for 16 threads on the same machine.
const PHASE_COST: f32 = 0.11;

/// Threads that finish `work` µs of one thread, in so many phases, soonest: each makes all the others wait longer, so that w/n + n (r + p b) is
/// least at n = √(w / (r + p b)).
fn useful_threads(work: f32, phases: usize, most: usize) -> usize {
    let best = (work / (REGION_COST + phases as f32 * PHASE_COST)).sqrt();
    (best as usize).clamp(1, most)
}

/// The threads of a world.
#[derive(Default)]
pub(crate) struct Workers {
    own: Option<Team>,
    host: Option<Arc<dyn ParallelFor>>,
}

impl Workers {
    /// Threads of the world's own, the calling one among them; as many as the machine has for zero.
    pub(crate) fn new(count: u32) -> Result<Self> {
        #[cfg(feature = "trace")]
        if let Some(threads) = trace::simulated() {
            return Ok(Self { own: Some(Team::simulated(threads)), host: None });
        }
        let count = if count == 0 { std::thread::available_parallelism().map_or(1, usize::from) } else { count as usize };
        if count == 1 {
            return Ok(Self::default());
        }
        let refused = |_| Error::new(ErrorKind::CapacityExceeded, "threads", "the system gave no more threads");
        Ok(Self { own: Some(Team::new(count).map_err(refused)?), host: None })
    }

    /// Has threads of the world's own do the work, as many as [`Workers::new`] makes.
    pub(crate) fn set_own(&mut self, count: u32) -> Result<()> {
        self.own = Self::new(count)?.own;
        Ok(())
    }

    /// Has the threads of a host's pool do the work instead of the world's own.
    pub(crate) fn set_pool(&mut self, pool: Arc<ThreadPool>) {
        self.own = (pool.current_num_threads() > 1).then(|| Team::of_host(pool));
    }

    /// Has the host's job system do the work, or no longer.
    pub(crate) fn set_host(&mut self, host: Option<Arc<dyn ParallelFor>>) {
        self.host = host;
    }

    /// Whether the calling thread does everything.
    pub(crate) fn is_alone(&self) -> bool {
        self.own.is_none() && self.host.is_none()
    }

    /// Whether the host's job system does the work, which it does in steps alone.
    pub(crate) fn has_host(&self) -> bool {
        self.host.is_some()
    }

    /// Whether threads of a pool do it, which look for work all the time within a step: short pieces pay, and may wait for others.
    pub(crate) fn has_team(&self) -> bool {
        self.team().is_some()
    }

    fn team(&self) -> Option<&Team> {
        self.own.as_ref().filter(|_| self.host.is_none())
    }

    /// Threads that there are, the calling one among them, as far as it is known.
    pub(crate) fn count(&self) -> usize {
        self.team().map_or(1, Team::threads)
    }

    /// Places that pieces of phases may be meant for: as many as there are threads, some at least where the host does the work.
    pub(crate) fn places(&self) -> usize {
        if self.has_host() { PIECES_EACH } else { self.count() }
    }

    /// Places for `work` µs of one thread in so many phases: no more than help.
    pub(crate) fn places_for(&self, work: f32, phases: usize) -> usize {
        if self.has_host() { PIECES_EACH } else { useful_threads(work, phases, self.count()) }
    }

    /// Has threads of a pool stay awake for a step, until the watch is dropped.
    pub(crate) fn watch(&self) -> Option<Watch> {
        self.team().map(Team::watch)
    }

    /// Length of the pieces into which `count` things are cut, of which `least` are worth another thread's while: some 1 µs.
    pub(crate) fn piece(&self, count: usize, least: usize) -> usize {
        let pieces = match (&self.host, &self.own) {
            (Some(_), _) => MAX_PIECES,
            (None, Some(_)) => MAX_PIECES.min(PIECES_EACH * self.count()),
            (None, None) => 1,
        };
        count.div_ceil(pieces).max(least)
    }

    /// Works on all pieces, side by side.
    #[inline]
    #[cfg_attr(feature = "trace", track_caller)]
    pub(crate) fn share<T: Send>(&self, pieces: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
        if self.is_alone() { pieces.for_each(work) } else { self.share_out(pieces, work) }
    }

    /// Works on all pieces with other threads. Never inlined, so that a thread that is alone meets nothing of it.
    #[inline(never)]
    #[cfg_attr(feature = "trace", track_caller)]
    fn share_out<T: Send>(&self, pieces: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
        match (&self.host, &self.own) {
            (Some(host), _) => share_with_host(&**host, pieces, work),
            (None, Some(team)) => team.share(pieces, &work),
            (None, None) => pieces.for_each(work),
        }
    }

    /// Works on pieces, each meant for the thread of its number.
    #[cfg_attr(feature = "trace", track_caller)]
    pub(crate) fn share_among_all<T: Send>(&self, pieces: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
        if self.has_host() {
            self.share(pieces, work);
        } else {
            self.share_in_phases(pieces.zip(0..).map(|(piece, owner)| (0, owner, piece)), work);
        }
    }

    /// Works on all pieces, each with the number of its phase and that of the thread that it is meant for: those of one phase side by side,
    /// and none before those of earlier ones are done. Who has done what was meant for it does what others have not begun.
    #[inline]
    #[cfg_attr(feature = "trace", track_caller)]
    pub(crate) fn share_in_phases<T: Send>(&self, pieces: impl Iterator<Item = (u32, usize, T)>, work: impl Fn(T) + Sync) {
        match self.team() {
            Some(team) => share_out_in_phases(team, pieces, work),
            None => pieces.for_each(|(.., piece)| work(piece)),
        }
    }

    /// Works on all pieces, each with the number of the thread that it is meant for. `needs` calls its second argument with the number of each
    /// earlier piece that the piece of a number waits for; it waits for all earlier ones of its own thread, too.
    #[inline]
    #[cfg_attr(feature = "trace", track_caller)]
    pub(crate) fn share_in_flow<T: Send>(
        &self,
        pieces: impl Iterator<Item = (usize, T)>,
        needs: impl Fn(usize, &mut dyn FnMut(usize)) + Sync,
        work: impl Fn(T) + Sync,
    ) {
        match self.team() {
            Some(team) => team.share_in_flow(pieces, &needs, &work),
            None => pieces.for_each(|(_, piece)| work(piece)),
        }
    }
}

/// Works on the pieces of phases with a team; not inlined for the reason given at [`Workers::share_out`].
#[inline(never)]
#[cfg_attr(feature = "trace", track_caller)]
fn share_out_in_phases<T: Send>(team: &Team, pieces: impl Iterator<Item = (u32, usize, T)>, work: impl Fn(T) + Sync) {
    team.share_in_phases(pieces, &work);
}

/// Works on all pieces with a host's job system, so many at a time.
fn share_with_host<T: Send>(host: &dyn ParallelFor, mut pieces: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
    loop {
        let waiting = [const { Mutex::new(None) }; MAX_PIECES];
        let count = waiting.iter().zip(&mut pieces).map(|(place, piece)| *lock(place) = Some(piece)).count();
        let part = |number: usize| {
            let piece = waiting.get(number).and_then(|place| lock(place).take());
            if let Some(piece) = piece {
                work(piece);
            }
        };
        if count > 1 {
            host.run(count, &part);
        }
        (0..count).for_each(part);
        if count < MAX_PIECES {
            return;
        }
    }
}

fn lock<T>(place: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    struct Careless;

    impl ParallelFor for Careless {
        fn run(&self, count: usize, part: &(dyn Fn(usize) + Sync)) {
            // Twice what is even, nothing of what is odd, and some that do not exist.
            (0..count + 5).step_by(2).chain((0..count).step_by(2)).for_each(part);
        }
    }

    #[test]
    fn everything_is_done_once_even_by_a_careless_host() {
        let mut careless = Workers::default();
        careless.set_host(Some(Arc::new(Careless)));
        for workers in [careless, Workers::default(), Workers::new(3).unwrap()] {
            for length in [workers.piece(1003, 10), 1] {
                let mut items = vec![0_u32; 1003];
                workers.share(items.chunks_mut(length), |chunk| chunk.iter_mut().for_each(|item| *item += 1));
                assert!(items.iter().all(|&item| item == 1), "pieces of {length}");
            }
        }
    }

    #[test]
    fn no_piece_begins_before_earlier_phases_are_done() {
        for workers in [Workers::default(), Workers::new(2).unwrap(), Workers::new(5).unwrap()] {
            let _watch = workers.watch();
            let begun: Vec<AtomicUsize> = (0..50).map(|_| AtomicUsize::new(0)).collect();
            let pieces = (0..200).map(|number| (number / 4, number as usize % 4, number as usize / 4));
            workers.share_in_phases(pieces, |phase| {
                assert!(begun[..phase].iter().all(|count| count.load(Ordering::Relaxed) == 4), "in phase {phase}");
                begun[phase].fetch_add(1, Ordering::Relaxed);
            });
            assert!(begun.iter().all(|count| count.load(Ordering::Relaxed) == 4), "{begun:?}");
        }
    }

    #[test]
    fn a_panic_of_any_thread_is_one_of_the_caller_and_the_team_goes_on() {
        let workers = Workers::new(3).unwrap();
        for _ in 0..20 {
            let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                workers.share_in_phases((0..40).map(|number| (number / 8, number as usize % 8, number)), |number| {
                    assert!(number != 13, "unlucky")
                });
            }));
            assert!(outcome.is_err());
        }
        let count = AtomicUsize::new(0);
        let add_one = || _ = count.fetch_add(1, Ordering::Relaxed);
        workers.share(0..100, |_| add_one());
        assert_eq!(count.into_inner(), 100);
    }

    #[test]
    fn a_team_may_be_called_from_several_threads_and_from_within() {
        let workers = Workers::new(3).unwrap();
        let count = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let add_one = |_| _ = count.fetch_add(1, Ordering::Relaxed);
                    for _ in 0..100 {
                        workers.share(0..5, |_| workers.share(0..3, add_one));
                    }
                });
            }
        });
        assert_eq!(count.into_inner(), 4 * 100 * 15);
    }

    #[test]
    fn more_phases_and_pieces_than_a_region_has_are_done_in_order() {
        let workers = Workers::new(4).unwrap();
        let _watch = workers.watch();
        let order: Vec<AtomicUsize> = (0..70_000).map(|_| AtomicUsize::new(0)).collect();
        let done = AtomicUsize::new(0);
        let pieces = (0..order.len()).map(|number| (number as u32 / 400, number % 9, number));
        workers.share_in_phases(pieces, |number| {
            assert!(done.fetch_add(1, Ordering::Relaxed) >= number / 400 * 400, "piece {number} is early");
            order[number].fetch_add(1, Ordering::Relaxed);
        });
        assert!(order.iter().all(|count| count.load(Ordering::Relaxed) == 1));
        workers.share(order.iter(), |count| _ = count.fetch_add(1, Ordering::Relaxed));
        assert!(order.iter().all(|count| count.load(Ordering::Relaxed) == 2));
    }

    #[test]
    fn each_piece_is_done_once_in_ten_thousand_short_regions() {
        let workers = Workers::new(5).unwrap();
        let mut sums = vec![0_u64; 40];
        for _ in 0..50 {
            let _watch = workers.watch();
            for _ in 0..200 {
                let pieces = sums.iter_mut().enumerate().map(|(number, sum)| (number as u32 / 10, number % 5, sum));
                workers.share_in_phases(pieces, |sum| *sum += 1);
            }
        }
        assert!(sums.iter().all(|&sum| sum == 10_000), "{sums:?}");
    }

    #[test]
    fn in_a_flow_each_piece_begins_after_those_it_waits_for() {
        // Storeys of ten columns; each piece waits for its neighbours above, and the last for all.
        let (columns, storeys) = (10, 60);
        for threads in [1, 2, 3, 10] {
            let workers = Workers::new(threads).unwrap();
            for _ in 0..5 {
                let _watch = workers.watch();
                let done: Vec<AtomicUsize> = (0..=columns * storeys).map(|_| AtomicUsize::new(0)).collect();
                let needs = |number: usize, need: &mut dyn FnMut(usize)| match number {
                    number if number == columns * storeys => (number - columns..number).for_each(need),
                    number if number < columns => {}
                    number => (0..columns)
                        .filter(|&c| c.abs_diff(number % columns) <= 1)
                        .for_each(|c| need((number / columns - 1) * columns + c)),
                };
                let pieces = (0..=columns * storeys).map(|number| (number % columns, number));
                workers.share_in_flow(pieces, needs, |number| {
                    needs(number, &mut |earlier| {
                        assert_eq!(done[earlier].load(Ordering::Relaxed), 1, "{number} before {earlier}")
                    });
                    done[number].fetch_add(1, Ordering::Relaxed);
                });
                assert!(done.iter().all(|count| count.load(Ordering::Relaxed) == 1));
            }
        }
    }

    #[test]
    fn a_pool_of_the_host_does_the_work_whoever_steps_and_two_worlds_may_share_it() {
        let pool = Arc::new(rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap());
        let count = AtomicUsize::new(0);
        let steps = || {
            let mut workers = Workers::default();
            workers.set_pool(pool.clone());
            for _ in 0..20 {
                let _watch = workers.watch();
                for _ in 0..5 {
                    workers.share(0..20, |_| _ = count.fetch_add(1, Ordering::Relaxed));
                }
            }
        };
        steps();
        pool.install(steps);
        pool.join(steps, steps);
        std::thread::scope(|scope| {
            scope.spawn(steps);
            scope.spawn(steps);
        });
        assert_eq!(count.into_inner(), 6 * 20 * 5 * 20);
    }

    #[test]
    fn threads_are_asked_for_work_that_feeds_them_alone() {
        assert_eq!(useful_threads(0.0, 1, 16), 1);
        assert_eq!(useful_threads(2.0, 1, 16), 2);
        assert_eq!(useful_threads(20.0, 1, 16), 6);
        assert_eq!(useful_threads(10_000.0, 1, 16), 16);
        assert!(useful_threads(50.0, 10, 16) < useful_threads(50.0, 1, 16), "more phases, more waiting");
    }
}
