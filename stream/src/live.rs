//! A stream that is published now, as seen from a reader.

use std::time::{Duration, Instant};

use iceoryx2::config::Config;

use crate::channel::{Inlet, Received};
use crate::domain::{Domain, Membership, Source};
use crate::foreign::OwnMemory;
use crate::problem::{Problem, Result};
use longspan_stream_schema::LS_STREAM_SCHEMA;

/// How often a reader looks for a stream that is not there, or asks whether a silent one lives (s).
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Both channels of one publisher.
#[derive(Debug)]
pub(crate) struct Attached {
    pub source: Source,
    hot: Inlet,
    cold: Inlet,
}

/// Finds a publisher, and finds another one when that has gone.
#[derive(Debug)]
pub(crate) struct Live {
    domain: Domain,
    /// Only a stream of this name; any if empty.
    name: String,
    config: Config,
    /// Cleared when nobody is there, so that a reader that waits holds nothing.
    membership: Option<Membership>,
    attached: Option<Attached>,
    memory: OwnMemory,
    looked: Option<Instant>,
}

/// Which channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Channel {
    Hot,
    Cold,
}

impl Live {
    pub(crate) fn new(domain: &Domain, name: &str) -> Result<Self> {
        Ok(Self {
            domain: domain.clone(),
            name: name.to_owned(),
            config: domain.config()?,
            membership: None,
            attached: None,
            memory: OwnMemory::open()?,
            looked: None,
        })
    }

    pub(crate) fn source(&self) -> Option<&Source> {
        self.attached.as_ref().map(|attached| &attached.source)
    }

    /// Looks for a publisher, unless that was done a moment ago; true if one is there now that was not.
    pub(crate) fn attach(&mut self) -> Result<bool> {
        if self.attached.is_some() || !self.is_time() {
            return Ok(false);
        }
        let sources = self.domain.sources()?;
        let mut wrong_schema = None;
        // The one that began last, if there are several.
        for source in sources.into_iter().filter(|source| self.name.is_empty() || source.name == self.name).rev() {
            if source.schema != LS_STREAM_SCHEMA {
                wrong_schema = Some(source.schema);
                continue;
            }
            let membership = match self.membership.take() {
                Some(membership) => membership,
                None => self.domain.join(&self.config)?,
            };
            let node = &self.membership.insert(membership).node;
            let (Some(hot), Some(cold)) = (Inlet::open(node, &source, "hot")?, Inlet::open(node, &source, "cold")?) else {
                continue;
            };
            if hot.has_publisher(&self.config, &source) {
                self.attached = Some(Attached { source, hot, cold });
                return Ok(true);
            }
        }
        self.clean();
        match wrong_schema {
            Some(found) => Err(Problem::Incompatible(format!(
                "a stream of this name has schema {found}, this library reads {LS_STREAM_SCHEMA}"
            ))),
            None => Ok(false),
        }
    }

    /// Copies the next message of a channel; false if there is none.
    pub(crate) fn receive(&mut self, channel: Channel, into: &mut Vec<u8>) -> Result<bool> {
        let Some(attached) = &self.attached else { return Ok(false) };
        let inlet = if channel == Channel::Hot { &attached.hot } else { &attached.cold };
        Ok(matches!(inlet.receive(&self.memory, into)?, Received::Message))
    }

    /// Lets go of a publisher that has gone, and clears up after it; true if that was so. To be asked when nothing comes.
    pub(crate) fn detach_if_gone(&mut self) -> bool {
        let Some(attached) = &self.attached else { return false };
        if self.looked.is_some_and(|looked| looked.elapsed() < LOOK_EVERY) {
            return false;
        }
        self.looked = Some(Instant::now());
        if attached.hot.has_publisher(&self.config, &attached.source) {
            return false;
        }
        self.attached = None;
        self.clean();
        true
    }

    /// Removes what dead processes left.
    fn clean(&mut self) {
        if let Some(membership) = self.membership.take() {
            membership.node.try_cleanup_dead_nodes();
        }
        self.domain.clear();
    }

    fn is_time(&mut self) -> bool {
        let due = self.looked.is_none_or(|looked| looked.elapsed() >= LOOK_EVERY);
        if due {
            self.looked = Some(Instant::now());
        }
        due
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.attached = None;
        self.membership = None;
        self.domain.clear();
    }
}
