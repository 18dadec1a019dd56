//! A snapshot that was made up with a right checksum is refused or gives a world that steps: never a panic.

use glam::Vec3;

use super::{LISTED, seal};
use crate::{BodyDef, Geometry, JointDef, JointKind, LocalPose, Pose, Shape, ShapeDef, World, WorldDef};

/// Bodies of several kinds and forms in contact, jointed and asleep.
fn busy_world() -> World {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let floor = ShapeDef::new(Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap());
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
    let parts = vec![
        (LocalPose::IDENTITY, Geometry::Ball { radius: 0.3 }),
        (LocalPose::at(Vec3::X * 0.3), Geometry::Box { half_extents: Vec3::splat(0.2) }),
    ];
    let forms = [Geometry::Box { half_extents: Vec3::splat(0.3) }, Geometry::Compound { parts }, Geometry::Ball { radius: 0.25 }];
    let mut bodies = Vec::new();
    for number in 0..12 {
        let shape = ShapeDef::new(Shape::new(forms[number % 3].clone()).unwrap());
        let pose = Pose::at_xyz(0.7 * (number % 4) as f64, 0.3 + 0.6 * (number / 4) as f64, 0.0);
        bodies.push(world.create_body(&BodyDef::dynamic(pose).with_shape(shape)).unwrap());
    }
    world.create_joint(&JointDef::new(JointKind::HINGE, bodies[8], bodies[9]).at(Vec3::X * 0.35, Vec3::X * -0.35)).unwrap();
    for _ in 0..40 {
        world.step(1.0 / 60.0).unwrap();
    }
    world.put_to_sleep(bodies[2]).unwrap();
    world.destroy_body(bodies[5]).unwrap();
    world
}

/// Seeds that the test goes through; LONGSPAN_SEEDS=n takes others, for a search of an hour.
const SEEDS: u64 = 1;

#[test]
fn what_is_made_up_does_no_harm() {
    let source = busy_world();
    let mut good = Vec::new();
    source.save(&mut good);
    let chosen = std::env::var("LONGSPAN_SEEDS").ok().and_then(|seeds| seeds.parse().ok());
    let seeds = chosen.map_or(0..SEEDS, |seeds: u64| SEEDS..SEEDS + seeds);
    let mut accepted = 0;
    for seed in seeds {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(2 * seed + 1);
        let mut random = |below: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % below as u64) as usize
        };
        for number in 0..4000 {
            let mut made_up = good.clone();
            for _ in 0..1 + random(4) {
                let at = 40 + random(made_up.len() - 40);
                match random(4) {
                    0 => made_up[at] ^= 1 << random(8),
                    1 => made_up[at] = random(256) as u8,
                    2 => drop(made_up.remove(at)),
                    _ => made_up.insert(at, random(256) as u8),
                }
            }
            seal::close(&mut made_up, seal::form(LISTED));
            let outcome = std::panic::catch_unwind(|| live(&made_up));
            accepted += usize::from(outcome.unwrap_or_else(|_| panic!("seed {seed}, snapshot {number}")));
        }
    }
    println!("{accepted} made up snapshots made sense");
    assert!(accepted > 10, "only {accepted} were accepted");
}

/// Whether a snapshot is accepted; if so, its world lives for a while.
fn live(snapshot: &[u8]) -> bool {
    let mut world = World::new(&WorldDef::default()).unwrap();
    if world.restore(snapshot).is_err() {
        return false;
    }
    for _ in 0..3 {
        world.step(1.0 / 60.0).unwrap();
    }
    for body in world.bodies().collect::<Vec<_>>() {
        world.destroy_body(body).unwrap();
    }
    true
}
