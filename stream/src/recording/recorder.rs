//! Writing a recording.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use longspan_stream_schema::LS_STREAM_CHANNEL_HOT;

use super::format::{ChunkHeader, FileHeader, STORED_LZ4, STORED_PLAIN};
use crate::message::Message;
use crate::problem::Result;
use crate::scene::Scene;

/// Frames of a chunk at most: what is lost if the recording process dies, and what a player goes through to seek.
const CHUNK_FRAMES: u32 = 120;

/// Bytes after which a chunk ends at the next frame, if that is more than twice its first messages: so that those stay a small
/// part of a file.
const CHUNK_BYTES: usize = 1 << 20;

/// Writes the messages of a stream to a file.
#[derive(Debug)]
pub struct Recorder {
    file: File,
    chunk: Vec<u8>,
    packed: Vec<u8>,
    keyframe: usize,
    steps: Option<(u64, u64)>,
    frames: u32,
    all_frames: u64,
    written: u64,
}

impl Recorder {
    /// Begins a file; one of this name is replaced.
    ///
    /// # Errors
    /// What the file system says.
    pub fn create(file: &Path) -> Result<Self> {
        let mut file = File::create(file)?;
        let head = FileHeader::new();
        file.write_all(bytemuck::bytes_of(&head))?;
        Ok(Self {
            file,
            chunk: Vec::new(),
            packed: Vec::new(),
            keyframe: 0,
            steps: None,
            frames: 0,
            all_frames: 0,
            written: size_of_val(&head) as u64,
        })
    }

    /// To be called before `scene` takes in a message that is to be written: where a chunk begins, the scene is written first.
    pub fn prepare(&mut self, scene: &Scene) {
        if self.chunk.is_empty() {
            scene.write_keyframe(&mut self.chunk);
            self.keyframe = self.chunk.len();
        }
    }

    /// Adds a message.
    ///
    /// # Errors
    /// What the file system says; the file then ends with the last whole chunk.
    pub fn write(&mut self, message: &Message<'_>) -> Result<()> {
        self.chunk.extend_from_slice(message.bytes());
        if message.header.channel == LS_STREAM_CHANNEL_HOT {
            let step = message.header.step;
            self.steps = Some((self.steps.map_or(step, |(first, _)| first), step));
            self.frames += 1;
            self.all_frames += 1;
            if self.frames >= CHUNK_FRAMES || self.chunk.len() > CHUNK_BYTES.max(3 * self.keyframe) {
                self.end_chunk()?;
            }
        }
        Ok(())
    }

    /// Bytes in the file so far.
    pub fn written(&self) -> u64 {
        self.written
    }

    fn end_chunk(&mut self) -> Result<()> {
        if self.chunk.is_empty() {
            return Ok(());
        }
        self.packed.resize(lz4_flex::block::get_maximum_output_size(self.chunk.len()), 0);
        let packed = lz4_flex::block::compress_into(&self.chunk, &mut self.packed).unwrap_or(usize::MAX);
        let (content, storage) =
            if packed < self.chunk.len() { (&self.packed[..packed], STORED_LZ4) } else { (&self.chunk[..], STORED_PLAIN) };
        let header = ChunkHeader::new(content, |header| {
            header.length = self.chunk.len() as u64;
            header.keyframe = self.keyframe as u64;
            (header.first_step, header.last_step) = self.steps.unwrap_or_default();
            (header.frames, header.storage) = (self.frames, storage);
        });
        self.file.write_all(bytemuck::bytes_of(&header))?;
        self.file.write_all(content)?;
        self.written += (size_of_val(&header) + content.len()) as u64;
        self.chunk.clear();
        (self.steps, self.frames) = (None, 0);
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// What the file system says.
    pub fn finish(mut self) -> Result<()> {
        self.end_chunk()?;
        let frames = u32::try_from(self.all_frames).unwrap_or(u32::MAX);
        let closing = ChunkHeader::new(&[], |header| header.frames = frames);
        self.file.write_all(bytemuck::bytes_of(&closing))?;
        Ok(())
    }
}
