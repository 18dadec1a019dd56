//! A vehicle on one wide track of 132 links that its sprockets drive over a step.
//!
//! The links: a plate each (half-extents 0.035 × 0.015 × 0.5 m, 2 kg) at a pitch of 0.1 m, hinged about z in the plate's middle plane,
//! with gaps of 0.03 m between plates. Two sprockets with 20 teeth at x = ±2.8 m: hubs of radius 0.30 m on which the plates lie, the
//! teeth in the gaps (0.02 m thick, from 0.29 m to 0.335 m, 0.4 m wide), so the hinges lie on a circle of 0.05/sin 9° = 0.320 m and
//! 56 links span each straight between the axles. Five plain wheels of 0.30 m between them carry the lower run, and the upper one
//! hangs on them too. Sprockets 40 kg, wheels 20 kg, on hinges of a hull of 500 kg (half-extents 2.6 × 0.1 × 0.4 m) inside the
//! track. Speed servos turn both sprockets at 4 rad/s over flat ground (friction 0.8) and, 2 m ahead, a step of 0.15 m. Of the parts
//! of the vehicle only links touch wheels. 20 s.

use std::f64::consts::{PI, TAU};

use longspan::glam::{DQuat, DVec2, DVec3, Quat, Vec3};
use longspan::{BodyDef, CollisionFilter, Geometry, JointKind, LocalPose, Pose};

use crate::assemble::{filtered, solid, x_to};
use crate::machines::servo;
use crate::metrics::{DrivenEnergy, JointGap, Reading, or_infinite};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, shape, start, with_friction};

const PITCH: f64 = 0.1;
const TEETH: usize = 20;
const STRAIGHT: usize = 56;
const HALF_AXLES: f64 = 0.5 * PITCH * STRAIGHT as f64;
const PLATE_HALF: Vec3 = Vec3::new(0.035, 0.015, 0.5);
const HUB: f32 = 0.30;
const RATE: f64 = 4.0;
const STEP_HEIGHT: f64 = 0.15;
/// How far a link may lie from the track's plane, or from the nearest wheel, and still be on (m).
const OFF_SIDEWAYS: f64 = 0.25;

const GROUND: CollisionFilter = CollisionFilter { member_of: 1, collides_with: 2 };
const LINK: CollisionFilter = CollisionFilter { member_of: 2, collides_with: 1 | 4 };
const WHEEL: CollisionFilter = CollisionFilter { member_of: 4, collides_with: 2 };

/// The hinges' path: the corners of two half polygons of 20 corners, joined by straights; clockwise as seen from +z.
fn hinge_points(count: usize) -> Vec<DVec2> {
    let radius = 0.5 * PITCH / libm::sin(PI / TEETH as f64);
    let mut points = Vec::with_capacity(count);
    for index in 0..STRAIGHT {
        points.push(DVec2::new(-HALF_AXLES + PITCH * index as f64, radius));
    }
    for index in 0..TEETH / 2 {
        let angle = 0.5 * PI - TAU * index as f64 / TEETH as f64;
        points.push(DVec2::new(HALF_AXLES, 0.0) + radius * DVec2::from_angle(angle));
    }
    points.extend_from_within(..);
    for point in &mut points[count / 2..] {
        *point = -*point;
    }
    points
}

pub(crate) fn track(params: &mut Params) -> Result<Scene, SceneError> {
    let step = params.number("step", STEP_HEIGHT, 0.0..=1.0)?;
    let mut scene = start(params, 20.0)?;
    let count = 2 * STRAIGHT + TEETH;
    let height = 0.5 * PITCH / libm::sin(PI / TEETH as f64) + f64::from(PLATE_HALF.y) + 0.001;
    let lift = DVec3::Y * height;

    let ground = with_friction(cuboid(60.0, 0.5, 5.0)?, 0.8);
    scene.body(filtered(BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(ground), GROUND));
    if step > 0.0 {
        let half = with_friction(cuboid(20.0, (0.5 * step) as f32, 5.0)?, 0.8);
        let front = HALF_AXLES + 0.4 + 2.0;
        scene.body(filtered(BodyDef::fixed(Pose::at_xyz(front + 20.0, 0.5 * step, 0.0)).with_shape(half), GROUND));
    }

    let hull = scene.body(filtered(solid(Pose::at(lift), cuboid(2.6, 0.1, 0.4)?, 500.0), NOTHING));
    // Forward is +x: wheels turn clockwise as seen from +z.
    let drive = servo(-RATE);
    for x in [-HALF_AXLES, HALF_AXLES] {
        let sprocket = scene.body(filtered(solid(Pose::at(lift + DVec3::X * x), sprocket()?, 40.0), WHEEL));
        scene.hinge(hull, sprocket, drive, lift + DVec3::X * x, DVec3::Z);
    }
    let flat = Quat::from_rotation_x(0.5 * std::f32::consts::PI);
    for index in 1..=5 {
        let at = lift + DVec3::X * (-HALF_AXLES + HALF_AXLES / 3.0 * f64::from(index));
        let drum = with_friction(shape(Geometry::Cylinder { half_height: 0.2, radius: HUB })?, 0.3);
        let wheel = scene.body(filtered(solid(Pose::at(at).rotated(flat), drum, 20.0), WHEEL));
        scene.hinge(hull, wheel, JointKind::HINGE, at, DVec3::Z);
    }

    let points: Vec<DVec3> = hinge_points(count).into_iter().map(|point| point.extend(0.0) + lift).collect();
    let plate = with_friction(cuboid(PLATE_HALF.x, PLATE_HALF.y, PLATE_HALF.z)?, 0.8);
    let links: Vec<usize> = (0..count)
        .map(|index| {
            let (from, to) = (points[index], points[(index + 1) % count]);
            let heading = (to - from).truncate().to_angle();
            let pose = Pose::at(0.5 * (from + to)).rotated(DQuat::from_rotation_z(heading).as_quat());
            scene.body(filtered(solid(pose, plate.clone(), 2.0), LINK))
        })
        .collect();
    let axes = x_to(DVec3::Z);
    for index in 0..count {
        let next = (index + 1) % count;
        scene.join(links[index], links[next], JointKind::HINGE, &Pose::at(points[next]).rotated(axes));
    }

    let steps = scene.steps;
    scene.judge(JointGap::over_last(steps));
    let watched = links.clone();
    scene.judge(Reading::worst_of_last(steps, "sideways_m", move |view| {
        let pose = view.engine.pose(hull);
        let off = |&link: &usize| f64::from(pose.inverse_transform_point(view.engine.pose(link).position).z.abs());
        watched.iter().map(off).map(or_infinite).fold(0.0, f64::max)
    }));
    scene.judge(Reading::after(steps, "links_off", move |view| {
        let pose = view.engine.pose(hull);
        let off = |link: &&usize| {
            let local = pose.inverse_transform_point(view.engine.pose(**link).position).as_dvec3();
            // Inside the outline of the track, a hand's breadth either way.
            let beyond = (local.x.abs() - HALF_AXLES).max(0.0).hypot(local.y);
            !(local.z.abs() < OFF_SIDEWAYS && beyond < 0.5)
        };
        links.iter().filter(off).count() as f64
    }));
    scene.judge(Reading::after(steps, "way_m", move |view| view.center(hull).x));
    scene.judge(DrivenEnergy::default());
    Ok(scene)
}

const NOTHING: CollisionFilter = CollisionFilter { member_of: 8, collides_with: 0 };

/// A hub with teeth about z; tooth k stands where hinge k of the polygon lies.
fn sprocket() -> Result<longspan::ShapeDef, SceneError> {
    let hub = Geometry::Cylinder { half_height: 0.2, radius: HUB };
    let tooth = Geometry::Box { half_extents: Vec3::new(0.0225, 0.01, 0.2) };
    let flat = Quat::from_rotation_x(0.5 * std::f32::consts::PI);
    let mut parts = vec![(LocalPose { position: Vec3::ZERO, rotation: flat }, hub)];
    for index in 0..TEETH {
        let turn = Quat::from_rotation_z((TAU * index as f64 / TEETH as f64) as f32);
        parts.push((LocalPose { position: turn * (Vec3::X * 0.3125), rotation: turn }, tooth.clone()));
    }
    Ok(with_friction(shape(Geometry::Compound { parts })?, 0.3))
}
