//! Waits for other threads that are at work.

/// Looks at what is waited for before the processor is offered to others between any two: some 3 µs. Where threads share a processor, the
/// one that is waited for is not at work meanwhile.
pub(super) const LOOKS: u32 = 128;

/// Looks before a thread that has done its own does what others have not begun: some 0.5 µs.
const LOOKS_FOR_MORE: u32 = 16;

/// Waits for what another thread that is at work will have done soon.
pub(super) fn wait_until(is_so: impl Fn() -> bool) {
    let mut looks = 0;
    while !is_so() {
        looks += 1;
        pause(looks);
    }
}

/// Waits a little for what is perhaps so in a moment, and says whether it is. To look whether another thread has begun a piece of its own takes
/// the line where that is noted out of its cache.
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
pub(super) fn pause(looks: u32) {
    if looks < LOOKS {
        std::hint::spin_loop();
    } else {
        std::thread::yield_now();
    }
}
