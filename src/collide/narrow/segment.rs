//! Segments inside capsules, and edges: nearest points, and the stretch on which two run side by side.

use glam::Vec3;
use parry3d::math::Pose3;

/// Shortest stretch that counts as a line of contact, as a fraction of the radii.
const MIN_STRETCH: f32 = 1.0e-2;

/// How far the two segments may part sideways at the ends of a line of contact, as a fraction of the radii: this much
/// costs an eighth of a percent of the radii in distance.
const MAX_SKEW: f32 = 0.05;

/// How far the normal may lean along either segment at a line of contact (sine): beside the end of a capsule, a point
/// along the normal is then within 0.05 % of the radius of its surface.
pub(super) const MAX_LEAN: f32 = 0.03;

/// Squared sine below which two segments are parallel.
pub(super) const PARALLEL: f32 = 1.0e-10;

/// The points center + s·half, −1 ≤ s ≤ 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub center: Vec3,
    pub half: Vec3,
}

impl Segment {
    /// The inner segment of a capsule placed at `pose`.
    pub fn of_capsule(half_height: f32, pose: &Pose3) -> Self {
        Self { center: pose.translation, half: pose.rotation * Vec3::new(0.0, half_height, 0.0) }
    }

    pub fn between(from: Vec3, to: Vec3) -> Self {
        Self { center: 0.5 * (from + to), half: 0.5 * (to - from) }
    }

    pub fn at(&self, s: f32) -> Vec3 {
        self.center + self.half * s
    }

    /// Distance (m) along the unit vector `toward` from the point at `s` to the surface of the capsule of `radius` around
    /// this segment. At the end that leads that way it is the radius; further back the side, or the end's ball, is further.
    pub fn depth_of(&self, s: f32, toward: Vec3, radius: f32) -> f32 {
        let length = self.half.length();
        let lean = (toward.dot(self.half) / length).clamp(-1.0, 1.0);
        let back = (1.0 - s * 1.0_f32.copysign(lean)) * length;
        let (sin, cos_squared) = (lean.abs(), 1.0 - lean * lean);
        if back * cos_squared <= radius * sin * cos_squared.sqrt() {
            back * sin + (radius * radius - back * back * cos_squared).max(0.0).sqrt()
        } else {
            radius / cos_squared.sqrt()
        }
    }

    /// Parameters of the closest points of two segments (Ericson, Real-Time Collision Detection, §5.1.9, with centres for
    /// origins; the determinant is taken from the cross product, which does not cancel near parallel).
    pub fn closest(&self, other: &Self) -> (f32, f32) {
        let (u, v, r) = (self.half, other.half, self.center - other.center);
        let (uu, vv, uv) = (u.length_squared(), v.length_squared(), u.dot(v));
        let (ur, vr) = (u.dot(r), v.dot(r));
        let determinant = u.cross(v).length_squared();
        let s = if determinant > PARALLEL * uu * vv { ((uv * vr - ur * vv) / determinant).clamp(-1.0, 1.0) } else { 0.0 };
        let t = (uv * s + vr) / vv;
        if t.abs() <= 1.0 {
            return (s, t);
        }
        let t = t.clamp(-1.0, 1.0);
        (((uv * t - ur) / uu).clamp(-1.0, 1.0), t)
    }

    /// The pairs of points at both ends of the stretch where the segments run side by side across `normal`, from the low to
    /// the high end of `self`; none if they cross, or only meet at their ends. `radii` (m) is the scale of the contact.
    pub fn side_by_side(&self, other: &Self, normal: Vec3, radii: f32) -> Option<[(Vec3, Vec3); 2]> {
        let leans = |half: Vec3| normal.dot(half).abs() > MAX_LEAN * half.length();
        if leans(self.half) || leans(other.half) {
            return None;
        }
        let squared = self.half.length_squared();
        let slope = other.half.dot(self.half) / squared;
        let middle = (other.center - self.center).dot(self.half) / squared;
        let (low, high) = ((middle - slope.abs()).max(-1.0), (middle + slope.abs()).min(1.0));
        let stretch = (high - low) * squared.sqrt();
        if stretch.is_nan() || stretch < MIN_STRETCH * radii {
            return None;
        }
        let pair = |s: f32| {
            let facing = (self.at(s), other.at(((s - middle) / slope).clamp(-1.0, 1.0)));
            let skew = (facing.1 - facing.0).reject_from_normalized(normal);
            (skew.length_squared() <= (MAX_SKEW * radii) * (MAX_SKEW * radii)).then_some(facing)
        };
        Some([pair(low)?, pair(high)?])
    }
}
