//! The hot channel: all that moved in a step, and the layers that a host asked for.

use longspan::{Handle, Moved, World};
use longspan_stream_schema::{
    ContentHash, LS_STREAM_BODY_ASLEEP, LS_STREAM_CHANNEL_HOT, LS_STREAM_HAS_STATE_HASH, LS_STREAM_LAYER_BOUNDS,
    LS_STREAM_LAYER_CONTACTS, LS_STREAM_LAYER_JOINT_LOADS, LS_STREAM_LAYER_PLANES, LsStreamHeader, LsStreamMotion,
    LsStreamSection, Wire,
};

use super::{Cold, records};
use crate::channel::Slate;
use crate::message::{HEADER, SECTION, Sections, clock, header};

/// Builds frames.
#[derive(Debug, Default)]
pub(crate) struct Hot {
    layers: Sections,
    /// Hash of the world's state, and the version that it is of.
    state: Option<([u64; 2], u64)>,
}

impl Hot {
    /// Collects the layers of this step; returns the bytes of the content of the frame.
    pub(crate) fn prepare(&mut self, world: &World, layers: u32) -> usize {
        self.layers.clear();
        if layers & LS_STREAM_LAYER_CONTACTS != 0 {
            world.contacts().for_each(|contact| self.layers.push(&records::contact(&contact)));
        }
        if layers & LS_STREAM_LAYER_JOINT_LOADS != 0 {
            let loads = world.joints().filter_map(|joint| records::joint_load(world, joint).ok());
            loads.for_each(|load| self.layers.push(&load));
        }
        if layers & LS_STREAM_LAYER_BOUNDS != 0 {
            world.bounds().for_each(|bound| self.layers.push(&records::bound(&bound)));
        }
        if layers & LS_STREAM_LAYER_PLANES != 0 {
            world.planes().for_each(|plane| self.layers.push(&records::plane(&plane)));
        }
        self.layers.close();
        SECTION + world.moved().len() * size_of::<LsStreamMotion>() + self.layers.bytes.len()
    }

    /// A header with all that the world says.
    pub(crate) fn header(&mut self, world: &World, session: u64, with_hash: bool) -> LsStreamHeader {
        LsStreamHeader {
            step: world.step_count(),
            time: world.time(),
            state_hash: if with_hash { self.state_hash(world) } else { 0 },
            flags: if with_hash { LS_STREAM_HAS_STATE_HASH } else { 0 },
            body_count: world.body_count() as u32,
            shape_count: world.shape_count() as u32,
            joint_count: world.joint_count() as u32,
            ..header(LS_STREAM_CHANNEL_HOT, session)
        }
    }

    /// Of a world in which all sleeps the hash is not computed again: reading every body costs more than the step.
    fn state_hash(&mut self, world: &World) -> u64 {
        let version = world.state_version();
        match self.state {
            Some((known, hash)) if known == version => hash,
            _ => self.state.insert((version, world.state_hash())).1,
        }
    }

    /// Writes the content of a frame, and returns its header. `known` has what is said of bodies beside their motion.
    pub(crate) fn write(&self, world: &World, known: &Cold, start: LsStreamHeader, slate: &mut Slate<'_>) -> LsStreamHeader {
        let moved = world.moved();
        let mut hash = ContentHash::default();
        let mut put = |bytes: &[u8]| {
            hash.add(bytes);
            slate.put(bytes);
        };
        let length = moved.len() * size_of::<LsStreamMotion>();
        put(bytemuck::bytes_of(&LsStreamSection {
            kind: LsStreamMotion::SECTION,
            stride: size_of::<LsStreamMotion>() as u32,
            count: moved.len() as u32,
            length: length as u64,
            ..LsStreamSection::default()
        }));
        for moved in moved {
            put(bytemuck::bytes_of(&motion(moved, known)));
        }
        put(&self.layers.bytes);
        LsStreamHeader {
            section_count: 1 + self.layers.count,
            length: (HEADER + SECTION + length + self.layers.bytes.len()) as u64,
            content_hash: hash.finish(),
            clock: clock(),
            ..start
        }
    }
}

fn motion(moved: &Moved, known: &Cold) -> LsStreamMotion {
    let flags = known.flags.get(moved.body.place()).copied().unwrap_or(0);
    LsStreamMotion {
        body: moved.body.to_bits(),
        user_word: moved.user_word,
        union_id: known.unions.get(moved.body.place()).copied().unwrap_or(0),
        position: moved.pose.position.to_array(),
        rotation: moved.pose.rotation.to_array(),
        linear_velocity: moved.linear_velocity.to_array(),
        angular_velocity: moved.angular_velocity.to_array(),
        flags: flags | if moved.fell_asleep { LS_STREAM_BODY_ASLEEP } else { 0 },
        reserved: 0,
    }
}
