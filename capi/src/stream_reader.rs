//! Readers of streams, live or recorded. Without the feature `stream` every function here says so and does nothing else.

use std::ffi::c_char;

use longspan_stream_schema::{
    LsStreamBody, LsStreamBound, LsStreamBreak, LsStreamContact, LsStreamEvent, LsStreamJoint, LsStreamJointLoad, LsStreamPiece,
    LsStreamPlane, LsStreamShape, LsStreamWorld,
};

use crate::boundary::call;
use crate::result::LsResult;
use crate::stream::streaming;
use crate::stream_def::{LsStreamPoll, LsStreamReader, LsStreamReaderDef, LsStreamRecording};

#[cfg(streams)]
use crate::{
    pointer::{Out, host},
    sized::{self, SizedOut},
    stream_reading as reading,
};

/// Fills a reader definition with defaults.
///
/// @param def   filled on LS_OK
/// @param size  sizeof *def as the host knows it
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_def_init(def: *mut LsStreamReaderDef, size: usize) -> LsResult {
    streaming!("ls_stream_reader_def_init", [def, size], {
        host!(SizedOut::new, def, size).write_definition(&LsStreamReaderDef::default())
    })
}

/// Makes a reader of a stream, or of a recording. A stream need not be there yet, may end, and may begin anew: the reader finds it.
///
/// What comes from a publisher is checked and never believed: no bytes of it make the reader fail in another way than by an error.
/// @param def  filled by ls_stream_reader_def_init and changed as wanted; read during the call
/// @param out  the reader, on LS_OK; the host ends it with ls_stream_reader_close
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE,
///         LS_ERROR_STREAM_SYSTEM, LS_ERROR_STREAM_INCOMPATIBLE, LS_ERROR_STREAM_CORRUPT
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_open(def: *const LsStreamReaderDef, out: *mut LsStreamReader) -> LsResult {
    streaming!("ls_stream_reader_open", [def, out], {
        let (def, out) = (host!(sized::read, def), host!(Out::new, out));
        out.write(reading::open(&def)?)
    })
}

/// Ends a reader; its arrays end here. A file that it records is finished.
///
/// @param reader  the reader; any value is safe
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_STREAM_SYSTEM
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub extern "C" fn ls_stream_reader_close(reader: LsStreamReader) -> LsResult {
    streaming!("ls_stream_reader_close", [reader], reading::close(reader))
}

/// Takes in all that has come, and says what that was. Of a recording it takes the next frame.
///
/// @param reader   the reader; any value is safe
/// @param timeout  how long to wait for a frame (s), 0 to 3600; 0 only looks. Who waits costs the publisher nothing.
/// @param out      filled on LS_OK
/// @param size     sizeof *out as the host knows it
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY (another thread uses the reader), LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_STREAM_SYSTEM, LS_ERROR_STREAM_INCOMPATIBLE (a stream of another version),
///         LS_ERROR_STREAM_CORRUPT (a message made no sense and was left out; the next call goes on)
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_poll(
    reader: LsStreamReader,
    timeout: f32,
    out: *mut LsStreamPoll,
    size: usize,
) -> LsResult {
    streaming!("ls_stream_reader_poll", [reader, timeout, out, size], {
        let out = host!(SizedOut::new, out, size);
        out.write(&reading::poll(reader, timeout)?)
    })
}

/// Takes in the next frame, not the newest: for who wants each of them.
///
/// @param reader  the reader; any value is safe
/// @param out     filled on LS_OK
/// @param size    sizeof *out as the host knows it
/// @return as ls_stream_reader_poll, LS_ERROR_NULL_ARGUMENT and LS_ERROR_STRUCT_SIZE among them
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_next(reader: LsStreamReader, out: *mut LsStreamPoll, size: usize) -> LsResult {
    streaming!("ls_stream_reader_next", [reader, out, size], {
        let out = host!(SizedOut::new, out, size);
        out.write(&reading::next(reader)?)
    })
}

/// Goes to the frame of a step of a recording, or the last one before it.
///
/// @param reader  the reader of a recording; any value is safe
/// @param step    number of the step
/// @param out     filled on LS_OK
/// @param size    sizeof *out as the host knows it
/// @return as ls_stream_reader_poll, LS_ERROR_NULL_ARGUMENT and LS_ERROR_STRUCT_SIZE among them; LS_ERROR_OUT_OF_RANGE if the
///         reader reads a live stream
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_seek(
    reader: LsStreamReader,
    step: u64,
    out: *mut LsStreamPoll,
    size: usize,
) -> LsResult {
    streaming!("ls_stream_reader_seek", [reader, step, out, size], {
        let out = host!(SizedOut::new, out, size);
        out.write(&reading::seek(reader, step)?)
    })
}

/// Settings of the world that the stream is of.
///
/// @param reader  the reader; any value is safe
/// @param out     filled on LS_OK; all zero before they have been told
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_world_get(reader: LsStreamReader, out: *mut LsStreamWorld) -> LsResult {
    streaming!("ls_stream_reader_world_get", [reader, out], {
        let out = host!(Out::new, out);
        reading::with(reader, |state| out.write(*state.reader.scene().world()))
    })
}

/// Bodies as the last frame left them, by handle.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_bodies_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamBody,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_bodies_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.bodies();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// Shapes, by handle and part.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_shapes_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamShape,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_shapes_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.shapes();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// Joints, by handle.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_joints_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamJoint,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_joints_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.joints();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// Contacts of the last frame; none unless the stream has LS_STREAM_LAYER_CONTACTS.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_contacts_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamContact,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_contacts_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.contacts();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// What joints carry in the last frame; none unless the stream has LS_STREAM_LAYER_JOINT_LOADS.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_joint_loads_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamJointLoad,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_joint_loads_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.joint_loads();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// Long-range bounds of the last frame; none unless the stream has LS_STREAM_LAYER_BOUNDS.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_bounds_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamBound,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_bounds_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.bounds();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// Planes of hinge chains in the last frame; none unless the stream has LS_STREAM_LAYER_PLANES.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_planes_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamPlane,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_planes_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.planes();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// What happened, as far as the last call of ls_stream_reader_poll, _next or _seek brought it: the oldest first.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_events_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamEvent,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_events_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.events();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// Joints that broke since the last call of ls_stream_reader_poll, _next or _seek, the oldest first.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_breaks_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamBreak,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_breaks_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.breaks();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// Pieces of unions that fell apart since the last call of ls_stream_reader_poll, _next or _seek, the oldest first.
///
/// @param reader  the reader; any value is safe
/// @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
///                or _close for this reader; do not follow it if the count is 0
/// @param count   number of elements
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_pieces_get(
    reader: LsStreamReader,
    out: *mut *const LsStreamPiece,
    count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_pieces_get", [reader, out, count], {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        reading::with(reader, |state| {
            let found = state.pieces();
            out.write(found.as_ptr())?;
            count.write(found.len())
        })
    })
}

/// Triangles of a part of a shape that a few numbers do not describe: a hull, a mesh, a height field.
///
/// @param reader          the reader; any value is safe
/// @param shape           LsStreamShape.shape
/// @param part            LsStreamShape.part
/// @param vertices        three floats each, in the part's frame (m), owned by the reader as its other arrays are
/// @param vertex_count    number of vertices; 0 if they have not come yet, or the part has none
/// @param triangles       three numbers of vertices each, counter-clockwise seen from outside, each less than vertex_count
/// @param triangle_count  number of triangles
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_mesh_get(
    reader: LsStreamReader,
    shape: u64,
    part: u32,
    vertices: *mut *const [f32; 3],
    vertex_count: *mut usize,
    triangles: *mut *const [u32; 3],
    triangle_count: *mut usize,
) -> LsResult {
    streaming!("ls_stream_reader_mesh_get", [reader, shape, part, vertices, vertex_count, triangles, triangle_count], {
        let (vertices, vertex_count) = (host!(Out::new, vertices), host!(Out::new, vertex_count));
        let (triangles, triangle_count) = (host!(Out::new, triangles), host!(Out::new, triangle_count));
        reading::with(reader, |state| {
            let mesh = state.reader.scene().mesh(shape, part);
            let (points, corners) = mesh.map_or((&[][..], &[][..]), |mesh| (&mesh.vertices[..], &mesh.triangles[..]));
            vertices.write(points.as_ptr())?;
            vertex_count.write(points.len())?;
            triangles.write(corners.as_ptr())?;
            triangle_count.write(corners.len())
        })
    })
}

/// Hash of what the reader knows: the step, and handles, poses, velocities and flags of all bodies, and the joints. The same frame
/// of a recording has the same.
///
/// @param reader  the reader; any value is safe
/// @param out     filled on LS_OK
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_hash_get(reader: LsStreamReader, out: *mut u64) -> LsResult {
    streaming!("ls_stream_reader_hash_get", [reader, out], {
        let out = host!(Out::new, out);
        reading::with(reader, |state| out.write(state.reader.scene().hash()))
    })
}

/// Records from now on all that the reader takes in.
///
/// @param reader  the reader of a live stream; any value is safe
/// @param file    path of the file, replaced if it is there; NULL finishes the file under way
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_OUT_OF_RANGE, LS_ERROR_STREAM_SYSTEM; not LS_ERROR_NULL_ARGUMENT
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_record(reader: LsStreamReader, file: *const c_char) -> LsResult {
    streaming!("ls_stream_reader_record", [reader, file], {
        let file = host!(crate::stream_host::text, file);
        reading::record(reader, &file)
    })
}

/// What is known of a recording as a whole.
///
/// @param reader  the reader of a recording; any value is safe
/// @param out     filled on LS_OK
/// @param size    sizeof *out as the host knows it
/// @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
///         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_NOT_APPLICABLE (a live stream)
/// Threads: one thread at a time for each reader. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_stream_reader_recording_get(
    reader: LsStreamReader,
    out: *mut LsStreamRecording,
    size: usize,
) -> LsResult {
    streaming!("ls_stream_reader_recording_get", [reader, out, size], {
        let out = host!(SizedOut::new, out, size);
        out.write(&reading::recording(reader)?)
    })
}
