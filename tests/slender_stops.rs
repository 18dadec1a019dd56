//! Stops that slender bodies spin into.

use longspan::glam::Vec3;
use longspan::{BodyDef, BodyId, Mass, MassProperties, Pose, Solver};

use crate::stops::{Stop, join_with, world};

/// A turn about the length of a slender body, which a direct solve takes apart from that of its axis from 3 rad/s on: rods, and doors taller than
/// they are wide.
#[test]
fn a_slender_body_that_spins_into_a_stop_leaves_at_its_share_of_the_speed() {
    for (stop, restitution) in [Stop::Hinge, Stop::Twist, Stop::SixAxisTurn]
        .into_iter()
        .flat_map(|stop| [0.3, 0.6].map(|restitution| (stop, restitution)))
    {
        for (rate, speed) in
            [30.0, 60.0, 240.0].into_iter().flat_map(|rate| [1.0, 3.5, 4.5, 8.0, 20.0, 50.0].map(|speed| (rate, speed)))
        {
            let (dt, way) = (1.0 / rate, 0.6);
            let mut world = world(Solver::Auto, 0.0);
            let properties = Mass::Properties(MassProperties::new(27.0, Vec3::new(1.75, 10.7, 9.0)));
            let door = world.create_body(&BodyDef::dynamic(Pose::IDENTITY).with_mass(properties)).expect("a valid body");
            join_with(&mut world, stop, [BodyId::NULL, door], way, restitution);
            stop.start(&mut world, door, speed);
            let mut left = speed;
            for _ in 0..(way / (speed * dt)) as u32 + 3 {
                world.step(dt).expect("a valid step");
                left = stop.speed(&world, door);
                if left < 0.0 {
                    break;
                }
            }
            let (share, what) = (-left / speed, format!("{stop:?}, {rate}/s, {speed} rad/s"));
            assert!((share - restitution).abs() < 0.01, "{what}: leaves at {share} of its speed, bound {restitution} ± 0.01");
        }
    }
}
