//! Axes of the world that a body is locked along or about stay locked, however it came to its velocity.

use longspan::glam::Vec3;
use longspan::{BodyDef, BodyKind, LockedAxes, Pose, Shape, ShapeDef, World, WorldDef};

#[test]
fn no_velocity_is_left_along_or_about_locked_axes() {
    let locked = LockedAxes { translation: [false, true, false], rotation: [true, false, false] };
    for way in 0..4 {
        let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
        let mut def = BodyDef::dynamic(Pose::IDENTITY).with_shape(ShapeDef::new(Shape::ball(0.2).unwrap()));
        let (linear, angular) = (Vec3::new(1.0, 3.0, 0.0), Vec3::new(2.0, 0.0, 1.0));
        if way == 0 {
            (def.linear_velocity, def.angular_velocity) = (linear, angular);
        }
        if way == 3 {
            (def.kind, def.linear_velocity, def.angular_velocity) = (BodyKind::Kinematic, linear, angular);
        }
        if way != 2 {
            def.locked_axes = locked;
        }
        let body = world.create_body(&def).unwrap();
        if way == 1 || way == 2 {
            world.set_linear_velocity(body, linear).unwrap();
            world.set_angular_velocity(body, angular).unwrap();
        }
        match way {
            2 => world.set_locked_axes(body, locked).unwrap(),
            3 => world.set_body_kind(body, BodyKind::Dynamic).unwrap(),
            _ => {}
        }
        for _ in 0..60 {
            world.step(1.0 / 60.0).unwrap();
        }
        let (pose, speed) = (world.pose(body).unwrap(), world.linear_velocity(body).unwrap());
        assert!(pose.position.y == 0.0 && (pose.position.x - 1.0).abs() < 1.0e-5, "way {way}: at {}", pose.position);
        assert!(speed == Vec3::X && world.angular_velocity(body).unwrap() == Vec3::Z, "way {way}: {speed} m/s");
    }
}
