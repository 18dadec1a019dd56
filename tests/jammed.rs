//! Joints and contacts that contradict one another: what is jammed may slip, but gains no energy.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, JointDef, JointId, JointKind, Mass, Pose, Shape, ShapeDef, Solver, World, WorldDef};

const GRAVITY: f64 = 9.81;

fn body(world: &mut World, pose: Pose, shape: Shape, mass: f32) -> BodyId {
    let def = BodyDef { mass: Mass::Total(mass), ..BodyDef::dynamic(pose) };
    world.create_body(&def.with_shape(ShapeDef::new(shape))).unwrap()
}

fn fixed(world: &mut World, pose: Pose, geometry: Geometry) -> BodyId {
    world.create_body(&BodyDef::fixed(pose).with_shape(ShapeDef::new(Shape::new(geometry).unwrap()))).unwrap()
}

fn floor(world: &mut World) {
    fixed(world, Pose::at_xyz(0.0, -1.0, 0.0), Geometry::Box { half_extents: Vec3::new(100.0, 1.0, 100.0) });
}

/// A chain of capsules from a point in the frame of `from` (m), with a ball at its end.
struct Chain {
    joints: Vec<JointId>,
    bodies: Vec<(BodyId, f64)>,
}

impl Chain {
    /// `links` as long as `length` (m) in this direction, of mass `link` (kg), and `load` (kg).
    fn new(
        world: &mut World,
        from: (BodyId, Vec3),
        start: DVec3,
        along: DVec3,
        links: usize,
        length: f64,
        [link, load]: [f32; 2],
    ) -> Self {
        let turn = Quat::from_rotation_arc(Vec3::Y, along.as_vec3());
        let (mut last, mut anchor) = from;
        let (mut joints, mut bodies) = (Vec::new(), Vec::new());
        let half = (0.5 * length) as f32;
        for i in 0..=links {
            let (reach, mass) = if i == links { (0.3, load) } else { (half, link) };
            let center = start + along * (length * i as f64 + f64::from(reach));
            let shape = if i == links { Shape::ball(0.3) } else { Shape::capsule(half - 0.04, 0.04) };
            let next = body(world, Pose { position: center, rotation: turn }, shape.unwrap(), mass);
            joints
                .push(world.create_joint(&JointDef::new(JointKind::SPHERICAL, last, next).at(anchor, Vec3::Y * -reach)).unwrap());
            bodies.push((next, f64::from(mass)));
            (last, anchor) = (next, Vec3::Y * reach);
        }
        Self { joints, bodies }
    }

    /// Energy of all bodies as points (J).
    fn energy(&self, world: &World) -> f64 {
        let of = |&(body, mass): &(BodyId, f64)| {
            let speed = world.linear_velocity(body).unwrap().as_dvec3().length_squared();
            mass * (0.5 * speed + GRAVITY * world.pose(body).unwrap().position.y)
        };
        self.bodies.iter().map(of).sum()
    }
}

/// Most that a chain with this weight (kg) gains when it is wound up, over the energy of one flung out, and its widest gap (m).
fn wind_up(rate: f32, weight: f32) -> [f64; 2] {
    let mut world = World::new(&WorldDef::default()).unwrap();
    floor(&mut world);
    let top = DVec3::new(0.0, 8.0, 0.0);
    let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.2)).unwrap());
    let drive = world.create_body(&BodyDef::kinematic(Pose::at(top)).with_shape(cube)).unwrap();
    let chain = Chain::new(&mut world, (drive, Vec3::Y * -0.2), top - DVec3::Y * 0.2, -DVec3::Y, 20, 0.2, [0.5, weight]);
    let before = chain.energy(&world);
    let flung_out = chain.bodies.iter().map(|(_, mass)| 0.5 * mass * (20.0_f64 * 4.3).powi(2)).sum::<f64>();
    let (mut gap, mut most) = (0.0_f32, before);
    for step in 1..=(4.0 * rate) as usize {
        if (step as f32) < 3.0 * rate {
            let turned = Quat::from_rotation_z(20.0 * step as f32 / rate);
            world.move_to(drive, Pose { position: top, rotation: turned }).unwrap();
        }
        gap = gap.max(world.step(1.0 / rate).unwrap().residuals.joint_gap);
        most = most.max(chain.energy(&world));
    }
    [(most - before) / flung_out, f64::from(gap)]
}

/// A box that turns at 20 rad/s winds up 4 m of chain with 100 kg, which comes to hang in its own turns. It can give them no more
/// than they have when they turn with it stretched out. How they come to hang is chaotic, so weights that differ by 10 g are tried. Of 24
/// runs at 60 steps a second eight had a gap of 5 to 47 cm for a moment, at 120 one of 2 cm; of 15 later three had, of 27
/// after that eleven, one of 3.4 m. Of nine, six may. The middle energy of twelve
/// at 240 steps a second was 0.6 to 1.8 once; of two sets a day apart it was 1.98 and 2.00, each between 1.7 and 2.3 but for one; of a later one 2.58, between
/// 2.38 and 2.66, when at 60 the chain was flung about in none of 30 runs and not in 6 of 60, and at 120 the middle one had fallen from 1.6 to 0.5.
fn winds_up_without_throwing(rate: f32, runs: u8) {
    let weights = (0..runs).map(|number| 100.0 + 0.01 * f32::from(number));
    let [mut gains, mut gaps] = [Vec::new(), Vec::new()];
    for [gain, gap] in weights.map(|weight| wind_up(rate, weight)) {
        gains.push(gain);
        gaps.push(gap);
    }
    for (of, numbers, share, [lower, most]) in
        [("times the energy of a chain flung out", &mut gains, 2, [3.0, 10.0]), ("m of gaps", &mut gaps, 3, [1.0e-3, 0.6])]
    {
        numbers.sort_by(f64::total_cmp);
        println!("{rate} steps a second: {numbers:.5?} {of}");
        let (some, most_of_them) = (numbers[usize::from((runs - 1) / share)], numbers[usize::from(3 * runs / 4)]);
        assert!(some < lower && most_of_them < most, "{rate} steps a second: {numbers:?} {of}");
    }
}

#[test]
fn a_chain_that_a_driven_box_winds_up_is_not_thrown_about() {
    winds_up_without_throwing(60.0, 9);
}

#[test]
fn a_chain_that_a_driven_box_winds_up_is_not_thrown_about_at_120() {
    winds_up_without_throwing(120.0, 3);
}

#[test]
fn a_chain_that_a_driven_box_winds_up_is_not_thrown_about_at_240() {
    winds_up_without_throwing(240.0, 3);
}

/// Greatest rise of the energy of a tonne at the end of a chain over a post, that begins so much higher (m), as a share of its fall's.
fn rise_over_a_post(rate: f32, substeps: u32, solver: Solver, higher: f64) -> f64 {
    let mut world = World::new(&WorldDef { substeps, solver, ..WorldDef::default() }).unwrap();
    floor(&mut world);
    let lying = Pose { position: DVec3::new(0.0, 5.0, 0.0), rotation: Quat::from_rotation_x(std::f32::consts::FRAC_PI_2) };
    fixed(&mut world, lying, Geometry::Cylinder { half_height: 1.0, radius: 0.5 });
    let start = DVec3::new(-2.5, 5.56 + higher, 0.0);
    let chain = Chain::new(&mut world, (BodyId::NULL, start.as_vec3()), start, DVec3::X, 30, 0.2, [0.5, 1000.0]);
    let before = chain.energy(&world);
    let mut most = before;
    for _ in 0..(10.0 * rate) as usize {
        world.step(1.0 / rate).unwrap();
        most = most.max(chain.energy(&world));
    }
    (most - before) / (1000.0 * GRAVITY * 5.56)
}

/// A tonne falls at the end of a chain that lies over a post, at steps in which a link turns by more than a radian. Mended positions
/// may lift it by 5 mm in a step. At 30 steps a second of one substep it is chance whether it rises at all: of 100 starts that differ by micrometres
/// 85 do not, and 4 rise by 5 to 7 %.
#[test]
fn a_tonne_on_a_chain_over_a_post_does_not_rise_higher_than_it_was() {
    for (rate, substeps, solver, starts) in [
        (30.0, 1, Solver::Auto, 10),
        (60.0, 1, Solver::Auto, 1),
        (60.0, 4, Solver::Auto, 1),
        (30.0, 1, Solver::GaussSeidel, 1),
        (60.0, 4, Solver::GaussSeidel, 1),
    ] {
        let mut rises: Vec<f64> =
            (0..starts).map(|start| rise_over_a_post(rate, substeps, solver, 1.0e-5 * f64::from(start))).collect();
        rises.sort_by(f64::total_cmp);
        println!("{rate} steps a second of {substeps}, {solver:?}: energy rises by {rises:.4?}");
        let (mostly, most) = (rises[rises.len() * 7 / 10], rises[rises.len() - 1]);
        assert!(
            mostly < 0.05 && most < 0.1,
            "{rate} steps a second of {substeps}, {solver:?}: energy has risen by {rises:.4?} of the fall's"
        );
    }
}

/// A chain with 100 kg that swings against its own links while it is handed from one solver to the other.
#[test]
fn a_chain_that_changes_solvers_as_it_hits_itself_keeps_its_energy() {
    let mut world = World::new(&WorldDef { substeps: 1, ..WorldDef::default() }).unwrap();
    floor(&mut world);
    let start = DVec3::new(0.0, 8.0, 0.0);
    let chain = Chain::new(&mut world, (BodyId::NULL, start.as_vec3()), start, DVec3::X, 20, 0.3, [1.0, 100.0]);
    let before = chain.energy(&world);
    let mut most = before;
    for step in 0..300 {
        if step % 8 == 7 {
            let solver = if step % 16 == 7 { Solver::GaussSeidel } else { Solver::Auto };
            chain.joints.iter().for_each(|&joint| world.set_joint_solver(joint, solver).unwrap());
        }
        world.step(1.0 / 30.0).unwrap();
        most = most.max(chain.energy(&world));
    }
    let rise = (most - before) / (100.0 * GRAVITY * 8.0);
    println!("energy rises by {rise:.1e}");
    assert!(rise < 0.01, "energy has risen by {rise:.4} of the fall's");
}
