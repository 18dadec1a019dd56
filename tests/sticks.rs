//! Sticks and planks that cross each other lie still: what lies on an edge has the face beside it to come down on.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Pose, Shape, ShapeDef, World, WorldDef};
use longspan_scenes::Random;

/// Steps until all of a heap of these boxes sleep, dropped one on another at any angle, and how deep the deepest overlaps then (m).
fn rest(half: Vec3, count: usize, rate: f32, seed: u64) -> (Option<u32>, f32) {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let length = f64::from(half.x);
    let floor = ShapeDef::new(Shape::cuboid(Vec3::new(100.0, 1.0, 100.0) * half.x).unwrap());
    world.create_body(&BodyDef::fixed(Pose::at(DVec3::NEG_Y * length)).with_shape(floor)).unwrap();
    let mut random = Random::new(seed);
    let bodies: Vec<BodyId> = (0..count)
        .map(|number| {
            let up = f64::from(half.y) * (1.0 + 2.5 * number as f64) + 0.02 * length;
            let place =
                DVec3::new(f64::from(random.between(-0.3, 0.3)) * length, up, f64::from(random.between(-0.3, 0.3)) * length);
            let pose = Pose::at(place).rotated(Quat::from_rotation_y(random.between(0.0, 3.0)));
            world.create_body(&BodyDef::dynamic(pose).with_shape(ShapeDef::new(Shape::cuboid(half).unwrap()))).unwrap()
        })
        .collect();
    for step in 1..=(8.0 * rate) as u32 {
        world.step(1.0 / rate).unwrap();
        if bodies.iter().all(|&body| !world.is_awake(body).unwrap()) {
            return (Some(step), world.report().residuals.penetration);
        }
    }
    (None, world.report().residuals.penetration)
}

#[test]
fn sticks_and_planks_across_each_other_come_to_rest() {
    for (name, half) in
        [("sticks", Vec3::new(0.5, 0.02, 0.02)), ("planks", Vec3::new(0.5, 0.02, 0.1)), ("rods", Vec3::new(0.05, 0.005, 0.005))]
    {
        for rate in [30.0, 60.0, 120.0] {
            let heaps: Vec<_> = (1..9).map(|seed| rest(half, 3, rate, seed)).collect();
            // With the one point of two edges 14 of 24 heaps at 60 steps a second rolled on from edge to edge, 36 mm deep in each other.
            let awake = heaps.iter().filter(|(slept, _)| slept.is_none()).count();
            assert!(awake <= 1, "{name} at {rate} Hz: {awake} of 8 heaps still awake after 8 s");
            // Planks at 30 Hz fall asleep up to a quarter of their half thickness in each other; it was all of it.
            let bound = if rate < 60.0 { 0.3 } else { 0.1 } * half.y;
            let deepest = heaps.iter().fold(0.0_f32, |deepest, heap| deepest.max(heap.1));
            assert!(deepest < bound, "{name} at {rate} Hz: {deepest} m deep, bound {bound} m");
        }
    }
}
