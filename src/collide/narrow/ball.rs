//! A ball against a ball, a box or a capsule: closest point, in closed form.

use glam::Vec3;
use parry3d::math::Pose3;

use super::{Manifold, ManifoldPoint};

/// A ball touches at one point, whichever feature the other shape offers there.
const FEATURE: u32 = 0;

/// The one point of a contact, and its normal.
pub(super) struct BallContact {
    normal: Vec3,
    point: ManifoldPoint,
}

#[inline]
pub(super) fn append(touch: Option<BallContact>, out: &mut Vec<Manifold>) {
    if let Some(BallContact { normal, point }) = touch {
        let manifold = Manifold::append(out);
        manifold.normal = normal;
        manifold.push(point);
    }
}

/// Ball B against ball A. Balls with one centre separate along y.
#[inline]
pub(super) fn ball_ball(radius_a: f32, radius_b: f32, relative: &Pose3, margin: f32) -> Option<BallContact> {
    let distance = relative.translation.length();
    let normal = if distance > 0.0 { relative.translation / distance } else { Vec3::Y };
    contact(normal * radius_a, normal, distance - radius_a, radius_b, relative, margin)
}

/// Ball B against box A. From inside, the ball leaves through the nearest face.
#[inline]
pub(super) fn box_ball(half: Vec3, radius: f32, relative: &Pose3, margin: f32) -> Option<BallContact> {
    let (nearest, normal, distance) = nearest_on_box(half, relative.translation);
    contact(nearest, normal, distance, radius, relative, margin)
}

/// Box B against ball A.
#[inline]
pub(super) fn ball_box(radius: f32, half: Vec3, relative: &Pose3, margin: f32) -> Option<BallContact> {
    let (on_b, outward, distance) = nearest_on_box(half, relative.rotation.inverse() * -relative.translation);
    let separation = distance - radius;
    // Written so that a NaN is no contact.
    let near = separation <= margin;
    near.then(|| {
        let normal = relative.rotation * -outward;
        BallContact { normal, point: ManifoldPoint { on_a: normal * radius, on_b, separation, feature: FEATURE } }
    })
}

/// The point of a box's surface nearest to `center`, the normal there, and the distance along it, negative inside.
#[inline]
fn nearest_on_box(half: Vec3, center: Vec3) -> (Vec3, Vec3, f32) {
    let nearest = center.clamp(-half, half);
    if nearest != center {
        let offset = center - nearest;
        let distance = offset.length();
        return (nearest, offset / distance, distance);
    }
    let depth = half - center.abs();
    let axis = if depth.x <= depth.y && depth.x <= depth.z {
        0
    } else if depth.y <= depth.z {
        1
    } else {
        2
    };
    let sign = 1.0_f32.copysign(center[axis]);
    let mut normal = Vec3::ZERO;
    normal[axis] = sign;
    let mut nearest = center;
    nearest[axis] = sign * half[axis];
    (nearest, normal, -depth[axis])
}

/// Ball B against capsule A. A centre on the capsule's axis leaves along x.
pub(super) fn capsule_ball(half_height: f32, radius_a: f32, radius_b: f32, relative: &Pose3, margin: f32) -> Option<BallContact> {
    let center = relative.translation;
    let nearest = Vec3::new(0.0, center.y.clamp(-half_height, half_height), 0.0);
    let offset = center - nearest;
    let distance = offset.length();
    let normal = if distance > 0.0 { offset / distance } else { Vec3::X };
    contact(nearest + normal * radius_a, normal, distance - radius_a, radius_b, relative, margin)
}

/// The contact of a ball whose centre is at `distance` along `normal` from `on_a`.
#[inline]
fn contact(on_a: Vec3, normal: Vec3, distance: f32, radius: f32, relative: &Pose3, margin: f32) -> Option<BallContact> {
    let separation = distance - radius;
    // Written so that a NaN is no contact.
    let near = separation <= margin;
    near.then(|| {
        let on_b = relative.rotation.inverse() * (normal * -radius);
        BallContact { normal, point: ManifoldPoint { on_a, on_b, separation, feature: FEATURE } }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn at(x: f32, y: f32, z: f32) -> Pose3 {
        Pose3::from_parts(Vec3::new(x, y, z), Quat::from_rotation_z(0.7))
    }

    fn only(touch: Option<BallContact>) -> (Vec3, ManifoldPoint) {
        let BallContact { normal, point } = touch.expect("a contact");
        (normal, point)
    }

    #[test]
    fn balls_touch_on_the_line_of_their_centres() {
        let (normal, point) = only(ball_ball(1.0, 0.5, &at(3.0, 0.0, 4.0), 10.0));
        assert!((normal - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6, "normal {normal}");
        assert!((point.separation - 3.5).abs() < 1e-6, "{} m", point.separation);
        let on_b = at(3.0, 0.0, 4.0) * point.on_b;
        assert!((on_b - point.on_a - normal * 3.5).length() < 1e-5, "points {} and {on_b}", point.on_a);
        assert!(ball_ball(1.0, 0.5, &at(3.0, 0.0, 4.0), 3.4).is_none(), "3.5 m is beyond the margin of 3.4 m");
    }

    #[test]
    fn balls_with_one_centre_separate_along_y() {
        let (normal, point) = only(ball_ball(1.0, 0.5, &at(0.0, 0.0, 0.0), 0.0));
        assert_eq!((normal, point.separation), (Vec3::Y, -1.5));
    }

    #[test]
    fn a_ball_outside_a_box_touches_face_edge_and_corner() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let cases = [
            (at(0.5, 2.25, -1.0), Vec3::Y, -0.25),
            (at(1.3, 2.4, 0.0), Vec3::new(0.6, 0.8, 0.0), 0.0),
            (at(-3.0, -4.0, -4.0), Vec3::new(-2.0, -2.0, -1.0) / 3.0, 2.5),
        ];
        for (pose, expected, separation) in cases {
            let (normal, point) = only(box_ball(half, 0.5, &pose, 5.0));
            assert!((normal - expected).length() < 1e-6, "normal {normal}, expected {expected}");
            assert!((point.separation - separation).abs() < 1e-6, "{} m, expected {separation} m", point.separation);
        }
    }

    #[test]
    fn a_ball_inside_a_box_leaves_by_the_nearest_face() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let (normal, point) = only(box_ball(half, 0.5, &at(0.1, -1.5, 0.0), 0.0));
        assert_eq!((normal, point.separation, point.on_a), (Vec3::NEG_Y, -1.0, Vec3::new(0.1, -2.0, 0.0)));
        let (normal, point) = only(box_ball(half, 0.5, &at(0.0, 0.0, 0.0), 0.0));
        assert_eq!((normal, point.separation), (Vec3::X, -1.5));
        let (normal, point) = only(box_ball(half, 0.5, &at(0.0, 0.0, 3.0), 0.0));
        assert_eq!((normal, point.separation), (Vec3::Z, -0.5), "centre on the face");
    }

    #[test]
    fn a_box_touches_a_ball_where_the_ball_touches_the_box() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        for pose in [at(0.5, 2.25, -1.0), at(1.3, 2.4, 0.0), at(-3.0, -4.0, -4.0), at(0.1, -1.5, 0.0)] {
            let (normal, point) = only(box_ball(half, 0.5, &pose, 5.0));
            let (back, mirrored) = only(ball_box(0.5, half, &pose.inverse(), 5.0));
            assert!((pose.rotation * back + normal).length() < 1e-6, "normals {normal} and {back}");
            assert!((point.separation - mirrored.separation).abs() < 2e-6, "{} and {} m", point.separation, mirrored.separation);
            let off = (mirrored.on_b - point.on_a).length().max((mirrored.on_a - point.on_b).length());
            assert!(off < 2e-6, "points {off} m apart");
        }
    }

    #[test]
    fn a_ball_touches_a_capsule_on_its_side_and_on_its_ends() {
        let (normal, point) = only(capsule_ball(1.0, 0.25, 0.5, &at(0.0, 0.5, 2.0), 5.0));
        assert_eq!((normal, point.separation, point.on_a), (Vec3::Z, 1.25, Vec3::new(0.0, 0.5, 0.25)));
        let (normal, point) = only(capsule_ball(1.0, 0.25, 0.5, &at(0.3, -1.4, 0.0), 5.0));
        assert!((normal - Vec3::new(0.6, -0.8, 0.0)).length() < 1e-6, "normal {normal}");
        assert!((point.separation + 0.25).abs() < 1e-6, "{} m", point.separation);
        let (normal, point) = only(capsule_ball(1.0, 0.25, 0.5, &at(0.0, 0.5, 0.0), 0.0));
        assert_eq!((normal, point.separation), (Vec3::X, -0.75), "centre on the axis");
    }
}
