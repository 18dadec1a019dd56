//! A free body turns as mechanics says, however slowly: its angular momentum stays where it points.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyId, Geometry, Pose, Shape, ShapeDef, World, WorldDef};

fn angular_momentum(world: &World, body: BodyId) -> DVec3 {
    let mass = world.mass_properties(body).unwrap().expect("a dynamic body has a mass");
    let axes = (world.pose(body).unwrap().rotation * mass.inertia_frame).as_dquat().normalize();
    axes * (mass.principal_inertia.as_dvec3() * (axes.conjugate() * world.angular_velocity(body).unwrap().as_dvec3()))
}

#[test]
fn what_turns_slowly_keeps_the_direction_of_its_angular_momentum() {
    let shapes = [
        ("box", Shape::cuboid(Vec3::new(1.0, 0.5, 0.3)).unwrap()),
        ("rod", Shape::cuboid(Vec3::new(1.0, 0.05, 0.05)).unwrap()),
        ("disc", Shape::new(Geometry::Cylinder { half_height: 0.05, radius: 1.0 }).unwrap()),
        ("ship of 60 m", Shape::cuboid(Vec3::new(30.0, 5.0, 8.0)).unwrap()),
    ];
    for (name, shape) in shapes {
        for (rate, substeps) in [(30.0_f32, 4), (60.0, 1), (60.0, 16), (240.0, 4), (240.0, 16)] {
            for speed in [0.01_f32, 0.05, 0.3] {
                let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, substeps, ..WorldDef::default() }).unwrap();
                let mut def = BodyDef::dynamic(Pose::IDENTITY).with_shape(ShapeDef::new(shape.clone()));
                (def.angular_velocity, def.can_sleep) = (Vec3::new(0.6, 0.6, 0.53) * speed, false);
                let body = world.create_body(&def).unwrap();
                let before = angular_momentum(&world, body);
                for _ in 0..(rate / speed) as usize {
                    world.step(1.0 / rate).unwrap();
                }
                let after = angular_momentum(&world, body);
                let (off, size) = (before.angle_between(after), after.length() / before.length() - 1.0);
                // By 0.3 to 0.6 rad where nothing turned it.
                let what = format!("{name} at {speed} rad/s, {rate} Hz, {substeps} substeps");
                assert!(off < 0.01 && size.abs() < 1.0e-3, "{what}: off by {off} rad after a radian, {size} greater");
            }
        }
    }
}
