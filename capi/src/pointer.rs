//! Pointers from C: null is checked, validity is the host's duty.
//!
//! Exports come here through `host!`: they are `unsafe extern "C"`, and their header comments ask for what is needed here.

use std::ptr::NonNull;

use ls_core::glam::{DVec3, Vec3};

use crate::result::{Failure, LS_ERROR_BUFFER_TOO_SMALL, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE, Outcome};

/// Where a result goes. Unaligned pointers are written to like any other.
pub(crate) struct Out<T>(NonNull<T>);

impl<T> Out<T> {
    /// # Safety
    /// If not null, `pointer` is valid for writing a `T` during the call.
    pub(crate) unsafe fn new(pointer: *mut T, name: &'static str) -> Outcome<Self> {
        NonNull::new(pointer).map(Self).ok_or_else(|| null(name))
    }

    pub(crate) fn write(&self, value: T) -> Outcome<()> {
        // SAFETY: valid for writing, as promised to `new`.
        unsafe { self.0.as_ptr().write_unaligned(value) };
        Ok(())
    }
}

impl<T> Out<[T; 3]> {
    /// # Safety
    /// If not null, `pointer` is valid for writing three values during the call.
    pub(crate) unsafe fn three(pointer: *mut T, name: &'static str) -> Outcome<Self> {
        // SAFETY: as promised to this function.
        unsafe { Self::new(pointer.cast(), name) }
    }
}

/// Where an array of results goes.
pub(crate) struct OutArray<T> {
    elements: *mut T,
    len: usize,
}

impl<T> OutArray<T> {
    /// # Safety
    /// `elements` is null, or valid for writing `len` values during the call.
    pub(crate) unsafe fn new(elements: *mut T, len: usize, name: &'static str) -> Outcome<Self> {
        if elements.is_null() && len > 0 { Err(null(name)) } else { Ok(Self { elements, len }) }
    }

    /// Writes the first values, as many as there are and fit.
    pub(crate) fn write(&self, values: impl Iterator<Item = T>) {
        for (i, value) in values.take(self.len).enumerate() {
            // SAFETY: i < len, and there is room for that many, as promised to `new`.
            unsafe { self.elements.add(i).write_unaligned(value) };
        }
    }
}

/// A buffer of the host for as many results as fit, and where their number goes.
pub(crate) struct Buffer<T> {
    elements: OutArray<T>,
    count: Out<usize>,
}

impl<T> Buffer<T> {
    /// # Safety
    /// `elements` is null, or valid for writing `capacity` values during the call; `count` is null or valid for writing.
    pub(crate) unsafe fn new(elements: *mut T, capacity: usize, count: *mut usize, name: &'static str) -> Outcome<Self> {
        // SAFETY: as promised to this function.
        unsafe { Ok(Self { elements: OutArray::new(elements, capacity, name)?, count: Out::new(count, "count")? }) }
    }

    /// Whether so many values fit; if not, writes their number.
    pub(crate) fn room_for(&self, needed: usize) -> Outcome<()> {
        if needed > self.elements.len {
            self.count.write(needed)?;
            return Err(Failure::Refused(LS_ERROR_BUFFER_TOO_SMALL, "capacity", "is less than the number written to count"));
        }
        Ok(())
    }

    /// Writes all bytes and their number, or only their number if they do not fit.
    pub(crate) fn fill_bytes(&self, bytes: &[u8]) -> Outcome<()>
    where
        T: From<u8>,
    {
        self.fill(|| bytes.iter().map(|&byte| T::from(byte)))
    }

    /// Writes all values and their number, or only their number if they do not fit.
    pub(crate) fn fill<I: Iterator<Item = T>>(&self, values: impl Fn() -> I) -> Outcome<()> {
        let needed = values().count();
        self.count.write(needed)?;
        self.room_for(needed)?;
        self.elements.write(values());
        Ok(())
    }
}

/// # Safety
/// `pointer` is valid for reading `count` values during the call, or null.
pub(crate) unsafe fn slice<'a, T>(pointer: *const T, count: usize, name: &'static str) -> Outcome<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(null(name));
    }
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Failure::Refused(LS_ERROR_OUT_OF_RANGE, name, "the count is larger than memory"));
    }
    if !pointer.is_aligned() {
        return Err(Failure::Refused(LS_ERROR_OUT_OF_RANGE, name, "the pointer is not aligned"));
    }
    // SAFETY: not null, aligned, no longer than memory; readable as promised to this function.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// # Safety
/// If not null, `pointer` is valid for reading a `T` during the call.
pub(crate) unsafe fn read<T: Copy>(pointer: *const T, name: &'static str) -> Outcome<T> {
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: not null; readable as promised to this function.
    Ok(unsafe { pointer.read_unaligned() })
}

/// # Safety
/// If not null, `pointer` is valid for reading three floats during the call.
pub(crate) unsafe fn vector(pointer: *const f32, name: &'static str) -> Outcome<Vec3> {
    // SAFETY: as promised to this function.
    unsafe { read(pointer.cast::<[f32; 3]>(), name) }.map(Vec3::from_array)
}

/// # Safety
/// If not null, `pointer` is valid for reading three doubles during the call.
pub(crate) unsafe fn point(pointer: *const f64, name: &'static str) -> Outcome<DVec3> {
    // SAFETY: as promised to this function.
    unsafe { read(pointer.cast::<[f64; 3]>(), name) }.map(DVec3::from_array)
}

pub(crate) fn null(name: &'static str) -> Failure {
    Failure::Refused(LS_ERROR_NULL_ARGUMENT, name, "is NULL")
}

/// Takes a pointer of an export through one of the checked ways in or out, by its own name.
macro_rules! host {
    ($way:path, $pointer:ident $(, $size:ident)*) => {
        // SAFETY: the export is unsafe, and its header comment asks for a pointer that is NULL or valid in this way.
        unsafe { $way($pointer $(, $size)*, stringify!($pointer)) }?
    };
}
pub(crate) use host;
