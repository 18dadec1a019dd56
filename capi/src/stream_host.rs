//! Publishers behind handles; only with the feature `stream`.

use std::collections::BTreeMap;
use std::ffi::{CStr, c_char};
use std::sync::{Mutex, PoisonError};

use ls_core::World;
use ls_stream::{Domain, Problem, Publisher, PublisherDef, Source};

use crate::access::{edit_hosted, read_hosted};
use crate::handle::LsWorld;
use crate::result::{
    Failure, LS_ERROR_INVALID_HANDLE, LS_ERROR_NULL_HANDLE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_STALE_HANDLE,
    LS_ERROR_STREAM_CORRUPT, LS_ERROR_STREAM_INCOMPATIBLE, LS_ERROR_STREAM_SYSTEM, Outcome,
};
use crate::stream_def::{LsStream, LsStreamDef, LsStreamSource, LsStreamStats};

/// Handles of one kind: `check | number`; a number is never given out twice.
pub(crate) struct Handles<T> {
    check: u64,
    argument: &'static str,
    content: Mutex<(u64, BTreeMap<u64, T>)>,
}

const NUMBER_BITS: u32 = 54;

impl<T: Clone> Handles<T> {
    pub(crate) const fn new(check: u64, argument: &'static str) -> Self {
        Self { check, argument, content: Mutex::new((0, BTreeMap::new())) }
    }

    pub(crate) fn insert(&self, value: T) -> u64 {
        let mut content = self.content.lock().unwrap_or_else(PoisonError::into_inner);
        content.0 += 1;
        let id = self.check << NUMBER_BITS | content.0;
        content.1.insert(id, value);
        id
    }

    pub(crate) fn find(&self, id: u64) -> Outcome<T> {
        let content = self.content.lock().unwrap_or_else(PoisonError::into_inner);
        let refuse = |code, problem| Err(Failure::Refused(code, self.argument, problem));
        match content.1.get(&id) {
            Some(value) => Ok(value.clone()),
            None if id == 0 => refuse(LS_ERROR_NULL_HANDLE, "handle is null"),
            None if id >> NUMBER_BITS == self.check && (1..=content.0).contains(&(id & ((1 << NUMBER_BITS) - 1))) => {
                refuse(LS_ERROR_STALE_HANDLE, "has ended")
            }
            None => refuse(LS_ERROR_INVALID_HANDLE, "handle was never given out"),
        }
    }

    pub(crate) fn remove(&self, id: u64) {
        self.content.lock().unwrap_or_else(PoisonError::into_inner).1.remove(&id);
    }
}

static STREAMS: Handles<LsWorld> = Handles::new(0x2C3, "stream");

/// The streams of a world.
#[derive(Default)]
pub(crate) struct Streams(Vec<(u64, Mutex<Publisher>)>);

impl Streams {
    pub(crate) fn publish(&mut self, world: &World) {
        for (_, publisher) in &mut self.0 {
            publisher.get_mut().unwrap_or_else(PoisonError::into_inner).publish(world);
        }
    }
}

impl Drop for Streams {
    fn drop(&mut self) {
        self.0.iter().for_each(|(id, _)| STREAMS.remove(*id));
    }
}

impl From<Problem> for Failure {
    fn from(problem: Problem) -> Self {
        match problem {
            Problem::Argument(argument, what) => Self::Refused(LS_ERROR_OUT_OF_RANGE, argument, what),
            Problem::Corrupt(what) => Self::Refused(LS_ERROR_STREAM_CORRUPT, "stream", what),
            Problem::Incompatible(what) => Self::Described(LS_ERROR_STREAM_INCOMPATIBLE, what),
            Problem::System(what) => Self::Described(LS_ERROR_STREAM_SYSTEM, what),
        }
    }
}

/// A text of the host; empty for NULL.
///
/// # Safety
/// `text` is null, or ends with a zero and is readable up to there during the call.
pub(crate) unsafe fn text(text: *const c_char, name: &'static str) -> Outcome<String> {
    if text.is_null() {
        return Ok(String::new());
    }
    // SAFETY: not null; closed by a zero, as promised to this function.
    let bytes = unsafe { CStr::from_ptr(text) };
    bytes.to_str().map(str::to_owned).map_err(|_| Failure::Refused(LS_ERROR_OUT_OF_RANGE, name, "is not UTF-8"))
}

pub(crate) fn open(world: LsWorld, def: &LsStreamDef) -> Outcome<LsStream> {
    // SAFETY: the header asks for names that are NULL or closed by a zero.
    let (name, domain) = unsafe { (text(def.name, "name")?, text(def.domain, "domain")?) };
    let def = PublisherDef {
        name: if name.is_empty() { "world".to_owned() } else { name },
        domain: Domain::named(&domain)?,
        every: def.every,
        layers: def.layers,
        readers: def.readers,
        body_capacity: def.body_capacity,
        state_hash: def.state_hash != 0,
    };
    edit_hosted(world, |hosted| {
        let publisher = Publisher::open(&hosted.world, &def)?;
        let id = STREAMS.insert(world);
        hosted.streams.0.push((id, Mutex::new(publisher)));
        Ok(LsStream { id })
    })
}

pub(crate) fn close(stream: LsStream) -> Outcome<()> {
    let world = STREAMS.find(stream.id)?;
    edit_hosted(world, |hosted| {
        hosted.streams.0.retain(|(id, _)| *id != stream.id);
        STREAMS.remove(stream.id);
        Ok(())
    })
}

pub(crate) fn serve(stream: LsStream) -> Outcome<()> {
    let world = STREAMS.find(stream.id)?;
    edit_hosted(world, |hosted| {
        for (_, publisher) in hosted.streams.0.iter_mut().filter(|(id, _)| *id == stream.id) {
            publisher.get_mut().unwrap_or_else(PoisonError::into_inner).serve();
        }
        Ok(())
    })
}

pub(crate) fn stats(stream: LsStream) -> Outcome<LsStreamStats> {
    let world = STREAMS.find(stream.id)?;
    read_hosted(world, |hosted| {
        let found = hosted.streams.0.iter().find(|(id, _)| *id == stream.id);
        let (_, publisher) = found.ok_or(Failure::Refused(LS_ERROR_STALE_HANDLE, "stream", "has ended"))?;
        let stats = *publisher.lock().unwrap_or_else(PoisonError::into_inner).stats();
        let ls_stream::PublisherStats { frames, records, dropped, bytes, seconds } = stats;
        Ok(LsStreamStats { frames, records, dropped, bytes, seconds })
    })
}

pub(crate) fn sources(domain: &str) -> Outcome<Vec<Source>> {
    Ok(Domain::named(domain)?.sources()?)
}

pub(crate) fn source(source: &Source) -> LsStreamSource {
    let mut name = [0; 64];
    for (to, from) in name.iter_mut().zip(source.name.bytes().take(63)) {
        *to = from as c_char;
    }
    LsStreamSource { name, process: source.process, number: source.number, schema: source.schema, reserved: 0 }
}
