//! What hops a little comes down, and rests.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyId, Mass, Material, Pose, Shape, ShapeDef, World, WorldDef};

const RADIUS: f32 = 0.02857;
const SUBSTEPS: f64 = 4.0;

/// Numbers from 0 to 1, the same ones each time.
struct Shares(u32);

impl Shares {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }
}

fn table(friction: f32) -> World {
    let mut world = World::new(&WorldDef { restitution_threshold: 0.05, ..WorldDef::default() }).unwrap();
    let mut slab = ShapeDef::new(Shape::cuboid(Vec3::new(5.0, 0.05, 5.0)).unwrap());
    slab.material = Material { friction, ..Material::default() };
    world.create_body(&BodyDef::fixed(Pose::at(DVec3::Y * -0.05)).with_shape(slab)).unwrap();
    world
}

fn ball(world: &mut World, at: Vec3, velocity: Vec3, friction: f32, restitution: f32) -> BodyId {
    let mut shape = ShapeDef::new(Shape::ball(RADIUS).unwrap());
    let (rolling_friction, spinning_friction) = (0.01 * RADIUS, 0.02 * RADIUS);
    shape.material = Material { friction, restitution, rolling_friction, spinning_friction, ..Material::default() };
    let def = BodyDef { linear_velocity: velocity, mass: Mass::Total(0.17), ..BodyDef::dynamic(Pose::at(at.as_dvec3())) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

/// Most that a ball may lie above the table (m): twice what it falls in a substep, or what counts as touching.
fn allowed(dt: f32) -> f64 {
    let substep = f64::from(dt) / SUBSTEPS;
    (2.0 * 9.81 * substep * substep).max(2.0e-3 * f64::from(RADIUS))
}

/// A ball that met another as it came down was held where it had been a substep before, and rolled on there, a tenth of its radius up.
#[test]
fn balls_that_meet_as_they_come_down_do_not_stay_up() {
    for rate in [30.0_f32, 60.0, 120.0] {
        let (mut shares, dt) = (Shares(1), 1.0 / rate);
        for pair in 0..150 {
            let mut world = table(0.2);
            let balls = [0.0, 1.0].map(|number| {
                let apart = number * 2.0 * RADIUS * (1.02 + 0.3 * shares.next());
                let at = Vec3::new(apart, RADIUS + 0.01 * shares.next(), 0.3 * RADIUS * shares.next());
                let velocity = Vec3::new(0.5 * shares.next(), 0.0, 0.5 * (shares.next() - 0.5));
                ball(&mut world, at, velocity, 0.2, 0.95)
            });
            let mut level_for = [0_u32; 2];
            let mut last = [0.0; 2];
            for _ in 0..(3.0 * rate) as u32 {
                world.step(dt).unwrap();
                for (i, &ball) in balls.iter().enumerate() {
                    let height = world.pose(ball).unwrap().position.y - f64::from(RADIUS);
                    let stays_up = height > allowed(dt) && (height - last[i]).abs() < 1.0e-6;
                    level_for[i] = if stays_up { level_for[i] + 1 } else { 0 };
                    last[i] = height;
                    let seconds = level_for[i] as f32 * dt;
                    assert!(seconds < 0.3, "pair {pair} at {rate} steps a second: {} mm up for {seconds} s", 1.0e3 * height);
                }
            }
        }
    }
}
