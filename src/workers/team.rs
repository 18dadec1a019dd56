//! Threads of a pool that stay awake for a step, and the work that they share.
//!
//! The threads are rayon's, of a pool of the world's own or one of the host's, and sleep where rayon has them sleep. A thread that has gone to
//! sleep takes 50 µs and more to begin, as long as many a part of a step, so a step calls them once, all together, and they look for its
//! regions until it ends. Nobody waits for them: what they do not come for, others do. So a pool whose threads are busy elsewhere, or one
//! whose own thread makes the step, or two worlds in one pool, make a step slower and nothing else.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::thread::JoinHandle;
use std::time::Duration;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::pieces::{Pieces, Store};
use super::region::{Line, MAX_OWNERS, MAX_PHASES, MAX_REGION, Needs, Regions};
use super::wait::{LOOKS, pause};
use super::{PIECES_EACH, useful_threads};
use crate::platform::Moment;

/// For how long a member looks for the next region within a step before it goes back to its pool.
const PATIENCE: Duration = Duration::from_millis(2);

/// No thread of the pool.
const NOBODY: usize = usize::MAX;

/// The threads of a world, the calling one among them.
pub(super) struct Team {
    pool: Option<Arc<ThreadPool>>,
    /// Threads of the world's own.
    own: Vec<JoinHandle<()>>,
    shared: Arc<Shared>,
    /// Held by the thread whose region it is: reads of a world call from any number of threads.
    caller: Mutex<Draft>,
}

/// What the calling thread and its members share.
struct Shared {
    regions: Regions,
    /// Odd while a step is under way.
    step: Line<AtomicU64>,
    /// Members that look for regions.
    attending: AtomicUsize,
    /// Threads of the pool that have been called and have not come yet.
    waiting: AtomicUsize,
    /// Number that the thread which makes the step has in the pool.
    caller: AtomicUsize,
    /// Step in which they were called last.
    called: AtomicU64,
    /// Whether the last step has had a region.
    is_used: AtomicBool,
}

/// A region as it is put together.
#[derive(Default)]
struct Draft {
    store: Store,
    /// Phase and owner of each piece.
    pieces: Vec<(u8, u8)>,
    counts: Vec<u16>,
}

impl Team {
    /// Threads of the world's own, so many with the calling one.
    pub(super) fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let threads = threads.min(MAX_OWNERS);
        let mut own = Vec::new();
        let pool = ThreadPoolBuilder::new().num_threads(threads - 1).spawn_handler(|thread| {
            let builder = std::thread::Builder::new().name(format!("longspan-{}", thread.index()));
            own.push(builder.spawn(|| thread.run())?);
            Ok(())
        });
        let pool = Arc::new(pool.build()?);
        Ok(Self::of_pool(pool, own, threads))
    }

    /// The threads of a host's pool: as many in all as it has, of which one is left out where another makes the step.
    pub(super) fn of_host(pool: Arc<ThreadPool>) -> Self {
        let threads = pool.current_num_threads().min(MAX_OWNERS);
        Self::of_pool(pool, Vec::new(), threads)
    }

    fn of_pool(pool: Arc<ThreadPool>, own: Vec<JoinHandle<()>>, threads: usize) -> Self {
        let shared = Self::shared(threads);
        Self { pool: Some(pool), own, shared, caller: Mutex::default() }
    }

    fn shared(threads: usize) -> Arc<Shared> {
        Arc::new(Shared {
            regions: Regions::new(threads),
            step: Line::default(),
            attending: AtomicUsize::new(0),
            waiting: AtomicUsize::new(0),
            caller: AtomicUsize::new(NOBODY),
            called: AtomicU64::new(0),
            is_used: AtomicBool::new(false),
        })
    }

    /// No threads, but work is cut for so many, and what is done of it noted.
    #[cfg(feature = "trace")]
    pub(super) fn simulated(threads: usize) -> Self {
        let shared = Self::shared(threads.clamp(1, MAX_OWNERS));
        Self { pool: None, own: Vec::new(), shared, caller: Mutex::default() }
    }

    /// Threads in all.
    pub(super) fn threads(&self) -> usize {
        self.shared.regions.threads()
    }

    /// Works on all pieces, which are nobody's: a number of threads after one another has those in a row.
    #[cfg_attr(feature = "trace", track_caller)]
    pub(super) fn share<T: Send>(&self, mut pieces: impl Iterator<Item = T>, work: &(impl Fn(T) + Sync)) {
        let Some(mut draft) = self.draft() else { return pieces.for_each(work) };
        let Draft { store, pieces: places, counts } = &mut *draft;
        let mut kept = store.begin();
        loop {
            pieces.by_ref().take(MAX_REGION).for_each(|piece| kept.push(piece));
            let count = kept.len();
            let is_cut_short = count < PIECES_EACH * self.threads();
            let width = if is_cut_short { useful_threads(count as f32, 1, self.threads()).min(count) } else { self.threads() };
            places.clear();
            places.extend((0..count).map(|number| (0, (number * width / count) as u8)));
            self.run(&mut kept, (places, None), counts, work);
            if count < MAX_REGION {
                return;
            }
        }
    }

    /// Works on all pieces, each with the number of its phase and that of the thread that it is meant for.
    #[cfg_attr(feature = "trace", track_caller)]
    pub(super) fn share_in_phases<T: Send>(&self, pieces: impl Iterator<Item = (u32, usize, T)>, work: &(impl Fn(T) + Sync)) {
        let Some(mut draft) = self.draft() else { return pieces.for_each(|(.., piece)| work(piece)) };
        let Draft { store, pieces: places, counts } = &mut *draft;
        let mut kept = store.begin();
        let (mut last, mut phase) = (None, 0);
        places.clear();
        for (own, owner, piece) in pieces {
            let is_next = last.replace(own).is_some_and(|last| last != own);
            phase += usize::from(is_next);
            if phase == MAX_PHASES || places.len() == MAX_REGION {
                self.run(&mut kept, (places, None), counts, work);
                places.clear();
                phase = 0;
            }
            places.push((phase as u8, (owner % self.threads()) as u8));
            kept.push(piece);
        }
        self.run(&mut kept, (places, None), counts, work);
    }

    /// Works on all pieces, each with the number of the thread that it is meant for, which wait for the earlier ones that `needs` names, and for
    /// earlier ones of the same thread. More than a region has are done by this thread.
    #[cfg_attr(feature = "trace", track_caller)]
    pub(super) fn share_in_flow<T: Send>(
        &self,
        pieces: impl Iterator<Item = (usize, T)>,
        needs: Needs<'_>,
        work: &(impl Fn(T) + Sync),
    ) {
        let Some(mut draft) = self.draft() else { return pieces.for_each(|(_, piece)| work(piece)) };
        let Draft { store, pieces: places, counts } = &mut *draft;
        let mut kept = store.begin();
        places.clear();
        for (owner, piece) in pieces {
            places.push((0, (owner % self.threads()) as u8));
            kept.push(piece);
        }
        if places.len() > MAX_REGION {
            places.iter_mut().for_each(|place| place.1 = 0);
        }
        self.run(&mut kept, (places, Some(needs)), counts, work);
    }

    /// The place where a region is put together; none while the team is at work for another thread, or for this one further out.
    fn draft(&self) -> Option<MutexGuard<'_, Draft>> {
        match self.caller.try_lock() {
            Ok(draft) => {
                #[cfg(feature = "trace")]
                super::trace::begin();
                Some(draft)
            }
            Err(TryLockError::Poisoned(draft)) => Some(draft.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Works on the pieces of a region with all threads that it is for.
    #[cfg_attr(feature = "trace", track_caller)]
    fn run<T: Send>(
        &self,
        kept: &mut Pieces<'_, T>,
        (places, needs): (&[(u8, u8)], Option<Needs<'_>>),
        counts: &mut Vec<u16>,
        work: &(impl Fn(T) + Sync),
    ) {
        let shared = &*self.shared;
        let pieces = kept.written();
        // SAFETY: each number is once in the order of the region, and claimed once; or called for once below.
        let task = |number: usize| work(unsafe { pieces.take(number) });
        #[cfg(feature = "trace")]
        if self.pool.is_none() {
            let width = places.iter().map(|place| usize::from(place.1) + 1).max().unwrap_or(0);
            if places.len() > 1 && width > 1 {
                // SAFETY: no thread goes through regions. To put this one in order is part of what it costs.
                unsafe { shared.regions.open(places, width, counts, &task, needs) };
            }
            super::trace::record(std::panic::Location::caller(), (places, needs), &task);
            return kept.clear();
        }
        let width = places.iter().map(|place| usize::from(place.1) + 1).max().unwrap_or(0);
        if places.len() < 2 || width < 2 {
            (0..places.len()).for_each(task);
        } else {
            // Reads of a world have threads come for one region.
            let is_step = shared.step.0.load(Ordering::Relaxed) % 2 == 1;
            let _watch = (!is_step).then(|| self.begin_step());
            // SAFETY: the caller's place is held, and this thread goes through the region here.
            unsafe { shared.regions.open(places, width, counts, &task, needs) };
            shared.is_used.store(true, Ordering::Relaxed);
            let is_called = shared.called.load(Ordering::Relaxed) == shared.step.0.load(Ordering::Relaxed);
            if !is_called || shared.attending.load(Ordering::Relaxed) == 0 {
                self.call();
            }
            shared.regions.work(shared.regions.opened(), 0);
            if let Some(panic) = shared.regions.take_panic() {
                resume_unwind(panic);
            }
        }
        kept.clear();
    }

    /// Has all threads of the pool look for regions until the step ends, unless some have not come for the last call yet.
    fn call(&self) {
        let shared = &self.shared;
        let Some(pool) = self.pool.as_ref().filter(|_| shared.waiting.load(Ordering::Relaxed) == 0) else { return };
        shared.caller.store(pool.current_thread_index().unwrap_or(NOBODY), Ordering::Relaxed);
        shared.called.store(shared.step.0.load(Ordering::Relaxed), Ordering::Relaxed);
        shared.waiting.store(pool.current_num_threads(), Ordering::Release);
        let shared = shared.clone();
        pool.spawn_broadcast(move |context| shared.come(context.index()));
    }

    /// Keeps members awake until the watch is dropped; calls them at once if they have been needed while the last one was kept.
    pub(super) fn watch(&self) -> Watch {
        let watch = self.begin_step();
        if self.shared.is_used.swap(false, Ordering::Relaxed) {
            self.call();
        }
        watch
    }

    fn begin_step(&self) -> Watch {
        self.shared.step.0.fetch_add(1, Ordering::Relaxed);
        Watch(self.shared.clone())
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        // Its threads end when they have nothing to do; a host's pool goes on.
        self.pool = None;
        for thread in self.own.drain(..) {
            // What it has panicked of was a piece's, and has been handed on.
            let _ = thread.join();
        }
    }
}

/// While it lives, members stay awake between regions.
pub(crate) struct Watch(Arc<Shared>);

impl Drop for Watch {
    fn drop(&mut self) {
        self.0.step.0.fetch_add(1, Ordering::Relaxed);
    }
}

impl Shared {
    /// What a thread of the pool does that has been called.
    fn come(&self, index: usize) {
        let caller = self.caller.load(Ordering::Relaxed);
        self.waiting.fetch_sub(1, Ordering::AcqRel);
        // The thread that makes the step is number 0, whether it is of the pool or not.
        let member = if index < caller { index + 1 } else { index };
        if index != caller && member < self.regions.threads() {
            self.attending.fetch_add(1, Ordering::Relaxed);
            self.attend(member);
            self.attending.fetch_sub(1, Ordering::Relaxed);
        }
    }

    /// Looks for regions within a step, and for a while, and goes through them.
    fn attend(&self, member: usize) {
        let step = self.step.0.load(Ordering::Acquire);
        let (mut seen, mut looks, mut from) = (0, 0, None);
        while step % 2 == 1 && self.step.0.load(Ordering::Relaxed) == step {
            let opened = self.regions.opened();
            if opened != seen {
                self.regions.work(opened, member);
                (seen, looks, from) = (opened, 0, None);
                continue;
            }
            looks += 1;
            pause(looks);
            if looks % LOOKS == 0 && Moment::now().since(*from.get_or_insert_with(Moment::now)) > PATIENCE {
                return;
            }
        }
    }
}
