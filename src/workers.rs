//! Who does the independent parts of a step: the calling thread, threads of the world's own, or the host's job system.
//!
//! Parts share nothing and are the same whoever does them, so the bits of a step do not depend on it.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::{Error, ErrorKind, Result};

/// A host's job system.
pub trait ParallelFor: Send + Sync {
    /// Calls `part` once for each number below `count`, on any threads and in any order, and returns when all calls have
    /// returned. What it leaves out is done afterwards on the calling thread; what it does twice is done once.
    fn run(&self, count: usize, part: &(dyn Fn(usize) + Sync));
}

/// Pieces into which work is cut at most.
pub(crate) const MOST_PIECES: usize = 64;

/// Pieces for each thread: one may come late.
const PIECES_EACH: usize = 8;

/// The threads of a world.
#[derive(Default)]
pub(crate) struct Workers {
    /// The calling thread does its share: these are one fewer than there are in all.
    own: Option<rayon::ThreadPool>,
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
        let builder = rayon::ThreadPoolBuilder::new().num_threads(count - 1).thread_name(|i| format!("longspan-{i}"));
        Ok(Self { own: Some(builder.build().map_err(refused)?), host: None })
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

    /// Length of the pieces into which `count` things are cut, of which `least` are worth another thread's while.
    pub(crate) fn piece(&self, count: usize, least: usize) -> usize {
        let pieces = match (&self.host, &self.own) {
            (Some(_), _) => MOST_PIECES,
            (None, Some(pool)) => MOST_PIECES.min(PIECES_EACH * (pool.current_num_threads() + 1)),
            (None, None) => 1,
        };
        count.div_ceil(pieces).max(least)
    }

    /// Works on all pieces, side by side.
    pub(crate) fn share<T: Send>(&self, mut pieces: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
        if self.is_alone() {
            return pieces.for_each(work);
        }
        loop {
            let waiting = [const { Mutex::new(None) }; MOST_PIECES];
            let count = waiting.iter().zip(&mut pieces).map(|(place, piece)| *lock(place) = Some(piece)).count();
            let part = |number: usize| {
                let piece = waiting.get(number).and_then(|place| lock(place).take());
                if let Some(piece) = piece {
                    work(piece);
                }
            };
            match (&self.host, &self.own) {
                _ if count < 2 => (),
                (Some(host), _) => host.run(count, &part),
                (None, Some(pool)) => {
                    let next = AtomicUsize::new(0);
                    let numbers = || std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
                    let take_all = || numbers().take_while(|&number| number < count).for_each(part);
                    pool.in_place_scope(|scope| {
                        (1..count).take(pool.current_num_threads()).for_each(|_| scope.spawn(|_| take_all()));
                        take_all();
                    });
                }
                (None, None) => (),
            }
            (0..count).for_each(part);
            if count < MOST_PIECES {
                return;
            }
        }
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
}
