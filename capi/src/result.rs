//! Result codes, and how the failures of the solver and of the boundary become one.

use std::borrow::Cow;
use std::ffi::c_char;

use ls_core::ErrorKind;

/// What a call returns: LS_OK, or one of the LS_ERROR_ constants. Unless a function says otherwise, a call that fails has
/// changed nothing and has written nothing through its pointers. New codes may be added: treat an unknown one as a failure.
pub type LsResult = i32;

/// The call did what it says.
pub const LS_OK: LsResult = 0;
/// A pointer that must not be NULL is NULL (also: NULL with a count greater than zero).
pub const LS_ERROR_NULL_ARGUMENT: LsResult = 1;
/// A handle is zero.
pub const LS_ERROR_NULL_HANDLE: LsResult = 2;
/// A handle was never given out, or names an object of another kind.
pub const LS_ERROR_INVALID_HANDLE: LsResult = 3;
/// What a handle named has been destroyed.
pub const LS_ERROR_STALE_HANDLE: LsResult = 4;
/// A destroy call on an object that was destroyed before.
pub const LS_ERROR_ALREADY_DESTROYED: LsResult = 5;
/// A handle belongs to another world, alive or dead.
pub const LS_ERROR_FOREIGN_HANDLE: LsResult = 6;
/// A number is NaN or infinite where a finite one is needed.
pub const LS_ERROR_NOT_FINITE: LsResult = 7;
/// A number or count is outside the range that the argument allows.
pub const LS_ERROR_OUT_OF_RANGE: LsResult = 8;
/// A rotation or direction is more than 1 % away from unit length.
pub const LS_ERROR_NOT_UNIT: LsResult = 9;
/// A shape without volume or extent: collinear points, zero extents.
pub const LS_ERROR_DEGENERATE: LsResult = 10;
/// An index points past the end of what it indexes.
pub const LS_ERROR_INDEX_OUT_OF_RANGE: LsResult = 11;
/// The call does not apply to what it was given, for example a force on a static body.
pub const LS_ERROR_NOT_APPLICABLE: LsResult = 12;
/// This build of the library has nothing of that kind.
pub const LS_ERROR_UNSUPPORTED: LsResult = 13;
/// A fixed capacity is used up: 1023 worlds alive, or 2^28 objects of a kind in a world.
pub const LS_ERROR_CAPACITY_EXCEEDED: LsResult = 14;
/// An enumeration or bit set has a value that this version does not know.
pub const LS_ERROR_INVALID_ENUM: LsResult = 15;
/// A struct_size (or size argument) is zero, smaller than the first version of the struct, or greater than 65536.
pub const LS_ERROR_STRUCT_SIZE: LsResult = 16;
/// A buffer has room for fewer elements than there are; the number needed has been written to the count.
pub const LS_ERROR_BUFFER_TOO_SMALL: LsResult = 17;
/// Another thread is using the world in a way that excludes this call; nothing was waited for.
pub const LS_ERROR_WORLD_BUSY: LsResult = 18;
/// The call edits a world from inside a callback.
pub const LS_ERROR_WORLD_LOCKED: LsResult = 19;
/// An earlier call on this world ended with LS_ERROR_PANIC; the world can only be destroyed.
pub const LS_ERROR_WORLD_POISONED: LsResult = 20;
/// The library failed inside this call, which is a bug in it; the world that was in use is poisoned.
pub const LS_ERROR_PANIC: LsResult = 21;
/// A failure that has no code of its own.
pub const LS_ERROR_OTHER: LsResult = 22;
/// Bytes that are no snapshot, of another version of the library, cut short or corrupted.
pub const LS_ERROR_INVALID_SNAPSHOT: LsResult = 23;

/// A stream or a recording of another version.
pub const LS_ERROR_STREAM_INCOMPATIBLE: LsResult = 24;
/// Bytes of a stream or a recording that make no sense.
pub const LS_ERROR_STREAM_CORRUPT: LsResult = 25;
/// The system refuses shared memory or a file; the message says which, and why.
pub const LS_ERROR_STREAM_SYSTEM: LsResult = 26;

/// A call that did not succeed.
#[derive(Debug)]
pub enum Failure {
    /// Refused: the code, the argument at fault, and what is wrong with it.
    Refused(LsResult, &'static str, &'static str),
    /// Refused, for a reason that no list of reasons has: the code, and the whole message.
    Described(LsResult, String),
    /// Caught on its way out: what the panic said.
    Panicked(String),
}

pub(crate) type Outcome<T> = Result<T, Failure>;

impl Failure {
    /// The same of the part of a compound with this number.
    pub(crate) fn in_part(self, number: usize) -> Self {
        self.in_element("parts", number)
    }

    /// The same of an element of a list.
    pub(crate) fn in_element(self, list: &str, number: usize) -> Self {
        match self {
            Self::Refused(code, argument, problem) => Self::Described(code, format!("{list}[{number}].{argument}: {problem}")),
            Self::Described(code, what) => Self::Described(code, format!("{list}[{number}].{what}")),
            other @ Self::Panicked(_) => other,
        }
    }

    pub(crate) fn code(&self) -> LsResult {
        match *self {
            Self::Refused(code, ..) | Self::Described(code, _) => code,
            Self::Panicked(_) => LS_ERROR_PANIC,
        }
    }
}

impl From<ls_core::Error> for Failure {
    fn from(error: ls_core::Error) -> Self {
        let code = code_of(error.kind);
        let own = match name_in_c(error.argument) {
            Cow::Borrowed(argument) => Self::Refused(code, argument, error.problem),
            Cow::Owned(argument) => Self::Described(code, format!("{argument}: {}", error.problem)),
        };
        match error.part {
            Some(part) => own.in_part(part as usize),
            None => own,
        }
    }
}

/// What the header calls an argument of the core.
fn name_in_c(argument: &'static str) -> Cow<'static, str> {
    let own = match argument {
        "local_pose.position" => "local_position",
        "local_pose.rotation" => "local_rotation",
        "vertices" => "points",
        "geometry" => "shape",
        "twist_limits" => "limits",
        "motor.velocity" => "motor_drive.target_velocity",
        "motor.max_speed" => "motor_drive.max_speed",
        "motor.max_torque" => "spherical_motor.max_torque",
        "strength.damage.from" => "strength.damage_from",
        "strength.damage.time" => "strength.damage_time",
        "strength.damage.half_life" => "strength.damage_half_life",
        _ => return of_axis(argument).map_or(Cow::Borrowed(argument), Cow::Owned),
    };
    Cow::Borrowed(own)
}

/// The same of an axis of a generic joint.
fn of_axis(argument: &str) -> Option<String> {
    let (list, first) = if argument.starts_with("linear[") { ("linear_axes", 0) } else { ("angular_axes", 3) };
    let (axis, field) = argument.strip_prefix("linear[").or(argument.strip_prefix("angular["))?.split_once("].")?;
    let number: usize = axis.parse().ok()?;
    Some(match field {
        "motor.velocity" => format!("axis_drives[{}].target_velocity", first + number),
        "motor.max_speed" => format!("axis_drives[{}].max_speed", first + number),
        "motor.compliance" | "motor.damping" => format!("{list}[{axis}].{}", field.replacen("motor", "motor.softness", 1)),
        _ => format!("{list}[{axis}].{field}"),
    })
}

fn code_of(kind: ErrorKind) -> LsResult {
    match kind {
        ErrorKind::NullHandle => LS_ERROR_NULL_HANDLE,
        ErrorKind::InvalidHandle => LS_ERROR_INVALID_HANDLE,
        ErrorKind::StaleHandle => LS_ERROR_STALE_HANDLE,
        ErrorKind::AlreadyDestroyed => LS_ERROR_ALREADY_DESTROYED,
        ErrorKind::ForeignHandle => LS_ERROR_FOREIGN_HANDLE,
        ErrorKind::NotFinite => LS_ERROR_NOT_FINITE,
        ErrorKind::OutOfRange => LS_ERROR_OUT_OF_RANGE,
        ErrorKind::NotUnit => LS_ERROR_NOT_UNIT,
        ErrorKind::Degenerate => LS_ERROR_DEGENERATE,
        ErrorKind::IndexOutOfRange => LS_ERROR_INDEX_OUT_OF_RANGE,
        ErrorKind::NotApplicable => LS_ERROR_NOT_APPLICABLE,
        ErrorKind::Unsupported => LS_ERROR_UNSUPPORTED,
        ErrorKind::CapacityExceeded => LS_ERROR_CAPACITY_EXCEEDED,
        ErrorKind::InvalidSnapshot => LS_ERROR_INVALID_SNAPSHOT,
        _ => LS_ERROR_OTHER,
    }
}

/// Name of a result code, such as "LS_ERROR_STALE_HANDLE"; for logs and assertions.
///
/// @param result  any value
/// @return a string that lives as long as the library, never NULL; "unknown result" for a value without a name
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub extern "C" fn ls_result_name_get(result: LsResult) -> *const c_char {
    let name = match result {
        LS_OK => c"LS_OK",
        LS_ERROR_NULL_ARGUMENT => c"LS_ERROR_NULL_ARGUMENT",
        LS_ERROR_NULL_HANDLE => c"LS_ERROR_NULL_HANDLE",
        LS_ERROR_INVALID_HANDLE => c"LS_ERROR_INVALID_HANDLE",
        LS_ERROR_STALE_HANDLE => c"LS_ERROR_STALE_HANDLE",
        LS_ERROR_ALREADY_DESTROYED => c"LS_ERROR_ALREADY_DESTROYED",
        LS_ERROR_FOREIGN_HANDLE => c"LS_ERROR_FOREIGN_HANDLE",
        LS_ERROR_NOT_FINITE => c"LS_ERROR_NOT_FINITE",
        LS_ERROR_OUT_OF_RANGE => c"LS_ERROR_OUT_OF_RANGE",
        LS_ERROR_NOT_UNIT => c"LS_ERROR_NOT_UNIT",
        LS_ERROR_DEGENERATE => c"LS_ERROR_DEGENERATE",
        LS_ERROR_INDEX_OUT_OF_RANGE => c"LS_ERROR_INDEX_OUT_OF_RANGE",
        LS_ERROR_NOT_APPLICABLE => c"LS_ERROR_NOT_APPLICABLE",
        LS_ERROR_UNSUPPORTED => c"LS_ERROR_UNSUPPORTED",
        LS_ERROR_CAPACITY_EXCEEDED => c"LS_ERROR_CAPACITY_EXCEEDED",
        LS_ERROR_INVALID_ENUM => c"LS_ERROR_INVALID_ENUM",
        LS_ERROR_STRUCT_SIZE => c"LS_ERROR_STRUCT_SIZE",
        LS_ERROR_BUFFER_TOO_SMALL => c"LS_ERROR_BUFFER_TOO_SMALL",
        LS_ERROR_WORLD_BUSY => c"LS_ERROR_WORLD_BUSY",
        LS_ERROR_WORLD_LOCKED => c"LS_ERROR_WORLD_LOCKED",
        LS_ERROR_WORLD_POISONED => c"LS_ERROR_WORLD_POISONED",
        LS_ERROR_PANIC => c"LS_ERROR_PANIC",
        LS_ERROR_OTHER => c"LS_ERROR_OTHER",
        LS_ERROR_INVALID_SNAPSHOT => c"LS_ERROR_INVALID_SNAPSHOT",
        LS_ERROR_STREAM_INCOMPATIBLE => c"LS_ERROR_STREAM_INCOMPATIBLE",
        LS_ERROR_STREAM_CORRUPT => c"LS_ERROR_STREAM_CORRUPT",
        LS_ERROR_STREAM_SYSTEM => c"LS_ERROR_STREAM_SYSTEM",
        _ => c"unknown result",
    };
    name.as_ptr()
}
