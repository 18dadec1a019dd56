//! Readers behind handles; only with the feature `stream`.

use std::path::Path;
use std::sync::{Arc, Mutex, TryLockError};
use std::time::Duration;

use ls_stream::schema::{
    LsStreamBody, LsStreamBound, LsStreamBreak, LsStreamContact, LsStreamEvent, LsStreamJoint, LsStreamJointLoad, LsStreamPiece,
    LsStreamPlane, LsStreamShape,
};
use ls_stream::{Domain, End, Poll, Reader};

use crate::result::{Failure, LS_ERROR_NOT_APPLICABLE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_WORLD_BUSY, Outcome};
use crate::stream_def::*;
use crate::stream_host::{Handles, text};

/// Longest time to wait for a frame (s).
const LONGEST: f32 = 3600.0;

/// A reader, and what of its scene has been put in rows for C.
pub(crate) struct Reading {
    pub reader: Reader,
    bodies: Vec<LsStreamBody>,
    shapes: Vec<LsStreamShape>,
    joints: Vec<LsStreamJoint>,
}

static READERS: Handles<Arc<Mutex<Reading>>> = Handles::new(0x2D1, "reader");

/// A row that is filled when it is first asked for, and emptied when the scene moves on.
fn row<'a, 's, T: Copy + 's>(row: &'a mut Vec<T>, records: impl Iterator<Item = &'s T>) -> &'a [T] {
    if row.is_empty() {
        row.extend(records.copied());
    }
    row
}

impl Reading {
    pub(crate) fn bodies(&mut self) -> &[LsStreamBody] {
        row(&mut self.bodies, self.reader.scene().bodies())
    }

    pub(crate) fn shapes(&mut self) -> &[LsStreamShape] {
        row(&mut self.shapes, self.reader.scene().shapes())
    }

    pub(crate) fn joints(&mut self) -> &[LsStreamJoint] {
        row(&mut self.joints, self.reader.scene().joints())
    }

    pub(crate) fn contacts(&self) -> &[LsStreamContact] {
        self.reader.scene().contacts()
    }

    pub(crate) fn joint_loads(&self) -> &[LsStreamJointLoad] {
        self.reader.scene().joint_loads()
    }

    pub(crate) fn bounds(&self) -> &[LsStreamBound] {
        self.reader.scene().bounds()
    }

    pub(crate) fn planes(&self) -> &[LsStreamPlane] {
        self.reader.scene().planes()
    }

    pub(crate) fn events(&self) -> &[LsStreamEvent] {
        self.reader.scene().events()
    }

    pub(crate) fn breaks(&self) -> &[LsStreamBreak] {
        self.reader.scene().breaks()
    }

    pub(crate) fn pieces(&self) -> &[LsStreamPiece] {
        self.reader.scene().pieces()
    }

    fn expire(&mut self) {
        self.bodies.clear();
        self.shapes.clear();
        self.joints.clear();
        self.reader.forget_events();
    }

    fn found(&self, poll: Poll) -> LsStreamPoll {
        let (status, lost_frames, lost_records, is_first) = match poll {
            Poll::Frame { lost_frames, lost_records, is_first } => (LS_STREAM_FRAME, lost_frames, lost_records, is_first),
            Poll::Nothing => (LS_STREAM_NOTHING, 0, 0, false),
            Poll::Gone => (LS_STREAM_GONE, 0, 0, false),
            Poll::End => (LS_STREAM_END, 0, 0, false),
        };
        let scene = self.reader.scene();
        LsStreamPoll {
            status,
            is_first: is_first.into(),
            is_complete: scene.is_complete().into(),
            reserved: 0,
            lost_frames,
            lost_records,
            frame: *scene.frame(),
        }
    }
}

/// Work with a reader that nobody else is using now.
pub(crate) fn with<R>(reader: LsStreamReader, work: impl FnOnce(&mut Reading) -> Outcome<R>) -> Outcome<R> {
    let found = READERS.find(reader.id)?;
    let mut reading = match found.try_lock() {
        Ok(reading) => reading,
        // What a panic left half-done is a scene, which the next cycle puts right.
        Err(TryLockError::Poisoned(reading)) => reading.into_inner(),
        Err(TryLockError::WouldBlock) => {
            return Err(Failure::Refused(LS_ERROR_WORLD_BUSY, "reader", "another thread is using the reader"));
        }
    };
    work(&mut reading)
}

pub(crate) fn open(def: &LsStreamReaderDef) -> Outcome<LsStreamReader> {
    // SAFETY: the header asks for texts that are NULL or closed by a zero.
    let (name, domain, recording) =
        unsafe { (text(def.name, "name")?, text(def.domain, "domain")?, text(def.recording, "recording")?) };
    let reader = if recording.is_empty() {
        Reader::attach(&Domain::named(&domain)?, &name)?
    } else {
        Reader::open(Path::new(&recording))?
    };
    let reading = Reading { reader, bodies: Vec::new(), shapes: Vec::new(), joints: Vec::new() };
    Ok(LsStreamReader { id: READERS.insert(Arc::new(Mutex::new(reading))) })
}

pub(crate) fn close(reader: LsStreamReader) -> Outcome<()> {
    let finished = with(reader, |reading| Ok(reading.reader.record(None)))?;
    READERS.remove(reader.id);
    Ok(finished?)
}

pub(crate) fn poll(reader: LsStreamReader, timeout: f32) -> Outcome<LsStreamPoll> {
    if !(0.0..=LONGEST).contains(&timeout) {
        return Err(Failure::Refused(LS_ERROR_OUT_OF_RANGE, "timeout", "must be 0 to 3600 s"));
    }
    with(reader, |reading| {
        reading.expire();
        let poll = reading.reader.wait(Duration::from_secs_f32(timeout))?;
        Ok(reading.found(poll))
    })
}

pub(crate) fn next(reader: LsStreamReader) -> Outcome<LsStreamPoll> {
    with(reader, |reading| {
        reading.expire();
        let poll = reading.reader.poll_next()?;
        Ok(reading.found(poll))
    })
}

pub(crate) fn seek(reader: LsStreamReader, step: u64) -> Outcome<LsStreamPoll> {
    with(reader, |reading| {
        reading.expire();
        let poll = reading.reader.seek(step)?;
        Ok(reading.found(poll))
    })
}

pub(crate) fn record(reader: LsStreamReader, file: &str) -> Outcome<()> {
    with(reader, |reading| Ok(reading.reader.record(Some(Path::new(file)).filter(|_| !file.is_empty()))?))
}

pub(crate) fn recording(reader: LsStreamReader) -> Outcome<LsStreamRecording> {
    with(reader, |reading| {
        let live = Failure::Refused(LS_ERROR_NOT_APPLICABLE, "reader", "reads a live stream");
        let info = reading.reader.recording().ok_or(live)?;
        let (end, offset) = match info.end {
            End::Finished => (LS_STREAM_RECORDING_FINISHED, 0),
            End::CutAfter(at) => (LS_STREAM_RECORDING_CUT, at),
            End::DamagedAt(at) => (LS_STREAM_RECORDING_DAMAGED, at),
        };
        let (first_step, last_step) = info.steps.unwrap_or_default();
        Ok(LsStreamRecording { first_step, last_step, frames: info.frames, offset, end, reserved: 0 })
    })
}
