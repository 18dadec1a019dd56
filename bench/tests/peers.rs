//! What the benchmark relies on in every peer engine, checked against closed forms.

use glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, JointDef, JointKind, Limits, LocalPose, Mass, MassProperties, Material, Pose, Shape, ShapeDef, WorldDef,
};
use longspan_bench::peers;
use longspan_scenes::{Effort, Engine, SceneJoint};

const DT: f32 = 1.0 / 60.0;
const GRAVITY: f64 = 9.81;

/// Substeps (collision steps) for what shall hold closely.
const FINE: Effort = Effort::N(32);

fn peers() -> impl Iterator<Item = &'static str> {
    let built = [
        ("rapier", cfg!(feature = "peer-rapier")),
        ("box3d", cfg!(feature = "peer-box3d")),
        ("jolt", cfg!(feature = "peer-jolt")),
    ];
    built.into_iter().filter_map(|(name, built)| built.then_some(name))
}

fn scene(name: &str, effort: Effort) -> Box<dyn Engine> {
    let mut world = WorldDef::default();
    world.sleep.enabled = false;
    peers::create(name, &world, effort, 1).expect("the peer is part of this build")
}

fn weightless(name: &str, effort: Effort) -> Box<dyn Engine> {
    let mut world = WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() };
    world.sleep.enabled = false;
    peers::create(name, &world, effort, 1).expect("the peer is part of this build")
}

fn steps(engine: &mut dyn Engine, count: usize) {
    for _ in 0..count {
        engine.step(DT);
    }
}

fn ball(radius: f32) -> ShapeDef {
    ShapeDef::new(Shape::ball(radius).unwrap())
}

fn cuboid(x: f32, y: f32, z: f32) -> ShapeDef {
    ShapeDef::new(Shape::cuboid(Vec3::new(x, y, z)).unwrap())
}

fn dynamic_at(x: f64, y: f64, z: f64, shape: ShapeDef) -> BodyDef {
    BodyDef::dynamic(Pose::at_xyz(x, y, z)).with_shape(shape)
}

fn joint(kind: JointKind, a: Option<usize>, b: Option<usize>) -> SceneJoint {
    SceneJoint { a, b, def: JointDef::new(kind, Default::default(), Default::default()) }
}

fn gap(engine: &dyn Engine, joint: &SceneJoint) -> f64 {
    let end = |body: Option<usize>, frame: &Pose| body.map_or(*frame, |body| engine.pose(body).transform(frame)).position;
    (end(joint.a, &joint.def.frame_a) - end(joint.b, &joint.def.frame_b)).length()
}

#[test]
fn a_ball_falls_as_far_as_gravity_says() {
    for name in peers() {
        let mut engine = scene(name, Effort::Default);
        let mut def = dynamic_at(1.0, 100.0, -2.0, ball(0.5));
        def.linear_velocity = Vec3::new(3.0, 0.0, 0.0);
        let ball = engine.add_body(&def);
        steps(engine.as_mut(), 60);
        let pose = engine.pose(ball).position;
        let expected = DVec3::new(4.0, 100.0 - 0.5 * GRAVITY, -2.0);
        // First-order stepping is off by at most one step's fall at the end speed: g·t·dt/2.
        let bound = 0.5 * GRAVITY / 60.0 + 1.0e-3;
        let error = (pose - expected).length();
        assert!(error <= bound, "{name}: {error:.4} m from the parabola after 1 s, at most {bound:.4} m");
        let speed = engine.linear_velocity(ball);
        let error = (speed - Vec3::new(3.0, -9.81, 0.0)).length();
        assert!(error <= 1.0e-3, "{name}: speed {speed} m/s after 1 s is {error} m/s off");
    }
}

#[test]
fn a_box_rests_at_its_height_on_a_box_and_on_a_half_space() {
    for name in peers() {
        let mut engine = scene(name, Effort::Default);
        engine.add_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(cuboid(5.0, 1.0, 5.0)));
        let on_box = engine.add_body(&dynamic_at(0.0, 0.5, 0.0, cuboid(0.5, 0.5, 0.5)));
        let plane = ShapeDef::new(Shape::new(longspan::Geometry::HalfSpace { normal: Vec3::Y }).unwrap());
        engine.add_body(&BodyDef::fixed(Pose::at_xyz(0.0, -2.0, 0.0)).with_shape(plane));
        let on_plane = engine.add_body(&dynamic_at(20.0, -1.5, 0.0, cuboid(0.5, 0.5, 0.5)));
        steps(engine.as_mut(), 120);
        for (body, height) in [(on_box, 0.5), (on_plane, -1.5)] {
            // The greatest slop among the engines' defaults is Jolt's 2 cm.
            let error = engine.pose(body).position.y - height;
            assert!(error.abs() <= 0.021, "{name}: rests {error:.4} m from its height, at most 0.021 m");
            let speed = engine.linear_velocity(body).length();
            assert!(speed <= 0.05, "{name}: still moves at {speed} m/s after 2 s, at most 0.05 m/s");
        }
    }
}

#[test]
fn a_pendulum_keeps_its_joint_and_its_period() {
    for name in peers() {
        for on_scene_body in [true, false] {
            let mut engine = scene(name, FINE);
            let anchor = on_scene_body
                .then(|| engine.add_body(&BodyDef::fixed(Pose::at_xyz(0.0, 2.1, 0.0)).with_shape(cuboid(0.1, 0.1, 0.1))));
            let mass = Mass::Total(1.0);
            let link = ShapeDef::new(Shape::capsule(0.08, 0.02).unwrap());
            let sideways = Quat::from_rotation_z(0.5 * std::f32::consts::PI);
            let def = BodyDef::dynamic(Pose::at_xyz(0.1, 2.0, 0.0).rotated(sideways)).with_shape(link.clone()).with_mass(mass);
            let link = engine.add_body(&def);
            let mut hang = joint(JointKind::SPHERICAL, anchor, Some(link));
            let on_a = if on_scene_body { Vec3::new(0.0, -0.1, 0.0) } else { Vec3::new(0.0, 2.0, 0.0) };
            hang.def = hang.def.at(on_a, Vec3::new(0.0, 0.1, 0.0));
            engine.add_joint(&hang);
            let mut worst = 0.0_f64;
            let mut lowest = (0, f64::INFINITY);
            for step in 1..=60 {
                engine.step(DT);
                worst = worst.max(gap(engine.as_ref(), &hang));
                let x = engine.pose(link).position.x.abs();
                if step <= 20 && x < lowest.1 {
                    lowest = (step, x);
                }
            }
            assert!(worst <= 1.0e-3, "{name}: joint gap {:.3} mm within 1 s, at most 1 mm", 1000.0 * worst);
            // A pendulum from the horizontal passes its lowest point after K(sin 45°)·√(I/(m·g·l)), K = 1.85407.
            let shape = Shape::capsule(0.08, 0.02).unwrap().mass_properties(1000.0).unwrap();
            let about_joint = shape.principal_inertia.x / shape.mass + 0.01;
            let expected = 1.85407 * (f64::from(about_joint) / (GRAVITY * 0.1)).sqrt();
            let measured = f64::from(lowest.0) / 60.0;
            assert!((measured - expected).abs() <= 1.0 / 60.0, "{name}: lowest after {measured:.4} s, expected {expected:.4} s");
        }
    }
}

#[test]
fn a_weight_on_a_joint_reads_as_its_weight() {
    for name in peers() {
        let distance = JointKind::Distance { limits: Limits::new(0.0, 1.0), spring_length: None, motor: Default::default() };
        for (kind, below) in [(JointKind::Fixed, 0.0), (JointKind::HINGE, 0.0), (JointKind::SPHERICAL, 0.0), (distance, 1.0)] {
            let mut engine = scene(name, FINE);
            let weight = dynamic_at(0.0, -0.3 - below, 0.0, cuboid(0.2, 0.3, 0.2)).with_mass(Mass::Total(50.0));
            let weight = engine.add_body(&weight);
            let mut hang = joint(kind, None, Some(weight));
            hang.def = hang.def.at(Vec3::ZERO, Vec3::new(0.0, 0.3, 0.0));
            let hang = engine.add_joint(&hang);
            steps(engine.as_mut(), 120);
            let force = engine.joint_force(hang).expect("these kinds are reported by every peer");
            let expected = Vec3::new(0.0, 50.0 * 9.81, 0.0);
            let error = (force - expected).length();
            assert!(error <= 0.02 * expected.y, "{name}: {kind:?} carries {force} N, expected {expected} N ± 2 %");
        }
    }
}

#[test]
fn joints_turn_and_slide_about_their_own_axis_only() {
    for name in peers() {
        // Frames turned so that the joint axis, x of the frame, is z of the world.
        let to_z = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
        for (kind, slides) in [(JointKind::HINGE, false), (JointKind::PRISMATIC, true)] {
            let mut engine = weightless(name, FINE);
            let mut def = dynamic_at(0.0, 0.0, 0.0, cuboid(0.2, 0.3, 0.4));
            def.linear_velocity = Vec3::new(0.3, 0.2, 1.0);
            def.angular_velocity = Vec3::new(0.5, 0.4, 1.0);
            let body = engine.add_body(&def);
            let mut held = joint(kind, None, Some(body));
            held.def.frame_a.rotation = to_z;
            held.def.frame_b.rotation = to_z;
            engine.add_joint(&held);
            steps(engine.as_mut(), 30);
            let pose = engine.pose(body);
            let turn = pose.rotation.to_scaled_axis();
            let (free, held) = if slides {
                (pose.position.z, pose.position.truncate().length() + f64::from(turn.length()))
            } else {
                (f64::from(turn.z), pose.position.length() + f64::from(turn.truncate().length()))
            };
            assert!((free - 0.5).abs() <= 0.01, "{name}: {kind:?} moved {free:.4} m or rad in 0.5 s, expected 0.5");
            assert!(held <= 2.0e-3, "{name}: {kind:?} gave {held:.5} m or rad across its axis, at most 0.002");
        }
    }
}

#[test]
fn limits_stop_what_they_limit() {
    let quarter = Limits::new(-0.25, 0.25);
    let kinds = [
        JointKind::Hinge { limits: quarter, motor: Default::default() },
        JointKind::Prismatic { limits: quarter, motor: Default::default() },
        JointKind::Distance { limits: Limits::new(f32::NEG_INFINITY, 0.25), spring_length: None, motor: Default::default() },
    ];
    for name in peers() {
        for kind in kinds {
            let mut engine = weightless(name, FINE);
            let mut def = dynamic_at(0.0, 0.0, 0.0, cuboid(0.2, 0.3, 0.4));
            (def.linear_velocity, def.angular_velocity) = (Vec3::X, Vec3::X);
            let body = engine.add_body(&def);
            engine.add_joint(&joint(kind, None, Some(body)));
            steps(engine.as_mut(), 60);
            let pose = engine.pose(body);
            let reached = match kind {
                JointKind::Hinge { .. } => f64::from(pose.rotation.to_scaled_axis().x),
                _ => pose.position.x,
            };
            assert!(reached.abs() <= 0.26, "{name}: {kind:?} let {reached:.4} m or rad pass, limit 0.25");
        }
    }
}

#[test]
fn masses_arrive_whatever_they_are_made_from() {
    // The engines read back what they solve with in the first step, and panic if that is not what they were handed.
    let tilted = MassProperties {
        mass: 3.0,
        center_of_mass: Vec3::new(0.1, -0.05, 0.02),
        principal_inertia: Vec3::new(0.1, 0.2, 0.25),
        inertia_frame: Quat::from_rotation_y(0.7),
    };
    let mut shifted = cuboid(0.1, 0.2, 0.3);
    shifted.local_pose = LocalPose { position: Vec3::new(0.3, 0.1, 0.0), rotation: Quat::from_rotation_x(0.4) };
    let light = MassProperties::new(1.0e-3, Vec3::splat(4.0e-6));
    for name in peers() {
        let mut engine = weightless(name, Effort::Default);
        let mut spin = |def: BodyDef, x: f64| {
            let mut def = def;
            def.pose = Pose::at_xyz(x, 0.0, 0.0).rotated(Quat::from_rotation_z(0.3));
            def.linear_velocity = Vec3::Z;
            engine.add_body(&def)
        };
        let bodies = [
            spin(BodyDef::default().with_shape(cuboid(0.1, 0.2, 0.3)), 0.0),
            spin(BodyDef::default().with_shape(shifted.clone()), 5.0),
            spin(BodyDef::default().with_shape(shifted.clone()).with_shape(ball(0.2)).with_mass(Mass::Total(7.0)), 10.0),
            spin(BodyDef::default().with_shape(cuboid(0.1, 0.2, 0.3)).with_mass(Mass::Properties(tilted)), 15.0),
            spin(BodyDef::default().with_shape(ball(0.02)).with_mass(Mass::Properties(light)), 20.0),
        ];
        engine.step(DT);
        for body in bodies {
            let speed = engine.linear_velocity(body);
            assert!((speed - Vec3::Z).length() <= 1.0e-5, "{name}: a free body's centre of mass moves at {speed} m/s, not z");
        }
        // An impulse on the centre of mass changes its velocity by impulse over mass, and turns nothing.
        engine.apply_impulse(bodies[3], Vec3::new(6.0, 0.0, 0.0));
        let (speed, turn) = (engine.linear_velocity(bodies[3]), engine.angular_velocity(bodies[3]));
        assert!((speed - Vec3::new(2.0, 0.0, 1.0)).length() <= 1.0e-4, "{name}: {speed} m/s after 6 N·s on 3 kg");
        assert!(turn.length() <= 1.0e-6, "{name}: {turn} rad/s after an impulse at the centre of mass");
    }
}

#[test]
fn jointed_neighbours_collide_only_if_asked_to() {
    for name in peers() {
        for collide in [false, true] {
            let mut engine = weightless(name, Effort::Default);
            let a = engine.add_body(&dynamic_at(0.0, 0.0, 0.0, cuboid(0.2, 0.2, 0.2)));
            let b = engine.add_body(&dynamic_at(0.3, 0.0, 0.0, cuboid(0.2, 0.2, 0.2)));
            // Apart from contact this joint lets them be where they are.
            let mut slack = joint(
                JointKind::Distance { limits: Limits::new(0.0, 5.0), spring_length: None, motor: Default::default() },
                Some(a),
                Some(b),
            );
            slack.def.collide_connected = collide;
            engine.add_joint(&slack);
            let stranger = engine.add_body(&dynamic_at(10.0, 0.0, 0.0, cuboid(0.2, 0.2, 0.2)));
            let overlapping = engine.add_body(&dynamic_at(10.3, 0.0, 0.0, cuboid(0.2, 0.2, 0.2)));
            steps(engine.as_mut(), 60);
            let apart = |a, b| (engine.pose(a).position - engine.pose(b).position).length();
            let jointed = apart(a, b);
            assert_eq!(jointed > 0.35, collide, "{name}: jointed bodies are {jointed:.4} m apart, collide_connected {collide}");
            let free = apart(stranger, overlapping);
            assert!(free > 0.35, "{name}: bodies without a joint stayed in each other, {free:.4} m apart");
        }
    }
}

#[test]
fn friction_is_the_geometric_mean_of_both_surfaces() {
    let with_friction = |mut shape: ShapeDef, friction: f32| {
        shape.material = Material { friction, ..Material::default() };
        shape
    };
    for name in peers() {
        let mut engine = scene(name, Effort::Default);
        let floor = with_friction(cuboid(50.0, 1.0, 50.0), 0.9);
        engine.add_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(floor));
        let slider = with_friction(cuboid(0.5, 0.1, 0.5), 0.1);
        let body = engine.add_body(&dynamic_at(0.0, 0.1, 0.0, slider));
        steps(engine.as_mut(), 30);
        let start = engine.pose(body).position.x;
        engine.set_linear_velocity(body, Vec3::new(3.0, 0.0, 0.0));
        steps(engine.as_mut(), 120);
        // √(0.9·0.1) = 0.3; v²/(2·μ·g).
        let expected = 9.0 / (2.0 * 0.3 * GRAVITY);
        let slid = engine.pose(body).position.x - start;
        assert!((slid - expected).abs() <= 0.05 * expected, "{name}: slid {slid:.4} m, expected {expected:.4} m ± 5 %");
    }
}

#[test]
fn every_supported_shape_rests_on_the_floor() {
    let hull = Shape::new(longspan::Geometry::ConvexHull {
        points: (0..8).map(|i| Vec3::new((i & 1) as f32 - 0.5, (i >> 1 & 1) as f32 - 0.5, (i >> 2 & 1) as f32 - 0.5)).collect(),
    });
    let cylinder = Shape::new(longspan::Geometry::Cylinder { half_height: 0.5, radius: 0.4 });
    let shapes = [Shape::ball(0.5), Shape::cuboid(Vec3::splat(0.5)), Shape::capsule(0.25, 0.25), cylinder, hull];
    for name in peers() {
        let mut engine = scene(name, Effort::Default);
        engine.add_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(cuboid(20.0, 1.0, 5.0)));
        let mut x = -9.0;
        let bodies = shapes.each_ref().map(|shape| {
            x += 3.0;
            engine.add_body(&dynamic_at(x, 0.5, 0.0, ShapeDef::new(shape.clone().unwrap())))
        });
        steps(engine.as_mut(), 60);
        for (body, shape) in bodies.into_iter().zip(&shapes) {
            let y = engine.pose(body).position.y;
            assert!((y - 0.5).abs() <= 0.021, "{name}: {shape:?} rests at {y:.4} m, expected 0.5 ± 0.021 m");
        }
        // Below all of them nothing is left once the floor is gone.
        engine.remove_body(0);
        steps(engine.as_mut(), 30);
        for body in bodies {
            let y = engine.pose(body).position.y;
            assert!(y < 0.0, "{name}: body {body} hangs in the air at {y:.4} m after its floor was removed");
        }
    }
}

#[test]
fn a_body_at_rest_sleeps_only_if_the_world_allows_it() {
    for name in peers() {
        for enabled in [true, false] {
            let mut world = WorldDef::default();
            world.sleep.enabled = enabled;
            let mut engine = peers::create(name, &world, Effort::Default, 1).expect("the peer is part of this build");
            engine.add_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(cuboid(5.0, 1.0, 5.0)));
            let body = engine.add_body(&dynamic_at(0.0, 0.5, 0.0, cuboid(0.5, 0.5, 0.5)));
            steps(engine.as_mut(), 240);
            assert_eq!(engine.is_awake(body), !enabled, "{name}: awake after 4 s at rest, sleep enabled: {enabled}");
        }
    }
}

#[test]
fn the_number_of_threads_changes_nothing_but_the_time() {
    for name in peers().filter(|name| *name != "rapier") {
        let run = |threads| {
            let mut engine = peers::create(name, &WorldDef::default(), Effort::Default, threads).expect("the peer is built");
            engine.add_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(cuboid(20.0, 1.0, 20.0)));
            let at = |i: i32| f64::from(i) * 0.61;
            let bodies: Vec<usize> = (0..64)
                .map(|i| {
                    let lean = 0.05 * f64::from(i / 16);
                    engine.add_body(&dynamic_at(at(i % 4) + lean, 0.5 + at(i / 16), at(i / 4 % 4), cuboid(0.3, 0.3, 0.3)))
                })
                .collect();
            steps(engine.as_mut(), 90);
            bodies.into_iter().map(|body| engine.pose(body)).collect::<Vec<_>>()
        };
        assert_eq!(run(1), run(2), "{name}: two threads end elsewhere than one");
    }
}

#[test]
fn gravity_can_be_turned_and_wakes_who_sleeps() {
    for name in peers() {
        let mut engine = peers::create(name, &WorldDef::default(), Effort::Default, 1).expect("the peer is part of this build");
        engine.add_body(&BodyDef::fixed(Pose::at_xyz(0.0, -1.0, 0.0)).with_shape(cuboid(5.0, 1.0, 5.0)));
        let body = engine.add_body(&dynamic_at(0.0, 0.5, 0.0, cuboid(0.5, 0.5, 0.5)));
        steps(engine.as_mut(), 240);
        assert!(!engine.is_awake(body), "{name}: awake after 4 s at rest");
        assert!(engine.set_gravity(Vec3::new(0.0, 1.0, 0.0)), "{name} cannot turn gravity");
        steps(engine.as_mut(), 60);
        let risen = engine.pose(body).position.y - 0.5;
        assert!((0.4..0.6).contains(&risen), "{name}: rose {risen:.4} m in 1 s, expected 0.5 m");
    }
}

#[test]
fn a_great_effort_is_borne() {
    for name in peers() {
        let mut engine = scene(name, Effort::N(1275));
        let ball = engine.add_body(&dynamic_at(0.0, 0.0, 0.0, ball(0.5)));
        steps(engine.as_mut(), 6);
        let (fallen, expected) = (-engine.pose(ball).position.y, 0.5 * GRAVITY * 0.01);
        assert!((fallen - expected).abs() <= 1.0e-3 * expected, "{name}: fell {fallen:.6} m in 0.1 s, expected {expected:.6} m");
    }
}

#[test]
fn what_an_engine_lacks_is_refused_by_name() {
    for name in peers() {
        let refused = std::panic::catch_unwind(|| {
            let mut engine = scene(name, Effort::Default);
            let body = engine.add_body(&dynamic_at(0.0, 0.0, 0.0, ball(0.5)));
            let mut soft = joint(JointKind::SPHERICAL, None, Some(body));
            soft.def.linear.compliance = 1.0e-3;
            engine.add_joint(&soft);
        });
        let panic = refused.expect_err("a soft joint means something else in every engine");
        let message = panic.downcast_ref::<String>().expect("the message is formatted");
        assert_eq!(*message, format!("not supported by {name}: a joint with compliance"));
    }
}

#[test]
fn a_speed_motor_turns_a_hinge_at_its_speed_with_no_more_than_its_torque() {
    for name in peers() {
        for (torque, expected) in [(f32::INFINITY, 1.0), (0.25, 0.5)] {
            let mut engine = weightless(name, Effort::Default);
            let inertia = MassProperties {
                mass: 1.0,
                center_of_mass: Vec3::ZERO,
                principal_inertia: Vec3::splat(0.5),
                inertia_frame: Quat::IDENTITY,
            };
            let wheel = dynamic_at(0.0, 0.0, 0.0, ball(0.2)).with_mass(Mass::Properties(inertia));
            let wheel = engine.add_body(&wheel);
            let motor = longspan::Motor::Velocity { target: 1.0, max_force: torque };
            engine.add_joint(&joint(JointKind::Hinge { limits: Limits::NONE, motor }, None, Some(wheel)));
            // 0.25 N·m on 0.5 kg·m² give half a radian per second in a second.
            steps(engine.as_mut(), 60);
            let spin = f64::from(engine.angular_velocity(wheel).x);
            assert!((spin - expected).abs() <= 0.01, "{name}: {spin:.4} rad/s after 1 s at {torque} N·m, expected {expected}");
        }
    }
}

#[test]
fn a_swing_limit_is_a_cone_about_the_joint_axis() {
    for name in peers() {
        for swing_limit in [0.3, 1.0] {
            let mut engine = scene(name, FINE);
            let rod = engine.add_body(&dynamic_at(0.5, 0.0, 0.0, cuboid(0.5, 0.05, 0.05)));
            let kind = JointKind::Spherical { swing_limit, twist_limits: Limits::NONE, motor: Default::default() };
            let mut ball = joint(kind, None, Some(rod));
            ball.def.frame_b = Pose::at_xyz(-0.5, 0.0, 0.0);
            engine.add_joint(&ball);
            steps(engine.as_mut(), 600);
            let sunk = (-engine.pose(rod).rotation.mul_vec3(Vec3::X).y).asin();
            assert!((sunk - swing_limit).abs() <= 0.02, "{name}: rests {sunk:.4} rad below the level, limit {swing_limit} rad");
        }
    }
}
