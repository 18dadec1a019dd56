//! A car on a rope bridge: planks tied edge to edge over a gap of `planks` × 0.5 m, and a car that drives across, or stands on it.
//!
//! Planks of 20 kg (half-extents 0.25 × 0.05 × 1 m) hang in a curve whose slope grows by 0.03 a plank, tied at both edges by two ball joints.
//! The car: a hull of `hull` kg on four wheels of 50 kg, radius 0.3 m and 0.2 m wide, 2.4 m and 1.5 m apart, on hinges. With `speed` it
//! begins on the left bank and motors of at most 1 kN·m turn its wheels; at 0 it stands in the middle on free wheels.
//!
//! `deep_m` is the worst overlap of a wheel and a plank or bank. The car stays upright and on its line by symmetry: `aside_m` and `tilt_deg`
//! (about its long axis) are off from that. `behind_m` is how far it is from speed × time at the end: no wheel starts without slip.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, Geometry, JointKind, Limits, Motor, Pose};

use crate::assemble::{solid, x_to};
use crate::metrics::{DrivenEnergy, JointGap, Reading, or_infinite};
use crate::params::{Params, SceneError};
use crate::scene::{Scene, cuboid, shape, start_at_rate, with_friction};

const PLANK_HALF: Vec3 = Vec3::new(0.25, 0.05, 1.0);
const SLOPE: f64 = 0.03;
const WHEEL: f64 = 0.3;
const WHEEL_HALF_WIDTH: f64 = 0.1;
const TORQUE: f32 = 1000.0;
/// How far before the bridge the car begins, and how far beyond it the banks reach (m).
const RUN_UP: f64 = 3.0;
const BANK_HALF: f64 = 6.0;

/// Where planks are tied: each as long as a plank, about the middle.
fn curve(planks: usize) -> Vec<DVec3> {
    let mut points = vec![DVec3::ZERO];
    for index in 0..planks {
        let angle = libm::atan(SLOPE * (index as f64 - 0.5 * (planks as f64 - 1.0)));
        let last = points[index];
        points.push(last + DVec3::new(libm::cos(angle), libm::sin(angle), 0.0) * (2.0 * f64::from(PLANK_HALF.x)));
    }
    let shift = DVec3::X * (0.5 * points[planks].x);
    points.into_iter().map(|point| point - shift).collect()
}

pub(crate) fn bridge_car(params: &mut Params) -> Result<Scene, SceneError> {
    let planks = params.count("planks", 20, 2..=500)?;
    let hull = params.number("hull", 1300.0, 1.0..=1.0e6)?;
    let speed = params.number("speed", 2.0, 0.0..=20.0)?;
    let points = curve(planks);
    let half_span = points[planks].x;
    let seconds = if speed > 0.0 { 2.0 * (half_span + RUN_UP) / speed } else { 5.0 };
    let (mut scene, _) = start_at_rate(params, seconds)?;

    let top = f64::from(PLANK_HALF.y);
    let bank = with_friction(cuboid(BANK_HALF as f32, 0.5, 3.0)?, 0.8);
    let banks = [-1.0, 1.0].map(|side| {
        let at = Pose::at_xyz(side * (half_span + BANK_HALF), top - 0.5, 0.0);
        scene.body(BodyDef::fixed(at).with_shape(bank.clone()))
    });
    let wood = with_friction(cuboid(PLANK_HALF.x, PLANK_HALF.y, PLANK_HALF.z)?, 0.8);
    let mut last = banks[0];
    let mut deck = vec![(banks[0], BANK_HALF, 0.5), (banks[1], BANK_HALF, 0.5)];
    let tie = |scene: &mut Scene, a: usize, b: usize, at: DVec3| {
        for z in [-1.0, 1.0] {
            scene.tie(a, b, at + DVec3::Z * z);
        }
    };
    for ends in points.windows(2) {
        let way = ends[1] - ends[0];
        let pose = Pose::at(0.5 * (ends[0] + ends[1])).rotated(Quat::from_rotation_z(libm::atan2(way.y, way.x) as f32));
        let plank = scene.body(solid(pose, wood.clone(), 20.0));
        tie(&mut scene, last, plank, ends[0]);
        deck.push((plank, f64::from(PLANK_HALF.x), top));
        last = plank;
    }
    tie(&mut scene, last, banks[1], points[planks]);

    let deepest = points.iter().map(|point| point.y).fold(0.0, f64::min);
    // On the bank it starts on its wheels; over the middle it is set down from where its wheels clear the planks that rise before and behind.
    let start = if speed > 0.0 { DVec3::X * -(half_span + RUN_UP) } else { DVec3::Y * (deepest + 0.06) };
    let axles = start + DVec3::Y * (top + WHEEL);
    let car = scene.body(solid(Pose::at(axles + DVec3::Y * 0.2), cuboid(1.5, 0.2, 0.6)?, hull as f32));
    let tyre = Geometry::Cylinder { half_height: WHEEL_HALF_WIDTH as f32, radius: WHEEL as f32 };
    let tyre = with_friction(shape(tyre)?, 0.8);
    let lying = Quat::from_rotation_x(0.5 * std::f32::consts::PI);
    let motor = Motor::Velocity { target: (-speed / WHEEL) as f32, max_force: TORQUE };
    let motor = if speed > 0.0 { motor } else { Motor::Off };
    let mut wheels = Vec::new();
    for x in [-1.2, 1.2] {
        for z in [-0.75, 0.75] {
            let at = axles + DVec3::new(x, 0.0, z);
            let wheel = scene.body(solid(Pose::at(at).rotated(lying), tyre.clone(), 50.0));
            let kind = JointKind::Hinge { limits: Limits::NONE, motor };
            scene.join(car, wheel, kind, &Pose::at(at).rotated(x_to(DVec3::Z)));
            wheels.push(wheel);
        }
    }

    let steps = scene.steps;
    scene.judge(Reading::worst_of_last(steps, "deep_m", move |view| {
        let depth = |&wheel: &usize| {
            let at = view.engine.pose(wheel).position;
            let below = deck.iter().filter_map(|&(plank, half, thick)| {
                let local = view.engine.pose(plank).inverse_transform_point(at).as_dvec3();
                (local.x.abs() <= half).then_some(WHEEL + thick - local.y)
            });
            below.fold(0.0, f64::max)
        };
        wheels.iter().map(depth).map(or_infinite).fold(0.0, f64::max)
    }));
    scene.judge(JointGap::over_last(steps));
    scene.judge(Reading::worst_of_last(steps, "aside_m", move |view| view.engine.pose(car).position.z.abs()));
    scene.judge(Reading::worst_of_last(steps, "tilt_deg", move |view| {
        let across = view.engine.pose(car).rotation * Vec3::Z;
        libm::asin(f64::from(across.y.clamp(-1.0, 1.0))).abs().to_degrees()
    }));
    scene.judge(Reading::after(steps, "behind_m", move |view| speed * view.time - (view.center(car).x - start.x)));
    scene.judge(Reading::after(steps, "height_m", move |view| view.center(car).y));
    scene.judge(DrivenEnergy::default());
    Ok(scene)
}
