//! What holds what up: verdicts, loads, and what would fall.

use longspan::glam::{Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, ErrorKind, JointDef, JointKind, Limits, Mass, Material, Motor, Pose, Shape, ShapeDef, SleepSettings,
    Verdict, World, WorldDef,
};

const DT: f32 = 1.0 / 60.0;

fn world() -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { support: true, sleep, ..WorldDef::default() }).unwrap()
}

fn cuboid(half: Vec3) -> ShapeDef {
    ShapeDef::new(Shape::cuboid(half).unwrap())
}

fn with_floor() -> (World, BodyId) {
    let mut world = world();
    let floor = BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(cuboid(Vec3::new(20.0, 0.5, 20.0)));
    let floor = world.create_body(&floor).unwrap();
    (world, floor)
}

/// A box of half extents 0.5 m and 100 kg, its centre at (x, y, 0).
fn add_box(world: &mut World, x: f64, y: f64) -> BodyId {
    let def = BodyDef::dynamic(Pose::at_xyz(x, y, 0.0)).with_shape(cuboid(Vec3::splat(0.5))).with_mass(Mass::Total(100.0));
    world.create_body(&def).unwrap()
}

fn run(world: &mut World, steps: u32) {
    for _ in 0..steps {
        world.step(DT).unwrap();
    }
}

fn verdict(world: &World, body: BodyId) -> Verdict {
    world.support(body).unwrap().verdict
}

#[test]
fn a_stack_is_supported_and_a_falling_box_is_not() {
    let (mut world, floor) = with_floor();
    let stack: Vec<BodyId> = (0..5).map(|level| add_box(&mut world, 0.0, 0.5 + f64::from(level))).collect();
    let falling = add_box(&mut world, 5.0, 10.0);
    run(&mut world, 20);
    for &body in &stack {
        let support = world.support(body).unwrap();
        assert_eq!(support.verdict, Verdict::Supported);
        assert!((support.margin - 0.5).abs() < 0.01, "margin {} m of a box centred on its like", support.margin);
    }
    assert_eq!(verdict(&world, falling), Verdict::NoContact);
    assert_eq!(verdict(&world, floor), Verdict::Ground);
    assert_eq!(world.supported_count().unwrap(), 5);
    assert_eq!(world.supporters(stack[2]).unwrap(), [stack[1]]);
    assert_eq!(world.supported_by(stack[2]).unwrap(), [stack[3]]);
    assert_eq!(world.path_to_ground(stack[4]).unwrap(), [stack[4], stack[3], stack[2], stack[1], stack[0], floor]);
    assert_eq!(world.support_hull(stack[0]).unwrap().len(), 4);
}

#[test]
fn the_three_cases_of_the_figure_are_judged_in_motion() {
    // Inside the hull below: the common centre of mass is over the post.
    let (mut world, _) = with_floor();
    let post = add_box(&mut world, 0.0, 0.5);
    let inside = add_box(&mut world, 0.3, 1.5);
    // Beyond: this one tips over.
    let other_post = add_box(&mut world, 5.0, 0.5);
    let outside = add_box(&mut world, 5.6, 1.5);
    world.step(DT).unwrap();
    assert_eq!((verdict(&world, post), verdict(&world, inside)), (Verdict::Supported, Verdict::Supported));
    assert_eq!((verdict(&world, other_post), verdict(&world, outside)), (Verdict::Supported, Verdict::OutsideHull));
    let margin = world.support(outside).unwrap().margin;
    assert!((margin + 0.1).abs() < 0.01, "margin {margin} m of a box 0.1 m beyond the edge");
    // On something that slides.
    world.set_linear_velocity(post, Vec3::X * 2.0).unwrap();
    world.set_linear_velocity(inside, Vec3::X * 2.0).unwrap();
    run(&mut world, 3);
    assert_eq!(verdict(&world, post), Verdict::Sliding);
    assert_eq!(verdict(&world, inside), Verdict::OnUnsupported);
}

#[test]
fn a_scale_under_a_stack_reads_its_weight() {
    let (mut world, floor) = with_floor();
    let stack: Vec<BodyId> = (0..6).map(|level| add_box(&mut world, 0.0, 0.5 + f64::from(level))).collect();
    let beside = add_box(&mut world, 4.0, 0.5);
    run(&mut world, 60);
    let weight = 100.0 * 9.81;
    for (level, &body) in stack.iter().enumerate() {
        let (load, expected) = (world.load_on(body).unwrap(), weight * (5 - level) as f32);
        assert!((load - expected).abs() <= 0.01 * weight, "{load} N on box {level}, of {expected} N");
    }
    let on_floor = world.load_on(floor).unwrap();
    assert!((on_floor - 7.0 * weight).abs() <= 0.07 * weight, "{on_floor} N on the floor, of {} N", 7.0 * weight);
    let between = world.load_between(beside, floor).unwrap();
    assert!((between - weight).abs() <= 0.01 * weight, "{between} N between a box and the floor, of {weight} N");
}

#[test]
fn what_is_asked_after_a_body_is_destroyed_names_nothing_that_is_gone() {
    for gone in 0..3 {
        let (mut world, floor) = with_floor();
        let stack: Vec<BodyId> = (0..3).map(|level| add_box(&mut world, 0.0, 0.5 + f64::from(level))).collect();
        run(&mut world, 20);
        world.destroy_body(stack[gone]).unwrap();
        for asks_after_a_new_body in [false, true] {
            if asks_after_a_new_body {
                add_box(&mut world, 5.0, 3.0);
            }
            let bodies: Vec<BodyId> = world.bodies().collect();
            for &body in &bodies {
                let load = world.load_on(body).unwrap();
                assert!((0.0..=3.0 * 9.81 * 100.0 * 1.01).contains(&load), "{load} N on a body of the stack");
                let named = [world.supporters(body), world.supported_by(body), world.path_to_ground(body)];
                for other in named.into_iter().flat_map(|named| named.unwrap()) {
                    assert!(bodies.contains(&other), "box {gone} is gone, and {other:?} is named");
                }
                assert!(world.support_hull(body).is_ok() && world.would_lose_support(&[body]).is_ok());
                for &other in &bodies {
                    assert!(world.load_between(body, other).unwrap() >= 0.0);
                }
            }
        }
        run(&mut world, 60);
        let left = world.load_on(floor).unwrap() / (9.81 * 100.0);
        assert!((left - 3.0).abs() < 0.1 || gone == 0, "the floor bears {left} boxes of three");
    }
}

#[test]
fn what_would_lose_support_does_when_the_keystone_goes() {
    let (mut world, _) = with_floor();
    let posts = [add_box(&mut world, -1.0, 0.5), add_box(&mut world, 1.0, 0.5)];
    let beam = BodyDef::dynamic(Pose::at_xyz(0.0, 1.1, 0.0)).with_shape(cuboid(Vec3::new(1.5, 0.1, 0.5)));
    let beam = world.create_body(&beam).unwrap();
    let on_top = [add_box(&mut world, -1.0, 1.7), add_box(&mut world, 1.0, 1.7)];
    let apart = add_box(&mut world, 6.0, 0.5);
    run(&mut world, 60);
    let predicted = world.would_lose_support(&[posts[1]]).unwrap();
    assert_eq!(predicted, [beam, on_top[1]]);
    assert_eq!(verdict(&world, beam), Verdict::Supported, "asking changes nothing");
    world.destroy_body(posts[1]).unwrap();
    world.step(DT).unwrap();
    let lost: Vec<BodyId> = world.support_changes().unwrap().iter().filter(|change| !change.supported).map(|c| c.body).collect();
    assert_eq!(lost, predicted);
    assert_eq!(verdict(&world, apart), Verdict::Supported);
    run(&mut world, 60);
    assert!(world.pose(beam).unwrap().position.y < 1.0, "the beam is at {} m", world.pose(beam).unwrap().position.y);
}

#[test]
fn a_rope_is_held_by_what_it_is_tied_to() {
    let (mut world, _) = with_floor();
    // A heavy frame carries a beam that reaches out; a chain of three hangs from the beam, with a box on the lowest.
    let frame = add_box(&mut world, 0.0, 0.5);
    let arm =
        BodyDef::dynamic(Pose::at_xyz(0.4, 1.1, 0.0)).with_shape(cuboid(Vec3::new(1.2, 0.1, 0.1))).with_mass(Mass::Total(20.0));
    let arm = world.create_body(&arm).unwrap();
    world.create_joint(&JointDef::new(JointKind::Fixed, frame, arm).at(Vec3::Y * 0.5, Vec3::new(-0.4, -0.1, 0.0))).unwrap();
    let mut above = arm;
    let mut links = Vec::new();
    for number in 0..3 {
        let at = Pose::at_xyz(1.5, 0.95 - 0.1 * f64::from(number), 0.0);
        let link = BodyDef::dynamic(at).with_shape(cuboid(Vec3::splat(0.04))).with_mass(Mass::Total(1.0));
        let link = world.create_body(&link).unwrap();
        let on_above = if number == 0 { Vec3::new(1.1, -0.1, 0.0) } else { Vec3::Y * -0.05 };
        world.create_joint(&JointDef::new(JointKind::SPHERICAL, above, link).at(on_above, Vec3::Y * 0.05)).unwrap();
        links.push(link);
        above = link;
    }
    let loose = add_box(&mut world, 8.0, 12.0);
    let mate = add_box(&mut world, 8.0, 14.0);
    world.create_joint(&JointDef::new(JointKind::SPHERICAL, loose, mate).at(Vec3::Y, Vec3::NEG_Y)).unwrap();
    run(&mut world, 40);
    assert!(verdict(&world, frame).is_supported(), "{:?}", verdict(&world, frame));
    for &link in &links {
        assert_eq!(verdict(&world, link), Verdict::HeldByJoints);
    }
    assert_eq!(verdict(&world, loose), Verdict::HangingLoose);
    let path = world.path_to_ground(links[2]).unwrap();
    assert_eq!(path[..4], [links[2], links[1], links[0], arm]);
    assert_eq!(world.would_lose_support(&[arm]).unwrap(), links);
}

#[test]
fn a_tilting_ground_lets_go_within_a_degree_of_the_friction_angle() {
    let mut world = world();
    let surface = Material { friction: 0.5, ..Material::default() };
    let slab = ShapeDef { material: surface, ..cuboid(Vec3::new(10.0, 0.5, 10.0)) };
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(slab)).unwrap();
    let block = ShapeDef { material: surface, ..cuboid(Vec3::new(0.5, 0.2, 0.5)) };
    let block = world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.0, 0.2, 0.0)).with_shape(block)).unwrap();
    run(&mut world, 60);
    // Turning gravity by two degrees a second is tilting the ground without moving it.
    let (mut angle, mut marked_until) = (0.0_f32, 0.0_f32);
    let started = loop {
        angle += 2.0 * DT;
        world.set_gravity(Quat::from_rotation_z(angle.to_radians()) * Vec3::NEG_Y * 9.81).unwrap();
        world.step(DT).unwrap();
        let slides = world.linear_velocity(block).unwrap().length() > 1.0e-3;
        let supported = verdict(&world, block).is_supported();
        assert!(!(slides && supported), "supported at {angle}° though it slides");
        if supported {
            marked_until = angle;
        }
        if slides {
            break angle;
        }
        assert!(angle < 40.0, "still at rest at {angle}°");
    };
    let expected = 0.5_f32.atan().to_degrees();
    assert!((started - expected).abs() < 1.0, "starts to slide at {started}°, of {expected}°");
    assert!(started - marked_until < 0.2, "the mark was gone at {marked_until}°, long before it slid at {started}°");
}

#[test]
fn nothing_is_supported_without_gravity_and_nothing_is_judged_when_off() {
    let (mut world, _) = with_floor();
    let body = add_box(&mut world, 0.0, 0.5);
    run(&mut world, 20);
    assert_eq!(world.supported_count().unwrap(), 1);
    world.set_gravity(Vec3::ZERO).unwrap();
    world.step(DT).unwrap();
    assert_eq!(verdict(&world, body), Verdict::NoGravity);
    assert_eq!(world.support_changes().unwrap().len(), 1);
    world.set_gravity(Vec3::NEG_Y * 9.81).unwrap();
    run(&mut world, 10);
    assert_eq!(verdict(&world, body), Verdict::Supported);
    world.set_support(false);
    assert_eq!(world.support(body).unwrap_err().kind, ErrorKind::NotApplicable);
    world.set_support(true);
    assert_eq!(verdict(&world, body), Verdict::Supported, "switched on, the world is judged as it is");
}

#[test]
fn gains_are_told_when_they_last_and_losses_at_once() {
    let (mut world, _) = with_floor();
    let body = add_box(&mut world, 0.0, 0.5);
    let mut gained = 0;
    for step in 1..=20 {
        world.step(DT).unwrap();
        for change in world.support_changes().unwrap() {
            assert!(change.supported && change.body == body);
            gained = step;
        }
    }
    assert_eq!(gained, 6, "the step in which the gain was told");
    world.add_impulse(body, Vec3::Y * 500.0).unwrap();
    world.step(DT).unwrap();
    let lost = world.support_changes().unwrap();
    assert!(lost.len() == 1 && !lost[0].supported, "{lost:?}");
}

#[test]
fn every_stone_of_the_gallery_is_judged_rightly() {
    let scene = longspan_scenes::build("support_gallery", &[]).unwrap();
    let mut engine = longspan_scenes::LongspanEngine::new(&scene.world, longspan_scenes::Effort::Default, 1).unwrap();
    let run = longspan_scenes::run(scene, &mut engine, longspan_scenes::Effort::Default, 1).unwrap();
    assert_eq!(run.errors, [("wrong_verdicts", 0.0)]);
}

/// Joints of all kinds that can carry what hangs half a metre below.
fn kinds_that_carry() -> [JointKind; 6] {
    let rod = JointKind::Distance { limits: Limits::new(0.5, 0.5), spring_length: None, motor: Motor::Off };
    let slider = JointKind::Prismatic { limits: Limits::new(-0.1, 0.1), motor: Motor::Off };
    let universal = JointKind::Generic { linear: [Axis::LOCKED; 3], angular: [Axis::FREE, Axis::FREE, Axis::LOCKED] };
    [JointKind::Fixed, JointKind::HINGE, JointKind::SPHERICAL, rod, slider, universal]
}

/// Small boxes half a metre apart, each hanging on the one before it by a joint, the first on `top`.
fn chain(world: &mut World, top: BodyId, kinds: &[JointKind]) -> Vec<BodyId> {
    let mut above = top;
    let hang = |(number, kind): (usize, &JointKind)| {
        let at = Pose::at_xyz(0.0, -0.5 * (number + 1) as f64, 0.0);
        let body = BodyDef::dynamic(at).with_shape(cuboid(Vec3::splat(0.05))).with_mass(Mass::Total(1.0));
        let body = world.create_body(&body).unwrap();
        let at = if matches!(kind, JointKind::Distance { .. }) { [0.0, 0.0] } else { [-0.25, 0.25] };
        world.create_joint(&JointDef::new(*kind, above, body).at(Vec3::Y * at[0], Vec3::Y * at[1])).unwrap();
        above = body;
        body
    };
    kinds.iter().enumerate().map(hang).collect()
}

#[test]
fn what_hangs_by_joints_is_carried_by_what_it_hangs_on() {
    for (first, second) in kinds_that_carry().into_iter().flat_map(|first| kinds_that_carry().map(|second| (first, second))) {
        for on_world in [false, true] {
            let mut world = world();
            let top = BodyDef::fixed(Pose::IDENTITY).with_shape(cuboid(Vec3::splat(0.05)));
            let top = if on_world { BodyId::NULL } else { world.create_body(&top).unwrap() };
            let links = chain(&mut world, top, &[first, second, JointKind::HINGE]);
            let [a, b, c] = links[..] else { panic!("three links") };
            run(&mut world, 20);
            let what = format!("{first:?}, {second:?}, on the world: {on_world}");
            let ground: Vec<BodyId> = if on_world { Vec::new() } else { vec![top] };
            for (body, above, below) in [(a, ground.clone(), vec![b]), (b, vec![a], vec![c]), (c, vec![b], Vec::new())] {
                assert_eq!(world.supporters(body).unwrap(), above, "{what}: carriers of {body:?}");
                assert_eq!(world.supported_by(body).unwrap(), below, "{what}: carried by {body:?}");
            }
            if !on_world {
                assert_eq!(world.supported_by(top).unwrap(), [a], "{what}: carried by the ground");
            }
            let way: Vec<BodyId> = [c, b, a].into_iter().chain(ground).collect();
            assert_eq!(world.path_to_ground(c).unwrap(), way, "{what}");
        }
    }
}

#[test]
fn of_a_bridge_held_at_both_ends_each_half_hangs_on_its_own() {
    let mut world = world();
    let planks: Vec<BodyId> = (0..6)
        .map(|number| {
            let at = Pose::at_xyz(f64::from(number) - 2.5, 0.0, 0.0);
            let plank = BodyDef::dynamic(at).with_shape(cuboid(Vec3::new(0.4, 0.05, 0.3))).with_mass(Mass::Total(1.0));
            world.create_body(&plank).unwrap()
        })
        .collect();
    let mut join = |a, b, on_a, on_b| world.create_joint(&JointDef::new(JointKind::SPHERICAL, a, b).at(on_a, on_b)).unwrap();
    for pair in planks.windows(2) {
        join(pair[0], pair[1], Vec3::X * 0.5, Vec3::X * -0.5);
    }
    join(BodyId::NULL, planks[0], Vec3::X * -3.0, Vec3::X * -0.5);
    join(BodyId::NULL, planks[5], Vec3::X * 3.0, Vec3::X * 0.5);
    run(&mut world, 20);
    for number in 0..3_usize {
        for (own, outer, inner) in [(number, number.wrapping_sub(1), number + 1), (5 - number, 6 - number, 4 - number)] {
            let neighbour = |place: usize, is_there: bool| if is_there { vec![planks[place]] } else { Vec::new() };
            assert_eq!(world.supporters(planks[own]).unwrap(), neighbour(outer, number > 0), "carriers of plank {own}");
            assert_eq!(world.supported_by(planks[own]).unwrap(), neighbour(inner, number < 2), "carried by plank {own}");
        }
    }
    assert_eq!(world.path_to_ground(planks[2]).unwrap(), [planks[2], planks[1], planks[0]]);
}
