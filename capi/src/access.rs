//! Who may use a world now.
//!
//!     read    any number of threads at a time; also inside the world's callbacks
//!     edit    one thread, nobody reading; refused inside callbacks
//!     step    an edit; afterwards the lock is handed down to reading without a gap, and the callbacks run
//!
//! Nothing waits: whoever comes second gets `LS_ERROR_WORLD_BUSY`, or `LS_ERROR_WORLD_LOCKED` if it is the world's own callback
//! that asks. A panic on the way poisons the world.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

use ls_core::{RecordedWorld, World};

use crate::callback::{self, CallbackThread};
use crate::callbacks::LsCallbacks;
use crate::fracture::FractureHandlers;
use crate::handle::LsWorld;
use crate::log;
use crate::published::Published;
use crate::registry;
use crate::result::{Failure, LS_ERROR_WORLD_BUSY, LS_ERROR_WORLD_LOCKED, LS_ERROR_WORLD_POISONED, Outcome};
use crate::world_events::OverloadHandler;

/// A world and what belongs to it on this side of the boundary.
pub(crate) struct Hosted {
    pub world: RecordedWorld,
    /// Arrays of the last step in C's layout, filled when asked for.
    pub published: Published,
    pub overload_handler: Option<OverloadHandler>,
    pub fracture_handlers: FractureHandlers,
    pub callbacks: LsCallbacks,
    /// Who publishes its steps to other processes.
    #[cfg(streams)]
    pub streams: crate::stream_host::Streams,
}

/// A place for one world; empty once the world is destroyed.
pub(crate) struct WorldCell {
    hosted: RwLock<Option<Hosted>>,
    callbacks: CallbackThread,
    poisoned: AtomicBool,
}

impl WorldCell {
    pub(crate) fn new(world: World) -> Self {
        let hosted = Hosted {
            world: RecordedWorld::new(world),
            published: Published::default(),
            overload_handler: None,
            fracture_handlers: FractureHandlers::default(),
            callbacks: LsCallbacks::default(),
            #[cfg(streams)]
            streams: Default::default(),
        };
        Self { hosted: RwLock::new(Some(hosted)), callbacks: CallbackThread::default(), poisoned: AtomicBool::new(false) }
    }

    fn try_read(&self) -> Outcome<RwLockReadGuard<'_, Option<Hosted>>> {
        self.healthy()?;
        match self.hosted.try_read() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::Poisoned(_)) => Err(poisoned()),
            Err(TryLockError::WouldBlock) => Err(busy("another thread is editing or stepping the world")),
        }
    }

    fn try_write(&self) -> Outcome<RwLockWriteGuard<'_, Option<Hosted>>> {
        self.healthy()?;
        self.try_write_even_poisoned()
    }

    fn try_write_even_poisoned(&self) -> Outcome<RwLockWriteGuard<'_, Option<Hosted>>> {
        if log::inside_callback() || callback::inside_any() {
            return Err(locked());
        }
        match self.hosted.try_write() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::Poisoned(guard)) => Ok(guard.into_inner()),
            Err(TryLockError::WouldBlock) if self.callbacks.is_this() => Err(locked()),
            Err(TryLockError::WouldBlock) => Err(busy("another thread is using the world")),
        }
    }

    fn healthy(&self) -> Outcome<()> {
        if self.poisoned.load(Ordering::Acquire) { Err(poisoned()) } else { Ok(()) }
    }

    /// Runs `work`; if it panics, the world is poisoned.
    fn or_poison<R>(&self, work: impl FnOnce() -> R) -> R {
        struct Poison<'a>(&'a AtomicBool);
        impl Drop for Poison<'_> {
            fn drop(&mut self) {
                self.0.store(true, Ordering::Release);
            }
        }
        let poison = Poison(&self.poisoned);
        let result = work();
        std::mem::forget(poison);
        result
    }
}

/// Work that leaves a world as it is.
pub(crate) fn read<R>(world: LsWorld, work: impl FnOnce(&World) -> Outcome<R>) -> Outcome<R> {
    read_hosted(world, |hosted| work(&hosted.world))
}

/// As [`read`], for what belongs to this side of the boundary.
pub(crate) fn read_hosted<R>(world: LsWorld, work: impl FnOnce(&Hosted) -> Outcome<R>) -> Outcome<R> {
    let cell = registry::find(world)?;
    let guard = cell.try_read()?;
    let hosted = guard.as_ref().ok_or_else(registry::stale)?;
    cell.or_poison(|| work(hosted))
}

/// Work that changes a world.
pub(crate) fn edit<R>(world: LsWorld, work: impl FnOnce(&mut RecordedWorld) -> ls_core::Result<R>) -> Outcome<R> {
    edit_hosted(world, |hosted| Ok(work(&mut hosted.world)?))
}

/// As [`edit`], for what belongs to this side of the boundary.
pub(crate) fn edit_hosted<R>(world: LsWorld, work: impl FnOnce(&mut Hosted) -> Outcome<R>) -> Outcome<R> {
    let cell = registry::find(world)?;
    let mut guard = cell.try_write()?;
    let hosted = guard.as_mut().ok_or_else(registry::stale)?;
    cell.or_poison(|| work(hosted))
}

/// Work that changes a world, followed by its callbacks.
pub(crate) fn edit_then_call_back(
    world: LsWorld,
    work: impl FnOnce(&mut Hosted) -> Outcome<()>,
    callbacks: impl FnOnce(&Hosted),
) -> Outcome<()> {
    let cell = registry::find(world)?;
    let mut guard = cell.try_write()?;
    let hosted = guard.as_mut().ok_or_else(registry::stale)?;
    cell.or_poison(|| work(hosted))?;
    let inside = cell.callbacks.enter();
    let guard = RwLockWriteGuard::downgrade(guard);
    let hosted = guard.as_ref().ok_or_else(registry::stale)?;
    cell.or_poison(|| callbacks(hosted));
    drop(inside);
    Ok(())
}

/// Ends a world, poisoned or not.
pub(crate) fn destroy(world: LsWorld) -> Outcome<()> {
    let cell = registry::find_to_destroy(world)?;
    let hosted = cell.try_write_even_poisoned()?.take().ok_or_else(registry::already_destroyed)?;
    registry::remove(world)?;
    drop(hosted);
    Ok(())
}

fn busy(problem: &'static str) -> Failure {
    Failure::Refused(LS_ERROR_WORLD_BUSY, "world", problem)
}

fn locked() -> Failure {
    Failure::Refused(LS_ERROR_WORLD_LOCKED, "world", "cannot be edited from inside a callback")
}

fn poisoned() -> Failure {
    Failure::Refused(LS_ERROR_WORLD_POISONED, "world", "an earlier call failed inside the library; destroy the world")
}
