//! From any number of contact points to four: the deepest, then those that span the largest area.
//!
//! A later candidate must be better by a margin to win, so that equal candidates fall to the first, and a resting contact
//! keeps its choice when its points move by less than that margin.

use glam::Vec3;

use super::{MAX_POINTS, Manifold, ManifoldPoint};

/// How much better (relative) a later candidate must be.
const LEAD: f32 = 1.0e-3;

/// A contact point before reduction, both surfaces in one frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PointCandidate {
    pub on_a: Vec3,
    pub on_b: Vec3,
    pub separation: f32,
    pub feature: u32,
}

/// Fills `manifold` with at most four of `candidates`; depths within `tie` (m) count as equal. `place` gives the final point.
pub(super) fn reduce_into(
    manifold: &mut Manifold,
    candidates: &[PointCandidate],
    tie: f32,
    place: impl Fn(&PointCandidate) -> ManifoldPoint,
) {
    if candidates.len() <= MAX_POINTS {
        for candidate in candidates {
            manifold.push(place(candidate));
        }
        return;
    }
    let (kept, count) = choose(candidates, tie);
    for &index in &kept[..count] {
        manifold.push(place(&candidates[index]));
    }
}

/// Adds to the points that `manifold` has as many of `candidates` as there is room for, those that span the largest area with them.
pub(super) fn fill(
    manifold: &mut Manifold,
    candidates: &[PointCandidate],
    tie: f32,
    place: impl Fn(&PointCandidate) -> ManifoldPoint,
) {
    let known = usize::from(manifold.count);
    if known == 0 || known + candidates.len() <= MAX_POINTS {
        return reduce_into(manifold, candidates, tie, place);
    }
    let mut chosen = manifold.points.map(|point| point.on_a);
    for count in known..MAX_POINTS {
        let Some(next) = widest(&chosen[..count], candidates) else { return };
        chosen[count] = candidates[next].on_a;
        manifold.push(place(&candidates[next]));
    }
}

fn choose(candidates: &[PointCandidate], tie: f32) -> ([usize; MAX_POINTS], usize) {
    let first = candidates
        .iter()
        .enumerate()
        .skip(1)
        .fold(0, |best, (i, c)| if c.separation < candidates[best].separation - tie { i } else { best });
    let mut kept = [first, 0, 0, 0];
    let mut chosen = [candidates[first].on_a; MAX_POINTS];
    for count in 1..MAX_POINTS {
        let Some(next) = widest(&chosen[..count], candidates) else { return (kept, count) };
        (kept[count], chosen[count]) = (next, candidates[next].on_a);
    }
    (kept, MAX_POINTS)
}

/// The candidate that spans the most with one to three points chosen before, if any spans more than they do.
fn widest(chosen: &[Vec3], candidates: &[PointCandidate]) -> Option<usize> {
    let (at, count) = (|i: usize| candidates[i].on_a, candidates.len());
    let base = || chosen[1] - chosen[0];
    match *chosen {
        [first] => largest(count, |i| at(i).distance_squared(first)).map(|(second, _)| second),
        [first, _] => largest(count, |i| base().cross(at(i) - first).length_squared()).map(|(third, _)| third),
        [first, second, third] => {
            let area = base().cross(third - first);
            let size = area.length();
            let corners = [first, second, third];
            let outward = [0, 1, 2].map(|k| (corners[(k + 1) % 3] - corners[k]).cross(area / size));
            // Area that a point adds to the triangle: that beyond the edge it is furthest out of.
            let added = |i: usize| {
                let beyond = |k: usize| outward[k].dot(at(i) - corners[k]);
                beyond(0).max(beyond(1)).max(beyond(2))
            };
            largest(count, added).filter(|&(_, gain)| gain > LEAD * size).map(|(fourth, _)| fourth)
        }
        _ => None,
    }
}

/// The first candidate with the largest positive measure, up to [`LEAD`].
fn largest(count: usize, measure: impl Fn(usize) -> f32) -> Option<(usize, f32)> {
    let mut best = None;
    let mut to_beat = 0.0;
    for i in 0..count {
        let value = measure(i);
        if value > to_beat {
            best = Some((i, value));
            to_beat = value * (1.0 + LEAD);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reduced(points: &[(f32, f32, f32)]) -> Vec<u32> {
        let candidates: Vec<_> = points
            .iter()
            .enumerate()
            .map(|(i, &(x, z, separation))| PointCandidate {
                on_a: Vec3::new(x, 0.0, z),
                on_b: Vec3::new(x, separation, z),
                separation,
                feature: i as u32,
            })
            .collect();
        let mut manifold = Manifold::default();
        reduce_into(&mut manifold, &candidates, 1e-4, |c| ManifoldPoint { feature: c.feature, ..Default::default() });
        manifold.contacts().iter().map(|p| p.feature).collect()
    }

    fn octagon(jitter: f32) -> Vec<(f32, f32, f32)> {
        (0..8)
            .map(|i| {
                let (sin, cos) = (i as f32 * std::f32::consts::FRAC_PI_4 + 0.2).sin_cos();
                let noise = jitter * ((i * 7 % 5) as f32 - 2.0);
                (cos + noise, sin - noise, noise)
            })
            .collect()
    }

    #[test]
    fn a_regular_octagon_reduces_to_a_square_and_keeps_it_under_jitter() {
        assert_eq!(reduced(&octagon(0.0)), [0, 4, 2, 6]);
        for jitter in [1e-6, -1e-6, 1e-5] {
            assert_eq!(reduced(&octagon(jitter)), [0, 4, 2, 6], "jitter {jitter} m");
        }
    }

    #[test]
    fn the_deepest_point_is_always_kept_and_comes_first() {
        let mut points = octagon(0.0);
        points.push((0.1, 0.0, -0.5));
        assert_eq!(reduced(&points)[0], 8);
    }

    #[test]
    fn points_on_a_line_or_on_one_spot_leave_no_spare() {
        let line: Vec<_> = (0..6).map(|i| (i as f32, 0.0, 0.0)).collect();
        assert_eq!(reduced(&line), [0, 5]);
        assert_eq!(reduced(&[(1.0, 1.0, 0.0); 6]), [0]);
    }
}
