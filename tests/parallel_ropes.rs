//! A platform on several ropes of links: each bears its share, at rest and as it swings. Only what the ropes would give by says which.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyId, CollisionFilter, JointDef, JointId, JointKind, Mass, Pose, Shape, ShapeDef, World, WorldDef};

const GRAVITY: f64 = 9.81;
const LINK: f64 = 0.2;
const PLATFORM: f64 = 50.0;

/// Ropes in a ring around the middle of a platform, each of so many links.
struct Platform {
    world: World,
    body: BodyId,
    tops: Vec<JointId>,
    weight: f64,
}

impl Platform {
    fn new(ropes: usize, links: usize, scale: f64) -> Self {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let half = Vec3::new(1.0, 0.05, 1.0) * scale as f32;
        let shape = ShapeDef::new(Shape::cuboid(half).unwrap());
        let body = world
            .create_body(&BodyDef::dynamic(Pose::IDENTITY).with_shape(shape).with_mass(Mass::Total(PLATFORM as f32)))
            .unwrap();
        let length = 0.3 * scale;
        let mut tops = Vec::new();
        for rope in 0..ropes {
            let angle = std::f64::consts::TAU * rope as f64 / ropes as f64;
            let place = DVec3::new(0.9 * angle.cos(), 0.05, 0.9 * angle.sin()) * scale;
            let (mut above, mut at) = (body, place);
            for link in 0..=links {
                let center = place + DVec3::Y * (length * (link as f64 + 0.5));
                let next = if link == links {
                    let hook = BodyDef::fixed(Pose::at(place + DVec3::Y * (length * links as f64)));
                    world.create_body(&hook).unwrap()
                } else {
                    let shape = Shape::capsule((0.5 * length - 0.02 * scale) as f32, (0.02 * scale) as f32).unwrap();
                    let mut shape = ShapeDef::new(shape);
                    shape.filter = CollisionFilter { member_of: 2, collides_with: 0 };
                    let def = BodyDef::dynamic(Pose::at(center)).with_shape(shape);
                    world.create_body(&def.with_mass(Mass::Total(LINK as f32))).unwrap()
                };
                let low = if link == links { Vec3::ZERO } else { Vec3::Y * (-0.5 * length) as f32 };
                let joint = world.create_joint(&JointDef::new(JointKind::SPHERICAL, above, next).at(at.as_vec3(), low)).unwrap();
                (above, at) = (next, DVec3::Y * (0.5 * length));
                if link == links {
                    tops.push(joint);
                }
            }
        }
        Self { world, body, tops, weight: GRAVITY * (PLATFORM + (ropes * links) as f64 * LINK) }
    }

    /// What each rope bears, as a share of an equal one.
    fn shares(&self) -> Vec<f64> {
        let load = |&joint: &JointId| f64::from(self.world.joint_state(joint).unwrap().force.y).abs();
        self.tops.iter().map(|joint| load(joint) * self.tops.len() as f64 / self.weight).collect()
    }
}

#[test]
fn every_rope_bears_its_share_of_a_platform_at_rest() {
    for rate in [30.0_f32, 60.0, 120.0, 240.0] {
        for (ropes, links, scale) in [(4, 1, 1.0), (4, 8, 1.0), (5, 2, 1.0), (6, 3, 0.1), (8, 5, 10.0)] {
            let mut platform = Platform::new(ropes, links, scale);
            for _ in 0..(0.5 * rate) as usize {
                platform.world.step(1.0 / rate).unwrap();
                for share in platform.shares() {
                    assert!(
                        (share - 1.0).abs() < 0.01,
                        "{ropes} ropes of {links}, {scale}, {rate} Hz: one bears {share:.3} of it"
                    );
                }
            }
        }
    }
}

#[test]
fn every_rod_bears_its_share_of_a_platform_that_swings() {
    for rate in [30.0_f32, 60.0, 120.0, 240.0] {
        for (ropes, scale) in [(4, 1.0), (5, 1.0), (8, 1.0), (6, 10.0)] {
            let mut platform = Platform::new(ropes, 1, scale);
            platform.world.set_linear_velocity(platform.body, Vec3::X * (0.3 * scale.sqrt() as f32)).unwrap();
            for _ in 0..(3.0 * rate) as usize {
                platform.world.step(1.0 / rate).unwrap();
                for share in platform.shares() {
                    assert!((share - 1.0).abs() < 0.3, "{ropes} rods, {scale}, {rate} Hz: one bears {share:.3} of its share");
                }
            }
        }
    }
}
