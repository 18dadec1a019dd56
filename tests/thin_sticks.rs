//! Contacts give sticks that turn fast no energy: what they take of a spin about a stick's length, which weighs next to nothing, is no more than it
//! has.

use std::f32::consts::PI;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, Mass, Material, Pose, Shape, ShapeDef, World, WorldDef};

const GRAVITY: f64 = 9.81;

/// Sticks along y, so much longer than they are thick.
fn sticks(half_height: f32, ratio: f32) -> [Geometry; 4] {
    let radius = half_height / ratio;
    [
        Geometry::Box { half_extents: Vec3::new(radius, half_height, radius) },
        Geometry::Capsule { half_height, radius },
        Geometry::Cylinder { half_height, radius },
        Geometry::Cone { half_height, radius },
    ]
}

fn smooth(geometry: Geometry, restitution: f32) -> ShapeDef {
    let material = Material { friction: 0.0, restitution, ..Material::default() };
    ShapeDef { material, ..ShapeDef::new(Shape::new(geometry).unwrap()) }
}

/// Kinetic energy (J).
fn kinetic(world: &World, body: BodyId) -> f64 {
    let mass = world.mass_properties(body).unwrap().unwrap();
    let axes = (world.pose(body).unwrap().rotation * mass.inertia_frame).as_dquat();
    let spin = axes.conjugate() * world.angular_velocity(body).unwrap().as_dvec3();
    let moved = f64::from(mass.mass) * world.linear_velocity(body).unwrap().as_dvec3().length_squared();
    0.5 * (moved + (spin * spin).dot(mass.principal_inertia.as_dvec3()))
}

/// Most energy within two seconds, over that at first, of a stick of a kilogram that falls as it turns, and rebounds in full.
fn most_of_a_fall(geometry: &Geometry, size: f32, lean: f32, rate: f32) -> f64 {
    let mut world = World::new(&WorldDef { gravity: Vec3::NEG_Y * GRAVITY as f32, ..WorldDef::default() }).unwrap();
    world.set_restitution_threshold(0.1).unwrap();
    let floor = smooth(Geometry::HalfSpace { normal: Vec3::Y }, 1.0);
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
    let height = f64::from(size) * 0.75 + 0.02;
    let pose = Pose { position: DVec3::new(0.1, height, 0.1), rotation: Quat::from_rotation_z(lean) };
    let def = BodyDef {
        mass: Mass::Total(1.0),
        linear_velocity: Vec3::NEG_Y * 2.0,
        angular_velocity: Vec3::new(0.0, 3.0, 4.0),
        ..BodyDef::dynamic(pose)
    };
    let body = world.create_body(&def.with_shape(smooth(geometry.clone(), 1.0))).unwrap();
    let energy = |world: &World| kinetic(world, body) + GRAVITY * world.center_of_mass(body).unwrap().y;
    let first = energy(&world);
    let steps = 0..(2.0 * rate) as usize;
    steps.fold(1.0, |most, _| {
        world.step(1.0 / rate).unwrap();
        f64::max(most, energy(&world) / first)
    })
}

/// Sticks of 1:80 had up to 2.0, 2.7, 1.01 and 1.002 times their energy at 30, 60, 120 and 240 Hz, of other lengths and leans up to eleven times. What is
/// left at 30 Hz is what they are lifted by out of a floor that they have turned into.
#[test]
fn thin_sticks_that_fall_and_rebound_gain_no_energy() {
    for (size, ratio) in [(0.16, 80.0), (1.0, 40.0)] {
        for geometry in sticks(0.5 * size, ratio) {
            for (rate, bound) in [(30.0, 1.03), (60.0, 1.01), (120.0, 1.01), (240.0, 1.005)] {
                for way in 0..6 {
                    let most = most_of_a_fall(&geometry, size, (way as f32 + 0.5) * PI / 6.0, rate);
                    assert!(most < bound, "{geometry:?}, {way}, {rate}/s: it had {most} of its energy, bound {bound}");
                }
            }
        }
    }
}

/// Most energy within a second, over that at first, of two sticks that meet in the air without restitution.
fn most_of_two(geometry: &Geometry, size: f32, lean: f32, rate: f32) -> f64 {
    let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
    let place = |x: f32, y: f32| DVec3::new(f64::from(x), f64::from(y), 0.0) * f64::from(size);
    let mut throw = |position: DVec3, rotation: Quat, mass: f32, speed: f32, spin: Vec3| {
        let (linear_velocity, angular_velocity) = (Vec3::Y * speed, spin * (0.16 / size));
        let def = BodyDef {
            mass: Mass::Total(mass),
            linear_velocity,
            angular_velocity,
            ..BodyDef::dynamic(Pose { position, rotation })
        };
        world.create_body(&def.with_shape(smooth(geometry.clone(), 0.0))).unwrap()
    };
    let upper = throw(place(0.0, 0.875), Quat::from_rotation_z(lean), 1.0, -2.0, Vec3::new(0.0, 3.0, 20.0));
    let lower = throw(place(0.15, -0.2), Quat::from_rotation_x(1.2), 2.0, 2.0, Vec3::X * 15.0);
    let energy = |world: &World| kinetic(world, upper) + kinetic(world, lower);
    let first = energy(&world);
    (0..rate as usize).fold(1.0, |most, _| {
        world.step(1.0 / rate).unwrap();
        f64::max(most, energy(&world) / first)
    })
}

/// Cones of 1:200 had up to 1.8 and 2.25 times their energy at 30 and 60 Hz, capsules and cylinders 1.25 at 30.
#[test]
fn thin_sticks_that_meet_in_the_air_gain_no_energy() {
    for (size, ratio) in [(0.16, 200.0), (0.16, 80.0), (1.6, 200.0)] {
        for geometry in sticks(0.5 * size, ratio) {
            for rate in [30.0, 60.0, 120.0, 240.0] {
                for way in 0..6 {
                    let most = most_of_two(&geometry, size, (way as f32 + 0.5) * PI / 6.0, rate);
                    assert!(most < 1.002, "{geometry:?}, {way}, {rate}/s: they had {most} of their energy, bound 1.002");
                }
            }
        }
    }
}

/// Share of its energy that a stick 0.4 m long keeps as it spins about the vertical and comes down on a smooth floor, in the mean of six ways to lean.
fn kept(geometry: &Geometry, rate: f32) -> f64 {
    let mean = (0..6).map(|way| {
        let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
        world.set_restitution_threshold(0.0).unwrap();
        let floor = smooth(Geometry::HalfSpace { normal: Vec3::Y }, 1.0);
        world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
        let rotation = Quat::from_rotation_z((way as f32 + 0.5) * PI / 12.0);
        let pose = Pose { position: DVec3::new(0.3, 0.5, 0.2), rotation };
        let def = BodyDef {
            mass: Mass::Total(1.0),
            linear_velocity: Vec3::NEG_Y * 3.0,
            angular_velocity: Vec3::Y * 30.0,
            ..BodyDef::dynamic(pose)
        };
        let body = world.create_body(&def.with_shape(smooth(geometry.clone(), 1.0))).unwrap();
        let first = kinetic(&world, body);
        for _ in 0..(0.6 * rate) as usize {
            world.step(1.0 / rate).unwrap();
        }
        kinetic(&world, body) / first / 6.0
    });
    mean.sum()
}

/// Capsules of 1:20 kept 0.976 and 0.92 of it in the mean at 30 and 60 Hz, boxes of 1:40 0.92 and 0.95, cylinders of 1:80 0.88 at 120.
#[test]
fn thin_sticks_that_rebound_keep_their_energy() {
    for (ratio, rates) in
        [(10.0, [30.0, 60.0, 120.0, 240.0]), (20.0, [30.0, 60.0, 120.0, 240.0]), (40.0, [60.0, 60.0, 120.0, 240.0])]
    {
        for geometry in sticks(0.2, ratio) {
            for rate in rates {
                let kept = kept(&geometry, rate);
                assert!((kept - 1.0).abs() < 0.03, "{geometry:?}, {rate}/s: keeps {kept} of its energy in the mean, bound 0.03");
            }
        }
    }
}
