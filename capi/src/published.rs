//! Arrays of the last step in C's layout.
//!
//! Each is converted when it is first asked for, and stays where it is until the next step: that is how long the host may read
//! it. A world whose host never asks pays nothing.

use std::sync::{Mutex, PoisonError};

use crate::access::Hosted;
use crate::events::{LsArticulation, LsContactPair, LsHit, LsIsland, LsJointOverload, LsJointStop, LsMoved};
use crate::fracture::{LsJointBreak, LsPiece, LsSplit};
use crate::handle::LsBody;

#[derive(Default)]
pub(crate) struct Published {
    pub moved: Array<LsMoved>,
    pub contact_began: Array<LsContactPair>,
    pub contact_ended: Array<LsContactPair>,
    pub overloaded: Array<LsJointOverload>,
    pub hits: Array<LsHit>,
    pub joint_stops: Array<LsJointStop>,
    pub sensor_began: Array<LsContactPair>,
    pub sensor_ended: Array<LsContactPair>,
    pub sensed: Array<LsContactPair>,
    pub quarantined: Array<LsBody>,
    pub articulations: Array<LsArticulation>,
    pub islands: Array<LsIsland>,
    pub broken: Array<LsJointBreak>,
    pub splits: Array<LsSplit>,
    pub pieces: Array<LsPiece>,
    pub piece_bodies: Array<LsBody>,
}

impl Published {
    /// The arrays handed out so far end here.
    pub(crate) fn expire(&mut self) {
        self.moved.expire();
        self.contact_began.expire();
        self.contact_ended.expire();
        self.overloaded.expire();
        self.hits.expire();
        self.joint_stops.expire();
        self.sensor_began.expire();
        self.sensor_ended.expire();
        self.sensed.expire();
        self.quarantined.expire();
        self.articulations.expire();
        self.islands.expire();
        self.broken.expire();
        self.splits.expire();
        self.pieces.expire();
        self.piece_bodies.expire();
    }
}

/// Where each array of the last step is, and how long it is.
macro_rules! arrays {
    ($($name:ident: $element:ty = $from:path),* $(,)?) => {
        impl Hosted {
            $(pub(crate) fn $name(&self) -> (*const $element, usize) {
                self.published.$name.get(self.world.$name().iter().map($from))
            })*
        }
    };
}

arrays!(
    moved: LsMoved = LsMoved::from,
    contact_began: LsContactPair = LsContactPair::from,
    contact_ended: LsContactPair = LsContactPair::from,
    overloaded: LsJointOverload = LsJointOverload::from,
    hits: LsHit = LsHit::from,
    joint_stops: LsJointStop = LsJointStop::from,
    sensor_began: LsContactPair = LsContactPair::from,
    sensor_ended: LsContactPair = LsContactPair::from,
    sensed: LsContactPair = LsContactPair::from,
    quarantined: LsBody = LsBody::of,
);

pub(crate) struct Array<T>(Mutex<Content<T>>);

struct Content<T> {
    current: bool,
    elements: Vec<T>,
}

impl<T> Default for Array<T> {
    fn default() -> Self {
        Self(Mutex::new(Content { current: false, elements: Vec::new() }))
    }
}

impl<T> Array<T> {
    fn expire(&mut self) {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner).current = false;
    }

    /// Where the elements are, and how many; filled from `source` if that has not happened since the last step.
    pub(crate) fn get(&self, source: impl Iterator<Item = T>) -> (*const T, usize) {
        let mut content = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !content.current {
            content.elements.clear();
            content.elements.extend(source);
            content.current = true;
        }
        (content.elements.as_ptr(), content.elements.len())
    }
}
