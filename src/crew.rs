//! Threads of a world's own, for loops that are too short to be handed to a job system.
//!
//! The thread that steps *leads*: it offers the numbers of one loop after another in one atomic word, and works on them itself.
//!
//! ```text
//! leader   offers 0 … 23 · takes 0, 1, 2 … from the front ┐
//! helper                   takes 23, 22 … from the back   ┴ all done · next loop …
//! ```
//!
//! The leader takes from the front and helpers from the back, so that on two threads each sees the same bodies and pairs in every loop
//! and finds them in its own cache. Nobody waits for a number that nobody has taken: where helpers come late, or never, the leader
//! does everything. A helper that finds nothing looks on for a moment, as loops follow one another, and then sleeps until it is woken.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

/// Looks at the word before a helper sleeps: some 20 µs, about what waking it takes.
const LOOKS: u32 = 500;

/// Looks before the leader lets others run. What it waits for takes microseconds, unless the system has put a helper to sleep.
const PATIENCE: u32 = 5000;

/// A loop's work on one number.
type Work<'a> = &'a (dyn Fn(usize) + Sync);

/// What leader and helpers share.
#[derive(Default)]
struct Board {
    /// Numbers of the loop that nobody has taken, front (upper half) to back.
    offer: AtomicU64,
    /// Numbers that helpers have done.
    done: AtomicUsize,
    /// Work of the loop; that of the last one where none is open.
    work: Mutex<Option<Work<'static>>>,
    /// What a helper's work that failed said.
    failure: Mutex<Option<Box<dyn Any + Send>>>,
    is_closed: AtomicBool,
}

impl Board {
    /// Takes a number from the front or the back, if any is left.
    fn take(&self, from_back: bool) -> Option<usize> {
        let mut offer = self.offer.load(Ordering::SeqCst);
        loop {
            let (front, back) = (offer >> 32, offer & u64::from(u32::MAX));
            if front >= back {
                return None;
            }
            let (left, number) = if from_back { (offer - 1, back - 1) } else { (offer + (1 << 32), front) };
            match self.offer.compare_exchange_weak(offer, left, Ordering::AcqRel, Ordering::SeqCst) {
                Ok(_) => return Some(number as usize),
                Err(now) => offer = now,
            }
        }
    }

    /// Works on loops until the crew is dismissed.
    fn help(&self, is_asleep: &AtomicBool) {
        let mut looks = 0;
        while !self.is_closed.load(Ordering::SeqCst) {
            if let Some(number) = self.take(true) {
                let work = *lock(&self.work);
                let done = work.map(|work| catch_unwind(AssertUnwindSafe(|| work(number))));
                if let Some(Err(failure)) = done {
                    lock(&self.failure).get_or_insert(failure);
                }
                self.done.fetch_add(1, Ordering::Release);
                looks = 0;
            } else if looks < LOOKS {
                looks += 1;
                std::hint::spin_loop();
            } else {
                is_asleep.store(true, Ordering::SeqCst);
                // What was offered before the leader could see that this helper sleeps is seen here.
                let offer = self.offer.load(Ordering::SeqCst);
                if offer >> 32 >= offer & u64::from(u32::MAX) && !self.is_closed.load(Ordering::SeqCst) {
                    std::thread::park();
                }
                is_asleep.store(false, Ordering::SeqCst);
                looks = 0;
            }
        }
    }
}

/// A loop that is open: it takes back what nobody has taken, and waits for what helpers have, also where the leader's work panics.
struct Open<'a> {
    board: &'a Board,
    /// Numbers that the leader has not taken.
    others: usize,
}

impl Drop for Open<'_> {
    fn drop(&mut self) {
        let offer = self.board.offer.swap(0, Ordering::AcqRel);
        let left = (offer & u64::from(u32::MAX)).saturating_sub(offer >> 32) as usize;
        let mut looks = 0_u32;
        while self.board.done.load(Ordering::Acquire) + left < self.others {
            looks += 1;
            if looks.is_multiple_of(PATIENCE) {
                std::thread::yield_now();
            } else {
                std::hint::spin_loop();
            }
        }
    }
}

struct Helper {
    thread: JoinHandle<()>,
    is_asleep: Arc<AtomicBool>,
}

impl Helper {
    fn wake(&self) {
        if self.is_asleep.swap(false, Ordering::SeqCst) {
            self.thread.thread().unpark();
        }
    }
}

/// The helpers of whoever leads.
pub(crate) struct Crew {
    board: Arc<Board>,
    helpers: Vec<Helper>,
}

impl Crew {
    /// # Errors
    /// The system gave no more threads.
    pub(crate) fn new(helpers: usize) -> std::io::Result<Self> {
        let mut crew = Self { board: Arc::default(), helpers: Vec::new() };
        for number in 1..=helpers {
            let (board, is_asleep) = (crew.board.clone(), Arc::<AtomicBool>::default());
            let asleep = is_asleep.clone();
            let thread = Builder::new().name(format!("longspan-{number}")).spawn(move || board.help(&asleep))?;
            crew.helpers.push(Helper { thread, is_asleep });
        }
        Ok(crew)
    }

    /// Calls `work` once for each number below `count`, side by side, and returns when all calls have.
    pub(crate) fn for_each(&mut self, count: usize, work: Work<'_>) {
        let board = &*self.board;
        // SAFETY: only the lifetime is lost. A helper calls the work for a number that it has taken and not done yet, and numbers are
        // offered after this and until `Open` is dropped, which waits for those that are not done, also where a call panics. Nobody
        // else offers any meanwhile: the crew is borrowed.
        let work: Work<'static> = unsafe { std::mem::transmute::<Work<'_>, Work<'static>>(work) };
        *lock(&board.work) = Some(work);
        board.done.store(0, Ordering::Relaxed);
        let mut open = Open { board, others: count };
        board.offer.store(count as u64, Ordering::SeqCst);
        self.helpers.iter().take(count.saturating_sub(1)).for_each(Helper::wake);
        while let Some(number) = board.take(false) {
            open.others -= 1;
            work(number);
        }
        drop(open);
        let failure = lock(&board.failure).take();
        if let Some(failure) = failure {
            resume_unwind(failure);
        }
    }
}

impl Drop for Crew {
    fn drop(&mut self) {
        self.board.is_closed.store(true, Ordering::SeqCst);
        for helper in self.helpers.drain(..) {
            helper.wake();
            // A helper catches what its work throws.
            let _ = helper.thread.join();
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_done_once_by_any_number_of_threads() {
        for helpers in [0, 1, 2, 7] {
            let mut crew = Crew::new(helpers).unwrap();
            let counts: Vec<AtomicUsize> = (0..103).map(|_| AtomicUsize::new(0)).collect();
            for round in 1..=300 {
                crew.for_each(counts.len(), &|number| _ = counts[number].fetch_add(1, Ordering::Relaxed));
                assert!(counts.iter().all(|count| count.load(Ordering::Relaxed) == round), "{helpers} helpers, round {round}");
                if round % 100 == 0 {
                    // Long enough for helpers to fall asleep.
                    std::thread::sleep(std::time::Duration::from_millis(2));
                }
            }
        }
    }

    #[test]
    fn a_panic_of_any_part_is_passed_on_and_the_crew_works_on() {
        let mut crew = Crew::new(2).unwrap();
        for bad in [0, 1, 50, 99] {
            let failed = AssertUnwindSafe(|| crew.for_each(100, &|number| assert_ne!(number, bad, "as it should")));
            assert!(catch_unwind(failed).is_err(), "part {bad} has failed in silence");
            let sum = AtomicUsize::new(0);
            crew.for_each(100, &|number| _ = sum.fetch_add(number, Ordering::Relaxed));
            assert_eq!(sum.into_inner(), 4950, "after part {bad} failed");
        }
    }
}
