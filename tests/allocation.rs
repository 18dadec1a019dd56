//! A step in which no pair is new and none touches for the first time takes no memory; what a body, a contact, a joint and a bound take.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use common::{Run, scene};
use longspan::glam::Vec3;
use longspan::{BodyDef, BodyId, Geometry, JointDef, JointKind, Mass, Pose, Shape, ShapeDef, Solver, World, WorldDef};
use longspan_scenes::DT;

/// The system's allocator, counting what this thread takes.
struct Counting;

thread_local! {
    static TAKEN: Cell<u64> = const { Cell::new(0) };
    static BYTES_HELD: Cell<i64> = const { Cell::new(0) };
}

fn note() {
    // Threads that are ending have no counter any more; none of them steps a world.
    let _ = TAKEN.try_with(|taken| taken.set(taken.get() + 1));
}

fn note_bytes(taken: usize, given_back: usize) {
    let _ = BYTES_HELD.try_with(|held| held.set(held.get() + taken as i64 - given_back as i64));
}

// SAFETY: every call is handed on unchanged to the system's allocator, which keeps the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        note_bytes(layout.size(), 0);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note();
        note_bytes(layout.size(), 0);
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note();
        note_bytes(size, layout.size());
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        note_bytes(0, layout.size());
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations in each of a hundred steps after a scene's end.
fn allocations_after(name: &str, keys: &[(&str, &str)]) -> (Vec<u64>, Run) {
    let mut run = Run::of(name, keys);
    let counts = (0..100).map(|_| {
        let before = TAKEN.get();
        run.engine.world_mut().step(DT).expect("the step length is valid");
        TAKEN.get() - before
    });
    (counts.collect(), run)
}

#[track_caller]
fn takes_no_memory(name: &str, keys: &[(&str, &str)]) {
    let (counts, run) = allocations_after(name, keys);
    let total: u64 = counts.iter().sum();
    let pairs = run.world().report().counts.pairs;
    assert_eq!(total, 0, "{name}: allocations in 100 steps at rest with {pairs} pairs, bound 0; by step {counts:?}");
}

#[test]
fn the_allocator_counts() {
    let before = TAKEN.get();
    std::hint::black_box(Vec::<u8>::with_capacity(100));
    assert_eq!(TAKEN.get() - before, 1, "allocations of one vector");
}

#[test]
fn boxes_balls_capsules_and_joints_at_rest_take_no_memory() {
    takes_no_memory("resting", &[]);
}

#[test]
fn a_swinging_chain_takes_no_memory() {
    takes_no_memory("hanging_chain", &[("n", "10"), ("ratio", "10"), ("seconds", "2")]);
}

#[test]
fn a_bridge_under_its_load_takes_no_memory() {
    takes_no_memory("footbridge", &[("seconds", "6")]);
}

#[test]
fn a_step_on_threads_of_a_pool_takes_the_note_that_calls_them_and_no_lists() {
    let mut run = Run::on_threads(scene("many_pyramids", &[("seconds", "0.2")]), 3);
    let counts: Vec<u64> = (0..10)
        .map(|_| {
            let before = TAKEN.get();
            run.engine.world_mut().step(DT).expect("the step length is valid");
            TAKEN.get() - before
        })
        .collect();
    // A queue of the pool may grow where threads come late, on a busy machine in three steps of ten; a list for each region, or for each piece,
    // would be dozens.
    let once = counts.iter().filter(|&&count| count <= 1).count();
    assert!(
        once >= 5 && counts.iter().all(|&count| count <= 8),
        "allocations of steps on three threads, mostly 1, at most 8: {counts:?}"
    );
}

#[test]
fn a_standing_tower_takes_no_memory() {
    takes_no_memory("tower", &[("bodies", "200"), ("ball", "off"), ("seconds", "2")]);
}

/// A rope that is tied, lies over a drum and bears a load: joints and contacts solved as one.
#[test]
fn a_rope_that_rests_on_a_drum_takes_no_memory() {
    use longspan::glam::{DVec3, Quat};
    let mut world = World::new(&WorldDef::default()).expect("the definition is valid");
    let shaped = |def: BodyDef, geometry| def.with_shape(ShapeDef::new(Shape::new(geometry).expect("the size is valid")));
    let upright = Pose { position: DVec3::ZERO, rotation: Quat::from_rotation_x(std::f32::consts::FRAC_PI_2) };
    let drum = Geometry::Cylinder { half_height: 0.5, radius: 0.3 };
    world.create_body(&shaped(BodyDef::fixed(upright), drum)).expect("the definition is valid");
    let point = |i: u8| {
        let angle = std::f64::consts::PI * (1.0 - f64::from(i) / 10.0);
        DVec3::new(angle.cos(), angle.sin(), 0.0) * 0.325
    };
    let (mut last, mut anchor) = (BodyId::NULL, point(0).as_vec3());
    for i in 0..14 {
        let down = |links: u8| point(10) - DVec3::Y * (0.1 * f64::from(links));
        let ends = match i {
            0..10 => [point(i), point(i + 1)],
            10..13 => [down(i - 10), down(i - 9)],
            _ => [down(3), down(7)],
        };
        let (way, position) = (ends[1] - ends[0], 0.5 * (ends[0] + ends[1]));
        let half = 0.5 * way.length() as f32;
        let pose = Pose { position, rotation: Quat::from_rotation_arc(Vec3::Y, way.normalize().as_vec3()) };
        let (geometry, mass) = match i {
            13 => (Geometry::Box { half_extents: Vec3::splat(0.2) }, 100.0),
            _ => (Geometry::Capsule { half_height: half - 0.02, radius: 0.02 }, 0.2),
        };
        let link = BodyDef { mass: Mass::Total(mass), can_sleep: false, ..BodyDef::dynamic(pose) };
        let link = world.create_body(&shaped(link, geometry)).expect("the definition is valid");
        let joint = JointDef::new(JointKind::SPHERICAL, last, link).at(anchor, Vec3::Y * -half);
        world.create_joint(&joint).expect("the definition is valid");
        (last, anchor) = (link, Vec3::Y * half);
    }
    let counts: Vec<u64> = (0..300)
        .map(|_| {
            let before = TAKEN.get();
            world.step(DT).expect("the step length is valid");
            TAKEN.get() - before
        })
        .collect();
    assert!(world.awake_body_count() > 10, "only {} bodies are awake", world.awake_body_count());
    assert_eq!(counts[200..].iter().sum::<u64>(), 0, "allocations in 100 steps at rest, bound 0; by step {:?}", &counts[200..]);
}

#[test]
fn judging_an_arch_by_thrust_takes_no_memory() {
    // After a second its stones are braced, and not held yet: the hold takes some when it first looks at them.
    let of = |thrust: &str| allocations_after("arch", &[("support", "on"), ("thrust", thrust), ("seconds", "1")]).0;
    assert_eq!(of("on"), of("off"), "allocations by step, with thrust and without");
}

#[test]
fn a_sleeping_world_takes_no_memory() {
    let (counts, run) = allocations_after("idle", &[("what", "asleep"), ("n", "100")]);
    assert_eq!(run.world().awake_body_count(), 0, "bodies awake");
    assert_eq!(counts.iter().sum::<u64>(), 0, "allocations in 100 steps asleep, bound 0; by step {counts:?}");
}

/// A world of `count` boxes side by side, a metre apart, and what it has added to it by `add`: bytes that it holds after five steps, and
/// the world.
fn held_by(count: usize, gravity: f32, add: impl Fn(&mut World, &[BodyId])) -> (f64, World) {
    let before = BYTES_HELD.get();
    let def = WorldDef { gravity: Vec3::NEG_Y * gravity, solver: Solver::GaussSeidel, ..WorldDef::default() };
    let mut world = World::new(&def).expect("the definition is valid");
    let shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.25)).expect("the size is valid"));
    let boxes: Vec<BodyId> = (0..count)
        .map(|place| {
            let def = BodyDef::dynamic(Pose::at_xyz(place as f64, 0.25, 0.0)).with_shape(shape.clone());
            world.create_body(&def).expect("the definition is valid")
        })
        .collect();
    add(&mut world, &boxes);
    for _ in 0..5 {
        world.step(DT).expect("the step length is valid");
    }
    let held = BYTES_HELD.get() - before - (boxes.capacity() * size_of::<BodyId>()) as i64;
    (held as f64, world)
}

/// Joints between neighbours, half way.
fn link(world: &mut World, boxes: &[BodyId], long_range: bool) {
    for two in boxes.windows(2) {
        let mut def = JointDef::new(JointKind::SPHERICAL, two[0], two[1]).at(Vec3::X * 0.5, Vec3::X * -0.5);
        def.long_range = long_range;
        world.create_joint(&def).expect("the definition is valid");
    }
}

/// As docs/lab/performance.md says. Room grows by leaps, here by those of a thousand of each.
#[test]
fn a_body_a_contact_a_joint_and_a_bound_take_the_memory_that_is_stated() {
    let floor = |world: &mut World, _: &[BodyId]| {
        let solid = ShapeDef::new(Shape::cuboid(Vec3::new(1000.0, 0.5, 2.0)).expect("the size is valid"));
        world.create_body(&BodyDef::fixed(Pose::at_xyz(500.0, -0.5, 0.0)).with_shape(solid)).expect("the definition is valid");
    };
    const COUNT: usize = 1000;
    let (alone, _) = held_by(COUNT, 0.0, |_, _| {});
    let (lying, on_floor) = held_by(COUNT, 9.81, floor);
    let (linked, chain) = held_by(COUNT, 0.0, |world, boxes| link(world, boxes, false));
    let (bound, with_bounds) = held_by(COUNT, 0.0, |world, boxes| link(world, boxes, true));

    let counts = [&on_floor, &chain, &with_bounds].map(|world| world.report().counts);
    let found = [
        ("a body of one shape", alone / COUNT as f64, 1700.0),
        ("a manifold of four points", (lying - alone) / f64::from(counts[0].manifolds), 1650.0),
        ("a joint", (linked - alone) / f64::from(counts[1].joints), 3000.0),
        ("a bound", (bound - linked) / f64::from(counts[2].bounds), 1500.0),
    ];
    for (what, bytes, most) in found {
        println!("{what}: {bytes:.0} bytes");
        assert!(bytes > 0.0 && bytes <= most, "{what} takes {bytes:.0} bytes, bound {most}; counted {counts:?}");
    }
}
