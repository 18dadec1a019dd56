//! Handles and the pools they index.
//!
//! A handle is 64 bits: `world tag (10) | kind (2) | generation (24) | index + 1 (28)`; zero is null. Every bit pattern is safe
//! to pass: a pool says whether it is null, foreign, stale or was never given out. A slot whose generations are used up is
//! retired, so a handle never comes to mean something else.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::{Error, ErrorKind, Result};
use crate::prefetch::prefetch;
use crate::tight_vec::extend_tightly;

const INDEX_BITS: u32 = 28;
const GENERATION_BITS: u32 = 24;
const KIND_BITS: u32 = 2;
const INDEX_MASK: u64 = (1 << INDEX_BITS) - 1;
const GENERATION_MASK: u64 = (1 << GENERATION_BITS) - 1;
const KIND_MASK: u64 = (1 << KIND_BITS) - 1;
const KIND_SHIFT: u32 = INDEX_BITS + GENERATION_BITS;
const TAG_SHIFT: u32 = KIND_SHIFT + KIND_BITS;
const TAGS: usize = 1 << (64 - TAG_SHIFT);

/// Most objects of one kind that a world can hold at a time.
pub const MAX_OBJECTS: usize = INDEX_MASK as usize - 1;

/// A typed handle: `BodyId`, `ShapeId` or `JointId`.
pub trait Handle: Copy {
    /// Number of the kind, 0 to 3, part of every handle's bits.
    const KIND: u64;
    /// What an error calls the argument that holds such a handle.
    const ARGUMENT: &'static str;
    /// Wraps raw bits; any value is safe.
    fn from_bits(bits: u64) -> Self;
    /// The raw bits, to store outside and to hand back later.
    fn to_bits(self) -> u64;
    /// Number of the place that the object has among those of its kind. Whoever comes after it gets the same number; null has
    /// none that means anything.
    fn place(self) -> usize {
        ((self.to_bits() & INDEX_MASK) as usize).saturating_sub(1)
    }
}

macro_rules! handle {
    ($(#[$doc:meta])* $name:ident, $kind:expr, $argument:expr) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        pub struct $name(u64);

        impl $name {
            /// The handle that names nothing.
            pub const NULL: Self = Self(0);
        }

        impl Handle for $name {
            const KIND: u64 = $kind;
            const ARGUMENT: &'static str = $argument;
            fn from_bits(bits: u64) -> Self {
                Self(bits)
            }
            fn to_bits(self) -> u64 {
                self.0
            }
        }
    };
}

handle!(
    /// Names a body of one world.
    BodyId, 1, "body"
);
handle!(
    /// Names a shape on a body of one world.
    ShapeId, 2, "shape"
);
handle!(
    /// Names a joint of one world.
    JointId, 3, "joint"
);

/// A handle's bits but for the number of its world.
pub(crate) fn without_world(handle: impl Handle) -> u64 {
    handle.to_bits() & ((1 << TAG_SHIFT) - 1)
}

/// The same handle in another world; null stays null.
pub(crate) fn in_world<H: Handle>(handle: H, tag: u16) -> H {
    let bits = without_world(handle);
    H::from_bits(if bits == 0 { 0 } else { bits | u64::from(tag) << TAG_SHIFT })
}

/// The number of a world, part of every handle it gives out; unique among the worlds alive.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct WorldTag(u16);

struct Tags {
    used: [bool; TAGS],
    last: usize,
}

static TAGS_IN_USE: Mutex<Tags> = Mutex::new(Tags { used: [false; TAGS], last: 0 });

impl WorldTag {
    /// The number itself.
    pub(crate) fn number(&self) -> u16 {
        self.0
    }

    /// Takes the next free tag, round robin, so that a dead world's handles stay foreign for as long as possible.
    pub(crate) fn acquire() -> Result<Self> {
        let mut tags = TAGS_IN_USE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        for step in 1..TAGS {
            let tag = 1 + (tags.last + step - 1) % (TAGS - 1);
            if !tags.used[tag] {
                tags.used[tag] = true;
                tags.last = tag;
                return Ok(Self(tag as u16));
            }
        }
        Err(Error::new(ErrorKind::CapacityExceeded, "world", "1023 worlds are alive already"))
    }
}

impl Drop for WorldTag {
    fn drop(&mut self) {
        let mut tags = TAGS_IN_USE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        tags.used[self.0 as usize] = false;
    }
}

/// A place in a pool, and how often it has been given out.
#[derive(Debug, Clone)]
pub(crate) struct Slot<T> {
    pub generation: u32,
    pub value: Option<T>,
}

/// Objects of one kind, found by handle or by slot index.
#[derive(Debug)]
pub(crate) struct Pool<T, H> {
    slots: Vec<Slot<T>>,
    free: Vec<u32>,
    len: usize,
    /// Rises with whatever comes or goes; no two pools of a process begin with the same. Never part of a state.
    version: u64,
    /// Rises with whatever may have changed. Never part of a state.
    changes: u64,
    tag: u16,
    handle: std::marker::PhantomData<H>,
}

/// Pools made so far, in the upper half of a version.
static POOLS: AtomicU64 = AtomicU64::new(0);

fn first_version() -> u64 {
    POOLS.fetch_add(1, Ordering::Relaxed) << 32
}

impl<T, H: Handle> Pool<T, H> {
    pub(crate) fn new(tag: &WorldTag) -> Self {
        let version = first_version();
        Self { slots: Vec::new(), free: Vec::new(), len: 0, version, changes: 0, tag: tag.0, handle: std::marker::PhantomData }
    }

    /// A number that differs whenever other objects are in the pool.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Numbers that differ whenever any object has come, gone, or been open to change.
    pub(crate) fn changes(&self) -> [u64; 2] {
        [self.version, self.changes]
    }

    /// A pool with these places, of which these are free; `None` if that cannot be.
    pub(crate) fn from_parts(tag: u16, slots: Vec<Slot<T>>, free: Vec<u32>) -> Option<Self> {
        let empty = slots.iter().filter(|slot| slot.value.is_none() && u64::from(slot.generation) < GENERATION_MASK).count();
        let mut sorted = free.clone();
        sorted.sort_unstable();
        let distinct = sorted.windows(2).all(|two| two[0] < two[1]);
        let usable = |&index: &u32| slots.get(index as usize).is_some_and(|slot| slot.value.is_none());
        let in_range = slots.len() <= MAX_OBJECTS && slots.iter().all(|slot| u64::from(slot.generation) <= GENERATION_MASK);
        if !(distinct && in_range && free.len() == empty && free.iter().all(usable)) {
            return None;
        }
        let len = slots.iter().filter(|slot| slot.value.is_some()).count();
        Some(Self { slots, free, len, version: first_version(), changes: 0, tag, handle: std::marker::PhantomData })
    }

    /// Every place, in order.
    pub(crate) fn slots(&self) -> &[Slot<T>] {
        &self.slots
    }

    /// Every place, in order, for threads to change what is there.
    pub(crate) fn slots_mut(&mut self) -> &mut [Slot<T>] {
        self.changes += 1;
        &mut self.slots
    }

    /// Free places; the last one is given out next.
    pub(crate) fn free(&self) -> &[u32] {
        &self.free
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// One more than the largest slot index in use so far.
    pub(crate) fn slot_count(&self) -> usize {
        self.slots.len()
    }

    pub(crate) fn reserve(&mut self, additional: usize) {
        self.slots.reserve_exact(additional);
    }

    pub(crate) fn insert(&mut self, value: T) -> Result<(u32, H)> {
        let index = match self.free.pop() {
            Some(index) => index,
            None if self.slots.len() < MAX_OBJECTS => {
                extend_tightly(&mut self.slots, std::iter::once(Slot { generation: 0, value: None }));
                (self.slots.len() - 1) as u32
            }
            None => return Err(Error::new(ErrorKind::CapacityExceeded, H::ARGUMENT, "the world holds no more of this kind")),
        };
        self.slots[index as usize].value = Some(value);
        self.len += 1;
        self.version += 1;
        Ok((index, self.handle_of(index)))
    }

    pub(crate) fn remove(&mut self, index: u32) -> Option<T> {
        let slot = &mut self.slots[index as usize];
        let value = slot.value.take()?;
        self.len -= 1;
        self.version += 1;
        slot.generation += 1;
        if u64::from(slot.generation) < GENERATION_MASK {
            self.free.push(index);
        }
        Some(value)
    }

    pub(crate) fn handle_of(&self, index: u32) -> H {
        let generation = u64::from(self.slots[index as usize].generation);
        let bits =
            (u64::from(self.tag) << TAG_SHIFT) | (H::KIND << KIND_SHIFT) | (generation << INDEX_BITS) | u64::from(index + 1);
        H::from_bits(bits)
    }

    /// Slot index of a live object, or why there is none.
    pub(crate) fn find(&self, handle: H) -> Result<u32> {
        let bits = handle.to_bits();
        let error = |kind, problem| Err(Error::new(kind, H::ARGUMENT, problem));
        if bits == 0 {
            return error(ErrorKind::NullHandle, "handle is null");
        }
        let (tag, kind) = (bits >> TAG_SHIFT, (bits >> KIND_SHIFT) & KIND_MASK);
        let (generation, index) = ((bits >> INDEX_BITS) & GENERATION_MASK, bits & INDEX_MASK);
        if kind != H::KIND || index == 0 || tag == 0 {
            return error(ErrorKind::InvalidHandle, "handle was never given out for this kind of object");
        }
        if tag != u64::from(self.tag) {
            return error(ErrorKind::ForeignHandle, "handle belongs to another world");
        }
        match self.slots.get(index as usize - 1) {
            Some(slot) if u64::from(slot.generation) == generation && slot.value.is_some() => Ok(index as u32 - 1),
            Some(slot) if generation < u64::from(slot.generation) => error(ErrorKind::StaleHandle, "object was destroyed"),
            _ => error(ErrorKind::InvalidHandle, "handle was never given out by this world"),
        }
    }

    /// Slot index of an object that is known to be alive, without looking at it.
    pub(crate) fn slot_of(&self, handle: H) -> u32 {
        let index = Self::place_of(handle);
        debug_assert!(self.find(handle) == Ok(index), "who knows an object to be alive is told when it is destroyed");
        index
    }

    /// Slot index of an object that is known to be alive, of any pool of its kind.
    pub(crate) fn place_of(handle: H) -> u32 {
        (handle.to_bits() & INDEX_MASK) as u32 - 1
    }

    /// As [`find`](Self::find), for a call that destroys: a dead object is an error of its own.
    pub(crate) fn find_to_destroy(&self, handle: H) -> Result<u32> {
        self.find(handle).map_err(|error| match error.kind {
            ErrorKind::StaleHandle => Error::new(ErrorKind::AlreadyDestroyed, H::ARGUMENT, "object was destroyed before"),
            _ => error,
        })
    }

    pub(crate) fn get(&self, index: u32) -> Option<&T> {
        self.slots.get(index as usize)?.value.as_ref()
    }

    /// Asks for the memory of a slot.
    #[inline(always)]
    pub(crate) fn ask_for(&self, index: u32) {
        if let Some(slot) = self.slots.get(index as usize) {
            prefetch(slot);
        }
    }

    pub(crate) fn get_mut(&mut self, index: u32) -> Option<&mut T> {
        self.changes += 1;
        self.slots.get_mut(index as usize)?.value.as_mut()
    }

    /// Every live object with its slot index, in slot order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, &T)> {
        self.slots.iter().enumerate().filter_map(|(index, slot)| Some((index as u32, slot.value.as_ref()?)))
    }
}

impl<T, H: Handle> std::ops::Index<u32> for Pool<T, H> {
    type Output = T;
    fn index(&self, index: u32) -> &T {
        self.slots[index as usize].value.as_ref().expect("slot indices inside a world name live objects")
    }
}

impl<T, H: Handle> std::ops::IndexMut<u32> for Pool<T, H> {
    fn index_mut(&mut self, index: u32) -> &mut T {
        self.changes += 1;
        self.slots[index as usize].value.as_mut().expect("slot indices inside a world name live objects")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pool(tag: &WorldTag) -> Pool<u8, BodyId> {
        Pool::new(tag)
    }

    #[test]
    fn each_wrong_handle_gets_its_own_error() {
        let (tag, other_tag) = (WorldTag::acquire().unwrap(), WorldTag::acquire().unwrap());
        let (mut bodies, mut others) = (pool(&tag), pool(&other_tag));
        let (index, handle) = bodies.insert(1).unwrap();
        let (_, foreign) = others.insert(2).unwrap();
        assert_eq!(bodies.find(handle), Ok(index));
        let kind = |h: BodyId| bodies.find(h).unwrap_err().kind;
        assert_eq!(kind(BodyId::NULL), ErrorKind::NullHandle);
        assert_eq!(kind(foreign), ErrorKind::ForeignHandle);
        assert_eq!(kind(BodyId::from_bits(handle.to_bits() + 7)), ErrorKind::InvalidHandle);
        assert_eq!(kind(BodyId::from_bits(u64::MAX)), ErrorKind::InvalidHandle);
        bodies.remove(index);
        assert_eq!(bodies.find(handle).unwrap_err().kind, ErrorKind::StaleHandle);
        assert_eq!(bodies.find_to_destroy(handle).unwrap_err().kind, ErrorKind::AlreadyDestroyed);
        let (_, reused) = bodies.insert(3).unwrap();
        assert_ne!(reused, handle);
        assert_eq!(bodies.find(handle).unwrap_err().kind, ErrorKind::StaleHandle);
    }

    #[test]
    fn a_slot_out_of_generations_is_retired() {
        let tag = WorldTag::acquire().unwrap();
        let mut bodies = pool(&tag);
        let (index, _) = bodies.insert(0).unwrap();
        bodies.slots[index as usize].generation = GENERATION_MASK as u32 - 1;
        let last = bodies.handle_of(index);
        bodies.remove(index);
        let (next, _) = bodies.insert(0).unwrap();
        assert_ne!(next, index);
        assert_eq!(bodies.find(last).unwrap_err().kind, ErrorKind::StaleHandle);
    }

    #[test]
    fn a_pool_keeps_an_eighth_in_reserve_and_what_it_was_told_of() {
        let tag = WorldTag::acquire().unwrap();
        let (mut grown, mut told) = (pool(&tag), pool(&tag));
        (0..10_000).for_each(|_| {
            grown.insert(1).unwrap();
        });
        let room = grown.slots.capacity();
        assert!(room < 11_300, "room for {room} of 10,000");
        told.reserve(10_000);
        assert_eq!(told.slots.capacity(), 10_000);
    }
}
