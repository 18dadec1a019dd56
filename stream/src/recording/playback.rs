//! Reading a recording.

use std::fs::File;
use std::path::Path;

use longspan_stream_schema::{LS_STREAM_CHANNEL_HOT, LsStreamHeader};

use super::format::{CHUNK_HEADER, CHUNK_START, ChunkHeader, FILE_HEADER, FileHeader, MAX_CHUNK, STORED_LZ4, STORED_PLAIN};
use crate::message::{HEADER, Message};
use crate::platform::FileExt;
use crate::problem::{Problem, Result};
use crate::scene::Scene;

/// How a recording ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// As it was finished.
    Finished,
    /// It was cut short: after this byte there is no whole chunk.
    CutAfter(u64),
    /// It was not cut short, but is damaged: the first byte of what had to be left out.
    DamagedAt(u64),
}

/// A recording as a whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingInfo {
    /// First and last step of which there is a frame; `None` if there is no frame.
    pub steps: Option<(u64, u64)>,
    /// Number of frames.
    pub frames: u64,
    /// How it ends.
    pub end: End,
}

#[derive(Debug, Clone, Copy)]
struct Chunk {
    at: u64,
    header: ChunkHeader,
}

/// Plays a recording.
#[derive(Debug)]
pub struct Playback {
    file: File,
    chunks: Vec<Chunk>,
    info: RecordingInfo,
    /// Chunk that is played, and its messages.
    current: Option<usize>,
    content: Vec<u8>,
    /// First byte of the next message.
    next: usize,
    stored: Vec<u8>,
}

impl Playback {
    /// Opens a recording and finds its chunks.
    ///
    /// # Errors
    /// The file cannot be read; is no recording; or is one of another version. Damage further on is no error: see
    /// [`RecordingInfo::end`].
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        let mut head = [0; FILE_HEADER];
        if file.read_exact_at(&mut head, 0).is_err() {
            return Err(Problem::Corrupt("the file ends before a recording begins"));
        }
        FileHeader::check(&head)?;
        let (mut chunks, mut at, mut damaged, mut finished) = (Vec::new(), FILE_HEADER as u64, None, false);
        while !finished {
            let Some(header) = chunk_header(&file, at) else {
                if at >= length {
                    break;
                }
                damaged.get_or_insert(at);
                match next_chunk(&file, at + 1, length) {
                    Some(found) => at = found,
                    None => break,
                }
                continue;
            };
            finished = header.is_closing();
            let end = at + CHUNK_HEADER as u64 + header.stored;
            if end > length {
                damaged.get_or_insert(at);
                break;
            }
            if !finished {
                chunks.push(Chunk { at, header });
            }
            at = end;
        }
        let end = match (finished, damaged) {
            (true, None) => End::Finished,
            (true, Some(at)) => End::DamagedAt(at),
            (false, damaged) => End::CutAfter(damaged.unwrap_or(at)),
        };
        let mut playback = Self {
            file,
            chunks,
            info: RecordingInfo { steps: None, frames: 0, end },
            current: None,
            content: Vec::new(),
            next: 0,
            stored: Vec::new(),
        };
        playback.leave_out_damaged();
        Ok(playback)
    }

    /// Checks the content of all chunks once, so that what is said of the recording holds.
    fn leave_out_damaged(&mut self) {
        let mut whole = Vec::new();
        for chunk in std::mem::take(&mut self.chunks) {
            if read_stored(&self.file, &chunk, &mut self.stored).is_ok() {
                whole.push(chunk);
            } else {
                let earlier = match self.info.end {
                    End::Finished => chunk.at,
                    End::CutAfter(at) | End::DamagedAt(at) => at.min(chunk.at),
                };
                self.info.end = End::DamagedAt(earlier);
            }
        }
        self.info.frames = whole.iter().map(|chunk| u64::from(chunk.header.frames)).sum();
        let mut with_frames = whole.iter().filter(|chunk| chunk.header.frames > 0).map(|chunk| &chunk.header);
        self.info.steps = with_frames.next().map(|first| {
            let last = whole.iter().rfind(|chunk| chunk.header.frames > 0).map_or(first.last_step, |c| c.header.last_step);
            (first.first_step, last)
        });
        self.chunks = whole;
    }

    /// What is known of it as a whole.
    pub fn info(&self) -> &RecordingInfo {
        &self.info
    }

    /// Takes the next frame into `scene`, with all that was told before it; `None` at the end. What it returns is the number of
    /// messages of the cold channel that were missed, when the recording was made or because the file is damaged.
    ///
    /// # Errors
    /// `Corrupt`: a chunk or message had to be left out; the next call goes on behind it.
    pub fn next(&mut self, scene: &mut Scene) -> Result<Option<u64>> {
        let mut lost = 0;
        loop {
            if self.next >= self.content.len() {
                let following = self.current.map_or(0, |current| current + 1);
                let Some(&chunk) = self.chunks.get(following) else { return Ok(None) };
                let expected = self.current.map(|current| end_of(&self.chunks[current]));
                self.current = Some(following);
                self.load(&chunk)?;
                if expected == Some(chunk.at) {
                    // The scene has come this far by itself.
                    self.next = chunk.header.keyframe as usize;
                } else {
                    lost += u64::from(expected.is_some());
                    scene.begin_anew();
                }
                continue;
            }
            let from = self.next;
            let keyframe = self.current.is_some_and(|current| (from as u64) < self.chunks[current].header.keyframe);
            let message = self.take_message()?;
            let channel = message.header.channel;
            scene.apply(&message)?;
            if channel == LS_STREAM_CHANNEL_HOT && !keyframe {
                return Ok(Some(lost));
            }
        }
    }

    /// Goes to the frame of `step` or the last one before it; false if there is none, and then to the first.
    ///
    /// # Errors
    /// As [`next`](Self::next).
    pub fn seek(&mut self, step: u64, scene: &mut Scene) -> Result<bool> {
        let found = self.chunks.iter().rposition(|chunk| chunk.header.frames > 0 && chunk.header.first_step <= step);
        let Some(&chunk) = self.chunks.get(found.unwrap_or(0)) else { return Ok(false) };
        self.current = Some(found.unwrap_or(0));
        self.load(&chunk)?;
        scene.begin_anew();
        loop {
            if self.next(scene)?.is_none() {
                return Ok(false);
            }
            let here = scene.frame().step;
            if here >= step || self.step_of_next_frame().is_none_or(|next| next > step) {
                return Ok(here <= step);
            }
        }
    }

    /// Step of the frame after this one, where it is in the same chunk.
    fn step_of_next_frame(&self) -> Option<u64> {
        let mut at = self.next;
        loop {
            let header: LsStreamHeader = bytemuck::pod_read_unaligned(self.content.get(at..at + HEADER)?);
            if header.channel == LS_STREAM_CHANNEL_HOT {
                return Some(header.step);
            }
            at += (header.length as usize).max(HEADER);
        }
    }

    /// The message that comes next; the one after it is next then.
    fn take_message(&mut self) -> Result<Message<'_>> {
        let Self { content, next, .. } = self;
        let rest = &content[*next..];
        let length = match rest.get(..HEADER) {
            Some(head) => bytemuck::pod_read_unaligned::<LsStreamHeader>(head).length as usize,
            None => rest.len(),
        };
        let whole = rest.get(..length.max(HEADER));
        // Without a length, there is no telling where the next message begins: on with the next chunk.
        *next = whole.map_or(content.len(), |message| *next + message.len());
        Message::check(whole.unwrap_or_default())
    }

    /// Unpacks a chunk.
    fn load(&mut self, chunk: &Chunk) -> Result<()> {
        self.next = 0;
        self.content.clear();
        read_stored(&self.file, chunk, &mut self.stored)?;
        let length = chunk.header.length.min(MAX_CHUNK) as usize;
        match chunk.header.storage {
            STORED_PLAIN => self.content.extend_from_slice(&self.stored),
            STORED_LZ4 => {
                self.content.resize(length, 0);
                let unpacked = lz4_flex::block::decompress_into(&self.stored, &mut self.content);
                self.content.truncate(unpacked.unwrap_or(0));
            }
            _ => {}
        }
        if self.content.len() == length {
            return Ok(());
        }
        self.content.clear();
        Err(Problem::Corrupt("a chunk of the recording cannot be unpacked"))
    }
}

fn end_of(chunk: &Chunk) -> u64 {
    chunk.at + CHUNK_HEADER as u64 + chunk.header.stored
}

fn chunk_header(file: &File, at: u64) -> Option<ChunkHeader> {
    let mut bytes = [0; CHUNK_HEADER];
    file.read_exact_at(&mut bytes, at).ok()?;
    ChunkHeader::read(&bytes)
}

fn read_stored(file: &File, chunk: &Chunk, into: &mut Vec<u8>) -> Result<()> {
    into.resize(chunk.header.stored as usize, 0);
    file.read_exact_at(into, chunk.at + CHUNK_HEADER as u64)?;
    if crc32fast::hash(into) == chunk.header.content_checksum {
        Ok(())
    } else {
        Err(Problem::Corrupt("a chunk of the recording is damaged"))
    }
}

/// Where the next chunk begins, from `at` on.
fn next_chunk(file: &File, mut at: u64, length: u64) -> Option<u64> {
    const WINDOW: usize = 1 << 16;
    let mut window = vec![0; WINDOW];
    while at < length {
        let here = WINDOW.min((length - at) as usize);
        file.read_exact_at(&mut window[..here], at).ok()?;
        for offset in 0..here.saturating_sub(CHUNK_START.len() - 1) {
            let found = window[offset..].starts_with(&CHUNK_START) && chunk_header(file, at + offset as u64).is_some();
            if found {
                return Some(at + offset as u64);
            }
        }
        at += (here.saturating_sub(CHUNK_START.len() - 1)).max(1) as u64;
    }
    None
}
