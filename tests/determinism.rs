//! The same calls give the same bits.

use std::sync::Arc;

use crate::common::{self, Run, scene};
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    BodyDef, BodyId, CollisionFilter, Geometry, JointDef, JointKind, Limits, Material, Motor, ParallelFor, Pose, Shape, ShapeDef,
    Softness, Solver, World, WorldDef,
};
use longspan_scenes::Random;

fn hash_on(threads: usize, name: &str, keys: &[(&str, &str)]) -> u64 {
    Run::on_threads(scene(name, keys), threads).world().state_hash()
}

#[track_caller]
fn same_on_any_number_of_threads(name: &str, keys: &[(&str, &str)]) {
    let one = hash_on(1, name, keys);
    for threads in [2, 3, 5] {
        assert_eq!(hash_on(threads, name, keys), one, "{name}: state hashes on {threads} threads and on one");
    }
}

#[test]
fn a_pile_has_the_same_bits_on_any_number_of_threads() {
    same_on_any_number_of_threads("pile", &[("n", "1000"), ("seconds", "5")]);
}

#[test]
fn a_pile_that_is_swept_in_rounds_has_the_same_bits_on_any_number_of_threads() {
    let run = |threads| Run::on_threads(scene("pile", &[("n", "5000"), ("seconds", "1.2")]), threads);
    let one = run(1);
    let counts = one.world().report().counts;
    assert!(counts.bodies_awake - counts.islands > 4500, "{} islands", counts.islands);
    for threads in [2, 3] {
        assert_eq!(run(threads).world().state_hash(), one.world().state_hash(), "state hashes on {threads} threads and on one");
    }
}

/// A job system that does everything on the calling thread, the last part first.
struct Inline;

impl ParallelFor for Inline {
    fn run(&self, count: usize, part: &(dyn Fn(usize) + Sync)) {
        (0..count).rev().for_each(part);
    }
}

/// One with a thread for each part.
struct Crowd;

impl ParallelFor for Crowd {
    fn run(&self, count: usize, part: &(dyn Fn(usize) + Sync)) {
        std::thread::scope(|scope| (0..count).for_each(|number| drop(scope.spawn(move || part(number)))));
    }
}

/// State of a heap of boxes and balls that bounce and roll on a plate that turns: one island, large enough to be shared.
fn heap(threads: u32, jobs: Option<Arc<dyn ParallelFor>>) -> u64 {
    let mut world = World::new(&WorldDef { threads, ..WorldDef::default() }).unwrap();
    world.set_parallel_for(jobs);
    let top = ShapeDef::new(Shape::cuboid(Vec3::new(6.0, 0.5, 6.0)).unwrap());
    let plate = BodyDef { angular_velocity: Vec3::Y * 0.5, ..BodyDef::kinematic(Pose::IDENTITY) };
    world.create_body(&plate.with_shape(top)).unwrap();
    for i in 0..900 {
        let (layer, place) = (i / 100, i % 100);
        let jitter = 0.013 * f64::from(i * 7919 % 31);
        let position =
            DVec3::new(f64::from(place % 10) - 4.5 + jitter, 1.0 + 0.9 * f64::from(layer), f64::from(place / 10) - 4.5);
        let pose = Pose { position, rotation: Quat::from_rotation_y(0.1 * i as f32) };
        let shape = if i % 3 == 0 { Shape::ball(0.45) } else { Shape::cuboid(Vec3::splat(0.4)) }.unwrap();
        let (restitution, rolling_friction) = if i % 5 == 0 { (0.3, 0.02) } else { (0.0, 0.0) };
        let material = Material { restitution, rolling_friction, ..Material::default() };
        let shape = ShapeDef { material, ..ShapeDef::new(shape) };
        world.create_body(&BodyDef::dynamic(pose).with_shape(shape)).unwrap();
    }
    for _ in 0..45 {
        world.step(1.0 / 60.0).unwrap();
    }
    let counts = world.report().counts;
    assert!(counts.manifolds > 1500 && counts.islands < 100, "{} manifolds, {} islands", counts.manifolds, counts.islands);
    world.state_hash()
}

#[test]
fn any_job_system_and_any_number_of_threads_give_one_island_the_same_bits() {
    let one = heap(1, None);
    for threads in [2, 7] {
        assert_eq!(heap(threads, None), one, "state hashes on {threads} threads and on one");
    }
    assert_eq!(heap(1, Some(Arc::new(Inline))), one, "state hashes with all parts inline, backwards, and on one thread");
    assert_eq!(heap(1, Some(Arc::new(Crowd))), one, "state hashes with a thread a part and on one");
}

/// State of columns of boxes and balls that have fallen onto each other and lean, most of which lose the load of what rolls off them.
fn columns_that_lose_their_load(threads: u32) -> u64 {
    let mut world = World::new(&WorldDef { threads, ..WorldDef::default() }).unwrap();
    let ground = ShapeDef::new(Shape::new(Geometry::HalfSpace { normal: Vec3::Y }).unwrap());
    world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(ground)).unwrap();
    for i in 0..700 {
        let (layer, place) = (f64::from(i / 64), i % 64);
        let [x, z] = [place % 8, place / 8].map(|number| 1.05 * f64::from(number));
        let pose = Pose::at(DVec3::new(x + 0.01 * f64::from(i % 5), 0.6 + 1.02 * layer, z));
        let shape = if i % 3 == 0 { Shape::ball(0.5) } else { Shape::cuboid(Vec3::splat(0.5)) }.unwrap();
        world.create_body(&BodyDef::dynamic(pose).with_shape(ShapeDef::new(shape))).unwrap();
    }
    for _ in 0..60 {
        world.step(1.0 / 60.0).unwrap();
    }
    world.state_hash()
}

#[test]
fn columns_that_lose_their_load_have_the_same_bits_on_any_number_of_threads() {
    let one = columns_that_lose_their_load(1);
    for threads in [2, 4] {
        assert_eq!(columns_that_lose_their_load(threads), one, "state hashes on {threads} threads and on one");
    }
}

#[test]
fn a_pool_of_the_host_gives_the_same_bits_whoever_makes_the_step() {
    let pool = Arc::new(longspan::rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("the system gives threads"));
    let run = |pool: Option<Arc<longspan::rayon::ThreadPool>>| {
        let mut run = Run::on_threads(scene("large_pyramid", &[("base", "40"), ("seconds", "0.02")]), 1);
        let world = run.engine.world_mut();
        world.set_thread_pool(pool).expect("a pool that is there is taken");
        (0..10).for_each(|_| _ = world.step(longspan_scenes::DT).expect("the step length is valid"));
        world.set_thread_pool(None).expect("one thread is there");
        world.step(longspan_scenes::DT).expect("the step length is valid");
        run.world().state_hash()
    };
    let one = run(None);
    assert_eq!(run(Some(pool.clone())), one, "state hashes in a pool and on one thread");
    assert_eq!(
        pool.install(|| run(Some(pool.clone()))),
        one,
        "state hashes of a step made by the pool's own thread and on one thread"
    );
}

#[test]
fn a_tower_has_the_same_bits_on_any_number_of_threads_while_it_stands_and_falls() {
    same_on_any_number_of_threads("tower", &[("seconds", "11")]);
}

#[test]
fn a_pyramid_has_the_same_bits_on_any_number_of_threads_while_momentum_is_handed_down_in_it() {
    same_on_any_number_of_threads("large_pyramid", &[("base", "60"), ("seconds", "0.25")]);
}

#[test]
fn a_net_that_is_cut_into_strips_has_the_same_bits_on_any_number_of_threads() {
    same_on_any_number_of_threads("joint_grid", &[("n", "50"), ("seconds", "0.25")]);
    // Contacts have its joints swept with them.
    let with_a_guest = |threads| {
        let mut scene = scene("joint_grid", &[("n", "50"), ("seconds", "0.25")]);
        scene.bodies.iter_mut().flat_map(|body| &mut body.shapes).for_each(|shape| shape.filter = CollisionFilter::default());
        let mut guest = scene.bodies[scene.bodies.len() / 2 + 20].clone();
        guest.pose.position.z += 0.75;
        scene.bodies.push(guest);
        let run = Run::on_threads(scene, threads);
        assert!(run.world().report().counts.manifolds > 0, "the guest touches the net");
        run.world().state_hash()
    };
    let one = with_a_guest(1);
    for threads in [2, 4] {
        assert_eq!(with_a_guest(threads), one, "state hashes on {threads} threads and on one");
    }
}

#[test]
fn jointed_bodies_have_the_same_bits_on_any_number_of_threads() {
    same_on_any_number_of_threads("violent", &[("what", "joints"), ("n", "200"), ("seconds", "0.3")]);
}

#[test]
fn a_heap_of_ragdolls_has_the_same_bits_on_any_number_of_threads() {
    let heap = |threads| {
        let run = Run::on_threads(scene("ragdoll_pile", &[("n", "60"), ("seconds", "3.5")]), threads);
        let counts = run.world().report().counts;
        assert!(counts.manifolds > 1200 && counts.islands < 40, "{} manifolds, {} islands", counts.manifolds, counts.islands);
        run.world().state_hash()
    };
    let one = heap(1);
    for threads in [2, 3] {
        assert_eq!(heap(threads), one, "state hashes on {threads} threads and on one");
    }
}

#[test]
fn two_runs_have_the_same_bits() {
    let keys = [("n", "300"), ("seconds", "5")];
    assert_eq!(hash_on(1, "pile", &keys), hash_on(1, "pile", &keys), "state hashes of two runs");
}

/// Poses and velocities of the last `count` bodies after each step of a scene, with some of another scene's bodies created first.
fn states_beside(strangers: usize) -> Vec<Vec<(Pose, Vec3, Vec3)>> {
    let mut scene = scene("column", &[("n", "8"), ("scatter_mm", "100"), ("gap_mm", "20"), ("seconds", "3")]);
    let mut others = common::scene("pile", &[("n", "100")]).bodies;
    others.truncate(strangers);
    for def in &mut others {
        def.pose.position.x += 200.0;
    }
    let own = scene.bodies.len();
    scene.bodies.splice(0..0, others);
    scene.metrics.clear();
    let mut states = Vec::new();
    Run::watched(scene, |view| {
        let state = |body| (view.engine.pose(body), view.engine.linear_velocity(body), view.engine.angular_velocity(body));
        states.push((strangers..strangers + own).map(state).collect());
    });
    states
}

#[test]
fn unrelated_bodies_change_no_bit_of_an_island() {
    let alone = states_beside(0);
    let beside = states_beside(90);
    let differs = alone.iter().zip(&beside).position(|(alone, beside)| alone != beside);
    assert_eq!(differs, None, "first step after which a falling column differs beside 90 bodies 200 m away");
}

/// Poses of the bodies of two ragdolls in a pit after each step, with two others in a pit 200 m away that are dropped so much later (m
/// higher): with who has come to lie, and with who still tumbles, go others in lockstep.
fn ragdolls_beside(height: f64, solver: Solver) -> Vec<Vec<Pose>> {
    let mut own = scene("ragdoll_pile", &[("n", "2"), ("seconds", "4")]);
    let mut others = scene("ragdoll_pile", &[("n", "2")]);
    let count = own.bodies.len();
    for def in &mut others.bodies {
        def.pose.position.x += 200.0;
        if def.kind == longspan::BodyKind::Dynamic {
            def.pose.position.y += height;
        }
    }
    for end in others.joints.iter_mut().flat_map(|joint| [&mut joint.a, &mut joint.b]) {
        *end = end.map(|body| body + count);
    }
    own.bodies.append(&mut others.bodies);
    own.joints.append(&mut others.joints);
    own.metrics.clear();
    // Which units of a heap are held is looked at in turns that depend on the whole world: the promise is that of the solver.
    own.world.hold = false;
    own.world.solver = solver;
    let mut poses = Vec::new();
    Run::watched(own, |view| poses.push((0..count).map(|body| view.engine.pose(body)).collect()));
    poses
}

#[test]
fn what_tumbles_beside_a_ragdoll_in_lockstep_changes_no_bit_of_it() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        let first = ragdolls_beside(0.0, solver);
        for height in [1, 3] {
            let later = ragdolls_beside(f64::from(height), solver);
            let differs = first.iter().zip(&later).position(|(first, later)| first != later);
            assert_eq!(
                differs, None,
                "{solver:?}: first step after which ragdolls differ beside others that fall from {height} m higher"
            );
        }
    }
}

/// Makes a chain of boxes at `x` (m) that its joints draw together, and that collide with each other.
fn open_chain(world: &mut World, x: f64, speed: f32, random: &mut Random) -> Vec<BodyId> {
    let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.3)).unwrap());
    let mut boxes = Vec::new();
    for number in 0..8 {
        let place = Pose::at_xyz(x + 0.8 * f64::from(number), 5.0, 0.0);
        let (linear_velocity, angular_velocity) = (random.vector(speed), random.vector(speed));
        let def = BodyDef { linear_velocity, angular_velocity, ..BodyDef::dynamic(place).with_shape(cube.clone()) };
        let body = world.create_body(&def).unwrap();
        if let Some(&last) = boxes.last() {
            let joint = JointDef::new(JointKind::SPHERICAL, last, body).at(Vec3::X * 0.4 + random.vector(0.15), Vec3::X * -0.4);
            world.create_joint(&JointDef { collide_connected: true, ..joint }).unwrap();
        }
        boxes.push(body);
    }
    boxes
}

/// Makes a bar at a place that a motor on a joint to the world turns, which is solved by sweeps.
fn swept_bar(world: &mut World, place: Pose, limits: Limits, motor: Motor) {
    let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.3)).unwrap());
    let bar = world.create_body(&BodyDef::dynamic(place).with_shape(cube)).unwrap();
    let hinge = JointDef::new(JointKind::Hinge { limits, motor }, BodyId::NULL, bar);
    let hinge = JointDef { frame_a: place, solver: Solver::GaussSeidel, restitution: 0.5, ..hinge };
    world.create_joint(&hinge).unwrap();
}

const TURNS: Motor = Motor::Velocity { target: 0.3, max_force: f32::INFINITY };

/// Velocities of chains after each step, with bars that swept motors turn 500 m away.
fn chains_beside(bars: u32, seed: u64) -> Vec<Vec<[Vec3; 2]>> {
    let mut random = Random::new(seed);
    let mut world = World::new(&WorldDef::default()).unwrap();
    let mut boxes = Vec::new();
    for x in [0.0, 50.0, 100.0, 150.0, 200.0, 250.0] {
        for bar in 0..bars {
            swept_bar(&mut world, Pose::at_xyz(x, 2.0 * f64::from(bar), 500.0), Limits::NONE, TURNS);
        }
        boxes.extend(open_chain(&mut world, x, 20.0, &mut random));
    }
    let mut step = |_| {
        world.step(1.0 / 60.0).unwrap();
        boxes.iter().map(|&body| [world.linear_velocity(body).unwrap(), world.angular_velocity(body).unwrap()]).collect()
    };
    (0..20).map(&mut step).collect()
}

#[test]
fn motors_in_another_island_change_no_bit_of_one_without() {
    for seed in 0..6 {
        let alone = chains_beside(0, seed);
        for bars in [1, 2] {
            let beside = chains_beside(bars, seed);
            let differs = alone.iter().zip(&beside).position(|(alone, beside)| alone != beside);
            assert_eq!(differs, None, "seed {seed}: first step after which chains differ beside {bars} motors each");
        }
    }
}

/// Rows of joints that are swept one by one are laid out only where there are any: what is left of those of another scene must not be swept.
#[test]
fn what_a_world_has_stepped_before_a_restore_makes_no_difference() {
    let save = |world: &World| {
        let mut bytes = Vec::new();
        world.save(&mut bytes);
        bytes
    };
    let softness = Softness { compliance: 0.0, damping: 0.0 };
    let motors = [
        (Limits::NONE, TURNS),
        (Limits::NONE, Motor::Position { target: 0.3, softness, max_force: f32::INFINITY }),
        (Limits { min: -0.01, max: 0.01 }, Motor::Velocity { target: 9.0, max_force: 1.0e5 }),
    ];
    for (limits, motor) in motors {
        let mut driven = World::new(&WorldDef::default()).unwrap();
        swept_bar(&mut driven, Pose::IDENTITY, limits, motor);
        let driven = save(&driven);
        let mut used = World::new(&WorldDef::default()).unwrap();
        let mut random = Random::new(7);
        for round in 0..30 {
            let solver = [Solver::Auto, Solver::GaussSeidel][round % 2];
            let mut chain = World::new(&WorldDef { solver, ..WorldDef::default() }).unwrap();
            open_chain(&mut chain, 0.0, 50.0, &mut random);
            let chain = save(&chain);
            used.restore(&driven).unwrap();
            used.step(1.0 / 60.0).unwrap();
            used.restore(&chain).unwrap();
            let mut fresh = World::new(&WorldDef::default()).unwrap();
            fresh.restore(&chain).unwrap();
            for step in 0..20 {
                used.step(1.0 / 60.0).unwrap();
                fresh.step(1.0 / 60.0).unwrap();
                assert_eq!(used.state_hash(), fresh.state_hash(), "{motor:?}, {solver:?}, round {round}, step {step}");
            }
        }
    }
}
