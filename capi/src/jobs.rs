//! The host's job system does the independent parts of a step.

use std::any::Any;
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

use ls_core::ParallelFor;

use crate::access::edit_hosted;
use crate::boundary::call;
use crate::float_environment::{FloatEnvironment, as_host};
use crate::handle::LsWorld;
use crate::result::LsResult;

/// Does the parts begin, begin + 1, ... end - 1 of a job; given to an LsParallelForCallback, which calls it on any threads.
/// @param job    as given to the callback
/// @param begin  first part
/// @param end    one past the last part
pub type LsJobFunction = Option<unsafe extern "C" fn(job: *mut c_void, begin: usize, end: usize)>;

/// Has the parts 0, 1, ... count - 1 of a job done, by calls of run for ranges that do not overlap and leave nothing out, on any
/// threads, and returns when all those calls have returned. A host without threads calls run(job, 0, count).
///
/// Called on the thread that steps, a few times a step, under its own floating-point settings; parts take from 10 microseconds to
/// milliseconds each. It must return normally (no exception, no longjmp). The world that steps cannot be used inside it.
/// @param count  number of parts
/// @param run    does parts; never NULL
/// @param job    to be handed to run
/// @param user   as given to ls_world_parallel_for_set
pub type LsParallelForCallback =
    Option<unsafe extern "C" fn(count: usize, run: LsJobFunction, job: *mut c_void, user: *mut c_void)>;

struct HostJobs {
    callback: unsafe extern "C" fn(usize, LsJobFunction, *mut c_void, *mut c_void),
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back, and the header says on which thread.
unsafe impl Send for HostJobs {}
// SAFETY: as above.
unsafe impl Sync for HostJobs {}

/// A job while the host's callback runs.
struct Job<'a> {
    part: &'a (dyn Fn(usize) + Sync),
    count: usize,
    /// What a part that failed said.
    failure: Mutex<Option<Box<dyn Any + Send>>>,
}

impl ParallelFor for HostJobs {
    fn run(&self, count: usize, part: &(dyn Fn(usize) + Sync)) {
        let job = Job { part, count, failure: Mutex::new(None) };
        let pointer = ptr::from_ref(&job).cast_mut().cast::<c_void>();
        // SAFETY: the host promised a function of this type that accepts its own pointer.
        as_host(|| unsafe { (self.callback)(count, Some(run_parts), pointer, self.user) });
        if let Some(failure) = job.failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
            resume_unwind(failure);
        }
    }
}

/// # Safety
/// `job` is that of a callback that has not returned yet.
unsafe extern "C" fn run_parts(job: *mut c_void, begin: usize, end: usize) {
    // SAFETY: as promised to this function; a job is only ever read but for its mutex.
    let Some(job) = (unsafe { job.cast::<Job>().as_ref() }) else { return };
    let environment = FloatEnvironment::enter();
    // Unwind safe: the panic goes on in the call that steps, which poisons the world.
    let done = catch_unwind(AssertUnwindSafe(|| (begin..end.min(job.count)).for_each(job.part)));
    if let Err(failure) = done {
        job.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(failure);
    }
    drop(environment);
}

/// Has the host's job system do the independent parts of a world's steps, in place of threads of its own. The bits of a step do not
/// depend on who does them.
///
/// @param world     the world; any value is safe
/// @param callback  called by ls_world_step; NULL for the world's own threads, as many as it was created with
/// @param user      handed back to the callback; must stay valid until another callback is set or the world is destroyed
/// @return LS_OK, a world error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_parallel_for_set(
    world: LsWorld,
    callback: LsParallelForCallback,
    user: *mut c_void,
) -> LsResult {
    call("ls_world_parallel_for_set", || {
        edit_hosted(world, |hosted| {
            let jobs = callback.map(|callback| Arc::new(HostJobs { callback, user }) as Arc<dyn ParallelFor>);
            hosted.world.set_parallel_for(jobs);
            Ok(())
        })
    })
}
