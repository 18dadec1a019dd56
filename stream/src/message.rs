//! Messages: how they are put together, and how one that comes from anywhere is taken apart.

use std::time::{SystemTime, UNIX_EPOCH};

use bytemuck::Zeroable;
use longspan_stream_schema::{
    ContentHash, LAYOUT_HASH, LS_STREAM_CHANNEL_COLD, LS_STREAM_CHANNEL_HOT, LS_STREAM_MAGIC, LS_STREAM_SCHEMA, LsStreamHeader,
    LsStreamSection, Wire,
};

use crate::problem::{Problem, Result};

pub(crate) const HEADER: usize = size_of::<LsStreamHeader>();
pub(crate) const SECTION: usize = size_of::<LsStreamSection>();

/// Longest message that a reader takes (bytes); more than a million bodies that all move.
pub(crate) const MAX_MESSAGE: usize = 1 << 28;

/// The system's clock (ns since 1970 began).
pub(crate) fn clock() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64)
}

/// A header with all that does not depend on the content.
pub(crate) fn header(channel: u32, session: u64) -> LsStreamHeader {
    LsStreamHeader {
        magic: LS_STREAM_MAGIC,
        schema: LS_STREAM_SCHEMA,
        header_size: HEADER as u32,
        layout_hash: LAYOUT_HASH,
        session,
        channel,
        ..LsStreamHeader::zeroed()
    }
}

/// Sections being put together in a buffer.
#[derive(Debug, Default)]
pub(crate) struct Sections {
    pub bytes: Vec<u8>,
    pub count: u32,
    /// Where the section under way begins, its kind and its stride.
    open: Option<(usize, u32, u32)>,
    records: u32,
}

impl Sections {
    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        (self.count, self.open, self.records) = (0, None, 0);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Bytes that adding `len` bytes of a record will take at most.
    pub(crate) fn len_with(&self, len: usize) -> usize {
        self.bytes.len() + SECTION + len + 16
    }

    /// Adds a record, to the section under way if that is of its kind.
    pub(crate) fn push<T: Wire>(&mut self, record: &T) {
        self.push_bytes(T::SECTION, bytemuck::bytes_of(record));
    }

    /// As [`push`](Self::push), for a record whose section its type does not tell.
    pub(crate) fn push_bytes(&mut self, kind: u32, record: &[u8]) {
        let stride = record.len() as u32;
        if self.open.is_none_or(|(_, open, width)| (open, width) != (kind, stride)) {
            self.close();
            self.open = Some((self.bytes.len(), kind, stride));
            self.bytes.extend_from_slice(&[0; SECTION]);
        }
        self.bytes.extend_from_slice(record);
        self.records += 1;
    }

    /// Begins a section of one record whose bytes follow one by one.
    pub(crate) fn begin_bytes(&mut self, kind: u32) {
        self.close();
        self.open = Some((self.bytes.len(), kind, 0));
        self.bytes.extend_from_slice(&[0; SECTION]);
        self.records = 1;
    }

    /// Adds bytes to a section of one record.
    pub(crate) fn add_bytes(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Ends the section under way.
    pub(crate) fn close(&mut self) {
        let Some((start, kind, stride)) = self.open.take() else { return };
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        let length = (self.bytes.len() - start - SECTION) as u64;
        let section = LsStreamSection { kind, stride, count: self.records, length, ..LsStreamSection::zeroed() };
        self.bytes[start..start + SECTION].copy_from_slice(bytemuck::bytes_of(&section));
        self.count += 1;
        self.records = 0;
    }

    /// Fills in what depends on the content, and returns it after the header.
    pub(crate) fn finish(&mut self, header: &mut LsStreamHeader) -> &[u8] {
        self.close();
        let mut hash = ContentHash::default();
        hash.add(&self.bytes);
        header.section_count = self.count;
        header.length = (HEADER + self.bytes.len()) as u64;
        header.content_hash = hash.finish();
        &self.bytes
    }
}

/// One message, checked: sections lie inside it, and its content is what its publisher hashed. Numbers in records are not checked
/// yet; that is done where they are used.
#[derive(Debug, Clone, Copy)]
pub struct Message<'a> {
    /// What it begins with.
    pub header: LsStreamHeader,
    content: &'a [u8],
    bytes: &'a [u8],
}

/// Checks all of a header that can be checked without the content.
pub(crate) fn check_header(header: &LsStreamHeader) -> Result<()> {
    if header.magic != LS_STREAM_MAGIC {
        return Err(Problem::Corrupt("a message does not begin as one"));
    }
    if header.schema != LS_STREAM_SCHEMA {
        let found = header.schema;
        return Err(Problem::Incompatible(format!("the stream has schema {found}, this library reads {LS_STREAM_SCHEMA}")));
    }
    if header.layout_hash != LAYOUT_HASH {
        return Err(Problem::Incompatible("same number of schema, but other records: one side is a development build".into()));
    }
    let fits = (HEADER as u64..=MAX_MESSAGE as u64).contains(&header.length) && header.length.is_multiple_of(8);
    if header.header_size as usize != HEADER || !fits {
        return Err(Problem::Corrupt("a message has a length that none can have"));
    }
    if ![LS_STREAM_CHANNEL_HOT, LS_STREAM_CHANNEL_COLD].contains(&header.channel) {
        return Err(Problem::Corrupt("a message is of no channel"));
    }
    if !header.time.is_finite() {
        return Err(Problem::Corrupt("a message is of no time"));
    }
    Ok(())
}

impl<'a> Message<'a> {
    /// Checks bytes that may come from anywhere.
    ///
    /// # Errors
    /// `Incompatible` where another version wrote them, `Corrupt` for everything else that is wrong.
    pub fn check(bytes: &'a [u8]) -> Result<Self> {
        let Some((head, content)) = bytes.split_at_checked(HEADER) else {
            return Err(Problem::Corrupt("a message is shorter than its header"));
        };
        let header: LsStreamHeader = bytemuck::pod_read_unaligned(head);
        check_header(&header)?;
        if header.length != bytes.len() as u64 {
            return Err(Problem::Corrupt("a message is not as long as it says"));
        }
        let mut hash = ContentHash::default();
        hash.add(content);
        if hash.finish() != header.content_hash {
            return Err(Problem::Corrupt("a message was changed after it was written"));
        }
        let message = Self { header, content, bytes };
        let mut rest = content;
        for _ in 0..header.section_count {
            rest = Section::split(rest)?.1;
        }
        if rest.is_empty() { Ok(message) } else { Err(Problem::Corrupt("bytes after the last section")) }
    }

    /// All its bytes, as in shared memory and in a recording.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Its sections, in order.
    pub fn sections(&self) -> impl Iterator<Item = Section<'a>> + use<'a> {
        let mut rest = self.content;
        std::iter::from_fn(move || {
            let (section, after) = Section::split(rest).ok()?;
            rest = after;
            Some(section)
        })
    }
}

/// A section of a message that was checked.
#[derive(Debug, Clone, Copy)]
pub struct Section<'a> {
    /// `LS_STREAM_SECTION_` constant, or a kind that came later.
    pub kind: u32,
    stride: usize,
    count: usize,
    bytes: &'a [u8],
}

impl<'a> Section<'a> {
    fn split(bytes: &'a [u8]) -> Result<(Self, &'a [u8])> {
        let Some((head, rest)) = bytes.split_at_checked(SECTION) else {
            return Err(Problem::Corrupt("a message ends inside a section's head"));
        };
        let LsStreamSection { kind, stride, count, length, .. } = bytemuck::pod_read_unaligned(head);
        let inside = length <= rest.len() as u64 && length.is_multiple_of(8);
        let filled = u64::from(stride).checked_mul(count.into()).is_some_and(|used| used <= length);
        if !(inside && filled) {
            return Err(Problem::Corrupt("a section reaches past the end of its message"));
        }
        let (bytes, after) = rest.split_at(length as usize);
        Ok((Self { kind, stride: stride as usize, count: count as usize, bytes }, after))
    }

    /// Its records, if they are of this type; a record that is shorter than what is known of it ends with zeroes.
    ///
    /// # Errors
    /// `Corrupt` at the first record that holds NaN or an infinity.
    pub fn records<T: Wire>(&self) -> impl Iterator<Item = Result<T>> + use<'a, T> {
        self.plain::<T>(T::SECTION).map(|record| {
            if record.is_finite() { Ok(record) } else { Err(Problem::Corrupt("a record holds NaN or an infinity")) }
        })
    }

    /// Records of a type without numbers to check, if the section is of this kind.
    pub(crate) fn plain<T: bytemuck::Pod>(&self, kind: u32) -> impl Iterator<Item = T> + use<'a, T> {
        let count = if self.kind == kind && self.stride > 0 { self.count } else { 0 };
        let (bytes, stride) = (self.bytes, self.stride);
        (0..count).map(move |index| {
            let stored = &bytes[index * stride..(index + 1) * stride];
            let mut record = T::zeroed();
            let known = stride.min(size_of::<T>());
            bytemuck::bytes_of_mut(&mut record)[..known].copy_from_slice(&stored[..known]);
            record
        })
    }

    /// All its bytes, padding included.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use longspan_stream_schema::{LsStreamEvent, LsStreamMotion};

    fn sample() -> Vec<u8> {
        let mut sections = Sections::default();
        sections.push(&LsStreamMotion { body: 7, ..LsStreamMotion::zeroed() });
        sections.push(&LsStreamMotion { body: 8, ..LsStreamMotion::zeroed() });
        sections.push_bytes(4711, &[1; 13]);
        sections.push(&LsStreamEvent { a: 9, ..LsStreamEvent::zeroed() });
        let mut header = header(LS_STREAM_CHANNEL_HOT, 1);
        let content = sections.finish(&mut header).to_vec();
        [bytemuck::bytes_of(&header), &content].concat()
    }

    #[test]
    fn what_goes_in_comes_out_and_unknown_sections_are_skipped() {
        let bytes = sample();
        let message = Message::check(&bytes).unwrap();
        let bodies: Vec<u64> =
            message.sections().flat_map(|section| section.records::<LsStreamMotion>()).map(|m| m.unwrap().body).collect();
        let events: Vec<u64> =
            message.sections().flat_map(|section| section.records::<LsStreamEvent>()).map(|event| event.unwrap().a).collect();
        assert_eq!((bodies, events, message.sections().count()), (vec![7, 8], vec![9], 3));
    }

    #[test]
    fn every_changed_bit_and_every_cut_is_noticed() {
        let bytes = sample();
        for bit in 0..8 * bytes.len() {
            let mut changed = bytes.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            // What a header says of the world is the publisher's to say.
            let told = LsStreamHeader::zeroed();
            let base = std::ptr::from_ref(&told) as usize;
            let claims = [
                &raw const told.session as usize..&raw const told.state_hash as usize + 8,
                &raw const told.dropped as usize..&raw const told.channel as usize,
                &raw const told.body_count as usize..HEADER + base,
            ];
            if claims.iter().any(|claim| claim.contains(&(base + bit / 8))) {
                continue;
            }
            assert!(Message::check(&changed).is_err(), "bit {} of byte {}", bit % 8, bit / 8);
        }
        for cut in 0..bytes.len() {
            assert!(Message::check(&bytes[..cut]).is_err(), "cut after {cut} bytes");
        }
    }

    #[test]
    fn records_of_another_length_are_read_as_far_as_they_are_known() {
        let mut sections = Sections::default();
        let mut longer = bytemuck::bytes_of(&LsStreamMotion { body: 5, flags: 3, ..LsStreamMotion::zeroed() }).to_vec();
        longer.extend([9; 8]);
        sections.push_bytes(LsStreamMotion::SECTION, &longer);
        sections.push_bytes(LsStreamMotion::SECTION, &longer[..8]);
        let mut header = header(LS_STREAM_CHANNEL_HOT, 1);
        let content = sections.finish(&mut header).to_vec();
        let bytes = [bytemuck::bytes_of(&header), &content].concat();
        let message = Message::check(&bytes).unwrap();
        let read: Vec<LsStreamMotion> = message.sections().flat_map(|s| s.records()).map(|r| r.unwrap()).collect();
        assert_eq!(read.iter().map(|m| (m.body, m.flags)).collect::<Vec<_>>(), [(5, 3), (5, 0)]);
    }

    #[test]
    fn other_versions_are_told_apart_from_damage() {
        let mut bytes = sample();
        bytes[8] = 2;
        assert!(matches!(Message::check(&bytes), Err(Problem::Incompatible(_))));
    }
}
