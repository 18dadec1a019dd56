//! What lies between a floor and a heavy body does not leave through the floor.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, Mass, Pose, Shape, ShapeDef, World, WorldDef};

/// A number from 0 to 1 that goes on from the last.
fn draw(state: &mut u64) -> f32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 40) as f32 / 16_777_216.0
}

fn solid(world: &mut World, geometry: Geometry, (at, turn): (DVec3, Quat), mass: Option<f32>) -> BodyId {
    let pose = Pose { position: at, rotation: turn };
    let def = if mass.is_some() { BodyDef::dynamic(pose) } else { BodyDef::fixed(pose) };
    let mut def = def.with_shape(ShapeDef::new(Shape::new(geometry).unwrap()));
    if let Some(mass) = mass {
        def.mass = Mass::Total(mass);
    }
    world.create_body(&def).unwrap()
}

/// Past the middle of the floor the shortest way out was that below: of 25 up to 6 left.
#[test]
fn a_heavy_crate_that_falls_on_a_heap_pushes_nothing_through_the_floor() {
    for (rate, seed) in [30.0_f32, 60.0, 120.0].into_iter().flat_map(|rate| (1..4).map(move |seed| (rate, seed))) {
        let (size, mut state) = (0.1_f32, seed);
        let mut world = World::new(&WorldDef::default()).unwrap();
        let half = |x: f32, y: f32, z: f32| Geometry::Box { half_extents: size * Vec3::new(x, y, z) };
        let at = |x: f32, y: f32, z: f32| ((size * Vec3::new(x, y, z)).as_dvec3(), Quat::IDENTITY);
        solid(&mut world, half(1.0, 0.1, 1.0), at(0.0, -0.1, 0.0), None);
        for side in [-1.1, 1.1] {
            solid(&mut world, half(0.1, 2.0, 1.0), at(side, 2.0, 0.0), None);
            solid(&mut world, half(1.2, 2.0, 0.1), at(0.0, 2.0, side), None);
        }
        let heap: Vec<BodyId> = (0..25)
            .map(|i| {
                let mut aside = || 1.2 * draw(&mut state) - 0.6;
                let (place, _) = at(aside(), 0.3 + 0.15 * i as f32, aside());
                let turn = Quat::from_scaled_axis(3.0 * Vec3::new(aside(), aside(), aside()));
                let geometry = if i % 2 == 1 { half(0.15, 0.15, 0.15) } else { Geometry::Ball { radius: 0.15 * size } };
                solid(&mut world, geometry, (place, turn), Some(0.002))
            })
            .collect();
        for _ in 0..(3.0 * rate) as u32 {
            world.step(1.0 / rate).unwrap();
        }
        let (place, _) = at(0.0, 2.5, 0.0);
        solid(&mut world, half(0.5, 0.2, 0.5), (place, Quat::from_rotation_y(0.3 * draw(&mut state))), Some(0.4));
        for step in 0..(2.0 * rate) as u32 {
            world.step(1.0 / rate).unwrap();
            for (number, &body) in heap.iter().enumerate() {
                let height = world.pose(body).unwrap().position.y as f32 / (0.2 * size);
                assert!(
                    height > -1.0,
                    "{rate} Hz, seed {seed}, step {step}, body {number}: {height} of the floor's thickness over it"
                );
            }
        }
    }
}
