//! Pairs with their contacts as three tables, rows of one length each: pairs, their manifolds, the manifolds' points.
//!
//! Much of a pair follows all but exactly from the rest, and is stored as the difference from what would be expected: the pose that
//! manifolds were made for is mostly a few steps from the pose of now, and a point on B is, counted in steps from one float to the next,
//! near the one on A moved along the normal by the separation. Whoever reads expects the same, bit for bit.

use glam::{Quat, Vec3};
use parry3d::math::Pose3;

use super::stored::{Reader, Stored, Writer, stored};
use super::table::{Input, Output};
use crate::collide::active_hits::ActiveHit;
use crate::collide::cache::PairCache;
use crate::collide::collider::Collider;
use crate::collide::narrow::{Manifold, ManifoldPoint};
use crate::collide::pairs::{Pair, PairKey};
use crate::collide::persistent_manifold::{Carried, CarriedManifold, Manifolds};
use crate::collide::quantized_pose::{TURN_STEP, coarse, pose_unit};
use crate::id::{Pool, ShapeId};
use crate::solve::contact::ContactImpulses;

/// A pair without its manifolds.
pub(crate) struct PairRow {
    key: PairKey,
    /// Whether it may touch, is in contact, has a pose it was made for, and whether that is a far one; then its manifolds.
    info: u32,
    /// Steps of the pose it was made for from the pose of now, as many bits for each number as [`STEP_BITS`] says; 0 if far.
    steps: u32,
    /// Bits of the margin, without those that are always 0.
    margin: u32,
    /// Speed and impulse of the hit under way.
    approach: f32,
    blow: f32,
}

/// A pose that a pair was made for and whose steps do not fit: its numbers against those of now.
pub(crate) struct FarPose([Steps; 7]);

impl FarPose {
    pub(crate) const FIELDS: &str = "FarPose";
}

const MAY_TOUCH: u32 = 1;
const IN_CONTACT: u32 = 2;
const HAS_POSE: u32 = 4;
const FAR_POSE: u32 = 8;
const MANIFOLDS: u32 = 16;

/// Bits of each number's steps: a pose that is near differs by less in each.
const STEP_BITS: [u32; 7] = [5, 5, 5, 4, 4, 4, 4];

/// Bits that a margin never has.
const MARGIN_SHIFT: u32 = 13;

/// A manifold without its points.
pub(crate) struct ManifoldRow {
    count: u8,
    part: u32,
    normal: Vec3,
    friction: Vec3,
    twist: f32,
    rolling: Vec3,
}

/// A point of a manifold, with its multiplier.
pub(crate) struct PointRow {
    feature: u32,
    separation: f32,
    impulse: f32,
    on_a: Vec3,
    /// Against what follows from the point on A.
    on_b: [Steps; 3],
}

stored!(fixed PairRow { key, info, steps, margin, approach, blow });
stored!(fixed ManifoldRow { count, part, normal, friction, twist, rolling });
stored!(fixed PointRow { feature, separation, impulse, on_a, on_b });

/// How many floats lie between what is expected and what is, small numbers for small differences of either sign.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Steps(u32);

impl Steps {
    fn between(expected: f32, actual: f32) -> Self {
        let difference = place(actual).wrapping_sub(place(expected));
        Self(((difference << 1) ^ (difference >> 31)) as u32)
    }

    fn from(self, expected: f32) -> f32 {
        let difference = (self.0 >> 1) as i32 ^ -((self.0 & 1) as i32);
        // The places of floats are those of their bits, once the negative ones are turned round: the same turn leads back.
        f32::from_bits(turned(place(expected).wrapping_add(difference)) as u32)
    }
}

/// Place of a float in the order of all floats.
fn place(value: f32) -> i32 {
    turned(value.to_bits() as i32)
}

fn turned(bits: i32) -> i32 {
    bits ^ (((bits >> 31) as u32) >> 1) as i32
}

impl Stored for FarPose {
    const FIXED: bool = true;
    fn put(&self, out: &mut Writer) {
        self.0.put(out);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        Stored::take(input).map(Self)
    }
}

impl Stored for Steps {
    fn put(&self, out: &mut Writer) {
        out.put(self.0);
    }
    fn take(input: &mut Reader) -> Option<Self> {
        input.take().map(Self)
    }
}

/// Writes the pairs in these slots with all they carry. The pose that manifolds were made for is among that even where it is so far from that of
/// now that the next step would make them anew: an edit before it may put a body to sleep, which is looked at only after it has moved on, or
/// back where it came from.
pub(crate) fn write(
    tables: &mut Output,
    (pairs, slots): (&PairCache, impl ExactSizeIterator<Item = u32> + Clone),
    colliders: &Pool<Collider, ShapeId>,
) {
    let row_of = |slot| {
        let pair = pairs.get(slot);
        row_of((pair, pairs.blow_of(slot)), colliders)
    };
    let (rows, far): (Vec<PairRow>, Vec<Option<FarPose>>) = slots.clone().map(row_of).unzip();
    tables.table(rows.iter());
    let far: Vec<FarPose> = far.into_iter().flatten().collect();
    tables.table(far.iter());
    let carried: Vec<(Pose3, Carried)> = slots
        .map(|slot| pairs.get(slot))
        .flat_map(|pair| {
            let pose = Now::of(pair.key, colliders).map_or(Pose3::IDENTITY, |now| now.exact);
            pair.manifolds.iter().map(move |manifold| (pose, manifold))
        })
        .collect();
    let rows: Vec<ManifoldRow> = carried.iter().map(|(_, carried)| ManifoldRow::of(carried)).collect();
    tables.table(rows.iter());
    let points: Vec<PointRow> = carried.iter().flat_map(|(pose, carried)| points_of(pose, carried)).collect();
    tables.table(points.iter());
}

/// Reads what [`write`] has written, pairs and the hit of each; `None` if it makes no sense.
pub(crate) fn read(input: &mut Input, colliders: &Pool<Collider, ShapeId>) -> Option<(Vec<Pair>, Vec<ActiveHit>)> {
    let rows = input.table::<PairRow>()?;
    let mut far = input.table::<FarPose>()?.into_iter();
    let (mut manifolds, mut points) = (input.table::<ManifoldRow>()?.into_iter(), input.table::<PointRow>()?.into_iter());
    let mut pairs = Vec::with_capacity(rows.len());
    let blows = rows.iter().map(|row| ActiveHit { approach: row.approach, impulse: row.blow }).collect();
    for row in rows {
        let now = Now::of(row.key, colliders)?;
        let mut pair = row.pair(&now, &mut far)?;
        let count = (row.info / MANIFOLDS) as usize;
        if count > manifolds.len() {
            return None;
        }
        let carried = manifolds.by_ref().take(count).map(|row| row.manifold(&now.exact, &mut points));
        pair.manifolds = Manifolds::of(&carried.collect::<Option<Vec<_>>>()?);
        pairs.push(pair);
    }
    (far.next().is_none() && manifolds.next().is_none() && points.next().is_none()).then_some((pairs, blows))
}

/// Pose of B's shape in A's as it is now, the same in steps, and the step of its translation (m).
struct Now {
    exact: Pose3,
    coarse: Pose3,
    unit: f32,
}

impl Now {
    fn of(key: PairKey, colliders: &Pool<Collider, ShapeId>) -> Option<Self> {
        let (a, b) = key.shapes();
        let (a, b) = (colliders.get(a)?, colliders.get(b)?);
        let least_extent = a.least_extent.min(b.least_extent);
        let (exact, unit) = (a.relative(b), pose_unit(least_extent));
        Some(Self { exact, coarse: coarse(&exact, unit), unit })
    }
}

fn components(pose: &Pose3) -> [f32; 7] {
    let (p, q) = (pose.translation, pose.rotation);
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}

fn pose_of([x, y, z, qx, qy, qz, qw]: [f32; 7]) -> Pose3 {
    Pose3::from_parts(Vec3::new(x, y, z), Quat::from_xyzw(qx, qy, qz, qw))
}

/// Step of each number of a pose whose translation goes in steps of `unit`.
fn units(unit: f32) -> [f32; 7] {
    std::array::from_fn(|i| if i < 3 { unit } else { TURN_STEP })
}

/// Steps from one pose to another, if they are few and lead there to the bit.
fn packed(from: [f32; 7], to: [f32; 7], units: [f32; 7]) -> Option<u32> {
    let (mut bits, mut shift) = (0, 0);
    for i in 0..7 {
        let range = 1_u32 << STEP_BITS[i];
        let steps = (to[i] - from[i]) / units[i] + (range / 2) as f32;
        if !(0.0..range as f32).contains(&steps) {
            return None;
        }
        bits |= (steps as u32) << shift;
        shift += STEP_BITS[i];
    }
    let arrives = unpacked(from, bits, units).iter().zip(&to).all(|(a, b)| a.to_bits() == b.to_bits());
    arrives.then_some(bits)
}

fn unpacked(from: [f32; 7], bits: u32, units: [f32; 7]) -> [f32; 7] {
    let mut rest = bits;
    std::array::from_fn(|i| {
        let range = 1 << STEP_BITS[i];
        let steps = (rest % range) as i32 - (range / 2) as i32;
        rest >>= STEP_BITS[i];
        from[i] + steps as f32 * units[i]
    })
}

fn row_of((pair, blow): (&Pair, ActiveHit), colliders: &Pool<Collider, ShapeId>) -> (PairRow, Option<FarPose>) {
    // Written out, so that a field that is new does not compile.
    let Pair {
        key,
        manifolds,
        // See `made_for`.
        pose: _,
        margin: _,
        updated: _,
        still: _,
        version: _,
        // Of the support analysis.
        touching: _,
        touches: _,
        near: _,
        told: _,
        word: _,
        // Of the multipliers.
        pressed: _,
        may_touch,
        in_contact,
        active: _,
    } = pair;
    let flag = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
    let info = flag(*may_touch, MAY_TOUCH) | flag(*in_contact, IN_CONTACT) | (manifolds.len() as u32 * MANIFOLDS);
    let mut row = PairRow { key: *key, info, steps: 0, margin: 0, approach: blow.approach, blow: blow.impulse };
    let mut far = None;
    let now = Now::of(*key, colliders);
    if let (Some((pose, margin)), Some(now)) = (pair.made_for(), now) {
        row.info |= HAS_POSE;
        row.margin = margin.to_bits() >> MARGIN_SHIFT;
        let (from, to) = (components(&now.coarse), components(&pose));
        match packed(from, to, units(now.unit)) {
            Some(steps) => row.steps = steps,
            None => {
                row.info |= FAR_POSE;
                far = Some(FarPose(std::array::from_fn(|i| Steps::between(from[i], to[i]))));
            }
        }
    }
    (row, far)
}

impl PairRow {
    fn pair(&self, now: &Now, far: &mut impl Iterator<Item = FarPose>) -> Option<Pair> {
        let mut pair = Pair::new(self.key);
        let has = |flag: u32| self.info & flag != 0;
        (pair.may_touch, pair.in_contact) = (has(MAY_TOUCH), has(IN_CONTACT));
        if has(HAS_POSE) {
            let from = components(&now.coarse);
            let to = if has(FAR_POSE) {
                let FarPose(steps) = far.next()?;
                std::array::from_fn(|i| steps[i].from(from[i]))
            } else {
                unpacked(from, self.steps, units(now.unit))
            };
            pair.set_made_for(&pose_of(to), f32::from_bits(self.margin.checked_shl(MARGIN_SHIFT)?));
        }
        Some(pair)
    }
}

impl ManifoldRow {
    fn of(carried: &Carried) -> Self {
        let Carried { normal, part, points, impulses } = *carried;
        let ContactImpulses { normal: _, friction, twist, rolling } = *impulses;
        Self { count: points.len() as u8, part, normal, friction, twist, rolling }
    }

    fn manifold(&self, pose: &Pose3, points: &mut impl Iterator<Item = PointRow>) -> Option<CarriedManifold> {
        let Self { count, part, normal, friction, twist, rolling } = *self;
        let mut geometry = Manifold { normal, count, part, ..Manifold::default() };
        let mut impulses = ContactImpulses { friction, twist, rolling, ..ContactImpulses::default() };
        let places = geometry.points.get_mut(..usize::from(count)).filter(|places| !places.is_empty())?;
        for (point, impulse) in places.iter_mut().zip(&mut impulses.normal) {
            let row = points.next()?;
            *point = row.point(pose, normal);
            *impulse = row.impulse;
        }
        Some(CarriedManifold { geometry, impulses })
    }
}

fn points_of<'a>(pose: &'a Pose3, carried: &'a Carried) -> impl Iterator<Item = PointRow> + 'a {
    let points = carried.points.iter().zip(&carried.impulses.normal);
    points.map(move |(&ManifoldPoint { on_a, on_b, separation, feature }, &impulse)| {
        let (actual, expected) = (on_b.to_array(), expected_on_b(pose, on_a, carried.normal, separation).to_array());
        PointRow { feature, separation, impulse, on_a, on_b: std::array::from_fn(|i| Steps::between(expected[i], actual[i])) }
    })
}

impl PointRow {
    fn point(&self, pose: &Pose3, normal: Vec3) -> ManifoldPoint {
        let expected = expected_on_b(pose, self.on_a, normal, self.separation).to_array();
        let on_b = Vec3::from_array(std::array::from_fn(|i| self.on_b[i].from(expected[i])));
        ManifoldPoint { on_a: self.on_a, on_b, separation: self.separation, feature: self.feature }
    }
}

/// The point on B, in B's frame, that lies beyond the one on A along the normal.
fn expected_on_b(pose: &Pose3, on_a: Vec3, normal: Vec3, separation: f32) -> Vec3 {
    pose.rotation.conjugate() * (on_a + normal * separation - pose.translation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_lead_from_any_float_to_any_other() {
        let floats =
            [0.0, -0.0, 1.0, -1.0, f32::MIN_POSITIVE, -f32::MIN_POSITIVE, 1.0e-45, f32::MAX, f32::MIN, f32::INFINITY, 0.1];
        for from in floats.into_iter().chain([f32::NAN]) {
            for to in floats {
                assert_eq!(Steps::between(from, to).from(from).to_bits(), to.to_bits(), "from {from} to {to}");
            }
        }
        assert_eq!(Steps::between(1.0, 1.0_f32.next_up()), Steps(2));
        assert_eq!(Steps::between(0.0, -0.0), Steps(1));
    }
}
