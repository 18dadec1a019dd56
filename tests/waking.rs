//! Whatever changes the motion or the load of something wakes what joints, contacts and unions connect to it.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{
    ArticulationSettings, BodyDef, BodyId, BodyKind, CollisionFilter, FractureSettings, JointDef, JointId, JointKind, Limits,
    LockedAxes, LongRangeDef, Mass, Material, Motor, Pose, Shape, ShapeDef, ShapeId, SleepSettings, SoftBound, Softness, Solver,
    Strength, World, WorldDef,
};

const DT: f32 = 1.0 / 60.0;

fn cube(half: f32) -> ShapeDef {
    ShapeDef::new(Shape::cuboid(Vec3::splat(half)).unwrap())
}

fn strong(newtons: f32) -> Strength {
    Strength { tension: newtons, compression: newtons, shear: newtons, ..Strength::UNBREAKABLE }
}

/// Every kind of joint that holds a body below another, by its name.
fn kinds() -> [(&'static str, JointKind); 6] {
    let locked = longspan::Axis::LOCKED;
    let free = longspan::Axis::FREE;
    [
        ("fixed", JointKind::Fixed),
        ("hinge", JointKind::HINGE),
        ("spherical", JointKind::SPHERICAL),
        ("distance", JointKind::Distance { limits: Limits::new(0.0, 1.0e-3), spring_length: None, motor: Motor::Off }),
        // Its axis is x, across gravity.
        ("prismatic", JointKind::Prismatic { limits: Limits::new(-0.1, 0.1), motor: Motor::Off }),
        ("generic", JointKind::Generic { linear: [locked; 3], angular: [free, locked, locked] }),
    ]
}

/// A joint of this kind between a body and the one a metre below it.
fn hung(kind: JointKind, upper: BodyId, lower: BodyId) -> JointDef {
    JointDef::new(kind, upper, lower).at(Vec3::ZERO, Vec3::Y)
}

/// Things that sleep, connected in every way to what the edits of the table below change.
struct Scene {
    world: World,
    /// Moves as the host says; `bob` hangs on it.
    hub: BodyId,
    bob: BodyId,
    /// Free; hangs on the world by `hook`, and `load` on it.
    link: BodyId,
    hook: JointId,
    load: BodyId,
    pin: JointId,
    /// Static; `arm` is welded to it, and `lamp` hangs on the arm.
    post: BodyId,
    arm: BodyId,
    lamp: BodyId,
    weld: JointId,
    /// Static; `crate_` lies on it and carries `top`.
    floor: BodyId,
    crate_: BodyId,
    top: BodyId,
    /// Lies on another floor and has nothing to do with any of it.
    bystander: BodyId,
}

impl Scene {
    fn new(kind: JointKind) -> Self {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let mut body = |def: BodyDef, at: [f64; 3], half: f32| {
            let pose = Pose::at_xyz(at[0], at[1], at[2]);
            world.create_body(&BodyDef { pose, ..def }.with_shape(cube(half))).unwrap()
        };
        let fixed = || BodyDef::fixed(Pose::IDENTITY);
        let free = || BodyDef::dynamic(Pose::IDENTITY);
        let hub = body(BodyDef::kinematic(Pose::IDENTITY), [0.0, 5.0, 0.0], 0.1);
        let bob = body(free(), [0.0, 4.0, 0.0], 0.2);
        let link = body(free(), [3.0, 5.0, 0.0], 0.1);
        let load = body(free(), [3.0, 4.0, 0.0], 0.2);
        let post = body(fixed(), [6.0, 5.0, 0.0], 0.1);
        let arm = body(free(), [6.0, 4.0, 0.0], 0.1);
        let lamp = body(free(), [6.0, 3.0, 0.0], 0.2);
        let floor = body(fixed(), [9.0, -1.0, 0.0], 1.0);
        let crate_ = body(free(), [9.0, 0.25, 0.0], 0.25);
        let top = body(free(), [9.0, 0.75, 0.0], 0.25);
        body(fixed(), [15.0, -1.0, 0.0], 1.0);
        let bystander = body(free(), [15.0, 0.25, 0.0], 0.25);
        world.create_joint(&hung(kind, hub, bob)).unwrap();
        let hook = JointDef::new(kind, BodyId::NULL, link).at(Vec3::new(3.0, 5.0, 0.0), Vec3::ZERO);
        let hook = world.create_joint(&hook).unwrap();
        let pin = world.create_joint(&hung(kind, link, load)).unwrap();
        let weld = world.create_joint(&hung(JointKind::Fixed, post, arm)).unwrap();
        world.create_joint(&hung(kind, arm, lamp)).unwrap();
        world.step(DT).unwrap();
        world.step(DT).unwrap();
        let mut scene = Self { world, hub, bob, link, hook, load, pin, post, arm, lamp, weld, floor, crate_, top, bystander };
        for body in [scene.bob, scene.load, scene.lamp, scene.top, scene.bystander] {
            scene.world.put_to_sleep(body).unwrap();
        }
        assert_eq!(scene.awake(), [], "everything sleeps at first");
        scene
    }

    fn shape(&self, body: BodyId) -> ShapeId {
        self.world.body_shapes(body).unwrap()[0]
    }

    /// Those of the sleepers that are awake.
    fn awake(&self) -> Vec<Sleeper> {
        let bodies = [(Bob, self.bob), (Load, self.load), (Lamp, self.lamp), (Top, self.top), (Bystander, self.bystander)];
        bodies.into_iter().filter(|&(_, body)| self.world.is_awake(body).unwrap()).map(|(name, _)| name).collect()
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Sleeper {
    Bob,
    Load,
    Lamp,
    Top,
    Bystander,
}
use Sleeper::{Bob, Bystander, Lamp, Load, Top};

const ALL: &[Sleeper] = &[Bob, Load, Lamp, Top, Bystander];

/// An edit by its name in the C API, and who is awake a step later.
type Row = (&'static str, &'static [Sleeper], fn(&mut Scene));

/// Where hubs are put.
const POSE: Pose = Pose { position: DVec3::new(0.5, 5.0, 0.0), rotation: Quat::IDENTITY };
const GIVE: Softness = Softness { compliance: 1.0e-4, damping: 1.0 };

/// The same kind of joint with other limits.
fn relimited(kind: JointKind) -> JointKind {
    match kind {
        JointKind::Fixed => JointKind::Fixed,
        JointKind::Hinge { motor, .. } => JointKind::Hinge { limits: Limits::new(-1.0, 1.0), motor },
        JointKind::Spherical { twist_limits, motor, .. } => JointKind::Spherical { swing_limit: 1.0, twist_limits, motor },
        JointKind::Distance { spring_length, motor, .. } => {
            JointKind::Distance { limits: Limits::new(0.0, 2.0e-3), spring_length, motor }
        }
        JointKind::Prismatic { motor, .. } => JointKind::Prismatic { limits: Limits::new(-0.2, 0.2), motor },
        JointKind::Generic { angular, .. } => JointKind::Generic { linear: [longspan::Axis::limited(-0.01, 0.01); 3], angular },
        other => other,
    }
}

const ROWS: &[Row] = &[
    ("ls_body_create", &[Top], |s| create(s, BodyKind::Static)),
    ("ls_body_create", &[Top], |s| create(s, BodyKind::Kinematic)),
    ("ls_body_create", &[Top], |s| create(s, BodyKind::Dynamic)),
    ("ls_body_destroy", &[Bob], |s| s.world.destroy_body(s.hub).unwrap()),
    ("ls_body_destroy", &[Load], |s| s.world.destroy_body(s.link).unwrap()),
    ("ls_body_destroy", &[Lamp], |s| s.world.destroy_body(s.post).unwrap()),
    ("ls_body_destroy", &[Lamp], |s| s.world.destroy_body(s.arm).unwrap()),
    ("ls_body_destroy", &[Top], |s| s.world.destroy_body(s.floor).unwrap()),
    ("ls_body_destroy", &[Top], |s| s.world.destroy_body(s.crate_).unwrap()),
    ("ls_body_pose_set", &[Bob], |s| s.world.set_pose(s.hub, POSE).unwrap()),
    ("ls_body_pose_set", &[Load], |s| s.world.set_pose(s.link, Pose::at_xyz(3.01, 5.0, 0.0)).unwrap()),
    ("ls_body_pose_set", &[Lamp], |s| s.world.set_pose(s.post, Pose::at_xyz(6.5, 5.0, 0.0)).unwrap()),
    ("ls_body_pose_set", &[Top], |s| s.world.set_pose(s.floor, Pose::at_xyz(9.0, -2.0, 0.0)).unwrap()),
    ("ls_body_linear_velocity_set", &[Bob], |s| s.world.set_linear_velocity(s.hub, Vec3::X).unwrap()),
    ("ls_body_linear_velocity_set", &[Load], |s| s.world.set_linear_velocity(s.link, Vec3::X).unwrap()),
    ("ls_body_linear_velocity_set", &[Top], |s| s.world.set_linear_velocity(s.crate_, Vec3::X).unwrap()),
    ("ls_body_angular_velocity_set", &[Bob], |s| s.world.set_angular_velocity(s.hub, Vec3::Z).unwrap()),
    ("ls_body_angular_velocity_set", &[Load], |s| s.world.set_angular_velocity(s.link, Vec3::Z).unwrap()),
    ("ls_body_move_to", &[Bob], |s| s.world.move_to(s.hub, POSE).unwrap()),
    ("ls_body_kind_set", &[Bob], |s| s.world.set_body_kind(s.hub, BodyKind::Dynamic).unwrap()),
    ("ls_body_kind_set", &[Bob], |s| s.world.set_body_kind(s.hub, BodyKind::Static).unwrap()),
    ("ls_body_kind_set", &[Lamp], |s| s.world.set_body_kind(s.post, BodyKind::Dynamic).unwrap()),
    ("ls_body_kind_set", &[Top], |s| s.world.set_body_kind(s.floor, BodyKind::Dynamic).unwrap()),
    ("ls_body_kind_set", &[Top], |s| s.world.set_body_kind(s.crate_, BodyKind::Kinematic).unwrap()),
    ("ls_body_mass_set", &[Load], |s| s.world.set_mass(s.link, Mass::Total(900.0)).unwrap()),
    ("ls_body_mass_set", &[Lamp], |s| s.world.set_mass(s.arm, Mass::Total(900.0)).unwrap()),
    ("ls_body_mass_set", &[Top], |s| s.world.set_mass(s.crate_, Mass::Total(900.0)).unwrap()),
    ("ls_body_damping_set", &[Load], |s| s.world.set_damping(s.link, 1.0, 1.0).unwrap()),
    ("ls_body_gravity_scale_set", &[Load], |s| s.world.set_gravity_scale(s.link, -1.0).unwrap()),
    ("ls_body_gravity_scale_set", &[Top], |s| s.world.set_gravity_scale(s.crate_, -1.0).unwrap()),
    ("ls_body_locked_axes_set", &[Load], |s| {
        let locked = LockedAxes { translation: [true, false, false], rotation: [false; 3] };
        s.world.set_locked_axes(s.link, locked).unwrap();
    }),
    ("ls_body_locked_axes_set", &[Lamp], |s| {
        let locked = LockedAxes { translation: [true, false, false], rotation: [false; 3] };
        s.world.set_locked_axes(s.arm, locked).unwrap();
    }),
    ("ls_body_can_sleep_set", &[Load], |s| s.world.set_can_sleep(s.link, false).unwrap()),
    ("ls_body_wake", &[Load], |s| s.world.wake(s.link).unwrap()),
    ("ls_body_force_add", &[Load], |s| s.world.add_force(s.link, Vec3::X).unwrap()),
    ("ls_body_force_add_at", &[Top], |s| s.world.add_force_at(s.crate_, Vec3::X, DVec3::new(9.0, 0.25, 0.0)).unwrap()),
    ("ls_body_torque_add", &[Load], |s| s.world.add_torque(s.link, Vec3::X).unwrap()),
    ("ls_body_impulse_add", &[Load], |s| s.world.add_impulse(s.link, Vec3::X).unwrap()),
    ("ls_body_impulse_add_at", &[Top], |s| s.world.add_impulse_at(s.crate_, Vec3::X, DVec3::new(9.0, 0.25, 0.0)).unwrap()),
    ("ls_body_angular_impulse_add", &[Load], |s| s.world.add_angular_impulse(s.link, Vec3::X).unwrap()),
    ("ls_shape_attach", &[Load], |s| s.world.attach_shape(s.link, &cube(0.05)).map(drop).unwrap()),
    ("ls_shape_attach", &[Top], |s| {
        let local_pose = longspan::LocalPose { position: Vec3::new(0.0, 1.1, 0.0), ..longspan::LocalPose::IDENTITY };
        s.world.attach_shape(s.floor, &ShapeDef { local_pose, ..cube(0.2) }).map(drop).unwrap();
    }),
    ("ls_shape_destroy", &[Top], |s| s.world.destroy_shape(s.shape(s.floor)).unwrap()),
    ("ls_shape_def_set", &[Load], |s| s.world.set_shape_def(s.shape(s.link), &cube(0.12)).unwrap()),
    ("ls_shape_def_set", &[Top], |s| s.world.set_shape_def(s.shape(s.floor), &cube(1.1)).unwrap()),
    ("ls_shape_def_set", &[Top], |s| s.world.set_shape_def(s.shape(s.crate_), &cube(0.2)).unwrap()),
    ("ls_shape_material_set", &[Top], |s| {
        s.world.set_material(s.shape(s.floor), Material { friction: 0.0, ..Material::default() }).unwrap();
    }),
    ("ls_shape_material_set", &[Top], |s| {
        s.world.set_material(s.shape(s.crate_), Material { friction: 0.0, ..Material::default() }).unwrap();
    }),
    ("ls_shape_filter_set", &[Top], |s| {
        s.world.set_filter(s.shape(s.floor), CollisionFilter { collides_with: 0, ..CollisionFilter::default() }).unwrap();
    }),
    ("ls_shape_filter_set", &[Top], |s| {
        s.world.set_filter(s.shape(s.crate_), CollisionFilter { collides_with: 0, ..CollisionFilter::default() }).unwrap();
    }),
    ("ls_joint_create", &[Bob], |s| s.world.create_joint(&hung(JointKind::SPHERICAL, s.hub, s.bob)).map(drop).unwrap()),
    ("ls_joint_destroy", &[Load], |s| s.world.destroy_joint(s.hook).unwrap()),
    ("ls_joint_destroy", &[Lamp], |s| s.world.destroy_joint(s.weld).unwrap()),
    ("ls_joint_kind_set", &[Load], |s| {
        let kind = relimited(s.world.joint_def(s.hook).unwrap().kind);
        s.world.set_joint_kind(s.hook, kind).unwrap();
    }),
    ("ls_joint_softness_set", &[Load], |s| s.world.set_joint_softness(s.hook, GIVE, GIVE, GIVE).unwrap()),
    ("ls_joint_softness_set", &[Lamp], |s| s.world.set_joint_softness(s.weld, GIVE, GIVE, GIVE).unwrap()),
    ("ls_joint_friction_set", &[Load], |s| s.world.set_joint_friction(s.hook, 1.0).unwrap()),
    ("ls_joint_restitution_set", &[Load], |s| s.world.set_joint_restitution(s.hook, 0.5).unwrap()),
    ("ls_joint_axis_friction_set", &[Load], |s| s.world.set_joint_axis_friction(s.hook, [1.0; 6]).unwrap()),
    ("ls_joint_frames_set", &[Load], |s| {
        s.world.set_joint_frames(s.hook, Pose::at_xyz(3.0, 5.1, 0.0), Pose::IDENTITY).unwrap();
    }),
    ("ls_joint_frames_set", &[Lamp], |s| {
        s.world.set_joint_frames(s.weld, Pose::at_xyz(0.0, 0.1, 0.0), Pose::at_xyz(0.0, 1.0, 0.0)).unwrap();
    }),
    ("ls_joint_solver_set", &[Load], |s| s.world.set_joint_solver(s.hook, Solver::GaussSeidel).unwrap()),
    ("ls_joint_long_range_set", &[Load], |s| s.world.set_joint_long_range(s.hook, false).unwrap()),
    ("ls_joint_long_range_set", &[Lamp], |s| s.world.set_joint_long_range(s.weld, false).unwrap()),
    ("ls_joint_break_set", &[Load], |s| s.world.set_joint_break(s.hook, 1.0, 1.0).unwrap()),
    ("ls_joint_strength_set", &[Load], |s| s.world.set_joint_strength(s.hook, strong(1.0)).unwrap()),
    ("ls_joint_strength_set", &[Lamp], |s| s.world.set_joint_strength(s.weld, strong(1.0)).unwrap()),
    ("ls_world_fractures_apply", &[Load], |s| s.world.apply_fractures(&[s.pin]).unwrap()),
    ("ls_world_fractures_apply", &[Lamp], |s| s.world.apply_fractures(&[s.weld]).unwrap()),
    ("ls_world_soft_bound_set", &[Load], |s| {
        s.world.set_soft_bound(s.hook, s.pin, Some(SoftBound { share: 0.5, softness: GIVE })).unwrap();
    }),
    ("ls_world_soft_bound_remove", &[Load], |s| s.world.set_soft_bound(s.hook, s.pin, None).unwrap()),
    ("ls_world_gravity_set", ALL, |s| s.world.set_gravity(Vec3::Y).unwrap()),
    ("ls_world_fracture_settings_set", ALL, |s| {
        s.world.set_fracture_settings(FractureSettings { by_load: false, ..FractureSettings::default() }).unwrap();
    }),
    ("ls_world_long_range_set", ALL, |s| {
        s.world.set_long_range(&LongRangeDef { enabled: false, ..LongRangeDef::default() }).unwrap();
    }),
    ("ls_world_sleep_settings_set", ALL, |s| {
        s.world.set_sleep_settings(SleepSettings { enabled: false, ..SleepSettings::default() }).unwrap();
    }),
    // What changes neither the motion nor the load of anything that rests.
    ("ls_body_fast_set", &[], |s| s.world.set_fast(s.link, true).unwrap()),
    ("ls_body_user_word_set", &[], |s| s.world.set_user_word(s.link, 7).unwrap()),
    ("ls_shape_user_word_set", &[], |s| s.world.set_shape_user_word(s.shape(s.link), 7).unwrap()),
    ("ls_joint_user_word_set", &[], |s| s.world.set_joint_user_word(s.hook, 7).unwrap()),
    ("ls_world_effort_set", &[], |s| s.world.set_effort(8, 4).unwrap()),
    ("ls_world_articulation_settings_set", &[], |s| {
        s.world.set_articulation_settings(ArticulationSettings { most_substeps: 2, ..ArticulationSettings::default() }).unwrap();
    }),
    ("ls_world_restitution_threshold_set", &[], |s| s.world.set_restitution_threshold(2.0).unwrap()),
    ("ls_world_hit_threshold_set", &[], |s| s.world.set_hit_threshold(2.0).unwrap()),
    ("ls_support_enabled_set", &[], |s| s.world.set_support(true)),
    ("ls_world_parallel_for_set", &[], |s| s.world.set_parallel_for(None)),
    ("ls_world_profiler_set", &[], |s| s.world.set_profiler(None)),
];

/// What is not about bodies, shapes or joints of a world.
const NOT_EDITS: [&str; 10] = [
    "ls_abort_level_set",
    "ls_allocator_set",
    "ls_log_callback_set",
    "ls_world_break_callback_set",
    "ls_world_callbacks_set",
    "ls_world_overload_callback_set",
    "ls_world_split_callback_set",
    "ls_world_create",
    "ls_world_destroy",
    // Makes bodies and joints as the calls above do.
    "ls_world_cells_create",
];

/// Makes a body that overlaps the crate.
fn create(scene: &mut Scene, kind: BodyKind) {
    let def = BodyDef { kind, pose: Pose::at_xyz(9.05, 0.1, 0.0), ..BodyDef::default() };
    scene.world.create_body(&def.with_shape(cube(0.1))).unwrap();
}

#[test]
fn every_edit_wakes_what_it_may_set_in_motion_and_nothing_else() {
    for (name, kind) in kinds().into_iter().skip(1) {
        for (number, &(edit, woken, change)) in ROWS.iter().enumerate() {
            let mut scene = Scene::new(kind);
            change(&mut scene);
            scene.world.step(DT).unwrap();
            assert_eq!(scene.awake(), woken, "{name}: {edit}, row {number}");
        }
    }
}

/// A function of the header that is missing here is an edit that nobody has thought about.
#[test]
fn the_table_of_edits_has_a_row_for_each_function_that_changes_something() {
    let header = include_str!("../include/longspan/longspan.h");
    let words = header.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| word.starts_with("ls_"));
    let ends = ["_set", "_create", "_destroy", "_attach", "_remove", "_move_to", "_wake", "_apply", "_add", "_add_at"];
    let changes = |word: &&str| ends.iter().any(|end| word.ends_with(end));
    let mut missing: Vec<&str> =
        words.filter(changes).filter(|word| !ROWS.iter().any(|row| row.0 == *word) && !NOT_EDITS.contains(word)).collect();
    missing.sort_unstable();
    missing.dedup();
    assert!(missing.is_empty(), "no row for {missing:?}");
    for (edit, ..) in ROWS {
        assert!(header.contains(&format!("{edit}(")), "{edit} is no function of the header");
    }
}

#[test]
fn an_edit_that_changes_nothing_wakes_nothing() {
    type NamedEdit = (&'static str, fn(&mut Scene));
    let edits: [NamedEdit; 8] = [
        ("kind of a joint", |s| {
            let kind = s.world.joint_def(s.hook).unwrap().kind;
            s.world.set_joint_kind(s.hook, kind).unwrap();
        }),
        ("softness", |s| s.world.set_joint_softness(s.hook, Softness::RIGID, Softness::RIGID, Softness::RIGID).unwrap()),
        ("friction", |s| s.world.set_joint_friction(s.hook, 0.0).unwrap()),
        ("strength", |s| s.world.set_joint_strength(s.hook, Strength::UNBREAKABLE).unwrap()),
        ("solver", |s| s.world.set_joint_solver(s.hook, Solver::Auto).unwrap()),
        ("velocity of what stands", |s| s.world.set_linear_velocity(s.hub, Vec3::ZERO).unwrap()),
        ("target where it is", |s| s.world.move_to(s.hub, s.world.pose(s.hub).unwrap()).unwrap()),
        ("gravity", |s| s.world.set_gravity(s.world.gravity()).unwrap()),
    ];
    for (name, edit) in edits {
        let mut scene = Scene::new(JointKind::HINGE);
        edit(&mut scene);
        scene.world.step(DT).unwrap();
        assert_eq!(scene.awake(), [], "{name}");
    }
}

fn step(world: &mut World, dt: f32) {
    world.step(dt).unwrap();
}

/// Steps until a body has fallen asleep (s).
fn sleep(world: &mut World, body: BodyId, dt: f32) -> f32 {
    for step in 0..(10.0 / dt) as u32 {
        if !world.is_awake(body).unwrap() {
            return step as f32 * dt;
        }
        world.step(dt).unwrap();
    }
    panic!("it does not fall asleep in 10 s");
}

/// A hub of this kind with a bob that has fallen asleep on it.
fn hub_and_bob(def: &WorldDef, hub: BodyKind, kind: JointKind, dt: f32) -> (World, [BodyId; 2], JointId) {
    let mut world = World::new(def).unwrap();
    let hub = BodyDef { kind: hub, pose: Pose::at_xyz(0.0, 5.0, 0.0), ..BodyDef::default() };
    let hub = world.create_body(&hub.with_shape(cube(0.1))).unwrap();
    let bob = BodyDef { pose: Pose::at_xyz(0.0, 4.0, 0.0), angular_damping: 1.0, linear_damping: 1.0, ..BodyDef::default() };
    let bob = world.create_body(&bob.with_shape(cube(0.2))).unwrap();
    let joint = world.create_joint(&hung(kind, hub, bob)).unwrap();
    if !matches!(kind, JointKind::Fixed) {
        sleep(&mut world, bob, dt);
    }
    (world, [hub, bob], joint)
}

/// Ways to take a hub 2 m along x, in 2 s or at once.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Velocity,
    Target,
    Teleport,
}

fn follows(solver: Solver, hub: BodyKind, (name, kind): (&str, JointKind), way: Way, rate: f32) {
    let dt = 1.0 / rate;
    let what = format!("{name} on a {hub:?} hub, {way:?}, {rate} Hz, {solver:?}");
    let (mut world, [hub, bob], joint) = hub_and_bob(&WorldDef { solver, ..WorldDef::default() }, hub, kind, dt);
    let from = world.pose(hub).unwrap();
    let at = |x: f64| Pose { position: from.position + DVec3::X * x, ..from };
    let steps = (2.0 * rate) as u32;
    if way == Way::Velocity {
        world.set_linear_velocity(hub, Vec3::X).unwrap();
    }
    if way == Way::Teleport {
        world.set_pose(hub, at(2.0)).unwrap();
    }
    for step in 1..=steps {
        if way == Way::Target {
            world.move_to(hub, at(2.0 * f64::from(step) / f64::from(steps))).unwrap();
        }
        world.step(dt).unwrap();
        assert!(way == Way::Teleport || world.is_awake(bob).unwrap(), "{what}: asleep in step {step}");
    }
    let gap = world.joint_state(joint).unwrap().gap;
    assert!(gap < 5.0e-3, "{what}: the joint is {gap} m open");
    assert!((world.pose(hub).unwrap().position.x - 2.0).abs() < 1.0e-3, "{what}");
    if way == Way::Velocity {
        world.set_linear_velocity(hub, Vec3::ZERO).unwrap();
    }
    // Sweeps leave what hangs on a link of a millimetre trembling.
    if solver == Solver::GaussSeidel {
        return;
    }
    // A pendulum of 1 m that loses its swing at 1/s sleeps once it hangs, whatever its host keeps saying.
    if !matches!(kind, JointKind::Fixed) {
        for _ in 0..(12.0 * rate) as u32 {
            match way {
                Way::Velocity => world.set_linear_velocity(hub, Vec3::ZERO).unwrap(),
                Way::Target => world.move_to(hub, at(2.0)).unwrap(),
                Way::Teleport => {}
            }
            world.step(dt).unwrap();
        }
        let velocities = [world.linear_velocity(bob).unwrap(), world.angular_velocity(bob).unwrap()];
        assert!(!world.is_awake(bob).unwrap(), "{what}: it does not sleep on a hub that stands, at {velocities:?}");
    }
    let bob = world.pose(bob).unwrap().position;
    let free_along_x = matches!(kind, JointKind::Prismatic { .. });
    let bound = if free_along_x { 0.11 } else { 5.0e-3 };
    assert!((bob.x - 2.0).abs() < bound && (bob.y - 4.0).abs() < 5.0e-3, "{what}: the bob ends at {bob}");
}

#[test]
fn what_hangs_on_a_hub_follows_it_and_sleeps_when_it_stands() {
    for kind in kinds() {
        for way in [Way::Velocity, Way::Target, Way::Teleport] {
            follows(Solver::Auto, BodyKind::Kinematic, kind, way, 60.0);
        }
        follows(Solver::Auto, BodyKind::Static, kind, Way::Teleport, 60.0);
        follows(Solver::GaussSeidel, BodyKind::Kinematic, kind, Way::Velocity, 60.0);
    }
    for rate in [30.0, 240.0] {
        follows(Solver::Auto, BodyKind::Kinematic, kinds()[2], Way::Target, rate);
        follows(Solver::Auto, BodyKind::Kinematic, kinds()[1], Way::Teleport, rate);
    }
}

/// A kinematic hub is let go while its bob sleeps: both fall freely, by ½ g t².
#[test]
fn a_hub_made_dynamic_beside_a_sleeper_falls_with_it() {
    for rate in [30.0, 60.0, 240.0] {
        for (name, kind) in kinds() {
            for from in [BodyKind::Static, BodyKind::Kinematic] {
                let dt = 1.0 / rate;
                let (mut world, [hub, bob], _) = hub_and_bob(&WorldDef::default(), from, kind, dt);
                world.set_damping(bob, 0.0, 0.0).unwrap();
                if !matches!(kind, JointKind::Fixed) {
                    world.put_to_sleep(bob).unwrap();
                }
                world.set_body_kind(hub, BodyKind::Dynamic).unwrap();
                (0..rate as u32).for_each(|_| step(&mut world, dt));
                let fallen = 5.0 - world.pose(hub).unwrap().position.y;
                // The rule of a substep of length h falls short or long by at most ½ g t h.
                let bound = 0.5 * 9.81 * f64::from(dt) / 4.0 + 1.0e-3;
                assert!(
                    (fallen - 4.905).abs() < bound,
                    "{name}, {from:?}, {rate} Hz: fell {fallen} m in 1 s, of 4.905 ± {bound}"
                );
            }
        }
    }
}

#[test]
fn a_strength_below_the_load_of_a_sleeping_joint_breaks_it_at_once() {
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for (name, kind) in kinds() {
            for hub in [BodyKind::Static, BodyKind::Kinematic] {
                let (mut world, _, joint) = hub_and_bob(&WorldDef { solver, ..WorldDef::default() }, hub, kind, DT);
                world.step(DT).unwrap();
                world.set_joint_strength(joint, strong(5.0)).unwrap();
                let broken = (0..3).map(|_| world.step(DT).unwrap().counts.joints_broken).sum::<u32>();
                assert_eq!((broken, world.joint_count()), (1, 0), "{name} on a {hub:?} hub, {solver:?}");
            }
        }
    }
}
