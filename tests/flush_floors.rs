//! Floors made of pieces that lie flush, boxes beside one another, parts of a compound, triangles, cells of a height field, are floors: what
//! glides, rolls, slides or falls on them does as on one plane, whatever its shape, size and speed and whatever the rate.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::*;

const FLOORS: [&str; 4] = ["boxes side by side", "a compound", "a mesh", "a height field"];
const FLAT: [&str; 5] = ["box", "disc", "cone", "octagon", "compound"];
const ROUND: [&str; 3] = ["ball", "capsule", "cylinder"];

/// Size (m), rate (1/s).
const SCALES: [(f32, f32); 5] = [(1.0, 30.0), (1.0, 60.0), (1.0, 240.0), (0.1, 60.0), (10.0, 60.0)];

/// Side of a piece over the size of what moves on it.
const PIECE: f32 = 1.7;

fn material(friction: f32, restitution: f32) -> Material {
    Material { friction, restitution, ..Material::default() }
}

fn fixed(world: &mut World, geometry: Geometry, at: Vec3, material: Material) {
    let shape = ShapeDef { material, ..ShapeDef::new(Shape::new(geometry).expect("a valid shape")) };
    world.create_body(&BodyDef::fixed(Pose::at(at.as_dvec3())).with_shape(shape)).expect("a valid body");
}

/// A floor whose top is at zero, of so many pieces each way from the middle along x and z.
fn lay(world: &mut World, floor: &str, size: f32, (nx, nz): (i32, i32), material: Material) {
    let piece = PIECE * size;
    let (columns, rows) = ((2 * nx + 1) as usize, (2 * nz + 1) as usize);
    let each = || (-nx..=nx).flat_map(move |i| (-nz..=nz).map(move |k| (i, k)));
    let top = |(i, k): (i32, i32)| Vec3::new(i as f32 * piece, 0.0, k as f32 * piece);
    let half_extents = 0.5 * Vec3::new(piece, size, piece);
    let middle = |place| top(place) - Vec3::Y * (0.5 * size);
    match floor {
        "boxes side by side" => each().for_each(|place| fixed(world, Geometry::Box { half_extents }, middle(place), material)),
        "a compound" => {
            let parts = each().map(|place| (LocalPose::at(middle(place)), Geometry::Box { half_extents })).collect();
            fixed(world, Geometry::Compound { parts }, Vec3::ZERO, material);
        }
        "a mesh" => {
            let at = |i: i32, k: i32| ((i + nx) * (2 * nz + 1) + k + nz) as u32;
            let cells = each().filter(|&(i, k)| i < nx && k < nz);
            let triangles =
                cells.flat_map(|(i, k)| [[at(i, k), at(i, k + 1), at(i + 1, k)], [at(i + 1, k), at(i, k + 1), at(i + 1, k + 1)]]);
            let triangles = triangles.collect();
            fixed(world, Geometry::TriangleMesh { vertices: each().map(top).collect(), triangles }, Vec3::ZERO, material);
        }
        _ => {
            let [size_x, size_z] = [columns, rows].map(|count| (count - 1) as f32 * piece);
            let heights = vec![0.0; rows * columns];
            fixed(world, Geometry::HeightField { rows, columns, heights, size_x, size_z }, Vec3::ZERO, material);
        }
    }
}

/// A shape, and how high its centre is and how it is turned where it lies; what is round rolls along x.
fn form(name: &str, size: f32) -> (Geometry, f32, Quat) {
    let lying = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
    let (geometry, height, rotation) = match name {
        "box" => (Geometry::Box { half_extents: Vec3::new(1.0, 0.5, 0.7) * size }, 0.5, Quat::IDENTITY),
        "disc" => (Geometry::Cylinder { half_height: 0.2 * size, radius: size }, 0.2, Quat::IDENTITY),
        "cone" => (Geometry::Cone { half_height: 0.6 * size, radius: 0.8 * size }, 0.6, Quat::IDENTITY),
        "octagon" => {
            let corner = |k: u8| Quat::from_rotation_y(f32::from(k) * std::f32::consts::FRAC_PI_4) * Vec3::X * size;
            let points = (0..8).flat_map(|k| [-0.4, 0.4].map(|y| corner(k) + Vec3::Y * (y * size))).collect();
            (Geometry::ConvexHull { points }, 0.4, Quat::IDENTITY)
        }
        "compound" => {
            let part = |x: f32, y: f32, half: [f32; 3]| {
                (LocalPose::at(Vec3::new(x, y, 0.0) * size), Geometry::Box { half_extents: Vec3::from_array(half) * size })
            };
            let parts = vec![part(-0.6, 0.0, [0.3, 0.3, 0.5]), part(0.6, 0.0, [0.3, 0.3, 0.5]), part(0.0, 0.2, [0.6, 0.1, 0.5])];
            (Geometry::Compound { parts }, 0.3, Quat::IDENTITY)
        }
        "ball" => (Geometry::Ball { radius: size }, 1.0, Quat::IDENTITY),
        "capsule" => (Geometry::Capsule { half_height: 0.8 * size, radius: 0.5 * size }, 0.5, lying),
        _ => (Geometry::Cylinder { half_height: 0.8 * size, radius: 0.5 * size }, 0.5, lying),
    };
    (geometry, height * size, rotation)
}

/// A body on a floor, away from the corners and the middle of a piece.
struct Run {
    world: World,
    body: BodyId,
    height: f64,
    rate: f32,
}

impl Run {
    fn new(floor: &str, name: &str, (size, rate): (f32, f32), material: Material, above: f32) -> Self {
        let mut world = World::new(&WorldDef::default()).expect("a valid world");
        lay(&mut world, floor, size, (16, 8), material);
        let (geometry, height, rotation) = form(name, size);
        let shape = ShapeDef { material, ..ShapeDef::new(Shape::new(geometry).expect("a valid shape")) };
        let at = Vec3::new(-20.69 * size, height + above, -4.63 * size).as_dvec3();
        let body = world.create_body(&BodyDef::dynamic(Pose::at(at).rotated(rotation)).with_shape(shape)).expect("a valid body");
        Self { world, body, height: f64::from(height), rate }
    }

    fn step(&mut self) {
        self.world.step(1.0 / self.rate).expect("a valid step");
    }

    fn place(&self) -> DVec3 {
        self.world.pose(self.body).expect("it stays").position
    }

    /// Along the floor, how far it has gone from `start` along a direction, and how far aside (m).
    fn way(&self, start: DVec3, along: Vec3) -> [f64; 2] {
        let way = (self.place() - start).with_y(0.0);
        let gone = way.dot(along.as_dvec3());
        [gone, (way - along.as_dvec3() * gone).length()]
    }
}

/// How far what moves over 24 of its sizes by so much of its size in a step is off: its speed and its way (shares), how high it hops (sizes), and
/// its spin (over its speed and size).
fn crossing(floor: &str, name: &str, scale: (f32, f32), stride: f32, rolls: bool) -> [f64; 4] {
    let (size, rate) = scale;
    let mut run = Run::new(floor, name, scale, material(if rolls { 0.5 } else { 0.0 }, 0.0), 0.0);
    let along = if rolls { Vec3::X } else { Vec3::new(1.0, 0.0, 0.37).normalize() };
    let speed = stride * size * rate;
    let spin = if rolls { Vec3::Y.cross(along) * (speed / run.height as f32) } else { Vec3::ZERO };
    run.world.set_linear_velocity(run.body, along * speed).expect("a valid velocity");
    run.world.set_angular_velocity(run.body, spin).expect("a valid velocity");
    let start = run.place();
    let [mut hop, mut turns] = [0.0_f64; 2];
    for _ in 0..(24.0 / stride) as u32 {
        run.step();
        hop = hop.max((run.place().y - run.height).abs() / f64::from(size));
        let turned = run.world.angular_velocity(run.body).expect("it stays") - spin;
        turns = turns.max(f64::from(turned.length() * size / speed));
    }
    let [gone, aside] = run.way(start, along);
    let now = run.world.linear_velocity(run.body).expect("it stays").dot(along);
    [f64::from((now / speed - 1.0).abs()), aside / gone, hop, turns]
}

fn keeps_on(names: &[&str], rolls: bool, bounds: [f64; 4]) {
    let strides = |scale| if scale == (1.0, 60.0) { &[0.05, 0.3, 0.8][..] } else { &[0.3] };
    for (floor, &name) in FLOORS.into_iter().flat_map(|floor| names.iter().map(move |name| (floor, name))) {
        for (scale, &stride) in SCALES.into_iter().flat_map(|scale| strides(scale).iter().map(move |stride| (scale, stride))) {
            let off = crossing(floor, name, scale, stride, rolls);
            let what = format!("a {name} of {} m on {floor} at {}/s, {stride} of its size a step", scale.0, scale.1);
            for ((off, bound), of) in
                off.into_iter().zip(bounds).zip(["its speed", "its way", "its size", "the spin of its speed"])
            {
                assert!(off < bound, "{what}: off by {off} of {of}, bound {bound}");
            }
        }
    }
}

/// A cylinder that lay along the edge of the next part of a compound met it at two points, taken for a face of it: it lost up to 60 % of its
/// speed and flew 20 of its sizes high. A compound that came over a corner of four tiles met the side of the one across.
#[test]
fn what_glides_keeps_its_speed() {
    keeps_on(&[&FLAT[..], &ROUND].concat(), false, [3.0e-3, 2.0e-3, 1.0e-2, 1.0e-2]);
}

/// On triangles the depth of what only just overlaps is noise, and points deeper than five times that were left out: what lay on a line lost
/// one of its ends. It still turns a little as its load goes from triangle to triangle.
#[test]
fn what_rolls_keeps_its_speed() {
    keeps_on(&ROUND, true, [5.0e-3, 2.0e-2, 1.0e-2, 0.1]);
}

/// d = v²/2µg. Normal rows are solved after friction, and what they let go of bore friction all the same: up to 12 % too much in a step in which
/// a body came onto the next piece, 1 to 4 % of the way.
#[test]
fn what_slides_stops_where_friction_stops_it() {
    const FRICTION: f32 = 0.5;
    for (floor, name) in FLOORS.into_iter().flat_map(|floor| FLAT.map(|name| (floor, name))) {
        for (size, rate) in SCALES {
            let mut run = Run::new(floor, name, (size, rate), material(FRICTION, 0.0), 0.0);
            let along = Vec3::new(1.0, 0.0, 0.37).normalize();
            let expected = 8.0 * size;
            let slowing = FRICTION * run.world.gravity().length();
            let speed = (2.0 * slowing * expected).sqrt();
            run.world.set_linear_velocity(run.body, along * speed).expect("a valid velocity");
            let start = run.place();
            (0..(1.5 * speed / slowing * rate) as u32).for_each(|_| run.step());
            let [gone, aside] = run.way(start, along);
            let (off, aside) = (gone / f64::from(expected) - 1.0, aside / gone);
            let what = format!("a {name} of {size} m on {floor} at {rate}/s");
            assert!(off.abs() < 7.5e-3, "{what}: stops {off} of its way off, bound 7.5e-3");
            assert!(aside < 2.0e-3, "{what}: goes {aside} of its way aside, bound 2e-3");
        }
    }
}

/// What falls fast meets the edge of a piece beside that which it lands on in the same step, and was struck by both.
#[test]
fn what_falls_rebounds_straight() {
    for (floor, name) in FLOORS.into_iter().flat_map(|floor| ["ball", "box", "octagon"].map(|name| (floor, name))) {
        for ((size, rate), restitution) in SCALES.into_iter().flat_map(|scale| [0.5, 1.0].map(|e| (scale, e))) {
            let above = 4.0 * size;
            let mut run = Run::new(floor, name, (size, rate), material(0.5, restitution), above);
            run.world.set_restitution_threshold(0.01 * size.sqrt()).expect("a valid speed");
            let fall = (2.0 * above / run.world.gravity().length()).sqrt();
            let [mut apex, mut spin, mut hit] = [0.0_f64, 0.0, 0.0];
            for _ in 0..(fall * (1.0 + 1.9 * restitution) * rate) as u32 {
                run.step();
                let [linear, angular] =
                    [World::linear_velocity, World::angular_velocity].map(|of| of(&run.world, run.body).expect("it stays"));
                hit = if linear.y > 0.0 { 1.0 } else { hit };
                apex = apex.max(hit * (run.place().y - run.height));
                spin = spin.max(f64::from(angular.length()));
            }
            let what = format!("a {name} of {size} m on {floor} at {rate}/s, restitution {restitution}");
            let off = apex / f64::from(above) - f64::from(restitution * restitution);
            assert!(off.abs() < 0.03, "{what}: rises {off} of its height too far, bound 0.03");
            let turned = spin * f64::from(fall);
            assert!(turned < 0.05, "{what}: would turn by {turned} rad in its fall, bound 0.05");
        }
    }
}

/// What goes further in a step than a floor is thick would be beside its neighbours, or behind them, had it not rebounded: they held it there.
#[test]
fn what_goes_further_than_a_floor_is_thick_rebounds() {
    let scales = [(0.05_f32, 30.0_f32), (0.05, 60.0), (0.5, 30.0), (2.0, 30.0)];
    for (floor, (size, rate)) in FLOORS.into_iter().flat_map(|floor| scales.map(|scale| (floor, scale))) {
        // Away from the seams, over the size; strides over the radius, five of which are as thick as a piece.
        for (stride, place) in
            [3.0_f32, 6.0, 12.0, 24.0].into_iter().flat_map(|stride| [-20.69_f32, -20.1, -19.7].map(|x| (stride, x)))
        {
            for fast in [false, true] {
                let radius = 0.2 * size;
                let speed = stride * radius * rate;
                let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).expect("a valid world");
                world.set_restitution_threshold(0.1 * speed).expect("a valid speed");
                lay(&mut world, floor, size, (16, 8), material(0.5, 0.8));
                let ball =
                    ShapeDef { material: material(0.5, 0.8), ..ShapeDef::new(Shape::ball(radius).expect("a valid shape")) };
                let at = Vec3::new(place * size, radius * (1.0 + 0.4 * stride), -4.63 * size).as_dvec3();
                let def = BodyDef { fast, linear_velocity: Vec3::NEG_Y * speed, ..BodyDef::dynamic(Pose::at(at)) };
                let body = world.create_body(&def.with_shape(ball)).expect("a valid body");
                for _ in 0..3 {
                    world.step(1.0 / rate).expect("a valid step");
                }
                let off = (world.linear_velocity(body).expect("it stays") - Vec3::Y * (0.8 * speed)).length() / speed;
                assert!(
                    off < 0.02,
                    "a ball of {radius} m at {place} sizes of a piece, {stride} radii a step at {rate}/s on {floor}, fast {fast}: its rebound \
                     is off by {off} of its speed, bound 0.02"
                );
            }
        }
    }
}

/// Which corners of an octagon are kept of a contact may change from step to step; two were told at the place of one.
#[test]
fn a_contact_tells_each_of_its_points_once() {
    for (floor, name) in FLOORS.into_iter().flat_map(|floor| ["octagon", "disc", "cone"].map(|name| (floor, name))) {
        for (size, rate) in SCALES {
            let mut run = Run::new(floor, name, (size, rate), material(0.3, 0.0), 0.02 * size);
            run.world.set_linear_velocity(run.body, Vec3::new(2.0, 0.0, 1.0) * size.sqrt()).expect("a valid velocity");
            for _ in 0..rate as u32 {
                run.step();
                let contacts = run.world.contacts_of(run.body).expect("it stays");
                for contact in contacts.filter(|contact| contact.normal.y.abs() > 0.9) {
                    let points: Vec<DVec3> = contact.points().iter().map(|point| point.position).collect();
                    let nearest =
                        points.iter().enumerate().flat_map(|(i, a)| points[..i].iter().map(move |b| (*a - *b).length()));
                    let nearest = nearest.fold(f64::INFINITY, f64::min) / f64::from(size);
                    assert!(nearest > 0.0, "a {name} of {size} m on {floor} at {rate}/s: two points {nearest} of its size apart");
                }
            }
        }
    }
}

/// A floor of parts that the host moves along at this speed (m/s), and what goes over it at 2.5 m/s: how far its speed over the floor is off (share),
/// and how high it hops (m).
fn on_the_move(name: &str, carried: f64, rate: f32) -> [f64; 2] {
    let mut world = World::new(&WorldDef::default()).expect("a valid world");
    let slides = name == "box";
    let surface = material(if slides { 0.0 } else { 0.5 }, 0.0);
    let with = |geometry| ShapeDef { material: surface, ..ShapeDef::new(Shape::new(geometry).expect("a valid shape")) };
    let cell = |i: i32, k: i32| LocalPose::at(Vec3::new(f64::from(i) as f32 * 0.5, -0.1, (f64::from(k) as f32 + 0.37) * 0.5));
    let tile = || Geometry::Box { half_extents: Vec3::new(0.25, 0.1, 0.25) };
    let parts = (-3..30).flat_map(|i| (-3..3).map(move |k| (i, k))).map(|(i, k)| (cell(i, k), tile())).collect();
    let mut floor = BodyDef::kinematic(Pose::at(DVec3::ZERO)).with_shape(with(Geometry::Compound { parts }));
    floor.linear_velocity = Vec3::X * carried as f32;
    world.create_body(&floor).expect("a valid body");
    let (geometry, height, rotation) = form(name, if slides { 0.3 } else { 0.15 });
    let mut def = BodyDef::dynamic(Pose::at_xyz(0.0, f64::from(height), 0.0).rotated(rotation)).with_shape(with(geometry));
    def.linear_velocity = Vec3::X * (carried as f32 + 2.5);
    def.angular_velocity = if slides { Vec3::ZERO } else { Vec3::NEG_Z * (2.5 / height) };
    let body = world.create_body(&def).expect("a valid body");
    let mut hop = 0.0_f64;
    for _ in 0..(3.0 * rate) as u32 {
        world.step(1.0 / rate).expect("a valid step");
        hop = hop.max((world.pose(body).expect("it stays").position.y - f64::from(height)).abs());
    }
    let speed = f64::from(world.linear_velocity(body).expect("it stays").x) - carried;
    [(speed / 2.5 - 1.0).abs(), hop]
}

#[test]
fn a_floor_of_parts_that_moves_along_is_a_floor() {
    for (name, rate) in
        ["ball", "capsule", "cylinder", "box"].into_iter().flat_map(|name| [30.0, 60.0, 240.0].map(|rate| (name, rate)))
    {
        for carried in [3.0, -8.0, 20.0] {
            let [off, hop] = on_the_move(name, carried, rate);
            // Only floors that stand still had no seams: boxes lost 98 % of their speed, balls 38 % and hopped by 35 mm.
            assert!(off < 2.0e-3, "{name} on a floor at {carried} m/s, {rate} Hz: speed off by {off}");
            assert!(hop < 1.0e-3, "{name} on a floor at {carried} m/s, {rate} Hz: hops by {hop} m");
        }
    }
}

/// How far something that lies with its edges exactly on those of a piece gets in the time in which friction lets it go one and a half pieces,
/// pushed with twice what friction takes, over that.
fn pushed_off_the_grid(name: &str, floor: &str, size: f32, rate: f32, (offset, way): (f64, f32)) -> f64 {
    let mut world = World::new(&WorldDef::default()).expect("a valid world");
    let (piece, friction) = (PIECE * size, 0.4);
    lay(&mut world, floor, size, (3, 1), material(friction, 0.0));
    let half = 0.5 * piece;
    let geometry = match name {
        "box" => Geometry::Box { half_extents: Vec3::splat(half) },
        "cylinder" => Geometry::Cylinder { half_height: half, radius: half },
        "cone" => Geometry::Cone { half_height: half, radius: half },
        "crate of two parts" => {
            let part = |z: f32| (LocalPose::at(Vec3::Z * (z * half)), Geometry::Box { half_extents: Vec3::splat(half) });
            Geometry::Compound { parts: vec![part(-1.0), part(1.0)] }
        }
        _ => {
            let corner = |i: u8| Vec3::from_array([1, 2, 4].map(|bit| if i & bit == 0 { -half } else { half }));
            Geometry::ConvexHull { points: (0..8).map(corner).collect() }
        }
    };
    let shape = ShapeDef { material: material(friction, 0.0), ..ShapeDef::new(Shape::new(geometry).expect("a valid shape")) };
    // Two parts lie on two pieces, side by side.
    let aside = if name == "crate of two parts" { 0.5 } else { 0.0 };
    let at = DVec3::new(offset * f64::from(piece), f64::from(half), (offset + aside) * f64::from(piece));
    let body = world.create_body(&BodyDef::dynamic(Pose::at(at)).with_shape(shape)).expect("a valid body");
    let mass = world.mass_properties(body).expect("it is there").expect("it is dynamic").mass;
    let steps = ((3.0 * piece / (friction * 9.81)).sqrt() * rate) as u32;
    for _ in 0..steps {
        world.add_force(body, Vec3::X * (2.0 * friction * 9.81 * mass * way)).expect("a body of the world");
        world.step(1.0 / rate).expect("a valid step");
    }
    let time = f64::from(steps as f32 / rate);
    let gone = (world.pose(body).expect("it stays").position.x - at.x) * f64::from(way);
    gone / (0.5 * 9.81 * f64::from(friction) * time * time)
}

#[test]
fn what_lies_exactly_on_a_piece_can_be_pushed_off_it() {
    let names = ["box", "hull", "cylinder", "cone", "crate of two parts"];
    for (floor, name) in FLOORS.into_iter().flat_map(|floor| names.map(|name| (floor, name))) {
        for (size, rate) in [(0.3, 60.0), (1.0, 30.0), (1.0, 60.0), (1.0, 120.0), (3.0, 60.0)] {
            for place in [(0.0, 1.0), (0.0, -1.0), (1.0e-7, 1.0), (1.0e-6, -1.0), (1.0e-5, 1.0)] {
                let gone = pushed_off_the_grid(name, floor, size, rate, place);
                // Edges of neighbours held what did not move yet: half of these stayed where they were. A crate of two parts fell into the floor: the
                // side that a tile turns to the next one was taken for a face on which it lay.
                assert!((0.9..1.1).contains(&gone), "{name} on {floor}, {size} m, {rate} Hz, {place:?}: {gone} of its way");
            }
        }
    }
}

/// A cart on such wheels (radius, m) that crosses the pieces of a floor at 17 radii a second, at this angle to their edges (rad): how far its speed
/// is off at the end (share), and how high it hops (radii).
fn cart_crossing(floor: &str, wheel: &str, (radius, rate, angle): (f32, f32, f32)) -> [f64; 2] {
    let mut world = World::new(&WorldDef::default()).expect("a valid world");
    let surface = material(0.5, 0.0);
    lay(&mut world, floor, 2.0 * radius, (10, 6), surface);
    let turn = Quat::from_rotation_y(angle);
    let along = turn * Vec3::X;
    let place = |at: Vec3| (turn * (Vec3::new(-25.3, 0.0, 0.7) + at) * radius).as_dvec3();
    let mut add = |geometry, at: Vec3, rotation, mass, spin: Vec3| {
        let shape = ShapeDef { material: surface, ..ShapeDef::new(Shape::new(geometry).expect("a valid shape")) };
        let mut def = BodyDef::dynamic(Pose::at(place(at)).rotated(rotation)).with_shape(shape).with_mass(Mass::Total(mass));
        (def.linear_velocity, def.angular_velocity) = (along * (17.0 * radius), spin);
        world.create_body(&def).expect("a valid body")
    };
    let lying = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
    let half_extents = Vec3::new(3.0, 0.8, 1.7) * radius;
    let chassis = add(Geometry::Box { half_extents }, Vec3::Y * 2.0, turn, 1500.0, Vec3::ZERO);
    let places = [-1.6_f32, 1.6].into_iter().flat_map(|x| [-2.3, 2.3].map(|z| Vec3::new(x, 1.0, z)));
    let wheels: Vec<_> = places
        .map(|at| {
            let geometry = match wheel {
                "cylinder" => Geometry::Cylinder { half_height: 0.3 * radius, radius },
                "capsule" => Geometry::Capsule { half_height: 0.3 * radius, radius },
                _ => Geometry::Ball { radius },
            };
            (add(geometry, at, turn * lying, 40.0, turn * Vec3::NEG_Z * 17.0), at)
        })
        .collect();
    for (body, at) in wheels {
        let mut def = JointDef::new(JointKind::HINGE, chassis, body);
        let along_z = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
        def.frame_a = Pose::at(((at - Vec3::Y * 2.0) * radius).as_dvec3()).rotated(along_z);
        def.frame_b = Pose::IDENTITY.rotated(lying.inverse() * along_z);
        world.create_joint(&def).expect("a valid joint");
    }
    let height = world.pose(chassis).expect("it stays").position.y;
    let mut hop = 0.0_f64;
    for _ in 0..(45.0 / 17.0 * rate) as u32 {
        world.step(1.0 / rate).expect("a valid step");
        hop = hop.max((world.pose(chassis).expect("it stays").position.y - height).abs() / f64::from(radius));
    }
    let now = world.linear_velocity(chassis).expect("it stays").dot(along);
    [f64::from((now / (17.0 * radius) - 1.0).abs()), hop]
}

/// The point of an edge ahead that faces a wheel was found beside that edge, and so not on it: wheels with joints, which are collided as they stand,
/// were struck by it. Carts on cylinders hopped by up to 10 radii and stopped.
#[test]
fn what_rolls_on_wheels_keeps_its_speed() {
    for (floor, wheel) in FLOORS.into_iter().flat_map(|floor| ROUND.map(|wheel| (floor, wheel))) {
        for scale in [(0.35, 30.0, 0.0), (0.35, 60.0, 0.4), (0.35, 240.0, 0.0), (0.035, 60.0, 0.0)] {
            let [off, hop] = cart_crossing(floor, wheel, scale);
            let what = format!("{wheel} wheels of {} m on {floor} at {}/s, {} rad", scale.0, scale.1, scale.2);
            assert!(off < 5.0e-3, "{what}: off by {off} of its speed, bound 5e-3");
            assert!(hop < 1.0e-2, "{what}: hops by {hop} of a radius, bound 1e-2");
        }
    }
}

/// A wall of triangles has nothing behind it, and its foot was taken for a seam of the floor: discs and crates that slid into one tipped over, by up to half
/// a turn, and left with 0.4 to 0.96 of their energy.
#[test]
fn what_slides_into_a_wall_of_triangles_rebounds_as_from_a_box() {
    for (name, (size, rate)) in ["disc", "box", "octagon"].into_iter().flat_map(|name| SCALES.map(|scale| (name, scale))) {
        for (restitution, askew) in [(0.0_f32, 0.0_f32), (0.0, 0.3), (1.0, 0.1)] {
            let (away, speed) = (3.0 * size, 2.0 * size.sqrt());
            let mut run = Run::new("boxes side by side", name, (size, rate), material(0.0, restitution), 0.0);
            run.world.set_restitution_threshold(0.01 * size.sqrt()).expect("a valid speed");
            let corner = |up: f32, aside: f32| Vec3::new(0.0, up * size, aside * size);
            let vertices = vec![corner(0.0, -9.0), corner(4.0, -9.0), corner(0.0, 9.0), corner(4.0, 9.0)];
            let wall = Geometry::TriangleMesh { vertices, triangles: vec![[0, 2, 1], [2, 3, 1]] };
            let foot = run.place().with_y(0.0).as_vec3() + Vec3::X * away;
            fixed(&mut run.world, wall, foot, material(0.0, restitution));
            let velocity = Vec3::new(askew.cos(), 0.0, askew.sin()) * speed;
            run.world.set_linear_velocity(run.body, velocity).expect("a valid velocity");
            for _ in 0..(1.5 * f64::from(away / velocity.x) * f64::from(rate)) as u32 {
                run.step();
            }
            let [linear, angular] =
                [World::linear_velocity, World::angular_velocity].map(|of| of(&run.world, run.body).expect("it stays"));
            let what = format!("a {name} of {size} m at {rate}/s, restitution {restitution}, {askew} rad askew");
            let off = (linear - Vec3::new(-restitution * velocity.x, 0.0, velocity.z)).length() / speed;
            assert!(off < 0.01, "{what}: {off} of its speed off, bound 0.01");
            let turning = angular.length() * size / speed;
            assert!(turning < 0.01, "{what}: turns at {turning} of its speed, bound 0.01");
        }
    }
}
