//! Where the streams of a user meet, and what they are called.
//!
//! Everything lies under one folder of the user's own, and shared memory carries the user's number in its names: nobody else can
//! open it, and nobody else's leftovers are in the way. A domain is a room of its own inside that folder.

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use iceoryx2::config::Config;
use iceoryx2::node::Node;
use iceoryx2::prelude::{
    CallbackProgression, FileName, LogLevel, NodeState, Path, SemanticString, Service, ServiceName, set_log_level,
};
use longspan_stream_schema::{LS_STREAM_ABI, LS_STREAM_SCHEMA};

use crate::channel::{self, Carrier};
use crate::platform::{DirBuilderExt, MetadataExt, PermissionsExt};
use crate::problem::{Problem, Result};

/// Most letters of a stream's or a domain's name.
pub const MAX_NAME: usize = 63;

/// First word of the name of everything that is ours.
const FAMILY: &str = "longspan";

/// A room in which publishers and readers find each other. Only processes of the same user are ever in it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Domain(String);

/// Letters, digits, `_`, `-` and `.`; not empty, not too long, no leading dot.
pub(crate) fn check_name(argument: &'static str, name: &str) -> Result<()> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    if name.is_empty() || name.len() > MAX_NAME || name.starts_with('.') || !name.chars().all(plain) {
        return Err(Problem::Argument(argument, "must be 1 to 63 letters, digits, '_', '-' and '.', and not begin with '.'"));
    }
    Ok(())
}

impl Domain {
    /// The domain of this name; the empty name is the one where everybody is who asks for none.
    ///
    /// # Errors
    /// The name has letters that a file name should not have, or too many.
    pub fn named(name: &str) -> Result<Self> {
        if !name.is_empty() {
            check_name("domain", name)?;
        }
        Ok(Self(name.to_owned()))
    }

    /// The folder in which everything but the shared memory itself lies.
    pub fn folder(&self) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("{FAMILY}-{}", user()));
        if self.0.is_empty() { folder.join("default") } else { folder.join(format!("d-{}", self.0)) }
    }

    /// What the names of all its shared memory begin with. No name of a domain has a plus, so no other domain's begin so.
    pub fn prefix(&self) -> String {
        format!("ls{}_{}+", user(), self.0)
    }

    /// Settings for iceoryx2; makes the folder, and refuses one that is not ours alone.
    pub(crate) fn config(&self) -> Result<Config> {
        set_log_level(LogLevel::Fatal);
        let folder = self.folder();
        for level in [folder.parent().unwrap_or(&folder), &folder] {
            own_folder(level)?;
        }
        let name = |text: String| FileName::new(text.as_bytes()).map_err(|_| Problem::Argument("domain", "is too long"));
        let path = folder.to_str().and_then(|text| Path::new(text.as_bytes()).ok());
        let path = path.ok_or_else(|| Problem::System(format!("{} is too long a name for a folder", folder.display())))?;
        let mut config = Config::default();
        config.global.set_root_path(&path);
        config.global.prefix = name(self.prefix())?;
        // Readers come and go, and are killed; the fewer of them clear up, the fewer are killed while they do.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        Ok(config)
    }

    /// Where its files lie, in the words of a configuration file of iceoryx2's: for a tunnel that is to carry its streams.
    ///
    /// # Errors
    /// The folder is somebody else's.
    pub fn settings(&self) -> Result<String> {
        let global = self.config()?.global;
        Ok(format!("[global]\nroot-path = \"{}\"\nprefix = \"{}\"\n", global.root_path(), global.prefix))
    }

    /// Joins the domain. Nobody clears it from now on until the membership ends.
    pub(crate) fn join(&self, config: &Config) -> Result<Membership> {
        let lock = self.lock()?;
        lock.lock_shared()?;
        self.own_memory()?;
        let node = channel::node(config)?;
        // iceoryx2 makes the file by which it numbers processes everybody's.
        self.own_memory()?;
        Ok(Membership { node, _lock: lock })
    }

    /// Takes shared memory of the domain from everybody else; refuses what somebody else has put under its names: memory that can be
    /// cut short by others is a fatal signal for who maps it.
    fn own_memory(&self) -> Result<()> {
        for file in self.memory() {
            // It may be gone by now.
            let Ok(found) = fs::symlink_metadata(&file) else { continue };
            if !found.is_file() || found.uid() != user() {
                return Err(Problem::System(format!("{} is not this user's", file.display())));
            }
            if found.mode() & 0o077 != 0 {
                let _ = fs::set_permissions(&file, fs::Permissions::from_mode(0o600));
            }
        }
        Ok(())
    }

    /// The files that are its shared memory.
    fn memory(&self) -> impl Iterator<Item = PathBuf> {
        let prefix = self.prefix();
        let files = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        files.filter(move |file| file.file_name().to_string_lossy().starts_with(&prefix)).map(|file| file.path())
    }

    /// Removes everything that is left, if no process lives that is a member.
    ///
    /// iceoryx2 removes what a dead process left, file by file; one that dies while it does that, or while it starts, can leave files
    /// that nobody is told of. They are found here, by their place. That nobody lives is known by the lock, which the kernel takes
    /// from a process that dies.
    pub(crate) fn clear(&self) {
        let Ok(lock) = self.lock() else { return };
        if lock.try_lock().is_err() || self.has_guests() {
            return;
        }
        for part in ["nodes", "services"] {
            let _ = fs::remove_dir_all(self.folder().join(part));
        }
        for file in self.memory() {
            let _ = fs::remove_file(file);
        }
    }

    /// Whether programs live here that know nothing of the lock: a tunnel, or tools of iceoryx2's.
    fn has_guests(&self) -> bool {
        let mut found = false;
        let listed = self.config().map(|config| {
            Node::<Carrier>::list(&config, |node| {
                found |= matches!(node, NodeState::Alive(_));
                if found { CallbackProgression::Stop } else { CallbackProgression::Continue }
            })
        });
        found && listed.is_ok()
    }

    /// A file that members lock together, and who clears up alone. It stays.
    fn lock(&self) -> Result<fs::File> {
        Ok(fs::File::create(self.folder().join("lock"))?)
    }

    /// All streams that are published now, or were until their process died.
    ///
    /// # Errors
    /// The folder is somebody else's, or cannot be read.
    pub fn sources(&self) -> Result<Vec<Source>> {
        let config = self.config()?;
        let mut sources = Vec::new();
        let listed = Carrier::list(&config, |service| {
            if let Some(source) = Source::parse(service.static_details.name().as_str()) {
                sources.push(source);
            }
            CallbackProgression::Continue
        });
        listed.map_err(|error| Problem::System(format!("streams cannot be listed: {error}")))?;
        sources.sort();
        Ok(sources)
    }
}

/// A process as a member of a domain.
#[derive(Debug)]
pub(crate) struct Membership {
    /// What it is to iceoryx2.
    pub node: Node<Carrier>,
    /// Held until the node is gone.
    _lock: fs::File,
}

/// The number of the user whose process this is.
fn user() -> u32 {
    fs::metadata("/proc/self").map_or(0, |of_self| of_self.uid())
}

/// Makes a folder that only its owner can enter, or checks that it is one.
fn own_folder(folder: &std::path::Path) -> Result<()> {
    match fs::DirBuilder::new().mode(0o700).create(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
            return Err(Problem::System(format!("{}: {error}", folder.display())));
        }
        _ => {}
    }
    let found = fs::symlink_metadata(folder)?;
    if !found.is_dir() || found.uid() != user() {
        return Err(Problem::System(format!("{} is not a folder of this user", folder.display())));
    }
    if found.mode() & 0o077 != 0 {
        fs::set_permissions(folder, fs::Permissions::from_mode(0o700))?;
    }
    Ok(())
}

/// A stream that can be read.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Source {
    /// The name that its host gave it.
    pub name: String,
    /// Number of the process that publishes it.
    pub process: u32,
    /// Number of the stream in that process.
    pub number: u32,
    /// Number of its schema; one that is not [`LS_STREAM_SCHEMA`] cannot be read.
    pub schema: u32,
    /// Number of the binary interface of the library that publishes it; any can be read.
    pub abi: u32,
    /// Number of the machine on which it is published; see [`is_here`](Self::is_here).
    pub machine: u32,
}

/// Number of this machine, or of this container on it: of what numbers its processes by itself or has a network of its own. Two
/// streams that a tunnel brings together must not have one name, and who reads must know whether the process of a stream is one of
/// its neighbours.
fn machine() -> u32 {
    static NUMBER: OnceLock<u32> = OnceLock::new();
    *NUMBER.get_or_init(|| {
        let boot = fs::read("/proc/sys/kernel/random/boot_id").unwrap_or_default();
        let spaces = ["pid", "net"].map(|space| fs::read_link(format!("/proc/self/ns/{space}")).unwrap_or_default());
        let mut hash = crc32fast::Hasher::new();
        hash.update(&boot);
        spaces.iter().for_each(|space| hash.update(space.as_os_str().as_encoded_bytes()));
        hash.finalize()
    })
}

impl Source {
    pub(crate) fn new(name: &str, process: u32, number: u32) -> Self {
        Self { name: name.to_owned(), process, number, schema: LS_STREAM_SCHEMA, abi: LS_STREAM_ABI, machine: machine() }
    }

    /// Whether it is published on this machine; if not, a tunnel has brought it.
    pub fn is_here(&self) -> bool {
        self.machine == machine()
    }

    /// Name of the service that carries a channel.
    pub(crate) fn service(&self, channel: &str) -> Result<ServiceName> {
        let Self { name, process, number, schema, abi, machine } = self;
        let text = format!("{FAMILY}/abi{abi}/schema{schema}/{machine:08x}/{process}/{number}/{name}/{channel}");
        ServiceName::new(&text).map_err(|_| Problem::Argument("name", "is too long"))
    }

    /// The stream of which this is the name of the hot channel.
    fn parse(service: &str) -> Option<Self> {
        let words: Vec<&str> = service.split('/').collect();
        let [FAMILY, abi, schema, machine, process, number, name, "hot"] = words[..] else { return None };
        Some(Self {
            name: name.to_owned(),
            process: process.parse().ok()?,
            number: number.parse().ok()?,
            schema: schema.strip_prefix("schema")?.parse().ok()?,
            abi: abi.strip_prefix("abi")?.parse().ok()?,
            machine: u32::from_str_radix(machine, 16).ok()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_found_by_the_name_of_its_service() {
        let source = Source::new("crane.left-2", 4711, 3);
        assert_eq!(Source::parse(source.service("hot").unwrap().as_str()), Some(source.clone()));
        assert_eq!(Source::parse(source.service("cold").unwrap().as_str()), None);
        assert!(source.is_here());
        let other = Source::parse("longspan/abi7/schema9/00c0ffee/1/2/x/hot").unwrap();
        assert_eq!((other.schema, other.abi, other.machine), (9, 7, 0xc0_ffee));
        assert_eq!(Source::parse(other.service("hot").unwrap().as_str()), Some(other));
        for other in ["", "longspan", "camera/hot", "longspan/abi0/schemaX/0/1/2/x/hot"] {
            assert_eq!(Source::parse(other), None, "{other}");
        }
    }

    #[test]
    fn names_that_would_leave_the_folder_are_refused() {
        for name in ["..", ".x", "a/b", "a b", "ä", &"x".repeat(64)] {
            assert!(Domain::named(name).is_err(), "{name}");
        }
        assert!(Domain::named("").is_ok());
    }
}
