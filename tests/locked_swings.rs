//! Axes that are locked take nothing from a motion that they do not forbid: what hangs, stands and spins in a plane, or upright, goes on as what is free.

use std::f32::consts::FRAC_PI_2;

use longspan::glam::{Quat, Vec3};
use longspan::{
    BodyDef, BodyId, JointDef, JointKind, LockedAxes, Mass, MassProperties, Pose, Shape, ShapeDef, Solver, World, WorldDef,
};

const GRAVITY: f64 = 9.81;
const NONE: LockedAxes = LockedAxes { translation: [false; 3], rotation: [false; 3] };
/// What a game in a plane locks.
const PLANAR: LockedAxes = LockedAxes { translation: [false, false, true], rotation: [true, true, false] };
/// What keeps a character upright.
const UPRIGHT: LockedAxes = LockedAxes { translation: [false; 3], rotation: [true; 3] };
const ONE_WAY: LockedAxes = LockedAxes { translation: [false, false, true], ..NONE };
const ONE_TURN: LockedAxes = LockedAxes { rotation: [true, false, false], ..NONE };

/// A body of these half extents that touches nothing.
fn body(world: &mut World, half: Vec3, mass: f32, [x, y]: [f64; 2], locks: LockedAxes) -> BodyId {
    let mut shape = ShapeDef::new(Shape::cuboid(half).unwrap());
    shape.filter.collides_with = 0;
    let def = BodyDef { mass: Mass::Total(mass), locked_axes: locks, ..BodyDef::dynamic(Pose::at_xyz(x, y, 0.0)) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

/// A joint with its axis along z at this place.
fn join(world: &mut World, kind: JointKind, a: BodyId, b: BodyId, [x, y]: [f64; 2]) {
    let frame = |body: BodyId| {
        let own = world.pose(body).unwrap();
        let back = own.rotation.conjugate();
        let at = back.as_dquat() * (Pose::at_xyz(x, y, 0.0).position - own.position);
        Pose { position: at, rotation: back * Quat::from_rotation_y(-FRAC_PI_2) }
    };
    let (frame_a, frame_b) = (frame(a), frame(b));
    world.create_joint(&JointDef { frame_a, frame_b, ..JointDef::new(kind, a, b) }).unwrap();
}

/// A world, and a body of it that nothing moves.
fn world(gravity: Vec3, solver: Solver) -> (World, BodyId) {
    let mut world = World::new(&WorldDef { gravity, solver, ..WorldDef::default() }).unwrap();
    let anchor = world.create_body(&BodyDef::fixed(Pose::IDENTITY)).unwrap();
    (world, anchor)
}

/// Kinetic and potential energy (J).
fn energy(world: &World, bodies: &[BodyId]) -> f64 {
    let of = |&body: &BodyId| {
        let own = world.mass_properties(body).unwrap().unwrap();
        let pose = world.pose(body).unwrap();
        let spin = (pose.rotation * own.inertia_frame).conjugate() * world.angular_velocity(body).unwrap();
        let kinetic = own.mass * world.linear_velocity(body).unwrap().length_squared() + spin.dot(own.principal_inertia * spin);
        0.5 * f64::from(kinetic) + f64::from(own.mass) * GRAVITY * pose.position.y
    };
    bodies.iter().map(of).sum()
}

/// Worst change of the energy of two rods of a length `size`, let go level, in three swings, over what they fall by.
fn double_pendulum(rate: u32, size: f64, kind: JointKind, locks: LockedAxes) -> f64 {
    let (mut world, anchor) = world(WorldDef::default().gravity, Solver::Auto);
    let half = Vec3::new(0.5, 0.05, 0.05) * size as f32;
    let rods = [0.5, 1.5].map(|x| body(&mut world, half, 1.0, [x * size, 0.0], locks));
    join(&mut world, kind, anchor, rods[0], [0.0, 0.0]);
    join(&mut world, kind, rods[0], rods[1], [size, 0.0]);
    let first = energy(&world, &rods);
    let mut worst = 0.0_f64;
    for _ in 0..(4.0 * size.sqrt() * f64::from(rate)) as u32 {
        world.step(1.0 / rate as f32).unwrap();
        worst = worst.max((energy(&world, &rods) - first).abs());
    }
    worst / (2.0 * GRAVITY * size)
}

#[test]
fn what_swings_in_a_plane_keeps_its_energy_when_it_is_locked_there() {
    for rate in [30, 60, 120, 240] {
        for size in [0.5, 1.0, 10.0] {
            for kind in [JointKind::HINGE, JointKind::SPHERICAL] {
                let free = double_pendulum(rate, size, kind, NONE);
                for locks in [PLANAR, ONE_WAY, ONE_TURN] {
                    let off = double_pendulum(rate, size, kind, locks);
                    let what = format!("{rate} Hz, {size} m, {kind:?}, {locks:?}");
                    assert!(off < 1.1 * free + 1.0e-5, "{what}: energy changes by {off} of m g l, without locks by {free}");
                }
            }
        }
    }
}

/// Share of its energy that a character of 80 kg keeps which hangs upright from a rope of so many links of half a kilogram, and is sent
/// across it at this speed over √size (m/s), a fifth of a second later.
fn sent_off(rate: u32, size: f64, links: u32, speed: f32, locks: LockedAxes) -> f64 {
    let (mut world, anchor) = world(WorldDef::default().gravity, Solver::Auto);
    let mut bodies: Vec<BodyId> = Vec::new();
    let link = |n: u32| -0.4 * f64::from(n) * size;
    for n in 0..links {
        let half = Vec3::new(0.03, 0.2, 0.03) * size as f32;
        let next = body(&mut world, half, 0.5, [0.0, link(n) - 0.2 * size], NONE);
        join(&mut world, JointKind::SPHERICAL, *bodies.last().unwrap_or(&anchor), next, [0.0, link(n)]);
        bodies.push(next);
    }
    let half = Vec3::splat(0.3 * size as f32);
    let character = body(&mut world, half, 80.0, [0.35 * size, link(links) - 0.1 * size], locks);
    join(&mut world, JointKind::SPHERICAL, *bodies.last().unwrap_or(&anchor), character, [0.0, link(links)]);
    bodies.push(character);
    let before = energy(&world, &bodies);
    world.set_linear_velocity(character, Vec3::X * speed * size.sqrt() as f32).unwrap();
    let sent = energy(&world, &bodies) - before;
    for _ in 0..(0.2 * size.sqrt() * f64::from(rate)) as u32 {
        world.step(1.0 / rate as f32).unwrap();
    }
    (energy(&world, &bodies) - before) / sent
}

#[test]
fn an_upright_character_swings_off_on_a_rope() {
    for rate in [30, 60, 120, 240] {
        for size in [0.1, 1.0, 10.0] {
            for links in [1, 5, 15] {
                for speed in [1.0, 5.0, 10.0] {
                    for locks in [UPRIGHT, ONE_WAY, ONE_TURN] {
                        let kept = sent_off(rate, size, links, speed, locks);
                        let free = sent_off(rate, size, links, speed, NONE);
                        let what = format!("{rate} Hz, {size} m, {links} links, {speed} m/s, {locks:?}");
                        assert!(
                            (free - 0.05..1.001).contains(&kept),
                            "{what}: {kept} of the energy is left, {free} without locks"
                        );
                    }
                }
            }
        }
    }
}

/// Characters who stand on a hinged deck that ropes hold: their greatest depth over the size, and the steps that were given up.
fn crowd(rate: u32, size: f64, count: u32, locks: LockedAxes) -> (f32, usize) {
    let (mut world, anchor) = world(WorldDef::default().gravity, Solver::Auto);
    let mut planks: Vec<BodyId> = Vec::new();
    for n in 0..8 {
        let x = f64::from(n) * size;
        let shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.48, 0.05, 0.5) * size as f32).unwrap());
        let def = BodyDef { mass: Mass::Total(30.0), ..BodyDef::dynamic(Pose::at_xyz(x, -0.05 * size, 0.0)) };
        let plank = world.create_body(&def.with_shape(shape)).unwrap();
        join(&mut world, JointKind::HINGE, *planks.last().unwrap_or(&anchor), plank, [x - 0.5 * size, -0.05 * size]);
        planks.push(plank);
    }
    join(&mut world, JointKind::HINGE, anchor, planks[7], [7.5 * size, -0.05 * size]);
    for n in 0..count {
        let at = Pose::at_xyz((2.0 + 0.4 * f64::from(n)) * size, 0.9 * size, 0.0);
        let shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.2, 0.9, 0.2) * size as f32).unwrap());
        let def = BodyDef { mass: Mass::Total(80.0), locked_axes: locks, ..BodyDef::dynamic(at) };
        world.create_body(&def.with_shape(shape)).unwrap();
    }
    let (mut deepest, mut given_up) = (0.0_f32, 0);
    for _ in 0..(size.sqrt() * f64::from(rate)) as u32 {
        world.step(1.0 / rate as f32).unwrap();
        deepest = deepest.max(world.report().residuals.penetration);
        given_up += world.islands().iter().filter(|island| island.given_up).count();
    }
    (deepest / size as f32, given_up)
}

/// Friction against spin between two of them has nothing to move: its response was zero, and the step no number.
#[test]
fn upright_characters_who_touch_stand_on_a_hinged_deck() {
    for rate in [30, 60, 120, 240] {
        for size in [0.1, 1.0, 10.0] {
            for locks in [UPRIGHT, PLANAR, ONE_TURN] {
                let (deepest, given_up) = crowd(rate, size, 6, locks);
                let what = format!("{rate} Hz, {size} m, {locks:?}");
                assert!(deepest < 1.0e-3, "{what}: {deepest} of their size deep");
                assert_eq!(given_up, 0, "{what}: steps are given up");
            }
        }
    }
}

/// A body whose principal axes lean out of the plane turns in it by what its inertia is about the plane's normal: (I⁻¹)_zz⁻¹ is not I_zz.
#[test]
fn what_leans_out_of_its_plane_turns_there_as_its_inertia_says() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for rate in [30, 60, 120, 240] {
            let (mut world, anchor) = world(Vec3::ZERO, solver);
            let moments = Vec3::new(1.0, 0.9, 0.15);
            let frame = Quat::from_rotation_x(0.6);
            let properties = MassProperties { inertia_frame: frame, ..MassProperties::new(2.0, moments) };
            let def = BodyDef { mass: Mass::Properties(properties), locked_axes: PLANAR, ..BodyDef::dynamic(Pose::IDENTITY) };
            let [free, struck] = [0, 1].map(|_| world.create_body(&def).unwrap());
            world.set_angular_velocity(free, Vec3::Z * 3.0).unwrap();
            world.add_angular_impulse(struck, Vec3::Z).unwrap();
            let hung = world.create_body(&def).unwrap();
            join(&mut world, JointKind::HINGE, anchor, hung, [-1.0, 0.0]);
            world.add_angular_impulse(hung, Vec3::Z).unwrap();
            // z in the principal axes.
            let axis = frame.conjugate() * Vec3::Z;
            let moment = axis.dot(moments * axis);
            for _ in 0..2 * rate {
                world.step(1.0 / rate as f32).unwrap();
            }
            let spin = |body| world.angular_velocity(body).unwrap().z;
            for (body, expected) in [(free, 3.0), (struck, 1.0 / moment), (hung, 1.0 / (moment + 2.0))] {
                let off = spin(body) / expected - 1.0;
                assert!(off.abs() < 2.0e-3, "{solver:?}, {rate} Hz: {} rad/s for {expected}", spin(body));
            }
        }
    }
}
