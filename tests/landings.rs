//! Loads that straight chains let down on a floor: the hook goes on, and the chain above has to give way to a side.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, BodyId, JointDef, JointKind, Mass, Pose, Shape, ShapeDef, World, WorldDef};

const LINKS: usize = 13;

struct Lowering {
    world: World,
    hook: BodyId,
    /// Links from the hook on, and the load last.
    bodies: Vec<BodyId>,
}

/// Thirteen links of this length and a load of twenty times the mass of each below a hook, all going down at `speed`; one link is off the line
/// by a thousandth of that speed.
fn lowering(link: f32, speed: f32) -> Lowering {
    let mut world = World::new(&WorldDef::default()).expect("a valid world");
    let size = f64::from(link);
    let floor = ShapeDef::new(Shape::cuboid(Vec3::new(50.0, 0.5, 50.0) * link).expect("a valid box"));
    world.create_body(&BodyDef::fixed(Pose::at(DVec3::NEG_Y * 0.5 * size)).with_shape(floor)).expect("a valid body");
    let mut top = DVec3::Y * (size * (LINKS as f64 + 1.03));
    let hook = world.create_body(&BodyDef::kinematic(Pose::at(top))).expect("a valid body");
    let (mut above, mut at, mut bodies) = (hook, Vec3::ZERO, Vec::new());
    for number in 0..=LINKS {
        let is_load = number == LINKS;
        let half = if is_load { Vec3::splat(0.5) } else { Vec3::new(0.1, 0.5, 0.1) };
        let mass = if is_load { 80.0 } else { 4.0 } * link.powi(3);
        let shape = ShapeDef::new(Shape::cuboid(half * link).expect("a valid box"));
        let def = BodyDef::dynamic(Pose::at(top - DVec3::Y * 0.5 * size)).with_shape(shape).with_mass(Mass::Total(mass));
        let body = world.create_body(&def).expect("a valid body");
        let joint = JointDef::new(JointKind::SPHERICAL, above, body).at(at, Vec3::Y * 0.5 * link);
        world.create_joint(&joint).expect("a valid joint");
        let aside = if number == LINKS / 2 { 1.0e-3 * speed } else { 0.0 };
        world.set_linear_velocity(body, Vec3::new(aside, -speed, 0.0)).expect("a body of the world");
        (above, at) = (body, Vec3::NEG_Y * 0.5 * link);
        top -= DVec3::Y * size;
        bodies.push(body);
    }
    Lowering { world, hook, bodies }
}

/// A line that is pressed together by u gives way at √(2 u l/(n h)) in a substep of length h: by up to 6 u here. Links of 8 m at a share of 0.3 are
/// not here: at 240 steps a second their load still rises by 3.4 links (docs/guide/limits.md).
#[test]
fn a_load_that_a_straight_chain_lets_down_stays_on_the_floor() {
    for rate in [30.0, 60.0, 120.0, 240.0] {
        for (link, share) in [(0.3_f32, 0.1_f32), (0.3, 0.3), (0.3, 0.6), (0.3, 1.0), (8.0, 0.1), (8.0, 0.6), (8.0, 1.0)] {
            let speed = share * (9.81 * link).sqrt();
            let Lowering { mut world, hook, bodies } = lowering(link, speed);
            let (mut fastest, mut highest) = (0.0_f32, 0.0_f64);
            for _ in 0..(2.0 * (link / 9.81).sqrt() / share.max(0.3) * rate) as u32 {
                world.set_linear_velocity(hook, Vec3::NEG_Y * speed).expect("a body of the world");
                world.step(1.0 / rate).expect("a valid step");
                let speed_of = |&body: &BodyId| world.linear_velocity(body).expect("it stays").length();
                fastest = bodies.iter().map(speed_of).fold(fastest, f32::max);
                highest = highest.max(world.pose(bodies[LINKS]).expect("it stays").position.y / f64::from(link) - 0.5);
            }
            let what = format!("{rate}/s, links of {link} m, hook at {speed} m/s");
            println!("{what}: {:.1} times as fast, {highest:.3} links high", fastest / speed);
            assert!(fastest < 8.0 * speed, "{what}: {fastest} m/s");
            assert!(highest < 0.4, "{what}: the load is {highest} links above the floor");
        }
    }
}
