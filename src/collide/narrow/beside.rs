//! Long parts that cross at a small angle, or lean on each other: how far apart they are away from where they are nearest.
//!
//! Two lines of round surfaces whose radii add up to R, and which cross at an angle θ, are nearest at one point. At a distance z from there
//! they are w = θ z beside each other, and along the normal further apart by the sagitta
//!
//! ```text
//! R − √(R² − w²) ≈ θ² z² / 2R:
//! ```
//!
//! a log nine radii long that lies on another, off by a hundredth of a radian, has its ends 0.002 radii higher than its middle. With a
//! row at the nearest point alone it turns about that freely for a step, and an end that comes down at a third of a radius a step is inside the
//! other before there is a row for it; then that end has the only one, and the other end goes in. So the ends of the stretch are points
//! too, each at its own distance along the common normal. While they rest apart they are further off than the margin, and the nearest point
//! is left.

use glam::Vec3;
use parry3d::math::Pose3;

use super::face::Corner;
use super::part::Part;
use super::segment::Segment;
use super::{Manifold, ManifoldPoint};

/// How far the surfaces may part sideways at an end of the stretch, over the sum of their radii.
///
/// Why: a row at the end of a stretch lets two surfaces that rock over each other overlap by a quarter of the sagitta there, midway to the
/// nearest point. The sagitta at this is a tenth of the radii, so that overlap is a fortieth of them, a twentieth of a radius; and what rocks is held
/// up by no more than θ/4 a step.
/// Scenes: logs across logs, 0.0005 to 0.5 rad, half lengths of 2 to 40 radii, 30 to 240 Hz.
/// Test: tests/logs.rs
const ASIDE: f32 = 0.436;

/// Shortest way from the nearest point to an end that says more than it does, over the sum of the radii: on less, a turn within a step leads no
/// deeper than what is missing at any point contact.
const ARM: f32 = 0.5;

/// A line of the surface of a long part that faces the other, and the radii of curvature across it at its low and its high end (m).
pub(super) struct Side {
    pub line: Segment,
    pub radii: [f32; 2],
}

/// Points of two surfaces across from each other along a normal, and their distance along it (m).
pub(super) struct Across {
    pub on_a: Vec3,
    pub on_b: Vec3,
    pub separation: f32,
}

impl Side {
    /// Of the surface at `radius` around a core, where its outward normal is nearly this.
    pub fn around(core: &Segment, radius: f32, outward: Vec3) -> Self {
        let lean = outward.dot(core.half).powi(2) / core.half.length_squared();
        let depth = radius / (1.0 - lean).sqrt();
        Self { line: Segment { center: core.center + outward * depth, ..*core }, radii: [radius; 2] }
    }

    /// Of the edge of a part, of which these are the ends in the frame of the contact; none of a face.
    pub fn of(part: &Part, corners: &[Corner], outward: Vec3) -> Option<Self> {
        let &[(from, _), (to, _)] = corners else { return None };
        let line = Segment::between(from, to);
        let radii = match *part {
            Part::Capsule { radius, .. } => return Some(Self::around(&line, radius, outward)),
            Part::Cylinder { radius, .. } => [radius; 2],
            // What a cone is round by grows along its side: its line alone is taken.
            _ => [0.0; 2],
        };
        Some(Self { line, radii })
    }

    fn radius(&self, s: f32) -> f32 {
        let [low, high] = self.radii;
        0.5 * (low + high + (high - low) * s)
    }
}

/// The ends of the stretch on which A and B lie beside each other along `normal`, from the low to the high end of A; none where an end is hardly
/// further than the point `near`, where they are nearest, or where the two rather stand on each other or cross.
pub(super) fn ends(a: &Side, b: &Side, normal: Vec3, near: Vec3) -> [Option<Across>; 2] {
    let flat = |half: Vec3| half.reject_from_normalized(normal);
    let (of_a, of_b) = (flat(a.line.half), flat(b.line.half));
    let (reach, between) = (of_a.length(), b.line.center - a.line.center);
    let along = of_a / reach;
    let across = normal.cross(along);
    let (reach_b, drift) = (of_b.dot(along), of_b.dot(across));
    // Less than an eighth of a turn from each other and from the plane across the normal; written so that a NaN, or no length, is none.
    let is_long = 2.0 * reach * reach > a.line.half.length_squared() && 2.0 * reach_b * reach_b > b.line.half.length_squared();
    if !is_long {
        return [None, None];
    }
    let (middle, aside) = (between.dot(along), between.dot(across));
    let at = |z: f32| (z / reach, (z - middle) / reach_b);
    let sideways = |z: f32| aside + drift * at(z).1;
    let radii = |z: f32| (a.radius(at(z).0), b.radius(at(z).1));
    let (mut low, mut high) = ((-reach).max(middle - reach_b.abs()), reach.min(middle + reach_b.abs()));
    for sign in [1.0, -1.0] {
        let room = |z: f32| ASIDE * (radii(z).0 + radii(z).1) - sign * sideways(z);
        let (at_low, at_high) = (room(low), room(high));
        let border = low + (high - low) * at_low / (at_low - at_high);
        match (at_low >= 0.0, at_high >= 0.0) {
            (true, true) => {}
            (true, false) => high = border,
            (false, true) => low = border,
            (false, false) => return [None, None],
        }
    }
    let across_b = normal.cross(of_b / of_b.length() * reach_b.signum());
    // Round a line its surface goes across it, whatever way the normal leans.
    let [in_a, in_b] = [a.line.half, b.line.half].map(|half| normal.reject_from(half).normalize_or_zero());
    let start = (near - a.line.center).dot(along);
    let least = ARM * (radii(start.clamp(-reach, reach)).0 + b.radius(at(start).1.clamp(-1.0, 1.0)));
    [low, high].map(|z| {
        let is_apart = low < high && (z - start).abs() > least;
        is_apart.then(|| {
            let ((s, t), (radius_a, radius_b)) = (at(z), radii(z));
            let sin = if radius_a + radius_b > 0.0 { sideways(z) / (radius_a + radius_b) } else { 0.0 };
            let sagitta = 1.0 - (1.0 - sin * sin).max(0.0).sqrt();
            let away = |across: Vec3, inward: Vec3| across * sin - inward * sagitta;
            let (on_a, on_b) = (a.line.at(s) + away(across, in_a) * radius_a, b.line.at(t) - away(across_b, in_b) * radius_b);
            Across { on_a, on_b, separation: normal.dot(on_b - on_a) }
        })
    })
}

/// Adds the ends of the stretch to the nearest point, the only one of a manifold of B (placed at `relative` in A's frame) against A; points further apart
/// than `margin` are left out.
pub(super) fn widen([a, b]: &[Side; 2], relative: &Pose3, margin: f32, manifold: &mut Manifold) {
    let found = ends(a, b, manifold.normal, manifold.points[0].on_a);
    for (feature, Across { on_a, on_b, separation }) in (0..).zip(found).filter_map(|(feature, end)| Some((feature, end?))) {
        if separation <= margin {
            manifold.push(ManifoldPoint { on_a, on_b: relative.inverse_transform_point(on_b), separation, feature });
        }
    }
}
