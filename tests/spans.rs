//! What joints span and contacts load: bridges, towers of struts and cables, nets, arches, lifts.

use crate::common::Run;
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Geometry, JointDef, JointKind, Limits, Mass, Material, Motor, Pose, QueryFilter, Shape, ShapeDef,
    SleepSettings, World, WorldDef,
};

/// Where wheels of 50 kg bear a hull of 1.3 t, sweeps let them sink into planks of 20 kg by 5 cm, and the car runs off its line by 0.3 m.
/// At 4 m/s and 30 Hz a wheel goes on by 33 mm in a substep, which a plank that rises by 0.08 more than the last meets by 2.6 mm.
#[test]
fn a_car_drives_over_a_bridge_of_planks_and_stays_on_it() {
    for rate in ["30", "60", "120"] {
        for keys in [[("planks", "8"), ("speed", "4")], [("planks", "10"), ("speed", "0")]] {
            let run = Run::of("bridge_car", &[keys[0], keys[1], ("rate", rate), ("seconds", "2.5")]);
            run.keeps("deep_m", 3.0e-3, "m");
            run.keeps("joint_gap_m", 1.0e-3, "m");
            run.keeps("aside_m", 1.0e-2, "m");
            run.keeps("tilt_deg", 0.2, "degrees");
        }
    }
}

/// How high (m) wheels of a car hop that crosses a bridge of eight planks at 4 m/s, or as fast for its size: the slope grows by 0.03 from plank to plank.
fn hop_on_a_bridge(wheel: &Geometry, [size, rate]: [f32; 2]) -> f32 {
    const PLANKS: usize = 8;
    let mut world = World::new(&WorldDef::default()).unwrap();
    let solid = |geometry: Geometry| {
        let material = Material { friction: 0.8, ..Material::default() };
        ShapeDef { material, ..ShapeDef::new(Shape::new(geometry).unwrap()) }
    };
    let cuboid = |x: f32, y: f32, z: f32| Geometry::Box { half_extents: Vec3::new(x, y, z) * size };
    let slope = |i: usize| 0.03 * (i as f32 - 0.5 * (PLANKS as f32 - 1.0));
    let mut ends = vec![Vec3::ZERO];
    (0..PLANKS).for_each(|i| ends.push(ends[i] + Quat::from_rotation_z(slope(i)) * Vec3::X * (0.5 * size)));
    let half = 0.5 * ends[PLANKS].x;
    ends.iter_mut().for_each(|end| end.x -= half);
    let banks = [-1.0, 1.0].map(|side| {
        let at = Pose::at_xyz((side * (half + 6.0 * size)).into(), f64::from(-0.45 * size), 0.0);
        (world.create_body(&BodyDef::fixed(at).with_shape(solid(cuboid(6.0, 0.5, 3.0)))).unwrap(), at)
    });
    let [speed, radius] = [4.0 * size.sqrt(), 0.3 * size];
    let add = |world: &mut World, at: Pose, geometry: Geometry, mass: f32, [velocity, spin]: [Vec3; 2]| {
        let def = BodyDef { mass: Mass::Total(mass * size.powi(3)), ..BodyDef::dynamic(at) };
        let def = BodyDef { linear_velocity: velocity, angular_velocity: spin, ..def };
        (world.create_body(&def.with_shape(solid(geometry))).unwrap(), at)
    };
    let tie = |world: &mut World, kind: JointKind, pair: [(BodyId, Pose); 2], at: Vec3, axes: Quat| {
        let frame = |(_, pose): (BodyId, Pose)| {
            Pose::at(pose.inverse_transform_point(at.as_dvec3()).as_dvec3()).rotated(pose.rotation.inverse() * axes)
        };
        let mut def = JointDef::new(kind, pair[0].0, pair[1].0);
        (def.frame_a, def.frame_b) = (frame(pair[0]), frame(pair[1]));
        world.create_joint(&def).unwrap();
    };
    let mut last = banks[0];
    for (i, end) in ends.iter().enumerate() {
        let next = ends.get(i + 1).map_or(banks[1], |next| {
            let at = Pose::at((0.5 * (*end + *next)).as_dvec3()).rotated(Quat::from_rotation_z(slope(i)));
            add(&mut world, at, cuboid(0.25, 0.05, 1.0), 20.0, [Vec3::ZERO; 2])
        });
        for z in [-size, size] {
            tie(&mut world, JointKind::SPHERICAL, [last, next], *end + Vec3::Z * z, Quat::IDENTITY);
        }
        last = next;
    }
    let axles = Vec3::new(-half - 3.0 * size, 0.05 * size + radius, 0.0);
    let along = Vec3::X * speed;
    let hull = Pose::at((axles + Vec3::Y * (0.2 * size)).as_dvec3());
    let hull = add(&mut world, hull, cuboid(1.5, 0.2, 0.6), 1300.0, [along, Vec3::ZERO]);
    let wheels = [(-1.2, -0.75), (-1.2, 0.75), (1.2, -0.75), (1.2, 0.75)].map(|(x, z)| {
        let at = axles + Vec3::new(x, 0.0, z) * size;
        let lying = Pose::at(at.as_dvec3()).rotated(Quat::from_rotation_arc(Vec3::Y, Vec3::Z));
        let body = add(&mut world, lying, wheel.clone(), 50.0, [along, Vec3::Z * (-speed / radius)]);
        tie(&mut world, JointKind::HINGE, [hull, body], at, Quat::from_rotation_arc(Vec3::X, Vec3::Z));
        body.0
    });
    let mut hop = 0.0_f32;
    for _ in 0..((2.0 * half + 4.0 * size) / speed * rate) as usize {
        world.step(1.0 / rate).unwrap();
        for &body in &wheels {
            let at = Pose::at(world.pose(body).unwrap().position);
            // A ray would look down between planks.
            let filter = QueryFilter { ignored: &[body], ..QueryFilter::default() };
            let below = world.cast_shape(&Shape::ball(0.5 * radius).unwrap(), at, Vec3::NEG_Y * size, &filter).unwrap();
            hop = hop.max(below.map_or(size, |hit| hit.distance as f32) - 0.5 * radius);
        }
    }
    hop
}

/// At either bank the slope falls by 0.105, over which wheels fly by (v s)²/2g, 9 mm at 4 m/s, and the hull's pitch adds to that. The edges of planks
/// ahead, which move and don't lie flush to the bit, struck wheels: they hopped by 82 to 136 mm at 30 and 60 steps a second.
#[test]
fn wheels_do_not_hop_over_the_edges_of_planks() {
    for [size, rate] in [[1.0, 30.0], [1.0, 60.0], [1.0, 120.0], [0.1, 120.0], [10.0, 30.0]] {
        let radius = 0.3 * size;
        let wheels = [
            Geometry::Cylinder { half_height: 0.1 * size, radius },
            Geometry::Capsule { half_height: 0.1 * size, radius },
            Geometry::Ball { radius },
        ];
        for wheel in &wheels {
            let hop = hop_on_a_bridge(wheel, [size, rate]) / size;
            assert!(hop < 0.02, "{wheel:?} at {rate}/s: hops by {hop} of its size, bound 0.02");
        }
    }
}

/// A truck of 1.5 t on eight wheels drives over planks of 100 kg that hang from ropes. Its wheels must not make the planks turn: they did, wheels went
/// 7 to 20 mm deep, and it ran off its line and once off the bridge.
#[test]
fn a_truck_drives_over_a_bridge_that_hangs_from_ropes() {
    for rate in [30.0_f32, 60.0, 120.0] {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let solid = |geometry: Geometry, friction: f32| {
            let material = Material { friction, ..Material::default() };
            ShapeDef { material, ..ShapeDef::new(Shape::new(geometry).unwrap()) }
        };
        let cuboid = |x: f32, y: f32, z: f32| Geometry::Box { half_extents: Vec3::new(x, y, z) };
        let (planks, length) = (12, 1.0_f32);
        let half = 0.5 * length * planks as f32;
        for side in [-1.0, 1.0] {
            let def = BodyDef::fixed(Pose::at_xyz(side * f64::from(half + 10.0), -0.5, 0.0));
            world.create_body(&def.with_shape(solid(cuboid(10.0, 0.55, 3.0), 0.8))).unwrap();
        }
        let mut last = (BodyId::NULL, Vec3::X * -half);
        for i in 0..planks {
            let at = DVec3::X * f64::from(length * (i as f32 + 0.5) - half);
            let def = BodyDef { mass: Mass::Total(100.0), ..BodyDef::dynamic(Pose::at(at)) };
            let plank = world.create_body(&def.with_shape(solid(cuboid(0.48 * length, 0.05, 1.5), 0.8))).unwrap();
            let hinge = |ends: [BodyId; 2], points: [Vec3; 2]| {
                let mut def = JointDef::new(JointKind::HINGE, ends[0], ends[1]).at(points[0], points[1]);
                let across = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
                (def.frame_a.rotation, def.frame_b.rotation) = (across, across);
                def
            };
            world.create_joint(&hinge([last.0, plank], [last.1, Vec3::X * (-0.5 * length)])).unwrap();
            if i + 1 == planks {
                world.create_joint(&hinge([plank, BodyId::NULL], [Vec3::X * (0.5 * length), Vec3::X * half])).unwrap();
            }
            last = (plank, Vec3::X * (0.5 * length));
            for z in [-1.4, 1.4] {
                let rope = JointKind::Distance { limits: Limits::new(0.0, 4.0), spring_length: None, motor: Motor::Off };
                let ends = (Vec3::new(at.x as f32, 4.0, z), Vec3::Z * z);
                world.create_joint(&JointDef::new(rope, BodyId::NULL, plank).at(ends.0, ends.1)).unwrap();
            }
        }
        let (wheel, speed, start) = (0.35_f32, 6.0_f32, -half - 3.0);
        let def = BodyDef { mass: Mass::Total(1500.0), ..BodyDef::dynamic(Pose::at_xyz(start.into(), 0.75, 0.0)) };
        let hull = world.create_body(&def.with_shape(solid(cuboid(2.2, 0.3, 0.6), 0.5))).unwrap();
        for (x, z) in [-1.65_f32, -0.55, 0.55, 1.65].into_iter().flat_map(|x| [(x, -0.8_f32), (x, 0.8)]) {
            let upright = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
            let pose = Pose::at_xyz((start + x).into(), f64::from(wheel) + 0.05, z.into()).rotated(upright);
            let def = BodyDef { mass: Mass::Total(19.0), ..BodyDef::dynamic(pose) };
            let round = solid(Geometry::Cylinder { half_height: 0.12, radius: wheel }, 0.8);
            let body = world.create_body(&def.with_shape(round)).unwrap();
            let motor = Motor::Velocity { target: -speed / wheel, max_force: 130.0 };
            let mut def = JointDef::new(JointKind::Hinge { limits: Limits::NONE, motor }, hull, body);
            def = def.at(Vec3::new(x, wheel + 0.05 - 0.75, z), Vec3::ZERO);
            let across = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
            (def.frame_a.rotation, def.frame_b.rotation) = (across, upright.inverse() * across);
            world.create_joint(&def).unwrap();
        }
        let mut deep = 0.0_f32;
        for _ in 0..(5.0 * rate) as usize {
            world.step(1.0 / rate).unwrap();
            deep = deep.max(world.report().residuals.penetration);
        }
        let end = world.pose(hull).unwrap().position;
        assert!(deep < 2.0e-3, "{rate}/s: {deep} m deep, bound 2 mm");
        assert!(end.x > -1.0, "{rate}/s: at {} m after 5 s, bound the middle of the bridge less a metre", end.x);
        assert!(end.z.abs() < 0.5 && end.y > 0.6, "{rate}/s: {} m aside at {} m, bounds 0.5 m and above 0.6 m", end.z, end.y);
    }
}

/// Its cables have no tension where it is made: struts turn by a few milliradians until they have. By sweeps it lies down.
#[test]
fn a_tower_of_struts_and_cables_bears_its_load() {
    for rate in ["30", "60", "120"] {
        for (storeys, load) in [("3", "0"), ("4", "100"), ("6", "100")] {
            let run = Run::of("tensegrity", &[("storeys", storeys), ("load", load), ("rate", rate), ("seconds", "2")]);
            run.keeps("sunk_m", 0.02, "m");
            run.keeps("joint_gap_m", 1.0e-3, "m");
        }
    }
}

/// By sweeps all four fall through.
#[test]
fn a_net_holds_the_boxes_that_fall_into_it() {
    for rate in ["30", "60", "120"] {
        let run = Run::of("net", &[("cells", "3"), ("boxes", "4"), ("rate", rate), ("seconds", "1.5")]);
        run.is("fallen", 0.0);
        run.keeps("joint_gap_m", 1.0e-3, "m");
        run.keeps("energy_growth_pct", 0.1, "%");
    }
}

/// Stones of an arch under load lean on edges.
#[test]
fn an_arch_of_many_stones_bears_its_lamp_at_few_steps_a_second() {
    for (stones, lamp) in [("17", "37"), ("20", "300"), ("31", "1000")] {
        Run::of("lamp_arch", &[("n", stones), ("lamp", lamp), ("rate", "30")]).keeps("sunk_m", 1.0e-3, "m");
    }
}

/// What stands on a platform that stops at 1 m/s leaves it by v²/2g, and comes down on it again.
#[test]
fn a_lift_that_runs_against_its_stop_stays_exact() {
    for rate in ["30", "60", "120"] {
        let run = Run::of("elevator", &[("stop", "on"), ("rate", rate)]);
        run.keeps("behind_m", 1.0e-3, "m");
        run.keeps("load_err_pct", 0.1, "%");
        let (hop, expected) = (run.error("hop_m"), 1.0 / (2.0 * 9.81));
        assert!((hop - expected).abs() < 3.0e-3, "at {rate} Hz the crate leaves by {hop} m, expected {expected} m");
    }
}

/// A box of this mass beside a smooth wall that touches its side, so that contacts are in its island.
fn box_at_a_wall(mass: f32, at: DVec3) -> (World, BodyId) {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let mut world = World::new(&WorldDef { sleep, ..WorldDef::default() }).unwrap();
    let shape = |half_extents: Vec3| {
        let material = Material { friction: 0.0, ..Material::default() };
        ShapeDef { material, ..ShapeDef::new(Shape::new(Geometry::Box { half_extents }).unwrap()) }
    };
    world.create_body(&BodyDef::fixed(Pose::at(at - DVec3::Z * 0.6)).with_shape(shape(Vec3::new(9.0, 9.0, 0.5)))).unwrap();
    let def = BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(Pose::at(at)) };
    let body = world.create_body(&def.with_shape(shape(Vec3::splat(0.1)))).unwrap();
    (world, body)
}

/// It falls by a metre, or turns a quarter down, on the stop of its joint; the wall must take nothing of that.
#[test]
fn what_falls_on_a_stop_comes_up_as_restitution_says_with_contacts_beside_it() {
    for rate in [30.0_f32, 60.0, 120.0, 240.0] {
        for (mass, restitution) in [(100.0, 1.0_f32), (1.0, 0.6)] {
            for is_hinge in [false, true] {
                let start = if is_hinge { DVec3::X } else { DVec3::Y };
                let (mut world, body) = box_at_a_wall(mass, start);
                let limits = Limits::new(0.0, f32::INFINITY);
                let mut def = if is_hinge {
                    let limits = Limits::new(-std::f32::consts::FRAC_PI_2, f32::INFINITY);
                    JointDef::new(JointKind::Hinge { limits, motor: Motor::Off }, BodyId::NULL, body)
                } else {
                    JointDef::new(JointKind::Prismatic { limits, motor: Motor::Off }, BodyId::NULL, body)
                };
                let axes = if is_hinge {
                    Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2)
                } else {
                    Quat::from_rotation_z(std::f32::consts::FRAC_PI_2)
                };
                def.frame_a = Pose { position: DVec3::ZERO, rotation: axes };
                def.frame_b = Pose { position: if is_hinge { -start } else { DVec3::ZERO }, rotation: axes };
                def.restitution = restitution;
                world.create_joint(&def).unwrap();
                let energy = |world: &World| {
                    let speed = world.linear_velocity(body).unwrap().length_squared();
                    let spin = world.angular_velocity(body).unwrap().length_squared() * 0.04 / 6.0;
                    let bottom = if is_hinge { -1.0 } else { 0.0 };
                    world.pose(body).unwrap().position.y - bottom + f64::from(speed + spin) / (2.0 * 9.81)
                };
                let fell = |world: &World| {
                    if is_hinge { world.angular_velocity(body).unwrap().z } else { world.linear_velocity(body).unwrap().y }
                };
                let mut before = energy(&world);
                let mut after = f64::NAN;
                for _ in 0..(1.1 * rate) as usize {
                    world.step(1.0 / rate).unwrap();
                    if fell(&world) > 0.0 {
                        after = energy(&world);
                        break;
                    }
                    before = energy(&world);
                }
                let (share, expected) = (after / before, f64::from(restitution * restitution));
                let what = format!("{mass} kg, restitution {restitution}, hinge: {is_hinge}, at {rate} Hz");
                assert!((share - expected).abs() < 0.02, "{what}: {share} of the energy is left, expected {expected}");
                assert!(before > 0.93, "{what}: it has lost energy on its way, {before} m of 1 are left");
            }
        }
    }
}
