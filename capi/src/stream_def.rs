//! What a stream and a reader of one start with, and what they say of themselves.

#![cfg_attr(not(streams), allow(dead_code, reason = "hosts read these; the library does with the feature alone"))]

use std::ffi::c_char;
use std::ptr;

use longspan_stream_schema::LsStreamHeader;

use crate::sized::{Definition, Versioned};

/// Names a stream. Passed by value; any value is safe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LsStream {
    /// Opaque bits, zero for none; they may be stored, compared, and handed back later.
    pub id: u64,
}

/// Names a reader of a stream. Passed by value; any value is safe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LsStreamReader {
    /// Opaque bits, zero for none; they may be stored, compared, and handed back later.
    pub id: u64,
}

/// Everything a stream starts with. Fill it with ls_stream_def_init first.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsStreamDef {
    /// Size of this struct in the host, set by ls_stream_def_init.
    pub struct_size: u32,
    /// A frame every so many steps, at least 1; default 1.
    pub every: u32,
    /// What readers look for: 1 to 63 letters, digits, '_', '-' and '.'; NULL, the default, for "world".
    pub name: *const c_char,
    /// Room in which publishers and readers find each other, named alike; NULL, the default, for that of all who ask for none.
    /// Only processes of the same user meet, whatever the room.
    pub domain: *const c_char,
    /// LS_STREAM_LAYER_ bits: what frames hold besides motion; default 0.
    pub layers: u32,
    /// Most readers at a time, 1 to 64; default 8. Each costs memory for four frames.
    pub readers: u32,
    /// Bodies to have room for from the start; default 0, for those that are there. More are found room for when they come.
    pub body_capacity: u32,
    /// Not 0: each frame carries the hash of the world's state; default 1.
    pub state_hash: u32,
}

/// What a stream has done so far. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsStreamStats {
    /// Frames published.
    pub frames: u64,
    /// Messages published on the cold channel.
    pub records: u64,
    /// Messages that could not be placed; a reader that is late loses frames without being counted here.
    pub dropped: u64,
    /// Bytes published.
    pub bytes: u64,
    /// What the last publication took (s).
    pub seconds: f64,
}

/// Everything a reader starts with. Fill it with ls_stream_reader_def_init first.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsStreamReaderDef {
    /// Size of this struct in the host, set by ls_stream_reader_def_init.
    pub struct_size: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// Name of the stream; NULL, the default, for any. It need not be there yet.
    pub name: *const c_char,
    /// Room of the publisher; see LsStreamDef.
    pub domain: *const c_char,
    /// File of a recording to read in place of a stream; NULL, the default, for none.
    pub recording: *const c_char,
}

/// Reader status: there is a newer frame.
pub const LS_STREAM_FRAME: i32 = 0;
/// Reader status: nothing new.
pub const LS_STREAM_NOTHING: i32 = 1;
/// Reader status: no publisher is there. The reader goes on looking for one.
pub const LS_STREAM_GONE: i32 = 2;
/// Reader status: the recording is over.
pub const LS_STREAM_END: i32 = 3;

/// What a reader found. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsStreamPoll {
    /// LS_STREAM_FRAME, LS_STREAM_NOTHING, LS_STREAM_GONE or LS_STREAM_END.
    pub status: i32,
    /// 1 for the first frame of a publisher that has begun, or begun anew; else 0.
    pub is_first: u32,
    /// 1 if the whole world has been told and nothing was missed since; else 0.
    pub is_complete: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// Frames that were published since the last one and could not be read any more.
    pub lost_frames: u64,
    /// Messages of the cold channel that were missed.
    pub lost_records: u64,
    /// Header of the last frame; all zero before the first.
    pub frame: LsStreamHeader,
}

/// A stream that can be read. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsStreamSource {
    /// Its name, closed by a zero.
    pub name: [c_char; 64],
    /// Number of the process that publishes it.
    pub process: u32,
    /// Number of the stream in that process.
    pub number: u32,
    /// Its schema; this library reads LS_STREAM_SCHEMA.
    pub schema: u32,
    /// Not used; 0.
    pub reserved: u32,
}

/// Recording end: it was finished.
pub const LS_STREAM_RECORDING_FINISHED: i32 = 0;
/// Recording end: it was cut short.
pub const LS_STREAM_RECORDING_CUT: i32 = 1;
/// Recording end: some of it is damaged and left out.
pub const LS_STREAM_RECORDING_DAMAGED: i32 = 2;

/// A recording as a whole. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsStreamRecording {
    /// First step of which there is a frame.
    pub first_step: u64,
    /// Last step of which there is a frame.
    pub last_step: u64,
    /// Number of frames.
    pub frames: u64,
    /// First byte of what is missing or damaged; 0 if nothing is.
    pub offset: u64,
    /// LS_STREAM_RECORDING_ constant.
    pub end: i32,
    /// Not used; 0.
    pub reserved: u32,
}

// SAFETY: numbers and pointers without padding.
unsafe impl Versioned for LsStreamDef {
    const SIZES: &'static [usize] = &[40];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsStreamDef {}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsStreamStats {
    const SIZES: &'static [usize] = &[40];
}

// SAFETY: numbers and pointers without padding.
unsafe impl Versioned for LsStreamReaderDef {
    const SIZES: &'static [usize] = &[32];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsStreamReaderDef {}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsStreamPoll {
    const SIZES: &'static [usize] = &[160];
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsStreamRecording {
    const SIZES: &'static [usize] = &[40];
}

impl Default for LsStreamDef {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            every: 1,
            name: ptr::null(),
            domain: ptr::null(),
            layers: 0,
            readers: 8,
            body_capacity: 0,
            state_hash: 1,
        }
    }
}

impl Default for LsStreamReaderDef {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            reserved: 0,
            name: ptr::null(),
            domain: ptr::null(),
            recording: ptr::null(),
        }
    }
}
