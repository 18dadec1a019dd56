//! Streams: a world's poses and events to other processes. Without the feature `stream` every function here says so and does
//! nothing else.

use std::ffi::c_char;

use crate::boundary::call;
use crate::handle::LsWorld;
use crate::result::{Failure, LS_ERROR_UNSUPPORTED, LsResult};
use crate::stream_def::{LsStream, LsStreamDef, LsStreamSource, LsStreamStats};

/// What a library without streams answers.
#[allow(dead_code, reason = "a library with streams does not")]
pub(crate) fn unsupported() -> Failure {
    Failure::Refused(LS_ERROR_UNSUPPORTED, "stream", "this library was built without the feature `stream`")
}

/// The body of an export that is there only with the feature.
macro_rules! streaming {
    ($name:literal, [$($argument:ident),*], $work:expr) => {{
        #[cfg(streams)]
        let result = call($name, || $work);
        #[cfg(not(streams))]
        let result = {
            let _ = ($($argument),*);
            call($name, || Err($crate::stream::unsupported()))
        };
        result
    }};
}
pub(crate) use streaming;

#[cfg(streams)]
use crate::{
    pointer::{Buffer, Out, host},
    sized::{self, SizedOut},
    stream_host,
};

/// Fills a stream definition with defaults.
///
/// @param def   filled on LS_OK
/// @param size  sizeof *def as the host knows it
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_def_init(def: *mut LsStreamDef, size: usize) -> LsResult {
    streaming!("ls_stream_def_init", [def, size], { host!(SizedOut::new, def, size).write_definition(&LsStreamDef::default()) })
}

/// Begins to publish a world to other processes of this user, through shared memory; docs/reference/stream-bytes.md has the bytes.
///
/// From now on each ls_world_step ends with a publication, which never waits and never fails: what cannot be placed is counted.
/// Leftovers of publishers that died are removed here. A world may have several streams.
/// @param world  the world; any value is safe
/// @param def    filled by ls_stream_def_init and changed as wanted; read during the call
/// @param out    the stream, on LS_OK; it ends with ls_stream_close, or with its world
/// @return LS_OK, LS_ERROR_UNSUPPORTED, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE,
///         LS_ERROR_STREAM_SYSTEM
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_open(world: LsWorld, def: *const LsStreamDef, out: *mut LsStream) -> LsResult {
    streaming!("ls_stream_open", [world, def, out], {
        let (def, out) = (host!(sized::read, def), host!(Out::new, out));
        out.write(stream_host::open(world, &def)?)
    })
}

/// Ends a stream.
///
/// @param stream  the stream; any value is safe
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE, a world error
/// Threads: edit of its world. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_stream_close(stream: LsStream) -> LsResult {
    streaming!("ls_stream_close", [stream], stream_host::close(stream))
}

/// Lets readers in that have come since the last step, and gives them what they are to have; for a host that is not stepping its
/// world now. A step does it too.
///
/// @param stream  the stream; any value is safe
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE, a world error
/// Threads: edit of its world. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_stream_serve(stream: LsStream) -> LsResult {
    streaming!("ls_stream_serve", [stream], stream_host::serve(stream))
}

/// What a stream has done so far.
///
/// @param stream  the stream; any value is safe
/// @param out     filled on LS_OK
/// @param size    sizeof *out as the host knows it
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE, a world error,
///         LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: read of its world. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_stats_get(stream: LsStream, out: *mut LsStreamStats, size: usize) -> LsResult {
    streaming!("ls_stream_stats_get", [stream, out, size], {
        let out = host!(SizedOut::new, out, size);
        out.write(&stream_host::stats(stream)?)
    })
}

/// Streams that are published now by processes of this user.
///
/// @param domain    see LsStreamDef; may be NULL
/// @param out       room for capacity sources, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of sources that fit
/// @param count     number of streams, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE, LS_ERROR_BUFFER_TOO_SMALL,
///         LS_ERROR_STREAM_SYSTEM
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_sources_get(
    domain: *const c_char,
    out: *mut LsStreamSource,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_sources_get", [domain, out, capacity, count], {
        let buffer = host!(Buffer::new, out, capacity, count);
        let sources = stream_host::sources(&host!(stream_host::text, domain))?;
        buffer.fill(|| sources.iter().map(stream_host::source))
    })
}
