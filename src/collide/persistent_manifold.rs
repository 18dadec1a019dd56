//! Manifolds of a pair with their multipliers, kept from step to step.
//!
//! Three of four manifolds of a pile have one point, and room for four would be half of what manifolds take: such a one is kept
//! by itself. Whoever reads sees all of them as [`Carried`].

use glam::{DVec3, Vec3};
use parry3d::math::Pose3;

use super::narrow::{Manifold, ManifoldPoint};
use crate::contact::{ContactImpulses, tangents};
use crate::load_distribution::{LoadedPoint, balance};
use crate::prefetch::prefetch;

/// A manifold with the multipliers it had at the end of the last step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CarriedManifold {
    pub geometry: Manifold,
    pub impulses: ContactImpulses,
}

/// The same of one point of whole shapes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CarriedPoint {
    normal: Vec3,
    point: ManifoldPoint,
    impulses: ContactImpulses,
}

/// A manifold as it is read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Carried<'a> {
    /// Unit vector in the frame of shape A, from A to B.
    pub normal: Vec3,
    /// As [`Manifold::part`].
    pub part: u32,
    /// 1 to 4.
    pub points: &'a [ManifoldPoint],
    pub impulses: &'a ContactImpulses,
}

impl Carried<'_> {
    /// Whether any of its points pressed in the last step.
    pub(crate) fn presses(&self) -> bool {
        self.impulses.normal.iter().any(|&impulse| impulse > 0.0)
    }
}

impl CarriedManifold {
    fn read(&self) -> Carried<'_> {
        let Manifold { normal, part, .. } = self.geometry;
        Carried { normal, part, points: self.geometry.contacts(), impulses: &self.impulses }
    }
}

impl CarriedPoint {
    fn read(&self) -> Carried<'_> {
        Carried { normal: self.normal, part: 0, points: std::slice::from_ref(&self.point), impulses: &self.impulses }
    }
}

/// The one point of all these, if it can be kept by itself.
fn lone_point(manifolds: &[CarriedManifold]) -> Option<CarriedPoint> {
    let [CarriedManifold { geometry: Manifold { normal, points, count: 1, part: 0 }, impulses }] = manifolds else { return None };
    Some(CarriedPoint { normal: *normal, point: points[0], impulses: *impulses })
}

/// Separation of a point that is left out (m): more than anything closes in a step.
const LEFT_OUT: f32 = 1.0e6;

/// All manifolds of a pair.
#[derive(Debug, Clone)]
pub(crate) enum Manifolds {
    Point(Box<CarriedPoint>),
    Any(Box<[CarriedManifold]>),
}

/// How much memory the manifolds of a pair take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    None,
    Point,
    One,
    Many,
}

/// A pair has no room for more, see [`Pair`](super::pairs::Pair).
const _: () = assert!(size_of::<Manifolds>() <= 16);

impl Default for Manifolds {
    fn default() -> Self {
        Self::Any(Box::default())
    }
}

impl Manifolds {
    pub(crate) fn of(manifolds: &[CarriedManifold]) -> Self {
        match lone_point(manifolds) {
            Some(point) => Self::Point(Box::new(point)),
            None => Self::Any(manifolds.into()),
        }
    }

    pub(super) fn kind(&self) -> Kind {
        match self {
            Self::Point(_) => Kind::Point,
            Self::Any(manifolds) if manifolds.len() > 1 => Kind::Many,
            Self::Any(manifolds) if manifolds.len() == 1 => Kind::One,
            Self::Any(_) => Kind::None,
        }
    }

    /// Where in memory they are.
    pub(super) fn address(&self) -> usize {
        match self {
            Self::Point(point) => std::ptr::from_ref(&**point).addr(),
            Self::Any(manifolds) => manifolds.as_ptr().addr(),
        }
    }

    /// Asks for the memory that they are in.
    #[inline(always)]
    pub(crate) fn prefetch(&self) {
        match self {
            Self::Point(point) => prefetch(&**point),
            Self::Any(manifolds) => prefetch(&**manifolds),
        }
    }

    /// Asks for the memory that their multipliers are in.
    #[inline(always)]
    pub(crate) fn prefetch_impulses(&self) {
        match self {
            Self::Point(point) => prefetch(&point.impulses),
            Self::Any(manifolds) => manifolds.iter().for_each(|manifold| prefetch(&manifold.impulses)),
        }
    }

    /// Exchanges manifolds of one [`Kind`], but not the memory that they are in.
    pub(super) fn swap_contents(&mut self, other: &mut Self) {
        match (self, other) {
            (Self::Point(a), Self::Point(b)) => std::mem::swap(&mut **a, &mut **b),
            (Self::Any(a), Self::Any(b)) if a.len() == b.len() => a.swap_with_slice(b),
            (a, b) => std::mem::swap(a, b),
        }
    }

    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Point(_) => 1,
            Self::Any(manifolds) => manifolds.len(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether any normal multiplier is positive.
    pub(super) fn are_pressed(&self) -> bool {
        self.iter().any(|manifold| manifold.impulses.normal.iter().any(|&lambda| lambda > 0.0))
    }

    pub(crate) fn get(&self, number: usize) -> Carried<'_> {
        match self {
            Self::Point(point) => point.read(),
            Self::Any(manifolds) => manifolds[number].read(),
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = Carried<'_>> {
        let (point, manifolds) = match self {
            Self::Point(point) => (Some(&**point), &[][..]),
            Self::Any(manifolds) => (None, &manifolds[..]),
        };
        point.into_iter().map(CarriedPoint::read).chain(manifolds.iter().map(CarriedManifold::read))
    }

    pub(crate) fn impulses_mut(&mut self) -> impl Iterator<Item = &mut ContactImpulses> {
        let (point, manifolds) = match self {
            Self::Point(point) => (Some(&mut point.impulses), &mut [][..]),
            Self::Any(manifolds) => (None, &mut manifolds[..]),
        };
        point.into_iter().chain(manifolds.iter_mut().map(|manifold| &mut manifold.impulses))
    }

    /// Leaves a point out until the manifold is made anew.
    pub(super) fn leave_out(&mut self, number: usize, point: usize) {
        let (place, impulses) = match self {
            Self::Point(only) => (&mut only.point, &mut only.impulses),
            Self::Any(manifolds) => {
                let manifold = &mut manifolds[number];
                (&mut manifold.geometry.points[point], &mut manifold.impulses)
            }
        };
        place.separation = LEFT_OUT;
        impulses.normal[point] = 0.0;
    }

    /// Gives a manifold another normal, and its points other places.
    pub(super) fn turn(&mut self, number: usize, to: Vec3, moved: impl Fn(&mut ManifoldPoint)) {
        let (normal, points) = match self {
            Self::Point(only) => (&mut only.normal, std::slice::from_mut(&mut only.point)),
            Self::Any(manifolds) => {
                let Manifold { normal, points, count, .. } = &mut manifolds[number].geometry;
                (normal, &mut points[..usize::from(*count)])
            }
        };
        *normal = to;
        points.iter_mut().filter(|point| point.separation != LEFT_OUT).for_each(moved);
    }

    pub(crate) fn set_impulses(&mut self, number: usize, impulses: ContactImpulses) {
        match self {
            Self::Point(point) => point.impulses = impulses,
            Self::Any(manifolds) => manifolds[number].impulses = impulses,
        }
    }

    /// Moves the points with the shapes, with B's at `relative` in A's frame: their separations follow, the points stay where they are
    /// on the surfaces.
    pub(crate) fn follow(&mut self, relative: &Pose3) {
        let follow = |normal: Vec3, point: &mut ManifoldPoint| {
            if point.separation == LEFT_OUT {
                return;
            }
            let on_b = relative.rotation * point.on_b + relative.translation;
            point.separation = normal.dot(on_b - point.on_a);
        };
        match self {
            Self::Point(point) => follow(point.normal, &mut point.point),
            Self::Any(manifolds) => {
                for Manifold { normal, points, count, .. } in manifolds.iter_mut().map(|manifold| &mut manifold.geometry) {
                    points[..usize::from(*count)].iter_mut().for_each(|point| follow(*normal, point));
                }
            }
        }
    }

    /// Takes new manifolds, with the multipliers of the old points that they continue; `carried` is a buffer.
    pub(crate) fn take(&mut self, fresh: &[Manifold], carried: &mut Vec<CarriedManifold>) {
        carried.clear();
        carried.extend(fresh.iter().map(|manifold| {
            let old = self.iter().find(|old| old.part == manifold.part);
            let impulses = old.map_or(ContactImpulses::default(), |old| continued(&old, manifold));
            CarriedManifold { geometry: *manifold, impulses }
        }));
        match (self, lone_point(carried)) {
            (Self::Point(kept), Some(point)) => **kept = point,
            (Self::Any(kept), None) if kept.len() == carried.len() => kept.copy_from_slice(carried),
            (kept, _) => *kept = Self::of(carried),
        }
    }
}

/// Separation of an unloaded point up to which it belongs to the region of a pressed face, over the smaller shape's extent; a loaded one
/// that is further off may have nothing to press on.
pub(crate) const TOUCHING_SHARE: f32 = 1.0e-3;

/// Points of a pressed manifold that are pressed or touch, as bits; none where nothing is pressed. `extent` is the lesser least
/// extent of the two shapes (m).
pub(crate) fn touching(manifold: &Carried, extent: f32) -> u8 {
    let exist = (1 << manifold.points.len()) - 1;
    let pressed = pressed(manifold.impulses) & exist;
    if pressed == 0 { 0 } else { pressed | near(manifold.points, extent) }
}

/// Points with a normal multiplier above zero, as bits.
pub(super) fn pressed(impulses: &ContactImpulses) -> u8 {
    (0..impulses.normal.len()).fold(0, |bits, i| bits | u8::from(impulses.normal[i] > 0.0) << i)
}

/// Points that are near enough to touch where others are pressed, as bits.
pub(super) fn near(points: &[ManifoldPoint], extent: f32) -> u8 {
    points.iter().enumerate().fold(0, |bits, (i, point)| bits | u8::from(point.separation <= TOUCHING_SHARE * extent) << i)
}

/// Cosine of the turn of a normal from which on multipliers are not carried over. Where bodies are pressed deep into one another the
/// axis of least overlap jumps, and what held up a column of falling bodies would push sideways against nothing.
const MIN_ALIGNMENT: f32 = 0.9;

/// Share of the old multipliers that matching features must have taken for them to be kept point by point.
const ALL_TAKEN: f32 = 0.999;

/// Multipliers of `old` for the points of `new`: point by point where features match, or else the same force and moments.
///
/// Two faces cross in up to eight points, of which four are kept; which four may change with the last bit. A point that took
/// its multiplier with it would leave the others to find the load again, and a tower shakes itself down.
fn continued(old: &Carried, new: &Manifold) -> ContactImpulses {
    let new_points = new.contacts();
    let mut impulses = ContactImpulses { normal: [0.0; 4], ..*old.impulses };
    let mut taken = 0.0;
    for (point, normal) in new_points.iter().zip(&mut impulses.normal) {
        if let Some(j) = old.points.iter().position(|old| old.feature == point.feature) {
            *normal = old.impulses.normal[j];
            taken += *normal;
        }
    }
    let total: f32 = old.impulses.normal[..old.points.len()].iter().sum();
    if total == 0.0 || old.normal.dot(new.normal) < MIN_ALIGNMENT {
        return ContactImpulses::default();
    }
    if taken < total * ALL_TAKEN {
        impulses.normal = spread(old, new_points);
    }
    impulses
}

/// The old multipliers' force and moments on the new points.
fn spread(old: &Carried, new_points: &[ManifoldPoint]) -> [f32; 4] {
    let (u, v) = tangents(old.normal);
    let column = |point: &ManifoldPoint| DVec3::new(1.0, f64::from(point.on_a.dot(u)), f64::from(point.on_a.dot(v)));
    // About the centre of the new points, so that the moments are those of small levers.
    let center = new_points.iter().map(column).sum::<DVec3>() / new_points.len() as f64;
    let about_center = |point: &ManifoldPoint| column(point) - DVec3::new(0.0, center.y, center.z);
    let demand =
        old.points.iter().zip(&old.impulses.normal).map(|(point, &lambda)| about_center(point) * f64::from(lambda)).sum();
    let mut loaded = [LoadedPoint::new(DVec3::ZERO); 4];
    for (loaded, point) in loaded.iter_mut().zip(new_points) {
        *loaded = LoadedPoint::new(about_center(point));
    }
    balance(&mut loaded[..new_points.len()], demand);
    loaded.map(|point| point.force as f32)
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    fn pressed(normal: Vec3) -> Manifold {
        let mut manifold = Manifold { normal, count: 1, ..Manifold::default() };
        manifold.points[0].feature = 7;
        manifold
    }

    #[test]
    fn a_multiplier_stays_with_its_direction() {
        let impulses = ContactImpulses { normal: [5.0, 0.0, 0.0, 0.0], friction: Vec3::X, ..ContactImpulses::default() };
        let old = Manifolds::of(&[CarriedManifold { geometry: pressed(Vec3::Y), impulses }]);
        let after_turn = |degrees: f32| continued(&old.get(0), &pressed(Quat::from_rotation_z(degrees.to_radians()) * Vec3::Y));
        assert_eq!(after_turn(0.0), impulses);
        assert_eq!(after_turn(10.0), impulses);
        // The axis of least overlap has jumped from one face to the next.
        assert_eq!(after_turn(90.0), ContactImpulses::default());
        assert_eq!(after_turn(180.0), ContactImpulses::default());
    }
}
