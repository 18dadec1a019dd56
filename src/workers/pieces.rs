//! Keeps pieces of work until threads take them, in memory that stays from region to region whatever the pieces are.

use std::marker::PhantomData;
use std::mem::MaybeUninit;

use super::region::Line;

/// Memory for pieces.
#[derive(Default)]
pub(super) struct Store(Vec<MaybeUninit<Line<[u8; 128]>>>);

/// Pieces of one kind, which are written one after another and then taken, each once. What nobody takes is not dropped.
pub(super) struct Pieces<'a, T> {
    store: &'a mut Store,
    count: usize,
    kind: PhantomData<T>,
}

impl Store {
    /// Room for pieces of a kind; what was there is forgotten.
    pub(super) fn begin<T>(&mut self) -> Pieces<'_, T> {
        const { assert!(align_of::<T>() <= align_of::<Line<[u8; 128]>>()) };
        Pieces { store: self, count: 0, kind: PhantomData }
    }
}

impl<T> Pieces<'_, T> {
    pub(super) fn push(&mut self, piece: T) {
        let lines = ((self.count + 1) * size_of::<T>()).div_ceil(size_of::<Line<[u8; 128]>>());
        if lines > self.store.0.len() {
            self.store.0.resize_with((2 * lines).max(8), MaybeUninit::uninit);
        }
        // SAFETY: the memory is aligned for any piece, and has been made to reach beyond this one.
        unsafe { self.store.0.as_mut_ptr().cast::<T>().add(self.count).write(piece) };
        self.count += 1;
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The pieces, to be taken from any thread.
    pub(super) fn written(&mut self) -> Written<'_, T> {
        Written { first: self.store.0.as_mut_ptr().cast(), count: self.count, kind: PhantomData }
    }

    /// Forgets all pieces.
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }
}

/// Pieces that are there.
pub(super) struct Written<'a, T> {
    first: *mut T,
    count: usize,
    kind: PhantomData<&'a mut T>,
}

// SAFETY: it gives pieces away, each once, which may be sent.
unsafe impl<T: Send> Sync for Written<'_, T> {}

impl<T> Written<'_, T> {
    /// Takes a piece out.
    ///
    /// # Safety
    /// Each piece is taken at most once.
    pub(super) unsafe fn take(&self, number: usize) -> T {
        assert!(number < self.count, "there is no such piece");
        // SAFETY: it has been written, and is taken once.
        unsafe { self.first.add(number).read() }
    }
}
