//! Arguments and answers of calls as bytes.

use crate::body::{BodyDef, BodyKind, LockedAxes};
use crate::fracture::{FractureSettings, Strength};
use crate::id::{BodyId, JointId, ShapeId, without_world};
use crate::joint::{JointDef, JointKind, Softness};
use crate::long_range::{LongRangeDef, SoftBound};
use crate::mass::Mass;
use crate::material::Material;
use crate::pose::Pose;
use crate::settings::{ArticulationSettings, SleepSettings, Solver};
use crate::shape::{CollisionFilter, Shape, ShapeDef};
use crate::snapshot::forms::{KnownForms, NumberedForms};
use crate::snapshot::stored::{Reader, Stored, Writer};
use crate::snapshot::table::{Input, Output};

/// The bytes of one call.
#[derive(Default)]
pub(super) struct Log {
    bytes: Vec<u8>,
}

impl Log {
    pub(super) fn clear(&mut self) {
        self.bytes.clear();
    }

    pub(super) fn content(&self) -> &[u8] {
        &self.bytes
    }

    /// Seven bits a byte, the lowest first; the highest bit says that more follow.
    pub(super) fn number(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }

    pub(super) fn u32(&mut self, value: u32) {
        self.bytes.extend_from_slice(&value.to_le_bytes());
    }

    pub(super) fn u64(&mut self, value: u64) {
        self.bytes.extend_from_slice(&value.to_le_bytes());
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        self.number(bytes.len() as u64);
        self.bytes.extend_from_slice(bytes);
    }

    /// Arguments in a row, after the forms of shapes in them.
    pub(super) fn arguments(&mut self, arguments: &[&dyn Argument]) {
        let mut shapes = Vec::new();
        arguments.iter().for_each(|argument| argument.list_shapes(&mut shapes));
        let forms = NumberedForms::of(shapes.into_iter());
        forms.write(&mut self.bytes);
        Output::new(&mut self.bytes, &forms).row_of(|row| arguments.iter().for_each(|argument| argument.write(row)));
    }
}

/// The calls of a recording, as they are read.
pub(super) struct Pages<'a>(pub &'a [u8]);

impl<'a> Pages<'a> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    pub(super) fn number(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let [byte] = self.array()?;
            value |= u64::from(byte & 0x7f).checked_shl(shift)?;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(self.number()?).ok()?;
        let bytes = self.0.get(..length)?;
        self.0 = &self.0[length..];
        Some(bytes)
    }

    /// The arguments of a call, which `take` reads in order; handles become those of world `tag`.
    pub(super) fn arguments<T>(&mut self, tag: u16, take: impl FnOnce(&mut Reader) -> Option<T>) -> Option<T> {
        let (forms, rest) = KnownForms::read(self.0, std::iter::empty()).ok()?;
        let mut input = Input::new(rest, &forms, tag);
        let arguments = input.row_of(take)?;
        self.0 = &rest[rest.len() - input.remaining()..];
        Some(arguments)
    }
}

/// An argument of a call.
pub(super) trait Argument {
    fn list_shapes<'a>(&'a self, _shapes: &mut Vec<&'a Shape>) {}
    fn write(&self, row: &mut Writer);
}

macro_rules! plain_arguments {
    ($($type:ty),* $(,)?) => {$(
        impl Argument for $type {
            fn write(&self, row: &mut Writer) {
                self.put(row);
            }
        }
    )*};
}

plain_arguments!(
    bool,
    f32,
    [f32; 6],
    u32,
    u64,
    glam::Vec3,
    glam::DVec3,
    BodyId,
    ShapeId,
    JointId,
    BodyKind,
    LockedAxes,
    Pose,
    Mass,
    Material,
    Softness,
    CollisionFilter,
    JointDef,
    JointKind,
    SleepSettings,
    ArticulationSettings,
    LongRangeDef,
    Option<SoftBound>,
    Strength,
    FractureSettings,
    Vec<JointId>,
    Solver,
);

impl Argument for ShapeDef {
    fn list_shapes<'a>(&'a self, shapes: &mut Vec<&'a Shape>) {
        shapes.push(&self.shape);
    }
    fn write(&self, row: &mut Writer) {
        self.put(row);
    }
}

impl Argument for BodyDef {
    fn list_shapes<'a>(&'a self, shapes: &mut Vec<&'a Shape>) {
        shapes.extend(self.shapes.iter().map(|def| &def.shape));
    }
    fn write(&self, row: &mut Writer) {
        self.put(row);
    }
}

/// What a call returns, as a number that does not depend on the world it was made in.
pub(super) trait Answer {
    fn word(&self) -> u64;
}

impl Answer for () {
    fn word(&self) -> u64 {
        0
    }
}

macro_rules! handles_answer {
    ($($handle:ty),*) => {$(
        impl Answer for $handle {
            fn word(&self) -> u64 {
                without_world(*self)
            }
        }
    )*};
}

handles_answer!(BodyId, ShapeId, JointId);
