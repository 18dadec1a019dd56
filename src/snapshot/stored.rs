//! Types that a snapshot stores as rows of words.

use glam::{DVec3, Quat, Vec3};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose3;

use super::forms::{KnownForms, NumberedForms};
use crate::id::{BodyId, Handle, JointId, ShapeId};
use crate::shape::Shape;

/// Rows are written here.
pub(crate) struct Writer<'a> {
    pub words: Vec<u32>,
    pub forms: &'a NumberedForms,
}

impl Writer<'_> {
    pub(crate) fn put(&mut self, word: u32) {
        self.words.push(word);
    }
}

/// A row is read from here; `None` from any of it means that the row makes no sense.
pub(crate) struct Reader<'a> {
    pub words: &'a [u32],
    pub forms: &'a KnownForms,
    /// Number of the world that is read into: handles get it.
    pub tag: u16,
    /// Lists inside lists that are being read.
    pub depth: u32,
    /// How many numbers runs may still stand for, in all rows together.
    pub numbers_left: &'a mut u64,
}

impl Reader<'_> {
    pub(crate) fn take(&mut self) -> Option<u32> {
        let (&first, rest) = self.words.split_first()?;
        self.words = rest;
        Some(first)
    }
}

/// Deepest nesting of lists; nothing that is stored goes deeper, and what is made up must not exhaust the stack.
const MAX_DEPTH: u32 = 4;

/// A value that a snapshot holds, as words.
pub(crate) trait Stored: Sized {
    /// What is stored, by name.
    const FIELDS: &'static str = "";
    /// Whether rows of it all have as many words as the first.
    const FIXED: bool = false;
    fn put(&self, out: &mut Writer);
    fn take(input: &mut Reader) -> Option<Self>;
}

/// Stores a struct field by field. Every field is named: those that are stored, and those that are made anew with the value they
/// get. A field that is not named does not compile.
macro_rules! stored {
    (fixed $name:ident { $($field:ident),* $(,)? }) => {
        impl $crate::snapshot::stored::Stored for $name {
            const FIELDS: &'static str = stringify!($name { $($field),* });
            const FIXED: bool = true;
            fn put(&self, out: &mut $crate::snapshot::stored::Writer) {
                let Self { $($field,)* } = self;
                $($crate::snapshot::stored::Stored::put($field, out);)*
            }
            fn take(input: &mut $crate::snapshot::stored::Reader) -> Option<Self> {
                Some(Self { $($field: $crate::snapshot::stored::Stored::take(input)?,)* })
            }
        }
    };
    ($(#[$meta:meta])* $name:ident { $($field:ident),* $(,)? } $(anew { $($anew:ident: $value:expr),* $(,)? })?) => {
        impl $crate::snapshot::stored::Stored for $name {
            const FIELDS: &'static str = stringify!($name { $($field),* });
            fn put(&self, out: &mut $crate::snapshot::stored::Writer) {
                let Self { $($field,)* $($($anew: _,)*)? } = self;
                $($crate::snapshot::stored::Stored::put($field, out);)*
            }
            fn take(input: &mut $crate::snapshot::stored::Reader) -> Option<Self> {
                Some(Self {
                    $($field: $crate::snapshot::stored::Stored::take(input)?,)*
                    $($($anew: $value,)*)?
                })
            }
        }
    };
}
pub(crate) use stored;

/// Stores an enum: a number for each variant, then its fields. A variant that is not named does not compile.
macro_rules! stored_enum {
    ($name:ident { $($number:literal => $variant:ident { $($field:tt: $local:ident),* }),* $(,)? }) => {
        impl $crate::snapshot::stored::Stored for $name {
            fn put(&self, out: &mut $crate::snapshot::stored::Writer) {
                match self {
                    $(Self::$variant { $($field: $local),* } => {
                        out.put($number);
                        $($crate::snapshot::stored::Stored::put($local, out);)*
                    })*
                }
            }
            fn take(input: &mut $crate::snapshot::stored::Reader) -> Option<Self> {
                Some(match input.take()? {
                    $($number => Self::$variant { $($field: $crate::snapshot::stored::Stored::take(input)?),* },)*
                    _ => return None,
                })
            }
        }
    };
}
pub(crate) use stored_enum;

macro_rules! stored_as_bits {
    ($($type:ty: |$value:ident| $to:expr, |$word:ident| $from:expr;)*) => {$(
        impl Stored for $type {
            fn put(&self, out: &mut Writer) {
                let $value = *self;
                out.put($to);
            }
            fn take(input: &mut Reader) -> Option<Self> {
                let $word = input.take()?;
                $from
            }
        }
    )*};
}

stored_as_bits! {
    u32: |value| value, |word| Some(word);
    u8: |value| u32::from(value), |word| u8::try_from(word).ok();
    bool: |value| u32::from(value), |word| (word < 2).then_some(word == 1);
    f32: |value| value.to_bits(), |word| Some(f32::from_bits(word));
}

impl Stored for u64 {
    fn put(&self, out: &mut Writer) {
        out.put((*self >> 32) as u32);
        out.put(*self as u32);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        Some(u64::from(input.take()?) << 32 | u64::from(input.take()?))
    }
}

impl Stored for usize {
    fn put(&self, out: &mut Writer) {
        (*self as u64).put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        usize::try_from(u64::take(input)?).ok()
    }
}

impl Stored for f64 {
    fn put(&self, out: &mut Writer) {
        self.to_bits().put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        u64::take(input).map(f64::from_bits)
    }
}

impl<T: Stored> Stored for Option<T> {
    fn put(&self, out: &mut Writer) {
        self.is_some().put(out);
        if let Some(value) = self {
            value.put(out);
        }
    }
    fn take(input: &mut Reader) -> Option<Self> {
        if bool::take(input)? { Some(Some(T::take(input)?)) } else { Some(None) }
    }
}

impl<T: Stored> Stored for Box<T> {
    fn put(&self, out: &mut Writer) {
        (**self).put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        T::take(input).map(Box::new)
    }
}

impl<A: Stored, B: Stored> Stored for (A, B) {
    fn put(&self, out: &mut Writer) {
        self.0.put(out);
        self.1.put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        Some((A::take(input)?, B::take(input)?))
    }
}

impl<T: Stored + Copy + Default, const N: usize> Stored for [T; N] {
    fn put(&self, out: &mut Writer) {
        self.iter().for_each(|value| value.put(out));
    }
    fn take(input: &mut Reader) -> Option<Self> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = T::take(input)?;
        }
        Some(values)
    }
}

impl<T: Stored> Stored for Vec<T> {
    fn put(&self, out: &mut Writer) {
        out.put(self.len() as u32);
        self.iter().for_each(|value| value.put(out));
    }
    fn take(input: &mut Reader) -> Option<Self> {
        // Every element takes a word or more, so that a length out of thin air reserves nothing.
        let len = input.take()? as usize;
        if len > input.words.len() || input.depth >= MAX_DEPTH {
            return None;
        }
        input.depth += 1;
        let values = (0..len).map(|_| T::take(input)).collect();
        input.depth -= 1;
        values
    }
}

macro_rules! stored_as_array {
    ($($type:ty: $array:ty, |$value:ident| $to:expr, |$read:ident| $from:expr;)*) => {$(
        impl Stored for $type {
            fn put(&self, out: &mut Writer) {
                let $value = self;
                let array: $array = $to;
                array.put(out);
            }
            fn take(input: &mut Reader) -> Option<Self> {
                let $read = <$array>::take(input)?;
                Some($from)
            }
        }
    )*};
}

stored_as_array! {
    Vec3: [f32; 3], |v| v.to_array(), |a| Vec3::from_array(a);
    DVec3: [f64; 3], |v| v.to_array(), |a| DVec3::from_array(a);
    Quat: [f32; 4], |q| q.to_array(), |a| Quat::from_array(a);
    Pose3: (Vec3, Quat), |p| (p.translation, p.rotation), |a| Pose3::from_parts(a.0, a.1);
    Aabb: (Vec3, Vec3), |b| (b.mins, b.maxs), |a| Aabb { mins: a.0, maxs: a.1 };
}

macro_rules! stored_handles {
    ($($handle:ty),*) => {$(
        impl Stored for $handle {
            fn put(&self, out: &mut Writer) {
                crate::id::without_world(*self).put(out);
            }
            fn take(input: &mut Reader) -> Option<Self> {
                let bits = u64::take(input)?;
                Some(crate::id::in_world(<$handle as Handle>::from_bits(bits), input.tag))
            }
        }
    )*};
}

stored_handles!(BodyId, ShapeId, JointId);

impl Stored for Shape {
    fn put(&self, out: &mut Writer) {
        out.forms.number_of(self).put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        let number = input.take()?;
        input.forms.get(number).cloned()
    }
}
