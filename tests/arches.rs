//! Arches of dry stones without anything that joints hold: what leans on its neighbours' sides keeps its place.

use std::f64::consts::PI;

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, Geometry, IslandPlan, Material, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef};

/// An arch of stones of this size (m, its middle line) on two pillars stands for three seconds; how far its keystone sinks, over its size, and how
/// deep stones are in each other at the end. Plans of the islands that are solved then: one that stands may be held.
fn arch(stones: usize, size: f64, rate: f64) -> (Vec<IslandPlan>, [f64; 2]) {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let mut world = World::new(&WorldDef { sleep, ..WorldDef::default() }).unwrap();
    let shape = |geometry| {
        let material = Material { friction: 0.7, ..Material::default() };
        ShapeDef { material, density: 2400.0, ..ShapeDef::new(Shape::new(geometry).unwrap()) }
    };
    for side in [-1.0, 1.0] {
        let pillar = Geometry::Box { half_extents: Vec3::new(0.25, 0.2, 0.2) * size as f32 };
        let pose = Pose::at(DVec3::new(side, -0.2, 0.0) * size);
        world.create_body(&BodyDef::fixed(pose).with_shape(shape(pillar))).unwrap();
    }
    let mut bodies = Vec::new();
    for i in 0..stones {
        let ends = [0, 1].map(|end| PI - PI * (i + end) as f64 / stones as f64);
        let middle = 0.5 * (ends[0] + ends[1]);
        let center = DVec3::new(middle.cos(), middle.sin(), 0.0) * size;
        let corners = (0..8).map(|n| {
            let (angle, radius, z) = (ends[n & 1], [0.88, 1.12][n >> 1 & 1] * size, [-0.1, 0.1][n >> 2] * size);
            (DVec3::new(angle.cos(), angle.sin(), 0.0) * radius + DVec3::Z * z - center).as_vec3()
        });
        let stone = shape(Geometry::ConvexHull { points: corners.collect() });
        bodies.push(world.create_body(&BodyDef::dynamic(Pose::at(center)).with_shape(stone)).unwrap());
    }
    let key = bodies[stones / 2];
    let before = world.pose(key).unwrap().position.y;
    for _ in 0..(3.0 * rate) as usize {
        world.step(1.0 / rate as f32).unwrap();
    }
    let plans = world.islands().iter().map(|island| island.plan).collect();
    let sunk = before - world.pose(key).unwrap().position.y;
    (plans, [sunk / size, f64::from(world.report().residuals.penetration) / size])
}

/// Swept, 17 stones sink by 17 mm at 30 Hz and 31 by 53.
#[test]
fn an_arch_of_any_size_keeps_its_height() {
    let cases = [
        (7, 2.85, 30.0),
        (12, 2.85, 120.0),
        (17, 2.85, 30.0),
        (31, 2.85, 30.0),
        (31, 2.85, 60.0),
        (17, 0.285, 120.0),
        (17, 28.5, 60.0),
    ];
    for (stones, size, rate) in cases {
        let (plans, [sunk, deep]) = arch(stones, size, rate);
        assert_eq!(plans, [IslandPlan::Coupled], "an arch of {stones} stones is one problem");
        assert!(sunk.abs() < 3.0e-4, "{stones} stones, {size} m, {rate} Hz: sinks by {sunk} of its size, bound 3e-4");
        assert!(deep < 1.0e-4, "{stones} stones, {size} m, {rate} Hz: {deep} of its size deep, bound 1e-4");
    }
}

/// Their joints half-way up are at 45°. Where those counted as ground, one of eight stones was swept and sank by 3e-4 of its size as it was made.
#[test]
fn an_arch_of_a_multiple_of_four_stones_does_not_sink_as_it_is_made() {
    for (stones, size, rate) in [(8, 2.85, 60.0), (8, 0.285, 30.0), (12, 28.5, 60.0)] {
        let (_, [sunk, deep]) = arch(stones, size, rate);
        assert!(sunk.abs() < 1.0e-5, "{stones} stones, {size} m, {rate} Hz: sinks by {sunk} of its size, bound 1e-5");
        assert!(deep < 1.0e-4, "{stones} stones, {size} m, {rate} Hz: {deep} of its size deep, bound 1e-4");
    }
}
