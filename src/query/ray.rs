//! Where a ray enters a convex part, in closed form and double precision.
//!
//! A solid is where a few conditions hold at once: between planes, inside a quadric. Along a ray each holds on an interval,
//! and the ray is inside where all intervals meet (Kay and Kajiya 1986). The one that begins last has the normal.

use glam::{DVec2, DVec3};

use super::part::{ConvexPart, PartForm};

/// How far outside a triangle's edge a ray may pass and still meet it, over the triangle's extent as the ray sees it: what
/// rotations round away. Edges that two triangles share are met exactly.
const EDGE: f64 = 1.0e-12;

/// Where a ray is inside what holds so far, and the normal where it comes in.
#[derive(Clone, Copy)]
struct Stretch {
    from: f64,
    to: f64,
    normal: Option<DVec3>,
}

impl Stretch {
    fn all() -> Self {
        Self { from: f64::NEG_INFINITY, to: f64::INFINITY, normal: None }
    }

    fn none() -> Self {
        Self { from: f64::INFINITY, to: f64::NEG_INFINITY, normal: None }
    }

    fn cut(&mut self, from: f64, to: f64, normal: impl FnOnce() -> DVec3) {
        if from > self.from {
            (self.from, self.normal) = (from, Some(normal()));
        }
        self.to = self.to.min(to);
    }

    /// Keeps where n·p ≤ offset.
    fn cut_plane(&mut self, origin: DVec3, direction: DVec3, normal: DVec3, offset: f64) {
        let (height, closing) = (normal.dot(origin) - offset, normal.dot(direction));
        if closing < 0.0 {
            self.cut(height / -closing, f64::INFINITY, || normal);
        } else if closing > 0.0 {
            self.to = self.to.min(-height / closing);
        } else if height > 0.0 {
            *self = Self::none();
        }
    }

    /// Keeps where a t² + 2 b t + c ≤ 0, for a ≥ 0.
    fn cut_quadric(&mut self, a: f64, b: f64, c: f64, normal: impl FnOnce(f64) -> DVec3) {
        match roots(a, b, c) {
            Some((from, to)) => self.cut(from, to, || normal(from)),
            None if c > 0.0 => *self = Self::none(),
            None => {}
        }
    }

    fn is_empty(&self) -> bool {
        self.from > self.to
    }
}

/// Roots of a t² + 2 b t + c, the lesser first; none if there are none or if it is constant.
fn roots(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    if a == 0.0 {
        return None;
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    // The root without cancellation first.
    let q = -(b + discriminant.sqrt().copysign(b));
    let (first, second) = (q / a, if q == 0.0 { 0.0 } else { c / q });
    Some((first.min(second), first.max(second)))
}

/// Where a ray first meets a part: distance (m) and outward normal, both in the frame of the query. A ray that begins inside a
/// solid meets it at 0, against its direction. `direction` is a unit vector.
pub(super) fn enter(part: &ConvexPart, origin: DVec3, direction: DVec3, length: f64) -> Option<(f64, DVec3)> {
    if let PartForm::Triangle(corners) = part.form {
        return triangle(corners, origin, direction).filter(|&(distance, _)| distance <= length);
    }
    let (start, along) = (part.place.to_local(origin), part.place.axes.transpose() * direction);
    // Seen from the point of the ray nearest to the part, nothing is lost to the length of the way there.
    let shift = if matches!(part.form, PartForm::HalfSpace { .. }) { 0.0 } else { -start.dot(along) };
    let inside = stretch(part, start + along * shift, along);
    let (from, to) = (inside.from + shift, inside.to + shift);
    if inside.is_empty() || to < 0.0 || from > length {
        return None;
    }
    match inside.normal {
        Some(normal) if from > 0.0 => Some((from, part.place.axes * normal)),
        _ => Some((0.0, -direction)),
    }
}

fn stretch(part: &ConvexPart, o: DVec3, d: DVec3) -> Stretch {
    let mut inside = Stretch::all();
    match part.form {
        PartForm::Triangle(_) => {}
        PartForm::HalfSpace { normal } => inside.cut_plane(o, d, normal, 0.0),
        PartForm::Point => inside = ball(o, d, part.rounding),
        PartForm::Segment { half_height } => inside = capsule(o, d, half_height, part.rounding),
        PartForm::Box { half_extents } => {
            for axis in 0..3 {
                let mut normal = DVec3::ZERO;
                normal[axis] = 1.0;
                inside.cut_plane(o, d, normal, half_extents[axis]);
                inside.cut_plane(o, d, -normal, half_extents[axis]);
            }
        }
        PartForm::Cylinder { half_height, radius } => {
            inside.cut_plane(o, d, DVec3::Y, half_height);
            inside.cut_plane(o, d, DVec3::NEG_Y, half_height);
            around_axis(&mut inside, o, d, radius);
        }
        PartForm::Cone { half_height, radius } => {
            inside.cut_plane(o, d, DVec3::Y, half_height);
            inside.cut_plane(o, d, DVec3::NEG_Y, half_height);
            cone_side(&mut inside, o, d, half_height, radius);
        }
        PartForm::Hull(hull) => {
            for &(normal, offset) in hull.planes() {
                inside.cut_plane(o, d, normal, offset);
                if inside.is_empty() {
                    break;
                }
            }
        }
    }
    inside
}

fn ball(o: DVec3, d: DVec3, radius: f64) -> Stretch {
    let mut inside = Stretch::all();
    inside.cut_quadric(d.length_squared(), o.dot(d), o.length_squared() - radius * radius, |t| (o + d * t).normalize_or(-d));
    inside
}

fn around_axis(inside: &mut Stretch, o: DVec3, d: DVec3, radius: f64) {
    let (p, q) = (DVec2::new(o.x, o.z), DVec2::new(d.x, d.z));
    let normal = |t: f64| {
        let n = (p + q * t).normalize_or(DVec2::X);
        DVec3::new(n.x, 0.0, n.y)
    };
    inside.cut_quadric(q.length_squared(), p.dot(q), p.length_squared() - radius * radius, normal);
}

/// A capsule is the union of a tube and two balls, and convex: from the first entry to the last exit.
fn capsule(o: DVec3, d: DVec3, half_height: f64, radius: f64) -> Stretch {
    let mut tube = Stretch::all();
    tube.cut_plane(o, d, DVec3::Y, half_height);
    tube.cut_plane(o, d, DVec3::NEG_Y, half_height);
    around_axis(&mut tube, o, d, radius);
    let ends = [half_height, -half_height].map(|y| ball(o - DVec3::Y * y, d, radius));
    let mut whole: Option<Stretch> = None;
    // A tube is entered through an end inside a ball: its flat end is no surface.
    for piece in ends.into_iter().chain([tube]).filter(|piece| !piece.is_empty()) {
        whole = Some(match whole {
            None => piece,
            Some(known) => {
                let first = if piece.from < known.from { piece } else { known };
                Stretch { to: known.to.max(piece.to), ..first }
            }
        });
    }
    whole.unwrap_or(Stretch::none())
}

/// Keeps what lies in the cone below its tip: x² + z² ≤ k² s² with s = h − y ≥ 0, k = r/(2h). The planes of its ends have been cut.
fn cone_side(inside: &mut Stretch, o: DVec3, d: DVec3, half_height: f64, radius: f64) {
    let k = radius / (2.0 * half_height);
    let s = half_height - o.y;
    let a = d.x * d.x + d.z * d.z - k * k * d.y * d.y;
    let b = o.x * d.x + o.z * d.z + k * k * s * d.y;
    let c = o.x * o.x + o.z * o.z - k * k * s * s;
    let normal = |t: f64| {
        let p = o + d * t;
        let across = DVec3::new(p.x, 0.0, p.z).normalize_or(DVec3::X);
        (across + DVec3::Y * k).normalize()
    };
    // Along a line of the cone's side it is linear.
    if a.abs() <= 1.0e-14 * (1.0 + k * k) {
        if b == 0.0 {
            if c > 0.0 {
                *inside = Stretch::none();
            }
        } else {
            let t = -c / (2.0 * b);
            if b < 0.0 { inside.cut(t, f64::INFINITY, || normal(t)) } else { inside.to = inside.to.min(t) }
        }
    } else if a > 0.0 {
        inside.cut_quadric(a, b, c, normal);
    } else {
        // Steeper than the side: inside one nappe before the first root and inside the other after the second, which is this one for a
        // line that leads away from its tip. Through the tip the two roots are one, up to rounding.
        let (first, second) = roots(a, b, c).unwrap_or((-b / a, -b / a));
        if d.y < 0.0 { inside.cut(second, f64::INFINITY, || normal(second)) } else { inside.to = inside.to.min(first) }
    }
}

/// Where a ray meets a triangle (Woop, Benthin and Wald 2013). Seen along the ray, the origin is inside if it is on the same
/// side of all edges, or on one: the sides of an edge that two triangles share are exactly opposite.
fn triangle(corners: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
    let size = direction.abs();
    let z = if size.x > size.y && size.x > size.z {
        0
    } else if size.y > size.z {
        1
    } else {
        2
    };
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let shear = (direction[x] / direction[z], direction[y] / direction[z]);
    let seen = corners.map(|corner| {
        let p = corner - origin;
        (p[x] - shear.0 * p[z], p[y] - shear.1 * p[z], p[z])
    });
    let side = |a: (f64, f64, f64), b: (f64, f64, f64)| a.0 * b.1 - a.1 * b.0;
    let [a, b, c] = seen;
    let (u, v, w) = (side(b, c), side(c, a), side(a, b));
    let extent = seen.iter().flat_map(|p| seen.iter().map(|q| (p.0 - q.0).abs().max((p.1 - q.1).abs()))).fold(0.0, f64::max);
    let slack = EDGE * extent * (extent + seen.iter().map(|p| p.0.abs().max(p.1.abs())).fold(0.0, f64::max));
    let [low, high] = [u.min(v).min(w), u.max(v).max(w)];
    let sum = u + v + w;
    if (low < -slack && high > slack) || sum == 0.0 {
        return None;
    }
    let distance = (u * a.2 + v * b.2 + w * c.2) / sum / direction[z];
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize()?;
    let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
    (distance >= 0.0).then_some((distance, normal))
}
