//! Joints that meet contacts: ropes on posts, loads that stand and hang at once.

use std::f64::consts::PI;

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, Geometry, JointDef, JointId, JointKind, Limits, Mass, Material, Motor, Pose, Shape, ShapeDef, SleepSettings,
    World, WorldDef,
};

fn world() -> World {
    World::new(&WorldDef { sleep: SleepSettings { enabled: false, ..SleepSettings::default() }, ..WorldDef::default() }).unwrap()
}

fn add(world: &mut World, def: &BodyDef, geometry: Geometry, friction: f32) -> BodyId {
    let material = Material { friction, ..Material::default() };
    let shape = ShapeDef { material, ..ShapeDef::new(Shape::new(geometry).unwrap()) };
    world.create_body(&def.clone().with_shape(shape)).unwrap()
}

fn dynamic(mass: f32, pose: Pose) -> BodyDef {
    BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(pose) }
}

fn cube(world: &mut World, mass: f32, half: f32, at: DVec3, friction: f32) -> BodyId {
    add(world, &dynamic(mass, Pose::at(at)), Geometry::Box { half_extents: Vec3::splat(half) }, friction)
}

/// Height of a body's centre (m).
fn height(world: &World, body: BodyId) -> f64 {
    world.pose(body).unwrap().position.y
}

fn run(world: &mut World, seconds: f64, rate: f32) {
    for _ in 0..(seconds * f64::from(rate)).round() as usize {
        world.step(1.0 / rate).unwrap();
    }
}

/// A rope of capsules from point to point, 1 kg each; neighbours meet at the points.
fn rope(world: &mut World, points: &[DVec3], friction: f32, from: Option<(BodyId, Vec3)>) -> (Vec<BodyId>, Vec<JointId>) {
    let (mut links, mut joints) = (Vec::new(), Vec::new());
    let mut last = from;
    for ends in points.windows(2) {
        let (way, middle) = (ends[1] - ends[0], 0.5 * (ends[0] + ends[1]));
        let half = 0.5 * way.length() as f32;
        let rotation = Quat::from_rotation_arc(Vec3::Y, way.normalize().as_vec3());
        let geometry = Geometry::Capsule { half_height: half, radius: 0.02 };
        let link = add(world, &dynamic(1.0, Pose { position: middle, rotation }), geometry, friction);
        if let Some((body, anchor)) = last {
            joints
                .push(world.create_joint(&JointDef::new(JointKind::SPHERICAL, body, link).at(anchor, Vec3::Y * -half)).unwrap());
        }
        last = Some((link, Vec3::Y * half));
        links.push(link);
    }
    (links, joints)
}

fn hang(world: &mut World, mass: f32, from: BodyId, anchor: Vec3, point: DVec3) -> (BodyId, JointId) {
    let load = cube(world, mass, 0.1, point - DVec3::Y * 0.1, 0.5);
    let joint = JointDef::new(JointKind::SPHERICAL, from, load).at(anchor, Vec3::Y * 0.1);
    (load, world.create_joint(&joint).unwrap())
}

const POST: f64 = 0.3;

/// A rope over a fixed post of 0.3 m with a load at each end, and the loads (kg).
fn rope_on_a_post(world: &mut World, friction: f32, loads: [f32; 2]) -> [BodyId; 2] {
    let upright = Quat::from_rotation_x(-0.5 * PI as f32);
    let post = Pose { position: DVec3::ZERO, rotation: upright };
    add(world, &BodyDef::fixed(post), Geometry::Cylinder { half_height: 0.5, radius: POST as f32 }, friction);
    let (half, along) = (0.05, POST + 0.02);
    let radius = (along * along + half * half).sqrt();
    let step = 2.0 * (half / radius).asin();
    let arc = (PI / step).floor();
    let first = 0.5 * (PI + arc * step);
    let at = |angle: f64| DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0);
    let mut points: Vec<DVec3> = (1..=6).rev().map(|i| at(first) - DVec3::Y * 0.1 * f64::from(i)).collect();
    points.extend((0..=arc as usize).map(|i| at(first - step * i as f64)));
    let end = *points.last().unwrap();
    points.extend((1..=6).map(|i| end - DVec3::Y * 0.1 * f64::from(i)));
    let (links, _) = rope(world, &points, friction, None);
    let tip = Vec3::Y * half as f32;
    let (left, _) = hang(world, loads[0], links[0], -tip, points[0]);
    let (right, _) = hang(world, loads[1], *links.last().unwrap(), tip, *points.last().unwrap());
    [left, right]
}

#[test]
fn a_rope_on_a_post_rests_without_sinking_in_or_gaining_energy() {
    for (loads, friction, rate) in
        [([10.0, 10.0], 0.5, 60.0), ([10.0e3, 10.0e3], 0.5, 60.0), ([10.0e3, 10.0e3], 0.05, 60.0), ([100.0, 100.0], 0.2, 30.0)]
    {
        let mut world = world();
        let ends = rope_on_a_post(&mut world, friction, loads);
        let before = ends.map(|end| height(&world, end));
        let (mut deepest, mut fastest) = (0.0_f32, 0.0_f32);
        for step in 0..(2.0 * rate) as usize {
            world.step(1.0 / rate).unwrap();
            deepest = deepest.max(world.report().residuals.penetration);
            if step as f32 > rate {
                fastest = ends.iter().fold(fastest, |most, &end| most.max(world.linear_velocity(end).unwrap().length()));
            }
        }
        let what = format!("{loads:?} kg, friction {friction}, {rate} Hz");
        assert!(deepest < 1.0e-3, "{what}: {deepest} m deep");
        assert!(fastest < 0.02, "{what}: {fastest} m/s after a second");
        for (end, before) in ends.into_iter().zip(before) {
            let moved = height(&world, end) - before;
            assert!(moved.abs() < 5.0e-3, "{what}: a load has moved by {moved} m");
        }
    }
}

/// A rope is tied at one end and laid over a post with a little slack: as it goes taut, a blow of tonnes goes through links of a kilogram.
#[test]
fn a_rope_that_is_tied_and_goes_taut_on_its_post_comes_to_rest() {
    for (mass, rate) in [(5.0e3_f32, 60.0_f32), (10.0e3, 120.0), (10.0e3, 30.0)] {
        let mut world = world();
        let upright = Quat::from_rotation_x(-0.5 * PI as f32);
        let post = Geometry::Cylinder { half_height: 0.5, radius: POST as f32 };
        add(&mut world, &BodyDef::fixed(Pose { position: DVec3::ZERO, rotation: upright }), post, 0.5);
        let (along, radius) = (1.5, (POST + 0.02) / (0.075_f64 / (POST + 0.02)).cos());
        let (arc, links) = (PI * radius, 27);
        let point = |i: usize| {
            let way = (2.0 * along + arc) * i as f64 / links as f64;
            let angle = PI - (way - along) / radius;
            match way {
                way if way < along => DVec3::new(-radius, way - along, 0.0),
                way if way < along + arc => DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0),
                way => DVec3::new(radius, along + arc - way, 0.0),
            }
        };
        let points: Vec<DVec3> = (0..=links).map(point).collect();
        let (bodies, _) = rope(&mut world, &points, 0.5, Some((BodyId::NULL, points[0].as_vec3())));
        let half = 0.5 * (points[links] - points[links - 1]).length() as f32;
        let (load, _) = hang(&mut world, mass, bodies[links - 1], Vec3::Y * half, points[links]);
        let before = height(&world, load);
        run(&mut world, 1.5, rate);
        let (moved, speed) = (height(&world, load) - before, world.linear_velocity(load).unwrap().length());
        let deep = world.report().residuals.penetration;
        let what = format!("{mass} kg at {rate} Hz");
        assert!(moved.abs() < 1.0e-2, "{what}: the load has moved by {moved} m");
        assert!(speed < 0.02 && deep < 1.0e-4, "{what}: {speed} m/s, {deep} m deep");
    }
}

/// Euler's e^(μ φ) around half a post is 2.57 at μ = 0.3; a polygon of links of 18° holds 4 % less.
#[test]
fn a_rope_on_a_post_holds_up_to_the_ratio_that_friction_allows() {
    // The hanging parts of the rope, 6 kg each, weigh with the loads.
    for (scale, rate) in [(10.0, 60.0), (100.0, 60.0), (10.0, 120.0)] {
        for (ratio, holds) in [(2.2_f32, true), (2.9, false)] {
            let mut world = world();
            let [_, heavy] = rope_on_a_post(&mut world, 0.3, [10.0 * scale, 10.0 * scale * ratio]);
            let before = height(&world, heavy);
            run(&mut world, 1.0, rate);
            let fallen = before - height(&world, heavy);
            let expected = if holds { fallen < 5.0e-3 } else { fallen > 0.05 };
            assert!(expected, "loads of 10 × {scale} kg, 1 : {ratio} at {rate} Hz: the heavy one has fallen by {fallen} m");
        }
    }
}

#[test]
fn a_load_that_stands_is_not_lifted_by_the_slack_chain_on_it() {
    for (mass, rate) in [(1000.0_f32, 60.0_f32), (100.0, 60.0), (1000.0, 30.0)] {
        let mut world = world();
        let floor = Geometry::Box { half_extents: Vec3::new(20.0, 0.5, 20.0) };
        add(&mut world, &BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)), floor, 0.5);
        let load = cube(&mut world, mass, 0.5, DVec3::Y * 0.5, 0.5);
        let points: Vec<DVec3> = (0..=15).map(|i| DVec3::Y * (1.0 + 0.2 * f64::from(i))).collect();
        let (links, _) = rope(&mut world, &points, 0.5, Some((load, Vec3::Y * 0.5)));
        let top = points[15] + DVec3::Y * 0.1;
        let hook_box = Geometry::Box { half_extents: Vec3::splat(0.1) };
        let hook = add(&mut world, &BodyDef::kinematic(Pose::at(top)), hook_box, 0.5);
        world.create_joint(&JointDef::new(JointKind::SPHERICAL, links[14], hook).at(Vec3::Y * 0.1, Vec3::Y * -0.1)).unwrap();
        let mut highest = 0.0_f64;
        for step in 0..(2.0 * rate) as usize {
            let down = step as f64 / f64::from(rate);
            world.move_to(hook, Pose::at(top - DVec3::new(-0.1, 0.5, 0.0) * down.min(1.0))).unwrap();
            world.step(1.0 / rate).unwrap();
            highest = highest.max(height(&world, load));
        }
        assert!(highest < 0.502, "{mass} kg at {rate} Hz: the load was lifted to {highest} m");
    }
}

/// A horizontal floor, the top at zero.
fn floor(world: &mut World) {
    let half_extents = Vec3::new(20.0, 0.5, 20.0);
    add(world, &BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)), Geometry::Box { half_extents }, 0.5);
}

/// A slider between `body` and the world, along y, and its motor.
fn lift(world: &mut World, platform: BodyId, at: DVec3, motor: Motor) -> JointId {
    let upwards = Quat::from_rotation_z(0.5 * PI as f32);
    let kind = JointKind::Prismatic { limits: Limits::NONE, motor };
    let mut def = JointDef::new(kind, BodyId::NULL, platform);
    (def.frame_a, def.frame_b) = (Pose { position: at, rotation: upwards }, Pose { position: DVec3::ZERO, rotation: upwards });
    world.create_joint(&def).unwrap()
}

#[test]
fn a_lift_bears_the_weight_of_what_stands_on_it_and_rises_as_told() {
    for (mass, rate) in [(500.0, 60.0), (5.0e3, 30.0), (5.0e3, 120.0), (50.0e3, 60.0)] {
        let mut world = world();
        let at = DVec3::Y * 2.0;
        let plate = Geometry::Box { half_extents: Vec3::new(1.0, 0.1, 1.0) };
        let platform = add(&mut world, &dynamic(50.0, Pose::at(at)), plate, 0.5);
        let load = cube(&mut world, mass, 0.3, at + DVec3::Y * 0.4, 0.5);
        let motor = Motor::Velocity { target: 1.0, max_force: f32::INFINITY };
        let joint = lift(&mut world, platform, at, motor);
        run(&mut world, 1.0, rate);
        let (rise, stands) = (height(&world, platform) - at.y, height(&world, load) - height(&world, platform) - 0.4);
        let (effort, weight) = (world.joint_state(joint).unwrap().effort, 9.81 * (mass + 50.0));
        let what = format!("{mass} kg on 50 kg at {rate} Hz");
        assert!((rise - 1.0).abs() < 1.0e-3, "{what}: it has risen by {rise} m");
        assert!(stands.abs() < 1.0e-3, "{what}: the load is {stands} m above its place");
        assert!((effort / weight - 1.0).abs() < 1.0e-3, "{what}: {effort} N of {weight} N");
    }
}

/// Fingers push with 400 N each; friction of 0.6 holds 480 N, the cube asks for 196 N and as much again as it is shaken.
#[test]
fn a_gripper_of_light_fingers_holds_what_it_shakes() {
    for (finger, rate) in [(0.3, 60.0), (0.3, 30.0), (5.0, 120.0)] {
        let mut world = world();
        floor(&mut world);
        let start = DVec3::Y * 0.8;
        let palm_box = Geometry::Box { half_extents: Vec3::new(0.3, 0.05, 0.1) };
        let palm = add(&mut world, &BodyDef::kinematic(Pose::at(start)), palm_box, 0.5);
        let held = cube(&mut world, 20.0, 0.1, DVec3::Y * 0.3, 0.6);
        for side in [-1.0_f32, 1.0] {
            let geometry = Geometry::Box { half_extents: Vec3::new(0.02, 0.1, 0.08) };
            let at = DVec3::new(0.1201 * f64::from(side), 0.35, 0.0);
            let finger = add(&mut world, &dynamic(finger, Pose::at(at)), geometry, 0.6);
            let motor = Motor::Velocity { target: -0.3 * side, max_force: 400.0 };
            let kind = JointKind::Prismatic { limits: Limits::NONE, motor };
            let joint = JointDef::new(kind, palm, finger).at((at - start).as_vec3(), Vec3::ZERO);
            world.create_joint(&joint).unwrap();
        }
        // It closes while the cube falls by less than a millimetre.
        run(&mut world, 0.2, rate);
        let before = height(&world, held) - start.y;
        for step in 0..(2.0 * rate) as usize {
            let time = (step + 1) as f64 / f64::from(rate);
            let at = start + DVec3::new(0.0, 0.1 * time, 0.01 * (1.0 - (8.0 * PI * time).cos()));
            world.move_to(palm, Pose::at(at)).unwrap();
            world.step(1.0 / rate).unwrap();
        }
        let slid = height(&world, held) - world.pose(palm).unwrap().position.y - before;
        assert!(slid.abs() < 1.0e-3, "fingers of {finger} kg at {rate} Hz: it has slid by {slid} m");
    }
}

/// A hinge turns a drum of 0.4 m at 1 rad/s and winds up a rope of 0.03 m with a load: it rises by 0.43 m a second, and more as links are
/// the sides of a polygon.
#[test]
fn a_winch_lifts_what_it_winds() {
    for (mass, rate) in [(100.0, 60.0), (300.0, 120.0)] {
        let mut world = world();
        let geometry = Geometry::Cylinder { half_height: 0.4, radius: 0.4 };
        let upright = Pose { position: DVec3::ZERO, rotation: Quat::from_rotation_x(-0.5 * PI as f32) };
        let drum = add(&mut world, &dynamic(300.0, upright), geometry, 0.3);
        let about_z = Quat::from_rotation_y(-0.5 * PI as f32);
        let motor = Motor::Velocity { target: 1.0, max_force: 1.0e6 };
        let mut hinge = JointDef::new(JointKind::Hinge { limits: Limits::NONE, motor }, BodyId::NULL, drum);
        hinge.frame_a.rotation = about_z;
        hinge.frame_b.rotation = upright.rotation.conjugate() * about_z;
        world.create_joint(&hinge).unwrap();
        let points: Vec<DVec3> = (0..=30).map(|i| DVec3::new(0.42, -0.1 * f64::from(i), 0.0)).collect();
        let anchor = upright.rotation.conjugate() * points[0].as_vec3();
        let (links, _) = rope(&mut world, &points, 0.3, Some((drum, anchor)));
        let (load, _) = hang(&mut world, mass, links[29], Vec3::Y * 0.05, points[30]);
        let before = height(&world, load);
        run(&mut world, 3.0, rate);
        let (rise, deep) = (height(&world, load) - before, world.report().residuals.penetration);
        assert!((1.24..1.31).contains(&rise), "{mass} kg at {rate} Hz: it has risen by {rise} m, expected 1.26 to 1.28");
        assert!(deep < 1.0e-3, "{mass} kg at {rate} Hz: {deep} m deep");
    }
}
