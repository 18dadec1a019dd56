//! Which function collides which pair of parts.

use glam::Vec3;
use parry3d::math::Pose3;

use super::part::Part;
use super::segment::Segment;
use super::{Manifold, NarrowScratch, ball, box_box, capsule, capsule_box, convex, cylinder, half_space, lying, triangle};

/// Appends the manifold of part `b`, placed at `relative` in A's frame, against part `a`, if they are near.
pub(super) fn collide(a: &Part, b: &Part, relative: &Pose3, margin: f32, scratch: &mut NarrowScratch, out: &mut Vec<Manifold>) {
    let before = out.len();
    nearest(a, b, relative, margin, scratch, out);
    for manifold in &mut out[before..] {
        lying::widen([a, b], relative, margin, scratch.turns, &mut scratch.polygons, manifold);
    }
}

/// The same with the nearest points alone where one of the two is round.
fn nearest(a: &Part, b: &Part, relative: &Pose3, margin: f32, scratch: &mut NarrowScratch, out: &mut Vec<Manifold>) {
    match (a, b) {
        (&Part::Box { half_extents: half_a }, &Part::Box { half_extents: half_b }) => {
            box_box::box_box(half_a, half_b, relative, margin, out);
        }
        (&Part::Ball { radius: radius_a }, &Part::Ball { radius: radius_b }) => {
            ball::append(ball::ball_ball(radius_a, radius_b, relative, margin), out);
        }
        (&Part::Box { half_extents }, &Part::Ball { radius }) => {
            ball::append(ball::box_ball(half_extents, radius, relative, margin), out);
        }
        (&Part::Ball { radius }, &Part::Box { half_extents }) => {
            ball::append(ball::ball_box(radius, half_extents, relative, margin), out);
        }
        (&Part::Capsule { half_height, radius: radius_a }, &Part::Ball { radius }) => {
            ball::append(ball::capsule_ball(half_height, radius_a, radius, relative, margin), out);
        }
        (
            &Part::Capsule { half_height: half_height_a, radius: radius_a },
            &Part::Capsule { half_height: half_height_b, radius: radius_b },
        ) => out.extend(capsule::capsule_capsule((half_height_a, radius_a), (half_height_b, radius_b), relative, margin)),
        (&Part::Box { half_extents }, &Part::Capsule { half_height, radius }) => {
            out.extend(capsule_box::box_capsule(half_extents, (half_height, radius), relative, margin));
        }
        (Part::HalfSpace { .. }, Part::HalfSpace { .. }) => {}
        (&Part::HalfSpace { normal }, _) => {
            out.extend(half_space::half_space(normal, b, relative, margin, &mut scratch.polygons));
        }
        (Part::Triangle { triangle, constraints }, Part::Ball { .. } | Part::Box { .. }) => {
            out.extend(triangle::collide(triangle, constraints.as_ref(), b, relative, margin, &mut scratch.triangle));
        }
        (&Part::Cylinder { half_height, radius }, Part::Ball { .. } | Part::Capsule { .. }) => {
            let core = match b {
                Part::Capsule { half_height, .. } => Segment::of_capsule(*half_height, relative),
                _ => Segment { center: relative.translation, half: Vec3::ZERO },
            };
            let beside = cylinder::side_core((half_height, radius), &core, b.rounding(), relative, margin);
            out.extend(beside.unwrap_or_else(|| convex::collide(a, b, relative, margin, scratch.last, &mut scratch.polygons)));
        }
        (_, Part::HalfSpace { .. })
        | (Part::Ball { .. } | Part::Capsule { .. }, Part::Cylinder { .. })
        | (Part::Ball { .. }, Part::Capsule { .. })
        | (Part::Capsule { .. }, Part::Box { .. })
        | (Part::Ball { .. } | Part::Box { .. }, Part::Triangle { .. }) => {
            let inverse = relative.inverse();
            let before = out.len();
            scratch.last = scratch.last.map(|last| inverse.rotation * -last);
            nearest(b, a, &inverse, margin, scratch, out);
            for manifold in &mut out[before..] {
                manifold.swap(&inverse);
            }
        }
        _ => out.extend(convex::collide(a, b, relative, margin, scratch.last, &mut scratch.polygons)),
    }
}
