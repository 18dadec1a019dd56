//! The reading side: one interface to what is live and to what is recorded.

use std::path::Path;
use std::time::{Duration, Instant};

use longspan_stream_schema::{LS_STREAM_CHANNEL_COLD, LsStreamHeader};

use crate::arrivals::Arrivals;

use crate::domain::{Domain, Source};
use crate::live::{Channel, Live};
use crate::message::Message;
use crate::problem::{Problem, Result};
use crate::recording::{Playback, Recorder, RecordingInfo};
use crate::scene::Scene;

/// How often a reader that waits looks (s). It costs the publisher nothing, whoever waits; that is why nobody is woken.
const LOOK_EVERY: Duration = Duration::from_micros(200);

/// What a reader found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Poll {
    /// A frame that is newer than the last one: the scene has moved on.
    Frame {
        /// Frames that were published since the last one and were not seen.
        lost_frames: u64,
        /// Messages of the cold channel that were missed: the scene may be out of date until it is complete again.
        lost_records: u64,
        /// The first frame of a publisher that has begun, or begun anew.
        is_first: bool,
    },
    /// Nothing that is new.
    Nothing,
    /// No publisher is there.
    Gone,
    /// The recording is over.
    End,
}

#[derive(Debug)]
enum Input {
    Live(Box<Live>),
    File(Box<Playback>),
}

/// Reads a stream, live or recorded, into a [`Scene`].
#[derive(Debug)]
pub struct Reader {
    input: Input,
    scene: Scene,
    arrivals: Arrivals,
    counts: Counts,
    recorder: Option<Recorder>,
}

/// What was missed since the last frame that was handed out.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    hot_sequence: u64,
    cold_sequence: u64,
    lost_frames: u64,
    lost_records: u64,
    is_first: bool,
}

impl Reader {
    /// A reader of the stream of this name, or of any if the name is empty. It need not be there yet.
    ///
    /// # Errors
    /// Shared memory cannot be used.
    pub fn attach(domain: &Domain, name: &str) -> Result<Self> {
        if !name.is_empty() {
            crate::domain::check_name("name", name)?;
        }
        Ok(Self::new(Input::Live(Box::new(Live::new(domain, name)?))))
    }

    /// A reader of a recording, before its first frame.
    ///
    /// # Errors
    /// The file cannot be read, or is no recording, or one of another version.
    pub fn open(file: &Path) -> Result<Self> {
        Ok(Self::new(Input::File(Box::new(Playback::open(file)?))))
    }

    fn new(input: Input) -> Self {
        Self { input, scene: Scene::default(), arrivals: Arrivals::default(), counts: Counts::default(), recorder: None }
    }

    /// What is known of the world.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Empties the lists of events, breaks and pieces.
    pub fn forget_events(&mut self) {
        self.scene.forget_events();
    }

    /// Where a live stream comes from, while one is there.
    pub fn source(&self) -> Option<&Source> {
        match &self.input {
            Input::Live(live) => live.source(),
            Input::File(_) => None,
        }
    }

    /// What is known of a recording as a whole.
    pub fn recording(&self) -> Option<&RecordingInfo> {
        match &self.input {
            Input::Live(_) => None,
            Input::File(playback) => Some(playback.info()),
        }
    }

    /// The newest frame: all that have come are taken in, and the last one counts. Of a recording, the next frame.
    ///
    /// # Errors
    /// `Incompatible`: a stream of another version. `Corrupt`: a message made no sense and was left out; the next call goes on.
    pub fn poll(&mut self) -> Result<Poll> {
        self.advance(false)
    }

    /// The next frame, for who wants each of them.
    ///
    /// # Errors
    /// As [`poll`](Self::poll).
    pub fn poll_next(&mut self) -> Result<Poll> {
        self.advance(true)
    }

    /// As [`poll`](Self::poll), but waits for a frame for so long. A recording does not keep one waiting.
    ///
    /// # Errors
    /// As [`poll`](Self::poll).
    pub fn wait(&mut self, timeout: Duration) -> Result<Poll> {
        let deadline = Instant::now() + timeout;
        loop {
            let found = self.poll()?;
            let over = matches!(found, Poll::Frame { .. } | Poll::End) || Instant::now() >= deadline;
            if over {
                return Ok(found);
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Goes to the frame of this step of a recording, or the last one before it.
    ///
    /// # Errors
    /// `Argument` for a live stream; else as [`poll`](Self::poll).
    pub fn seek(&mut self, step: u64) -> Result<Poll> {
        match &mut self.input {
            Input::Live(_) => Err(Problem::Argument("reader", "reads a live stream, where nothing can be sought")),
            Input::File(playback) => {
                let found = playback.seek(step, &mut self.scene)?;
                Ok(if found { Poll::Frame { lost_frames: 0, lost_records: 0, is_first: false } } else { Poll::End })
            }
        }
    }

    /// Writes all that comes from now on to a file, beginning with what is known; `None` ends that.
    ///
    /// # Errors
    /// The file cannot be written. Later failures end the recording, and [`recorded`](Self::recorded) says so.
    pub fn record(&mut self, file: Option<&Path>) -> Result<()> {
        if let Some(recorder) = self.recorder.take() {
            recorder.finish()?;
        }
        if let Some(file) = file {
            self.recorder = Some(Recorder::create(file)?);
        }
        Ok(())
    }

    /// Bytes written so far to the file that is being recorded; `None` if none is.
    pub fn recorded(&self) -> Option<u64> {
        self.recorder.as_ref().map(Recorder::written)
    }

    fn advance(&mut self, one_by_one: bool) -> Result<Poll> {
        let live = match &mut self.input {
            Input::Live(live) => live,
            Input::File(playback) => {
                let lost = playback.next(&mut self.scene)?;
                return Ok(lost.map_or(Poll::End, |lost_records| Poll::Frame { lost_frames: 0, lost_records, is_first: false }));
            }
        };
        if live.attach()? {
            self.counts = Counts { is_first: true, ..Counts::default() };
            self.arrivals.clear();
        }
        if live.source().is_none() {
            return Ok(Poll::Gone);
        }
        let mut found = false;
        while !(found && one_by_one) && self.take_frame()? {
            found = true;
        }
        if found {
            let Counts { lost_frames, lost_records, is_first, .. } = self.counts;
            self.counts = Counts { lost_frames: 0, lost_records: 0, is_first: false, ..self.counts };
            return Ok(Poll::Frame { lost_frames, lost_records, is_first });
        }
        let Input::Live(live) = &mut self.input else { return Ok(Poll::Nothing) };
        Ok(if live.detach_if_gone() { Poll::Gone } else { Poll::Nothing })
    }

    /// Takes in the next frame and, before it, what had been told until its step; false if there is none.
    fn take_frame(&mut self) -> Result<bool> {
        let Input::Live(live) = &mut self.input else { return Ok(false) };
        let step = self.arrivals.next_frame(live)?;
        while let Some(message) = self.arrivals.record_until(step) {
            let taken = self.take(&message, Channel::Cold);
            self.arrivals.give_back(message);
            taken?;
        }
        let Some(frame) = self.arrivals.frame() else { return Ok(false) };
        let taken = self.take(&frame, Channel::Hot);
        self.arrivals.give_back(frame);
        taken.map(|()| true)
    }

    /// Takes in a message.
    fn take(&mut self, bytes: &[u8], channel: Channel) -> Result<()> {
        let message = Message::check(bytes)?;
        let LsStreamHeader { sequence, channel: said, session, .. } = message.header;
        if (said == LS_STREAM_CHANNEL_COLD) != (channel == Channel::Cold) {
            return Err(Problem::Corrupt("a message came by the wrong channel"));
        }
        if self.scene.session() != session {
            self.counts = Counts { is_first: true, ..Counts::default() };
        }
        self.counts.note(channel, sequence);
        if let Some(recorder) = &mut self.recorder {
            recorder.prepare(&self.scene);
        }
        self.scene.apply(&message)?;
        if let Some(Err(problem)) = self.recorder.as_mut().map(|recorder| recorder.write(&message)) {
            self.recorder = None;
            return Err(problem);
        }
        Ok(())
    }
}

impl Counts {
    /// The first message of a channel that a reader sees may have any number: it has missed nothing that it was there for.
    fn note(&mut self, channel: Channel, sequence: u64) {
        let (last, lost) = match channel {
            Channel::Hot => (&mut self.hot_sequence, &mut self.lost_frames),
            Channel::Cold => (&mut self.cold_sequence, &mut self.lost_records),
        };
        if *last != 0 {
            *lost = lost.saturating_add(sequence.saturating_sub(last.saturating_add(1)));
        }
        *last = sequence;
    }
}
