//! Small machines of joints do what mechanics says of them, by either solver and at several rates.

use std::f32::consts::{FRAC_PI_2, PI};

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Geometry, JointDef, JointId, JointKind, Limits, Mass, MassProperties, Material, Motor, Pose, Shape,
    ShapeDef, SleepSettings, Softness, Solver, World, WorldDef,
};

const GRAVITY: f32 = 9.81;
const SOLVERS: [Solver; 2] = [Solver::Auto, Solver::GaussSeidel];

fn world(gravity: f32, solver: Solver) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, solver, sleep, ..WorldDef::default() }).expect("a valid world")
}

/// A box of this mass (kg) that touches nothing.
fn ghost(world: &mut World, at: DVec3, half: Vec3, mass: f32) -> BodyId {
    let mut shape = ShapeDef::new(Shape::cuboid(half).expect("a valid shape"));
    shape.filter.collides_with = 0;
    world.create_body(&BodyDef::dynamic(Pose::at(at)).with_shape(shape).with_mass(Mass::Total(mass))).expect("a valid body")
}

/// A body of this mass (kg) and radius of inertia (m) without shapes.
fn weight(world: &mut World, at: DVec3, mass: f32, radius: f32) -> BodyId {
    let inertia = Vec3::splat(mass * radius * radius);
    let def = BodyDef::dynamic(Pose::at(at)).with_mass(Mass::Properties(MassProperties::new(mass, inertia)));
    world.create_body(&def).expect("a valid body")
}

/// Joins bodies in a point of the world, with the joint's x axis along `axis`, as they stand now.
fn join(world: &mut World, kind: JointKind, [a, b]: [BodyId; 2], at: DVec3, axis: Vec3) -> JointId {
    let turn = Quat::from_rotation_arc(Vec3::X, axis);
    let seen_by = |body: BodyId| {
        let pose = if body == BodyId::NULL { Pose::IDENTITY } else { world.pose(body).expect("bodies stay") };
        Pose::at(pose.inverse_transform_point(at).as_dvec3()).rotated(pose.rotation.conjugate() * turn)
    };
    let def = JointDef { frame_a: seen_by(a), frame_b: seen_by(b), ..JointDef::new(kind, a, b) };
    world.create_joint(&def).expect("a valid joint")
}

fn steps(world: &mut World, rate: f32, seconds: f32) {
    for _ in 0..(rate * seconds).round() as usize {
        world.step(1.0 / rate).expect("a valid step");
    }
}

fn at(world: &World, body: BodyId) -> DVec3 {
    world.pose(body).expect("bodies stay").position
}

fn state(world: &World, joint: JointId) -> longspan::JointState {
    world.joint_state(joint).expect("joints stay")
}

fn motored(motor: Motor) -> JointKind {
    JointKind::Hinge { limits: Limits::NONE, motor }
}

#[test]
fn pendulums_from_a_millimetre_to_five_centimetres_gain_nothing_and_stay_whole() {
    for solver in SOLVERS {
        for rate in [60.0, 240.0] {
            for length in [1.0e-3, 5.0e-3, 2.0e-2, 5.0e-2] {
                let mut world = world(GRAVITY, solver);
                let bob = weight(&mut world, DVec3::X * length, 1.0e-3, 0.2 * length as f32);
                let joint = join(&mut world, JointKind::HINGE, [BodyId::NULL, bob], DVec3::ZERO, Vec3::Z);
                for step in 0..(5.0 * rate) as usize {
                    world.step(1.0 / rate).expect("a valid step");
                    let speed = world.linear_velocity(bob).expect("bodies stay").as_dvec3();
                    let spin = world.angular_velocity(bob).expect("bodies stay").as_dvec3();
                    let kinetic = 0.5 * (speed.length_squared() + 0.04 * length * length * spin.length_squared());
                    let energy = (kinetic / f64::from(GRAVITY) + at(&world, bob).y) / length;
                    let what = format!("{solver:?}, {rate}/s, {length} m, step {step}");
                    assert!(energy < 0.02, "{what}: gains {energy} of m g l, bound 2 %");
                    let gap = f64::from(state(&world, joint).gap) / length;
                    assert!(gap < 1e-2, "{what}: open by {gap} of the length, bound 1 %");
                }
            }
        }
    }
}

#[test]
fn a_teleported_bob_comes_back_without_a_kick() {
    for solver in SOLVERS {
        for rate in [30.0, 60.0, 240.0] {
            for away in [0.5, 2.0, 20.0] {
                let mut world = world(GRAVITY, solver);
                let bob = weight(&mut world, DVec3::NEG_Y, 1.0, 0.2);
                let joint = join(&mut world, JointKind::SPHERICAL, [BodyId::NULL, bob], DVec3::ZERO, Vec3::X);
                steps(&mut world, rate, 0.5);
                world.set_pose(bob, Pose::at(DVec3::new(away, -1.0, 0.0))).expect("a valid pose");
                let mut fastest = 0.0_f32;
                for _ in 0..(2.0 * rate) as usize {
                    world.step(1.0 / rate).expect("a valid step");
                    fastest = fastest.max(world.linear_velocity(bob).expect("bodies stay").length());
                }
                // From as high above its lowest point as it can be, and what it falls freely while it is drawn in.
                let most = (2.0 * GRAVITY * 2.2_f32).sqrt();
                let what = format!("{solver:?}, {rate}/s, {away} m");
                assert!(fastest < most, "{what}: {fastest} m/s, a bob that falls from the top has {most}");
                let gap = state(&world, joint).gap;
                assert!(gap < 1e-3, "{what}: open by {gap} m, bound 1 mm");
            }
        }
    }
}

#[test]
fn a_sprung_door_closes_as_a_damped_spring() {
    for solver in SOLVERS {
        for rate in [30.0, 60.0, 240.0] {
            let (own, time) = (4.0_f32 / 3.0, 0.4_f32);
            let mut world = world(0.0, solver);
            let door = ghost(&mut world, DVec3::X * 0.5, Vec3::new(0.5, 1.0, 0.001), 4.0);
            // Critically damped, of time constant `time`.
            let (stiffness, damping) = (own / (time * time), 2.0 * own / time);
            let softness = Softness { compliance: 1.0 / stiffness, damping };
            let motor = Motor::Position { target: -1.0, softness, max_force: f32::INFINITY };
            let joint = join(&mut world, motored(motor), [BodyId::NULL, door], DVec3::ZERO, Vec3::Y);
            for second in 1..=4 {
                steps(&mut world, rate, 0.5);
                let t = 0.5 * second as f32 / time;
                let (angle, expected) = (state(&world, joint).position + 1.0, (1.0 + t) * (-t).exp());
                let bound = 0.04 * (60.0 / rate).max(0.25);
                let off = (angle - expected).abs();
                assert!(
                    off < bound,
                    "{solver:?}, {rate}/s: {angle} rad left after {t} time constants, not {expected}; bound {bound}"
                );
            }
        }
    }
}

#[test]
fn a_parallel_four_bar_keeps_its_coupler_level_at_any_crank() {
    for solver in SOLVERS {
        for rate in [30.0, 60.0, 240.0] {
            let mut world = world(GRAVITY, solver);
            let crank = ghost(&mut world, DVec3::new(0.0, 0.5, 0.0), Vec3::new(0.05, 0.5, 0.05), 2.0);
            let rocker = ghost(&mut world, DVec3::new(2.0, 0.5, 0.0), Vec3::new(0.05, 0.5, 0.05), 2.0);
            let coupler = ghost(&mut world, DVec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 0.05, 0.05), 3.0);
            let motor = Motor::Velocity { target: 1.5, max_force: 500.0 };
            let driven = join(&mut world, motored(motor), [BodyId::NULL, crank], DVec3::ZERO, Vec3::Z);
            let joints = [
                join(&mut world, JointKind::HINGE, [BodyId::NULL, rocker], DVec3::X * 2.0, Vec3::Z),
                join(&mut world, JointKind::HINGE, [crank, coupler], DVec3::Y, Vec3::Z),
                join(&mut world, JointKind::HINGE, [rocker, coupler], DVec3::new(2.0, 1.0, 0.0), Vec3::Z),
            ];
            // Up to shortly before its dead centre, where it may go over into the crossed way.
            steps(&mut world, rate, 0.9);
            let what = format!("{solver:?}, {rate}/s");
            let angle = state(&world, driven).position;
            assert!((angle - 1.35).abs() < 0.03, "{what}: the crank has turned by {angle} rad, not 1.35");
            let axis = world.pose(coupler).expect("bodies stay").rotation * Vec3::X;
            assert!(axis.y.abs() < 5e-3, "{what}: the coupler leans by {} rad, bound 5 mrad", axis.y);
            for joint in joints {
                let gap = state(&world, joint).gap;
                assert!(gap < 2e-3, "{what}: a joint is open by {gap} m, bound 2 mm");
            }
        }
    }
}

#[test]
fn a_swimmer_gets_nowhere_in_empty_space() {
    for solver in SOLVERS {
        for rate in [30.0, 60.0, 240.0] {
            let mut world = world(0.0, solver);
            let links: Vec<BodyId> =
                (0..5).map(|i| ghost(&mut world, DVec3::X * f64::from(i), Vec3::new(0.45, 0.1, 0.1), 1.0)).collect();
            let joints: Vec<JointId> = (1..5)
                .map(|i| {
                    let place = DVec3::X * (f64::from(i) - 0.5);
                    join(&mut world, JointKind::HINGE, [links[i as usize - 1], links[i as usize]], place, Vec3::Z)
                })
                .collect();
            let center = |world: &World| links.iter().map(|&link| at(world, link)).sum::<DVec3>() / 5.0;
            let before = center(&world);
            for step in 0..(6.0 * rate) as usize {
                for (i, &joint) in joints.iter().enumerate() {
                    let target = 2.0 * (3.0 * step as f32 / rate - i as f32).sin();
                    let motor = Motor::Velocity { target, max_force: 50.0 };
                    world.set_joint_kind(joint, motored(motor)).expect("a valid joint");
                }
                world.step(1.0 / rate).expect("a valid step");
            }
            let swum = (center(&world) - before).length();
            assert!(swum < 2e-3, "{solver:?}, {rate}/s: its centre has moved by {swum} m, bound 2 mm");
        }
    }
}

#[test]
fn blades_welded_to_a_hub_coast_with_it() {
    for solver in SOLVERS {
        for rate in [30.0, 60.0, 240.0] {
            let mut world = world(0.0, solver);
            let hub = ghost(&mut world, DVec3::ZERO, Vec3::splat(0.2), 5.0);
            join(&mut world, JointKind::HINGE, [BodyId::NULL, hub], DVec3::ZERO, Vec3::Z);
            for (x, y) in [(1.0, 0.0), (-0.5, 0.75_f64.sqrt()), (-0.5, -0.75_f64.sqrt())] {
                let place = DVec3::new(x, y, 0.0);
                let blade = ghost(&mut world, place, Vec3::new(0.1, 0.1, 0.02), 1.0);
                join(&mut world, JointKind::Fixed, [hub, blade], place * 0.5, Vec3::X);
            }
            let torque = 3.0;
            world.add_angular_impulse(hub, Vec3::Z * torque).expect("it is dynamic");
            // About the hub's axis: that of a cube, and three blades a metre away.
            let own = 5.0 * 2.0 * 0.04 / 3.0 + 3.0 * (1.0 + 2.0 * 0.01 / 3.0);
            for _ in 0..5 {
                steps(&mut world, rate, 1.0);
                let share = world.angular_velocity(hub).expect("bodies stay").z * own / torque;
                assert!((share - 1.0).abs() < 5e-3, "{solver:?}, {rate}/s: keeps {share} of its momentum, bound 0.5 %");
            }
        }
    }
}

#[test]
fn a_drawbridge_hangs_on_its_chains_as_statics_says() {
    for solver in SOLVERS {
        for rate in [30.0, 60.0, 240.0] {
            let mut world = world(GRAVITY, solver);
            let (mass, length, height) = (500.0_f32, 4.0_f64, 3.0_f64);
            let deck = ghost(&mut world, DVec3::X * (0.5 * length), Vec3::new(0.5 * length as f32, 0.1, 1.0), mass);
            let hinge = join(&mut world, JointKind::HINGE, [BodyId::NULL, deck], DVec3::ZERO, Vec3::Z);
            let chain = (length * length + height * height).sqrt() as f32;
            let kind = JointKind::Distance { limits: Limits::new(0.0, chain), spring_length: None, motor: Motor::Off };
            let chains = [-1.0, 1.0].map(|z| {
                let mut def = JointDef::new(kind, BodyId::NULL, deck);
                def.frame_a = Pose::at(DVec3::new(0.0, height, z));
                def.frame_b = Pose::at(DVec3::new(0.5 * length, 0.0, z));
                world.create_joint(&def).expect("a valid joint")
            });
            steps(&mut world, rate, 3.0);
            let what = format!("{solver:?}, {rate}/s");
            let sunk = -2.0 * at(&world, deck).y;
            assert!(sunk.abs() < 2e-3, "{what}: its end has sunk by {sunk} m, bound 2 mm");
            // Moments about the hinge: two chains at a slope of 3 : 4 hold half the weight.
            let expected = 0.25 * mass * GRAVITY * chain / height as f32;
            let share = chains.map(|chain| state(&world, chain).force.length()).iter().sum::<f32>() / (2.0 * expected);
            assert!((share - 1.0).abs() < 0.01, "{what}: the chains bear {share} of what statics says, bound 1 %");
            let gap = state(&world, hinge).gap;
            assert!(gap < 1e-3, "{what}: the hinge is open by {gap} m, bound 1 mm");
        }
    }
}

#[test]
fn a_seesaw_balances_and_tips_as_its_moments_say() {
    for solver in SOLVERS {
        for rate in [30.0, 60.0, 240.0] {
            for far in [2.0_f64, 1.6] {
                let mut world = world(GRAVITY, solver);
                let plank = ghost(&mut world, DVec3::ZERO, Vec3::new(2.0, 0.02, 0.2), 10.0);
                let hinge = join(&mut world, JointKind::HINGE, [BodyId::NULL, plank], DVec3::ZERO, Vec3::Z);
                for (mass, x) in [(40.0, -1.0), (20.0, far)] {
                    let rider = weight(&mut world, DVec3::X * x, mass, 0.1);
                    join(&mut world, JointKind::Fixed, [plank, rider], DVec3::X * x, Vec3::X);
                }
                steps(&mut world, rate, 0.4);
                let far = far as f32;
                let inertia = 10.0 * (4.0 + 0.0004) / 3.0 + 40.0 * 1.01 + 20.0 * (far * far + 0.01);
                let expected = 0.5 * GRAVITY * (40.0 - 20.0 * far) / inertia * 0.16;
                let off = (state(&world, hinge).position - expected).abs();
                let bound = 0.004 * (60.0 / rate).max(1.0);
                assert!(off < bound, "{solver:?}, {rate}/s, at {far} m: off by {off} rad from {expected}, bound {bound}");
            }
        }
    }
}

#[test]
fn a_wrecking_ball_arrives_with_the_speed_of_its_fall() {
    for (solver, bound) in [(Solver::Auto, 0.01), (Solver::GaussSeidel, 0.04)] {
        for rate in [30.0, 60.0, 240.0] {
            let mut world = world(GRAVITY, solver);
            let mut before = BodyId::NULL;
            let mut joints = Vec::new();
            for i in 0..8 {
                let link = ghost(&mut world, DVec3::X * (0.25 + 0.5 * f64::from(i)), Vec3::new(0.24, 0.04, 0.04), 2.0);
                joints.push(join(&mut world, JointKind::SPHERICAL, [before, link], DVec3::X * (0.5 * f64::from(i)), Vec3::X));
                before = link;
            }
            let ball = weight(&mut world, DVec3::X * 4.5, 1000.0, 0.3);
            joints.push(join(&mut world, JointKind::SPHERICAL, [before, ball], DVec3::X * 4.0, Vec3::X));
            // It swings at 4 m and turns about its own joint, half a metre off, hardly at all.
            let (mut most, mut widest) = (0.0_f32, 0.0_f32);
            for _ in 0..(2.0 * rate) as usize {
                world.step(1.0 / rate).expect("a valid step");
                let speed = world.linear_velocity(ball).expect("bodies stay").length();
                let fallen = -at(&world, ball).y as f32;
                most = most.max(0.5 * speed * speed / (GRAVITY * fallen.max(0.5)));
                widest = joints.iter().map(|&joint| state(&world, joint).gap).fold(widest, f32::max);
            }
            let what = format!("{solver:?}, {rate}/s");
            assert!(most < 1.0 + bound, "{what}: has {most} of the energy of its fall, bound {bound} above it");
            assert!(most > 0.95, "{what}: has {most} of the energy of its fall, bound 95 %");
            assert!(widest < 0.02, "{what}: a joint opens by {widest} m, bound 2 cm");
        }
    }
}

#[test]
fn a_flipper_throws_a_ball_no_faster_than_itself() {
    for solver in SOLVERS {
        for rate in [60.0, 120.0, 240.0] {
            let mut world = world(GRAVITY, solver);
            let mut shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.5, 0.05, 0.2)).expect("a valid shape"));
            shape.material = Material { restitution: 0.0, friction: 0.0, ..Material::default() };
            let def = BodyDef::dynamic(Pose::at(DVec3::X * 0.5)).with_shape(shape.clone()).with_mass(Mass::Total(20.0));
            let flipper = world.create_body(&def).expect("a valid body");
            let kind =
                JointKind::Hinge { limits: Limits::new(0.0, 0.8), motor: Motor::Velocity { target: 10.0, max_force: 1.0e5 } };
            join(&mut world, kind, [BodyId::NULL, flipper], DVec3::ZERO, Vec3::Z);
            let ball = ShapeDef { material: shape.material, ..ShapeDef::new(Shape::ball(0.05).expect("a valid shape")) };
            let place = DVec3::new(0.8, 0.1, 0.0);
            let def = BodyDef { fast: true, ..BodyDef::dynamic(Pose::at(place)).with_shape(ball).with_mass(Mass::Total(0.1)) };
            let ball = world.create_body(&def).expect("a valid body");
            let mut fastest = 0.0_f32;
            for _ in 0..(0.3 * rate) as usize {
                world.step(1.0 / rate).expect("a valid step");
                fastest = fastest.max(world.linear_velocity(ball).expect("bodies stay").length());
                let (turn, place) = (world.pose(flipper).expect("bodies stay").rotation, at(&world, ball));
                let above = (turn.conjugate() * place.as_vec3()).y;
                assert!(above > 0.0, "{solver:?}, {rate}/s: the ball is through, {above} m above the flipper's middle");
            }
            // At 0.8 m the flipper has 8 m/s; without friction the ball slides out to its tip meanwhile, and leaves at 11.7.
            assert!(
                (8.0..=12.0).contains(&fastest),
                "{solver:?}, {rate}/s: the ball leaves at {fastest} m/s, from 8 to 12 is right"
            );
        }
    }
}

#[test]
fn a_piston_throws_a_crate_no_faster_than_itself() {
    for solver in SOLVERS {
        for rate in [30.0, 60.0, 240.0] {
            // Twenty times as light as its piston to ten times as heavy, and how much too fast two sweeps between contact and motor leave it.
            for (mass, too_fast) in [(1.0, 0.04), (10.0, 0.18), (20.0, 0.245), (200.0, 0.53)] {
                let mut world = world(GRAVITY, solver);
                let shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.5, 0.1, 0.5)).expect("a valid shape"));
                let def = BodyDef::dynamic(Pose::IDENTITY).with_shape(shape).with_mass(Mass::Total(20.0));
                let piston = world.create_body(&def).expect("a valid body");
                let motor = Motor::Velocity { target: 6.0, max_force: f32::INFINITY };
                let kind = JointKind::Prismatic { limits: Limits::new(0.0, 1.0), motor };
                join(&mut world, kind, [BodyId::NULL, piston], DVec3::ZERO, Vec3::Y);
                let shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.2)).expect("a valid shape"));
                let def = BodyDef::dynamic(Pose::at(DVec3::Y * 0.3)).with_shape(shape).with_mass(Mass::Total(mass));
                let load = world.create_body(&def).expect("a valid body");
                let mut fastest = 0.0_f32;
                for _ in 0..(0.5 * rate) as usize {
                    world.step(1.0 / rate).expect("a valid step");
                    fastest = fastest.max(world.linear_velocity(load).expect("bodies stay").y);
                }
                let what = format!("{solver:?}, {rate}/s, {mass} kg");
                let bound = if solver == Solver::Auto { 6.01 } else { 6.0 * (1.0 + too_fast) };
                assert!((5.7..=bound).contains(&fastest), "{what}: thrown at {fastest} m/s by a piston at 6, bound {bound} m/s");
            }
        }
    }
}

/// Sweeps see the platform's own mass where its load presses on it: what overlaps is taken out at the cost of the platform.
#[test]
fn a_swept_lift_with_a_hundred_times_its_mass_rises_by_most_of_what_it_is_told_to() {
    for (rate, least) in [(60.0, 5.3), (240.0, 5.8)] {
        let mut world = world(GRAVITY, Solver::GaussSeidel);
        let [platform, _] = [(0.0, Vec3::new(1.0, 0.1, 1.0), 50.0), (0.4, Vec3::splat(0.3), 5.0e3)].map(|(y, half, mass)| {
            let shape = ShapeDef::new(Shape::cuboid(half).expect("a valid shape"));
            let def = BodyDef::dynamic(Pose::at(DVec3::Y * y)).with_shape(shape).with_mass(Mass::Total(mass));
            world.create_body(&def).expect("a valid body")
        });
        let motor = Motor::Velocity { target: 1.0, max_force: f32::INFINITY };
        let kind = JointKind::Prismatic { limits: Limits::NONE, motor };
        join(&mut world, kind, [BodyId::NULL, platform], DVec3::ZERO, Vec3::Y);
        for _ in 0..(6.0 * rate) as usize {
            world.step(1.0 / rate).expect("a valid step");
        }
        let rise = world.pose(platform).expect("it stays").position.y;
        assert!((least..=6.01).contains(&rise), "{rate}/s: rises by {rise} m of 6, bound {least} m");
    }
}

#[test]
fn a_car_with_steered_hubs_drives_in_a_circle() {
    let by_rows = [30.0, 60.0, 120.0, 240.0].map(|rate| (rate, Solver::Auto));
    // Sweeps hold a hub that is so much lighter than its car from 240 steps a second on.
    for (rate, solver) in by_rows.into_iter().chain([(240.0, Solver::GaussSeidel)]) {
        let mut world = world(GRAVITY, solver);
        let floor = ShapeDef::new(Shape::cuboid(Vec3::new(50.0, 0.5, 50.0)).expect("a valid shape"));
        world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(floor)).expect("a valid body");
        let chassis = ghost(&mut world, DVec3::Y * 0.6, Vec3::new(1.2, 0.15, 0.5), 600.0);
        // Each wheel stands across its way about the middle of the circle, and rolls as fast as that is long.
        let (wheelbase, circle) = (2.0_f32, 5.5_f32);
        for (x, z) in [(1.0, 0.6), (1.0, -0.6), (-1.0, 0.6), (-1.0, -0.6)] {
            let place = DVec3::new(x, 0.35, z);
            let cylinder = Shape::new(Geometry::Cylinder { half_height: 0.05, radius: 0.35 }).expect("a valid shape");
            let mut shape = ShapeDef::new(cylinder);
            shape.material = Material { friction: 1.0, ..Material::default() };
            let pose = Pose::at(place).rotated(Quat::from_rotation_x(FRAC_PI_2));
            let def = BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(20.0));
            let wheel = world.create_body(&def).expect("a valid body");
            if x > 0.0 {
                let hub = ghost(&mut world, place, Vec3::splat(0.1), 10.0);
                let softness = Softness { compliance: 1.0e-5, damping: 500.0 };
                let target = (wheelbase / (circle + z as f32)).atan();
                let motor = Motor::Position { target, softness, max_force: 1.0e4 };
                join(&mut world, motored(motor), [chassis, hub], place, Vec3::Y);
                join(&mut world, JointKind::HINGE, [hub, wheel], place, Vec3::Z);
            } else {
                let motor = Motor::Velocity { target: -6.0 * (1.0 + z as f32 / circle), max_force: 400.0 };
                join(&mut world, motored(motor), [chassis, wheel], place, Vec3::Z);
            }
        }
        steps(&mut world, rate, 4.0);
        let (speed, turning) = (world.linear_velocity(chassis), world.angular_velocity(chassis));
        let (speed, turning) = (speed.expect("bodies stay").length(), turning.expect("bodies stay").y);
        let what = format!("{solver:?}, {rate}/s");
        assert!((1.6..2.6).contains(&speed), "{what}: drives at {speed} m/s, its wheels at 2.1");
        let expected = circle.hypot(0.5 * wheelbase);
        let radius = speed / turning;
        assert!((radius / expected - 1.0).abs() < 0.1, "{what}: a circle of {radius} m, bound 10 % from {expected} m");
        let pose = world.pose(chassis).expect("bodies stay");
        let lean = (pose.rotation * Vec3::Y).angle_between(Vec3::Y);
        assert!(lean < 0.05 * PI, "{what}: leans by {lean} rad");
    }
}
