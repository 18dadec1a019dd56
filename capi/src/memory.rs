//! The library's memory: how much there is, and who gives it.
//!
//! Everything that the library and what it is built of allocate comes through here; a host's allocator is asked, or the system's.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ffi::c_void;
use std::mem;
use std::ptr;
use std::sync::atomic::{AtomicPtr, AtomicU64, AtomicUsize, Ordering};

use crate::boundary::call;
use crate::pointer::{self, host};
use crate::result::{Failure, LS_ERROR_NOT_APPLICABLE, LsResult, Outcome};
use crate::sized::{SizedOut, Versioned};

/// Gives memory; given in an LsAllocator. Called on any thread that uses the library or that it started.
/// @param size       number of bytes, > 0
/// @param alignment  a power of two
/// @param user       as given in the LsAllocator
/// @return memory of that size and alignment, or NULL, which ends the process
pub type LsAllocateCallback = Option<unsafe extern "C" fn(size: usize, alignment: usize, user: *mut c_void) -> *mut c_void>;

/// Takes memory back; given in an LsAllocator. Called on any thread.
/// @param memory     as the allocate callback gave it
/// @param size       as asked for then
/// @param alignment  as asked for then
/// @param user       as given in the LsAllocator
pub type LsReleaseCallback = Option<unsafe extern "C" fn(memory: *mut c_void, size: usize, alignment: usize, user: *mut c_void)>;

/// Who gives the library its memory. The layout of this struct never changes.
///
/// The callbacks must return normally (no exception, no longjmp) and must not call the library.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsAllocator {
    /// Gives memory; not NULL.
    pub allocate: LsAllocateCallback,
    /// Takes it back; not NULL.
    pub release: LsReleaseCallback,
    /// Handed back to the callbacks.
    pub user: *mut c_void,
}

/// Memory that the library holds. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct LsMemory {
    /// Bytes held now, by all worlds together.
    pub bytes: u64,
    /// Most bytes held at any time.
    pub peak_bytes: u64,
    /// Blocks held now.
    pub blocks: u64,
    /// Blocks asked for so far: a step that allocates nothing leaves it as it is.
    pub allocations: u64,
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsMemory {
    const SIZES: &'static [usize] = &[32];
}

struct Memory {
    bytes: AtomicU64,
    peak: AtomicU64,
    blocks: AtomicU64,
    allocations: AtomicU64,
    /// The host's functions as addresses; zero for those of the system.
    allocate: AtomicUsize,
    release: AtomicUsize,
    user: AtomicPtr<c_void>,
}

#[global_allocator]
static MEMORY: Memory = Memory {
    bytes: AtomicU64::new(0),
    peak: AtomicU64::new(0),
    blocks: AtomicU64::new(0),
    allocations: AtomicU64::new(0),
    allocate: AtomicUsize::new(0),
    release: AtomicUsize::new(0),
    user: AtomicPtr::new(ptr::null_mut()),
};

impl Memory {
    fn grow(&self, size: usize) {
        let bytes = self.bytes.fetch_add(size as u64, Ordering::Relaxed) + size as u64;
        if bytes > self.peak.load(Ordering::Relaxed) {
            self.peak.fetch_max(bytes, Ordering::Relaxed);
        }
        self.allocations.fetch_add(1, Ordering::Relaxed);
    }
}

// SAFETY: every block comes from the system or from the host, which promised as much for its functions, and goes back where it
// came from: functions change only while there are no blocks.
unsafe impl GlobalAlloc for Memory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let block = match self.allocate.load(Ordering::Acquire) {
            // SAFETY: as promised to this function.
            0 => unsafe { System.alloc(layout) },
            address => {
                // SAFETY: the address was stored from a function of this type.
                let allocate: unsafe extern "C" fn(usize, usize, *mut c_void) -> *mut c_void = unsafe { mem::transmute(address) };
                // SAFETY: the host promised a function of this type that accepts its own pointer.
                unsafe { allocate(layout.size(), layout.align(), self.user.load(Ordering::Acquire)) }.cast()
            }
        };
        if !block.is_null() {
            self.grow(layout.size());
            self.blocks.fetch_add(1, Ordering::Relaxed);
        }
        block
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        self.bytes.fetch_sub(layout.size() as u64, Ordering::Relaxed);
        self.blocks.fetch_sub(1, Ordering::Relaxed);
        match self.release.load(Ordering::Acquire) {
            // SAFETY: as promised to this function.
            0 => unsafe { System.dealloc(block, layout) },
            address => {
                // SAFETY: the address was stored from a function of this type.
                let release: unsafe extern "C" fn(*mut c_void, usize, usize, *mut c_void) = unsafe { mem::transmute(address) };
                // SAFETY: the host promised a function of this type that accepts its own pointer.
                unsafe { release(block.cast(), layout.size(), layout.align(), self.user.load(Ordering::Acquire)) };
            }
        }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if self.allocate.load(Ordering::Acquire) == 0 {
            // SAFETY: as promised to this function.
            let moved = unsafe { System.realloc(block, layout, size) };
            if !moved.is_null() {
                self.bytes.fetch_sub(layout.size() as u64, Ordering::Relaxed);
                self.grow(size);
            }
            return moved;
        }
        // SAFETY: the size is not zero and does not overflow, as promised to this function.
        let fresh = unsafe { Layout::from_size_align_unchecked(size, layout.align()) };
        // SAFETY: as above.
        let moved = unsafe { self.alloc(fresh) };
        if !moved.is_null() {
            // SAFETY: both blocks are at least that long, and do not overlap.
            unsafe { ptr::copy_nonoverlapping(block, moved, layout.size().min(size)) };
            // SAFETY: as promised to this function.
            unsafe { self.dealloc(block, layout) };
        }
        moved
    }
}

/// Sets who gives the library its memory: the first call that a host makes, before any other.
///
/// @param allocator  read during the call; NULL for the system's own
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT (a function in it is NULL), LS_ERROR_NOT_APPLICABLE (the library holds memory already:
///         ls_memory_get says how much)
/// Threads: one thread, while no other is inside the library. Callbacks: LS_ERROR_NOT_APPLICABLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_allocator_set(allocator: *const LsAllocator) -> LsResult {
    call("ls_allocator_set", || {
        let (mut allocate, mut release, mut user) = (0, 0, ptr::null_mut());
        if !allocator.is_null() {
            let given = host!(pointer::read, allocator);
            allocate = given.allocate.ok_or_else(|| pointer::null("allocator.allocate"))? as usize;
            release = given.release.ok_or_else(|| pointer::null("allocator.release"))? as usize;
            user = given.user;
        }
        if MEMORY.blocks.load(Ordering::Acquire) > 0 {
            return Err(Failure::Refused(
                LS_ERROR_NOT_APPLICABLE,
                "allocator",
                "comes too late: the library holds memory already",
            ));
        }
        MEMORY.user.store(user, Ordering::Release);
        MEMORY.allocate.store(allocate, Ordering::Release);
        MEMORY.release.store(release, Ordering::Release);
        Ok(())
    })
}

/// Memory that the library holds.
///
/// @param out   filled on LS_OK
/// @param size  sizeof *out as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_memory_get(out: *mut LsMemory, size: usize) -> LsResult {
    call("ls_memory_get", || -> Outcome<()> {
        let number = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        host!(SizedOut::new, out, size).write(&LsMemory {
            bytes: number(&MEMORY.bytes),
            peak_bytes: number(&MEMORY.peak),
            blocks: number(&MEMORY.blocks),
            allocations: number(&MEMORY.allocations),
        })
    })
}
