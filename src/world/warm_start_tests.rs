//! Tests of the warm start by body, which only large islands use (*solve/body_warm_start.rs*).

use glam::{DVec3, Quat, Vec3};

use crate::{BodyDef, Material, Pose, Shape, ShapeDef, World, WorldDef};

/// A heap of slabs of 0.5 × 0.1 × 0.2 m that fall on the ground and on each other, tumbling and sliding, after so many steps. One of them resists
/// spinning by so much (m).
fn heap(spinning_friction: f32, steps: u32) -> World {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let ground = ShapeDef::new(Shape::cuboid(Vec3::new(20.0, 1.0, 20.0)).unwrap());
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(ground)).unwrap();
    for number in 0..600 {
        let (layer, place) = (number / 200, number % 200);
        let position = DVec3::new(f64::from(place % 10), 0.06 + 0.15 * f64::from(layer), f64::from(place / 10))
            * DVec3::new(0.45, 1.0, 0.18);
        let pose = Pose { position, rotation: Quat::from_rotation_y(0.2 * (number % 7) as f32) };
        let spinning_friction = if number == 0 { spinning_friction } else { 0.0 };
        let material = Material { spinning_friction, ..Material::default() };
        let slab = ShapeDef { material, ..ShapeDef::new(Shape::cuboid(Vec3::new(0.25, 0.05, 0.1)).unwrap()) };
        let def =
            BodyDef { linear_velocity: Vec3::X * 2.0, angular_velocity: Vec3::new(1.0, 4.0, 2.0), ..BodyDef::dynamic(pose) };
        world.create_body(&def.with_shape(slab)).unwrap();
    }
    for _ in 0..steps {
        world.step(1.0 / 60.0).unwrap();
    }
    world
}

#[test]
fn what_bodies_carry_is_what_their_contacts_carry() {
    // From the third step on chance decides which slab meets which edge, and hundredths of a metre per second differ by it alone.
    for steps in 1..=2 {
        // No torque to speak of, but contacts that are not plain are gone through in each substep.
        let (by_body, by_contact) = (heap(0.0, steps), heap(1.0e-20, steps));
        let is_on =
            |world: &World| world.batches.stages[..world.batches.count].iter().any(|stages| stages.body_warm_start.is_on());
        assert!(is_on(&by_body) && !is_on(&by_contact));
        let velocities = |world: &World| {
            world.bodies.iter().map(|(_, body)| [body.linear_velocity, body.angular_velocity]).collect::<Vec<_>>()
        };
        let pairs = velocities(&by_body)
            .into_iter()
            .zip(velocities(&by_contact))
            .flat_map(|(one, other)| [0, 1].map(|i| (one[i], other[i])));
        let mut off: Vec<f32> = pairs.map(|(one, other)| (one - other).length()).collect();
        off.sort_unstable_by(f32::total_cmp);
        // Rounding alone, 4e-5 after one step; then a slab here and there meets an edge a substep sooner than in the other world, and
        // hands that on: 4e-3 at 99 of 100, 1e-2 at the worst. Without δω ← I'⁻¹ I δω it is 0.6 rad/s after one step.
        let (most, worst) = (off[off.len() * 99 / 100], off[off.len() - 1]);
        let bound = if steps == 1 { 1.0e-3 } else { 1.0e-2 };
        assert!(most < bound && worst < 2.0e-2, "velocities differ by {most}, at the worst by {worst}, after {steps} steps");
    }
}
