//! What turns back is slow for a moment, and not at rest.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, JointDef, JointKind, Mass, MassProperties, Material, Pose, Shape, ShapeDef, Solver, World, WorldDef,
};

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];

/// Time after which it turns back (s).
const TIME: f32 = 3.0;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Rolls,
    Slides,
    Flies,
}

/// Speed of a body of this size (m) that comes back where it set out, over that at which it did so: it turns back at `acceleration` (m/s²).
fn returns(way: Way, size: f32, acceleration: f32, (rate, solver): (f32, Solver)) -> f32 {
    let is_slope = way != Way::Flies;
    let pull = if way == Way::Rolls { 1.4 * acceleration } else { acceleration };
    let gravity = if is_slope { Vec3::new(-pull, -(9.81_f32.powi(2) - pull * pull).sqrt(), 0.0) } else { Vec3::NEG_X * pull };
    let mut world = World::new(&WorldDef { gravity, solver, ..WorldDef::default() }).unwrap();
    let material = Material { friction: if way == Way::Slides { 0.0 } else { 0.5 }, ..Material::default() };
    if is_slope {
        let slope = Shape::cuboid(Vec3::new(500.0, 1.0, 5.0 * size)).unwrap();
        let ground = BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(ShapeDef { material, ..ShapeDef::new(slope) });
        world.create_body(&ground).unwrap();
    }
    let shape = if way == Way::Rolls { Shape::ball(size) } else { Shape::cuboid(Vec3::splat(size)) };
    let shape = ShapeDef { material, ..ShapeDef::new(shape.unwrap()) };
    let speed = acceleration * TIME;
    let linear_velocity = Vec3::X * speed;
    let angular_velocity = if way == Way::Rolls { Vec3::NEG_Z * (speed / size) } else { Vec3::ZERO };
    let place = Pose::at_xyz(0.0, f64::from(size), 0.0);
    let def = BodyDef { linear_velocity, angular_velocity, ..BodyDef::dynamic(place).with_shape(shape) };
    let body = world.create_body(&def).unwrap();
    for _ in 0..(2.0 * TIME * rate).round() as u32 {
        world.step(1.0 / rate).unwrap();
    }
    -world.linear_velocity(body).unwrap().x / speed
}

#[test]
fn what_rolls_slides_or_flies_back_does_not_stay_where_it_turns() {
    for how in RATES.into_iter().flat_map(|rate| [(rate, Solver::Auto), (rate, Solver::GaussSeidel)]) {
        for (way, size) in [Way::Rolls, Way::Slides, Way::Flies].into_iter().flat_map(|way| [(way, 0.1), (way, 0.5), (way, 2.0)])
        {
            for acceleration in [0.013, 0.02, 0.03, 0.07, 0.14, 0.2, 0.35] {
                let back = returns(way, size, acceleration, how);
                assert!((back - 1.0).abs() < 0.1, "{way:?}, {size} m, {acceleration} m/s², {how:?}: back at {back} of its speed");
            }
        }
    }
}

/// It is let go at 0.5 rad from where it hangs, and swings to the other side and back.
#[test]
fn a_wheel_that_is_out_of_balance_by_a_millimetre_swings_to_and_fro() {
    const INERTIA: f32 = 9.8;
    const MASS: f32 = 78.0;
    for how in RATES.into_iter().flat_map(|rate| [(rate, Solver::Auto), (rate, Solver::GaussSeidel)]) {
        for off in [1.0e-3_f32, 2.0e-3, 5.0e-3] {
            let mut world = World::new(&WorldDef { solver: how.1, ..WorldDef::default() }).unwrap();
            let mass = MassProperties {
                mass: MASS,
                center_of_mass: Vec3::NEG_Y * off,
                principal_inertia: Vec3::new(INERTIA, 5.0, 5.0),
                inertia_frame: Quat::IDENTITY,
            };
            let askew = Pose { position: DVec3::ZERO, rotation: Quat::from_rotation_x(0.5) };
            let wheel = BodyDef::dynamic(askew).with_shape(ShapeDef::new(Shape::ball(0.5).unwrap()));
            let wheel = world.create_body(&wheel.with_mass(Mass::Properties(mass))).unwrap();
            world.create_joint(&JointDef::new(JointKind::HINGE, BodyId::NULL, wheel)).unwrap();
            // 1.5 % longer than that of small swings.
            let period = 1.015 * std::f32::consts::TAU * (INERTIA / (MASS * 9.81 * off)).sqrt();
            let mut turned = |seconds: f32| {
                for _ in 0..(seconds * how.0).round() as u32 {
                    world.step(1.0 / how.0).unwrap();
                }
                let rotation = world.pose(wheel).unwrap().rotation;
                2.0 * rotation.x.atan2(rotation.w)
            };
            let (there, back) = (turned(0.5 * period), turned(0.5 * period));
            assert!(there < -0.45 && back > 0.45, "{off} m, {how:?}: from 0.5 rad to {there} and back to {back}");
        }
    }
}

/// What friction stops has changed its velocity steadily, too, but does so no more.
#[test]
fn what_has_slid_to_a_stop_sleeps_as_soon_as_it_has_been_slow_for_long_enough() {
    for how in RATES.into_iter().flat_map(|rate| [(rate, Solver::Auto), (rate, Solver::GaussSeidel)]) {
        for friction in [0.02, 0.05, 0.2, 0.6] {
            let mut world = World::new(&WorldDef { solver: how.1, ..WorldDef::default() }).unwrap();
            let material = Material { friction, ..Material::default() };
            let solid = |half: Vec3| ShapeDef { material, ..ShapeDef::new(Shape::cuboid(half).unwrap()) };
            let ground = BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(solid(Vec3::new(50.0, 1.0, 5.0)));
            world.create_body(&ground).unwrap();
            let def = BodyDef::dynamic(Pose::at_xyz(0.0, 0.5, 0.0)).with_shape(solid(Vec3::splat(0.5)));
            let body = world.create_body(&BodyDef { linear_velocity: Vec3::X, ..def }).unwrap();
            let slides = 1.0 / (friction * 9.81);
            let mut time = 0.0;
            while world.is_awake(body).unwrap() && time < 60.0 {
                world.step(1.0 / how.0).unwrap();
                time += 1.0 / how.0;
            }
            assert!(time < slides + 0.75, "friction {friction}, {how:?}: slides for {slides} s, asleep after {time} s");
        }
    }
}
