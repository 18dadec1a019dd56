//! Depth and direction of least overlap of two convex parts (van den Bergen 2001), in double precision.
//!
//! The origin lies inside the body of all b − a. A polytope of its points grows from the simplex that GJK left: the face
//! nearest to the origin is pushed out to the surface until it lies on it. Its distance is the depth, its normal the way in.

use glam::{DQuat, DVec3};

use super::gjk::{self, Closest, Simplex, SimplexVertex};
use super::part::ConvexPart;

/// Error of the depth at which the search ends, over the depth and over the size of the parts.
const TOLERANCE: (f64, f64) = (1.0e-9, 1.0e-12);

/// A corner closer than this to the plane, line or point of those before it adds nothing, over the size of the parts.
const FLAT: f64 = 1.0e-12;

/// Faces whose normals differ by less (1 − cosine) lie across the same way out.
const ALIGNED: f64 = 1.0e-12;

/// Steps of the search: round rims take the most.
const MAX_STEPS: usize = 256;

/// Steps after those, at one place: each halves an arc of a rim or more, and so quarters the error.
const LAST_STEPS: usize = 48;

/// How far the deepest points may be beside each other before they are looked for anew, over the size of the parts: rounding.
const ASIDE: f64 = 1.0e-9;

/// How far apart the parts are moved for that, over their size: little beside what they curve over, much beside rounding.
const ROOM: f64 = 1.0e-4;

/// How deep two parts overlap, without their rounding.
pub(super) struct Depth {
    /// Least depth (m), ≥ 0.
    pub depth: f64,
    /// Unit direction in which B is to be pushed out of A.
    pub normal: DVec3,
    pub on_a: DVec3,
    pub on_b: DVec3,
}

struct EpaFace {
    corners: [usize; 3],
    normal: DVec3,
    /// Distance of the plane from the origin (m).
    distance: f64,
}

/// How deep two parts overlap whose `simplex` holds the origin.
pub(super) fn depth(a: &ConvexPart, b: &ConvexPart, simplex: &Simplex) -> Depth {
    let mut corners = simplex.corners[..simplex.count].to_vec();
    let size = a.reach().max(b.reach()).max(f64::MIN_POSITIVE);
    if let Err(normal) = fill_tetrahedron(a, b, &mut corners, FLAT * size) {
        // All b − a lie in a plane: the way out is across it, on the side of B.
        let (on_a, on_b) = simplex.points();
        let side = normal.dot(b.place.origin - a.place.origin);
        return Depth { depth: 0.0, normal: normal * 1.0_f64.copysign(side), on_a, on_b };
    }
    let mut faces: Vec<EpaFace> = Vec::with_capacity(32);
    let middle = corners.iter().map(|corner| corner.offset).sum::<DVec3>() * 0.25;
    for triangle in [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]] {
        let [p, q, r] = triangle.map(|i| corners[i].offset);
        let outward = (q - p).cross(r - p).dot(p - middle) > 0.0;
        push(&mut faces, &corners, if outward { triangle } else { [triangle[0], triangle[2], triangle[1]] });
    }
    // The way out along any direction is no shorter than the least; the polytope is no deeper. Between the two lies the answer, and
    // where they are nearest to each other the points are surest: a later step may fold the surface at a needle.
    let (mut least, mut shortest) = (f64::INFINITY, DVec3::Y);
    let (mut doubt, mut found) = (f64::INFINITY, None);
    for step in 0..MAX_STEPS + LAST_STEPS {
        // Where two parts are round about one line, the way out is as short all round: no number of steps makes all of the rim exact. What
        // is left of them goes to where the last corner is.
        let nearest = nearest(&faces, (step >= MAX_STEPS).then(|| corners.len() - 1));
        let (normal, distance) = (faces[nearest].normal, faces[nearest].distance);
        let next = SimplexVertex::support(a, b, normal);
        let way_out = normal.dot(next.offset);
        if way_out < least {
            (least, shortest) = (way_out, normal);
        }
        if found.is_none() || way_out - distance < doubt {
            (doubt, found) = (way_out - distance, Some(way_through(&faces, &corners, nearest, way_out)));
        }
        if least - distance <= TOLERANCE.0 * least + TOLERANCE.1 * size
            || !take_in(&mut faces, &mut corners, next, TOLERANCE.1 * size)
        {
            break;
        }
    }
    let found = found.unwrap_or_else(|| way_through(&faces, &corners, 0, faces[0].distance));
    let is_shortest = found.depth <= least + TOLERANCE.0 * least + TOLERANCE.1 * size;
    let way = found.on_a - found.on_b;
    if is_shortest && way.distance(found.normal * found.depth) <= ASIDE * size {
        return Depth { depth: found.depth.max(0.0), ..found };
    }
    // Where the surface was surest is not where the way out is shortest, or its needles hide what is behind it.
    let (depth, normal) = if is_shortest { (found.depth, found.normal) } else { (least, -shortest) };
    let (on_a, on_b) = opposite(a, b, normal * depth, normal * (ROOM * size)).unwrap_or((found.on_a, found.on_b));
    Depth { depth: depth.max(0.0), normal, on_a, on_b }
}

/// The points that a way out leads from and to: the nearest ones once B is pushed out by it, and by some room more.
fn opposite(a: &ConvexPart, b: &ConvexPart, way_out: DVec3, room: DVec3) -> Option<(DVec3, DVec3)> {
    let pushed = b.moved(way_out + room, DQuat::IDENTITY, DVec3::ZERO);
    let Closest::Apart { on_a, .. } = gjk::closest(a, &pushed) else { return None };
    Some((on_a, on_a - way_out))
}

/// The way out of a given length across a face: the points on A and B that it leads from and to.
fn way_through(faces: &[EpaFace], corners: &[SimplexVertex], number: usize, depth: f64) -> Depth {
    let normal = faces[number].normal;
    // Of the faces across the way out, the one that it passes through.
    let across = faces.iter().filter(|face| face.normal.dot(normal) > 1.0 - ALIGNED);
    let inner = |face: &EpaFace| shares(face, corners).into_iter().fold(f64::INFINITY, f64::min);
    let face = across.max_by(|a, b| inner(a).total_cmp(&inner(b))).unwrap_or(&faces[number]);
    let (on_a, on_b) = points(face, corners);
    // On B's side of the way out both points are where its plane is.
    let off = (on_b - on_a).dot(normal) - depth;
    Depth { depth, normal: -normal, on_a, on_b: on_b - normal * off }
}

/// The face nearest to the origin, of all or of those at a corner.
fn nearest(faces: &[EpaFace], at: Option<usize>) -> usize {
    let counts = |face: &EpaFace| at.is_none_or(|corner| face.corners.contains(&corner));
    let nearer = |best: usize, i: usize| {
        let (face, known) = (&faces[i], &faces[best]);
        if counts(face) && (!counts(known) || face.distance < known.distance) { i } else { best }
    };
    (1..faces.len()).fold(0, nearer)
}

/// Adds corners until there are four that are not in one plane; where all are, the normal of a plane that holds them.
fn fill_tetrahedron(a: &ConvexPart, b: &ConvexPart, corners: &mut Vec<SimplexVertex>, flat: f64) -> Result<(), DVec3> {
    let mut kept: Vec<SimplexVertex> = Vec::with_capacity(4);
    for &corner in corners.iter() {
        if off(&kept, corner.offset) > flat {
            kept.push(corner);
        }
    }
    while kept.len() < 4 {
        let directions = match *kept {
            [] => vec![DVec3::X],
            [_] => vec![DVec3::X, DVec3::Y, DVec3::Z],
            [p, q] => {
                let (u, v) = (q.offset - p.offset).normalize().any_orthonormal_pair();
                vec![u, v]
            }
            _ => vec![normal_of(&kept)],
        };
        let fallback = directions[0];
        let both = directions.into_iter().flat_map(|direction| [direction, -direction]);
        let candidates = both.map(|direction| SimplexVertex::support(a, b, direction));
        let best = candidates.max_by(|x, y| off(&kept, x.offset).total_cmp(&off(&kept, y.offset)));
        match best {
            Some(corner) if kept.is_empty() || off(&kept, corner.offset) > flat => kept.push(corner),
            _ if kept.len() == 1 => return Err(DVec3::Y),
            _ => return Err(fallback),
        }
    }
    *corners = kept;
    Ok(())
}

fn normal_of(corners: &[SimplexVertex]) -> DVec3 {
    let [p, q, r] = [0, 1, 2].map(|i| corners[i].offset);
    (q - p).cross(r - p).normalize_or(DVec3::Y)
}

/// Distance of a point from the point, line or plane of up to three corners (m).
fn off(corners: &[SimplexVertex], point: DVec3) -> f64 {
    match *corners {
        [] => f64::INFINITY,
        [p] => point.distance(p.offset),
        [p, q] => (point - p.offset).reject_from((q.offset - p.offset).normalize()).length(),
        [p, ..] => (point - p.offset).dot(normal_of(corners)).abs(),
    }
}

fn push(faces: &mut Vec<EpaFace>, corners: &[SimplexVertex], triangle: [usize; 3]) {
    let [p, q, r] = triangle.map(|i| corners[i].offset);
    // A needle without a normal is never the nearest.
    let normal = (q - p).cross(r - p).try_normalize();
    let distance = normal.map_or(f64::INFINITY, |normal| normal.dot(p).max(normal.dot(q)).max(normal.dot(r)));
    faces.push(EpaFace { corners: triangle, normal: normal.unwrap_or(DVec3::ZERO), distance });
}

/// Puts a corner in place of the faces that it is above; false, with nothing changed, if there are none or if rounding has them
/// leave no simple loop: a surface that is no longer closed would grow without end.
fn take_in(faces: &mut Vec<EpaFace>, corners: &mut Vec<SimplexVertex>, next: SimplexVertex, slack: f64) -> bool {
    let is_seen = |face: &EpaFace| face.normal.dot(next.offset) > face.distance + slack;
    let mut rim: Vec<(usize, usize)> = Vec::new();
    for face in faces.iter().filter(|face| is_seen(face)) {
        for side in 0..3 {
            let edge = (face.corners[side], face.corners[(side + 1) % 3]);
            // An edge between two faces that go cancels out.
            match rim.iter().position(|&(from, to)| (to, from) == edge) {
                Some(inner) => drop(rim.swap_remove(inner)),
                None => rim.push(edge),
            }
        }
    }
    if !is_loop(&rim) {
        return false;
    }
    faces.retain(|face| !is_seen(face));
    let number = corners.len();
    corners.push(next);
    for (from, to) in rim {
        push(faces, corners, [from, to, number]);
    }
    true
}

/// Whether edges form one loop that meets no corner twice.
fn is_loop(rim: &[(usize, usize)]) -> bool {
    let Some(&(start, mut at)) = rim.first() else { return false };
    for length in 1..=rim.len() {
        if at == start {
            return length == rim.len();
        }
        let mut onward = rim.iter().filter(|(from, _)| *from == at);
        match (onward.next(), onward.next()) {
            (Some(&(_, to)), None) => at = to,
            _ => return false,
        }
    }
    false
}

/// The shares of a face's corners that make the foot of the origin on its plane; one of them is negative if that is outside.
fn shares(face: &EpaFace, corners: &[SimplexVertex]) -> [f64; 3] {
    let [p, q, r] = face.corners.map(|i| corners[i].offset);
    let foot = face.normal * face.distance;
    let (u, v, w) = (q - p, r - p, foot - p);
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let area = uu * vv - uv * uv;
    let (s, t) = if area > 0.0 { ((vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area) } else { (0.0, 0.0) };
    [1.0 - s - t, s, t]
}

/// The points on A and B behind the foot of the origin on a face.
fn points(face: &EpaFace, corners: &[SimplexVertex]) -> (DVec3, DVec3) {
    // What rounding puts outside a needle is brought back, so that both points are points of their parts.
    let shares = shares(face, corners).map(|share| share.max(0.0));
    let total: f64 = shares.iter().sum();
    let of =
        |part: fn(&SimplexVertex) -> DVec3| (0..3).map(|i| part(&corners[face.corners[i]]) * (shares[i] / total)).sum::<DVec3>();
    (of(|corner| corner.on_a), of(|corner| corner.on_b))
}

#[cfg(test)]
mod tests {
    use super::super::gap;
    use super::super::part::{PartForm, tests::part};
    use super::*;

    /// A random pair whose search folded its surface at a needle in its last steps.
    #[test]
    fn the_deepest_points_are_on_both_parts() {
        let cone = part(
            PartForm::Cone { half_height: 0.3725338578224182, radius: 0.920171856880188 },
            DVec3::new(-1.487628280579088, -0.13918377121973435, -0.9416581810330626),
            [DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.0, 0.0, 1.0)],
        );
        let bar = part(
            PartForm::Box { half_extents: DVec3::new(0.7881396412849426, 0.7148962020874023, 0.23745213449001312) },
            DVec3::new(0.0, 0.0, 0.0),
            [
                DVec3::new(0.07506759773152027, -0.844797409988346, -0.5297944807638155),
                DVec3::new(-0.6990966782280703, 0.3342731204695597, -0.6320801495237933),
                DVec3::new(0.7110757275152177, 0.41782630004408006, -0.5655019829586609),
            ],
        );
        let found = gap::gap(&cone, &bar).unwrap();
        let outside = [cone.outside(found.on_a), bar.outside(found.on_b)];
        assert!(outside.iter().all(|&outside| outside < 1.0e-9), "{outside:?} m outside");
        assert!((gap::along(&cone, &bar, found.normal) - found.distance).abs() < 1.0e-9, "{found:?}");
        assert!(((found.on_b - found.on_a).dot(found.normal) - found.distance).abs() < 1.0e-9, "{found:?}");
    }
}
