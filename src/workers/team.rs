//! Threads that stay awake for a step, and the tasks that they share.
//!
//! A thread that has gone to sleep takes 50 µs and more to begin, as long as many a part of a step. So between the regions of a step
//! the members of a team look for the next one, for a while, and sleep only between steps.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, TryLockError};
use std::thread::JoinHandle;
use std::time::Duration;

use super::lock;
use crate::platform::Moment;

/// Looks at what is waited for before the processor is offered to others between any two: some 3 µs. Where threads share a processor, the
/// one that is waited for is not at work meanwhile.
const LOOKS: u32 = 128;

/// Looks before a thread that has done its own does what others have not begun: some 0.5 µs.
const LOOKS_FOR_MORE: u32 = 16;

/// For how long a member looks for the next region within a step before it goes to sleep.
const PATIENCE: Duration = Duration::from_millis(2);

/// What all members, and the thread that has called them, do at once until there is nothing left of it, each with its number.
type Task = &'static (dyn Fn(usize) + Sync);

/// Threads that wait for regions.
pub(super) struct Team {
    post: Arc<Shared>,
    members: Vec<JoinHandle<()>>,
    /// Held by the thread whose region it is: reads of a world call from any number of threads.
    caller: Mutex<()>,
}

/// Where members find the next region.
#[derive(Default)]
struct Shared {
    notice: Mutex<State>,
    call: Condvar,
    /// Number of the last region, which can be looked at without the notice.
    last: AtomicU64,
    /// Members within the region that is open, or was last.
    inside: AtomicUsize,
    /// Whether a step is under way.
    is_watched: AtomicBool,
    /// Whether the last step has had a region.
    is_used: AtomicBool,
}

#[derive(Default)]
struct State {
    /// The region that is open.
    region: Option<Task>,
    number: u64,
    sleeping: usize,
    panic: Option<Box<dyn Any + Send>>,
    is_over: bool,
}

impl Team {
    pub(super) fn new(members: usize) -> std::io::Result<Self> {
        let mut team = Self { post: Arc::default(), members: Vec::new(), caller: Mutex::new(()) };
        for number in 0..members {
            let post = team.post.clone();
            let thread = std::thread::Builder::new().name(format!("longspan-{number}"));
            team.members.push(thread.spawn(move || post.attend(number + 1))?);
        }
        Ok(team)
    }

    pub(super) fn len(&self) -> usize {
        self.members.len()
    }

    /// Has `work` called once by this thread, as number 0, and by each member that comes in time, and returns when all calls have
    /// returned. While the team is at work for another thread, this one is left alone with it.
    pub(super) fn run(&self, work: &(dyn Fn(usize) + Sync)) {
        let caller = match self.caller.try_lock() {
            Ok(caller) => caller,
            Err(TryLockError::Poisoned(caller)) => caller.into_inner(),
            Err(TryLockError::WouldBlock) => return work(0),
        };
        // SAFETY: only the lifetime changes. Members call a region only between their coming in, which is while it is posted, and their
        // going out; `open`, dropped at the end of this function and where `work` panics, takes it down and waits until all are out.
        let region = unsafe { std::mem::transmute::<&(dyn Fn(usize) + Sync), Task>(work) };
        let open = Open::new(&self.post, region);
        work(0);
        drop(open);
        let panic = lock(&self.post.notice).panic.take();
        drop(caller);
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }

    /// Keeps members awake until the watch is dropped; calls them at once if they have been needed while the last one was kept.
    pub(super) fn watch(&self) -> Watch {
        self.post.is_watched.store(true, Ordering::Relaxed);
        if self.post.is_used.swap(false, Ordering::Relaxed) {
            drop(lock(&self.post.notice));
            self.post.call.notify_all();
        }
        Watch(self.post.clone())
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        lock(&self.post.notice).is_over = true;
        self.post.call.notify_all();
        for member in self.members.drain(..) {
            // What it has panicked of was a region's, and has been handed on.
            let _ = member.join();
        }
    }
}

/// While it lives, members stay awake between regions.
pub(crate) struct Watch(Arc<Shared>);

impl Drop for Watch {
    fn drop(&mut self) {
        self.0.is_watched.store(false, Ordering::Relaxed);
    }
}

/// A region that members may come into until this is dropped.
struct Open<'a>(&'a Shared);

impl<'a> Open<'a> {
    fn new(post: &'a Shared, region: Task) -> Self {
        let mut notice = lock(&post.notice);
        notice.region = Some(region);
        notice.number += 1;
        post.last.store(notice.number, Ordering::Relaxed);
        post.is_used.store(true, Ordering::Relaxed);
        let is_anyone_asleep = notice.sleeping > 0;
        drop(notice);
        if is_anyone_asleep {
            post.call.notify_all();
        }
        Self(post)
    }
}

impl Drop for Open<'_> {
    fn drop(&mut self) {
        lock(&self.0.notice).region = None;
        wait_until(|| self.0.inside.load(Ordering::Acquire) == 0);
    }
}

impl Shared {
    /// What the member of this number does all its life.
    fn attend(&self, member: usize) {
        let mut seen = 0;
        while let Some(region) = self.next(&mut seen) {
            if let Err(panic) = catch_unwind(AssertUnwindSafe(|| region(member))) {
                lock(&self.notice).panic.get_or_insert(panic);
            }
            self.inside.fetch_sub(1, Ordering::Release);
        }
    }

    /// Comes into the next region after the one of this number; `None` when the team is no more.
    fn next(&self, seen: &mut u64) -> Option<Task> {
        loop {
            self.look_out(*seen);
            let mut notice = lock(&self.notice);
            if notice.is_over {
                return None;
            }
            if notice.number == *seen {
                notice.sleeping += 1;
                notice = self.call.wait(notice).unwrap_or_else(std::sync::PoisonError::into_inner);
                notice.sleeping -= 1;
                continue;
            }
            *seen = notice.number;
            if let Some(region) = notice.region {
                // Under the lock: whoever takes the region down after this finds it.
                self.inside.fetch_add(1, Ordering::Relaxed);
                return Some(region);
            }
        }
    }

    /// Looks for another region than the one of this number, within a step and for a while.
    fn look_out(&self, seen: u64) {
        let mut from = None;
        let mut looks = 0;
        while self.last.load(Ordering::Relaxed) == seen && self.is_watched.load(Ordering::Relaxed) {
            looks += 1;
            pause(looks);
            if looks % LOOKS == 0 && Moment::now().since(*from.get_or_insert_with(Moment::now)) > PATIENCE {
                return;
            }
        }
    }
}

/// Waits for what another thread that is at work will have done soon.
pub(super) fn wait_until(is_so: impl Fn() -> bool) {
    let mut looks = 0;
    while !is_so() {
        looks += 1;
        pause(looks);
    }
}

/// Waits a little for what is perhaps so in a moment, and says whether it is. To look whether another thread has begun a piece of its own takes
/// the place where that is noted out of its cache.
pub(super) fn is_soon(is_so: impl Fn() -> bool) -> bool {
    (0..LOOKS_FOR_MORE).any(|_| {
        let is_so = is_so();
        if !is_so {
            std::hint::spin_loop();
        }
        is_so
    })
}

/// Passes the time between two looks: more than a few, and others may have the processor.
fn pause(looks: u32) {
    if looks < LOOKS {
        std::hint::spin_loop();
    } else {
        std::thread::yield_now();
    }
}
