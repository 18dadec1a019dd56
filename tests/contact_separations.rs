//! What is told of a contact is how its surfaces lie at the end of the step.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, Material, Pose, Shape, ShapeDef, World, WorldDef};

const RATES: [f32; 3] = [30.0, 60.0, 240.0];

fn shapes(size: f32) -> [(&'static str, Shape); 6] {
    let solid = |geometry: Geometry| Shape::new(geometry).expect("a valid shape");
    let (half_height, radius) = (0.6 * size, 0.5 * size);
    let points = (0..8)
        .map(|i| size * Vec3::new(0.5 - (i & 1) as f32, 0.4 - 0.8 * (i >> 1 & 1) as f32, 0.3 - 0.6 * (i >> 2) as f32))
        .collect();
    [
        ("ball", solid(Geometry::Ball { radius })),
        ("box", Shape::cuboid(Vec3::new(0.5, 0.3, 0.4) * size).expect("a valid shape")),
        ("capsule", solid(Geometry::Capsule { half_height, radius })),
        ("cylinder", solid(Geometry::Cylinder { half_height, radius })),
        ("cone", solid(Geometry::Cone { half_height, radius })),
        ("hull", solid(Geometry::ConvexHull { points })),
    ]
}

fn grounds(size: f32) -> [(&'static str, Geometry); 4] {
    let wide = 40.0 * size;
    let corner = |x: f32, z: f32| Vec3::new(x * wide, 0.0, z * wide);
    [
        ("box", Geometry::Box { half_extents: Vec3::new(wide, size, wide) }),
        ("half-space", Geometry::HalfSpace { normal: Vec3::Y }),
        (
            "mesh",
            Geometry::TriangleMesh {
                vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
                triangles: vec![[0, 2, 1], [0, 3, 2]],
            },
        ),
        (
            "height field",
            Geometry::HeightField { rows: 5, columns: 5, heights: vec![0.0; 25], size_x: 2.0 * wide, size_z: 2.0 * wide },
        ),
    ]
}

/// Height of the lowest point of a body (m).
fn lowest(world: &World, body: BodyId, shape: &Shape) -> f64 {
    let pose = world.pose(body).expect("it stays");
    let down = pose.rotation.conjugate() * Vec3::NEG_Y;
    let along = |point: Vec3| f64::from((pose.rotation * point).y);
    let rim = |radius: f32, y: f32| {
        let across = Vec3::new(down.x, 0.0, down.z).normalize_or_zero() * radius;
        along(Vec3::new(across.x, y, across.z))
    };
    let low = match shape.geometry() {
        Geometry::Ball { radius } => -f64::from(*radius),
        Geometry::Box { half_extents } => along(half_extents.copysign(down)),
        Geometry::Capsule { half_height, radius } => along(Vec3::Y * half_height.copysign(down.y)) - f64::from(*radius),
        Geometry::Cylinder { half_height, radius } => rim(*radius, half_height.copysign(down.y)),
        Geometry::Cone { half_height, radius } => rim(*radius, -half_height).min(along(Vec3::Y * *half_height)),
        Geometry::ConvexHull { points } => points.iter().map(|&point| along(point)).fold(f64::INFINITY, f64::min),
        _ => unreachable!("no other shape is tried"),
    };
    pose.position.y + low
}

/// How far below the lowest point of the body the nearest of its contacts is told to be, and how far above it, at most over 3 s in which it
/// falls, bounces off its edges, rolls and slides (shares of its size).
fn off(ground: &Geometry, shape: &Shape, size: f32, rate: f32) -> [f64; 2] {
    let mut world = World::new(&WorldDef::default()).expect("a valid world");
    let top = if matches!(ground, Geometry::Box { .. }) { -f64::from(size) } else { 0.0 };
    let surface = |shape: Shape| ShapeDef { material: Material { friction: 0.4, ..Material::default() }, ..ShapeDef::new(shape) };
    let floor = BodyDef::fixed(Pose::at(DVec3::Y * top)).with_shape(surface(Shape::new(ground.clone()).expect("a valid shape")));
    world.create_body(&floor).expect("a valid body");
    let speed = 2.0 * size.sqrt();
    let at = Pose::at(DVec3::Y * f64::from(1.3 * size)).rotated(Quat::from_rotation_z(1.1));
    let mut def = BodyDef::dynamic(at).with_shape(surface(shape.clone()));
    def.linear_velocity = Vec3::new(speed, 0.0, 0.3 * speed);
    def.angular_velocity = Vec3::new(0.0, 1.0, -2.0) * speed / size;
    let body = world.create_body(&def).expect("a valid body");
    let mut off = [0.0_f64; 2];
    for _ in 0..(3.0 * rate) as u32 {
        world.step(1.0 / rate).expect("a valid step");
        let contacts = world.contacts_of(body).expect("it stays");
        let points = contacts.flat_map(|contact| contact.points().to_vec()).map(|point| f64::from(point.separation));
        let told = points.fold(f64::INFINITY, f64::min);
        if told.is_finite() {
            let above = (told - lowest(&world, body, shape)) / f64::from(size);
            off = [off[0].max(-above), off[1].max(above)];
        }
    }
    off
}

/// A ball on one point rolls on by a tenth of a radian and more between two steps: the point where it touched is off the ground by then.
#[test]
fn a_contact_tells_how_far_its_surfaces_are_apart_now() {
    for (rate, size) in RATES.into_iter().flat_map(|rate| [0.05_f32, 1.0, 20.0].map(|size| (rate, size))) {
        for ((on, ground), (name, shape)) in
            grounds(size).into_iter().flat_map(|ground| shapes(size).map(|shape| (ground.clone(), shape)))
        {
            let [below, above] = off(&ground, &shape, size, rate);
            let what = format!("a {name} of {size} m on a {on} at {rate}/s");
            // The rim of what is round meets triangles at a point nearby.
            let is_rim = matches!(name, "cylinder" | "cone");
            let bound = if is_rim { 0.02 } else { 1.0e-3 };
            assert!(below < bound, "{what}: told {below} of its size too near, bound {bound}");
            // Of others the lowest corner may be none of those that touch.
            assert!(name != "ball" || above < 1.0e-3, "{what}: told {above} of its size too far, bound 1e-3");
        }
    }
}

/// What spins about its own axis by more than it shows: a contact that was looked for as far as it could reach told overlaps of half a metre.
#[test]
fn a_contact_of_what_spins_past_tells_the_true_gap() {
    for (rate, size) in RATES.into_iter().flat_map(|rate| [0.006_f32, 0.06, 0.6].map(|size| (rate, size))) {
        let shapes = [Geometry::Ball { radius: size }, Geometry::Capsule { half_height: size, radius: 0.5 * size }];
        for (shape, turn) in shapes.into_iter().flat_map(|shape| [0.5_f32, 2.0, 8.0, 17.0].map(|turn| (shape.clone(), turn))) {
            let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).expect("a valid world");
            let [spins, rests] = [(0.0, turn * rate), (6.0, 0.0)].map(|(place, spin)| {
                let at = Pose::at(Vec3::X.as_dvec3() * f64::from(place * size));
                let def = BodyDef::dynamic(at).with_shape(ShapeDef::new(Shape::new(shape.clone()).expect("a valid shape")));
                world.create_body(&BodyDef { angular_velocity: Vec3::Y * spin, ..def }).expect("a valid body")
            });
            world.set_linear_velocity(spins, Vec3::X * (5.0 * size)).expect("it stays");
            for _ in 0..(0.1 * rate) as u32 {
                world.step(1.0 / rate).expect("a valid step");
                let [a, b] = [spins, rests].map(|body| world.body_shapes(body).expect("it stays")[0]);
                let gap = world.shape_distance(a, b).expect("they stay").distance;
                for contact in world.contacts_of(rests).expect("it stays").filter(|contact| contact.points().len() == 1) {
                    let off = (f64::from(contact.points()[0].separation) - gap).abs() / f64::from(size);
                    let what = format!("{shape:?} that spins by {turn} rad a step at {rate}/s");
                    assert!(off < 1.0e-3, "{what}: a gap is told that is off by {off} of its size, bound 1e-3");
                }
            }
        }
    }
}
