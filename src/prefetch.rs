//! Memory asked for before it is used: of a large world each record that a walk comes to is far away, and a processor waits for one
//! at a time where there is much to do about each.

/// How many records ahead of its use memory is asked for; what says where that memory is, twice as many.
pub(crate) const AHEAD: usize = 6;

/// Asks for the memory of a value, all of it; where a processor cannot be asked nothing happens.
#[inline(always)]
pub(crate) fn prefetch<T: ?Sized>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let (first, size) = (std::ptr::from_ref(value).cast::<i8>(), size_of_val(value));
        // SAFETY: nothing is read: it is a hint, whatever the address.
        let ask = |offset: usize| unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(offset)) };
        (0..size).step_by(LINE).for_each(ask);
        if align_of_val(value) < LINE {
            // What does not begin with a line may end in one more.
            ask(size.saturating_sub(1));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}
