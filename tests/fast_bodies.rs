//! Bodies flagged fast stay on their side of what they meet: of walls that rest, move, turn or fly, of meshes, and of each other.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, LocalPose, Material, Pose, Shape, ShapeDef, World, WorldDef};

/// Deterministic numbers from 0 to 1.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn direction(&mut self) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| self.next() - 0.5)).normalize()
    }

    fn rotation(&mut self) -> Quat {
        Quat::from_axis_angle(self.direction(), 3.0 * self.next())
    }
}

fn world(gravity: f32) -> World {
    World::new(&WorldDef { gravity: Vec3::NEG_Y * gravity, ..WorldDef::default() }).unwrap()
}

fn surface(shape: Shape, friction: f32, restitution: f32) -> ShapeDef {
    ShapeDef { material: Material { friction, restitution, ..Material::default() }, ..ShapeDef::new(shape) }
}

/// Shapes of about this size (m).
fn solids(size: f32) -> [(&'static str, Shape); 5] {
    let half = 0.5 * size;
    [
        ("ball", Shape::ball(half).unwrap()),
        ("box", Shape::cuboid(Vec3::splat(half)).unwrap()),
        ("capsule", Shape::new(Geometry::Capsule { half_height: size, radius: half }).unwrap()),
        ("plank", Shape::cuboid(Vec3::new(2.0 * size, half, 0.5 * half)).unwrap()),
        ("cylinder", Shape::new(Geometry::Cylinder { half_height: half, radius: half }).unwrap()),
    ]
}

/// A closed room of 20 cm and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Room {
    Boxes,
    Mesh,
    Turning,
    Shaken,
    Falling,
}

/// Half the width of the room, and the thickness of its walls (m).
const HALF: f32 = 0.1;
const WALL: f32 = 1.0e-3;

impl Room {
    fn build(self, world: &mut World, restitution: f32) -> BodyId {
        let walls = (0..6).map(|side| {
            let mut half = Vec3::splat(HALF + WALL);
            half[side / 2] = 0.5 * WALL;
            let mut at = Vec3::ZERO;
            at[side / 2] = (HALF + 0.5 * WALL) * if side % 2 == 0 { -1.0 } else { 1.0 };
            ShapeDef {
                local_pose: LocalPose { position: at, rotation: Quat::IDENTITY },
                density: 1.0e5,
                ..surface(Shape::cuboid(half).unwrap(), 0.3, restitution)
            }
        });
        let def = match self {
            Self::Boxes | Self::Mesh => BodyDef::fixed(Pose::IDENTITY),
            Self::Turning => BodyDef { angular_velocity: Vec3::Z * 5.0, ..BodyDef::kinematic(Pose::IDENTITY) },
            Self::Shaken => BodyDef::kinematic(Pose::IDENTITY),
            Self::Falling => BodyDef::dynamic(Pose::IDENTITY),
        };
        let def = if self == Self::Mesh {
            let vertices = (0..8).map(|corner| {
                Vec3::from_array(std::array::from_fn(|axis| HALF * if corner >> axis & 1 == 1 { 1.0 } else { -1.0 }))
            });
            let triangles = (0..6_u32).flat_map(|side| {
                let (axis, far) = (side / 2, side % 2);
                let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
                let corner = far << axis;
                let [a, b, c, d] = [corner, corner | u, corner | v, corner | u | v];
                if far == 0 { [[a, b, c], [b, d, c]] } else { [[a, c, b], [b, c, d]] }
            });
            let mesh = Geometry::TriangleMesh { vertices: vertices.collect(), triangles: triangles.collect() };
            def.with_shape(surface(Shape::new(mesh).unwrap(), 0.3, restitution))
        } else {
            walls.fold(def, BodyDef::with_shape)
        };
        world.create_body(&def).unwrap()
    }
}

#[test]
fn what_is_fast_stays_in_a_room_of_thin_walls() {
    const BODIES: usize = 30;
    let mut draw = Draw(7);
    for room in [Room::Boxes, Room::Mesh, Room::Turning, Room::Shaken, Room::Falling] {
        for (kind, (rate, speed)) in
            (0..5).cycle().zip([30.0_f32, 60.0, 240.0].into_iter().flat_map(|rate| [5.0_f32, 40.0, 400.0].map(|v| (rate, v))))
        {
            let restitution = if kind % 2 == 0 { 0.0 } else { 0.9 };
            let (mut world, (name, shape)) = (world(9.81), &solids(0.006)[kind]);
            let walls = room.build(&mut world, restitution);
            let bodies: Vec<BodyId> = (0..BODIES)
                .map(|i| {
                    let at = DVec3::new((i % 5) as f64 - 2.0, (i / 5 % 3) as f64 - 1.0, (i / 15) as f64 - 0.5) * 0.03;
                    let def = BodyDef { fast: true, linear_velocity: draw.direction() * speed, ..BodyDef::dynamic(Pose::at(at)) };
                    world.create_body(&def.with_shape(surface(shape.clone(), 0.3, restitution))).unwrap()
                })
                .collect();
            for step in 1..=(0.25 * rate) as u32 {
                if room == Room::Shaken {
                    let height = 0.3 * f64::from(20.0 * step as f32 / rate).sin();
                    world.move_to(walls, Pose::at(DVec3::Y * height)).unwrap();
                }
                world.step(1.0 / rate).unwrap();
            }
            let around = world.pose(walls).unwrap();
            let is_out = |&&body: &&BodyId| {
                let seen = around.rotation.as_dquat().conjugate() * (world.pose(body).unwrap().position - around.position);
                seen.abs().max_element() > f64::from(HALF)
            };
            let out = bodies.iter().filter(is_out).count();
            assert!(out == 0, "{room:?}, {name}s at {speed} m/s, {rate} Hz: {out} of {BODIES} outside, none allowed");
        }
    }
}

/// A hollow cube of this width (m) that is flagged fast, falls, turns and comes to lie, with things in it that are not.
fn thrown_crate(width: f32, shape: &Shape, density: f32, rate: f32) -> usize {
    let mut world = world(9.81);
    world
        .create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(surface(
            Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap(),
            0.5,
            0.0,
        )))
        .unwrap();
    let (half, wall, quick) = (0.5 * width, 0.04 * width, width.sqrt());
    let walls = (0..6).map(|side| {
        let mut extents = Vec3::splat(half + wall);
        extents[side / 2] = 0.5 * wall;
        let mut position = Vec3::ZERO;
        position[side / 2] = (half + 0.5 * wall) * if side % 2 == 0 { -1.0 } else { 1.0 };
        let shape = surface(Shape::cuboid(extents).unwrap(), 0.4, 0.0);
        ShapeDef { local_pose: LocalPose { position, rotation: Quat::IDENTITY }, ..shape }
    });
    let (at, linear_velocity) = (DVec3::Y * f64::from(3.0 * width), Vec3::X * 2.0 * quick);
    let angular_velocity = Vec3::new(4.0, -3.0, 10.0) / quick;
    let def = BodyDef { fast: true, linear_velocity, angular_velocity, ..BodyDef::dynamic(Pose::at(at)) };
    let crate_body = world.create_body(&walls.fold(def, BodyDef::with_shape)).unwrap();
    let things: Vec<BodyId> = (0..8)
        .map(|corner| {
            let place = Vec3::from_array(std::array::from_fn(|axis| if corner >> axis & 1 == 1 { 0.25 } else { -0.25 })) * width;
            let def = BodyDef { linear_velocity, ..BodyDef::dynamic(Pose::at(at + place.as_dvec3())) };
            let part = ShapeDef { density, ..surface(shape.clone(), 0.4, 0.0) };
            world.create_body(&def.with_shape(part)).unwrap()
        })
        .collect();
    for _ in 0..(3.0 * rate) as u32 {
        world.step(1.0 / rate).unwrap();
    }
    let around = world.pose(crate_body).unwrap();
    let is_out = |&&body: &&BodyId| {
        let seen = around.rotation.as_dquat().conjugate() * (world.pose(body).unwrap().position - around.position);
        seen.abs().max_element() > f64::from(half)
    };
    things.iter().filter(is_out).count()
}

#[test]
fn a_fast_crate_keeps_what_is_in_it() {
    for width in [0.05_f32, 0.3, 1.0] {
        for (name, shape) in solids(0.15 * width).into_iter().filter(|(name, _)| ["ball", "box", "cylinder"].contains(name)) {
            for (density, rate) in [100.0, 1000.0, 1.0e4].into_iter().flat_map(|d| [30.0, 60.0, 120.0].map(|rate| (d, rate))) {
                let out = thrown_crate(width, &shape, density, rate);
                assert!(out == 0, "{name}s of {density} kg/m³ in a crate of {width} m at {rate} Hz: {out} of 8 outside");
            }
        }
    }
}

#[test]
fn what_is_fast_and_long_does_not_pass_a_wall_however_it_turns() {
    let mut draw = Draw(11);
    for (speed, rate) in [(20.0_f32, 30.0_f32), (60.0, 60.0), (400.0, 120.0), (9900.0, 30.0)] {
        for size in [0.002_f32, 0.02, 0.3] {
            for (name, shape) in solids(size) {
                for wall_speed in [0.0, 5.0] {
                    let mut world = world(0.0);
                    let wall = surface(Shape::cuboid(Vec3::new(9.0, 5.0e-4, 9.0)).unwrap(), 0.0, 0.5);
                    let def = BodyDef { linear_velocity: Vec3::Y * wall_speed, ..BodyDef::kinematic(Pose::IDENTITY) };
                    let wall = world.create_body(&def.with_shape(wall)).unwrap();
                    let way = f64::from((speed + wall_speed) / rate) * f64::from(0.3 + 2.0 * draw.next());
                    let start = Pose { position: DVec3::new(0.12, 3.0 * f64::from(size) + way, 0.07), rotation: draw.rotation() };
                    let def = BodyDef { fast: true, linear_velocity: Vec3::NEG_Y * speed, ..BodyDef::dynamic(start) };
                    let body = world.create_body(&def.with_shape(surface(shape.clone(), 0.0, 0.5))).unwrap();
                    for _ in 0..8 {
                        world.step(1.0 / rate).unwrap();
                    }
                    let above = (world.pose(body).unwrap().position - world.pose(wall).unwrap().position).y;
                    assert!(
                        above > 0.0,
                        "{name} of {size} m at {speed} m/s, wall at {wall_speed} m/s, {rate} Hz: ends {above} m above the wall"
                    );
                }
            }
        }
    }
}

/// Turned by 41 rad in a substep, a body of a gram once got a rotation that was no number, and left the world.
#[test]
fn no_spin_below_the_limit_makes_a_body_leave_the_world() {
    for spin in [500.0_f32, 5000.0, 9900.0] {
        for (name, shape) in solids(0.002) {
            let mut world = world(9.81);
            let floor = surface(Shape::cuboid(Vec3::new(1.0, 0.1, 1.0)).unwrap(), 0.3, 0.5);
            world.create_body(&BodyDef::fixed(Pose::at(DVec3::Y * -0.1)).with_shape(floor)).unwrap();
            let def = BodyDef {
                angular_velocity: Vec3::new(0.4, -0.2, 0.9).normalize() * spin,
                ..BodyDef::dynamic(Pose::at(DVec3::Y * 0.005))
            };
            let body = world.create_body(&def.with_shape(surface(shape, 0.3, 0.5))).unwrap();
            for _ in 0..10 {
                world.step(1.0 / 30.0).unwrap();
                assert!(world.quarantined().is_empty(), "{name} at {spin} rad/s has left the world");
            }
            assert!(world.pose(body).unwrap().position.is_finite());
        }
    }
}

#[test]
fn what_stands_on_end_meets_triangles_of_any_size() {
    for cell in [0.01_f32, 0.5, 20.0, 500.0] {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, z)| Vec3::new(x, 0.0, z) * cell);
        let mesh = Geometry::TriangleMesh { vertices: corners.to_vec(), triangles: vec![[0, 2, 1], [1, 2, 3]] };
        for (name, shape, height) in [
            ("capsule", Geometry::Capsule { half_height: 0.002, radius: 0.001 }, 0.003),
            ("cone on its tip", Geometry::Cone { half_height: 0.002, radius: 0.001 }, 0.002),
        ] {
            for tilt in [0.0_f32, 0.3, 0.7] {
                let mut world = world(0.0);
                let floor = surface(Shape::new(mesh.clone()).unwrap(), 0.0, 0.0);
                world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
                let over = if name == "capsule" { 0.002 * tilt.cos() + 0.001 } else { height * tilt.cos() };
                let upside = if name == "capsule" { 0.0 } else { std::f32::consts::PI };
                let at = DVec3::new(0.2 * f64::from(cell), f64::from(over) + 1.0e-5, 0.3 * f64::from(cell));
                let start = Pose { position: at, rotation: Quat::from_rotation_x(upside + tilt) };
                let def = BodyDef { linear_velocity: Vec3::NEG_Y, ..BodyDef::dynamic(start) };
                let body = world.create_body(&def.with_shape(surface(Shape::new(shape.clone()).unwrap(), 0.0, 0.0))).unwrap();
                world.step(1.0 / 240.0).unwrap();
                let tip = world.linear_velocity(body).unwrap().y;
                assert!(tip > -0.9, "{name} tilted by {tilt} rad on triangles of {cell} m: still falls at {tip} of -1 m/s");
            }
        }
    }
}

/// A floor through the origin whose pieces are as wide as `cell` (m).
fn lay_floor(world: &mut World, kind: &str, cell: f32) {
    let count = 10_u16;
    let cube = || Shape::cuboid(Vec3::splat(0.5 * cell)).unwrap();
    let places = || {
        let middle = move |i: u16| (f32::from(i) - 0.5 * f32::from(count) + 0.5) * cell;
        (0..count * count).map(move |place| Vec3::new(middle(place / count), -0.5 * cell, middle(place % count)))
    };
    let flat = vec![0.0; usize::from((count + 1) * (count + 1))];
    let width = f32::from(count) * cell;
    let shapes: Vec<ShapeDef> = match kind {
        "one box" => {
            let whole = Shape::cuboid(Vec3::new(0.5 * width, 0.5, 0.5 * width)).unwrap();
            vec![ShapeDef { local_pose: LocalPose::at(Vec3::NEG_Y * 0.5), ..ShapeDef::new(whole) }]
        }
        "boxes" => places().map(|at| ShapeDef { local_pose: LocalPose::at(at), ..ShapeDef::new(cube()) }).collect(),
        "parts" => {
            let parts = places().map(|at| (LocalPose::at(at), cube().geometry().clone())).collect();
            vec![ShapeDef::new(Shape::new(Geometry::Compound { parts }).unwrap())]
        }
        _ => {
            let (rows, columns) = (usize::from(count) + 1, usize::from(count) + 1);
            let field = Geometry::HeightField { rows, columns, heights: flat, size_x: width, size_z: width };
            vec![ShapeDef::new(Shape::new(field).unwrap())]
        }
    };
    let def = shapes.into_iter().fold(BodyDef::fixed(Pose::at(DVec3::ZERO)), BodyDef::with_shape);
    world.create_body(&def).unwrap();
}

#[test]
fn what_is_thrown_onto_a_floor_and_not_flagged_does_not_fall_through() {
    // Up to 3 m/s and 50 rad/s: twenty radii in a step of the smallest. A hit on a corner turns them half round within the step.
    let (mut runs, mut fallen) = (0, Vec::new());
    for (floor, rate) in
        ["one box", "boxes", "parts", "field"].into_iter().flat_map(|floor| [30.0, 60.0, 120.0].map(|rate| (floor, rate)))
    {
        for size in [0.005_f32, 0.016, 0.05] {
            let mut draw = Draw(7);
            for (name, shape) in solids(size).iter().cycle().take(40) {
                let cell = size * (1.0 + 10.0 * draw.next());
                let mut world = world(9.81);
                lay_floor(&mut world, floor, cell);
                let at = Vec3::new(draw.next() - 0.5, 0.0, draw.next() - 0.5) * cell + Vec3::Y * size * (1.5 + 3.0 * draw.next());
                let def = BodyDef {
                    linear_velocity: draw.direction() * 0.3 - Vec3::Y * 3.0 * draw.next(),
                    angular_velocity: draw.direction() * 50.0 * draw.next(),
                    ..BodyDef::dynamic(Pose::at(at.as_dvec3()).rotated(draw.rotation()))
                };
                let body = world.create_body(&def.with_shape(ShapeDef::new(shape.clone()))).unwrap();
                let mut depth = 0.0_f64;
                for _ in 0..rate as u32 {
                    world.step(1.0 / rate).unwrap();
                    let place = world.pose(body).unwrap().position;
                    if place.abs().with_y(0.0).max_element() < 4.5 * f64::from(cell) {
                        depth = depth.max(-place.y / f64::from(size));
                    }
                }
                runs += 1;
                if depth > 0.0 {
                    fallen.push(format!("{name} of {size} m on {floor}, {rate} Hz: {depth:.2}"));
                }
            }
        }
    }
    // Before such bodies were swept, 45 of 1440.
    assert!(fallen.is_empty(), "{} of {runs}: {fallen:?}", fallen.len());
}

/// A wide paddle of this half width (m) that the host turns, or a door of much mass that turns by itself, and a body at rest in its way; greatest
/// speed that the body gets, over that of the edge of the paddle times √2.
fn thrown_by_paddle(shape: &Shape, half: f32, spin: f32, (rate, is_door): (f32, bool), draw: &mut Draw) -> f32 {
    let mut world = world(0.0);
    let paddle = surface(Shape::cuboid(Vec3::new(half, half, half / 60.0)).unwrap(), 0.3, 0.0);
    let def = match is_door {
        true => BodyDef::dynamic(Pose::IDENTITY).with_shape(ShapeDef { density: 1.0e6, ..paddle }),
        false => BodyDef::kinematic(Pose::IDENTITY).with_shape(paddle),
    };
    world.create_body(&BodyDef { angular_velocity: Vec3::X * spin, ..def }).unwrap();
    let at = Vec3::new(1.3 * draw.next() - 0.65, 1.3 * draw.next() - 0.65, 0.2 + 0.5 * draw.next()) * half;
    let def = BodyDef { fast: true, ..BodyDef::dynamic(Pose::at(at.as_dvec3()).rotated(draw.rotation())) };
    let body = world.create_body(&def.with_shape(surface(shape.clone(), 0.3, 0.0))).unwrap();
    let mut fastest = 0.0_f32;
    for _ in 0..(8.0 / spin * rate) as usize {
        world.step(1.0 / rate).unwrap();
        fastest = fastest.max(world.linear_velocity(body).unwrap().length());
    }
    fastest / (spin * half * std::f32::consts::SQRT_2)
}

/// What a turning paddle pushes slides along it to its edge, and leaves it there at √2 of its speed at most. Held to its place on the paddle for
/// the rest of a step it kept the speed that it was to slide with, and got more in each step.
#[test]
fn what_turns_throws_what_is_fast_as_it_should() {
    let mut draw = Draw(11);
    for (half, is_door) in [(0.09_f32, false), (0.9, false), (0.9, true), (9.0, false)] {
        for (rate, turn) in
            [30.0_f32, 60.0, 120.0].into_iter().flat_map(|rate| [0.05_f32, 0.1, 0.2, 0.4].map(|turn| (rate, turn)))
        {
            for (name, shape) in
                solids(0.13 * half).into_iter().filter(|(name, _)| matches!(*name, "ball" | "capsule" | "cylinder"))
            {
                for case in 0..6 {
                    let found = thrown_by_paddle(&shape, half, turn * rate, (rate, is_door), &mut draw);
                    assert!(
                        found < 1.2,
                        "a {name} thrown by a {} of {half} m that turns by {turn} rad a step at {rate} Hz, case {case}: {found} of what it \
                         may get, bound 1.2",
                        if is_door { "door" } else { "paddle" }
                    );
                }
            }
        }
    }
}

/// A turntable is wide, and what it turns is not thrown or carried by what it does elsewhere: no touch is taken that is none.
#[test]
fn what_is_fast_moves_on_a_turntable_as_what_is_not() {
    for (size, rate) in [(0.1_f32, 30.0_f32), (0.1, 60.0), (0.1, 240.0), (1.0, 60.0)] {
        for (name, shape) in solids(size) {
            for turn in [0.02_f32, 0.05, 0.1] {
                let ends = [false, true].map(|fast| {
                    let mut world = world(9.81 * size / 0.1);
                    let mut table = surface(Shape::cuboid(Vec3::new(80.0, 5.0, 80.0) * size).unwrap(), 1.0, 0.0);
                    table.local_pose.position = Vec3::NEG_Y * (5.0 * size);
                    let spin = turn * rate;
                    let def = BodyDef { angular_velocity: Vec3::Y * spin, ..BodyDef::kinematic(Pose::IDENTITY) };
                    world.create_body(&def.with_shape(table)).unwrap();
                    // Within what friction holds: ω² r < μ g.
                    let radius = (0.5 * 98.1 * size / (spin * spin)).min(5.0 * size);
                    let (lies, height) = match name {
                        "capsule" => (Quat::from_rotation_x(std::f32::consts::FRAC_PI_2), 0.5),
                        "plank" => (Quat::from_rotation_x(std::f32::consts::FRAC_PI_2), 0.25),
                        _ => (Quat::IDENTITY, 0.5),
                    };
                    let at = Vec3::new(radius, height * size, 0.0).as_dvec3();
                    let def = BodyDef {
                        fast,
                        linear_velocity: Vec3::NEG_Z * (spin * radius),
                        angular_velocity: Vec3::Y * spin,
                        ..BodyDef::dynamic(Pose::at(at).rotated(lies))
                    };
                    let body = world.create_body(&def.with_shape(surface(shape.clone(), 1.0, 0.0))).unwrap();
                    for _ in 0..(0.5 * rate) as u32 {
                        world.step(1.0 / rate).unwrap();
                    }
                    (world.pose(body).unwrap().position, radius)
                });
                let apart = (ends[0].0 - ends[1].0).length() as f32 / ends[0].1;
                // A capsule rolls outwards, ever faster, and is swept where it does so.
                let bound = if name == "capsule" { 0.1 } else { 0.02 };
                assert!(
                    apart < bound,
                    "a {name} of {size} m on a turntable that turns by {turn} rad a step at {rate} Hz: flagged it is {apart} of its \
                     distance from the middle elsewhere after half a second, bound {bound}"
                );
            }
        }
    }
}

/// Kinetic and potential energy over mass of a body without restitution (J/kg).
fn energy(world: &World, body: BodyId) -> f64 {
    let (mass, pose) = (world.mass_properties(body).unwrap().unwrap(), world.pose(body).unwrap());
    let spin = mass.inertia_frame.conjugate() * (pose.rotation.conjugate() * world.angular_velocity(body).unwrap());
    let turning = (spin * spin).dot(mass.principal_inertia) / mass.mass;
    let moving = world.linear_velocity(body).unwrap().length_squared() + turning;
    0.5 * f64::from(moving) + 9.81 * world.center_of_mass(body).unwrap().y
}

/// What tips over dips with points of its rim that did not touch before. Held where the rest of it touched already, it hung there, and gained
/// speed without end.
#[test]
fn what_is_fast_and_thin_tips_over_as_what_is_not() {
    for (size, rate) in [0.1_f32, 1.0, 10.0].into_iter().flat_map(|size| [30.0_f32, 60.0, 120.0, 240.0].map(|rate| (size, rate)))
    {
        let coin = Shape::new(Geometry::Cylinder { half_height: 0.02 * size, radius: 0.3 * size }).unwrap();
        let plank = Shape::cuboid(Vec3::new(0.6, 0.02, 0.3) * size).unwrap();
        let disc = Shape::new(Geometry::Cylinder { half_height: 0.03 * size, radius: 0.5 * size }).unwrap();
        for (name, shape, turned, height) in [
            ("coin on its rim", coin, Quat::from_rotation_x(1.45), 0.31),
            ("leaning plank", plank, Quat::from_rotation_z(1.3), 0.66),
            ("dropped disc", disc, Quat::from_rotation_x(0.9) * Quat::from_rotation_z(0.4), 2.0),
        ] {
            let mut world = world(9.81);
            let floor = surface(Shape::cuboid(Vec3::new(60.0, 1.0, 60.0) * size).unwrap(), 0.5, 0.0);
            world.create_body(&BodyDef::fixed(Pose::at(DVec3::NEG_Y * f64::from(size))).with_shape(floor)).unwrap();
            let start = Pose::at(DVec3::Y * f64::from(height * size)).rotated(turned);
            let def = BodyDef { fast: true, linear_velocity: Vec3::X * size.sqrt(), ..BodyDef::dynamic(start) };
            let body = world.create_body(&def.with_shape(surface(shape, 0.5, 0.0))).unwrap();
            let (mut least, mut gained, mut held) = (f64::INFINITY, 0.0_f64, 0);
            for _ in 0..(5.0 * rate * size.sqrt().max(1.0)) as u32 {
                let before = world.pose(body).unwrap().position;
                world.step(1.0 / rate).unwrap();
                let now = energy(&world, body);
                least = least.min(now);
                gained = gained.max((now - least) / (9.81 * f64::from(size)));
                let moved = (world.pose(body).unwrap().position - before).length() as f32;
                let speed = world.linear_velocity(body).unwrap().length();
                held += u32::from(speed > 0.2 * size.sqrt() && moved < 0.02 * speed / rate && moved < 1.0e-5 * size);
            }
            let case = format!("{name} of {size} m at {rate} Hz");
            assert!(held == 0, "{case}: has speed and stays in place in {held} steps, none allowed");
            // Rows of one step may give back what friction took: 1 % of the height that it falls by.
            assert!(gained < 0.02, "{case}: gains {gained} of its size times its weight, bound 0.02");
        }
    }
}
