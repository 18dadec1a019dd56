//! Pairs of shapes that may touch, with the contacts they had last: found by key, walked in key order.
//!
//! A pair is *active* while one of its bodies can move by itself; the pairs of a sleeping island are kept by the island.

use std::borrow::Cow;
use std::collections::BTreeMap;

use glam::{DVec3, Mat3, Quat, Vec3};
use parry3d::math::Pose3;

use super::collider::{Collider, contact_margin};
use super::narrow::{self, Manifold, ManifoldPoint, Scratch};
use crate::balance::{LoadedPoint, balance};
use crate::body::Body;
use crate::material::PairMaterial;
use crate::room::make_room_behind;
use crate::solve::contact::{ContactImpulses, tangents};

/// Two shapes' slots, the lower first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct PairKey(u64);

impl PairKey {
    pub(crate) fn new(a: u32, b: u32) -> Self {
        Self(u64::from(a.min(b)) << 32 | u64::from(a.max(b)))
    }

    pub(crate) fn shapes(self) -> (u32, u32) {
        ((self.0 >> 32) as u32, self.0 as u32)
    }
}

/// A manifold with the multipliers it had at the end of the last step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CarriedManifold {
    pub geometry: Manifold,
    pub impulses: ContactImpulses,
}

/// Separation of an unloaded point up to which it belongs to the region of a pressed face, over the smaller shape's extent.
const TOUCHING_SHARE: f32 = 1.0e-3;

/// Points of a pressed manifold that are pressed or touch, as bits; none where nothing is pressed. `extent` is the lesser least
/// extent of the two shapes (m).
pub(crate) fn touching(manifold: &CarriedManifold, extent: f32) -> u8 {
    let points = &manifold.geometry.points[..manifold.geometry.count as usize];
    let is_pressed = |i: usize| manifold.impulses.normal[i] > 0.0;
    if !(0..points.len()).any(is_pressed) {
        return 0;
    }
    let touches = |i: usize| is_pressed(i) || points[i].separation <= TOUCHING_SHARE * extent;
    (0..points.len()).fold(0, |bits, i| bits | u8::from(touches(i)) << i)
}

/// The bits of all manifolds of a pair in order, four each; [`TOO_MANY`] where there is no room for them.
pub(crate) fn pack_touching(bits: impl Iterator<Item = u8>) -> u32 {
    bits.enumerate().fold(0, |packed, (number, bits)| with_touching(packed, number, bits))
}

/// The bits of the manifolds before one, and its own.
fn with_touching(packed: u32, number: usize, bits: u8) -> u32 {
    let has_room = number < u32::BITS as usize / 4 - 1;
    if has_room { packed | u32::from(bits) << (4 * number) } else { TOO_MANY }
}

/// What [`pack_touching`] says of a pair of which it can tell nothing.
pub(crate) const TOO_MANY: u32 = u32::MAX;

/// Two shapes near each other.
///
/// A pile has ten for each of its bodies, and a dozen walks a step go over them: 136 bytes instead of 120 cost it a tenth.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    pub key: PairKey,
    pub material: PairMaterial,
    pub manifolds: Vec<CarriedManifold>,
    /// Pose of B's shape in A's, and margin, that the manifolds were made for, rounded as in [`coarse`] and [`rounded_up`].
    pub made_for: Option<(Pose3, f32)>,
    /// Whether the narrow phase made new manifolds in the last step.
    pub updated: bool,
    /// Whether both bodies were held, or cannot move, when the step began.
    pub still: bool,
    /// Counts the manifolds that the slot has had.
    pub version: u32,
    /// Lesser least extent of the two shapes (m).
    pub extent: f32,
    /// Which points touched at the end of the last step, and do now, where somebody wants to know.
    pub touching: u32,
    pub touches: u32,
    /// Whether any normal multiplier is positive.
    pub pressed: bool,
    /// Whether a point may close its separation within the step.
    pub may_touch: bool,
    /// Whether a normal impulse acted in the last step.
    pub in_contact: bool,
    /// Greatest speed at which points have approached each other in the hit under way (m/s); zero if there is none.
    pub approach: f32,
    /// Impulse along the normal in the hit under way (N·s).
    pub blow: f32,
    pub active: bool,
}

/// Relative motion below which manifolds are kept, as translation over the smaller shape's least extent, and as rotation (rad).
///
/// Separations are those of the kept points exactly. What is wrong with them after a turn θ is where on the surfaces they should
/// be, and the normal by up to θ. Over a round surface or along an edge both matter at once. Between faces the points are corners:
/// where these lie over a face is wrong by θ times the gap, and how far off it by θ² of the extent, here four millionths.
const REUSE: f32 = 5.0e-4;
const REUSE_OF_FACES: f32 = 2.0e-3;

/// Points from which on a manifold is one of faces.
const FACE_POINTS: u8 = 3;

/// Factor on relative motion in the margin that manifolds are made for, so that a slightly greater speed does not remake them.
const MARGIN_RESERVE: f32 = 1.5;

/// Cosine of the turn of a normal from which on multipliers are not carried over. Where bodies are pressed deep into one another the
/// axis of least overlap jumps, and what held up a column of falling bodies would push sideways against nothing.
const LEAST_ALIGNMENT: f32 = 0.9;

/// Share of the old multipliers that matching features must have taken for them to be kept point by point.
const ALL_TAKEN: f32 = 0.999;

impl Pair {
    pub(crate) fn new(key: PairKey, material: PairMaterial) -> Self {
        Self {
            key,
            material,
            manifolds: Vec::new(),
            made_for: None,
            updated: false,
            still: false,
            version: 0,
            extent: 0.0,
            touching: 0,
            touches: 0,
            pressed: false,
            may_touch: false,
            in_contact: false,
            approach: 0.0,
            blow: 0.0,
            active: false,
        }
    }

    /// Brings the manifolds up to date with the bodies' poses.
    pub(crate) fn update(&mut self, a: &Collider, b: &Collider, motion: f32, scratch: &mut PairScratch) {
        let still = contact_margin(a, b);
        let relative = a.relative(b);
        self.extent = a.least_extent.min(b.least_extent);
        self.updated = !self.still_good(&relative, still + motion, self.extent);
        if self.updated {
            self.version = self.version.wrapping_add(1);
            let margin = rounded_up(still + motion * MARGIN_RESERVE);
            if !(0.0..f32::INFINITY).contains(&margin) {
                // Nothing moves like that; whatever does is taken out after the step.
                return self.part();
            }
            narrow::collide(&a.shape, &b.shape, relative, margin, &mut scratch.narrow, &mut scratch.manifolds);
            self.carry_over(&scratch.manifolds, &mut scratch.carried);
            self.made_for = Some((coarse(&relative, pose_unit(a, b)), margin));
        } else {
            self.follow(&relative);
        }
        let points = self.manifolds.iter().flat_map(|m| &m.geometry.points[..m.geometry.count as usize]);
        self.may_touch = points.fold(f32::INFINITY, |least, point| least.min(point.separation)) <= motion;
    }

    /// Takes note that the two cannot touch in this step, and gives back the room of manifolds.
    pub(crate) fn part(&mut self) {
        self.version = self.version.wrapping_add(1);
        self.manifolds = Vec::new();
        self.made_for = None;
        self.may_touch = false;
        self.updated = false;
        (self.pressed, self.touches) = (false, 0);
    }

    /// Whether there are contact points at all.
    pub(crate) fn has_points(&self) -> bool {
        !self.manifolds.is_empty()
    }

    pub(crate) fn is_active(&self) -> bool {
        self.active
    }

    /// Whether the relative pose is close enough to the one the manifolds were made for, and the margin no larger.
    fn still_good(&self, relative: &Pose3, margin: f32, extent: f32) -> bool {
        self.made_for.is_some_and(|(_, made_with)| margin <= made_with) && self.is_near(relative, extent)
    }

    /// Whether the pose that the manifolds were made for is near enough to this one for them to be kept.
    pub(crate) fn is_near(&self, relative: &Pose3, extent: f32) -> bool {
        let Some((made_for, _)) = &self.made_for else {
            return false;
        };
        let shift = (relative.translation - made_for.translation).length();
        let (p, q) = (relative.rotation, made_for.rotation);
        let turn = (Quat::from_xyzw(p.x, p.y, p.z, p.w) - Quat::from_xyzw(q.x, q.y, q.z, q.w)).length() * 2.0;
        let between_faces = self.manifolds.iter().all(|manifold| manifold.geometry.count >= FACE_POINTS);
        let reuse = if between_faces && !self.manifolds.is_empty() { REUSE_OF_FACES } else { REUSE };
        shift <= extent * reuse && turn <= reuse
    }

    /// Moves the kept points with the shapes: their separations follow, the points stay where they are on the surfaces.
    fn follow(&mut self, relative: &Pose3) {
        for manifold in &mut self.manifolds {
            let normal = manifold.geometry.normal;
            for point in &mut manifold.geometry.points[..manifold.geometry.count as usize] {
                let on_b = relative.rotation * point.on_b + relative.translation;
                point.separation = normal.dot(on_b - point.on_a);
            }
        }
    }

    /// Takes new manifolds, with the multipliers of the old points that they continue.
    fn carry_over(&mut self, fresh: &[Manifold], carried: &mut Vec<CarriedManifold>) {
        carried.clear();
        carried.extend(fresh.iter().map(|manifold| {
            let old = self.manifolds.iter().find(|old| old.geometry.part == manifold.part);
            let impulses = old.map_or(ContactImpulses::default(), |old| continued(old, manifold));
            CarriedManifold { geometry: *manifold, impulses }
        }));
        // Old and new are never here together: most pairs that touch have one manifold, and room for that alone.
        self.manifolds.clear();
        self.manifolds.reserve_exact(carried.len());
        self.manifolds.extend_from_slice(carried);
        if carried.is_empty() {
            (self.pressed, self.touches) = (false, 0);
        }
    }

    /// Multiplies all multipliers.
    pub(crate) fn scale_impulses(&mut self, scale: f32) {
        for manifold in &mut self.manifolds {
            manifold.impulses = manifold.impulses.scaled(scale);
        }
    }

    /// Forgets all multipliers.
    pub(crate) fn forget_impulses(&mut self) {
        for manifold in &mut self.manifolds {
            manifold.impulses = ContactImpulses::default();
        }
        (self.pressed, self.touches) = (false, 0);
    }

    /// Takes the multipliers of a manifold; manifolds come in order. `is_judged` says whether somebody wants to know which points touch.
    pub(crate) fn store(&mut self, number: usize, impulses: ContactImpulses, is_judged: bool) {
        let carried = &mut self.manifolds[number];
        carried.impulses = impulses;
        if number == 0 {
            (self.pressed, self.touches) = (false, 0);
        }
        self.pressed |= impulses.normal.iter().any(|&lambda| lambda > 0.0);
        if is_judged {
            self.touches = with_touching(self.touches, number, touching(carried, self.extent));
        }
    }

    /// Brings up to date what is known of the multipliers without looking at them.
    fn note_pressed(&mut self) {
        self.pressed = self.manifolds.iter().any(|manifold| manifold.impulses.normal.iter().any(|&lambda| lambda > 0.0));
        self.touches = pack_touching(self.manifolds.iter().map(|manifold| touching(manifold, self.extent)));
    }
}

/// Steps of the pose that a pair remembers, in shares of the smaller shape's extent and in radians: an eighth or a fourth of what it
/// is compared by, so that a pair at rest takes a few bits of a snapshot.
const SHIFT_STEP: f32 = 1.0 / 8192.0;
pub(crate) const TURN_STEP: f32 = 1.0 / 16384.0;

/// Bits of a margin that are not remembered.
const LOST_MARGIN_BITS: u32 = 0x1fff;

/// Step of the translation that a pair of these shapes remembers (m), a power of two; the rotation's is [`TURN_STEP`].
pub(crate) fn pose_unit(a: &Collider, b: &Collider) -> f32 {
    const EXPONENT: u32 = 0x7f80_0000;
    f32::from_bits(a.least_extent.min(b.least_extent).to_bits() & EXPONENT) * SHIFT_STEP
}

/// A pose in steps of `unit` and [`TURN_STEP`].
pub(crate) fn coarse(pose: &Pose3, unit: f32) -> Pose3 {
    let (p, q) = (pose.translation, pose.rotation);
    let turn = |x: f32| in_steps(x, TURN_STEP);
    Pose3::from_parts(
        Vec3::from_array(p.to_array().map(|x| in_steps(x, unit))),
        Quat::from_xyzw(turn(q.x), turn(q.y), turn(q.z), turn(q.w)),
    )
}

fn in_steps(x: f32, unit: f32) -> f32 {
    // Added to a number whose last bit is one, a float is rounded to whole numbers.
    const ONES: f32 = 12_582_912.0;
    let steps = x / unit;
    if steps.abs() < 4.0e6 { ((steps + ONES) - ONES) * unit } else { x }
}

/// The least margin that is remembered and no smaller than this one (positive). Were it smaller, a pair at rest would be asked for
/// more than it was made for, and be made anew in every step.
fn rounded_up(margin: f32) -> f32 {
    f32::from_bits((margin.to_bits() + LOST_MARGIN_BITS) & !LOST_MARGIN_BITS)
}

/// Multipliers of `old` for the points of `new`: point by point where features match, or else the same force and moments.
///
/// Two faces cross in up to eight points, of which four are kept; which four may change with the last bit. A point that took
/// its multiplier with it would leave the others to find the load again, and a tower shakes itself down.
fn continued(old: &CarriedManifold, new: &Manifold) -> ContactImpulses {
    let old_points = &old.geometry.points[..old.geometry.count as usize];
    let new_points = &new.points[..new.count as usize];
    let mut impulses = ContactImpulses { normal: [0.0; 4], ..old.impulses };
    let mut taken = 0.0;
    for (point, normal) in new_points.iter().zip(&mut impulses.normal) {
        if let Some(j) = old_points.iter().position(|old| old.feature == point.feature) {
            *normal = old.impulses.normal[j];
            taken += *normal;
        }
    }
    let total: f32 = old.impulses.normal[..old_points.len()].iter().sum();
    if total == 0.0 || old.geometry.normal.dot(new.normal) < LEAST_ALIGNMENT {
        return ContactImpulses::default();
    }
    if taken < total * ALL_TAKEN {
        impulses.normal = spread(old, new_points);
    }
    impulses
}

/// The old multipliers' force and moments on the new points.
fn spread(old: &CarriedManifold, new_points: &[ManifoldPoint]) -> [f32; 4] {
    let (u, v) = tangents(old.geometry.normal);
    let column = |point: &ManifoldPoint| DVec3::new(1.0, f64::from(point.on_a.dot(u)), f64::from(point.on_a.dot(v)));
    let old_points = &old.geometry.points[..old.geometry.count as usize];
    // About the centre of the new points, so that the moments are those of small levers.
    let center = new_points.iter().map(column).sum::<DVec3>() / new_points.len() as f64;
    let about_center = |point: &ManifoldPoint| column(point) - DVec3::new(0.0, center.y, center.z);
    let demand =
        old_points.iter().zip(&old.impulses.normal).map(|(point, &lambda)| about_center(point) * f64::from(lambda)).sum();
    let mut loaded = [LoadedPoint::new(DVec3::ZERO); 4];
    for (loaded, point) in loaded.iter_mut().zip(new_points) {
        *loaded = LoadedPoint::new(about_center(point));
    }
    balance(&mut loaded[..new_points.len()], demand);
    loaded.map(|point| point.force as f32)
}

/// Buffers that one thread of the narrow phase reuses.
#[derive(Default)]
pub(crate) struct PairScratch {
    narrow: Scratch,
    manifolds: Vec<Manifold>,
    carried: Vec<CarriedManifold>,
}

/// All pairs of a world.
#[derive(Debug, Default)]
pub(crate) struct PairCache {
    pairs: Vec<Pair>,
    free: Vec<u32>,
    /// Active pairs in key order, and what edits have given up since it was last [settled](Self::settle).
    active: Vec<(PairKey, u32)>,
    /// How many of those were given up, and what edits have made active instead.
    gone: usize,
    woken: BTreeMap<PairKey, u32>,
    /// Slots given up and not yet [forgotten](Self::forget_released), where somebody wants to know.
    released: Option<Vec<u32>>,
}

impl PairCache {
    /// A cache of active pairs, sorted by key, and of pairs that sleep, which take the slots after them; `None` if not sorted.
    pub(crate) fn from_parts(active: Vec<Pair>, asleep: Vec<Pair>) -> Option<Self> {
        if !active.windows(2).all(|two| two[0].key < two[1].key) {
            return None;
        }
        let keys = active.iter().enumerate().map(|(slot, pair)| (pair.key, slot as u32)).collect();
        let mut pairs = active;
        pairs.iter_mut().for_each(|pair| pair.active = true);
        pairs.extend(asleep);
        pairs.iter_mut().for_each(Pair::note_pressed);
        Some(Self { pairs, active: keys, ..Self::default() })
    }

    /// Every slot of the cache, also those not in use.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Pair> {
        self.pairs.iter()
    }

    /// Active pairs, in key order; as they were before edits since [`settle`](Self::settle).
    pub(crate) fn active(&self) -> &[(PairKey, u32)] {
        debug_assert!(self.is_settled(), "stages of a step begin with settled pairs");
        &self.active
    }

    /// Active pairs, in key order, also between steps.
    pub(crate) fn listed(&self) -> Cow<'_, [(PairKey, u32)]> {
        if self.is_settled() {
            return Cow::Borrowed(&self.active);
        }
        let mut listed: Vec<(PairKey, u32)> = self.active.iter().copied().filter(|&(_, slot)| self.get(slot).active).collect();
        listed.extend(self.woken.iter().map(|(&key, &slot)| (key, slot)));
        listed.sort_unstable();
        Cow::Owned(listed)
    }

    /// Brings the list of active pairs up to date with edits.
    ///
    /// Each edit touches few pairs of very many: it leaves a mark, and the list is gone through once for all of them.
    pub(crate) fn settle(&mut self) {
        if std::mem::take(&mut self.gone) > 0 {
            let pairs = &self.pairs;
            self.active.retain(|&(_, slot)| pairs[slot as usize].active);
        }
        if !self.woken.is_empty() {
            let woken: Vec<(PairKey, u32)> = std::mem::take(&mut self.woken).into_iter().collect();
            self.merge(&woken);
        }
    }

    /// Puts slots in the order in which pairs are gone through, if they are much out of it, and says where each has gone.
    ///
    /// Pairs come and go, and slots are used again: after a while each pair is a read from another place of memory, a dozen times a
    /// step.
    pub(crate) fn tidy(&mut self) -> Option<Vec<u32>> {
        self.settle();
        let out_of_order = self.active.windows(2).filter(|two| two[0].1 > two[1].1).count();
        if self.active.len() < LEAST_TIDIED || out_of_order as f32 <= MOST_OUT_OF_ORDER * self.active.len() as f32 {
            return None;
        }
        const NONE: u32 = u32::MAX;
        let mut places = vec![NONE; self.pairs.len()];
        for ((_, slot), place) in self.active.iter_mut().zip(0..) {
            places[*slot as usize] = place;
            *slot = place;
        }
        let others = places.iter_mut().filter(|place| **place == NONE);
        others.zip(self.active.len() as u32..).for_each(|(place, next)| *place = next);
        put_in_places(&mut self.pairs, &places);
        for slot in self.free.iter_mut().chain(self.released.iter_mut().flatten()) {
            *slot = places[*slot as usize];
        }
        Some(places)
    }

    fn is_settled(&self) -> bool {
        self.gone == 0 && self.woken.is_empty()
    }

    /// Slot of an active pair, also between steps.
    pub(crate) fn find(&self, key: PairKey) -> Option<u32> {
        let listed = self.active.binary_search_by_key(&key, |&(key, _)| key).ok().map(|place| self.active[place].1);
        listed.filter(|&slot| self.get(slot).active).or_else(|| self.woken.get(&key).copied())
    }

    /// Gives up an active pair, also between steps.
    pub(crate) fn give_up(&mut self, slot: u32) {
        let key = self.get(slot).key;
        if self.woken.remove(&key).is_none() {
            self.gone += 1;
        }
        self.release(slot);
    }

    pub(crate) fn get(&self, slot: u32) -> &Pair {
        &self.pairs[slot as usize]
    }

    pub(crate) fn get_mut(&mut self, slot: u32) -> &mut Pair {
        &mut self.pairs[slot as usize]
    }

    /// Calls `f` for every active pair, in key order.
    pub(crate) fn for_each_active(&mut self, mut f: impl FnMut(&mut Pair)) {
        self.settle();
        for &(_, slot) in &self.active {
            f(&mut self.pairs[slot as usize]);
        }
    }

    /// Every slot of the cache, also those not in use or asleep; see [`is_active`](Self::is_active).
    pub(crate) fn slots_mut(&mut self) -> &mut [Pair] {
        &mut self.pairs
    }

    /// Adds those of `keys` (sorted, without repeats) that are not active yet; `material` combines the surfaces of a pair.
    pub(crate) fn activate_new(&mut self, keys: &[PairKey], material: impl Fn(PairKey) -> PairMaterial) {
        if keys.is_empty() {
            return;
        }
        self.settle();
        let mut fresh = Vec::new();
        for &key in keys {
            if self.active.binary_search_by_key(&key, |&(key, _)| key).is_err() {
                fresh.push((key, self.allocate(key, material(key))));
            }
        }
        self.merge(&fresh);
    }

    /// Makes pairs active again that a sleeping island kept. Dropped are those that were found anew meanwhile, and those of which
    /// one side has gone: `material` combines the surfaces of a pair that still is one.
    pub(crate) fn activate_kept(&mut self, slots: &[u32], material: impl Fn(PairKey) -> Option<PairMaterial>) {
        for &slot in slots {
            let key = self.pairs[slot as usize].key;
            match material(key).filter(|_| self.find(key).is_none()) {
                None => self.release(slot),
                Some(material) => {
                    let pair = &mut self.pairs[slot as usize];
                    (pair.active, pair.still, pair.material) = (true, false, material);
                    self.woken.insert(key, slot);
                }
            }
        }
    }

    /// Keeps the active pairs that `keep` says; `drop_or_store` takes the others and says whether their slot lives on.
    pub(crate) fn retain_active(&mut self, mut fate: impl FnMut(PairKey, u32, &Pair) -> Fate) {
        self.settle();
        let mut active = std::mem::take(&mut self.active);
        active.retain(|&(key, slot)| match fate(key, slot, &self.pairs[slot as usize]) {
            Fate::Stay => true,
            Fate::Store => {
                self.pairs[slot as usize].active = false;
                false
            }
            Fate::Drop => {
                self.release(slot);
                false
            }
        });
        self.active = active;
    }

    /// Gives a slot back, and the room of its manifolds: three of four pairs never touch.
    pub(crate) fn release(&mut self, slot: u32) {
        let pair = &mut self.pairs[slot as usize];
        pair.manifolds = Vec::new();
        pair.active = false;
        self.free.push(slot);
        if let Some(released) = &mut self.released {
            released.push(slot);
        }
    }

    /// Notes which slots are given up from now on, or no longer.
    pub(crate) fn follow_releases(&mut self, on: bool) {
        self.released = on.then(Vec::new);
    }

    /// Slots that were given up; some may be those of other pairs by now.
    pub(crate) fn released(&self) -> &[u32] {
        self.released.as_deref().unwrap_or(&[])
    }

    /// Forgets which slots were given up.
    pub(crate) fn forget_released(&mut self) {
        if let Some(released) = &mut self.released {
            released.clear();
        }
    }

    /// Whether a slot still is that of a pair, active or asleep, that has contacts.
    pub(crate) fn holds(&self, slot: u32, key: PairKey) -> bool {
        let pair = &self.pairs[slot as usize];
        pair.key == key && !pair.manifolds.is_empty()
    }

    fn allocate(&mut self, key: PairKey, material: PairMaterial) -> u32 {
        match self.free.pop() {
            Some(slot) => {
                let version = self.pairs[slot as usize].version.wrapping_add(1);
                self.pairs[slot as usize] = Pair { version, ..Pair::new(key, material) };
                slot
            }
            None => {
                make_room_behind(&mut self.pairs, 1);
                self.pairs.push(Pair::new(key, material));
                self.pairs.len() as u32 - 1
            }
        }
    }

    fn merge(&mut self, fresh: &[(PairKey, u32)]) {
        if fresh.is_empty() {
            return;
        }
        for &(_, slot) in fresh {
            self.pairs[slot as usize].active = true;
        }
        let mut old = self.active.len();
        make_room_behind(&mut self.active, fresh.len());
        self.active.extend_from_slice(fresh);
        // From the last to the first, so that nothing is written over before it is read.
        for (number, &next) in fresh.iter().enumerate().rev() {
            while old > 0 && self.active[old - 1].0 > next.0 {
                self.active[old + number] = self.active[old - 1];
                old -= 1;
            }
            self.active[old + number] = next;
        }
    }
}

/// Active pairs from which on their order in memory matters, and share of them that may come before the one before them.
const LEAST_TIDIED: usize = 2048;
const MOST_OUT_OF_ORDER: f32 = 0.2;

/// Moves every item to its place.
pub(crate) fn put_in_places<T>(items: &mut [T], places: &[u32]) {
    let mut places = places.to_vec();
    for i in 0..items.len() {
        while places[i] as usize != i {
            let place = places[i] as usize;
            items.swap(i, place);
            places.swap(i, place);
        }
    }
}

/// What becomes of an active pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fate {
    /// Stays active.
    Stay,
    /// Leaves the active list; somebody else keeps its slot.
    Store,
    /// Is given up.
    Drop,
}

/// A manifold in world axes: normal, and points as levers from the two centres of mass (m).
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorldManifold {
    pub normal: Vec3,
    pub lever_a: [Vec3; 4],
    pub lever_b: [Vec3; 4],
}

impl WorldManifold {
    pub(crate) fn new(manifold: &Manifold, a: (&Collider, &Body), b: (&Collider, &Body)) -> Self {
        let frame = |(collider, body): (&Collider, &Body)| {
            let offset = body.rotation * (collider.local_pose.position - body.local_center);
            (offset, Mat3::from_quat(collider.place.1))
        };
        let ((offset_a, rotation_a), (offset_b, rotation_b)) = (frame(a), frame(b));
        let mut world =
            Self { normal: (rotation_a * manifold.normal).normalize(), lever_a: [Vec3::ZERO; 4], lever_b: [Vec3::ZERO; 4] };
        for (i, point) in manifold.points[..manifold.count as usize].iter().enumerate() {
            world.lever_a[i] = offset_a + rotation_a * point.on_a;
            world.lever_b[i] = offset_b + rotation_b * point.on_b;
        }
        world
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressed(normal: Vec3) -> Manifold {
        let mut manifold = Manifold { normal, count: 1, ..Manifold::default() };
        manifold.points[0].feature = 7;
        manifold
    }

    #[test]
    fn a_multiplier_stays_with_its_direction() {
        let impulses = ContactImpulses { normal: [5.0, 0.0, 0.0, 0.0], friction: Vec3::X, ..ContactImpulses::default() };
        let old = CarriedManifold { geometry: pressed(Vec3::Y), impulses };
        let after_turn = |degrees: f32| continued(&old, &pressed(Quat::from_rotation_z(degrees.to_radians()) * Vec3::Y));
        assert_eq!(after_turn(0.0), impulses);
        assert_eq!(after_turn(10.0), impulses);
        // The axis of least overlap has jumped from one face to the next.
        assert_eq!(after_turn(90.0), ContactImpulses::default());
        assert_eq!(after_turn(180.0), ContactImpulses::default());
    }
}
