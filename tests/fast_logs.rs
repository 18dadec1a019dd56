//! Long round bodies flagged fast that spin about their own axes: nothing comes nearer to anything by that.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, Pose, Shape, ShapeDef, World, WorldDef};

/// Spin bounded by how far the ends reach was so fast that searches for a touch did not end, and the body went no further in each step: a tenth
/// of its way.
#[test]
fn what_spins_about_its_own_axis_goes_on_past_what_it_does_not_touch() {
    let (radius, half_height) = (0.01_f32, 0.09);
    for geometry in [
        Geometry::Cylinder { half_height, radius },
        Geometry::Capsule { half_height, radius },
        Geometry::Cone { half_height, radius },
    ] {
        let shape = Shape::new(geometry.clone()).unwrap();
        for rate in [30.0_f32, 60.0, 120.0, 240.0] {
            for spin in [20.0, 80.0, 320.0] {
                let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
                world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(ShapeDef::new(shape.clone()))).unwrap();
                let start = DVec3::new(2.01 * f64::from(radius), -2.0 * f64::from(radius), 0.0);
                let pose = Pose { position: start, rotation: Quat::IDENTITY };
                let mut def = BodyDef::dynamic(pose).with_shape(ShapeDef::new(shape.clone()));
                (def.linear_velocity, def.angular_velocity, def.fast) = (Vec3::Y * (0.5 * radius * rate), Vec3::Y * spin, true);
                let body = world.create_body(&def).unwrap();
                for _ in 0..10 {
                    world.step(1.0 / rate).unwrap();
                }
                let gone = (world.pose(body).unwrap().position.y - start.y) / (5.0 * f64::from(radius));
                // To the rounding of f32.
                assert!((gone - 1.0).abs() < 1.0e-4, "{geometry:?}, {rate} Hz, {spin} rad/s: {gone} of the way");
            }
        }
    }
}

/// A number in a range that goes on from the last.
fn draw(state: &mut u64, low: f32, high: f32) -> f32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    low + (high - low) * ((*state >> 40) as f32 / 16_777_216.0)
}

fn post(world: &mut World, half_extents: Vec3, at: Vec3) {
    let shape = Shape::new(Geometry::Box { half_extents }).unwrap();
    let pose = Pose { position: at.as_dvec3(), rotation: Quat::IDENTITY };
    world.create_body(&BodyDef::fixed(pose).with_shape(ShapeDef::new(shape))).unwrap();
}

fn deepest(world: &World, body: BodyId) -> f32 {
    world
        .contacts_of(body)
        .unwrap()
        .flat_map(|contact| contact.points().to_vec())
        .map(|point| -point.separation)
        .fold(0.0, f32::max)
}

/// Logs that rolled off others stopped on them, and pushed them into the floor in each step; some came off again at up to 64 m/s.
#[test]
fn fast_logs_in_a_rack_lie_on_each_other() {
    let size = 0.1_f32;
    for (rate, seed) in [60.0_f32, 120.0].into_iter().flat_map(|rate| (1..4).map(move |seed| (rate, seed))) {
        let mut world = World::new(&WorldDef::default()).unwrap();
        post(&mut world, size * Vec3::new(1.0, 0.05, 1.0), size * Vec3::NEG_Y * 0.05);
        for (x, z) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            post(&mut world, size * Vec3::new(0.05, 1.0, 0.05), size * Vec3::new(0.55 * x, 1.0, 0.5 * z));
        }
        let (mut state, mut logs) = (seed, Vec::<(BodyId, f32)>::new());
        for _ in 0..12 {
            let radius = size * draw(&mut state, 0.06, 0.11);
            let top = logs.iter().map(|&(log, radius)| world.pose(log).unwrap().position.y as f32 + radius).fold(0.0, f32::max);
            let at = Vec3::new(size * draw(&mut state, -0.3, 0.3), top + radius + 0.01 * size, 0.0);
            let lean = std::f32::consts::FRAC_PI_2 + draw(&mut state, -0.01, 0.01);
            let shape = Shape::new(Geometry::Cylinder { half_height: 0.9 * size, radius }).unwrap();
            let pose = Pose { position: at.as_dvec3(), rotation: Quat::from_rotation_x(lean) };
            let mut def = BodyDef::dynamic(pose).with_shape(ShapeDef::new(shape));
            def.fast = true;
            logs.push((world.create_body(&def).unwrap(), radius));
            for step in 0..(0.5 * rate) as u32 {
                world.step(1.0 / rate).unwrap();
                for (number, &(log, radius)) in logs.iter().enumerate() {
                    let deep = deepest(&world, log) / radius;
                    // A log that lands on others is pushed in by a tenth; what is half a radius in does not come out by the way that it came.
                    assert!(
                        deep < 0.3,
                        "{rate} Hz, seed {seed}, {} logs, step {step}, log {number}: {deep} radii deep",
                        logs.len()
                    );
                }
            }
        }
    }
}
