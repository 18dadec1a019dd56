#!/usr/bin/env python3
"""How a recorded world moved, from Python: kinetic energy and number of moving bodies over time, as CSV.

    cargo build --release -p longspan-capi --features stream
    python3 examples/analyse.py target/release/liblongspan.so run.lsr

Only ctypes is needed; where numpy is installed, numpy.ctypeslib.as_array on an array of Body gives a structured array.
"""
import ctypes
import sys

U32, U64, I32, F32, F64 = ctypes.c_uint32, ctypes.c_uint64, ctypes.c_int32, ctypes.c_float, ctypes.c_double


class Header(ctypes.Structure):
    _fields_ = (
        [("magic", U64), ("schema", U32), ("header_size", U32), ("layout_hash", U64), ("length", U64), ("session", U64)]
        + [("sequence", U64), ("step", U64), ("time", F64), ("state_hash", U64), ("content_hash", U64), ("dropped", U64)]
        + [(name, U32) for name in ("channel", "section_count", "body_count", "shape_count", "joint_count", "flags")]
        + [("cycle", U64), ("clock", U64)]
    )


class Poll(ctypes.Structure):
    _fields_ = [("status", I32), ("is_first", U32), ("is_complete", U32), ("reserved", U32), ("lost_frames", U64),
                ("lost_records", U64), ("frame", Header)]


class ReaderDef(ctypes.Structure):
    _fields_ = [("struct_size", U32), ("reserved", U32), ("name", ctypes.c_char_p), ("domain", ctypes.c_char_p),
                ("recording", ctypes.c_char_p)]


class Reader(ctypes.Structure):
    _fields_ = [("id", U64)]


class Body(ctypes.Structure):
    _fields_ = [("body", U64), ("user_word", U64), ("union_id", U64), ("step", U64), ("position", F64 * 3), ("rotation", F32 * 4),
                ("linear_velocity", F32 * 3), ("angular_velocity", F32 * 3), ("flags", U32), ("kind", I32), ("mass", F32),
                ("support", I32), ("support_margin", F32), ("support_load", F32)]


STREAM_FRAME, STREAM_END = 0, 3


def main(library_path, recording):
    library = ctypes.CDLL(library_path)
    library.ls_last_error_message_get.restype = ctypes.c_char_p

    def check(result):
        if result != 0:
            sys.exit(library.ls_last_error_message_get().decode())

    definition, reader, poll = ReaderDef(), Reader(), Poll()
    check(library.ls_stream_reader_def_init(ctypes.byref(definition), ctypes.c_size_t(ctypes.sizeof(definition))))
    definition.recording = recording.encode()
    check(library.ls_stream_reader_open(ctypes.byref(definition), ctypes.byref(reader)))
    bodies, count = ctypes.POINTER(Body)(), ctypes.c_size_t()
    print("step,time_s,bodies,moving,kinetic_energy_J")
    while True:
        check(library.ls_stream_reader_next(reader, ctypes.byref(poll), ctypes.c_size_t(ctypes.sizeof(poll))))
        if poll.status != STREAM_FRAME:
            break
        check(library.ls_stream_reader_bodies_get(reader, ctypes.byref(bodies), ctypes.byref(count)))
        energy, moving = 0.0, 0
        for body in bodies[: count.value]:
            squared = sum(v * v for v in body.linear_velocity)
            energy += 0.5 * body.mass * squared
            moving += squared > 1e-6
        print(f"{poll.frame.step},{poll.frame.time:.4f},{count.value},{moving},{energy:.6g}")
    check(library.ls_stream_reader_close(reader))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
