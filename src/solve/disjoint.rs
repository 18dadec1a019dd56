//! Arrays that several threads write at once, each at slots of its own.
//!
//! Rows of one colour share no moving body, and a body that is moved is in one block of bodies. Neither can be said by cutting an
//! array into slices, so here the promise is made in words, in one place ([`Shared::hand`]), and checked by whoever hands out the
//! work in builds with debug assertions. Articulations, blocks of contacts and pairs are given to threads in the same way
//! ([`DisjointSlices::part`]). What does not move (the world's slot and those of kinematic bodies, which any number of rows act on) is read by
//! all and written by none.

use std::marker::PhantomData;
use std::ops::Range;
use std::ptr::NonNull;

/// What kernels over lanes read and write: one record for each slot.
pub(crate) trait Slots<T> {
    fn get(&self, slot: u32) -> &T;
    fn get_mut(&mut self, slot: u32) -> &mut T;
}

impl<T> Slots<T> for [T] {
    #[inline(always)]
    fn get(&self, slot: u32) -> &T {
        &self[slot as usize]
    }

    #[inline(always)]
    fn get_mut(&mut self, slot: u32) -> &mut T {
        &mut self[slot as usize]
    }
}

/// An array by slot that several threads work on.
pub(crate) struct Shared<'a, T> {
    first: NonNull<T>,
    count: usize,
    moving: usize,
    /// What is written of a slot that does not move goes here, in each hand.
    spare: T,
    array: PhantomData<&'a mut [T]>,
}

// SAFETY: it holds the array exclusively, and reads and writes through it are bound by the promise of `hand`.
unsafe impl<T: Send + Sync> Sync for Shared<'_, T> {}

impl<'a, T: Copy> Shared<'a, T> {
    /// Of these slots, so many after the world's are those of bodies that move.
    pub(crate) fn new(array: &'a mut [T], moving: usize) -> Self {
        let (count, spare) = (array.len(), array[0]);
        assert!(moving < count, "the world's slot comes before those of bodies that move");
        Self { first: NonNull::from(array).cast(), count, moving, spare, array: PhantomData }
    }

    /// A hand for one thread.
    ///
    /// # Safety
    /// While it lives no other hand is used for the slot of a moving body that this one is used for.
    pub(crate) unsafe fn hand(&self) -> DisjointMut<'_, T> {
        DisjointMut { first: self.first, count: self.count, moving: self.moving, spare: self.spare, array: PhantomData }
    }
}

/// One of possibly several hands on an array.
pub(crate) struct DisjointMut<'a, T> {
    first: NonNull<T>,
    count: usize,
    moving: usize,
    spare: T,
    array: PhantomData<&'a mut [T]>,
}

impl<'a, T: Copy> DisjointMut<'a, T> {
    /// The only hand on an array; see [`Shared::new`].
    pub(crate) fn alone(array: &'a mut [T], moving: usize) -> Self {
        let Shared { first, count, moving, spare, .. } = Shared::new(array, moving);
        Self { first, count, moving, spare, array: PhantomData }
    }
}

impl<T> Slots<T> for DisjointMut<'_, T> {
    #[inline(always)]
    fn get(&self, slot: u32) -> &T {
        assert!((slot as usize) < self.count);
        // SAFETY: the slot is within the array, which the hand borrows. Nobody writes to it meanwhile: of a moving body by the promise
        // of `Shared::hand`, and of what does not move because no hand does.
        unsafe { self.first.add(slot as usize).as_ref() }
    }

    #[inline(always)]
    fn get_mut(&mut self, slot: u32) -> &mut T {
        let moves = (slot as usize).wrapping_sub(1) < self.moving;
        // SAFETY: the slots of moving bodies are within the array, as `Shared::new` has made sure; of those nobody else reads or writes any
        // meanwhile, by the promise of `Shared::hand`.
        unsafe { if moves { self.first.add(slot as usize) } else { NonNull::from(&mut self.spare) }.as_mut() }
    }
}

/// An array whose elements several threads change at once, each others, and of which they read what nobody changes.
pub(crate) struct DisjointSlices<'a, T> {
    first: NonNull<T>,
    count: usize,
    array: PhantomData<&'a mut [T]>,
}

// SAFETY: it holds the array exclusively, and reads and writes through it are bound by the promise of `part`.
unsafe impl<T: Send> Sync for DisjointSlices<'_, T> {}

impl<'a, T> DisjointSlices<'a, T> {
    pub(crate) fn new(array: &'a mut [T]) -> Self {
        Self { count: array.len(), first: NonNull::from(array).cast(), array: PhantomData }
    }

    /// Some of its elements, for one thread.
    ///
    /// # Safety
    /// While it lives no other part is used for an element that this one changes.
    pub(crate) unsafe fn part(&self) -> DisjointPart<'_, T> {
        DisjointPart { first: self.first, count: self.count, array: PhantomData }
    }
}

impl<T> DisjointPart<'_, T> {
    /// Elements that follow one another.
    pub(crate) fn range_mut(&mut self, range: Range<usize>) -> &mut [T] {
        assert!(range.start <= range.end && range.end <= self.count);
        // SAFETY: the elements are within the array, and nobody else uses any of them, by the promise of `DisjointSlices::part`.
        unsafe { NonNull::slice_from_raw_parts(self.first.add(range.start), range.len()).as_mut() }
    }
}

/// Some elements of an array.
pub(crate) struct DisjointPart<'a, T> {
    first: NonNull<T>,
    count: usize,
    array: PhantomData<&'a mut [T]>,
}

impl<T> Slots<T> for DisjointPart<'_, T> {
    #[inline(always)]
    fn get(&self, slot: u32) -> &T {
        assert!((slot as usize) < self.count);
        // SAFETY: the element is within the array, which the part borrows, and nobody else changes it, by the promise of `DisjointSlices::part`.
        unsafe { self.first.add(slot as usize).as_ref() }
    }

    #[inline(always)]
    fn get_mut(&mut self, slot: u32) -> &mut T {
        assert!((slot as usize) < self.count);
        // SAFETY: the element is within the array, and nobody else uses it, by the same promise.
        unsafe { self.first.add(slot as usize).as_mut() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hands_write_what_moves_and_nothing_else() {
        let mut numbers = [0, 1, 2, 3, 4];
        let shared = Shared::new(&mut numbers, 3);
        std::thread::scope(|scope| {
            for own in [[1, 3], [2, 2]] {
                let shared = &shared;
                scope.spawn(move || {
                    // SAFETY: each thread uses other moving slots.
                    let mut hand = unsafe { shared.hand() };
                    for slot in own.into_iter().chain([0, 4]) {
                        *hand.get_mut(slot) += 10;
                    }
                    assert_eq!((*hand.get(0), *hand.get(4)), (0, 4));
                });
            }
        });
        assert_eq!(numbers, [0, 11, 22, 13, 4]);
    }
}
