//! The publishing side.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use longspan::World;
use longspan_stream_schema::{
    LS_STREAM_LAYER_ALL, LS_STREAM_LAYER_BOUNDS, LS_STREAM_LAYER_CONTACTS, LS_STREAM_LAYER_JOINT_LOADS, LsStreamHeader,
    LsStreamMotion, LsStreamWorld,
};

use crate::capture::{BLOCK, Cold, Hot};
use crate::channel::{Outlet, Room};
use crate::domain::{Domain, Membership, Source, check_name};
use crate::message::{SECTION, clock};
use crate::problem::{Problem, Result};

/// Frames that wait for a reader. Two would do for one that only wants the latest; a recorder that is held up for a moment wants all.
const HOT_BUFFER: usize = 4;

/// Messages that wait for a reader, and that one gets which joins late: four seconds of a world of 10,000 bodies, and all of a
/// small one.
const COLD_BUFFER: usize = 256;

/// Most readers of a stream at a time.
const MAX_READERS: u32 = 64;

/// What a stream starts with.
#[derive(Debug, Clone, PartialEq)]
pub struct PublisherDef {
    /// What readers look for: 1 to 63 letters, digits, `_`, `-` and `.`.
    pub name: String,
    /// Where readers look.
    pub domain: Domain,
    /// A frame every so many steps, at least 1.
    pub every: u32,
    /// `LS_STREAM_LAYER_` bits: what frames hold besides motion.
    pub layers: u32,
    /// Readers at a time, 1 to 64. Each costs memory for four frames.
    pub readers: u32,
    /// Bodies to have room for from the start; more are found room for, which costs the step in which it happens some time.
    pub body_capacity: u32,
    /// Whether each frame carries the hash of the world's state.
    pub state_hash: bool,
}

impl Default for PublisherDef {
    fn default() -> Self {
        Self {
            name: "world".into(),
            domain: Domain::default(),
            every: 1,
            layers: 0,
            readers: 8,
            body_capacity: 0,
            state_hash: true,
        }
    }
}

impl PublisherDef {
    fn check(&self) -> Result<()> {
        check_name("name", &self.name)?;
        if self.every == 0 {
            return Err(Problem::Argument("every", "must be at least 1"));
        }
        if self.layers & !LS_STREAM_LAYER_ALL != 0 {
            return Err(Problem::Argument("layers", "has bits that this version does not know"));
        }
        if !(1..=MAX_READERS).contains(&self.readers) {
            return Err(Problem::Argument("readers", "must be 1 to 64"));
        }
        Ok(())
    }

    /// Bytes that a frame of this world may come to.
    fn frame_bytes(&self, world: &World) -> usize {
        let layer = |bit: u32, bytes: usize| if self.layers & bit != 0 { bytes } else { 0 };
        let bodies = (world.body_count()).max(self.body_capacity as usize).max(64);
        let motion = bodies * size_of::<LsStreamMotion>();
        let contacts = layer(LS_STREAM_LAYER_CONTACTS, 4 * bodies * size_of::<longspan_stream_schema::LsStreamContact>());
        let loads = layer(LS_STREAM_LAYER_JOINT_LOADS, world.joint_count() * 24);
        let bounds = layer(LS_STREAM_LAYER_BOUNDS, world.bounds().count() * 96);
        (8 * SECTION + motion + contacts + loads + bounds).next_power_of_two()
    }
}

/// What a stream has done so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PublisherStats {
    /// Frames published.
    pub frames: u64,
    /// Messages published on the cold channel.
    pub records: u64,
    /// Messages that could not be placed.
    pub dropped: u64,
    /// Bytes published.
    pub bytes: u64,
    /// What the last publication took (s).
    pub seconds: f64,
}

/// Publishes a world.
///
/// It holds no reference to the world: [`publish`](Self::publish) is to be called after each step. Dropping it ends the stream.
#[derive(Debug)]
pub struct Publisher {
    def: PublisherDef,
    source: Source,
    hot: Hot,
    cold: Cold,
    hot_outlet: Outlet,
    cold_outlet: Outlet,
    hot_sequence: u64,
    cold_sequence: u64,
    steps: u64,
    stats: PublisherStats,
    /// The channel failed from within; nothing is published any more.
    failed: bool,
    /// After the ports, which it outlives.
    membership: Membership,
    /// Last of all.
    _clearer: Clearer,
}

/// Clears up when everything else is gone.
#[derive(Debug)]
struct Clearer(Domain);

impl Drop for Clearer {
    fn drop(&mut self) {
        self.0.clear();
    }
}

impl Drop for Publisher {
    fn drop(&mut self) {
        // While the channels are still there: what dead readers had of them goes with them.
        let _ = catch_unwind(AssertUnwindSafe(|| self.membership.node.try_cleanup_dead_nodes()));
    }
}

/// Streams of this process so far.
static STREAMS: AtomicU32 = AtomicU32::new(1);

impl Publisher {
    /// Begins a stream of `world`, and tells all that is in it.
    ///
    /// What processes left behind that died is removed on the way.
    ///
    /// # Errors
    /// Names the field of `def` that is out of range; says why shared memory cannot be used.
    pub fn open(world: &World, def: &PublisherDef) -> Result<Self> {
        def.check()?;
        let config = def.domain.config()?;
        def.domain.clear();
        let membership = def.domain.join(&config)?;
        let node = &membership.node;
        node.try_cleanup_dead_nodes();
        let source = Source::new(&def.name, std::process::id(), STREAMS.fetch_add(1, Ordering::Relaxed));
        let readers = def.readers as usize;
        let hot_room = Room { name: "hot", buffer: HOT_BUFFER, history: 1, bytes: def.frame_bytes(world), grows: true };
        let cold_room = Room { name: "cold", buffer: COLD_BUFFER, history: COLD_BUFFER, bytes: BLOCK, grows: false };
        // Readers look for the hot channel: it comes last.
        let cold_outlet = Outlet::open(node, &source, cold_room, readers)?;
        let hot_outlet = Outlet::open(node, &source, hot_room, readers)?;
        let session = session(source.number);
        let mut publisher = Self {
            source,
            hot: Hot::default(),
            cold: Cold::new(about(world, def), session),
            hot_outlet,
            cold_outlet,
            hot_sequence: 0,
            cold_sequence: 0,
            steps: 0,
            stats: PublisherStats::default(),
            failed: false,
            membership,
            _clearer: Clearer(def.domain.clone()),
            def: def.clone(),
        };
        publisher.tell(world, true);
        publisher.publish_frame(world, session);
        Ok(publisher)
    }

    /// What readers find it by.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// What it was opened with.
    pub fn def(&self) -> &PublisherDef {
        &self.def
    }

    /// What it has done so far.
    pub fn stats(&self) -> &PublisherStats {
        &self.stats
    }

    /// Publishes the last step of `world`, the one that the stream was opened for.
    ///
    /// Never fails and never waits: what cannot be placed is counted ([`PublisherStats::dropped`]).
    pub fn publish(&mut self, world: &World) {
        let start = Instant::now();
        self.steps += 1;
        if self.failed {
            self.stats.dropped += 1;
            return;
        }
        // Queues in shared memory can be written by readers; one that spoils them must not take the simulation down.
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            self.tell(world, false);
            if self.steps.is_multiple_of(self.def.every.into()) {
                self.publish_frame(world, self.cold.session());
            }
        }));
        self.failed = outcome.is_err();
        self.stats.seconds = start.elapsed().as_secs_f64();
    }

    /// Lets readers in that have come since the last publication, and gives them what was published before. To be called now and
    /// then while the world is not stepped; [`publish`](Self::publish) does it too.
    pub fn serve(&mut self) {
        if !self.failed {
            let served = catch_unwind(AssertUnwindSafe(|| {
                self.cold_outlet.serve();
                self.hot_outlet.serve();
            }));
            self.failed = served.is_err();
        }
    }

    fn tell(&mut self, world: &World, all: bool) {
        let Self { cold, cold_outlet, cold_sequence, stats, .. } = self;
        let mut ship = |header: &mut LsStreamHeader, content: &[u8]| {
            *cold_sequence += 1;
            header.sequence = *cold_sequence;
            header.dropped = stats.dropped;
            let header = *header;
            let sent = cold_outlet.send(content.len(), |slate| {
                slate.put(content);
                header
            });
            stats.records += u64::from(sent);
            stats.dropped += u64::from(!sent);
            stats.bytes += header.length;
        };
        if all { cold.tell_all(world, &mut ship) } else { cold.tell(world, &mut ship) }
    }

    fn publish_frame(&mut self, world: &World, session: u64) {
        let length = self.hot.prepare(world, self.def.layers);
        self.hot_sequence += 1;
        let start = LsStreamHeader {
            sequence: self.hot_sequence,
            dropped: self.stats.dropped,
            ..self.hot.header(world, session, self.def.state_hash)
        };
        let sent = self.hot_outlet.send(length, |slate| self.hot.write(world, &self.cold, start, slate));
        self.stats.frames += u64::from(sent);
        self.stats.dropped += u64::from(!sent);
        self.stats.bytes += length as u64;
    }
}

fn about(world: &World, def: &PublisherDef) -> LsStreamWorld {
    let mut name = [0; 64];
    name[..def.name.len()].copy_from_slice(def.name.as_bytes());
    let settings = world.def();
    LsStreamWorld {
        name,
        process: std::process::id().into(),
        gravity: world.gravity().to_array(),
        substeps: settings.substeps,
        iterations: settings.iterations,
        support: u32::from(world.supported_count().is_ok()),
        layers: def.layers,
        every: def.every,
    }
}

/// Differs between any two streams that a reader could take for one.
fn session(number: u32) -> u64 {
    (clock() ^ (u64::from(std::process::id()) << 40) ^ u64::from(number)).max(1)
}
