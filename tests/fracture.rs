//! Joints break at the loads that they were given, in the step that overloads them, and nothing is lost when they do.

use crate::common::{Run, scene};
use longspan::glam::{DVec3, Vec3, Vec3Swizzles};
use longspan::{
    BodyDef, BodyId, BreakCause, BreakLimit, Damage, FractureSettings, JointDef, JointId, JointKind, Pose, Shape, ShapeDef,
    Strength, World, WorldDef,
};
use longspan_scenes::Scene;

const DT: f32 = 1.0 / 60.0;

fn world(def: WorldDef) -> World {
    World::new(&def).unwrap()
}

fn weightless() -> WorldDef {
    WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }
}

/// A cube of 0.2 m and 8 kg.
fn cube(world: &mut World, position: DVec3) -> BodyId {
    let shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.1)).unwrap());
    world.create_body(&BodyDef::dynamic(Pose::at(position)).with_shape(shape)).unwrap()
}

/// A cube held by the world at its centre, the joint's axis along x.
fn held_cube(world: &mut World, strength: Strength) -> (BodyId, JointId) {
    let body = cube(world, DVec3::ZERO);
    let def = JointDef { strength, ..JointDef::new(JointKind::Fixed, BodyId::NULL, body) };
    let joint = world.create_joint(&def).unwrap();
    (body, joint)
}

/// A scene in a world of its own, its joints' handles in order.
fn populate(scene: &Scene, def: WorldDef) -> (World, Vec<BodyId>, Vec<JointId>) {
    let mut world = world(def);
    let bodies: Vec<BodyId> = scene.bodies.iter().map(|def| world.create_body(def).unwrap()).collect();
    let joints = scene.joints.iter().map(|joint| {
        let id_of = |side: Option<usize>| side.map_or(BodyId::NULL, |body| bodies[body]);
        world.create_joint(&JointDef { body_a: id_of(joint.a), body_b: id_of(joint.b), ..joint.def }).unwrap()
    });
    let joints = joints.collect();
    (world, bodies, joints)
}

const BREAKING_VASE: &[(&str, &str)] = &[("break", "2000000")];

/// So weak that hardly a weld is left.
const SHATTERING_VASE: &[(&str, &str)] = &[("break", "1000000")];

fn shattering_vase() -> Scene {
    scene("vase", SHATTERING_VASE)
}

#[test]
fn a_cantilever_breaks_first_at_its_root_at_the_load_of_statics() {
    for keys in [&[("n", "10")][..], &[("n", "40"), ("bending", "5000")], &[("solver", "gs"), ("n", "5"), ("bending", "100")]] {
        let run = Run::of("breaking_beam", keys);
        println!("{keys:?}: {:.3} % off", run.error("break_load_err_pct"));
        run.keeps("break_load_err_pct", 3.0, "%");
        run.is("first_broken", 0.0);
    }
}

#[test]
fn a_blow_breaks_at_its_impulse_over_the_window_at_any_step() {
    for rate in [30_u32, 60, 120, 240, 480] {
        for (impulse, breaks) in [(9.9, false), (10.1, true)] {
            let mut world = world(weightless());
            let strength = Strength { shear: 100.0, window: 0.1, ..Strength::UNBREAKABLE };
            let (body, _) = held_cube(&mut world, strength);
            world.add_impulse(body, Vec3::Y * impulse).unwrap();
            for _ in 0..rate {
                world.step(1.0 / rate as f32).unwrap();
            }
            assert_eq!(world.joint_count() == 0, breaks, "{impulse} N·s within 0.1 s against 100 N, {rate} steps a second");
        }
    }
}

#[test]
fn each_limit_is_told_apart() {
    let strength =
        Strength { tension: 100.0, compression: 200.0, shear: 300.0, bending: 40.0, torsion: 50.0, window: DT, damage: None };
    let cases = [
        (Vec3::X * 101.0, Vec3::ZERO, Vec3::X * 99.0, Vec3::ZERO, BreakLimit::Tension),
        (Vec3::X * -202.0, Vec3::ZERO, Vec3::X * -198.0, Vec3::ZERO, BreakLimit::Compression),
        (Vec3::Z * 303.0, Vec3::ZERO, Vec3::Z * 297.0, Vec3::ZERO, BreakLimit::Shear),
        (Vec3::ZERO, Vec3::Y * 40.4, Vec3::ZERO, Vec3::Y * 39.6, BreakLimit::Bending),
        (Vec3::ZERO, Vec3::X * -50.5, Vec3::ZERO, Vec3::X * -49.5, BreakLimit::Torsion),
    ];
    for (force, torque, borne_force, borne_torque, limit) in cases {
        let mut world = world(weightless());
        let (body, joint) = held_cube(&mut world, strength);
        for _ in 0..10 {
            world.add_force(body, borne_force).unwrap();
            world.add_torque(body, borne_torque).unwrap();
            world.step(DT).unwrap();
        }
        let stress = world.joint_stress(joint).unwrap();
        assert!((stress.share - 0.99).abs() < 1e-3 && stress.limit == limit, "{limit:?}: {stress:?}");
        let mut share = [0.0];
        world.joint_shares_into(&[joint], &mut share).unwrap();
        assert_eq!((share[0], world.joints_near_breaking(0.98).unwrap()), (stress.share, vec![(joint, stress.share)]));
        world.add_force(body, force).unwrap();
        world.add_torque(body, torque).unwrap();
        world.step(DT).unwrap();
        let [broken] = world.broken() else { panic!("{limit:?}: {} joints broke", world.broken().len()) };
        assert_eq!((broken.joint, broken.limit, broken.cause, broken.step), (joint, limit, BreakCause::Load, 11));
        assert!(
            (broken.force + force).length() <= 0.01 * force.length()
                && (broken.torque + torque).length() <= 0.01 * torque.length(),
            "{broken:?}"
        );
        // It bore the step up to its limit: a hundredth of its load has moved it.
        let speed = world.linear_velocity(body).unwrap().length();
        assert!(speed <= 0.011 * force.length() * DT / 8.0, "{limit:?}: leaves at {speed} m/s");
    }
}

#[test]
fn the_same_joints_of_a_vase_break_at_any_number_of_iterations() {
    let all = scene("vase", BREAKING_VASE).joints.len();
    let broken_at = |iterations: &str| {
        let run = Run::of("vase", &[BREAKING_VASE, &[("iterations", iterations)]].concat());
        (0..all).filter(|&joint| run.world().joint_def(run.engine.joint_id(joint)).is_err()).collect::<Vec<usize>>()
    };
    let reference = broken_at("50");
    assert!(reference.len() >= 5, "{} of {all} joints break", reference.len());
    for iterations in ["5", "10"] {
        let broken = broken_at(iterations);
        let differ = (0..all).filter(|joint| broken.contains(joint) != reference.contains(joint)).count();
        println!("{iterations} and 50 iterations: {} and {} joints, {differ} of {all} differ", broken.len(), reference.len());
        assert!(differ * 10 <= all, "{iterations} and 50 iterations: {differ} of {all} joints differ, bound a tenth");
    }
}

#[test]
fn the_first_blow_breaks_the_same_joints_of_a_weak_vase_at_any_number_of_iterations() {
    let broken_at = |iterations: u32| {
        let scene = shattering_vase();
        let (mut world, _, joints) = populate(&scene, WorldDef { iterations, ..scene.world });
        while world.broken().is_empty() {
            world.step(DT).unwrap();
        }
        let broken: Vec<JointId> = world.broken().iter().map(|broken| broken.joint).collect();
        joints.iter().map(|joint| broken.contains(joint)).collect::<Vec<bool>>()
    };
    let reference = broken_at(50);
    let count = reference.iter().filter(|&&broken| broken).count();
    for iterations in [5, 10] {
        let differ = broken_at(iterations).iter().zip(&reference).filter(|(one, other)| one != other).count();
        println!("{iterations} and 50 iterations: {differ} differ, {count} break at 50");
        assert!(differ * 10 <= count, "{iterations} and 50 iterations: {differ} joints differ, {count} break at 50");
    }
}

#[test]
fn a_vase_breaks_with_the_same_bits_on_any_number_of_threads() {
    let on = |threads| Run::on_threads(shattering_vase(), threads).world().state_hash();
    assert_eq!(on(2), on(1), "state hashes on two threads and on one");
}

/// Momentum and angular momentum about the origin of all bodies.
fn momenta(world: &World, bodies: &[BodyId]) -> (DVec3, DVec3) {
    let mut total = (DVec3::ZERO, DVec3::ZERO);
    for &body in bodies {
        let Some(mass) = world.mass_properties(body).unwrap() else { continue };
        let momentum = world.linear_velocity(body).unwrap().as_dvec3() * f64::from(mass.mass);
        let axes = (world.pose(body).unwrap().rotation.as_dquat().normalize() * mass.inertia_frame.as_dquat()).normalize();
        let spin = axes.conjugate() * world.angular_velocity(body).unwrap().as_dvec3();
        total.0 += momentum;
        total.1 += world.center_of_mass(body).unwrap().cross(momentum) + axes * (mass.principal_inertia.as_dvec3() * spin);
    }
    total
}

/// Greatest change of momentum, and of angular momentum, in a step with a split, each over the first of these scales (kg·m/s and
/// kg·m²/s), and the number of splits.
fn change_at_splits(world: &mut World, bodies: &[BodyId], scales: (f64, f64)) -> (f64, f64, usize) {
    let mut before = momenta(world, bodies);
    let mut worst = (0.0_f64, 0.0_f64, 0);
    for _ in 0..120 {
        world.step(DT).unwrap();
        let now = momenta(world, bodies);
        if !world.splits().is_empty() {
            worst.0 = worst.0.max(now.0.distance(before.0) / scales.0);
            worst.1 = worst.1.max(now.1.distance(before.1) / scales.1);
            worst.2 += world.splits().len();
        }
        before = now;
    }
    println!("{} splits: momentum changes by {:.2e}, angular momentum by {:.2e}", worst.2, worst.0, worst.1);
    worst
}

#[test]
fn a_vase_that_spins_apart_keeps_its_momentum() {
    // The hoops of the vase bear m ω² r per piece at 15 rad/s: 300 N, where the welds bear 160 N. Nothing touches: contacts have
    // errors of their own.
    let mut scene = scene("vase", &[("break", "20000"), ("fast", "off")]);
    scene.bodies.remove(0);
    for joint in &mut scene.joints {
        (joint.a, joint.b) = (joint.a.map(|body| body - 1), joint.b.map(|body| body - 1));
    }
    let center = scene.bodies.iter().map(|body| body.pose.position).sum::<DVec3>() / scene.bodies.len() as f64;
    let axis = scene.bodies[0].pose.rotation * Vec3::Y;
    for body in &mut scene.bodies {
        let lever = (body.pose.position - center).as_vec3();
        body.angular_velocity = axis * 15.0;
        body.linear_velocity = Vec3::new(3.0, 0.0, 0.0) + body.angular_velocity.cross(lever);
        body.pose.position -= center;
        body.shapes.iter_mut().for_each(|shape| shape.filter.collides_with = 0);
    }
    let (mut world, bodies, _) = populate(&scene, WorldDef { gravity: Vec3::ZERO, ..scene.world });
    let (linear, angular) = momenta(&world, &bodies);
    let (linear, angular, splits) = change_at_splits(&mut world, &bodies, (linear.length(), angular.length()));
    assert!(splits > 0, "it stays whole");
    assert!(linear <= 1e-5, "momentum changes by {linear:.2e} of itself in a step with a split, bound 1e-5");
    assert!(angular <= 1e-5, "angular momentum changes by {angular:.2e} of itself in a step with a split, bound 1e-5");
}

#[test]
fn no_momentum_is_lost_when_a_free_vase_shatters_on_a_free_ball() {
    let mut scene = scene("vase", &[("break", "1000000"), ("fast", "off")]);
    let ball = ShapeDef { density: 500.0, ..ShapeDef::new(Shape::ball(0.5).unwrap()) };
    scene.bodies[0] = BodyDef::dynamic(Pose::at_xyz(0.1, 0.9, 0.0)).with_shape(ball);
    for body in &mut scene.bodies[1..] {
        body.linear_velocity = Vec3::new(0.0, -6.0, 0.0);
    }
    let (mut world, bodies, _) = populate(&scene, WorldDef { gravity: Vec3::ZERO, ..scene.world });
    let scale = momenta(&world, &bodies).0.length();
    let (linear, angular, splits) = change_at_splits(&mut world, &bodies, (scale, scale));
    assert!(splits > 0, "the vase does not break");
    assert!(linear <= 1e-5, "momentum changes by {linear:.2e} of itself in a step with a split, bound 1e-5");
    assert!(angular <= 1e-5, "angular momentum changes by {angular:.2e} of momentum × 1 m in a step with a split, bound 1e-5");
}

#[test]
fn the_pieces_of_a_split_hold_all_that_the_union_held() {
    let (mut world, bodies, _) = populate(&shattering_vase(), shattering_vase().world);
    let mut splits = 0;
    for _ in 0..240 {
        world.step(DT).unwrap();
        for split in world.splits() {
            splits += 1;
            let pieces = &world.pieces()[split.pieces.0 as usize..split.pieces.1 as usize];
            assert!(pieces.len() > 1 && !split.anchored && pieces.iter().all(|piece| !piece.anchored && !piece.cut_loose));
            let mass: f64 = pieces.iter().map(|piece| f64::from(piece.mass)).sum();
            let momentum: DVec3 = pieces.iter().map(|piece| piece.linear_velocity.as_dvec3() * f64::from(piece.mass)).sum();
            let lost = (momentum / mass).distance(split.linear_velocity.as_dvec3());
            assert!((mass / f64::from(split.mass) - 1.0).abs() < 1e-6 && lost < 1e-5, "{lost} m/s of the union's speed lost");
            let members: usize = pieces.iter().map(|piece| (piece.bodies.1 - piece.bodies.0) as usize).sum();
            assert_eq!(members, split.body_count as usize);
            assert!(pieces.is_sorted_by_key(|piece| piece.first_body) && pieces[0].first_body == split.first_body);
        }
        let listed = world.piece_bodies().len();
        assert!(world.splits().iter().map(|split| split.body_count as usize).sum::<usize>() == listed && listed < bodies.len());
    }
    assert!(splits > 0, "the vase does not break");
}

#[test]
fn nothing_breaks_in_ten_minutes_at_four_fifths_of_its_limit() {
    let (mut rest, mut handled) = (world(WorldDef::default()), world(WorldDef::default()));
    let sleepless = longspan::SleepSettings { enabled: false, ..WorldDef::default().sleep };
    let mut hands = Vec::new();
    for world in [&mut rest, &mut handled] {
        world.set_sleep_settings(sleepless).unwrap();
        let hand = world.create_body(&BodyDef::kinematic(Pose::at_xyz(-0.1, 0.0, 0.0))).unwrap();
        let mut held = hand;
        for index in 0..4 {
            let body = cube(world, DVec3::X * (0.2 * f64::from(index) + 0.1));
            let (on_a, on_b) = (Vec3::X * 0.1, Vec3::X * -0.1);
            world.create_joint(&JointDef::new(JointKind::Fixed, held, body).at(on_a, on_b)).unwrap();
            held = body;
        }
        hands.push(hand);
    }
    for world in [&mut rest, &mut handled] {
        for _ in 0..60 {
            world.step(DT).unwrap();
        }
        // What each joint bears at rest is four fifths of what it can.
        for joint in world.joints().collect::<Vec<_>>() {
            let load = world.joint_stress(joint).unwrap().load;
            let limit = |load: f32| load.abs() / 0.8;
            let strength = Strength { shear: limit(load.force.y), bending: limit(load.torque.z), ..Strength::UNBREAKABLE };
            world.set_joint_strength(joint, strength).unwrap();
        }
    }
    let mut most = 0.0_f32;
    for step in 0..36_000 {
        rest.step(DT).unwrap();
        let phase = f64::from(step) / 60.0 * std::f64::consts::TAU * 0.2;
        handled.move_to(hands[1], Pose::at_xyz(-0.1, 0.05 * (1.0 - phase.cos()), 0.0)).unwrap();
        handled.step(DT).unwrap();
        let near = handled.joints_near_breaking(0.0).unwrap();
        most = most.max(near.first().map_or(f32::INFINITY, |&(_, share)| share));
    }
    println!("handled, a joint bears up to {:.2} % of its limit", 100.0 * most);
    assert_eq!((rest.joint_count(), handled.joint_count()), (4, 4), "joints left");
}

/// The whole vase, upright on the floor; in a hand that holds a piece of its rim if there is one to hold it.
fn upright_vase(in_hand: bool) -> (World, Option<BodyId>, Vec<JointId>) {
    let mut scene = scene("vase", &[]);
    let upright = scene.bodies[1].pose.rotation.conjugate();
    for body in &mut scene.bodies[1..] {
        body.pose.position = upright.as_dquat() * body.pose.position;
        body.pose.rotation = (upright * body.pose.rotation).normalize();
    }
    let half_height = 0.5 * 0.99 * 0.16;
    let lowest = scene.bodies[1..].iter().map(|body| body.pose.position.y).fold(f64::INFINITY, f64::min) - half_height;
    let lift = if in_hand { 1.0 } else { 0.0 };
    scene.bodies[1..].iter_mut().for_each(|body| body.pose.position.y += lift - lowest);
    let (mut world, bodies, joints) = populate(&scene, scene.world);
    let sleepless = longspan::SleepSettings { enabled: false, ..scene.world.sleep };
    world.set_sleep_settings(sleepless).unwrap();
    let rim = *bodies.last().expect("the vase has pieces");
    let hand = in_hand.then(|| {
        let hand = world.create_body(&BodyDef::kinematic(world.pose(rim).unwrap())).unwrap();
        world.create_joint(&JointDef::new(JointKind::Fixed, hand, rim)).unwrap();
        hand
    });
    (world, hand, joints)
}

/// Gives all joints the same limits, of each of which the greatest present load of its kind is four fifths: limits that differ would
/// distribute the load anew.
fn load_to_four_fifths(world: &mut World, joints: &[JointId]) {
    let loads = joints.iter().map(|&joint| {
        let load = world.joint_stress(joint).unwrap().load;
        let (force, torque) = (load.force, load.torque);
        [(-force.x).max(0.0), force.x.max(0.0), force.yz().length(), torque.yz().length(), torque.x.abs()]
    });
    let loads: Vec<[f32; 5]> = loads.collect();
    let limits: [f32; 5] = std::array::from_fn(|kind| loads.iter().map(|load| load[kind]).fold(0.0, f32::max) / 0.8);
    // Next to nothing is pulled or pressed along the axes, which are radial; limits of rounding alone would be none.
    let least = 0.01 * limits[2];
    let [tension, compression, shear, bending, torsion] = limits;
    let (tension, compression) = (tension.max(least), compression.max(least));
    let (bending, torsion) = (bending.max(0.1 * least), torsion.max(0.1 * least));
    for &joint in joints {
        world
            .set_joint_strength(joint, Strength { tension, compression, shear, bending, torsion, ..Strength::UNBREAKABLE })
            .unwrap();
    }
}

#[test]
fn a_vase_at_four_fifths_of_its_limits_lasts_ten_minutes() {
    for in_hand in [false, true] {
        let (mut world, hand, joints) = upright_vase(in_hand);
        // Limits that nothing reaches: loads are then those of whole steps from the start.
        let strong = Strength { tension: 1e9, compression: 1e9, shear: 1e9, bending: 1e9, torsion: 1e9, ..Strength::UNBREAKABLE };
        joints.iter().for_each(|&joint| world.set_joint_strength(joint, strong).unwrap());
        for _ in 0..120 {
            world.step(DT).unwrap();
        }
        load_to_four_fifths(&mut world, &joints);
        let mut most = 0.0_f32;
        let start = hand.map(|hand| world.pose(hand).unwrap());
        for step in 0..36_000 {
            if let (Some(hand), Some(start)) = (hand, start) {
                let phase = f64::from(step) / 60.0 * std::f64::consts::TAU * 0.2;
                let moved = DVec3::Y * (0.05 * (1.0 - phase.cos()));
                world.move_to(hand, Pose { position: start.position + moved, ..start }).unwrap();
            }
            world.step(DT).unwrap();
            let near = world.joints_near_breaking(0.0).unwrap();
            most = most.max(near.first().map_or(f32::INFINITY, |&(_, share)| share));
            assert!(world.broken().is_empty(), "in hand: {in_hand}; {} break after {step} steps", world.broken().len());
        }
        println!("in hand: {in_hand}; a joint bears up to {:.2} % of its limit", 100.0 * most);
    }
}

#[test]
fn what_a_server_broke_makes_its_client_the_same() {
    for most in [4096, 5] {
        let scene = shattering_vase();
        let fracture = FractureSettings { by_load: true, most };
        let (mut server, _, joints) = populate(&scene, WorldDef { fracture, ..scene.world });
        let (mut client, ..) =
            populate(&scene, WorldDef { fracture: FractureSettings { by_load: false, most: 4096 }, ..scene.world });
        let (mut alone, ..) =
            populate(&scene, WorldDef { fracture: FractureSettings { by_load: false, most: 4096 }, ..scene.world });
        let mut broken = 0;
        for step in 0..240 {
            server.step(DT).unwrap();
            let list: Vec<JointId> = server.broken().iter().map(|broken| broken.joint).collect();
            assert!(list.len() <= most as usize);
            broken += list.len();
            client.apply_fractures(&list).unwrap();
            client.step(DT).unwrap();
            alone.step(DT).unwrap();
            assert_eq!(client.state_hash(), server.state_hash(), "hashes after step {step}, {most} breaks a step");
            assert_eq!(client.splits().len(), server.splits().len());
        }
        assert!(broken > 10, "{broken} joints broke");
        assert_eq!(alone.joint_count(), joints.len(), "a client that is told nothing breaks nothing");
    }
}

#[test]
fn what_exceeds_the_budget_breaks_in_the_steps_after() {
    let mut world = world(WorldDef { fracture: FractureSettings { by_load: true, most: 3 }, ..weightless() });
    let strength = Strength { shear: 1.0, ..Strength::UNBREAKABLE };
    let held: Vec<(BodyId, JointId)> = (0..8).map(|_| held_cube(&mut world, strength)).collect();
    for &(body, _) in &held {
        world.add_force(body, Vec3::Y * 100.0).unwrap();
    }
    let mut order = Vec::new();
    for expected in [3, 3, 2, 0] {
        world.step(DT).unwrap();
        let counts = world.report().counts;
        assert_eq!((counts.joints_broken as usize, world.broken().len()), (expected, expected));
        assert_eq!(counts.joints_condemned as usize, 8 - order.len() - expected);
        order.extend(world.broken().iter().map(|broken| broken.joint));
    }
    assert_eq!(order, held.iter().map(|&(_, joint)| joint).collect::<Vec<_>>(), "by handle");
}

#[test]
fn a_piece_cut_loose_from_its_anchor_is_told() {
    let mut world = world(WorldDef::default());
    let (top, joint) = held_cube(&mut world, Strength::UNBREAKABLE);
    let below = cube(&mut world, DVec3::Y * -0.3);
    world.create_joint(&JointDef::new(JointKind::Fixed, top, below).at(Vec3::Y * -0.15, Vec3::Y * 0.15)).unwrap();
    world.step(DT).unwrap();
    world.apply_fractures(&[joint]).unwrap();
    world.step(DT).unwrap();
    let ([split], [piece]) = (world.splits(), world.pieces()) else { panic!("{:?}", world.splits()) };
    assert!(split.anchored && split.body_count == 2 && !piece.anchored && piece.cut_loose, "{split:?} {piece:?}");
    assert_eq!((world.broken()[0].cause, world.piece_bodies()), (BreakCause::Applied, &[top, below][..]));
    for _ in 0..60 {
        world.step(DT).unwrap();
    }
    assert!(world.pose(below).unwrap().position.y < -4.0, "it falls");
}

#[test]
fn a_joint_wears_out_and_says_so() {
    let mut world = world(WorldDef::default());
    let damage = Damage { from: 0.5, time: 1.0, half_life: f32::INFINITY };
    // 8 kg weigh 78.48 N: 0.8 of this limit, so that (0.8 − 0.5)/(1 − 0.5) = 0.6 of a second's wear a second.
    let strength = Strength { shear: 8.0 * 9.81 / 0.8, damage: Some(damage), ..Strength::UNBREAKABLE };
    let (_, joint) = held_cube(&mut world, strength);
    let mut steps = 0;
    while world.joint_count() == 1 && steps < 1000 {
        world.step(DT).unwrap();
        steps += 1;
    }
    assert!((steps as f32 * DT - 1.0 / 0.6).abs() < 0.05, "worn out after {} s, expected 1.667 s", steps as f32 * DT);
    assert_eq!((world.broken()[0].joint, world.broken()[0].cause), (joint, BreakCause::Damage));
}

#[test]
fn a_wall_of_bricks_lets_a_ball_through_that_it_cannot_stop() {
    let keys = [("bricks", "60"), ("mass", "1000"), ("seconds", "2")];
    let run = Run::of("brick_wall", &keys);
    let ball = run.engine.body_id(run.world().bodies().count() - 1);
    let (speed, z) = (run.world().linear_velocity(ball).unwrap().z, run.world().pose(ball).unwrap().position.z);
    println!("{} joints broken, {} pieces, ball at {z:.2} m with {speed:.2} m/s", run.error("broken"), run.error("pieces"));
    run.is("non_finite", 0.0);
    assert!(run.error("broken") > 5.0 && z > 1.0 && (1.0..15.0).contains(&speed), "ball at {z} m with {speed} m/s");
    let hard = Run::of("brick_wall", &[&keys[..], &[("stress", "1e9")]].concat());
    hard.is("broken", 0.0);
}

#[test]
fn a_wall_of_bricks_stands_until_it_is_hit() {
    let run = Run::of("brick_wall", &[("bricks", "60"), ("seconds", "0.4")]);
    run.is("broken", 0.0);
}

#[test]
fn bad_numbers_are_refused_by_name() {
    let mut world = world(WorldDef::default());
    let (_, joint) = held_cube(&mut world, Strength::UNBREAKABLE);
    let refused = |world: &mut World, strength: Strength| world.set_joint_strength(joint, strength).unwrap_err().argument;
    assert_eq!(refused(&mut world, Strength { shear: -1.0, ..Strength::UNBREAKABLE }), "strength.shear");
    assert_eq!(refused(&mut world, Strength { window: 0.0, ..Strength::UNBREAKABLE }), "strength.window");
    let damage = Some(Damage { from: 1.0, time: 1.0, half_life: 1.0 });
    assert_eq!(refused(&mut world, Strength { damage, ..Strength::UNBREAKABLE }), "strength.damage.from");
    let settings = FractureSettings { by_load: true, most: 0 };
    assert_eq!(world.set_fracture_settings(settings).unwrap_err().argument, "fracture.most");
    assert_eq!(world.apply_fractures(&[joint, JointId::NULL]).unwrap_err().argument, "joints");
    world.step(DT).unwrap();
    assert_eq!(world.joint_count(), 1, "a list that is refused breaks nothing");
    world.destroy_joint(joint).unwrap();
    world.apply_fractures(&[joint]).unwrap();
    assert_eq!(world.joint_stress(joint).unwrap_err().argument, "joint");
}
