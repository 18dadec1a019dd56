//! A torque of the host on what a joint holds moves nothing, however light that is, and the joint bears it.

use longspan::glam::{Quat, Vec3};
use longspan::{BodyDef, BodyId, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, World, WorldDef};

/// Joints to the world about or along x that hold a body about z at least.
fn joints() -> Vec<(&'static str, JointKind)> {
    let still = Limits::new(0.0, 0.0);
    vec![
        ("a hinge", JointKind::Hinge { limits: Limits::NONE, motor: Motor::Off }),
        ("a slider", JointKind::Prismatic { limits: still, motor: Motor::Off }),
        ("a fixed joint", JointKind::Fixed),
    ]
}

/// Seen where the torque alone would turn it to, a body of 0.55 rad in a substep and more was solved for a turn more: it was told to spin at up to
/// 10,000 rad/s in a pose that stood still, and flew off as its joint was destroyed.
#[test]
fn what_a_joint_holds_does_not_spin_under_a_torque() {
    for rate in [30.0_f32, 60.0, 240.0] {
        for (half, mass) in
            [(Vec3::splat(0.1), 10.0_f32), (Vec3::new(0.015, 0.005, 0.005), 0.01), (Vec3::new(0.5, 0.5, 0.02), 30.0)]
        {
            for turn in [0.3_f32, 0.7, 2.0, 10.0] {
                for (name, kind) in joints() {
                    let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
                    let mut def = BodyDef::dynamic(Pose::IDENTITY).with_shape(ShapeDef::new(Shape::cuboid(half).unwrap()));
                    def.mass = Mass::Total(mass);
                    let body = world.create_body(&def).unwrap();
                    let joint = world.create_joint(&JointDef::new(kind, BodyId::NULL, body)).unwrap();
                    let inertia = mass / 3.0 * (half.x * half.x + half.y * half.y);
                    // That turns it by `turn` in one of four substeps.
                    let torque = turn * inertia * (4.0 * rate).powi(2);
                    let mut told = 0.0;
                    for _ in 0..rate as usize {
                        world.add_torque(body, Vec3::Z * torque).unwrap();
                        world.step(1.0 / rate).unwrap();
                        told = world.joint_state(joint).unwrap().torque.length();
                        let what = format!("{name}, {half}, {turn} rad, {rate} Hz");
                        let (spin, share) = (world.angular_velocity(body).unwrap().length(), told / torque);
                        assert!(spin < 1.0e-3, "{what}: told to turn at {spin} rad/s");
                        assert!((share - 1.0).abs() < 0.02, "{what}: the joint is told to bear {share} of the torque");
                        let rotation = world.pose(body).unwrap().rotation;
                        assert!(rotation.angle_between(Quat::IDENTITY) < 1.0e-3, "{what}: turned to {rotation}");
                    }
                    assert!(told > 0.0);
                    world.destroy_joint(joint).unwrap();
                    world.step(1.0 / rate).unwrap();
                    let spin = world.angular_velocity(body).unwrap().length();
                    assert!(spin < 1.0e-3, "{name}, {half}, {turn} rad, {rate} Hz: leaves its joint at {spin} rad/s");
                }
            }
        }
    }
}
