//! Restitution against what joints hold: a blow goes through the joints.

use std::f32::consts::PI;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    Axis, BodyDef, BodyId, Geometry, JointDef, JointId, JointKind, Limits, Mass, Material, Motor, Pose, Shape, ShapeDef,
    SleepSettings, Strength, World, WorldDef,
};

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];

fn world(gravity: f32) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, sleep, ..WorldDef::default() }).unwrap()
}

fn body(world: &mut World, mass: f32, at: DVec3, geometry: Geometry, (restitution, friction): (f32, f32)) -> BodyId {
    let mut shape = ShapeDef::new(Shape::new(geometry).unwrap());
    shape.material = Material { friction, restitution, ..Material::default() };
    world.create_body(&BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(Pose::at(at)) }.with_shape(shape)).unwrap()
}

/// Ways to hold a plate where it is.
const HOLDS: [&str; 6] =
    ["six axes", "a hinge on its stop", "a hinge at rest by its motor", "equal limits", "four balls", "a slider on its stop"];

fn hold(world: &mut World, plate: BodyId, how: &str) {
    let hinge = |limits: Limits, motor: Motor| {
        let mut def = JointDef::new(JointKind::Hinge { limits, motor }, BodyId::NULL, plate);
        def.frame_a = Pose { position: DVec3::NEG_X, rotation: Quat::from_rotation_y(-0.5 * PI) };
        def.frame_b = def.frame_a;
        def
    };
    let mut make = |def: JointDef| world.create_joint(&def).unwrap();
    match how {
        "six axes" => {
            let locked = [Axis::limited(0.0, 0.0); 3];
            make(JointDef::new(JointKind::Generic { linear: locked, angular: locked }, BodyId::NULL, plate));
        }
        "a hinge on its stop" => {
            make(hinge(Limits::new(0.0, 0.5), Motor::Off));
        }
        "a hinge at rest by its motor" => {
            make(hinge(Limits::NONE, Motor::Velocity { target: 0.0, max_force: f32::INFINITY }));
        }
        "equal limits" => {
            make(hinge(Limits::new(0.0, 0.0), Motor::Off));
        }
        "four balls" => {
            for (x, z) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let corner = Vec3::new(x, 0.0, z);
                make(JointDef::new(JointKind::SPHERICAL, BodyId::NULL, plate).at(corner, corner));
            }
        }
        _ => {
            let kind = JointKind::Prismatic { limits: Limits::new(0.0, 0.3), motor: Motor::Off };
            let mut def = JointDef::new(kind, BodyId::NULL, plate);
            (def.frame_a.rotation, def.frame_b.rotation) = (Quat::from_rotation_z(0.5 * PI), Quat::from_rotation_z(0.5 * PI));
            make(def);
        }
    }
}

/// Height that a ball's energy is good for over the plate (m).
fn apex(world: &World, ball: BodyId) -> f64 {
    let speed = f64::from(world.linear_velocity(ball).unwrap().y);
    world.pose(ball).unwrap().position.y - 0.3 + speed * speed / (2.0 * 9.81)
}

#[test]
fn a_ball_comes_up_from_a_plate_as_restitution_says_whatever_joints_hold_it() {
    let plate_box = Geometry::Box { half_extents: Vec3::new(1.0, 0.1, 1.0) };
    for rate in RATES {
        for (mass, restitution) in [(0.1, 1.0_f32), (1.0, 1.0), (1.0, 0.6), (20.0, 1.0), (50.0, 1.0), (100.0, 0.8), (1000.0, 1.0)]
        {
            for how in HOLDS {
                let mut world = world(9.81);
                let plate = body(&mut world, mass, DVec3::ZERO, plate_box.clone(), (0.0, 0.5));
                hold(&mut world, plate, how);
                for _ in 0..(0.25 * rate) as usize {
                    world.step(1.0 / rate).unwrap();
                }
                let ball = body(&mut world, 1.0, DVec3::Y * 1.3, Geometry::Ball { radius: 0.2 }, (restitution, 0.5));
                let (mut expected, mut bounces, mut was_rising) = (1.0, 0, false);
                for _ in 0..(1.6 * rate) as usize {
                    world.step(1.0 / rate).unwrap();
                    let is_rising = world.linear_velocity(ball).unwrap().y > 0.0;
                    // What hits at less than a metre a second does not rebound.
                    if is_rising && !was_rising && 2.0 * 9.81 * expected > 1.5 {
                        expected *= f64::from(restitution * restitution);
                        let (found, what) =
                            (apex(&world, ball), format!("{mass} kg held by {how} at {rate} Hz, e {restitution}"));
                        assert!((found / expected - 1.0).abs() < 0.005, "{what}: comes up {found} m, expected {expected} m");
                        bounces += 1;
                    }
                    was_rising = is_rising;
                }
                assert!(bounces >= 1, "{mass} kg held by {how} at {rate} Hz: the ball has not come up");
            }
        }
    }
}

#[test]
fn balls_that_hang_in_a_row_pass_a_blow_on() {
    for rate in RATES {
        for gap in [1.0e-5, 1.0e-4, 3.0e-3] {
            let mut world = world(9.81);
            let spacing = 0.2 + gap;
            let balls: Vec<_> = (0..5)
                .map(|i| {
                    let at = DVec3::X * (spacing * f64::from(i));
                    let ball = body(&mut world, 1.0, at, Geometry::Ball { radius: 0.1 }, (1.0, 0.0));
                    let hook = at.as_vec3() + Vec3::Y * 2.0;
                    world.create_joint(&JointDef::new(JointKind::SPHERICAL, BodyId::NULL, ball).at(hook, Vec3::Y * 2.0)).unwrap();
                    ball
                })
                .collect();
            world.set_linear_velocity(balls[0], Vec3::X * -2.5).unwrap();
            world.set_angular_velocity(balls[0], Vec3::Z * -1.25).unwrap();
            let speeds = |world: &World| balls.iter().map(|&ball| world.linear_velocity(ball).unwrap().x).collect::<Vec<_>>();
            // Half a swing of 2 m takes 1.45 s.
            for _ in 0..(1.55 * rate) as usize {
                world.step(1.0 / rate).unwrap();
            }
            let found = speeds(&world);
            let what = format!("{gap} m apart at {rate} Hz: {found:?} m/s");
            assert!(found[4] > 2.2 && found[4] < 2.51, "{what}: the last one should have 2.3 to 2.5");
            assert!(found[..4].iter().all(|speed| speed.abs() < 0.05), "{what}: all others should hang still");
        }
    }
}

#[test]
fn hits_on_a_chain_in_free_flight_gain_no_energy_and_keep_momentum() {
    for rate in [30.0, 60.0, 240.0] {
        for material in [(1.0, 0.0), (1.0, 0.5), (0.5, 0.5)] {
            let mut world = world(0.0);
            let link = Geometry::Box { half_extents: Vec3::new(0.25, 0.1, 0.2) };
            let mut bodies: Vec<BodyId> = Vec::new();
            for (i, mass) in [1.0, 3.0, 0.5, 2.0].into_iter().enumerate() {
                let next = body(&mut world, mass, DVec3::X * (0.6 * i as f64), link.clone(), material);
                if let Some(&last) = bodies.last() {
                    let joint = JointDef::new(JointKind::SPHERICAL, last, next).at(Vec3::X * 0.3, Vec3::X * -0.3);
                    world.create_joint(&joint).unwrap();
                }
                bodies.push(next);
            }
            for (i, mass) in [0.5, 1.0, 5.0, 0.2].into_iter().enumerate() {
                let at = DVec3::new(0.5 * i as f64 + 0.1, 1.0 + 0.3 * i as f64, 0.05);
                let ball = body(&mut world, mass, at, Geometry::Ball { radius: 0.1 }, material);
                world.set_linear_velocity(ball, Vec3::new(0.3, -4.0, 0.1)).unwrap();
                world.set_angular_velocity(ball, Vec3::new(0.0, 3.0, 20.0)).unwrap();
                bodies.push(ball);
            }
            let mass = |world: &World, body: BodyId| world.mass_properties(body).unwrap().unwrap();
            let energy = |world: &World| -> f64 {
                let of = |&body: &BodyId| {
                    let (own, turn) = (mass(world, body), world.pose(body).unwrap().rotation);
                    let spin = ((turn * own.inertia_frame).conjugate() * world.angular_velocity(body).unwrap()).as_dvec3();
                    let speed = world.linear_velocity(body).unwrap().as_dvec3();
                    0.5 * (f64::from(own.mass) * speed.length_squared() + spin.dot(own.principal_inertia.as_dvec3() * spin))
                };
                bodies.iter().map(of).sum()
            };
            let momentum = |world: &World| -> DVec3 {
                let of = |&body: &BodyId| world.linear_velocity(body).unwrap().as_dvec3() * f64::from(mass(world, body).mass);
                bodies.iter().map(of).sum()
            };
            let (before, carried) = (energy(&world), momentum(&world));
            let (mut last, mut most) = (before, 0.0_f64);
            for _ in 0..rate as usize {
                world.step(1.0 / rate).unwrap();
                let now = energy(&world);
                (most, last) = (most.max(now - last), now);
            }
            let what = format!("{rate} Hz, restitution and friction {material:?}");
            // What swings along is solved to second order between hits.
            assert!(most < 5.0e-4 * before, "{what}: a step gains {most} J of {before} J");
            let is_elastic = material == (1.0, 0.0);
            assert!(last < if is_elastic { 1.0003 } else { 0.99 } * before, "{what}: {last} J of {before} J after the hits");
            assert!(!is_elastic || last > 0.999 * before, "{what}: {last} J of {before} J after elastic hits");
            let drift = (momentum(&world) - carried).length() / carried.length();
            assert!(drift < 1.0e-5, "{what}: momentum has changed by {drift} of itself");
        }
    }
}

/// Arms whose hinges have elastic stops, thrown without gravity: each blow goes through all links, and what is met gives back what it takes.
#[test]
fn arms_on_elastic_stops_keep_their_energy() {
    for (links, rate) in (1..=3).flat_map(|links| RATES.map(|rate| (links, rate))) {
        for size in [0.1_f32, 1.0, 10.0] {
            let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
            let def = WorldDef { gravity: Vec3::ZERO, restitution_threshold: 0.0, sleep, ..WorldDef::default() };
            let mut world = World::new(&def).unwrap();
            let about_z = Quat::from_rotation_y(-0.5 * PI);
            let mut arm = vec![BodyId::NULL];
            for link in 0..links {
                let half = Vec3::new(0.5, 0.05, 0.05) * size;
                let mut shape = ShapeDef::new(Shape::cuboid(half).unwrap());
                shape.filter.collides_with = 0;
                let pose = Pose::at_xyz(f64::from(size) * (f64::from(link) + 0.5), 0.0, 0.0);
                let body = BodyDef { mass: Mass::Total(1.0), ..BodyDef::dynamic(pose) }.with_shape(shape);
                let body = world.create_body(&body).unwrap();
                let kind = JointKind::Hinge { limits: Limits::new(-0.8, 0.8), motor: Motor::Off };
                let mut def = JointDef { restitution: 1.0, ..JointDef::new(kind, arm[arm.len() - 1], body) };
                let at = |along: f32| Pose::at_xyz(f64::from(along * size), 0.0, 0.0).rotated(about_z);
                (def.frame_a, def.frame_b) = (at(if link == 0 { 0.0 } else { 0.5 }), at(-0.5));
                world.create_joint(&def).unwrap();
                arm.push(body);
            }
            let thrown = arm[arm.len() - 1];
            world.set_angular_velocity(thrown, Vec3::Z * 4.0).unwrap();
            world.set_linear_velocity(thrown, Vec3::Y * (2.0 * size)).unwrap();
            world.step(1.0 / rate).unwrap();
            let inertia = (1.0 + 0.01) / 12.0;
            let energy = |world: &World| {
                let of = |&body: &BodyId| {
                    let (speed, turn) = (world.linear_velocity(body).unwrap() / size, world.angular_velocity(body).unwrap());
                    0.5 * speed.length_squared() + 0.5 * inertia * turn.length_squared()
                };
                arm[1..].iter().map(of).sum::<f32>()
            };
            let begun = energy(&world);
            let mut met = 0;
            for _ in 0..(6.0 * rate) as u32 {
                world.step(1.0 / rate).unwrap();
                met += world.joint_stops().len();
            }
            let left = energy(&world) / begun;
            let what = format!("{links} links of {size} m at {rate}/s, {met} stops met");
            assert!(met >= 10, "{what}: it turns about");
            assert!((0.9..1.001).contains(&left), "{what}: {left} of the energy is left after 6 s");
        }
    }
}

/// The ball goes off at (1 + e) times the speed of the bat.
#[test]
fn a_bat_on_a_motor_gives_all_of_the_restitution() {
    let free = Axis { limits: Limits::NONE, ..Axis::limited(0.0, 0.0) };
    for rate in RATES {
        for (restitution, mass, is_slider) in
            [(1.0, 1.0, true), (1.0, 10.0, true), (1.0, 0.1, false), (0.5, 1.0, false), (0.5, 100.0, true)]
        {
            let mut world = world(0.0);
            let bat = Geometry::Box { half_extents: Vec3::splat(0.2) };
            let bat = body(&mut world, 1.0, DVec3::ZERO, bat, (restitution, 0.0));
            let motor = Motor::Velocity { target: 2.0, max_force: f32::INFINITY };
            let kind = if is_slider {
                JointKind::Prismatic { limits: Limits::NONE, motor }
            } else {
                let locked = Axis::limited(0.0, 0.0);
                JointKind::Generic { linear: [Axis { motor, ..free }, locked, locked], angular: [locked; 3] }
            };
            world.create_joint(&JointDef::new(kind, BodyId::NULL, bat)).unwrap();
            let ball = body(&mut world, mass, DVec3::X * 0.5137, Geometry::Ball { radius: 0.1 }, (restitution, 0.0));
            for _ in 0..rate as usize {
                world.step(1.0 / rate).unwrap();
            }
            let (speed, expected) = (world.linear_velocity(ball).unwrap().x, 2.0 * (1.0 + restitution));
            let what = format!("a ball of {mass} kg, restitution {restitution}, {rate} Hz");
            assert!((speed - expected).abs() < 1.0e-3 * expected, "{what}: {speed} m/s, expected {expected}");
        }
    }
}

/// A plate of 100 kg that a joint at its middle holds to the world: that joint.
fn held_plate(world: &mut World, kind: JointKind, is_slider: bool, strength: f32) -> JointId {
    let plate = body(world, 100.0, DVec3::ZERO, Geometry::Box { half_extents: Vec3::new(0.5, 0.05, 0.5) }, (0.0, 0.5));
    let mut def = JointDef::new(kind, BodyId::NULL, plate);
    if is_slider {
        (def.frame_a.rotation, def.frame_b.rotation) = (Quat::from_rotation_z(0.5 * PI), Quat::from_rotation_z(0.5 * PI));
    }
    def.strength = Strength { tension: strength, compression: strength, shear: strength, window: 1.0e-3, ..def.strength };
    world.create_joint(&def).unwrap()
}

/// What the impact solve does through joints was in no load: 0 of 60 N·s at a restitution of one half, so that such blows broke nothing.
#[test]
fn joints_bear_the_blows_that_rebound_from_what_they_hold() {
    let locked = [Axis::limited(0.0, 0.0); 3];
    let slider = JointKind::Prismatic { limits: Limits::new(0.0, 0.3), motor: Motor::Off };
    let kinds = [JointKind::HINGE, JointKind::SPHERICAL, JointKind::Generic { linear: locked, angular: locked }, slider];
    for (rate, (number, kind)) in RATES.into_iter().flat_map(|rate| kinds.into_iter().enumerate().map(move |kind| (rate, kind))) {
        for restitution in [0.0_f32, 0.3, 1.0] {
            for strength in [f32::INFINITY, 50.0] {
                let mut world = world(0.0);
                let joint = held_plate(&mut world, kind, number == 3, strength);
                let ball = body(&mut world, 20.0, DVec3::Y * 0.65, Geometry::Ball { radius: 0.1 }, (restitution, 0.0));
                world.set_linear_velocity(ball, Vec3::NEG_Y * 2.0).unwrap();
                let (mut borne, mut broken) = (0.0, 0);
                for _ in 0..(0.5 * rate) as usize {
                    world.step(1.0 / rate).unwrap();
                    broken += world.broken().len();
                    borne += world.joint_state(joint).map_or(0.0, |state| state.force.y / rate);
                }
                let what = format!("{kind:?} at {rate} Hz, e {restitution}");
                if strength.is_finite() {
                    assert!(broken > 0, "{what}: a blow of 40 N·s and more breaks nothing of 50 N");
                    continue;
                }
                // A ball on its middle does not turn it: the joint takes all of it.
                let given = 20.0 * (world.linear_velocity(ball).unwrap().y + 2.0);
                assert!(given > 39.9 * (1.0 + restitution), "{what}: the ball was given {given} N·s");
                assert!((borne / given - 1.0).abs() < 2.0e-3, "{what}: {borne} N·s borne of {given}");
            }
        }
    }
}

/// Two bodies that a joint holds together, the lower of which lands: all that the upper one gains has gone through the joint. So has what a stop
/// with restitution gives back beside it.
#[test]
fn a_joint_of_what_lands_bears_what_its_upper_body_is_given() {
    let cube = Geometry::Box { half_extents: Vec3::splat(0.4) };
    for rate in RATES {
        for (kind, own) in [
            (JointKind::HINGE, 0.0),
            (JointKind::SPHERICAL, 0.0),
            (JointKind::Prismatic { limits: Limits::new(-0.03, 0.05), motor: Motor::Off }, 0.0),
            (JointKind::Prismatic { limits: Limits::new(-0.03, 0.05), motor: Motor::Off }, 0.5),
        ] {
            let mut world = world(9.81);
            let floor = ShapeDef::new(Shape::new(Geometry::Box { half_extents: Vec3::new(5.0, 0.5, 5.0) }).unwrap());
            world.create_body(&BodyDef::fixed(Pose::at(DVec3::Y * -2.5)).with_shape(floor)).unwrap();
            let upper = body(&mut world, 2.0, DVec3::Y, cube.clone(), (0.6, 0.5));
            let lower = body(&mut world, 3.0, DVec3::ZERO, cube.clone(), (0.6, 0.5));
            let mut def = JointDef::new(kind, upper, lower).at(Vec3::Y * -0.5, Vec3::Y * 0.5);
            let turned =
                if matches!(kind, JointKind::Prismatic { .. }) { Quat::from_rotation_z(0.5 * PI) } else { Quat::IDENTITY };
            (def.frame_a.rotation, def.frame_b.rotation, def.restitution) = (turned, turned, own);
            let joint = world.create_joint(&def).unwrap();
            let count = (0.8 * rate) as usize;
            let mut borne = 0.0;
            for _ in 0..count {
                world.step(1.0 / rate).unwrap();
                borne -= world.joint_state(joint).unwrap().force.y / rate;
            }
            let given = 2.0 * (world.linear_velocity(upper).unwrap().y + 9.81 * count as f32 / rate);
            let what = format!("{kind:?} with {own} at {rate} Hz");
            assert!(given > 10.0, "{what}: it has not landed");
            assert!((borne / given - 1.0).abs() < 5.0e-3, "{what}: {borne} N·s borne of {given}");
        }
    }
}
