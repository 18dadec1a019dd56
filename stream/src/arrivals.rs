//! What has come over a live stream's two channels, in the order in which it is to be taken in.
//!
//! A publisher tells what a step changed on the cold channel before it sends the step's frame on the hot one. A reader that looks in
//! between, or that is some frames behind, finds records of later steps than the frame that it comes to next. They wait here until
//! their own frame is there: so a frame shows the same to every reader that knows the whole scene, whenever it looks, and the same
//! when it is played from a recording.

use std::collections::VecDeque;

use longspan_stream_schema::LsStreamHeader;

use crate::live::{Channel, Live};
use crate::message::HEADER;
use crate::problem::Result;

/// Messages that wait for their frame at most; more would be those of a publisher that frames never come from.
const MAX_WAITING: usize = 1024;

/// Messages on their way into a scene.
#[derive(Debug, Default)]
pub(crate) struct Arrivals {
    /// Of the cold channel, as they came.
    records: VecDeque<Vec<u8>>,
    /// The next frame, until what was told before it has been taken in.
    frame: Option<Vec<u8>>,
    /// Buffers to be used again.
    spare: Vec<Vec<u8>>,
}

fn step_of(message: &[u8]) -> u64 {
    message.get(..HEADER).map_or(0, |head| bytemuck::pod_read_unaligned::<LsStreamHeader>(head).step)
}

impl Arrivals {
    /// Forgets what has come: it was another publisher's.
    pub(crate) fn clear(&mut self) {
        self.records.clear();
        self.frame = None;
    }

    /// Fetches all records that are there, and the next frame unless one waits; its step, if there is one.
    ///
    /// # Errors
    /// A message made no sense and was left out.
    pub(crate) fn next_frame(&mut self, live: &mut Live) -> Result<Option<u64>> {
        if self.frame.is_none() {
            self.frame = self.fetch(live, Channel::Hot)?;
        }
        // After the frame: what was told before it is there by now.
        while let Some(message) = self.fetch(live, Channel::Cold)? {
            self.records.push_back(message);
        }
        Ok(self.frame.as_deref().map(step_of))
    }

    fn fetch(&mut self, live: &mut Live, channel: Channel) -> Result<Option<Vec<u8>>> {
        let mut buffer = self.spare.pop().unwrap_or_default();
        match live.receive(channel, &mut buffer) {
            Ok(true) => Ok(Some(buffer)),
            none => {
                self.spare.push(buffer);
                none.map(|_| None)
            }
        }
    }

    /// The next record, if it was told at `step` or before, or if too many wait.
    pub(crate) fn record_until(&mut self, step: Option<u64>) -> Option<Vec<u8>> {
        let is_due = |message: &Vec<u8>| step.is_some_and(|step| step_of(message) <= step);
        let due = self.records.len() > MAX_WAITING || self.records.front().is_some_and(is_due);
        if due { self.records.pop_front() } else { None }
    }

    /// The frame that waited for the records before it.
    pub(crate) fn frame(&mut self) -> Option<Vec<u8>> {
        self.frame.take()
    }

    /// Takes a message back that is part of the scene now.
    pub(crate) fn give_back(&mut self, message: Vec<u8>) {
        self.spare.push(message);
    }
}
