//! The two channels of a stream, as services of iceoryx2.
//!
//! What is set, and why: a publisher throws away rather than waits (`DiscardData`, safe overflow: the oldest unread message goes);
//! iceoryx2 installs no handlers of signals, prints nothing and reads no configuration file of its own; all files are in a folder
//! of the user's own ([`crate::domain`]). Ports are those that may be handed from thread to thread, since a world may be.
//!
//! A message's header travels as iceoryx2's user header, its sections as the payload; the two lie side by side.
#![allow(unsafe_code)]

use iceoryx2::config::Config;
use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::publisher::Publisher as Port;
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, CallbackProgression, NodeName, NodeState, PortFactory, SignalHandlingMode,
    ZeroCopySend, ipc_threadsafe,
};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as ChannelService;
use longspan_stream_schema::{LsStreamHeader, LsStreamSection};

use crate::domain::Source;
use crate::foreign::OwnMemory;
use crate::message::{HEADER, MAX_MESSAGE, check_header};
use crate::problem::{Problem, Result};

pub(crate) type Carrier = ipc_threadsafe::Service;

/// [`LsStreamHeader`] as iceoryx2 knows it.
#[derive(Debug, Clone, Copy, Default)]
#[repr(transparent)]
struct CarriedHeader(LsStreamHeader);

// SAFETY: plain numbers without pointers, in the layout of C.
unsafe impl ZeroCopySend for CarriedHeader {
    unsafe fn type_name() -> &'static str {
        "LsStreamHeader1"
    }
}

/// Messages are whole words, so that records begin at multiples of eight. Bytes that are to be aligned so would do, but for
/// iceoryx2's tunnel: it carries no type whose size is not a multiple of its alignment.
type Word = u64;
const WORD: usize = size_of::<Word>();

type Service = ChannelService<Carrier, [Word], CarriedHeader>;

/// Room of a channel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Room {
    pub name: &'static str,
    /// Messages that wait for a reader until the oldest is thrown away.
    pub buffer: usize,
    /// Messages that a reader gets which joins late.
    pub history: usize,
    /// Bytes of a message, at first or at most.
    pub bytes: usize,
    /// Whether more bytes are found when needed. For that, iceoryx2 keeps books of 256 pieces of memory with each reader, which the
    /// publisher clears when one joins: 0.6 MB for a history of 256 messages.
    pub grows: bool,
}

/// The host of the stream, and a tunnel that carries it to or from another machine: it wants to write on what it carries.
const PUBLISHERS: usize = 2;

/// What a process is to iceoryx2.
pub(crate) fn node(config: &Config) -> Result<Node<Carrier>> {
    let name = NodeName::new("longspan").map_err(system("node"))?;
    let builder = NodeBuilder::new().name(&name).config(config).signal_handling_mode(SignalHandlingMode::Disabled);
    builder.create::<Carrier>().map_err(system("shared memory cannot be used"))
}

fn system<E: std::fmt::Debug>(what: &'static str) -> impl Fn(E) -> Problem {
    move |error| Problem::System(format!("{what}: {error:?}"))
}

/// The publishing end of a channel.
#[derive(Debug)]
pub(crate) struct Outlet {
    port: Port<Carrier, [Word], CarriedHeader>,
    _service: Service,
}

impl Outlet {
    pub(crate) fn open(node: &Node<Carrier>, source: &Source, room: Room, readers: usize) -> Result<Self> {
        let service = node
            .service_builder(&source.service(room.name)?)
            .publish_subscribe::<[Word]>()
            .user_header::<CarriedHeader>()
            .enable_safe_overflow(true)
            .max_publishers(PUBLISHERS)
            .max_subscribers(readers)
            // A reader that died holds its place until the next one starts and clears up.
            .max_nodes(2 * readers + 2 * PUBLISHERS)
            .subscriber_max_buffer_size(room.buffer)
            .subscriber_max_borrowed_samples(1)
            .history_size(room.history)
            .create()
            .map_err(system("a channel cannot be made"))?;
        let port = service
            .publisher_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .max_loaned_samples(1)
            .initial_max_slice_len(room.bytes / WORD)
            .allocation_strategy(if room.grows { AllocationStrategy::PowerOfTwo } else { AllocationStrategy::Static })
            .create()
            .map_err(system("a channel cannot be written"))?;
        Ok(Self { port, _service: service })
    }

    /// Lets readers in that have come since the last message, and gives them what they are to have.
    pub(crate) fn serve(&self) {
        // A reader that cannot be let in is its own loss.
        let _ = self.port.update_connections();
    }

    /// Places a message whose content has this length: `fill` writes the content, from front to back, and says what its header is.
    /// False if there was no room.
    pub(crate) fn send(&self, length: usize, fill: impl FnOnce(&mut Slate<'_>) -> LsStreamHeader) -> bool {
        assert!(length.is_multiple_of(WORD), "a section's length is a multiple of eight");
        let Ok(mut loan) = self.port.loan_slice_uninit(length / WORD) else { return false };
        let words = loan.payload_mut();
        // SAFETY: the same memory, all of it, as bytes, which need no alignment and, as the words, no content.
        let room = unsafe { std::slice::from_raw_parts_mut(words.as_mut_ptr().cast(), WORD * words.len()) };
        let mut slate = Slate { room, written: 0 };
        let header = fill(&mut slate);
        let written = slate.written;
        assert_eq!(written, length, "a message is as long as was said");
        loan.user_header_mut().0 = header;
        // SAFETY: `length` bytes were asked for, and as many were written from the front.
        let sample = unsafe { loan.assume_init() };
        sample.send().is_ok()
    }
}

/// Shared memory that is written once, from front to back, and never read.
pub(crate) struct Slate<'a> {
    room: &'a mut [std::mem::MaybeUninit<u8>],
    written: usize,
}

impl Slate<'_> {
    /// Writes on.
    pub(crate) fn put(&mut self, bytes: &[u8]) {
        let room = &mut self.room[self.written..self.written + bytes.len()];
        for (place, &byte) in room.iter_mut().zip(bytes) {
            place.write(byte);
        }
        self.written += bytes.len();
    }
}

/// The reading end of a channel.
#[derive(Debug)]
pub(crate) struct Inlet {
    port: Subscriber<Carrier, [Word], CarriedHeader>,
    service: Service,
}

/// What is on a channel.
pub(crate) enum Received {
    /// A message was copied.
    Message,
    /// Nothing that was not read before.
    Nothing,
}

impl Inlet {
    /// `None` where there is no such channel (any more).
    pub(crate) fn open(node: &Node<Carrier>, source: &Source, channel: &str) -> Result<Option<Self>> {
        let builder = node.service_builder(&source.service(channel)?).publish_subscribe::<[Word]>();
        let service = match builder.user_header::<CarriedHeader>().open() {
            Ok(service) => service,
            Err(PublishSubscribeOpenError::IncompatibleTypes | PublishSubscribeOpenError::VersionMismatch) => {
                return Err(Problem::Incompatible("the channel carries something else".into()));
            }
            Err(PublishSubscribeOpenError::ExceedsMaxNumberOfNodes) => {
                node.try_cleanup_dead_nodes();
                return Ok(None);
            }
            Err(
                PublishSubscribeOpenError::DoesNotExist
                | PublishSubscribeOpenError::IsMarkedForDestruction
                | PublishSubscribeOpenError::HangsInCreation
                | PublishSubscribeOpenError::ServiceInCorruptedState,
            ) => return Ok(None),
            Err(error) => return Err(Problem::System(format!("a channel cannot be read: {error:?}"))),
        };
        let port = match service.subscriber_builder().create() {
            Err(SubscriberCreateError::ExceedsMaxSupportedSubscribers) => {
                // Readers that died hold their places until somebody clears up.
                node.try_cleanup_dead_nodes();
                service.subscriber_builder().create()
            }
            port => port,
        };
        Ok(Some(Self { port: port.map_err(system("a channel cannot be read"))?, service }))
    }

    /// Copies the next message into `into`, which is as long as the message afterwards.
    pub(crate) fn receive(&self, memory: &OwnMemory, into: &mut Vec<u8>) -> Result<Received> {
        let sample = match self.port.receive() {
            Ok(Some(sample)) => sample,
            Ok(None) => return Ok(Received::Nothing),
            // The publisher went while its messages were being read.
            Err(_) => return Ok(Received::Nothing),
        };
        // Only the address of the header is taken; iceoryx2 has not looked at it either.
        let address = std::ptr::from_ref(sample.user_header()) as usize;
        into.resize(HEADER, 0);
        if !memory.copy(address, into) {
            return Err(Problem::Corrupt("a message lies outside its memory"));
        }
        let header: LsStreamHeader = bytemuck::pod_read_unaligned(into);
        check_header(&header)?;
        let length = (header.length as usize).min(MAX_MESSAGE);
        into.resize(length, 0);
        if !memory.copy(address.wrapping_add(HEADER), &mut into[HEADER..]) {
            return Err(Problem::Corrupt("a message reaches outside its memory"));
        }
        Ok(Received::Message)
    }

    /// Whether who publishes lives: the host itself if it is on this machine, else the tunnel that brings its messages. A tunnel
    /// writes on both ends of what it carries, so on the host's machine it says nothing of the host.
    pub(crate) fn has_publisher(&self, config: &Config, source: &Source) -> bool {
        let mut publishers = Vec::new();
        self.service.dynamic_config().list_publishers(|publisher| {
            publishers.push(publisher.node_id);
            CallbackProgression::Continue
        });
        let counts = |id: &UniqueNodeId| {
            !source.is_here() || id.pid::<Carrier>().is_ok_and(|process| u32::try_from(process.value()) == Ok(source.process))
        };
        let lives = |id: UniqueNodeId| matches!(Node::<Carrier>::state_of(config, id), Ok(Some(NodeState::Alive(_))));
        publishers.into_iter().filter(counts).any(lives)
    }
}

// The payload follows the header without a gap, as in a file.
const _: () = assert!(HEADER.is_multiple_of(8) && size_of::<LsStreamSection>().is_multiple_of(8));
