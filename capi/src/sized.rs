//! Structs that grow: an old host runs on a new library, and the reverse.
//!
//! The host says how large its copy of the struct is. Fields are only ever appended, so the sizes that a struct has had are
//! its versions. A host's copy is read as the newest version that fits in it; what that version lacks keeps its default, and
//! what the host has beyond the library's own version is ignored.

use std::ptr;

use crate::pointer::null;
use crate::result::{Failure, LS_ERROR_STRUCT_SIZE, Outcome};

/// No version of any struct will be larger; a greater size is garbage.
const LARGEST: usize = 65536;

/// A struct that grows from version to version.
///
/// # Safety
/// `Self` is `repr(C)`, has no padding and takes any bytes (numbers and raw pointers only).
pub(crate) unsafe trait Versioned: Copy + Default {
    /// Size of each version in bytes, ascending; the last is that of `Self`.
    const SIZES: &'static [usize];
}

/// A [`Versioned`] struct that begins with its size, a `uint32_t`.
///
/// # Safety
/// The first field is `struct_size: u32`.
pub(crate) unsafe trait Definition: Versioned {}

/// Size of the newest version that fits in `size` bytes.
fn version_within<T: Versioned>(size: usize, argument: &'static str) -> Outcome<usize> {
    let fits = T::SIZES.iter().copied().rfind(|&version| version <= size);
    fits.filter(|_| size <= LARGEST).ok_or(Failure::Refused(
        LS_ERROR_STRUCT_SIZE,
        argument,
        "struct_size is not the size of the struct; fill it with its _init function",
    ))
}

/// The size that a definition of the host gives itself.
///
/// # Safety
/// `pointer` is null, or valid for reading as many bytes as its `struct_size` says.
pub(crate) unsafe fn declared_size<T: Definition>(pointer: *const T, argument: &'static str) -> Outcome<usize> {
    if pointer.is_null() {
        return Err(null(argument));
    }
    // SAFETY: a definition begins with its size.
    let size = unsafe { pointer.cast::<u32>().read_unaligned() } as usize;
    version_within::<T>(size, argument)?;
    Ok(size)
}

/// Reads a definition of the host.
///
/// # Safety
/// `pointer` is null, or valid for reading as many bytes as its `struct_size` says.
pub(crate) unsafe fn read<T: Definition>(pointer: *const T, argument: &'static str) -> Outcome<T> {
    // SAFETY: as promised to this function.
    let size = unsafe { declared_size(pointer, argument) }?;
    let mut value = T::default();
    // SAFETY: the version is no longer than what the host declares, nor than `T`, and `T` takes any bytes.
    unsafe { ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut value).cast(), version_within::<T>(size, argument)?) };
    Ok(value)
}

/// Where a struct that grows goes, and the size of the host's copy.
pub(crate) struct SizedOut<T> {
    pointer: *mut T,
    size: usize,
}

impl<T: Versioned> SizedOut<T> {
    /// # Safety
    /// `pointer` is null, or valid for writing `size` bytes during the call.
    pub(crate) unsafe fn new(pointer: *mut T, size: usize, name: &'static str) -> Outcome<Self> {
        if pointer.is_null() {
            return Err(null(name));
        }
        version_within::<T>(size, "size")?;
        Ok(Self { pointer, size })
    }

    /// Writes the version that the host knows; what the host has beyond it becomes zero.
    pub(crate) fn write(&self, value: &T) -> Outcome<()> {
        let known = version_within::<T>(self.size, "size")?;
        // SAFETY: `known` is at most the size of `T` and `self.size`, which the host can hold, as promised to `new`.
        unsafe {
            ptr::copy_nonoverlapping(ptr::from_ref(value).cast::<u8>(), self.pointer.cast(), known);
            self.pointer.cast::<u8>().add(known).write_bytes(0, self.size - known);
        }
        Ok(())
    }

    /// As [`write`](Self::write), and the definition then says how large the host's copy is.
    pub(crate) fn write_definition(&self, value: &T) -> Outcome<()>
    where
        T: Definition,
    {
        self.write(value)?;
        // SAFETY: a definition begins with its size, and is at least that long.
        unsafe { self.pointer.cast::<u32>().write_unaligned(self.size as u32) };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Version 1 ended after `a`, version 2 after `c`.
    #[derive(Debug, Clone, Copy, PartialEq)]
    #[repr(C)]
    struct Grown {
        struct_size: u32,
        a: u32,
        b: u32,
        c: u32,
        d: u32,
    }

    impl Default for Grown {
        fn default() -> Self {
            Self { struct_size: 20, a: 1, b: 2, c: 3, d: 4 }
        }
    }

    // SAFETY: five u32, no padding.
    unsafe impl Versioned for Grown {
        const SIZES: &'static [usize] = &[8, 16, 20];
    }

    // SAFETY: begins with its size.
    unsafe impl Definition for Grown {}

    fn read_words(words: &[u32]) -> Outcome<Grown> {
        // SAFETY: the slice is at least as long as the size it declares, or that size is refused.
        unsafe { read(words.as_ptr().cast(), "def") }
    }

    #[test]
    fn an_older_definition_keeps_the_defaults_of_what_it_lacks() {
        assert_eq!(read_words(&[8, 10]).unwrap(), Grown { struct_size: 8, a: 10, ..Grown::default() });
        assert_eq!(read_words(&[16, 10, 11, 12]).unwrap(), Grown { struct_size: 16, a: 10, b: 11, c: 12, d: 4 });
    }

    #[test]
    fn a_size_between_two_versions_is_read_as_the_older() {
        assert_eq!(read_words(&[12, 10, 11]).unwrap(), Grown { struct_size: 12, a: 10, ..Grown::default() });
    }

    #[test]
    fn a_newer_definition_loses_only_its_tail() {
        assert_eq!(read_words(&[24, 10, 11, 12, 13, 14]).unwrap(), Grown { struct_size: 24, a: 10, b: 11, c: 12, d: 13 });
    }

    #[test]
    fn sizes_that_no_version_had_are_refused() {
        for size in [0, 4, 7, LARGEST as u32 + 1, u32::MAX] {
            let failure = read_words(&[size, 0, 0, 0, 0]).expect_err("must be refused");
            assert_eq!(failure.code(), LS_ERROR_STRUCT_SIZE, "size {size}");
        }
    }

    #[test]
    fn a_result_fills_what_the_host_knows_and_clears_what_the_library_does_not() {
        let mut words = [u32::MAX; 7];
        // SAFETY: 28 bytes are there.
        unsafe { SizedOut::new(words.as_mut_ptr().cast::<Grown>(), 24, "out") }
            .unwrap()
            .write_definition(&Grown::default())
            .unwrap();
        assert_eq!(words, [24, 1, 2, 3, 4, 0, u32::MAX]);
        let mut words = [u32::MAX; 4];
        // SAFETY: 16 bytes are there.
        unsafe { SizedOut::new(words.as_mut_ptr().cast::<Grown>(), 8, "out") }
            .unwrap()
            .write_definition(&Grown::default())
            .unwrap();
        assert_eq!(words, [8, 1, u32::MAX, u32::MAX]);
    }
}
