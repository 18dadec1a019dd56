//! A ball or a capsule against the side of a cylinder, in closed form: what lies on a drum, a wheel or a pipe; and edges against it.
//!
//! Where the point of a segment that is nearest to the cylinder's axis lies between the ends of the cylinder and outside it, it is
//! the nearest to the cylinder too, for the cylinder is a part of the infinite one. The normal is radial there, exact to rounding. An
//! iterative search that stops at 1e-5 of the distance leaves the normal several hundredths of a radian off over a thin core: a cable would
//! slide into its drum.

use glam::{Vec2, Vec3};
use parry3d::math::Pose3;

use super::beside::{self, Side};
use super::convex::LONE;
use super::segment::Segment;
use super::{Manifold, ManifoldPoint};

/// Squared sine of a segment's angle to the axis below which all of its points are as near to it as its middle.
const PARALLEL: f32 = 1.0e-10;

/// Cosine between a normal and an edge up to which they are at right angles: rounding of an edge some hundred radii long.
const SQUARE: f32 = 1.0e-5;

/// Squared sine of the angle between an edge and a rim from which on they cross.
const CROSSING: f32 = 0.01;

/// Most steps along an edge; four are enough for most.
const MAX_STEPS: u32 = 16;

/// A core of `radius` around the segment `core` (one point where `half` is zero) against the side of cylinder A (half height and
/// radius, m); none where it is not the side that the core is nearest to.
pub(super) fn side_core(a: (f32, f32), core: &Segment, radius: f32, relative: &Pose3, margin: f32) -> Option<Option<Manifold>> {
    let (half_height, radius_a) = a;
    let nearest = core.at(nearest_to_axis(core));
    let across = Vec2::new(nearest.x, nearest.z);
    let distance = across.length();
    // Written so that a NaN is left to others.
    let beside = nearest.y.abs() <= half_height && distance > radius_a;
    if !beside {
        return None;
    }
    if distance - radius_a - radius > margin {
        return Some(None);
    }
    let normal = Vec3::new(across.x, 0.0, across.y) / distance;
    let foot = normal * radius_a;
    let place = |(on_side, on_core): (Vec3, Vec3), feature| ManifoldPoint {
        on_a: on_side,
        on_b: relative.inverse_transform_point(on_core - normal * radius),
        separation: normal.dot(on_core - on_side) - radius,
        feature,
    };
    let mut manifold = Manifold { normal, ..Manifold::default() };
    let line = Segment { center: foot, half: Vec3::Y * half_height };
    let girth = radius.min(radius_a).min(half_height);
    match line.side_by_side(core, normal, girth) {
        Some(ends) => {
            let points = (0..).zip(ends).map(|(feature, end)| place(end, feature));
            points.filter(|point| point.separation <= margin).for_each(|point| manifold.push(point));
        }
        None => {
            manifold.push(place((foot + Vec3::Y * nearest.y, nearest), LONE));
            let sides = [Side { line, radii: [radius_a; 2] }, Side::around(core, radius, -normal)];
            beside::widen(&sides, relative, margin, &mut manifold);
        }
    }
    Some((manifold.count > 0).then_some(manifold))
}

/// What of a cylinder and an edge is nearest to each other.
pub(super) struct NearEdge {
    /// From the cylinder to the edge.
    pub normal: Vec3,
    pub on_cylinder: Vec3,
    pub on_edge: Vec3,
}

/// The point of an edge that is nearest to the side or the rim of a cylinder (half height and radius, m); none where that is nearest to an end
/// face, in the rim's overlap, or on the axis.
///
/// It is that nearest to the axis, if this is beside the cylinder. Else it lies between there and where the edge comes to be beyond the rim: with
/// q = ρ − r and p = |y| − h, the distance D = √(q² + p²) is convex along the edge, and Newton's method finds its least value: q″ = (u² − q′²)/ρ
/// with u across the axis, D″ = (q′² + q q″ + p′² − D′²)/D.
pub(super) fn nearest_on_edge((half_height, radius): (f32, f32), edge: &Segment) -> Option<NearEdge> {
    let along = edge.half;
    let of_axis = nearest_to_axis(edge);
    let at = edge.at(of_axis);
    let rim = half_height.copysign(at.y);
    if at.y.abs() <= half_height {
        let normal = Vec3::new(at.x, 0.0, at.z).try_normalize()?;
        let on_cylinder = normal * radius + Vec3::Y * at.y;
        return Some(NearEdge { normal, on_cylinder, on_edge: at });
    }
    let of_rim = if along.y == 0.0 { of_axis } else { ((rim - edge.center.y) / along.y).clamp(-1.0, 1.0) };
    let (mut low, mut high) = (of_axis.min(of_rim), of_axis.max(of_rim));
    let (mut s, mut steps) = (of_rim, 0);
    loop {
        let at = edge.at(s);
        let across = Vec3::new(at.x, 0.0, at.z);
        let axis_distance = across.length();
        let (beyond, over) = (axis_distance - radius, at.y - rim);
        // Written so that a NaN is none.
        let is_outside = beyond > 0.0;
        if !is_outside {
            return None;
        }
        let outward = across / axis_distance;
        let offset = outward * beyond + Vec3::Y * over;
        let distance = offset.length();
        let normal = offset / distance;
        let (slope, widens) = (normal.dot(along), outward.dot(along));
        let bend = (along.x * along.x + along.z * along.z - widens * widens) / axis_distance;
        let curvature = (widens * widens + beyond * bend + along.y * along.y - slope * slope) / distance;
        (low, high) = if slope > 0.0 { (low, s) } else { (s, high) };
        let next = (s - slope / curvature).clamp(low, high);
        let is_found = slope.abs() <= SQUARE * along.length() || next == s || steps == MAX_STEPS;
        if is_found {
            // What is square to the edge and to the rim does not suffer from how little they are apart.
            let square = along.cross(Vec3::Y.cross(outward));
            let is_crossing = s.abs() < 1.0 && square.length_squared() > CROSSING * along.length_squared();
            let normal = if is_crossing { square.normalize() * 1.0_f32.copysign(square.dot(offset)) } else { normal };
            return Some(NearEdge { normal, on_cylinder: at - offset, on_edge: at });
        }
        (s, steps) = (if next == low || next == high { 0.5 * (low + high) } else { next }, steps + 1);
    }
}

/// Where on the segment the distance to the y axis is least.
fn nearest_to_axis(core: &Segment) -> f32 {
    let (center, half) = (Vec2::new(core.center.x, core.center.z), Vec2::new(core.half.x, core.half.z));
    let squared = half.length_squared();
    if squared <= PARALLEL * core.half.length_squared() { 0.0 } else { (-center.dot(half) / squared).clamp(-1.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    const DRUM: (f32, f32) = (0.5, 1.0);

    fn rod(at: Vec3, rotation: Quat) -> (Segment, Pose3) {
        let pose = Pose3::from_parts(at, rotation);
        (Segment::of_capsule(0.1, &pose), pose)
    }

    #[test]
    fn a_rod_across_a_drum_touches_where_it_is_tangent_and_nowhere_else() {
        for degrees in 0..360 {
            let angle = (degrees as f32).to_radians();
            let radial = Vec3::new(angle.cos(), 0.0, angle.sin());
            let tangent = Vec3::Y.cross(radial);
            // Its middle lies 3 cm past the point of contact.
            let (core, pose) = rod(radial * 1.019 + tangent * 0.03, Quat::from_rotation_arc(Vec3::Y, tangent));
            let manifold = side_core(DRUM, &core, 0.02, &pose, 0.1).flatten().expect("a contact");
            assert_eq!(manifold.count, 1);
            let point = &manifold.points[0];
            assert!((manifold.normal - radial).length() < 1e-6, "normal {} for {radial}", manifold.normal);
            assert!((point.separation + 0.001).abs() < 1e-6, "{} m", point.separation);
            assert!((point.on_b - Vec3::new(0.0, -0.03, 0.0)).reject_from(pose.rotation.inverse() * radial).length() < 1e-5);
        }
    }

    #[test]
    fn a_rod_along_a_drum_lies_on_both_ends_of_the_common_stretch() {
        let (core, pose) = rod(Vec3::new(0.0, 0.45, 1.02), Quat::IDENTITY);
        let manifold = side_core(DRUM, &core, 0.02, &pose, 0.1).flatten().expect("a contact");
        assert_eq!((manifold.count, manifold.normal), (2, Vec3::Z));
        for (point, y) in manifold.contacts().iter().zip([0.35, 0.5]) {
            assert!((point.on_a - Vec3::new(0.0, y, 1.0)).length() < 1e-6, "point {}", point.on_a);
            assert!(point.separation.abs() < 1e-6, "{} m", point.separation);
        }
    }

    /// Edges at all angles to the axis and to the side, near and far, against a search in small steps in `f64`.
    #[test]
    fn the_nearest_point_of_an_edge_is_exact() {
        let distance = |at: Vec3| {
            let at = at.as_dvec3();
            let (beyond, over) = ((at.x * at.x + at.z * at.z).sqrt() - 1.0, (at.y.abs() - 0.5).max(0.0));
            if over > 0.0 { beyond.hypot(over) } else { beyond }
        };
        for turn in [0.0, 1.0e-6, 1.0e-4, 3.0e-3, 0.1, 0.4, 1.2, 1.57] {
            for (height, clearance, shift) in
                [0.0, 0.3, 0.499, 0.6].into_iter().flat_map(|y| [(y, 1.0e-4, 0.0), (y, 2.0e-3, 0.8), (y, 0.2, -0.6)])
            {
                let along = Quat::from_rotation_x(turn) * Vec3::Y;
                let center = Vec3::new(1.0 + clearance, height, 0.0) + along * shift;
                let edge = Segment { center, half: along };
                let found = nearest_on_edge(DRUM, &edge).expect("an edge outside");
                let least = (-4000..=4000).map(|i| distance(edge.at(i as f32 / 4000.0))).fold(f64::INFINITY, f64::min);
                let what =
                    format!("turned by {turn}, {clearance} m off at {height} m, shifted by {shift} m: {:?}", found.on_edge);
                assert!(distance(found.on_edge) < least + 1.0e-6, "{what}: {} m, least {least} m", distance(found.on_edge));
                let way = (found.on_edge - found.on_cylinder).length();
                assert!((f64::from(way) - distance(found.on_edge)).abs() < 1.0e-6, "{what}: {way} m");
                assert!((found.on_cylinder + found.normal * way - found.on_edge).length() < 1.0e-6, "{what}: {}", found.normal);
            }
        }
    }

    #[test]
    fn what_is_past_an_end_or_inside_is_left_to_others() {
        for at in [Vec3::new(1.01, 0.6, 0.0), Vec3::new(0.9, 0.0, 0.0)] {
            let (core, pose) = rod(at, Quat::from_rotation_x(1.5));
            assert!(side_core(DRUM, &core, 0.02, &pose, 0.1).is_none(), "{at}");
        }
    }
}
