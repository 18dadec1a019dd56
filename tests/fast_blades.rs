//! What tumbles and meets another free body gains no energy, flagged fast or not.

use longspan::glam::{self, DVec3, Quat, Vec3};
use longspan::*;
use longspan_scenes::Random;

fn body(world: &mut World, half: Vec3, mass: f32, restitution: f32, pose: Pose, motion: [Vec3; 2]) -> BodyId {
    let mut part = ShapeDef::new(Shape::cuboid(half).unwrap());
    part.material = Material { restitution, ..Material::default() };
    let mut def = BodyDef::dynamic(pose).with_shape(part);
    (def.mass, def.fast) = (Mass::Total(mass), true);
    [def.linear_velocity, def.angular_velocity] = motion;
    world.create_body(&def).unwrap()
}

/// Of all bodies that move (J).
fn energy(world: &World, bodies: &[BodyId]) -> f64 {
    let of = |&body: &BodyId| {
        let (linear, angular) = (world.linear_velocity(body).unwrap(), world.angular_velocity(body).unwrap());
        let mass = world.mass_properties(body).unwrap().unwrap();
        let own = ((world.pose(body).unwrap().rotation * mass.inertia_frame).conjugate() * angular).as_dvec3();
        0.5 * (f64::from(mass.mass) * linear.as_dvec3().length_squared() + own.dot(mass.principal_inertia.as_dvec3() * own))
    };
    bodies.iter().map(of).sum()
}

/// A blade and small cubes that fly into it: what was stopped on its way was turned back, and kept its angular velocity as another body about other
/// axes would: 9 to 32 of 200 throws gained, up to twice their energy.
#[test]
fn what_flies_into_a_blade_gains_nothing() {
    for (size, rate, thick, restitution) in [
        (1.0_f32, 60.0_f32, 0.01, 0.0),
        (1.0, 60.0, 0.01, 0.5),
        (1.0, 60.0, 0.08, 0.0),
        (0.1, 60.0, 0.01, 0.5),
        (1.0, 240.0, 0.01, 0.5),
    ] {
        for seed in 0..60 {
            let mut dice = Random::new(seed);
            let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
            let spin = [Vec3::ZERO, Vec3::Y * 60.0];
            let blade = body(&mut world, Vec3::new(1.0, thick, 0.08) * size, 2.0, restitution, Pose::IDENTITY, spin);
            let (angle, along) = (dice.between(0.0, std::f32::consts::TAU), dice.between(0.3, 0.9));
            let at = Vec3::new(along * angle.cos(), 0.15 + thick + dice.between(0.0, 0.3), along * angle.sin()) * size;
            let turn =
                Quat::from_euler(glam::EulerRot::XYZ, dice.between(-3.0, 3.0), dice.between(-3.0, 3.0), dice.between(-3.0, 3.0));
            let pose = Pose::at(DVec3::from(at)).rotated(turn);
            let cube = body(&mut world, Vec3::splat(0.06 * size), 0.3, restitution, pose, [Vec3::NEG_Y * 8.0 * size, Vec3::ZERO]);
            let before = energy(&world, &[blade, cube]);
            for step in 0..(0.15 * rate) as u32 {
                world.step(1.0 / rate).unwrap();
                let kept = energy(&world, &[blade, cube]) / before;
                assert!(
                    kept < 1.01,
                    "{size}, {rate} Hz, {thick}, e = {restitution}, seed {seed}, step {step}: {kept} of the energy"
                );
            }
        }
    }
}
