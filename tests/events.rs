//! What a step tells of hits, sensors, stops and waking, and what a body's kind may become.

use longspan::glam::{Quat, Vec3};
use longspan::{
    BodyDef, BodyId, BodyKind, CollisionFilter, ErrorKind, Geometry, JointDef, JointKind, Limits, Mass, Material, Motor, Pose,
    Shape, ShapeDef, Solver, World, WorldDef,
};

const DT: f32 = 1.0 / 60.0;

fn world(hit_threshold: f32) -> World {
    let mut world = World::new(&WorldDef { hit_threshold, ..WorldDef::default() }).unwrap();
    let floor = ShapeDef::new(Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap());
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
    world
}

fn run(world: &mut World, steps: u32) {
    for _ in 0..steps {
        world.step(DT).unwrap();
    }
}

fn ball(world: &mut World, height: f64, restitution: f32) -> BodyId {
    let mut shape = ShapeDef::new(Shape::ball(0.5).unwrap());
    shape.material = Material { restitution, ..Material::default() };
    let def = BodyDef { mass: Mass::Total(2.0), ..BodyDef::dynamic(Pose::at_xyz(0.0, height, 0.0)) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

#[test]
fn a_hit_says_how_fast_and_how_hard() {
    for restitution in [0.0, 0.5, 1.0] {
        let mut world = world(1.0);
        ball(&mut world, 3.5, restitution);
        let fallen = (2.0 * 9.81 * 3.0_f32).sqrt();
        let hit = (0..60).find_map(|_| {
            world.step(DT).unwrap();
            world.hits().first().copied()
        });
        let hit = hit.expect("it falls in less than a second");
        let expected = 2.0 * fallen * (1.0 + restitution);
        println!(
            "restitution {restitution}: {:.3} m/s of {fallen:.3}, {:.3} N·s of {expected:.3}",
            hit.approach_speed, hit.impulse
        );
        assert!((hit.approach_speed - fallen).abs() < 9.81 * DT, "a step's fall is the most that it may miss");
        assert!((hit.impulse / expected - 1.0).abs() < 0.05, "{} N·s, expected {expected}", hit.impulse);
        assert!((hit.normal.y.abs() - 1.0).abs() < 1e-5 && hit.point.y.abs() < 0.05);
    }
}

#[test]
fn every_hit_has_begun_once_also_where_nothing_presses_any_more() {
    let shapes = [Shape::ball(0.5), Shape::cuboid(Vec3::splat(0.5)), Shape::capsule(0.5, 0.5)].map(Result::unwrap);
    for (shape, solver) in shapes.iter().flat_map(|shape| [(shape, Solver::Auto), (shape, Solver::GaussSeidel)]) {
        for (rate, speed) in [(30.0, 2.0), (60.0, 7.0), (60.0, 30.0), (240.0, 7.0)] {
            for (restitution, kind) in [(0.0, BodyKind::Static), (0.0, BodyKind::Dynamic), (0.4, BodyKind::Dynamic)] {
                let def = WorldDef { gravity: Vec3::ZERO, solver, hit_threshold: 0.1, ..WorldDef::default() };
                let mut world = World::new(&def).unwrap();
                let mut add = |kind: BodyKind, x: f64, speed: f32| {
                    let mut shape = ShapeDef::new(shape.clone());
                    shape.material = Material { restitution, friction: 0.0, ..Material::default() };
                    let def = BodyDef { kind, linear_velocity: Vec3::X * speed, ..BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)) };
                    world.create_body(&def.with_shape(shape)).unwrap()
                };
                add(BodyKind::Dynamic, -2.237, speed);
                add(kind, 0.0, 0.0);
                let (mut hits, mut begun, mut before_hit) = (0, 0, 0);
                for _ in 0..(4.0 * rate / speed) as u32 + 10 {
                    world.step(1.0 / rate).unwrap();
                    begun += world.contact_began().len();
                    hits += world.hits().len();
                    before_hit += if world.hits().is_empty() { 0 } else { begun };
                }
                let what = format!("{solver:?}, {rate} Hz, {speed} m/s, restitution {restitution}, {kind:?}");
                assert!(
                    hits == 1 && begun == 1 && before_hit == 1,
                    "{what}: {hits} hits, {begun} begun, {before_hit} by the hit"
                );
            }
        }
    }
}

#[test]
fn what_is_slow_or_not_asked_for_is_no_hit() {
    for threshold in [8.0, f32::INFINITY] {
        let mut world = world(threshold);
        ball(&mut world, 3.5, 0.0);
        for _ in 0..60 {
            world.step(DT).unwrap();
            assert!(world.hits().is_empty());
        }
    }
    let mut world = world(1.0);
    assert_eq!(world.set_hit_threshold(-1.0).unwrap_err().argument, "speed");
}

#[test]
fn a_sensor_sees_what_enters_and_leaves_and_pushes_nothing() {
    let fall = |with_sensor: bool| {
        let mut world = world(f32::INFINITY);
        let body = ball(&mut world, 6.0, 0.0);
        let (mut began, mut ended) = (Vec::new(), Vec::new());
        if with_sensor {
            let zone = ShapeDef::new(Shape::cuboid(Vec3::ONE).unwrap()).sensing();
            world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, 3.0, 0.0)).with_shape(zone)).unwrap();
        }
        for step in 0..90 {
            world.step(DT).unwrap();
            began.extend(world.sensor_began().iter().map(|pair| (step, pair.body_b == body)));
            ended.extend(world.sensor_ended().iter().map(|pair| (step, pair.body_b == body)));
        }
        (world.pose(body).unwrap(), began, ended)
    };
    let ((free, ..), (seen, began, ended)) = (fall(false), fall(true));
    assert_eq!(free, seen, "the fall is the same, bit for bit");
    // From 6 m its lowest point is at 4 m after 0.55 s, its highest at 2 m after 0.96 s.
    assert!(matches!(began[..], [(32..=34, true)]) && matches!(ended[..], [(56..=59, true)]), "{began:?} {ended:?}");
}

#[test]
fn a_sensor_ends_with_what_it_sees() {
    let mut world = world(f32::INFINITY);
    let body = ball(&mut world, 0.5, 0.0);
    let zone = ShapeDef::new(Shape::cuboid(Vec3::ONE).unwrap()).sensing();
    let mut def = BodyDef::dynamic(Pose::at_xyz(0.0, 1.0, 0.0));
    assert_eq!(world.create_body(&def.clone().with_shape(zone.clone())).unwrap_err().argument, "mass", "a sensor has no mass");
    def.kind = BodyKind::Kinematic;
    let zone_body = world.create_body(&def.with_shape(zone)).unwrap();
    world.step(DT).unwrap();
    assert_eq!((world.sensed().len(), world.sensor_began().len()), (2, 2), "the ball, and the floor, for it may move");
    let mut saved = Vec::new();
    world.save(&mut saved);
    world.destroy_body(body).unwrap();
    world.step(DT).unwrap();
    assert_eq!((world.sensed().len(), world.sensor_ended().len()), (1, 1));
    assert_eq!(world.sensor_ended()[0].body_b, body);
    world.restore(&saved).unwrap();
    world.step(DT).unwrap();
    assert_eq!((world.sensed().len(), world.sensor_began().len()), (2, 0), "what was overlapped then still is");
    world.destroy_body(zone_body).unwrap();
    world.step(DT).unwrap();
    assert_eq!((world.sensed().len(), world.sensor_ended().len()), (0, 2));
}

#[test]
fn a_joint_that_comes_to_its_stop_says_which_once() {
    let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
    let bar = ShapeDef::new(Shape::cuboid(Vec3::new(0.5, 0.1, 0.1)).unwrap());
    let body = world.create_body(&BodyDef::dynamic(Pose::IDENTITY).with_shape(bar)).unwrap();
    let drive =
        |target| JointKind::Hinge { limits: Limits::new(-0.4, 0.6), motor: Motor::Velocity { target, max_force: 1000.0 } };
    let mut def = JointDef::new(drive(1.0), BodyId::NULL, body);
    (def.user_word, def.frame_a.rotation, def.frame_b.rotation) = (9, Quat::IDENTITY, Quat::IDENTITY);
    let joint = world.create_joint(&def).unwrap();
    let mut stops = Vec::new();
    for step in 0..240 {
        if step == 120 {
            world.set_joint_kind(joint, drive(-1.0)).unwrap();
        }
        world.step(DT).unwrap();
        stops.extend(world.joint_stops().iter().map(|stop| (step, stop.joint == joint, stop.user_word, stop.axis, stop.upper)));
    }
    println!("{stops:?}, {:?}", world.joint_state(joint).unwrap().position);
    assert_eq!(stops.len(), 2, "{stops:?}");
    assert!(matches!(stops[0], (30..=40, true, 9, 0, true)) && matches!(stops[1], (175..=185, true, 9, 0, false)), "{stops:?}");
}

#[test]
fn a_stop_that_is_met_and_left_within_a_step_is_told_too() {
    // A flap is thrown up against its stop, and falls back at once: from a little later in the step each time.
    let bar = ShapeDef::new(Shape::cuboid(Vec3::new(0.5, 0.05, 0.2)).unwrap());
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for phase in 0..24 {
            let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).unwrap();
            let mut def = BodyDef::dynamic(Pose::at_xyz(0.5, 0.0, 0.0)).with_shape(bar.clone());
            def.angular_velocity = Vec3::Z * (2.4 + 0.02 * phase as f32);
            def.linear_velocity = def.angular_velocity.cross(Vec3::X * 0.5);
            let body = world.create_body(&def).unwrap();
            let limits = Limits::new(-1.0, 0.1);
            let along_z = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
            let mut hinge = JointDef::new(JointKind::Hinge { limits, motor: Motor::Off }, BodyId::NULL, body);
            hinge.frame_b.position.x = -0.5;
            (hinge.frame_a.rotation, hinge.frame_b.rotation) = (along_z, along_z);
            let joint = world.create_joint(&hinge).unwrap();
            let (mut stops, mut highest) = (Vec::new(), f32::NEG_INFINITY);
            for step in 0..15 {
                world.step(DT).unwrap();
                highest = highest.max(world.joint_state(joint).unwrap().position);
                stops.extend(world.joint_stops().iter().map(|stop| (step, stop.axis, stop.upper)));
            }
            assert!(matches!(stops[..], [(0..=6, 0, true)]), "{solver:?}, phase {phase}: {stops:?}, {highest} rad at most");
            let after = world.joint_state(joint).unwrap();
            assert!(after.position < 0.0 && after.velocity < 0.0, "{solver:?}, phase {phase}: it has not fallen: {after:?}");
        }
    }
}

#[test]
fn what_wakes_says_so() {
    let mut world = world(f32::INFINITY);
    let body = ball(&mut world, 0.5, 0.0);
    let slept = (0..120).find(|_| {
        world.step(DT).unwrap();
        world.moved().iter().any(|moved| moved.fell_asleep)
    });
    assert!(slept.is_some() && !world.is_awake(body).unwrap());
    world.step(DT).unwrap();
    assert!(world.moved().is_empty());
    world.add_impulse(body, Vec3::Y).unwrap();
    world.step(DT).unwrap();
    assert!(matches!(world.moved(), [moved] if moved.woke && moved.body == body), "{:?}", world.moved());
    world.step(DT).unwrap();
    assert!(matches!(world.moved(), [moved] if !moved.woke));
}

#[test]
fn what_is_welded_in_flight_says_that_it_sleeps() {
    for (pieces, solver) in [1, 3].into_iter().flat_map(|pieces| [(pieces, Solver::Auto), (pieces, Solver::GaussSeidel)]) {
        let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).unwrap();
        let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).unwrap());
        let at = |number: u32| Pose::at_xyz(f64::from(number), 10.0, 0.0);
        let bodies: Vec<BodyId> = (0..pieces)
            .map(|number| world.create_body(&BodyDef::dynamic(at(number)).with_shape(cube.clone())).unwrap())
            .collect();
        for pair in bodies.windows(2) {
            world.create_joint(&JointDef::new(JointKind::Fixed, pair[0], pair[1]).at(Vec3::X * 0.5, Vec3::X * -0.5)).unwrap();
        }
        run(&mut world, 30);
        let weld =
            JointDef { frame_a: world.pose(bodies[0]).unwrap(), ..JointDef::new(JointKind::Fixed, BodyId::NULL, bodies[0]) };
        let weld = world.create_joint(&weld).unwrap();
        assert!(bodies.iter().all(|&body| world.is_awake(body).unwrap()));
        world.step(DT).unwrap();
        let told: Vec<_> = world.moved().iter().map(|moved| (moved.body, moved.fell_asleep, moved.linear_velocity)).collect();
        assert_eq!(told, bodies.iter().map(|&body| (body, true, Vec3::ZERO)).collect::<Vec<_>>(), "{solver:?}");
        assert!(!bodies.iter().any(|&body| world.is_awake(body).unwrap()));
        assert_eq!(world.report().counts.moved, pieces);
        world.step(DT).unwrap();
        assert!(world.moved().is_empty(), "{solver:?}: told once");
        world.destroy_joint(weld).unwrap();
        world.step(DT).unwrap();
        assert_eq!(world.moved().len() as u32, pieces, "{solver:?}: it falls again");
    }
}

#[test]
fn a_body_may_become_another_kind_while_the_world_lives() {
    let mut world = world(f32::INFINITY);
    let (lower, upper) = (ball(&mut world, 0.5, 0.0), ball(&mut world, 1.5, 0.0));
    run(&mut world, 60);
    // The upper one stays where it is when the lower one is gone, as long as it is static.
    world.set_body_kind(upper, BodyKind::Static).unwrap();
    world.destroy_body(lower).unwrap();
    let height = |world: &World| world.pose(upper).unwrap().position.y;
    let before = height(&world);
    run(&mut world, 30);
    assert_eq!(height(&world), before);
    assert_eq!(world.mass_properties(upper).unwrap(), None);
    world.set_body_kind(upper, BodyKind::Dynamic).unwrap();
    assert_eq!(world.mass_properties(upper).unwrap().map(|mass| mass.mass), Some(2.0), "it has its mass back");
    run(&mut world, 90);
    assert!((height(&world) - 0.5).abs() < 1e-3, "it has fallen to {} m", height(&world));
    world.set_body_kind(upper, BodyKind::Kinematic).unwrap();
    world.set_linear_velocity(upper, Vec3::Y).unwrap();
    run(&mut world, 60);
    assert!((height(&world) - 1.5).abs() < 1e-2, "it has risen to {} m", height(&world));
}

#[test]
fn a_kind_that_a_body_cannot_have_is_refused() {
    let mut world = world(f32::INFINITY);
    let floor = world.bodies().next().unwrap();
    assert_eq!(world.set_body_kind(floor, BodyKind::Dynamic).unwrap_err().kind, ErrorKind::NotApplicable, "no solid");
    let mut saved = Vec::new();
    world.save(&mut saved);
    world.restore(&saved).unwrap();
}

/// A ball that lies on the floor, awake.
fn ball_on_the_floor() -> (World, BodyId) {
    let mut world = world(1.0);
    let ball = ball(&mut world, 0.5, 0.0);
    run(&mut world, 20);
    assert_eq!(world.contacts().count(), 1, "contacts of the ball at rest");
    (world, ball)
}

#[test]
fn contacts_that_edits_end_are_told_after_the_next_step() {
    type Edit = fn(&mut World, BodyId);
    let edits: [(&str, Edit); 3] = [
        ("a body destroyed", |world, body| world.destroy_body(body).expect("alive")),
        ("a body teleported", |world, body| world.set_pose(body, Pose::at_xyz(0.0, 5.0, 0.0)).expect("a pose")),
        ("a filter changed", |world, body| {
            let shape = world.body_shapes(body).expect("alive")[0];
            world.set_filter(shape, CollisionFilter { member_of: 1, collides_with: 0 }).expect("alive");
        }),
    ];
    for (what, edit) in edits {
        let (mut world, body) = ball_on_the_floor();
        edit(&mut world, body);
        assert!(world.contact_ended().is_empty(), "{what}: the last step's list stays as it was");
        world.step(DT).expect("a step");
        let ended: Vec<_> = world.contact_ended().iter().map(|pair| [pair.body_a, pair.body_b]).collect();
        assert!(ended.len() == 1 && ended[0].contains(&body), "{what}: contacts ended {ended:?}");
        world.step(DT).expect("a step");
        assert!(world.contact_ended().is_empty(), "{what}: told once");
    }
}

#[test]
fn a_world_asleep_moves_nothing() {
    let (mut world, _) = ball_on_the_floor();
    run(&mut world, 120);
    assert_eq!(world.awake_body_count(), 0, "bodies awake after two seconds at rest");
    let before = world.state_hash();
    for _ in 0..60 {
        let report = world.step(DT).expect("a step");
        assert_eq!((report.counts.moved, report.counts.islands, report.counts.pairs), (0, 0, 0), "moved, islands, pairs");
        assert!(world.moved().is_empty(), "bodies moved");
    }
    assert_eq!(world.state_hash(), before, "state hash of a world asleep");
}
