//! Bodies that joints hold at one point of a third, and inside of each other: slings from a hook, beads on a string.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Geometry, JointDef, JointId, JointKind, Mass, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef,
};

fn world(gravity: f32) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, sleep, ..WorldDef::default() }).unwrap()
}

fn body(world: &mut World, mass: f32, pose: Pose, shape: Shape) -> BodyId {
    let def = BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(pose) };
    world.create_body(&def.with_shape(ShapeDef::new(shape))).unwrap()
}

fn ball_joint(world: &mut World, a: (BodyId, Vec3), b: (BodyId, Vec3)) -> JointId {
    world.create_joint(&JointDef::new(JointKind::SPHERICAL, a.0, b.0).at(a.1, b.1)).unwrap()
}

/// Kinetic and potential energy (J).
fn energy(world: &World, bodies: &[BodyId], gravity: f64) -> f64 {
    let of = |&body: &BodyId| {
        let own = world.mass_properties(body).unwrap().unwrap();
        let pose = world.pose(body).unwrap();
        let spin = ((pose.rotation * own.inertia_frame).conjugate() * world.angular_velocity(body).unwrap()).as_dvec3();
        let speed = world.linear_velocity(body).unwrap().as_dvec3();
        let kinetic = 0.5 * (f64::from(own.mass) * speed.length_squared() + spin.dot(own.principal_inertia.as_dvec3() * spin));
        kinetic + f64::from(own.mass) * gravity * pose.position.y
    };
    bodies.iter().map(of).sum()
}

/// What slings begin at.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hook {
    World,
    Fixed,
    /// A heavy body on a joint of its own.
    Swinging,
}

/// Three chains of so many links from a hook to a plate that is pushed, in units of `size`, joined at their tips or in the middles of their round ends.
fn slings(world: &mut World, hook: Hook, (size, links, apart): (f32, usize, f32), by_tips: bool) -> Vec<BodyId> {
    let plate_at = Vec3::Y * size;
    let plate = Shape::new(Geometry::Cylinder { half_height: 0.03 * size, radius: 0.5 * size }).unwrap();
    let mut bodies = vec![body(world, 50.0, Pose::at(plate_at.as_dvec3()), plate)];
    let top = Vec3::Y * (4.0 * size);
    let hook = match hook {
        Hook::World => (BodyId::NULL, top),
        Hook::Fixed => {
            let shape = ShapeDef::new(Shape::ball(0.05 * size).unwrap());
            (world.create_body(&BodyDef::fixed(Pose::at(top.as_dvec3())).with_shape(shape)).unwrap(), Vec3::ZERO)
        }
        Hook::Swinging => {
            let own = body(world, 5.0, Pose::at(top.as_dvec3()), Shape::ball(0.05 * size).unwrap());
            ball_joint(world, (BodyId::NULL, top + Vec3::Y * size), (own, Vec3::Y * size));
            bodies.push(own);
            (own, Vec3::ZERO)
        }
    };
    for sling in 0..3 {
        let turn = Quat::from_rotation_y(sling as f32 * std::f32::consts::TAU / 3.0);
        let beside = turn * Vec3::X * (apart * size);
        let (from, to) = (top + beside, plate_at + turn * Vec3::new(0.4, 0.03, 0.0) * size);
        let (step, mut last) = ((to - from) / links as f32, (hook.0, hook.1 + beside));
        let half = 0.5 * step.length();
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Y, step.normalize());
        for link in 0..links {
            let at = from + step * (link as f32 + 0.5);
            let next = body(
                world,
                0.1,
                Pose::at(at.as_dvec3()).rotated(rotation),
                Shape::capsule(half - if by_tips { 0.01 * size } else { 0.0 }, 0.01 * size).unwrap(),
            );
            ball_joint(world, last, (next, Vec3::Y * half));
            last = (next, Vec3::NEG_Y * half);
            bodies.push(next);
        }
        ball_joint(world, last, (bodies[0], to - plate_at));
    }
    world.set_linear_velocity(bodies[0], Vec3::new(1.0, 0.0, 0.3) * size.sqrt()).unwrap();
    bodies
}

/// They gained 140 of 592 J in ten seconds, and links spun at 780 rad/s.
#[test]
fn slings_from_one_point_swing_without_gaining_energy() {
    for (hook, rate, size, links, apart, by_tips) in [
        (Hook::World, 60.0_f32, 1.0_f32, 10, 0.0_f32, true),
        (Hook::World, 30.0, 1.0, 4, 0.003, false),
        (Hook::World, 240.0, 0.1, 10, 0.0, true),
        (Hook::World, 60.0, 10.0, 6, 0.006, false),
        (Hook::Fixed, 60.0, 1.0, 10, 0.0, true),
        (Hook::Swinging, 60.0, 1.0, 10, 0.0, false),
        (Hook::Swinging, 120.0, 1.0, 5, 0.003, true),
    ] {
        let mut world = world(9.81);
        let bodies = slings(&mut world, hook, (size, links, apart), by_tips);
        let (start, mut most, mut spin) = (energy(&world, &bodies, 9.81), 0.0_f64, 0.0_f32);
        for _ in 0..(4.0 * rate) as usize {
            world.step(1.0 / rate).unwrap();
            most = most.max(energy(&world, &bodies, 9.81) - start);
            let spins = bodies.iter().map(|&body| world.angular_velocity(body).unwrap().length());
            spin = spin.max(spins.fold(0.0, f32::max));
        }
        let what =
            format!("{links} links from {hook:?}, {apart} beside each other, size {size} m, {rate} Hz, by tips: {by_tips}");
        // Of what the push has given, 27 J for 1 m.
        let pushed = 0.5 * 50.0 * 1.09 * f64::from(size);
        assert!(most < 0.05 * pushed, "{what}: {most} J more than at first, bound 5 % of {pushed} J");
        let swing = 10.0 / size.sqrt();
        assert!(spin < swing, "{what}: turns at {spin} rad/s, bound {swing} rad/s");
    }
}

#[test]
fn only_what_always_overlaps_does_not_collide() {
    // How far beside each other two bars are held by the middles of their round ends, of radius 5 cm: and whether they collide.
    for (apart, collides) in [(0.0, false), (0.08, false), (0.095, true), (0.12, true)] {
        for by_world in [true, false] {
            let mut world = world(0.0);
            let hub = match by_world {
                true => BodyId::NULL,
                false => world.create_body(&BodyDef::fixed(Pose::IDENTITY)).unwrap(),
            };
            let bars = [-0.5, 0.5].map(|side| {
                let at = Vec3::X * (apart * side);
                let pose = Pose::at((at + Vec3::Z * 0.5).as_dvec3()).rotated(Quat::from_rotation_x(0.5 * std::f32::consts::PI));
                let bar = body(&mut world, 1.0, pose, Shape::capsule(0.5, 0.05).unwrap());
                (bar, ball_joint(&mut world, (hub, at), (bar, Vec3::NEG_Y * 0.5)))
            });
            // Towards each other, if they are apart.
            world.set_angular_velocity(bars[0].0, Vec3::Y).unwrap();
            let mut touched = false;
            for _ in 0..30 {
                world.step(1.0 / 60.0).unwrap();
                touched |= world.contacts_of(bars[0].0).unwrap().any(|contact| contact.normal_force() > 0.0);
            }
            assert_eq!(touched, collides, "bars held {apart} m beside each other, by the world: {by_world}");
            // What no joint holds there any more collides, and no longer so where it is held again.
            world.destroy_joint(bars[1].1).unwrap();
            world
                .set_pose(
                    bars[1].0,
                    Pose::at(DVec3::new(0.0, 0.0, 0.5)).rotated(Quat::from_rotation_x(0.5 * std::f32::consts::PI)),
                )
                .unwrap();
            world.step(1.0 / 60.0).unwrap();
            assert!(world.contacts_of(bars[1].0).unwrap().count() > 0, "a bar that was let go of, {apart} m");
            if apart > 0.0 {
                continue;
            }
            ball_joint(&mut world, (hub, Vec3::ZERO), (bars[1].0, Vec3::NEG_Y * 0.5));
            world.step(1.0 / 60.0).unwrap();
            let left = world.contacts_of(bars[1].0).unwrap().count();
            assert_eq!(left, 0, "contacts of a bar that is held again, by the world: {by_world}");
        }
    }
}

/// The next bead but one of a string touches where the string bends, and is what bounds how far.
#[test]
fn beads_that_are_apart_on_a_straight_string_collide() {
    let mut world = world(0.0);
    let [left, middle, right] = [(-0.07, 1.0_f32), (0.0, 100.0), (0.07, 1.0)]
        .map(|(x, mass)| body(&mut world, mass, Pose::at(DVec3::X * x), Shape::ball(0.05).unwrap()));
    ball_joint(&mut world, (left, Vec3::X * 0.035), (middle, Vec3::X * -0.035));
    ball_joint(&mut world, (middle, Vec3::X * 0.035), (right, Vec3::X * -0.035));
    [left, right].into_iter().for_each(|bead| world.set_linear_velocity(bead, Vec3::Y).unwrap());
    let mut touched = false;
    for _ in 0..60 {
        world.step(1.0 / 60.0).unwrap();
        touched |= world.contacts_of(left).unwrap().any(|contact| contact.normal_force() > 0.0);
    }
    assert!(touched, "beads of 10 cm on a string that bends, 14 cm apart where it is straight, do not touch");
}
