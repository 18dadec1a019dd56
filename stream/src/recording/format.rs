//! The bytes around messages in a file.

use bytemuck::{Pod, Zeroable};
use longspan_stream_schema::{LAYOUT_HASH, LS_STREAM_SCHEMA};

use crate::problem::{Problem, Result};

/// "LSRECORD".
const FILE_MAGIC: u64 = 0x4452_4F43_4552_534C;
/// "LSCHUNK\n".
const CHUNK_MAGIC: u64 = 0x0A4B_4E55_4843_534C;

/// Version of the bytes around messages.
const VERSION: u32 = 1;

/// Bytes of messages in a chunk at most, once it is unpacked; a message more than that would not be taken either.
pub(super) const MAX_CHUNK: u64 = 1 << 30;

pub(super) const STORED_PLAIN: u32 = 0;
pub(super) const STORED_LZ4: u32 = 1;

/// What a file begins with.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FileHeader {
    magic: u64,
    version: u32,
    schema: u32,
    layout_hash: u64,
    reserved: [u64; 4],
    unused: u32,
    checksum: u32,
}

/// What a chunk begins with. The closing chunk has no content, and `frames` of the whole file.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ChunkHeader {
    magic: u64,
    /// Bytes that follow.
    pub stored: u64,
    /// Bytes of the messages.
    pub length: u64,
    /// Of those, the ones that make a scene what it was at the beginning of the chunk.
    pub keyframe: u64,
    pub first_step: u64,
    pub last_step: u64,
    pub frames: u32,
    /// `STORED_…`.
    pub storage: u32,
    /// CRC-32 of what follows.
    pub content_checksum: u32,
    /// CRC-32 of this header up to here.
    checksum: u32,
}

pub(super) const FILE_HEADER: usize = size_of::<FileHeader>();
pub(super) const CHUNK_HEADER: usize = size_of::<ChunkHeader>();

fn checksum_of<T: Pod>(header: &T) -> u32 {
    let bytes = bytemuck::bytes_of(header);
    crc32fast::hash(&bytes[..bytes.len() - size_of::<u32>()])
}

impl FileHeader {
    pub(super) fn new() -> Self {
        let header =
            Self { magic: FILE_MAGIC, version: VERSION, schema: LS_STREAM_SCHEMA, layout_hash: LAYOUT_HASH, ..Self::zeroed() };
        Self { checksum: checksum_of(&header), ..header }
    }

    pub(super) fn check(bytes: &[u8; FILE_HEADER]) -> Result<()> {
        let header: Self = bytemuck::pod_read_unaligned(bytes);
        if header.magic != FILE_MAGIC {
            return Err(Problem::Incompatible("the file is no recording of a stream".into()));
        }
        if header.checksum != checksum_of(&header) {
            return Err(Problem::Corrupt("the head of the recording is damaged"));
        }
        if (header.version, header.schema) != (VERSION, LS_STREAM_SCHEMA) {
            let (version, schema) = (header.version, header.schema);
            let found = format!("the recording has version {version} and schema {schema}");
            return Err(Problem::Incompatible(format!("{found}, this library reads {VERSION} and {LS_STREAM_SCHEMA}")));
        }
        if header.layout_hash != LAYOUT_HASH {
            return Err(Problem::Incompatible("the recording has other records: a development build wrote it".into()));
        }
        Ok(())
    }
}

impl ChunkHeader {
    /// A header with this content; what the others say is filled in by `fill`.
    pub(super) fn new(content: &[u8], fill: impl FnOnce(&mut Self)) -> Self {
        let mut header = Self { magic: CHUNK_MAGIC, ..Self::zeroed() };
        header.stored = content.len() as u64;
        header.content_checksum = crc32fast::hash(content);
        fill(&mut header);
        header.checksum = checksum_of(&header);
        header
    }

    /// The header in these bytes, if they are one.
    pub(super) fn read(bytes: &[u8; CHUNK_HEADER]) -> Option<Self> {
        let header: Self = bytemuck::pod_read_unaligned(bytes);
        let sane = header.stored <= MAX_CHUNK && header.length <= MAX_CHUNK && header.keyframe <= header.length;
        (header.magic == CHUNK_MAGIC && header.checksum == checksum_of(&header) && sane).then_some(header)
    }

    pub(super) fn is_closing(&self) -> bool {
        self.length == 0
    }
}

/// First bytes of a chunk, for who has lost the way.
pub(super) const CHUNK_START: [u8; 8] = CHUNK_MAGIC.to_le_bytes();
