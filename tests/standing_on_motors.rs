//! What motors of joints hold upright stands, whether or not its joints have stops that it never meets: on a floor, on what can move, after a fall.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Drive, Geometry, JointDef, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, Softness, SphericalMotor,
    World, WorldDef,
};

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];

/// What holds a column of links upright on its foot.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Held {
    Springs,
    Servos,
    Speeds,
    Friction,
    BallSprings,
}

impl Held {
    const ALL: [Self; 5] = [Self::Springs, Self::Servos, Self::Speeds, Self::Friction, Self::BallSprings];
    const MOTORS: [Self; 4] = [Self::Springs, Self::Servos, Self::Speeds, Self::BallSprings];

    /// The joint of a column `size` times as large as one of a metre, with stops half a radian away.
    fn joint(self, ends: [BodyId; 2], size: f32) -> JointDef {
        let (torque, limits) = (size.powi(4), Limits::new(-0.5, 0.5));
        let softness = Softness { compliance: 1.0 / (4000.0 * torque), damping: 200.0 * size.powf(4.5) };
        let motor = match self {
            Self::Springs => Motor::Drive(Drive { softness, ..Drive::to(0.0, f32::INFINITY) }),
            Self::Servos => Motor::Drive(Drive::to(0.0, 1000.0 * torque)),
            Self::Speeds => Motor::Velocity { target: 0.0, max_force: 1000.0 * torque },
            Self::Friction | Self::BallSprings => Motor::Off,
        };
        let kind = match self {
            Self::BallSprings => {
                let motor = SphericalMotor::Position { target: Quat::IDENTITY, max_torque: f32::INFINITY, softness };
                JointKind::Spherical { swing_limit: 0.5, twist_limits: Limits::new(-0.5, 0.5), motor }
            }
            _ => JointKind::Hinge { limits, motor },
        };
        let mut def = JointDef::new(kind, ends[0], ends[1]);
        if self == Self::Friction {
            def.friction = 400.0 * torque;
        }
        def
    }
}

fn cuboid(half: Vec3) -> ShapeDef {
    ShapeDef::new(Shape::cuboid(half).expect("a valid shape"))
}

fn body(world: &mut World, at: DVec3, mass: f32, shape: ShapeDef) -> BodyId {
    let def = BodyDef::dynamic(Pose::at(at)).with_shape(shape).with_mass(Mass::Total(mass));
    world.create_body(&def).expect("a valid body")
}

/// A foot of 4 kg on a height (m), `links` of 6 kg, and `load` (kg) at the top, all for a size of 1; returns the load.
fn column(world: &mut World, held: Held, (links, load, size): (u32, f32, f32), height: f64) -> BodyId {
    let (scale, mass) = (f64::from(size), size.powi(3));
    let at = |y: f64, z: f64| DVec3::new(0.0, height + y * scale, z * scale);
    let mut below = body(world, at(0.03, 0.05), 4.0 * mass, cuboid(Vec3::new(0.15, 0.03, 0.2) * size));
    let mut joint = 0.08;
    for link in 1..=links {
        let is_load = link == links;
        let half = if is_load { 0.3 } else { 0.2 };
        let shape = match is_load {
            true => cuboid(Vec3::new(0.17, 0.28, 0.1) * size),
            false => ShapeDef::new(
                Shape::new(Geometry::Capsule { half_height: 0.13 * size, radius: 0.06 * size }).expect("a valid shape"),
            ),
        };
        let own = if is_load { load } else { 6.0 } * mass;
        let above = body(world, at(joint + half, 0.0), own, shape);
        let mut def = held.joint([below, above], size);
        for (end, frame) in [below, above].into_iter().zip([&mut def.frame_a, &mut def.frame_b]) {
            *frame = Pose::at(at(joint, 0.0) - world.pose(end).expect("it stays").position);
        }
        world.create_joint(&def).expect("a valid joint");
        (below, joint) = (above, joint + 2.0 * half);
    }
    below
}

fn world(size: f32) -> World {
    let mut world = World::new(&WorldDef::default()).expect("a valid world");
    let half = Vec3::new(20.0, 1.0, 20.0) * size;
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, f64::from(-size), 0.0)).with_shape(cuboid(half))).expect("a valid body");
    world
}

/// How far the load goes aside within 4 s (sizes).
fn lean(world: &mut World, load: BodyId, rate: f32, size: f32) -> f64 {
    let mut most = 0.0_f64;
    for _ in 0..(4.0 * rate) as u32 {
        world.step(1.0 / rate).expect("a valid step");
        let at = world.pose(load).expect("it stays").position;
        most = most.max(at.x.hypot(at.z) / f64::from(size));
    }
    most
}

#[test]
fn a_column_that_its_joints_hold_stands_on_its_foot() {
    for (held, rate) in Held::ALL.into_iter().flat_map(|held| RATES.map(|rate| (held, rate))) {
        for of in [(3, 50.0, 1.0), (4, 50.0, 1.0), (5, 20.0, 1.0), (3, 10.0, 1.0), (4, 50.0, 0.2), (4, 50.0, 5.0), (8, 6.0, 1.0)]
        {
            let mut world = world(of.2);
            let load = column(&mut world, held, of, 0.0);
            let lean = lean(&mut world, load, rate, of.2);
            assert!(lean < 1.0e-3, "{held:?}, {of:?} (links, load, size), {rate}/s: leans by {lean} sizes, bound 0.001");
        }
    }
}

/// On a crate that can move, which is moved by what it bears; and let fall by 5 cm, where all of it sways a little on its springs.
#[test]
fn it_stands_on_a_crate_and_lands_on_its_foot() {
    for (held, rate) in Held::MOTORS.into_iter().flat_map(|held| RATES.map(|rate| (held, rate))) {
        for load in [10.0, 50.0] {
            let mut on_crate = world(1.0);
            body(&mut on_crate, DVec3::Y * 0.2, 30.0, cuboid(Vec3::new(0.4, 0.2, 0.4)));
            let top = column(&mut on_crate, held, (3, load, 1.0), 0.4);
            let stands = lean(&mut on_crate, top, rate, 1.0);
            let mut falls = world(1.0);
            let top = column(&mut falls, held, (3, load, 1.0), 0.05);
            let lands = lean(&mut falls, top, rate, 1.0);
            let what = format!("{held:?} under {load} kg, {rate}/s");
            assert!(stands < 2.0e-3, "{what}: leans by {stands} m on a crate, bound 2 mm");
            assert!(lands < 0.1, "{what}: leans by {lands} m when it lands, bound 0.1 m");
        }
    }
}

/// On tiles, of which its foot touches more than six.
#[test]
fn it_stands_on_tiles() {
    for (held, rate) in Held::MOTORS.into_iter().flat_map(|held| RATES.map(|rate| (held, rate))) {
        let mut world = World::new(&WorldDef::default()).expect("a valid world");
        for tile in 0..36 {
            let at = Pose::at_xyz(0.1 * f64::from(tile % 6) - 0.22, -0.05, 0.1 * f64::from(tile / 6) - 0.22);
            world.create_body(&BodyDef::fixed(at).with_shape(cuboid(Vec3::splat(0.05)))).expect("a valid body");
        }
        let top = column(&mut world, held, (3, 10.0, 1.0), 0.0);
        let lean = lean(&mut world, top, rate, 1.0);
        assert!(lean < 1.0e-3, "{held:?}, {rate}/s: leans by {lean} m, bound 1 mm");
    }
}
