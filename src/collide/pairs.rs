//! A pair of shapes that may touch, with the contacts it had last.

use std::cmp::Ordering;

use glam::{Mat3, Quat, Vec3};
use parry3d::math::Pose3;

use super::collider::{Collider, relative};
use super::collider_state::{ColliderState, Follow};
use super::found_contacts::FoundContacts;
use super::narrow::{Manifold, ManifoldPoint, NarrowScratch, PressedNormal};
use super::persistent_manifold::{Carried, CarriedManifold, Manifolds, near, pressed, touching};
use super::predict::{self, Reach, Step};
use super::quantized_pose::{QuantizedPose, coarse, pose_unit};
use crate::body::Body;
use crate::contact::ContactImpulses;
use crate::contact::status::ContactStatus;

/// Two shapes' slots, the lower first. Beside a pair's slot in a list it takes twelve bytes, where a number of eight would take sixteen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct PairKey {
    lower: u32,
    upper: u32,
}

impl PairKey {
    pub(crate) fn new(a: u32, b: u32) -> Self {
        Self { lower: a.min(b), upper: a.max(b) }
    }

    pub(crate) fn shapes(self) -> (u32, u32) {
        (self.lower, self.upper)
    }

    /// A number that keys go by: compared as one, not as two.
    fn place(self) -> u64 {
        u64::from(self.lower) << 32 | u64::from(self.upper)
    }
}

impl Ord for PairKey {
    fn cmp(&self, other: &Self) -> Ordering {
        self.place().cmp(&other.place())
    }
}

impl PartialOrd for PairKey {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The bits of all manifolds of a pair in order, four each; [`TOO_MANY`] where there is no room for them.
pub(crate) fn pack_touching(bits: impl Iterator<Item = u8>) -> u16 {
    bits.enumerate().fold(0, |packed, (number, bits)| with_touching(packed, number, bits))
}

/// The bits of the manifolds before one, and its own.
fn with_touching(packed: u16, number: usize, bits: u8) -> u16 {
    let has_room = number < u16::BITS as usize / 4 - 1;
    if has_room { packed | u16::from(bits) << (4 * number) } else { TOO_MANY }
}

/// What [`pack_touching`] says of a pair of which it can tell nothing.
pub(crate) const TOO_MANY: u16 = u16::MAX;

/// What the support analysis has made of a pair: enough to tell that it need not be looked at again, from the pair alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Word {
    /// It has no links.
    #[default]
    Nothing,
    /// It is to be looked at, whatever happens.
    Unsettled,
    /// Its links are those of its points, and hold.
    Holds,
    /// Its one manifold slides, and was told to [rise](Told::rise) like this.
    Slides(u8),
}

/// Two shapes near each other.
///
/// A pile has ten for each of its bodies, and walks over them wait for memory: what all of them ask for comes first, the pose last.
#[derive(Debug, Clone)]
#[repr(C)]
pub(crate) struct Pair {
    pub key: PairKey,
    pub manifolds: Manifolds,
    /// Margin that the manifolds were made for, rounded as in [`rounded_up`]; [`NOT_MADE`] where they were made for none.
    pub margin: f32,
    /// Counts the manifolds that the slot has had.
    pub version: u16,
    /// Which points touched at the end of the last step, and do now, where somebody wants to know.
    pub touching: u16,
    pub touches: u16,
    /// Of a pair with one manifold: its points that are near enough to touch, as bits, and what the solver told of it last. Of others
    /// nothing is told.
    pub near: u8,
    pub told: ContactStatus,
    /// What the support analysis has made of it.
    pub word: Word,
    /// Whether the narrow phase made new manifolds in the last step.
    pub updated: bool,
    /// Whether both bodies were held, or cannot move, when the step began.
    pub still: bool,
    /// Whether any normal multiplier is positive.
    pub pressed: bool,
    /// Whether a point may close its separation within the step.
    pub may_touch: bool,
    /// Whether a normal impulse acted in the last step.
    pub in_contact: bool,
    pub active: bool,
    /// Pose of B's shape in A's that the manifolds were made for.
    pub pose: QuantizedPose,
}

// Less where addresses are short.
const _: () = assert!(size_of::<Pair>() <= 64);

/// Margin of a pair whose manifolds were made for no pose.
const NOT_MADE: f32 = -1.0;

/// Relative motion below which manifolds are kept, as translation over the smaller shape's least extent, and as rotation (rad).
///
/// Separations are those of the kept points exactly. What is wrong with them after a turn θ is where on the surfaces they should
/// be, and the normal by up to θ. Over a round surface or along an edge both matter at once. What is round itself is pushed on by what presses
/// behind its middle, and comes to roll by itself at θ a step. Between faces the points are corners: where these lie over a face is wrong by
/// θ times the gap, and how far off it by θ² of the extent, here four millionths.
const REUSE: f32 = 5.0e-4;
const REUSE_OF_ROUND: f32 = 1.0e-5;
const REUSE_OF_FACES: f32 = 2.0e-3;

/// Turn of a body in a step from which on the normal of its last contact no longer tells on which side of something fixed it is (rad): an eighth of a turn
/// more would be across it.
const STILL_THAT_SIDE: f32 = 0.8;

/// Points from which on a manifold is one of faces.
const FACE_POINTS: usize = 3;

/// Factor on relative motion in the margin that manifolds are made for, so that a slightly greater speed does not remake them.
const MARGIN_RESERVE: f32 = 1.5;

impl Pair {
    pub(crate) fn new(key: PairKey) -> Self {
        Self {
            key,
            manifolds: Manifolds::default(),
            margin: NOT_MADE,
            version: 0,
            touching: 0,
            touches: 0,
            near: 0,
            told: ContactStatus::NOTHING,
            word: Word::Nothing,
            updated: false,
            still: false,
            pressed: false,
            may_touch: false,
            in_contact: false,
            active: false,
            pose: QuantizedPose::IDENTITY,
        }
    }

    /// Brings the manifolds up to date with the bodies' poses; what else is known of shapes is asked for where they are made
    /// anew.
    pub(crate) fn update<'a>(
        &mut self,
        (a, b): (&ColliderState, &ColliderState),
        motion: f32,
        step: Step,
        moving: impl FnOnce() -> [Follow<'a>; 2],
        scratch: &mut PairScratch,
    ) {
        let still = a.contact_margin(b);
        let relative = relative((a.position, a.rotation), (b.position, b.rotation));
        let extent = a.least_extent.min(b.least_extent);
        let keeps = still + motion <= self.margin && self.is_near(&relative, extent, a.is_round || b.is_round);
        put(&mut self.updated, !keeps);
        if !keeps {
            self.version = self.version.wrapping_add(1);
            let margin = rounded_up(still + motion * MARGIN_RESERVE);
            if !(0.0..f32::INFINITY).contains(&margin) {
                // Nothing moves like that; whatever does is taken out after the step.
                return self.part();
            }
            let moving = moving();
            let reach = Reach { motion, margin, is_pressed: self.pressed, before: &self.manifolds };
            let PairScratch { narrow, manifolds, spare, .. } = scratch;
            narrow.last = (self.manifolds.len() == 1).then(|| self.manifolds.get(0).normal);
            let pressed = narrow.last.filter(|_| self.pressed);
            narrow.pressed = pressed.and_then(|normal| match [moving[0].is_free, moving[1].is_free] {
                [false, true] => Some(PressedNormal::OfA(normal)),
                // It has turned with A in the last step.
                [true, false] if moving[0].angular.length() * step.dt < STILL_THAT_SIDE => {
                    Some(PressedNormal::OfB(relative.rotation.inverse() * normal))
                }
                _ => None,
            });
            let mut found = FoundContacts { scratch: narrow, manifolds, spare };
            predict::collide((a, b), &moving, step, relative, reach, &mut found);
            self.take(&scratch.manifolds, &mut scratch.carried);
            (self.pose, self.margin) = (QuantizedPose::of(&coarse(&relative, pose_unit(extent))), margin);
        } else {
            self.manifolds.follow(&relative);
        }
        let points = self.manifolds.iter().flat_map(|manifold| manifold.points);
        put(&mut self.may_touch, points.fold(f32::INFINITY, |least, point| least.min(point.separation)) <= motion);
        self.note_near(extent);
    }

    /// Leaves a point out of the pair's contacts until they are made anew; `extent` is the lesser least extent of the two shapes (m).
    pub(crate) fn leave_out(&mut self, number: usize, point: usize, extent: f32) {
        self.manifolds.leave_out(number, point);
        self.note_near(extent);
    }

    /// Gives a manifold another normal, in A's frame, and its points other places, until it is made anew; `extent` as in [`Self::leave_out`].
    pub(crate) fn turn(&mut self, number: usize, normal: Vec3, extent: f32, moved: impl Fn(&mut ManifoldPoint)) {
        self.manifolds.turn(number, normal, moved);
        self.note_near(extent);
    }

    /// Whether the solver has told of all of it.
    pub(crate) fn is_told(&self) -> bool {
        self.active && self.told.is_known()
    }

    fn note_near(&mut self, extent: f32) {
        if self.manifolds.len() == 1 {
            put(&mut self.near, near(self.manifolds.get(0).points, extent));
        }
    }

    /// Takes note of whether neither side can move, and says so: nothing of the pair is looked at then.
    pub(crate) fn rests(&mut self, still: bool) -> bool {
        put(&mut self.still, still);
        if still {
            put(&mut self.updated, false);
        }
        still
    }

    /// Takes note that the two cannot touch in this step, and gives back the room of manifolds.
    pub(crate) fn part(&mut self) {
        let has_parted = self.margin == NOT_MADE && self.manifolds.is_empty() && !self.may_touch && !self.updated;
        if has_parted {
            return;
        }
        self.version = self.version.wrapping_add(1);
        self.manifolds = Manifolds::default();
        self.margin = NOT_MADE;
        self.may_touch = false;
        self.updated = false;
        (self.pressed, self.touches, self.told) = (false, 0, ContactStatus::NOTHING);
    }

    /// Pose and margin that the manifolds were made for, if for any.
    pub(crate) fn made_for(&self) -> Option<(Pose3, f32)> {
        (self.margin != NOT_MADE).then(|| (self.pose.exact(), self.margin))
    }

    /// Says what the manifolds were made for: a pose in steps, as [`coarse`] gives it, and a margin.
    pub(crate) fn set_made_for(&mut self, pose: &Pose3, margin: f32) {
        (self.pose, self.margin) = (QuantizedPose::of(pose), margin);
    }

    /// Whether there are contact points at all.
    pub(crate) fn has_points(&self) -> bool {
        !self.manifolds.is_empty()
    }

    pub(crate) fn is_active(&self) -> bool {
        self.active
    }

    /// Whether the pose that the manifolds were made for is near enough to this one for them to be kept; whether either shape `is_round`.
    pub(crate) fn is_near(&self, relative: &Pose3, extent: f32, is_round: bool) -> bool {
        if self.margin == NOT_MADE {
            return false;
        }
        let pose = self.pose.exact();
        let shift = (relative.translation - pose.translation).length();
        let (p, q) = (relative.rotation, pose.rotation);
        let turn = (Quat::from_xyzw(p.x, p.y, p.z, p.w) - Quat::from_xyzw(q.x, q.y, q.z, q.w)).length() * 2.0;
        let between_faces = self.manifolds.iter().all(|manifold| manifold.points.len() >= FACE_POINTS);
        let reuse = match (is_round, between_faces && !self.manifolds.is_empty()) {
            (_, true) => REUSE_OF_FACES,
            (true, false) => REUSE_OF_ROUND,
            (false, false) => REUSE,
        };
        shift <= extent * reuse && turn <= reuse
    }

    /// Takes new manifolds, with the multipliers of the old points that they continue.
    fn take(&mut self, fresh: &[Manifold], carried: &mut Vec<CarriedManifold>) {
        self.manifolds.take(fresh, carried);
        if fresh.len() != 1 {
            self.told = ContactStatus::NOTHING;
        }
        // Multipliers may have gone with the points that bore them, and the solver does not look at what neither side can move.
        if self.pressed && !self.manifolds.are_pressed() {
            (self.pressed, self.touches) = (false, 0);
        }
    }

    /// Multiplies all multipliers.
    pub(crate) fn scale_impulses(&mut self, scale: f32) {
        self.manifolds.impulses_mut().for_each(|impulses| *impulses = impulses.scaled(scale));
    }

    /// Forgets all multipliers.
    pub(crate) fn forget_impulses(&mut self) {
        self.manifolds.impulses_mut().for_each(|impulses| *impulses = ContactImpulses::default());
        (self.pressed, self.touches) = (false, 0);
    }

    /// Takes the multipliers of a manifold; manifolds come in order.
    pub(crate) fn store(&mut self, number: usize, impulses: ContactImpulses) {
        self.manifolds.set_impulses(number, impulses);
        if number == 0 {
            (self.pressed, self.touches, self.told) = (false, 0, ContactStatus::NOTHING);
        }
        self.pressed |= impulses.normal.iter().any(|&lambda| lambda > 0.0);
    }

    /// The same where somebody wants to know which points touch, with what the solver tells of it; `extent` is the lesser least extent of
    /// the two shapes (m).
    pub(crate) fn store_told(
        &mut self,
        number: usize,
        impulses: ContactImpulses,
        told: ContactStatus,
        extent: impl FnOnce() -> f32,
    ) {
        self.store(number, impulses);
        if self.manifolds.len() == 1 {
            let pressed = pressed(&impulses);
            (self.touches, self.told) = (if pressed == 0 { 0 } else { u16::from(pressed | self.near) }, told);
        } else {
            self.touches = with_touching(self.touches, number, touching(&self.manifolds.get(number), extent()));
        }
    }

    /// Brings up to date what is known of the multipliers without looking at them; `extent` is the lesser least extent of the two shapes (m).
    pub(super) fn note_pressed(&mut self, extent: f32) {
        self.pressed = self.manifolds.are_pressed();
        self.touches = pack_touching(self.manifolds.iter().map(|manifold| touching(&manifold, extent)));
        self.note_near(extent);
    }
}

/// Writes what is not there yet: a line of memory that nothing is written to need not go back to where it came from.
fn put<T: PartialEq>(place: &mut T, value: T) {
    if *place != value {
        *place = value;
    }
}

/// Bits of a margin that are not remembered.
const LOST_MARGIN_BITS: u32 = 0x1fff;

/// The least margin that is remembered and no smaller than this one (positive). Were it smaller, a pair at rest would be asked for
/// more than it was made for, and be made anew in every step.
fn rounded_up(margin: f32) -> f32 {
    f32::from_bits((margin.to_bits() + LOST_MARGIN_BITS) & !LOST_MARGIN_BITS)
}

/// Buffers that one thread of the narrow phase reuses.
#[derive(Default)]
pub(crate) struct PairScratch {
    narrow: NarrowScratch,
    manifolds: Vec<Manifold>,
    spare: Vec<Manifold>,
    carried: Vec<CarriedManifold>,
}

/// A manifold in world axes: normal, and points as levers from the two centres of mass (m).
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorldManifold {
    pub normal: Vec3,
    pub lever_a: [Vec3; 4],
    pub lever_b: [Vec3; 4],
}

impl WorldManifold {
    pub(crate) fn new(manifold: &Carried, a: (&Collider, &Body), b: (&Collider, &Body)) -> Self {
        let frame = |(collider, body): (&Collider, &Body)| (collider.offset_on(body), collider.place.1);
        Self::of(manifold, frame(a), frame(b))
    }

    /// Of shapes whose origins are so far from the centres of mass (m), and which are turned like this.
    pub(crate) fn of(manifold: &Carried, (offset_a, turn_a): (Vec3, Quat), (offset_b, turn_b): (Vec3, Quat)) -> Self {
        let (rotation_a, rotation_b) = (Mat3::from_quat(turn_a), Mat3::from_quat(turn_b));
        let mut world =
            Self { normal: (rotation_a * manifold.normal).normalize(), lever_a: [Vec3::ZERO; 4], lever_b: [Vec3::ZERO; 4] };
        for (i, point) in manifold.points.iter().enumerate() {
            world.lever_a[i] = offset_a + rotation_a * point.on_a;
            world.lever_b[i] = offset_b + rotation_b * point.on_b;
        }
        world
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_restored_pair_are_near_by_the_size_of_its_shapes() {
        let mut manifold = Manifold { normal: Vec3::Y, count: 3, ..Manifold::default() };
        for (point, separation) in manifold.points.iter_mut().zip([0.0, 2.0e-4, 2.0e-2]) {
            point.separation = separation;
        }
        let mut pair = Pair::new(PairKey::new(0, 1));
        pair.take(&[manifold], &mut Vec::new());
        let impulses = ContactImpulses { normal: [5.0, 0.0, 0.0, 0.0], ..ContactImpulses::default() };
        pair.manifolds.set_impulses(0, impulses);
        // A thousandth of 0.3 m is between the second and the third.
        pair.note_pressed(0.3);
        assert_eq!((pair.touches, pair.near), (0b11, 0b11), "points that touch, and that are near");
        // A step that wakes the pair and has not looked at it tells the same.
        pair.store_told(0, impulses, ContactStatus::of(ContactStatus::KNOWN), || 0.3);
        assert_eq!(pair.touches, 0b11, "points that touch as the solver tells");
    }
}
