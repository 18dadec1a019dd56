//! Runs the independent parts of a step: on the calling thread, on threads of the world, or on the host's job system.
//!
//! Parts share nothing and are the same whoever does them, so the bits of a step do not depend on it.

mod team;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::{Error, ErrorKind, Result};
use team::{Team, Watch, is_soon, wait_until};

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

/// Pieces of phases that are handed out together: a step's sweep has a dozen phases.
const MAX_IN_PHASES: usize = 128;

/// The threads of a world.
#[derive(Default)]
pub(crate) struct Workers {
    /// The calling thread does its share: these are one fewer than there are in all.
    own: Option<Team>,
    host: Option<Arc<dyn ParallelFor>>,
}

impl Workers {
    /// Threads of the world's own, the calling one among them; as many as the machine has for zero.
    pub(crate) fn new(count: u32) -> Result<Self> {
        let count = if count == 0 { std::thread::available_parallelism().map_or(1, usize::from) } else { count as usize };
        if count == 1 {
            return Ok(Self::default());
        }
        let refused = |_| Error::new(ErrorKind::CapacityExceeded, "threads", "the system gave no more threads");
        Ok(Self { own: Some(Team::new(count - 1).map_err(refused)?), host: None })
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

    /// Whether threads of its own do it, which look for work all the time within a step: short pieces pay, and may wait for others.
    pub(crate) fn has_team(&self) -> bool {
        self.own.is_some() && self.host.is_none()
    }

    /// Threads that there are, the calling one among them, as far as it is known.
    pub(crate) fn count(&self) -> usize {
        1 + self.own.as_ref().filter(|_| self.host.is_none()).map_or(0, Team::len)
    }

    /// Places that pieces of phases may be meant for: as many as there are threads, some at least where the host does the work.
    pub(crate) fn places(&self) -> usize {
        if self.has_host() { PIECES_EACH } else { self.count().min(MAX_PIECES) }
    }

    /// Has threads of its own stay awake for a step, until the watch is dropped.
    pub(crate) fn watch(&self) -> Option<Watch> {
        self.own.as_ref().filter(|_| self.host.is_none()).map(Team::watch)
    }

    /// Length of the pieces into which `count` things are cut, of which `least` are worth another thread's while.
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
    pub(crate) fn share<T: Send>(&self, pieces: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
        if self.is_alone() { pieces.for_each(work) } else { self.share_out(pieces, work) }
    }

    /// Works on all pieces with other threads. Never inlined: its arrays of pieces would lie on the stack of a thread that is alone,
    /// too, where several of them side by side are a hundred kilobytes that a cold step fetches for nothing.
    #[inline(never)]
    fn share_out<T: Send>(&self, mut pieces: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
        let Some(host) = &self.host else {
            let Some(team) = &self.own else { return pieces.for_each(work) };
            return while share_some::<T, MAX_PIECES>(team, &mut pieces.by_ref().map(|piece| (0, None, piece)), &work) {};
        };
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

    /// Works on pieces, each meant for the thread of its number.
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
    pub(crate) fn share_in_phases<T: Send>(&self, pieces: impl Iterator<Item = (u32, usize, T)>, work: impl Fn(T) + Sync) {
        match self.own.as_ref().filter(|_| self.has_team()) {
            Some(team) => share_out_in_phases(team, pieces, work),
            None => pieces.for_each(|(.., piece)| work(piece)),
        }
    }
}

/// Works on the pieces of phases with a team; not inlined for the reason given at [`Workers::share_out`].
#[inline(never)]
fn share_out_in_phases<T: Send>(team: &Team, pieces: impl Iterator<Item = (u32, usize, T)>, work: impl Fn(T) + Sync) {
    let mut pieces = pieces.map(|(phase, owner, piece)| (phase, Some(owner), piece));
    while share_some::<T, MAX_IN_PHASES>(team, &mut pieces, &work) {}
}

/// Works on the next pieces, each with its phase and whose it is first of all, and says whether there may be more: a number of threads after
/// one another have those of a phase that are nobody's.
#[inline(never)]
fn share_some<T: Send, const MOST: usize>(
    team: &Team,
    pieces: &mut impl Iterator<Item = (u32, Option<usize>, T)>,
    work: &(impl Fn(T) + Sync),
) -> bool {
    let waiting = [const { Mutex::new(None) }; MOST];
    // Pieces before the end of each phase, and whose each piece is.
    let (mut ends, mut owners) = ([0; MOST], [None; MOST]);
    let (mut count, mut phases, mut phase) = (0, 0, None);
    for (own, owner, piece) in pieces.take(MOST) {
        phases += usize::from(phase != Some(own));
        phase = Some(own);
        *lock(&waiting[count]) = Some(piece);
        owners[count] = owner;
        count += 1;
        ends[phases - 1] = count;
    }
    let done = AtomicUsize::new(0);
    let take = |number: usize| {
        let piece = lock(&waiting[number]).take();
        if let Some(piece) = piece {
            // Counted whatever becomes of it: others wait for it.
            let _counted = Counted(&done);
            work(piece);
        }
    };
    if count < 2 {
        (0..count).for_each(take);
        return false;
    }
    let members = 1 + team.len();
    team.run(&|member| {
        let mut first = 0;
        for &end in &ends[..phases] {
            if done.load(Ordering::Acquire) < end {
                let is_own = |&number: &usize| owners[number].unwrap_or((number - first) * members / (end - first)) == member;
                (first..end).filter(is_own).for_each(take);
                let is_over = || done.load(Ordering::Acquire) >= end;
                if !is_soon(is_over) {
                    (first..end).rev().filter(|number| !is_own(number)).for_each(take);
                    wait_until(is_over);
                }
            }
            first = end;
        }
    });
    count == MOST
}

/// One more is done, once this is dropped.
struct Counted<'a>(&'a AtomicUsize);

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::Release);
    }
}

fn lock<T>(place: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
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
}
