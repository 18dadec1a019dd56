//! The table of forms of shapes, at the start of a snapshot: what the world has already is not built again.

use std::collections::HashMap;

use glam::Vec3;

use super::forms::{KnownForms, NumberedForms};
use super::refused;
use super::stored::{Reader, Stored, Writer, stored_enum};
use super::table::{Input, Output};
use crate::error::Result;
use crate::shape::{Geometry, LocalPose, Shape};

impl NumberedForms {
    pub(crate) fn of<'a>(shapes: impl Iterator<Item = &'a Shape>) -> Self {
        let mut forms = Self::default();
        let mut by_content: HashMap<Vec<u32>, u32> = HashMap::new();
        for shape in shapes {
            let Self { by_address, distinct } = &mut forms;
            by_address.entry(shape.address()).or_insert_with(|| {
                *by_content.entry(words_of(shape)).or_insert_with(|| {
                    distinct.push(shape.clone());
                    distinct.len() as u32 - 1
                })
            });
        }
        forms
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) {
        let none = Self::default();
        let forms: Vec<Form> = self.distinct.iter().map(|shape| Form(shape.geometry().clone())).collect();
        Output::new(out, &none).table(forms.iter());
    }
}

impl KnownForms {
    /// Reads the forms at the start of `bytes`, and returns what comes after them. Those among `present` are not built anew.
    pub(crate) fn read<'a, 'b>(bytes: &'a [u8], present: impl Iterator<Item = &'b Shape>) -> Result<(Self, &'a [u8])> {
        let none = Self::default();
        let mut input = Input::new(bytes, &none, 0);
        let stored = input.table::<Form>().ok_or(refused("holds a form of a shape that makes no sense"))?;
        let (mut there, mut seen): (HashMap<Vec<u32>, &Shape>, HashMap<usize, ()>) = (HashMap::new(), HashMap::new());
        for shape in present {
            if seen.insert(shape.address(), ()).is_none() {
                there.entry(words_of(shape)).or_insert(shape);
            }
        }
        let build = |Form(geometry): Form| match there.get(&words_of_geometry(&geometry)) {
            Some(&shape) => Ok(shape.clone()),
            None => Shape::new(geometry).map_err(|_| refused("holds a form of a shape that is refused")),
        };
        let rest = &bytes[bytes.len() - input.remaining()..];
        Ok((Self(stored.into_iter().map(build).collect::<Result<_>>()?), rest))
    }
}

fn words_of(shape: &Shape) -> Vec<u32> {
    words_of_geometry(shape.geometry())
}

fn words_of_geometry(geometry: &Geometry) -> Vec<u32> {
    let none = NumberedForms::default();
    let mut out = Writer { words: Vec::new(), forms: &none };
    geometry.put(&mut out);
    out.words
}

struct Form(Geometry);

impl Stored for Form {
    fn put(&self, out: &mut Writer) {
        self.0.put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        Geometry::take(input).map(Self)
    }
}

stored_enum!(Geometry {
    0 => Ball { radius: radius },
    1 => Box { half_extents: half_extents },
    2 => Capsule { half_height: half_height, radius: radius },
    3 => Cylinder { half_height: half_height, radius: radius },
    4 => Cone { half_height: half_height, radius: radius },
    5 => ConvexHull { points: points },
    6 => TriangleMesh { vertices: vertices, triangles: triangles },
    7 => HeightField { rows: rows, columns: columns, heights: heights, size_x: size_x, size_z: size_z },
    8 => HalfSpace { normal: normal },
    9 => Compound { parts: parts },
});

impl Stored for LocalPose {
    fn put(&self, out: &mut Writer) {
        self.position.put(out);
        self.rotation.put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        Some(Self { position: Vec3::take(input)?, rotation: Stored::take(input)? })
    }
}
