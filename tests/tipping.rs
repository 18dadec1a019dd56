//! What tips over an edge is kept awake until it falls, however slow it is.

use std::f32::consts::FRAC_PI_2;

use longspan::glam::{Quat, Vec3};
use longspan::{BodyDef, LocalPose, Pose, Shape, ShapeDef, Solver, World, WorldDef};

const RATES: [f32; 3] = [30.0, 60.0, 240.0];

fn cuboid(half: Vec3) -> ShapeDef {
    ShapeDef::new(Shape::cuboid(half).unwrap())
}

/// By how much a body turns whose centre is so far above a table and `beyond` its edge, until it has tipped over or sleeps (rad).
fn tips(shape: ShapeDef, rise: f32, size: f32, beyond: f32, (rate, solver): (f32, Solver)) -> f32 {
    let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).unwrap();
    let place = |x: f32, y: f32| Pose::at_xyz(f64::from(x), f64::from(y), 0.0);
    world.create_body(&BodyDef::fixed(place(-size, -size)).with_shape(cuboid(Vec3::splat(size)))).unwrap();
    let body = world.create_body(&BodyDef::dynamic(place(beyond, rise)).with_shape(shape)).unwrap();
    let turned = |world: &World| world.pose(body).unwrap().rotation.angle_between(Quat::IDENTITY);
    for _ in 0..(20.0 * size.sqrt() * rate) as u32 {
        world.step(1.0 / rate).unwrap();
        if turned(&world) > 0.3 || !world.is_awake(body).unwrap() {
            break;
        }
    }
    turned(&world)
}

#[test]
fn what_tips_over_an_edge_does_not_fall_asleep_however_long_and_slow_it_is() {
    let sizes = [0.1, 0.37, 1.0, 2.3, 10.0].into_iter();
    for (size, share) in sizes.flat_map(|size| [0.001, 0.002, 0.01, 0.03, 0.06].map(|share| (size, share))) {
        for how in RATES.into_iter().flat_map(|rate| [(rate, Solver::Auto), (rate, Solver::GaussSeidel)]) {
            let across = LocalPose { rotation: Quat::from_rotation_z(FRAC_PI_2), ..LocalPose::IDENTITY };
            let round = ShapeDef::new(Shape::capsule(size, 0.05 * size).unwrap());
            let shapes = [
                (cuboid(Vec3::new(size, 0.05 * size, 0.2 * size)), 0.05),
                (ShapeDef { local_pose: across, ..round }, 0.05),
                // On the edge of its foot: it is slower by the square of its height.
                (cuboid(Vec3::new(0.2 * size, size, 0.2 * size)), 1.0),
            ];
            for (number, (shape, rise)) in shapes.into_iter().enumerate().take(if share < 0.01 { 2 } else { 3 }) {
                let turned = tips(shape, rise * size, size, share * size, how);
                assert!(turned > 0.3, "{number} of {size} m, {share} beyond, {how:?}: asleep at {turned} rad");
            }
        }
    }
}
