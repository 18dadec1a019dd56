//! What lies on a round surface that hardly bends below it: the corners of its face, or the ends of its edge, hold it as on a plane.
//!
//! At a distance d from where it is touched, a surface of radius R has gone away from its tangent plane by the sagitta d²/2R. The nearest
//! point of a face that lies on it is one, and a turn by d/R moves it from one corner to the opposite one. With that point alone a
//! body would tip to and fro from step to step, pressed by less than it weighs, and go in. So the corners are points too, each at its own
//! distance along the common normal. Where the surface bends more, they are further away than the margin, and the nearest point is left.

use glam::Vec3;
use parry3d::math::Pose3;

use super::convex::Buffers;
use super::face::{self, Corner};
use super::part::Part;
use super::reduce::{PointCandidate, fill};
use super::segment::MAX_LEAN;
use super::{Manifold, ManifoldPoint};

/// Separations that differ by less than this fraction of the part's reach count as equal.
const TIE: f32 = 1.0e-4;

/// Points nearer to each other than this fraction of the part's reach are one.
const ONE_SPOT: f32 = 1.0e-2;

/// Bit of the feature of a corner, which no other point of such a manifold has.
const CORNER: u32 = 1 << 30;

/// Adds the corners of what lies on a round part to a manifold of B (placed at `relative` in A's frame) against A, which is along a normal
/// of the round part; `turns` says how far each may turn in the step (rad).
pub(super) fn widen(
    [a, b]: [&Part; 2],
    relative: &Pose3,
    margin: f32,
    turns: [f32; 2],
    buffers: &mut Buffers,
    manifold: &mut Manifold,
) {
    let on_a = Round::of(a, manifold.normal, turns[0]);
    if on_a.is_some_and(|round| round.holds(b, relative, margin, buffers, manifold)) {
        return;
    }
    let seen_from_b = relative.rotation.inverse() * -manifold.normal;
    if let Some(round) = Round::of(b, seen_from_b, turns[1]) {
        let inverse = relative.inverse();
        let mut wide = *manifold;
        wide.swap(relative);
        if round.holds(a, &inverse, margin, buffers, &mut wide) {
            wide.swap(&inverse);
            *manifold = wide;
        }
    }
}

/// Whether a face of a box may lie over a ball with all of its corners: none is further from the middle of the face than the ball's radius.
#[inline]
pub(super) fn may_lie_on_ball(half_extents: Vec3, radius: f32) -> bool {
    let longest = half_extents.max_element();
    half_extents.length_squared() - longest * longest <= radius * radius
}

/// A ball, or what is round of a capsule or a cylinder, about a core along the y axis.
struct Round {
    half_height: f32,
    radius: f32,
    /// Whether it is round at its ends too.
    is_capped: bool,
    /// How far its surface goes in the step by turning (m).
    roll: f32,
}

impl Round {
    /// What is round of a part where the normal is this.
    fn of(part: &Part, normal: Vec3, turn: f32) -> Option<Self> {
        let (half_height, radius, is_capped) = match *part {
            Part::Ball { radius } => (0.0, radius, true),
            Part::Capsule { half_height, radius } => (half_height, radius, true),
            Part::Cylinder { half_height, radius } if normal.y.abs() <= MAX_LEAN => (half_height, radius, false),
            _ => return None,
        };
        Some(Self { half_height, radius, is_capped, roll: radius * turn })
    }

    /// From the core to a point, across the normal and along it; none beyond an end that is not round.
    fn arm(&self, point: Vec3, normal: Vec3) -> Option<(Vec3, f32)> {
        let core = point.y.clamp(-self.half_height, self.half_height);
        let arm = point - Vec3::Y * core;
        let along = normal.dot(arm);
        (self.is_capped || core == point.y).then(|| (arm - normal * along, along))
    }

    /// Whether a place lies on its surface: along a normal that is not across the core it may have gone past an end of that.
    fn is_at(&self, place: Vec3) -> bool {
        let core = place.y.clamp(-self.half_height, self.half_height);
        let off = ((place - Vec3::Y * core).length() - self.radius).abs();
        (self.is_capped || core == place.y) && off <= TIE * self.radius
    }

    /// Whether a face of a box may lie over it with all of its corners: across its core a face is as wide as the box's least edge.
    fn bears(&self, half_extents: Vec3) -> bool {
        let is_ball = self.half_height == 0.0;
        if is_ball { may_lie_on_ball(half_extents, self.radius) } else { half_extents.min_element() <= self.radius }
    }

    /// Adds the corners of a part at `pose` that lies on it, all of which must be over it, and says whether there are any.
    ///
    /// What turns in itself meets nothing by that, but a row at a distance d from the core's normal takes it to close by d times the
    /// turn. Where that is more than the sagitta, there is no point: a ball rolls over what is smaller than its way in a step.
    fn holds(&self, part: &Part, pose: &Pose3, margin: f32, buffers: &mut Buffers, manifold: &mut Manifold) -> bool {
        if matches!(part, Part::Box { half_extents } if !self.bears(*half_extents)) {
            return false;
        }
        let normal = manifold.normal;
        let Buffers { corners_b: corners, candidates, .. } = buffers;
        if !matches!(part, Part::Triangle { .. } | Part::HalfSpace { .. }) {
            face::lying(part, pose.rotation.inverse() * -normal, corners);
        } else {
            corners.clear();
        }
        let known = usize::from(manifold.count);
        if corners.len() <= known {
            return false;
        }
        let least_arm = 2.0 * self.roll;
        candidates.clear();
        for &(on_b, id) in corners.iter() {
            let at = *pose * on_b;
            let Some((across, along)) = self.arm(at, normal) else { return false };
            let squared = across.length_squared();
            let height = self.radius * self.radius - squared;
            // Written so that a NaN is no contact.
            let is_over = height > 0.0;
            if !is_over {
                return false;
            }
            let separation = along - height.sqrt();
            if !self.is_at(at - normal * separation) {
                return false;
            }
            if separation <= margin && squared >= least_arm * least_arm {
                let feature = CORNER | u32::from(id);
                candidates.push(PointCandidate { on_a: at - normal * separation, on_b, separation, feature });
            }
        }
        self.choose(part.reach(), corners, candidates, manifold)
    }

    /// Takes the corners of a part of this reach into the manifold, and of its own points those that say more.
    fn choose(&self, reach: f32, corners: &[Corner], candidates: &[PointCandidate], manifold: &mut Manifold) -> bool {
        let tie = TIE * reach + 4.0 * f32::EPSILON * (self.radius + self.half_height);
        let least = manifold.contacts().iter().fold(f32::INFINITY, |least, point| least.min(point.separation));
        let is_flat = candidates.len() == corners.len() && candidates.iter().all(|c| c.separation <= least + tie);
        let one_spot = ONE_SPOT * reach;
        let is_corner = |point: &ManifoldPoint| {
            let is_at = |c: &PointCandidate| c.on_a.distance_squared(point.on_a) <= one_spot * one_spot;
            candidates.iter().any(|c| c.separation <= point.separation + tie && is_at(c))
        };
        let mut wide = Manifold { normal: manifold.normal, part: manifold.part, ..Manifold::default() };
        if !is_flat {
            manifold.contacts().iter().filter(|point| !is_corner(point)).for_each(|point| wide.push(*point));
        }
        fill(&mut wide, candidates, tie, |c| ManifoldPoint {
            on_a: c.on_a,
            on_b: c.on_b,
            separation: c.separation,
            feature: c.feature,
        });
        let is_wider = wide.count > manifold.count;
        if is_wider {
            *manifold = wide;
        }
        is_wider
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn widened(ball: f32, part: &Part, pose: Pose3, margin: f32, turn: f32) -> Manifold {
        let point = ManifoldPoint { on_a: Vec3::Y * ball, separation: pose.translation.y - ball - 0.5, ..Default::default() };
        let mut manifold = Manifold::single(Vec3::Y, point);
        widen([&Part::Ball { radius: ball }, part], &pose, margin, [turn, 0.0], &mut Buffers::default(), &mut manifold);
        manifold
    }

    #[test]
    fn corners_of_what_lies_on_a_ball_are_at_their_own_distances() {
        let part = Part::Box { half_extents: Vec3::splat(0.5) };
        for (ball, count) in [(1.0e4, 4), (50.0, 4), (5.0, 4), (2.0, 1), (0.5, 1)] {
            let pose = Pose3::from_parts(Vec3::Y * (ball + 0.5), Quat::from_rotation_y(0.3));
            let manifold = widened(ball, &part, pose, 0.06, 0.0);
            assert_eq!(usize::from(manifold.count), count, "ball of {ball} m: {manifold:?}");
            for point in manifold.contacts().iter().filter(|point| point.feature & CORNER != 0) {
                let sagitta = ball - (ball * ball - 0.5).sqrt();
                assert!((point.separation - sagitta).abs() < 2.0e-7 * ball.max(1.0), "{point:?}, expected {sagitta} m");
            }
        }
    }

    #[test]
    fn what_rolls_far_in_a_step_has_no_corners() {
        let part = Part::Box { half_extents: Vec3::splat(0.5) };
        let pose = Pose3::from_translation(Vec3::Y * 50.5);
        assert_eq!(widened(50.0, &part, pose, 0.06, 0.006).count, 4);
        assert_eq!(widened(50.0, &part, pose, 0.06, 0.008).count, 1);
    }
}
