//! Axes of the world that a body is locked along or about stay locked, however it came to its velocity.

use std::f32::consts::FRAC_PI_2;

use longspan::glam::{Quat, Vec3, Vec3Swizzles};
use longspan::{
    Axis, BodyDef, BodyKind, Geometry, JointDef, JointKind, LockedAxes, Mass, Pose, Shape, ShapeDef, Solver, World, WorldDef,
};

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

/// Two boxes that move in the plane across z, whatever of that their `locks` say, on a joint whose axis z frames are `off` by (rad): their greatest
/// energy over that at first, how far they have turned against each other (rad), and the greatest torque of the joint across z (N·m).
fn a_pair_in_a_plane(solver: Solver, rate: u32, size: f32, kind: JointKind, locks: LockedAxes, off: f32) -> (f64, f32, f32) {
    let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, solver, ..WorldDef::default() }).unwrap();
    let half_extents = Vec3::new(0.4, 0.1, 0.2) * size;
    let bodies = [0.0, 1.0].map(|x| {
        let shape = ShapeDef::new(Shape::new(Geometry::Box { half_extents }).unwrap());
        let def = BodyDef::dynamic(Pose::at_xyz(x * f64::from(size), 0.0, 0.0)).with_shape(shape);
        world.create_body(&BodyDef { locked_axes: locks, ..def.with_mass(Mass::Total(64.0 * size.powi(3))) }).unwrap()
    });
    let frame = Quat::from_axis_angle(Vec3::new(0.6, 0.8, 0.0), off) * Quat::from_rotation_y(-FRAC_PI_2);
    let mut def = JointDef::new(kind, bodies[0], bodies[1]);
    for (own, x) in [(&mut def.frame_a, 0.5), (&mut def.frame_b, -0.5)] {
        *own = Pose { rotation: frame, ..Pose::at_xyz(x * f64::from(size), 0.0, 0.0) };
    }
    let joint = world.create_joint(&def).unwrap();
    for (body, [x, y, spin]) in bodies.into_iter().zip([[1.0, -1.5, 0.5], [-0.7, 1.2, 2.0]]) {
        world.set_linear_velocity(body, Vec3::new(x, y, 0.0) * size).unwrap();
        world.set_angular_velocity(body, Vec3::Z * spin).unwrap();
    }
    let energy = |world: &World| -> f64 {
        let of = |body| {
            let (speed, spin) = (world.linear_velocity(body).unwrap() / size, world.angular_velocity(body).unwrap().z);
            f64::from(speed.length_squared() + spin * spin * 0.17 / 3.0)
        };
        bodies.into_iter().map(of).sum()
    };
    let (first, mut most, mut torque, mut turned) = (energy(&world), 0.0_f64, 0.0_f32, 0.0);
    for _ in 0..2 * rate {
        world.step(1.0 / rate as f32).unwrap();
        most = most.max(energy(&world) / first);
        torque = torque.max(world.joint_stress(joint).unwrap().load.torque.yz().length() / size.powi(5));
        let spins = bodies.map(|body| world.angular_velocity(body).unwrap().z);
        turned += (spins[1] - spins[0]).abs() / rate as f32;
    }
    (most, turned, torque)
}

#[test]
fn joints_about_an_axis_about_which_both_bodies_turn_alone_neither_throw_nor_stop_them() {
    let free = Axis::limited(f32::NEG_INFINITY, f32::INFINITY);
    let six = JointKind::Generic { linear: [Axis::LOCKED; 3], angular: [free, Axis::LOCKED, Axis::LOCKED] };
    let planar = [
        [false, false, true, true, true, false],
        [false, false, false, true, true, false],
        [false, false, true, true, false, false],
    ];
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for rate in [30, 60, 120, 240] {
            for size in [0.01, 1.0, 100.0] {
                for kind in [JointKind::HINGE, six] {
                    for [x, y, z, about_x, about_y, about_z] in planar {
                        for off in [0.0, 1.0e-7, 1.0e-5, 5.0e-4] {
                            let locks = LockedAxes { translation: [x, y, z], rotation: [about_x, about_y, about_z] };
                            let (most, turned, torque) = a_pair_in_a_plane(solver, rate, size, kind, locks, off);
                            let what = format!("{solver:?}, {rate} Hz, {size} m, {locks:?}, {off} rad off");
                            // Two rows of the joint hold what a lock does; what they lack in rounding is nothing to throw a body by.
                            assert!(most < 1.01, "{what}: energy grows to {most} of what it was");
                            assert!(turned > 1.0, "{what}: the two turn against each other by {turned} rad in 2 s, not freely");
                            let idle = about_x && about_y;
                            assert!(!idle || torque < 1.0e-3, "{what}: rows that nothing can move have {torque} N·m");
                        }
                    }
                }
            }
        }
    }
}
