//! Divides the pieces of a region among threads: phase after phase, each piece once, with no lock.
//!
//! Every owner has a cache line of its own, where the next of its pieces is claimed; a thread goes through its own, and only one that has
//! waited for a while looks at the lines of others. What a thread has done of a phase it tells in one addition, and whoever tells the last of
//! it opens the next phase, so a phase costs each thread one addition and one look at what has changed.
//!
//! Nobody announces that it comes or goes. A claim carries the number of its region, so a thread that is late, with the number of one that
//! is over, claims nothing; what a region is made of is read only between a claim and the addition that counts it, and no region ends
//! before all of its pieces are counted.
//!
//! Where pieces wait for some others instead of for all of an earlier phase, there is one phase, and every owner's line says how far its
//! pieces are done. Who has to wait for a piece that nobody has begun does it.

use std::any::Any;
use std::cell::UnsafeCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU16, AtomicU32, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use super::wait::{is_soon, wait_until};

/// Phases of a region: as many as there is room for beside a claim in an owner's line.
pub(super) const MAX_PHASES: usize = 56;

/// Pieces of a region: their numbers have sixteen bits.
pub(super) const MAX_REGION: usize = 1 << 15;

/// Owners of a region.
pub(super) const MAX_OWNERS: usize = 64;

/// The phase of a region that is over.
const OVER: u64 = 0xff;

/// Looks, each some 0.5 µs, before a thread does pieces of others that wait for some others: one that it takes from its owner too early makes
/// both wait.
const LOOKS_IN_FLOW: u32 = 16;

/// Calls a function for the number of each earlier piece that the piece of a number waits for.
pub(super) type Needs<'a> = &'a (dyn Fn(usize, &mut dyn FnMut(usize)) + Sync);

/// What is done with the piece of a number.
type Task = &'static (dyn Fn(usize) + Sync);

/// What no other thread's data shares a cache line, or the pair of lines that are fetched together, with.
#[derive(Debug, Default)]
#[repr(align(128))]
pub(super) struct Line<T>(pub T);

/// Pieces of an owner, which stand in a row in the order of a region, phase after phase.
#[repr(align(128))]
struct Owner {
    /// Number of the region, and place of the next piece that nobody has claimed.
    next: AtomicU64,
    /// Place after the last one of each phase.
    ends: [AtomicU16; MAX_PHASES],
}

impl Owner {
    fn new() -> Self {
        Self { next: AtomicU64::new(0), ends: [const { AtomicU16::new(0) }; MAX_PHASES] }
    }

    /// Claims the next piece of a phase, and says its place.
    fn claim(&self, region: u32, phase: usize) -> Option<usize> {
        self.claim_before(region, || self.ends[phase].load(Ordering::Acquire))
    }

    /// Claims the next piece if its place is before one.
    fn claim_before(&self, region: u32, end: impl Fn() -> u16) -> Option<usize> {
        let mut next = self.next.load(Ordering::Acquire);
        loop {
            // The ends of a later region are seen only with its number, or by one whose claim fails for it.
            if next >> 32 != u64::from(region) || next as u32 >= u32::from(end()) {
                return None;
            }
            match self.next.compare_exchange_weak(next, next + 1, Ordering::AcqRel, Ordering::Acquire) {
                Ok(_) => return Some(next as u32 as usize),
                Err(now) => next = now,
            }
        }
    }
}

/// What the pieces of a region are, and in which order.
struct Plan {
    task: Option<Task>,
    /// Numbers of pieces: owner after owner, of each phase after phase.
    order: Vec<u16>,
    /// Pieces up to the end of each phase.
    until: Vec<usize>,
    /// Where pieces wait for some others: for which, and owner and place of each number.
    needs: Option<Needs<'static>>,
    places: Vec<(u8, u16)>,
}

/// The region that is open, or was last.
pub(super) struct Regions {
    /// Number of the last region, and how many threads it is for: changes once a region, so whoever a region is not for stays out of its way.
    opened: Line<AtomicU64>,
    /// The same number, and the phase that is open.
    stage: Line<AtomicU64>,
    /// Pieces that are done.
    done: Line<AtomicUsize>,
    owners: Box<[Owner]>,
    /// By owner, where pieces wait for some others: place of the first of its pieces that is not done.
    reached: Box<[Line<AtomicU32>]>,
    /// Written while no region is open, and read by whoever has claimed a piece and not counted it yet.
    plan: UnsafeCell<Plan>,
    has_panicked: AtomicBool,
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

// SAFETY: everything but the plan is atomic or locked. The plan is written by the caller of `run`, of whom there is one at a time, while no
// piece is left to claim and all that were are counted; it is read by who has claimed one, which happens after it was written and before
// that piece is counted, so before it is written again.
unsafe impl Sync for Regions {}
// SAFETY: as above; the task is only there while `run` is at work.
unsafe impl Send for Regions {}

impl Regions {
    /// Regions of so many threads.
    pub(super) fn new(threads: usize) -> Self {
        Self {
            opened: Line::default(),
            stage: Line(AtomicU64::new(OVER)),
            done: Line::default(),
            owners: (0..threads).map(|_| Owner::new()).collect(),
            reached: (0..threads).map(|_| Line::default()).collect(),
            plan: UnsafeCell::new(Plan { task: None, order: Vec::new(), until: Vec::new(), needs: None, places: Vec::new() }),
            has_panicked: AtomicBool::new(false),
            panic: Mutex::new(None),
        }
    }

    pub(super) fn threads(&self) -> usize {
        self.owners.len()
    }

    /// Opens a region for the first `width` threads: pieces by their phases and owners, in the order of their phases. With `needs` they are of
    /// one phase, and each waits for earlier ones, those of its owner among them.
    ///
    /// # Safety
    /// One thread at a time opens regions, and goes through each as thread 0, which ends it, before `task` and `needs` end and the next is opened.
    pub(super) unsafe fn open(
        &self,
        pieces: &[(u8, u8)],
        width: usize,
        counts: &mut Vec<u16>,
        task: &(dyn Fn(usize) + Sync),
        needs: Option<Needs<'_>>,
    ) {
        debug_assert!(pieces.len() <= MAX_REGION && width <= self.threads() && pieces.is_sorted_by_key(|piece| piece.0));
        let phases = pieces.last().map_or(0, |last| usize::from(last.0) + 1);
        let region = ((self.opened.0.load(Ordering::Relaxed) >> 8) as u32).wrapping_add(1);
        // SAFETY: no region is open, and all pieces of earlier ones are counted.
        let plan = unsafe { &mut *self.plan.get() };
        // SAFETY: only the lifetime changes. The task is called for pieces of this region alone, all of which are done when thread 0 has
        // gone through it, which the caller does while the task lives.
        plan.task = Some(unsafe { std::mem::transmute::<&(dyn Fn(usize) + Sync), Task>(task) });
        // SAFETY: as above.
        plan.needs = unsafe { std::mem::transmute::<Option<Needs<'_>>, Option<Needs<'static>>>(needs) };
        plan.until.clear();
        plan.until.resize(phases, 0);
        counts.clear();
        counts.resize(phases * width, 0);
        for &(phase, owner) in pieces {
            plan.until[usize::from(phase)] += 1;
            counts[usize::from(owner) * phases + usize::from(phase)] += 1;
        }
        let mut sum = 0;
        plan.until.iter_mut().for_each(|until| (sum, *until) = (sum + *until, sum + *until));
        let mut sum = 0;
        counts.iter_mut().for_each(|count| (sum, *count) = (sum + *count, sum));
        plan.order.clear();
        plan.order.resize(pieces.len(), 0);
        for (number, &(phase, owner)) in (0..).zip(pieces) {
            let place = &mut counts[usize::from(owner) * phases + usize::from(phase)];
            plan.order[usize::from(*place)] = number;
            *place += 1;
        }
        if needs.is_some() {
            plan.places.clear();
            plan.places.resize(pieces.len(), (0, 0));
            for (place, &number) in (0..).zip(&plan.order) {
                plan.places[usize::from(number)] = (pieces[usize::from(number)].1, place);
            }
        }
        self.done.0.store(0, Ordering::Relaxed);
        let mut first = 0;
        for ((owner, reached), ends) in self.owners.iter().zip(&self.reached).zip(counts.chunks(phases.max(1))) {
            reached.0.store(u32::from(first), Ordering::Relaxed);
            // First: whoever still looks at the last region and sees an end of this one finds its claim refused.
            owner.next.store(u64::from(region) << 32 | u64::from(first), Ordering::Release);
            owner.ends.iter().zip(ends).for_each(|(end, &own)| end.store(own, Ordering::Release));
            first = ends.last().copied().unwrap_or(first);
        }
        self.stage.0.store(u64::from(region) << 8, Ordering::Release);
        self.opened.0.store(u64::from(region) << 8 | width as u64, Ordering::Release);
    }

    /// The last region, of which nothing but that it is another than before is of interest to whoever it is not for.
    pub(super) fn opened(&self) -> u64 {
        self.opened.0.load(Ordering::Acquire)
    }

    /// Goes through an opened region as one of its threads, until it is over; does nothing where it is for fewer threads.
    pub(super) fn work(&self, opened: u64, thread: usize) {
        let (region, width) = ((opened >> 8) as u32, (opened & 0xff) as usize);
        if thread >= width {
            return;
        }
        loop {
            let stage = self.stage.0.load(Ordering::Acquire);
            if stage >> 8 != u64::from(region) || stage & 0xff == OVER {
                return;
            }
            let phase = (stage & 0xff) as usize;
            let is_over = || self.stage.0.load(Ordering::Acquire) != stage;
            let is_flow = self.drain(region, phase, thread);
            let looks = if is_flow { LOOKS_IN_FLOW } else { 1 };
            if !(0..looks).any(|_| is_soon(is_over)) {
                (1..width).for_each(|step| _ = self.drain(region, phase, (thread + step) % width));
                wait_until(is_over);
            }
        }
    }

    /// Does what is left of an owner's pieces of a phase, and says whether they wait for some others.
    fn drain(&self, region: u32, phase: usize, owner: usize) -> bool {
        let Some(mut place) = self.owners[owner].claim(region, phase) else { return false };
        // SAFETY: a piece is claimed, and none of what this thread claims here is counted before the last look at the plan.
        let plan = unsafe { &*self.plan.get() };
        let is_flow = plan.needs.is_some();
        let mut count = 0;
        loop {
            count += 1;
            self.perform(plan, region, owner, place);
            match self.owners[owner].claim(region, phase) {
                Some(next) => place = next,
                None => break,
            }
        }
        self.count(plan, region, phase, count);
        is_flow
    }

    /// Does a piece that this thread has claimed.
    fn perform(&self, plan: &Plan, region: u32, owner: usize, place: usize) {
        let number = usize::from(plan.order[place]);
        if let Some(needs) = plan.needs {
            self.reach(plan, region, owner, place);
            needs(number, &mut |earlier| {
                let (owner, place) = plan.places[earlier];
                self.reach(plan, region, usize::from(owner), usize::from(place) + 1);
            });
        }
        if let Some(task) = plan.task
            && let Err(panic) = catch_unwind(AssertUnwindSafe(|| task(number)))
        {
            self.panic.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(panic);
            self.has_panicked.store(true, Ordering::Relaxed);
        }
        if plan.needs.is_some() {
            self.reached[owner].0.store(place as u32 + 1, Ordering::Release);
        }
    }

    /// Waits until an owner's pieces are done that are before a place, or does what nobody has begun of them. Whoever waits here has claimed
    /// pieces and waits for one with a lower number than all of them, so no circle of threads waits.
    fn reach(&self, plan: &Plan, region: u32, owner: usize, place: usize) {
        let is_reached = || self.reached[owner].0.load(Ordering::Acquire) as usize >= place;
        while !is_soon(is_reached) {
            let Some(own) = self.owners[owner].claim_before(region, || place as u16) else { return wait_until(is_reached) };
            self.perform(plan, region, owner, own);
            // Not the last: the piece that waits is not counted.
            self.done.0.fetch_add(1, Ordering::AcqRel);
        }
    }

    /// Counts pieces that this thread has done; whoever counts the last of a phase opens the next.
    fn count(&self, plan: &Plan, region: u32, phase: usize, count: usize) {
        let (until, is_last) = (plan.until[phase], phase + 1 == plan.until.len());
        if self.done.0.fetch_add(count, Ordering::AcqRel) + count == until {
            let next = if is_last { OVER } else { phase as u64 + 1 };
            self.stage.0.store(u64::from(region) << 8 | next, Ordering::Release);
        }
    }

    /// What a piece of the last region has panicked of, if any has.
    pub(super) fn take_panic(&self) -> Option<Box<dyn Any + Send>> {
        // Noted before the piece was counted.
        let has_panicked = self.has_panicked.load(Ordering::Relaxed);
        has_panicked.then(|| {
            self.has_panicked.store(false, Ordering::Relaxed);
            self.panic.lock().unwrap_or_else(PoisonError::into_inner).take()
        })?
    }
}
