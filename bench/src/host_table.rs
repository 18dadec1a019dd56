//! What a host asks of a world between its steps, as tables for the guide: snapshots against a step, and thousands of edits.

use cpu_time::ThreadTime;
use longspan::glam::Vec3;
use longspan::{
    BodyDef, BodyId, CollisionFilter, Geometry, JointDef, JointId, JointKind, Mass, Material, Pose, Result as Refusable, Shape,
    ShapeDef, ShapeId, World,
};
use longspan_scenes::{Effort, Engine, LongspanEngine, build};

type Problem = Box<dyn std::error::Error>;

/// A scene, its keys, and the steps after which it is saved.
type Saved = (&'static str, &'static [(&'static str, &'static str)], u32);

/// Scenes that are saved and restored, with the steps after which that is done.
const SAVED: [Saved; 6] =
    [("tower", &[], 10), ("tower", &[], 60), ("pile", &[], 200), ("pile", &[], 600), ("rope_bridge", &[], 60), ("vase", &[], 30)];

/// Edits of one kind made between two steps; the second number shows whether the time of each depends on how many there are.
const EDITS: [usize; 2] = [1250, 5000];

/// Prints both tables; `repeats` is the number of times that everything timed is done, of which the median is told.
pub fn print(repeats: usize) -> Result<(), Problem> {
    println!(
        "| scene | step | bodies | points | bytes | a body | bytes − 64 a point, a body | save (ms) | restore (ms) | step (ms) | restore ÷ step |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, keys, after) in SAVED {
        print_snapshot(name, keys, after, repeats)?;
    }
    println!("\n| edit | bodies | each (µs), of {} | each (µs), of {} | steps before and after (ms) |", EDITS[0], EDITS[1]);
    println!("|---|---|---|---|---|");
    for edit in EDIT_KINDS {
        print_edit(edit, repeats.min(5))?;
    }
    Ok(())
}

/// A scene at default effort on one thread, after some steps.
fn after(steps: u32, name: &str, keys: &[(&str, &str)]) -> Result<(LongspanEngine, f32), Problem> {
    let keys: Vec<(String, String)> = keys.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    let scene = build(name, &keys)?;
    let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1)?;
    for def in &scene.bodies {
        engine.add_body(def);
    }
    for joint in &scene.joints {
        engine.add_joint(joint);
    }
    for _ in 0..steps {
        engine.step(scene.dt);
    }
    match engine.refusal() {
        None => Ok((engine, scene.dt)),
        Some(problem) => Err(format!("{name}: {problem}").into()),
    }
}

fn print_snapshot(name: &str, keys: &[(&str, &str)], after_steps: u32, repeats: usize) -> Result<(), Problem> {
    let (mut engine, dt) = after(after_steps, name, keys)?;
    let world = engine.world_mut();
    let mut bytes = Vec::new();
    world.save(&mut bytes);
    let points: usize = world.contacts().map(|contact| contact.points().len()).sum();
    let bodies = world.body_count();
    let (mut saving, mut restoring, mut stepping) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..repeats {
        world.restore(&bytes)?;
        // The first step after a restore is none like the others: boxes and graphs are made anew.
        world.step(dt)?;
        let clock = ThreadTime::now();
        world.step(dt)?;
        stepping.push(milliseconds(clock));
        let clock = ThreadTime::now();
        world.restore(&bytes)?;
        restoring.push(milliseconds(clock));
        let mut again = Vec::with_capacity(bytes.len());
        let clock = ThreadTime::now();
        world.save(&mut again);
        saving.push(milliseconds(clock));
    }
    let (save, restore, step) = (median(&mut saving), median(&mut restoring), median(&mut stepping));
    let each = |bytes: f64| bytes / bodies as f64;
    println!(
        "| {name} | {after_steps} | {bodies} | {points} | {} | {:.0} | {:.0} | {save:.2} | {restore:.2} | {step:.2} | {:.2} |",
        bytes.len(),
        each(bytes.len() as f64),
        each(bytes.len() as f64 - 64.0 * points as f64),
        restore / step,
    );
    Ok(())
}

fn milliseconds(since: ThreadTime) -> f64 {
    since.elapsed().as_secs_f64() * 1.0e3
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A kind of edit: its name, the scene that it is done in, the steps before, and what is done for the n-th time.
struct EditKind {
    name: &'static str,
    scene: (&'static str, &'static [(&'static str, &'static str)]),
    steps: u32,
    make: fn(&mut Edited, usize) -> Refusable<()>,
}

/// A world under edits, with what it held at first.
struct Edited {
    world: World,
    bodies: Vec<BodyId>,
    shapes: Vec<ShapeId>,
    joints: Vec<JointId>,
    /// The first body, which is static.
    ground: BodyId,
    solid: ShapeDef,
}

const AWAKE: (&str, &[(&str, &str)]) = ("many_pyramids", &[]);
const ASLEEP: (&str, &[(&str, &str)]) = ("idle", &[("what", "asleep")]);
const JOINTED: (&str, &[(&str, &str)]) = ("ragdoll_rain", &[("n", "700")]);

const EDIT_KINDS: &[EditKind] = &[
    EditKind { name: "mass, awake", scene: AWAKE, steps: 20, make: set_mass },
    EditKind { name: "mass, asleep", scene: ASLEEP, steps: 60, make: set_mass },
    EditKind { name: "form of a shape, awake", scene: AWAKE, steps: 20, make: set_form },
    EditKind { name: "form of a shape, asleep", scene: ASLEEP, steps: 60, make: set_form },
    EditKind { name: "surface of a shape", scene: AWAKE, steps: 20, make: set_surface },
    EditKind { name: "filter of a shape", scene: AWAKE, steps: 20, make: set_filter },
    EditKind { name: "impulse", scene: AWAKE, steps: 20, make: push },
    EditKind { name: "teleport, awake", scene: AWAKE, steps: 20, make: teleport },
    EditKind { name: "teleport, asleep", scene: ASLEEP, steps: 60, make: teleport },
    EditKind { name: "wake", scene: ASLEEP, steps: 60, make: wake },
    EditKind { name: "create a body", scene: AWAKE, steps: 20, make: create },
    EditKind { name: "destroy a body, awake", scene: AWAKE, steps: 20, make: destroy },
    EditKind { name: "destroy a body, asleep", scene: ASLEEP, steps: 60, make: destroy },
    EditKind { name: "attach a shape to the ground", scene: AWAKE, steps: 20, make: attach },
    EditKind { name: "joint to the ground", scene: AWAKE, steps: 20, make: tie },
    EditKind { name: "limits of a joint", scene: JOINTED, steps: 20, make: set_limits },
    EditKind { name: "frames of a joint", scene: JOINTED, steps: 20, make: set_frames },
    EditKind { name: "destroy a joint", scene: JOINTED, steps: 20, make: cut },
];

fn set_mass(edited: &mut Edited, n: usize) -> Refusable<()> {
    edited.world.set_mass(edited.bodies[n], Mass::Total(2.0))
}

fn set_form(edited: &mut Edited, n: usize) -> Refusable<()> {
    edited.world.set_shape_def(edited.shapes[n], &edited.solid)
}

fn set_surface(edited: &mut Edited, n: usize) -> Refusable<()> {
    edited.world.set_material(edited.shapes[n], Material { friction: 0.7, ..Material::default() })
}

fn set_filter(edited: &mut Edited, n: usize) -> Refusable<()> {
    edited.world.set_filter(edited.shapes[n], CollisionFilter { member_of: 3, collides_with: u32::MAX })
}

fn push(edited: &mut Edited, n: usize) -> Refusable<()> {
    edited.world.add_impulse(edited.bodies[n], Vec3::X)
}

fn teleport(edited: &mut Edited, n: usize) -> Refusable<()> {
    let mut pose = edited.world.pose(edited.bodies[n])?;
    pose.position.y += 40.0;
    edited.world.set_pose(edited.bodies[n], pose)
}

fn wake(edited: &mut Edited, n: usize) -> Refusable<()> {
    edited.world.wake(edited.bodies[n])
}

fn create(edited: &mut Edited, n: usize) -> Refusable<()> {
    let along = |place: usize| 1.2 * place as f64 - 42.0;
    let pose = Pose::at_xyz(along(n % 71), 40.0, along(n / 71));
    edited.world.create_body(&BodyDef::dynamic(pose).with_shape(edited.solid.clone())).map(drop)
}

fn destroy(edited: &mut Edited, n: usize) -> Refusable<()> {
    edited.world.destroy_body(edited.bodies[n])
}

fn attach(edited: &mut Edited, n: usize) -> Refusable<()> {
    let mut def = edited.solid.clone();
    def.local_pose.position = Vec3::new((n % 71) as f32 * 2.0 - 71.0, 50.0, (n / 71) as f32 * 2.0 - 71.0);
    edited.world.attach_shape(edited.ground, &def).map(drop)
}

fn tie(edited: &mut Edited, n: usize) -> Refusable<()> {
    let place = edited.world.pose(edited.bodies[n])?;
    let ground = edited.world.pose(edited.ground)?;
    let mut def = JointDef::new(JointKind::SPHERICAL, edited.ground, edited.bodies[n]);
    def.frame_a = Pose::at(place.position - ground.position);
    edited.world.create_joint(&def).map(drop)
}

fn set_limits(edited: &mut Edited, n: usize) -> Refusable<()> {
    let mut kind = edited.world.joint_def(edited.joints[n])?.kind;
    match &mut kind {
        JointKind::Hinge { limits, .. } => limits.max += 0.01,
        JointKind::Spherical { swing_limit, .. } => *swing_limit *= 0.99,
        _ => {}
    }
    edited.world.set_joint_kind(edited.joints[n], kind)
}

fn set_frames(edited: &mut Edited, n: usize) -> Refusable<()> {
    let def = edited.world.joint_def(edited.joints[n])?;
    edited.world.set_joint_frames(edited.joints[n], def.frame_a, def.frame_b)
}

fn cut(edited: &mut Edited, n: usize) -> Refusable<()> {
    edited.world.destroy_joint(edited.joints[n])
}

fn print_edit(kind: &EditKind, repeats: usize) -> Result<(), Problem> {
    let (mut engine, dt) = after(kind.steps, kind.scene.0, kind.scene.1)?;
    let (mut before, mut saved) = (Vec::new(), Vec::new());
    engine.world().save(&mut saved);
    let bodies = engine.world().body_count();
    let world = std::mem::replace(engine.world_mut(), World::new(&longspan::WorldDef::default())?);
    let mut edited = edited(world)?;
    let (mut each, mut after) = ([0.0; 2], Vec::new());
    for (count, each) in EDITS.into_iter().zip(&mut each) {
        let mut times = Vec::new();
        for _ in 0..repeats {
            edited.world.restore(&saved)?;
            edited.world.step(dt)?;
            before.push(timed(&mut edited.world, dt)?);
            let clock = ThreadTime::now();
            for n in 0..count {
                (kind.make)(&mut edited, n)?;
            }
            times.push(milliseconds(clock) * 1.0e3 / count as f64);
            after.push(timed(&mut edited.world, dt)?);
        }
        *each = median(&mut times);
    }
    let steps = (median(&mut before), median(&mut after[repeats..]));
    println!("| {} | {bodies} | {:.2} | {:.2} | {:.2}, {:.2} |", kind.name, each[0], each[1], steps.0, steps.1);
    Ok(())
}

fn edited(world: World) -> Result<Edited, Problem> {
    let bodies: Vec<BodyId> = world.bodies().collect();
    let (ground, bodies) = bodies.split_first().ok_or("the scene has bodies")?;
    let mut shapes = Vec::with_capacity(bodies.len());
    for &body in bodies {
        shapes.push(*world.body_shapes(body)?.first().ok_or("every body has a shape")?);
    }
    let solid = ShapeDef::new(Shape::new(Geometry::Box { half_extents: Vec3::splat(0.3) })?);
    Ok(Edited { joints: world.joints().collect(), bodies: bodies.to_vec(), shapes, ground: *ground, solid, world })
}

fn timed(world: &mut World, dt: f32) -> Result<f64, Problem> {
    let clock = ThreadTime::now();
    world.step(dt)?;
    Ok(milliseconds(clock))
}
