//! Which number each form of a shape has in a snapshot: each distinct one is stored once.

use std::collections::HashMap;

use crate::shape::Shape;

/// Forms with their numbers, for writing. Looked up only: the order of a map never reaches a snapshot.
#[derive(Default)]
pub(crate) struct NumberedForms {
    pub(super) by_address: HashMap<usize, u32>,
    pub(super) distinct: Vec<Shape>,
}

impl NumberedForms {
    /// Number of a form that was among those given.
    pub(crate) fn number_of(&self, shape: &Shape) -> u32 {
        self.by_address.get(&shape.address()).copied().unwrap_or(u32::MAX)
    }
}

/// Forms by number, for reading.
#[derive(Default)]
pub(crate) struct KnownForms(pub(super) Vec<Shape>);

impl KnownForms {
    pub(crate) fn get(&self, number: u32) -> Option<&Shape> {
        self.0.get(number as usize)
    }
}
