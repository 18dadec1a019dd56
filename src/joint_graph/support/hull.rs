//! Convex hulls in the plane across gravity: where a load can be carried.
//!
//! A region is a convex polygon, anticlockwise, of none, one (a point), two (an edge) or more vertices. Coordinates are metres
//! from some body's centre of mass, in `f32`; orientation tests are in `f64`, where the products of two `f32` are exact.

use glam::Vec2;

/// Share of a region's reach by which a point may lie outside and still count as inside.
///
/// Contact points of stacked faces lie exactly on each other's edges; without slack, rounding would clip every stack.
const SLACK_SHARE: f32 = 1.0e-3;

/// Share of a region's reach below which its width is rounding, so that it is an edge: sides that lie on one another cut all away.
const MIN_WIDTH_SHARE: f32 = 1.0e-5;

/// Convex hull of `points` by Andrew's monotone chain (1979), into `hull`; `points` is sorted on the way.
///
/// Points on an edge of the hull are left out. The result depends on the set of points alone, not on their order.
pub(crate) fn convex_hull(points: &mut [Vec2], hull: &mut Vec<Vec2>) {
    hull.clear();
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    chain(points.iter(), hull);
    let lower = hull.len();
    chain(points.iter().rev(), hull);
    // Both chains end where the other begins; one of a single point is the same twice.
    hull.pop();
    if lower > 1 {
        hull.remove(lower);
    }
    if hull.len() == 2 && hull[0] == hull[1] {
        hull.pop();
    }
    if hull.len() >= 3 {
        flatten(hull);
    }
}

/// Leaves the two ends of a hull that is as thin as rounding.
fn flatten(hull: &mut Vec<Vec2>) {
    let farthest = |from: Vec2| hull.iter().fold(from, |far, &v| if v.distance(from) > far.distance(from) { v } else { far });
    let one = farthest(hull[0]);
    let other = farthest(one);
    let widest = hull.iter().map(|&v| cross(one, other, v).abs()).fold(0.0, f64::max);
    if widest < f64::from(MIN_WIDTH_SHARE * reach(hull) * one.distance(other)) {
        let is_first = one.x.total_cmp(&other.x).then(one.y.total_cmp(&other.y)).is_lt();
        hull.clear();
        hull.extend(if is_first { [one, other] } else { [other, one] });
    }
}

/// Appends the chain that turns left all along.
fn chain<'a>(points: impl Iterator<Item = &'a Vec2>, hull: &mut Vec<Vec2>) {
    let start = hull.len();
    for &point in points {
        while hull.len() >= start + 2 && cross(hull[hull.len() - 2], hull[hull.len() - 1], point) <= 0.0 {
            hull.pop();
        }
        if hull.len() == start || hull[hull.len() - 1] != point {
            hull.push(point);
        }
    }
}

/// Twice the area of the triangle a b c, positive if it turns left.
fn cross(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b - a).as_dvec2().perp_dot((c - a).as_dvec2())
}

/// Signed distance of `point` from the border of a region (m): positive inside, negative outside, −∞ from nothing.
///
/// Points and edges have no inside, so nothing balances on them with a margin above zero.
pub(crate) fn margin(hull: &[Vec2], point: Vec2) -> f32 {
    if hull.is_empty() {
        return f32::NEG_INFINITY;
    }
    let edges = || (0..hull.len()).map(|i| (hull[i], hull[(i + 1) % hull.len()]));
    let nearest = edges().map(|(a, b)| distance_to_segment(point, a, b)).fold(f32::INFINITY, f32::min);
    let is_inside = hull.len() >= 3 && edges().all(|(a, b)| cross(a, b, point) >= 0.0);
    if is_inside { nearest } else { -nearest }
}

/// Greatest distance of a region's vertices from the origin (m).
pub(crate) fn reach(hull: &[Vec2]) -> f32 {
    hull.iter().map(|vertex| vertex.length_squared()).fold(0.0, f32::max).sqrt()
}

fn distance_to_segment(point: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = b - a;
    let share = (point - a).dot(along) / along.length_squared();
    let nearest = if share > 0.0 { a + along * share.min(1.0) } else { a };
    point.distance(nearest)
}

/// What two regions have in common, into `out`: all of `region` where it lies inside `bound`, give or take the slack of `bound`.
pub(crate) fn intersect(region: &[Vec2], bound: &[Vec2], out: &mut Vec<Vec2>) {
    out.clear();
    if bound.is_empty() {
        return;
    }
    let slack = SLACK_SHARE * reach(bound);
    if region.iter().all(|&point| margin(bound, point) >= -slack) {
        out.extend_from_slice(region);
        return;
    }
    // Clip against the one that has sides to clip at.
    match (bound.len() >= 3, region.len() >= 3) {
        (true, _) => {
            out.extend_from_slice(region);
            clip(out, bound);
        }
        (false, true) => {
            out.extend_from_slice(bound);
            clip(out, region);
        }
        (false, false) => {
            out.extend(region.iter().filter(|&&point| margin(bound, point) >= -slack));
            out.extend(bound.iter().filter(|&&point| margin(region, point) >= -slack));
            out.extend(crossing(region, bound));
        }
    }
}

/// Cuts `polygon` at every side of the convex polygon `sides` (Sutherland and Hodgman 1974).
fn clip(polygon: &mut Vec<Vec2>, sides: &[Vec2]) {
    for i in 0..sides.len() {
        let (a, b) = (sides[i], sides[(i + 1) % sides.len()]);
        let count = polygon.len();
        for j in 0..count {
            let (from, to) = (polygon[j], polygon[(j + 1) % count]);
            let (left_from, left_to) = (cross(a, b, from), cross(a, b, to));
            if left_from >= 0.0 {
                polygon.push(from);
            }
            if (left_from > 0.0 && left_to < 0.0) || (left_from < 0.0 && left_to > 0.0) {
                polygon.push(from + (to - from) * (left_from / (left_from - left_to)) as f32);
            }
        }
        polygon.drain(..count);
    }
}

/// Where two edges cross.
fn crossing(p: &[Vec2], q: &[Vec2]) -> Option<Vec2> {
    let (&[a, b], &[c, d]) = (p, q) else { return None };
    let (from, to) = (cross(c, d, a), cross(c, d, b));
    let crosses = from * to < 0.0 && cross(a, b, c) * cross(a, b, d) < 0.0;
    crosses.then(|| a + (b - a) * (from / (from - to)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hull_of(points: &[(f32, f32)]) -> Vec<Vec2> {
        let mut hull = Vec::new();
        convex_hull(&mut points.iter().map(|&(x, y)| Vec2::new(x, y)).collect::<Vec<_>>(), &mut hull);
        hull
    }

    fn square(half: f32) -> Vec<Vec2> {
        hull_of(&[(-half, -half), (half, -half), (half, half), (-half, half)])
    }

    #[test]
    fn hulls_of_few_points_are_points_and_edges() {
        assert!(hull_of(&[]).is_empty());
        assert_eq!(hull_of(&[(1.0, 2.0)]), [Vec2::new(1.0, 2.0)]);
        assert_eq!(hull_of(&[(1.0, 2.0), (1.0, 2.0), (1.0, 2.0)]).len(), 1);
        assert_eq!(hull_of(&[(0.0, 0.0), (1.0, 1.0)]).len(), 2);
        assert_eq!(hull_of(&[(0.0, 0.0), (2.0, 2.0), (1.0, 1.0), (0.5, 0.5)]), [Vec2::ZERO, Vec2::splat(2.0)]);
        assert_eq!(hull_of(&[(0.0, 0.0), (0.0, 2.0), (0.0, 1.0)]).len(), 2);
        assert_eq!(hull_of(&[(0.0, 0.0), (2.0, 2.0), (1.0, 1.000001)]), [Vec2::ZERO, Vec2::splat(2.0)]);
        assert_eq!(hull_of(&[(0.0, 0.0), (2.0, 2.0), (1.0, 1.001)]).len(), 3);
    }

    #[test]
    fn a_hull_keeps_corners_alone_and_turns_left() {
        let hull = hull_of(&[(0.0, 0.0), (1.0, 0.0), (0.5, 0.0), (1.0, 1.0), (0.5, 0.5), (0.0, 1.0), (0.0, 0.5), (1.0, 0.0)]);
        assert_eq!(hull, [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    }

    #[test]
    fn margins_are_distances_to_the_border() {
        let hull = square(1.0);
        let cases = [((0.0, 0.0), 1.0), ((0.7, 0.0), 0.3), ((1.5, 0.0), -0.5), ((4.0, 5.0), -5.0)];
        for ((x, y), expected) in cases {
            let found = margin(&hull, Vec2::new(x, y));
            assert!((found - expected).abs() < 1e-6, "margin {found} m at ({x}, {y}), expected {expected} m");
        }
        assert_eq!(margin(&hull_of(&[(-1.0, 0.0), (1.0, 0.0)]), Vec2::new(0.0, 0.5)), -0.5);
        assert!(margin(&hull_of(&[(-1.0, 0.0), (1.0, 0.0)]), Vec2::ZERO) <= 0.0, "an edge has no inside");
        assert_eq!(margin(&[Vec2::X], Vec2::ZERO), -1.0);
        assert_eq!(margin(&[], Vec2::ZERO), f32::NEG_INFINITY);
    }

    #[test]
    fn regions_are_cut_where_the_support_below_ends() {
        let common = |a: &[Vec2], b: &[Vec2]| {
            let (mut out, mut hull) = (Vec::new(), Vec::new());
            intersect(a, b, &mut out);
            convex_hull(&mut out, &mut hull);
            hull
        };
        assert_eq!(common(&square(2.0), &square(1.0)), square(1.0));
        assert_eq!(common(&square(0.5), &square(1.0)), square(0.5));
        assert_eq!(common(&square(1.0005), &square(1.0)), square(1.0005), "within the slack nothing is cut");
        let far = square(0.5).iter().map(|&p| p + Vec2::X * 3.0).collect::<Vec<_>>();
        assert!(common(&far, &square(1.0)).is_empty());
        let sliver = hull_of(&[(-0.143_458_3, -0.215_630_11), (0.044_933_14, 0.303_808_36), (-0.143_458_3, -0.215_630_08)]);
        assert_eq!(common(&square(2.0), &sliver).len(), 2, "what is as thin as rounding carries from end to end");
        let edge = [Vec2::new(-3.0, 0.0), Vec2::new(3.0, 0.0)];
        assert_eq!(common(&edge, &square(1.0)), [Vec2::NEG_X, Vec2::X]);
        assert_eq!(common(&square(1.0), &edge), [Vec2::NEG_X, Vec2::X]);
        let upright = [Vec2::new(0.0, -3.0), Vec2::new(0.0, 3.0)];
        assert_eq!(common(&edge, &upright), [Vec2::ZERO]);
        assert_eq!(common(&[Vec2::X * 0.5], &edge), [Vec2::X * 0.5]);
        assert!(common(&[Vec2::Y], &edge).is_empty());
    }
}
