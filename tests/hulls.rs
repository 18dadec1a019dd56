//! Convex hulls, however round or thin: they weigh what their surface holds, lie where they are put, and roll.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Cells, Error, Geometry, Mass, Pose, Shape, ShapeDef, World, WorldDef};

const WATER: f64 = 1000.0;

fn circle(count: u32, y: f64) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(count)).sin_cos();
        DVec3::new(cos, y, sin).as_vec3()
    })
}

/// Points on a sunflower spiral over the unit disc.
fn spiral(count: u32) -> impl Iterator<Item = (f64, f64, f64)> {
    (0..count).map(move |i| {
        let (r, (sin, cos)) = (((f64::from(i) + 0.5) / f64::from(count)).sqrt(), (2.399_963_23 * f64::from(i)).sin_cos());
        (r, r * cos, r * sin)
    })
}

fn prism(sides: u32) -> Vec<Vec3> {
    circle(sides, -1.0).chain(circle(sides, 1.0)).collect()
}

fn lens(thickness: f64) -> Vec<Vec3> {
    let caps = spiral(200).flat_map(|(r, x, z)| {
        let y = thickness * (1.0 - r * r);
        [DVec3::new(x, y, z).as_vec3(), DVec3::new(x, -y, z).as_vec3()]
    });
    caps.chain(circle(64, 0.0)).collect()
}

fn sphere(count: u32) -> Vec<Vec3> {
    (0..count)
        .map(|i| {
            let y = 1.0 - f64::from(2 * i + 1) / f64::from(count);
            let (sin, cos) = (2.399_963_23 * f64::from(i)).sin_cos();
            (DVec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + DVec3::Y * y).as_vec3()
        })
        .collect()
}

fn sheet(width: f32, thickness: f32) -> Vec<Vec3> {
    let half = Vec3::new(width, thickness, width) * 0.5;
    (0..8).map(|i| half * Vec3::new([-1.0, 1.0][i & 1], [-1.0, 1.0][i >> 1 & 1], [-1.0, 1.0][i >> 2])).collect()
}

fn hull(points: Vec<Vec3>) -> Result<Shape, Error> {
    Shape::new(Geometry::ConvexHull { points })
}

#[test]
fn a_hull_weighs_what_its_surface_holds() {
    let area = |sides: u32| 0.5 * f64::from(sides) * (std::f64::consts::TAU / f64::from(sides)).sin();
    let mut cases: Vec<(String, Vec<Vec3>, f64, f64)> = Vec::new();
    for sides in [3, 64, 200, 224, 240, 256, 300, 400, 512, 2048] {
        cases.push((format!("prism of {sides} sides"), prism(sides), 2.0 * area(sides), 1.0e-5));
        let cone = circle(sides, -1.0).chain([Vec3::Y]).collect();
        cases.push((format!("cone of {sides} sides"), cone, 2.0 / 3.0 * area(sides), 1.0e-5));
    }
    for thickness in [0.3, 0.1, 0.05, 0.02] {
        // A paraboloid cap holds half of its cylinder; 200 points leave out 2 %.
        cases.push((format!("lens {thickness} m thick"), lens(thickness), std::f64::consts::PI * thickness, 0.03));
    }
    cases.push(("sphere of 4096 points".to_owned(), sphere(4096), 4.0 / 3.0 * std::f64::consts::PI, 0.002));
    cases.push(("sheet of 1 mm".to_owned(), sheet(2.0, 0.001), 0.004, 1.0e-5));
    cases.push(("pane of 0.5 mm".to_owned(), sheet(2.0, 0.0005), 0.002, 1.0e-5));
    for scale in [1.0e-3_f32, 1.0, 100.0] {
        for (name, points, volume, tolerance) in &cases {
            let shape =
                hull(points.iter().map(|&point| point * scale).collect()).unwrap_or_else(|error| panic!("{name}: {error}"));
            let expected = volume * f64::from(scale).powi(3) * WATER;
            let mass = shape.mass_properties(WATER as f32).expect("a hull has mass");
            let off = f64::from(mass.mass) / expected - 1.0;
            assert!(off.abs() < *tolerance, "{name} times {scale}: {} kg, expected {expected} kg", mass.mass);
            assert!(mass.principal_inertia.min_element() > 0.0, "{name}: {:?}", mass.principal_inertia);
        }
    }
}

#[test]
fn a_sheet_has_the_inertia_of_a_plate() {
    let mass = hull(sheet(2.0, 0.001)).unwrap().mass_properties(WATER as f32).unwrap();
    let mut moments = mass.principal_inertia.to_array();
    moments.sort_by(f32::total_cmp);
    // m (a² + b²)/12, with 4 kg and 2 m.
    for (moment, expected) in moments.into_iter().zip([4.0 / 3.0, 4.0 / 3.0, 8.0 / 3.0]) {
        assert!((moment - expected).abs() < 1.0e-4 * expected, "{moment} kg·m², expected {expected} kg·m²");
    }
}

#[test]
fn cells_of_smooth_solids_keep_all_of_the_mass() {
    for (name, points) in [("lens", lens(0.1)), ("prism", prism(400)), ("sheet", sheet(2.0, 0.01)), ("sphere", sphere(600))] {
        let whole = Geometry::ConvexHull { points };
        let mass_of = |geometry: Geometry| f64::from(Shape::new(geometry).unwrap().mass_properties(WATER as f32).unwrap().mass);
        let expected = mass_of(whole.clone());
        let seeds = Cells::random_seeds(&whole, 12, 5).unwrap();
        let cut = Cells::cut(&whole, &seeds).unwrap();
        let total: f64 = cut.cells.iter().map(|cell| mass_of(Geometry::ConvexHull { points: cell.points.clone() })).sum();
        assert!((total / expected - 1.0).abs() < 1.0e-5, "{name}: {} cells weigh {total} kg of {expected} kg", cut.cells.len());
    }
}

fn floors() -> [(&'static str, Geometry, f64); 3] {
    let vertices = [(-1, -1), (1, -1), (1, 1), (-1, 1)].map(|(x, z)| Vec3::new(20.0 * x as f32, 0.0, 20.0 * z as f32));
    let mesh = Geometry::TriangleMesh { vertices: vertices.to_vec(), triangles: vec![[0, 2, 1], [0, 3, 2]] };
    [
        ("half-space", Geometry::HalfSpace { normal: Vec3::Y }, 0.0),
        ("box", Geometry::Box { half_extents: Vec3::new(20.0, 1.0, 20.0) }, -1.0),
        ("mesh", mesh, 0.0),
    ]
}

fn scene(floor: Geometry, y: f64, points: &[Vec3], pose: Pose, velocity: (Vec3, Vec3)) -> (World, BodyId) {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let ground = ShapeDef::new(Shape::new(floor).unwrap());
    world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, y, 0.0)).with_shape(ground)).unwrap();
    let solid = ShapeDef::new(hull(points.to_vec()).unwrap());
    let def = BodyDef { linear_velocity: velocity.0, angular_velocity: velocity.1, ..BodyDef::dynamic(pose).with_shape(solid) };
    let body = world.create_body(&def).unwrap();
    (world, body)
}

fn lowest(world: &World, body: BodyId, points: &[Vec3]) -> f64 {
    let pose = world.pose(body).unwrap();
    points.iter().map(|&point| pose.position.y + f64::from((pose.rotation * point).y)).fold(f64::MAX, f64::min)
}

#[test]
fn smooth_and_thin_hulls_come_to_rest_on_every_floor() {
    let solids = [
        ("lens", lens(0.3)),
        ("thin lens", lens(0.02)),
        ("prism of 400 sides", prism(400)),
        ("sphere of 4096 points", sphere(4096)),
        ("sheet of 1 mm", sheet(2.0, 0.001)),
        ("pane of 0.5 mm", sheet(1.0, 0.0005)),
    ];
    for (name, points) in solids {
        let bottom = points.iter().map(|point| f64::from(point.y)).fold(f64::MAX, f64::min);
        for (floor, form, y) in floors() {
            let (mut world, body) = scene(form, y, &points, Pose::at_xyz(0.0, 0.02 - bottom, 0.0), (Vec3::ZERO, Vec3::ZERO));
            for _ in 0..90 {
                world.step(1.0 / 60.0).unwrap();
            }
            let low = lowest(&world, body, &points);
            // What a resting contact may sink in or hover: a tenth of what boxes of a metre do.
            assert!(low.abs() < 2.0e-3, "{name} on a {floor} lies {low} m above it");
            // What has a flat or a broad side lies still; a sphere may go on rolling as slowly as it likes.
            let speed = world.linear_velocity(body).unwrap().length();
            let may_roll = points.len() == 4096;
            assert!(may_roll || speed < 0.02, "{name} on a {floor} still moves at {speed} m/s");
        }
    }
}

#[test]
fn round_hulls_roll() {
    // Over a facet of angle θ a rolling polygon loses about θ² of its energy: a prism of 400 sides 2.5e-4 each, 6 % in the
    // 240 facets that pass in 2 s; a sphere of 4096 points (θ near 0.05) three times that share over its 70.
    let lying = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    for (name, points, turn, least) in
        [("prism of 400 sides", prism(400), lying, 0.85), ("sphere of 4096 points", sphere(4096), Quat::IDENTITY, 0.7)]
    {
        for (floor, form, y) in floors() {
            let speed = 2.0_f32;
            let velocity = (Vec3::X * speed, Vec3::NEG_Z * speed);
            let (mut world, body) = scene(form, y, &points, Pose::at_xyz(-5.0, 1.0, 0.0).rotated(turn), velocity);
            for _ in 0..120 {
                world.step(1.0 / 60.0).unwrap();
            }
            let way = world.pose(body).unwrap().position.x + 5.0;
            assert!(way > least * 4.0 && way < 4.04, "{name} on a {floor} rolled {way} m of 4 m");
        }
    }
}

#[test]
fn what_is_refused_names_what_the_host_set() {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let error = hull(sheet(10.0, 0.0005)).unwrap_err();
    assert_eq!(error.argument, "points", "{error}");
    // A body whose shapes weigh too little for a body: the host gave a density, not a mass.
    let shape = ShapeDef { density: 1.0e-6, ..ShapeDef::new(hull(sheet(1.0e-3, 1.0e-4)).unwrap()) };
    let light = BodyDef { mass: Mass::FromShapes, ..BodyDef::dynamic(Pose::IDENTITY).with_shape(shape) };
    assert_eq!(world.create_body(&light).unwrap_err().argument, "density");
}
