//! What is put down lies still, what rolls goes on rolling, and thin things carry and stop what meets them, at any size.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, LocalPose, Material, Pose, Shape, ShapeDef, World, WorldDef};

fn world(gravity: f32) -> World {
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, ..WorldDef::default() }).unwrap()
}

fn shape(geometry: Geometry, friction: f32) -> ShapeDef {
    let mut def = ShapeDef::new(Shape::new(geometry).unwrap());
    def.material = Material { friction, ..Material::default() };
    def
}

fn cuboid(x: f32, y: f32, z: f32) -> Geometry {
    Geometry::Box { half_extents: Vec3::new(x, y, z) }
}

fn hull(x: f32, y: f32, z: f32) -> Geometry {
    let sign = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
    let points = (0..8).map(|i| Vec3::new(x * sign(i & 1), y * sign(i & 2), z * sign(i & 4)));
    Geometry::ConvexHull { points: points.collect() }
}

fn part(at: Vec3, geometry: Geometry) -> (LocalPose, Geometry) {
    (LocalPose { position: at, rotation: Quat::IDENTITY }, geometry)
}

/// A flat surface of ten by ten cells of this size about the origin.
fn sheet(cell: f32, is_field: bool) -> Geometry {
    const SIDE: usize = 11;
    if is_field {
        let size = 10.0 * cell;
        return Geometry::HeightField { rows: SIDE, columns: SIDE, heights: vec![0.0; SIDE * SIDE], size_x: size, size_z: size };
    }
    let vertices = (0..SIDE * SIDE).map(|i| Vec3::new((i / SIDE) as f32 - 5.0, 0.0, (i % SIDE) as f32 - 5.0) * cell).collect();
    let corners = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE).map(|i| i as u32);
    let (one, row) = (1, SIDE as u32);
    let triangles = corners.flat_map(|a| [[a, a + one, a + row], [a + one, a + row + one, a + row]]).collect();
    Geometry::TriangleMesh { vertices, triangles }
}

/// Supports whose top is at height zero, each with the height of its origin.
fn supports(size: f32) -> Vec<(&'static str, Geometry, f32)> {
    let halves = [-1.5, 1.5].map(|x| part(Vec3::X * (x * size + 0.1 * size), cuboid(1.5 * size, 0.5 * size, 3.0 * size)));
    vec![
        ("half-space", Geometry::HalfSpace { normal: Vec3::Y }, 0.0),
        ("box", cuboid(3.0 * size, 0.5 * size, 3.0 * size), -0.5 * size),
        ("hull", hull(3.0 * size, 0.5 * size, 3.0 * size), -0.5 * size),
        ("cylinder", Geometry::Cylinder { half_height: 0.5 * size, radius: 3.0 * size }, -0.5 * size),
        ("slab", cuboid(3.0 * size, 0.02 * size, 3.0 * size), -0.02 * size),
        ("mesh", sheet(0.7 * size, false), 0.0),
        ("field", sheet(0.7 * size, true), 0.0),
        ("compound", Geometry::Compound { parts: halves.into() }, -0.5 * size),
    ]
}

/// Shapes as they stand or lie, each with the height of its origin.
fn solids(size: f32) -> Vec<(&'static str, Geometry, f32, Quat)> {
    let lying = Quat::from_rotation_y(0.4) * Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let leg = |x: f32, z: f32| part(Vec3::new(x, -0.25, z) * size, cuboid(0.06 * size, 0.2 * size, 0.06 * size));
    let mut table = vec![part(Vec3::Y * (0.0 * size), cuboid(0.5 * size, 0.05 * size, 0.4 * size))];
    table.extend([leg(-0.4, -0.3), leg(0.4, -0.3), leg(0.4, 0.3), leg(-0.4, 0.3)]);
    vec![
        ("ball", Geometry::Ball { radius: 0.4 * size }, 0.4 * size, Quat::IDENTITY),
        ("capsule", Geometry::Capsule { half_height: 0.4 * size, radius: 0.2 * size }, 0.2 * size, lying),
        ("cylinder", Geometry::Cylinder { half_height: 0.4 * size, radius: 0.3 * size }, 0.4 * size, Quat::IDENTITY),
        ("cone", Geometry::Cone { half_height: 0.4 * size, radius: 0.3 * size }, 0.4 * size, Quat::IDENTITY),
        ("box", cuboid(0.3 * size, 0.2 * size, 0.4 * size), 0.2 * size, Quat::from_rotation_y(0.3)),
        ("hull", hull(0.3 * size, 0.2 * size, 0.4 * size), 0.2 * size, Quat::from_rotation_y(0.3)),
        ("table", Geometry::Compound { parts: table }, 0.45 * size, Quat::from_rotation_y(0.3)),
    ]
}

fn put(world: &mut World, shape: ShapeDef, at: DVec3, turned: Quat) -> BodyId {
    let def = BodyDef { can_sleep: false, ..BodyDef::dynamic(Pose { position: at, rotation: turned }) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

#[test]
fn every_shape_rests_on_every_support_at_every_size() {
    for size in [0.01_f32, 0.1, 1.0, 10.0] {
        for (on, support, depth) in supports(size) {
            for (name, solid, height, turned) in solids(size) {
                let mut world = world(9.81);
                let floor = BodyDef::fixed(Pose::at(DVec3::Y * f64::from(depth)));
                world.create_body(&floor.with_shape(shape(support.clone(), 0.6))).unwrap();
                let at = DVec3::new(0.13 * f64::from(size), f64::from(height), 0.07 * f64::from(size));
                let body = put(&mut world, shape(solid, 0.6), at, turned);
                for _ in 0..120 {
                    world.step(1.0 / 60.0).unwrap();
                }
                let pose = world.pose(body).unwrap();
                let off = (pose.position - at).length() / f64::from(size);
                let tilt = (pose.rotation * turned.inverse()).xyz().length();
                let speed = world.linear_velocity(body).unwrap().length() / (9.81 * size).sqrt();
                // Nothing slows what can roll: a ball and a lying capsule keep the little speed that rounding gives them.
                let (most_off, most_tilt) = if ["ball", "capsule"].contains(&name) { (0.05, 0.1) } else { (4.0e-3, 4.0e-3) };
                assert!(
                    off < most_off && speed < 2.0e-3 && tilt < most_tilt,
                    "{name} on {on}, size {size} m: {off} sizes off after 2 s, turned by {tilt}, at {speed} of √(g size)"
                );
            }
        }
    }
}

#[test]
fn what_rolls_goes_on_rolling_over_meshes_fields_and_parts() {
    for (on, support, depth) in supports(4.0).into_iter().filter(|(on, ..)| ["mesh", "field", "compound", "slab"].contains(on)) {
        for is_wheel in [false, true] {
            for (speed, rate) in [(1.0_f32, 60.0_f32), (4.0, 30.0), (4.0, 60.0), (4.0, 240.0)] {
                let mut world = world(9.81);
                let floor = BodyDef::fixed(Pose::at(DVec3::Y * f64::from(depth)));
                world.create_body(&floor.with_shape(shape(support.clone(), 1.0))).unwrap();
                let (radius, axle) = (0.3, Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
                let (round, turned) = match is_wheel {
                    true => (Geometry::Cylinder { half_height: 0.1, radius }, axle),
                    false => (Geometry::Ball { radius }, Quat::IDENTITY),
                };
                let start = DVec3::new(-5.0, f64::from(radius), 0.4);
                let body = put(&mut world, shape(round, 1.0), start, turned);
                let (along, spin) = (Vec3::X * speed, Vec3::NEG_Z * (speed / radius));
                world.set_linear_velocity(body, along).unwrap();
                world.set_angular_velocity(body, spin).unwrap();
                for _ in 0..(8.0 / speed * rate) as usize {
                    world.step(1.0 / rate).unwrap();
                }
                let off = (world.linear_velocity(body).unwrap() - along).length() / speed;
                let slip = (world.angular_velocity(body).unwrap() - spin).length() * radius / speed;
                let aside = (world.pose(body).unwrap().position - start).z.abs();
                assert!(
                    off < 0.02 && slip < 0.02 && aside < 0.05,
                    "wheel {is_wheel} on {on}, {speed} m/s, {rate} Hz: off by {off} of its speed, {slip} of its spin, {aside} m aside in 8 m"
                );
            }
        }
    }
}

#[test]
fn spinning_friction_stops_a_top_when_it_should() {
    for (size, rate) in [(0.05_f32, 60.0_f32), (0.5, 60.0), (0.5, 240.0), (5.0, 30.0)] {
        let mut world = world(9.81);
        // Torque s m g on 2/5 m r²: the spin ω ends after 2 r² ω / (5 s g).
        let (radius, arm) = (size, 0.02 * size);
        let material = Material { friction: 0.5, spinning_friction: arm, ..Material::default() };
        let with_material = |geometry: Geometry| {
            let mut def = shape(geometry, 0.5);
            def.material = material;
            def
        };
        let floor = with_material(Geometry::HalfSpace { normal: Vec3::Y });
        world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
        let body = put(&mut world, with_material(Geometry::Ball { radius }), DVec3::Y * f64::from(radius), Quat::IDENTITY);
        let slowing = arm * 9.81 / (0.4 * radius * radius);
        let spin = 1.5 * slowing;
        world.set_angular_velocity(body, Vec3::Y * spin).unwrap();
        for _ in 0..rate as u32 {
            world.step(1.0 / rate).unwrap();
        }
        let left = world.angular_velocity(body).unwrap().y / spin;
        assert!((left - 1.0 / 3.0).abs() < 0.01, "{size} m, {rate} Hz: {left} of the spin is left after two thirds of its time");
        for _ in 0..rate as u32 {
            world.step(1.0 / rate).unwrap();
        }
        let left = world.angular_velocity(body).unwrap().length() / spin;
        assert!(left < 1.0e-3, "{size} m, {rate} Hz: {left} of the spin is left");
    }
}

#[test]
fn a_peg_stands_on_a_cube() {
    for size in [0.02_f32, 0.2, 2.0] {
        for rate in [30.0_f32, 60.0, 240.0] {
            let mut world = world(9.81);
            world
                .create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(shape(Geometry::HalfSpace { normal: Vec3::Y }, 0.6)))
                .unwrap();
            let scale = f64::from(size);
            put(&mut world, shape(cuboid(0.5 * size, 0.5 * size, 0.5 * size), 0.6), DVec3::Y * (0.5 * scale), Quat::IDENTITY);
            let peg = Geometry::Cylinder { half_height: 0.5 * size, radius: 0.06 * size };
            let at = DVec3::new(0.3, 1.5, -0.2) * scale;
            let peg = put(&mut world, shape(peg, 0.6), at, Quat::IDENTITY);
            for _ in 0..(4.0 * rate) as usize {
                world.step(1.0 / rate).unwrap();
            }
            let off = (world.pose(peg).unwrap().position - at).length() / scale;
            assert!(off < 5.0e-3, "size {size} m, {rate} Hz: the peg is {off} sizes off after 4 s");
        }
    }
}

#[test]
fn what_is_fast_is_stopped_by_thin_walls() {
    for (speed, rate) in [(5.0_f32, 30.0_f32), (30.0, 60.0), (100.0, 60.0), (300.0, 240.0)] {
        for thickness in [0.002_f32, 0.02] {
            let walls = [cuboid(thickness, 2.0, 2.0), hull(thickness, 2.0, 2.0)];
            let compound =
                Geometry::Compound { parts: [-1.0, 1.0].map(|z| part(Vec3::Z * z, cuboid(thickness, 2.0, 1.0))).into() };
            for wall in walls.into_iter().chain([compound]) {
                for (name, solid, ..) in solids(0.3) {
                    for phase in 0..3 {
                        let mut world = world(0.0);
                        world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(shape(wall.clone(), 0.0))).unwrap();
                        let start = DVec3::new(-1.0 - f64::from(speed / rate) * 0.31 * f64::from(phase), 0.1, 0.2);
                        let pose = Pose { position: start, rotation: Quat::from_rotation_y(0.3 * phase as f32) };
                        let def = BodyDef { fast: true, linear_velocity: Vec3::X * speed, ..BodyDef::dynamic(pose) };
                        let body = world.create_body(&def.with_shape(shape(solid.clone(), 0.0))).unwrap();
                        for _ in 0..(3.0 * rate / speed) as usize + 8 {
                            world.step(1.0 / rate).unwrap();
                        }
                        let x = world.pose(body).unwrap().position.x;
                        assert!(
                            x < 0.0,
                            "{name}, wall of {thickness} m, {speed} m/s, {rate} Hz, phase {phase}: at {x} m, behind the wall"
                        );
                    }
                }
            }
        }
    }
}

/// Where the pressed points of something that has been thrown on a floor hang in the air when it has come to rest, over its size.
fn greatest_gap_at_rest(form: &str, size: f32, rate: f32, throw: u32) -> f32 {
    let mut world = world(9.81);
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(shape(Geometry::HalfSpace { normal: Vec3::Y }, 0.4))).unwrap();
    let geometry = match form {
        "coin" => Geometry::Cylinder { half_height: 0.04 * size, radius: 0.5 * size },
        "cone" => Geometry::Cone { half_height: 0.4 * size, radius: 0.4 * size },
        "plate" => cuboid(0.5 * size, 0.04 * size, 0.5 * size),
        _ => cuboid(0.5 * size, 0.5 * size, 0.5 * size),
    };
    let turn =
        Quat::from_euler(longspan::glam::EulerRot::XYZ, 0.7 + 0.9 * throw as f32, 0.4 * throw as f32, 1.1 + 0.6 * throw as f32);
    let mut def = BodyDef::dynamic(Pose::at(DVec3::Y * f64::from(1.6 * size)).rotated(turn)).with_shape(shape(geometry, 0.4));
    def.linear_velocity = Vec3::X * size.sqrt() * 0.5;
    let body = world.create_body(&def).unwrap();
    for _ in 0..(8.0 * rate) as u32 {
        world.step(1.0 / rate).unwrap();
    }
    let points = world.contacts_of(body).unwrap().flat_map(|contact| contact.points().to_vec()).collect::<Vec<_>>();
    let pressed = points.iter().filter(|point| point.normal_force > 0.0);
    pressed.fold(0.0_f32, |most, point| most.max(point.separation)) / size
}

#[test]
fn what_has_been_thrown_lies_on_the_points_that_bear_it() {
    for form in ["coin", "cone", "plate", "cube"] {
        for (size, rate) in [(0.1_f32, 60.0_f32), (0.1, 240.0), (0.5, 30.0), (0.5, 60.0), (0.03, 60.0)] {
            // What a substep of free fall closes may stay open, more at the end of a lever.
            let bound = 3.0 * 9.81 / (4.0 * rate).powi(2) / size + 1.0e-3;
            for throw in 0..6 {
                let gap = greatest_gap_at_rest(form, size, rate, throw);
                // Points that had inherited their load bore it where they were: coins of 10 cm 11 mm above the floor.
                assert!(gap < bound, "{form} of {size} m at {rate} Hz, throw {throw}: bears at {gap} of its size, bound {bound}");
            }
        }
    }
}
