//! Contacts act where surfaces meet, and nowhere else: what passes by is left alone, and what slides or rolls over one surface made of
//! many pieces moves as over one.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, Material, Pose, Shape, ShapeDef, World, WorldDef};

/// A floor of `2 * cells * cells` triangles with diagonals both ways, as a mesh or a height field.
fn grid(cells: usize, cell: f32, height: impl Fn(f32, f32) -> f32, is_field: bool) -> Shape {
    let side = cells + 1;
    let size = cells as f32 * cell;
    let coordinate = |i: usize| i as f32 * cell - 0.5 * size;
    if is_field {
        let heights = (0..side * side).map(|i| height(coordinate(i % side), coordinate(i / side))).collect();
        return Shape::new(Geometry::HeightField { rows: side, columns: side, heights, size_x: size, size_z: size }).unwrap();
    }
    let vertex = |i: usize| {
        let (x, z) = (coordinate(i / side), coordinate(i % side));
        Vec3::new(x, height(x, z), z)
    };
    let vertices = (0..side * side).map(vertex).collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
        let (a, b) = ((i * side + j) as u32, (i * side + j + 1) as u32);
        let (c, d) = (a + side as u32, b + side as u32);
        triangles.extend(if (i + j) % 2 == 1 { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] });
    }
    Shape::new(Geometry::TriangleMesh { vertices, triangles }).unwrap()
}

#[test]
fn what_lies_on_a_fine_mesh_does_not_roll_by_itself() {
    for (size, cell) in [(0.002, 0.5), (0.01, 0.5), (0.01, 2.0), (0.05, 0.5), (0.5, 0.5)] {
        for is_field in [false, true] {
            for is_cylinder in [false, true] {
                let mut world = World::new(&WorldDef { hold: false, ..WorldDef::default() }).unwrap();
                let floor = ShapeDef::new(grid(24, cell * size, |_, _| 0.0, is_field));
                world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
                let (half_height, radius) = (size, 0.6 * size);
                let round = if is_cylinder {
                    Geometry::Cylinder { half_height, radius }
                } else {
                    Geometry::Capsule { half_height, radius }
                };
                let lying = Quat::from_rotation_y(0.7) * Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
                let at = DVec3::new(0.31, 0.6, 0.17) * f64::from(size);
                let pose = Pose { position: at, rotation: lying };
                let def = BodyDef { can_sleep: false, ..BodyDef::dynamic(pose) };
                let body = world.create_body(&def.with_shape(ShapeDef::new(Shape::new(round).unwrap()))).unwrap();
                for _ in 0..300 {
                    world.step(1.0 / 60.0).unwrap();
                }
                let drift = (world.pose(body).unwrap().position - at).length() / f64::from(size);
                let what = (if is_cylinder { "cylinder" } else { "capsule" }, if is_field { "field" } else { "mesh" });
                println!("{what:?}, size {size} m, cells of {cell} sizes: drift {drift:.4} sizes");
                // What rolled by itself went several sizes in this time.
                assert!(drift < 0.1, "{what:?}, size {size} m, cells of {cell} sizes: drift {drift} sizes in 5 s");
            }
        }
    }
}

fn world(gravity: f32) -> World {
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, ..WorldDef::default() }).unwrap()
}

/// A shape without friction.
fn smooth(shape: Shape, restitution: f32) -> ShapeDef {
    let mut def = ShapeDef::new(shape);
    def.material = Material { friction: 0.0, restitution, ..Material::default() };
    def
}

/// A body flagged fast.
fn fast(world: &mut World, shape: ShapeDef, at: DVec3, velocity: Vec3) -> BodyId {
    let def = BodyDef { fast: true, linear_velocity: velocity, ..BodyDef::dynamic(Pose::at(at)) };
    world.create_body(&def.with_shape(shape)).unwrap()
}

fn position(world: &World, body: BodyId) -> DVec3 {
    world.pose(body).unwrap().position
}

#[test]
fn fast_balls_never_swap_places() {
    for (radius, restitution, speed, rate) in
        [0.008_f32, 0.0286, 0.1].into_iter().flat_map(|radius| [0.0, 0.5, 0.9].map(|e| (radius, e))).flat_map(|(radius, e)| {
            [(3.0, 60.0), (12.0, 30.0), (20.0, 60.0), (60.0, 240.0), (300.0, 60.0)].map(|(v, rate)| (radius, e, v, rate))
        })
    {
        for phase in 0..4 {
            let mut world = world(9.81);
            let floor = smooth(Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap(), 0.0);
            world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
            let at = |x: f64| DVec3::new(x, f64::from(radius), 0.0);
            // The one in front comes towards the other, rests, or runs away from it.
            let ahead = [0.0, 0.0, -0.5 * speed, 0.3 * speed][phase];
            let start = -0.5 - f64::from(speed / rate) * 0.37 * phase as f64;
            let mut ball =
                |x: f64, v: f32| fast(&mut world, smooth(Shape::ball(radius).unwrap(), restitution), at(x), Vec3::X * v);
            let (first, second, third) = (ball(start, speed), ball(0.0, ahead), ball(0.31, 0.0));
            for step in 0..60 {
                world.step(1.0 / rate).unwrap();
                let [a, b, c] = [first, second, third].map(|body| position(&world, body).x);
                assert!(
                    a < b && b < c,
                    "radius {radius} m, e {restitution}, {speed} m/s, {rate} Hz, step {step}: balls at {a}, {b}, {c} m"
                );
            }
        }
    }
}

#[test]
fn nothing_fast_passes_a_bat() {
    for (bat_speed, rate) in [(0.0, 60.0), (5.0, 60.0), (20.0, 60.0), (30.0, 30.0), (30.0, 240.0), (100.0, 60.0)] {
        for (is_driven, is_box) in [(false, false), (true, false), (false, true), (true, true)] {
            for phase in 0..5 {
                let mut world = world(0.0);
                let bat = smooth(Shape::cuboid(Vec3::new(0.015, 0.15, 0.1)).unwrap(), 1.0);
                let velocity = if is_driven { Vec3::ZERO } else { Vec3::NEG_X * bat_speed };
                let def = BodyDef { linear_velocity: velocity, ..BodyDef::kinematic(Pose::at(DVec3::X * 1.5)) };
                let bat = world.create_body(&def.with_shape(bat)).unwrap();
                let shape = if is_box { Shape::cuboid(Vec3::splat(0.02)) } else { Shape::ball(0.02) }.unwrap();
                let start = DVec3::new(-1.0 - 0.19 * f64::from(phase), 0.0, 0.0);
                let ball = fast(&mut world, smooth(shape, 1.0), start, Vec3::X * 30.0);
                for step in 1..=(0.25 * rate) as u32 {
                    if is_driven {
                        let x = 1.5 - f64::from(bat_speed * step as f32 / rate);
                        world.move_to(bat, Pose::at(DVec3::X * x)).unwrap();
                    }
                    world.step(1.0 / rate).unwrap();
                    let (ball, bat) = (position(&world, ball).x, position(&world, bat).x);
                    assert!(
                        ball < bat,
                        "bat at {bat_speed} m/s, {rate} Hz, box {is_box}, phase {phase}: ball at {ball} m, bat at {bat} m"
                    );
                }
                let speed = world.linear_velocity(ball).unwrap().x;
                let expected = -(30.0 + 2.0 * bat_speed);
                assert!(
                    (speed / expected - 1.0).abs() < 0.01,
                    "bat at {bat_speed} m/s, {rate} Hz: {speed} m/s, not {expected} m/s"
                );
            }
        }
    }
}

#[test]
fn a_swung_bat_does_not_pass_what_floats_in_its_way() {
    for (spin, rate) in [(5.0_f32, 60.0), (20.0, 60.0), (40.0, 60.0), (40.0, 240.0)] {
        for lever in [0.2, 0.5, 0.9] {
            let mut world = world(0.0);
            let def = BodyDef { angular_velocity: Vec3::Y * spin, ..BodyDef::kinematic(Pose::IDENTITY) };
            let bat =
                world.create_body(&def.with_shape(smooth(Shape::cuboid(Vec3::new(1.0, 0.1, 0.015)).unwrap(), 0.0))).unwrap();
            let at = Quat::from_rotation_y(1.3).as_dquat() * DVec3::X * lever;
            let ball = fast(&mut world, smooth(Shape::ball(0.02).unwrap(), 0.0), at, Vec3::ZERO);
            let mut ahead = f64::INFINITY;
            for _ in 0..(1.5 / spin * rate) as u32 {
                world.step(1.0 / rate).unwrap();
                // The bat's face that comes first looks to where it turns, along −z at the start.
                let (seen, turn) = (position(&world, ball), world.pose(bat).unwrap().rotation);
                ahead = ahead.min(-(turn.as_dquat().conjugate() * seen).z);
            }
            assert!(ahead > 0.0, "{spin} rad/s, {rate} Hz, lever {lever} m: the ball ends {ahead} m before the bat");
        }
    }
}

#[test]
fn what_is_fast_rolls_on_over_what_it_rests_on() {
    for (speed, rate) in [(2.0, 60.0), (8.0, 60.0), (40.0, 60.0), (40.0, 240.0)] {
        for is_mesh in [false, true] {
            let mut world = world(9.81);
            let floor = if is_mesh {
                grid(60, 1.0, |_, _| 0.0, false)
            } else {
                Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap()
            };
            world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(smooth(floor, 0.0))).unwrap();
            let start = DVec3::new(-25.0, 0.1, 0.3);
            let ball = fast(&mut world, smooth(Shape::ball(0.1).unwrap(), 0.0), start, Vec3::X * speed);
            for _ in 0..rate as u32 {
                world.step(1.0 / rate).unwrap();
            }
            let way = (position(&world, ball) - start).x;
            assert!((way / f64::from(speed) - 1.0).abs() < 1.0e-3, "{speed} m/s, {rate} Hz, mesh {is_mesh}: {way} m in a second");
        }
    }
}
