//! Errors as values: the rule that was broken, and the argument that broke it.
//!
//! A call that returns an [`Error`] has changed nothing.

use std::fmt;

/// The rule that was broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The handle is zero.
    NullHandle,
    /// The handle was never given out by any world, or is of another kind.
    InvalidHandle,
    /// What the handle named has been destroyed.
    StaleHandle,
    /// A destroy call on a handle whose object was destroyed before.
    AlreadyDestroyed,
    /// The handle belongs to another world.
    ForeignHandle,
    /// A number is NaN or infinite where a finite one is needed.
    NotFinite,
    /// A number is outside the range that the argument allows.
    OutOfRange,
    /// A rotation or direction is more than 1 % away from unit length.
    NotUnit,
    /// A shape without volume or extent: collinear points, zero extents.
    Degenerate,
    /// An index points past the end of what it indexes.
    IndexOutOfRange,
    /// The call does not apply to what it was given (for example a force on a static body).
    NotApplicable,
    /// Nothing of that kind exists in this version of the library.
    Unsupported,
    /// A fixed capacity (worlds alive, bodies in a world) is used up.
    CapacityExceeded,
    /// Bytes that are no snapshot, of another version of the library, cut short or corrupted.
    InvalidSnapshot,
}

/// A refused call: the rule broken, the argument that broke it, and what is wrong with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Error {
    /// The rule that was broken.
    pub kind: ErrorKind,
    /// Name of the argument (or field) at fault, as the caller wrote it.
    pub argument: &'static str,
    /// What is wrong with it, as a short sentence without a full stop.
    pub problem: &'static str,
    /// Number of the part of a compound whose argument that is.
    pub part: Option<u32>,
}

/// Result of every fallible call.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error of `kind` about `argument`.
    pub const fn new(kind: ErrorKind, argument: &'static str, problem: &'static str) -> Self {
        Self { kind, argument, problem, part: None }
    }

    /// The same error about the part of a compound with this number.
    pub(crate) fn in_part(self, number: usize) -> Self {
        Self { part: u32::try_from(number).ok(), ..self }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.part {
            Some(part) => write!(f, "parts[{part}].{}: {}", self.argument, self.problem),
            None => write!(f, "{}: {}", self.argument, self.problem),
        }
    }
}

impl std::error::Error for Error {}
