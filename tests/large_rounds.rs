//! What is small lies on what is round and large as on a plane, and what has been thrown on it does not go in.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, Geometry, Pose, Shape, ShapeDef, World, WorldDef};

fn hull(points: &[[f32; 3]], size: f32) -> Geometry {
    Geometry::ConvexHull { points: points.iter().map(|&point| Vec3::from(point) * size).collect() }
}

/// Solids whose half size is this (m).
fn solids(half: f32) -> [(&'static str, Geometry); 6] {
    let cube: Vec<_> = (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0 } else { 1.0 })).collect();
    let wedge = [[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [0.0, 1.0, -1.0], [0.0, 1.0, 1.0]];
    [
        ("box", Geometry::Box { half_extents: Vec3::splat(half) }),
        ("cylinder", Geometry::Cylinder { half_height: half, radius: 0.7 * half }),
        ("cone", Geometry::Cone { half_height: half, radius: half }),
        ("capsule", Geometry::Capsule { half_height: 0.6 * half, radius: 0.4 * half }),
        ("cube", hull(&cube, half)),
        ("wedge", hull(&wedge, half)),
    ]
}

/// A ball, a lying capsule and a lying cylinder of this radius (m).
fn rounds(radius: f32) -> [(&'static str, Geometry); 3] {
    let half_height = radius;
    [
        ("ball", Geometry::Ball { radius }),
        ("capsule", Geometry::Capsule { half_height, radius }),
        ("cylinder", Geometry::Cylinder { half_height, radius }),
    ]
}

/// Mean depth in the last half second of two, over the half size, of what has been let fall on the top of something round.
fn depth_at_rest(solid: &Geometry, half: f32, round: &Geometry, radius: f32, rate: f32, throw: u32) -> f32 {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let lying = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let below = Pose { position: DVec3::NEG_Y * f64::from(radius), rotation: lying };
    let ground = world.create_body(&BodyDef::fixed(below).with_shape(ShapeDef::new(Shape::new(round.clone()).unwrap()))).unwrap();
    let turned = Quat::from_rotation_y(0.3 + throw as f32) * Quat::from_rotation_x(0.05 + 0.8 * throw as f32);
    let above = Pose { position: DVec3::Y * f64::from(2.2 * half), rotation: turned };
    let body = world.create_body(&BodyDef::dynamic(above).with_shape(ShapeDef::new(Shape::new(solid.clone()).unwrap()))).unwrap();
    let [on, of] = [ground, body].map(|body| world.body_shapes(body).unwrap()[0]);
    let (steps, late) = ((2.0 * rate) as u32, (1.5 * rate) as u32);
    let mut sum = 0.0;
    for step in 0..steps {
        world.step(1.0 / rate).unwrap();
        if step >= late {
            sum -= world.shape_distance(on, of).unwrap().distance.min(0.0);
        }
    }
    sum as f32 / (steps - late) as f32 / half
}

/// What rocks on the nearest point within what the surface falls away below its corners is pressed at another place in each step. At 30 steps a
/// second that costs a good part of this sagitta, at most 0.05 of the half size here; corners take over beyond it.
#[test]
fn what_falls_on_something_large_and_round_does_not_go_in() {
    for half in [0.05_f32, 0.5] {
        for ratio in [10.0, 30.0, 300.0] {
            for (on, round) in rounds(ratio * half) {
                for (name, solid) in solids(half) {
                    for rate in [30.0, 60.0, 120.0] {
                        for throw in 0..2 {
                            let depth = depth_at_rest(&solid, half, &round, ratio * half, rate, throw);
                            let what = format!("{name} of {half} m on a {on} of {ratio} times that at {rate} Hz, throw {throw}");
                            let most = if rate < 60.0 { 0.05 } else { 0.02 };
                            assert!(depth < most, "{what}: {depth} of its half size deep");
                        }
                    }
                }
            }
        }
    }
}
