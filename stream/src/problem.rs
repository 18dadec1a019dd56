//! What can go wrong with a stream.

use std::fmt;

/// Result of a call that may fail.
pub type Result<T> = std::result::Result<T, Problem>;

/// Why a call failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Problem {
    /// An argument makes no sense: its name, and what is wrong with it.
    Argument(&'static str, &'static str),
    /// Bytes of another version: what was found, and what is understood.
    Incompatible(String),
    /// Bytes that are no message, or a damaged one.
    Corrupt(&'static str),
    /// Shared memory or a file refused.
    System(String),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Argument(name, problem) => write!(f, "{name}: {problem}"),
            Self::Incompatible(what) => write!(f, "incompatible: {what}"),
            Self::Corrupt(what) => write!(f, "corrupt: {what}"),
            Self::System(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for Problem {}

impl From<std::io::Error> for Problem {
    fn from(error: std::io::Error) -> Self {
        Self::System(error.to_string())
    }
}
