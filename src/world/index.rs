//! What walks over pairs ask of shapes and bodies, in a few bytes each.
//!
//! A pile has ten pairs for each body, and each of its records is hundreds of bytes: a walk that reads one number of each record waits for
//! memory at most pairs, and the more so the more bodies there are. The arrays here stay in the cache.

/// A set of slots that is emptied at once.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// When each slot was marked last.
    at: Vec<u32>,
    now: u32,
}

impl Marks {
    /// Forgets all marks, and makes room for those of so many slots.
    pub(super) fn begin(&mut self, slots: usize) {
        if self.now == u32::MAX {
            self.at.clear();
            self.now = 0;
        }
        self.now += 1;
        if self.at.len() < slots {
            self.at.resize(slots, 0);
        }
    }

    pub(super) fn set(&mut self, slot: u32) {
        if self.at.len() <= slot as usize {
            self.at.resize(slot as usize + 1, 0);
        }
        self.at[slot as usize] = self.now;
    }

    pub(super) fn has(&self, slot: u32) -> bool {
        self.at.get(slot as usize) == Some(&self.now)
    }
}

/// The arrays of a world.
#[derive(Debug, Default)]
pub(super) struct Index {
    /// Body of each shape, by slot.
    bodies: Vec<u32>,
    /// Bodies that a step moves, as it begins.
    pub moving: Marks,
    /// Bodies that islands consist of.
    pub free: Marks,
    /// Shapes with another kept box than when pairs were last looked through.
    pub reboxed: Marks,
    /// Whether pairs have been looked through since the world was made or restored.
    pub is_known: bool,
}

impl Index {
    /// An index of a world that was restored, which has shapes of these bodies.
    pub(super) fn of(shapes: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut index = Self::default();
        shapes.for_each(|(slot, body)| index.add_shape(slot, body));
        index
    }

    /// Takes note of a shape in this slot on a body.
    pub(super) fn add_shape(&mut self, slot: u32, body: u32) {
        if self.bodies.len() <= slot as usize {
            self.bodies.resize(slot as usize + 1, u32::MAX);
        }
        self.bodies[slot as usize] = body;
    }

    /// Body of a shape.
    pub(super) fn body_of(&self, shape: u32) -> u32 {
        self.bodies[shape as usize]
    }
}
